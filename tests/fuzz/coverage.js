/** The blocks of the viewer's code that an input reaches, as V8 counts them. */

import { Session } from "node:inspector/promises";

/** Code whose coverage counts. */
const OURS = /\/viewer\/src\//;

/** Tells whether an input reached code that none before it did. */
export class Coverage {
  /** Blocks that were reached. @type {Set<string>} */
  #reached = new Set();
  #session = new Session();

  /** Start to count: call it before the code is loaded. */
  async start() {
    this.#session.connect();
    await this.#session.post("Profiler.enable");
    await this.#session.post("Profiler.startPreciseCoverage", { callCount: true, detailed: true });
  }

  /** Number of blocks that were reached. */
  get blocks() {
    return this.#reached.size;
  }

  /** True if something new was reached since the last call; how often, in powers of two, counts as well. */
  async grew() {
    const { result } = await this.#session.post("Profiler.takePreciseCoverage");
    const before = this.#reached.size;
    for (const { url, functions } of result) {
      if (!OURS.test(url)) continue;
      for (const { ranges } of functions) {
        for (const { startOffset, endOffset, count } of ranges) {
          if (count > 0) this.#reached.add(`${url}:${startOffset}-${endOffset}:${Math.min(3, Math.log2(count) >> 1)}`);
        }
      }
    }
    return this.#reached.size > before;
  }
}
