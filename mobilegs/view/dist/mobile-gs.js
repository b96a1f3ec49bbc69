(function bundle(){"use strict";
var g={"dots.glsl":`precision highp float;
uniform vec4 dots[5];
#ifdef VERTEX
layout(location = 0) in vec3 mean;
void main() {
vec4 at = vec4(mean, 1.0);
float depth = dot(dots[2], at);
gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
if (!(depth > dots[3].w)) return;
float side = depth * clamp(dots[4].x / depth, dots[4].y, 4.0 * dots[4].y);
int way = gl_VertexID % 3;
vec2 corner = vec2(float(way & 1), float(way >> 1)) * 2.0 - 1.0;
if (gl_VertexID % 6 > 2) corner = -corner;
vec2 place = vec2(dot(dots[0], at), dot(dots[1], at));
gl_Position = vec4(place + side * dots[4].zw * corner, 0.0, depth);
}
#else
out vec4 color;
void main() { color = vec4(dots[3].rgb, 1.0); }
#endif
`,"dots.wgsl":`struct Dots {
row_x: vec4f,
row_y: vec4f,
row_w: vec4f,
color: vec3f,
near: f32,
side: f32,
least: f32,
pixel: vec2f,
}
@group(0) @binding(0) var<uniform> dots: Dots;
@vertex
fn corner_of_dot(@location(0) mean: vec3f, @builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
let at = vec4f(mean, 1.0);
let depth = dot(dots.row_w, at);
if (!(depth > dots.near)) { return vec4f(2.0, 2.0, 2.0, 1.0); }
let side = depth * clamp(dots.side / depth, dots.least, 4.0 * dots.least);
let turn = select(1.0, -1.0, vertex % 6u > 2u);
let corner = turn * (vec2f(vec2u((vertex % 3u) & 1u, (vertex % 3u) >> 1u)) * 2.0 - 1.0);
let place = vec2f(dot(dots.row_x, at), dot(dots.row_y, at));
return vec4f(place + side * dots.pixel * corner, 0.0, depth);
}
@fragment
fn paint_dot() -> @location(0) vec4f { return vec4f(dots.color, 1.0); }
`,"network.wgsl":`alias Num4 = vec4<Num>;
const GAUSSIANS = 32u;
const QUARTERS = 4u;
const PARTS = 4u;
const NUM_MAX = 6e4;
const LAYER1 = 0u;
const OFFSETS2 = 384u;
const LAYER2 = 416u;
const HEADS = 2464u;
const HEAD_OFFSETS = 2496u;
@group(0) @binding(5) var<storage, read> weights: array<mat4x4<Num>>;
var<workgroup> hidden: array<Num4, 512>;
var<workgroup> sums: array<vec2f, 128>;
var<workgroup> touching: atomic<u32>;
var<workgroup> any_touches: u32;
fn activated(x: vec4f) -> Num4 { return Num4(clamp(x, vec4f(0.0), vec4f(NUM_MAX))); }
@compute @workgroup_size(GAUSSIANS * QUARTERS)
fn evaluate_network(
@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
@builtin(local_invocation_index) local: u32) {
let own = local % GAUSSIANS;
let quarter = local / GAUSSIANS;
let place = (group.y * groups.x + group.x) * GAUSSIANS + own;
let i = min(place, view.count - 1u);
let shape = shape_of(i);
let ellipse = ellipse_of(shape);
if (quarter == 0u && ellipse.depth > view.near && touches(ellipse, 1.0)) {
atomicMax(&touching, 1u);
}
workgroupBarrier();
if (local == 0u) { any_touches = atomicLoad(&touching); }
if (workgroupUniformLoad(&any_touches) == 0u) { return; }
let away = shape.mean - view.position;
let direction = away * inverseSqrt(max(dot(away, away), 1e-30));
let fixed = inputs_of(i);
let x0 = Num4(fixed[0]);
let x1 = Num4(fixed[1]);
let x2 = Num4(fixed[2]);
let x3 = Num4(vec4f(direction, fixed[3].x));
let x4 = Num4(vec4f(fixed[3].yzw, fixed[4].x));
let x5 = Num4(vec4f(fixed[4].yz, 1.0, 0.0));
let one = Num4(vec4f(1.0, 0.0, 0.0, 0.0));
var at = OFFSETS2 + 8u * quarter;
var a0 = vec4f(one * weights[at]);
var a1 = vec4f(one * weights[at + 1u]);
var a2 = vec4f(one * weights[at + 2u]);
var a3 = vec4f(one * weights[at + 3u]);
var a4 = vec4f(one * weights[at + 4u]);
var a5 = vec4f(one * weights[at + 5u]);
var a6 = vec4f(one * weights[at + 6u]);
var a7 = vec4f(one * weights[at + 7u]);
for (var part = 0u; part < PARTS; part++) {
for (var four = 4u * quarter; four < 4u * quarter + 4u; four++) {
let first = LAYER1 + 6u * (16u * part + four);
let h = vec4f(x0 * weights[first]) + vec4f(x1 * weights[first + 1u])
+ vec4f(x2 * weights[first + 2u]) + vec4f(x3 * weights[first + 3u])
+ vec4f(x4 * weights[first + 4u]) + vec4f(x5 * weights[first + 5u]);
hidden[GAUSSIANS * four + own] = activated(h);
}
workgroupBarrier();
for (var four = 0u; four < 16u; four++) {
let h = hidden[GAUSSIANS * four + own];
at = LAYER2 + 32u * (16u * part + four) + 8u * quarter;
a0 += vec4f(h * weights[at]);
a1 += vec4f(h * weights[at + 1u]);
a2 += vec4f(h * weights[at + 2u]);
a3 += vec4f(h * weights[at + 3u]);
a4 += vec4f(h * weights[at + 4u]);
a5 += vec4f(h * weights[at + 5u]);
a6 += vec4f(h * weights[at + 6u]);
a7 += vec4f(h * weights[at + 7u]);
}
workgroupBarrier();
}
at = HEADS + 8u * quarter;
let found = vec4f(activated(a0) * weights[at]) + vec4f(activated(a1) * weights[at + 1u])
+ vec4f(activated(a2) * weights[at + 2u]) + vec4f(activated(a3) * weights[at + 3u])
+ vec4f(activated(a4) * weights[at + 4u]) + vec4f(activated(a5) * weights[at + 5u])
+ vec4f(activated(a6) * weights[at + 6u]) + vec4f(activated(a7) * weights[at + 7u]);
sums[local] = found.xy;
workgroupBarrier();
if (quarter > 0u || place >= view.count) { return; }
let offsets = vec4f(one * weights[HEAD_OFFSETS]).xy;
let total = sums[own] + sums[own + 32u] + sums[own + 64u] + sums[own + 96u] + offsets;
seen[i] = as_lobes(vec2f(fixed[4].w, 0.0) + total / 0.28209479177387814);
}
`,"packed.glsl":`uniform usampler2D shapes;
vec4 bytes_of(uint word) {
int w = int(word);
return vec4(ivec4(w << 24, w << 16, w << 8, w) >> 24) / 127.0;
}
float scale_of(uint byte) { return uintBitsToFloat(((byte & 255u) + 888u) << 20); }
Shape shape_of(int i) {
uvec4 words = texelFetch(shapes, texel(i), 0);
vec3 stored = vec3(unpackHalf2x16(words.x), unpackHalf2x16(words.y).x);
vec3 steps = vec3(uvec3(words.z, words.z >> 11, words.z >> 22) & uvec3(2047u, 2047u, 1023u));
vec3 scales = uintBitsToFloat(uvec3(scale_bits.x + scale_bits.y * steps / vec3(2047.0, 2047.0, 1023.0)));
int w = int(words.w);
vec3 q = vec3(ivec3(w << 2, w << 12, w << 22) >> 22) * (0.7071067811865476 / 511.0);
float rest = sqrt(max(0.0, 1.0 - dot(q, q)));
uint largest = words.w >> 30;
vec4 r = largest == 0u ? vec4(rest, q) : largest == 1u ? vec4(q.x, rest, q.yz)
: largest == 2u ? vec4(q.xy, rest, q.z) : vec4(q, rest);
vec3 a = vec3(1.0 - 2.0 * (r.z * r.z + r.w * r.w), 2.0 * (r.y * r.z + r.x * r.w),
2.0 * (r.y * r.w - r.x * r.z));
vec3 b = vec3(2.0 * (r.y * r.z - r.x * r.w), 1.0 - 2.0 * (r.y * r.y + r.w * r.w),
2.0 * (r.z * r.w + r.x * r.y));
vec3 c = vec3(2.0 * (r.y * r.w + r.x * r.z), 2.0 * (r.z * r.w - r.x * r.y),
1.0 - 2.0 * (r.y * r.y + r.z * r.z));
return Shape(frame.xyz + frame.w * stored, mat3(a * scales.x, b * scales.y, c * scales.z));
}
#ifdef VERTEX
uniform usampler2D looks;
Look look_of(int i) {
uvec2 look = texelFetch(looks, texel(i), 0).rg;
uvec3 rgb = uvec3(look.x, look.x >> 9, look.x >> 18) & uvec3(511u);
return Look(
vec3(rgb) * exp2(float(look.x >> 27) - 24.0), unpackHalf2x16(look.y).y,
float(look.y & 65535u) / 65535.0);
}
#else
uniform usampler2D colors;
uniform usampler2D lobes;
layout(location = 0) out uvec2 look_out;
vec3 color_along(int i, float basis[16]) {
uvec4 words = texelFetch(colors, texel(i), 0);
vec3 constant = vec3(unpackHalf2x16(words.x), unpackHalf2x16(words.y).x);
float last = bytes_of(words.y).w;
vec4 one = bytes_of(words.z);
vec4 two = bytes_of(words.w);
vec3 sloped = basis[1] * vec3(last, one.xy) + basis[2] * vec3(one.zw, two.x) +
basis[3] * two.yzw;
return 0.5 + basis[0] * constant + scale_of(words.y >> 16) * sloped;
}
vec2 two(int word, float a, float b) {
vec4 pair = bytes_of(texelFetch(lobes, texel(word), 0).r);
return a * pair.xy + b * pair.zw;
}
vec2 lobes_along(int i, float basis[16]) {
int first = (lobe_size + 2) / 2 * i;
vec2 sloped = vec2(0.0);
if (lobe_size > 1) {
sloped += two(first + 1, basis[1], basis[2]);
sloped += two(first + 2, basis[3], basis[4]);
}
if (lobe_size > 4) {
sloped += two(first + 3, basis[5], basis[6]);
sloped += two(first + 4, basis[7], basis[8]);
}
if (lobe_size > 9) {
sloped += two(first + 5, basis[9], basis[10]);
sloped += two(first + 6, basis[11], basis[12]);
sloped += two(first + 7, basis[13], basis[14]);
sloped += two(first + 8, basis[15], 0.0);
}
uint word = texelFetch(shapes, texel(i), 0).y;
return basis[0] * unpackHalf2x16(texelFetch(lobes, texel(first), 0).r) +
vec2(scale_of(word >> 16), scale_of(word >> 24)) * sloped;
}
void keep(Look look) {
float most = clamp(max(look.color.r, max(look.color.g, look.color.b)), 1e-4, 6e4);
float exponent = floor(log2(most)) + 1.0;
uvec3 rgb = uvec3(min(look.color, vec3(6e4)) * exp2(9.0 - exponent) + 0.5);
rgb = min(rgb, uvec3(511u));
look_out = uvec2(
rgb.r | rgb.g << 9 | rgb.b << 18 | uint(exponent + 15.0) << 27,
uint(look.opacity * 65535.0 + 0.5) | packHalf2x16(vec2(0.0, min(look.weight, 6e4))));
}
#endif
`,"packed.wgsl":`@group(0) @binding(1) var<storage, read> shapes: array<vec4u>;
@group(0) @binding(2) var<storage, read> colors: array<vec4u>;
@group(0) @binding(3) var<storage, read> lobes: array<u32>;
@group(0) @binding(4) var<storage, read> inputs: array<u32>;
@group(0) @binding(6) var<storage, read_write> seen: array<u32>;
alias StoredLook = vec2u;
fn scale_of(byte: u32) -> f32 { return bitcast<f32>(((byte & 255u) + 888u) << 20u); }
fn shape_of(i: u32) -> Shape {
let words = shapes[i];
let xy = unpack2x16float(words.x);
let mean = view.frame.xyz + view.frame.w * vec3f(xy, unpack2x16float(words.y).x);
let steps = vec3f(vec3u(words.z, words.z >> 11u, words.z >> 22u) & vec3u(2047u, 2047u, 1023u));
let bits = view.scale_bits.x + view.scale_bits.y * steps / vec3f(2047.0, 2047.0, 1023.0);
let scales = bitcast<vec3f>(vec3u(bits));
let thirds = vec3i(bitcast<i32>(words.w << 2u), bitcast<i32>(words.w << 12u),
bitcast<i32>(words.w << 22u)) >> vec3u(22u);
let q = vec3f(thirds) * (0.7071067811865476 / 511.0);
let rest = sqrt(max(0.0, 1.0 - dot(q, q)));
var r = vec4f(rest, q);
switch words.w >> 30u {
case 1u: { r = vec4f(q.x, rest, q.yz); }
case 2u: { r = vec4f(q.xy, rest, q.z); }
case 3u: { r = vec4f(q, rest); }
default: {}
}
let a = vec3f(1.0 - 2.0 * (r.z * r.z + r.w * r.w), 2.0 * (r.y * r.z + r.x * r.w),
2.0 * (r.y * r.w - r.x * r.z));
let b = vec3f(2.0 * (r.y * r.z - r.x * r.w), 1.0 - 2.0 * (r.y * r.y + r.w * r.w),
2.0 * (r.z * r.w + r.x * r.y));
let c = vec3f(2.0 * (r.y * r.w + r.x * r.z), 2.0 * (r.z * r.w - r.x * r.y),
1.0 - 2.0 * (r.y * r.y + r.z * r.z));
return Shape(mean, mat3x3f(a * scales.x, b * scales.y, c * scales.z));
}
fn color_along(i: u32, basis: array<f32, 16>) -> vec3f {
let words = colors[i];
let constant = vec3f(unpack2x16float(words.x), unpack2x16float(words.y).x);
let last = unpack4x8snorm(words.y).w;
let one = unpack4x8snorm(words.z);
let two = unpack4x8snorm(words.w);
let sloped = basis[1] * vec3f(last, one.xy) + basis[2] * vec3f(one.zw, two.x) +
basis[3] * two.yzw;
return 0.5 + basis[0] * constant + scale_of(words.y >> 16u) * sloped;
}
fn two(word: u32, a: f32, b: f32) -> vec2f {
let pair = unpack4x8snorm(lobes[word]);
return a * pair.xy + b * pair.zw;
}
fn lobes_along(i: u32, basis: array<f32, 16>) -> vec2f {
let first = (view.lobe_size + 2u) / 2u * i;
var sloped = vec2f(0.0);
if (view.lobe_size > 1u) {
sloped += two(first + 1u, basis[1], basis[2]);
sloped += two(first + 2u, basis[3], basis[4]);
}
if (view.lobe_size > 4u) {
sloped += two(first + 3u, basis[5], basis[6]);
sloped += two(first + 4u, basis[7], basis[8]);
}
if (view.lobe_size > 9u) {
sloped += two(first + 5u, basis[9], basis[10]);
sloped += two(first + 6u, basis[11], basis[12]);
sloped += two(first + 7u, basis[13], basis[14]);
sloped += two(first + 8u, basis[15], 0.0);
}
let word = shapes[i].y;
return basis[0] * unpack2x16float(lobes[first]) +
vec2f(scale_of(word >> 16u), scale_of(word >> 24u)) * sloped;
}
fn inputs_of(i: u32) -> array<vec4f, 5> {
let at = 10u * i;
let first = inputs[at];
var pairs: array<vec2f, 9>;
for (var k = 0u; k < 9u; k++) { pairs[k] = unpack2x16snorm(inputs[at + 1u + k]); }
return array<vec4f, 5>(
vec4f(unpack2x16snorm(first).y, pairs[0], pairs[1].x),
vec4f(pairs[1].y, pairs[2], pairs[3].x),
vec4f(pairs[3].y, pairs[4], pairs[5].x),
vec4f(pairs[5].y, pairs[6], pairs[7].x),
vec4f(pairs[7].y, pairs[8], unpack2x16float(first).x));
}
fn as_lobes(found: vec2f) -> u32 { return pack2x16float(clamp(found, vec2f(-6e4), vec2f(6e4))); }
fn store(look: Look) -> StoredLook {
let most = clamp(max(look.color.r, max(look.color.g, look.color.b)), 1e-4, 6e4);
let exponent = floor(log2(most)) + 1.0;
let parts = vec3u(min(look.color, vec3f(6e4)) * exp2(9.0 - exponent) + 0.5);
let rgb = min(parts, vec3u(511u));
return vec2u(
rgb.r | (rgb.g << 9u) | (rgb.b << 18u) | (u32(exponent + 15.0) << 27u),
u32(look.opacity * 65535.0 + 0.5) | pack2x16float(vec2f(0.0, min(look.weight, 6e4))));
}
fn stored(look: StoredLook) -> Look {
let rgb = vec3u(look.x, look.x >> 9u, look.x >> 18u) & vec3u(511u);
return Look(
vec3f(rgb) * exp2(f32(look.x >> 27u) - 24.0), unpack2x16float(look.y).y,
f32(look.y & 65535u) / 65535.0);
}
`,"project.glsl":`void harmonics(int size, vec3 d, out float b[16]) {
for (int k = 0; k < 16; k++) { b[k] = 0.0; }
b[0] = 0.28209479177387814;
if (size < 4) { return; }
const float c1 = 0.4886025119029199;
b[1] = -c1 * d.y;
b[2] = c1 * d.z;
b[3] = -c1 * d.x;
if (size < 9) { return; }
vec3 s = d * d;
b[4] = 1.0925484305920792 * d.x * d.y;
b[5] = -1.0925484305920792 * d.y * d.z;
b[6] = 0.31539156525252005 * (2.0 * s.z - s.x - s.y);
b[7] = -1.0925484305920792 * d.x * d.z;
b[8] = 0.5462742152960396 * (s.x - s.y);
if (size < 16) { return; }
b[9] = -0.5900435899266435 * d.y * (3.0 * s.x - s.y);
b[10] = 2.890611442640554 * d.x * d.y * d.z;
b[11] = -0.4570457994644658 * d.y * (4.0 * s.z - s.x - s.y);
b[12] = 0.3731763325901154 * d.z * (2.0 * s.z - 3.0 * s.x - 3.0 * s.y);
b[13] = -0.4570457994644658 * d.x * (4.0 * s.z - s.x - s.y);
b[14] = 1.445305721320277 * d.z * (s.x - s.y);
b[15] = -0.5900435899266435 * d.x * (s.x - 3.0 * s.y);
}
float weight_of(float depth, float largest, float phi) {
if (weighting == 3) { return max(0.0, 1.0 - depth / size.z) * phi; }
float w = phi * phi;
if (weighting != 1) { w += phi / (depth * depth); }
if (weighting != 2) { w += exp(min(largest / depth, background.w)); }
return w;
}
Look look_at(int i) {
Look look = Look(vec3(0.0), 0.0, 0.0);
if (i >= count) { return look; }
Shape shape = shape_of(i);
Ellipse e = ellipse_of(shape);
if (!(e.depth > position.w)) { return look; }
vec3 away = shape.mean - position.xyz;
float basis[16];
harmonics(max(sh_size, lobe_size), away * inversesqrt(dot(away, away)), basis);
vec2 seen = lobes_along(i, basis);
float opacity = 1.0 / (1.0 + exp(min(-seen.x, 80.0)));
if (!(opacity > scale_bits.z)) { return look; }
vec2 box = reach_of(opacity) * sqrt(e.variance);
if (any(lessThan(e.center + box, vec2(0.5)))) { return look; }
if (any(greaterThan(e.center - box, size.xy - 0.5))) { return look; }
vec3 a = shape.axes[0];
vec3 b = shape.axes[1];
vec3 c = shape.axes[2];
float largest = sqrt(max(dot(a, a), max(dot(b, b), dot(c, c))));
look.color = max(color_along(i, basis), vec3(0.0));
look.weight = weight_of(e.depth, largest, max(seen.y, 0.0)) * weight_scale;
look.opacity = opacity;
return look;
}
void main() { keep(look_at(int(gl_FragCoord.y) * 4096 + int(gl_FragCoord.x))); }
`,"project.wgsl":`override SORTED = false;
override STRIPS = false;
struct Drawn {
vertices: u32,
instances: atomic<u32>,
first: u32,
base: u32,
first_instance: u32,
}
@group(0) @binding(4) var<storage, read_write> looks: array<StoredLook>;
@group(0) @binding(5) var<storage, read_write> batches: array<u32>;
@group(0) @binding(6) var<storage, read_write> drawn: Drawn;
fn harmonics(size: u32, d: vec3f) -> array<f32, 16> {
var b: array<f32, 16>;
b[0] = 0.28209479177387814;
if (size < 4u) { return b; }
const c1 = 0.4886025119029199;
b[1] = -c1 * d.y;
b[2] = c1 * d.z;
b[3] = -c1 * d.x;
if (size < 9u) { return b; }
let s = d * d;
b[4] = 1.0925484305920792 * d.x * d.y;
b[5] = -1.0925484305920792 * d.y * d.z;
b[6] = 0.31539156525252005 * (2.0 * s.z - s.x - s.y);
b[7] = -1.0925484305920792 * d.x * d.z;
b[8] = 0.5462742152960396 * (s.x - s.y);
if (size < 16u) { return b; }
b[9] = -0.5900435899266435 * d.y * (3.0 * s.x - s.y);
b[10] = 2.890611442640554 * d.x * d.y * d.z;
b[11] = -0.4570457994644658 * d.y * (4.0 * s.z - s.x - s.y);
b[12] = 0.3731763325901154 * d.z * (2.0 * s.z - 3.0 * s.x - 3.0 * s.y);
b[13] = -0.4570457994644658 * d.x * (4.0 * s.z - s.x - s.y);
b[14] = 1.445305721320277 * d.z * (s.x - s.y);
b[15] = -0.5900435899266435 * d.x * (s.x - 3.0 * s.y);
return b;
}
fn weight_of(depth: f32, largest: f32, phi: f32) -> f32 {
if (view.weighting == 3u) { return max(0.0, 1.0 - depth / view.sigma) * phi; }
var w = phi * phi;
if (view.weighting != 1u) { w += phi / (depth * depth); }
if (view.weighting != 2u) { w += exp(min(largest / depth, view.exponent_max)); }
return w;
}
fn look_at(i: u32) -> Look {
var look: Look;
let shape = shape_of(i);
let ellipse = ellipse_of(shape);
if (!(ellipse.depth > view.near)) { return look; }
let away = shape.mean - view.position;
let basis = harmonics(max(view.sh_size, view.lobe_size), away * inverseSqrt(dot(away, away)));
let seen = lobes_along(i, basis);
let opacity = 1.0 / (1.0 + exp(min(-seen.x, 80.0)));
if (!(opacity > view.alpha_min)) { return look; }
if (!touches(ellipse, opacity)) { return look; }
let a = shape.axes;
let largest = sqrt(max(dot(a[0], a[0]), max(dot(a[1], a[1]), dot(a[2], a[2]))));
look.color = max(color_along(i, basis), vec3f(0.0));
look.weight = weight_of(ellipse.depth, largest, max(seen.y, 0.0)) * view.weight_scale;
look.opacity = opacity;
return look;
}
var<workgroup> shown: atomic<u32>;
@compute @workgroup_size(BATCH)
fn project_all(
@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
@builtin(local_invocation_index) local: u32) {
let batch = group.y * groups.x + group.x;
let i = batch * BATCH + local;
if (i < view.count) {
let look = look_at(i);
looks[i] = store(look);
if (look.opacity > 0.0) { atomicMax(&shown, 1u); }
}
workgroupBarrier();
if (SORTED || local > 0u) { return; }
if (atomicLoad(&shown) > 0u) {
let step = select(1u, BATCH, STRIPS);
batches[atomicAdd(&drawn.instances, step) / step] = batch;
}
}
`,"resolve.glsl":`uniform sampler2D color_sums;
uniform sampler2D weight_sums;
uniform int last_row;
out vec4 color_out;
void main() {
ivec2 at = ivec2(gl_FragCoord.xy);
at.y = abs(last_row - at.y);
vec4 sum = texelFetch(color_sums, at, 0);
#ifdef SORTED
color_out = vec4(sum.rgb + (1.0 - sum.a) * background.rgb, sum.a);
#else
float weight = texelFetch(weight_sums, at, 0).r;
float behind = size.w * weight_scale;
if (!(weight > 1e-12 * weight_scale)) {
color_out = vec4(background.rgb, 1.0 - sum.a);
} else if (weighting == 3) {
color_out = vec4((behind * background.rgb + sum.rgb) / (behind + weight), 1.0 - sum.a);
} else {
color_out = vec4((1.0 - sum.a) * sum.rgb / weight + sum.a * background.rgb, 1.0 - sum.a);
}
#endif
}
`,"resolve.wgsl":`@group(0) @binding(1) var colors: texture_2d<f32>;
@group(0) @binding(2) var weights: texture_2d<f32>;
@vertex
fn whole_picture(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
return vec4f(f32((vertex << 1u) & 2u) * 2.0 - 1.0, f32(vertex & 2u) * 2.0 - 1.0, 0.0, 1.0);
}
@fragment
fn resolve_sortfree(@builtin(position) position: vec4f) -> @location(0) vec4f {
let sum = textureLoad(colors, vec2i(position.xy), 0);
let weight = textureLoad(weights, vec2i(position.xy), 0).r;
if (!(weight > 1e-12 * view.weight_scale)) { return vec4f(view.background, 1.0 - sum.a); }
let behind = view.background_weight * view.weight_scale;
if (view.weighting == 3u) {
return vec4f((behind * view.background + sum.rgb) / (behind + weight), 1.0 - sum.a);
}
return vec4f((1.0 - sum.a) * sum.rgb / weight + sum.a * view.background, 1.0 - sum.a);
}
@fragment
fn resolve_sorted(@builtin(position) position: vec4f) -> @location(0) vec4f {
let sum = textureLoad(colors, vec2i(position.xy), 0);
return vec4f(sum.rgb + (1.0 - sum.a) * view.background, sum.a);
}
`,"splat.glsl":`#ifdef VERTEX
#ifdef SORTED
uniform usampler2D order;
#endif
flat out vec4 axes;
flat out vec4 color;
flat out vec3 center;
void main() {
gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
axes = vec4(0.0);
color = vec4(0.0);
center = vec3(0.0);
#ifdef STRIPS
int i = gl_InstanceID;
#else
int i = gl_InstanceID * BATCH + gl_VertexID / 4;
#endif
if (i >= count) { return; }
#ifdef SORTED
i = int(texelFetch(order, texel(i), 0).r);
#endif
Look look = look_of(i);
if (!(look.opacity > 0.0)) { return; }
Ellipse e = ellipse_of(shape_of(i));
float skew = 0.5 * (e.variance.x - e.variance.y);
float cov = e.covariance;
float root = sqrt(skew * skew + cov * cov);
float large = 0.5 * (e.variance.x + e.variance.y) + root;
vec2 way = vec2(1.0, 0.0);
if (root > 0.0) {
way = normalize(skew > 0.0 ? vec2(root + skew, cov) : vec2(cov, root - skew));
}
vec2 sizes = sqrt(vec2(large, e.determinant / large));
vec2 across = vec2(-way.y, way.x);
axes = vec4(way, across) / sizes.xxyy;
color = vec4(look.color, look.weight);
center = vec3(e.center, look.opacity);
vec2 side = (reach_of(look.opacity) * sizes + 0.02) *
(vec2(gl_VertexID & 1, (gl_VertexID >> 1) & 1) * 2.0 - 1.0);
vec2 at = e.center + side.x * way + side.y * across;
gl_Position = vec4(at / size.xy * 2.0 - 1.0, 0.0, 1.0);
}
#else
flat in vec4 axes;
flat in vec4 color;
flat in vec3 center;
layout(location = 0) out vec4 color_out;
#ifndef SORTED
layout(location = 1) out vec4 weight_out;
#endif
void main() {
vec2 d = gl_FragCoord.xy - center.xy;
vec2 q = vec2(dot(axes.xy, d), dot(axes.zw, d));
float alpha = center.z * exp(-0.5 * dot(q, q));
alpha = alpha >= scale_bits.z ? min(alpha, ALPHA_MAX) : 0.0;
#ifdef SORTED
color_out = vec4(color.rgb * alpha, alpha);
#else
float weighted = alpha * color.w;
color_out = vec4(color.rgb * weighted, alpha);
weight_out = vec4(weighted, 0.0, 0.0, 0.0);
#endif
}
#endif
`,"splat.wgsl":`override SORTED = false;
override STRIPS = false;
@group(0) @binding(4) var<storage, read> looks: array<StoredLook>;
@group(0) @binding(5) var<storage, read> order: array<u32>;
struct Corner {
@builtin(position) position: vec4f,
@location(0) @interpolate(flat) axes: vec4f,
@location(1) @interpolate(flat) color: vec4f,
@location(2) @interpolate(flat) center: vec3f,
}
@vertex
fn corner(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
var out: Corner;
out.position = vec4f(2.0, 2.0, 2.0, 1.0);
let place = select(instance * BATCH + vertex / 4u, instance, STRIPS);
var i = place;
if (SORTED) {
if (place >= view.count) { return out; }
i = order[place];
} else {
i = order[place / BATCH] * BATCH + place % BATCH;
if (i >= view.count) { return out; }
}
let look = stored(looks[i]);
if (!(look.opacity > 0.0)) { return out; }
let ellipse = ellipse_of(shape_of(i));
let skew = 0.5 * (ellipse.variance.x - ellipse.variance.y);
let cov = ellipse.covariance;
let root = sqrt(skew * skew + cov * cov);
let large = 0.5 * (ellipse.variance.x + ellipse.variance.y) + root;
var way = vec2f(1.0, 0.0);
if (root > 0.0) {
way = normalize(select(vec2f(cov, root - skew), vec2f(root + skew, cov), skew > 0.0));
}
let lengths = vec2f(large, ellipse.determinant / large);
let sizes = sqrt(lengths);
let across = vec2f(-way.y, way.x);
out.axes = vec4f(way, across) / sizes.xxyy;
out.color = vec4f(look.color, look.weight);
out.center = vec3f(ellipse.center, look.opacity);
let side = (reach_of(look.opacity) * sizes + 0.02) *
(vec2f(vec2u(vertex & 1u, (vertex >> 1u) & 1u)) * 2.0 - 1.0);
let at = ellipse.center + side.x * way + side.y * across;
out.position = vec4f(at / view.size * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), 0.0, 1.0);
return out;
}
fn alpha_at(corner: Corner) -> f32 {
let d = corner.position.xy - corner.center.xy;
let q = vec2f(dot(corner.axes.xy, d), dot(corner.axes.zw, d));
let alpha = corner.center.z * exp(-0.5 * dot(q, q));
return select(0.0, min(alpha, ALPHA_MAX), alpha >= view.alpha_min);
}
struct Sums {
@location(0) color: vec4f,
@location(1) weight: vec4f,
}
@fragment
fn add_weighted(corner: Corner) -> Sums {
let alpha = alpha_at(corner);
let weighted = alpha * corner.color.w;
return Sums(vec4f(corner.color.rgb * weighted, alpha), vec4f(weighted, 0.0, 0.0, 0.0));
}
@fragment
fn cover(corner: Corner) -> @location(0) vec4f {
let alpha = alpha_at(corner);
return vec4f(corner.color.rgb * alpha, alpha);
}
`,"view.glsl":`precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
layout(std140) uniform View {
vec4 row_x;
vec4 row_y;
vec4 row_z;
vec4 position;
vec4 lens;
vec4 limits;
vec4 background;
vec4 size;
float weight_scale;
int count;
int sh_size;
int lobe_size;
int weighting;
vec4 frame;
vec4 scale_bits;
};
const float ALPHA_MAX = 0.99;
const float BLUR = 0.3;
const int BATCH = 128;
ivec2 texel(int i) { return ivec2(i & 4095, i >> 12); }
struct Shape {
vec3 mean;
mat3 axes;
};
struct Look {
vec3 color;
float weight;
float opacity;
};
struct Ellipse {
float depth;
vec2 center;
vec2 variance;
float covariance;
float determinant;
};
Ellipse ellipse_of(Shape shape) {
Ellipse e;
vec4 mean = vec4(shape.mean, 1.0);
e.depth = dot(row_z, mean);
if (!(e.depth > position.w)) { return e; }
vec2 t = vec2(dot(row_x, mean), dot(row_y, mean)) / e.depth;
vec2 uv = clamp(t, limits.xz, limits.yw);
vec3 depths = row_z.xyz * shape.axes;
vec3 px = (lens.x / e.depth) * (row_x.xyz * shape.axes - uv.x * depths);
vec3 py = (lens.y / e.depth) * (row_y.xyz * shape.axes - uv.y * depths);
e.center = lens.xy * t + lens.zw;
e.variance = vec2(dot(px, px), dot(py, py)) + BLUR;
e.covariance = dot(px, py);
vec3 crossed = cross(px, py);
e.determinant = dot(crossed, crossed) + BLUR * (e.variance.x + e.variance.y - BLUR);
return e;
}
float reach_of(float opacity) { return sqrt(2.0 * log(opacity / scale_bits.z)); }
`,"view.wgsl":`struct View {
row_x: vec4f,
row_y: vec4f,
row_z: vec4f,
position: vec3f,
near: f32,
focal: vec2f,
center: vec2f,
limits: vec4f,
background: vec3f,
exponent_max: f32,
size: vec2f,
sigma: f32,
background_weight: f32,
weight_scale: f32,
count: u32,
sh_size: u32,
lobe_size: u32,
weighting: u32,
frame: vec4f,
scale_bits: vec2f,
alpha_min: f32,
}
@group(0) @binding(0) var<uniform> view: View;
struct Shape {
mean: vec3f,
axes: mat3x3f,
}
struct Look {
color: vec3f,
weight: f32,
opacity: f32,
}
const ALPHA_MAX = 0.99;
const BLUR = 0.3;
const BATCH = 128u;
struct Ellipse {
depth: f32,
center: vec2f,
variance: vec2f,
covariance: f32,
determinant: f32,
}
fn ellipse_of(shape: Shape) -> Ellipse {
var out: Ellipse;
let mean = vec4f(shape.mean, 1.0);
out.depth = dot(view.row_z, mean);
if (!(out.depth > view.near)) { return out; }
let t = vec2f(dot(view.row_x, mean), dot(view.row_y, mean)) / out.depth;
let uv = clamp(t, view.limits.xz, view.limits.yw);
let depths = view.row_z.xyz * shape.axes;
let px = (view.focal.x / out.depth) * (view.row_x.xyz * shape.axes - uv.x * depths);
let py = (view.focal.y / out.depth) * (view.row_y.xyz * shape.axes - uv.y * depths);
out.center = view.focal * t + view.center;
out.variance = vec2f(dot(px, px), dot(py, py)) + BLUR;
out.covariance = dot(px, py);
let crossed = cross(px, py);
out.determinant = dot(crossed, crossed) + BLUR * (out.variance.x + out.variance.y - BLUR);
return out;
}
fn reach_of(opacity: f32) -> f32 { return sqrt(2.0 * log(opacity / view.alpha_min)); }
fn touches(ellipse: Ellipse, opacity: f32) -> bool {
let box = reach_of(opacity) * sqrt(ellipse.variance);
return !(any(ellipse.center + box < vec2f(0.5)) || any(ellipse.center - box > view.size - 0.5));
}
`,"whole.glsl":`void main() {
gl_Position = vec4(
float((gl_VertexID << 1) & 2) * 2.0 - 1.0, float(gl_VertexID & 2) * 2.0 - 1.0, 0.0, 1.0);
}
`,"wide.glsl":`uniform sampler2D shapes;
Shape shape_of(int i) {
vec4 a = texelFetch(shapes, texel(3 * i), 0);
vec4 b = texelFetch(shapes, texel(3 * i + 1), 0);
vec4 c = texelFetch(shapes, texel(3 * i + 2), 0);
return Shape(vec3(a.w, b.w, c.w), mat3(a.xyz, b.xyz, c.xyz));
}
#ifdef VERTEX
uniform sampler2D looks;
uniform sampler2D opacities;
Look look_of(int i) {
vec4 color = texelFetch(looks, texel(i), 0);
return Look(color.rgb, color.w, texelFetch(opacities, texel(i), 0).r);
}
#else
uniform sampler2D colors;
uniform sampler2D lobes;
layout(location = 0) out vec4 look_out;
layout(location = 1) out float opacity_out;
vec3 color_along(int i, float basis[16]) {
vec3 color = vec3(0.5);
for (int k = 0; k < sh_size; k++) {
color += basis[k] * texelFetch(colors, texel(sh_size * i + k), 0).rgb;
}
return color;
}
vec2 lobes_along(int i, float basis[16]) {
vec2 seen = vec2(0.0);
for (int k = 0; k < lobe_size; k++) {
seen += basis[k] * texelFetch(lobes, texel(lobe_size * i + k), 0).rg;
}
return seen;
}
void keep(Look look) {
look_out = vec4(look.color, look.weight);
opacity_out = look.opacity;
}
#endif
`,"wide.wgsl":`@group(0) @binding(1) var<storage, read> shapes: array<vec4f>;
@group(0) @binding(2) var<storage, read> colors: array<f32>;
@group(0) @binding(3) var<storage, read> lobes: array<vec2f>;
@group(0) @binding(4) var<storage, read> inputs: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> seen: array<vec2f>;
struct StoredLook {
color: vec4f,
opacity: f32,
}
fn shape_of(i: u32) -> Shape {
let a = shapes[3u * i];
let b = shapes[3u * i + 1u];
let c = shapes[3u * i + 2u];
return Shape(vec3f(a.w, b.w, c.w), mat3x3f(a.xyz, b.xyz, c.xyz));
}
fn color_along(i: u32, basis: array<f32, 16>) -> vec3f {
var b = basis;
var color = vec3f(0.5);
for (var k = 0u; k < view.sh_size; k++) {
let at = 3u * (view.sh_size * i + k);
color += b[k] * vec3f(colors[at], colors[at + 1u], colors[at + 2u]);
}
return color;
}
fn lobes_along(i: u32, basis: array<f32, 16>) -> vec2f {
var b = basis;
var seen = vec2f(0.0);
for (var k = 0u; k < view.lobe_size; k++) { seen += b[k] * lobes[view.lobe_size * i + k]; }
return seen;
}
fn inputs_of(i: u32) -> array<vec4f, 5> {
let at = 5u * i;
return array<vec4f, 5>(inputs[at], inputs[at + 1u], inputs[at + 2u], inputs[at + 3u], inputs[at + 4u]);
}
fn as_lobes(found: vec2f) -> vec2f { return found; }
fn store(look: Look) -> StoredLook {
return StoredLook(vec4f(look.color, look.weight), look.opacity);
}
fn stored(look: StoredLook) -> Look { return Look(look.color.rgb, look.color.w, look.opacity); }
`};var Ot=()=>({name:"",before:"",failed:"",state:"",share:NaN,sentence:""}),wt=class{#t=[Ot(),Ot()];begin(t,e){let s=this.#t[t].name;this.#t[t]=e===void 0?Ot():{...Ot(),name:e,before:s,state:"loading"}}fail(t,e,s){let{name:o,before:r}=this.#t[t];this.note(t,{share:1,state:"failed",sentence:e,failed:this.names[t],name:s?r:o})}note(t,e){Object.assign(this.#t[t],e)}get state(){let t=this.#t.map(({state:s})=>s);return["failed","loading","loaded"].find(s=>t.includes(s))??""}get busy(){return this.#t.some(({state:t})=>t==="loading")}get share(){let t=this.#t.filter(({state:e})=>e).map(({share:e})=>e);return t.reduce((e,s)=>e+s,0)/t.length}get sentence(){let t=this.#t.every(({state:s})=>s),e=this.#t.map(({state:s,sentence:o,failed:r})=>s!=="failed"?"":t&&r&&!o.includes(r)?`${r}: ${o}`:o);return[...new Set(e.filter(Boolean))].join("; ")}get names(){return xo(this.#t[0].name,this.#t[1].name)}};function xo(n,t){let[e,s]=[n,t].map(o=>o.split("/").filter(Boolean));for(let o=1;o<=Math.max(e.length,s.length);o++){let[r,i]=[e,s].map(a=>a.slice(-o).map(ye).join("/"));if(r!==i)return[r,i]}return[ye(e[e.length-1]??""),ye(s[s.length-1]??"")]}function ye(n){try{return decodeURIComponent(n)}catch{return n}}function Lt(n){let t=n?.trim().toLowerCase()??"",e=/^([0-9a-f]{3}|[0-9a-f]{6})$/.test(t)?`#${t}`:t,s=/^#[0-9a-f]+$/.test(e)?e:Eo(e),o=s.length===4?s.replace(/[^#]/g,"$&$&"):s;if(!/^#[0-9a-f]{6}$/.test(o))return null;let r=i=>Number.parseInt(o.slice(i,i+2),16)/255;return[r(1),r(3),r(5)]}function ws(n){let t=e=>Math.round(255*Math.min(Math.max(e,0),1));return`#${n.map(e=>t(e).toString(16).padStart(2,"0")).join("")}`}function Eo(n){let t=n?document.createElement("canvas").getContext("2d"):null;if(!t)return"";let[e,s]=["#000000","#ffffff"].map(o=>(t.fillStyle=o,t.fillStyle=n,String(t.fillStyle)));return e===s?e:""}function ms(n,t,e){let s=f=>n.querySelector(`[name=${f}]`);s("background").value=ws(t.background);let o=s("scale"),r=t.scale??0;[...o.options].some(({value:f})=>Number(f)===r)||o.add(new Option(`${Math.round(100*r)} %`,String(r))),o.value=String(r),s("mode").value=t.mode,s("turning").checked=t.turning,s("stats").checked=e;let{renderer:i,adapter:a}=t.device,c=i?`Rendered with ${i}${a?` on ${a}`:""}`:"";n.querySelector(".device").textContent=c;let l=n.querySelector("[data-act=view]");l.hidden=t.views.length<2}function gs(n,t){let{name:e,value:s}=n;e==="background"?t.background=Lt(s):e==="scale"?t.scale=Number(s)||null:e==="mode"?t.mode=s==="fly"?"fly":"orbit":e==="turning"&&(t.turning=n.checked),t.redraw()}var ko=new Map([["ArrowLeft",-.02],["ArrowDown",-.02],["ArrowRight",.02],["ArrowUp",.02],["PageDown",-.1],["PageUp",.1],["Home",-1],["End",1]]),Ut=class{share=.5;#t;#s;#o=["",""];constructor(t,e){this.#t=t,this.#s=e,t.onpointerdown=({pointerId:s})=>t.setPointerCapture(s),t.onpointermove=({pointerId:s,clientX:o})=>{if(!t.hasPointerCapture(s))return;let{left:r,width:i}=e.getBoundingClientRect();this.#e((o-r)/i)},t.onkeydown=s=>{let o=ko.get(s.key);o===void 0||s.ctrlKey||s.metaKey||s.altKey||(s.preventDefault(),this.#e(this.share+o))}}show(t){this.#o=t,this.#t.querySelectorAll("span").forEach((e,s)=>e.textContent=t[s]),this.#t.setAttribute("aria-label",`${t[0]} on the left, ${t[1]} on the right`),this.#t.hidden=!1,this.#s.classList.add("drawn"),this.#e(this.share)}#e(t){this.share=Math.min(Math.max(t,0),1);let e=Math.round(100*this.share);this.#s.style.clipPath=`inset(0 0 0 ${100*this.share}%)`,this.#t.style.left=`${100*this.share}%`,this.#t.setAttribute("aria-valuenow",String(e));let[s,o]=this.#o;this.#t.setAttribute("aria-valuetext",`${e} % ${s}, ${100-e} % ${o}`)}};var bs=':host{display:block;position:relative;overflow:hidden;contain:strict;color-scheme:light dark;--paper: #16181dd9;--ink: #f3f4f6;--accent: #7db4ff;--wall: #0d0f12;--field: #ffffff1c;background:var(--wall);color:var(--ink);font:14px/1.4 system-ui,sans-serif;min-height:120px}@media(prefers-color-scheme:light){:host{--paper: #ffffffd9;--ink: #16181d;--accent: #0b62d6;--wall: #e8eaee;--field: #0000000f}}canvas{opacity:0;display:block;width:100%;height:100%;touch-action:none;cursor:grab;outline:none}canvas.drawn{opacity:1}canvas.polite{touch-action:pan-y}canvas:active{cursor:grabbing}canvas.reached{outline:2px solid var(--accent);outline-offset:-2px}.over{position:absolute;inset:0;pointer-events:none}.split{position:absolute;top:0;bottom:0;width:20px;margin-left:-10px;cursor:ew-resize;touch-action:none;outline:none}.split:before{content:"";position:absolute;inset:0 9px;background:#fff;box-shadow:0 0 3px #000a}.split:after{content:"\\2039\\2002\\203a";position:absolute;top:50%;left:-12px;width:44px;height:44px;margin-top:-22px;border-radius:50%;background:var(--paper);line-height:40px;text-align:center;font-size:20px;box-shadow:0 0 0 2px #fff,0 0 5px 2px #000a}.split:focus-visible:after{box-shadow:0 0 0 3px var(--accent)}.split span{position:absolute;top:12px;padding:2px 8px;border-radius:6px;background:var(--paper);max-width:40vw;overflow:hidden;text-overflow:ellipsis;white-space:nowrap}.split span:first-child{right:18px}.split span:last-child{left:18px}[hidden]{display:none!important}.bar{position:absolute;inset:0 0 auto;height:3px;background:transparent}.bar>div{height:100%;width:0;background:var(--accent);transition:width .15s}.bar.unknown>div{width:100%!important;animation:wait 1.2s ease-in-out infinite alternate}@keyframes wait{0%{opacity:.2}}@media(prefers-reduced-motion:reduce){.bar>div{transition:none;animation:none!important}}.panel{position:absolute;background:var(--paper);border-radius:10px;padding:12px 16px;backdrop-filter:blur(8px)}.panel:focus{outline:none}.message,.help,.report{inset:0;margin:auto;width:fit-content;height:fit-content;max-width:min(34em,92%);max-height:92%;box-sizing:border-box;overflow:auto}.message{overflow-wrap:anywhere}.stats{top:12px;left:12px;font-variant-numeric:tabular-nums;white-space:pre;pointer-events:none}.split:not([hidden])~.stats{top:52px}.said{right:12px;top:12px;pointer-events:none}.said:not(.seen){clip-path:inset(50%)}h2{font-size:16px;margin:0 0 8px}.help dl{display:grid;grid-template-columns:fit-content(45%) 1fr;gap:4px 16px;margin:0 0 12px}.help dt{font-weight:600}.help dd{margin:0}.buttons{position:absolute;right:12px;left:12px;bottom:calc(12px + env(safe-area-inset-bottom));display:flex;flex-wrap:wrap;justify-content:end;gap:8px;pointer-events:none}.settings{right:12px;bottom:calc(68px + env(safe-area-inset-bottom));width:min(26em,calc(100% - 24px));box-sizing:border-box;max-height:calc(100% - 80px);overflow:auto}@media(max-height:500px){.settings{bottom:12px;max-height:calc(100% - 24px);columns:2;width:min(40em,calc(100% - 24px))}}.settings p{display:flex;flex-wrap:wrap;align-items:center;gap:8px;margin:0 0 8px}.settings p>label{flex:1}.settings>label{display:flex;align-items:center;gap:8px;min-height:36px}.settings>small{display:block;margin:8px 0 12px;overflow-wrap:anywhere}button,select,[type=color]{font:inherit;color:inherit;background:var(--paper);border:0;border-radius:10px;min-width:44px;min-height:44px;padding:0 9px;cursor:pointer;pointer-events:auto}.panel :is(button,select,[type=color]){background:var(--field)}[type=color]{padding:6px}[type=checkbox]{width:20px;height:20px;margin:0;accent-color:var(--accent)}button:hover{color:var(--accent)}:is(button,select,input,textarea):focus-visible{outline:2px solid var(--accent)}textarea{font:12px/1.3 ui-monospace,monospace;color:inherit;background:transparent;max-width:100%}.drop{inset:12px;border:2px dashed var(--accent);display:grid;place-items:center}';var Ao=[["Drag","rotate the scene"],["Two fingers, right button or Shift","move sideways"],["Pinch or wheel","zoom in and out"],["Double tap","look at that point"],["Arrow keys","rotate"],["W A S D Q E","fly; hold Shift to fly faster"],["M","switch between orbiting and looking around"],["V","next training camera"],["R","back to the first view"],["F","full screen"],["P","save a picture"],["I","frame rate and size"],["O","settings"],["H","help"]],vs=`
<style>${bs}</style>
<canvas tabindex="0" role="application"></canvas>
<div class="split" role="slider" tabindex="0" aria-valuemin="0" aria-valuemax="100" hidden>
<span></span><span></span>
</div>
<div class="bar" role="progressbar" aria-label="loading" hidden><div></div></div>
<div class="panel stats" hidden></div>
<div class="panel said" role="status"></div>
<div class="buttons">
<button data-act="reset" title="Back to the first view (R)">Reset</button>
<button data-act="settings" title="Settings (O)" aria-expanded="false">Settings</button>
<button data-act="full" title="Full screen (F)">Full screen</button>
<button data-act="help" title="Help (H)" aria-label="Help" aria-expanded="false">?</button>
</div>
<div class="panel settings" role="dialog" aria-label="Settings" tabindex="-1" hidden>
<h2>Settings</h2>
<p><label for="color">Background</label><input id="color" type="color" name="background" />
<button data-act="own">The scene's own</button></p>
<p><label for="scale">Resolution</label><select id="scale" name="scale">
<option value="0">automatic</option><option value="1">100 %</option>
<option value="0.7">70 %</option><option value="0.5">50 %</option>
</select></p>
<p><label for="mode">Dragging</label><select id="mode" name="mode">
<option value="orbit">rotates the scene</option><option value="fly">looks around</option>
</select></p>
<label><input type="checkbox" name="turning" /> Rotate slowly</label>
<label><input type="checkbox" name="stats" /> Show the frame rate</label>
<small class="device"></small>
<p><button data-act="open">Open a file</button><input type="file" multiple hidden />
<button data-act="view">Next camera</button> <button data-act="picture">Save a picture</button>
<button data-act="close">Close</button></p>
</div>
<div class="panel help" role="dialog" aria-label="Help" tabindex="-1" hidden>
<h2>Controls</h2>
<dl>${Ao.map(([n,t])=>`<dt>${n}</dt><dd>${t}</dd>`).join("")}</dl>
<button data-act="close">Close</button>
</div>
<div class="panel report" role="dialog" aria-label="Benchmark" tabindex="-1" hidden>
<h2></h2>
<textarea readonly rows="14" cols="44" aria-label="Results as JSON"></textarea><br />
<button data-act="copy">Copy</button> <button data-act="share">Share</button>
<button data-act="close">Close</button> <small class="copied" role="status"></small>
</div>
<div class="panel message" hidden><p role="alert"></p><button data-act="open">Open a file</button>
<button data-act="close">Close</button></div>
<div class="panel drop" hidden>Drop a scene to open it, or two to compare them</div>`,xe=new Map(Object.entries({r:"reset",m:"mode",f:"full",h:"help",i:"stats",o:"settings",p:"picture",v:"view"}));var ys=new Map([["KeyW",[0,0,1]],["KeyS",[0,0,-1]],["KeyA",[-1,0,0]],["KeyD",[1,0,0]],["KeyQ",[0,1,0]],["KeyE",[0,-1,0]]]),xs=new Map([["ArrowLeft",[-1,0]],["ArrowRight",[1,0]],["ArrowUp",[0,-1]],["ArrowDown",[0,1]]]),zt=class{#t;#s;#o=new AbortController;#e=new Map;#n=new Set;#r=!1;#i={x:0,y:0,time:0};constructor(t,e){this.#t=t,this.#s=e;let s=(o,r)=>t.addEventListener(o,r,{signal:this.#o.signal,passive:!1});s("pointerdown",o=>this.#c(o)),s("pointermove",o=>this.#l(o)),s("pointerup",o=>this.#f(o)),s("pointercancel",o=>this.#f(o)),s("wheel",o=>this.#g(o)),s("contextmenu",o=>o.preventDefault()),s("keydown",o=>this.#v(o,!0)),s("keyup",o=>this.#v(o,!1)),s("blur",()=>this.#n.clear())}get busy(){return this.#n.size>0}advance(t){if(!this.busy)return;let e=this.#s.pose(),s=.9*e.reach*t*(this.#r?4:1);for(let o of this.#n){let r=ys.get(o);r&&e.move(r[0]*s,r[1]*s,r[2]*s);let i=xs.get(o);i&&this.#a(i[0]*1.5*t,i[1]*1.5*t)}this.#s.changed()}destroy(){this.#o.abort()}#a(t,e){let s=this.#s.pose();this.#s.mode()==="orbit"?s.orbit(t,e):s.look(t,e)}#c(t){this.#t.focus({preventScroll:!0}),this.#t.setPointerCapture(t.pointerId),this.#e.set(t.pointerId,{x:t.offsetX,y:t.offsetY});let{x:e,y:s,time:o}=this.#i,r=Math.hypot(t.offsetX-e,t.offsetY-s)<20,i=this.#e.size===1&&t.button===0;i&&r&&t.timeStamp-o<350&&this.#s.focus(t.offsetX,t.offsetY),this.#i={x:t.offsetX,y:t.offsetY,time:i?t.timeStamp:-1/0},this.#s.held(),t.preventDefault()}#l(t){let e=this.#e.get(t.pointerId);if(e===void 0)return;let s={x:t.offsetX,y:t.offsetY};Math.hypot(s.x-this.#i.x,s.y-this.#i.y)>6&&(this.#i.time=-1/0),this.#e.size===1?this.#d(s.x-e.x,s.y-e.y,t):this.#e.size===2&&this.#w(t.pointerId,s),this.#e.set(t.pointerId,s),this.#s.changed()}#f(t){this.#e.delete(t.pointerId)}#d(t,e,s){s.buttons&6||s.shiftKey||s.ctrlKey?this.#h(t,e):this.#a(t*.006,e*.006)}#w(t,e){let s=this.#e.get(t),o=[...this.#e].find(([a])=>a!==t)?.[1];if(s===void 0||o===void 0)return;let r=Math.hypot(s.x-o.x,s.y-o.y),i=Math.hypot(e.x-o.x,e.y-o.y);this.#s.mode()==="fly"?this.#s.pose().move(0,0,2*(i-r)*this.#m):r>0&&i>0&&this.#s.pose().dolly(r/i),this.#h((e.x-s.x)/2,(e.y-s.y)/2)}#h(t,e){this.#s.pose().move(-t*this.#m,-e*this.#m,0)}get#m(){let{target:t,eye:e}=this.#s.pose();return Math.hypot(...t.map((s,o)=>s-e[o]))/Math.max(this.#t.clientHeight,1)}#g(t){if(this.#t.classList.contains("polite")&&!t.ctrlKey&&!t.metaKey)return;t.preventDefault();let e=t.deltaMode===WheelEvent.DOM_DELTA_LINE?16:1,s=t.deltaY*e*(t.ctrlKey?8:1)*.0012,o=this.#s.pose();this.#s.mode()==="orbit"?o.dolly(Math.exp(s)):o.move(0,0,-s*o.reach),this.#s.changed()}#v(t,e){let{code:s}=t;if(this.#r=t.shiftKey,!e&&s.startsWith("Meta")&&this.#n.clear(),e&&(t.ctrlKey||t.metaKey||t.altKey)||!ys.has(s)&&!xs.has(s))return;let o=e&&!this.#n.has(s);e?this.#n.add(s):this.#n.delete(s),o&&this.advance(.03),this.#s.changed(),t.preventDefault()}};function Ee(){let n=URL.createObjectURL(new Blob([`(${bundle})()`],{type:"text/javascript"}));return setTimeout(()=>URL.revokeObjectURL(n),6e4),new Worker(n)}function Es(n,t){let e=globalThis.preloadedWorker;delete globalThis.preloadedWorker;let s;return e&&"url"in n&&e.url===n.url?(s=e.worker,e.messages.forEach(t)):(e?.worker.terminate(),s=Ee(),s.postMessage(n)),s.onmessage=t,s}async function ks(){let n=globalThis.preloadedAdapter;return delete globalThis.preloadedAdapter,await n??navigator.gpu.requestAdapter({powerPreference:"high-performance"})}async function As(n){return g[n]}function Ft(n,[t,e,s]){let o=n.length/3,r=new Float32Array(o);for(let l=0;l<o;l++)r[l]=t*n[3*l]+e*n[3*l+1]+s*n[3*l+2];let i=new Uint32Array(r.buffer);for(let l=0;l<o;l++)i[l]=i[l]&2147483648?i[l]:~i[l]&2147483647;let a=Uint32Array.from({length:o},(l,f)=>f),c=new Uint32Array(o);for(let l of[0,16]){let f=new Uint32Array(65537);for(let h=0;h<o;h++)f[(i[h]>>>l&65535)+1]+=1;for(let h=0;h<65536;h++)f[h+1]+=f[h];for(let h=0;h<o;h++){let d=a[h];c[f[i[d]>>>l&65535]++]=d}[a,c]=[c,a]}return a}var _o=/[\x00-\x1f\x7f-\x9f\u2028\u2029\p{Cs}]/gu,v=class extends Error{name="SceneError";constructor(t){super(t.replace(_o,"\uFFFD"))}};function D(n){return new DataView(n.buffer,n.byteOffset,n.byteLength)}var Y=class{#t;#s=0;#o=0;constructor(t){this.#t=t}get left(){return 8*(this.#t.length-this.#s)-this.#o}take(t){let e=this.#t,s=this.#s,o=e[s]|e[s+1]<<8|e[s+2]<<16|e[s+3]<<24,r=this.#o+t,i=o>>>this.#o&(1<<t)-1;return this.#s=s+(r>>>3),this.#o=r&7,i}atEnd(){return this.left<8&&this.#t[this.#s]>>>this.#o===0}};function ot(n,t){let e=Math.ceil(t/8);if(n.length!==e)throw new v(`packed bits take ${n.length} bytes where ${e} belong`);if(t%8&&n[e-1]>>t%8)throw new v("packed bits end in bits that are not zero");return new Y(n)}var _s="0061736d01000000012a0460077f7f7f7f7f7f7d0060037f7f7f0060097f7f7f7f7f7f7f7f7f017f60097f7f7f7f7f7f7f7d7d00020f0103656e76066d656d6f727902000103060500010202030607017f014180080b073705056c61796572000005756e69747300010a70756c6c5f706c61696e00020f70756c6c5f636f6e7465787475616c0003047061636b00040abc21059c0404017f017b047f0b7b024020054101480d00200120054102746a21072006fd13210820044102742209410148210a0340200020094102746a210b4100210c03402001fd09000c210d2001fd090008210e2001fd090004210f2001fd090000211002400240200a450d00200d2111200e2112200f2113201021140c010b2002200c4102746a2104200d2111200e2112200f2113201021142000210503402004fd00001022152005fd0900002216fde6012010fde40121102004fd00000022172016fde6012014fde401211420152005fd0900042216fde601200ffde401210f20172016fde6012013fde401211320152005fd0900082216fde601200efde401210e20172016fde6012012fde401211220152005fd09000c2216fde601200dfde401210d20172016fde6012011fde401211120044180046a2104200541106a2205200b490d000b0b2003200c4102746a2205201120082011fde601fde901fd0b00800c2005201220082012fde601fde901fd0b0080082005201320082013fde601fde901fd0b0080042005201020082010fde601fde901fd0b00102005201420082014fde601fde901fd0b0000200541900c6a200d2008200dfde601fde901fd0b000020054190086a200e2008200efde601fde901fd0b000020054190046a200f2008200ffde601fde901fd0b0000200c41f800492105200c41086a210c20050d000b20034180106a2103200b2100200141106a22012007490d000b0b0bd50104027f017b027f017b200020024109746a2103410021040340fd0c0000000000000000000000000000000021052000200441027422066a22022107034020052007fd00000022082008fde601fde401210520074180046a22072003490d000b200120066a2107fd0c0000803f0000803f0000803f0000803f2005fde301fd0cccbc8c2bccbc8c2bccbc8c2bccbc8c2bfde901fde70121050340200720052002fd000000fde601fd0b000020074180046a210720024180046a22022003490d000b200441fc00492102200441046a210420020d000b0bd30101087f41002109034002402006200820092007491b220a4101480d002000200a4103746a210b2000210a0340024020022001200a280200220c41ffff0071220d4101746a2f0100220e4102746a280200220f0d0041000f0b20042f01002110200a28020420094101746a200e3b0102200a20104100200d200f410f766b200f41ffff0171200c410e766c6a220c4180800449220f1b200c200f41047474723602002004200f4101746a2104200a41086a220a200b490d000b0b0240200420054b0d00200941016a220920074d0d010b0b20040bf101010a7f410021094100210a0340024020062008200a2007491b220b4101480d002000200b4103746a210c2000210b0340024020022009200b280204200a4101746a220d2f010071220e20036c2001200e410f74200b280200220f41ffff00712210410174726a2f010022116a4102746a280200220e0d0041000f0b20042f01002112200d20113b0102200b201241002010200e410f766b200e41ffff0171200f410e766c6a220d4180800449220e1b200d200e41047474723602002004200e4101746a2104200b41086a220b200c490d000b0b0240200420054b0d00417f2109200a41016a220a20074d0d010b0b20040bfc1707067f027b037f0c7b037f0e7b017f2005417e7121092005410171210a200641036c210b2006410174210c20044180206a210d200541017441026a210e2008fd13210f2007fd132110410021112006410274221241027421130340fd0c020000000200000002000000020000002214fd0c010000000100000001000000010000002215fd0c0000000000000000000000000000000022162001fd000080042217fde0012001fd0000002218fde001fd442219fd522001fd00008008221afde001201720182019fd522217fde001fd442218fd522119fd0c03000000030000000300000003000000211b2001fd0000800c221c201a20172018fd522217201cfde0012017fde001fd44221dfd52221efd0cffffff7fffffff7fffffff7fffffff7f221cfd4e2016fd37211ffd0c0000000000000000000000000000000022172118410121202016211a4100212102400240024020050e020201000b0340201720032020410a746a2222fd000000fde001fde90120224180086afd000000fde001fde9012117201820224180046afd000000fde001fde901202241800c6afd000000fde001fde9012118202041026a2120202141026a22212009470d000b0b0240200a450d00201720032020410a746a2222fd000000fde001fde9012117201820224180046afd000000fde001fde90121180b2018fd0cffff0f00ffff0f00ffff0f00ffff0f00221afdae014114fdad0121162017201afdae014114fdad01211a0b201b2019201dfd52211d200d2003fd000080042217fd0c000000800000008000000080000000802223fd4e2003fd00000022184110fdad01fd0c008000000080000000800000008000002224fd4efd502018201cfd4e2219fd0c0000804b0000804b0000804b0000804b2225fde601fd6afdf80120192018410dfdad012015fd4efdae01fd0cff0f00c8ff0f00c8ff0f00c8ff0f00c82226fdae01410dfdad01fd0cff7b0000ff7b0000ff7b0000ff7b00002227fdb7012019fd0c000080380000803800008038000080382228fd3afd52fd502017201cfd4e22182025fde601fd6afdf80120182017410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120182028fd3afd524110fdab01fd502217fd0c0000ffff0000ffff0000ffff0000fffffd4efd0ce2f00000e2f00000e2f00000e2f00000fd502017201ffd522217fd5a00000041022120200d20064102746a2017fd5a000001200d200c4102746a2017fd5a000002200d200b4102746a2017fd5a0000032016fd0c78030000780300007803000078030000221ffdb901fd0c770400007704000077040000770400002229fdb601fd0c88fcffff88fcffff88fcffff88fcffff222afdae01212bfd0c00008037000080370000803700008037212cfd0c0000fe420000fe420000fe420000fe422117201a201ffdb9012029fdb601202afdae01212d0240200e41024d0d002017202b4114fdab01202cfdae01fde70121192017202d4114fdab01202cfdae01fde701211a200d21220340202241046a22222019200320204109742221418004726afd000000fde601fd0c0000fec20000fec20000fec20000fec22218fde9012017fde801fd0c002000440020004400200044002000442216fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4e201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf801fd0cff000000ff000000ff000000ff000000fd4e2019200320214180086a2221418004726afd000000fde6012018fde9012017fde8012016fde401fdf8014118fdab01201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4efd50fd50fd502218fd5a000000202220126a2018fd5a0000012022200c4102746a2018fd5a0000022022200b4102746a2018fd5a000003202041046a2220200e490d000b0b200441346a202d4110fdab01202b4118fdab01fd502218fd5a000003200441246a2018fd5a000002200441146a2018fd5a000001200441046a2018fd5a000000200441386a200f2000fd00008004fdfa012010fde501fde601fd0c000000000000000000000000000000002218fde901fd0c0000803f0000803f0000803f0000803f2216fde801fd0c00e0ff4400e0ff4400e0ff4400e0ff44221afde601fd0c0000003f0000003f0000003f0000003f2219fde401fdf801410bfdab01200f2000fd00008008fdfa012010fde501fde6012018fde9012016fde801fd0c00c07f4400c07f4400c07f4400c07f44fde6012019fde401fdf8014116fdab01fd50200f2000fd000000fdfa012010fde501fde6012018fde9012016fde801201afde6012019fde401fdf801fd502216fd5a000003200441286a2016fd5a000002200441186a2016fd5a000001200441086a2016fd5a0000002004413c6afd0c71aa34c471aa34c471aa34c471aa34c4fd0c71aa344471aa344471aa344471aa3444201e2018fd43fd5222162001fd00008004221a2001fd000000201d2015fd39fd52fde601fd0c001080440010804400108044001080442219fde401fdf801410afdab01fd0c00fc0f0000fc0f0000fc0f0000fc0f00fd4e201d4114fdab01fd5020162001fd00008008222b201a201d2014fd39fd52fde6012019fde401fdf801fd0cff030000ff030000ff030000ff030000221afd4efd50410afdab0120162001fd0000800c202b201d201bfd39fd52fde6012019fde401fdf801201afd4efd502216fd5a0000032004412c6a2016fd5a0000022004411c6a2016fd5a0000012004410c6a2016fd5a0000002002fd0000802c211d2002fd00008028211b2002fd00008024212b2002fd00008020212d2002fd0000801c21142002fd00008018211e2002fd00008014212e2002fd00008010212f2002fd0000800c2130200441b0106a2002fd0000800422162023fd4e2002fd00000022194110fdad012024fd4efd502019201cfd4e221a2025fde601fd6afdf801201a2019410dfdad012015fd4efdae012026fdae01410dfdad012027fdb701201a2028fd3afd52fd502016201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd524110fdab01fd502216fd5a000003200441a0106a2016fd5a00000220044190106a2016fd5a00000120044180106a2016fd5a000000200441b4106a2002fd000080082216201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd522030fde0012018fde901202ffde001fde901202efde001fde901201efde001fde9012014fde001fde901202dfde001fde901202bfde001fde901201bfde001fde901201dfde001fde901fd0cffff0f00ffff0f00ffff0f00ffff0f00fdae014114fdad01201ffdb9012029fdb601202afdae0122184110fdab0120164110fdad012024fd4efd50fd502002fd0000800c201720184114fdab01202cfdae01fde7012218fde601fd0c0000fec20000fec20000fec20000fec22216fde9012017fde801fd0c002000440020004400200044002000442219fde401fdf8014118fdab01fd50221afd5a000003200441a4106a201afd5a00000220044194106a201afd5a00000120044184106a201afd5a00000020044188106a213141002120410121210340203120204102746a222241306a20182020410b7420026a22204180186afd000000fde6012016fde9012017fde8012019fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4e2018202041801c6afd000000fde6012016fde9012017fde8012019fde401fdf8014118fdab01fd50201820204180146afd000000fde6012016fde9012017fde8012019fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4efd50201820204180106afd000000fde6012016fde9012017fde8012019fde401fdf801fd0cff000000ff000000ff000000ff000000fd4efd50221afd5a000003202241206a201afd5a000002202241106a201afd5a0000012022201afd5a00000020214101712122410021214101212020220d000b200441c0006a2104200341106a2103200241106a2102200141106a2101200041106a2100200d20136a210d201141fc00492122201141046a211120220d000b0b";var mt,Ss=new WeakMap;function It(n){return typeof WebAssembly=="object"?new WebAssembly.Memory({initial:Math.ceil(n/2**16)}):null}function rt(n){if(n===null)return null;if(mt===void 0)try{let e=_s.match(/../g);mt=new WebAssembly.Module(Uint8Array.from(e,s=>parseInt(s,16)))}catch{mt=null}if(mt===null)return null;let t=Ss.get(n);if(!t){let{exports:e}=new WebAssembly.Instance(mt,{env:{memory:n}});t=e,Ss.set(n,t)}return t}var ke=2048,K;function Ts({contexts:n,alphabet:t,symbols:e,spans:s},o,r,i,a){K===void 0&&(K=It(1));let c=rt(K);if(K===null||c===null)return;let l=o.length,f=ke+2*e.length,h=f+4*s.length,d=h+i.length,p=d+2*l+2,u=Math.ceil((p+2*a+2)/2**16)-K.buffer.byteLength/2**16;u>0&&K.grow(u);let{buffer:w}=K,m=new Uint32Array(w,0,2*l);o.forEach((k,x)=>m.set([k,p-2+2*r[x]],2*x)),new Uint16Array(w,ke,e.length).set(e),new Uint32Array(w,f,s.length).set(s),new Uint8Array(w,h,i.length).set(i);let E=(n>1?c.pull_contextual:c.pull_plain)(0,ke,f,t,h,d,l,Math.floor(a/l),a%l);return{decoded:new Uint16Array(w,p,a).slice(),left:E?(d-E)/2:-1/0,states:m.filter((k,x)=>x%2===0)}}var Bt=14,bt=1<<Bt,Ms=65536,So=64,To=256,Mo=2048,Nt=12,Rs=-1/0;function Q(n,t,e,s=!1){if(n.length<Nt)throw new v("a rANS stream is too short to hold its header");let o=D(n),r=o.getUint16(0,!0),i=o.getUint16(2,!0),a=o.getUint32(4,!0),c=o.getUint32(8,!0);if(r!==e)throw new v(`a rANS stream of ${r} symbols stands where ${e} belong`);if(i!==1&&i!==e||i>So)throw new v(`a rANS stream has ${i} contexts`);let l=Ro(t);if(n.length!==Nt+a+4*l+2*c)throw new v("a rANS stream is longer or shorter than its header says");let f=Nt+a,h=Lo(n.subarray(Nt,f),i,e),d=new Uint32Array(l).map((E,k)=>o.getUint32(f+4*k,!0));if(d.some(E=>E<Ms))throw new v("a rANS stream starts in an impossible state");let p=Math.floor(t/l),u=t%l,w=d.map((E,k)=>k*p+Math.min(k,u)),m=[h,d,w,n.subarray(f+4*l),t],y=(s?void 0:Ts(...m))??Oo(...m);if(y.left===Rs)throw new v("a rANS stream leads to a context that is not used: it is damaged");if(y.left<0)throw new v("a rANS stream ends early: the file is damaged");if(y.left>0||y.states.some(E=>E!==Ms))throw new v("a rANS stream does not end where it should: the file is damaged");return y.decoded}function Ro(n){let t=Math.max(1,Math.floor(n/Mo));return Math.min(To,1<<31-Math.clz32(t))}function Oo({contexts:n,alphabet:t,symbols:e,spans:s},o,r,i,a){let c=o.length,l=Math.floor(a/c),f=a%c,h=new Uint16Array(a),d=i.length/2,p=new Uint16Array(d+1);new Uint8Array(p.buffer).set(i);let u=0;for(let w=0;w<=l;w++){let m=w<l?c:f,y=n>1&&w>0;for(let E=0;E<m;E++){let k=r[E]+w,x=y?h[k-1]:0,A=o[E],M=A&bt-1,C=e[x<<Bt|M],st=s[x*t+C];if(st===0)return{decoded:h,left:Rs,states:o};let nt=Math.imul(st&32767,A>>>Bt)+M-(st>>>15)|0,V=(nt>>>16)-1>>>31;o[E]=nt<<16*V|p[u]&-V,u+=V,h[k]=C}}return{decoded:h,left:d-u,states:o}}function Lo(n,t,e){let s=new Y(n),o=new Uint16Array(t*bt),r=new Uint32Array(t*e);for(let i=0;i<t;i++){if(!gt(s,1))continue;let a=Uo(s,e),c=i*bt;for(let l=0;l<e;l++){let f=a[l];f!==0&&(r[i*e+l]=c%bt<<15|f,o.fill(l,c,c+f),c+=f)}}if(!s.atEnd())throw new v("a rANS stream's frequency tables are longer than they should be");return{contexts:t,alphabet:e,symbols:o,spans:r}}function Uo(n,t){let e=new Uint16Array(t),s=[];for(let a=0;a<t;a++)gt(n,1)&&s.push(a);let o=gt(n,4),r=s.pop(),i=bt;for(let a of s){let c=o;for(;!gt(n,1);)c++;if(c>Bt)throw new v("a rANS stream's frequency table holds a number out of range");e[a]=gt(n,c)+(1<<c)-(1<<o)+1,i-=e[a]}if(r===void 0||i<1)throw new v("a rANS stream's frequencies do not sum to 16384");return e[r]=i,e}function gt(n,t){if(t>n.left)throw new v("a rANS stream's frequency tables end early");return n.take(t)}var zo=Float64Array.from({length:31},(n,t)=>2**(Math.max(t,1)-25)),Ls=new Float32Array(1),Os=new Uint32Array(Ls.buffer);function Ae(n){return(n&31744)===31744}function U(n){let t=n>>10&31,e=(n&1023)+(t>0?1024:0);return(n&32768?-e:e)*zo[t]}function q(n){Ls[0]=n;let t=Os[0]>>>16&32768,e=Os[0]&2147483647;if(e<947912704){let s=Math.abs(n)*16777216,o=Math.round(s);return t|(o-s===.5&&o%2?o-1:o)}return t|Math.min(e+4095+(e>>>13&1)-939524096>>>13,31743)}function _e(n,t){let e=Fo(n,t);if(e.some(Ae))throw new v(`the stream '${n.name}' of the .mgs file has numbers that are not finite`);return Float32Array.from(e,U)}function Fo({name:n,codec:t,data:e},s){let o=new v(`the stream '${n}' of the .mgs file has a wrong length`);if(t==="raw"){if(e.length!==2*s)throw o;return Uint16Array.from({length:s},(l,f)=>e[2*f]|e[2*f+1]<<8)}if(e.length<4)throw o;let r=4+D(e).getUint32(0,!0);if(r>e.length||t==="halves"&&e.length!==r+s)throw o;let i=Q(e.subarray(4,r),s,256),a=e.subarray(r),c=t==="planes"?Q(a,s,256):a;return i.map((l,f)=>l<<8|c[f])}var Io=49,J=24,Ct=Uint32Array.from({length:4096},(n,t)=>{let e=0;for(let s=0;s<12;s++)e|=(t>>>s&1)<<10*(s%3)+Math.floor(s/3);return e});function Us(n,t){let e=n.length<4?1/0:4+D(n).getUint32(0,!0);if(e>n.length)throw new v("the stream of positions is too short to hold what its header says");let s=Q(n.subarray(4,e),t,Io),o=0;for(let l=0;l<t;l++)o+=Math.max(s[l]-1,0);let r=ot(n.subarray(e),o),i=new Uint16Array(3*t),a=0,c=0;for(let l=0;l<t;l++){let f=s[l]-1;if(f>=J?(a+=r.take(J),c+=(1<<f-J)+r.take(f-J)):f>=0&&(a+=(1<<f)+r.take(f)),c+=a>>>J,a&=(1<<J)-1,c>>>J)throw new v("the stream of positions leaves its 48-bit grid");let h=Ct[a&4095]|Ct[a>>>12]<<4,d=Ct[c&4095]|Ct[c>>>12]<<4;for(let p=0,u=0;p<3;p++,u+=10){let w=h>>>u&255|(d>>>u&255)<<8,m=w&32768?w&32767:w^65535;if(Ae(m))throw new v("the stream of positions holds numbers that are not finite");i[3*l+p]=m}}return i}function zs(n,t){let e=3*Math.ceil(n.length/3/t);if(e<=3)return n;let s=new Uint16Array(3*Math.ceil(n.length/e));for(let o=0,r=0;o<n.length;o+=e,r+=3)s.set(n.subarray(o,o+3),r);return s}function Se(n,{center:t,radius:e,exponent:s}){let o=new Float32Array(n.length),r=e*2**s;for(let i=0;i<n.length;i++)o[i]=t[i%3]+Math.fround(r*U(n[i]));return o}function Dt(n){return"stored"in n?Se(n.stored,n.grid):n}var No={from:64,to:65536,times:4},Bo={from:32,to:1024,times:2},Fs=128,Ns="mobilegs variant 1";function Bs(n,t){let e=null;try{e=t?.getItem(`${Ns} ${n.describe()}`)??null}catch{}return n.variants.find(s=>$s(s)===e)??null}async function Cs(n,t){let e={floats:!1,strips:!1},s={...e};if(await Is(n,e,{...e,strips:!0},No,Co)&&(s.strips=!0),n.variants.some(({floats:o})=>o)){let o={...s,floats:!0};await Is(n,s,o,Bo,Do)&&(s.floats=!0)}try{t?.setItem(`${Ns} ${n.describe()}`,$s(s))}catch{}return s}async function Ds(n){n.setScene({...Te(1,1,()=>[0,0,1]),packing:{center:[0,0,0],unit:1,leastScaleBits:0,scaleBitsSpan:0},shapes:Uint32Array.of(0,15360,0,0),colors:new Uint32Array(4),shSize:4,lobes:new Uint32Array(5),lobeSize:9}),await n.drawUnseen(Me(1))}function Ps(n){n.setDots({means:Float32Array.of(0,0,1),color:[0,0,0],side:1,background:[0,0,0]}),n.drawDots(Me(1)),n.setDots(null)}var $s=({floats:n,strips:t})=>`${n} ${t}`;async function Is(n,t,e,{from:s,to:o,times:r},i){let a=0;for(let c=s;;c*=r){let{scene:l,side:f}=i(c);n.setScene(l);let h=[1/0,1/0];for(let p=0;p<=3;p++)for(let[u,w]of[t,e].entries()){n.variant=w;let m=performance.now();await n.drawUnseen(Me(f)),p>0&&(h[u]=Math.min(h[u],performance.now()-m))}let d=Math.max(...h);if(c===s&&(a=d),d>Math.max(4,3*a)||c>=o)return h[1]<.85*h[0]}}function Co(n){let t=Math.ceil(Math.sqrt(n)),e=o=>2*(o+.5)/t-1;return{scene:Te(n,.001,o=>[e(o%t),e(Math.floor(o/t)),1]),side:256}}function Do(n){return{scene:Te(Fs,1,t=>[0,0,1+t/Fs]),side:n}}function Te(n,t,e){let s=new Float32Array(12*n);for(let o=0;o<n;o++){let[r,i,a]=e(o);s.set([t,0,0,r,0,t,0,i,0,0,t,a],12*o)}return{count:n,packing:null,shapes:s,colors:new Float32Array(3*n),shSize:1,lobes:new Float32Array(2*n).fill(1),lobeSize:1,sorted:!1,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},background:[0,0,0]}}function Me(n){return{viewmat:[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],fx:n/2,fy:n/2,cx:n/2,cy:n/2,width:n,height:n,near:.1}}function Gs(n){let[t,e,s]=[1,2,3].map(c=>n[`hidden${c}.weight`]),o=["opacity","phi"].map(c=>({weights:Po(n[`${c}.weight`],s,128),offset:n[`${c}.weight`].reduce((l,f,h)=>l+f*n["hidden3.bias"][h],n[`${c}.bias`][0])})),r=new Float32Array(16*2497),i=0,a=(c,l,f)=>{for(let h=c;h<c+4;h++)for(let d=l;d<l+4;d++)r[i++]=f(h,d)};for(let c=0;c<256;c+=4)for(let l=0;l<24;l+=4)a(c,l,(f,h)=>h<22?t[22*f+h]:h===22?n["hidden1.bias"][f]:0);for(let c=0;c<128;c+=4)a(c,0,(l,f)=>f===0?n["hidden2.bias"][l]:0);for(let c=0;c<256;c+=4)for(let l=0;l<128;l+=4)a(l,c,(f,h)=>e[256*f+h]);for(let c=0;c<128;c+=4)a(0,c,(l,f)=>o[l]?.weights[f]??0);return a(0,0,(c,l)=>l===0?o[c]?.offset??0:0),r}function Po(n,t,e){return Array.from({length:e},(s,o)=>n.reduce((r,i,a)=>r+i*t[e*a+o],0))}function at({packing:n,shSize:t,lobeSize:e,network:s}){return n?{shapes:4,colors:4,lobes:s?10:e+2>>1}:{shapes:12,colors:3*t,lobes:2*e}}function qs(n){return U(n&65535)}function Pt(n,{viewmat:t,fx:e,fy:s,cx:o,cy:r,width:i,height:a,near:c},l){let{background:f,weighting:h,packing:d}=n,p=.3*.5*i/e,u=.3*.5*a/s,w=[0,1,2].map(E=>-(t[E]*t[3]+t[4+E]*t[7]+t[8+E]*t[11])),m=new Float32Array(192/4);m.set([...Array.from(t).slice(0,12),...w,c,e,s,o,r,-o/e-p,(i-o)/e+p,-r/s-u,(a-r)/s+u,...f,h.exponentMax,i,a,h.sigma,h.backgroundWeight,l]);let y=[n.count,n.shSize,n.lobeSize,h.index];if(new Int32Array(m.buffer).set(y,33),d){let{center:E,unit:k,leastScaleBits:x,scaleBitsSpan:A}=d;m.set([...E,k,x,A],40)}return m[46]=!n.sorted&&h.alphaMin||1/255,m}var $t=class{milliseconds=null;#t;#s;#o=!1;#e=!1;#n=[];constructor(t){this.#t=t,this.#s=t.getExtension("EXT_disjoint_timer_query_webgl2")}start(){this.#e=this.#o&&!this.#n.length}pass(t){if(!this.#e)return;let[e,s]=[this.#t,this.#s.TIME_ELAPSED_EXT];if(this.#n.length&&e.endQuery(s),t){let o=e.createQuery();this.#n.push([t,o]),e.beginQuery(s,o)}else this.#e=!1}async time(){let t=this.#t;this.#o=this.#s!==null;let e=this.#n[this.#n.length-1];if(!e||this.#e)return;for(let o=0;o<100&&!t.getQueryParameter(e[1],t.QUERY_RESULT_AVAILABLE);o++)await new Promise(r=>setTimeout(r,5));let s=this.#n.map(([o,r])=>[o,t.getQueryParameter(r,t.QUERY_RESULT)/1e6]);t.getParameter(this.#s.GPU_DISJOINT_EXT)||(this.milliseconds=Object.fromEntries(s));for(let[,o]of this.#n.splice(0))t.deleteQuery(o)}forget(){this.#n=[],this.#e=!1}};function Gt({color:n,side:t},{viewmat:e,fx:s,fy:o,cx:r,cy:i,width:a,height:c,near:l}){let[f,h,d]=[0,4,8].map(p=>Array.from(e).slice(p,p+4));return Float32Array.of(...f.map((p,u)=>2*(s*p+r*d[u])/a-d[u]),...h.map((p,u)=>d[u]-2*(o*p+i*d[u])/c),...d,...n,l,o*t/2,.002*c/2,2/a,2/c)}function qt({means:n}){let t=new Float32Array(6*n.length);for(let e=0,s=0;e<n.length;e+=3)for(let o=s+18;s<o;s+=3)t[s]=n[e],t[s+1]=n[e+1],t[s+2]=n[e+2];return t}var Ht=["shapes","colors","lobes","looks","opacities","order","color_sums","weight_sums"],Wt=class{#t;#s=new Map;constructor(t){this.#t=t}make(t,e,[s,o]){let r=this.#t;r.deleteTexture(this.#s.get(t)??null);let i=r.createTexture();return this.#s.set(t,i),r.activeTexture(r.TEXTURE0+Ht.indexOf(t)),r.bindTexture(r.TEXTURE_2D,i),r.texStorage2D(r.TEXTURE_2D,1,e,s,o),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MIN_FILTER,r.NEAREST),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MAG_FILTER,r.NEAREST),i}upload(t,e,s){let o=this.#t,[r,,i]=e,a=Xt(s.length/i);if(a[1]>o.getParameter(o.MAX_TEXTURE_SIZE))throw new Error("the scene has more Gaussians than this GPU's textures can hold");this.make(t,o[r],a),this.write(t,e,0,s)}write(t,[,e,s],o,r){let i=this.#t,a=r instanceof Float32Array?i.FLOAT:i.UNSIGNED_INT,c=r.length/s;i.activeTexture(i.TEXTURE0+Ht.indexOf(t));for(let l=0;l<c;){let[f,h]=[(o+l)%4096,Math.floor((o+l)/4096)],d=Math.min(4096-f,c-l),p=d===4096?Math.floor((c-l)/4096):1,u=l*s;i.texSubImage2D(i.TEXTURE_2D,0,f,h,d,p,i[e],a,r,u),l+=d*p}}destroy(){for(let t of this.#s.values())this.#t.deleteTexture(t)}};function Xt(n){return[Math.max(1,Math.min(n,4096)),Math.max(1,Math.ceil(n/4096))]}var jt=128,Hs=0,Oe=["EXT_color_buffer_float","EXT_color_buffer_half_float"];function Le(n){return["EXT_color_buffer_float","EXT_float_blend"].every(t=>n.getExtension(t))}function Ue(n){for(let r of[...Oe,"EXT_float_blend"])n.getExtension(r);let t=n.getExtension("WEBGL_provoking_vertex");t?.provokingVertexWEBGL(t.FIRST_VERTEX_CONVENTION_WEBGL),n.disable(n.DITHER);let e={view:n.createBuffer(),corners:n.createBuffer(),quads:n.createVertexArray(),looks:n.createFramebuffer(),sums:n.createFramebuffer(),programs:new Map,textures:new Wt(n)};n.bindBufferBase(n.UNIFORM_BUFFER,Hs,e.view),n.bufferData(n.UNIFORM_BUFFER,192,n.DYNAMIC_DRAW),n.bindVertexArray(e.quads),n.bindBuffer(n.ELEMENT_ARRAY_BUFFER,e.corners);let s=[0,1,2,2,1,3],o=Array.from({length:jt},(r,i)=>s.map(a=>4*i+a));return n.bufferData(n.ELEMENT_ARRAY_BUFFER,Uint16Array.from(o.flat()),n.STATIC_DRAW),e}function Ws(n,t,{sorted:e,packed:s,strips:o}){let{view:r,whole:i,project:a,splat:c,resolve:l}=t,f=s?t.packed:t.wide,h=`${e?`#define SORTED
`:""}${o?`#define STRIPS
`:""}`,d=(p,u)=>{let w=ze(n,`${h}#define VERTEX
${r}${p}`,`${h}${r}${u}`);return n.useProgram(w),Ht.forEach((m,y)=>n.uniform1i(n.getUniformLocation(w,m),y)),n.uniformBlockBinding(w,n.getUniformBlockIndex(w,"View"),Hs),w};return{project:d(i,`${f}${a}`),splat:d(`${f}${c}`,c),resolve:d(i,l)}}function ze(n,t,e){let s=n.createProgram();for(let[o,r]of[[n.VERTEX_SHADER,t],[n.FRAGMENT_SHADER,e]]){let i=n.createShader(o);n.shaderSource(i,`#version 300 es
${r}`),n.compileShader(i),n.attachShader(s,i),n.deleteShader(i)}if(n.linkProgram(s),!n.getProgramParameter(s,n.LINK_STATUS)&&!n.isContextLost()){let o=(n.getAttachedShaders(s)??[]).map(r=>n.getShaderInfoLog(r));throw o.push(n.getProgramInfoLog(s)),new Error(`this GPU refuses a shader: ${o.join(" ")}`)}return s}var Vt=class{#t;#s=null;#o;#e;#n;#r=0;constructor(t,e){this.#t=t,this.#o=ze(t,`#define VERTEX
${e}`,e),this.#e=t.createVertexArray(),this.#n=t.createBuffer(),t.bindVertexArray(this.#e),t.bindBuffer(t.ARRAY_BUFFER,this.#n),t.enableVertexAttribArray(0),t.vertexAttribPointer(0,3,t.FLOAT,!1,0,0)}take(t){let[e,s]=[this.#t,t?qt(t):new Float32Array(0)];this.#s=t,this.#r=s.length/3,e.bindBuffer(e.ARRAY_BUFFER,this.#n),e.bufferData(e.ARRAY_BUFFER,s,e.STATIC_DRAW)}draw(t){let[e,s]=[this.#t,this.#s];s&&(e.bindFramebuffer(e.FRAMEBUFFER,null),e.viewport(0,0,t.width,t.height),e.disable(e.BLEND),e.clearBufferfv(e.COLOR,0,[...s.background,1]),e.useProgram(this.#o),e.uniform4fv(e.getUniformLocation(this.#o,"dots"),Gt(s,t)),e.bindVertexArray(this.#e),e.drawArrays(e.TRIANGLES,0,this.#r))}destroy(){let t=this.#t;t.deleteProgram(this.#o),t.deleteVertexArray(this.#e),t.deleteBuffer(this.#n)}};var Fe=new Float32Array(0),js={shapes:["RGBA32UI","RGBA_INTEGER",4],colors:["RGBA32UI","RGBA_INTEGER",4],lobes:["R32UI","RED_INTEGER",1]},Ys={shapes:["RGBA32F","RGBA",4],colors:["RGB32F","RGB",3],lobes:["RG32F","RG",2]},$o={...Ys,colors:["RGB16F","RGB",3],lobes:["RG16F","RG",2]},Vs=["R32UI","RED_INTEGER",1],vt=class n{static files=["view","wide","packed","whole","project","splat","resolve","dots"].map(t=>`${t}.glsl`);variant;lost=null;onLost=()=>{};onRestored=()=>{};#t;#s;#o;#e=null;#n=js;#r=null;#i="";#a;#c=t=>{t.preventDefault(),this.#e=this.#r=null,this.lost="the browser took the GPU away from this page: reload it if no picture returns",this.onLost(this.lost)};#l=()=>{this.#e=null,this.#o=Ue(this.#t),this.#i="",this.#a.forget(),this.lost=null,this.onRestored()};static create(t,e,{floats:s=!1,strips:o=!1}={}){let r=t.getContext("webgl2",{alpha:!1,antialias:!1,depth:!1,powerPreference:"high-performance"});if(r===null)throw new Error("this browser cannot draw with WebGL2 here");if(!Oe.some(i=>r.getExtension(i)))throw new Error("this GPU cannot draw into textures of floats");if(s&&!Le(r))throw new Error("this GPU cannot blend 32-bit floats: use the variant halves");if(r.getParameter(r.MAX_TEXTURE_SIZE)<4096)throw new Error(`this GPU's textures are less than ${4096} pixels wide`);return new n(r,e,{floats:s,strips:o})}constructor(t,e,s){this.#t=t,this.#s=e,this.variant=s,this.#o=Ue(t),this.#a=new $t(t),t.canvas.addEventListener("webglcontextlost",this.#c),t.canvas.addEventListener("webglcontextrestored",this.#l)}setScene(t){let e=this.#t;if(this.#e=null,t.network)throw new Error("this scene needs a network for every Gaussian in every frame, which takes WebGPU: open it in a browser that has it");this.#n=t.packing?js:this.variant.floats?Ys:$o;let{shapes:s,colors:o,lobes:r}=t;for(let[a,c]of Object.entries({shapes:s,colors:o,lobes:r}))this.#o.textures.upload(a,this.#n[a],c);e.bindFramebuffer(e.FRAMEBUFFER,this.#o.looks);let i=t.packing?[e.RG32UI,0]:[e.RGBA32F,e.R32F];["looks","opacities"].forEach((a,c)=>{let l=i[c]?this.#o.textures.make(a,i[c],Xt(t.count)):null;e.framebufferTexture2D(e.FRAMEBUFFER,e.COLOR_ATTACHMENT0+c,e.TEXTURE_2D,l,0)}),this.#g("textures of 32-bit numbers"),this.#e={...t,shapes:Fe,colors:Fe,lobes:Fe},t.sorted&&this.#o.textures.upload("order",Vs,Uint32Array.from({length:t.count},(a,c)=>c))}show(t){this.#e&&(this.#e.count=t)}update(t,e,s){if(this.#e===null)return;let o=this.#n[t];this.#o.textures.write(t,o,at(this.#e)[t]/o[2]*e,s)}setDots(t){this.lost===null&&(this.#r??=new Vt(this.#t,this.#s.dots),this.#r.take(t))}drawDots(t){this.#r&&(this.#f(t),this.#r.draw(t))}setOrder(t){if(this.#e!==null){if(t.length!==this.#e.count)throw new Error(`an order of ${t.length} Gaussians does not fit this scene`);this.#o.textures.write("order",Vs,0,t)}}draw(t){this.#e!==null&&(this.#f(t),this.#a.start(),this.#d(this.#e,t),this.#w(this.#e,null,t.height-1),this.#a.pass())}async drawUnseen(t){let e=this.#t;if(this.#e&&this.#d(this.#e,t),e.readBuffer(e.COLOR_ATTACHMENT0),e.readPixels(0,0,1,1,e.RGBA,e.FLOAT,new Float32Array(4)),e.isContextLost())throw new Error("the graphics device was lost")}get milliseconds(){return this.#a.milliseconds}async time(){this.lost===null&&await this.#a.time()}async finished(){this.#t.bindFramebuffer(this.#t.FRAMEBUFFER,null),this.#t.readPixels(0,0,1,1,this.#t.RGBA,this.#t.UNSIGNED_BYTE,new Uint8Array(4))}get variants(){return(Le(this.#t)?[!1,!0]:[!1]).flatMap(t=>[{floats:t,strips:!1},{floats:t,strips:!0}])}describe(){let t=this.#t,e=t.getExtension("WEBGL_debug_renderer_info");return String(t.getParameter(e?e.UNMASKED_RENDERER_WEBGL:t.RENDERER))}async pixels(t){if(this.#e===null)throw new Error("there is no scene to draw");let e=this.#t,{width:s,height:o}=t;this.#d(this.#e,t);let[r,i]=[e.createFramebuffer(),e.createRenderbuffer()];e.bindFramebuffer(e.FRAMEBUFFER,r),e.bindRenderbuffer(e.RENDERBUFFER,i),e.renderbufferStorage(e.RENDERBUFFER,e.RGBA32F,s,o),e.framebufferRenderbuffer(e.FRAMEBUFFER,e.COLOR_ATTACHMENT0,e.RENDERBUFFER,i),this.#w(this.#e,r,0);let a=new Float32Array(4*s*o);return e.readPixels(0,0,s,o,e.RGBA,e.FLOAT,a),e.deleteFramebuffer(r),e.deleteRenderbuffer(i),a}destroy(){let t=this.#t,{view:e,corners:s,quads:o,looks:r,sums:i,programs:a,textures:c}=this.#o;this.#e=null,this.#r?.destroy(),t.canvas.removeEventListener("webglcontextlost",this.#c),t.canvas.removeEventListener("webglcontextrestored",this.#l),c.destroy();for(let l of a.values())for(let f of Object.values(l))t.deleteProgram(f);for(let l of[r,i])t.deleteFramebuffer(l);t.deleteVertexArray(o);for(let l of[e,s])t.deleteBuffer(l);t.getExtension("WEBGL_lose_context")?.loseContext()}#f({width:t,height:e}){let{canvas:s}=this.#t;s.width!==t&&(s.width=t),s.height!==e&&(s.height=e)}#d(t,e){let s=this.#t,{view:o,quads:r,looks:i,sums:a}=this.#o,c=this.#m(t);this.#h(t.sorted,e),s.bindBuffer(s.UNIFORM_BUFFER,o);let l=Pt(t,e,this.variant.floats?1:.015625);s.bufferSubData(s.UNIFORM_BUFFER,0,l),s.bindVertexArray(r),s.disable(s.BLEND),s.bindFramebuffer(s.FRAMEBUFFER,i),s.drawBuffers([s.COLOR_ATTACHMENT0,t.packing?s.NONE:s.COLOR_ATTACHMENT1]);let[f,h]=Xt(t.count);if(s.viewport(0,0,f,h),s.useProgram(c.project),this.#a.pass("project"),s.drawArrays(s.TRIANGLES,0,3),s.bindFramebuffer(s.FRAMEBUFFER,a),s.viewport(0,0,e.width,e.height),s.enable(s.BLEND),s.useProgram(c.splat),this.#a.pass("splat"),t.sorted?(s.drawBuffers([s.COLOR_ATTACHMENT0]),s.clearBufferfv(s.COLOR,0,[0,0,0,0]),s.blendFunc(s.ONE,s.ONE_MINUS_SRC_ALPHA)):(s.drawBuffers([s.COLOR_ATTACHMENT0,s.COLOR_ATTACHMENT1]),s.clearBufferfv(s.COLOR,0,[0,0,0,1]),s.clearBufferfv(s.COLOR,1,[0,0,0,0]),s.blendFuncSeparate(s.ONE,s.ONE,s.ZERO,s.ONE_MINUS_SRC_ALPHA)),this.variant.strips)s.drawArraysInstanced(s.TRIANGLE_STRIP,0,4,t.count);else{let d=Math.ceil(t.count/jt);s.drawElementsInstanced(s.TRIANGLES,6*jt,s.UNSIGNED_SHORT,0,d)}}#w(t,e,s){let o=this.#t,{resolve:r}=this.#m(t);o.bindFramebuffer(o.FRAMEBUFFER,e),o.disable(o.BLEND),o.useProgram(r),this.#a.pass("resolve"),o.uniform1i(o.getUniformLocation(r,"last_row"),s),o.drawArrays(o.TRIANGLES,0,3)}#h(t,{width:e,height:s}){let{floats:o}=this.variant,r=`${e} ${s} ${t} ${o}`;if(r===this.#i)return;let i=this.#t,a=i.getParameter(i.MAX_TEXTURE_SIZE);if(!(e>0&&e<=a&&s>0&&s<=a))throw new Error(`an image of ${e}x${s} pixels cannot be rendered: each side must lie between 1 and ${a}`);i.bindFramebuffer(i.FRAMEBUFFER,this.#o.sums);let c=o?[i.RGBA32F,i.R32F]:[i.RGBA16F,i.R16F];["color_sums","weight_sums"].forEach((l,f)=>{let h=t&&f>0?null:this.#o.textures.make(l,c[f],[e,s]);i.framebufferTexture2D(i.FRAMEBUFFER,i.COLOR_ATTACHMENT0+f,i.TEXTURE_2D,h,0)}),this.#g(`pictures of ${e}x${s} floats`),this.#i=r}#m({sorted:t,packing:e}){let{programs:s}=this.#o,o={sorted:t,packed:e!==null,strips:this.variant.strips},r=Object.values(o).join(" "),i=s.get(r)??Ws(this.#t,this.#s,o);return s.set(r,i),i}#g(t){let e=this.#t;if(e.checkFramebufferStatus(e.FRAMEBUFFER)!==e.FRAMEBUFFER_COMPLETE&&!e.isContextLost())throw new Error(`this GPU cannot draw into ${t}`)}};var Yt=class{#t;#s;#o;#e;#n;#r;constructor(t,e,s){let{device:o}=t;this.#t=o,this.#s=e,this.#o=t.dots(s);let{UNIFORM:r,VERTEX:i,COPY_DST:a}=GPUBufferUsage;this.#e=o.createBuffer({size:80,usage:r|a});let c=qt(e);this.#r=c.length/3,this.#n=t.filled(c,i)}draw(t,e){let[s,o,r]=[this.#t,this.#o,this.#s];s.queue.writeBuffer(this.#e,0,Gt(r,t));let i=s.createCommandEncoder(),a=i.beginRenderPass({colorAttachments:[{view:e,loadOp:"clear",storeOp:"store",clearValue:[...r.background,1]}]}),c=[{binding:0,resource:{buffer:this.#e}}];a.setPipeline(o),a.setBindGroup(0,s.createBindGroup({layout:o.getBindGroupLayout(0),entries:c})),a.setVertexBuffer(0,this.#n),a.draw(this.#r),a.end(),s.queue.submit([i.finish()])}destroy(){this.#e.destroy(),this.#n.destroy()}};var W=128,yt=["network","project","splat","resolve"],Kt=class n{milliseconds=null;#t;#s=new Map;#o=new Map;#e=null;static async create(t,e){if(!("gpu"in navigator))throw new Error("this browser has no WebGPU on this page: it may need https, or a newer version");let s=await ks();if(s===null)throw new Error("WebGPU finds no graphics adapter on this device");let r=["timestamp-query","float32-blendable","shader-f16"].filter(l=>s.features.has(l));if(e&&!r.includes("float32-blendable"))throw new Error("this device cannot blend 32-bit floats");let{maxStorageBufferBindingSize:i,maxBufferSize:a}=s.limits,c=await s.requestDevice({requiredFeatures:r,requiredLimits:{maxStorageBufferBindingSize:i,maxBufferSize:a}});return new n(c,t)}constructor(t,e){if(this.device=t,this.#t=e,t.features.has("timestamp-query")){let s=16*yt.length,o=GPUBufferUsage;this.#e={queries:t.createQuerySet({type:"timestamp",count:2*yt.length}),found:t.createBuffer({size:s,usage:o.QUERY_RESOLVE|o.COPY_SRC}),read:t.createBuffer({size:s,usage:o.MAP_READ|o.COPY_DST})}}}get blendsFloats(){return this.device.features.has("float32-blendable")}get number(){return this.device.features.has("shader-f16")?"f16":"f32"}network(t){return this.#n(`network ${t.packed}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#r("network",t),entryPoint:"evaluate_network"}}))}project(t,{strips:e}){return this.#n(`project ${t.packed} ${t.sorted} ${e}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#r("project",t),entryPoint:"project_all",constants:{SORTED:Number(t.sorted),STRIPS:Number(e)}}}))}splat(t,{floats:e,strips:s}){return this.#n(`splat ${t.packed} ${t.sorted} ${s} ${e}`,()=>{let o={srcFactor:"one",dstFactor:"one-minus-src-alpha",operation:"add"},r=t.sorted?{color:o,alpha:o}:{color:{srcFactor:"one",dstFactor:"one",operation:"add"},alpha:{srcFactor:"zero",dstFactor:"one-minus-src-alpha",operation:"add"}},i=this.#r("splat",t);return this.device.createRenderPipeline({layout:"auto",vertex:{module:i,entryPoint:"corner",constants:{SORTED:Number(t.sorted),STRIPS:Number(s)}},primitive:{topology:s?"triangle-strip":"triangle-list"},fragment:{module:i,entryPoint:t.sorted?"cover":"add_weighted",targets:Be(t.sorted,e).map(a=>({format:a,blend:r}))}})})}resolve(t,e){return this.#n(`resolve ${t} ${e}`,()=>{let s=this.#r("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:s,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:s,entryPoint:t?"resolve_sorted":"resolve_sortfree",targets:[{format:e}]}})})}dots(t){return this.#n(`dots ${t}`,()=>{let e=this.device.createShaderModule({code:this.#t.dots,label:"dots"}),s=[{shaderLocation:0,offset:0,format:"float32x3"}];return this.device.createRenderPipeline({layout:"auto",vertex:{module:e,entryPoint:"corner_of_dot",buffers:[{arrayStride:12,attributes:s}]},fragment:{module:e,entryPoint:"paint_dot",targets:[{format:t}]}})})}filled(t,e){let s=Math.ceil(t.byteLength/4)*4,o=this.device.createBuffer({size:s,usage:e,mappedAtCreation:!0}),r=new Uint8Array(t.buffer,t.byteOffset,t.byteLength);return new Uint8Array(o.getMappedRange()).set(r),o.unmap(),o}bind(t,e){return this.device.createBindGroup({layout:t.getBindGroupLayout(0),entries:Object.entries(e).map(([s,o])=>({binding:Number(s),resource:o instanceof GPUBuffer?{buffer:o}:o}))})}stamps(t){if(this.#e===null)return;let e=2*yt.indexOf(t);return{querySet:this.#e.queries,beginningOfPassWriteIndex:e,endOfPassWriteIndex:e+1}}async time({network:t}){if(this.#e===null||this.#e.read.mapState!=="unmapped")return;let{queries:e,found:s,read:o}=this.#e,r=this.device.createCommandEncoder();r.resolveQuerySet(e,0,2*yt.length,s,0),r.copyBufferToBuffer(s,0,o,0,o.size),this.device.queue.submit([r.finish()]),await o.mapAsync(GPUMapMode.READ);let i=new BigUint64Array(o.getMappedRange()),a=yt.map((c,l)=>[c,Number(i[2*l+1]-i[2*l])/1e6]);this.milliseconds=Object.fromEntries(t?a:a.slice(1)),o.unmap()}#n(t,e){let s=this.#o.get(t)??e();return this.#o.set(t,s),s}#r(t,e){let s=e===null?"":this.#t[e.packed?"packed":"wide"],o=`${t} ${e?.packed}`,r=this.number==="f16"?`enable f16;
`:"",a=`${t==="network"?`${r}alias Num = ${this.number};
`:""}${this.#t.view}
${s}
${this.#t[t]}`,c=this.#s.get(o)??this.device.createShaderModule({code:a,label:t});return this.#s.set(o,c),c}};function Ne(n,t){return Object.fromEntries(n.map((e,s)=>[t+s,e]))}function Be(n,t){return t?n?["rgba32float"]:["rgba32float","r32float"]:n?["rgba16float"]:["rgba16float","r16float"]}var Ho={packed:8,wide:32},Ce=new Float32Array(0),xt=class n{static files=["view","wide","packed","network","project","splat","resolve","dots"].map(t=>`${t}.wgsl`);variant;lost=null;onLost=()=>{};#t;#s;#o;#e;#n;#r=null;#i=null;#a=null;#c=null;#l;#f;#d;static async create(t,e,{floats:s=!1,strips:o=!1}={}){let r=await Kt.create(e,s);return new n(r,t,{floats:s,strips:o})}constructor(t,e,s){let o=e.getContext("webgpu");if(o===null)throw new Error("this canvas is already drawn to in another way");let{device:r}=t;this.variant=s,this.#t=t,this.#s=r,this.#e=e,this.#o=o,this.#n=navigator.gpu.getPreferredCanvasFormat(),o.configure({device:r,format:this.#n,alphaMode:"opaque"});let i=GPUBufferUsage;this.#l=r.createBuffer({size:192,usage:i.UNIFORM|i.COPY_DST});let a=i.STORAGE|i.INDIRECT|i.COPY_DST;this.#f=r.createBuffer({size:20,usage:a});let c=new Uint16Array(6*W);for(let l=0;l<W;l++)c.set([0,1,2,2,1,3].map(f=>4*l+f),6*l);this.#d=t.filled(c,i.INDEX),r.lost.then(({reason:l})=>{l!=="destroyed"&&this.#w("the graphics device was lost: reload the page to go on")}),r.onuncapturederror=({error:l})=>this.#w(`this GPU cannot draw the scene: ${l.message}`)}get variants(){return(this.#t.blendsFloats?[!1,!0]:[!1]).flatMap(t=>[{floats:t,strips:!1},{floats:t,strips:!0}])}get milliseconds(){return this.#t.milliseconds}setScene(t){this.#h();let{count:e,sorted:s}=t,o={sorted:s,packed:t.packing!==null,network:!!t.network},r=Ho[o.packed?"packed":"wide"]*Math.max(e,1),i={shapes:t.shapes,colors:t.colors,lobes:t.lobes},a=Math.max(r,...Object.values(i).map(u=>u.byteLength)),{maxStorageBufferBindingSize:c,maxBufferSize:l}=this.#s.limits,f=Math.min(c,l);if(a>f)throw new Error(`${e} Gaussians need ${Math.ceil(a/2**20)} MiB at a stretch, and this device gives ${Math.floor(f/2**20)}`);let h=GPUBufferUsage,d=u=>this.#t.filled(u.length?u:new Uint32Array(16),h.STORAGE|h.COPY_DST),p=u=>this.#s.createBuffer({size:4*Math.max(1,u),usage:h.STORAGE|h.COPY_DST});this.#i={kind:o,parts:{shapes:d(i.shapes),colors:d(i.colors),lobes:d(i.lobes)},looks:this.#s.createBuffer({size:r,usage:h.STORAGE}),batches:p(Math.ceil(e/W)),order:s?p(e):null,network:t.network?{weights:this.#t.filled(this.#b(t.network),h.STORAGE),lobes:p(e)}:null},this.#r={...t,shapes:Ce,colors:Ce,lobes:Ce},s&&this.setOrder(Uint32Array.from({length:e},(u,w)=>w))}show(t){this.#r&&(this.#r.count=t)}update(t,e,s){if(!this.#r||!this.#i||this.lost!==null)return;let o=4*at(this.#r)[t]*e;this.#s.queue.writeBuffer(this.#i.parts[t],o,s)}setDots(t){this.#a?.destroy(),this.#a=t&&new Yt(this.#t,t,this.#n)}drawDots(t){this.lost===null&&this.#a?.draw(t,this.#g(t))}setOrder(t){let e=this.#i?.order;e&&this.#s.queue.writeBuffer(e,0,t)}draw(t){this.lost===null&&this.#u(t,this.#g(t),this.#n)}async pixels(t){let{width:e,height:s}=t,o=Math.ceil(16*e/256)*256,r=this.#v(e,s,"rgba32float");this.#u(t,r.createView(),"rgba32float");let i=this.#s.createBuffer({size:o*s,usage:GPUBufferUsage.MAP_READ|GPUBufferUsage.COPY_DST}),a=this.#s.createCommandEncoder();a.copyTextureToBuffer({texture:r},{buffer:i,bytesPerRow:o},[e,s]),this.#s.queue.submit([a.finish()]),await i.mapAsync(GPUMapMode.READ);let c=new Float32Array(i.getMappedRange()),l=new Float32Array(4*e*s);for(let f=0;f<s;f++){let h=f*o/4;l.set(c.subarray(h,h+4*e),4*e*f)}return i.destroy(),r.destroy(),l}async drawUnseen(t){let e=this.#v(t.width,t.height,this.#n);if(this.#u(t,e.createView(),this.#n),await this.finished(),e.destroy(),this.lost!==null)throw new Error(this.lost)}async finished(){await this.#s.queue.onSubmittedWorkDone()}describe(){let t=this.#s.adapterInfo;return[t?.vendor,t?.architecture,t?.device,t?.description].filter(Boolean).join(" ")}async time(){this.lost===null&&this.#i&&await this.#t.time(this.#i.kind)}destroy(){this.#h(),this.setDots(null),this.#s.onuncapturederror=null,this.#s.destroy()}#w(t){this.lost===null&&(this.lost=t,this.onLost(t))}#h(){for(let t of this.#m())t.destroy();this.#i=this.#r=null}#m(){if(this.#i===null)return[];let{parts:t,looks:e,batches:s,order:o,network:r}=this.#i;return[...Object.values(t),e,s,...o?[o]:[],...Object.values(r??{})]}#g({width:t,height:e}){return this.#e.width!==t&&(this.#e.width=t),this.#e.height!==e&&(this.#e.height=e),this.#o.getCurrentTexture().createView()}#v(t,e,s){let o=GPUTextureUsage;return this.#s.createTexture({size:[t,e],format:s,usage:o.RENDER_ATTACHMENT|o.COPY_SRC})}#u(t,e,s){let o=this.#r;if(!o||!this.#i)return;let{queue:r}=this.#s,{floats:i,strips:a}=this.variant;r.writeBuffer(this.#l,0,Pt(o,t,i?1:.015625)),r.writeBuffer(this.#f,0,Uint32Array.of(a?4:6*W,0,0,0,0));let c=this.#A(t.width,t.height,o.sorted),l=this.#s.createCommandEncoder();this.#y(l,o.count,this.#i),this.#x(l,o.count,this.#i),this.#E(l,o.count,this.#i,c);let f=this.#t.resolve(o.sorted,s),h=l.beginRenderPass({colorAttachments:[{view:e,loadOp:"clear",storeOp:"store"}],timestampWrites:this.#t.stamps("resolve")});h.setPipeline(f),h.setBindGroup(0,this.#t.bind(f,{0:this.#l,...Ne(c,1)})),h.draw(3),h.end(),r.submit([l.finish()])}#b(t){return this.#t.number==="f16"?Uint16Array.from(t,q):t}#y(t,e,{kind:s,parts:o,network:r}){if(r===null)return;let i={0:this.#l,1:o.shapes,4:o.lobes,5:r.weights,6:r.lobes};this.#k(t,"network",this.#t.network(s),i,Math.ceil(e/32))}#x(t,e,{kind:s,parts:o,looks:r,batches:i,network:a}){let c=a?.lobes??o.lobes,l=[this.#l,o.shapes,o.colors,c,r,i,this.#f],f=this.#t.project(s,this.variant);this.#k(t,"project",f,Ne(l,0),Math.ceil(e/W))}#k(t,e,s,o,r){let i=Math.max(1,Math.min(r,65535)),a=t.beginComputePass({timestampWrites:this.#t.stamps(e)});a.setPipeline(s),a.setBindGroup(0,this.#t.bind(s,o)),a.dispatchWorkgroups(i,Math.ceil(r/i)),a.end()}#E(t,e,{kind:s,parts:o,looks:r,batches:i,order:a},c){let l=[{r:0,g:0,b:0,a:s.sorted?0:1},{r:0,g:0,b:0,a:0}],f=this.#t.splat(s,this.variant),h=t.beginRenderPass({colorAttachments:c.map((p,u)=>({view:p,loadOp:"clear",storeOp:"store",clearValue:l[u]})),timestampWrites:this.#t.stamps("splat")});h.setPipeline(f);let d={0:this.#l,1:o.shapes,4:r,5:a??i};h.setBindGroup(0,this.#t.bind(f,d)),h.setIndexBuffer(this.#d,"uint16"),this.variant.strips?s.sorted?h.draw(4,e):h.drawIndirect(this.#f,0):s.sorted?h.drawIndexed(6*W,Math.ceil(e/W)):h.drawIndexedIndirect(this.#f,0),h.end()}#A(t,e,s){let o=`${t} ${e} ${s} ${this.variant.floats}`;if(this.#c?.key===o)return this.#c.views;for(let c of this.#c?.textures??[])c.destroy();let r=GPUTextureUsage,i=Be(s,this.variant.floats).map(c=>this.#s.createTexture({size:[t,e],format:c,usage:r.RENDER_ATTACHMENT|r.TEXTURE_BINDING})),a=i.map(c=>c.createView());return this.#c={key:o,textures:i,views:a},a}};async function Qt(n,t){let e="";if(t!=="webgl")try{let s=await Ks(xt.files);return{name:"WebGPU",renderer:await xt.create(n,s)}}catch(s){if(t==="webgpu")throw s;e=s instanceof Error?s.message:String(s)}try{return{name:"WebGL2",renderer:vt.create(n,await Ks(vt.files))}}catch(s){let o=s instanceof Error?s.message:String(s);throw new Error(`this browser cannot draw the scene: ${e?`${e}; `:""}${o}`)}}async function Ks(n){let t=n.map(async e=>[e.replace(/\.[a-z]+$/,""),await As(e)]);return Object.fromEntries(await Promise.all(t))}var Qs=new Map;function Js(n){let t=Qs.get(n)??Wo(n);return Qs.set(n,t),t}async function Wo(n){let{renderer:t}=await Qt(document.createElement("canvas"),n);try{return await Cs(t,De())}finally{t.destroy()}}function De(){try{return localStorage}catch{return null}}var S=(n,t,e=1)=>[n[0]+e*t[0],n[1]+e*t[1],n[2]+e*t[2]],I=(n,t)=>S(n,t,-1),O=(n,t)=>n[0]*t[0]+n[1]*t[1]+n[2]*t[2],H=(n,t)=>[n[1]*t[2]-n[2]*t[1],n[2]*t[0]-n[0]*t[2],n[0]*t[1]-n[1]*t[0]],ct=n=>Math.hypot(...n);function X(n){let t=ct(n);return t>0?[n[0]/t,n[1]/t,n[2]/t]:[1,0,0]}function Pe(n,t,e){let[s,o]=[Math.cos(e),Math.sin(e)],r=O(n,t)*(1-s),i=H(t,n);return S(S([n[0]*s,n[1]*s,n[2]*s],i,o),t,r)}var Xo=Math.cos(.5*Math.PI/180),Jt=class{by="";#t=!1;#s=null;reset(t){this.by=t,this.#t=!1}invalidate(){this.#s=null}get pending(){return this.#t}received(){this.#t=!1}neededDirection({viewmat:t}){let e=[t[8],t[9],t[10]],s=this.#s!==null&&O(e,this.#s)>=Xo;return!this.by||this.#t||s?null:(this.#t=this.by==="worker",this.#s=e)}};var Zs=12;function tn(n,t,e,s,o){let{viewmat:r,fx:i,fy:a,cx:c,cy:l,near:f}=e,h=-1,d=1/0;for(let p=0;3*p<n.length;p++){if(t[p]<0)continue;let[u,w,m]=[n[3*p],n[3*p+1],n[3*p+2]],y=r[8]*u+r[9]*w+r[10]*m+r[11];if(y<=f||y>=d)continue;let E=i*(r[0]*u+r[1]*w+r[2]*m+r[3])/y+c-s,k=a*(r[4]*u+r[5]*w+r[6]*m+r[7])/y+l-o;E*E+k*k>Zs*Zs||(d=y,h=p)}return h<0?null:[n[3*h],n[3*h+1],n[3*h+2]]}function $e(n,t,e,s){let o=s instanceof Uint32Array;for(let r=0;r*t<s.length;r++)n[e+r]=o?qs(s[r*t]):s[r*t]}var jo=50,Zt=class{count=0;views=[];near=.2;logits=new Float32Array(0);request=null;calibrated=Promise.resolve();name="";broken=!1;#t=new Float32Array(0);#s;#o=!1;#e;#n;#r=null;#i=null;#a=null;#c=null;#l=Promise.resolve(!1);#f=!1;#d=null;#w=!1;#h=2;#m=[0,0,0];#g=null;#v=[0,0,0];#u=new Jt;#b=null;#y=!1;#x=!1;#k=!1;constructor(t,e,s,o){this.canvas=t,this.#n=e,this.#s=s,this.#e=o}begin(t){return this.#l=this.#E(t)}async#E(t){try{let{name:e,renderer:s}=await Qt(this.canvas,t);if(this.#f)return s.destroy(),!1;s.onLost=i=>this.#p(i),"onRestored"in s&&(s.onRestored=()=>this.request&&this.load(this.request));let r=s.variants.find(({floats:i,strips:a})=>i===this.#s?.floats&&a===this.#s.strips)??Bs(s,De());return r&&(s.variant=r),this.#o=r!==null,this.#r=s,this.name=e,Ps(s),!0}catch(e){return this.#n.failed(Ge(e)),!1}}async#A(){if(this.#o||this.broken)return;this.#o=!0;let t=this.name==="WebGPU"?"webgpu":"webgl",e=await Js(t);this.#r&&(this.#r.variant=e),this.#n.changed()}load(t,e=!1){this.#a?.terminate(),this.request=t;let s=Es(t,async({data:o})=>{if(!await this.#l){s.terminate();return}(s===this.#a||s===this.#i)&&this.#z(o,s)});s.onerror=o=>{o.preventDefault(),!e&&s===this.#a?this.load(t,!0):this.#R("the viewer's own files could not be loaded: reload the page",s)},this.#a=this.#c=s}async sort(t){if(this.#u.by==="")return null;if(this.broken)throw new Error("the renderer was lost");this.#u.pending&&await this.#S();let e=performance.now();return this.#u.invalidate(),this.#U(t),this.#u.pending&&await this.#S(),performance.now()-e}#S(){return new Promise((t,e)=>this.#b={resolve:t,reject:e})}#_(t){this.#b?.reject(new Error(t)),this.#b=null}draw(t){if(this.#i===null)return;let e={...t,near:this.near};if(this.#x){this.#r?.drawDots(e),this.#T();return}this.#U(t),this.#r?.draw(e)}async#T(){let t=this.#r;this.#k||this.#e||!t||(this.#k=!0,await new Promise(e=>setTimeout(e,jo)),this.#x&&!this.#f&&await Ds(t).catch(()=>{}))}drawOrReport(t){if(!this.broken)try{this.draw(t)}catch(e){this.#p(Ge(e))}}async finished(){await this.#r?.finished()}pixels(t){return(this.#i&&!this.#x?this.#r?.pixels(t):null)??Promise.reject(new Error("nothing can be drawn"))}get background(){return this.#g??this.#m}set background(t){this.#g=t,this.background.forEach((e,s)=>this.#v[s]=e)}get means(){return this.#t=Dt(this.#t)}get milliseconds(){return this.#r?.milliseconds??null}async time(){this.#y||!this.#r||(this.#y=!0,await this.#r.time().catch(()=>{}),this.#y=!1)}get device(){let{floats:t,strips:e}=this.#r?.variant??{floats:!1,strips:!1},s=`${t?"floats":"halves"}, ${e?"strips":"batches"}`,{by:o}=this.#u,r=this.#r?.describe()??"";return{renderer:this.name,adapter:r,variant:s,sorted:o!=="",sorted_by:o||null}}destroy(){this.#f=this.broken=!0,this.#_("the renderer was lost"),this.#a?.terminate(),this.#i?.terminate(),this.#r?.destroy(),this.#r=null}#p(t){this.broken=!0,this.#_(t),this.#n.broken(t)}#z(t,e){this.broken&&e===this.#i||(t.kind==="failed"?this.#R(t.sentence,e):t.kind==="progress"?e===this.#c&&this.#n.progress(t.received/t.total):t.kind==="dots"?this.#F(t,e):t.kind==="scene"?this.#I(t,e):t.kind==="rows"?this.#N(t):t.kind==="more"?this.#M(t.means):t.kind==="order"?this.#B(t.order):(this.#u.by!=="worker"&&e.terminate(),this.#a||(this.calibrated=this.#A().catch(()=>{})),e===this.#c&&this.#n.loaded(t.milliseconds,t.bytes)))}#R(t,e){let s=e===this.#a&&this.#d!==null;e===this.#i&&this.#_(t),e===this.#a&&(this.#a=null,this.request=this.#d),(e!==this.#i||this.#u.by!=="worker")&&e.terminate(),e===this.#c&&this.#n.failed(t,s)}#F({dots:t,views:e,near:s},o){this.#u.reset(""),this.#O(o,t.background,()=>this.#r?.setDots(t))&&(this.#x=!0,this.#L(e,s),this.logits=new Float32Array(t.means.length/3),this.#M(t.means),this.#w||this.#n.arrived())}#I({data:t,means:e,views:s,near:o},r){let i=r===this.#i;this.#u.reset(t.sorted?"worker":this.#e?"page":""),t.sorted=this.#u.by!=="",this.#O(r,t.background,()=>{this.#r?.setDots(null),this.#r?.setScene(t)})&&(this.#x=!1,this.#L(s,o),this.logits=new Float32Array(t.count),this.#h=at(t).lobes,$e(this.logits,this.#h,0,t.lobes),this.#M(e),!i&&!this.#w&&this.#n.arrived())}#O(t,e,s){if(t!==this.#i&&(this.#i?.terminate(),this.#_("another scene was opened")),this.#i=t,t===this.#a&&(this.#w=this.request===this.#d&&this.count>0,this.#d=this.request,this.#a=null),this.#m=[...e],this.#v=e,this.background=this.#g,this.#r?.lost)return this.#p(this.#r.lost),!1;try{s()}catch(o){return t.terminate(),this.count=0,this.#n.failed(Ge(o)),!1}return this.broken=!1,!0}#L(t,e){this.views=t,this.near=e}#M(t){this.#t=t,this.count=("stored"in t?t.stored:t).length/3,this.#r?.show(this.count),this.#u.invalidate(),this.#n.changed()}#N({part:t,from:e,numbers:s}){this.#r?.update(t,e,s),t==="lobes"&&$e(this.logits,this.#h,e,s),this.#n.changed()}#B(t){this.#u.received(),this.#r?.setOrder(t),this.#b?.resolve(),this.#b=null,this.#n.ordered()}#U(t){let e=this.#u.neededDirection(t);e!==null&&(this.#u.by==="page"?this.#r?.setOrder(Ft(this.means,e)):this.#i?.postMessage({forward:e}))}},Ge=n=>n instanceof Error?n.message:String(n);var en=.02,sn=.02,nn=.001,Z=class n{constructor(t,e,s){this.eye=t,this.target=e,this.up=X(s),this.reach=ct(I(e,t))||1}static fromViews(t,e=0){let s=t.map(Yo),o=Vo(s),{eye:r,forward:i}=s[e],a=O(I(Ko(s),r),i),c=Math.max(...s.map(l=>ct(I(l.eye,r))),0)||1;return new n(r,S(r,i,a>nn*c?a:c),o)}static around(t){let e=[0,1,2].map(r=>{let i=t.filter((c,l)=>l%3===r).sort(),a=c=>i[Math.floor(c*(i.length-1))]??0;return[a(.15),a(.5),a(.85)]}),s=e.map(([,r])=>r),o=Math.max(...e.map(([r,,i])=>i-r))||1;return new n(S(s,[0,-.3,-1],1.5*o),s,[0,-1,0])}get forward(){return X(I(this.target,this.eye))}get right(){return X(H(this.forward,this.up))}copy(){let t=new n(this.eye,this.target,this.up);return t.reach=this.reach,t}orbit(t,e){let s=this.#t(I(this.eye,this.target),t,e);this.eye=S(this.target,s)}look(t,e){let s=this.#t(I(this.eye,this.target),t,e);this.target=I(this.eye,s)}move(t,e,s){let o=H(this.forward,this.right),r=S([0,0,0],this.right,t);r=S(S(r,o,e),this.forward,s),this.eye=S(this.eye,r),this.target=S(this.target,r)}dolly(t){let e=I(this.eye,this.target),s=Math.max(ct(e)*t,nn*this.reach);this.eye=S(this.target,X(e),s)}focus(t){ct(I(t,this.eye))>0&&(this.target=t)}viewmat(){let{forward:t,right:e,eye:s}=this,o=H(t,e),r=i=>[...i,-O(i,s)];return[...r(e),...r(o),...r(t),0,0,0,1]}#t(t,e,s){let o=Math.acos(Math.min(1,Math.max(-1,O(X(t),this.up)))),r=Math.min(Math.max(o-s,en),Math.PI-en)-o;return Pe(Pe(t,this.right,r),this.up,-e)}};function on(n,t,e,s,o,r=null){let i=Math.tan((r??50)*Math.PI/360),a=r===null?t:null,c=a?e*a.K[0]/a.width:e/(2*i),l=a?s*a.K[4]/a.height:s/(2*i),f=Math.sqrt(c*l),h={cx:e/2,cy:s/2};return{viewmat:n.viewmat(),fx:f,fy:f,...h,width:e,height:s,near:o}}function Vo(n){let t=X(n.reduce((s,{down:o})=>I(s,o),[0,0,0])),e=t;for(let s=0;s<200;s++){let o=S([0,0,0],e,1+sn);for(let{right:r}of n)o=S(o,r,-O(r,e)/n.length);e=X(S(o,t,sn*O(t,e)))}return e}function Yo({viewmat:n}){let t=i=>[n[4*i],n[4*i+1],n[4*i+2]],[e,s,o]=[t(0),t(1),t(2)],r=S([0,0,0],e,-n[3]);return r=S(S(r,s,-n[7]),o,-n[11]),{eye:r,right:e,forward:o,down:s}}function Ko(n){let t=[.001,0,0,0,.001,0,0,0,.001],e=[0,0,0];for(let{eye:c,forward:l}of n){for(let f=0;f<3;f++)for(let h=0;h<3;h++)t[3*f+h]+=(f===h?1:0)-l[f]*l[h];e=S(S(e,c,1+.001/n.length),l,-O(l,c))}let s=c=>[t[c],t[3+c],t[6+c]],[o,r,i]=[s(0),s(1),s(2)],a=O(o,H(r,i));return[O(e,H(r,i))/a,O(o,H(e,i))/a,O(o,H(r,e))/a]}var Qo=16.666666666666668,Jo=1e3/50,Zo=1e3/45,rn=1e3/26,tr=3,er=200,sr=.9,an=[4,64],nr=[1,.85,.7,.6,.5],Et=class{#t=0;#s=[];#o;#e=Zo;#n={step:0,median:1/0};#r=0;#i=an[0];constructor(t){this.fixed=t,this.#o=t===null?nr:[t]}get scale(){return this.#o[this.#t]}size(t,e,s,o){let r=Math.min(s,2)*(o?this.scale:this.#o[0]),i=a=>Math.max(1,Math.round(a*r));return{width:i(t),height:i(e)}}note(t){this.#s.push(t);let{length:e}=this.#s;if(e<tr||this.#s.reduce((o,r)=>o+r)<er)return;let s=this.#s.sort((o,r)=>o-r)[e>>1];this.#s=[],s>this.#e?this.#a(s):s>=Jo||this.#t===0?this.#r=0:++this.#r>=this.#i&&(this.#t-=1,this.#r=0)}#a(t){let{step:e,median:s}=this.#n;if(this.#r=0,this.#i=Math.min(2*this.#i,an[1]),e<this.#t&&t<rn&&t>sr*s){this.#t=e,this.#e=rn;return}this.#n={step:this.#t,median:t};let o=this.scale*Math.sqrt(Qo/t),r=this.#o.findIndex(i=>i<this.scale&&i<=o);this.#t=r<0?this.#o.length-1:r}};var or=100,cn=150,rr=9*Math.PI/180,te=class{mode="orbit";pose=new Z([0,0,-3],[0,0,0],[0,-1,0]);fov=null;timed=!1;turning=!1;measured=!1;#t;#s;#o;#e;#n=null;#r="auto";#i=null;#a;#c;#l=this.pose;#f=!1;#d=0;#w=0;#h=-1/0;#m=!1;#g=0;#v=0;#u;constructor(t,e,{variant:s=null}={}){this.#s=t,this.#t=e,this.#o=s,this.#a=new Et(null),this.#e=this.#y(t,0,!1),this.#c=new zt(t,{pose:()=>this.pose,mode:()=>this.mode,held:()=>this.turning=!1,changed:()=>{this.#h=performance.now(),this.turning=!1,this.redraw()},focus:(o,r)=>this.#A(o,r)}),this.#u=new ResizeObserver(()=>this.redraw()),this.#u.observe(t)}begin(t){return this.#r=t,this.#e.begin(t)}load(t){this.#e.request&&(this.#f=!1),this.#e.load(t)}async compare(t,e,s){this.endComparison();let o=this.#y(t,1,s);o.background=this.#i,this.#n=o,await this.#e.calibrated,o===this.#n&&await o.begin(this.#r)&&o===this.#n&&o.load(e)}endComparison(){this.#n?.destroy(),this.#n=null}redraw(){!this.#d&&!this.measured&&(this.#d=requestAnimationFrame(t=>this.#k(t)))}reset(t){let{views:e}=this;this.pose=t===void 0||e.length===0?this.#l.copy():Z.fromViews(e,(t%e.length+e.length)%e.length),this.redraw()}place(t){this.pose=t,this.#f=!0,this.redraw()}camera(t,e){return on(this.pose,this.views[0]??null,t,e,this.#e.near,this.fov)}get views(){return this.#e.views.length?this.#e.views:this.#n?.views??[]}get count(){return this.#e.count}get calibrated(){return this.#e.calibrated}get source(){let{request:t}=this.#e;return t===null||"forward"in t?null:"url"in t?t.url:t.file}get device(){return this.#e.device}get scale(){return this.#a.fixed}set scale(t){this.#a=new Et(t),this.redraw()}get choices(){let{mode:t,fov:e,turning:s,scale:o,timed:r}=this;return{mode:t,fov:e,turning:s,scale:o,timed:r,background:this.#i}}get background(){return this.#e.background}set background(t){this.#i=t;for(let e of this.#b)e.background=t;this.redraw()}async drawAndWait(t,e){let s=this.camera(t,e),o=await this.#e.sort(s);if(this.#e.draw(s),await this.finished(),this.#e.broken)throw new Error("the renderer was lost");return o}async finished(){await this.#e.finished()}async passes(){return await this.#e.time(),this.#e.milliseconds}pixels(t,e=0){return this.#b[e]?.pixels(t)??Promise.reject(new Error("there is no other scene"))}screenshot(t=1){let{width:e,height:s}=this.#E(),o=document.createElement("canvas");[o.width,o.height]=[e,s];let r=o.getContext("2d");return this.#b.forEach(({canvas:i},a)=>{let c=a*Math.round(t*e),l=e-c;l>0&&r?.drawImage(i,c,0,l,s,c,0,l,s)}),new Promise(i=>o.toBlob(i,"image/png"))}destroy(){cancelAnimationFrame(this.#d),clearTimeout(this.#v),clearTimeout(this.#g),this.#c.destroy(),this.#u.disconnect();for(let t of this.#b)t.destroy()}get#b(){return this.#n?[this.#e,this.#n]:[this.#e]}#y(t,e,s){let o={progress:r=>this.#t.progress(e,r),arrived:()=>this.#x(e),changed:()=>{this.#g||=setTimeout(()=>this.redraw(),or)},ordered:()=>this.redraw(),loaded:(r,i)=>{this.#t.loaded(e,r,i),this.redraw()},failed:(r,i)=>this.#t.failed(e,r,i),broken:r=>this.#t.broken(e,r)};return new Zt(t,o,this.#o,s)}#x(t){let{views:e}=this;(t===0||!this.#e.views.length&&this.#h===-1/0)&&(e.length||this.#e.count)&&(this.#l=e.length?Z.fromViews(e):Z.around(this.#e.means),this.#f||this.reset()),this.redraw()}#k(t){this.#d=0,clearTimeout(this.#g),this.#g=0;let e=t-this.#w;this.#w=t;let s=this.#m,o=this.turning&&this.count>0;this.#m=performance.now()-this.#h<cn||this.#c.busy||o,this.#m&&s&&this.#a.note(e);let r=Math.min(e,100)/1e3;this.#c.advance(r),o&&this.pose.orbit(rr*r,0);let{width:i,height:a}=this.#E();if(clearTimeout(this.#v),this.#m&&(this.#v=setTimeout(()=>this.redraw(),2*cn)),this.count&&!this.#e.broken){let{name:c,count:l,milliseconds:f}=this.#e,h=this.#m&&s?e:0,d=this.#n?.count??0;this.#t.drawn({renderer:c,count:l,compared:d,width:i,height:a,milliseconds:h,passes:f}),this.timed&&this.#e.time()}(this.#c.busy||o)&&this.redraw()}#E(){let{clientWidth:t,clientHeight:e}=this.#s,s=this.#a.size(t,e,devicePixelRatio,this.#m);if(t&&e){let o=this.camera(s.width,s.height);for(let r of this.#b)r.drawOrReport(o)}return s}#A(t,e){let{clientWidth:s,clientHeight:o}=this.#s,{means:r,logits:i}=this.#e,a=tn(r,i,this.camera(s,o),t,e);a&&this.pose.focus(a),this.redraw()}};var ln=["settings","help","report"],fn=["scale","background","fov","autorotate"],ir=2e3,hn="sorted",ar={rootMargin:"100%"},cr="(prefers-reduced-motion: reduce)",qe=class extends(globalThis.HTMLElement??Object){static observedAttributes=["src","compare",...fn];viewer=null;#t;#s=null;#o=new wt;#e=null;#n;#r=!1;#i=!1;#a=null;#c=[];#l=0;#f=Promise.resolve(!1);#d=!1;#w=new IntersectionObserver(t=>t.some(e=>e.isIntersecting)&&this.#h(),ar);constructor(){super(),this.#t=this.attachShadow({mode:"open",delegatesFocus:!0}),this.#t.innerHTML=vs;for(let e of this.#t.querySelectorAll("button"))e.addEventListener("click",()=>this.act(e.dataset.act??""));this.#t.addEventListener("keydown",e=>{let{code:s,key:o,ctrlKey:r,metaKey:i,altKey:a,repeat:c,target:l,defaultPrevented:f}=e,h=xe.get(o.toLowerCase())??xe.get(s.slice(3).toLowerCase()),d=f||l.matches("textarea, select");h&&!r&&!i&&!a&&!c&&!d&&this.act(h),s==="Escape"&&this.act("close")}),this.#t.addEventListener("keyup",e=>{let{code:s,target:o}=e,{classList:r}=o;s==="Tab"&&(r.add("reached"),o?.addEventListener("blur",()=>r.remove("reached"),{once:!0}))}),this.#p("settings").addEventListener("input",({target:e})=>{let s=e;s.name==="stats"?this.act("stats"):this.viewer&&gs(s,this.viewer)}),this.addEventListener("dragover",e=>{e.preventDefault(),this.#p("drop").hidden=!1}),this.addEventListener("dragleave",()=>this.#p("drop").hidden=!0),this.addEventListener("drop",e=>{e.preventDefault(),this.#p("drop").hidden=!0,this.#y(e.dataTransfer?.files)});let t=this.#b;t.addEventListener("change",()=>{this.#E(null),this.#y(t.files),t.value=""})}connectedCallback(){queueMicrotask(()=>{if(!this.isConnected||this.viewer)return;let t=this.getAttribute("poster")?.replace(/[\x22\\\n]/g,encodeURIComponent);t&&(this.style.background=`center / cover no-repeat url("${t}")`),this.getAttribute("loading")==="lazy"?this.#w.observe(this):this.#h()})}#h(t=this.getAttribute("renderer")??"auto"){this.#w.disconnect(),this.#p("buttons").hidden=this.hasAttribute("noui"),this.#t.querySelector("[data-act=full]").hidden=!document.fullscreenEnabled;let e=this.#t.querySelector("canvas"),s=this.getAttribute("variant"),[o,r]=["floats","strips"].map(c=>!!s?.includes(c));this.viewer=new te(e,this,{variant:s===null?null:{floats:o,strips:r}}),e.setAttribute("aria-label",`${this.getAttribute("alt")??"3D scene"}. Press H for the keys.`),e.classList.toggle("polite",this.hasAttribute("polite"));for(let c of fn)this.#A(c);this.#f=this.viewer.begin(t),this.#d=!1,this.#f.then(c=>this.#d=!c);let i=this.#e??this.getAttribute("src"),a=this.#n===void 0?this.getAttribute("compare"):this.#n;i&&this.open(i),a&&this.compare(a)}disconnectedCallback(){this.#w.disconnect(),this.#m()}#m(){this.viewer?.destroy(),this.viewer=null,this.#T(),this.#o=new wt;let t=this.#t.querySelector("canvas");t?.classList.remove("drawn"),t?.replaceWith(t.cloneNode())}attributeChangedCallback(t,e,s){t==="src"&&(this.#e=null),t==="compare"&&(this.#n=void 0),!(!this.viewer||s===e)&&(t==="compare"?this.compare(s||null):t!=="src"?this.#A(t):s&&this.open(s))}async open(t){this.#e=t,this.#i=this.#r,await this.#S(0,t,(e,s)=>e.load(s))}async compare(t){this.#n=t,this.#i=!1,this.#r=t===hn;let e=this.#r?this.#e:t;this.viewer?.endComparison(),this.#T(),this.#o.begin(1),this.#_(),e!==null&&await this.#S(1,e,(s,o)=>{this.#T();let r=document.createElement("canvas");r.className="over",r.setAttribute("aria-hidden","true"),this.#p("split").before(r),this.#s=new Ut(this.#p("split"),r),s.compare(r,o,this.#r)})}act(t){let e=this.viewer;if(e){if(t==="reset"||t==="view")e.turning=!1,e.reset(t==="view"?++this.#l:void 0);else if(t==="help"||t==="settings")this.#E(t);else if(t==="stats")e.timed=this.#k("stats");else if(t==="own")e.background=null;else if(t==="mode"){let s=e.mode==="fly";e.mode=s?"orbit":"fly",this.#g(`Dragging ${s?"rotates the scene":"looks around"}.`,!0)}else t==="picture"?this.#x():t==="open"?this.#b.click():t==="copy"?this.#u():t==="share"?navigator.share?.({text:this.#v}).catch(()=>{}):t==="full"?document.fullscreenElement?document.exitFullscreen():this.requestFullscreen?.().catch(()=>{}):t==="close"&&(this.#p("message").hidden=!0,this.#E(null));ms(this.#p("settings"),e,!this.#p("stats").hidden),e.redraw()}}progress(t,e){this.#o.note(t,{share:e,state:"loading"}),this.#_()}loaded(t,e,s){this.#o.note(t,{share:1,state:"loaded"}),this.#_(),t!==1&&(this.#i&&this.compare(hn),this.#g(`${this.viewer?.count.toLocaleString("en")} Gaussians loaded.`),this.dispatchEvent(new CustomEvent("load",{detail:{milliseconds:e,bytes:s}})))}failed(t,e,s=!1){this.#o.fail(t,e,s),t===0&&(this.#i=!1),this.#_(),this.#p("message").hidden=!1,t===0&&(this.#e=this.viewer?.source??this.#e),this.#t.querySelector(".message [data-act=open]").hidden=!!this.viewer?.count,this.dispatchEvent(new CustomEvent("error",{detail:{sentence:e}}))}broken(t,e){let s=this.viewer;if(!s||s.device.renderer==="WebGL2"||this.getAttribute("renderer")==="webgpu"){this.failed(t,e);return}console.warn(`WebGL2 takes over: ${e}`),this.#m(),this.#h("webgl"),Object.assign(this.viewer,s.choices),s.count&&this.viewer?.place(s.pose)}report(t){let e=JSON.stringify(t,null,1),s=this.#p("report");s.querySelector("textarea").value=e;let o=t.scenes,r=o.some(a=>a.interrupted),i=o.map(({cold:a,steady:c})=>`${a.fps} frames/s cold, ${c.fps} steady`).join(" | ");s.querySelector("h2").textContent=r?"The page was hidden during the measurement: measure again":i,s.querySelector("[data-act=share]").hidden=!navigator.share,s.hidden&&this.#E("report"),this.dispatchEvent(new CustomEvent("report",{detail:t}))}drawn(t){this.#t.querySelector("canvas")?.classList.add("drawn"),t.compared&&this.#p("split").hidden&&this.#s?.show(this.#o.names),this.dispatchEvent(new CustomEvent("frame",{detail:t}));let e=this.#p("stats");if(e.hidden)return;t.milliseconds&&(this.#c=[...this.#c.slice(-29),t.milliseconds]);let s=this.#c.reduce((i,a)=>i+a,0)/this.#c.length,o=[t.count,t.compared].filter((i,a)=>a===0||i),r=[`${t.renderer}, ${t.width} x ${t.height}`,`${o.map(i=>i.toLocaleString("en")).join(" | ")} Gaussians`,this.#c.length?`${(1e3/s).toFixed(0)} frames/s, ${s.toFixed(1)} ms`:"still",...Object.entries(t.passes??{}).map(([i,a])=>`${i} ${a.toFixed(2)} ms`)];e.textContent=r.join(`
`)}#g(t,e=!1){let s=this.#p("said");s.textContent=t,s.classList.toggle("seen",e),setTimeout(()=>s.classList.remove("seen"),ir)}get#v(){let t=this.#t.querySelector("textarea");return t.focus(),t.select(),t.value}async#u(){let t=this.#v,e=navigator.clipboard?await navigator.clipboard.writeText(t).then(()=>!0,()=>!1):document.execCommand("copy");this.#p("copied").textContent=e?"Copied.":"This browser does not allow copying: the text is selected, press Ctrl+C."}get#b(){return this.#t.querySelector("[type=file]")}#y(t){let[e,s]=t??[];e&&this.open(e),s&&this.compare(s)}async#x(){let t=await this.viewer?.screenshot(this.#s?.share);if(!t)return;let e=document.createElement("a");Object.assign(e,{href:URL.createObjectURL(t),download:"scene.png"}).click(),setTimeout(()=>URL.revokeObjectURL(e.href),1e3)}#k(t,e){let s=this.#p(t);return s.hidden=e===void 0?!s.hidden:!e,this.#t.querySelector(`[data-act=${t}]`)?.setAttribute("aria-expanded",String(!s.hidden)),!s.hidden}#E(t){ln.every(s=>this.#p(s).hidden)&&(this.#a=this.#t.activeElement);let e=t!==null&&this.#p(t).hidden;for(let s of ln)this.#k(s,e&&s===t);e?this.#p(t).focus():(this.#a??this.#t.querySelector("canvas"))?.focus({preventScroll:!0})}#A(t){let e=this.viewer,s=this.getAttribute(t),o=Number(s);t==="scale"?e.scale=o>0&&o<=1?o:null:t==="fov"?e.fov=o>=1&&o<=150?o:null:t==="background"?e.background=Lt(s):e.turning=s!==null&&!matchMedia(cr).matches,e.redraw()}async#S(t,e,s){let o=this.viewer;if(o===null||this.#d)return;let r=this.#n;if(t===1&&(!await this.#f||o!==this.viewer||r!==this.#n))return;let i=typeof e=="string"?e.replace(/[?#].*$/,""):"scene",a=e instanceof File?e.name:i;this.#o.begin(t,t===1&&this.#r?`${a}, sorted`:a),this.#_();try{let c=e instanceof Blob?{file:e}:{url:new URL(e,document.baseURI).href};s(o,c)}catch(c){this.failed(t,`the scene cannot be opened: ${c.message}`)}}#_(){let{state:t,busy:e,share:s,sentence:o,names:r}=this.#o,i=this.#p("bar");i.hidden=!e,i.classList.toggle("unknown",Number.isNaN(s));let a=Math.min(100,Math.round(100*s))||0;i.setAttribute("aria-valuenow",String(a)),i.firstElementChild.style.width=`${a}%`;let c=this.#p("message"),l=c.querySelector("p");l.textContent!==o&&(l.textContent=o),o||(c.hidden=!0),this.#p("split").hidden||this.#s?.show(r),t&&(this.dataset.state=t)}#T(){this.#p("split").hidden=!0,this.#t.querySelector(".over")?.remove(),this.#s=null}#p(t){return this.#t.querySelector(`.${t}`)}};globalThis.customElements?.define("mobile-gs",qe);var b=128,lr=1e-12,dn=new Float32Array(0),ee=class{wasmMemory=null;#t=[];#s=0;#o=null;#e;constructor(t=!1){this.#e=t}block(t){return this.#n(t,b*t,null)}part({at:t},e,s){let o={at:t+4*b*e,width:s,numbers:dn};return this.#t.push([o,null,b*s]),o}layer(t,e,s){let o=s?s.length:t.length/e,r=Math.ceil(o/4)*4,i=new Float32Array(r*e);for(let l=0;l<o;l++){let f=(l-l%4)*e+l%4;for(let h=0;h<e;h++)i[f+4*h]=t[l*e+h]}let a=new Float32Array(r);s&&a.set(s);let c=l=>this.#n(0,l.length,l);return{inputs:e,outputs:r,weights:c(i),offsets:c(a)}}#n(t,e,s){let o={at:this.#s,width:t,numbers:dn};return this.#t.push([o,s,e]),this.#s+=16*Math.ceil(e/4),o}allocate(){this.wasmMemory=It(this.#s);let t=this.wasmMemory?.buffer??new ArrayBuffer(this.#s);for(let[e,s,o]of this.#t.splice(0))e.numbers=new Float32Array(t,e.at,o),s&&e.numbers.set(s);this.#o=this.#e?null:rt(this.wasmMemory)}apply({inputs:t,outputs:e,weights:s,offsets:o},r,i,a){if(this.#o){this.#o.layer(s.at,o.at,r.at,i.at,t,e,a);return}let[c,l,f,h]=[r,i,s,o].map(({numbers:d})=>d);for(let d=0;d<e;d++){let p=(d-d%4)*t+d%4;for(let u=0;u<b;u++){let w=h[d];for(let m=0;m<t;m++)w+=f[p+4*m]*c[m*b+u];l[d*b+u]=Math.max(w,a*w)}}}units({at:t,width:e,numbers:s},{at:o,numbers:r}){if(this.#o){this.#o.units(t,o,e);return}for(let i=0;i<b;i++){let a=0;for(let l=i;l<b*e;l+=b)a+=s[l]*s[l];let c=1/Math.max(Math.sqrt(a),lr);for(let l=i;l<b*e;l+=b)r[l]=s[l]*c}}};var fr=80;function un(n){let t=0;for(let{count:e,size:s,length:o}of n.values())t+=e*s*o;return t}function pn(n,t){let e=0,s=new Map;for(let[o,{count:r,size:i,length:a}]of t){let c=()=>n.subarray(e,e+=i*a);s.set(o,{length:a,books:Array.from({length:r},c)})}if(s.get("scale")?.books.some(o=>o.some(r=>r>fr)))throw new v("the codebooks of the .mgs file hold scales that are out of range");return s}function wn(n){return new Map([...n].map(([t,{step:e,columns:s}])=>{let o=s.map(({least:r,size:i})=>Float32Array.from({length:i},(a,c)=>(r+c)*e));return[t,{length:1,books:o,middles:s.map(({least:r,middle:i})=>i-r)}]}))}function mn({name:n,codec:t,data:e},s,o){if(t==="rans")return Q(e,s,o);let r=32-Math.clz32(o-1),i=ot(e,r*s),a=new Uint16Array(s);for(let c=0;c<s;c++){let l=i.take(r);if(l>=o)throw new v(`the stream '${n}' points outside of its codebook`);a[c]=l}return a}function kt({length:n,books:t,middles:e}){let s=new Uint16Array(b);return{length:n,books:t.map((o,r)=>e?o.subarray(e[r],e[r]+1):hr(o,n)),columns:t.map(()=>s)}}function hr(n,t){let e=new Float64Array(t);for(let s=0;s<n.length;s++)e[s%t]+=n[s]*t/n.length;return Float32Array.from(e)}function N({length:n,books:t,columns:e},s,o,r,i){for(let a=0;a<t.length;a++){let c=t[a],l=e[a],f=a*n*o;if(n===1){for(let h=r;h<i;h++)s[f++]=c[l[h]];continue}for(let h=0;h<n;h++,f=(a*n+h)*o)for(let d=r;d<i;d++)s[f++]=c[l[d]*n+h]}}var dr=[53,210,405,600,787,970,1151,1329],ur=Uint8Array.from({length:1330},(n,t)=>dr.filter(e=>e<=t).length),He=Float64Array.from({length:512},(n,t)=>(t+.5)/2**(31-Math.clz32(t))-1.5),pr=2.5,We=(n,t)=>ur[Math.min(256*Math.abs(Math.fround(n-t)),1329)|0];function gn(n,t,e){let[s,o,r]=e,i=s.length,a=[new Uint16Array(i),new Uint16Array(i),new Uint16Array(i)],[c,l,f]=a,[h,d,p]=t,u=new Y(n),w=0;for(let m=0;m<i;m++){let y=h[s[m]],E=d[o[m]],k=p[r[m]],x=We(E,k),A=We(y,k),M=We(y,E),C=u.take(x+A+M);c[m]=1<<x|C&(1<<x)-1,l[m]=1<<A|C>>>x&(1<<A)-1,f[m]=1<<M|C>>>x+A,w+=x+A+M}return ot(n,w),a}function bn({step:n,columns:[{least:t},{least:e},{least:s}]},o,r,i,a){let[c,l,f,h,d,p]=o;for(let u=r,w=0;u<i;u++,w++){let m=n*(c[u]+t+He[h[u]]),y=n*(l[u]+e+He[d[u]]),E=n*(f[u]+s+He[p[u]]),k=(m*m+y*y+E*E)/4,x=1+k*(-1/2+k*(1/24+k*(-1/720+k*(1/40320+k*(-1/3628800+k*(1/479001600-k/87178291200)))))),A=1/2+k*(-1/12+k*(1/240+k*(-1/10080+k*(1/725760+k*(-1/79833600+k/12454041600)))));if(k>pr){let M=Math.sqrt(k);x=Math.cos(M),A=Math.sin(M)/(2*M)}a[w]=x,a[w+b]=A*m,a[w+2*b]=A*y,a[w+3*b]=A*E}}var lt=class{#t;#s;#o;constructor(t,{sh:e,scales:s,quats:o},r){this.#t=t,this.#s=[[e,t.part(r,0,12)],[s,t.part(r,12,3)]],this.#o=[o,t.part(r,15,4)]}write(){let[t,e]=this.#o;for(let[s,o]of this.#s)this.#t.units(s,o);e.numbers.set(t.numbers)}};var wr=[["context1",64,96],["context2",13,64],["static1",64,16],["static2",3,64],["view1",64,16],["view2",9,64]],mr=[["both1",128,6],["static2",3,64],["view2",9,64]],Xe={linear:"color-matrices",networks:"appearance-decoder",latent_networks:"color-networks"};function vn({colors:n,scalars:t}){let e=t.get("appearance")?.columns.length??6,s={linear:[["static2",3,3],["view2",9,e-3]],networks:wr,latent_networks:mr};return[Xe[n],s[n]]}var yn=[["hidden1.weight",256,22],["hidden1.bias",1,256],["hidden2.weight",128,256],["hidden2.bias",1,128],["hidden3.weight",64,128],["hidden3.bias",1,64],["phi.weight",1,64],["phi.bias",1,1],["opacity.weight",1,64],["opacity.bias",1,1]];function xn({degree:n,latents:t,hidden:e}){let s=2*(n+1)**2,o=[19+t,...e],r=[["bias",1,s],["basis",t,s]];return e.length===0||([...e,s].forEach((i,a)=>r.push([`weights.${a}`,i,o[a]])),e.forEach((i,a)=>r.push([`offsets.${a}`,1,i]))),r}function En(n){return n.reduce((t,[,e,s])=>t+e*s,0)}function kn(n,t){let e=0;return Object.fromEntries(t.map(([s,o,r])=>[s,n.subarray(e,e+=o*r)]))}var gr=256,An=["raw","halves","planes"],br=["bits","rans"],_n=[["scale","rotation"],["appearance","opacity"],["lobes"]],Ve=_n.length,At=2,je=class{positions=null;columns=new Map;#t;constructor(t,e){this.#t=t,this.count=e}get stage(){let t=_n.findIndex(e=>!e.every(s=>this.#s(s)));return t<0?Ve:t}rows(t,e,s="slice"){let o=[...this.columns].filter(([i])=>this.#s(i)).map(([i,a])=>[i,a.map(c=>c[s](t,e))]);return{positions:this.positions[s](3*t,3*e),columns:Object.fromEntries(o)}}#s(t){let{cuts:e,scalars:s}=this.#t,o=s.size&&t==="rotation"?3:0,r=(e.get(t)?.count??s.get(t)?.columns.length??0)+o;return Object.keys(this.columns.get(t)??[]).length===r}},se=class{levels;network=null;#t;#s;#o=new Map;#e=new Map;#n=new Map;#r={};#i={};constructor(t,e){this.#t=t,this.#s=e;let{network:s,lobes:o,cuts:r,scalars:i,lodSizes:a}=t;s&&this.#l("view-network",yn,f=>this.network=f),o&&this.#l("lobe-decoder",xn(o),f=>this.#r=f),this.#l(...vn(t),f=>this.#i=f),i.size?this.#n=wn(i):this.#c("codebooks",An,[],f=>{this.#n=pn(_e(f,un(r)),r)});let c=[...this.#o.keys()],l=0;this.levels=a.map((f,h)=>(l+=f,this.#a(f,h?`@${h}`:"",c,l)))}#a(t,e,s,o){let{cuts:r,scalars:i}=this.#t,a=new je(this.#t,t),[c,...l]=["positions","scale.0","scale.1","scale.2"].map(d=>d+e),f=(d,p)=>{let u=[];a.columns.set(d,u);for(let[w,m]of p.entries())this.#c(`${d}.${w}${e}`,br,[c],y=>{u[w]=mn(y,t,m)})},h=({data:d})=>{a.positions=Us(d,t)};this.#c(c,["morton-class"],s,h,o);for(let[d,{count:p,size:u}]of r)f(d,Array(p).fill(u));for(let[d,{columns:p}]of i)f(d,p.map(({size:u})=>u));if(i.size){let[d,p]=["scale","rotation"].map(u=>a.columns.get(u)??[]);this.#c(`rotation-finer${e}`,["bits"],[c,...l],({data:u})=>{let{books:w}=this.#n.get("scale");gn(u,w,d).forEach((m,y)=>p[3+y]=m)})}return a}accept(t){this.#o.has(t.name)&&this.#e.set(t.name,t)}step(t){for(let[e,{after:s,minBytes:o,read:r}]of this.#o){let i=this.#e.get(e);if(!(i===void 0||t<o||s.some(a=>this.#o.has(a))))return r(i),this.#o.delete(e),this.#e.delete(e),!0}return!1}get decoderInputs(){let[{count:t,positions:e}]=this.levels,s=e,o=Math.min(t,gr),r=new Uint16Array(3*o).map((c,l)=>s[3*Math.floor(Math.floor(l/3)*t/o)+l%3]),[i,a]=[this.#t,this.#n];return{header:i,books:a,appearance:this.#i,lobes:this.#r,samples:r}}#c(t,e,s,o,r=0){let i=this.#s.find(a=>a.name===t);if(i===void 0)throw new v(`the .mgs file lacks its stream '${t}'`);if(!e.includes(i.codec))throw new v(`the stream '${t}' of the .mgs file uses the codec '${i.codec}', which this program does not know`);this.#o.set(t,{after:s,minBytes:r,read:o})}#l(t,e,s){this.#c(t,An,[],o=>s(kn(_e(o,En(e)),e)))}};var z=new Int32Array(2048);for(let n=0;n<z.length;n++){let t=n<256?n:z[n-256];for(let e=0;e<8;e++)t=(t&1?3988292384:0)^t>>>1;z[n]=t}function ne(n,t=0){let e=~t,s=0;for(;s+8<=n.length;s+=8)e^=n[s]|n[s+1]<<8|n[s+2]<<16|n[s+3]<<24,e=z[1792+(e&255)]^z[1536+(e>>>8&255)]^z[1280+(e>>>16&255)]^z[1024+(e>>>24)]^z[768+n[s+4]]^z[512+n[s+5]]^z[256+n[s+6]]^z[n[s+7]];for(;s<n.length;s++)e=z[(e^n[s])&255]^e>>>8;return~e>>>0}var vr=2**26,yr=8,Ke=4096,Ye=2**14,xr=1e-5,Er=1e3,kr=80,Ar=8,Qe=32,_r=256,Sr=3,Tr=64,Sn=2**16,Tn=64,Mn=4096,Mr=1e-20,oe=1e20,Rr=/[\x00-\x1f\x7f-\x9f\p{Cs}]/u,Rn=["mobile_gs","no_depth","no_scale","sort_free_gs"],Or=[["scale",[[3,1],[1,3]]],["rotation",[[2,2],[1,4]]],["appearance",[[3,2]]],["opacity",[[1,1]]]],On=[6,12],Lr=[["scale",3],["rotation",3],["appearance",On[0]],["opacity",1]];function Ln(n,t){let{colors:e="networks"}=n;for(let[h,d,...p]of[["mode",n.mode,"nvq","sq"],["blend",n.blend,"sortfree","sorted"],["sh_degree",n.sh_degree,1],["colors",e,"linear","networks","latent_networks"]])if(!p.includes(d))throw new v(`the .mgs file has ${h} '${zn(d)}', which this program does not know: a newer one may`);let s=Fr(n),o=n.network;if(typeof o!="boolean")throw _("network");if(o&&s!==null)throw new v("the .mgs file has lobes and a view network: it can have one of them");let r=n.mode==="sq",i=R(n,"count",1,vr),a={count:i,lodSizes:zr(n,i),cuts:r?new Map:Ir(P(n,"codebooks"),s),scalars:r?Nr(P(n,"scalars"),s,e==="linear"):new Map,grid:Br(P(n,"positions")),colors:e,sorted:n.blend==="sorted",lobes:s,network:o,weighting:Cr(P(n,"weighting")),background:ie(n,"background",3),near:j(n,"near"),views:_t(n,"views").map(Dr),meta:Pr(P(n,"meta"))},c=Ur(a),f=n.streams.filter(h=>c.has(h.name)).reduce((h,d)=>h+d.bytes,0);if(i>f)throw new v(`the .mgs file claims ${i} Gaussians in ${f} of its ${t} bytes: it is damaged`);if(a.background.some(h=>h<0||h>1))throw _("background");if(!(a.near>0&&a.near<=oe))throw _("near");if(a.views.length>Tr)throw _("views");return a}function re(n,t){return typeof n!="string"||n.length>2*t||Rr.test(n)?!1:n.length<=t||[...n].length<=t}function Ur({colors:n,lobes:t,network:e,cuts:s,scalars:o,lodSizes:r}){let i=["positions"];for(let[c,{count:l}]of s)for(let f=0;f<l;f++)i.push(`${c}.${f}`);for(let[c,{columns:l}]of o)i.push(...l.map((f,h)=>`${c}.${h}`));o.size&&i.push("rotation-finer");let a=r.flatMap((c,l)=>i.map(f=>l?`${f}@${l}`:f));return a.push(Xe[n]),t&&a.push("lobe-decoder"),e&&a.push("view-network"),s.size&&a.push("codebooks"),new Set(a)}function zr(n,t){let e=_t(n,"layers").map(o=>R({layers:o},"layers",1,t)),s=e.reduce((o,r)=>o+r,0);if(e.length>yr||s!==t)throw _("layers");return e}function Fr(n){if(n.lobes===null)return null;let t=P(n,"lobes"),e=_t(t,"hidden");if(e.length>Sr)throw _("lobes.hidden");return{degree:R(t,"degree",0,3),latents:R(t,"latents",0,Qe),hidden:e.map(s=>R({hidden:s},"hidden",1,_r))}}function Ir(n,t){let e=new Map;for(let[o,r]of Or){if(o==="opacity"&&!Object.hasOwn(n,o)&&t!==null)continue;let i=P(n,o),a=r.find(([c,l])=>i.count===c&&i.length===l);if(!a)throw _(`codebooks.${o}`);e.set(o,{count:a[0],length:a[1],size:R(i,"size",1,Ke)})}let s=0;if(Object.hasOwn(n,"lobes")){let o=P(n,"lobes"),r=R(o,"count",1,Qe),i=R(o,"length",1,Qe);e.set("lobes",{count:r,length:i,size:R(o,"size",1,Ke)}),s=r*i}if(s!==(t===null?0:t.latents))throw _("codebooks.lobes");return e}function Nr(n,t,e){let s=new Map,o=t?.latents??0;if(Object.hasOwn(n,"lobes")&&!o)throw _("scalars.lobes");for(let[r,i]of[...Lr,["lobes",o]]){if(r==="opacity"&&!Object.hasOwn(n,r)&&t!==null||i===0)continue;let c=P(n,r),[l,f,h]=["least","size","middle"].map(y=>_t(c,y)),[d,p]=r==="appearance"&&e?On:[i,i],u=l.length;if(u<d||u>p||f.length!==u||h.length!==u)throw _(`scalars.${r}`);let w=Math.fround(j(c,"step"));if(!(w>=xr&&w<=Er))throw _(`scalars.${r}.step`);let m=l.map((y,E)=>{let k={least:l[E],size:f[E],middle:h[E]},x=R(k,"least",-Ye,Ye),A=R(k,"size",1,Ke),M=R({size:x+A-1},"size",x,Ye);if(r==="scale"&&M*w>kr)throw _("scalars.scale");let C=Math.max(-x,M)+.5;if(r==="rotation"&&C*w>Ar)throw _("scalars.rotation");return{least:x,size:A,middle:R(k,"middle",x,M)}});s.set(r,{step:w,columns:m})}return s}function Br(n){let t=ie(n,"center",3),e=Math.fround(j(n,"radius"));if(t.some(s=>Math.abs(s)>Math.fround(oe)))throw _("positions.center");if(e<Mr||e>oe)throw _("positions.radius");return{center:t,radius:e,exponent:R(n,"exponent",0,14)}}function Cr(n){let{name:t}=n;if(typeof t!="string")throw _("name");if(!Rn.includes(t))throw new v(`the .mgs file has the weighting '${zn(t)}': known are ${Rn.join(", ")}`);let e={name:t,exponent_max:j(n,"exponent_max"),sigma:j(n,"sigma"),background_weight:j(n,"background_weight"),alpha_min:n.alpha_min===void 0?1/255:j(n,"alpha_min")};if(!(e.exponent_max>0&&e.exponent_max<=80))throw _("exponent_max");if(!(e.sigma>0&&e.sigma<=oe))throw _("sigma");if(e.background_weight<0)throw _("background_weight");if(!(e.alpha_min>=1e-4&&e.alpha_min<=.1))throw _("alpha_min");return e}function Dr(n){let t=P({views:n},"views"),e=ie(t,"viewmat",16),s=ie(t,"K",9);if(![0,0,0,1].every((i,a)=>e[12+a]===i)||![0,0,1].every((i,a)=>s[6+a]===i)||s[0]<=0||s[4]<=0)throw new v("a view's matrices in the .mgs file are not those of a camera");let r=R(t,"width",1,Sn);return{viewmat:e,K:s,width:r,height:R(t,"height",1,Sn)}}function Pr(n){let t=Object.entries(n);if(t.length>Tn)throw new v(`the .mgs file has ${t.length} notes: ${Tn} are allowed`);for(let[e,s]of t){let o=s===null||typeof s=="boolean"||re(s,Mn),r=typeof s=="number"&&Math.abs(s)<=2**53;if(!(o||r)||!re(e,Mn))throw new v(`the note '${e.slice(0,40)}' is not a short text or a number`)}return n}function P(n,t){let e=n[t];if(typeof e!="object"||e===null||Array.isArray(e))throw _(t);return e}function _t(n,t){let e=n[t];if(!Array.isArray(e))throw _(t);return e}function R(n,t,e,s){let o=j(n,t);if(!Number.isInteger(o)||o<e||o>s)throw _(t);return o}function j(n,t){return Un(n[t],t)}function ie(n,t,e){let s=_t(n,t);if(s.length!==e)throw _(t);return Float32Array.from(s,o=>Un(o,t))}function Un(n,t){if(typeof n!="number"||!(Math.abs(n)<=3e38))throw _(t);return n}function zn(n){return typeof n!="object"||n===null?String(n).slice(0,40):Array.isArray(n)?"a list":"an object"}function _(n){return new v(`the field '${n}' in the header of the .mgs file is missing or invalid`)}var ht=[77,71,83,26,13,10,0,1],Je=[2,3],ae=20,$r=2**20,Gr=256,qr=2**32,Hr=[["ply","a PLY scene: train or compress it first"],["PK","a zip archive (perhaps .sog)"],["\x8B","a gzip file (perhaps .spz)"],["NGSP","an .spz scene"],["glTF","a binary glTF file"],["\xFD7zXZ","an xz file (perhaps another program's comp.xz)"],["\x89PNG","a PNG picture"],["\xFF\xD8\xFF","a JPEG picture"],["<","a web page"],["{","a JSON text"]],ce=class{received=0;total=1/0;fields=null;table=[];#t=[];#s=0;#o=0;#e=!1;#n=null;append(t){if(t.length>0&&this.#t.push(t),this.received+=t.length,this.#s+=t.length,!this.#r())return[];if(this.received>this.total)throw new v(`the .mgs file has ${this.received-this.total} bytes too many at its end`);let e=[];for(let s;(s=this.table[this.#o])&&Ze(s.bytes)<=this.#s;)this.#o++,e.push(Wr(s,this.#a(Ze(s.bytes))));return e}end(){if(this.fields!==null){let e=this.table[this.#o];if(e===void 0)return;throw new v(`the .mgs file ends inside its stream '${e.name}': it has been cut short`)}if(!this.#e)throw new v(Fn(this.#a(this.#s)));let t=this.#n===null?"first bytes":"header";throw new v(`the .mgs file ends inside its ${t}: it has been cut short`)}#r(){if(!this.#e&&this.#s>=ht.length){let t=this.#a(ht.length);if(ht.some((e,s)=>e!==t[s]))throw new v(Fn(t));this.#e=!0}if(this.#e&&this.#n===null&&this.#s>=ae-ht.length&&(this.#n=this.#a(ae-ht.length)),this.#n!==null&&this.fields===null){let t=Xr(this.#n);this.#s>=t&&this.#i(this.#n,this.#a(t))}return this.fields!==null}#i(t,e){let s=D(t).getUint32(8,!0);if((ae+e.length)%8||ne(e,ne(t.subarray(0,8)))!==s)throw new v("the header of the .mgs file is damaged (wrong checksum)");if(this.fields=jr(e),D(t).getUint16(0,!0)===2&&(this.fields.layers=[this.fields.count]),this.table=Vr(this.fields.streams),this.total=this.table.reduce((o,r)=>o+Ze(r.bytes),ae+e.length),this.total>qr)throw new v(`the .mgs file claims ${this.total} bytes, too many for a scene`)}#a(t){this.#s-=t;let e=this.#t[0];if(e!==void 0&&e.length>t)return this.#t[0]=e.subarray(t),e.subarray(0,t);let s=new Uint8Array(t),o=0,r=0;for(;o<t;){let i=this.#t[r],a=i.subarray(0,t-o);s.set(a,o),o+=a.length,a.length<i.length?this.#t[r]=i.subarray(a.length):r++}return this.#t.splice(0,r),s}};function Ze(n){return Math.ceil(n/8)*8}function Wr(n,t){let e=t.subarray(0,n.bytes);if(ne(e)!==n.crc32)throw new v(`the stream '${n.name}' of the .mgs file is damaged (wrong checksum)`);if(t.subarray(n.bytes).some(s=>s!==0))throw new v(`the .mgs file is damaged after its stream '${n.name}'`);return{name:n.name,codec:n.codec,data:e}}function Xr(n){let t=D(n),e=t.getUint16(0,!0),s=t.getUint32(4,!0);if(!Je.includes(e))throw new v(`the .mgs file is of version ${e}.${t.getUint16(2,!0)}, this program reads ${Je[0]}.x to ${Je[1]}.x: reload the page, or write the file again with this version of mobilegs`);if(s>$r)throw new v(`the header of the .mgs file claims ${s} bytes: it is damaged`);return s}function jr(n){let t;try{t=JSON.parse(new TextDecoder("utf-8",{fatal:!0,ignoreBOM:!0}).decode(n))}catch{throw new v("the header of the .mgs file is not valid JSON")}if(typeof t!="object"||t===null||Array.isArray(t))throw new v("the header of the .mgs file is not a JSON object");return t}function Vr(n){if(!Array.isArray(n)||n.length>Gr)throw new v("the header of the .mgs file lacks a table of streams");let t=new Set;return n.map(e=>{let{name:s,codec:o,bytes:r,crc32:i}=Object(e);if(!([s,o].every(c=>re(c,64))&&[r,i].every(c=>Number.isInteger(c)&&c>=0&&c<2**40)))throw new v("the header of the .mgs file has a broken table of streams");if(t.has(s))throw new v(`the .mgs file has two streams called '${s}'`);return t.add(s),{name:s,codec:o,bytes:r,crc32:i}})}function Fn(n){if(n.length===0)return"the file is empty, not a .mgs scene";if(ht.findIndex((o,r)=>o!==n[r])>=Math.min(3,n.length))return"the first bytes of the .mgs file are damaged: transfer it again, in binary mode";let e=String.fromCharCode(...n),s=Hr.find(([o])=>e.startsWith(o));return s?`this is not a .mgs scene but looks like ${s[1]}`:"this is not a .mgs scene"}var ts=class{header=null;decoder=null;#t=new ce;get received(){return this.#t.received}get total(){return this.#t.total}append(t){let e=this.#t.append(t),{fields:s,table:o,total:r}=this.#t;s!==null&&this.decoder===null&&(this.header=Ln(s,r),this.decoder=new se(this.header,o));for(let i of e)this.decoder?.accept(i)}end(){this.#t.end()}step(){return this.decoder?.step(this.received)??!1}};async function In(n,t){let e=new ts,s=n.getReader();try{for(let o=0;;){o-=performance.now();let{value:r,done:i}=await s.read();if(o+=performance.now(),i)break;e.append(r);do await t(e,o);while(e.step())}}catch(o){throw await s.cancel().catch(()=>{}),o}return e.end(),e}var os=16,es=6*os,$=64,le=13,ss=.01,ns=6,Nn=15,{fround:F,sqrt:Yr}=Math,fe=class{#t;#s;#o;#e;constructor(t,e,{static2:s,view2:o}){let r=3+o.length/9,i=new Float32Array(12*r);for(let a=0;a<12;a++){let c=a<3?s.subarray(3*a,3*a+3):o.subarray((a-3)*(r-3));i.set(c.subarray(0,r-3),a*r+(a<3?0:3))}this.#t=t,this.#s=t.block(r),this.#o=t.layer(i,r),this.#e=e}decode(t,e,s){N(e,this.#s.numbers,b,s,s+t.length/3),this.#t.apply(this.#o,this.#s,this.#e,1)}},he=class{#t;#s;#o;#e;#n;#r;#i;constructor(t,e,{both1:s,static2:o,view2:r}){this.#t=t,this.#s=[t.layer(s,ns),t.layer(o,$),t.layer(r,$)],this.#o=t.block(ns),this.#e=t.block(2*$),this.#n=[t.part(this.#e,0,$),t.part(this.#e,$,$)],this.#r=e,this.#i=t.part(e,3,12)}decode(t,e,s){let o=this.#t,[r,i,a]=this.#s;N(e,this.#o.numbers,b,s,s+t.length/3),o.apply(r,this.#o,this.#e,ss),o.apply(i,this.#n[0],this.#r,1),o.apply(a,this.#n[1],this.#i,1)}},de=class{#t;#s;#o;#e;#n;#r;#i;#a;#c;#l;constructor(t,e,{context1:s,context2:o,static1:r,static2:i,view1:a,view2:c},l){this.#t=t,this.#s=[t.layer(s,es),t.layer(o,$),t.layer(r,le+3),t.layer(i,$),t.layer(a,le+3),t.layer(c,$)],this.#l=2**l,this.#o=t.block(ns),this.#e=t.block(es),this.#n=t.block($),this.#r=t.block(le+3),this.#i=t.part(this.#r,le,3),this.#a=e,this.#c=t.part(e,3,12)}decode(t,e,s){let o=this.#t,[r,i,a,c,l,f]=this.#s,[h,d]=[this.#o.numbers,this.#i.numbers],[p,u,w]=[this.#e,this.#n,this.#r];this.#d(t,p.numbers),o.apply(r,p,u,0),o.apply(i,u,w,1),N(e,h,b,s,s+t.length/3),d.set(h.subarray(0,3*b)),o.apply(a,w,u,ss),o.apply(c,u,this.#a,1),d.set(h.subarray(3*b)),o.apply(l,w,u,ss),o.apply(f,u,this.#c,1)}#f(t,e){let s=U(t[e])*this.#l,o=U(t[e+1])*this.#l,r=U(t[e+2])*this.#l,i=F(F(F(s*s)+F(o*o))+F(r*r));return Math.max(1,F(Yr(i)))}#d(t,e){for(let s=0,o=0;o<t.length;s++,o+=3){let r=this.#f(t,o),i=F(2-F(1/r));for(let a=0;a<3;a++){let c=U(t[o+a])*this.#l,l=F(i*F(c/r));Kr(l,e,a*os*b+s)}}}};function Kr(n,t,e){let s=F(F(n*.25)+.5),o=Math.sin(Math.PI*s),r=Math.cos(Math.PI*s);for(let i=e+os*b;e<i;e+=b){t[e]=o,t[e+es/2*b]=r;let a=2*o*r;r=1-2*o*o,o=a}}var pe=.28209479177387814,ue=class{#t;#s;#o;#e;#n;#r;#i;constructor(t,e,s,{degree:o,latents:r,hidden:i},a){let c=2*(o+1)**2,l=i.at(-1)??0,f=[19+r,...i];this.#t=t,this.#o=s,this.#s=i.map((u,w)=>t.layer(a[`weights.${w}`],f[w],a[`offsets.${w}`]));let h=a[`weights.${i.length}`],d=Qr(h,l,a.basis,r,c);this.#s.push(t.layer(d,l+r,a.bias)),this.#e=t.block(r);let p=i.length?[19,...i]:[0];this.#n=p.map(u=>t.block(Math.ceil(u/4)*4+r)),this.#r=[0,p.length-1].map(u=>t.part(this.#n[u],p[u],r)),this.#i=i.length?new lt(t,e,this.#n[0]):null}decode(t,e,s){let[o,r,i]=[this.#t,this.#n,this.#s.length-1];this.#i?.write(),t&&N(t,this.#e.numbers,b,e,s),this.#r[0].numbers.set(this.#e.numbers);for(let a=0;a<i;a++)o.apply(this.#s[a],r[a],r[a+1],0);this.#r[1].numbers.set(this.#e.numbers),o.apply(this.#s[i],r[i],this.#o,1)}};function Qr(n,t,e,s,o){let r=t+s,i=new Float32Array(o*r);for(let a=0;a<o;a++){for(let c=0;c<t;c++)i[a*r+c]=n[a*t+c];for(let c=0;c<s;c++)i[a*r+t+c]=e[c*o+a]}return i}function St(n,t){for(let e=0;e<t.length;e++)n.fill(t[e],e*b,(e+1)*b)}var Jr=1/3,Zr=[1,0,0,0],dt=class{#t;#s=new ee;#o;#e;#n;#r;#i;#a;#c;#l;#f;constructor(t){let{header:e,samples:s}=t,{lobes:o,grid:r}=e,i=this.#s;this.#t=t;let a=o?.degree??0,c=i.block(Nn),l={logScales:i.block(3),scales:i.block(3),quats:i.block(4),sh:i.part(c,0,12),lobes:i.block(2*(a+1)**2+2),statics:i.block(e.network?19:0),words:i.block(18)};this.#o=l.quats,this.#n=o&&new ue(i,l,l.lobes,o,t.lobes),this.#r=e.network?new lt(i,l,l.statics):null;let{appearance:f}=t;e.colors==="linear"?this.#e=new fe(i,c,f):e.colors==="latent_networks"?this.#e=new he(i,c,f):this.#e=new de(i,c,f,r.exponent),i.allocate(),this.#c=Object.fromEntries([...t.books].map(([p,u])=>[p,{...u,columns:[]}])),this.#l=Bn(this.#h("scale")),this.#f=Bn(kt(this.#h("scale")));let h=Object.fromEntries(Object.entries(l).map(([p,{numbers:u}])=>[p,u])),d=ei(this.#l);this.#i={...h,count:0,lobeDegree:a,scaleRange:d,memory:i.wasmMemory},this.#a={sh:this.#d(s),lobes:[0,1/pe]},this.#n&&(this.#a.lobes=this.#w(this.#n))}#d(t){let{sh:e}=this.#i,s=new Float64Array(12),o=kt(this.#h("appearance"));for(let r=0;r<t.length;r+=3*b){let i=t.subarray(r,r+3*b);this.#e.decode(i,o,0);for(let a=0;a<12;a++)for(let c=0;3*c<i.length;c++)s[a]+=3*e[a*b+c]/t.length}return s}#w(t){let{scales:e,quats:s,sh:o,lobes:r}=this.#i,i=this.#c.lobes;return N(this.#f,e,b,0,b),St(s,Zr),St(o,this.#a.sh),t.decode(i?kt(i):null,0,b),Array.from({length:r.length/b-2},(a,c)=>r[c*b])}decode({positions:t,columns:e},s=0){let{header:o}=this.#t,r=t.subarray(3*s,3*(s+b)),i=r.length/3,a=s+i,[c,l]=[this.#i,this.#c];c.count=i,c.positions=r;let{logScales:f,scales:h,quats:d,sh:p,lobes:u}=c,{scale:w,rotation:m,appearance:y}=e,E=!0;for(let x of Object.keys(l)){let A=e[x];A?this.#h(x).columns=A:E=!1}this.#l.columns=w,N(this.#h("scale"),f,b,s,a),N(this.#l,h,b,s,a);let k=o.scalars.get("rotation");if(k?bn(k,m,s,a,d):(N(this.#h("rotation"),d,b,s,a),this.#s.units(this.#o,this.#o)),y?this.#e.decode(r,this.#h("appearance"),s):St(p,this.#a.sh),this.#n&&E?this.#n.decode(l.lobes??null,s,a):St(u,this.#a.lobes),l.opacity){let{books:[x]}=e.opacity?l.opacity:kt(l.opacity),A=e.opacity?.[0];ti(u,x,A,s,i)}return this.#r?.write(),c}get network(){return this.#r!==null}get lobeDegree(){return this.#i.lobeDegree}get scaleRange(){return this.#i.scaleRange}get neutral(){let t=[0,1,2].map(r=>.5+pe*this.#a.sh[r]),[e,s,o]=this.#f.books.map(([r])=>r);return{color:t,side:Jr*Math.cbrt(e*s*o)}}#h(t){return this.#c[t]}};function ti(n,t,e,s,o){for(let r=0;r<o;r++)n[r]+=t[e?e[s+r]:0]/pe}function Bn(n){return{...n,books:n.books.map(t=>t.map(Math.exp))}}function ei({books:n}){let t=[1/0,-1/0];for(let e of n)for(let s of e)t=[Math.min(t[0],s),Math.max(t[1],s)];return t}var{fround:L}=Math,si=["mobile_gs","no_depth","no_scale","sort_free_gs"],ni=q(-1e4),oi=[2047,2047,1023],Cn=L(511/Math.SQRT1_2),Dn=888,Tt=new Uint32Array(1),we=new Float32Array(Tt.buffer);function Pn({sorted:n,weighting:t,background:e,grid:s,lobes:o},r,i,a=null){let c=o?.degree??0,[l,f]=Gn(i);return{count:r,packing:{center:Array.from(s.center),unit:s.radius*2**s.exponent,leastScaleBits:l,scaleBitsSpan:f},...$n(a?10:qn(c),r),network:a&&Gs(a),shSize:4,lobeSize:(c+1)**2,sorted:n,weighting:{index:si.indexOf(t.name),exponentMax:t.exponent_max,sigma:t.sigma,backgroundWeight:t.background_weight,alphaMin:t.alpha_min},background:Array.from(e)}}function me(n,t,e=$n(rs(n),t.positions.length/3)){let s=t.positions.length/3,o=rs(n),r=4*b,i;for(let a=0;a<s;a+=b){let c=n.decode(t,a);i??=ri(c);let l=i();e.shapes.set(l.subarray(0,4*c.count),4*a),e.colors.set(l.subarray(r,r+4*c.count),4*a),e.lobes.set(l.subarray(2*r,2*r+o*c.count),o*a)}return e}var $n=(n,t)=>({shapes:new Uint32Array(4*t),colors:new Uint32Array(4*t),lobes:new Uint32Array(n*t)});function Gn(n){let[t,e]=n.map(s=>(we[0]=s,L(Tt[0])));return[t,e-t]}var qn=n=>(n+1)**2+2>>1,rs=({network:n,lobeDegree:t})=>n?10:qn(t);function ri(n,t=!1){let{scales:e,quats:s,sh:o,lobes:r,lobeDegree:i,statics:a,scaleRange:c,memory:l}=n,{buffer:f,byteOffset:h,length:d}=n.words,p=new Uint32Array(f,h,d),[u,w]=Gn(c),m=w>0?L(1/w):0,y=t?null:rt(l),[E,k,x,A]=[e,s,o,r].map(({byteOffset:nt})=>nt),M=a.length>0,[C,st]=[(i+1)**2-1,rs({network:M,lobeDegree:i})];return()=>{y?y.pack(E,k,x,A,h,C,st,u,m):ii(n,p,st,u,m),M&&ai(a,p);let{count:nt,positions:V}=n;for(let pt=0,ve=0;pt<nt;pt++,ve+=4)p[ve]=V[3*pt]|V[3*pt+1]<<16,p[ve+1]|=V[3*pt+2];return p}}function ii({scales:n,quats:t,sh:e,lobes:s,lobeDegree:o},r,i,a,c){let l=2*(o+1)**2;for(let f=0;f<b;f++){let h=8*b+i*f,d=fi(s,f,l,r,h);li(e,f,r,4*(b+f)),r[4*f+1]=d<<16;let p=0;for(let w=2;w>=0;w--){we[0]=n[w*b+f];let m=L(L(L(Tt[0])-a)*c);p=p<<11|L(L(oi[w]*Math.min(Math.max(m,0),1))+.5)}r[4*f+2]=p;let u=[0,1,2,3].map(w=>t[w*b+f]);r[4*f+3]=ci(u),u.some(Boolean)||(r[h]=ni|r[h]&4294901760)}}function ai(n,t){for(let e=0;e<b;e++){let s=8*b+10*e;t[s]=t[s]&65535|Math.round(32767*n[e])<<16;for(let o=1;o<10;o++){let[r,i]=[2*o-1,2*o].map(a=>Math.round(32767*n[a*b+e]));t[s+o]=r&65535|i<<16}}}function ci(n){let t=0;for(let o=1;o<4;o++)Math.abs(n[o])>Math.abs(n[t])&&(t=o);let e=n[t]<0?-Cn:Cn,s=t;for(let o=0;o<4;o++)o!==t&&(s=s<<10|L(L(e*n[o])+1024.5)&1023);return s}function li(n,t,e,s){let o=c=>n[c*b+t],r=Array.from({length:9},(c,l)=>o(3+l)),i=Xn(r),a=r.map(c=>Wn(i,c));e[s]=q(o(0))|q(o(1))<<16,e[s+1]=q(o(2))|i<<16|a[0]<<24;for(let c of[1,5])e[s+1+(c+3>>2)]=Hn(a,c)}function fi(n,t,e,s,o){let r=f=>n[f*b+t],i=Array.from({length:e-2},(f,h)=>r(2+h)),[a,c]=[0,1].map(f=>Xn(i.filter((h,d)=>d%2===f))),l=i.map((f,h)=>Wn(h%2?c:a,f));s[o]=q(r(0))|q(r(1))<<16;for(let f=0,h=o+1;f<l.length;f+=4,h++)s[h]=Hn(l,f);return a|c<<8}var Hn=(n,t)=>n[t]|n[t+1]<<8|n[t+2]<<16|n[t+3]<<24;function Wn(n,t){Tt[0]=n+Dn<<20;let e=L(L(127/we[0])*t);return L(Math.min(Math.max(e,-127),127)+512.5)&255}function Xn(n){return we[0]=Math.max(0,...n.map(Math.abs)),Math.min(Math.max((Tt[0]+1048575>>20)-Dn,0),255)}var jn=8192,hi=1e5,di=3,ui=2,pi=8,ge=class{results=[];#t=[];#s;#o=null;#e=null;#n=[];#r;#i=null;#a;#c;#l=!1;#f=!1;#d=()=>{};#w=()=>{};#h=new Promise((t,e)=>{this.#d=t,this.#w=e});constructor(t){this.#h.catch(()=>{});let e=0;for(let[s,o]of t.entries()){for(let r=0;r<o;r+=jn)this.#t.push({level:s,from:r,to:Math.min(r+jn,o),first:e+r});e+=o}this.#s=new Uint8Array(t.length),this.#a=new Uint8Array(this.#t.length),this.#c=this.#a.slice(),this.#r=e}set output(t){if(this.#i=t,t!==null)for(let[e,s]of this.results.splice(0))Yn(s,Vn(t,this.#r,e,e+s.shapes.length/4))}spawn(){let{decoderInputs:t}=this.#o,e=this.#r<hi?1:navigator.hardwareConcurrency;for(let s=1;s<Math.min(e,di+1);s++)this.#m(t)}#m(t){try{let e=Ee();e.postMessage({decoderInputs:t});let s={worker:e,jobs:0};e.onmessage=({data:o})=>{s.jobs--,this.#E(o),this.#x(s)},e.onerror=o=>o.preventDefault(),this.#n.push(s)}catch{}}start(t){return this.#o=t,this.#e=new dt(t.decoderInputs)}advance(t,e){if(!(e<=this.#s[t])){this.#s[t]=e;for(let s of this.#n)this.#x(s);this.#k().catch(this.#w)}}finish(){return this.#f=!0,this.#A(),this.#h}terminate(){for(let{worker:t}of this.#n)t.terminate()}get#g(){return this.#a.findIndex((t,e)=>t<this.#u(e))}get#v(){let t=this.#g;return t<0?this.#c.findIndex((e,s)=>e<this.#u(s)):t}#u(t){return this.#s[this.#t[t].level]}#b(t,e){let{levels:s}=this.#o,{level:o,from:r,to:i}=this.#t[t];return s[o].rows(r,i,e)}#y(t){let{first:e,from:s,to:o}=this.#t[t];return this.#i?Vn(this.#i,this.#r,e,e+o-s):void 0}#x(t){for(let e;t.jobs<ui&&(e=this.#g)>=0;t.jobs++){let s=this.#a[e]=this.#u(e),o=this.#b(e,"slice"),r=[o.positions,...Object.values(o.columns).flat()].map(({buffer:i})=>i);t.worker.postMessage({rows:o,chunk:e,stage:s},{transfer:r})}}async#k(){if(!this.#l){this.#l=!0;for(let t;(t=this.#v)>=0&&this.#e;){let e=this.#a[t]=this.#u(t),s=me(this.#e,this.#b(t,"subarray"),this.#y(t));this.#E({chunk:t,stage:e,packed:s}),await is()}this.#l=!1}}#E({chunk:t,stage:e,packed:s}){if(e<=this.#c[t])return;this.#c[t]=e;let o=this.#y(t);o===void 0?this.results.push([this.#t[t].first,s]):o.shapes.buffer!==s.shapes.buffer&&Yn(s,o),this.#A()}get firstLevelReady(){return this.#t.every(({level:t},e)=>t>0||this.#c[e]>0)}get levels(){let t=this.#c.findIndex(e=>e<At);return t<0?this.#s.length:this.#t[t].level}#A(){this.#f&&this.#v<0&&this.#d()}};function Vn(n,t,e,s){let o=r=>{let i=n[r].length/t;return n[r].subarray(i*e,i*s)};return{shapes:o("shapes"),colors:o("colors"),lobes:o("lobes")}}function Yn(n,t){for(let e of Object.keys(t))t[e].set(n[e])}var Kn=0;async function is(){if(performance.now()-Kn<pi)return;let{port1:n,port2:t}=new MessageChannel;await new Promise(e=>{n.onmessage=()=>{n.close(),e(null)},t.postMessage(null)}),Kn=performance.now()}var wi=.28209479177387814,[mi,gi]=[13.8,-69],bi=new Map([["char",1],["int8",1],["uchar",1],["uint8",1],["short",2],["int16",2],["ushort",2],["uint16",2],["int",4],["int32",4],["uint",4],["uint32",4],["float",4],["float32",4],["double",8],["float64",8]]),Qn=["x","y","z","f_dc_0","f_dc_1","f_dc_2","opacity","scale_0","scale_1"];Qn.push("scale_2","rot_0","rot_1","rot_2","rot_3");function cs(n){return n[0]===112&&n[1]===108&&n[2]===121}function Jn(n){let{offsets:t,stride:e,rows:s,start:o}=vi(n),r=new DataView(n.buffer,n.byteOffset+o),i=[...t.keys()].filter(w=>w.startsWith("f_rest_")).length,a=i/3+1;if(![1,4,9,16].includes(a))throw new Error(`the .ply file has ${i} numbers f_rest_*: 0, 9, 24 or 45 were expected`);let c=w=>t.get(w),l=["x","y","z","scale_0","scale_1","scale_2","rot_0","rot_1","rot_2","rot_3"];l.push("opacity","f_dc_0","f_dc_1","f_dc_2");for(let w=0;w+1<a;w++)for(let m=0;m<3;m++)l.push(`f_rest_${m*(a-1)+w}`);let f=l.find(w=>!t.has(w));if(f)throw new Error(`the .ply file has ${i} numbers f_rest_*, but not ${f}`);let h=l.map(c),d=ls(s,a),p=new Float32Array(h.length);for(let w=0;w<s;w++){for(let y=0;y<p.length;y++)p[y]=r.getFloat32(w*e+h[y],!0);for(let y=3;y<6;y++)p[y]===-1/0&&(p[y]=gi);Math.abs(p[10])===1/0&&(p[10]=Math.sign(p[10])*mi);let m=0;for(let y=0;y<p.length;y++)m+=p[y]*0;m===0&&fs(d,p)}let{count:u}=d;return u===s||(d.shapes=d.shapes.slice(0,12*u),d.colors=d.colors.slice(0,3*a*u),d.lobes=d.lobes.slice(0,2*u)),d}function as(n=""){return`'${n.slice(0,40).replace(/[^\x20-\x7e]/g,"\uFFFD")}'`}function ls(n,t){return{count:0,packing:null,shapes:new Float32Array(12*n),colors:new Float32Array(3*t*n),shSize:t,lobes:new Float32Array(2*n),lobeSize:1,sorted:!0,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},background:[0,0,0]}}function fs(n,t){let[e,s,o,r]=[t[6],t[7],t[8],t[9]],i=e*e+s*s+o*o+r*r;if(!(i>0))return;let a=2/i,[c,l,f]=[Math.exp(t[3]),Math.exp(t[4]),Math.exp(t[5])];if(!(c+l+f<1e30&&Math.abs(t[10])<1e30))return;let h=n.count++;n.shapes.set([c*(1-a*(o*o+r*r)),c*a*(s*o+e*r),c*a*(s*r-e*o),t[0],l*a*(s*o-e*r),l*(1-a*(s*s+r*r)),l*a*(o*r+e*s),t[1],f*a*(s*r+e*o),f*a*(o*r-e*s),f*(1-a*(s*s+o*o)),t[2]],12*h),n.lobes[2*h]=t[10]/wi,n.colors.set(t.subarray(11),3*n.shSize*h)}function vi(n){let t=new TextDecoder("latin1").decode(n.subarray(0,65536)),e=/\nend_header\r?\n/.exec(t);if(!cs(n)||e===null)throw new Error("this is not a PLY file, or its header is cut off");let s=t.slice(0,e.index).split(/\r?\n/).map(d=>d.trim().split(/\s+/)),o=s.find(d=>d[0]==="format")?.[1];if(o!=="binary_little_endian")throw new Error(`the .ply file is ${as(o)}: only binary_little_endian is read`);let r=s.findIndex(d=>d[0]==="element"),i=s[r]??[],a=/^\d+$/.test(i[2])?Number(i[2]):NaN;if(i[1]!=="vertex"||!Number.isSafeInteger(a)||a<0)throw new Error("the .ply file does not begin with its vertices, as those of 3DGS do");let c=new Map,l=0;for(let d of s.slice(r+1)){if(d[0]==="element")break;if(d[0]!=="property")continue;let p=bi.get(d[1]);if(p===void 0)throw new Error(`the .ply file has a property of type ${as(d[1])}`);if(d.length!==3)throw new Error("the .ply file has a property without a name, or with two");if(c.has(d[2]))throw new Error(`the .ply file has the property ${as(d[2])} twice`);(d[1]==="float"||d[1]==="float32")&&c.set(d[2],l),l+=p}let f=Qn.filter(d=>!c.has(d));if(f.length)throw new Error(`the .ply file is not a Gaussian scene: it lacks ${f.join(", ")} as floats`);let h=e.index+e[0].length;if(h+a*l>n.length)throw new Error(`the .ply file is cut off: ${a} Gaussians were announced`);return{offsets:c,stride:l,rows:a,start:h}}var B="the compressed data is damaged or cut off";var tt=class{left;#t;constructor(t){let e=t[t.length-1];if(!e)throw new Error(B);this.#t=t,this.left=8*t.length-1-Math.clz32(e)+24}take(t){return t>24?this.take(t-16)*65536+this.take(16):(this.left-=t,this.#s(this.left,t))}decode(t,{width:e,symbols:s,bits:o}){for(let r=0;r<t.length;r++){let i=this.#s(this.left-e,e);t[r]=s[i],this.left-=o[i]}if(this.left!==0)throw new Error(B)}#s(t,e){let s=this.#t;if(t<0)return t+e>0?this.#s(0,t+e)<<-t:0;let o=t>>3;return(s[o]|s[o+1]<<8|s[o+2]<<16|s[o+3]<<24)>>>(t&7)&(1<<e)-1}};function Zn(n){let t=new Uint8Array(1);return{accuracy:0,symbols:Uint8Array.of(n),bits:t,bases:new Uint16Array(1)}}function Mt(n,t){let e=1<<n,s={accuracy:n,symbols:new Uint8Array(e),bits:new Uint8Array(e),bases:new Uint16Array(e)},o=e;for(let[c,l]of t.entries())l===-1&&(s.symbols[--o]=c);let r=(e>>1)+(e>>3)+3,i=0;for(let[c,l]of t.entries())for(let f=0;f<l;f++){s.symbols[i]=c;do i=i+r&e-1;while(i>=o)}if(i!==0)throw new Error(B);let a=t.map(c=>Math.abs(c));for(let c=0;c<e;c++){let l=a[s.symbols[c]]++,f=n-(31-Math.clz32(l));s.bits[c]=f,s.bases[c]=(l<<f)-e}return s}function hs(n,t,e,s){let o=8*t,r=l=>{let f=o>>3,d=(n[f]|n[f+1]<<8|n[f+2]<<16)>>(o&7)&(1<<l)-1;return o+=l,d},i=5+r(4);if(i>e)throw new Error(B);let a=[];for(let l=1<<i;l>0;){let f=32-Math.clz32(l+1),h=(1<<f)-2-l,d=r(f-1);d>=h&&r(1)&&(d+=(1<<f-1)-h);let p=d-1;l-=Math.abs(p),a.push(p);for(let u=p===0?3:0;u===3;){u=r(2);for(let w=0;w<u;w++)a.push(0)}if(l<0||a.length>s)throw new Error(B)}let c=o+7>>3;if(c>n.length)throw new Error(B);return{table:Mt(i,a),end:c}}function to(n,t){let e=n[t++];if(!(e<128)){let l=e-127,f=t+(l+1>>1);if(!(f<=n.length))throw new Error(B);let h=d=>n[t+(d>>1)]>>(d%2?0:4)&15;return{weights:Array.from({length:l},(d,p)=>h(p)),end:f}}let s=t+e;if(s>n.length)throw new Error(B);let{table:o,end:r}=hs(n.subarray(0,s),t,6,13),i=new tt(n.subarray(r,s)),a=[],c=[i.take(o.accuracy),i.take(o.accuracy)];for(let l=0;a.length<255;l^=1){let f=c[l];if(a.push(o.symbols[f]),c[l]=o.bases[f]+i.take(o.bits[f]),i.left<0)return a.push(o.symbols[c[l^1]]),{weights:a,end:s}}throw new Error(B)}function eo(n){let t=c=>c>0?1<<c-1:0,e=0;for(let c of n)e+=t(c);let s=32-Math.clz32(e),o=(1<<s)-e;if(e===0||s>11||o&o-1)throw new Error(B);let r=[...n,32-Math.clz32(o)];if(r.length>256)throw new Error(B);let i={width:s,symbols:new Uint8Array(1<<s),bits:new Uint8Array(1<<s)},a=0;for(let c=1;c<=s;c++)for(let[l,f]of r.entries()){if(f!==c)continue;let h=a+t(c);i.symbols.fill(l,a,h),i.bits.fill(s+1-c,a,h),a=h}return i}var yi=4247762216,xi=25481893,Rt=1<<17,T="the compressed data is damaged or cut off";function oo(n,t){let e=[];for(let s of t)e.push(n),n+=2**s;return{bits:t,bases:e}}var so=oo(0,[...Array(16).fill(0),1,1,1,1,2,2,3,3,4,6,7,8,9,10,11,12,13,14,15,16]),no=oo(3,[...Array(32).fill(0),1,1,1,1,2,2,3,3,4,4,5,7,8,9,10,11,12,13,14,15,16]),Ei=[{accuracy:9,symbols:36,usual:Mt(6,[4,3,2,2,2,2,2,2,2,2,2,2,2,1,1,1,2,2,2,2,2,2,2,2,2,3,2,1,1,1,1,1,-1,-1,-1,-1])},{accuracy:8,symbols:32,usual:Mt(5,[1,1,1,1,1,1,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1])},{accuracy:9,symbols:53,usual:Mt(6,[1,4,3,2,2,2,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1,-1,-1])}],ds=class{length=0;bytes;#t;constructor(t){this.#t=t,this.bytes=new Uint8Array(Math.min(t,Rt))}reserve(t){let e=this.length+t;if(e>this.#t)throw new Error("the compressed data is longer than announced");if(e<=this.bytes.length)return;let s=new Uint8Array(Math.min(this.#t,Math.max(e,2*this.bytes.length)));s.set(this.bytes.subarray(0,this.length)),this.bytes=s}append(t){this.reserve(t.length),this.bytes.set(t,this.length),this.length+=t.length}fill(t,e){this.reserve(e),this.bytes.fill(t,this.length,this.length+e),this.length+=e}repeat(t,e){if(!(t>0&&t<=this.length))throw new Error(T);this.reserve(e);let{bytes:s}=this,o=this.length+e;if(t>=e)s.copyWithin(this.length,this.length-t,o-t);else for(let r=this.length;r<o;r++)s[r]=s[r-t];this.length=o}};function ro(n,t){let e=new ds(t),s=new DataView(n.buffer,n.byteOffset,n.byteLength),o=0;for(;o<n.length;){if(o+8>n.length)throw new Error(T);let r=s.getUint32(o,!0);if(r>>>4===xi)o+=8+s.getUint32(o+4,!0);else if(r===yi)o=ki(n,o+4,e);else throw new Error(T)}if(o!==n.length||e.length!==t)throw new Error(T);return e.bytes}function ki(n,t,e){let s=n[t++],o=(s&32)!==0;if(o||(t+=1),n.subarray(t,t+=[0,1,2,4][s&3]).some(a=>a))throw new Error("the compressed data needs a dictionary, which is missing");t+=[o?1:0,2,4,8][s>>6];let i={huffman:null,tables:[null,null,null],recent:[1,4,8]};for(let a=!1;!a;){if(t+3>n.length)throw new Error(T);let c=n[t]|n[t+1]<<8|n[t+2]<<16;t+=3,a=(c&1)===1;let l=c>>1&3,f=c>>3,h=l===1?1:f;if(l===3||f>Rt||t+h>n.length)throw new Error(T);l===0?e.append(n.subarray(t,t+f)):l===1?e.fill(n[t],f):Ai(n.subarray(t,t+f),i,e),t+=h}return t+(s&4?4:0)}function Ai(n,t,e){let{literals:s,end:o}=Ti(n,t),r=o,i=n[r++];if(i===void 0)throw new Error(T);if(i===255?(i=n[r]+(n[r+1]<<8)+32512,r+=2):i>127&&(i=(i-128<<8)+n[r++]),i===0){e.append(s);return}let a=n[r++];if(!(i>0)||a===void 0||a&3)throw new Error(T);for(let[c,{accuracy:l,symbols:f,usual:h}]of Ei.entries()){let d=a>>6-2*c&3;if(d===0)t.tables[c]=h;else if(d===1){if(!(n[r]<f))throw new Error(T);t.tables[c]=Zn(n[r++])}else if(d===2){let{table:p,end:u}=hs(n,r,l,f);t.tables[c]=p,r=u}}_i(new tt(n.subarray(r)),i,s,t,e)}function _i(n,t,e,{tables:s,recent:o},r){let[i,a,c]=s;if(!i||!a||!c)throw new Error(T);let l=n.take(i.accuracy),f=n.take(a.accuracy),h=n.take(c.accuracy),d=0,p=r.length+Rt;for(let u=t;u>0;u--){let w=a.symbols[f],m=c.symbols[h],y=i.symbols[l],E=2**w+n.take(w),k=no.bases[m]+n.take(no.bits[m]),x=so.bases[y]+n.take(so.bits[y]);if(u>1&&(l=i.bases[l]+n.take(i.bits[l]),h=c.bases[h]+n.take(c.bits[h]),f=a.bases[f]+n.take(a.bits[f])),n.left<0||d+x>e.length)throw new Error(T);if(r.append(e.subarray(d,d+x)),d+=x,r.repeat(Si(E,x,o),k),r.length>p)throw new Error(T)}if(n.left!==0)throw new Error(T);r.append(e.subarray(d))}function Si(n,t,e){if(n>3)return e.unshift(n-3),e.pop(),e[0];let s=t===0?n:n-1,o=s<3?e[s]:e[0]-1;return s>0&&(e.splice(Math.min(s,2),1),e.unshift(o)),o}function Ti(n,t){let e=n[0]|n[1]<<8|n[2]<<16,s=n[0]&3,o=n[0]>>2&3;if(s<2){let d=[1,2,1,3][o],p=d===1?n[0]>>3:(e&(d===2?65535:16777215))>>4,u=d+(s===0?p:1);if(p>Rt||!(u<=n.length))throw new Error(T);return s===0?{literals:n.subarray(d,u),end:u}:{literals:new Uint8Array(p).fill(n[d]),end:u}}let r=[3,3,4,5][o],i=[10,10,14,18][o],a=(e>>>0)+(n[3]??0)*2**24+(n[4]??0)*2**32,c=Math.floor(a/16)%2**i,l=Math.floor(a/2**(4+i))%2**i,f=r+l;if(c>Rt||!(f<=n.length))throw new Error(T);let h=r;if(s===2){let{weights:d,end:p}=to(n.subarray(0,f),h);t.huffman=eo(d),h=p}if(t.huffman===null)throw new Error(T);return{literals:Mi(n.subarray(h,f),c,o!==0,t.huffman),end:f}}function Mi(n,t,e,s){let o=new Uint8Array(t);if(!e)return new tt(n).decode(o,s),o;if(n.length<6)throw new Error(T);let r=t+3>>2;for(let i=0,a=6;i<4;i++){let c=i<3?n[2*i]|n[2*i+1]<<8:n.length-a;if(a+c>n.length)throw new Error(T);let l=i<3?(i+1)*r:t;if(l>t)throw new Error(T);new tt(n.subarray(a,a+c)).decode(o.subarray(i*r,l),s),a+=c}return o}var Ri=1347635022,Oi=1e7,be=16,ao=32,co=[0,3,8,15,24],Li=15,Ui=.15,zi=[-1,-1,1,-1,1,1,-1,1,-1,1,-1,-1,1,-1,1],et="the .spz file is damaged or cut off";function lo(n){return n[0]===78&&n[1]===71&&n[2]===83&&n[3]===80||n[0]===31&&n[1]===139}async function fo(n){if(n[0]!==31){let r=ho(n,n.length);return io(r,Ii(r,n))}let{header:t,content:e}=await Fi(n),s=[],o=be;for(let r of us(t))s.push(e.subarray(o,o+=r));return io(t,s)}function ho(n,t){let e=new DataView(n.buffer,n.byteOffset,n.byteLength);if(n.length<be||e.getUint32(0,!0)!==Ri)throw new Error("this is not a .spz file");let s=e.getUint32(4,!0),o=s<4;if(s<1||s>4)throw new Error(`the .spz file has version ${s}: 1 to 4 are read`);if(!o&&n.length<ao)throw new Error(et);let r=e.getUint32(8,!0),[i,a,c,l]=n.subarray(12,16);if(r>Oi)throw new Error(`the .spz file announces ${r} Gaussians, too many to be drawn`);if(r>t)throw new Error(`the .spz file announces ${r} Gaussians in ${t} bytes: it is cut off`);if(i>4||a>24)throw new Error(et);let f=(c&2)!==0;return{version:s,count:r,degree:i,fraction:a,extended:f,streams:l,table:o?0:e.getUint32(16,!0)}}function us({version:n,count:t,degree:e}){return[n===1?6:9,1,3,3,n<3?3:4,3*co[e]].map(s=>s*t)}async function Fi(n){let e=new Response(n).body.pipeThrough(new DecompressionStream("gzip")).getReader(),s=[],o=0,r=null,i=1/0,a=async()=>new Uint8Array(await new Blob(s).arrayBuffer());for(;o<=i;){let{value:c,done:l}=await e.read().catch(()=>{throw new Error(et)});if(l)break;if(s.push(c),o+=c.length,r===null&&o>=be){if(r=ho(await a(),n.length),r.version>3)throw new Error("this is not a .spz file");i=us(r).reduce((f,h)=>f+h,be)}}if(r===null)throw new Error("this is not a .spz file");if(o>i&&(await e.cancel().catch(()=>{}),!r.extended))throw new Error("the .spz file holds more than it announces");if(o<i)throw new Error(`the .spz file is cut off: ${r.count} Gaussians were announced`);return{header:r,content:await a()}}function Ii(n,t){let{streams:e,table:s,version:o}=n,r=us(n),i=s+16*e,a=r.filter(h=>h>0).length;if(o!==4||s<ao||i>t.length||e!==a)throw new Error(et);let c=new DataView(t.buffer,t.byteOffset,t.byteLength),[l,f]=[s,i];return r.map(h=>{if(h===0)return new Uint8Array(0);let d=Number(c.getBigUint64(l,!0)),p=Number(c.getBigUint64(l+8,!0));if(l+=16,f+d>t.length||p!==h)throw new Error(et);let u=t.subarray(f,f+=d);try{return ro(u,h)}catch(w){throw new Error(`${et}: ${w instanceof Error?w.message:w}`)}})}function io({version:n,count:t,degree:e,fraction:s},o){let[r,i,a,c,l,f]=o,h=co[e],d=Math.min(h,Li),p=d+1,u=ls(t,p),w=new Float32Array(11+3*p),m=n===1?Bi(r):Ni(r,2**-s),y=n<3?Ci:Di;for(let E=0;E<t;E++){w[0]=m(3*E),w[1]=-m(3*E+1),w[2]=-m(3*E+2);for(let x=0;x<3;x++)w[3+x]=c[3*E+x]/16-10;y(l,E,w);let k=Math.min(Math.max(i[E]/255,1e-6),1-1e-6);w[10]=Math.log(k/(1-k));for(let x=0;x<3;x++)w[11+x]=(a[3*E+x]/255-.5)/Ui;for(let x=0;x<d;x++)for(let A=0;A<3;A++)w[14+3*x+A]=zi[x]*(f[3*(h*E+x)+A]-128)/128;fs(u,w)}return u}function Ni(n,t){return e=>{let s=3*e;return t*((n[s]<<8|n[s+1]<<16|n[s+2]<<24)>>8)}}function Bi(n){return t=>{let e=U(n[2*t]|n[2*t+1]<<8);if(!Number.isFinite(e))throw new Error(et);return e}}function Ci(n,t,e){let[s,o,r]=[0,1,2].map(a=>n[3*t+a]/127.5-1),i=Math.sqrt(Math.max(0,1-s*s-o*o-r*r));e.set([i,s,-o,-r],6)}function Di(n,t,e){let s=4*t,o=n[s]|n[s+1]<<8|n[s+2]<<16|n[s+3]<<24,r=o>>>30,i=[0,0,0,0],a=1;for(let c=0,l=20;c<4;c++){if(c===r)continue;let f=(o>>l&511)/511*Math.SQRT1_2;i[c]=o>>l+9&1?-f:f,a-=f*f,l-=10}i[r]=Math.sqrt(Math.max(0,a)),e.set([i[3],i[0],-i[1],-i[2]],6)}var Pi=8192,$i=.2,Gi=2**20,uo=1500,qi=8,go=["shapes","colors","lobes"],ut=new Float32Array(0),G=(n,t=[])=>self.postMessage(n,{transfer:t}),bo=({shapes:n,colors:t,lobes:e})=>[n.buffer,t.buffer,e.buffer];async function Hi(n){if("file"in n)return{source:n.file.stream(),total:n.file.size};let t;try{t=await fetch(n.url)}catch{throw new Error(`${n.url} cannot be reached: is the address right, the network there, and may this site load it (CORS)?`)}if(!t.ok||t.body===null)throw new Error(`${n.url} could not be loaded: the server says ${t.status}`);let e=t.headers.has("Content-Encoding")?NaN:Number(t.headers.get("Content-Length"));return{source:t.body,total:e||NaN}}var ps=class{#t;#s;#o;#e;#n;#r=0;#i=null;#a=!1;constructor(t,e,s,o,r){this.#t=t,this.#n=r,this.#s=e,this.#o=s,this.#e=o;let{grid:i,views:a,near:c}=t,l=Array.from(t.background),{color:f,side:h}=o.neutral,d=Se(zs(e[0].positions,Pi),i),p=h*Math.sqrt(3*t.count/d.length),u={means:d,color:f,side:p,background:l};G({kind:"dots",dots:u,views:a,near:c},[u.means.buffer])}send(t){if(!this.#o.firstLevelReady||!this.allocate(t))return;let e=this.#o.levels,s=this.#r;this.#r=Math.max(e,1);let o=this.#o.results.splice(0),r=this.#i;if(r){this.#i=this.#o.output=null;let{views:i,near:a}=this.#t;G({kind:"scene",data:r,means:this.#c(),views:i,near:a},bo(r));return}for(let[i,a]of o)for(let c of go){let l=a[c];G({kind:"rows",part:c,from:i,numbers:l},[l.buffer])}s!==this.#r&&G({kind:"more",means:this.#c()})}allocate(t){let{count:e}=this.#t;return!this.#a&&qi*t>=e&&(this.#i=this.#o.output=Pn(this.#t,e,this.#e.scaleRange,this.#n),this.#a=!0),this.#a}#c(){let t=this.#s.slice(0,this.#r),e=new Uint16Array(t.reduce((r,{count:i})=>r+3*i,0)),s=0;for(let{positions:r,count:i}of t)e.set(r,s),s+=3*i;let o={stored:e,grid:this.#t.grid};return this.#t.sorted&&(ut=Dt(o)),o}};async function Wi(n){let t=null,e=null,[s,o]=[0,0],r=[],i=async({header:a,decoder:c,received:l,total:f},h)=>{if(G({kind:"progress",received:l,total:f}),a===null||c===null)return;o=l,t??=new ge(a.lodSizes);let d=r=c.levels,p=h*(f/l-1)>uo;d[0].positions&&!e&&(e=new ps(a,d,t,t.start(c),c.network),t.spawn(),s=setInterval(()=>e?.send(o),uo)),e?.allocate(l);for(let[u,{stage:w}]of d.entries())e&&(w===Ve||p&&u===0&&w>=At)&&t.advance(u,w);await is()};try{await In(n,i)}finally{for(let[a,{stage:c,positions:l}]of r.entries())e&&l&&c>=At&&t?.advance(a,c);await t?.finish().finally(()=>{clearInterval(s),t?.terminate()}),e?.send(o)}return o}async function po(n,t,e){let[s,o]=[new Uint8Array(t||Gi),0],r=n.getReader();for(let a;!(a=await r.read()).done;){let c=o+a.value.length;if(c>s.length){let l=s;s=new Uint8Array(Math.max(c,2*s.length)),s.set(l)}s.set(a.value,o),o=c,G({kind:"progress",received:o,total:t})}let i=await e(s.subarray(0,o));if(!i.count)throw new Error("there is no Gaussian in this file that can be drawn");ut=new Float32Array(3*i.count);for(let a=0;a<ut.length;a++)ut[a]=i.shapes[4*a+3];return G({kind:"scene",data:i,means:ut,views:[],near:$i},bo(i)),o}async function Xi(n){let t=n.getReader(),e=()=>t.read().catch(()=>{throw new Error("the file broke off before its end: load it again")}),s=await e(),o=s?.value??new Uint8Array(0),r=new ReadableStream({async pull(i){let{value:a,done:c}=s??await e();s=null,c?i.close():i.enqueue(a)},cancel:()=>t.cancel()});return{first:o,whole:r}}async function wo(n){let t=performance.now();try{let{source:e,total:s}=await Hi(n),{first:o,whole:r}=await Xi(e),i;cs(o)?i=await po(r,s,Jn):lo(o)?i=await po(r,s,fo):i=await Wi(r),G({kind:"done",milliseconds:performance.now()-t,bytes:i})}catch(e){let{message:s}=e,o=e instanceof RangeError?`the scene is too large for this device: ${s}`:s;G({kind:"failed",sentence:o})}}var mo;function vo(){self.onmessage=async({data:n})=>{if("decoderInputs"in n){mo=new dt(n.decoderInputs);return}if("rows"in n){let{rows:t,chunk:e,stage:s}=n,o=me(mo,t),r=go.map(i=>o[i].buffer);self.postMessage({chunk:e,stage:s,packed:o},{transfer:r});return}if("forward"in n){let t=Ft(ut,n.forward);G({kind:"order",order:t},[t.buffer]);return}await wo(n)},self.name&&wo({url:self.name})}globalThis.document||vo();
})();
