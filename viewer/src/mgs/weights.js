/** Shapes of the networks' matrices, in the order of their streams. docs/reference/format.md, sections 7 and 8. */

import { STATICS } from "./statics.js";

/** @typedef {import("./header.js").Header} Header */
/** @typedef {import("./header.js").LobeShape} LobeShape */
/** @typedef {[name: string, rows: number, columns: number]} Shape of a matrix, row by row */
/** @typedef {Record<string, Float32Array>} Weights */

/** @type {Shape[]} */
const COLOR_NETWORKS = [
  ["context1", 64, 96],
  ["context2", 13, 64],
  ["static1", 64, 16],
  ["static2", 3, 64],
  ["view1", 64, 16],
  ["view2", 9, 64],
];

/** @type {Shape[]} */
const LATENT_NETWORKS = [["both1", 128, 6], ["static2", 3, 64], ["view2", 9, 64]];
/** The stream of the colour decoder. @type {Record<string, string>} */
export const COLOR_STREAMS = {
  linear: "color-matrices",
  networks: "appearance-decoder",
  latent_networks: "color-networks",
};

/**
 * The stream of the colour decoder and the shapes of its matrices.
 *
 * @param {Header} header
 * @returns {[string, Shape[]]}
 */
export function colorShapes({ colors, scalars }) {
  const latents = scalars.get("appearance")?.columns.length ?? 6;
  /** @type {Record<string, Shape[]>} */
  const shapes = {
    linear: [["static2", 3, 3], ["view2", 9, latents - 3]],
    networks: COLOR_NETWORKS,
    latent_networks: LATENT_NETWORKS,
  };
  return [COLOR_STREAMS[colors], shapes[colors]];
}

/** @type {Shape[]} */
export const NETWORK = [
  ["hidden1.weight", 256, 22],
  ["hidden1.bias", 1, 256],
  ["hidden2.weight", 128, 256],
  ["hidden2.bias", 1, 128],
  ["hidden3.weight", 64, 128],
  ["hidden3.bias", 1, 64],
  ["phi.weight", 1, 64],
  ["phi.bias", 1, 1],
  ["opacity.weight", 1, 64],
  ["opacity.bias", 1, 1],
];

/**
 * @param {LobeShape} shape
 * @returns {Shape[]}
 */
export function lobeShapes({ degree, latents, hidden }) {
  const outputs = 2 * (degree + 1) ** 2;
  const inputs = [STATICS + latents, ...hidden];
  /** @type {Shape[]} */
  const shapes = [["bias", 1, outputs], ["basis", latents, outputs]];
  if (hidden.length === 0) return shapes;
  [...hidden, outputs].forEach((rows, i) => shapes.push([`weights.${i}`, rows, inputs[i]]));
  hidden.forEach((rows, i) => shapes.push([`offsets.${i}`, 1, rows]));
  return shapes;
}

/** Count of numbers in all matrices. @param {Shape[]} shapes */
export function weightNumbers(shapes) {
  return shapes.reduce((sum, [, rows, columns]) => sum + rows * columns, 0);
}

/**
 * Split numbers into matrices by name.
 *
 * @param {Float32Array} numbers
 * @param {Shape[]} shapes
 * @returns {Weights}
 */
export function splitWeights(numbers, shapes) {
  let start = 0;
  return Object.fromEntries(
    shapes.map(([name, rows, columns]) => [
      name,
      numbers.subarray(start, (start += rows * columns)),
    ]),
  );
}
