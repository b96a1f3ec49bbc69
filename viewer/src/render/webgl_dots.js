/** Renders dots with WebGL2. */

import { packDots, verticesOf } from "./dots.js";
import { linked } from "./webgl_program.js";

/** @typedef {import("./dots.js").Dots} Dots */
/** @typedef {import("./types.js").Camera} Camera */

/** The dots of a scene that is loading; the program is reused. */
export class WebGlDots {
  #gl;
  /** @type {Dots | null} */
  #dots = null;
  #program;
  #triangles;
  #vertices;
  #count = 0;

  /** @param {WebGL2RenderingContext} gl @param {string} shader */
  constructor(gl, shader) {
    this.#gl = gl;
    this.#program = linked(gl, `#define VERTEX\n${shader}`, shader);
    this.#triangles = gl.createVertexArray();
    this.#vertices = gl.createBuffer();
    gl.bindVertexArray(this.#triangles);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.#vertices);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
  }

  /** @param {Dots | null} dots */
  take(dots) {
    const [gl, vertices] = [this.#gl, dots ? verticesOf(dots) : new Float32Array(0)];
    this.#dots = dots;
    this.#count = vertices.length / 3;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.#vertices);
    gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STATIC_DRAW);
  }

  /** Render into a target. @param {Camera} camera @param {import("./webgl.js").Target} target */
  draw(camera, { framebuffer, x, y }) {
    const [gl, dots] = [this.#gl, this.#dots];
    if (!dots) return;
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(x, y, camera.width, camera.height);
    gl.disable(gl.BLEND);
    gl.enable(gl.SCISSOR_TEST); // another part of the target may hold another picture
    gl.scissor(x, y, camera.width, camera.height);
    gl.clearBufferfv(gl.COLOR, 0, [...dots.background, 1]);
    gl.disable(gl.SCISSOR_TEST);
    gl.useProgram(this.#program);
    gl.uniform4fv(gl.getUniformLocation(this.#program, "dots"), packDots(dots, camera));
    gl.bindVertexArray(this.#triangles);
    gl.drawArrays(gl.TRIANGLES, 0, this.#count);
  }

  destroy() {
    const gl = this.#gl;
    gl.deleteProgram(this.#program);
    gl.deleteVertexArray(this.#triangles);
    gl.deleteBuffer(this.#vertices);
  }
}
