/** What the passes of a frame take on the device, where WebGL2 tells. */

const PATIENCE = 100; // looks, some milliseconds apart, at whether the device has told

/** Times one frame after another, from when it is first asked on. */
export class Clock {
  /** Of the last frame that was timed, by pass; null where the device has no clock. @type {Record<string, number> | null} */
  milliseconds = null;

  #gl;
  #told;
  #wanted = false;
  #running = false;
  /** Of the frame that is timed. @type {[pass: string, WebGLQuery][]} */
  #queries = [];

  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.#gl = gl;
    this.#told = gl.getExtension("EXT_disjoint_timer_query_webgl2");
  }

  /** A frame begins that may be timed. */
  start() {
    this.#running = this.#wanted && !this.#queries.length;
  }

  /** A pass begins, and the one before ends; without a name, the frame does. @param {string} [pass] */
  pass(pass) {
    if (!this.#running) return;
    const [gl, what] = [this.#gl, this.#told.TIME_ELAPSED_EXT];
    if (this.#queries.length) gl.endQuery(what);
    if (pass) {
      const query = /** @type {WebGLQuery} */ (gl.createQuery());
      this.#queries.push([pass, query]);
      gl.beginQuery(what, query);
    } else this.#running = false;
  }

  /** Waits for what the device has to say of the last frame that was timed, into `milliseconds`. */
  async time() {
    const gl = this.#gl;
    this.#wanted = this.#told !== null;
    const last = this.#queries[this.#queries.length - 1];
    if (!last || this.#running) return;
    for (let i = 0; i < PATIENCE && !gl.getQueryParameter(last[1], gl.QUERY_RESULT_AVAILABLE); i++) {
      await new Promise((resolve) => setTimeout(resolve, 5));
    }
    const found = this.#queries.map(([pass, query]) => [pass, gl.getQueryParameter(query, gl.QUERY_RESULT) / 1e6]);
    // what the device did meanwhile for others may have got into it
    if (!gl.getParameter(this.#told.GPU_DISJOINT_EXT)) this.milliseconds = Object.fromEntries(found);
    for (const [, query] of this.#queries.splice(0)) gl.deleteQuery(query);
  }

  /** What was asked of a context that was lost since is never told. */
  forget() {
    this.#queries = [];
    this.#running = false;
  }
}
