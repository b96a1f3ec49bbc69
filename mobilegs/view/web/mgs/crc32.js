/** CRC-32 as zip and PNG have it. */

const TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; bit++) value = (value & 1 ? 0xedb88320 : 0) ^ (value >>> 1);
  return value;
});

/**
 * The checksum of `data`, or of all that led to `before` followed by `data`.
 *
 * @param {Uint8Array} data
 * @param {number} [before]
 */
export function crc32(data, before = 0) {
  let value = ~before;
  for (let i = 0; i < data.length; i++) {
    value = TABLE[(value ^ data[i]) & 255] ^ (value >>> 8);
  }
  return ~value >>> 0;
}
