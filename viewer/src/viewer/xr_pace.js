/** Chooses how finely a headset's pictures are drawn, from the times of its frames. */

const LATE = 1.5; // periods after which a frame is late
const SPAN = 500; // milliseconds of a window
const FEWEST = 4; // frames of a window
const SLOW = 0.2; // share of late frames from which on less is drawn
const FAST = 0.02; // share below which a window is calm
const FAR = 3; // periods of the median frame at which two steps are taken at once
const CALM = [4, 64]; // calm windows before more is drawn: at first, and at most

/**
 * Shares of the headset's resolution per side, and factors of `levelSigma`: below 1, more Gaussians are added up in
 * targets of less than full size. These take a third of the fragments away and leave 52 dB, so they come first.
 */
const STEPS = [
  { scale: 1, coarseness: 1 },
  { scale: 1, coarseness: 0.6 },
  { scale: 0.85, coarseness: 0.6 },
  { scale: 0.7, coarseness: 0.6 },
  { scale: 0.6, coarseness: 0.6 },
  { scale: 0.5, coarseness: 0.6 },
  { scale: 0.4, coarseness: 0.6 },
];
const FIRST = 3; // a session that begins by stuttering makes visitors ill

/** Adapts scale and levels to the rate of a headset. */
export class FramePace {
  #rate;
  #step = FIRST;
  #steps = STEPS;
  /** @type {number[]} */
  #times = [];
  #calm = 0; // consecutive calm windows
  #patience = CALM[0];

  /** @param {number} rate frames per second of the headset @param {number | null} fixed scale, or null to choose it */
  constructor(rate, fixed) {
    this.#rate = rate;
    if (fixed !== null) [this.#steps, this.#step] = [[{ scale: fixed, coarseness: 1 }], 0];
  }

  /** Size and coarseness of the next frame. @returns {{scale: number, coarseness: number}} */
  get step() {
    return this.#steps[this.#step];
  }

  /** The headset has another rate. @param {number} rate */
  set rate(rate) {
    this.#rate = rate;
    this.forget();
  }

  /** Forget frames, after a pause. */
  forget() {
    this.#times = [];
    this.#calm = 0;
  }

  /** Record a frame. @param {number} milliseconds since the previous one */
  note(milliseconds) {
    const times = this.#times;
    times.push(milliseconds);
    if (times.length < FEWEST || times.reduce((sum, time) => sum + time) < SPAN) return;
    this.#times = [];
    const period = 1000 / this.#rate;
    const late = times.filter((time) => time > LATE * period).length / times.length;
    if (late > SLOW) {
      const median = times.sort((a, b) => a - b)[times.length >> 1];
      this.#step = Math.min(this.#step + (median > FAR * period ? 2 : 1), this.#steps.length - 1);
      this.#patience = Math.min(2 * this.#patience, CALM[1]);
      this.#calm = 0;
    } else if (late > FAST || this.#step === 0) this.#calm = 0;
    else if (++this.#calm >= this.#patience) {
      this.#step -= 1;
      this.#calm = 0;
    }
  }
}
