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
`};var tr=/[\x00-\x1f\x7f-\x9f\u2028\u2029\p{Cs}]/gu,x=class extends Error{name="SceneError";constructor(e){super(e.replace(tr,"\uFFFD"))}};function H(s){return new DataView(s.buffer,s.byteOffset,s.byteLength)}var re=class{#e;#t=0;#o=0;constructor(e){this.#e=e}get left(){return 8*(this.#e.length-this.#t)-this.#o}take(e){let t=this.#e,n=this.#t,o=t[n]|t[n+1]<<8|t[n+2]<<16|t[n+3]<<24,r=this.#o+e,i=o>>>this.#o&(1<<e)-1;return this.#t=n+(r>>>3),this.#o=r&7,i}atEnd(){return this.left<8&&this.#e[this.#t]>>>this.#o===0}};function ue(s,e){let t=Math.ceil(e/8);if(s.length!==t)throw new x(`packed bits take ${s.length} bytes where ${t} belong`);if(e%8&&s[t-1]>>e%8)throw new x("packed bits end in bits that are not zero");return new re(s)}var Mn="0061736d01000000012a0460077f7f7f7f7f7f7d0060037f7f7f0060097f7f7f7f7f7f7f7f7f017f60097f7f7f7f7f7f7f7d7d00020f0103656e76066d656d6f727902000103060500010202030607017f014180080b073705056c61796572000005756e69747300010a70756c6c5f706c61696e00020f70756c6c5f636f6e7465787475616c0003047061636b00040abc21059c0404017f017b047f0b7b024020054101480d00200120054102746a21072006fd13210820044102742209410148210a0340200020094102746a210b4100210c03402001fd09000c210d2001fd090008210e2001fd090004210f2001fd090000211002400240200a450d00200d2111200e2112200f2113201021140c010b2002200c4102746a2104200d2111200e2112200f2113201021142000210503402004fd00001022152005fd0900002216fde6012010fde40121102004fd00000022172016fde6012014fde401211420152005fd0900042216fde601200ffde401210f20172016fde6012013fde401211320152005fd0900082216fde601200efde401210e20172016fde6012012fde401211220152005fd09000c2216fde601200dfde401210d20172016fde6012011fde401211120044180046a2104200541106a2205200b490d000b0b2003200c4102746a2205201120082011fde601fde901fd0b00800c2005201220082012fde601fde901fd0b0080082005201320082013fde601fde901fd0b0080042005201020082010fde601fde901fd0b00102005201420082014fde601fde901fd0b0000200541900c6a200d2008200dfde601fde901fd0b000020054190086a200e2008200efde601fde901fd0b000020054190046a200f2008200ffde601fde901fd0b0000200c41f800492105200c41086a210c20050d000b20034180106a2103200b2100200141106a22012007490d000b0b0bd50104027f017b027f017b200020024109746a2103410021040340fd0c0000000000000000000000000000000021052000200441027422066a22022107034020052007fd00000022082008fde601fde401210520074180046a22072003490d000b200120066a2107fd0c0000803f0000803f0000803f0000803f2005fde301fd0cccbc8c2bccbc8c2bccbc8c2bccbc8c2bfde901fde70121050340200720052002fd000000fde601fd0b000020074180046a210720024180046a22022003490d000b200441fc00492102200441046a210420020d000b0bd30101087f41002109034002402006200820092007491b220a4101480d002000200a4103746a210b2000210a0340024020022001200a280200220c41ffff0071220d4101746a2f0100220e4102746a280200220f0d0041000f0b20042f01002110200a28020420094101746a200e3b0102200a20104100200d200f410f766b200f41ffff0171200c410e766c6a220c4180800449220f1b200c200f41047474723602002004200f4101746a2104200a41086a220a200b490d000b0b0240200420054b0d00200941016a220920074d0d010b0b20040bf101010a7f410021094100210a0340024020062008200a2007491b220b4101480d002000200b4103746a210c2000210b0340024020022009200b280204200a4101746a220d2f010071220e20036c2001200e410f74200b280200220f41ffff00712210410174726a2f010022116a4102746a280200220e0d0041000f0b20042f01002112200d20113b0102200b201241002010200e410f766b200e41ffff0171200f410e766c6a220d4180800449220e1b200d200e41047474723602002004200e4101746a2104200b41086a220b200c490d000b0b0240200420054b0d00417f2109200a41016a220a20074d0d010b0b20040bfc1707067f027b037f0c7b037f0e7b017f2005417e7121092005410171210a200641036c210b2006410174210c20044180206a210d200541017441026a210e2008fd13210f2007fd132110410021112006410274221241027421130340fd0c020000000200000002000000020000002214fd0c010000000100000001000000010000002215fd0c0000000000000000000000000000000022162001fd000080042217fde0012001fd0000002218fde001fd442219fd522001fd00008008221afde001201720182019fd522217fde001fd442218fd522119fd0c03000000030000000300000003000000211b2001fd0000800c221c201a20172018fd522217201cfde0012017fde001fd44221dfd52221efd0cffffff7fffffff7fffffff7fffffff7f221cfd4e2016fd37211ffd0c0000000000000000000000000000000022172118410121202016211a4100212102400240024020050e020201000b0340201720032020410a746a2222fd000000fde001fde90120224180086afd000000fde001fde9012117201820224180046afd000000fde001fde901202241800c6afd000000fde001fde9012118202041026a2120202141026a22212009470d000b0b0240200a450d00201720032020410a746a2222fd000000fde001fde9012117201820224180046afd000000fde001fde90121180b2018fd0cffff0f00ffff0f00ffff0f00ffff0f00221afdae014114fdad0121162017201afdae014114fdad01211a0b201b2019201dfd52211d200d2003fd000080042217fd0c000000800000008000000080000000802223fd4e2003fd00000022184110fdad01fd0c008000000080000000800000008000002224fd4efd502018201cfd4e2219fd0c0000804b0000804b0000804b0000804b2225fde601fd6afdf80120192018410dfdad012015fd4efdae01fd0cff0f00c8ff0f00c8ff0f00c8ff0f00c82226fdae01410dfdad01fd0cff7b0000ff7b0000ff7b0000ff7b00002227fdb7012019fd0c000080380000803800008038000080382228fd3afd52fd502017201cfd4e22182025fde601fd6afdf80120182017410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120182028fd3afd524110fdab01fd502217fd0c0000ffff0000ffff0000ffff0000fffffd4efd0ce2f00000e2f00000e2f00000e2f00000fd502017201ffd522217fd5a00000041022120200d20064102746a2017fd5a000001200d200c4102746a2017fd5a000002200d200b4102746a2017fd5a0000032016fd0c78030000780300007803000078030000221ffdb901fd0c770400007704000077040000770400002229fdb601fd0c88fcffff88fcffff88fcffff88fcffff222afdae01212bfd0c00008037000080370000803700008037212cfd0c0000fe420000fe420000fe420000fe422117201a201ffdb9012029fdb601202afdae01212d0240200e41024d0d002017202b4114fdab01202cfdae01fde70121192017202d4114fdab01202cfdae01fde701211a200d21220340202241046a22222019200320204109742221418004726afd000000fde601fd0c0000fec20000fec20000fec20000fec22218fde9012017fde801fd0c002000440020004400200044002000442216fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4e201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf801fd0cff000000ff000000ff000000ff000000fd4e2019200320214180086a2221418004726afd000000fde6012018fde9012017fde8012016fde401fdf8014118fdab01201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4efd50fd50fd502218fd5a000000202220126a2018fd5a0000012022200c4102746a2018fd5a0000022022200b4102746a2018fd5a000003202041046a2220200e490d000b0b200441346a202d4110fdab01202b4118fdab01fd502218fd5a000003200441246a2018fd5a000002200441146a2018fd5a000001200441046a2018fd5a000000200441386a200f2000fd00008004fdfa012010fde501fde601fd0c000000000000000000000000000000002218fde901fd0c0000803f0000803f0000803f0000803f2216fde801fd0c00e0ff4400e0ff4400e0ff4400e0ff44221afde601fd0c0000003f0000003f0000003f0000003f2219fde401fdf801410bfdab01200f2000fd00008008fdfa012010fde501fde6012018fde9012016fde801fd0c00c07f4400c07f4400c07f4400c07f44fde6012019fde401fdf8014116fdab01fd50200f2000fd000000fdfa012010fde501fde6012018fde9012016fde801201afde6012019fde401fdf801fd502216fd5a000003200441286a2016fd5a000002200441186a2016fd5a000001200441086a2016fd5a0000002004413c6afd0c71aa34c471aa34c471aa34c471aa34c4fd0c71aa344471aa344471aa344471aa3444201e2018fd43fd5222162001fd00008004221a2001fd000000201d2015fd39fd52fde601fd0c001080440010804400108044001080442219fde401fdf801410afdab01fd0c00fc0f0000fc0f0000fc0f0000fc0f00fd4e201d4114fdab01fd5020162001fd00008008222b201a201d2014fd39fd52fde6012019fde401fdf801fd0cff030000ff030000ff030000ff030000221afd4efd50410afdab0120162001fd0000800c202b201d201bfd39fd52fde6012019fde401fdf801201afd4efd502216fd5a0000032004412c6a2016fd5a0000022004411c6a2016fd5a0000012004410c6a2016fd5a0000002002fd0000802c211d2002fd00008028211b2002fd00008024212b2002fd00008020212d2002fd0000801c21142002fd00008018211e2002fd00008014212e2002fd00008010212f2002fd0000800c2130200441b0106a2002fd0000800422162023fd4e2002fd00000022194110fdad012024fd4efd502019201cfd4e221a2025fde601fd6afdf801201a2019410dfdad012015fd4efdae012026fdae01410dfdad012027fdb701201a2028fd3afd52fd502016201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd524110fdab01fd502216fd5a000003200441a0106a2016fd5a00000220044190106a2016fd5a00000120044180106a2016fd5a000000200441b4106a2002fd000080082216201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd522030fde0012018fde901202ffde001fde901202efde001fde901201efde001fde9012014fde001fde901202dfde001fde901202bfde001fde901201bfde001fde901201dfde001fde901fd0cffff0f00ffff0f00ffff0f00ffff0f00fdae014114fdad01201ffdb9012029fdb601202afdae0122184110fdab0120164110fdad012024fd4efd50fd502002fd0000800c201720184114fdab01202cfdae01fde7012218fde601fd0c0000fec20000fec20000fec20000fec22216fde9012017fde801fd0c002000440020004400200044002000442219fde401fdf8014118fdab01fd50221afd5a000003200441a4106a201afd5a00000220044194106a201afd5a00000120044184106a201afd5a00000020044188106a213141002120410121210340203120204102746a222241306a20182020410b7420026a22204180186afd000000fde6012016fde9012017fde8012019fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4e2018202041801c6afd000000fde6012016fde9012017fde8012019fde401fdf8014118fdab01fd50201820204180146afd000000fde6012016fde9012017fde8012019fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4efd50201820204180106afd000000fde6012016fde9012017fde8012019fde401fdf801fd0cff000000ff000000ff000000ff000000fd4efd50221afd5a000003202241206a201afd5a000002202241106a201afd5a0000012022201afd5a00000020214101712122410021214101212020220d000b200441c0006a2104200341106a2103200241106a2102200141106a2101200041106a2100200d20136a210d201141fc00492122201141046a211120220d000b0b";var ye,Tn=new WeakMap;function Pe(s){return typeof WebAssembly=="object"?new WebAssembly.Memory({initial:Math.ceil(s/2**16)}):null}function de(s){if(s===null)return null;if(ye===void 0)try{let t=Mn.match(/../g);ye=new WebAssembly.Module(Uint8Array.from(t,n=>parseInt(n,16)))}catch{ye=null}if(ye===null)return null;let e=Tn.get(s);if(!e){let{exports:t}=new WebAssembly.Instance(ye,{env:{memory:s}});e=t,Tn.set(s,e)}return e}var y=128,nr=1e-12,Rn=new Float32Array(0),Be=class{wasmMemory=null;#e=[];#t=0;#o=null;#s;constructor(e=!1){this.#s=e}block(e){return this.#n(e,y*e,null)}part({at:e},t,n){let o={at:e+4*y*t,width:n,numbers:Rn};return this.#e.push([o,null,y*n]),o}layer(e,t,n){let o=n?n.length:e.length/t,r=Math.ceil(o/4)*4,i=new Float32Array(r*t);for(let l=0;l<o;l++){let f=(l-l%4)*t+l%4;for(let h=0;h<t;h++)i[f+4*h]=e[l*t+h]}let a=new Float32Array(r);n&&a.set(n);let c=l=>this.#n(0,l.length,l);return{inputs:t,outputs:r,weights:c(i),offsets:c(a)}}#n(e,t,n){let o={at:this.#t,width:e,numbers:Rn};return this.#e.push([o,n,t]),this.#t+=16*Math.ceil(t/4),o}allocate(){this.wasmMemory=Pe(this.#t);let e=this.wasmMemory?.buffer??new ArrayBuffer(this.#t);for(let[t,n,o]of this.#e.splice(0))t.numbers=new Float32Array(e,t.at,o),n&&t.numbers.set(n);this.#o=this.#s?null:de(this.wasmMemory)}apply({inputs:e,outputs:t,weights:n,offsets:o},r,i,a){if(this.#o){this.#o.layer(n.at,o.at,r.at,i.at,e,t,a);return}let[c,l,f,h]=[r,i,n,o].map(({numbers:u})=>u);for(let u=0;u<t;u++){let p=(u-u%4)*e+u%4;for(let d=0;d<y;d++){let m=h[u];for(let g=0;g<e;g++)m+=f[p+4*g]*c[g*y+d];l[u*y+d]=Math.max(m,a*m)}}}units({at:e,width:t,numbers:n},{at:o,numbers:r}){if(this.#o){this.#o.units(e,o,t);return}for(let i=0;i<y;i++){let a=0;for(let l=i;l<y*t;l+=y)a+=n[l]*n[l];let c=1/Math.max(Math.sqrt(a),nr);for(let l=i;l<y*t;l+=y)r[l]=n[l]*c}}};var Ft=2048,ie;function Ln({contexts:s,alphabet:e,symbols:t,spans:n},o,r,i,a){ie===void 0&&(ie=Pe(1));let c=de(ie);if(ie===null||c===null)return;let l=o.length,f=Ft+2*t.length,h=f+4*n.length,u=h+i.length,p=u+2*l+2,d=Math.ceil((p+2*a+2)/2**16)-ie.buffer.byteLength/2**16;d>0&&ie.grow(d);let{buffer:m}=ie,g=new Uint32Array(m,0,2*l);o.forEach((w,_)=>g.set([w,p-2+2*r[_]],2*_)),new Uint16Array(m,Ft,t.length).set(t),new Uint32Array(m,f,n.length).set(n),new Uint8Array(m,h,i.length).set(i);let E=(s>1?c.pull_contextual:c.pull_plain)(0,Ft,f,e,h,u,l,Math.floor(a/l),a%l);return{decoded:new Uint16Array(m,p,a).slice(),left:E?(u-E)/2:-1/0,states:g.filter((w,_)=>_%2===0)}}var Ge=14,Ee=1<<Ge,On=65536,sr=64,or=256,rr=2048,$e=12,Fn=-1/0;function ae(s,e,t,n=!1){if(s.length<$e)throw new x("a rANS stream is too short to hold its header");let o=H(s),r=o.getUint16(0,!0),i=o.getUint16(2,!0),a=o.getUint32(4,!0),c=o.getUint32(8,!0);if(r!==t)throw new x(`a rANS stream of ${r} symbols stands where ${t} belong`);if(i!==1&&i!==t||i>sr)throw new x(`a rANS stream has ${i} contexts`);let l=ir(e);if(s.length!==$e+a+4*l+2*c)throw new x("a rANS stream is longer or shorter than its header says");let f=$e+a,h=cr(s.subarray($e,f),i,t),u=new Uint32Array(l).map((E,w)=>o.getUint32(f+4*w,!0));if(u.some(E=>E<On))throw new x("a rANS stream starts in an impossible state");let p=Math.floor(e/l),d=e%l,m=u.map((E,w)=>w*p+Math.min(w,d)),g=[h,u,m,s.subarray(f+4*l),e],v=(n?void 0:Ln(...g))??ar(...g);if(v.left===Fn)throw new x("a rANS stream leads to a context that is not used: it is damaged");if(v.left<0)throw new x("a rANS stream ends early: the file is damaged");if(v.left>0||v.states.some(E=>E!==On))throw new x("a rANS stream does not end where it should: the file is damaged");return v.decoded}function ir(s){let e=Math.max(1,Math.floor(s/rr));return Math.min(or,1<<31-Math.clz32(e))}function ar({contexts:s,alphabet:e,symbols:t,spans:n},o,r,i,a){let c=o.length,l=Math.floor(a/c),f=a%c,h=new Uint16Array(a),u=i.length/2,p=new Uint16Array(u+1);new Uint8Array(p.buffer).set(i);let d=0;for(let m=0;m<=l;m++){let g=m<l?c:f,v=s>1&&m>0;for(let E=0;E<g;E++){let w=r[E]+m,_=v?h[w-1]:0,k=o[E],S=k&Ee-1,I=t[_<<Ge|S],K=n[_*e+I];if(K===0)return{decoded:h,left:Fn,states:o};let Q=Math.imul(K&32767,k>>>Ge)+S-(K>>>15)|0,O=(Q>>>16)-1>>>31;o[E]=Q<<16*O|p[d]&-O,d+=O,h[w]=I}}return{decoded:h,left:u-d,states:o}}function cr(s,e,t){let n=new re(s),o=new Uint16Array(e*Ee),r=new Uint32Array(e*t);for(let i=0;i<e;i++){if(!xe(n,1))continue;let a=lr(n,t),c=i*Ee;for(let l=0;l<t;l++){let f=a[l];f!==0&&(r[i*t+l]=c%Ee<<15|f,o.fill(l,c,c+f),c+=f)}}if(!n.atEnd())throw new x("a rANS stream's frequency tables are longer than they should be");return{contexts:e,alphabet:t,symbols:o,spans:r}}function lr(s,e){let t=new Uint16Array(e),n=[];for(let a=0;a<e;a++)xe(s,1)&&n.push(a);let o=xe(s,4),r=n.pop(),i=Ee;for(let a of n){let c=o;for(;!xe(s,1);)c++;if(c>Ge)throw new x("a rANS stream's frequency table holds a number out of range");t[a]=xe(s,c)+(1<<c)-(1<<o)+1,i-=t[a]}if(r===void 0||i<1)throw new x("a rANS stream's frequencies do not sum to 16384");return t[r]=i,t}function xe(s,e){if(e>s.left)throw new x("a rANS stream's frequency tables end early");return s.take(e)}var fr=80;function Un(s){let e=0;for(let{count:t,size:n,length:o}of s.values())e+=t*n*o;return e}function zn(s,e){let t=0,n=new Map;for(let[o,{count:r,size:i,length:a}]of e){let c=()=>s.subarray(t,t+=i*a);n.set(o,{length:a,books:Array.from({length:r},c)})}if(n.get("scale")?.books.some(o=>o.some(r=>r>fr)))throw new x("the codebooks of the .mgs file hold scales that are out of range");return n}function Nn(s){return new Map([...s].map(([e,{step:t,columns:n}])=>{let o=n.map(({least:r,size:i})=>Float32Array.from({length:i},(a,c)=>(r+c)*t));return[e,{length:1,books:o,middles:n.map(({least:r,middle:i})=>i-r)}]}))}function In({name:s,codec:e,data:t},n,o){if(e==="rans")return ae(t,n,o);let r=32-Math.clz32(o-1),i=ue(t,r*n),a=new Uint16Array(n);for(let c=0;c<n;c++){let l=i.take(r);if(l>=o)throw new x(`the stream '${s}' points outside of its codebook`);a[c]=l}return a}function _e({length:s,books:e,middles:t}){let n=new Uint16Array(y);return{length:s,books:e.map((o,r)=>t?o.subarray(t[r],t[r]+1):hr(o,s)),columns:e.map(()=>n)}}function hr(s,e){let t=new Float64Array(e);for(let n=0;n<s.length;n++)t[n%e]+=s[n]*e/s.length;return Float32Array.from(t)}function B({length:s,books:e,columns:t},n,o,r,i){for(let a=0;a<e.length;a++){let c=e[a],l=t[a],f=a*s*o;if(s===1){for(let h=r;h<i;h++)n[f++]=c[l[h]];continue}for(let h=0;h<s;h++,f=(a*s+h)*o)for(let u=r;u<i;u++)n[f++]=c[l[u]*s+h]}}var ur=Float64Array.from({length:31},(s,e)=>2**(Math.max(e,1)-25)),Dn=new Float32Array(1),Cn=new Uint32Array(Dn.buffer);function Ut(s){return(s&31744)===31744}function C(s){let e=s>>10&31,t=(s&1023)+(e>0?1024:0);return(s&32768?-t:t)*ur[e]}function X(s){Dn[0]=s;let e=Cn[0]>>>16&32768,t=Cn[0]&2147483647;if(t<947912704){let n=Math.abs(s)*16777216,o=Math.round(n);return e|(o-n===.5&&o%2?o-1:o)}return e|Math.min(t+4095+(t>>>13&1)-939524096>>>13,31743)}function zt(s,e){let t=dr(s,e);if(t.some(Ut))throw new x(`the stream '${s.name}' of the .mgs file has numbers that are not finite`);return Float32Array.from(t,C)}function dr({name:s,codec:e,data:t},n){let o=new x(`the stream '${s}' of the .mgs file has a wrong length`);if(e==="raw"){if(t.length!==2*n)throw o;return Uint16Array.from({length:n},(l,f)=>t[2*f]|t[2*f+1]<<8)}if(t.length<4)throw o;let r=4+H(t).getUint32(0,!0);if(r>t.length||e==="halves"&&t.length!==r+n)throw o;let i=ae(t.subarray(4,r),n,256),a=t.subarray(r),c=e==="planes"?ae(a,n,256):a;return i.map((l,f)=>l<<8|c[f])}var pr=49,ce=24,qe=Uint32Array.from({length:4096},(s,e)=>{let t=0;for(let n=0;n<12;n++)t|=(e>>>n&1)<<10*(n%3)+Math.floor(n/3);return t});function Pn(s,e){let t=s.length<4?1/0:4+H(s).getUint32(0,!0);if(t>s.length)throw new x("the stream of positions is too short to hold what its header says");let n=ae(s.subarray(4,t),e,pr),o=0;for(let l=0;l<e;l++)o+=Math.max(n[l]-1,0);let r=ue(s.subarray(t),o),i=new Uint16Array(3*e),a=0,c=0;for(let l=0;l<e;l++){let f=n[l]-1;if(f>=ce?(a+=r.take(ce),c+=(1<<f-ce)+r.take(f-ce)):f>=0&&(a+=(1<<f)+r.take(f)),c+=a>>>ce,a&=(1<<ce)-1,c>>>ce)throw new x("the stream of positions leaves its 48-bit grid");let h=qe[a&4095]|qe[a>>>12]<<4,u=qe[c&4095]|qe[c>>>12]<<4;for(let p=0,d=0;p<3;p++,d+=10){let m=h>>>d&255|(u>>>d&255)<<8,g=m&32768?m&32767:m^65535;if(Ut(g))throw new x("the stream of positions holds numbers that are not finite");i[3*l+p]=g}}return i}function Bn(s,e){let t=3*Math.ceil(s.length/3/e);if(t<=3)return s;let n=new Uint16Array(3*Math.ceil(s.length/t));for(let o=0,r=0;o<s.length;o+=t,r+=3)n.set(s.subarray(o,o+3),r);return n}function Nt(s,{center:e,radius:t,exponent:n}){let o=new Float32Array(s.length),r=t*2**n;for(let i=0;i<s.length;i++)o[i]=e[i%3]+Math.fround(r*C(s[i]));return o}function He(s){return"stored"in s?Nt(s.stored,s.grid):s}var mr=[53,210,405,600,787,970,1151,1329],gr=Uint8Array.from({length:1330},(s,e)=>mr.filter(t=>t<=e).length),It=Float64Array.from({length:512},(s,e)=>(e+.5)/2**(31-Math.clz32(e))-1.5),wr=2.5,Ct=(s,e)=>gr[Math.min(256*Math.abs(Math.fround(s-e)),1329)|0];function $n(s,e,t){let[n,o,r]=t,i=n.length,a=[new Uint16Array(i),new Uint16Array(i),new Uint16Array(i)],[c,l,f]=a,[h,u,p]=e,d=new re(s),m=0;for(let g=0;g<i;g++){let v=h[n[g]],E=u[o[g]],w=p[r[g]],_=Ct(E,w),k=Ct(v,w),S=Ct(v,E),I=d.take(_+k+S);c[g]=1<<_|I&(1<<_)-1,l[g]=1<<k|I>>>_&(1<<k)-1,f[g]=1<<S|I>>>_+k,m+=_+k+S}return ue(s,m),a}function Gn({step:s,columns:[{least:e},{least:t},{least:n}]},o,r,i,a){let[c,l,f,h,u,p]=o;for(let d=r,m=0;d<i;d++,m++){let g=s*(c[d]+e+It[h[d]]),v=s*(l[d]+t+It[u[d]]),E=s*(f[d]+n+It[p[d]]),w=(g*g+v*v+E*E)/4,_=1+w*(-1/2+w*(1/24+w*(-1/720+w*(1/40320+w*(-1/3628800+w*(1/479001600-w/87178291200)))))),k=1/2+w*(-1/12+w*(1/240+w*(-1/10080+w*(1/725760+w*(-1/79833600+w/12454041600)))));if(w>wr){let S=Math.sqrt(w);_=Math.cos(S),k=Math.sin(S)/(2*S)}a[m]=_,a[m+y]=k*g,a[m+2*y]=k*v,a[m+3*y]=k*E}}var pe=class{#e;#t;#o;constructor(e,{sh:t,scales:n,quats:o},r){this.#e=e,this.#t=[[t,e.part(r,0,12)],[n,e.part(r,12,3)]],this.#o=[o,e.part(r,15,4)]}write(){let[e,t]=this.#o;for(let[n,o]of this.#t)this.#e.units(n,o);t.numbers.set(e.numbers)}};var br=[["context1",64,96],["context2",13,64],["static1",64,16],["static2",3,64],["view1",64,16],["view2",9,64]],vr=[["both1",128,6],["static2",3,64],["view2",9,64]],Dt={linear:"color-matrices",networks:"appearance-decoder",latent_networks:"color-networks"};function qn({colors:s,scalars:e}){let t=e.get("appearance")?.columns.length??6,n={linear:[["static2",3,3],["view2",9,t-3]],networks:br,latent_networks:vr};return[Dt[s],n[s]]}var Hn=[["hidden1.weight",256,22],["hidden1.bias",1,256],["hidden2.weight",128,256],["hidden2.bias",1,128],["hidden3.weight",64,128],["hidden3.bias",1,64],["phi.weight",1,64],["phi.bias",1,1],["opacity.weight",1,64],["opacity.bias",1,1]];function Vn({degree:s,latents:e,hidden:t}){let n=2*(s+1)**2,o=[19+e,...t],r=[["bias",1,n],["basis",e,n]];return t.length===0||([...t,n].forEach((i,a)=>r.push([`weights.${a}`,i,o[a]])),t.forEach((i,a)=>r.push([`offsets.${a}`,1,i]))),r}function Wn(s){return s.reduce((e,[,t,n])=>e+t*n,0)}function jn(s,e){let t=0;return Object.fromEntries(e.map(([n,o,r])=>[n,s.subarray(t,t+=o*r)]))}var yr=256,Xn=["raw","halves","planes"],xr=["bits","rans"],Yn=[["scale","rotation"],["appearance","opacity"],["lobes"]],Bt=Yn.length,ke=2,Pt=class{positions=null;columns=new Map;#e;constructor(e,t){this.#e=e,this.count=t}get stage(){let e=Yn.findIndex(t=>!t.every(n=>this.#t(n)));return e<0?Bt:e}rows(e,t,n="slice"){let o=[...this.columns].filter(([i])=>this.#t(i)).map(([i,a])=>[i,a.map(c=>c[n](e,t))]);return{positions:this.positions[n](3*e,3*t),columns:Object.fromEntries(o)}}#t(e){let{cuts:t,scalars:n}=this.#e,o=n.size&&e==="rotation"?3:0,r=(t.get(e)?.count??n.get(e)?.columns.length??0)+o;return Object.keys(this.columns.get(e)??[]).length===r}},Ve=class{levels;network=null;#e;#t;#o=new Map;#s=new Map;#n=new Map;#i={};#r={};constructor(e,t){this.#e=e,this.#t=t;let{network:n,lobes:o,cuts:r,scalars:i,lodSizes:a}=e;n&&this.#l("view-network",Hn,f=>this.network=f),o&&this.#l("lobe-decoder",Vn(o),f=>this.#i=f),this.#l(...qn(e),f=>this.#r=f),i.size?this.#n=Nn(i):this.#a("codebooks",Xn,[],f=>{this.#n=zn(zt(f,Un(r)),r)});let c=[...this.#o.keys()],l=0;this.levels=a.map((f,h)=>(l+=f,this.#c(f,h?`@${h}`:"",c,l)))}#c(e,t,n,o){let{cuts:r,scalars:i}=this.#e,a=new Pt(this.#e,e),[c,...l]=["positions","scale.0","scale.1","scale.2"].map(u=>u+t),f=(u,p)=>{let d=[];a.columns.set(u,d);for(let[m,g]of p.entries())this.#a(`${u}.${m}${t}`,xr,[c],v=>{d[m]=In(v,e,g)})},h=({data:u})=>{a.positions=Pn(u,e)};this.#a(c,["morton-class"],n,h,o);for(let[u,{count:p,size:d}]of r)f(u,Array(p).fill(d));for(let[u,{columns:p}]of i)f(u,p.map(({size:d})=>d));if(i.size){let[u,p]=["scale","rotation"].map(d=>a.columns.get(d)??[]);this.#a(`rotation-finer${t}`,["bits"],[c,...l],({data:d})=>{let{books:m}=this.#n.get("scale");$n(d,m,u).forEach((g,v)=>p[3+v]=g)})}return a}accept(e){this.#o.has(e.name)&&this.#s.set(e.name,e)}step(e){for(let[t,{after:n,minBytes:o,read:r}]of this.#o){let i=this.#s.get(t);if(!(i===void 0||e<o||n.some(a=>this.#o.has(a))))return r(i),this.#o.delete(t),this.#s.delete(t),!0}return!1}get decoderInputs(){let[{count:e,positions:t}]=this.levels,n=t,o=Math.min(e,yr),r=new Uint16Array(3*o).map((c,l)=>n[3*Math.floor(Math.floor(l/3)*e/o)+l%3]),[i,a]=[this.#e,this.#n];return{header:i,books:a,appearance:this.#r,lobes:this.#i,samples:r}}#a(e,t,n,o,r=0){let i=this.#t.find(a=>a.name===e);if(i===void 0)throw new x(`the .mgs file lacks its stream '${e}'`);if(!t.includes(i.codec))throw new x(`the stream '${e}' of the .mgs file uses the codec '${i.codec}', which this program does not know`);this.#o.set(e,{after:n,minBytes:r,read:o})}#l(e,t,n){this.#a(e,Xn,[],o=>n(jn(zt(o,Wn(t)),t)))}};var D=new Int32Array(2048);for(let s=0;s<D.length;s++){let e=s<256?s:D[s-256];for(let t=0;t<8;t++)e=(e&1?3988292384:0)^e>>>1;D[s]=e}function We(s,e=0){let t=~e,n=0;for(;n+8<=s.length;n+=8)t^=s[n]|s[n+1]<<8|s[n+2]<<16|s[n+3]<<24,t=D[1792+(t&255)]^D[1536+(t>>>8&255)]^D[1280+(t>>>16&255)]^D[1024+(t>>>24)]^D[768+s[n+4]]^D[512+s[n+5]]^D[256+s[n+6]]^D[s[n+7]];for(;n<s.length;n++)t=D[(t^s[n])&255]^t>>>8;return~t>>>0}var J=Object.freeze({blur:.3,antialiased:!1,soft_edge:!1}),Er=2**26,_r=8,Gt=4096,$t=2**14,kr=1e-5,Ar=1e3,Sr=80,Mr=8,qt=32,Tr=256,Rr=3,Lr=64,Kn=2**16,Qn=64,Zn=4096,Or=1e-20,je=1e20,Fr=/[\x00-\x1f\x7f-\x9f\p{Cs}]/u,Jn=["mobile_gs","no_depth","no_scale","sort_free_gs"],Ur=[["scale",[[3,1],[1,3]]],["rotation",[[2,2],[1,4]]],["appearance",[[3,2]]],["opacity",[[1,1]]]],es=[6,12],zr=[["scale",3],["rotation",3],["appearance",es[0]],["opacity",1]];function ts(s,e){let{colors:t="networks"}=s;for(let[h,u,...p]of[["mode",s.mode,"nvq","sq"],["blend",s.blend,"sortfree","sorted"],["sh_degree",s.sh_degree,1],["colors",t,"linear","networks","latent_networks"]])if(!p.includes(u))throw new x(`the .mgs file has ${h} '${ss(u)}', which this program does not know: a newer one may`);let n=Cr(s),o=s.network;if(typeof o!="boolean")throw A("network");if(o&&n!==null)throw new x("the .mgs file has lobes and a view network: it can have one of them");let r=s.mode==="sq",i=F(s,"count",1,Er),a={count:i,lodSizes:Ir(s,i),cuts:r?new Map:Dr($(s,"codebooks"),n),scalars:r?Pr($(s,"scalars"),n,t==="linear"):new Map,grid:Br($(s,"positions")),colors:t,sorted:s.blend==="sorted",lobes:n,network:o,weighting:$r($(s,"weighting")),footprint:Gr($(s,"footprint")),background:Ye(s,"background",3),near:Y(s,"near"),views:Ae(s,"views").map(qr),meta:Hr($(s,"meta"))},c=Nr(a),f=s.streams.filter(h=>c.has(h.name)).reduce((h,u)=>h+u.bytes,0);if(i>f)throw new x(`the .mgs file claims ${i} Gaussians in ${f} of its ${e} bytes: it is damaged`);if(a.footprint.soft_edge&&a.sorted)throw A("footprint.soft_edge");if(a.background.some(h=>h<0||h>1))throw A("background");if(!(a.near>0&&a.near<=je))throw A("near");if(a.views.length>Lr)throw A("views");return a}function Xe(s,e){return typeof s!="string"||s.length>2*e||Fr.test(s)?!1:s.length<=e||[...s].length<=e}function Nr({colors:s,lobes:e,network:t,cuts:n,scalars:o,lodSizes:r}){let i=["positions"];for(let[c,{count:l}]of n)for(let f=0;f<l;f++)i.push(`${c}.${f}`);for(let[c,{columns:l}]of o)i.push(...l.map((f,h)=>`${c}.${h}`));o.size&&i.push("rotation-finer");let a=r.flatMap((c,l)=>i.map(f=>l?`${f}@${l}`:f));return a.push(Dt[s]),e&&a.push("lobe-decoder"),t&&a.push("view-network"),n.size&&a.push("codebooks"),new Set(a)}function Ir(s,e){let t=Ae(s,"layers").map(o=>F({layers:o},"layers",1,e)),n=t.reduce((o,r)=>o+r,0);if(t.length>_r||n!==e)throw A("layers");return t}function Cr(s){if(s.lobes===null)return null;let e=$(s,"lobes"),t=Ae(e,"hidden");if(t.length>Rr)throw A("lobes.hidden");return{degree:F(e,"degree",0,3),latents:F(e,"latents",0,qt),hidden:t.map(n=>F({hidden:n},"hidden",1,Tr))}}function Dr(s,e){let t=new Map;for(let[o,r]of Ur){if(o==="opacity"&&!Object.hasOwn(s,o)&&e!==null)continue;let i=$(s,o),a=r.find(([c,l])=>i.count===c&&i.length===l);if(!a)throw A(`codebooks.${o}`);t.set(o,{count:a[0],length:a[1],size:F(i,"size",1,Gt)})}let n=0;if(Object.hasOwn(s,"lobes")){let o=$(s,"lobes"),r=F(o,"count",1,qt),i=F(o,"length",1,qt);t.set("lobes",{count:r,length:i,size:F(o,"size",1,Gt)}),n=r*i}if(n!==(e===null?0:e.latents))throw A("codebooks.lobes");return t}function Pr(s,e,t){let n=new Map,o=e?.latents??0;if(Object.hasOwn(s,"lobes")&&!o)throw A("scalars.lobes");for(let[r,i]of[...zr,["lobes",o]]){if(r==="opacity"&&!Object.hasOwn(s,r)&&e!==null||i===0)continue;let c=$(s,r),[l,f,h]=["least","size","middle"].map(v=>Ae(c,v)),[u,p]=r==="appearance"&&t?es:[i,i],d=l.length;if(d<u||d>p||f.length!==d||h.length!==d)throw A(`scalars.${r}`);let m=Math.fround(Y(c,"step"));if(!(m>=kr&&m<=Ar))throw A(`scalars.${r}.step`);let g=l.map((v,E)=>{let w={least:l[E],size:f[E],middle:h[E]},_=F(w,"least",-$t,$t),k=F(w,"size",1,Gt),S=F({size:_+k-1},"size",_,$t);if(r==="scale"&&S*m>Sr)throw A("scalars.scale");let I=Math.max(-_,S)+.5;if(r==="rotation"&&I*m>Mr)throw A("scalars.rotation");return{least:_,size:k,middle:F(w,"middle",_,S)}});n.set(r,{step:m,columns:g})}return n}function Br(s){let e=Ye(s,"center",3),t=Math.fround(Y(s,"radius"));if(e.some(n=>Math.abs(n)>Math.fround(je)))throw A("positions.center");if(t<Or||t>je)throw A("positions.radius");return{center:e,radius:t,exponent:F(s,"exponent",0,14)}}function $r(s){let{name:e}=s;if(typeof e!="string")throw A("name");if(!Jn.includes(e))throw new x(`the .mgs file has the weighting '${ss(e)}': known are ${Jn.join(", ")}`);let t={name:e,exponent_max:Y(s,"exponent_max"),sigma:Y(s,"sigma"),background_weight:Y(s,"background_weight"),alpha_min:s.alpha_min===void 0?1/255:Y(s,"alpha_min")};if(!(t.exponent_max>0&&t.exponent_max<=80))throw A("exponent_max");if(!(t.sigma>0&&t.sigma<=je))throw A("sigma");if(t.background_weight<0)throw A("background_weight");if(!(t.alpha_min>=1e-4&&t.alpha_min<=.1))throw A("alpha_min");return t}function Gr(s){let{antialiased:e,soft_edge:t}=s;if(typeof e!="boolean")throw A("footprint.antialiased");if(typeof t!="boolean")throw A("footprint.soft_edge");let n=Y(s,"blur");if(!(n>0&&n<=4))throw A("footprint.blur");return{blur:n,antialiased:e,soft_edge:t}}function qr(s){let e=$({views:s},"views"),t=Ye(e,"viewmat",16),n=Ye(e,"K",9);if(![0,0,0,1].every((i,a)=>t[12+a]===i)||![0,0,1].every((i,a)=>n[6+a]===i)||n[0]<=0||n[4]<=0)throw new x("a view's matrices in the .mgs file are not those of a camera");let r=F(e,"width",1,Kn);return{viewmat:t,K:n,width:r,height:F(e,"height",1,Kn)}}function Hr(s){let e=Object.entries(s);if(e.length>Qn)throw new x(`the .mgs file has ${e.length} notes: ${Qn} are allowed`);for(let[t,n]of e){let o=n===null||typeof n=="boolean"||Xe(n,Zn),r=typeof n=="number"&&Math.abs(n)<=2**53;if(!(o||r)||!Xe(t,Zn))throw new x(`the note '${t.slice(0,40)}' is not a short text or a number`)}return s}function $(s,e){let t=s[e];if(typeof t!="object"||t===null||Array.isArray(t))throw A(e);return t}function Ae(s,e){let t=s[e];if(!Array.isArray(t))throw A(e);return t}function F(s,e,t,n){let o=Y(s,e);if(!Number.isInteger(o)||o<t||o>n)throw A(e);return o}function Y(s,e){return ns(s[e],e)}function Ye(s,e,t){let n=Ae(s,e);if(n.length!==t)throw A(e);return Float32Array.from(n,o=>ns(o,e))}function ns(s,e){if(typeof s!="number"||!(Math.abs(s)<=3e38))throw A(e);return s}function ss(s){return typeof s!="object"||s===null?String(s).slice(0,40):Array.isArray(s)?"a list":"an object"}function A(s){return new x(`the field '${s}' in the header of the .mgs file is missing or invalid`)}var ge=[77,71,83,26,13,10,0,1],Ht=[2,3,4],Ke=20,Vr=2**20,Wr=256,jr=2**32,Xr=[["ply","a PLY scene: train or compress it first"],["PK","a zip archive (perhaps .sog)"],["\x8B","a gzip file (perhaps .spz)"],["NGSP","an .spz scene"],["glTF","a binary glTF file"],["\xFD7zXZ","an xz file (perhaps another program's comp.xz)"],["\x89PNG","a PNG picture"],["\xFF\xD8\xFF","a JPEG picture"],["<","a web page"],["{","a JSON text"]],Qe=class{received=0;total=1/0;fields=null;table=[];#e=[];#t=0;#o=0;#s=!1;#n=null;append(e){if(e.length>0&&this.#e.push(e),this.received+=e.length,this.#t+=e.length,!this.#i())return[];if(this.received>this.total)throw new x(`the .mgs file has ${this.received-this.total} bytes too many at its end`);let t=[];for(let n;(n=this.table[this.#o])&&Vt(n.bytes)<=this.#t;)this.#o++,t.push(Yr(n,this.#c(Vt(n.bytes))));return t}end(){if(this.fields!==null){let t=this.table[this.#o];if(t===void 0)return;throw new x(`the .mgs file ends inside its stream '${t.name}': it has been cut short`)}if(!this.#s)throw new x(os(this.#c(this.#t)));let e=this.#n===null?"first bytes":"header";throw new x(`the .mgs file ends inside its ${e}: it has been cut short`)}#i(){if(!this.#s&&this.#t>=ge.length){let e=this.#c(ge.length);if(ge.some((t,n)=>t!==e[n]))throw new x(os(e));this.#s=!0}if(this.#s&&this.#n===null&&this.#t>=Ke-ge.length&&(this.#n=this.#c(Ke-ge.length)),this.#n!==null&&this.fields===null){let e=Kr(this.#n);this.#t>=e&&this.#r(this.#n,this.#c(e))}return this.fields!==null}#r(e,t){let n=H(e).getUint32(8,!0);if((Ke+t.length)%8||We(t,We(e.subarray(0,8)))!==n)throw new x("the header of the .mgs file is damaged (wrong checksum)");this.fields=Qr(t);let o=H(e).getUint16(0,!0);if((o===2||o===4&&this.fields.layers===void 0)&&(this.fields.layers=[this.fields.count]),o<4&&(this.fields.footprint=J),this.table=Zr(this.fields.streams),this.total=this.table.reduce((r,i)=>r+Vt(i.bytes),Ke+t.length),this.total>jr)throw new x(`the .mgs file claims ${this.total} bytes, too many for a scene`)}#c(e){this.#t-=e;let t=this.#e[0];if(t!==void 0&&t.length>e)return this.#e[0]=t.subarray(e),t.subarray(0,e);let n=new Uint8Array(e),o=0,r=0;for(;o<e;){let i=this.#e[r],a=i.subarray(0,e-o);n.set(a,o),o+=a.length,a.length<i.length?this.#e[r]=i.subarray(a.length):r++}return this.#e.splice(0,r),n}};function Vt(s){return Math.ceil(s/8)*8}function Yr(s,e){let t=e.subarray(0,s.bytes);if(We(t)!==s.crc32)throw new x(`the stream '${s.name}' of the .mgs file is damaged (wrong checksum)`);if(e.subarray(s.bytes).some(n=>n!==0))throw new x(`the .mgs file is damaged after its stream '${s.name}'`);return{name:s.name,codec:s.codec,data:t}}function Kr(s){let e=H(s),t=e.getUint16(0,!0),n=e.getUint32(4,!0);if(!Ht.includes(t))throw new x(`the .mgs file is of version ${t}.${e.getUint16(2,!0)}, this program reads ${Ht[0]}.x to ${Ht[2]}.x: reload the page, or write the file again with this version of mobilegs`);if(n>Vr)throw new x(`the header of the .mgs file claims ${n} bytes: it is damaged`);return n}function Qr(s){let e;try{e=JSON.parse(new TextDecoder("utf-8",{fatal:!0,ignoreBOM:!0}).decode(s))}catch{throw new x("the header of the .mgs file is not valid JSON")}if(typeof e!="object"||e===null||Array.isArray(e))throw new x("the header of the .mgs file is not a JSON object");return e}function Zr(s){if(!Array.isArray(s)||s.length>Wr)throw new x("the header of the .mgs file lacks a table of streams");let e=new Set;return s.map(t=>{let{name:n,codec:o,bytes:r,crc32:i}=Object(t);if(!([n,o].every(c=>Xe(c,64))&&[r,i].every(c=>Number.isInteger(c)&&c>=0&&c<2**40)))throw new x("the header of the .mgs file has a broken table of streams");if(e.has(n))throw new x(`the .mgs file has two streams called '${n}'`);return e.add(n),{name:n,codec:o,bytes:r,crc32:i}})}function os(s){if(s.length===0)return"the file is empty, not a .mgs scene";if(ge.findIndex((o,r)=>o!==s[r])>=Math.min(3,s.length))return"the first bytes of the .mgs file are damaged: transfer it again, in binary mode";let t=String.fromCharCode(...s),n=Xr.find(([o])=>t.startsWith(o));return n?`this is not a .mgs scene but looks like ${n[1]}`:"this is not a .mgs scene"}var Wt=class{header=null;decoder=null;#e=new Qe;get received(){return this.#e.received}get total(){return this.#e.total}append(e){let t=this.#e.append(e),{fields:n,table:o,total:r}=this.#e;n!==null&&this.decoder===null&&(this.header=ts(n,r),this.decoder=new Ve(this.header,o));for(let i of t)this.decoder?.accept(i)}end(){this.#e.end()}step(){return this.decoder?.step(this.received)??!1}};async function rs(s,e){let t=new Wt,n=s.getReader();try{for(let o=0;;){o-=performance.now();let{value:r,done:i}=await n.read();if(o+=performance.now(),i)break;t.append(r);do await e(t,o);while(t.step())}}catch(o){throw await n.cancel().catch(()=>{}),o}return t.end(),t}var Kt=16,jt=6*Kt,V=64,Ze=13,Xt=.01,Yt=6,is=15,{fround:P,sqrt:Jr}=Math,Je=class{#e;#t;#o;#s;constructor(e,t,{static2:n,view2:o}){let r=3+o.length/9,i=new Float32Array(12*r);for(let a=0;a<12;a++){let c=a<3?n.subarray(3*a,3*a+3):o.subarray((a-3)*(r-3));i.set(c.subarray(0,r-3),a*r+(a<3?0:3))}this.#e=e,this.#t=e.block(r),this.#o=e.layer(i,r),this.#s=t}decode(e,t,n){B(t,this.#t.numbers,y,n,n+e.length/3),this.#e.apply(this.#o,this.#t,this.#s,1)}},et=class{#e;#t;#o;#s;#n;#i;#r;constructor(e,t,{both1:n,static2:o,view2:r}){this.#e=e,this.#t=[e.layer(n,Yt),e.layer(o,V),e.layer(r,V)],this.#o=e.block(Yt),this.#s=e.block(2*V),this.#n=[e.part(this.#s,0,V),e.part(this.#s,V,V)],this.#i=t,this.#r=e.part(t,3,12)}decode(e,t,n){let o=this.#e,[r,i,a]=this.#t;B(t,this.#o.numbers,y,n,n+e.length/3),o.apply(r,this.#o,this.#s,Xt),o.apply(i,this.#n[0],this.#i,1),o.apply(a,this.#n[1],this.#r,1)}},tt=class{#e;#t;#o;#s;#n;#i;#r;#c;#a;#l;constructor(e,t,{context1:n,context2:o,static1:r,static2:i,view1:a,view2:c},l){this.#e=e,this.#t=[e.layer(n,jt),e.layer(o,V),e.layer(r,Ze+3),e.layer(i,V),e.layer(a,Ze+3),e.layer(c,V)],this.#l=2**l,this.#o=e.block(Yt),this.#s=e.block(jt),this.#n=e.block(V),this.#i=e.block(Ze+3),this.#r=e.part(this.#i,Ze,3),this.#c=t,this.#a=e.part(t,3,12)}decode(e,t,n){let o=this.#e,[r,i,a,c,l,f]=this.#t,[h,u]=[this.#o.numbers,this.#r.numbers],[p,d,m]=[this.#s,this.#n,this.#i];this.#p(e,p.numbers),o.apply(r,p,d,0),o.apply(i,d,m,1),B(t,h,y,n,n+e.length/3),u.set(h.subarray(0,3*y)),o.apply(a,m,d,Xt),o.apply(c,d,this.#c,1),u.set(h.subarray(3*y)),o.apply(l,m,d,Xt),o.apply(f,d,this.#a,1)}#f(e,t){let n=C(e[t])*this.#l,o=C(e[t+1])*this.#l,r=C(e[t+2])*this.#l,i=P(P(P(n*n)+P(o*o))+P(r*r));return Math.max(1,P(Jr(i)))}#p(e,t){for(let n=0,o=0;o<e.length;n++,o+=3){let r=this.#f(e,o),i=P(2-P(1/r));for(let a=0;a<3;a++){let c=C(e[o+a])*this.#l,l=P(i*P(c/r));ei(l,t,a*Kt*y+n)}}}};function ei(s,e,t){let n=P(P(s*.25)+.5),o=Math.sin(Math.PI*n),r=Math.cos(Math.PI*n);for(let i=t+Kt*y;t<i;t+=y){e[t]=o,e[t+jt/2*y]=r;let a=2*o*r;r=1-2*o*o,o=a}}var st=.28209479177387814,nt=class{#e;#t;#o;#s;#n;#i;#r;constructor(e,t,n,{degree:o,latents:r,hidden:i},a){let c=2*(o+1)**2,l=i.at(-1)??0,f=[19+r,...i];this.#e=e,this.#o=n,this.#t=i.map((d,m)=>e.layer(a[`weights.${m}`],f[m],a[`offsets.${m}`]));let h=a[`weights.${i.length}`],u=ti(h,l,a.basis,r,c);this.#t.push(e.layer(u,l+r,a.bias)),this.#s=e.block(r);let p=i.length?[19,...i]:[0];this.#n=p.map(d=>e.block(Math.ceil(d/4)*4+r)),this.#i=[0,p.length-1].map(d=>e.part(this.#n[d],p[d],r)),this.#r=i.length?new pe(e,t,this.#n[0]):null}decode(e,t,n){let[o,r,i]=[this.#e,this.#n,this.#t.length-1];this.#r?.write(),e&&B(e,this.#s.numbers,y,t,n),this.#i[0].numbers.set(this.#s.numbers);for(let a=0;a<i;a++)o.apply(this.#t[a],r[a],r[a+1],0);this.#i[1].numbers.set(this.#s.numbers),o.apply(this.#t[i],r[i],this.#o,1)}};function ti(s,e,t,n,o){let r=e+n,i=new Float32Array(o*r);for(let a=0;a<o;a++){for(let c=0;c<e;c++)i[a*r+c]=s[a*e+c];for(let c=0;c<n;c++)i[a*r+e+c]=t[c*o+a]}return i}function Se(s,e){for(let t=0;t<e.length;t++)s.fill(e[t],t*y,(t+1)*y)}var ni=1/3,si=[1,0,0,0],we=class{#e;#t=new Be;#o;#s;#n;#i;#r;#c;#a;#l;#f;constructor(e){let{header:t,samples:n}=e,{lobes:o,grid:r}=t,i=this.#t;this.#e=e;let a=o?.degree??0,c=i.block(is),l={logScales:i.block(3),scales:i.block(3),quats:i.block(4),sh:i.part(c,0,12),lobes:i.block(2*(a+1)**2+2),statics:i.block(t.network?19:0),words:i.block(18)};this.#o=l.quats,this.#n=o&&new nt(i,l,l.lobes,o,e.lobes),this.#i=t.network?new pe(i,l,l.statics):null;let{appearance:f}=e;t.colors==="linear"?this.#s=new Je(i,c,f):t.colors==="latent_networks"?this.#s=new et(i,c,f):this.#s=new tt(i,c,f,r.exponent),i.allocate(),this.#a=Object.fromEntries([...e.books].map(([p,d])=>[p,{...d,columns:[]}])),this.#l=as(this.#h("scale")),this.#f=as(_e(this.#h("scale")));let h=Object.fromEntries(Object.entries(l).map(([p,{numbers:d}])=>[p,d])),u=ri(this.#l);this.#r={...h,count:0,lobeDegree:a,scaleRange:u,memory:i.wasmMemory},this.#c={sh:this.#p(n),lobes:[0,1/st]},this.#n&&(this.#c.lobes=this.#m(this.#n))}#p(e){let{sh:t}=this.#r,n=new Float64Array(12),o=_e(this.#h("appearance"));for(let r=0;r<e.length;r+=3*y){let i=e.subarray(r,r+3*y);this.#s.decode(i,o,0);for(let a=0;a<12;a++)for(let c=0;3*c<i.length;c++)n[a]+=3*t[a*y+c]/e.length}return n}#m(e){let{scales:t,quats:n,sh:o,lobes:r}=this.#r,i=this.#a.lobes;return B(this.#f,t,y,0,y),Se(n,si),Se(o,this.#c.sh),e.decode(i?_e(i):null,0,y),Array.from({length:r.length/y-2},(a,c)=>r[c*y])}decode({positions:e,columns:t},n=0){let{header:o}=this.#e,r=e.subarray(3*n,3*(n+y)),i=r.length/3,a=n+i,[c,l]=[this.#r,this.#a];c.count=i,c.positions=r;let{logScales:f,scales:h,quats:u,sh:p,lobes:d}=c,{scale:m,rotation:g,appearance:v}=t,E=!0;for(let _ of Object.keys(l)){let k=t[_];k?this.#h(_).columns=k:E=!1}this.#l.columns=m,B(this.#h("scale"),f,y,n,a),B(this.#l,h,y,n,a);let w=o.scalars.get("rotation");if(w?Gn(w,g,n,a,u):(B(this.#h("rotation"),u,y,n,a),this.#t.units(this.#o,this.#o)),v?this.#s.decode(r,this.#h("appearance"),n):Se(p,this.#c.sh),this.#n&&E?this.#n.decode(l.lobes??null,n,a):Se(d,this.#c.lobes),l.opacity){let{books:[_]}=t.opacity?l.opacity:_e(l.opacity),k=t.opacity?.[0];oi(d,_,k,n,i)}return this.#i?.write(),c}get network(){return this.#i!==null}get lobeDegree(){return this.#r.lobeDegree}get scaleRange(){return this.#r.scaleRange}get neutral(){let e=[0,1,2].map(r=>.5+st*this.#c.sh[r]),[t,n,o]=this.#f.books.map(([r])=>r);return{color:e,side:ni*Math.cbrt(t*n*o)}}#h(e){return this.#a[e]}};function oi(s,e,t,n,o){for(let r=0;r<o;r++)s[r]+=e[t?t[n+r]:0]/st}function as(s){return{...s,books:s.books.map(e=>e.map(Math.exp))}}function ri({books:s}){let e=[1/0,-1/0];for(let t of s)for(let n of t)e=[Math.min(e[0],n),Math.max(e[1],n)];return e}function cs(s){let[e,t,n]=[1,2,3].map(c=>s[`hidden${c}.weight`]),o=["opacity","phi"].map(c=>({weights:ii(s[`${c}.weight`],n,128),offset:s[`${c}.weight`].reduce((l,f,h)=>l+f*s["hidden3.bias"][h],s[`${c}.bias`][0])})),r=new Float32Array(16*2497),i=0,a=(c,l,f)=>{for(let h=c;h<c+4;h++)for(let u=l;u<l+4;u++)r[i++]=f(h,u)};for(let c=0;c<256;c+=4)for(let l=0;l<24;l+=4)a(c,l,(f,h)=>h<22?e[22*f+h]:h===22?s["hidden1.bias"][f]:0);for(let c=0;c<128;c+=4)a(c,0,(l,f)=>f===0?s["hidden2.bias"][l]:0);for(let c=0;c<256;c+=4)for(let l=0;l<128;l+=4)a(l,c,(f,h)=>t[256*f+h]);for(let c=0;c<128;c+=4)a(0,c,(l,f)=>o[l]?.weights[f]??0);return a(0,0,(c,l)=>l===0?o[c]?.offset??0:0),r}function ii(s,e,t){return Array.from({length:t},(n,o)=>s.reduce((r,i,a)=>r+i*e[t*a+o],0))}var{fround:U}=Math,ai=["mobile_gs","no_depth","no_scale","sort_free_gs"],ci=X(-1e4),li=[2047,2047,1023],ls=U(511/Math.SQRT1_2),fs=888,Me=new Uint32Array(1),ot=new Float32Array(Me.buffer);function hs({sorted:s,weighting:e,footprint:t,background:n,grid:o,lobes:r},i,a,c=null){let l=r?.degree??0,[f,h]=ds(a);return{count:i,packing:{center:Array.from(o.center),unit:o.radius*2**o.exponent,leastScaleBits:f,scaleBitsSpan:h},...us(c?10:ps(l),i),network:c&&cs(c),shSize:4,lobeSize:(l+1)**2,sorted:s,weighting:{index:ai.indexOf(e.name),exponentMax:e.exponent_max,sigma:e.sigma,backgroundWeight:e.background_weight,alphaMin:e.alpha_min},footprint:t,background:Array.from(n)}}function rt(s,e,t=us(Qt(s),e.positions.length/3)){let n=e.positions.length/3,o=Qt(s),r=4*y,i;for(let a=0;a<n;a+=y){let c=s.decode(e,a);i??=fi(c);let l=i();t.shapes.set(l.subarray(0,4*c.count),4*a),t.colors.set(l.subarray(r,r+4*c.count),4*a),t.lobes.set(l.subarray(2*r,2*r+o*c.count),o*a)}return t}var us=(s,e)=>({shapes:new Uint32Array(4*e),colors:new Uint32Array(4*e),lobes:new Uint32Array(s*e)});function ds(s){let[e,t]=s.map(n=>(ot[0]=n,U(Me[0])));return[e,t-e]}var ps=s=>(s+1)**2+2>>1,Qt=({network:s,lobeDegree:e})=>s?10:ps(e);function fi(s,e=!1){let{scales:t,quats:n,sh:o,lobes:r,lobeDegree:i,statics:a,scaleRange:c,memory:l}=s,{buffer:f,byteOffset:h,length:u}=s.words,p=new Uint32Array(f,h,u),[d,m]=ds(c),g=m>0?U(1/m):0,v=e?null:de(l),[E,w,_,k]=[t,n,o,r].map(({byteOffset:Q})=>Q),S=a.length>0,[I,K]=[(i+1)**2-1,Qt({network:S,lobeDegree:i})];return()=>{v?v.pack(E,w,_,k,h,I,K,d,g):hi(s,p,K,d,g),S&&ui(a,p);let{count:Q,positions:O}=s;for(let q=0,Z=0;q<Q;q++,Z+=4)p[Z]=O[3*q]|O[3*q+1]<<16,p[Z+1]|=O[3*q+2];return p}}function hi({scales:s,quats:e,sh:t,lobes:n,lobeDegree:o},r,i,a,c){let l=2*(o+1)**2;for(let f=0;f<y;f++){let h=8*y+i*f,u=mi(n,f,l,r,h);pi(t,f,r,4*(y+f)),r[4*f+1]=u<<16;let p=0;for(let m=2;m>=0;m--){ot[0]=s[m*y+f];let g=U(U(U(Me[0])-a)*c);p=p<<11|U(U(li[m]*Math.min(Math.max(g,0),1))+.5)}r[4*f+2]=p;let d=[0,1,2,3].map(m=>e[m*y+f]);r[4*f+3]=di(d),d.some(Boolean)||(r[h]=ci|r[h]&4294901760)}}function ui(s,e){for(let t=0;t<y;t++){let n=8*y+10*t;e[n]=e[n]&65535|Math.round(32767*s[t])<<16;for(let o=1;o<10;o++){let[r,i]=[2*o-1,2*o].map(a=>Math.round(32767*s[a*y+t]));e[n+o]=r&65535|i<<16}}}function di(s){let e=0;for(let o=1;o<4;o++)Math.abs(s[o])>Math.abs(s[e])&&(e=o);let t=s[e]<0?-ls:ls,n=e;for(let o=0;o<4;o++)o!==e&&(n=n<<10|U(U(t*s[o])+1024.5)&1023);return n}function pi(s,e,t,n){let o=c=>s[c*y+e],r=Array.from({length:9},(c,l)=>o(3+l)),i=ws(r),a=r.map(c=>gs(i,c));t[n]=X(o(0))|X(o(1))<<16,t[n+1]=X(o(2))|i<<16|a[0]<<24;for(let c of[1,5])t[n+1+(c+3>>2)]=ms(a,c)}function mi(s,e,t,n,o){let r=f=>s[f*y+e],i=Array.from({length:t-2},(f,h)=>r(2+h)),[a,c]=[0,1].map(f=>ws(i.filter((h,u)=>u%2===f))),l=i.map((f,h)=>gs(h%2?c:a,f));n[o]=X(r(0))|X(r(1))<<16;for(let f=0,h=o+1;f<l.length;f+=4,h++)n[h]=ms(l,f);return a|c<<8}var ms=(s,e)=>s[e]|s[e+1]<<8|s[e+2]<<16|s[e+3]<<24;function gs(s,e){Me[0]=s+fs<<20;let t=U(U(127/ot[0])*e);return U(Math.min(Math.max(t,-127),127)+512.5)&255}function ws(s){return ot[0]=Math.max(0,...s.map(Math.abs)),Math.min(Math.max((Me[0]+1048575>>20)-fs,0),255)}function Zt(){let s=URL.createObjectURL(new Blob([`(${bundle})()`],{type:"text/javascript"}));return setTimeout(()=>URL.revokeObjectURL(s),6e4),new Worker(s)}function bs(s,e){let t=globalThis.preloadedWorker;delete globalThis.preloadedWorker;let n;return t&&"url"in s&&t.url===s.url?(n=t.worker,t.messages.forEach(e)):(t?.worker.terminate(),n=Zt(),n.postMessage(s)),n.onmessage=e,n}async function vs(){let s=globalThis.preloadedAdapter;return delete globalThis.preloadedAdapter,await s??navigator.gpu.requestAdapter({powerPreference:"high-performance"})}async function ys(s){return b[s]}function xs(){return"0.1.0"}function Es(){let s=document.getElementById("scene");if(s===null)return null;let e=atob(s.textContent),t=new Uint8Array(e.length);for(let n=0;n<t.length;n++)t[n]=e.charCodeAt(n);return new Blob([t])}var _s=8192,gi=1e5,wi=3,bi=2,vi=8,it=class{results=[];#e=[];#t;#o=null;#s=null;#n=[];#i;#r=null;#c;#a;#l=!1;#f=!1;#p=()=>{};#m=()=>{};#h=new Promise((e,t)=>{this.#p=e,this.#m=t});constructor(e){this.#h.catch(()=>{});let t=0;for(let[n,o]of e.entries()){for(let r=0;r<o;r+=_s)this.#e.push({level:n,from:r,to:Math.min(r+_s,o),first:t+r});t+=o}this.#t=new Uint8Array(e.length),this.#c=new Uint8Array(this.#e.length),this.#a=this.#c.slice(),this.#i=t}set output(e){if(this.#r=e,e!==null)for(let[t,n]of this.results.splice(0))As(n,ks(e,this.#i,t,t+n.shapes.length/4))}spawn(){let{decoderInputs:e}=this.#o,t=this.#i<gi?1:navigator.hardwareConcurrency;for(let n=1;n<Math.min(t,wi+1);n++)this.#w(e)}#w(e){try{let t=Zt();t.postMessage({decoderInputs:e});let n={worker:t,jobs:0};t.onmessage=({data:o})=>{n.jobs--,this.#y(o),this.#E(n)},t.onerror=o=>o.preventDefault(),this.#n.push(n)}catch{}}start(e){return this.#o=e,this.#s=new we(e.decoderInputs)}advance(e,t){if(!(t<=this.#t[e])){this.#t[e]=t;for(let n of this.#n)this.#E(n);this.#k().catch(this.#m)}}finish(){return this.#f=!0,this.#_(),this.#h}terminate(){for(let{worker:e}of this.#n)e.terminate()}get#b(){return this.#c.findIndex((e,t)=>e<this.#v(t))}get#g(){let e=this.#b;return e<0?this.#a.findIndex((t,n)=>t<this.#v(n)):e}#v(e){return this.#t[this.#e[e].level]}#u(e,t){let{levels:n}=this.#o,{level:o,from:r,to:i}=this.#e[e];return n[o].rows(r,i,t)}#x(e){let{first:t,from:n,to:o}=this.#e[e];return this.#r?ks(this.#r,this.#i,t,t+o-n):void 0}#E(e){for(let t;e.jobs<bi&&(t=this.#b)>=0;e.jobs++){let n=this.#c[t]=this.#v(t),o=this.#u(t,"slice"),r=[o.positions,...Object.values(o.columns).flat()].map(({buffer:i})=>i);e.worker.postMessage({rows:o,chunk:t,stage:n},{transfer:r})}}async#k(){if(!this.#l){this.#l=!0;for(let e;(e=this.#g)>=0&&this.#s;){let t=this.#c[e]=this.#v(e),n=rt(this.#s,this.#u(e,"subarray"),this.#x(e));this.#y({chunk:e,stage:t,packed:n}),await Jt()}this.#l=!1}}#y({chunk:e,stage:t,packed:n}){if(t<=this.#a[e])return;this.#a[e]=t;let o=this.#x(e);o===void 0?this.results.push([this.#e[e].first,n]):o.shapes.buffer!==n.shapes.buffer&&As(n,o),this.#_()}get firstLevelReady(){return this.#e.every(({level:e},t)=>e>0||this.#a[t]>0)}get levels(){let e=this.#a.findIndex(t=>t<ke);return e<0?this.#t.length:this.#e[e].level}#_(){this.#f&&this.#g<0&&this.#p()}};function ks(s,e,t,n){let o=r=>{let i=s[r].length/e;return s[r].subarray(i*t,i*n)};return{shapes:o("shapes"),colors:o("colors"),lobes:o("lobes")}}function As(s,e){for(let t of Object.keys(e))e[t].set(s[t])}var Ss=0;async function Jt(){if(performance.now()-Ss<vi)return;let{port1:s,port2:e}=new MessageChannel;await new Promise(t=>{s.onmessage=()=>{s.close(),t(null)},e.postMessage(null)}),Ss=performance.now()}function at(s,[e,t,n]){let o=s.length/3,r=new Float32Array(o);for(let l=0;l<o;l++)r[l]=e*s[3*l]+t*s[3*l+1]+n*s[3*l+2];let i=new Uint32Array(r.buffer);for(let l=0;l<o;l++)i[l]=i[l]&2147483648?i[l]:~i[l]&2147483647;let a=Uint32Array.from({length:o},(l,f)=>f),c=new Uint32Array(o);for(let l of[0,16]){let f=new Uint32Array(65537);for(let h=0;h<o;h++)f[(i[h]>>>l&65535)+1]+=1;for(let h=0;h<65536;h++)f[h+1]+=f[h];for(let h=0;h<o;h++){let u=a[h];c[f[i[u]>>>l&65535]++]=u}[a,c]=[c,a]}return a}function Ms(s){let e=s.length/3,t=Math.max(1,Math.floor(e/1e4)),n=[0,1,2].map(a=>Float32Array.from({length:Math.ceil(e/t)},(c,l)=>s[3*l*t+a])),o=n.map(a=>a.slice().sort()[a.length-1>>1]),r=n[0].map((a,c)=>Math.max(...n.map((l,f)=>Math.abs(l[c]-o[f])))),i=r.sort()[Math.floor(.9*(r.length-1))];return .2*Math.min(1,Math.max(i,1e-6))}var M=(s,e,t=1)=>[s[0]+t*e[0],s[1]+t*e[1],s[2]+t*e[2]],R=(s,e)=>M(s,e,-1),L=(s,e)=>s[0]*e[0]+s[1]*e[1]+s[2]*e[2],z=(s,e)=>[s[1]*e[2]-s[2]*e[1],s[2]*e[0]-s[0]*e[2],s[0]*e[1]-s[1]*e[0]],ee=s=>Math.hypot(...s);function W(s){let e=ee(s);return e>0?[s[0]/e,s[1]/e,s[2]/e]:[1,0,0]}function en(s,e,t){let[n,o]=[Math.cos(t),Math.sin(t)],r=L(s,e)*(1-n),i=z(e,s);return M(M([s[0]*n,s[1]*n,s[2]*n],i,o),e,r)}var Ts=.02,yi=/^-?\d{1,9}(\.\d{1,9})?$/,Te=new Map([["-y",[0,-1,0]],["z",[0,0,1]],["y",[0,1,0]],["-z",[0,0,-1]],["x",[1,0,0]],["-x",[-1,0,0]]]),te=[0,-1,0];function Rs(s){let e=W(s.reduce((n,{down:o})=>R(n,o),[0,0,0])),t=e;for(let n=0;n<200;n++){let o=M([0,0,0],t,1+Ts);for(let{right:r}of s)o=M(o,r,-L(r,t)/s.length);t=W(M(o,e,Ts*L(e,t)))}return t}function Ls(s,e){let t=L(te,e);if(t<1e-9-1)return[s[0],-s[1],-s[2]];let n=z(te,e),o=z(n,s);return M(M(s,o),z(n,o),1/(1+t))}function ct(s){let e=typeof s=="string"?s.trim().split(/\s+/):[];if(e.length!==3||!e.every(n=>yi.test(n)))return null;let t=e.map(Number);return t.some(n=>n!==0)?W(t):null}function Os(s,e){let t=[...Te.keys()],n=i=>L(Te.get(i)??te,e),o=t.reduce((i,a)=>n(a)>n(i)?a:i),r=[null,...t.filter(i=>i!==o)];return r[(r.indexOf(s===o?null:s)+1)%r.length]}var xi=65536,Ei=.28209479177387814,[_i,ki]=[13.8,-69],Ai=new Map([["char",1],["int8",1],["uchar",1],["uint8",1],["short",2],["int16",2],["ushort",2],["uint16",2],["int",4],["int32",4],["uint",4],["uint32",4],["float",4],["float32",4],["double",8],["float64",8]]),Si=new Map([["x",[1,0,0]],["y",[0,-1,0]],["z",[0,0,1]]]),Fs=["x","y","z","f_dc_0","f_dc_1","f_dc_2","opacity","scale_0","scale_1"];Fs.push("scale_2","rot_0","rot_1","rot_2","rot_3");function nn(s){return s[0]===112&&s[1]===108&&s[2]===121}function Us(s){let{offsets:e,stride:t,rows:n,start:o,footprint:r,up:i}=Mi(s),a=new DataView(s.buffer,s.byteOffset+o),c=[...e.keys()].filter(v=>v.startsWith("f_rest_")).length,l=c/3+1;if(![1,4,9,16].includes(l))throw new Error(`the .ply file has ${c} numbers f_rest_*: 0, 9, 24 or 45 were expected`);let f=v=>e.get(v),h=["x","y","z","scale_0","scale_1","scale_2","rot_0","rot_1","rot_2","rot_3"];h.push("opacity","f_dc_0","f_dc_1","f_dc_2");for(let v=0;v+1<l;v++)for(let E=0;E<3;E++)h.push(`f_rest_${E*(l-1)+v}`);let u=h.find(v=>!e.has(v));if(u)throw new Error(`the .ply file has ${c} numbers f_rest_*, but not ${u}`);let p=h.map(f),d={...sn(n,l,r),up:i},m=new Float32Array(p.length);for(let v=0;v<n;v++){for(let w=0;w<m.length;w++)m[w]=a.getFloat32(v*t+p[w],!0);for(let w=3;w<6;w++)m[w]===-1/0&&(m[w]=ki);Math.abs(m[10])===1/0&&(m[10]=Math.sign(m[10])*_i);let E=0;for(let w=0;w<m.length;w++)E+=m[w]*0;E===0&&on(d,m)}let{count:g}=d;return g===n||(d.shapes=d.shapes.slice(0,12*g),d.colors=d.colors.slice(0,3*l*g),d.lobes=d.lobes.slice(0,2*g)),d}function tn(s=""){return`'${s.slice(0,40).replace(/[^\x20-\x7e]/g,"\uFFFD")}'`}function sn(s,e,t){return{count:0,packing:null,shapes:new Float32Array(12*s),colors:new Float32Array(3*e*s),shSize:e,lobes:new Float32Array(2*s),lobeSize:1,sorted:!0,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},footprint:t,background:[0,0,0]}}function on(s,e){let[t,n,o,r]=[e[6],e[7],e[8],e[9]],i=t*t+n*n+o*o+r*r;if(!(i>0))return;let a=2/i,[c,l,f]=[Math.exp(e[3]),Math.exp(e[4]),Math.exp(e[5])];if(!(c+l+f<1e30&&Math.abs(e[10])<1e30))return;let h=s.count++;s.shapes.set([c*(1-a*(o*o+r*r)),c*a*(n*o+t*r),c*a*(n*r-t*o),e[0],l*a*(n*o-t*r),l*(1-a*(n*n+r*r)),l*a*(o*r+t*n),e[1],f*a*(n*r+t*o),f*a*(o*r-t*n),f*(1-a*(n*n+o*o)),e[2]],12*h),s.lobes[2*h]=e[10]/Ei,s.colors.set(e.subarray(11),3*s.shSize*h)}function Mi(s){let e=new TextDecoder("latin1").decode(s.subarray(0,xi)),t=/\nend_header\r?\n/.exec(e);if(!nn(s)||t===null)throw new Error("this is not a PLY file, or its header is cut off");let n=e.slice(0,t.index).split(/\r?\n/).map(u=>u.trim().split(/\s+/)),o=n.find(u=>u[0]==="format")?.[1];if(o!=="binary_little_endian")throw new Error(`the .ply file is ${tn(o)}: only binary_little_endian is read`);let r=n.findIndex(u=>u[0]==="element"),i=n[r]??[],a=/^\d+$/.test(i[2])?Number(i[2]):NaN;if(i[1]!=="vertex"||!Number.isSafeInteger(a)||a<0)throw new Error("the .ply file does not begin with its vertices, as those of 3DGS do");let c=new Map,l=0;for(let u of n.slice(r+1)){if(u[0]==="element")break;if(u[0]!=="property")continue;let p=Ai.get(u[1]);if(p===void 0)throw new Error(`the .ply file has a property of type ${tn(u[1])}`);if(u.length!==3)throw new Error("the .ply file has a property without a name, or with two");if(c.has(u[2]))throw new Error(`the .ply file has the property ${tn(u[2])} twice`);(u[1]==="float"||u[1]==="float32")&&c.set(u[2],l),l+=p}let f=Fs.filter(u=>!c.has(u));if(f.length)throw new Error(`the .ply file is not a Gaussian scene: it lacks ${f.join(", ")} as floats`);let h=t.index+t[0].length;if(h+a*l>s.length)throw new Error(`the .ply file is cut off: ${a} Gaussians were announced`);return{offsets:c,stride:l,rows:a,start:h,footprint:Ti(n),up:Ri(n)}}function Ti(s){let e={...J};for(let[t,...n]of s){if(t!=="comment")continue;let o=n.join(" ");n[0]==="SplatRenderMode:"?e.antialiased=n[1]?.toLowerCase()==="mip":o==="antialiased 1"||o==="postshot.anti_aliasing=1"?e.antialiased=!0:n.length===3&&o.startsWith("mobilegs blur ")&&(e.blur=/^\d*\.?\d+$/.test(n[2])?Number(n[2]):NaN)}if(!(e.blur>0&&e.blur<=4))throw new Error("the .ply file names a blur that is not possible: above 0 and at most 4 is");return e}function Ri(s){let e=null;for(let t of s){let[n,o,r,...i]=t.map(a=>a.toLowerCase());n==="comment"&&(o==="vertical"&&r==="axis:"&&i.length===1&&(e=Si.get(i[0])??e),o==="mobilegs"&&r==="up"&&(e=ct(i.join(" "))??e))}return e}var G="the compressed data is damaged or cut off";var le=class{left;#e;constructor(e){let t=e[e.length-1];if(!t)throw new Error(G);this.#e=e,this.left=8*e.length-1-Math.clz32(t)+24}take(e){return e>24?this.take(e-16)*65536+this.take(16):(this.left-=e,this.#t(this.left,e))}decode(e,{width:t,symbols:n,bits:o}){for(let r=0;r<e.length;r++){let i=this.#t(this.left-t,t);e[r]=n[i],this.left-=o[i]}if(this.left!==0)throw new Error(G)}#t(e,t){let n=this.#e;if(e<0)return e+t>0?this.#t(0,e+t)<<-e:0;let o=e>>3;return(n[o]|n[o+1]<<8|n[o+2]<<16|n[o+3]<<24)>>>(e&7)&(1<<t)-1}};function zs(s){let e=new Uint8Array(1);return{accuracy:0,symbols:Uint8Array.of(s),bits:e,bases:new Uint16Array(1)}}function Re(s,e){let t=1<<s,n={accuracy:s,symbols:new Uint8Array(t),bits:new Uint8Array(t),bases:new Uint16Array(t)},o=t;for(let[c,l]of e.entries())l===-1&&(n.symbols[--o]=c);let r=(t>>1)+(t>>3)+3,i=0;for(let[c,l]of e.entries())for(let f=0;f<l;f++){n.symbols[i]=c;do i=i+r&t-1;while(i>=o)}if(i!==0)throw new Error(G);let a=e.map(c=>Math.abs(c));for(let c=0;c<t;c++){let l=a[n.symbols[c]]++,f=s-(31-Math.clz32(l));n.bits[c]=f,n.bases[c]=(l<<f)-t}return n}function rn(s,e,t,n){let o=8*e,r=l=>{let f=o>>3,u=(s[f]|s[f+1]<<8|s[f+2]<<16)>>(o&7)&(1<<l)-1;return o+=l,u},i=5+r(4);if(i>t)throw new Error(G);let a=[];for(let l=1<<i;l>0;){let f=32-Math.clz32(l+1),h=(1<<f)-2-l,u=r(f-1);u>=h&&r(1)&&(u+=(1<<f-1)-h);let p=u-1;l-=Math.abs(p),a.push(p);for(let d=p===0?3:0;d===3;){d=r(2);for(let m=0;m<d;m++)a.push(0)}if(l<0||a.length>n)throw new Error(G)}let c=o+7>>3;if(c>s.length)throw new Error(G);return{table:Re(i,a),end:c}}function Ns(s,e){let t=s[e++];if(!(t<128)){let l=t-127,f=e+(l+1>>1);if(!(f<=s.length))throw new Error(G);let h=u=>s[e+(u>>1)]>>(u%2?0:4)&15;return{weights:Array.from({length:l},(u,p)=>h(p)),end:f}}let n=e+t;if(n>s.length)throw new Error(G);let{table:o,end:r}=rn(s.subarray(0,n),e,6,13),i=new le(s.subarray(r,n)),a=[],c=[i.take(o.accuracy),i.take(o.accuracy)];for(let l=0;a.length<255;l^=1){let f=c[l];if(a.push(o.symbols[f]),c[l]=o.bases[f]+i.take(o.bits[f]),i.left<0)return a.push(o.symbols[c[l^1]]),{weights:a,end:n}}throw new Error(G)}function Is(s){let e=c=>c>0?1<<c-1:0,t=0;for(let c of s)t+=e(c);let n=32-Math.clz32(t),o=(1<<n)-t;if(t===0||n>11||o&o-1)throw new Error(G);let r=[...s,32-Math.clz32(o)];if(r.length>256)throw new Error(G);let i={width:n,symbols:new Uint8Array(1<<n),bits:new Uint8Array(1<<n)},a=0;for(let c=1;c<=n;c++)for(let[l,f]of r.entries()){if(f!==c)continue;let h=a+e(c);i.symbols.fill(l,a,h),i.bits.fill(n+1-c,a,h),a=h}return i}var Li=4247762216,Oi=25481893,Le=1<<17,T="the compressed data is damaged or cut off";function Ps(s,e){let t=[];for(let n of e)t.push(s),s+=2**n;return{bits:e,bases:t}}var Cs=Ps(0,[...Array(16).fill(0),1,1,1,1,2,2,3,3,4,6,7,8,9,10,11,12,13,14,15,16]),Ds=Ps(3,[...Array(32).fill(0),1,1,1,1,2,2,3,3,4,4,5,7,8,9,10,11,12,13,14,15,16]),Fi=[{accuracy:9,symbols:36,usual:Re(6,[4,3,2,2,2,2,2,2,2,2,2,2,2,1,1,1,2,2,2,2,2,2,2,2,2,3,2,1,1,1,1,1,-1,-1,-1,-1])},{accuracy:8,symbols:32,usual:Re(5,[1,1,1,1,1,1,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1])},{accuracy:9,symbols:53,usual:Re(6,[1,4,3,2,2,2,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1,-1,-1])}],an=class{length=0;bytes;#e;constructor(e){this.#e=e,this.bytes=new Uint8Array(Math.min(e,Le))}reserve(e){let t=this.length+e;if(t>this.#e)throw new Error("the compressed data is longer than announced");if(t<=this.bytes.length)return;let n=new Uint8Array(Math.min(this.#e,Math.max(t,2*this.bytes.length)));n.set(this.bytes.subarray(0,this.length)),this.bytes=n}append(e){this.reserve(e.length),this.bytes.set(e,this.length),this.length+=e.length}fill(e,t){this.reserve(t),this.bytes.fill(e,this.length,this.length+t),this.length+=t}repeat(e,t){if(!(e>0&&e<=this.length))throw new Error(T);this.reserve(t);let{bytes:n}=this,o=this.length+t;if(e>=t)n.copyWithin(this.length,this.length-e,o-e);else for(let r=this.length;r<o;r++)n[r]=n[r-e];this.length=o}};function Bs(s,e){let t=new an(e),n=new DataView(s.buffer,s.byteOffset,s.byteLength),o=0;for(;o<s.length;){if(o+8>s.length)throw new Error(T);let r=n.getUint32(o,!0);if(r>>>4===Oi)o+=8+n.getUint32(o+4,!0);else if(r===Li)o=Ui(s,o+4,t);else throw new Error(T)}if(o!==s.length||t.length!==e)throw new Error(T);return t.bytes}function Ui(s,e,t){let n=s[e++],o=(n&32)!==0;if(o||(e+=1),s.subarray(e,e+=[0,1,2,4][n&3]).some(a=>a))throw new Error("the compressed data needs a dictionary, which is missing");e+=[o?1:0,2,4,8][n>>6];let i={huffman:null,tables:[null,null,null],recent:[1,4,8]};for(let a=!1;!a;){if(e+3>s.length)throw new Error(T);let c=s[e]|s[e+1]<<8|s[e+2]<<16;e+=3,a=(c&1)===1;let l=c>>1&3,f=c>>3,h=l===1?1:f;if(l===3||f>Le||e+h>s.length)throw new Error(T);l===0?t.append(s.subarray(e,e+f)):l===1?t.fill(s[e],f):zi(s.subarray(e,e+f),i,t),e+=h}return e+(n&4?4:0)}function zi(s,e,t){let{literals:n,end:o}=Ci(s,e),r=o,i=s[r++];if(i===void 0)throw new Error(T);if(i===255?(i=s[r]+(s[r+1]<<8)+32512,r+=2):i>127&&(i=(i-128<<8)+s[r++]),i===0){t.append(n);return}let a=s[r++];if(!(i>0)||a===void 0||a&3)throw new Error(T);for(let[c,{accuracy:l,symbols:f,usual:h}]of Fi.entries()){let u=a>>6-2*c&3;if(u===0)e.tables[c]=h;else if(u===1){if(!(s[r]<f))throw new Error(T);e.tables[c]=zs(s[r++])}else if(u===2){let{table:p,end:d}=rn(s,r,l,f);e.tables[c]=p,r=d}}Ni(new le(s.subarray(r)),i,n,e,t)}function Ni(s,e,t,{tables:n,recent:o},r){let[i,a,c]=n;if(!i||!a||!c)throw new Error(T);let l=s.take(i.accuracy),f=s.take(a.accuracy),h=s.take(c.accuracy),u=0,p=r.length+Le;for(let d=e;d>0;d--){let m=a.symbols[f],g=c.symbols[h],v=i.symbols[l],E=2**m+s.take(m),w=Ds.bases[g]+s.take(Ds.bits[g]),_=Cs.bases[v]+s.take(Cs.bits[v]);if(d>1&&(l=i.bases[l]+s.take(i.bits[l]),h=c.bases[h]+s.take(c.bits[h]),f=a.bases[f]+s.take(a.bits[f])),s.left<0||u+_>t.length)throw new Error(T);if(r.append(t.subarray(u,u+_)),u+=_,r.repeat(Ii(E,_,o),w),r.length>p)throw new Error(T)}if(s.left!==0)throw new Error(T);r.append(t.subarray(u))}function Ii(s,e,t){if(s>3)return t.unshift(s-3),t.pop(),t[0];let n=e===0?s:s-1,o=n<3?t[n]:t[0]-1;return n>0&&(t.splice(Math.min(n,2),1),t.unshift(o)),o}function Ci(s,e){let t=s[0]|s[1]<<8|s[2]<<16,n=s[0]&3,o=s[0]>>2&3;if(n<2){let u=[1,2,1,3][o],p=u===1?s[0]>>3:(t&(u===2?65535:16777215))>>4,d=u+(n===0?p:1);if(p>Le||!(d<=s.length))throw new Error(T);return n===0?{literals:s.subarray(u,d),end:d}:{literals:new Uint8Array(p).fill(s[u]),end:d}}let r=[3,3,4,5][o],i=[10,10,14,18][o],a=(t>>>0)+(s[3]??0)*2**24+(s[4]??0)*2**32,c=Math.floor(a/16)%2**i,l=Math.floor(a/2**(4+i))%2**i,f=r+l;if(c>Le||!(f<=s.length))throw new Error(T);let h=r;if(n===2){let{weights:u,end:p}=Ns(s.subarray(0,f),h);e.huffman=Is(u),h=p}if(e.huffman===null)throw new Error(T);return{literals:Di(s.subarray(h,f),c,o!==0,e.huffman),end:f}}function Di(s,e,t,n){let o=new Uint8Array(e);if(!t)return new le(s).decode(o,n),o;if(s.length<6)throw new Error(T);let r=e+3>>2;for(let i=0,a=6;i<4;i++){let c=i<3?s[2*i]|s[2*i+1]<<8:s.length-a;if(a+c>s.length)throw new Error(T);let l=i<3?(i+1)*r:e;if(l>e)throw new Error(T);new le(s.subarray(a,a+c)).decode(o.subarray(i*r,l),n),a+=c}return o}var Pi=1347635022,Bi=1e7,lt=16,Gs=32,qs=[0,3,8,15,24],$i=15,Gi=.15,qi=[-1,-1,1,-1,1,1,-1,1,-1,1,-1,-1,1,-1,1],fe="the .spz file is damaged or cut off";function Hs(s){return s[0]===78&&s[1]===71&&s[2]===83&&s[3]===80||s[0]===31&&s[1]===139}async function Vs(s){if(s[0]!==31){let r=Ws(s,s.length);return $s(r,Vi(r,s))}let{header:e,content:t}=await Hi(s),n=[],o=lt;for(let r of cn(e))n.push(t.subarray(o,o+=r));return $s(e,n)}function Ws(s,e){let t=new DataView(s.buffer,s.byteOffset,s.byteLength);if(s.length<lt||t.getUint32(0,!0)!==Pi)throw new Error("this is not a .spz file");let n=t.getUint32(4,!0),o=n<4;if(n<1||n>4)throw new Error(`the .spz file has version ${n}: 1 to 4 are read`);if(!o&&s.length<Gs)throw new Error(fe);let r=t.getUint32(8,!0),[i,a,c,l]=s.subarray(12,16);if(r>Bi)throw new Error(`the .spz file announces ${r} Gaussians, too many to be drawn`);if(r>e)throw new Error(`the .spz file announces ${r} Gaussians in ${e} bytes: it is cut off`);if(i>4||a>24)throw new Error(fe);let[f,h]=[(c&1)!==0,(c&2)!==0];return{version:n,count:r,degree:i,fraction:a,antialiased:f,extended:h,streams:l,table:o?0:t.getUint32(16,!0)}}function cn({version:s,count:e,degree:t}){return[s===1?6:9,1,3,3,s<3?3:4,3*qs[t]].map(n=>n*e)}async function Hi(s){let t=new Response(s).body.pipeThrough(new DecompressionStream("gzip")).getReader(),n=[],o=0,r=null,i=1/0,a=async()=>new Uint8Array(await new Blob(n).arrayBuffer());for(;o<=i;){let{value:c,done:l}=await t.read().catch(()=>{throw new Error(fe)});if(l)break;if(n.push(c),o+=c.length,r===null&&o>=lt){if(r=Ws(await a(),s.length),r.version>3)throw new Error("this is not a .spz file");i=cn(r).reduce((f,h)=>f+h,lt)}}if(r===null)throw new Error("this is not a .spz file");if(o>i&&(await t.cancel().catch(()=>{}),!r.extended))throw new Error("the .spz file holds more than it announces");if(o<i)throw new Error(`the .spz file is cut off: ${r.count} Gaussians were announced`);return{header:r,content:await a()}}function Vi(s,e){let{streams:t,table:n,version:o}=s,r=cn(s),i=n+16*t,a=r.filter(h=>h>0).length;if(o!==4||n<Gs||i>e.length||t!==a)throw new Error(fe);let c=new DataView(e.buffer,e.byteOffset,e.byteLength),[l,f]=[n,i];return r.map(h=>{if(h===0)return new Uint8Array(0);let u=Number(c.getBigUint64(l,!0)),p=Number(c.getBigUint64(l+8,!0));if(l+=16,f+u>e.length||p!==h)throw new Error(fe);let d=e.subarray(f,f+=u);try{return Bs(d,h)}catch(m){throw new Error(`${fe}: ${m instanceof Error?m.message:m}`)}})}function $s({version:s,count:e,degree:t,fraction:n,antialiased:o},r){let[i,a,c,l,f,h]=r,u=qs[t],p=Math.min(u,$i),d=p+1,m=sn(e,d,{...J,antialiased:o}),g=new Float32Array(11+3*d),v=s===1?ji(i):Wi(i,2**-n),E=s<3?Xi:Yi;for(let w=0;w<e;w++){g[0]=v(3*w),g[1]=-v(3*w+1),g[2]=-v(3*w+2);for(let k=0;k<3;k++)g[3+k]=l[3*w+k]/16-10;E(f,w,g);let _=Math.min(Math.max(a[w]/255,1e-6),1-1e-6);g[10]=Math.log(_/(1-_));for(let k=0;k<3;k++)g[11+k]=(c[3*w+k]/255-.5)/Gi;for(let k=0;k<p;k++)for(let S=0;S<3;S++)g[14+3*k+S]=qi[k]*(h[3*(u*w+k)+S]-128)/128;on(m,g)}return m}function Wi(s,e){return t=>{let n=3*t;return e*((s[n]<<8|s[n+1]<<16|s[n+2]<<24)>>8)}}function ji(s){return e=>{let t=C(s[2*e]|s[2*e+1]<<8);if(!Number.isFinite(t))throw new Error(fe);return t}}function Xi(s,e,t){let[n,o,r]=[0,1,2].map(a=>s[3*e+a]/127.5-1),i=Math.sqrt(Math.max(0,1-n*n-o*o-r*r));t.set([i,n,-o,-r],6)}function Yi(s,e,t){let n=4*e,o=s[n]|s[n+1]<<8|s[n+2]<<16|s[n+3]<<24,r=o>>>30,i=[0,0,0,0],a=1;for(let c=0,l=20;c<4;c++){if(c===r)continue;let f=(o>>l&511)/511*Math.SQRT1_2;i[c]=o>>l+9&1?-f:f,a-=f*f,l-=10}i[r]=Math.sqrt(Math.max(0,a)),t.set([i[3],i[0],-i[1],-i[2]],6)}var Ki=8192,Qi=2**20,js=1500,Zi=8,Qs=["shapes","colors","lobes"],he=new Float32Array(0),j=(s,e=[])=>self.postMessage(s,{transfer:e}),Zs=({shapes:s,colors:e,lobes:t})=>[s.buffer,e.buffer,t.buffer];async function Ji(s){if("file"in s)return{source:s.file.stream(),total:s.file.size};let e;try{e=await fetch(s.url)}catch{throw new Error(`${s.url} cannot be reached: is the address right, the network there, and may this site load it (CORS)?`)}if(!e.ok||e.body===null)throw new Error(`${s.url} could not be loaded: the server says ${e.status}`);let t=e.headers.has("Content-Encoding")?NaN:Number(e.headers.get("Content-Length"));return{source:e.body,total:t||NaN}}var ln=class{#e;#t;#o;#s;#n;#i=0;#r=null;#c=!1;constructor(e,t,n,o,r){this.#e=e,this.#n=r,this.#t=t,this.#o=n,this.#s=o;let i=Array.from(e.background),{color:a,side:c}=o.neutral,l=Nt(Bn(t[0].positions,Ki),e.grid),f=c*Math.sqrt(3*e.count/l.length),h={means:l,color:a,side:f,background:i};j({kind:"dots",dots:h,...this.#a},[h.means.buffer])}get#a(){let{views:e,near:t,meta:n}=this.#e;return{views:e,near:t,up:ct(n.up)}}send(e){if(!this.#o.firstLevelReady||!this.allocate(e))return;let t=this.#o.levels,n=this.#i;this.#i=Math.max(t,1);let o=this.#o.results.splice(0),r=this.#r;if(r){this.#r=this.#o.output=null,j({kind:"scene",data:r,means:this.#l(),...this.#a},Zs(r));return}for(let[i,a]of o)for(let c of Qs){let l=a[c];j({kind:"rows",part:c,from:i,numbers:l},[l.buffer])}n!==this.#i&&j({kind:"more",means:this.#l()})}allocate(e){let{count:t}=this.#e;return!this.#c&&Zi*e>=t&&(this.#r=this.#o.output=hs(this.#e,t,this.#s.scaleRange,this.#n),this.#c=!0),this.#c}#l(){let e=this.#t.slice(0,this.#i),t=new Uint16Array(e.reduce((r,{count:i})=>r+3*i,0)),n=0;for(let{positions:r,count:i}of e)t.set(r,n),n+=3*i;let o={stored:t,grid:this.#e.grid};return this.#e.sorted&&(he=He(o)),o}};async function ea(s){let e=null,t=null,[n,o]=[0,0],r=[],i=async({header:a,decoder:c,received:l,total:f},h)=>{if(j({kind:"progress",received:l,total:f}),a===null||c===null)return;o=l,e??=new it(a.lodSizes);let u=r=c.levels,p=h*(f/l-1)>js;u[0].positions&&!t&&(t=new ln(a,u,e,e.start(c),c.network),e.spawn(),n=setInterval(()=>t?.send(o),js)),t?.allocate(l);for(let[d,{stage:m}]of u.entries())t&&(m===Bt||p&&d===0&&m>=ke)&&e.advance(d,m);await Jt()};try{await rs(s,i)}finally{for(let[a,{stage:c,positions:l}]of r.entries())t&&l&&c>=ke&&e?.advance(a,c);await e?.finish().finally(()=>{clearInterval(n),e?.terminate()}),t?.send(o)}return o}async function Xs(s,e,t){let[n,o]=[new Uint8Array(e||Qi),0],r=s.getReader();for(let c;!(c=await r.read()).done;){let l=o+c.value.length;if(l>n.length){let f=n;n=new Uint8Array(Math.max(l,2*n.length)),n.set(f)}n.set(c.value,o),o=l,j({kind:"progress",received:o,total:e})}let i=await t(n.subarray(0,o));if(!i.count)throw new Error("there is no Gaussian in this file that can be drawn");he=new Float32Array(3*i.count);for(let c=0;c<he.length;c++)he[c]=i.shapes[4*c+3];let a={views:[],near:Ms(he),up:i.up??null};return j({kind:"scene",data:i,means:he,...a},Zs(i)),o}async function ta(s){let e=s.getReader(),t=()=>e.read().catch(()=>{throw new Error("the file broke off before its end: load it again")}),n=await t(),o=n?.value??new Uint8Array(0),r=new ReadableStream({async pull(i){let{value:a,done:c}=n??await t();n=null,c?i.close():i.enqueue(a)},cancel:()=>e.cancel()});return{first:o,whole:r}}async function Ys(s){let e=performance.now();try{let{source:t,total:n}=await Ji(s),{first:o,whole:r}=await ta(t),i;nn(o)?i=await Xs(r,n,Us):Hs(o)?i=await Xs(r,n,Vs):i=await ea(r),j({kind:"done",milliseconds:performance.now()-e,bytes:i})}catch(t){let{message:n}=t,o=t instanceof RangeError?`the scene is too large for this device: ${n}`:n;j({kind:"failed",sentence:o})}}var Ks;function Js(){self.onmessage=async({data:s})=>{if("decoderInputs"in s){Ks=new we(s.decoderInputs);return}if("rows"in s){let{rows:e,chunk:t,stage:n}=s,o=rt(Ks,e),r=Qs.map(i=>o[i].buffer);self.postMessage({chunk:t,stage:n,packed:o},{transfer:r});return}if("forward"in s){let e=at(he,s.forward);j({kind:"order",order:e},[e.buffer]);return}await Ys(s)},self.name&&Ys({url:self.name})}var ft=()=>({name:"",before:"",failed:"",state:"",share:NaN,sentence:""}),Oe=class{#e=[ft(),ft()];begin(e,t){let n=this.#e[e].name;this.#e[e]=t===void 0?ft():{...ft(),name:t,before:n,state:"loading"}}fail(e,t,n){let{name:o,before:r}=this.#e[e];this.note(e,{share:1,state:"failed",sentence:t,failed:this.names[e],name:n?r:o})}note(e,t){Object.assign(this.#e[e],t)}get state(){let e=this.#e.map(({state:n})=>n);return["failed","loading","loaded"].find(n=>e.includes(n))??""}get busy(){return this.#e.some(({state:e})=>e==="loading")}get share(){let e=this.#e.filter(({state:t})=>t).map(({share:t})=>t);return e.reduce((t,n)=>t+n,0)/e.length}get sentence(){let e=this.#e.every(({state:n})=>n),t=this.#e.map(({state:n,sentence:o,failed:r})=>n!=="failed"?"":e&&r&&!o.includes(r)?`${r}: ${o}`:o);return[...new Set(t.filter(Boolean))].join("; ")}get names(){return na(this.#e[0].name,this.#e[1].name)}};function na(s,e){let[t,n]=[s,e].map(o=>o.split("/").filter(Boolean));for(let o=1;o<=Math.max(t.length,n.length);o++){let[r,i]=[t,n].map(a=>a.slice(-o).map(fn).join("/"));if(r!==i)return[r,i]}return[fn(t[t.length-1]??""),fn(n[n.length-1]??"")]}function fn(s){try{return decodeURIComponent(s)}catch{return s}}function ht(s){let e=s?.trim().toLowerCase()??"",t=/^([0-9a-f]{3}|[0-9a-f]{6})$/.test(e)?`#${e}`:e,n=/^#[0-9a-f]+$/.test(t)?t:sa(t),o=n.length===4?n.replace(/[^#]/g,"$&$&"):n;if(!/^#[0-9a-f]{6}$/.test(o))return null;let r=i=>Number.parseInt(o.slice(i,i+2),16)/255;return[r(1),r(3),r(5)]}function eo(s){let e=t=>Math.round(255*Math.min(Math.max(t,0),1));return`#${s.map(t=>e(t).toString(16).padStart(2,"0")).join("")}`}function sa(s){let e=s?document.createElement("canvas").getContext("2d"):null;if(!e)return"";let[t,n]=["#000000","#ffffff"].map(o=>(e.fillStyle=o,e.fillStyle=s,String(e.fillStyle)));return t===n?t:""}function to(s,e,t){let n=f=>s.querySelector(`[name=${f}]`);n("background").value=eo(e.background);let o=n("scale"),r=e.scale??0;[...o.options].some(({value:f})=>Number(f)===r)||o.add(new Option(`${Math.round(100*r)} %`,String(r))),o.value=String(r),n("mode").value=e.mode,n("turning").checked=e.turning,n("stats").checked=t;let{renderer:i,adapter:a}=e.device,c=i?`Rendered with ${i}${a?` on ${a}`:""}`:"";s.querySelector(".device").textContent=c;let l=s.querySelector("[data-act=view]");l.hidden=e.views.length<2}function no(s,e){let{name:t,value:n}=s;t==="background"?e.background=ht(n):t==="scale"?e.scale=Number(n)||null:t==="mode"?e.mode=n==="fly"?"fly":"orbit":t==="turning"&&(e.turning=s.checked),e.redraw()}var oa=new Map([["ArrowLeft",-.02],["ArrowDown",-.02],["ArrowRight",.02],["ArrowUp",.02],["PageDown",-.1],["PageUp",.1],["Home",-1],["End",1]]),ut=class{share=.5;#e;#t;#o=["",""];constructor(e,t){this.#e=e,this.#t=t,e.onpointerdown=({pointerId:n})=>e.setPointerCapture(n),e.onpointermove=({pointerId:n,clientX:o})=>{if(!e.hasPointerCapture(n))return;let{left:r,width:i}=t.getBoundingClientRect();this.#s((o-r)/i)},e.onkeydown=n=>{let o=oa.get(n.key);o===void 0||n.ctrlKey||n.metaKey||n.altKey||(n.preventDefault(),this.#s(this.share+o))}}show(e){this.#o=e,this.#e.querySelectorAll("span").forEach((t,n)=>t.textContent=e[n]),this.#e.setAttribute("aria-label",`${e[0]} on the left, ${e[1]} on the right`),this.#e.hidden=!1,this.#t.classList.add("drawn"),this.#s(this.share)}#s(e){this.share=Math.min(Math.max(e,0),1);let t=Math.round(100*this.share);this.#t.style.clipPath=`inset(0 0 0 ${100*this.share}%)`,this.#e.style.left=`${100*this.share}%`,this.#e.setAttribute("aria-valuenow",String(t));let[n,o]=this.#o;this.#e.setAttribute("aria-valuetext",`${t} % ${n}, ${100-t} % ${o}`)}};var so=':host{display:block;position:relative;overflow:hidden;contain:strict;color-scheme:light dark;--paper: #16181dd9;--ink: #f3f4f6;--accent: #7db4ff;--wall: #0d0f12;--field: #ffffff1c;background:var(--wall);color:var(--ink);font:14px/1.4 system-ui,sans-serif;min-height:120px}@media(prefers-color-scheme:light){:host{--paper: #ffffffd9;--ink: #16181d;--accent: #0b62d6;--wall: #e8eaee;--field: #0000000f}}canvas{opacity:0;display:block;width:100%;height:100%;touch-action:none;cursor:grab;outline:none}canvas.drawn{opacity:1}canvas.polite{touch-action:pan-y}canvas:active{cursor:grabbing}canvas.reached{outline:2px solid var(--accent);outline-offset:-2px}.over{position:absolute;inset:0;pointer-events:none}.split{position:absolute;top:0;bottom:0;width:20px;margin-left:-10px;cursor:ew-resize;touch-action:none;outline:none}.split:before{content:"";position:absolute;inset:0 9px;background:#fff;box-shadow:0 0 3px #000a}.split:after{content:"\\2039\\2002\\203a";position:absolute;top:50%;left:-12px;width:44px;height:44px;margin-top:-22px;border-radius:50%;background:var(--paper);line-height:40px;text-align:center;font-size:20px;box-shadow:0 0 0 2px #fff,0 0 5px 2px #000a}.split:focus-visible:after{box-shadow:0 0 0 3px var(--accent)}.split span{position:absolute;top:12px;padding:2px 8px;border-radius:6px;background:var(--paper);max-width:40vw;overflow:hidden;text-overflow:ellipsis;white-space:nowrap}.split span:first-child{right:18px}.split span:last-child{left:18px}[hidden]{display:none!important}.bar{position:absolute;inset:0 0 auto;height:3px;background:transparent}.bar>div{height:100%;width:0;background:var(--accent);transition:width .15s}.bar.unknown>div{width:100%!important;animation:wait 1.2s ease-in-out infinite alternate}@keyframes wait{0%{opacity:.2}}@media(prefers-reduced-motion:reduce){.bar>div{transition:none;animation:none!important}}.panel{position:absolute;background:var(--paper);border-radius:10px;padding:12px 16px;backdrop-filter:blur(8px)}.panel:focus{outline:none}.message,.help,.report{inset:0;margin:auto;width:fit-content;height:fit-content;max-width:min(34em,92%);max-height:92%;box-sizing:border-box;overflow:auto}.message{overflow-wrap:anywhere}.stats{top:12px;left:12px;font-variant-numeric:tabular-nums;white-space:pre;pointer-events:none}.split:not([hidden])~.stats{top:52px}.said{right:12px;top:12px;pointer-events:none}.said:not(.seen){clip-path:inset(50%)}h2{font-size:16px;margin:0 0 8px}.help dl{display:grid;grid-template-columns:fit-content(45%) 1fr;gap:4px 16px;margin:0 0 12px}.help dt{font-weight:600}.help dd{margin:0}.buttons{position:absolute;right:12px;left:12px;bottom:calc(12px + env(safe-area-inset-bottom));display:flex;flex-wrap:wrap;justify-content:end;gap:8px;pointer-events:none}.settings{right:12px;bottom:calc(68px + env(safe-area-inset-bottom));width:min(26em,calc(100% - 24px));box-sizing:border-box;max-height:calc(100% - 80px);overflow:auto}@media(max-height:500px){.settings{bottom:12px;max-height:calc(100% - 24px);columns:2;width:min(40em,calc(100% - 24px))}}.settings p{display:flex;flex-wrap:wrap;align-items:center;gap:8px;margin:0 0 8px}.settings p>label{flex:1}.settings>label{display:flex;align-items:center;gap:8px;min-height:36px}.settings>small{display:block;margin:8px 0 12px;overflow-wrap:anywhere}button,select,[type=color]{font:inherit;color:inherit;background:var(--paper);border:0;border-radius:10px;min-width:44px;min-height:44px;padding:0 9px;cursor:pointer;pointer-events:auto}.panel :is(button,select,[type=color]){background:var(--field)}[type=color]{padding:6px}[type=checkbox]{width:20px;height:20px;margin:0;accent-color:var(--accent)}button:hover{color:var(--accent)}:is(button,select,input,textarea):focus-visible{outline:2px solid var(--accent)}textarea{font:12px/1.3 ui-monospace,monospace;color:inherit;background:transparent;max-width:100%}.drop{inset:12px;border:2px dashed var(--accent);display:grid;place-items:center}';var ra=[["Drag","rotate the scene"],["Two fingers, right button or Shift","move sideways"],["Pinch or wheel","zoom in and out"],["Double tap","look at that point"],["Arrow keys","rotate"],["W A S D Q E","fly; hold Shift to fly faster"],["M","switch between orbiting and looking around"],["V","next training camera"],["R","back to the first view"],["U","turn another axis upwards"],["F","full screen"],["P","save a picture"],["I","frame rate and size"],["O","settings"],["H","help"]],oo=`
<style>${so}</style>
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
<dl>${ra.map(([s,e])=>`<dt>${s}</dt><dd>${e}</dd>`).join("")}</dl>
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
<div class="panel drop" hidden>Drop a scene to open it, or two to compare them</div>`,hn=new Map(Object.entries({r:"reset",m:"mode",f:"full",h:"help",i:"stats",o:"settings",p:"picture",v:"view",u:"up"}));var ro=new Map([["KeyW",[0,0,1]],["KeyS",[0,0,-1]],["KeyA",[-1,0,0]],["KeyD",[1,0,0]],["KeyQ",[0,1,0]],["KeyE",[0,-1,0]]]),io=new Map([["ArrowLeft",[-1,0]],["ArrowRight",[1,0]],["ArrowUp",[0,-1]],["ArrowDown",[0,1]]]),dt=class{#e;#t;#o=new AbortController;#s=new Map;#n=new Set;#i=!1;#r={x:0,y:0,time:0};constructor(e,t){this.#e=e,this.#t=t;let n=(o,r)=>e.addEventListener(o,r,{signal:this.#o.signal,passive:!1});n("pointerdown",o=>this.#a(o)),n("pointermove",o=>this.#l(o)),n("pointerup",o=>this.#f(o)),n("pointercancel",o=>this.#f(o)),n("wheel",o=>this.#b(o)),n("contextmenu",o=>o.preventDefault()),n("keydown",o=>this.#g(o,!0)),n("keyup",o=>this.#g(o,!1)),n("blur",()=>this.#n.clear())}get busy(){return this.#n.size>0}advance(e){if(!this.busy)return;let t=this.#t.pose(),n=.9*t.reach*e*(this.#i?4:1);for(let o of this.#n){let r=ro.get(o);r&&t.move(r[0]*n,r[1]*n,r[2]*n);let i=io.get(o);i&&this.#c(i[0]*1.5*e,i[1]*1.5*e)}this.#t.changed()}destroy(){this.#o.abort()}#c(e,t){let n=this.#t.pose();this.#t.mode()==="orbit"?n.orbit(e,t):n.look(e,t)}#a(e){this.#e.focus({preventScroll:!0}),this.#e.setPointerCapture(e.pointerId),this.#s.set(e.pointerId,{x:e.offsetX,y:e.offsetY});let{x:t,y:n,time:o}=this.#r,r=Math.hypot(e.offsetX-t,e.offsetY-n)<20,i=this.#s.size===1&&e.button===0;i&&r&&e.timeStamp-o<350&&this.#t.focus(e.offsetX,e.offsetY),this.#r={x:e.offsetX,y:e.offsetY,time:i?e.timeStamp:-1/0},this.#t.held(),e.preventDefault()}#l(e){let t=this.#s.get(e.pointerId);if(t===void 0)return;let n={x:e.offsetX,y:e.offsetY};Math.hypot(n.x-this.#r.x,n.y-this.#r.y)>6&&(this.#r.time=-1/0),this.#s.size===1?this.#p(n.x-t.x,n.y-t.y,e):this.#s.size===2&&this.#m(e.pointerId,n),this.#s.set(e.pointerId,n),this.#t.changed()}#f(e){this.#s.delete(e.pointerId)}#p(e,t,n){n.buttons&6||n.shiftKey||n.ctrlKey?this.#h(e,t):this.#c(e*.006,t*.006)}#m(e,t){let n=this.#s.get(e),o=[...this.#s].find(([a])=>a!==e)?.[1];if(n===void 0||o===void 0)return;let r=Math.hypot(n.x-o.x,n.y-o.y),i=Math.hypot(t.x-o.x,t.y-o.y);this.#t.mode()==="fly"?this.#t.pose().move(0,0,2*(i-r)*this.#w):r>0&&i>0&&this.#t.pose().dolly(r/i),this.#h((t.x-n.x)/2,(t.y-n.y)/2)}#h(e,t){this.#t.pose().move(-e*this.#w,-t*this.#w,0)}get#w(){let{target:e,eye:t}=this.#t.pose();return Math.hypot(...e.map((n,o)=>n-t[o]))/Math.max(this.#e.clientHeight,1)}#b(e){if(this.#e.classList.contains("polite")&&!e.ctrlKey&&!e.metaKey)return;e.preventDefault();let t=e.deltaMode===WheelEvent.DOM_DELTA_LINE?16:1,n=e.deltaY*t*(e.ctrlKey?8:1)*.0012,o=this.#t.pose();this.#t.mode()==="orbit"?o.dolly(Math.exp(n)):o.move(0,0,-n*o.reach),this.#t.changed()}#g(e,t){let{code:n}=e;if(this.#i=e.shiftKey,!t&&n.startsWith("Meta")&&this.#n.clear(),t&&(e.ctrlKey||e.metaKey||e.altKey)||!ro.has(n)&&!io.has(n))return;let o=t&&!this.#n.has(n);t?this.#n.add(n):this.#n.delete(n),o&&this.advance(.03),this.#t.changed(),e.preventDefault()}};var ia={from:64,to:65536,times:4},aa={from:32,to:1024,times:2},ao=128,lo="mobilegs variant 1";function fo(s,e){let t=null;try{t=e?.getItem(`${lo} ${s.describe()}`)??null}catch{}return s.variants.find(n=>mo(n)===t)??null}async function ho(s,e){let t={floats:!1,strips:!1},n={...t};if(await co(s,t,{...t,strips:!0},ia,ca)&&(n.strips=!0),s.variants.some(({floats:o})=>o)){let o={...n,floats:!0};await co(s,n,o,aa,la)&&(n.floats=!0)}try{e?.setItem(`${lo} ${s.describe()}`,mo(n))}catch{}return n}async function uo(s){s.setScene({...un(1,1,()=>[0,0,1]),packing:{center:[0,0,0],unit:1,leastScaleBits:0,scaleBitsSpan:0},shapes:Uint32Array.of(0,15360,0,0),colors:new Uint32Array(4),shSize:4,lobes:new Uint32Array(5),lobeSize:9}),await s.drawUnseen(dn(1))}function po(s){s.setDots({means:Float32Array.of(0,0,1),color:[0,0,0],side:1,background:[0,0,0]}),s.drawDots(dn(1)),s.setDots(null)}var mo=({floats:s,strips:e})=>`${s} ${e}`;async function co(s,e,t,{from:n,to:o,times:r},i){let a=0;for(let c=n;;c*=r){let{scene:l,side:f}=i(c);s.setScene(l);let h=[1/0,1/0];for(let p=0;p<=3;p++)for(let[d,m]of[e,t].entries()){s.variant=m;let g=performance.now();await s.drawUnseen(dn(f)),p>0&&(h[d]=Math.min(h[d],performance.now()-g))}let u=Math.max(...h);if(c===n&&(a=u),u>Math.max(4,3*a)||c>=o)return h[1]<.85*h[0]}}function ca(s){let e=Math.ceil(Math.sqrt(s)),t=o=>2*(o+.5)/e-1;return{scene:un(s,.001,o=>[t(o%e),t(Math.floor(o/e)),1]),side:256}}function la(s){return{scene:un(ao,1,e=>[0,0,1+e/ao]),side:s}}function un(s,e,t){let n=new Float32Array(12*s);for(let o=0;o<s;o++){let[r,i,a]=t(o);n.set([e,0,0,r,0,e,0,i,0,0,e,a],12*o)}return{count:s,packing:null,shapes:n,colors:new Float32Array(3*s),shSize:1,lobes:new Float32Array(2*s).fill(1),lobeSize:1,sorted:!1,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},background:[0,0,0]}}function dn(s){return{viewmat:[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],fx:s/2,fy:s/2,cx:s/2,cy:s/2,width:s,height:s,near:.1}}function go(s){return s?.soft_edge?1:1.4}function ne(s,e){let t=[[s,e]];for(let n=1;n<4;n++)t.push(t[n-1].map(o=>(o-(n===1?0:1)>>1)+2));return t}function se(s,e){let[,...t]=ne(s,e),n=[[0,0]],o=0;for(let[,r]of t)n.push([s,o]),o+=r;return{places:n,size:[s+t[0][0],Math.max(e,o)]}}function ve({packing:s,shSize:e,lobeSize:t,network:n}){return s?{shapes:4,colors:4,lobes:n?10:t+2>>1}:{shapes:12,colors:3*e,lobes:2*t}}function wo(s){return C(s&65535)}var Fe=288,pt=2**-6,bo=.3;function Ue(s,e){let{fx:t,fy:n,cx:o,cy:r,width:i,height:a}=s;return{...s,fx:e*t,fy:e*n,cx:e*o,cy:e*r,width:e*i,height:e*a}}function mt(s,e,t,n,o){let{viewmat:r,fx:i,fy:a,cx:c,cy:l,width:f,height:h,near:u}=e,{background:p,weighting:d,packing:m,footprint:g=J}=s,v=bo*.5*f/i,E=bo*.5*h/a,w=[0,1,2].map(O=>-(r[O]*r[3]+r[4+O]*r[7]+r[8+O]*r[11])),_=new Float32Array(Fe/4);_.set([...Array.from(r).slice(0,12),...w,u,i,a,c,l,-c/i-v,(f-c)/i+v,-l/a-E,(h-l)/a+E,...p,d.exponentMax,f,h,d.sigma,d.backgroundWeight,t]);let k=[s.count,s.shSize,s.lobeSize,d.index];if(new Int32Array(_.buffer).set(k,33),m){let{center:O,unit:q,leastScaleBits:Z,scaleBitsSpan:Jo}=m;_.set([...O,q,Z,Jo],40)}_[46]=!s.sorted&&d.alphaMin||1/255,_[47]=g.blur,new Int32Array(_.buffer).set([Number(g.antialiased),Number(g.soft_edge&&!s.sorted)],48),_[50]=n,new Int32Array(_.buffer)[51]=o;let S=ne(f,h),{places:I,size:K}=se(f,h),Q=I.flatMap(([O,q],Z)=>[O,q,O+S[Z][0],q+S[Z][1]]);return _.set([...Q,...K],52),_}var gt=class{milliseconds=null;#e;#t;#o=!1;#s=!1;#n=[];constructor(e){this.#e=e,this.#t=e.getExtension("EXT_disjoint_timer_query_webgl2")}start(){this.#s=this.#o&&!this.#n.length}pass(e){if(!this.#s)return;let[t,n]=[this.#e,this.#t.TIME_ELAPSED_EXT];if(this.#n.length&&t.endQuery(n),e){let o=t.createQuery();this.#n.push([e,o]),t.beginQuery(n,o)}else this.#s=!1}async time(){let e=this.#e;this.#o=this.#t!==null;let t=this.#n[this.#n.length-1];if(!t||this.#s)return;for(let o=0;o<100&&!e.getQueryParameter(t[1],e.QUERY_RESULT_AVAILABLE);o++)await new Promise(r=>setTimeout(r,5));let n=this.#n.map(([o,r])=>[o,e.getQueryParameter(r,e.QUERY_RESULT)/1e6]);e.getParameter(this.#t.GPU_DISJOINT_EXT)||(this.milliseconds=Object.fromEntries(n));for(let[,o]of this.#n.splice(0))e.deleteQuery(o)}forget(){this.#n=[],this.#s=!1}};function wt({color:s,side:e},{viewmat:t,fx:n,fy:o,cx:r,cy:i,width:a,height:c,near:l}){let[f,h,u]=[0,4,8].map(p=>Array.from(t).slice(p,p+4));return Float32Array.of(...f.map((p,d)=>2*(n*p+r*u[d])/a-u[d]),...h.map((p,d)=>u[d]-2*(o*p+i*u[d])/c),...u,...s,l,o*e/2,.002*c/2,2/a,2/c)}function bt({means:s}){let e=new Float32Array(6*s.length);for(let t=0,n=0;t<s.length;t+=3)for(let o=n+18;n<o;n+=3)e[n]=s[t],e[n+1]=s[t+1],e[n+2]=s[t+2];return e}var vt=["shapes","colors","lobes","looks","opacities","order","color_sums","weight_sums","color_sums_1","weight_sums_1","color_sums_2","weight_sums_2"],yt=class{#e;#t=new Map;constructor(e){this.#e=e}make(e,t,[n,o]){let r=this.#e;r.deleteTexture(this.#t.get(e)??null);let i=r.createTexture();return this.#t.set(e,i),r.activeTexture(r.TEXTURE0+vt.indexOf(e)),r.bindTexture(r.TEXTURE_2D,i),r.texStorage2D(r.TEXTURE_2D,1,t,n,o),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MIN_FILTER,r.NEAREST),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MAG_FILTER,r.NEAREST),i}upload(e,t,n){let o=this.#e,[r,,i]=t,a=ze(n.length/i);if(a[1]>o.getParameter(o.MAX_TEXTURE_SIZE))throw new Error("the scene has more Gaussians than this GPU's textures can hold");this.make(e,o[r],a),this.write(e,t,0,n)}write(e,[,t,n],o,r){let i=this.#e,a=r instanceof Float32Array?i.FLOAT:i.UNSIGNED_INT,c=r.length/n;i.activeTexture(i.TEXTURE0+vt.indexOf(e));for(let l=0;l<c;){let[f,h]=[(o+l)%4096,Math.floor((o+l)/4096)],u=Math.min(4096-f,c-l),p=u===4096?Math.floor((c-l)/4096):1,d=l*n;i.texSubImage2D(i.TEXTURE_2D,0,f,h,u,p,i[t],a,r,d),l+=u*p}}destroy(){for(let e of this.#t.values())this.#e.deleteTexture(e)}};function ze(s){return[Math.max(1,Math.min(s,4096)),Math.max(1,Math.ceil(s/4096))]}var xt=128,vo=0,pn=["EXT_color_buffer_float","EXT_color_buffer_half_float"];function mn(s){return["EXT_color_buffer_float","EXT_float_blend"].every(e=>s.getExtension(e))}function gn(s){for(let r of[...pn,"EXT_float_blend"])s.getExtension(r);let e=s.getExtension("WEBGL_provoking_vertex");e?.provokingVertexWEBGL(e.FIRST_VERTEX_CONVENTION_WEBGL),s.disable(s.DITHER);let t={view:s.createBuffer(),corners:s.createBuffer(),quads:s.createVertexArray(),looks:s.createFramebuffer(),sums:s.createFramebuffer(),enlarged:[s.createFramebuffer(),s.createFramebuffer()],programs:new Map,counters:new Map,textures:new yt(s)};s.bindBufferBase(s.UNIFORM_BUFFER,vo,t.view),s.bufferData(s.UNIFORM_BUFFER,Fe,s.DYNAMIC_DRAW),s.bindVertexArray(t.quads),s.bindBuffer(s.ELEMENT_ARRAY_BUFFER,t.corners);let n=[0,1,2,2,1,3],o=Array.from({length:xt},(r,i)=>n.map(a=>4*i+a));return s.bufferData(s.ELEMENT_ARRAY_BUFFER,Uint16Array.from(o.flat()),s.STATIC_DRAW),t}function yo(s,e,t){let{whole:n,project:o,splat:r,resolve:i}=e,a=t.packed?e.packed:e.wide,c=Eo(s,e.view,t);return{project:c(n,`${a}${o}`),splat:c(`${a}${r}`,r),resolve:c(n,i),enlarge:t.leveled?[1,2].map(l=>c(n,`#define LEVEL ${l}
${i}`)):[]}}function xo(s,{view:e,packed:t,wide:n,whole:o,count:r},i){return Eo(s,e,i)(o,`#define VERTEX
${i.packed?t:n}${r}`)}function Eo(s,e,{sorted:t,strips:n,leveled:o}){let i=Object.entries({SORTED:t,STRIPS:n,LEVELED:o}).map(([a,c])=>c?`#define ${a}
`:"").join("");return(a,c)=>{let l=wn(s,`${i}#define VERTEX
${e}${a}`,`${i}${e}${c}`);return s.useProgram(l),vt.forEach((f,h)=>s.uniform1i(s.getUniformLocation(l,f),h)),s.uniformBlockBinding(l,s.getUniformBlockIndex(l,"View"),vo),l}}function wn(s,e,t){let n=s.createProgram();for(let[o,r]of[[s.VERTEX_SHADER,e],[s.FRAGMENT_SHADER,t]]){let i=s.createShader(o);s.shaderSource(i,`#version 300 es
${r}`),s.compileShader(i),s.attachShader(n,i),s.deleteShader(i)}if(s.linkProgram(n),!s.getProgramParameter(n,s.LINK_STATUS)&&!s.isContextLost()){let o=(s.getAttachedShaders(n)??[]).map(r=>s.getShaderInfoLog(r));throw o.push(s.getProgramInfoLog(n)),new Error(`this GPU refuses a shader: ${o.join(" ")}`)}return n}var Et=class{#e;#t=null;#o;#s;#n;#i=0;constructor(e,t){this.#e=e,this.#o=wn(e,`#define VERTEX
${t}`,t),this.#s=e.createVertexArray(),this.#n=e.createBuffer(),e.bindVertexArray(this.#s),e.bindBuffer(e.ARRAY_BUFFER,this.#n),e.enableVertexAttribArray(0),e.vertexAttribPointer(0,3,e.FLOAT,!1,0,0)}take(e){let[t,n]=[this.#e,e?bt(e):new Float32Array(0)];this.#t=e,this.#i=n.length/3,t.bindBuffer(t.ARRAY_BUFFER,this.#n),t.bufferData(t.ARRAY_BUFFER,n,t.STATIC_DRAW)}draw(e){let[t,n]=[this.#e,this.#t];n&&(t.bindFramebuffer(t.FRAMEBUFFER,null),t.viewport(0,0,e.width,e.height),t.disable(t.BLEND),t.clearBufferfv(t.COLOR,0,[...n.background,1]),t.useProgram(this.#o),t.uniform4fv(t.getUniformLocation(this.#o,"dots"),wt(n,e)),t.bindVertexArray(this.#s),t.drawArrays(t.TRIANGLES,0,this.#i))}destroy(){let e=this.#e;e.deleteProgram(this.#o),e.deleteVertexArray(this.#s),e.deleteBuffer(this.#n)}};var bn=new Float32Array(0),ko={shapes:["RGBA32UI","RGBA_INTEGER",4],colors:["RGBA32UI","RGBA_INTEGER",4],lobes:["R32UI","RED_INTEGER",1]},So={shapes:["RGBA32F","RGBA",4],colors:["RGB32F","RGB",3],lobes:["RG32F","RG",2]},ha={...So,colors:["RGB16F","RGB",3],lobes:["RG16F","RG",2]},Ao=["R32UI","RED_INTEGER",1],Ne=class s{static files=["view","wide","packed","whole","project","splat","resolve","count","dots"].map(e=>`${e}.glsl`);variant;levelSigma=0;supersampling=1;lost=null;onLost=()=>{};onRestored=()=>{};#e;#t;#o;#s=null;#n=ko;#i=null;#r=null;#c="";#a;#l=e=>{e.preventDefault(),this.#s=this.#i=null,this.lost="the browser took the GPU away from this page: reload it if no picture returns",this.onLost(this.lost)};#f=()=>{this.#s=null,this.#o=gn(this.#e),this.#c="",this.#a.forget(),this.lost=null,this.onRestored()};static create(e,t,{floats:n=!1,strips:o=!1}={}){let r=e.getContext("webgl2",{alpha:!1,antialias:!1,depth:!1,powerPreference:"high-performance"});if(r===null)throw new Error("this browser cannot draw with WebGL2 here");if(!pn.some(i=>r.getExtension(i)))throw new Error("this GPU cannot draw into textures of floats");if(n&&!mn(r))throw new Error("this GPU cannot blend 32-bit floats: use the variant halves");if(r.getParameter(r.MAX_TEXTURE_SIZE)<4096)throw new Error(`this GPU's textures are less than ${4096} pixels wide`);return new s(r,t,{floats:n,strips:o})}constructor(e,t,n){this.#e=e,this.#t=t,this.variant=n,this.#o=gn(e),this.#a=new gt(e),e.canvas.addEventListener("webglcontextlost",this.#l),e.canvas.addEventListener("webglcontextrestored",this.#f)}setScene(e){let t=this.#e;if(this.#s=this.#r=null,e.network)throw new Error("this scene needs a network for every Gaussian in every frame, which takes WebGPU: open it in a browser that has it");this.#n=e.packing?ko:this.variant.floats?So:ha;let{shapes:n,colors:o,lobes:r}=e;for(let[a,c]of Object.entries({shapes:n,colors:o,lobes:r}))this.#o.textures.upload(a,this.#n[a],c);t.bindFramebuffer(t.FRAMEBUFFER,this.#o.looks);let i=e.packing?[t.RG32UI,0]:[t.RGBA32F,t.R32F];["looks","opacities"].forEach((a,c)=>{let l=i[c]?this.#o.textures.make(a,i[c],ze(e.count)):null;t.framebufferTexture2D(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0+c,t.TEXTURE_2D,l,0)}),this.#E("textures of 32-bit numbers"),this.#s={...e,shapes:bn,colors:bn,lobes:bn},e.sorted&&this.#o.textures.upload("order",Ao,Uint32Array.from({length:e.count},(a,c)=>c))}show(e){this.#s&&(this.#s.count=e)}update(e,t,n){if(this.#s===null)return;let o=this.#n[e];this.#o.textures.write(e,o,ve(this.#s)[e]/o[2]*t,n)}setDots(e){this.lost===null&&(this.#i??=new Et(this.#e,this.#t.dots),this.#i.take(e))}drawDots(e){this.#i&&(this.#p(e),this.#i.draw(e))}setOrder(e){if(this.#s!==null){if(e.length!==this.#s.count)throw new Error(`an order of ${e.length} Gaussians does not fit this scene`);this.#o.textures.write("order",Ao,0,e)}}draw(e){this.#s!==null&&(this.#p(e),this.#a.start(),this.#m(this.#s,e),this.#h(this.#s,e,null,e.height-1),this.#a.pass())}async drawUnseen(e){let t=this.#e;if(this.#s&&this.#m(this.#s,e),t.readBuffer(t.COLOR_ATTACHMENT0),t.readPixels(0,0,1,1,t.RGBA,t.FLOAT,new Float32Array(4)),t.isContextLost())throw new Error("the graphics device was lost")}get milliseconds(){return this.#a.milliseconds}async time(){this.lost===null&&await this.#a.time()}async finished(){this.#e.bindFramebuffer(this.#e.FRAMEBUFFER,null),this.#e.readPixels(0,0,1,1,this.#e.RGBA,this.#e.UNSIGNED_BYTE,new Uint8Array(4))}async fragments(){if(this.#s===null||this.#r===null)return null;let e=this.#e,{leveled:t,pixels:n}=this.#r,[o,r]=ze(this.#s.count),[i,a]=[e.createFramebuffer(),e.createRenderbuffer()];e.bindFramebuffer(e.FRAMEBUFFER,i),e.bindRenderbuffer(e.RENDERBUFFER,a),e.renderbufferStorage(e.RENDERBUFFER,e.RGBA16F,o,r),e.framebufferRenderbuffer(e.FRAMEBUFFER,e.COLOR_ATTACHMENT0,e.RENDERBUFFER,a),e.disable(e.BLEND),e.viewport(0,0,o,r),e.useProgram(this.#x(this.#s,t)),e.drawArrays(e.TRIANGLES,0,3);let c=new Float32Array(4*o*r);e.readPixels(0,0,o,r,e.RGBA,e.FLOAT,c),e.deleteFramebuffer(i),e.deleteRenderbuffer(a);let l=new Array(t?4:1).fill(0);for(let f=0;f<c.length;f+=4)l[c[f+1]]+=c[f]**2/n;return l}get variants(){return(mn(this.#e)?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}describe(){let e=this.#e,t=e.getExtension("WEBGL_debug_renderer_info");return String(e.getParameter(t?t.UNMASKED_RENDERER_WEBGL:e.RENDERER))}async pixels(e){if(this.#s===null)throw new Error("there is no scene to draw");let t=this.#e,{width:n,height:o}=e;this.#m(this.#s,e);let[r,i]=[t.createFramebuffer(),t.createRenderbuffer()];t.bindFramebuffer(t.FRAMEBUFFER,r),t.bindRenderbuffer(t.RENDERBUFFER,i),t.renderbufferStorage(t.RENDERBUFFER,t.RGBA32F,n,o),t.framebufferRenderbuffer(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0,t.RENDERBUFFER,i),this.#h(this.#s,e,r,0);let a=new Float32Array(4*n*o);return t.readPixels(0,0,n,o,t.RGBA,t.FLOAT,a),t.deleteFramebuffer(r),t.deleteRenderbuffer(i),a}destroy(){let e=this.#e,{view:t,corners:n,quads:o,looks:r,sums:i,enlarged:a,programs:c,counters:l,textures:f}=this.#o;this.#s=null,this.#i?.destroy(),e.canvas.removeEventListener("webglcontextlost",this.#l),e.canvas.removeEventListener("webglcontextrestored",this.#f),f.destroy();for(let h of c.values())for(let u of Object.values(h).flat())e.deleteProgram(u);for(let h of l.values())e.deleteProgram(h);for(let h of[r,i,...a])e.deleteFramebuffer(h);e.deleteVertexArray(o);for(let h of[t,n])e.deleteBuffer(h);e.getExtension("WEBGL_lose_context")?.loseContext()}#p({width:e,height:t}){let{canvas:n}=this.#e;n.width!==e&&(n.width=e),n.height!==t&&(n.height=t)}#m(e,t){let n=this.#e,o=t.width*t.height;t=Ue(t,this.supersampling);let{view:r,quads:i,looks:a,sums:c}=this.#o,l=this.#b(e,t),f=this.#u(e,l),[h,u]=this.#g(e.sorted,l,t);n.bindBuffer(n.UNIFORM_BUFFER,r),this.#r={leveled:l,pixels:o};let p=this.variant.floats?1:pt,d=mt(e,t,p,this.levelSigma,this.supersampling);n.bufferSubData(n.UNIFORM_BUFFER,0,d),n.bindVertexArray(i),n.disable(n.BLEND),n.bindFramebuffer(n.FRAMEBUFFER,a),n.drawBuffers([n.COLOR_ATTACHMENT0,e.packing?n.NONE:n.COLOR_ATTACHMENT1]);let[m,g]=ze(e.count);if(n.viewport(0,0,m,g),n.useProgram(f.project),this.#a.pass("project"),n.drawArrays(n.TRIANGLES,0,3),n.bindFramebuffer(n.FRAMEBUFFER,c),n.viewport(0,0,h,u),n.enable(n.BLEND),n.useProgram(f.splat),this.#a.pass("splat"),e.sorted?(n.drawBuffers([n.COLOR_ATTACHMENT0]),n.clearBufferfv(n.COLOR,0,[0,0,0,0]),n.blendFunc(n.ONE,n.ONE_MINUS_SRC_ALPHA)):(n.drawBuffers([n.COLOR_ATTACHMENT0,n.COLOR_ATTACHMENT1]),n.clearBufferfv(n.COLOR,0,[0,0,0,1]),n.clearBufferfv(n.COLOR,1,[0,0,0,0]),n.blendFuncSeparate(n.ONE,n.ONE,n.ZERO,n.ONE_MINUS_SRC_ALPHA)),this.variant.strips)n.drawArraysInstanced(n.TRIANGLE_STRIP,0,4,e.count);else{let v=Math.ceil(e.count/xt);n.drawElementsInstanced(n.TRIANGLES,6*xt,n.UNSIGNED_SHORT,0,v)}}#h(e,t,n,o){let r=this.#e,i=Ue(t,this.supersampling),{resolve:a,enlarge:c}=this.#u(e,this.#b(e,i));r.disable(r.BLEND),this.#a.pass("resolve"),c.length&&this.#w(c,i),r.bindFramebuffer(r.FRAMEBUFFER,n),r.viewport(0,0,t.width,t.height),r.useProgram(a),r.uniform1i(r.getUniformLocation(a,"last_row"),o),r.drawArrays(r.TRIANGLES,0,3)}#w(e,{width:t,height:n}){let o=this.#e,r=ne(t,n);for(let i of[2,1])o.bindFramebuffer(o.FRAMEBUFFER,this.#o.enlarged[i-1]),o.viewport(0,0,r[i][0],r[i][1]),o.useProgram(e[i-1]),o.drawArrays(o.TRIANGLES,0,3)}#b({sorted:e},{width:t,height:n}){let o=this.#e.getParameter(this.#e.MAX_TEXTURE_SIZE);return this.levelSigma>0&&!e&&Math.max(...se(t,n).size)<=o}#g(e,t,{width:n,height:o}){let{floats:r}=this.variant,i=t?se(n,o).size:[n,o],a=`${n} ${o} ${e} ${t} ${r}`;if(a===this.#c)return i;let c=this.#e,l=c.getParameter(c.MAX_TEXTURE_SIZE);if(!(n>0&&n<=l&&o>0&&o<=l))throw new Error(`an image of ${n}x${o} pixels cannot be rendered: each side must lie between 1 and ${l}`);let f=r?[c.RGBA32F,c.R32F]:[c.RGBA16F,c.R16F],{sums:h,enlarged:u,textures:p}=this.#o,d=ne(n,o);return[h,...u].forEach((m,g)=>{let v=g?`_${g}`:"";c.bindFramebuffer(c.FRAMEBUFFER,m),["color_sums","weight_sums"].forEach((E,w)=>{let _=(g===0||t)&&!(e&&w>0),k=g===0?i:d[g],S=_?p.make(`${E}${v}`,f[w],k):null;c.framebufferTexture2D(c.FRAMEBUFFER,c.COLOR_ATTACHMENT0+w,c.TEXTURE_2D,S,0)}),g&&t&&c.drawBuffers([c.COLOR_ATTACHMENT0,c.COLOR_ATTACHMENT1]),(g===0||t)&&this.#E(`pictures of ${n}x${o} floats`)}),this.#c=a,i}#v({sorted:e,packing:t},n){return{sorted:e,packed:t!==null,strips:this.variant.strips,leveled:n}}#u(e,t){let{programs:n}=this.#o,o=this.#v(e,t),r=Object.values(o).join(" "),i=n.get(r)??yo(this.#e,this.#t,o);return n.set(r,i),i}#x(e,t){let{counters:n}=this.#o,o={...this.#v(e,t),strips:!1},r=Object.values(o).join(" "),i=n.get(r)??xo(this.#e,this.#t,o);return n.set(r,i),i}#E(e){let t=this.#e;if(t.checkFramebufferStatus(t.FRAMEBUFFER)!==t.FRAMEBUFFER_COMPLETE&&!t.isContextLost())throw new Error(`this GPU cannot draw into ${e}`)}};var _t=class{#e;#t;#o;#s;#n;#i;constructor(e,t,n){let{device:o}=e;this.#e=o,this.#t=t,this.#o=e.dots(n);let{UNIFORM:r,VERTEX:i,COPY_DST:a}=GPUBufferUsage;this.#s=o.createBuffer({size:80,usage:r|a});let c=bt(t);this.#i=c.length/3,this.#n=e.filled(c,i)}draw(e,t){let[n,o,r]=[this.#e,this.#o,this.#t];n.queue.writeBuffer(this.#s,0,wt(r,e));let i=n.createCommandEncoder(),a=i.beginRenderPass({colorAttachments:[{view:t,loadOp:"clear",storeOp:"store",clearValue:[...r.background,1]}]}),c=[{binding:0,resource:{buffer:this.#s}}];a.setPipeline(o),a.setBindGroup(0,n.createBindGroup({layout:o.getBindGroupLayout(0),entries:c})),a.setVertexBuffer(0,this.#n),a.draw(this.#i),a.end(),n.queue.submit([i.finish()])}destroy(){this.#s.destroy(),this.#n.destroy()}};var oe=128,Mo={srcFactor:"one",dstFactor:"one-minus-src-alpha",operation:"add"},da={color:Mo,alpha:Mo},pa={color:{srcFactor:"one",dstFactor:"one",operation:"add"},alpha:{srcFactor:"zero",dstFactor:"one-minus-src-alpha",operation:"add"}},To=["float32-blendable","float32-filterable"],Ie=["network","project","splat","resolve"],kt=class s{milliseconds=null;#e;#t=new Map;#o=new Map;#s=null;static async create(e,t){if(!("gpu"in navigator))throw new Error("this browser has no WebGPU on this page: it may need https, or a newer version");let n=await vs();if(n===null)throw new Error("WebGPU finds no graphics adapter on this device");let r=["timestamp-query","float32-blendable","float32-filterable","shader-f16"].filter(l=>n.features.has(l));if(t&&!To.every(l=>r.includes(l)))throw new Error("this device cannot blend and filter 32-bit floats");let{maxStorageBufferBindingSize:i,maxBufferSize:a}=n.limits,c=await n.requestDevice({requiredFeatures:r,requiredLimits:{maxStorageBufferBindingSize:i,maxBufferSize:a}});return new s(c,e)}constructor(e,t){if(this.device=e,this.#e=t,this.bilinear=e.createSampler({magFilter:"linear",minFilter:"linear"}),e.features.has("timestamp-query")){let n=16*Ie.length,o=GPUBufferUsage;this.#s={queries:e.createQuerySet({type:"timestamp",count:2*Ie.length}),found:e.createBuffer({size:n,usage:o.QUERY_RESOLVE|o.COPY_SRC}),read:e.createBuffer({size:n,usage:o.MAP_READ|o.COPY_DST})}}}get blendsFloats(){return To.every(e=>this.device.features.has(e))}get number(){return this.device.features.has("shader-f16")?"f16":"f32"}network(e){return this.#n(`network ${e.packed}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#i("network",e),entryPoint:"evaluate_network"}}))}project(e,{strips:t}){return this.#n(`project ${e.packed} ${e.sorted} ${t}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#i("project",e),entryPoint:e.sorted?"project_sorted":"project_sortfree",constants:{STRIPS:Number(t)}}}))}count(e){return this.#n(`count ${e.packed} ${e.sorted}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#i("count",e),entryPoint:"count_fragments",constants:{SORTED:Number(e.sorted)}}}))}splat(e,{floats:t,strips:n},o){return this.#n(`splat ${e.packed} ${e.sorted} ${n} ${t} ${o}`,()=>{let r=e.sorted?da:pa,i=this.#i("splat",e);return this.device.createRenderPipeline({layout:"auto",vertex:{module:i,entryPoint:e.sorted?"corner_sorted":o?"corner_of_level":"corner_sortfree",constants:{STRIPS:Number(n)}},primitive:{topology:n?"triangle-strip":"triangle-list"},fragment:{module:i,entryPoint:e.sorted?"cover":o?"add_to_level":"add_weighted",targets:At(e.sorted,t).map(a=>({format:a,blend:r}))}})})}enlarge(e,t){return this.#n(`enlarge ${e} ${t}`,()=>{let n=this.#i("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:n,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:n,entryPoint:"add_enlarged",constants:{LEVEL:e},targets:At(!1,t).map(o=>({format:o}))}})})}resolve(e,t,n){return this.#n(`resolve ${e} ${n} ${t}`,()=>{let o=this.#i("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:o,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:o,entryPoint:e?"resolve_sorted":n?"resolve_levels":"resolve_sortfree",targets:[{format:t}]}})})}dots(e){return this.#n(`dots ${e}`,()=>{let t=this.device.createShaderModule({code:this.#e.dots,label:"dots"}),n=[{shaderLocation:0,offset:0,format:"float32x3"}];return this.device.createRenderPipeline({layout:"auto",vertex:{module:t,entryPoint:"corner_of_dot",buffers:[{arrayStride:12,attributes:n}]},fragment:{module:t,entryPoint:"paint_dot",targets:[{format:e}]}})})}filled(e,t){let n=Math.ceil(e.byteLength/4)*4,o=this.device.createBuffer({size:n,usage:t,mappedAtCreation:!0}),r=new Uint8Array(e.buffer,e.byteOffset,e.byteLength);return new Uint8Array(o.getMappedRange()).set(r),o.unmap(),o}bind(e,t){return this.device.createBindGroup({layout:e.getBindGroupLayout(0),entries:Object.entries(t).map(([n,o])=>({binding:Number(n),resource:o instanceof GPUBuffer?{buffer:o}:o}))})}stamps(e,t=!0,n=!0){if(this.#s===null||!(t||n))return;let o=2*Ie.indexOf(e);return{querySet:this.#s.queries,...t?{beginningOfPassWriteIndex:o}:{},...n?{endOfPassWriteIndex:o+1}:{}}}async time({network:e}){if(this.#s===null||this.#s.read.mapState!=="unmapped")return;let{queries:t,found:n,read:o}=this.#s,r=this.device.createCommandEncoder();r.resolveQuerySet(t,0,2*Ie.length,n,0),r.copyBufferToBuffer(n,0,o,0,o.size),this.device.queue.submit([r.finish()]),await o.mapAsync(GPUMapMode.READ);let i=new BigUint64Array(o.getMappedRange()),a=Ie.map((c,l)=>[c,Number(i[2*l+1]-i[2*l])/1e6]);this.milliseconds=Object.fromEntries(e?a:a.slice(1)),o.unmap()}#n(e,t){let n=this.#o.get(e)??t();return this.#o.set(e,n),n}#i(e,t){let n=t===null?"":this.#e[t.packed?"packed":"wide"],o=`${e} ${t?.packed}`,r=this.number==="f16"?`enable f16;
`:"",a=`${e==="network"?`${r}alias Num = ${this.number};
`:""}${this.#e.view}
${n}
${this.#e[e]}`,c=this.#t.get(o)??this.device.createShaderModule({code:a,label:e});return this.#t.set(o,c),c}};function vn(s,e){return Object.fromEntries(s.map((t,n)=>[e+n,t]))}function At(s,e){return e?s?["rgba32float"]:["rgba32float","r32float"]:s?["rgba16float"]:["rgba16float","r16float"]}var ga=6,wa={packed:8,wide:32},yn=new Float32Array(0),Ce=class s{static files=["view","wide","packed","network","project","splat","resolve","count","dots"].map(e=>`${e}.wgsl`);variant;levelSigma=0;supersampling=1;lost=null;onLost=()=>{};#e;#t;#o;#s;#n;#i=null;#r=null;#c=null;#a=null;#l;#f;#p=null;#m;static async create(e,t,{floats:n=!1,strips:o=!1}={}){let r=await kt.create(t,n);return new s(r,e,{floats:n,strips:o})}constructor(e,t,n){let o=t.getContext("webgpu");if(o===null)throw new Error("this canvas is already drawn to in another way");let{device:r}=e;this.variant=n,this.#e=e,this.#t=r,this.#s=t,this.#o=o,this.#n=navigator.gpu.getPreferredCanvasFormat(),o.configure({device:r,format:this.#n,alphaMode:"opaque"});let i=GPUBufferUsage;this.#l=r.createBuffer({size:Fe,usage:i.UNIFORM|i.COPY_DST});let a=i.STORAGE|i.INDIRECT|i.COPY_DST;this.#f=r.createBuffer({size:4*ga,usage:a});let c=new Uint16Array(6*oe);for(let l=0;l<oe;l++)c.set([0,1,2,2,1,3].map(f=>4*l+f),6*l);this.#m=e.filled(c,i.INDEX),r.lost.then(({reason:l})=>{l!=="destroyed"&&this.#h("the graphics device was lost: reload the page to go on")}),r.onuncapturederror=({error:l})=>this.#h(`this GPU cannot draw the scene: ${l.message}`)}get variants(){return(this.#e.blendsFloats?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}get milliseconds(){return this.#e.milliseconds}setScene(e){this.#w();let{count:t,sorted:n}=e,o={sorted:n,packed:e.packing!==null,network:!!e.network},r=wa[o.packed?"packed":"wide"]*Math.max(t,1),i={shapes:e.shapes,colors:e.colors,lobes:e.lobes},a=Math.max(r,...Object.values(i).map(d=>d.byteLength)),{maxStorageBufferBindingSize:c,maxBufferSize:l}=this.#t.limits,f=Math.min(c,l);if(a>f)throw new Error(`${t} Gaussians need ${Math.ceil(a/2**20)} MiB at a stretch, and this device gives ${Math.floor(f/2**20)}`);let h=GPUBufferUsage,u=d=>this.#e.filled(d.length?d:new Uint32Array(16),h.STORAGE|h.COPY_DST),p=d=>this.#t.createBuffer({size:4*Math.max(1,d),usage:h.STORAGE|h.COPY_DST});this.#r={kind:o,parts:{shapes:u(i.shapes),colors:u(i.colors),lobes:u(i.lobes)},looks:this.#t.createBuffer({size:r,usage:h.STORAGE}),order:p(t),network:e.network?{weights:this.#e.filled(this.#x(e.network),h.STORAGE),lobes:p(t)}:null},this.#i={...e,shapes:yn,colors:yn,lobes:yn},n&&this.setOrder(Uint32Array.from({length:t},(d,m)=>m))}show(e){this.#i&&(this.#i.count=e)}update(e,t,n){if(!this.#i||!this.#r||this.lost!==null)return;let o=4*ve(this.#i)[e]*t;this.#t.queue.writeBuffer(this.#r.parts[e],o,n)}setDots(e){this.#c?.destroy(),this.#c=e&&new _t(this.#e,e,this.#n)}drawDots(e){this.lost===null&&this.#c?.draw(e,this.#g(e))}setOrder(e){this.#r?.kind.sorted&&this.#t.queue.writeBuffer(this.#r.order,0,e)}draw(e){this.lost===null&&this.#u(e,this.#g(e),this.#n)}async pixels(e){let{width:t,height:n}=e,o=Math.ceil(16*t/256)*256,r=this.#v(t,n,"rgba32float");this.#u(e,r.createView(),"rgba32float");let i=this.#t.createBuffer({size:o*n,usage:GPUBufferUsage.MAP_READ|GPUBufferUsage.COPY_DST}),a=this.#t.createCommandEncoder();a.copyTextureToBuffer({texture:r},{buffer:i,bytesPerRow:o},[t,n]),this.#t.queue.submit([a.finish()]),await i.mapAsync(GPUMapMode.READ);let c=new Float32Array(i.getMappedRange()),l=new Float32Array(4*t*n);for(let f=0;f<n;f++){let h=f*o/4;l.set(c.subarray(h,h+4*t),4*t*f)}return i.destroy(),r.destroy(),l}async drawUnseen(e){let t=this.#v(e.width,e.height,this.#n);if(this.#u(e,t.createView(),this.#n),await this.finished(),t.destroy(),this.lost!==null)throw new Error(this.lost)}async finished(){await this.#t.queue.onSubmittedWorkDone()}describe(){let e=this.#t.adapterInfo;return[e?.vendor,e?.architecture,e?.device,e?.description].filter(Boolean).join(" ")}async time(){this.lost===null&&this.#r&&await this.#e.time(this.#r.kind)}async fragments(){let[e,t,n]=[this.#r,this.#i,this.#p];if(!e||!t||!n||this.lost!==null)return null;let o=GPUBufferUsage,r=this.#e.filled(new Uint32Array(4),o.STORAGE|o.COPY_SRC),i=this.#t.createBuffer({size:r.size,usage:o.MAP_READ|o.COPY_DST}),{kind:a,parts:c,looks:l,order:f}=e,h=this.#t.createCommandEncoder(),u={0:this.#l,1:c.shapes,4:l,5:f,6:this.#f,7:r};this.#y(h,null,this.#e.count(a),u,Math.ceil(t.count/oe)),h.copyBufferToBuffer(r,0,i,0,r.size),this.#t.queue.submit([h.finish()]),await i.mapAsync(GPUMapMode.READ);let p=Array.from(new Uint32Array(i.getMappedRange()),d=>d/8/n.pixels);for(let d of[r,i])d.destroy();return n.leveled?p:p.slice(0,1)}destroy(){this.#w(),this.setDots(null),this.#t.onuncapturederror=null,this.#t.destroy()}#h(e){this.lost===null&&(this.lost=e,this.onLost(e))}#w(){for(let e of this.#b())e.destroy();this.#r=this.#i=this.#p=null}#b(){if(this.#r===null)return[];let{parts:e,looks:t,order:n,network:o}=this.#r;return[...Object.values(e),t,n,...Object.values(o??{})]}#g({width:e,height:t}){return this.#s.width!==e&&(this.#s.width=e),this.#s.height!==t&&(this.#s.height=t),this.#o.getCurrentTexture().createView()}#v(e,t,n){let o=GPUTextureUsage;return this.#t.createTexture({size:[e,t],format:n,usage:o.RENDER_ATTACHMENT|o.COPY_SRC})}#u(e,t,n){let o=this.#i;if(!o||!this.#r)return;let r=Ue(e,this.supersampling),{queue:i}=this.#t,{floats:a,strips:c}=this.variant,l=this.#t.limits.maxTextureDimension2D,h=Math.max(...se(r.width,r.height).size)<=l&&!o.sorted&&this.levelSigma>0,u=h?this.levelSigma:0,p=mt(o,r,a?1:pt,u,this.supersampling);i.writeBuffer(this.#l,0,p),i.writeBuffer(this.#f,0,Uint32Array.of(c?4:6*oe,0,0,0,0,0));let d=this.#S(r.width,r.height,o.sorted,h);this.#p={leveled:h,pixels:e.width*e.height};let m=this.#t.createCommandEncoder();this.#E(m,o.count,this.#r),this.#k(m,o.count,this.#r),this.#_(m,o.count,this.#r,d[0],h),h&&(this.#A(m,this.#e.enlarge(2,a),[...d[0],...d[0]],d[2],!0,!1),this.#A(m,this.#e.enlarge(1,a),[...d[0],...d[2]],d[1],!1,!1));let g=d.slice(0,2).flat();this.#A(m,this.#e.resolve(o.sorted,n,h),g,[t],!h,!0),i.submit([m.finish()])}#x(e){return this.#e.number==="f16"?Uint16Array.from(e,X):e}#E(e,t,{kind:n,parts:o,network:r}){if(r===null)return;let i={0:this.#l,1:o.shapes,4:o.lobes,5:r.weights,6:r.lobes};this.#y(e,"network",this.#e.network(n),i,Math.ceil(t/32))}#k(e,t,{kind:n,parts:o,looks:r,order:i,network:a}){let c=a?.lobes??o.lobes,l=[this.#l,o.shapes,o.colors,c,r];n.sorted||l.push(i,this.#f);let f=this.#e.project(n,this.variant);this.#y(e,"project",f,vn(l,0),Math.ceil(t/oe))}#y(e,t,n,o,r){let i=Math.max(1,Math.min(r,65535)),a=e.beginComputePass(t?{timestampWrites:this.#e.stamps(t)}:{});a.setPipeline(n),a.setBindGroup(0,this.#e.bind(n,o)),a.dispatchWorkgroups(i,Math.ceil(r/i)),a.end()}#_(e,t,{kind:n,parts:o,looks:r,order:i},a,c){let l=[{r:0,g:0,b:0,a:n.sorted?0:1},{r:0,g:0,b:0,a:0}],f=this.#e.splat(n,this.variant,c),h=e.beginRenderPass({colorAttachments:a.map((p,d)=>({view:p,loadOp:"clear",storeOp:"store",clearValue:l[d]})),timestampWrites:this.#e.stamps("splat")});h.setPipeline(f);let u={0:this.#l,1:o.shapes,4:r,5:i};h.setBindGroup(0,this.#e.bind(f,n.sorted?u:{...u,6:this.#f})),h.setIndexBuffer(this.#m,"uint16"),this.variant.strips?n.sorted?h.draw(4,t):h.drawIndirect(this.#f,0):n.sorted?h.drawIndexed(6*oe,Math.ceil(t/oe)):h.drawIndexedIndirect(this.#f,0),h.end()}#A(e,t,n,o,r,i){let a=e.beginRenderPass({colorAttachments:o.map(l=>({view:l,loadOp:"clear",storeOp:"store"})),timestampWrites:this.#e.stamps("resolve",r,i)});a.setPipeline(t);let c={0:this.#l,...vn(n,1)};n.length===4&&(c[5]=this.#e.bilinear),a.setBindGroup(0,this.#e.bind(t,c)),a.draw(3),a.end()}#S(e,t,n,o){let r=`${e} ${t} ${n} ${o} ${this.variant.floats}`;if(this.#a?.key===r)return this.#a.views;for(let f of this.#a?.textures??[])f.destroy();let i=GPUTextureUsage,a=[],l=(o?[se(e,t).size,...ne(e,t).slice(1,3)]:[[e,t]]).map(f=>At(n,this.variant.floats).map(h=>{let u=i.RENDER_ATTACHMENT|i.TEXTURE_BINDING,p=this.#t.createTexture({size:f,format:h,usage:u});return a.push(p),p.createView()}));return this.#a={key:r,textures:a,views:l},l}};async function St(s,e){let t="";if(e!=="webgl")try{let n=await Ro(Ce.files);return{name:"WebGPU",renderer:await Ce.create(s,n)}}catch(n){if(e==="webgpu")throw n;t=n instanceof Error?n.message:String(n)}try{return{name:"WebGL2",renderer:Ne.create(s,await Ro(Ne.files))}}catch(n){let o=n instanceof Error?n.message:String(n);throw new Error(`this browser cannot draw the scene: ${t?`${t}; `:""}${o}`)}}async function Ro(s){let e=s.map(async t=>[t.replace(/\.[a-z]+$/,""),await ys(t)]);return Object.fromEntries(await Promise.all(e))}var Lo=new Map;function Oo(s){let e=Lo.get(s)??ba(s);return Lo.set(s,e),e}async function ba(s){let{renderer:e}=await St(document.createElement("canvas"),s);try{return await ho(e,xn())}finally{e.destroy()}}function xn(){try{return localStorage}catch{return null}}var va=Math.cos(.5*Math.PI/180),Mt=class{by="";#e=!1;#t=null;reset(e){this.by=e,this.#e=!1}invalidate(){this.#t=null}get pending(){return this.#e}received(){this.#e=!1}neededDirection({viewmat:e}){let t=[e[8],e[9],e[10]],n=this.#t!==null&&L(t,this.#t)>=va;return!this.by||this.#e||n?null:(this.#e=this.by==="worker",this.#t=t)}};var Fo=12;function Uo(s,e,t,n,o){let{viewmat:r,fx:i,fy:a,cx:c,cy:l,near:f}=t,h=-1,u=1/0;for(let p=0;3*p<s.length;p++){if(e[p]<0)continue;let[d,m,g]=[s[3*p],s[3*p+1],s[3*p+2]],v=r[8]*d+r[9]*m+r[10]*g+r[11];if(v<=f||v>=u)continue;let E=i*(r[0]*d+r[1]*m+r[2]*g+r[3])/v+c-n,w=a*(r[4]*d+r[5]*m+r[6]*g+r[7])/v+l-o;E*E+w*w>Fo*Fo||(u=v,h=p)}return h<0?null:[s[3*h],s[3*h+1],s[3*h+2]]}function En(s,e,t,n){let o=n instanceof Uint32Array;for(let r=0;r*e<n.length;r++)s[t+r]=o?wo(n[r*e]):n[r*e]}var ya=1e3,xa=50,Tt=class{count=0;views=[];near=.2;up=null;logits=new Float32Array(0);request=null;fragments=null;calibrated=Promise.resolve();name="";broken=!1;#e=new Float32Array(0);#t;#o;#s=!1;#n;#i;#r=null;#c=null;#a=null;#l=null;#f=Promise.resolve(!1);#p=!1;#m=null;#h=!1;#w=2;#b=[0,0,0];#g=null;#v=[0,0,0];#u=new Mt;#x=null;#E=-1/0;#k=!1;#y=!1;#_=!1;constructor(e,t,n,o,r=null){this.canvas=e,this.#i=t,this.#t=n,this.#o=r,this.#n=o}begin(e){return this.#f=this.#A(e)}async#A(e){try{let{name:t,renderer:n}=await St(this.canvas,e);if(this.#p)return n.destroy(),!1;n.onLost=i=>this.#T(i),"onRestored"in n&&(n.onRestored=()=>this.request&&this.load(this.request));let r=n.variants.find(({floats:i,strips:a})=>i===this.#t?.floats&&a===this.#t.strips)??fo(n,xn());return r&&(n.variant=r),n.levelSigma=this.#o??1,this.#s=r!==null,this.#r=n,this.name=t,po(n),!0}catch(t){return this.#i.failed(_n(t)),!1}}async#S(){if(this.#s||this.broken)return;this.#s=!0;let e=this.name==="WebGPU"?"webgpu":"webgl",t=await Oo(e);this.#r&&(this.#r.variant=t),this.#i.changed()}load(e,t=!1){this.#a?.terminate(),this.request=e;let n=bs(e,async({data:o})=>{if(!await this.#f){n.terminate();return}(n===this.#a||n===this.#c)&&this.#N(o,n)});n.onerror=o=>{o.preventDefault(),!t&&n===this.#a?this.load(e,!0):this.#L("the viewer's own files could not be loaded: reload the page",n)},this.#a=this.#l=n}async sort(e){if(this.#u.by==="")return null;if(this.broken)throw new Error("the renderer was lost");this.#u.pending&&await this.#M();let t=performance.now();return this.#u.invalidate(),this.#U(e),this.#u.pending&&await this.#M(),performance.now()-t}#M(){return new Promise((e,t)=>this.#x={resolve:e,reject:t})}#d(e){this.#x?.reject(new Error(e)),this.#x=null}draw(e,t=1){if(this.#c===null)return;let n={...e,near:this.near};if(this.#y){this.#r?.drawDots(n),this.#z();return}this.#U(e),this.#r&&(this.#r.supersampling=t,this.#r.draw(n),this.#r.supersampling=1)}async#z(){let e=this.#r;this.#_||this.#n||!e||(this.#_=!0,await new Promise(t=>setTimeout(t,xa)),this.#y&&!this.#p&&await uo(e).catch(()=>{}))}drawOrReport(e,t){if(!this.broken)try{this.draw(e,t)}catch(n){this.#T(_n(n))}}async finished(){await this.#r?.finished()}pixels(e){return(this.#c&&!this.#y?this.#r?.pixels(e):null)??Promise.reject(new Error("nothing can be drawn"))}get background(){return this.#g??this.#b}set background(e){this.#g=e,this.background.forEach((t,n)=>this.#v[n]=t)}get means(){return this.#e=He(this.#e)}get milliseconds(){return this.#r?.milliseconds??null}async time(){this.#k||!this.#r||(this.#k=!0,await this.#r.time().catch(()=>{}),performance.now()>this.#E+ya&&(this.fragments=await this.countFragments(),this.#E=performance.now()),this.#k=!1)}async countFragments(){return this.#y||this.broken?null:await this.#r?.fragments().catch(()=>null)??null}get device(){let{floats:e,strips:t}=this.#r?.variant??{floats:!1,strips:!1},n=`${e?"floats":"halves"}, ${t?"strips":"batches"}`,{by:o}=this.#u,r=this.#r?.describe()??"";return{renderer:this.name,adapter:r,variant:n,sorted:o!=="",sorted_by:o||null}}destroy(){this.#p=this.broken=!0,this.#d("the renderer was lost"),this.#a?.terminate(),this.#c?.terminate(),this.#r?.destroy(),this.#r=null}#T(e){this.broken=!0,this.#d(e),this.#i.broken(e)}#N(e,t){this.broken&&t===this.#c||(e.kind==="failed"?this.#L(e.sentence,t):e.kind==="progress"?t===this.#l&&this.#i.progress(e.received/e.total):e.kind==="dots"?this.#I(e,t):e.kind==="scene"?this.#C(e,t):e.kind==="rows"?this.#D(e):e.kind==="more"?this.#R(e.means):e.kind==="order"?this.#P(e.order):(this.#u.by!=="worker"&&t.terminate(),this.#a||(this.calibrated=this.#S().catch(()=>{})),t===this.#l&&this.#i.loaded(e.milliseconds,e.bytes)))}#L(e,t){let n=t===this.#a&&this.#m!==null;t===this.#c&&this.#d(e),t===this.#a&&(this.#a=null,this.request=this.#m),(t!==this.#c||this.#u.by!=="worker")&&t.terminate(),t===this.#l&&this.#i.failed(e,n)}#I({dots:e,...t},n){this.#u.reset(""),this.#O(n,e.background,()=>this.#r?.setDots(e))&&(this.#y=!0,this.#F(t),this.logits=new Float32Array(e.means.length/3),this.#R(e.means),this.#h||this.#i.arrived())}#C({data:e,means:t,...n},o){let r=o===this.#c;this.#u.reset(e.sorted?"worker":this.#n?"page":""),e.sorted=this.#u.by!=="",this.#O(o,e.background,()=>{this.#r&&(this.#r.setDots(null),this.#r.setScene(e),this.#r.levelSigma=this.#o??go(e.footprint))})&&(this.#y=!1,this.#F(n),this.logits=new Float32Array(e.count),this.#w=ve(e).lobes,En(this.logits,this.#w,0,e.lobes),this.#R(t),!r&&!this.#h&&this.#i.arrived())}#O(e,t,n){if(e!==this.#c&&(this.#c?.terminate(),this.#d("another scene was opened")),this.#c=e,e===this.#a&&(this.#h=this.request===this.#m&&this.count>0,this.#m=this.request,this.#a=null),this.#b=[...t],this.#v=t,this.background=this.#g,this.#r?.lost)return this.#T(this.#r.lost),!1;try{n()}catch(o){return e.terminate(),this.count=0,this.#i.failed(_n(o)),!1}return this.broken=!1,!0}#F({views:e,near:t,up:n}){this.views=e,this.near=t,this.up=n}#R(e){this.#e=e,this.count=("stored"in e?e.stored:e).length/3,this.#r?.show(this.count),this.#u.invalidate(),this.#i.changed()}#D({part:e,from:t,numbers:n}){this.#r?.update(e,t,n),e==="lobes"&&En(this.logits,this.#w,t,n),this.#i.changed()}#P(e){this.#u.received(),this.#r?.setOrder(e),this.#x?.resolve(),this.#x=null,this.#i.ordered()}#U(e){let t=this.#u.neededDirection(e);t!==null&&(this.#u.by==="page"?this.#r?.setOrder(at(this.means,t)):this.#c?.postMessage({forward:t}))}},_n=s=>s instanceof Error?s.message:String(s);var zo=.02,No=.001,N=class s{constructor(e,t,n){this.eye=e,this.target=t,this.up=W(n),this.reach=ee(R(t,e))||1}static fromViews(e,t=0,n=null){let o=e.map(Ea),{eye:r,forward:i}=o[t],a=L(R(_a(o),r),i),c=Math.max(...o.map(l=>ee(R(l.eye,r))),0)||1;return new s(r,M(r,i,a>No*c?a:c),n??Rs(o))}static around(e,t=te){let n=[0,1,2].map(i=>{let a=e.filter((l,f)=>f%3===i).sort(),c=l=>a[Math.floor(l*(a.length-1))]??0;return[c(.15),c(.5),c(.85)]}),o=n.map(([,i])=>i),r=Math.max(...n.map(([i,,a])=>a-i))||1;return new s(M(o,Ls([0,-.3,-1],t),1.5*r),o,t)}get forward(){return W(R(this.target,this.eye))}get right(){return W(z(this.forward,this.up))}copy(){let e=new s(this.eye,this.target,this.up);return e.reach=this.reach,e}orbit(e,t){let n=this.#e(R(this.eye,this.target),e,t);this.eye=M(this.target,n)}look(e,t){let n=this.#e(R(this.eye,this.target),e,t);this.target=R(this.eye,n)}move(e,t,n){let o=z(this.forward,this.right),r=M([0,0,0],this.right,e);r=M(M(r,o,t),this.forward,n),this.eye=M(this.eye,r),this.target=M(this.target,r)}dolly(e){let t=R(this.eye,this.target),n=Math.max(ee(t)*e,No*this.reach);this.eye=M(this.target,W(t),n)}focus(e){ee(R(e,this.eye))>0&&(this.target=e)}viewmat(){let{forward:e,right:t,eye:n}=this,o=z(e,t),r=i=>[...i,-L(i,n)];return[...r(t),...r(o),...r(e),0,0,0,1]}#e(e,t,n){let o=Math.acos(Math.min(1,Math.max(-1,L(W(e),this.up)))),r=Math.min(Math.max(o-n,zo),Math.PI-zo)-o;return en(en(e,this.right,r),this.up,-t)}};function Io(s,e,t,n,o,r=null){let i=Math.tan((r??50)*Math.PI/360),a=r===null?e:null,c=a?t*a.K[0]/a.width:t/(2*i),l=a?n*a.K[4]/a.height:n/(2*i),f=Math.sqrt(c*l),h={cx:t/2,cy:n/2};return{viewmat:s.viewmat(),fx:f,fy:f,...h,width:t,height:n,near:o}}function Ea({viewmat:s}){let e=i=>[s[4*i],s[4*i+1],s[4*i+2]],[t,n,o]=[e(0),e(1),e(2)],r=M([0,0,0],t,-s[3]);return r=M(M(r,n,-s[7]),o,-s[11]),{eye:r,right:t,forward:o,down:n}}function _a(s){let e=[.001,0,0,0,.001,0,0,0,.001],t=[0,0,0];for(let{eye:c,forward:l}of s){for(let f=0;f<3;f++)for(let h=0;h<3;h++)e[3*f+h]+=(f===h?1:0)-l[f]*l[h];t=M(M(t,c,1+.001/s.length),l,-L(l,c))}let n=c=>[e[c],e[3+c],e[6+c]],[o,r,i]=[n(0),n(1),n(2)],a=L(o,z(r,i));return[L(t,z(r,i))/a,L(o,z(t,i))/a,L(o,z(r,t))/a]}var ka=16.666666666666668,Aa=1e3/50,Sa=1e3/45,Co=1e3/26,Ma=3,Ta=200,Ra=.9,Do=[4,64],La=[1,.85,.7,.6,.5],De=class{#e=0;#t=[];#o;#s=Sa;#n={step:0,median:1/0};#i=0;#r=Do[0];constructor(e){this.fixed=e,this.#o=e===null?La:[e]}get scale(){return this.#o[this.#e]}reduced(e){return(e?this.scale:this.#o[0])<1}size(e,t,n,o){let r=Math.min(n,2)*(o?this.scale:this.#o[0]),i=a=>Math.max(1,Math.round(a*r));return{width:i(e),height:i(t)}}note(e){this.#t.push(e);let{length:t}=this.#t;if(t<Ma||this.#t.reduce((o,r)=>o+r)<Ta)return;let n=this.#t.sort((o,r)=>o-r)[t>>1];this.#t=[],n>this.#s?this.#c(n):n>=Aa||this.#e===0?this.#i=0:++this.#i>=this.#r&&(this.#e-=1,this.#i=0)}#c(e){let{step:t,median:n}=this.#n;if(this.#i=0,this.#r=Math.min(2*this.#r,Do[1]),t<this.#e&&e<Co&&e>Ra*n){this.#e=t,this.#s=Co;return}this.#n={step:this.#e,median:e};let o=this.scale*Math.sqrt(ka/e),r=this.#o.findIndex(i=>i<this.scale&&i<=o);this.#e=r<0?this.#o.length-1:r}};function Po({fx:s,fy:e,width:t,height:n},o){if(o.length===0)return 1;let r=Math.sqrt(o[0].K[0]*o[0].K[4]),i=Math.min(4,Math.floor(4096/Math.max(t,n)));return Math.max(1,Math.min(Math.floor(r/Math.sqrt(s*e)+.5),i))}var Oa=100,Bo=150,Fa=9*Math.PI/180,Rt=class{mode="orbit";pose=new N([0,0,-3],[0,0,0],[0,-1,0]);fov=null;timed=!1;turning=!1;measured=!1;#e;#t;#o;#s;#n;#i=null;#r="auto";#c=null;#a=null;#l;#f;#p=this.pose;#m=!1;#h=0;#w=0;#b=-1/0;#g=!1;#v=0;#u=0;#x;constructor(e,t,{variant:n=null,levels:o=null}={}){this.#t=e,this.#e=t,this.#o=n,this.#s=o,this.#l=new De(null),this.#n=this.#k(e,0,!1),this.#f=new dt(e,{pose:()=>this.pose,mode:()=>this.mode,held:()=>this.turning=!1,changed:()=>{this.#b=performance.now(),this.turning=!1,this.redraw()},focus:(r,i)=>this.#d(r,i)}),this.#x=new ResizeObserver(()=>this.redraw()),this.#x.observe(e)}begin(e){return this.#r=e,this.#n.begin(e)}load(e){this.#n.request&&(this.#m=!1,this.#a=null),this.#n.load(e)}async compare(e,t,n){this.endComparison();let o=this.#k(e,1,n);o.background=this.#c,this.#i=o,await this.#n.calibrated,o===this.#i&&await o.begin(this.#r)&&o===this.#i&&o.load(t)}endComparison(){this.#i?.destroy(),this.#i=null}redraw(){!this.#h&&!this.measured&&(this.#h=requestAnimationFrame(e=>this.#S(e)))}reset(e){let{views:t}=this;this.pose=e===void 0||t.length===0?this.#p.copy():N.fromViews(t,(e%t.length+t.length)%t.length,this.#A),this.redraw()}get up(){return this.#a}set up(e){let t=e!==null&&Te.has(e)?e:null;t!==this.#a&&(this.#a=t,this.#n.count&&(this.#p=this.#_(),this.reset()))}turnUp(){let{views:e}=this,t=this.#n.up??(e.length?N.fromViews(e).up:te);return this.up=Os(this.#a,t),this.#a??""}place(e){this.pose=e,this.#m=!0,this.redraw()}camera(e,t){return Io(this.pose,this.views[0]??null,e,t,this.#n.near,this.fov)}get views(){return this.#n.views.length?this.#n.views:this.#i?.views??[]}get count(){return this.#n.count}get calibrated(){return this.#n.calibrated}get source(){let{request:e}=this.#n;return e===null||"forward"in e?null:"url"in e?e.url:e.file}get device(){return this.#n.device}get scale(){return this.#l.fixed}set scale(e){this.#l=new De(e),this.redraw()}get choices(){let{mode:e,fov:t,turning:n,scale:o,timed:r,up:i}=this;return{mode:e,fov:t,turning:n,scale:o,timed:r,up:i,background:this.#c}}get background(){return this.#n.background}set background(e){this.#c=e;for(let t of this.#E)t.background=e;this.redraw()}async drawAndWait(e,t){let n=this.camera(e,t),o=await this.#n.sort(n);if(this.#n.draw(n),await this.finished(),this.#n.broken)throw new Error("the renderer was lost");return o}async finished(){await this.#n.finished()}async passes(){return await this.#n.time(),this.#n.milliseconds}fragments(){return this.#n.countFragments()}pixels(e,t=0){return this.#E[t]?.pixels(e)??Promise.reject(new Error("there is no other scene"))}screenshot(e=1){let{width:t,height:n}=this.#M(),o=document.createElement("canvas");[o.width,o.height]=[t,n];let r=o.getContext("2d");return this.#E.forEach(({canvas:i},a)=>{let c=a*Math.round(e*t),l=t-c;l>0&&r?.drawImage(i,c,0,l,n,c,0,l,n)}),new Promise(i=>o.toBlob(i,"image/png"))}destroy(){cancelAnimationFrame(this.#h),clearTimeout(this.#u),clearTimeout(this.#v),this.#f.destroy(),this.#x.disconnect();for(let e of this.#E)e.destroy()}get#E(){return this.#i?[this.#n,this.#i]:[this.#n]}#k(e,t,n){let o={progress:r=>this.#e.progress(t,r),arrived:()=>this.#y(t),changed:()=>{this.#v||=setTimeout(()=>this.redraw(),Oa)},ordered:()=>this.redraw(),loaded:(r,i)=>{this.#e.loaded(t,r,i),this.redraw()},failed:(r,i)=>this.#e.failed(t,r,i),broken:r=>this.#e.broken(t,r)};return new Tt(e,o,this.#o,n,this.#s)}#y(e){let{views:t}=this;(e===0||!this.#n.views.length&&this.#b===-1/0)&&(t.length||this.#n.count)&&(this.#p=this.#_(),this.#m||this.reset()),this.redraw()}#_(){let{views:e}=this;return e.length&&this.#a===null?N.fromViews(e,0,this.#A):N.around(this.#n.means,this.#A??te)}get#A(){return Te.get(this.#a??"")??this.#n.up}#S(e){this.#h=0,clearTimeout(this.#v),this.#v=0;let t=e-this.#w;this.#w=e;let n=this.#g,o=this.turning&&this.count>0;this.#g=performance.now()-this.#b<Bo||this.#f.busy||o,this.#g&&n&&this.#l.note(t);let r=Math.min(t,100)/1e3;this.#f.advance(r),o&&this.pose.orbit(Fa*r,0);let{width:i,height:a}=this.#M();if(clearTimeout(this.#u),this.#g&&(this.#u=setTimeout(()=>this.redraw(),2*Bo)),this.count&&!this.#n.broken){let{name:c,count:l,milliseconds:f,fragments:h}=this.#n,u=this.#g&&n?t:0,p=this.#i?.count??0;this.#e.drawn({renderer:c,count:l,compared:p,width:i,height:a,milliseconds:u,passes:f,fragments:h}),this.timed&&this.#n.time()}(this.#f.busy||o)&&this.redraw()}#M(){let{clientWidth:e,clientHeight:t}=this.#t,n=this.#l.size(e,t,devicePixelRatio,this.#g);if(e&&t){let o=this.camera(n.width,n.height),r=this.#l.reduced(this.#g)?1:Po(o,this.views);for(let i of this.#E)i.drawOrReport(o,r)}return n}#d(e,t){let{clientWidth:n,clientHeight:o}=this.#t,{means:r,logits:i}=this.#n,a=Uo(r,i,this.camera(n,o),e,t);a&&this.pose.focus(a),this.redraw()}};var $o=["settings","help","report"],Go=["scale","background","fov","up","autorotate"],Ua=2e3,qo="sorted",za={rootMargin:"100%"},Na="(prefers-reduced-motion: reduce)",kn=class extends(globalThis.HTMLElement??Object){static observedAttributes=["src","compare",...Go];viewer=null;#e;#t=null;#o=new Oe;#s=null;#n;#i=!1;#r=!1;#c=null;#a=[];#l=0;#f=Promise.resolve(!1);#p=!1;#m=new IntersectionObserver(e=>e.some(t=>t.isIntersecting)&&this.#h(),za);constructor(){super(),this.#e=this.attachShadow({mode:"open",delegatesFocus:!0}),this.#e.innerHTML=oo;for(let t of this.#e.querySelectorAll("button"))t.addEventListener("click",()=>this.act(t.dataset.act??""));this.#e.addEventListener("keydown",t=>{let{code:n,key:o,ctrlKey:r,metaKey:i,altKey:a,repeat:c,target:l,defaultPrevented:f}=t,h=hn.get(o.toLowerCase())??hn.get(n.slice(3).toLowerCase()),u=f||l.matches("textarea, select");h&&!r&&!i&&!a&&!c&&!u&&this.act(h),n==="Escape"&&this.act("close")}),this.#e.addEventListener("keyup",t=>{let{code:n,target:o}=t,{classList:r}=o;n==="Tab"&&(r.add("reached"),o?.addEventListener("blur",()=>r.remove("reached"),{once:!0}))}),this.#d("settings").addEventListener("input",({target:t})=>{let n=t;n.name==="stats"?this.act("stats"):this.viewer&&no(n,this.viewer)}),this.addEventListener("dragover",t=>{t.preventDefault(),this.#d("drop").hidden=!1}),this.addEventListener("dragleave",()=>this.#d("drop").hidden=!0),this.addEventListener("drop",t=>{t.preventDefault(),this.#d("drop").hidden=!0,this.#x(t.dataTransfer?.files)});let e=this.#u;e.addEventListener("change",()=>{this.#y(null),this.#x(e.files),e.value=""})}connectedCallback(){queueMicrotask(()=>{if(!this.isConnected||this.viewer)return;let e=this.getAttribute("poster")?.replace(/[\x22\\\n]/g,encodeURIComponent);e&&(this.style.background=`center / cover no-repeat url("${e}")`),this.getAttribute("loading")==="lazy"?this.#m.observe(this):this.#h()})}#h(e=this.getAttribute("renderer")??"auto"){this.#m.disconnect(),this.#d("buttons").hidden=this.hasAttribute("noui"),this.#e.querySelector("[data-act=full]").hidden=!document.fullscreenEnabled;let t=this.#e.querySelector("canvas"),n=this.getAttribute("variant"),[o,r]=["floats","strips"].map(l=>!!n?.includes(l)),i=Number(this.getAttribute("levels")??NaN);this.viewer=new Rt(t,this,{variant:n===null?null:{floats:o,strips:r},levels:i===0||i>=.6&&i<=100?i:null}),t.setAttribute("aria-label",`${this.getAttribute("alt")??"3D scene"}. Press H for the keys.`),t.classList.toggle("polite",this.hasAttribute("polite"));for(let l of Go)this.#_(l);this.#f=this.viewer.begin(e),this.#p=!1,this.#f.then(l=>this.#p=!l);let a=this.#s??this.getAttribute("src"),c=this.#n===void 0?this.getAttribute("compare"):this.#n;a&&this.open(a),c&&this.compare(c)}disconnectedCallback(){this.#m.disconnect(),this.#w()}#w(){this.viewer?.destroy(),this.viewer=null,this.#M(),this.#o=new Oe;let e=this.#e.querySelector("canvas");e?.classList.remove("drawn"),e?.replaceWith(e.cloneNode())}attributeChangedCallback(e,t,n){e==="src"&&(this.#s=null),e==="compare"&&(this.#n=void 0),!(!this.viewer||n===t)&&(e==="compare"?this.compare(n||null):e!=="src"?this.#_(e):n&&this.open(n))}async open(e){this.#s=e,this.#r=this.#i,await this.#A(0,e,(t,n)=>{t.load(n),this.#_("up")})}async compare(e){this.#n=e,this.#r=!1,this.#i=e===qo;let t=this.#i?this.#s:e;this.viewer?.endComparison(),this.#M(),this.#o.begin(1),this.#S(),t!==null&&await this.#A(1,t,(n,o)=>{this.#M();let r=document.createElement("canvas");r.className="over",r.setAttribute("aria-hidden","true"),this.#d("split").before(r),this.#t=new ut(this.#d("split"),r),n.compare(r,o,this.#i)})}act(e){let t=this.viewer;if(t){if(e==="reset"||e==="view")t.turning=!1,t.reset(e==="view"?++this.#l:void 0);else if(e==="help"||e==="settings")this.#y(e);else if(e==="stats")t.timed=this.#k("stats");else if(e==="own")t.background=null;else if(e==="up"){let n=t.turnUp();this.#b(n?`The axis ${n} points up.`:"The scene's own direction points up.",!0)}else if(e==="mode"){let n=t.mode==="fly";t.mode=n?"orbit":"fly",this.#b(`Dragging ${n?"rotates the scene":"looks around"}.`,!0)}else e==="picture"?this.#E():e==="open"?this.#u.click():e==="copy"?this.#v():e==="share"?navigator.share?.({text:this.#g}).catch(()=>{}):e==="full"?document.fullscreenElement?document.exitFullscreen():this.requestFullscreen?.().catch(()=>{}):e==="close"&&(this.#d("message").hidden=!0,this.#y(null));to(this.#d("settings"),t,!this.#d("stats").hidden),t.redraw()}}progress(e,t){this.#o.note(e,{share:t,state:"loading"}),this.#S()}loaded(e,t,n){this.#o.note(e,{share:1,state:"loaded"}),this.#S(),e!==1&&(this.#r&&this.compare(qo),this.#b(`${this.viewer?.count.toLocaleString("en")} Gaussians loaded.`),this.dispatchEvent(new CustomEvent("load",{detail:{milliseconds:t,bytes:n}})))}failed(e,t,n=!1){this.#o.fail(e,t,n),e===0&&(this.#r=!1),this.#S(),this.#d("message").hidden=!1,e===0&&(this.#s=this.viewer?.source??this.#s),this.#e.querySelector(".message [data-act=open]").hidden=!!this.viewer?.count,this.dispatchEvent(new CustomEvent("error",{detail:{sentence:t}}))}broken(e,t){let n=this.viewer;if(!n||n.device.renderer==="WebGL2"||this.getAttribute("renderer")==="webgpu"){this.failed(e,t);return}console.warn(`WebGL2 takes over: ${t}`),this.#w(),this.#h("webgl"),Object.assign(this.viewer,n.choices),n.count&&this.viewer?.place(n.pose)}report(e){let t=JSON.stringify(e,null,1),n=this.#d("report");n.querySelector("textarea").value=t;let o=e.scenes,r=o.some(a=>a.interrupted),i=o.map(({cold:a,steady:c})=>`${a.fps} frames/s cold, ${c.fps} steady`).join(" | ");n.querySelector("h2").textContent=r?"The page was hidden during the measurement: measure again":i,n.querySelector("[data-act=share]").hidden=!navigator.share,n.hidden&&this.#y("report"),this.dispatchEvent(new CustomEvent("report",{detail:e}))}drawn(e){this.#e.querySelector("canvas")?.classList.add("drawn"),e.compared&&this.#d("split").hidden&&this.#t?.show(this.#o.names),this.dispatchEvent(new CustomEvent("frame",{detail:e}));let t=this.#d("stats");if(t.hidden)return;e.milliseconds&&(this.#a=[...this.#a.slice(-29),e.milliseconds]);let n=this.#a.reduce((i,a)=>i+a,0)/this.#a.length,o=[e.count,e.compared].filter((i,a)=>a===0||i),r=[`${e.renderer}, ${e.width} x ${e.height}`,`${o.map(i=>i.toLocaleString("en")).join(" | ")} Gaussians`,this.#a.length?`${(1e3/n).toFixed(0)} frames/s, ${n.toFixed(1)} ms`:"still",...e.fragments?Ia(e.fragments):[],...Object.entries(e.passes??{}).map(([i,a])=>`${i} ${a.toFixed(2)} ms`)];t.textContent=r.join(`
`)}#b(e,t=!1){let n=this.#d("said");n.textContent=e,n.classList.toggle("seen",t),setTimeout(()=>n.classList.remove("seen"),Ua)}get#g(){let e=this.#e.querySelector("textarea");return e.focus(),e.select(),e.value}async#v(){let e=this.#g,t=navigator.clipboard?await navigator.clipboard.writeText(e).then(()=>!0,()=>!1):document.execCommand("copy");this.#d("copied").textContent=t?"Copied.":"This browser does not allow copying: the text is selected, press Ctrl+C."}get#u(){return this.#e.querySelector("[type=file]")}#x(e){let[t,n]=e??[];t&&this.open(t),n&&this.compare(n)}async#E(){let e=await this.viewer?.screenshot(this.#t?.share);if(!e)return;let t=document.createElement("a");Object.assign(t,{href:URL.createObjectURL(e),download:"scene.png"}).click(),setTimeout(()=>URL.revokeObjectURL(t.href),1e3)}#k(e,t){let n=this.#d(e);return n.hidden=t===void 0?!n.hidden:!t,this.#e.querySelector(`[data-act=${e}]`)?.setAttribute("aria-expanded",String(!n.hidden)),!n.hidden}#y(e){$o.every(n=>this.#d(n).hidden)&&(this.#c=this.#e.activeElement);let t=e!==null&&this.#d(e).hidden;for(let n of $o)this.#k(n,t&&n===e);t?this.#d(e).focus():(this.#c??this.#e.querySelector("canvas"))?.focus({preventScroll:!0})}#_(e){let t=this.viewer,n=this.getAttribute(e),o=Number(n);e==="scale"?t.scale=o>0&&o<=1?o:null:e==="fov"?t.fov=o>=1&&o<=150?o:null:e==="background"?t.background=ht(n):e==="up"?t.up=n:t.turning=n!==null&&!matchMedia(Na).matches,t.redraw()}async#A(e,t,n){let o=this.viewer;if(o===null||this.#p)return;let r=this.#n;if(e===1&&(!await this.#f||o!==this.viewer||r!==this.#n))return;let i=typeof t=="string"?t.replace(/[?#].*$/,""):"scene",a=t instanceof File?t.name:i;this.#o.begin(e,e===1&&this.#i?`${a}, sorted`:a),this.#S();try{let c=t instanceof Blob?{file:t}:{url:new URL(t,document.baseURI).href};n(o,c)}catch(c){this.failed(e,`the scene cannot be opened: ${c.message}`)}}#S(){let{state:e,busy:t,share:n,sentence:o,names:r}=this.#o,i=this.#d("bar");i.hidden=!t,i.classList.toggle("unknown",Number.isNaN(n));let a=Math.min(100,Math.round(100*n))||0;i.setAttribute("aria-valuenow",String(a)),i.firstElementChild.style.width=`${a}%`;let c=this.#d("message"),l=c.querySelector("p");l.textContent!==o&&(l.textContent=o),o||(c.hidden=!0),this.#d("split").hidden||this.#t?.show(r),e&&(this.dataset.state=e)}#M(){this.#d("split").hidden=!0,this.#e.querySelector(".over")?.remove(),this.#t=null}#d(e){return this.#e.querySelector(`.${e}`)}};function Ia(s){let e=o=>o.toFixed(1),t=s.reduce((o,r)=>o+r),n=[`${e(t)} fragments per pixel`];return s.length>1?[...n,`${s.map(e).join(" + ")} by level`]:n}globalThis.customElements?.define("mobile-gs",kn);var Ot=40,An=480,Ho=10,Ca=10,Da=1e3,Pa=250;function jo(s,e){let[,t,n,o]=/^(?:(\d+)(?:,|$))?(?:(\d+)x(\d+))?$/.exec(s)??[];return{seconds:Math.min(Math.max(Number(t)||60,1),3600),width:Math.min(Number(n)||e.width,8192),height:Math.min(Number(o)||e.height,8192)}}var Ba=({views:s})=>s.length<2?An:Ot*s.length;function Vo(s,e,t){let{views:n}=s;if(n.length<2){let f=e.copy();return f.orbit(2*Math.PI*t/An,.2*Math.sin(6*Math.PI*t/An)),f}let o=Math.floor(t/Ot),[r,i]=[o,o+1].map(f=>N.fromViews(n,f%n.length)),a=t%Ot/Ot,c=M(r.eye,R(i.eye,r.eye),a),l=M(r.target,R(i.target,r.target),a);return new N(c,l,r.up)}async function Xo(s,e,t){let n=s.pose.copy(),o=document.hidden,r=()=>o||=document.hidden;document.addEventListener("visibilitychange",r),s.measured=!0;try{let i=await Wo(),a=await $a(s,n,e,t),c=await Wo();return{...a,battery:i&&c&&{start:i,end:c},interrupted:o}}finally{document.removeEventListener("visibilitychange",r),s.measured=!1,s.place(n)}}async function Wo(){let s=await navigator.getBattery?.().catch(()=>null);return s?{percent:Math.round(100*s.level),charging:s.charging}:null}async function $a(s,e,{seconds:t,width:n,height:o},r){let i=[],a=[];for(let d=0;d<Ho;d++)s.pose=Vo(s,e,d),await s.drawAndWait(n,o);await s.passes();let c=performance.now(),l=[],f=0;for(let d=Ho,m=0;m<1e3*t;d++){s.pose=Vo(s,e,d);let g=performance.now()-c,v=await s.drawAndWait(n,o);if(m=performance.now()-c,i.push({from:g,to:m,order:v}),r(Math.min(1,m/(1e3*t))),m-f<Pa)continue;let E=await s.passes();if(E&&a.push({from:g,to:m,passes:{...E}}),m>Da*l.length){let w=await s.fragments();w&&l.push(w)}await new Promise(w=>requestAnimationFrame(w)),f=performance.now()-c}let h=1e3*Math.min(Ca,t/2),u=i[i.length-1].to,p=d=>Ga(i.filter(d),a.filter(d));return{path:Ba(s),cold:p(({from:d})=>d<h),steady:p(({to:d})=>d>u-h),whole:p(()=>!0),fps_by_second:Array.from({length:t},(d,m)=>Yo(i.filter(({to:g})=>Math.min(Math.floor(g/1e3),t-1)===m))),fragments:l.length?l[0].map((d,m)=>Sn(l.reduce((g,v)=>g+v[m],0)/l.length)):null}}var Sn=s=>Number(s.toFixed(2));function Yo(s){let e=s.reduce((t,{from:n,to:o})=>t+o-n,0);return s.length?Sn(1e3*s.length/e):null}function Lt(s,e){let t=s.slice().sort((n,o)=>n-o);return Sn(t[Math.floor(e*(t.length-1))]??NaN)}function Ga(s,e){let t=s.map(({from:i,to:a})=>a-i),n=s.flatMap(({order:i})=>i??[]),o=[...new Set(e.flatMap(({passes:i})=>Object.keys(i)))],r=i=>Lt(e.flatMap(({passes:a})=>a[i]??[]),.5);return{frames:t.length,fps:Yo(s)??NaN,milliseconds:Lt(t,.5),milliseconds95:Lt(t,.95),order:n.length?Lt(n,.5):null,passes:o.length?Object.fromEntries(o.map(i=>[i,r(i)])):null}}function Ko({eye:s,target:e,up:t}){let n=Math.min(20,Math.max(0,Math.ceil(4-Math.log10(ee(R(e,s)))))),o=(r,i=n)=>r.map(a=>Number(a.toFixed(i))).join(",");return`eye=${o(s)}&at=${o(e)}&up=${o(t,5)}`}function Qo(s){let e=new URLSearchParams(s.replace(/^#/,"")),t=["eye","at","up"].map(i=>(e.get(i)??"").split(",").map(Number));if(t.some(i=>i.length!==3||!i.every(Number.isFinite)))return null;let[n,o,r]=t;return n.every((i,a)=>i===o[a])?null:new N(n,o,r)}var qa="renderer variant levels scale noui poster background fov up autorotate compare".split(" "),Ha=400;function Zo(){let s=document.querySelector("mobile-gs"),e=new URLSearchParams(location.search);for(let c of qa){let l=e.get(c);l!==null&&s.setAttribute(c,l)}let t=e.get("url");t&&s.setAttribute("src",t),setTimeout(()=>{let c=Es();!t&&c?s.open(c):s.hasAttribute("src")||s.failed(0,"no scene is given: open a .mgs, .ply or .spz file, or add ?url=... to the address"),n(),parent===self&&s.focus({preventScroll:!0})},0);let n=()=>{let c=Qo(location.hash);c&&s.viewer?.place(c)};addEventListener("hashchange",n);let o=0,r="",i=()=>s.viewer?Ko(s.viewer.pose):"";s.addEventListener("frame",()=>{r||=i(),clearTimeout(o),o=setTimeout(()=>{let c=i(),l=r!==""&&c!==r;r=c;try{l&&history.replaceState(null,"",`#${c}`)}catch{}},Ha)});let a=e.get("bench");a!==null&&Va(s,a,e.getAll("url").slice(1))}async function Va(s,e,t){let n={width:Math.round(innerWidth*devicePixelRatio),height:Math.round(innerHeight*devicePixelRatio)},o=jo(e,n),r=[],i;for(let a of[null,...t]){let c=Wa(s);a!==null&&s.setAttribute("src",a);let l=await c,{viewer:f}=s;if(!l||!f)return;await f.calibrated,i??=await navigator.wakeLock?.request("screen").catch(()=>null);try{let h=await Xo(f,o,u=>s.progress(0,u));r.push({scene:s.getAttribute("src")??"own",gaussians:f.count,file_bytes:l.bytes,milliseconds_to_load:Math.round(l.milliseconds),...f.device,...h})}catch(h){i?.release(),s.failed(0,`the frame rate cannot be measured: ${h.message}`);return}s.loaded(0,l.milliseconds,l.bytes)}i?.release(),s.report({date:new Date().toISOString(),...o,viewer:xs(),browser:navigator.userAgent,device_pixel_ratio:devicePixelRatio,scenes:r})}function Wa(s){return new Promise(e=>{s.addEventListener("load",t=>e(t.detail),{once:!0}),s.addEventListener("error",()=>e(null),{once:!0})})}globalThis.document?Zo():Js();
})();
