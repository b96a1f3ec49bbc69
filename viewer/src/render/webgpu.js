/** The WebGPU renderer. It uses the shaders in the same way as mobilegs/view/wgpu_renderer.py. */

import { PASS_LEVEL, levelPlaces, levelSizes } from "./levels.js";
import { BATCH, CORNERS } from "./quads.js";
import { hasDepthPass, strides, variantsOf } from "./types.js";
import { VIEW_BYTES, float16Scale, magnified, viewUniforms } from "./view_uniforms.js";
import { GAUSSIANS } from "./view_network.js";
import { WebGpuDots } from "./webgpu_dots.js";
import { Program, numbered, sumFormats } from "./webgpu_program.js";

/** @typedef {import("./dots.js").Dots} Dots */
/** @typedef {import("./types.js").Camera} Camera */
/** @typedef {import("./types.js").Numbers} Numbers */
/** @typedef {import("./types.js").Part} Part */
/** @typedef {import("./types.js").SceneData} SceneData */
/** @typedef {import("./types.js").Variant} Variant */
/** @typedef {import("./webgpu_program.js").Kind} Kind */
/**
 * @typedef {object} Uploaded
 * @property {Kind} kind
 * @property {Record<Part, GPUBuffer>} parts
 * @property {GPUBuffer} looks
 * @property {GPUBuffer} order of a sorted scene; or the list of visible Gaussians
 * @property {{weights: GPUBuffer, lobes: GPUBuffer} | null} network weights, and results
 */

const DRAWN_WORDS = 6; // of Drawn in project.wgsl
const LOOK_BYTES = { packed: 8, wide: 32 };
const NOTHING = new Float32Array(0);

/** Renders sort-free and sorted scenes with WebGPU. */
export class WebGpuRenderer {
  /** The current variant; may be changed between frames. @type {Variant} */
  variant;
  /** Smallest standard deviation of a Gaussian at a level, in its pixels, at least 0.6; 0: all at full size. */
  levelSigma = 0;
  /** Pixels rendered and averaged along a side of each pixel of the canvas: `supersampling` of mobilegs. */
  supersampling = 1;
  /** Why the renderer cannot continue, or null. @type {string | null} */
  lost = null;
  /** Called once with `lost`. @type {(sentence: string) => void} */
  onLost = () => {};

  #program;
  #device;
  #context;
  #canvas;
  #format;
  /** @type {SceneData | null} */
  #scene = null;
  /** @type {Uploaded | null} */
  #uploaded = null;
  /** @type {WebGpuDots | null} */
  #dots = null;
  /**
   * Of all levels; then of levels 1 and 2 with the coarser ones; and the picture of a depth pass.
   *
   * @type {{key: string, views: GPUTextureView[][], moments: GPUTextureView | null, textures: GPUTexture[]} | null}
   */
  #sums = null;
  #view;
  #drawn;
  /** Of the last frame. @type {{leveled: boolean, pixels: number} | null} */
  #last = null;
  #corners;

  /**
   * @param {HTMLCanvasElement | OffscreenCanvas} canvas
   * @param {Record<string, string>} shaders texts by name
   * @param {Partial<Variant>} [variant] default: float16 in batches
   * @returns {Promise<WebGpuRenderer>} rejects with an error message where WebGPU is missing
   */
  static async create(canvas, shaders, { floats = false, strips = false } = {}) {
    const program = await Program.create(shaders, floats);
    return new WebGpuRenderer(program, canvas, { floats, strips });
  }

  /**
   * @param {Program} program
   * @param {HTMLCanvasElement | OffscreenCanvas} canvas
   * @param {Variant} variant
   */
  constructor(program, canvas, variant) {
    const context = /** @type {GPUCanvasContext | null} */ (canvas.getContext("webgpu"));
    if (context === null) throw new Error("this canvas is already drawn to in another way");
    const { device } = program;
    this.variant = variant;
    this.#program = program;
    this.#device = device;
    this.#canvas = canvas;
    this.#context = context;
    this.#format = navigator.gpu.getPreferredCanvasFormat();
    context.configure({ device, format: this.#format, alphaMode: "opaque" });
    const use = GPUBufferUsage;
    this.#view = device.createBuffer({ size: VIEW_BYTES, usage: use.UNIFORM | use.COPY_DST });
    const usage = use.STORAGE | use.INDIRECT | use.COPY_DST;
    this.#drawn = device.createBuffer({ size: 4 * DRAWN_WORDS, usage });
    this.#corners = program.filled(CORNERS, use.INDEX);
    device.lost.then(({ reason }) => {
      if (reason !== "destroyed") this.#fail("the graphics device was lost: reload the page to go on");
    });
    // the only notice of refused shaders and of missing memory
    device.onuncapturederror = ({ error }) => this.#fail(`this GPU cannot draw the scene: ${error.message}`);
  }

  /** The variants that this device supports. @returns {Variant[]} */
  get variants() {
    return variantsOf(this.#program.blendsFloats);
  }

  /** Milliseconds by pass of the last timed frame; null where the device has no timer. */
  get milliseconds() {
    return this.#program.milliseconds;
  }

  /**
   * Replace the scene.
   *
   * @param {SceneData} scene
   */
  setScene(scene) {
    this.#release();
    const { count, sorted } = scene;
    const kind = {
      sorted,
      packed: scene.packing !== null,
      network: Boolean(scene.network),
      depthPass: hasDepthPass(scene),
    };
    const looks = LOOK_BYTES[kind.packed ? "packed" : "wide"] * Math.max(count, 1); // not empty
    const parts = { shapes: scene.shapes, colors: scene.colors, lobes: scene.lobes };
    const needed = Math.max(looks, ...Object.values(parts).map((part) => part.byteLength));
    const { maxStorageBufferBindingSize, maxBufferSize } = this.#device.limits;
    const most = Math.min(maxStorageBufferBindingSize, maxBufferSize);
    if (needed > most) {
      throw new Error(
        `${count} Gaussians need ${Math.ceil(needed / 2 ** 20)} MiB at a stretch, and this ` +
          `device gives ${Math.floor(most / 2 ** 20)}`,
      );
    }
    const use = GPUBufferUsage;
    const filled = (/** @type {Numbers} */ part) =>
      this.#program.filled(part.length ? part : new Uint32Array(16), use.STORAGE | use.COPY_DST);
    const list = (/** @type {number} */ length) =>
      this.#device.createBuffer({ size: 4 * Math.max(1, length), usage: use.STORAGE | use.COPY_DST });
    this.#uploaded = {
      kind,
      parts: {
        shapes: filled(parts.shapes),
        colors: filled(parts.colors),
        lobes: filled(parts.lobes),
      },
      looks: this.#device.createBuffer({ size: looks, usage: use.STORAGE }),
      order: list(count),
      network: scene.network
        ? { weights: this.#program.weights(scene.network), lobes: list(count) }
        : null,
    };
    // the GPU has a copy now: drop the page's own, since phones have little memory
    this.#scene = { ...scene, shapes: NOTHING, colors: NOTHING, lobes: NOTHING };
    if (sorted) this.setOrder(Uint32Array.from({ length: count }, (_, i) => i));
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
    if (!this.#scene || !this.#uploaded || this.lost !== null) return;
    const start = 4 * strides(this.#scene)[part] * from;
    this.#device.queue.writeBuffer(this.#uploaded.parts[part], start, numbers);
  }

  /** Set the dots that `drawDots` renders; the scene stays. @param {Dots | null} dots */
  setDots(dots) {
    this.#dots?.destroy();
    this.#dots = dots && new WebGpuDots(this.#program, dots, this.#format);
  }

  /** Render the dots; the canvas gets the camera's size. @param {Camera} camera */
  drawDots(camera) {
    if (this.lost === null) this.#dots?.draw(camera, this.#fitted(camera));
  }

  /**
   * Set the order of a sorted scene, the farthest Gaussian first.
   *
   * @param {Uint32Array<ArrayBuffer>} order
   */
  setOrder(order) {
    if (!this.#uploaded?.kind.sorted) return;
    this.#device.queue.writeBuffer(this.#uploaded.order, 0, order);
  }

  /**
   * Render into the canvas, which gets the camera's size.
   *
   * @param {Camera} camera
   */
  draw(camera) {
    if (this.lost === null) this.#frame(camera, this.#fitted(camera), this.#format);
  }

  /**
   * Render to floats: r, g, b and the coverage of the background, top row first.
   *
   * @param {Camera} camera
   * @returns {Promise<Float32Array>}
   */
  async pixels(camera) {
    const { width, height } = camera;
    const stride = Math.ceil((16 * width) / 256) * 256; // rows of a copy must be aligned
    const texture = this.#target(width, height, "rgba32float");
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

  /** Render off screen and wait until it is done. @param {Camera} camera */
  async drawUnseen(camera) {
    const texture = this.#target(camera.width, camera.height, this.#format);
    this.#frame(camera, texture.createView(), this.#format);
    await this.finished();
    texture.destroy();
    if (this.lost !== null) throw new Error(this.lost);
  }

  /** Wait until all submitted work is rendered. */
  async finished() {
    await this.#device.queue.onSubmittedWorkDone();
  }

  /** The name of the device, as far as the browser reveals it. */
  describe() {
    const told = this.#device.adapterInfo; // not in all browsers
    return [told?.vendor, told?.architecture, told?.device, told?.description].filter(Boolean).join(" ");
  }

  /** Request the pass times of the last frame, stored in `milliseconds`. */
  async time() {
    if (this.lost === null && this.#uploaded) await this.#program.time(this.#uploaded.kind);
  }

  /**
   * Fragments per pixel of the last frame, by level, as mobilegs/evaluate/fragments.py counts them; null
   * before the first frame.
   *
   * @returns {Promise<number[] | null>}
   */
  async fragments() {
    const [uploaded, scene, last] = [this.#uploaded, this.#scene, this.#last];
    if (!uploaded || !scene || !last || this.lost !== null) return null;
    const use = GPUBufferUsage;
    const areas = this.#program.filled(new Uint32Array(4), use.STORAGE | use.COPY_SRC);
    const read = this.#device.createBuffer({ size: areas.size, usage: use.MAP_READ | use.COPY_DST });
    const { kind, parts, looks, order } = uploaded;
    const encoder = this.#device.createCommandEncoder();
    const resources = { 0: this.#view, 1: parts.shapes, 4: looks, 5: order, 6: this.#drawn, 7: areas };
    this.#program.compute(encoder, this.#program.count(kind), resources, Math.ceil(scene.count / BATCH));
    encoder.copyBufferToBuffer(areas, 0, read, 0, areas.size);
    this.#device.queue.submit([encoder.finish()]);
    await read.mapAsync(GPUMapMode.READ);
    const found = Array.from(new Uint32Array(read.getMappedRange()), (area) => area / 8 / last.pixels);
    for (const buffer of [areas, read]) buffer.destroy();
    return last.leveled ? found : found.slice(0, 1);
  }

  /** Free all resources; the renderer cannot be used afterwards. */
  destroy() {
    this.#release();
    this.setDots(null);
    this.#device.onuncapturederror = null;
    this.#device.destroy();
  }

  /** @param {string} sentence */
  #fail(sentence) {
    if (this.lost !== null) return;
    this.lost = sentence;
    this.onLost(sentence);
  }

  #release() {
    for (const buffer of this.#buffers()) buffer.destroy();
    this.#uploaded = this.#scene = this.#last = null;
  }

  #buffers() {
    if (this.#uploaded === null) return [];
    const { parts, looks, order, network } = this.#uploaded;
    return [...Object.values(parts), looks, order, ...Object.values(network ?? {})];
  }

  /** Resize the canvas and return its texture. @param {Camera} camera */
  #fitted({ width, height }) {
    if (this.#canvas.width !== width) this.#canvas.width = width;
    if (this.#canvas.height !== height) this.#canvas.height = height;
    return this.#context.getCurrentTexture().createView();
  }

  /** @param {number} width @param {number} height @param {GPUTextureFormat} format */
  #target(width, height, format) {
    const use = GPUTextureUsage;
    return this.#device.createTexture({
      size: [width, height],
      format,
      usage: use.RENDER_ATTACHMENT | use.COPY_SRC,
    });
  }

  /**
   * @param {Camera} camera
   * @param {GPUTextureView} target
   * @param {GPUTextureFormat} format
   */
  #frame(camera, target, format) {
    const scene = this.#scene;
    if (!scene || !this.#uploaded) return;
    const fine = magnified(camera, this.supersampling);
    const { queue } = this.#device;
    const { floats, strips } = this.variant;
    // one texture must hold all levels
    const most = this.#device.limits.maxTextureDimension2D;
    const fits = Math.max(...levelPlaces(fine.width, fine.height).size) <= most;
    const leveled = fits && !scene.sorted && this.levelSigma > 0;
    const sigma = leveled ? this.levelSigma : 0;
    const uniforms = viewUniforms(scene, fine, floats ? 1 : float16Scale(hasDepthPass(scene)), sigma, this.supersampling);
    queue.writeBuffer(this.#view, 0, uniforms);
    queue.writeBuffer(this.#drawn, 0, Uint32Array.of(strips ? 4 : 6 * BATCH, 0, 0, 0, 0, 0));
    const { views: sums, moments } = this.#sumsFor(fine.width, fine.height, this.#uploaded.kind, leveled);
    this.#last = { leveled, pixels: camera.width * camera.height };
    const encoder = this.#device.createCommandEncoder();
    this.#evaluate(encoder, scene.count, this.#uploaded);
    this.#project(encoder, scene.count, this.#uploaded);
    this.#splat(encoder, scene.count, this.#uploaded, sums[0], moments, leveled);
    if (leveled) {
      const formats = sumFormats(false, floats);
      this.#fill(encoder, this.#program.enlarge(2, formats), [...sums[0], ...sums[0]], sums[2], true, false);
      this.#fill(encoder, this.#program.enlarge(1, formats), [...sums[0], ...sums[2]], sums[1], false, false);
    }
    const read = sums.slice(0, 2).flat();
    this.#fill(encoder, this.#program.resolve(scene.sorted, format, leveled), read, [target], !leveled, true);
    queue.submit([encoder.finish()]);
  }

  /** @param {GPUCommandEncoder} encoder @param {number} count @param {Uploaded} uploaded */
  #evaluate(encoder, count, { kind, parts, network }) {
    if (network === null) return;
    const resources = { 0: this.#view, 1: parts.shapes, 4: parts.lobes, 5: network.weights, 6: network.lobes };
    const groups = Math.ceil(count / GAUSSIANS);
    this.#program.compute(encoder, this.#program.network(kind), resources, groups, this.#program.stamps("network"));
  }

  /** @param {GPUCommandEncoder} encoder @param {number} count @param {Uploaded} uploaded */
  #project(encoder, count, { kind, parts, looks, order, network }) {
    const lobes = network?.lobes ?? parts.lobes;
    const all = [this.#view, parts.shapes, parts.colors, lobes, looks];
    if (!kind.sorted) all.push(order, this.#drawn);
    const pipeline = this.#program.project(kind, this.variant);
    const groups = Math.ceil(count / BATCH);
    this.#program.compute(encoder, pipeline, numbered(all, 0), groups, this.#program.stamps("project"));
  }

  /**
   * @param {GPUCommandEncoder} encoder
   * @param {number} count
   * @param {Uploaded} uploaded
   * @param {GPUTextureView[]} sums
   * @param {GPUTextureView | null} moments the picture of a depth pass, which is computed first
   * @param {boolean} leveled
   */
  #splat(encoder, count, { kind, parts, looks, order }, sums, moments, leveled) {
    const nothing = { r: 0, g: 0, b: 0, a: 0 };
    /** @type {import("./webgpu_program.js").Resources} */
    const read = { 0: this.#view, 1: parts.shapes, 4: looks, 5: order };
    if (!kind.sorted) read[6] = this.#drawn;
    /**
     * @param {GPURenderPipeline} pipeline
     * @param {GPUTextureView[]} written
     * @param {GPUColor[]} clear
     * @param {GPURenderPassTimestampWrites} [timestampWrites]
     */
    const draw = (pipeline, written, clear, timestampWrites) => {
      const pass = encoder.beginRenderPass({
        colorAttachments: written.map((view, i) => ({ view, loadOp: "clear", storeOp: "store", clearValue: clear[i] })),
        timestampWrites,
      });
      pass.setPipeline(pipeline);
      pass.setBindGroup(0, this.#program.bind(pipeline, read));
      pass.setIndexBuffer(this.#corners, "uint16");
      if (this.variant.strips) {
        if (kind.sorted) pass.draw(4, count);
        else pass.drawIndirect(this.#drawn, 0);
      } else if (kind.sorted) pass.drawIndexed(6 * BATCH, Math.ceil(count / BATCH));
      else pass.drawIndexedIndirect(this.#drawn, 0);
      pass.end();
    };
    if (moments) {
      draw(this.#program.depths(kind, this.variant), [moments], [nothing], this.#program.stamps("splat", true, false));
      [read[2], read[3]] = [moments, this.#program.bilinear];
    }
    const clear = [{ ...nothing, a: kind.sorted ? 0 : 1 }, nothing]; // nothing is covered yet
    const stamps = this.#program.stamps("splat", moments === null);
    draw(this.#program.splat(kind, this.variant, leveled), sums, clear, stamps);
  }

  /**
   * Compute every pixel of textures from other ones, as a part of the resolve pass.
   *
   * @param {GPUCommandEncoder} encoder
   * @param {GPURenderPipeline} pipeline
   * @param {GPUTextureView[]} read
   * @param {GPUTextureView[]} written
   * @param {boolean} begin whether it is the first part
   * @param {boolean} end whether it is the last part
   */
  #fill(encoder, pipeline, read, written, begin, end) {
    /** @type {import("./webgpu_program.js").Resources} */
    const resources = { 0: this.#view, ...numbered(read, 1) };
    if (read.length === 4) resources[5] = this.#program.bilinear;
    this.#program.fill(encoder, pipeline, resources, written, this.#program.stamps("resolve", begin, end));
  }

  /**
   * @param {number} width
   * @param {number} height
   * @param {Kind} kind
   * @param {boolean} leveled
   */
  #sumsFor(width, height, { sorted, depthPass }, leveled) {
    const { floats } = this.variant;
    const key = `${width} ${height} ${sorted} ${leveled} ${floats} ${depthPass}`;
    if (this.#sums?.key === key) return this.#sums;
    for (const texture of this.#sums?.textures ?? []) texture.destroy();
    const usage = GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.TEXTURE_BINDING;
    /** @type {GPUTexture[]} */
    const textures = [];
    const made = (/** @type {number[]} */ size, /** @type {GPUTextureFormat} */ format) => {
      textures.push(this.#device.createTexture({ size, format, usage }));
      return textures[textures.length - 1].createView();
    };
    const coarse = levelSizes(width, height);
    const sizes = leveled ? [levelPlaces(width, height).size, ...coarse.slice(1, 3)] : [[width, height]];
    const views = sizes.map((size) => sumFormats(sorted, floats).map((format) => made(size, format)));
    const moments = depthPass ? made(coarse[PASS_LEVEL], this.#program.momentsFormat) : null;
    return (this.#sums = { key, textures, views, moments });
  }
}
