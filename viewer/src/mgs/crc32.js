/** CRC-32 of zip and PNG. */

/** Tables of slicing-by-8: a byte followed by 0 to 7 zero bytes. */
const TABLES = new Int32Array(8 * 256);
for (let i = 0; i < TABLES.length; i++) {
  let value = i < 256 ? i : TABLES[i - 256];
  for (let bit = 0; bit < 8; bit++) value = (value & 1 ? 0xedb88320 : 0) ^ (value >>> 1);
  TABLES[i] = value;
}

/**
 * The checksum of `data`, or of the bytes with the checksum `before` followed by `data`.
 *
 * @param {Uint8Array} data
 * @param {number} [before]
 */
export function crc32(data, before = 0) {
  let value = ~before;
  let i = 0;
  for (; i + 8 <= data.length; i += 8) {
    value ^= data[i] | (data[i + 1] << 8) | (data[i + 2] << 16) | (data[i + 3] << 24);
    value =
      TABLES[1792 + (value & 255)] ^
      TABLES[1536 + ((value >>> 8) & 255)] ^
      TABLES[1280 + ((value >>> 16) & 255)] ^
      TABLES[1024 + (value >>> 24)] ^
      TABLES[768 + data[i + 4]] ^
      TABLES[512 + data[i + 5]] ^
      TABLES[256 + data[i + 6]] ^
      TABLES[data[i + 7]];
  }
  for (; i < data.length; i++) value = TABLES[(value ^ data[i]) & 255] ^ (value >>> 8);
  return ~value >>> 0;
}
