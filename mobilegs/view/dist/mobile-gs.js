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
@group(0) @binding(5) var<storage, read_write> list: array<u32>;
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
var<workgroup> found: atomic<u32>;
var<workgroup> begin: u32;
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
if (local == 0u) { atomicStore(&found, 0u); }
workgroupBarrier();
var seen: Seen;
var place = 0u;
if (i < view.count) {
seen = look_at(i);
if (seen.look.opacity > 0.0) { place = atomicAdd(&found, 1u); }
}
workgroupBarrier();
if (local == 0u) {
let number = atomicLoad(&found);
begin = atomicAdd(&drawn.count, number);
let end = begin + number;
atomicMax(&drawn.instances, select((end + BATCH - 1u) / BATCH, end, STRIPS));
}
workgroupBarrier();
if (seen.look.opacity > 0.0) {
looks[begin + place] = store(seen.look);
list[begin + place] = i | (seen.level << LEVEL_SHIFT);
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
if (supersampling == 1) {
color_out = resolved(at);
return;
}
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
@group(0) @binding(5) var bilinear: sampler;
override LEVEL = 1u;
struct Sums {
color: vec4f,
weight: f32,
}
fn with_coarser(fine: Sums, pixel: vec2i, begin: f32, first: vec2f) -> Sums {
let at = 0.5 * (vec2f(pixel) + 0.5 - begin) + 1.0 + first;
let place = at / vec2f(textureDimensions(coarse_colors));
let color = textureSampleLevel(coarse_colors, bilinear, place, 0.0);
let weight = textureSampleLevel(coarse_weights, bilinear, place, 0.0).r;
return Sums(vec4f(fine.color.rgb + color.rgb, fine.color.a * color.a), fine.weight + weight);
}
fn sums_at(pixel: vec2i) -> Sums { return Sums(textureLoad(colors, pixel, 0), textureLoad(weights, pixel, 0).r); }
struct Added {
@location(0) color: vec4f,
@location(1) weight: vec4f,
}
@fragment
fn add_enlarged(@builtin(position) position: vec4f) -> Added {
let pixel = vec2i(position.xy);
var first = vec2f();
if (LEVEL == 2u) { first = view.regions[3].xy; }
let sums = with_coarser(sums_at(pixel + vec2i(view.regions[LEVEL].xy)), pixel, 1.0, first);
return Added(sums.color, vec4f(sums.weight, 0.0, 0.0, 0.0));
}
@vertex
fn whole_picture(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
return vec4f(f32((vertex << 1u) & 2u) * 2.0 - 1.0, f32(vertex & 2u) * 2.0 - 1.0, 0.0, 1.0);
}
@fragment
fn resolve_sortfree(@builtin(position) position: vec4f) -> @location(0) vec4f {
if (view.supersampling == 1u) { return resolved(sums_at(vec2i(position.xy))); }
var sum = vec4f();
for (var k = 0; k < samples(); k++) {
sum += resolved(sums_at(sample_of(position, k)));
}
return sum / f32(samples());
}
@fragment
fn resolve_levels(@builtin(position) position: vec4f) -> @location(0) vec4f {
if (view.supersampling == 1u) { return resolved_levels(vec2i(position.xy)); }
var sum = vec4f();
for (var k = 0; k < samples(); k++) { sum += resolved_levels(sample_of(position, k)); }
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
fn resolved_levels(pixel: vec2i) -> vec4f { return resolved(with_coarser(sums_at(pixel), pixel, 0.0, vec2f())); }
fn samples() -> i32 { return i32(view.supersampling * view.supersampling); }
fn sample_of(position: vec4f, k: i32) -> vec2i {
let side = i32(view.supersampling);
return vec2i(position.xy) * side + vec2i(k % side, k / side);
}
fn resolved(sums: Sums) -> vec4f {
let sum = sums.color;
let weight = sums.weight;
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
region = regions[level];
e.center += region.xy;
target = whole.xy;
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
@group(0) @binding(6) var<storage, read> listed: Listed;
struct Corner {
@builtin(position) position: vec4f,
@location(0) @interpolate(flat) axes: vec4f,
@location(1) @interpolate(flat) color: vec4f,
@location(2) @interpolate(flat) center: vec4f,
}
struct LevelCorner {
@builtin(position) position: vec4f,
@location(0) @interpolate(flat) axes: vec4f,
@location(1) @interpolate(flat) color: vec4f,
@location(2) @interpolate(flat) center: vec4f,
@location(3) @interpolate(flat) region: vec4f,
}
const NOWHERE = vec4f(2.0, 2.0, 2.0, 1.0);
@vertex
fn corner_sorted(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
var out: Corner;
out.position = NOWHERE;
let place = place_in(vertex, instance);
if (place >= view.count) { return out; }
let i = order[place];
let look = stored(looks[i]);
if (!(look.opacity > 0.0)) { return out; }
return corner_of(vertex, look, look.opacity, ellipse_of(shape_of(i)), view.size);
}
@vertex
fn corner_sortfree(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
var out: Corner;
out.position = NOWHERE;
let place = place_in(vertex, instance);
if (place >= listed.count) { return out; }
let look = stored(looks[place]);
return corner_of(vertex, look, look.opacity, ellipse_of(shape_of(order[place])), view.size);
}
@vertex
fn corner_of_level(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> LevelCorner {
var out: LevelCorner;
out.position = NOWHERE;
let place = place_in(vertex, instance);
if (place >= listed.count) { return out; }
let look = stored(looks[place]);
let level = order[place] >> LEVEL_SHIFT;
var ellipse = ellipse_of(shape_of(order[place] & ((1u << LEVEL_SHIFT) - 1u)));
var opacity = look.opacity;
if (level > 0u) {
let coarse = to_level(ellipse, level);
opacity *= sqrt(ellipse.determinant / coarse.determinant) / f32(1u << (2u * level));
ellipse = coarse;
}
out.region = view.regions[level];
ellipse.center += out.region.xy;
let corner = corner_of(vertex, look, opacity, ellipse, view.whole);
out.position = corner.position;
out.axes = corner.axes;
out.color = corner.color;
out.center = corner.center;
return out;
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
fn alpha_at(position: vec2f, axes: vec4f, center: vec4f) -> f32 {
let d = position - center.xy;
let q = vec2f(dot(axes.xy, d), dot(axes.zw, d));
let alpha = center.z * exp(-0.5 * dot(q, q));
let edge = f32(view.soft_edge) * view.alpha_min;
return select(0.0, min(center.w * (alpha - edge), ALPHA_MAX), alpha >= view.alpha_min);
}
struct Sums {
@location(0) color: vec4f,
@location(1) weight: vec4f,
}
@fragment
fn add_weighted(corner: Corner) -> Sums {
return sums_of(alpha_at(corner.position.xy, corner.axes, corner.center), corner.color);
}
@fragment
fn add_to_level(corner: LevelCorner) -> Sums {
let at = corner.position.xy;
let outside = any(at < corner.region.xy) || any(at > corner.region.zw);
return sums_of(select(alpha_at(at, corner.axes, corner.center), 0.0, outside), corner.color);
}
fn sums_of(alpha: f32, color: vec4f) -> Sums {
let weighted = alpha * color.w;
return Sums(vec4f(color.rgb * weighted, alpha), vec4f(weighted, 0.0, 0.0, 0.0));
}
@fragment
fn cover(corner: Corner) -> @location(0) vec4f {
let alpha = alpha_at(corner.position.xy, corner.axes, corner.center);
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
vec4 regions[4];
vec4 whole;
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
regions: array<vec4f, 4>,
whole: vec2f,
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
const WEIGHT_UNIT = 10.0;
const LEVEL_SHIFT = 30u;
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
`};var Ne=()=>({name:"",before:"",failed:"",state:"",share:NaN,sentence:""}),ve=class{#e=[Ne(),Ne()];begin(e,t){let s=this.#e[e].name;this.#e[e]=t===void 0?Ne():{...Ne(),name:t,before:s,state:"loading"}}fail(e,t,s){let{name:n,before:r}=this.#e[e];this.note(e,{share:1,state:"failed",sentence:t,failed:this.names[e],name:s?r:n})}note(e,t){Object.assign(this.#e[e],t)}get state(){let e=this.#e.map(({state:s})=>s);return["failed","loading","loaded"].find(s=>e.includes(s))??""}get busy(){return this.#e.some(({state:e})=>e==="loading")}get share(){let e=this.#e.filter(({state:t})=>t).map(({share:t})=>t);return e.reduce((t,s)=>t+s,0)/e.length}get sentence(){let e=this.#e.every(({state:s})=>s),t=this.#e.map(({state:s,sentence:n,failed:r})=>s!=="failed"?"":e&&r&&!n.includes(r)?`${r}: ${n}`:n);return[...new Set(t.filter(Boolean))].join("; ")}get names(){return Lo(this.#e[0].name,this.#e[1].name)}};function Lo(o,e){let[t,s]=[o,e].map(n=>n.split("/").filter(Boolean));for(let n=1;n<=Math.max(t.length,s.length);n++){let[r,i]=[t,s].map(a=>a.slice(-n).map(Tt).join("/"));if(r!==i)return[r,i]}return[Tt(t[t.length-1]??""),Tt(s[s.length-1]??"")]}function Tt(o){try{return decodeURIComponent(o)}catch{return o}}function Ce(o){let e=o?.trim().toLowerCase()??"",t=/^([0-9a-f]{3}|[0-9a-f]{6})$/.test(e)?`#${e}`:e,s=/^#[0-9a-f]+$/.test(t)?t:Oo(t),n=s.length===4?s.replace(/[^#]/g,"$&$&"):s;if(!/^#[0-9a-f]{6}$/.test(n))return null;let r=i=>Number.parseInt(n.slice(i,i+2),16)/255;return[r(1),r(3),r(5)]}function vs(o){let e=t=>Math.round(255*Math.min(Math.max(t,0),1));return`#${o.map(t=>e(t).toString(16).padStart(2,"0")).join("")}`}function Oo(o){let e=o?document.createElement("canvas").getContext("2d"):null;if(!e)return"";let[t,s]=["#000000","#ffffff"].map(n=>(e.fillStyle=n,e.fillStyle=o,String(e.fillStyle)));return t===s?t:""}function xs(o,e,t){let s=f=>o.querySelector(`[name=${f}]`);s("background").value=vs(e.background);let n=s("scale"),r=e.scale??0;[...n.options].some(({value:f})=>Number(f)===r)||n.add(new Option(`${Math.round(100*r)} %`,String(r))),n.value=String(r),s("mode").value=e.mode,s("turning").checked=e.turning,s("stats").checked=t;let{renderer:i,adapter:a}=e.device,c=i?`Rendered with ${i}${a?` on ${a}`:""}`:"";o.querySelector(".device").textContent=c;let l=o.querySelector("[data-act=view]");l.hidden=e.views.length<2}function ys(o,e){let{name:t,value:s}=o;t==="background"?e.background=Ce(s):t==="scale"?e.scale=Number(s)||null:t==="mode"?e.mode=s==="fly"?"fly":"orbit":t==="turning"&&(e.turning=o.checked),e.redraw()}var Fo=new Map([["ArrowLeft",-.02],["ArrowDown",-.02],["ArrowRight",.02],["ArrowUp",.02],["PageDown",-.1],["PageUp",.1],["Home",-1],["End",1]]),De=class{share=.5;#e;#t;#o=["",""];constructor(e,t){this.#e=e,this.#t=t,e.onpointerdown=({pointerId:s})=>e.setPointerCapture(s),e.onpointermove=({pointerId:s,clientX:n})=>{if(!e.hasPointerCapture(s))return;let{left:r,width:i}=t.getBoundingClientRect();this.#n((n-r)/i)},e.onkeydown=s=>{let n=Fo.get(s.key);n===void 0||s.ctrlKey||s.metaKey||s.altKey||(s.preventDefault(),this.#n(this.share+n))}}show(e){this.#o=e,this.#e.querySelectorAll("span").forEach((t,s)=>t.textContent=e[s]),this.#e.setAttribute("aria-label",`${e[0]} on the left, ${e[1]} on the right`),this.#e.hidden=!1,this.#t.classList.add("drawn"),this.#n(this.share)}#n(e){this.share=Math.min(Math.max(e,0),1);let t=Math.round(100*this.share);this.#t.style.clipPath=`inset(0 0 0 ${100*this.share}%)`,this.#e.style.left=`${100*this.share}%`,this.#e.setAttribute("aria-valuenow",String(t));let[s,n]=this.#o;this.#e.setAttribute("aria-valuetext",`${t} % ${s}, ${100-t} % ${n}`)}};var Es=':host{display:block;position:relative;overflow:hidden;contain:strict;color-scheme:light dark;--paper: #16181dd9;--ink: #f3f4f6;--accent: #7db4ff;--wall: #0d0f12;--field: #ffffff1c;background:var(--wall);color:var(--ink);font:14px/1.4 system-ui,sans-serif;min-height:120px}@media(prefers-color-scheme:light){:host{--paper: #ffffffd9;--ink: #16181d;--accent: #0b62d6;--wall: #e8eaee;--field: #0000000f}}canvas{opacity:0;display:block;width:100%;height:100%;touch-action:none;cursor:grab;outline:none}canvas.drawn{opacity:1}canvas.polite{touch-action:pan-y}canvas:active{cursor:grabbing}canvas.reached{outline:2px solid var(--accent);outline-offset:-2px}.over{position:absolute;inset:0;pointer-events:none}.split{position:absolute;top:0;bottom:0;width:20px;margin-left:-10px;cursor:ew-resize;touch-action:none;outline:none}.split:before{content:"";position:absolute;inset:0 9px;background:#fff;box-shadow:0 0 3px #000a}.split:after{content:"\\2039\\2002\\203a";position:absolute;top:50%;left:-12px;width:44px;height:44px;margin-top:-22px;border-radius:50%;background:var(--paper);line-height:40px;text-align:center;font-size:20px;box-shadow:0 0 0 2px #fff,0 0 5px 2px #000a}.split:focus-visible:after{box-shadow:0 0 0 3px var(--accent)}.split span{position:absolute;top:12px;padding:2px 8px;border-radius:6px;background:var(--paper);max-width:40vw;overflow:hidden;text-overflow:ellipsis;white-space:nowrap}.split span:first-child{right:18px}.split span:last-child{left:18px}[hidden]{display:none!important}.bar{position:absolute;inset:0 0 auto;height:3px;background:transparent}.bar>div{height:100%;width:0;background:var(--accent);transition:width .15s}.bar.unknown>div{width:100%!important;animation:wait 1.2s ease-in-out infinite alternate}@keyframes wait{0%{opacity:.2}}@media(prefers-reduced-motion:reduce){.bar>div{transition:none;animation:none!important}}.panel{position:absolute;background:var(--paper);border-radius:10px;padding:12px 16px;backdrop-filter:blur(8px)}.panel:focus{outline:none}.message,.help,.report{inset:0;margin:auto;width:fit-content;height:fit-content;max-width:min(34em,92%);max-height:92%;box-sizing:border-box;overflow:auto}.message{overflow-wrap:anywhere}.stats{top:12px;left:12px;font-variant-numeric:tabular-nums;white-space:pre;pointer-events:none}.split:not([hidden])~.stats{top:52px}.said{right:12px;top:12px;pointer-events:none}.said:not(.seen){clip-path:inset(50%)}h2{font-size:16px;margin:0 0 8px}.help dl{display:grid;grid-template-columns:fit-content(45%) 1fr;gap:4px 16px;margin:0 0 12px}.help dt{font-weight:600}.help dd{margin:0}.buttons{position:absolute;right:12px;left:12px;bottom:calc(12px + env(safe-area-inset-bottom));display:flex;flex-wrap:wrap;justify-content:end;gap:8px;pointer-events:none}.settings{right:12px;bottom:calc(68px + env(safe-area-inset-bottom));width:min(26em,calc(100% - 24px));box-sizing:border-box;max-height:calc(100% - 80px);overflow:auto}@media(max-height:500px){.settings{bottom:12px;max-height:calc(100% - 24px);columns:2;width:min(40em,calc(100% - 24px))}}.settings p{display:flex;flex-wrap:wrap;align-items:center;gap:8px;margin:0 0 8px}.settings p>label{flex:1}.settings>label{display:flex;align-items:center;gap:8px;min-height:36px}.settings>small{display:block;margin:8px 0 12px;overflow-wrap:anywhere}button,select,[type=color]{font:inherit;color:inherit;background:var(--paper);border:0;border-radius:10px;min-width:44px;min-height:44px;padding:0 9px;cursor:pointer;pointer-events:auto}.panel :is(button,select,[type=color]){background:var(--field)}[type=color]{padding:6px}[type=checkbox]{width:20px;height:20px;margin:0;accent-color:var(--accent)}button:hover{color:var(--accent)}:is(button,select,input,textarea):focus-visible{outline:2px solid var(--accent)}textarea{font:12px/1.3 ui-monospace,monospace;color:inherit;background:transparent;max-width:100%}.drop{inset:12px;border:2px dashed var(--accent);display:grid;place-items:center}';var zo=[["Drag","rotate the scene"],["Two fingers, right button or Shift","move sideways"],["Pinch or wheel","zoom in and out"],["Double tap","look at that point"],["Arrow keys","rotate"],["W A S D Q E","fly; hold Shift to fly faster"],["M","switch between orbiting and looking around"],["V","next training camera"],["R","back to the first view"],["F","full screen"],["P","save a picture"],["I","frame rate and size"],["O","settings"],["H","help"]],_s=`
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
<dl>${zo.map(([o,e])=>`<dt>${o}</dt><dd>${e}</dd>`).join("")}</dl>
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
<div class="panel drop" hidden>Drop a scene to open it, or two to compare them</div>`,Mt=new Map(Object.entries({r:"reset",m:"mode",f:"full",h:"help",i:"stats",o:"settings",p:"picture",v:"view"}));var ks=new Map([["KeyW",[0,0,1]],["KeyS",[0,0,-1]],["KeyA",[-1,0,0]],["KeyD",[1,0,0]],["KeyQ",[0,1,0]],["KeyE",[0,-1,0]]]),As=new Map([["ArrowLeft",[-1,0]],["ArrowRight",[1,0]],["ArrowUp",[0,-1]],["ArrowDown",[0,1]]]),Pe=class{#e;#t;#o=new AbortController;#n=new Map;#s=new Set;#r=!1;#i={x:0,y:0,time:0};constructor(e,t){this.#e=e,this.#t=t;let s=(n,r)=>e.addEventListener(n,r,{signal:this.#o.signal,passive:!1});s("pointerdown",n=>this.#c(n)),s("pointermove",n=>this.#l(n)),s("pointerup",n=>this.#f(n)),s("pointercancel",n=>this.#f(n)),s("wheel",n=>this.#w(n)),s("contextmenu",n=>n.preventDefault()),s("keydown",n=>this.#g(n,!0)),s("keyup",n=>this.#g(n,!1)),s("blur",()=>this.#s.clear())}get busy(){return this.#s.size>0}advance(e){if(!this.busy)return;let t=this.#t.pose(),s=.9*t.reach*e*(this.#r?4:1);for(let n of this.#s){let r=ks.get(n);r&&t.move(r[0]*s,r[1]*s,r[2]*s);let i=As.get(n);i&&this.#a(i[0]*1.5*e,i[1]*1.5*e)}this.#t.changed()}destroy(){this.#o.abort()}#a(e,t){let s=this.#t.pose();this.#t.mode()==="orbit"?s.orbit(e,t):s.look(e,t)}#c(e){this.#e.focus({preventScroll:!0}),this.#e.setPointerCapture(e.pointerId),this.#n.set(e.pointerId,{x:e.offsetX,y:e.offsetY});let{x:t,y:s,time:n}=this.#i,r=Math.hypot(e.offsetX-t,e.offsetY-s)<20,i=this.#n.size===1&&e.button===0;i&&r&&e.timeStamp-n<350&&this.#t.focus(e.offsetX,e.offsetY),this.#i={x:e.offsetX,y:e.offsetY,time:i?e.timeStamp:-1/0},this.#t.held(),e.preventDefault()}#l(e){let t=this.#n.get(e.pointerId);if(t===void 0)return;let s={x:e.offsetX,y:e.offsetY};Math.hypot(s.x-this.#i.x,s.y-this.#i.y)>6&&(this.#i.time=-1/0),this.#n.size===1?this.#d(s.x-t.x,s.y-t.y,e):this.#n.size===2&&this.#u(e.pointerId,s),this.#n.set(e.pointerId,s),this.#t.changed()}#f(e){this.#n.delete(e.pointerId)}#d(e,t,s){s.buttons&6||s.shiftKey||s.ctrlKey?this.#h(e,t):this.#a(e*.006,t*.006)}#u(e,t){let s=this.#n.get(e),n=[...this.#n].find(([a])=>a!==e)?.[1];if(s===void 0||n===void 0)return;let r=Math.hypot(s.x-n.x,s.y-n.y),i=Math.hypot(t.x-n.x,t.y-n.y);this.#t.mode()==="fly"?this.#t.pose().move(0,0,2*(i-r)*this.#b):r>0&&i>0&&this.#t.pose().dolly(r/i),this.#h((t.x-s.x)/2,(t.y-s.y)/2)}#h(e,t){this.#t.pose().move(-e*this.#b,-t*this.#b,0)}get#b(){let{target:e,eye:t}=this.#t.pose();return Math.hypot(...e.map((s,n)=>s-t[n]))/Math.max(this.#e.clientHeight,1)}#w(e){if(this.#e.classList.contains("polite")&&!e.ctrlKey&&!e.metaKey)return;e.preventDefault();let t=e.deltaMode===WheelEvent.DOM_DELTA_LINE?16:1,s=e.deltaY*t*(e.ctrlKey?8:1)*.0012,n=this.#t.pose();this.#t.mode()==="orbit"?n.dolly(Math.exp(s)):n.move(0,0,-s*n.reach),this.#t.changed()}#g(e,t){let{code:s}=e;if(this.#r=e.shiftKey,!t&&s.startsWith("Meta")&&this.#s.clear(),t&&(e.ctrlKey||e.metaKey||e.altKey)||!ks.has(s)&&!As.has(s))return;let n=t&&!this.#s.has(s);t?this.#s.add(s):this.#s.delete(s),n&&this.advance(.03),this.#t.changed(),e.preventDefault()}};function Rt(){let o=URL.createObjectURL(new Blob([`(${bundle})()`],{type:"text/javascript"}));return setTimeout(()=>URL.revokeObjectURL(o),6e4),new Worker(o)}function Ss(o,e){let t=globalThis.preloadedWorker;delete globalThis.preloadedWorker;let s;return t&&"url"in o&&t.url===o.url?(s=t.worker,t.messages.forEach(e)):(t?.worker.terminate(),s=Rt(),s.postMessage(o)),s.onmessage=e,s}async function Ts(){let o=globalThis.preloadedAdapter;return delete globalThis.preloadedAdapter,await o??navigator.gpu.requestAdapter({powerPreference:"high-performance"})}async function Ms(o){return g[o]}function Be(o,[e,t,s]){let n=o.length/3,r=new Float32Array(n);for(let l=0;l<n;l++)r[l]=e*o[3*l]+t*o[3*l+1]+s*o[3*l+2];let i=new Uint32Array(r.buffer);for(let l=0;l<n;l++)i[l]=i[l]&2147483648?i[l]:~i[l]&2147483647;let a=Uint32Array.from({length:n},(l,f)=>f),c=new Uint32Array(n);for(let l of[0,16]){let f=new Uint32Array(65537);for(let h=0;h<n;h++)f[(i[h]>>>l&65535)+1]+=1;for(let h=0;h<65536;h++)f[h+1]+=f[h];for(let h=0;h<n;h++){let d=a[h];c[f[i[d]>>>l&65535]++]=d}[a,c]=[c,a]}return a}var Uo=/[\x00-\x1f\x7f-\x9f\u2028\u2029\p{Cs}]/gu,y=class extends Error{name="SceneError";constructor(e){super(e.replace(Uo,"\uFFFD"))}};function G(o){return new DataView(o.buffer,o.byteOffset,o.byteLength)}var ee=class{#e;#t=0;#o=0;constructor(e){this.#e=e}get left(){return 8*(this.#e.length-this.#t)-this.#o}take(e){let t=this.#e,s=this.#t,n=t[s]|t[s+1]<<8|t[s+2]<<16|t[s+3]<<24,r=this.#o+e,i=n>>>this.#o&(1<<e)-1;return this.#t=s+(r>>>3),this.#o=r&7,i}atEnd(){return this.left<8&&this.#e[this.#t]>>>this.#o===0}};function ce(o,e){let t=Math.ceil(e/8);if(o.length!==t)throw new y(`packed bits take ${o.length} bytes where ${t} belong`);if(e%8&&o[t-1]>>e%8)throw new y("packed bits end in bits that are not zero");return new ee(o)}var Rs="0061736d01000000012a0460077f7f7f7f7f7f7d0060037f7f7f0060097f7f7f7f7f7f7f7f7f017f60097f7f7f7f7f7f7f7d7d00020f0103656e76066d656d6f727902000103060500010202030607017f014180080b073705056c61796572000005756e69747300010a70756c6c5f706c61696e00020f70756c6c5f636f6e7465787475616c0003047061636b00040abc21059c0404017f017b047f0b7b024020054101480d00200120054102746a21072006fd13210820044102742209410148210a0340200020094102746a210b4100210c03402001fd09000c210d2001fd090008210e2001fd090004210f2001fd090000211002400240200a450d00200d2111200e2112200f2113201021140c010b2002200c4102746a2104200d2111200e2112200f2113201021142000210503402004fd00001022152005fd0900002216fde6012010fde40121102004fd00000022172016fde6012014fde401211420152005fd0900042216fde601200ffde401210f20172016fde6012013fde401211320152005fd0900082216fde601200efde401210e20172016fde6012012fde401211220152005fd09000c2216fde601200dfde401210d20172016fde6012011fde401211120044180046a2104200541106a2205200b490d000b0b2003200c4102746a2205201120082011fde601fde901fd0b00800c2005201220082012fde601fde901fd0b0080082005201320082013fde601fde901fd0b0080042005201020082010fde601fde901fd0b00102005201420082014fde601fde901fd0b0000200541900c6a200d2008200dfde601fde901fd0b000020054190086a200e2008200efde601fde901fd0b000020054190046a200f2008200ffde601fde901fd0b0000200c41f800492105200c41086a210c20050d000b20034180106a2103200b2100200141106a22012007490d000b0b0bd50104027f017b027f017b200020024109746a2103410021040340fd0c0000000000000000000000000000000021052000200441027422066a22022107034020052007fd00000022082008fde601fde401210520074180046a22072003490d000b200120066a2107fd0c0000803f0000803f0000803f0000803f2005fde301fd0cccbc8c2bccbc8c2bccbc8c2bccbc8c2bfde901fde70121050340200720052002fd000000fde601fd0b000020074180046a210720024180046a22022003490d000b200441fc00492102200441046a210420020d000b0bd30101087f41002109034002402006200820092007491b220a4101480d002000200a4103746a210b2000210a0340024020022001200a280200220c41ffff0071220d4101746a2f0100220e4102746a280200220f0d0041000f0b20042f01002110200a28020420094101746a200e3b0102200a20104100200d200f410f766b200f41ffff0171200c410e766c6a220c4180800449220f1b200c200f41047474723602002004200f4101746a2104200a41086a220a200b490d000b0b0240200420054b0d00200941016a220920074d0d010b0b20040bf101010a7f410021094100210a0340024020062008200a2007491b220b4101480d002000200b4103746a210c2000210b0340024020022009200b280204200a4101746a220d2f010071220e20036c2001200e410f74200b280200220f41ffff00712210410174726a2f010022116a4102746a280200220e0d0041000f0b20042f01002112200d20113b0102200b201241002010200e410f766b200e41ffff0171200f410e766c6a220d4180800449220e1b200d200e41047474723602002004200e4101746a2104200b41086a220b200c490d000b0b0240200420054b0d00417f2109200a41016a220a20074d0d010b0b20040bfc1707067f027b037f0c7b037f0e7b017f2005417e7121092005410171210a200641036c210b2006410174210c20044180206a210d200541017441026a210e2008fd13210f2007fd132110410021112006410274221241027421130340fd0c020000000200000002000000020000002214fd0c010000000100000001000000010000002215fd0c0000000000000000000000000000000022162001fd000080042217fde0012001fd0000002218fde001fd442219fd522001fd00008008221afde001201720182019fd522217fde001fd442218fd522119fd0c03000000030000000300000003000000211b2001fd0000800c221c201a20172018fd522217201cfde0012017fde001fd44221dfd52221efd0cffffff7fffffff7fffffff7fffffff7f221cfd4e2016fd37211ffd0c0000000000000000000000000000000022172118410121202016211a4100212102400240024020050e020201000b0340201720032020410a746a2222fd000000fde001fde90120224180086afd000000fde001fde9012117201820224180046afd000000fde001fde901202241800c6afd000000fde001fde9012118202041026a2120202141026a22212009470d000b0b0240200a450d00201720032020410a746a2222fd000000fde001fde9012117201820224180046afd000000fde001fde90121180b2018fd0cffff0f00ffff0f00ffff0f00ffff0f00221afdae014114fdad0121162017201afdae014114fdad01211a0b201b2019201dfd52211d200d2003fd000080042217fd0c000000800000008000000080000000802223fd4e2003fd00000022184110fdad01fd0c008000000080000000800000008000002224fd4efd502018201cfd4e2219fd0c0000804b0000804b0000804b0000804b2225fde601fd6afdf80120192018410dfdad012015fd4efdae01fd0cff0f00c8ff0f00c8ff0f00c8ff0f00c82226fdae01410dfdad01fd0cff7b0000ff7b0000ff7b0000ff7b00002227fdb7012019fd0c000080380000803800008038000080382228fd3afd52fd502017201cfd4e22182025fde601fd6afdf80120182017410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120182028fd3afd524110fdab01fd502217fd0c0000ffff0000ffff0000ffff0000fffffd4efd0ce2f00000e2f00000e2f00000e2f00000fd502017201ffd522217fd5a00000041022120200d20064102746a2017fd5a000001200d200c4102746a2017fd5a000002200d200b4102746a2017fd5a0000032016fd0c78030000780300007803000078030000221ffdb901fd0c770400007704000077040000770400002229fdb601fd0c88fcffff88fcffff88fcffff88fcffff222afdae01212bfd0c00008037000080370000803700008037212cfd0c0000fe420000fe420000fe420000fe422117201a201ffdb9012029fdb601202afdae01212d0240200e41024d0d002017202b4114fdab01202cfdae01fde70121192017202d4114fdab01202cfdae01fde701211a200d21220340202241046a22222019200320204109742221418004726afd000000fde601fd0c0000fec20000fec20000fec20000fec22218fde9012017fde801fd0c002000440020004400200044002000442216fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4e201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf801fd0cff000000ff000000ff000000ff000000fd4e2019200320214180086a2221418004726afd000000fde6012018fde9012017fde8012016fde401fdf8014118fdab01201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4efd50fd50fd502218fd5a000000202220126a2018fd5a0000012022200c4102746a2018fd5a0000022022200b4102746a2018fd5a000003202041046a2220200e490d000b0b200441346a202d4110fdab01202b4118fdab01fd502218fd5a000003200441246a2018fd5a000002200441146a2018fd5a000001200441046a2018fd5a000000200441386a200f2000fd00008004fdfa012010fde501fde601fd0c000000000000000000000000000000002218fde901fd0c0000803f0000803f0000803f0000803f2216fde801fd0c00e0ff4400e0ff4400e0ff4400e0ff44221afde601fd0c0000003f0000003f0000003f0000003f2219fde401fdf801410bfdab01200f2000fd00008008fdfa012010fde501fde6012018fde9012016fde801fd0c00c07f4400c07f4400c07f4400c07f44fde6012019fde401fdf8014116fdab01fd50200f2000fd000000fdfa012010fde501fde6012018fde9012016fde801201afde6012019fde401fdf801fd502216fd5a000003200441286a2016fd5a000002200441186a2016fd5a000001200441086a2016fd5a0000002004413c6afd0c71aa34c471aa34c471aa34c471aa34c4fd0c71aa344471aa344471aa344471aa3444201e2018fd43fd5222162001fd00008004221a2001fd000000201d2015fd39fd52fde601fd0c001080440010804400108044001080442219fde401fdf801410afdab01fd0c00fc0f0000fc0f0000fc0f0000fc0f00fd4e201d4114fdab01fd5020162001fd00008008222b201a201d2014fd39fd52fde6012019fde401fdf801fd0cff030000ff030000ff030000ff030000221afd4efd50410afdab0120162001fd0000800c202b201d201bfd39fd52fde6012019fde401fdf801201afd4efd502216fd5a0000032004412c6a2016fd5a0000022004411c6a2016fd5a0000012004410c6a2016fd5a0000002002fd0000802c211d2002fd00008028211b2002fd00008024212b2002fd00008020212d2002fd0000801c21142002fd00008018211e2002fd00008014212e2002fd00008010212f2002fd0000800c2130200441b0106a2002fd0000800422162023fd4e2002fd00000022194110fdad012024fd4efd502019201cfd4e221a2025fde601fd6afdf801201a2019410dfdad012015fd4efdae012026fdae01410dfdad012027fdb701201a2028fd3afd52fd502016201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd524110fdab01fd502216fd5a000003200441a0106a2016fd5a00000220044190106a2016fd5a00000120044180106a2016fd5a000000200441b4106a2002fd000080082216201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd522030fde0012018fde901202ffde001fde901202efde001fde901201efde001fde9012014fde001fde901202dfde001fde901202bfde001fde901201bfde001fde901201dfde001fde901fd0cffff0f00ffff0f00ffff0f00ffff0f00fdae014114fdad01201ffdb9012029fdb601202afdae0122184110fdab0120164110fdad012024fd4efd50fd502002fd0000800c201720184114fdab01202cfdae01fde7012218fde601fd0c0000fec20000fec20000fec20000fec22216fde9012017fde801fd0c002000440020004400200044002000442219fde401fdf8014118fdab01fd50221afd5a000003200441a4106a201afd5a00000220044194106a201afd5a00000120044184106a201afd5a00000020044188106a213141002120410121210340203120204102746a222241306a20182020410b7420026a22204180186afd000000fde6012016fde9012017fde8012019fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4e2018202041801c6afd000000fde6012016fde9012017fde8012019fde401fdf8014118fdab01fd50201820204180146afd000000fde6012016fde9012017fde8012019fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4efd50201820204180106afd000000fde6012016fde9012017fde8012019fde401fdf801fd0cff000000ff000000ff000000ff000000fd4efd50221afd5a000003202241206a201afd5a000002202241106a201afd5a0000012022201afd5a00000020214101712122410021214101212020220d000b200441c0006a2104200341106a2103200241106a2102200141106a2101200041106a2100200d20136a210d201141fc00492122201141046a211120220d000b0b";var xe,Ls=new WeakMap;function $e(o){return typeof WebAssembly=="object"?new WebAssembly.Memory({initial:Math.ceil(o/2**16)}):null}function le(o){if(o===null)return null;if(xe===void 0)try{let t=Rs.match(/../g);xe=new WebAssembly.Module(Uint8Array.from(t,s=>parseInt(s,16)))}catch{xe=null}if(xe===null)return null;let e=Ls.get(o);if(!e){let{exports:t}=new WebAssembly.Instance(xe,{env:{memory:o}});e=t,Ls.set(o,e)}return e}var Lt=2048,te;function Os({contexts:o,alphabet:e,symbols:t,spans:s},n,r,i,a){te===void 0&&(te=$e(1));let c=le(te);if(te===null||c===null)return;let l=n.length,f=Lt+2*t.length,h=f+4*s.length,d=h+i.length,p=d+2*l+2,u=Math.ceil((p+2*a+2)/2**16)-te.buffer.byteLength/2**16;u>0&&te.grow(u);let{buffer:m}=te,w=new Uint32Array(m,0,2*l);n.forEach((E,b)=>w.set([E,p-2+2*r[b]],2*b)),new Uint16Array(m,Lt,t.length).set(t),new Uint32Array(m,f,s.length).set(s),new Uint8Array(m,h,i.length).set(i);let _=(o>1?c.pull_contextual:c.pull_plain)(0,Lt,f,e,h,d,l,Math.floor(a/l),a%l);return{decoded:new Uint16Array(m,p,a).slice(),left:_?(d-_)/2:-1/0,states:w.filter((E,b)=>b%2===0)}}var qe=14,Ee=1<<qe,Fs=65536,Io=64,No=256,Co=2048,Ge=12,zs=-1/0;function se(o,e,t,s=!1){if(o.length<Ge)throw new y("a rANS stream is too short to hold its header");let n=G(o),r=n.getUint16(0,!0),i=n.getUint16(2,!0),a=n.getUint32(4,!0),c=n.getUint32(8,!0);if(r!==t)throw new y(`a rANS stream of ${r} symbols stands where ${t} belong`);if(i!==1&&i!==t||i>Io)throw new y(`a rANS stream has ${i} contexts`);let l=Do(e);if(o.length!==Ge+a+4*l+2*c)throw new y("a rANS stream is longer or shorter than its header says");let f=Ge+a,h=Bo(o.subarray(Ge,f),i,t),d=new Uint32Array(l).map((_,E)=>n.getUint32(f+4*E,!0));if(d.some(_=>_<Fs))throw new y("a rANS stream starts in an impossible state");let p=Math.floor(e/l),u=e%l,m=d.map((_,E)=>E*p+Math.min(E,u)),w=[h,d,m,o.subarray(f+4*l),e],v=(s?void 0:Os(...w))??Po(...w);if(v.left===zs)throw new y("a rANS stream leads to a context that is not used: it is damaged");if(v.left<0)throw new y("a rANS stream ends early: the file is damaged");if(v.left>0||v.states.some(_=>_!==Fs))throw new y("a rANS stream does not end where it should: the file is damaged");return v.decoded}function Do(o){let e=Math.max(1,Math.floor(o/Co));return Math.min(No,1<<31-Math.clz32(e))}function Po({contexts:o,alphabet:e,symbols:t,spans:s},n,r,i,a){let c=n.length,l=Math.floor(a/c),f=a%c,h=new Uint16Array(a),d=i.length/2,p=new Uint16Array(d+1);new Uint8Array(p.buffer).set(i);let u=0;for(let m=0;m<=l;m++){let w=m<l?c:f,v=o>1&&m>0;for(let _=0;_<w;_++){let E=r[_]+m,b=v?h[E-1]:0,k=n[_],S=k&Ee-1,z=t[b<<qe|S],K=s[b*e+z];if(K===0)return{decoded:h,left:zs,states:n};let Y=Math.imul(K&32767,k>>>qe)+S-(K>>>15)|0,R=(Y>>>16)-1>>>31;n[_]=Y<<16*R|p[u]&-R,u+=R,h[E]=z}}return{decoded:h,left:d-u,states:n}}function Bo(o,e,t){let s=new ee(o),n=new Uint16Array(e*Ee),r=new Uint32Array(e*t);for(let i=0;i<e;i++){if(!ye(s,1))continue;let a=$o(s,t),c=i*Ee;for(let l=0;l<t;l++){let f=a[l];f!==0&&(r[i*t+l]=c%Ee<<15|f,n.fill(l,c,c+f),c+=f)}}if(!s.atEnd())throw new y("a rANS stream's frequency tables are longer than they should be");return{contexts:e,alphabet:t,symbols:n,spans:r}}function $o(o,e){let t=new Uint16Array(e),s=[];for(let a=0;a<e;a++)ye(o,1)&&s.push(a);let n=ye(o,4),r=s.pop(),i=Ee;for(let a of s){let c=n;for(;!ye(o,1);)c++;if(c>qe)throw new y("a rANS stream's frequency table holds a number out of range");t[a]=ye(o,c)+(1<<c)-(1<<n)+1,i-=t[a]}if(r===void 0||i<1)throw new y("a rANS stream's frequencies do not sum to 16384");return t[r]=i,t}function ye(o,e){if(e>o.left)throw new y("a rANS stream's frequency tables end early");return o.take(e)}var Go=Float64Array.from({length:31},(o,e)=>2**(Math.max(e,1)-25)),Is=new Float32Array(1),Us=new Uint32Array(Is.buffer);function Ot(o){return(o&31744)===31744}function U(o){let e=o>>10&31,t=(o&1023)+(e>0?1024:0);return(o&32768?-t:t)*Go[e]}function W(o){Is[0]=o;let e=Us[0]>>>16&32768,t=Us[0]&2147483647;if(t<947912704){let s=Math.abs(o)*16777216,n=Math.round(s);return e|(n-s===.5&&n%2?n-1:n)}return e|Math.min(t+4095+(t>>>13&1)-939524096>>>13,31743)}function Ft(o,e){let t=qo(o,e);if(t.some(Ot))throw new y(`the stream '${o.name}' of the .mgs file has numbers that are not finite`);return Float32Array.from(t,U)}function qo({name:o,codec:e,data:t},s){let n=new y(`the stream '${o}' of the .mgs file has a wrong length`);if(e==="raw"){if(t.length!==2*s)throw n;return Uint16Array.from({length:s},(l,f)=>t[2*f]|t[2*f+1]<<8)}if(t.length<4)throw n;let r=4+G(t).getUint32(0,!0);if(r>t.length||e==="halves"&&t.length!==r+s)throw n;let i=se(t.subarray(4,r),s,256),a=t.subarray(r),c=e==="planes"?se(a,s,256):a;return i.map((l,f)=>l<<8|c[f])}var Ho=49,ne=24,He=Uint32Array.from({length:4096},(o,e)=>{let t=0;for(let s=0;s<12;s++)t|=(e>>>s&1)<<10*(s%3)+Math.floor(s/3);return t});function Ns(o,e){let t=o.length<4?1/0:4+G(o).getUint32(0,!0);if(t>o.length)throw new y("the stream of positions is too short to hold what its header says");let s=se(o.subarray(4,t),e,Ho),n=0;for(let l=0;l<e;l++)n+=Math.max(s[l]-1,0);let r=ce(o.subarray(t),n),i=new Uint16Array(3*e),a=0,c=0;for(let l=0;l<e;l++){let f=s[l]-1;if(f>=ne?(a+=r.take(ne),c+=(1<<f-ne)+r.take(f-ne)):f>=0&&(a+=(1<<f)+r.take(f)),c+=a>>>ne,a&=(1<<ne)-1,c>>>ne)throw new y("the stream of positions leaves its 48-bit grid");let h=He[a&4095]|He[a>>>12]<<4,d=He[c&4095]|He[c>>>12]<<4;for(let p=0,u=0;p<3;p++,u+=10){let m=h>>>u&255|(d>>>u&255)<<8,w=m&32768?m&32767:m^65535;if(Ot(w))throw new y("the stream of positions holds numbers that are not finite");i[3*l+p]=w}}return i}function Cs(o,e){let t=3*Math.ceil(o.length/3/e);if(t<=3)return o;let s=new Uint16Array(3*Math.ceil(o.length/t));for(let n=0,r=0;n<o.length;n+=t,r+=3)s.set(o.subarray(n,n+3),r);return s}function zt(o,{center:e,radius:t,exponent:s}){let n=new Float32Array(o.length),r=t*2**s;for(let i=0;i<o.length;i++)n[i]=e[i%3]+Math.fround(r*U(o[i]));return n}function We(o){return"stored"in o?zt(o.stored,o.grid):o}var Wo={from:64,to:65536,times:4},Vo={from:32,to:1024,times:2},Ds=128,Bs="mobilegs variant 1";function $s(o,e){let t=null;try{t=e?.getItem(`${Bs} ${o.describe()}`)??null}catch{}return o.variants.find(s=>Ws(s)===t)??null}async function Gs(o,e){let t={floats:!1,strips:!1},s={...t};if(await Ps(o,t,{...t,strips:!0},Wo,jo)&&(s.strips=!0),o.variants.some(({floats:n})=>n)){let n={...s,floats:!0};await Ps(o,s,n,Vo,Xo)&&(s.floats=!0)}try{e?.setItem(`${Bs} ${o.describe()}`,Ws(s))}catch{}return s}async function qs(o){o.setScene({...Ut(1,1,()=>[0,0,1]),packing:{center:[0,0,0],unit:1,leastScaleBits:0,scaleBitsSpan:0},shapes:Uint32Array.of(0,15360,0,0),colors:new Uint32Array(4),shSize:4,lobes:new Uint32Array(5),lobeSize:9}),await o.drawUnseen(It(1))}function Hs(o){o.setDots({means:Float32Array.of(0,0,1),color:[0,0,0],side:1,background:[0,0,0]}),o.drawDots(It(1)),o.setDots(null)}var Ws=({floats:o,strips:e})=>`${o} ${e}`;async function Ps(o,e,t,{from:s,to:n,times:r},i){let a=0;for(let c=s;;c*=r){let{scene:l,side:f}=i(c);o.setScene(l);let h=[1/0,1/0];for(let p=0;p<=3;p++)for(let[u,m]of[e,t].entries()){o.variant=m;let w=performance.now();await o.drawUnseen(It(f)),p>0&&(h[u]=Math.min(h[u],performance.now()-w))}let d=Math.max(...h);if(c===s&&(a=d),d>Math.max(4,3*a)||c>=n)return h[1]<.85*h[0]}}function jo(o){let e=Math.ceil(Math.sqrt(o)),t=n=>2*(n+.5)/e-1;return{scene:Ut(o,.001,n=>[t(n%e),t(Math.floor(n/e)),1]),side:256}}function Xo(o){return{scene:Ut(Ds,1,e=>[0,0,1+e/Ds]),side:o}}function Ut(o,e,t){let s=new Float32Array(12*o);for(let n=0;n<o;n++){let[r,i,a]=t(n);s.set([e,0,0,r,0,e,0,i,0,0,e,a],12*n)}return{count:o,packing:null,shapes:s,colors:new Float32Array(3*o),shSize:1,lobes:new Float32Array(2*o).fill(1),lobeSize:1,sorted:!1,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},background:[0,0,0]}}function It(o){return{viewmat:[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],fx:o/2,fy:o/2,cx:o/2,cy:o/2,width:o,height:o,near:.1}}function Z(o,e){let t=[[o,e]];for(let s=1;s<4;s++)t.push(t[s-1].map(n=>(n-(s===1?0:1)>>1)+2));return t}function V(o,e){let[,...t]=Z(o,e),s=[[0,0]],n=0;for(let[,r]of t)s.push([o,n]),n+=r;return{places:s,size:[o+t[0][0],Math.max(e,n)]}}function Vs(o){let[e,t,s]=[1,2,3].map(c=>o[`hidden${c}.weight`]),n=["opacity","phi"].map(c=>({weights:Ko(o[`${c}.weight`],s,128),offset:o[`${c}.weight`].reduce((l,f,h)=>l+f*o["hidden3.bias"][h],o[`${c}.bias`][0])})),r=new Float32Array(16*2497),i=0,a=(c,l,f)=>{for(let h=c;h<c+4;h++)for(let d=l;d<l+4;d++)r[i++]=f(h,d)};for(let c=0;c<256;c+=4)for(let l=0;l<24;l+=4)a(c,l,(f,h)=>h<22?e[22*f+h]:h===22?o["hidden1.bias"][f]:0);for(let c=0;c<128;c+=4)a(c,0,(l,f)=>f===0?o["hidden2.bias"][l]:0);for(let c=0;c<256;c+=4)for(let l=0;l<128;l+=4)a(l,c,(f,h)=>t[256*f+h]);for(let c=0;c<128;c+=4)a(0,c,(l,f)=>n[l]?.weights[f]??0);return a(0,0,(c,l)=>l===0?n[c]?.offset??0:0),r}function Ko(o,e,t){return Array.from({length:t},(s,n)=>o.reduce((r,i,a)=>r+i*e[t*a+n],0))}function he({packing:o,shSize:e,lobeSize:t,network:s}){return o?{shapes:4,colors:4,lobes:s?10:t+2>>1}:{shapes:12,colors:3*e,lobes:2*t}}function js(o){return U(o&65535)}var de=class{#e;#t;#o;constructor(e,{sh:t,scales:s,quats:n},r){this.#e=e,this.#t=[[t,e.part(r,0,12)],[s,e.part(r,12,3)]],this.#o=[n,e.part(r,15,4)]}write(){let[e,t]=this.#o;for(let[s,n]of this.#t)this.#e.units(s,n);t.numbers.set(e.numbers)}};var Yo=[["context1",64,96],["context2",13,64],["static1",64,16],["static2",3,64],["view1",64,16],["view2",9,64]],Qo=[["both1",128,6],["static2",3,64],["view2",9,64]],Nt={linear:"color-matrices",networks:"appearance-decoder",latent_networks:"color-networks"};function Xs({colors:o,scalars:e}){let t=e.get("appearance")?.columns.length??6,s={linear:[["static2",3,3],["view2",9,t-3]],networks:Yo,latent_networks:Qo};return[Nt[o],s[o]]}var Ks=[["hidden1.weight",256,22],["hidden1.bias",1,256],["hidden2.weight",128,256],["hidden2.bias",1,128],["hidden3.weight",64,128],["hidden3.bias",1,64],["phi.weight",1,64],["phi.bias",1,1],["opacity.weight",1,64],["opacity.bias",1,1]];function Ys({degree:o,latents:e,hidden:t}){let s=2*(o+1)**2,n=[19+e,...t],r=[["bias",1,s],["basis",e,s]];return t.length===0||([...t,s].forEach((i,a)=>r.push([`weights.${a}`,i,n[a]])),t.forEach((i,a)=>r.push([`offsets.${a}`,1,i]))),r}function Qs(o){return o.reduce((e,[,t,s])=>e+t*s,0)}function Zs(o,e){let t=0;return Object.fromEntries(e.map(([s,n,r])=>[s,o.subarray(t,t+=n*r)]))}var Ke=Object.freeze({blur:.3,antialiased:!1,soft_edge:!1}),Zo=2**26,Jo=8,Dt=4096,Ct=2**14,er=1e-5,tr=1e3,sr=80,nr=8,Pt=32,or=256,rr=3,ir=64,Js=2**16,en=64,tn=4096,ar=1e-20,Ve=1e20,cr=/[\x00-\x1f\x7f-\x9f\p{Cs}]/u,sn=["mobile_gs","no_depth","no_scale","sort_free_gs"],lr=[["scale",[[3,1],[1,3]]],["rotation",[[2,2],[1,4]]],["appearance",[[3,2]]],["opacity",[[1,1]]]],nn=[6,12],fr=[["scale",3],["rotation",3],["appearance",nn[0]],["opacity",1]];function on(o,e){let{colors:t="networks"}=o;for(let[h,d,...p]of[["mode",o.mode,"nvq","sq"],["blend",o.blend,"sortfree","sorted"],["sh_degree",o.sh_degree,1],["colors",t,"linear","networks","latent_networks"]])if(!p.includes(d))throw new y(`the .mgs file has ${h} '${an(d)}', which this program does not know: a newer one may`);let s=ur(o),n=o.network;if(typeof n!="boolean")throw A("network");if(n&&s!==null)throw new y("the .mgs file has lobes and a view network: it can have one of them");let r=o.mode==="sq",i=L(o,"count",1,Zo),a={count:i,lodSizes:dr(o,i),cuts:r?new Map:pr(C(o,"codebooks"),s),scalars:r?mr(C(o,"scalars"),s,t==="linear"):new Map,grid:wr(C(o,"positions")),colors:t,sorted:o.blend==="sorted",lobes:s,network:n,weighting:gr(C(o,"weighting")),footprint:br(C(o,"footprint")),background:Xe(o,"background",3),near:j(o,"near"),views:_e(o,"views").map(vr),meta:xr(C(o,"meta"))},c=hr(a),f=o.streams.filter(h=>c.has(h.name)).reduce((h,d)=>h+d.bytes,0);if(i>f)throw new y(`the .mgs file claims ${i} Gaussians in ${f} of its ${e} bytes: it is damaged`);if(a.footprint.soft_edge&&a.sorted)throw A("footprint.soft_edge");if(a.background.some(h=>h<0||h>1))throw A("background");if(!(a.near>0&&a.near<=Ve))throw A("near");if(a.views.length>ir)throw A("views");return a}function je(o,e){return typeof o!="string"||o.length>2*e||cr.test(o)?!1:o.length<=e||[...o].length<=e}function hr({colors:o,lobes:e,network:t,cuts:s,scalars:n,lodSizes:r}){let i=["positions"];for(let[c,{count:l}]of s)for(let f=0;f<l;f++)i.push(`${c}.${f}`);for(let[c,{columns:l}]of n)i.push(...l.map((f,h)=>`${c}.${h}`));n.size&&i.push("rotation-finer");let a=r.flatMap((c,l)=>i.map(f=>l?`${f}@${l}`:f));return a.push(Nt[o]),e&&a.push("lobe-decoder"),t&&a.push("view-network"),s.size&&a.push("codebooks"),new Set(a)}function dr(o,e){let t=_e(o,"layers").map(n=>L({layers:n},"layers",1,e)),s=t.reduce((n,r)=>n+r,0);if(t.length>Jo||s!==e)throw A("layers");return t}function ur(o){if(o.lobes===null)return null;let e=C(o,"lobes"),t=_e(e,"hidden");if(t.length>rr)throw A("lobes.hidden");return{degree:L(e,"degree",0,3),latents:L(e,"latents",0,Pt),hidden:t.map(s=>L({hidden:s},"hidden",1,or))}}function pr(o,e){let t=new Map;for(let[n,r]of lr){if(n==="opacity"&&!Object.hasOwn(o,n)&&e!==null)continue;let i=C(o,n),a=r.find(([c,l])=>i.count===c&&i.length===l);if(!a)throw A(`codebooks.${n}`);t.set(n,{count:a[0],length:a[1],size:L(i,"size",1,Dt)})}let s=0;if(Object.hasOwn(o,"lobes")){let n=C(o,"lobes"),r=L(n,"count",1,Pt),i=L(n,"length",1,Pt);t.set("lobes",{count:r,length:i,size:L(n,"size",1,Dt)}),s=r*i}if(s!==(e===null?0:e.latents))throw A("codebooks.lobes");return t}function mr(o,e,t){let s=new Map,n=e?.latents??0;if(Object.hasOwn(o,"lobes")&&!n)throw A("scalars.lobes");for(let[r,i]of[...fr,["lobes",n]]){if(r==="opacity"&&!Object.hasOwn(o,r)&&e!==null||i===0)continue;let c=C(o,r),[l,f,h]=["least","size","middle"].map(v=>_e(c,v)),[d,p]=r==="appearance"&&t?nn:[i,i],u=l.length;if(u<d||u>p||f.length!==u||h.length!==u)throw A(`scalars.${r}`);let m=Math.fround(j(c,"step"));if(!(m>=er&&m<=tr))throw A(`scalars.${r}.step`);let w=l.map((v,_)=>{let E={least:l[_],size:f[_],middle:h[_]},b=L(E,"least",-Ct,Ct),k=L(E,"size",1,Dt),S=L({size:b+k-1},"size",b,Ct);if(r==="scale"&&S*m>sr)throw A("scalars.scale");let z=Math.max(-b,S)+.5;if(r==="rotation"&&z*m>nr)throw A("scalars.rotation");return{least:b,size:k,middle:L(E,"middle",b,S)}});s.set(r,{step:m,columns:w})}return s}function wr(o){let e=Xe(o,"center",3),t=Math.fround(j(o,"radius"));if(e.some(s=>Math.abs(s)>Math.fround(Ve)))throw A("positions.center");if(t<ar||t>Ve)throw A("positions.radius");return{center:e,radius:t,exponent:L(o,"exponent",0,14)}}function gr(o){let{name:e}=o;if(typeof e!="string")throw A("name");if(!sn.includes(e))throw new y(`the .mgs file has the weighting '${an(e)}': known are ${sn.join(", ")}`);let t={name:e,exponent_max:j(o,"exponent_max"),sigma:j(o,"sigma"),background_weight:j(o,"background_weight"),alpha_min:o.alpha_min===void 0?1/255:j(o,"alpha_min")};if(!(t.exponent_max>0&&t.exponent_max<=80))throw A("exponent_max");if(!(t.sigma>0&&t.sigma<=Ve))throw A("sigma");if(t.background_weight<0)throw A("background_weight");if(!(t.alpha_min>=1e-4&&t.alpha_min<=.1))throw A("alpha_min");return t}function br(o){let{antialiased:e,soft_edge:t}=o;if(typeof e!="boolean")throw A("footprint.antialiased");if(typeof t!="boolean")throw A("footprint.soft_edge");let s=j(o,"blur");if(!(s>0&&s<=4))throw A("footprint.blur");return{blur:s,antialiased:e,soft_edge:t}}function vr(o){let e=C({views:o},"views"),t=Xe(e,"viewmat",16),s=Xe(e,"K",9);if(![0,0,0,1].every((i,a)=>t[12+a]===i)||![0,0,1].every((i,a)=>s[6+a]===i)||s[0]<=0||s[4]<=0)throw new y("a view's matrices in the .mgs file are not those of a camera");let r=L(e,"width",1,Js);return{viewmat:t,K:s,width:r,height:L(e,"height",1,Js)}}function xr(o){let e=Object.entries(o);if(e.length>en)throw new y(`the .mgs file has ${e.length} notes: ${en} are allowed`);for(let[t,s]of e){let n=s===null||typeof s=="boolean"||je(s,tn),r=typeof s=="number"&&Math.abs(s)<=2**53;if(!(n||r)||!je(t,tn))throw new y(`the note '${t.slice(0,40)}' is not a short text or a number`)}return o}function C(o,e){let t=o[e];if(typeof t!="object"||t===null||Array.isArray(t))throw A(e);return t}function _e(o,e){let t=o[e];if(!Array.isArray(t))throw A(e);return t}function L(o,e,t,s){let n=j(o,e);if(!Number.isInteger(n)||n<t||n>s)throw A(e);return n}function j(o,e){return rn(o[e],e)}function Xe(o,e,t){let s=_e(o,e);if(s.length!==t)throw A(e);return Float32Array.from(s,n=>rn(n,e))}function rn(o,e){if(typeof o!="number"||!(Math.abs(o)<=3e38))throw A(e);return o}function an(o){return typeof o!="object"||o===null?String(o).slice(0,40):Array.isArray(o)?"a list":"an object"}function A(o){return new y(`the field '${o}' in the header of the .mgs file is missing or invalid`)}var ke=288,Ye=2**-6,cn=.3;function Ae(o,e){let{fx:t,fy:s,cx:n,cy:r,width:i,height:a}=o;return{...o,fx:e*t,fy:e*s,cx:e*n,cy:e*r,width:e*i,height:e*a}}function Qe(o,e,t,s,n){let{viewmat:r,fx:i,fy:a,cx:c,cy:l,width:f,height:h,near:d}=e,{background:p,weighting:u,packing:m,footprint:w=Ke}=o,v=cn*.5*f/i,_=cn*.5*h/a,E=[0,1,2].map(R=>-(r[R]*r[3]+r[4+R]*r[7]+r[8+R]*r[11])),b=new Float32Array(ke/4);b.set([...Array.from(r).slice(0,12),...E,d,i,a,c,l,-c/i-v,(f-c)/i+v,-l/a-_,(h-l)/a+_,...p,u.exponentMax,f,h,u.sigma,u.backgroundWeight,t]);let k=[o.count,o.shSize,o.lobeSize,u.index];if(new Int32Array(b.buffer).set(k,33),m){let{center:R,unit:$,leastScaleBits:Q,scaleBitsSpan:Mo}=m;b.set([...R,$,Q,Mo],40)}b[46]=!o.sorted&&u.alphaMin||1/255,b[47]=w.blur,new Int32Array(b.buffer).set([Number(w.antialiased),Number(w.soft_edge&&!o.sorted)],48),b[50]=s,new Int32Array(b.buffer)[51]=n;let S=Z(f,h),{places:z,size:K}=V(f,h),Y=z.flatMap(([R,$],Q)=>[R,$,R+S[Q][0],$+S[Q][1]]);return b.set([...Y,...K],52),b}var Ze=class{milliseconds=null;#e;#t;#o=!1;#n=!1;#s=[];constructor(e){this.#e=e,this.#t=e.getExtension("EXT_disjoint_timer_query_webgl2")}start(){this.#n=this.#o&&!this.#s.length}pass(e){if(!this.#n)return;let[t,s]=[this.#e,this.#t.TIME_ELAPSED_EXT];if(this.#s.length&&t.endQuery(s),e){let n=t.createQuery();this.#s.push([e,n]),t.beginQuery(s,n)}else this.#n=!1}async time(){let e=this.#e;this.#o=this.#t!==null;let t=this.#s[this.#s.length-1];if(!t||this.#n)return;for(let n=0;n<100&&!e.getQueryParameter(t[1],e.QUERY_RESULT_AVAILABLE);n++)await new Promise(r=>setTimeout(r,5));let s=this.#s.map(([n,r])=>[n,e.getQueryParameter(r,e.QUERY_RESULT)/1e6]);e.getParameter(this.#t.GPU_DISJOINT_EXT)||(this.milliseconds=Object.fromEntries(s));for(let[,n]of this.#s.splice(0))e.deleteQuery(n)}forget(){this.#s=[],this.#n=!1}};function Je({color:o,side:e},{viewmat:t,fx:s,fy:n,cx:r,cy:i,width:a,height:c,near:l}){let[f,h,d]=[0,4,8].map(p=>Array.from(t).slice(p,p+4));return Float32Array.of(...f.map((p,u)=>2*(s*p+r*d[u])/a-d[u]),...h.map((p,u)=>d[u]-2*(n*p+i*d[u])/c),...d,...o,l,n*e/2,.002*c/2,2/a,2/c)}function et({means:o}){let e=new Float32Array(6*o.length);for(let t=0,s=0;t<o.length;t+=3)for(let n=s+18;s<n;s+=3)e[s]=o[t],e[s+1]=o[t+1],e[s+2]=o[t+2];return e}var pe=["shapes","colors","lobes","looks","opacities","order","color_sums","weight_sums","color_sums_1","weight_sums_1","color_sums_2","weight_sums_2"],tt=class{#e;#t=new Map;constructor(e){this.#e=e}make(e,t,[s,n]){let r=this.#e;r.deleteTexture(this.#t.get(e)??null);let i=r.createTexture();return this.#t.set(e,i),r.activeTexture(r.TEXTURE0+pe.indexOf(e)),r.bindTexture(r.TEXTURE_2D,i),r.texStorage2D(r.TEXTURE_2D,1,t,s,n),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MIN_FILTER,r.NEAREST),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MAG_FILTER,r.NEAREST),i}upload(e,t,s){let n=this.#e,[r,,i]=t,a=st(s.length/i);if(a[1]>n.getParameter(n.MAX_TEXTURE_SIZE))throw new Error("the scene has more Gaussians than this GPU's textures can hold");this.make(e,n[r],a),this.write(e,t,0,s)}write(e,[,t,s],n,r){let i=this.#e,a=r instanceof Float32Array?i.FLOAT:i.UNSIGNED_INT,c=r.length/s;i.activeTexture(i.TEXTURE0+pe.indexOf(e));for(let l=0;l<c;){let[f,h]=[(n+l)%4096,Math.floor((n+l)/4096)],d=Math.min(4096-f,c-l),p=d===4096?Math.floor((c-l)/4096):1,u=l*s;i.texSubImage2D(i.TEXTURE_2D,0,f,h,d,p,i[t],a,r,u),l+=d*p}}destroy(){for(let e of this.#t.values())this.#e.deleteTexture(e)}};function st(o){return[Math.max(1,Math.min(o,4096)),Math.max(1,Math.ceil(o/4096))]}var nt=128,ln=0,Bt=["EXT_color_buffer_float","EXT_color_buffer_half_float"];function $t(o){return["EXT_color_buffer_float","EXT_float_blend"].every(e=>o.getExtension(e))}function Gt(o){for(let r of[...Bt,"EXT_float_blend"])o.getExtension(r);let e=o.getExtension("WEBGL_provoking_vertex");e?.provokingVertexWEBGL(e.FIRST_VERTEX_CONVENTION_WEBGL),o.disable(o.DITHER);let t={view:o.createBuffer(),corners:o.createBuffer(),quads:o.createVertexArray(),looks:o.createFramebuffer(),sums:o.createFramebuffer(),enlarged:[o.createFramebuffer(),o.createFramebuffer()],programs:new Map,textures:new tt(o)};o.bindBufferBase(o.UNIFORM_BUFFER,ln,t.view),o.bufferData(o.UNIFORM_BUFFER,ke,o.DYNAMIC_DRAW),o.bindVertexArray(t.quads),o.bindBuffer(o.ELEMENT_ARRAY_BUFFER,t.corners);let s=[0,1,2,2,1,3],n=Array.from({length:nt},(r,i)=>s.map(a=>4*i+a));return o.bufferData(o.ELEMENT_ARRAY_BUFFER,Uint16Array.from(n.flat()),o.STATIC_DRAW),t}function fn(o,e,{sorted:t,packed:s,strips:n,leveled:r}){let{view:i,whole:a,project:c,splat:l,resolve:f}=e,h=s?e.packed:e.wide,p=Object.entries({SORTED:t,STRIPS:n,LEVELED:r}).map(([m,w])=>w?`#define ${m}
`:"").join(""),u=(m,w)=>{let v=qt(o,`${p}#define VERTEX
${i}${m}`,`${p}${i}${w}`);return o.useProgram(v),pe.forEach((_,E)=>o.uniform1i(o.getUniformLocation(v,_),E)),o.uniformBlockBinding(v,o.getUniformBlockIndex(v,"View"),ln),v};return{project:u(a,`${h}${c}`),splat:u(`${h}${l}`,l),resolve:u(a,f),...r?{enlarge:u(a,`#define ENLARGE
${f}`)}:{}}}function qt(o,e,t){let s=o.createProgram();for(let[n,r]of[[o.VERTEX_SHADER,e],[o.FRAGMENT_SHADER,t]]){let i=o.createShader(n);o.shaderSource(i,`#version 300 es
${r}`),o.compileShader(i),o.attachShader(s,i),o.deleteShader(i)}if(o.linkProgram(s),!o.getProgramParameter(s,o.LINK_STATUS)&&!o.isContextLost()){let n=(o.getAttachedShaders(s)??[]).map(r=>o.getShaderInfoLog(r));throw n.push(o.getProgramInfoLog(s)),new Error(`this GPU refuses a shader: ${n.join(" ")}`)}return s}var ot=class{#e;#t=null;#o;#n;#s;#r=0;constructor(e,t){this.#e=e,this.#o=qt(e,`#define VERTEX
${t}`,t),this.#n=e.createVertexArray(),this.#s=e.createBuffer(),e.bindVertexArray(this.#n),e.bindBuffer(e.ARRAY_BUFFER,this.#s),e.enableVertexAttribArray(0),e.vertexAttribPointer(0,3,e.FLOAT,!1,0,0)}take(e){let[t,s]=[this.#e,e?et(e):new Float32Array(0)];this.#t=e,this.#r=s.length/3,t.bindBuffer(t.ARRAY_BUFFER,this.#s),t.bufferData(t.ARRAY_BUFFER,s,t.STATIC_DRAW)}draw(e){let[t,s]=[this.#e,this.#t];s&&(t.bindFramebuffer(t.FRAMEBUFFER,null),t.viewport(0,0,e.width,e.height),t.disable(t.BLEND),t.clearBufferfv(t.COLOR,0,[...s.background,1]),t.useProgram(this.#o),t.uniform4fv(t.getUniformLocation(this.#o,"dots"),Je(s,e)),t.bindVertexArray(this.#n),t.drawArrays(t.TRIANGLES,0,this.#r))}destroy(){let e=this.#e;e.deleteProgram(this.#o),e.deleteVertexArray(this.#n),e.deleteBuffer(this.#s)}};var Ht=new Float32Array(0),dn={shapes:["RGBA32UI","RGBA_INTEGER",4],colors:["RGBA32UI","RGBA_INTEGER",4],lobes:["R32UI","RED_INTEGER",1]},pn={shapes:["RGBA32F","RGBA",4],colors:["RGB32F","RGB",3],lobes:["RG32F","RG",2]},yr={...pn,colors:["RGB16F","RGB",3],lobes:["RG16F","RG",2]},un=["R32UI","RED_INTEGER",1],Se=class o{static files=["view","wide","packed","whole","project","splat","resolve","dots"].map(e=>`${e}.glsl`);variant;levelSigma=0;supersampling=1;lost=null;onLost=()=>{};onRestored=()=>{};#e;#t;#o;#n=null;#s=dn;#r=null;#i="";#a;#c=e=>{e.preventDefault(),this.#n=this.#r=null,this.lost="the browser took the GPU away from this page: reload it if no picture returns",this.onLost(this.lost)};#l=()=>{this.#n=null,this.#o=Gt(this.#e),this.#i="",this.#a.forget(),this.lost=null,this.onRestored()};static create(e,t,{floats:s=!1,strips:n=!1}={}){let r=e.getContext("webgl2",{alpha:!1,antialias:!1,depth:!1,powerPreference:"high-performance"});if(r===null)throw new Error("this browser cannot draw with WebGL2 here");if(!Bt.some(i=>r.getExtension(i)))throw new Error("this GPU cannot draw into textures of floats");if(s&&!$t(r))throw new Error("this GPU cannot blend 32-bit floats: use the variant halves");if(r.getParameter(r.MAX_TEXTURE_SIZE)<4096)throw new Error(`this GPU's textures are less than ${4096} pixels wide`);return new o(r,t,{floats:s,strips:n})}constructor(e,t,s){this.#e=e,this.#t=t,this.variant=s,this.#o=Gt(e),this.#a=new Ze(e),e.canvas.addEventListener("webglcontextlost",this.#c),e.canvas.addEventListener("webglcontextrestored",this.#l)}setScene(e){let t=this.#e;if(this.#n=null,e.network)throw new Error("this scene needs a network for every Gaussian in every frame, which takes WebGPU: open it in a browser that has it");this.#s=e.packing?dn:this.variant.floats?pn:yr;let{shapes:s,colors:n,lobes:r}=e;for(let[a,c]of Object.entries({shapes:s,colors:n,lobes:r}))this.#o.textures.upload(a,this.#s[a],c);t.bindFramebuffer(t.FRAMEBUFFER,this.#o.looks);let i=e.packing?[t.RG32UI,0]:[t.RGBA32F,t.R32F];["looks","opacities"].forEach((a,c)=>{let l=i[c]?this.#o.textures.make(a,i[c],st(e.count)):null;t.framebufferTexture2D(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0+c,t.TEXTURE_2D,l,0)}),this.#v("textures of 32-bit numbers"),this.#n={...e,shapes:Ht,colors:Ht,lobes:Ht},e.sorted&&this.#o.textures.upload("order",un,Uint32Array.from({length:e.count},(a,c)=>c))}show(e){this.#n&&(this.#n.count=e)}update(e,t,s){if(this.#n===null)return;let n=this.#s[e];this.#o.textures.write(e,n,he(this.#n)[e]/n[2]*t,s)}setDots(e){this.lost===null&&(this.#r??=new ot(this.#e,this.#t.dots),this.#r.take(e))}drawDots(e){this.#r&&(this.#f(e),this.#r.draw(e))}setOrder(e){if(this.#n!==null){if(e.length!==this.#n.count)throw new Error(`an order of ${e.length} Gaussians does not fit this scene`);this.#o.textures.write("order",un,0,e)}}draw(e){this.#n!==null&&(this.#f(e),this.#a.start(),this.#d(this.#n,e),this.#u(this.#n,e,null,e.height-1),this.#a.pass())}async drawUnseen(e){let t=this.#e;if(this.#n&&this.#d(this.#n,e),t.readBuffer(t.COLOR_ATTACHMENT0),t.readPixels(0,0,1,1,t.RGBA,t.FLOAT,new Float32Array(4)),t.isContextLost())throw new Error("the graphics device was lost")}get milliseconds(){return this.#a.milliseconds}async time(){this.lost===null&&await this.#a.time()}async finished(){this.#e.bindFramebuffer(this.#e.FRAMEBUFFER,null),this.#e.readPixels(0,0,1,1,this.#e.RGBA,this.#e.UNSIGNED_BYTE,new Uint8Array(4))}get variants(){return($t(this.#e)?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}describe(){let e=this.#e,t=e.getExtension("WEBGL_debug_renderer_info");return String(e.getParameter(t?t.UNMASKED_RENDERER_WEBGL:e.RENDERER))}async pixels(e){if(this.#n===null)throw new Error("there is no scene to draw");let t=this.#e,{width:s,height:n}=e;this.#d(this.#n,e);let[r,i]=[t.createFramebuffer(),t.createRenderbuffer()];t.bindFramebuffer(t.FRAMEBUFFER,r),t.bindRenderbuffer(t.RENDERBUFFER,i),t.renderbufferStorage(t.RENDERBUFFER,t.RGBA32F,s,n),t.framebufferRenderbuffer(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0,t.RENDERBUFFER,i),this.#u(this.#n,e,r,0);let a=new Float32Array(4*s*n);return t.readPixels(0,0,s,n,t.RGBA,t.FLOAT,a),t.deleteFramebuffer(r),t.deleteRenderbuffer(i),a}destroy(){let e=this.#e,{view:t,corners:s,quads:n,looks:r,sums:i,enlarged:a,programs:c,textures:l}=this.#o;this.#n=null,this.#r?.destroy(),e.canvas.removeEventListener("webglcontextlost",this.#c),e.canvas.removeEventListener("webglcontextrestored",this.#l),l.destroy();for(let f of c.values())for(let h of Object.values(f))e.deleteProgram(h);for(let f of[r,i,...a])e.deleteFramebuffer(f);e.deleteVertexArray(n);for(let f of[t,s])e.deleteBuffer(f);e.getExtension("WEBGL_lose_context")?.loseContext()}#f({width:e,height:t}){let{canvas:s}=this.#e;s.width!==e&&(s.width=e),s.height!==t&&(s.height=t)}#d(e,t){let s=this.#e;t=Ae(t,this.supersampling);let{view:n,quads:r,looks:i,sums:a}=this.#o,c=this.#b(e,t),l=this.#g(e,c),[f,h]=this.#w(e.sorted,c,t);s.bindBuffer(s.UNIFORM_BUFFER,n);let d=this.variant.floats?1:Ye,p=Qe(e,t,d,this.levelSigma,this.supersampling);s.bufferSubData(s.UNIFORM_BUFFER,0,p),s.bindVertexArray(r),s.disable(s.BLEND),s.bindFramebuffer(s.FRAMEBUFFER,i),s.drawBuffers([s.COLOR_ATTACHMENT0,e.packing?s.NONE:s.COLOR_ATTACHMENT1]);let[u,m]=st(e.count);if(s.viewport(0,0,u,m),s.useProgram(l.project),this.#a.pass("project"),s.drawArrays(s.TRIANGLES,0,3),s.bindFramebuffer(s.FRAMEBUFFER,a),s.viewport(0,0,f,h),s.enable(s.BLEND),s.useProgram(l.splat),this.#a.pass("splat"),e.sorted?(s.drawBuffers([s.COLOR_ATTACHMENT0]),s.clearBufferfv(s.COLOR,0,[0,0,0,0]),s.blendFunc(s.ONE,s.ONE_MINUS_SRC_ALPHA)):(s.drawBuffers([s.COLOR_ATTACHMENT0,s.COLOR_ATTACHMENT1]),s.clearBufferfv(s.COLOR,0,[0,0,0,1]),s.clearBufferfv(s.COLOR,1,[0,0,0,0]),s.blendFuncSeparate(s.ONE,s.ONE,s.ZERO,s.ONE_MINUS_SRC_ALPHA)),this.variant.strips)s.drawArraysInstanced(s.TRIANGLE_STRIP,0,4,e.count);else{let w=Math.ceil(e.count/nt);s.drawElementsInstanced(s.TRIANGLES,6*nt,s.UNSIGNED_SHORT,0,w)}}#u(e,t,s,n){let r=this.#e,i=Ae(t,this.supersampling),{resolve:a,enlarge:c}=this.#g(e,this.#b(e,i));r.disable(r.BLEND),this.#a.pass("resolve"),c&&this.#h(c,a,i),r.bindFramebuffer(r.FRAMEBUFFER,s),r.viewport(0,0,t.width,t.height),r.useProgram(a),r.uniform1i(r.getUniformLocation(a,"last_row"),n),r.drawArrays(r.TRIANGLES,0,3)}#h(e,t,{width:s,height:n}){let r=this.#e,{places:i}=V(s,n),a=Z(s,n),c=(l,f,h)=>{r.useProgram(l);for(let d of["color","weight"]){let p=pe.indexOf(`${d}_sums${f}`);r.uniform1i(r.getUniformLocation(l,`coarse_${d}s`),p)}r.uniform2i(r.getUniformLocation(l,"coarse_from"),h[0],h[1])};for(let l of[2,1])r.bindFramebuffer(r.FRAMEBUFFER,this.#o.enlarged[l-1]),r.viewport(0,0,a[l][0],a[l][1]),l===2?c(e,"",i[3]):c(e,"_2",[0,0]),r.uniform2i(r.getUniformLocation(e,"from"),i[l][0],i[l][1]),r.drawArrays(r.TRIANGLES,0,3);c(t,"_1",[0,0])}#b({sorted:e},{width:t,height:s}){let n=this.#e.getParameter(this.#e.MAX_TEXTURE_SIZE);return this.levelSigma>0&&!e&&Math.max(...V(t,s).size)<=n}#w(e,t,{width:s,height:n}){let{floats:r}=this.variant,i=t?V(s,n).size:[s,n],a=`${s} ${n} ${e} ${t} ${r}`;if(a===this.#i)return i;let c=this.#e,l=c.getParameter(c.MAX_TEXTURE_SIZE);if(!(s>0&&s<=l&&n>0&&n<=l))throw new Error(`an image of ${s}x${n} pixels cannot be rendered: each side must lie between 1 and ${l}`);let f=r?[c.RGBA32F,c.R32F]:[c.RGBA16F,c.R16F],{sums:h,enlarged:d,textures:p}=this.#o,u=Z(s,n);return[h,...d].forEach((m,w)=>{let v=w?`_${w}`:"";c.bindFramebuffer(c.FRAMEBUFFER,m),["color_sums","weight_sums"].forEach((_,E)=>{let b=(w===0||t)&&!(e&&E>0),k=w===0?i:u[w],S=b?p.make(`${_}${v}`,f[E],k):null;c.framebufferTexture2D(c.FRAMEBUFFER,c.COLOR_ATTACHMENT0+E,c.TEXTURE_2D,S,0)}),w&&t&&c.drawBuffers([c.COLOR_ATTACHMENT0,c.COLOR_ATTACHMENT1]),(w===0||t)&&this.#v(`pictures of ${s}x${n} floats`)}),this.#i=a,i}#g({sorted:e,packing:t},s){let{programs:n}=this.#o,r={sorted:e,packed:t!==null,strips:this.variant.strips,leveled:s},i=Object.values(r).join(" "),a=n.get(i)??fn(this.#e,this.#t,r);return n.set(i,a),a}#v(e){let t=this.#e;if(t.checkFramebufferStatus(t.FRAMEBUFFER)!==t.FRAMEBUFFER_COMPLETE&&!t.isContextLost())throw new Error(`this GPU cannot draw into ${e}`)}};var rt=class{#e;#t;#o;#n;#s;#r;constructor(e,t,s){let{device:n}=e;this.#e=n,this.#t=t,this.#o=e.dots(s);let{UNIFORM:r,VERTEX:i,COPY_DST:a}=GPUBufferUsage;this.#n=n.createBuffer({size:80,usage:r|a});let c=et(t);this.#r=c.length/3,this.#s=e.filled(c,i)}draw(e,t){let[s,n,r]=[this.#e,this.#o,this.#t];s.queue.writeBuffer(this.#n,0,Je(r,e));let i=s.createCommandEncoder(),a=i.beginRenderPass({colorAttachments:[{view:t,loadOp:"clear",storeOp:"store",clearValue:[...r.background,1]}]}),c=[{binding:0,resource:{buffer:this.#n}}];a.setPipeline(n),a.setBindGroup(0,s.createBindGroup({layout:n.getBindGroupLayout(0),entries:c})),a.setVertexBuffer(0,this.#s),a.draw(this.#r),a.end(),s.queue.submit([i.finish()])}destroy(){this.#n.destroy(),this.#s.destroy()}};var oe=128,mn={srcFactor:"one",dstFactor:"one-minus-src-alpha",operation:"add"},_r={color:mn,alpha:mn},kr={color:{srcFactor:"one",dstFactor:"one",operation:"add"},alpha:{srcFactor:"zero",dstFactor:"one-minus-src-alpha",operation:"add"}},wn=["float32-blendable","float32-filterable"],Te=["network","project","splat","resolve"],it=class o{milliseconds=null;#e;#t=new Map;#o=new Map;#n=null;static async create(e,t){if(!("gpu"in navigator))throw new Error("this browser has no WebGPU on this page: it may need https, or a newer version");let s=await Ts();if(s===null)throw new Error("WebGPU finds no graphics adapter on this device");let r=["timestamp-query","float32-blendable","float32-filterable","shader-f16"].filter(l=>s.features.has(l));if(t&&!wn.every(l=>r.includes(l)))throw new Error("this device cannot blend and filter 32-bit floats");let{maxStorageBufferBindingSize:i,maxBufferSize:a}=s.limits,c=await s.requestDevice({requiredFeatures:r,requiredLimits:{maxStorageBufferBindingSize:i,maxBufferSize:a}});return new o(c,e)}constructor(e,t){if(this.device=e,this.#e=t,this.bilinear=e.createSampler({magFilter:"linear",minFilter:"linear"}),e.features.has("timestamp-query")){let s=16*Te.length,n=GPUBufferUsage;this.#n={queries:e.createQuerySet({type:"timestamp",count:2*Te.length}),found:e.createBuffer({size:s,usage:n.QUERY_RESOLVE|n.COPY_SRC}),read:e.createBuffer({size:s,usage:n.MAP_READ|n.COPY_DST})}}}get blendsFloats(){return wn.every(e=>this.device.features.has(e))}get number(){return this.device.features.has("shader-f16")?"f16":"f32"}network(e){return this.#s(`network ${e.packed}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#r("network",e),entryPoint:"evaluate_network"}}))}project(e,{strips:t}){return this.#s(`project ${e.packed} ${e.sorted} ${t}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#r("project",e),entryPoint:e.sorted?"project_sorted":"project_sortfree",constants:{STRIPS:Number(t)}}}))}splat(e,{floats:t,strips:s},n){return this.#s(`splat ${e.packed} ${e.sorted} ${s} ${t} ${n}`,()=>{let r=e.sorted?_r:kr,i=this.#r("splat",e);return this.device.createRenderPipeline({layout:"auto",vertex:{module:i,entryPoint:e.sorted?"corner_sorted":n?"corner_of_level":"corner_sortfree",constants:{STRIPS:Number(s)}},primitive:{topology:s?"triangle-strip":"triangle-list"},fragment:{module:i,entryPoint:e.sorted?"cover":n?"add_to_level":"add_weighted",targets:at(e.sorted,t).map(a=>({format:a,blend:r}))}})})}enlarge(e,t){return this.#s(`enlarge ${e} ${t}`,()=>{let s=this.#r("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:s,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:s,entryPoint:"add_enlarged",constants:{LEVEL:e},targets:at(!1,t).map(n=>({format:n}))}})})}resolve(e,t,s){return this.#s(`resolve ${e} ${s} ${t}`,()=>{let n=this.#r("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:n,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:n,entryPoint:e?"resolve_sorted":s?"resolve_levels":"resolve_sortfree",targets:[{format:t}]}})})}dots(e){return this.#s(`dots ${e}`,()=>{let t=this.device.createShaderModule({code:this.#e.dots,label:"dots"}),s=[{shaderLocation:0,offset:0,format:"float32x3"}];return this.device.createRenderPipeline({layout:"auto",vertex:{module:t,entryPoint:"corner_of_dot",buffers:[{arrayStride:12,attributes:s}]},fragment:{module:t,entryPoint:"paint_dot",targets:[{format:e}]}})})}filled(e,t){let s=Math.ceil(e.byteLength/4)*4,n=this.device.createBuffer({size:s,usage:t,mappedAtCreation:!0}),r=new Uint8Array(e.buffer,e.byteOffset,e.byteLength);return new Uint8Array(n.getMappedRange()).set(r),n.unmap(),n}bind(e,t){return this.device.createBindGroup({layout:e.getBindGroupLayout(0),entries:Object.entries(t).map(([s,n])=>({binding:Number(s),resource:n instanceof GPUBuffer?{buffer:n}:n}))})}stamps(e,t=!0,s=!0){if(this.#n===null||!(t||s))return;let n=2*Te.indexOf(e);return{querySet:this.#n.queries,...t?{beginningOfPassWriteIndex:n}:{},...s?{endOfPassWriteIndex:n+1}:{}}}async time({network:e}){if(this.#n===null||this.#n.read.mapState!=="unmapped")return;let{queries:t,found:s,read:n}=this.#n,r=this.device.createCommandEncoder();r.resolveQuerySet(t,0,2*Te.length,s,0),r.copyBufferToBuffer(s,0,n,0,n.size),this.device.queue.submit([r.finish()]),await n.mapAsync(GPUMapMode.READ);let i=new BigUint64Array(n.getMappedRange()),a=Te.map((c,l)=>[c,Number(i[2*l+1]-i[2*l])/1e6]);this.milliseconds=Object.fromEntries(e?a:a.slice(1)),n.unmap()}#s(e,t){let s=this.#o.get(e)??t();return this.#o.set(e,s),s}#r(e,t){let s=t===null?"":this.#e[t.packed?"packed":"wide"],n=`${e} ${t?.packed}`,r=this.number==="f16"?`enable f16;
`:"",a=`${e==="network"?`${r}alias Num = ${this.number};
`:""}${this.#e.view}
${s}
${this.#e[e]}`,c=this.#t.get(n)??this.device.createShaderModule({code:a,label:e});return this.#t.set(n,c),c}};function Wt(o,e){return Object.fromEntries(o.map((t,s)=>[e+s,t]))}function at(o,e){return e?o?["rgba32float"]:["rgba32float","r32float"]:o?["rgba16float"]:["rgba16float","r16float"]}var Sr=6,Tr={packed:8,wide:32},Vt=new Float32Array(0),Me=class o{static files=["view","wide","packed","network","project","splat","resolve","dots"].map(e=>`${e}.wgsl`);variant;levelSigma=0;supersampling=1;lost=null;onLost=()=>{};#e;#t;#o;#n;#s;#r=null;#i=null;#a=null;#c=null;#l;#f;#d;static async create(e,t,{floats:s=!1,strips:n=!1}={}){let r=await it.create(t,s);return new o(r,e,{floats:s,strips:n})}constructor(e,t,s){let n=t.getContext("webgpu");if(n===null)throw new Error("this canvas is already drawn to in another way");let{device:r}=e;this.variant=s,this.#e=e,this.#t=r,this.#n=t,this.#o=n,this.#s=navigator.gpu.getPreferredCanvasFormat(),n.configure({device:r,format:this.#s,alphaMode:"opaque"});let i=GPUBufferUsage;this.#l=r.createBuffer({size:ke,usage:i.UNIFORM|i.COPY_DST});let a=i.STORAGE|i.INDIRECT|i.COPY_DST;this.#f=r.createBuffer({size:4*Sr,usage:a});let c=new Uint16Array(6*oe);for(let l=0;l<oe;l++)c.set([0,1,2,2,1,3].map(f=>4*l+f),6*l);this.#d=e.filled(c,i.INDEX),r.lost.then(({reason:l})=>{l!=="destroyed"&&this.#u("the graphics device was lost: reload the page to go on")}),r.onuncapturederror=({error:l})=>this.#u(`this GPU cannot draw the scene: ${l.message}`)}get variants(){return(this.#e.blendsFloats?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}get milliseconds(){return this.#e.milliseconds}setScene(e){this.#h();let{count:t,sorted:s}=e,n={sorted:s,packed:e.packing!==null,network:!!e.network},r=Tr[n.packed?"packed":"wide"]*Math.max(t,1),i={shapes:e.shapes,colors:e.colors,lobes:e.lobes},a=Math.max(r,...Object.values(i).map(u=>u.byteLength)),{maxStorageBufferBindingSize:c,maxBufferSize:l}=this.#t.limits,f=Math.min(c,l);if(a>f)throw new Error(`${t} Gaussians need ${Math.ceil(a/2**20)} MiB at a stretch, and this device gives ${Math.floor(f/2**20)}`);let h=GPUBufferUsage,d=u=>this.#e.filled(u.length?u:new Uint32Array(16),h.STORAGE|h.COPY_DST),p=u=>this.#t.createBuffer({size:4*Math.max(1,u),usage:h.STORAGE|h.COPY_DST});this.#i={kind:n,parts:{shapes:d(i.shapes),colors:d(i.colors),lobes:d(i.lobes)},looks:this.#t.createBuffer({size:r,usage:h.STORAGE}),order:p(t),network:e.network?{weights:this.#e.filled(this.#p(e.network),h.STORAGE),lobes:p(t)}:null},this.#r={...e,shapes:Vt,colors:Vt,lobes:Vt},s&&this.setOrder(Uint32Array.from({length:t},(u,m)=>m))}show(e){this.#r&&(this.#r.count=e)}update(e,t,s){if(!this.#r||!this.#i||this.lost!==null)return;let n=4*he(this.#r)[e]*t;this.#t.queue.writeBuffer(this.#i.parts[e],n,s)}setDots(e){this.#a?.destroy(),this.#a=e&&new rt(this.#e,e,this.#s)}drawDots(e){this.lost===null&&this.#a?.draw(e,this.#w(e))}setOrder(e){this.#i?.kind.sorted&&this.#t.queue.writeBuffer(this.#i.order,0,e)}draw(e){this.lost===null&&this.#v(e,this.#w(e),this.#s)}async pixels(e){let{width:t,height:s}=e,n=Math.ceil(16*t/256)*256,r=this.#g(t,s,"rgba32float");this.#v(e,r.createView(),"rgba32float");let i=this.#t.createBuffer({size:n*s,usage:GPUBufferUsage.MAP_READ|GPUBufferUsage.COPY_DST}),a=this.#t.createCommandEncoder();a.copyTextureToBuffer({texture:r},{buffer:i,bytesPerRow:n},[t,s]),this.#t.queue.submit([a.finish()]),await i.mapAsync(GPUMapMode.READ);let c=new Float32Array(i.getMappedRange()),l=new Float32Array(4*t*s);for(let f=0;f<s;f++){let h=f*n/4;l.set(c.subarray(h,h+4*t),4*t*f)}return i.destroy(),r.destroy(),l}async drawUnseen(e){let t=this.#g(e.width,e.height,this.#s);if(this.#v(e,t.createView(),this.#s),await this.finished(),t.destroy(),this.lost!==null)throw new Error(this.lost)}async finished(){await this.#t.queue.onSubmittedWorkDone()}describe(){let e=this.#t.adapterInfo;return[e?.vendor,e?.architecture,e?.device,e?.description].filter(Boolean).join(" ")}async time(){this.lost===null&&this.#i&&await this.#e.time(this.#i.kind)}destroy(){this.#h(),this.setDots(null),this.#t.onuncapturederror=null,this.#t.destroy()}#u(e){this.lost===null&&(this.lost=e,this.onLost(e))}#h(){for(let e of this.#b())e.destroy();this.#i=this.#r=null}#b(){if(this.#i===null)return[];let{parts:e,looks:t,order:s,network:n}=this.#i;return[...Object.values(e),t,s,...Object.values(n??{})]}#w({width:e,height:t}){return this.#n.width!==e&&(this.#n.width=e),this.#n.height!==t&&(this.#n.height=t),this.#o.getCurrentTexture().createView()}#g(e,t,s){let n=GPUTextureUsage;return this.#t.createTexture({size:[e,t],format:s,usage:n.RENDER_ATTACHMENT|n.COPY_SRC})}#v(e,t,s){let n=this.#r;if(!n||!this.#i)return;let r=Ae(e,this.supersampling),{queue:i}=this.#t,{floats:a,strips:c}=this.variant,l=n.sorted?0:this.levelSigma,f=Qe(n,r,a?1:Ye,l,this.supersampling);i.writeBuffer(this.#l,0,f),i.writeBuffer(this.#f,0,Uint32Array.of(c?4:6*oe,0,0,0,0,0));let h=this.#t.limits.maxTextureDimension2D,d=l>0&&Math.max(...V(r.width,r.height).size)<=h,p=this.#A(r.width,r.height,n.sorted,d),u=this.#t.createCommandEncoder();this.#x(u,n.count,this.#i),this.#k(u,n.count,this.#i),this.#E(u,n.count,this.#i,p[0],d),d&&(this.#_(u,this.#e.enlarge(2,a),[...p[0],...p[0]],p[2],!0,!1),this.#_(u,this.#e.enlarge(1,a),[...p[0],...p[2]],p[1],!1,!1));let m=p.slice(0,2).flat();this.#_(u,this.#e.resolve(n.sorted,s,d),m,[t],!d,!0),i.submit([u.finish()])}#p(e){return this.#e.number==="f16"?Uint16Array.from(e,W):e}#x(e,t,{kind:s,parts:n,network:r}){if(r===null)return;let i={0:this.#l,1:n.shapes,4:n.lobes,5:r.weights,6:r.lobes};this.#y(e,"network",this.#e.network(s),i,Math.ceil(t/32))}#k(e,t,{kind:s,parts:n,looks:r,order:i,network:a}){let c=a?.lobes??n.lobes,l=[this.#l,n.shapes,n.colors,c,r];s.sorted||l.push(i,this.#f);let f=this.#e.project(s,this.variant);this.#y(e,"project",f,Wt(l,0),Math.ceil(t/oe))}#y(e,t,s,n,r){let i=Math.max(1,Math.min(r,65535)),a=e.beginComputePass({timestampWrites:this.#e.stamps(t)});a.setPipeline(s),a.setBindGroup(0,this.#e.bind(s,n)),a.dispatchWorkgroups(i,Math.ceil(r/i)),a.end()}#E(e,t,{kind:s,parts:n,looks:r,order:i},a,c){let l=[{r:0,g:0,b:0,a:s.sorted?0:1},{r:0,g:0,b:0,a:0}],f=this.#e.splat(s,this.variant,c),h=e.beginRenderPass({colorAttachments:a.map((p,u)=>({view:p,loadOp:"clear",storeOp:"store",clearValue:l[u]})),timestampWrites:this.#e.stamps("splat")});h.setPipeline(f);let d={0:this.#l,1:n.shapes,4:r,5:i};h.setBindGroup(0,this.#e.bind(f,s.sorted?d:{...d,6:this.#f})),h.setIndexBuffer(this.#d,"uint16"),this.variant.strips?s.sorted?h.draw(4,t):h.drawIndirect(this.#f,0):s.sorted?h.drawIndexed(6*oe,Math.ceil(t/oe)):h.drawIndexedIndirect(this.#f,0),h.end()}#_(e,t,s,n,r,i){let a=e.beginRenderPass({colorAttachments:n.map(l=>({view:l,loadOp:"clear",storeOp:"store"})),timestampWrites:this.#e.stamps("resolve",r,i)});a.setPipeline(t);let c={0:this.#l,...Wt(s,1)};s.length===4&&(c[5]=this.#e.bilinear),a.setBindGroup(0,this.#e.bind(t,c)),a.draw(3),a.end()}#A(e,t,s,n){let r=`${e} ${t} ${s} ${n} ${this.variant.floats}`;if(this.#c?.key===r)return this.#c.views;for(let f of this.#c?.textures??[])f.destroy();let i=GPUTextureUsage,a=[],l=(n?[V(e,t).size,...Z(e,t).slice(1,3)]:[[e,t]]).map(f=>at(s,this.variant.floats).map(h=>{let d=i.RENDER_ATTACHMENT|i.TEXTURE_BINDING,p=this.#t.createTexture({size:f,format:h,usage:d});return a.push(p),p.createView()}));return this.#c={key:r,textures:a,views:l},l}};async function ct(o,e){let t="";if(e!=="webgl")try{let s=await gn(Me.files);return{name:"WebGPU",renderer:await Me.create(o,s)}}catch(s){if(e==="webgpu")throw s;t=s instanceof Error?s.message:String(s)}try{return{name:"WebGL2",renderer:Se.create(o,await gn(Se.files))}}catch(s){let n=s instanceof Error?s.message:String(s);throw new Error(`this browser cannot draw the scene: ${t?`${t}; `:""}${n}`)}}async function gn(o){let e=o.map(async t=>[t.replace(/\.[a-z]+$/,""),await Ms(t)]);return Object.fromEntries(await Promise.all(e))}var bn=new Map;function vn(o){let e=bn.get(o)??Mr(o);return bn.set(o,e),e}async function Mr(o){let{renderer:e}=await ct(document.createElement("canvas"),o);try{return await Gs(e,jt())}finally{e.destroy()}}function jt(){try{return localStorage}catch{return null}}var T=(o,e,t=1)=>[o[0]+t*e[0],o[1]+t*e[1],o[2]+t*e[2]],D=(o,e)=>T(o,e,-1),O=(o,e)=>o[0]*e[0]+o[1]*e[1]+o[2]*e[2],X=(o,e)=>[o[1]*e[2]-o[2]*e[1],o[2]*e[0]-o[0]*e[2],o[0]*e[1]-o[1]*e[0]],me=o=>Math.hypot(...o);function J(o){let e=me(o);return e>0?[o[0]/e,o[1]/e,o[2]/e]:[1,0,0]}function Xt(o,e,t){let[s,n]=[Math.cos(t),Math.sin(t)],r=O(o,e)*(1-s),i=X(e,o);return T(T([o[0]*s,o[1]*s,o[2]*s],i,n),e,r)}var Rr=Math.cos(.5*Math.PI/180),lt=class{by="";#e=!1;#t=null;reset(e){this.by=e,this.#e=!1}invalidate(){this.#t=null}get pending(){return this.#e}received(){this.#e=!1}neededDirection({viewmat:e}){let t=[e[8],e[9],e[10]],s=this.#t!==null&&O(t,this.#t)>=Rr;return!this.by||this.#e||s?null:(this.#e=this.by==="worker",this.#t=t)}};var xn=12;function yn(o,e,t,s,n){let{viewmat:r,fx:i,fy:a,cx:c,cy:l,near:f}=t,h=-1,d=1/0;for(let p=0;3*p<o.length;p++){if(e[p]<0)continue;let[u,m,w]=[o[3*p],o[3*p+1],o[3*p+2]],v=r[8]*u+r[9]*m+r[10]*w+r[11];if(v<=f||v>=d)continue;let _=i*(r[0]*u+r[1]*m+r[2]*w+r[3])/v+c-s,E=a*(r[4]*u+r[5]*m+r[6]*w+r[7])/v+l-n;_*_+E*E>xn*xn||(d=v,h=p)}return h<0?null:[o[3*h],o[3*h+1],o[3*h+2]]}function Kt(o,e,t,s){let n=s instanceof Uint32Array;for(let r=0;r*e<s.length;r++)o[t+r]=n?js(s[r*e]):s[r*e]}var Lr=50,ft=class{count=0;views=[];near=.2;logits=new Float32Array(0);request=null;calibrated=Promise.resolve();name="";broken=!1;#e=new Float32Array(0);#t;#o;#n=!1;#s;#r;#i=null;#a=null;#c=null;#l=null;#f=Promise.resolve(!1);#d=!1;#u=null;#h=!1;#b=2;#w=[0,0,0];#g=null;#v=[0,0,0];#p=new lt;#x=null;#k=!1;#y=!1;#E=!1;constructor(e,t,s,n,r=0){this.canvas=e,this.#r=t,this.#t=s,this.#o=r,this.#s=n}begin(e){return this.#f=this.#_(e)}async#_(e){try{let{name:t,renderer:s}=await ct(this.canvas,e);if(this.#d)return s.destroy(),!1;s.onLost=i=>this.#M(i),"onRestored"in s&&(s.onRestored=()=>this.request&&this.load(this.request));let r=s.variants.find(({floats:i,strips:a})=>i===this.#t?.floats&&a===this.#t.strips)??$s(s,jt());return r&&(s.variant=r),s.levelSigma=this.#o,this.#n=r!==null,this.#i=s,this.name=t,Hs(s),!0}catch(t){return this.#r.failed(Yt(t)),!1}}async#A(){if(this.#n||this.broken)return;this.#n=!0;let e=this.name==="WebGPU"?"webgpu":"webgl",t=await vn(e);this.#i&&(this.#i.variant=t),this.#r.changed()}load(e,t=!1){this.#c?.terminate(),this.request=e;let s=Ss(e,async({data:n})=>{if(!await this.#f){s.terminate();return}(s===this.#c||s===this.#a)&&this.#U(n,s)});s.onerror=n=>{n.preventDefault(),!t&&s===this.#c?this.load(e,!0):this.#L("the viewer's own files could not be loaded: reload the page",s)},this.#c=this.#l=s}async sort(e){if(this.#p.by==="")return null;if(this.broken)throw new Error("the renderer was lost");this.#p.pending&&await this.#S();let t=performance.now();return this.#p.invalidate(),this.#z(e),this.#p.pending&&await this.#S(),performance.now()-t}#S(){return new Promise((e,t)=>this.#x={resolve:e,reject:t})}#T(e){this.#x?.reject(new Error(e)),this.#x=null}draw(e,t=1){if(this.#a===null)return;let s={...e,near:this.near};if(this.#y){this.#i?.drawDots(s),this.#m();return}this.#z(e),this.#i&&(this.#i.supersampling=t,this.#i.draw(s),this.#i.supersampling=1)}async#m(){let e=this.#i;this.#E||this.#s||!e||(this.#E=!0,await new Promise(t=>setTimeout(t,Lr)),this.#y&&!this.#d&&await qs(e).catch(()=>{}))}drawOrReport(e,t){if(!this.broken)try{this.draw(e,t)}catch(s){this.#M(Yt(s))}}async finished(){await this.#i?.finished()}pixels(e){return(this.#a&&!this.#y?this.#i?.pixels(e):null)??Promise.reject(new Error("nothing can be drawn"))}get background(){return this.#g??this.#w}set background(e){this.#g=e,this.background.forEach((t,s)=>this.#v[s]=t)}get means(){return this.#e=We(this.#e)}get milliseconds(){return this.#i?.milliseconds??null}async time(){this.#k||!this.#i||(this.#k=!0,await this.#i.time().catch(()=>{}),this.#k=!1)}get device(){let{floats:e,strips:t}=this.#i?.variant??{floats:!1,strips:!1},s=`${e?"floats":"halves"}, ${t?"strips":"batches"}`,{by:n}=this.#p,r=this.#i?.describe()??"";return{renderer:this.name,adapter:r,variant:s,sorted:n!=="",sorted_by:n||null}}destroy(){this.#d=this.broken=!0,this.#T("the renderer was lost"),this.#c?.terminate(),this.#a?.terminate(),this.#i?.destroy(),this.#i=null}#M(e){this.broken=!0,this.#T(e),this.#r.broken(e)}#U(e,t){this.broken&&t===this.#a||(e.kind==="failed"?this.#L(e.sentence,t):e.kind==="progress"?t===this.#l&&this.#r.progress(e.received/e.total):e.kind==="dots"?this.#I(e,t):e.kind==="scene"?this.#N(e,t):e.kind==="rows"?this.#C(e):e.kind==="more"?this.#R(e.means):e.kind==="order"?this.#D(e.order):(this.#p.by!=="worker"&&t.terminate(),this.#c||(this.calibrated=this.#A().catch(()=>{})),t===this.#l&&this.#r.loaded(e.milliseconds,e.bytes)))}#L(e,t){let s=t===this.#c&&this.#u!==null;t===this.#a&&this.#T(e),t===this.#c&&(this.#c=null,this.request=this.#u),(t!==this.#a||this.#p.by!=="worker")&&t.terminate(),t===this.#l&&this.#r.failed(e,s)}#I({dots:e,views:t,near:s},n){this.#p.reset(""),this.#O(n,e.background,()=>this.#i?.setDots(e))&&(this.#y=!0,this.#F(t,s),this.logits=new Float32Array(e.means.length/3),this.#R(e.means),this.#h||this.#r.arrived())}#N({data:e,means:t,views:s,near:n},r){let i=r===this.#a;this.#p.reset(e.sorted?"worker":this.#s?"page":""),e.sorted=this.#p.by!=="",this.#O(r,e.background,()=>{this.#i?.setDots(null),this.#i?.setScene(e)})&&(this.#y=!1,this.#F(s,n),this.logits=new Float32Array(e.count),this.#b=he(e).lobes,Kt(this.logits,this.#b,0,e.lobes),this.#R(t),!i&&!this.#h&&this.#r.arrived())}#O(e,t,s){if(e!==this.#a&&(this.#a?.terminate(),this.#T("another scene was opened")),this.#a=e,e===this.#c&&(this.#h=this.request===this.#u&&this.count>0,this.#u=this.request,this.#c=null),this.#w=[...t],this.#v=t,this.background=this.#g,this.#i?.lost)return this.#M(this.#i.lost),!1;try{s()}catch(n){return e.terminate(),this.count=0,this.#r.failed(Yt(n)),!1}return this.broken=!1,!0}#F(e,t){this.views=e,this.near=t}#R(e){this.#e=e,this.count=("stored"in e?e.stored:e).length/3,this.#i?.show(this.count),this.#p.invalidate(),this.#r.changed()}#C({part:e,from:t,numbers:s}){this.#i?.update(e,t,s),e==="lobes"&&Kt(this.logits,this.#b,t,s),this.#r.changed()}#D(e){this.#p.received(),this.#i?.setOrder(e),this.#x?.resolve(),this.#x=null,this.#r.ordered()}#z(e){let t=this.#p.neededDirection(e);t!==null&&(this.#p.by==="page"?this.#i?.setOrder(Be(this.means,t)):this.#a?.postMessage({forward:t}))}},Yt=o=>o instanceof Error?o.message:String(o);var En=.02,_n=.02,kn=.001,re=class o{constructor(e,t,s){this.eye=e,this.target=t,this.up=J(s),this.reach=me(D(t,e))||1}static fromViews(e,t=0){let s=e.map(Fr),n=Or(s),{eye:r,forward:i}=s[t],a=O(D(zr(s),r),i),c=Math.max(...s.map(l=>me(D(l.eye,r))),0)||1;return new o(r,T(r,i,a>kn*c?a:c),n)}static around(e){let t=[0,1,2].map(r=>{let i=e.filter((c,l)=>l%3===r).sort(),a=c=>i[Math.floor(c*(i.length-1))]??0;return[a(.15),a(.5),a(.85)]}),s=t.map(([,r])=>r),n=Math.max(...t.map(([r,,i])=>i-r))||1;return new o(T(s,[0,-.3,-1],1.5*n),s,[0,-1,0])}get forward(){return J(D(this.target,this.eye))}get right(){return J(X(this.forward,this.up))}copy(){let e=new o(this.eye,this.target,this.up);return e.reach=this.reach,e}orbit(e,t){let s=this.#e(D(this.eye,this.target),e,t);this.eye=T(this.target,s)}look(e,t){let s=this.#e(D(this.eye,this.target),e,t);this.target=D(this.eye,s)}move(e,t,s){let n=X(this.forward,this.right),r=T([0,0,0],this.right,e);r=T(T(r,n,t),this.forward,s),this.eye=T(this.eye,r),this.target=T(this.target,r)}dolly(e){let t=D(this.eye,this.target),s=Math.max(me(t)*e,kn*this.reach);this.eye=T(this.target,J(t),s)}focus(e){me(D(e,this.eye))>0&&(this.target=e)}viewmat(){let{forward:e,right:t,eye:s}=this,n=X(e,t),r=i=>[...i,-O(i,s)];return[...r(t),...r(n),...r(e),0,0,0,1]}#e(e,t,s){let n=Math.acos(Math.min(1,Math.max(-1,O(J(e),this.up)))),r=Math.min(Math.max(n-s,En),Math.PI-En)-n;return Xt(Xt(e,this.right,r),this.up,-t)}};function An(o,e,t,s,n,r=null){let i=Math.tan((r??50)*Math.PI/360),a=r===null?e:null,c=a?t*a.K[0]/a.width:t/(2*i),l=a?s*a.K[4]/a.height:s/(2*i),f=Math.sqrt(c*l),h={cx:t/2,cy:s/2};return{viewmat:o.viewmat(),fx:f,fy:f,...h,width:t,height:s,near:n}}function Or(o){let e=J(o.reduce((s,{down:n})=>D(s,n),[0,0,0])),t=e;for(let s=0;s<200;s++){let n=T([0,0,0],t,1+_n);for(let{right:r}of o)n=T(n,r,-O(r,t)/o.length);t=J(T(n,e,_n*O(e,t)))}return t}function Fr({viewmat:o}){let e=i=>[o[4*i],o[4*i+1],o[4*i+2]],[t,s,n]=[e(0),e(1),e(2)],r=T([0,0,0],t,-o[3]);return r=T(T(r,s,-o[7]),n,-o[11]),{eye:r,right:t,forward:n,down:s}}function zr(o){let e=[.001,0,0,0,.001,0,0,0,.001],t=[0,0,0];for(let{eye:c,forward:l}of o){for(let f=0;f<3;f++)for(let h=0;h<3;h++)e[3*f+h]+=(f===h?1:0)-l[f]*l[h];t=T(T(t,c,1+.001/o.length),l,-O(l,c))}let s=c=>[e[c],e[3+c],e[6+c]],[n,r,i]=[s(0),s(1),s(2)],a=O(n,X(r,i));return[O(t,X(r,i))/a,O(n,X(t,i))/a,O(n,X(r,t))/a]}var Ur=16.666666666666668,Ir=1e3/50,Nr=1e3/45,Sn=1e3/26,Cr=3,Dr=200,Pr=.9,Tn=[4,64],Br=[1,.85,.7,.6,.5],Re=class{#e=0;#t=[];#o;#n=Nr;#s={step:0,median:1/0};#r=0;#i=Tn[0];constructor(e){this.fixed=e,this.#o=e===null?Br:[e]}get scale(){return this.#o[this.#e]}reduced(e){return(e?this.scale:this.#o[0])<1}size(e,t,s,n){let r=Math.min(s,2)*(n?this.scale:this.#o[0]),i=a=>Math.max(1,Math.round(a*r));return{width:i(e),height:i(t)}}note(e){this.#t.push(e);let{length:t}=this.#t;if(t<Cr||this.#t.reduce((n,r)=>n+r)<Dr)return;let s=this.#t.sort((n,r)=>n-r)[t>>1];this.#t=[],s>this.#n?this.#a(s):s>=Ir||this.#e===0?this.#r=0:++this.#r>=this.#i&&(this.#e-=1,this.#r=0)}#a(e){let{step:t,median:s}=this.#s;if(this.#r=0,this.#i=Math.min(2*this.#i,Tn[1]),t<this.#e&&e<Sn&&e>Pr*s){this.#e=t,this.#n=Sn;return}this.#s={step:this.#e,median:e};let n=this.scale*Math.sqrt(Ur/e),r=this.#o.findIndex(i=>i<this.scale&&i<=n);this.#e=r<0?this.#o.length-1:r}};function Mn({fx:o,fy:e,width:t,height:s},n){if(n.length===0)return 1;let r=Math.sqrt(n[0].K[0]*n[0].K[4]),i=Math.min(4,Math.floor(4096/Math.max(t,s)));return Math.max(1,Math.min(Math.floor(r/Math.sqrt(o*e)+.5),i))}var $r=100,Rn=150,Gr=9*Math.PI/180,ht=class{mode="orbit";pose=new re([0,0,-3],[0,0,0],[0,-1,0]);fov=null;timed=!1;turning=!1;measured=!1;#e;#t;#o;#n;#s;#r=null;#i="auto";#a=null;#c;#l;#f=this.pose;#d=!1;#u=0;#h=0;#b=-1/0;#w=!1;#g=0;#v=0;#p;constructor(e,t,{variant:s=null,levels:n=0}={}){this.#t=e,this.#e=t,this.#o=s,this.#n=n,this.#c=new Re(null),this.#s=this.#k(e,0,!1),this.#l=new Pe(e,{pose:()=>this.pose,mode:()=>this.mode,held:()=>this.turning=!1,changed:()=>{this.#b=performance.now(),this.turning=!1,this.redraw()},focus:(r,i)=>this.#A(r,i)}),this.#p=new ResizeObserver(()=>this.redraw()),this.#p.observe(e)}begin(e){return this.#i=e,this.#s.begin(e)}load(e){this.#s.request&&(this.#d=!1),this.#s.load(e)}async compare(e,t,s){this.endComparison();let n=this.#k(e,1,s);n.background=this.#a,this.#r=n,await this.#s.calibrated,n===this.#r&&await n.begin(this.#i)&&n===this.#r&&n.load(t)}endComparison(){this.#r?.destroy(),this.#r=null}redraw(){!this.#u&&!this.measured&&(this.#u=requestAnimationFrame(e=>this.#E(e)))}reset(e){let{views:t}=this;this.pose=e===void 0||t.length===0?this.#f.copy():re.fromViews(t,(e%t.length+t.length)%t.length),this.redraw()}place(e){this.pose=e,this.#d=!0,this.redraw()}camera(e,t){return An(this.pose,this.views[0]??null,e,t,this.#s.near,this.fov)}get views(){return this.#s.views.length?this.#s.views:this.#r?.views??[]}get count(){return this.#s.count}get calibrated(){return this.#s.calibrated}get source(){let{request:e}=this.#s;return e===null||"forward"in e?null:"url"in e?e.url:e.file}get device(){return this.#s.device}get scale(){return this.#c.fixed}set scale(e){this.#c=new Re(e),this.redraw()}get choices(){let{mode:e,fov:t,turning:s,scale:n,timed:r}=this;return{mode:e,fov:t,turning:s,scale:n,timed:r,background:this.#a}}get background(){return this.#s.background}set background(e){this.#a=e;for(let t of this.#x)t.background=e;this.redraw()}async drawAndWait(e,t){let s=this.camera(e,t),n=await this.#s.sort(s);if(this.#s.draw(s),await this.finished(),this.#s.broken)throw new Error("the renderer was lost");return n}async finished(){await this.#s.finished()}async passes(){return await this.#s.time(),this.#s.milliseconds}pixels(e,t=0){return this.#x[t]?.pixels(e)??Promise.reject(new Error("there is no other scene"))}screenshot(e=1){let{width:t,height:s}=this.#_(),n=document.createElement("canvas");[n.width,n.height]=[t,s];let r=n.getContext("2d");return this.#x.forEach(({canvas:i},a)=>{let c=a*Math.round(e*t),l=t-c;l>0&&r?.drawImage(i,c,0,l,s,c,0,l,s)}),new Promise(i=>n.toBlob(i,"image/png"))}destroy(){cancelAnimationFrame(this.#u),clearTimeout(this.#v),clearTimeout(this.#g),this.#l.destroy(),this.#p.disconnect();for(let e of this.#x)e.destroy()}get#x(){return this.#r?[this.#s,this.#r]:[this.#s]}#k(e,t,s){let n={progress:r=>this.#e.progress(t,r),arrived:()=>this.#y(t),changed:()=>{this.#g||=setTimeout(()=>this.redraw(),$r)},ordered:()=>this.redraw(),loaded:(r,i)=>{this.#e.loaded(t,r,i),this.redraw()},failed:(r,i)=>this.#e.failed(t,r,i),broken:r=>this.#e.broken(t,r)};return new ft(e,n,this.#o,s,this.#n)}#y(e){let{views:t}=this;(e===0||!this.#s.views.length&&this.#b===-1/0)&&(t.length||this.#s.count)&&(this.#f=t.length?re.fromViews(t):re.around(this.#s.means),this.#d||this.reset()),this.redraw()}#E(e){this.#u=0,clearTimeout(this.#g),this.#g=0;let t=e-this.#h;this.#h=e;let s=this.#w,n=this.turning&&this.count>0;this.#w=performance.now()-this.#b<Rn||this.#l.busy||n,this.#w&&s&&this.#c.note(t);let r=Math.min(t,100)/1e3;this.#l.advance(r),n&&this.pose.orbit(Gr*r,0);let{width:i,height:a}=this.#_();if(clearTimeout(this.#v),this.#w&&(this.#v=setTimeout(()=>this.redraw(),2*Rn)),this.count&&!this.#s.broken){let{name:c,count:l,milliseconds:f}=this.#s,h=this.#w&&s?t:0,d=this.#r?.count??0;this.#e.drawn({renderer:c,count:l,compared:d,width:i,height:a,milliseconds:h,passes:f}),this.timed&&this.#s.time()}(this.#l.busy||n)&&this.redraw()}#_(){let{clientWidth:e,clientHeight:t}=this.#t,s=this.#c.size(e,t,devicePixelRatio,this.#w);if(e&&t){let n=this.camera(s.width,s.height),r=this.#c.reduced(this.#w)?1:Mn(n,this.views);for(let i of this.#x)i.drawOrReport(n,r)}return s}#A(e,t){let{clientWidth:s,clientHeight:n}=this.#t,{means:r,logits:i}=this.#s,a=yn(r,i,this.camera(s,n),e,t);a&&this.pose.focus(a),this.redraw()}};var Ln=["settings","help","report"],On=["scale","background","fov","autorotate"],qr=2e3,Fn="sorted",Hr={rootMargin:"100%"},Wr="(prefers-reduced-motion: reduce)",Qt=class extends(globalThis.HTMLElement??Object){static observedAttributes=["src","compare",...On];viewer=null;#e;#t=null;#o=new ve;#n=null;#s;#r=!1;#i=!1;#a=null;#c=[];#l=0;#f=Promise.resolve(!1);#d=!1;#u=new IntersectionObserver(e=>e.some(t=>t.isIntersecting)&&this.#h(),Hr);constructor(){super(),this.#e=this.attachShadow({mode:"open",delegatesFocus:!0}),this.#e.innerHTML=_s;for(let t of this.#e.querySelectorAll("button"))t.addEventListener("click",()=>this.act(t.dataset.act??""));this.#e.addEventListener("keydown",t=>{let{code:s,key:n,ctrlKey:r,metaKey:i,altKey:a,repeat:c,target:l,defaultPrevented:f}=t,h=Mt.get(n.toLowerCase())??Mt.get(s.slice(3).toLowerCase()),d=f||l.matches("textarea, select");h&&!r&&!i&&!a&&!c&&!d&&this.act(h),s==="Escape"&&this.act("close")}),this.#e.addEventListener("keyup",t=>{let{code:s,target:n}=t,{classList:r}=n;s==="Tab"&&(r.add("reached"),n?.addEventListener("blur",()=>r.remove("reached"),{once:!0}))}),this.#m("settings").addEventListener("input",({target:t})=>{let s=t;s.name==="stats"?this.act("stats"):this.viewer&&ys(s,this.viewer)}),this.addEventListener("dragover",t=>{t.preventDefault(),this.#m("drop").hidden=!1}),this.addEventListener("dragleave",()=>this.#m("drop").hidden=!0),this.addEventListener("drop",t=>{t.preventDefault(),this.#m("drop").hidden=!0,this.#x(t.dataTransfer?.files)});let e=this.#p;e.addEventListener("change",()=>{this.#E(null),this.#x(e.files),e.value=""})}connectedCallback(){queueMicrotask(()=>{if(!this.isConnected||this.viewer)return;let e=this.getAttribute("poster")?.replace(/[\x22\\\n]/g,encodeURIComponent);e&&(this.style.background=`center / cover no-repeat url("${e}")`),this.getAttribute("loading")==="lazy"?this.#u.observe(this):this.#h()})}#h(e=this.getAttribute("renderer")??"auto"){this.#u.disconnect(),this.#m("buttons").hidden=this.hasAttribute("noui"),this.#e.querySelector("[data-act=full]").hidden=!document.fullscreenEnabled;let t=this.#e.querySelector("canvas"),s=this.getAttribute("variant"),[n,r]=["floats","strips"].map(l=>!!s?.includes(l)),i=Number(this.getAttribute("levels"));this.viewer=new ht(t,this,{variant:s===null?null:{floats:n,strips:r},levels:i>=.6&&i<=100?i:0}),t.setAttribute("aria-label",`${this.getAttribute("alt")??"3D scene"}. Press H for the keys.`),t.classList.toggle("polite",this.hasAttribute("polite"));for(let l of On)this.#_(l);this.#f=this.viewer.begin(e),this.#d=!1,this.#f.then(l=>this.#d=!l);let a=this.#n??this.getAttribute("src"),c=this.#s===void 0?this.getAttribute("compare"):this.#s;a&&this.open(a),c&&this.compare(c)}disconnectedCallback(){this.#u.disconnect(),this.#b()}#b(){this.viewer?.destroy(),this.viewer=null,this.#T(),this.#o=new ve;let e=this.#e.querySelector("canvas");e?.classList.remove("drawn"),e?.replaceWith(e.cloneNode())}attributeChangedCallback(e,t,s){e==="src"&&(this.#n=null),e==="compare"&&(this.#s=void 0),!(!this.viewer||s===t)&&(e==="compare"?this.compare(s||null):e!=="src"?this.#_(e):s&&this.open(s))}async open(e){this.#n=e,this.#i=this.#r,await this.#A(0,e,(t,s)=>t.load(s))}async compare(e){this.#s=e,this.#i=!1,this.#r=e===Fn;let t=this.#r?this.#n:e;this.viewer?.endComparison(),this.#T(),this.#o.begin(1),this.#S(),t!==null&&await this.#A(1,t,(s,n)=>{this.#T();let r=document.createElement("canvas");r.className="over",r.setAttribute("aria-hidden","true"),this.#m("split").before(r),this.#t=new De(this.#m("split"),r),s.compare(r,n,this.#r)})}act(e){let t=this.viewer;if(t){if(e==="reset"||e==="view")t.turning=!1,t.reset(e==="view"?++this.#l:void 0);else if(e==="help"||e==="settings")this.#E(e);else if(e==="stats")t.timed=this.#y("stats");else if(e==="own")t.background=null;else if(e==="mode"){let s=t.mode==="fly";t.mode=s?"orbit":"fly",this.#w(`Dragging ${s?"rotates the scene":"looks around"}.`,!0)}else e==="picture"?this.#k():e==="open"?this.#p.click():e==="copy"?this.#v():e==="share"?navigator.share?.({text:this.#g}).catch(()=>{}):e==="full"?document.fullscreenElement?document.exitFullscreen():this.requestFullscreen?.().catch(()=>{}):e==="close"&&(this.#m("message").hidden=!0,this.#E(null));xs(this.#m("settings"),t,!this.#m("stats").hidden),t.redraw()}}progress(e,t){this.#o.note(e,{share:t,state:"loading"}),this.#S()}loaded(e,t,s){this.#o.note(e,{share:1,state:"loaded"}),this.#S(),e!==1&&(this.#i&&this.compare(Fn),this.#w(`${this.viewer?.count.toLocaleString("en")} Gaussians loaded.`),this.dispatchEvent(new CustomEvent("load",{detail:{milliseconds:t,bytes:s}})))}failed(e,t,s=!1){this.#o.fail(e,t,s),e===0&&(this.#i=!1),this.#S(),this.#m("message").hidden=!1,e===0&&(this.#n=this.viewer?.source??this.#n),this.#e.querySelector(".message [data-act=open]").hidden=!!this.viewer?.count,this.dispatchEvent(new CustomEvent("error",{detail:{sentence:t}}))}broken(e,t){let s=this.viewer;if(!s||s.device.renderer==="WebGL2"||this.getAttribute("renderer")==="webgpu"){this.failed(e,t);return}console.warn(`WebGL2 takes over: ${t}`),this.#b(),this.#h("webgl"),Object.assign(this.viewer,s.choices),s.count&&this.viewer?.place(s.pose)}report(e){let t=JSON.stringify(e,null,1),s=this.#m("report");s.querySelector("textarea").value=t;let n=e.scenes,r=n.some(a=>a.interrupted),i=n.map(({cold:a,steady:c})=>`${a.fps} frames/s cold, ${c.fps} steady`).join(" | ");s.querySelector("h2").textContent=r?"The page was hidden during the measurement: measure again":i,s.querySelector("[data-act=share]").hidden=!navigator.share,s.hidden&&this.#E("report"),this.dispatchEvent(new CustomEvent("report",{detail:e}))}drawn(e){this.#e.querySelector("canvas")?.classList.add("drawn"),e.compared&&this.#m("split").hidden&&this.#t?.show(this.#o.names),this.dispatchEvent(new CustomEvent("frame",{detail:e}));let t=this.#m("stats");if(t.hidden)return;e.milliseconds&&(this.#c=[...this.#c.slice(-29),e.milliseconds]);let s=this.#c.reduce((i,a)=>i+a,0)/this.#c.length,n=[e.count,e.compared].filter((i,a)=>a===0||i),r=[`${e.renderer}, ${e.width} x ${e.height}`,`${n.map(i=>i.toLocaleString("en")).join(" | ")} Gaussians`,this.#c.length?`${(1e3/s).toFixed(0)} frames/s, ${s.toFixed(1)} ms`:"still",...Object.entries(e.passes??{}).map(([i,a])=>`${i} ${a.toFixed(2)} ms`)];t.textContent=r.join(`
`)}#w(e,t=!1){let s=this.#m("said");s.textContent=e,s.classList.toggle("seen",t),setTimeout(()=>s.classList.remove("seen"),qr)}get#g(){let e=this.#e.querySelector("textarea");return e.focus(),e.select(),e.value}async#v(){let e=this.#g,t=navigator.clipboard?await navigator.clipboard.writeText(e).then(()=>!0,()=>!1):document.execCommand("copy");this.#m("copied").textContent=t?"Copied.":"This browser does not allow copying: the text is selected, press Ctrl+C."}get#p(){return this.#e.querySelector("[type=file]")}#x(e){let[t,s]=e??[];t&&this.open(t),s&&this.compare(s)}async#k(){let e=await this.viewer?.screenshot(this.#t?.share);if(!e)return;let t=document.createElement("a");Object.assign(t,{href:URL.createObjectURL(e),download:"scene.png"}).click(),setTimeout(()=>URL.revokeObjectURL(t.href),1e3)}#y(e,t){let s=this.#m(e);return s.hidden=t===void 0?!s.hidden:!t,this.#e.querySelector(`[data-act=${e}]`)?.setAttribute("aria-expanded",String(!s.hidden)),!s.hidden}#E(e){Ln.every(s=>this.#m(s).hidden)&&(this.#a=this.#e.activeElement);let t=e!==null&&this.#m(e).hidden;for(let s of Ln)this.#y(s,t&&s===e);t?this.#m(e).focus():(this.#a??this.#e.querySelector("canvas"))?.focus({preventScroll:!0})}#_(e){let t=this.viewer,s=this.getAttribute(e),n=Number(s);e==="scale"?t.scale=n>0&&n<=1?n:null:e==="fov"?t.fov=n>=1&&n<=150?n:null:e==="background"?t.background=Ce(s):t.turning=s!==null&&!matchMedia(Wr).matches,t.redraw()}async#A(e,t,s){let n=this.viewer;if(n===null||this.#d)return;let r=this.#s;if(e===1&&(!await this.#f||n!==this.viewer||r!==this.#s))return;let i=typeof t=="string"?t.replace(/[?#].*$/,""):"scene",a=t instanceof File?t.name:i;this.#o.begin(e,e===1&&this.#r?`${a}, sorted`:a),this.#S();try{let c=t instanceof Blob?{file:t}:{url:new URL(t,document.baseURI).href};s(n,c)}catch(c){this.failed(e,`the scene cannot be opened: ${c.message}`)}}#S(){let{state:e,busy:t,share:s,sentence:n,names:r}=this.#o,i=this.#m("bar");i.hidden=!t,i.classList.toggle("unknown",Number.isNaN(s));let a=Math.min(100,Math.round(100*s))||0;i.setAttribute("aria-valuenow",String(a)),i.firstElementChild.style.width=`${a}%`;let c=this.#m("message"),l=c.querySelector("p");l.textContent!==n&&(l.textContent=n),n||(c.hidden=!0),this.#m("split").hidden||this.#t?.show(r),e&&(this.dataset.state=e)}#T(){this.#m("split").hidden=!0,this.#e.querySelector(".over")?.remove(),this.#t=null}#m(e){return this.#e.querySelector(`.${e}`)}};globalThis.customElements?.define("mobile-gs",Qt);var x=128,Vr=1e-12,zn=new Float32Array(0),dt=class{wasmMemory=null;#e=[];#t=0;#o=null;#n;constructor(e=!1){this.#n=e}block(e){return this.#s(e,x*e,null)}part({at:e},t,s){let n={at:e+4*x*t,width:s,numbers:zn};return this.#e.push([n,null,x*s]),n}layer(e,t,s){let n=s?s.length:e.length/t,r=Math.ceil(n/4)*4,i=new Float32Array(r*t);for(let l=0;l<n;l++){let f=(l-l%4)*t+l%4;for(let h=0;h<t;h++)i[f+4*h]=e[l*t+h]}let a=new Float32Array(r);s&&a.set(s);let c=l=>this.#s(0,l.length,l);return{inputs:t,outputs:r,weights:c(i),offsets:c(a)}}#s(e,t,s){let n={at:this.#t,width:e,numbers:zn};return this.#e.push([n,s,t]),this.#t+=16*Math.ceil(t/4),n}allocate(){this.wasmMemory=$e(this.#t);let e=this.wasmMemory?.buffer??new ArrayBuffer(this.#t);for(let[t,s,n]of this.#e.splice(0))t.numbers=new Float32Array(e,t.at,n),s&&t.numbers.set(s);this.#o=this.#n?null:le(this.wasmMemory)}apply({inputs:e,outputs:t,weights:s,offsets:n},r,i,a){if(this.#o){this.#o.layer(s.at,n.at,r.at,i.at,e,t,a);return}let[c,l,f,h]=[r,i,s,n].map(({numbers:d})=>d);for(let d=0;d<t;d++){let p=(d-d%4)*e+d%4;for(let u=0;u<x;u++){let m=h[d];for(let w=0;w<e;w++)m+=f[p+4*w]*c[w*x+u];l[d*x+u]=Math.max(m,a*m)}}}units({at:e,width:t,numbers:s},{at:n,numbers:r}){if(this.#o){this.#o.units(e,n,t);return}for(let i=0;i<x;i++){let a=0;for(let l=i;l<x*t;l+=x)a+=s[l]*s[l];let c=1/Math.max(Math.sqrt(a),Vr);for(let l=i;l<x*t;l+=x)r[l]=s[l]*c}}};var jr=80;function Un(o){let e=0;for(let{count:t,size:s,length:n}of o.values())e+=t*s*n;return e}function In(o,e){let t=0,s=new Map;for(let[n,{count:r,size:i,length:a}]of e){let c=()=>o.subarray(t,t+=i*a);s.set(n,{length:a,books:Array.from({length:r},c)})}if(s.get("scale")?.books.some(n=>n.some(r=>r>jr)))throw new y("the codebooks of the .mgs file hold scales that are out of range");return s}function Nn(o){return new Map([...o].map(([e,{step:t,columns:s}])=>{let n=s.map(({least:r,size:i})=>Float32Array.from({length:i},(a,c)=>(r+c)*t));return[e,{length:1,books:n,middles:s.map(({least:r,middle:i})=>i-r)}]}))}function Cn({name:o,codec:e,data:t},s,n){if(e==="rans")return se(t,s,n);let r=32-Math.clz32(n-1),i=ce(t,r*s),a=new Uint16Array(s);for(let c=0;c<s;c++){let l=i.take(r);if(l>=n)throw new y(`the stream '${o}' points outside of its codebook`);a[c]=l}return a}function Le({length:o,books:e,middles:t}){let s=new Uint16Array(x);return{length:o,books:e.map((n,r)=>t?n.subarray(t[r],t[r]+1):Xr(n,o)),columns:e.map(()=>s)}}function Xr(o,e){let t=new Float64Array(e);for(let s=0;s<o.length;s++)t[s%e]+=o[s]*e/o.length;return Float32Array.from(t)}function P({length:o,books:e,columns:t},s,n,r,i){for(let a=0;a<e.length;a++){let c=e[a],l=t[a],f=a*o*n;if(o===1){for(let h=r;h<i;h++)s[f++]=c[l[h]];continue}for(let h=0;h<o;h++,f=(a*o+h)*n)for(let d=r;d<i;d++)s[f++]=c[l[d]*o+h]}}var Kr=[53,210,405,600,787,970,1151,1329],Yr=Uint8Array.from({length:1330},(o,e)=>Kr.filter(t=>t<=e).length),Zt=Float64Array.from({length:512},(o,e)=>(e+.5)/2**(31-Math.clz32(e))-1.5),Qr=2.5,Jt=(o,e)=>Yr[Math.min(256*Math.abs(Math.fround(o-e)),1329)|0];function Dn(o,e,t){let[s,n,r]=t,i=s.length,a=[new Uint16Array(i),new Uint16Array(i),new Uint16Array(i)],[c,l,f]=a,[h,d,p]=e,u=new ee(o),m=0;for(let w=0;w<i;w++){let v=h[s[w]],_=d[n[w]],E=p[r[w]],b=Jt(_,E),k=Jt(v,E),S=Jt(v,_),z=u.take(b+k+S);c[w]=1<<b|z&(1<<b)-1,l[w]=1<<k|z>>>b&(1<<k)-1,f[w]=1<<S|z>>>b+k,m+=b+k+S}return ce(o,m),a}function Pn({step:o,columns:[{least:e},{least:t},{least:s}]},n,r,i,a){let[c,l,f,h,d,p]=n;for(let u=r,m=0;u<i;u++,m++){let w=o*(c[u]+e+Zt[h[u]]),v=o*(l[u]+t+Zt[d[u]]),_=o*(f[u]+s+Zt[p[u]]),E=(w*w+v*v+_*_)/4,b=1+E*(-1/2+E*(1/24+E*(-1/720+E*(1/40320+E*(-1/3628800+E*(1/479001600-E/87178291200)))))),k=1/2+E*(-1/12+E*(1/240+E*(-1/10080+E*(1/725760+E*(-1/79833600+E/12454041600)))));if(E>Qr){let S=Math.sqrt(E);b=Math.cos(S),k=Math.sin(S)/(2*S)}a[m]=b,a[m+x]=k*w,a[m+2*x]=k*v,a[m+3*x]=k*_}}var Zr=256,Bn=["raw","halves","planes"],Jr=["bits","rans"],$n=[["scale","rotation"],["appearance","opacity"],["lobes"]],ts=$n.length,Oe=2,es=class{positions=null;columns=new Map;#e;constructor(e,t){this.#e=e,this.count=t}get stage(){let e=$n.findIndex(t=>!t.every(s=>this.#t(s)));return e<0?ts:e}rows(e,t,s="slice"){let n=[...this.columns].filter(([i])=>this.#t(i)).map(([i,a])=>[i,a.map(c=>c[s](e,t))]);return{positions:this.positions[s](3*e,3*t),columns:Object.fromEntries(n)}}#t(e){let{cuts:t,scalars:s}=this.#e,n=s.size&&e==="rotation"?3:0,r=(t.get(e)?.count??s.get(e)?.columns.length??0)+n;return Object.keys(this.columns.get(e)??[]).length===r}},ut=class{levels;network=null;#e;#t;#o=new Map;#n=new Map;#s=new Map;#r={};#i={};constructor(e,t){this.#e=e,this.#t=t;let{network:s,lobes:n,cuts:r,scalars:i,lodSizes:a}=e;s&&this.#l("view-network",Ks,f=>this.network=f),n&&this.#l("lobe-decoder",Ys(n),f=>this.#r=f),this.#l(...Xs(e),f=>this.#i=f),i.size?this.#s=Nn(i):this.#c("codebooks",Bn,[],f=>{this.#s=In(Ft(f,Un(r)),r)});let c=[...this.#o.keys()],l=0;this.levels=a.map((f,h)=>(l+=f,this.#a(f,h?`@${h}`:"",c,l)))}#a(e,t,s,n){let{cuts:r,scalars:i}=this.#e,a=new es(this.#e,e),[c,...l]=["positions","scale.0","scale.1","scale.2"].map(d=>d+t),f=(d,p)=>{let u=[];a.columns.set(d,u);for(let[m,w]of p.entries())this.#c(`${d}.${m}${t}`,Jr,[c],v=>{u[m]=Cn(v,e,w)})},h=({data:d})=>{a.positions=Ns(d,e)};this.#c(c,["morton-class"],s,h,n);for(let[d,{count:p,size:u}]of r)f(d,Array(p).fill(u));for(let[d,{columns:p}]of i)f(d,p.map(({size:u})=>u));if(i.size){let[d,p]=["scale","rotation"].map(u=>a.columns.get(u)??[]);this.#c(`rotation-finer${t}`,["bits"],[c,...l],({data:u})=>{let{books:m}=this.#s.get("scale");Dn(u,m,d).forEach((w,v)=>p[3+v]=w)})}return a}accept(e){this.#o.has(e.name)&&this.#n.set(e.name,e)}step(e){for(let[t,{after:s,minBytes:n,read:r}]of this.#o){let i=this.#n.get(t);if(!(i===void 0||e<n||s.some(a=>this.#o.has(a))))return r(i),this.#o.delete(t),this.#n.delete(t),!0}return!1}get decoderInputs(){let[{count:e,positions:t}]=this.levels,s=t,n=Math.min(e,Zr),r=new Uint16Array(3*n).map((c,l)=>s[3*Math.floor(Math.floor(l/3)*e/n)+l%3]),[i,a]=[this.#e,this.#s];return{header:i,books:a,appearance:this.#i,lobes:this.#r,samples:r}}#c(e,t,s,n,r=0){let i=this.#t.find(a=>a.name===e);if(i===void 0)throw new y(`the .mgs file lacks its stream '${e}'`);if(!t.includes(i.codec))throw new y(`the stream '${e}' of the .mgs file uses the codec '${i.codec}', which this program does not know`);this.#o.set(e,{after:s,minBytes:r,read:n})}#l(e,t,s){this.#c(e,Bn,[],n=>s(Zs(Ft(n,Qs(t)),t)))}};var I=new Int32Array(2048);for(let o=0;o<I.length;o++){let e=o<256?o:I[o-256];for(let t=0;t<8;t++)e=(e&1?3988292384:0)^e>>>1;I[o]=e}function pt(o,e=0){let t=~e,s=0;for(;s+8<=o.length;s+=8)t^=o[s]|o[s+1]<<8|o[s+2]<<16|o[s+3]<<24,t=I[1792+(t&255)]^I[1536+(t>>>8&255)]^I[1280+(t>>>16&255)]^I[1024+(t>>>24)]^I[768+o[s+4]]^I[512+o[s+5]]^I[256+o[s+6]]^I[o[s+7]];for(;s<o.length;s++)t=I[(t^o[s])&255]^t>>>8;return~t>>>0}var we=[77,71,83,26,13,10,0,1],ss=[2,3,4],mt=20,ei=2**20,ti=256,si=2**32,ni=[["ply","a PLY scene: train or compress it first"],["PK","a zip archive (perhaps .sog)"],["\x8B","a gzip file (perhaps .spz)"],["NGSP","an .spz scene"],["glTF","a binary glTF file"],["\xFD7zXZ","an xz file (perhaps another program's comp.xz)"],["\x89PNG","a PNG picture"],["\xFF\xD8\xFF","a JPEG picture"],["<","a web page"],["{","a JSON text"]],wt=class{received=0;total=1/0;fields=null;table=[];#e=[];#t=0;#o=0;#n=!1;#s=null;append(e){if(e.length>0&&this.#e.push(e),this.received+=e.length,this.#t+=e.length,!this.#r())return[];if(this.received>this.total)throw new y(`the .mgs file has ${this.received-this.total} bytes too many at its end`);let t=[];for(let s;(s=this.table[this.#o])&&ns(s.bytes)<=this.#t;)this.#o++,t.push(oi(s,this.#a(ns(s.bytes))));return t}end(){if(this.fields!==null){let t=this.table[this.#o];if(t===void 0)return;throw new y(`the .mgs file ends inside its stream '${t.name}': it has been cut short`)}if(!this.#n)throw new y(Gn(this.#a(this.#t)));let e=this.#s===null?"first bytes":"header";throw new y(`the .mgs file ends inside its ${e}: it has been cut short`)}#r(){if(!this.#n&&this.#t>=we.length){let e=this.#a(we.length);if(we.some((t,s)=>t!==e[s]))throw new y(Gn(e));this.#n=!0}if(this.#n&&this.#s===null&&this.#t>=mt-we.length&&(this.#s=this.#a(mt-we.length)),this.#s!==null&&this.fields===null){let e=ri(this.#s);this.#t>=e&&this.#i(this.#s,this.#a(e))}return this.fields!==null}#i(e,t){let s=G(e).getUint32(8,!0);if((mt+t.length)%8||pt(t,pt(e.subarray(0,8)))!==s)throw new y("the header of the .mgs file is damaged (wrong checksum)");this.fields=ii(t);let n=G(e).getUint16(0,!0);if((n===2||n===4&&this.fields.layers===void 0)&&(this.fields.layers=[this.fields.count]),n<4&&(this.fields.footprint=Ke),this.table=ai(this.fields.streams),this.total=this.table.reduce((r,i)=>r+ns(i.bytes),mt+t.length),this.total>si)throw new y(`the .mgs file claims ${this.total} bytes, too many for a scene`)}#a(e){this.#t-=e;let t=this.#e[0];if(t!==void 0&&t.length>e)return this.#e[0]=t.subarray(e),t.subarray(0,e);let s=new Uint8Array(e),n=0,r=0;for(;n<e;){let i=this.#e[r],a=i.subarray(0,e-n);s.set(a,n),n+=a.length,a.length<i.length?this.#e[r]=i.subarray(a.length):r++}return this.#e.splice(0,r),s}};function ns(o){return Math.ceil(o/8)*8}function oi(o,e){let t=e.subarray(0,o.bytes);if(pt(t)!==o.crc32)throw new y(`the stream '${o.name}' of the .mgs file is damaged (wrong checksum)`);if(e.subarray(o.bytes).some(s=>s!==0))throw new y(`the .mgs file is damaged after its stream '${o.name}'`);return{name:o.name,codec:o.codec,data:t}}function ri(o){let e=G(o),t=e.getUint16(0,!0),s=e.getUint32(4,!0);if(!ss.includes(t))throw new y(`the .mgs file is of version ${t}.${e.getUint16(2,!0)}, this program reads ${ss[0]}.x to ${ss[2]}.x: reload the page, or write the file again with this version of mobilegs`);if(s>ei)throw new y(`the header of the .mgs file claims ${s} bytes: it is damaged`);return s}function ii(o){let e;try{e=JSON.parse(new TextDecoder("utf-8",{fatal:!0,ignoreBOM:!0}).decode(o))}catch{throw new y("the header of the .mgs file is not valid JSON")}if(typeof e!="object"||e===null||Array.isArray(e))throw new y("the header of the .mgs file is not a JSON object");return e}function ai(o){if(!Array.isArray(o)||o.length>ti)throw new y("the header of the .mgs file lacks a table of streams");let e=new Set;return o.map(t=>{let{name:s,codec:n,bytes:r,crc32:i}=Object(t);if(!([s,n].every(c=>je(c,64))&&[r,i].every(c=>Number.isInteger(c)&&c>=0&&c<2**40)))throw new y("the header of the .mgs file has a broken table of streams");if(e.has(s))throw new y(`the .mgs file has two streams called '${s}'`);return e.add(s),{name:s,codec:n,bytes:r,crc32:i}})}function Gn(o){if(o.length===0)return"the file is empty, not a .mgs scene";if(we.findIndex((n,r)=>n!==o[r])>=Math.min(3,o.length))return"the first bytes of the .mgs file are damaged: transfer it again, in binary mode";let t=String.fromCharCode(...o),s=ni.find(([n])=>t.startsWith(n));return s?`this is not a .mgs scene but looks like ${s[1]}`:"this is not a .mgs scene"}var os=class{header=null;decoder=null;#e=new wt;get received(){return this.#e.received}get total(){return this.#e.total}append(e){let t=this.#e.append(e),{fields:s,table:n,total:r}=this.#e;s!==null&&this.decoder===null&&(this.header=on(s,r),this.decoder=new ut(this.header,n));for(let i of t)this.decoder?.accept(i)}end(){this.#e.end()}step(){return this.decoder?.step(this.received)??!1}};async function qn(o,e){let t=new os,s=o.getReader();try{for(let n=0;;){n-=performance.now();let{value:r,done:i}=await s.read();if(n+=performance.now(),i)break;t.append(r);do await e(t,n);while(t.step())}}catch(n){throw await s.cancel().catch(()=>{}),n}return t.end(),t}var cs=16,rs=6*cs,q=64,gt=13,is=.01,as=6,Hn=15,{fround:N,sqrt:ci}=Math,bt=class{#e;#t;#o;#n;constructor(e,t,{static2:s,view2:n}){let r=3+n.length/9,i=new Float32Array(12*r);for(let a=0;a<12;a++){let c=a<3?s.subarray(3*a,3*a+3):n.subarray((a-3)*(r-3));i.set(c.subarray(0,r-3),a*r+(a<3?0:3))}this.#e=e,this.#t=e.block(r),this.#o=e.layer(i,r),this.#n=t}decode(e,t,s){P(t,this.#t.numbers,x,s,s+e.length/3),this.#e.apply(this.#o,this.#t,this.#n,1)}},vt=class{#e;#t;#o;#n;#s;#r;#i;constructor(e,t,{both1:s,static2:n,view2:r}){this.#e=e,this.#t=[e.layer(s,as),e.layer(n,q),e.layer(r,q)],this.#o=e.block(as),this.#n=e.block(2*q),this.#s=[e.part(this.#n,0,q),e.part(this.#n,q,q)],this.#r=t,this.#i=e.part(t,3,12)}decode(e,t,s){let n=this.#e,[r,i,a]=this.#t;P(t,this.#o.numbers,x,s,s+e.length/3),n.apply(r,this.#o,this.#n,is),n.apply(i,this.#s[0],this.#r,1),n.apply(a,this.#s[1],this.#i,1)}},xt=class{#e;#t;#o;#n;#s;#r;#i;#a;#c;#l;constructor(e,t,{context1:s,context2:n,static1:r,static2:i,view1:a,view2:c},l){this.#e=e,this.#t=[e.layer(s,rs),e.layer(n,q),e.layer(r,gt+3),e.layer(i,q),e.layer(a,gt+3),e.layer(c,q)],this.#l=2**l,this.#o=e.block(as),this.#n=e.block(rs),this.#s=e.block(q),this.#r=e.block(gt+3),this.#i=e.part(this.#r,gt,3),this.#a=t,this.#c=e.part(t,3,12)}decode(e,t,s){let n=this.#e,[r,i,a,c,l,f]=this.#t,[h,d]=[this.#o.numbers,this.#i.numbers],[p,u,m]=[this.#n,this.#s,this.#r];this.#d(e,p.numbers),n.apply(r,p,u,0),n.apply(i,u,m,1),P(t,h,x,s,s+e.length/3),d.set(h.subarray(0,3*x)),n.apply(a,m,u,is),n.apply(c,u,this.#a,1),d.set(h.subarray(3*x)),n.apply(l,m,u,is),n.apply(f,u,this.#c,1)}#f(e,t){let s=U(e[t])*this.#l,n=U(e[t+1])*this.#l,r=U(e[t+2])*this.#l,i=N(N(N(s*s)+N(n*n))+N(r*r));return Math.max(1,N(ci(i)))}#d(e,t){for(let s=0,n=0;n<e.length;s++,n+=3){let r=this.#f(e,n),i=N(2-N(1/r));for(let a=0;a<3;a++){let c=U(e[n+a])*this.#l,l=N(i*N(c/r));li(l,t,a*cs*x+s)}}}};function li(o,e,t){let s=N(N(o*.25)+.5),n=Math.sin(Math.PI*s),r=Math.cos(Math.PI*s);for(let i=t+cs*x;t<i;t+=x){e[t]=n,e[t+rs/2*x]=r;let a=2*n*r;r=1-2*n*n,n=a}}var Et=.28209479177387814,yt=class{#e;#t;#o;#n;#s;#r;#i;constructor(e,t,s,{degree:n,latents:r,hidden:i},a){let c=2*(n+1)**2,l=i.at(-1)??0,f=[19+r,...i];this.#e=e,this.#o=s,this.#t=i.map((u,m)=>e.layer(a[`weights.${m}`],f[m],a[`offsets.${m}`]));let h=a[`weights.${i.length}`],d=fi(h,l,a.basis,r,c);this.#t.push(e.layer(d,l+r,a.bias)),this.#n=e.block(r);let p=i.length?[19,...i]:[0];this.#s=p.map(u=>e.block(Math.ceil(u/4)*4+r)),this.#r=[0,p.length-1].map(u=>e.part(this.#s[u],p[u],r)),this.#i=i.length?new de(e,t,this.#s[0]):null}decode(e,t,s){let[n,r,i]=[this.#e,this.#s,this.#t.length-1];this.#i?.write(),e&&P(e,this.#n.numbers,x,t,s),this.#r[0].numbers.set(this.#n.numbers);for(let a=0;a<i;a++)n.apply(this.#t[a],r[a],r[a+1],0);this.#r[1].numbers.set(this.#n.numbers),n.apply(this.#t[i],r[i],this.#o,1)}};function fi(o,e,t,s,n){let r=e+s,i=new Float32Array(n*r);for(let a=0;a<n;a++){for(let c=0;c<e;c++)i[a*r+c]=o[a*e+c];for(let c=0;c<s;c++)i[a*r+e+c]=t[c*n+a]}return i}function Fe(o,e){for(let t=0;t<e.length;t++)o.fill(e[t],t*x,(t+1)*x)}var hi=1/3,di=[1,0,0,0],ge=class{#e;#t=new dt;#o;#n;#s;#r;#i;#a;#c;#l;#f;constructor(e){let{header:t,samples:s}=e,{lobes:n,grid:r}=t,i=this.#t;this.#e=e;let a=n?.degree??0,c=i.block(Hn),l={logScales:i.block(3),scales:i.block(3),quats:i.block(4),sh:i.part(c,0,12),lobes:i.block(2*(a+1)**2+2),statics:i.block(t.network?19:0),words:i.block(18)};this.#o=l.quats,this.#s=n&&new yt(i,l,l.lobes,n,e.lobes),this.#r=t.network?new de(i,l,l.statics):null;let{appearance:f}=e;t.colors==="linear"?this.#n=new bt(i,c,f):t.colors==="latent_networks"?this.#n=new vt(i,c,f):this.#n=new xt(i,c,f,r.exponent),i.allocate(),this.#c=Object.fromEntries([...e.books].map(([p,u])=>[p,{...u,columns:[]}])),this.#l=Wn(this.#h("scale")),this.#f=Wn(Le(this.#h("scale")));let h=Object.fromEntries(Object.entries(l).map(([p,{numbers:u}])=>[p,u])),d=pi(this.#l);this.#i={...h,count:0,lobeDegree:a,scaleRange:d,memory:i.wasmMemory},this.#a={sh:this.#d(s),lobes:[0,1/Et]},this.#s&&(this.#a.lobes=this.#u(this.#s))}#d(e){let{sh:t}=this.#i,s=new Float64Array(12),n=Le(this.#h("appearance"));for(let r=0;r<e.length;r+=3*x){let i=e.subarray(r,r+3*x);this.#n.decode(i,n,0);for(let a=0;a<12;a++)for(let c=0;3*c<i.length;c++)s[a]+=3*t[a*x+c]/e.length}return s}#u(e){let{scales:t,quats:s,sh:n,lobes:r}=this.#i,i=this.#c.lobes;return P(this.#f,t,x,0,x),Fe(s,di),Fe(n,this.#a.sh),e.decode(i?Le(i):null,0,x),Array.from({length:r.length/x-2},(a,c)=>r[c*x])}decode({positions:e,columns:t},s=0){let{header:n}=this.#e,r=e.subarray(3*s,3*(s+x)),i=r.length/3,a=s+i,[c,l]=[this.#i,this.#c];c.count=i,c.positions=r;let{logScales:f,scales:h,quats:d,sh:p,lobes:u}=c,{scale:m,rotation:w,appearance:v}=t,_=!0;for(let b of Object.keys(l)){let k=t[b];k?this.#h(b).columns=k:_=!1}this.#l.columns=m,P(this.#h("scale"),f,x,s,a),P(this.#l,h,x,s,a);let E=n.scalars.get("rotation");if(E?Pn(E,w,s,a,d):(P(this.#h("rotation"),d,x,s,a),this.#t.units(this.#o,this.#o)),v?this.#n.decode(r,this.#h("appearance"),s):Fe(p,this.#a.sh),this.#s&&_?this.#s.decode(l.lobes??null,s,a):Fe(u,this.#a.lobes),l.opacity){let{books:[b]}=t.opacity?l.opacity:Le(l.opacity),k=t.opacity?.[0];ui(u,b,k,s,i)}return this.#r?.write(),c}get network(){return this.#r!==null}get lobeDegree(){return this.#i.lobeDegree}get scaleRange(){return this.#i.scaleRange}get neutral(){let e=[0,1,2].map(r=>.5+Et*this.#a.sh[r]),[t,s,n]=this.#f.books.map(([r])=>r);return{color:e,side:hi*Math.cbrt(t*s*n)}}#h(e){return this.#c[e]}};function ui(o,e,t,s,n){for(let r=0;r<n;r++)o[r]+=e[t?t[s+r]:0]/Et}function Wn(o){return{...o,books:o.books.map(e=>e.map(Math.exp))}}function pi({books:o}){let e=[1/0,-1/0];for(let t of o)for(let s of t)e=[Math.min(e[0],s),Math.max(e[1],s)];return e}var{fround:F}=Math,mi=["mobile_gs","no_depth","no_scale","sort_free_gs"],wi=W(-1e4),gi=[2047,2047,1023],Vn=F(511/Math.SQRT1_2),jn=888,ze=new Uint32Array(1),_t=new Float32Array(ze.buffer);function Xn({sorted:o,weighting:e,footprint:t,background:s,grid:n,lobes:r},i,a,c=null){let l=r?.degree??0,[f,h]=Yn(a);return{count:i,packing:{center:Array.from(n.center),unit:n.radius*2**n.exponent,leastScaleBits:f,scaleBitsSpan:h},...Kn(c?10:Qn(l),i),network:c&&Vs(c),shSize:4,lobeSize:(l+1)**2,sorted:o,weighting:{index:mi.indexOf(e.name),exponentMax:e.exponent_max,sigma:e.sigma,backgroundWeight:e.background_weight,alphaMin:e.alpha_min},footprint:t,background:Array.from(s)}}function kt(o,e,t=Kn(ls(o),e.positions.length/3)){let s=e.positions.length/3,n=ls(o),r=4*x,i;for(let a=0;a<s;a+=x){let c=o.decode(e,a);i??=bi(c);let l=i();t.shapes.set(l.subarray(0,4*c.count),4*a),t.colors.set(l.subarray(r,r+4*c.count),4*a),t.lobes.set(l.subarray(2*r,2*r+n*c.count),n*a)}return t}var Kn=(o,e)=>({shapes:new Uint32Array(4*e),colors:new Uint32Array(4*e),lobes:new Uint32Array(o*e)});function Yn(o){let[e,t]=o.map(s=>(_t[0]=s,F(ze[0])));return[e,t-e]}var Qn=o=>(o+1)**2+2>>1,ls=({network:o,lobeDegree:e})=>o?10:Qn(e);function bi(o,e=!1){let{scales:t,quats:s,sh:n,lobes:r,lobeDegree:i,statics:a,scaleRange:c,memory:l}=o,{buffer:f,byteOffset:h,length:d}=o.words,p=new Uint32Array(f,h,d),[u,m]=Yn(c),w=m>0?F(1/m):0,v=e?null:le(l),[_,E,b,k]=[t,s,n,r].map(({byteOffset:Y})=>Y),S=a.length>0,[z,K]=[(i+1)**2-1,ls({network:S,lobeDegree:i})];return()=>{v?v.pack(_,E,b,k,h,z,K,u,w):vi(o,p,K,u,w),S&&xi(a,p);let{count:Y,positions:R}=o;for(let $=0,Q=0;$<Y;$++,Q+=4)p[Q]=R[3*$]|R[3*$+1]<<16,p[Q+1]|=R[3*$+2];return p}}function vi({scales:o,quats:e,sh:t,lobes:s,lobeDegree:n},r,i,a,c){let l=2*(n+1)**2;for(let f=0;f<x;f++){let h=8*x+i*f,d=_i(s,f,l,r,h);Ei(t,f,r,4*(x+f)),r[4*f+1]=d<<16;let p=0;for(let m=2;m>=0;m--){_t[0]=o[m*x+f];let w=F(F(F(ze[0])-a)*c);p=p<<11|F(F(gi[m]*Math.min(Math.max(w,0),1))+.5)}r[4*f+2]=p;let u=[0,1,2,3].map(m=>e[m*x+f]);r[4*f+3]=yi(u),u.some(Boolean)||(r[h]=wi|r[h]&4294901760)}}function xi(o,e){for(let t=0;t<x;t++){let s=8*x+10*t;e[s]=e[s]&65535|Math.round(32767*o[t])<<16;for(let n=1;n<10;n++){let[r,i]=[2*n-1,2*n].map(a=>Math.round(32767*o[a*x+t]));e[s+n]=r&65535|i<<16}}}function yi(o){let e=0;for(let n=1;n<4;n++)Math.abs(o[n])>Math.abs(o[e])&&(e=n);let t=o[e]<0?-Vn:Vn,s=e;for(let n=0;n<4;n++)n!==e&&(s=s<<10|F(F(t*o[n])+1024.5)&1023);return s}function Ei(o,e,t,s){let n=c=>o[c*x+e],r=Array.from({length:9},(c,l)=>n(3+l)),i=eo(r),a=r.map(c=>Jn(i,c));t[s]=W(n(0))|W(n(1))<<16,t[s+1]=W(n(2))|i<<16|a[0]<<24;for(let c of[1,5])t[s+1+(c+3>>2)]=Zn(a,c)}function _i(o,e,t,s,n){let r=f=>o[f*x+e],i=Array.from({length:t-2},(f,h)=>r(2+h)),[a,c]=[0,1].map(f=>eo(i.filter((h,d)=>d%2===f))),l=i.map((f,h)=>Jn(h%2?c:a,f));s[n]=W(r(0))|W(r(1))<<16;for(let f=0,h=n+1;f<l.length;f+=4,h++)s[h]=Zn(l,f);return a|c<<8}var Zn=(o,e)=>o[e]|o[e+1]<<8|o[e+2]<<16|o[e+3]<<24;function Jn(o,e){ze[0]=o+jn<<20;let t=F(F(127/_t[0])*e);return F(Math.min(Math.max(t,-127),127)+512.5)&255}function eo(o){return _t[0]=Math.max(0,...o.map(Math.abs)),Math.min(Math.max((ze[0]+1048575>>20)-jn,0),255)}var to=8192,ki=1e5,Ai=3,Si=2,Ti=8,At=class{results=[];#e=[];#t;#o=null;#n=null;#s=[];#r;#i=null;#a;#c;#l=!1;#f=!1;#d=()=>{};#u=()=>{};#h=new Promise((e,t)=>{this.#d=e,this.#u=t});constructor(e){this.#h.catch(()=>{});let t=0;for(let[s,n]of e.entries()){for(let r=0;r<n;r+=to)this.#e.push({level:s,from:r,to:Math.min(r+to,n),first:t+r});t+=n}this.#t=new Uint8Array(e.length),this.#a=new Uint8Array(this.#e.length),this.#c=this.#a.slice(),this.#r=t}set output(e){if(this.#i=e,e!==null)for(let[t,s]of this.results.splice(0))no(s,so(e,this.#r,t,t+s.shapes.length/4))}spawn(){let{decoderInputs:e}=this.#o,t=this.#r<ki?1:navigator.hardwareConcurrency;for(let s=1;s<Math.min(t,Ai+1);s++)this.#b(e)}#b(e){try{let t=Rt();t.postMessage({decoderInputs:e});let s={worker:t,jobs:0};t.onmessage=({data:n})=>{s.jobs--,this.#E(n),this.#k(s)},t.onerror=n=>n.preventDefault(),this.#s.push(s)}catch{}}start(e){return this.#o=e,this.#n=new ge(e.decoderInputs)}advance(e,t){if(!(t<=this.#t[e])){this.#t[e]=t;for(let s of this.#s)this.#k(s);this.#y().catch(this.#u)}}finish(){return this.#f=!0,this.#_(),this.#h}terminate(){for(let{worker:e}of this.#s)e.terminate()}get#w(){return this.#a.findIndex((e,t)=>e<this.#v(t))}get#g(){let e=this.#w;return e<0?this.#c.findIndex((t,s)=>t<this.#v(s)):e}#v(e){return this.#t[this.#e[e].level]}#p(e,t){let{levels:s}=this.#o,{level:n,from:r,to:i}=this.#e[e];return s[n].rows(r,i,t)}#x(e){let{first:t,from:s,to:n}=this.#e[e];return this.#i?so(this.#i,this.#r,t,t+n-s):void 0}#k(e){for(let t;e.jobs<Si&&(t=this.#w)>=0;e.jobs++){let s=this.#a[t]=this.#v(t),n=this.#p(t,"slice"),r=[n.positions,...Object.values(n.columns).flat()].map(({buffer:i})=>i);e.worker.postMessage({rows:n,chunk:t,stage:s},{transfer:r})}}async#y(){if(!this.#l){this.#l=!0;for(let e;(e=this.#g)>=0&&this.#n;){let t=this.#a[e]=this.#v(e),s=kt(this.#n,this.#p(e,"subarray"),this.#x(e));this.#E({chunk:e,stage:t,packed:s}),await fs()}this.#l=!1}}#E({chunk:e,stage:t,packed:s}){if(t<=this.#c[e])return;this.#c[e]=t;let n=this.#x(e);n===void 0?this.results.push([this.#e[e].first,s]):n.shapes.buffer!==s.shapes.buffer&&no(s,n),this.#_()}get firstLevelReady(){return this.#e.every(({level:e},t)=>e>0||this.#c[t]>0)}get levels(){let e=this.#c.findIndex(t=>t<Oe);return e<0?this.#t.length:this.#e[e].level}#_(){this.#f&&this.#g<0&&this.#d()}};function so(o,e,t,s){let n=r=>{let i=o[r].length/e;return o[r].subarray(i*t,i*s)};return{shapes:n("shapes"),colors:n("colors"),lobes:n("lobes")}}function no(o,e){for(let t of Object.keys(e))e[t].set(o[t])}var oo=0;async function fs(){if(performance.now()-oo<Ti)return;let{port1:o,port2:e}=new MessageChannel;await new Promise(t=>{o.onmessage=()=>{o.close(),t(null)},e.postMessage(null)}),oo=performance.now()}var Mi=.28209479177387814,[Ri,Li]=[13.8,-69],Oi=new Map([["char",1],["int8",1],["uchar",1],["uint8",1],["short",2],["int16",2],["ushort",2],["uint16",2],["int",4],["int32",4],["uint",4],["uint32",4],["float",4],["float32",4],["double",8],["float64",8]]),ro=["x","y","z","f_dc_0","f_dc_1","f_dc_2","opacity","scale_0","scale_1"];ro.push("scale_2","rot_0","rot_1","rot_2","rot_3");function ds(o){return o[0]===112&&o[1]===108&&o[2]===121}function io(o){let{offsets:e,stride:t,rows:s,start:n}=Fi(o),r=new DataView(o.buffer,o.byteOffset+n),i=[...e.keys()].filter(m=>m.startsWith("f_rest_")).length,a=i/3+1;if(![1,4,9,16].includes(a))throw new Error(`the .ply file has ${i} numbers f_rest_*: 0, 9, 24 or 45 were expected`);let c=m=>e.get(m),l=["x","y","z","scale_0","scale_1","scale_2","rot_0","rot_1","rot_2","rot_3"];l.push("opacity","f_dc_0","f_dc_1","f_dc_2");for(let m=0;m+1<a;m++)for(let w=0;w<3;w++)l.push(`f_rest_${w*(a-1)+m}`);let f=l.find(m=>!e.has(m));if(f)throw new Error(`the .ply file has ${i} numbers f_rest_*, but not ${f}`);let h=l.map(c),d=us(s,a),p=new Float32Array(h.length);for(let m=0;m<s;m++){for(let v=0;v<p.length;v++)p[v]=r.getFloat32(m*t+h[v],!0);for(let v=3;v<6;v++)p[v]===-1/0&&(p[v]=Li);Math.abs(p[10])===1/0&&(p[10]=Math.sign(p[10])*Ri);let w=0;for(let v=0;v<p.length;v++)w+=p[v]*0;w===0&&ps(d,p)}let{count:u}=d;return u===s||(d.shapes=d.shapes.slice(0,12*u),d.colors=d.colors.slice(0,3*a*u),d.lobes=d.lobes.slice(0,2*u)),d}function hs(o=""){return`'${o.slice(0,40).replace(/[^\x20-\x7e]/g,"\uFFFD")}'`}function us(o,e){return{count:0,packing:null,shapes:new Float32Array(12*o),colors:new Float32Array(3*e*o),shSize:e,lobes:new Float32Array(2*o),lobeSize:1,sorted:!0,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},background:[0,0,0]}}function ps(o,e){let[t,s,n,r]=[e[6],e[7],e[8],e[9]],i=t*t+s*s+n*n+r*r;if(!(i>0))return;let a=2/i,[c,l,f]=[Math.exp(e[3]),Math.exp(e[4]),Math.exp(e[5])];if(!(c+l+f<1e30&&Math.abs(e[10])<1e30))return;let h=o.count++;o.shapes.set([c*(1-a*(n*n+r*r)),c*a*(s*n+t*r),c*a*(s*r-t*n),e[0],l*a*(s*n-t*r),l*(1-a*(s*s+r*r)),l*a*(n*r+t*s),e[1],f*a*(s*r+t*n),f*a*(n*r-t*s),f*(1-a*(s*s+n*n)),e[2]],12*h),o.lobes[2*h]=e[10]/Mi,o.colors.set(e.subarray(11),3*o.shSize*h)}function Fi(o){let e=new TextDecoder("latin1").decode(o.subarray(0,65536)),t=/\nend_header\r?\n/.exec(e);if(!ds(o)||t===null)throw new Error("this is not a PLY file, or its header is cut off");let s=e.slice(0,t.index).split(/\r?\n/).map(d=>d.trim().split(/\s+/)),n=s.find(d=>d[0]==="format")?.[1];if(n!=="binary_little_endian")throw new Error(`the .ply file is ${hs(n)}: only binary_little_endian is read`);let r=s.findIndex(d=>d[0]==="element"),i=s[r]??[],a=/^\d+$/.test(i[2])?Number(i[2]):NaN;if(i[1]!=="vertex"||!Number.isSafeInteger(a)||a<0)throw new Error("the .ply file does not begin with its vertices, as those of 3DGS do");let c=new Map,l=0;for(let d of s.slice(r+1)){if(d[0]==="element")break;if(d[0]!=="property")continue;let p=Oi.get(d[1]);if(p===void 0)throw new Error(`the .ply file has a property of type ${hs(d[1])}`);if(d.length!==3)throw new Error("the .ply file has a property without a name, or with two");if(c.has(d[2]))throw new Error(`the .ply file has the property ${hs(d[2])} twice`);(d[1]==="float"||d[1]==="float32")&&c.set(d[2],l),l+=p}let f=ro.filter(d=>!c.has(d));if(f.length)throw new Error(`the .ply file is not a Gaussian scene: it lacks ${f.join(", ")} as floats`);let h=t.index+t[0].length;if(h+a*l>o.length)throw new Error(`the .ply file is cut off: ${a} Gaussians were announced`);return{offsets:c,stride:l,rows:a,start:h}}var B="the compressed data is damaged or cut off";var ie=class{left;#e;constructor(e){let t=e[e.length-1];if(!t)throw new Error(B);this.#e=e,this.left=8*e.length-1-Math.clz32(t)+24}take(e){return e>24?this.take(e-16)*65536+this.take(16):(this.left-=e,this.#t(this.left,e))}decode(e,{width:t,symbols:s,bits:n}){for(let r=0;r<e.length;r++){let i=this.#t(this.left-t,t);e[r]=s[i],this.left-=n[i]}if(this.left!==0)throw new Error(B)}#t(e,t){let s=this.#e;if(e<0)return e+t>0?this.#t(0,e+t)<<-e:0;let n=e>>3;return(s[n]|s[n+1]<<8|s[n+2]<<16|s[n+3]<<24)>>>(e&7)&(1<<t)-1}};function ao(o){let e=new Uint8Array(1);return{accuracy:0,symbols:Uint8Array.of(o),bits:e,bases:new Uint16Array(1)}}function Ue(o,e){let t=1<<o,s={accuracy:o,symbols:new Uint8Array(t),bits:new Uint8Array(t),bases:new Uint16Array(t)},n=t;for(let[c,l]of e.entries())l===-1&&(s.symbols[--n]=c);let r=(t>>1)+(t>>3)+3,i=0;for(let[c,l]of e.entries())for(let f=0;f<l;f++){s.symbols[i]=c;do i=i+r&t-1;while(i>=n)}if(i!==0)throw new Error(B);let a=e.map(c=>Math.abs(c));for(let c=0;c<t;c++){let l=a[s.symbols[c]]++,f=o-(31-Math.clz32(l));s.bits[c]=f,s.bases[c]=(l<<f)-t}return s}function ms(o,e,t,s){let n=8*e,r=l=>{let f=n>>3,d=(o[f]|o[f+1]<<8|o[f+2]<<16)>>(n&7)&(1<<l)-1;return n+=l,d},i=5+r(4);if(i>t)throw new Error(B);let a=[];for(let l=1<<i;l>0;){let f=32-Math.clz32(l+1),h=(1<<f)-2-l,d=r(f-1);d>=h&&r(1)&&(d+=(1<<f-1)-h);let p=d-1;l-=Math.abs(p),a.push(p);for(let u=p===0?3:0;u===3;){u=r(2);for(let m=0;m<u;m++)a.push(0)}if(l<0||a.length>s)throw new Error(B)}let c=n+7>>3;if(c>o.length)throw new Error(B);return{table:Ue(i,a),end:c}}function co(o,e){let t=o[e++];if(!(t<128)){let l=t-127,f=e+(l+1>>1);if(!(f<=o.length))throw new Error(B);let h=d=>o[e+(d>>1)]>>(d%2?0:4)&15;return{weights:Array.from({length:l},(d,p)=>h(p)),end:f}}let s=e+t;if(s>o.length)throw new Error(B);let{table:n,end:r}=ms(o.subarray(0,s),e,6,13),i=new ie(o.subarray(r,s)),a=[],c=[i.take(n.accuracy),i.take(n.accuracy)];for(let l=0;a.length<255;l^=1){let f=c[l];if(a.push(n.symbols[f]),c[l]=n.bases[f]+i.take(n.bits[f]),i.left<0)return a.push(n.symbols[c[l^1]]),{weights:a,end:s}}throw new Error(B)}function lo(o){let e=c=>c>0?1<<c-1:0,t=0;for(let c of o)t+=e(c);let s=32-Math.clz32(t),n=(1<<s)-t;if(t===0||s>11||n&n-1)throw new Error(B);let r=[...o,32-Math.clz32(n)];if(r.length>256)throw new Error(B);let i={width:s,symbols:new Uint8Array(1<<s),bits:new Uint8Array(1<<s)},a=0;for(let c=1;c<=s;c++)for(let[l,f]of r.entries()){if(f!==c)continue;let h=a+e(c);i.symbols.fill(l,a,h),i.bits.fill(s+1-c,a,h),a=h}return i}var zi=4247762216,Ui=25481893,Ie=1<<17,M="the compressed data is damaged or cut off";function uo(o,e){let t=[];for(let s of e)t.push(o),o+=2**s;return{bits:e,bases:t}}var fo=uo(0,[...Array(16).fill(0),1,1,1,1,2,2,3,3,4,6,7,8,9,10,11,12,13,14,15,16]),ho=uo(3,[...Array(32).fill(0),1,1,1,1,2,2,3,3,4,4,5,7,8,9,10,11,12,13,14,15,16]),Ii=[{accuracy:9,symbols:36,usual:Ue(6,[4,3,2,2,2,2,2,2,2,2,2,2,2,1,1,1,2,2,2,2,2,2,2,2,2,3,2,1,1,1,1,1,-1,-1,-1,-1])},{accuracy:8,symbols:32,usual:Ue(5,[1,1,1,1,1,1,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1])},{accuracy:9,symbols:53,usual:Ue(6,[1,4,3,2,2,2,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1,-1,-1])}],ws=class{length=0;bytes;#e;constructor(e){this.#e=e,this.bytes=new Uint8Array(Math.min(e,Ie))}reserve(e){let t=this.length+e;if(t>this.#e)throw new Error("the compressed data is longer than announced");if(t<=this.bytes.length)return;let s=new Uint8Array(Math.min(this.#e,Math.max(t,2*this.bytes.length)));s.set(this.bytes.subarray(0,this.length)),this.bytes=s}append(e){this.reserve(e.length),this.bytes.set(e,this.length),this.length+=e.length}fill(e,t){this.reserve(t),this.bytes.fill(e,this.length,this.length+t),this.length+=t}repeat(e,t){if(!(e>0&&e<=this.length))throw new Error(M);this.reserve(t);let{bytes:s}=this,n=this.length+t;if(e>=t)s.copyWithin(this.length,this.length-e,n-e);else for(let r=this.length;r<n;r++)s[r]=s[r-e];this.length=n}};function po(o,e){let t=new ws(e),s=new DataView(o.buffer,o.byteOffset,o.byteLength),n=0;for(;n<o.length;){if(n+8>o.length)throw new Error(M);let r=s.getUint32(n,!0);if(r>>>4===Ui)n+=8+s.getUint32(n+4,!0);else if(r===zi)n=Ni(o,n+4,t);else throw new Error(M)}if(n!==o.length||t.length!==e)throw new Error(M);return t.bytes}function Ni(o,e,t){let s=o[e++],n=(s&32)!==0;if(n||(e+=1),o.subarray(e,e+=[0,1,2,4][s&3]).some(a=>a))throw new Error("the compressed data needs a dictionary, which is missing");e+=[n?1:0,2,4,8][s>>6];let i={huffman:null,tables:[null,null,null],recent:[1,4,8]};for(let a=!1;!a;){if(e+3>o.length)throw new Error(M);let c=o[e]|o[e+1]<<8|o[e+2]<<16;e+=3,a=(c&1)===1;let l=c>>1&3,f=c>>3,h=l===1?1:f;if(l===3||f>Ie||e+h>o.length)throw new Error(M);l===0?t.append(o.subarray(e,e+f)):l===1?t.fill(o[e],f):Ci(o.subarray(e,e+f),i,t),e+=h}return e+(s&4?4:0)}function Ci(o,e,t){let{literals:s,end:n}=Bi(o,e),r=n,i=o[r++];if(i===void 0)throw new Error(M);if(i===255?(i=o[r]+(o[r+1]<<8)+32512,r+=2):i>127&&(i=(i-128<<8)+o[r++]),i===0){t.append(s);return}let a=o[r++];if(!(i>0)||a===void 0||a&3)throw new Error(M);for(let[c,{accuracy:l,symbols:f,usual:h}]of Ii.entries()){let d=a>>6-2*c&3;if(d===0)e.tables[c]=h;else if(d===1){if(!(o[r]<f))throw new Error(M);e.tables[c]=ao(o[r++])}else if(d===2){let{table:p,end:u}=ms(o,r,l,f);e.tables[c]=p,r=u}}Di(new ie(o.subarray(r)),i,s,e,t)}function Di(o,e,t,{tables:s,recent:n},r){let[i,a,c]=s;if(!i||!a||!c)throw new Error(M);let l=o.take(i.accuracy),f=o.take(a.accuracy),h=o.take(c.accuracy),d=0,p=r.length+Ie;for(let u=e;u>0;u--){let m=a.symbols[f],w=c.symbols[h],v=i.symbols[l],_=2**m+o.take(m),E=ho.bases[w]+o.take(ho.bits[w]),b=fo.bases[v]+o.take(fo.bits[v]);if(u>1&&(l=i.bases[l]+o.take(i.bits[l]),h=c.bases[h]+o.take(c.bits[h]),f=a.bases[f]+o.take(a.bits[f])),o.left<0||d+b>t.length)throw new Error(M);if(r.append(t.subarray(d,d+b)),d+=b,r.repeat(Pi(_,b,n),E),r.length>p)throw new Error(M)}if(o.left!==0)throw new Error(M);r.append(t.subarray(d))}function Pi(o,e,t){if(o>3)return t.unshift(o-3),t.pop(),t[0];let s=e===0?o:o-1,n=s<3?t[s]:t[0]-1;return s>0&&(t.splice(Math.min(s,2),1),t.unshift(n)),n}function Bi(o,e){let t=o[0]|o[1]<<8|o[2]<<16,s=o[0]&3,n=o[0]>>2&3;if(s<2){let d=[1,2,1,3][n],p=d===1?o[0]>>3:(t&(d===2?65535:16777215))>>4,u=d+(s===0?p:1);if(p>Ie||!(u<=o.length))throw new Error(M);return s===0?{literals:o.subarray(d,u),end:u}:{literals:new Uint8Array(p).fill(o[d]),end:u}}let r=[3,3,4,5][n],i=[10,10,14,18][n],a=(t>>>0)+(o[3]??0)*2**24+(o[4]??0)*2**32,c=Math.floor(a/16)%2**i,l=Math.floor(a/2**(4+i))%2**i,f=r+l;if(c>Ie||!(f<=o.length))throw new Error(M);let h=r;if(s===2){let{weights:d,end:p}=co(o.subarray(0,f),h);e.huffman=lo(d),h=p}if(e.huffman===null)throw new Error(M);return{literals:$i(o.subarray(h,f),c,n!==0,e.huffman),end:f}}function $i(o,e,t,s){let n=new Uint8Array(e);if(!t)return new ie(o).decode(n,s),n;if(o.length<6)throw new Error(M);let r=e+3>>2;for(let i=0,a=6;i<4;i++){let c=i<3?o[2*i]|o[2*i+1]<<8:o.length-a;if(a+c>o.length)throw new Error(M);let l=i<3?(i+1)*r:e;if(l>e)throw new Error(M);new ie(o.subarray(a,a+c)).decode(n.subarray(i*r,l),s),a+=c}return n}var Gi=1347635022,qi=1e7,St=16,wo=32,go=[0,3,8,15,24],Hi=15,Wi=.15,Vi=[-1,-1,1,-1,1,1,-1,1,-1,1,-1,-1,1,-1,1],ae="the .spz file is damaged or cut off";function bo(o){return o[0]===78&&o[1]===71&&o[2]===83&&o[3]===80||o[0]===31&&o[1]===139}async function vo(o){if(o[0]!==31){let r=xo(o,o.length);return mo(r,Xi(r,o))}let{header:e,content:t}=await ji(o),s=[],n=St;for(let r of gs(e))s.push(t.subarray(n,n+=r));return mo(e,s)}function xo(o,e){let t=new DataView(o.buffer,o.byteOffset,o.byteLength);if(o.length<St||t.getUint32(0,!0)!==Gi)throw new Error("this is not a .spz file");let s=t.getUint32(4,!0),n=s<4;if(s<1||s>4)throw new Error(`the .spz file has version ${s}: 1 to 4 are read`);if(!n&&o.length<wo)throw new Error(ae);let r=t.getUint32(8,!0),[i,a,c,l]=o.subarray(12,16);if(r>qi)throw new Error(`the .spz file announces ${r} Gaussians, too many to be drawn`);if(r>e)throw new Error(`the .spz file announces ${r} Gaussians in ${e} bytes: it is cut off`);if(i>4||a>24)throw new Error(ae);let f=(c&2)!==0;return{version:s,count:r,degree:i,fraction:a,extended:f,streams:l,table:n?0:t.getUint32(16,!0)}}function gs({version:o,count:e,degree:t}){return[o===1?6:9,1,3,3,o<3?3:4,3*go[t]].map(s=>s*e)}async function ji(o){let t=new Response(o).body.pipeThrough(new DecompressionStream("gzip")).getReader(),s=[],n=0,r=null,i=1/0,a=async()=>new Uint8Array(await new Blob(s).arrayBuffer());for(;n<=i;){let{value:c,done:l}=await t.read().catch(()=>{throw new Error(ae)});if(l)break;if(s.push(c),n+=c.length,r===null&&n>=St){if(r=xo(await a(),o.length),r.version>3)throw new Error("this is not a .spz file");i=gs(r).reduce((f,h)=>f+h,St)}}if(r===null)throw new Error("this is not a .spz file");if(n>i&&(await t.cancel().catch(()=>{}),!r.extended))throw new Error("the .spz file holds more than it announces");if(n<i)throw new Error(`the .spz file is cut off: ${r.count} Gaussians were announced`);return{header:r,content:await a()}}function Xi(o,e){let{streams:t,table:s,version:n}=o,r=gs(o),i=s+16*t,a=r.filter(h=>h>0).length;if(n!==4||s<wo||i>e.length||t!==a)throw new Error(ae);let c=new DataView(e.buffer,e.byteOffset,e.byteLength),[l,f]=[s,i];return r.map(h=>{if(h===0)return new Uint8Array(0);let d=Number(c.getBigUint64(l,!0)),p=Number(c.getBigUint64(l+8,!0));if(l+=16,f+d>e.length||p!==h)throw new Error(ae);let u=e.subarray(f,f+=d);try{return po(u,h)}catch(m){throw new Error(`${ae}: ${m instanceof Error?m.message:m}`)}})}function mo({version:o,count:e,degree:t,fraction:s},n){let[r,i,a,c,l,f]=n,h=go[t],d=Math.min(h,Hi),p=d+1,u=us(e,p),m=new Float32Array(11+3*p),w=o===1?Yi(r):Ki(r,2**-s),v=o<3?Qi:Zi;for(let _=0;_<e;_++){m[0]=w(3*_),m[1]=-w(3*_+1),m[2]=-w(3*_+2);for(let b=0;b<3;b++)m[3+b]=c[3*_+b]/16-10;v(l,_,m);let E=Math.min(Math.max(i[_]/255,1e-6),1-1e-6);m[10]=Math.log(E/(1-E));for(let b=0;b<3;b++)m[11+b]=(a[3*_+b]/255-.5)/Wi;for(let b=0;b<d;b++)for(let k=0;k<3;k++)m[14+3*b+k]=Vi[b]*(f[3*(h*_+b)+k]-128)/128;ps(u,m)}return u}function Ki(o,e){return t=>{let s=3*t;return e*((o[s]<<8|o[s+1]<<16|o[s+2]<<24)>>8)}}function Yi(o){return e=>{let t=U(o[2*e]|o[2*e+1]<<8);if(!Number.isFinite(t))throw new Error(ae);return t}}function Qi(o,e,t){let[s,n,r]=[0,1,2].map(a=>o[3*e+a]/127.5-1),i=Math.sqrt(Math.max(0,1-s*s-n*n-r*r));t.set([i,s,-n,-r],6)}function Zi(o,e,t){let s=4*e,n=o[s]|o[s+1]<<8|o[s+2]<<16|o[s+3]<<24,r=n>>>30,i=[0,0,0,0],a=1;for(let c=0,l=20;c<4;c++){if(c===r)continue;let f=(n>>l&511)/511*Math.SQRT1_2;i[c]=n>>l+9&1?-f:f,a-=f*f,l-=10}i[r]=Math.sqrt(Math.max(0,a)),t.set([i[3],i[0],-i[1],-i[2]],6)}var Ji=8192,ea=.2,ta=2**20,yo=1500,sa=8,Ao=["shapes","colors","lobes"],be=new Float32Array(0),H=(o,e=[])=>self.postMessage(o,{transfer:e}),So=({shapes:o,colors:e,lobes:t})=>[o.buffer,e.buffer,t.buffer];async function na(o){if("file"in o)return{source:o.file.stream(),total:o.file.size};let e;try{e=await fetch(o.url)}catch{throw new Error(`${o.url} cannot be reached: is the address right, the network there, and may this site load it (CORS)?`)}if(!e.ok||e.body===null)throw new Error(`${o.url} could not be loaded: the server says ${e.status}`);let t=e.headers.has("Content-Encoding")?NaN:Number(e.headers.get("Content-Length"));return{source:e.body,total:t||NaN}}var bs=class{#e;#t;#o;#n;#s;#r=0;#i=null;#a=!1;constructor(e,t,s,n,r){this.#e=e,this.#s=r,this.#t=t,this.#o=s,this.#n=n;let{grid:i,views:a,near:c}=e,l=Array.from(e.background),{color:f,side:h}=n.neutral,d=zt(Cs(t[0].positions,Ji),i),p=h*Math.sqrt(3*e.count/d.length),u={means:d,color:f,side:p,background:l};H({kind:"dots",dots:u,views:a,near:c},[u.means.buffer])}send(e){if(!this.#o.firstLevelReady||!this.allocate(e))return;let t=this.#o.levels,s=this.#r;this.#r=Math.max(t,1);let n=this.#o.results.splice(0),r=this.#i;if(r){this.#i=this.#o.output=null;let{views:i,near:a}=this.#e;H({kind:"scene",data:r,means:this.#c(),views:i,near:a},So(r));return}for(let[i,a]of n)for(let c of Ao){let l=a[c];H({kind:"rows",part:c,from:i,numbers:l},[l.buffer])}s!==this.#r&&H({kind:"more",means:this.#c()})}allocate(e){let{count:t}=this.#e;return!this.#a&&sa*e>=t&&(this.#i=this.#o.output=Xn(this.#e,t,this.#n.scaleRange,this.#s),this.#a=!0),this.#a}#c(){let e=this.#t.slice(0,this.#r),t=new Uint16Array(e.reduce((r,{count:i})=>r+3*i,0)),s=0;for(let{positions:r,count:i}of e)t.set(r,s),s+=3*i;let n={stored:t,grid:this.#e.grid};return this.#e.sorted&&(be=We(n)),n}};async function oa(o){let e=null,t=null,[s,n]=[0,0],r=[],i=async({header:a,decoder:c,received:l,total:f},h)=>{if(H({kind:"progress",received:l,total:f}),a===null||c===null)return;n=l,e??=new At(a.lodSizes);let d=r=c.levels,p=h*(f/l-1)>yo;d[0].positions&&!t&&(t=new bs(a,d,e,e.start(c),c.network),e.spawn(),s=setInterval(()=>t?.send(n),yo)),t?.allocate(l);for(let[u,{stage:m}]of d.entries())t&&(m===ts||p&&u===0&&m>=Oe)&&e.advance(u,m);await fs()};try{await qn(o,i)}finally{for(let[a,{stage:c,positions:l}]of r.entries())t&&l&&c>=Oe&&e?.advance(a,c);await e?.finish().finally(()=>{clearInterval(s),e?.terminate()}),t?.send(n)}return n}async function Eo(o,e,t){let[s,n]=[new Uint8Array(e||ta),0],r=o.getReader();for(let a;!(a=await r.read()).done;){let c=n+a.value.length;if(c>s.length){let l=s;s=new Uint8Array(Math.max(c,2*s.length)),s.set(l)}s.set(a.value,n),n=c,H({kind:"progress",received:n,total:e})}let i=await t(s.subarray(0,n));if(!i.count)throw new Error("there is no Gaussian in this file that can be drawn");be=new Float32Array(3*i.count);for(let a=0;a<be.length;a++)be[a]=i.shapes[4*a+3];return H({kind:"scene",data:i,means:be,views:[],near:ea},So(i)),n}async function ra(o){let e=o.getReader(),t=()=>e.read().catch(()=>{throw new Error("the file broke off before its end: load it again")}),s=await t(),n=s?.value??new Uint8Array(0),r=new ReadableStream({async pull(i){let{value:a,done:c}=s??await t();s=null,c?i.close():i.enqueue(a)},cancel:()=>e.cancel()});return{first:n,whole:r}}async function _o(o){let e=performance.now();try{let{source:t,total:s}=await na(o),{first:n,whole:r}=await ra(t),i;ds(n)?i=await Eo(r,s,io):bo(n)?i=await Eo(r,s,vo):i=await oa(r),H({kind:"done",milliseconds:performance.now()-e,bytes:i})}catch(t){let{message:s}=t,n=t instanceof RangeError?`the scene is too large for this device: ${s}`:s;H({kind:"failed",sentence:n})}}var ko;function To(){self.onmessage=async({data:o})=>{if("decoderInputs"in o){ko=new ge(o.decoderInputs);return}if("rows"in o){let{rows:e,chunk:t,stage:s}=o,n=kt(ko,e),r=Ao.map(i=>n[i].buffer);self.postMessage({chunk:t,stage:s,packed:n},{transfer:r});return}if("forward"in o){let e=Be(be,o.forward);H({kind:"order",order:e},[e.buffer]);return}await _o(o)},self.name&&_o({url:self.name})}globalThis.document||To();
})();
