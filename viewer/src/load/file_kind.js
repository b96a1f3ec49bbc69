/** Recognises the formats of scenes by their first bytes. */

/** True if bytes begin as a PLY file does. @param {Uint8Array} bytes */
export function isPly(bytes) {
  return bytes[0] === 0x70 && bytes[1] === 0x6c && bytes[2] === 0x79;
}

/** True if bytes begin as an SPZ file does: with its name, or as gzip. @param {Uint8Array} bytes */
export function isSpz(bytes) {
  const named = bytes[0] === 0x4e && bytes[1] === 0x47 && bytes[2] === 0x53 && bytes[3] === 0x50;
  return named || (bytes[0] === 0x1f && bytes[1] === 0x8b);
}
