/** How many pixels to draw: as many as the device can in time. */

const DENSITY_MAX = 2; // device pixels a CSS pixel; more is not seen on a phone, and is paid for
const GOAL = 1000 / 60; // milliseconds a frame
const FAST = 1000 / 50;
const SLOW = 1000 / 45;
const SLOWEST = 1000 / 26; // screens that save power show 30 a second, however little is drawn
const LEAST = 3; // frames looked at before the scale changes
const SPAN = 200; // milliseconds that they take at least
const HELPS = 0.9; // share of a frame's time that may be left if fewer pixels are worth it
const CALM = [4, 64]; // spans that must have been fast before more is drawn, at first and at most
const STEPS = [1, 0.85, 0.7, 0.6, 0.5];

/** Picks a scale from the times of frames that follow one another. */
export class Resolution {
  #step = 0;
  /** @type {number[]} */
  #times = [];
  #steps;
  #slow = SLOW;
  /** Before less was drawn: the step, and what a frame took. */
  #before = { step: 0, median: Infinity };
  #fast = 0; // spans, one after the other
  #calm = CALM[0];

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
    const { length } = this.#times;
    if (length < LEAST || this.#times.reduce((sum, time) => sum + time) < SPAN) return;
    const median = this.#times.sort((a, b) => a - b)[length >> 1];
    this.#times = [];
    if (median > this.#slow) this.#less(median);
    else if (median >= FAST || this.#step === 0) this.#fast = 0;
    else if (++this.#fast >= this.#calm) {
      this.#step -= 1;
      this.#fast = 0;
    }
  }

  /** Draws less, unless that did not help before. @param {number} median milliseconds of a frame */
  #less(median) {
    const { step, median: before } = this.#before;
    this.#fast = 0;
    this.#calm = Math.min(2 * this.#calm, CALM[1]);
    if (step < this.#step && median < SLOWEST && median > HELPS * before) {
      this.#step = step; // it is the screen that shows no more
      this.#slow = SLOWEST;
      return;
    }
    this.#before = { step: this.#step, median };
    const wanted = this.scale * Math.sqrt(GOAL / median);
    const next = this.#steps.findIndex((scale) => scale < this.scale && scale <= wanted);
    this.#step = next < 0 ? this.#steps.length - 1 : next;
  }
}
