/** Times the passes of a frame on the device, where WebGL2 has timer queries. */

const POLLS_MAX = 100; // polls, some milliseconds apart, for a result

/** Times single frames, from the first call of `time` on. */
export class FrameTimer {
  /** Milliseconds by pass of the last timed frame; null without timer queries. @type {Record<string, number> | null} */
  milliseconds = null;

  #gl;
  #extension;
  #requested = false;
  #running = false;
  /** Queries of the frame that is timed. @type {[pass: string, WebGLQuery][]} */
  #queries = [];

  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.#gl = gl;
    this.#extension = gl.getExtension("EXT_disjoint_timer_query_webgl2");
  }

  /** Start a frame. */
  start() {
    this.#running = this.#requested && !this.#queries.length;
  }

  /** End the previous pass and start another one; without a name, end the frame. @param {string} [pass] */
  pass(pass) {
    if (!this.#running) return;
    const [gl, what] = [this.#gl, this.#extension.TIME_ELAPSED_EXT];
    if (this.#queries.length) gl.endQuery(what);
    if (pass) {
      const query = /** @type {WebGLQuery} */ (gl.createQuery());
      this.#queries.push([pass, query]);
      gl.beginQuery(what, query);
    } else this.#running = false;
  }

  /** Wait for the result of the last timed frame and store it in `milliseconds`. */
  async time() {
    const gl = this.#gl;
    this.#requested = this.#extension !== null;
    const last = this.#queries[this.#queries.length - 1];
    if (!last || this.#running) return;
    for (let i = 0; i < POLLS_MAX && !gl.getQueryParameter(last[1], gl.QUERY_RESULT_AVAILABLE); i++) {
      await new Promise((resolve) => setTimeout(resolve, 5));
    }
    const found = this.#queries.map(([pass, query]) => [pass, gl.getQueryParameter(query, gl.QUERY_RESULT) / 1e6]);
    // a disjoint result may include other work
    if (!gl.getParameter(this.#extension.GPU_DISJOINT_EXT)) this.milliseconds = Object.fromEntries(found);
    for (const [, query] of this.#queries.splice(0)) gl.deleteQuery(query);
  }

  /** Drop queries after the context was lost: they never get a result. */
  forget() {
    this.#queries = [];
    this.#running = false;
  }
}
