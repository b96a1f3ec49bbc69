/** QR codes (ISO/IEC 18004): bytes, error correction level L, versions 1 to 20. */

const QUIET = 4; // modules around a code
// of level L, by version
const CHECK = [7, 10, 15, 20, 26, 18, 20, 24, 30, 18, 20, 24, 26, 30, 22, 24, 28, 30, 28, 28]; // bytes per block
const BLOCKS = [1, 1, 1, 1, 1, 2, 2, 2, 2, 4, 4, 4, 4, 4, 6, 6, 6, 6, 7, 8];
/** Whether a mask inverts the module in column x and row y. @type {((x: number, y: number) => boolean)[]} */
const MASKS = [
  (x, y) => (x + y) % 2 === 0,
  (_, y) => y % 2 === 0,
  (x) => x % 3 === 0,
  (x, y) => (x + y) % 3 === 0,
  (x, y) => ((x / 3 | 0) + (y >> 1)) % 2 === 0,
  (x, y) => ((x * y) % 2) + ((x * y) % 3) === 0,
  (x, y) => (((x * y) % 2) + ((x * y) % 3)) % 2 === 0,
  (x, y) => (((x + y) % 2) + ((x * y) % 3)) % 2 === 0,
]; // prettier-ignore

/** @typedef {boolean[][]} Modules rows of dark (true) and light modules, without the quiet zone */

/**
 * The QR code of a text; null if it is longer than 858 bytes.
 *
 * @param {string} text
 * @param {number} [mask] by default the one with the fewest large areas of one colour
 * @returns {Modules | null}
 */
export function qrCode(text, mask) {
  const bytes = new TextEncoder().encode(text);
  const version = CHECK.findIndex((_, i) => bytes.length <= dataBytes(i + 1) - (i < 9 ? 2 : 3)) + 1;
  if (version === 0) return null;
  const bits = bitsOf(interleaved(padded(bytes, version), version));
  const masks = mask === undefined ? MASKS.keys() : [mask];
  const codes = [...masks].map((one) => drawn(version, bits, one));
  const penalties = codes.map(penalty);
  return codes[penalties.indexOf(Math.min(...penalties))];
}

/** A code as SVG; of a text that is too long, the empty text. @param {string} text */
export function svgCode(text) {
  const modules = qrCode(text);
  if (!modules) return "";
  const size = modules.length + 2 * QUIET;
  const dark = modules.flatMap((row, y) => row.flatMap((on, x) => (on ? `M${x + QUIET} ${y + QUIET}h1v1h-1z` : [])));
  return `<svg viewBox="0 0 ${size} ${size}"><path d="${dark.join("")}"/></svg>`;
}

/** Modules that hold data and check bits. @param {number} version */
function dataModules(version) {
  const positions = alignment(version).length;
  const around = positions ? 25 * (positions ** 2 - 3) + 2 * 5 * (2 - positions) : 0;
  const size = 17 + 4 * version;
  return size ** 2 - 3 * 64 - 31 - 2 * (size - 16) - around - (version < 7 ? 0 : 36);
}

/** @param {number} version */
const dataBytes = (version) => (dataModules(version) >> 3) - CHECK[version - 1] * BLOCKS[version - 1];

/** Coordinates of alignment patterns. @param {number} version @returns {number[]} */
function alignment(version) {
  if (version === 1) return [];
  const count = (version / 7 | 0) + 2; // prettier-ignore
  const step = 2 * Math.ceil((4 * version + 4) / (2 * count - 2));
  const last = 10 + 4 * version;
  return [6, ...Array.from({ length: count - 1 }, (_, i) => last - (count - 2 - i) * step)];
}

/** Mode, length, bytes, terminator and padding. @param {Uint8Array} bytes @param {number} version */
function padded(bytes, version) {
  const { length } = bytes;
  const head = version < 10 ? [4, length >> 4, length & 15] : [4, length >> 12, (length >> 8) & 15, (length >> 4) & 15, length & 15];
  const halves = [...head, ...[...bytes].flatMap((byte) => [byte >> 4, byte & 15]), 0];
  const full = Array.from({ length: halves.length >> 1 }, (_, i) => 16 * halves[2 * i] + halves[2 * i + 1]);
  for (let i = 0; full.length < dataBytes(version); i++) full.push(i % 2 ? 0x11 : 0xec);
  return full;
}

/** Blocks with check bytes, a byte of each in turn. @param {number[]} data @param {number} version */
function interleaved(data, version) {
  const count = BLOCKS[version - 1];
  const short = count - (data.length % count); // the other blocks are longer by one byte
  const size = Math.floor(data.length / count);
  const blocks = Array.from({ length: count }, (_, i) => {
    const start = i * size + Math.max(0, i - short);
    return data.slice(start, start + size + Number(i >= short));
  });
  const checks = blocks.map((block) => checkBytes(block, CHECK[version - 1]));
  const inTurn = (/** @type {number[][]} */ rows) =>
    Array.from({ length: Math.max(...rows.map((row) => row.length)) }, (_, i) => rows.map((row) => row[i]))
      .flat()
      .filter((byte) => byte !== undefined);
  return [...inTurn(blocks), ...inTurn(checks)];
}

/** Product in the field of 256 elements. @param {number} a @param {number} b */
function times(a, b) {
  let product = 0;
  for (let bit = 7; bit >= 0; bit--) product = (product << 1) ^ ((product >> 7) * 0x11d) ^ (((b >> bit) & 1) * a);
  return product;
}

/** Reed-Solomon remainder. @param {number[]} data @param {number} count @returns {number[]} */
function checkBytes(data, count) {
  let generator = [1]; // coefficients of the product of (x - 2^i), without the leading one at the end
  for (let i = 0, root = 1; i < count; i++, root = times(root, 2)) {
    generator = [...generator, 0].map((value, k) => value ^ (k ? times(generator[k - 1], root) : 0));
  }
  const rest = new Array(count).fill(0);
  for (const byte of data) {
    const factor = byte ^ rest.shift();
    rest.push(0);
    rest.forEach((value, k) => (rest[k] = value ^ times(generator[k + 1], factor)));
  }
  return rest;
}

/** @param {number[]} bytes */
const bitsOf = (bytes) => bytes.flatMap((byte) => [7, 6, 5, 4, 3, 2, 1, 0].map((bit) => Boolean((byte >> bit) & 1)));

/** A number followed by its remainder. @param {number} value @param {number} length @param {number} generator */
function withCheck(value, length, generator) {
  let rest = value;
  for (let i = 0; i < length; i++) rest = (rest << 1) ^ ((rest >> (length - 1)) * generator);
  return (value << length) | rest;
}

/** @param {number} version @param {boolean[]} bits @param {number} mask @returns {Modules} */
function drawn(version, bits, mask) {
  const size = 17 + 4 * version;
  /** @type {(boolean | undefined)[][]} */
  const modules = Array.from({ length: size }, () => new Array(size));
  const set = (/** @type {number} */ x, /** @type {number} */ y, /** @type {boolean} */ dark) => {
    if (modules[y] && x >= 0 && x < size) modules[y][x] = dark;
  };
  /** Squares around a point, as dark as `dark` says by distance. @param {number} cx @param {number} cy @param {number} reach @param {number[]} dark */
  const squares = (cx, cy, reach, dark) => {
    for (let y = -reach; y <= reach; y++) {
      for (let x = -reach; x <= reach; x++) {
        set(cx + x, cy + y, dark.includes(Math.max(Math.abs(x), Math.abs(y))));
      }
    }
  };
  for (let i = 0; i < size; i++) {
    set(6, i, i % 2 === 0);
    set(i, 6, i % 2 === 0);
  }
  for (const [x, y] of [[3, 3], [size - 4, 3], [3, size - 4]]) squares(x, y, 4, [0, 1, 3]);
  const places = alignment(version);
  const last = places.length - 1;
  for (const [i, x] of places.entries()) {
    for (const [k, y] of places.entries()) {
      const finder = (i === 0 && (k === 0 || k === last)) || (i === last && k === 0);
      if (!finder) squares(x, y, 2, [0, 2]);
    }
  }
  const format = withCheck(8 | mask, 10, 0x537) ^ 0x5412; // 8: level L
  for (let i = 0; i < 15; i++) {
    const dark = Boolean((format >> i) & 1);
    set(8, i < 6 ? i : i < 8 ? i + 1 : size - 15 + i, dark);
    set(i < 8 ? size - 1 - i : i === 8 ? 7 : 14 - i, 8, dark);
  }
  set(8, size - 8, true);
  const number = withCheck(version, 12, 0x1f25);
  for (let i = 0; version > 6 && i < 18; i++) {
    const dark = Boolean((number >> i) & 1);
    const [along, across] = [Math.floor(i / 3), size - 11 + (i % 3)];
    set(along, across, dark);
    set(across, along, dark);
  }
  let next = 0;
  for (let right = size - 1; right > 0; right -= 2) {
    if (right === 6) right = 5; // the column of the timing pattern
    for (let i = 0; i < size; i++) {
      const y = (right + 1) & 2 ? i : size - 1 - i;
      for (const x of [right, right - 1]) {
        if (modules[y][x] === undefined) modules[y][x] = (bits[next++] ?? false) !== MASKS[mask](x, y);
      }
    }
  }
  return /** @type {Modules} */ (modules);
}

/** How hard a code is to read: its runs of five or more modules and its squares of one colour. @param {Modules} modules */
function penalty(modules) {
  const size = modules.length;
  let sum = 0;
  for (let a = 0; a < size; a++) {
    let [across, down] = [0, 0];
    for (let b = 0; b < size; b++) {
      across = b && modules[a][b] === modules[a][b - 1] ? across + 1 : 1;
      down = b && modules[b][a] === modules[b - 1][a] ? down + 1 : 1;
      for (const run of [across, down]) sum += run === 5 ? 3 : Number(run > 5);
      const dark = modules[a][b];
      if (a && b && [modules[a - 1][b], modules[a][b - 1], modules[a - 1][b - 1]].every((one) => one === dark)) sum += 3;
    }
  }
  return sum;
}
