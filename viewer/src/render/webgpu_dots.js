/** Renders dots with WebGPU. */

import { DOT_BYTES, packDots, verticesOf } from "./dots.js";

/** @typedef {import("./dots.js").Dots} Dots */
/** @typedef {import("./types.js").Camera} Camera */
/** @typedef {import("./webgpu_program.js").Program} Program */

/** The dots of a scene that is loading. */
export class WebGpuDots {
  #device;
  #dots;
  #pipeline;
  #view;
  #vertices;
  #count;

  /**
   * @param {Program} program
   * @param {Dots} dots
   * @param {GPUTextureFormat} format of the canvas
   */
  constructor(program, dots, format) {
    const { device } = program;
    this.#device = device;
    this.#dots = dots;
    this.#pipeline = program.dots(format);
    const { UNIFORM, VERTEX, COPY_DST } = GPUBufferUsage;
    this.#view = device.createBuffer({ size: DOT_BYTES, usage: UNIFORM | COPY_DST });
    const vertices = verticesOf(dots);
    this.#count = vertices.length / 3;
    this.#vertices = program.filled(vertices, VERTEX);
  }

  /** @param {Camera} camera @param {GPUTextureView} target */
  draw(camera, target) {
    const [device, pipeline, dots] = [this.#device, this.#pipeline, this.#dots];
    device.queue.writeBuffer(this.#view, 0, packDots(dots, camera));
    const encoder = device.createCommandEncoder();
    const pass = encoder.beginRenderPass({
      colorAttachments: [{ view: target, loadOp: "clear", storeOp: "store", clearValue: [...dots.background, 1] }],
    });
    const entries = [{ binding: 0, resource: { buffer: this.#view } }];
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries }));
    pass.setVertexBuffer(0, this.#vertices);
    pass.draw(this.#count);
    pass.end();
    device.queue.submit([encoder.finish()]);
  }

  destroy() {
    this.#view.destroy();
    this.#vertices.destroy();
  }
}
