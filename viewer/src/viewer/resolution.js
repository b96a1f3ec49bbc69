/** Chooses the rendered resolution from frame times. */

const DENSITY_MAX = 2; // device pixels per CSS pixel; more is not visible on a phone
const GOAL = 1000 / 60; // milliseconds per frame
const FAST = 1000 / 50;
const SLOW = 1000 / 45;
const SLOWEST = 1000 / 26; // screens in power-saving mode show 30 frames/s at any load
const LEAST = 3; // fewest frames before the scale changes
const SPAN = 200; // fewest milliseconds before the scale changes
const HELPS = 0.9; // frame time that fewer pixels must fall below, relative to before
const CALM = [4, 64]; // fast spans before the scale grows: at first, and at most
const STEPS = [1, 0.85, 0.7, 0.6, 0.5];

/** Selects a scale from the times of consecutive frames. */
export class Resolution {
  #step = 0;
  /** @type {number[]} */
  #times = [];
  #steps;
  #slow = SLOW;
  /** Scale step and frame time before the last reduction. */
  #before = { step: 0, median: Infinity };
  #fast = 0; // consecutive fast spans
  #calm = CALM[0];

  /** @param {number | null} fixed fixed scale, or null to select it */
  constructor(fixed) {
    this.fixed = fixed;
    this.#steps = fixed === null ? STEPS : [fixed];
  }

  /** Share of the screen's resolution, per side. */
  get scale() {
    return this.#steps[this.#step];
  }

  /** True if fewer pixels are rendered than the screen has. @param {boolean} moving */
  reduced(moving) {
    return (moving ? this.scale : this.#steps[0]) < 1;
  }

  /**
   * The size to render: full resolution when nothing moves.
   *
   * @param {number} width CSS pixels
   * @param {number} height
   * @param {number} density device pixels per CSS pixel
   * @param {boolean} moving
   */
  size(width, height, density, moving) {
    const factor = Math.min(density, DENSITY_MAX) * (moving ? this.scale : this.#steps[0]);
    const side = (/** @type {number} */ length) => Math.max(1, Math.round(length * factor));
    return { width: side(width), height: side(height) };
  }

  /**
   * Record a frame.
   *
   * @param {number} milliseconds since the previous frame, during a movement
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

  /** Reduce the scale, unless the last reduction did not help. @param {number} median milliseconds of a frame */
  #less(median) {
    const { step, median: before } = this.#before;
    this.#fast = 0;
    this.#calm = Math.min(2 * this.#calm, CALM[1]);
    if (step < this.#step && median < SLOWEST && median > HELPS * before) {
      this.#step = step; // the screen limits the frame rate
      this.#slow = SLOWEST;
      return;
    }
    this.#before = { step: this.#step, median };
    const wanted = this.scale * Math.sqrt(GOAL / median);
    const next = this.#steps.findIndex((scale) => scale < this.scale && scale <= wanted);
    this.#step = next < 0 ? this.#steps.length - 1 : next;
  }
}
