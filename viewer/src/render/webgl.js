/**
 * The renderer for browsers without WebGPU: WebGL2, and the same picture.
 *
 * A frame has three passes, as `native.py` has them: project (a pixel a Gaussian, into textures),
 * splats (blended quads, in any order for a sort-free scene), resolve.
 */

import { strides } from "./types.js";
import { FLOAT16_SCALE, viewUniforms } from "./view_uniforms.js";
import { FrameTimer } from "./webgl_timer.js";
import { WebGlDots } from "./webgl_dots.js";
import { BATCH, TARGETS, blendsFloats, makeFixed, makePrograms } from "./webgl_program.js";
import { ROW, extent } from "./webgl_textures.js";

/** @typedef {import("./dots.js").Dots} Dots */
/** @typedef {import("./types.js").Camera} Camera */
/** @typedef {import("./types.js").Numbers} Numbers */
/** @typedef {import("./types.js").Part} Part */
/** @typedef {import("./types.js").SceneData} SceneData */
/** @typedef {import("./types.js").Variant} Variant */
/** @typedef {import("./webgl_textures.js").Input} Input */

const NOTHING = new Float32Array(0);
/** @type {Record<Part, Input>} */
const PACKED = {
  shapes: ["RGBA32UI", "RGBA_INTEGER", 4],
  colors: ["RGBA32UI", "RGBA_INTEGER", 4],
  lobes: ["R32UI", "RED_INTEGER", 1],
};
/** @type {Record<Part, Input>} */
const FLOATS = {
  shapes: ["RGBA32F", "RGBA", 4],
  colors: ["RGB32F", "RGB", 3],
  lobes: ["RG32F", "RG", 2],
};
/** Halves move a picture of 66 dB by 0.1. @type {Record<Part, Input>} */
const HALVES = { ...FLOATS, colors: ["RGB16F", "RGB", 3], lobes: ["RG16F", "RG", 2] };
/** @type {Input} */
const ORDER = ["R32UI", "RED_INTEGER", 1];

/** Draws a scene with WebGL2, which even browsers have that reach this page over plain http. */
export class WebGlRenderer {
  /** The shaders that `create` is given, by file. */
  static files = ["view", "wide", "packed", "whole", "project", "splat", "resolve", "dots"].map(
    (name) => `${name}.glsl`,
  );

  /** How it draws; may be changed between frames. @type {Variant} */
  variant;
  /** Why nothing is drawn any more, or null. @type {string | null} */
  lost = null;
  /** Called with a sentence when the context is lost. @type {(sentence: string) => void} */
  onLost = () => {};
  /** Called when the context is back, but without a scene. @type {() => void} */
  onRestored = () => {};

  #gl;
  #shaders;
  #fixed;
  /** @type {SceneData | null} */
  #scene = null;
  #inputs = PACKED; // of the scene
  /** @type {WebGlDots | null} */
  #dots = null;
  #sums = ""; // what the textures of the sums are for
  #timer;

  #onLost = (/** @type {Event} */ event) => {
    event.preventDefault(); // or the context would never come back
    this.#scene = this.#dots = null;
    this.lost = "the browser took the GPU away from this page: reload it if no picture returns";
    this.onLost(this.lost);
  };

  #onRestored = () => {
    this.#scene = null; // one that was set in between has not arrived
    this.#fixed = makeFixed(this.#gl);
    this.#sums = "";
    this.#timer.forget();
    this.lost = null;
    this.onRestored();
  };

  /**
   * A renderer that draws into `canvas`, halves in batches unless `variant` says otherwise.
   *
   * Throws an Error with one sentence if the browser or its GPU cannot.
   *
   * @param {HTMLCanvasElement | OffscreenCanvas} canvas
   * @param {Record<string, string>} shaders texts of `files`, by the name before the dot
   * @param {Partial<Variant>} [variant]
   */
  static create(canvas, shaders, { floats = false, strips = false } = {}) {
    const gl = /** @type {WebGL2RenderingContext | null} */ (
      canvas.getContext("webgl2", {
        alpha: false,
        antialias: false,
        depth: false,
        powerPreference: "high-performance",
      })
    );
    if (gl === null) throw new Error("this browser cannot draw with WebGL2 here");
    if (!TARGETS.some((name) => gl.getExtension(name))) {
      throw new Error("this GPU cannot draw into textures of floats");
    }
    if (floats && !blendsFloats(gl)) {
      throw new Error("this GPU cannot blend 32-bit floats: draw with halves");
    }
    if (gl.getParameter(gl.MAX_TEXTURE_SIZE) < ROW) {
      throw new Error(`this GPU's textures are less than ${ROW} pixels wide`);
    }
    return new WebGlRenderer(gl, shaders, { floats, strips });
  }

  /**
   * Use `create`, which asks first what the GPU can do.
   *
   * @param {WebGL2RenderingContext} gl
   * @param {Record<string, string>} shaders
   * @param {Variant} variant
   */
  constructor(gl, shaders, variant) {
    this.#gl = gl;
    this.#shaders = shaders;
    this.variant = variant;
    this.#fixed = makeFixed(gl);
    this.#timer = new FrameTimer(gl);
    gl.canvas.addEventListener("webglcontextlost", this.#onLost);
    gl.canvas.addEventListener("webglcontextrestored", this.#onRestored);
  }

  /**
   * Takes on a scene in the place of the one before, or after a `webglcontextrestored` event.
   *
   * @param {SceneData} scene
   */
  setScene(scene) {
    const gl = this.#gl;
    this.#scene = null;
    this.#inputs = scene.packing ? PACKED : this.variant.floats ? FLOATS : HALVES;
    const { shapes, colors, lobes } = scene;
    for (const [name, data] of Object.entries({ shapes, colors, lobes })) {
      this.#fixed.textures.upload(name, this.#inputs[/** @type {Part} */ (name)], data);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#fixed.looks);
    const formats = scene.packing ? [gl.RG32UI, 0] : [gl.RGBA32F, gl.R32F];
    ["looks", "opacities"].forEach((name, i) => {
      const texture = formats[i] ? this.#fixed.textures.make(name, formats[i], extent(scene.count)) : null;
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
    });
    this.#check("textures of 32-bit numbers");
    // the numbers are the GPU's now: a page on a phone cannot keep them as well
    this.#scene = { ...scene, shapes: NOTHING, colors: NOTHING, lobes: NOTHING };
    if (!scene.sorted) return;
    this.#fixed.textures.upload("order", ORDER, Uint32Array.from({ length: scene.count }, (_, i) => i));
  }

  /** Draws so many Gaussians of the scene that there is room for, the first ones. @param {number} count */
  show(count) {
    if (this.#scene) this.#scene.count = count;
  }

  /**
   * Writes new numbers over those of some Gaussians, for a scene that is still arriving.
   *
   * @param {Part} part
   * @param {number} from first Gaussian whose numbers changed
   * @param {Numbers} numbers all of theirs, of that part
   */
  update(part, from, numbers) {
    if (this.#scene === null) return;
    const input = this.#inputs[part];
    this.#fixed.textures.write(part, input, (strides(this.#scene)[part] / input[2]) * from, numbers);
  }

  /** Dots that `drawDots` draws, or none any more; the scene stays. @param {Dots | null} dots */
  setDots(dots) {
    if (this.lost !== null) return;
    this.#dots ??= new WebGlDots(this.#gl, this.#shaders.dots);
    this.#dots.take(dots);
  }

  /** Draws them into the canvas, which takes the camera's size. @param {Camera} camera */
  drawDots(camera) {
    if (!this.#dots) return;
    this.#fit(camera);
    this.#dots.draw(camera);
  }

  /**
   * The order of a sorted scene's Gaussians, far ones first; their own until it is known.
   *
   * @param {Uint32Array<ArrayBuffer>} order
   */
  setOrder(order) {
    if (this.#scene === null) return;
    if (order.length !== this.#scene.count) {
      throw new Error(`an order of ${order.length} Gaussians does not suit this scene`);
    }
    this.#fixed.textures.write("order", ORDER, 0, order);
  }

  /**
   * Draws into the canvas, which takes the camera's size. Without a scene nothing happens.
   *
   * @param {Camera} camera
   */
  draw(camera) {
    if (this.#scene === null) return;
    this.#fit(camera);
    this.#timer.start();
    this.#sum(this.#scene, camera);
    this.#resolve(this.#scene, null, camera.height - 1);
    this.#timer.pass();
  }

  /** Draws where nobody sees it, and waits until that is done. @param {Camera} camera */
  async drawUnseen(camera) {
    const gl = this.#gl;
    if (this.#scene) this.#sum(this.#scene, camera);
    gl.readBuffer(gl.COLOR_ATTACHMENT0);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.FLOAT, new Float32Array(4));
    if (gl.isContextLost()) throw new Error("the graphics device was lost");
  }

  /** Milliseconds of the last timed frame by pass; null where the device has no clock. */
  get milliseconds() {
    return this.#timer.milliseconds;
  }

  /** Asks what each pass of a frame took, into `milliseconds`: of one that was drawn since it was first asked. */
  async time() {
    if (this.lost === null) await this.#timer.time();
  }

  /** Waits until everything that was asked for is drawn. */
  async finished() {
    this.#gl.bindFramebuffer(this.#gl.FRAMEBUFFER, null);
    // the only wait that every browser keeps
    this.#gl.readPixels(0, 0, 1, 1, this.#gl.RGBA, this.#gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  /** The ways there are to draw. @returns {Variant[]} */
  get variants() {
    return (blendsFloats(this.#gl) ? [false, true] : [false]).flatMap((floats) => [
      { floats, strips: false },
      { floats, strips: true },
    ]);
  }

  /** The device in words, as far as the browser tells. */
  describe() {
    const gl = this.#gl;
    const told = gl.getExtension("WEBGL_debug_renderer_info");
    return String(gl.getParameter(told ? told.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  }

  /**
   * The same picture as RGBA floats, `[height][width][4]`, the top row first.
   *
   * @param {Camera} camera
   * @returns {Promise<Float32Array>}
   */
  async pixels(camera) {
    if (this.#scene === null) throw new Error("there is no scene to draw");
    const gl = this.#gl;
    const { width, height } = camera;
    this.#sum(this.#scene, camera);
    const [target, picture] = [gl.createFramebuffer(), gl.createRenderbuffer()];
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.bindRenderbuffer(gl.RENDERBUFFER, picture);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGBA32F, width, height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, picture);
    this.#resolve(this.#scene, target, 0);
    const pixels = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, pixels);
    gl.deleteFramebuffer(target);
    gl.deleteRenderbuffer(picture);
    return pixels;
  }

  /** Gives back what the GPU holds. The renderer cannot be used any more. */
  destroy() {
    const gl = this.#gl;
    const { view, corners, quads, looks, sums, programs, textures } = this.#fixed;
    this.#scene = null;
    this.#dots?.destroy();
    gl.canvas.removeEventListener("webglcontextlost", this.#onLost);
    gl.canvas.removeEventListener("webglcontextrestored", this.#onRestored);
    textures.destroy();
    for (const passes of programs.values()) {
      for (const program of Object.values(passes)) gl.deleteProgram(program);
    }
    for (const framebuffer of [looks, sums]) gl.deleteFramebuffer(framebuffer);
    gl.deleteVertexArray(quads);
    for (const buffer of [view, corners]) gl.deleteBuffer(buffer);
    // or it would count among those that a page may have, of which the oldest is taken away
    gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  /** @param {Camera} camera */
  #fit({ width, height }) {
    const { canvas } = this.#gl;
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
  }

  /**
   * The first two passes.
   *
   * @param {SceneData} scene
   * @param {Camera} camera
   */
  #sum(scene, camera) {
    const gl = this.#gl;
    const { view, quads, looks, sums } = this.#fixed;
    const programs = this.#programs(scene);
    this.#resize(scene.sorted, camera);
    gl.bindBuffer(gl.UNIFORM_BUFFER, view);
    const packed = viewUniforms(scene, camera, this.variant.floats ? 1 : FLOAT16_SCALE);
    gl.bufferSubData(gl.UNIFORM_BUFFER, 0, packed);
    gl.bindVertexArray(quads);
    gl.disable(gl.BLEND);
    gl.bindFramebuffer(gl.FRAMEBUFFER, looks);
    gl.drawBuffers([gl.COLOR_ATTACHMENT0, scene.packing ? gl.NONE : gl.COLOR_ATTACHMENT1]);
    const [width, height] = extent(scene.count);
    gl.viewport(0, 0, width, height);
    gl.useProgram(programs.project);
    this.#timer.pass("project");
    gl.drawArrays(gl.TRIANGLES, 0, 3);

    gl.bindFramebuffer(gl.FRAMEBUFFER, sums);
    gl.viewport(0, 0, camera.width, camera.height);
    gl.enable(gl.BLEND);
    gl.useProgram(programs.splat);
    this.#timer.pass("splat");
    if (scene.sorted) {
      gl.drawBuffers([gl.COLOR_ATTACHMENT0]);
      gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    } else {
      gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
      gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 1]); // nothing is covered yet
      gl.clearBufferfv(gl.COLOR, 1, [0, 0, 0, 0]);
      gl.blendFuncSeparate(gl.ONE, gl.ONE, gl.ZERO, gl.ONE_MINUS_SRC_ALPHA);
    }
    if (this.variant.strips) {
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, scene.count);
    } else {
      const batches = Math.ceil(scene.count / BATCH);
      gl.drawElementsInstanced(gl.TRIANGLES, 6 * BATCH, gl.UNSIGNED_SHORT, 0, batches);
    }
  }

  /**
   * The last pass.
   *
   * @param {SceneData} scene
   * @param {WebGLFramebuffer | null} target
   * @param {number} lastRow of the target if its rows count from below, or 0
   */
  #resolve(scene, target, lastRow) {
    const gl = this.#gl;
    const { resolve } = this.#programs(scene);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.disable(gl.BLEND);
    gl.useProgram(resolve);
    this.#timer.pass("resolve");
    gl.uniform1i(gl.getUniformLocation(resolve, "last_row"), lastRow);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /**
   * Textures for the sums of a picture, kept while its size stays.
   *
   * @param {boolean} sorted
   * @param {Camera} camera
   */
  #resize(sorted, { width, height }) {
    const { floats } = this.variant;
    const key = `${width} ${height} ${sorted} ${floats}`;
    if (key === this.#sums) return;
    const gl = this.#gl;
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (!(width > 0 && width <= most && height > 0 && height <= most)) {
      throw new Error(
        `a picture of ${width}x${height} pixels cannot be drawn: each side must lie between 1 ` +
          `and ${most}`,
      );
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#fixed.sums);
    const formats = floats ? [gl.RGBA32F, gl.R32F] : [gl.RGBA16F, gl.R16F];
    ["color_sums", "weight_sums"].forEach((name, i) => {
      const texture = sorted && i > 0 ? null : this.#fixed.textures.make(name, formats[i], [width, height]);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
    });
    this.#check(`pictures of ${width}x${height} floats`);
    this.#sums = key;
  }

  /** @param {SceneData} scene */
  #programs({ sorted, packing }) {
    const { programs } = this.#fixed;
    const kind = { sorted, packed: packing !== null, strips: this.variant.strips };
    const key = Object.values(kind).join(" ");
    const passes = programs.get(key) ?? makePrograms(this.#gl, this.#shaders, kind);
    programs.set(key, passes);
    return passes;
  }

  /** Throws if the GPU cannot draw into the bound framebuffer. @param {string} what */
  #check(what) {
    const gl = this.#gl;
    const status = gl.checkFramebufferStatus(gl.FRAMEBUFFER);
    if (status !== gl.FRAMEBUFFER_COMPLETE && !gl.isContextLost()) {
      throw new Error(`this GPU cannot draw into ${what}`);
    }
  }
}
