/** Draws all meshes of a scene into the current render pass of a WebGPURenderer, as webgl_stage.js does in WebGL2. */

import { PASS_LEVEL, levelPlaces, levelSizes } from "../render/levels.js";
import { BATCH, CORNERS } from "../render/quads.js";
import { strides } from "../render/types.js";
import { GAUSSIANS } from "../render/view_network.js";
import { VIEW_BYTES } from "../render/view_uniforms.js";
import { numbered } from "../render/webgpu_program.js";
import { frameOf, meshUniforms, nearestOf, passes } from "./placed_camera.js";
import { BLOCKS_FORMAT, LAYER_FORMATS, MeshProgram, SUMS_DEPTH } from "./webgpu_passes.js";
import { BLOCKS, DEPTH, LAYERS, PICTURE, PLACED, PLACED_BYTES, WIDE_BLOCKS } from "./webgpu_texts.js";

/** @typedef {import("three").Camera} ThreeCamera */
/** @typedef {import("./mobile_gs_mesh.js").MobileGSMesh} MobileGSMesh */
/** @typedef {import("./placed_camera.js").Frame} Frame */
/** @typedef {import("./webgpu_passes.js").Attachments} Attachments */
/** @typedef {import("./webgpu_passes.js").Kept} Kept */
/** @typedef {import("../render/types.js").Part} Part */
/** @typedef {import("../render/types.js").SceneData} SceneData */
/** @typedef {import("../render/types.js").Variant} Variant */
/** @typedef {import("../render/webgpu_program.js").Resources} Resources */
/**
 * A mesh's scene on a device.
 *
 * @typedef {object} Splats
 * @property {SceneData} data that was uploaded
 * @property {number} applied changes that were uploaded
 * @property {Record<Part, GPUBuffer>} parts
 * @property {GPUBuffer} looks
 * @property {GPUBuffer} list of visible Gaussians
 * @property {GPUBuffer} drawn arguments of the indirect draw
 * @property {{weights: GPUBuffer, lobes: GPUBuffer} | null} network weights, and results
 * @property {Map<ThreeCamera, GPUBuffer>} views uniforms of each camera: a nested render call must not change them
 */
/**
 * Textures of one size.
 *
 * @typedef {object} Targets
 * @property {string} key
 * @property {GPUTexture[]} all
 * @property {GPUTextureView[][]} sums of all levels; then of levels 1 and 2 with the coarser ones
 * @property {GPUTextureView} depth of the sums
 * @property {GPUTextureView[]} blocks
 */
/**
 * The layers of a picture: colours and proximities.
 *
 * @typedef {object} Layers
 * @property {string} key
 * @property {GPUTexture[]} all
 * @property {GPUTextureView[]} arrays
 * @property {GPUTextureView[][]} slices of each layer
 */

const DRAWN_BYTES = 24; // of Drawn in project.wgsl
const LOOK_BYTES = 8;
const PARTS = /** @type {Part[]} */ (["shapes", "colors", "lobes"]);
const KIND = { sorted: false, packed: true, network: true, depthPass: false };

export class WebGpuStage {
  /** Of `selectVariant`. */
  api = /** @type {const} */ ("webgpu");
  /** The way to draw meshes that name none. */
  variant = { floats: false, strips: false };

  #renderer;
  #backend;
  /** @type {GPUDevice} */
  #device;
  #shaders;
  /** By whether the depth of opaque meshes is multisampled. @type {Map<boolean, MeshProgram>} */
  #programs = new Map();
  /** @type {Map<MobileGSMesh, Splats>} */
  #splats = new Map();
  /** @type {Targets | null} */
  #targets = null;
  /** @type {Layers | null} */
  #layers = null;
  /** The picture of a depth pass. @type {GPUTexture | null} */
  #moments = null;
  /** A copy of the framebuffer's colours. @type {GPUTexture | null} */
  #picture = null;
  /** Of each camera. @type {Map<ThreeCamera, GPUBuffer>} */
  #placed = new Map();
  #corners;
  #reset;

  /**
   * @param {any} renderer a WebGPURenderer with the WebGPU backend
   * @param {Record<string, string>} shaders WGSL by name
   */
  constructor(renderer, shaders) {
    this.#renderer = renderer;
    this.#backend = renderer.backend;
    this.#device = renderer.backend.device;
    this.#shaders = shaders;
    const use = GPUBufferUsage;
    this.#corners = this.#program(false).filled(CORNERS, use.INDEX);
    /** The arguments before anything is listed, by whether an instance is a quad. */
    this.#reset = [6 * BATCH, 4].map((vertices) =>
      this.#program(false).filled(Uint32Array.of(vertices, 0, 0, 0, 0, 0), use.COPY_SRC),
    );
  }

  /** Why a mesh cannot be drawn here, or null. @param {MobileGSMesh} mesh */
  refusal(mesh) {
    const { maxStorageBufferBindingSize: most } = this.#device.limits;
    const needed = Math.max(...PARTS.map((part) => mesh.data?.[part].byteLength ?? 0));
    if (needed <= most) return null;
    const [asked, given] = [needed, most].map((bytes) => Math.ceil(bytes / 2 ** 20));
    return (
      `this scene needs ${asked} MiB in one buffer and the renderer allows ${given}: create it with ` +
      "requiredLimits: { maxStorageBufferBindingSize, maxBufferSize }"
    );
  }

  /** True if nothing is uploaded any more. */
  get empty() {
    return this.#splats.size === 0;
  }

  /** Free the resources of a mesh. @param {MobileGSMesh} mesh */
  forget(mesh) {
    const splats = this.#splats.get(mesh);
    if (!splats) return;
    this.#splats.delete(mesh);
    const { parts, looks, list, drawn, network, views } = splats;
    const buffers = [...Object.values(parts), looks, list, drawn, ...Object.values(network ?? {}), ...views.values()];
    for (const buffer of buffers) buffer.destroy();
  }

  /** Free all resources. */
  destroy() {
    for (const mesh of [...this.#splats.keys()]) this.forget(mesh);
    for (const buffer of [this.#corners, ...this.#reset, ...this.#placed.values()]) buffer.destroy();
    for (const program of this.#programs.values()) program.destroy();
    const textures = [...(this.#targets?.all ?? []), ...(this.#layers?.all ?? []), this.#moments, this.#picture];
    for (const texture of textures) texture?.destroy();
  }

  /**
   * Draw meshes, all of which have a scene.
   *
   * @param {MobileGSMesh[][]} layers the meshes of each
   * @param {ThreeCamera} camera
   * @param {{tested: boolean, keeps: boolean}} depths whether the framebuffer may have some, and whether the meshes
   *     write theirs
   */
  draw(layers, camera, depths) {
    const backend = this.#backend;
    const context = this.#renderer._currentRenderContext;
    const data = backend.get(context);
    const { encoder, descriptor } = data;
    const { x, y, width, height } = context.viewportValue;
    // passes of layers are recorded for later
    if (!data.currentPass || !(width > 0 && height > 0)) return;
    data.currentPass.end();
    const finish = this.#sum(encoder, context, layers, camera, depths);
    // go on with the pass, as three.js does after it has copied a framebuffer
    for (const attachment of descriptor.colorAttachments) attachment.loadOp = "load";
    if (context.depth) descriptor.depthStencilAttachment.depthLoadOp = "load";
    if (context.stencil) descriptor.depthStencilAttachment.stencilLoadOp = "load";
    const pass = (data.currentPass = encoder.beginRenderPass(descriptor));
    pass.setViewport(x, y, width, height, 0, 1);
    if (context.scissor) backend.updateScissor(context);
    finish(pass);
    if (context.viewport) backend.updateViewport(context);
    else pass.setViewport(0, 0, context.width, context.height, 0, 1);
    // what three.js believes to be set in the pass
    if (backend._resetRenderContextData) backend._resetRenderContextData(data);
    else data.currentSets = { attributes: {}, bindingGroups: [], pipeline: null, index: null }; // before 0.187
  }

  /**
   * Add the splats of each layer up; returns a function that draws the picture in a pass of three.js.
   *
   * @param {GPUCommandEncoder} encoder
   * @param {any} context of three.js
   * @param {MobileGSMesh[][]} layers
   * @param {ThreeCamera} camera
   * @param {{tested: boolean, keeps: boolean}} depths
   * @returns {(pass: GPURenderPassEncoder) => void}
   */
  #sum(encoder, context, layers, camera, { tested, keeps }) {
    const meshes = layers.flat();
    const { x, y, width, height } = context.viewportValue;
    const { color, depth } = this.#framebuffer(context);
    const attachments = this.#attachments(context, color, depth);
    const program = this.#program(attachments.samples > 1 && depth !== null);
    keeps &&= depth !== null;
    const several = layers.length > 1;
    const variant = { ...(meshes[0].variant ?? this.variant), moments: several ? 3 : keeps ? 2 : 1 };
    variant.floats &&= program.blendsFloats;
    const most = this.#device.limits.maxTextureDimension2D;
    const { frame, fine, sigmas, leveled } = frameOf(meshes, camera, { width, height, upward: false }, variant.floats, most);
    const targets = this.#targetsOf(fine.width, fine.height, leveled, variant);
    const moments = meshes.some(passes) ? this.#momentsOf(fine, program.momentsFormat) : null;
    const all = new Map(meshes.map((mesh, i) => [mesh, this.#uploaded(mesh, frame, sigmas[i], program)]));
    const viewOf = (/** @type {MobileGSMesh} */ mesh) => /** @type {GPUBuffer} */ (all.get(mesh)?.views.get(camera));
    const view = viewOf(meshes[0]);
    // a multisampled depth that is not stored cannot be read
    tested &&= depth !== null && (depth.usage & GPUTextureUsage.TEXTURE_BINDING) !== 0;
    const edges = tested && attachments.samples > 1;
    const scene = tested ? depth?.createView({ aspect: "depth-only" }) : null;
    const placed = this.#placedOf(camera, x, y);
    if (tested && scene && leveled) {
      for (const level of [0, 1]) {
        /** @type {Resources} */
        const read = level ? { [BLOCKS]: targets.blocks[0] } : { 0: view, [PLACED]: placed, [DEPTH]: scene };
        program.fill(encoder, program.blocks(level), read, [targets.blocks[level]]);
      }
    }
    for (const splats of all.values()) this.#list(encoder, program, splats, camera, variant, tested && leveled ? targets.blocks : null);
    /** @type {Resources} */
    const meshDepth = tested && scene ? { [PLACED]: placed, [DEPTH]: scene } : {};
    const sums = numbered(leveled ? [...targets.sums[0], ...targets.sums[1]] : targets.sums[0], 1);
    /** @type {Resources} */
    const read = leveled ? { ...sums, 5: program.bilinear } : sums;
    const resolved = several ? this.#layersOf(width, height, layers.length) : null;
    /**
     * @param {GPURenderPassEncoder} pass
     * @param {MobileGSMesh} mesh
     * @param {GPURenderPipeline} pipeline
     * @param {Resources} more
     */
    const quads = (pass, mesh, pipeline, more) => {
      const { parts, looks, list, drawn } = /** @type {Splats} */ (all.get(mesh));
      pass.setPipeline(pipeline);
      pass.setIndexBuffer(this.#corners, "uint16");
      const own = { 0: viewOf(mesh), 1: parts.shapes, 4: looks, 5: list, 6: drawn };
      pass.setBindGroup(0, program.bind(pipeline, { ...own, ...meshDepth, ...more }));
      if (variant.strips) pass.drawIndirect(drawn, 0);
      else pass.drawIndexedIndirect(drawn, 0);
    };
    layers.forEach((layer, i) => {
      const passing = layer.filter(passes);
      if (passing.length && moments) {
        const colorAttachments = [{ view: moments, loadOp: /** @type {const} */ ("clear"), storeOp: /** @type {const} */ ("store") }];
        const pass = encoder.beginRenderPass({ colorAttachments });
        for (const mesh of passing) quads(pass, mesh, program.depthsBefore(variant, tested), {});
        pass.end();
      }
      const pass = encoder.beginRenderPass({
        colorAttachments: targets.sums[0].map((target, index) => ({
          view: target,
          loadOp: "clear",
          storeOp: "store",
          clearValue: { r: 0, g: 0, b: 0, a: index ? 0 : 1 }, // nothing is covered yet
        })),
        depthStencilAttachment: tested
          ? {
              view: targets.depth,
              depthLoadOp: i ? "load" : "clear",
              depthStoreOp: edges || several ? "store" : "discard",
              depthClearValue: 0,
            }
          : undefined,
      });
      if (tested && i === 0) {
        const nearness = program.nearness(variant);
        pass.setPipeline(nearness);
        pass.setBindGroup(0, program.bind(nearness, { 0: view, ...meshDepth }));
        pass.draw(3);
      }
      for (const mesh of layer) {
        /** @type {Resources} */
        const seen = moments && passes(mesh) ? { 2: moments, 3: program.bilinear } : {};
        quads(pass, mesh, program.add(variant, leveled, tested, passes(mesh)), seen);
      }
      pass.end();
      if (leveled) this.#enlarge(encoder, program, view, targets, variant);
      if (resolved) program.fill(encoder, program.layer(leveled), { 0: viewOf(layer[0]), ...read }, resolved.slices[i]);
    });
    const picture = this.#copy(encoder, color, x, y, width, height);
    const shown = resolved ? numbered(resolved.arrays, LAYERS) : read;
    return (pass) => {
      /** @type {import("./webgpu_passes.js").Way[]} */
      const ways = edges ? ["samples", "behind edges"] : ["over"];
      if (keeps) ways.push("depth");
      for (const way of ways) {
        const pipeline = program.over(way, attachments, several ? "layers" : leveled ? "levels" : "sums");
        /** @type {Resources} */
        const more = way === "depth" ? {} : { [PICTURE]: picture.createView() };
        if (edges && way !== "depth") more[DEPTH] = targets.depth;
        pass.setPipeline(pipeline);
        pass.setBindGroup(0, program.bind(pipeline, { 0: view, [PLACED]: placed, ...shown, ...more }));
        pass.draw(3);
      }
    };
  }

  /**
   * Compute levels 1 and 2 with the coarser ones.
   *
   * @param {GPUCommandEncoder} encoder
   * @param {MeshProgram} program
   * @param {GPUBuffer} view
   * @param {Targets} targets
   * @param {Kept} kept
   */
  #enlarge(encoder, program, view, { sums }, kept) {
    for (const [level, coarser] of [[2, 0], [1, 2]]) {
      const read = { 0: view, ...numbered([...sums[0], ...sums[coarser]], 1), 5: program.bilinear };
      program.fill(encoder, program.enlarge(level, MeshProgram.sums(kept)), read, sums[level]);
    }
  }

  /**
   * The textures that three.js draws into: resolved colours, and the depth or null.
   *
   * @param {any} context
   * @returns {{color: GPUTexture, depth: GPUTexture | null}}
   */
  #framebuffer(context) {
    const backend = this.#backend;
    if (context.textures !== null) {
      const depth = context.depth ? backend.get(context.depthTexture).texture : null;
      return { color: backend.get(context.textures[0]).texture, depth };
    }
    const depth = context.depth ? backend.textureUtils.getDepthBuffer(context.depth, context.stencil) : null;
    return { color: backend.context.getCurrentTexture(), depth };
  }

  /** @param {any} context @param {GPUTexture} color @param {GPUTexture | null} depth @returns {Attachments} */
  #attachments(context, color, depth) {
    const backend = this.#backend;
    const colors = context.textures?.map((/** @type {any} */ texture) => backend.get(texture).texture.format);
    const samples = backend.utils.getSampleCountRenderContext(context);
    const reversed = this.#renderer.reversedDepthBuffer === true;
    return { colors: colors ?? [color.format], depth: depth?.format ?? null, samples, reversed };
  }

  /** @param {boolean} multisampled */
  #program(multisampled) {
    const program = this.#programs.get(multisampled) ?? new MeshProgram(this.#device, this.#shaders, multisampled);
    this.#programs.set(multisampled, program);
    return program;
  }

  /**
   * Uniforms of `Placed`.
   *
   * @param {ThreeCamera} camera
   * @param {number} x
   * @param {number} y
   */
  #placedOf(camera, x, y) {
    const p = camera.projectionMatrix.elements;
    const nearest = nearestOf(camera);
    const { far = 1000 } = /** @type {{far?: number}} */ (/** @type {unknown} */ (camera));
    const reversed = this.#renderer.reversedDepthBuffer === true;
    const log = this.#renderer.logarithmicDepthBuffer === true ? Math.log2(far / nearest) : 0;
    const floats = Float32Array.of(nearest / p[14], (nearest * p[10]) / p[14], reversed ? 0 : 1, log, 0, 0, 0, 0);
    new Int32Array(floats.buffer).set([x, y], 4);
    return this.#write(this.#placed, camera, floats, PLACED_BYTES);
  }

  /**
   * Write a camera's uniform buffer.
   *
   * @param {Map<ThreeCamera, GPUBuffer>} buffers
   * @param {ThreeCamera} camera
   * @param {Float32Array<ArrayBuffer>} floats
   * @param {number} size
   */
  #write(buffers, camera, floats, size) {
    const usage = GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST;
    const buffer = buffers.get(camera) ?? this.#device.createBuffer({ size, usage });
    buffers.set(camera, buffer);
    this.#device.queue.writeBuffer(buffer, 0, floats);
    return buffer;
  }

  /**
   * Upload what has changed in a mesh, and its uniforms.
   *
   * @param {MobileGSMesh} mesh
   * @param {Frame} frame
   * @param {number} levelSigma
   * @param {MeshProgram} program
   */
  #uploaded(mesh, frame, levelSigma, program) {
    const data = /** @type {SceneData} */ (mesh.data);
    let splats = this.#splats.get(mesh);
    if (splats?.data !== data) {
      this.forget(mesh);
      splats = this.#upload(data, mesh.changes.length, program);
      this.#splats.set(mesh, splats);
    }
    for (; splats.applied < mesh.changes.length; splats.applied++) {
      const { part, from, count } = mesh.changes[splats.applied];
      const stride = strides(data)[part];
      const numbers = data[part].subarray(stride * from, stride * (from + count));
      this.#device.queue.writeBuffer(splats.parts[part], 4 * stride * from, numbers);
    }
    this.#write(splats.views, frame.camera, meshUniforms(frame, mesh, data, mesh.near, levelSigma), VIEW_BYTES);
    return splats;
  }

  /** @param {SceneData} data @param {number} applied @param {MeshProgram} program @returns {Splats} */
  #upload(data, applied, program) {
    const total = Math.max(1, data.shapes.length / strides(data).shapes);
    const use = GPUBufferUsage;
    const filled = (/** @type {Part} */ part) =>
      program.filled(data[part].length ? data[part] : new Uint32Array(16), use.STORAGE | use.COPY_DST);
    const storage = (/** @type {number} */ size, more = 0) =>
      this.#device.createBuffer({ size, usage: use.STORAGE | more });
    return {
      data,
      applied,
      parts: { shapes: filled("shapes"), colors: filled("colors"), lobes: filled("lobes") },
      looks: storage(LOOK_BYTES * total),
      list: storage(4 * total),
      drawn: storage(DRAWN_BYTES, use.INDIRECT | use.COPY_DST),
      network: data.network
        ? { weights: program.weights(data.network), lobes: storage(4 * total) }
        : null,
      views: new Map(),
    };
  }

  /**
   * List the visible Gaussians of a mesh.
   *
   * @param {GPUCommandEncoder} encoder
   * @param {MeshProgram} program
   * @param {Splats} splats
   * @param {ThreeCamera} camera
   * @param {Variant} variant
   * @param {GPUTextureView[] | null} blocks null: the depth does not change levels
   */
  #list(encoder, program, { data, parts, looks, list, drawn, network, views }, camera, variant, blocks) {
    const view = /** @type {GPUBuffer} */ (views.get(camera));
    encoder.copyBufferToBuffer(this.#reset[Number(variant.strips)], 0, drawn, 0, DRAWN_BYTES);
    if (network) {
      const read = { 0: view, 1: parts.shapes, 4: parts.lobes, 5: network.weights, 6: network.lobes };
      program.compute(encoder, program.network(KIND), read, Math.ceil(data.count / GAUSSIANS));
    }
    const lobes = network?.lobes ?? parts.lobes;
    /** @type {Resources} */
    const all = numbered([view, parts.shapes, parts.colors, lobes, looks, list, drawn], 0);
    if (blocks) [all[BLOCKS], all[WIDE_BLOCKS]] = blocks;
    program.compute(encoder, program.list(variant, blocks !== null), all, Math.ceil(data.count / BATCH));
  }

  /**
   * Copy the colours of the framebuffer, which is read and drawn into.
   *
   * @param {GPUCommandEncoder} encoder
   * @param {GPUTexture} color
   * @param {number} x
   * @param {number} y
   * @param {number} width
   * @param {number} height
   */
  #copy(encoder, color, x, y, width, height) {
    const old = this.#picture;
    const alike = old?.width === color.width && old.height === color.height && old.format === color.format;
    if (!old || !alike) {
      old?.destroy();
      const usage = GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST;
      this.#picture = this.#device.createTexture({ size: [color.width, color.height], format: color.format, usage });
    }
    const texture = /** @type {GPUTexture} */ (this.#picture);
    const origin = [x, y];
    encoder.copyTextureToTexture({ texture: color, origin }, { texture, origin }, [width, height]);
    return texture;
  }

  /**
   * @param {number} width
   * @param {number} height
   * @param {boolean} leveled
   * @param {Kept} kept
   * @returns {Targets}
   */
  #targetsOf(width, height, leveled, kept) {
    const formats = MeshProgram.sums(kept);
    const key = `${width} ${height} ${leveled} ${formats}`;
    if (this.#targets?.key === key) return this.#targets;
    for (const texture of this.#targets?.all ?? []) texture.destroy();
    /** @type {GPUTexture[]} */
    const all = [];
    const made = (/** @type {number[]} */ size, /** @type {GPUTextureFormat} */ format) => {
      all.push(this.#texture(size, format));
      return all[all.length - 1].createView();
    };
    const place = leveled ? levelPlaces(width, height).size : [width, height];
    const coarse = leveled ? levelSizes(width, height).slice(1, 3) : [];
    const sums = [place, ...coarse].map((size) => formats.map((format) => made(size, format)));
    const depth = made(place, SUMS_DEPTH);
    const sides = [8, 64].map((side) => [Math.ceil(width / side), Math.ceil(height / side)]);
    const blocks = sides.map((size) => made(size, BLOCKS_FORMAT));
    return (this.#targets = { key, all, sums, depth, blocks });
  }

  /** The picture of a depth pass. @param {{width: number, height: number}} image @param {GPUTextureFormat} format */
  #momentsOf(image, format) {
    const [width, height] = levelSizes(image.width, image.height)[PASS_LEVEL];
    if (this.#moments?.width !== width || this.#moments.height !== height || this.#moments.format !== format) {
      this.#moments?.destroy();
      this.#moments = this.#texture([width, height], format);
    }
    return this.#moments.createView();
  }

  /** @param {number} width @param {number} height @param {number} count of layers @returns {Layers} */
  #layersOf(width, height, count) {
    const key = `${width} ${height} ${count}`;
    if (this.#layers?.key === key) return this.#layers;
    for (const texture of this.#layers?.all ?? []) texture.destroy();
    const all = LAYER_FORMATS.map((format) => this.#texture([width, height, count], format));
    const slices = Array.from({ length: count }, (_, baseArrayLayer) =>
      all.map((texture) => texture.createView({ dimension: "2d", baseArrayLayer, arrayLayerCount: 1 })),
    );
    return (this.#layers = { key, all, arrays: all.map((texture) => texture.createView()), slices });
  }

  /** @param {number[]} size @param {GPUTextureFormat} format */
  #texture(size, format) {
    const usage = GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.TEXTURE_BINDING;
    return this.#device.createTexture({ size, format, usage });
  }
}
