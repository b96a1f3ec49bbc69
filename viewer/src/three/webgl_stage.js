/**
 * Draws all meshes of a scene into the current framebuffer of a WebGLRenderer.
 *
 * The splats of a layer are added up in two textures; opaque meshes hide them, by a copy of their depth. Then the
 * sums are drawn over the framebuffer. Of several layers, each is resolved into textures of its own first, and a
 * pixel composites them by their depths.
 */

import { Vector4 } from "three";
import { LEVELS, PASS_LEVEL, levelPlaces, levelSizes } from "../render/levels.js";
import { BATCH, CORNERS } from "../render/quads.js";
import { strides } from "../render/types.js";
import { VIEW_BYTES } from "../render/view_uniforms.js";
import { TARGETS, blendsFloats, maker } from "../render/webgl_program.js";
import { PACKED, Textures, extent } from "../render/webgl_textures.js";
import { frameOf, meshUniforms, nearestOf, passes } from "./placed_camera.js";
import { COLOR_UNIT, DEPTH_UNIT, FramebufferCopy } from "./webgl_copy.js";
import { BLOCKS_UNIT, DepthBlocks, WIDE_BLOCKS_UNIT } from "./webgl_blocks.js";
import { LAYER_UNITS, LayerTextures } from "./webgl_layers.js";
import { BLOCKS, LAYER, MESHES, NEARNESS, OVER } from "./webgl_texts.js";

/** @typedef {import("three").WebGLRenderer} WebGLRenderer */
/** @typedef {import("three").Camera} ThreeCamera */
/** @typedef {import("./mobile_gs_mesh.js").MobileGSMesh} MobileGSMesh */
/** @typedef {import("./placed_camera.js").Frame} Frame */
/** @typedef {import("../render/types.js").Part} Part */
/** @typedef {import("../render/types.js").SceneData} SceneData */
/**
 * The state of three.js that a frame depends on.
 *
 * @typedef {object} State
 * @property {WebGLFramebuffer | null} framebuffer
 * @property {import("three").WebGLRenderTarget | null} target
 * @property {boolean} reversed whether larger depths are nearer
 * @property {boolean} scissored
 * @property {boolean} tested whether the framebuffer may have depths
 * @property {boolean} keeps whether the meshes write their depth
 */
/**
 * A mesh's scene in a context.
 *
 * @typedef {object} Splats
 * @property {SceneData} data that was uploaded
 * @property {number} applied changes that were uploaded
 * @property {Textures} textures
 * @property {WebGLFramebuffer} looks output of the project pass
 * @property {WebGLBuffer} view the uniform block
 */

const PARTS = /** @type {Part[]} */ (["shapes", "colors", "lobes"]);
const viewport = new Vector4();

export class WebGlStage {
  /** Of `selectVariant`. */
  api = /** @type {const} */ ("webgl");
  /** The way to draw meshes that name none. */
  variant = { floats: false, strips: false };

  #renderer;
  #gl;
  #shaders;
  #binding; // of the uniform block; three.js uses the first ones
  /** Quads of a batch. @type {{corners: WebGLBuffer, array: WebGLVertexArrayObject} | null} */
  #quads = null;
  #copy;
  #blocks;
  #layers;
  /** @type {Map<string, WebGLProgram>} */
  #programs = new Map();
  /** @type {Map<MobileGSMesh, Splats>} */
  #splats = new Map();
  /** Of all levels, then of levels 1 and 2 with the coarser ones. */
  #sums;
  #depths; // output of the depth pass
  #depth;
  #textures;
  #key = ""; // size and format of the textures of the sums
  #passKey = ""; // size of the picture of the depth pass

  /**
   * @param {WebGLRenderer} renderer
   * @param {Record<string, string>} shaders GLSL by name
   */
  constructor(renderer, shaders) {
    const gl = /** @type {WebGL2RenderingContext} */ (renderer.getContext());
    if (!TARGETS.map((name) => gl.getExtension(name)).some(Boolean)) {
      throw new Error("this GPU cannot draw into textures of floats");
    }
    this.#renderer = renderer;
    this.#gl = gl;
    this.#shaders = shaders;
    this.#binding = gl.getParameter(gl.MAX_UNIFORM_BUFFER_BINDINGS) - 1;
    this.#copy = new FramebufferCopy(gl);
    this.#blocks = new DepthBlocks(gl);
    this.#layers = new LayerTextures(gl);
    this.#sums = [gl.createFramebuffer(), gl.createFramebuffer(), gl.createFramebuffer()];
    this.#depths = gl.createFramebuffer();
    this.#depth = gl.createRenderbuffer();
    this.#textures = new Textures(gl);
  }

  /** Why a mesh cannot be drawn here, or null. @param {MobileGSMesh} mesh */
  refusal(mesh) {
    if (!mesh.data?.network) return null;
    return "this scene needs a network for every Gaussian in every frame, which takes WebGPURenderer";
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
    splats.textures.destroy();
    this.#gl.deleteFramebuffer(splats.looks);
    this.#gl.deleteBuffer(splats.view);
  }

  /** Free all resources. */
  destroy() {
    const gl = this.#gl;
    for (const mesh of [...this.#splats.keys()]) this.forget(mesh);
    for (const program of this.#programs.values()) gl.deleteProgram(program);
    this.#copy.destroy();
    this.#blocks.destroy();
    this.#layers.destroy();
    this.#textures.destroy();
    for (const framebuffer of [this.#depths, ...this.#sums]) gl.deleteFramebuffer(framebuffer);
    gl.deleteRenderbuffer(this.#depth);
    gl.deleteVertexArray(this.#quads?.array ?? null);
    gl.deleteBuffer(this.#quads?.corners ?? null);
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
    const [gl, renderer] = [this.#gl, this.#renderer];
    const target = renderer.getRenderTarget();
    const [face, mip] = [renderer.getActiveCubeFace(), renderer.getActiveMipmapLevel()];
    renderer.getCurrentViewport(viewport);
    if (viewport.z < 1 || viewport.w < 1) return; // a headset's second eye may have none
    const buffers = /** @type {any} */ (renderer.state.buffers);
    const reversed = buffers.depth.getReversed?.() ?? false; // older versions of three.js cannot
    if (reversed) buffers.depth.setReversed(false);
    const framebuffer = gl.getParameter(gl.DRAW_FRAMEBUFFER_BINDING);
    const scissored = gl.isEnabled(gl.SCISSOR_TEST);
    const convention = gl.getExtension("WEBGL_provoking_vertex");
    convention?.provokingVertexWEBGL(convention.FIRST_VERTEX_CONVENTION_WEBGL);
    const others = [gl.SCISSOR_TEST, gl.CULL_FACE, gl.STENCIL_TEST, gl.POLYGON_OFFSET_FILL, gl.SAMPLE_ALPHA_TO_COVERAGE];
    for (const what of [...others, gl.BLEND, gl.DEPTH_TEST, gl.DITHER]) gl.disable(what);
    gl.colorMask(true, true, true, true);
    gl.blendEquation(gl.FUNC_ADD);
    // three.js leaves these as its last texture had them
    for (const what of [gl.UNPACK_FLIP_Y_WEBGL, gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL]) gl.pixelStorei(what, false);
    for (const what of [gl.UNPACK_ROW_LENGTH, gl.UNPACK_SKIP_PIXELS, gl.UNPACK_SKIP_ROWS]) gl.pixelStorei(what, 0);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    this.#bindQuads();
    try {
      this.#draw(layers, camera, { framebuffer, target, reversed, scissored, ...depths });
    } finally {
      convention?.provokingVertexWEBGL(convention.LAST_VERTEX_CONVENTION_WEBGL);
      gl.bindVertexArray(null);
      gl.enable(gl.DITHER);
      renderer.resetState();
      if (reversed) {
        buffers.depth.setReversed(true);
        buffers.depth.setClear(1);
      }
      renderer.setRenderTarget(target, face, mip);
      renderer.state.viewport(viewport); // that of one eye in WebXR
    }
  }

  /**
   * @param {MobileGSMesh[][]} layers
   * @param {ThreeCamera} camera
   * @param {State} state
   */
  #draw(layers, camera, { framebuffer, target, reversed, scissored, tested, keeps }) {
    const gl = this.#gl;
    const { x, y, z: width, w: height } = viewport;
    const meshes = layers.flat();
    const { strips, ...wanted } = meshes[0].variant ?? this.variant;
    const floats = wanted.floats && blendsFloats(gl);
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    const { frame, fine, sigmas, leveled } = frameOf(meshes, camera, { width, height, upward: true }, floats, most);
    const several = layers.length > 1;
    const size = this.#resize(fine.width, fine.height, leveled, floats, several ? 3 : keeps ? 2 : 1, meshes.some(passes));
    const all = new Map(meshes.map((mesh, i) => [mesh, this.#uploaded(mesh, frame, sigmas[i])]));

    const opaque = /** @type {any} */ (target)?.isXRRenderTarget === true;
    const area = [x, y, x + width, y + height];
    const output = target === null ? this.#renderer.outputColorSpace : opaque ? target.texture.colorSpace : "";
    const linear = output !== "srgb";
    tested &&= this.#copy.depth(framebuffer, area, opaque);
    if (linear) this.#copy.color(framebuffer, area, opaque);
    const kind = { strips, leveled };
    if (several) this.#layers.resize(width, height, layers.length);

    gl.useProgram(this.#program("project", kind));
    for (const splats of all.values()) this.#project(splats);

    const toNearness = this.#toNearness(camera, reversed);
    /** @param {WebGLProgram} program */
    const use = (program) => {
      gl.useProgram(program);
      gl.uniform2i(gl.getUniformLocation(program, "first"), x, y);
      gl.uniform4fv(gl.getUniformLocation(program, "to_nearness"), toNearness);
    };
    if (tested && leveled) this.#blocks.draw(fine, (level) => use(this.#program("blocks", kind, level ? ["WIDE"] : [])));
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#sums[0]);
    gl.viewport(0, 0, size[0], size[1]);
    gl.depthMask(true);
    if (tested) {
      gl.enable(gl.DEPTH_TEST);
      gl.depthFunc(gl.ALWAYS);
      gl.drawBuffers([gl.NONE, gl.NONE]);
      use(this.#program("nearness", kind));
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
    const hiding = tested ? ["MESHES"] : [];
    /** @param {MobileGSMesh} mesh @param {string[]} words */
    const quads = (mesh, words) => {
      const splats = /** @type {Splats} */ (all.get(mesh));
      const of = words.includes("DEPTH_PASS") ? { strips, leveled: false } : kind;
      use(this.#program("splat", of, [...words, ...hiding]));
      this.#bind(splats);
      const { count } = splats.data;
      if (strips) gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
      else gl.drawElementsInstanced(gl.TRIANGLES, 6 * BATCH, gl.UNSIGNED_SHORT, 0, Math.ceil(count / BATCH));
    };
    const added = several || keeps ? ["MOMENTS"] : [];
    layers.forEach((layer, i) => {
      const passing = layer.filter(passes);
      if (passing.length) {
        const [across, down] = levelSizes(fine.width, fine.height)[PASS_LEVEL];
        gl.disable(gl.DEPTH_TEST);
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.#depths);
        gl.viewport(0, 0, across, down);
        gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
        gl.enable(gl.BLEND);
        gl.blendFunc(gl.ONE, gl.ONE);
        for (const mesh of passing) quads(mesh, ["DEPTH_PASS"]);
      }
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.#sums[0]);
      gl.viewport(0, 0, size[0], size[1]);
      if (tested) gl.enable(gl.DEPTH_TEST);
      gl.depthMask(false);
      gl.depthFunc(gl.GREATER);
      gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
      gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 1]); // nothing is covered yet
      gl.clearBufferfv(gl.COLOR, 1, [0, 0, 0, 0]);
      gl.enable(gl.BLEND);
      gl.blendFuncSeparate(gl.ONE, gl.ONE, gl.ZERO, gl.ONE_MINUS_SRC_ALPHA);
      this.#textures.bind();
      for (const mesh of layer) quads(mesh, [...added, ...(passes(mesh) ? ["VISIBLE"] : [])]);
      gl.disable(gl.DEPTH_TEST);
      gl.disable(gl.BLEND);
      if (leveled) this.#enlarge(kind, fine);
      if (!several) return;
      this.#layers.attach(i);
      gl.viewport(0, 0, width, height);
      gl.useProgram(this.#program("layer", kind));
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    });

    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(x, y, width, height);
    if (scissored) gl.enable(gl.SCISSOR_TEST);
    if (framebuffer !== null) gl.drawBuffers([gl.COLOR_ATTACHMENT0]);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const edges = tested && gl.getParameter(gl.SAMPLES) > 1;
    if (several) this.#layers.bind();
    const words = several ? ["LAYERS"] : [];
    /** @param {WebGLProgram} program */
    const useOver = (program) => {
      use(program);
      gl.uniform1i(gl.getUniformLocation(program, "layers"), layers.length);
    };
    const over = this.#program("over", kind, [...words, ...(linear ? ["LINEAR"] : []), ...(edges ? ["EDGES"] : [])]);
    useOver(over);
    if (edges) {
      gl.enable(gl.DEPTH_TEST);
      gl.depthMask(false);
      const compare = reversed ? [gl.LEQUAL, gl.GREATER] : [gl.GEQUAL, gl.LESS];
      for (const behind of [false, true]) {
        gl.depthFunc(compare[Number(behind)]);
        gl.uniform1i(gl.getUniformLocation(over, "behind_edges"), Number(behind));
        gl.drawArrays(gl.TRIANGLES, 0, 3);
      }
    } else gl.drawArrays(gl.TRIANGLES, 0, 3);
    if (!keeps) return;
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.ALWAYS);
    gl.depthMask(true);
    gl.colorMask(false, false, false, false);
    useOver(this.#program("over", kind, [...words, "DEPTH"]));
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  #bindQuads() {
    const gl = this.#gl;
    if (this.#quads) {
      gl.bindVertexArray(this.#quads.array);
      return;
    }
    this.#quads = { array: gl.createVertexArray(), corners: gl.createBuffer() };
    gl.bindVertexArray(this.#quads.array);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.#quads.corners);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, CORNERS, gl.STATIC_DRAW);
  }

  /** Compute the looks of all Gaussians. @param {Splats} splats */
  #project(splats) {
    const gl = this.#gl;
    this.#bind(splats);
    gl.bindFramebuffer(gl.FRAMEBUFFER, splats.looks);
    const [width, height] = extent(splats.data.count);
    gl.viewport(0, 0, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** @param {Splats} splats */
  #bind({ textures, view }) {
    textures.bind();
    this.#gl.bindBufferBase(this.#gl.UNIFORM_BUFFER, this.#binding, view);
  }

  /** @param {{strips: boolean, leveled: boolean}} kind @param {{width: number, height: number}} fine */
  #enlarge(kind, { width, height }) {
    const gl = this.#gl;
    const sizes = levelSizes(width, height);
    for (const level of [2, 1]) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.#sums[level]);
      gl.viewport(0, 0, sizes[level][0], sizes[level][1]);
      gl.useProgram(this.#program("enlarge", kind, [`LEVEL ${level}`]));
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
  }

  /**
   * How the nearness, `nearest / depth`, follows from the depth in the framebuffer: a factor and an offset; the
   * depth of empty pixels; log2(far + 1) for logarithmic depths, whose factor is `nearest`.
   *
   * @param {ThreeCamera} camera
   * @param {boolean} reversed
   */
  #toNearness(camera, reversed) {
    const p = camera.projectionMatrix.elements;
    const nearest = nearestOf(camera);
    const { far } = /** @type {{far?: number}} */ (/** @type {unknown} */ (camera));
    const log = this.#renderer.capabilities.logarithmicDepthBuffer ? Math.log2((far ?? 1000) + 1) : 0;
    if (log) return [nearest, 0, 1, log];
    if (reversed) return [nearest / p[14], (nearest * p[10]) / p[14], 0, 0];
    return [(2 * nearest) / p[14], (nearest * (p[10] - 1)) / p[14], 1, 0];
  }

  /**
   * Upload what has changed in a mesh, and its uniforms.
   *
   * @param {MobileGSMesh} mesh
   * @param {Frame} frame
   * @param {number} levelSigma
   */
  #uploaded(mesh, frame, levelSigma) {
    const gl = this.#gl;
    const data = /** @type {SceneData} */ (mesh.data);
    let splats = this.#splats.get(mesh);
    if (splats?.data !== data) {
      this.forget(mesh);
      splats = this.#upload(data, mesh.changes.length);
      this.#splats.set(mesh, splats);
    }
    for (; splats.applied < mesh.changes.length; splats.applied++) {
      const { part, from, count } = mesh.changes[splats.applied];
      const stride = strides(data)[part];
      const numbers = data[part].subarray(stride * from, stride * (from + count));
      splats.textures.write(part, PACKED[part], (stride / PACKED[part][2]) * from, numbers);
    }
    gl.bindBuffer(gl.UNIFORM_BUFFER, splats.view);
    gl.bufferSubData(gl.UNIFORM_BUFFER, 0, meshUniforms(frame, mesh, data, mesh.near, levelSigma));
    return splats;
  }

  /** @param {SceneData} data @param {number} applied @returns {Splats} */
  #upload(data, applied) {
    const gl = this.#gl;
    const textures = new Textures(gl);
    for (const part of PARTS) textures.upload(part, PACKED[part], data[part]);
    const [looks, view] = [gl.createFramebuffer(), gl.createBuffer()];
    gl.bindFramebuffer(gl.FRAMEBUFFER, looks);
    const total = data.shapes.length / strides(data).shapes;
    const texture = textures.make("looks", gl.RG32UI, extent(total));
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    gl.bindBuffer(gl.UNIFORM_BUFFER, view);
    gl.bufferData(gl.UNIFORM_BUFFER, VIEW_BYTES, gl.DYNAMIC_DRAW);
    return { data, applied, textures, looks, view };
  }

  /**
   * A program, made at its first use.
   *
   * @param {"project" | "splat" | "enlarge" | "layer" | "nearness" | "blocks" | "over"} name
   * @param {{strips: boolean, leveled: boolean}} kind
   * @param {string[]} [words] to define
   */
  #program(name, { strips, leveled }, words = []) {
    const key = [name, strips, leveled, ...words].join(" ");
    const known = this.#programs.get(key);
    if (known) return known;
    const gl = this.#gl;
    const { view, packed, project, splat, whole, resolve } = this.#shaders;
    const defined = words.map((word) => `#define ${word}\n`).join("");
    const meshes = words.includes("MESHES") ? MESHES : "";
    const resolved = `#define main resolve_main\n${resolve}\n#undef main\n`;
    const [vertex, fragment] = {
      project: [whole, `${packed}${project}`],
      splat: [`${defined}${packed}${meshes}${splat}`, `${defined}${meshes}${splat}`],
      enlarge: [whole, `${defined}${resolve}`],
      layer: [whole, `${resolved}${LAYER}`],
      nearness: [whole, NEARNESS],
      blocks: [whole, `${defined}${BLOCKS}`],
      over: [whole, `${defined}${resolved}${OVER}`],
    }[name];
    const program = maker(gl, view, { sorted: false, packed: true, strips, leveled })(vertex, fragment);
    gl.uniformBlockBinding(program, gl.getUniformBlockIndex(program, "View"), this.#binding);
    const [layer_colors, layer_proximities] = LAYER_UNITS;
    const copies = { scene_depth: DEPTH_UNIT, picture: COLOR_UNIT };
    const units = { ...copies, blocks: BLOCKS_UNIT, wide_blocks: WIDE_BLOCKS_UNIT, layer_colors, layer_proximities };
    for (const [sampler, unit] of Object.entries(units)) gl.uniform1i(gl.getUniformLocation(program, sampler), unit);
    this.#programs.set(key, program);
    return program;
  }

  /**
   * Allocate the textures of the sums when size or format change; returns their size.
   *
   * @param {number} width
   * @param {number} height
   * @param {boolean} leveled
   * @param {boolean} floats
   * @param {number} moments of the proximity that are added up: 1 is the weight alone
   * @param {boolean} depthPass
   */
  #resize(width, height, leveled, floats, moments, depthPass) {
    const size = leveled ? levelPlaces(width, height).size : [width, height];
    const key = `${width} ${height} ${leveled} ${floats} ${moments}`;
    const sizes = levelSizes(width, height);
    if (depthPass && this.#passKey !== `${sizes[PASS_LEVEL]}`) {
      this.#passKey = `${sizes[PASS_LEVEL]}`;
      this.#textures.makeMoments(this.#depths, sizes[PASS_LEVEL]);
    }
    if (key === this.#key) return size;
    const gl = this.#gl;
    const colors = floats ? gl.RGBA32F : gl.RGBA16F;
    const weights = floats ? [gl.R32F, gl.RG32F, colors] : [gl.R16F, gl.RG16F, colors];
    const formats = [colors, weights[moments - 1]];
    for (let level = 0; level < (leveled ? LEVELS - 1 : 1); level++) {
      const suffix = level ? `_${level}` : "";
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.#sums[level]);
      ["color_sums", "weight_sums"].forEach((name, i) => {
        const texture = this.#textures.make(`${name}${suffix}`, formats[i], level ? sizes[level] : size);
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
      });
      gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#sums[0]);
    gl.bindRenderbuffer(gl.RENDERBUFFER, this.#depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT32F, size[0], size[1]);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.#depth);
    if (gl.checkFramebufferStatus(gl.FRAMEBUFFER) !== gl.FRAMEBUFFER_COMPLETE && !gl.isContextLost()) {
      throw new Error(`this GPU cannot draw into pictures of ${width}x${height} floats`);
    }
    this.#key = key;
    return size;
  }
}
