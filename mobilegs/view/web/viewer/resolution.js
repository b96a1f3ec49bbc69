/** How many pixels to draw: as many as the device can in time. */

const DENSITY_MAX = 2; // device pixels a CSS pixel; more is not seen on a phone, and is paid for
const SLOW = 1000 / 26; // milliseconds a frame; screens that save power show 30 a second
const FAST = 1000 / 50;
const FRAMES = 12; // looked at before the scale changes
const STEPS = [1, 0.85, 0.7, 0.6, 0.5];

/** Picks a scale from the times of frames that follow one another. */
export class Resolution {
  #step = 0;
  /** @type {number[]} */
  #times = [];
  #steps;

  /** @param {number | null} fixed scale to keep, or null to choose it */
  constructor(fixed) {
    this.fixed = fixed;
    this.#steps = fixed === null ? STEPS : [fixed];
  }

  /** Share of the screen's own pixels, by side. */
  get scale() {
    return this.#steps[this.#step];
  }

  /**
   * The size to draw at: what stands still has time to be sharp.
   *
   * @param {number} width CSS pixels
   * @param {number} height
   * @param {number} density device pixels a CSS pixel
   * @param {boolean} moving
   */
  size(width, height, density, moving) {
    const factor = Math.min(density, DENSITY_MAX) * (moving ? this.scale : this.#steps[0]);
    const side = (/** @type {number} */ length) => Math.max(1, Math.round(length * factor));
    return { width: side(width), height: side(height) };
  }

  /**
   * Takes note of a frame.
   *
   * @param {number} milliseconds since the frame before, while something moves all the time
   */
  note(milliseconds) {
    this.#times.push(milliseconds);
    if (this.#times.length < FRAMES) return;
    const median = this.#times.sort((a, b) => a - b)[FRAMES / 2];
    this.#times = [];
    if (median > SLOW) this.#step = Math.min(this.#step + 1, this.#steps.length - 1);
    else if (median < FAST && this.#step > 0) this.#step -= 1;
  }

  /** Forgets the times: frames no longer follow one another. */
  pause() {
    this.#times = [];
  }
}
