/** The WebGPU device and its pipelines. */

import { toFloat16 } from "../mgs/float16.js";

/** @typedef {import("./types.js").Numbers} Numbers */
/** @typedef {import("./types.js").Variant} Variant */
/** @typedef {{sorted: boolean, packed: boolean, network: boolean, depthPass: boolean}} Kind of a scene */
/** @typedef {Record<number, GPUBuffer | GPUTextureView | GPUSampler>} Resources by the number of their binding */

/** @type {GPUBlendComponent} */
const ADD = { srcFactor: "one", dstFactor: "one", operation: "add" };
/** @type {GPUBlendComponent} */
const COVER = { srcFactor: "one", dstFactor: "one-minus-src-alpha", operation: "add" };
/** @type {GPUBlendState} */
export const OVER = { color: COVER, alpha: COVER };
/** Colours add up, alpha is multiplied by one minus itself. @type {GPUBlendState} */
export const SUMS = {
  color: ADD,
  alpha: { srcFactor: "zero", dstFactor: "one-minus-src-alpha", operation: "add" },
};
/** Of the depth pass. @type {GPUBlendState} */
const ADDED = { color: ADD, alpha: ADD };
/** Needed by float32 sums, whose levels are enlarged by filtering. @type {GPUFeatureName[]} */
const FLOATS = ["float32-blendable", "float32-filterable"];
const PASSES = ["network", "project", "splat", "resolve"];
/** @typedef {"network" | "project" | "splat" | "resolve"} Pass */

/** Device, shaders and pipelines that all scenes share. */
export class Program {
  /** Milliseconds by pass of the last timed frame; null where the device has no timer. @type {Record<string, number> | null} */
  milliseconds = null;
  #shaders;
  /** @type {Map<string, GPUShaderModule>} */
  #modules = new Map();
  /** @type {Map<string, GPURenderPipeline | GPUComputePipeline>} */
  #pipelines = new Map();
  /** @type {{queries: GPUQuerySet, found: GPUBuffer, read: GPUBuffer} | null} */
  #clock = null;

  /**
   * @param {Record<string, string>} shaders WGSL by name
   * @param {boolean} floats whether blending float32 is required
   * @returns {Promise<Program>} rejects with an error message where WebGPU is missing
   */
  static async create(shaders, floats) {
    if (!("gpu" in navigator)) {
      throw new Error("this browser has no WebGPU on this page: it may need https, or a newer version");
    }
    const preloaded = globalThis.preloadedAdapter;
    delete globalThis.preloadedAdapter;
    const adapter = (await preloaded) ?? (await navigator.gpu.requestAdapter({ powerPreference: "high-performance" }));
    if (adapter === null) throw new Error("WebGPU finds no graphics adapter on this device");
    /** @type {GPUFeatureName[]} */
    const wanted = ["timestamp-query", "float32-blendable", "float32-filterable", "shader-f16"];
    const features = wanted.filter((name) => adapter.features.has(name));
    if (floats && !FLOATS.every((name) => features.includes(name))) {
      throw new Error("this device cannot blend and filter 32-bit floats");
    }
    const { maxStorageBufferBindingSize, maxBufferSize } = adapter.limits;
    const device = await adapter.requestDevice({
      requiredFeatures: features,
      requiredLimits: { maxStorageBufferBindingSize, maxBufferSize },
    });
    return new Program(device, shaders);
  }

  /**
   * @param {GPUDevice} device
   * @param {Record<string, string>} shaders
   */
  constructor(device, shaders) {
    this.device = device;
    this.#shaders = shaders;
    this.bilinear = device.createSampler({ magFilter: "linear", minFilter: "linear" });
    if (device.features.has("timestamp-query")) {
      const size = 16 * PASSES.length;
      const use = GPUBufferUsage;
      this.#clock = {
        queries: device.createQuerySet({ type: "timestamp", count: 2 * PASSES.length }),
        found: device.createBuffer({ size, usage: use.QUERY_RESOLVE | use.COPY_SRC }),
        read: device.createBuffer({ size, usage: use.MAP_READ | use.COPY_DST }),
      };
    }
  }

  /** Free the timer, for a device that goes on. */
  destroy() {
    for (const part of Object.values(this.#clock ?? {})) part.destroy();
  }

  /** True if sums can be float32. */
  get blendsFloats() {
    return FLOATS.every((name) => this.device.features.has(name));
  }

  /** The numbers that the view network computes with. @returns {"f16" | "f32"} */
  get number() {
    return this.device.features.has("shader-f16") ? "f16" : "f32";
  }

  /** The pipeline of the view network. @param {Kind} kind */
  network(kind) {
    return this.computing("network", kind, "evaluate_network");
  }

  /** @param {Kind} kind @param {Variant} variant */
  project(kind, { strips }) {
    const name = kind.sorted ? "project_sorted" : "project_sortfree";
    return this.computing("project", kind, name, { STRIPS: Number(strips) });
  }

  /** The pipeline that counts fragments. @param {Kind} kind */
  count(kind) {
    return this.computing("count", kind, "count_fragments", { SORTED: Number(kind.sorted) });
  }

  /** Entry points that add Gaussians of a sort-free scene up. @param {boolean} leveled @param {boolean} depthPass */
  static entries(leveled, depthPass) {
    if (!leveled && !depthPass) return ["corner_sortfree", "add_weighted"];
    return ["corner_of_level", depthPass ? "add_seen" : "add_to_level"];
  }

  /** @param {Kind} kind @param {Variant} variant @param {boolean} leveled */
  splat(kind, variant, leveled) {
    const [corner, add] = kind.sorted ? ["corner_sorted", "cover"] : Program.entries(leveled, kind.depthPass);
    const blend = kind.sorted ? OVER : SUMS;
    const targets = sumFormats(kind.sorted, variant.floats).map((format) => ({ format, blend }));
    return this.quads(kind, variant, corner, add, targets, { constants: { LEVELED: Number(leveled) } });
  }

  /**
   * The format of the picture of the depth pass: float32 in every variant, as variances cancel in float16. It has a
   * sixteenth of the pixels.
   *
   * @returns {GPUTextureFormat}
   */
  get momentsFormat() {
    return this.blendsFloats ? "rgba32float" : "rgba16float";
  }

  /** Adds Gaussians to that picture. @param {Pick<Kind, "packed">} kind @param {Variant} variant @param {string} [corner] entry point @param {string} [add] entry point */
  depths(kind, variant, corner = "corner_of_pass", add = "add_depth") {
    return this.quads(kind, variant, corner, add, [{ format: this.momentsFormat, blend: ADDED }]);
  }

  /**
   * A pipeline that draws quads.
   *
   * @param {Pick<Kind, "packed">} kind
   * @param {Variant} variant
   * @param {string} corner entry point
   * @param {string} add entry point
   * @param {GPUColorTargetState[]} targets
   * @param {{constants?: Record<string, number>, depthStencil?: GPUDepthStencilState}} [more]
   */
  quads(kind, { strips }, corner, add, targets, { constants = {}, depthStencil } = {}) {
    const key = [corner, add, kind.packed, strips, ...targets.map(({ format }) => format), ...Object.values(constants)];
    return this.cached(`${key.join(" ")} ${depthStencil !== undefined}`, () => {
      const module = this.module("splat", kind);
      return this.device.createRenderPipeline({
        layout: "auto",
        vertex: { module, entryPoint: corner, constants: { STRIPS: Number(strips), ...constants } },
        primitive: { topology: strips ? "triangle-strip" : "triangle-list" },
        fragment: { module, entryPoint: add, targets },
        depthStencil,
      });
    });
  }

  /** The pipeline that adds the coarser levels to level 1 or 2. @param {number} level @param {GPUTextureFormat[]} formats of the sums */
  enlarge(level, formats) {
    return this.whole("resolve", "add_enlarged", formats, { LEVEL: level });
  }

  /**
   * @param {boolean} sorted
   * @param {GPUTextureFormat} format of the target
   * @param {boolean} levels whether the sums of `enlarge` are added
   */
  resolve(sorted, format, levels) {
    const entryPoint = sorted ? "resolve_sorted" : levels ? "resolve_levels" : "resolve_sortfree";
    return this.whole("resolve", entryPoint, [format]);
  }

  /** @param {GPUTextureFormat} format of the target */
  dots(format) {
    return this.cached(`dots ${format}`, () => {
      const module = this.device.createShaderModule({ code: this.#shaders.dots, label: "dots" });
      /** @type {GPUVertexAttribute[]} */
      const attributes = [{ shaderLocation: 0, offset: 0, format: "float32x3" }];
      return this.device.createRenderPipeline({
        layout: "auto",
        vertex: { module, entryPoint: "corner_of_dot", buffers: [{ arrayStride: 12, attributes }] },
        fragment: { module, entryPoint: "paint_dot", targets: [{ format }] },
      });
    });
  }

  /**
   * A pipeline that computes every pixel of textures.
   *
   * @param {string} name of the shader
   * @param {string} entryPoint
   * @param {GPUTextureFormat[]} formats
   * @param {Record<string, number>} [constants]
   */
  whole(name, entryPoint, formats, constants = {}) {
    return this.cached([name, entryPoint, ...formats, ...Object.values(constants)].join(" "), () => {
      const module = this.module(name, null);
      const targets = formats.map((format) => ({ format }));
      return this.device.createRenderPipeline({
        layout: "auto",
        vertex: { module, entryPoint: "whole_picture" },
        fragment: { module, entryPoint, constants, targets },
      });
    });
  }

  /**
   * A pipeline that computes.
   *
   * @param {string} name of the shader
   * @param {Pick<Kind, "packed">} kind
   * @param {string} entryPoint
   * @param {Record<string, number>} [constants]
   */
  computing(name, kind, entryPoint, constants = {}) {
    return this.cached([entryPoint, kind.packed, ...Object.values(constants)].join(" "), () =>
      this.device.createComputePipeline({
        layout: "auto",
        compute: { module: this.module(name, kind), entryPoint, constants },
      }),
    );
  }

  /**
   * Encode a compute pass.
   *
   * @param {GPUCommandEncoder} encoder
   * @param {GPUComputePipeline} pipeline
   * @param {Resources} resources
   * @param {number} groups
   * @param {GPUComputePassTimestampWrites} [timestampWrites]
   */
  compute(encoder, pipeline, resources, groups, timestampWrites) {
    const across = Math.max(1, Math.min(groups, 65535));
    const pass = encoder.beginComputePass({ timestampWrites });
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, this.bind(pipeline, resources));
    pass.dispatchWorkgroups(across, Math.ceil(groups / across));
    pass.end();
  }

  /**
   * Encode a pass that computes every pixel of textures.
   *
   * @param {GPUCommandEncoder} encoder
   * @param {GPURenderPipeline} pipeline
   * @param {Resources} resources
   * @param {GPUTextureView[]} written
   * @param {GPURenderPassTimestampWrites} [timestampWrites]
   */
  fill(encoder, pipeline, resources, written, timestampWrites) {
    const pass = encoder.beginRenderPass({
      colorAttachments: written.map((view) => ({ view, loadOp: "clear", storeOp: "store" })),
      timestampWrites,
    });
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, this.bind(pipeline, resources));
    pass.draw(3);
    pass.end();
  }

  /** A buffer with the weights of the view network. @param {Float32Array<ArrayBuffer>} matrices */
  weights(matrices) {
    const numbers = this.number === "f16" ? Uint16Array.from(matrices, toFloat16) : matrices;
    return this.filled(numbers, GPUBufferUsage.STORAGE);
  }

  /**
   * Create a buffer with given content.
   *
   * @param {Numbers | Uint16Array} numbers
   * @param {number} usage
   */
  filled(numbers, usage) {
    const size = Math.ceil(numbers.byteLength / 4) * 4;
    const buffer = this.device.createBuffer({ size, usage, mappedAtCreation: true });
    const bytes = new Uint8Array(numbers.buffer, numbers.byteOffset, numbers.byteLength);
    new Uint8Array(buffer.getMappedRange()).set(bytes);
    buffer.unmap();
    return buffer;
  }

  /**
   * Create the bind group of a pipeline.
   *
   * @param {GPURenderPipeline | GPUComputePipeline} pipeline
   * @param {Resources} resources
   */
  bind(pipeline, resources) {
    return this.device.createBindGroup({
      layout: pipeline.getBindGroupLayout(0),
      entries: Object.entries(resources).map(([binding, resource]) => ({
        binding: Number(binding),
        resource: resource instanceof GPUBuffer ? { buffer: resource } : resource,
      })),
    });
  }

  /**
   * Timestamp writes of a pass; of several with one name, the first has the `begin` and the last the `end`.
   *
   * @param {Pass} pass
   * @param {boolean} [begin]
   * @param {boolean} [end]
   */
  stamps(pass, begin = true, end = true) {
    if (this.#clock === null || !(begin || end)) return undefined;
    const index = 2 * PASSES.indexOf(pass);
    return {
      querySet: this.#clock.queries,
      ...(begin ? { beginningOfPassWriteIndex: index } : {}),
      ...(end ? { endOfPassWriteIndex: index + 1 } : {}),
    };
  }

  /**
   * Request the pass times of the last frame, stored in `milliseconds`; ignored while a request is pending.
   *
   * @param {Kind} kind of the scene
   */
  async time({ network }) {
    if (this.#clock === null || this.#clock.read.mapState !== "unmapped") return;
    const { queries, found, read } = this.#clock;
    const encoder = this.device.createCommandEncoder();
    encoder.resolveQuerySet(queries, 0, 2 * PASSES.length, found, 0);
    encoder.copyBufferToBuffer(found, 0, read, 0, read.size);
    this.device.queue.submit([encoder.finish()]);
    await read.mapAsync(GPUMapMode.READ);
    const stamps = new BigUint64Array(read.getMappedRange());
    const times = PASSES.map((name, i) => [name, Number(stamps[2 * i + 1] - stamps[2 * i]) / 1e6]);
    this.milliseconds = Object.fromEntries(network ? times : times.slice(1));
    read.unmap();
  }

  /**
   * A pipeline, made at its first use.
   *
   * @template {GPURenderPipeline | GPUComputePipeline} T
   * @param {string} key
   * @param {() => T} make
   * @returns {T}
   */
  cached(key, make) {
    const found = /** @type {T | undefined} */ (this.#pipelines.get(key)) ?? make();
    this.#pipelines.set(key, found);
    return found;
  }

  /** A module of the shaders, by name. @param {string} name @param {Pick<Kind, "packed"> | null} kind whose rows it reads */
  module(name, kind) {
    const rows = kind === null ? "" : this.#shaders[kind.packed ? "packed" : "wide"];
    const key = `${name} ${kind?.packed}`;
    const enabled = this.number === "f16" ? "enable f16;\n" : "";
    const numbers = name === "network" ? `${enabled}alias Num = ${this.number};\n` : "";
    const code = `${numbers}${this.#shaders.view}\n${rows}\n${this.#shaders[name]}`;
    const module = this.#modules.get(key) ?? this.device.createShaderModule({ code, label: name });
    this.#modules.set(key, module);
    return module;
  }
}

/**
 * Number resources by binding, from `first` on.
 *
 * @template T
 * @param {T[]} items
 * @param {number} first
 * @returns {Record<number, T>}
 */
export function numbered(items, first) {
  return Object.fromEntries(items.map((item, i) => [first + i, item]));
}

/** @param {boolean} sorted @param {boolean} floats @returns {GPUTextureFormat[]} */
export function sumFormats(sorted, floats) {
  if (floats) return sorted ? ["rgba32float"] : ["rgba32float", "r32float"];
  return sorted ? ["rgba16float"] : ["rgba16float", "r16float"];
}
