/** The layers of a picture: colours and proximities, a slice of a texture array each. */

import { BLOCKS_UNIT, WIDE_BLOCKS_UNIT } from "./webgl_blocks.js";

/** Texture units of colours and proximities: those of the blocks, which have another kind of texture. */
export const LAYER_UNITS = [BLOCKS_UNIT, WIDE_BLOCKS_UNIT];

export class LayerTextures {
  #gl;
  #framebuffer;
  /** @type {WebGLTexture[]} */
  #textures = [];
  #key = "";

  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.#gl = gl;
    this.#framebuffer = gl.createFramebuffer();
  }

  /** Allocate the textures when the size changes. @param {number} width @param {number} height @param {number} count of layers */
  resize(width, height, count) {
    const gl = this.#gl;
    const key = `${width} ${height} ${count}`;
    if (key === this.#key) return;
    for (const texture of this.#textures) gl.deleteTexture(texture);
    this.#textures = [gl.RGBA16F, gl.RG16F].map((format, i) => {
      const texture = gl.createTexture();
      gl.activeTexture(gl.TEXTURE0 + LAYER_UNITS[i]);
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
      gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, format, width, height, count);
      gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      return texture;
    });
    this.#key = key;
  }

  /** Draw into a layer from now on. @param {number} layer */
  attach(layer) {
    const gl = this.#gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#framebuffer);
    this.#textures.forEach((texture, i) => {
      gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, texture, 0, layer);
    });
    gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
  }

  /** Bind the textures to their units. */
  bind() {
    const gl = this.#gl;
    this.#textures.forEach((texture, i) => {
      gl.activeTexture(gl.TEXTURE0 + LAYER_UNITS[i]);
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
    });
  }

  /** Free all resources. */
  destroy() {
    for (const texture of this.#textures) this.#gl.deleteTexture(texture);
    this.#gl.deleteFramebuffer(this.#framebuffer);
  }
}
