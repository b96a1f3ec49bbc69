/**
 * The WebGL2 renderer, for browsers without WebGPU. It renders the same image.
 *
 * A frame has three passes, as in WebGPU: project (one pixel per Gaussian, into textures), splat (blended
 * quads, in any order for a sort-free scene; with the depth pass, if there is one), resolve.
 */

import { LEVELS, PASS_LEVEL, levelPlaces, levelSizes } from "./levels.js";
import { BATCH } from "./quads.js";
import { hasDepthPass, strides, variantsOf } from "./types.js";
import { float16Scale, magnified, viewUniforms } from "./view_uniforms.js";
import { FrameTimer } from "./webgl_timer.js";
import { WebGlDots } from "./webgl_dots.js";
import { TARGETS, blendsFloats, makeCounter, makeFixed, makePrograms } from "./webgl_program.js";
import { PACKED, ROW, extent } from "./webgl_textures.js";

/** @typedef {import("./dots.js").Dots} Dots */
/** @typedef {import("./types.js").Camera} Camera */
/** @typedef {import("./types.js").Numbers} Numbers */
/** @typedef {import("./types.js").Part} Part */
/** @typedef {import("./types.js").SceneData} SceneData */
/** @typedef {import("./types.js").Variant} Variant */
/** @typedef {import("./webgl_textures.js").Input} Input */
/**
 * A part of a framebuffer that gets an image of the camera's size.
 *
 * @typedef {object} Target
 * @property {WebGLFramebuffer | null} framebuffer whose rows count from below
 * @property {number} x its first column
 * @property {number} y its lowest row
 */

const NOTHING = new Float32Array(0);
/** @type {Target} */
const CANVAS = { framebuffer: null, x: 0, y: 0 };
/** @type {Record<Part, Input>} */
const FLOATS = {
  shapes: ["RGBA32F", "RGBA", 4],
  colors: ["RGB32F", "RGB", 3],
  lobes: ["RG32F", "RG", 2],
};
/** Float16 inputs change an image of 66 dB by 0.1 dB. @type {Record<Part, Input>} */
const HALVES = { ...FLOATS, colors: ["RGB16F", "RGB", 3], lobes: ["RG16F", "RG", 2] };
/** @type {Input} */
const ORDER = ["R32UI", "RED_INTEGER", 1];

/** Renders with WebGL2, which also works on pages served over plain http. */
export class WebGlRenderer {
  /** The current variant; may be changed between frames. @type {Variant} */
  variant;
  /** Smallest standard deviation of a Gaussian at a level, in its pixels, at least 0.6; 0: all at full size. */
  levelSigma = 0;
  /** Pixels rendered and averaged along a side of each pixel of the canvas: `supersampling` of mobilegs. */
  supersampling = 1;
  /** A sphere, outside of which nothing is drawn: centre and radius, world units. @type {number[] | null} */
  crop = null;
  /** Why the renderer cannot continue, or null. @type {string | null} */
  lost = null;
  /** Called with a message when the context is lost. @type {(sentence: string) => void} */
  onLost = () => {};
  /** Called when the context is restored, without a scene. @type {() => void} */
  onRestored = () => {};

  #gl;
  #shaders;
  #fixed;
  /** @type {SceneData | null} */
  #scene = null;
  #inputs = PACKED; // of the scene
  /** @type {WebGlDots | null} */
  #dots = null;
  /** Of the last frame. @type {{leveled: boolean, pixels: number} | null} */
  #last = null;
  #sums = ""; // size and format of the textures of the sums
  #timer;

  #onLost = (/** @type {Event} */ event) => {
    event.preventDefault(); // otherwise the context is never restored
    this.#scene = this.#dots = null;
    this.lost = "the browser took the GPU away from this page: reload it if no picture returns";
    this.onLost(this.lost);
  };

  #onRestored = () => {
    this.#scene = null; // a scene set meanwhile was not uploaded
    this.#fixed = makeFixed(this.#gl);
    this.#sums = "";
    this.#timer.forget();
    this.lost = null;
    this.onRestored();
  };

  /**
   * Create a renderer for `canvas`; the default variant is float16 in batches.
   *
   * Throws an Error with a message for visitors if the browser or its GPU cannot render.
   *
   * @param {HTMLCanvasElement | OffscreenCanvas} canvas
   * @param {Record<string, string>} shaders texts by name
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
      throw new Error("this GPU cannot blend 32-bit floats: use the variant halves");
    }
    if (gl.getParameter(gl.MAX_TEXTURE_SIZE) < ROW) {
      throw new Error(`this GPU's textures are less than ${ROW} pixels wide`);
    }
    return new WebGlRenderer(gl, shaders, { floats, strips });
  }

  /**
   * Use `create`, which checks the GPU first.
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
   * Replace the scene, or set it again after a `webglcontextrestored` event. Throws an Error for a scene
   * with a view network.
   *
   * @param {SceneData} scene
   */
  setScene(scene) {
    const gl = this.#gl;
    this.#scene = this.#last = null;
    if (scene.network) {
      throw new Error(
        "this scene needs a network for every Gaussian in every frame, which takes WebGPU: open it in a " +
          "browser that has it",
      );
    }
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
    // the GPU has a copy now: drop the page's own, since phones have little memory
    this.#scene = { ...scene, shapes: NOTHING, colors: NOTHING, lobes: NOTHING };
    if (!scene.sorted) return;
    this.#fixed.textures.upload("order", ORDER, Uint32Array.from({ length: scene.count }, (_, i) => i));
  }

  /** Render only the first Gaussians of the scene. @param {number} count */
  show(count) {
    if (this.#scene) this.#scene.count = count;
  }

  /**
   * Replace the numbers of some Gaussians, while a scene is loading.
   *
   * @param {Part} part
   * @param {number} from first of the Gaussians
   * @param {Numbers} numbers that part of all these Gaussians
   */
  update(part, from, numbers) {
    if (this.#scene === null) return;
    const input = this.#inputs[part];
    this.#fixed.textures.write(part, input, (strides(this.#scene)[part] / input[2]) * from, numbers);
  }

  /** Set the dots that `drawDots` renders; the scene stays. @param {Dots | null} dots */
  setDots(dots) {
    if (this.lost !== null) return;
    this.#dots ??= new WebGlDots(this.#gl, this.#shaders.dots);
    this.#dots.take(dots);
  }

  /** Render the dots, as `draw`. @param {Camera} camera @param {Target | null} [target] */
  drawDots(camera, target = null) {
    if (!this.#dots) return;
    if (!target) this.#fit(camera);
    this.#dots.draw(camera, target ?? CANVAS);
  }

  /**
   * Set the order of a sorted scene, the farthest Gaussian first.
   *
   * @param {Uint32Array<ArrayBuffer>} order
   */
  setOrder(order) {
    if (this.#scene === null) return;
    if (order.length !== this.#scene.count) {
      throw new Error(`an order of ${order.length} Gaussians does not fit this scene`);
    }
    this.#fixed.textures.write("order", ORDER, 0, order);
  }

  /**
   * Render into the canvas, which gets the camera's size, or into a target. Does nothing without a scene.
   *
   * @param {Camera} camera
   * @param {Target | null} [target] null: the canvas
   */
  draw(camera, target = null) {
    if (this.#scene === null) return;
    if (!target) this.#fit(camera);
    const { framebuffer, x, y } = target ?? CANVAS;
    this.#timer.start();
    this.#sum(this.#scene, camera);
    this.#resolve(this.#scene, camera, framebuffer, x, y, y + camera.height - 1);
    this.#timer.pass();
  }

  /** Render off screen and wait until it is done. @param {Camera} camera */
  async drawUnseen(camera) {
    const gl = this.#gl;
    if (this.#scene) this.#sum(this.#scene, camera);
    gl.readBuffer(gl.COLOR_ATTACHMENT0);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.FLOAT, new Float32Array(4));
    if (gl.isContextLost()) throw new Error("the graphics device was lost");
  }

  /** Milliseconds by pass of the last timed frame; null where the device has no timer. */
  get milliseconds() {
    return this.#timer.milliseconds;
  }

  /** Request the pass times of a frame, stored in `milliseconds`; frames are timed from the first call on. */
  async time() {
    if (this.lost === null) await this.#timer.time();
  }

  /** Wait until all submitted work is rendered. */
  async finished() {
    this.#gl.bindFramebuffer(this.#gl.FRAMEBUFFER, null);
    // reading a pixel is the only wait that works in every browser
    this.#gl.readPixels(0, 0, 1, 1, this.#gl.RGBA, this.#gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  /**
   * Fragments per pixel of the last frame, by level, as mobilegs/evaluate/fragments.py counts them; null
   * before the first frame.
   *
   * @returns {Promise<number[] | null>}
   */
  async fragments() {
    if (this.#scene === null || this.#last === null) return null;
    const gl = this.#gl;
    const { leveled, pixels } = this.#last;
    const [width, height] = extent(this.#scene.count);
    const [target, areas] = [gl.createFramebuffer(), gl.createRenderbuffer()];
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.bindRenderbuffer(gl.RENDERBUFFER, areas);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGBA16F, width, height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, areas);
    gl.disable(gl.BLEND);
    gl.viewport(0, 0, width, height);
    gl.useProgram(this.#counter(this.#scene, leveled));
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const rows = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, rows);
    gl.deleteFramebuffer(target);
    gl.deleteRenderbuffer(areas);
    const found = new Array(leveled ? LEVELS : 1).fill(0);
    for (let i = 0; i < rows.length; i += 4) found[rows[i + 1]] += rows[i] ** 2 / pixels;
    return found;
  }

  /** The variants that this device supports. @returns {Variant[]} */
  get variants() {
    return variantsOf(blendsFloats(this.#gl));
  }

  /** The context that this renderer uses alone. */
  get context() {
    return this.#gl;
  }

  /** The name of the device, as far as the browser reveals it. */
  describe() {
    const gl = this.#gl;
    const told = gl.getExtension("WEBGL_debug_renderer_info");
    return String(gl.getParameter(told ? told.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  }

  /**
   * Render to RGBA floats, `[height][width][4]`, top row first.
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
    this.#resolve(this.#scene, camera, target, 0, 0, 0);
    const pixels = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, pixels);
    gl.deleteFramebuffer(target);
    gl.deleteRenderbuffer(picture);
    return pixels;
  }

  /** Free all resources; the renderer cannot be used afterwards. */
  destroy() {
    const gl = this.#gl;
    const { view, corners, quads, looks, depths, sums, enlarged, programs, counters, textures } = this.#fixed;
    this.#scene = null;
    this.#dots?.destroy();
    gl.canvas.removeEventListener("webglcontextlost", this.#onLost);
    gl.canvas.removeEventListener("webglcontextrestored", this.#onRestored);
    textures.destroy();
    for (const passes of programs.values()) {
      for (const program of Object.values(passes).flat()) gl.deleteProgram(program);
    }
    for (const program of counters.values()) gl.deleteProgram(program);
    for (const framebuffer of [looks, depths, sums, ...enlarged]) gl.deleteFramebuffer(framebuffer);
    gl.deleteVertexArray(quads);
    for (const buffer of [view, corners]) gl.deleteBuffer(buffer);
    // browsers limit the contexts of a page and drop the oldest one
    gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  /** @param {Camera} camera */
  #fit({ width, height }) {
    const { canvas } = this.#gl;
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
  }

  /**
   * Project and splat.
   *
   * @param {SceneData} scene
   * @param {Camera} camera
   */
  #sum(scene, camera) {
    const gl = this.#gl;
    const pictured = camera.width * camera.height;
    camera = magnified(camera, this.supersampling);
    const { view, quads, looks, depths, sums } = this.#fixed;
    const leveled = this.#leveled(scene, camera);
    const programs = this.#programs(scene, leveled);
    const [sumsWidth, sumsHeight] = this.#resize(scene, leveled, camera);
    gl.bindBuffer(gl.UNIFORM_BUFFER, view);
    this.#last = { leveled, pixels: pictured };
    const scale = this.variant.floats ? 1 : float16Scale(hasDepthPass(scene));
    const packed = viewUniforms(scene, camera, scale, this.levelSigma, this.supersampling);
    gl.bufferSubData(gl.UNIFORM_BUFFER, 0, packed);
    gl.bindVertexArray(quads);
    gl.disable(gl.BLEND);
    gl.bindFramebuffer(gl.FRAMEBUFFER, looks);
    gl.drawBuffers([gl.COLOR_ATTACHMENT0, scene.packing ? gl.NONE : gl.COLOR_ATTACHMENT1]);
    const [width, height] = extent(scene.count);
    gl.viewport(0, 0, width, height);
    gl.useProgram(programs.project);
    gl.uniform4fv(gl.getUniformLocation(programs.project, "crop"), this.crop ?? [0, 0, 0, 0]);
    this.#timer.pass("project");
    gl.drawArrays(gl.TRIANGLES, 0, 3);

    gl.enable(gl.BLEND);
    this.#timer.pass("splat");
    for (const program of programs.depths) {
      const [across, down] = levelSizes(camera.width, camera.height)[PASS_LEVEL];
      gl.bindFramebuffer(gl.FRAMEBUFFER, depths);
      gl.viewport(0, 0, across, down);
      gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
      gl.blendFunc(gl.ONE, gl.ONE);
      gl.useProgram(program);
      this.#quads(scene.count);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, sums);
    gl.viewport(0, 0, sumsWidth, sumsHeight);
    gl.useProgram(programs.splat);
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
    this.#quads(scene.count);
  }

  /** Draw the quads of all Gaussians. @param {number} count */
  #quads(count) {
    const gl = this.#gl;
    if (this.variant.strips) gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    else gl.drawElementsInstanced(gl.TRIANGLES, 6 * BATCH, gl.UNSIGNED_SHORT, 0, Math.ceil(count / BATCH));
  }

  /**
   * Resolve the sums.
   *
   * @param {SceneData} scene
   * @param {Camera} camera
   * @param {WebGLFramebuffer | null} target
   * @param {number} x first column of the picture in the target
   * @param {number} y first row
   * @param {number} lastRow of the picture in the target if its rows are counted from the bottom, or 0
   */
  #resolve(scene, camera, target, x, y, lastRow) {
    const gl = this.#gl;
    const fine = magnified(camera, this.supersampling);
    const { resolve, enlarge } = this.#programs(scene, this.#leveled(scene, fine));
    gl.disable(gl.BLEND);
    this.#timer.pass("resolve");
    if (enlarge.length) this.#enlarge(enlarge, fine);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.viewport(x, y, camera.width, camera.height);
    gl.useProgram(resolve);
    gl.uniform1i(gl.getUniformLocation(resolve, "first_column"), x);
    gl.uniform1i(gl.getUniformLocation(resolve, "last_row"), lastRow);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /**
   * Add the levels up, from the coarsest to level 1.
   *
   * @param {WebGLProgram[]} programs of levels 1 and 2
   * @param {Camera} camera
   */
  #enlarge(programs, { width, height }) {
    const gl = this.#gl;
    const sizes = levelSizes(width, height);
    for (const level of [2, 1]) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.#fixed.enlarged[level - 1]);
      gl.viewport(0, 0, sizes[level][0], sizes[level][1]);
      gl.useProgram(programs[level - 1]);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
  }

  /** True if levels are drawn: one texture must hold them all. @param {SceneData} scene @param {Camera} camera */
  #leveled({ sorted }, { width, height }) {
    const most = this.#gl.getParameter(this.#gl.MAX_TEXTURE_SIZE);
    return this.levelSigma > 0 && !sorted && Math.max(...levelPlaces(width, height).size) <= most;
  }

  /**
   * Allocate the textures of the sums when size or format change.
   *
   * @param {SceneData} scene
   * @param {boolean} leveled
   * @param {Camera} camera
   * @returns {number[]} width and height of the textures
   */
  #resize(scene, leveled, { width, height }) {
    const { floats } = this.variant;
    const { sorted } = scene;
    const size = leveled ? levelPlaces(width, height).size : [width, height];
    const key = `${width} ${height} ${sorted} ${leveled} ${floats} ${hasDepthPass(scene)}`;
    if (key === this.#sums) return size;
    const gl = this.#gl;
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (!(width > 0 && width <= most && height > 0 && height <= most)) {
      throw new Error(
        `an image of ${width}x${height} pixels cannot be rendered: each side must lie between 1 ` +
          `and ${most}`,
      );
    }
    const formats = floats ? [gl.RGBA32F, gl.R32F] : [gl.RGBA16F, gl.R16F];
    const { depths, sums, enlarged, textures } = this.#fixed;
    const sizes = levelSizes(width, height);
    if (hasDepthPass(scene)) textures.makeMoments(depths, sizes[PASS_LEVEL]);
    [sums, ...enlarged].forEach((framebuffer, level) => {
      const suffix = level ? `_${level}` : "";
      gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
      ["color_sums", "weight_sums"].forEach((name, i) => {
        const needed = (level === 0 || leveled) && !(sorted && i > 0);
        const pixels = level === 0 ? size : sizes[level];
        const texture = needed ? textures.make(`${name}${suffix}`, formats[i], pixels) : null;
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
      });
      if (level && leveled) gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
      if (level === 0 || leveled) this.#check(`pictures of ${width}x${height} floats`);
    });
    this.#sums = key;
    return size;
  }

  /** @param {SceneData} scene @param {boolean} leveled */
  #kind(scene, leveled) {
    const { sorted, packing } = scene;
    return { sorted, packed: packing !== null, strips: this.variant.strips, leveled, depthPass: hasDepthPass(scene) };
  }

  /** @param {SceneData} scene @param {boolean} leveled */
  #programs(scene, leveled) {
    const { programs } = this.#fixed;
    const kind = this.#kind(scene, leveled);
    const key = Object.values(kind).join(" ");
    const passes = programs.get(key) ?? makePrograms(this.#gl, this.#shaders, kind);
    programs.set(key, passes);
    return passes;
  }

  /** @param {SceneData} scene @param {boolean} leveled */
  #counter(scene, leveled) {
    const { counters } = this.#fixed;
    const kind = { ...this.#kind(scene, leveled), strips: false, depthPass: false };
    const key = Object.values(kind).join(" ");
    const program = counters.get(key) ?? makeCounter(this.#gl, this.#shaders, kind);
    counters.set(key, program);
    return program;
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
