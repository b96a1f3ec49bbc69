/** Copies of a framebuffer of three.js: its depth, and its colours if they are needed. */

import { SAMPLERS, replaced } from "../render/webgl_textures.js";

/** @typedef {{depths: GLenum[], sure: boolean, color: GLenum}} Formats depth formats to try, whether the first is right, and the colours' */

/** Texture units of the copies, behind those of the renderer. */
export const DEPTH_UNIT = SAMPLERS.length;
export const COLOR_UNIT = DEPTH_UNIT + 1;

/** Copies parts of framebuffers into textures of the same format; multisampled ones are resolved. */
export class FramebufferCopy {
  #gl;
  /** Formats of each framebuffer; null is the default one's key. @type {Map<WebGLFramebuffer | null, Formats>} */
  #formats = new Map();
  #copies;

  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.#gl = gl;
    const copy = (/** @type {GLenum} */ unit) => ({
      unit: gl.TEXTURE0 + unit,
      framebuffer: gl.createFramebuffer(),
      texture: /** @type {WebGLTexture | null} */ (null),
      key: "",
    });
    this.#copies = { depth: copy(DEPTH_UNIT), color: copy(COLOR_UNIT) };
  }

  /**
   * Copy the depth into the texture at DEPTH_UNIT; returns false without one.
   *
   * @param {WebGLFramebuffer | null} source
   * @param {number[]} area left, bottom, right, top
   * @param {boolean} opaque whether the browser owns the framebuffer, as in WebXR
   */
  depth(source, area, opaque) {
    const gl = this.#gl;
    const formats = this.#formatsOf(source, opaque);
    while (formats.depths.length > 0) {
      const [format] = formats.depths;
      const stencil = format === gl.DEPTH24_STENCIL8 || format === gl.DEPTH32F_STENCIL8;
      const attachment = stencil ? gl.DEPTH_STENCIL_ATTACHMENT : gl.DEPTH_ATTACHMENT;
      this.#copy("depth", format, attachment, source, area);
      // the format of a framebuffer of the browser is found by trying
      if (formats.sure || gl.getError() === gl.NO_ERROR) {
        formats.sure = true;
        return true;
      }
      formats.depths.shift();
    }
    return false;
  }

  /**
   * Copy the colours into the texture at COLOR_UNIT.
   *
   * @param {WebGLFramebuffer | null} source
   * @param {number[]} area
   * @param {boolean} opaque
   */
  color(source, area, opaque) {
    const { color } = this.#formatsOf(source, opaque);
    this.#copy("color", color, this.#gl.COLOR_ATTACHMENT0, source, area);
  }

  /** Free all resources. */
  destroy() {
    for (const { texture, framebuffer } of Object.values(this.#copies)) {
      this.#gl.deleteTexture(texture);
      this.#gl.deleteFramebuffer(framebuffer);
    }
  }

  /**
   * @param {"depth" | "color"} name
   * @param {GLenum} format
   * @param {GLenum} attachment
   * @param {WebGLFramebuffer | null} source
   * @param {number[]} area
   */
  #copy(name, format, attachment, source, [left, bottom, right, top]) {
    const gl = this.#gl;
    const copy = this.#copies[name];
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, source);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, copy.framebuffer);
    gl.activeTexture(copy.unit);
    const key = `${format} ${right} ${top}`;
    if (copy.key !== key) {
      copy.texture = replaced(gl, copy.texture, format, right, top);
      copy.key = key;
      gl.framebufferTexture2D(gl.DRAW_FRAMEBUFFER, attachment, gl.TEXTURE_2D, copy.texture, 0);
    }
    gl.bindTexture(gl.TEXTURE_2D, copy.texture);
    // of a multisampled framebuffer only the same place can be copied
    const bits = name === "depth" ? gl.DEPTH_BUFFER_BIT : gl.COLOR_BUFFER_BIT;
    gl.blitFramebuffer(left, bottom, right, top, left, bottom, right, top, bits, gl.NEAREST);
  }

  /** @param {WebGLFramebuffer | null} source @param {boolean} opaque @returns {Formats} */
  #formatsOf(source, opaque) {
    const known = this.#formats.get(source);
    if (known) return known;
    const formats = source === null || opaque ? this.#ofBrowser() : this.#ofTarget(source);
    this.#formats.set(source, formats);
    return formats;
  }

  /** Formats of a framebuffer of the browser, which does not name them. @returns {Formats} */
  #ofBrowser() {
    const gl = this.#gl;
    const { depth, alpha } = gl.getContextAttributes() ?? { depth: true, alpha: true };
    const all = [
      ...[gl.DEPTH24_STENCIL8, gl.DEPTH_COMPONENT24, gl.DEPTH_COMPONENT32F],
      ...[gl.DEPTH32F_STENCIL8, gl.DEPTH_COMPONENT16],
    ];
    return { depths: depth ? all : [], sure: false, color: alpha ? gl.RGBA8 : gl.RGB8 };
  }

  /** @param {WebGLFramebuffer} source @returns {Formats} */
  #ofTarget(source) {
    const gl = this.#gl;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, source);
    const ask = (/** @type {GLenum} */ attachment, /** @type {GLenum} */ what) =>
      gl.getFramebufferAttachmentParameter(gl.READ_FRAMEBUFFER, attachment, what);
    const has = (/** @type {GLenum} */ attachment) =>
      ask(attachment, gl.FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE) !== gl.NONE;
    const depths = [];
    if (has(gl.DEPTH_ATTACHMENT)) {
      const bits = ask(gl.DEPTH_ATTACHMENT, gl.FRAMEBUFFER_ATTACHMENT_DEPTH_SIZE);
      const stencil = has(gl.STENCIL_ATTACHMENT);
      if (bits === 16) depths.push(gl.DEPTH_COMPONENT16);
      else if (bits === 32) depths.push(stencil ? gl.DEPTH32F_STENCIL8 : gl.DEPTH_COMPONENT32F);
      else depths.push(stencil ? gl.DEPTH24_STENCIL8 : gl.DEPTH_COMPONENT24);
    }
    const color = gl.COLOR_ATTACHMENT0;
    const [red, alpha] = [gl.FRAMEBUFFER_ATTACHMENT_RED_SIZE, gl.FRAMEBUFFER_ATTACHMENT_ALPHA_SIZE].map((what) =>
      ask(color, what),
    );
    const encoded = ask(color, gl.FRAMEBUFFER_ATTACHMENT_COLOR_ENCODING) === gl.SRGB;
    /** @type {Record<number, GLenum>} */
    const byRed = {
      8: encoded ? gl.SRGB8_ALPHA8 : alpha ? gl.RGBA8 : gl.RGB8,
      10: gl.RGB10_A2,
      11: gl.R11F_G11F_B10F,
      16: gl.RGBA16F,
      32: gl.RGBA32F,
    };
    return { depths, sure: true, color: byRed[red] ?? gl.RGBA8 };
  }
}
