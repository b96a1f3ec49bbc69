/** The lines of the panel with the frame rate. */

/**
 * @typedef {object} Stats of a frame
 * @property {string} renderer
 * @property {number} count Gaussians
 * @property {number} compared Gaussians of the other scene, or 0
 * @property {boolean} early true if a poster shows more: the visitor has not moved, and most of the scene is missing
 * @property {number} width pixels rendered
 * @property {number} height
 * @property {number} milliseconds since the previous frame; 0 while nothing moves
 * @property {Record<string, number> | null} passes milliseconds by pass, where the device has a timer
 * @property {number[] | null} fragments per pixel by level, while each pass is timed
 */

const KEPT = 30; // frame times whose mean is shown

/** Frame times, and what else is known of the frames. */
export class FrameStats {
  /** Recent frame times, milliseconds. @type {number[]} */
  #times = [];

  /** Take a frame. @param {Stats} stats @returns {string} lines that describe it */
  lines(stats) {
    if (stats.milliseconds) this.#times = [...this.#times.slice(1 - KEPT), stats.milliseconds];
    const mean = this.#times.reduce((sum, time) => sum + time, 0) / this.#times.length;
    const counts = [stats.count, stats.compared].filter((count, side) => side === 0 || count);
    return [
      `${stats.renderer}, ${stats.width} x ${stats.height}`,
      `${counts.map((count) => count.toLocaleString("en")).join(" | ")} Gaussians`,
      this.#times.length ? `${(1000 / mean).toFixed(0)} frames/s, ${mean.toFixed(1)} ms` : "still",
      ...(stats.fragments ? fragmentLines(stats.fragments) : []),
      ...Object.entries(stats.passes ?? {}).map(([pass, time]) => `${pass} ${time.toFixed(2)} ms`),
    ].join("\n");
  }
}

/** @param {number[]} levels fragments per pixel by level */
function fragmentLines(levels) {
  const told = (/** @type {number} */ value) => value.toFixed(1);
  const sum = levels.reduce((all, value) => all + value);
  const lines = [`${told(sum)} fragments per pixel`];
  return levels.length > 1 ? [...lines, `${levels.map(told).join(" + ")} by level`] : lines;
}
