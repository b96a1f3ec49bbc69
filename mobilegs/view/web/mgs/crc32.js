/** CRC-32 as zip and PNG have it. */

/** What a byte does to the checksum, then with one, two and three zero bytes behind it. */
const TABLES = new Int32Array(4 * 256);
for (let i = 0; i < TABLES.length; i++) {
  let value = i < 256 ? i : TABLES[i - 256];
  for (let bit = 0; bit < 8; bit++) value = (value & 1 ? 0xedb88320 : 0) ^ (value >>> 1);
  TABLES[i] = value;
}

/**
 * The checksum of `data`, or of all that led to `before` followed by `data`.
 *
 * @param {Uint8Array} data
 * @param {number} [before]
 */
export function crc32(data, before = 0) {
  let value = ~before;
  let i = 0;
  for (; i + 4 <= data.length; i += 4) {
    value ^= data[i] | (data[i + 1] << 8) | (data[i + 2] << 16) | (data[i + 3] << 24);
    value =
      TABLES[768 + (value & 255)] ^
      TABLES[512 + ((value >>> 8) & 255)] ^
      TABLES[256 + ((value >>> 16) & 255)] ^
      TABLES[value >>> 24];
  }
  for (; i < data.length; i++) value = TABLES[(value ^ data[i]) & 255] ^ (value >>> 8);
  return ~value >>> 0;
}
