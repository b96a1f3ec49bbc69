/** Half-precision numbers as bits. */

/** What a last digit is worth, by exponent. */
const DIGIT = Float64Array.from({ length: 31 }, (_, exponent) => 2 ** (Math.max(exponent, 1) - 25));

const FLOAT = new Float32Array(1);
const BITS = new Uint32Array(FLOAT.buffer);

/** Whether the bits of a half are those of infinity or NaN. @param {number} bits */
export function notFinite(bits) {
  return (bits & 0x7c00) === 0x7c00;
}

/** The value of a finite half's bits, exactly. @param {number} bits */
export function fromHalf(bits) {
  const exponent = (bits >> 10) & 31;
  const digits = (bits & 1023) + (exponent > 0 ? 1024 : 0);
  return (bits & 0x8000 ? -digits : digits) * DIGIT[exponent];
}

/** The bits of the half next to a number, ties to even; what is too large becomes the largest. @param {number} value */
export function toHalf(value) {
  FLOAT[0] = value;
  const sign = (BITS[0] >>> 16) & 0x8000;
  const bits = BITS[0] & 0x7fffffff;
  if (bits < 0x38800000) {
    // in the last digit of small halves
    const size = Math.abs(value) * 2 ** 24;
    const rounded = Math.round(size);
    return sign | (rounded - size === 0.5 && rounded % 2 ? rounded - 1 : rounded);
  }
  // half of the last digit that stays, less one where that is even; exponents differ by 112
  return sign | Math.min((bits + 0xfff + ((bits >>> 13) & 1) - 0x38000000) >>> 13, 0x7bff);
}
