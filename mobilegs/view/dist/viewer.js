(function bundle(){"use strict";
var b={"dots.glsl":`precision highp float;
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
#ifdef LEVELED
uniform sampler2D coarse_colors;
uniform sampler2D coarse_weights;
uniform ivec2 coarse_from;
#endif
#ifdef LEVELED
void add_enlarged(ivec2 pixel, int begin, inout vec4 color, inout float weight) {
ivec2 at = pixel - begin;
ivec2 nearest = (at >> 1) + 1;
ivec2 other = nearest + 2 * (at & 1) - 1 + coarse_from;
nearest += coarse_from;
ivec2 b = ivec2(other.x, nearest.y);
ivec2 c = ivec2(nearest.x, other.y);
vec4 coarse = 0.5625 * texelFetch(coarse_colors, nearest, 0) + 0.1875 * texelFetch(coarse_colors, b, 0) +
0.1875 * texelFetch(coarse_colors, c, 0) + 0.0625 * texelFetch(coarse_colors, other, 0);
color = vec4(color.rgb + coarse.rgb, color.a * coarse.a);
weight += 0.5625 * texelFetch(coarse_weights, nearest, 0).r + 0.1875 * texelFetch(coarse_weights, b, 0).r +
0.1875 * texelFetch(coarse_weights, c, 0).r + 0.0625 * texelFetch(coarse_weights, other, 0).r;
}
#endif
#ifdef ENLARGE
uniform ivec2 from;
layout(location = 0) out vec4 color_out;
layout(location = 1) out vec4 weight_out;
void main() {
ivec2 at = ivec2(gl_FragCoord.xy);
color_out = texelFetch(color_sums, from + at, 0);
float weight = texelFetch(weight_sums, from + at, 0).r;
add_enlarged(at, 1, color_out, weight);
weight_out = vec4(weight, 0.0, 0.0, 0.0);
}
#else
out vec4 color_out;
vec4 resolved(ivec2 at) {
vec4 sum = texelFetch(color_sums, at, 0);
#ifdef SORTED
return vec4(sum.rgb + (1.0 - sum.a) * background.rgb, sum.a);
#else
float weight = texelFetch(weight_sums, at, 0).r;
#ifdef LEVELED
add_enlarged(at, 0, sum, weight);
#endif
float behind = size.w * weight_scale;
if (!(weight > 1e-12 * weight_scale)) { return vec4(background.rgb, 1.0 - sum.a); }
if (weighting == 3) {
return vec4((behind * background.rgb + sum.rgb) / (behind + weight), 1.0 - sum.a);
}
return vec4((1.0 - sum.a) * sum.rgb / weight + sum.a * background.rgb, 1.0 - sum.a);
#endif
}
void main() {
ivec2 at = ivec2(gl_FragCoord.xy);
at.y = abs(last_row - at.y);
vec4 sum = vec4(0.0);
for (int k = 0; k < supersampling * supersampling; k++) {
sum += resolved(at * supersampling + ivec2(k % supersampling, k / supersampling));
}
color_out = sum / float(supersampling * supersampling);
}
#endif
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
var sum = vec4f();
for (var k = 0; k < samples(); k++) {
let pixel = sample_of(position, k);
sum += resolved(textureLoad(colors, pixel, 0), textureLoad(weights, pixel, 0).r);
}
return sum / f32(samples());
}
@fragment
fn resolve_levels(@builtin(position) position: vec4f) -> @location(0) vec4f {
var sum = vec4f();
for (var k = 0; k < samples(); k++) {
let pixel = sample_of(position, k);
let fine = textureLoad(colors, pixel, 0);
let coarse = enlarged(pixel, 0);
let all = vec4f(fine.rgb + coarse.color.rgb, fine.a * coarse.color.a);
sum += resolved(all, textureLoad(weights, pixel, 0).r + coarse.weight);
}
return sum / f32(samples());
}
@fragment
fn resolve_sorted(@builtin(position) position: vec4f) -> @location(0) vec4f {
var sum = vec4f();
for (var k = 0; k < samples(); k++) {
let pixel = textureLoad(colors, sample_of(position, k), 0);
sum += vec4f(pixel.rgb + (1.0 - pixel.a) * view.background, pixel.a);
}
return sum / f32(samples());
}
fn samples() -> i32 { return i32(view.supersampling * view.supersampling); }
fn sample_of(position: vec4f, k: i32) -> vec2i {
let side = i32(view.supersampling);
return vec2i(position.xy) * side + vec2i(k % side, k / side);
}
fn resolved(sum: vec4f, weight: f32) -> vec4f {
if (!(weight > 1e-12 * view.weight_scale)) { return vec4f(view.background, 1.0 - sum.a); }
let behind = view.background_weight * view.weight_scale;
if (view.weighting == 3u) {
return vec4f((behind * view.background + sum.rgb) / (behind + weight), 1.0 - sum.a);
}
return vec4f((1.0 - sum.a) * sum.rgb / weight + sum.a * view.background, 1.0 - sum.a);
}
`,"splat.glsl":`#ifdef VERTEX
#ifdef SORTED
uniform usampler2D order;
#endif
flat out vec4 axes;
flat out vec4 color;
flat out vec4 center;
#ifdef LEVELED
flat out vec4 region;
#endif
void main() {
gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
axes = vec4(0.0);
color = vec4(0.0);
center = vec4(0.0);
#ifdef LEVELED
region = vec4(0.0);
#endif
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
float opacity = look.opacity;
vec2 target = size.xy;
#ifdef LEVELED
int level = level_of(e, look.weight / weight_scale);
if (level > 0) {
Ellipse coarse = to_level(e, level);
opacity *= sqrt(e.determinant / coarse.determinant) / float(1 << (2 * level));
e = coarse;
}
vec4 place = level_place(level);
region = vec4(place.xy, place.xy + place.zw);
e.center += place.xy;
target = levels_size();
#endif
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
center = vec4(e.center, opacity, e.compensation);
vec2 side = (reach_of(opacity) * sizes + 0.02) *
(vec2(gl_VertexID & 1, (gl_VertexID >> 1) & 1) * 2.0 - 1.0);
vec2 at = e.center + side.x * way + side.y * across;
gl_Position = vec4(at / target * 2.0 - 1.0, 0.0, 1.0);
}
#else
flat in vec4 axes;
flat in vec4 color;
flat in vec4 center;
#ifdef LEVELED
flat in vec4 region;
#endif
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
#ifdef LEVELED
if (any(lessThan(gl_FragCoord.xy, region.xy)) || any(greaterThan(gl_FragCoord.xy, region.zw))) { alpha = 0.0; }
#endif
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
int supersampling;
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
#ifdef LEVELED
const float WEIGHT_UNIT = 10.0;
int level_of(Ellipse e, float w) {
float skew = 0.5 * (e.variance.x - e.variance.y);
float cov = e.covariance;
float larger = 0.5 * (e.variance.x + e.variance.y) + sqrt(skew * skew + cov * cov);
float needed = level_sigma * level_sigma * sqrt(max(w / WEIGHT_UNIT, 1.0));
float share = e.determinant / (larger * needed);
return int(share >= 4.0) + int(share >= 16.0) + int(share >= 64.0);
}
Ellipse to_level(Ellipse e, int level) {
Ellipse coarse = e;
float side = float(1 << level);
float spread = 0.25 * (side * side - 1.0);
coarse.center = e.center / side + 1.0;
coarse.determinant = e.determinant - spread * (e.variance.x + e.variance.y) + spread * spread;
coarse.determinant /= side * side * side * side;
coarse.variance = (e.variance - spread) / (side * side);
coarse.covariance = e.covariance / (side * side);
return coarse;
}
vec4 level_place(int level) {
ivec2 side = ivec2(size.xy);
ivec2 from = ivec2(0);
for (int l = 1; l <= level; l++) {
from = l == 1 ? ivec2(side.x, 0) : ivec2(from.x, from.y + side.y);
side = (side - (l == 1 ? 0 : 1)) / 2 + 2;
}
return vec4(from, side);
}
vec2 levels_size() {
vec4 second = level_place(1);
vec4 last = level_place(3);
return vec2(second.x + second.z, max(size.y, last.y + last.w));
}
#endif
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
supersampling: u32,
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
`};var jo=/[\x00-\x1f\x7f-\x9f\u2028\u2029\p{Cs}]/gu,x=class extends Error{name="SceneError";constructor(e){super(e.replace(jo,"\uFFFD"))}};function $(n){return new DataView(n.buffer,n.byteOffset,n.byteLength)}var Z=class{#e;#t=0;#o=0;constructor(e){this.#e=e}get left(){return 8*(this.#e.length-this.#t)-this.#o}take(e){let t=this.#e,s=this.#t,o=t[s]|t[s+1]<<8|t[s+2]<<16|t[s+3]<<24,r=this.#o+e,i=o>>>this.#o&(1<<e)-1;return this.#t=s+(r>>>3),this.#o=r&7,i}atEnd(){return this.left<8&&this.#e[this.#t]>>>this.#o===0}};function re(n,e){let t=Math.ceil(e/8);if(n.length!==t)throw new x(`packed bits take ${n.length} bytes where ${t} belong`);if(e%8&&n[t-1]>>e%8)throw new x("packed bits end in bits that are not zero");return new Z(n)}var As="0061736d01000000012a0460077f7f7f7f7f7f7d0060037f7f7f0060097f7f7f7f7f7f7f7f7f017f60097f7f7f7f7f7f7f7d7d00020f0103656e76066d656d6f727902000103060500010202030607017f014180080b073705056c61796572000005756e69747300010a70756c6c5f706c61696e00020f70756c6c5f636f6e7465787475616c0003047061636b00040abc21059c0404017f017b047f0b7b024020054101480d00200120054102746a21072006fd13210820044102742209410148210a0340200020094102746a210b4100210c03402001fd09000c210d2001fd090008210e2001fd090004210f2001fd090000211002400240200a450d00200d2111200e2112200f2113201021140c010b2002200c4102746a2104200d2111200e2112200f2113201021142000210503402004fd00001022152005fd0900002216fde6012010fde40121102004fd00000022172016fde6012014fde401211420152005fd0900042216fde601200ffde401210f20172016fde6012013fde401211320152005fd0900082216fde601200efde401210e20172016fde6012012fde401211220152005fd09000c2216fde601200dfde401210d20172016fde6012011fde401211120044180046a2104200541106a2205200b490d000b0b2003200c4102746a2205201120082011fde601fde901fd0b00800c2005201220082012fde601fde901fd0b0080082005201320082013fde601fde901fd0b0080042005201020082010fde601fde901fd0b00102005201420082014fde601fde901fd0b0000200541900c6a200d2008200dfde601fde901fd0b000020054190086a200e2008200efde601fde901fd0b000020054190046a200f2008200ffde601fde901fd0b0000200c41f800492105200c41086a210c20050d000b20034180106a2103200b2100200141106a22012007490d000b0b0bd50104027f017b027f017b200020024109746a2103410021040340fd0c0000000000000000000000000000000021052000200441027422066a22022107034020052007fd00000022082008fde601fde401210520074180046a22072003490d000b200120066a2107fd0c0000803f0000803f0000803f0000803f2005fde301fd0cccbc8c2bccbc8c2bccbc8c2bccbc8c2bfde901fde70121050340200720052002fd000000fde601fd0b000020074180046a210720024180046a22022003490d000b200441fc00492102200441046a210420020d000b0bd30101087f41002109034002402006200820092007491b220a4101480d002000200a4103746a210b2000210a0340024020022001200a280200220c41ffff0071220d4101746a2f0100220e4102746a280200220f0d0041000f0b20042f01002110200a28020420094101746a200e3b0102200a20104100200d200f410f766b200f41ffff0171200c410e766c6a220c4180800449220f1b200c200f41047474723602002004200f4101746a2104200a41086a220a200b490d000b0b0240200420054b0d00200941016a220920074d0d010b0b20040bf101010a7f410021094100210a0340024020062008200a2007491b220b4101480d002000200b4103746a210c2000210b0340024020022009200b280204200a4101746a220d2f010071220e20036c2001200e410f74200b280200220f41ffff00712210410174726a2f010022116a4102746a280200220e0d0041000f0b20042f01002112200d20113b0102200b201241002010200e410f766b200e41ffff0171200f410e766c6a220d4180800449220e1b200d200e41047474723602002004200e4101746a2104200b41086a220b200c490d000b0b0240200420054b0d00417f2109200a41016a220a20074d0d010b0b20040bfc1707067f027b037f0c7b037f0e7b017f2005417e7121092005410171210a200641036c210b2006410174210c20044180206a210d200541017441026a210e2008fd13210f2007fd132110410021112006410274221241027421130340fd0c020000000200000002000000020000002214fd0c010000000100000001000000010000002215fd0c0000000000000000000000000000000022162001fd000080042217fde0012001fd0000002218fde001fd442219fd522001fd00008008221afde001201720182019fd522217fde001fd442218fd522119fd0c03000000030000000300000003000000211b2001fd0000800c221c201a20172018fd522217201cfde0012017fde001fd44221dfd52221efd0cffffff7fffffff7fffffff7fffffff7f221cfd4e2016fd37211ffd0c0000000000000000000000000000000022172118410121202016211a4100212102400240024020050e020201000b0340201720032020410a746a2222fd000000fde001fde90120224180086afd000000fde001fde9012117201820224180046afd000000fde001fde901202241800c6afd000000fde001fde9012118202041026a2120202141026a22212009470d000b0b0240200a450d00201720032020410a746a2222fd000000fde001fde9012117201820224180046afd000000fde001fde90121180b2018fd0cffff0f00ffff0f00ffff0f00ffff0f00221afdae014114fdad0121162017201afdae014114fdad01211a0b201b2019201dfd52211d200d2003fd000080042217fd0c000000800000008000000080000000802223fd4e2003fd00000022184110fdad01fd0c008000000080000000800000008000002224fd4efd502018201cfd4e2219fd0c0000804b0000804b0000804b0000804b2225fde601fd6afdf80120192018410dfdad012015fd4efdae01fd0cff0f00c8ff0f00c8ff0f00c8ff0f00c82226fdae01410dfdad01fd0cff7b0000ff7b0000ff7b0000ff7b00002227fdb7012019fd0c000080380000803800008038000080382228fd3afd52fd502017201cfd4e22182025fde601fd6afdf80120182017410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120182028fd3afd524110fdab01fd502217fd0c0000ffff0000ffff0000ffff0000fffffd4efd0ce2f00000e2f00000e2f00000e2f00000fd502017201ffd522217fd5a00000041022120200d20064102746a2017fd5a000001200d200c4102746a2017fd5a000002200d200b4102746a2017fd5a0000032016fd0c78030000780300007803000078030000221ffdb901fd0c770400007704000077040000770400002229fdb601fd0c88fcffff88fcffff88fcffff88fcffff222afdae01212bfd0c00008037000080370000803700008037212cfd0c0000fe420000fe420000fe420000fe422117201a201ffdb9012029fdb601202afdae01212d0240200e41024d0d002017202b4114fdab01202cfdae01fde70121192017202d4114fdab01202cfdae01fde701211a200d21220340202241046a22222019200320204109742221418004726afd000000fde601fd0c0000fec20000fec20000fec20000fec22218fde9012017fde801fd0c002000440020004400200044002000442216fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4e201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf801fd0cff000000ff000000ff000000ff000000fd4e2019200320214180086a2221418004726afd000000fde6012018fde9012017fde8012016fde401fdf8014118fdab01201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4efd50fd50fd502218fd5a000000202220126a2018fd5a0000012022200c4102746a2018fd5a0000022022200b4102746a2018fd5a000003202041046a2220200e490d000b0b200441346a202d4110fdab01202b4118fdab01fd502218fd5a000003200441246a2018fd5a000002200441146a2018fd5a000001200441046a2018fd5a000000200441386a200f2000fd00008004fdfa012010fde501fde601fd0c000000000000000000000000000000002218fde901fd0c0000803f0000803f0000803f0000803f2216fde801fd0c00e0ff4400e0ff4400e0ff4400e0ff44221afde601fd0c0000003f0000003f0000003f0000003f2219fde401fdf801410bfdab01200f2000fd00008008fdfa012010fde501fde6012018fde9012016fde801fd0c00c07f4400c07f4400c07f4400c07f44fde6012019fde401fdf8014116fdab01fd50200f2000fd000000fdfa012010fde501fde6012018fde9012016fde801201afde6012019fde401fdf801fd502216fd5a000003200441286a2016fd5a000002200441186a2016fd5a000001200441086a2016fd5a0000002004413c6afd0c71aa34c471aa34c471aa34c471aa34c4fd0c71aa344471aa344471aa344471aa3444201e2018fd43fd5222162001fd00008004221a2001fd000000201d2015fd39fd52fde601fd0c001080440010804400108044001080442219fde401fdf801410afdab01fd0c00fc0f0000fc0f0000fc0f0000fc0f00fd4e201d4114fdab01fd5020162001fd00008008222b201a201d2014fd39fd52fde6012019fde401fdf801fd0cff030000ff030000ff030000ff030000221afd4efd50410afdab0120162001fd0000800c202b201d201bfd39fd52fde6012019fde401fdf801201afd4efd502216fd5a0000032004412c6a2016fd5a0000022004411c6a2016fd5a0000012004410c6a2016fd5a0000002002fd0000802c211d2002fd00008028211b2002fd00008024212b2002fd00008020212d2002fd0000801c21142002fd00008018211e2002fd00008014212e2002fd00008010212f2002fd0000800c2130200441b0106a2002fd0000800422162023fd4e2002fd00000022194110fdad012024fd4efd502019201cfd4e221a2025fde601fd6afdf801201a2019410dfdad012015fd4efdae012026fdae01410dfdad012027fdb701201a2028fd3afd52fd502016201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd524110fdab01fd502216fd5a000003200441a0106a2016fd5a00000220044190106a2016fd5a00000120044180106a2016fd5a000000200441b4106a2002fd000080082216201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd522030fde0012018fde901202ffde001fde901202efde001fde901201efde001fde9012014fde001fde901202dfde001fde901202bfde001fde901201bfde001fde901201dfde001fde901fd0cffff0f00ffff0f00ffff0f00ffff0f00fdae014114fdad01201ffdb9012029fdb601202afdae0122184110fdab0120164110fdad012024fd4efd50fd502002fd0000800c201720184114fdab01202cfdae01fde7012218fde601fd0c0000fec20000fec20000fec20000fec22216fde9012017fde801fd0c002000440020004400200044002000442219fde401fdf8014118fdab01fd50221afd5a000003200441a4106a201afd5a00000220044194106a201afd5a00000120044184106a201afd5a00000020044188106a213141002120410121210340203120204102746a222241306a20182020410b7420026a22204180186afd000000fde6012016fde9012017fde8012019fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4e2018202041801c6afd000000fde6012016fde9012017fde8012019fde401fdf8014118fdab01fd50201820204180146afd000000fde6012016fde9012017fde8012019fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4efd50201820204180106afd000000fde6012016fde9012017fde8012019fde401fdf801fd0cff000000ff000000ff000000ff000000fd4efd50221afd5a000003202241206a201afd5a000002202241106a201afd5a0000012022201afd5a00000020214101712122410021214101212020220d000b200441c0006a2104200341106a2103200241106a2102200141106a2101200041106a2100200d20136a210d201141fc00492122201141046a211120220d000b0b";var be,Ss=new WeakMap;function Ie(n){return typeof WebAssembly=="object"?new WebAssembly.Memory({initial:Math.ceil(n/2**16)}):null}function ie(n){if(n===null)return null;if(be===void 0)try{let t=As.match(/../g);be=new WebAssembly.Module(Uint8Array.from(t,s=>parseInt(s,16)))}catch{be=null}if(be===null)return null;let e=Ss.get(n);if(!e){let{exports:t}=new WebAssembly.Instance(be,{env:{memory:n}});e=t,Ss.set(n,e)}return e}var y=128,Xo=1e-12,Ms=new Float32Array(0),Ne=class{wasmMemory=null;#e=[];#t=0;#o=null;#n;constructor(e=!1){this.#n=e}block(e){return this.#s(e,y*e,null)}part({at:e},t,s){let o={at:e+4*y*t,width:s,numbers:Ms};return this.#e.push([o,null,y*s]),o}layer(e,t,s){let o=s?s.length:e.length/t,r=Math.ceil(o/4)*4,i=new Float32Array(r*t);for(let l=0;l<o;l++){let f=(l-l%4)*t+l%4;for(let h=0;h<t;h++)i[f+4*h]=e[l*t+h]}let a=new Float32Array(r);s&&a.set(s);let c=l=>this.#s(0,l.length,l);return{inputs:t,outputs:r,weights:c(i),offsets:c(a)}}#s(e,t,s){let o={at:this.#t,width:e,numbers:Ms};return this.#e.push([o,s,t]),this.#t+=16*Math.ceil(t/4),o}allocate(){this.wasmMemory=Ie(this.#t);let e=this.wasmMemory?.buffer??new ArrayBuffer(this.#t);for(let[t,s,o]of this.#e.splice(0))t.numbers=new Float32Array(e,t.at,o),s&&t.numbers.set(s);this.#o=this.#n?null:ie(this.wasmMemory)}apply({inputs:e,outputs:t,weights:s,offsets:o},r,i,a){if(this.#o){this.#o.layer(s.at,o.at,r.at,i.at,e,t,a);return}let[c,l,f,h]=[r,i,s,o].map(({numbers:d})=>d);for(let d=0;d<t;d++){let p=(d-d%4)*e+d%4;for(let u=0;u<y;u++){let m=h[d];for(let w=0;w<e;w++)m+=f[p+4*w]*c[w*y+u];l[d*y+u]=Math.max(m,a*m)}}}units({at:e,width:t,numbers:s},{at:o,numbers:r}){if(this.#o){this.#o.units(e,o,t);return}for(let i=0;i<y;i++){let a=0;for(let l=i;l<y*t;l+=y)a+=s[l]*s[l];let c=1/Math.max(Math.sqrt(a),Xo);for(let l=i;l<y*t;l+=y)r[l]=s[l]*c}}};var zt=2048,J;function Ts({contexts:n,alphabet:e,symbols:t,spans:s},o,r,i,a){J===void 0&&(J=Ie(1));let c=ie(J);if(J===null||c===null)return;let l=o.length,f=zt+2*t.length,h=f+4*s.length,d=h+i.length,p=d+2*l+2,u=Math.ceil((p+2*a+2)/2**16)-J.buffer.byteLength/2**16;u>0&&J.grow(u);let{buffer:m}=J,w=new Uint32Array(m,0,2*l);o.forEach((_,v)=>w.set([_,p-2+2*r[v]],2*v)),new Uint16Array(m,zt,t.length).set(t),new Uint32Array(m,f,s.length).set(s),new Uint8Array(m,h,i.length).set(i);let E=(n>1?c.pull_contextual:c.pull_plain)(0,zt,f,e,h,d,l,Math.floor(a/l),a%l);return{decoded:new Uint16Array(m,p,a).slice(),left:E?(d-E)/2:-1/0,states:w.filter((_,v)=>v%2===0)}}var Pe=14,ye=1<<Pe,Rs=65536,Ko=64,Yo=256,Qo=2048,Ce=12,Ls=-1/0;function ee(n,e,t,s=!1){if(n.length<Ce)throw new x("a rANS stream is too short to hold its header");let o=$(n),r=o.getUint16(0,!0),i=o.getUint16(2,!0),a=o.getUint32(4,!0),c=o.getUint32(8,!0);if(r!==t)throw new x(`a rANS stream of ${r} symbols stands where ${t} belong`);if(i!==1&&i!==t||i>Ko)throw new x(`a rANS stream has ${i} contexts`);let l=Zo(e);if(n.length!==Ce+a+4*l+2*c)throw new x("a rANS stream is longer or shorter than its header says");let f=Ce+a,h=er(n.subarray(Ce,f),i,t),d=new Uint32Array(l).map((E,_)=>o.getUint32(f+4*_,!0));if(d.some(E=>E<Rs))throw new x("a rANS stream starts in an impossible state");let p=Math.floor(e/l),u=e%l,m=d.map((E,_)=>_*p+Math.min(_,u)),w=[h,d,m,n.subarray(f+4*l),e],g=(s?void 0:Ts(...w))??Jo(...w);if(g.left===Ls)throw new x("a rANS stream leads to a context that is not used: it is damaged");if(g.left<0)throw new x("a rANS stream ends early: the file is damaged");if(g.left>0||g.states.some(E=>E!==Rs))throw new x("a rANS stream does not end where it should: the file is damaged");return g.decoded}function Zo(n){let e=Math.max(1,Math.floor(n/Qo));return Math.min(Yo,1<<31-Math.clz32(e))}function Jo({contexts:n,alphabet:e,symbols:t,spans:s},o,r,i,a){let c=o.length,l=Math.floor(a/c),f=a%c,h=new Uint16Array(a),d=i.length/2,p=new Uint16Array(d+1);new Uint8Array(p.buffer).set(i);let u=0;for(let m=0;m<=l;m++){let w=m<l?c:f,g=n>1&&m>0;for(let E=0;E<w;E++){let _=r[E]+m,v=g?h[_-1]:0,k=o[E],S=k&ye-1,F=t[v<<Pe|S],j=s[v*e+F];if(j===0)return{decoded:h,left:Ls,states:o};let X=Math.imul(j&32767,k>>>Pe)+S-(j>>>15)|0,Q=(X>>>16)-1>>>31;o[E]=X<<16*Q|p[u]&-Q,u+=Q,h[_]=F}}return{decoded:h,left:d-u,states:o}}function er(n,e,t){let s=new Z(n),o=new Uint16Array(e*ye),r=new Uint32Array(e*t);for(let i=0;i<e;i++){if(!ve(s,1))continue;let a=tr(s,t),c=i*ye;for(let l=0;l<t;l++){let f=a[l];f!==0&&(r[i*t+l]=c%ye<<15|f,o.fill(l,c,c+f),c+=f)}}if(!s.atEnd())throw new x("a rANS stream's frequency tables are longer than they should be");return{contexts:e,alphabet:t,symbols:o,spans:r}}function tr(n,e){let t=new Uint16Array(e),s=[];for(let a=0;a<e;a++)ve(n,1)&&s.push(a);let o=ve(n,4),r=s.pop(),i=ye;for(let a of s){let c=o;for(;!ve(n,1);)c++;if(c>Pe)throw new x("a rANS stream's frequency table holds a number out of range");t[a]=ve(n,c)+(1<<c)-(1<<o)+1,i-=t[a]}if(r===void 0||i<1)throw new x("a rANS stream's frequencies do not sum to 16384");return t[r]=i,t}function ve(n,e){if(e>n.left)throw new x("a rANS stream's frequency tables end early");return n.take(e)}var sr=80;function Os(n){let e=0;for(let{count:t,size:s,length:o}of n.values())e+=t*s*o;return e}function zs(n,e){let t=0,s=new Map;for(let[o,{count:r,size:i,length:a}]of e){let c=()=>n.subarray(t,t+=i*a);s.set(o,{length:a,books:Array.from({length:r},c)})}if(s.get("scale")?.books.some(o=>o.some(r=>r>sr)))throw new x("the codebooks of the .mgs file hold scales that are out of range");return s}function Fs(n){return new Map([...n].map(([e,{step:t,columns:s}])=>{let o=s.map(({least:r,size:i})=>Float32Array.from({length:i},(a,c)=>(r+c)*t));return[e,{length:1,books:o,middles:s.map(({least:r,middle:i})=>i-r)}]}))}function Us({name:n,codec:e,data:t},s,o){if(e==="rans")return ee(t,s,o);let r=32-Math.clz32(o-1),i=re(t,r*s),a=new Uint16Array(s);for(let c=0;c<s;c++){let l=i.take(r);if(l>=o)throw new x(`the stream '${n}' points outside of its codebook`);a[c]=l}return a}function xe({length:n,books:e,middles:t}){let s=new Uint16Array(y);return{length:n,books:e.map((o,r)=>t?o.subarray(t[r],t[r]+1):nr(o,n)),columns:e.map(()=>s)}}function nr(n,e){let t=new Float64Array(e);for(let s=0;s<n.length;s++)t[s%e]+=n[s]*e/n.length;return Float32Array.from(t)}function P({length:n,books:e,columns:t},s,o,r,i){for(let a=0;a<e.length;a++){let c=e[a],l=t[a],f=a*n*o;if(n===1){for(let h=r;h<i;h++)s[f++]=c[l[h]];continue}for(let h=0;h<n;h++,f=(a*n+h)*o)for(let d=r;d<i;d++)s[f++]=c[l[d]*n+h]}}var or=Float64Array.from({length:31},(n,e)=>2**(Math.max(e,1)-25)),Ns=new Float32Array(1),Is=new Uint32Array(Ns.buffer);function Ft(n){return(n&31744)===31744}function U(n){let e=n>>10&31,t=(n&1023)+(e>0?1024:0);return(n&32768?-t:t)*or[e]}function H(n){Ns[0]=n;let e=Is[0]>>>16&32768,t=Is[0]&2147483647;if(t<947912704){let s=Math.abs(n)*16777216,o=Math.round(s);return e|(o-s===.5&&o%2?o-1:o)}return e|Math.min(t+4095+(t>>>13&1)-939524096>>>13,31743)}function Ut(n,e){let t=rr(n,e);if(t.some(Ft))throw new x(`the stream '${n.name}' of the .mgs file has numbers that are not finite`);return Float32Array.from(t,U)}function rr({name:n,codec:e,data:t},s){let o=new x(`the stream '${n}' of the .mgs file has a wrong length`);if(e==="raw"){if(t.length!==2*s)throw o;return Uint16Array.from({length:s},(l,f)=>t[2*f]|t[2*f+1]<<8)}if(t.length<4)throw o;let r=4+$(t).getUint32(0,!0);if(r>t.length||e==="halves"&&t.length!==r+s)throw o;let i=ee(t.subarray(4,r),s,256),a=t.subarray(r),c=e==="planes"?ee(a,s,256):a;return i.map((l,f)=>l<<8|c[f])}var ir=49,te=24,De=Uint32Array.from({length:4096},(n,e)=>{let t=0;for(let s=0;s<12;s++)t|=(e>>>s&1)<<10*(s%3)+Math.floor(s/3);return t});function Cs(n,e){let t=n.length<4?1/0:4+$(n).getUint32(0,!0);if(t>n.length)throw new x("the stream of positions is too short to hold what its header says");let s=ee(n.subarray(4,t),e,ir),o=0;for(let l=0;l<e;l++)o+=Math.max(s[l]-1,0);let r=re(n.subarray(t),o),i=new Uint16Array(3*e),a=0,c=0;for(let l=0;l<e;l++){let f=s[l]-1;if(f>=te?(a+=r.take(te),c+=(1<<f-te)+r.take(f-te)):f>=0&&(a+=(1<<f)+r.take(f)),c+=a>>>te,a&=(1<<te)-1,c>>>te)throw new x("the stream of positions leaves its 48-bit grid");let h=De[a&4095]|De[a>>>12]<<4,d=De[c&4095]|De[c>>>12]<<4;for(let p=0,u=0;p<3;p++,u+=10){let m=h>>>u&255|(d>>>u&255)<<8,w=m&32768?m&32767:m^65535;if(Ft(w))throw new x("the stream of positions holds numbers that are not finite");i[3*l+p]=w}}return i}function Ps(n,e){let t=3*Math.ceil(n.length/3/e);if(t<=3)return n;let s=new Uint16Array(3*Math.ceil(n.length/t));for(let o=0,r=0;o<n.length;o+=t,r+=3)s.set(n.subarray(o,o+3),r);return s}function It(n,{center:e,radius:t,exponent:s}){let o=new Float32Array(n.length),r=t*2**s;for(let i=0;i<n.length;i++)o[i]=e[i%3]+Math.fround(r*U(n[i]));return o}function Be(n){return"stored"in n?It(n.stored,n.grid):n}var ar=[53,210,405,600,787,970,1151,1329],cr=Uint8Array.from({length:1330},(n,e)=>ar.filter(t=>t<=e).length),Nt=Float64Array.from({length:512},(n,e)=>(e+.5)/2**(31-Math.clz32(e))-1.5),lr=2.5,Ct=(n,e)=>cr[Math.min(256*Math.abs(Math.fround(n-e)),1329)|0];function Ds(n,e,t){let[s,o,r]=t,i=s.length,a=[new Uint16Array(i),new Uint16Array(i),new Uint16Array(i)],[c,l,f]=a,[h,d,p]=e,u=new Z(n),m=0;for(let w=0;w<i;w++){let g=h[s[w]],E=d[o[w]],_=p[r[w]],v=Ct(E,_),k=Ct(g,_),S=Ct(g,E),F=u.take(v+k+S);c[w]=1<<v|F&(1<<v)-1,l[w]=1<<k|F>>>v&(1<<k)-1,f[w]=1<<S|F>>>v+k,m+=v+k+S}return re(n,m),a}function Bs({step:n,columns:[{least:e},{least:t},{least:s}]},o,r,i,a){let[c,l,f,h,d,p]=o;for(let u=r,m=0;u<i;u++,m++){let w=n*(c[u]+e+Nt[h[u]]),g=n*(l[u]+t+Nt[d[u]]),E=n*(f[u]+s+Nt[p[u]]),_=(w*w+g*g+E*E)/4,v=1+_*(-1/2+_*(1/24+_*(-1/720+_*(1/40320+_*(-1/3628800+_*(1/479001600-_/87178291200)))))),k=1/2+_*(-1/12+_*(1/240+_*(-1/10080+_*(1/725760+_*(-1/79833600+_/12454041600)))));if(_>lr){let S=Math.sqrt(_);v=Math.cos(S),k=Math.sin(S)/(2*S)}a[m]=v,a[m+y]=k*w,a[m+2*y]=k*g,a[m+3*y]=k*E}}var ae=class{#e;#t;#o;constructor(e,{sh:t,scales:s,quats:o},r){this.#e=e,this.#t=[[t,e.part(r,0,12)],[s,e.part(r,12,3)]],this.#o=[o,e.part(r,15,4)]}write(){let[e,t]=this.#o;for(let[s,o]of this.#t)this.#e.units(s,o);t.numbers.set(e.numbers)}};var fr=[["context1",64,96],["context2",13,64],["static1",64,16],["static2",3,64],["view1",64,16],["view2",9,64]],hr=[["both1",128,6],["static2",3,64],["view2",9,64]],Pt={linear:"color-matrices",networks:"appearance-decoder",latent_networks:"color-networks"};function $s({colors:n,scalars:e}){let t=e.get("appearance")?.columns.length??6,s={linear:[["static2",3,3],["view2",9,t-3]],networks:fr,latent_networks:hr};return[Pt[n],s[n]]}var Gs=[["hidden1.weight",256,22],["hidden1.bias",1,256],["hidden2.weight",128,256],["hidden2.bias",1,128],["hidden3.weight",64,128],["hidden3.bias",1,64],["phi.weight",1,64],["phi.bias",1,1],["opacity.weight",1,64],["opacity.bias",1,1]];function qs({degree:n,latents:e,hidden:t}){let s=2*(n+1)**2,o=[19+e,...t],r=[["bias",1,s],["basis",e,s]];return t.length===0||([...t,s].forEach((i,a)=>r.push([`weights.${a}`,i,o[a]])),t.forEach((i,a)=>r.push([`offsets.${a}`,1,i]))),r}function Hs(n){return n.reduce((e,[,t,s])=>e+t*s,0)}function Ws(n,e){let t=0;return Object.fromEntries(e.map(([s,o,r])=>[s,n.subarray(t,t+=o*r)]))}var dr=256,Vs=["raw","halves","planes"],ur=["bits","rans"],js=[["scale","rotation"],["appearance","opacity"],["lobes"]],Bt=js.length,Ee=2,Dt=class{positions=null;columns=new Map;#e;constructor(e,t){this.#e=e,this.count=t}get stage(){let e=js.findIndex(t=>!t.every(s=>this.#t(s)));return e<0?Bt:e}rows(e,t,s="slice"){let o=[...this.columns].filter(([i])=>this.#t(i)).map(([i,a])=>[i,a.map(c=>c[s](e,t))]);return{positions:this.positions[s](3*e,3*t),columns:Object.fromEntries(o)}}#t(e){let{cuts:t,scalars:s}=this.#e,o=s.size&&e==="rotation"?3:0,r=(t.get(e)?.count??s.get(e)?.columns.length??0)+o;return Object.keys(this.columns.get(e)??[]).length===r}},$e=class{levels;network=null;#e;#t;#o=new Map;#n=new Map;#s=new Map;#r={};#i={};constructor(e,t){this.#e=e,this.#t=t;let{network:s,lobes:o,cuts:r,scalars:i,lodSizes:a}=e;s&&this.#l("view-network",Gs,f=>this.network=f),o&&this.#l("lobe-decoder",qs(o),f=>this.#r=f),this.#l(...$s(e),f=>this.#i=f),i.size?this.#s=Fs(i):this.#c("codebooks",Vs,[],f=>{this.#s=zs(Ut(f,Os(r)),r)});let c=[...this.#o.keys()],l=0;this.levels=a.map((f,h)=>(l+=f,this.#a(f,h?`@${h}`:"",c,l)))}#a(e,t,s,o){let{cuts:r,scalars:i}=this.#e,a=new Dt(this.#e,e),[c,...l]=["positions","scale.0","scale.1","scale.2"].map(d=>d+t),f=(d,p)=>{let u=[];a.columns.set(d,u);for(let[m,w]of p.entries())this.#c(`${d}.${m}${t}`,ur,[c],g=>{u[m]=Us(g,e,w)})},h=({data:d})=>{a.positions=Cs(d,e)};this.#c(c,["morton-class"],s,h,o);for(let[d,{count:p,size:u}]of r)f(d,Array(p).fill(u));for(let[d,{columns:p}]of i)f(d,p.map(({size:u})=>u));if(i.size){let[d,p]=["scale","rotation"].map(u=>a.columns.get(u)??[]);this.#c(`rotation-finer${t}`,["bits"],[c,...l],({data:u})=>{let{books:m}=this.#s.get("scale");Ds(u,m,d).forEach((w,g)=>p[3+g]=w)})}return a}accept(e){this.#o.has(e.name)&&this.#n.set(e.name,e)}step(e){for(let[t,{after:s,minBytes:o,read:r}]of this.#o){let i=this.#n.get(t);if(!(i===void 0||e<o||s.some(a=>this.#o.has(a))))return r(i),this.#o.delete(t),this.#n.delete(t),!0}return!1}get decoderInputs(){let[{count:e,positions:t}]=this.levels,s=t,o=Math.min(e,dr),r=new Uint16Array(3*o).map((c,l)=>s[3*Math.floor(Math.floor(l/3)*e/o)+l%3]),[i,a]=[this.#e,this.#s];return{header:i,books:a,appearance:this.#i,lobes:this.#r,samples:r}}#c(e,t,s,o,r=0){let i=this.#t.find(a=>a.name===e);if(i===void 0)throw new x(`the .mgs file lacks its stream '${e}'`);if(!t.includes(i.codec))throw new x(`the stream '${e}' of the .mgs file uses the codec '${i.codec}', which this program does not know`);this.#o.set(e,{after:s,minBytes:r,read:o})}#l(e,t,s){this.#c(e,Vs,[],o=>s(Ws(Ut(o,Hs(t)),t)))}};var I=new Int32Array(2048);for(let n=0;n<I.length;n++){let e=n<256?n:I[n-256];for(let t=0;t<8;t++)e=(e&1?3988292384:0)^e>>>1;I[n]=e}function Ge(n,e=0){let t=~e,s=0;for(;s+8<=n.length;s+=8)t^=n[s]|n[s+1]<<8|n[s+2]<<16|n[s+3]<<24,t=I[1792+(t&255)]^I[1536+(t>>>8&255)]^I[1280+(t>>>16&255)]^I[1024+(t>>>24)]^I[768+n[s+4]]^I[512+n[s+5]]^I[256+n[s+6]]^I[n[s+7]];for(;s<n.length;s++)t=I[(t^n[s])&255]^t>>>8;return~t>>>0}var Ve=Object.freeze({blur:.3,antialiased:!1,soft_edge:!1}),pr=2**26,mr=8,Gt=4096,$t=2**14,wr=1e-5,gr=1e3,br=80,vr=8,qt=32,yr=256,xr=3,Er=64,Xs=2**16,Ks=64,Ys=4096,_r=1e-20,qe=1e20,kr=/[\x00-\x1f\x7f-\x9f\p{Cs}]/u,Qs=["mobile_gs","no_depth","no_scale","sort_free_gs"],Ar=[["scale",[[3,1],[1,3]]],["rotation",[[2,2],[1,4]]],["appearance",[[3,2]]],["opacity",[[1,1]]]],Zs=[6,12],Sr=[["scale",3],["rotation",3],["appearance",Zs[0]],["opacity",1]];function Js(n,e){let{colors:t="networks"}=n;for(let[h,d,...p]of[["mode",n.mode,"nvq","sq"],["blend",n.blend,"sortfree","sorted"],["sh_degree",n.sh_degree,1],["colors",t,"linear","networks","latent_networks"]])if(!p.includes(d))throw new x(`the .mgs file has ${h} '${tn(d)}', which this program does not know: a newer one may`);let s=Rr(n),o=n.network;if(typeof o!="boolean")throw A("network");if(o&&s!==null)throw new x("the .mgs file has lobes and a view network: it can have one of them");let r=n.mode==="sq",i=R(n,"count",1,pr),a={count:i,lodSizes:Tr(n,i),cuts:r?new Map:Lr(D(n,"codebooks"),s),scalars:r?Or(D(n,"scalars"),s,t==="linear"):new Map,grid:zr(D(n,"positions")),colors:t,sorted:n.blend==="sorted",lobes:s,network:o,weighting:Fr(D(n,"weighting")),footprint:Ur(D(n,"footprint")),background:We(n,"background",3),near:W(n,"near"),views:_e(n,"views").map(Ir),meta:Nr(D(n,"meta"))},c=Mr(a),f=n.streams.filter(h=>c.has(h.name)).reduce((h,d)=>h+d.bytes,0);if(i>f)throw new x(`the .mgs file claims ${i} Gaussians in ${f} of its ${e} bytes: it is damaged`);if(a.footprint.soft_edge&&a.sorted)throw A("footprint.soft_edge");if(a.background.some(h=>h<0||h>1))throw A("background");if(!(a.near>0&&a.near<=qe))throw A("near");if(a.views.length>Er)throw A("views");return a}function He(n,e){return typeof n!="string"||n.length>2*e||kr.test(n)?!1:n.length<=e||[...n].length<=e}function Mr({colors:n,lobes:e,network:t,cuts:s,scalars:o,lodSizes:r}){let i=["positions"];for(let[c,{count:l}]of s)for(let f=0;f<l;f++)i.push(`${c}.${f}`);for(let[c,{columns:l}]of o)i.push(...l.map((f,h)=>`${c}.${h}`));o.size&&i.push("rotation-finer");let a=r.flatMap((c,l)=>i.map(f=>l?`${f}@${l}`:f));return a.push(Pt[n]),e&&a.push("lobe-decoder"),t&&a.push("view-network"),s.size&&a.push("codebooks"),new Set(a)}function Tr(n,e){let t=_e(n,"layers").map(o=>R({layers:o},"layers",1,e)),s=t.reduce((o,r)=>o+r,0);if(t.length>mr||s!==e)throw A("layers");return t}function Rr(n){if(n.lobes===null)return null;let e=D(n,"lobes"),t=_e(e,"hidden");if(t.length>xr)throw A("lobes.hidden");return{degree:R(e,"degree",0,3),latents:R(e,"latents",0,qt),hidden:t.map(s=>R({hidden:s},"hidden",1,yr))}}function Lr(n,e){let t=new Map;for(let[o,r]of Ar){if(o==="opacity"&&!Object.hasOwn(n,o)&&e!==null)continue;let i=D(n,o),a=r.find(([c,l])=>i.count===c&&i.length===l);if(!a)throw A(`codebooks.${o}`);t.set(o,{count:a[0],length:a[1],size:R(i,"size",1,Gt)})}let s=0;if(Object.hasOwn(n,"lobes")){let o=D(n,"lobes"),r=R(o,"count",1,qt),i=R(o,"length",1,qt);t.set("lobes",{count:r,length:i,size:R(o,"size",1,Gt)}),s=r*i}if(s!==(e===null?0:e.latents))throw A("codebooks.lobes");return t}function Or(n,e,t){let s=new Map,o=e?.latents??0;if(Object.hasOwn(n,"lobes")&&!o)throw A("scalars.lobes");for(let[r,i]of[...Sr,["lobes",o]]){if(r==="opacity"&&!Object.hasOwn(n,r)&&e!==null||i===0)continue;let c=D(n,r),[l,f,h]=["least","size","middle"].map(g=>_e(c,g)),[d,p]=r==="appearance"&&t?Zs:[i,i],u=l.length;if(u<d||u>p||f.length!==u||h.length!==u)throw A(`scalars.${r}`);let m=Math.fround(W(c,"step"));if(!(m>=wr&&m<=gr))throw A(`scalars.${r}.step`);let w=l.map((g,E)=>{let _={least:l[E],size:f[E],middle:h[E]},v=R(_,"least",-$t,$t),k=R(_,"size",1,Gt),S=R({size:v+k-1},"size",v,$t);if(r==="scale"&&S*m>br)throw A("scalars.scale");let F=Math.max(-v,S)+.5;if(r==="rotation"&&F*m>vr)throw A("scalars.rotation");return{least:v,size:k,middle:R(_,"middle",v,S)}});s.set(r,{step:m,columns:w})}return s}function zr(n){let e=We(n,"center",3),t=Math.fround(W(n,"radius"));if(e.some(s=>Math.abs(s)>Math.fround(qe)))throw A("positions.center");if(t<_r||t>qe)throw A("positions.radius");return{center:e,radius:t,exponent:R(n,"exponent",0,14)}}function Fr(n){let{name:e}=n;if(typeof e!="string")throw A("name");if(!Qs.includes(e))throw new x(`the .mgs file has the weighting '${tn(e)}': known are ${Qs.join(", ")}`);let t={name:e,exponent_max:W(n,"exponent_max"),sigma:W(n,"sigma"),background_weight:W(n,"background_weight"),alpha_min:n.alpha_min===void 0?1/255:W(n,"alpha_min")};if(!(t.exponent_max>0&&t.exponent_max<=80))throw A("exponent_max");if(!(t.sigma>0&&t.sigma<=qe))throw A("sigma");if(t.background_weight<0)throw A("background_weight");if(!(t.alpha_min>=1e-4&&t.alpha_min<=.1))throw A("alpha_min");return t}function Ur(n){let{antialiased:e,soft_edge:t}=n;if(typeof e!="boolean")throw A("footprint.antialiased");if(typeof t!="boolean")throw A("footprint.soft_edge");let s=W(n,"blur");if(!(s>0&&s<=4))throw A("footprint.blur");return{blur:s,antialiased:e,soft_edge:t}}function Ir(n){let e=D({views:n},"views"),t=We(e,"viewmat",16),s=We(e,"K",9);if(![0,0,0,1].every((i,a)=>t[12+a]===i)||![0,0,1].every((i,a)=>s[6+a]===i)||s[0]<=0||s[4]<=0)throw new x("a view's matrices in the .mgs file are not those of a camera");let r=R(e,"width",1,Xs);return{viewmat:t,K:s,width:r,height:R(e,"height",1,Xs)}}function Nr(n){let e=Object.entries(n);if(e.length>Ks)throw new x(`the .mgs file has ${e.length} notes: ${Ks} are allowed`);for(let[t,s]of e){let o=s===null||typeof s=="boolean"||He(s,Ys),r=typeof s=="number"&&Math.abs(s)<=2**53;if(!(o||r)||!He(t,Ys))throw new x(`the note '${t.slice(0,40)}' is not a short text or a number`)}return n}function D(n,e){let t=n[e];if(typeof t!="object"||t===null||Array.isArray(t))throw A(e);return t}function _e(n,e){let t=n[e];if(!Array.isArray(t))throw A(e);return t}function R(n,e,t,s){let o=W(n,e);if(!Number.isInteger(o)||o<t||o>s)throw A(e);return o}function W(n,e){return en(n[e],e)}function We(n,e,t){let s=_e(n,e);if(s.length!==t)throw A(e);return Float32Array.from(s,o=>en(o,e))}function en(n,e){if(typeof n!="number"||!(Math.abs(n)<=3e38))throw A(e);return n}function tn(n){return typeof n!="object"||n===null?String(n).slice(0,40):Array.isArray(n)?"a list":"an object"}function A(n){return new x(`the field '${n}' in the header of the .mgs file is missing or invalid`)}var le=[77,71,83,26,13,10,0,1],Ht=[2,3,4],je=20,Cr=2**20,Pr=256,Dr=2**32,Br=[["ply","a PLY scene: train or compress it first"],["PK","a zip archive (perhaps .sog)"],["\x8B","a gzip file (perhaps .spz)"],["NGSP","an .spz scene"],["glTF","a binary glTF file"],["\xFD7zXZ","an xz file (perhaps another program's comp.xz)"],["\x89PNG","a PNG picture"],["\xFF\xD8\xFF","a JPEG picture"],["<","a web page"],["{","a JSON text"]],Xe=class{received=0;total=1/0;fields=null;table=[];#e=[];#t=0;#o=0;#n=!1;#s=null;append(e){if(e.length>0&&this.#e.push(e),this.received+=e.length,this.#t+=e.length,!this.#r())return[];if(this.received>this.total)throw new x(`the .mgs file has ${this.received-this.total} bytes too many at its end`);let t=[];for(let s;(s=this.table[this.#o])&&Wt(s.bytes)<=this.#t;)this.#o++,t.push($r(s,this.#a(Wt(s.bytes))));return t}end(){if(this.fields!==null){let t=this.table[this.#o];if(t===void 0)return;throw new x(`the .mgs file ends inside its stream '${t.name}': it has been cut short`)}if(!this.#n)throw new x(sn(this.#a(this.#t)));let e=this.#s===null?"first bytes":"header";throw new x(`the .mgs file ends inside its ${e}: it has been cut short`)}#r(){if(!this.#n&&this.#t>=le.length){let e=this.#a(le.length);if(le.some((t,s)=>t!==e[s]))throw new x(sn(e));this.#n=!0}if(this.#n&&this.#s===null&&this.#t>=je-le.length&&(this.#s=this.#a(je-le.length)),this.#s!==null&&this.fields===null){let e=Gr(this.#s);this.#t>=e&&this.#i(this.#s,this.#a(e))}return this.fields!==null}#i(e,t){let s=$(e).getUint32(8,!0);if((je+t.length)%8||Ge(t,Ge(e.subarray(0,8)))!==s)throw new x("the header of the .mgs file is damaged (wrong checksum)");this.fields=qr(t);let o=$(e).getUint16(0,!0);if((o===2||o===4&&this.fields.layers===void 0)&&(this.fields.layers=[this.fields.count]),o<4&&(this.fields.footprint=Ve),this.table=Hr(this.fields.streams),this.total=this.table.reduce((r,i)=>r+Wt(i.bytes),je+t.length),this.total>Dr)throw new x(`the .mgs file claims ${this.total} bytes, too many for a scene`)}#a(e){this.#t-=e;let t=this.#e[0];if(t!==void 0&&t.length>e)return this.#e[0]=t.subarray(e),t.subarray(0,e);let s=new Uint8Array(e),o=0,r=0;for(;o<e;){let i=this.#e[r],a=i.subarray(0,e-o);s.set(a,o),o+=a.length,a.length<i.length?this.#e[r]=i.subarray(a.length):r++}return this.#e.splice(0,r),s}};function Wt(n){return Math.ceil(n/8)*8}function $r(n,e){let t=e.subarray(0,n.bytes);if(Ge(t)!==n.crc32)throw new x(`the stream '${n.name}' of the .mgs file is damaged (wrong checksum)`);if(e.subarray(n.bytes).some(s=>s!==0))throw new x(`the .mgs file is damaged after its stream '${n.name}'`);return{name:n.name,codec:n.codec,data:t}}function Gr(n){let e=$(n),t=e.getUint16(0,!0),s=e.getUint32(4,!0);if(!Ht.includes(t))throw new x(`the .mgs file is of version ${t}.${e.getUint16(2,!0)}, this program reads ${Ht[0]}.x to ${Ht[2]}.x: reload the page, or write the file again with this version of mobilegs`);if(s>Cr)throw new x(`the header of the .mgs file claims ${s} bytes: it is damaged`);return s}function qr(n){let e;try{e=JSON.parse(new TextDecoder("utf-8",{fatal:!0,ignoreBOM:!0}).decode(n))}catch{throw new x("the header of the .mgs file is not valid JSON")}if(typeof e!="object"||e===null||Array.isArray(e))throw new x("the header of the .mgs file is not a JSON object");return e}function Hr(n){if(!Array.isArray(n)||n.length>Pr)throw new x("the header of the .mgs file lacks a table of streams");let e=new Set;return n.map(t=>{let{name:s,codec:o,bytes:r,crc32:i}=Object(t);if(!([s,o].every(c=>He(c,64))&&[r,i].every(c=>Number.isInteger(c)&&c>=0&&c<2**40)))throw new x("the header of the .mgs file has a broken table of streams");if(e.has(s))throw new x(`the .mgs file has two streams called '${s}'`);return e.add(s),{name:s,codec:o,bytes:r,crc32:i}})}function sn(n){if(n.length===0)return"the file is empty, not a .mgs scene";if(le.findIndex((o,r)=>o!==n[r])>=Math.min(3,n.length))return"the first bytes of the .mgs file are damaged: transfer it again, in binary mode";let t=String.fromCharCode(...n),s=Br.find(([o])=>t.startsWith(o));return s?`this is not a .mgs scene but looks like ${s[1]}`:"this is not a .mgs scene"}var Vt=class{header=null;decoder=null;#e=new Xe;get received(){return this.#e.received}get total(){return this.#e.total}append(e){let t=this.#e.append(e),{fields:s,table:o,total:r}=this.#e;s!==null&&this.decoder===null&&(this.header=Js(s,r),this.decoder=new $e(this.header,o));for(let i of t)this.decoder?.accept(i)}end(){this.#e.end()}step(){return this.decoder?.step(this.received)??!1}};async function nn(n,e){let t=new Vt,s=n.getReader();try{for(let o=0;;){o-=performance.now();let{value:r,done:i}=await s.read();if(o+=performance.now(),i)break;t.append(r);do await e(t,o);while(t.step())}}catch(o){throw await s.cancel().catch(()=>{}),o}return t.end(),t}var Yt=16,jt=6*Yt,G=64,Ke=13,Xt=.01,Kt=6,on=15,{fround:N,sqrt:Wr}=Math,Ye=class{#e;#t;#o;#n;constructor(e,t,{static2:s,view2:o}){let r=3+o.length/9,i=new Float32Array(12*r);for(let a=0;a<12;a++){let c=a<3?s.subarray(3*a,3*a+3):o.subarray((a-3)*(r-3));i.set(c.subarray(0,r-3),a*r+(a<3?0:3))}this.#e=e,this.#t=e.block(r),this.#o=e.layer(i,r),this.#n=t}decode(e,t,s){P(t,this.#t.numbers,y,s,s+e.length/3),this.#e.apply(this.#o,this.#t,this.#n,1)}},Qe=class{#e;#t;#o;#n;#s;#r;#i;constructor(e,t,{both1:s,static2:o,view2:r}){this.#e=e,this.#t=[e.layer(s,Kt),e.layer(o,G),e.layer(r,G)],this.#o=e.block(Kt),this.#n=e.block(2*G),this.#s=[e.part(this.#n,0,G),e.part(this.#n,G,G)],this.#r=t,this.#i=e.part(t,3,12)}decode(e,t,s){let o=this.#e,[r,i,a]=this.#t;P(t,this.#o.numbers,y,s,s+e.length/3),o.apply(r,this.#o,this.#n,Xt),o.apply(i,this.#s[0],this.#r,1),o.apply(a,this.#s[1],this.#i,1)}},Ze=class{#e;#t;#o;#n;#s;#r;#i;#a;#c;#l;constructor(e,t,{context1:s,context2:o,static1:r,static2:i,view1:a,view2:c},l){this.#e=e,this.#t=[e.layer(s,jt),e.layer(o,G),e.layer(r,Ke+3),e.layer(i,G),e.layer(a,Ke+3),e.layer(c,G)],this.#l=2**l,this.#o=e.block(Kt),this.#n=e.block(jt),this.#s=e.block(G),this.#r=e.block(Ke+3),this.#i=e.part(this.#r,Ke,3),this.#a=t,this.#c=e.part(t,3,12)}decode(e,t,s){let o=this.#e,[r,i,a,c,l,f]=this.#t,[h,d]=[this.#o.numbers,this.#i.numbers],[p,u,m]=[this.#n,this.#s,this.#r];this.#u(e,p.numbers),o.apply(r,p,u,0),o.apply(i,u,m,1),P(t,h,y,s,s+e.length/3),d.set(h.subarray(0,3*y)),o.apply(a,m,u,Xt),o.apply(c,u,this.#a,1),d.set(h.subarray(3*y)),o.apply(l,m,u,Xt),o.apply(f,u,this.#c,1)}#f(e,t){let s=U(e[t])*this.#l,o=U(e[t+1])*this.#l,r=U(e[t+2])*this.#l,i=N(N(N(s*s)+N(o*o))+N(r*r));return Math.max(1,N(Wr(i)))}#u(e,t){for(let s=0,o=0;o<e.length;s++,o+=3){let r=this.#f(e,o),i=N(2-N(1/r));for(let a=0;a<3;a++){let c=U(e[o+a])*this.#l,l=N(i*N(c/r));Vr(l,t,a*Yt*y+s)}}}};function Vr(n,e,t){let s=N(N(n*.25)+.5),o=Math.sin(Math.PI*s),r=Math.cos(Math.PI*s);for(let i=t+Yt*y;t<i;t+=y){e[t]=o,e[t+jt/2*y]=r;let a=2*o*r;r=1-2*o*o,o=a}}var et=.28209479177387814,Je=class{#e;#t;#o;#n;#s;#r;#i;constructor(e,t,s,{degree:o,latents:r,hidden:i},a){let c=2*(o+1)**2,l=i.at(-1)??0,f=[19+r,...i];this.#e=e,this.#o=s,this.#t=i.map((u,m)=>e.layer(a[`weights.${m}`],f[m],a[`offsets.${m}`]));let h=a[`weights.${i.length}`],d=jr(h,l,a.basis,r,c);this.#t.push(e.layer(d,l+r,a.bias)),this.#n=e.block(r);let p=i.length?[19,...i]:[0];this.#s=p.map(u=>e.block(Math.ceil(u/4)*4+r)),this.#r=[0,p.length-1].map(u=>e.part(this.#s[u],p[u],r)),this.#i=i.length?new ae(e,t,this.#s[0]):null}decode(e,t,s){let[o,r,i]=[this.#e,this.#s,this.#t.length-1];this.#i?.write(),e&&P(e,this.#n.numbers,y,t,s),this.#r[0].numbers.set(this.#n.numbers);for(let a=0;a<i;a++)o.apply(this.#t[a],r[a],r[a+1],0);this.#r[1].numbers.set(this.#n.numbers),o.apply(this.#t[i],r[i],this.#o,1)}};function jr(n,e,t,s,o){let r=e+s,i=new Float32Array(o*r);for(let a=0;a<o;a++){for(let c=0;c<e;c++)i[a*r+c]=n[a*e+c];for(let c=0;c<s;c++)i[a*r+e+c]=t[c*o+a]}return i}function ke(n,e){for(let t=0;t<e.length;t++)n.fill(e[t],t*y,(t+1)*y)}var Xr=1/3,Kr=[1,0,0,0],fe=class{#e;#t=new Ne;#o;#n;#s;#r;#i;#a;#c;#l;#f;constructor(e){let{header:t,samples:s}=e,{lobes:o,grid:r}=t,i=this.#t;this.#e=e;let a=o?.degree??0,c=i.block(on),l={logScales:i.block(3),scales:i.block(3),quats:i.block(4),sh:i.part(c,0,12),lobes:i.block(2*(a+1)**2+2),statics:i.block(t.network?19:0),words:i.block(18)};this.#o=l.quats,this.#s=o&&new Je(i,l,l.lobes,o,e.lobes),this.#r=t.network?new ae(i,l,l.statics):null;let{appearance:f}=e;t.colors==="linear"?this.#n=new Ye(i,c,f):t.colors==="latent_networks"?this.#n=new Qe(i,c,f):this.#n=new Ze(i,c,f,r.exponent),i.allocate(),this.#c=Object.fromEntries([...e.books].map(([p,u])=>[p,{...u,columns:[]}])),this.#l=rn(this.#h("scale")),this.#f=rn(xe(this.#h("scale")));let h=Object.fromEntries(Object.entries(l).map(([p,{numbers:u}])=>[p,u])),d=Qr(this.#l);this.#i={...h,count:0,lobeDegree:a,scaleRange:d,memory:i.wasmMemory},this.#a={sh:this.#u(s),lobes:[0,1/et]},this.#s&&(this.#a.lobes=this.#p(this.#s))}#u(e){let{sh:t}=this.#i,s=new Float64Array(12),o=xe(this.#h("appearance"));for(let r=0;r<e.length;r+=3*y){let i=e.subarray(r,r+3*y);this.#n.decode(i,o,0);for(let a=0;a<12;a++)for(let c=0;3*c<i.length;c++)s[a]+=3*t[a*y+c]/e.length}return s}#p(e){let{scales:t,quats:s,sh:o,lobes:r}=this.#i,i=this.#c.lobes;return P(this.#f,t,y,0,y),ke(s,Kr),ke(o,this.#a.sh),e.decode(i?xe(i):null,0,y),Array.from({length:r.length/y-2},(a,c)=>r[c*y])}decode({positions:e,columns:t},s=0){let{header:o}=this.#e,r=e.subarray(3*s,3*(s+y)),i=r.length/3,a=s+i,[c,l]=[this.#i,this.#c];c.count=i,c.positions=r;let{logScales:f,scales:h,quats:d,sh:p,lobes:u}=c,{scale:m,rotation:w,appearance:g}=t,E=!0;for(let v of Object.keys(l)){let k=t[v];k?this.#h(v).columns=k:E=!1}this.#l.columns=m,P(this.#h("scale"),f,y,s,a),P(this.#l,h,y,s,a);let _=o.scalars.get("rotation");if(_?Bs(_,w,s,a,d):(P(this.#h("rotation"),d,y,s,a),this.#t.units(this.#o,this.#o)),g?this.#n.decode(r,this.#h("appearance"),s):ke(p,this.#a.sh),this.#s&&E?this.#s.decode(l.lobes??null,s,a):ke(u,this.#a.lobes),l.opacity){let{books:[v]}=t.opacity?l.opacity:xe(l.opacity),k=t.opacity?.[0];Yr(u,v,k,s,i)}return this.#r?.write(),c}get network(){return this.#r!==null}get lobeDegree(){return this.#i.lobeDegree}get scaleRange(){return this.#i.scaleRange}get neutral(){let e=[0,1,2].map(r=>.5+et*this.#a.sh[r]),[t,s,o]=this.#f.books.map(([r])=>r);return{color:e,side:Xr*Math.cbrt(t*s*o)}}#h(e){return this.#c[e]}};function Yr(n,e,t,s,o){for(let r=0;r<o;r++)n[r]+=e[t?t[s+r]:0]/et}function rn(n){return{...n,books:n.books.map(e=>e.map(Math.exp))}}function Qr({books:n}){let e=[1/0,-1/0];for(let t of n)for(let s of t)e=[Math.min(e[0],s),Math.max(e[1],s)];return e}function an(n){let[e,t,s]=[1,2,3].map(c=>n[`hidden${c}.weight`]),o=["opacity","phi"].map(c=>({weights:Zr(n[`${c}.weight`],s,128),offset:n[`${c}.weight`].reduce((l,f,h)=>l+f*n["hidden3.bias"][h],n[`${c}.bias`][0])})),r=new Float32Array(16*2497),i=0,a=(c,l,f)=>{for(let h=c;h<c+4;h++)for(let d=l;d<l+4;d++)r[i++]=f(h,d)};for(let c=0;c<256;c+=4)for(let l=0;l<24;l+=4)a(c,l,(f,h)=>h<22?e[22*f+h]:h===22?n["hidden1.bias"][f]:0);for(let c=0;c<128;c+=4)a(c,0,(l,f)=>f===0?n["hidden2.bias"][l]:0);for(let c=0;c<256;c+=4)for(let l=0;l<128;l+=4)a(l,c,(f,h)=>t[256*f+h]);for(let c=0;c<128;c+=4)a(0,c,(l,f)=>o[l]?.weights[f]??0);return a(0,0,(c,l)=>l===0?o[c]?.offset??0:0),r}function Zr(n,e,t){return Array.from({length:t},(s,o)=>n.reduce((r,i,a)=>r+i*e[t*a+o],0))}var{fround:z}=Math,Jr=["mobile_gs","no_depth","no_scale","sort_free_gs"],ei=H(-1e4),ti=[2047,2047,1023],cn=z(511/Math.SQRT1_2),ln=888,Ae=new Uint32Array(1),tt=new Float32Array(Ae.buffer);function fn({sorted:n,weighting:e,footprint:t,background:s,grid:o,lobes:r},i,a,c=null){let l=r?.degree??0,[f,h]=dn(a);return{count:i,packing:{center:Array.from(o.center),unit:o.radius*2**o.exponent,leastScaleBits:f,scaleBitsSpan:h},...hn(c?10:un(l),i),network:c&&an(c),shSize:4,lobeSize:(l+1)**2,sorted:n,weighting:{index:Jr.indexOf(e.name),exponentMax:e.exponent_max,sigma:e.sigma,backgroundWeight:e.background_weight,alphaMin:e.alpha_min},footprint:t,background:Array.from(s)}}function st(n,e,t=hn(Qt(n),e.positions.length/3)){let s=e.positions.length/3,o=Qt(n),r=4*y,i;for(let a=0;a<s;a+=y){let c=n.decode(e,a);i??=si(c);let l=i();t.shapes.set(l.subarray(0,4*c.count),4*a),t.colors.set(l.subarray(r,r+4*c.count),4*a),t.lobes.set(l.subarray(2*r,2*r+o*c.count),o*a)}return t}var hn=(n,e)=>({shapes:new Uint32Array(4*e),colors:new Uint32Array(4*e),lobes:new Uint32Array(n*e)});function dn(n){let[e,t]=n.map(s=>(tt[0]=s,z(Ae[0])));return[e,t-e]}var un=n=>(n+1)**2+2>>1,Qt=({network:n,lobeDegree:e})=>n?10:un(e);function si(n,e=!1){let{scales:t,quats:s,sh:o,lobes:r,lobeDegree:i,statics:a,scaleRange:c,memory:l}=n,{buffer:f,byteOffset:h,length:d}=n.words,p=new Uint32Array(f,h,d),[u,m]=dn(c),w=m>0?z(1/m):0,g=e?null:ie(l),[E,_,v,k]=[t,s,o,r].map(({byteOffset:X})=>X),S=a.length>0,[F,j]=[(i+1)**2-1,Qt({network:S,lobeDegree:i})];return()=>{g?g.pack(E,_,v,k,h,F,j,u,w):ni(n,p,j,u,w),S&&oi(a,p);let{count:X,positions:Q}=n;for(let ge=0,Ot=0;ge<X;ge++,Ot+=4)p[Ot]=Q[3*ge]|Q[3*ge+1]<<16,p[Ot+1]|=Q[3*ge+2];return p}}function ni({scales:n,quats:e,sh:t,lobes:s,lobeDegree:o},r,i,a,c){let l=2*(o+1)**2;for(let f=0;f<y;f++){let h=8*y+i*f,d=ai(s,f,l,r,h);ii(t,f,r,4*(y+f)),r[4*f+1]=d<<16;let p=0;for(let m=2;m>=0;m--){tt[0]=n[m*y+f];let w=z(z(z(Ae[0])-a)*c);p=p<<11|z(z(ti[m]*Math.min(Math.max(w,0),1))+.5)}r[4*f+2]=p;let u=[0,1,2,3].map(m=>e[m*y+f]);r[4*f+3]=ri(u),u.some(Boolean)||(r[h]=ei|r[h]&4294901760)}}function oi(n,e){for(let t=0;t<y;t++){let s=8*y+10*t;e[s]=e[s]&65535|Math.round(32767*n[t])<<16;for(let o=1;o<10;o++){let[r,i]=[2*o-1,2*o].map(a=>Math.round(32767*n[a*y+t]));e[s+o]=r&65535|i<<16}}}function ri(n){let e=0;for(let o=1;o<4;o++)Math.abs(n[o])>Math.abs(n[e])&&(e=o);let t=n[e]<0?-cn:cn,s=e;for(let o=0;o<4;o++)o!==e&&(s=s<<10|z(z(t*n[o])+1024.5)&1023);return s}function ii(n,e,t,s){let o=c=>n[c*y+e],r=Array.from({length:9},(c,l)=>o(3+l)),i=wn(r),a=r.map(c=>mn(i,c));t[s]=H(o(0))|H(o(1))<<16,t[s+1]=H(o(2))|i<<16|a[0]<<24;for(let c of[1,5])t[s+1+(c+3>>2)]=pn(a,c)}function ai(n,e,t,s,o){let r=f=>n[f*y+e],i=Array.from({length:t-2},(f,h)=>r(2+h)),[a,c]=[0,1].map(f=>wn(i.filter((h,d)=>d%2===f))),l=i.map((f,h)=>mn(h%2?c:a,f));s[o]=H(r(0))|H(r(1))<<16;for(let f=0,h=o+1;f<l.length;f+=4,h++)s[h]=pn(l,f);return a|c<<8}var pn=(n,e)=>n[e]|n[e+1]<<8|n[e+2]<<16|n[e+3]<<24;function mn(n,e){Ae[0]=n+ln<<20;let t=z(z(127/tt[0])*e);return z(Math.min(Math.max(t,-127),127)+512.5)&255}function wn(n){return tt[0]=Math.max(0,...n.map(Math.abs)),Math.min(Math.max((Ae[0]+1048575>>20)-ln,0),255)}function Zt(){let n=URL.createObjectURL(new Blob([`(${bundle})()`],{type:"text/javascript"}));return setTimeout(()=>URL.revokeObjectURL(n),6e4),new Worker(n)}function gn(n,e){let t=globalThis.preloadedWorker;delete globalThis.preloadedWorker;let s;return t&&"url"in n&&t.url===n.url?(s=t.worker,t.messages.forEach(e)):(t?.worker.terminate(),s=Zt(),s.postMessage(n)),s.onmessage=e,s}async function bn(){let n=globalThis.preloadedAdapter;return delete globalThis.preloadedAdapter,await n??navigator.gpu.requestAdapter({powerPreference:"high-performance"})}async function vn(n){return b[n]}function yn(){return"0.1.0"}function xn(){let n=document.getElementById("scene");if(n===null)return null;let e=atob(n.textContent),t=new Uint8Array(e.length);for(let s=0;s<t.length;s++)t[s]=e.charCodeAt(s);return new Blob([t])}var En=8192,ci=1e5,li=3,fi=2,hi=8,nt=class{results=[];#e=[];#t;#o=null;#n=null;#s=[];#r;#i=null;#a;#c;#l=!1;#f=!1;#u=()=>{};#p=()=>{};#h=new Promise((e,t)=>{this.#u=e,this.#p=t});constructor(e){this.#h.catch(()=>{});let t=0;for(let[s,o]of e.entries()){for(let r=0;r<o;r+=En)this.#e.push({level:s,from:r,to:Math.min(r+En,o),first:t+r});t+=o}this.#t=new Uint8Array(e.length),this.#a=new Uint8Array(this.#e.length),this.#c=this.#a.slice(),this.#r=t}set output(e){if(this.#i=e,e!==null)for(let[t,s]of this.results.splice(0))kn(s,_n(e,this.#r,t,t+s.shapes.length/4))}spawn(){let{decoderInputs:e}=this.#o,t=this.#r<ci?1:navigator.hardwareConcurrency;for(let s=1;s<Math.min(t,li+1);s++)this.#g(e)}#g(e){try{let t=Zt();t.postMessage({decoderInputs:e});let s={worker:t,jobs:0};t.onmessage=({data:o})=>{s.jobs--,this.#x(o),this.#_(s)},t.onerror=o=>o.preventDefault(),this.#s.push(s)}catch{}}start(e){return this.#o=e,this.#n=new fe(e.decoderInputs)}advance(e,t){if(!(t<=this.#t[e])){this.#t[e]=t;for(let s of this.#s)this.#_(s);this.#E().catch(this.#p)}}finish(){return this.#f=!0,this.#k(),this.#h}terminate(){for(let{worker:e}of this.#s)e.terminate()}get#b(){return this.#a.findIndex((e,t)=>e<this.#v(t))}get#w(){let e=this.#b;return e<0?this.#c.findIndex((t,s)=>t<this.#v(s)):e}#v(e){return this.#t[this.#e[e].level]}#d(e,t){let{levels:s}=this.#o,{level:o,from:r,to:i}=this.#e[e];return s[o].rows(r,i,t)}#y(e){let{first:t,from:s,to:o}=this.#e[e];return this.#i?_n(this.#i,this.#r,t,t+o-s):void 0}#_(e){for(let t;e.jobs<fi&&(t=this.#b)>=0;e.jobs++){let s=this.#a[t]=this.#v(t),o=this.#d(t,"slice"),r=[o.positions,...Object.values(o.columns).flat()].map(({buffer:i})=>i);e.worker.postMessage({rows:o,chunk:t,stage:s},{transfer:r})}}async#E(){if(!this.#l){this.#l=!0;for(let e;(e=this.#w)>=0&&this.#n;){let t=this.#a[e]=this.#v(e),s=st(this.#n,this.#d(e,"subarray"),this.#y(e));this.#x({chunk:e,stage:t,packed:s}),await Jt()}this.#l=!1}}#x({chunk:e,stage:t,packed:s}){if(t<=this.#c[e])return;this.#c[e]=t;let o=this.#y(e);o===void 0?this.results.push([this.#e[e].first,s]):o.shapes.buffer!==s.shapes.buffer&&kn(s,o),this.#k()}get firstLevelReady(){return this.#e.every(({level:e},t)=>e>0||this.#c[t]>0)}get levels(){let e=this.#c.findIndex(t=>t<Ee);return e<0?this.#t.length:this.#e[e].level}#k(){this.#f&&this.#w<0&&this.#u()}};function _n(n,e,t,s){let o=r=>{let i=n[r].length/e;return n[r].subarray(i*t,i*s)};return{shapes:o("shapes"),colors:o("colors"),lobes:o("lobes")}}function kn(n,e){for(let t of Object.keys(e))e[t].set(n[t])}var An=0;async function Jt(){if(performance.now()-An<hi)return;let{port1:n,port2:e}=new MessageChannel;await new Promise(t=>{n.onmessage=()=>{n.close(),t(null)},e.postMessage(null)}),An=performance.now()}function ot(n,[e,t,s]){let o=n.length/3,r=new Float32Array(o);for(let l=0;l<o;l++)r[l]=e*n[3*l]+t*n[3*l+1]+s*n[3*l+2];let i=new Uint32Array(r.buffer);for(let l=0;l<o;l++)i[l]=i[l]&2147483648?i[l]:~i[l]&2147483647;let a=Uint32Array.from({length:o},(l,f)=>f),c=new Uint32Array(o);for(let l of[0,16]){let f=new Uint32Array(65537);for(let h=0;h<o;h++)f[(i[h]>>>l&65535)+1]+=1;for(let h=0;h<65536;h++)f[h+1]+=f[h];for(let h=0;h<o;h++){let d=a[h];c[f[i[d]>>>l&65535]++]=d}[a,c]=[c,a]}return a}var di=.28209479177387814,[ui,pi]=[13.8,-69],mi=new Map([["char",1],["int8",1],["uchar",1],["uint8",1],["short",2],["int16",2],["ushort",2],["uint16",2],["int",4],["int32",4],["uint",4],["uint32",4],["float",4],["float32",4],["double",8],["float64",8]]),Sn=["x","y","z","f_dc_0","f_dc_1","f_dc_2","opacity","scale_0","scale_1"];Sn.push("scale_2","rot_0","rot_1","rot_2","rot_3");function ts(n){return n[0]===112&&n[1]===108&&n[2]===121}function Mn(n){let{offsets:e,stride:t,rows:s,start:o}=wi(n),r=new DataView(n.buffer,n.byteOffset+o),i=[...e.keys()].filter(m=>m.startsWith("f_rest_")).length,a=i/3+1;if(![1,4,9,16].includes(a))throw new Error(`the .ply file has ${i} numbers f_rest_*: 0, 9, 24 or 45 were expected`);let c=m=>e.get(m),l=["x","y","z","scale_0","scale_1","scale_2","rot_0","rot_1","rot_2","rot_3"];l.push("opacity","f_dc_0","f_dc_1","f_dc_2");for(let m=0;m+1<a;m++)for(let w=0;w<3;w++)l.push(`f_rest_${w*(a-1)+m}`);let f=l.find(m=>!e.has(m));if(f)throw new Error(`the .ply file has ${i} numbers f_rest_*, but not ${f}`);let h=l.map(c),d=ss(s,a),p=new Float32Array(h.length);for(let m=0;m<s;m++){for(let g=0;g<p.length;g++)p[g]=r.getFloat32(m*t+h[g],!0);for(let g=3;g<6;g++)p[g]===-1/0&&(p[g]=pi);Math.abs(p[10])===1/0&&(p[10]=Math.sign(p[10])*ui);let w=0;for(let g=0;g<p.length;g++)w+=p[g]*0;w===0&&ns(d,p)}let{count:u}=d;return u===s||(d.shapes=d.shapes.slice(0,12*u),d.colors=d.colors.slice(0,3*a*u),d.lobes=d.lobes.slice(0,2*u)),d}function es(n=""){return`'${n.slice(0,40).replace(/[^\x20-\x7e]/g,"\uFFFD")}'`}function ss(n,e){return{count:0,packing:null,shapes:new Float32Array(12*n),colors:new Float32Array(3*e*n),shSize:e,lobes:new Float32Array(2*n),lobeSize:1,sorted:!0,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},background:[0,0,0]}}function ns(n,e){let[t,s,o,r]=[e[6],e[7],e[8],e[9]],i=t*t+s*s+o*o+r*r;if(!(i>0))return;let a=2/i,[c,l,f]=[Math.exp(e[3]),Math.exp(e[4]),Math.exp(e[5])];if(!(c+l+f<1e30&&Math.abs(e[10])<1e30))return;let h=n.count++;n.shapes.set([c*(1-a*(o*o+r*r)),c*a*(s*o+t*r),c*a*(s*r-t*o),e[0],l*a*(s*o-t*r),l*(1-a*(s*s+r*r)),l*a*(o*r+t*s),e[1],f*a*(s*r+t*o),f*a*(o*r-t*s),f*(1-a*(s*s+o*o)),e[2]],12*h),n.lobes[2*h]=e[10]/di,n.colors.set(e.subarray(11),3*n.shSize*h)}function wi(n){let e=new TextDecoder("latin1").decode(n.subarray(0,65536)),t=/\nend_header\r?\n/.exec(e);if(!ts(n)||t===null)throw new Error("this is not a PLY file, or its header is cut off");let s=e.slice(0,t.index).split(/\r?\n/).map(d=>d.trim().split(/\s+/)),o=s.find(d=>d[0]==="format")?.[1];if(o!=="binary_little_endian")throw new Error(`the .ply file is ${es(o)}: only binary_little_endian is read`);let r=s.findIndex(d=>d[0]==="element"),i=s[r]??[],a=/^\d+$/.test(i[2])?Number(i[2]):NaN;if(i[1]!=="vertex"||!Number.isSafeInteger(a)||a<0)throw new Error("the .ply file does not begin with its vertices, as those of 3DGS do");let c=new Map,l=0;for(let d of s.slice(r+1)){if(d[0]==="element")break;if(d[0]!=="property")continue;let p=mi.get(d[1]);if(p===void 0)throw new Error(`the .ply file has a property of type ${es(d[1])}`);if(d.length!==3)throw new Error("the .ply file has a property without a name, or with two");if(c.has(d[2]))throw new Error(`the .ply file has the property ${es(d[2])} twice`);(d[1]==="float"||d[1]==="float32")&&c.set(d[2],l),l+=p}let f=Sn.filter(d=>!c.has(d));if(f.length)throw new Error(`the .ply file is not a Gaussian scene: it lacks ${f.join(", ")} as floats`);let h=t.index+t[0].length;if(h+a*l>n.length)throw new Error(`the .ply file is cut off: ${a} Gaussians were announced`);return{offsets:c,stride:l,rows:a,start:h}}var B="the compressed data is damaged or cut off";var se=class{left;#e;constructor(e){let t=e[e.length-1];if(!t)throw new Error(B);this.#e=e,this.left=8*e.length-1-Math.clz32(t)+24}take(e){return e>24?this.take(e-16)*65536+this.take(16):(this.left-=e,this.#t(this.left,e))}decode(e,{width:t,symbols:s,bits:o}){for(let r=0;r<e.length;r++){let i=this.#t(this.left-t,t);e[r]=s[i],this.left-=o[i]}if(this.left!==0)throw new Error(B)}#t(e,t){let s=this.#e;if(e<0)return e+t>0?this.#t(0,e+t)<<-e:0;let o=e>>3;return(s[o]|s[o+1]<<8|s[o+2]<<16|s[o+3]<<24)>>>(e&7)&(1<<t)-1}};function Tn(n){let e=new Uint8Array(1);return{accuracy:0,symbols:Uint8Array.of(n),bits:e,bases:new Uint16Array(1)}}function Se(n,e){let t=1<<n,s={accuracy:n,symbols:new Uint8Array(t),bits:new Uint8Array(t),bases:new Uint16Array(t)},o=t;for(let[c,l]of e.entries())l===-1&&(s.symbols[--o]=c);let r=(t>>1)+(t>>3)+3,i=0;for(let[c,l]of e.entries())for(let f=0;f<l;f++){s.symbols[i]=c;do i=i+r&t-1;while(i>=o)}if(i!==0)throw new Error(B);let a=e.map(c=>Math.abs(c));for(let c=0;c<t;c++){let l=a[s.symbols[c]]++,f=n-(31-Math.clz32(l));s.bits[c]=f,s.bases[c]=(l<<f)-t}return s}function os(n,e,t,s){let o=8*e,r=l=>{let f=o>>3,d=(n[f]|n[f+1]<<8|n[f+2]<<16)>>(o&7)&(1<<l)-1;return o+=l,d},i=5+r(4);if(i>t)throw new Error(B);let a=[];for(let l=1<<i;l>0;){let f=32-Math.clz32(l+1),h=(1<<f)-2-l,d=r(f-1);d>=h&&r(1)&&(d+=(1<<f-1)-h);let p=d-1;l-=Math.abs(p),a.push(p);for(let u=p===0?3:0;u===3;){u=r(2);for(let m=0;m<u;m++)a.push(0)}if(l<0||a.length>s)throw new Error(B)}let c=o+7>>3;if(c>n.length)throw new Error(B);return{table:Se(i,a),end:c}}function Rn(n,e){let t=n[e++];if(!(t<128)){let l=t-127,f=e+(l+1>>1);if(!(f<=n.length))throw new Error(B);let h=d=>n[e+(d>>1)]>>(d%2?0:4)&15;return{weights:Array.from({length:l},(d,p)=>h(p)),end:f}}let s=e+t;if(s>n.length)throw new Error(B);let{table:o,end:r}=os(n.subarray(0,s),e,6,13),i=new se(n.subarray(r,s)),a=[],c=[i.take(o.accuracy),i.take(o.accuracy)];for(let l=0;a.length<255;l^=1){let f=c[l];if(a.push(o.symbols[f]),c[l]=o.bases[f]+i.take(o.bits[f]),i.left<0)return a.push(o.symbols[c[l^1]]),{weights:a,end:s}}throw new Error(B)}function Ln(n){let e=c=>c>0?1<<c-1:0,t=0;for(let c of n)t+=e(c);let s=32-Math.clz32(t),o=(1<<s)-t;if(t===0||s>11||o&o-1)throw new Error(B);let r=[...n,32-Math.clz32(o)];if(r.length>256)throw new Error(B);let i={width:s,symbols:new Uint8Array(1<<s),bits:new Uint8Array(1<<s)},a=0;for(let c=1;c<=s;c++)for(let[l,f]of r.entries()){if(f!==c)continue;let h=a+e(c);i.symbols.fill(l,a,h),i.bits.fill(s+1-c,a,h),a=h}return i}var gi=4247762216,bi=25481893,Me=1<<17,T="the compressed data is damaged or cut off";function Fn(n,e){let t=[];for(let s of e)t.push(n),n+=2**s;return{bits:e,bases:t}}var On=Fn(0,[...Array(16).fill(0),1,1,1,1,2,2,3,3,4,6,7,8,9,10,11,12,13,14,15,16]),zn=Fn(3,[...Array(32).fill(0),1,1,1,1,2,2,3,3,4,4,5,7,8,9,10,11,12,13,14,15,16]),vi=[{accuracy:9,symbols:36,usual:Se(6,[4,3,2,2,2,2,2,2,2,2,2,2,2,1,1,1,2,2,2,2,2,2,2,2,2,3,2,1,1,1,1,1,-1,-1,-1,-1])},{accuracy:8,symbols:32,usual:Se(5,[1,1,1,1,1,1,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1])},{accuracy:9,symbols:53,usual:Se(6,[1,4,3,2,2,2,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1,-1,-1])}],rs=class{length=0;bytes;#e;constructor(e){this.#e=e,this.bytes=new Uint8Array(Math.min(e,Me))}reserve(e){let t=this.length+e;if(t>this.#e)throw new Error("the compressed data is longer than announced");if(t<=this.bytes.length)return;let s=new Uint8Array(Math.min(this.#e,Math.max(t,2*this.bytes.length)));s.set(this.bytes.subarray(0,this.length)),this.bytes=s}append(e){this.reserve(e.length),this.bytes.set(e,this.length),this.length+=e.length}fill(e,t){this.reserve(t),this.bytes.fill(e,this.length,this.length+t),this.length+=t}repeat(e,t){if(!(e>0&&e<=this.length))throw new Error(T);this.reserve(t);let{bytes:s}=this,o=this.length+t;if(e>=t)s.copyWithin(this.length,this.length-e,o-e);else for(let r=this.length;r<o;r++)s[r]=s[r-e];this.length=o}};function Un(n,e){let t=new rs(e),s=new DataView(n.buffer,n.byteOffset,n.byteLength),o=0;for(;o<n.length;){if(o+8>n.length)throw new Error(T);let r=s.getUint32(o,!0);if(r>>>4===bi)o+=8+s.getUint32(o+4,!0);else if(r===gi)o=yi(n,o+4,t);else throw new Error(T)}if(o!==n.length||t.length!==e)throw new Error(T);return t.bytes}function yi(n,e,t){let s=n[e++],o=(s&32)!==0;if(o||(e+=1),n.subarray(e,e+=[0,1,2,4][s&3]).some(a=>a))throw new Error("the compressed data needs a dictionary, which is missing");e+=[o?1:0,2,4,8][s>>6];let i={huffman:null,tables:[null,null,null],recent:[1,4,8]};for(let a=!1;!a;){if(e+3>n.length)throw new Error(T);let c=n[e]|n[e+1]<<8|n[e+2]<<16;e+=3,a=(c&1)===1;let l=c>>1&3,f=c>>3,h=l===1?1:f;if(l===3||f>Me||e+h>n.length)throw new Error(T);l===0?t.append(n.subarray(e,e+f)):l===1?t.fill(n[e],f):xi(n.subarray(e,e+f),i,t),e+=h}return e+(s&4?4:0)}function xi(n,e,t){let{literals:s,end:o}=ki(n,e),r=o,i=n[r++];if(i===void 0)throw new Error(T);if(i===255?(i=n[r]+(n[r+1]<<8)+32512,r+=2):i>127&&(i=(i-128<<8)+n[r++]),i===0){t.append(s);return}let a=n[r++];if(!(i>0)||a===void 0||a&3)throw new Error(T);for(let[c,{accuracy:l,symbols:f,usual:h}]of vi.entries()){let d=a>>6-2*c&3;if(d===0)e.tables[c]=h;else if(d===1){if(!(n[r]<f))throw new Error(T);e.tables[c]=Tn(n[r++])}else if(d===2){let{table:p,end:u}=os(n,r,l,f);e.tables[c]=p,r=u}}Ei(new se(n.subarray(r)),i,s,e,t)}function Ei(n,e,t,{tables:s,recent:o},r){let[i,a,c]=s;if(!i||!a||!c)throw new Error(T);let l=n.take(i.accuracy),f=n.take(a.accuracy),h=n.take(c.accuracy),d=0,p=r.length+Me;for(let u=e;u>0;u--){let m=a.symbols[f],w=c.symbols[h],g=i.symbols[l],E=2**m+n.take(m),_=zn.bases[w]+n.take(zn.bits[w]),v=On.bases[g]+n.take(On.bits[g]);if(u>1&&(l=i.bases[l]+n.take(i.bits[l]),h=c.bases[h]+n.take(c.bits[h]),f=a.bases[f]+n.take(a.bits[f])),n.left<0||d+v>t.length)throw new Error(T);if(r.append(t.subarray(d,d+v)),d+=v,r.repeat(_i(E,v,o),_),r.length>p)throw new Error(T)}if(n.left!==0)throw new Error(T);r.append(t.subarray(d))}function _i(n,e,t){if(n>3)return t.unshift(n-3),t.pop(),t[0];let s=e===0?n:n-1,o=s<3?t[s]:t[0]-1;return s>0&&(t.splice(Math.min(s,2),1),t.unshift(o)),o}function ki(n,e){let t=n[0]|n[1]<<8|n[2]<<16,s=n[0]&3,o=n[0]>>2&3;if(s<2){let d=[1,2,1,3][o],p=d===1?n[0]>>3:(t&(d===2?65535:16777215))>>4,u=d+(s===0?p:1);if(p>Me||!(u<=n.length))throw new Error(T);return s===0?{literals:n.subarray(d,u),end:u}:{literals:new Uint8Array(p).fill(n[d]),end:u}}let r=[3,3,4,5][o],i=[10,10,14,18][o],a=(t>>>0)+(n[3]??0)*2**24+(n[4]??0)*2**32,c=Math.floor(a/16)%2**i,l=Math.floor(a/2**(4+i))%2**i,f=r+l;if(c>Me||!(f<=n.length))throw new Error(T);let h=r;if(s===2){let{weights:d,end:p}=Rn(n.subarray(0,f),h);e.huffman=Ln(d),h=p}if(e.huffman===null)throw new Error(T);return{literals:Ai(n.subarray(h,f),c,o!==0,e.huffman),end:f}}function Ai(n,e,t,s){let o=new Uint8Array(e);if(!t)return new se(n).decode(o,s),o;if(n.length<6)throw new Error(T);let r=e+3>>2;for(let i=0,a=6;i<4;i++){let c=i<3?n[2*i]|n[2*i+1]<<8:n.length-a;if(a+c>n.length)throw new Error(T);let l=i<3?(i+1)*r:e;if(l>e)throw new Error(T);new se(n.subarray(a,a+c)).decode(o.subarray(i*r,l),s),a+=c}return o}var Si=1347635022,Mi=1e7,rt=16,Nn=32,Cn=[0,3,8,15,24],Ti=15,Ri=.15,Li=[-1,-1,1,-1,1,1,-1,1,-1,1,-1,-1,1,-1,1],ne="the .spz file is damaged or cut off";function Pn(n){return n[0]===78&&n[1]===71&&n[2]===83&&n[3]===80||n[0]===31&&n[1]===139}async function Dn(n){if(n[0]!==31){let r=Bn(n,n.length);return In(r,zi(r,n))}let{header:e,content:t}=await Oi(n),s=[],o=rt;for(let r of is(e))s.push(t.subarray(o,o+=r));return In(e,s)}function Bn(n,e){let t=new DataView(n.buffer,n.byteOffset,n.byteLength);if(n.length<rt||t.getUint32(0,!0)!==Si)throw new Error("this is not a .spz file");let s=t.getUint32(4,!0),o=s<4;if(s<1||s>4)throw new Error(`the .spz file has version ${s}: 1 to 4 are read`);if(!o&&n.length<Nn)throw new Error(ne);let r=t.getUint32(8,!0),[i,a,c,l]=n.subarray(12,16);if(r>Mi)throw new Error(`the .spz file announces ${r} Gaussians, too many to be drawn`);if(r>e)throw new Error(`the .spz file announces ${r} Gaussians in ${e} bytes: it is cut off`);if(i>4||a>24)throw new Error(ne);let f=(c&2)!==0;return{version:s,count:r,degree:i,fraction:a,extended:f,streams:l,table:o?0:t.getUint32(16,!0)}}function is({version:n,count:e,degree:t}){return[n===1?6:9,1,3,3,n<3?3:4,3*Cn[t]].map(s=>s*e)}async function Oi(n){let t=new Response(n).body.pipeThrough(new DecompressionStream("gzip")).getReader(),s=[],o=0,r=null,i=1/0,a=async()=>new Uint8Array(await new Blob(s).arrayBuffer());for(;o<=i;){let{value:c,done:l}=await t.read().catch(()=>{throw new Error(ne)});if(l)break;if(s.push(c),o+=c.length,r===null&&o>=rt){if(r=Bn(await a(),n.length),r.version>3)throw new Error("this is not a .spz file");i=is(r).reduce((f,h)=>f+h,rt)}}if(r===null)throw new Error("this is not a .spz file");if(o>i&&(await t.cancel().catch(()=>{}),!r.extended))throw new Error("the .spz file holds more than it announces");if(o<i)throw new Error(`the .spz file is cut off: ${r.count} Gaussians were announced`);return{header:r,content:await a()}}function zi(n,e){let{streams:t,table:s,version:o}=n,r=is(n),i=s+16*t,a=r.filter(h=>h>0).length;if(o!==4||s<Nn||i>e.length||t!==a)throw new Error(ne);let c=new DataView(e.buffer,e.byteOffset,e.byteLength),[l,f]=[s,i];return r.map(h=>{if(h===0)return new Uint8Array(0);let d=Number(c.getBigUint64(l,!0)),p=Number(c.getBigUint64(l+8,!0));if(l+=16,f+d>e.length||p!==h)throw new Error(ne);let u=e.subarray(f,f+=d);try{return Un(u,h)}catch(m){throw new Error(`${ne}: ${m instanceof Error?m.message:m}`)}})}function In({version:n,count:e,degree:t,fraction:s},o){let[r,i,a,c,l,f]=o,h=Cn[t],d=Math.min(h,Ti),p=d+1,u=ss(e,p),m=new Float32Array(11+3*p),w=n===1?Ui(r):Fi(r,2**-s),g=n<3?Ii:Ni;for(let E=0;E<e;E++){m[0]=w(3*E),m[1]=-w(3*E+1),m[2]=-w(3*E+2);for(let v=0;v<3;v++)m[3+v]=c[3*E+v]/16-10;g(l,E,m);let _=Math.min(Math.max(i[E]/255,1e-6),1-1e-6);m[10]=Math.log(_/(1-_));for(let v=0;v<3;v++)m[11+v]=(a[3*E+v]/255-.5)/Ri;for(let v=0;v<d;v++)for(let k=0;k<3;k++)m[14+3*v+k]=Li[v]*(f[3*(h*E+v)+k]-128)/128;ns(u,m)}return u}function Fi(n,e){return t=>{let s=3*t;return e*((n[s]<<8|n[s+1]<<16|n[s+2]<<24)>>8)}}function Ui(n){return e=>{let t=U(n[2*e]|n[2*e+1]<<8);if(!Number.isFinite(t))throw new Error(ne);return t}}function Ii(n,e,t){let[s,o,r]=[0,1,2].map(a=>n[3*e+a]/127.5-1),i=Math.sqrt(Math.max(0,1-s*s-o*o-r*r));t.set([i,s,-o,-r],6)}function Ni(n,e,t){let s=4*e,o=n[s]|n[s+1]<<8|n[s+2]<<16|n[s+3]<<24,r=o>>>30,i=[0,0,0,0],a=1;for(let c=0,l=20;c<4;c++){if(c===r)continue;let f=(o>>l&511)/511*Math.SQRT1_2;i[c]=o>>l+9&1?-f:f,a-=f*f,l-=10}i[r]=Math.sqrt(Math.max(0,a)),t.set([i[3],i[0],-i[1],-i[2]],6)}var Ci=8192,Pi=.2,Di=2**20,$n=1500,Bi=8,Wn=["shapes","colors","lobes"],de=new Float32Array(0),q=(n,e=[])=>self.postMessage(n,{transfer:e}),Vn=({shapes:n,colors:e,lobes:t})=>[n.buffer,e.buffer,t.buffer];async function $i(n){if("file"in n)return{source:n.file.stream(),total:n.file.size};let e;try{e=await fetch(n.url)}catch{throw new Error(`${n.url} cannot be reached: is the address right, the network there, and may this site load it (CORS)?`)}if(!e.ok||e.body===null)throw new Error(`${n.url} could not be loaded: the server says ${e.status}`);let t=e.headers.has("Content-Encoding")?NaN:Number(e.headers.get("Content-Length"));return{source:e.body,total:t||NaN}}var as=class{#e;#t;#o;#n;#s;#r=0;#i=null;#a=!1;constructor(e,t,s,o,r){this.#e=e,this.#s=r,this.#t=t,this.#o=s,this.#n=o;let{grid:i,views:a,near:c}=e,l=Array.from(e.background),{color:f,side:h}=o.neutral,d=It(Ps(t[0].positions,Ci),i),p=h*Math.sqrt(3*e.count/d.length),u={means:d,color:f,side:p,background:l};q({kind:"dots",dots:u,views:a,near:c},[u.means.buffer])}send(e){if(!this.#o.firstLevelReady||!this.allocate(e))return;let t=this.#o.levels,s=this.#r;this.#r=Math.max(t,1);let o=this.#o.results.splice(0),r=this.#i;if(r){this.#i=this.#o.output=null;let{views:i,near:a}=this.#e;q({kind:"scene",data:r,means:this.#c(),views:i,near:a},Vn(r));return}for(let[i,a]of o)for(let c of Wn){let l=a[c];q({kind:"rows",part:c,from:i,numbers:l},[l.buffer])}s!==this.#r&&q({kind:"more",means:this.#c()})}allocate(e){let{count:t}=this.#e;return!this.#a&&Bi*e>=t&&(this.#i=this.#o.output=fn(this.#e,t,this.#n.scaleRange,this.#s),this.#a=!0),this.#a}#c(){let e=this.#t.slice(0,this.#r),t=new Uint16Array(e.reduce((r,{count:i})=>r+3*i,0)),s=0;for(let{positions:r,count:i}of e)t.set(r,s),s+=3*i;let o={stored:t,grid:this.#e.grid};return this.#e.sorted&&(de=Be(o)),o}};async function Gi(n){let e=null,t=null,[s,o]=[0,0],r=[],i=async({header:a,decoder:c,received:l,total:f},h)=>{if(q({kind:"progress",received:l,total:f}),a===null||c===null)return;o=l,e??=new nt(a.lodSizes);let d=r=c.levels,p=h*(f/l-1)>$n;d[0].positions&&!t&&(t=new as(a,d,e,e.start(c),c.network),e.spawn(),s=setInterval(()=>t?.send(o),$n)),t?.allocate(l);for(let[u,{stage:m}]of d.entries())t&&(m===Bt||p&&u===0&&m>=Ee)&&e.advance(u,m);await Jt()};try{await nn(n,i)}finally{for(let[a,{stage:c,positions:l}]of r.entries())t&&l&&c>=Ee&&e?.advance(a,c);await e?.finish().finally(()=>{clearInterval(s),e?.terminate()}),t?.send(o)}return o}async function Gn(n,e,t){let[s,o]=[new Uint8Array(e||Di),0],r=n.getReader();for(let a;!(a=await r.read()).done;){let c=o+a.value.length;if(c>s.length){let l=s;s=new Uint8Array(Math.max(c,2*s.length)),s.set(l)}s.set(a.value,o),o=c,q({kind:"progress",received:o,total:e})}let i=await t(s.subarray(0,o));if(!i.count)throw new Error("there is no Gaussian in this file that can be drawn");de=new Float32Array(3*i.count);for(let a=0;a<de.length;a++)de[a]=i.shapes[4*a+3];return q({kind:"scene",data:i,means:de,views:[],near:Pi},Vn(i)),o}async function qi(n){let e=n.getReader(),t=()=>e.read().catch(()=>{throw new Error("the file broke off before its end: load it again")}),s=await t(),o=s?.value??new Uint8Array(0),r=new ReadableStream({async pull(i){let{value:a,done:c}=s??await t();s=null,c?i.close():i.enqueue(a)},cancel:()=>e.cancel()});return{first:o,whole:r}}async function qn(n){let e=performance.now();try{let{source:t,total:s}=await $i(n),{first:o,whole:r}=await qi(t),i;ts(o)?i=await Gn(r,s,Mn):Pn(o)?i=await Gn(r,s,Dn):i=await Gi(r),q({kind:"done",milliseconds:performance.now()-e,bytes:i})}catch(t){let{message:s}=t,o=t instanceof RangeError?`the scene is too large for this device: ${s}`:s;q({kind:"failed",sentence:o})}}var Hn;function jn(){self.onmessage=async({data:n})=>{if("decoderInputs"in n){Hn=new fe(n.decoderInputs);return}if("rows"in n){let{rows:e,chunk:t,stage:s}=n,o=st(Hn,e),r=Wn.map(i=>o[i].buffer);self.postMessage({chunk:t,stage:s,packed:o},{transfer:r});return}if("forward"in n){let e=ot(de,n.forward);q({kind:"order",order:e},[e.buffer]);return}await qn(n)},self.name&&qn({url:self.name})}var it=()=>({name:"",before:"",failed:"",state:"",share:NaN,sentence:""}),Te=class{#e=[it(),it()];begin(e,t){let s=this.#e[e].name;this.#e[e]=t===void 0?it():{...it(),name:t,before:s,state:"loading"}}fail(e,t,s){let{name:o,before:r}=this.#e[e];this.note(e,{share:1,state:"failed",sentence:t,failed:this.names[e],name:s?r:o})}note(e,t){Object.assign(this.#e[e],t)}get state(){let e=this.#e.map(({state:s})=>s);return["failed","loading","loaded"].find(s=>e.includes(s))??""}get busy(){return this.#e.some(({state:e})=>e==="loading")}get share(){let e=this.#e.filter(({state:t})=>t).map(({share:t})=>t);return e.reduce((t,s)=>t+s,0)/e.length}get sentence(){let e=this.#e.every(({state:s})=>s),t=this.#e.map(({state:s,sentence:o,failed:r})=>s!=="failed"?"":e&&r&&!o.includes(r)?`${r}: ${o}`:o);return[...new Set(t.filter(Boolean))].join("; ")}get names(){return Hi(this.#e[0].name,this.#e[1].name)}};function Hi(n,e){let[t,s]=[n,e].map(o=>o.split("/").filter(Boolean));for(let o=1;o<=Math.max(t.length,s.length);o++){let[r,i]=[t,s].map(a=>a.slice(-o).map(cs).join("/"));if(r!==i)return[r,i]}return[cs(t[t.length-1]??""),cs(s[s.length-1]??"")]}function cs(n){try{return decodeURIComponent(n)}catch{return n}}function at(n){let e=n?.trim().toLowerCase()??"",t=/^([0-9a-f]{3}|[0-9a-f]{6})$/.test(e)?`#${e}`:e,s=/^#[0-9a-f]+$/.test(t)?t:Wi(t),o=s.length===4?s.replace(/[^#]/g,"$&$&"):s;if(!/^#[0-9a-f]{6}$/.test(o))return null;let r=i=>Number.parseInt(o.slice(i,i+2),16)/255;return[r(1),r(3),r(5)]}function Xn(n){let e=t=>Math.round(255*Math.min(Math.max(t,0),1));return`#${n.map(t=>e(t).toString(16).padStart(2,"0")).join("")}`}function Wi(n){let e=n?document.createElement("canvas").getContext("2d"):null;if(!e)return"";let[t,s]=["#000000","#ffffff"].map(o=>(e.fillStyle=o,e.fillStyle=n,String(e.fillStyle)));return t===s?t:""}function Kn(n,e,t){let s=f=>n.querySelector(`[name=${f}]`);s("background").value=Xn(e.background);let o=s("scale"),r=e.scale??0;[...o.options].some(({value:f})=>Number(f)===r)||o.add(new Option(`${Math.round(100*r)} %`,String(r))),o.value=String(r),s("mode").value=e.mode,s("turning").checked=e.turning,s("stats").checked=t;let{renderer:i,adapter:a}=e.device,c=i?`Rendered with ${i}${a?` on ${a}`:""}`:"";n.querySelector(".device").textContent=c;let l=n.querySelector("[data-act=view]");l.hidden=e.views.length<2}function Yn(n,e){let{name:t,value:s}=n;t==="background"?e.background=at(s):t==="scale"?e.scale=Number(s)||null:t==="mode"?e.mode=s==="fly"?"fly":"orbit":t==="turning"&&(e.turning=n.checked),e.redraw()}var Vi=new Map([["ArrowLeft",-.02],["ArrowDown",-.02],["ArrowRight",.02],["ArrowUp",.02],["PageDown",-.1],["PageUp",.1],["Home",-1],["End",1]]),ct=class{share=.5;#e;#t;#o=["",""];constructor(e,t){this.#e=e,this.#t=t,e.onpointerdown=({pointerId:s})=>e.setPointerCapture(s),e.onpointermove=({pointerId:s,clientX:o})=>{if(!e.hasPointerCapture(s))return;let{left:r,width:i}=t.getBoundingClientRect();this.#n((o-r)/i)},e.onkeydown=s=>{let o=Vi.get(s.key);o===void 0||s.ctrlKey||s.metaKey||s.altKey||(s.preventDefault(),this.#n(this.share+o))}}show(e){this.#o=e,this.#e.querySelectorAll("span").forEach((t,s)=>t.textContent=e[s]),this.#e.setAttribute("aria-label",`${e[0]} on the left, ${e[1]} on the right`),this.#e.hidden=!1,this.#t.classList.add("drawn"),this.#n(this.share)}#n(e){this.share=Math.min(Math.max(e,0),1);let t=Math.round(100*this.share);this.#t.style.clipPath=`inset(0 0 0 ${100*this.share}%)`,this.#e.style.left=`${100*this.share}%`,this.#e.setAttribute("aria-valuenow",String(t));let[s,o]=this.#o;this.#e.setAttribute("aria-valuetext",`${t} % ${s}, ${100-t} % ${o}`)}};var Qn=':host{display:block;position:relative;overflow:hidden;contain:strict;color-scheme:light dark;--paper: #16181dd9;--ink: #f3f4f6;--accent: #7db4ff;--wall: #0d0f12;--field: #ffffff1c;background:var(--wall);color:var(--ink);font:14px/1.4 system-ui,sans-serif;min-height:120px}@media(prefers-color-scheme:light){:host{--paper: #ffffffd9;--ink: #16181d;--accent: #0b62d6;--wall: #e8eaee;--field: #0000000f}}canvas{opacity:0;display:block;width:100%;height:100%;touch-action:none;cursor:grab;outline:none}canvas.drawn{opacity:1}canvas.polite{touch-action:pan-y}canvas:active{cursor:grabbing}canvas.reached{outline:2px solid var(--accent);outline-offset:-2px}.over{position:absolute;inset:0;pointer-events:none}.split{position:absolute;top:0;bottom:0;width:20px;margin-left:-10px;cursor:ew-resize;touch-action:none;outline:none}.split:before{content:"";position:absolute;inset:0 9px;background:#fff;box-shadow:0 0 3px #000a}.split:after{content:"\\2039\\2002\\203a";position:absolute;top:50%;left:-12px;width:44px;height:44px;margin-top:-22px;border-radius:50%;background:var(--paper);line-height:40px;text-align:center;font-size:20px;box-shadow:0 0 0 2px #fff,0 0 5px 2px #000a}.split:focus-visible:after{box-shadow:0 0 0 3px var(--accent)}.split span{position:absolute;top:12px;padding:2px 8px;border-radius:6px;background:var(--paper);max-width:40vw;overflow:hidden;text-overflow:ellipsis;white-space:nowrap}.split span:first-child{right:18px}.split span:last-child{left:18px}[hidden]{display:none!important}.bar{position:absolute;inset:0 0 auto;height:3px;background:transparent}.bar>div{height:100%;width:0;background:var(--accent);transition:width .15s}.bar.unknown>div{width:100%!important;animation:wait 1.2s ease-in-out infinite alternate}@keyframes wait{0%{opacity:.2}}@media(prefers-reduced-motion:reduce){.bar>div{transition:none;animation:none!important}}.panel{position:absolute;background:var(--paper);border-radius:10px;padding:12px 16px;backdrop-filter:blur(8px)}.panel:focus{outline:none}.message,.help,.report{inset:0;margin:auto;width:fit-content;height:fit-content;max-width:min(34em,92%);max-height:92%;box-sizing:border-box;overflow:auto}.message{overflow-wrap:anywhere}.stats{top:12px;left:12px;font-variant-numeric:tabular-nums;white-space:pre;pointer-events:none}.split:not([hidden])~.stats{top:52px}.said{right:12px;top:12px;pointer-events:none}.said:not(.seen){clip-path:inset(50%)}h2{font-size:16px;margin:0 0 8px}.help dl{display:grid;grid-template-columns:fit-content(45%) 1fr;gap:4px 16px;margin:0 0 12px}.help dt{font-weight:600}.help dd{margin:0}.buttons{position:absolute;right:12px;left:12px;bottom:calc(12px + env(safe-area-inset-bottom));display:flex;flex-wrap:wrap;justify-content:end;gap:8px;pointer-events:none}.settings{right:12px;bottom:calc(68px + env(safe-area-inset-bottom));width:min(26em,calc(100% - 24px));box-sizing:border-box;max-height:calc(100% - 80px);overflow:auto}@media(max-height:500px){.settings{bottom:12px;max-height:calc(100% - 24px);columns:2;width:min(40em,calc(100% - 24px))}}.settings p{display:flex;flex-wrap:wrap;align-items:center;gap:8px;margin:0 0 8px}.settings p>label{flex:1}.settings>label{display:flex;align-items:center;gap:8px;min-height:36px}.settings>small{display:block;margin:8px 0 12px;overflow-wrap:anywhere}button,select,[type=color]{font:inherit;color:inherit;background:var(--paper);border:0;border-radius:10px;min-width:44px;min-height:44px;padding:0 9px;cursor:pointer;pointer-events:auto}.panel :is(button,select,[type=color]){background:var(--field)}[type=color]{padding:6px}[type=checkbox]{width:20px;height:20px;margin:0;accent-color:var(--accent)}button:hover{color:var(--accent)}:is(button,select,input,textarea):focus-visible{outline:2px solid var(--accent)}textarea{font:12px/1.3 ui-monospace,monospace;color:inherit;background:transparent;max-width:100%}.drop{inset:12px;border:2px dashed var(--accent);display:grid;place-items:center}';var ji=[["Drag","rotate the scene"],["Two fingers, right button or Shift","move sideways"],["Pinch or wheel","zoom in and out"],["Double tap","look at that point"],["Arrow keys","rotate"],["W A S D Q E","fly; hold Shift to fly faster"],["M","switch between orbiting and looking around"],["V","next training camera"],["R","back to the first view"],["F","full screen"],["P","save a picture"],["I","frame rate and size"],["O","settings"],["H","help"]],Zn=`
<style>${Qn}</style>
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
<dl>${ji.map(([n,e])=>`<dt>${n}</dt><dd>${e}</dd>`).join("")}</dl>
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
<div class="panel drop" hidden>Drop a scene to open it, or two to compare them</div>`,ls=new Map(Object.entries({r:"reset",m:"mode",f:"full",h:"help",i:"stats",o:"settings",p:"picture",v:"view"}));var Jn=new Map([["KeyW",[0,0,1]],["KeyS",[0,0,-1]],["KeyA",[-1,0,0]],["KeyD",[1,0,0]],["KeyQ",[0,1,0]],["KeyE",[0,-1,0]]]),eo=new Map([["ArrowLeft",[-1,0]],["ArrowRight",[1,0]],["ArrowUp",[0,-1]],["ArrowDown",[0,1]]]),lt=class{#e;#t;#o=new AbortController;#n=new Map;#s=new Set;#r=!1;#i={x:0,y:0,time:0};constructor(e,t){this.#e=e,this.#t=t;let s=(o,r)=>e.addEventListener(o,r,{signal:this.#o.signal,passive:!1});s("pointerdown",o=>this.#c(o)),s("pointermove",o=>this.#l(o)),s("pointerup",o=>this.#f(o)),s("pointercancel",o=>this.#f(o)),s("wheel",o=>this.#b(o)),s("contextmenu",o=>o.preventDefault()),s("keydown",o=>this.#w(o,!0)),s("keyup",o=>this.#w(o,!1)),s("blur",()=>this.#s.clear())}get busy(){return this.#s.size>0}advance(e){if(!this.busy)return;let t=this.#t.pose(),s=.9*t.reach*e*(this.#r?4:1);for(let o of this.#s){let r=Jn.get(o);r&&t.move(r[0]*s,r[1]*s,r[2]*s);let i=eo.get(o);i&&this.#a(i[0]*1.5*e,i[1]*1.5*e)}this.#t.changed()}destroy(){this.#o.abort()}#a(e,t){let s=this.#t.pose();this.#t.mode()==="orbit"?s.orbit(e,t):s.look(e,t)}#c(e){this.#e.focus({preventScroll:!0}),this.#e.setPointerCapture(e.pointerId),this.#n.set(e.pointerId,{x:e.offsetX,y:e.offsetY});let{x:t,y:s,time:o}=this.#i,r=Math.hypot(e.offsetX-t,e.offsetY-s)<20,i=this.#n.size===1&&e.button===0;i&&r&&e.timeStamp-o<350&&this.#t.focus(e.offsetX,e.offsetY),this.#i={x:e.offsetX,y:e.offsetY,time:i?e.timeStamp:-1/0},this.#t.held(),e.preventDefault()}#l(e){let t=this.#n.get(e.pointerId);if(t===void 0)return;let s={x:e.offsetX,y:e.offsetY};Math.hypot(s.x-this.#i.x,s.y-this.#i.y)>6&&(this.#i.time=-1/0),this.#n.size===1?this.#u(s.x-t.x,s.y-t.y,e):this.#n.size===2&&this.#p(e.pointerId,s),this.#n.set(e.pointerId,s),this.#t.changed()}#f(e){this.#n.delete(e.pointerId)}#u(e,t,s){s.buttons&6||s.shiftKey||s.ctrlKey?this.#h(e,t):this.#a(e*.006,t*.006)}#p(e,t){let s=this.#n.get(e),o=[...this.#n].find(([a])=>a!==e)?.[1];if(s===void 0||o===void 0)return;let r=Math.hypot(s.x-o.x,s.y-o.y),i=Math.hypot(t.x-o.x,t.y-o.y);this.#t.mode()==="fly"?this.#t.pose().move(0,0,2*(i-r)*this.#g):r>0&&i>0&&this.#t.pose().dolly(r/i),this.#h((t.x-s.x)/2,(t.y-s.y)/2)}#h(e,t){this.#t.pose().move(-e*this.#g,-t*this.#g,0)}get#g(){let{target:e,eye:t}=this.#t.pose();return Math.hypot(...e.map((s,o)=>s-t[o]))/Math.max(this.#e.clientHeight,1)}#b(e){if(this.#e.classList.contains("polite")&&!e.ctrlKey&&!e.metaKey)return;e.preventDefault();let t=e.deltaMode===WheelEvent.DOM_DELTA_LINE?16:1,s=e.deltaY*t*(e.ctrlKey?8:1)*.0012,o=this.#t.pose();this.#t.mode()==="orbit"?o.dolly(Math.exp(s)):o.move(0,0,-s*o.reach),this.#t.changed()}#w(e,t){let{code:s}=e;if(this.#r=e.shiftKey,!t&&s.startsWith("Meta")&&this.#s.clear(),t&&(e.ctrlKey||e.metaKey||e.altKey)||!Jn.has(s)&&!eo.has(s))return;let o=t&&!this.#s.has(s);t?this.#s.add(s):this.#s.delete(s),o&&this.advance(.03),this.#t.changed(),e.preventDefault()}};var Xi={from:64,to:65536,times:4},Ki={from:32,to:1024,times:2},to=128,no="mobilegs variant 1";function oo(n,e){let t=null;try{t=e?.getItem(`${no} ${n.describe()}`)??null}catch{}return n.variants.find(s=>co(s)===t)??null}async function ro(n,e){let t={floats:!1,strips:!1},s={...t};if(await so(n,t,{...t,strips:!0},Xi,Yi)&&(s.strips=!0),n.variants.some(({floats:o})=>o)){let o={...s,floats:!0};await so(n,s,o,Ki,Qi)&&(s.floats=!0)}try{e?.setItem(`${no} ${n.describe()}`,co(s))}catch{}return s}async function io(n){n.setScene({...fs(1,1,()=>[0,0,1]),packing:{center:[0,0,0],unit:1,leastScaleBits:0,scaleBitsSpan:0},shapes:Uint32Array.of(0,15360,0,0),colors:new Uint32Array(4),shSize:4,lobes:new Uint32Array(5),lobeSize:9}),await n.drawUnseen(hs(1))}function ao(n){n.setDots({means:Float32Array.of(0,0,1),color:[0,0,0],side:1,background:[0,0,0]}),n.drawDots(hs(1)),n.setDots(null)}var co=({floats:n,strips:e})=>`${n} ${e}`;async function so(n,e,t,{from:s,to:o,times:r},i){let a=0;for(let c=s;;c*=r){let{scene:l,side:f}=i(c);n.setScene(l);let h=[1/0,1/0];for(let p=0;p<=3;p++)for(let[u,m]of[e,t].entries()){n.variant=m;let w=performance.now();await n.drawUnseen(hs(f)),p>0&&(h[u]=Math.min(h[u],performance.now()-w))}let d=Math.max(...h);if(c===s&&(a=d),d>Math.max(4,3*a)||c>=o)return h[1]<.85*h[0]}}function Yi(n){let e=Math.ceil(Math.sqrt(n)),t=o=>2*(o+.5)/e-1;return{scene:fs(n,.001,o=>[t(o%e),t(Math.floor(o/e)),1]),side:256}}function Qi(n){return{scene:fs(to,1,e=>[0,0,1+e/to]),side:n}}function fs(n,e,t){let s=new Float32Array(12*n);for(let o=0;o<n;o++){let[r,i,a]=t(o);s.set([e,0,0,r,0,e,0,i,0,0,e,a],12*o)}return{count:n,packing:null,shapes:s,colors:new Float32Array(3*n),shSize:1,lobes:new Float32Array(2*n).fill(1),lobeSize:1,sorted:!1,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},background:[0,0,0]}}function hs(n){return{viewmat:[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],fx:n/2,fy:n/2,cx:n/2,cy:n/2,width:n,height:n,near:.1}}function ue(n,e){let t=[[n,e]];for(let s=1;s<4;s++)t.push(t[s-1].map(o=>(o-(s===1?0:1)>>1)+2));return t}function ft(n,e){let[,...t]=ue(n,e),s=[[0,0]],o=0;for(let[,r]of t)s.push([n,o]),o+=r;return{places:s,size:[n+t[0][0],Math.max(e,o)]}}function pe({packing:n,shSize:e,lobeSize:t,network:s}){return n?{shapes:4,colors:4,lobes:s?10:t+2>>1}:{shapes:12,colors:3*e,lobes:2*t}}function lo(n){return U(n&65535)}var Re=208,ht=2**-6,fo=.3;function Le(n,e){let{fx:t,fy:s,cx:o,cy:r,width:i,height:a}=n;return{...n,fx:e*t,fy:e*s,cx:e*o,cy:e*r,width:e*i,height:e*a}}function dt(n,e,t,s,o){let{viewmat:r,fx:i,fy:a,cx:c,cy:l,width:f,height:h,near:d}=e,{background:p,weighting:u,packing:m,footprint:w=Ve}=n,g=fo*.5*f/i,E=fo*.5*h/a,_=[0,1,2].map(S=>-(r[S]*r[3]+r[4+S]*r[7]+r[8+S]*r[11])),v=new Float32Array(Re/4);v.set([...Array.from(r).slice(0,12),..._,d,i,a,c,l,-c/i-g,(f-c)/i+g,-l/a-E,(h-l)/a+E,...p,u.exponentMax,f,h,u.sigma,u.backgroundWeight,t]);let k=[n.count,n.shSize,n.lobeSize,u.index];if(new Int32Array(v.buffer).set(k,33),m){let{center:S,unit:F,leastScaleBits:j,scaleBitsSpan:X}=m;v.set([...S,F,j,X],40)}return v[46]=!n.sorted&&u.alphaMin||1/255,v[47]=w.blur,new Int32Array(v.buffer).set([Number(w.antialiased),Number(w.soft_edge&&!n.sorted)],48),v[50]=s,new Int32Array(v.buffer)[51]=o,v}var ut=class{milliseconds=null;#e;#t;#o=!1;#n=!1;#s=[];constructor(e){this.#e=e,this.#t=e.getExtension("EXT_disjoint_timer_query_webgl2")}start(){this.#n=this.#o&&!this.#s.length}pass(e){if(!this.#n)return;let[t,s]=[this.#e,this.#t.TIME_ELAPSED_EXT];if(this.#s.length&&t.endQuery(s),e){let o=t.createQuery();this.#s.push([e,o]),t.beginQuery(s,o)}else this.#n=!1}async time(){let e=this.#e;this.#o=this.#t!==null;let t=this.#s[this.#s.length-1];if(!t||this.#n)return;for(let o=0;o<100&&!e.getQueryParameter(t[1],e.QUERY_RESULT_AVAILABLE);o++)await new Promise(r=>setTimeout(r,5));let s=this.#s.map(([o,r])=>[o,e.getQueryParameter(r,e.QUERY_RESULT)/1e6]);e.getParameter(this.#t.GPU_DISJOINT_EXT)||(this.milliseconds=Object.fromEntries(s));for(let[,o]of this.#s.splice(0))e.deleteQuery(o)}forget(){this.#s=[],this.#n=!1}};function pt({color:n,side:e},{viewmat:t,fx:s,fy:o,cx:r,cy:i,width:a,height:c,near:l}){let[f,h,d]=[0,4,8].map(p=>Array.from(t).slice(p,p+4));return Float32Array.of(...f.map((p,u)=>2*(s*p+r*d[u])/a-d[u]),...h.map((p,u)=>d[u]-2*(o*p+i*d[u])/c),...d,...n,l,o*e/2,.002*c/2,2/a,2/c)}function mt({means:n}){let e=new Float32Array(6*n.length);for(let t=0,s=0;t<n.length;t+=3)for(let o=s+18;s<o;s+=3)e[s]=n[t],e[s+1]=n[t+1],e[s+2]=n[t+2];return e}var me=["shapes","colors","lobes","looks","opacities","order","color_sums","weight_sums","color_sums_1","weight_sums_1","color_sums_2","weight_sums_2"],wt=class{#e;#t=new Map;constructor(e){this.#e=e}make(e,t,[s,o]){let r=this.#e;r.deleteTexture(this.#t.get(e)??null);let i=r.createTexture();return this.#t.set(e,i),r.activeTexture(r.TEXTURE0+me.indexOf(e)),r.bindTexture(r.TEXTURE_2D,i),r.texStorage2D(r.TEXTURE_2D,1,t,s,o),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MIN_FILTER,r.NEAREST),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MAG_FILTER,r.NEAREST),i}upload(e,t,s){let o=this.#e,[r,,i]=t,a=gt(s.length/i);if(a[1]>o.getParameter(o.MAX_TEXTURE_SIZE))throw new Error("the scene has more Gaussians than this GPU's textures can hold");this.make(e,o[r],a),this.write(e,t,0,s)}write(e,[,t,s],o,r){let i=this.#e,a=r instanceof Float32Array?i.FLOAT:i.UNSIGNED_INT,c=r.length/s;i.activeTexture(i.TEXTURE0+me.indexOf(e));for(let l=0;l<c;){let[f,h]=[(o+l)%4096,Math.floor((o+l)/4096)],d=Math.min(4096-f,c-l),p=d===4096?Math.floor((c-l)/4096):1,u=l*s;i.texSubImage2D(i.TEXTURE_2D,0,f,h,d,p,i[t],a,r,u),l+=d*p}}destroy(){for(let e of this.#t.values())this.#e.deleteTexture(e)}};function gt(n){return[Math.max(1,Math.min(n,4096)),Math.max(1,Math.ceil(n/4096))]}var bt=128,ho=0,ds=["EXT_color_buffer_float","EXT_color_buffer_half_float"];function us(n){return["EXT_color_buffer_float","EXT_float_blend"].every(e=>n.getExtension(e))}function ps(n){for(let r of[...ds,"EXT_float_blend"])n.getExtension(r);let e=n.getExtension("WEBGL_provoking_vertex");e?.provokingVertexWEBGL(e.FIRST_VERTEX_CONVENTION_WEBGL),n.disable(n.DITHER);let t={view:n.createBuffer(),corners:n.createBuffer(),quads:n.createVertexArray(),looks:n.createFramebuffer(),sums:n.createFramebuffer(),enlarged:[n.createFramebuffer(),n.createFramebuffer()],programs:new Map,textures:new wt(n)};n.bindBufferBase(n.UNIFORM_BUFFER,ho,t.view),n.bufferData(n.UNIFORM_BUFFER,Re,n.DYNAMIC_DRAW),n.bindVertexArray(t.quads),n.bindBuffer(n.ELEMENT_ARRAY_BUFFER,t.corners);let s=[0,1,2,2,1,3],o=Array.from({length:bt},(r,i)=>s.map(a=>4*i+a));return n.bufferData(n.ELEMENT_ARRAY_BUFFER,Uint16Array.from(o.flat()),n.STATIC_DRAW),t}function uo(n,e,{sorted:t,packed:s,strips:o,leveled:r}){let{view:i,whole:a,project:c,splat:l,resolve:f}=e,h=s?e.packed:e.wide,p=Object.entries({SORTED:t,STRIPS:o,LEVELED:r}).map(([m,w])=>w?`#define ${m}
`:"").join(""),u=(m,w)=>{let g=ms(n,`${p}#define VERTEX
${i}${m}`,`${p}${i}${w}`);return n.useProgram(g),me.forEach((E,_)=>n.uniform1i(n.getUniformLocation(g,E),_)),n.uniformBlockBinding(g,n.getUniformBlockIndex(g,"View"),ho),g};return{project:u(a,`${h}${c}`),splat:u(`${h}${l}`,l),resolve:u(a,f),...r?{enlarge:u(a,`#define ENLARGE
${f}`)}:{}}}function ms(n,e,t){let s=n.createProgram();for(let[o,r]of[[n.VERTEX_SHADER,e],[n.FRAGMENT_SHADER,t]]){let i=n.createShader(o);n.shaderSource(i,`#version 300 es
${r}`),n.compileShader(i),n.attachShader(s,i),n.deleteShader(i)}if(n.linkProgram(s),!n.getProgramParameter(s,n.LINK_STATUS)&&!n.isContextLost()){let o=(n.getAttachedShaders(s)??[]).map(r=>n.getShaderInfoLog(r));throw o.push(n.getProgramInfoLog(s)),new Error(`this GPU refuses a shader: ${o.join(" ")}`)}return s}var vt=class{#e;#t=null;#o;#n;#s;#r=0;constructor(e,t){this.#e=e,this.#o=ms(e,`#define VERTEX
${t}`,t),this.#n=e.createVertexArray(),this.#s=e.createBuffer(),e.bindVertexArray(this.#n),e.bindBuffer(e.ARRAY_BUFFER,this.#s),e.enableVertexAttribArray(0),e.vertexAttribPointer(0,3,e.FLOAT,!1,0,0)}take(e){let[t,s]=[this.#e,e?mt(e):new Float32Array(0)];this.#t=e,this.#r=s.length/3,t.bindBuffer(t.ARRAY_BUFFER,this.#s),t.bufferData(t.ARRAY_BUFFER,s,t.STATIC_DRAW)}draw(e){let[t,s]=[this.#e,this.#t];s&&(t.bindFramebuffer(t.FRAMEBUFFER,null),t.viewport(0,0,e.width,e.height),t.disable(t.BLEND),t.clearBufferfv(t.COLOR,0,[...s.background,1]),t.useProgram(this.#o),t.uniform4fv(t.getUniformLocation(this.#o,"dots"),pt(s,e)),t.bindVertexArray(this.#n),t.drawArrays(t.TRIANGLES,0,this.#r))}destroy(){let e=this.#e;e.deleteProgram(this.#o),e.deleteVertexArray(this.#n),e.deleteBuffer(this.#s)}};var ws=new Float32Array(0),mo={shapes:["RGBA32UI","RGBA_INTEGER",4],colors:["RGBA32UI","RGBA_INTEGER",4],lobes:["R32UI","RED_INTEGER",1]},go={shapes:["RGBA32F","RGBA",4],colors:["RGB32F","RGB",3],lobes:["RG32F","RG",2]},Zi={...go,colors:["RGB16F","RGB",3],lobes:["RG16F","RG",2]},wo=["R32UI","RED_INTEGER",1],Oe=class n{static files=["view","wide","packed","whole","project","splat","resolve","dots"].map(e=>`${e}.glsl`);variant;levelSigma=0;supersampling=1;lost=null;onLost=()=>{};onRestored=()=>{};#e;#t;#o;#n=null;#s=mo;#r=null;#i="";#a;#c=e=>{e.preventDefault(),this.#n=this.#r=null,this.lost="the browser took the GPU away from this page: reload it if no picture returns",this.onLost(this.lost)};#l=()=>{this.#n=null,this.#o=ps(this.#e),this.#i="",this.#a.forget(),this.lost=null,this.onRestored()};static create(e,t,{floats:s=!1,strips:o=!1}={}){let r=e.getContext("webgl2",{alpha:!1,antialias:!1,depth:!1,powerPreference:"high-performance"});if(r===null)throw new Error("this browser cannot draw with WebGL2 here");if(!ds.some(i=>r.getExtension(i)))throw new Error("this GPU cannot draw into textures of floats");if(s&&!us(r))throw new Error("this GPU cannot blend 32-bit floats: use the variant halves");if(r.getParameter(r.MAX_TEXTURE_SIZE)<4096)throw new Error(`this GPU's textures are less than ${4096} pixels wide`);return new n(r,t,{floats:s,strips:o})}constructor(e,t,s){this.#e=e,this.#t=t,this.variant=s,this.#o=ps(e),this.#a=new ut(e),e.canvas.addEventListener("webglcontextlost",this.#c),e.canvas.addEventListener("webglcontextrestored",this.#l)}setScene(e){let t=this.#e;if(this.#n=null,e.network)throw new Error("this scene needs a network for every Gaussian in every frame, which takes WebGPU: open it in a browser that has it");this.#s=e.packing?mo:this.variant.floats?go:Zi;let{shapes:s,colors:o,lobes:r}=e;for(let[a,c]of Object.entries({shapes:s,colors:o,lobes:r}))this.#o.textures.upload(a,this.#s[a],c);t.bindFramebuffer(t.FRAMEBUFFER,this.#o.looks);let i=e.packing?[t.RG32UI,0]:[t.RGBA32F,t.R32F];["looks","opacities"].forEach((a,c)=>{let l=i[c]?this.#o.textures.make(a,i[c],gt(e.count)):null;t.framebufferTexture2D(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0+c,t.TEXTURE_2D,l,0)}),this.#v("textures of 32-bit numbers"),this.#n={...e,shapes:ws,colors:ws,lobes:ws},e.sorted&&this.#o.textures.upload("order",wo,Uint32Array.from({length:e.count},(a,c)=>c))}show(e){this.#n&&(this.#n.count=e)}update(e,t,s){if(this.#n===null)return;let o=this.#s[e];this.#o.textures.write(e,o,pe(this.#n)[e]/o[2]*t,s)}setDots(e){this.lost===null&&(this.#r??=new vt(this.#e,this.#t.dots),this.#r.take(e))}drawDots(e){this.#r&&(this.#f(e),this.#r.draw(e))}setOrder(e){if(this.#n!==null){if(e.length!==this.#n.count)throw new Error(`an order of ${e.length} Gaussians does not fit this scene`);this.#o.textures.write("order",wo,0,e)}}draw(e){this.#n!==null&&(this.#f(e),this.#a.start(),this.#u(this.#n,e),this.#p(this.#n,e,null,e.height-1),this.#a.pass())}async drawUnseen(e){let t=this.#e;if(this.#n&&this.#u(this.#n,e),t.readBuffer(t.COLOR_ATTACHMENT0),t.readPixels(0,0,1,1,t.RGBA,t.FLOAT,new Float32Array(4)),t.isContextLost())throw new Error("the graphics device was lost")}get milliseconds(){return this.#a.milliseconds}async time(){this.lost===null&&await this.#a.time()}async finished(){this.#e.bindFramebuffer(this.#e.FRAMEBUFFER,null),this.#e.readPixels(0,0,1,1,this.#e.RGBA,this.#e.UNSIGNED_BYTE,new Uint8Array(4))}get variants(){return(us(this.#e)?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}describe(){let e=this.#e,t=e.getExtension("WEBGL_debug_renderer_info");return String(e.getParameter(t?t.UNMASKED_RENDERER_WEBGL:e.RENDERER))}async pixels(e){if(this.#n===null)throw new Error("there is no scene to draw");let t=this.#e,{width:s,height:o}=e;this.#u(this.#n,e);let[r,i]=[t.createFramebuffer(),t.createRenderbuffer()];t.bindFramebuffer(t.FRAMEBUFFER,r),t.bindRenderbuffer(t.RENDERBUFFER,i),t.renderbufferStorage(t.RENDERBUFFER,t.RGBA32F,s,o),t.framebufferRenderbuffer(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0,t.RENDERBUFFER,i),this.#p(this.#n,e,r,0);let a=new Float32Array(4*s*o);return t.readPixels(0,0,s,o,t.RGBA,t.FLOAT,a),t.deleteFramebuffer(r),t.deleteRenderbuffer(i),a}destroy(){let e=this.#e,{view:t,corners:s,quads:o,looks:r,sums:i,enlarged:a,programs:c,textures:l}=this.#o;this.#n=null,this.#r?.destroy(),e.canvas.removeEventListener("webglcontextlost",this.#c),e.canvas.removeEventListener("webglcontextrestored",this.#l),l.destroy();for(let f of c.values())for(let h of Object.values(f))e.deleteProgram(h);for(let f of[r,i,...a])e.deleteFramebuffer(f);e.deleteVertexArray(o);for(let f of[t,s])e.deleteBuffer(f);e.getExtension("WEBGL_lose_context")?.loseContext()}#f({width:e,height:t}){let{canvas:s}=this.#e;s.width!==e&&(s.width=e),s.height!==t&&(s.height=t)}#u(e,t){let s=this.#e;t=Le(t,this.supersampling);let{view:o,quads:r,looks:i,sums:a}=this.#o,c=this.#g(e,t),l=this.#w(e,c),[f,h]=this.#b(e.sorted,c,t);s.bindBuffer(s.UNIFORM_BUFFER,o);let d=this.variant.floats?1:ht,p=dt(e,t,d,this.levelSigma,this.supersampling);s.bufferSubData(s.UNIFORM_BUFFER,0,p),s.bindVertexArray(r),s.disable(s.BLEND),s.bindFramebuffer(s.FRAMEBUFFER,i),s.drawBuffers([s.COLOR_ATTACHMENT0,e.packing?s.NONE:s.COLOR_ATTACHMENT1]);let[u,m]=gt(e.count);if(s.viewport(0,0,u,m),s.useProgram(l.project),this.#a.pass("project"),s.drawArrays(s.TRIANGLES,0,3),s.bindFramebuffer(s.FRAMEBUFFER,a),s.viewport(0,0,f,h),s.enable(s.BLEND),s.useProgram(l.splat),this.#a.pass("splat"),e.sorted?(s.drawBuffers([s.COLOR_ATTACHMENT0]),s.clearBufferfv(s.COLOR,0,[0,0,0,0]),s.blendFunc(s.ONE,s.ONE_MINUS_SRC_ALPHA)):(s.drawBuffers([s.COLOR_ATTACHMENT0,s.COLOR_ATTACHMENT1]),s.clearBufferfv(s.COLOR,0,[0,0,0,1]),s.clearBufferfv(s.COLOR,1,[0,0,0,0]),s.blendFuncSeparate(s.ONE,s.ONE,s.ZERO,s.ONE_MINUS_SRC_ALPHA)),this.variant.strips)s.drawArraysInstanced(s.TRIANGLE_STRIP,0,4,e.count);else{let w=Math.ceil(e.count/bt);s.drawElementsInstanced(s.TRIANGLES,6*bt,s.UNSIGNED_SHORT,0,w)}}#p(e,t,s,o){let r=this.#e,i=Le(t,this.supersampling),{resolve:a,enlarge:c}=this.#w(e,this.#g(e,i));r.disable(r.BLEND),this.#a.pass("resolve"),c&&this.#h(c,a,i),r.bindFramebuffer(r.FRAMEBUFFER,s),r.viewport(0,0,t.width,t.height),r.useProgram(a),r.uniform1i(r.getUniformLocation(a,"last_row"),o),r.drawArrays(r.TRIANGLES,0,3)}#h(e,t,{width:s,height:o}){let r=this.#e,{places:i}=ft(s,o),a=ue(s,o),c=(l,f,h)=>{r.useProgram(l);for(let d of["color","weight"]){let p=me.indexOf(`${d}_sums${f}`);r.uniform1i(r.getUniformLocation(l,`coarse_${d}s`),p)}r.uniform2i(r.getUniformLocation(l,"coarse_from"),h[0],h[1])};for(let l of[2,1])r.bindFramebuffer(r.FRAMEBUFFER,this.#o.enlarged[l-1]),r.viewport(0,0,a[l][0],a[l][1]),l===2?c(e,"",i[3]):c(e,"_2",[0,0]),r.uniform2i(r.getUniformLocation(e,"from"),i[l][0],i[l][1]),r.drawArrays(r.TRIANGLES,0,3);c(t,"_1",[0,0])}#g({sorted:e},{width:t,height:s}){let o=this.#e.getParameter(this.#e.MAX_TEXTURE_SIZE);return this.levelSigma>0&&!e&&Math.max(...ft(t,s).size)<=o}#b(e,t,{width:s,height:o}){let{floats:r}=this.variant,i=t?ft(s,o).size:[s,o],a=`${s} ${o} ${e} ${t} ${r}`;if(a===this.#i)return i;let c=this.#e,l=c.getParameter(c.MAX_TEXTURE_SIZE);if(!(s>0&&s<=l&&o>0&&o<=l))throw new Error(`an image of ${s}x${o} pixels cannot be rendered: each side must lie between 1 and ${l}`);let f=r?[c.RGBA32F,c.R32F]:[c.RGBA16F,c.R16F],{sums:h,enlarged:d,textures:p}=this.#o,u=ue(s,o);return[h,...d].forEach((m,w)=>{let g=w?`_${w}`:"";c.bindFramebuffer(c.FRAMEBUFFER,m),["color_sums","weight_sums"].forEach((E,_)=>{let v=(w===0||t)&&!(e&&_>0),k=w===0?i:u[w],S=v?p.make(`${E}${g}`,f[_],k):null;c.framebufferTexture2D(c.FRAMEBUFFER,c.COLOR_ATTACHMENT0+_,c.TEXTURE_2D,S,0)}),w&&t&&c.drawBuffers([c.COLOR_ATTACHMENT0,c.COLOR_ATTACHMENT1]),(w===0||t)&&this.#v(`pictures of ${s}x${o} floats`)}),this.#i=a,i}#w({sorted:e,packing:t},s){let{programs:o}=this.#o,r={sorted:e,packed:t!==null,strips:this.variant.strips,leveled:s},i=Object.values(r).join(" "),a=o.get(i)??uo(this.#e,this.#t,r);return o.set(i,a),a}#v(e){let t=this.#e;if(t.checkFramebufferStatus(t.FRAMEBUFFER)!==t.FRAMEBUFFER_COMPLETE&&!t.isContextLost())throw new Error(`this GPU cannot draw into ${e}`)}};var yt=class{#e;#t;#o;#n;#s;#r;constructor(e,t,s){let{device:o}=e;this.#e=o,this.#t=t,this.#o=e.dots(s);let{UNIFORM:r,VERTEX:i,COPY_DST:a}=GPUBufferUsage;this.#n=o.createBuffer({size:80,usage:r|a});let c=mt(t);this.#r=c.length/3,this.#s=e.filled(c,i)}draw(e,t){let[s,o,r]=[this.#e,this.#o,this.#t];s.queue.writeBuffer(this.#n,0,pt(r,e));let i=s.createCommandEncoder(),a=i.beginRenderPass({colorAttachments:[{view:t,loadOp:"clear",storeOp:"store",clearValue:[...r.background,1]}]}),c=[{binding:0,resource:{buffer:this.#n}}];a.setPipeline(o),a.setBindGroup(0,s.createBindGroup({layout:o.getBindGroupLayout(0),entries:c})),a.setVertexBuffer(0,this.#s),a.draw(this.#r),a.end(),s.queue.submit([i.finish()])}destroy(){this.#n.destroy(),this.#s.destroy()}};var oe=128;var bo={srcFactor:"one",dstFactor:"one-minus-src-alpha",operation:"add"},ea={color:bo,alpha:bo},vo={color:{srcFactor:"one",dstFactor:"one",operation:"add"},alpha:{srcFactor:"zero",dstFactor:"one-minus-src-alpha",operation:"add"}},ze=["network","project","splat","resolve"],xt=class n{milliseconds=null;#e;#t=new Map;#o=new Map;#n=null;static async create(e,t){if(!("gpu"in navigator))throw new Error("this browser has no WebGPU on this page: it may need https, or a newer version");let s=await bn();if(s===null)throw new Error("WebGPU finds no graphics adapter on this device");let r=["timestamp-query","float32-blendable","shader-f16"].filter(l=>s.features.has(l));if(t&&!r.includes("float32-blendable"))throw new Error("this device cannot blend 32-bit floats");let{maxStorageBufferBindingSize:i,maxBufferSize:a}=s.limits,c=await s.requestDevice({requiredFeatures:r,requiredLimits:{maxStorageBufferBindingSize:i,maxBufferSize:a}});return new n(c,e)}constructor(e,t){if(this.device=e,this.#e=t,e.features.has("timestamp-query")){let s=16*ze.length,o=GPUBufferUsage;this.#n={queries:e.createQuerySet({type:"timestamp",count:2*ze.length}),found:e.createBuffer({size:s,usage:o.QUERY_RESOLVE|o.COPY_SRC}),read:e.createBuffer({size:s,usage:o.MAP_READ|o.COPY_DST})}}}get blendsFloats(){return this.device.features.has("float32-blendable")}get number(){return this.device.features.has("shader-f16")?"f16":"f32"}network(e){return this.#s(`network ${e.packed}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#r("network",e),entryPoint:"evaluate_network"}}))}project(e,{strips:t}){return this.#s(`project ${e.packed} ${e.sorted} ${t}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#r("project",e),entryPoint:e.sorted?"project_sorted":"project_sortfree",constants:{STRIPS:Number(t)}}}))}splat(e,{floats:t,strips:s}){return this.#s(`splat ${e.packed} ${e.sorted} ${s} ${t}`,()=>{let o=e.sorted?ea:vo,r=this.#r("splat",e);return this.device.createRenderPipeline({layout:"auto",vertex:{module:r,entryPoint:e.sorted?"corner_sorted":"corner_of_level",constants:{STRIPS:Number(s)}},primitive:{topology:s?"triangle-strip":"triangle-list"},fragment:{module:r,entryPoint:e.sorted?"cover":"add_weighted",targets:Et(e.sorted,t).map(i=>({format:i,blend:o}))}})})}enlarge(e){return this.#s(`enlarge ${e}`,()=>{let t=this.#r("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:t,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:t,entryPoint:"add_enlarged",targets:Et(!1,e).map(s=>({format:s,blend:vo}))}})})}resolve(e,t,s){return this.#s(`resolve ${e} ${s} ${t}`,()=>{let o=this.#r("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:o,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:o,entryPoint:e?"resolve_sorted":s?"resolve_levels":"resolve_sortfree",targets:[{format:t}]}})})}dots(e){return this.#s(`dots ${e}`,()=>{let t=this.device.createShaderModule({code:this.#e.dots,label:"dots"}),s=[{shaderLocation:0,offset:0,format:"float32x3"}];return this.device.createRenderPipeline({layout:"auto",vertex:{module:t,entryPoint:"corner_of_dot",buffers:[{arrayStride:12,attributes:s}]},fragment:{module:t,entryPoint:"paint_dot",targets:[{format:e}]}})})}filled(e,t){let s=Math.ceil(e.byteLength/4)*4,o=this.device.createBuffer({size:s,usage:t,mappedAtCreation:!0}),r=new Uint8Array(e.buffer,e.byteOffset,e.byteLength);return new Uint8Array(o.getMappedRange()).set(r),o.unmap(),o}bind(e,t){return this.device.createBindGroup({layout:e.getBindGroupLayout(0),entries:Object.entries(t).map(([s,o])=>({binding:Number(s),resource:o instanceof GPUBuffer?{buffer:o}:o}))})}stamps(e,t=!0,s=!0){if(this.#n===null||!(t||s))return;let o=2*ze.indexOf(e);return{querySet:this.#n.queries,...t?{beginningOfPassWriteIndex:o}:{},...s?{endOfPassWriteIndex:o+1}:{}}}async time({network:e}){if(this.#n===null||this.#n.read.mapState!=="unmapped")return;let{queries:t,found:s,read:o}=this.#n,r=this.device.createCommandEncoder();r.resolveQuerySet(t,0,2*ze.length,s,0),r.copyBufferToBuffer(s,0,o,0,o.size),this.device.queue.submit([r.finish()]),await o.mapAsync(GPUMapMode.READ);let i=new BigUint64Array(o.getMappedRange()),a=ze.map((c,l)=>[c,Number(i[2*l+1]-i[2*l])/1e6]);this.milliseconds=Object.fromEntries(e?a:a.slice(1)),o.unmap()}#s(e,t){let s=this.#o.get(e)??t();return this.#o.set(e,s),s}#r(e,t){let s=t===null?"":this.#e[t.packed?"packed":"wide"],o=`${e} ${t?.packed}`,r=this.number==="f16"?`enable f16;
`:"",a=`${e==="network"?`${r}alias Num = ${this.number};
`:""}${this.#e.view}
${s}
${this.#e[e]}`,c=this.#t.get(o)??this.device.createShaderModule({code:a,label:e});return this.#t.set(o,c),c}};function _t(n,e){return Object.fromEntries(n.map((t,s)=>[e+s,t]))}function Et(n,e){return e?n?["rgba32float"]:["rgba32float","r32float"]:n?["rgba16float"]:["rgba16float","r16float"]}var gs=256,kt=6,sa={packed:8,wide:32},bs=new Float32Array(0),Fe=class n{static files=["view","wide","packed","network","project","splat","resolve","dots"].map(e=>`${e}.wgsl`);variant;levelSigma=0;supersampling=1;lost=null;onLost=()=>{};#e;#t;#o;#n;#s;#r=null;#i=null;#a=null;#c=null;#l;#f;#u;#p;static async create(e,t,{floats:s=!1,strips:o=!1}={}){let r=await xt.create(t,s);return new n(r,e,{floats:s,strips:o})}constructor(e,t,s){let o=t.getContext("webgpu");if(o===null)throw new Error("this canvas is already drawn to in another way");let{device:r}=e;this.variant=s,this.#e=e,this.#t=r,this.#n=t,this.#o=o,this.#s=navigator.gpu.getPreferredCanvasFormat(),o.configure({device:r,format:this.#s,alphaMode:"opaque"});let i=GPUBufferUsage;this.#l=r.createBuffer({size:Re,usage:i.UNIFORM|i.COPY_DST});let a=i.STORAGE|i.INDIRECT|i.COPY_DST;this.#f=r.createBuffer({size:4*kt*4,usage:a});let c=new Uint32Array(4*gs/4);for(let f=0;f<4;f++)c[f*gs/4]=f;this.#u=e.filled(c,i.UNIFORM);let l=new Uint16Array(6*oe);for(let f=0;f<oe;f++)l.set([0,1,2,2,1,3].map(h=>4*f+h),6*f);this.#p=e.filled(l,i.INDEX),r.lost.then(({reason:f})=>{f!=="destroyed"&&this.#h("the graphics device was lost: reload the page to go on")}),r.onuncapturederror=({error:f})=>this.#h(`this GPU cannot draw the scene: ${f.message}`)}get variants(){return(this.#e.blendsFloats?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}get milliseconds(){return this.#e.milliseconds}setScene(e){this.#g();let{count:t,sorted:s}=e,o={sorted:s,packed:e.packing!==null,network:!!e.network},r=sa[o.packed?"packed":"wide"]*Math.max(t,1),i={shapes:e.shapes,colors:e.colors,lobes:e.lobes},a=Math.max(r,...Object.values(i).map(u=>u.byteLength)),{maxStorageBufferBindingSize:c,maxBufferSize:l}=this.#t.limits,f=Math.min(c,l);if(a>f)throw new Error(`${t} Gaussians need ${Math.ceil(a/2**20)} MiB at a stretch, and this device gives ${Math.floor(f/2**20)}`);let h=GPUBufferUsage,d=u=>this.#e.filled(u.length?u:new Uint32Array(16),h.STORAGE|h.COPY_DST),p=u=>this.#t.createBuffer({size:4*Math.max(1,u),usage:h.STORAGE|h.COPY_DST});this.#i={kind:o,parts:{shapes:d(i.shapes),colors:d(i.colors),lobes:d(i.lobes)},looks:this.#t.createBuffer({size:r,usage:h.STORAGE}),order:p(s?t:2*t),network:e.network?{weights:this.#e.filled(this.#y(e.network),h.STORAGE),lobes:p(t)}:null},this.#r={...e,shapes:bs,colors:bs,lobes:bs},s&&this.setOrder(Uint32Array.from({length:t},(u,m)=>m))}show(e){this.#r&&(this.#r.count=e)}update(e,t,s){if(!this.#r||!this.#i||this.lost!==null)return;let o=4*pe(this.#r)[e]*t;this.#t.queue.writeBuffer(this.#i.parts[e],o,s)}setDots(e){this.#a?.destroy(),this.#a=e&&new yt(this.#e,e,this.#s)}drawDots(e){this.lost===null&&this.#a?.draw(e,this.#w(e))}setOrder(e){this.#i?.kind.sorted&&this.#t.queue.writeBuffer(this.#i.order,0,e)}draw(e){this.lost===null&&this.#d(e,this.#w(e),this.#s)}async pixels(e){let{width:t,height:s}=e,o=Math.ceil(16*t/256)*256,r=this.#v(t,s,"rgba32float");this.#d(e,r.createView(),"rgba32float");let i=this.#t.createBuffer({size:o*s,usage:GPUBufferUsage.MAP_READ|GPUBufferUsage.COPY_DST}),a=this.#t.createCommandEncoder();a.copyTextureToBuffer({texture:r},{buffer:i,bytesPerRow:o},[t,s]),this.#t.queue.submit([a.finish()]),await i.mapAsync(GPUMapMode.READ);let c=new Float32Array(i.getMappedRange()),l=new Float32Array(4*t*s);for(let f=0;f<s;f++){let h=f*o/4;l.set(c.subarray(h,h+4*t),4*t*f)}return i.destroy(),r.destroy(),l}async drawUnseen(e){let t=this.#v(e.width,e.height,this.#s);if(this.#d(e,t.createView(),this.#s),await this.finished(),t.destroy(),this.lost!==null)throw new Error(this.lost)}async finished(){await this.#t.queue.onSubmittedWorkDone()}describe(){let e=this.#t.adapterInfo;return[e?.vendor,e?.architecture,e?.device,e?.description].filter(Boolean).join(" ")}async time(){this.lost===null&&this.#i&&await this.#e.time(this.#i.kind)}destroy(){this.#g(),this.setDots(null),this.#t.onuncapturederror=null,this.#t.destroy()}#h(e){this.lost===null&&(this.lost=e,this.onLost(e))}#g(){for(let e of this.#b())e.destroy();this.#i=this.#r=null}#b(){if(this.#i===null)return[];let{parts:e,looks:t,order:s,network:o}=this.#i;return[...Object.values(e),t,s,...Object.values(o??{})]}#w({width:e,height:t}){return this.#n.width!==e&&(this.#n.width=e),this.#n.height!==t&&(this.#n.height=t),this.#o.getCurrentTexture().createView()}#v(e,t,s){let o=GPUTextureUsage;return this.#t.createTexture({size:[e,t],format:s,usage:o.RENDER_ATTACHMENT|o.COPY_SRC})}#d(e,t,s){let o=this.#r;if(!o||!this.#i)return;let r=Le(e,this.supersampling),{queue:i}=this.#t,{floats:a,strips:c}=this.variant,l=o.sorted?0:this.levelSigma,f=dt(o,r,a?1:ht,l,this.supersampling);i.writeBuffer(this.#l,0,f);let h=new Uint32Array(kt*4);for(let w=0;w<4;w++)h[kt*w]=c?4:6*oe;i.writeBuffer(this.#f,0,h);let d=this.#A(r.width,r.height,o.sorted,l?4:1),p=this.#t.createCommandEncoder();this.#_(p,o.count,this.#i),this.#E(p,o.count,this.#i),this.#k(p,o.count,this.#i,d);let u=this.#e.resolve(o.sorted,s,d.length>1),m=p.beginRenderPass({colorAttachments:[{view:t,loadOp:"clear",storeOp:"store"}],timestampWrites:this.#e.stamps("resolve")});m.setPipeline(u),m.setBindGroup(0,this.#e.bind(u,{0:this.#l,..._t(d.slice(0,2).flat(),1)})),m.draw(3),m.end(),i.submit([p.finish()])}#y(e){return this.#e.number==="f16"?Uint16Array.from(e,H):e}#_(e,t,{kind:s,parts:o,network:r}){if(r===null)return;let i={0:this.#l,1:o.shapes,4:o.lobes,5:r.weights,6:r.lobes};this.#x(e,"network",this.#e.network(s),i,Math.ceil(t/32))}#E(e,t,{kind:s,parts:o,looks:r,order:i,network:a}){let c=a?.lobes??o.lobes,l=[this.#l,o.shapes,o.colors,c,r];s.sorted||l.push(i,this.#f);let f=this.#e.project(s,this.variant);this.#x(e,"project",f,_t(l,0),Math.ceil(t/oe))}#x(e,t,s,o,r){let i=Math.max(1,Math.min(r,65535)),a=e.beginComputePass({timestampWrites:this.#e.stamps(t)});a.setPipeline(s),a.setBindGroup(0,this.#e.bind(s,o)),a.dispatchWorkgroups(i,Math.ceil(r/i)),a.end()}#k(e,t,{kind:s,parts:o,looks:r,order:i},a){let c=[{r:0,g:0,b:0,a:s.sorted?0:1},{r:0,g:0,b:0,a:0}],l=this.#e.splat(s,this.variant),f=a.length-1;for(let h=f;h>=0;h--){let d=e.beginRenderPass({colorAttachments:a[h].map((w,g)=>({view:w,loadOp:"clear",storeOp:"store",clearValue:c[g]})),timestampWrites:this.#e.stamps("splat",h===f,h===0)});if(h>0&&h<f){let w=this.#e.enlarge(this.variant.floats);d.setPipeline(w),d.setBindGroup(0,this.#e.bind(w,_t(a[h+1],3))),d.draw(3)}d.setPipeline(l);let p={buffer:this.#u,offset:h*gs,size:16},u={0:this.#l,1:o.shapes,4:r,5:i};d.setBindGroup(0,this.#e.bind(l,s.sorted?u:{...u,6:this.#f,7:p})),d.setIndexBuffer(this.#p,"uint16");let m=4*kt*h;this.variant.strips?s.sorted?d.draw(4,t):d.drawIndirect(this.#f,m):s.sorted?d.drawIndexed(6*oe,Math.ceil(t/oe)):d.drawIndexedIndirect(this.#f,m),d.end()}}#A(e,t,s,o){let r=`${e} ${t} ${s} ${o} ${this.variant.floats}`;if(this.#c?.key===r)return this.#c.views;for(let l of this.#c?.textures??[])l.destroy();let i=GPUTextureUsage,a=[],c=ue(e,t).slice(0,o).map(l=>Et(s,this.variant.floats).map(f=>{let h=i.RENDER_ATTACHMENT|i.TEXTURE_BINDING,d=this.#t.createTexture({size:l,format:f,usage:h});return a.push(d),d.createView()}));return this.#c={key:r,textures:a,views:c},c}};async function At(n,e){let t="";if(e!=="webgl")try{let s=await yo(Fe.files);return{name:"WebGPU",renderer:await Fe.create(n,s)}}catch(s){if(e==="webgpu")throw s;t=s instanceof Error?s.message:String(s)}try{return{name:"WebGL2",renderer:Oe.create(n,await yo(Oe.files))}}catch(s){let o=s instanceof Error?s.message:String(s);throw new Error(`this browser cannot draw the scene: ${t?`${t}; `:""}${o}`)}}async function yo(n){let e=n.map(async t=>[t.replace(/\.[a-z]+$/,""),await vn(t)]);return Object.fromEntries(await Promise.all(e))}var xo=new Map;function Eo(n){let e=xo.get(n)??na(n);return xo.set(n,e),e}async function na(n){let{renderer:e}=await At(document.createElement("canvas"),n);try{return await ro(e,vs())}finally{e.destroy()}}function vs(){try{return localStorage}catch{return null}}var M=(n,e,t=1)=>[n[0]+t*e[0],n[1]+t*e[1],n[2]+t*e[2]],L=(n,e)=>M(n,e,-1),O=(n,e)=>n[0]*e[0]+n[1]*e[1]+n[2]*e[2],V=(n,e)=>[n[1]*e[2]-n[2]*e[1],n[2]*e[0]-n[0]*e[2],n[0]*e[1]-n[1]*e[0]],K=n=>Math.hypot(...n);function Y(n){let e=K(n);return e>0?[n[0]/e,n[1]/e,n[2]/e]:[1,0,0]}function ys(n,e,t){let[s,o]=[Math.cos(t),Math.sin(t)],r=O(n,e)*(1-s),i=V(e,n);return M(M([n[0]*s,n[1]*s,n[2]*s],i,o),e,r)}var oa=Math.cos(.5*Math.PI/180),St=class{by="";#e=!1;#t=null;reset(e){this.by=e,this.#e=!1}invalidate(){this.#t=null}get pending(){return this.#e}received(){this.#e=!1}neededDirection({viewmat:e}){let t=[e[8],e[9],e[10]],s=this.#t!==null&&O(t,this.#t)>=oa;return!this.by||this.#e||s?null:(this.#e=this.by==="worker",this.#t=t)}};var _o=12;function ko(n,e,t,s,o){let{viewmat:r,fx:i,fy:a,cx:c,cy:l,near:f}=t,h=-1,d=1/0;for(let p=0;3*p<n.length;p++){if(e[p]<0)continue;let[u,m,w]=[n[3*p],n[3*p+1],n[3*p+2]],g=r[8]*u+r[9]*m+r[10]*w+r[11];if(g<=f||g>=d)continue;let E=i*(r[0]*u+r[1]*m+r[2]*w+r[3])/g+c-s,_=a*(r[4]*u+r[5]*m+r[6]*w+r[7])/g+l-o;E*E+_*_>_o*_o||(d=g,h=p)}return h<0?null:[n[3*h],n[3*h+1],n[3*h+2]]}function xs(n,e,t,s){let o=s instanceof Uint32Array;for(let r=0;r*e<s.length;r++)n[t+r]=o?lo(s[r*e]):s[r*e]}var ra=50,Mt=class{count=0;views=[];near=.2;logits=new Float32Array(0);request=null;calibrated=Promise.resolve();name="";broken=!1;#e=new Float32Array(0);#t;#o;#n=!1;#s;#r;#i=null;#a=null;#c=null;#l=null;#f=Promise.resolve(!1);#u=!1;#p=null;#h=!1;#g=2;#b=[0,0,0];#w=null;#v=[0,0,0];#d=new St;#y=null;#_=!1;#E=!1;#x=!1;constructor(e,t,s,o,r=0){this.canvas=e,this.#r=t,this.#t=s,this.#o=r,this.#s=o}begin(e){return this.#f=this.#k(e)}async#k(e){try{let{name:t,renderer:s}=await At(this.canvas,e);if(this.#u)return s.destroy(),!1;s.onLost=i=>this.#T(i),"onRestored"in s&&(s.onRestored=()=>this.request&&this.load(this.request));let r=s.variants.find(({floats:i,strips:a})=>i===this.#t?.floats&&a===this.#t.strips)??oo(s,vs());return r&&(s.variant=r),s.levelSigma=this.#o,this.#n=r!==null,this.#i=s,this.name=t,ao(s),!0}catch(t){return this.#r.failed(Es(t)),!1}}async#A(){if(this.#n||this.broken)return;this.#n=!0;let e=this.name==="WebGPU"?"webgpu":"webgl",t=await Eo(e);this.#i&&(this.#i.variant=t),this.#r.changed()}load(e,t=!1){this.#c?.terminate(),this.request=e;let s=gn(e,async({data:o})=>{if(!await this.#f){s.terminate();return}(s===this.#c||s===this.#a)&&this.#U(o,s)});s.onerror=o=>{o.preventDefault(),!t&&s===this.#c?this.load(e,!0):this.#L("the viewer's own files could not be loaded: reload the page",s)},this.#c=this.#l=s}async sort(e){if(this.#d.by==="")return null;if(this.broken)throw new Error("the renderer was lost");this.#d.pending&&await this.#S();let t=performance.now();return this.#d.invalidate(),this.#F(e),this.#d.pending&&await this.#S(),performance.now()-t}#S(){return new Promise((e,t)=>this.#y={resolve:e,reject:t})}#M(e){this.#y?.reject(new Error(e)),this.#y=null}draw(e,t=1){if(this.#a===null)return;let s={...e,near:this.near};if(this.#E){this.#i?.drawDots(s),this.#m();return}this.#F(e),this.#i&&(this.#i.supersampling=t,this.#i.draw(s),this.#i.supersampling=1)}async#m(){let e=this.#i;this.#x||this.#s||!e||(this.#x=!0,await new Promise(t=>setTimeout(t,ra)),this.#E&&!this.#u&&await io(e).catch(()=>{}))}drawOrReport(e,t){if(!this.broken)try{this.draw(e,t)}catch(s){this.#T(Es(s))}}async finished(){await this.#i?.finished()}pixels(e){return(this.#a&&!this.#E?this.#i?.pixels(e):null)??Promise.reject(new Error("nothing can be drawn"))}get background(){return this.#w??this.#b}set background(e){this.#w=e,this.background.forEach((t,s)=>this.#v[s]=t)}get means(){return this.#e=Be(this.#e)}get milliseconds(){return this.#i?.milliseconds??null}async time(){this.#_||!this.#i||(this.#_=!0,await this.#i.time().catch(()=>{}),this.#_=!1)}get device(){let{floats:e,strips:t}=this.#i?.variant??{floats:!1,strips:!1},s=`${e?"floats":"halves"}, ${t?"strips":"batches"}`,{by:o}=this.#d,r=this.#i?.describe()??"";return{renderer:this.name,adapter:r,variant:s,sorted:o!=="",sorted_by:o||null}}destroy(){this.#u=this.broken=!0,this.#M("the renderer was lost"),this.#c?.terminate(),this.#a?.terminate(),this.#i?.destroy(),this.#i=null}#T(e){this.broken=!0,this.#M(e),this.#r.broken(e)}#U(e,t){this.broken&&t===this.#a||(e.kind==="failed"?this.#L(e.sentence,t):e.kind==="progress"?t===this.#l&&this.#r.progress(e.received/e.total):e.kind==="dots"?this.#I(e,t):e.kind==="scene"?this.#N(e,t):e.kind==="rows"?this.#C(e):e.kind==="more"?this.#R(e.means):e.kind==="order"?this.#P(e.order):(this.#d.by!=="worker"&&t.terminate(),this.#c||(this.calibrated=this.#A().catch(()=>{})),t===this.#l&&this.#r.loaded(e.milliseconds,e.bytes)))}#L(e,t){let s=t===this.#c&&this.#p!==null;t===this.#a&&this.#M(e),t===this.#c&&(this.#c=null,this.request=this.#p),(t!==this.#a||this.#d.by!=="worker")&&t.terminate(),t===this.#l&&this.#r.failed(e,s)}#I({dots:e,views:t,near:s},o){this.#d.reset(""),this.#O(o,e.background,()=>this.#i?.setDots(e))&&(this.#E=!0,this.#z(t,s),this.logits=new Float32Array(e.means.length/3),this.#R(e.means),this.#h||this.#r.arrived())}#N({data:e,means:t,views:s,near:o},r){let i=r===this.#a;this.#d.reset(e.sorted?"worker":this.#s?"page":""),e.sorted=this.#d.by!=="",this.#O(r,e.background,()=>{this.#i?.setDots(null),this.#i?.setScene(e)})&&(this.#E=!1,this.#z(s,o),this.logits=new Float32Array(e.count),this.#g=pe(e).lobes,xs(this.logits,this.#g,0,e.lobes),this.#R(t),!i&&!this.#h&&this.#r.arrived())}#O(e,t,s){if(e!==this.#a&&(this.#a?.terminate(),this.#M("another scene was opened")),this.#a=e,e===this.#c&&(this.#h=this.request===this.#p&&this.count>0,this.#p=this.request,this.#c=null),this.#b=[...t],this.#v=t,this.background=this.#w,this.#i?.lost)return this.#T(this.#i.lost),!1;try{s()}catch(o){return e.terminate(),this.count=0,this.#r.failed(Es(o)),!1}return this.broken=!1,!0}#z(e,t){this.views=e,this.near=t}#R(e){this.#e=e,this.count=("stored"in e?e.stored:e).length/3,this.#i?.show(this.count),this.#d.invalidate(),this.#r.changed()}#C({part:e,from:t,numbers:s}){this.#i?.update(e,t,s),e==="lobes"&&xs(this.logits,this.#g,t,s),this.#r.changed()}#P(e){this.#d.received(),this.#i?.setOrder(e),this.#y?.resolve(),this.#y=null,this.#r.ordered()}#F(e){let t=this.#d.neededDirection(e);t!==null&&(this.#d.by==="page"?this.#i?.setOrder(ot(this.means,t)):this.#a?.postMessage({forward:t}))}},Es=n=>n instanceof Error?n.message:String(n);var Ao=.02,So=.02,Mo=.001,C=class n{constructor(e,t,s){this.eye=e,this.target=t,this.up=Y(s),this.reach=K(L(t,e))||1}static fromViews(e,t=0){let s=e.map(aa),o=ia(s),{eye:r,forward:i}=s[t],a=O(L(ca(s),r),i),c=Math.max(...s.map(l=>K(L(l.eye,r))),0)||1;return new n(r,M(r,i,a>Mo*c?a:c),o)}static around(e){let t=[0,1,2].map(r=>{let i=e.filter((c,l)=>l%3===r).sort(),a=c=>i[Math.floor(c*(i.length-1))]??0;return[a(.15),a(.5),a(.85)]}),s=t.map(([,r])=>r),o=Math.max(...t.map(([r,,i])=>i-r))||1;return new n(M(s,[0,-.3,-1],1.5*o),s,[0,-1,0])}get forward(){return Y(L(this.target,this.eye))}get right(){return Y(V(this.forward,this.up))}copy(){let e=new n(this.eye,this.target,this.up);return e.reach=this.reach,e}orbit(e,t){let s=this.#e(L(this.eye,this.target),e,t);this.eye=M(this.target,s)}look(e,t){let s=this.#e(L(this.eye,this.target),e,t);this.target=L(this.eye,s)}move(e,t,s){let o=V(this.forward,this.right),r=M([0,0,0],this.right,e);r=M(M(r,o,t),this.forward,s),this.eye=M(this.eye,r),this.target=M(this.target,r)}dolly(e){let t=L(this.eye,this.target),s=Math.max(K(t)*e,Mo*this.reach);this.eye=M(this.target,Y(t),s)}focus(e){K(L(e,this.eye))>0&&(this.target=e)}viewmat(){let{forward:e,right:t,eye:s}=this,o=V(e,t),r=i=>[...i,-O(i,s)];return[...r(t),...r(o),...r(e),0,0,0,1]}#e(e,t,s){let o=Math.acos(Math.min(1,Math.max(-1,O(Y(e),this.up)))),r=Math.min(Math.max(o-s,Ao),Math.PI-Ao)-o;return ys(ys(e,this.right,r),this.up,-t)}};function To(n,e,t,s,o,r=null){let i=Math.tan((r??50)*Math.PI/360),a=r===null?e:null,c=a?t*a.K[0]/a.width:t/(2*i),l=a?s*a.K[4]/a.height:s/(2*i),f=Math.sqrt(c*l),h={cx:t/2,cy:s/2};return{viewmat:n.viewmat(),fx:f,fy:f,...h,width:t,height:s,near:o}}function ia(n){let e=Y(n.reduce((s,{down:o})=>L(s,o),[0,0,0])),t=e;for(let s=0;s<200;s++){let o=M([0,0,0],t,1+So);for(let{right:r}of n)o=M(o,r,-O(r,t)/n.length);t=Y(M(o,e,So*O(e,t)))}return t}function aa({viewmat:n}){let e=i=>[n[4*i],n[4*i+1],n[4*i+2]],[t,s,o]=[e(0),e(1),e(2)],r=M([0,0,0],t,-n[3]);return r=M(M(r,s,-n[7]),o,-n[11]),{eye:r,right:t,forward:o,down:s}}function ca(n){let e=[.001,0,0,0,.001,0,0,0,.001],t=[0,0,0];for(let{eye:c,forward:l}of n){for(let f=0;f<3;f++)for(let h=0;h<3;h++)e[3*f+h]+=(f===h?1:0)-l[f]*l[h];t=M(M(t,c,1+.001/n.length),l,-O(l,c))}let s=c=>[e[c],e[3+c],e[6+c]],[o,r,i]=[s(0),s(1),s(2)],a=O(o,V(r,i));return[O(t,V(r,i))/a,O(o,V(t,i))/a,O(o,V(r,t))/a]}var la=16.666666666666668,fa=1e3/50,ha=1e3/45,Ro=1e3/26,da=3,ua=200,pa=.9,Lo=[4,64],ma=[1,.85,.7,.6,.5],Ue=class{#e=0;#t=[];#o;#n=ha;#s={step:0,median:1/0};#r=0;#i=Lo[0];constructor(e){this.fixed=e,this.#o=e===null?ma:[e]}get scale(){return this.#o[this.#e]}reduced(e){return(e?this.scale:this.#o[0])<1}size(e,t,s,o){let r=Math.min(s,2)*(o?this.scale:this.#o[0]),i=a=>Math.max(1,Math.round(a*r));return{width:i(e),height:i(t)}}note(e){this.#t.push(e);let{length:t}=this.#t;if(t<da||this.#t.reduce((o,r)=>o+r)<ua)return;let s=this.#t.sort((o,r)=>o-r)[t>>1];this.#t=[],s>this.#n?this.#a(s):s>=fa||this.#e===0?this.#r=0:++this.#r>=this.#i&&(this.#e-=1,this.#r=0)}#a(e){let{step:t,median:s}=this.#s;if(this.#r=0,this.#i=Math.min(2*this.#i,Lo[1]),t<this.#e&&e<Ro&&e>pa*s){this.#e=t,this.#n=Ro;return}this.#s={step:this.#e,median:e};let o=this.scale*Math.sqrt(la/e),r=this.#o.findIndex(i=>i<this.scale&&i<=o);this.#e=r<0?this.#o.length-1:r}};function Oo({fx:n,fy:e,width:t,height:s},o){if(o.length===0)return 1;let r=Math.sqrt(o[0].K[0]*o[0].K[4]),i=Math.min(4,Math.floor(4096/Math.max(t,s)));return Math.max(1,Math.min(Math.floor(r/Math.sqrt(n*e)+.5),i))}var wa=100,zo=150,ga=9*Math.PI/180,Tt=class{mode="orbit";pose=new C([0,0,-3],[0,0,0],[0,-1,0]);fov=null;timed=!1;turning=!1;measured=!1;#e;#t;#o;#n;#s;#r=null;#i="auto";#a=null;#c;#l;#f=this.pose;#u=!1;#p=0;#h=0;#g=-1/0;#b=!1;#w=0;#v=0;#d;constructor(e,t,{variant:s=null,levels:o=0}={}){this.#t=e,this.#e=t,this.#o=s,this.#n=o,this.#c=new Ue(null),this.#s=this.#_(e,0,!1),this.#l=new lt(e,{pose:()=>this.pose,mode:()=>this.mode,held:()=>this.turning=!1,changed:()=>{this.#g=performance.now(),this.turning=!1,this.redraw()},focus:(r,i)=>this.#A(r,i)}),this.#d=new ResizeObserver(()=>this.redraw()),this.#d.observe(e)}begin(e){return this.#i=e,this.#s.begin(e)}load(e){this.#s.request&&(this.#u=!1),this.#s.load(e)}async compare(e,t,s){this.endComparison();let o=this.#_(e,1,s);o.background=this.#a,this.#r=o,await this.#s.calibrated,o===this.#r&&await o.begin(this.#i)&&o===this.#r&&o.load(t)}endComparison(){this.#r?.destroy(),this.#r=null}redraw(){!this.#p&&!this.measured&&(this.#p=requestAnimationFrame(e=>this.#x(e)))}reset(e){let{views:t}=this;this.pose=e===void 0||t.length===0?this.#f.copy():C.fromViews(t,(e%t.length+t.length)%t.length),this.redraw()}place(e){this.pose=e,this.#u=!0,this.redraw()}camera(e,t){return To(this.pose,this.views[0]??null,e,t,this.#s.near,this.fov)}get views(){return this.#s.views.length?this.#s.views:this.#r?.views??[]}get count(){return this.#s.count}get calibrated(){return this.#s.calibrated}get source(){let{request:e}=this.#s;return e===null||"forward"in e?null:"url"in e?e.url:e.file}get device(){return this.#s.device}get scale(){return this.#c.fixed}set scale(e){this.#c=new Ue(e),this.redraw()}get choices(){let{mode:e,fov:t,turning:s,scale:o,timed:r}=this;return{mode:e,fov:t,turning:s,scale:o,timed:r,background:this.#a}}get background(){return this.#s.background}set background(e){this.#a=e;for(let t of this.#y)t.background=e;this.redraw()}async drawAndWait(e,t){let s=this.camera(e,t),o=await this.#s.sort(s);if(this.#s.draw(s),await this.finished(),this.#s.broken)throw new Error("the renderer was lost");return o}async finished(){await this.#s.finished()}async passes(){return await this.#s.time(),this.#s.milliseconds}pixels(e,t=0){return this.#y[t]?.pixels(e)??Promise.reject(new Error("there is no other scene"))}screenshot(e=1){let{width:t,height:s}=this.#k(),o=document.createElement("canvas");[o.width,o.height]=[t,s];let r=o.getContext("2d");return this.#y.forEach(({canvas:i},a)=>{let c=a*Math.round(e*t),l=t-c;l>0&&r?.drawImage(i,c,0,l,s,c,0,l,s)}),new Promise(i=>o.toBlob(i,"image/png"))}destroy(){cancelAnimationFrame(this.#p),clearTimeout(this.#v),clearTimeout(this.#w),this.#l.destroy(),this.#d.disconnect();for(let e of this.#y)e.destroy()}get#y(){return this.#r?[this.#s,this.#r]:[this.#s]}#_(e,t,s){let o={progress:r=>this.#e.progress(t,r),arrived:()=>this.#E(t),changed:()=>{this.#w||=setTimeout(()=>this.redraw(),wa)},ordered:()=>this.redraw(),loaded:(r,i)=>{this.#e.loaded(t,r,i),this.redraw()},failed:(r,i)=>this.#e.failed(t,r,i),broken:r=>this.#e.broken(t,r)};return new Mt(e,o,this.#o,s,this.#n)}#E(e){let{views:t}=this;(e===0||!this.#s.views.length&&this.#g===-1/0)&&(t.length||this.#s.count)&&(this.#f=t.length?C.fromViews(t):C.around(this.#s.means),this.#u||this.reset()),this.redraw()}#x(e){this.#p=0,clearTimeout(this.#w),this.#w=0;let t=e-this.#h;this.#h=e;let s=this.#b,o=this.turning&&this.count>0;this.#b=performance.now()-this.#g<zo||this.#l.busy||o,this.#b&&s&&this.#c.note(t);let r=Math.min(t,100)/1e3;this.#l.advance(r),o&&this.pose.orbit(ga*r,0);let{width:i,height:a}=this.#k();if(clearTimeout(this.#v),this.#b&&(this.#v=setTimeout(()=>this.redraw(),2*zo)),this.count&&!this.#s.broken){let{name:c,count:l,milliseconds:f}=this.#s,h=this.#b&&s?t:0,d=this.#r?.count??0;this.#e.drawn({renderer:c,count:l,compared:d,width:i,height:a,milliseconds:h,passes:f}),this.timed&&this.#s.time()}(this.#l.busy||o)&&this.redraw()}#k(){let{clientWidth:e,clientHeight:t}=this.#t,s=this.#c.size(e,t,devicePixelRatio,this.#b);if(e&&t){let o=this.camera(s.width,s.height),r=this.#c.reduced(this.#b)?1:Oo(o,this.views);for(let i of this.#y)i.drawOrReport(o,r)}return s}#A(e,t){let{clientWidth:s,clientHeight:o}=this.#t,{means:r,logits:i}=this.#s,a=ko(r,i,this.camera(s,o),e,t);a&&this.pose.focus(a),this.redraw()}};var Fo=["settings","help","report"],Uo=["scale","background","fov","autorotate"],ba=2e3,Io="sorted",va={rootMargin:"100%"},ya="(prefers-reduced-motion: reduce)",_s=class extends(globalThis.HTMLElement??Object){static observedAttributes=["src","compare",...Uo];viewer=null;#e;#t=null;#o=new Te;#n=null;#s;#r=!1;#i=!1;#a=null;#c=[];#l=0;#f=Promise.resolve(!1);#u=!1;#p=new IntersectionObserver(e=>e.some(t=>t.isIntersecting)&&this.#h(),va);constructor(){super(),this.#e=this.attachShadow({mode:"open",delegatesFocus:!0}),this.#e.innerHTML=Zn;for(let t of this.#e.querySelectorAll("button"))t.addEventListener("click",()=>this.act(t.dataset.act??""));this.#e.addEventListener("keydown",t=>{let{code:s,key:o,ctrlKey:r,metaKey:i,altKey:a,repeat:c,target:l,defaultPrevented:f}=t,h=ls.get(o.toLowerCase())??ls.get(s.slice(3).toLowerCase()),d=f||l.matches("textarea, select");h&&!r&&!i&&!a&&!c&&!d&&this.act(h),s==="Escape"&&this.act("close")}),this.#e.addEventListener("keyup",t=>{let{code:s,target:o}=t,{classList:r}=o;s==="Tab"&&(r.add("reached"),o?.addEventListener("blur",()=>r.remove("reached"),{once:!0}))}),this.#m("settings").addEventListener("input",({target:t})=>{let s=t;s.name==="stats"?this.act("stats"):this.viewer&&Yn(s,this.viewer)}),this.addEventListener("dragover",t=>{t.preventDefault(),this.#m("drop").hidden=!1}),this.addEventListener("dragleave",()=>this.#m("drop").hidden=!0),this.addEventListener("drop",t=>{t.preventDefault(),this.#m("drop").hidden=!0,this.#y(t.dataTransfer?.files)});let e=this.#d;e.addEventListener("change",()=>{this.#x(null),this.#y(e.files),e.value=""})}connectedCallback(){queueMicrotask(()=>{if(!this.isConnected||this.viewer)return;let e=this.getAttribute("poster")?.replace(/[\x22\\\n]/g,encodeURIComponent);e&&(this.style.background=`center / cover no-repeat url("${e}")`),this.getAttribute("loading")==="lazy"?this.#p.observe(this):this.#h()})}#h(e=this.getAttribute("renderer")??"auto"){this.#p.disconnect(),this.#m("buttons").hidden=this.hasAttribute("noui"),this.#e.querySelector("[data-act=full]").hidden=!document.fullscreenEnabled;let t=this.#e.querySelector("canvas"),s=this.getAttribute("variant"),[o,r]=["floats","strips"].map(l=>!!s?.includes(l)),i=Number(this.getAttribute("levels"));this.viewer=new Tt(t,this,{variant:s===null?null:{floats:o,strips:r},levels:i>=.6&&i<=100?i:0}),t.setAttribute("aria-label",`${this.getAttribute("alt")??"3D scene"}. Press H for the keys.`),t.classList.toggle("polite",this.hasAttribute("polite"));for(let l of Uo)this.#k(l);this.#f=this.viewer.begin(e),this.#u=!1,this.#f.then(l=>this.#u=!l);let a=this.#n??this.getAttribute("src"),c=this.#s===void 0?this.getAttribute("compare"):this.#s;a&&this.open(a),c&&this.compare(c)}disconnectedCallback(){this.#p.disconnect(),this.#g()}#g(){this.viewer?.destroy(),this.viewer=null,this.#M(),this.#o=new Te;let e=this.#e.querySelector("canvas");e?.classList.remove("drawn"),e?.replaceWith(e.cloneNode())}attributeChangedCallback(e,t,s){e==="src"&&(this.#n=null),e==="compare"&&(this.#s=void 0),!(!this.viewer||s===t)&&(e==="compare"?this.compare(s||null):e!=="src"?this.#k(e):s&&this.open(s))}async open(e){this.#n=e,this.#i=this.#r,await this.#A(0,e,(t,s)=>t.load(s))}async compare(e){this.#s=e,this.#i=!1,this.#r=e===Io;let t=this.#r?this.#n:e;this.viewer?.endComparison(),this.#M(),this.#o.begin(1),this.#S(),t!==null&&await this.#A(1,t,(s,o)=>{this.#M();let r=document.createElement("canvas");r.className="over",r.setAttribute("aria-hidden","true"),this.#m("split").before(r),this.#t=new ct(this.#m("split"),r),s.compare(r,o,this.#r)})}act(e){let t=this.viewer;if(t){if(e==="reset"||e==="view")t.turning=!1,t.reset(e==="view"?++this.#l:void 0);else if(e==="help"||e==="settings")this.#x(e);else if(e==="stats")t.timed=this.#E("stats");else if(e==="own")t.background=null;else if(e==="mode"){let s=t.mode==="fly";t.mode=s?"orbit":"fly",this.#b(`Dragging ${s?"rotates the scene":"looks around"}.`,!0)}else e==="picture"?this.#_():e==="open"?this.#d.click():e==="copy"?this.#v():e==="share"?navigator.share?.({text:this.#w}).catch(()=>{}):e==="full"?document.fullscreenElement?document.exitFullscreen():this.requestFullscreen?.().catch(()=>{}):e==="close"&&(this.#m("message").hidden=!0,this.#x(null));Kn(this.#m("settings"),t,!this.#m("stats").hidden),t.redraw()}}progress(e,t){this.#o.note(e,{share:t,state:"loading"}),this.#S()}loaded(e,t,s){this.#o.note(e,{share:1,state:"loaded"}),this.#S(),e!==1&&(this.#i&&this.compare(Io),this.#b(`${this.viewer?.count.toLocaleString("en")} Gaussians loaded.`),this.dispatchEvent(new CustomEvent("load",{detail:{milliseconds:t,bytes:s}})))}failed(e,t,s=!1){this.#o.fail(e,t,s),e===0&&(this.#i=!1),this.#S(),this.#m("message").hidden=!1,e===0&&(this.#n=this.viewer?.source??this.#n),this.#e.querySelector(".message [data-act=open]").hidden=!!this.viewer?.count,this.dispatchEvent(new CustomEvent("error",{detail:{sentence:t}}))}broken(e,t){let s=this.viewer;if(!s||s.device.renderer==="WebGL2"||this.getAttribute("renderer")==="webgpu"){this.failed(e,t);return}console.warn(`WebGL2 takes over: ${t}`),this.#g(),this.#h("webgl"),Object.assign(this.viewer,s.choices),s.count&&this.viewer?.place(s.pose)}report(e){let t=JSON.stringify(e,null,1),s=this.#m("report");s.querySelector("textarea").value=t;let o=e.scenes,r=o.some(a=>a.interrupted),i=o.map(({cold:a,steady:c})=>`${a.fps} frames/s cold, ${c.fps} steady`).join(" | ");s.querySelector("h2").textContent=r?"The page was hidden during the measurement: measure again":i,s.querySelector("[data-act=share]").hidden=!navigator.share,s.hidden&&this.#x("report"),this.dispatchEvent(new CustomEvent("report",{detail:e}))}drawn(e){this.#e.querySelector("canvas")?.classList.add("drawn"),e.compared&&this.#m("split").hidden&&this.#t?.show(this.#o.names),this.dispatchEvent(new CustomEvent("frame",{detail:e}));let t=this.#m("stats");if(t.hidden)return;e.milliseconds&&(this.#c=[...this.#c.slice(-29),e.milliseconds]);let s=this.#c.reduce((i,a)=>i+a,0)/this.#c.length,o=[e.count,e.compared].filter((i,a)=>a===0||i),r=[`${e.renderer}, ${e.width} x ${e.height}`,`${o.map(i=>i.toLocaleString("en")).join(" | ")} Gaussians`,this.#c.length?`${(1e3/s).toFixed(0)} frames/s, ${s.toFixed(1)} ms`:"still",...Object.entries(e.passes??{}).map(([i,a])=>`${i} ${a.toFixed(2)} ms`)];t.textContent=r.join(`
`)}#b(e,t=!1){let s=this.#m("said");s.textContent=e,s.classList.toggle("seen",t),setTimeout(()=>s.classList.remove("seen"),ba)}get#w(){let e=this.#e.querySelector("textarea");return e.focus(),e.select(),e.value}async#v(){let e=this.#w,t=navigator.clipboard?await navigator.clipboard.writeText(e).then(()=>!0,()=>!1):document.execCommand("copy");this.#m("copied").textContent=t?"Copied.":"This browser does not allow copying: the text is selected, press Ctrl+C."}get#d(){return this.#e.querySelector("[type=file]")}#y(e){let[t,s]=e??[];t&&this.open(t),s&&this.compare(s)}async#_(){let e=await this.viewer?.screenshot(this.#t?.share);if(!e)return;let t=document.createElement("a");Object.assign(t,{href:URL.createObjectURL(e),download:"scene.png"}).click(),setTimeout(()=>URL.revokeObjectURL(t.href),1e3)}#E(e,t){let s=this.#m(e);return s.hidden=t===void 0?!s.hidden:!t,this.#e.querySelector(`[data-act=${e}]`)?.setAttribute("aria-expanded",String(!s.hidden)),!s.hidden}#x(e){Fo.every(s=>this.#m(s).hidden)&&(this.#a=this.#e.activeElement);let t=e!==null&&this.#m(e).hidden;for(let s of Fo)this.#E(s,t&&s===e);t?this.#m(e).focus():(this.#a??this.#e.querySelector("canvas"))?.focus({preventScroll:!0})}#k(e){let t=this.viewer,s=this.getAttribute(e),o=Number(s);e==="scale"?t.scale=o>0&&o<=1?o:null:e==="fov"?t.fov=o>=1&&o<=150?o:null:e==="background"?t.background=at(s):t.turning=s!==null&&!matchMedia(ya).matches,t.redraw()}async#A(e,t,s){let o=this.viewer;if(o===null||this.#u)return;let r=this.#s;if(e===1&&(!await this.#f||o!==this.viewer||r!==this.#s))return;let i=typeof t=="string"?t.replace(/[?#].*$/,""):"scene",a=t instanceof File?t.name:i;this.#o.begin(e,e===1&&this.#r?`${a}, sorted`:a),this.#S();try{let c=t instanceof Blob?{file:t}:{url:new URL(t,document.baseURI).href};s(o,c)}catch(c){this.failed(e,`the scene cannot be opened: ${c.message}`)}}#S(){let{state:e,busy:t,share:s,sentence:o,names:r}=this.#o,i=this.#m("bar");i.hidden=!t,i.classList.toggle("unknown",Number.isNaN(s));let a=Math.min(100,Math.round(100*s))||0;i.setAttribute("aria-valuenow",String(a)),i.firstElementChild.style.width=`${a}%`;let c=this.#m("message"),l=c.querySelector("p");l.textContent!==o&&(l.textContent=o),o||(c.hidden=!0),this.#m("split").hidden||this.#t?.show(r),e&&(this.dataset.state=e)}#M(){this.#m("split").hidden=!0,this.#e.querySelector(".over")?.remove(),this.#t=null}#m(e){return this.#e.querySelector(`.${e}`)}};globalThis.customElements?.define("mobile-gs",_s);var Lt=40,ks=480,No=10,xa=10,Ea=250;function Do(n,e){let[,t,s,o]=/^(?:(\d+)(?:,|$))?(?:(\d+)x(\d+))?$/.exec(n)??[];return{seconds:Math.min(Math.max(Number(t)||60,1),3600),width:Math.min(Number(s)||e.width,8192),height:Math.min(Number(o)||e.height,8192)}}var _a=({views:n})=>n.length<2?ks:Lt*n.length;function Co(n,e,t){let{views:s}=n;if(s.length<2){let f=e.copy();return f.orbit(2*Math.PI*t/ks,.2*Math.sin(6*Math.PI*t/ks)),f}let o=Math.floor(t/Lt),[r,i]=[o,o+1].map(f=>C.fromViews(s,f%s.length)),a=t%Lt/Lt,c=M(r.eye,L(i.eye,r.eye),a),l=M(r.target,L(i.target,r.target),a);return new C(c,l,r.up)}async function Bo(n,e,t){let s=n.pose.copy(),o=document.hidden,r=()=>o||=document.hidden;document.addEventListener("visibilitychange",r),n.measured=!0;try{let i=await Po(),a=await ka(n,s,e,t),c=await Po();return{...a,battery:i&&c&&{start:i,end:c},interrupted:o}}finally{document.removeEventListener("visibilitychange",r),n.measured=!1,n.place(s)}}async function Po(){let n=await navigator.getBattery?.().catch(()=>null);return n?{percent:Math.round(100*n.level),charging:n.charging}:null}async function ka(n,e,{seconds:t,width:s,height:o},r){let i=[],a=[];for(let p=0;p<No;p++)n.pose=Co(n,e,p),await n.drawAndWait(s,o);await n.passes();let c=performance.now(),l=0;for(let p=No,u=0;u<1e3*t;p++){n.pose=Co(n,e,p);let m=performance.now()-c,w=await n.drawAndWait(s,o);if(u=performance.now()-c,i.push({from:m,to:u,order:w}),r(Math.min(1,u/(1e3*t))),u-l<Ea)continue;let g=await n.passes();g&&a.push({from:m,to:u,passes:{...g}}),await new Promise(E=>requestAnimationFrame(E)),l=performance.now()-c}let f=1e3*Math.min(xa,t/2),h=i[i.length-1].to,d=p=>Aa(i.filter(p),a.filter(p));return{path:_a(n),cold:d(({from:p})=>p<f),steady:d(({to:p})=>p>h-f),whole:d(()=>!0),fps_by_second:Array.from({length:t},(p,u)=>Go(i.filter(({to:m})=>Math.min(Math.floor(m/1e3),t-1)===u)))}}var $o=n=>Number(n.toFixed(2));function Go(n){let e=n.reduce((t,{from:s,to:o})=>t+o-s,0);return n.length?$o(1e3*n.length/e):null}function Rt(n,e){let t=n.slice().sort((s,o)=>s-o);return $o(t[Math.floor(e*(t.length-1))]??NaN)}function Aa(n,e){let t=n.map(({from:i,to:a})=>a-i),s=n.flatMap(({order:i})=>i??[]),o=[...new Set(e.flatMap(({passes:i})=>Object.keys(i)))],r=i=>Rt(e.flatMap(({passes:a})=>a[i]??[]),.5);return{frames:t.length,fps:Go(n)??NaN,milliseconds:Rt(t,.5),milliseconds95:Rt(t,.95),order:s.length?Rt(s,.5):null,passes:o.length?Object.fromEntries(o.map(i=>[i,r(i)])):null}}function qo({eye:n,target:e,up:t}){let s=Math.min(20,Math.max(0,Math.ceil(4-Math.log10(K(L(e,n)))))),o=(r,i=s)=>r.map(a=>Number(a.toFixed(i))).join(",");return`eye=${o(n)}&at=${o(e)}&up=${o(t,5)}`}function Ho(n){let e=new URLSearchParams(n.replace(/^#/,"")),t=["eye","at","up"].map(i=>(e.get(i)??"").split(",").map(Number));if(t.some(i=>i.length!==3||!i.every(Number.isFinite)))return null;let[s,o,r]=t;return s.every((i,a)=>i===o[a])?null:new C(s,o,r)}var Sa="renderer variant levels scale noui poster background fov autorotate compare".split(" "),Ma=400;function Wo(){let n=document.querySelector("mobile-gs"),e=new URLSearchParams(location.search);for(let c of Sa){let l=e.get(c);l!==null&&n.setAttribute(c,l)}let t=e.get("url");t&&n.setAttribute("src",t),setTimeout(()=>{let c=xn();!t&&c?n.open(c):n.hasAttribute("src")||n.failed(0,"no scene is given: open a .mgs, .ply or .spz file, or add ?url=... to the address"),s(),parent===self&&n.focus({preventScroll:!0})},0);let s=()=>{let c=Ho(location.hash);c&&n.viewer?.place(c)};addEventListener("hashchange",s);let o=0,r="",i=()=>n.viewer?qo(n.viewer.pose):"";n.addEventListener("frame",()=>{r||=i(),clearTimeout(o),o=setTimeout(()=>{let c=i(),l=r!==""&&c!==r;r=c;try{l&&history.replaceState(null,"",`#${c}`)}catch{}},Ma)});let a=e.get("bench");a!==null&&Ta(n,a,e.getAll("url").slice(1))}async function Ta(n,e,t){let s={width:Math.round(innerWidth*devicePixelRatio),height:Math.round(innerHeight*devicePixelRatio)},o=Do(e,s),r=[],i;for(let a of[null,...t]){let c=Ra(n);a!==null&&n.setAttribute("src",a);let l=await c,{viewer:f}=n;if(!l||!f)return;await f.calibrated,i??=await navigator.wakeLock?.request("screen").catch(()=>null);try{let h=await Bo(f,o,d=>n.progress(0,d));r.push({scene:n.getAttribute("src")??"own",gaussians:f.count,file_bytes:l.bytes,milliseconds_to_load:Math.round(l.milliseconds),...f.device,...h})}catch(h){i?.release(),n.failed(0,`the frame rate cannot be measured: ${h.message}`);return}n.loaded(0,l.milliseconds,l.bytes)}i?.release(),n.report({date:new Date().toISOString(),...o,viewer:yn(),browser:navigator.userAgent,device_pixel_ratio:devicePixelRatio,scenes:r})}function Ra(n){return new Promise(e=>{n.addEventListener("load",t=>e(t.detail),{once:!0}),n.addEventListener("error",()=>e(null),{once:!0})})}globalThis.document?Wo():jn();
})();
