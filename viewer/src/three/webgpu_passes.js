/** The pipelines of three.js' meshes in WebGPU. */

import { OVER, Program, SUMS } from "../render/webgpu_program.js";
import { NEARNESS, PROJECT, nearnessAt, over } from "./webgpu_texts.js";

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
/** @typedef {{floats: boolean, keeps: boolean}} Kept precision of the sums, and whether the nearness is added up as well */
/** @typedef {"over" | "samples" | "behind edges" | "depth"} Way to draw the sums */

/** Format of the depth of the sums. */
export const SUMS_DEPTH = "depth32float";
/** Format of the blocks. */
export const BLOCKS_FORMAT = "rg16float";
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
      over: `${shaders.resolve}${over(false)}`,
      over_levels: `${shaders.resolve}${over(true)}`,
    });
  }

  /** Formats of the sums. @param {Kept} kept @returns {GPUTextureFormat[]} */
  static sums({ floats, keeps }) {
    return floats
      ? ["rgba32float", keeps ? "rg32float" : "r32float"]
      : ["rgba16float", keeps ? "rg16float" : "r16float"];
  }

  /** Lists the visible Gaussians. @param {Variant} variant @param {boolean} tested whether they choose levels by the depth */
  list({ strips }, tested) {
    return this.computing("project", PACKED, tested ? "project_in_depth" : "project_sortfree", { STRIPS: Number(strips) });
  }

  /** Blocks of 8 x 8 or 64 x 64 pixels. @param {number} level 0 or 1 */
  blocks(level) {
    return this.cached(`blocks ${level}`, () => {
      const module = this.module("nearness", null);
      return this.device.createRenderPipeline({
        layout: "auto",
        vertex: { module, entryPoint: "whole_target" },
        fragment: {
          module,
          entryPoint: level ? "range_of_blocks" : "range_of_pixels",
          targets: [{ format: BLOCKS_FORMAT }],
        },
      });
    });
  }

  /** The nearness of opaque meshes, in the pass of the sums. @param {Kept} kept */
  nearness(kept) {
    return this.cached(`nearness ${kept.floats} ${kept.keeps}`, () => {
      const module = this.module("nearness", null);
      return this.device.createRenderPipeline({
        layout: "auto",
        vertex: { module, entryPoint: "whole_target" },
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
   */
  add(kept, leveled, tested) {
    const { floats, strips, keeps } = kept;
    return this.cached(`add ${strips} ${floats} ${keeps} ${leveled} ${tested}`, () => {
      const module = this.module("splat", PACKED);
      return this.device.createRenderPipeline({
        layout: "auto",
        vertex: {
          module,
          entryPoint: leveled ? "corner_of_level" : "corner_sortfree",
          constants: { STRIPS: Number(strips) },
        },
        primitive: { topology: strips ? "triangle-strip" : "triangle-list" },
        fragment: {
          module,
          entryPoint: leveled ? "add_to_level" : "add_weighted",
          targets: MeshProgram.sums(kept).map((format) => ({ format, blend: SUMS })),
        },
        depthStencil: tested ? { format: SUMS_DEPTH, depthWriteEnabled: false, depthCompare: "greater" } : undefined,
      });
    });
  }

  /**
   * Draws the sums in a pass of three.js.
   *
   * @param {Way} way
   * @param {Attachments} attachments
   * @param {boolean} leveled
   */
  over(way, { colors, depth, samples, reversed }, leveled) {
    return this.cached(`over ${way} ${colors} ${depth} ${samples} ${reversed} ${leveled}`, () => {
      const module = this.module(leveled ? "over_levels" : "over", null);
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
            way === "depth" || i > 0 ? { format, writeMask: 0 } : { format, blend: OVER },
          ),
        },
        depthStencil,
        multisample: { count: samples },
      });
    });
  }
}
