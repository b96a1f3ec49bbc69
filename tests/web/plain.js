/**
 * A small plain scene by formula, as `.ply` and `.spz`.
 *
 * `node plain.js FILE` writes the .ply from which `splat-transform FILE spz_v4.spz` (version 3.7.0,
 * with --spz-version 3 for spz_v3.spz) made the .spz files in this folder, so that another program's files are
 * tested.
 */

import { writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";
import { joined } from "./write.js";

export const COUNT = 60;
const FRACTION = 12;
const SIZES = [0, 3, 8, 15, 24]; // coefficients of a colour by degree, without the constant

/** Numbers of each Gaussian as 3DGS has them; harmonics are r, g, b inside. @param {number} degree */
export function example(degree = 3) {
  const wave = (i, k) => Math.sin(1 + 7.3 * i + 2.1 * k * k);
  return Array.from({ length: COUNT }, (_, i) => {
    const quat = [0, 1, 2, 3].map((k) => wave(i, 10 + k));
    const length = Math.hypot(...quat);
    return {
      mean: [0, 1, 2].map((k) => 3 * wave(i, k)),
      logScale: [0, 1, 2].map((k) => -2 + 2.5 * wave(i, 4 + k)),
      quat: quat.map((part) => part / length),
      logit: 4 * wave(i, 20),
      color: [0, 1, 2].map((c) => 1.5 * wave(i, 30 + c)),
      harmonics: Array.from({ length: 3 * SIZES[degree] }, (_, k) => 0.4 * wave(i, 40 + k)),
    };
  });
}

/** @param {ReturnType<typeof example>} rows */
export function plyOf(rows) {
  const size = rows[0].harmonics.length / 3;
  const names = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2"];
  for (let k = 0; k < 3 * size; k++) names.push(`f_rest_${k}`);
  names.push("opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3");
  const lines = ["ply", "format binary_little_endian 1.0", `element vertex ${rows.length}`];
  const head = [...lines, ...names.map((name) => `property float ${name}`), "end_header\n"].join("\n");
  const numbers = rows.flatMap(({ mean, color, harmonics, logit, logScale, quat }) => {
    const rest = harmonics.map((_, k) => harmonics[3 * (k % size) + Math.floor(k / size)]);
    return [...mean, ...color, ...rest, logit, ...logScale, ...quat];
  });
  return joined([new TextEncoder().encode(head), new Uint8Array(Float32Array.from(numbers).buffer)]);
}

/**
 * The bytes of each attribute: positions, opacities, colours, scales, rotations, harmonics.
 *
 * @param {ReturnType<typeof example>} rows
 * @param {number} version
 */
export function attributesOf(rows, version) {
  const byte = (value) => Math.min(255, Math.max(0, Math.round(value)));
  const inRub = ([x, y, z]) => [x, -y, -z];
  const positions = rows.flatMap(({ mean }) =>
    inRub(mean).flatMap((value) => {
      if (version === 1) return halfOf(value);
      const fixed = Math.round(value * 2 ** FRACTION);
      return [fixed & 255, (fixed >> 8) & 255, (fixed >> 16) & 255];
    }),
  );
  const opacities = rows.map(({ logit }) => byte(255 / (1 + Math.exp(-logit))));
  const colors = rows.flatMap(({ color }) => color.map((c) => byte(255 * (0.15 * c + 0.5))));
  const scales = rows.flatMap(({ logScale }) => logScale.map((s) => byte(16 * (s + 10))));
  const rotations = rows.flatMap(({ quat: [w, x, y, z] }) => {
    const parts = [...inRub([x, y, z]), w];
    if (version < 3) return parts.slice(0, 3).map((part) => byte(127.5 * (1 + Math.sign(w) * part)));
    const largest = parts.reduce((best, part, k) => (Math.abs(part) > Math.abs(parts[best]) ? k : best), 0);
    let word = largest;
    for (let k = 0; k < 4; k++) {
      if (k === largest) continue;
      const part = Math.sign(parts[largest]) * parts[k];
      word = (word << 10) | ((part < 0 ? 1 : 0) << 9) | Math.round(511 * Math.SQRT2 * Math.abs(part));
    }
    return [word & 255, (word >>> 8) & 255, (word >>> 16) & 255, word >>> 24];
  });
  // each harmonic is even or odd under the turn by half a circle around x
  const signs = Array.from({ length: 24 }, (_, k) => parity(k));
  const harmonics = rows.flatMap((row) =>
    row.harmonics.map((value, k) => byte(128 + 128 * signs[Math.floor(k / 3)] * value)),
  );
  return [positions, opacities, colors, scales, rotations, harmonics].map((part) => Uint8Array.from(part));
}

/**
 * The sign that harmonic `k` (0: the first of degree 1) takes when y and z change theirs: that of
 * P_l^m(-z) is (-1)^(l + m), and those with the sine of an angle around z are odd in it.
 *
 * @param {number} k
 */
function parity(k) {
  const degree = Math.floor(Math.sqrt(k + 1));
  const order = k + 1 - degree * (degree + 1);
  return ((degree + order) % 2 ? -1 : 1) * (order < 0 ? -1 : 1);
}

/** @param {number} value */
function halfOf(value) {
  if (value === 0) return [0, 0];
  const exponent = Math.max(-14, Math.floor(Math.log2(Math.abs(value))));
  const digits = Math.round(Math.abs(value) * 2 ** (10 - exponent));
  const bits = (value < 0 ? 0x8000 : 0) | ((exponent + 14) << 10) + digits;
  return [bits & 255, bits >> 8];
}

/** @param {number} version @param {number} count @param {number} degree @param {number} [flags] @param {number} [last] */
export function headOf(version, count, degree, flags = 0, last = 0) {
  const head = new DataView(new ArrayBuffer(16));
  head.setUint32(0, 0x5053474e, true);
  head.setUint32(4, version, true);
  head.setUint32(8, count, true);
  [degree, FRACTION, flags, last].forEach((value, k) => head.setUint8(12 + k, value));
  return new Uint8Array(head.buffer);
}

/** A file of version 1, 2 or 3. @param {ReturnType<typeof example>} rows @param {number} version @param {number} degree */
export function gzippedSpz(rows, version, degree) {
  const parts = attributesOf(rows, version);
  return new Uint8Array(gzipSync(joined([headOf(version, rows.length, degree), ...parts])));
}

/** A file of version 4. @param {number} count @param {number} degree @param {Uint8Array[]} streams @param {number[]} sizes */
export function streamedSpz(count, degree, streams, sizes) {
  const table = new DataView(new ArrayBuffer(16 + 16 * streams.length));
  table.setUint32(0, 32, true);
  streams.forEach((stream, i) => {
    table.setBigUint64(16 + 16 * i, BigInt(stream.length), true);
    table.setBigUint64(24 + 16 * i, BigInt(sizes[i]), true);
  });
  return joined([headOf(4, count, degree, 0, streams.length), new Uint8Array(table.buffer), ...streams]);
}

if (process.argv[1]?.endsWith("plain.js")) writeFileSync(process.argv[2], plyOf(example()));
