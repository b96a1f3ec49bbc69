/** The quads of an instance, which one draws together. */

export const BATCH = 128; // as in view.glsl and view.wgsl

const QUAD = [0, 1, 2, 2, 1, 3];

/** Indices of the corners of a batch: two triangles each. */
export const CORNERS = Uint16Array.from({ length: 6 * BATCH }, (_, i) => 4 * Math.floor(i / 6) + QUAD[i % 6]);
