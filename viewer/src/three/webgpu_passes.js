/** The pipelines of three.js' meshes in WebGPU. */

import { OVER as OVER_STATE, Program, SUMS } from "../render/webgpu_program.js";
import { COMPOSITE, NEARNESS, OVER, PROJECT, SPLAT, nearnessAt, sums } from "./webgpu_texts.js";

/** @typedef {import("../render/types.js").Variant} Variant */
/** @typedef {import("../render/webgpu_program.js").Kind} Kind */
/**
 * What a render pass of three.js draws into.
 *
 * @typedef {object} Attachments
 * @property {GPUTextureFormat[]} colors
 * @property {GPUTextureFormat | null} depth
 * @property {number} samples of a pixel
 * @property {boolean} reversed whether larger depths are nearer
 */
/** @typedef {{floats: boolean, moments: number}} Kept precision of the sums, and moments of the proximity that are added up: 1 is the weight alone */
/** @typedef {"sums" | "levels" | "layers"} Picture what its pixels are made of */
/** @typedef {"over" | "samples" | "behind edges" | "depth"} Way to draw the picture */

/** Format of the depth of the sums. */
export const SUMS_DEPTH = "depth32float";
/** Format of the blocks. */
export const BLOCKS_FORMAT = "rg16float";
/** Formats of the layers: colours; mean proximity and its standard deviation. @type {GPUTextureFormat[]} */
export const LAYER_FORMATS = ["rgba16float", "rg16float"];
const PACKED = { packed: true };

/** Pipelines of a device, and of the number of samples of the depth that they read. */
export class MeshProgram extends Program {
  /**
   * @param {GPUDevice} device
   * @param {Record<string, string>} shaders WGSL by name
   * @param {boolean} multisampled whether the depth of opaque meshes is
   */
  constructor(device, shaders, multisampled) {
    const depth = nearnessAt(multisampled);
    super(device, {
      ...shaders,
      project: `${shaders.project}${PROJECT}`,
      nearness: `${depth}${NEARNESS}`,
      splat: `${shaders.splat}${depth}${SPLAT}`,
      sums: `${shaders.resolve}${sums(false)}${OVER}`,
      levels: `${shaders.resolve}${sums(true)}${OVER}`,
      layers: `${shaders.resolve}${COMPOSITE}${OVER}`,
    });
  }

  /** Formats of the sums. @param {Kept} kept @returns {GPUTextureFormat[]} */
  static sums({ floats, moments }) {
    /** @type {GPUTextureFormat[]} */
    const weights = floats ? ["r32float", "rg32float", "rgba32float"] : ["r16float", "rg16float", "rgba16float"];
    return [floats ? "rgba32float" : "rgba16float", weights[moments - 1]];
  }

  /** Lists the visible Gaussians. @param {Variant} variant @param {boolean} tested whether they choose levels by the depth */
  list({ strips }, tested) {
    return this.computing("project", PACKED, tested ? "project_in_depth" : "project_sortfree", { STRIPS: Number(strips) });
  }

  /** Blocks of 8 x 8 or 64 x 64 pixels. @param {number} level 0 or 1 */
  blocks(level) {
    return this.whole("nearness", level ? "range_of_blocks" : "range_of_pixels", [BLOCKS_FORMAT]);
  }

  /** A scene as a layer of the picture. @param {boolean} leveled */
  layer(leveled) {
    return this.whole(leveled ? "levels" : "sums", "layer_of", LAYER_FORMATS);
  }

  /** The nearness of opaque meshes, in the pass of the sums. @param {Kept} kept */
  nearness(kept) {
    return this.cached(`nearness ${kept.floats} ${kept.moments}`, () => {
      const module = this.module("nearness", null);
      return this.device.createRenderPipeline({
        layout: "auto",
        vertex: { module, entryPoint: "whole_picture" },
        fragment: {
          module,
          entryPoint: "nearness_of_levels",
          targets: MeshProgram.sums(kept).map((format) => ({ format, writeMask: 0 })),
        },
        depthStencil: { format: SUMS_DEPTH, depthWriteEnabled: true, depthCompare: "always" },
      });
    });
  }

  /**
   * Adds Gaussians up.
   *
   * @param {Kept & Variant} kept
   * @param {boolean} leveled
   * @param {boolean} tested whether opaque meshes hide them
   * @param {boolean} depthPass whether their scene has one
   */
  add(kept, leveled, tested, depthPass) {
    const placed = ["placed_corner", (tested ? "add_before_meshes" : "add_moments") + (depthPass ? "_seen" : "")];
    const [corner, add] = tested || kept.moments > 1 ? placed : Program.entries(leveled, depthPass);
    const targets = MeshProgram.sums(kept).map((format) => ({ format, blend: SUMS }));
    /** @type {GPUDepthStencilState | undefined} */
    const depthStencil = tested ? { format: SUMS_DEPTH, depthWriteEnabled: false, depthCompare: "greater" } : undefined;
    return this.quads(PACKED, kept, corner, add, targets, { constants: { LEVELED: Number(leveled) }, depthStencil });
  }

  /** The picture of a depth pass. @param {Variant} variant @param {boolean} tested whether opaque meshes hide Gaussians */
  depthsBefore(variant, tested) {
    return this.depths(PACKED, variant, ...(tested ? ["placed_corner_of_pass", "add_depth_before_meshes"] : []));
  }

  /**
   * Draws the picture in a pass of three.js.
   *
   * @param {Way} way
   * @param {Attachments} attachments
   * @param {Picture} picture
   */
  over(way, { colors, depth, samples, reversed }, picture) {
    return this.cached(`over ${way} ${colors} ${depth} ${samples} ${reversed} ${picture}`, () => {
      const module = this.module(picture, null);
      const behind = way === "behind edges";
      /** @type {GPUCompareFunction} */
      const samplesPass = reversed ? (behind ? "greater" : "less-equal") : behind ? "less" : "greater-equal";
      /** @type {GPUDepthStencilState | undefined} */
      const depthStencil = depth
        ? {
            format: depth,
            depthWriteEnabled: way === "depth",
            depthCompare: way === "samples" || behind ? samplesPass : "always",
          }
        : undefined;
      return this.device.createRenderPipeline({
        layout: "auto",
        vertex: { module, entryPoint: "whole_picture" },
        fragment: {
          module,
          entryPoint: way === "over" ? "draw_over" : way === "depth" ? "draw_depth" : "draw_over_samples",
          constants: way === "samples" || behind ? { BEHIND_EDGES: Number(behind) } : {},
          targets: colors.map((format, i) =>
            way === "depth" || i > 0 ? { format, writeMask: 0 } : { format, blend: OVER_STATE },
          ),
        },
        depthStencil,
        multisample: { count: samples },
      });
    });
  }
}
