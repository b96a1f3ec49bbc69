/** The least and the largest nearness of opaque meshes in blocks of pixels, by which Gaussians choose their level. */

import { replaced } from "../render/webgl_textures.js";
import { COLOR_UNIT } from "./webgl_copy.js";

/** Texture units of blocks of 8 x 8 and of 64 x 64 pixels, behind those of the copies. */
export const BLOCKS_UNIT = COLOR_UNIT + 1;
export const WIDE_BLOCKS_UNIT = BLOCKS_UNIT + 1;
const SIDE = 8;

export class DepthBlocks {
  #gl;
  #targets;

  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.#gl = gl;
    this.#targets = [BLOCKS_UNIT, WIDE_BLOCKS_UNIT].map((unit) => ({
      unit: gl.TEXTURE0 + unit,
      framebuffer: gl.createFramebuffer(),
      texture: /** @type {WebGLTexture | null} */ (null),
      size: [0, 0],
    }));
  }

  /**
   * Compute the blocks of a picture.
   *
   * @param {{width: number, height: number}} picture
   * @param {(level: number) => void} use the program of the level, 0 or 1
   */
  draw({ width, height }, use) {
    const gl = this.#gl;
    let size = [width, height];
    this.#targets.forEach((target, level) => {
      size = size.map((side) => Math.ceil(side / SIDE));
      gl.bindFramebuffer(gl.FRAMEBUFFER, target.framebuffer);
      gl.activeTexture(target.unit);
      if (target.size.some((side, i) => side !== size[i])) {
        target.texture = replaced(gl, target.texture, gl.RG16F, size[0], size[1]);
        target.size = size;
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target.texture, 0);
      }
      gl.bindTexture(gl.TEXTURE_2D, target.texture);
      gl.viewport(0, 0, size[0], size[1]);
      use(level);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    });
  }

  /** Free all resources. */
  destroy() {
    for (const { texture, framebuffer } of this.#targets) {
      this.#gl.deleteTexture(texture);
      this.#gl.deleteFramebuffer(framebuffer);
    }
  }
}
