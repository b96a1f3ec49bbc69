/**
 * The renderer for browsers without WebGPU: WebGL2, and the same picture.
 *
 * A frame has three passes, as `native.py` has them: project (a pixel a Gaussian, into textures),
 * splats (blended quads, in any order for a sort-free scene), resolve.
 */

import { HALF_SCALE, VIEW_BYTES, packView } from "./view.js";

/** @typedef {import("./types.js").Camera} Camera */
/** @typedef {import("./types.js").SceneData} SceneData */
/** @typedef {"shapes" | "colors" | "lobes"} Part */
/** @typedef {"project" | "splat" | "resolve"} Pass */
/** @typedef {"RGBA32F" | "RGB32F" | "RGB16F" | "RG32F" | "RG16F" | "R32UI"} Format */

/**
 * What stays the same until the context is lost.
 *
 * @typedef {object} Fixed
 * @property {WebGLBuffer} view the uniform block of view.glsl
 * @property {WebGLBuffer} corners of the quads of a batch
 * @property {WebGLVertexArrayObject} quads
 * @property {WebGLFramebuffer} splats what the first pass writes
 * @property {WebGLFramebuffer} sums what the second one writes
 * @property {Map<boolean, Record<Pass, WebGLProgram>>} programs sorted ones and others, once needed
 * @property {Map<string, WebGLTexture>} textures by the sampler that reads them
 */

const ROW = 4096; // texels in a row of textures that hold Gaussians, as in view.glsl
const BATCH = 128; // quads of an instance, as in view.glsl
const VIEW_BINDING = 0;
const NOTHING = new Float32Array(0);

/** Each sampler has a texture unit of its own, so that nothing is ever bound anew. */
const SAMPLERS = [
  "shapes",
  "colors",
  "lobes",
  "splat_axes",
  "splat_places",
  "splat_colors",
  "order",
  "color_sums",
  "weight_sums",
];

/**
 * How the texture of each input is stored with 32-bit floats and without, the format of its
 * numbers, and how many of them make a texel. Halves move a picture of 66 dB by 0.1.
 *
 * @type {Record<Part | "order", [Format, Format, "RGBA" | "RGB" | "RG" | "RED_INTEGER", number]>}
 */
const INPUTS = {
  shapes: ["RGBA32F", "RGBA32F", "RGBA", 4],
  colors: ["RGB32F", "RGB16F", "RGB", 3],
  lobes: ["RG32F", "RG16F", "RG", 2],
  order: ["R32UI", "R32UI", "RED_INTEGER", 1],
};

/** Draws a scene with WebGL2, which even browsers have that reach this page over plain http. */
export class WebGlRenderer {
  /** The shaders that `create` is given, by file. */
  static files = ["view.glsl", "whole.glsl", "project.glsl", "splat.glsl", "resolve.glsl"];

  /** Why nothing is drawn any more, or null. @type {string | null} */
  lost = null;
  /** Called with a sentence when the context is lost. @type {(sentence: string) => void} */
  onLost = () => {};
  /** Called when the context is back, but without a scene. @type {() => void} */
  onRestored = () => {};

  #gl;
  #shaders;
  #fullPrecision;
  #fixed;
  /** @type {SceneData | null} */
  #scene = null;
  #size = [0, 0];

  #onLost = (/** @type {Event} */ event) => {
    event.preventDefault(); // or the context would never come back
    this.#scene = null;
    this.lost = "the browser took the GPU away from this page: reload it if no picture returns";
    this.onLost(this.lost);
  };

  #onRestored = () => {
    this.#scene = null; // one that was set in between has not arrived
    this.#fixed = makeFixed(this.#gl);
    this.lost = null;
    this.onRestored();
  };

  /**
   * A renderer that draws into `canvas`, with 16-bit floats unless `fullPrecision` asks for 32.
   *
   * Throws an Error with one sentence if the browser or its GPU cannot.
   *
   * @param {HTMLCanvasElement | OffscreenCanvas} canvas
   * @param {Record<string, string>} shaders texts of `files`, by the name before the dot
   * @param {{fullPrecision?: boolean}} [options]
   */
  static create(canvas, shaders, { fullPrecision = false } = {}) {
    const gl = /** @type {WebGL2RenderingContext | null} */ (
      canvas.getContext("webgl2", {
        alpha: false,
        antialias: false,
        depth: false,
        powerPreference: "high-performance",
      })
    );
    if (gl === null) throw new Error("this browser cannot draw with WebGL2 here");
    if (gl.getExtension("EXT_color_buffer_float") === null) {
      throw new Error("this GPU cannot draw into textures of floats");
    }
    if (fullPrecision && gl.getExtension("EXT_float_blend") === null) {
      throw new Error("this GPU cannot blend 32-bit floats: draw with halves");
    }
    if (gl.getParameter(gl.MAX_TEXTURE_SIZE) < ROW) {
      throw new Error(`this GPU's textures are less than ${ROW} pixels wide`);
    }
    return new WebGlRenderer(gl, shaders, fullPrecision);
  }

  /**
   * Use `create`, which asks first what the GPU can do.
   *
   * @param {WebGL2RenderingContext} gl
   * @param {Record<string, string>} shaders
   * @param {boolean} fullPrecision
   */
  constructor(gl, shaders, fullPrecision) {
    this.#gl = gl;
    this.#shaders = shaders;
    this.#fullPrecision = fullPrecision;
    this.#fixed = makeFixed(gl);
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
    this.#upload("shapes", scene.shapes);
    this.#upload("colors", scene.colors);
    this.#upload("lobes", scene.lobes);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#fixed.splats);
    ["splat_axes", "splat_places", "splat_colors"].forEach((name, i) => {
      const texture = this.#texture(name, gl.RGBA32F, extent(scene.count));
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
    });
    this.#check("three textures of 32-bit floats");
    // the numbers are the GPU's now: a page on a phone cannot keep them as well
    this.#scene = { ...scene, shapes: NOTHING, colors: NOTHING, lobes: NOTHING };
    this.#size = [0, 0]; // whether there is a sum of weights depends on the scene
    if (scene.sorted) this.#upload("order", Uint32Array.from({ length: scene.count }, (_, i) => i));
  }

  /**
   * Writes new numbers over those of some Gaussians, for a scene that is still arriving.
   *
   * @param {Part} part
   * @param {number} from first Gaussian whose numbers changed
   * @param {Float32Array} numbers all of theirs, of that part
   */
  update(part, from, numbers) {
    if (this.#scene === null) return;
    const texels = { shapes: 3, colors: this.#scene.shSize, lobes: this.#scene.lobeSize };
    this.#write(part, texels[part] * from, numbers);
  }

  /**
   * The order of a sorted scene's Gaussians, far ones first; their own until it is known.
   *
   * @param {Uint32Array} order
   */
  setOrder(order) {
    if (this.#scene === null) return;
    if (order.length !== this.#scene.count) {
      throw new Error(`an order of ${order.length} Gaussians does not suit this scene`);
    }
    this.#write("order", 0, order);
  }

  /**
   * Draws into the canvas, which takes the camera's size. Without a scene nothing happens.
   *
   * @param {Camera} camera
   */
  draw(camera) {
    if (this.#scene === null) return;
    const { canvas } = this.#gl;
    if (canvas.width !== camera.width) canvas.width = camera.width;
    if (canvas.height !== camera.height) canvas.height = camera.height;
    this.#sum(this.#scene, camera);
    this.#resolve(this.#scene, null, camera.height - 1);
  }

  /** Waits until everything that was asked for is drawn. */
  async finished() {
    // the only wait that every browser keeps
    this.#gl.readPixels(0, 0, 1, 1, this.#gl.RGBA, this.#gl.UNSIGNED_BYTE, new Uint8Array(4));
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
    const { view, corners, quads, splats, sums, programs, textures } = this.#fixed;
    this.#scene = null;
    gl.canvas.removeEventListener("webglcontextlost", this.#onLost);
    gl.canvas.removeEventListener("webglcontextrestored", this.#onRestored);
    for (const texture of textures.values()) gl.deleteTexture(texture);
    for (const passes of programs.values()) {
      for (const program of Object.values(passes)) gl.deleteProgram(program);
    }
    for (const framebuffer of [splats, sums]) gl.deleteFramebuffer(framebuffer);
    gl.deleteVertexArray(quads);
    for (const buffer of [view, corners]) gl.deleteBuffer(buffer);
  }

  /**
   * The first two passes.
   *
   * @param {SceneData} scene
   * @param {Camera} camera
   */
  #sum(scene, camera) {
    const gl = this.#gl;
    const { view, quads, splats, sums } = this.#fixed;
    const programs = this.#programs(scene.sorted);
    this.#resize(scene.sorted, camera);
    gl.bindBuffer(gl.UNIFORM_BUFFER, view);
    const packed = packView(scene, camera, this.#fullPrecision ? 1 : HALF_SCALE);
    gl.bufferSubData(gl.UNIFORM_BUFFER, 0, packed);
    gl.bindVertexArray(quads);
    gl.disable(gl.BLEND);
    gl.bindFramebuffer(gl.FRAMEBUFFER, splats);
    gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1, gl.COLOR_ATTACHMENT2]);
    const [width, height] = extent(scene.count);
    gl.viewport(0, 0, width, height);
    gl.useProgram(programs.project);
    gl.drawArrays(gl.TRIANGLES, 0, 3);

    gl.bindFramebuffer(gl.FRAMEBUFFER, sums);
    gl.viewport(0, 0, camera.width, camera.height);
    gl.enable(gl.BLEND);
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
    const batches = Math.ceil(scene.count / BATCH);
    gl.drawElementsInstanced(gl.TRIANGLES, 6 * BATCH, gl.UNSIGNED_SHORT, 0, batches);
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
    const { resolve } = this.#programs(scene.sorted);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.disable(gl.BLEND);
    gl.useProgram(resolve);
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
    if (width === this.#size[0] && height === this.#size[1]) return;
    const gl = this.#gl;
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (!(width > 0 && width <= most && height > 0 && height <= most)) {
      throw new Error(
        `a picture of ${width}x${height} pixels cannot be drawn: each side must lie between 1 ` +
          `and ${most}`,
      );
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#fixed.sums);
    const formats = this.#fullPrecision ? [gl.RGBA32F, gl.R32F] : [gl.RGBA16F, gl.R16F];
    ["color_sums", "weight_sums"].forEach((name, i) => {
      const texture = sorted && i > 0 ? null : this.#texture(name, formats[i], [width, height]);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
    });
    this.#check(`pictures of ${width}x${height} floats`);
    this.#size = [width, height];
  }

  /** @param {boolean} sorted */
  #programs(sorted) {
    const { programs } = this.#fixed;
    const passes = programs.get(sorted) ?? makePrograms(this.#gl, this.#shaders, sorted);
    programs.set(sorted, passes);
    return passes;
  }

  /**
   * A texture for one sampler, in the place of the one before.
   *
   * @param {string} name
   * @param {GLenum} format
   * @param {number[]} size
   */
  #texture(name, format, [width, height]) {
    const gl = this.#gl;
    const { textures } = this.#fixed;
    gl.deleteTexture(textures.get(name) ?? null);
    const texture = gl.createTexture();
    textures.set(name, texture);
    gl.activeTexture(gl.TEXTURE0 + SAMPLERS.indexOf(name));
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return texture;
  }

  /**
   * A new texture with all numbers of an input.
   *
   * @param {Part | "order"} name
   * @param {Float32Array | Uint32Array} data
   */
  #upload(name, data) {
    const gl = this.#gl;
    const [full, half, , channels] = INPUTS[name];
    const size = extent(data.length / channels);
    if (size[1] > gl.getParameter(gl.MAX_TEXTURE_SIZE)) {
      throw new Error("the scene has more Gaussians than this GPU's textures can hold");
    }
    this.#texture(name, gl[this.#fullPrecision ? full : half], size);
    this.#write(name, 0, data);
  }

  /**
   * Writes texels of an input, row by row, or whole rows at once.
   *
   * @param {Part | "order"} name
   * @param {number} from first texel
   * @param {Float32Array | Uint32Array} data
   */
  #write(name, from, data) {
    const gl = this.#gl;
    const [, , layout, channels] = INPUTS[name];
    const kind = data instanceof Float32Array ? gl.FLOAT : gl.UNSIGNED_INT;
    const texels = data.length / channels;
    gl.activeTexture(gl.TEXTURE0 + SAMPLERS.indexOf(name));
    for (let done = 0; done < texels; ) {
      const [x, y] = [(from + done) % ROW, Math.floor((from + done) / ROW)];
      const width = Math.min(ROW - x, texels - done);
      const height = width === ROW ? Math.floor((texels - done) / ROW) : 1;
      const start = done * channels;
      gl.texSubImage2D(gl.TEXTURE_2D, 0, x, y, width, height, gl[layout], kind, data, start);
      done += width * height;
    }
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

/** Width and height of the texture that holds so many texels. @param {number} texels */
function extent(texels) {
  const width = Math.max(1, Math.min(texels, ROW));
  return [width, Math.max(1, Math.ceil(texels / ROW))];
}

/** @param {WebGL2RenderingContext} gl @returns {Fixed} */
function makeFixed(gl) {
  // a context that comes back has forgotten what it was asked for
  for (const name of ["EXT_color_buffer_float", "EXT_float_blend"]) gl.getExtension(name);
  // all corners carry the same values: Metal would pay for another convention than its own
  const convention = gl.getExtension("WEBGL_provoking_vertex");
  convention?.provokingVertexWEBGL(convention.FIRST_VERTEX_CONVENTION_WEBGL);
  gl.disable(gl.DITHER);
  const fixed = {
    view: gl.createBuffer(),
    corners: gl.createBuffer(),
    quads: gl.createVertexArray(),
    splats: gl.createFramebuffer(),
    sums: gl.createFramebuffer(),
    programs: new Map(),
    textures: new Map(),
  };
  gl.bindBufferBase(gl.UNIFORM_BUFFER, VIEW_BINDING, fixed.view);
  gl.bufferData(gl.UNIFORM_BUFFER, VIEW_BYTES, gl.DYNAMIC_DRAW);
  gl.bindVertexArray(fixed.quads);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, fixed.corners);
  const quad = [0, 1, 2, 2, 1, 3];
  const corners = Array.from({ length: BATCH }, (_, i) => quad.map((corner) => 4 * i + corner));
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, Uint16Array.from(corners.flat()), gl.STATIC_DRAW);
  return fixed;
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {Record<string, string>} shaders
 * @param {boolean} sorted
 * @returns {Record<Pass, WebGLProgram>}
 */
function makePrograms(gl, { view, whole, project, splat, resolve }, sorted) {
  /** @type {(vertex: string, fragment: string) => WebGLProgram} */
  const link = (vertex, fragment) => {
    const program = gl.createProgram();
    const version = `#version 300 es\n${sorted ? "#define SORTED\n" : ""}`;
    for (const [kind, text] of /** @type {[GLenum, string][]} */ ([
      [gl.VERTEX_SHADER, `${version}#define VERTEX\n${view}${vertex}`],
      [gl.FRAGMENT_SHADER, `${version}${view}${fragment}`],
    ])) {
      const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      gl.deleteShader(shader); // as soon as the program goes
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = (gl.getAttachedShaders(program) ?? []).map((one) => gl.getShaderInfoLog(one));
      logs.push(gl.getProgramInfoLog(program));
      throw new Error(`this GPU refuses a shader: ${logs.join(" ")}`);
    }
    gl.useProgram(program);
    SAMPLERS.forEach((name, unit) => gl.uniform1i(gl.getUniformLocation(program, name), unit));
    gl.uniformBlockBinding(program, gl.getUniformBlockIndex(program, "View"), VIEW_BINDING);
    return program;
  };
  return {
    project: link(whole, project),
    splat: link(splat, splat),
    resolve: link(whole, resolve),
  };
}
