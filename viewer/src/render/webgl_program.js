/** The WebGL2 programs and buffers that all scenes share. */

import { CORNERS } from "./quads.js";
import { VIEW_BYTES } from "./view_uniforms.js";
import { SAMPLERS, Textures } from "./webgl_textures.js";

/** @typedef {{sorted: boolean, packed: boolean, strips: boolean, leveled: boolean, depthPass: boolean}} Kind of drawing */
/** @typedef {{project: WebGLProgram, depths: WebGLProgram[], splat: WebGLProgram, resolve: WebGLProgram, enlarge: WebGLProgram[]}} Passes one of depths if the scene has a depth pass; levels 1 and 2 are enlarged */
/**
 * Resources that live as long as the context.
 *
 * @typedef {object} Fixed
 * @property {WebGLBuffer} view the uniform block of view.glsl
 * @property {WebGLBuffer} corners of the quads of a batch
 * @property {WebGLVertexArrayObject} quads
 * @property {WebGLFramebuffer} looks output of the project pass
 * @property {WebGLFramebuffer} depths output of the depth pass
 * @property {WebGLFramebuffer} sums output of the splat pass
 * @property {WebGLFramebuffer[]} enlarged of levels 1 and 2, each with the coarser ones
 * @property {Map<string, Passes>} programs by kind, made at the first use
 * @property {Map<string, WebGLProgram>} counters likewise
 * @property {Textures} textures
 */

const VIEW_BINDING = 0;
const DEPTHS = "#define DEPTH_PASS\n";
/** Packed scenes need either extension. Some phones have only the second one, which is limited to float16. */
export const TARGETS = ["EXT_color_buffer_float", "EXT_color_buffer_half_float"];

/** True if sums can be float32. @param {WebGL2RenderingContext} gl */
export function blendsFloats(gl) {
  return ["EXT_color_buffer_float", "EXT_float_blend"].every((name) => gl.getExtension(name));
}

/** @param {WebGL2RenderingContext} gl @returns {Fixed} */
export function makeFixed(gl) {
  // a restored context needs its extensions requested again
  for (const name of [...TARGETS, "EXT_float_blend"]) gl.getExtension(name);
  // flat values are equal at all corners; on Metal another convention than its own is slow
  const convention = gl.getExtension("WEBGL_provoking_vertex");
  convention?.provokingVertexWEBGL(convention.FIRST_VERTEX_CONVENTION_WEBGL);
  gl.disable(gl.DITHER);
  const fixed = {
    view: gl.createBuffer(),
    corners: gl.createBuffer(),
    quads: gl.createVertexArray(),
    looks: gl.createFramebuffer(),
    depths: gl.createFramebuffer(),
    sums: gl.createFramebuffer(),
    enlarged: [gl.createFramebuffer(), gl.createFramebuffer()],
    programs: new Map(),
    counters: new Map(),
    textures: new Textures(gl),
  };
  gl.bindBufferBase(gl.UNIFORM_BUFFER, VIEW_BINDING, fixed.view);
  gl.bufferData(gl.UNIFORM_BUFFER, VIEW_BYTES, gl.DYNAMIC_DRAW);
  gl.bindVertexArray(fixed.quads);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, fixed.corners);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, CORNERS, gl.STATIC_DRAW);
  return fixed;
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {Record<string, string>} shaders
 * @param {Kind} kind
 * @returns {Passes}
 */
export function makePrograms(gl, shaders, kind) {
  const { whole, project, splat, resolve } = shaders;
  const rows = kind.packed ? shaders.packed : shaders.wide;
  const made = maker(gl, shaders.view, kind);
  const visible = kind.depthPass ? "#define VISIBLE\n" : "";
  return {
    project: made(whole, `${rows}${project}`),
    depths: kind.depthPass ? [maker(gl, shaders.view, { ...kind, leveled: false })(`${DEPTHS}${rows}${splat}`, `${DEPTHS}${splat}`)] : [],
    splat: made(`${visible}${rows}${splat}`, `${visible}${splat}`),
    resolve: made(whole, resolve),
    enlarge: kind.leveled ? [1, 2].map((level) => made(whole, `#define LEVEL ${level}\n${resolve}`)) : [],
  };
}

/**
 * The program that counts fragments.
 *
 * @param {WebGL2RenderingContext} gl
 * @param {Record<string, string>} shaders
 * @param {Kind} kind
 */
export function makeCounter(gl, { view, packed, wide, whole, count }, kind) {
  return maker(gl, view, kind)(whole, `#define VERTEX\n${kind.packed ? packed : wide}${count}`);
}

/**
 * A function that makes programs of a kind.
 *
 * @param {WebGL2RenderingContext} gl
 * @param {string} view
 * @param {Omit<Kind, "depthPass">} kind
 * @returns {(vertex: string, fragment: string) => WebGLProgram}
 */
export function maker(gl, view, { sorted, strips, leveled }) {
  const words = { SORTED: sorted, STRIPS: strips, LEVELED: leveled };
  const defined = Object.entries(words).map(([word, set]) => (set ? `#define ${word}\n` : "")).join("");
  return (vertex, fragment) => {
    const program = linked(gl, `${defined}#define VERTEX\n${view}${vertex}`, `${defined}${view}${fragment}`);
    gl.useProgram(program);
    SAMPLERS.forEach((name, unit) => gl.uniform1i(gl.getUniformLocation(program, name), unit));
    gl.uniformBlockBinding(program, gl.getUniformBlockIndex(program, "View"), VIEW_BINDING);
    return program;
  };
}

/** Compile and link a program; throws an Error with the GPU's log. @param {WebGL2RenderingContext} gl @param {string} vertex @param {string} fragment */
export function linked(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [kind, text] of /** @type {[GLenum, string][]} */ ([
    [gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, fragment],
  ])) {
    const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
    gl.shaderSource(shader, `#version 300 es\n${text}`);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    gl.deleteShader(shader); // with the program
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    const logs = (gl.getAttachedShaders(program) ?? []).map((one) => gl.getShaderInfoLog(one));
    logs.push(gl.getProgramInfoLog(program));
    throw new Error(`this GPU refuses a shader: ${logs.join(" ")}`);
  }
  return program;
}
