/** Makes small `.mgs` files for tests, as simple as the format allows. */

import { crc32 } from "../../viewer/src/mgs/crc32.js";
import { laneCount } from "../../viewer/src/mgs/rans.js";
import { randomNumbers } from "./pieces.js";

/**
 * A file around any header and streams, with valid checksums.
 *
 * @param {object} fields
 * @param {[string, string, Uint8Array][]} streams name, codec, content
 * @param {number} [major] version
 */
export function seal(fields, streams, major = 2) {
  const table = streams.map(([name, codec, data]) => {
    return { name, codec, bytes: data.length, crc32: crc32(data) };
  });
  let text = JSON.stringify({ ...fields, streams: table });
  text = text.padEnd(text.length + ((8 - ((20 + text.length) % 8)) % 8));
  const prefix = new DataView(new ArrayBuffer(12));
  prefix.setUint16(0, major, true);
  prefix.setUint32(4, text.length, true);
  const header = new TextEncoder().encode(text);
  prefix.setUint32(8, crc32(header, crc32(new Uint8Array(prefix.buffer, 0, 8))), true);
  const magic = [0x4d, 0x47, 0x53, 0x1a, 0x0d, 0x0a, 0x00, 0x01];
  const padding = (data) => new Uint8Array((8 - (data.length % 8)) % 8);
  const parts = streams.flatMap(([, , data]) => [data, padding(data)]);
  return joined([magic, new Uint8Array(prefix.buffer), header, ...parts]);
}

/** @param {ArrayLike<number>[]} parts */
export function joined(parts) {
  const bytes = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let start = 0;
  for (const part of parts) {
    bytes.set(part, start);
    start += part.length;
  }
  return bytes;
}

/**
 * Bits, lowest first, of numbers below 2^53.
 *
 * @param {[number, number][]} numbers value and width
 */
export function bits(numbers) {
  const all = numbers.flatMap(([value, width]) =>
    Array.from({ length: width }, (_, i) => Math.floor(value / 2 ** i) % 2),
  );
  const bytes = new Uint8Array(Math.ceil(all.length / 8));
  all.forEach((bit, i) => (bytes[i >> 3] |= bit << (i & 7)));
  return bytes;
}

/**
 * A rANS stream of one lane in which nothing but one symbol occurs.
 *
 * @param {number} alphabet
 * @param {number} symbol
 */
export function constantRans(alphabet, symbol) {
  const occurs = Array.from({ length: alphabet }, (_, i) => [Number(i === symbol), 1]);
  return rans(alphabet, 1, bits([[1, 1], ...occurs, [0, 4]]), [65536], []);
}

/**
 * @param {number} alphabet
 * @param {number} contexts
 * @param {Uint8Array} tables
 * @param {number[]} states
 * @param {number[]} words
 */
export function rans(alphabet, contexts, tables, states, words) {
  const head = new Uint8Array(Uint16Array.of(alphabet, contexts).buffer);
  const lengths = new Uint8Array(Uint32Array.of(tables.length, words.length).buffer);
  const rest = [Uint32Array.from(states), Uint16Array.from(words)];
  return joined([head, lengths, tables, ...rest.map((row) => new Uint8Array(row.buffer))]);
}

/**
 * Positions in a row: a lane's first code is far from the one before, the others are next to it.
 *
 * Classes follow from the classes before them, so they take no words.
 *
 * @param {number} count
 */
function positions(count) {
  const far = 41;
  const follows = new Map([[0, far], [far, 1], [1, 1]]);
  const tables = Array.from({ length: 49 }, (_, context) => {
    const next = follows.get(context);
    if (next === undefined) return [[0, 1]];
    return [[1, 1], ...Array.from({ length: 49 }, (_, i) => [Number(i === next), 1]), [0, 4]];
  });
  const lanes = laneCount(count);
  const coded = rans(49, 49, bits(tables.flat()), new Array(lanes).fill(65536), []);
  // bits 30 to 32 keep all axes away from the halves that are not numbers
  const low = Array.from({ length: lanes }, (_, i) => [i === 0 ? 7 * 2 ** 30 : 0, far - 1]);
  return joined([new Uint8Array(Uint32Array.of(coded.length).buffer), coded, bits(low)]);
}

/** A scene with lobes that has one of everything, and its streams in the order of the file. @param {number} [count] */
export function smallScene(count = 40) {
  const random = randomNumbers(5);
  const halves = (length) => {
    const numbers = Array.from({ length }, () => 0x3000 + Math.floor(random() * 0x800));
    const signs = numbers.map((bits) => bits | (random() < 0.5 ? 0x8000 : 0));
    return new Uint8Array(Uint16Array.from(signs).buffer);
  };
  const lobes = { degree: 1, latents: 4, hidden: [6] };
  const codebooks = {
    scale: { count: 3, length: 1, size: 8 },
    rotation: { count: 2, length: 2, size: 8 },
    appearance: { count: 3, length: 2, size: 8 },
    opacity: { count: 1, length: 1, size: 8 },
    lobes: { count: 2, length: 2, size: 8 },
  };
  const indices = () => bits(Array.from({ length: count }, () => [Math.floor(random() * 8), 3]));
  const columns = Object.entries(codebooks).flatMap(([name, book]) =>
    Array.from({ length: book.count }, (_, i) => [`${name}.${i}`, "bits", indices()]),
  );
  const fields = {
    mode: "nvq",
    blend: "sortfree",
    sh_degree: 1,
    count,
    positions: { center: [1, 2, 3], radius: 2, exponent: 11 },
    codebooks,
    lobes,
    network: false,
    weighting: { name: "mobile_gs", exponent_max: 4, sigma: 10, background_weight: 0 },
    background: [0, 0.5, 1],
    near: 0.2,
    views: [],
    meta: {},
  };
  /** @type {[string, string, Uint8Array][]} */
  const streams = [
    ["lobe-decoder", "raw", halves(8 + 4 * 8 + 6 * 23 + 8 * 6 + 6)],
    ["appearance-decoder", "raw", halves(9792)],
    ["codebooks", "raw", halves(8 * (3 + 4 + 6 + 1 + 4))],
    ["positions", "morton-class", positions(count)],
    ...columns,
  ];
  return { fields, streams };
}

/**
 * A scene in layers, and each of them as a scene of its own with the same networks and codebooks.
 *
 * @param {number[]} layers Gaussians of each
 */
export function layeredScene(layers) {
  const scenes = layers.map((count) => smallScene(count));
  const [{ fields, streams }] = scenes;
  const shared = streams.slice(0, 3);
  const alone = scenes.map((scene) => ({ fields: scene.fields, streams: [...shared, ...scene.streams.slice(3)] }));
  const own = alone.map(({ streams }, i) =>
    streams.slice(3).map(([name, ...rest]) => [i ? `${name}@${i}` : name, ...rest]),
  );
  const count = layers.reduce((sum, size) => sum + size, 0);
  return { fields: { ...fields, count, layers }, shared, own, alone };
}
