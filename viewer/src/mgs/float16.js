/** 16-bit floats: conversion, and the streams that hold them. docs/reference/format.md, section 4. */

import { view } from "./bits.js";
import { SceneError } from "./error.js";
import { decodeRans } from "./rans.js";

/** @typedef {import("./container.js").Stream} Stream */

/** Value of the last bit, by exponent. */
const DIGIT = Float64Array.from({ length: 31 }, (_, exponent) => 2 ** (Math.max(exponent, 1) - 25));

const FLOAT = new Float32Array(1);
const BITS = new Uint32Array(FLOAT.buffer);

/** True if the bits are infinity or NaN. @param {number} bits */
export function isNotFinite(bits) {
  return (bits & 0x7c00) === 0x7c00;
}

/** The value of finite bits, exactly. @param {number} bits */
export function fromFloat16(bits) {
  const exponent = (bits >> 10) & 31;
  const digits = (bits & 1023) + (exponent > 0 ? 1024 : 0);
  return (bits & 0x8000 ? -digits : digits) * DIGIT[exponent];
}

/** The bits of the nearest float16, ties to even; larger numbers become the largest one. @param {number} value */
export function toFloat16(value) {
  FLOAT[0] = value;
  const sign = (BITS[0] >>> 16) & 0x8000;
  const bits = BITS[0] & 0x7fffffff;
  if (bits < 0x38800000) {
    // subnormal: a multiple of 2^-24
    const size = Math.abs(value) * 2 ** 24;
    const rounded = Math.round(size);
    return sign | (rounded - size === 0.5 && rounded % 2 ? rounded - 1 : rounded);
  }
  // round to nearest even; the exponent biases differ by 112
  return sign | Math.min((bits + 0xfff + ((bits >>> 13) & 1) - 0x38000000) >>> 13, 0x7bff);
}

/**
 * Decode the `count` numbers of a stream of float16; all must be finite.
 *
 * @param {Stream} stream
 * @param {number} count
 * @returns {Float32Array}
 */
export function decodeFloat16(stream, count) {
  const bits = decodeBits(stream, count);
  if (bits.some(isNotFinite)) {
    throw new SceneError(
      `the stream '${stream.name}' of the .mgs file has numbers that are not finite`,
    );
  }
  return Float32Array.from(bits, fromFloat16);
}

/**
 * @param {Stream} stream
 * @param {number} count
 */
function decodeBits({ name, codec, data }, count) {
  const wrong = new SceneError(`the stream '${name}' of the .mgs file has a wrong length`);
  if (codec === "raw") {
    if (data.length !== 2 * count) throw wrong;
    return Uint16Array.from({ length: count }, (_, i) => data[2 * i] | (data[2 * i + 1] << 8));
  }
  if (data.length < 4) throw wrong;
  const start = 4 + view(data).getUint32(0, true);
  if (start > data.length || (codec === "halves" && data.length !== start + count)) throw wrong;
  const upper = decodeRans(data.subarray(4, start), count, 256);
  const rest = data.subarray(start);
  const lower = codec === "planes" ? decodeRans(rest, count, 256) : rest;
  return upper.map((byte, i) => (byte << 8) | lower[i]);
}
