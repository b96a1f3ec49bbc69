/** WebGL2 textures that hold numbers. Each has its own unit and stays bound. */

/** @typedef {import("./types.js").Numbers} Numbers */
/** @typedef {"RGBA32F" | "RGB32F" | "RGB16F" | "RG32F" | "RG16F" | "R32UI" | "RGBA32UI"} Format */
/** @typedef {"RGBA" | "RGB" | "RG" | "RED_INTEGER" | "RGBA_INTEGER"} Layout */
/** @typedef {[Format, Layout, number]} Input internal format, format, numbers per texel */

export const ROW = 4096; // texels in a row of textures that hold Gaussians, as in view.glsl

/** The textures of a packed scene. @type {Record<import("./types.js").Part, Input>} */
export const PACKED = {
  shapes: ["RGBA32UI", "RGBA_INTEGER", 4],
  colors: ["RGBA32UI", "RGBA_INTEGER", 4],
  lobes: ["R32UI", "RED_INTEGER", 1],
};

/** Samplers in the order of their texture units. */
export const SAMPLERS = [
  "shapes",
  "colors",
  "lobes",
  "looks",
  "opacities",
  "order",
  "color_sums",
  "weight_sums",
  // of a level, with the coarser ones
  "color_sums_1",
  "weight_sums_1",
  "color_sums_2",
  "weight_sums_2",
  "moments",
];

/** The textures of a context. */
export class Textures {
  #gl;
  /** @type {Map<string, WebGLTexture>} */
  #all = new Map();

  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.#gl = gl;
  }

  /**
   * Create the texture of a sampler and delete the previous one.
   *
   * @param {string} name
   * @param {GLenum} format
   * @param {number[]} size
   */
  make(name, format, [width, height]) {
    const gl = this.#gl;
    gl.activeTexture(gl.TEXTURE0 + SAMPLERS.indexOf(name));
    const texture = replaced(gl, this.#all.get(name) ?? null, format, width, height);
    this.#all.set(name, texture);
    return texture;
  }

  /**
   * Create the picture of the depth pass, which is read with filters, as the output of a framebuffer.
   *
   * It is float32 where the GPU blends and filters that, as variances cancel in float16.
   *
   * @param {WebGLFramebuffer} framebuffer
   * @param {number[]} size
   */
  makeMoments(framebuffer, size) {
    const gl = this.#gl;
    const wide = ["EXT_color_buffer_float", "EXT_float_blend", "OES_texture_float_linear"].every((name) => gl.getExtension(name));
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    const texture = this.make("moments", wide ? gl.RGBA32F : gl.RGBA16F, size);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
  }

  /**
   * Create a texture with all numbers of an input.
   *
   * @param {string} name
   * @param {Input} input
   * @param {Numbers} data
   */
  upload(name, input, data) {
    const gl = this.#gl;
    const [format, , channels] = input;
    const size = extent(data.length / channels);
    if (size[1] > gl.getParameter(gl.MAX_TEXTURE_SIZE)) {
      throw new Error("the scene has more Gaussians than this GPU's textures can hold");
    }
    this.make(name, gl[format], size);
    this.write(name, input, 0, data);
  }

  /**
   * Write texels of an input: partial rows, then whole rows at once.
   *
   * @param {string} name
   * @param {Input} input
   * @param {number} from first texel
   * @param {Numbers} data
   */
  write(name, [, layout, channels], from, data) {
    const gl = this.#gl;
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

  /** Bind all textures to their units again, in a context that others use too. */
  bind() {
    for (const [name, texture] of this.#all) {
      this.#gl.activeTexture(this.#gl.TEXTURE0 + SAMPLERS.indexOf(name));
      this.#gl.bindTexture(this.#gl.TEXTURE_2D, texture);
    }
  }

  /** Delete all textures. */
  destroy() {
    for (const texture of this.#all.values()) this.#gl.deleteTexture(texture);
  }
}

/**
 * A texture without filters, bound to the active unit, in place of an earlier one.
 *
 * @param {WebGL2RenderingContext} gl
 * @param {WebGLTexture | null} old
 * @param {GLenum} format
 * @param {number} width
 * @param {number} height
 */
export function replaced(gl, old, format, width, height) {
  gl.deleteTexture(old);
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  return texture;
}

/** Width and height of a texture with at least `texels` texels. @param {number} texels */
export function extent(texels) {
  const width = Math.max(1, Math.min(texels, ROW));
  return [width, Math.max(1, Math.ceil(texels / ROW))];
}
