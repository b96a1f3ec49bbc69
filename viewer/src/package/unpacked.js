/** Texts that the package contains compressed: it stays small, and bundlers need no settings to find files. */

/** Digits of base 85, those of Z85: they need no escapes in JavaScript. */
const DIGITS = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-:+=^!/*?&<>()[]{}@%$#";

/**
 * The digits of some bytes: five for four of them. build_package.mjs packs with it.
 *
 * @param {Uint8Array} bytes
 */
export function toDigits(bytes) {
  const padded = new Uint8Array(4 * Math.ceil(bytes.length / 4));
  padded.set(bytes);
  const numbers = new DataView(padded.buffer);
  let text = String(padded.length - bytes.length);
  for (let at = 0; at < padded.length; at += 4) {
    for (let power = 85 ** 4; power >= 1; power /= 85) text += DIGITS[Math.floor(numbers.getUint32(at) / power) % 85];
  }
  return text;
}

/** The bytes of some digits. @param {string} text */
export function fromDigits(text) {
  const numbers = new DataView(new ArrayBuffer((4 * (text.length - 1)) / 5));
  for (let at = 0; at < numbers.byteLength; at += 4) {
    let number = 0;
    for (let k = 1; k <= 5; k++) number = 85 * number + DIGITS.indexOf(text[(5 * at) / 4 + k]);
    numbers.setUint32(at, number);
  }
  return new Uint8Array(numbers.buffer, 0, numbers.byteLength - Number(text[0]));
}

/** @param {string} packed digits of gzip @returns {Promise<string>} */
export function unpacked(packed) {
  return new Response(new Blob([fromDigits(packed)]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
}
