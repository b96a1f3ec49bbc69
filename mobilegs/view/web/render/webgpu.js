/** Draws a scene with WebGPU: the shaders of view/shaders, as view/native.py uses them. */

import { HALF_SCALE, VIEW_BYTES, packView } from "./view.js";

/** @typedef {import("./types.js").Camera} Camera */
/** @typedef {import("./types.js").SceneData} SceneData */
/** @typedef {{bind: GPUBindGroup, drawnBind: GPUBindGroup, buffers: GPUBuffer[], order: GPUBuffer | null}} Uploaded */

const BATCH = 128; // quads of an instance, as in view.wgsl
const WORKGROUP = 64;
const SPLAT_BYTES = 48;
const DRAWN = [6 * BATCH, 0, 0, 0, 0, 0]; // project.wgsl's Drawn, before a frame
const NOTHING = new Float32Array(0);
const PASSES = ["project", "splat", "resolve"];

/**
 * The device and what runs on it; both ways of blending share it.
 */
export class WebGpuRenderer {
  /** What the device told when it was lost, or null. @type {string | null} */
  lost = null;
  /** Called once, with a sentence, when the device is lost. @type {(sentence: string) => void} */
  onLost = () => {};
  /** Milliseconds of the last timed frame by pass; null where the device has no clock. @type {Record<string, number> | null} */
  milliseconds = null;

  #device;
  #context;
  #canvas;
  #format;
  #fullPrecision;
  #codes;
  /** @type {GPUQuerySet | null} */
  #queries = null;
  /** @type {Map<string, GPURenderPipeline | GPUComputePipeline>} */
  #pipelines = new Map();
  /** @type {SceneData | null} */
  #scene = null;
  /** @type {Uploaded | null} */
  #uploaded = null;
  /** @type {{width: number, height: number, sorted: boolean, views: GPUTextureView[], textures: GPUTexture[]} | null} */
  #sums = null;
  #view;
  #drawn;
  #corners;

  /**
   * @param {HTMLCanvasElement | OffscreenCanvas} canvas
   * @param {Record<string, string>} shaders WGSL by name: view, project, splat, resolve
   * @param {{fullPrecision?: boolean}} [options]
   * @returns {Promise<WebGpuRenderer>} rejects with one sentence where the browser cannot
   */
  static async create(canvas, shaders, { fullPrecision = false } = {}) {
    if (!("gpu" in navigator)) {
      throw new Error("this browser has no WebGPU here; it may need https, or a newer version");
    }
    const adapter = await navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
    if (adapter === null) throw new Error("this device gives WebGPU no graphics adapter");
    /** @type {GPUFeatureName[]} */
    const features = [];
    if (adapter.features.has("timestamp-query")) features.push("timestamp-query");
    if (fullPrecision) {
      if (!adapter.features.has("float32-blendable")) {
        throw new Error("this device cannot blend 32-bit floats");
      }
      features.push("float32-blendable");
    }
    const { maxStorageBufferBindingSize, maxBufferSize } = adapter.limits;
    const device = await adapter.requestDevice({
      requiredFeatures: features,
      requiredLimits: { maxStorageBufferBindingSize, maxBufferSize },
    });
    return new WebGpuRenderer(device, canvas, shaders, fullPrecision);
  }

  /**
   * @param {GPUDevice} device
   * @param {HTMLCanvasElement | OffscreenCanvas} canvas
   * @param {Record<string, string>} shaders
   * @param {boolean} fullPrecision
   */
  constructor(device, canvas, shaders, fullPrecision) {
    const context = /** @type {GPUCanvasContext | null} */ (canvas.getContext("webgpu"));
    if (context === null) throw new Error("this canvas is already drawn to in another way");
    this.#device = device;
    this.#canvas = canvas;
    this.#context = context;
    this.#format = navigator.gpu.getPreferredCanvasFormat();
    this.#fullPrecision = fullPrecision;
    context.configure({ device, format: this.#format, alphaMode: "opaque" });
    const module = (/** @type {string} */ name) =>
      device.createShaderModule({ code: `${shaders.view}\n${shaders[name]}`, label: name });
    this.#codes = {
      project: module("project"),
      splat: module("splat"),
      resolve: module("resolve"),
    };
    const use = GPUBufferUsage;
    this.#view = device.createBuffer({ size: VIEW_BYTES, usage: use.UNIFORM | use.COPY_DST });
    this.#drawn = device.createBuffer({
      size: 4 * DRAWN.length,
      usage: use.STORAGE | use.INDIRECT | use.COPY_DST,
    });
    const corners = new Uint16Array(6 * BATCH);
    for (let quad = 0; quad < BATCH; quad++) {
      corners.set([0, 1, 2, 2, 1, 3].map((corner) => 4 * quad + corner), 6 * quad);
    }
    this.#corners = this.#filled(corners, use.INDEX);
    if (device.features.has("timestamp-query")) {
      this.#queries = device.createQuerySet({ type: "timestamp", count: 2 * PASSES.length });
    }
    device.lost.then(({ reason, message }) => {
      this.lost = message;
      if (reason !== "destroyed") {
        this.onLost("the graphics device was lost: reload the page to go on");
      }
    });
  }

  /**
   * Takes on a scene in the place of the one before.
   *
   * @param {SceneData} scene
   */
  setScene(scene) {
    this.#release();
    const { count, sorted } = scene;
    const rows = Math.max(count, 1); // buffers cannot be empty
    const needed = Math.max(
      SPLAT_BYTES * rows,
      scene.colors.byteLength,
      scene.lobes.byteLength,
      scene.shapes.byteLength,
    );
    const { maxStorageBufferBindingSize, maxBufferSize } = this.#device.limits;
    const most = Math.min(maxStorageBufferBindingSize, maxBufferSize);
    if (needed > most) {
      throw new Error(
        `${count} Gaussians need ${Math.ceil(needed / 2 ** 20)} MiB at a stretch, and this ` +
          `device gives ${Math.floor(most / 2 ** 20)}`,
      );
    }
    const use = GPUBufferUsage;
    const parts = [scene.shapes, scene.colors, scene.lobes].map((part) =>
      this.#filled(part.length ? part : new Float32Array(16), use.STORAGE | use.COPY_DST),
    );
    const splats = this.#device.createBuffer({ size: SPLAT_BYTES * rows, usage: use.STORAGE });
    const order = sorted
      ? this.#device.createBuffer({ size: 4 * rows, usage: use.STORAGE | use.COPY_DST })
      : null;
    const last = order ? { binding: 3, buffer: order } : { binding: 2, buffer: this.#drawn };
    // the numbers are the GPU's now: a page on a phone cannot keep them as well
    this.#scene = { ...scene, shapes: NOTHING, colors: NOTHING, lobes: NOTHING };
    this.#uploaded = {
      buffers: order ? [...parts, splats, order] : [...parts, splats],
      order,
      bind: this.#bind(this.#project(), [this.#view, ...parts, splats, this.#drawn]),
      drawnBind: this.#device.createBindGroup({
        layout: this.#splat().getBindGroupLayout(0),
        entries: [
          { binding: 0, resource: { buffer: this.#view } },
          { binding: 1, resource: { buffer: splats } },
          { binding: last.binding, resource: { buffer: last.buffer } },
        ],
      }),
    };
    if (order) this.setOrder(Uint32Array.from({ length: count }, (_, i) => i));
  }

  /**
   * Writes new numbers over those of some Gaussians, for a scene that is still arriving.
   *
   * @param {"shapes" | "colors" | "lobes"} part
   * @param {number} from first Gaussian whose numbers changed
   * @param {Float32Array<ArrayBuffer>} numbers all of theirs, of that part
   */
  update(part, from, numbers) {
    if (!this.#scene || !this.#uploaded || this.lost !== null) return;
    const stride = { shapes: 12, colors: 3 * this.#scene.shSize, lobes: 2 * this.#scene.lobeSize };
    const buffer = this.#uploaded.buffers[["shapes", "colors", "lobes"].indexOf(part)];
    this.#device.queue.writeBuffer(buffer, 4 * stride[part] * from, numbers);
  }

  /**
   * The order of a sorted scene, far ones first.
   *
   * @param {Uint32Array<ArrayBuffer>} order
   */
  setOrder(order) {
    const buffer = this.#uploaded?.order;
    if (buffer) this.#device.queue.writeBuffer(buffer, 0, order);
  }

  /**
   * Draws into the canvas, which takes the camera's size.
   *
   * @param {Camera} camera
   */
  draw(camera) {
    if (this.lost !== null) return;
    if (this.#canvas.width !== camera.width) this.#canvas.width = camera.width;
    if (this.#canvas.height !== camera.height) this.#canvas.height = camera.height;
    this.#frame(camera, this.#context.getCurrentTexture().createView(), this.#format);
  }

  /**
   * The picture as numbers: r, g, b and how much of the background is covered, top row first.
   *
   * @param {Camera} camera
   * @returns {Promise<Float32Array>}
   */
  async pixels(camera) {
    const { width, height } = camera;
    const stride = Math.ceil((16 * width) / 256) * 256; // rows of a copy must be aligned
    const use = GPUTextureUsage;
    const texture = this.#device.createTexture({
      size: [width, height],
      format: "rgba32float",
      usage: use.RENDER_ATTACHMENT | use.COPY_SRC,
    });
    this.#frame(camera, texture.createView(), "rgba32float");
    const buffer = this.#device.createBuffer({
      size: stride * height,
      usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST,
    });
    const encoder = this.#device.createCommandEncoder();
    encoder.copyTextureToBuffer({ texture }, { buffer, bytesPerRow: stride }, [width, height]);
    this.#device.queue.submit([encoder.finish()]);
    await buffer.mapAsync(GPUMapMode.READ);
    const rows = new Float32Array(buffer.getMappedRange());
    const found = new Float32Array(4 * width * height);
    for (let y = 0; y < height; y++) {
      const from = (y * stride) / 4;
      found.set(rows.subarray(from, from + 4 * width), 4 * width * y);
    }
    buffer.destroy();
    texture.destroy();
    return found;
  }

  /** Waits until everything that was asked for is drawn. */
  async finished() {
    await this.#device.queue.onSubmittedWorkDone();
  }

  /** The device in words, as far as the browser tells. */
  describe() {
    const { vendor, architecture, device, description } = this.#device.adapterInfo;
    return [vendor, architecture, device, description].filter(Boolean).join(" ");
  }

  /** Asks what each pass of the last frame took, into `milliseconds`. */
  async time() {
    if (this.#queries === null || this.lost !== null) return;
    const use = GPUBufferUsage;
    const size = 16 * PASSES.length;
    const found = this.#device.createBuffer({ size, usage: use.QUERY_RESOLVE | use.COPY_SRC });
    const read = this.#device.createBuffer({ size, usage: use.MAP_READ | use.COPY_DST });
    const encoder = this.#device.createCommandEncoder();
    encoder.resolveQuerySet(this.#queries, 0, 2 * PASSES.length, found, 0);
    encoder.copyBufferToBuffer(found, 0, read, 0, size);
    this.#device.queue.submit([encoder.finish()]);
    await read.mapAsync(GPUMapMode.READ);
    const stamps = new BigUint64Array(read.getMappedRange());
    this.milliseconds = Object.fromEntries(
      PASSES.map((name, i) => [name, Number(stamps[2 * i + 1] - stamps[2 * i]) / 1e6]),
    );
    read.destroy();
    found.destroy();
  }

  /** Gives back everything; the renderer cannot be used any more. */
  destroy() {
    this.#release();
    this.#device.destroy();
  }

  #release() {
    for (const buffer of this.#uploaded?.buffers ?? []) buffer.destroy();
    this.#uploaded = this.#scene = null;
  }

  /**
   * @param {Camera} camera
   * @param {GPUTextureView} target
   * @param {GPUTextureFormat} format
   */
  #frame(camera, target, format) {
    const scene = this.#scene;
    const uploaded = this.#uploaded;
    if (!scene || !uploaded) return;
    const { queue } = this.#device;
    queue.writeBuffer(this.#view, 0, packView(scene, camera, this.#fullPrecision ? 1 : HALF_SCALE));
    if (!scene.sorted) queue.writeBuffer(this.#drawn, 0, Uint32Array.from(DRAWN));
    const sums = this.#sumsFor(camera.width, camera.height, scene.sorted);
    const encoder = this.#device.createCommandEncoder();

    const groups = Math.ceil(scene.count / WORKGROUP);
    const across = Math.max(1, Math.min(groups, 65535));
    const projecting = encoder.beginComputePass({ timestampWrites: this.#stamps(0) });
    projecting.setPipeline(this.#project());
    projecting.setBindGroup(0, uploaded.bind);
    projecting.dispatchWorkgroups(across, Math.ceil(groups / across));
    projecting.end();

    const clear = [
      { r: 0, g: 0, b: 0, a: scene.sorted ? 0 : 1 }, // nothing is covered yet
      { r: 0, g: 0, b: 0, a: 0 },
    ];
    const splatting = encoder.beginRenderPass({
      colorAttachments: sums.map((view, i) => ({
        view,
        loadOp: "clear",
        storeOp: "store",
        clearValue: clear[i],
      })),
      timestampWrites: this.#stamps(1),
    });
    splatting.setPipeline(this.#splat());
    splatting.setBindGroup(0, uploaded.drawnBind);
    splatting.setIndexBuffer(this.#corners, "uint16");
    if (scene.sorted) splatting.drawIndexed(6 * BATCH, Math.ceil(scene.count / BATCH));
    else splatting.drawIndexedIndirect(this.#drawn, 0);
    splatting.end();

    const pipeline = this.#resolve(format);
    const resolving = encoder.beginRenderPass({
      colorAttachments: [{ view: target, loadOp: "clear", storeOp: "store" }],
      timestampWrites: this.#stamps(2),
    });
    resolving.setPipeline(pipeline);
    resolving.setBindGroup(0, this.#bind(pipeline, [this.#view, ...sums]));
    resolving.draw(3);
    resolving.end();
    queue.submit([encoder.finish()]);
  }

  /**
   * @param {number} width
   * @param {number} height
   * @param {boolean} sorted
   */
  #sumsFor(width, height, sorted) {
    const kept = this.#sums;
    if (kept && kept.width === width && kept.height === height && kept.sorted === sorted) {
      return kept.views;
    }
    for (const texture of kept?.textures ?? []) texture.destroy();
    const use = GPUTextureUsage;
    const textures = this.#sumFormats(sorted).map((format) =>
      this.#device.createTexture({
        size: [width, height],
        format,
        usage: use.RENDER_ATTACHMENT | use.TEXTURE_BINDING,
      }),
    );
    const views = textures.map((texture) => texture.createView());
    this.#sums = { width, height, sorted, textures, views };
    return views;
  }

  /** @param {boolean} sorted @returns {GPUTextureFormat[]} */
  #sumFormats(sorted) {
    if (this.#fullPrecision) return sorted ? ["rgba32float"] : ["rgba32float", "r32float"];
    return sorted ? ["rgba16float"] : ["rgba16float", "r16float"];
  }

  get #sorted() {
    return this.#scene?.sorted ?? false;
  }

  /**
   * @template {GPURenderPipeline | GPUComputePipeline} T
   * @param {string} name
   * @param {() => T} make
   * @returns {T}
   */
  #kept(name, make) {
    const key = `${name} ${this.#sorted}`;
    const found = /** @type {T | undefined} */ (this.#pipelines.get(key)) ?? make();
    this.#pipelines.set(key, found);
    return found;
  }

  #project() {
    return this.#kept("project", () =>
      this.#device.createComputePipeline({
        layout: "auto",
        compute: {
          module: this.#codes.project,
          entryPoint: "project_all",
          constants: { SORTED: Number(this.#sorted) },
        },
      }),
    );
  }

  #splat() {
    return this.#kept("splat", () => {
      /** @type {GPUBlendComponent} */
      const over = { srcFactor: "one", dstFactor: "one-minus-src-alpha", operation: "add" };
      /** @type {GPUBlendState} */
      const blend = this.#sorted
        ? { color: over, alpha: over }
        : {
            color: { srcFactor: "one", dstFactor: "one", operation: "add" },
            alpha: { srcFactor: "zero", dstFactor: "one-minus-src-alpha", operation: "add" },
          };
      const module = this.#codes.splat;
      return this.#device.createRenderPipeline({
        layout: "auto",
        vertex: { module, entryPoint: this.#sorted ? "corner_sorted" : "corner_sortfree" },
        primitive: { topology: "triangle-list" },
        fragment: {
          module,
          entryPoint: this.#sorted ? "cover" : "add_weighted",
          targets: this.#sumFormats(this.#sorted).map((format) => ({ format, blend })),
        },
      });
    });
  }

  /** @param {GPUTextureFormat} format */
  #resolve(format) {
    return this.#kept(`resolve ${format}`, () => {
      const module = this.#codes.resolve;
      return this.#device.createRenderPipeline({
        layout: "auto",
        vertex: { module, entryPoint: "whole_picture" },
        primitive: { topology: "triangle-list" },
        fragment: {
          module,
          entryPoint: this.#sorted ? "resolve_sorted" : "resolve_sortfree",
          targets: [{ format }],
        },
      });
    });
  }

  /**
   * Binds resources in the order of their numbers.
   *
   * @param {GPURenderPipeline | GPUComputePipeline} pipeline
   * @param {(GPUBuffer | GPUTextureView)[]} resources
   */
  #bind(pipeline, resources) {
    return this.#device.createBindGroup({
      layout: pipeline.getBindGroupLayout(0),
      entries: resources.map((resource, binding) => ({
        binding,
        resource: resource instanceof GPUBuffer ? { buffer: resource } : resource,
      })),
    });
  }

  /** @param {number} pass */
  #stamps(pass) {
    if (this.#queries === null) return undefined;
    return {
      querySet: this.#queries,
      beginningOfPassWriteIndex: 2 * pass,
      endOfPassWriteIndex: 2 * pass + 1,
    };
  }

  /**
   * @param {Float32Array | Uint16Array} numbers
   * @param {number} usage
   */
  #filled(numbers, usage) {
    const size = Math.ceil(numbers.byteLength / 4) * 4;
    const buffer = this.#device.createBuffer({ size, usage, mappedAtCreation: true });
    const bytes = new Uint8Array(numbers.buffer, numbers.byteOffset, numbers.byteLength);
    new Uint8Array(buffer.getMappedRange()).set(bytes);
    buffer.unmap();
    return buffer;
  }
}
