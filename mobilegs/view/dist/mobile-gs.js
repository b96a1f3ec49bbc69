(function bundle(){"use strict";
var b={"count.glsl":`out vec4 found;
void main() {
found = vec4(0.0);
int i = int(gl_FragCoord.y) * 4096 + int(gl_FragCoord.x);
if (i >= count) { return; }
Look look = look_of(i);
if (!(look.opacity > 0.0)) { return; }
Ellipse e = ellipse_of(shape_of(i));
float opacity = look.opacity;
vec2 side = size.xy;
#ifdef LEVELED
int level = level_of(e, look.weight / weight_scale);
side = regions[level].zw - regions[level].xy;
if (level > 0) {
Ellipse coarse = to_level(e, level);
opacity *= fading(e, coarse, level);
e = coarse;
}
found.y = float(level);
#endif
float reach = reach_of(max(opacity, scale_bits.z));
vec2 box = reach * sqrt(e.variance);
vec2 share = max(min(e.center + box, side) - max(e.center - box, vec2(0.0)), vec2(0.0)) / max(2.0 * box, vec2(1e-9));
found.x = sqrt(3.14159265 * reach * reach * sqrt(e.determinant) * share.x * share.y);
}
`,"count.wgsl":`override SORTED = false;
@group(0) @binding(4) var<storage, read> looks: array<StoredLook>;
@group(0) @binding(5) var<storage, read> list: array<u32>;
@group(0) @binding(6) var<storage, read> listed: array<u32, 6>;
@group(0) @binding(7) var<storage, read_write> areas: array<atomic<u32>, 4>;
@compute @workgroup_size(BATCH)
fn count_fragments(
@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
@builtin(local_invocation_index) local: u32) {
let place = (group.y * groups.x + group.x) * BATCH + local;
if (place >= select(listed[5], view.count, SORTED)) { return; }
let look = stored(looks[place]);
if (!(look.opacity > 0.0)) { return; }
let entry = select(list[place], place, SORTED);
let level = select(entry >> LEVEL_SHIFT, 0u, SORTED);
var ellipse = ellipse_of(shape_of(select(entry & ((1u << LEVEL_SHIFT) - 1u), entry, SORTED)));
var opacity = look.opacity;
if (level > 0u) {
let coarse = to_level(ellipse, level);
opacity *= fading(ellipse, coarse, level);
ellipse = coarse;
}
let region = view.regions[level];
let reach = reach_of(max(opacity, view.alpha_min));
let box = reach * sqrt(ellipse.variance);
let inside = max(min(ellipse.center + box, region.zw - region.xy) - max(ellipse.center - box, vec2f()), vec2f());
let share = inside / max(2.0 * box, vec2f(1e-9));
let area = 3.14159265 * reach * reach * sqrt(ellipse.determinant) * share.x * share.y;
atomicAdd(&areas[level], u32(8.0 * area + 0.5));
}
`,"dots.glsl":`precision highp float;
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
#ifndef LEVEL
#define LEVEL 0
#endif
#if LEVEL == 2
#define coarse_colors color_sums
#define coarse_weights weight_sums
#elif LEVEL == 1
uniform sampler2D color_sums_2;
uniform sampler2D weight_sums_2;
#define coarse_colors color_sums_2
#define coarse_weights weight_sums_2
#else
uniform sampler2D color_sums_1;
uniform sampler2D weight_sums_1;
#define coarse_colors color_sums_1
#define coarse_weights weight_sums_1
#endif
void add_enlarged(ivec2 pixel, int begin, inout vec4 color, inout float weight) {
ivec2 coarse_from = LEVEL == 2 ? ivec2(regions[3].xy) : ivec2(0);
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
#if defined(LEVELED) && LEVEL > 0
layout(location = 0) out vec4 color_out;
layout(location = 1) out vec4 weight_out;
void main() {
ivec2 at = ivec2(gl_FragCoord.xy);
ivec2 from = ivec2(regions[LEVEL].xy);
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
opacity *= fading(e, coarse, level);
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
opacity *= fading(ellipse, coarse, level);
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
float fading(Ellipse e, Ellipse coarse, int level) {
return sqrt(e.determinant / coarse.determinant) / float(1 << (2 * level));
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
fn fading(ellipse: Ellipse, coarse: Ellipse, level: u32) -> f32 {
return sqrt(ellipse.determinant / coarse.determinant) / f32(1u << (2u * level));
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
`};var Be=()=>({name:"",before:"",failed:"",state:"",share:NaN,sentence:""}),xe=class{#e=[Be(),Be()];begin(e,t){let n=this.#e[e].name;this.#e[e]=t===void 0?Be():{...Be(),name:t,before:n,state:"loading"}}fail(e,t,n){let{name:s,before:o}=this.#e[e];this.note(e,{share:1,state:"failed",sentence:t,failed:this.names[e],name:n?o:s})}note(e,t){Object.assign(this.#e[e],t)}get state(){let e=this.#e.map(({state:n})=>n);return["failed","loading","loaded"].find(n=>e.includes(n))??""}get busy(){return this.#e.some(({state:e})=>e==="loading")}get share(){let e=this.#e.filter(({state:t})=>t).map(({share:t})=>t);return e.reduce((t,n)=>t+n,0)/e.length}get sentence(){let e=this.#e.every(({state:n})=>n),t=this.#e.map(({state:n,sentence:s,failed:o})=>n!=="failed"?"":e&&o&&!s.includes(o)?`${o}: ${s}`:s);return[...new Set(t.filter(Boolean))].join("; ")}get names(){return Br(this.#e[0].name,this.#e[1].name)}};function Br(r,e){let[t,n]=[r,e].map(s=>s.split("/").filter(Boolean));for(let s=1;s<=Math.max(t.length,n.length);s++){let[o,i]=[t,n].map(a=>a.slice(-s).map(Lt).join("/"));if(o!==i)return[o,i]}return[Lt(t[t.length-1]??""),Lt(n[n.length-1]??"")]}function Lt(r){try{return decodeURIComponent(r)}catch{return r}}function Pe(r){let e=r?.trim().toLowerCase()??"",t=/^([0-9a-f]{3}|[0-9a-f]{6})$/.test(e)?`#${e}`:e,n=/^#[0-9a-f]+$/.test(t)?t:Pr(t),s=n.length===4?n.replace(/[^#]/g,"$&$&"):n;if(!/^#[0-9a-f]{6}$/.test(s))return null;let o=i=>Number.parseInt(s.slice(i,i+2),16)/255;return[o(1),o(3),o(5)]}function _n(r){let e=t=>Math.round(255*Math.min(Math.max(t,0),1));return`#${r.map(t=>e(t).toString(16).padStart(2,"0")).join("")}`}function Pr(r){let e=r?document.createElement("canvas").getContext("2d"):null;if(!e)return"";let[t,n]=["#000000","#ffffff"].map(s=>(e.fillStyle=s,e.fillStyle=r,String(e.fillStyle)));return t===n?t:""}function kn(r,e,t){let n=f=>r.querySelector(`[name=${f}]`);n("background").value=_n(e.background);let s=n("scale"),o=e.scale??0;[...s.options].some(({value:f})=>Number(f)===o)||s.add(new Option(`${Math.round(100*o)} %`,String(o))),s.value=String(o),n("mode").value=e.mode,n("turning").checked=e.turning,n("stats").checked=t;let{renderer:i,adapter:a}=e.device,c=i?`Rendered with ${i}${a?` on ${a}`:""}`:"";r.querySelector(".device").textContent=c;let l=r.querySelector("[data-act=view]");l.hidden=e.views.length<2}function An(r,e){let{name:t,value:n}=r;t==="background"?e.background=Pe(n):t==="scale"?e.scale=Number(n)||null:t==="mode"?e.mode=n==="fly"?"fly":"orbit":t==="turning"&&(e.turning=r.checked),e.redraw()}var $r=new Map([["ArrowLeft",-.02],["ArrowDown",-.02],["ArrowRight",.02],["ArrowUp",.02],["PageDown",-.1],["PageUp",.1],["Home",-1],["End",1]]),$e=class{share=.5;#e;#t;#r=["",""];constructor(e,t){this.#e=e,this.#t=t,e.onpointerdown=({pointerId:n})=>e.setPointerCapture(n),e.onpointermove=({pointerId:n,clientX:s})=>{if(!e.hasPointerCapture(n))return;let{left:o,width:i}=t.getBoundingClientRect();this.#s((s-o)/i)},e.onkeydown=n=>{let s=$r.get(n.key);s===void 0||n.ctrlKey||n.metaKey||n.altKey||(n.preventDefault(),this.#s(this.share+s))}}show(e){this.#r=e,this.#e.querySelectorAll("span").forEach((t,n)=>t.textContent=e[n]),this.#e.setAttribute("aria-label",`${e[0]} on the left, ${e[1]} on the right`),this.#e.hidden=!1,this.#t.classList.add("drawn"),this.#s(this.share)}#s(e){this.share=Math.min(Math.max(e,0),1);let t=Math.round(100*this.share);this.#t.style.clipPath=`inset(0 0 0 ${100*this.share}%)`,this.#e.style.left=`${100*this.share}%`,this.#e.setAttribute("aria-valuenow",String(t));let[n,s]=this.#r;this.#e.setAttribute("aria-valuetext",`${t} % ${n}, ${100-t} % ${s}`)}};var Sn=':host{display:block;position:relative;overflow:hidden;contain:strict;color-scheme:light dark;--paper: #16181dd9;--ink: #f3f4f6;--accent: #7db4ff;--wall: #0d0f12;--field: #ffffff1c;background:var(--wall);color:var(--ink);font:14px/1.4 system-ui,sans-serif;min-height:120px}@media(prefers-color-scheme:light){:host{--paper: #ffffffd9;--ink: #16181d;--accent: #0b62d6;--wall: #e8eaee;--field: #0000000f}}canvas{opacity:0;display:block;width:100%;height:100%;touch-action:none;cursor:grab;outline:none}canvas.drawn{opacity:1}canvas.polite{touch-action:pan-y}canvas:active{cursor:grabbing}canvas.reached{outline:2px solid var(--accent);outline-offset:-2px}.over{position:absolute;inset:0;pointer-events:none}.split{position:absolute;top:0;bottom:0;width:20px;margin-left:-10px;cursor:ew-resize;touch-action:none;outline:none}.split:before{content:"";position:absolute;inset:0 9px;background:#fff;box-shadow:0 0 3px #000a}.split:after{content:"\\2039\\2002\\203a";position:absolute;top:50%;left:-12px;width:44px;height:44px;margin-top:-22px;border-radius:50%;background:var(--paper);line-height:40px;text-align:center;font-size:20px;box-shadow:0 0 0 2px #fff,0 0 5px 2px #000a}.split:focus-visible:after{box-shadow:0 0 0 3px var(--accent)}.split span{position:absolute;top:12px;padding:2px 8px;border-radius:6px;background:var(--paper);max-width:40vw;overflow:hidden;text-overflow:ellipsis;white-space:nowrap}.split span:first-child{right:18px}.split span:last-child{left:18px}[hidden]{display:none!important}.bar{position:absolute;inset:0 0 auto;height:3px;background:transparent}.bar>div{height:100%;width:0;background:var(--accent);transition:width .15s}.bar.unknown>div{width:100%!important;animation:wait 1.2s ease-in-out infinite alternate}@keyframes wait{0%{opacity:.2}}@media(prefers-reduced-motion:reduce){.bar>div{transition:none;animation:none!important}}.panel{position:absolute;background:var(--paper);border-radius:10px;padding:12px 16px;backdrop-filter:blur(8px)}.panel:focus{outline:none}.message,.help,.report{inset:0;margin:auto;width:fit-content;height:fit-content;max-width:min(34em,92%);max-height:92%;box-sizing:border-box;overflow:auto}.message{overflow-wrap:anywhere}.stats{top:12px;left:12px;font-variant-numeric:tabular-nums;white-space:pre;pointer-events:none}.split:not([hidden])~.stats{top:52px}.said{right:12px;top:12px;pointer-events:none}.said:not(.seen){clip-path:inset(50%)}h2{font-size:16px;margin:0 0 8px}.help dl{display:grid;grid-template-columns:fit-content(45%) 1fr;gap:4px 16px;margin:0 0 12px}.help dt{font-weight:600}.help dd{margin:0}.buttons{position:absolute;right:12px;left:12px;bottom:calc(12px + env(safe-area-inset-bottom));display:flex;flex-wrap:wrap;justify-content:end;gap:8px;pointer-events:none}.settings{right:12px;bottom:calc(68px + env(safe-area-inset-bottom));width:min(26em,calc(100% - 24px));box-sizing:border-box;max-height:calc(100% - 80px);overflow:auto}@media(max-height:500px){.settings{bottom:12px;max-height:calc(100% - 24px);columns:2;width:min(40em,calc(100% - 24px))}}.settings p{display:flex;flex-wrap:wrap;align-items:center;gap:8px;margin:0 0 8px}.settings p>label{flex:1}.settings>label{display:flex;align-items:center;gap:8px;min-height:36px}.settings>small{display:block;margin:8px 0 12px;overflow-wrap:anywhere}button,select,[type=color]{font:inherit;color:inherit;background:var(--paper);border:0;border-radius:10px;min-width:44px;min-height:44px;padding:0 9px;cursor:pointer;pointer-events:auto}.panel :is(button,select,[type=color]){background:var(--field)}[type=color]{padding:6px}[type=checkbox]{width:20px;height:20px;margin:0;accent-color:var(--accent)}button:hover{color:var(--accent)}:is(button,select,input,textarea):focus-visible{outline:2px solid var(--accent)}textarea{font:12px/1.3 ui-monospace,monospace;color:inherit;background:transparent;max-width:100%}.drop{inset:12px;border:2px dashed var(--accent);display:grid;place-items:center}';var Gr=[["Drag","rotate the scene"],["Two fingers, right button or Shift","move sideways"],["Pinch or wheel","zoom in and out"],["Double tap","look at that point"],["Arrow keys","rotate"],["W A S D Q E","fly; hold Shift to fly faster"],["M","switch between orbiting and looking around"],["V","next training camera"],["R","back to the first view"],["U","turn another axis upwards"],["F","full screen"],["P","save a picture"],["I","frame rate and size"],["O","settings"],["H","help"]],Tn=`
<style>${Sn}</style>
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
<button data-act="up" title="Another axis points up (U)">Turn upright</button>
<button data-act="close">Close</button></p>
</div>
<div class="panel help" role="dialog" aria-label="Help" tabindex="-1" hidden>
<h2>Controls</h2>
<dl>${Gr.map(([r,e])=>`<dt>${r}</dt><dd>${e}</dd>`).join("")}</dl>
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
<div class="panel drop" hidden>Drop a scene to open it, or two to compare them</div>`,Ot=new Map(Object.entries({r:"reset",m:"mode",f:"full",h:"help",i:"stats",o:"settings",p:"picture",v:"view",u:"up"}));var Mn=new Map([["KeyW",[0,0,1]],["KeyS",[0,0,-1]],["KeyA",[-1,0,0]],["KeyD",[1,0,0]],["KeyQ",[0,1,0]],["KeyE",[0,-1,0]]]),Rn=new Map([["ArrowLeft",[-1,0]],["ArrowRight",[1,0]],["ArrowUp",[0,-1]],["ArrowDown",[0,1]]]),Ge=class{#e;#t;#r=new AbortController;#s=new Map;#n=new Set;#i=!1;#o={x:0,y:0,time:0};constructor(e,t){this.#e=e,this.#t=t;let n=(s,o)=>e.addEventListener(s,o,{signal:this.#r.signal,passive:!1});n("pointerdown",s=>this.#a(s)),n("pointermove",s=>this.#l(s)),n("pointerup",s=>this.#f(s)),n("pointercancel",s=>this.#f(s)),n("wheel",s=>this.#b(s)),n("contextmenu",s=>s.preventDefault()),n("keydown",s=>this.#w(s,!0)),n("keyup",s=>this.#w(s,!1)),n("blur",()=>this.#n.clear())}get busy(){return this.#n.size>0}advance(e){if(!this.busy)return;let t=this.#t.pose(),n=.9*t.reach*e*(this.#i?4:1);for(let s of this.#n){let o=Mn.get(s);o&&t.move(o[0]*n,o[1]*n,o[2]*n);let i=Rn.get(s);i&&this.#c(i[0]*1.5*e,i[1]*1.5*e)}this.#t.changed()}destroy(){this.#r.abort()}#c(e,t){let n=this.#t.pose();this.#t.mode()==="orbit"?n.orbit(e,t):n.look(e,t)}#a(e){this.#e.focus({preventScroll:!0}),this.#e.setPointerCapture(e.pointerId),this.#s.set(e.pointerId,{x:e.offsetX,y:e.offsetY});let{x:t,y:n,time:s}=this.#o,o=Math.hypot(e.offsetX-t,e.offsetY-n)<20,i=this.#s.size===1&&e.button===0;i&&o&&e.timeStamp-s<350&&this.#t.focus(e.offsetX,e.offsetY),this.#o={x:e.offsetX,y:e.offsetY,time:i?e.timeStamp:-1/0},this.#t.held(),e.preventDefault()}#l(e){let t=this.#s.get(e.pointerId);if(t===void 0)return;let n={x:e.offsetX,y:e.offsetY};Math.hypot(n.x-this.#o.x,n.y-this.#o.y)>6&&(this.#o.time=-1/0),this.#s.size===1?this.#p(n.x-t.x,n.y-t.y,e):this.#s.size===2&&this.#m(e.pointerId,n),this.#s.set(e.pointerId,n),this.#t.changed()}#f(e){this.#s.delete(e.pointerId)}#p(e,t,n){n.buttons&6||n.shiftKey||n.ctrlKey?this.#h(e,t):this.#c(e*.006,t*.006)}#m(e,t){let n=this.#s.get(e),s=[...this.#s].find(([a])=>a!==e)?.[1];if(n===void 0||s===void 0)return;let o=Math.hypot(n.x-s.x,n.y-s.y),i=Math.hypot(t.x-s.x,t.y-s.y);this.#t.mode()==="fly"?this.#t.pose().move(0,0,2*(i-o)*this.#g):o>0&&i>0&&this.#t.pose().dolly(o/i),this.#h((t.x-n.x)/2,(t.y-n.y)/2)}#h(e,t){this.#t.pose().move(-e*this.#g,-t*this.#g,0)}get#g(){let{target:e,eye:t}=this.#t.pose();return Math.hypot(...e.map((n,s)=>n-t[s]))/Math.max(this.#e.clientHeight,1)}#b(e){if(this.#e.classList.contains("polite")&&!e.ctrlKey&&!e.metaKey)return;e.preventDefault();let t=e.deltaMode===WheelEvent.DOM_DELTA_LINE?16:1,n=e.deltaY*t*(e.ctrlKey?8:1)*.0012,s=this.#t.pose();this.#t.mode()==="orbit"?s.dolly(Math.exp(n)):s.move(0,0,-n*s.reach),this.#t.changed()}#w(e,t){let{code:n}=e;if(this.#i=e.shiftKey,!t&&n.startsWith("Meta")&&this.#n.clear(),t&&(e.ctrlKey||e.metaKey||e.altKey)||!Mn.has(n)&&!Rn.has(n))return;let s=t&&!this.#n.has(n);t?this.#n.add(n):this.#n.delete(n),s&&this.advance(.03),this.#t.changed(),e.preventDefault()}};function Ft(){let r=URL.createObjectURL(new Blob([`(${bundle})()`],{type:"text/javascript"}));return setTimeout(()=>URL.revokeObjectURL(r),6e4),new Worker(r)}function Ln(r,e){let t=globalThis.preloadedWorker;delete globalThis.preloadedWorker;let n;return t&&"url"in r&&t.url===r.url?(n=t.worker,t.messages.forEach(e)):(t?.worker.terminate(),n=Ft(),n.postMessage(r)),n.onmessage=e,n}async function On(){let r=globalThis.preloadedAdapter;return delete globalThis.preloadedAdapter,await r??navigator.gpu.requestAdapter({powerPreference:"high-performance"})}async function Fn(r){return b[r]}function qe(r,[e,t,n]){let s=r.length/3,o=new Float32Array(s);for(let l=0;l<s;l++)o[l]=e*r[3*l]+t*r[3*l+1]+n*r[3*l+2];let i=new Uint32Array(o.buffer);for(let l=0;l<s;l++)i[l]=i[l]&2147483648?i[l]:~i[l]&2147483647;let a=Uint32Array.from({length:s},(l,f)=>f),c=new Uint32Array(s);for(let l of[0,16]){let f=new Uint32Array(65537);for(let h=0;h<s;h++)f[(i[h]>>>l&65535)+1]+=1;for(let h=0;h<65536;h++)f[h+1]+=f[h];for(let h=0;h<s;h++){let u=a[h];c[f[i[u]>>>l&65535]++]=u}[a,c]=[c,a]}return a}var qr=/[\x00-\x1f\x7f-\x9f\u2028\u2029\p{Cs}]/gu,y=class extends Error{name="SceneError";constructor(e){super(e.replace(qr,"\uFFFD"))}};function q(r){return new DataView(r.buffer,r.byteOffset,r.byteLength)}var re=class{#e;#t=0;#r=0;constructor(e){this.#e=e}get left(){return 8*(this.#e.length-this.#t)-this.#r}take(e){let t=this.#e,n=this.#t,s=t[n]|t[n+1]<<8|t[n+2]<<16|t[n+3]<<24,o=this.#r+e,i=s>>>this.#r&(1<<e)-1;return this.#t=n+(o>>>3),this.#r=o&7,i}atEnd(){return this.left<8&&this.#e[this.#t]>>>this.#r===0}};function he(r,e){let t=Math.ceil(e/8);if(r.length!==t)throw new y(`packed bits take ${r.length} bytes where ${t} belong`);if(e%8&&r[t-1]>>e%8)throw new y("packed bits end in bits that are not zero");return new re(r)}var zn="0061736d01000000012a0460077f7f7f7f7f7f7d0060037f7f7f0060097f7f7f7f7f7f7f7f7f017f60097f7f7f7f7f7f7f7d7d00020f0103656e76066d656d6f727902000103060500010202030607017f014180080b073705056c61796572000005756e69747300010a70756c6c5f706c61696e00020f70756c6c5f636f6e7465787475616c0003047061636b00040abc21059c0404017f017b047f0b7b024020054101480d00200120054102746a21072006fd13210820044102742209410148210a0340200020094102746a210b4100210c03402001fd09000c210d2001fd090008210e2001fd090004210f2001fd090000211002400240200a450d00200d2111200e2112200f2113201021140c010b2002200c4102746a2104200d2111200e2112200f2113201021142000210503402004fd00001022152005fd0900002216fde6012010fde40121102004fd00000022172016fde6012014fde401211420152005fd0900042216fde601200ffde401210f20172016fde6012013fde401211320152005fd0900082216fde601200efde401210e20172016fde6012012fde401211220152005fd09000c2216fde601200dfde401210d20172016fde6012011fde401211120044180046a2104200541106a2205200b490d000b0b2003200c4102746a2205201120082011fde601fde901fd0b00800c2005201220082012fde601fde901fd0b0080082005201320082013fde601fde901fd0b0080042005201020082010fde601fde901fd0b00102005201420082014fde601fde901fd0b0000200541900c6a200d2008200dfde601fde901fd0b000020054190086a200e2008200efde601fde901fd0b000020054190046a200f2008200ffde601fde901fd0b0000200c41f800492105200c41086a210c20050d000b20034180106a2103200b2100200141106a22012007490d000b0b0bd50104027f017b027f017b200020024109746a2103410021040340fd0c0000000000000000000000000000000021052000200441027422066a22022107034020052007fd00000022082008fde601fde401210520074180046a22072003490d000b200120066a2107fd0c0000803f0000803f0000803f0000803f2005fde301fd0cccbc8c2bccbc8c2bccbc8c2bccbc8c2bfde901fde70121050340200720052002fd000000fde601fd0b000020074180046a210720024180046a22022003490d000b200441fc00492102200441046a210420020d000b0bd30101087f41002109034002402006200820092007491b220a4101480d002000200a4103746a210b2000210a0340024020022001200a280200220c41ffff0071220d4101746a2f0100220e4102746a280200220f0d0041000f0b20042f01002110200a28020420094101746a200e3b0102200a20104100200d200f410f766b200f41ffff0171200c410e766c6a220c4180800449220f1b200c200f41047474723602002004200f4101746a2104200a41086a220a200b490d000b0b0240200420054b0d00200941016a220920074d0d010b0b20040bf101010a7f410021094100210a0340024020062008200a2007491b220b4101480d002000200b4103746a210c2000210b0340024020022009200b280204200a4101746a220d2f010071220e20036c2001200e410f74200b280200220f41ffff00712210410174726a2f010022116a4102746a280200220e0d0041000f0b20042f01002112200d20113b0102200b201241002010200e410f766b200e41ffff0171200f410e766c6a220d4180800449220e1b200d200e41047474723602002004200e4101746a2104200b41086a220b200c490d000b0b0240200420054b0d00417f2109200a41016a220a20074d0d010b0b20040bfc1707067f027b037f0c7b037f0e7b017f2005417e7121092005410171210a200641036c210b2006410174210c20044180206a210d200541017441026a210e2008fd13210f2007fd132110410021112006410274221241027421130340fd0c020000000200000002000000020000002214fd0c010000000100000001000000010000002215fd0c0000000000000000000000000000000022162001fd000080042217fde0012001fd0000002218fde001fd442219fd522001fd00008008221afde001201720182019fd522217fde001fd442218fd522119fd0c03000000030000000300000003000000211b2001fd0000800c221c201a20172018fd522217201cfde0012017fde001fd44221dfd52221efd0cffffff7fffffff7fffffff7fffffff7f221cfd4e2016fd37211ffd0c0000000000000000000000000000000022172118410121202016211a4100212102400240024020050e020201000b0340201720032020410a746a2222fd000000fde001fde90120224180086afd000000fde001fde9012117201820224180046afd000000fde001fde901202241800c6afd000000fde001fde9012118202041026a2120202141026a22212009470d000b0b0240200a450d00201720032020410a746a2222fd000000fde001fde9012117201820224180046afd000000fde001fde90121180b2018fd0cffff0f00ffff0f00ffff0f00ffff0f00221afdae014114fdad0121162017201afdae014114fdad01211a0b201b2019201dfd52211d200d2003fd000080042217fd0c000000800000008000000080000000802223fd4e2003fd00000022184110fdad01fd0c008000000080000000800000008000002224fd4efd502018201cfd4e2219fd0c0000804b0000804b0000804b0000804b2225fde601fd6afdf80120192018410dfdad012015fd4efdae01fd0cff0f00c8ff0f00c8ff0f00c8ff0f00c82226fdae01410dfdad01fd0cff7b0000ff7b0000ff7b0000ff7b00002227fdb7012019fd0c000080380000803800008038000080382228fd3afd52fd502017201cfd4e22182025fde601fd6afdf80120182017410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120182028fd3afd524110fdab01fd502217fd0c0000ffff0000ffff0000ffff0000fffffd4efd0ce2f00000e2f00000e2f00000e2f00000fd502017201ffd522217fd5a00000041022120200d20064102746a2017fd5a000001200d200c4102746a2017fd5a000002200d200b4102746a2017fd5a0000032016fd0c78030000780300007803000078030000221ffdb901fd0c770400007704000077040000770400002229fdb601fd0c88fcffff88fcffff88fcffff88fcffff222afdae01212bfd0c00008037000080370000803700008037212cfd0c0000fe420000fe420000fe420000fe422117201a201ffdb9012029fdb601202afdae01212d0240200e41024d0d002017202b4114fdab01202cfdae01fde70121192017202d4114fdab01202cfdae01fde701211a200d21220340202241046a22222019200320204109742221418004726afd000000fde601fd0c0000fec20000fec20000fec20000fec22218fde9012017fde801fd0c002000440020004400200044002000442216fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4e201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf801fd0cff000000ff000000ff000000ff000000fd4e2019200320214180086a2221418004726afd000000fde6012018fde9012017fde8012016fde401fdf8014118fdab01201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4efd50fd50fd502218fd5a000000202220126a2018fd5a0000012022200c4102746a2018fd5a0000022022200b4102746a2018fd5a000003202041046a2220200e490d000b0b200441346a202d4110fdab01202b4118fdab01fd502218fd5a000003200441246a2018fd5a000002200441146a2018fd5a000001200441046a2018fd5a000000200441386a200f2000fd00008004fdfa012010fde501fde601fd0c000000000000000000000000000000002218fde901fd0c0000803f0000803f0000803f0000803f2216fde801fd0c00e0ff4400e0ff4400e0ff4400e0ff44221afde601fd0c0000003f0000003f0000003f0000003f2219fde401fdf801410bfdab01200f2000fd00008008fdfa012010fde501fde6012018fde9012016fde801fd0c00c07f4400c07f4400c07f4400c07f44fde6012019fde401fdf8014116fdab01fd50200f2000fd000000fdfa012010fde501fde6012018fde9012016fde801201afde6012019fde401fdf801fd502216fd5a000003200441286a2016fd5a000002200441186a2016fd5a000001200441086a2016fd5a0000002004413c6afd0c71aa34c471aa34c471aa34c471aa34c4fd0c71aa344471aa344471aa344471aa3444201e2018fd43fd5222162001fd00008004221a2001fd000000201d2015fd39fd52fde601fd0c001080440010804400108044001080442219fde401fdf801410afdab01fd0c00fc0f0000fc0f0000fc0f0000fc0f00fd4e201d4114fdab01fd5020162001fd00008008222b201a201d2014fd39fd52fde6012019fde401fdf801fd0cff030000ff030000ff030000ff030000221afd4efd50410afdab0120162001fd0000800c202b201d201bfd39fd52fde6012019fde401fdf801201afd4efd502216fd5a0000032004412c6a2016fd5a0000022004411c6a2016fd5a0000012004410c6a2016fd5a0000002002fd0000802c211d2002fd00008028211b2002fd00008024212b2002fd00008020212d2002fd0000801c21142002fd00008018211e2002fd00008014212e2002fd00008010212f2002fd0000800c2130200441b0106a2002fd0000800422162023fd4e2002fd00000022194110fdad012024fd4efd502019201cfd4e221a2025fde601fd6afdf801201a2019410dfdad012015fd4efdae012026fdae01410dfdad012027fdb701201a2028fd3afd52fd502016201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd524110fdab01fd502216fd5a000003200441a0106a2016fd5a00000220044190106a2016fd5a00000120044180106a2016fd5a000000200441b4106a2002fd000080082216201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd522030fde0012018fde901202ffde001fde901202efde001fde901201efde001fde9012014fde001fde901202dfde001fde901202bfde001fde901201bfde001fde901201dfde001fde901fd0cffff0f00ffff0f00ffff0f00ffff0f00fdae014114fdad01201ffdb9012029fdb601202afdae0122184110fdab0120164110fdad012024fd4efd50fd502002fd0000800c201720184114fdab01202cfdae01fde7012218fde601fd0c0000fec20000fec20000fec20000fec22216fde9012017fde801fd0c002000440020004400200044002000442219fde401fdf8014118fdab01fd50221afd5a000003200441a4106a201afd5a00000220044194106a201afd5a00000120044184106a201afd5a00000020044188106a213141002120410121210340203120204102746a222241306a20182020410b7420026a22204180186afd000000fde6012016fde9012017fde8012019fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4e2018202041801c6afd000000fde6012016fde9012017fde8012019fde401fdf8014118fdab01fd50201820204180146afd000000fde6012016fde9012017fde8012019fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4efd50201820204180106afd000000fde6012016fde9012017fde8012019fde401fdf801fd0cff000000ff000000ff000000ff000000fd4efd50221afd5a000003202241206a201afd5a000002202241106a201afd5a0000012022201afd5a00000020214101712122410021214101212020220d000b200441c0006a2104200341106a2103200241106a2102200141106a2101200041106a2100200d20136a210d201141fc00492122201141046a211120220d000b0b";var ye,Un=new WeakMap;function He(r){return typeof WebAssembly=="object"?new WebAssembly.Memory({initial:Math.ceil(r/2**16)}):null}function ue(r){if(r===null)return null;if(ye===void 0)try{let t=zn.match(/../g);ye=new WebAssembly.Module(Uint8Array.from(t,n=>parseInt(n,16)))}catch{ye=null}if(ye===null)return null;let e=Un.get(r);if(!e){let{exports:t}=new WebAssembly.Instance(ye,{env:{memory:r}});e=t,Un.set(r,e)}return e}var zt=2048,oe;function In({contexts:r,alphabet:e,symbols:t,spans:n},s,o,i,a){oe===void 0&&(oe=He(1));let c=ue(oe);if(oe===null||c===null)return;let l=s.length,f=zt+2*t.length,h=f+4*n.length,u=h+i.length,p=u+2*l+2,d=Math.ceil((p+2*a+2)/2**16)-oe.buffer.byteLength/2**16;d>0&&oe.grow(d);let{buffer:m}=oe,w=new Uint32Array(m,0,2*l);s.forEach((g,E)=>w.set([g,p-2+2*o[E]],2*E)),new Uint16Array(m,zt,t.length).set(t),new Uint32Array(m,f,n.length).set(n),new Uint8Array(m,h,i.length).set(i);let _=(r>1?c.pull_contextual:c.pull_plain)(0,zt,f,e,h,u,l,Math.floor(a/l),a%l);return{decoded:new Uint16Array(m,p,a).slice(),left:_?(u-_)/2:-1/0,states:w.filter((g,E)=>E%2===0)}}var We=14,_e=1<<We,Nn=65536,Hr=64,Vr=256,Wr=2048,Ve=12,Cn=-1/0;function ie(r,e,t,n=!1){if(r.length<Ve)throw new y("a rANS stream is too short to hold its header");let s=q(r),o=s.getUint16(0,!0),i=s.getUint16(2,!0),a=s.getUint32(4,!0),c=s.getUint32(8,!0);if(o!==t)throw new y(`a rANS stream of ${o} symbols stands where ${t} belong`);if(i!==1&&i!==t||i>Hr)throw new y(`a rANS stream has ${i} contexts`);let l=jr(e);if(r.length!==Ve+a+4*l+2*c)throw new y("a rANS stream is longer or shorter than its header says");let f=Ve+a,h=Yr(r.subarray(Ve,f),i,t),u=new Uint32Array(l).map((_,g)=>s.getUint32(f+4*g,!0));if(u.some(_=>_<Nn))throw new y("a rANS stream starts in an impossible state");let p=Math.floor(e/l),d=e%l,m=u.map((_,g)=>g*p+Math.min(g,d)),w=[h,u,m,r.subarray(f+4*l),e],v=(n?void 0:In(...w))??Xr(...w);if(v.left===Cn)throw new y("a rANS stream leads to a context that is not used: it is damaged");if(v.left<0)throw new y("a rANS stream ends early: the file is damaged");if(v.left>0||v.states.some(_=>_!==Nn))throw new y("a rANS stream does not end where it should: the file is damaged");return v.decoded}function jr(r){let e=Math.max(1,Math.floor(r/Wr));return Math.min(Vr,1<<31-Math.clz32(e))}function Xr({contexts:r,alphabet:e,symbols:t,spans:n},s,o,i,a){let c=s.length,l=Math.floor(a/c),f=a%c,h=new Uint16Array(a),u=i.length/2,p=new Uint16Array(u+1);new Uint8Array(p.buffer).set(i);let d=0;for(let m=0;m<=l;m++){let w=m<l?c:f,v=r>1&&m>0;for(let _=0;_<w;_++){let g=o[_]+m,E=v?h[g-1]:0,k=s[_],S=k&_e-1,U=t[E<<We|S],Y=n[E*e+U];if(Y===0)return{decoded:h,left:Cn,states:s};let K=Math.imul(Y&32767,k>>>We)+S-(Y>>>15)|0,L=(K>>>16)-1>>>31;s[_]=K<<16*L|p[d]&-L,d+=L,h[g]=U}}return{decoded:h,left:u-d,states:s}}function Yr(r,e,t){let n=new re(r),s=new Uint16Array(e*_e),o=new Uint32Array(e*t);for(let i=0;i<e;i++){if(!Ee(n,1))continue;let a=Kr(n,t),c=i*_e;for(let l=0;l<t;l++){let f=a[l];f!==0&&(o[i*t+l]=c%_e<<15|f,s.fill(l,c,c+f),c+=f)}}if(!n.atEnd())throw new y("a rANS stream's frequency tables are longer than they should be");return{contexts:e,alphabet:t,symbols:s,spans:o}}function Kr(r,e){let t=new Uint16Array(e),n=[];for(let a=0;a<e;a++)Ee(r,1)&&n.push(a);let s=Ee(r,4),o=n.pop(),i=_e;for(let a of n){let c=s;for(;!Ee(r,1);)c++;if(c>We)throw new y("a rANS stream's frequency table holds a number out of range");t[a]=Ee(r,c)+(1<<c)-(1<<s)+1,i-=t[a]}if(o===void 0||i<1)throw new y("a rANS stream's frequencies do not sum to 16384");return t[o]=i,t}function Ee(r,e){if(e>r.left)throw new y("a rANS stream's frequency tables end early");return r.take(e)}var Qr=Float64Array.from({length:31},(r,e)=>2**(Math.max(e,1)-25)),Bn=new Float32Array(1),Dn=new Uint32Array(Bn.buffer);function Ut(r){return(r&31744)===31744}function I(r){let e=r>>10&31,t=(r&1023)+(e>0?1024:0);return(r&32768?-t:t)*Qr[e]}function j(r){Bn[0]=r;let e=Dn[0]>>>16&32768,t=Dn[0]&2147483647;if(t<947912704){let n=Math.abs(r)*16777216,s=Math.round(n);return e|(s-n===.5&&s%2?s-1:s)}return e|Math.min(t+4095+(t>>>13&1)-939524096>>>13,31743)}function It(r,e){let t=Zr(r,e);if(t.some(Ut))throw new y(`the stream '${r.name}' of the .mgs file has numbers that are not finite`);return Float32Array.from(t,I)}function Zr({name:r,codec:e,data:t},n){let s=new y(`the stream '${r}' of the .mgs file has a wrong length`);if(e==="raw"){if(t.length!==2*n)throw s;return Uint16Array.from({length:n},(l,f)=>t[2*f]|t[2*f+1]<<8)}if(t.length<4)throw s;let o=4+q(t).getUint32(0,!0);if(o>t.length||e==="halves"&&t.length!==o+n)throw s;let i=ie(t.subarray(4,o),n,256),a=t.subarray(o),c=e==="planes"?ie(a,n,256):a;return i.map((l,f)=>l<<8|c[f])}var Jr=49,ae=24,je=Uint32Array.from({length:4096},(r,e)=>{let t=0;for(let n=0;n<12;n++)t|=(e>>>n&1)<<10*(n%3)+Math.floor(n/3);return t});function Pn(r,e){let t=r.length<4?1/0:4+q(r).getUint32(0,!0);if(t>r.length)throw new y("the stream of positions is too short to hold what its header says");let n=ie(r.subarray(4,t),e,Jr),s=0;for(let l=0;l<e;l++)s+=Math.max(n[l]-1,0);let o=he(r.subarray(t),s),i=new Uint16Array(3*e),a=0,c=0;for(let l=0;l<e;l++){let f=n[l]-1;if(f>=ae?(a+=o.take(ae),c+=(1<<f-ae)+o.take(f-ae)):f>=0&&(a+=(1<<f)+o.take(f)),c+=a>>>ae,a&=(1<<ae)-1,c>>>ae)throw new y("the stream of positions leaves its 48-bit grid");let h=je[a&4095]|je[a>>>12]<<4,u=je[c&4095]|je[c>>>12]<<4;for(let p=0,d=0;p<3;p++,d+=10){let m=h>>>d&255|(u>>>d&255)<<8,w=m&32768?m&32767:m^65535;if(Ut(w))throw new y("the stream of positions holds numbers that are not finite");i[3*l+p]=w}}return i}function $n(r,e){let t=3*Math.ceil(r.length/3/e);if(t<=3)return r;let n=new Uint16Array(3*Math.ceil(r.length/t));for(let s=0,o=0;s<r.length;s+=t,o+=3)n.set(r.subarray(s,s+3),o);return n}function Nt(r,{center:e,radius:t,exponent:n}){let s=new Float32Array(r.length),o=t*2**n;for(let i=0;i<r.length;i++)s[i]=e[i%3]+Math.fround(o*I(r[i]));return s}function Xe(r){return"stored"in r?Nt(r.stored,r.grid):r}var eo={from:64,to:65536,times:4},to={from:32,to:1024,times:2},Gn=128,Hn="mobilegs variant 1";function Vn(r,e){let t=null;try{t=e?.getItem(`${Hn} ${r.describe()}`)??null}catch{}return r.variants.find(n=>Yn(n)===t)??null}async function Wn(r,e){let t={floats:!1,strips:!1},n={...t};if(await qn(r,t,{...t,strips:!0},eo,no)&&(n.strips=!0),r.variants.some(({floats:s})=>s)){let s={...n,floats:!0};await qn(r,n,s,to,so)&&(n.floats=!0)}try{e?.setItem(`${Hn} ${r.describe()}`,Yn(n))}catch{}return n}async function jn(r){r.setScene({...Ct(1,1,()=>[0,0,1]),packing:{center:[0,0,0],unit:1,leastScaleBits:0,scaleBitsSpan:0},shapes:Uint32Array.of(0,15360,0,0),colors:new Uint32Array(4),shSize:4,lobes:new Uint32Array(5),lobeSize:9}),await r.drawUnseen(Dt(1))}function Xn(r){r.setDots({means:Float32Array.of(0,0,1),color:[0,0,0],side:1,background:[0,0,0]}),r.drawDots(Dt(1)),r.setDots(null)}var Yn=({floats:r,strips:e})=>`${r} ${e}`;async function qn(r,e,t,{from:n,to:s,times:o},i){let a=0;for(let c=n;;c*=o){let{scene:l,side:f}=i(c);r.setScene(l);let h=[1/0,1/0];for(let p=0;p<=3;p++)for(let[d,m]of[e,t].entries()){r.variant=m;let w=performance.now();await r.drawUnseen(Dt(f)),p>0&&(h[d]=Math.min(h[d],performance.now()-w))}let u=Math.max(...h);if(c===n&&(a=u),u>Math.max(4,3*a)||c>=s)return h[1]<.85*h[0]}}function no(r){let e=Math.ceil(Math.sqrt(r)),t=s=>2*(s+.5)/e-1;return{scene:Ct(r,.001,s=>[t(s%e),t(Math.floor(s/e)),1]),side:256}}function so(r){return{scene:Ct(Gn,1,e=>[0,0,1+e/Gn]),side:r}}function Ct(r,e,t){let n=new Float32Array(12*r);for(let s=0;s<r;s++){let[o,i,a]=t(s);n.set([e,0,0,o,0,e,0,i,0,0,e,a],12*s)}return{count:r,packing:null,shapes:n,colors:new Float32Array(3*r),shSize:1,lobes:new Float32Array(2*r).fill(1),lobeSize:1,sorted:!1,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},background:[0,0,0]}}function Dt(r){return{viewmat:[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],fx:r/2,fy:r/2,cx:r/2,cy:r/2,width:r,height:r,near:.1}}function Kn(r){return r?.soft_edge?1:1.4}function Z(r,e){let t=[[r,e]];for(let n=1;n<4;n++)t.push(t[n-1].map(s=>(s-(n===1?0:1)>>1)+2));return t}function J(r,e){let[,...t]=Z(r,e),n=[[0,0]],s=0;for(let[,o]of t)n.push([r,s]),s+=o;return{places:n,size:[r+t[0][0],Math.max(e,s)]}}function Qn(r){let[e,t,n]=[1,2,3].map(c=>r[`hidden${c}.weight`]),s=["opacity","phi"].map(c=>({weights:ro(r[`${c}.weight`],n,128),offset:r[`${c}.weight`].reduce((l,f,h)=>l+f*r["hidden3.bias"][h],r[`${c}.bias`][0])})),o=new Float32Array(16*2497),i=0,a=(c,l,f)=>{for(let h=c;h<c+4;h++)for(let u=l;u<l+4;u++)o[i++]=f(h,u)};for(let c=0;c<256;c+=4)for(let l=0;l<24;l+=4)a(c,l,(f,h)=>h<22?e[22*f+h]:h===22?r["hidden1.bias"][f]:0);for(let c=0;c<128;c+=4)a(c,0,(l,f)=>f===0?r["hidden2.bias"][l]:0);for(let c=0;c<256;c+=4)for(let l=0;l<128;l+=4)a(l,c,(f,h)=>t[256*f+h]);for(let c=0;c<128;c+=4)a(0,c,(l,f)=>s[l]?.weights[f]??0);return a(0,0,(c,l)=>l===0?s[c]?.offset??0:0),o}function ro(r,e,t){return Array.from({length:t},(n,s)=>r.reduce((o,i,a)=>o+i*e[t*a+s],0))}function pe({packing:r,shSize:e,lobeSize:t,network:n}){return r?{shapes:4,colors:4,lobes:n?10:t+2>>1}:{shapes:12,colors:3*e,lobes:2*t}}function Zn(r){return I(r&65535)}var me=class{#e;#t;#r;constructor(e,{sh:t,scales:n,quats:s},o){this.#e=e,this.#t=[[t,e.part(o,0,12)],[n,e.part(o,12,3)]],this.#r=[s,e.part(o,15,4)]}write(){let[e,t]=this.#r;for(let[n,s]of this.#t)this.#e.units(n,s);t.numbers.set(e.numbers)}};var oo=[["context1",64,96],["context2",13,64],["static1",64,16],["static2",3,64],["view1",64,16],["view2",9,64]],io=[["both1",128,6],["static2",3,64],["view2",9,64]],Bt={linear:"color-matrices",networks:"appearance-decoder",latent_networks:"color-networks"};function Jn({colors:r,scalars:e}){let t=e.get("appearance")?.columns.length??6,n={linear:[["static2",3,3],["view2",9,t-3]],networks:oo,latent_networks:io};return[Bt[r],n[r]]}var es=[["hidden1.weight",256,22],["hidden1.bias",1,256],["hidden2.weight",128,256],["hidden2.bias",1,128],["hidden3.weight",64,128],["hidden3.bias",1,64],["phi.weight",1,64],["phi.bias",1,1],["opacity.weight",1,64],["opacity.bias",1,1]];function ts({degree:r,latents:e,hidden:t}){let n=2*(r+1)**2,s=[19+e,...t],o=[["bias",1,n],["basis",e,n]];return t.length===0||([...t,n].forEach((i,a)=>o.push([`weights.${a}`,i,s[a]])),t.forEach((i,a)=>o.push([`offsets.${a}`,1,i]))),o}function ns(r){return r.reduce((e,[,t,n])=>e+t*n,0)}function ss(r,e){let t=0;return Object.fromEntries(e.map(([n,s,o])=>[n,r.subarray(t,t+=s*o)]))}var ee=Object.freeze({blur:.3,antialiased:!1,soft_edge:!1}),ao=2**26,co=8,$t=4096,Pt=2**14,lo=1e-5,fo=1e3,ho=80,uo=8,Gt=32,po=256,mo=3,wo=64,rs=2**16,os=64,is=4096,go=1e-20,Ye=1e20,bo=/[\x00-\x1f\x7f-\x9f\p{Cs}]/u,as=["mobile_gs","no_depth","no_scale","sort_free_gs"],vo=[["scale",[[3,1],[1,3]]],["rotation",[[2,2],[1,4]]],["appearance",[[3,2]]],["opacity",[[1,1]]]],cs=[6,12],xo=[["scale",3],["rotation",3],["appearance",cs[0]],["opacity",1]];function ls(r,e){let{colors:t="networks"}=r;for(let[h,u,...p]of[["mode",r.mode,"nvq","sq"],["blend",r.blend,"sortfree","sorted"],["sh_degree",r.sh_degree,1],["colors",t,"linear","networks","latent_networks"]])if(!p.includes(u))throw new y(`the .mgs file has ${h} '${hs(u)}', which this program does not know: a newer one may`);let n=_o(r),s=r.network;if(typeof s!="boolean")throw A("network");if(s&&n!==null)throw new y("the .mgs file has lobes and a view network: it can have one of them");let o=r.mode==="sq",i=O(r,"count",1,ao),a={count:i,lodSizes:Eo(r,i),cuts:o?new Map:ko(B(r,"codebooks"),n),scalars:o?Ao(B(r,"scalars"),n,t==="linear"):new Map,grid:So(B(r,"positions")),colors:t,sorted:r.blend==="sorted",lobes:n,network:s,weighting:To(B(r,"weighting")),footprint:Mo(B(r,"footprint")),background:Qe(r,"background",3),near:X(r,"near"),views:ke(r,"views").map(Ro),meta:Lo(B(r,"meta"))},c=yo(a),f=r.streams.filter(h=>c.has(h.name)).reduce((h,u)=>h+u.bytes,0);if(i>f)throw new y(`the .mgs file claims ${i} Gaussians in ${f} of its ${e} bytes: it is damaged`);if(a.footprint.soft_edge&&a.sorted)throw A("footprint.soft_edge");if(a.background.some(h=>h<0||h>1))throw A("background");if(!(a.near>0&&a.near<=Ye))throw A("near");if(a.views.length>wo)throw A("views");return a}function Ke(r,e){return typeof r!="string"||r.length>2*e||bo.test(r)?!1:r.length<=e||[...r].length<=e}function yo({colors:r,lobes:e,network:t,cuts:n,scalars:s,lodSizes:o}){let i=["positions"];for(let[c,{count:l}]of n)for(let f=0;f<l;f++)i.push(`${c}.${f}`);for(let[c,{columns:l}]of s)i.push(...l.map((f,h)=>`${c}.${h}`));s.size&&i.push("rotation-finer");let a=o.flatMap((c,l)=>i.map(f=>l?`${f}@${l}`:f));return a.push(Bt[r]),e&&a.push("lobe-decoder"),t&&a.push("view-network"),n.size&&a.push("codebooks"),new Set(a)}function Eo(r,e){let t=ke(r,"layers").map(s=>O({layers:s},"layers",1,e)),n=t.reduce((s,o)=>s+o,0);if(t.length>co||n!==e)throw A("layers");return t}function _o(r){if(r.lobes===null)return null;let e=B(r,"lobes"),t=ke(e,"hidden");if(t.length>mo)throw A("lobes.hidden");return{degree:O(e,"degree",0,3),latents:O(e,"latents",0,Gt),hidden:t.map(n=>O({hidden:n},"hidden",1,po))}}function ko(r,e){let t=new Map;for(let[s,o]of vo){if(s==="opacity"&&!Object.hasOwn(r,s)&&e!==null)continue;let i=B(r,s),a=o.find(([c,l])=>i.count===c&&i.length===l);if(!a)throw A(`codebooks.${s}`);t.set(s,{count:a[0],length:a[1],size:O(i,"size",1,$t)})}let n=0;if(Object.hasOwn(r,"lobes")){let s=B(r,"lobes"),o=O(s,"count",1,Gt),i=O(s,"length",1,Gt);t.set("lobes",{count:o,length:i,size:O(s,"size",1,$t)}),n=o*i}if(n!==(e===null?0:e.latents))throw A("codebooks.lobes");return t}function Ao(r,e,t){let n=new Map,s=e?.latents??0;if(Object.hasOwn(r,"lobes")&&!s)throw A("scalars.lobes");for(let[o,i]of[...xo,["lobes",s]]){if(o==="opacity"&&!Object.hasOwn(r,o)&&e!==null||i===0)continue;let c=B(r,o),[l,f,h]=["least","size","middle"].map(v=>ke(c,v)),[u,p]=o==="appearance"&&t?cs:[i,i],d=l.length;if(d<u||d>p||f.length!==d||h.length!==d)throw A(`scalars.${o}`);let m=Math.fround(X(c,"step"));if(!(m>=lo&&m<=fo))throw A(`scalars.${o}.step`);let w=l.map((v,_)=>{let g={least:l[_],size:f[_],middle:h[_]},E=O(g,"least",-Pt,Pt),k=O(g,"size",1,$t),S=O({size:E+k-1},"size",E,Pt);if(o==="scale"&&S*m>ho)throw A("scalars.scale");let U=Math.max(-E,S)+.5;if(o==="rotation"&&U*m>uo)throw A("scalars.rotation");return{least:E,size:k,middle:O(g,"middle",E,S)}});n.set(o,{step:m,columns:w})}return n}function So(r){let e=Qe(r,"center",3),t=Math.fround(X(r,"radius"));if(e.some(n=>Math.abs(n)>Math.fround(Ye)))throw A("positions.center");if(t<go||t>Ye)throw A("positions.radius");return{center:e,radius:t,exponent:O(r,"exponent",0,14)}}function To(r){let{name:e}=r;if(typeof e!="string")throw A("name");if(!as.includes(e))throw new y(`the .mgs file has the weighting '${hs(e)}': known are ${as.join(", ")}`);let t={name:e,exponent_max:X(r,"exponent_max"),sigma:X(r,"sigma"),background_weight:X(r,"background_weight"),alpha_min:r.alpha_min===void 0?1/255:X(r,"alpha_min")};if(!(t.exponent_max>0&&t.exponent_max<=80))throw A("exponent_max");if(!(t.sigma>0&&t.sigma<=Ye))throw A("sigma");if(t.background_weight<0)throw A("background_weight");if(!(t.alpha_min>=1e-4&&t.alpha_min<=.1))throw A("alpha_min");return t}function Mo(r){let{antialiased:e,soft_edge:t}=r;if(typeof e!="boolean")throw A("footprint.antialiased");if(typeof t!="boolean")throw A("footprint.soft_edge");let n=X(r,"blur");if(!(n>0&&n<=4))throw A("footprint.blur");return{blur:n,antialiased:e,soft_edge:t}}function Ro(r){let e=B({views:r},"views"),t=Qe(e,"viewmat",16),n=Qe(e,"K",9);if(![0,0,0,1].every((i,a)=>t[12+a]===i)||![0,0,1].every((i,a)=>n[6+a]===i)||n[0]<=0||n[4]<=0)throw new y("a view's matrices in the .mgs file are not those of a camera");let o=O(e,"width",1,rs);return{viewmat:t,K:n,width:o,height:O(e,"height",1,rs)}}function Lo(r){let e=Object.entries(r);if(e.length>os)throw new y(`the .mgs file has ${e.length} notes: ${os} are allowed`);for(let[t,n]of e){let s=n===null||typeof n=="boolean"||Ke(n,is),o=typeof n=="number"&&Math.abs(n)<=2**53;if(!(s||o)||!Ke(t,is))throw new y(`the note '${t.slice(0,40)}' is not a short text or a number`)}return r}function B(r,e){let t=r[e];if(typeof t!="object"||t===null||Array.isArray(t))throw A(e);return t}function ke(r,e){let t=r[e];if(!Array.isArray(t))throw A(e);return t}function O(r,e,t,n){let s=X(r,e);if(!Number.isInteger(s)||s<t||s>n)throw A(e);return s}function X(r,e){return fs(r[e],e)}function Qe(r,e,t){let n=ke(r,e);if(n.length!==t)throw A(e);return Float32Array.from(n,s=>fs(s,e))}function fs(r,e){if(typeof r!="number"||!(Math.abs(r)<=3e38))throw A(e);return r}function hs(r){return typeof r!="object"||r===null?String(r).slice(0,40):Array.isArray(r)?"a list":"an object"}function A(r){return new y(`the field '${r}' in the header of the .mgs file is missing or invalid`)}var Ae=288,Ze=2**-6,us=.3;function Se(r,e){let{fx:t,fy:n,cx:s,cy:o,width:i,height:a}=r;return{...r,fx:e*t,fy:e*n,cx:e*s,cy:e*o,width:e*i,height:e*a}}function Je(r,e,t,n,s){let{viewmat:o,fx:i,fy:a,cx:c,cy:l,width:f,height:h,near:u}=e,{background:p,weighting:d,packing:m,footprint:w=ee}=r,v=us*.5*f/i,_=us*.5*h/a,g=[0,1,2].map(L=>-(o[L]*o[3]+o[4+L]*o[7]+o[8+L]*o[11])),E=new Float32Array(Ae/4);E.set([...Array.from(o).slice(0,12),...g,u,i,a,c,l,-c/i-v,(f-c)/i+v,-l/a-_,(h-l)/a+_,...p,d.exponentMax,f,h,d.sigma,d.backgroundWeight,t]);let k=[r.count,r.shSize,r.lobeSize,d.index];if(new Int32Array(E.buffer).set(k,33),m){let{center:L,unit:G,leastScaleBits:Q,scaleBitsSpan:Cr}=m;E.set([...L,G,Q,Cr],40)}E[46]=!r.sorted&&d.alphaMin||1/255,E[47]=w.blur,new Int32Array(E.buffer).set([Number(w.antialiased),Number(w.soft_edge&&!r.sorted)],48),E[50]=n,new Int32Array(E.buffer)[51]=s;let S=Z(f,h),{places:U,size:Y}=J(f,h),K=U.flatMap(([L,G],Q)=>[L,G,L+S[Q][0],G+S[Q][1]]);return E.set([...K,...Y],52),E}var et=class{milliseconds=null;#e;#t;#r=!1;#s=!1;#n=[];constructor(e){this.#e=e,this.#t=e.getExtension("EXT_disjoint_timer_query_webgl2")}start(){this.#s=this.#r&&!this.#n.length}pass(e){if(!this.#s)return;let[t,n]=[this.#e,this.#t.TIME_ELAPSED_EXT];if(this.#n.length&&t.endQuery(n),e){let s=t.createQuery();this.#n.push([e,s]),t.beginQuery(n,s)}else this.#s=!1}async time(){let e=this.#e;this.#r=this.#t!==null;let t=this.#n[this.#n.length-1];if(!t||this.#s)return;for(let s=0;s<100&&!e.getQueryParameter(t[1],e.QUERY_RESULT_AVAILABLE);s++)await new Promise(o=>setTimeout(o,5));let n=this.#n.map(([s,o])=>[s,e.getQueryParameter(o,e.QUERY_RESULT)/1e6]);e.getParameter(this.#t.GPU_DISJOINT_EXT)||(this.milliseconds=Object.fromEntries(n));for(let[,s]of this.#n.splice(0))e.deleteQuery(s)}forget(){this.#n=[],this.#s=!1}};function tt({color:r,side:e},{viewmat:t,fx:n,fy:s,cx:o,cy:i,width:a,height:c,near:l}){let[f,h,u]=[0,4,8].map(p=>Array.from(t).slice(p,p+4));return Float32Array.of(...f.map((p,d)=>2*(n*p+o*u[d])/a-u[d]),...h.map((p,d)=>u[d]-2*(s*p+i*u[d])/c),...u,...r,l,s*e/2,.002*c/2,2/a,2/c)}function nt({means:r}){let e=new Float32Array(6*r.length);for(let t=0,n=0;t<r.length;t+=3)for(let s=n+18;n<s;n+=3)e[n]=r[t],e[n+1]=r[t+1],e[n+2]=r[t+2];return e}var st=["shapes","colors","lobes","looks","opacities","order","color_sums","weight_sums","color_sums_1","weight_sums_1","color_sums_2","weight_sums_2"],rt=class{#e;#t=new Map;constructor(e){this.#e=e}make(e,t,[n,s]){let o=this.#e;o.deleteTexture(this.#t.get(e)??null);let i=o.createTexture();return this.#t.set(e,i),o.activeTexture(o.TEXTURE0+st.indexOf(e)),o.bindTexture(o.TEXTURE_2D,i),o.texStorage2D(o.TEXTURE_2D,1,t,n,s),o.texParameteri(o.TEXTURE_2D,o.TEXTURE_MIN_FILTER,o.NEAREST),o.texParameteri(o.TEXTURE_2D,o.TEXTURE_MAG_FILTER,o.NEAREST),i}upload(e,t,n){let s=this.#e,[o,,i]=t,a=Te(n.length/i);if(a[1]>s.getParameter(s.MAX_TEXTURE_SIZE))throw new Error("the scene has more Gaussians than this GPU's textures can hold");this.make(e,s[o],a),this.write(e,t,0,n)}write(e,[,t,n],s,o){let i=this.#e,a=o instanceof Float32Array?i.FLOAT:i.UNSIGNED_INT,c=o.length/n;i.activeTexture(i.TEXTURE0+st.indexOf(e));for(let l=0;l<c;){let[f,h]=[(s+l)%4096,Math.floor((s+l)/4096)],u=Math.min(4096-f,c-l),p=u===4096?Math.floor((c-l)/4096):1,d=l*n;i.texSubImage2D(i.TEXTURE_2D,0,f,h,u,p,i[t],a,o,d),l+=u*p}}destroy(){for(let e of this.#t.values())this.#e.deleteTexture(e)}};function Te(r){return[Math.max(1,Math.min(r,4096)),Math.max(1,Math.ceil(r/4096))]}var ot=128,ds=0,qt=["EXT_color_buffer_float","EXT_color_buffer_half_float"];function Ht(r){return["EXT_color_buffer_float","EXT_float_blend"].every(e=>r.getExtension(e))}function Vt(r){for(let o of[...qt,"EXT_float_blend"])r.getExtension(o);let e=r.getExtension("WEBGL_provoking_vertex");e?.provokingVertexWEBGL(e.FIRST_VERTEX_CONVENTION_WEBGL),r.disable(r.DITHER);let t={view:r.createBuffer(),corners:r.createBuffer(),quads:r.createVertexArray(),looks:r.createFramebuffer(),sums:r.createFramebuffer(),enlarged:[r.createFramebuffer(),r.createFramebuffer()],programs:new Map,counters:new Map,textures:new rt(r)};r.bindBufferBase(r.UNIFORM_BUFFER,ds,t.view),r.bufferData(r.UNIFORM_BUFFER,Ae,r.DYNAMIC_DRAW),r.bindVertexArray(t.quads),r.bindBuffer(r.ELEMENT_ARRAY_BUFFER,t.corners);let n=[0,1,2,2,1,3],s=Array.from({length:ot},(o,i)=>n.map(a=>4*i+a));return r.bufferData(r.ELEMENT_ARRAY_BUFFER,Uint16Array.from(s.flat()),r.STATIC_DRAW),t}function ps(r,e,t){let{whole:n,project:s,splat:o,resolve:i}=e,a=t.packed?e.packed:e.wide,c=ws(r,e.view,t);return{project:c(n,`${a}${s}`),splat:c(`${a}${o}`,o),resolve:c(n,i),enlarge:t.leveled?[1,2].map(l=>c(n,`#define LEVEL ${l}
${i}`)):[]}}function ms(r,{view:e,packed:t,wide:n,whole:s,count:o},i){return ws(r,e,i)(s,`#define VERTEX
${i.packed?t:n}${o}`)}function ws(r,e,{sorted:t,strips:n,leveled:s}){let i=Object.entries({SORTED:t,STRIPS:n,LEVELED:s}).map(([a,c])=>c?`#define ${a}
`:"").join("");return(a,c)=>{let l=Wt(r,`${i}#define VERTEX
${e}${a}`,`${i}${e}${c}`);return r.useProgram(l),st.forEach((f,h)=>r.uniform1i(r.getUniformLocation(l,f),h)),r.uniformBlockBinding(l,r.getUniformBlockIndex(l,"View"),ds),l}}function Wt(r,e,t){let n=r.createProgram();for(let[s,o]of[[r.VERTEX_SHADER,e],[r.FRAGMENT_SHADER,t]]){let i=r.createShader(s);r.shaderSource(i,`#version 300 es
${o}`),r.compileShader(i),r.attachShader(n,i),r.deleteShader(i)}if(r.linkProgram(n),!r.getProgramParameter(n,r.LINK_STATUS)&&!r.isContextLost()){let s=(r.getAttachedShaders(n)??[]).map(o=>r.getShaderInfoLog(o));throw s.push(r.getProgramInfoLog(n)),new Error(`this GPU refuses a shader: ${s.join(" ")}`)}return n}var it=class{#e;#t=null;#r;#s;#n;#i=0;constructor(e,t){this.#e=e,this.#r=Wt(e,`#define VERTEX
${t}`,t),this.#s=e.createVertexArray(),this.#n=e.createBuffer(),e.bindVertexArray(this.#s),e.bindBuffer(e.ARRAY_BUFFER,this.#n),e.enableVertexAttribArray(0),e.vertexAttribPointer(0,3,e.FLOAT,!1,0,0)}take(e){let[t,n]=[this.#e,e?nt(e):new Float32Array(0)];this.#t=e,this.#i=n.length/3,t.bindBuffer(t.ARRAY_BUFFER,this.#n),t.bufferData(t.ARRAY_BUFFER,n,t.STATIC_DRAW)}draw(e){let[t,n]=[this.#e,this.#t];n&&(t.bindFramebuffer(t.FRAMEBUFFER,null),t.viewport(0,0,e.width,e.height),t.disable(t.BLEND),t.clearBufferfv(t.COLOR,0,[...n.background,1]),t.useProgram(this.#r),t.uniform4fv(t.getUniformLocation(this.#r,"dots"),tt(n,e)),t.bindVertexArray(this.#s),t.drawArrays(t.TRIANGLES,0,this.#i))}destroy(){let e=this.#e;e.deleteProgram(this.#r),e.deleteVertexArray(this.#s),e.deleteBuffer(this.#n)}};var jt=new Float32Array(0),bs={shapes:["RGBA32UI","RGBA_INTEGER",4],colors:["RGBA32UI","RGBA_INTEGER",4],lobes:["R32UI","RED_INTEGER",1]},xs={shapes:["RGBA32F","RGBA",4],colors:["RGB32F","RGB",3],lobes:["RG32F","RG",2]},Fo={...xs,colors:["RGB16F","RGB",3],lobes:["RG16F","RG",2]},vs=["R32UI","RED_INTEGER",1],Me=class r{static files=["view","wide","packed","whole","project","splat","resolve","count","dots"].map(e=>`${e}.glsl`);variant;levelSigma=0;supersampling=1;lost=null;onLost=()=>{};onRestored=()=>{};#e;#t;#r;#s=null;#n=bs;#i=null;#o=null;#c="";#a;#l=e=>{e.preventDefault(),this.#s=this.#i=null,this.lost="the browser took the GPU away from this page: reload it if no picture returns",this.onLost(this.lost)};#f=()=>{this.#s=null,this.#r=Vt(this.#e),this.#c="",this.#a.forget(),this.lost=null,this.onRestored()};static create(e,t,{floats:n=!1,strips:s=!1}={}){let o=e.getContext("webgl2",{alpha:!1,antialias:!1,depth:!1,powerPreference:"high-performance"});if(o===null)throw new Error("this browser cannot draw with WebGL2 here");if(!qt.some(i=>o.getExtension(i)))throw new Error("this GPU cannot draw into textures of floats");if(n&&!Ht(o))throw new Error("this GPU cannot blend 32-bit floats: use the variant halves");if(o.getParameter(o.MAX_TEXTURE_SIZE)<4096)throw new Error(`this GPU's textures are less than ${4096} pixels wide`);return new r(o,t,{floats:n,strips:s})}constructor(e,t,n){this.#e=e,this.#t=t,this.variant=n,this.#r=Vt(e),this.#a=new et(e),e.canvas.addEventListener("webglcontextlost",this.#l),e.canvas.addEventListener("webglcontextrestored",this.#f)}setScene(e){let t=this.#e;if(this.#s=this.#o=null,e.network)throw new Error("this scene needs a network for every Gaussian in every frame, which takes WebGPU: open it in a browser that has it");this.#n=e.packing?bs:this.variant.floats?xs:Fo;let{shapes:n,colors:s,lobes:o}=e;for(let[a,c]of Object.entries({shapes:n,colors:s,lobes:o}))this.#r.textures.upload(a,this.#n[a],c);t.bindFramebuffer(t.FRAMEBUFFER,this.#r.looks);let i=e.packing?[t.RG32UI,0]:[t.RGBA32F,t.R32F];["looks","opacities"].forEach((a,c)=>{let l=i[c]?this.#r.textures.make(a,i[c],Te(e.count)):null;t.framebufferTexture2D(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0+c,t.TEXTURE_2D,l,0)}),this.#E("textures of 32-bit numbers"),this.#s={...e,shapes:jt,colors:jt,lobes:jt},e.sorted&&this.#r.textures.upload("order",vs,Uint32Array.from({length:e.count},(a,c)=>c))}show(e){this.#s&&(this.#s.count=e)}update(e,t,n){if(this.#s===null)return;let s=this.#n[e];this.#r.textures.write(e,s,pe(this.#s)[e]/s[2]*t,n)}setDots(e){this.lost===null&&(this.#i??=new it(this.#e,this.#t.dots),this.#i.take(e))}drawDots(e){this.#i&&(this.#p(e),this.#i.draw(e))}setOrder(e){if(this.#s!==null){if(e.length!==this.#s.count)throw new Error(`an order of ${e.length} Gaussians does not fit this scene`);this.#r.textures.write("order",vs,0,e)}}draw(e){this.#s!==null&&(this.#p(e),this.#a.start(),this.#m(this.#s,e),this.#h(this.#s,e,null,e.height-1),this.#a.pass())}async drawUnseen(e){let t=this.#e;if(this.#s&&this.#m(this.#s,e),t.readBuffer(t.COLOR_ATTACHMENT0),t.readPixels(0,0,1,1,t.RGBA,t.FLOAT,new Float32Array(4)),t.isContextLost())throw new Error("the graphics device was lost")}get milliseconds(){return this.#a.milliseconds}async time(){this.lost===null&&await this.#a.time()}async finished(){this.#e.bindFramebuffer(this.#e.FRAMEBUFFER,null),this.#e.readPixels(0,0,1,1,this.#e.RGBA,this.#e.UNSIGNED_BYTE,new Uint8Array(4))}async fragments(){if(this.#s===null||this.#o===null)return null;let e=this.#e,{leveled:t,pixels:n}=this.#o,[s,o]=Te(this.#s.count),[i,a]=[e.createFramebuffer(),e.createRenderbuffer()];e.bindFramebuffer(e.FRAMEBUFFER,i),e.bindRenderbuffer(e.RENDERBUFFER,a),e.renderbufferStorage(e.RENDERBUFFER,e.RGBA16F,s,o),e.framebufferRenderbuffer(e.FRAMEBUFFER,e.COLOR_ATTACHMENT0,e.RENDERBUFFER,a),e.disable(e.BLEND),e.viewport(0,0,s,o),e.useProgram(this.#y(this.#s,t)),e.drawArrays(e.TRIANGLES,0,3);let c=new Float32Array(4*s*o);e.readPixels(0,0,s,o,e.RGBA,e.FLOAT,c),e.deleteFramebuffer(i),e.deleteRenderbuffer(a);let l=new Array(t?4:1).fill(0);for(let f=0;f<c.length;f+=4)l[c[f+1]]+=c[f]**2/n;return l}get variants(){return(Ht(this.#e)?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}describe(){let e=this.#e,t=e.getExtension("WEBGL_debug_renderer_info");return String(e.getParameter(t?t.UNMASKED_RENDERER_WEBGL:e.RENDERER))}async pixels(e){if(this.#s===null)throw new Error("there is no scene to draw");let t=this.#e,{width:n,height:s}=e;this.#m(this.#s,e);let[o,i]=[t.createFramebuffer(),t.createRenderbuffer()];t.bindFramebuffer(t.FRAMEBUFFER,o),t.bindRenderbuffer(t.RENDERBUFFER,i),t.renderbufferStorage(t.RENDERBUFFER,t.RGBA32F,n,s),t.framebufferRenderbuffer(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0,t.RENDERBUFFER,i),this.#h(this.#s,e,o,0);let a=new Float32Array(4*n*s);return t.readPixels(0,0,n,s,t.RGBA,t.FLOAT,a),t.deleteFramebuffer(o),t.deleteRenderbuffer(i),a}destroy(){let e=this.#e,{view:t,corners:n,quads:s,looks:o,sums:i,enlarged:a,programs:c,counters:l,textures:f}=this.#r;this.#s=null,this.#i?.destroy(),e.canvas.removeEventListener("webglcontextlost",this.#l),e.canvas.removeEventListener("webglcontextrestored",this.#f),f.destroy();for(let h of c.values())for(let u of Object.values(h).flat())e.deleteProgram(u);for(let h of l.values())e.deleteProgram(h);for(let h of[o,i,...a])e.deleteFramebuffer(h);e.deleteVertexArray(s);for(let h of[t,n])e.deleteBuffer(h);e.getExtension("WEBGL_lose_context")?.loseContext()}#p({width:e,height:t}){let{canvas:n}=this.#e;n.width!==e&&(n.width=e),n.height!==t&&(n.height=t)}#m(e,t){let n=this.#e,s=t.width*t.height;t=Se(t,this.supersampling);let{view:o,quads:i,looks:a,sums:c}=this.#r,l=this.#b(e,t),f=this.#u(e,l),[h,u]=this.#w(e.sorted,l,t);n.bindBuffer(n.UNIFORM_BUFFER,o),this.#o={leveled:l,pixels:s};let p=this.variant.floats?1:Ze,d=Je(e,t,p,this.levelSigma,this.supersampling);n.bufferSubData(n.UNIFORM_BUFFER,0,d),n.bindVertexArray(i),n.disable(n.BLEND),n.bindFramebuffer(n.FRAMEBUFFER,a),n.drawBuffers([n.COLOR_ATTACHMENT0,e.packing?n.NONE:n.COLOR_ATTACHMENT1]);let[m,w]=Te(e.count);if(n.viewport(0,0,m,w),n.useProgram(f.project),this.#a.pass("project"),n.drawArrays(n.TRIANGLES,0,3),n.bindFramebuffer(n.FRAMEBUFFER,c),n.viewport(0,0,h,u),n.enable(n.BLEND),n.useProgram(f.splat),this.#a.pass("splat"),e.sorted?(n.drawBuffers([n.COLOR_ATTACHMENT0]),n.clearBufferfv(n.COLOR,0,[0,0,0,0]),n.blendFunc(n.ONE,n.ONE_MINUS_SRC_ALPHA)):(n.drawBuffers([n.COLOR_ATTACHMENT0,n.COLOR_ATTACHMENT1]),n.clearBufferfv(n.COLOR,0,[0,0,0,1]),n.clearBufferfv(n.COLOR,1,[0,0,0,0]),n.blendFuncSeparate(n.ONE,n.ONE,n.ZERO,n.ONE_MINUS_SRC_ALPHA)),this.variant.strips)n.drawArraysInstanced(n.TRIANGLE_STRIP,0,4,e.count);else{let v=Math.ceil(e.count/ot);n.drawElementsInstanced(n.TRIANGLES,6*ot,n.UNSIGNED_SHORT,0,v)}}#h(e,t,n,s){let o=this.#e,i=Se(t,this.supersampling),{resolve:a,enlarge:c}=this.#u(e,this.#b(e,i));o.disable(o.BLEND),this.#a.pass("resolve"),c.length&&this.#g(c,i),o.bindFramebuffer(o.FRAMEBUFFER,n),o.viewport(0,0,t.width,t.height),o.useProgram(a),o.uniform1i(o.getUniformLocation(a,"last_row"),s),o.drawArrays(o.TRIANGLES,0,3)}#g(e,{width:t,height:n}){let s=this.#e,o=Z(t,n);for(let i of[2,1])s.bindFramebuffer(s.FRAMEBUFFER,this.#r.enlarged[i-1]),s.viewport(0,0,o[i][0],o[i][1]),s.useProgram(e[i-1]),s.drawArrays(s.TRIANGLES,0,3)}#b({sorted:e},{width:t,height:n}){let s=this.#e.getParameter(this.#e.MAX_TEXTURE_SIZE);return this.levelSigma>0&&!e&&Math.max(...J(t,n).size)<=s}#w(e,t,{width:n,height:s}){let{floats:o}=this.variant,i=t?J(n,s).size:[n,s],a=`${n} ${s} ${e} ${t} ${o}`;if(a===this.#c)return i;let c=this.#e,l=c.getParameter(c.MAX_TEXTURE_SIZE);if(!(n>0&&n<=l&&s>0&&s<=l))throw new Error(`an image of ${n}x${s} pixels cannot be rendered: each side must lie between 1 and ${l}`);let f=o?[c.RGBA32F,c.R32F]:[c.RGBA16F,c.R16F],{sums:h,enlarged:u,textures:p}=this.#r,d=Z(n,s);return[h,...u].forEach((m,w)=>{let v=w?`_${w}`:"";c.bindFramebuffer(c.FRAMEBUFFER,m),["color_sums","weight_sums"].forEach((_,g)=>{let E=(w===0||t)&&!(e&&g>0),k=w===0?i:d[w],S=E?p.make(`${_}${v}`,f[g],k):null;c.framebufferTexture2D(c.FRAMEBUFFER,c.COLOR_ATTACHMENT0+g,c.TEXTURE_2D,S,0)}),w&&t&&c.drawBuffers([c.COLOR_ATTACHMENT0,c.COLOR_ATTACHMENT1]),(w===0||t)&&this.#E(`pictures of ${n}x${s} floats`)}),this.#c=a,i}#v({sorted:e,packing:t},n){return{sorted:e,packed:t!==null,strips:this.variant.strips,leveled:n}}#u(e,t){let{programs:n}=this.#r,s=this.#v(e,t),o=Object.values(s).join(" "),i=n.get(o)??ps(this.#e,this.#t,s);return n.set(o,i),i}#y(e,t){let{counters:n}=this.#r,s={...this.#v(e,t),strips:!1},o=Object.values(s).join(" "),i=n.get(o)??ms(this.#e,this.#t,s);return n.set(o,i),i}#E(e){let t=this.#e;if(t.checkFramebufferStatus(t.FRAMEBUFFER)!==t.FRAMEBUFFER_COMPLETE&&!t.isContextLost())throw new Error(`this GPU cannot draw into ${e}`)}};var at=class{#e;#t;#r;#s;#n;#i;constructor(e,t,n){let{device:s}=e;this.#e=s,this.#t=t,this.#r=e.dots(n);let{UNIFORM:o,VERTEX:i,COPY_DST:a}=GPUBufferUsage;this.#s=s.createBuffer({size:80,usage:o|a});let c=nt(t);this.#i=c.length/3,this.#n=e.filled(c,i)}draw(e,t){let[n,s,o]=[this.#e,this.#r,this.#t];n.queue.writeBuffer(this.#s,0,tt(o,e));let i=n.createCommandEncoder(),a=i.beginRenderPass({colorAttachments:[{view:t,loadOp:"clear",storeOp:"store",clearValue:[...o.background,1]}]}),c=[{binding:0,resource:{buffer:this.#s}}];a.setPipeline(s),a.setBindGroup(0,n.createBindGroup({layout:s.getBindGroupLayout(0),entries:c})),a.setVertexBuffer(0,this.#n),a.draw(this.#i),a.end(),n.queue.submit([i.finish()])}destroy(){this.#s.destroy(),this.#n.destroy()}};var te=128,ys={srcFactor:"one",dstFactor:"one-minus-src-alpha",operation:"add"},Uo={color:ys,alpha:ys},Io={color:{srcFactor:"one",dstFactor:"one",operation:"add"},alpha:{srcFactor:"zero",dstFactor:"one-minus-src-alpha",operation:"add"}},Es=["float32-blendable","float32-filterable"],Re=["network","project","splat","resolve"],ct=class r{milliseconds=null;#e;#t=new Map;#r=new Map;#s=null;static async create(e,t){if(!("gpu"in navigator))throw new Error("this browser has no WebGPU on this page: it may need https, or a newer version");let n=await On();if(n===null)throw new Error("WebGPU finds no graphics adapter on this device");let o=["timestamp-query","float32-blendable","float32-filterable","shader-f16"].filter(l=>n.features.has(l));if(t&&!Es.every(l=>o.includes(l)))throw new Error("this device cannot blend and filter 32-bit floats");let{maxStorageBufferBindingSize:i,maxBufferSize:a}=n.limits,c=await n.requestDevice({requiredFeatures:o,requiredLimits:{maxStorageBufferBindingSize:i,maxBufferSize:a}});return new r(c,e)}constructor(e,t){if(this.device=e,this.#e=t,this.bilinear=e.createSampler({magFilter:"linear",minFilter:"linear"}),e.features.has("timestamp-query")){let n=16*Re.length,s=GPUBufferUsage;this.#s={queries:e.createQuerySet({type:"timestamp",count:2*Re.length}),found:e.createBuffer({size:n,usage:s.QUERY_RESOLVE|s.COPY_SRC}),read:e.createBuffer({size:n,usage:s.MAP_READ|s.COPY_DST})}}}get blendsFloats(){return Es.every(e=>this.device.features.has(e))}get number(){return this.device.features.has("shader-f16")?"f16":"f32"}network(e){return this.#n(`network ${e.packed}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#i("network",e),entryPoint:"evaluate_network"}}))}project(e,{strips:t}){return this.#n(`project ${e.packed} ${e.sorted} ${t}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#i("project",e),entryPoint:e.sorted?"project_sorted":"project_sortfree",constants:{STRIPS:Number(t)}}}))}count(e){return this.#n(`count ${e.packed} ${e.sorted}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#i("count",e),entryPoint:"count_fragments",constants:{SORTED:Number(e.sorted)}}}))}splat(e,{floats:t,strips:n},s){return this.#n(`splat ${e.packed} ${e.sorted} ${n} ${t} ${s}`,()=>{let o=e.sorted?Uo:Io,i=this.#i("splat",e);return this.device.createRenderPipeline({layout:"auto",vertex:{module:i,entryPoint:e.sorted?"corner_sorted":s?"corner_of_level":"corner_sortfree",constants:{STRIPS:Number(n)}},primitive:{topology:n?"triangle-strip":"triangle-list"},fragment:{module:i,entryPoint:e.sorted?"cover":s?"add_to_level":"add_weighted",targets:lt(e.sorted,t).map(a=>({format:a,blend:o}))}})})}enlarge(e,t){return this.#n(`enlarge ${e} ${t}`,()=>{let n=this.#i("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:n,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:n,entryPoint:"add_enlarged",constants:{LEVEL:e},targets:lt(!1,t).map(s=>({format:s}))}})})}resolve(e,t,n){return this.#n(`resolve ${e} ${n} ${t}`,()=>{let s=this.#i("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:s,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:s,entryPoint:e?"resolve_sorted":n?"resolve_levels":"resolve_sortfree",targets:[{format:t}]}})})}dots(e){return this.#n(`dots ${e}`,()=>{let t=this.device.createShaderModule({code:this.#e.dots,label:"dots"}),n=[{shaderLocation:0,offset:0,format:"float32x3"}];return this.device.createRenderPipeline({layout:"auto",vertex:{module:t,entryPoint:"corner_of_dot",buffers:[{arrayStride:12,attributes:n}]},fragment:{module:t,entryPoint:"paint_dot",targets:[{format:e}]}})})}filled(e,t){let n=Math.ceil(e.byteLength/4)*4,s=this.device.createBuffer({size:n,usage:t,mappedAtCreation:!0}),o=new Uint8Array(e.buffer,e.byteOffset,e.byteLength);return new Uint8Array(s.getMappedRange()).set(o),s.unmap(),s}bind(e,t){return this.device.createBindGroup({layout:e.getBindGroupLayout(0),entries:Object.entries(t).map(([n,s])=>({binding:Number(n),resource:s instanceof GPUBuffer?{buffer:s}:s}))})}stamps(e,t=!0,n=!0){if(this.#s===null||!(t||n))return;let s=2*Re.indexOf(e);return{querySet:this.#s.queries,...t?{beginningOfPassWriteIndex:s}:{},...n?{endOfPassWriteIndex:s+1}:{}}}async time({network:e}){if(this.#s===null||this.#s.read.mapState!=="unmapped")return;let{queries:t,found:n,read:s}=this.#s,o=this.device.createCommandEncoder();o.resolveQuerySet(t,0,2*Re.length,n,0),o.copyBufferToBuffer(n,0,s,0,s.size),this.device.queue.submit([o.finish()]),await s.mapAsync(GPUMapMode.READ);let i=new BigUint64Array(s.getMappedRange()),a=Re.map((c,l)=>[c,Number(i[2*l+1]-i[2*l])/1e6]);this.milliseconds=Object.fromEntries(e?a:a.slice(1)),s.unmap()}#n(e,t){let n=this.#r.get(e)??t();return this.#r.set(e,n),n}#i(e,t){let n=t===null?"":this.#e[t.packed?"packed":"wide"],s=`${e} ${t?.packed}`,o=this.number==="f16"?`enable f16;
`:"",a=`${e==="network"?`${o}alias Num = ${this.number};
`:""}${this.#e.view}
${n}
${this.#e[e]}`,c=this.#t.get(s)??this.device.createShaderModule({code:a,label:e});return this.#t.set(s,c),c}};function Xt(r,e){return Object.fromEntries(r.map((t,n)=>[e+n,t]))}function lt(r,e){return e?r?["rgba32float"]:["rgba32float","r32float"]:r?["rgba16float"]:["rgba16float","r16float"]}var Co=6,Do={packed:8,wide:32},Yt=new Float32Array(0),Le=class r{static files=["view","wide","packed","network","project","splat","resolve","count","dots"].map(e=>`${e}.wgsl`);variant;levelSigma=0;supersampling=1;lost=null;onLost=()=>{};#e;#t;#r;#s;#n;#i=null;#o=null;#c=null;#a=null;#l;#f;#p=null;#m;static async create(e,t,{floats:n=!1,strips:s=!1}={}){let o=await ct.create(t,n);return new r(o,e,{floats:n,strips:s})}constructor(e,t,n){let s=t.getContext("webgpu");if(s===null)throw new Error("this canvas is already drawn to in another way");let{device:o}=e;this.variant=n,this.#e=e,this.#t=o,this.#s=t,this.#r=s,this.#n=navigator.gpu.getPreferredCanvasFormat(),s.configure({device:o,format:this.#n,alphaMode:"opaque"});let i=GPUBufferUsage;this.#l=o.createBuffer({size:Ae,usage:i.UNIFORM|i.COPY_DST});let a=i.STORAGE|i.INDIRECT|i.COPY_DST;this.#f=o.createBuffer({size:4*Co,usage:a});let c=new Uint16Array(6*te);for(let l=0;l<te;l++)c.set([0,1,2,2,1,3].map(f=>4*l+f),6*l);this.#m=e.filled(c,i.INDEX),o.lost.then(({reason:l})=>{l!=="destroyed"&&this.#h("the graphics device was lost: reload the page to go on")}),o.onuncapturederror=({error:l})=>this.#h(`this GPU cannot draw the scene: ${l.message}`)}get variants(){return(this.#e.blendsFloats?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}get milliseconds(){return this.#e.milliseconds}setScene(e){this.#g();let{count:t,sorted:n}=e,s={sorted:n,packed:e.packing!==null,network:!!e.network},o=Do[s.packed?"packed":"wide"]*Math.max(t,1),i={shapes:e.shapes,colors:e.colors,lobes:e.lobes},a=Math.max(o,...Object.values(i).map(d=>d.byteLength)),{maxStorageBufferBindingSize:c,maxBufferSize:l}=this.#t.limits,f=Math.min(c,l);if(a>f)throw new Error(`${t} Gaussians need ${Math.ceil(a/2**20)} MiB at a stretch, and this device gives ${Math.floor(f/2**20)}`);let h=GPUBufferUsage,u=d=>this.#e.filled(d.length?d:new Uint32Array(16),h.STORAGE|h.COPY_DST),p=d=>this.#t.createBuffer({size:4*Math.max(1,d),usage:h.STORAGE|h.COPY_DST});this.#o={kind:s,parts:{shapes:u(i.shapes),colors:u(i.colors),lobes:u(i.lobes)},looks:this.#t.createBuffer({size:o,usage:h.STORAGE}),order:p(t),network:e.network?{weights:this.#e.filled(this.#y(e.network),h.STORAGE),lobes:p(t)}:null},this.#i={...e,shapes:Yt,colors:Yt,lobes:Yt},n&&this.setOrder(Uint32Array.from({length:t},(d,m)=>m))}show(e){this.#i&&(this.#i.count=e)}update(e,t,n){if(!this.#i||!this.#o||this.lost!==null)return;let s=4*pe(this.#i)[e]*t;this.#t.queue.writeBuffer(this.#o.parts[e],s,n)}setDots(e){this.#c?.destroy(),this.#c=e&&new at(this.#e,e,this.#n)}drawDots(e){this.lost===null&&this.#c?.draw(e,this.#w(e))}setOrder(e){this.#o?.kind.sorted&&this.#t.queue.writeBuffer(this.#o.order,0,e)}draw(e){this.lost===null&&this.#u(e,this.#w(e),this.#n)}async pixels(e){let{width:t,height:n}=e,s=Math.ceil(16*t/256)*256,o=this.#v(t,n,"rgba32float");this.#u(e,o.createView(),"rgba32float");let i=this.#t.createBuffer({size:s*n,usage:GPUBufferUsage.MAP_READ|GPUBufferUsage.COPY_DST}),a=this.#t.createCommandEncoder();a.copyTextureToBuffer({texture:o},{buffer:i,bytesPerRow:s},[t,n]),this.#t.queue.submit([a.finish()]),await i.mapAsync(GPUMapMode.READ);let c=new Float32Array(i.getMappedRange()),l=new Float32Array(4*t*n);for(let f=0;f<n;f++){let h=f*s/4;l.set(c.subarray(h,h+4*t),4*t*f)}return i.destroy(),o.destroy(),l}async drawUnseen(e){let t=this.#v(e.width,e.height,this.#n);if(this.#u(e,t.createView(),this.#n),await this.finished(),t.destroy(),this.lost!==null)throw new Error(this.lost)}async finished(){await this.#t.queue.onSubmittedWorkDone()}describe(){let e=this.#t.adapterInfo;return[e?.vendor,e?.architecture,e?.device,e?.description].filter(Boolean).join(" ")}async time(){this.lost===null&&this.#o&&await this.#e.time(this.#o.kind)}async fragments(){let[e,t,n]=[this.#o,this.#i,this.#p];if(!e||!t||!n||this.lost!==null)return null;let s=GPUBufferUsage,o=this.#e.filled(new Uint32Array(4),s.STORAGE|s.COPY_SRC),i=this.#t.createBuffer({size:o.size,usage:s.MAP_READ|s.COPY_DST}),{kind:a,parts:c,looks:l,order:f}=e,h=this.#t.createCommandEncoder(),u={0:this.#l,1:c.shapes,4:l,5:f,6:this.#f,7:o};this.#x(h,null,this.#e.count(a),u,Math.ceil(t.count/te)),h.copyBufferToBuffer(o,0,i,0,o.size),this.#t.queue.submit([h.finish()]),await i.mapAsync(GPUMapMode.READ);let p=Array.from(new Uint32Array(i.getMappedRange()),d=>d/8/n.pixels);for(let d of[o,i])d.destroy();return n.leveled?p:p.slice(0,1)}destroy(){this.#g(),this.setDots(null),this.#t.onuncapturederror=null,this.#t.destroy()}#h(e){this.lost===null&&(this.lost=e,this.onLost(e))}#g(){for(let e of this.#b())e.destroy();this.#o=this.#i=this.#p=null}#b(){if(this.#o===null)return[];let{parts:e,looks:t,order:n,network:s}=this.#o;return[...Object.values(e),t,n,...Object.values(s??{})]}#w({width:e,height:t}){return this.#s.width!==e&&(this.#s.width=e),this.#s.height!==t&&(this.#s.height=t),this.#r.getCurrentTexture().createView()}#v(e,t,n){let s=GPUTextureUsage;return this.#t.createTexture({size:[e,t],format:n,usage:s.RENDER_ATTACHMENT|s.COPY_SRC})}#u(e,t,n){let s=this.#i;if(!s||!this.#o)return;let o=Se(e,this.supersampling),{queue:i}=this.#t,{floats:a,strips:c}=this.variant,l=this.#t.limits.maxTextureDimension2D,h=Math.max(...J(o.width,o.height).size)<=l&&!s.sorted&&this.levelSigma>0,u=h?this.levelSigma:0,p=Je(s,o,a?1:Ze,u,this.supersampling);i.writeBuffer(this.#l,0,p),i.writeBuffer(this.#f,0,Uint32Array.of(c?4:6*te,0,0,0,0,0));let d=this.#S(o.width,o.height,s.sorted,h);this.#p={leveled:h,pixels:e.width*e.height};let m=this.#t.createCommandEncoder();this.#E(m,s.count,this.#o),this.#k(m,s.count,this.#o),this.#_(m,s.count,this.#o,d[0],h),h&&(this.#A(m,this.#e.enlarge(2,a),[...d[0],...d[0]],d[2],!0,!1),this.#A(m,this.#e.enlarge(1,a),[...d[0],...d[2]],d[1],!1,!1));let w=d.slice(0,2).flat();this.#A(m,this.#e.resolve(s.sorted,n,h),w,[t],!h,!0),i.submit([m.finish()])}#y(e){return this.#e.number==="f16"?Uint16Array.from(e,j):e}#E(e,t,{kind:n,parts:s,network:o}){if(o===null)return;let i={0:this.#l,1:s.shapes,4:s.lobes,5:o.weights,6:o.lobes};this.#x(e,"network",this.#e.network(n),i,Math.ceil(t/32))}#k(e,t,{kind:n,parts:s,looks:o,order:i,network:a}){let c=a?.lobes??s.lobes,l=[this.#l,s.shapes,s.colors,c,o];n.sorted||l.push(i,this.#f);let f=this.#e.project(n,this.variant);this.#x(e,"project",f,Xt(l,0),Math.ceil(t/te))}#x(e,t,n,s,o){let i=Math.max(1,Math.min(o,65535)),a=e.beginComputePass(t?{timestampWrites:this.#e.stamps(t)}:{});a.setPipeline(n),a.setBindGroup(0,this.#e.bind(n,s)),a.dispatchWorkgroups(i,Math.ceil(o/i)),a.end()}#_(e,t,{kind:n,parts:s,looks:o,order:i},a,c){let l=[{r:0,g:0,b:0,a:n.sorted?0:1},{r:0,g:0,b:0,a:0}],f=this.#e.splat(n,this.variant,c),h=e.beginRenderPass({colorAttachments:a.map((p,d)=>({view:p,loadOp:"clear",storeOp:"store",clearValue:l[d]})),timestampWrites:this.#e.stamps("splat")});h.setPipeline(f);let u={0:this.#l,1:s.shapes,4:o,5:i};h.setBindGroup(0,this.#e.bind(f,n.sorted?u:{...u,6:this.#f})),h.setIndexBuffer(this.#m,"uint16"),this.variant.strips?n.sorted?h.draw(4,t):h.drawIndirect(this.#f,0):n.sorted?h.drawIndexed(6*te,Math.ceil(t/te)):h.drawIndexedIndirect(this.#f,0),h.end()}#A(e,t,n,s,o,i){let a=e.beginRenderPass({colorAttachments:s.map(l=>({view:l,loadOp:"clear",storeOp:"store"})),timestampWrites:this.#e.stamps("resolve",o,i)});a.setPipeline(t);let c={0:this.#l,...Xt(n,1)};n.length===4&&(c[5]=this.#e.bilinear),a.setBindGroup(0,this.#e.bind(t,c)),a.draw(3),a.end()}#S(e,t,n,s){let o=`${e} ${t} ${n} ${s} ${this.variant.floats}`;if(this.#a?.key===o)return this.#a.views;for(let f of this.#a?.textures??[])f.destroy();let i=GPUTextureUsage,a=[],l=(s?[J(e,t).size,...Z(e,t).slice(1,3)]:[[e,t]]).map(f=>lt(n,this.variant.floats).map(h=>{let u=i.RENDER_ATTACHMENT|i.TEXTURE_BINDING,p=this.#t.createTexture({size:f,format:h,usage:u});return a.push(p),p.createView()}));return this.#a={key:o,textures:a,views:l},l}};async function ft(r,e){let t="";if(e!=="webgl")try{let n=await _s(Le.files);return{name:"WebGPU",renderer:await Le.create(r,n)}}catch(n){if(e==="webgpu")throw n;t=n instanceof Error?n.message:String(n)}try{return{name:"WebGL2",renderer:Me.create(r,await _s(Me.files))}}catch(n){let s=n instanceof Error?n.message:String(n);throw new Error(`this browser cannot draw the scene: ${t?`${t}; `:""}${s}`)}}async function _s(r){let e=r.map(async t=>[t.replace(/\.[a-z]+$/,""),await Fn(t)]);return Object.fromEntries(await Promise.all(e))}var ks=new Map;function As(r){let e=ks.get(r)??Bo(r);return ks.set(r,e),e}async function Bo(r){let{renderer:e}=await ft(document.createElement("canvas"),r);try{return await Wn(e,Kt())}finally{e.destroy()}}function Kt(){try{return localStorage}catch{return null}}var T=(r,e,t=1)=>[r[0]+t*e[0],r[1]+t*e[1],r[2]+t*e[2]],N=(r,e)=>T(r,e,-1),R=(r,e)=>r[0]*e[0]+r[1]*e[1]+r[2]*e[2],F=(r,e)=>[r[1]*e[2]-r[2]*e[1],r[2]*e[0]-r[0]*e[2],r[0]*e[1]-r[1]*e[0]],ge=r=>Math.hypot(...r);function H(r){let e=ge(r);return e>0?[r[0]/e,r[1]/e,r[2]/e]:[1,0,0]}function Qt(r,e,t){let[n,s]=[Math.cos(t),Math.sin(t)],o=R(r,e)*(1-n),i=F(e,r);return T(T([r[0]*n,r[1]*n,r[2]*n],i,s),e,o)}var Po=Math.cos(.5*Math.PI/180),ht=class{by="";#e=!1;#t=null;reset(e){this.by=e,this.#e=!1}invalidate(){this.#t=null}get pending(){return this.#e}received(){this.#e=!1}neededDirection({viewmat:e}){let t=[e[8],e[9],e[10]],n=this.#t!==null&&R(t,this.#t)>=Po;return!this.by||this.#e||n?null:(this.#e=this.by==="worker",this.#t=t)}};var Ss=12;function Ts(r,e,t,n,s){let{viewmat:o,fx:i,fy:a,cx:c,cy:l,near:f}=t,h=-1,u=1/0;for(let p=0;3*p<r.length;p++){if(e[p]<0)continue;let[d,m,w]=[r[3*p],r[3*p+1],r[3*p+2]],v=o[8]*d+o[9]*m+o[10]*w+o[11];if(v<=f||v>=u)continue;let _=i*(o[0]*d+o[1]*m+o[2]*w+o[3])/v+c-n,g=a*(o[4]*d+o[5]*m+o[6]*w+o[7])/v+l-s;_*_+g*g>Ss*Ss||(u=v,h=p)}return h<0?null:[r[3*h],r[3*h+1],r[3*h+2]]}function Zt(r,e,t,n){let s=n instanceof Uint32Array;for(let o=0;o*e<n.length;o++)r[t+o]=s?Zn(n[o*e]):n[o*e]}var $o=1e3,Go=50,ut=class{count=0;views=[];near=.2;up=null;logits=new Float32Array(0);request=null;fragments=null;calibrated=Promise.resolve();name="";broken=!1;#e=new Float32Array(0);#t;#r;#s=!1;#n;#i;#o=null;#c=null;#a=null;#l=null;#f=Promise.resolve(!1);#p=!1;#m=null;#h=!1;#g=2;#b=[0,0,0];#w=null;#v=[0,0,0];#u=new ht;#y=null;#E=-1/0;#k=!1;#x=!1;#_=!1;constructor(e,t,n,s,o=null){this.canvas=e,this.#i=t,this.#t=n,this.#r=o,this.#n=s}begin(e){return this.#f=this.#A(e)}async#A(e){try{let{name:t,renderer:n}=await ft(this.canvas,e);if(this.#p)return n.destroy(),!1;n.onLost=i=>this.#M(i),"onRestored"in n&&(n.onRestored=()=>this.request&&this.load(this.request));let o=n.variants.find(({floats:i,strips:a})=>i===this.#t?.floats&&a===this.#t.strips)??Vn(n,Kt());return o&&(n.variant=o),n.levelSigma=this.#r??1,this.#s=o!==null,this.#o=n,this.name=t,Xn(n),!0}catch(t){return this.#i.failed(Jt(t)),!1}}async#S(){if(this.#s||this.broken)return;this.#s=!0;let e=this.name==="WebGPU"?"webgpu":"webgl",t=await As(e);this.#o&&(this.#o.variant=t),this.#i.changed()}load(e,t=!1){this.#a?.terminate(),this.request=e;let n=Ln(e,async({data:s})=>{if(!await this.#f){n.terminate();return}(n===this.#a||n===this.#c)&&this.#I(s,n)});n.onerror=s=>{s.preventDefault(),!t&&n===this.#a?this.load(e,!0):this.#L("the viewer's own files could not be loaded: reload the page",n)},this.#a=this.#l=n}async sort(e){if(this.#u.by==="")return null;if(this.broken)throw new Error("the renderer was lost");this.#u.pending&&await this.#T();let t=performance.now();return this.#u.invalidate(),this.#z(e),this.#u.pending&&await this.#T(),performance.now()-t}#T(){return new Promise((e,t)=>this.#y={resolve:e,reject:t})}#d(e){this.#y?.reject(new Error(e)),this.#y=null}draw(e,t=1){if(this.#c===null)return;let n={...e,near:this.near};if(this.#x){this.#o?.drawDots(n),this.#U();return}this.#z(e),this.#o&&(this.#o.supersampling=t,this.#o.draw(n),this.#o.supersampling=1)}async#U(){let e=this.#o;this.#_||this.#n||!e||(this.#_=!0,await new Promise(t=>setTimeout(t,Go)),this.#x&&!this.#p&&await jn(e).catch(()=>{}))}drawOrReport(e,t){if(!this.broken)try{this.draw(e,t)}catch(n){this.#M(Jt(n))}}async finished(){await this.#o?.finished()}pixels(e){return(this.#c&&!this.#x?this.#o?.pixels(e):null)??Promise.reject(new Error("nothing can be drawn"))}get background(){return this.#w??this.#b}set background(e){this.#w=e,this.background.forEach((t,n)=>this.#v[n]=t)}get means(){return this.#e=Xe(this.#e)}get milliseconds(){return this.#o?.milliseconds??null}async time(){this.#k||!this.#o||(this.#k=!0,await this.#o.time().catch(()=>{}),performance.now()>this.#E+$o&&(this.fragments=await this.countFragments(),this.#E=performance.now()),this.#k=!1)}async countFragments(){return this.#x||this.broken?null:await this.#o?.fragments().catch(()=>null)??null}get device(){let{floats:e,strips:t}=this.#o?.variant??{floats:!1,strips:!1},n=`${e?"floats":"halves"}, ${t?"strips":"batches"}`,{by:s}=this.#u,o=this.#o?.describe()??"";return{renderer:this.name,adapter:o,variant:n,sorted:s!=="",sorted_by:s||null}}destroy(){this.#p=this.broken=!0,this.#d("the renderer was lost"),this.#a?.terminate(),this.#c?.terminate(),this.#o?.destroy(),this.#o=null}#M(e){this.broken=!0,this.#d(e),this.#i.broken(e)}#I(e,t){this.broken&&t===this.#c||(e.kind==="failed"?this.#L(e.sentence,t):e.kind==="progress"?t===this.#l&&this.#i.progress(e.received/e.total):e.kind==="dots"?this.#N(e,t):e.kind==="scene"?this.#C(e,t):e.kind==="rows"?this.#D(e):e.kind==="more"?this.#R(e.means):e.kind==="order"?this.#B(e.order):(this.#u.by!=="worker"&&t.terminate(),this.#a||(this.calibrated=this.#S().catch(()=>{})),t===this.#l&&this.#i.loaded(e.milliseconds,e.bytes)))}#L(e,t){let n=t===this.#a&&this.#m!==null;t===this.#c&&this.#d(e),t===this.#a&&(this.#a=null,this.request=this.#m),(t!==this.#c||this.#u.by!=="worker")&&t.terminate(),t===this.#l&&this.#i.failed(e,n)}#N({dots:e,...t},n){this.#u.reset(""),this.#O(n,e.background,()=>this.#o?.setDots(e))&&(this.#x=!0,this.#F(t),this.logits=new Float32Array(e.means.length/3),this.#R(e.means),this.#h||this.#i.arrived())}#C({data:e,means:t,...n},s){let o=s===this.#c;this.#u.reset(e.sorted?"worker":this.#n?"page":""),e.sorted=this.#u.by!=="",this.#O(s,e.background,()=>{this.#o&&(this.#o.setDots(null),this.#o.setScene(e),this.#o.levelSigma=this.#r??Kn(e.footprint))})&&(this.#x=!1,this.#F(n),this.logits=new Float32Array(e.count),this.#g=pe(e).lobes,Zt(this.logits,this.#g,0,e.lobes),this.#R(t),!o&&!this.#h&&this.#i.arrived())}#O(e,t,n){if(e!==this.#c&&(this.#c?.terminate(),this.#d("another scene was opened")),this.#c=e,e===this.#a&&(this.#h=this.request===this.#m&&this.count>0,this.#m=this.request,this.#a=null),this.#b=[...t],this.#v=t,this.background=this.#w,this.#o?.lost)return this.#M(this.#o.lost),!1;try{n()}catch(s){return e.terminate(),this.count=0,this.#i.failed(Jt(s)),!1}return this.broken=!1,!0}#F({views:e,near:t,up:n}){this.views=e,this.near=t,this.up=n}#R(e){this.#e=e,this.count=("stored"in e?e.stored:e).length/3,this.#o?.show(this.count),this.#u.invalidate(),this.#i.changed()}#D({part:e,from:t,numbers:n}){this.#o?.update(e,t,n),e==="lobes"&&Zt(this.logits,this.#g,t,n),this.#i.changed()}#B(e){this.#u.received(),this.#o?.setOrder(e),this.#y?.resolve(),this.#y=null,this.#i.ordered()}#z(e){let t=this.#u.neededDirection(e);t!==null&&(this.#u.by==="page"?this.#o?.setOrder(qe(this.means,t)):this.#c?.postMessage({forward:t}))}},Jt=r=>r instanceof Error?r.message:String(r);var Ms=.02,qo=/^-?\d{1,9}(\.\d{1,9})?$/,Oe=new Map([["-y",[0,-1,0]],["z",[0,0,1]],["y",[0,1,0]],["-z",[0,0,-1]],["x",[1,0,0]],["-x",[-1,0,0]]]),ne=[0,-1,0];function Rs(r){let e=H(r.reduce((n,{down:s})=>N(n,s),[0,0,0])),t=e;for(let n=0;n<200;n++){let s=T([0,0,0],t,1+Ms);for(let{right:o}of r)s=T(s,o,-R(o,t)/r.length);t=H(T(s,e,Ms*R(e,t)))}return t}function Ls(r,e){let t=R(ne,e);if(t<1e-9-1)return[r[0],-r[1],-r[2]];let n=F(ne,e),s=F(n,r);return T(T(r,s),F(n,s),1/(1+t))}function dt(r){let e=typeof r=="string"?r.trim().split(/\s+/):[];if(e.length!==3||!e.every(n=>qo.test(n)))return null;let t=e.map(Number);return t.some(n=>n!==0)?H(t):null}function Os(r,e){let t=[...Oe.keys()],n=i=>R(Oe.get(i)??ne,e),s=t.reduce((i,a)=>n(a)>n(i)?a:i),o=[null,...t.filter(i=>i!==s)];return o[(o.indexOf(r===s?null:r)+1)%o.length]}var Fs=.02,zs=.001,se=class r{constructor(e,t,n){this.eye=e,this.target=t,this.up=H(n),this.reach=ge(N(t,e))||1}static fromViews(e,t=0,n=null){let s=e.map(Ho),{eye:o,forward:i}=s[t],a=R(N(Vo(s),o),i),c=Math.max(...s.map(l=>ge(N(l.eye,o))),0)||1;return new r(o,T(o,i,a>zs*c?a:c),n??Rs(s))}static around(e,t=ne){let n=[0,1,2].map(i=>{let a=e.filter((l,f)=>f%3===i).sort(),c=l=>a[Math.floor(l*(a.length-1))]??0;return[c(.15),c(.5),c(.85)]}),s=n.map(([,i])=>i),o=Math.max(...n.map(([i,,a])=>a-i))||1;return new r(T(s,Ls([0,-.3,-1],t),1.5*o),s,t)}get forward(){return H(N(this.target,this.eye))}get right(){return H(F(this.forward,this.up))}copy(){let e=new r(this.eye,this.target,this.up);return e.reach=this.reach,e}orbit(e,t){let n=this.#e(N(this.eye,this.target),e,t);this.eye=T(this.target,n)}look(e,t){let n=this.#e(N(this.eye,this.target),e,t);this.target=N(this.eye,n)}move(e,t,n){let s=F(this.forward,this.right),o=T([0,0,0],this.right,e);o=T(T(o,s,t),this.forward,n),this.eye=T(this.eye,o),this.target=T(this.target,o)}dolly(e){let t=N(this.eye,this.target),n=Math.max(ge(t)*e,zs*this.reach);this.eye=T(this.target,H(t),n)}focus(e){ge(N(e,this.eye))>0&&(this.target=e)}viewmat(){let{forward:e,right:t,eye:n}=this,s=F(e,t),o=i=>[...i,-R(i,n)];return[...o(t),...o(s),...o(e),0,0,0,1]}#e(e,t,n){let s=Math.acos(Math.min(1,Math.max(-1,R(H(e),this.up)))),o=Math.min(Math.max(s-n,Fs),Math.PI-Fs)-s;return Qt(Qt(e,this.right,o),this.up,-t)}};function Us(r,e,t,n,s,o=null){let i=Math.tan((o??50)*Math.PI/360),a=o===null?e:null,c=a?t*a.K[0]/a.width:t/(2*i),l=a?n*a.K[4]/a.height:n/(2*i),f=Math.sqrt(c*l),h={cx:t/2,cy:n/2};return{viewmat:r.viewmat(),fx:f,fy:f,...h,width:t,height:n,near:s}}function Ho({viewmat:r}){let e=i=>[r[4*i],r[4*i+1],r[4*i+2]],[t,n,s]=[e(0),e(1),e(2)],o=T([0,0,0],t,-r[3]);return o=T(T(o,n,-r[7]),s,-r[11]),{eye:o,right:t,forward:s,down:n}}function Vo(r){let e=[.001,0,0,0,.001,0,0,0,.001],t=[0,0,0];for(let{eye:c,forward:l}of r){for(let f=0;f<3;f++)for(let h=0;h<3;h++)e[3*f+h]+=(f===h?1:0)-l[f]*l[h];t=T(T(t,c,1+.001/r.length),l,-R(l,c))}let n=c=>[e[c],e[3+c],e[6+c]],[s,o,i]=[n(0),n(1),n(2)],a=R(s,F(o,i));return[R(t,F(o,i))/a,R(s,F(t,i))/a,R(s,F(o,t))/a]}var Wo=16.666666666666668,jo=1e3/50,Xo=1e3/45,Is=1e3/26,Yo=3,Ko=200,Qo=.9,Ns=[4,64],Zo=[1,.85,.7,.6,.5],Fe=class{#e=0;#t=[];#r;#s=Xo;#n={step:0,median:1/0};#i=0;#o=Ns[0];constructor(e){this.fixed=e,this.#r=e===null?Zo:[e]}get scale(){return this.#r[this.#e]}reduced(e){return(e?this.scale:this.#r[0])<1}size(e,t,n,s){let o=Math.min(n,2)*(s?this.scale:this.#r[0]),i=a=>Math.max(1,Math.round(a*o));return{width:i(e),height:i(t)}}note(e){this.#t.push(e);let{length:t}=this.#t;if(t<Yo||this.#t.reduce((s,o)=>s+o)<Ko)return;let n=this.#t.sort((s,o)=>s-o)[t>>1];this.#t=[],n>this.#s?this.#c(n):n>=jo||this.#e===0?this.#i=0:++this.#i>=this.#o&&(this.#e-=1,this.#i=0)}#c(e){let{step:t,median:n}=this.#n;if(this.#i=0,this.#o=Math.min(2*this.#o,Ns[1]),t<this.#e&&e<Is&&e>Qo*n){this.#e=t,this.#s=Is;return}this.#n={step:this.#e,median:e};let s=this.scale*Math.sqrt(Wo/e),o=this.#r.findIndex(i=>i<this.scale&&i<=s);this.#e=o<0?this.#r.length-1:o}};function Cs({fx:r,fy:e,width:t,height:n},s){if(s.length===0)return 1;let o=Math.sqrt(s[0].K[0]*s[0].K[4]),i=Math.min(4,Math.floor(4096/Math.max(t,n)));return Math.max(1,Math.min(Math.floor(o/Math.sqrt(r*e)+.5),i))}var Jo=100,Ds=150,ei=9*Math.PI/180,pt=class{mode="orbit";pose=new se([0,0,-3],[0,0,0],[0,-1,0]);fov=null;timed=!1;turning=!1;measured=!1;#e;#t;#r;#s;#n;#i=null;#o="auto";#c=null;#a=null;#l;#f;#p=this.pose;#m=!1;#h=0;#g=0;#b=-1/0;#w=!1;#v=0;#u=0;#y;constructor(e,t,{variant:n=null,levels:s=null}={}){this.#t=e,this.#e=t,this.#r=n,this.#s=s,this.#l=new Fe(null),this.#n=this.#k(e,0,!1),this.#f=new Ge(e,{pose:()=>this.pose,mode:()=>this.mode,held:()=>this.turning=!1,changed:()=>{this.#b=performance.now(),this.turning=!1,this.redraw()},focus:(o,i)=>this.#d(o,i)}),this.#y=new ResizeObserver(()=>this.redraw()),this.#y.observe(e)}begin(e){return this.#o=e,this.#n.begin(e)}load(e){this.#n.request&&(this.#m=!1,this.#a=null),this.#n.load(e)}async compare(e,t,n){this.endComparison();let s=this.#k(e,1,n);s.background=this.#c,this.#i=s,await this.#n.calibrated,s===this.#i&&await s.begin(this.#o)&&s===this.#i&&s.load(t)}endComparison(){this.#i?.destroy(),this.#i=null}redraw(){!this.#h&&!this.measured&&(this.#h=requestAnimationFrame(e=>this.#S(e)))}reset(e){let{views:t}=this;this.pose=e===void 0||t.length===0?this.#p.copy():se.fromViews(t,(e%t.length+t.length)%t.length,this.#A),this.redraw()}get up(){return this.#a}set up(e){let t=e!==null&&Oe.has(e)?e:null;t!==this.#a&&(this.#a=t,this.#n.count&&(this.#p=this.#_(),this.reset()))}turnUp(){let{views:e}=this,t=this.#n.up??(e.length?se.fromViews(e).up:ne);return this.up=Os(this.#a,t),this.#a??""}place(e){this.pose=e,this.#m=!0,this.redraw()}camera(e,t){return Us(this.pose,this.views[0]??null,e,t,this.#n.near,this.fov)}get views(){return this.#n.views.length?this.#n.views:this.#i?.views??[]}get count(){return this.#n.count}get calibrated(){return this.#n.calibrated}get source(){let{request:e}=this.#n;return e===null||"forward"in e?null:"url"in e?e.url:e.file}get device(){return this.#n.device}get scale(){return this.#l.fixed}set scale(e){this.#l=new Fe(e),this.redraw()}get choices(){let{mode:e,fov:t,turning:n,scale:s,timed:o,up:i}=this;return{mode:e,fov:t,turning:n,scale:s,timed:o,up:i,background:this.#c}}get background(){return this.#n.background}set background(e){this.#c=e;for(let t of this.#E)t.background=e;this.redraw()}async drawAndWait(e,t){let n=this.camera(e,t),s=await this.#n.sort(n);if(this.#n.draw(n),await this.finished(),this.#n.broken)throw new Error("the renderer was lost");return s}async finished(){await this.#n.finished()}async passes(){return await this.#n.time(),this.#n.milliseconds}fragments(){return this.#n.countFragments()}pixels(e,t=0){return this.#E[t]?.pixels(e)??Promise.reject(new Error("there is no other scene"))}screenshot(e=1){let{width:t,height:n}=this.#T(),s=document.createElement("canvas");[s.width,s.height]=[t,n];let o=s.getContext("2d");return this.#E.forEach(({canvas:i},a)=>{let c=a*Math.round(e*t),l=t-c;l>0&&o?.drawImage(i,c,0,l,n,c,0,l,n)}),new Promise(i=>s.toBlob(i,"image/png"))}destroy(){cancelAnimationFrame(this.#h),clearTimeout(this.#u),clearTimeout(this.#v),this.#f.destroy(),this.#y.disconnect();for(let e of this.#E)e.destroy()}get#E(){return this.#i?[this.#n,this.#i]:[this.#n]}#k(e,t,n){let s={progress:o=>this.#e.progress(t,o),arrived:()=>this.#x(t),changed:()=>{this.#v||=setTimeout(()=>this.redraw(),Jo)},ordered:()=>this.redraw(),loaded:(o,i)=>{this.#e.loaded(t,o,i),this.redraw()},failed:(o,i)=>this.#e.failed(t,o,i),broken:o=>this.#e.broken(t,o)};return new ut(e,s,this.#r,n,this.#s)}#x(e){let{views:t}=this;(e===0||!this.#n.views.length&&this.#b===-1/0)&&(t.length||this.#n.count)&&(this.#p=this.#_(),this.#m||this.reset()),this.redraw()}#_(){let{views:e}=this;return e.length&&this.#a===null?se.fromViews(e,0,this.#A):se.around(this.#n.means,this.#A??ne)}get#A(){return Oe.get(this.#a??"")??this.#n.up}#S(e){this.#h=0,clearTimeout(this.#v),this.#v=0;let t=e-this.#g;this.#g=e;let n=this.#w,s=this.turning&&this.count>0;this.#w=performance.now()-this.#b<Ds||this.#f.busy||s,this.#w&&n&&this.#l.note(t);let o=Math.min(t,100)/1e3;this.#f.advance(o),s&&this.pose.orbit(ei*o,0);let{width:i,height:a}=this.#T();if(clearTimeout(this.#u),this.#w&&(this.#u=setTimeout(()=>this.redraw(),2*Ds)),this.count&&!this.#n.broken){let{name:c,count:l,milliseconds:f,fragments:h}=this.#n,u=this.#w&&n?t:0,p=this.#i?.count??0;this.#e.drawn({renderer:c,count:l,compared:p,width:i,height:a,milliseconds:u,passes:f,fragments:h}),this.timed&&this.#n.time()}(this.#f.busy||s)&&this.redraw()}#T(){let{clientWidth:e,clientHeight:t}=this.#t,n=this.#l.size(e,t,devicePixelRatio,this.#w);if(e&&t){let s=this.camera(n.width,n.height),o=this.#l.reduced(this.#w)?1:Cs(s,this.views);for(let i of this.#E)i.drawOrReport(s,o)}return n}#d(e,t){let{clientWidth:n,clientHeight:s}=this.#t,{means:o,logits:i}=this.#n,a=Ts(o,i,this.camera(n,s),e,t);a&&this.pose.focus(a),this.redraw()}};var Bs=["settings","help","report"],Ps=["scale","background","fov","up","autorotate"],ti=2e3,$s="sorted",ni={rootMargin:"100%"},si="(prefers-reduced-motion: reduce)",en=class extends(globalThis.HTMLElement??Object){static observedAttributes=["src","compare",...Ps];viewer=null;#e;#t=null;#r=new xe;#s=null;#n;#i=!1;#o=!1;#c=null;#a=[];#l=0;#f=Promise.resolve(!1);#p=!1;#m=new IntersectionObserver(e=>e.some(t=>t.isIntersecting)&&this.#h(),ni);constructor(){super(),this.#e=this.attachShadow({mode:"open",delegatesFocus:!0}),this.#e.innerHTML=Tn;for(let t of this.#e.querySelectorAll("button"))t.addEventListener("click",()=>this.act(t.dataset.act??""));this.#e.addEventListener("keydown",t=>{let{code:n,key:s,ctrlKey:o,metaKey:i,altKey:a,repeat:c,target:l,defaultPrevented:f}=t,h=Ot.get(s.toLowerCase())??Ot.get(n.slice(3).toLowerCase()),u=f||l.matches("textarea, select");h&&!o&&!i&&!a&&!c&&!u&&this.act(h),n==="Escape"&&this.act("close")}),this.#e.addEventListener("keyup",t=>{let{code:n,target:s}=t,{classList:o}=s;n==="Tab"&&(o.add("reached"),s?.addEventListener("blur",()=>o.remove("reached"),{once:!0}))}),this.#d("settings").addEventListener("input",({target:t})=>{let n=t;n.name==="stats"?this.act("stats"):this.viewer&&An(n,this.viewer)}),this.addEventListener("dragover",t=>{t.preventDefault(),this.#d("drop").hidden=!1}),this.addEventListener("dragleave",()=>this.#d("drop").hidden=!0),this.addEventListener("drop",t=>{t.preventDefault(),this.#d("drop").hidden=!0,this.#y(t.dataTransfer?.files)});let e=this.#u;e.addEventListener("change",()=>{this.#x(null),this.#y(e.files),e.value=""})}connectedCallback(){queueMicrotask(()=>{if(!this.isConnected||this.viewer)return;let e=this.getAttribute("poster")?.replace(/[\x22\\\n]/g,encodeURIComponent);e&&(this.style.background=`center / cover no-repeat url("${e}")`),this.getAttribute("loading")==="lazy"?this.#m.observe(this):this.#h()})}#h(e=this.getAttribute("renderer")??"auto"){this.#m.disconnect(),this.#d("buttons").hidden=this.hasAttribute("noui"),this.#e.querySelector("[data-act=full]").hidden=!document.fullscreenEnabled;let t=this.#e.querySelector("canvas"),n=this.getAttribute("variant"),[s,o]=["floats","strips"].map(l=>!!n?.includes(l)),i=Number(this.getAttribute("levels")??NaN);this.viewer=new pt(t,this,{variant:n===null?null:{floats:s,strips:o},levels:i===0||i>=.6&&i<=100?i:null}),t.setAttribute("aria-label",`${this.getAttribute("alt")??"3D scene"}. Press H for the keys.`),t.classList.toggle("polite",this.hasAttribute("polite"));for(let l of Ps)this.#_(l);this.#f=this.viewer.begin(e),this.#p=!1,this.#f.then(l=>this.#p=!l);let a=this.#s??this.getAttribute("src"),c=this.#n===void 0?this.getAttribute("compare"):this.#n;a&&this.open(a),c&&this.compare(c)}disconnectedCallback(){this.#m.disconnect(),this.#g()}#g(){this.viewer?.destroy(),this.viewer=null,this.#T(),this.#r=new xe;let e=this.#e.querySelector("canvas");e?.classList.remove("drawn"),e?.replaceWith(e.cloneNode())}attributeChangedCallback(e,t,n){e==="src"&&(this.#s=null),e==="compare"&&(this.#n=void 0),!(!this.viewer||n===t)&&(e==="compare"?this.compare(n||null):e!=="src"?this.#_(e):n&&this.open(n))}async open(e){this.#s=e,this.#o=this.#i,await this.#A(0,e,(t,n)=>{t.load(n),this.#_("up")})}async compare(e){this.#n=e,this.#o=!1,this.#i=e===$s;let t=this.#i?this.#s:e;this.viewer?.endComparison(),this.#T(),this.#r.begin(1),this.#S(),t!==null&&await this.#A(1,t,(n,s)=>{this.#T();let o=document.createElement("canvas");o.className="over",o.setAttribute("aria-hidden","true"),this.#d("split").before(o),this.#t=new $e(this.#d("split"),o),n.compare(o,s,this.#i)})}act(e){let t=this.viewer;if(t){if(e==="reset"||e==="view")t.turning=!1,t.reset(e==="view"?++this.#l:void 0);else if(e==="help"||e==="settings")this.#x(e);else if(e==="stats")t.timed=this.#k("stats");else if(e==="own")t.background=null;else if(e==="up"){let n=t.turnUp();this.#b(n?`The axis ${n} points up.`:"The scene's own direction points up.",!0)}else if(e==="mode"){let n=t.mode==="fly";t.mode=n?"orbit":"fly",this.#b(`Dragging ${n?"rotates the scene":"looks around"}.`,!0)}else e==="picture"?this.#E():e==="open"?this.#u.click():e==="copy"?this.#v():e==="share"?navigator.share?.({text:this.#w}).catch(()=>{}):e==="full"?document.fullscreenElement?document.exitFullscreen():this.requestFullscreen?.().catch(()=>{}):e==="close"&&(this.#d("message").hidden=!0,this.#x(null));kn(this.#d("settings"),t,!this.#d("stats").hidden),t.redraw()}}progress(e,t){this.#r.note(e,{share:t,state:"loading"}),this.#S()}loaded(e,t,n){this.#r.note(e,{share:1,state:"loaded"}),this.#S(),e!==1&&(this.#o&&this.compare($s),this.#b(`${this.viewer?.count.toLocaleString("en")} Gaussians loaded.`),this.dispatchEvent(new CustomEvent("load",{detail:{milliseconds:t,bytes:n}})))}failed(e,t,n=!1){this.#r.fail(e,t,n),e===0&&(this.#o=!1),this.#S(),this.#d("message").hidden=!1,e===0&&(this.#s=this.viewer?.source??this.#s),this.#e.querySelector(".message [data-act=open]").hidden=!!this.viewer?.count,this.dispatchEvent(new CustomEvent("error",{detail:{sentence:t}}))}broken(e,t){let n=this.viewer;if(!n||n.device.renderer==="WebGL2"||this.getAttribute("renderer")==="webgpu"){this.failed(e,t);return}console.warn(`WebGL2 takes over: ${t}`),this.#g(),this.#h("webgl"),Object.assign(this.viewer,n.choices),n.count&&this.viewer?.place(n.pose)}report(e){let t=JSON.stringify(e,null,1),n=this.#d("report");n.querySelector("textarea").value=t;let s=e.scenes,o=s.some(a=>a.interrupted),i=s.map(({cold:a,steady:c})=>`${a.fps} frames/s cold, ${c.fps} steady`).join(" | ");n.querySelector("h2").textContent=o?"The page was hidden during the measurement: measure again":i,n.querySelector("[data-act=share]").hidden=!navigator.share,n.hidden&&this.#x("report"),this.dispatchEvent(new CustomEvent("report",{detail:e}))}drawn(e){this.#e.querySelector("canvas")?.classList.add("drawn"),e.compared&&this.#d("split").hidden&&this.#t?.show(this.#r.names),this.dispatchEvent(new CustomEvent("frame",{detail:e}));let t=this.#d("stats");if(t.hidden)return;e.milliseconds&&(this.#a=[...this.#a.slice(-29),e.milliseconds]);let n=this.#a.reduce((i,a)=>i+a,0)/this.#a.length,s=[e.count,e.compared].filter((i,a)=>a===0||i),o=[`${e.renderer}, ${e.width} x ${e.height}`,`${s.map(i=>i.toLocaleString("en")).join(" | ")} Gaussians`,this.#a.length?`${(1e3/n).toFixed(0)} frames/s, ${n.toFixed(1)} ms`:"still",...e.fragments?ri(e.fragments):[],...Object.entries(e.passes??{}).map(([i,a])=>`${i} ${a.toFixed(2)} ms`)];t.textContent=o.join(`
`)}#b(e,t=!1){let n=this.#d("said");n.textContent=e,n.classList.toggle("seen",t),setTimeout(()=>n.classList.remove("seen"),ti)}get#w(){let e=this.#e.querySelector("textarea");return e.focus(),e.select(),e.value}async#v(){let e=this.#w,t=navigator.clipboard?await navigator.clipboard.writeText(e).then(()=>!0,()=>!1):document.execCommand("copy");this.#d("copied").textContent=t?"Copied.":"This browser does not allow copying: the text is selected, press Ctrl+C."}get#u(){return this.#e.querySelector("[type=file]")}#y(e){let[t,n]=e??[];t&&this.open(t),n&&this.compare(n)}async#E(){let e=await this.viewer?.screenshot(this.#t?.share);if(!e)return;let t=document.createElement("a");Object.assign(t,{href:URL.createObjectURL(e),download:"scene.png"}).click(),setTimeout(()=>URL.revokeObjectURL(t.href),1e3)}#k(e,t){let n=this.#d(e);return n.hidden=t===void 0?!n.hidden:!t,this.#e.querySelector(`[data-act=${e}]`)?.setAttribute("aria-expanded",String(!n.hidden)),!n.hidden}#x(e){Bs.every(n=>this.#d(n).hidden)&&(this.#c=this.#e.activeElement);let t=e!==null&&this.#d(e).hidden;for(let n of Bs)this.#k(n,t&&n===e);t?this.#d(e).focus():(this.#c??this.#e.querySelector("canvas"))?.focus({preventScroll:!0})}#_(e){let t=this.viewer,n=this.getAttribute(e),s=Number(n);e==="scale"?t.scale=s>0&&s<=1?s:null:e==="fov"?t.fov=s>=1&&s<=150?s:null:e==="background"?t.background=Pe(n):e==="up"?t.up=n:t.turning=n!==null&&!matchMedia(si).matches,t.redraw()}async#A(e,t,n){let s=this.viewer;if(s===null||this.#p)return;let o=this.#n;if(e===1&&(!await this.#f||s!==this.viewer||o!==this.#n))return;let i=typeof t=="string"?t.replace(/[?#].*$/,""):"scene",a=t instanceof File?t.name:i;this.#r.begin(e,e===1&&this.#i?`${a}, sorted`:a),this.#S();try{let c=t instanceof Blob?{file:t}:{url:new URL(t,document.baseURI).href};n(s,c)}catch(c){this.failed(e,`the scene cannot be opened: ${c.message}`)}}#S(){let{state:e,busy:t,share:n,sentence:s,names:o}=this.#r,i=this.#d("bar");i.hidden=!t,i.classList.toggle("unknown",Number.isNaN(n));let a=Math.min(100,Math.round(100*n))||0;i.setAttribute("aria-valuenow",String(a)),i.firstElementChild.style.width=`${a}%`;let c=this.#d("message"),l=c.querySelector("p");l.textContent!==s&&(l.textContent=s),s||(c.hidden=!0),this.#d("split").hidden||this.#t?.show(o),e&&(this.dataset.state=e)}#T(){this.#d("split").hidden=!0,this.#e.querySelector(".over")?.remove(),this.#t=null}#d(e){return this.#e.querySelector(`.${e}`)}};function ri(r){let e=s=>s.toFixed(1),t=r.reduce((s,o)=>s+o),n=[`${e(t)} fragments per pixel`];return r.length>1?[...n,`${r.map(e).join(" + ")} by level`]:n}globalThis.customElements?.define("mobile-gs",en);var x=128,oi=1e-12,Gs=new Float32Array(0),mt=class{wasmMemory=null;#e=[];#t=0;#r=null;#s;constructor(e=!1){this.#s=e}block(e){return this.#n(e,x*e,null)}part({at:e},t,n){let s={at:e+4*x*t,width:n,numbers:Gs};return this.#e.push([s,null,x*n]),s}layer(e,t,n){let s=n?n.length:e.length/t,o=Math.ceil(s/4)*4,i=new Float32Array(o*t);for(let l=0;l<s;l++){let f=(l-l%4)*t+l%4;for(let h=0;h<t;h++)i[f+4*h]=e[l*t+h]}let a=new Float32Array(o);n&&a.set(n);let c=l=>this.#n(0,l.length,l);return{inputs:t,outputs:o,weights:c(i),offsets:c(a)}}#n(e,t,n){let s={at:this.#t,width:e,numbers:Gs};return this.#e.push([s,n,t]),this.#t+=16*Math.ceil(t/4),s}allocate(){this.wasmMemory=He(this.#t);let e=this.wasmMemory?.buffer??new ArrayBuffer(this.#t);for(let[t,n,s]of this.#e.splice(0))t.numbers=new Float32Array(e,t.at,s),n&&t.numbers.set(n);this.#r=this.#s?null:ue(this.wasmMemory)}apply({inputs:e,outputs:t,weights:n,offsets:s},o,i,a){if(this.#r){this.#r.layer(n.at,s.at,o.at,i.at,e,t,a);return}let[c,l,f,h]=[o,i,n,s].map(({numbers:u})=>u);for(let u=0;u<t;u++){let p=(u-u%4)*e+u%4;for(let d=0;d<x;d++){let m=h[u];for(let w=0;w<e;w++)m+=f[p+4*w]*c[w*x+d];l[u*x+d]=Math.max(m,a*m)}}}units({at:e,width:t,numbers:n},{at:s,numbers:o}){if(this.#r){this.#r.units(e,s,t);return}for(let i=0;i<x;i++){let a=0;for(let l=i;l<x*t;l+=x)a+=n[l]*n[l];let c=1/Math.max(Math.sqrt(a),oi);for(let l=i;l<x*t;l+=x)o[l]=n[l]*c}}};var ii=80;function qs(r){let e=0;for(let{count:t,size:n,length:s}of r.values())e+=t*n*s;return e}function Hs(r,e){let t=0,n=new Map;for(let[s,{count:o,size:i,length:a}]of e){let c=()=>r.subarray(t,t+=i*a);n.set(s,{length:a,books:Array.from({length:o},c)})}if(n.get("scale")?.books.some(s=>s.some(o=>o>ii)))throw new y("the codebooks of the .mgs file hold scales that are out of range");return n}function Vs(r){return new Map([...r].map(([e,{step:t,columns:n}])=>{let s=n.map(({least:o,size:i})=>Float32Array.from({length:i},(a,c)=>(o+c)*t));return[e,{length:1,books:s,middles:n.map(({least:o,middle:i})=>i-o)}]}))}function Ws({name:r,codec:e,data:t},n,s){if(e==="rans")return ie(t,n,s);let o=32-Math.clz32(s-1),i=he(t,o*n),a=new Uint16Array(n);for(let c=0;c<n;c++){let l=i.take(o);if(l>=s)throw new y(`the stream '${r}' points outside of its codebook`);a[c]=l}return a}function ze({length:r,books:e,middles:t}){let n=new Uint16Array(x);return{length:r,books:e.map((s,o)=>t?s.subarray(t[o],t[o]+1):ai(s,r)),columns:e.map(()=>n)}}function ai(r,e){let t=new Float64Array(e);for(let n=0;n<r.length;n++)t[n%e]+=r[n]*e/r.length;return Float32Array.from(t)}function P({length:r,books:e,columns:t},n,s,o,i){for(let a=0;a<e.length;a++){let c=e[a],l=t[a],f=a*r*s;if(r===1){for(let h=o;h<i;h++)n[f++]=c[l[h]];continue}for(let h=0;h<r;h++,f=(a*r+h)*s)for(let u=o;u<i;u++)n[f++]=c[l[u]*r+h]}}var ci=[53,210,405,600,787,970,1151,1329],li=Uint8Array.from({length:1330},(r,e)=>ci.filter(t=>t<=e).length),tn=Float64Array.from({length:512},(r,e)=>(e+.5)/2**(31-Math.clz32(e))-1.5),fi=2.5,nn=(r,e)=>li[Math.min(256*Math.abs(Math.fround(r-e)),1329)|0];function js(r,e,t){let[n,s,o]=t,i=n.length,a=[new Uint16Array(i),new Uint16Array(i),new Uint16Array(i)],[c,l,f]=a,[h,u,p]=e,d=new re(r),m=0;for(let w=0;w<i;w++){let v=h[n[w]],_=u[s[w]],g=p[o[w]],E=nn(_,g),k=nn(v,g),S=nn(v,_),U=d.take(E+k+S);c[w]=1<<E|U&(1<<E)-1,l[w]=1<<k|U>>>E&(1<<k)-1,f[w]=1<<S|U>>>E+k,m+=E+k+S}return he(r,m),a}function Xs({step:r,columns:[{least:e},{least:t},{least:n}]},s,o,i,a){let[c,l,f,h,u,p]=s;for(let d=o,m=0;d<i;d++,m++){let w=r*(c[d]+e+tn[h[d]]),v=r*(l[d]+t+tn[u[d]]),_=r*(f[d]+n+tn[p[d]]),g=(w*w+v*v+_*_)/4,E=1+g*(-1/2+g*(1/24+g*(-1/720+g*(1/40320+g*(-1/3628800+g*(1/479001600-g/87178291200)))))),k=1/2+g*(-1/12+g*(1/240+g*(-1/10080+g*(1/725760+g*(-1/79833600+g/12454041600)))));if(g>fi){let S=Math.sqrt(g);E=Math.cos(S),k=Math.sin(S)/(2*S)}a[m]=E,a[m+x]=k*w,a[m+2*x]=k*v,a[m+3*x]=k*_}}var hi=256,Ys=["raw","halves","planes"],ui=["bits","rans"],Ks=[["scale","rotation"],["appearance","opacity"],["lobes"]],rn=Ks.length,Ue=2,sn=class{positions=null;columns=new Map;#e;constructor(e,t){this.#e=e,this.count=t}get stage(){let e=Ks.findIndex(t=>!t.every(n=>this.#t(n)));return e<0?rn:e}rows(e,t,n="slice"){let s=[...this.columns].filter(([i])=>this.#t(i)).map(([i,a])=>[i,a.map(c=>c[n](e,t))]);return{positions:this.positions[n](3*e,3*t),columns:Object.fromEntries(s)}}#t(e){let{cuts:t,scalars:n}=this.#e,s=n.size&&e==="rotation"?3:0,o=(t.get(e)?.count??n.get(e)?.columns.length??0)+s;return Object.keys(this.columns.get(e)??[]).length===o}},wt=class{levels;network=null;#e;#t;#r=new Map;#s=new Map;#n=new Map;#i={};#o={};constructor(e,t){this.#e=e,this.#t=t;let{network:n,lobes:s,cuts:o,scalars:i,lodSizes:a}=e;n&&this.#l("view-network",es,f=>this.network=f),s&&this.#l("lobe-decoder",ts(s),f=>this.#i=f),this.#l(...Jn(e),f=>this.#o=f),i.size?this.#n=Vs(i):this.#a("codebooks",Ys,[],f=>{this.#n=Hs(It(f,qs(o)),o)});let c=[...this.#r.keys()],l=0;this.levels=a.map((f,h)=>(l+=f,this.#c(f,h?`@${h}`:"",c,l)))}#c(e,t,n,s){let{cuts:o,scalars:i}=this.#e,a=new sn(this.#e,e),[c,...l]=["positions","scale.0","scale.1","scale.2"].map(u=>u+t),f=(u,p)=>{let d=[];a.columns.set(u,d);for(let[m,w]of p.entries())this.#a(`${u}.${m}${t}`,ui,[c],v=>{d[m]=Ws(v,e,w)})},h=({data:u})=>{a.positions=Pn(u,e)};this.#a(c,["morton-class"],n,h,s);for(let[u,{count:p,size:d}]of o)f(u,Array(p).fill(d));for(let[u,{columns:p}]of i)f(u,p.map(({size:d})=>d));if(i.size){let[u,p]=["scale","rotation"].map(d=>a.columns.get(d)??[]);this.#a(`rotation-finer${t}`,["bits"],[c,...l],({data:d})=>{let{books:m}=this.#n.get("scale");js(d,m,u).forEach((w,v)=>p[3+v]=w)})}return a}accept(e){this.#r.has(e.name)&&this.#s.set(e.name,e)}step(e){for(let[t,{after:n,minBytes:s,read:o}]of this.#r){let i=this.#s.get(t);if(!(i===void 0||e<s||n.some(a=>this.#r.has(a))))return o(i),this.#r.delete(t),this.#s.delete(t),!0}return!1}get decoderInputs(){let[{count:e,positions:t}]=this.levels,n=t,s=Math.min(e,hi),o=new Uint16Array(3*s).map((c,l)=>n[3*Math.floor(Math.floor(l/3)*e/s)+l%3]),[i,a]=[this.#e,this.#n];return{header:i,books:a,appearance:this.#o,lobes:this.#i,samples:o}}#a(e,t,n,s,o=0){let i=this.#t.find(a=>a.name===e);if(i===void 0)throw new y(`the .mgs file lacks its stream '${e}'`);if(!t.includes(i.codec))throw new y(`the stream '${e}' of the .mgs file uses the codec '${i.codec}', which this program does not know`);this.#r.set(e,{after:n,minBytes:o,read:s})}#l(e,t,n){this.#a(e,Ys,[],s=>n(ss(It(s,ns(t)),t)))}};var C=new Int32Array(2048);for(let r=0;r<C.length;r++){let e=r<256?r:C[r-256];for(let t=0;t<8;t++)e=(e&1?3988292384:0)^e>>>1;C[r]=e}function gt(r,e=0){let t=~e,n=0;for(;n+8<=r.length;n+=8)t^=r[n]|r[n+1]<<8|r[n+2]<<16|r[n+3]<<24,t=C[1792+(t&255)]^C[1536+(t>>>8&255)]^C[1280+(t>>>16&255)]^C[1024+(t>>>24)]^C[768+r[n+4]]^C[512+r[n+5]]^C[256+r[n+6]]^C[r[n+7]];for(;n<r.length;n++)t=C[(t^r[n])&255]^t>>>8;return~t>>>0}var be=[77,71,83,26,13,10,0,1],on=[2,3,4],bt=20,di=2**20,pi=256,mi=2**32,wi=[["ply","a PLY scene: train or compress it first"],["PK","a zip archive (perhaps .sog)"],["\x8B","a gzip file (perhaps .spz)"],["NGSP","an .spz scene"],["glTF","a binary glTF file"],["\xFD7zXZ","an xz file (perhaps another program's comp.xz)"],["\x89PNG","a PNG picture"],["\xFF\xD8\xFF","a JPEG picture"],["<","a web page"],["{","a JSON text"]],vt=class{received=0;total=1/0;fields=null;table=[];#e=[];#t=0;#r=0;#s=!1;#n=null;append(e){if(e.length>0&&this.#e.push(e),this.received+=e.length,this.#t+=e.length,!this.#i())return[];if(this.received>this.total)throw new y(`the .mgs file has ${this.received-this.total} bytes too many at its end`);let t=[];for(let n;(n=this.table[this.#r])&&an(n.bytes)<=this.#t;)this.#r++,t.push(gi(n,this.#c(an(n.bytes))));return t}end(){if(this.fields!==null){let t=this.table[this.#r];if(t===void 0)return;throw new y(`the .mgs file ends inside its stream '${t.name}': it has been cut short`)}if(!this.#s)throw new y(Qs(this.#c(this.#t)));let e=this.#n===null?"first bytes":"header";throw new y(`the .mgs file ends inside its ${e}: it has been cut short`)}#i(){if(!this.#s&&this.#t>=be.length){let e=this.#c(be.length);if(be.some((t,n)=>t!==e[n]))throw new y(Qs(e));this.#s=!0}if(this.#s&&this.#n===null&&this.#t>=bt-be.length&&(this.#n=this.#c(bt-be.length)),this.#n!==null&&this.fields===null){let e=bi(this.#n);this.#t>=e&&this.#o(this.#n,this.#c(e))}return this.fields!==null}#o(e,t){let n=q(e).getUint32(8,!0);if((bt+t.length)%8||gt(t,gt(e.subarray(0,8)))!==n)throw new y("the header of the .mgs file is damaged (wrong checksum)");this.fields=vi(t);let s=q(e).getUint16(0,!0);if((s===2||s===4&&this.fields.layers===void 0)&&(this.fields.layers=[this.fields.count]),s<4&&(this.fields.footprint=ee),this.table=xi(this.fields.streams),this.total=this.table.reduce((o,i)=>o+an(i.bytes),bt+t.length),this.total>mi)throw new y(`the .mgs file claims ${this.total} bytes, too many for a scene`)}#c(e){this.#t-=e;let t=this.#e[0];if(t!==void 0&&t.length>e)return this.#e[0]=t.subarray(e),t.subarray(0,e);let n=new Uint8Array(e),s=0,o=0;for(;s<e;){let i=this.#e[o],a=i.subarray(0,e-s);n.set(a,s),s+=a.length,a.length<i.length?this.#e[o]=i.subarray(a.length):o++}return this.#e.splice(0,o),n}};function an(r){return Math.ceil(r/8)*8}function gi(r,e){let t=e.subarray(0,r.bytes);if(gt(t)!==r.crc32)throw new y(`the stream '${r.name}' of the .mgs file is damaged (wrong checksum)`);if(e.subarray(r.bytes).some(n=>n!==0))throw new y(`the .mgs file is damaged after its stream '${r.name}'`);return{name:r.name,codec:r.codec,data:t}}function bi(r){let e=q(r),t=e.getUint16(0,!0),n=e.getUint32(4,!0);if(!on.includes(t))throw new y(`the .mgs file is of version ${t}.${e.getUint16(2,!0)}, this program reads ${on[0]}.x to ${on[2]}.x: reload the page, or write the file again with this version of mobilegs`);if(n>di)throw new y(`the header of the .mgs file claims ${n} bytes: it is damaged`);return n}function vi(r){let e;try{e=JSON.parse(new TextDecoder("utf-8",{fatal:!0,ignoreBOM:!0}).decode(r))}catch{throw new y("the header of the .mgs file is not valid JSON")}if(typeof e!="object"||e===null||Array.isArray(e))throw new y("the header of the .mgs file is not a JSON object");return e}function xi(r){if(!Array.isArray(r)||r.length>pi)throw new y("the header of the .mgs file lacks a table of streams");let e=new Set;return r.map(t=>{let{name:n,codec:s,bytes:o,crc32:i}=Object(t);if(!([n,s].every(c=>Ke(c,64))&&[o,i].every(c=>Number.isInteger(c)&&c>=0&&c<2**40)))throw new y("the header of the .mgs file has a broken table of streams");if(e.has(n))throw new y(`the .mgs file has two streams called '${n}'`);return e.add(n),{name:n,codec:s,bytes:o,crc32:i}})}function Qs(r){if(r.length===0)return"the file is empty, not a .mgs scene";if(be.findIndex((s,o)=>s!==r[o])>=Math.min(3,r.length))return"the first bytes of the .mgs file are damaged: transfer it again, in binary mode";let t=String.fromCharCode(...r),n=wi.find(([s])=>t.startsWith(s));return n?`this is not a .mgs scene but looks like ${n[1]}`:"this is not a .mgs scene"}var cn=class{header=null;decoder=null;#e=new vt;get received(){return this.#e.received}get total(){return this.#e.total}append(e){let t=this.#e.append(e),{fields:n,table:s,total:o}=this.#e;n!==null&&this.decoder===null&&(this.header=ls(n,o),this.decoder=new wt(this.header,s));for(let i of t)this.decoder?.accept(i)}end(){this.#e.end()}step(){return this.decoder?.step(this.received)??!1}};async function Zs(r,e){let t=new cn,n=r.getReader();try{for(let s=0;;){s-=performance.now();let{value:o,done:i}=await n.read();if(s+=performance.now(),i)break;t.append(o);do await e(t,s);while(t.step())}}catch(s){throw await n.cancel().catch(()=>{}),s}return t.end(),t}var un=16,ln=6*un,V=64,xt=13,fn=.01,hn=6,Js=15,{fround:D,sqrt:yi}=Math,yt=class{#e;#t;#r;#s;constructor(e,t,{static2:n,view2:s}){let o=3+s.length/9,i=new Float32Array(12*o);for(let a=0;a<12;a++){let c=a<3?n.subarray(3*a,3*a+3):s.subarray((a-3)*(o-3));i.set(c.subarray(0,o-3),a*o+(a<3?0:3))}this.#e=e,this.#t=e.block(o),this.#r=e.layer(i,o),this.#s=t}decode(e,t,n){P(t,this.#t.numbers,x,n,n+e.length/3),this.#e.apply(this.#r,this.#t,this.#s,1)}},Et=class{#e;#t;#r;#s;#n;#i;#o;constructor(e,t,{both1:n,static2:s,view2:o}){this.#e=e,this.#t=[e.layer(n,hn),e.layer(s,V),e.layer(o,V)],this.#r=e.block(hn),this.#s=e.block(2*V),this.#n=[e.part(this.#s,0,V),e.part(this.#s,V,V)],this.#i=t,this.#o=e.part(t,3,12)}decode(e,t,n){let s=this.#e,[o,i,a]=this.#t;P(t,this.#r.numbers,x,n,n+e.length/3),s.apply(o,this.#r,this.#s,fn),s.apply(i,this.#n[0],this.#i,1),s.apply(a,this.#n[1],this.#o,1)}},_t=class{#e;#t;#r;#s;#n;#i;#o;#c;#a;#l;constructor(e,t,{context1:n,context2:s,static1:o,static2:i,view1:a,view2:c},l){this.#e=e,this.#t=[e.layer(n,ln),e.layer(s,V),e.layer(o,xt+3),e.layer(i,V),e.layer(a,xt+3),e.layer(c,V)],this.#l=2**l,this.#r=e.block(hn),this.#s=e.block(ln),this.#n=e.block(V),this.#i=e.block(xt+3),this.#o=e.part(this.#i,xt,3),this.#c=t,this.#a=e.part(t,3,12)}decode(e,t,n){let s=this.#e,[o,i,a,c,l,f]=this.#t,[h,u]=[this.#r.numbers,this.#o.numbers],[p,d,m]=[this.#s,this.#n,this.#i];this.#p(e,p.numbers),s.apply(o,p,d,0),s.apply(i,d,m,1),P(t,h,x,n,n+e.length/3),u.set(h.subarray(0,3*x)),s.apply(a,m,d,fn),s.apply(c,d,this.#c,1),u.set(h.subarray(3*x)),s.apply(l,m,d,fn),s.apply(f,d,this.#a,1)}#f(e,t){let n=I(e[t])*this.#l,s=I(e[t+1])*this.#l,o=I(e[t+2])*this.#l,i=D(D(D(n*n)+D(s*s))+D(o*o));return Math.max(1,D(yi(i)))}#p(e,t){for(let n=0,s=0;s<e.length;n++,s+=3){let o=this.#f(e,s),i=D(2-D(1/o));for(let a=0;a<3;a++){let c=I(e[s+a])*this.#l,l=D(i*D(c/o));Ei(l,t,a*un*x+n)}}}};function Ei(r,e,t){let n=D(D(r*.25)+.5),s=Math.sin(Math.PI*n),o=Math.cos(Math.PI*n);for(let i=t+un*x;t<i;t+=x){e[t]=s,e[t+ln/2*x]=o;let a=2*s*o;o=1-2*s*s,s=a}}var At=.28209479177387814,kt=class{#e;#t;#r;#s;#n;#i;#o;constructor(e,t,n,{degree:s,latents:o,hidden:i},a){let c=2*(s+1)**2,l=i.at(-1)??0,f=[19+o,...i];this.#e=e,this.#r=n,this.#t=i.map((d,m)=>e.layer(a[`weights.${m}`],f[m],a[`offsets.${m}`]));let h=a[`weights.${i.length}`],u=_i(h,l,a.basis,o,c);this.#t.push(e.layer(u,l+o,a.bias)),this.#s=e.block(o);let p=i.length?[19,...i]:[0];this.#n=p.map(d=>e.block(Math.ceil(d/4)*4+o)),this.#i=[0,p.length-1].map(d=>e.part(this.#n[d],p[d],o)),this.#o=i.length?new me(e,t,this.#n[0]):null}decode(e,t,n){let[s,o,i]=[this.#e,this.#n,this.#t.length-1];this.#o?.write(),e&&P(e,this.#s.numbers,x,t,n),this.#i[0].numbers.set(this.#s.numbers);for(let a=0;a<i;a++)s.apply(this.#t[a],o[a],o[a+1],0);this.#i[1].numbers.set(this.#s.numbers),s.apply(this.#t[i],o[i],this.#r,1)}};function _i(r,e,t,n,s){let o=e+n,i=new Float32Array(s*o);for(let a=0;a<s;a++){for(let c=0;c<e;c++)i[a*o+c]=r[a*e+c];for(let c=0;c<n;c++)i[a*o+e+c]=t[c*s+a]}return i}function Ie(r,e){for(let t=0;t<e.length;t++)r.fill(e[t],t*x,(t+1)*x)}var ki=1/3,Ai=[1,0,0,0],ve=class{#e;#t=new mt;#r;#s;#n;#i;#o;#c;#a;#l;#f;constructor(e){let{header:t,samples:n}=e,{lobes:s,grid:o}=t,i=this.#t;this.#e=e;let a=s?.degree??0,c=i.block(Js),l={logScales:i.block(3),scales:i.block(3),quats:i.block(4),sh:i.part(c,0,12),lobes:i.block(2*(a+1)**2+2),statics:i.block(t.network?19:0),words:i.block(18)};this.#r=l.quats,this.#n=s&&new kt(i,l,l.lobes,s,e.lobes),this.#i=t.network?new me(i,l,l.statics):null;let{appearance:f}=e;t.colors==="linear"?this.#s=new yt(i,c,f):t.colors==="latent_networks"?this.#s=new Et(i,c,f):this.#s=new _t(i,c,f,o.exponent),i.allocate(),this.#a=Object.fromEntries([...e.books].map(([p,d])=>[p,{...d,columns:[]}])),this.#l=er(this.#h("scale")),this.#f=er(ze(this.#h("scale")));let h=Object.fromEntries(Object.entries(l).map(([p,{numbers:d}])=>[p,d])),u=Ti(this.#l);this.#o={...h,count:0,lobeDegree:a,scaleRange:u,memory:i.wasmMemory},this.#c={sh:this.#p(n),lobes:[0,1/At]},this.#n&&(this.#c.lobes=this.#m(this.#n))}#p(e){let{sh:t}=this.#o,n=new Float64Array(12),s=ze(this.#h("appearance"));for(let o=0;o<e.length;o+=3*x){let i=e.subarray(o,o+3*x);this.#s.decode(i,s,0);for(let a=0;a<12;a++)for(let c=0;3*c<i.length;c++)n[a]+=3*t[a*x+c]/e.length}return n}#m(e){let{scales:t,quats:n,sh:s,lobes:o}=this.#o,i=this.#a.lobes;return P(this.#f,t,x,0,x),Ie(n,Ai),Ie(s,this.#c.sh),e.decode(i?ze(i):null,0,x),Array.from({length:o.length/x-2},(a,c)=>o[c*x])}decode({positions:e,columns:t},n=0){let{header:s}=this.#e,o=e.subarray(3*n,3*(n+x)),i=o.length/3,a=n+i,[c,l]=[this.#o,this.#a];c.count=i,c.positions=o;let{logScales:f,scales:h,quats:u,sh:p,lobes:d}=c,{scale:m,rotation:w,appearance:v}=t,_=!0;for(let E of Object.keys(l)){let k=t[E];k?this.#h(E).columns=k:_=!1}this.#l.columns=m,P(this.#h("scale"),f,x,n,a),P(this.#l,h,x,n,a);let g=s.scalars.get("rotation");if(g?Xs(g,w,n,a,u):(P(this.#h("rotation"),u,x,n,a),this.#t.units(this.#r,this.#r)),v?this.#s.decode(o,this.#h("appearance"),n):Ie(p,this.#c.sh),this.#n&&_?this.#n.decode(l.lobes??null,n,a):Ie(d,this.#c.lobes),l.opacity){let{books:[E]}=t.opacity?l.opacity:ze(l.opacity),k=t.opacity?.[0];Si(d,E,k,n,i)}return this.#i?.write(),c}get network(){return this.#i!==null}get lobeDegree(){return this.#o.lobeDegree}get scaleRange(){return this.#o.scaleRange}get neutral(){let e=[0,1,2].map(o=>.5+At*this.#c.sh[o]),[t,n,s]=this.#f.books.map(([o])=>o);return{color:e,side:ki*Math.cbrt(t*n*s)}}#h(e){return this.#a[e]}};function Si(r,e,t,n,s){for(let o=0;o<s;o++)r[o]+=e[t?t[n+o]:0]/At}function er(r){return{...r,books:r.books.map(e=>e.map(Math.exp))}}function Ti({books:r}){let e=[1/0,-1/0];for(let t of r)for(let n of t)e=[Math.min(e[0],n),Math.max(e[1],n)];return e}var{fround:z}=Math,Mi=["mobile_gs","no_depth","no_scale","sort_free_gs"],Ri=j(-1e4),Li=[2047,2047,1023],tr=z(511/Math.SQRT1_2),nr=888,Ne=new Uint32Array(1),St=new Float32Array(Ne.buffer);function sr({sorted:r,weighting:e,footprint:t,background:n,grid:s,lobes:o},i,a,c=null){let l=o?.degree??0,[f,h]=or(a);return{count:i,packing:{center:Array.from(s.center),unit:s.radius*2**s.exponent,leastScaleBits:f,scaleBitsSpan:h},...rr(c?10:ir(l),i),network:c&&Qn(c),shSize:4,lobeSize:(l+1)**2,sorted:r,weighting:{index:Mi.indexOf(e.name),exponentMax:e.exponent_max,sigma:e.sigma,backgroundWeight:e.background_weight,alphaMin:e.alpha_min},footprint:t,background:Array.from(n)}}function Tt(r,e,t=rr(dn(r),e.positions.length/3)){let n=e.positions.length/3,s=dn(r),o=4*x,i;for(let a=0;a<n;a+=x){let c=r.decode(e,a);i??=Oi(c);let l=i();t.shapes.set(l.subarray(0,4*c.count),4*a),t.colors.set(l.subarray(o,o+4*c.count),4*a),t.lobes.set(l.subarray(2*o,2*o+s*c.count),s*a)}return t}var rr=(r,e)=>({shapes:new Uint32Array(4*e),colors:new Uint32Array(4*e),lobes:new Uint32Array(r*e)});function or(r){let[e,t]=r.map(n=>(St[0]=n,z(Ne[0])));return[e,t-e]}var ir=r=>(r+1)**2+2>>1,dn=({network:r,lobeDegree:e})=>r?10:ir(e);function Oi(r,e=!1){let{scales:t,quats:n,sh:s,lobes:o,lobeDegree:i,statics:a,scaleRange:c,memory:l}=r,{buffer:f,byteOffset:h,length:u}=r.words,p=new Uint32Array(f,h,u),[d,m]=or(c),w=m>0?z(1/m):0,v=e?null:ue(l),[_,g,E,k]=[t,n,s,o].map(({byteOffset:K})=>K),S=a.length>0,[U,Y]=[(i+1)**2-1,dn({network:S,lobeDegree:i})];return()=>{v?v.pack(_,g,E,k,h,U,Y,d,w):Fi(r,p,Y,d,w),S&&zi(a,p);let{count:K,positions:L}=r;for(let G=0,Q=0;G<K;G++,Q+=4)p[Q]=L[3*G]|L[3*G+1]<<16,p[Q+1]|=L[3*G+2];return p}}function Fi({scales:r,quats:e,sh:t,lobes:n,lobeDegree:s},o,i,a,c){let l=2*(s+1)**2;for(let f=0;f<x;f++){let h=8*x+i*f,u=Ni(n,f,l,o,h);Ii(t,f,o,4*(x+f)),o[4*f+1]=u<<16;let p=0;for(let m=2;m>=0;m--){St[0]=r[m*x+f];let w=z(z(z(Ne[0])-a)*c);p=p<<11|z(z(Li[m]*Math.min(Math.max(w,0),1))+.5)}o[4*f+2]=p;let d=[0,1,2,3].map(m=>e[m*x+f]);o[4*f+3]=Ui(d),d.some(Boolean)||(o[h]=Ri|o[h]&4294901760)}}function zi(r,e){for(let t=0;t<x;t++){let n=8*x+10*t;e[n]=e[n]&65535|Math.round(32767*r[t])<<16;for(let s=1;s<10;s++){let[o,i]=[2*s-1,2*s].map(a=>Math.round(32767*r[a*x+t]));e[n+s]=o&65535|i<<16}}}function Ui(r){let e=0;for(let s=1;s<4;s++)Math.abs(r[s])>Math.abs(r[e])&&(e=s);let t=r[e]<0?-tr:tr,n=e;for(let s=0;s<4;s++)s!==e&&(n=n<<10|z(z(t*r[s])+1024.5)&1023);return n}function Ii(r,e,t,n){let s=c=>r[c*x+e],o=Array.from({length:9},(c,l)=>s(3+l)),i=lr(o),a=o.map(c=>cr(i,c));t[n]=j(s(0))|j(s(1))<<16,t[n+1]=j(s(2))|i<<16|a[0]<<24;for(let c of[1,5])t[n+1+(c+3>>2)]=ar(a,c)}function Ni(r,e,t,n,s){let o=f=>r[f*x+e],i=Array.from({length:t-2},(f,h)=>o(2+h)),[a,c]=[0,1].map(f=>lr(i.filter((h,u)=>u%2===f))),l=i.map((f,h)=>cr(h%2?c:a,f));n[s]=j(o(0))|j(o(1))<<16;for(let f=0,h=s+1;f<l.length;f+=4,h++)n[h]=ar(l,f);return a|c<<8}var ar=(r,e)=>r[e]|r[e+1]<<8|r[e+2]<<16|r[e+3]<<24;function cr(r,e){Ne[0]=r+nr<<20;let t=z(z(127/St[0])*e);return z(Math.min(Math.max(t,-127),127)+512.5)&255}function lr(r){return St[0]=Math.max(0,...r.map(Math.abs)),Math.min(Math.max((Ne[0]+1048575>>20)-nr,0),255)}var fr=8192,Ci=1e5,Di=3,Bi=2,Pi=8,Mt=class{results=[];#e=[];#t;#r=null;#s=null;#n=[];#i;#o=null;#c;#a;#l=!1;#f=!1;#p=()=>{};#m=()=>{};#h=new Promise((e,t)=>{this.#p=e,this.#m=t});constructor(e){this.#h.catch(()=>{});let t=0;for(let[n,s]of e.entries()){for(let o=0;o<s;o+=fr)this.#e.push({level:n,from:o,to:Math.min(o+fr,s),first:t+o});t+=s}this.#t=new Uint8Array(e.length),this.#c=new Uint8Array(this.#e.length),this.#a=this.#c.slice(),this.#i=t}set output(e){if(this.#o=e,e!==null)for(let[t,n]of this.results.splice(0))ur(n,hr(e,this.#i,t,t+n.shapes.length/4))}spawn(){let{decoderInputs:e}=this.#r,t=this.#i<Ci?1:navigator.hardwareConcurrency;for(let n=1;n<Math.min(t,Di+1);n++)this.#g(e)}#g(e){try{let t=Ft();t.postMessage({decoderInputs:e});let n={worker:t,jobs:0};t.onmessage=({data:s})=>{n.jobs--,this.#x(s),this.#E(n)},t.onerror=s=>s.preventDefault(),this.#n.push(n)}catch{}}start(e){return this.#r=e,this.#s=new ve(e.decoderInputs)}advance(e,t){if(!(t<=this.#t[e])){this.#t[e]=t;for(let n of this.#n)this.#E(n);this.#k().catch(this.#m)}}finish(){return this.#f=!0,this.#_(),this.#h}terminate(){for(let{worker:e}of this.#n)e.terminate()}get#b(){return this.#c.findIndex((e,t)=>e<this.#v(t))}get#w(){let e=this.#b;return e<0?this.#a.findIndex((t,n)=>t<this.#v(n)):e}#v(e){return this.#t[this.#e[e].level]}#u(e,t){let{levels:n}=this.#r,{level:s,from:o,to:i}=this.#e[e];return n[s].rows(o,i,t)}#y(e){let{first:t,from:n,to:s}=this.#e[e];return this.#o?hr(this.#o,this.#i,t,t+s-n):void 0}#E(e){for(let t;e.jobs<Bi&&(t=this.#b)>=0;e.jobs++){let n=this.#c[t]=this.#v(t),s=this.#u(t,"slice"),o=[s.positions,...Object.values(s.columns).flat()].map(({buffer:i})=>i);e.worker.postMessage({rows:s,chunk:t,stage:n},{transfer:o})}}async#k(){if(!this.#l){this.#l=!0;for(let e;(e=this.#w)>=0&&this.#s;){let t=this.#c[e]=this.#v(e),n=Tt(this.#s,this.#u(e,"subarray"),this.#y(e));this.#x({chunk:e,stage:t,packed:n}),await pn()}this.#l=!1}}#x({chunk:e,stage:t,packed:n}){if(t<=this.#a[e])return;this.#a[e]=t;let s=this.#y(e);s===void 0?this.results.push([this.#e[e].first,n]):s.shapes.buffer!==n.shapes.buffer&&ur(n,s),this.#_()}get firstLevelReady(){return this.#e.every(({level:e},t)=>e>0||this.#a[t]>0)}get levels(){let e=this.#a.findIndex(t=>t<Ue);return e<0?this.#t.length:this.#e[e].level}#_(){this.#f&&this.#w<0&&this.#p()}};function hr(r,e,t,n){let s=o=>{let i=r[o].length/e;return r[o].subarray(i*t,i*n)};return{shapes:s("shapes"),colors:s("colors"),lobes:s("lobes")}}function ur(r,e){for(let t of Object.keys(e))e[t].set(r[t])}var dr=0;async function pn(){if(performance.now()-dr<Pi)return;let{port1:r,port2:e}=new MessageChannel;await new Promise(t=>{r.onmessage=()=>{r.close(),t(null)},e.postMessage(null)}),dr=performance.now()}function pr(r){let e=r.length/3,t=Math.max(1,Math.floor(e/1e4)),n=[0,1,2].map(a=>Float32Array.from({length:Math.ceil(e/t)},(c,l)=>r[3*l*t+a])),s=n.map(a=>a.slice().sort()[a.length-1>>1]),o=n[0].map((a,c)=>Math.max(...n.map((l,f)=>Math.abs(l[c]-s[f])))),i=o.sort()[Math.floor(.9*(o.length-1))];return .2*Math.min(1,Math.max(i,1e-6))}var $i=65536,Gi=.28209479177387814,[qi,Hi]=[13.8,-69],Vi=new Map([["char",1],["int8",1],["uchar",1],["uint8",1],["short",2],["int16",2],["ushort",2],["uint16",2],["int",4],["int32",4],["uint",4],["uint32",4],["float",4],["float32",4],["double",8],["float64",8]]),Wi=new Map([["x",[1,0,0]],["y",[0,-1,0]],["z",[0,0,1]]]),mr=["x","y","z","f_dc_0","f_dc_1","f_dc_2","opacity","scale_0","scale_1"];mr.push("scale_2","rot_0","rot_1","rot_2","rot_3");function wn(r){return r[0]===112&&r[1]===108&&r[2]===121}function wr(r){let{offsets:e,stride:t,rows:n,start:s,footprint:o,up:i}=ji(r),a=new DataView(r.buffer,r.byteOffset+s),c=[...e.keys()].filter(v=>v.startsWith("f_rest_")).length,l=c/3+1;if(![1,4,9,16].includes(l))throw new Error(`the .ply file has ${c} numbers f_rest_*: 0, 9, 24 or 45 were expected`);let f=v=>e.get(v),h=["x","y","z","scale_0","scale_1","scale_2","rot_0","rot_1","rot_2","rot_3"];h.push("opacity","f_dc_0","f_dc_1","f_dc_2");for(let v=0;v+1<l;v++)for(let _=0;_<3;_++)h.push(`f_rest_${_*(l-1)+v}`);let u=h.find(v=>!e.has(v));if(u)throw new Error(`the .ply file has ${c} numbers f_rest_*, but not ${u}`);let p=h.map(f),d={...gn(n,l,o),up:i},m=new Float32Array(p.length);for(let v=0;v<n;v++){for(let g=0;g<m.length;g++)m[g]=a.getFloat32(v*t+p[g],!0);for(let g=3;g<6;g++)m[g]===-1/0&&(m[g]=Hi);Math.abs(m[10])===1/0&&(m[10]=Math.sign(m[10])*qi);let _=0;for(let g=0;g<m.length;g++)_+=m[g]*0;_===0&&bn(d,m)}let{count:w}=d;return w===n||(d.shapes=d.shapes.slice(0,12*w),d.colors=d.colors.slice(0,3*l*w),d.lobes=d.lobes.slice(0,2*w)),d}function mn(r=""){return`'${r.slice(0,40).replace(/[^\x20-\x7e]/g,"\uFFFD")}'`}function gn(r,e,t){return{count:0,packing:null,shapes:new Float32Array(12*r),colors:new Float32Array(3*e*r),shSize:e,lobes:new Float32Array(2*r),lobeSize:1,sorted:!0,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},footprint:t,background:[0,0,0]}}function bn(r,e){let[t,n,s,o]=[e[6],e[7],e[8],e[9]],i=t*t+n*n+s*s+o*o;if(!(i>0))return;let a=2/i,[c,l,f]=[Math.exp(e[3]),Math.exp(e[4]),Math.exp(e[5])];if(!(c+l+f<1e30&&Math.abs(e[10])<1e30))return;let h=r.count++;r.shapes.set([c*(1-a*(s*s+o*o)),c*a*(n*s+t*o),c*a*(n*o-t*s),e[0],l*a*(n*s-t*o),l*(1-a*(n*n+o*o)),l*a*(s*o+t*n),e[1],f*a*(n*o+t*s),f*a*(s*o-t*n),f*(1-a*(n*n+s*s)),e[2]],12*h),r.lobes[2*h]=e[10]/Gi,r.colors.set(e.subarray(11),3*r.shSize*h)}function ji(r){let e=new TextDecoder("latin1").decode(r.subarray(0,$i)),t=/\nend_header\r?\n/.exec(e);if(!wn(r)||t===null)throw new Error("this is not a PLY file, or its header is cut off");let n=e.slice(0,t.index).split(/\r?\n/).map(u=>u.trim().split(/\s+/)),s=n.find(u=>u[0]==="format")?.[1];if(s!=="binary_little_endian")throw new Error(`the .ply file is ${mn(s)}: only binary_little_endian is read`);let o=n.findIndex(u=>u[0]==="element"),i=n[o]??[],a=/^\d+$/.test(i[2])?Number(i[2]):NaN;if(i[1]!=="vertex"||!Number.isSafeInteger(a)||a<0)throw new Error("the .ply file does not begin with its vertices, as those of 3DGS do");let c=new Map,l=0;for(let u of n.slice(o+1)){if(u[0]==="element")break;if(u[0]!=="property")continue;let p=Vi.get(u[1]);if(p===void 0)throw new Error(`the .ply file has a property of type ${mn(u[1])}`);if(u.length!==3)throw new Error("the .ply file has a property without a name, or with two");if(c.has(u[2]))throw new Error(`the .ply file has the property ${mn(u[2])} twice`);(u[1]==="float"||u[1]==="float32")&&c.set(u[2],l),l+=p}let f=mr.filter(u=>!c.has(u));if(f.length)throw new Error(`the .ply file is not a Gaussian scene: it lacks ${f.join(", ")} as floats`);let h=t.index+t[0].length;if(h+a*l>r.length)throw new Error(`the .ply file is cut off: ${a} Gaussians were announced`);return{offsets:c,stride:l,rows:a,start:h,footprint:Xi(n),up:Yi(n)}}function Xi(r){let e={...ee};for(let[t,...n]of r){if(t!=="comment")continue;let s=n.join(" ");n[0]==="SplatRenderMode:"?e.antialiased=n[1]?.toLowerCase()==="mip":s==="antialiased 1"||s==="postshot.anti_aliasing=1"?e.antialiased=!0:n.length===3&&s.startsWith("mobilegs blur ")&&(e.blur=/^\d*\.?\d+$/.test(n[2])?Number(n[2]):NaN)}if(!(e.blur>0&&e.blur<=4))throw new Error("the .ply file names a blur that is not possible: above 0 and at most 4 is");return e}function Yi(r){let e=null;for(let t of r){let[n,s,o,...i]=t.map(a=>a.toLowerCase());n==="comment"&&(s==="vertical"&&o==="axis:"&&i.length===1&&(e=Wi.get(i[0])??e),s==="mobilegs"&&o==="up"&&(e=dt(i.join(" "))??e))}return e}var $="the compressed data is damaged or cut off";var ce=class{left;#e;constructor(e){let t=e[e.length-1];if(!t)throw new Error($);this.#e=e,this.left=8*e.length-1-Math.clz32(t)+24}take(e){return e>24?this.take(e-16)*65536+this.take(16):(this.left-=e,this.#t(this.left,e))}decode(e,{width:t,symbols:n,bits:s}){for(let o=0;o<e.length;o++){let i=this.#t(this.left-t,t);e[o]=n[i],this.left-=s[i]}if(this.left!==0)throw new Error($)}#t(e,t){let n=this.#e;if(e<0)return e+t>0?this.#t(0,e+t)<<-e:0;let s=e>>3;return(n[s]|n[s+1]<<8|n[s+2]<<16|n[s+3]<<24)>>>(e&7)&(1<<t)-1}};function gr(r){let e=new Uint8Array(1);return{accuracy:0,symbols:Uint8Array.of(r),bits:e,bases:new Uint16Array(1)}}function Ce(r,e){let t=1<<r,n={accuracy:r,symbols:new Uint8Array(t),bits:new Uint8Array(t),bases:new Uint16Array(t)},s=t;for(let[c,l]of e.entries())l===-1&&(n.symbols[--s]=c);let o=(t>>1)+(t>>3)+3,i=0;for(let[c,l]of e.entries())for(let f=0;f<l;f++){n.symbols[i]=c;do i=i+o&t-1;while(i>=s)}if(i!==0)throw new Error($);let a=e.map(c=>Math.abs(c));for(let c=0;c<t;c++){let l=a[n.symbols[c]]++,f=r-(31-Math.clz32(l));n.bits[c]=f,n.bases[c]=(l<<f)-t}return n}function vn(r,e,t,n){let s=8*e,o=l=>{let f=s>>3,u=(r[f]|r[f+1]<<8|r[f+2]<<16)>>(s&7)&(1<<l)-1;return s+=l,u},i=5+o(4);if(i>t)throw new Error($);let a=[];for(let l=1<<i;l>0;){let f=32-Math.clz32(l+1),h=(1<<f)-2-l,u=o(f-1);u>=h&&o(1)&&(u+=(1<<f-1)-h);let p=u-1;l-=Math.abs(p),a.push(p);for(let d=p===0?3:0;d===3;){d=o(2);for(let m=0;m<d;m++)a.push(0)}if(l<0||a.length>n)throw new Error($)}let c=s+7>>3;if(c>r.length)throw new Error($);return{table:Ce(i,a),end:c}}function br(r,e){let t=r[e++];if(!(t<128)){let l=t-127,f=e+(l+1>>1);if(!(f<=r.length))throw new Error($);let h=u=>r[e+(u>>1)]>>(u%2?0:4)&15;return{weights:Array.from({length:l},(u,p)=>h(p)),end:f}}let n=e+t;if(n>r.length)throw new Error($);let{table:s,end:o}=vn(r.subarray(0,n),e,6,13),i=new ce(r.subarray(o,n)),a=[],c=[i.take(s.accuracy),i.take(s.accuracy)];for(let l=0;a.length<255;l^=1){let f=c[l];if(a.push(s.symbols[f]),c[l]=s.bases[f]+i.take(s.bits[f]),i.left<0)return a.push(s.symbols[c[l^1]]),{weights:a,end:n}}throw new Error($)}function vr(r){let e=c=>c>0?1<<c-1:0,t=0;for(let c of r)t+=e(c);let n=32-Math.clz32(t),s=(1<<n)-t;if(t===0||n>11||s&s-1)throw new Error($);let o=[...r,32-Math.clz32(s)];if(o.length>256)throw new Error($);let i={width:n,symbols:new Uint8Array(1<<n),bits:new Uint8Array(1<<n)},a=0;for(let c=1;c<=n;c++)for(let[l,f]of o.entries()){if(f!==c)continue;let h=a+e(c);i.symbols.fill(l,a,h),i.bits.fill(n+1-c,a,h),a=h}return i}var Ki=4247762216,Qi=25481893,De=1<<17,M="the compressed data is damaged or cut off";function Er(r,e){let t=[];for(let n of e)t.push(r),r+=2**n;return{bits:e,bases:t}}var xr=Er(0,[...Array(16).fill(0),1,1,1,1,2,2,3,3,4,6,7,8,9,10,11,12,13,14,15,16]),yr=Er(3,[...Array(32).fill(0),1,1,1,1,2,2,3,3,4,4,5,7,8,9,10,11,12,13,14,15,16]),Zi=[{accuracy:9,symbols:36,usual:Ce(6,[4,3,2,2,2,2,2,2,2,2,2,2,2,1,1,1,2,2,2,2,2,2,2,2,2,3,2,1,1,1,1,1,-1,-1,-1,-1])},{accuracy:8,symbols:32,usual:Ce(5,[1,1,1,1,1,1,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1])},{accuracy:9,symbols:53,usual:Ce(6,[1,4,3,2,2,2,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1,-1,-1])}],xn=class{length=0;bytes;#e;constructor(e){this.#e=e,this.bytes=new Uint8Array(Math.min(e,De))}reserve(e){let t=this.length+e;if(t>this.#e)throw new Error("the compressed data is longer than announced");if(t<=this.bytes.length)return;let n=new Uint8Array(Math.min(this.#e,Math.max(t,2*this.bytes.length)));n.set(this.bytes.subarray(0,this.length)),this.bytes=n}append(e){this.reserve(e.length),this.bytes.set(e,this.length),this.length+=e.length}fill(e,t){this.reserve(t),this.bytes.fill(e,this.length,this.length+t),this.length+=t}repeat(e,t){if(!(e>0&&e<=this.length))throw new Error(M);this.reserve(t);let{bytes:n}=this,s=this.length+t;if(e>=t)n.copyWithin(this.length,this.length-e,s-e);else for(let o=this.length;o<s;o++)n[o]=n[o-e];this.length=s}};function _r(r,e){let t=new xn(e),n=new DataView(r.buffer,r.byteOffset,r.byteLength),s=0;for(;s<r.length;){if(s+8>r.length)throw new Error(M);let o=n.getUint32(s,!0);if(o>>>4===Qi)s+=8+n.getUint32(s+4,!0);else if(o===Ki)s=Ji(r,s+4,t);else throw new Error(M)}if(s!==r.length||t.length!==e)throw new Error(M);return t.bytes}function Ji(r,e,t){let n=r[e++],s=(n&32)!==0;if(s||(e+=1),r.subarray(e,e+=[0,1,2,4][n&3]).some(a=>a))throw new Error("the compressed data needs a dictionary, which is missing");e+=[s?1:0,2,4,8][n>>6];let i={huffman:null,tables:[null,null,null],recent:[1,4,8]};for(let a=!1;!a;){if(e+3>r.length)throw new Error(M);let c=r[e]|r[e+1]<<8|r[e+2]<<16;e+=3,a=(c&1)===1;let l=c>>1&3,f=c>>3,h=l===1?1:f;if(l===3||f>De||e+h>r.length)throw new Error(M);l===0?t.append(r.subarray(e,e+f)):l===1?t.fill(r[e],f):ea(r.subarray(e,e+f),i,t),e+=h}return e+(n&4?4:0)}function ea(r,e,t){let{literals:n,end:s}=sa(r,e),o=s,i=r[o++];if(i===void 0)throw new Error(M);if(i===255?(i=r[o]+(r[o+1]<<8)+32512,o+=2):i>127&&(i=(i-128<<8)+r[o++]),i===0){t.append(n);return}let a=r[o++];if(!(i>0)||a===void 0||a&3)throw new Error(M);for(let[c,{accuracy:l,symbols:f,usual:h}]of Zi.entries()){let u=a>>6-2*c&3;if(u===0)e.tables[c]=h;else if(u===1){if(!(r[o]<f))throw new Error(M);e.tables[c]=gr(r[o++])}else if(u===2){let{table:p,end:d}=vn(r,o,l,f);e.tables[c]=p,o=d}}ta(new ce(r.subarray(o)),i,n,e,t)}function ta(r,e,t,{tables:n,recent:s},o){let[i,a,c]=n;if(!i||!a||!c)throw new Error(M);let l=r.take(i.accuracy),f=r.take(a.accuracy),h=r.take(c.accuracy),u=0,p=o.length+De;for(let d=e;d>0;d--){let m=a.symbols[f],w=c.symbols[h],v=i.symbols[l],_=2**m+r.take(m),g=yr.bases[w]+r.take(yr.bits[w]),E=xr.bases[v]+r.take(xr.bits[v]);if(d>1&&(l=i.bases[l]+r.take(i.bits[l]),h=c.bases[h]+r.take(c.bits[h]),f=a.bases[f]+r.take(a.bits[f])),r.left<0||u+E>t.length)throw new Error(M);if(o.append(t.subarray(u,u+E)),u+=E,o.repeat(na(_,E,s),g),o.length>p)throw new Error(M)}if(r.left!==0)throw new Error(M);o.append(t.subarray(u))}function na(r,e,t){if(r>3)return t.unshift(r-3),t.pop(),t[0];let n=e===0?r:r-1,s=n<3?t[n]:t[0]-1;return n>0&&(t.splice(Math.min(n,2),1),t.unshift(s)),s}function sa(r,e){let t=r[0]|r[1]<<8|r[2]<<16,n=r[0]&3,s=r[0]>>2&3;if(n<2){let u=[1,2,1,3][s],p=u===1?r[0]>>3:(t&(u===2?65535:16777215))>>4,d=u+(n===0?p:1);if(p>De||!(d<=r.length))throw new Error(M);return n===0?{literals:r.subarray(u,d),end:d}:{literals:new Uint8Array(p).fill(r[u]),end:d}}let o=[3,3,4,5][s],i=[10,10,14,18][s],a=(t>>>0)+(r[3]??0)*2**24+(r[4]??0)*2**32,c=Math.floor(a/16)%2**i,l=Math.floor(a/2**(4+i))%2**i,f=o+l;if(c>De||!(f<=r.length))throw new Error(M);let h=o;if(n===2){let{weights:u,end:p}=br(r.subarray(0,f),h);e.huffman=vr(u),h=p}if(e.huffman===null)throw new Error(M);return{literals:ra(r.subarray(h,f),c,s!==0,e.huffman),end:f}}function ra(r,e,t,n){let s=new Uint8Array(e);if(!t)return new ce(r).decode(s,n),s;if(r.length<6)throw new Error(M);let o=e+3>>2;for(let i=0,a=6;i<4;i++){let c=i<3?r[2*i]|r[2*i+1]<<8:r.length-a;if(a+c>r.length)throw new Error(M);let l=i<3?(i+1)*o:e;if(l>e)throw new Error(M);new ce(r.subarray(a,a+c)).decode(s.subarray(i*o,l),n),a+=c}return s}var oa=1347635022,ia=1e7,Rt=16,Ar=32,Sr=[0,3,8,15,24],aa=15,ca=.15,la=[-1,-1,1,-1,1,1,-1,1,-1,1,-1,-1,1,-1,1],le="the .spz file is damaged or cut off";function Tr(r){return r[0]===78&&r[1]===71&&r[2]===83&&r[3]===80||r[0]===31&&r[1]===139}async function Mr(r){if(r[0]!==31){let o=Rr(r,r.length);return kr(o,ha(o,r))}let{header:e,content:t}=await fa(r),n=[],s=Rt;for(let o of yn(e))n.push(t.subarray(s,s+=o));return kr(e,n)}function Rr(r,e){let t=new DataView(r.buffer,r.byteOffset,r.byteLength);if(r.length<Rt||t.getUint32(0,!0)!==oa)throw new Error("this is not a .spz file");let n=t.getUint32(4,!0),s=n<4;if(n<1||n>4)throw new Error(`the .spz file has version ${n}: 1 to 4 are read`);if(!s&&r.length<Ar)throw new Error(le);let o=t.getUint32(8,!0),[i,a,c,l]=r.subarray(12,16);if(o>ia)throw new Error(`the .spz file announces ${o} Gaussians, too many to be drawn`);if(o>e)throw new Error(`the .spz file announces ${o} Gaussians in ${e} bytes: it is cut off`);if(i>4||a>24)throw new Error(le);let[f,h]=[(c&1)!==0,(c&2)!==0];return{version:n,count:o,degree:i,fraction:a,antialiased:f,extended:h,streams:l,table:s?0:t.getUint32(16,!0)}}function yn({version:r,count:e,degree:t}){return[r===1?6:9,1,3,3,r<3?3:4,3*Sr[t]].map(n=>n*e)}async function fa(r){let t=new Response(r).body.pipeThrough(new DecompressionStream("gzip")).getReader(),n=[],s=0,o=null,i=1/0,a=async()=>new Uint8Array(await new Blob(n).arrayBuffer());for(;s<=i;){let{value:c,done:l}=await t.read().catch(()=>{throw new Error(le)});if(l)break;if(n.push(c),s+=c.length,o===null&&s>=Rt){if(o=Rr(await a(),r.length),o.version>3)throw new Error("this is not a .spz file");i=yn(o).reduce((f,h)=>f+h,Rt)}}if(o===null)throw new Error("this is not a .spz file");if(s>i&&(await t.cancel().catch(()=>{}),!o.extended))throw new Error("the .spz file holds more than it announces");if(s<i)throw new Error(`the .spz file is cut off: ${o.count} Gaussians were announced`);return{header:o,content:await a()}}function ha(r,e){let{streams:t,table:n,version:s}=r,o=yn(r),i=n+16*t,a=o.filter(h=>h>0).length;if(s!==4||n<Ar||i>e.length||t!==a)throw new Error(le);let c=new DataView(e.buffer,e.byteOffset,e.byteLength),[l,f]=[n,i];return o.map(h=>{if(h===0)return new Uint8Array(0);let u=Number(c.getBigUint64(l,!0)),p=Number(c.getBigUint64(l+8,!0));if(l+=16,f+u>e.length||p!==h)throw new Error(le);let d=e.subarray(f,f+=u);try{return _r(d,h)}catch(m){throw new Error(`${le}: ${m instanceof Error?m.message:m}`)}})}function kr({version:r,count:e,degree:t,fraction:n,antialiased:s},o){let[i,a,c,l,f,h]=o,u=Sr[t],p=Math.min(u,aa),d=p+1,m=gn(e,d,{...ee,antialiased:s}),w=new Float32Array(11+3*d),v=r===1?da(i):ua(i,2**-n),_=r<3?pa:ma;for(let g=0;g<e;g++){w[0]=v(3*g),w[1]=-v(3*g+1),w[2]=-v(3*g+2);for(let k=0;k<3;k++)w[3+k]=l[3*g+k]/16-10;_(f,g,w);let E=Math.min(Math.max(a[g]/255,1e-6),1-1e-6);w[10]=Math.log(E/(1-E));for(let k=0;k<3;k++)w[11+k]=(c[3*g+k]/255-.5)/ca;for(let k=0;k<p;k++)for(let S=0;S<3;S++)w[14+3*k+S]=la[k]*(h[3*(u*g+k)+S]-128)/128;bn(m,w)}return m}function ua(r,e){return t=>{let n=3*t;return e*((r[n]<<8|r[n+1]<<16|r[n+2]<<24)>>8)}}function da(r){return e=>{let t=I(r[2*e]|r[2*e+1]<<8);if(!Number.isFinite(t))throw new Error(le);return t}}function pa(r,e,t){let[n,s,o]=[0,1,2].map(a=>r[3*e+a]/127.5-1),i=Math.sqrt(Math.max(0,1-n*n-s*s-o*o));t.set([i,n,-s,-o],6)}function ma(r,e,t){let n=4*e,s=r[n]|r[n+1]<<8|r[n+2]<<16|r[n+3]<<24,o=s>>>30,i=[0,0,0,0],a=1;for(let c=0,l=20;c<4;c++){if(c===o)continue;let f=(s>>l&511)/511*Math.SQRT1_2;i[c]=s>>l+9&1?-f:f,a-=f*f,l-=10}i[o]=Math.sqrt(Math.max(0,a)),t.set([i[3],i[0],-i[1],-i[2]],6)}var wa=8192,ga=2**20,Lr=1500,ba=8,Ur=["shapes","colors","lobes"],fe=new Float32Array(0),W=(r,e=[])=>self.postMessage(r,{transfer:e}),Ir=({shapes:r,colors:e,lobes:t})=>[r.buffer,e.buffer,t.buffer];async function va(r){if("file"in r)return{source:r.file.stream(),total:r.file.size};let e;try{e=await fetch(r.url)}catch{throw new Error(`${r.url} cannot be reached: is the address right, the network there, and may this site load it (CORS)?`)}if(!e.ok||e.body===null)throw new Error(`${r.url} could not be loaded: the server says ${e.status}`);let t=e.headers.has("Content-Encoding")?NaN:Number(e.headers.get("Content-Length"));return{source:e.body,total:t||NaN}}var En=class{#e;#t;#r;#s;#n;#i=0;#o=null;#c=!1;constructor(e,t,n,s,o){this.#e=e,this.#n=o,this.#t=t,this.#r=n,this.#s=s;let i=Array.from(e.background),{color:a,side:c}=s.neutral,l=Nt($n(t[0].positions,wa),e.grid),f=c*Math.sqrt(3*e.count/l.length),h={means:l,color:a,side:f,background:i};W({kind:"dots",dots:h,...this.#a},[h.means.buffer])}get#a(){let{views:e,near:t,meta:n}=this.#e;return{views:e,near:t,up:dt(n.up)}}send(e){if(!this.#r.firstLevelReady||!this.allocate(e))return;let t=this.#r.levels,n=this.#i;this.#i=Math.max(t,1);let s=this.#r.results.splice(0),o=this.#o;if(o){this.#o=this.#r.output=null,W({kind:"scene",data:o,means:this.#l(),...this.#a},Ir(o));return}for(let[i,a]of s)for(let c of Ur){let l=a[c];W({kind:"rows",part:c,from:i,numbers:l},[l.buffer])}n!==this.#i&&W({kind:"more",means:this.#l()})}allocate(e){let{count:t}=this.#e;return!this.#c&&ba*e>=t&&(this.#o=this.#r.output=sr(this.#e,t,this.#s.scaleRange,this.#n),this.#c=!0),this.#c}#l(){let e=this.#t.slice(0,this.#i),t=new Uint16Array(e.reduce((o,{count:i})=>o+3*i,0)),n=0;for(let{positions:o,count:i}of e)t.set(o,n),n+=3*i;let s={stored:t,grid:this.#e.grid};return this.#e.sorted&&(fe=Xe(s)),s}};async function xa(r){let e=null,t=null,[n,s]=[0,0],o=[],i=async({header:a,decoder:c,received:l,total:f},h)=>{if(W({kind:"progress",received:l,total:f}),a===null||c===null)return;s=l,e??=new Mt(a.lodSizes);let u=o=c.levels,p=h*(f/l-1)>Lr;u[0].positions&&!t&&(t=new En(a,u,e,e.start(c),c.network),e.spawn(),n=setInterval(()=>t?.send(s),Lr)),t?.allocate(l);for(let[d,{stage:m}]of u.entries())t&&(m===rn||p&&d===0&&m>=Ue)&&e.advance(d,m);await pn()};try{await Zs(r,i)}finally{for(let[a,{stage:c,positions:l}]of o.entries())t&&l&&c>=Ue&&e?.advance(a,c);await e?.finish().finally(()=>{clearInterval(n),e?.terminate()}),t?.send(s)}return s}async function Or(r,e,t){let[n,s]=[new Uint8Array(e||ga),0],o=r.getReader();for(let c;!(c=await o.read()).done;){let l=s+c.value.length;if(l>n.length){let f=n;n=new Uint8Array(Math.max(l,2*n.length)),n.set(f)}n.set(c.value,s),s=l,W({kind:"progress",received:s,total:e})}let i=await t(n.subarray(0,s));if(!i.count)throw new Error("there is no Gaussian in this file that can be drawn");fe=new Float32Array(3*i.count);for(let c=0;c<fe.length;c++)fe[c]=i.shapes[4*c+3];let a={views:[],near:pr(fe),up:i.up??null};return W({kind:"scene",data:i,means:fe,...a},Ir(i)),s}async function ya(r){let e=r.getReader(),t=()=>e.read().catch(()=>{throw new Error("the file broke off before its end: load it again")}),n=await t(),s=n?.value??new Uint8Array(0),o=new ReadableStream({async pull(i){let{value:a,done:c}=n??await t();n=null,c?i.close():i.enqueue(a)},cancel:()=>e.cancel()});return{first:s,whole:o}}async function Fr(r){let e=performance.now();try{let{source:t,total:n}=await va(r),{first:s,whole:o}=await ya(t),i;wn(s)?i=await Or(o,n,wr):Tr(s)?i=await Or(o,n,Mr):i=await xa(o),W({kind:"done",milliseconds:performance.now()-e,bytes:i})}catch(t){let{message:n}=t,s=t instanceof RangeError?`the scene is too large for this device: ${n}`:n;W({kind:"failed",sentence:s})}}var zr;function Nr(){self.onmessage=async({data:r})=>{if("decoderInputs"in r){zr=new ve(r.decoderInputs);return}if("rows"in r){let{rows:e,chunk:t,stage:n}=r,s=Tt(zr,e),o=Ur.map(i=>s[i].buffer);self.postMessage({chunk:t,stage:n,packed:s},{transfer:o});return}if("forward"in r){let e=qe(fe,r.forward);W({kind:"order",order:e},[e.buffer]);return}await Fr(r)},self.name&&Fr({url:self.name})}globalThis.document||Nr();
})();
