(function bundle(){"use strict";
var ua=Object.defineProperty;var M=(s,e,t)=>()=>{if(t)throw t[0];try{return s&&(e=s(s=0)),e}catch(n){throw t=[n],n}};var ct=(s,e)=>{for(var t in e)ua(s,t,{get:e[t],enumerable:!0})};var b,p=M(()=>{b={"count.glsl":`out vec4 found;
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
`}});var ma,_,te=M(()=>{"use strict";p();ma=/[\x00-\x1f\x7f-\x9f\u2028\u2029\p{Cs}]/gu,_=class extends Error{name="SceneError";constructor(e){super(e.replace(ma,"\uFFFD"))}}});var Ae,lt=M(()=>{"use strict";p();Ae=class{#e;#t;#o;constructor(e,{sh:t,scales:n,quats:o},r){this.#e=e,this.#t=[[t,e.part(r,0,12)],[n,e.part(r,12,3)]],this.#o=[o,e.part(r,15,4)]}write(){let[e,t]=this.#o;for(let[n,o]of this.#t)this.#e.units(n,o);t.numbers.set(e.numbers)}}});function Is({colors:s,scalars:e}){let t=e.get("appearance")?.columns.length??6,n={linear:[["static2",3,3],["view2",9,t-3]],networks:ga,latent_networks:wa};return[_n[s],n[s]]}function $s({degree:s,latents:e,hidden:t}){let n=2*(s+1)**2,o=[19+e,...t],r=[["bias",1,n],["basis",e,n]];return t.length===0||([...t,n].forEach((i,a)=>r.push([`weights.${a}`,i,o[a]])),t.forEach((i,a)=>r.push([`offsets.${a}`,1,i]))),r}function Ds(s){return s.reduce((e,[,t,n])=>e+t*n,0)}function Bs(s,e){let t=0;return Object.fromEntries(e.map(([n,o,r])=>[n,s.subarray(t,t+=o*r)]))}var ga,wa,_n,Cs,An=M(()=>{"use strict";p();lt();ga=[["context1",64,96],["context2",13,64],["static1",64,16],["static2",3,64],["view1",64,16],["view2",9,64]],wa=[["both1",128,6],["static2",3,64],["view2",9,64]],_n={linear:"color-matrices",networks:"appearance-decoder",latent_networks:"color-networks"};Cs=[["hidden1.weight",256,22],["hidden1.bias",1,256],["hidden2.weight",128,256],["hidden2.bias",1,128],["hidden3.weight",64,128],["hidden3.bias",1,64],["phi.weight",1,64],["phi.bias",1,1],["opacity.weight",1,64],["opacity.bias",1,1]]});function Ws(s,e){let{colors:t="networks"}=s;for(let[h,d,...m]of[["mode",s.mode,"nvq","sq"],["blend",s.blend,"sortfree","sorted"],["sh_degree",s.sh_degree,1],["colors",t,"linear","networks","latent_networks"]])if(!m.includes(d))throw new _(`the .mgs file has ${h} '${Xs(d)}', which this program does not know: a newer one may`);let n=Fa(s),o=s.network;if(typeof o!="boolean")throw R("network");if(o&&n!==null)throw new _("the .mgs file has lobes and a view network: it can have one of them");let r=s.mode==="sq",i=N(s,"count",1,ba),a={count:i,lodSizes:za(s,i),cuts:r?new Map:Na(V(s,"codebooks"),n),scalars:r?Ua(V(s,"scalars"),n,t==="linear"):new Map,grid:Ia(V(s,"positions")),colors:t,sorted:s.blend==="sorted",lobes:n,network:o,weighting:Ca(V(s,"weighting")),footprint:$a(V(s,"footprint")),background:dt(s,"background",3),near:ne(s,"near"),views:$e(s,"views").map(Da),meta:Ba(V(s,"meta"))},c=Oa(a),f=s.streams.filter(h=>c.has(h.name)).reduce((h,d)=>h+d.bytes,0);if(i>f)throw new _(`the .mgs file claims ${i} Gaussians in ${f} of its ${e} bytes: it is damaged`);if(a.footprint.soft_edge&&a.sorted)throw R("footprint.soft_edge");if(a.background.some(h=>h<0||h>1))throw R("background");if(!(a.near>0&&a.near<=ft))throw R("near");if(a.views.length>Sa)throw R("views");return a}function ht(s,e){return typeof s!="string"||s.length>2*e||Ta.test(s)?!1:s.length<=e||[...s].length<=e}function Oa({colors:s,lobes:e,network:t,cuts:n,scalars:o,lodSizes:r}){let i=["positions"];for(let[c,{count:l}]of n)for(let f=0;f<l;f++)i.push(`${c}.${f}`);for(let[c,{columns:l}]of o)i.push(...l.map((f,h)=>`${c}.${h}`));o.size&&i.push("rotation-finer");let a=r.flatMap((c,l)=>i.map(f=>l?`${f}@${l}`:f));return a.push(_n[s]),e&&a.push("lobe-decoder"),t&&a.push("view-network"),n.size&&a.push("codebooks"),new Set(a)}function za(s,e){let t=$e(s,"layers").map(o=>N({layers:o},"layers",1,e)),n=t.reduce((o,r)=>o+r,0);if(t.length>va||n!==e)throw R("layers");return t}function Fa(s){if(s.lobes===null)return null;let e=V(s,"lobes"),t=$e(e,"hidden");if(t.length>Aa)throw R("lobes.hidden");return{degree:N(e,"degree",0,3),latents:N(e,"latents",0,Tn),hidden:t.map(n=>N({hidden:n},"hidden",1,_a))}}function Na(s,e){let t=new Map;for(let[o,r]of Ra){if(o==="opacity"&&!Object.hasOwn(s,o)&&e!==null)continue;let i=V(s,o),a=r.find(([c,l])=>i.count===c&&i.length===l);if(!a)throw R(`codebooks.${o}`);t.set(o,{count:a[0],length:a[1],size:N(i,"size",1,Mn)})}let n=0;if(Object.hasOwn(s,"lobes")){let o=V(s,"lobes"),r=N(o,"count",1,Tn),i=N(o,"length",1,Tn);t.set("lobes",{count:r,length:i,size:N(o,"size",1,Mn)}),n=r*i}if(n!==(e===null?0:e.latents))throw R("codebooks.lobes");return t}function Ua(s,e,t){let n=new Map,o=e?.latents??0;if(Object.hasOwn(s,"lobes")&&!o)throw R("scalars.lobes");for(let[r,i]of[...La,["lobes",o]]){if(r==="opacity"&&!Object.hasOwn(s,r)&&e!==null||i===0)continue;let c=V(s,r),[l,f,h]=["least","size","middle"].map(x=>$e(c,x)),[d,m]=r==="appearance"&&t?Vs:[i,i],u=l.length;if(u<d||u>m||f.length!==u||h.length!==u)throw R(`scalars.${r}`);let g=Math.fround(ne(c,"step"));if(!(g>=xa&&g<=ya))throw R(`scalars.${r}.step`);let w=l.map((x,y)=>{let v={least:l[y],size:f[y],middle:h[y]},E=N(v,"least",-Sn,Sn),A=N(v,"size",1,Mn),T=N({size:E+A-1},"size",E,Sn);if(r==="scale"&&T*g>ka)throw R("scalars.scale");let I=Math.max(-E,T)+.5;if(r==="rotation"&&I*g>Ea)throw R("scalars.rotation");return{least:E,size:A,middle:N(v,"middle",E,T)}});n.set(r,{step:g,columns:w})}return n}function Ia(s){let e=dt(s,"center",3),t=Math.fround(ne(s,"radius"));if(e.some(n=>Math.abs(n)>Math.fround(ft)))throw R("positions.center");if(t<Ma||t>ft)throw R("positions.radius");return{center:e,radius:t,exponent:N(s,"exponent",0,14)}}function Ca(s){let{name:e}=s;if(typeof e!="string")throw R("name");if(!qs.includes(e))throw new _(`the .mgs file has the weighting '${Xs(e)}': known are ${qs.join(", ")}`);let t={name:e,exponent_max:ne(s,"exponent_max"),sigma:ne(s,"sigma"),background_weight:ne(s,"background_weight"),alpha_min:s.alpha_min===void 0?1/255:ne(s,"alpha_min")};if(!(t.exponent_max>0&&t.exponent_max<=80))throw R("exponent_max");if(!(t.sigma>0&&t.sigma<=ft))throw R("sigma");if(t.background_weight<0)throw R("background_weight");if(!(t.alpha_min>=1e-4&&t.alpha_min<=.1))throw R("alpha_min");return t}function $a(s){let{antialiased:e,soft_edge:t}=s;if(typeof e!="boolean")throw R("footprint.antialiased");if(typeof t!="boolean")throw R("footprint.soft_edge");let n=ne(s,"blur");if(!(n>0&&n<=4))throw R("footprint.blur");return{blur:n,antialiased:e,soft_edge:t}}function Da(s){let e=V({views:s},"views"),t=dt(e,"viewmat",16),n=dt(e,"K",9);if(![0,0,0,1].every((i,a)=>t[12+a]===i)||![0,0,1].every((i,a)=>n[6+a]===i)||n[0]<=0||n[4]<=0)throw new _("a view's matrices in the .mgs file are not those of a camera");let r=N(e,"width",1,Ps);return{viewmat:t,K:n,width:r,height:N(e,"height",1,Ps)}}function Ba(s){let e=Object.entries(s);if(e.length>Gs)throw new _(`the .mgs file has ${e.length} notes: ${Gs} are allowed`);for(let[t,n]of e){let o=n===null||typeof n=="boolean"||ht(n,Hs),r=typeof n=="number"&&Math.abs(n)<=2**53;if(!(o||r)||!ht(t,Hs))throw new _(`the note '${t.slice(0,40)}' is not a short text or a number`)}return s}function V(s,e){let t=s[e];if(typeof t!="object"||t===null||Array.isArray(t))throw R(e);return t}function $e(s,e){let t=s[e];if(!Array.isArray(t))throw R(e);return t}function N(s,e,t,n){let o=ne(s,e);if(!Number.isInteger(o)||o<t||o>n)throw R(e);return o}function ne(s,e){return js(s[e],e)}function dt(s,e,t){let n=$e(s,e);if(n.length!==t)throw R(e);return Float32Array.from(n,o=>js(o,e))}function js(s,e){if(typeof s!="number"||!(Math.abs(s)<=3e38))throw R(e);return s}function Xs(s){return typeof s!="object"||s===null?String(s).slice(0,40):Array.isArray(s)?"a list":"an object"}function R(s){return new _(`the field '${s}' in the header of the .mgs file is missing or invalid`)}var ae,ba,va,Mn,Sn,xa,ya,ka,Ea,Tn,_a,Aa,Sa,Ps,Gs,Hs,Ma,ft,Ta,qs,Ra,Vs,La,Me=M(()=>{"use strict";p();te();An();ae=Object.freeze({blur:.3,antialiased:!1,soft_edge:!1}),ba=2**26,va=8,Mn=4096,Sn=2**14,xa=1e-5,ya=1e3,ka=80,Ea=8,Tn=32,_a=256,Aa=3,Sa=64,Ps=2**16,Gs=64,Hs=4096,Ma=1e-20,ft=1e20,Ta=/[\x00-\x1f\x7f-\x9f\p{Cs}]/u,qs=["mobile_gs","no_depth","no_scale","sort_free_gs"],Ra=[["scale",[[3,1],[1,3]]],["rotation",[[2,2],[1,4]]],["appearance",[[3,2]]],["opacity",[[1,1]]]],Vs=[6,12],La=[["scale",3],["rotation",3],["appearance",Vs[0]],["opacity",1]]});function D(s){let e=U(s);return e>0?[s[0]/e,s[1]/e,s[2]/e]:[1,0,0]}function Rn(s,e,t){let[n,o]=[Math.cos(t),Math.sin(t)],r=O(s,e)*(1-n),i=$(e,s);return S(S([s[0]*n,s[1]*n,s[2]*n],i,o),e,r)}var S,L,O,$,U,K=M(()=>{"use strict";p();S=(s,e,t=1)=>[s[0]+t*e[0],s[1]+t*e[1],s[2]+t*e[2]],L=(s,e)=>S(s,e,-1),O=(s,e)=>s[0]*e[0]+s[1]*e[1]+s[2]*e[2],$=(s,e)=>[s[1]*e[2]-s[2]*e[1],s[2]*e[0]-s[0]*e[2],s[0]*e[1]-s[1]*e[0]],U=s=>Math.hypot(...s)});function Ys(s){let e=D(s.reduce((n,{down:o})=>L(n,o),[0,0,0])),t=e;for(let n=0;n<200;n++){let o=S([0,0,0],t,1+Ks);for(let{right:r}of s)o=S(o,r,-O(r,t)/s.length);t=D(S(o,e,Ks*O(e,t)))}return t}function Be(s,e){let t=O(se,e);if(t<1e-9-1)return[s[0],-s[1],-s[2]];let n=$(se,e),o=$(n,s);return S(S(s,o),$(n,o),1/(1+t))}function ut(s){let e=typeof s=="string"?s.trim().split(/\s+/):[];if(e.length!==3||!e.every(n=>Pa.test(n)))return null;let t=e.map(Number);return t.some(n=>n!==0)?D(t):null}function Qs(s,e){let t=[...De.keys()],n=i=>O(De.get(i)??se,e),o=t.reduce((i,a)=>n(a)>n(i)?a:i),r=[null,...t.filter(i=>i!==o)];return r[(r.indexOf(s===o?null:s)+1)%r.length]}var Ks,Pa,De,se,Te=M(()=>{"use strict";p();K();Ks=.02,Pa=/^-?\d{1,9}(\.\d{1,9})?$/,De=new Map([["-y",[0,-1,0]],["z",[0,0,1]],["y",[0,1,0]],["-z",[0,0,-1]],["x",[1,0,0]],["-x",[-1,0,0]]]),se=[0,-1,0]});function pt(s){return s[0]===112&&s[1]===108&&s[2]===121}function Zs(s){return s[0]===78&&s[1]===71&&s[2]===83&&s[3]===80||s[0]===31&&s[1]===139}var Ln=M(()=>{"use strict";p()});function eo(s){let{offsets:e,stride:t,rows:n,start:o,footprint:r,up:i}=Xa(s),a=new DataView(s.buffer,s.byteOffset+o),c=[...e.keys()].filter(x=>x.startsWith("f_rest_")).length,l=c/3+1;if(![1,4,9,16].includes(l))throw new Error(`the .ply file has ${c} numbers f_rest_*: 0, 9, 24 or 45 were expected`);let f=x=>e.get(x),h=["x","y","z","scale_0","scale_1","scale_2","rot_0","rot_1","rot_2","rot_3"];h.push("opacity","f_dc_0","f_dc_1","f_dc_2");for(let x=0;x+1<l;x++)for(let y=0;y<3;y++)h.push(`f_rest_${y*(l-1)+x}`);let d=h.find(x=>!e.has(x));if(d)throw new Error(`the .ply file has ${c} numbers f_rest_*, but not ${d}`);let m=h.map(f),u={...zn(n,l,r),up:i},g=new Float32Array(m.length);for(let x=0;x<n;x++){for(let v=0;v<g.length;v++)g[v]=a.getFloat32(x*t+m[v],!0);for(let v=3;v<6;v++)g[v]===-1/0&&(g[v]=Va);Math.abs(g[10])===1/0&&(g[10]=Math.sign(g[10])*qa);let y=0;for(let v=0;v<g.length;v++)y+=g[v]*0;y===0&&Fn(u,g)}let{count:w}=u;return w===n||(u.shapes=u.shapes.slice(0,12*w),u.colors=u.colors.slice(0,3*l*w),u.lobes=u.lobes.slice(0,2*w)),u}function On(s=""){return`'${s.slice(0,40).replace(/[^\x20-\x7e]/g,"\uFFFD")}'`}function zn(s,e,t){return{count:0,packing:null,shapes:new Float32Array(12*s),colors:new Float32Array(3*e*s),shSize:e,lobes:new Float32Array(2*s),lobeSize:1,sorted:!0,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},footprint:t,background:[0,0,0]}}function Fn(s,e){let[t,n,o,r]=[e[6],e[7],e[8],e[9]],i=t*t+n*n+o*o+r*r;if(!(i>0))return;let a=2/i,[c,l,f]=[Math.exp(e[3]),Math.exp(e[4]),Math.exp(e[5])];if(!(c+l+f<1e30&&Math.abs(e[10])<1e30))return;let h=s.count++;s.shapes.set([c*(1-a*(o*o+r*r)),c*a*(n*o+t*r),c*a*(n*r-t*o),e[0],l*a*(n*o-t*r),l*(1-a*(n*n+r*r)),l*a*(o*r+t*n),e[1],f*a*(n*r+t*o),f*a*(o*r-t*n),f*(1-a*(n*n+o*o)),e[2]],12*h),s.lobes[2*h]=e[10]/Ha,s.colors.set(e.subarray(11),3*s.shSize*h)}function Xa(s){let e=new TextDecoder("latin1").decode(s.subarray(0,Ga)),t=/\nend_header\r?\n/.exec(e);if(!pt(s)||t===null)throw new Error("this is not a PLY file, or its header is cut off");let n=e.slice(0,t.index).split(/\r?\n/).map(d=>d.trim().split(/\s+/)),o=n.find(d=>d[0]==="format")?.[1];if(o!=="binary_little_endian")throw new Error(`the .ply file is ${On(o)}: only binary_little_endian is read`);let r=n.findIndex(d=>d[0]==="element"),i=n[r]??[],a=/^\d+$/.test(i[2])?Number(i[2]):NaN;if(i[1]!=="vertex"||!Number.isSafeInteger(a)||a<0)throw new Error("the .ply file does not begin with its vertices, as those of 3DGS do");let c=new Map,l=0;for(let d of n.slice(r+1)){if(d[0]==="element")break;if(d[0]!=="property")continue;let m=Wa.get(d[1]);if(m===void 0)throw new Error(`the .ply file has a property of type ${On(d[1])}`);if(d.length!==3)throw new Error("the .ply file has a property without a name, or with two");if(c.has(d[2]))throw new Error(`the .ply file has the property ${On(d[2])} twice`);(d[1]==="float"||d[1]==="float32")&&c.set(d[2],l),l+=m}let f=Js.filter(d=>!c.has(d));if(f.length)throw new Error(`the .ply file is not a Gaussian scene: it lacks ${f.join(", ")} as floats`);let h=t.index+t[0].length;if(h+a*l>s.length)throw new Error(`the .ply file is cut off: ${a} Gaussians were announced`);return{offsets:c,stride:l,rows:a,start:h,footprint:Ka(n),up:Ya(n)}}function Ka(s){let e={...ae};for(let[t,...n]of s){if(t!=="comment")continue;let o=n.join(" ");n[0]==="SplatRenderMode:"?e.antialiased=n[1]?.toLowerCase()==="mip":o==="antialiased 1"||o==="postshot.anti_aliasing=1"?e.antialiased=!0:n.length===3&&o.startsWith("mobilegs blur ")&&(e.blur=/^\d*\.?\d+$/.test(n[2])?Number(n[2]):NaN)}if(!(e.blur>0&&e.blur<=4))throw new Error("the .ply file names a blur that is not possible: above 0 and at most 4 is");return e}function Ya(s){let e=null;for(let t of s){let[n,o,r,...i]=t.map(a=>a.toLowerCase());n==="comment"&&(o==="vertical"&&r==="axis:"&&i.length===1&&(e=ja.get(i[0])??e),o==="mobilegs"&&r==="up"&&(e=ut(i.join(" "))??e))}return e}var Ga,Ha,qa,Va,Wa,ja,Js,Nn=M(()=>{"use strict";p();Me();Te();Ln();Ga=65536,Ha=.28209479177387814,[qa,Va]=[13.8,-69],Wa=new Map([["char",1],["int8",1],["uchar",1],["uint8",1],["short",2],["int16",2],["ushort",2],["uint16",2],["int",4],["int32",4],["uint",4],["uint32",4],["float",4],["float32",4],["double",8],["float64",8]]),ja=new Map([["x",[1,0,0]],["y",[0,-1,0]],["z",[0,0,1]]]),Js=["x","y","z","f_dc_0","f_dc_1","f_dc_2","opacity","scale_0","scale_1"];Js.push("scale_2","rot_0","rot_1","rot_2","rot_3")});function Y(s){return new DataView(s.buffer,s.byteOffset,s.byteLength)}function Re(s,e){let t=Math.ceil(e/8);if(s.length!==t)throw new _(`packed bits take ${s.length} bytes where ${t} belong`);if(e%8&&s[t-1]>>e%8)throw new _("packed bits end in bits that are not zero");return new me(s)}var me,ge=M(()=>{"use strict";p();te();me=class{#e;#t=0;#o=0;constructor(e){this.#e=e}get left(){return 8*(this.#e.length-this.#t)-this.#o}take(e){let t=this.#e,n=this.#t,o=t[n]|t[n+1]<<8|t[n+2]<<16|t[n+3]<<24,r=this.#o+e,i=o>>>this.#o&(1<<e)-1;return this.#t=n+(r>>>3),this.#o=r&7,i}atEnd(){return this.left<8&&this.#e[this.#t]>>>this.#o===0}}});var to,no=M(()=>{"use strict";p();to="0061736d01000000012a0460077f7f7f7f7f7f7d0060037f7f7f0060097f7f7f7f7f7f7f7f7f017f60097f7f7f7f7f7f7f7d7d00020f0103656e76066d656d6f727902000103060500010202030607017f014180080b073705056c61796572000005756e69747300010a70756c6c5f706c61696e00020f70756c6c5f636f6e7465787475616c0003047061636b00040abc21059c0404017f017b047f0b7b024020054101480d00200120054102746a21072006fd13210820044102742209410148210a0340200020094102746a210b4100210c03402001fd09000c210d2001fd090008210e2001fd090004210f2001fd090000211002400240200a450d00200d2111200e2112200f2113201021140c010b2002200c4102746a2104200d2111200e2112200f2113201021142000210503402004fd00001022152005fd0900002216fde6012010fde40121102004fd00000022172016fde6012014fde401211420152005fd0900042216fde601200ffde401210f20172016fde6012013fde401211320152005fd0900082216fde601200efde401210e20172016fde6012012fde401211220152005fd09000c2216fde601200dfde401210d20172016fde6012011fde401211120044180046a2104200541106a2205200b490d000b0b2003200c4102746a2205201120082011fde601fde901fd0b00800c2005201220082012fde601fde901fd0b0080082005201320082013fde601fde901fd0b0080042005201020082010fde601fde901fd0b00102005201420082014fde601fde901fd0b0000200541900c6a200d2008200dfde601fde901fd0b000020054190086a200e2008200efde601fde901fd0b000020054190046a200f2008200ffde601fde901fd0b0000200c41f800492105200c41086a210c20050d000b20034180106a2103200b2100200141106a22012007490d000b0b0bd50104027f017b027f017b200020024109746a2103410021040340fd0c0000000000000000000000000000000021052000200441027422066a22022107034020052007fd00000022082008fde601fde401210520074180046a22072003490d000b200120066a2107fd0c0000803f0000803f0000803f0000803f2005fde301fd0cccbc8c2bccbc8c2bccbc8c2bccbc8c2bfde901fde70121050340200720052002fd000000fde601fd0b000020074180046a210720024180046a22022003490d000b200441fc00492102200441046a210420020d000b0bd30101087f41002109034002402006200820092007491b220a4101480d002000200a4103746a210b2000210a0340024020022001200a280200220c41ffff0071220d4101746a2f0100220e4102746a280200220f0d0041000f0b20042f01002110200a28020420094101746a200e3b0102200a20104100200d200f410f766b200f41ffff0171200c410e766c6a220c4180800449220f1b200c200f41047474723602002004200f4101746a2104200a41086a220a200b490d000b0b0240200420054b0d00200941016a220920074d0d010b0b20040bf101010a7f410021094100210a0340024020062008200a2007491b220b4101480d002000200b4103746a210c2000210b0340024020022009200b280204200a4101746a220d2f010071220e20036c2001200e410f74200b280200220f41ffff00712210410174726a2f010022116a4102746a280200220e0d0041000f0b20042f01002112200d20113b0102200b201241002010200e410f766b200e41ffff0171200f410e766c6a220d4180800449220e1b200d200e41047474723602002004200e4101746a2104200b41086a220b200c490d000b0b0240200420054b0d00417f2109200a41016a220a20074d0d010b0b20040bfc1707067f027b037f0c7b037f0e7b017f2005417e7121092005410171210a200641036c210b2006410174210c20044180206a210d200541017441026a210e2008fd13210f2007fd132110410021112006410274221241027421130340fd0c020000000200000002000000020000002214fd0c010000000100000001000000010000002215fd0c0000000000000000000000000000000022162001fd000080042217fde0012001fd0000002218fde001fd442219fd522001fd00008008221afde001201720182019fd522217fde001fd442218fd522119fd0c03000000030000000300000003000000211b2001fd0000800c221c201a20172018fd522217201cfde0012017fde001fd44221dfd52221efd0cffffff7fffffff7fffffff7fffffff7f221cfd4e2016fd37211ffd0c0000000000000000000000000000000022172118410121202016211a4100212102400240024020050e020201000b0340201720032020410a746a2222fd000000fde001fde90120224180086afd000000fde001fde9012117201820224180046afd000000fde001fde901202241800c6afd000000fde001fde9012118202041026a2120202141026a22212009470d000b0b0240200a450d00201720032020410a746a2222fd000000fde001fde9012117201820224180046afd000000fde001fde90121180b2018fd0cffff0f00ffff0f00ffff0f00ffff0f00221afdae014114fdad0121162017201afdae014114fdad01211a0b201b2019201dfd52211d200d2003fd000080042217fd0c000000800000008000000080000000802223fd4e2003fd00000022184110fdad01fd0c008000000080000000800000008000002224fd4efd502018201cfd4e2219fd0c0000804b0000804b0000804b0000804b2225fde601fd6afdf80120192018410dfdad012015fd4efdae01fd0cff0f00c8ff0f00c8ff0f00c8ff0f00c82226fdae01410dfdad01fd0cff7b0000ff7b0000ff7b0000ff7b00002227fdb7012019fd0c000080380000803800008038000080382228fd3afd52fd502017201cfd4e22182025fde601fd6afdf80120182017410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120182028fd3afd524110fdab01fd502217fd0c0000ffff0000ffff0000ffff0000fffffd4efd0ce2f00000e2f00000e2f00000e2f00000fd502017201ffd522217fd5a00000041022120200d20064102746a2017fd5a000001200d200c4102746a2017fd5a000002200d200b4102746a2017fd5a0000032016fd0c78030000780300007803000078030000221ffdb901fd0c770400007704000077040000770400002229fdb601fd0c88fcffff88fcffff88fcffff88fcffff222afdae01212bfd0c00008037000080370000803700008037212cfd0c0000fe420000fe420000fe420000fe422117201a201ffdb9012029fdb601202afdae01212d0240200e41024d0d002017202b4114fdab01202cfdae01fde70121192017202d4114fdab01202cfdae01fde701211a200d21220340202241046a22222019200320204109742221418004726afd000000fde601fd0c0000fec20000fec20000fec20000fec22218fde9012017fde801fd0c002000440020004400200044002000442216fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4e201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf801fd0cff000000ff000000ff000000ff000000fd4e2019200320214180086a2221418004726afd000000fde6012018fde9012017fde8012016fde401fdf8014118fdab01201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4efd50fd50fd502218fd5a000000202220126a2018fd5a0000012022200c4102746a2018fd5a0000022022200b4102746a2018fd5a000003202041046a2220200e490d000b0b200441346a202d4110fdab01202b4118fdab01fd502218fd5a000003200441246a2018fd5a000002200441146a2018fd5a000001200441046a2018fd5a000000200441386a200f2000fd00008004fdfa012010fde501fde601fd0c000000000000000000000000000000002218fde901fd0c0000803f0000803f0000803f0000803f2216fde801fd0c00e0ff4400e0ff4400e0ff4400e0ff44221afde601fd0c0000003f0000003f0000003f0000003f2219fde401fdf801410bfdab01200f2000fd00008008fdfa012010fde501fde6012018fde9012016fde801fd0c00c07f4400c07f4400c07f4400c07f44fde6012019fde401fdf8014116fdab01fd50200f2000fd000000fdfa012010fde501fde6012018fde9012016fde801201afde6012019fde401fdf801fd502216fd5a000003200441286a2016fd5a000002200441186a2016fd5a000001200441086a2016fd5a0000002004413c6afd0c71aa34c471aa34c471aa34c471aa34c4fd0c71aa344471aa344471aa344471aa3444201e2018fd43fd5222162001fd00008004221a2001fd000000201d2015fd39fd52fde601fd0c001080440010804400108044001080442219fde401fdf801410afdab01fd0c00fc0f0000fc0f0000fc0f0000fc0f00fd4e201d4114fdab01fd5020162001fd00008008222b201a201d2014fd39fd52fde6012019fde401fdf801fd0cff030000ff030000ff030000ff030000221afd4efd50410afdab0120162001fd0000800c202b201d201bfd39fd52fde6012019fde401fdf801201afd4efd502216fd5a0000032004412c6a2016fd5a0000022004411c6a2016fd5a0000012004410c6a2016fd5a0000002002fd0000802c211d2002fd00008028211b2002fd00008024212b2002fd00008020212d2002fd0000801c21142002fd00008018211e2002fd00008014212e2002fd00008010212f2002fd0000800c2130200441b0106a2002fd0000800422162023fd4e2002fd00000022194110fdad012024fd4efd502019201cfd4e221a2025fde601fd6afdf801201a2019410dfdad012015fd4efdae012026fdae01410dfdad012027fdb701201a2028fd3afd52fd502016201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd524110fdab01fd502216fd5a000003200441a0106a2016fd5a00000220044190106a2016fd5a00000120044180106a2016fd5a000000200441b4106a2002fd000080082216201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd522030fde0012018fde901202ffde001fde901202efde001fde901201efde001fde9012014fde001fde901202dfde001fde901202bfde001fde901201bfde001fde901201dfde001fde901fd0cffff0f00ffff0f00ffff0f00ffff0f00fdae014114fdad01201ffdb9012029fdb601202afdae0122184110fdab0120164110fdad012024fd4efd50fd502002fd0000800c201720184114fdab01202cfdae01fde7012218fde601fd0c0000fec20000fec20000fec20000fec22216fde9012017fde801fd0c002000440020004400200044002000442219fde401fdf8014118fdab01fd50221afd5a000003200441a4106a201afd5a00000220044194106a201afd5a00000120044184106a201afd5a00000020044188106a213141002120410121210340203120204102746a222241306a20182020410b7420026a22204180186afd000000fde6012016fde9012017fde8012019fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4e2018202041801c6afd000000fde6012016fde9012017fde8012019fde401fdf8014118fdab01fd50201820204180146afd000000fde6012016fde9012017fde8012019fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4efd50201820204180106afd000000fde6012016fde9012017fde8012019fde401fdf801fd0cff000000ff000000ff000000ff000000fd4efd50221afd5a000003202241206a201afd5a000002202241106a201afd5a0000012022201afd5a00000020214101712122410021214101212020220d000b200441c0006a2104200341106a2103200241106a2102200141106a2101200041106a2100200d20136a210d201141fc00492122201141046a211120220d000b0b"});function mt(s){return typeof WebAssembly=="object"?new WebAssembly.Memory({initial:Math.ceil(s/2**16)}):null}function Le(s){if(s===null)return null;if(Pe===void 0)try{let t=to.match(/../g);Pe=new WebAssembly.Module(Uint8Array.from(t,n=>parseInt(n,16)))}catch{Pe=null}if(Pe===null)return null;let e=so.get(s);if(!e){let{exports:t}=new WebAssembly.Instance(Pe,{env:{memory:s}});e=t,so.set(s,e)}return e}var Pe,so,gt=M(()=>{"use strict";p();no();so=new WeakMap});function oo({contexts:s,alphabet:e,symbols:t,spans:n},o,r,i,a){we===void 0&&(we=mt(1));let c=Le(we);if(we===null||c===null)return;let l=o.length,f=Un+2*t.length,h=f+4*n.length,d=h+i.length,m=d+2*l+2,u=Math.ceil((m+2*a+2)/2**16)-we.buffer.byteLength/2**16;u>0&&we.grow(u);let{buffer:g}=we,w=new Uint32Array(g,0,2*l);o.forEach((v,E)=>w.set([v,m-2+2*r[E]],2*E)),new Uint16Array(g,Un,t.length).set(t),new Uint32Array(g,f,n.length).set(n),new Uint8Array(g,h,i.length).set(i);let y=(s>1?c.pull_contextual:c.pull_plain)(0,Un,f,e,h,d,l,Math.floor(a/l),a%l);return{decoded:new Uint16Array(g,m,a).slice(),left:y?(d-y)/2:-1/0,states:w.filter((v,E)=>E%2===0)}}var Un,we,ro=M(()=>{"use strict";p();gt();Un=2048});function be(s,e,t,n=!1){if(s.length<wt)throw new _("a rANS stream is too short to hold its header");let o=Y(s),r=o.getUint16(0,!0),i=o.getUint16(2,!0),a=o.getUint32(4,!0),c=o.getUint32(8,!0);if(r!==t)throw new _(`a rANS stream of ${r} symbols stands where ${t} belong`);if(i!==1&&i!==t||i>Qa)throw new _(`a rANS stream has ${i} contexts`);let l=ec(e);if(s.length!==wt+a+4*l+2*c)throw new _("a rANS stream is longer or shorter than its header says");let f=wt+a,h=nc(s.subarray(wt,f),i,t),d=new Uint32Array(l).map((y,v)=>o.getUint32(f+4*v,!0));if(d.some(y=>y<io))throw new _("a rANS stream starts in an impossible state");let m=Math.floor(e/l),u=e%l,g=d.map((y,v)=>v*m+Math.min(v,u)),w=[h,d,g,s.subarray(f+4*l),e],x=(n?void 0:oo(...w))??tc(...w);if(x.left===ao)throw new _("a rANS stream leads to a context that is not used: it is damaged");if(x.left<0)throw new _("a rANS stream ends early: the file is damaged");if(x.left>0||x.states.some(y=>y!==io))throw new _("a rANS stream does not end where it should: the file is damaged");return x.decoded}function ec(s){let e=Math.max(1,Math.floor(s/Ja));return Math.min(Za,1<<31-Math.clz32(e))}function tc({contexts:s,alphabet:e,symbols:t,spans:n},o,r,i,a){let c=o.length,l=Math.floor(a/c),f=a%c,h=new Uint16Array(a),d=i.length/2,m=new Uint16Array(d+1);new Uint8Array(m.buffer).set(i);let u=0;for(let g=0;g<=l;g++){let w=g<l?c:f,x=s>1&&g>0;for(let y=0;y<w;y++){let v=r[y]+g,E=x?h[v-1]:0,A=o[y],T=A&He-1,I=t[E<<bt|T],q=n[E*e+I];if(q===0)return{decoded:h,left:ao,states:o};let re=Math.imul(q&32767,A>>>bt)+T-(q>>>15)|0,F=(re>>>16)-1>>>31;o[y]=re<<16*F|m[u]&-F,u+=F,h[v]=I}}return{decoded:h,left:d-u,states:o}}function nc(s,e,t){let n=new me(s),o=new Uint16Array(e*He),r=new Uint32Array(e*t);for(let i=0;i<e;i++){if(!Ge(n,1))continue;let a=sc(n,t),c=i*He;for(let l=0;l<t;l++){let f=a[l];f!==0&&(r[i*t+l]=c%He<<15|f,o.fill(l,c,c+f),c+=f)}}if(!n.atEnd())throw new _("a rANS stream's frequency tables are longer than they should be");return{contexts:e,alphabet:t,symbols:o,spans:r}}function sc(s,e){let t=new Uint16Array(e),n=[];for(let a=0;a<e;a++)Ge(s,1)&&n.push(a);let o=Ge(s,4),r=n.pop(),i=He;for(let a of n){let c=o;for(;!Ge(s,1);)c++;if(c>bt)throw new _("a rANS stream's frequency table holds a number out of range");t[a]=Ge(s,c)+(1<<c)-(1<<o)+1,i-=t[a]}if(r===void 0||i<1)throw new _("a rANS stream's frequencies do not sum to 16384");return t[r]=i,t}function Ge(s,e){if(e>s.left)throw new _("a rANS stream's frequency tables end early");return s.take(e)}var bt,He,io,Qa,Za,Ja,wt,ao,vt=M(()=>{"use strict";p();ge();te();ro();bt=14,He=1<<bt,io=65536,Qa=64,Za=256,Ja=2048,wt=12,ao=-1/0});function In(s){return(s&31744)===31744}function P(s){let e=s>>10&31,t=(s&1023)+(e>0?1024:0);return(s&32768?-t:t)*oc[e]}function oe(s){lo[0]=s;let e=co[0]>>>16&32768,t=co[0]&2147483647;if(t<947912704){let n=Math.abs(s)*16777216,o=Math.round(n);return e|(o-n===.5&&o%2?o-1:o)}return e|Math.min(t+4095+(t>>>13&1)-939524096>>>13,31743)}function Cn(s,e){let t=rc(s,e);if(t.some(In))throw new _(`the stream '${s.name}' of the .mgs file has numbers that are not finite`);return Float32Array.from(t,P)}function rc({name:s,codec:e,data:t},n){let o=new _(`the stream '${s}' of the .mgs file has a wrong length`);if(e==="raw"){if(t.length!==2*n)throw o;return Uint16Array.from({length:n},(l,f)=>t[2*f]|t[2*f+1]<<8)}if(t.length<4)throw o;let r=4+Y(t).getUint32(0,!0);if(r>t.length||e==="halves"&&t.length!==r+n)throw o;let i=be(t.subarray(4,r),n,256),a=t.subarray(r),c=e==="planes"?be(a,n,256):a;return i.map((l,f)=>l<<8|c[f])}var oc,lo,co,ce=M(()=>{"use strict";p();ge();te();vt();oc=Float64Array.from({length:31},(s,e)=>2**(Math.max(e,1)-25)),lo=new Float32Array(1),co=new Uint32Array(lo.buffer)});function fo(s){let e=new Uint8Array(1);return{accuracy:0,symbols:Uint8Array.of(s),bits:e,bases:new Uint16Array(1)}}function qe(s,e){let t=1<<s,n={accuracy:s,symbols:new Uint8Array(t),bits:new Uint8Array(t),bases:new Uint16Array(t)},o=t;for(let[c,l]of e.entries())l===-1&&(n.symbols[--o]=c);let r=(t>>1)+(t>>3)+3,i=0;for(let[c,l]of e.entries())for(let f=0;f<l;f++){n.symbols[i]=c;do i=i+r&t-1;while(i>=o)}if(i!==0)throw new Error(W);let a=e.map(c=>Math.abs(c));for(let c=0;c<t;c++){let l=a[n.symbols[c]]++,f=s-(31-Math.clz32(l));n.bits[c]=f,n.bases[c]=(l<<f)-t}return n}function $n(s,e,t,n){let o=8*e,r=l=>{let f=o>>3,d=(s[f]|s[f+1]<<8|s[f+2]<<16)>>(o&7)&(1<<l)-1;return o+=l,d},i=5+r(4);if(i>t)throw new Error(W);let a=[];for(let l=1<<i;l>0;){let f=32-Math.clz32(l+1),h=(1<<f)-2-l,d=r(f-1);d>=h&&r(1)&&(d+=(1<<f-1)-h);let m=d-1;l-=Math.abs(m),a.push(m);for(let u=m===0?3:0;u===3;){u=r(2);for(let g=0;g<u;g++)a.push(0)}if(l<0||a.length>n)throw new Error(W)}let c=o+7>>3;if(c>s.length)throw new Error(W);return{table:qe(i,a),end:c}}function ho(s,e){let t=s[e++];if(!(t<128)){let l=t-127,f=e+(l+1>>1);if(!(f<=s.length))throw new Error(W);let h=d=>s[e+(d>>1)]>>(d%2?0:4)&15;return{weights:Array.from({length:l},(d,m)=>h(m)),end:f}}let n=e+t;if(n>s.length)throw new Error(W);let{table:o,end:r}=$n(s.subarray(0,n),e,6,13),i=new ve(s.subarray(r,n)),a=[],c=[i.take(o.accuracy),i.take(o.accuracy)];for(let l=0;a.length<255;l^=1){let f=c[l];if(a.push(o.symbols[f]),c[l]=o.bases[f]+i.take(o.bits[f]),i.left<0)return a.push(o.symbols[c[l^1]]),{weights:a,end:n}}throw new Error(W)}function uo(s){let e=c=>c>0?1<<c-1:0,t=0;for(let c of s)t+=e(c);let n=32-Math.clz32(t),o=(1<<n)-t;if(t===0||n>11||o&o-1)throw new Error(W);let r=[...s,32-Math.clz32(o)];if(r.length>256)throw new Error(W);let i={width:n,symbols:new Uint8Array(1<<n),bits:new Uint8Array(1<<n)},a=0;for(let c=1;c<=n;c++)for(let[l,f]of r.entries()){if(f!==c)continue;let h=a+e(c);i.symbols.fill(l,a,h),i.bits.fill(n+1-c,a,h),a=h}return i}var W,ve,po=M(()=>{"use strict";p();W="the compressed data is damaged or cut off",ve=class{left;#e;constructor(e){let t=e[e.length-1];if(!t)throw new Error(W);this.#e=e,this.left=8*e.length-1-Math.clz32(t)+24}take(e){return e>24?this.take(e-16)*65536+this.take(16):(this.left-=e,this.#t(this.left,e))}decode(e,{width:t,symbols:n,bits:o}){for(let r=0;r<e.length;r++){let i=this.#t(this.left-t,t);e[r]=n[i],this.left-=o[i]}if(this.left!==0)throw new Error(W)}#t(e,t){let n=this.#e;if(e<0)return e+t>0?this.#t(0,e+t)<<-e:0;let o=e>>3;return(n[o]|n[o+1]<<8|n[o+2]<<16|n[o+3]<<24)>>>(e&7)&(1<<t)-1}}});function wo(s,e){let t=[];for(let n of e)t.push(s),s+=2**n;return{bits:e,bases:t}}function bo(s,e){let t=new Dn(e),n=new DataView(s.buffer,s.byteOffset,s.byteLength),o=0;for(;o<s.length;){if(o+8>s.length)throw new Error(z);let r=n.getUint32(o,!0);if(r>>>4===ac)o+=8+n.getUint32(o+4,!0);else if(r===ic)o=lc(s,o+4,t);else throw new Error(z)}if(o!==s.length||t.length!==e)throw new Error(z);return t.bytes}function lc(s,e,t){let n=s[e++],o=(n&32)!==0;if(o||(e+=1),s.subarray(e,e+=[0,1,2,4][n&3]).some(a=>a))throw new Error("the compressed data needs a dictionary, which is missing");e+=[o?1:0,2,4,8][n>>6];let i={huffman:null,tables:[null,null,null],recent:[1,4,8]};for(let a=!1;!a;){if(e+3>s.length)throw new Error(z);let c=s[e]|s[e+1]<<8|s[e+2]<<16;e+=3,a=(c&1)===1;let l=c>>1&3,f=c>>3,h=l===1?1:f;if(l===3||f>Ve||e+h>s.length)throw new Error(z);l===0?t.append(s.subarray(e,e+f)):l===1?t.fill(s[e],f):fc(s.subarray(e,e+f),i,t),e+=h}return e+(n&4?4:0)}function fc(s,e,t){let{literals:n,end:o}=uc(s,e),r=o,i=s[r++];if(i===void 0)throw new Error(z);if(i===255?(i=s[r]+(s[r+1]<<8)+32512,r+=2):i>127&&(i=(i-128<<8)+s[r++]),i===0){t.append(n);return}let a=s[r++];if(!(i>0)||a===void 0||a&3)throw new Error(z);for(let[c,{accuracy:l,symbols:f,usual:h}]of cc.entries()){let d=a>>6-2*c&3;if(d===0)e.tables[c]=h;else if(d===1){if(!(s[r]<f))throw new Error(z);e.tables[c]=fo(s[r++])}else if(d===2){let{table:m,end:u}=$n(s,r,l,f);e.tables[c]=m,r=u}}hc(new ve(s.subarray(r)),i,n,e,t)}function hc(s,e,t,{tables:n,recent:o},r){let[i,a,c]=n;if(!i||!a||!c)throw new Error(z);let l=s.take(i.accuracy),f=s.take(a.accuracy),h=s.take(c.accuracy),d=0,m=r.length+Ve;for(let u=e;u>0;u--){let g=a.symbols[f],w=c.symbols[h],x=i.symbols[l],y=2**g+s.take(g),v=go.bases[w]+s.take(go.bits[w]),E=mo.bases[x]+s.take(mo.bits[x]);if(u>1&&(l=i.bases[l]+s.take(i.bits[l]),h=c.bases[h]+s.take(c.bits[h]),f=a.bases[f]+s.take(a.bits[f])),s.left<0||d+E>t.length)throw new Error(z);if(r.append(t.subarray(d,d+E)),d+=E,r.repeat(dc(y,E,o),v),r.length>m)throw new Error(z)}if(s.left!==0)throw new Error(z);r.append(t.subarray(d))}function dc(s,e,t){if(s>3)return t.unshift(s-3),t.pop(),t[0];let n=e===0?s:s-1,o=n<3?t[n]:t[0]-1;return n>0&&(t.splice(Math.min(n,2),1),t.unshift(o)),o}function uc(s,e){let t=s[0]|s[1]<<8|s[2]<<16,n=s[0]&3,o=s[0]>>2&3;if(n<2){let d=[1,2,1,3][o],m=d===1?s[0]>>3:(t&(d===2?65535:16777215))>>4,u=d+(n===0?m:1);if(m>Ve||!(u<=s.length))throw new Error(z);return n===0?{literals:s.subarray(d,u),end:u}:{literals:new Uint8Array(m).fill(s[d]),end:u}}let r=[3,3,4,5][o],i=[10,10,14,18][o],a=(t>>>0)+(s[3]??0)*2**24+(s[4]??0)*2**32,c=Math.floor(a/16)%2**i,l=Math.floor(a/2**(4+i))%2**i,f=r+l;if(c>Ve||!(f<=s.length))throw new Error(z);let h=r;if(n===2){let{weights:d,end:m}=ho(s.subarray(0,f),h);e.huffman=uo(d),h=m}if(e.huffman===null)throw new Error(z);return{literals:pc(s.subarray(h,f),c,o!==0,e.huffman),end:f}}function pc(s,e,t,n){let o=new Uint8Array(e);if(!t)return new ve(s).decode(o,n),o;if(s.length<6)throw new Error(z);let r=e+3>>2;for(let i=0,a=6;i<4;i++){let c=i<3?s[2*i]|s[2*i+1]<<8:s.length-a;if(a+c>s.length)throw new Error(z);let l=i<3?(i+1)*r:e;if(l>e)throw new Error(z);new ve(s.subarray(a,a+c)).decode(o.subarray(i*r,l),n),a+=c}return o}var ic,ac,Ve,z,mo,go,cc,Dn,vo=M(()=>{"use strict";p();po();ic=4247762216,ac=25481893,Ve=1<<17,z="the compressed data is damaged or cut off";mo=wo(0,[...Array(16).fill(0),1,1,1,1,2,2,3,3,4,6,7,8,9,10,11,12,13,14,15,16]),go=wo(3,[...Array(32).fill(0),1,1,1,1,2,2,3,3,4,4,5,7,8,9,10,11,12,13,14,15,16]),cc=[{accuracy:9,symbols:36,usual:qe(6,[4,3,2,2,2,2,2,2,2,2,2,2,2,1,1,1,2,2,2,2,2,2,2,2,2,3,2,1,1,1,1,1,-1,-1,-1,-1])},{accuracy:8,symbols:32,usual:qe(5,[1,1,1,1,1,1,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1])},{accuracy:9,symbols:53,usual:qe(6,[1,4,3,2,2,2,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1,-1,-1])}],Dn=class{length=0;bytes;#e;constructor(e){this.#e=e,this.bytes=new Uint8Array(Math.min(e,Ve))}reserve(e){let t=this.length+e;if(t>this.#e)throw new Error("the compressed data is longer than announced");if(t<=this.bytes.length)return;let n=new Uint8Array(Math.min(this.#e,Math.max(t,2*this.bytes.length)));n.set(this.bytes.subarray(0,this.length)),this.bytes=n}append(e){this.reserve(e.length),this.bytes.set(e,this.length),this.length+=e.length}fill(e,t){this.reserve(t),this.bytes.fill(e,this.length,this.length+t),this.length+=t}repeat(e,t){if(!(e>0&&e<=this.length))throw new Error(z);this.reserve(t);let{bytes:n}=this,o=this.length+t;if(e>=t)n.copyWithin(this.length,this.length-e,o-e);else for(let r=this.length;r<o;r++)n[r]=n[r-e];this.length=o}}});async function Eo(s){if(s[0]!==31){let r=_o(s,s.length);return xo(r,yc(r,s))}let{header:e,content:t}=await xc(s),n=[],o=xt;for(let r of Bn(e))n.push(t.subarray(o,o+=r));return xo(e,n)}function _o(s,e){let t=new DataView(s.buffer,s.byteOffset,s.byteLength);if(s.length<xt||t.getUint32(0,!0)!==mc)throw new Error("this is not a .spz file");let n=t.getUint32(4,!0),o=n<4;if(n<1||n>4)throw new Error(`the .spz file has version ${n}: 1 to 4 are read`);if(!o&&s.length<yo)throw new Error(xe);let r=t.getUint32(8,!0),[i,a,c,l]=s.subarray(12,16);if(r>gc)throw new Error(`the .spz file announces ${r} Gaussians, too many to be drawn`);if(r>e)throw new Error(`the .spz file announces ${r} Gaussians in ${e} bytes: it is cut off`);if(i>4||a>24)throw new Error(xe);let[f,h]=[(c&1)!==0,(c&2)!==0];return{version:n,count:r,degree:i,fraction:a,antialiased:f,extended:h,streams:l,table:o?0:t.getUint32(16,!0)}}function Bn({version:s,count:e,degree:t}){return[s===1?6:9,1,3,3,s<3?3:4,3*ko[t]].map(n=>n*e)}async function xc(s){let t=new Response(s).body.pipeThrough(new DecompressionStream("gzip")).getReader(),n=[],o=0,r=null,i=1/0,a=async()=>new Uint8Array(await new Blob(n).arrayBuffer());for(;o<=i;){let{value:c,done:l}=await t.read().catch(()=>{throw new Error(xe)});if(l)break;if(n.push(c),o+=c.length,r===null&&o>=xt){if(r=_o(await a(),s.length),r.version>3)throw new Error("this is not a .spz file");i=Bn(r).reduce((f,h)=>f+h,xt)}}if(r===null)throw new Error("this is not a .spz file");if(o>i&&(await t.cancel().catch(()=>{}),!r.extended))throw new Error("the .spz file holds more than it announces");if(o<i)throw new Error(`the .spz file is cut off: ${r.count} Gaussians were announced`);return{header:r,content:await a()}}function yc(s,e){let{streams:t,table:n,version:o}=s,r=Bn(s),i=n+16*t,a=r.filter(h=>h>0).length;if(o!==4||n<yo||i>e.length||t!==a)throw new Error(xe);let c=new DataView(e.buffer,e.byteOffset,e.byteLength),[l,f]=[n,i];return r.map(h=>{if(h===0)return new Uint8Array(0);let d=Number(c.getBigUint64(l,!0)),m=Number(c.getBigUint64(l+8,!0));if(l+=16,f+d>e.length||m!==h)throw new Error(xe);let u=e.subarray(f,f+=d);try{return bo(u,h)}catch(g){throw new Error(`${xe}: ${g instanceof Error?g.message:g}`)}})}function xo({version:s,count:e,degree:t,fraction:n,antialiased:o},r){let[i,a,c,l,f,h]=r,d=ko[t],m=Math.min(d,wc),u=m+1,g=zn(e,u,{...ae,antialiased:o}),w=new Float32Array(11+3*u),x=s===1?Ec(i):kc(i,2**-n),y=s<3?_c:Ac;for(let v=0;v<e;v++){w[0]=x(3*v),w[1]=-x(3*v+1),w[2]=-x(3*v+2);for(let A=0;A<3;A++)w[3+A]=l[3*v+A]/16-10;y(f,v,w);let E=Math.min(Math.max(a[v]/255,1e-6),1-1e-6);w[10]=Math.log(E/(1-E));for(let A=0;A<3;A++)w[11+A]=(c[3*v+A]/255-.5)/bc;for(let A=0;A<m;A++)for(let T=0;T<3;T++)w[14+3*A+T]=vc[A]*(h[3*(d*v+A)+T]-128)/128;Fn(g,w)}return g}function kc(s,e){return t=>{let n=3*t;return e*((s[n]<<8|s[n+1]<<16|s[n+2]<<24)>>8)}}function Ec(s){return e=>{let t=P(s[2*e]|s[2*e+1]<<8);if(!Number.isFinite(t))throw new Error(xe);return t}}function _c(s,e,t){let[n,o,r]=[0,1,2].map(a=>s[3*e+a]/127.5-1),i=Math.sqrt(Math.max(0,1-n*n-o*o-r*r));t.set([i,n,-o,-r],6)}function Ac(s,e,t){let n=4*e,o=s[n]|s[n+1]<<8|s[n+2]<<16|s[n+3]<<24,r=o>>>30,i=[0,0,0,0],a=1;for(let c=0,l=20;c<4;c++){if(c===r)continue;let f=(o>>l&511)/511*Math.SQRT1_2;i[c]=o>>l+9&1?-f:f,a-=f*f,l-=10}i[r]=Math.sqrt(Math.max(0,a)),t.set([i[3],i[0],-i[1],-i[2]],6)}var mc,gc,xt,yo,ko,wc,bc,vc,xe,Ao=M(()=>{"use strict";p();ce();Me();Nn();vo();mc=1347635022,gc=1e7,xt=16,yo=32,ko=[0,3,8,15,24],wc=15,bc=.15,vc=[-1,-1,1,-1,1,1,-1,1,-1,1,-1,-1,1,-1,1],xe="the .spz file is damaged or cut off"});var So={};ct(So,{readPly:()=>eo,readSpz:()=>Eo});var Mo=M(()=>{"use strict";p();Nn();Ao()});function Pn(){let s=URL.createObjectURL(new Blob([`${zo()}(${bundle})()`],{type:"text/javascript"}));return setTimeout(()=>URL.revokeObjectURL(s),6e4),new Worker(s)}function To(s,e){let t=globalThis.preloadedWorker;delete globalThis.preloadedWorker;let n;return t&&"url"in s&&t.url===s.url?(n=t.worker,t.messages.forEach(e)):(t?.worker.terminate(),n=Pn(),n.postMessage(s)),n.onmessage=e,n}async function Ro(){let s=globalThis.preloadedAdapter;return delete globalThis.preloadedAdapter,await s??navigator.gpu.requestAdapter({powerPreference:"high-performance"})}async function yt(s){return b[s]}function Lo(){return"0.1.0"}function Oo(){let s=document.getElementById("scene");if(s===null)return null;let e=atob(s.textContent),t=new Uint8Array(e.length);for(let n=0;n<t.length;n++)t[n]=e.charCodeAt(n);return new Blob([t])}var ye=M(()=>{p();le()});function Fo(s){return s?.soft_edge?1:1.4}function fe(s,e){let t=[[s,e]];for(let n=1;n<4;n++)t.push(t[n-1].map(o=>(o-(n===1?0:1)>>1)+2));return t}function he(s,e){let[,...t]=fe(s,e),n=[[0,0]],o=0;for(let[,r]of t)n.push([s,o]),o+=r;return{places:n,size:[s+t[0][0],Math.max(e,o)]}}var We=M(()=>{"use strict";p()});function No(s){let[e,t,n]=[1,2,3].map(c=>s[`hidden${c}.weight`]),o=["opacity","phi"].map(c=>({weights:Sc(s[`${c}.weight`],n,128),offset:s[`${c}.weight`].reduce((l,f,h)=>l+f*s["hidden3.bias"][h],s[`${c}.bias`][0])})),r=new Float32Array(16*2497),i=0,a=(c,l,f)=>{for(let h=c;h<c+4;h++)for(let d=l;d<l+4;d++)r[i++]=f(h,d)};for(let c=0;c<256;c+=4)for(let l=0;l<24;l+=4)a(c,l,(f,h)=>h<22?e[22*f+h]:h===22?s["hidden1.bias"][f]:0);for(let c=0;c<128;c+=4)a(c,0,(l,f)=>f===0?s["hidden2.bias"][l]:0);for(let c=0;c<256;c+=4)for(let l=0;l<128;l+=4)a(l,c,(f,h)=>t[256*f+h]);for(let c=0;c<128;c+=4)a(0,c,(l,f)=>o[l]?.weights[f]??0);return a(0,0,(c,l)=>l===0?o[c]?.offset??0:0),r}function Sc(s,e,t){return Array.from({length:t},(n,o)=>s.reduce((r,i,a)=>r+i*e[t*a+o],0))}var kt=M(()=>{"use strict";p()});function ze({packing:s,shSize:e,lobeSize:t,network:n}){return s?{shapes:4,colors:4,lobes:n?10:t+2>>1}:{shapes:12,colors:3*e,lobes:2*t}}function Uo(s){return P(s&65535)}var je=M(()=>{"use strict";p();ce();kt()});function Ke(s,e){let{fx:t,fy:n,cx:o,cy:r,width:i,height:a}=s;return{...s,fx:e*t,fy:e*n,cx:e*o,cy:e*r,width:e*i,height:e*a}}function _t(s,e,t,n,o){let{viewmat:r,fx:i,fy:a,cx:c,cy:l,width:f,height:h,near:d}=e,{background:m,weighting:u,packing:g,footprint:w=ae}=s,x=Io*.5*f/i,y=Io*.5*h/a,v=[0,1,2].map(F=>-(r[F]*r[3]+r[4+F]*r[7]+r[8+F]*r[11])),E=new Float32Array(Xe/4);E.set([...Array.from(r).slice(0,12),...v,d,i,a,c,l,-c/i-x,(f-c)/i+x,-l/a-y,(h-l)/a+y,...m,u.exponentMax,f,h,u.sigma,u.backgroundWeight,t]);let A=[s.count,s.shSize,s.lobeSize,u.index];if(new Int32Array(E.buffer).set(A,33),g){let{center:F,unit:X,leastScaleBits:ie,scaleBitsSpan:da}=g;E.set([...F,X,ie,da],40)}E[46]=!s.sorted&&u.alphaMin||1/255,E[47]=w.blur,new Int32Array(E.buffer).set([Number(w.antialiased),Number(w.soft_edge&&!s.sorted)],48),E[50]=n,new Int32Array(E.buffer)[51]=o;let T=fe(f,h),{places:I,size:q}=he(f,h),re=I.flatMap(([F,X],ie)=>[F,X,F+T[ie][0],X+T[ie][1]]);return E.set([...re,...q],52),E}var Xe,Et,Io,At=M(()=>{"use strict";p();Me();We();Xe=288,Et=2**-6,Io=.3});var St,Co=M(()=>{"use strict";p();St=class{milliseconds=null;#e;#t;#o=!1;#s=!1;#n=[];constructor(e){this.#e=e,this.#t=e.getExtension("EXT_disjoint_timer_query_webgl2")}start(){this.#s=this.#o&&!this.#n.length}pass(e){if(!this.#s)return;let[t,n]=[this.#e,this.#t.TIME_ELAPSED_EXT];if(this.#n.length&&t.endQuery(n),e){let o=t.createQuery();this.#n.push([e,o]),t.beginQuery(n,o)}else this.#s=!1}async time(){let e=this.#e;this.#o=this.#t!==null;let t=this.#n[this.#n.length-1];if(!t||this.#s)return;for(let o=0;o<100&&!e.getQueryParameter(t[1],e.QUERY_RESULT_AVAILABLE);o++)await new Promise(r=>setTimeout(r,5));let n=this.#n.map(([o,r])=>[o,e.getQueryParameter(r,e.QUERY_RESULT)/1e6]);e.getParameter(this.#t.GPU_DISJOINT_EXT)||(this.milliseconds=Object.fromEntries(n));for(let[,o]of this.#n.splice(0))e.deleteQuery(o)}forget(){this.#n=[],this.#s=!1}}});function Mt({color:s,side:e},{viewmat:t,fx:n,fy:o,cx:r,cy:i,width:a,height:c,near:l}){let[f,h,d]=[0,4,8].map(m=>Array.from(t).slice(m,m+4));return Float32Array.of(...f.map((m,u)=>2*(n*m+r*d[u])/a-d[u]),...h.map((m,u)=>d[u]-2*(o*m+i*d[u])/c),...d,...s,l,o*e/2,.002*c/2,2/a,2/c)}function Tt({means:s}){let e=new Float32Array(6*s.length);for(let t=0,n=0;t<s.length;t+=3)for(let o=n+18;n<o;n+=3)e[n]=s[t],e[n+1]=s[t+1],e[n+2]=s[t+2];return e}var Gn=M(()=>{"use strict";p()});function Ye(s){return[Math.max(1,Math.min(s,4096)),Math.max(1,Math.ceil(s/4096))]}var Rt,Lt,Hn=M(()=>{"use strict";p();Rt=["shapes","colors","lobes","looks","opacities","order","color_sums","weight_sums","color_sums_1","weight_sums_1","color_sums_2","weight_sums_2"],Lt=class{#e;#t=new Map;constructor(e){this.#e=e}make(e,t,[n,o]){let r=this.#e;r.deleteTexture(this.#t.get(e)??null);let i=r.createTexture();return this.#t.set(e,i),r.activeTexture(r.TEXTURE0+Rt.indexOf(e)),r.bindTexture(r.TEXTURE_2D,i),r.texStorage2D(r.TEXTURE_2D,1,t,n,o),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MIN_FILTER,r.NEAREST),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MAG_FILTER,r.NEAREST),i}upload(e,t,n){let o=this.#e,[r,,i]=t,a=Ye(n.length/i);if(a[1]>o.getParameter(o.MAX_TEXTURE_SIZE))throw new Error("the scene has more Gaussians than this GPU's textures can hold");this.make(e,o[r],a),this.write(e,t,0,n)}write(e,[,t,n],o,r){let i=this.#e,a=r instanceof Float32Array?i.FLOAT:i.UNSIGNED_INT,c=r.length/n;i.activeTexture(i.TEXTURE0+Rt.indexOf(e));for(let l=0;l<c;){let[f,h]=[(o+l)%4096,Math.floor((o+l)/4096)],d=Math.min(4096-f,c-l),m=d===4096?Math.floor((c-l)/4096):1,u=l*n;i.texSubImage2D(i.TEXTURE_2D,0,f,h,d,m,i[t],a,r,u),l+=d*m}}destroy(){for(let e of this.#t.values())this.#e.deleteTexture(e)}}});function Vn(s){return["EXT_color_buffer_float","EXT_float_blend"].every(e=>s.getExtension(e))}function Wn(s){for(let r of[...qn,"EXT_float_blend"])s.getExtension(r);let e=s.getExtension("WEBGL_provoking_vertex");e?.provokingVertexWEBGL(e.FIRST_VERTEX_CONVENTION_WEBGL),s.disable(s.DITHER);let t={view:s.createBuffer(),corners:s.createBuffer(),quads:s.createVertexArray(),looks:s.createFramebuffer(),sums:s.createFramebuffer(),enlarged:[s.createFramebuffer(),s.createFramebuffer()],programs:new Map,counters:new Map,textures:new Lt(s)};s.bindBufferBase(s.UNIFORM_BUFFER,$o,t.view),s.bufferData(s.UNIFORM_BUFFER,Xe,s.DYNAMIC_DRAW),s.bindVertexArray(t.quads),s.bindBuffer(s.ELEMENT_ARRAY_BUFFER,t.corners);let n=[0,1,2,2,1,3],o=Array.from({length:Ot},(r,i)=>n.map(a=>4*i+a));return s.bufferData(s.ELEMENT_ARRAY_BUFFER,Uint16Array.from(o.flat()),s.STATIC_DRAW),t}function Do(s,e,t){let{whole:n,project:o,splat:r,resolve:i}=e,a=t.packed?e.packed:e.wide,c=Po(s,e.view,t);return{project:c(n,`${a}${o}`),splat:c(`${a}${r}`,r),resolve:c(n,i),enlarge:t.leveled?[1,2].map(l=>c(n,`#define LEVEL ${l}
${i}`)):[]}}function Bo(s,{view:e,packed:t,wide:n,whole:o,count:r},i){return Po(s,e,i)(o,`#define VERTEX
${i.packed?t:n}${r}`)}function Po(s,e,{sorted:t,strips:n,leveled:o}){let i=Object.entries({SORTED:t,STRIPS:n,LEVELED:o}).map(([a,c])=>c?`#define ${a}
`:"").join("");return(a,c)=>{let l=jn(s,`${i}#define VERTEX
${e}${a}`,`${i}${e}${c}`);return s.useProgram(l),Rt.forEach((f,h)=>s.uniform1i(s.getUniformLocation(l,f),h)),s.uniformBlockBinding(l,s.getUniformBlockIndex(l,"View"),$o),l}}function jn(s,e,t){let n=s.createProgram();for(let[o,r]of[[s.VERTEX_SHADER,e],[s.FRAGMENT_SHADER,t]]){let i=s.createShader(o);s.shaderSource(i,`#version 300 es
${r}`),s.compileShader(i),s.attachShader(n,i),s.deleteShader(i)}if(s.linkProgram(n),!s.getProgramParameter(n,s.LINK_STATUS)&&!s.isContextLost()){let o=(s.getAttachedShaders(n)??[]).map(r=>s.getShaderInfoLog(r));throw o.push(s.getProgramInfoLog(n)),new Error(`this GPU refuses a shader: ${o.join(" ")}`)}return n}var Ot,$o,qn,Xn=M(()=>{"use strict";p();At();Hn();Ot=128,$o=0,qn=["EXT_color_buffer_float","EXT_color_buffer_half_float"]});var zt,Go=M(()=>{"use strict";p();Gn();Xn();zt=class{#e;#t=null;#o;#s;#n;#i=0;constructor(e,t){this.#e=e,this.#o=jn(e,`#define VERTEX
${t}`,t),this.#s=e.createVertexArray(),this.#n=e.createBuffer(),e.bindVertexArray(this.#s),e.bindBuffer(e.ARRAY_BUFFER,this.#n),e.enableVertexAttribArray(0),e.vertexAttribPointer(0,3,e.FLOAT,!1,0,0)}take(e){let[t,n]=[this.#e,e?Tt(e):new Float32Array(0)];this.#t=e,this.#i=n.length/3,t.bindBuffer(t.ARRAY_BUFFER,this.#n),t.bufferData(t.ARRAY_BUFFER,n,t.STATIC_DRAW)}draw(e){let[t,n]=[this.#e,this.#t];n&&(t.bindFramebuffer(t.FRAMEBUFFER,null),t.viewport(0,0,e.width,e.height),t.disable(t.BLEND),t.clearBufferfv(t.COLOR,0,[...n.background,1]),t.useProgram(this.#o),t.uniform4fv(t.getUniformLocation(this.#o,"dots"),Mt(n,e)),t.bindVertexArray(this.#s),t.drawArrays(t.TRIANGLES,0,this.#i))}destroy(){let e=this.#e;e.deleteProgram(this.#o),e.deleteVertexArray(this.#s),e.deleteBuffer(this.#n)}}});var Kn,qo,Wo,Tc,Vo,Ft,jo=M(()=>{"use strict";p();We();je();At();Co();Go();Xn();Hn();Kn=new Float32Array(0),qo={shapes:["RGBA32UI","RGBA_INTEGER",4],colors:["RGBA32UI","RGBA_INTEGER",4],lobes:["R32UI","RED_INTEGER",1]},Wo={shapes:["RGBA32F","RGBA",4],colors:["RGB32F","RGB",3],lobes:["RG32F","RG",2]},Tc={...Wo,colors:["RGB16F","RGB",3],lobes:["RG16F","RG",2]},Vo=["R32UI","RED_INTEGER",1],Ft=class s{static files=["view","wide","packed","whole","project","splat","resolve","count","dots"].map(e=>`${e}.glsl`);variant;levelSigma=0;supersampling=1;lost=null;onLost=()=>{};onRestored=()=>{};#e;#t;#o;#s=null;#n=qo;#i=null;#r=null;#a="";#c;#l=e=>{e.preventDefault(),this.#s=this.#i=null,this.lost="the browser took the GPU away from this page: reload it if no picture returns",this.onLost(this.lost)};#f=()=>{this.#s=null,this.#o=Wn(this.#e),this.#a="",this.#c.forget(),this.lost=null,this.onRestored()};static create(e,t,{floats:n=!1,strips:o=!1}={}){let r=e.getContext("webgl2",{alpha:!1,antialias:!1,depth:!1,powerPreference:"high-performance"});if(r===null)throw new Error("this browser cannot draw with WebGL2 here");if(!qn.some(i=>r.getExtension(i)))throw new Error("this GPU cannot draw into textures of floats");if(n&&!Vn(r))throw new Error("this GPU cannot blend 32-bit floats: use the variant halves");if(r.getParameter(r.MAX_TEXTURE_SIZE)<4096)throw new Error(`this GPU's textures are less than ${4096} pixels wide`);return new s(r,t,{floats:n,strips:o})}constructor(e,t,n){this.#e=e,this.#t=t,this.variant=n,this.#o=Wn(e),this.#c=new St(e),e.canvas.addEventListener("webglcontextlost",this.#l),e.canvas.addEventListener("webglcontextrestored",this.#f)}setScene(e){let t=this.#e;if(this.#s=this.#r=null,e.network)throw new Error("this scene needs a network for every Gaussian in every frame, which takes WebGPU: open it in a browser that has it");this.#n=e.packing?qo:this.variant.floats?Wo:Tc;let{shapes:n,colors:o,lobes:r}=e;for(let[a,c]of Object.entries({shapes:n,colors:o,lobes:r}))this.#o.textures.upload(a,this.#n[a],c);t.bindFramebuffer(t.FRAMEBUFFER,this.#o.looks);let i=e.packing?[t.RG32UI,0]:[t.RGBA32F,t.R32F];["looks","opacities"].forEach((a,c)=>{let l=i[c]?this.#o.textures.make(a,i[c],Ye(e.count)):null;t.framebufferTexture2D(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0+c,t.TEXTURE_2D,l,0)}),this.#E("textures of 32-bit numbers"),this.#s={...e,shapes:Kn,colors:Kn,lobes:Kn},e.sorted&&this.#o.textures.upload("order",Vo,Uint32Array.from({length:e.count},(a,c)=>c))}show(e){this.#s&&(this.#s.count=e)}update(e,t,n){if(this.#s===null)return;let o=this.#n[e];this.#o.textures.write(e,o,ze(this.#s)[e]/o[2]*t,n)}setDots(e){this.lost===null&&(this.#i??=new zt(this.#e,this.#t.dots),this.#i.take(e))}drawDots(e){this.#i&&(this.#u(e),this.#i.draw(e))}setOrder(e){if(this.#s!==null){if(e.length!==this.#s.count)throw new Error(`an order of ${e.length} Gaussians does not fit this scene`);this.#o.textures.write("order",Vo,0,e)}}draw(e){this.#s!==null&&(this.#u(e),this.#c.start(),this.#w(this.#s,e),this.#p(this.#s,e,null,e.height-1),this.#c.pass())}async drawUnseen(e){let t=this.#e;if(this.#s&&this.#w(this.#s,e),t.readBuffer(t.COLOR_ATTACHMENT0),t.readPixels(0,0,1,1,t.RGBA,t.FLOAT,new Float32Array(4)),t.isContextLost())throw new Error("the graphics device was lost")}get milliseconds(){return this.#c.milliseconds}async time(){this.lost===null&&await this.#c.time()}async finished(){this.#e.bindFramebuffer(this.#e.FRAMEBUFFER,null),this.#e.readPixels(0,0,1,1,this.#e.RGBA,this.#e.UNSIGNED_BYTE,new Uint8Array(4))}async fragments(){if(this.#s===null||this.#r===null)return null;let e=this.#e,{leveled:t,pixels:n}=this.#r,[o,r]=Ye(this.#s.count),[i,a]=[e.createFramebuffer(),e.createRenderbuffer()];e.bindFramebuffer(e.FRAMEBUFFER,i),e.bindRenderbuffer(e.RENDERBUFFER,a),e.renderbufferStorage(e.RENDERBUFFER,e.RGBA16F,o,r),e.framebufferRenderbuffer(e.FRAMEBUFFER,e.COLOR_ATTACHMENT0,e.RENDERBUFFER,a),e.disable(e.BLEND),e.viewport(0,0,o,r),e.useProgram(this.#d(this.#s,t)),e.drawArrays(e.TRIANGLES,0,3);let c=new Float32Array(4*o*r);e.readPixels(0,0,o,r,e.RGBA,e.FLOAT,c),e.deleteFramebuffer(i),e.deleteRenderbuffer(a);let l=new Array(t?4:1).fill(0);for(let f=0;f<c.length;f+=4)l[c[f+1]]+=c[f]**2/n;return l}get variants(){return(Vn(this.#e)?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}describe(){let e=this.#e,t=e.getExtension("WEBGL_debug_renderer_info");return String(e.getParameter(t?t.UNMASKED_RENDERER_WEBGL:e.RENDERER))}async pixels(e){if(this.#s===null)throw new Error("there is no scene to draw");let t=this.#e,{width:n,height:o}=e;this.#w(this.#s,e);let[r,i]=[t.createFramebuffer(),t.createRenderbuffer()];t.bindFramebuffer(t.FRAMEBUFFER,r),t.bindRenderbuffer(t.RENDERBUFFER,i),t.renderbufferStorage(t.RENDERBUFFER,t.RGBA32F,n,o),t.framebufferRenderbuffer(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0,t.RENDERBUFFER,i),this.#p(this.#s,e,r,0);let a=new Float32Array(4*n*o);return t.readPixels(0,0,n,o,t.RGBA,t.FLOAT,a),t.deleteFramebuffer(r),t.deleteRenderbuffer(i),a}destroy(){let e=this.#e,{view:t,corners:n,quads:o,looks:r,sums:i,enlarged:a,programs:c,counters:l,textures:f}=this.#o;this.#s=null,this.#i?.destroy(),e.canvas.removeEventListener("webglcontextlost",this.#l),e.canvas.removeEventListener("webglcontextrestored",this.#f),f.destroy();for(let h of c.values())for(let d of Object.values(h).flat())e.deleteProgram(d);for(let h of l.values())e.deleteProgram(h);for(let h of[r,i,...a])e.deleteFramebuffer(h);e.deleteVertexArray(o);for(let h of[t,n])e.deleteBuffer(h);e.getExtension("WEBGL_lose_context")?.loseContext()}#u({width:e,height:t}){let{canvas:n}=this.#e;n.width!==e&&(n.width=e),n.height!==t&&(n.height=t)}#w(e,t){let n=this.#e,o=t.width*t.height;t=Ke(t,this.supersampling);let{view:r,quads:i,looks:a,sums:c}=this.#o,l=this.#g(e,t),f=this.#y(e,l),[h,d]=this.#k(e.sorted,l,t);n.bindBuffer(n.UNIFORM_BUFFER,r),this.#r={leveled:l,pixels:o};let m=this.variant.floats?1:Et,u=_t(e,t,m,this.levelSigma,this.supersampling);n.bufferSubData(n.UNIFORM_BUFFER,0,u),n.bindVertexArray(i),n.disable(n.BLEND),n.bindFramebuffer(n.FRAMEBUFFER,a),n.drawBuffers([n.COLOR_ATTACHMENT0,e.packing?n.NONE:n.COLOR_ATTACHMENT1]);let[g,w]=Ye(e.count);if(n.viewport(0,0,g,w),n.useProgram(f.project),this.#c.pass("project"),n.drawArrays(n.TRIANGLES,0,3),n.bindFramebuffer(n.FRAMEBUFFER,c),n.viewport(0,0,h,d),n.enable(n.BLEND),n.useProgram(f.splat),this.#c.pass("splat"),e.sorted?(n.drawBuffers([n.COLOR_ATTACHMENT0]),n.clearBufferfv(n.COLOR,0,[0,0,0,0]),n.blendFunc(n.ONE,n.ONE_MINUS_SRC_ALPHA)):(n.drawBuffers([n.COLOR_ATTACHMENT0,n.COLOR_ATTACHMENT1]),n.clearBufferfv(n.COLOR,0,[0,0,0,1]),n.clearBufferfv(n.COLOR,1,[0,0,0,0]),n.blendFuncSeparate(n.ONE,n.ONE,n.ZERO,n.ONE_MINUS_SRC_ALPHA)),this.variant.strips)n.drawArraysInstanced(n.TRIANGLE_STRIP,0,4,e.count);else{let x=Math.ceil(e.count/Ot);n.drawElementsInstanced(n.TRIANGLES,6*Ot,n.UNSIGNED_SHORT,0,x)}}#p(e,t,n,o){let r=this.#e,i=Ke(t,this.supersampling),{resolve:a,enlarge:c}=this.#y(e,this.#g(e,i));r.disable(r.BLEND),this.#c.pass("resolve"),c.length&&this.#m(c,i),r.bindFramebuffer(r.FRAMEBUFFER,n),r.viewport(0,0,t.width,t.height),r.useProgram(a),r.uniform1i(r.getUniformLocation(a,"last_row"),o),r.drawArrays(r.TRIANGLES,0,3)}#m(e,{width:t,height:n}){let o=this.#e,r=fe(t,n);for(let i of[2,1])o.bindFramebuffer(o.FRAMEBUFFER,this.#o.enlarged[i-1]),o.viewport(0,0,r[i][0],r[i][1]),o.useProgram(e[i-1]),o.drawArrays(o.TRIANGLES,0,3)}#g({sorted:e},{width:t,height:n}){let o=this.#e.getParameter(this.#e.MAX_TEXTURE_SIZE);return this.levelSigma>0&&!e&&Math.max(...he(t,n).size)<=o}#k(e,t,{width:n,height:o}){let{floats:r}=this.variant,i=t?he(n,o).size:[n,o],a=`${n} ${o} ${e} ${t} ${r}`;if(a===this.#a)return i;let c=this.#e,l=c.getParameter(c.MAX_TEXTURE_SIZE);if(!(n>0&&n<=l&&o>0&&o<=l))throw new Error(`an image of ${n}x${o} pixels cannot be rendered: each side must lie between 1 and ${l}`);let f=r?[c.RGBA32F,c.R32F]:[c.RGBA16F,c.R16F],{sums:h,enlarged:d,textures:m}=this.#o,u=fe(n,o);return[h,...d].forEach((g,w)=>{let x=w?`_${w}`:"";c.bindFramebuffer(c.FRAMEBUFFER,g),["color_sums","weight_sums"].forEach((y,v)=>{let E=(w===0||t)&&!(e&&v>0),A=w===0?i:u[w],T=E?m.make(`${y}${x}`,f[v],A):null;c.framebufferTexture2D(c.FRAMEBUFFER,c.COLOR_ATTACHMENT0+v,c.TEXTURE_2D,T,0)}),w&&t&&c.drawBuffers([c.COLOR_ATTACHMENT0,c.COLOR_ATTACHMENT1]),(w===0||t)&&this.#E(`pictures of ${n}x${o} floats`)}),this.#a=a,i}#b({sorted:e,packing:t},n){return{sorted:e,packed:t!==null,strips:this.variant.strips,leveled:n}}#y(e,t){let{programs:n}=this.#o,o=this.#b(e,t),r=Object.values(o).join(" "),i=n.get(r)??Do(this.#e,this.#t,o);return n.set(r,i),i}#d(e,t){let{counters:n}=this.#o,o={...this.#b(e,t),strips:!1},r=Object.values(o).join(" "),i=n.get(r)??Bo(this.#e,this.#t,o);return n.set(r,i),i}#E(e){let t=this.#e;if(t.checkFramebufferStatus(t.FRAMEBUFFER)!==t.FRAMEBUFFER_COMPLETE&&!t.isContextLost())throw new Error(`this GPU cannot draw into ${e}`)}}});var Xo={};ct(Xo,{WebGlRenderer:()=>Ft,shaderText:()=>yt});var Ko=M(()=>{"use strict";p();ye();jo()});var Yo,Qe,Qo,Zo,Jo,er,Nt=M(()=>{"use strict";p();Yo=["en","de","zh","es","ja"],Qe={scene:"3D scene",keysHint:"Press H for the keys.",wake:"Show in 3D",hint:"Drag to look around",loading:"Loading",controls:"Controls",reset:"Back to the first view",share:"Share",settings:"Settings",help:"Help",full:"Full screen",window:"Leave full screen",close:"Close",background:"Background",own:"The scene's own",scale:"Resolution",automatic:"automatic",mode:"Dragging",orbit:"rotates the scene",fly:"looks around",walk:"walks",turning:"Rotate slowly",stats:"Show the frame rate",open:"Open a file",view:"Next camera",picture:"Save a picture",up:"Turn upright",device:"Rendered with {}",adapter:"Rendered with {} on {}",link:"Link to this view",copy:"Copy",copied:"Copied.",uncopied:"This browser does not allow copying: the text is selected, press Ctrl+C.",send:"Send\u2026",code:"QR code of the link",scan:"Scan it to open the scene on another device.",local:"This address works on this device only.",touch:"Touch",mouse:"Mouse",keys:"Keys",oneFinger:"One finger",twoFingers:"Two fingers",pinch:"Pinch",doubleTap:"Double tap",drag:"Drag",rightDrag:"Right button or Shift",wheel:"Wheel",doubleClick:"Double click",rotate:"rotate the scene",pan:"move sideways",zoom:"zoom in and out",focus:"look at that point",flyHelp:"fly; faster with Shift",modeHelp:"orbit, look around or walk",report:"Benchmark",results:"Results as JSON",failed:"The scene cannot be shown",offline:"There is no connection",retry:"Try again",drop:"Drop a scene to open it, or two to compare them",compared:"{} on the left, {} on the right",loaded:"{} Gaussians loaded.",axis:"The axis {} points up.",ownAxis:"The scene's own direction points up.",orbits:"Dragging rotates the scene.",flies:"Dragging looks around.",walks:"Walk with the stick or W A S D; dragging looks around."},Qo={scene:"3D-Szene",keysHint:"Taste H zeigt die Tasten.",wake:"In 3D zeigen",hint:"Ziehen, um sich umzusehen",loading:"L\xE4dt",controls:"Bedienung",reset:"Zur\xFCck zur ersten Ansicht",share:"Teilen",settings:"Einstellungen",help:"Hilfe",full:"Vollbild",window:"Vollbild beenden",close:"Schlie\xDFen",background:"Hintergrund",own:"Der der Szene",scale:"Aufl\xF6sung",automatic:"automatisch",mode:"Ziehen",orbit:"dreht die Szene",fly:"dreht den Blick",walk:"zum Gehen",turning:"Langsam drehen",stats:"Bildrate anzeigen",open:"Datei \xF6ffnen",view:"N\xE4chste Kamera",picture:"Bild speichern",up:"Aufrichten",device:"Gezeichnet mit {}",adapter:"Gezeichnet mit {} auf {}",link:"Link zu dieser Ansicht",copy:"Kopieren",copied:"Kopiert.",uncopied:"Dieser Browser erlaubt kein Kopieren: Der Text ist markiert, dr\xFCcken Sie Strg+C.",send:"Senden\u2026",code:"QR-Code des Links",scan:"Scannen \xF6ffnet die Szene auf einem anderen Ger\xE4t.",local:"Diese Adresse gilt nur auf diesem Ger\xE4t.",touch:"Ber\xFChrung",mouse:"Maus",keys:"Tasten",oneFinger:"Ein Finger",twoFingers:"Zwei Finger",pinch:"Zwei Finger spreizen",doubleTap:"Doppelt tippen",drag:"Ziehen",rightDrag:"Rechte Taste oder Umschalt",wheel:"Mausrad",doubleClick:"Doppelklick",rotate:"Szene drehen",pan:"seitw\xE4rts bewegen",zoom:"vergr\xF6\xDFern und verkleinern",focus:"diesen Punkt ansehen",flyHelp:"fliegen; mit Umschalt schneller",modeHelp:"Szene drehen, umsehen oder gehen",report:"Messung",results:"Ergebnisse als JSON",failed:"Die Szene kann nicht gezeigt werden",offline:"Keine Verbindung",retry:"Noch einmal versuchen",drop:"Eine Szene hier ablegen, oder zwei zum Vergleichen",compared:"{} links, {} rechts",loaded:"{} Gau\xDF-Funktionen geladen.",axis:"Die Achse {} zeigt nach oben.",ownAxis:"Die Richtung der Szene zeigt nach oben.",orbits:"Ziehen dreht die Szene.",flies:"Ziehen dreht den Blick.",walks:"Gehen mit dem Stick oder W A S D; Ziehen dreht den Blick."},Zo={scene:"\u4E09\u7EF4\u573A\u666F",keysHint:"\u6309 H \u952E\u67E5\u770B\u5FEB\u6377\u952E\u3002",wake:"\u4EE5 3D \u663E\u793A",hint:"\u62D6\u52A8\u4EE5\u73AF\u987E\u56DB\u5468",loading:"\u6B63\u5728\u52A0\u8F7D",controls:"\u63A7\u4EF6",reset:"\u56DE\u5230\u521D\u59CB\u89C6\u89D2",share:"\u5206\u4EAB",settings:"\u8BBE\u7F6E",help:"\u5E2E\u52A9",full:"\u5168\u5C4F",window:"\u9000\u51FA\u5168\u5C4F",close:"\u5173\u95ED",background:"\u80CC\u666F",own:"\u4F7F\u7528\u573A\u666F\u80CC\u666F",scale:"\u5206\u8FA8\u7387",automatic:"\u81EA\u52A8",mode:"\u62D6\u52A8\u65B9\u5F0F",orbit:"\u65CB\u8F6C\u573A\u666F",fly:"\u8F6C\u52A8\u89C6\u7EBF",walk:"\u884C\u8D70",turning:"\u7F13\u6162\u65CB\u8F6C",stats:"\u663E\u793A\u5E27\u7387",open:"\u6253\u5F00\u6587\u4EF6",view:"\u4E0B\u4E00\u4E2A\u76F8\u673A",picture:"\u4FDD\u5B58\u56FE\u7247",up:"\u8C03\u6574\u671D\u4E0A\u65B9\u5411",device:"\u4F7F\u7528 {} \u6E32\u67D3",adapter:"\u4F7F\u7528 {} \u6E32\u67D3\uFF0C\u8BBE\u5907\uFF1A{}",link:"\u5F53\u524D\u89C6\u89D2\u7684\u94FE\u63A5",copy:"\u590D\u5236",copied:"\u5DF2\u590D\u5236\u3002",uncopied:"\u6B64\u6D4F\u89C8\u5668\u4E0D\u5141\u8BB8\u590D\u5236\uFF1A\u6587\u5B57\u5DF2\u9009\u4E2D\uFF0C\u8BF7\u6309 Ctrl+C\u3002",send:"\u53D1\u9001\u2026",code:"\u94FE\u63A5\u7684\u4E8C\u7EF4\u7801",scan:"\u626B\u63CF\u4E8C\u7EF4\u7801\uFF0C\u5728\u5176\u4ED6\u8BBE\u5907\u4E0A\u6253\u5F00\u573A\u666F\u3002",local:"\u6B64\u5730\u5740\u4EC5\u5728\u672C\u8BBE\u5907\u4E0A\u6709\u6548\u3002",touch:"\u89E6\u6478",mouse:"\u9F20\u6807",keys:"\u952E\u76D8",oneFinger:"\u5355\u6307",twoFingers:"\u53CC\u6307",pinch:"\u53CC\u6307\u634F\u5408",doubleTap:"\u53CC\u51FB\u5C4F\u5E55",drag:"\u62D6\u52A8",rightDrag:"\u53F3\u952E\u6216 Shift",wheel:"\u6EDA\u8F6E",doubleClick:"\u53CC\u51FB",rotate:"\u65CB\u8F6C\u573A\u666F",pan:"\u5E73\u79FB",zoom:"\u653E\u5927\u6216\u7F29\u5C0F",focus:"\u770B\u5411\u8BE5\u70B9",flyHelp:"\u98DE\u884C\uFF1B\u6309\u4F4F Shift \u52A0\u901F",modeHelp:"\u65CB\u8F6C\u573A\u666F\u3001\u8F6C\u52A8\u89C6\u7EBF\u6216\u884C\u8D70",report:"\u6027\u80FD\u6D4B\u8BD5",results:"JSON \u683C\u5F0F\u7684\u7ED3\u679C",failed:"\u65E0\u6CD5\u663E\u793A\u573A\u666F",offline:"\u6CA1\u6709\u7F51\u7EDC\u8FDE\u63A5",retry:"\u91CD\u8BD5",drop:"\u62D6\u653E\u4E00\u4E2A\u573A\u666F\u4EE5\u6253\u5F00\uFF0C\u6216\u4E24\u4E2A\u4EE5\u6BD4\u8F83",compared:"\u5DE6\u4FA7\uFF1A{}\uFF0C\u53F3\u4FA7\uFF1A{}",loaded:"\u5DF2\u52A0\u8F7D {} \u4E2A\u9AD8\u65AF\u3002",axis:"{} \u8F74\u671D\u4E0A\u3002",ownAxis:"\u4F7F\u7528\u573A\u666F\u81EA\u8EAB\u7684\u671D\u4E0A\u65B9\u5411\u3002",orbits:"\u62D6\u52A8\u53EF\u65CB\u8F6C\u573A\u666F\u3002",flies:"\u62D6\u52A8\u53EF\u8F6C\u52A8\u89C6\u7EBF\u3002",walks:"\u7528\u6447\u6746\u6216 W A S D \u884C\u8D70\uFF1B\u62D6\u52A8\u53EF\u8F6C\u52A8\u89C6\u7EBF\u3002"},Jo={scene:"Escena 3D",keysHint:"Pulsa H para ver las teclas.",wake:"Mostrar en 3D",hint:"Arrastra para mirar alrededor",loading:"Cargando",controls:"Controles",reset:"Volver a la vista inicial",share:"Compartir",settings:"Ajustes",help:"Ayuda",full:"Pantalla completa",window:"Salir de pantalla completa",close:"Cerrar",background:"Fondo",own:"El de la escena",scale:"Resoluci\xF3n",automatic:"autom\xE1tica",mode:"Arrastrar",orbit:"gira la escena",fly:"gira la mirada",walk:"caminar",turning:"Girar despacio",stats:"Mostrar fotogramas por segundo",open:"Abrir un archivo",view:"C\xE1mara siguiente",picture:"Guardar una imagen",up:"Enderezar",device:"Dibujado con {}",adapter:"Dibujado con {} en {}",link:"Enlace a esta vista",copy:"Copiar",copied:"Copiado.",uncopied:"Este navegador no permite copiar: el texto est\xE1 seleccionado, pulsa Ctrl+C.",send:"Enviar\u2026",code:"C\xF3digo QR del enlace",scan:"Escan\xE9alo para abrir la escena en otro dispositivo.",local:"Esta direcci\xF3n solo funciona en este dispositivo.",touch:"Pantalla t\xE1ctil",mouse:"Rat\xF3n",keys:"Teclas",oneFinger:"Un dedo",twoFingers:"Dos dedos",pinch:"Pellizcar",doubleTap:"Tocar dos veces",drag:"Arrastrar",rightDrag:"Bot\xF3n derecho o May\xFAs",wheel:"Rueda",doubleClick:"Doble clic",rotate:"girar la escena",pan:"mover de lado",zoom:"acercar y alejar",focus:"mirar ese punto",flyHelp:"volar; m\xE1s r\xE1pido con May\xFAs",modeHelp:"girar la escena, la mirada o caminar",report:"Medici\xF3n",results:"Resultados en JSON",failed:"No se puede mostrar la escena",offline:"No hay conexi\xF3n",retry:"Intentar de nuevo",drop:"Suelta una escena para abrirla, o dos para compararlas",compared:"{} a la izquierda, {} a la derecha",loaded:"{} gaussianas cargadas.",axis:"El eje {} apunta hacia arriba.",ownAxis:"La direcci\xF3n propia de la escena apunta hacia arriba.",orbits:"Arrastrar gira la escena.",flies:"Arrastrar gira la mirada.",walks:"Camina con la palanca o con W A S D; arrastrar gira la mirada."},er={scene:"3D\u30B7\u30FC\u30F3",keysHint:"H\u30AD\u30FC\u3067\u64CD\u4F5C\u4E00\u89A7\u3092\u8868\u793A\u3057\u307E\u3059\u3002",wake:"3D\u3067\u8868\u793A",hint:"\u30C9\u30E9\u30C3\u30B0\u3057\u3066\u898B\u56DE\u3059",loading:"\u8AAD\u307F\u8FBC\u307F\u4E2D",controls:"\u64CD\u4F5C",reset:"\u6700\u521D\u306E\u8996\u70B9\u306B\u623B\u308B",share:"\u5171\u6709",settings:"\u8A2D\u5B9A",help:"\u30D8\u30EB\u30D7",full:"\u5168\u753B\u9762\u8868\u793A",window:"\u5168\u753B\u9762\u8868\u793A\u3092\u7D42\u4E86",close:"\u9589\u3058\u308B",background:"\u80CC\u666F",own:"\u30B7\u30FC\u30F3\u306E\u80CC\u666F",scale:"\u89E3\u50CF\u5EA6",automatic:"\u81EA\u52D5",mode:"\u30C9\u30E9\u30C3\u30B0\u306E\u52D5\u4F5C",orbit:"\u30B7\u30FC\u30F3\u3092\u56DE\u3059",fly:"\u8996\u7DDA\u3092\u52D5\u304B\u3059",walk:"\u6B69\u304F",turning:"\u3086\u3063\u304F\u308A\u56DE\u8EE2",stats:"\u30D5\u30EC\u30FC\u30E0\u30EC\u30FC\u30C8\u3092\u8868\u793A",open:"\u30D5\u30A1\u30A4\u30EB\u3092\u958B\u304F",view:"\u6B21\u306E\u30AB\u30E1\u30E9",picture:"\u753B\u50CF\u3092\u4FDD\u5B58",up:"\u4E0A\u5411\u304D\u3092\u5909\u66F4",device:"{}\u3067\u63CF\u753B",adapter:"{}\u3067\u63CF\u753B\uFF08{}\uFF09",link:"\u3053\u306E\u8996\u70B9\u3078\u306E\u30EA\u30F3\u30AF",copy:"\u30B3\u30D4\u30FC",copied:"\u30B3\u30D4\u30FC\u3057\u307E\u3057\u305F\u3002",uncopied:"\u3053\u306E\u30D6\u30E9\u30A6\u30B6\u30FC\u3067\u306F\u30B3\u30D4\u30FC\u3067\u304D\u307E\u305B\u3093\u3002\u9078\u629E\u4E2D\u306E\u6587\u5B57\u3092Ctrl+C\u3067\u30B3\u30D4\u30FC\u3057\u3066\u304F\u3060\u3055\u3044\u3002",send:"\u9001\u4FE1\u2026",code:"\u30EA\u30F3\u30AF\u306EQR\u30B3\u30FC\u30C9",scan:"\u8AAD\u307F\u53D6\u308B\u3068\u5225\u306E\u7AEF\u672B\u3067\u30B7\u30FC\u30F3\u3092\u958B\u3051\u307E\u3059\u3002",local:"\u3053\u306E\u30A2\u30C9\u30EC\u30B9\u306F\u3053\u306E\u7AEF\u672B\u3067\u306E\u307F\u6709\u52B9\u3067\u3059\u3002",touch:"\u30BF\u30C3\u30C1",mouse:"\u30DE\u30A6\u30B9",keys:"\u30AD\u30FC",oneFinger:"1\u672C\u6307",twoFingers:"2\u672C\u6307",pinch:"\u30D4\u30F3\u30C1",doubleTap:"\u30C0\u30D6\u30EB\u30BF\u30C3\u30D7",drag:"\u30C9\u30E9\u30C3\u30B0",rightDrag:"\u53F3\u30DC\u30BF\u30F3\u307E\u305F\u306FShift",wheel:"\u30DB\u30A4\u30FC\u30EB",doubleClick:"\u30C0\u30D6\u30EB\u30AF\u30EA\u30C3\u30AF",rotate:"\u30B7\u30FC\u30F3\u3092\u56DE\u3059",pan:"\u5E73\u884C\u79FB\u52D5",zoom:"\u62E1\u5927\u30FB\u7E2E\u5C0F",focus:"\u305D\u306E\u70B9\u3092\u898B\u308B",flyHelp:"\u79FB\u52D5\uFF08Shift\u3067\u901F\u304F\uFF09",modeHelp:"\u30B7\u30FC\u30F3\u306E\u56DE\u8EE2\u3001\u8996\u7DDA\u3001\u6B69\u884C\u306E\u5207\u308A\u66FF\u3048",report:"\u6027\u80FD\u6E2C\u5B9A",results:"\u7D50\u679C\uFF08JSON\uFF09",failed:"\u30B7\u30FC\u30F3\u3092\u8868\u793A\u3067\u304D\u307E\u305B\u3093",offline:"\u63A5\u7D9A\u304C\u3042\u308A\u307E\u305B\u3093",retry:"\u518D\u8A66\u884C",drop:"\u30B7\u30FC\u30F3\u3092\u30C9\u30ED\u30C3\u30D7\u3057\u3066\u958B\u304F\uFF082\u3064\u3067\u6BD4\u8F03\uFF09",compared:"\u5DE6\uFF1A{}\u3001\u53F3\uFF1A{}",loaded:"{}\u500B\u306E\u30AC\u30A6\u30B7\u30A2\u30F3\u3092\u8AAD\u307F\u8FBC\u307F\u307E\u3057\u305F\u3002",axis:"{}\u8EF8\u304C\u4E0A\u3067\u3059\u3002",ownAxis:"\u30B7\u30FC\u30F3\u672C\u6765\u306E\u5411\u304D\u304C\u4E0A\u3067\u3059\u3002",orbits:"\u30C9\u30E9\u30C3\u30B0\u3067\u30B7\u30FC\u30F3\u3092\u56DE\u3057\u307E\u3059\u3002",flies:"\u30C9\u30E9\u30C3\u30B0\u3067\u8996\u7DDA\u3092\u52D5\u304B\u3057\u307E\u3059\u3002",walks:"\u30B9\u30C6\u30A3\u30C3\u30AF\u307E\u305F\u306FW A S D\u3067\u6B69\u304D\u3001\u30C9\u30E9\u30C3\u30B0\u3067\u8996\u7DDA\u3092\u52D5\u304B\u3057\u307E\u3059\u3002"}});var tr={};ct(tr,{de:()=>Qo,es:()=>Jo,ja:()=>er,zh:()=>Zo});var nr=M(()=>{"use strict";p();Nt()});function Yn(s,e){let t=[];for(let n=1;n<=zc;n++){let o=s[n===1?e:`${e}.${n}`];if(typeof o!="string")break;t.push(o)}return t}function sr(s){let t=Yn(s,"path").flatMap(o=>o.split(";")).map(o=>{let r=o.trim().split(/\s+/),i=r.length===6&&r.every(a=>Oc.test(a))?r.map(Number):[];return{eye:i.slice(0,3),target:i.slice(3)}});return t.every(({eye:o,target:r})=>o.length===3&&U(L(r,o))>0)?t:[]}function or(s,e){let t=Math.min(Math.floor(e),Math.max(s.length-2,0)),n=e-t,o=f=>s[Math.min(Math.max(f,0),s.length-1)],[r,i,a,c]=[-1,0,1,2].map(f=>o(t+f)),l=f=>i[f].map((h,d)=>{let[m,u,g]=[r[f][d],a[f][d],c[f][d]],w=(u-m)/2,x=(g-h)/2,y=3*(u-h)-2*w-x;return h+n*(w+n*(y+n*(2*(h-u)+w+x)))});return{eye:l("eye"),target:l("target")}}function rr(s,e,t){let{eye:n,target:o}=s.pose;return ar(s,e,r=>{let i=Math.min(r/Rc,1),a=i*i*(3-2*i);return{key:or([{eye:n,target:o},t],a),last:i===1}})}function ir(s,e,t){let n=t.length-1;return ar(s,e,o=>{let r=(1-Math.cos(Math.PI*o/(Lc*n)))/2;return{key:or(t,n*r),last:!1}})}function ar(s,e,t){let n=performance.now(),o=new AbortController;for(let i of Fc)e.addEventListener(i,()=>o.abort(),{signal:o.signal,capture:!0});let r=()=>{if(o.signal.aborted)return;let{key:i,last:a}=t((performance.now()-n)/1e3),c=s.pose.copy();c.eye=i.eye,c.target=i.target,s.place(c),a?o.abort():requestAnimationFrame(r)};return r(),()=>o.abort()}var Rc,Lc,Oc,zc,Fc,cr=M(()=>{"use strict";p();K();Rc=.9,Lc=3,Oc=/^-?\d{1,12}(\.\d{1,12})?$/,zc=64,Fc=["pointerdown","wheel","keydown"]});function Ic(s){let e=t=>Array.isArray(t)&&t.length===3&&t.every(n=>Number.isFinite(n));return Yn(s,"annotations").flatMap(t=>{let n;try{n=JSON.parse(t)}catch{n=null}return(Array.isArray(n)?n:[]).filter(r=>e(r?.at)&&typeof r.text=="string"&&(!r.eye||e(r.eye)))})}function lr(s,e,t,n){let o=a=>{let c=s.getAttribute(a);return c===null?t.notes:{[a]:c}};e.querySelector(".annotations")?.remove();let r=Ic(o("annotations"));r.length&&new Qn(s,e,t,r);let i=sr(o("path"));n&&i.length>1&&!matchMedia(Nc).matches&&ir(t,s,i)}var Nc,Uc,Qn,fr=M(()=>{"use strict";p();cr();K();Nc="(prefers-reduced-motion: reduce)",Uc=`
.annotations { position: absolute; inset: 0; overflow: hidden; pointer-events: none; }
.annotations button { position: absolute; left: 0; top: 0; width: 28px; height: 28px; min-width: 0; min-height: 0; margin: -14px; padding: 0;
  border: 2px solid #fff; border-radius: 50%; background: #10131acc; color: #fff; font: 600 13px/1 system-ui, sans-serif;
  pointer-events: auto; cursor: pointer; }
.annotations button::after { content: ""; position: absolute; inset: -10px; border-radius: 50%; }
.annotations button[aria-expanded=true] { background: #fff; color: #10131a; }
.annotations button:focus-visible { outline: 3px solid #6cb6ff; outline-offset: 2px; }
.annotations p { position: absolute; left: 0; top: 0; box-sizing: border-box; width: max-content; max-width: min(300px, 80%);
  max-height: 45%; overflow: auto; margin: 0; padding: 10px 14px; border-radius: 10px; background: #10131aee; color: #f3f4f6;
  font: 15px/1.45 system-ui, sans-serif; white-space: pre-line; overflow-wrap: anywhere; pointer-events: auto; }`;Qn=class{#e=document.createElement("div");#t=document.createElement("p");#o;#s;#n;#i=-1;constructor(e,t,n,o){this.#o=n,this.#s=e;let r=this.#e;r.className="annotations";let i=document.createElement("style");i.textContent=Uc,this.#t.hidden=!0,this.#t.id="annotation",this.#t.setAttribute("role","status"),this.#n=o.map((c,l)=>{let f=document.createElement("button");return f.type="button",f.textContent=String(l+1),f.setAttribute("aria-label",`${l+1}: ${c.text.slice(0,80)}`),f.setAttribute("aria-expanded","false"),f.addEventListener("click",()=>this.#r(l===this.#i?-1:l)),{button:f,annotation:c}}),r.append(i,...this.#n.map(({button:c})=>c),this.#t),r.addEventListener("keydown",c=>{c.key==="Escape"&&this.#r(-1),(c.key==="Enter"||c.key===" ")&&c.stopPropagation()}),t.querySelector("canvas:last-of-type")?.after(r);let a=()=>{r.isConnected?this.#a():e.removeEventListener("frame",a)};e.addEventListener("frame",a),a(),n.redraw()}#r(e){if(this.#i=e,this.#n.forEach(({button:a},c)=>a.setAttribute("aria-expanded",String(c===e))),this.#t.hidden=e<0,e<0)return;let{at:t,text:n,eye:o}=this.#n[e].annotation;this.#t.textContent=n;let{pose:r}=this.#o,i=o??S(r.eye,L(t,r.target),1);U(L(t,i))>0&&rr(this.#o,this.#s,{eye:i,target:t}),this.#a()}#a(){let{clientWidth:e,clientHeight:t}=this.#e;if(!e||!t)return;let{viewmat:n,fx:o,fy:r,cx:i,cy:a,near:c}=this.#o.camera(e,t);this.#n.forEach(({button:l,annotation:{at:f}},h)=>{let[d,m,u]=[0,4,8].map(T=>O([n[T],n[T+1],n[T+2]],f)+n[T+3]),[g,w]=[o*d/u+i,r*m/u+a],x=u>c&&g>0&&g<e&&w>0&&w<t;if(l.style.visibility=x?"":"hidden",x&&(l.style.transform=`translate(${g}px, ${w}px)`),h!==this.#i)return;this.#t.hidden=!x;let{offsetWidth:y,offsetHeight:v}=this.#t,E=Math.min(Math.max(g-y/2,8),Math.max(e-y-8,8)),A=w+24+v<t?w+24:Math.max(w-24-v,8);this.#t.style.transform=`translate(${E}px, ${A}px)`})}}});function ur(s,e,t,n,o,r=null){let i=Math.tan((r??50)*Math.PI/360),a=r===null?e:null,c=a?t*a.K[0]/a.width:t/(2*i),l=a?n*a.K[4]/a.height:n/(2*i),f=r===null?s.box:null,h=f?Math.min(t/(2*f[0]),n/(2*f[1])):Math.sqrt(c*l),d={cx:t/2,cy:n/2};return{viewmat:s.viewmat(),fx:h,fy:h,...d,width:t,height:n,near:o}}function $c({viewmat:s}){let e=i=>[s[4*i],s[4*i+1],s[4*i+2]],[t,n,o]=[e(0),e(1),e(2)],r=S([0,0,0],t,-s[3]);return r=S(S(r,n,-s[7]),o,-s[11]),{eye:r,right:t,forward:o,down:n}}function Dc(s){let e=[.001,0,0,0,.001,0,0,0,.001],t=[0,0,0];for(let{eye:c,forward:l}of s){for(let f=0;f<3;f++)for(let h=0;h<3;h++)e[3*f+h]+=(f===h?1:0)-l[f]*l[h];t=S(S(t,c,1+.001/s.length),l,-O(l,c))}let n=c=>[e[c],e[3+c],e[6+c]],[o,r,i]=[n(0),n(1),n(2)],a=O(o,$(r,i));return[O(t,$(r,i))/a,O(o,$(t,i))/a,O(o,$(r,t))/a]}var hr,Cc,dr,C,Ut=M(()=>{"use strict";p();Te();K();hr=.02,Cc=[.42,.42],dr=.001,C=class s{constructor(e,t,n){this.eye=e,this.target=t,this.up=D(n),this.reach=U(L(t,e))||1,this.box=null}static fromStart({eye:e,target:t,box:n},o){let r=new s(e,t,o);return r.box=n,r}static fromViews(e,t=0,n=null){let o=e.map($c),{eye:r,forward:i}=o[t],a=O(L(Dc(o),r),i),c=Math.max(...o.map(l=>U(L(l.eye,r))),0)||1;return new s(r,S(r,i,a>dr*c?a:c),n??Ys(o))}static around(e,t=se){let n=[0,1,2].map(a=>{let c=e.filter((f,h)=>h%3===a).sort(),l=f=>c[Math.floor(f*(c.length-1))]??0;return[l(.15),l(.5),l(.85)]}),o=n.map(([,a])=>a),r=Math.max(...n.map(([a,,c])=>c-a))||1,i=new s(S(o,Be([0,-.3,-1],t),1.5*r),o,t);return i.box=Cc,i}get forward(){return D(L(this.target,this.eye))}get right(){return D($(this.forward,this.up))}copy(){let e=new s(this.eye,this.target,this.up);return e.reach=this.reach,e.box=this.box,e}orbit(e,t){let n=this.#e(L(this.eye,this.target),e,t);this.eye=S(this.target,n)}look(e,t){let n=this.#e(L(this.eye,this.target),e,t);this.target=L(this.eye,n)}move(e,t,n){let o=$(this.forward,this.right),r=S([0,0,0],this.right,e);r=S(S(r,o,t),this.forward,n),this.eye=S(this.eye,r),this.target=S(this.target,r)}walk(e,t){let n=D($(this.up,this.right)),o=S(S([0,0,0],this.right,e),n,t);this.eye=S(this.eye,o),this.target=S(this.target,o)}dolly(e){let t=L(this.eye,this.target),n=Math.max(U(t)*e,dr*this.reach);this.eye=S(this.target,D(t),n)}focus(e){U(L(e,this.eye))>0&&(this.target=e)}viewmat(){let{forward:e,right:t,eye:n}=this,o=$(e,t),r=i=>[...i,-O(i,n)];return[...r(t),...r(o),...r(e),0,0,0,1]}#e(e,t,n){let o=Math.acos(Math.min(1,Math.max(-1,O(D(e),this.up)))),r=Math.min(Math.max(o-n,hr),Math.PI-hr)-o;return Rn(Rn(e,this.right,r),this.up,-t)}}});function wr(s,e){let[,t,n,o]=/^(?:(\d+)(?:,|$))?(?:(\d+)x(\d+))?$/.exec(s)??[];return{seconds:Math.min(Math.max(Number(t)||60,1),3600),width:Math.min(Number(n)||e.width,8192),height:Math.min(Number(o)||e.height,8192)}}function mr(s,e,t){let{views:n}=s;if(n.length<2){let f=e.copy();return f.orbit(2*Math.PI*t/Zn,.2*Math.sin(6*Math.PI*t/Zn)),f}let o=Math.floor(t/Ct),[r,i]=[o,o+1].map(f=>C.fromViews(n,f%n.length)),a=t%Ct/Ct,c=S(r.eye,L(i.eye,r.eye),a),l=S(r.target,L(i.target,r.target),a);return new C(c,l,r.up)}async function br(s,e,t){let n=s.pose.copy(),o=document.hidden,r=()=>o||=document.hidden;document.addEventListener("visibilitychange",r),s.measured=!0;try{let i=await gr(),a=await qc(s,n,e,t),c=await gr();return{...a,battery:i&&c&&{start:i,end:c},interrupted:o}}finally{document.removeEventListener("visibilitychange",r),s.measured=!1,s.place(n)}}async function gr(){let s=await navigator.getBattery?.().catch(()=>null);return s?{percent:Math.round(100*s.level),charging:s.charging}:null}async function qc(s,e,{seconds:t,width:n,height:o},r){let i=[],a=[];for(let u=0;u<pr;u++)s.pose=mr(s,e,u),await s.drawAndWait(n,o);await s.passes();let c=performance.now(),l=[],f=0;for(let u=pr,g=0;g<1e3*t;u++){s.pose=mr(s,e,u);let w=performance.now()-c,x=await s.drawAndWait(n,o);if(g=performance.now()-c,i.push({from:w,to:g,order:x}),r(Math.min(1,g/(1e3*t))),g-f<Gc)continue;let y=await s.passes();if(y&&a.push({from:w,to:g,passes:{...y}}),g>Pc*l.length){let v=await s.fragments();v&&l.push(v)}await new Promise(v=>requestAnimationFrame(v)),f=performance.now()-c}let h=1e3*Math.min(Bc,t/2),d=i[i.length-1].to,m=u=>Vc(i.filter(u),a.filter(u));return{path:Hc(s),cold:m(({from:u})=>u<h),steady:m(({to:u})=>u>d-h),whole:m(()=>!0),fps_by_second:Array.from({length:t},(u,g)=>vr(i.filter(({to:w})=>Math.min(Math.floor(w/1e3),t-1)===g))),fragments:l.length?l[0].map((u,g)=>Jn(l.reduce((w,x)=>w+x[g],0)/l.length)):null}}function vr(s){let e=s.reduce((t,{from:n,to:o})=>t+o-n,0);return s.length?Jn(1e3*s.length/e):null}function It(s,e){let t=s.slice().sort((n,o)=>n-o);return Jn(t[Math.floor(e*(t.length-1))]??NaN)}function Vc(s,e){let t=s.map(({from:i,to:a})=>a-i),n=s.flatMap(({order:i})=>i??[]),o=[...new Set(e.flatMap(({passes:i})=>Object.keys(i)))],r=i=>It(e.flatMap(({passes:a})=>a[i]??[]),.5);return{frames:t.length,fps:vr(s)??NaN,milliseconds:It(t,.5),milliseconds95:It(t,.95),order:n.length?It(n,.5):null,passes:o.length?Object.fromEntries(o.map(i=>[i,r(i)])):null}}var Ct,Zn,pr,Bc,Pc,Gc,Hc,Jn,xr=M(()=>{"use strict";p();Ut();K();Ct=40,Zn=480,pr=10,Bc=10,Pc=1e3,Gc=250;Hc=({views:s})=>s.length<2?Zn:Ct*s.length;Jn=s=>Number(s.toFixed(2))});function _r(s,e){let t=new TextEncoder().encode(s),n=ts.findIndex((c,l)=>t.length<=Ar(l+1)-(l<9?2:3))+1;if(n===0)return null;let o=Yc(Xc(jc(t,n),n)),i=[...e===void 0?Er.keys():[e]].map(c=>Qc(n,o,c)),a=i.map(Zc);return i[a.indexOf(Math.min(...a))]}function Wc(s){let e=Sr(s).length,t=e?25*(e**2-3)+10*(2-e):0,n=17+4*s;return n**2-192-31-2*(n-16)-t-(s<7?0:36)}function Sr(s){if(s===1)return[];let e=(s/7|0)+2,t=2*Math.ceil((4*s+4)/(2*e-2)),n=10+4*s;return[6,...Array.from({length:e-1},(o,r)=>n-(e-2-r)*t)]}function jc(s,e){let{length:t}=s,o=[...e<10?[4,t>>4,t&15]:[4,t>>12,t>>8&15,t>>4&15,t&15],...[...s].flatMap(i=>[i>>4,i&15]),0],r=Array.from({length:o.length>>1},(i,a)=>16*o[2*a]+o[2*a+1]);for(let i=0;r.length<Ar(e);i++)r.push(i%2?17:236);return r}function Xc(s,e){let t=kr[e-1],n=t-s.length%t,o=Math.floor(s.length/t),r=Array.from({length:t},(c,l)=>{let f=l*o+Math.max(0,l-n);return s.slice(f,f+o+ +(l>=n))}),i=r.map(c=>Kc(c,ts[e-1])),a=c=>Array.from({length:Math.max(...c.map(l=>l.length))},(l,f)=>c.map(h=>h[f])).flat().filter(l=>l!==void 0);return[...a(r),...a(i)]}function es(s,e){let t=0;for(let n=7;n>=0;n--)t=t<<1^(t>>7)*285^(e>>n&1)*s;return t}function Kc(s,e){let t=[1];for(let o=0,r=1;o<e;o++,r=es(r,2))t=[...t,0].map((i,a)=>i^(a?es(t[a-1],r):0));let n=new Array(e).fill(0);for(let o of s){let r=o^n.shift();n.push(0),n.forEach((i,a)=>n[a]=i^es(t[a+1],r))}return n}function yr(s,e,t){let n=s;for(let o=0;o<e;o++)n=n<<1^(n>>e-1)*t;return s<<e|n}function Qc(s,e,t){let n=17+4*s,o=Array.from({length:n},()=>new Array(n)),r=(d,m,u)=>{o[m]&&d>=0&&d<n&&(o[m][d]=u)},i=(d,m,u,g)=>{for(let w=-u;w<=u;w++)for(let x=-u;x<=u;x++)r(d+x,m+w,g.includes(Math.max(Math.abs(x),Math.abs(w))))};for(let d=0;d<n;d++)r(6,d,d%2===0),r(d,6,d%2===0);for(let[d,m]of[[3,3],[n-4,3],[3,n-4]])i(d,m,4,[0,1,3]);let a=Sr(s),c=a.length-1;for(let[d,m]of a.entries())for(let[u,g]of a.entries())d===0&&(u===0||u===c)||d===c&&u===0||i(m,g,2,[0,2]);let l=yr(8|t,10,1335)^21522;for(let d=0;d<15;d++){let m=!!(l>>d&1);r(8,d<6?d:d<8?d+1:n-15+d,m),r(d<8?n-1-d:d===8?7:14-d,8,m)}r(8,n-8,!0);let f=yr(s,12,7973);for(let d=0;s>6&&d<18;d++){let m=!!(f>>d&1),[u,g]=[Math.floor(d/3),n-11+d%3];r(u,g,m),r(g,u,m)}let h=0;for(let d=n-1;d>0;d-=2){d===6&&(d=5);for(let m=0;m<n;m++){let u=d+1&2?m:n-1-m;for(let g of[d,d-1])o[u][g]===void 0&&(o[u][g]=(e[h++]??!1)!==Er[t](g,u))}}return o}function Zc(s){let e=s.length,t=0;for(let n=0;n<e;n++){let[o,r]=[0,0];for(let i=0;i<e;i++){o=i&&s[n][i]===s[n][i-1]?o+1:1,r=i&&s[i][n]===s[i-1][n]?r+1:1;for(let c of[o,r])t+=c===5?3:+(c>5);let a=s[n][i];n&&i&&[s[n-1][i],s[n][i-1],s[n-1][i-1]].every(c=>c===a)&&(t+=3)}}return t}var ts,kr,Er,Ar,Yc,Mr=M(()=>{"use strict";p();ts=[7,10,15,20,26,18,20,24,30,18,20,24,26,30,22,24,28,30,28,28],kr=[1,1,1,1,1,2,2,2,2,4,4,4,4,4,6,6,6,6,7,8],Er=[(s,e)=>(s+e)%2===0,(s,e)=>e%2===0,s=>s%3===0,(s,e)=>(s+e)%3===0,(s,e)=>((s/3|0)+(e>>1))%2===0,(s,e)=>s*e%2+s*e%3===0,(s,e)=>(s*e%2+s*e%3)%2===0,(s,e)=>((s+e)%2+s*e%3)%2===0];Ar=s=>(Wc(s)>>3)-ts[s-1]*kr[s-1];Yc=s=>s.flatMap(e=>[7,6,5,4,3,2,1,0].map(t=>!!(e>>t&1)))});var Tr={};ct(Tr,{parsePlan:()=>wr,qrCode:()=>_r,runBench:()=>br,showNotes:()=>lr});var Rr=M(()=>{"use strict";p();fr();xr();Mr()});var ns,Lr,Or,Fe,zo,le=M(()=>{"use strict";p();ns=()=>Promise.resolve().then(()=>(Mo(),So)),Lr=()=>Promise.resolve().then(()=>(Ko(),Xo)),Or=()=>Promise.resolve().then(()=>(nr(),tr)),Fe=()=>Promise.resolve().then(()=>(Rr(),Tr)),zo=()=>""});p();p();le();p();var Q=new Set,Ze=new Set;function zr(s,e){if(Q.delete(s),Q.size>=4){let t=[...Q],n=t.find(({inSight:o})=>o===!1)??(e?t[0]:void 0);if(!n)return Ze.add(s),!1;Q.delete(n),Ze.add(n),n.suspend()}return Ze.delete(s),Q.add(s),!0}function Fr(s){Q.delete(s),Ze.delete(s),Ir()}function Nr(s,e){s.inSight=e,Ir()}function Ur(s){Q.delete(s)&&Q.add(s)}function Ir(){for(let s of[...Ze]){let e=Q.size<4||[...Q].some(({inSight:t})=>t===!1);s.inSight&&e&&s.resume()}}p();var $t=()=>({name:"",before:"",failed:"",state:"",share:NaN,sentence:""}),Je=class{#e=[$t(),$t()];begin(e,t){let n=this.#e[e].name;this.#e[e]=t===void 0?$t():{...$t(),name:t,before:n,state:"loading"}}fail(e,t,n){let{name:o,before:r}=this.#e[e];this.note(e,{share:1,state:"failed",sentence:t,failed:this.names[e],name:n?r:o})}note(e,t){Object.assign(this.#e[e],t)}get state(){let e=this.#e.map(({state:n})=>n);return["failed","loading","loaded"].find(n=>e.includes(n))??""}get busy(){return this.#e.some(({state:e})=>e==="loading")}get share(){let e=this.#e.filter(({state:t})=>t).map(({share:t})=>t);return e.reduce((t,n)=>t+n,0)/e.length}get sentence(){let e=this.#e.every(({state:n})=>n),t=this.#e.map(({state:n,sentence:o,failed:r})=>n!=="failed"?"":e&&r&&!o.includes(r)?`${r}: ${o}`:o);return[...new Set(t.filter(Boolean))].join("; ")}get names(){return Jc(this.#e[0].name,this.#e[1].name)}};function Jc(s,e){let[t,n]=[s,e].map(o=>o.split("/").filter(Boolean));for(let o=1;o<=Math.max(t.length,n.length);o++){let[r,i]=[t,n].map(a=>a.slice(-o).map(ss).join("/"));if(r!==i)return[r,i]}return[ss(t[t.length-1]??""),ss(n[n.length-1]??"")]}function ss(s){try{return decodeURIComponent(s)}catch{return s}}p();var el=["pointermove","pointerdown","wheel","keydown","focusin"],tl=["pointerdown","wheel","keydown"],Dt=class{#e;#t=new Set;#o=0;#s=0;constructor(e,t){this.#e=t;let n={capture:!0,passive:!0};for(let o of el)e.addEventListener(o,()=>this.#n(),n);for(let o of tl)e.addEventListener(o,()=>this.#i(),n)}invite(e){this.#t.has(e)||(this.#t.add(e),this.#n(),this.#r("hint").hidden=!1,clearTimeout(this.#s),this.#s=setTimeout(()=>this.#i(),7e3))}setTitle(e,t){let n=this.#r("title"),o=[e,t];o.every((r,i)=>n.children[i].textContent===r)||(o.forEach((r,i)=>n.children[i].textContent=r),n.hidden=!e&&!t)}#n(){this.#e.classList.remove("idle"),clearTimeout(this.#o),this.#t.size&&(this.#o=setTimeout(()=>this.#e.classList.add("idle"),4e3))}#i(){this.#r("hint").hidden=!0}#r(e){return this.#e.querySelector(`.${e}`)}};p();function Bt(s){let e=s?.trim().toLowerCase()??"",t=/^([0-9a-f]{3}|[0-9a-f]{6})$/.test(e)?`#${e}`:e,n=/^#[0-9a-f]+$/.test(t)?t:nl(t),o=n.length===4?n.replace(/[^#]/g,"$&$&"):n;if(!/^#[0-9a-f]{6}$/.test(o))return null;let r=i=>Number.parseInt(o.slice(i,i+2),16)/255;return[r(1),r(3),r(5)]}function Cr(s){let e=t=>Math.round(255*Math.min(Math.max(t,0),1));return`#${s.map(t=>e(t).toString(16).padStart(2,"0")).join("")}`}function nl(s){let e=s?document.createElement("canvas").getContext("2d"):null;if(!e)return"";let[t,n]=["#000000","#ffffff"].map(o=>(e.fillStyle=o,e.fillStyle=s,String(e.fillStyle)));return t===n?t:""}p();p();le();var os=4,$r=()=>location.protocol.startsWith("http");async function rs(s){try{return await navigator.share(s),!0}catch(e){return e.name==="AbortError"}}var is=({hostname:s})=>/^(localhost|127\..*|\[::1\])$/.test(s);async function Dr(s){try{let e=(await Fe()).qrCode(s);if(!e)return"";let t=e.length+2*os,n=e.flatMap((o,r)=>o.flatMap((i,a)=>i?`M${a+os} ${r+os}h1v1h-1z`:[]));return`<svg viewBox="0 0 ${t} ${t}"><path d="${n.join("")}"/></svg>`}catch{return""}}var Br=["settings","help","share","report"],Pt=class{#e;#t=null;constructor(e){this.#e=e}toggle(e,t){let n=this.#n(e);return n.hidden=t===void 0?!n.hidden:!t,this.#e.querySelector(`[data-act=${e}]`)?.setAttribute("aria-expanded",String(!n.hidden)),!n.hidden}show(e){this.#o||(this.#t=this.#e.activeElement);let t=e!==null&&this.#n(e).hidden;for(let n of Br)this.toggle(n,t&&n===e);t?this.#n(e).focus():(this.#t??this.#e.querySelector("canvas"))?.focus({preventScroll:!0})}async copy(e){let t=this.#s(),n=navigator.clipboard?await navigator.clipboard.writeText(t).then(()=>!0,()=>!1):document.execCommand("copy");this.#n("sheet:not([hidden]) .copied").textContent=n?e.copied:e.uncopied}send(){let e=this.#s();rs(this.#o==="share"?{url:e}:{text:e})}async share(e){let{href:t}=location,n=this.#n("share");if(n.hidden&&"share"in navigator&&matchMedia("(pointer: coarse)").matches&&await rs({title:document.title,url:t}))return;let[r,i]=[n.querySelector("input"),this.#n("code")];r.value=t,this.#n("share .copied").textContent="",n.querySelector("[data-act=send]").hidden=!navigator.share,this.show("share"),i.innerHTML=is(location)?"":await Dr(t),i.hidden=!i.innerHTML,this.#n("about").textContent=is(location)?e.local:i.hidden?"":e.scan}get#o(){return Br.find(e=>!this.#n(e).hidden)}#s(){let e=this.#e.querySelector(".sheet:not([hidden]) :is(textarea, [readonly])");return e.focus(),e.select(),e.value}#n(e){return this.#e.querySelector(`.${e}`)}};p();Te();K();var as="none",sl=/^-?\d{1,12}(\.\d{1,12})?$/,de=24,Ne={angle:8,share:.25},Gt=Math.PI/180,ol=9,rl=.001;function cs(s){let e=typeof s=="string"?s.trim().split(/\s+/):[];return e.every(t=>sl.test(t))?e.map(Number):null}var Ht=(s,e)=>[s[e],s[e+1],s[e+2]];function Pr(s){let e=cs(s);if(e?.length!==8)return null;let[t,n]=[Ht(e,0),Ht(e,3)],[o,r]=e.slice(6);return t.every((i,a)=>i===n[a])||!(o>0&&r>0&&o<1e3&&r<1e3)?null:{eye:t,target:n,box:[o,r]}}function Gr(s){let e=cs(s);if(e?.length!==6+2*de)return null;let[t,n,o]=e.slice(3,6),r=e.slice(6);if(!(t>=0&&n>0&&n<=o)||r.some(c=>Math.abs(c)>90))return null;let i=Array.from({length:de},(c,l)=>r.slice(2*l,2*l+2)),a={pivot:Ht(e,0),pan:t,nearest:n,farthest:o,elevations:i};return i.some(([c,l])=>c<=l)?a:null}function il(s,e){let t=o=>O(s,Be(o,e)),n=Math.asin(Math.min(1,Math.max(-1,O(s,e))))/Gt;return[(Math.atan2(t([0,0,1]),t([1,0,0]))/Gt+360)%360,n]}function al(s,e,t){let[n,o]=[s*Gt,e*Gt];return Be([Math.cos(n)*Math.cos(o),-Math.sin(o),Math.sin(n)*Math.cos(o)],t)}var Hr=(s,e)=>((e-s+180)%360+360)%360-180;function cl({elevations:s},e){let t=s.map(([d,m])=>d<=m),n=e/360*de-.5,o=Math.floor(n),r=n-o,[i,a]=[(o+de)%de,(o+1)%de],c=r<.5?i:a;if(t[c]){let[d,m]=t[i]&&t[a]?[i,a]:[c,c],u=g=>(1-r)*s[d][g]+r*s[m][g];return[e,u(0),u(1)]}let[l,f,h]=[1/0,0,0];for(let d=0;d<2*de;d++){let m=360*(d+1>>1)/de,u=Math.abs(Hr(e,m));t[d>>1]&&u<l&&([l,f,h]=[u,d>>1,m])}return[h,s[f][0],s[f][1]]}function qr(s,e,t){return s.limits===as?null:(e<t?Gr(s.limits_portrait):null)??Gr(s.limits)}function Vr(s){let e=cs(s);if(e?.length!==4)return null;let t=Ht(e,0);return U(t)>0?D(t):null}function Wr(s,e,t){return(e<t?Pr(s.start_portrait):null)??Pr(s.start)}function ls(s,e,t,n){let o=0,r=(T,I)=>{let q=t(T,I);return o=Math.max(o,q/I),q},i=n==="orbit"?s.target:e.pivot,a=L(s.eye,i),c=U(a),{nearest:l,farthest:f,pan:h}=e,d=n==="orbit"?l:0;c>f?c=f+r(c-f,Ne.share*f):c<d&&(c=d-r(d-c,Ne.share*d));let[m,u]=il(D(a),s.up),[g,w,x]=cl(e,m),y=Hr(g,m);y&&(m=g+Math.sign(y)*r(Math.abs(y),Ne.angle)),u>x?u=x+r(u-x,Ne.angle):u<w&&(u=w-r(w-u,Ne.angle)),a=S([0,0,0],al(m,u,s.up),c);let v=L(s.target,s.eye);if(s.eye=S(i,a),n!=="orbit")return s.target=S(s.eye,v),o;let E=L(s.target,e.pivot),A=U(E);if(A>h){let T=(h+r(A-h,Ne.share*f))/A-1;s.target=S(s.target,E,T),s.eye=S(s.eye,E,T)}return o}function jr(s,e,t){ls(s,e,(n,o)=>o*(1-Math.exp(-n/o)),t)}function Xr(s,e,t,n){let o=Math.exp(-ol*n);return ls(s,e,(i,a)=>i<rl*a?0:i*o,t)>0}var Kr=(s,e)=>ls(s.copy(),e,t=>t,"orbit");p();var qt=(s,e,t)=>`M${s-t} ${e}a${t} ${t} 0 1 0 ${2*t} 0a${t} ${t} 0 1 0-${2*t} 0`,ll={reset:"M4 11.5l8-7 8 7M6.5 9.5V19.5h11V9.5",share:"M12 15V3.5M8 7.5l4-4 4 4M7 11.5H5v9h14v-9h-2",settings:`M4 8h7.5M16.5 8H20M4 16h3.5M12.5 16H20${qt(14,8,2.5)}${qt(10,16,2.5)}`,full:"M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5",window:"M9 4v5H4M20 9h-5V4M15 20v-5h5M4 15h5v5",help:`${qt(12,12,9)}M9.5 9.5a2.5 2.5 0 1 1 3.7 2.2c-.9.5-1.2 1-1.2 2M12 17v.01`,close:"M6.5 6.5l11 11M17.5 6.5l-11 11",drag:`M2.5 12.5c0 3.5 4 6 9.5 6s9.5-2.5 9.5-6M.5 14.5l2-2.5 2.5 2M19 14l2.5-2 2 2.5${qt(12,8,4)}`,wake:"M8 5l11 7-11 7z",alert:"M12 4.5L3 19.5h18zM12 10.5v4M12 17v.01"},ue=s=>`<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${ll[s]}"/></svg>`;p();le();Nt();function Yr(s){return[s.closest("[lang]")?.getAttribute("lang")??"",...navigator.languages].map(n=>n.toLowerCase().split("-")[0]).find(n=>Yo.includes(n))??"en"}async function Qr(s){if(s==="en")return Qe;try{return(await Or())[s]}catch{return Qe}}var ke=(s,...e)=>e.reduce((t,n)=>t.replace("{}",()=>n),s);function Vt(s,e){let t=e;for(let n of s.querySelectorAll("[data-text]"))n.textContent=t[n.dataset.text??""];for(let n of s.querySelectorAll("[data-name]")){let o=t[n.dataset.name??""];n.setAttribute("aria-label",o),n instanceof HTMLButtonElement&&(n.title=o+(n.dataset.key?` (${n.dataset.key})`:""))}}p();function Zr(s,e,t,n){let o=h=>s.querySelector(`[name=${h}]`);o("background").value=Cr(e.background);let r=o("scale"),i=e.scale??0;[...r.options].some(({value:h})=>Number(h)===i)||r.add(new Option(`${Math.round(100*i)} %`,String(i))),r.value=String(i),o("mode").value=e.mode,o("turning").checked=e.turning,o("stats").checked=t;let{renderer:a,adapter:c}=e.device,l=a?ke(c?n.adapter:n.device,a,c):"";s.querySelector(".device").textContent=l;let f=s.querySelector("[data-act=view]");f.hidden=e.views.length<2}function Jr(s,e){let{name:t,value:n}=s;t==="background"?e.background=Bt(n):t==="scale"?e.scale=Number(n)||null:t==="mode"?e.mode=n:t==="turning"&&(e.turning=s.checked),e.redraw()}p();function ei(s,e){let t=s.firstElementChild,n=null,o=(a,c)=>{t.style.transform=`translate(${a}px, ${c}px)`,e(a/44,-c/44)};s.addEventListener("pointerdown",a=>{a.preventDefault(),n=a.pointerId,s.setPointerCapture(n),r(a)});let r=a=>{if(a.pointerId!==n)return;let{left:c,top:l,width:f,height:h}=s.getBoundingClientRect(),[d,m]=[a.clientX-c-f/2,a.clientY-l-h/2],u=Math.min(1,44/(Math.hypot(d,m)||1));o(d*u,m*u)},i=a=>{a.pointerId===n&&(n=null,o(0,0))};s.addEventListener("pointermove",r),s.addEventListener("pointerup",i),s.addEventListener("pointercancel",i)}p();Ut();K();function Wt({eye:s,target:e,up:t}){let n=Math.min(20,Math.max(0,Math.ceil(4-Math.log10(U(L(e,s)))))),o=(r,i=n)=>r.map(a=>Number(a.toFixed(i))).join(",");return`eye=${o(s)}&at=${o(e)}&up=${o(t,5)}`}function jt(s){let e=new URLSearchParams(s.replace(/^#/,"")),t=["eye","at","up"].map(i=>(e.get(i)??"").split(",").map(Number));if(t.some(i=>i.length!==3||!i.every(Number.isFinite)))return null;let[n,o,r]=t;return n.every((i,a)=>i===o[a])?null:new C(n,o,r)}p();var Ue=.02,fl=new Map([["ArrowLeft",-Ue],["ArrowDown",-Ue],["ArrowRight",Ue],["ArrowUp",Ue],["PageDown",-5*Ue],["PageUp",5*Ue],["Home",-1],["End",1]]),Xt=class{share=.5;#e;#t;#o=["",""];constructor(e,t){this.#e=e,this.#t=t,e.onpointerdown=({pointerId:n})=>e.setPointerCapture(n),e.onpointermove=({pointerId:n,clientX:o})=>{if(!e.hasPointerCapture(n))return;let{left:r,width:i}=t.getBoundingClientRect();this.#s((o-r)/i)},e.onkeydown=n=>{let o=fl.get(n.key);o===void 0||n.ctrlKey||n.metaKey||n.altKey||(n.preventDefault(),this.#s(this.share+o))}}show(e,t){this.#o=e,this.#e.querySelectorAll("span").forEach((n,o)=>n.textContent=e[o]),this.#e.setAttribute("aria-label",ke(t,...e)),this.#e.hidden=!1,this.#t.classList.add("drawn"),this.#s(this.share)}#s(e){this.share=Math.min(Math.max(e,0),1);let t=Math.round(100*this.share);this.#t.style.clipPath=`inset(0 0 0 ${100*this.share}%)`,this.#e.style.left=`${100*this.share}%`,this.#e.setAttribute("aria-valuenow",String(t));let[n,o]=this.#o;this.#e.setAttribute("aria-valuetext",`${t} % ${n}, ${100-t} % ${o}`)}};p();var Kt=class{#e=[];lines(e){e.milliseconds&&(this.#e=[...this.#e.slice(-29),e.milliseconds]);let t=this.#e.reduce((o,r)=>o+r,0)/this.#e.length,n=[e.count,e.compared].filter((o,r)=>r===0||o);return[`${e.renderer}, ${e.width} x ${e.height}`,`${n.map(o=>o.toLocaleString("en")).join(" | ")} Gaussians`,this.#e.length?`${(1e3/t).toFixed(0)} frames/s, ${t.toFixed(1)} ms`:"still",...e.fragments?hl(e.fragments):[],...Object.entries(e.passes??{}).map(([o,r])=>`${o} ${r.toFixed(2)} ms`)].join(`
`)}};function hl(s){let e=o=>o.toFixed(1),t=s.reduce((o,r)=>o+r),n=[`${e(t)} fragments per pixel`];return s.length>1?[...n,`${s.map(e).join(" + ")} by level`]:n}p();p();var ti=':host{display:block;position:relative;overflow:hidden;contain:strict;container-type:size;color-scheme:light dark;min-height:120px;background:#0d0f12;color:var(--ink);--paper: #15171ce6;--ink: #f3f4f6;--dim: #c3c8d0;--line: #ffffff26;--field: #ffffff1f;--accent: #8ab8ff;--on: #0d1420;font:15px/1.45 system-ui,sans-serif;-webkit-text-size-adjust:100%;-webkit-tap-highlight-color:transparent;--top: calc(12px + env(safe-area-inset-top)) ;--bottom: calc(12px + env(safe-area-inset-bottom)) ;--start: calc(12px + env(safe-area-inset-left)) ;--end: calc(12px + env(safe-area-inset-right)) }:host(:dir(rtl)){--start: calc(12px + env(safe-area-inset-right)) ;--end: calc(12px + env(safe-area-inset-left)) }@media(prefers-color-scheme:light){:host{--paper: #fffffff0;--ink: #16181d;--dim: #474d58;--line: #0000001f;--field: #00000012;--accent: #0b57c9;--on: #fff}}[hidden]{display:none!important}canvas{opacity:0;display:block;width:100%;height:100%;touch-action:none;cursor:grab;outline:none}canvas.drawn{opacity:1;transition:opacity .3s}canvas.polite{touch-action:pan-y}canvas:active{cursor:grabbing}canvas.reached{outline:2px solid var(--accent);outline-offset:-2px}.over{position:absolute;inset:0;pointer-events:none}.panel{position:absolute;box-sizing:border-box;background:var(--paper);border-radius:14px;padding:12px 16px;box-shadow:0 0 0 1px var(--line),0 6px 24px #0003;backdrop-filter:blur(12px)}.panel:focus{outline:none}.split{position:absolute;top:0;bottom:0;width:20px;margin-left:-10px;cursor:ew-resize;touch-action:none;outline:none}.split:before{content:"";position:absolute;inset:0 9px;background:#fff;box-shadow:0 0 3px #000a}.split:after{content:"\\2039\\2002\\203a";position:absolute;top:50%;left:-12px;width:44px;height:44px;margin-top:-22px;border-radius:50%;background:var(--paper);line-height:40px;text-align:center;font-size:20px;box-shadow:0 0 0 2px #fff,0 0 5px 2px #000a}.split:focus-visible:after{box-shadow:0 0 0 3px var(--accent)}.split span{position:absolute;top:var(--top);padding:2px 8px;border-radius:6px;background:var(--paper);max-width:40cqw;overflow:hidden;text-overflow:ellipsis;white-space:nowrap}.split span:first-child{right:18px}.split span:last-child{left:18px}.bar{position:absolute;inset:0 0 auto;height:3px;background:#0006}.bar>div{height:100%;width:0;background:#8ab8ff;transition:width .15s}.bar.unknown>div{width:100%!important;animation:wait 1.2s ease-in-out infinite alternate}@keyframes wait{0%{opacity:.2}}.stats{top:var(--top);inset-inline-end:var(--end);padding:8px 12px;font:12px/1.5 ui-monospace,monospace;white-space:pre;unicode-bidi:plaintext;pointer-events:none}.split:not([hidden])~.stats{top:calc(var(--top) + 40px)}.said{top:var(--top);inset-inline:var(--start) var(--end);width:fit-content;max-width:calc(100% - 24px);margin-inline:auto;padding:8px 14px;pointer-events:none}.said:not(.seen){clip-path:inset(50%)}.chrome{position:absolute;inset:0;pointer-events:none;transition:inset .2s}.title{top:var(--top);inset-inline-start:var(--start);max-width:min(24em,calc(100% - 24px));padding:8px 14px;overflow-wrap:anywhere;transition:opacity .4s}.title>*{display:block}.title span{color:var(--dim);font-size:13px}.split:not([hidden])~.chrome .title{display:none}.foot{position:absolute;bottom:var(--bottom);inset-inline:var(--start) var(--end);pointer-events:none;display:flex;flex-direction:column;align-items:center;gap:12px}.foot>*{position:static;display:flex;align-items:center}.buttons{flex-wrap:wrap;justify-content:center;padding:4px;gap:2px;pointer-events:auto;transition:opacity .4s}.hint{gap:10px;padding:8px 16px;animation:rise .4s}.hint svg{color:var(--accent);flex:none}.idle:not(:has([aria-expanded=true])) :is(.title,.buttons):not(:has(:focus-visible)){opacity:0}@media(hover:none){.idle:not(:has([aria-expanded=true])) .buttons{pointer-events:none}}@media(hover:hover){.buttons:hover{opacity:1!important}}.sheet,.message{display:flex;flex-direction:column;padding:0;animation:rise .2s}.sheet{top:var(--top);bottom:var(--bottom);inset-inline-end:var(--end);margin-top:auto;width:min(380px,calc(100% - 24px));height:fit-content;max-height:calc(100% - 24px)}.report{width:min(34em,calc(100% - 24px))}.top{display:flex;align-items:center;justify-content:space-between;padding-block:8px 4px;padding-inline:20px 8px}.body{overflow:auto;overscroll-behavior:contain;padding:0 20px 20px}@keyframes rise{0%{opacity:0;translate:0 12px}}@container (min-width: 640px){.chrome:has([aria-expanded=true]){inset-inline-end:392px}}@container (max-width: 639.9px){.sheet{inset:auto 0 0;width:auto;max-height:min(72%,100% - 48px);border-radius:20px 20px 0 0;padding-bottom:env(safe-area-inset-bottom)}}.message{inset:0;margin:auto;width:fit-content;height:fit-content;max-width:min(30em,100% - 24px);max-height:94%;padding:20px;gap:10px;overflow:auto;overflow-wrap:anywhere}.message>svg{color:var(--accent);width:30px;height:30px;flex:none}.message p{margin:0;color:var(--dim)}h2{font-size:17px;line-height:1.3;margin:0}h3{font-size:13px;font-weight:600;color:var(--dim);margin:12px 0 6px}.help .body>:first-child h3{margin-top:0}dl{display:grid;grid-template-columns:fit-content(45%) 1fr;gap:6px 16px;margin:0}dt{font-weight:600}dd{margin:0;color:var(--dim)}dd:first-letter{text-transform:uppercase}kbd{font:12px/1.6 ui-monospace,monospace;padding:1px 6px;border-radius:5px;background:var(--field);white-space:nowrap}@container (max-width: 300px){dl{display:block}dd{margin-bottom:8px}}.touch,.mouse,.keys{display:none}@media(any-pointer:coarse){.touch{display:block}}@media(any-pointer:fine){.mouse,.keys{display:block}}.typed .keys{display:block}.sheet p{display:flex;flex-wrap:wrap;align-items:center;gap:8px;margin:0;min-height:52px}.sheet p>label{flex:1 1 5em}.sheet p+p{border-top:1px solid var(--line)}.sheet p>input:not([type]){flex:1;min-width:0}.acts{display:flex;flex-wrap:wrap;gap:8px}.body>.acts{margin-top:12px}.acts>*{flex:1 0 auto}small{display:block;font-size:13px;color:var(--dim);overflow-wrap:anywhere;margin-top:8px}small:empty{display:none}.code{background:#fff;border-radius:10px;width:min(196px,100%);margin:12px auto 0}.code svg{display:block;width:100%;height:auto;fill:#000;stroke:none;shape-rendering:crispEdges}.about{text-align:center}svg{width:24px;height:24px;fill:none;stroke:currentColor;stroke-width:1.8;stroke-linecap:round;stroke-linejoin:round}button,select,input:not([type]),[type=color]{font:inherit;color:inherit;background:var(--field);border:0;border-radius:10px;box-sizing:border-box;min-width:44px;min-height:44px;padding:0 12px;max-width:100%;touch-action:manipulation}button,select,[type=color],[type=checkbox]{cursor:pointer}select,input:not([type]){font-size:16px}.buttons button,.icon{display:grid;place-items:center;padding:0;width:44px;background:none}.buttons [aria-expanded=true]{background:var(--field);color:var(--accent)}.main{background:var(--accent);color:var(--on)}[type=color]{padding:8px;width:52px}[type=checkbox]{appearance:none;position:relative;width:46px;height:28px;margin:0;border-radius:14px;background:var(--field);box-shadow:inset 0 0 0 1.5px var(--dim)}[type=checkbox]:before{content:"";position:absolute;inset-block:5px;inset-inline-start:5px;width:18px;border-radius:9px;background:var(--dim);transition:inset-inline-start .15s}[type=checkbox]:checked{background:var(--accent);box-shadow:none}[type=checkbox]:checked:before{inset-inline-start:23px;background:var(--on)}@media(forced-colors:active){[type=checkbox]{appearance:auto}}@media(hover:hover){button:hover{background:var(--field);color:var(--accent)}.main:hover{background:var(--accent);color:var(--on);filter:brightness(1.1)}}:is(button,select,input,textarea):focus-visible{outline:2px solid var(--accent);outline-offset:1px}textarea{font:12px/1.3 ui-monospace,monospace;color:inherit;background:var(--field);border:0;border-radius:10px;box-sizing:border-box;width:100%;padding:10px;direction:ltr}.still{position:absolute;inset:0;width:100%;height:100%;pointer-events:none}.wake{position:absolute;inset:0;margin:auto;width:72px;height:72px;border-radius:50%;background:var(--paper)}.stick{position:absolute;inset-block-end:calc(var(--bottom) + 64px);inset-inline-start:var(--start);width:120px;height:120px;border-radius:50%;background:#0006;box-shadow:inset 0 0 0 2px #fff9;touch-action:none}.stick:not(.shown){display:none}.stick span{position:absolute;inset:34px;border-radius:50%;background:#fffd;box-shadow:0 1px 6px #0008}@media not (any-pointer:coarse){.stick{display:none}}.drop{inset:12px;border:2px dashed var(--accent);display:grid;place-items:center;text-align:center}@media(prefers-reduced-motion:reduce){*,:before{transition:none!important;animation:none!important}}';var dl={touch:[["oneFinger","rotate"],["twoFingers","pan"],["pinch","zoom"],["doubleTap","focus"]],mouse:[["drag","rotate"],["rightDrag","pan"],["wheel","zoom"],["doubleClick","focus"]]},ul=[["\u2190 \u2191 \u2193 \u2192","rotate"],["W A S D Q E","flyHelp"],["M","modeHelp"],["V","view"],["R","reset"],["U","up"],["F","full"],["P","picture"],["I","stats"],["O","settings"],["H","help"],["Esc","close"]],et=(s,e="")=>`<button data-act="${s}" data-name="${s}" ${e}>${ue(s)}</button>`,Z=(s,e=s,t="")=>`<button data-act="${s}" data-text="${e}" ${t}></button>`,Yt=(s,e)=>`
<div class="panel sheet ${s}" role="dialog" data-name="${s}" tabindex="-1" hidden>
<div class="top"><h2 data-text="${s}"></h2>
<button class="icon" data-act="close" data-name="close">${ue("close")}</button></div>
<div class="body">${e}</div>
</div>`,ni=s=>`<div class="${s}"><h3 data-text="${s}"></h3><dl>${dl[s].map(([e,t])=>`<dt data-text="${e}"></dt><dd data-text="${t}"></dd>`).join("")}</dl></div>`,pl=ul.map(([s,e])=>`<dt>${s.split(" ").map(n=>`<kbd>${n}</kbd>`).join(" ")}</dt><dd data-text="${e}"></dd>`),si=`
<style>${ti}</style>
<canvas tabindex="0" role="application"></canvas>
<div class="split" role="slider" tabindex="0" aria-valuemin="0" aria-valuemax="100" hidden>
<span></span><span></span>
</div>
<div class="stick" aria-hidden="true"><span></span></div>
<button class="wake" data-act="wake" data-name="wake" hidden>${ue("wake")}</button>
<div class="bar" role="progressbar" data-name="loading" hidden><div></div></div>
<div class="panel stats" hidden></div>
<div class="panel said" role="status"></div>
<div class="chrome">
<div class="panel title" hidden><strong dir="auto"></strong><span dir="auto"></span></div>
<div class="foot">
<div class="panel hint" aria-hidden="true" hidden>${ue("drag")}<span data-text="hint"></span></div>
<div class="panel buttons" role="group" data-name="controls">
${et("reset",'data-key="R"')}
${et("share",'aria-expanded="false"')}
${et("settings",'data-key="O" aria-expanded="false"')}
${et("help",'data-key="H" aria-expanded="false"')}
${et("full",'data-key="F"')}
</div>
</div>
</div>
${Yt("settings",`
<p><label for="mode" data-text="mode"></label><select id="mode" name="mode">
<option value="orbit" data-text="orbit"></option><option value="fly" data-text="fly"></option>
<option value="walk" data-text="walk"></option>
</select></p>
<p><label for="scale" data-text="scale"></label><select id="scale" name="scale">
<option value="0" data-text="automatic"></option><option value="1">100 %</option>
<option value="0.7">70 %</option><option value="0.5">50 %</option>
</select></p>
<p><label for="turning" data-text="turning"></label><input id="turning" type="checkbox" name="turning" /></p>
<p><label for="stats" data-text="stats"></label><input id="stats" type="checkbox" name="stats" /></p>
<p><label for="color" data-text="background"></label>${Z("own")}
<input id="color" type="color" name="background" /></p>
<div class="acts">${Z("open")}<input type="file" multiple hidden />
${Z("picture")}${Z("view")}${Z("up","up",'title="U"')}</div>
<small class="device"></small>`)}
${Yt("help",`${ni("touch")}${ni("mouse")}
<div class="keys"><h3 data-text="keys"></h3><dl>${pl.join("")}</dl></div>`)}
${Yt("share",`
<label for="link" data-text="link"></label>
<p><input id="link" readonly /><button data-act="copy" data-text="copy" class="main"></button></p>
<small class="copied" role="status"></small>
<div class="code" role="img" data-name="code"></div>
<small class="about"></small>
<div class="acts">${Z("send")}</div>`)}
${Yt("report",`
<textarea readonly rows="14" cols="44" data-name="results"></textarea>
<small class="copied" role="status"></small>
<div class="acts">${Z("copy")}${Z("send")}</div>`)}
<div class="panel message" hidden>${ue("alert")}<h2></h2><p role="alert"></p>
<div class="acts"><button class="main" data-act="retry" data-text="retry"></button>
${Z("open")}${Z("close")}</div></div>
<div class="panel drop" data-text="drop" hidden></div>`,fs=new Map(Object.entries({r:"reset",m:"mode",f:"full",h:"help",i:"stats",o:"settings",p:"picture",v:"view",u:"up"}));Nt();p();p();var oi=new Map([["KeyW",[0,0,1]],["KeyS",[0,0,-1]],["KeyA",[-1,0,0]],["KeyD",[1,0,0]],["KeyQ",[0,1,0]],["KeyE",[0,-1,0]]]),ri=new Map([["ArrowLeft",[-1,0]],["ArrowRight",[1,0]],["ArrowUp",[0,-1]],["ArrowDown",[0,1]]]),Qt=class{#e;#t;#o=new AbortController;#s=new Map;#n=new Set;#i=!1;stride=[0,0];#r={x:0,y:0,time:0};constructor(e,t){this.#e=e,this.#t=t;let n=(o,r)=>e.addEventListener(o,r,{signal:this.#o.signal,passive:!1});n("pointerdown",o=>this.#l(o)),n("pointermove",o=>this.#f(o)),n("pointerup",o=>this.#u(o)),n("pointercancel",o=>this.#u(o)),n("wheel",o=>this.#k(o)),n("contextmenu",o=>o.preventDefault()),n("keydown",o=>this.#b(o,!0)),n("keyup",o=>this.#b(o,!1)),n("blur",()=>this.#n.clear())}get busy(){return this.#n.size>0||this.stride.some(Boolean)}get held(){return this.busy||this.#s.size>0}advance(e){if(!this.busy)return;let n=.9*this.#t.pose().reach*e*(this.#i?4:1);for(let i of this.#n){let a=oi.get(i);a&&this.#a(a[0]*n,a[1]*n,a[2]*n);let c=ri.get(i);c&&this.#c(c[0]*1.5*e,c[1]*1.5*e)}let[o,r]=this.stride;(o||r)&&this.#a(o*n,0,r*n),this.#t.changed()}#a(e,t,n){let o=this.#t.pose();this.#t.mode()==="walk"?o.walk(e,n):o.move(e,t,n)}destroy(){this.#o.abort()}#c(e,t){let n=this.#t.pose();this.#t.mode()==="orbit"?n.orbit(e,t):n.look(e,t)}#l(e){this.#e.focus({preventScroll:!0}),this.#e.setPointerCapture(e.pointerId),this.#s.set(e.pointerId,{x:e.offsetX,y:e.offsetY});let{x:t,y:n,time:o}=this.#r,r=Math.hypot(e.offsetX-t,e.offsetY-n)<20,i=this.#s.size===1&&e.button===0;i&&r&&e.timeStamp-o<350&&this.#t.focus(e.offsetX,e.offsetY),this.#r={x:e.offsetX,y:e.offsetY,time:i?e.timeStamp:-1/0},this.#t.held(),e.preventDefault()}#f(e){let t=this.#s.get(e.pointerId);if(t===void 0)return;let n={x:e.offsetX,y:e.offsetY};Math.hypot(n.x-this.#r.x,n.y-this.#r.y)>6&&(this.#r.time=-1/0),this.#s.size===1?this.#w(n.x-t.x,n.y-t.y,e):this.#s.size===2&&this.#p(e.pointerId,n),this.#s.set(e.pointerId,n),this.#t.changed()}#u(e){this.#s.delete(e.pointerId)}#w(e,t,n){n.buttons&6||n.shiftKey||n.ctrlKey?this.#m(e,t):this.#c(e*.006,t*.006)}#p(e,t){let n=this.#s.get(e),o=[...this.#s].find(([a])=>a!==e)?.[1];if(n===void 0||o===void 0)return;let r=Math.hypot(n.x-o.x,n.y-o.y),i=Math.hypot(t.x-o.x,t.y-o.y);this.#t.mode()!=="orbit"?this.#a(0,0,2*(i-r)*this.#g):r>0&&i>0&&this.#t.pose().dolly(r/i),this.#m((t.x-n.x)/2,(t.y-n.y)/2)}#m(e,t){this.#a(-e*this.#g,-t*this.#g,0)}get#g(){let{target:e,eye:t}=this.#t.pose();return Math.hypot(...e.map((n,o)=>n-t[o]))/Math.max(this.#e.clientHeight,1)}#k(e){if(this.#e.classList.contains("polite")&&!e.ctrlKey&&!e.metaKey)return;e.preventDefault();let t=e.deltaMode===WheelEvent.DOM_DELTA_LINE?16:1,n=e.deltaY*t*(e.ctrlKey?8:1)*.0012,o=this.#t.pose();this.#t.mode()==="orbit"?o.dolly(Math.exp(n)):this.#a(0,0,-n*o.reach),this.#t.changed()}#b(e,t){let{code:n}=e;if(this.#i=e.shiftKey,!t&&n.startsWith("Meta")&&this.#n.clear(),t&&(e.ctrlKey||e.metaKey||e.altKey)||!oi.has(n)&&!ri.has(n))return;let o=t&&!this.#n.has(n);t?this.#n.add(n):this.#n.delete(n),o&&this.advance(.03),this.#t.changed(),e.preventDefault()}};p();ye();p();function Zt(s,[e,t,n]){let o=s.length/3,r=new Float32Array(o);for(let l=0;l<o;l++)r[l]=e*s[3*l]+t*s[3*l+1]+n*s[3*l+2];let i=new Uint32Array(r.buffer);for(let l=0;l<o;l++)i[l]=i[l]&2147483648?i[l]:~i[l]&2147483647;let a=Uint32Array.from({length:o},(l,f)=>f),c=new Uint32Array(o);for(let l of[0,16]){let f=new Uint32Array(65537);for(let h=0;h<o;h++)f[(i[h]>>>l&65535)+1]+=1;for(let h=0;h<65536;h++)f[h+1]+=f[h];for(let h=0;h<o;h++){let d=a[h];c[f[i[d]>>>l&65535]++]=d}[a,c]=[c,a]}return a}p();ge();te();ce();vt();var ml=49,Ee=24,Jt=Uint32Array.from({length:4096},(s,e)=>{let t=0;for(let n=0;n<12;n++)t|=(e>>>n&1)<<10*(n%3)+Math.floor(n/3);return t});function ii(s,e){let t=s.length<4?1/0:4+Y(s).getUint32(0,!0);if(t>s.length)throw new _("the stream of positions is too short to hold what its header says");let n=be(s.subarray(4,t),e,ml),o=0;for(let l=0;l<e;l++)o+=Math.max(n[l]-1,0);let r=Re(s.subarray(t),o),i=new Uint16Array(3*e),a=0,c=0;for(let l=0;l<e;l++){let f=n[l]-1;if(f>=Ee?(a+=r.take(Ee),c+=(1<<f-Ee)+r.take(f-Ee)):f>=0&&(a+=(1<<f)+r.take(f)),c+=a>>>Ee,a&=(1<<Ee)-1,c>>>Ee)throw new _("the stream of positions leaves its 48-bit grid");let h=Jt[a&4095]|Jt[a>>>12]<<4,d=Jt[c&4095]|Jt[c>>>12]<<4;for(let m=0,u=0;m<3;m++,u+=10){let g=h>>>u&255|(d>>>u&255)<<8,w=g&32768?g&32767:g^65535;if(In(w))throw new _("the stream of positions holds numbers that are not finite");i[3*l+m]=w}}return i}function ai(s,e){let t=3*Math.ceil(s.length/3/e);if(t<=3)return s;let n=new Uint16Array(3*Math.ceil(s.length/t));for(let o=0,r=0;o<s.length;o+=t,r+=3)n.set(s.subarray(o,o+3),r);return n}function hs(s,{center:e,radius:t,exponent:n}){let o=new Float32Array(s.length),r=t*2**n;for(let i=0;i<s.length;i++)o[i]=e[i%3]+Math.fround(r*P(s[i]));return o}function en(s){return"stored"in s?hs(s.stored,s.grid):s}p();var gl={from:64,to:65536,times:4},wl={from:32,to:1024,times:2},ci=128,fi="mobilegs variant 1";function hi(s,e){let t=null;try{t=e?.getItem(`${fi} ${s.describe()}`)??null}catch{}return s.variants.find(n=>mi(n)===t)??null}async function di(s,e){let t={floats:!1,strips:!1},n={...t};if(await li(s,t,{...t,strips:!0},gl,bl)&&(n.strips=!0),s.variants.some(({floats:o})=>o)){let o={...n,floats:!0};await li(s,n,o,wl,vl)&&(n.floats=!0)}try{e?.setItem(`${fi} ${s.describe()}`,mi(n))}catch{}return n}async function ui(s){s.setScene({...ds(1,1,()=>[0,0,1]),packing:{center:[0,0,0],unit:1,leastScaleBits:0,scaleBitsSpan:0},shapes:Uint32Array.of(0,15360,0,0),colors:new Uint32Array(4),shSize:4,lobes:new Uint32Array(5),lobeSize:9}),await s.drawUnseen(us(1))}function pi(s){s.setDots({means:Float32Array.of(0,0,1),color:[0,0,0],side:1,background:[0,0,0]}),s.drawDots(us(1)),s.setDots(null)}var mi=({floats:s,strips:e})=>`${s} ${e}`;async function li(s,e,t,{from:n,to:o,times:r},i){let a=0;for(let c=n;;c*=r){let{scene:l,side:f}=i(c);s.setScene(l);let h=[1/0,1/0];for(let m=0;m<=3;m++)for(let[u,g]of[e,t].entries()){s.variant=g;let w=performance.now();await s.drawUnseen(us(f)),m>0&&(h[u]=Math.min(h[u],performance.now()-w))}let d=Math.max(...h);if(c===n&&(a=d),d>Math.max(4,3*a)||c>=o)return h[1]<.85*h[0]}}function bl(s){let e=Math.ceil(Math.sqrt(s)),t=o=>2*(o+.5)/e-1;return{scene:ds(s,.001,o=>[t(o%e),t(Math.floor(o/e)),1]),side:256}}function vl(s){return{scene:ds(ci,1,e=>[0,0,1+e/ci]),side:s}}function ds(s,e,t){let n=new Float32Array(12*s);for(let o=0;o<s;o++){let[r,i,a]=t(o);n.set([e,0,0,r,0,e,0,i,0,0,e,a],12*o)}return{count:s,packing:null,shapes:n,colors:new Float32Array(3*s),shSize:1,lobes:new Float32Array(2*s).fill(1),lobeSize:1,sorted:!1,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},background:[0,0,0]}}function us(s){return{viewmat:[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],fx:s/2,fy:s/2,cx:s/2,cy:s/2,width:s,height:s,near:.1}}We();p();ye();le();p();ce();We();je();At();kt();p();Gn();var tn=class{#e;#t;#o;#s;#n;#i;constructor(e,t,n){let{device:o}=e;this.#e=o,this.#t=t,this.#o=e.dots(n);let{UNIFORM:r,VERTEX:i,COPY_DST:a}=GPUBufferUsage;this.#s=o.createBuffer({size:80,usage:r|a});let c=Tt(t);this.#i=c.length/3,this.#n=e.filled(c,i)}draw(e,t){let[n,o,r]=[this.#e,this.#o,this.#t];n.queue.writeBuffer(this.#s,0,Mt(r,e));let i=n.createCommandEncoder(),a=i.beginRenderPass({colorAttachments:[{view:t,loadOp:"clear",storeOp:"store",clearValue:[...r.background,1]}]}),c=[{binding:0,resource:{buffer:this.#s}}];a.setPipeline(o),a.setBindGroup(0,n.createBindGroup({layout:o.getBindGroupLayout(0),entries:c})),a.setVertexBuffer(0,this.#n),a.draw(this.#i),a.end(),n.queue.submit([i.finish()])}destroy(){this.#s.destroy(),this.#n.destroy()}};p();ye();var pe=128,gi={srcFactor:"one",dstFactor:"one-minus-src-alpha",operation:"add"},yl={color:gi,alpha:gi},kl={color:{srcFactor:"one",dstFactor:"one",operation:"add"},alpha:{srcFactor:"zero",dstFactor:"one-minus-src-alpha",operation:"add"}},wi=["float32-blendable","float32-filterable"],tt=["network","project","splat","resolve"],nn=class s{milliseconds=null;#e;#t=new Map;#o=new Map;#s=null;static async create(e,t){if(!("gpu"in navigator))throw new Error("this browser has no WebGPU on this page: it may need https, or a newer version");let n=await Ro();if(n===null)throw new Error("WebGPU finds no graphics adapter on this device");let r=["timestamp-query","float32-blendable","float32-filterable","shader-f16"].filter(l=>n.features.has(l));if(t&&!wi.every(l=>r.includes(l)))throw new Error("this device cannot blend and filter 32-bit floats");let{maxStorageBufferBindingSize:i,maxBufferSize:a}=n.limits,c=await n.requestDevice({requiredFeatures:r,requiredLimits:{maxStorageBufferBindingSize:i,maxBufferSize:a}});return new s(c,e)}constructor(e,t){if(this.device=e,this.#e=t,this.bilinear=e.createSampler({magFilter:"linear",minFilter:"linear"}),e.features.has("timestamp-query")){let n=16*tt.length,o=GPUBufferUsage;this.#s={queries:e.createQuerySet({type:"timestamp",count:2*tt.length}),found:e.createBuffer({size:n,usage:o.QUERY_RESOLVE|o.COPY_SRC}),read:e.createBuffer({size:n,usage:o.MAP_READ|o.COPY_DST})}}}get blendsFloats(){return wi.every(e=>this.device.features.has(e))}get number(){return this.device.features.has("shader-f16")?"f16":"f32"}network(e){return this.#n(`network ${e.packed}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#i("network",e),entryPoint:"evaluate_network"}}))}project(e,{strips:t}){return this.#n(`project ${e.packed} ${e.sorted} ${t}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#i("project",e),entryPoint:e.sorted?"project_sorted":"project_sortfree",constants:{STRIPS:Number(t)}}}))}count(e){return this.#n(`count ${e.packed} ${e.sorted}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.#i("count",e),entryPoint:"count_fragments",constants:{SORTED:Number(e.sorted)}}}))}splat(e,{floats:t,strips:n},o){return this.#n(`splat ${e.packed} ${e.sorted} ${n} ${t} ${o}`,()=>{let r=e.sorted?yl:kl,i=this.#i("splat",e);return this.device.createRenderPipeline({layout:"auto",vertex:{module:i,entryPoint:e.sorted?"corner_sorted":o?"corner_of_level":"corner_sortfree",constants:{STRIPS:Number(n)}},primitive:{topology:n?"triangle-strip":"triangle-list"},fragment:{module:i,entryPoint:e.sorted?"cover":o?"add_to_level":"add_weighted",targets:sn(e.sorted,t).map(a=>({format:a,blend:r}))}})})}enlarge(e,t){return this.#n(`enlarge ${e} ${t}`,()=>{let n=this.#i("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:n,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:n,entryPoint:"add_enlarged",constants:{LEVEL:e},targets:sn(!1,t).map(o=>({format:o}))}})})}resolve(e,t,n){return this.#n(`resolve ${e} ${n} ${t}`,()=>{let o=this.#i("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:o,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:o,entryPoint:e?"resolve_sorted":n?"resolve_levels":"resolve_sortfree",targets:[{format:t}]}})})}dots(e){return this.#n(`dots ${e}`,()=>{let t=this.device.createShaderModule({code:this.#e.dots,label:"dots"}),n=[{shaderLocation:0,offset:0,format:"float32x3"}];return this.device.createRenderPipeline({layout:"auto",vertex:{module:t,entryPoint:"corner_of_dot",buffers:[{arrayStride:12,attributes:n}]},fragment:{module:t,entryPoint:"paint_dot",targets:[{format:e}]}})})}filled(e,t){let n=Math.ceil(e.byteLength/4)*4,o=this.device.createBuffer({size:n,usage:t,mappedAtCreation:!0}),r=new Uint8Array(e.buffer,e.byteOffset,e.byteLength);return new Uint8Array(o.getMappedRange()).set(r),o.unmap(),o}bind(e,t){return this.device.createBindGroup({layout:e.getBindGroupLayout(0),entries:Object.entries(t).map(([n,o])=>({binding:Number(n),resource:o instanceof GPUBuffer?{buffer:o}:o}))})}stamps(e,t=!0,n=!0){if(this.#s===null||!(t||n))return;let o=2*tt.indexOf(e);return{querySet:this.#s.queries,...t?{beginningOfPassWriteIndex:o}:{},...n?{endOfPassWriteIndex:o+1}:{}}}async time({network:e}){if(this.#s===null||this.#s.read.mapState!=="unmapped")return;let{queries:t,found:n,read:o}=this.#s,r=this.device.createCommandEncoder();r.resolveQuerySet(t,0,2*tt.length,n,0),r.copyBufferToBuffer(n,0,o,0,o.size),this.device.queue.submit([r.finish()]),await o.mapAsync(GPUMapMode.READ);let i=new BigUint64Array(o.getMappedRange()),a=tt.map((c,l)=>[c,Number(i[2*l+1]-i[2*l])/1e6]);this.milliseconds=Object.fromEntries(e?a:a.slice(1)),o.unmap()}#n(e,t){let n=this.#o.get(e)??t();return this.#o.set(e,n),n}#i(e,t){let n=t===null?"":this.#e[t.packed?"packed":"wide"],o=`${e} ${t?.packed}`,r=this.number==="f16"?`enable f16;
`:"",a=`${e==="network"?`${r}alias Num = ${this.number};
`:""}${this.#e.view}
${n}
${this.#e[e]}`,c=this.#t.get(o)??this.device.createShaderModule({code:a,label:e});return this.#t.set(o,c),c}};function ps(s,e){return Object.fromEntries(s.map((t,n)=>[e+n,t]))}function sn(s,e){return e?s?["rgba32float"]:["rgba32float","r32float"]:s?["rgba16float"]:["rgba16float","r16float"]}var _l=6,Al={packed:8,wide:32},ms=new Float32Array(0),nt=class s{static files=["view","wide","packed","network","project","splat","resolve","count","dots"].map(e=>`${e}.wgsl`);variant;levelSigma=0;supersampling=1;lost=null;onLost=()=>{};#e;#t;#o;#s;#n;#i=null;#r=null;#a=null;#c=null;#l;#f;#u=null;#w;static async create(e,t,{floats:n=!1,strips:o=!1}={}){let r=await nn.create(t,n);return new s(r,e,{floats:n,strips:o})}constructor(e,t,n){let o=t.getContext("webgpu");if(o===null)throw new Error("this canvas is already drawn to in another way");let{device:r}=e;this.variant=n,this.#e=e,this.#t=r,this.#s=t,this.#o=o,this.#n=navigator.gpu.getPreferredCanvasFormat(),o.configure({device:r,format:this.#n,alphaMode:"opaque"});let i=GPUBufferUsage;this.#l=r.createBuffer({size:Xe,usage:i.UNIFORM|i.COPY_DST});let a=i.STORAGE|i.INDIRECT|i.COPY_DST;this.#f=r.createBuffer({size:4*_l,usage:a});let c=new Uint16Array(6*pe);for(let l=0;l<pe;l++)c.set([0,1,2,2,1,3].map(f=>4*l+f),6*l);this.#w=e.filled(c,i.INDEX),r.lost.then(({reason:l})=>{l!=="destroyed"&&this.#p("the graphics device was lost: reload the page to go on")}),r.onuncapturederror=({error:l})=>this.#p(`this GPU cannot draw the scene: ${l.message}`)}get variants(){return(this.#e.blendsFloats?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}get milliseconds(){return this.#e.milliseconds}setScene(e){this.#m();let{count:t,sorted:n}=e,o={sorted:n,packed:e.packing!==null,network:!!e.network},r=Al[o.packed?"packed":"wide"]*Math.max(t,1),i={shapes:e.shapes,colors:e.colors,lobes:e.lobes},a=Math.max(r,...Object.values(i).map(u=>u.byteLength)),{maxStorageBufferBindingSize:c,maxBufferSize:l}=this.#t.limits,f=Math.min(c,l);if(a>f)throw new Error(`${t} Gaussians need ${Math.ceil(a/2**20)} MiB at a stretch, and this device gives ${Math.floor(f/2**20)}`);let h=GPUBufferUsage,d=u=>this.#e.filled(u.length?u:new Uint32Array(16),h.STORAGE|h.COPY_DST),m=u=>this.#t.createBuffer({size:4*Math.max(1,u),usage:h.STORAGE|h.COPY_DST});this.#r={kind:o,parts:{shapes:d(i.shapes),colors:d(i.colors),lobes:d(i.lobes)},looks:this.#t.createBuffer({size:r,usage:h.STORAGE}),order:m(t),network:e.network?{weights:this.#e.filled(this.#d(e.network),h.STORAGE),lobes:m(t)}:null},this.#i={...e,shapes:ms,colors:ms,lobes:ms},n&&this.setOrder(Uint32Array.from({length:t},(u,g)=>g))}show(e){this.#i&&(this.#i.count=e)}update(e,t,n){if(!this.#i||!this.#r||this.lost!==null)return;let o=4*ze(this.#i)[e]*t;this.#t.queue.writeBuffer(this.#r.parts[e],o,n)}setDots(e){this.#a?.destroy(),this.#a=e&&new tn(this.#e,e,this.#n)}drawDots(e){this.lost===null&&this.#a?.draw(e,this.#k(e))}setOrder(e){this.#r?.kind.sorted&&this.#t.queue.writeBuffer(this.#r.order,0,e)}draw(e){this.lost===null&&this.#y(e,this.#k(e),this.#n)}async pixels(e){let{width:t,height:n}=e,o=Math.ceil(16*t/256)*256,r=this.#b(t,n,"rgba32float");this.#y(e,r.createView(),"rgba32float");let i=this.#t.createBuffer({size:o*n,usage:GPUBufferUsage.MAP_READ|GPUBufferUsage.COPY_DST}),a=this.#t.createCommandEncoder();a.copyTextureToBuffer({texture:r},{buffer:i,bytesPerRow:o},[t,n]),this.#t.queue.submit([a.finish()]),await i.mapAsync(GPUMapMode.READ);let c=new Float32Array(i.getMappedRange()),l=new Float32Array(4*t*n);for(let f=0;f<n;f++){let h=f*o/4;l.set(c.subarray(h,h+4*t),4*t*f)}return i.destroy(),r.destroy(),l}async drawUnseen(e){let t=this.#b(e.width,e.height,this.#n);if(this.#y(e,t.createView(),this.#n),await this.finished(),t.destroy(),this.lost!==null)throw new Error(this.lost)}async finished(){await this.#t.queue.onSubmittedWorkDone()}describe(){let e=this.#t.adapterInfo;return[e?.vendor,e?.architecture,e?.device,e?.description].filter(Boolean).join(" ")}async time(){this.lost===null&&this.#r&&await this.#e.time(this.#r.kind)}async fragments(){let[e,t,n]=[this.#r,this.#i,this.#u];if(!e||!t||!n||this.lost!==null)return null;let o=GPUBufferUsage,r=this.#e.filled(new Uint32Array(4),o.STORAGE|o.COPY_SRC),i=this.#t.createBuffer({size:r.size,usage:o.MAP_READ|o.COPY_DST}),{kind:a,parts:c,looks:l,order:f}=e,h=this.#t.createCommandEncoder(),d={0:this.#l,1:c.shapes,4:l,5:f,6:this.#f,7:r};this.#v(h,null,this.#e.count(a),d,Math.ceil(t.count/pe)),h.copyBufferToBuffer(r,0,i,0,r.size),this.#t.queue.submit([h.finish()]),await i.mapAsync(GPUMapMode.READ);let m=Array.from(new Uint32Array(i.getMappedRange()),u=>u/8/n.pixels);for(let u of[r,i])u.destroy();return n.leveled?m:m.slice(0,1)}destroy(){this.#m(),this.setDots(null),this.#t.onuncapturederror=null,this.#t.destroy()}#p(e){this.lost===null&&(this.lost=e,this.onLost(e))}#m(){for(let e of this.#g())e.destroy();this.#r=this.#i=this.#u=null}#g(){if(this.#r===null)return[];let{parts:e,looks:t,order:n,network:o}=this.#r;return[...Object.values(e),t,n,...Object.values(o??{})]}#k({width:e,height:t}){return this.#s.width!==e&&(this.#s.width=e),this.#s.height!==t&&(this.#s.height=t),this.#o.getCurrentTexture().createView()}#b(e,t,n){let o=GPUTextureUsage;return this.#t.createTexture({size:[e,t],format:n,usage:o.RENDER_ATTACHMENT|o.COPY_SRC})}#y(e,t,n){let o=this.#i;if(!o||!this.#r)return;let r=Ke(e,this.supersampling),{queue:i}=this.#t,{floats:a,strips:c}=this.variant,l=this.#t.limits.maxTextureDimension2D,h=Math.max(...he(r.width,r.height).size)<=l&&!o.sorted&&this.levelSigma>0,d=h?this.levelSigma:0,m=_t(o,r,a?1:Et,d,this.supersampling);i.writeBuffer(this.#l,0,m),i.writeBuffer(this.#f,0,Uint32Array.of(c?4:6*pe,0,0,0,0,0));let u=this.#T(r.width,r.height,o.sorted,h);this.#u={leveled:h,pixels:e.width*e.height};let g=this.#t.createCommandEncoder();this.#E(g,o.count,this.#r),this.#_(g,o.count,this.#r),this.#x(g,o.count,this.#r,u[0],h),h&&(this.#S(g,this.#e.enlarge(2,a),[...u[0],...u[0]],u[2],!0,!1),this.#S(g,this.#e.enlarge(1,a),[...u[0],...u[2]],u[1],!1,!1));let w=u.slice(0,2).flat();this.#S(g,this.#e.resolve(o.sorted,n,h),w,[t],!h,!0),i.submit([g.finish()])}#d(e){return this.#e.number==="f16"?Uint16Array.from(e,oe):e}#E(e,t,{kind:n,parts:o,network:r}){if(r===null)return;let i={0:this.#l,1:o.shapes,4:o.lobes,5:r.weights,6:r.lobes};this.#v(e,"network",this.#e.network(n),i,Math.ceil(t/32))}#_(e,t,{kind:n,parts:o,looks:r,order:i,network:a}){let c=a?.lobes??o.lobes,l=[this.#l,o.shapes,o.colors,c,r];n.sorted||l.push(i,this.#f);let f=this.#e.project(n,this.variant);this.#v(e,"project",f,ps(l,0),Math.ceil(t/pe))}#v(e,t,n,o,r){let i=Math.max(1,Math.min(r,65535)),a=e.beginComputePass(t?{timestampWrites:this.#e.stamps(t)}:{});a.setPipeline(n),a.setBindGroup(0,this.#e.bind(n,o)),a.dispatchWorkgroups(i,Math.ceil(r/i)),a.end()}#x(e,t,{kind:n,parts:o,looks:r,order:i},a,c){let l=[{r:0,g:0,b:0,a:n.sorted?0:1},{r:0,g:0,b:0,a:0}],f=this.#e.splat(n,this.variant,c),h=e.beginRenderPass({colorAttachments:a.map((m,u)=>({view:m,loadOp:"clear",storeOp:"store",clearValue:l[u]})),timestampWrites:this.#e.stamps("splat")});h.setPipeline(f);let d={0:this.#l,1:o.shapes,4:r,5:i};h.setBindGroup(0,this.#e.bind(f,n.sorted?d:{...d,6:this.#f})),h.setIndexBuffer(this.#w,"uint16"),this.variant.strips?n.sorted?h.draw(4,t):h.drawIndirect(this.#f,0):n.sorted?h.drawIndexed(6*pe,Math.ceil(t/pe)):h.drawIndexedIndirect(this.#f,0),h.end()}#S(e,t,n,o,r,i){let a=e.beginRenderPass({colorAttachments:o.map(l=>({view:l,loadOp:"clear",storeOp:"store"})),timestampWrites:this.#e.stamps("resolve",r,i)});a.setPipeline(t);let c={0:this.#l,...ps(n,1)};n.length===4&&(c[5]=this.#e.bilinear),a.setBindGroup(0,this.#e.bind(t,c)),a.draw(3),a.end()}#T(e,t,n,o){let r=`${e} ${t} ${n} ${o} ${this.variant.floats}`;if(this.#c?.key===r)return this.#c.views;for(let f of this.#c?.textures??[])f.destroy();let i=GPUTextureUsage,a=[],l=(o?[he(e,t).size,...fe(e,t).slice(1,3)]:[[e,t]]).map(f=>sn(n,this.variant.floats).map(h=>{let d=i.RENDER_ATTACHMENT|i.TEXTURE_BINDING,m=this.#t.createTexture({size:f,format:h,usage:d});return a.push(m),m.createView()}));return this.#c={key:r,textures:a,views:l},l}};async function on(s,e){let t="";if(e!=="webgl")try{let n=await bi(nt.files,yt);return{name:"WebGPU",renderer:await nt.create(s,n)}}catch(n){if(e==="webgpu")throw n;t=n instanceof Error?n.message:String(n)}try{let{WebGlRenderer:n,shaderText:o}=await Lr();return{name:"WebGL2",renderer:n.create(s,await bi(n.files,o))}}catch(n){let o=n instanceof Error?n.message:String(n);throw new Error(`this browser cannot draw the scene: ${t?`${t}; `:""}${o}`)}}async function bi(s,e){let t=s.map(async n=>[n.replace(/\.[a-z]+$/,""),await e(n)]);return Object.fromEntries(await Promise.all(t))}p();ce();p();gt();var k=128,Sl=1e-12,vi=new Float32Array(0),rn=class{wasmMemory=null;#e=[];#t=0;#o=null;#s;constructor(e=!1){this.#s=e}block(e){return this.#n(e,k*e,null)}part({at:e},t,n){let o={at:e+4*k*t,width:n,numbers:vi};return this.#e.push([o,null,k*n]),o}layer(e,t,n){let o=n?n.length:e.length/t,r=Math.ceil(o/4)*4,i=new Float32Array(r*t);for(let l=0;l<o;l++){let f=(l-l%4)*t+l%4;for(let h=0;h<t;h++)i[f+4*h]=e[l*t+h]}let a=new Float32Array(r);n&&a.set(n);let c=l=>this.#n(0,l.length,l);return{inputs:t,outputs:r,weights:c(i),offsets:c(a)}}#n(e,t,n){let o={at:this.#t,width:e,numbers:vi};return this.#e.push([o,n,t]),this.#t+=16*Math.ceil(t/4),o}allocate(){this.wasmMemory=mt(this.#t);let e=this.wasmMemory?.buffer??new ArrayBuffer(this.#t);for(let[t,n,o]of this.#e.splice(0))t.numbers=new Float32Array(e,t.at,o),n&&t.numbers.set(n);this.#o=this.#s?null:Le(this.wasmMemory)}apply({inputs:e,outputs:t,weights:n,offsets:o},r,i,a){if(this.#o){this.#o.layer(n.at,o.at,r.at,i.at,e,t,a);return}let[c,l,f,h]=[r,i,n,o].map(({numbers:d})=>d);for(let d=0;d<t;d++){let m=(d-d%4)*e+d%4;for(let u=0;u<k;u++){let g=h[d];for(let w=0;w<e;w++)g+=f[m+4*w]*c[w*k+u];l[d*k+u]=Math.max(g,a*g)}}}units({at:e,width:t,numbers:n},{at:o,numbers:r}){if(this.#o){this.#o.units(e,o,t);return}for(let i=0;i<k;i++){let a=0;for(let l=i;l<k*t;l+=k)a+=n[l]*n[l];let c=1/Math.max(Math.sqrt(a),Sl);for(let l=i;l<k*t;l+=k)r[l]=n[l]*c}}};gt();kt();var{fround:B}=Math,Ml=["mobile_gs","no_depth","no_scale","sort_free_gs"],ws=oe(-1e4),Tl=[2047,2047,1023],xi=B(511/Math.SQRT1_2),yi=888,st=new Uint32Array(1),an=new Float32Array(st.buffer);function ki({sorted:s,weighting:e,footprint:t,background:n,grid:o,lobes:r},i,a,c=null){let l=r?.degree??0,[f,h]=_i(a);return{count:i,packing:{center:Array.from(o.center),unit:o.radius*2**o.exponent,leastScaleBits:f,scaleBitsSpan:h},...Ei(c?10:Ai(l),i),network:c&&No(c),shSize:4,lobeSize:(l+1)**2,sorted:s,weighting:{index:Ml.indexOf(e.name),exponentMax:e.exponent_max,sigma:e.sigma,backgroundWeight:e.background_weight,alphaMin:e.alpha_min},footprint:t,background:Array.from(n)}}function cn(s,e,t=Ei(gs(s),e.positions.length/3)){let n=e.positions.length/3,o=gs(s),r=4*k,i;for(let a=0;a<n;a+=k){let c=s.decode(e,a);i??=Rl(c);let l=i();t.shapes.set(l.subarray(0,4*c.count),4*a),t.colors.set(l.subarray(r,r+4*c.count),4*a),t.lobes.set(l.subarray(2*r,2*r+o*c.count),o*a)}return t}var Ei=(s,e)=>({shapes:new Uint32Array(4*e),colors:new Uint32Array(4*e),lobes:new Uint32Array(s*e)});function _i(s){let[e,t]=s.map(n=>(an[0]=n,B(st[0])));return[e,t-e]}var Ai=s=>(s+1)**2+2>>1,gs=({network:s,lobeDegree:e})=>s?10:Ai(e);function Rl(s,e=!1){let{scales:t,quats:n,sh:o,lobes:r,lobeDegree:i,statics:a,scaleRange:c,memory:l}=s,{buffer:f,byteOffset:h,length:d}=s.words,m=new Uint32Array(f,h,d),[u,g]=_i(c),w=g>0?B(1/g):0,x=e?null:Le(l),[y,v,E,A]=[t,n,o,r].map(({byteOffset:re})=>re),T=a.length>0,[I,q]=[(i+1)**2-1,gs({network:T,lobeDegree:i})];return()=>{x?x.pack(y,v,E,A,h,I,q,u,w):Ll(s,m,q,u,w),T&&Ol(a,m);let{count:re,positions:F}=s;for(let X=0,ie=0;X<re;X++,ie+=4)m[ie]=F[3*X]|F[3*X+1]<<16,m[ie+1]|=F[3*X+2];return m}}function Ll({scales:s,quats:e,sh:t,lobes:n,lobeDegree:o},r,i,a,c){let l=2*(o+1)**2;for(let f=0;f<k;f++){let h=8*k+i*f,d=Nl(n,f,l,r,h);Fl(t,f,r,4*(k+f)),r[4*f+1]=d<<16;let m=0;for(let g=2;g>=0;g--){an[0]=s[g*k+f];let w=B(B(B(st[0])-a)*c);m=m<<11|B(B(Tl[g]*Math.min(Math.max(w,0),1))+.5)}r[4*f+2]=m;let u=[0,1,2,3].map(g=>e[g*k+f]);r[4*f+3]=zl(u),u.some(Boolean)||(r[h]=ws|r[h]&4294901760)}}function Ol(s,e){for(let t=0;t<k;t++){let n=8*k+10*t;e[n]=e[n]&65535|Math.round(32767*s[t])<<16;for(let o=1;o<10;o++){let[r,i]=[2*o-1,2*o].map(a=>Math.round(32767*s[a*k+t]));e[n+o]=r&65535|i<<16}}}function zl(s){let e=0;for(let o=1;o<4;o++)Math.abs(s[o])>Math.abs(s[e])&&(e=o);let t=s[e]<0?-xi:xi,n=e;for(let o=0;o<4;o++)o!==e&&(n=n<<10|B(B(t*s[o])+1024.5)&1023);return n}function Fl(s,e,t,n){let o=c=>s[c*k+e],r=Array.from({length:9},(c,l)=>o(3+l)),i=Ti(r),a=r.map(c=>Mi(i,c));t[n]=oe(o(0))|oe(o(1))<<16,t[n+1]=oe(o(2))|i<<16|a[0]<<24;for(let c of[1,5])t[n+1+(c+3>>2)]=Si(a,c)}function Nl(s,e,t,n,o){let r=f=>s[f*k+e],i=Array.from({length:t-2},(f,h)=>r(2+h)),[a,c]=[0,1].map(f=>Ti(i.filter((h,d)=>d%2===f))),l=i.map((f,h)=>Mi(h%2?c:a,f));n[o]=oe(r(0))|oe(r(1))<<16;for(let f=0,h=o+1;f<l.length;f+=4,h++)n[h]=Si(l,f);return a|c<<8}var Si=(s,e)=>s[e]|s[e+1]<<8|s[e+2]<<16|s[e+3]<<24;function Mi(s,e){st[0]=s+yi<<20;let t=B(B(127/an[0])*e);return B(Math.min(Math.max(t,-127),127)+512.5)&255}function Ti(s){return an[0]=Math.max(0,...s.map(Math.abs)),Math.min(Math.max((st[0]+1048575>>20)-yi,0),255)}je();p();var Ri=new Map;function Li(s){let e=Ri.get(s)??Ul(s);return Ri.set(s,e),e}async function Ul(s){let{renderer:e}=await on(document.createElement("canvas"),s);try{return await di(e,bs())}finally{e.destroy()}}function bs(){try{return localStorage}catch{return null}}p();K();var Il=Math.cos(.5*Math.PI/180),ln=class{by="";#e=!1;#t=null;reset(e){this.by=e,this.#e=!1}invalidate(){this.#t=null}get pending(){return this.#e}received(){this.#e=!1}neededDirection({viewmat:e}){let t=[e[8],e[9],e[10]],n=this.#t!==null&&O(t,this.#t)>=Il;return!this.by||this.#e||n?null:(this.#e=this.by==="worker",this.#t=t)}};p();je();var Oi=12;function zi(s,e,t,n,o){let{viewmat:r,fx:i,fy:a,cx:c,cy:l,near:f}=t,h=-1,d=1/0;for(let m=0;3*m<s.length;m++){if(e[m]<0)continue;let[u,g,w]=[s[3*m],s[3*m+1],s[3*m+2]],x=r[8]*u+r[9]*g+r[10]*w+r[11];if(x<=f||x>=d)continue;let y=i*(r[0]*u+r[1]*g+r[2]*w+r[3])/x+c-n,v=a*(r[4]*u+r[5]*g+r[6]*w+r[7])/x+l-o;y*y+v*v>Oi*Oi||(d=x,h=m)}return h<0?null:[s[3*h],s[3*h+1],s[3*h+2]]}function fn(s,e,t,n){let o=n instanceof Uint32Array;for(let r=0;r*e<n.length;r++)s[t+r]=o?Uo(n[r*e]):n[r*e]}var Cl=1e3,$l=50,hn=class{count=0;total=0;views=[];near=.2;up=null;notes={};editable=!1;logits=new Float32Array(0);request=null;fragments=null;patient=!1;calibrated=Promise.resolve();name="";broken=!1;#e=new Float32Array(0);#t;#o;#s=!1;#n;#i;#r=null;#a=null;#c=null;#l=null;#f=Promise.resolve(!1);#u=!1;#w=null;#p=!1;#m=2;#g=new Uint32Array(0);#k=[0,0,0];#b=null;#y=[0,0,0];#d=new ln;#E=null;#_=-1/0;#v=!1;#x=!1;#S=!1;constructor(e,t,n,o,r=null){this.canvas=e,this.#i=t,this.#t=n,this.#o=r,this.#n=o}begin(e){return this.#f=this.#T(e)}async#T(e){try{let{name:t,renderer:n}=await on(this.canvas,e);if(this.#u)return n.destroy(),!1;n.onLost=i=>this.#N(i),"onRestored"in n&&(n.onRestored=()=>this.request&&this.load(this.request));let r=n.variants.find(({floats:i,strips:a})=>i===this.#t?.floats&&a===this.#t.strips)??hi(n,bs());return r&&(n.variant=r),n.levelSigma=this.#o??1,this.#s=r!==null,this.#r=n,this.name=t,pi(n),!0}catch(t){return this.#i.failed(vs(t)),!1}}async#z(){if(this.#s||this.broken)return;this.#s=!0;let e=this.name==="WebGPU"?"webgpu":"webgl",t=await Li(e);this.#r&&(this.#r.variant=t),this.#i.changed()}load(e,t=!1){this.#c?.terminate(),this.request=e;let n=To(e,async({data:o})=>{if(!await this.#f){n.terminate();return}(n===this.#c||n===this.#a)&&this.#C(o,n)});n.onerror=o=>{o.preventDefault(),!t&&n===this.#c?this.load(e,!0):this.#R("the viewer's own files could not be loaded: reload the page",n)},this.#c=this.#l=n}async sort(e){if(this.#d.by==="")return null;if(this.broken)throw new Error("the renderer was lost");this.#d.pending&&await this.#L();let t=performance.now();return this.#d.invalidate(),this.#D(e),this.#d.pending&&await this.#L(),performance.now()-t}#L(){return new Promise((e,t)=>this.#E={resolve:e,reject:t})}#M(e){this.#E?.reject(new Error(e)),this.#E=null}draw(e,t=1){if(this.#a===null)return;let n={...e,near:this.near};if(this.#x){this.#r?.drawDots(n),this.#F();return}this.#D(e),this.#r&&(this.#r.supersampling=t,this.#r.draw(n),this.#r.supersampling=1)}async#F(){let e=this.#r;this.#S||this.#n||!e||(this.#S=!0,await new Promise(t=>setTimeout(t,$l)),this.#x&&!this.#u&&await ui(e).catch(()=>{}))}drawOrReport(e,t){if(!this.broken)try{this.draw(e,t)}catch(n){this.#N(vs(n))}}async finished(){await this.#r?.finished()}pixels(e){return(this.#a&&!this.#x?this.#r?.pixels(e):null)??Promise.reject(new Error("nothing can be drawn"))}hide(e){let t=this.#g.slice();for(let n=0,o=0;o<t.length;n++,o+=this.#m)e[n]&&(t[o]=ws|t[o]&4294901760);this.#r?.update("lobes",0,t),fn(this.logits,this.#m,0,t),this.#i.ordered()}get background(){return this.#b??this.#k}set background(e){this.#b=e,this.background.forEach((t,n)=>this.#y[n]=t)}get means(){return this.#e=en(this.#e)}get milliseconds(){return this.#r?.milliseconds??null}async time(){this.#v||!this.#r||(this.#v=!0,await this.#r.time().catch(()=>{}),performance.now()>this.#_+Cl&&(this.fragments=await this.countFragments(),this.#_=performance.now()),this.#v=!1)}async countFragments(){return this.#x||this.broken?null:await this.#r?.fragments().catch(()=>null)??null}get device(){let{floats:e,strips:t}=this.#r?.variant??{floats:!1,strips:!1},n=`${e?"floats":"halves"}, ${t?"strips":"batches"}`,{by:o}=this.#d,r=this.#r?.describe()??"";return{renderer:this.name,adapter:r,variant:n,sorted:o!=="",sorted_by:o||null}}destroy(){this.#u=this.broken=!0,this.#M("the renderer was lost"),this.#c?.terminate(),this.#a?.terminate(),this.#r?.destroy(),this.#r=null}#N(e){this.broken=!0,this.#M(e),this.#i.broken(e)}#C(e,t){this.broken&&t===this.#a||(e.kind==="failed"?this.#R(e.sentence,t):e.kind==="progress"?t===this.#l&&this.#i.progress(e.received/e.total):e.kind==="dots"?this.#$(e,t):e.kind==="scene"?this.#I(e,t):e.kind==="rows"?this.#h(e):e.kind==="more"?this.#A(e.means):e.kind==="order"?this.#B(e.order):(this.#d.by!=="worker"&&t.terminate(),this.#c||(this.calibrated=this.#z().catch(()=>{})),t===this.#l&&this.#i.loaded(e.milliseconds,e.bytes)))}#R(e,t){let n=t===this.#c&&this.#w!==null;t===this.#a&&this.#M(e),t===this.#c&&(this.#c=null,this.request=this.#w),(t!==this.#a||this.#d.by!=="worker")&&t.terminate(),t===this.#l&&this.#i.failed(e,n)}#$({dots:e,...t},n){if(this.patient&&!this.count){this.#x=!0,this.#F();return}this.#d.reset(""),this.#O(n,e.background,()=>this.#r?.setDots(e))&&(this.#x=!0,this.#U(t),this.logits=new Float32Array(e.means.length/3),this.#A(e.means),this.#p||this.#i.arrived())}#I({data:e,means:t,...n},o){let r=o===this.#a;this.#d.reset(e.sorted?"worker":this.#n?"page":""),e.sorted=this.#d.by!=="",this.#O(o,e.background,()=>{this.#r&&(this.#r.setDots(null),this.#r.setScene(e),this.#r.levelSigma=this.#o??Fo(e.footprint))})&&(this.#x=!1,this.#U(n),this.logits=new Float32Array(e.count),this.total=e.count,this.#m=ze(e).lobes,this.editable&&e.lobes instanceof Uint32Array&&(this.#g=e.lobes),fn(this.logits,this.#m,0,e.lobes),this.#A(t),!r&&!this.#p&&this.#i.arrived())}#O(e,t,n){if(e!==this.#a&&(this.#a?.terminate(),this.#M("another scene was opened")),this.#a=e,e===this.#c&&(this.#p=this.request===this.#w&&this.count>0,this.#w=this.request,this.#c=null),this.#k=[...t],this.#y=t,this.background=this.#b,this.#r?.lost)return this.#N(this.#r.lost),!1;try{n()}catch(o){return e.terminate(),this.count=0,this.#i.failed(vs(o)),!1}return this.broken=!1,!0}#U({views:e,near:t,up:n,notes:o}){this.views=e,this.near=t,this.up=n,this.notes=o}#A(e){this.#e=e,this.count=("stored"in e?e.stored:e).length/3,this.#r?.show(this.count),this.#d.invalidate(),this.#i.changed()}#h({part:e,from:t,numbers:n}){this.#r?.update(e,t,n),e==="lobes"&&(this.#g.length&&this.#g.set(n,t*this.#m),fn(this.logits,this.#m,t,n)),this.#i.changed()}#B(e){this.#d.received(),this.#r?.setOrder(e),this.#E?.resolve(),this.#E=null,this.#i.ordered()}#D(e){let t=this.#d.neededDirection(e);t!==null&&(this.#d.by==="page"?this.#r?.setOrder(Zt(this.means,t)):this.#a?.postMessage({forward:t}))}},vs=s=>s instanceof Error?s.message:String(s);Ut();p();var Dl=16.666666666666668,Bl=1e3/50,Pl=1e3/45,Fi=1e3/26,Gl=3,Hl=200,ql=.9,Ni=[4,64],Vl=[1,.85,.7,.6,.5],ot=class{#e=0;#t=[];#o;#s=Pl;#n={step:0,median:1/0};#i=0;#r=Ni[0];constructor(e){this.fixed=e,this.#o=e===null?Vl:[e]}get scale(){return this.#o[this.#e]}reduced(e){return(e?this.scale:this.#o[0])<1}size(e,t,n,o){let r=Math.min(n,2)*(o?this.scale:this.#o[0]),i=a=>Math.max(1,Math.round(a*r));return{width:i(e),height:i(t)}}note(e){this.#t.push(e);let{length:t}=this.#t;if(t<Gl||this.#t.reduce((o,r)=>o+r)<Hl)return;let n=this.#t.sort((o,r)=>o-r)[t>>1];this.#t=[],n>this.#s?this.#a(n):n>=Bl||this.#e===0?this.#i=0:++this.#i>=this.#r&&(this.#e-=1,this.#i=0)}#a(e){let{step:t,median:n}=this.#n;if(this.#i=0,this.#r=Math.min(2*this.#r,Ni[1]),t<this.#e&&e<Fi&&e>ql*n){this.#e=t,this.#s=Fi;return}this.#n={step:this.#e,median:e};let o=this.scale*Math.sqrt(Dl/e),r=this.#o.findIndex(i=>i<this.scale&&i<=o);this.#e=r<0?this.#o.length-1:r}};p();function Ui({fx:s,fy:e,width:t,height:n},o){if(o.length===0)return 1;let r=Math.sqrt(o[0].K[0]*o[0].K[4]),i=Math.min(4,Math.floor(4096/Math.max(t,n)));return Math.max(1,Math.min(Math.floor(r/Math.sqrt(s*e)+.5),i))}Te();K();var Wl=100,Ii=150,jl=6,Xl=.2,Kl=9*Math.PI/180,dn=class{pose=new C([0,0,-3],[0,0,0],[0,-1,0]);fov=null;timed=!1;turning=!1;measured=!1;#e;#t;#o;#s;#n;#i=null;#r="auto";#a=null;#c=null;#l={};#f;#u;#w=this.pose;#p=!1;#m=!0;#g=null;#k={way:1,speed:1,excess:0};#b="orbit";#y=null;#d=0;#E=0;#_=-1/0;#v=!1;#x=0;#S=0;#T;constructor(e,t,{variant:n=null,levels:o=null,editable:r=!1,patient:i=!1}={}){this.#t=e,this.#e=t,this.#o=n,this.#s=o,this.#f=new ot(null),this.#n=this.#F(e,0,!1),this.#n.editable=r,this.#n.patient=i,this.#u=new Qt(e,{pose:()=>this.pose,mode:()=>this.mode,held:()=>this.turning=!1,changed:()=>{this.#_=performance.now(),this.turning=this.#m=!1,this.#g&&jr(this.pose,this.#g,this.mode),this.redraw()},focus:(a,c)=>this.#h(a,c)}),this.#T=new ResizeObserver(()=>{this.count&&(this.#m?this.#z():this.#L()),this.redraw()}),this.#T.observe(e)}begin(e){return this.#r=e,this.#n.begin(e)}load(e){this.#n.request&&(this.#p=!1,this.#c=null),this.#n.load(e)}async compare(e,t,n){this.endComparison();let o=this.#F(e,1,n);o.background=this.#a,this.#i=o,await this.#n.calibrated,o===this.#i&&await o.begin(this.#r)&&o===this.#i&&o.load(t)}endComparison(){this.#i?.destroy(),this.#i=null}redraw(){!this.#d&&!this.measured&&(this.#d=requestAnimationFrame(e=>this.#$(e)))}reset(e){let{views:t}=this;if(this.#m=e===void 0||t.length===0,this.#m)this.#z();else{let n=e%t.length;this.pose=C.fromViews(t,(n+t.length)%t.length,this.#R)}this.redraw()}#z(){this.#L(),this.pose=this.#w.copy()}#L(){this.#w=this.#C();let{clientWidth:e,clientHeight:t}=this.#t;this.#g=this.#c===null?qr(this.notes,e,t):null}get up(){return this.#c}set up(e){let t=e!==null&&De.has(e)?e:null;t!==this.#c&&(this.#c=t,this.#n.count&&this.reset())}turnUp(){let{views:e}=this,t=this.#n.up??(e.length?C.fromViews(e).up:se);return this.up=Qs(this.#c,t),this.#c??""}place(e){this.pose=e,e.box??=this.#w.box,this.#p=!0,this.#m=!1,this.redraw()}get mode(){return this.#b}set mode(e){this.#b=e;let t=e==="walk"?Vr(this.notes.floor):null,n=t?this.#w.eye:this.pose.eye,o=t??this.pose.up;this.#y=e==="walk"?{normal:o,offset:O(n,o)}:null,this.redraw()}stride(e,t){this.#u.stride=[e,t],this.redraw()}camera(e,t){return ur(this.pose,this.views[0]??null,e,t,this.#n.near,this.fov)}get views(){return this.#n.views.length?this.#n.views:this.#i?.views??[]}get notes(){return{...this.#n.notes,...this.#l}}set given(e){this.#l=e,this.count&&(this.#m?this.reset():this.#L())}get count(){return this.#n.count}get means(){return this.#n.means}hide(e){this.#n.hide(e)}pointAt(e,t){let{clientWidth:n,clientHeight:o}=this.#t,{means:r,logits:i}=this.#n;return zi(r,i,this.camera(n,o),e,t)}get calibrated(){return this.#n.calibrated}get source(){let{request:e}=this.#n;return e===null||"forward"in e?null:"url"in e?e.url:e.file}get device(){return this.#n.device}get scale(){return this.#f.fixed}set scale(e){this.#f=new ot(e),this.redraw()}get choices(){let{mode:e,fov:t,turning:n,scale:o,timed:r,up:i}=this;return{mode:e,fov:t,turning:n,scale:o,timed:r,up:i,background:this.#a}}get background(){return this.#n.background}set background(e){this.#a=e;for(let t of this.#M)t.background=e;this.redraw()}async drawAndWait(e,t){let n=this.camera(e,t),o=await this.#n.sort(n);if(this.#n.draw(n),await this.finished(),this.#n.broken)throw new Error("the renderer was lost");return o}async finished(){await this.#n.finished()}async passes(){return await this.#n.time(),this.#n.milliseconds}fragments(){return this.#n.countFragments()}pixels(e,t=0){return this.#M[t]?.pixels(e)??Promise.reject(new Error("there is no other scene"))}screenshot(e=1){return new Promise(t=>this.copy(e).toBlob(t,"image/png"))}copy(e=1){let{width:t,height:n}=this.#A(),o=document.createElement("canvas");[o.width,o.height]=[t,n];let r=o.getContext("2d");return this.#M.forEach(({canvas:i},a)=>{let c=a*Math.round(e*t),l=t-c;l>0&&r?.drawImage(i,c,0,l,n,c,0,l,n)}),o}destroy(){cancelAnimationFrame(this.#d),clearTimeout(this.#S),clearTimeout(this.#x),this.#u.destroy(),this.#T.disconnect();for(let e of this.#M)e.destroy()}get#M(){return this.#i?[this.#n,this.#i]:[this.#n]}#F(e,t,n){let o={progress:r=>this.#e.progress(t,r),arrived:()=>this.#N(t),changed:()=>{this.#x||=setTimeout(()=>this.redraw(),Wl)},ordered:()=>this.redraw(),loaded:(r,i)=>{this.#e.loaded(t,r,i),this.redraw()},failed:(r,i)=>this.#e.failed(t,r,i),broken:r=>this.#e.broken(t,r)};return new hn(e,o,this.#o,n,this.#s)}#N(e){let{views:t}=this;(e===0||!this.#n.views.length&&this.#_===-1/0)&&(t.length||this.#n.count)&&(this.#L(),this.#p?this.pose.box??=this.#w.box:this.reset()),this.redraw()}#C(){let{views:e}=this;if(this.#c===null){let{clientWidth:t,clientHeight:n}=this.#t,o=Wr(this.notes,t,n);if(o)return C.fromStart(o,this.#R??(e.length?C.fromViews(e).up:se));if(e.length)return C.fromViews(e,0,this.#R)}return C.around(this.#n.means,this.#R??se)}get#R(){return De.get(this.#c??"")??this.#n.up}#$(e){this.#d=0,clearTimeout(this.#x),this.#x=0;let t=e-this.#E;this.#E=e;let n=this.#v,o=this.turning&&this.count>0;this.#v=performance.now()-this.#_<Ii||this.#u.busy||o,this.#v&&n&&this.#f.note(t);let r=Math.min(t,100)/1e3;this.#u.advance(r),o&&this.#I(r);let i=this.#U(r),{width:a,height:c}=this.#A();if(clearTimeout(this.#S),this.#v&&(this.#S=setTimeout(()=>this.redraw(),2*Ii)),this.count&&!this.#n.broken){let{name:f,count:h,milliseconds:d,fragments:m}=this.#n,u=this.#v&&n?t:0,g=this.#i?.count??0,w=this.#n.patient&&this.#m&&h<Xl*this.#n.total;this.#e.drawn({renderer:f,count:h,compared:g,early:w,width:a,height:c,milliseconds:u,passes:d,fragments:m}),this.timed&&this.#n.time()}let l=this.#O(r);(this.#u.busy||o||i||l)&&this.redraw()}#I(e){let t=this.#k;t.speed+=(t.way-t.speed)*(1-Math.exp(-2*e)),this.pose.orbit(Kl*e*t.speed,0),this.#m=!1;let n=this.#g?Kr(this.pose,this.#g):0;n>t.excess&&t.way*t.speed>0&&(t.way=-t.way),t.excess=n}#O(e){if(!this.#y)return!1;let{normal:t,offset:n}=this.#y,o=O(this.pose.eye,t)-n;if(Math.abs(o)<1e-4*this.pose.reach)return!1;let r=-o*(1-Math.exp(-jl*e));return this.pose.eye=S(this.pose.eye,t,r),this.pose.target=S(this.pose.target,t,r),!0}#U(e){return!(this.#g&&this.#_>-1/0&&!this.turning)||this.#u.held?!1:Xr(this.pose,this.#g,this.mode,e)}#A(){let{clientWidth:e,clientHeight:t}=this.#t,n=this.#f.size(e,t,devicePixelRatio,this.#v);if(e&&t){let o=this.camera(n.width,n.height),r=this.#f.reduced(this.#v)?1:Ui(o,this.views);for(let i of this.#M)i.drawOrReport(o,r)}return n}#h(e,t){let n=this.pointAt(e,t);n&&this.pose.focus(n),this.redraw()}};var xs=["orbit","fly","walk"],Yl=120,ys=["start","start-portrait","limits","free"],Ci=["camera","scale","background","fov","up","autorotate",...ys],$i=["heading","credit","alt","lang"],Ql=2e3,Di="sorted",Zl={rootMargin:"100%"},Jl="(prefers-reduced-motion: reduce)",ks=class extends(globalThis.HTMLElement??Object){static observedAttributes=["src","compare",...Ci,...$i];viewer=null;#e;#t;#o;#s=Qe;#n="en";#i=null;#r=new Je;#a=null;#c;#l=!1;#f=!1;#u=new Kt;#w=0;#p=Promise.resolve(!1);#m=!1;#g=null;#k={inSight:null,suspend:()=>this.#_(),resume:()=>this.#d()};#b=new IntersectionObserver(([{isIntersecting:e}])=>Nr(this.#k,e));#y=new IntersectionObserver(e=>e.some(t=>t.isIntersecting)&&this.#d(),Zl);constructor(){super(),this.#e=this.attachShadow({mode:"open",delegatesFocus:!0}),this.#e.innerHTML=si,this.#o=new Pt(this.#e),this.#t=new Dt(this,this.#h("chrome"));for(let t of this.#e.querySelectorAll("button"))t.addEventListener("click",()=>this.act(t.dataset.act??""));this.#e.addEventListener("keydown",t=>{let{code:n,key:o,ctrlKey:r,metaKey:i,altKey:a,repeat:c,target:l,defaultPrevented:f}=t,h=fs.get(o.toLowerCase())??fs.get(n.slice(3).toLowerCase()),d=f||l.matches("textarea, select, input:not([type])");h&&!r&&!i&&!a&&!c&&!d&&(this.#h("help").classList.add("typed"),this.act(h)),n==="Escape"&&this.act("close")}),this.#e.addEventListener("keyup",t=>{let{code:n,target:o}=t,{classList:r}=o;n==="Tab"&&(r.add("reached"),o?.addEventListener("blur",()=>r.remove("reached"),{once:!0}))}),this.#h("settings").addEventListener("input",({target:t})=>{let n=t;n.name==="stats"?this.act("stats"):this.viewer&&Jr(n,this.viewer),this.#h("stick").classList.toggle("shown",this.viewer?.mode==="walk")}),this.addEventListener("fullscreenchange",()=>{let t=this.#A("full"),n=document.fullscreenElement?"window":"full";t.innerHTML=ue(n),t.dataset.name=n,Vt(this.#e,this.#s)}),ei(this.#h("stick"),(t,n)=>this.viewer?.stride(t,n)),this.addEventListener("pointerdown",()=>Ur(this.#k)),this.addEventListener("dragover",t=>{t.preventDefault(),this.#h("drop").hidden=!1}),this.addEventListener("dragleave",()=>this.#h("drop").hidden=!0),this.addEventListener("drop",t=>{t.preventDefault(),this.#h("drop").hidden=!0,this.#N(t.dataTransfer?.files)});let e=this.#F;e.addEventListener("change",()=>{this.#o.show(null),this.#N(e.files),e.value=""})}connectedCallback(){queueMicrotask(()=>{if(!this.isConnected||this.viewer)return;let e=this.getAttribute("poster")?.replace(/[\x22\\\n]/g,encodeURIComponent);e&&(this.style.background=`center / cover no-repeat url("${e}")`),this.clientHeight<=Yl&&(this.style.aspectRatio="16 / 10"),this.#b.observe(this),this.getAttribute("loading")==="lazy"?this.#y.observe(this):this.#d()})}#d(e=!1){this.#y.disconnect();let t=zr(this.#k,e);if(this.#h("wake").hidden=t,!t)return void this.#z();this.#v(),this.#g&&this.#E(this.#g)}#E({choices:e,pose:t}){let n=this.viewer;Object.assign(n,e),t&&n.place(t)}#_(){let{viewer:e}=this;if(e){if(e.count){this.#g={choices:e.choices,pose:e.pose};let t=e.copy();t.className="still",this.#h("bar").before(t)}this.#h("wake").hidden=!1,this.#x()}}#v(e=this.getAttribute("renderer")??"auto"){this.#h("chrome").hidden=this.hasAttribute("noui"),this.#A("full").hidden=!document.fullscreenEnabled,this.#A("share").hidden=!$r(),this.#z();let t=this.#e.querySelector("canvas"),n=this.getAttribute("variant"),[o,r]=["floats","strips"].map(l=>!!n?.includes(l)),i=Number(this.getAttribute("levels")??NaN);this.viewer=new dn(t,this,{variant:n===null?null:{floats:o,strips:r},levels:i===0||i>=.6&&i<=100?i:null,patient:this.hasAttribute("poster"),editable:this.hasAttribute("editable")}),t.classList.toggle("polite",this.hasAttribute("polite"));for(let l of Ci)this.#R(l);this.#p=this.viewer.begin(e),this.#m=!1,this.#p.then(l=>this.#m=!l);let a=this.#a??this.getAttribute("src"),c=this.#c===void 0?this.getAttribute("compare"):this.#c;a&&this.open(a),c&&this.compare(c)}disconnectedCallback(){this.#y.disconnect(),this.#b.disconnect(),this.#x(),Fr(this.#k)}get camera(){return this.viewer?Wt(this.viewer.pose):""}set camera(e){let t=jt(e);t&&this.viewer?.place(t)}#x(){this.viewer?.destroy(),this.viewer=null,this.#U(),this.#r=new Je;let e=this.#e.querySelector("canvas");e?.classList.remove("drawn"),e?.replaceWith(e.cloneNode())}attributeChangedCallback(e,t,n){if(e==="src"&&(this.#a=null),e==="compare"&&(this.#c=void 0),!(!this.viewer||n===t)){if($i.includes(e)){this.#z();return}e==="compare"?this.compare(n||null):e!=="src"?this.#R(e):n&&this.open(n)}}async open(e){this.#a=e,this.#f=this.#l,await this.#I(0,e,(t,n)=>{t.load(n),this.#R("up")})}async compare(e){this.#c=e,this.#f=!1,this.#l=e===Di;let t=this.#l?this.#a:e;this.viewer?.endComparison(),this.#U(),this.#r.begin(1),this.#O(),t!==null&&await this.#I(1,t,(n,o)=>{this.#U();let r=document.createElement("canvas");r.className="over",r.setAttribute("aria-hidden","true"),this.#h("split").before(r),this.#i=new Xt(this.#h("split"),r),n.compare(r,o,this.#l)})}act(e){let t=this.viewer;if(e==="wake"&&this.#d(!0),!!t){if(e==="reset"||e==="view")t.turning=!1,t.reset(e==="view"?++this.#w:void 0);else if(e==="help"||e==="settings")this.#o.show(e);else if(e==="stats")t.timed=this.#o.toggle("stats");else if(e==="own")t.background=null;else if(e==="up"){let n=t.turnUp();this.#T(n?ke(this.#s.axis,n):this.#s.ownAxis,!0)}else if(e==="mode"){let n=xs[(xs.indexOf(t.mode)+1)%xs.length];t.mode=n,this.#T(this.#s[{orbit:"orbits",fly:"flies",walk:"walks"}[n]],!0)}else e==="picture"?this.#C():e==="open"?this.#F.click():e==="copy"?this.#o.copy(this.#s):e==="share"?this.#o.share(this.#s):e==="send"?this.#o.send():e==="retry"?this.#M():e==="full"?document.fullscreenElement?document.exitFullscreen():this.requestFullscreen?.().catch(()=>{}):e==="close"&&(this.#h("message").hidden=!0,this.#o.show(null));this.#h("stick").classList.toggle("shown",t.mode==="walk"),Zr(this.#h("settings"),t,!this.#h("stats").hidden,this.#s),t.redraw()}}progress(e,t){this.#r.note(e,{share:t,state:"loading"}),this.#O()}loaded(e,t,n){this.#r.note(e,{share:1,state:"loaded"}),this.#O(),e!==1&&(this.#f&&this.compare(Di),this.#T(ke(this.#s.loaded,(this.viewer?.count??0).toLocaleString(this.#n))),this.dispatchEvent(new CustomEvent("load",{detail:{milliseconds:t,bytes:n}})),this.#S())}async#S(){let{viewer:e}=this;this.#e.querySelector(".annotations")?.remove();let t=["annotations","path"].some(o=>e?.notes[o]||this.hasAttribute(o));if(!e||!t||this.hasAttribute("editable"))return;let{showNotes:n}=await Fe();e===this.viewer&&n(this,this.#e,e,this.hasAttribute("autoplay"))}failed(e,t,n=!1){this.#r.fail(e,t,n),e===0&&(this.#f=!1),this.#O();let o=this.#h("message");o.hidden=!1,e===0&&(this.#a=this.viewer?.source??this.#a);let{viewer:r}=this,i=!!r?.count,a=o.querySelector("h2");a.hidden=i,a.dataset.text=navigator.onLine?"failed":"offline",Vt(o,this.#s),this.#A("open",o).hidden=i,this.#A("retry",o).hidden=i||typeof this.#a!="string"||!r?.device.renderer,this.dispatchEvent(new CustomEvent("error",{detail:{sentence:t}}))}broken(e,t){let n=this.viewer;if(!n||n.device.renderer==="WebGL2"||this.getAttribute("renderer")==="webgpu"){this.failed(e,t);return}console.warn(`WebGL2 takes over: ${t}`),this.#x(),this.#v("webgl"),this.#E({choices:n.choices,pose:n.count?n.pose:null})}report(e){let t=JSON.stringify(e,null,1),n=this.#h("report");n.querySelector("textarea").value=t;let o=e.scenes,r=o.some(c=>c.interrupted),i=o.map(({cold:c,steady:l})=>`${c.fps} frames/s cold, ${l.fps} steady`).join(" | "),a=n.querySelector("h2");delete a.dataset.text,a.textContent=r?"The page was hidden during the measurement: measure again":i,this.#A("send",n).hidden=!navigator.share,n.hidden&&this.#o.show("report"),this.dispatchEvent(new CustomEvent("report",{detail:e}))}drawn(e){e.early||this.#e.querySelector("canvas")?.classList.add("drawn"),this.#e.querySelector(".still")?.remove(),this.#g=null,e.compared&&this.#h("split").hidden&&this.#i?.show(this.#r.names,this.#s.compared),this.#L(),this.viewer?.measured||this.#t.invite(this.#a),this.dispatchEvent(new CustomEvent("frame",{detail:e}));let t=this.#h("stats");t.hidden||(t.textContent=this.#u.lines(e))}#T(e,t=!1){let n=this.#h("said");n.textContent=e,n.classList.toggle("seen",t),setTimeout(()=>n.classList.remove("seen"),Ql)}async#z(){this.#n=Yr(this),this.#s=await Qr(this.#n),Vt(this.#e,this.#s),this.#e.querySelector("canvas")?.setAttribute("aria-label",`${this.getAttribute("alt")??this.#s.scene}. ${this.#s.keysHint}`),this.#L()}#L(){let{title:e="",credit:t=""}=this.viewer?.notes??{};this.#t.setTitle(this.getAttribute("heading")??String(e??""),this.getAttribute("credit")??String(t??""))}#M(){this.#a!==null&&(this.#h("message").hidden=!0,this.open(this.#a))}get#F(){return this.#e.querySelector("[type=file]")}#N(e){let[t,n]=e??[];t&&this.open(t),n&&this.compare(n)}async#C(){let e=await this.viewer?.screenshot(this.#i?.share);if(!e)return;let t=document.createElement("a");Object.assign(t,{href:URL.createObjectURL(e),download:"scene.png"}).click(),setTimeout(()=>URL.revokeObjectURL(t.href),1e3)}#R(e){let t=this.viewer,n=this.getAttribute(e),o=Number(n);e==="scale"?t.scale=o>0&&o<=1?o:null:e==="fov"?t.fov=o>=1&&o<=150?o:null:e==="background"?t.background=Bt(n):e==="up"?t.up=n:ys.includes(e)?this.#$(t):e==="camera"?this.camera=n??"":t.turning=n!==null&&!matchMedia(Jl).matches,t.redraw()}#$(e){let t={};for(let n of ys){let o=this.getAttribute(n);n==="free"&&o!==null?t.limits=as:o!==null&&(t[n.replace("-","_")]=o,n.includes("-")||(t[`${n}_portrait`]=""))}e.given=t}async#I(e,t,n){let o=this.viewer;if(o===null||this.#m)return;let r=this.#c;if(e===1&&(!await this.#p||o!==this.viewer||r!==this.#c))return;let i=typeof t=="string"?t.replace(/[?#].*$/,""):"scene",a=t instanceof File?t.name:i;this.#r.begin(e,e===1&&this.#l?`${a}, sorted`:a),this.#O();try{let c=t instanceof Blob?{file:t}:{url:new URL(t,document.baseURI).href};n(o,c)}catch(c){this.failed(e,`the scene cannot be opened: ${c.message}`)}}#O(){let{state:e,busy:t,share:n,sentence:o,names:r}=this.#r,i=this.#h("bar");i.hidden=!t,i.classList.toggle("unknown",Number.isNaN(n));let a=Math.min(100,Math.round(100*n))||0;i.setAttribute("aria-valuenow",String(a)),i.firstElementChild.style.width=`${a}%`;let c=this.#h("message"),l=c.querySelector("p");l.textContent!==o&&(l.textContent=o),o||(c.hidden=!0),this.#h("split").hidden||this.#i?.show(r,this.#s.compared),e&&(this.dataset.state=e)}#U(){this.#h("split").hidden=!0,this.#e.querySelector(".over")?.remove(),this.#i=null}#A(e,t=this.#e){return t.querySelector(`[data-act=${e}]`)}#h(e){return this.#e.querySelector(`.${e}`)}};globalThis.customElements?.define("mobile-gs",ks);p();p();p();ge();te();vt();var e0=80;function Bi(s){let e=0;for(let{count:t,size:n,length:o}of s.values())e+=t*n*o;return e}function Pi(s,e){let t=0,n=new Map;for(let[o,{count:r,size:i,length:a}]of e){let c=()=>s.subarray(t,t+=i*a);n.set(o,{length:a,books:Array.from({length:r},c)})}if(n.get("scale")?.books.some(o=>o.some(r=>r>e0)))throw new _("the codebooks of the .mgs file hold scales that are out of range");return n}function Gi(s){return new Map([...s].map(([e,{step:t,columns:n}])=>{let o=n.map(({least:r,size:i})=>Float32Array.from({length:i},(a,c)=>(r+c)*t));return[e,{length:1,books:o,middles:n.map(({least:r,middle:i})=>i-r)}]}))}function Hi({name:s,codec:e,data:t},n,o){if(e==="rans")return be(t,n,o);let r=32-Math.clz32(o-1),i=Re(t,r*n),a=new Uint16Array(n);for(let c=0;c<n;c++){let l=i.take(r);if(l>=o)throw new _(`the stream '${s}' points outside of its codebook`);a[c]=l}return a}function rt({length:s,books:e,middles:t}){let n=new Uint16Array(k);return{length:s,books:e.map((o,r)=>t?o.subarray(t[r],t[r]+1):t0(o,s)),columns:e.map(()=>n)}}function t0(s,e){let t=new Float64Array(e);for(let n=0;n<s.length;n++)t[n%e]+=s[n]*e/s.length;return Float32Array.from(t)}function j({length:s,books:e,columns:t},n,o,r,i){for(let a=0;a<e.length;a++){let c=e[a],l=t[a],f=a*s*o;if(s===1){for(let h=r;h<i;h++)n[f++]=c[l[h]];continue}for(let h=0;h<s;h++,f=(a*s+h)*o)for(let d=r;d<i;d++)n[f++]=c[l[d]*s+h]}}te();ce();p();ge();var n0=[53,210,405,600,787,970,1151,1329],s0=Uint8Array.from({length:1330},(s,e)=>n0.filter(t=>t<=e).length),Es=Float64Array.from({length:512},(s,e)=>(e+.5)/2**(31-Math.clz32(e))-1.5),o0=2.5,_s=(s,e)=>s0[Math.min(256*Math.abs(Math.fround(s-e)),1329)|0];function qi(s,e,t){let[n,o,r]=t,i=n.length,a=[new Uint16Array(i),new Uint16Array(i),new Uint16Array(i)],[c,l,f]=a,[h,d,m]=e,u=new me(s),g=0;for(let w=0;w<i;w++){let x=h[n[w]],y=d[o[w]],v=m[r[w]],E=_s(y,v),A=_s(x,v),T=_s(x,y),I=u.take(E+A+T);c[w]=1<<E|I&(1<<E)-1,l[w]=1<<A|I>>>E&(1<<A)-1,f[w]=1<<T|I>>>E+A,g+=E+A+T}return Re(s,g),a}function Vi({step:s,columns:[{least:e},{least:t},{least:n}]},o,r,i,a){let[c,l,f,h,d,m]=o;for(let u=r,g=0;u<i;u++,g++){let w=s*(c[u]+e+Es[h[u]]),x=s*(l[u]+t+Es[d[u]]),y=s*(f[u]+n+Es[m[u]]),v=(w*w+x*x+y*y)/4,E=1+v*(-1/2+v*(1/24+v*(-1/720+v*(1/40320+v*(-1/3628800+v*(1/479001600-v/87178291200)))))),A=1/2+v*(-1/12+v*(1/240+v*(-1/10080+v*(1/725760+v*(-1/79833600+v/12454041600)))));if(v>o0){let T=Math.sqrt(v);E=Math.cos(T),A=Math.sin(T)/(2*T)}a[g]=E,a[g+k]=A*w,a[g+2*k]=A*x,a[g+3*k]=A*y}}An();var r0=256,Wi=["raw","halves","planes"],i0=["bits","rans"],ji=[["scale","rotation"],["appearance","opacity"],["lobes"]],Ss=ji.length,it=2,As=class{positions=null;columns=new Map;#e;constructor(e,t){this.#e=e,this.count=t}get stage(){let e=ji.findIndex(t=>!t.every(n=>this.#t(n)));return e<0?Ss:e}rows(e,t,n="slice"){let o=[...this.columns].filter(([i])=>this.#t(i)).map(([i,a])=>[i,a.map(c=>c[n](e,t))]);return{positions:this.positions[n](3*e,3*t),columns:Object.fromEntries(o)}}#t(e){let{cuts:t,scalars:n}=this.#e,o=n.size&&e==="rotation"?3:0,r=(t.get(e)?.count??n.get(e)?.columns.length??0)+o;return Object.keys(this.columns.get(e)??[]).length===r}},un=class{levels;network=null;#e;#t;#o=new Map;#s=new Map;#n=new Map;#i={};#r={};constructor(e,t){this.#e=e,this.#t=t;let{network:n,lobes:o,cuts:r,scalars:i,lodSizes:a}=e;n&&this.#l("view-network",Cs,f=>this.network=f),o&&this.#l("lobe-decoder",$s(o),f=>this.#i=f),this.#l(...Is(e),f=>this.#r=f),i.size?this.#n=Gi(i):this.#c("codebooks",Wi,[],f=>{this.#n=Pi(Cn(f,Bi(r)),r)});let c=[...this.#o.keys()],l=0;this.levels=a.map((f,h)=>(l+=f,this.#a(f,h?`@${h}`:"",c,l)))}#a(e,t,n,o){let{cuts:r,scalars:i}=this.#e,a=new As(this.#e,e),[c,...l]=["positions","scale.0","scale.1","scale.2"].map(d=>d+t),f=(d,m)=>{let u=[];a.columns.set(d,u);for(let[g,w]of m.entries())this.#c(`${d}.${g}${t}`,i0,[c],x=>{u[g]=Hi(x,e,w)})},h=({data:d})=>{a.positions=ii(d,e)};this.#c(c,["morton-class"],n,h,o);for(let[d,{count:m,size:u}]of r)f(d,Array(m).fill(u));for(let[d,{columns:m}]of i)f(d,m.map(({size:u})=>u));if(i.size){let[d,m]=["scale","rotation"].map(u=>a.columns.get(u)??[]);this.#c(`rotation-finer${t}`,["bits"],[c,...l],({data:u})=>{let{books:g}=this.#n.get("scale");qi(u,g,d).forEach((w,x)=>m[3+x]=w)})}return a}accept(e){this.#o.has(e.name)&&this.#s.set(e.name,e)}step(e){for(let[t,{after:n,minBytes:o,read:r}]of this.#o){let i=this.#s.get(t);if(!(i===void 0||e<o||n.some(a=>this.#o.has(a))))return r(i),this.#o.delete(t),this.#s.delete(t),!0}return!1}get decoderInputs(){let[{count:e,positions:t}]=this.levels,n=t,o=Math.min(e,r0),r=new Uint16Array(3*o).map((c,l)=>n[3*Math.floor(Math.floor(l/3)*e/o)+l%3]),[i,a]=[this.#e,this.#n];return{header:i,books:a,appearance:this.#r,lobes:this.#i,samples:r}}#c(e,t,n,o,r=0){let i=this.#t.find(a=>a.name===e);if(i===void 0)throw new _(`the .mgs file lacks its stream '${e}'`);if(!t.includes(i.codec))throw new _(`the stream '${e}' of the .mgs file uses the codec '${i.codec}', which this program does not know`);this.#o.set(e,{after:n,minBytes:r,read:o})}#l(e,t,n){this.#c(e,Wi,[],o=>n(Bs(Cn(o,Ds(t)),t)))}};p();p();ge();p();var G=new Int32Array(2048);for(let s=0;s<G.length;s++){let e=s<256?s:G[s-256];for(let t=0;t<8;t++)e=(e&1?3988292384:0)^e>>>1;G[s]=e}function pn(s,e=0){let t=~e,n=0;for(;n+8<=s.length;n+=8)t^=s[n]|s[n+1]<<8|s[n+2]<<16|s[n+3]<<24,t=G[1792+(t&255)]^G[1536+(t>>>8&255)]^G[1280+(t>>>16&255)]^G[1024+(t>>>24)]^G[768+s[n+4]]^G[512+s[n+5]]^G[256+s[n+6]]^G[s[n+7]];for(;n<s.length;n++)t=G[(t^s[n])&255]^t>>>8;return~t>>>0}te();Me();var Ie=[77,71,83,26,13,10,0,1],Ms=[2,3,4],mn=20,a0=2**20,c0=256,l0=2**32,f0=[["ply","a PLY scene: train or compress it first"],["PK","a zip archive (perhaps .sog)"],["\x8B","a gzip file (perhaps .spz)"],["NGSP","an .spz scene"],["glTF","a binary glTF file"],["\xFD7zXZ","an xz file (perhaps another program's comp.xz)"],["\x89PNG","a PNG picture"],["\xFF\xD8\xFF","a JPEG picture"],["<","a web page"],["{","a JSON text"]],gn=class{received=0;total=1/0;fields=null;table=[];#e=[];#t=0;#o=0;#s=!1;#n=null;append(e){if(e.length>0&&this.#e.push(e),this.received+=e.length,this.#t+=e.length,!this.#i())return[];if(this.received>this.total)throw new _(`the .mgs file has ${this.received-this.total} bytes too many at its end`);let t=[];for(let n;(n=this.table[this.#o])&&Ts(n.bytes)<=this.#t;)this.#o++,t.push(h0(n,this.#a(Ts(n.bytes))));return t}end(){if(this.fields!==null){let t=this.table[this.#o];if(t===void 0)return;throw new _(`the .mgs file ends inside its stream '${t.name}': it has been cut short`)}if(!this.#s)throw new _(Xi(this.#a(this.#t)));let e=this.#n===null?"first bytes":"header";throw new _(`the .mgs file ends inside its ${e}: it has been cut short`)}#i(){if(!this.#s&&this.#t>=Ie.length){let e=this.#a(Ie.length);if(Ie.some((t,n)=>t!==e[n]))throw new _(Xi(e));this.#s=!0}if(this.#s&&this.#n===null&&this.#t>=mn-Ie.length&&(this.#n=this.#a(mn-Ie.length)),this.#n!==null&&this.fields===null){let e=d0(this.#n);this.#t>=e&&this.#r(this.#n,this.#a(e))}return this.fields!==null}#r(e,t){let n=Y(e).getUint32(8,!0);if((mn+t.length)%8||pn(t,pn(e.subarray(0,8)))!==n)throw new _("the header of the .mgs file is damaged (wrong checksum)");this.fields=u0(t);let o=Y(e).getUint16(0,!0);if((o===2||o===4&&this.fields.layers===void 0)&&(this.fields.layers=[this.fields.count]),o<4&&(this.fields.footprint=ae),this.table=p0(this.fields.streams),this.total=this.table.reduce((r,i)=>r+Ts(i.bytes),mn+t.length),this.total>l0)throw new _(`the .mgs file claims ${this.total} bytes, too many for a scene`)}#a(e){this.#t-=e;let t=this.#e[0];if(t!==void 0&&t.length>e)return this.#e[0]=t.subarray(e),t.subarray(0,e);let n=new Uint8Array(e),o=0,r=0;for(;o<e;){let i=this.#e[r],a=i.subarray(0,e-o);n.set(a,o),o+=a.length,a.length<i.length?this.#e[r]=i.subarray(a.length):r++}return this.#e.splice(0,r),n}};function Ts(s){return Math.ceil(s/8)*8}function h0(s,e){let t=e.subarray(0,s.bytes);if(pn(t)!==s.crc32)throw new _(`the stream '${s.name}' of the .mgs file is damaged (wrong checksum)`);if(e.subarray(s.bytes).some(n=>n!==0))throw new _(`the .mgs file is damaged after its stream '${s.name}'`);return{name:s.name,codec:s.codec,data:t}}function d0(s){let e=Y(s),t=e.getUint16(0,!0),n=e.getUint32(4,!0);if(!Ms.includes(t))throw new _(`the .mgs file is of version ${t}.${e.getUint16(2,!0)}, this program reads ${Ms[0]}.x to ${Ms[2]}.x: reload the page, or write the file again with this version of mobilegs`);if(n>a0)throw new _(`the header of the .mgs file claims ${n} bytes: it is damaged`);return n}function u0(s){let e;try{e=JSON.parse(new TextDecoder("utf-8",{fatal:!0,ignoreBOM:!0}).decode(s))}catch{throw new _("the header of the .mgs file is not valid JSON")}if(typeof e!="object"||e===null||Array.isArray(e))throw new _("the header of the .mgs file is not a JSON object");return e}function p0(s){if(!Array.isArray(s)||s.length>c0)throw new _("the header of the .mgs file lacks a table of streams");let e=new Set;return s.map(t=>{let{name:n,codec:o,bytes:r,crc32:i}=Object(t);if(!([n,o].every(c=>ht(c,64))&&[r,i].every(c=>Number.isInteger(c)&&c>=0&&c<2**40)))throw new _("the header of the .mgs file has a broken table of streams");if(e.has(n))throw new _(`the .mgs file has two streams called '${n}'`);return e.add(n),{name:n,codec:o,bytes:r,crc32:i}})}function Xi(s){if(s.length===0)return"the file is empty, not a .mgs scene";if(Ie.findIndex((o,r)=>o!==s[r])>=Math.min(3,s.length))return"the first bytes of the .mgs file are damaged: transfer it again, in binary mode";let t=String.fromCharCode(...s),n=f0.find(([o])=>t.startsWith(o));return n?`this is not a .mgs scene but looks like ${n[1]}`:"this is not a .mgs scene"}Me();var Rs=class{header=null;decoder=null;#e=new gn;get received(){return this.#e.received}get total(){return this.#e.total}append(e){let t=this.#e.append(e),{fields:n,table:o,total:r}=this.#e;n!==null&&this.decoder===null&&(this.header=Ws(n,r),this.decoder=new un(this.header,o));for(let i of t)this.decoder?.accept(i)}end(){this.#e.end()}step(){return this.decoder?.step(this.received)??!1}};async function Ki(s,e){let t=new Rs,n=s.getReader();try{for(let o=0;;){o-=performance.now();let{value:r,done:i}=await n.read();if(o+=performance.now(),i)break;t.append(r);do await e(t,o);while(t.step())}}catch(o){throw await n.cancel().catch(()=>{}),o}return t.end(),t}p();p();ce();var Fs=16,Ls=6*Fs,J=64,wn=13,Os=.01,zs=6,Yi=15,{fround:H,sqrt:m0}=Math,bn=class{#e;#t;#o;#s;constructor(e,t,{static2:n,view2:o}){let r=3+o.length/9,i=new Float32Array(12*r);for(let a=0;a<12;a++){let c=a<3?n.subarray(3*a,3*a+3):o.subarray((a-3)*(r-3));i.set(c.subarray(0,r-3),a*r+(a<3?0:3))}this.#e=e,this.#t=e.block(r),this.#o=e.layer(i,r),this.#s=t}decode(e,t,n){j(t,this.#t.numbers,k,n,n+e.length/3),this.#e.apply(this.#o,this.#t,this.#s,1)}},vn=class{#e;#t;#o;#s;#n;#i;#r;constructor(e,t,{both1:n,static2:o,view2:r}){this.#e=e,this.#t=[e.layer(n,zs),e.layer(o,J),e.layer(r,J)],this.#o=e.block(zs),this.#s=e.block(2*J),this.#n=[e.part(this.#s,0,J),e.part(this.#s,J,J)],this.#i=t,this.#r=e.part(t,3,12)}decode(e,t,n){let o=this.#e,[r,i,a]=this.#t;j(t,this.#o.numbers,k,n,n+e.length/3),o.apply(r,this.#o,this.#s,Os),o.apply(i,this.#n[0],this.#i,1),o.apply(a,this.#n[1],this.#r,1)}},xn=class{#e;#t;#o;#s;#n;#i;#r;#a;#c;#l;constructor(e,t,{context1:n,context2:o,static1:r,static2:i,view1:a,view2:c},l){this.#e=e,this.#t=[e.layer(n,Ls),e.layer(o,J),e.layer(r,wn+3),e.layer(i,J),e.layer(a,wn+3),e.layer(c,J)],this.#l=2**l,this.#o=e.block(zs),this.#s=e.block(Ls),this.#n=e.block(J),this.#i=e.block(wn+3),this.#r=e.part(this.#i,wn,3),this.#a=t,this.#c=e.part(t,3,12)}decode(e,t,n){let o=this.#e,[r,i,a,c,l,f]=this.#t,[h,d]=[this.#o.numbers,this.#r.numbers],[m,u,g]=[this.#s,this.#n,this.#i];this.#u(e,m.numbers),o.apply(r,m,u,0),o.apply(i,u,g,1),j(t,h,k,n,n+e.length/3),d.set(h.subarray(0,3*k)),o.apply(a,g,u,Os),o.apply(c,u,this.#a,1),d.set(h.subarray(3*k)),o.apply(l,g,u,Os),o.apply(f,u,this.#c,1)}#f(e,t){let n=P(e[t])*this.#l,o=P(e[t+1])*this.#l,r=P(e[t+2])*this.#l,i=H(H(H(n*n)+H(o*o))+H(r*r));return Math.max(1,H(m0(i)))}#u(e,t){for(let n=0,o=0;o<e.length;n++,o+=3){let r=this.#f(e,o),i=H(2-H(1/r));for(let a=0;a<3;a++){let c=P(e[o+a])*this.#l,l=H(i*H(c/r));g0(l,t,a*Fs*k+n)}}}};function g0(s,e,t){let n=H(H(s*.25)+.5),o=Math.sin(Math.PI*n),r=Math.cos(Math.PI*n);for(let i=t+Fs*k;t<i;t+=k){e[t]=o,e[t+Ls/2*k]=r;let a=2*o*r;r=1-2*o*o,o=a}}p();lt();var kn=.28209479177387814,yn=class{#e;#t;#o;#s;#n;#i;#r;constructor(e,t,n,{degree:o,latents:r,hidden:i},a){let c=2*(o+1)**2,l=i.at(-1)??0,f=[19+r,...i];this.#e=e,this.#o=n,this.#t=i.map((u,g)=>e.layer(a[`weights.${g}`],f[g],a[`offsets.${g}`]));let h=a[`weights.${i.length}`],d=w0(h,l,a.basis,r,c);this.#t.push(e.layer(d,l+r,a.bias)),this.#s=e.block(r);let m=i.length?[19,...i]:[0];this.#n=m.map(u=>e.block(Math.ceil(u/4)*4+r)),this.#i=[0,m.length-1].map(u=>e.part(this.#n[u],m[u],r)),this.#r=i.length?new Ae(e,t,this.#n[0]):null}decode(e,t,n){let[o,r,i]=[this.#e,this.#n,this.#t.length-1];this.#r?.write(),e&&j(e,this.#s.numbers,k,t,n),this.#i[0].numbers.set(this.#s.numbers);for(let a=0;a<i;a++)o.apply(this.#t[a],r[a],r[a+1],0);this.#i[1].numbers.set(this.#s.numbers),o.apply(this.#t[i],r[i],this.#o,1)}};function w0(s,e,t,n,o){let r=e+n,i=new Float32Array(o*r);for(let a=0;a<o;a++){for(let c=0;c<e;c++)i[a*r+c]=s[a*e+c];for(let c=0;c<n;c++)i[a*r+e+c]=t[c*o+a]}return i}lt();p();function at(s,e){for(let t=0;t<e.length;t++)s.fill(e[t],t*k,(t+1)*k)}var b0=1/3,v0=[1,0,0,0],Ce=class{#e;#t=new rn;#o;#s;#n;#i;#r;#a;#c;#l;#f;constructor(e){let{header:t,samples:n}=e,{lobes:o,grid:r}=t,i=this.#t;this.#e=e;let a=o?.degree??0,c=i.block(Yi),l={logScales:i.block(3),scales:i.block(3),quats:i.block(4),sh:i.part(c,0,12),lobes:i.block(2*(a+1)**2+2),statics:i.block(t.network?19:0),words:i.block(18)};this.#o=l.quats,this.#n=o&&new yn(i,l,l.lobes,o,e.lobes),this.#i=t.network?new Ae(i,l,l.statics):null;let{appearance:f}=e;t.colors==="linear"?this.#s=new bn(i,c,f):t.colors==="latent_networks"?this.#s=new vn(i,c,f):this.#s=new xn(i,c,f,r.exponent),i.allocate(),this.#c=Object.fromEntries([...e.books].map(([m,u])=>[m,{...u,columns:[]}])),this.#l=Qi(this.#p("scale")),this.#f=Qi(rt(this.#p("scale")));let h=Object.fromEntries(Object.entries(l).map(([m,{numbers:u}])=>[m,u])),d=y0(this.#l);this.#r={...h,count:0,lobeDegree:a,scaleRange:d,memory:i.wasmMemory},this.#a={sh:this.#u(n),lobes:[0,1/kn]},this.#n&&(this.#a.lobes=this.#w(this.#n))}#u(e){let{sh:t}=this.#r,n=new Float64Array(12),o=rt(this.#p("appearance"));for(let r=0;r<e.length;r+=3*k){let i=e.subarray(r,r+3*k);this.#s.decode(i,o,0);for(let a=0;a<12;a++)for(let c=0;3*c<i.length;c++)n[a]+=3*t[a*k+c]/e.length}return n}#w(e){let{scales:t,quats:n,sh:o,lobes:r}=this.#r,i=this.#c.lobes;return j(this.#f,t,k,0,k),at(n,v0),at(o,this.#a.sh),e.decode(i?rt(i):null,0,k),Array.from({length:r.length/k-2},(a,c)=>r[c*k])}decode({positions:e,columns:t},n=0){let{header:o}=this.#e,r=e.subarray(3*n,3*(n+k)),i=r.length/3,a=n+i,[c,l]=[this.#r,this.#c];c.count=i,c.positions=r;let{logScales:f,scales:h,quats:d,sh:m,lobes:u}=c,{scale:g,rotation:w,appearance:x}=t,y=!0;for(let E of Object.keys(l)){let A=t[E];A?this.#p(E).columns=A:y=!1}this.#l.columns=g,j(this.#p("scale"),f,k,n,a),j(this.#l,h,k,n,a);let v=o.scalars.get("rotation");if(v?Vi(v,w,n,a,d):(j(this.#p("rotation"),d,k,n,a),this.#t.units(this.#o,this.#o)),x?this.#s.decode(r,this.#p("appearance"),n):at(m,this.#a.sh),this.#n&&y?this.#n.decode(l.lobes??null,n,a):at(u,this.#a.lobes),l.opacity){let{books:[E]}=t.opacity?l.opacity:rt(l.opacity),A=t.opacity?.[0];x0(u,E,A,n,i)}return this.#i?.write(),c}get network(){return this.#i!==null}get lobeDegree(){return this.#r.lobeDegree}get scaleRange(){return this.#r.scaleRange}get neutral(){let e=[0,1,2].map(r=>.5+kn*this.#a.sh[r]),[t,n,o]=this.#f.books.map(([r])=>r);return{color:e,side:b0*Math.cbrt(t*n*o)}}#p(e){return this.#c[e]}};function x0(s,e,t,n,o){for(let r=0;r<o;r++)s[r]+=e[t?t[n+r]:0]/kn}function Qi(s){return{...s,books:s.books.map(e=>e.map(Math.exp))}}function y0({books:s}){let e=[1/0,-1/0];for(let t of s)for(let n of t)e=[Math.min(e[0],n),Math.max(e[1],n)];return e}le();p();ye();var Zi=8192,k0=1e5,E0=3,_0=2,A0=8,En=class{results=[];#e=[];#t;#o=null;#s=null;#n=[];#i;#r=null;#a;#c;#l=!1;#f=!1;#u=()=>{};#w=()=>{};#p=new Promise((e,t)=>{this.#u=e,this.#w=t});constructor(e){this.#p.catch(()=>{});let t=0;for(let[n,o]of e.entries()){for(let r=0;r<o;r+=Zi)this.#e.push({level:n,from:r,to:Math.min(r+Zi,o),first:t+r});t+=o}this.#t=new Uint8Array(e.length),this.#a=new Uint8Array(this.#e.length),this.#c=this.#a.slice(),this.#i=t}set output(e){if(this.#r=e,e!==null)for(let[t,n]of this.results.splice(0))ea(n,Ji(e,this.#i,t,t+n.shapes.length/4))}spawn(){let{decoderInputs:e}=this.#o,t=this.#i<k0?1:navigator.hardwareConcurrency;for(let n=1;n<Math.min(t,E0+1);n++)this.#m(e)}#m(e){try{let t=Pn();t.postMessage({decoderInputs:e});let n={worker:t,jobs:0};t.onmessage=({data:o})=>{n.jobs--,this.#v(o),this.#E(n)},t.onerror=o=>o.preventDefault(),this.#n.push(n)}catch{}}start(e){return this.#o=e,this.#s=new Ce(e.decoderInputs)}advance(e,t){if(!(t<=this.#t[e])){this.#t[e]=t;for(let n of this.#n)this.#E(n);this.#_().catch(this.#w)}}finish(){return this.#f=!0,this.#x(),this.#p}terminate(){for(let{worker:e}of this.#n)e.terminate()}get#g(){return this.#a.findIndex((e,t)=>e<this.#b(t))}get#k(){let e=this.#g;return e<0?this.#c.findIndex((t,n)=>t<this.#b(n)):e}#b(e){return this.#t[this.#e[e].level]}#y(e,t){let{levels:n}=this.#o,{level:o,from:r,to:i}=this.#e[e];return n[o].rows(r,i,t)}#d(e){let{first:t,from:n,to:o}=this.#e[e];return this.#r?Ji(this.#r,this.#i,t,t+o-n):void 0}#E(e){for(let t;e.jobs<_0&&(t=this.#g)>=0;e.jobs++){let n=this.#a[t]=this.#b(t),o=this.#y(t,"slice"),r=[o.positions,...Object.values(o.columns).flat()].map(({buffer:i})=>i);e.worker.postMessage({rows:o,chunk:t,stage:n},{transfer:r})}}async#_(){if(!this.#l){this.#l=!0;for(let e;(e=this.#k)>=0&&this.#s;){let t=this.#a[e]=this.#b(e),n=cn(this.#s,this.#y(e,"subarray"),this.#d(e));this.#v({chunk:e,stage:t,packed:n}),await Ns()}this.#l=!1}}#v({chunk:e,stage:t,packed:n}){if(t<=this.#c[e])return;this.#c[e]=t;let o=this.#d(e);o===void 0?this.results.push([this.#e[e].first,n]):o.shapes.buffer!==n.shapes.buffer&&ea(n,o),this.#x()}get firstLevelReady(){return this.#e.every(({level:e},t)=>e>0||this.#c[t]>0)}get levels(){let e=this.#c.findIndex(t=>t<it);return e<0?this.#t.length:this.#e[e].level}#x(){this.#f&&this.#k<0&&this.#u()}};function Ji(s,e,t,n){let o=r=>{let i=s[r].length/e;return s[r].subarray(i*t,i*n)};return{shapes:o("shapes"),colors:o("colors"),lobes:o("lobes")}}function ea(s,e){for(let t of Object.keys(e))e[t].set(s[t])}var ta=0;async function Ns(){if(performance.now()-ta<A0)return;let{port1:s,port2:e}=new MessageChannel;await new Promise(t=>{s.onmessage=()=>{s.close(),t(null)},e.postMessage(null)}),ta=performance.now()}p();function na(s){let e=s.length/3,t=Math.max(1,Math.floor(e/1e4)),n=[0,1,2].map(a=>Float32Array.from({length:Math.ceil(e/t)},(c,l)=>s[3*l*t+a])),o=n.map(a=>a.slice().sort()[a.length-1>>1]),r=n[0].map((a,c)=>Math.max(...n.map((l,f)=>Math.abs(l[c]-o[f])))),i=r.sort()[Math.floor(.9*(r.length-1))];return .2*Math.min(1,Math.max(i,1e-6))}Ln();Te();var S0=8192,M0=2**20,sa=1500,T0=8,aa=["shapes","colors","lobes"],_e=new Float32Array(0),ee=(s,e=[])=>self.postMessage(s,{transfer:e}),ca=({shapes:s,colors:e,lobes:t})=>[s.buffer,e.buffer,t.buffer];async function R0(s){if("file"in s)return{source:s.file.stream(),total:s.file.size};let e;try{e=await fetch(s.url)}catch{throw new Error(`${s.url} cannot be reached: is the address right, the network there, and may this site load it (CORS)?`)}if(!e.ok||e.body===null)throw new Error(`${s.url} could not be loaded: the server says ${e.status}`);let t=e.headers.has("Content-Encoding")?NaN:Number(e.headers.get("Content-Length"));return{source:e.body,total:t||NaN}}var Us=class{#e;#t;#o;#s;#n;#i=0;#r=null;#a=!1;constructor(e,t,n,o,r){this.#e=e,this.#n=r,this.#t=t,this.#o=n,this.#s=o;let i=Array.from(e.background),{color:a,side:c}=o.neutral,l=hs(ai(t[0].positions,S0),e.grid),f=c*Math.sqrt(3*e.count/l.length),h={means:l,color:a,side:f,background:i};ee({kind:"dots",dots:h,...this.#c},[h.means.buffer])}get#c(){let{views:e,near:t,meta:n}=this.#e;return{views:e,near:t,up:ut(n.up),notes:n}}send(e){if(!this.#o.firstLevelReady||!this.allocate(e))return;let t=this.#o.levels,n=this.#i;this.#i=Math.max(t,1);let o=this.#o.results.splice(0),r=this.#r;if(r){this.#r=this.#o.output=null,ee({kind:"scene",data:r,means:this.#l(),...this.#c},ca(r));return}for(let[i,a]of o)for(let c of aa){let l=a[c];ee({kind:"rows",part:c,from:i,numbers:l},[l.buffer])}n!==this.#i&&ee({kind:"more",means:this.#l()})}allocate(e){let{count:t}=this.#e;return!this.#a&&T0*e>=t&&(this.#r=this.#o.output=ki(this.#e,t,this.#s.scaleRange,this.#n),this.#a=!0),this.#a}#l(){let e=this.#t.slice(0,this.#i),t=new Uint16Array(e.reduce((r,{count:i})=>r+3*i,0)),n=0;for(let{positions:r,count:i}of e)t.set(r,n),n+=3*i;let o={stored:t,grid:this.#e.grid};return this.#e.sorted&&(_e=en(o)),o}};async function L0(s){let e=null,t=null,[n,o]=[0,0],r=[],i=async({header:a,decoder:c,received:l,total:f},h)=>{if(ee({kind:"progress",received:l,total:f}),a===null||c===null)return;o=l,e??=new En(a.lodSizes);let d=r=c.levels,m=h*(f/l-1)>sa;d[0].positions&&!t&&(t=new Us(a,d,e,e.start(c),c.network),e.spawn(),n=setInterval(()=>t?.send(o),sa)),t?.allocate(l);for(let[u,{stage:g}]of d.entries())t&&(g===Ss||m&&u===0&&g>=it)&&e.advance(u,g);await Ns()};try{await Ki(s,i)}finally{for(let[a,{stage:c,positions:l}]of r.entries())t&&l&&c>=it&&e?.advance(a,c);await e?.finish().finally(()=>{clearInterval(n),e?.terminate()}),t?.send(o)}return o}async function oa(s,e,t){let[n,o]=[new Uint8Array(e||M0),0],r=s.getReader();for(let c;!(c=await r.read()).done;){let l=o+c.value.length;if(l>n.length){let f=n;n=new Uint8Array(Math.max(l,2*n.length)),n.set(f)}n.set(c.value,o),o=l,ee({kind:"progress",received:o,total:e})}let i=await t(n.subarray(0,o));if(!i.count)throw new Error("there is no Gaussian in this file that can be drawn");_e=new Float32Array(3*i.count);for(let c=0;c<_e.length;c++)_e[c]=i.shapes[4*c+3];let a={views:[],near:na(_e),up:i.up??null,notes:{}};return ee({kind:"scene",data:i,means:_e,...a},ca(i)),o}async function O0(s){let e=s.getReader(),t=()=>e.read().catch(()=>{throw new Error("the file broke off before its end: load it again")}),n=await t(),o=n?.value??new Uint8Array(0),r=new ReadableStream({async pull(i){let{value:a,done:c}=n??await t();n=null,c?i.close():i.enqueue(a)},cancel:()=>e.cancel()});return{first:o,whole:r}}async function ra(s){let e=performance.now();try{let{source:t,total:n}=await R0(s),{first:o,whole:r}=await O0(t),i;pt(o)?i=await oa(r,n,(await ns()).readPly):Zs(o)?i=await oa(r,n,(await ns()).readSpz):i=await L0(r),ee({kind:"done",milliseconds:performance.now()-e,bytes:i})}catch(t){let{message:n}=t,o=t instanceof RangeError?`the scene is too large for this device: ${n}`:n;ee({kind:"failed",sentence:o})}}var ia;function la(){self.onmessage=async({data:s})=>{if("decoderInputs"in s){ia=new Ce(s.decoderInputs);return}if("rows"in s){let{rows:e,chunk:t,stage:n}=s,o=cn(ia,e),r=aa.map(i=>o[i].buffer);self.postMessage({chunk:t,stage:n,packed:o},{transfer:r});return}if("forward"in s){let e=Zt(_e,s.forward);ee({kind:"order",order:e},[e.buffer]);return}await ra(s)},self.name&&ra({url:self.name})}p();ye();le();var z0="renderer variant levels scale noui poster background fov up start start-portrait limits free autorotate autoplay compare heading credit lang".split(" "),F0=400;function ha(){let s=document.querySelector("mobile-gs"),e=new URLSearchParams(location.search);for(let c of z0){let l=e.get(c);l!==null&&s.setAttribute(c,l)}s.lang||=navigator.language;let t=e.get("url");t&&s.setAttribute("src",t),setTimeout(()=>{let c=Oo();!t&&c?s.open(c):s.hasAttribute("src")||s.failed(0,"no scene is given: open a .mgs, .ply or .spz file, or add ?url=... to the address"),n(),parent===self&&s.focus({preventScroll:!0})},0);let n=()=>{let c=jt(location.hash);c&&s.viewer?.place(c)};addEventListener("hashchange",n);let o=0,r="",i=()=>s.viewer?Wt(s.viewer.pose):"";s.addEventListener("frame",()=>{r||=i(),clearTimeout(o),o=setTimeout(()=>{let c=i(),l=r!==""&&c!==r;r=c;try{l&&history.replaceState(null,"",`#${c}`)}catch{}},F0)});let a=e.get("bench");a!==null&&N0(s,a,e.getAll("url").slice(1))}async function N0(s,e,t){let n={width:Math.round(innerWidth*devicePixelRatio),height:Math.round(innerHeight*devicePixelRatio)},o=fa(s),{parsePlan:r,runBench:i}=await Fe(),a=r(e,n),c=[],l;for(let f of[null,...t]){f!==null&&(o=fa(s)),f!==null&&s.setAttribute("src",f);let h=await o,{viewer:d}=s;if(!h||!d)return;await d.calibrated,l??=await navigator.wakeLock?.request("screen").catch(()=>null);try{let m=await i(d,a,u=>s.progress(0,u));c.push({scene:s.getAttribute("src")??"own",gaussians:d.count,file_bytes:h.bytes,milliseconds_to_load:Math.round(h.milliseconds),...d.device,...m})}catch(m){l?.release(),s.failed(0,`the frame rate cannot be measured: ${m.message}`);return}s.loaded(0,h.milliseconds,h.bytes)}l?.release(),s.report({date:new Date().toISOString(),...a,viewer:Lo(),browser:navigator.userAgent,device_pixel_ratio:devicePixelRatio,scenes:c})}function fa(s){return new Promise(e=>{s.addEventListener("load",t=>e(t.detail),{once:!0}),s.addEventListener("error",()=>e(null),{once:!0})})}globalThis.document?document.querySelector("mobile-gs[page]")&&ha():la();
})();
