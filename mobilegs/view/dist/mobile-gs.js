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
if (!(e.depth > position.w) || !(e.compensation > 0.0)) { return look; }
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
`,"project.wgsl":`override STRIPS = false;
struct Drawn {
vertices: u32,
instances: atomic<u32>,
first: u32,
base: u32,
first_instance: u32,
count: atomic<u32>,
}
@group(0) @binding(4) var<storage, read_write> looks: array<StoredLook>;
@group(0) @binding(5) var<storage, read_write> lists: array<u32>;
@group(0) @binding(6) var<storage, read_write> drawn: array<Drawn, LEVELS>;
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
struct Seen {
look: Look,
level: u32,
}
fn look_at(i: u32) -> Seen {
var seen_now: Seen;
let shape = shape_of(i);
let ellipse = ellipse_of(shape);
if (!(ellipse.depth > view.near) || !(ellipse.compensation > 0.0)) { return seen_now; }
let away = shape.mean - view.position;
let basis = harmonics(max(view.sh_size, view.lobe_size), away * inverseSqrt(dot(away, away)));
let seen = lobes_along(i, basis);
let opacity = 1.0 / (1.0 + exp(min(-seen.x, 80.0)));
if (!(opacity > view.alpha_min)) { return seen_now; }
if (!touches(ellipse, opacity)) { return seen_now; }
let a = shape.axes;
let largest = sqrt(max(dot(a[0], a[0]), max(dot(a[1], a[1]), dot(a[2], a[2]))));
let weight = weight_of(ellipse.depth, largest, max(seen.y, 0.0));
seen_now.look = Look(max(color_along(i, basis), vec3f(0.0)), weight * view.weight_scale, opacity);
seen_now.level = level_of(ellipse, weight);
return seen_now;
}
var<workgroup> found: array<atomic<u32>, LEVELS>;
var<workgroup> begin: array<u32, LEVELS>;
@compute @workgroup_size(BATCH)
fn project_sorted(
@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
@builtin(local_invocation_index) local: u32) {
let i = (group.y * groups.x + group.x) * BATCH + local;
if (i < view.count) { looks[i] = store(look_at(i).look); }
}
@compute @workgroup_size(BATCH)
fn project_sortfree(
@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
@builtin(local_invocation_index) local: u32) {
let i = (group.y * groups.x + group.x) * BATCH + local;
if (local < LEVELS) { atomicStore(&found[local], 0u); }
workgroupBarrier();
var level = LEVELS;
var place = 0u;
if (i < view.count) {
let now = look_at(i);
looks[i] = store(now.look);
if (now.look.opacity > 0.0) {
level = now.level;
place = atomicAdd(&found[level], 1u);
}
}
workgroupBarrier();
if (local < LEVELS) {
let number = atomicLoad(&found[local]);
if (number > 0u) {
let first = atomicAdd(&drawn[local].count, number);
begin[local] = first;
let end = first + number;
atomicMax(&drawn[local].instances, select((end + BATCH - 1u) / BATCH, end, STRIPS));
}
}
workgroupBarrier();
if (level < LEVELS) {
lists[place_of(level, begin[level] + place, arrayLength(&lists) / 2u)] = i;
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
@group(0) @binding(3) var coarse_colors: texture_2d<f32>;
@group(0) @binding(4) var coarse_weights: texture_2d<f32>;
struct Sums {
color: vec4f,
weight: f32,
}
fn enlarged(pixel: vec2i, begin: i32) -> Sums {
let at = pixel - begin;
let nearest = (at >> vec2u(1u)) + 1;
let other = nearest + 2 * (at & vec2i(1)) - 1;
let a = nearest;
let b = vec2i(other.x, nearest.y);
let c = vec2i(nearest.x, other.y);
let color = 0.5625 * textureLoad(coarse_colors, a, 0) + 0.1875 * textureLoad(coarse_colors, b, 0) +
0.1875 * textureLoad(coarse_colors, c, 0) + 0.0625 * textureLoad(coarse_colors, other, 0);
let weight = 0.5625 * textureLoad(coarse_weights, a, 0).r + 0.1875 * textureLoad(coarse_weights, b, 0).r +
0.1875 * textureLoad(coarse_weights, c, 0).r + 0.0625 * textureLoad(coarse_weights, other, 0).r;
return Sums(color, weight);
}
struct Added {
@location(0) color: vec4f,
@location(1) weight: vec4f,
}
@fragment
fn add_enlarged(@builtin(position) position: vec4f) -> Added {
let sums = enlarged(vec2i(position.xy), 1);
return Added(vec4f(sums.color.rgb, 1.0 - sums.color.a), vec4f(sums.weight, 0.0, 0.0, 0.0));
}
@vertex
fn whole_picture(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
return vec4f(f32((vertex << 1u) & 2u) * 2.0 - 1.0, f32(vertex & 2u) * 2.0 - 1.0, 0.0, 1.0);
}
@fragment
fn resolve_sortfree(@builtin(position) position: vec4f) -> @location(0) vec4f {
let pixel = vec2i(position.xy);
return resolved(textureLoad(colors, pixel, 0), textureLoad(weights, pixel, 0).r);
}
@fragment
fn resolve_levels(@builtin(position) position: vec4f) -> @location(0) vec4f {
let pixel = vec2i(position.xy);
let sum = textureLoad(colors, pixel, 0);
let coarse = enlarged(pixel, 0);
let all = vec4f(sum.rgb + coarse.color.rgb, sum.a * coarse.color.a);
return resolved(all, textureLoad(weights, pixel, 0).r + coarse.weight);
}
fn resolved(sum: vec4f, weight: f32) -> vec4f {
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
flat out vec4 center;
void main() {
gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
axes = vec4(0.0);
color = vec4(0.0);
center = vec4(0.0);
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
center = vec4(e.center, look.opacity, e.compensation);
vec2 side = (reach_of(look.opacity) * sizes + 0.02) *
(vec2(gl_VertexID & 1, (gl_VertexID >> 1) & 1) * 2.0 - 1.0);
vec2 at = e.center + side.x * way + side.y * across;
gl_Position = vec4(at / size.xy * 2.0 - 1.0, 0.0, 1.0);
}
#else
flat in vec4 axes;
flat in vec4 color;
flat in vec4 center;
layout(location = 0) out vec4 color_out;
#ifndef SORTED
layout(location = 1) out vec4 weight_out;
#endif
void main() {
vec2 d = gl_FragCoord.xy - center.xy;
vec2 q = vec2(dot(axes.xy, d), dot(axes.zw, d));
float alpha = center.z * exp(-0.5 * dot(q, q));
float edge = float(soft_edge) * scale_bits.z;
alpha = alpha >= scale_bits.z ? min(center.w * (alpha - edge), ALPHA_MAX) : 0.0;
#ifdef SORTED
color_out = vec4(color.rgb * alpha, alpha);
#else
float weighted = alpha * color.w;
color_out = vec4(color.rgb * weighted, alpha);
weight_out = vec4(weighted, 0.0, 0.0, 0.0);
#endif
}
#endif
`,"splat.wgsl":`override STRIPS = false;
@group(0) @binding(4) var<storage, read> looks: array<StoredLook>;
@group(0) @binding(5) var<storage, read> order: array<u32>;
struct Listed {
vertices: u32,
instances: u32,
first: u32,
base: u32,
first_instance: u32,
count: u32,
}
@group(0) @binding(6) var<storage, read> listed: array<Listed, LEVELS>;
@group(0) @binding(7) var<uniform> level: vec4u;
struct Corner {
@builtin(position) position: vec4f,
@location(0) @interpolate(flat) axes: vec4f,
@location(1) @interpolate(flat) color: vec4f,
@location(2) @interpolate(flat) center: vec4f,
}
@vertex
fn corner_sorted(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
var out: Corner;
out.position = vec4f(2.0, 2.0, 2.0, 1.0);
let place = place_in(vertex, instance);
if (place >= view.count) { return out; }
let i = order[place];
let look = stored(looks[i]);
if (!(look.opacity > 0.0)) { return out; }
return corner_of(vertex, look, look.opacity, ellipse_of(shape_of(i)), view.size);
}
@vertex
fn corner_of_level(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
var out: Corner;
out.position = vec4f(2.0, 2.0, 2.0, 1.0);
let place = place_in(vertex, instance);
if (place >= listed[level.x].count) { return out; }
let i = order[place_of(level.x, place, arrayLength(&order) / 2u)];
let look = stored(looks[i]);
let ellipse = ellipse_of(shape_of(i));
if (level.x == 0u) { return corner_of(vertex, look, look.opacity, ellipse, view.size); }
let coarse = to_level(ellipse, level.x);
let area = f32(1u << (2u * level.x));
let factor = sqrt(ellipse.determinant / coarse.determinant) / area;
return corner_of(vertex, look, look.opacity * factor, coarse, level_size(level.x));
}
fn place_in(vertex: u32, instance: u32) -> u32 {
return select(instance * BATCH + vertex / 4u, instance, STRIPS);
}
fn corner_of(vertex: u32, look: Look, opacity: f32, ellipse: Ellipse, size: vec2f) -> Corner {
var out: Corner;
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
out.center = vec4f(ellipse.center, opacity, ellipse.compensation);
let side = (reach_of(opacity) * sizes + 0.02) *
(vec2f(vec2u(vertex & 1u, (vertex >> 1u) & 1u)) * 2.0 - 1.0);
let at = ellipse.center + side.x * way + side.y * across;
out.position = vec4f(at / size * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), 0.0, 1.0);
return out;
}
fn alpha_at(corner: Corner) -> f32 {
let d = corner.position.xy - corner.center.xy;
let q = vec2f(dot(corner.axes.xy, d), dot(corner.axes.zw, d));
let alpha = corner.center.z * exp(-0.5 * dot(q, q));
let edge = f32(view.soft_edge) * view.alpha_min;
return select(0.0, min(corner.center.w * (alpha - edge), ALPHA_MAX), alpha >= view.alpha_min);
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
int antialiased;
int soft_edge;
float level_sigma;
};
const float ALPHA_MAX = 0.99;
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
float compensation;
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
float blur = scale_bits.w;
e.variance = vec2(dot(px, px), dot(py, py)) + blur;
e.covariance = dot(px, py);
vec3 crossed = cross(px, py);
float before = dot(crossed, crossed);
e.determinant = before + blur * (e.variance.x + e.variance.y - blur);
e.compensation = antialiased == 1 ? sqrt(before / e.determinant) : 1.0;
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
blur: f32,
antialiased: u32,
soft_edge: u32,
level_sigma: f32,
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
const BATCH = 128u;
const LEVELS = 4u;
const WEIGHT_UNIT = 10.0;
struct Ellipse {
depth: f32,
center: vec2f,
variance: vec2f,
covariance: f32,
determinant: f32,
compensation: f32,
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
out.variance = vec2f(dot(px, px), dot(py, py)) + view.blur;
out.covariance = dot(px, py);
let crossed = cross(px, py);
let before = dot(crossed, crossed);
out.determinant = before + view.blur * (out.variance.x + out.variance.y - view.blur);
out.compensation = select(1.0, sqrt(before / out.determinant), view.antialiased == 1u);
return out;
}
fn level_of(ellipse: Ellipse, w: f32) -> u32 {
if (!(view.level_sigma > 0.0)) { return 0u; }
let skew = 0.5 * (ellipse.variance.x - ellipse.variance.y);
let cov = ellipse.covariance;
let larger = 0.5 * (ellipse.variance.x + ellipse.variance.y) + sqrt(skew * skew + cov * cov);
let needed = view.level_sigma * view.level_sigma * sqrt(max(w / WEIGHT_UNIT, 1.0));
let share = ellipse.determinant / (larger * needed);
return u32(share >= 4.0) + u32(share >= 16.0) + u32(share >= 64.0);
}
fn to_level(ellipse: Ellipse, level: u32) -> Ellipse {
var out = ellipse;
let side = f32(1u << level);
let spread = 0.25 * (side * side - 1.0);
out.center = ellipse.center / side + 1.0;
out.determinant = ellipse.determinant - spread * (ellipse.variance.x + ellipse.variance.y) + spread * spread;
out.determinant /= side * side * side * side;
out.variance = (ellipse.variance - spread) / (side * side);
out.covariance = ellipse.covariance / (side * side);
return out;
}
fn level_size(level: u32) -> vec2f {
var size = vec2u(view.size);
for (var l = 0u; l < level; l++) { size = (size - select(1u, 0u, l == 0u)) / 2u + 2u; }
return vec2f(size);
}
fn place_of(level: u32, k: u32, entries: u32) -> u32 {
let start = (level >> 1u) * entries;
return start + select(k, entries - 1u - k, (level & 1u) == 1u);
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
`};var ze=()=>({name:"",before:"",failed:"",state:"",share:NaN,sentence:""}),me=class{#e=[ze(),ze()];begin(e,t){let s=this.#e[e].name;this.#e[e]=t===void 0?ze():{...ze(),name:t,before:s,state:"loading"}}fail(e,t,s){let{name:n,before:r}=this.#e[e];this.note(e,{share:1,state:"failed",sentence:t,failed:this.names[e],name:s?r:n})}note(e,t){Object.assign(this.#e[e],t)}get state(){let e=this.#e.map(({state:s})=>s);return["failed","loading","loaded"].find(s=>e.includes(s))??""}get busy(){return this.#e.some(({state:e})=>e==="loading")}get share(){let e=this.#e.filter(({state:t})=>t).map(({share:t})=>t);return e.reduce((t,s)=>t+s,0)/e.length}get sentence(){let e=this.#e.every(({state:s})=>s),t=this.#e.map(({state:s,sentence:n,failed:r})=>s!=="failed"?"":e&&r&&!n.includes(r)?`${r}: ${n}`:n);return[...new Set(t.filter(Boolean))].join("; ")}get names(){return Mo(this.#e[0].name,this.#e[1].name)}};function Mo(o,e){let[t,s]=[o,e].map(n=>n.split("/").filter(Boolean));for(let n=1;n<=Math.max(t.length,s.length);n++){let[r,i]=[t,s].map(a=>a.slice(-n).map(Tt).join("/"));if(r!==i)return[r,i]}return[Tt(t[t.length-1]??""),Tt(s[s.length-1]??"")]}function Tt(o){try{return decodeURIComponent(o)}catch{return o}}function Ue(o){let e=o?.trim().toLowerCase()??"",t=/^([0-9a-f]{3}|[0-9a-f]{6})$/.test(e)?`#${e}`:e,s=/^#[0-9a-f]+$/.test(t)?t:Ro(t),n=s.length===4?s.replace(/[^#]/g,"$&$&"):s;if(!/^#[0-9a-f]{6}$/.test(n))return null;let r=i=>Number.parseInt(n.slice(i,i+2),16)/255;return[r(1),r(3),r(5)]}function vs(o){let e=t=>Math.round(255*Math.min(Math.max(t,0),1));return`#${o.map(t=>e(t).toString(16).padStart(2,"0")).join("")}`}function Ro(o){let e=o?document.createElement("canvas").getContext("2d"):null;if(!e)return"";let[t,s]=["#000000","#ffffff"].map(n=>(e.fillStyle=n,e.fillStyle=o,String(e.fillStyle)));return t===s?t:""}function ys(o,e,t){let s=f=>o.querySelector(`[name=${f}]`);s("background").value=vs(e.background);let n=s("scale"),r=e.scale??0;[...n.options].some(({value:f})=>Number(f)===r)||n.add(new Option(`${Math.round(100*r)} %`,String(r))),n.value=String(r),s("mode").value=e.mode,s("turning").checked=e.turning,s("stats").checked=t;let{renderer:i,adapter:a}=e.device,c=i?`Rendered with ${i}${a?` on ${a}`:""}`:"";o.querySelector(".device").textContent=c;let l=o.querySelector("[data-act=view]");l.hidden=e.views.length<2}function xs(o,e){let{name:t,value:s}=o;t==="background"?e.background=Ue(s):t==="scale"?e.scale=Number(s)||null:t==="mode"?e.mode=s==="fly"?"fly":"orbit":t==="turning"&&(e.turning=o.checked),e.redraw()}var Lo=new Map([["ArrowLeft",-.02],["ArrowDown",-.02],["ArrowRight",.02],["ArrowUp",.02],["PageDown",-.1],["PageUp",.1],["Home",-1],["End",1]]),Fe=class{share=.5;#e;#t;#o=["",""];constructor(e,t){this.#e=e,this.#t=t,e.onpointerdown=({pointerId:s})=>e.setPointerCapture(s),e.onpointermove=({pointerId:s,clientX:n})=>{if(!e.hasPointerCapture(s))return;let{left:r,width:i}=t.getBoundingClientRect();this.#n((n-r)/i)},e.onkeydown=s=>{let n=Lo.get(s.key);n===void 0||s.ctrlKey||s.metaKey||s.altKey||(s.preventDefault(),this.#n(this.share+n))}}show(e){this.#o=e,this.#e.querySelectorAll("span").forEach((t,s)=>t.textContent=e[s]),this.#e.setAttribute("aria-label",`${e[0]} on the left, ${e[1]} on the right`),this.#e.hidden=!1,this.#t.classList.add("drawn"),this.#n(this.share)}#n(e){this.share=Math.min(Math.max(e,0),1);let t=Math.round(100*this.share);this.#t.style.clipPath=`inset(0 0 0 ${100*this.share}%)`,this.#e.style.left=`${100*this.share}%`,this.#e.setAttribute("aria-valuenow",String(t));let[s,n]=this.#o;this.#e.setAttribute("aria-valuetext",`${t} % ${s}, ${100-t} % ${n}`)}};var Es=':host{display:block;position:relative;overflow:hidden;contain:strict;color-scheme:light dark;--paper: #16181dd9;--ink: #f3f4f6;--accent: #7db4ff;--wall: #0d0f12;--field: #ffffff1c;background:var(--wall);color:var(--ink);font:14px/1.4 system-ui,sans-serif;min-height:120px}@media(prefers-color-scheme:light){:host{--paper: #ffffffd9;--ink: #16181d;--accent: #0b62d6;--wall: #e8eaee;--field: #0000000f}}canvas{opacity:0;display:block;width:100%;height:100%;touch-action:none;cursor:grab;outline:none}canvas.drawn{opacity:1}canvas.polite{touch-action:pan-y}canvas:active{cursor:grabbing}canvas.reached{outline:2px solid var(--accent);outline-offset:-2px}.over{position:absolute;inset:0;pointer-events:none}.split{position:absolute;top:0;bottom:0;width:20px;margin-left:-10px;cursor:ew-resize;touch-action:none;outline:none}.split:before{content:"";position:absolute;inset:0 9px;background:#fff;box-shadow:0 0 3px #000a}.split:after{content:"\\2039\\2002\\203a";position:absolute;top:50%;left:-12px;width:44px;height:44px;margin-top:-22px;border-radius:50%;background:var(--paper);line-height:40px;text-align:center;font-size:20px;box-shadow:0 0 0 2px #fff,0 0 5px 2px #000a}.split:focus-visible:after{box-shadow:0 0 0 3px var(--accent)}.split span{position:absolute;top:12px;padding:2px 8px;border-radius:6px;background:var(--paper);max-width:40vw;overflow:hidden;text-overflow:ellipsis;white-space:nowrap}.split span:first-child{right:18px}.split span:last-child{left:18px}[hidden]{display:none!important}.bar{position:absolute;inset:0 0 auto;height:3px;background:transparent}.bar>div{height:100%;width:0;background:var(--accent);transition:width .15s}.bar.unknown>div{width:100%!important;animation:wait 1.2s ease-in-out infinite alternate}@keyframes wait{0%{opacity:.2}}@media(prefers-reduced-motion:reduce){.bar>div{transition:none;animation:none!important}}.panel{position:absolute;background:var(--paper);border-radius:10px;padding:12px 16px;backdrop-filter:blur(8px)}.panel:focus{outline:none}.message,.help,.report{inset:0;margin:auto;width:fit-content;height:fit-content;max-width:min(34em,92%);max-height:92%;box-sizing:border-box;overflow:auto}.message{overflow-wrap:anywhere}.stats{top:12px;left:12px;font-variant-numeric:tabular-nums;white-space:pre;pointer-events:none}.split:not([hidden])~.stats{top:52px}.said{right:12px;top:12px;pointer-events:none}.said:not(.seen){clip-path:inset(50%)}h2{font-size:16px;margin:0 0 8px}.help dl{display:grid;grid-template-columns:fit-content(45%) 1fr;gap:4px 16px;margin:0 0 12px}.help dt{font-weight:600}.help dd{margin:0}.buttons{position:absolute;right:12px;left:12px;bottom:calc(12px + env(safe-area-inset-bottom));display:flex;flex-wrap:wrap;justify-content:end;gap:8px;pointer-events:none}.settings{right:12px;bottom:calc(68px + env(safe-area-inset-bottom));width:min(26em,calc(100% - 24px));box-sizing:border-box;max-height:calc(100% - 80px);overflow:auto}@media(max-height:500px){.settings{bottom:12px;max-height:calc(100% - 24px);columns:2;width:min(40em,calc(100% - 24px))}}.settings p{display:flex;flex-wrap:wrap;align-items:center;gap:8px;margin:0 0 8px}.settings p>label{flex:1}.settings>label{display:flex;align-items:center;gap:8px;min-height:36px}.settings>small{display:block;margin:8px 0 12px;overflow-wrap:anywhere}button,select,[type=color]{font:inherit;color:inherit;background:var(--paper);border:0;border-radius:10px;min-width:44px;min-height:44px;padding:0 9px;cursor:pointer;pointer-events:auto}.panel :is(button,select,[type=color]){background:var(--field)}[type=color]{padding:6px}[type=checkbox]{width:20px;height:20px;margin:0;accent-color:var(--accent)}button:hover{color:var(--accent)}:is(button,select,input,textarea):focus-visible{outline:2px solid var(--accent)}textarea{font:12px/1.3 ui-monospace,monospace;color:inherit;background:transparent;max-width:100%}.drop{inset:12px;border:2px dashed var(--accent);display:grid;place-items:center}';var Oo=[["Drag","rotate the scene"],["Two fingers, right button or Shift","move sideways"],["Pinch or wheel","zoom in and out"],["Double tap","look at that point"],["Arrow keys","rotate"],["W A S D Q E","fly; hold Shift to fly faster"],["M","switch between orbiting and looking around"],["V","next training camera"],["R","back to the first view"],["F","full screen"],["P","save a picture"],["I","frame rate and size"],["O","settings"],["H","help"]],ks=`
<style>${Es}</style>
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
<dl>${Oo.map(([o,e])=>`<dt>${o}</dt><dd>${e}</dd>`).join("")}</dl>
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
<div class="panel drop" hidden>Drop a scene to open it, or two to compare them</div>`,Mt=new Map(Object.entries({r:"reset",m:"mode",f:"full",h:"help",i:"stats",o:"settings",p:"picture",v:"view"}));var _s=new Map([["KeyW",[0,0,1]],["KeyS",[0,0,-1]],["KeyA",[-1,0,0]],["KeyD",[1,0,0]],["KeyQ",[0,1,0]],["KeyE",[0,-1,0]]]),As=new Map([["ArrowLeft",[-1,0]],["ArrowRight",[1,0]],["ArrowUp",[0,-1]],["ArrowDown",[0,1]]]),Ie=class{#e;#t;#o=new AbortController;#n=new Map;#s=new Set;#r=!1;#i={x:0,y:0,time:0};constructor(e,t){this.#e=e,this.#t=t;let s=(n,r)=>e.addEventListener(n,r,{signal:this.#o.signal,passive:!1});s("pointerdown",n=>this.#c(n)),s("pointermove",n=>this.#l(n)),s("pointerup",n=>this.#f(n)),s("pointercancel",n=>this.#f(n)),s("wheel",n=>this.#g(n)),s("contextmenu",n=>n.preventDefault()),s("keydown",n=>this.#b(n,!0)),s("keyup",n=>this.#b(n,!1)),s("blur",()=>this.#s.clear())}get busy(){return this.#s.size>0}advance(e){if(!this.busy)return;let t=this.#t.pose(),s=.9*t.reach*e*(this.#r?4:1);for(let n of this.#s){let r=_s.get(n);r&&t.move(r[0]*s,r[1]*s,r[2]*s);let i=As.get(n);i&&this.#a(i[0]*1.5*e,i[1]*1.5*e)}this.#t.changed()}destroy(){this.#o.abort()}#a(e,t){let s=this.#t.pose();this.#t.mode()==="orbit"?s.orbit(e,t):s.look(e,t)}#c(e){this.#e.focus({preventScroll:!0}),this.#e.setPointerCapture(e.pointerId),this.#n.set(e.pointerId,{x:e.offsetX,y:e.offsetY});let{x:t,y:s,time:n}=this.#i,r=Math.hypot(e.offsetX-t,e.offsetY-s)<20,i=this.#n.size===1&&e.button===0;i&&r&&e.timeStamp-n<350&&this.#t.focus(e.offsetX,e.offsetY),this.#i={x:e.offsetX,y:e.offsetY,time:i?e.timeStamp:-1/0},this.#t.held(),e.preventDefault()}#l(e){let t=this.#n.get(e.pointerId);if(t===void 0)return;let s={x:e.offsetX,y:e.offsetY};Math.hypot(s.x-this.#i.x,s.y-this.#i.y)>6&&(this.#i.time=-1/0),this.#n.size===1?this.#u(s.x-t.x,s.y-t.y,e):this.#n.size===2&&this.#p(e.pointerId,s),this.#n.set(e.pointerId,s),this.#t.changed()}#f(e){this.#n.delete(e.pointerId)}#u(e,t,s){s.buttons&6||s.shiftKey||s.ctrlKey?this.#h(e,t):this.#a(e*.006,t*.006)}#p(e,t){let s=this.#n.get(e),n=[...this.#n].find(([a])=>a!==e)?.[1];if(s===void 0||n===void 0)return;let r=Math.hypot(s.x-n.x,s.y-n.y),i=Math.hypot(t.x-n.x,t.y-n.y);this.#t.mode()==="fly"?this.#t.pose().move(0,0,2*(i-r)*this.#m):r>0&&i>0&&this.#t.pose().dolly(r/i),this.#h((t.x-s.x)/2,(t.y-s.y)/2)}#h(e,t){this.#t.pose().move(-e*this.#m,-t*this.#m,0)}get#m(){let{target:e,eye:t}=this.#t.pose();return Math.hypot(...e.map((s,n)=>s-t[n]))/Math.max(this.#e.clientHeight,1)}#g(e){if(this.#e.classList.contains("polite")&&!e.ctrlKey&&!e.metaKey)return;e.preventDefault();let t=e.deltaMode===WheelEvent.DOM_DELTA_LINE?16:1,s=e.deltaY*t*(e.ctrlKey?8:1)*.0012,n=this.#t.pose();this.#t.mode()==="orbit"?n.dolly(Math.exp(s)):n.move(0,0,-s*n.reach),this.#t.changed()}#b(e,t){let{code:s}=e;if(this.#r=e.shiftKey,!t&&s.startsWith("Meta")&&this.#s.clear(),t&&(e.ctrlKey||e.metaKey||e.altKey)||!_s.has(s)&&!As.has(s))return;let n=t&&!this.#s.has(s);t?this.#s.add(s):this.#s.delete(s),n&&this.advance(.03),this.#t.changed(),e.preventDefault()}};function Rt(){let o=URL.createObjectURL(new Blob([`(${bundle})()`],{type:"text/javascript"}));return setTimeout(()=>URL.revokeObjectURL(o),6e4),new Worker(o)}function Ss(o,e){let t=globalThis.preloadedWorker;delete globalThis.preloadedWorker;let s;return t&&"url"in o&&t.url===o.url?(s=t.worker,t.messages.forEach(e)):(t?.worker.terminate(),s=Rt(),s.postMessage(o)),s.onmessage=e,s}async function Ts(){let o=globalThis.preloadedAdapter;return delete globalThis.preloadedAdapter,await o??navigator.gpu.requestAdapter({powerPreference:"high-performance"})}async function Ms(o){return g[o]}function Ne(o,[e,t,s]){let n=o.length/3,r=new Float32Array(n);for(let l=0;l<n;l++)r[l]=e*o[3*l]+t*o[3*l+1]+s*o[3*l+2];let i=new Uint32Array(r.buffer);for(let l=0;l<n;l++)i[l]=i[l]&2147483648?i[l]:~i[l]&2147483647;let a=Uint32Array.from({length:n},(l,f)=>f),c=new Uint32Array(n);for(let l of[0,16]){let f=new Uint32Array(65537);for(let h=0;h<n;h++)f[(i[h]>>>l&65535)+1]+=1;for(let h=0;h<65536;h++)f[h+1]+=f[h];for(let h=0;h<n;h++){let d=a[h];c[f[i[d]>>>l&65535]++]=d}[a,c]=[c,a]}return a}var zo=/[\x00-\x1f\x7f-\x9f\u2028\u2029\p{Cs}]/gu,x=class extends Error{name="SceneError";constructor(e){super(e.replace(zo,"\uFFFD"))}};function P(o){return new DataView(o.buffer,o.byteOffset,o.byteLength)}var K=class{#e;#t=0;#o=0;constructor(e){this.#e=e}get left(){return 8*(this.#e.length-this.#t)-this.#o}take(e){let t=this.#e,s=this.#t,n=t[s]|t[s+1]<<8|t[s+2]<<16|t[s+3]<<24,r=this.#o+e,i=n>>>this.#o&(1<<e)-1;return this.#t=s+(r>>>3),this.#o=r&7,i}atEnd(){return this.left<8&&this.#e[this.#t]>>>this.#o===0}};function re(o,e){let t=Math.ceil(e/8);if(o.length!==t)throw new x(`packed bits take ${o.length} bytes where ${t} belong`);if(e%8&&o[t-1]>>e%8)throw new x("packed bits end in bits that are not zero");return new K(o)}var Rs="0061736d01000000012a0460077f7f7f7f7f7f7d0060037f7f7f0060097f7f7f7f7f7f7f7f7f017f60097f7f7f7f7f7f7f7d7d00020f0103656e76066d656d6f727902000103060500010202030607017f014180080b073705056c61796572000005756e69747300010a70756c6c5f706c61696e00020f70756c6c5f636f6e7465787475616c0003047061636b00040abc21059c0404017f017b047f0b7b024020054101480d00200120054102746a21072006fd13210820044102742209410148210a0340200020094102746a210b4100210c03402001fd09000c210d2001fd090008210e2001fd090004210f2001fd090000211002400240200a450d00200d2111200e2112200f2113201021140c010b2002200c4102746a2104200d2111200e2112200f2113201021142000210503402004fd00001022152005fd0900002216fde6012010fde40121102004fd00000022172016fde6012014fde401211420152005fd0900042216fde601200ffde401210f20172016fde6012013fde401211320152005fd0900082216fde601200efde401210e20172016fde6012012fde401211220152005fd09000c2216fde601200dfde401210d20172016fde6012011fde401211120044180046a2104200541106a2205200b490d000b0b2003200c4102746a2205201120082011fde601fde901fd0b00800c2005201220082012fde601fde901fd0b0080082005201320082013fde601fde901fd0b0080042005201020082010fde601fde901fd0b00102005201420082014fde601fde901fd0b0000200541900c6a200d2008200dfde601fde901fd0b000020054190086a200e2008200efde601fde901fd0b000020054190046a200f2008200ffde601fde901fd0b0000200c41f800492105200c41086a210c20050d000b20034180106a2103200b2100200141106a22012007490d000b0b0bd50104027f017b027f017b200020024109746a2103410021040340fd0c0000000000000000000000000000000021052000200441027422066a22022107034020052007fd00000022082008fde601fde401210520074180046a22072003490d000b200120066a2107fd0c0000803f0000803f0000803f0000803f2005fde301fd0cccbc8c2bccbc8c2bccbc8c2bccbc8c2bfde901fde70121050340200720052002fd000000fde601fd0b000020074180046a210720024180046a22022003490d000b200441fc00492102200441046a210420020d000b0bd30101087f41002109034002402006200820092007491b220a4101480d002000200a4103746a210b2000210a0340024020022001200a280200220c41ffff0071220d4101746a2f0100220e4102746a280200220f0d0041000f0b20042f01002110200a28020420094101746a200e3b0102200a20104100200d200f410f766b200f41ffff0171200c410e766c6a220c4180800449220f1b200c200f41047474723602002004200f4101746a2104200a41086a220a200b490d000b0b0240200420054b0d00200941016a220920074d0d010b0b20040bf101010a7f410021094100210a0340024020062008200a2007491b220b4101480d002000200b4103746a210c2000210b0340024020022009200b280204200a4101746a220d2f010071220e20036c2001200e410f74200b280200220f41ffff00712210410174726a2f010022116a4102746a280200220e0d0041000f0b20042f01002112200d20113b0102200b201241002010200e410f766b200e41ffff0171200f410e766c6a220d4180800449220e1b200d200e41047474723602002004200e4101746a2104200b41086a220b200c490d000b0b0240200420054b0d00417f2109200a41016a220a20074d0d010b0b20040bfc1707067f027b037f0c7b037f0e7b017f2005417e7121092005410171210a200641036c210b2006410174210c20044180206a210d200541017441026a210e2008fd13210f2007fd132110410021112006410274221241027421130340fd0c020000000200000002000000020000002214fd0c010000000100000001000000010000002215fd0c0000000000000000000000000000000022162001fd000080042217fde0012001fd0000002218fde001fd442219fd522001fd00008008221afde001201720182019fd522217fde001fd442218fd522119fd0c03000000030000000300000003000000211b2001fd0000800c221c201a20172018fd522217201cfde0012017fde001fd44221dfd52221efd0cffffff7fffffff7fffffff7fffffff7f221cfd4e2016fd37211ffd0c0000000000000000000000000000000022172118410121202016211a4100212102400240024020050e020201000b0340201720032020410a746a2222fd000000fde001fde90120224180086afd000000fde001fde9012117201820224180046afd000000fde001fde901202241800c6afd000000fde001fde9012118202041026a2120202141026a22212009470d000b0b0240200a450d00201720032020410a746a2222fd000000fde001fde9012117201820224180046afd000000fde001fde90121180b2018fd0cffff0f00ffff0f00ffff0f00ffff0f00221afdae014114fdad0121162017201afdae014114fdad01211a0b201b2019201dfd52211d200d2003fd000080042217fd0c000000800000008000000080000000802223fd4e2003fd00000022184110fdad01fd0c008000000080000000800000008000002224fd4efd502018201cfd4e2219fd0c0000804b0000804b0000804b0000804b2225fde601fd6afdf80120192018410dfdad012015fd4efdae01fd0cff0f00c8ff0f00c8ff0f00c8ff0f00c82226fdae01410dfdad01fd0cff7b0000ff7b0000ff7b0000ff7b00002227fdb7012019fd0c000080380000803800008038000080382228fd3afd52fd502017201cfd4e22182025fde601fd6afdf80120182017410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120182028fd3afd524110fdab01fd502217fd0c0000ffff0000ffff0000ffff0000fffffd4efd0ce2f00000e2f00000e2f00000e2f00000fd502017201ffd522217fd5a00000041022120200d20064102746a2017fd5a000001200d200c4102746a2017fd5a000002200d200b4102746a2017fd5a0000032016fd0c78030000780300007803000078030000221ffdb901fd0c770400007704000077040000770400002229fdb601fd0c88fcffff88fcffff88fcffff88fcffff222afdae01212bfd0c00008037000080370000803700008037212cfd0c0000fe420000fe420000fe420000fe422117201a201ffdb9012029fdb601202afdae01212d0240200e41024d0d002017202b4114fdab01202cfdae01fde70121192017202d4114fdab01202cfdae01fde701211a200d21220340202241046a22222019200320204109742221418004726afd000000fde601fd0c0000fec20000fec20000fec20000fec22218fde9012017fde801fd0c002000440020004400200044002000442216fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4e201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf801fd0cff000000ff000000ff000000ff000000fd4e2019200320214180086a2221418004726afd000000fde6012018fde9012017fde8012016fde401fdf8014118fdab01201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4efd50fd50fd502218fd5a000000202220126a2018fd5a0000012022200c4102746a2018fd5a0000022022200b4102746a2018fd5a000003202041046a2220200e490d000b0b200441346a202d4110fdab01202b4118fdab01fd502218fd5a000003200441246a2018fd5a000002200441146a2018fd5a000001200441046a2018fd5a000000200441386a200f2000fd00008004fdfa012010fde501fde601fd0c000000000000000000000000000000002218fde901fd0c0000803f0000803f0000803f0000803f2216fde801fd0c00e0ff4400e0ff4400e0ff4400e0ff44221afde601fd0c0000003f0000003f0000003f0000003f2219fde401fdf801410bfdab01200f2000fd00008008fdfa012010fde501fde6012018fde9012016fde801fd0c00c07f4400c07f4400c07f4400c07f44fde6012019fde401fdf8014116fdab01fd50200f2000fd000000fdfa012010fde501fde6012018fde9012016fde801201afde6012019fde401fdf801fd502216fd5a000003200441286a2016fd5a000002200441186a2016fd5a000001200441086a2016fd5a0000002004413c6afd0c71aa34c471aa34c471aa34c471aa34c4fd0c71aa344471aa344471aa344471aa3444201e2018fd43fd5222162001fd00008004221a2001fd000000201d2015fd39fd52fde601fd0c001080440010804400108044001080442219fde401fdf801410afdab01fd0c00fc0f0000fc0f0000fc0f0000fc0f00fd4e201d4114fdab01fd5020162001fd00008008222b201a201d2014fd39fd52fde6012019fde401fdf801fd0cff030000ff030000ff030000ff030000221afd4efd50410afdab0120162001fd0000800c202b201d201bfd39fd52fde6012019fde401fdf801201afd4efd502216fd5a0000032004412c6a2016fd5a0000022004411c6a2016fd5a0000012004410c6a2016fd5a0000002002fd0000802c211d2002fd00008028211b2002fd00008024212b2002fd00008020212d2002fd0000801c21142002fd00008018211e2002fd00008014212e2002fd00008010212f2002fd0000800c2130200441b0106a2002fd0000800422162023fd4e2002fd00000022194110fdad012024fd4efd502019201cfd4e221a2025fde601fd6afdf801201a2019410dfdad012015fd4efdae012026fdae01410dfdad012027fdb701201a2028fd3afd52fd502016201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd524110fdab01fd502216fd5a000003200441a0106a2016fd5a00000220044190106a2016fd5a00000120044180106a2016fd5a000000200441b4106a2002fd000080082216201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd522030fde0012018fde901202ffde001fde901202efde001fde901201efde001fde9012014fde001fde901202dfde001fde901202bfde001fde901201bfde001fde901201dfde001fde901fd0cffff0f00ffff0f00ffff0f00ffff0f00fdae014114fdad01201ffdb9012029fdb601202afdae0122184110fdab0120164110fdad012024fd4efd50fd502002fd0000800c201720184114fdab01202cfdae01fde7012218fde601fd0c0000fec20000fec20000fec20000fec22216fde9012017fde801fd0c002000440020004400200044002000442219fde401fdf8014118fdab01fd50221afd5a000003200441a4106a201afd5a00000220044194106a201afd5a00000120044184106a201afd5a00000020044188106a213141002120410121210340203120204102746a222241306a20182020410b7420026a22204180186afd000000fde6012016fde9012017fde8012019fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4e2018202041801c6afd000000fde6012016fde9012017fde8012019fde401fdf8014118fdab01fd50201820204180146afd000000fde6012016fde9012017fde8012019fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4efd50201820204180106afd000000fde6012016fde9012017fde8012019fde401fdf801fd0cff000000ff000000ff000000ff000000fd4efd50221afd5a000003202241206a201afd5a000002202241106a201afd5a0000012022201afd5a00000020214101712122410021214101212020220d000b200441c0006a2104200341106a2103200241106a2102200141106a2101200041106a2100200d20136a210d201141fc00492122201141046a211120220d000b0b";var ge,Ls=new WeakMap;function Ce(o){return typeof WebAssembly=="object"?new WebAssembly.Memory({initial:Math.ceil(o/2**16)}):null}function ie(o){if(o===null)return null;if(ge===void 0)try{let t=Rs.match(/../g);ge=new WebAssembly.Module(Uint8Array.from(t,s=>parseInt(s,16)))}catch{ge=null}if(ge===null)return null;let e=Ls.get(o);if(!e){let{exports:t}=new WebAssembly.Instance(ge,{env:{memory:o}});e=t,Ls.set(o,e)}return e}var Lt=2048,Y;function Os({contexts:o,alphabet:e,symbols:t,spans:s},n,r,i,a){Y===void 0&&(Y=Ce(1));let c=ie(Y);if(Y===null||c===null)return;let l=n.length,f=Lt+2*t.length,h=f+4*s.length,d=h+i.length,p=d+2*l+2,u=Math.ceil((p+2*a+2)/2**16)-Y.buffer.byteLength/2**16;u>0&&Y.grow(u);let{buffer:w}=Y,m=new Uint32Array(w,0,2*l);n.forEach((k,y)=>m.set([k,p-2+2*r[y]],2*y)),new Uint16Array(w,Lt,t.length).set(t),new Uint32Array(w,f,s.length).set(s),new Uint8Array(w,h,i.length).set(i);let E=(o>1?c.pull_contextual:c.pull_plain)(0,Lt,f,e,h,d,l,Math.floor(a/l),a%l);return{decoded:new Uint16Array(w,p,a).slice(),left:E?(d-E)/2:-1/0,states:m.filter((k,y)=>y%2===0)}}var De=14,ve=1<<De,zs=65536,Uo=64,Fo=256,Io=2048,Be=12,Us=-1/0;function Q(o,e,t,s=!1){if(o.length<Be)throw new x("a rANS stream is too short to hold its header");let n=P(o),r=n.getUint16(0,!0),i=n.getUint16(2,!0),a=n.getUint32(4,!0),c=n.getUint32(8,!0);if(r!==t)throw new x(`a rANS stream of ${r} symbols stands where ${t} belong`);if(i!==1&&i!==t||i>Uo)throw new x(`a rANS stream has ${i} contexts`);let l=No(e);if(o.length!==Be+a+4*l+2*c)throw new x("a rANS stream is longer or shorter than its header says");let f=Be+a,h=Bo(o.subarray(Be,f),i,t),d=new Uint32Array(l).map((E,k)=>n.getUint32(f+4*k,!0));if(d.some(E=>E<zs))throw new x("a rANS stream starts in an impossible state");let p=Math.floor(e/l),u=e%l,w=d.map((E,k)=>k*p+Math.min(k,u)),m=[h,d,w,o.subarray(f+4*l),e],b=(s?void 0:Os(...m))??Co(...m);if(b.left===Us)throw new x("a rANS stream leads to a context that is not used: it is damaged");if(b.left<0)throw new x("a rANS stream ends early: the file is damaged");if(b.left>0||b.states.some(E=>E!==zs))throw new x("a rANS stream does not end where it should: the file is damaged");return b.decoded}function No(o){let e=Math.max(1,Math.floor(o/Io));return Math.min(Fo,1<<31-Math.clz32(e))}function Co({contexts:o,alphabet:e,symbols:t,spans:s},n,r,i,a){let c=n.length,l=Math.floor(a/c),f=a%c,h=new Uint16Array(a),d=i.length/2,p=new Uint16Array(d+1);new Uint8Array(p.buffer).set(i);let u=0;for(let w=0;w<=l;w++){let m=w<l?c:f,b=o>1&&w>0;for(let E=0;E<m;E++){let k=r[E]+w,y=b?h[k-1]:0,_=n[E],T=_&ve-1,z=t[y<<De|T],ne=s[y*e+z];if(ne===0)return{decoded:h,left:Us,states:n};let oe=Math.imul(ne&32767,_>>>De)+T-(ne>>>15)|0,X=(oe>>>16)-1>>>31;n[E]=oe<<16*X|p[u]&-X,u+=X,h[k]=z}}return{decoded:h,left:d-u,states:n}}function Bo(o,e,t){let s=new K(o),n=new Uint16Array(e*ve),r=new Uint32Array(e*t);for(let i=0;i<e;i++){if(!be(s,1))continue;let a=Do(s,t),c=i*ve;for(let l=0;l<t;l++){let f=a[l];f!==0&&(r[i*t+l]=c%ve<<15|f,n.fill(l,c,c+f),c+=f)}}if(!s.atEnd())throw new x("a rANS stream's frequency tables are longer than they should be");return{contexts:e,alphabet:t,symbols:n,spans:r}}function Do(o,e){let t=new Uint16Array(e),s=[];for(let a=0;a<e;a++)be(o,1)&&s.push(a);let n=be(o,4),r=s.pop(),i=ve;for(let a of s){let c=n;for(;!be(o,1);)c++;if(c>De)throw new x("a rANS stream's frequency table holds a number out of range");t[a]=be(o,c)+(1<<c)-(1<<n)+1,i-=t[a]}if(r===void 0||i<1)throw new x("a rANS stream's frequencies do not sum to 16384");return t[r]=i,t}function be(o,e){if(e>o.left)throw new x("a rANS stream's frequency tables end early");return o.take(e)}var Po=Float64Array.from({length:31},(o,e)=>2**(Math.max(e,1)-25)),Is=new Float32Array(1),Fs=new Uint32Array(Is.buffer);function Ot(o){return(o&31744)===31744}function U(o){let e=o>>10&31,t=(o&1023)+(e>0?1024:0);return(o&32768?-t:t)*Po[e]}function q(o){Is[0]=o;let e=Fs[0]>>>16&32768,t=Fs[0]&2147483647;if(t<947912704){let s=Math.abs(o)*16777216,n=Math.round(s);return e|(n-s===.5&&n%2?n-1:n)}return e|Math.min(t+4095+(t>>>13&1)-939524096>>>13,31743)}function zt(o,e){let t=$o(o,e);if(t.some(Ot))throw new x(`the stream '${o.name}' of the .mgs file has numbers that are not finite`);return Float32Array.from(t,U)}function $o({name:o,codec:e,data:t},s){let n=new x(`the stream '${o}' of the .mgs file has a wrong length`);if(e==="raw"){if(t.length!==2*s)throw n;return Uint16Array.from({length:s},(l,f)=>t[2*f]|t[2*f+1]<<8)}if(t.length<4)throw n;let r=4+P(t).getUint32(0,!0);if(r>t.length||e==="halves"&&t.length!==r+s)throw n;let i=Q(t.subarray(4,r),s,256),a=t.subarray(r),c=e==="planes"?Q(a,s,256):a;return i.map((l,f)=>l<<8|c[f])}var Go=49,J=24,Pe=Uint32Array.from({length:4096},(o,e)=>{let t=0;for(let s=0;s<12;s++)t|=(e>>>s&1)<<10*(s%3)+Math.floor(s/3);return t});function Ns(o,e){let t=o.length<4?1/0:4+P(o).getUint32(0,!0);if(t>o.length)throw new x("the stream of positions is too short to hold what its header says");let s=Q(o.subarray(4,t),e,Go),n=0;for(let l=0;l<e;l++)n+=Math.max(s[l]-1,0);let r=re(o.subarray(t),n),i=new Uint16Array(3*e),a=0,c=0;for(let l=0;l<e;l++){let f=s[l]-1;if(f>=J?(a+=r.take(J),c+=(1<<f-J)+r.take(f-J)):f>=0&&(a+=(1<<f)+r.take(f)),c+=a>>>J,a&=(1<<J)-1,c>>>J)throw new x("the stream of positions leaves its 48-bit grid");let h=Pe[a&4095]|Pe[a>>>12]<<4,d=Pe[c&4095]|Pe[c>>>12]<<4;for(let p=0,u=0;p<3;p++,u+=10){let w=h>>>u&255|(d>>>u&255)<<8,m=w&32768?w&32767:w^65535;if(Ot(m))throw new x("the stream of positions holds numbers that are not finite");i[3*l+p]=m}}return i}function Cs(o,e){let t=3*Math.ceil(o.length/3/e);if(t<=3)return o;let s=new Uint16Array(3*Math.ceil(o.length/t));for(let n=0,r=0;n<o.length;n+=t,r+=3)s.set(o.subarray(n,n+3),r);return s}function Ut(o,{center:e,radius:t,exponent:s}){let n=new Float32Array(o.length),r=t*2**s;for(let i=0;i<o.length;i++)n[i]=e[i%3]+Math.fround(r*U(o[i]));return n}function $e(o){return"stored"in o?Ut(o.stored,o.grid):o}var qo={from:64,to:65536,times:4},Ho={from:32,to:1024,times:2},Bs=128,Ps="mobilegs variant 1";function $s(o,e){let t=null;try{t=e?.getItem(`${Ps} ${o.describe()}`)??null}catch{}return o.variants.find(s=>Ws(s)===t)??null}async function Gs(o,e){let t={floats:!1,strips:!1},s={...t};if(await Ds(o,t,{...t,strips:!0},qo,Wo)&&(s.strips=!0),o.variants.some(({floats:n})=>n)){let n={...s,floats:!0};await Ds(o,s,n,Ho,Vo)&&(s.floats=!0)}try{e?.setItem(`${Ps} ${o.describe()}`,Ws(s))}catch{}return s}async function qs(o){o.setScene({...Ft(1,1,()=>[0,0,1]),packing:{center:[0,0,0],unit:1,leastScaleBits:0,scaleBitsSpan:0},shapes:Uint32Array.of(0,15360,0,0),colors:new Uint32Array(4),shSize:4,lobes:new Uint32Array(5),lobeSize:9}),await o.drawUnseen(It(1))}function Hs(o){o.setDots({means:Float32Array.of(0,0,1),color:[0,0,0],side:1,background:[0,0,0]}),o.drawDots(It(1)),o.setDots(null)}var Ws=({floats:o,strips:e})=>`${o} ${e}`;async function Ds(o,e,t,{from:s,to:n,times:r},i){let a=0;for(let c=s;;c*=r){let{scene:l,side:f}=i(c);o.setScene(l);let h=[1/0,1/0];for(let p=0;p<=3;p++)for(let[u,w]of[e,t].entries()){o.variant=w;let m=performance.now();await o.drawUnseen(It(f)),p>0&&(h[u]=Math.min(h[u],performance.now()-m))}let d=Math.max(...h);if(c===s&&(a=d),d>Math.max(4,3*a)||c>=n)return h[1]<.85*h[0]}}function Wo(o){let e=Math.ceil(Math.sqrt(o)),t=n=>2*(n+.5)/e-1;return{scene:Ft(o,.001,n=>[t(n%e),t(Math.floor(n/e)),1]),side:256}}function Vo(o){return{scene:Ft(Bs,1,e=>[0,0,1+e/Bs]),side:o}}function Ft(o,e,t){let s=new Float32Array(12*o);for(let n=0;n<o;n++){let[r,i,a]=t(n);s.set([e,0,0,r,0,e,0,i,0,0,e,a],12*n)}return{count:o,packing:null,shapes:s,colors:new Float32Array(3*o),shSize:1,lobes:new Float32Array(2*o).fill(1),lobeSize:1,sorted:!1,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},background:[0,0,0]}}function It(o){return{viewmat:[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],fx:o/2,fy:o/2,cx:o/2,cy:o/2,width:o,height:o,near:.1}}function Vs(o){let[e,t,s]=[1,2,3].map(c=>o[`hidden${c}.weight`]),n=["opacity","phi"].map(c=>({weights:jo(o[`${c}.weight`],s,128),offset:o[`${c}.weight`].reduce((l,f,h)=>l+f*o["hidden3.bias"][h],o[`${c}.bias`][0])})),r=new Float32Array(16*2497),i=0,a=(c,l,f)=>{for(let h=c;h<c+4;h++)for(let d=l;d<l+4;d++)r[i++]=f(h,d)};for(let c=0;c<256;c+=4)for(let l=0;l<24;l+=4)a(c,l,(f,h)=>h<22?e[22*f+h]:h===22?o["hidden1.bias"][f]:0);for(let c=0;c<128;c+=4)a(c,0,(l,f)=>f===0?o["hidden2.bias"][l]:0);for(let c=0;c<256;c+=4)for(let l=0;l<128;l+=4)a(l,c,(f,h)=>t[256*f+h]);for(let c=0;c<128;c+=4)a(0,c,(l,f)=>n[l]?.weights[f]??0);return a(0,0,(c,l)=>l===0?n[c]?.offset??0:0),r}function jo(o,e,t){return Array.from({length:t},(s,n)=>o.reduce((r,i,a)=>r+i*e[t*a+n],0))}function ce({packing:o,shSize:e,lobeSize:t,network:s}){return o?{shapes:4,colors:4,lobes:s?10:t+2>>1}:{shapes:12,colors:3*e,lobes:2*t}}function js(o){return U(o&65535)}var le=class{#e;#t;#o;constructor(e,{sh:t,scales:s,quats:n},r){this.#e=e,this.#t=[[t,e.part(r,0,12)],[s,e.part(r,12,3)]],this.#o=[n,e.part(r,15,4)]}write(){let[e,t]=this.#o;for(let[s,n]of this.#t)this.#e.units(s,n);t.numbers.set(e.numbers)}};var Xo=[["context1",64,96],["context2",13,64],["static1",64,16],["static2",3,64],["view1",64,16],["view2",9,64]],Ko=[["both1",128,6],["static2",3,64],["view2",9,64]],Nt={linear:"color-matrices",networks:"appearance-decoder",latent_networks:"color-networks"};function Xs({colors:o,scalars:e}){let t=e.get("appearance")?.columns.length??6,s={linear:[["static2",3,3],["view2",9,t-3]],networks:Xo,latent_networks:Ko};return[Nt[o],s[o]]}var Ks=[["hidden1.weight",256,22],["hidden1.bias",1,256],["hidden2.weight",128,256],["hidden2.bias",1,128],["hidden3.weight",64,128],["hidden3.bias",1,64],["phi.weight",1,64],["phi.bias",1,1],["opacity.weight",1,64],["opacity.bias",1,1]];function Ys({degree:o,latents:e,hidden:t}){let s=2*(o+1)**2,n=[19+e,...t],r=[["bias",1,s],["basis",e,s]];return t.length===0||([...t,s].forEach((i,a)=>r.push([`weights.${a}`,i,n[a]])),t.forEach((i,a)=>r.push([`offsets.${a}`,1,i]))),r}function Qs(o){return o.reduce((e,[,t,s])=>e+t*s,0)}function Js(o,e){let t=0;return Object.fromEntries(e.map(([s,n,r])=>[s,o.subarray(t,t+=n*r)]))}var We=Object.freeze({blur:.3,antialiased:!1,soft_edge:!1}),Yo=2**26,Qo=8,Bt=4096,Ct=2**14,Jo=1e-5,Zo=1e3,er=80,tr=8,Dt=32,sr=256,nr=3,or=64,Zs=2**16,en=64,tn=4096,rr=1e-20,Ge=1e20,ir=/[\x00-\x1f\x7f-\x9f\p{Cs}]/u,sn=["mobile_gs","no_depth","no_scale","sort_free_gs"],ar=[["scale",[[3,1],[1,3]]],["rotation",[[2,2],[1,4]]],["appearance",[[3,2]]],["opacity",[[1,1]]]],nn=[6,12],cr=[["scale",3],["rotation",3],["appearance",nn[0]],["opacity",1]];function on(o,e){let{colors:t="networks"}=o;for(let[h,d,...p]of[["mode",o.mode,"nvq","sq"],["blend",o.blend,"sortfree","sorted"],["sh_degree",o.sh_degree,1],["colors",t,"linear","networks","latent_networks"]])if(!p.includes(d))throw new x(`the .mgs file has ${h} '${an(d)}', which this program does not know: a newer one may`);let s=hr(o),n=o.network;if(typeof n!="boolean")throw A("network");if(n&&s!==null)throw new x("the .mgs file has lobes and a view network: it can have one of them");let r=o.mode==="sq",i=R(o,"count",1,Yo),a={count:i,lodSizes:fr(o,i),cuts:r?new Map:dr(N(o,"codebooks"),s),scalars:r?ur(N(o,"scalars"),s,t==="linear"):new Map,grid:pr(N(o,"positions")),colors:t,sorted:o.blend==="sorted",lobes:s,network:n,weighting:wr(N(o,"weighting")),footprint:mr(N(o,"footprint")),background:He(o,"background",3),near:H(o,"near"),views:ye(o,"views").map(gr),meta:br(N(o,"meta"))},c=lr(a),f=o.streams.filter(h=>c.has(h.name)).reduce((h,d)=>h+d.bytes,0);if(i>f)throw new x(`the .mgs file claims ${i} Gaussians in ${f} of its ${e} bytes: it is damaged`);if(a.footprint.soft_edge&&a.sorted)throw A("footprint.soft_edge");if(a.background.some(h=>h<0||h>1))throw A("background");if(!(a.near>0&&a.near<=Ge))throw A("near");if(a.views.length>or)throw A("views");return a}function qe(o,e){return typeof o!="string"||o.length>2*e||ir.test(o)?!1:o.length<=e||[...o].length<=e}function lr({colors:o,lobes:e,network:t,cuts:s,scalars:n,lodSizes:r}){let i=["positions"];for(let[c,{count:l}]of s)for(let f=0;f<l;f++)i.push(`${c}.${f}`);for(let[c,{columns:l}]of n)i.push(...l.map((f,h)=>`${c}.${h}`));n.size&&i.push("rotation-finer");let a=r.flatMap((c,l)=>i.map(f=>l?`${f}@${l}`:f));return a.push(Nt[o]),e&&a.push("lobe-decoder"),t&&a.push("view-network"),s.size&&a.push("codebooks"),new Set(a)}function fr(o,e){let t=ye(o,"layers").map(n=>R({layers:n},"layers",1,e)),s=t.reduce((n,r)=>n+r,0);if(t.length>Qo||s!==e)throw A("layers");return t}function hr(o){if(o.lobes===null)return null;let e=N(o,"lobes"),t=ye(e,"hidden");if(t.length>nr)throw A("lobes.hidden");return{degree:R(e,"degree",0,3),latents:R(e,"latents",0,Dt),hidden:t.map(s=>R({hidden:s},"hidden",1,sr))}}function dr(o,e){let t=new Map;for(let[n,r]of ar){if(n==="opacity"&&!Object.hasOwn(o,n)&&e!==null)continue;let i=N(o,n),a=r.find(([c,l])=>i.count===c&&i.length===l);if(!a)throw A(`codebooks.${n}`);t.set(n,{count:a[0],length:a[1],size:R(i,"size",1,Bt)})}let s=0;if(Object.hasOwn(o,"lobes")){let n=N(o,"lobes"),r=R(n,"count",1,Dt),i=R(n,"length",1,Dt);t.set("lobes",{count:r,length:i,size:R(n,"size",1,Bt)}),s=r*i}if(s!==(e===null?0:e.latents))throw A("codebooks.lobes");return t}function ur(o,e,t){let s=new Map,n=e?.latents??0;if(Object.hasOwn(o,"lobes")&&!n)throw A("scalars.lobes");for(let[r,i]of[...cr,["lobes",n]]){if(r==="opacity"&&!Object.hasOwn(o,r)&&e!==null||i===0)continue;let c=N(o,r),[l,f,h]=["least","size","middle"].map(b=>ye(c,b)),[d,p]=r==="appearance"&&t?nn:[i,i],u=l.length;if(u<d||u>p||f.length!==u||h.length!==u)throw A(`scalars.${r}`);let w=Math.fround(H(c,"step"));if(!(w>=Jo&&w<=Zo))throw A(`scalars.${r}.step`);let m=l.map((b,E)=>{let k={least:l[E],size:f[E],middle:h[E]},y=R(k,"least",-Ct,Ct),_=R(k,"size",1,Bt),T=R({size:y+_-1},"size",y,Ct);if(r==="scale"&&T*w>er)throw A("scalars.scale");let z=Math.max(-y,T)+.5;if(r==="rotation"&&z*w>tr)throw A("scalars.rotation");return{least:y,size:_,middle:R(k,"middle",y,T)}});s.set(r,{step:w,columns:m})}return s}function pr(o){let e=He(o,"center",3),t=Math.fround(H(o,"radius"));if(e.some(s=>Math.abs(s)>Math.fround(Ge)))throw A("positions.center");if(t<rr||t>Ge)throw A("positions.radius");return{center:e,radius:t,exponent:R(o,"exponent",0,14)}}function wr(o){let{name:e}=o;if(typeof e!="string")throw A("name");if(!sn.includes(e))throw new x(`the .mgs file has the weighting '${an(e)}': known are ${sn.join(", ")}`);let t={name:e,exponent_max:H(o,"exponent_max"),sigma:H(o,"sigma"),background_weight:H(o,"background_weight"),alpha_min:o.alpha_min===void 0?1/255:H(o,"alpha_min")};if(!(t.exponent_max>0&&t.exponent_max<=80))throw A("exponent_max");if(!(t.sigma>0&&t.sigma<=Ge))throw A("sigma");if(t.background_weight<0)throw A("background_weight");if(!(t.alpha_min>=1e-4&&t.alpha_min<=.1))throw A("alpha_min");return t}function mr(o){let{antialiased:e,soft_edge:t}=o;if(typeof e!="boolean")throw A("footprint.antialiased");if(typeof t!="boolean")throw A("footprint.soft_edge");let s=H(o,"blur");if(!(s>0&&s<=4))throw A("footprint.blur");return{blur:s,antialiased:e,soft_edge:t}}function gr(o){let e=N({views:o},"views"),t=He(e,"viewmat",16),s=He(e,"K",9);if(![0,0,0,1].every((i,a)=>t[12+a]===i)||![0,0,1].every((i,a)=>s[6+a]===i)||s[0]<=0||s[4]<=0)throw new x("a view's matrices in the .mgs file are not those of a camera");let r=R(e,"width",1,Zs);return{viewmat:t,K:s,width:r,height:R(e,"height",1,Zs)}}function br(o){let e=Object.entries(o);if(e.length>en)throw new x(`the .mgs file has ${e.length} notes: ${en} are allowed`);for(let[t,s]of e){let n=s===null||typeof s=="boolean"||qe(s,tn),r=typeof s=="number"&&Math.abs(s)<=2**53;if(!(n||r)||!qe(t,tn))throw new x(`the note '${t.slice(0,40)}' is not a short text or a number`)}return o}function N(o,e){let t=o[e];if(typeof t!="object"||t===null||Array.isArray(t))throw A(e);return t}function ye(o,e){let t=o[e];if(!Array.isArray(t))throw A(e);return t}function R(o,e,t,s){let n=H(o,e);if(!Number.isInteger(n)||n<t||n>s)throw A(e);return n}function H(o,e){return rn(o[e],e)}function He(o,e,t){let s=ye(o,e);if(s.length!==t)throw A(e);return Float32Array.from(s,n=>rn(n,e))}function rn(o,e){if(typeof o!="number"||!(Math.abs(o)<=3e38))throw A(e);return o}function an(o){return typeof o!="object"||o===null?String(o).slice(0,40):Array.isArray(o)?"a list":"an object"}function A(o){return new x(`the field '${o}' in the header of the .mgs file is missing or invalid`)}var xe=208,Ve=2**-6,cn=.3;function je(o,{viewmat:e,fx:t,fy:s,cx:n,cy:r,width:i,height:a,near:c},l,f=0){let{background:h,weighting:d,packing:p,footprint:u=We}=o,w=cn*.5*i/t,m=cn*.5*a/s,b=[0,1,2].map(y=>-(e[y]*e[3]+e[4+y]*e[7]+e[8+y]*e[11])),E=new Float32Array(xe/4);E.set([...Array.from(e).slice(0,12),...b,c,t,s,n,r,-n/t-w,(i-n)/t+w,-r/s-m,(a-r)/s+m,...h,d.exponentMax,i,a,d.sigma,d.backgroundWeight,l]);let k=[o.count,o.shSize,o.lobeSize,d.index];if(new Int32Array(E.buffer).set(k,33),p){let{center:y,unit:_,leastScaleBits:T,scaleBitsSpan:z}=p;E.set([...y,_,T,z],40)}return E[46]=!o.sorted&&d.alphaMin||1/255,E[47]=u.blur,new Int32Array(E.buffer).set([Number(u.antialiased),Number(u.soft_edge&&!o.sorted)],48),E[50]=f,E}var Xe=class{milliseconds=null;#e;#t;#o=!1;#n=!1;#s=[];constructor(e){this.#e=e,this.#t=e.getExtension("EXT_disjoint_timer_query_webgl2")}start(){this.#n=this.#o&&!this.#s.length}pass(e){if(!this.#n)return;let[t,s]=[this.#e,this.#t.TIME_ELAPSED_EXT];if(this.#s.length&&t.endQuery(s),e){let n=t.createQuery();this.#s.push([e,n]),t.beginQuery(s,n)}else this.#n=!1}async time(){let e=this.#e;this.#o=this.#t!==null;let t=this.#s[this.#s.length-1];if(!t||this.#n)return;for(let n=0;n<100&&!e.getQueryParameter(t[1],e.QUERY_RESULT_AVAILABLE);n++)await new Promise(r=>setTimeout(r,5));let s=this.#s.map(([n,r])=>[n,e.getQueryParameter(r,e.QUERY_RESULT)/1e6]);e.getParameter(this.#t.GPU_DISJOINT_EXT)||(this.milliseconds=Object.fromEntries(s));for(let[,n]of this.#s.splice(0))e.deleteQuery(n)}forget(){this.#s=[],this.#n=!1}};function Ke({color:o,side:e},{viewmat:t,fx:s,fy:n,cx:r,cy:i,width:a,height:c,near:l}){let[f,h,d]=[0,4,8].map(p=>Array.from(t).slice(p,p+4));return Float32Array.of(...f.map((p,u)=>2*(s*p+r*d[u])/a-d[u]),...h.map((p,u)=>d[u]-2*(n*p+i*d[u])/c),...d,...o,l,n*e/2,.002*c/2,2/a,2/c)}function Ye({means:o}){let e=new Float32Array(6*o.length);for(let t=0,s=0;t<o.length;t+=3)for(let n=s+18;s<n;s+=3)e[s]=o[t],e[s+1]=o[t+1],e[s+2]=o[t+2];return e}var Qe=["shapes","colors","lobes","looks","opacities","order","color_sums","weight_sums"],Je=class{#e;#t=new Map;constructor(e){this.#e=e}make(e,t,[s,n]){let r=this.#e;r.deleteTexture(this.#t.get(e)??null);let i=r.createTexture();return this.#t.set(e,i),r.activeTexture(r.TEXTURE0+Qe.indexOf(e)),r.bindTexture(r.TEXTURE_2D,i),r.texStorage2D(r.TEXTURE_2D,1,t,s,n),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MIN_FILTER,r.NEAREST),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MAG_FILTER,r.NEAREST),i}upload(e,t,s){let n=this.#e,[r,,i]=t,a=Ze(s.length/i);if(a[1]>n.getParameter(n.MAX_TEXTURE_SIZE))throw new Error("the scene has more Gaussians than this GPU's textures can hold");this.make(e,n[r],a),this.write(e,t,0,s)}write(e,[,t,s],n,r){let i=this.#e,a=r instanceof Float32Array?i.FLOAT:i.UNSIGNED_INT,c=r.length/s;i.activeTexture(i.TEXTURE0+Qe.indexOf(e));for(let l=0;l<c;){let[f,h]=[(n+l)%4096,Math.floor((n+l)/4096)],d=Math.min(4096-f,c-l),p=d===4096?Math.floor((c-l)/4096):1,u=l*s;i.texSubImage2D(i.TEXTURE_2D,0,f,h,d,p,i[t],a,r,u),l+=d*p}}destroy(){for(let e of this.#t.values())this.#e.deleteTexture(e)}};function Ze(o){return[Math.max(1,Math.min(o,4096)),Math.max(1,Math.ceil(o/4096))]}var et=128,ln=0,Pt=["EXT_color_buffer_float","EXT_color_buffer_half_float"];function $t(o){return["EXT_color_buffer_float","EXT_float_blend"].every(e=>o.getExtension(e))}function Gt(o){for(let r of[...Pt,"EXT_float_blend"])o.getExtension(r);let e=o.getExtension("WEBGL_provoking_vertex");e?.provokingVertexWEBGL(e.FIRST_VERTEX_CONVENTION_WEBGL),o.disable(o.DITHER);let t={view:o.createBuffer(),corners:o.createBuffer(),quads:o.createVertexArray(),looks:o.createFramebuffer(),sums:o.createFramebuffer(),programs:new Map,textures:new Je(o)};o.bindBufferBase(o.UNIFORM_BUFFER,ln,t.view),o.bufferData(o.UNIFORM_BUFFER,xe,o.DYNAMIC_DRAW),o.bindVertexArray(t.quads),o.bindBuffer(o.ELEMENT_ARRAY_BUFFER,t.corners);let s=[0,1,2,2,1,3],n=Array.from({length:et},(r,i)=>s.map(a=>4*i+a));return o.bufferData(o.ELEMENT_ARRAY_BUFFER,Uint16Array.from(n.flat()),o.STATIC_DRAW),t}function fn(o,e,{sorted:t,packed:s,strips:n}){let{view:r,whole:i,project:a,splat:c,resolve:l}=e,f=s?e.packed:e.wide,h=`${t?`#define SORTED
`:""}${n?`#define STRIPS
`:""}`,d=(p,u)=>{let w=qt(o,`${h}#define VERTEX
${r}${p}`,`${h}${r}${u}`);return o.useProgram(w),Qe.forEach((m,b)=>o.uniform1i(o.getUniformLocation(w,m),b)),o.uniformBlockBinding(w,o.getUniformBlockIndex(w,"View"),ln),w};return{project:d(i,`${f}${a}`),splat:d(`${f}${c}`,c),resolve:d(i,l)}}function qt(o,e,t){let s=o.createProgram();for(let[n,r]of[[o.VERTEX_SHADER,e],[o.FRAGMENT_SHADER,t]]){let i=o.createShader(n);o.shaderSource(i,`#version 300 es
${r}`),o.compileShader(i),o.attachShader(s,i),o.deleteShader(i)}if(o.linkProgram(s),!o.getProgramParameter(s,o.LINK_STATUS)&&!o.isContextLost()){let n=(o.getAttachedShaders(s)??[]).map(r=>o.getShaderInfoLog(r));throw n.push(o.getProgramInfoLog(s)),new Error(`this GPU refuses a shader: ${n.join(" ")}`)}return s}var tt=class{#e;#t=null;#o;#n;#s;#r=0;constructor(e,t){this.#e=e,this.#o=qt(e,`#define VERTEX
${t}`,t),this.#n=e.createVertexArray(),this.#s=e.createBuffer(),e.bindVertexArray(this.#n),e.bindBuffer(e.ARRAY_BUFFER,this.#s),e.enableVertexAttribArray(0),e.vertexAttribPointer(0,3,e.FLOAT,!1,0,0)}take(e){let[t,s]=[this.#e,e?Ye(e):new Float32Array(0)];this.#t=e,this.#r=s.length/3,t.bindBuffer(t.ARRAY_BUFFER,this.#s),t.bufferData(t.ARRAY_BUFFER,s,t.STATIC_DRAW)}draw(e){let[t,s]=[this.#e,this.#t];s&&(t.bindFramebuffer(t.FRAMEBUFFER,null),t.viewport(0,0,e.width,e.height),t.disable(t.BLEND),t.clearBufferfv(t.COLOR,0,[...s.background,1]),t.useProgram(this.#o),t.uniform4fv(t.getUniformLocation(this.#o,"dots"),Ke(s,e)),t.bindVertexArray(this.#n),t.drawArrays(t.TRIANGLES,0,this.#r))}destroy(){let e=this.#e;e.deleteProgram(this.#o),e.deleteVertexArray(this.#n),e.deleteBuffer(this.#s)}};var Ht=new Float32Array(0),dn={shapes:["RGBA32UI","RGBA_INTEGER",4],colors:["RGBA32UI","RGBA_INTEGER",4],lobes:["R32UI","RED_INTEGER",1]},pn={shapes:["RGBA32F","RGBA",4],colors:["RGB32F","RGB",3],lobes:["RG32F","RG",2]},vr={...pn,colors:["RGB16F","RGB",3],lobes:["RG16F","RG",2]},un=["R32UI","RED_INTEGER",1],Ee=class o{static files=["view","wide","packed","whole","project","splat","resolve","dots"].map(e=>`${e}.glsl`);variant;lost=null;onLost=()=>{};onRestored=()=>{};#e;#t;#o;#n=null;#s=dn;#r=null;#i="";#a;#c=e=>{e.preventDefault(),this.#n=this.#r=null,this.lost="the browser took the GPU away from this page: reload it if no picture returns",this.onLost(this.lost)};#l=()=>{this.#n=null,this.#o=Gt(this.#e),this.#i="",this.#a.forget(),this.lost=null,this.onRestored()};static create(e,t,{floats:s=!1,strips:n=!1}={}){let r=e.getContext("webgl2",{alpha:!1,antialias:!1,depth:!1,powerPreference:"high-performance"});if(r===null)throw new Error("this browser cannot draw with WebGL2 here");if(!Pt.some(i=>r.getExtension(i)))throw new Error("this GPU cannot draw into textures of floats");if(s&&!$t(r))throw new Error("this GPU cannot blend 32-bit floats: use the variant halves");if(r.getParameter(r.MAX_TEXTURE_SIZE)<4096)throw new Error(`this GPU's textures are less than ${4096} pixels wide`);return new o(r,t,{floats:s,strips:n})}constructor(e,t,s){this.#e=e,this.#t=t,this.variant=s,this.#o=Gt(e),this.#a=new Xe(e),e.canvas.addEventListener("webglcontextlost",this.#c),e.canvas.addEventListener("webglcontextrestored",this.#l)}setScene(e){let t=this.#e;if(this.#n=null,e.network)throw new Error("this scene needs a network for every Gaussian in every frame, which takes WebGPU: open it in a browser that has it");this.#s=e.packing?dn:this.variant.floats?pn:vr;let{shapes:s,colors:n,lobes:r}=e;for(let[a,c]of Object.entries({shapes:s,colors:n,lobes:r}))this.#o.textures.upload(a,this.#s[a],c);t.bindFramebuffer(t.FRAMEBUFFER,this.#o.looks);let i=e.packing?[t.RG32UI,0]:[t.RGBA32F,t.R32F];["looks","opacities"].forEach((a,c)=>{let l=i[c]?this.#o.textures.make(a,i[c],Ze(e.count)):null;t.framebufferTexture2D(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0+c,t.TEXTURE_2D,l,0)}),this.#g("textures of 32-bit numbers"),this.#n={...e,shapes:Ht,colors:Ht,lobes:Ht},e.sorted&&this.#o.textures.upload("order",un,Uint32Array.from({length:e.count},(a,c)=>c))}show(e){this.#n&&(this.#n.count=e)}update(e,t,s){if(this.#n===null)return;let n=this.#s[e];this.#o.textures.write(e,n,ce(this.#n)[e]/n[2]*t,s)}setDots(e){this.lost===null&&(this.#r??=new tt(this.#e,this.#t.dots),this.#r.take(e))}drawDots(e){this.#r&&(this.#f(e),this.#r.draw(e))}setOrder(e){if(this.#n!==null){if(e.length!==this.#n.count)throw new Error(`an order of ${e.length} Gaussians does not fit this scene`);this.#o.textures.write("order",un,0,e)}}draw(e){this.#n!==null&&(this.#f(e),this.#a.start(),this.#u(this.#n,e),this.#p(this.#n,null,e.height-1),this.#a.pass())}async drawUnseen(e){let t=this.#e;if(this.#n&&this.#u(this.#n,e),t.readBuffer(t.COLOR_ATTACHMENT0),t.readPixels(0,0,1,1,t.RGBA,t.FLOAT,new Float32Array(4)),t.isContextLost())throw new Error("the graphics device was lost")}get milliseconds(){return this.#a.milliseconds}async time(){this.lost===null&&await this.#a.time()}async finished(){this.#e.bindFramebuffer(this.#e.FRAMEBUFFER,null),this.#e.readPixels(0,0,1,1,this.#e.RGBA,this.#e.UNSIGNED_BYTE,new Uint8Array(4))}get variants(){return($t(this.#e)?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}describe(){let e=this.#e,t=e.getExtension("WEBGL_debug_renderer_info");return String(e.getParameter(t?t.UNMASKED_RENDERER_WEBGL:e.RENDERER))}async pixels(e){if(this.#n===null)throw new Error("there is no scene to draw");let t=this.#e,{width:s,height:n}=e;this.#u(this.#n,e);let[r,i]=[t.createFramebuffer(),t.createRenderbuffer()];t.bindFramebuffer(t.FRAMEBUFFER,r),t.bindRenderbuffer(t.RENDERBUFFER,i),t.renderbufferStorage(t.RENDERBUFFER,t.RGBA32F,s,n),t.framebufferRenderbuffer(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0,t.RENDERBUFFER,i),this.#p(this.#n,r,0);let a=new Float32Array(4*s*n);return t.readPixels(0,0,s,n,t.RGBA,t.FLOAT,a),t.deleteFramebuffer(r),t.deleteRenderbuffer(i),a}destroy(){let e=this.#e,{view:t,corners:s,quads:n,looks:r,sums:i,programs:a,textures:c}=this.#o;this.#n=null,this.#r?.destroy(),e.canvas.removeEventListener("webglcontextlost",this.#c),e.canvas.removeEventListener("webglcontextrestored",this.#l),c.destroy();for(let l of a.values())for(let f of Object.values(l))e.deleteProgram(f);for(let l of[r,i])e.deleteFramebuffer(l);e.deleteVertexArray(n);for(let l of[t,s])e.deleteBuffer(l);e.getExtension("WEBGL_lose_context")?.loseContext()}#f({width:e,height:t}){let{canvas:s}=this.#e;s.width!==e&&(s.width=e),s.height!==t&&(s.height=t)}#u(e,t){let s=this.#e,{view:n,quads:r,looks:i,sums:a}=this.#o,c=this.#m(e);this.#h(e.sorted,t),s.bindBuffer(s.UNIFORM_BUFFER,n);let l=je(e,t,this.variant.floats?1:Ve);s.bufferSubData(s.UNIFORM_BUFFER,0,l),s.bindVertexArray(r),s.disable(s.BLEND),s.bindFramebuffer(s.FRAMEBUFFER,i),s.drawBuffers([s.COLOR_ATTACHMENT0,e.packing?s.NONE:s.COLOR_ATTACHMENT1]);let[f,h]=Ze(e.count);if(s.viewport(0,0,f,h),s.useProgram(c.project),this.#a.pass("project"),s.drawArrays(s.TRIANGLES,0,3),s.bindFramebuffer(s.FRAMEBUFFER,a),s.viewport(0,0,t.width,t.height),s.enable(s.BLEND),s.useProgram(c.splat),this.#a.pass("splat"),e.sorted?(s.drawBuffers([s.COLOR_ATTACHMENT0]),s.clearBufferfv(s.COLOR,0,[0,0,0,0]),s.blendFunc(s.ONE,s.ONE_MINUS_SRC_ALPHA)):(s.drawBuffers([s.COLOR_ATTACHMENT0,s.COLOR_ATTACHMENT1]),s.clearBufferfv(s.COLOR,0,[0,0,0,1]),s.clearBufferfv(s.COLOR,1,[0,0,0,0]),s.blendFuncSeparate(s.ONE,s.ONE,s.ZERO,s.ONE_MINUS_SRC_ALPHA)),this.variant.strips)s.drawArraysInstanced(s.TRIANGLE_STRIP,0,4,e.count);else{let d=Math.ceil(e.count/et);s.drawElementsInstanced(s.TRIANGLES,6*et,s.UNSIGNED_SHORT,0,d)}}#p(e,t,s){let n=this.#e,{resolve:r}=this.#m(e);n.bindFramebuffer(n.FRAMEBUFFER,t),n.disable(n.BLEND),n.useProgram(r),this.#a.pass("resolve"),n.uniform1i(n.getUniformLocation(r,"last_row"),s),n.drawArrays(n.TRIANGLES,0,3)}#h(e,{width:t,height:s}){let{floats:n}=this.variant,r=`${t} ${s} ${e} ${n}`;if(r===this.#i)return;let i=this.#e,a=i.getParameter(i.MAX_TEXTURE_SIZE);if(!(t>0&&t<=a&&s>0&&s<=a))throw new Error(`an image of ${t}x${s} pixels cannot be rendered: each side must lie between 1 and ${a}`);i.bindFramebuffer(i.FRAMEBUFFER,this.#o.sums);let c=n?[i.RGBA32F,i.R32F]:[i.RGBA16F,i.R16F];["color_sums","weight_sums"].forEach((l,f)=>{let h=e&&f>0?null:this.#o.textures.make(l,c[f],[t,s]);i.framebufferTexture2D(i.FRAMEBUFFER,i.COLOR_ATTACHMENT0+f,i.TEXTURE_2D,h,0)}),this.#g(`pictures of ${t}x${s} floats`),this.#i=r}#m({sorted:e,packing:t}){let{programs:s}=this.#o,n={sorted:e,packed:t!==null,strips:this.variant.strips},r=Object.values(n).join(" "),i=s.get(r)??fn(this.#e,this.#t,n);return s.set(r,i),i}#g(e){let t=this.#e;if(t.checkFramebufferStatus(t.FRAMEBUFFER)!==t.FRAMEBUFFER_COMPLETE&&!t.isContextLost())throw new Error(`this GPU cannot draw into ${e}`)}};var st=class{#e;#t;#o;#n;#s;#r;constructor(e,t,s){let{device:n}=e;this.#e=n,this.#t=t,this.#o=e.dots(s);let{UNIFORM:r,VERTEX:i,COPY_DST:a}=GPUBufferUsage;this.#n=n.createBuffer({size:80,usage:r|a});let c=Ye(t);this.#r=c.length/3,this.#s=e.filled(c,i)}draw(e,t){let[s,n,r]=[this.#e,this.#o,this.#t];s.queue.writeBuffer(this.#n,0,Ke(r,e));let i=s.createCommandEncoder(),a=i.beginRenderPass({colorAttachments:[{view:t,loadOp:"clear",storeOp:"store",clearValue:[...r.background,1]}]}),c=[{binding:0,resource:{buffer:this.#n}}];a.setPipeline(n),a.setBindGroup(0,s.createBindGroup({layout:n.getBindGroupLayout(0),entries:c})),a.setVertexBuffer(0,this.#s),a.draw(this.#r),a.end(),s.queue.submit([i.finish()])}destroy(){this.#n.destroy(),this.#s.destroy()}};var Z=128,V=4,wn={srcFactor:"one",dstFactor:"one-minus-src-alpha",operation:"add"},xr={color:wn,alpha:wn},mn={color:{srcFactor:"one",dstFactor:"one",operation:"add"},alpha:{srcFactor:"zero",dstFactor:"one-minus-src-alpha",operation:"add"}},ke=["network","project","splat","resolve"],nt=class o{milliseconds=null;#e;#t=new Map;#o=new Map;#n=null;static async create(e,t){if(!("gpu"in navigator))throw new Error("this browser has no WebGPU on this page: it may need https, or a newer version");let s=await Ts();if(s===null)throw new Error("WebGPU finds no graphics adapter on this device");let r=["timestamp-query","float32-blendable","shader-f16"].filter(l=>s.features.has(l));if(t&&!r.includes("float32-blendable"))throw new Error("this device cannot blend 32-bit floats");let{maxStorageBufferBindingSize:i,maxBufferSize:a}=s.limits,c=await s.requestDevice({requiredFeatures:r,requiredLimits:{maxStorageBufferBindingSize:i,maxBufferSize:a}});return new o(c,e)}constructor(e,t){if(this.device=e,this.#e=t,e.features.has("timestamp-query")){let s=16*ke.length,n=GPUBufferUsage;this.#n={queries:e.createQuerySet({type:"timestamp",count:2*ke.length}),found:e.createBuffer({size:s,usage:n.QUERY_RESOLVE|n.COPY_SRC}),read:e.createBuffer({size:s,usage:n.MAP_READ|n.COPY_DST})}}}get blendsFloats(){return this.device.features.has("float32-blendable")}get number(){return this.device.features.has("shader-f16")?"f16":"f32"}network(e){return this.#s(`network ${e.packed}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#r("network",e),entryPoint:"evaluate_network"}}))}project(e,{strips:t}){return this.#s(`project ${e.packed} ${e.sorted} ${t}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#r("project",e),entryPoint:e.sorted?"project_sorted":"project_sortfree",constants:{STRIPS:Number(t)}}}))}splat(e,{floats:t,strips:s}){return this.#s(`splat ${e.packed} ${e.sorted} ${s} ${t}`,()=>{let n=e.sorted?xr:mn,r=this.#r("splat",e);return this.device.createRenderPipeline({layout:"auto",vertex:{module:r,entryPoint:e.sorted?"corner_sorted":"corner_of_level",constants:{STRIPS:Number(s)}},primitive:{topology:s?"triangle-strip":"triangle-list"},fragment:{module:r,entryPoint:e.sorted?"cover":"add_weighted",targets:ot(e.sorted,t).map(i=>({format:i,blend:n}))}})})}enlarge(e){return this.#s(`enlarge ${e}`,()=>{let t=this.#r("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:t,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:t,entryPoint:"add_enlarged",targets:ot(!1,e).map(s=>({format:s,blend:mn}))}})})}resolve(e,t,s){return this.#s(`resolve ${e} ${s} ${t}`,()=>{let n=this.#r("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:n,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:n,entryPoint:e?"resolve_sorted":s?"resolve_levels":"resolve_sortfree",targets:[{format:t}]}})})}dots(e){return this.#s(`dots ${e}`,()=>{let t=this.device.createShaderModule({code:this.#e.dots,label:"dots"}),s=[{shaderLocation:0,offset:0,format:"float32x3"}];return this.device.createRenderPipeline({layout:"auto",vertex:{module:t,entryPoint:"corner_of_dot",buffers:[{arrayStride:12,attributes:s}]},fragment:{module:t,entryPoint:"paint_dot",targets:[{format:e}]}})})}filled(e,t){let s=Math.ceil(e.byteLength/4)*4,n=this.device.createBuffer({size:s,usage:t,mappedAtCreation:!0}),r=new Uint8Array(e.buffer,e.byteOffset,e.byteLength);return new Uint8Array(n.getMappedRange()).set(r),n.unmap(),n}bind(e,t){return this.device.createBindGroup({layout:e.getBindGroupLayout(0),entries:Object.entries(t).map(([s,n])=>({binding:Number(s),resource:n instanceof GPUBuffer?{buffer:n}:n}))})}stamps(e,t=!0,s=!0){if(this.#n===null||!(t||s))return;let n=2*ke.indexOf(e);return{querySet:this.#n.queries,...t?{beginningOfPassWriteIndex:n}:{},...s?{endOfPassWriteIndex:n+1}:{}}}async time({network:e}){if(this.#n===null||this.#n.read.mapState!=="unmapped")return;let{queries:t,found:s,read:n}=this.#n,r=this.device.createCommandEncoder();r.resolveQuerySet(t,0,2*ke.length,s,0),r.copyBufferToBuffer(s,0,n,0,n.size),this.device.queue.submit([r.finish()]),await n.mapAsync(GPUMapMode.READ);let i=new BigUint64Array(n.getMappedRange()),a=ke.map((c,l)=>[c,Number(i[2*l+1]-i[2*l])/1e6]);this.milliseconds=Object.fromEntries(e?a:a.slice(1)),n.unmap()}#s(e,t){let s=this.#o.get(e)??t();return this.#o.set(e,s),s}#r(e,t){let s=t===null?"":this.#e[t.packed?"packed":"wide"],n=`${e} ${t?.packed}`,r=this.number==="f16"?`enable f16;
`:"",a=`${e==="network"?`${r}alias Num = ${this.number};
`:""}${this.#e.view}
${s}
${this.#e[e]}`,c=this.#t.get(n)??this.device.createShaderModule({code:a,label:e});return this.#t.set(n,c),c}};function rt(o,e){return Object.fromEntries(o.map((t,s)=>[e+s,t]))}function ot(o,e){return e?o?["rgba32float"]:["rgba32float","r32float"]:o?["rgba16float"]:["rgba16float","r16float"]}var Wt=256,it=6,kr={packed:8,wide:32},Vt=new Float32Array(0),_e=class o{static files=["view","wide","packed","network","project","splat","resolve","dots"].map(e=>`${e}.wgsl`);variant;levelSigma=0;lost=null;onLost=()=>{};#e;#t;#o;#n;#s;#r=null;#i=null;#a=null;#c=null;#l;#f;#u;#p;static async create(e,t,{floats:s=!1,strips:n=!1}={}){let r=await nt.create(t,s);return new o(r,e,{floats:s,strips:n})}constructor(e,t,s){let n=t.getContext("webgpu");if(n===null)throw new Error("this canvas is already drawn to in another way");let{device:r}=e;this.variant=s,this.#e=e,this.#t=r,this.#n=t,this.#o=n,this.#s=navigator.gpu.getPreferredCanvasFormat(),n.configure({device:r,format:this.#s,alphaMode:"opaque"});let i=GPUBufferUsage;this.#l=r.createBuffer({size:xe,usage:i.UNIFORM|i.COPY_DST});let a=i.STORAGE|i.INDIRECT|i.COPY_DST;this.#f=r.createBuffer({size:4*it*V,usage:a});let c=new Uint32Array(V*Wt/4);for(let f=0;f<V;f++)c[f*Wt/4]=f;this.#u=e.filled(c,i.UNIFORM);let l=new Uint16Array(6*Z);for(let f=0;f<Z;f++)l.set([0,1,2,2,1,3].map(h=>4*f+h),6*f);this.#p=e.filled(l,i.INDEX),r.lost.then(({reason:f})=>{f!=="destroyed"&&this.#h("the graphics device was lost: reload the page to go on")}),r.onuncapturederror=({error:f})=>this.#h(`this GPU cannot draw the scene: ${f.message}`)}get variants(){return(this.#e.blendsFloats?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}get milliseconds(){return this.#e.milliseconds}setScene(e){this.#m();let{count:t,sorted:s}=e,n={sorted:s,packed:e.packing!==null,network:!!e.network},r=kr[n.packed?"packed":"wide"]*Math.max(t,1),i={shapes:e.shapes,colors:e.colors,lobes:e.lobes},a=Math.max(r,...Object.values(i).map(u=>u.byteLength)),{maxStorageBufferBindingSize:c,maxBufferSize:l}=this.#t.limits,f=Math.min(c,l);if(a>f)throw new Error(`${t} Gaussians need ${Math.ceil(a/2**20)} MiB at a stretch, and this device gives ${Math.floor(f/2**20)}`);let h=GPUBufferUsage,d=u=>this.#e.filled(u.length?u:new Uint32Array(16),h.STORAGE|h.COPY_DST),p=u=>this.#t.createBuffer({size:4*Math.max(1,u),usage:h.STORAGE|h.COPY_DST});this.#i={kind:n,parts:{shapes:d(i.shapes),colors:d(i.colors),lobes:d(i.lobes)},looks:this.#t.createBuffer({size:r,usage:h.STORAGE}),order:p(s?t:2*t),network:e.network?{weights:this.#e.filled(this.#v(e.network),h.STORAGE),lobes:p(t)}:null},this.#r={...e,shapes:Vt,colors:Vt,lobes:Vt},s&&this.setOrder(Uint32Array.from({length:t},(u,w)=>w))}show(e){this.#r&&(this.#r.count=e)}update(e,t,s){if(!this.#r||!this.#i||this.lost!==null)return;let n=4*ce(this.#r)[e]*t;this.#t.queue.writeBuffer(this.#i.parts[e],n,s)}setDots(e){this.#a?.destroy(),this.#a=e&&new st(this.#e,e,this.#s)}drawDots(e){this.lost===null&&this.#a?.draw(e,this.#b(e))}setOrder(e){this.#i?.kind.sorted&&this.#t.queue.writeBuffer(this.#i.order,0,e)}draw(e){this.lost===null&&this.#d(e,this.#b(e),this.#s)}async pixels(e){let{width:t,height:s}=e,n=Math.ceil(16*t/256)*256,r=this.#y(t,s,"rgba32float");this.#d(e,r.createView(),"rgba32float");let i=this.#t.createBuffer({size:n*s,usage:GPUBufferUsage.MAP_READ|GPUBufferUsage.COPY_DST}),a=this.#t.createCommandEncoder();a.copyTextureToBuffer({texture:r},{buffer:i,bytesPerRow:n},[t,s]),this.#t.queue.submit([a.finish()]),await i.mapAsync(GPUMapMode.READ);let c=new Float32Array(i.getMappedRange()),l=new Float32Array(4*t*s);for(let f=0;f<s;f++){let h=f*n/4;l.set(c.subarray(h,h+4*t),4*t*f)}return i.destroy(),r.destroy(),l}async drawUnseen(e){let t=this.#y(e.width,e.height,this.#s);if(this.#d(e,t.createView(),this.#s),await this.finished(),t.destroy(),this.lost!==null)throw new Error(this.lost)}async finished(){await this.#t.queue.onSubmittedWorkDone()}describe(){let e=this.#t.adapterInfo;return[e?.vendor,e?.architecture,e?.device,e?.description].filter(Boolean).join(" ")}async time(){this.lost===null&&this.#i&&await this.#e.time(this.#i.kind)}destroy(){this.#m(),this.setDots(null),this.#t.onuncapturederror=null,this.#t.destroy()}#h(e){this.lost===null&&(this.lost=e,this.onLost(e))}#m(){for(let e of this.#g())e.destroy();this.#i=this.#r=null}#g(){if(this.#i===null)return[];let{parts:e,looks:t,order:s,network:n}=this.#i;return[...Object.values(e),t,s,...Object.values(n??{})]}#b({width:e,height:t}){return this.#n.width!==e&&(this.#n.width=e),this.#n.height!==t&&(this.#n.height=t),this.#o.getCurrentTexture().createView()}#y(e,t,s){let n=GPUTextureUsage;return this.#t.createTexture({size:[e,t],format:s,usage:n.RENDER_ATTACHMENT|n.COPY_SRC})}#d(e,t,s){let n=this.#r;if(!n||!this.#i)return;let{queue:r}=this.#t,{floats:i,strips:a}=this.variant,c=n.sorted?0:this.levelSigma;r.writeBuffer(this.#l,0,je(n,e,i?1:Ve,c));let l=new Uint32Array(it*V);for(let u=0;u<V;u++)l[it*u]=a?4:6*Z;r.writeBuffer(this.#f,0,l);let f=this.#A(e.width,e.height,n.sorted,c?V:1),h=this.#t.createCommandEncoder();this.#k(h,n.count,this.#i),this.#E(h,n.count,this.#i),this.#_(h,n.count,this.#i,f);let d=this.#e.resolve(n.sorted,s,f.length>1),p=h.beginRenderPass({colorAttachments:[{view:t,loadOp:"clear",storeOp:"store"}],timestampWrites:this.#e.stamps("resolve")});p.setPipeline(d),p.setBindGroup(0,this.#e.bind(d,{0:this.#l,...rt(f.slice(0,2).flat(),1)})),p.draw(3),p.end(),r.submit([h.finish()])}#v(e){return this.#e.number==="f16"?Uint16Array.from(e,q):e}#k(e,t,{kind:s,parts:n,network:r}){if(r===null)return;let i={0:this.#l,1:n.shapes,4:n.lobes,5:r.weights,6:r.lobes};this.#x(e,"network",this.#e.network(s),i,Math.ceil(t/32))}#E(e,t,{kind:s,parts:n,looks:r,order:i,network:a}){let c=a?.lobes??n.lobes,l=[this.#l,n.shapes,n.colors,c,r];s.sorted||l.push(i,this.#f);let f=this.#e.project(s,this.variant);this.#x(e,"project",f,rt(l,0),Math.ceil(t/Z))}#x(e,t,s,n,r){let i=Math.max(1,Math.min(r,65535)),a=e.beginComputePass({timestampWrites:this.#e.stamps(t)});a.setPipeline(s),a.setBindGroup(0,this.#e.bind(s,n)),a.dispatchWorkgroups(i,Math.ceil(r/i)),a.end()}#_(e,t,{kind:s,parts:n,looks:r,order:i},a){let c=[{r:0,g:0,b:0,a:s.sorted?0:1},{r:0,g:0,b:0,a:0}],l=this.#e.splat(s,this.variant),f=a.length-1;for(let h=f;h>=0;h--){let d=e.beginRenderPass({colorAttachments:a[h].map((m,b)=>({view:m,loadOp:"clear",storeOp:"store",clearValue:c[b]})),timestampWrites:this.#e.stamps("splat",h===f,h===0)});if(h>0&&h<f){let m=this.#e.enlarge(this.variant.floats);d.setPipeline(m),d.setBindGroup(0,this.#e.bind(m,rt(a[h+1],3))),d.draw(3)}d.setPipeline(l);let p={buffer:this.#u,offset:h*Wt,size:16},u={0:this.#l,1:n.shapes,4:r,5:i};d.setBindGroup(0,this.#e.bind(l,s.sorted?u:{...u,6:this.#f,7:p})),d.setIndexBuffer(this.#p,"uint16");let w=4*it*h;this.variant.strips?s.sorted?d.draw(4,t):d.drawIndirect(this.#f,w):s.sorted?d.drawIndexed(6*Z,Math.ceil(t/Z)):d.drawIndexedIndirect(this.#f,w),d.end()}}#A(e,t,s,n){let r=`${e} ${t} ${s} ${n} ${this.variant.floats}`;if(this.#c?.key===r)return this.#c.views;for(let l of this.#c?.textures??[])l.destroy();let i=GPUTextureUsage,a=[],c=_r(e,t).slice(0,n).map(l=>ot(s,this.variant.floats).map(f=>{let h=i.RENDER_ATTACHMENT|i.TEXTURE_BINDING,d=this.#t.createTexture({size:l,format:f,usage:h});return a.push(d),d.createView()}));return this.#c={key:r,textures:a,views:c},c}};function _r(o,e){let t=[[o,e]];for(let s=1;s<V;s++)t.push(t[s-1].map(n=>(n-(s===1?0:1)>>1)+2));return t}async function at(o,e){let t="";if(e!=="webgl")try{let s=await gn(_e.files);return{name:"WebGPU",renderer:await _e.create(o,s)}}catch(s){if(e==="webgpu")throw s;t=s instanceof Error?s.message:String(s)}try{return{name:"WebGL2",renderer:Ee.create(o,await gn(Ee.files))}}catch(s){let n=s instanceof Error?s.message:String(s);throw new Error(`this browser cannot draw the scene: ${t?`${t}; `:""}${n}`)}}async function gn(o){let e=o.map(async t=>[t.replace(/\.[a-z]+$/,""),await Ms(t)]);return Object.fromEntries(await Promise.all(e))}var bn=new Map;function vn(o){let e=bn.get(o)??Ar(o);return bn.set(o,e),e}async function Ar(o){let{renderer:e}=await at(document.createElement("canvas"),o);try{return await Gs(e,jt())}finally{e.destroy()}}function jt(){try{return localStorage}catch{return null}}var S=(o,e,t=1)=>[o[0]+t*e[0],o[1]+t*e[1],o[2]+t*e[2]],C=(o,e)=>S(o,e,-1),L=(o,e)=>o[0]*e[0]+o[1]*e[1]+o[2]*e[2],W=(o,e)=>[o[1]*e[2]-o[2]*e[1],o[2]*e[0]-o[0]*e[2],o[0]*e[1]-o[1]*e[0]],he=o=>Math.hypot(...o);function j(o){let e=he(o);return e>0?[o[0]/e,o[1]/e,o[2]/e]:[1,0,0]}function Xt(o,e,t){let[s,n]=[Math.cos(t),Math.sin(t)],r=L(o,e)*(1-s),i=W(e,o);return S(S([o[0]*s,o[1]*s,o[2]*s],i,n),e,r)}var Sr=Math.cos(.5*Math.PI/180),ct=class{by="";#e=!1;#t=null;reset(e){this.by=e,this.#e=!1}invalidate(){this.#t=null}get pending(){return this.#e}received(){this.#e=!1}neededDirection({viewmat:e}){let t=[e[8],e[9],e[10]],s=this.#t!==null&&L(t,this.#t)>=Sr;return!this.by||this.#e||s?null:(this.#e=this.by==="worker",this.#t=t)}};var yn=12;function xn(o,e,t,s,n){let{viewmat:r,fx:i,fy:a,cx:c,cy:l,near:f}=t,h=-1,d=1/0;for(let p=0;3*p<o.length;p++){if(e[p]<0)continue;let[u,w,m]=[o[3*p],o[3*p+1],o[3*p+2]],b=r[8]*u+r[9]*w+r[10]*m+r[11];if(b<=f||b>=d)continue;let E=i*(r[0]*u+r[1]*w+r[2]*m+r[3])/b+c-s,k=a*(r[4]*u+r[5]*w+r[6]*m+r[7])/b+l-n;E*E+k*k>yn*yn||(d=b,h=p)}return h<0?null:[o[3*h],o[3*h+1],o[3*h+2]]}function Kt(o,e,t,s){let n=s instanceof Uint32Array;for(let r=0;r*e<s.length;r++)o[t+r]=n?js(s[r*e]):s[r*e]}var Tr=50,lt=class{count=0;views=[];near=.2;logits=new Float32Array(0);request=null;calibrated=Promise.resolve();name="";broken=!1;#e=new Float32Array(0);#t;#o;#n=!1;#s;#r;#i=null;#a=null;#c=null;#l=null;#f=Promise.resolve(!1);#u=!1;#p=null;#h=!1;#m=2;#g=[0,0,0];#b=null;#y=[0,0,0];#d=new ct;#v=null;#k=!1;#E=!1;#x=!1;constructor(e,t,s,n,r=0){this.canvas=e,this.#r=t,this.#t=s,this.#o=r,this.#s=n}begin(e){return this.#f=this.#_(e)}async#_(e){try{let{name:t,renderer:s}=await at(this.canvas,e);if(this.#u)return s.destroy(),!1;s.onLost=i=>this.#M(i),"onRestored"in s&&(s.onRestored=()=>this.request&&this.load(this.request));let r=s.variants.find(({floats:i,strips:a})=>i===this.#t?.floats&&a===this.#t.strips)??$s(s,jt());return r&&(s.variant=r),"levelSigma"in s&&(s.levelSigma=this.#o),this.#n=r!==null,this.#i=s,this.name=t,Hs(s),!0}catch(t){return this.#r.failed(Yt(t)),!1}}async#A(){if(this.#n||this.broken)return;this.#n=!0;let e=this.name==="WebGPU"?"webgpu":"webgl",t=await vn(e);this.#i&&(this.#i.variant=t),this.#r.changed()}load(e,t=!1){this.#c?.terminate(),this.request=e;let s=Ss(e,async({data:n})=>{if(!await this.#f){s.terminate();return}(s===this.#c||s===this.#a)&&this.#F(n,s)});s.onerror=n=>{n.preventDefault(),!t&&s===this.#c?this.load(e,!0):this.#L("the viewer's own files could not be loaded: reload the page",s)},this.#c=this.#l=s}async sort(e){if(this.#d.by==="")return null;if(this.broken)throw new Error("the renderer was lost");this.#d.pending&&await this.#S();let t=performance.now();return this.#d.invalidate(),this.#U(e),this.#d.pending&&await this.#S(),performance.now()-t}#S(){return new Promise((e,t)=>this.#v={resolve:e,reject:t})}#T(e){this.#v?.reject(new Error(e)),this.#v=null}draw(e){if(this.#a===null)return;let t={...e,near:this.near};if(this.#E){this.#i?.drawDots(t),this.#w();return}this.#U(e),this.#i?.draw(t)}async#w(){let e=this.#i;this.#x||this.#s||!e||(this.#x=!0,await new Promise(t=>setTimeout(t,Tr)),this.#E&&!this.#u&&await qs(e).catch(()=>{}))}drawOrReport(e){if(!this.broken)try{this.draw(e)}catch(t){this.#M(Yt(t))}}async finished(){await this.#i?.finished()}pixels(e){return(this.#a&&!this.#E?this.#i?.pixels(e):null)??Promise.reject(new Error("nothing can be drawn"))}get background(){return this.#b??this.#g}set background(e){this.#b=e,this.background.forEach((t,s)=>this.#y[s]=t)}get means(){return this.#e=$e(this.#e)}get milliseconds(){return this.#i?.milliseconds??null}async time(){this.#k||!this.#i||(this.#k=!0,await this.#i.time().catch(()=>{}),this.#k=!1)}get device(){let{floats:e,strips:t}=this.#i?.variant??{floats:!1,strips:!1},s=`${e?"floats":"halves"}, ${t?"strips":"batches"}`,{by:n}=this.#d,r=this.#i?.describe()??"";return{renderer:this.name,adapter:r,variant:s,sorted:n!=="",sorted_by:n||null}}destroy(){this.#u=this.broken=!0,this.#T("the renderer was lost"),this.#c?.terminate(),this.#a?.terminate(),this.#i?.destroy(),this.#i=null}#M(e){this.broken=!0,this.#T(e),this.#r.broken(e)}#F(e,t){this.broken&&t===this.#a||(e.kind==="failed"?this.#L(e.sentence,t):e.kind==="progress"?t===this.#l&&this.#r.progress(e.received/e.total):e.kind==="dots"?this.#I(e,t):e.kind==="scene"?this.#N(e,t):e.kind==="rows"?this.#C(e):e.kind==="more"?this.#R(e.means):e.kind==="order"?this.#B(e.order):(this.#d.by!=="worker"&&t.terminate(),this.#c||(this.calibrated=this.#A().catch(()=>{})),t===this.#l&&this.#r.loaded(e.milliseconds,e.bytes)))}#L(e,t){let s=t===this.#c&&this.#p!==null;t===this.#a&&this.#T(e),t===this.#c&&(this.#c=null,this.request=this.#p),(t!==this.#a||this.#d.by!=="worker")&&t.terminate(),t===this.#l&&this.#r.failed(e,s)}#I({dots:e,views:t,near:s},n){this.#d.reset(""),this.#O(n,e.background,()=>this.#i?.setDots(e))&&(this.#E=!0,this.#z(t,s),this.logits=new Float32Array(e.means.length/3),this.#R(e.means),this.#h||this.#r.arrived())}#N({data:e,means:t,views:s,near:n},r){let i=r===this.#a;this.#d.reset(e.sorted?"worker":this.#s?"page":""),e.sorted=this.#d.by!=="",this.#O(r,e.background,()=>{this.#i?.setDots(null),this.#i?.setScene(e)})&&(this.#E=!1,this.#z(s,n),this.logits=new Float32Array(e.count),this.#m=ce(e).lobes,Kt(this.logits,this.#m,0,e.lobes),this.#R(t),!i&&!this.#h&&this.#r.arrived())}#O(e,t,s){if(e!==this.#a&&(this.#a?.terminate(),this.#T("another scene was opened")),this.#a=e,e===this.#c&&(this.#h=this.request===this.#p&&this.count>0,this.#p=this.request,this.#c=null),this.#g=[...t],this.#y=t,this.background=this.#b,this.#i?.lost)return this.#M(this.#i.lost),!1;try{s()}catch(n){return e.terminate(),this.count=0,this.#r.failed(Yt(n)),!1}return this.broken=!1,!0}#z(e,t){this.views=e,this.near=t}#R(e){this.#e=e,this.count=("stored"in e?e.stored:e).length/3,this.#i?.show(this.count),this.#d.invalidate(),this.#r.changed()}#C({part:e,from:t,numbers:s}){this.#i?.update(e,t,s),e==="lobes"&&Kt(this.logits,this.#m,t,s),this.#r.changed()}#B(e){this.#d.received(),this.#i?.setOrder(e),this.#v?.resolve(),this.#v=null,this.#r.ordered()}#U(e){let t=this.#d.neededDirection(e);t!==null&&(this.#d.by==="page"?this.#i?.setOrder(Ne(this.means,t)):this.#a?.postMessage({forward:t}))}},Yt=o=>o instanceof Error?o.message:String(o);var En=.02,kn=.02,_n=.001,ee=class o{constructor(e,t,s){this.eye=e,this.target=t,this.up=j(s),this.reach=he(C(t,e))||1}static fromViews(e,t=0){let s=e.map(Rr),n=Mr(s),{eye:r,forward:i}=s[t],a=L(C(Lr(s),r),i),c=Math.max(...s.map(l=>he(C(l.eye,r))),0)||1;return new o(r,S(r,i,a>_n*c?a:c),n)}static around(e){let t=[0,1,2].map(r=>{let i=e.filter((c,l)=>l%3===r).sort(),a=c=>i[Math.floor(c*(i.length-1))]??0;return[a(.15),a(.5),a(.85)]}),s=t.map(([,r])=>r),n=Math.max(...t.map(([r,,i])=>i-r))||1;return new o(S(s,[0,-.3,-1],1.5*n),s,[0,-1,0])}get forward(){return j(C(this.target,this.eye))}get right(){return j(W(this.forward,this.up))}copy(){let e=new o(this.eye,this.target,this.up);return e.reach=this.reach,e}orbit(e,t){let s=this.#e(C(this.eye,this.target),e,t);this.eye=S(this.target,s)}look(e,t){let s=this.#e(C(this.eye,this.target),e,t);this.target=C(this.eye,s)}move(e,t,s){let n=W(this.forward,this.right),r=S([0,0,0],this.right,e);r=S(S(r,n,t),this.forward,s),this.eye=S(this.eye,r),this.target=S(this.target,r)}dolly(e){let t=C(this.eye,this.target),s=Math.max(he(t)*e,_n*this.reach);this.eye=S(this.target,j(t),s)}focus(e){he(C(e,this.eye))>0&&(this.target=e)}viewmat(){let{forward:e,right:t,eye:s}=this,n=W(e,t),r=i=>[...i,-L(i,s)];return[...r(t),...r(n),...r(e),0,0,0,1]}#e(e,t,s){let n=Math.acos(Math.min(1,Math.max(-1,L(j(e),this.up)))),r=Math.min(Math.max(n-s,En),Math.PI-En)-n;return Xt(Xt(e,this.right,r),this.up,-t)}};function An(o,e,t,s,n,r=null){let i=Math.tan((r??50)*Math.PI/360),a=r===null?e:null,c=a?t*a.K[0]/a.width:t/(2*i),l=a?s*a.K[4]/a.height:s/(2*i),f=Math.sqrt(c*l),h={cx:t/2,cy:s/2};return{viewmat:o.viewmat(),fx:f,fy:f,...h,width:t,height:s,near:n}}function Mr(o){let e=j(o.reduce((s,{down:n})=>C(s,n),[0,0,0])),t=e;for(let s=0;s<200;s++){let n=S([0,0,0],t,1+kn);for(let{right:r}of o)n=S(n,r,-L(r,t)/o.length);t=j(S(n,e,kn*L(e,t)))}return t}function Rr({viewmat:o}){let e=i=>[o[4*i],o[4*i+1],o[4*i+2]],[t,s,n]=[e(0),e(1),e(2)],r=S([0,0,0],t,-o[3]);return r=S(S(r,s,-o[7]),n,-o[11]),{eye:r,right:t,forward:n,down:s}}function Lr(o){let e=[.001,0,0,0,.001,0,0,0,.001],t=[0,0,0];for(let{eye:c,forward:l}of o){for(let f=0;f<3;f++)for(let h=0;h<3;h++)e[3*f+h]+=(f===h?1:0)-l[f]*l[h];t=S(S(t,c,1+.001/o.length),l,-L(l,c))}let s=c=>[e[c],e[3+c],e[6+c]],[n,r,i]=[s(0),s(1),s(2)],a=L(n,W(r,i));return[L(t,W(r,i))/a,L(n,W(t,i))/a,L(n,W(r,t))/a]}var Or=16.666666666666668,zr=1e3/50,Ur=1e3/45,Sn=1e3/26,Fr=3,Ir=200,Nr=.9,Tn=[4,64],Cr=[1,.85,.7,.6,.5],Ae=class{#e=0;#t=[];#o;#n=Ur;#s={step:0,median:1/0};#r=0;#i=Tn[0];constructor(e){this.fixed=e,this.#o=e===null?Cr:[e]}get scale(){return this.#o[this.#e]}size(e,t,s,n){let r=Math.min(s,2)*(n?this.scale:this.#o[0]),i=a=>Math.max(1,Math.round(a*r));return{width:i(e),height:i(t)}}note(e){this.#t.push(e);let{length:t}=this.#t;if(t<Fr||this.#t.reduce((n,r)=>n+r)<Ir)return;let s=this.#t.sort((n,r)=>n-r)[t>>1];this.#t=[],s>this.#n?this.#a(s):s>=zr||this.#e===0?this.#r=0:++this.#r>=this.#i&&(this.#e-=1,this.#r=0)}#a(e){let{step:t,median:s}=this.#s;if(this.#r=0,this.#i=Math.min(2*this.#i,Tn[1]),t<this.#e&&e<Sn&&e>Nr*s){this.#e=t,this.#n=Sn;return}this.#s={step:this.#e,median:e};let n=this.scale*Math.sqrt(Or/e),r=this.#o.findIndex(i=>i<this.scale&&i<=n);this.#e=r<0?this.#o.length-1:r}};var Br=100,Mn=150,Dr=9*Math.PI/180,ft=class{mode="orbit";pose=new ee([0,0,-3],[0,0,0],[0,-1,0]);fov=null;timed=!1;turning=!1;measured=!1;#e;#t;#o;#n;#s;#r=null;#i="auto";#a=null;#c;#l;#f=this.pose;#u=!1;#p=0;#h=0;#m=-1/0;#g=!1;#b=0;#y=0;#d;constructor(e,t,{variant:s=null,levels:n=0}={}){this.#t=e,this.#e=t,this.#o=s,this.#n=n,this.#c=new Ae(null),this.#s=this.#k(e,0,!1),this.#l=new Ie(e,{pose:()=>this.pose,mode:()=>this.mode,held:()=>this.turning=!1,changed:()=>{this.#m=performance.now(),this.turning=!1,this.redraw()},focus:(r,i)=>this.#A(r,i)}),this.#d=new ResizeObserver(()=>this.redraw()),this.#d.observe(e)}begin(e){return this.#i=e,this.#s.begin(e)}load(e){this.#s.request&&(this.#u=!1),this.#s.load(e)}async compare(e,t,s){this.endComparison();let n=this.#k(e,1,s);n.background=this.#a,this.#r=n,await this.#s.calibrated,n===this.#r&&await n.begin(this.#i)&&n===this.#r&&n.load(t)}endComparison(){this.#r?.destroy(),this.#r=null}redraw(){!this.#p&&!this.measured&&(this.#p=requestAnimationFrame(e=>this.#x(e)))}reset(e){let{views:t}=this;this.pose=e===void 0||t.length===0?this.#f.copy():ee.fromViews(t,(e%t.length+t.length)%t.length),this.redraw()}place(e){this.pose=e,this.#u=!0,this.redraw()}camera(e,t){return An(this.pose,this.views[0]??null,e,t,this.#s.near,this.fov)}get views(){return this.#s.views.length?this.#s.views:this.#r?.views??[]}get count(){return this.#s.count}get calibrated(){return this.#s.calibrated}get source(){let{request:e}=this.#s;return e===null||"forward"in e?null:"url"in e?e.url:e.file}get device(){return this.#s.device}get scale(){return this.#c.fixed}set scale(e){this.#c=new Ae(e),this.redraw()}get choices(){let{mode:e,fov:t,turning:s,scale:n,timed:r}=this;return{mode:e,fov:t,turning:s,scale:n,timed:r,background:this.#a}}get background(){return this.#s.background}set background(e){this.#a=e;for(let t of this.#v)t.background=e;this.redraw()}async drawAndWait(e,t){let s=this.camera(e,t),n=await this.#s.sort(s);if(this.#s.draw(s),await this.finished(),this.#s.broken)throw new Error("the renderer was lost");return n}async finished(){await this.#s.finished()}async passes(){return await this.#s.time(),this.#s.milliseconds}pixels(e,t=0){return this.#v[t]?.pixels(e)??Promise.reject(new Error("there is no other scene"))}screenshot(e=1){let{width:t,height:s}=this.#_(),n=document.createElement("canvas");[n.width,n.height]=[t,s];let r=n.getContext("2d");return this.#v.forEach(({canvas:i},a)=>{let c=a*Math.round(e*t),l=t-c;l>0&&r?.drawImage(i,c,0,l,s,c,0,l,s)}),new Promise(i=>n.toBlob(i,"image/png"))}destroy(){cancelAnimationFrame(this.#p),clearTimeout(this.#y),clearTimeout(this.#b),this.#l.destroy(),this.#d.disconnect();for(let e of this.#v)e.destroy()}get#v(){return this.#r?[this.#s,this.#r]:[this.#s]}#k(e,t,s){let n={progress:r=>this.#e.progress(t,r),arrived:()=>this.#E(t),changed:()=>{this.#b||=setTimeout(()=>this.redraw(),Br)},ordered:()=>this.redraw(),loaded:(r,i)=>{this.#e.loaded(t,r,i),this.redraw()},failed:(r,i)=>this.#e.failed(t,r,i),broken:r=>this.#e.broken(t,r)};return new lt(e,n,this.#o,s,this.#n)}#E(e){let{views:t}=this;(e===0||!this.#s.views.length&&this.#m===-1/0)&&(t.length||this.#s.count)&&(this.#f=t.length?ee.fromViews(t):ee.around(this.#s.means),this.#u||this.reset()),this.redraw()}#x(e){this.#p=0,clearTimeout(this.#b),this.#b=0;let t=e-this.#h;this.#h=e;let s=this.#g,n=this.turning&&this.count>0;this.#g=performance.now()-this.#m<Mn||this.#l.busy||n,this.#g&&s&&this.#c.note(t);let r=Math.min(t,100)/1e3;this.#l.advance(r),n&&this.pose.orbit(Dr*r,0);let{width:i,height:a}=this.#_();if(clearTimeout(this.#y),this.#g&&(this.#y=setTimeout(()=>this.redraw(),2*Mn)),this.count&&!this.#s.broken){let{name:c,count:l,milliseconds:f}=this.#s,h=this.#g&&s?t:0,d=this.#r?.count??0;this.#e.drawn({renderer:c,count:l,compared:d,width:i,height:a,milliseconds:h,passes:f}),this.timed&&this.#s.time()}(this.#l.busy||n)&&this.redraw()}#_(){let{clientWidth:e,clientHeight:t}=this.#t,s=this.#c.size(e,t,devicePixelRatio,this.#g);if(e&&t){let n=this.camera(s.width,s.height);for(let r of this.#v)r.drawOrReport(n)}return s}#A(e,t){let{clientWidth:s,clientHeight:n}=this.#t,{means:r,logits:i}=this.#s,a=xn(r,i,this.camera(s,n),e,t);a&&this.pose.focus(a),this.redraw()}};var Rn=["settings","help","report"],Ln=["scale","background","fov","autorotate"],Pr=2e3,On="sorted",$r={rootMargin:"100%"},Gr="(prefers-reduced-motion: reduce)",Qt=class extends(globalThis.HTMLElement??Object){static observedAttributes=["src","compare",...Ln];viewer=null;#e;#t=null;#o=new me;#n=null;#s;#r=!1;#i=!1;#a=null;#c=[];#l=0;#f=Promise.resolve(!1);#u=!1;#p=new IntersectionObserver(e=>e.some(t=>t.isIntersecting)&&this.#h(),$r);constructor(){super(),this.#e=this.attachShadow({mode:"open",delegatesFocus:!0}),this.#e.innerHTML=ks;for(let t of this.#e.querySelectorAll("button"))t.addEventListener("click",()=>this.act(t.dataset.act??""));this.#e.addEventListener("keydown",t=>{let{code:s,key:n,ctrlKey:r,metaKey:i,altKey:a,repeat:c,target:l,defaultPrevented:f}=t,h=Mt.get(n.toLowerCase())??Mt.get(s.slice(3).toLowerCase()),d=f||l.matches("textarea, select");h&&!r&&!i&&!a&&!c&&!d&&this.act(h),s==="Escape"&&this.act("close")}),this.#e.addEventListener("keyup",t=>{let{code:s,target:n}=t,{classList:r}=n;s==="Tab"&&(r.add("reached"),n?.addEventListener("blur",()=>r.remove("reached"),{once:!0}))}),this.#w("settings").addEventListener("input",({target:t})=>{let s=t;s.name==="stats"?this.act("stats"):this.viewer&&xs(s,this.viewer)}),this.addEventListener("dragover",t=>{t.preventDefault(),this.#w("drop").hidden=!1}),this.addEventListener("dragleave",()=>this.#w("drop").hidden=!0),this.addEventListener("drop",t=>{t.preventDefault(),this.#w("drop").hidden=!0,this.#v(t.dataTransfer?.files)});let e=this.#d;e.addEventListener("change",()=>{this.#x(null),this.#v(e.files),e.value=""})}connectedCallback(){queueMicrotask(()=>{if(!this.isConnected||this.viewer)return;let e=this.getAttribute("poster")?.replace(/[\x22\\\n]/g,encodeURIComponent);e&&(this.style.background=`center / cover no-repeat url("${e}")`),this.getAttribute("loading")==="lazy"?this.#p.observe(this):this.#h()})}#h(e=this.getAttribute("renderer")??"auto"){this.#p.disconnect(),this.#w("buttons").hidden=this.hasAttribute("noui"),this.#e.querySelector("[data-act=full]").hidden=!document.fullscreenEnabled;let t=this.#e.querySelector("canvas"),s=this.getAttribute("variant"),[n,r]=["floats","strips"].map(l=>!!s?.includes(l)),i=Number(this.getAttribute("levels"));this.viewer=new ft(t,this,{variant:s===null?null:{floats:n,strips:r},levels:i>=.6&&i<=100?i:0}),t.setAttribute("aria-label",`${this.getAttribute("alt")??"3D scene"}. Press H for the keys.`),t.classList.toggle("polite",this.hasAttribute("polite"));for(let l of Ln)this.#_(l);this.#f=this.viewer.begin(e),this.#u=!1,this.#f.then(l=>this.#u=!l);let a=this.#n??this.getAttribute("src"),c=this.#s===void 0?this.getAttribute("compare"):this.#s;a&&this.open(a),c&&this.compare(c)}disconnectedCallback(){this.#p.disconnect(),this.#m()}#m(){this.viewer?.destroy(),this.viewer=null,this.#T(),this.#o=new me;let e=this.#e.querySelector("canvas");e?.classList.remove("drawn"),e?.replaceWith(e.cloneNode())}attributeChangedCallback(e,t,s){e==="src"&&(this.#n=null),e==="compare"&&(this.#s=void 0),!(!this.viewer||s===t)&&(e==="compare"?this.compare(s||null):e!=="src"?this.#_(e):s&&this.open(s))}async open(e){this.#n=e,this.#i=this.#r,await this.#A(0,e,(t,s)=>t.load(s))}async compare(e){this.#s=e,this.#i=!1,this.#r=e===On;let t=this.#r?this.#n:e;this.viewer?.endComparison(),this.#T(),this.#o.begin(1),this.#S(),t!==null&&await this.#A(1,t,(s,n)=>{this.#T();let r=document.createElement("canvas");r.className="over",r.setAttribute("aria-hidden","true"),this.#w("split").before(r),this.#t=new Fe(this.#w("split"),r),s.compare(r,n,this.#r)})}act(e){let t=this.viewer;if(t){if(e==="reset"||e==="view")t.turning=!1,t.reset(e==="view"?++this.#l:void 0);else if(e==="help"||e==="settings")this.#x(e);else if(e==="stats")t.timed=this.#E("stats");else if(e==="own")t.background=null;else if(e==="mode"){let s=t.mode==="fly";t.mode=s?"orbit":"fly",this.#g(`Dragging ${s?"rotates the scene":"looks around"}.`,!0)}else e==="picture"?this.#k():e==="open"?this.#d.click():e==="copy"?this.#y():e==="share"?navigator.share?.({text:this.#b}).catch(()=>{}):e==="full"?document.fullscreenElement?document.exitFullscreen():this.requestFullscreen?.().catch(()=>{}):e==="close"&&(this.#w("message").hidden=!0,this.#x(null));ys(this.#w("settings"),t,!this.#w("stats").hidden),t.redraw()}}progress(e,t){this.#o.note(e,{share:t,state:"loading"}),this.#S()}loaded(e,t,s){this.#o.note(e,{share:1,state:"loaded"}),this.#S(),e!==1&&(this.#i&&this.compare(On),this.#g(`${this.viewer?.count.toLocaleString("en")} Gaussians loaded.`),this.dispatchEvent(new CustomEvent("load",{detail:{milliseconds:t,bytes:s}})))}failed(e,t,s=!1){this.#o.fail(e,t,s),e===0&&(this.#i=!1),this.#S(),this.#w("message").hidden=!1,e===0&&(this.#n=this.viewer?.source??this.#n),this.#e.querySelector(".message [data-act=open]").hidden=!!this.viewer?.count,this.dispatchEvent(new CustomEvent("error",{detail:{sentence:t}}))}broken(e,t){let s=this.viewer;if(!s||s.device.renderer==="WebGL2"||this.getAttribute("renderer")==="webgpu"){this.failed(e,t);return}console.warn(`WebGL2 takes over: ${t}`),this.#m(),this.#h("webgl"),Object.assign(this.viewer,s.choices),s.count&&this.viewer?.place(s.pose)}report(e){let t=JSON.stringify(e,null,1),s=this.#w("report");s.querySelector("textarea").value=t;let n=e.scenes,r=n.some(a=>a.interrupted),i=n.map(({cold:a,steady:c})=>`${a.fps} frames/s cold, ${c.fps} steady`).join(" | ");s.querySelector("h2").textContent=r?"The page was hidden during the measurement: measure again":i,s.querySelector("[data-act=share]").hidden=!navigator.share,s.hidden&&this.#x("report"),this.dispatchEvent(new CustomEvent("report",{detail:e}))}drawn(e){this.#e.querySelector("canvas")?.classList.add("drawn"),e.compared&&this.#w("split").hidden&&this.#t?.show(this.#o.names),this.dispatchEvent(new CustomEvent("frame",{detail:e}));let t=this.#w("stats");if(t.hidden)return;e.milliseconds&&(this.#c=[...this.#c.slice(-29),e.milliseconds]);let s=this.#c.reduce((i,a)=>i+a,0)/this.#c.length,n=[e.count,e.compared].filter((i,a)=>a===0||i),r=[`${e.renderer}, ${e.width} x ${e.height}`,`${n.map(i=>i.toLocaleString("en")).join(" | ")} Gaussians`,this.#c.length?`${(1e3/s).toFixed(0)} frames/s, ${s.toFixed(1)} ms`:"still",...Object.entries(e.passes??{}).map(([i,a])=>`${i} ${a.toFixed(2)} ms`)];t.textContent=r.join(`
`)}#g(e,t=!1){let s=this.#w("said");s.textContent=e,s.classList.toggle("seen",t),setTimeout(()=>s.classList.remove("seen"),Pr)}get#b(){let e=this.#e.querySelector("textarea");return e.focus(),e.select(),e.value}async#y(){let e=this.#b,t=navigator.clipboard?await navigator.clipboard.writeText(e).then(()=>!0,()=>!1):document.execCommand("copy");this.#w("copied").textContent=t?"Copied.":"This browser does not allow copying: the text is selected, press Ctrl+C."}get#d(){return this.#e.querySelector("[type=file]")}#v(e){let[t,s]=e??[];t&&this.open(t),s&&this.compare(s)}async#k(){let e=await this.viewer?.screenshot(this.#t?.share);if(!e)return;let t=document.createElement("a");Object.assign(t,{href:URL.createObjectURL(e),download:"scene.png"}).click(),setTimeout(()=>URL.revokeObjectURL(t.href),1e3)}#E(e,t){let s=this.#w(e);return s.hidden=t===void 0?!s.hidden:!t,this.#e.querySelector(`[data-act=${e}]`)?.setAttribute("aria-expanded",String(!s.hidden)),!s.hidden}#x(e){Rn.every(s=>this.#w(s).hidden)&&(this.#a=this.#e.activeElement);let t=e!==null&&this.#w(e).hidden;for(let s of Rn)this.#E(s,t&&s===e);t?this.#w(e).focus():(this.#a??this.#e.querySelector("canvas"))?.focus({preventScroll:!0})}#_(e){let t=this.viewer,s=this.getAttribute(e),n=Number(s);e==="scale"?t.scale=n>0&&n<=1?n:null:e==="fov"?t.fov=n>=1&&n<=150?n:null:e==="background"?t.background=Ue(s):t.turning=s!==null&&!matchMedia(Gr).matches,t.redraw()}async#A(e,t,s){let n=this.viewer;if(n===null||this.#u)return;let r=this.#s;if(e===1&&(!await this.#f||n!==this.viewer||r!==this.#s))return;let i=typeof t=="string"?t.replace(/[?#].*$/,""):"scene",a=t instanceof File?t.name:i;this.#o.begin(e,e===1&&this.#r?`${a}, sorted`:a),this.#S();try{let c=t instanceof Blob?{file:t}:{url:new URL(t,document.baseURI).href};s(n,c)}catch(c){this.failed(e,`the scene cannot be opened: ${c.message}`)}}#S(){let{state:e,busy:t,share:s,sentence:n,names:r}=this.#o,i=this.#w("bar");i.hidden=!t,i.classList.toggle("unknown",Number.isNaN(s));let a=Math.min(100,Math.round(100*s))||0;i.setAttribute("aria-valuenow",String(a)),i.firstElementChild.style.width=`${a}%`;let c=this.#w("message"),l=c.querySelector("p");l.textContent!==n&&(l.textContent=n),n||(c.hidden=!0),this.#w("split").hidden||this.#t?.show(r),e&&(this.dataset.state=e)}#T(){this.#w("split").hidden=!0,this.#e.querySelector(".over")?.remove(),this.#t=null}#w(e){return this.#e.querySelector(`.${e}`)}};globalThis.customElements?.define("mobile-gs",Qt);var v=128,qr=1e-12,zn=new Float32Array(0),ht=class{wasmMemory=null;#e=[];#t=0;#o=null;#n;constructor(e=!1){this.#n=e}block(e){return this.#s(e,v*e,null)}part({at:e},t,s){let n={at:e+4*v*t,width:s,numbers:zn};return this.#e.push([n,null,v*s]),n}layer(e,t,s){let n=s?s.length:e.length/t,r=Math.ceil(n/4)*4,i=new Float32Array(r*t);for(let l=0;l<n;l++){let f=(l-l%4)*t+l%4;for(let h=0;h<t;h++)i[f+4*h]=e[l*t+h]}let a=new Float32Array(r);s&&a.set(s);let c=l=>this.#s(0,l.length,l);return{inputs:t,outputs:r,weights:c(i),offsets:c(a)}}#s(e,t,s){let n={at:this.#t,width:e,numbers:zn};return this.#e.push([n,s,t]),this.#t+=16*Math.ceil(t/4),n}allocate(){this.wasmMemory=Ce(this.#t);let e=this.wasmMemory?.buffer??new ArrayBuffer(this.#t);for(let[t,s,n]of this.#e.splice(0))t.numbers=new Float32Array(e,t.at,n),s&&t.numbers.set(s);this.#o=this.#n?null:ie(this.wasmMemory)}apply({inputs:e,outputs:t,weights:s,offsets:n},r,i,a){if(this.#o){this.#o.layer(s.at,n.at,r.at,i.at,e,t,a);return}let[c,l,f,h]=[r,i,s,n].map(({numbers:d})=>d);for(let d=0;d<t;d++){let p=(d-d%4)*e+d%4;for(let u=0;u<v;u++){let w=h[d];for(let m=0;m<e;m++)w+=f[p+4*m]*c[m*v+u];l[d*v+u]=Math.max(w,a*w)}}}units({at:e,width:t,numbers:s},{at:n,numbers:r}){if(this.#o){this.#o.units(e,n,t);return}for(let i=0;i<v;i++){let a=0;for(let l=i;l<v*t;l+=v)a+=s[l]*s[l];let c=1/Math.max(Math.sqrt(a),qr);for(let l=i;l<v*t;l+=v)r[l]=s[l]*c}}};var Hr=80;function Un(o){let e=0;for(let{count:t,size:s,length:n}of o.values())e+=t*s*n;return e}function Fn(o,e){let t=0,s=new Map;for(let[n,{count:r,size:i,length:a}]of e){let c=()=>o.subarray(t,t+=i*a);s.set(n,{length:a,books:Array.from({length:r},c)})}if(s.get("scale")?.books.some(n=>n.some(r=>r>Hr)))throw new x("the codebooks of the .mgs file hold scales that are out of range");return s}function In(o){return new Map([...o].map(([e,{step:t,columns:s}])=>{let n=s.map(({least:r,size:i})=>Float32Array.from({length:i},(a,c)=>(r+c)*t));return[e,{length:1,books:n,middles:s.map(({least:r,middle:i})=>i-r)}]}))}function Nn({name:o,codec:e,data:t},s,n){if(e==="rans")return Q(t,s,n);let r=32-Math.clz32(n-1),i=re(t,r*s),a=new Uint16Array(s);for(let c=0;c<s;c++){let l=i.take(r);if(l>=n)throw new x(`the stream '${o}' points outside of its codebook`);a[c]=l}return a}function Se({length:o,books:e,middles:t}){let s=new Uint16Array(v);return{length:o,books:e.map((n,r)=>t?n.subarray(t[r],t[r]+1):Wr(n,o)),columns:e.map(()=>s)}}function Wr(o,e){let t=new Float64Array(e);for(let s=0;s<o.length;s++)t[s%e]+=o[s]*e/o.length;return Float32Array.from(t)}function B({length:o,books:e,columns:t},s,n,r,i){for(let a=0;a<e.length;a++){let c=e[a],l=t[a],f=a*o*n;if(o===1){for(let h=r;h<i;h++)s[f++]=c[l[h]];continue}for(let h=0;h<o;h++,f=(a*o+h)*n)for(let d=r;d<i;d++)s[f++]=c[l[d]*o+h]}}var Vr=[53,210,405,600,787,970,1151,1329],jr=Uint8Array.from({length:1330},(o,e)=>Vr.filter(t=>t<=e).length),Jt=Float64Array.from({length:512},(o,e)=>(e+.5)/2**(31-Math.clz32(e))-1.5),Xr=2.5,Zt=(o,e)=>jr[Math.min(256*Math.abs(Math.fround(o-e)),1329)|0];function Cn(o,e,t){let[s,n,r]=t,i=s.length,a=[new Uint16Array(i),new Uint16Array(i),new Uint16Array(i)],[c,l,f]=a,[h,d,p]=e,u=new K(o),w=0;for(let m=0;m<i;m++){let b=h[s[m]],E=d[n[m]],k=p[r[m]],y=Zt(E,k),_=Zt(b,k),T=Zt(b,E),z=u.take(y+_+T);c[m]=1<<y|z&(1<<y)-1,l[m]=1<<_|z>>>y&(1<<_)-1,f[m]=1<<T|z>>>y+_,w+=y+_+T}return re(o,w),a}function Bn({step:o,columns:[{least:e},{least:t},{least:s}]},n,r,i,a){let[c,l,f,h,d,p]=n;for(let u=r,w=0;u<i;u++,w++){let m=o*(c[u]+e+Jt[h[u]]),b=o*(l[u]+t+Jt[d[u]]),E=o*(f[u]+s+Jt[p[u]]),k=(m*m+b*b+E*E)/4,y=1+k*(-1/2+k*(1/24+k*(-1/720+k*(1/40320+k*(-1/3628800+k*(1/479001600-k/87178291200)))))),_=1/2+k*(-1/12+k*(1/240+k*(-1/10080+k*(1/725760+k*(-1/79833600+k/12454041600)))));if(k>Xr){let T=Math.sqrt(k);y=Math.cos(T),_=Math.sin(T)/(2*T)}a[w]=y,a[w+v]=_*m,a[w+2*v]=_*b,a[w+3*v]=_*E}}var Kr=256,Dn=["raw","halves","planes"],Yr=["bits","rans"],Pn=[["scale","rotation"],["appearance","opacity"],["lobes"]],ts=Pn.length,Te=2,es=class{positions=null;columns=new Map;#e;constructor(e,t){this.#e=e,this.count=t}get stage(){let e=Pn.findIndex(t=>!t.every(s=>this.#t(s)));return e<0?ts:e}rows(e,t,s="slice"){let n=[...this.columns].filter(([i])=>this.#t(i)).map(([i,a])=>[i,a.map(c=>c[s](e,t))]);return{positions:this.positions[s](3*e,3*t),columns:Object.fromEntries(n)}}#t(e){let{cuts:t,scalars:s}=this.#e,n=s.size&&e==="rotation"?3:0,r=(t.get(e)?.count??s.get(e)?.columns.length??0)+n;return Object.keys(this.columns.get(e)??[]).length===r}},dt=class{levels;network=null;#e;#t;#o=new Map;#n=new Map;#s=new Map;#r={};#i={};constructor(e,t){this.#e=e,this.#t=t;let{network:s,lobes:n,cuts:r,scalars:i,lodSizes:a}=e;s&&this.#l("view-network",Ks,f=>this.network=f),n&&this.#l("lobe-decoder",Ys(n),f=>this.#r=f),this.#l(...Xs(e),f=>this.#i=f),i.size?this.#s=In(i):this.#c("codebooks",Dn,[],f=>{this.#s=Fn(zt(f,Un(r)),r)});let c=[...this.#o.keys()],l=0;this.levels=a.map((f,h)=>(l+=f,this.#a(f,h?`@${h}`:"",c,l)))}#a(e,t,s,n){let{cuts:r,scalars:i}=this.#e,a=new es(this.#e,e),[c,...l]=["positions","scale.0","scale.1","scale.2"].map(d=>d+t),f=(d,p)=>{let u=[];a.columns.set(d,u);for(let[w,m]of p.entries())this.#c(`${d}.${w}${t}`,Yr,[c],b=>{u[w]=Nn(b,e,m)})},h=({data:d})=>{a.positions=Ns(d,e)};this.#c(c,["morton-class"],s,h,n);for(let[d,{count:p,size:u}]of r)f(d,Array(p).fill(u));for(let[d,{columns:p}]of i)f(d,p.map(({size:u})=>u));if(i.size){let[d,p]=["scale","rotation"].map(u=>a.columns.get(u)??[]);this.#c(`rotation-finer${t}`,["bits"],[c,...l],({data:u})=>{let{books:w}=this.#s.get("scale");Cn(u,w,d).forEach((m,b)=>p[3+b]=m)})}return a}accept(e){this.#o.has(e.name)&&this.#n.set(e.name,e)}step(e){for(let[t,{after:s,minBytes:n,read:r}]of this.#o){let i=this.#n.get(t);if(!(i===void 0||e<n||s.some(a=>this.#o.has(a))))return r(i),this.#o.delete(t),this.#n.delete(t),!0}return!1}get decoderInputs(){let[{count:e,positions:t}]=this.levels,s=t,n=Math.min(e,Kr),r=new Uint16Array(3*n).map((c,l)=>s[3*Math.floor(Math.floor(l/3)*e/n)+l%3]),[i,a]=[this.#e,this.#s];return{header:i,books:a,appearance:this.#i,lobes:this.#r,samples:r}}#c(e,t,s,n,r=0){let i=this.#t.find(a=>a.name===e);if(i===void 0)throw new x(`the .mgs file lacks its stream '${e}'`);if(!t.includes(i.codec))throw new x(`the stream '${e}' of the .mgs file uses the codec '${i.codec}', which this program does not know`);this.#o.set(e,{after:s,minBytes:r,read:n})}#l(e,t,s){this.#c(e,Dn,[],n=>s(Js(zt(n,Qs(t)),t)))}};var F=new Int32Array(2048);for(let o=0;o<F.length;o++){let e=o<256?o:F[o-256];for(let t=0;t<8;t++)e=(e&1?3988292384:0)^e>>>1;F[o]=e}function ut(o,e=0){let t=~e,s=0;for(;s+8<=o.length;s+=8)t^=o[s]|o[s+1]<<8|o[s+2]<<16|o[s+3]<<24,t=F[1792+(t&255)]^F[1536+(t>>>8&255)]^F[1280+(t>>>16&255)]^F[1024+(t>>>24)]^F[768+o[s+4]]^F[512+o[s+5]]^F[256+o[s+6]]^F[o[s+7]];for(;s<o.length;s++)t=F[(t^o[s])&255]^t>>>8;return~t>>>0}var de=[77,71,83,26,13,10,0,1],ss=[2,3,4],pt=20,Qr=2**20,Jr=256,Zr=2**32,ei=[["ply","a PLY scene: train or compress it first"],["PK","a zip archive (perhaps .sog)"],["\x8B","a gzip file (perhaps .spz)"],["NGSP","an .spz scene"],["glTF","a binary glTF file"],["\xFD7zXZ","an xz file (perhaps another program's comp.xz)"],["\x89PNG","a PNG picture"],["\xFF\xD8\xFF","a JPEG picture"],["<","a web page"],["{","a JSON text"]],wt=class{received=0;total=1/0;fields=null;table=[];#e=[];#t=0;#o=0;#n=!1;#s=null;append(e){if(e.length>0&&this.#e.push(e),this.received+=e.length,this.#t+=e.length,!this.#r())return[];if(this.received>this.total)throw new x(`the .mgs file has ${this.received-this.total} bytes too many at its end`);let t=[];for(let s;(s=this.table[this.#o])&&ns(s.bytes)<=this.#t;)this.#o++,t.push(ti(s,this.#a(ns(s.bytes))));return t}end(){if(this.fields!==null){let t=this.table[this.#o];if(t===void 0)return;throw new x(`the .mgs file ends inside its stream '${t.name}': it has been cut short`)}if(!this.#n)throw new x($n(this.#a(this.#t)));let e=this.#s===null?"first bytes":"header";throw new x(`the .mgs file ends inside its ${e}: it has been cut short`)}#r(){if(!this.#n&&this.#t>=de.length){let e=this.#a(de.length);if(de.some((t,s)=>t!==e[s]))throw new x($n(e));this.#n=!0}if(this.#n&&this.#s===null&&this.#t>=pt-de.length&&(this.#s=this.#a(pt-de.length)),this.#s!==null&&this.fields===null){let e=si(this.#s);this.#t>=e&&this.#i(this.#s,this.#a(e))}return this.fields!==null}#i(e,t){let s=P(e).getUint32(8,!0);if((pt+t.length)%8||ut(t,ut(e.subarray(0,8)))!==s)throw new x("the header of the .mgs file is damaged (wrong checksum)");this.fields=ni(t);let n=P(e).getUint16(0,!0);if((n===2||n===4&&this.fields.layers===void 0)&&(this.fields.layers=[this.fields.count]),n<4&&(this.fields.footprint=We),this.table=oi(this.fields.streams),this.total=this.table.reduce((r,i)=>r+ns(i.bytes),pt+t.length),this.total>Zr)throw new x(`the .mgs file claims ${this.total} bytes, too many for a scene`)}#a(e){this.#t-=e;let t=this.#e[0];if(t!==void 0&&t.length>e)return this.#e[0]=t.subarray(e),t.subarray(0,e);let s=new Uint8Array(e),n=0,r=0;for(;n<e;){let i=this.#e[r],a=i.subarray(0,e-n);s.set(a,n),n+=a.length,a.length<i.length?this.#e[r]=i.subarray(a.length):r++}return this.#e.splice(0,r),s}};function ns(o){return Math.ceil(o/8)*8}function ti(o,e){let t=e.subarray(0,o.bytes);if(ut(t)!==o.crc32)throw new x(`the stream '${o.name}' of the .mgs file is damaged (wrong checksum)`);if(e.subarray(o.bytes).some(s=>s!==0))throw new x(`the .mgs file is damaged after its stream '${o.name}'`);return{name:o.name,codec:o.codec,data:t}}function si(o){let e=P(o),t=e.getUint16(0,!0),s=e.getUint32(4,!0);if(!ss.includes(t))throw new x(`the .mgs file is of version ${t}.${e.getUint16(2,!0)}, this program reads ${ss[0]}.x to ${ss[2]}.x: reload the page, or write the file again with this version of mobilegs`);if(s>Qr)throw new x(`the header of the .mgs file claims ${s} bytes: it is damaged`);return s}function ni(o){let e;try{e=JSON.parse(new TextDecoder("utf-8",{fatal:!0,ignoreBOM:!0}).decode(o))}catch{throw new x("the header of the .mgs file is not valid JSON")}if(typeof e!="object"||e===null||Array.isArray(e))throw new x("the header of the .mgs file is not a JSON object");return e}function oi(o){if(!Array.isArray(o)||o.length>Jr)throw new x("the header of the .mgs file lacks a table of streams");let e=new Set;return o.map(t=>{let{name:s,codec:n,bytes:r,crc32:i}=Object(t);if(!([s,n].every(c=>qe(c,64))&&[r,i].every(c=>Number.isInteger(c)&&c>=0&&c<2**40)))throw new x("the header of the .mgs file has a broken table of streams");if(e.has(s))throw new x(`the .mgs file has two streams called '${s}'`);return e.add(s),{name:s,codec:n,bytes:r,crc32:i}})}function $n(o){if(o.length===0)return"the file is empty, not a .mgs scene";if(de.findIndex((n,r)=>n!==o[r])>=Math.min(3,o.length))return"the first bytes of the .mgs file are damaged: transfer it again, in binary mode";let t=String.fromCharCode(...o),s=ei.find(([n])=>t.startsWith(n));return s?`this is not a .mgs scene but looks like ${s[1]}`:"this is not a .mgs scene"}var os=class{header=null;decoder=null;#e=new wt;get received(){return this.#e.received}get total(){return this.#e.total}append(e){let t=this.#e.append(e),{fields:s,table:n,total:r}=this.#e;s!==null&&this.decoder===null&&(this.header=on(s,r),this.decoder=new dt(this.header,n));for(let i of t)this.decoder?.accept(i)}end(){this.#e.end()}step(){return this.decoder?.step(this.received)??!1}};async function Gn(o,e){let t=new os,s=o.getReader();try{for(let n=0;;){n-=performance.now();let{value:r,done:i}=await s.read();if(n+=performance.now(),i)break;t.append(r);do await e(t,n);while(t.step())}}catch(n){throw await s.cancel().catch(()=>{}),n}return t.end(),t}var cs=16,rs=6*cs,$=64,mt=13,is=.01,as=6,qn=15,{fround:I,sqrt:ri}=Math,gt=class{#e;#t;#o;#n;constructor(e,t,{static2:s,view2:n}){let r=3+n.length/9,i=new Float32Array(12*r);for(let a=0;a<12;a++){let c=a<3?s.subarray(3*a,3*a+3):n.subarray((a-3)*(r-3));i.set(c.subarray(0,r-3),a*r+(a<3?0:3))}this.#e=e,this.#t=e.block(r),this.#o=e.layer(i,r),this.#n=t}decode(e,t,s){B(t,this.#t.numbers,v,s,s+e.length/3),this.#e.apply(this.#o,this.#t,this.#n,1)}},bt=class{#e;#t;#o;#n;#s;#r;#i;constructor(e,t,{both1:s,static2:n,view2:r}){this.#e=e,this.#t=[e.layer(s,as),e.layer(n,$),e.layer(r,$)],this.#o=e.block(as),this.#n=e.block(2*$),this.#s=[e.part(this.#n,0,$),e.part(this.#n,$,$)],this.#r=t,this.#i=e.part(t,3,12)}decode(e,t,s){let n=this.#e,[r,i,a]=this.#t;B(t,this.#o.numbers,v,s,s+e.length/3),n.apply(r,this.#o,this.#n,is),n.apply(i,this.#s[0],this.#r,1),n.apply(a,this.#s[1],this.#i,1)}},vt=class{#e;#t;#o;#n;#s;#r;#i;#a;#c;#l;constructor(e,t,{context1:s,context2:n,static1:r,static2:i,view1:a,view2:c},l){this.#e=e,this.#t=[e.layer(s,rs),e.layer(n,$),e.layer(r,mt+3),e.layer(i,$),e.layer(a,mt+3),e.layer(c,$)],this.#l=2**l,this.#o=e.block(as),this.#n=e.block(rs),this.#s=e.block($),this.#r=e.block(mt+3),this.#i=e.part(this.#r,mt,3),this.#a=t,this.#c=e.part(t,3,12)}decode(e,t,s){let n=this.#e,[r,i,a,c,l,f]=this.#t,[h,d]=[this.#o.numbers,this.#i.numbers],[p,u,w]=[this.#n,this.#s,this.#r];this.#u(e,p.numbers),n.apply(r,p,u,0),n.apply(i,u,w,1),B(t,h,v,s,s+e.length/3),d.set(h.subarray(0,3*v)),n.apply(a,w,u,is),n.apply(c,u,this.#a,1),d.set(h.subarray(3*v)),n.apply(l,w,u,is),n.apply(f,u,this.#c,1)}#f(e,t){let s=U(e[t])*this.#l,n=U(e[t+1])*this.#l,r=U(e[t+2])*this.#l,i=I(I(I(s*s)+I(n*n))+I(r*r));return Math.max(1,I(ri(i)))}#u(e,t){for(let s=0,n=0;n<e.length;s++,n+=3){let r=this.#f(e,n),i=I(2-I(1/r));for(let a=0;a<3;a++){let c=U(e[n+a])*this.#l,l=I(i*I(c/r));ii(l,t,a*cs*v+s)}}}};function ii(o,e,t){let s=I(I(o*.25)+.5),n=Math.sin(Math.PI*s),r=Math.cos(Math.PI*s);for(let i=t+cs*v;t<i;t+=v){e[t]=n,e[t+rs/2*v]=r;let a=2*n*r;r=1-2*n*n,n=a}}var xt=.28209479177387814,yt=class{#e;#t;#o;#n;#s;#r;#i;constructor(e,t,s,{degree:n,latents:r,hidden:i},a){let c=2*(n+1)**2,l=i.at(-1)??0,f=[19+r,...i];this.#e=e,this.#o=s,this.#t=i.map((u,w)=>e.layer(a[`weights.${w}`],f[w],a[`offsets.${w}`]));let h=a[`weights.${i.length}`],d=ai(h,l,a.basis,r,c);this.#t.push(e.layer(d,l+r,a.bias)),this.#n=e.block(r);let p=i.length?[19,...i]:[0];this.#s=p.map(u=>e.block(Math.ceil(u/4)*4+r)),this.#r=[0,p.length-1].map(u=>e.part(this.#s[u],p[u],r)),this.#i=i.length?new le(e,t,this.#s[0]):null}decode(e,t,s){let[n,r,i]=[this.#e,this.#s,this.#t.length-1];this.#i?.write(),e&&B(e,this.#n.numbers,v,t,s),this.#r[0].numbers.set(this.#n.numbers);for(let a=0;a<i;a++)n.apply(this.#t[a],r[a],r[a+1],0);this.#r[1].numbers.set(this.#n.numbers),n.apply(this.#t[i],r[i],this.#o,1)}};function ai(o,e,t,s,n){let r=e+s,i=new Float32Array(n*r);for(let a=0;a<n;a++){for(let c=0;c<e;c++)i[a*r+c]=o[a*e+c];for(let c=0;c<s;c++)i[a*r+e+c]=t[c*n+a]}return i}function Me(o,e){for(let t=0;t<e.length;t++)o.fill(e[t],t*v,(t+1)*v)}var ci=1/3,li=[1,0,0,0],ue=class{#e;#t=new ht;#o;#n;#s;#r;#i;#a;#c;#l;#f;constructor(e){let{header:t,samples:s}=e,{lobes:n,grid:r}=t,i=this.#t;this.#e=e;let a=n?.degree??0,c=i.block(qn),l={logScales:i.block(3),scales:i.block(3),quats:i.block(4),sh:i.part(c,0,12),lobes:i.block(2*(a+1)**2+2),statics:i.block(t.network?19:0),words:i.block(18)};this.#o=l.quats,this.#s=n&&new yt(i,l,l.lobes,n,e.lobes),this.#r=t.network?new le(i,l,l.statics):null;let{appearance:f}=e;t.colors==="linear"?this.#n=new gt(i,c,f):t.colors==="latent_networks"?this.#n=new bt(i,c,f):this.#n=new vt(i,c,f,r.exponent),i.allocate(),this.#c=Object.fromEntries([...e.books].map(([p,u])=>[p,{...u,columns:[]}])),this.#l=Hn(this.#h("scale")),this.#f=Hn(Se(this.#h("scale")));let h=Object.fromEntries(Object.entries(l).map(([p,{numbers:u}])=>[p,u])),d=hi(this.#l);this.#i={...h,count:0,lobeDegree:a,scaleRange:d,memory:i.wasmMemory},this.#a={sh:this.#u(s),lobes:[0,1/xt]},this.#s&&(this.#a.lobes=this.#p(this.#s))}#u(e){let{sh:t}=this.#i,s=new Float64Array(12),n=Se(this.#h("appearance"));for(let r=0;r<e.length;r+=3*v){let i=e.subarray(r,r+3*v);this.#n.decode(i,n,0);for(let a=0;a<12;a++)for(let c=0;3*c<i.length;c++)s[a]+=3*t[a*v+c]/e.length}return s}#p(e){let{scales:t,quats:s,sh:n,lobes:r}=this.#i,i=this.#c.lobes;return B(this.#f,t,v,0,v),Me(s,li),Me(n,this.#a.sh),e.decode(i?Se(i):null,0,v),Array.from({length:r.length/v-2},(a,c)=>r[c*v])}decode({positions:e,columns:t},s=0){let{header:n}=this.#e,r=e.subarray(3*s,3*(s+v)),i=r.length/3,a=s+i,[c,l]=[this.#i,this.#c];c.count=i,c.positions=r;let{logScales:f,scales:h,quats:d,sh:p,lobes:u}=c,{scale:w,rotation:m,appearance:b}=t,E=!0;for(let y of Object.keys(l)){let _=t[y];_?this.#h(y).columns=_:E=!1}this.#l.columns=w,B(this.#h("scale"),f,v,s,a),B(this.#l,h,v,s,a);let k=n.scalars.get("rotation");if(k?Bn(k,m,s,a,d):(B(this.#h("rotation"),d,v,s,a),this.#t.units(this.#o,this.#o)),b?this.#n.decode(r,this.#h("appearance"),s):Me(p,this.#a.sh),this.#s&&E?this.#s.decode(l.lobes??null,s,a):Me(u,this.#a.lobes),l.opacity){let{books:[y]}=t.opacity?l.opacity:Se(l.opacity),_=t.opacity?.[0];fi(u,y,_,s,i)}return this.#r?.write(),c}get network(){return this.#r!==null}get lobeDegree(){return this.#i.lobeDegree}get scaleRange(){return this.#i.scaleRange}get neutral(){let e=[0,1,2].map(r=>.5+xt*this.#a.sh[r]),[t,s,n]=this.#f.books.map(([r])=>r);return{color:e,side:ci*Math.cbrt(t*s*n)}}#h(e){return this.#c[e]}};function fi(o,e,t,s,n){for(let r=0;r<n;r++)o[r]+=e[t?t[s+r]:0]/xt}function Hn(o){return{...o,books:o.books.map(e=>e.map(Math.exp))}}function hi({books:o}){let e=[1/0,-1/0];for(let t of o)for(let s of t)e=[Math.min(e[0],s),Math.max(e[1],s)];return e}var{fround:O}=Math,di=["mobile_gs","no_depth","no_scale","sort_free_gs"],ui=q(-1e4),pi=[2047,2047,1023],Wn=O(511/Math.SQRT1_2),Vn=888,Re=new Uint32Array(1),Et=new Float32Array(Re.buffer);function jn({sorted:o,weighting:e,footprint:t,background:s,grid:n,lobes:r},i,a,c=null){let l=r?.degree??0,[f,h]=Kn(a);return{count:i,packing:{center:Array.from(n.center),unit:n.radius*2**n.exponent,leastScaleBits:f,scaleBitsSpan:h},...Xn(c?10:Yn(l),i),network:c&&Vs(c),shSize:4,lobeSize:(l+1)**2,sorted:o,weighting:{index:di.indexOf(e.name),exponentMax:e.exponent_max,sigma:e.sigma,backgroundWeight:e.background_weight,alphaMin:e.alpha_min},footprint:t,background:Array.from(s)}}function kt(o,e,t=Xn(ls(o),e.positions.length/3)){let s=e.positions.length/3,n=ls(o),r=4*v,i;for(let a=0;a<s;a+=v){let c=o.decode(e,a);i??=wi(c);let l=i();t.shapes.set(l.subarray(0,4*c.count),4*a),t.colors.set(l.subarray(r,r+4*c.count),4*a),t.lobes.set(l.subarray(2*r,2*r+n*c.count),n*a)}return t}var Xn=(o,e)=>({shapes:new Uint32Array(4*e),colors:new Uint32Array(4*e),lobes:new Uint32Array(o*e)});function Kn(o){let[e,t]=o.map(s=>(Et[0]=s,O(Re[0])));return[e,t-e]}var Yn=o=>(o+1)**2+2>>1,ls=({network:o,lobeDegree:e})=>o?10:Yn(e);function wi(o,e=!1){let{scales:t,quats:s,sh:n,lobes:r,lobeDegree:i,statics:a,scaleRange:c,memory:l}=o,{buffer:f,byteOffset:h,length:d}=o.words,p=new Uint32Array(f,h,d),[u,w]=Kn(c),m=w>0?O(1/w):0,b=e?null:ie(l),[E,k,y,_]=[t,s,n,r].map(({byteOffset:oe})=>oe),T=a.length>0,[z,ne]=[(i+1)**2-1,ls({network:T,lobeDegree:i})];return()=>{b?b.pack(E,k,y,_,h,z,ne,u,m):mi(o,p,ne,u,m),T&&gi(a,p);let{count:oe,positions:X}=o;for(let we=0,St=0;we<oe;we++,St+=4)p[St]=X[3*we]|X[3*we+1]<<16,p[St+1]|=X[3*we+2];return p}}function mi({scales:o,quats:e,sh:t,lobes:s,lobeDegree:n},r,i,a,c){let l=2*(n+1)**2;for(let f=0;f<v;f++){let h=8*v+i*f,d=yi(s,f,l,r,h);vi(t,f,r,4*(v+f)),r[4*f+1]=d<<16;let p=0;for(let w=2;w>=0;w--){Et[0]=o[w*v+f];let m=O(O(O(Re[0])-a)*c);p=p<<11|O(O(pi[w]*Math.min(Math.max(m,0),1))+.5)}r[4*f+2]=p;let u=[0,1,2,3].map(w=>e[w*v+f]);r[4*f+3]=bi(u),u.some(Boolean)||(r[h]=ui|r[h]&4294901760)}}function gi(o,e){for(let t=0;t<v;t++){let s=8*v+10*t;e[s]=e[s]&65535|Math.round(32767*o[t])<<16;for(let n=1;n<10;n++){let[r,i]=[2*n-1,2*n].map(a=>Math.round(32767*o[a*v+t]));e[s+n]=r&65535|i<<16}}}function bi(o){let e=0;for(let n=1;n<4;n++)Math.abs(o[n])>Math.abs(o[e])&&(e=n);let t=o[e]<0?-Wn:Wn,s=e;for(let n=0;n<4;n++)n!==e&&(s=s<<10|O(O(t*o[n])+1024.5)&1023);return s}function vi(o,e,t,s){let n=c=>o[c*v+e],r=Array.from({length:9},(c,l)=>n(3+l)),i=Zn(r),a=r.map(c=>Jn(i,c));t[s]=q(n(0))|q(n(1))<<16,t[s+1]=q(n(2))|i<<16|a[0]<<24;for(let c of[1,5])t[s+1+(c+3>>2)]=Qn(a,c)}function yi(o,e,t,s,n){let r=f=>o[f*v+e],i=Array.from({length:t-2},(f,h)=>r(2+h)),[a,c]=[0,1].map(f=>Zn(i.filter((h,d)=>d%2===f))),l=i.map((f,h)=>Jn(h%2?c:a,f));s[n]=q(r(0))|q(r(1))<<16;for(let f=0,h=n+1;f<l.length;f+=4,h++)s[h]=Qn(l,f);return a|c<<8}var Qn=(o,e)=>o[e]|o[e+1]<<8|o[e+2]<<16|o[e+3]<<24;function Jn(o,e){Re[0]=o+Vn<<20;let t=O(O(127/Et[0])*e);return O(Math.min(Math.max(t,-127),127)+512.5)&255}function Zn(o){return Et[0]=Math.max(0,...o.map(Math.abs)),Math.min(Math.max((Re[0]+1048575>>20)-Vn,0),255)}var eo=8192,xi=1e5,Ei=3,ki=2,_i=8,_t=class{results=[];#e=[];#t;#o=null;#n=null;#s=[];#r;#i=null;#a;#c;#l=!1;#f=!1;#u=()=>{};#p=()=>{};#h=new Promise((e,t)=>{this.#u=e,this.#p=t});constructor(e){this.#h.catch(()=>{});let t=0;for(let[s,n]of e.entries()){for(let r=0;r<n;r+=eo)this.#e.push({level:s,from:r,to:Math.min(r+eo,n),first:t+r});t+=n}this.#t=new Uint8Array(e.length),this.#a=new Uint8Array(this.#e.length),this.#c=this.#a.slice(),this.#r=t}set output(e){if(this.#i=e,e!==null)for(let[t,s]of this.results.splice(0))so(s,to(e,this.#r,t,t+s.shapes.length/4))}spawn(){let{decoderInputs:e}=this.#o,t=this.#r<xi?1:navigator.hardwareConcurrency;for(let s=1;s<Math.min(t,Ei+1);s++)this.#m(e)}#m(e){try{let t=Rt();t.postMessage({decoderInputs:e});let s={worker:t,jobs:0};t.onmessage=({data:n})=>{s.jobs--,this.#x(n),this.#k(s)},t.onerror=n=>n.preventDefault(),this.#s.push(s)}catch{}}start(e){return this.#o=e,this.#n=new ue(e.decoderInputs)}advance(e,t){if(!(t<=this.#t[e])){this.#t[e]=t;for(let s of this.#s)this.#k(s);this.#E().catch(this.#p)}}finish(){return this.#f=!0,this.#_(),this.#h}terminate(){for(let{worker:e}of this.#s)e.terminate()}get#g(){return this.#a.findIndex((e,t)=>e<this.#y(t))}get#b(){let e=this.#g;return e<0?this.#c.findIndex((t,s)=>t<this.#y(s)):e}#y(e){return this.#t[this.#e[e].level]}#d(e,t){let{levels:s}=this.#o,{level:n,from:r,to:i}=this.#e[e];return s[n].rows(r,i,t)}#v(e){let{first:t,from:s,to:n}=this.#e[e];return this.#i?to(this.#i,this.#r,t,t+n-s):void 0}#k(e){for(let t;e.jobs<ki&&(t=this.#g)>=0;e.jobs++){let s=this.#a[t]=this.#y(t),n=this.#d(t,"slice"),r=[n.positions,...Object.values(n.columns).flat()].map(({buffer:i})=>i);e.worker.postMessage({rows:n,chunk:t,stage:s},{transfer:r})}}async#E(){if(!this.#l){this.#l=!0;for(let e;(e=this.#b)>=0&&this.#n;){let t=this.#a[e]=this.#y(e),s=kt(this.#n,this.#d(e,"subarray"),this.#v(e));this.#x({chunk:e,stage:t,packed:s}),await fs()}this.#l=!1}}#x({chunk:e,stage:t,packed:s}){if(t<=this.#c[e])return;this.#c[e]=t;let n=this.#v(e);n===void 0?this.results.push([this.#e[e].first,s]):n.shapes.buffer!==s.shapes.buffer&&so(s,n),this.#_()}get firstLevelReady(){return this.#e.every(({level:e},t)=>e>0||this.#c[t]>0)}get levels(){let e=this.#c.findIndex(t=>t<Te);return e<0?this.#t.length:this.#e[e].level}#_(){this.#f&&this.#b<0&&this.#u()}};function to(o,e,t,s){let n=r=>{let i=o[r].length/e;return o[r].subarray(i*t,i*s)};return{shapes:n("shapes"),colors:n("colors"),lobes:n("lobes")}}function so(o,e){for(let t of Object.keys(e))e[t].set(o[t])}var no=0;async function fs(){if(performance.now()-no<_i)return;let{port1:o,port2:e}=new MessageChannel;await new Promise(t=>{o.onmessage=()=>{o.close(),t(null)},e.postMessage(null)}),no=performance.now()}var Ai=.28209479177387814,[Si,Ti]=[13.8,-69],Mi=new Map([["char",1],["int8",1],["uchar",1],["uint8",1],["short",2],["int16",2],["ushort",2],["uint16",2],["int",4],["int32",4],["uint",4],["uint32",4],["float",4],["float32",4],["double",8],["float64",8]]),oo=["x","y","z","f_dc_0","f_dc_1","f_dc_2","opacity","scale_0","scale_1"];oo.push("scale_2","rot_0","rot_1","rot_2","rot_3");function ds(o){return o[0]===112&&o[1]===108&&o[2]===121}function ro(o){let{offsets:e,stride:t,rows:s,start:n}=Ri(o),r=new DataView(o.buffer,o.byteOffset+n),i=[...e.keys()].filter(w=>w.startsWith("f_rest_")).length,a=i/3+1;if(![1,4,9,16].includes(a))throw new Error(`the .ply file has ${i} numbers f_rest_*: 0, 9, 24 or 45 were expected`);let c=w=>e.get(w),l=["x","y","z","scale_0","scale_1","scale_2","rot_0","rot_1","rot_2","rot_3"];l.push("opacity","f_dc_0","f_dc_1","f_dc_2");for(let w=0;w+1<a;w++)for(let m=0;m<3;m++)l.push(`f_rest_${m*(a-1)+w}`);let f=l.find(w=>!e.has(w));if(f)throw new Error(`the .ply file has ${i} numbers f_rest_*, but not ${f}`);let h=l.map(c),d=us(s,a),p=new Float32Array(h.length);for(let w=0;w<s;w++){for(let b=0;b<p.length;b++)p[b]=r.getFloat32(w*t+h[b],!0);for(let b=3;b<6;b++)p[b]===-1/0&&(p[b]=Ti);Math.abs(p[10])===1/0&&(p[10]=Math.sign(p[10])*Si);let m=0;for(let b=0;b<p.length;b++)m+=p[b]*0;m===0&&ps(d,p)}let{count:u}=d;return u===s||(d.shapes=d.shapes.slice(0,12*u),d.colors=d.colors.slice(0,3*a*u),d.lobes=d.lobes.slice(0,2*u)),d}function hs(o=""){return`'${o.slice(0,40).replace(/[^\x20-\x7e]/g,"\uFFFD")}'`}function us(o,e){return{count:0,packing:null,shapes:new Float32Array(12*o),colors:new Float32Array(3*e*o),shSize:e,lobes:new Float32Array(2*o),lobeSize:1,sorted:!0,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},background:[0,0,0]}}function ps(o,e){let[t,s,n,r]=[e[6],e[7],e[8],e[9]],i=t*t+s*s+n*n+r*r;if(!(i>0))return;let a=2/i,[c,l,f]=[Math.exp(e[3]),Math.exp(e[4]),Math.exp(e[5])];if(!(c+l+f<1e30&&Math.abs(e[10])<1e30))return;let h=o.count++;o.shapes.set([c*(1-a*(n*n+r*r)),c*a*(s*n+t*r),c*a*(s*r-t*n),e[0],l*a*(s*n-t*r),l*(1-a*(s*s+r*r)),l*a*(n*r+t*s),e[1],f*a*(s*r+t*n),f*a*(n*r-t*s),f*(1-a*(s*s+n*n)),e[2]],12*h),o.lobes[2*h]=e[10]/Ai,o.colors.set(e.subarray(11),3*o.shSize*h)}function Ri(o){let e=new TextDecoder("latin1").decode(o.subarray(0,65536)),t=/\nend_header\r?\n/.exec(e);if(!ds(o)||t===null)throw new Error("this is not a PLY file, or its header is cut off");let s=e.slice(0,t.index).split(/\r?\n/).map(d=>d.trim().split(/\s+/)),n=s.find(d=>d[0]==="format")?.[1];if(n!=="binary_little_endian")throw new Error(`the .ply file is ${hs(n)}: only binary_little_endian is read`);let r=s.findIndex(d=>d[0]==="element"),i=s[r]??[],a=/^\d+$/.test(i[2])?Number(i[2]):NaN;if(i[1]!=="vertex"||!Number.isSafeInteger(a)||a<0)throw new Error("the .ply file does not begin with its vertices, as those of 3DGS do");let c=new Map,l=0;for(let d of s.slice(r+1)){if(d[0]==="element")break;if(d[0]!=="property")continue;let p=Mi.get(d[1]);if(p===void 0)throw new Error(`the .ply file has a property of type ${hs(d[1])}`);if(d.length!==3)throw new Error("the .ply file has a property without a name, or with two");if(c.has(d[2]))throw new Error(`the .ply file has the property ${hs(d[2])} twice`);(d[1]==="float"||d[1]==="float32")&&c.set(d[2],l),l+=p}let f=oo.filter(d=>!c.has(d));if(f.length)throw new Error(`the .ply file is not a Gaussian scene: it lacks ${f.join(", ")} as floats`);let h=t.index+t[0].length;if(h+a*l>o.length)throw new Error(`the .ply file is cut off: ${a} Gaussians were announced`);return{offsets:c,stride:l,rows:a,start:h}}var D="the compressed data is damaged or cut off";var te=class{left;#e;constructor(e){let t=e[e.length-1];if(!t)throw new Error(D);this.#e=e,this.left=8*e.length-1-Math.clz32(t)+24}take(e){return e>24?this.take(e-16)*65536+this.take(16):(this.left-=e,this.#t(this.left,e))}decode(e,{width:t,symbols:s,bits:n}){for(let r=0;r<e.length;r++){let i=this.#t(this.left-t,t);e[r]=s[i],this.left-=n[i]}if(this.left!==0)throw new Error(D)}#t(e,t){let s=this.#e;if(e<0)return e+t>0?this.#t(0,e+t)<<-e:0;let n=e>>3;return(s[n]|s[n+1]<<8|s[n+2]<<16|s[n+3]<<24)>>>(e&7)&(1<<t)-1}};function io(o){let e=new Uint8Array(1);return{accuracy:0,symbols:Uint8Array.of(o),bits:e,bases:new Uint16Array(1)}}function Le(o,e){let t=1<<o,s={accuracy:o,symbols:new Uint8Array(t),bits:new Uint8Array(t),bases:new Uint16Array(t)},n=t;for(let[c,l]of e.entries())l===-1&&(s.symbols[--n]=c);let r=(t>>1)+(t>>3)+3,i=0;for(let[c,l]of e.entries())for(let f=0;f<l;f++){s.symbols[i]=c;do i=i+r&t-1;while(i>=n)}if(i!==0)throw new Error(D);let a=e.map(c=>Math.abs(c));for(let c=0;c<t;c++){let l=a[s.symbols[c]]++,f=o-(31-Math.clz32(l));s.bits[c]=f,s.bases[c]=(l<<f)-t}return s}function ws(o,e,t,s){let n=8*e,r=l=>{let f=n>>3,d=(o[f]|o[f+1]<<8|o[f+2]<<16)>>(n&7)&(1<<l)-1;return n+=l,d},i=5+r(4);if(i>t)throw new Error(D);let a=[];for(let l=1<<i;l>0;){let f=32-Math.clz32(l+1),h=(1<<f)-2-l,d=r(f-1);d>=h&&r(1)&&(d+=(1<<f-1)-h);let p=d-1;l-=Math.abs(p),a.push(p);for(let u=p===0?3:0;u===3;){u=r(2);for(let w=0;w<u;w++)a.push(0)}if(l<0||a.length>s)throw new Error(D)}let c=n+7>>3;if(c>o.length)throw new Error(D);return{table:Le(i,a),end:c}}function ao(o,e){let t=o[e++];if(!(t<128)){let l=t-127,f=e+(l+1>>1);if(!(f<=o.length))throw new Error(D);let h=d=>o[e+(d>>1)]>>(d%2?0:4)&15;return{weights:Array.from({length:l},(d,p)=>h(p)),end:f}}let s=e+t;if(s>o.length)throw new Error(D);let{table:n,end:r}=ws(o.subarray(0,s),e,6,13),i=new te(o.subarray(r,s)),a=[],c=[i.take(n.accuracy),i.take(n.accuracy)];for(let l=0;a.length<255;l^=1){let f=c[l];if(a.push(n.symbols[f]),c[l]=n.bases[f]+i.take(n.bits[f]),i.left<0)return a.push(n.symbols[c[l^1]]),{weights:a,end:s}}throw new Error(D)}function co(o){let e=c=>c>0?1<<c-1:0,t=0;for(let c of o)t+=e(c);let s=32-Math.clz32(t),n=(1<<s)-t;if(t===0||s>11||n&n-1)throw new Error(D);let r=[...o,32-Math.clz32(n)];if(r.length>256)throw new Error(D);let i={width:s,symbols:new Uint8Array(1<<s),bits:new Uint8Array(1<<s)},a=0;for(let c=1;c<=s;c++)for(let[l,f]of r.entries()){if(f!==c)continue;let h=a+e(c);i.symbols.fill(l,a,h),i.bits.fill(s+1-c,a,h),a=h}return i}var Li=4247762216,Oi=25481893,Oe=1<<17,M="the compressed data is damaged or cut off";function ho(o,e){let t=[];for(let s of e)t.push(o),o+=2**s;return{bits:e,bases:t}}var lo=ho(0,[...Array(16).fill(0),1,1,1,1,2,2,3,3,4,6,7,8,9,10,11,12,13,14,15,16]),fo=ho(3,[...Array(32).fill(0),1,1,1,1,2,2,3,3,4,4,5,7,8,9,10,11,12,13,14,15,16]),zi=[{accuracy:9,symbols:36,usual:Le(6,[4,3,2,2,2,2,2,2,2,2,2,2,2,1,1,1,2,2,2,2,2,2,2,2,2,3,2,1,1,1,1,1,-1,-1,-1,-1])},{accuracy:8,symbols:32,usual:Le(5,[1,1,1,1,1,1,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1])},{accuracy:9,symbols:53,usual:Le(6,[1,4,3,2,2,2,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1,-1,-1])}],ms=class{length=0;bytes;#e;constructor(e){this.#e=e,this.bytes=new Uint8Array(Math.min(e,Oe))}reserve(e){let t=this.length+e;if(t>this.#e)throw new Error("the compressed data is longer than announced");if(t<=this.bytes.length)return;let s=new Uint8Array(Math.min(this.#e,Math.max(t,2*this.bytes.length)));s.set(this.bytes.subarray(0,this.length)),this.bytes=s}append(e){this.reserve(e.length),this.bytes.set(e,this.length),this.length+=e.length}fill(e,t){this.reserve(t),this.bytes.fill(e,this.length,this.length+t),this.length+=t}repeat(e,t){if(!(e>0&&e<=this.length))throw new Error(M);this.reserve(t);let{bytes:s}=this,n=this.length+t;if(e>=t)s.copyWithin(this.length,this.length-e,n-e);else for(let r=this.length;r<n;r++)s[r]=s[r-e];this.length=n}};function uo(o,e){let t=new ms(e),s=new DataView(o.buffer,o.byteOffset,o.byteLength),n=0;for(;n<o.length;){if(n+8>o.length)throw new Error(M);let r=s.getUint32(n,!0);if(r>>>4===Oi)n+=8+s.getUint32(n+4,!0);else if(r===Li)n=Ui(o,n+4,t);else throw new Error(M)}if(n!==o.length||t.length!==e)throw new Error(M);return t.bytes}function Ui(o,e,t){let s=o[e++],n=(s&32)!==0;if(n||(e+=1),o.subarray(e,e+=[0,1,2,4][s&3]).some(a=>a))throw new Error("the compressed data needs a dictionary, which is missing");e+=[n?1:0,2,4,8][s>>6];let i={huffman:null,tables:[null,null,null],recent:[1,4,8]};for(let a=!1;!a;){if(e+3>o.length)throw new Error(M);let c=o[e]|o[e+1]<<8|o[e+2]<<16;e+=3,a=(c&1)===1;let l=c>>1&3,f=c>>3,h=l===1?1:f;if(l===3||f>Oe||e+h>o.length)throw new Error(M);l===0?t.append(o.subarray(e,e+f)):l===1?t.fill(o[e],f):Fi(o.subarray(e,e+f),i,t),e+=h}return e+(s&4?4:0)}function Fi(o,e,t){let{literals:s,end:n}=Ci(o,e),r=n,i=o[r++];if(i===void 0)throw new Error(M);if(i===255?(i=o[r]+(o[r+1]<<8)+32512,r+=2):i>127&&(i=(i-128<<8)+o[r++]),i===0){t.append(s);return}let a=o[r++];if(!(i>0)||a===void 0||a&3)throw new Error(M);for(let[c,{accuracy:l,symbols:f,usual:h}]of zi.entries()){let d=a>>6-2*c&3;if(d===0)e.tables[c]=h;else if(d===1){if(!(o[r]<f))throw new Error(M);e.tables[c]=io(o[r++])}else if(d===2){let{table:p,end:u}=ws(o,r,l,f);e.tables[c]=p,r=u}}Ii(new te(o.subarray(r)),i,s,e,t)}function Ii(o,e,t,{tables:s,recent:n},r){let[i,a,c]=s;if(!i||!a||!c)throw new Error(M);let l=o.take(i.accuracy),f=o.take(a.accuracy),h=o.take(c.accuracy),d=0,p=r.length+Oe;for(let u=e;u>0;u--){let w=a.symbols[f],m=c.symbols[h],b=i.symbols[l],E=2**w+o.take(w),k=fo.bases[m]+o.take(fo.bits[m]),y=lo.bases[b]+o.take(lo.bits[b]);if(u>1&&(l=i.bases[l]+o.take(i.bits[l]),h=c.bases[h]+o.take(c.bits[h]),f=a.bases[f]+o.take(a.bits[f])),o.left<0||d+y>t.length)throw new Error(M);if(r.append(t.subarray(d,d+y)),d+=y,r.repeat(Ni(E,y,n),k),r.length>p)throw new Error(M)}if(o.left!==0)throw new Error(M);r.append(t.subarray(d))}function Ni(o,e,t){if(o>3)return t.unshift(o-3),t.pop(),t[0];let s=e===0?o:o-1,n=s<3?t[s]:t[0]-1;return s>0&&(t.splice(Math.min(s,2),1),t.unshift(n)),n}function Ci(o,e){let t=o[0]|o[1]<<8|o[2]<<16,s=o[0]&3,n=o[0]>>2&3;if(s<2){let d=[1,2,1,3][n],p=d===1?o[0]>>3:(t&(d===2?65535:16777215))>>4,u=d+(s===0?p:1);if(p>Oe||!(u<=o.length))throw new Error(M);return s===0?{literals:o.subarray(d,u),end:u}:{literals:new Uint8Array(p).fill(o[d]),end:u}}let r=[3,3,4,5][n],i=[10,10,14,18][n],a=(t>>>0)+(o[3]??0)*2**24+(o[4]??0)*2**32,c=Math.floor(a/16)%2**i,l=Math.floor(a/2**(4+i))%2**i,f=r+l;if(c>Oe||!(f<=o.length))throw new Error(M);let h=r;if(s===2){let{weights:d,end:p}=ao(o.subarray(0,f),h);e.huffman=co(d),h=p}if(e.huffman===null)throw new Error(M);return{literals:Bi(o.subarray(h,f),c,n!==0,e.huffman),end:f}}function Bi(o,e,t,s){let n=new Uint8Array(e);if(!t)return new te(o).decode(n,s),n;if(o.length<6)throw new Error(M);let r=e+3>>2;for(let i=0,a=6;i<4;i++){let c=i<3?o[2*i]|o[2*i+1]<<8:o.length-a;if(a+c>o.length)throw new Error(M);let l=i<3?(i+1)*r:e;if(l>e)throw new Error(M);new te(o.subarray(a,a+c)).decode(n.subarray(i*r,l),s),a+=c}return n}var Di=1347635022,Pi=1e7,At=16,wo=32,mo=[0,3,8,15,24],$i=15,Gi=.15,qi=[-1,-1,1,-1,1,1,-1,1,-1,1,-1,-1,1,-1,1],se="the .spz file is damaged or cut off";function go(o){return o[0]===78&&o[1]===71&&o[2]===83&&o[3]===80||o[0]===31&&o[1]===139}async function bo(o){if(o[0]!==31){let r=vo(o,o.length);return po(r,Wi(r,o))}let{header:e,content:t}=await Hi(o),s=[],n=At;for(let r of gs(e))s.push(t.subarray(n,n+=r));return po(e,s)}function vo(o,e){let t=new DataView(o.buffer,o.byteOffset,o.byteLength);if(o.length<At||t.getUint32(0,!0)!==Di)throw new Error("this is not a .spz file");let s=t.getUint32(4,!0),n=s<4;if(s<1||s>4)throw new Error(`the .spz file has version ${s}: 1 to 4 are read`);if(!n&&o.length<wo)throw new Error(se);let r=t.getUint32(8,!0),[i,a,c,l]=o.subarray(12,16);if(r>Pi)throw new Error(`the .spz file announces ${r} Gaussians, too many to be drawn`);if(r>e)throw new Error(`the .spz file announces ${r} Gaussians in ${e} bytes: it is cut off`);if(i>4||a>24)throw new Error(se);let f=(c&2)!==0;return{version:s,count:r,degree:i,fraction:a,extended:f,streams:l,table:n?0:t.getUint32(16,!0)}}function gs({version:o,count:e,degree:t}){return[o===1?6:9,1,3,3,o<3?3:4,3*mo[t]].map(s=>s*e)}async function Hi(o){let t=new Response(o).body.pipeThrough(new DecompressionStream("gzip")).getReader(),s=[],n=0,r=null,i=1/0,a=async()=>new Uint8Array(await new Blob(s).arrayBuffer());for(;n<=i;){let{value:c,done:l}=await t.read().catch(()=>{throw new Error(se)});if(l)break;if(s.push(c),n+=c.length,r===null&&n>=At){if(r=vo(await a(),o.length),r.version>3)throw new Error("this is not a .spz file");i=gs(r).reduce((f,h)=>f+h,At)}}if(r===null)throw new Error("this is not a .spz file");if(n>i&&(await t.cancel().catch(()=>{}),!r.extended))throw new Error("the .spz file holds more than it announces");if(n<i)throw new Error(`the .spz file is cut off: ${r.count} Gaussians were announced`);return{header:r,content:await a()}}function Wi(o,e){let{streams:t,table:s,version:n}=o,r=gs(o),i=s+16*t,a=r.filter(h=>h>0).length;if(n!==4||s<wo||i>e.length||t!==a)throw new Error(se);let c=new DataView(e.buffer,e.byteOffset,e.byteLength),[l,f]=[s,i];return r.map(h=>{if(h===0)return new Uint8Array(0);let d=Number(c.getBigUint64(l,!0)),p=Number(c.getBigUint64(l+8,!0));if(l+=16,f+d>e.length||p!==h)throw new Error(se);let u=e.subarray(f,f+=d);try{return uo(u,h)}catch(w){throw new Error(`${se}: ${w instanceof Error?w.message:w}`)}})}function po({version:o,count:e,degree:t,fraction:s},n){let[r,i,a,c,l,f]=n,h=mo[t],d=Math.min(h,$i),p=d+1,u=us(e,p),w=new Float32Array(11+3*p),m=o===1?ji(r):Vi(r,2**-s),b=o<3?Xi:Ki;for(let E=0;E<e;E++){w[0]=m(3*E),w[1]=-m(3*E+1),w[2]=-m(3*E+2);for(let y=0;y<3;y++)w[3+y]=c[3*E+y]/16-10;b(l,E,w);let k=Math.min(Math.max(i[E]/255,1e-6),1-1e-6);w[10]=Math.log(k/(1-k));for(let y=0;y<3;y++)w[11+y]=(a[3*E+y]/255-.5)/Gi;for(let y=0;y<d;y++)for(let _=0;_<3;_++)w[14+3*y+_]=qi[y]*(f[3*(h*E+y)+_]-128)/128;ps(u,w)}return u}function Vi(o,e){return t=>{let s=3*t;return e*((o[s]<<8|o[s+1]<<16|o[s+2]<<24)>>8)}}function ji(o){return e=>{let t=U(o[2*e]|o[2*e+1]<<8);if(!Number.isFinite(t))throw new Error(se);return t}}function Xi(o,e,t){let[s,n,r]=[0,1,2].map(a=>o[3*e+a]/127.5-1),i=Math.sqrt(Math.max(0,1-s*s-n*n-r*r));t.set([i,s,-n,-r],6)}function Ki(o,e,t){let s=4*e,n=o[s]|o[s+1]<<8|o[s+2]<<16|o[s+3]<<24,r=n>>>30,i=[0,0,0,0],a=1;for(let c=0,l=20;c<4;c++){if(c===r)continue;let f=(n>>l&511)/511*Math.SQRT1_2;i[c]=n>>l+9&1?-f:f,a-=f*f,l-=10}i[r]=Math.sqrt(Math.max(0,a)),t.set([i[3],i[0],-i[1],-i[2]],6)}var Yi=8192,Qi=.2,Ji=2**20,yo=1500,Zi=8,_o=["shapes","colors","lobes"],pe=new Float32Array(0),G=(o,e=[])=>self.postMessage(o,{transfer:e}),Ao=({shapes:o,colors:e,lobes:t})=>[o.buffer,e.buffer,t.buffer];async function ea(o){if("file"in o)return{source:o.file.stream(),total:o.file.size};let e;try{e=await fetch(o.url)}catch{throw new Error(`${o.url} cannot be reached: is the address right, the network there, and may this site load it (CORS)?`)}if(!e.ok||e.body===null)throw new Error(`${o.url} could not be loaded: the server says ${e.status}`);let t=e.headers.has("Content-Encoding")?NaN:Number(e.headers.get("Content-Length"));return{source:e.body,total:t||NaN}}var bs=class{#e;#t;#o;#n;#s;#r=0;#i=null;#a=!1;constructor(e,t,s,n,r){this.#e=e,this.#s=r,this.#t=t,this.#o=s,this.#n=n;let{grid:i,views:a,near:c}=e,l=Array.from(e.background),{color:f,side:h}=n.neutral,d=Ut(Cs(t[0].positions,Yi),i),p=h*Math.sqrt(3*e.count/d.length),u={means:d,color:f,side:p,background:l};G({kind:"dots",dots:u,views:a,near:c},[u.means.buffer])}send(e){if(!this.#o.firstLevelReady||!this.allocate(e))return;let t=this.#o.levels,s=this.#r;this.#r=Math.max(t,1);let n=this.#o.results.splice(0),r=this.#i;if(r){this.#i=this.#o.output=null;let{views:i,near:a}=this.#e;G({kind:"scene",data:r,means:this.#c(),views:i,near:a},Ao(r));return}for(let[i,a]of n)for(let c of _o){let l=a[c];G({kind:"rows",part:c,from:i,numbers:l},[l.buffer])}s!==this.#r&&G({kind:"more",means:this.#c()})}allocate(e){let{count:t}=this.#e;return!this.#a&&Zi*e>=t&&(this.#i=this.#o.output=jn(this.#e,t,this.#n.scaleRange,this.#s),this.#a=!0),this.#a}#c(){let e=this.#t.slice(0,this.#r),t=new Uint16Array(e.reduce((r,{count:i})=>r+3*i,0)),s=0;for(let{positions:r,count:i}of e)t.set(r,s),s+=3*i;let n={stored:t,grid:this.#e.grid};return this.#e.sorted&&(pe=$e(n)),n}};async function ta(o){let e=null,t=null,[s,n]=[0,0],r=[],i=async({header:a,decoder:c,received:l,total:f},h)=>{if(G({kind:"progress",received:l,total:f}),a===null||c===null)return;n=l,e??=new _t(a.lodSizes);let d=r=c.levels,p=h*(f/l-1)>yo;d[0].positions&&!t&&(t=new bs(a,d,e,e.start(c),c.network),e.spawn(),s=setInterval(()=>t?.send(n),yo)),t?.allocate(l);for(let[u,{stage:w}]of d.entries())t&&(w===ts||p&&u===0&&w>=Te)&&e.advance(u,w);await fs()};try{await Gn(o,i)}finally{for(let[a,{stage:c,positions:l}]of r.entries())t&&l&&c>=Te&&e?.advance(a,c);await e?.finish().finally(()=>{clearInterval(s),e?.terminate()}),t?.send(n)}return n}async function xo(o,e,t){let[s,n]=[new Uint8Array(e||Ji),0],r=o.getReader();for(let a;!(a=await r.read()).done;){let c=n+a.value.length;if(c>s.length){let l=s;s=new Uint8Array(Math.max(c,2*s.length)),s.set(l)}s.set(a.value,n),n=c,G({kind:"progress",received:n,total:e})}let i=await t(s.subarray(0,n));if(!i.count)throw new Error("there is no Gaussian in this file that can be drawn");pe=new Float32Array(3*i.count);for(let a=0;a<pe.length;a++)pe[a]=i.shapes[4*a+3];return G({kind:"scene",data:i,means:pe,views:[],near:Qi},Ao(i)),n}async function sa(o){let e=o.getReader(),t=()=>e.read().catch(()=>{throw new Error("the file broke off before its end: load it again")}),s=await t(),n=s?.value??new Uint8Array(0),r=new ReadableStream({async pull(i){let{value:a,done:c}=s??await t();s=null,c?i.close():i.enqueue(a)},cancel:()=>e.cancel()});return{first:n,whole:r}}async function Eo(o){let e=performance.now();try{let{source:t,total:s}=await ea(o),{first:n,whole:r}=await sa(t),i;ds(n)?i=await xo(r,s,ro):go(n)?i=await xo(r,s,bo):i=await ta(r),G({kind:"done",milliseconds:performance.now()-e,bytes:i})}catch(t){let{message:s}=t,n=t instanceof RangeError?`the scene is too large for this device: ${s}`:s;G({kind:"failed",sentence:n})}}var ko;function So(){self.onmessage=async({data:o})=>{if("decoderInputs"in o){ko=new ue(o.decoderInputs);return}if("rows"in o){let{rows:e,chunk:t,stage:s}=o,n=kt(ko,e),r=_o.map(i=>n[i].buffer);self.postMessage({chunk:t,stage:s,packed:n},{transfer:r});return}if("forward"in o){let e=Ne(pe,o.forward);G({kind:"order",order:e},[e.buffer]);return}await Eo(o)},self.name&&Eo({url:self.name})}globalThis.document||So();
})();
