(function bundle(){"use strict";
var sc=Object.defineProperty;var S=(s,e,t)=>()=>{if(t)throw t[0];try{return s&&(e=s(s=0)),e}catch(n){throw t=[n],n}};var Be=(s,e)=>{for(var t in e)sc(s,t,{get:e[t],enumerable:!0})};var b,p=S(()=>{b={"count.glsl":`out vec4 found;
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
uniform vec4 crop;
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
float opacity = (1.0 - whole.w) / (1.0 + exp(min(-seen.x, 80.0)));
if (!(opacity > scale_bits.z)) { return look; }
vec2 box = reach_of(opacity) * sqrt(e.variance);
if (any(lessThan(e.center + box, vec2(0.5)))) { return look; }
if (any(greaterThan(e.center - box, size.xy - 0.5))) { return look; }
vec3 a = shape.axes[0];
vec3 b = shape.axes[1];
vec3 c = shape.axes[2];
float largest = sqrt(max(dot(a, a), max(dot(b, b), dot(c, c))));
if (crop.w > 0.0 && distance(shape.mean, crop.xyz) + 2.0 * largest > crop.w) { return look; }
vec4 color = vec4(color_along(i, basis), 1.0);
look.color = max(color.rgb + vec3(dot(grade[0], color), dot(grade[1], color), dot(grade[2], color)), vec3(0.0));
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
let opacity = (1.0 - view.faded) / (1.0 + exp(min(-seen.x, 80.0)));
if (!(opacity > view.alpha_min)) { return seen_now; }
if (!touches(ellipse, opacity)) { return seen_now; }
let a = shape.axes;
let largest = sqrt(max(dot(a[0], a[0]), max(dot(a[1], a[1]), dot(a[2], a[2]))));
let weight = weight_of(ellipse.depth, largest, max(seen.y, 0.0));
let color = vec4f(color_along(i, basis), 1.0);
let added = vec3f(dot(view.grade[0], color), dot(view.grade[1], color), dot(view.grade[2], color));
seen_now.look = Look(max(color.rgb + added, vec3f(0.0)), weight * view.weight_scale, opacity);
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
var seen: Seen;
if (i < view.count) { seen = look_at(i); }
append_to_list(i, local, seen);
}
fn append_to_list(i: u32, local: u32, seen: Seen) {
if (local == 0u) { atomicStore(&found, 0u); }
workgroupBarrier();
var place = 0u;
if (seen.look.opacity > 0.0) { place = atomicAdd(&found, 1u); }
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
uniform int first_column;
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
at = ivec2(at.x - first_column, abs(last_row - at.y));
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
#ifdef PARTLY_HIDDEN
if (level > 0 && partly_hidden(e, opacity, level)) { level = 0; }
#endif
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
gl_Position = vec4(at / target * 2.0 - 1.0, min(whole.z / e.depth, 1.0), 1.0);
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
weight_out = vec4(weighted, weighted * (2.0 * gl_FragCoord.z - 1.0), 0.0, 0.0);
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
out.position = vec4f(at / size * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), min(view.nearest / ellipse.depth, 1.0), 1.0);
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
return sums_of(alpha_at(corner.position.xy, corner.axes, corner.center), corner.color, corner.position.z);
}
@fragment
fn add_to_level(corner: LevelCorner) -> Sums {
let at = corner.position.xy;
let outside = any(at < corner.region.xy) || any(at > corner.region.zw);
return sums_of(select(alpha_at(at, corner.axes, corner.center), 0.0, outside), corner.color, corner.position.z);
}
fn sums_of(alpha: f32, color: vec4f, nearness: f32) -> Sums {
let weighted = alpha * color.w;
return Sums(vec4f(color.rgb * weighted, alpha), vec4f(weighted, weighted * nearness, 0.0, 0.0));
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
vec4 grade[3];
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
nearest: f32,
faded: f32,
grade: array<vec4f, 3>,
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
`}});var rc,_,te=S(()=>{"use strict";p();rc=/[\x00-\x1f\x7f-\x9f\u2028\u2029\p{Cs}]/gu,_=class extends Error{name="SceneError";constructor(e){super(e.replace(rc,"\uFFFD"))}}});var Oe,Pn=S(()=>{"use strict";p();Oe=class{#e;#t;#o;constructor(e,{sh:t,scales:n,quats:o},r){this.#e=e,this.#t=[[t,e.part(r,0,12)],[n,e.part(r,12,3)]],this.#o=[o,e.part(r,15,4)]}write(){let[e,t]=this.#o;for(let[n,o]of this.#t)this.#e.units(n,o);t.numbers.set(e.numbers)}}});function so({colors:s,scalars:e}){let t=e.get("appearance")?.columns.length??6,n={linear:[["static2",3,3],["view2",9,t-3]],networks:ic,latent_networks:ac};return[Bn[s],n[s]]}function ro({degree:s,latents:e,hidden:t}){let n=2*(s+1)**2,o=[19+e,...t],r=[["bias",1,n],["basis",e,n]];return t.length===0||([...t,n].forEach((i,a)=>r.push([`weights.${a}`,i,o[a]])),t.forEach((i,a)=>r.push([`offsets.${a}`,1,i]))),r}function io(s){return s.reduce((e,[,t,n])=>e+t*n,0)}function ao(s,e){let t=0;return Object.fromEntries(e.map(([n,o,r])=>[n,s.subarray(t,t+=o*r)]))}var ic,ac,Bn,oo,Hn=S(()=>{"use strict";p();ic=[["context1",64,96],["context2",13,64],["static1",64,16],["static2",3,64],["view1",64,16],["view2",9,64]],ac=[["both1",128,6],["static2",3,64],["view2",9,64]],Bn={linear:"color-matrices",networks:"appearance-decoder",latent_networks:"color-networks"};oo=[["hidden1.weight",256,22],["hidden1.bias",1,256],["hidden2.weight",128,256],["hidden2.bias",1,128],["hidden3.weight",64,128],["hidden3.bias",1,64],["phi.weight",1,64],["phi.bias",1,1],["opacity.weight",1,64],["opacity.bias",1,1]]});function po(s,e){let{colors:t="networks"}=s;for(let[h,d,...m]of[["mode",s.mode,"nvq","sq"],["blend",s.blend,"sortfree","sorted"],["sh_degree",s.sh_degree,1],["colors",t,"linear","networks","latent_networks"]])if(!m.includes(d))throw new _(`the .mgs file has ${h} '${go(d)}', which this program does not know: a newer one may`);let n=kc(s),o=s.network;if(typeof o!="boolean")throw O("network");if(o&&n!==null)throw new _("the .mgs file has lobes and a view network: it can have one of them");let r=s.mode==="sq",i=C(s,"count",1,cc),a={count:i,lodSizes:Ec(s,i),cuts:r?new Map:_c(W(s,"codebooks"),n),scalars:r?Ac(W(s,"scalars"),n,t==="linear"):new Map,grid:Sc(W(s,"positions")),colors:t,sorted:s.blend==="sorted",lobes:n,network:o,weighting:Mc(W(s,"weighting")),footprint:Tc(W(s,"footprint")),background:wt(s,"background",3),near:ne(s,"near"),views:qe(s,"views").map(Rc),meta:Lc(W(s,"meta"))},c=yc(a),f=s.streams.filter(h=>c.has(h.name)).reduce((h,d)=>h+d.bytes,0);if(i>f)throw new _(`the .mgs file claims ${i} Gaussians in ${f} of its ${e} bytes: it is damaged`);if(a.footprint.soft_edge&&a.sorted)throw O("footprint.soft_edge");if(a.background.some(h=>h<0||h>1))throw O("background");if(!(a.near>0&&a.near<=mt))throw O("near");if(a.views.length>gc)throw O("views");return a}function gt(s,e){return typeof s!="string"||s.length>2*e||bc.test(s)?!1:s.length<=e||[...s].length<=e}function yc({colors:s,lobes:e,network:t,cuts:n,scalars:o,lodSizes:r}){let i=["positions"];for(let[c,{count:l}]of n)for(let f=0;f<l;f++)i.push(`${c}.${f}`);for(let[c,{columns:l}]of o)i.push(...l.map((f,h)=>`${c}.${h}`));o.size&&i.push("rotation-finer");let a=r.flatMap((c,l)=>i.map(f=>l?`${f}@${l}`:f));return a.push(Bn[s]),e&&a.push("lobe-decoder"),t&&a.push("view-network"),n.size&&a.push("codebooks"),new Set(a)}function Ec(s,e){let t=qe(s,"layers").map(o=>C({layers:o},"layers",1,e)),n=t.reduce((o,r)=>o+r,0);if(t.length>lc||n!==e)throw O("layers");return t}function kc(s){if(s.lobes===null)return null;let e=W(s,"lobes"),t=qe(e,"hidden");if(t.length>mc)throw O("lobes.hidden");return{degree:C(e,"degree",0,3),latents:C(e,"latents",0,Vn),hidden:t.map(n=>C({hidden:n},"hidden",1,pc))}}function _c(s,e){let t=new Map;for(let[o,r]of vc){if(o==="opacity"&&!Object.hasOwn(s,o)&&e!==null)continue;let i=W(s,o),a=r.find(([c,l])=>i.count===c&&i.length===l);if(!a)throw O(`codebooks.${o}`);t.set(o,{count:a[0],length:a[1],size:C(i,"size",1,Gn)})}let n=0;if(Object.hasOwn(s,"lobes")){let o=W(s,"lobes"),r=C(o,"count",1,Vn),i=C(o,"length",1,Vn);t.set("lobes",{count:r,length:i,size:C(o,"size",1,Gn)}),n=r*i}if(n!==(e===null?0:e.latents))throw O("codebooks.lobes");return t}function Ac(s,e,t){let n=new Map,o=e?.latents??0;if(Object.hasOwn(s,"lobes")&&!o)throw O("scalars.lobes");for(let[r,i]of[...xc,["lobes",o]]){if(r==="opacity"&&!Object.hasOwn(s,r)&&e!==null||i===0)continue;let c=W(s,r),[l,f,h]=["least","size","middle"].map(v=>qe(c,v)),[d,m]=r==="appearance"&&t?uo:[i,i],u=l.length;if(u<d||u>m||f.length!==u||h.length!==u)throw O(`scalars.${r}`);let g=Math.fround(ne(c,"step"));if(!(g>=fc&&g<=hc))throw O(`scalars.${r}.step`);let w=l.map((v,E)=>{let x={least:l[E],size:f[E],middle:h[E]},A=C(x,"least",-qn,qn),M=C(x,"size",1,Gn),R=C({size:A+M-1},"size",A,qn);if(r==="scale"&&R*g>dc)throw O("scalars.scale");let $=Math.max(-A,R)+.5;if(r==="rotation"&&$*g>uc)throw O("scalars.rotation");return{least:A,size:M,middle:C(x,"middle",A,R)}});n.set(r,{step:g,columns:w})}return n}function Sc(s){let e=wt(s,"center",3),t=Math.fround(ne(s,"radius"));if(e.some(n=>Math.abs(n)>Math.fround(mt)))throw O("positions.center");if(t<wc||t>mt)throw O("positions.radius");return{center:e,radius:t,exponent:C(s,"exponent",0,14)}}function Mc(s){let{name:e}=s;if(typeof e!="string")throw O("name");if(!ho.includes(e))throw new _(`the .mgs file has the weighting '${go(e)}': known are ${ho.join(", ")}`);let t={name:e,exponent_max:ne(s,"exponent_max"),sigma:ne(s,"sigma"),background_weight:ne(s,"background_weight"),alpha_min:s.alpha_min===void 0?1/255:ne(s,"alpha_min")};if(!(t.exponent_max>0&&t.exponent_max<=80))throw O("exponent_max");if(!(t.sigma>0&&t.sigma<=mt))throw O("sigma");if(t.background_weight<0)throw O("background_weight");if(!(t.alpha_min>=1e-4&&t.alpha_min<=.1))throw O("alpha_min");return t}function Tc(s){let{antialiased:e,soft_edge:t}=s;if(typeof e!="boolean")throw O("footprint.antialiased");if(typeof t!="boolean")throw O("footprint.soft_edge");let n=ne(s,"blur");if(!(n>0&&n<=4))throw O("footprint.blur");return{blur:n,antialiased:e,soft_edge:t}}function Rc(s){let e=W({views:s},"views"),t=wt(e,"viewmat",16),n=wt(e,"K",9);if(![0,0,0,1].every((i,a)=>t[12+a]===i)||![0,0,1].every((i,a)=>n[6+a]===i)||n[0]<=0||n[4]<=0)throw new _("a view's matrices in the .mgs file are not those of a camera");let r=C(e,"width",1,co);return{viewmat:t,K:n,width:r,height:C(e,"height",1,co)}}function Lc(s){let e=Object.entries(s);if(e.length>lo)throw new _(`the .mgs file has ${e.length} notes: ${lo} are allowed`);for(let[t,n]of e){let o=n===null||typeof n=="boolean"||gt(n,fo),r=typeof n=="number"&&Math.abs(n)<=2**53;if(!(o||r)||!gt(t,fo))throw new _(`the note '${t.slice(0,40)}' is not a short text or a number`)}return s}function W(s,e){let t=s[e];if(typeof t!="object"||t===null||Array.isArray(t))throw O(e);return t}function qe(s,e){let t=s[e];if(!Array.isArray(t))throw O(e);return t}function C(s,e,t,n){let o=ne(s,e);if(!Number.isInteger(o)||o<t||o>n)throw O(e);return o}function ne(s,e){return mo(s[e],e)}function wt(s,e,t){let n=qe(s,e);if(n.length!==t)throw O(e);return Float32Array.from(n,o=>mo(o,e))}function mo(s,e){if(typeof s!="number"||!(Math.abs(s)<=3e38))throw O(e);return s}function go(s){return typeof s!="object"||s===null?String(s).slice(0,40):Array.isArray(s)?"a list":"an object"}function O(s){return new _(`the field '${s}' in the header of the .mgs file is missing or invalid`)}var le,cc,lc,Gn,qn,fc,hc,dc,uc,Vn,pc,mc,gc,co,lo,fo,wc,mt,bc,ho,vc,uo,xc,ze=S(()=>{"use strict";p();te();Hn();le=Object.freeze({blur:.3,antialiased:!1,soft_edge:!1}),cc=2**26,lc=8,Gn=4096,qn=2**14,fc=1e-5,hc=1e3,dc=80,uc=8,Vn=32,pc=256,mc=3,gc=64,co=2**16,lo=64,fo=4096,wc=1e-20,mt=1e20,bc=/[\x00-\x1f\x7f-\x9f\p{Cs}]/u,ho=["mobile_gs","no_depth","no_scale","sort_free_gs"],vc=[["scale",[[3,1],[1,3]]],["rotation",[[2,2],[1,4]]],["appearance",[[3,2]]],["opacity",[[1,1]]]],uo=[6,12],xc=[["scale",3],["rotation",3],["appearance",uo[0]],["opacity",1]]});function N(s){let e=z(s);return e>0?[s[0]/e,s[1]/e,s[2]/e]:[1,0,0]}function Fe(s,e,t){let[n,o]=[Math.cos(t),Math.sin(t)],r=L(s,e)*(1-n),i=F(e,s);return y(y([s[0]*n,s[1]*n,s[2]*n],i,o),e,r)}var y,T,L,F,z,B=S(()=>{"use strict";p();y=(s,e,t=1)=>[s[0]+t*e[0],s[1]+t*e[1],s[2]+t*e[2]],T=(s,e)=>y(s,e,-1),L=(s,e)=>s[0]*e[0]+s[1]*e[1]+s[2]*e[2],F=(s,e)=>[s[1]*e[2]-s[2]*e[1],s[2]*e[0]-s[0]*e[2],s[0]*e[1]-s[1]*e[0]],z=s=>Math.hypot(...s)});function bo(s){let e=N(s.reduce((n,{down:o})=>T(n,o),[0,0,0])),t=e;for(let n=0;n<200;n++){let o=y([0,0,0],t,1+wo);for(let{right:r}of s)o=y(o,r,-L(r,t)/s.length);t=N(y(o,e,wo*L(e,t)))}return t}function ge(s,e){let t=L(se,e);if(t<1e-9-1)return[s[0],-s[1],-s[2]];let n=F(se,e),o=F(n,s);return y(y(s,o),F(n,o),1/(1+t))}function bt(s){let e=typeof s=="string"?s.trim().split(/\s+/):[];if(e.length!==3||!e.every(n=>Oc.test(n)))return null;let t=e.map(Number);return t.some(n=>n!==0)?N(t):null}function vo(s,e){let t=[...Ge.keys()],n=i=>L(Ge.get(i)??se,e),o=t.reduce((i,a)=>n(a)>n(i)?a:i),r=[null,...t.filter(i=>i!==o)];return r[(r.indexOf(s===o?null:s)+1)%r.length]}var wo,Oc,Ge,se,we=S(()=>{"use strict";p();B();wo=.02,Oc=/^-?\d{1,9}(\.\d{1,9})?$/,Ge=new Map([["-y",[0,-1,0]],["z",[0,0,1]],["y",[0,1,0]],["-z",[0,0,-1]],["x",[1,0,0]],["-x",[-1,0,0]]]),se=[0,-1,0]});function vt(s){return s[0]===112&&s[1]===108&&s[2]===121}function xo(s){return s[0]===78&&s[1]===71&&s[2]===83&&s[3]===80||s[0]===31&&s[1]===139}var Wn=S(()=>{"use strict";p()});function Eo(s){let{offsets:e,stride:t,rows:n,start:o,footprint:r,up:i}=$c(s),a=new DataView(s.buffer,s.byteOffset+o),c=[...e.keys()].filter(v=>v.startsWith("f_rest_")).length,l=c/3+1;if(![1,4,9,16].includes(l))throw new Error(`the .ply file has ${c} numbers f_rest_*: 0, 9, 24 or 45 were expected`);let f=v=>e.get(v),h=["x","y","z","scale_0","scale_1","scale_2","rot_0","rot_1","rot_2","rot_3"];h.push("opacity","f_dc_0","f_dc_1","f_dc_2");for(let v=0;v+1<l;v++)for(let E=0;E<3;E++)h.push(`f_rest_${E*(l-1)+v}`);let d=h.find(v=>!e.has(v));if(d)throw new Error(`the .ply file has ${c} numbers f_rest_*, but not ${d}`);let m=h.map(f),u={...Xn(n,l,r),up:i},g=new Float32Array(m.length);for(let v=0;v<n;v++){for(let x=0;x<g.length;x++)g[x]=a.getFloat32(v*t+m[x],!0);for(let x=3;x<6;x++)g[x]===-1/0&&(g[x]=Uc);Math.abs(g[10])===1/0&&(g[10]=Math.sign(g[10])*Nc);let E=0;for(let x=0;x<g.length;x++)E+=g[x]*0;E===0&&Kn(u,g)}let{count:w}=u;return w===n||(u.shapes=u.shapes.slice(0,12*w),u.colors=u.colors.slice(0,3*l*w),u.lobes=u.lobes.slice(0,2*w)),u}function jn(s=""){return`'${s.slice(0,40).replace(/[^\x20-\x7e]/g,"\uFFFD")}'`}function Xn(s,e,t){return{count:0,packing:null,shapes:new Float32Array(12*s),colors:new Float32Array(3*e*s),shSize:e,lobes:new Float32Array(2*s),lobeSize:1,sorted:!0,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},footprint:t,background:[0,0,0]}}function Kn(s,e){let[t,n,o,r]=[e[6],e[7],e[8],e[9]],i=t*t+n*n+o*o+r*r;if(!(i>0))return;let a=2/i,[c,l,f]=[Math.exp(e[3]),Math.exp(e[4]),Math.exp(e[5])];if(!(c+l+f<1e30&&Math.abs(e[10])<1e30))return;let h=s.count++;s.shapes.set([c*(1-a*(o*o+r*r)),c*a*(n*o+t*r),c*a*(n*r-t*o),e[0],l*a*(n*o-t*r),l*(1-a*(n*n+r*r)),l*a*(o*r+t*n),e[1],f*a*(n*r+t*o),f*a*(o*r-t*n),f*(1-a*(n*n+o*o)),e[2]],12*h),s.lobes[2*h]=e[10]/Fc,s.colors.set(e.subarray(11),3*s.shSize*h)}function $c(s){let e=new TextDecoder("latin1").decode(s.subarray(0,zc)),t=/\nend_header\r?\n/.exec(e);if(!vt(s)||t===null)throw new Error("this is not a PLY file, or its header is cut off");let n=e.slice(0,t.index).split(/\r?\n/).map(d=>d.trim().split(/\s+/)),o=n.find(d=>d[0]==="format")?.[1];if(o!=="binary_little_endian")throw new Error(`the .ply file is ${jn(o)}: only binary_little_endian is read`);let r=n.findIndex(d=>d[0]==="element"),i=n[r]??[],a=/^\d+$/.test(i[2])?Number(i[2]):NaN;if(i[1]!=="vertex"||!Number.isSafeInteger(a)||a<0)throw new Error("the .ply file does not begin with its vertices, as those of 3DGS do");let c=new Map,l=0;for(let d of n.slice(r+1)){if(d[0]==="element")break;if(d[0]!=="property")continue;let m=Ic.get(d[1]);if(m===void 0)throw new Error(`the .ply file has a property of type ${jn(d[1])}`);if(d.length!==3)throw new Error("the .ply file has a property without a name, or with two");if(c.has(d[2]))throw new Error(`the .ply file has the property ${jn(d[2])} twice`);(d[1]==="float"||d[1]==="float32")&&c.set(d[2],l),l+=m}let f=yo.filter(d=>!c.has(d));if(f.length)throw new Error(`the .ply file is not a Gaussian scene: it lacks ${f.join(", ")} as floats`);let h=t.index+t[0].length;if(h+a*l>s.length)throw new Error(`the .ply file is cut off: ${a} Gaussians were announced`);return{offsets:c,stride:l,rows:a,start:h,footprint:Dc(n),up:Pc(n)}}function Dc(s){let e={...le};for(let[t,...n]of s){if(t!=="comment")continue;let o=n.join(" ");n[0]==="SplatRenderMode:"?e.antialiased=n[1]?.toLowerCase()==="mip":o==="antialiased 1"||o==="postshot.anti_aliasing=1"?e.antialiased=!0:n.length===3&&o.startsWith("mobilegs blur ")&&(e.blur=/^\d*\.?\d+$/.test(n[2])?Number(n[2]):NaN)}if(!(e.blur>0&&e.blur<=4))throw new Error("the .ply file names a blur that is not possible: above 0 and at most 4 is");return e}function Pc(s){let e=null;for(let t of s){let[n,o,r,...i]=t.map(a=>a.toLowerCase());n==="comment"&&(o==="vertical"&&r==="axis:"&&i.length===1&&(e=Cc.get(i[0])??e),o==="mobilegs"&&r==="up"&&(e=bt(i.join(" "))??e))}return e}var zc,Fc,Nc,Uc,Ic,Cc,yo,Yn=S(()=>{"use strict";p();ze();we();Wn();zc=65536,Fc=.28209479177387814,[Nc,Uc]=[13.8,-69],Ic=new Map([["char",1],["int8",1],["uchar",1],["uint8",1],["short",2],["int16",2],["ushort",2],["uint16",2],["int",4],["int32",4],["uint",4],["uint32",4],["float",4],["float32",4],["double",8],["float64",8]]),Cc=new Map([["x",[1,0,0]],["y",[0,-1,0]],["z",[0,0,1]]]),yo=["x","y","z","f_dc_0","f_dc_1","f_dc_2","opacity","scale_0","scale_1"];yo.push("scale_2","rot_0","rot_1","rot_2","rot_3")});function Y(s){return new DataView(s.buffer,s.byteOffset,s.byteLength)}function Ne(s,e){let t=Math.ceil(e/8);if(s.length!==t)throw new _(`packed bits take ${s.length} bytes where ${t} belong`);if(e%8&&s[t-1]>>e%8)throw new _("packed bits end in bits that are not zero");return new be(s)}var be,ve=S(()=>{"use strict";p();te();be=class{#e;#t=0;#o=0;constructor(e){this.#e=e}get left(){return 8*(this.#e.length-this.#t)-this.#o}take(e){let t=this.#e,n=this.#t,o=t[n]|t[n+1]<<8|t[n+2]<<16|t[n+3]<<24,r=this.#o+e,i=o>>>this.#o&(1<<e)-1;return this.#t=n+(r>>>3),this.#o=r&7,i}atEnd(){return this.left<8&&this.#e[this.#t]>>>this.#o===0}}});var ko,_o=S(()=>{"use strict";p();ko="0061736d01000000012a0460077f7f7f7f7f7f7d0060037f7f7f0060097f7f7f7f7f7f7f7f7f017f60097f7f7f7f7f7f7f7d7d00020f0103656e76066d656d6f727902000103060500010202030607017f014180080b073705056c61796572000005756e69747300010a70756c6c5f706c61696e00020f70756c6c5f636f6e7465787475616c0003047061636b00040abc21059c0404017f017b047f0b7b024020054101480d00200120054102746a21072006fd13210820044102742209410148210a0340200020094102746a210b4100210c03402001fd09000c210d2001fd090008210e2001fd090004210f2001fd090000211002400240200a450d00200d2111200e2112200f2113201021140c010b2002200c4102746a2104200d2111200e2112200f2113201021142000210503402004fd00001022152005fd0900002216fde6012010fde40121102004fd00000022172016fde6012014fde401211420152005fd0900042216fde601200ffde401210f20172016fde6012013fde401211320152005fd0900082216fde601200efde401210e20172016fde6012012fde401211220152005fd09000c2216fde601200dfde401210d20172016fde6012011fde401211120044180046a2104200541106a2205200b490d000b0b2003200c4102746a2205201120082011fde601fde901fd0b00800c2005201220082012fde601fde901fd0b0080082005201320082013fde601fde901fd0b0080042005201020082010fde601fde901fd0b00102005201420082014fde601fde901fd0b0000200541900c6a200d2008200dfde601fde901fd0b000020054190086a200e2008200efde601fde901fd0b000020054190046a200f2008200ffde601fde901fd0b0000200c41f800492105200c41086a210c20050d000b20034180106a2103200b2100200141106a22012007490d000b0b0bd50104027f017b027f017b200020024109746a2103410021040340fd0c0000000000000000000000000000000021052000200441027422066a22022107034020052007fd00000022082008fde601fde401210520074180046a22072003490d000b200120066a2107fd0c0000803f0000803f0000803f0000803f2005fde301fd0cccbc8c2bccbc8c2bccbc8c2bccbc8c2bfde901fde70121050340200720052002fd000000fde601fd0b000020074180046a210720024180046a22022003490d000b200441fc00492102200441046a210420020d000b0bd30101087f41002109034002402006200820092007491b220a4101480d002000200a4103746a210b2000210a0340024020022001200a280200220c41ffff0071220d4101746a2f0100220e4102746a280200220f0d0041000f0b20042f01002110200a28020420094101746a200e3b0102200a20104100200d200f410f766b200f41ffff0171200c410e766c6a220c4180800449220f1b200c200f41047474723602002004200f4101746a2104200a41086a220a200b490d000b0b0240200420054b0d00200941016a220920074d0d010b0b20040bf101010a7f410021094100210a0340024020062008200a2007491b220b4101480d002000200b4103746a210c2000210b0340024020022009200b280204200a4101746a220d2f010071220e20036c2001200e410f74200b280200220f41ffff00712210410174726a2f010022116a4102746a280200220e0d0041000f0b20042f01002112200d20113b0102200b201241002010200e410f766b200e41ffff0171200f410e766c6a220d4180800449220e1b200d200e41047474723602002004200e4101746a2104200b41086a220b200c490d000b0b0240200420054b0d00417f2109200a41016a220a20074d0d010b0b20040bfc1707067f027b037f0c7b037f0e7b017f2005417e7121092005410171210a200641036c210b2006410174210c20044180206a210d200541017441026a210e2008fd13210f2007fd132110410021112006410274221241027421130340fd0c020000000200000002000000020000002214fd0c010000000100000001000000010000002215fd0c0000000000000000000000000000000022162001fd000080042217fde0012001fd0000002218fde001fd442219fd522001fd00008008221afde001201720182019fd522217fde001fd442218fd522119fd0c03000000030000000300000003000000211b2001fd0000800c221c201a20172018fd522217201cfde0012017fde001fd44221dfd52221efd0cffffff7fffffff7fffffff7fffffff7f221cfd4e2016fd37211ffd0c0000000000000000000000000000000022172118410121202016211a4100212102400240024020050e020201000b0340201720032020410a746a2222fd000000fde001fde90120224180086afd000000fde001fde9012117201820224180046afd000000fde001fde901202241800c6afd000000fde001fde9012118202041026a2120202141026a22212009470d000b0b0240200a450d00201720032020410a746a2222fd000000fde001fde9012117201820224180046afd000000fde001fde90121180b2018fd0cffff0f00ffff0f00ffff0f00ffff0f00221afdae014114fdad0121162017201afdae014114fdad01211a0b201b2019201dfd52211d200d2003fd000080042217fd0c000000800000008000000080000000802223fd4e2003fd00000022184110fdad01fd0c008000000080000000800000008000002224fd4efd502018201cfd4e2219fd0c0000804b0000804b0000804b0000804b2225fde601fd6afdf80120192018410dfdad012015fd4efdae01fd0cff0f00c8ff0f00c8ff0f00c8ff0f00c82226fdae01410dfdad01fd0cff7b0000ff7b0000ff7b0000ff7b00002227fdb7012019fd0c000080380000803800008038000080382228fd3afd52fd502017201cfd4e22182025fde601fd6afdf80120182017410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120182028fd3afd524110fdab01fd502217fd0c0000ffff0000ffff0000ffff0000fffffd4efd0ce2f00000e2f00000e2f00000e2f00000fd502017201ffd522217fd5a00000041022120200d20064102746a2017fd5a000001200d200c4102746a2017fd5a000002200d200b4102746a2017fd5a0000032016fd0c78030000780300007803000078030000221ffdb901fd0c770400007704000077040000770400002229fdb601fd0c88fcffff88fcffff88fcffff88fcffff222afdae01212bfd0c00008037000080370000803700008037212cfd0c0000fe420000fe420000fe420000fe422117201a201ffdb9012029fdb601202afdae01212d0240200e41024d0d002017202b4114fdab01202cfdae01fde70121192017202d4114fdab01202cfdae01fde701211a200d21220340202241046a22222019200320204109742221418004726afd000000fde601fd0c0000fec20000fec20000fec20000fec22218fde9012017fde801fd0c002000440020004400200044002000442216fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4e201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf801fd0cff000000ff000000ff000000ff000000fd4e2019200320214180086a2221418004726afd000000fde6012018fde9012017fde8012016fde401fdf8014118fdab01201a200320216afd000000fde6012018fde9012017fde8012016fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4efd50fd50fd502218fd5a000000202220126a2018fd5a0000012022200c4102746a2018fd5a0000022022200b4102746a2018fd5a000003202041046a2220200e490d000b0b200441346a202d4110fdab01202b4118fdab01fd502218fd5a000003200441246a2018fd5a000002200441146a2018fd5a000001200441046a2018fd5a000000200441386a200f2000fd00008004fdfa012010fde501fde601fd0c000000000000000000000000000000002218fde901fd0c0000803f0000803f0000803f0000803f2216fde801fd0c00e0ff4400e0ff4400e0ff4400e0ff44221afde601fd0c0000003f0000003f0000003f0000003f2219fde401fdf801410bfdab01200f2000fd00008008fdfa012010fde501fde6012018fde9012016fde801fd0c00c07f4400c07f4400c07f4400c07f44fde6012019fde401fdf8014116fdab01fd50200f2000fd000000fdfa012010fde501fde6012018fde9012016fde801201afde6012019fde401fdf801fd502216fd5a000003200441286a2016fd5a000002200441186a2016fd5a000001200441086a2016fd5a0000002004413c6afd0c71aa34c471aa34c471aa34c471aa34c4fd0c71aa344471aa344471aa344471aa3444201e2018fd43fd5222162001fd00008004221a2001fd000000201d2015fd39fd52fde601fd0c001080440010804400108044001080442219fde401fdf801410afdab01fd0c00fc0f0000fc0f0000fc0f0000fc0f00fd4e201d4114fdab01fd5020162001fd00008008222b201a201d2014fd39fd52fde6012019fde401fdf801fd0cff030000ff030000ff030000ff030000221afd4efd50410afdab0120162001fd0000800c202b201d201bfd39fd52fde6012019fde401fdf801201afd4efd502216fd5a0000032004412c6a2016fd5a0000022004411c6a2016fd5a0000012004410c6a2016fd5a0000002002fd0000802c211d2002fd00008028211b2002fd00008024212b2002fd00008020212d2002fd0000801c21142002fd00008018211e2002fd00008014212e2002fd00008010212f2002fd0000800c2130200441b0106a2002fd0000800422162023fd4e2002fd00000022194110fdad012024fd4efd502019201cfd4e221a2025fde601fd6afdf801201a2019410dfdad012015fd4efdae012026fdae01410dfdad012027fdb701201a2028fd3afd52fd502016201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd524110fdab01fd502216fd5a000003200441a0106a2016fd5a00000220044190106a2016fd5a00000120044180106a2016fd5a000000200441b4106a2002fd000080082216201cfd4e22192025fde601fd6afdf80120192016410dfdad012015fd4efdae012026fdae01410dfdad012027fdb70120192028fd3afd522030fde0012018fde901202ffde001fde901202efde001fde901201efde001fde9012014fde001fde901202dfde001fde901202bfde001fde901201bfde001fde901201dfde001fde901fd0cffff0f00ffff0f00ffff0f00ffff0f00fdae014114fdad01201ffdb9012029fdb601202afdae0122184110fdab0120164110fdad012024fd4efd50fd502002fd0000800c201720184114fdab01202cfdae01fde7012218fde601fd0c0000fec20000fec20000fec20000fec22216fde9012017fde801fd0c002000440020004400200044002000442219fde401fdf8014118fdab01fd50221afd5a000003200441a4106a201afd5a00000220044194106a201afd5a00000120044184106a201afd5a00000020044188106a213141002120410121210340203120204102746a222241306a20182020410b7420026a22204180186afd000000fde6012016fde9012017fde8012019fde401fdf8014110fdab01fd0c0000ff000000ff000000ff000000ff00fd4e2018202041801c6afd000000fde6012016fde9012017fde8012019fde401fdf8014118fdab01fd50201820204180146afd000000fde6012016fde9012017fde8012019fde401fdf8014108fdab01fd0c00ff000000ff000000ff000000ff0000fd4efd50201820204180106afd000000fde6012016fde9012017fde8012019fde401fdf801fd0cff000000ff000000ff000000ff000000fd4efd50221afd5a000003202241206a201afd5a000002202241106a201afd5a0000012022201afd5a00000020214101712122410021214101212020220d000b200441c0006a2104200341106a2103200241106a2102200141106a2101200041106a2100200d20136a210d201141fc00492122201141046a211120220d000b0b"});function xt(s){return typeof WebAssembly=="object"?new WebAssembly.Memory({initial:Math.ceil(s/2**16)}):null}function Ue(s){if(s===null)return null;if(Ve===void 0)try{let t=ko.match(/../g);Ve=new WebAssembly.Module(Uint8Array.from(t,n=>parseInt(n,16)))}catch{Ve=null}if(Ve===null)return null;let e=Ao.get(s);if(!e){let{exports:t}=new WebAssembly.Instance(Ve,{env:{memory:s}});e=t,Ao.set(s,e)}return e}var Ve,Ao,yt=S(()=>{"use strict";p();_o();Ao=new WeakMap});function So({contexts:s,alphabet:e,symbols:t,spans:n},o,r,i,a){xe===void 0&&(xe=xt(1));let c=Ue(xe);if(xe===null||c===null)return;let l=o.length,f=Qn+2*t.length,h=f+4*n.length,d=h+i.length,m=d+2*l+2,u=Math.ceil((m+2*a+2)/2**16)-xe.buffer.byteLength/2**16;u>0&&xe.grow(u);let{buffer:g}=xe,w=new Uint32Array(g,0,2*l);o.forEach((x,A)=>w.set([x,m-2+2*r[A]],2*A)),new Uint16Array(g,Qn,t.length).set(t),new Uint32Array(g,f,n.length).set(n),new Uint8Array(g,h,i.length).set(i);let E=(s>1?c.pull_contextual:c.pull_plain)(0,Qn,f,e,h,d,l,Math.floor(a/l),a%l);return{decoded:new Uint16Array(g,m,a).slice(),left:E?(d-E)/2:-1/0,states:w.filter((x,A)=>A%2===0)}}var Qn,xe,Mo=S(()=>{"use strict";p();yt();Qn=2048});function ye(s,e,t,n=!1){if(s.length<Et)throw new _("a rANS stream is too short to hold its header");let o=Y(s),r=o.getUint16(0,!0),i=o.getUint16(2,!0),a=o.getUint32(4,!0),c=o.getUint32(8,!0);if(r!==t)throw new _(`a rANS stream of ${r} symbols stands where ${t} belong`);if(i!==1&&i!==t||i>Bc)throw new _(`a rANS stream has ${i} contexts`);let l=Gc(e);if(s.length!==Et+a+4*l+2*c)throw new _("a rANS stream is longer or shorter than its header says");let f=Et+a,h=Wc(s.subarray(Et,f),i,t),d=new Uint32Array(l).map((E,x)=>o.getUint32(f+4*x,!0));if(d.some(E=>E<To))throw new _("a rANS stream starts in an impossible state");let m=Math.floor(e/l),u=e%l,g=d.map((E,x)=>x*m+Math.min(x,u)),w=[h,d,g,s.subarray(f+4*l),e],v=(n?void 0:So(...w))??Vc(...w);if(v.left===Ro)throw new _("a rANS stream leads to a context that is not used: it is damaged");if(v.left<0)throw new _("a rANS stream ends early: the file is damaged");if(v.left>0||v.states.some(E=>E!==To))throw new _("a rANS stream does not end where it should: the file is damaged");return v.decoded}function Gc(s){let e=Math.max(1,Math.floor(s/qc));return Math.min(Hc,1<<31-Math.clz32(e))}function Vc({contexts:s,alphabet:e,symbols:t,spans:n},o,r,i,a){let c=o.length,l=Math.floor(a/c),f=a%c,h=new Uint16Array(a),d=i.length/2,m=new Uint16Array(d+1);new Uint8Array(m.buffer).set(i);let u=0;for(let g=0;g<=l;g++){let w=g<l?c:f,v=s>1&&g>0;for(let E=0;E<w;E++){let x=r[E]+g,A=v?h[x-1]:0,M=o[E],R=M&je-1,$=t[A<<kt|R],V=n[A*e+$];if(V===0)return{decoded:h,left:Ro,states:o};let ae=Math.imul(V&32767,M>>>kt)+R-(V>>>15)|0,I=(ae>>>16)-1>>>31;o[E]=ae<<16*I|m[u]&-I,u+=I,h[x]=$}}return{decoded:h,left:d-u,states:o}}function Wc(s,e,t){let n=new be(s),o=new Uint16Array(e*je),r=new Uint32Array(e*t);for(let i=0;i<e;i++){if(!We(n,1))continue;let a=jc(n,t),c=i*je;for(let l=0;l<t;l++){let f=a[l];f!==0&&(r[i*t+l]=c%je<<15|f,o.fill(l,c,c+f),c+=f)}}if(!n.atEnd())throw new _("a rANS stream's frequency tables are longer than they should be");return{contexts:e,alphabet:t,symbols:o,spans:r}}function jc(s,e){let t=new Uint16Array(e),n=[];for(let a=0;a<e;a++)We(s,1)&&n.push(a);let o=We(s,4),r=n.pop(),i=je;for(let a of n){let c=o;for(;!We(s,1);)c++;if(c>kt)throw new _("a rANS stream's frequency table holds a number out of range");t[a]=We(s,c)+(1<<c)-(1<<o)+1,i-=t[a]}if(r===void 0||i<1)throw new _("a rANS stream's frequencies do not sum to 16384");return t[r]=i,t}function We(s,e){if(e>s.left)throw new _("a rANS stream's frequency tables end early");return s.take(e)}var kt,je,To,Bc,Hc,qc,Et,Ro,_t=S(()=>{"use strict";p();ve();te();Mo();kt=14,je=1<<kt,To=65536,Bc=64,Hc=256,qc=2048,Et=12,Ro=-1/0});function Zn(s){return(s&31744)===31744}function H(s){let e=s>>10&31,t=(s&1023)+(e>0?1024:0);return(s&32768?-t:t)*Xc[e]}function oe(s){Oo[0]=s;let e=Lo[0]>>>16&32768,t=Lo[0]&2147483647;if(t<947912704){let n=Math.abs(s)*16777216,o=Math.round(n);return e|(o-n===.5&&o%2?o-1:o)}return e|Math.min(t+4095+(t>>>13&1)-939524096>>>13,31743)}function Jn(s,e){let t=Kc(s,e);if(t.some(Zn))throw new _(`the stream '${s.name}' of the .mgs file has numbers that are not finite`);return Float32Array.from(t,H)}function Kc({name:s,codec:e,data:t},n){let o=new _(`the stream '${s}' of the .mgs file has a wrong length`);if(e==="raw"){if(t.length!==2*n)throw o;return Uint16Array.from({length:n},(l,f)=>t[2*f]|t[2*f+1]<<8)}if(t.length<4)throw o;let r=4+Y(t).getUint32(0,!0);if(r>t.length||e==="halves"&&t.length!==r+n)throw o;let i=ye(t.subarray(4,r),n,256),a=t.subarray(r),c=e==="planes"?ye(a,n,256):a;return i.map((l,f)=>l<<8|c[f])}var Xc,Oo,Lo,fe=S(()=>{"use strict";p();ve();te();_t();Xc=Float64Array.from({length:31},(s,e)=>2**(Math.max(e,1)-25)),Oo=new Float32Array(1),Lo=new Uint32Array(Oo.buffer)});function zo(s){let e=new Uint8Array(1);return{accuracy:0,symbols:Uint8Array.of(s),bits:e,bases:new Uint16Array(1)}}function Xe(s,e){let t=1<<s,n={accuracy:s,symbols:new Uint8Array(t),bits:new Uint8Array(t),bases:new Uint16Array(t)},o=t;for(let[c,l]of e.entries())l===-1&&(n.symbols[--o]=c);let r=(t>>1)+(t>>3)+3,i=0;for(let[c,l]of e.entries())for(let f=0;f<l;f++){n.symbols[i]=c;do i=i+r&t-1;while(i>=o)}if(i!==0)throw new Error(j);let a=e.map(c=>Math.abs(c));for(let c=0;c<t;c++){let l=a[n.symbols[c]]++,f=s-(31-Math.clz32(l));n.bits[c]=f,n.bases[c]=(l<<f)-t}return n}function es(s,e,t,n){let o=8*e,r=l=>{let f=o>>3,d=(s[f]|s[f+1]<<8|s[f+2]<<16)>>(o&7)&(1<<l)-1;return o+=l,d},i=5+r(4);if(i>t)throw new Error(j);let a=[];for(let l=1<<i;l>0;){let f=32-Math.clz32(l+1),h=(1<<f)-2-l,d=r(f-1);d>=h&&r(1)&&(d+=(1<<f-1)-h);let m=d-1;l-=Math.abs(m),a.push(m);for(let u=m===0?3:0;u===3;){u=r(2);for(let g=0;g<u;g++)a.push(0)}if(l<0||a.length>n)throw new Error(j)}let c=o+7>>3;if(c>s.length)throw new Error(j);return{table:Xe(i,a),end:c}}function Fo(s,e){let t=s[e++];if(!(t<128)){let l=t-127,f=e+(l+1>>1);if(!(f<=s.length))throw new Error(j);let h=d=>s[e+(d>>1)]>>(d%2?0:4)&15;return{weights:Array.from({length:l},(d,m)=>h(m)),end:f}}let n=e+t;if(n>s.length)throw new Error(j);let{table:o,end:r}=es(s.subarray(0,n),e,6,13),i=new Ee(s.subarray(r,n)),a=[],c=[i.take(o.accuracy),i.take(o.accuracy)];for(let l=0;a.length<255;l^=1){let f=c[l];if(a.push(o.symbols[f]),c[l]=o.bases[f]+i.take(o.bits[f]),i.left<0)return a.push(o.symbols[c[l^1]]),{weights:a,end:n}}throw new Error(j)}function No(s){let e=c=>c>0?1<<c-1:0,t=0;for(let c of s)t+=e(c);let n=32-Math.clz32(t),o=(1<<n)-t;if(t===0||n>11||o&o-1)throw new Error(j);let r=[...s,32-Math.clz32(o)];if(r.length>256)throw new Error(j);let i={width:n,symbols:new Uint8Array(1<<n),bits:new Uint8Array(1<<n)},a=0;for(let c=1;c<=n;c++)for(let[l,f]of r.entries()){if(f!==c)continue;let h=a+e(c);i.symbols.fill(l,a,h),i.bits.fill(n+1-c,a,h),a=h}return i}var j,Ee,Uo=S(()=>{"use strict";p();j="the compressed data is damaged or cut off",Ee=class{left;#e;constructor(e){let t=e[e.length-1];if(!t)throw new Error(j);this.#e=e,this.left=8*e.length-1-Math.clz32(t)+24}take(e){return e>24?this.take(e-16)*65536+this.take(16):(this.left-=e,this.#t(this.left,e))}decode(e,{width:t,symbols:n,bits:o}){for(let r=0;r<e.length;r++){let i=this.#t(this.left-t,t);e[r]=n[i],this.left-=o[i]}if(this.left!==0)throw new Error(j)}#t(e,t){let n=this.#e;if(e<0)return e+t>0?this.#t(0,e+t)<<-e:0;let o=e>>3;return(n[o]|n[o+1]<<8|n[o+2]<<16|n[o+3]<<24)>>>(e&7)&(1<<t)-1}}});function $o(s,e){let t=[];for(let n of e)t.push(s),s+=2**n;return{bits:e,bases:t}}function Do(s,e){let t=new ts(e),n=new DataView(s.buffer,s.byteOffset,s.byteLength),o=0;for(;o<s.length;){if(o+8>s.length)throw new Error(U);let r=n.getUint32(o,!0);if(r>>>4===Qc)o+=8+n.getUint32(o+4,!0);else if(r===Yc)o=Jc(s,o+4,t);else throw new Error(U)}if(o!==s.length||t.length!==e)throw new Error(U);return t.bytes}function Jc(s,e,t){let n=s[e++],o=(n&32)!==0;if(o||(e+=1),s.subarray(e,e+=[0,1,2,4][n&3]).some(a=>a))throw new Error("the compressed data needs a dictionary, which is missing");e+=[o?1:0,2,4,8][n>>6];let i={huffman:null,tables:[null,null,null],recent:[1,4,8]};for(let a=!1;!a;){if(e+3>s.length)throw new Error(U);let c=s[e]|s[e+1]<<8|s[e+2]<<16;e+=3,a=(c&1)===1;let l=c>>1&3,f=c>>3,h=l===1?1:f;if(l===3||f>Ke||e+h>s.length)throw new Error(U);l===0?t.append(s.subarray(e,e+f)):l===1?t.fill(s[e],f):el(s.subarray(e,e+f),i,t),e+=h}return e+(n&4?4:0)}function el(s,e,t){let{literals:n,end:o}=sl(s,e),r=o,i=s[r++];if(i===void 0)throw new Error(U);if(i===255?(i=s[r]+(s[r+1]<<8)+32512,r+=2):i>127&&(i=(i-128<<8)+s[r++]),i===0){t.append(n);return}let a=s[r++];if(!(i>0)||a===void 0||a&3)throw new Error(U);for(let[c,{accuracy:l,symbols:f,usual:h}]of Zc.entries()){let d=a>>6-2*c&3;if(d===0)e.tables[c]=h;else if(d===1){if(!(s[r]<f))throw new Error(U);e.tables[c]=zo(s[r++])}else if(d===2){let{table:m,end:u}=es(s,r,l,f);e.tables[c]=m,r=u}}tl(new Ee(s.subarray(r)),i,n,e,t)}function tl(s,e,t,{tables:n,recent:o},r){let[i,a,c]=n;if(!i||!a||!c)throw new Error(U);let l=s.take(i.accuracy),f=s.take(a.accuracy),h=s.take(c.accuracy),d=0,m=r.length+Ke;for(let u=e;u>0;u--){let g=a.symbols[f],w=c.symbols[h],v=i.symbols[l],E=2**g+s.take(g),x=Co.bases[w]+s.take(Co.bits[w]),A=Io.bases[v]+s.take(Io.bits[v]);if(u>1&&(l=i.bases[l]+s.take(i.bits[l]),h=c.bases[h]+s.take(c.bits[h]),f=a.bases[f]+s.take(a.bits[f])),s.left<0||d+A>t.length)throw new Error(U);if(r.append(t.subarray(d,d+A)),d+=A,r.repeat(nl(E,A,o),x),r.length>m)throw new Error(U)}if(s.left!==0)throw new Error(U);r.append(t.subarray(d))}function nl(s,e,t){if(s>3)return t.unshift(s-3),t.pop(),t[0];let n=e===0?s:s-1,o=n<3?t[n]:t[0]-1;return n>0&&(t.splice(Math.min(n,2),1),t.unshift(o)),o}function sl(s,e){let t=s[0]|s[1]<<8|s[2]<<16,n=s[0]&3,o=s[0]>>2&3;if(n<2){let d=[1,2,1,3][o],m=d===1?s[0]>>3:(t&(d===2?65535:16777215))>>4,u=d+(n===0?m:1);if(m>Ke||!(u<=s.length))throw new Error(U);return n===0?{literals:s.subarray(d,u),end:u}:{literals:new Uint8Array(m).fill(s[d]),end:u}}let r=[3,3,4,5][o],i=[10,10,14,18][o],a=(t>>>0)+(s[3]??0)*2**24+(s[4]??0)*2**32,c=Math.floor(a/16)%2**i,l=Math.floor(a/2**(4+i))%2**i,f=r+l;if(c>Ke||!(f<=s.length))throw new Error(U);let h=r;if(n===2){let{weights:d,end:m}=Fo(s.subarray(0,f),h);e.huffman=No(d),h=m}if(e.huffman===null)throw new Error(U);return{literals:ol(s.subarray(h,f),c,o!==0,e.huffman),end:f}}function ol(s,e,t,n){let o=new Uint8Array(e);if(!t)return new Ee(s).decode(o,n),o;if(s.length<6)throw new Error(U);let r=e+3>>2;for(let i=0,a=6;i<4;i++){let c=i<3?s[2*i]|s[2*i+1]<<8:s.length-a;if(a+c>s.length)throw new Error(U);let l=i<3?(i+1)*r:e;if(l>e)throw new Error(U);new Ee(s.subarray(a,a+c)).decode(o.subarray(i*r,l),n),a+=c}return o}var Yc,Qc,Ke,U,Io,Co,Zc,ts,Po=S(()=>{"use strict";p();Uo();Yc=4247762216,Qc=25481893,Ke=1<<17,U="the compressed data is damaged or cut off";Io=$o(0,[...Array(16).fill(0),1,1,1,1,2,2,3,3,4,6,7,8,9,10,11,12,13,14,15,16]),Co=$o(3,[...Array(32).fill(0),1,1,1,1,2,2,3,3,4,4,5,7,8,9,10,11,12,13,14,15,16]),Zc=[{accuracy:9,symbols:36,usual:Xe(6,[4,3,2,2,2,2,2,2,2,2,2,2,2,1,1,1,2,2,2,2,2,2,2,2,2,3,2,1,1,1,1,1,-1,-1,-1,-1])},{accuracy:8,symbols:32,usual:Xe(5,[1,1,1,1,1,1,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1])},{accuracy:9,symbols:53,usual:Xe(6,[1,4,3,2,2,2,2,2,2,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,-1,-1,-1,-1,-1,-1,-1])}],ts=class{length=0;bytes;#e;constructor(e){this.#e=e,this.bytes=new Uint8Array(Math.min(e,Ke))}reserve(e){let t=this.length+e;if(t>this.#e)throw new Error("the compressed data is longer than announced");if(t<=this.bytes.length)return;let n=new Uint8Array(Math.min(this.#e,Math.max(t,2*this.bytes.length)));n.set(this.bytes.subarray(0,this.length)),this.bytes=n}append(e){this.reserve(e.length),this.bytes.set(e,this.length),this.length+=e.length}fill(e,t){this.reserve(t),this.bytes.fill(e,this.length,this.length+t),this.length+=t}repeat(e,t){if(!(e>0&&e<=this.length))throw new Error(U);this.reserve(t);let{bytes:n}=this,o=this.length+t;if(e>=t)n.copyWithin(this.length,this.length-e,o-e);else for(let r=this.length;r<o;r++)n[r]=n[r-e];this.length=o}}});async function Go(s){if(s[0]!==31){let r=Vo(s,s.length);return Bo(r,hl(r,s))}let{header:e,content:t}=await fl(s),n=[],o=At;for(let r of ns(e))n.push(t.subarray(o,o+=r));return Bo(e,n)}function Vo(s,e){let t=new DataView(s.buffer,s.byteOffset,s.byteLength);if(s.length<At||t.getUint32(0,!0)!==rl)throw new Error("this is not a .spz file");let n=t.getUint32(4,!0),o=n<4;if(n<1||n>4)throw new Error(`the .spz file has version ${n}: 1 to 4 are read`);if(!o&&s.length<Ho)throw new Error(ke);let r=t.getUint32(8,!0),[i,a,c,l]=s.subarray(12,16);if(r>il)throw new Error(`the .spz file announces ${r} Gaussians, too many to be drawn`);if(r>e)throw new Error(`the .spz file announces ${r} Gaussians in ${e} bytes: it is cut off`);if(i>4||a>24)throw new Error(ke);let[f,h]=[(c&1)!==0,(c&2)!==0];return{version:n,count:r,degree:i,fraction:a,antialiased:f,extended:h,streams:l,table:o?0:t.getUint32(16,!0)}}function ns({version:s,count:e,degree:t}){return[s===1?6:9,1,3,3,s<3?3:4,3*qo[t]].map(n=>n*e)}async function fl(s){let t=new Response(s).body.pipeThrough(new DecompressionStream("gzip")).getReader(),n=[],o=0,r=null,i=1/0,a=async()=>new Uint8Array(await new Blob(n).arrayBuffer());for(;o<=i;){let{value:c,done:l}=await t.read().catch(()=>{throw new Error(ke)});if(l)break;if(n.push(c),o+=c.length,r===null&&o>=At){if(r=Vo(await a(),s.length),r.version>3)throw new Error("this is not a .spz file");i=ns(r).reduce((f,h)=>f+h,At)}}if(r===null)throw new Error("this is not a .spz file");if(o>i&&(await t.cancel().catch(()=>{}),!r.extended))throw new Error("the .spz file holds more than it announces");if(o<i)throw new Error(`the .spz file is cut off: ${r.count} Gaussians were announced`);return{header:r,content:await a()}}function hl(s,e){let{streams:t,table:n,version:o}=s,r=ns(s),i=n+16*t,a=r.filter(h=>h>0).length;if(o!==4||n<Ho||i>e.length||t!==a)throw new Error(ke);let c=new DataView(e.buffer,e.byteOffset,e.byteLength),[l,f]=[n,i];return r.map(h=>{if(h===0)return new Uint8Array(0);let d=Number(c.getBigUint64(l,!0)),m=Number(c.getBigUint64(l+8,!0));if(l+=16,f+d>e.length||m!==h)throw new Error(ke);let u=e.subarray(f,f+=d);try{return Do(u,h)}catch(g){throw new Error(`${ke}: ${g instanceof Error?g.message:g}`)}})}function Bo({version:s,count:e,degree:t,fraction:n,antialiased:o},r){let[i,a,c,l,f,h]=r,d=qo[t],m=Math.min(d,al),u=m+1,g=Xn(e,u,{...le,antialiased:o}),w=new Float32Array(11+3*u),v=s===1?ul(i):dl(i,2**-n),E=s<3?pl:ml;for(let x=0;x<e;x++){w[0]=v(3*x),w[1]=-v(3*x+1),w[2]=-v(3*x+2);for(let M=0;M<3;M++)w[3+M]=l[3*x+M]/16-10;E(f,x,w);let A=Math.min(Math.max(a[x]/255,1e-6),1-1e-6);w[10]=Math.log(A/(1-A));for(let M=0;M<3;M++)w[11+M]=(c[3*x+M]/255-.5)/cl;for(let M=0;M<m;M++)for(let R=0;R<3;R++)w[14+3*M+R]=ll[M]*(h[3*(d*x+M)+R]-128)/128;Kn(g,w)}return g}function dl(s,e){return t=>{let n=3*t;return e*((s[n]<<8|s[n+1]<<16|s[n+2]<<24)>>8)}}function ul(s){return e=>{let t=H(s[2*e]|s[2*e+1]<<8);if(!Number.isFinite(t))throw new Error(ke);return t}}function pl(s,e,t){let[n,o,r]=[0,1,2].map(a=>s[3*e+a]/127.5-1),i=Math.sqrt(Math.max(0,1-n*n-o*o-r*r));t.set([i,n,-o,-r],6)}function ml(s,e,t){let n=4*e,o=s[n]|s[n+1]<<8|s[n+2]<<16|s[n+3]<<24,r=o>>>30,i=[0,0,0,0],a=1;for(let c=0,l=20;c<4;c++){if(c===r)continue;let f=(o>>l&511)/511*Math.SQRT1_2;i[c]=o>>l+9&1?-f:f,a-=f*f,l-=10}i[r]=Math.sqrt(Math.max(0,a)),t.set([i[3],i[0],-i[1],-i[2]],6)}var rl,il,At,Ho,qo,al,cl,ll,ke,Wo=S(()=>{"use strict";p();fe();ze();Yn();Po();rl=1347635022,il=1e7,At=16,Ho=32,qo=[0,3,8,15,24],al=15,cl=.15,ll=[-1,-1,1,-1,1,1,-1,1,-1,1,-1,-1,1,-1,1],ke="the .spz file is damaged or cut off"});var jo={};Be(jo,{readPly:()=>Eo,readSpz:()=>Go});var Xo=S(()=>{"use strict";p();Yn();Wo()});function ss(){let s=URL.createObjectURL(new Blob([`${Jo()}(${bundle})()`],{type:"text/javascript"}));return setTimeout(()=>URL.revokeObjectURL(s),6e4),new Worker(s)}function Ko(s,e){let t=globalThis.preloadedWorker;delete globalThis.preloadedWorker;let n;return t&&"url"in s&&t.url===s.url?(n=t.worker,t.messages.forEach(e)):(t?.worker.terminate(),n=ss(),n.postMessage(s)),n.onmessage=e,n}async function Yo(){let s=globalThis.preloadedAdapter;return delete globalThis.preloadedAdapter,await s??navigator.gpu.requestAdapter({powerPreference:"high-performance"})}async function St(s){return b[s]}function Qo(){return"0.1.0"}function Zo(){let s=document.getElementById("scene");if(s===null)return null;let e=atob(s.textContent),t=new Uint8Array(e.length);for(let n=0;n<t.length;n++)t[n]=e.charCodeAt(n);return new Blob([t])}var _e=S(()=>{p();re()});function er(s){return s?.soft_edge?1:1.4}function he(s,e){let t=[[s,e]];for(let n=1;n<4;n++)t.push(t[n-1].map(o=>(o-(n===1?0:1)>>1)+2));return t}function de(s,e){let[,...t]=he(s,e),n=[[0,0]],o=0;for(let[,r]of t)n.push([s,o]),o+=r;return{places:n,size:[s+t[0][0],Math.max(e,o)]}}var Ye=S(()=>{"use strict";p()});function tr(s){let[e,t,n]=[1,2,3].map(c=>s[`hidden${c}.weight`]),o=["opacity","phi"].map(c=>({weights:gl(s[`${c}.weight`],n,128),offset:s[`${c}.weight`].reduce((l,f,h)=>l+f*s["hidden3.bias"][h],s[`${c}.bias`][0])})),r=new Float32Array(16*2497),i=0,a=(c,l,f)=>{for(let h=c;h<c+4;h++)for(let d=l;d<l+4;d++)r[i++]=f(h,d)};for(let c=0;c<256;c+=4)for(let l=0;l<24;l+=4)a(c,l,(f,h)=>h<22?e[22*f+h]:h===22?s["hidden1.bias"][f]:0);for(let c=0;c<128;c+=4)a(c,0,(l,f)=>f===0?s["hidden2.bias"][l]:0);for(let c=0;c<256;c+=4)for(let l=0;l<128;l+=4)a(l,c,(f,h)=>t[256*f+h]);for(let c=0;c<128;c+=4)a(0,c,(l,f)=>o[l]?.weights[f]??0);return a(0,0,(c,l)=>l===0?o[c]?.offset??0:0),r}function gl(s,e,t){return Array.from({length:t},(n,o)=>s.reduce((r,i,a)=>r+i*e[t*a+o],0))}var nr=S(()=>{"use strict";p()});function Ie({packing:s,shSize:e,lobeSize:t,network:n}){return s?{shapes:4,colors:4,lobes:n?10:t+2>>1}:{shapes:12,colors:3*e,lobes:2*t}}function sr(s){return H(s&65535)}var Ze=S(()=>{"use strict";p();fe()});function et(s,e){let{fx:t,fy:n,cx:o,cy:r,width:i,height:a}=s;return{...s,fx:e*t,fy:e*n,cx:e*o,cy:e*r,width:e*i,height:e*a}}function Tt(s,e,t,n,o){let{viewmat:r,fx:i,fy:a,cx:c,cy:l,width:f,height:h,near:d}=e,{background:m,weighting:u,packing:g,footprint:w=le}=s,v=or*.5*f/i,E=or*.5*h/a,x=[0,1,2].map(I=>-(r[I]*r[3]+r[4+I]*r[7]+r[8+I]*r[11])),A=new Float32Array(Je/4);A.set([...Array.from(r).slice(0,12),...x,d,i,a,c,l,-c/i-v,(f-c)/i+v,-l/a-E,(h-l)/a+E,...m,u.exponentMax,f,h,u.sigma,u.backgroundWeight,t]);let M=[s.count,s.shSize,s.lobeSize,u.index];if(new Int32Array(A.buffer).set(M,33),g){let{center:I,unit:K,leastScaleBits:ce,scaleBitsSpan:nc}=g;A.set([...I,K,ce,nc],40)}A[46]=!s.sorted&&u.alphaMin||1/255,A[47]=w.blur,new Int32Array(A.buffer).set([Number(w.antialiased),Number(w.soft_edge&&!s.sorted)],48),A[50]=n,new Int32Array(A.buffer)[51]=o;let R=he(f,h),{places:$,size:V}=de(f,h),ae=$.flatMap(([I,K],ce)=>[I,K,I+R[ce][0],K+R[ce][1]]);return A.set([...ae,...V],52),A}var Je,Mt,or,Rt=S(()=>{"use strict";p();ze();Ye();Je=336,Mt=2**-6,or=.3});var Lt,rr=S(()=>{"use strict";p();Lt=class{milliseconds=null;#e;#t;#o=!1;#s=!1;#n=[];constructor(e){this.#e=e,this.#t=e.getExtension("EXT_disjoint_timer_query_webgl2")}start(){this.#s=this.#o&&!this.#n.length}pass(e){if(!this.#s)return;let[t,n]=[this.#e,this.#t.TIME_ELAPSED_EXT];if(this.#n.length&&t.endQuery(n),e){let o=t.createQuery();this.#n.push([e,o]),t.beginQuery(n,o)}else this.#s=!1}async time(){let e=this.#e;this.#o=this.#t!==null;let t=this.#n[this.#n.length-1];if(!t||this.#s)return;for(let o=0;o<100&&!e.getQueryParameter(t[1],e.QUERY_RESULT_AVAILABLE);o++)await new Promise(r=>setTimeout(r,5));let n=this.#n.map(([o,r])=>[o,e.getQueryParameter(r,e.QUERY_RESULT)/1e6]);e.getParameter(this.#t.GPU_DISJOINT_EXT)||(this.milliseconds=Object.fromEntries(n));for(let[,o]of this.#n.splice(0))e.deleteQuery(o)}forget(){this.#n=[],this.#s=!1}}});function Ot({color:s,side:e},{viewmat:t,fx:n,fy:o,cx:r,cy:i,width:a,height:c,near:l}){let[f,h,d]=[0,4,8].map(m=>Array.from(t).slice(m,m+4));return Float32Array.of(...f.map((m,u)=>2*(n*m+r*d[u])/a-d[u]),...h.map((m,u)=>d[u]-2*(o*m+i*d[u])/c),...d,...s,l,o*e/2,.002*c/2,2/a,2/c)}function zt({means:s}){let e=new Float32Array(6*s.length);for(let t=0,n=0;t<s.length;t+=3)for(let o=n+18;n<o;n+=3)e[n]=s[t],e[n+1]=s[t+1],e[n+2]=s[t+2];return e}var os=S(()=>{"use strict";p()});function nt(s){return[Math.max(1,Math.min(s,4096)),Math.max(1,Math.ceil(s/4096))]}var rs,tt,Ft,is=S(()=>{"use strict";p();rs={shapes:["RGBA32UI","RGBA_INTEGER",4],colors:["RGBA32UI","RGBA_INTEGER",4],lobes:["R32UI","RED_INTEGER",1]},tt=["shapes","colors","lobes","looks","opacities","order","color_sums","weight_sums","color_sums_1","weight_sums_1","color_sums_2","weight_sums_2"],Ft=class{#e;#t=new Map;constructor(e){this.#e=e}make(e,t,[n,o]){let r=this.#e;r.deleteTexture(this.#t.get(e)??null);let i=r.createTexture();return this.#t.set(e,i),r.activeTexture(r.TEXTURE0+tt.indexOf(e)),r.bindTexture(r.TEXTURE_2D,i),r.texStorage2D(r.TEXTURE_2D,1,t,n,o),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MIN_FILTER,r.NEAREST),r.texParameteri(r.TEXTURE_2D,r.TEXTURE_MAG_FILTER,r.NEAREST),i}upload(e,t,n){let o=this.#e,[r,,i]=t,a=nt(n.length/i);if(a[1]>o.getParameter(o.MAX_TEXTURE_SIZE))throw new Error("the scene has more Gaussians than this GPU's textures can hold");this.make(e,o[r],a),this.write(e,t,0,n)}write(e,[,t,n],o,r){let i=this.#e,a=r instanceof Float32Array?i.FLOAT:i.UNSIGNED_INT,c=r.length/n;i.activeTexture(i.TEXTURE0+tt.indexOf(e));for(let l=0;l<c;){let[f,h]=[(o+l)%4096,Math.floor((o+l)/4096)],d=Math.min(4096-f,c-l),m=d===4096?Math.floor((c-l)/4096):1,u=l*n;i.texSubImage2D(i.TEXTURE_2D,0,f,h,d,m,i[t],a,r,u),l+=d*m}}bind(){for(let[e,t]of this.#t)this.#e.activeTexture(this.#e.TEXTURE0+tt.indexOf(e)),this.#e.bindTexture(this.#e.TEXTURE_2D,t)}destroy(){for(let e of this.#t.values())this.#e.deleteTexture(e)}}});function cs(s){return["EXT_color_buffer_float","EXT_float_blend"].every(e=>s.getExtension(e))}function ls(s){for(let r of[...as,"EXT_float_blend"])s.getExtension(r);let e=s.getExtension("WEBGL_provoking_vertex");e?.provokingVertexWEBGL(e.FIRST_VERTEX_CONVENTION_WEBGL),s.disable(s.DITHER);let t={view:s.createBuffer(),corners:s.createBuffer(),quads:s.createVertexArray(),looks:s.createFramebuffer(),sums:s.createFramebuffer(),enlarged:[s.createFramebuffer(),s.createFramebuffer()],programs:new Map,counters:new Map,textures:new Ft(s)};s.bindBufferBase(s.UNIFORM_BUFFER,ir,t.view),s.bufferData(s.UNIFORM_BUFFER,Je,s.DYNAMIC_DRAW),s.bindVertexArray(t.quads),s.bindBuffer(s.ELEMENT_ARRAY_BUFFER,t.corners);let n=[0,1,2,2,1,3],o=Array.from({length:Nt},(r,i)=>n.map(a=>4*i+a));return s.bufferData(s.ELEMENT_ARRAY_BUFFER,Uint16Array.from(o.flat()),s.STATIC_DRAW),t}function ar(s,e,t){let{whole:n,project:o,splat:r,resolve:i}=e,a=t.packed?e.packed:e.wide,c=lr(s,e.view,t);return{project:c(n,`${a}${o}`),splat:c(`${a}${r}`,r),resolve:c(n,i),enlarge:t.leveled?[1,2].map(l=>c(n,`#define LEVEL ${l}
${i}`)):[]}}function cr(s,{view:e,packed:t,wide:n,whole:o,count:r},i){return lr(s,e,i)(o,`#define VERTEX
${i.packed?t:n}${r}`)}function lr(s,e,{sorted:t,strips:n,leveled:o}){let i=Object.entries({SORTED:t,STRIPS:n,LEVELED:o}).map(([a,c])=>c?`#define ${a}
`:"").join("");return(a,c)=>{let l=fs(s,`${i}#define VERTEX
${e}${a}`,`${i}${e}${c}`);return s.useProgram(l),tt.forEach((f,h)=>s.uniform1i(s.getUniformLocation(l,f),h)),s.uniformBlockBinding(l,s.getUniformBlockIndex(l,"View"),ir),l}}function fs(s,e,t){let n=s.createProgram();for(let[o,r]of[[s.VERTEX_SHADER,e],[s.FRAGMENT_SHADER,t]]){let i=s.createShader(o);s.shaderSource(i,`#version 300 es
${r}`),s.compileShader(i),s.attachShader(n,i),s.deleteShader(i)}if(s.linkProgram(n),!s.getProgramParameter(n,s.LINK_STATUS)&&!s.isContextLost()){let o=(s.getAttachedShaders(n)??[]).map(r=>s.getShaderInfoLog(r));throw o.push(s.getProgramInfoLog(n)),new Error(`this GPU refuses a shader: ${o.join(" ")}`)}return n}var Nt,ir,as,hs=S(()=>{"use strict";p();Rt();is();Nt=128,ir=0,as=["EXT_color_buffer_float","EXT_color_buffer_half_float"]});var Ut,fr=S(()=>{"use strict";p();os();hs();Ut=class{#e;#t=null;#o;#s;#n;#i=0;constructor(e,t){this.#e=e,this.#o=fs(e,`#define VERTEX
${t}`,t),this.#s=e.createVertexArray(),this.#n=e.createBuffer(),e.bindVertexArray(this.#s),e.bindBuffer(e.ARRAY_BUFFER,this.#n),e.enableVertexAttribArray(0),e.vertexAttribPointer(0,3,e.FLOAT,!1,0,0)}take(e){let[t,n]=[this.#e,e?zt(e):new Float32Array(0)];this.#t=e,this.#i=n.length/3,t.bindBuffer(t.ARRAY_BUFFER,this.#n),t.bufferData(t.ARRAY_BUFFER,n,t.STATIC_DRAW)}draw(e,{framebuffer:t,x:n,y:o}){let[r,i]=[this.#e,this.#t];i&&(r.bindFramebuffer(r.FRAMEBUFFER,t),r.viewport(n,o,e.width,e.height),r.disable(r.BLEND),r.enable(r.SCISSOR_TEST),r.scissor(n,o,e.width,e.height),r.clearBufferfv(r.COLOR,0,[...i.background,1]),r.disable(r.SCISSOR_TEST),r.useProgram(this.#o),r.uniform4fv(r.getUniformLocation(this.#o,"dots"),Ot(i,e)),r.bindVertexArray(this.#s),r.drawArrays(r.TRIANGLES,0,this.#i))}destroy(){let e=this.#e;e.deleteProgram(this.#o),e.deleteVertexArray(this.#s),e.deleteBuffer(this.#n)}}});var ds,dr,pr,bl,ur,It,mr=S(()=>{"use strict";p();Ye();Ze();Rt();rr();fr();hs();is();ds=new Float32Array(0),dr={framebuffer:null,x:0,y:0},pr={shapes:["RGBA32F","RGBA",4],colors:["RGB32F","RGB",3],lobes:["RG32F","RG",2]},bl={...pr,colors:["RGB16F","RGB",3],lobes:["RG16F","RG",2]},ur=["R32UI","RED_INTEGER",1],It=class s{static files=["view","wide","packed","whole","project","splat","resolve","count","dots"].map(e=>`${e}.glsl`);variant;levelSigma=0;supersampling=1;crop=null;lost=null;onLost=()=>{};onRestored=()=>{};#e;#t;#o;#s=null;#n=rs;#i=null;#r=null;#a="";#c;#l=e=>{e.preventDefault(),this.#s=this.#i=null,this.lost="the browser took the GPU away from this page: reload it if no picture returns",this.onLost(this.lost)};#f=()=>{this.#s=null,this.#o=ls(this.#e),this.#a="",this.#c.forget(),this.lost=null,this.onRestored()};static create(e,t,{floats:n=!1,strips:o=!1}={}){let r=e.getContext("webgl2",{alpha:!1,antialias:!1,depth:!1,powerPreference:"high-performance"});if(r===null)throw new Error("this browser cannot draw with WebGL2 here");if(!as.some(i=>r.getExtension(i)))throw new Error("this GPU cannot draw into textures of floats");if(n&&!cs(r))throw new Error("this GPU cannot blend 32-bit floats: use the variant halves");if(r.getParameter(r.MAX_TEXTURE_SIZE)<4096)throw new Error(`this GPU's textures are less than ${4096} pixels wide`);return new s(r,t,{floats:n,strips:o})}constructor(e,t,n){this.#e=e,this.#t=t,this.variant=n,this.#o=ls(e),this.#c=new Lt(e),e.canvas.addEventListener("webglcontextlost",this.#l),e.canvas.addEventListener("webglcontextrestored",this.#f)}setScene(e){let t=this.#e;if(this.#s=this.#r=null,e.network)throw new Error("this scene needs a network for every Gaussian in every frame, which takes WebGPU: open it in a browser that has it");this.#n=e.packing?rs:this.variant.floats?pr:bl;let{shapes:n,colors:o,lobes:r}=e;for(let[a,c]of Object.entries({shapes:n,colors:o,lobes:r}))this.#o.textures.upload(a,this.#n[a],c);t.bindFramebuffer(t.FRAMEBUFFER,this.#o.looks);let i=e.packing?[t.RG32UI,0]:[t.RGBA32F,t.R32F];["looks","opacities"].forEach((a,c)=>{let l=i[c]?this.#o.textures.make(a,i[c],nt(e.count)):null;t.framebufferTexture2D(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0+c,t.TEXTURE_2D,l,0)}),this.#k("textures of 32-bit numbers"),this.#s={...e,shapes:ds,colors:ds,lobes:ds},e.sorted&&this.#o.textures.upload("order",ur,Uint32Array.from({length:e.count},(a,c)=>c))}show(e){this.#s&&(this.#s.count=e)}update(e,t,n){if(this.#s===null)return;let o=this.#n[e];this.#o.textures.write(e,o,Ie(this.#s)[e]/o[2]*t,n)}setDots(e){this.lost===null&&(this.#i??=new Ut(this.#e,this.#t.dots),this.#i.take(e))}drawDots(e,t=null){this.#i&&(t||this.#h(e),this.#i.draw(e,t??dr))}setOrder(e){if(this.#s!==null){if(e.length!==this.#s.count)throw new Error(`an order of ${e.length} Gaussians does not fit this scene`);this.#o.textures.write("order",ur,0,e)}}draw(e,t=null){if(this.#s===null)return;t||this.#h(e);let{framebuffer:n,x:o,y:r}=t??dr;this.#c.start(),this.#p(this.#s,e),this.#d(this.#s,e,n,o,r,r+e.height-1),this.#c.pass()}async drawUnseen(e){let t=this.#e;if(this.#s&&this.#p(this.#s,e),t.readBuffer(t.COLOR_ATTACHMENT0),t.readPixels(0,0,1,1,t.RGBA,t.FLOAT,new Float32Array(4)),t.isContextLost())throw new Error("the graphics device was lost")}get milliseconds(){return this.#c.milliseconds}async time(){this.lost===null&&await this.#c.time()}async finished(){this.#e.bindFramebuffer(this.#e.FRAMEBUFFER,null),this.#e.readPixels(0,0,1,1,this.#e.RGBA,this.#e.UNSIGNED_BYTE,new Uint8Array(4))}async fragments(){if(this.#s===null||this.#r===null)return null;let e=this.#e,{leveled:t,pixels:n}=this.#r,[o,r]=nt(this.#s.count),[i,a]=[e.createFramebuffer(),e.createRenderbuffer()];e.bindFramebuffer(e.FRAMEBUFFER,i),e.bindRenderbuffer(e.RENDERBUFFER,a),e.renderbufferStorage(e.RENDERBUFFER,e.RGBA16F,o,r),e.framebufferRenderbuffer(e.FRAMEBUFFER,e.COLOR_ATTACHMENT0,e.RENDERBUFFER,a),e.disable(e.BLEND),e.viewport(0,0,o,r),e.useProgram(this.#u(this.#s,t)),e.drawArrays(e.TRIANGLES,0,3);let c=new Float32Array(4*o*r);e.readPixels(0,0,o,r,e.RGBA,e.FLOAT,c),e.deleteFramebuffer(i),e.deleteRenderbuffer(a);let l=new Array(t?4:1).fill(0);for(let f=0;f<c.length;f+=4)l[c[f+1]]+=c[f]**2/n;return l}get variants(){return(cs(this.#e)?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}get context(){return this.#e}describe(){let e=this.#e,t=e.getExtension("WEBGL_debug_renderer_info");return String(e.getParameter(t?t.UNMASKED_RENDERER_WEBGL:e.RENDERER))}async pixels(e){if(this.#s===null)throw new Error("there is no scene to draw");let t=this.#e,{width:n,height:o}=e;this.#p(this.#s,e);let[r,i]=[t.createFramebuffer(),t.createRenderbuffer()];t.bindFramebuffer(t.FRAMEBUFFER,r),t.bindRenderbuffer(t.RENDERBUFFER,i),t.renderbufferStorage(t.RENDERBUFFER,t.RGBA32F,n,o),t.framebufferRenderbuffer(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0,t.RENDERBUFFER,i),this.#d(this.#s,e,r,0,0,0);let a=new Float32Array(4*n*o);return t.readPixels(0,0,n,o,t.RGBA,t.FLOAT,a),t.deleteFramebuffer(r),t.deleteRenderbuffer(i),a}destroy(){let e=this.#e,{view:t,corners:n,quads:o,looks:r,sums:i,enlarged:a,programs:c,counters:l,textures:f}=this.#o;this.#s=null,this.#i?.destroy(),e.canvas.removeEventListener("webglcontextlost",this.#l),e.canvas.removeEventListener("webglcontextrestored",this.#f),f.destroy();for(let h of c.values())for(let d of Object.values(h).flat())e.deleteProgram(d);for(let h of l.values())e.deleteProgram(h);for(let h of[r,i,...a])e.deleteFramebuffer(h);e.deleteVertexArray(o);for(let h of[t,n])e.deleteBuffer(h);e.getExtension("WEBGL_lose_context")?.loseContext()}#h({width:e,height:t}){let{canvas:n}=this.#e;n.width!==e&&(n.width=e),n.height!==t&&(n.height=t)}#p(e,t){let n=this.#e,o=t.width*t.height;t=et(t,this.supersampling);let{view:r,quads:i,looks:a,sums:c}=this.#o,l=this.#g(e,t),f=this.#v(e,l),[h,d]=this.#E(e.sorted,l,t);n.bindBuffer(n.UNIFORM_BUFFER,r),this.#r={leveled:l,pixels:o};let m=this.variant.floats?1:Mt,u=Tt(e,t,m,this.levelSigma,this.supersampling);n.bufferSubData(n.UNIFORM_BUFFER,0,u),n.bindVertexArray(i),n.disable(n.BLEND),n.bindFramebuffer(n.FRAMEBUFFER,a),n.drawBuffers([n.COLOR_ATTACHMENT0,e.packing?n.NONE:n.COLOR_ATTACHMENT1]);let[g,w]=nt(e.count);if(n.viewport(0,0,g,w),n.useProgram(f.project),n.uniform4fv(n.getUniformLocation(f.project,"crop"),this.crop??[0,0,0,0]),this.#c.pass("project"),n.drawArrays(n.TRIANGLES,0,3),n.bindFramebuffer(n.FRAMEBUFFER,c),n.viewport(0,0,h,d),n.enable(n.BLEND),n.useProgram(f.splat),this.#c.pass("splat"),e.sorted?(n.drawBuffers([n.COLOR_ATTACHMENT0]),n.clearBufferfv(n.COLOR,0,[0,0,0,0]),n.blendFunc(n.ONE,n.ONE_MINUS_SRC_ALPHA)):(n.drawBuffers([n.COLOR_ATTACHMENT0,n.COLOR_ATTACHMENT1]),n.clearBufferfv(n.COLOR,0,[0,0,0,1]),n.clearBufferfv(n.COLOR,1,[0,0,0,0]),n.blendFuncSeparate(n.ONE,n.ONE,n.ZERO,n.ONE_MINUS_SRC_ALPHA)),this.variant.strips)n.drawArraysInstanced(n.TRIANGLE_STRIP,0,4,e.count);else{let v=Math.ceil(e.count/Nt);n.drawElementsInstanced(n.TRIANGLES,6*Nt,n.UNSIGNED_SHORT,0,v)}}#d(e,t,n,o,r,i){let a=this.#e,c=et(t,this.supersampling),{resolve:l,enlarge:f}=this.#v(e,this.#g(e,c));a.disable(a.BLEND),this.#c.pass("resolve"),f.length&&this.#m(f,c),a.bindFramebuffer(a.FRAMEBUFFER,n),a.viewport(o,r,t.width,t.height),a.useProgram(l),a.uniform1i(a.getUniformLocation(l,"first_column"),o),a.uniform1i(a.getUniformLocation(l,"last_row"),i),a.drawArrays(a.TRIANGLES,0,3)}#m(e,{width:t,height:n}){let o=this.#e,r=he(t,n);for(let i of[2,1])o.bindFramebuffer(o.FRAMEBUFFER,this.#o.enlarged[i-1]),o.viewport(0,0,r[i][0],r[i][1]),o.useProgram(e[i-1]),o.drawArrays(o.TRIANGLES,0,3)}#g({sorted:e},{width:t,height:n}){let o=this.#e.getParameter(this.#e.MAX_TEXTURE_SIZE);return this.levelSigma>0&&!e&&Math.max(...de(t,n).size)<=o}#E(e,t,{width:n,height:o}){let{floats:r}=this.variant,i=t?de(n,o).size:[n,o],a=`${n} ${o} ${e} ${t} ${r}`;if(a===this.#a)return i;let c=this.#e,l=c.getParameter(c.MAX_TEXTURE_SIZE);if(!(n>0&&n<=l&&o>0&&o<=l))throw new Error(`an image of ${n}x${o} pixels cannot be rendered: each side must lie between 1 and ${l}`);let f=r?[c.RGBA32F,c.R32F]:[c.RGBA16F,c.R16F],{sums:h,enlarged:d,textures:m}=this.#o,u=he(n,o);return[h,...d].forEach((g,w)=>{let v=w?`_${w}`:"";c.bindFramebuffer(c.FRAMEBUFFER,g),["color_sums","weight_sums"].forEach((E,x)=>{let A=(w===0||t)&&!(e&&x>0),M=w===0?i:u[w],R=A?m.make(`${E}${v}`,f[x],M):null;c.framebufferTexture2D(c.FRAMEBUFFER,c.COLOR_ATTACHMENT0+x,c.TEXTURE_2D,R,0)}),w&&t&&c.drawBuffers([c.COLOR_ATTACHMENT0,c.COLOR_ATTACHMENT1]),(w===0||t)&&this.#k(`pictures of ${n}x${o} floats`)}),this.#a=a,i}#b({sorted:e,packing:t},n){return{sorted:e,packed:t!==null,strips:this.variant.strips,leveled:n}}#v(e,t){let{programs:n}=this.#o,o=this.#b(e,t),r=Object.values(o).join(" "),i=n.get(r)??ar(this.#e,this.#t,o);return n.set(r,i),i}#u(e,t){let{counters:n}=this.#o,o={...this.#b(e,t),strips:!1},r=Object.values(o).join(" "),i=n.get(r)??cr(this.#e,this.#t,o);return n.set(r,i),i}#k(e){let t=this.#e;if(t.checkFramebufferStatus(t.FRAMEBUFFER)!==t.FRAMEBUFFER_COMPLETE&&!t.isContextLost())throw new Error(`this GPU cannot draw into ${e}`)}}});var gr={};Be(gr,{WebGlRenderer:()=>It,shaderText:()=>St});var wr=S(()=>{"use strict";p();_e();mr()});var br,st,vr,xr,yr,Er,Ct=S(()=>{"use strict";p();br=["en","de","zh","es","ja"],st={scene:"3D scene",keysHint:"Press H for the keys.",wake:"Show in 3D",hint:"Drag to look around",loading:"Loading",controls:"Controls",reset:"Back to the first view",share:"Share",settings:"Settings",help:"Help",vr:"Enter VR",ar:"View in your room",full:"Full screen",window:"Leave full screen",close:"Close",background:"Background",own:"The scene's own",scale:"Resolution",automatic:"automatic",mode:"Dragging",orbit:"rotates the scene",fly:"looks around",walk:"walks",turning:"Rotate slowly",stats:"Show the frame rate",open:"Open a file",view:"Next camera",picture:"Save a picture",up:"Turn upright",device:"Rendered with {}",adapter:"Rendered with {} on {}",link:"Link to this view",copy:"Copy",copied:"Copied.",uncopied:"This browser does not allow copying: the text is selected, press Ctrl+C.",send:"Send\u2026",code:"QR code of the link",scan:"Scan it to open the scene on another device.",local:"This address works on this device only.",touch:"Touch",mouse:"Mouse",keys:"Keys",oneFinger:"One finger",twoFingers:"Two fingers",pinch:"Pinch",doubleTap:"Double tap",drag:"Drag",rightDrag:"Right button or Shift",wheel:"Wheel",doubleClick:"Double click",rotate:"rotate the scene",pan:"move sideways",zoom:"zoom in and out",focus:"look at that point",flyHelp:"fly; faster with Shift",modeHelp:"orbit, look around or walk",report:"Benchmark",results:"Results as JSON",failed:"The scene cannot be shown",offline:"There is no connection",retry:"Try again",drop:"Drop a scene to open it, or two to compare them",compared:"{} on the left, {} on the right",loaded:"{} Gaussians loaded.",axis:"The axis {} points up.",ownAxis:"The scene's own direction points up.",orbits:"Dragging rotates the scene.",flies:"Dragging looks around.",walks:"Walk with the stick or W A S D; dragging looks around."},vr={scene:"3D-Szene",keysHint:"Taste H zeigt die Tasten.",wake:"In 3D zeigen",hint:"Ziehen, um sich umzusehen",loading:"L\xE4dt",controls:"Bedienung",reset:"Zur\xFCck zur ersten Ansicht",share:"Teilen",settings:"Einstellungen",help:"Hilfe",vr:"In VR ansehen",ar:"Im eigenen Raum ansehen",full:"Vollbild",window:"Vollbild beenden",close:"Schlie\xDFen",background:"Hintergrund",own:"Der der Szene",scale:"Aufl\xF6sung",automatic:"automatisch",mode:"Ziehen",orbit:"dreht die Szene",fly:"dreht den Blick",walk:"zum Gehen",turning:"Langsam drehen",stats:"Bildrate anzeigen",open:"Datei \xF6ffnen",view:"N\xE4chste Kamera",picture:"Bild speichern",up:"Aufrichten",device:"Gezeichnet mit {}",adapter:"Gezeichnet mit {} auf {}",link:"Link zu dieser Ansicht",copy:"Kopieren",copied:"Kopiert.",uncopied:"Dieser Browser erlaubt kein Kopieren: Der Text ist markiert, dr\xFCcken Sie Strg+C.",send:"Senden\u2026",code:"QR-Code des Links",scan:"Scannen \xF6ffnet die Szene auf einem anderen Ger\xE4t.",local:"Diese Adresse gilt nur auf diesem Ger\xE4t.",touch:"Ber\xFChrung",mouse:"Maus",keys:"Tasten",oneFinger:"Ein Finger",twoFingers:"Zwei Finger",pinch:"Zwei Finger spreizen",doubleTap:"Doppelt tippen",drag:"Ziehen",rightDrag:"Rechte Taste oder Umschalt",wheel:"Mausrad",doubleClick:"Doppelklick",rotate:"Szene drehen",pan:"seitw\xE4rts bewegen",zoom:"vergr\xF6\xDFern und verkleinern",focus:"diesen Punkt ansehen",flyHelp:"fliegen; mit Umschalt schneller",modeHelp:"Szene drehen, umsehen oder gehen",report:"Messung",results:"Ergebnisse als JSON",failed:"Die Szene kann nicht gezeigt werden",offline:"Keine Verbindung",retry:"Noch einmal versuchen",drop:"Eine Szene hier ablegen, oder zwei zum Vergleichen",compared:"{} links, {} rechts",loaded:"{} Gau\xDF-Funktionen geladen.",axis:"Die Achse {} zeigt nach oben.",ownAxis:"Die Richtung der Szene zeigt nach oben.",orbits:"Ziehen dreht die Szene.",flies:"Ziehen dreht den Blick.",walks:"Gehen mit dem Stick oder W A S D; Ziehen dreht den Blick."},xr={scene:"\u4E09\u7EF4\u573A\u666F",keysHint:"\u6309 H \u952E\u67E5\u770B\u5FEB\u6377\u952E\u3002",wake:"\u4EE5 3D \u663E\u793A",hint:"\u62D6\u52A8\u4EE5\u73AF\u987E\u56DB\u5468",loading:"\u6B63\u5728\u52A0\u8F7D",controls:"\u63A7\u4EF6",reset:"\u56DE\u5230\u521D\u59CB\u89C6\u89D2",share:"\u5206\u4EAB",settings:"\u8BBE\u7F6E",help:"\u5E2E\u52A9",vr:"\u8FDB\u5165 VR",ar:"\u5728\u73B0\u5B9E\u7A7A\u95F4\u4E2D\u67E5\u770B",full:"\u5168\u5C4F",window:"\u9000\u51FA\u5168\u5C4F",close:"\u5173\u95ED",background:"\u80CC\u666F",own:"\u4F7F\u7528\u573A\u666F\u80CC\u666F",scale:"\u5206\u8FA8\u7387",automatic:"\u81EA\u52A8",mode:"\u62D6\u52A8\u65B9\u5F0F",orbit:"\u65CB\u8F6C\u573A\u666F",fly:"\u8F6C\u52A8\u89C6\u7EBF",walk:"\u884C\u8D70",turning:"\u7F13\u6162\u65CB\u8F6C",stats:"\u663E\u793A\u5E27\u7387",open:"\u6253\u5F00\u6587\u4EF6",view:"\u4E0B\u4E00\u4E2A\u76F8\u673A",picture:"\u4FDD\u5B58\u56FE\u7247",up:"\u8C03\u6574\u671D\u4E0A\u65B9\u5411",device:"\u4F7F\u7528 {} \u6E32\u67D3",adapter:"\u4F7F\u7528 {} \u6E32\u67D3\uFF0C\u8BBE\u5907\uFF1A{}",link:"\u5F53\u524D\u89C6\u89D2\u7684\u94FE\u63A5",copy:"\u590D\u5236",copied:"\u5DF2\u590D\u5236\u3002",uncopied:"\u6B64\u6D4F\u89C8\u5668\u4E0D\u5141\u8BB8\u590D\u5236\uFF1A\u6587\u5B57\u5DF2\u9009\u4E2D\uFF0C\u8BF7\u6309 Ctrl+C\u3002",send:"\u53D1\u9001\u2026",code:"\u94FE\u63A5\u7684\u4E8C\u7EF4\u7801",scan:"\u626B\u63CF\u4E8C\u7EF4\u7801\uFF0C\u5728\u5176\u4ED6\u8BBE\u5907\u4E0A\u6253\u5F00\u573A\u666F\u3002",local:"\u6B64\u5730\u5740\u4EC5\u5728\u672C\u8BBE\u5907\u4E0A\u6709\u6548\u3002",touch:"\u89E6\u6478",mouse:"\u9F20\u6807",keys:"\u952E\u76D8",oneFinger:"\u5355\u6307",twoFingers:"\u53CC\u6307",pinch:"\u53CC\u6307\u634F\u5408",doubleTap:"\u53CC\u51FB\u5C4F\u5E55",drag:"\u62D6\u52A8",rightDrag:"\u53F3\u952E\u6216 Shift",wheel:"\u6EDA\u8F6E",doubleClick:"\u53CC\u51FB",rotate:"\u65CB\u8F6C\u573A\u666F",pan:"\u5E73\u79FB",zoom:"\u653E\u5927\u6216\u7F29\u5C0F",focus:"\u770B\u5411\u8BE5\u70B9",flyHelp:"\u98DE\u884C\uFF1B\u6309\u4F4F Shift \u52A0\u901F",modeHelp:"\u65CB\u8F6C\u573A\u666F\u3001\u8F6C\u52A8\u89C6\u7EBF\u6216\u884C\u8D70",report:"\u6027\u80FD\u6D4B\u8BD5",results:"JSON \u683C\u5F0F\u7684\u7ED3\u679C",failed:"\u65E0\u6CD5\u663E\u793A\u573A\u666F",offline:"\u6CA1\u6709\u7F51\u7EDC\u8FDE\u63A5",retry:"\u91CD\u8BD5",drop:"\u62D6\u653E\u4E00\u4E2A\u573A\u666F\u4EE5\u6253\u5F00\uFF0C\u6216\u4E24\u4E2A\u4EE5\u6BD4\u8F83",compared:"\u5DE6\u4FA7\uFF1A{}\uFF0C\u53F3\u4FA7\uFF1A{}",loaded:"\u5DF2\u52A0\u8F7D {} \u4E2A\u9AD8\u65AF\u3002",axis:"{} \u8F74\u671D\u4E0A\u3002",ownAxis:"\u4F7F\u7528\u573A\u666F\u81EA\u8EAB\u7684\u671D\u4E0A\u65B9\u5411\u3002",orbits:"\u62D6\u52A8\u53EF\u65CB\u8F6C\u573A\u666F\u3002",flies:"\u62D6\u52A8\u53EF\u8F6C\u52A8\u89C6\u7EBF\u3002",walks:"\u7528\u6447\u6746\u6216 W A S D \u884C\u8D70\uFF1B\u62D6\u52A8\u53EF\u8F6C\u52A8\u89C6\u7EBF\u3002"},yr={scene:"Escena 3D",keysHint:"Pulsa H para ver las teclas.",wake:"Mostrar en 3D",hint:"Arrastra para mirar alrededor",loading:"Cargando",controls:"Controles",reset:"Volver a la vista inicial",share:"Compartir",settings:"Ajustes",help:"Ayuda",vr:"Ver en realidad virtual",ar:"Ver en tu espacio",full:"Pantalla completa",window:"Salir de pantalla completa",close:"Cerrar",background:"Fondo",own:"El de la escena",scale:"Resoluci\xF3n",automatic:"autom\xE1tica",mode:"Arrastrar",orbit:"gira la escena",fly:"gira la mirada",walk:"caminar",turning:"Girar despacio",stats:"Mostrar fotogramas por segundo",open:"Abrir un archivo",view:"C\xE1mara siguiente",picture:"Guardar una imagen",up:"Enderezar",device:"Dibujado con {}",adapter:"Dibujado con {} en {}",link:"Enlace a esta vista",copy:"Copiar",copied:"Copiado.",uncopied:"Este navegador no permite copiar: el texto est\xE1 seleccionado, pulsa Ctrl+C.",send:"Enviar\u2026",code:"C\xF3digo QR del enlace",scan:"Escan\xE9alo para abrir la escena en otro dispositivo.",local:"Esta direcci\xF3n solo funciona en este dispositivo.",touch:"Pantalla t\xE1ctil",mouse:"Rat\xF3n",keys:"Teclas",oneFinger:"Un dedo",twoFingers:"Dos dedos",pinch:"Pellizcar",doubleTap:"Tocar dos veces",drag:"Arrastrar",rightDrag:"Bot\xF3n derecho o May\xFAs",wheel:"Rueda",doubleClick:"Doble clic",rotate:"girar la escena",pan:"mover de lado",zoom:"acercar y alejar",focus:"mirar ese punto",flyHelp:"volar; m\xE1s r\xE1pido con May\xFAs",modeHelp:"girar la escena, la mirada o caminar",report:"Medici\xF3n",results:"Resultados en JSON",failed:"No se puede mostrar la escena",offline:"No hay conexi\xF3n",retry:"Intentar de nuevo",drop:"Suelta una escena para abrirla, o dos para compararlas",compared:"{} a la izquierda, {} a la derecha",loaded:"{} gaussianas cargadas.",axis:"El eje {} apunta hacia arriba.",ownAxis:"La direcci\xF3n propia de la escena apunta hacia arriba.",orbits:"Arrastrar gira la escena.",flies:"Arrastrar gira la mirada.",walks:"Camina con la palanca o con W A S D; arrastrar gira la mirada."},Er={scene:"3D\u30B7\u30FC\u30F3",keysHint:"H\u30AD\u30FC\u3067\u64CD\u4F5C\u4E00\u89A7\u3092\u8868\u793A\u3057\u307E\u3059\u3002",wake:"3D\u3067\u8868\u793A",hint:"\u30C9\u30E9\u30C3\u30B0\u3057\u3066\u898B\u56DE\u3059",loading:"\u8AAD\u307F\u8FBC\u307F\u4E2D",controls:"\u64CD\u4F5C",reset:"\u6700\u521D\u306E\u8996\u70B9\u306B\u623B\u308B",share:"\u5171\u6709",settings:"\u8A2D\u5B9A",help:"\u30D8\u30EB\u30D7",vr:"VR\u3067\u898B\u308B",ar:"\u73FE\u5B9F\u306E\u7A7A\u9593\u306B\u8868\u793A",full:"\u5168\u753B\u9762\u8868\u793A",window:"\u5168\u753B\u9762\u8868\u793A\u3092\u7D42\u4E86",close:"\u9589\u3058\u308B",background:"\u80CC\u666F",own:"\u30B7\u30FC\u30F3\u306E\u80CC\u666F",scale:"\u89E3\u50CF\u5EA6",automatic:"\u81EA\u52D5",mode:"\u30C9\u30E9\u30C3\u30B0\u306E\u52D5\u4F5C",orbit:"\u30B7\u30FC\u30F3\u3092\u56DE\u3059",fly:"\u8996\u7DDA\u3092\u52D5\u304B\u3059",walk:"\u6B69\u304F",turning:"\u3086\u3063\u304F\u308A\u56DE\u8EE2",stats:"\u30D5\u30EC\u30FC\u30E0\u30EC\u30FC\u30C8\u3092\u8868\u793A",open:"\u30D5\u30A1\u30A4\u30EB\u3092\u958B\u304F",view:"\u6B21\u306E\u30AB\u30E1\u30E9",picture:"\u753B\u50CF\u3092\u4FDD\u5B58",up:"\u4E0A\u5411\u304D\u3092\u5909\u66F4",device:"{}\u3067\u63CF\u753B",adapter:"{}\u3067\u63CF\u753B\uFF08{}\uFF09",link:"\u3053\u306E\u8996\u70B9\u3078\u306E\u30EA\u30F3\u30AF",copy:"\u30B3\u30D4\u30FC",copied:"\u30B3\u30D4\u30FC\u3057\u307E\u3057\u305F\u3002",uncopied:"\u3053\u306E\u30D6\u30E9\u30A6\u30B6\u30FC\u3067\u306F\u30B3\u30D4\u30FC\u3067\u304D\u307E\u305B\u3093\u3002\u9078\u629E\u4E2D\u306E\u6587\u5B57\u3092Ctrl+C\u3067\u30B3\u30D4\u30FC\u3057\u3066\u304F\u3060\u3055\u3044\u3002",send:"\u9001\u4FE1\u2026",code:"\u30EA\u30F3\u30AF\u306EQR\u30B3\u30FC\u30C9",scan:"\u8AAD\u307F\u53D6\u308B\u3068\u5225\u306E\u7AEF\u672B\u3067\u30B7\u30FC\u30F3\u3092\u958B\u3051\u307E\u3059\u3002",local:"\u3053\u306E\u30A2\u30C9\u30EC\u30B9\u306F\u3053\u306E\u7AEF\u672B\u3067\u306E\u307F\u6709\u52B9\u3067\u3059\u3002",touch:"\u30BF\u30C3\u30C1",mouse:"\u30DE\u30A6\u30B9",keys:"\u30AD\u30FC",oneFinger:"1\u672C\u6307",twoFingers:"2\u672C\u6307",pinch:"\u30D4\u30F3\u30C1",doubleTap:"\u30C0\u30D6\u30EB\u30BF\u30C3\u30D7",drag:"\u30C9\u30E9\u30C3\u30B0",rightDrag:"\u53F3\u30DC\u30BF\u30F3\u307E\u305F\u306FShift",wheel:"\u30DB\u30A4\u30FC\u30EB",doubleClick:"\u30C0\u30D6\u30EB\u30AF\u30EA\u30C3\u30AF",rotate:"\u30B7\u30FC\u30F3\u3092\u56DE\u3059",pan:"\u5E73\u884C\u79FB\u52D5",zoom:"\u62E1\u5927\u30FB\u7E2E\u5C0F",focus:"\u305D\u306E\u70B9\u3092\u898B\u308B",flyHelp:"\u79FB\u52D5\uFF08Shift\u3067\u901F\u304F\uFF09",modeHelp:"\u30B7\u30FC\u30F3\u306E\u56DE\u8EE2\u3001\u8996\u7DDA\u3001\u6B69\u884C\u306E\u5207\u308A\u66FF\u3048",report:"\u6027\u80FD\u6E2C\u5B9A",results:"\u7D50\u679C\uFF08JSON\uFF09",failed:"\u30B7\u30FC\u30F3\u3092\u8868\u793A\u3067\u304D\u307E\u305B\u3093",offline:"\u63A5\u7D9A\u304C\u3042\u308A\u307E\u305B\u3093",retry:"\u518D\u8A66\u884C",drop:"\u30B7\u30FC\u30F3\u3092\u30C9\u30ED\u30C3\u30D7\u3057\u3066\u958B\u304F\uFF082\u3064\u3067\u6BD4\u8F03\uFF09",compared:"\u5DE6\uFF1A{}\u3001\u53F3\uFF1A{}",loaded:"{}\u500B\u306E\u30AC\u30A6\u30B7\u30A2\u30F3\u3092\u8AAD\u307F\u8FBC\u307F\u307E\u3057\u305F\u3002",axis:"{}\u8EF8\u304C\u4E0A\u3067\u3059\u3002",ownAxis:"\u30B7\u30FC\u30F3\u672C\u6765\u306E\u5411\u304D\u304C\u4E0A\u3067\u3059\u3002",orbits:"\u30C9\u30E9\u30C3\u30B0\u3067\u30B7\u30FC\u30F3\u3092\u56DE\u3057\u307E\u3059\u3002",flies:"\u30C9\u30E9\u30C3\u30B0\u3067\u8996\u7DDA\u3092\u52D5\u304B\u3057\u307E\u3059\u3002",walks:"\u30B9\u30C6\u30A3\u30C3\u30AF\u307E\u305F\u306FW A S D\u3067\u6B69\u304D\u3001\u30C9\u30E9\u30C3\u30B0\u3067\u8996\u7DDA\u3092\u52D5\u304B\u3057\u307E\u3059\u3002"}});var kr={};Be(kr,{de:()=>vr,es:()=>yr,ja:()=>Er,zh:()=>xr});var _r=S(()=>{"use strict";p();Ct()});function us(s,e){let t=[];for(let n=1;n<=El;n++){let o=s[n===1?e:`${e}.${n}`];if(typeof o!="string")break;t.push(o)}return t}function Sr(s){let t=us(s,"path").flatMap(o=>o.split(";")).map(o=>{let r=o.trim().split(/\s+/),i=r.length===6&&r.every(a=>yl.test(a))?r.map(Number):[];return{eye:i.slice(0,3),target:i.slice(3)}});return t.every(({eye:o,target:r})=>o.length===3&&z(T(r,o))>0)?t:[]}function Mr(s,e){let t=Math.min(Math.floor(e),Math.max(s.length-2,0)),n=e-t,o=f=>s[Math.min(Math.max(f,0),s.length-1)],[r,i,a,c]=[-1,0,1,2].map(f=>o(t+f)),l=f=>i[f].map((h,d)=>{let[m,u,g]=[r[f][d],a[f][d],c[f][d]],w=(u-m)/2,v=(g-h)/2,E=3*(u-h)-2*w-v;return h+n*(w+n*(E+n*(2*(h-u)+w+v)))});return{eye:l("eye"),target:l("target")}}function $t(s,e,t,{seconds:n=vl,signal:o}={}){let{eye:r,target:i,up:a}=s.pose;return new Promise(c=>{let l=Rr(s,e,f=>{let h=n>0?Math.min(f/n,1):1,d=h*h*(3-2*h),m=Mr([{eye:r,target:i},t],d);return t.up&&(m.up=N(y(a,T(t.up,a),d))),{key:m,last:h===1}},c);o?.aborted&&l(),o?.addEventListener("abort",l,{once:!0})})}function Tr(s,e,t){let n=t.length-1;return Rr(s,e,o=>{let r=(1-Math.cos(Math.PI*o/(xl*n)))/2;return{key:Mr(t,n*r),last:!1}})}function Rr(s,e,t,n=()=>{}){let o=performance.now(),r=new AbortController;Ar.get(s)?.abort(),Ar.set(s,r),r.signal.addEventListener("abort",()=>n(!1));for(let a of kl)e.addEventListener(a,()=>r.abort(),{signal:r.signal,capture:!0});let i=()=>{if(r.signal.aborted)return;let{key:a,last:c}=t((performance.now()-o)/1e3),l=s.pose.copy();if(l.eye=a.eye,l.target=a.target,l.up=a.up??l.up,s.place(l),!c)return void requestAnimationFrame(i);n(!0),r.abort()};return i(),()=>r.abort()}var vl,xl,yl,El,kl,Ar,ps=S(()=>{"use strict";p();B();vl=.9,xl=3,yl=/^-?\d{1,12}(\.\d{1,12})?$/,El=64,kl=["pointerdown","wheel","keydown"];Ar=new WeakMap});function Sl(s){let e=t=>Array.isArray(t)&&t.length===3&&t.every(n=>Number.isFinite(n));return us(s,"annotations").flatMap(t=>{let n;try{n=JSON.parse(t)}catch{n=null}return(Array.isArray(n)?n:[]).filter(r=>e(r?.at)&&typeof r.text=="string"&&(!r.eye||e(r.eye)))})}function Lr(s,e,t,n){let o=a=>{let c=s.getAttribute(a);return c===null?t.notes:{[a]:c}};e.querySelector(".annotations")?.remove();let r=Sl(o("annotations"));r.length&&new ms(s,e,t,r);let i=Sr(o("path"));n&&i.length>1&&!matchMedia(_l).matches&&Tr(t,s,i)}function gs({viewmat:s,fx:e,fy:t,cx:n,cy:o,width:r,height:i,near:a},c){let[l,f,h]=[0,4,8].map(v=>L([s[v],s[v+1],s[v+2]],c)+s[v+3]),[d,m]=[e*l/h+n,t*f/h+o];if(h>a&&d>0&&d<r&&m>0&&m<i)return{x:d,y:m,inside:!0};let[u,g]=[e*l,t*f],w=1/Math.max(2*Math.abs(u)/r,2*Math.abs(g)/i,Number.MIN_VALUE);return{x:n+w*u,y:o+w*g,inside:!1}}var _l,Al,ms,ws=S(()=>{"use strict";p();ps();B();_l="(prefers-reduced-motion: reduce)",Al=`
.annotations { position: absolute; inset: 0; overflow: hidden; pointer-events: none; }
.annotations button { position: absolute; left: 0; top: 0; width: 28px; height: 28px; min-width: 0; min-height: 0; margin: -14px; padding: 0;
  border: 2px solid #fff; border-radius: 50%; background: #10131acc; color: #fff; font: 600 13px/1 system-ui, sans-serif;
  pointer-events: auto; cursor: pointer; }
.annotations button::after { content: ""; position: absolute; inset: -10px; border-radius: 50%; }
.annotations button[aria-expanded=true] { background: #fff; color: #10131a; }
.annotations button:focus-visible { outline: 3px solid #6cb6ff; outline-offset: 2px; }
.annotations p { position: absolute; left: 0; top: 0; box-sizing: border-box; width: max-content; max-width: min(300px, 80%);
  max-height: 45%; overflow: auto; margin: 0; padding: 10px 14px; border-radius: 10px; background: #10131aee; color: #f3f4f6;
  font: 15px/1.45 system-ui, sans-serif; white-space: pre-line; overflow-wrap: anywhere; pointer-events: auto; }`;ms=class{#e=document.createElement("div");#t=document.createElement("p");#o;#s;#n;#i=-1;constructor(e,t,n,o){this.#o=n,this.#s=e;let r=this.#e;r.className="annotations";let i=document.createElement("style");i.textContent=Al,this.#t.hidden=!0,this.#t.id="annotation",this.#t.setAttribute("role","status"),this.#n=o.map((c,l)=>{let f=document.createElement("button");return f.type="button",f.textContent=String(l+1),f.setAttribute("aria-label",`${l+1}: ${c.text.slice(0,80)}`),f.setAttribute("aria-expanded","false"),f.addEventListener("click",()=>this.#r(l===this.#i?-1:l)),{button:f,annotation:c}}),r.append(i,...this.#n.map(({button:c})=>c),this.#t),r.addEventListener("keydown",c=>{c.key==="Escape"&&this.#r(-1),(c.key==="Enter"||c.key===" ")&&c.stopPropagation()}),t.querySelector("canvas:last-of-type")?.after(r);let a=()=>{r.isConnected?this.#a():e.removeEventListener("frame",a)};e.addEventListener("frame",a),a(),n.redraw()}#r(e){if(this.#i=e,this.#n.forEach(({button:a},c)=>a.setAttribute("aria-expanded",String(c===e))),this.#t.hidden=e<0,e<0)return;let{at:t,text:n,eye:o}=this.#n[e].annotation;this.#t.textContent=n;let{pose:r}=this.#o,i=o??y(r.eye,T(t,r.target),1);z(T(t,i))>0&&$t(this.#o,this.#s,{eye:i,target:t}),this.#a()}#a(){let{clientWidth:e,clientHeight:t}=this.#e;if(!e||!t)return;let n=this.#o.camera(e,t);this.#n.forEach(({button:o,annotation:{at:r}},i)=>{let{x:a,y:c,inside:l}=gs(n,r);if(o.style.visibility=l?"":"hidden",l&&(o.style.transform=`translate(${a}px, ${c}px)`),i!==this.#i)return;this.#t.hidden=!l;let{offsetWidth:f,offsetHeight:h}=this.#t,d=Math.min(Math.max(a-f/2,8),Math.max(e-f-8,8)),m=c+24+h<t?c+24:Math.max(c-24-h,8);this.#t.style.transform=`translate(${d}px, ${m}px)`})}}});var Dt,Or=S(()=>{"use strict";p();ws();Dt=class{#e;#t;#o=new Set;constructor(e,t,n){this.#e=t,this.#t=n;let o=()=>this.#s();e.addEventListener("frame",o),t.addEventListener("slotchange",o),new MutationObserver(o).observe(e,{attributes:!0,attributeFilter:["data-at"],subtree:!0}),o()}#s(){let e=this.#t(),{clientWidth:t,clientHeight:n}=this.#e,o=e?.count&&t&&n?e.camera(t,n):null;for(let r of this.#e.assignedElements()){let i=this.#n(r.dataset.at??""),a=o&&i&&gs(o,i);r.toggleAttribute("data-outside",!a?.inside),a&&(r.style.setProperty("--annotation-x",`${a.x}px`),r.style.setProperty("--annotation-y",`${a.y}px`))}}#n(e){let t=e.trim().split(/[\s,]+/).map(Number);return t.length===3&&e.trim()&&t.every(Number.isFinite)?t:(this.#o.has(e)||console.warn(`mobile-gs: data-at="${e}" of an annotation is not a point: write three numbers, as "0 1.5 -2"`),this.#o.add(e),null)}}});function Nr(s,e,t,n,o,r=null){let i=Math.tan((r??50)*Math.PI/360),a=r===null?e:null,c=a?t*a.K[0]/a.width:t/(2*i),l=a?n*a.K[4]/a.height:n/(2*i),f=r===null?s.box:null,h=f?Math.min(t/(2*f[0]),n/(2*f[1])):Math.sqrt(c*l),d={cx:t/2,cy:n/2};return{viewmat:s.viewmat(),fx:h,fy:h,...d,width:t,height:n,near:o}}function Tl({viewmat:s}){let e=i=>[s[4*i],s[4*i+1],s[4*i+2]],[t,n,o]=[e(0),e(1),e(2)],r=y([0,0,0],t,-s[3]);return r=y(y(r,n,-s[7]),o,-s[11]),{eye:r,right:t,forward:o,down:n}}function Rl(s){let e=[.001,0,0,0,.001,0,0,0,.001],t=[0,0,0];for(let{eye:c,forward:l}of s){for(let f=0;f<3;f++)for(let h=0;h<3;h++)e[3*f+h]+=(f===h?1:0)-l[f]*l[h];t=y(y(t,c,1+.001/s.length),l,-L(l,c))}let n=c=>[e[c],e[3+c],e[6+c]],[o,r,i]=[n(0),n(1),n(2)],a=L(o,F(r,i));return[L(t,F(r,i))/a,L(o,F(t,i))/a,L(o,F(r,t))/a]}var zr,Ml,Fr,D,Pt=S(()=>{"use strict";p();we();B();zr=.02,Ml=[.42,.42],Fr=.001,D=class s{constructor(e,t,n){this.eye=e,this.target=t,this.up=N(n),this.reach=z(T(t,e))||1,this.box=null}static fromStart({eye:e,target:t,box:n},o){let r=new s(e,t,o);return r.box=n,r}static fromViews(e,t=0,n=null){let o=e.map(Tl),{eye:r,forward:i}=o[t],a=L(T(Rl(o),r),i),c=Math.max(...o.map(l=>z(T(l.eye,r))),0)||1;return new s(r,y(r,i,a>Fr*c?a:c),n??bo(o))}static around(e,t=se){let n=[0,1,2].map(a=>{let c=e.filter((f,h)=>h%3===a).sort(),l=f=>c[Math.floor(f*(c.length-1))]??0;return[l(.15),l(.5),l(.85)]}),o=n.map(([,a])=>a),r=Math.max(...n.map(([a,,c])=>c-a))||1,i=new s(y(o,ge([0,-.3,-1],t),1.5*r),o,t);return i.box=Ml,i}get forward(){return N(T(this.target,this.eye))}get right(){return N(F(this.forward,this.up))}copy(){let e=new s(this.eye,this.target,this.up);return e.reach=this.reach,e.box=this.box,e}orbit(e,t){let n=this.#e(T(this.eye,this.target),e,t);this.eye=y(this.target,n)}look(e,t){let n=this.#e(T(this.eye,this.target),e,t);this.target=T(this.eye,n)}move(e,t,n){let o=F(this.forward,this.right),r=y([0,0,0],this.right,e);r=y(y(r,o,t),this.forward,n),this.eye=y(this.eye,r),this.target=y(this.target,r)}walk(e,t){let n=N(F(this.up,this.right)),o=y(y([0,0,0],this.right,e),n,t);this.eye=y(this.eye,o),this.target=y(this.target,o)}dolly(e){let t=T(this.eye,this.target),n=Math.max(z(t)*e,Fr*this.reach);this.eye=y(this.target,N(t),n)}focus(e){z(T(e,this.eye))>0&&(this.target=e)}viewmat(){let{forward:e,right:t,eye:n}=this,o=F(e,t),r=i=>[...i,-L(i,n)];return[...r(t),...r(o),...r(e),0,0,0,1]}#e(e,t,n){let o=Math.acos(Math.min(1,Math.max(-1,L(N(e),this.up)))),r=Math.min(Math.max(o-n,zr),Math.PI-zr)-o;return Fe(Fe(e,this.right,r),this.up,-t)}}});function $r(s,e){let[,t,n,o]=/^(?:(\d+)(?:,|$))?(?:(\d+)x(\d+))?$/.exec(s)??[];return{seconds:Math.min(Math.max(Number(t)||60,1),3600),width:Math.min(Number(n)||e.width,8192),height:Math.min(Number(o)||e.height,8192)}}function Ir(s,e,t){let{views:n}=s;if(n.length<2){let f=e.copy();return f.orbit(2*Math.PI*t/bs,.2*Math.sin(6*Math.PI*t/bs)),f}let o=Math.floor(t/Ht),[r,i]=[o,o+1].map(f=>D.fromViews(n,f%n.length)),a=t%Ht/Ht,c=y(r.eye,T(i.eye,r.eye),a),l=y(r.target,T(i.target,r.target),a);return new D(c,l,r.up)}async function Dr(s,e,t){let n=s.pose.copy(),o=document.hidden,r=()=>o||=document.hidden;document.addEventListener("visibilitychange",r),s.measured=!0;try{let i=await Cr(),a=await Nl(s,n,e,t),c=await Cr();return{...a,battery:i&&c&&{start:i,end:c},interrupted:o}}finally{document.removeEventListener("visibilitychange",r),s.measured=!1,s.place(n)}}async function Cr(){let s=await navigator.getBattery?.().catch(()=>null);return s?{percent:Math.round(100*s.level),charging:s.charging}:null}async function Nl(s,e,{seconds:t,width:n,height:o},r){let i=[],a=[];for(let u=0;u<Ur;u++)s.pose=Ir(s,e,u),await s.drawAndWait(n,o);await s.passes();let c=performance.now(),l=[],f=0;for(let u=Ur,g=0;g<1e3*t;u++){s.pose=Ir(s,e,u);let w=performance.now()-c,v=await s.drawAndWait(n,o);if(g=performance.now()-c,i.push({from:w,to:g,order:v}),r(Math.min(1,g/(1e3*t))),g-f<zl)continue;let E=await s.passes();if(E&&a.push({from:w,to:g,passes:{...E}}),g>Ol*l.length){let x=await s.fragments();x&&l.push(x)}await new Promise(x=>requestAnimationFrame(x)),f=performance.now()-c}let h=1e3*Math.min(Ll,t/2),d=i[i.length-1].to,m=u=>Ul(i.filter(u),a.filter(u));return{path:Fl(s),cold:m(({from:u})=>u<h),steady:m(({to:u})=>u>d-h),whole:m(()=>!0),fps_by_second:Array.from({length:t},(u,g)=>Pr(i.filter(({to:w})=>Math.min(Math.floor(w/1e3),t-1)===g))),fragments:l.length?l[0].map((u,g)=>vs(l.reduce((w,v)=>w+v[g],0)/l.length)):null}}function Pr(s){let e=s.reduce((t,{from:n,to:o})=>t+o-n,0);return s.length?vs(1e3*s.length/e):null}function Bt(s,e){let t=s.slice().sort((n,o)=>n-o);return vs(t[Math.floor(e*(t.length-1))]??NaN)}function Ul(s,e){let t=s.map(({from:i,to:a})=>a-i),n=s.flatMap(({order:i})=>i??[]),o=[...new Set(e.flatMap(({passes:i})=>Object.keys(i)))],r=i=>Bt(e.flatMap(({passes:a})=>a[i]??[]),.5);return{frames:t.length,fps:Pr(s)??NaN,milliseconds:Bt(t,.5),milliseconds95:Bt(t,.95),order:n.length?Bt(n,.5):null,passes:o.length?Object.fromEntries(o.map(i=>[i,r(i)])):null}}var Ht,bs,Ur,Ll,Ol,zl,Fl,vs,Br=S(()=>{"use strict";p();Pt();B();Ht=40,bs=480,Ur=10,Ll=10,Ol=1e3,zl=250;Fl=({views:s})=>s.length<2?bs:Ht*s.length;vs=s=>Number(s.toFixed(2))});function Vr(s,e){let t=new TextEncoder().encode(s),n=ys.findIndex((c,l)=>t.length<=Wr(l+1)-(l<9?2:3))+1;if(n===0)return null;let o=Pl($l(Cl(t,n),n)),i=[...e===void 0?Gr.keys():[e]].map(c=>Bl(n,o,c)),a=i.map(Hl);return i[a.indexOf(Math.min(...a))]}function Il(s){let e=jr(s).length,t=e?25*(e**2-3)+10*(2-e):0,n=17+4*s;return n**2-192-31-2*(n-16)-t-(s<7?0:36)}function jr(s){if(s===1)return[];let e=(s/7|0)+2,t=2*Math.ceil((4*s+4)/(2*e-2)),n=10+4*s;return[6,...Array.from({length:e-1},(o,r)=>n-(e-2-r)*t)]}function Cl(s,e){let{length:t}=s,o=[...e<10?[4,t>>4,t&15]:[4,t>>12,t>>8&15,t>>4&15,t&15],...[...s].flatMap(i=>[i>>4,i&15]),0],r=Array.from({length:o.length>>1},(i,a)=>16*o[2*a]+o[2*a+1]);for(let i=0;r.length<Wr(e);i++)r.push(i%2?17:236);return r}function $l(s,e){let t=qr[e-1],n=t-s.length%t,o=Math.floor(s.length/t),r=Array.from({length:t},(c,l)=>{let f=l*o+Math.max(0,l-n);return s.slice(f,f+o+ +(l>=n))}),i=r.map(c=>Dl(c,ys[e-1])),a=c=>Array.from({length:Math.max(...c.map(l=>l.length))},(l,f)=>c.map(h=>h[f])).flat().filter(l=>l!==void 0);return[...a(r),...a(i)]}function xs(s,e){let t=0;for(let n=7;n>=0;n--)t=t<<1^(t>>7)*285^(e>>n&1)*s;return t}function Dl(s,e){let t=[1];for(let o=0,r=1;o<e;o++,r=xs(r,2))t=[...t,0].map((i,a)=>i^(a?xs(t[a-1],r):0));let n=new Array(e).fill(0);for(let o of s){let r=o^n.shift();n.push(0),n.forEach((i,a)=>n[a]=i^xs(t[a+1],r))}return n}function Hr(s,e,t){let n=s;for(let o=0;o<e;o++)n=n<<1^(n>>e-1)*t;return s<<e|n}function Bl(s,e,t){let n=17+4*s,o=Array.from({length:n},()=>new Array(n)),r=(d,m,u)=>{o[m]&&d>=0&&d<n&&(o[m][d]=u)},i=(d,m,u,g)=>{for(let w=-u;w<=u;w++)for(let v=-u;v<=u;v++)r(d+v,m+w,g.includes(Math.max(Math.abs(v),Math.abs(w))))};for(let d=0;d<n;d++)r(6,d,d%2===0),r(d,6,d%2===0);for(let[d,m]of[[3,3],[n-4,3],[3,n-4]])i(d,m,4,[0,1,3]);let a=jr(s),c=a.length-1;for(let[d,m]of a.entries())for(let[u,g]of a.entries())d===0&&(u===0||u===c)||d===c&&u===0||i(m,g,2,[0,2]);let l=Hr(8|t,10,1335)^21522;for(let d=0;d<15;d++){let m=!!(l>>d&1);r(8,d<6?d:d<8?d+1:n-15+d,m),r(d<8?n-1-d:d===8?7:14-d,8,m)}r(8,n-8,!0);let f=Hr(s,12,7973);for(let d=0;s>6&&d<18;d++){let m=!!(f>>d&1),[u,g]=[Math.floor(d/3),n-11+d%3];r(u,g,m),r(g,u,m)}let h=0;for(let d=n-1;d>0;d-=2){d===6&&(d=5);for(let m=0;m<n;m++){let u=d+1&2?m:n-1-m;for(let g of[d,d-1])o[u][g]===void 0&&(o[u][g]=(e[h++]??!1)!==Gr[t](g,u))}}return o}function Hl(s){let e=s.length,t=0;for(let n=0;n<e;n++){let[o,r]=[0,0];for(let i=0;i<e;i++){o=i&&s[n][i]===s[n][i-1]?o+1:1,r=i&&s[i][n]===s[i-1][n]?r+1:1;for(let c of[o,r])t+=c===5?3:+(c>5);let a=s[n][i];n&&i&&[s[n-1][i],s[n][i-1],s[n-1][i-1]].every(c=>c===a)&&(t+=3)}}return t}var ys,qr,Gr,Wr,Pl,Xr=S(()=>{"use strict";p();ys=[7,10,15,20,26,18,20,24,30,18,20,24,26,30,22,24,28,30,28,28],qr=[1,1,1,1,1,2,2,2,2,4,4,4,4,4,6,6,6,6,7,8],Gr=[(s,e)=>(s+e)%2===0,(s,e)=>e%2===0,s=>s%3===0,(s,e)=>(s+e)%3===0,(s,e)=>((s/3|0)+(e>>1))%2===0,(s,e)=>s*e%2+s*e%3===0,(s,e)=>(s*e%2+s*e%3)%2===0,(s,e)=>((s+e)%2+s*e%3)%2===0];Wr=s=>(Il(s)>>3)-ys[s-1]*qr[s-1];Pl=s=>s.flatMap(e=>[7,6,5,4,3,2,1,0].map(t=>!!(e>>t&1)))});function Kr(s,e,t,n){let o=e.querySelector(".report"),r=f=>o.querySelector(f);r("textarea").value=JSON.stringify(n,null,1);let i=n.scenes,a=i.some(f=>f.interrupted),c=i.map(({cold:f,steady:h})=>`${f.fps} frames/s cold, ${h.fps} steady`).join(" | "),l=r("h2");delete l.dataset.text,l.textContent=a?"The page was hidden during the measurement: measure again":c,r("[data-act=send]").hidden=!navigator.share,o.hidden&&t.show("report"),s.dispatchEvent(new CustomEvent("report",{detail:n}))}var Yr=S(()=>{"use strict";p()});var Qr={};Be(Qr,{Slotted:()=>Dt,flyTo:()=>$t,parsePlan:()=>$r,qrCode:()=>Vr,runBench:()=>Dr,showNotes:()=>Lr,showReport:()=>Kr});var Zr=S(()=>{"use strict";p();ws();ps();Or();Br();Xr();Yr()});function ks(s){let e=typeof s=="string"?s.trim().split(/\s+/):[];return e.every(t=>ql.test(t))?e.map(Number):null}function Jr(s){let e=ks(s);if(e?.length!==8)return null;let[t,n]=[Gt(e,0),Gt(e,3)],[o,r]=e.slice(6);return t.every((i,a)=>i===n[a])||!(o>0&&r>0&&o<1e3&&r<1e3)?null:{eye:t,target:n,box:[o,r]}}function ei(s){let e=ks(s);if(e?.length!==6+2*ue)return null;let[t,n,o]=e.slice(3,6),r=e.slice(6);if(!(t>=0&&n>0&&n<=o)||r.some(c=>Math.abs(c)>90))return null;let i=Array.from({length:ue},(c,l)=>r.slice(2*l,2*l+2)),a={pivot:Gt(e,0),pan:t,nearest:n,farthest:o,elevations:i};return i.some(([c,l])=>c<=l)?a:null}function Wl(s,e){let t=o=>L(s,ge(o,e)),n=Math.asin(Math.min(1,Math.max(-1,L(s,e))))/qt;return[(Math.atan2(t([0,0,1]),t([1,0,0]))/qt+360)%360,n]}function jl(s,e,t){let[n,o]=[s*qt,e*qt];return ge([Math.cos(n)*Math.cos(o),-Math.sin(o),Math.sin(n)*Math.cos(o)],t)}function Xl({elevations:s},e){let t=s.map(([d,m])=>d<=m),n=e/360*ue-.5,o=Math.floor(n),r=n-o,[i,a]=[(o+ue)%ue,(o+1)%ue],c=r<.5?i:a;if(t[c]){let[d,m]=t[i]&&t[a]?[i,a]:[c,c],u=g=>(1-r)*s[d][g]+r*s[m][g];return[e,u(0),u(1)]}let[l,f,h]=[1/0,0,0];for(let d=0;d<2*ue;d++){let m=360*(d+1>>1)/ue,u=Math.abs(ti(e,m));t[d>>1]&&u<l&&([l,f,h]=[u,d>>1,m])}return[h,s[f][0],s[f][1]]}function ni(s,e,t){return s.limits===Es?null:(e<t?ei(s.limits_portrait):null)??ei(s.limits)}function Vt(s){let e=ks(s);if(e?.length!==4)return null;let t=Gt(e,0),n=z(t);return n>0?{normal:N(t),offset:e[3]/n}:null}function si(s,e,t){return(e<t?Jr(s.start_portrait):null)??Jr(s.start)}function _s(s,e,t,n){let o=0,r=(R,$)=>{let V=t(R,$);return o=Math.max(o,V/$),V},i=n==="orbit"?s.target:e.pivot,a=T(s.eye,i),c=z(a),{nearest:l,farthest:f,pan:h}=e,d=n==="orbit"?l:0;c>f?c=f+r(c-f,Ce.share*f):c<d&&(c=d-r(d-c,Ce.share*d));let[m,u]=Wl(N(a),s.up),[g,w,v]=Xl(e,m),E=ti(g,m);E&&(m=g+Math.sign(E)*r(Math.abs(E),Ce.angle)),u>v?u=v+r(u-v,Ce.angle):u<w&&(u=w-r(w-u,Ce.angle)),a=y([0,0,0],jl(m,u,s.up),c);let x=T(s.target,s.eye);if(s.eye=y(i,a),n!=="orbit")return s.target=y(s.eye,x),o;let A=T(s.target,e.pivot),M=z(A);if(M>h){let R=(h+r(M-h,Ce.share*f))/M-1;s.target=y(s.target,A,R),s.eye=y(s.eye,A,R)}return o}function oi(s,e,t){_s(s,e,(n,o)=>o*(1-Math.exp(-n/o)),t)}function ri(s,e,t,n){let o=Math.exp(-Gl*n);return _s(s,e,(i,a)=>i<Vl*a?0:i*o,t)>0}var Es,ql,ue,Ce,qt,Gl,Vl,Gt,ti,ii,Wt=S(()=>{"use strict";p();we();B();Es="none",ql=/^-?\d{1,12}(\.\d{1,12})?$/,ue=24,Ce={angle:8,share:.25},qt=Math.PI/180,Gl=9,Vl=.001;Gt=(s,e)=>[s[e],s[e+1],s[e+2]];ti=(s,e)=>((e-s+180)%360+360)%360-180;ii=(s,e)=>_s(s.copy(),e,t=>t,"orbit")});function Xt({axes:s,scale:e,at:t},n){let o=s.map(r=>L(r,n));return y(t,o,e)}function ci(s,e,t){let n=F(e,s),o=N(z(n)>1e-6?n:ge([1,0,0],s)),r=F(o,s),i=Kt(t),a=F(i,Ae);return[0,1,2].map(c=>{let l=y(y([0,0,0],o,a[c]),s,Ae[c]);return y(l,r,-i[c])})}function Kt([s,,e]){return Math.hypot(s,e)>.001?N([s,0,e]):[0,0,-1]}function li(s,e){let t=Vt(e.floor),n=t?L(t.normal,s.eye)-t.offset:0;if(t&&n>0)return{up:t.normal,height:n,scale:jt/n};let o=Zl/s.reach;return{up:s.up,height:jt/o,scale:o}}function fi(s,e,t){let{up:n,height:o,scale:r}=li(s,e),i=ci(n,s.forward,t.forward),a=y(s.eye,n,-o),c=T([t.eye[0],0,t.eye[2]],Xt({axes:i,scale:r,at:[0,0,0]},a));return{axes:i,scale:r,at:c}}function Yt({eye:s,target:e,box:t}){let n=Math.min(Jl,...t??[.5,.5]);return{center:e,radius:n*z(T(e,s))}}function hi(s,e,t,n=null){let{center:o,radius:r}=Yt(s),{up:i,height:a}=li(s,e),c=Kl/(2*r),l=ci(i,s.forward,t.forward),f=Math.min(r,L(i,T(o,y(s.eye,i,-a)))),h=y(y(t.eye,Kt(t.forward),Yl),Ae,-Ql),d=n?y(n,Ae,c*Math.max(0,f)):h;return{axes:l,scale:c,at:T(d,Xt({axes:l,scale:c,at:[0,0,0]},o))}}function As({axes:s,scale:e,at:t},n,o,r=1){let i=[0,1,2].map(c=>Fe([s[0][c],s[1][c],s[2][c]],Ae,o));return{axes:[0,1,2].map(c=>i.map(l=>l[c])),scale:r*e,at:y(n,Fe(T(t,n),Ae,o),r)}}function di(s,e,t,n=Ae){let[o,r]=[T(e[1],e[0]),T(t[1],t[0])],i=y(o,n,-L(o,n)),a=Math.atan2(L(n,F(i,r)),L(i,r)),c=([f,h])=>y(f,T(h,f),.5),l=Math.min(ai,Math.max(1/ai,z(r)/z(o)||1));return ot(As(s,c(e),a,l),T(c(t),c(e)))}var Ae,jt,Kl,Yl,Ql,Zl,Jl,ai,ot,Ss=S(()=>{"use strict";p();Wt();we();B();Ae=[0,1,0],jt=1.6,Kl=.6,Yl=.8,Ql=.35,Zl=2,Jl=1,ai=2;ot=(s,e)=>({...s,at:y(s.at,e)})});var ui,e0,t0,n0,s0,pi,o0,Qt,mi=S(()=>{"use strict";p();Ss();B();ui=1.5,e0=.15,[t0,n0]=[.7,.3],s0=Math.PI/6,pi=[.3,5],o0=3,Qt=class{#e=new Map;#t=new WeakMap;#o=new Set;#s=!1;constructor(e){for(let t of["select","squeeze"])e.addEventListener(`${t}start`,({inputSource:n})=>{n.targetRayMode!=="gaze"&&this.#e.set(n,null)}),e.addEventListener(`${t}end`,({inputSource:n})=>this.#e.delete(n));e.addEventListener("inputsourceschange",({removed:t})=>t.forEach(n=>this.#e.delete(n)))}get holding(){return this.#e.size>0}release(){this.#e.clear()}pull(e,t,n,o,r){let a=[...this.#e].map(([h,d])=>{let m=this.#n(h,e,t,o);return this.#e.set(h,m),{source:h,before:d,now:m}}).filter(({before:h,now:d})=>h&&d).slice(0,2),[c,l]=["before","now"].map(h=>a.map(d=>d[h]));if(a.length===0)return n;if(a.length===1)return ot(n,T(l[0],c[0]));let f=a[0].source.targetRayMode==="screen";return di(n,c,l,f?T([0,0,0],r.forward):void 0)}steer(e,t,n,o,r){let i=Kt(o.forward),a=F(i,[0,1,0]),c=!1;for(let{gamepad:f,handedness:h}of e){if(!f||f.axes.length<2)continue;let[d,m]=f.axes.slice(-2).map(g=>Math.abs(g)>e0?g:0);c||=!!f.buttons[o0]?.pressed;let u=h==="left"&&!r;u||(Math.abs(d)>t0&&!this.#o.has(h)?(this.#o.add(h),n=As(n,r??o.eye,Math.sign(d)*s0)):Math.abs(d)<n0&&this.#o.delete(h)),!r&&(n=ot(n,y([0,0,0],i,m*ui*t)),u&&(n=ot(n,y([0,0,0],a,-d*ui*t))))}let l=c&&!this.#s;return this.#s=c,l?null:n}#n(e,t,n,o){let{gripSpace:r,targetRaySpace:i}=e,a=t.getPose(r??i,n);if(!a)return null;let{position:c,matrix:l}=a.transform,f=[c.x,c.y,c.z];if(r)return f;let h=this.#t.get(e)??Math.min(pi[1],Math.max(pi[0],z(T(o,f))));return this.#t.set(e,h),y(f,[l[8],l[9],l[10]],-h)}}});var gi,r0,i0,Zt,wi=S(()=>{"use strict";p();gi=[4,64],r0=[{scale:1,coarseness:1},{scale:1,coarseness:.6},{scale:.85,coarseness:.6},{scale:.7,coarseness:.6},{scale:.6,coarseness:.6},{scale:.5,coarseness:.6},{scale:.4,coarseness:.6}],i0=3,Zt=class{#e;#t=i0;#o=r0;#s=[];#n=0;#i=gi[0];constructor(e,t){this.#e=e,t!==null&&([this.#o,this.#t]=[[{scale:t,coarseness:1}],0])}get step(){return this.#o[this.#t]}set rate(e){this.#e=e,this.forget()}forget(){this.#s=[],this.#n=0}note(e){let t=this.#s;if(t.push(e),t.length<4||t.reduce((r,i)=>r+i)<500)return;this.#s=[];let n=1e3/this.#e,o=t.filter(r=>r>1.5*n).length/t.length;if(o>.2){let r=t.sort((i,a)=>i-a)[t.length>>1];this.#t=Math.min(this.#t+(r>3*n?2:1),this.#o.length-1),this.#i=Math.min(2*this.#i,gi[1]),this.#n=0}else o>.02||this.#t===0?this.#n=0:++this.#n>=this.#i&&(this.#t-=1,this.#n=0)}}});function bi({projectionMatrix:s,transform:e},{width:t,height:n},o,r){return{viewmat:c0(e.inverse.matrix,o),...a0(s,t,n),width:t,height:n,near:r/o.scale}}function a0(s,e,t){return{fx:s[0]*e/2,fy:s[5]*t/2,cx:(1-s[8])*e/2,cy:(1+s[9])*t/2}}function c0(s,{axes:e,scale:t,at:n}){return[...[1,-1,-1].map((r,i)=>{let a=[0,1,2].map(f=>r*s[4*f+i]),c=e[0].map((f,h)=>a[0]*e[0][h]+a[1]*e[1][h]+a[2]*e[2][h]),l=a[0]*n[0]+a[1]*n[1]+a[2]*n[2]+r*s[12+i];return[...c,l/t]}).flat(),0,0,0,1]}var vi=S(()=>{"use strict";p()});var yi={};Be(yi,{present:()=>h0});async function h0(s,e,t){if(s.session)return s.session.end();if(!s.count)throw new Error("a session can start once the scene is shown");let n=await d0(e);s.session=n,t.setAttribute("aria-pressed","true");let o=new Promise(f=>n.addEventListener("end",f,{once:!0})).then(()=>{s.session=null,t.setAttribute("aria-pressed","false"),s.redraw()}),r=()=>{},i=new Promise((f,h)=>r=h),a=e==="immersive-ar",{sceneView:c,own:l}=await s.webglView(a,f=>r(new Error(f)));try{await Promise.race([o,i,u0(n,s,c,a)]),await Promise.race([o,i])}finally{s.session===n&&await n.end(),l?s.background=s.choices.background:c.destroy()}}async function d0(s){try{return await navigator.xr.requestSession(s,{optionalFeatures:f0[s]})}catch(e){throw new Error(`the session cannot start: ${e.message}`)}}async function u0(s,e,t,n){let o=t.context;if(!o)throw new Error("this browser cannot draw with WebGL2 here");await o.makeXRCompatible();let r=await p0(s);n?t.background=[0,0,0]:t.background=e.choices.background,new Ms(s,e,t,o,r,n)}async function p0(s){try{return await s.requestReferenceSpace("local-floor")}catch{return(await s.requestReferenceSpace("local")).getOffsetReferenceSpace(new XRRigidTransform({y:-jt}))}}var xi,l0,f0,Ms,Ei=S(()=>{"use strict";p();mi();wi();Ss();vi();xi=60,l0=.1,f0={"immersive-vr":["local-floor","hand-tracking"],"immersive-ar":["local-floor","hand-tracking","hit-test"]};Ms=class{#e;#t;#o;#s;#n;#i;#r;#a;#c;#l=1;#f=null;#h=!1;#p=null;#d=NaN;constructor(e,t,n,o,r,i){this.#e=e,this.#t=t,this.#o=n,this.#s=o,this.#n=r,this.#i=i,this.#r=new Qt(e),this.#a=new Zt(e.frameRate??xi,t.scale),this.#c=this.#m(),e.addEventListener("frameratechange",()=>this.#a.rate=e.frameRate??xi),e.addEventListener("visibilitychange",()=>{this.#r.release(),this.#a.forget(),this.#d=NaN}),r.addEventListener("reset",()=>this.#f=null),i&&this.#g(),e.requestAnimationFrame(this.#E)}#m(){this.#l="requestViewportScale"in XRView.prototype?1:this.#a.step.scale;let e={antialias:!1,depth:!1,framebufferScaleFactor:this.#l},t=new XRWebGLLayer(this.#e,this.#s,e);return this.#e.updateRenderState({baseLayer:t}),t}async#g(){try{let e=await this.#e.requestReferenceSpace("viewer");this.#p=await this.#e.requestHitTestSource?.({space:e})??null}catch{}}#E=(e,t)=>{let[n,o]=[this.#e,this.#n];if(this.#o.broken)return void n.end();n.requestAnimationFrame(this.#E);let r=e-this.#d;this.#d=e;let i=n.visibilityState==="hidden"?null:t.getViewerPose(o);if(!i)return;r>0&&n.visibilityState==="visible"&&this.#a.note(r);let{position:a,matrix:c}=i.transform,l={eye:[a.x,a.y,a.z],forward:[-c[8],-c[9],-c[10]]};this.#f=this.#v(this.#f??this.#b(l,t),t,l,Math.min(r/1e3,l0)||0),this.#u(i.views,this.#f??this.#b(l,t))};#b(e,t){let{start:n,notes:o}=this.#t;if(!this.#i)return fi(n,o,e);let[r]=this.#p?t.getHitTestResults(this.#p):[],i=r?.getPose(this.#n)?.transform.position;return hi(n,o,e,i?[i.x,i.y,i.z]:null)}#v(e,t,n,o){let[r,i]=[this.#r,this.#e],a=Xt(e,Yt(this.#t.start).center);this.#h||=r.holding;let c=r.pull(t,this.#n,e,a,n),l=r.steer(i.inputSources,o,c,n,this.#i?a:null);return l===null&&(this.#h=!1),this.#p&&!this.#h?null:l}#u(e,t){let{scale:n,coarseness:o}=this.#a.step,r="requestViewportScale"in XRView.prototype;!r&&n!==this.#l&&(this.#c=this.#m());let{depthNear:i}=this.#e.renderState,{framebuffer:a}=this.#c,c=e.flatMap(d=>{r&&d.requestViewportScale(n);let{x:m,y:u,width:g,height:w}=this.#c.getViewport(d)??{x:0,y:0,width:0,height:0};return!g||!w?[]:[{camera:bi(d,{width:g,height:w},t,i),target:{framebuffer:a,x:m,y:u}}]}),{center:l,radius:f}=Yt(this.#t.start),h=this.#i?[...l,f]:null;c.length&&this.#o.drawEyes(c,o,h)}}});var Ts,ki,_i,ie,Ai,Jo,re=S(()=>{"use strict";p();Ts=()=>Promise.resolve().then(()=>(Xo(),jo)),ki=()=>Promise.resolve().then(()=>(wr(),gr)),_i=()=>Promise.resolve().then(()=>(_r(),kr)),ie=()=>Promise.resolve().then(()=>(Zr(),Qr)),Ai=()=>Promise.resolve().then(()=>(Ei(),yi)),Jo=()=>""});p();p();re();p();var Q=new Set,rt=new Set;function Si(s,e){if(Q.delete(s),Q.size>=4){let t=[...Q],n=t.find(({inSight:o})=>o===!1)??(e?t[0]:void 0);if(!n)return rt.add(s),!1;Q.delete(n),rt.add(n),n.suspend()}return rt.delete(s),Q.add(s),!0}function Mi(s){Q.delete(s),rt.delete(s),Li()}function Ti(s,e){s.inSight=e,Li()}function Ri(s){Q.delete(s)&&Q.add(s)}function Li(){for(let s of[...rt]){let e=Q.size<4||[...Q].some(({inSight:t})=>t===!1);s.inSight&&e&&s.resume()}}p();p();function Jt(s){let e=s?.trim().toLowerCase()??"",t=/^([0-9a-f]{3}|[0-9a-f]{6})$/.test(e)?`#${e}`:e,n=/^#[0-9a-f]+$/.test(t)?t:m0(t),o=n.length===4?n.replace(/[^#]/g,"$&$&"):n;if(!/^#[0-9a-f]{6}$/.test(o))return null;let r=i=>Number.parseInt(o.slice(i,i+2),16)/255;return[r(1),r(3),r(5)]}function Oi(s){let e=t=>Math.round(255*Math.min(Math.max(t,0),1));return`#${s.map(t=>e(t).toString(16).padStart(2,"0")).join("")}`}function m0(s){let e=s?document.createElement("canvas").getContext("2d"):null;if(!e)return"";let[t,n]=["#000000","#ffffff"].map(o=>(e.fillStyle=o,e.fillStyle=s,String(e.fillStyle)));return t===n?t:""}Wt();p();Pt();B();function en({eye:s,target:e,up:t}){let n=Math.min(20,Math.max(0,Math.ceil(4-Math.log10(z(T(e,s)))))),o=(r,i=n)=>r.map(a=>Number(a.toFixed(i))).join(",");return`eye=${o(s)}&at=${o(e)}&up=${o(t,5)}`}function Se(s){let e=new URLSearchParams(s.replace(/^#/,"")),t=["eye","at","up"].map(i=>(e.get(i)??"").split(",").map(Number));if(t.some(i=>i.length!==3||!i.every(Number.isFinite)))return null;let[n,o,r]=t;return n.every((i,a)=>i===o[a])?null:new D(n,o,r)}var zi=["start","start-portrait","limits","free"],Rs=["camera","scale","background","fov","up","autorotate",...zi],Ls="(prefers-reduced-motion: reduce)";function Fi(s){let e=s.getAttribute("variant"),[t,n]=["floats","strips"].map(r=>!!e?.includes(r)),o=Number(s.getAttribute("levels")??NaN);return{variant:e===null?null:{floats:t,strips:n},levels:o===0||o>=.6&&o<=100?o:null,patient:s.hasAttribute("poster"),editable:s.hasAttribute("editable")}}function tn(s,e,t){let n=s.getAttribute(t),o=Number(n);if(t==="scale")e.scale=o>0&&o<=1?o:null;else if(t==="fov")e.fov=o>=1&&o<=150?o:null;else if(t==="background")e.background=Jt(n);else if(t==="up")e.up=n;else if(t==="autorotate")e.turning=n!==null&&!matchMedia(Ls).matches;else if(t==="camera"){let r=Se(n??"");r&&e.place(r)}else e.given=g0(s);e.redraw()}function g0(s){let e={};for(let t of zi){let n=s.getAttribute(t);t==="free"&&n!==null?e.limits=Es:n!==null&&(e[t.replace("-","_")]=n,t.includes("-")||(e[`${t}_portrait`]=""))}return e}p();var nn=()=>({name:"",before:"",failed:"",state:"",share:NaN,sentence:""}),it=class{#e=[nn(),nn()];begin(e,t){let n=this.#e[e].name;this.#e[e]=t===void 0?nn():{...nn(),name:t,before:n,state:"loading"}}fail(e,t,n){let{name:o,before:r}=this.#e[e];this.note(e,{share:1,state:"failed",sentence:t,failed:this.names[e],name:n?r:o})}note(e,t){Object.assign(this.#e[e],t)}get state(){let e=this.#e.map(({state:n})=>n);return["failed","loading","loaded"].find(n=>e.includes(n))??""}get busy(){return this.#e.some(({state:e})=>e==="loading")}get share(){let e=this.#e.filter(({state:t})=>t).map(({share:t})=>t);return e.reduce((t,n)=>t+n,0)/e.length}get sentence(){let e=this.#e.every(({state:n})=>n),t=this.#e.map(({state:n,sentence:o,failed:r})=>n!=="failed"?"":e&&r&&!o.includes(r)?`${r}: ${o}`:o);return[...new Set(t.filter(Boolean))].join("; ")}get names(){return w0(this.#e[0].name,this.#e[1].name)}};function w0(s,e){let[t,n]=[s,e].map(o=>o.split("/").filter(Boolean));for(let o=1;o<=Math.max(t.length,n.length);o++){let[r,i]=[t,n].map(a=>a.slice(-o).map(Os).join("/"));if(r!==i)return[r,i]}return[Os(t[t.length-1]??""),Os(n[n.length-1]??"")]}function Os(s){try{return decodeURIComponent(s)}catch{return s}}p();re();var b0=4e3,v0=7e3,x0=["pointermove","pointerdown","wheel","keydown","focusin"],y0=["pointerdown","wheel","keydown"],Ni={vr:"immersive-vr",ar:"immersive-ar"},sn=class{#e;#t=new Set;#o=0;#s=0;#n=null;constructor(e,t){this.#e=t;let n={capture:!0,passive:!0};for(let o of x0)e.addEventListener(o,()=>this.#i(),n);for(let o of y0)e.addEventListener(o,()=>this.#r(),n)}invite(e){this.#t.has(e)||(this.#t.add(e),this.#i(),this.#a("hint").hidden=!1,clearTimeout(this.#s),this.#s=setTimeout(()=>this.#r(),v0))}setTitle(e,t){let n=this.#a("title"),o=[e,t];o.every((r,i)=>n.children[i].textContent===r)||(o.forEach((r,i)=>n.children[i].textContent=r),n.hidden=!e&&!t)}async offer(){let{featurePolicy:e}=document;if(!(e&&!e.allowsFeature("xr-spatial-tracking")))for(let[t,n]of Object.entries(Ni))await navigator.xr?.isSessionSupported(n).catch(()=>!1)&&(this.#n=(await Ai()).present,this.#a(t).hidden=!1)}present(e,t){return this.#n?.(t,Ni[e],this.#a(e))}#i(){this.#e.classList.remove("idle"),clearTimeout(this.#o),this.#t.size&&(this.#o=setTimeout(()=>this.#e.classList.add("idle"),b0))}#r(){this.#a("hint").hidden=!0}#a(e){return this.#e.querySelector(`.${e}`)}};p();p();re();var zs=4,Ui=()=>location.protocol.startsWith("http");async function Fs(s){try{return await navigator.share(s),!0}catch(e){return e.name==="AbortError"}}var Ns=({hostname:s})=>/^(localhost|127\..*|\[::1\])$/.test(s);async function Ii(s){try{let e=(await ie()).qrCode(s);if(!e)return"";let t=e.length+2*zs,n=e.flatMap((o,r)=>o.flatMap((i,a)=>i?`M${a+zs} ${r+zs}h1v1h-1z`:[]));return`<svg viewBox="0 0 ${t} ${t}"><path d="${n.join("")}"/></svg>`}catch{return""}}var Ci=["settings","help","share","report"],on=class{#e;#t=null;constructor(e){this.#e=e}toggle(e,t){let n=this.#n(e);return n.hidden=t===void 0?!n.hidden:!t,this.#e.querySelector(`[data-act=${e}]`)?.setAttribute("aria-expanded",String(!n.hidden)),!n.hidden}show(e){this.#o||(this.#t=this.#e.activeElement);let t=e!==null&&this.#n(e).hidden;for(let n of Ci)this.toggle(n,t&&n===e);t?this.#n(e).focus():(this.#t??this.#e.querySelector("canvas"))?.focus({preventScroll:!0})}async copy(e){let t=this.#s(),n=navigator.clipboard?await navigator.clipboard.writeText(t).then(()=>!0,()=>!1):document.execCommand("copy");this.#n("sheet:not([hidden]) .copied").textContent=n?e.copied:e.uncopied}send(){let e=this.#s();Fs(this.#o==="share"?{url:e}:{text:e})}async share(e){let{href:t}=location,n=this.#n("share");if(n.hidden&&"share"in navigator&&matchMedia("(pointer: coarse)").matches&&await Fs({title:document.title,url:t}))return;let[r,i]=[n.querySelector("input"),this.#n("code")];r.value=t,this.#n("share .copied").textContent="",n.querySelector("[data-act=send]").hidden=!navigator.share,this.show("share"),i.innerHTML=Ns(location)?"":await Ii(t),i.hidden=!i.innerHTML,this.#n("about").textContent=Ns(location)?e.local:i.hidden?"":e.scan}get#o(){return Ci.find(e=>!this.#n(e).hidden)}#s(){let e=this.#e.querySelector(".sheet:not([hidden]) :is(textarea, [readonly])");return e.focus(),e.select(),e.value}#n(e){return this.#e.querySelector(`.${e}`)}};p();p();p();var rn=(s,e,t)=>`M${s-t} ${e}a${t} ${t} 0 1 0 ${2*t} 0a${t} ${t} 0 1 0-${2*t} 0`,E0={reset:"M4 11.5l8-7 8 7M6.5 9.5V19.5h11V9.5",share:"M12 15V3.5M8 7.5l4-4 4 4M7 11.5H5v9h14v-9h-2",settings:`M4 8h7.5M16.5 8H20M4 16h3.5M12.5 16H20${rn(14,8,2.5)}${rn(10,16,2.5)}`,full:"M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5",window:"M9 4v5H4M20 9h-5V4M15 20v-5h5M4 15h5v5",help:`${rn(12,12,9)}M9.5 9.5a2.5 2.5 0 1 1 3.7 2.2c-.9.5-1.2 1-1.2 2M12 17v.01`,close:"M6.5 6.5l11 11M17.5 6.5l-11 11",drag:`M2.5 12.5c0 3.5 4 6 9.5 6s9.5-2.5 9.5-6M.5 14.5l2-2.5 2.5 2M19 14l2.5-2 2 2.5${rn(12,8,4)}`,vr:"M3.5 7.5h17v9.5h-5.5l-3-3.5-3 3.5H3.5zM8 11.5v.01M16 11.5v.01",ar:"M12 3.5l7.5 4.3v8.4L12 20.5l-7.5-4.3V7.8zM4.5 7.8l7.5 4.2 7.5-4.2M12 12v8.5",wake:"M8 5l11 7-11 7z",alert:"M12 4.5L3 19.5h18zM12 10.5v4M12 17v.01"},pe=s=>`<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${E0[s]}"/></svg>`;p();var $i=':host{display:block;position:relative;overflow:hidden;contain:strict;container-type:size;color-scheme:light dark;min-height:120px;background:#0d0f12;color:var(--ink);--paper: #15171ce6;--ink: #f3f4f6;--dim: #c3c8d0;--line: #ffffff26;--field: #ffffff1f;--accent: #8ab8ff;--on: #0d1420;font:15px/1.45 system-ui,sans-serif;-webkit-text-size-adjust:100%;-webkit-tap-highlight-color:transparent;--top: calc(12px + env(safe-area-inset-top)) ;--bottom: calc(12px + env(safe-area-inset-bottom)) ;--start: calc(12px + env(safe-area-inset-left)) ;--end: calc(12px + env(safe-area-inset-right)) }:host(:dir(rtl)){--start: calc(12px + env(safe-area-inset-right)) ;--end: calc(12px + env(safe-area-inset-left)) }@media(prefers-color-scheme:light){:host{--paper: #fffffff0;--ink: #16181d;--dim: #474d58;--line: #0000001f;--field: #00000012;--accent: #0b57c9;--on: #fff}}[hidden]{display:none!important}canvas{opacity:0;display:block;width:100%;height:100%;touch-action:none;cursor:grab;outline:none}canvas.drawn{opacity:1;transition:opacity .3s}canvas.polite{touch-action:pan-y}canvas:active{cursor:grabbing}canvas.reached{outline:2px solid var(--accent);outline-offset:-2px}.over{position:absolute;inset:0;pointer-events:none}.panel{position:absolute;box-sizing:border-box;background:var(--paper);border-radius:14px;padding:12px 16px;box-shadow:0 0 0 1px var(--line),0 6px 24px #0003;backdrop-filter:blur(12px)}.panel:focus{outline:none}.split{position:absolute;top:0;bottom:0;width:20px;margin-left:-10px;cursor:ew-resize;touch-action:none;outline:none}.split:before{content:"";position:absolute;inset:0 9px;background:#fff;box-shadow:0 0 3px #000a}.split:after{content:"\\2039\\2002\\203a";position:absolute;top:50%;left:-12px;width:44px;height:44px;margin-top:-22px;border-radius:50%;background:var(--paper);line-height:40px;text-align:center;font-size:20px;box-shadow:0 0 0 2px #fff,0 0 5px 2px #000a}.split:focus-visible:after{box-shadow:0 0 0 3px var(--accent)}.split span{position:absolute;top:var(--top);padding:2px 8px;border-radius:6px;background:var(--paper);max-width:40cqw;overflow:hidden;text-overflow:ellipsis;white-space:nowrap}.split span:first-child{right:18px}.split span:last-child{left:18px}slot{display:block;position:absolute;inset:0;overflow:hidden;pointer-events:none}::slotted(*){position:absolute;left:var(--annotation-x, 0);top:var(--annotation-y, 0);translate:-50% -50%;pointer-events:auto}::slotted([data-outside]){visibility:hidden}.bar{position:absolute;inset:0 0 auto;height:3px;background:#0006}.bar>div{height:100%;width:0;background:#8ab8ff;transition:width .15s}.bar.unknown>div{width:100%!important;animation:wait 1.2s ease-in-out infinite alternate}@keyframes wait{0%{opacity:.2}}.stats{top:var(--top);inset-inline-end:var(--end);padding:8px 12px;font:12px/1.5 ui-monospace,monospace;white-space:pre;unicode-bidi:plaintext;pointer-events:none}.split:not([hidden])~.stats{top:calc(var(--top) + 40px)}.said{top:var(--top);inset-inline:var(--start) var(--end);width:fit-content;max-width:calc(100% - 24px);margin-inline:auto;padding:8px 14px;pointer-events:none}.said:not(.seen){clip-path:inset(50%)}.chrome{position:absolute;inset:0;pointer-events:none;transition:inset .2s}.title{top:var(--top);inset-inline-start:var(--start);max-width:min(24em,calc(100% - 24px));padding:8px 14px;overflow-wrap:anywhere;transition:opacity .4s}.title>*{display:block}.title span{color:var(--dim);font-size:13px}.split:not([hidden])~.chrome .title{display:none}.foot{position:absolute;bottom:var(--bottom);inset-inline:var(--start) var(--end);pointer-events:none;display:flex;flex-direction:column;align-items:center;gap:12px}.foot>*{position:static;display:flex;align-items:center}.buttons{flex-wrap:wrap;justify-content:center;padding:4px;gap:2px;pointer-events:auto;transition:opacity .4s}.hint{gap:10px;padding:8px 16px;animation:rise .4s}.hint svg{color:var(--accent);flex:none}.idle:not(:has([aria-expanded=true])) :is(.title,.buttons):not(:has(:focus-visible)){opacity:0}@media(hover:none){.idle:not(:has([aria-expanded=true])) .buttons{pointer-events:none}}@media(hover:hover){.buttons:hover{opacity:1!important}}.sheet,.message{display:flex;flex-direction:column;padding:0;animation:rise .2s}.sheet{top:var(--top);bottom:var(--bottom);inset-inline-end:var(--end);margin-top:auto;width:min(380px,calc(100% - 24px));height:fit-content;max-height:calc(100% - 24px)}.report{width:min(34em,calc(100% - 24px))}.top{display:flex;align-items:center;justify-content:space-between;padding-block:8px 4px;padding-inline:20px 8px}.body{overflow:auto;overscroll-behavior:contain;padding:0 20px 20px}@keyframes rise{0%{opacity:0;translate:0 12px}}@container (min-width: 640px){.chrome:has([aria-expanded=true]){inset-inline-end:392px}}@container (max-width: 639.9px){.sheet{inset:auto 0 0;width:auto;max-height:min(72%,100% - 48px);border-radius:20px 20px 0 0;padding-bottom:env(safe-area-inset-bottom)}}.message{inset:0;margin:auto;width:fit-content;height:fit-content;max-width:min(30em,100% - 24px);max-height:94%;padding:20px;gap:10px;overflow:auto;overflow-wrap:anywhere}.message>svg{color:var(--accent);width:30px;height:30px;flex:none}.message p{margin:0;color:var(--dim)}h2{font-size:17px;line-height:1.3;margin:0}h3{font-size:13px;font-weight:600;color:var(--dim);margin:12px 0 6px}.help .body>:first-child h3{margin-top:0}dl{display:grid;grid-template-columns:fit-content(45%) 1fr;gap:6px 16px;margin:0}dt{font-weight:600}dd{margin:0;color:var(--dim)}dd:first-letter{text-transform:uppercase}kbd{font:12px/1.6 ui-monospace,monospace;padding:1px 6px;border-radius:5px;background:var(--field);white-space:nowrap}@container (max-width: 300px){dl{display:block}dd{margin-bottom:8px}}.touch,.mouse,.keys{display:none}@media(any-pointer:coarse){.touch{display:block}}@media(any-pointer:fine){.mouse,.keys{display:block}}.typed .keys{display:block}.sheet p{display:flex;flex-wrap:wrap;align-items:center;gap:8px;margin:0;min-height:52px}.sheet p>label{flex:1 1 5em}.sheet p+p{border-top:1px solid var(--line)}.sheet p>input:not([type]){flex:1;min-width:0}.acts{display:flex;flex-wrap:wrap;gap:8px}.body>.acts{margin-top:12px}.acts>*{flex:1 0 auto}small{display:block;font-size:13px;color:var(--dim);overflow-wrap:anywhere;margin-top:8px}small:empty{display:none}.code{background:#fff;border-radius:10px;width:min(196px,100%);margin:12px auto 0}.code svg{display:block;width:100%;height:auto;fill:#000;stroke:none;shape-rendering:crispEdges}.about{text-align:center}svg{width:24px;height:24px;fill:none;stroke:currentColor;stroke-width:1.8;stroke-linecap:round;stroke-linejoin:round}button,select,input:not([type]),[type=color]{font:inherit;color:inherit;background:var(--field);border:0;border-radius:10px;box-sizing:border-box;min-width:44px;min-height:44px;padding:0 12px;max-width:100%;touch-action:manipulation}button,select,[type=color],[type=checkbox]{cursor:pointer}select,input:not([type]){font-size:16px}.buttons button,.icon{display:grid;place-items:center;padding:0;width:44px;background:none}.buttons :is([aria-expanded=true],[aria-pressed=true]){background:var(--field);color:var(--accent)}.main{background:var(--accent);color:var(--on)}[type=color]{padding:8px;width:52px}[type=checkbox]{appearance:none;position:relative;width:46px;height:28px;margin:0;border-radius:14px;background:var(--field);box-shadow:inset 0 0 0 1.5px var(--dim)}[type=checkbox]:before{content:"";position:absolute;inset-block:5px;inset-inline-start:5px;width:18px;border-radius:9px;background:var(--dim);transition:inset-inline-start .15s}[type=checkbox]:checked{background:var(--accent);box-shadow:none}[type=checkbox]:checked:before{inset-inline-start:23px;background:var(--on)}@media(forced-colors:active){[type=checkbox]{appearance:auto}}@media(hover:hover){button:hover{background:var(--field);color:var(--accent)}.main:hover{background:var(--accent);color:var(--on);filter:brightness(1.1)}}:is(button,select,input,textarea):focus-visible{outline:2px solid var(--accent);outline-offset:1px}textarea{font:12px/1.3 ui-monospace,monospace;color:inherit;background:var(--field);border:0;border-radius:10px;box-sizing:border-box;width:100%;padding:10px;direction:ltr}.still{position:absolute;inset:0;width:100%;height:100%;pointer-events:none}.wake{position:absolute;inset:0;margin:auto;width:72px;height:72px;border-radius:50%;background:var(--paper)}.stick{position:absolute;inset-block-end:calc(var(--bottom) + 64px);inset-inline-start:var(--start);width:120px;height:120px;border-radius:50%;background:#0006;box-shadow:inset 0 0 0 2px #fff9;touch-action:none}.stick:not(.shown){display:none}.stick span{position:absolute;inset:34px;border-radius:50%;background:#fffd;box-shadow:0 1px 6px #0008}@media not (any-pointer:coarse){.stick{display:none}}.drop{inset:12px;border:2px dashed var(--accent);display:grid;place-items:center;text-align:center}@media(prefers-reduced-motion:reduce){*,:before{transition:none!important;animation:none!important}}';var k0={touch:[["oneFinger","rotate"],["twoFingers","pan"],["pinch","zoom"],["doubleTap","focus"]],mouse:[["drag","rotate"],["rightDrag","pan"],["wheel","zoom"],["doubleClick","focus"]]},_0=[["\u2190 \u2191 \u2193 \u2192","rotate"],["W A S D Q E","flyHelp"],["M","modeHelp"],["V","view"],["R","reset"],["U","up"],["F","full"],["P","picture"],["I","stats"],["O","settings"],["H","help"],["Esc","close"]],Me=(s,e="")=>`<button data-act="${s}" data-name="${s}" ${e}>${pe(s)}</button>`,Z=(s,e=s,t="")=>`<button data-act="${s}" data-text="${e}" ${t}></button>`,an=(s,e)=>`
<div class="panel sheet ${s}" role="dialog" data-name="${s}" tabindex="-1" hidden>
<div class="top"><h2 data-text="${s}"></h2>
<button class="icon" data-act="close" data-name="close">${pe("close")}</button></div>
<div class="body">${e}</div>
</div>`,Di=s=>`<div class="${s}"><h3 data-text="${s}"></h3><dl>${k0[s].map(([e,t])=>`<dt data-text="${e}"></dt><dd data-text="${t}"></dd>`).join("")}</dl></div>`,A0=_0.map(([s,e])=>`<dt>${s.split(" ").map(n=>`<kbd>${n}</kbd>`).join(" ")}</dt><dd data-text="${e}"></dd>`),Pi=`
<style>${$i}</style>
<canvas tabindex="0" role="application"></canvas>
<div class="split" role="slider" tabindex="0" aria-valuemin="0" aria-valuemax="100" hidden>
<span></span><span></span>
</div>
<slot name="annotation"></slot>
<div class="stick" aria-hidden="true"><span></span></div>
<button class="wake" data-act="wake" data-name="wake" hidden>${pe("wake")}</button>
<div class="bar" role="progressbar" data-name="loading" hidden><div></div></div>
<div class="panel stats" hidden></div>
<div class="panel said" role="status"></div>
<div class="chrome">
<div class="panel title" hidden><strong dir="auto"></strong><span dir="auto"></span></div>
<div class="foot">
<div class="panel hint" aria-hidden="true" hidden>${pe("drag")}<span data-text="hint"></span></div>
<div class="panel buttons" role="group" data-name="controls">
${Me("reset",'data-key="R"')}
${Me("share",'aria-expanded="false"')}
${Me("settings",'data-key="O" aria-expanded="false"')}
${Me("help",'data-key="H" aria-expanded="false"')}
${Me("vr",'class="vr" hidden')}
${Me("ar",'class="ar" hidden')}
${Me("full",'data-key="F"')}
</div>
</div>
</div>
${an("settings",`
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
${an("help",`${Di("touch")}${Di("mouse")}
<div class="keys"><h3 data-text="keys"></h3><dl>${A0.join("")}</dl></div>`)}
${an("share",`
<label for="link" data-text="link"></label>
<p><input id="link" readonly /><button data-act="copy" data-text="copy" class="main"></button></p>
<small class="copied" role="status"></small>
<div class="code" role="img" data-name="code"></div>
<small class="about"></small>
<div class="acts">${Z("send")}</div>`)}
${an("report",`
<textarea readonly rows="14" cols="44" data-name="results"></textarea>
<small class="copied" role="status"></small>
<div class="acts">${Z("copy")}${Z("send")}</div>`)}
<div class="panel message" hidden>${pe("alert")}<h2></h2><p role="alert"></p>
<div class="acts"><button class="main" data-act="retry" data-text="retry"></button>
${Z("open")}${Z("close")}</div></div>
<div class="panel drop" data-text="drop" hidden></div>`,Us=new Map(Object.entries({r:"reset",m:"mode",f:"full",h:"help",i:"stats",o:"settings",p:"picture",v:"view",u:"up"}));function Bi(s,e,t){s.addEventListener("keydown",n=>{let{code:o,key:r,ctrlKey:i,metaKey:a,altKey:c,repeat:l,target:f,defaultPrevented:h}=n,d=Us.get(r.toLowerCase())??Us.get(o.slice(3).toLowerCase()),m=h||f.matches("textarea, select, input:not([type])");d&&!i&&!a&&!c&&!l&&!m&&(t(),e(d)),o==="Escape"&&e("close")}),s.addEventListener("keyup",n=>{let{code:o,target:r}=n,{classList:i}=r;o==="Tab"&&(i.add("reached"),r?.addEventListener("blur",()=>i.remove("reached"),{once:!0}))})}function Hi(s,e,t){s.addEventListener("dragover",n=>{n.preventDefault(),e.hidden=!1}),s.addEventListener("dragleave",()=>e.hidden=!0),s.addEventListener("drop",n=>{n.preventDefault(),e.hidden=!0,t(n.dataTransfer?.files)})}p();function qi(s,e,t){let n=s.getAttribute("follow");if(!n)return;let o=s.getRootNode(),r=(a,c)=>{c!==s&&a.viewer?.count&&t(a.viewer.pose.copy(),c)};o.addEventListener("camera",a=>{let c=a.target;c.id===n&&r(c,a.detail.origin)},{signal:e});let i=o.getElementById(n);i&&r(i,i)}p();re();Ct();function Gi(s){return[s.closest("[lang]")?.getAttribute("lang")??"",...navigator.languages].map(n=>n.toLowerCase().split("-")[0]).find(n=>br.includes(n))??"en"}async function Vi(s){if(s==="en")return st;try{return(await _i())[s]}catch{return st}}var Te=(s,...e)=>e.reduce((t,n)=>t.replace("{}",()=>n),s);function cn(s,e){let t=e;for(let n of s.querySelectorAll("[data-text]"))n.textContent=t[n.dataset.text??""];for(let n of s.querySelectorAll("[data-name]")){let o=t[n.dataset.name??""];n.setAttribute("aria-label",o),n instanceof HTMLButtonElement&&(n.title=o+(n.dataset.key?` (${n.dataset.key})`:""))}}p();function Wi(s,e,t,n){let o=h=>s.querySelector(`[name=${h}]`);o("background").value=Oi(e.background);let r=o("scale"),i=e.scale??0;[...r.options].some(({value:h})=>Number(h)===i)||r.add(new Option(`${Math.round(100*i)} %`,String(i))),r.value=String(i),o("mode").value=e.mode,o("turning").checked=e.turning,o("stats").checked=t;let{renderer:a,adapter:c}=e.device,l=a?Te(c?n.adapter:n.device,a,c):"";s.querySelector(".device").textContent=l;let f=s.querySelector("[data-act=view]");f.hidden=e.views.length<2}function ji(s,e){let{name:t,value:n}=s;t==="background"?e.background=Jt(n):t==="scale"?e.scale=Number(n)||null:t==="mode"?e.mode=n:t==="turning"&&(e.turning=s.checked),e.redraw()}p();function Xi(s,e){let t=s.firstElementChild,n=null,o=(a,c)=>{t.style.transform=`translate(${a}px, ${c}px)`,e(a/44,-c/44)};s.addEventListener("pointerdown",a=>{a.preventDefault(),n=a.pointerId,s.setPointerCapture(n),r(a)});let r=a=>{if(a.pointerId!==n)return;let{left:c,top:l,width:f,height:h}=s.getBoundingClientRect(),[d,m]=[a.clientX-c-f/2,a.clientY-l-h/2],u=Math.min(1,44/(Math.hypot(d,m)||1));o(d*u,m*u)},i=a=>{a.pointerId===n&&(n=null,o(0,0))};s.addEventListener("pointermove",r),s.addEventListener("pointerup",i),s.addEventListener("pointercancel",i)}p();var $e=.02,S0=new Map([["ArrowLeft",-$e],["ArrowDown",-$e],["ArrowRight",$e],["ArrowUp",$e],["PageDown",-5*$e],["PageUp",5*$e],["Home",-1],["End",1]]),ln=class{share=.5;#e;#t;#o=["",""];constructor(e,t){this.#e=e,this.#t=t,e.onpointerdown=({pointerId:n})=>e.setPointerCapture(n),e.onpointermove=({pointerId:n,clientX:o})=>{if(!e.hasPointerCapture(n))return;let{left:r,width:i}=t.getBoundingClientRect();this.#s((o-r)/i)},e.onkeydown=n=>{let o=S0.get(n.key);o===void 0||n.ctrlKey||n.metaKey||n.altKey||(n.preventDefault(),this.#s(this.share+o))}}show(e,t){this.#o=e,this.#e.querySelectorAll("span").forEach((n,o)=>n.textContent=e[o]),this.#e.setAttribute("aria-label",Te(t,...e)),this.#e.hidden=!1,this.#t.classList.add("drawn"),this.#s(this.share)}#s(e){this.share=Math.min(Math.max(e,0),1);let t=Math.round(100*this.share);this.#t.style.clipPath=`inset(0 0 0 ${100*this.share}%)`,this.#e.style.left=`${100*this.share}%`,this.#e.setAttribute("aria-valuenow",String(t));let[n,o]=this.#o;this.#e.setAttribute("aria-valuetext",`${t} % ${n}, ${100-t} % ${o}`)}};p();var fn=class{#e=[];lines(e){e.milliseconds&&(this.#e=[...this.#e.slice(-29),e.milliseconds]);let t=this.#e.reduce((o,r)=>o+r,0)/this.#e.length,n=[e.count,e.compared].filter((o,r)=>r===0||o);return[`${e.renderer}, ${e.width} x ${e.height}`,`${n.map(o=>o.toLocaleString("en")).join(" | ")} Gaussians`,this.#e.length?`${(1e3/t).toFixed(0)} frames/s, ${t.toFixed(1)} ms`:"still",...e.fragments?M0(e.fragments):[],...Object.entries(e.passes??{}).map(([o,r])=>`${o} ${r.toFixed(2)} ms`)].join(`
`)}};function M0(s){let e=o=>o.toFixed(1),t=s.reduce((o,r)=>o+r),n=[`${e(t)} fragments per pixel`];return s.length>1?[...n,`${s.map(e).join(" + ")} by level`]:n}Ct();p();Wt();p();var Ki=new Map([["KeyW",[0,0,1]],["KeyS",[0,0,-1]],["KeyA",[-1,0,0]],["KeyD",[1,0,0]],["KeyQ",[0,1,0]],["KeyE",[0,-1,0]]]),Yi=new Map([["ArrowLeft",[-1,0]],["ArrowRight",[1,0]],["ArrowUp",[0,-1]],["ArrowDown",[0,1]]]),hn=class{#e;#t;#o=new AbortController;#s=new Map;#n=new Set;#i=!1;stride=[0,0];#r={x:0,y:0,time:0};constructor(e,t){this.#e=e,this.#t=t;let n=(o,r)=>e.addEventListener(o,r,{signal:this.#o.signal,passive:!1});n("pointerdown",o=>this.#l(o)),n("pointermove",o=>this.#f(o)),n("pointerup",o=>this.#h(o)),n("pointercancel",o=>this.#h(o)),n("wheel",o=>this.#E(o)),n("contextmenu",o=>o.preventDefault()),n("keydown",o=>this.#b(o,!0)),n("keyup",o=>this.#b(o,!1)),n("blur",()=>this.#n.clear())}get busy(){return this.#n.size>0||this.stride.some(Boolean)}get held(){return this.busy||this.#s.size>0}advance(e){if(!this.busy)return;let n=.9*this.#t.pose().reach*e*(this.#i?4:1);for(let i of this.#n){let a=Ki.get(i);a&&this.#a(a[0]*n,a[1]*n,a[2]*n);let c=Yi.get(i);c&&this.#c(c[0]*1.5*e,c[1]*1.5*e)}let[o,r]=this.stride;(o||r)&&this.#a(o*n,0,r*n),this.#t.changed()}#a(e,t,n){let o=this.#t.pose();this.#t.mode()==="walk"?o.walk(e,n):o.move(e,t,n)}destroy(){this.#o.abort()}#c(e,t){let n=this.#t.pose();this.#t.mode()==="orbit"?n.orbit(e,t):n.look(e,t)}#l(e){this.#e.focus({preventScroll:!0}),this.#e.setPointerCapture(e.pointerId),this.#s.set(e.pointerId,{x:e.offsetX,y:e.offsetY});let{x:t,y:n,time:o}=this.#r,r=Math.hypot(e.offsetX-t,e.offsetY-n)<20,i=this.#s.size===1&&e.button===0;i&&r&&e.timeStamp-o<350&&this.#t.focus(e.offsetX,e.offsetY),this.#r={x:e.offsetX,y:e.offsetY,time:i?e.timeStamp:-1/0},this.#t.held(),e.preventDefault()}#f(e){let t=this.#s.get(e.pointerId);if(t===void 0)return;let n={x:e.offsetX,y:e.offsetY};Math.hypot(n.x-this.#r.x,n.y-this.#r.y)>6&&(this.#r.time=-1/0),this.#s.size===1?this.#p(n.x-t.x,n.y-t.y,e):this.#s.size===2&&this.#d(e.pointerId,n),this.#s.set(e.pointerId,n),this.#t.changed()}#h(e){this.#s.delete(e.pointerId)}#p(e,t,n){n.buttons&6||n.shiftKey||n.ctrlKey?this.#m(e,t):this.#c(e*.006,t*.006)}#d(e,t){let n=this.#s.get(e),o=[...this.#s].find(([a])=>a!==e)?.[1];if(n===void 0||o===void 0)return;let r=Math.hypot(n.x-o.x,n.y-o.y),i=Math.hypot(t.x-o.x,t.y-o.y);this.#t.mode()!=="orbit"?this.#a(0,0,2*(i-r)*this.#g):r>0&&i>0&&this.#t.pose().dolly(r/i),this.#m((t.x-n.x)/2,(t.y-n.y)/2)}#m(e,t){this.#a(-e*this.#g,-t*this.#g,0)}get#g(){let{target:e,eye:t}=this.#t.pose();return Math.hypot(...e.map((n,o)=>n-t[o]))/Math.max(this.#e.clientHeight,1)}#E(e){if(this.#e.classList.contains("polite")&&!e.ctrlKey&&!e.metaKey)return;e.preventDefault();let t=e.deltaMode===WheelEvent.DOM_DELTA_LINE?16:1,n=e.deltaY*t*(e.ctrlKey?8:1)*.0012,o=this.#t.pose();this.#t.mode()==="orbit"?o.dolly(Math.exp(n)):this.#a(0,0,-n*o.reach),this.#t.changed()}#b(e,t){let{code:n}=e;if(this.#i=e.shiftKey,!t&&n.startsWith("Meta")&&this.#n.clear(),t&&(e.ctrlKey||e.metaKey||e.altKey)||!Ki.has(n)&&!Yi.has(n))return;let o=t&&!this.#n.has(n);t?this.#n.add(n):this.#n.delete(n),o&&this.advance(.03),this.#t.changed(),e.preventDefault()}};p();_e();p();function dn(s,[e,t,n]){let o=s.length/3,r=new Float32Array(o);for(let l=0;l<o;l++)r[l]=e*s[3*l]+t*s[3*l+1]+n*s[3*l+2];let i=new Uint32Array(r.buffer);for(let l=0;l<o;l++)i[l]=i[l]&2147483648?i[l]:~i[l]&2147483647;let a=Uint32Array.from({length:o},(l,f)=>f),c=new Uint32Array(o);for(let l of[0,16]){let f=new Uint32Array(65537);for(let h=0;h<o;h++)f[(i[h]>>>l&65535)+1]+=1;for(let h=0;h<65536;h++)f[h+1]+=f[h];for(let h=0;h<o;h++){let d=a[h];c[f[i[d]>>>l&65535]++]=d}[a,c]=[c,a]}return a}p();ve();te();fe();_t();var T0=49,Re=24,un=Uint32Array.from({length:4096},(s,e)=>{let t=0;for(let n=0;n<12;n++)t|=(e>>>n&1)<<10*(n%3)+Math.floor(n/3);return t});function Qi(s,e){let t=s.length<4?1/0:4+Y(s).getUint32(0,!0);if(t>s.length)throw new _("the stream of positions is too short to hold what its header says");let n=ye(s.subarray(4,t),e,T0),o=0;for(let l=0;l<e;l++)o+=Math.max(n[l]-1,0);let r=Ne(s.subarray(t),o),i=new Uint16Array(3*e),a=0,c=0;for(let l=0;l<e;l++){let f=n[l]-1;if(f>=Re?(a+=r.take(Re),c+=(1<<f-Re)+r.take(f-Re)):f>=0&&(a+=(1<<f)+r.take(f)),c+=a>>>Re,a&=(1<<Re)-1,c>>>Re)throw new _("the stream of positions leaves its 48-bit grid");let h=un[a&4095]|un[a>>>12]<<4,d=un[c&4095]|un[c>>>12]<<4;for(let m=0,u=0;m<3;m++,u+=10){let g=h>>>u&255|(d>>>u&255)<<8,w=g&32768?g&32767:g^65535;if(Zn(w))throw new _("the stream of positions holds numbers that are not finite");i[3*l+m]=w}}return i}function Zi(s,e){let t=3*Math.ceil(s.length/3/e);if(t<=3)return s;let n=new Uint16Array(3*Math.ceil(s.length/t));for(let o=0,r=0;o<s.length;o+=t,r+=3)n.set(s.subarray(o,o+3),r);return n}function Is(s,{center:e,radius:t,exponent:n}){let o=new Float32Array(s.length),r=t*2**n;for(let i=0;i<s.length;i++)o[i]=e[i%3]+Math.fround(r*H(s[i]));return o}function pn(s){return"stored"in s?Is(s.stored,s.grid):s}p();var R0={from:64,to:65536,times:4},L0={from:32,to:1024,times:2},Ji=128,ta="mobilegs variant 1";function mn(s,e){let t=null;try{t=e?.getItem(`${ta} ${s.describe()}`)??null}catch{}return s.variants.find(n=>ra(n)===t)??null}async function na(s,e){let t={floats:!1,strips:!1},n={...t};if(await ea(s,t,{...t,strips:!0},R0,O0)&&(n.strips=!0),s.variants.some(({floats:o})=>o)){let o={...n,floats:!0};await ea(s,n,o,L0,z0)&&(n.floats=!0)}try{e?.setItem(`${ta} ${s.describe()}`,ra(n))}catch{}return n}async function sa(s){s.setScene({...Cs(1,1,()=>[0,0,1]),packing:{center:[0,0,0],unit:1,leastScaleBits:0,scaleBitsSpan:0},shapes:Uint32Array.of(0,15360,0,0),colors:new Uint32Array(4),shSize:4,lobes:new Uint32Array(5),lobeSize:9}),await s.drawUnseen($s(1))}function oa(s){s.setDots({means:Float32Array.of(0,0,1),color:[0,0,0],side:1,background:[0,0,0]}),s.drawDots($s(1)),s.setDots(null)}var ra=({floats:s,strips:e})=>`${s} ${e}`;async function ea(s,e,t,{from:n,to:o,times:r},i){let a=0;for(let c=n;;c*=r){let{scene:l,side:f}=i(c);s.setScene(l);let h=[1/0,1/0];for(let m=0;m<=3;m++)for(let[u,g]of[e,t].entries()){s.variant=g;let w=performance.now();await s.drawUnseen($s(f)),m>0&&(h[u]=Math.min(h[u],performance.now()-w))}let d=Math.max(...h);if(c===n&&(a=d),d>Math.max(4,3*a)||c>=o)return h[1]<.85*h[0]}}function O0(s){let e=Math.ceil(Math.sqrt(s)),t=o=>2*(o+.5)/e-1;return{scene:Cs(s,.001,o=>[t(o%e),t(Math.floor(o/e)),1]),side:256}}function z0(s){return{scene:Cs(Ji,1,e=>[0,0,1+e/Ji]),side:s}}function Cs(s,e,t){let n=new Float32Array(12*s);for(let o=0;o<s;o++){let[r,i,a]=t(o);n.set([e,0,0,r,0,e,0,i,0,0,e,a],12*o)}return{count:s,packing:null,shapes:n,colors:new Float32Array(3*s),shSize:1,lobes:new Float32Array(2*s).fill(1),lobeSize:1,sorted:!1,weighting:{index:0,exponentMax:4,sigma:1,backgroundWeight:0},background:[0,0,0]}}function $s(s){return{viewmat:[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],fx:s/2,fy:s/2,cx:s/2,cy:s/2,width:s,height:s,near:.1}}Ye();p();_e();re();p();fe();Ye();Ze();Rt();p();os();var gn=class{#e;#t;#o;#s;#n;#i;constructor(e,t,n){let{device:o}=e;this.#e=o,this.#t=t,this.#o=e.dots(n);let{UNIFORM:r,VERTEX:i,COPY_DST:a}=GPUBufferUsage;this.#s=o.createBuffer({size:80,usage:r|a});let c=zt(t);this.#i=c.length/3,this.#n=e.filled(c,i)}draw(e,t){let[n,o,r]=[this.#e,this.#o,this.#t];n.queue.writeBuffer(this.#s,0,Ot(r,e));let i=n.createCommandEncoder(),a=i.beginRenderPass({colorAttachments:[{view:t,loadOp:"clear",storeOp:"store",clearValue:[...r.background,1]}]}),c=[{binding:0,resource:{buffer:this.#s}}];a.setPipeline(o),a.setBindGroup(0,n.createBindGroup({layout:o.getBindGroupLayout(0),entries:c})),a.setVertexBuffer(0,this.#n),a.draw(this.#i),a.end(),n.queue.submit([i.finish()])}destroy(){this.#s.destroy(),this.#n.destroy()}};p();_e();var me=128,ia={srcFactor:"one",dstFactor:"one-minus-src-alpha",operation:"add"},N0={color:ia,alpha:ia},U0={color:{srcFactor:"one",dstFactor:"one",operation:"add"},alpha:{srcFactor:"zero",dstFactor:"one-minus-src-alpha",operation:"add"}},aa=["float32-blendable","float32-filterable"],at=["network","project","splat","resolve"],wn=class s{milliseconds=null;#e;#t=new Map;#o=new Map;#s=null;static async create(e,t){if(!("gpu"in navigator))throw new Error("this browser has no WebGPU on this page: it may need https, or a newer version");let n=await Yo();if(n===null)throw new Error("WebGPU finds no graphics adapter on this device");let r=["timestamp-query","float32-blendable","float32-filterable","shader-f16"].filter(l=>n.features.has(l));if(t&&!aa.every(l=>r.includes(l)))throw new Error("this device cannot blend and filter 32-bit floats");let{maxStorageBufferBindingSize:i,maxBufferSize:a}=n.limits,c=await n.requestDevice({requiredFeatures:r,requiredLimits:{maxStorageBufferBindingSize:i,maxBufferSize:a}});return new s(c,e)}constructor(e,t){if(this.device=e,this.#e=t,this.bilinear=e.createSampler({magFilter:"linear",minFilter:"linear"}),e.features.has("timestamp-query")){let n=16*at.length,o=GPUBufferUsage;this.#s={queries:e.createQuerySet({type:"timestamp",count:2*at.length}),found:e.createBuffer({size:n,usage:o.QUERY_RESOLVE|o.COPY_SRC}),read:e.createBuffer({size:n,usage:o.MAP_READ|o.COPY_DST})}}}get blendsFloats(){return aa.every(e=>this.device.features.has(e))}get number(){return this.device.features.has("shader-f16")?"f16":"f32"}network(e){return this.cached(`network ${e.packed}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.module("network",e),entryPoint:"evaluate_network"}}))}project(e,{strips:t}){return this.cached(`project ${e.packed} ${e.sorted} ${t}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.module("project",e),entryPoint:e.sorted?"project_sorted":"project_sortfree",constants:{STRIPS:Number(t)}}}))}count(e){return this.cached(`count ${e.packed} ${e.sorted}`,()=>this.device.createComputePipeline({layout:"auto",compute:{module:this.module("count",e),entryPoint:"count_fragments",constants:{SORTED:Number(e.sorted)}}}))}splat(e,{floats:t,strips:n},o){return this.cached(`splat ${e.packed} ${e.sorted} ${n} ${t} ${o}`,()=>{let r=e.sorted?N0:U0,i=this.module("splat",e);return this.device.createRenderPipeline({layout:"auto",vertex:{module:i,entryPoint:e.sorted?"corner_sorted":o?"corner_of_level":"corner_sortfree",constants:{STRIPS:Number(n)}},primitive:{topology:n?"triangle-strip":"triangle-list"},fragment:{module:i,entryPoint:e.sorted?"cover":o?"add_to_level":"add_weighted",targets:bn(e.sorted,t).map(a=>({format:a,blend:r}))}})})}enlarge(e,t){return this.cached(`enlarge ${e} ${t}`,()=>{let n=this.module("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:n,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:n,entryPoint:"add_enlarged",constants:{LEVEL:e},targets:bn(!1,t).map(o=>({format:o}))}})})}resolve(e,t,n){return this.cached(`resolve ${e} ${n} ${t}`,()=>{let o=this.module("resolve",null);return this.device.createRenderPipeline({layout:"auto",vertex:{module:o,entryPoint:"whole_picture"},primitive:{topology:"triangle-list"},fragment:{module:o,entryPoint:e?"resolve_sorted":n?"resolve_levels":"resolve_sortfree",targets:[{format:t}]}})})}dots(e){return this.cached(`dots ${e}`,()=>{let t=this.device.createShaderModule({code:this.#e.dots,label:"dots"}),n=[{shaderLocation:0,offset:0,format:"float32x3"}];return this.device.createRenderPipeline({layout:"auto",vertex:{module:t,entryPoint:"corner_of_dot",buffers:[{arrayStride:12,attributes:n}]},fragment:{module:t,entryPoint:"paint_dot",targets:[{format:e}]}})})}filled(e,t){let n=Math.ceil(e.byteLength/4)*4,o=this.device.createBuffer({size:n,usage:t,mappedAtCreation:!0}),r=new Uint8Array(e.buffer,e.byteOffset,e.byteLength);return new Uint8Array(o.getMappedRange()).set(r),o.unmap(),o}bind(e,t){return this.device.createBindGroup({layout:e.getBindGroupLayout(0),entries:Object.entries(t).map(([n,o])=>({binding:Number(n),resource:o instanceof GPUBuffer?{buffer:o}:o}))})}stamps(e,t=!0,n=!0){if(this.#s===null||!(t||n))return;let o=2*at.indexOf(e);return{querySet:this.#s.queries,...t?{beginningOfPassWriteIndex:o}:{},...n?{endOfPassWriteIndex:o+1}:{}}}async time({network:e}){if(this.#s===null||this.#s.read.mapState!=="unmapped")return;let{queries:t,found:n,read:o}=this.#s,r=this.device.createCommandEncoder();r.resolveQuerySet(t,0,2*at.length,n,0),r.copyBufferToBuffer(n,0,o,0,o.size),this.device.queue.submit([r.finish()]),await o.mapAsync(GPUMapMode.READ);let i=new BigUint64Array(o.getMappedRange()),a=at.map((c,l)=>[c,Number(i[2*l+1]-i[2*l])/1e6]);this.milliseconds=Object.fromEntries(e?a:a.slice(1)),o.unmap()}cached(e,t){let n=this.#o.get(e)??t();return this.#o.set(e,n),n}module(e,t){let n=t===null?"":this.#e[t.packed?"packed":"wide"],o=`${e} ${t?.packed}`,r=this.number==="f16"?`enable f16;
`:"",a=`${e==="network"?`${r}alias Num = ${this.number};
`:""}${this.#e.view}
${n}
${this.#e[e]}`,c=this.#t.get(o)??this.device.createShaderModule({code:a,label:e});return this.#t.set(o,c),c}};function Ds(s,e){return Object.fromEntries(s.map((t,n)=>[e+n,t]))}function bn(s,e){return e?s?["rgba32float"]:["rgba32float","r32float"]:s?["rgba16float"]:["rgba16float","r16float"]}var I0=6,C0={packed:8,wide:32},Ps=new Float32Array(0),ct=class s{static files=["view","wide","packed","network","project","splat","resolve","count","dots"].map(e=>`${e}.wgsl`);variant;levelSigma=0;supersampling=1;lost=null;onLost=()=>{};#e;#t;#o;#s;#n;#i=null;#r=null;#a=null;#c=null;#l;#f;#h=null;#p;static async create(e,t,{floats:n=!1,strips:o=!1}={}){let r=await wn.create(t,n);return new s(r,e,{floats:n,strips:o})}constructor(e,t,n){let o=t.getContext("webgpu");if(o===null)throw new Error("this canvas is already drawn to in another way");let{device:r}=e;this.variant=n,this.#e=e,this.#t=r,this.#s=t,this.#o=o,this.#n=navigator.gpu.getPreferredCanvasFormat(),o.configure({device:r,format:this.#n,alphaMode:"opaque"});let i=GPUBufferUsage;this.#l=r.createBuffer({size:Je,usage:i.UNIFORM|i.COPY_DST});let a=i.STORAGE|i.INDIRECT|i.COPY_DST;this.#f=r.createBuffer({size:4*I0,usage:a});let c=new Uint16Array(6*me);for(let l=0;l<me;l++)c.set([0,1,2,2,1,3].map(f=>4*l+f),6*l);this.#p=e.filled(c,i.INDEX),r.lost.then(({reason:l})=>{l!=="destroyed"&&this.#d("the graphics device was lost: reload the page to go on")}),r.onuncapturederror=({error:l})=>this.#d(`this GPU cannot draw the scene: ${l.message}`)}get variants(){return(this.#e.blendsFloats?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}get milliseconds(){return this.#e.milliseconds}setScene(e){this.#m();let{count:t,sorted:n}=e,o={sorted:n,packed:e.packing!==null,network:!!e.network},r=C0[o.packed?"packed":"wide"]*Math.max(t,1),i={shapes:e.shapes,colors:e.colors,lobes:e.lobes},a=Math.max(r,...Object.values(i).map(u=>u.byteLength)),{maxStorageBufferBindingSize:c,maxBufferSize:l}=this.#t.limits,f=Math.min(c,l);if(a>f)throw new Error(`${t} Gaussians need ${Math.ceil(a/2**20)} MiB at a stretch, and this device gives ${Math.floor(f/2**20)}`);let h=GPUBufferUsage,d=u=>this.#e.filled(u.length?u:new Uint32Array(16),h.STORAGE|h.COPY_DST),m=u=>this.#t.createBuffer({size:4*Math.max(1,u),usage:h.STORAGE|h.COPY_DST});this.#r={kind:o,parts:{shapes:d(i.shapes),colors:d(i.colors),lobes:d(i.lobes)},looks:this.#t.createBuffer({size:r,usage:h.STORAGE}),order:m(t),network:e.network?{weights:this.#e.filled(this.#u(e.network),h.STORAGE),lobes:m(t)}:null},this.#i={...e,shapes:Ps,colors:Ps,lobes:Ps},n&&this.setOrder(Uint32Array.from({length:t},(u,g)=>g))}show(e){this.#i&&(this.#i.count=e)}update(e,t,n){if(!this.#i||!this.#r||this.lost!==null)return;let o=4*Ie(this.#i)[e]*t;this.#t.queue.writeBuffer(this.#r.parts[e],o,n)}setDots(e){this.#a?.destroy(),this.#a=e&&new gn(this.#e,e,this.#n)}drawDots(e){this.lost===null&&this.#a?.draw(e,this.#E(e))}setOrder(e){this.#r?.kind.sorted&&this.#t.queue.writeBuffer(this.#r.order,0,e)}draw(e){this.lost===null&&this.#v(e,this.#E(e),this.#n)}async pixels(e){let{width:t,height:n}=e,o=Math.ceil(16*t/256)*256,r=this.#b(t,n,"rgba32float");this.#v(e,r.createView(),"rgba32float");let i=this.#t.createBuffer({size:o*n,usage:GPUBufferUsage.MAP_READ|GPUBufferUsage.COPY_DST}),a=this.#t.createCommandEncoder();a.copyTextureToBuffer({texture:r},{buffer:i,bytesPerRow:o},[t,n]),this.#t.queue.submit([a.finish()]),await i.mapAsync(GPUMapMode.READ);let c=new Float32Array(i.getMappedRange()),l=new Float32Array(4*t*n);for(let f=0;f<n;f++){let h=f*o/4;l.set(c.subarray(h,h+4*t),4*t*f)}return i.destroy(),r.destroy(),l}async drawUnseen(e){let t=this.#b(e.width,e.height,this.#n);if(this.#v(e,t.createView(),this.#n),await this.finished(),t.destroy(),this.lost!==null)throw new Error(this.lost)}async finished(){await this.#t.queue.onSubmittedWorkDone()}describe(){let e=this.#t.adapterInfo;return[e?.vendor,e?.architecture,e?.device,e?.description].filter(Boolean).join(" ")}async time(){this.lost===null&&this.#r&&await this.#e.time(this.#r.kind)}async fragments(){let[e,t,n]=[this.#r,this.#i,this.#h];if(!e||!t||!n||this.lost!==null)return null;let o=GPUBufferUsage,r=this.#e.filled(new Uint32Array(4),o.STORAGE|o.COPY_SRC),i=this.#t.createBuffer({size:r.size,usage:o.MAP_READ|o.COPY_DST}),{kind:a,parts:c,looks:l,order:f}=e,h=this.#t.createCommandEncoder(),d={0:this.#l,1:c.shapes,4:l,5:f,6:this.#f,7:r};this.#x(h,null,this.#e.count(a),d,Math.ceil(t.count/me)),h.copyBufferToBuffer(r,0,i,0,r.size),this.#t.queue.submit([h.finish()]),await i.mapAsync(GPUMapMode.READ);let m=Array.from(new Uint32Array(i.getMappedRange()),u=>u/8/n.pixels);for(let u of[r,i])u.destroy();return n.leveled?m:m.slice(0,1)}destroy(){this.#m(),this.setDots(null),this.#t.onuncapturederror=null,this.#t.destroy()}#d(e){this.lost===null&&(this.lost=e,this.onLost(e))}#m(){for(let e of this.#g())e.destroy();this.#r=this.#i=this.#h=null}#g(){if(this.#r===null)return[];let{parts:e,looks:t,order:n,network:o}=this.#r;return[...Object.values(e),t,n,...Object.values(o??{})]}#E({width:e,height:t}){return this.#s.width!==e&&(this.#s.width=e),this.#s.height!==t&&(this.#s.height=t),this.#o.getCurrentTexture().createView()}#b(e,t,n){let o=GPUTextureUsage;return this.#t.createTexture({size:[e,t],format:n,usage:o.RENDER_ATTACHMENT|o.COPY_SRC})}#v(e,t,n){let o=this.#i;if(!o||!this.#r)return;let r=et(e,this.supersampling),{queue:i}=this.#t,{floats:a,strips:c}=this.variant,l=this.#t.limits.maxTextureDimension2D,h=Math.max(...de(r.width,r.height).size)<=l&&!o.sorted&&this.levelSigma>0,d=h?this.levelSigma:0,m=Tt(o,r,a?1:Mt,d,this.supersampling);i.writeBuffer(this.#l,0,m),i.writeBuffer(this.#f,0,Uint32Array.of(c?4:6*me,0,0,0,0,0));let u=this.#R(r.width,r.height,o.sorted,h);this.#h={leveled:h,pixels:e.width*e.height};let g=this.#t.createCommandEncoder();this.#k(g,o.count,this.#r),this.#_(g,o.count,this.#r),this.#y(g,o.count,this.#r,u[0],h),h&&(this.#S(g,this.#e.enlarge(2,a),[...u[0],...u[0]],u[2],!0,!1),this.#S(g,this.#e.enlarge(1,a),[...u[0],...u[2]],u[1],!1,!1));let w=u.slice(0,2).flat();this.#S(g,this.#e.resolve(o.sorted,n,h),w,[t],!h,!0),i.submit([g.finish()])}#u(e){return this.#e.number==="f16"?Uint16Array.from(e,oe):e}#k(e,t,{kind:n,parts:o,network:r}){if(r===null)return;let i={0:this.#l,1:o.shapes,4:o.lobes,5:r.weights,6:r.lobes};this.#x(e,"network",this.#e.network(n),i,Math.ceil(t/32))}#_(e,t,{kind:n,parts:o,looks:r,order:i,network:a}){let c=a?.lobes??o.lobes,l=[this.#l,o.shapes,o.colors,c,r];n.sorted||l.push(i,this.#f);let f=this.#e.project(n,this.variant);this.#x(e,"project",f,Ds(l,0),Math.ceil(t/me))}#x(e,t,n,o,r){let i=Math.max(1,Math.min(r,65535)),a=e.beginComputePass(t?{timestampWrites:this.#e.stamps(t)}:{});a.setPipeline(n),a.setBindGroup(0,this.#e.bind(n,o)),a.dispatchWorkgroups(i,Math.ceil(r/i)),a.end()}#y(e,t,{kind:n,parts:o,looks:r,order:i},a,c){let l=[{r:0,g:0,b:0,a:n.sorted?0:1},{r:0,g:0,b:0,a:0}],f=this.#e.splat(n,this.variant,c),h=e.beginRenderPass({colorAttachments:a.map((m,u)=>({view:m,loadOp:"clear",storeOp:"store",clearValue:l[u]})),timestampWrites:this.#e.stamps("splat")});h.setPipeline(f);let d={0:this.#l,1:o.shapes,4:r,5:i};h.setBindGroup(0,this.#e.bind(f,n.sorted?d:{...d,6:this.#f})),h.setIndexBuffer(this.#p,"uint16"),this.variant.strips?n.sorted?h.draw(4,t):h.drawIndirect(this.#f,0):n.sorted?h.drawIndexed(6*me,Math.ceil(t/me)):h.drawIndexedIndirect(this.#f,0),h.end()}#S(e,t,n,o,r,i){let a=e.beginRenderPass({colorAttachments:o.map(l=>({view:l,loadOp:"clear",storeOp:"store"})),timestampWrites:this.#e.stamps("resolve",r,i)});a.setPipeline(t);let c={0:this.#l,...Ds(n,1)};n.length===4&&(c[5]=this.#e.bilinear),a.setBindGroup(0,this.#e.bind(t,c)),a.draw(3),a.end()}#R(e,t,n,o){let r=`${e} ${t} ${n} ${o} ${this.variant.floats}`;if(this.#c?.key===r)return this.#c.views;for(let f of this.#c?.textures??[])f.destroy();let i=GPUTextureUsage,a=[],l=(o?[de(e,t).size,...he(e,t).slice(1,3)]:[[e,t]]).map(f=>bn(n,this.variant.floats).map(h=>{let d=i.RENDER_ATTACHMENT|i.TEXTURE_BINDING,m=this.#t.createTexture({size:f,format:h,usage:d});return a.push(m),m.createView()}));return this.#c={key:r,textures:a,views:l},l}};async function vn(s,e){let t="";if(e!=="webgl")try{let n=await ca(ct.files,St);return{name:"WebGPU",renderer:await ct.create(s,n)}}catch(n){if(e==="webgpu")throw n;t=n instanceof Error?n.message:String(n)}try{let{WebGlRenderer:n,shaderText:o}=await ki();return{name:"WebGL2",renderer:n.create(s,await ca(n.files,o))}}catch(n){let o=n instanceof Error?n.message:String(n);throw new Error(`this browser cannot draw the scene: ${t?`${t}; `:""}${o}`)}}async function ca(s,e){let t=s.map(async n=>[n.replace(/\.[a-z]+$/,""),await e(n)]);return Object.fromEntries(await Promise.all(t))}p();fe();p();yt();var k=128,$0=1e-12,la=new Float32Array(0),xn=class{wasmMemory=null;#e=[];#t=0;#o=null;#s;constructor(e=!1){this.#s=e}block(e){return this.#n(e,k*e,null)}part({at:e},t,n){let o={at:e+4*k*t,width:n,numbers:la};return this.#e.push([o,null,k*n]),o}layer(e,t,n){let o=n?n.length:e.length/t,r=Math.ceil(o/4)*4,i=new Float32Array(r*t);for(let l=0;l<o;l++){let f=(l-l%4)*t+l%4;for(let h=0;h<t;h++)i[f+4*h]=e[l*t+h]}let a=new Float32Array(r);n&&a.set(n);let c=l=>this.#n(0,l.length,l);return{inputs:t,outputs:r,weights:c(i),offsets:c(a)}}#n(e,t,n){let o={at:this.#t,width:e,numbers:la};return this.#e.push([o,n,t]),this.#t+=16*Math.ceil(t/4),o}allocate(){this.wasmMemory=xt(this.#t);let e=this.wasmMemory?.buffer??new ArrayBuffer(this.#t);for(let[t,n,o]of this.#e.splice(0))t.numbers=new Float32Array(e,t.at,o),n&&t.numbers.set(n);this.#o=this.#s?null:Ue(this.wasmMemory)}apply({inputs:e,outputs:t,weights:n,offsets:o},r,i,a){if(this.#o){this.#o.layer(n.at,o.at,r.at,i.at,e,t,a);return}let[c,l,f,h]=[r,i,n,o].map(({numbers:d})=>d);for(let d=0;d<t;d++){let m=(d-d%4)*e+d%4;for(let u=0;u<k;u++){let g=h[d];for(let w=0;w<e;w++)g+=f[m+4*w]*c[w*k+u];l[d*k+u]=Math.max(g,a*g)}}}units({at:e,width:t,numbers:n},{at:o,numbers:r}){if(this.#o){this.#o.units(e,o,t);return}for(let i=0;i<k;i++){let a=0;for(let l=i;l<k*t;l+=k)a+=n[l]*n[l];let c=1/Math.max(Math.sqrt(a),$0);for(let l=i;l<k*t;l+=k)r[l]=n[l]*c}}};yt();nr();var{fround:P}=Math,D0=["mobile_gs","no_depth","no_scale","sort_free_gs"],Hs=oe(-1e4),P0=[2047,2047,1023],fa=P(511/Math.SQRT1_2),ha=888,lt=new Uint32Array(1),yn=new Float32Array(lt.buffer);function da({sorted:s,weighting:e,footprint:t,background:n,grid:o,lobes:r},i,a,c=null){let l=r?.degree??0,[f,h]=pa(a);return{count:i,packing:{center:Array.from(o.center),unit:o.radius*2**o.exponent,leastScaleBits:f,scaleBitsSpan:h},...ua(c?10:ma(l),i),network:c&&tr(c),shSize:4,lobeSize:(l+1)**2,sorted:s,weighting:{index:D0.indexOf(e.name),exponentMax:e.exponent_max,sigma:e.sigma,backgroundWeight:e.background_weight,alphaMin:e.alpha_min},footprint:t,background:Array.from(n)}}function En(s,e,t=ua(Bs(s),e.positions.length/3)){let n=e.positions.length/3,o=Bs(s),r=4*k,i;for(let a=0;a<n;a+=k){let c=s.decode(e,a);i??=B0(c);let l=i();t.shapes.set(l.subarray(0,4*c.count),4*a),t.colors.set(l.subarray(r,r+4*c.count),4*a),t.lobes.set(l.subarray(2*r,2*r+o*c.count),o*a)}return t}var ua=(s,e)=>({shapes:new Uint32Array(4*e),colors:new Uint32Array(4*e),lobes:new Uint32Array(s*e)});function pa(s){let[e,t]=s.map(n=>(yn[0]=n,P(lt[0])));return[e,t-e]}var ma=s=>(s+1)**2+2>>1,Bs=({network:s,lobeDegree:e})=>s?10:ma(e);function B0(s,e=!1){let{scales:t,quats:n,sh:o,lobes:r,lobeDegree:i,statics:a,scaleRange:c,memory:l}=s,{buffer:f,byteOffset:h,length:d}=s.words,m=new Uint32Array(f,h,d),[u,g]=pa(c),w=g>0?P(1/g):0,v=e?null:Ue(l),[E,x,A,M]=[t,n,o,r].map(({byteOffset:ae})=>ae),R=a.length>0,[$,V]=[(i+1)**2-1,Bs({network:R,lobeDegree:i})];return()=>{v?v.pack(E,x,A,M,h,$,V,u,w):H0(s,m,V,u,w),R&&q0(a,m);let{count:ae,positions:I}=s;for(let K=0,ce=0;K<ae;K++,ce+=4)m[ce]=I[3*K]|I[3*K+1]<<16,m[ce+1]|=I[3*K+2];return m}}function H0({scales:s,quats:e,sh:t,lobes:n,lobeDegree:o},r,i,a,c){let l=2*(o+1)**2;for(let f=0;f<k;f++){let h=8*k+i*f,d=W0(n,f,l,r,h);V0(t,f,r,4*(k+f)),r[4*f+1]=d<<16;let m=0;for(let g=2;g>=0;g--){yn[0]=s[g*k+f];let w=P(P(P(lt[0])-a)*c);m=m<<11|P(P(P0[g]*Math.min(Math.max(w,0),1))+.5)}r[4*f+2]=m;let u=[0,1,2,3].map(g=>e[g*k+f]);r[4*f+3]=G0(u),u.some(Boolean)||(r[h]=Hs|r[h]&4294901760)}}function q0(s,e){for(let t=0;t<k;t++){let n=8*k+10*t;e[n]=e[n]&65535|Math.round(32767*s[t])<<16;for(let o=1;o<10;o++){let[r,i]=[2*o-1,2*o].map(a=>Math.round(32767*s[a*k+t]));e[n+o]=r&65535|i<<16}}}function G0(s){let e=0;for(let o=1;o<4;o++)Math.abs(s[o])>Math.abs(s[e])&&(e=o);let t=s[e]<0?-fa:fa,n=e;for(let o=0;o<4;o++)o!==e&&(n=n<<10|P(P(t*s[o])+1024.5)&1023);return n}function V0(s,e,t,n){let o=c=>s[c*k+e],r=Array.from({length:9},(c,l)=>o(3+l)),i=ba(r),a=r.map(c=>wa(i,c));t[n]=oe(o(0))|oe(o(1))<<16,t[n+1]=oe(o(2))|i<<16|a[0]<<24;for(let c of[1,5])t[n+1+(c+3>>2)]=ga(a,c)}function W0(s,e,t,n,o){let r=f=>s[f*k+e],i=Array.from({length:t-2},(f,h)=>r(2+h)),[a,c]=[0,1].map(f=>ba(i.filter((h,d)=>d%2===f))),l=i.map((f,h)=>wa(h%2?c:a,f));n[o]=oe(r(0))|oe(r(1))<<16;for(let f=0,h=o+1;f<l.length;f+=4,h++)n[h]=ga(l,f);return a|c<<8}var ga=(s,e)=>s[e]|s[e+1]<<8|s[e+2]<<16|s[e+3]<<24;function wa(s,e){lt[0]=s+ha<<20;let t=P(P(127/yn[0])*e);return P(Math.min(Math.max(t,-127),127)+512.5)&255}function ba(s){return yn[0]=Math.max(0,...s.map(Math.abs)),Math.min(Math.max((lt[0]+1048575>>20)-ha,0),255)}Ze();p();var va=new Map;function xa(s){let e=va.get(s)??j0(s);return va.set(s,e),e}async function j0(s){let{renderer:e}=await vn(document.createElement("canvas"),s);try{return mn(e,kn())??await na(e,kn())}finally{e.destroy()}}function kn(){try{return localStorage}catch{return null}}p();B();var X0=Math.cos(.5*Math.PI/180),_n=class{by="";#e=!1;#t=null;reset(e){this.by=e,this.#e=!1}invalidate(){this.#t=null}get pending(){return this.#e}received(){this.#e=!1}neededDirection({viewmat:e}){let t=[e[8],e[9],e[10]],n=this.#t!==null&&L(t,this.#t)>=X0;return!this.by||this.#e||n?null:(this.#e=this.by==="worker",this.#t=t)}};p();Ze();var ya=12;function Ea(s,e,t,n,o){let{viewmat:r,fx:i,fy:a,cx:c,cy:l,near:f}=t,h=-1,d=1/0;for(let m=0;3*m<s.length;m++){if(e[m]<0)continue;let[u,g,w]=[s[3*m],s[3*m+1],s[3*m+2]],v=r[8]*u+r[9]*g+r[10]*w+r[11];if(v<=f||v>=d)continue;let E=i*(r[0]*u+r[1]*g+r[2]*w+r[3])/v+c-n,x=a*(r[4]*u+r[5]*g+r[6]*w+r[7])/v+l-o;E*E+x*x>ya*ya||(d=v,h=m)}return h<0?null:[s[3*h],s[3*h+1],s[3*h+2]]}function An(s,e,t,n){let o=n instanceof Uint32Array;for(let r=0;r*e<n.length;r++)s[t+r]=o?sr(n[r*e]):n[r*e]}var K0=.6,Y0=1e3,Q0=50,ft=class{count=0;total=0;views=[];near=.2;up=null;notes={};editable=!1;logits=new Float32Array(0);request=null;fragments=null;patient=!1;calibrated=Promise.resolve();name="";broken=!1;#e=new Float32Array(0);#t;#o;#s=!1;#n;#i;#r=null;#a=null;#c=null;#l=null;#f=Promise.resolve(!1);#h=!1;#p=null;#d=!1;#m=2;#g=new Uint32Array(0);#E=[0,0,0];#b=null;#v=[0,0,0];#u=new _n;#k=null;#_=-1/0;#x=!1;#y=!1;#S=!1;constructor(e,t,n,o,r=null){this.canvas=e,this.#i=t,this.#t=n,this.#o=r,this.#n=o}begin(e){return this.#f=this.#R(e)}async#R(e){try{let{name:t,renderer:n}=await vn(this.canvas,e);if(this.#h)return n.destroy(),!1;n.onLost=i=>this.#O(i),"onRestored"in n&&(n.onRestored=()=>this.request&&this.load(this.request));let r=n.variants.find(({floats:i,strips:a})=>i===this.#t?.floats&&a===this.#t.strips)??mn(n,kn());return r&&(n.variant=r),n.levelSigma=this.#o??1,this.#s=r!==null,this.#r=n,this.name=t,oa(n),!0}catch(t){return this.#i.failed(Sn(t)),!1}}async#N(){if(this.#s||this.broken)return;this.#s=!0;let e=this.name==="WebGPU"?"webgpu":"webgl",t=await xa(e);this.#r&&(this.#r.variant=t),this.#i.changed()}load(e,t=!1){this.#c?.terminate(),this.request=e;let n=Ko(e,async({data:o})=>{if(!await this.#f){n.terminate();return}(n===this.#c||n===this.#a)&&this.#z(o,n)});n.onerror=o=>{o.preventDefault(),!t&&n===this.#c?this.load(e,!0):this.#C("the viewer's own files could not be loaded: reload the page",n)},this.#c=this.#l=n}async sort(e){if(this.#u.by==="")return null;if(this.broken)throw new Error("the renderer was lost");this.#u.pending&&await this.#M();let t=performance.now();return this.#u.invalidate(),this.#w(e),this.#u.pending&&await this.#M(),performance.now()-t}#M(){return new Promise((e,t)=>this.#k={resolve:e,reject:t})}#A(e){this.#k?.reject(new Error(e)),this.#k=null}draw(e,t=1){if(this.#a===null)return;let n={...e,near:this.near};if(this.#y){this.#r?.drawDots(n),this.#L();return}this.#w(e),this.#r&&(this.#r.supersampling=t,this.#r.draw(n),this.#r.supersampling=1)}get context(){return this.#U?.context??null}get#U(){return this.#r&&"context"in this.#r?this.#r:null}drawEyes(e,t,n){let o=this.#U;if(this.#a===null||this.broken||!o)return;this.#y||this.#w(e[0].camera);let{levelSigma:r}=o;r&&(o.levelSigma=Math.max(K0,t*r)),o.crop=n;try{for(let{camera:i,target:a}of e){let c={...i,near:Math.max(i.near,this.near)};this.#y?o.drawDots(c,a):o.draw(c,a)}}catch(i){this.#O(Sn(i))}o.crop=null,o.levelSigma=r,this.#y&&this.#L()}async#L(){let e=this.#r;this.#S||this.#n||!e||(this.#S=!0,await new Promise(t=>setTimeout(t,Q0)),this.#y&&!this.#h&&await sa(e).catch(()=>{}))}drawOrReport(e,t){if(!this.broken)try{this.draw(e,t)}catch(n){this.#O(Sn(n))}}async finished(){await this.#r?.finished()}pixels(e){return(this.#a&&!this.#y?this.#r?.pixels(e):null)??Promise.reject(new Error("nothing can be drawn"))}hide(e){let t=this.#g.slice();for(let n=0,o=0;o<t.length;n++,o+=this.#m)e[n]&&(t[o]=Hs|t[o]&4294901760);this.#r?.update("lobes",0,t),An(this.logits,this.#m,0,t),this.#i.ordered()}get background(){return this.#b??this.#E}set background(e){this.#b=e,this.background.forEach((t,n)=>this.#v[n]=t)}get means(){return this.#e=pn(this.#e)}get milliseconds(){return this.#r?.milliseconds??null}async time(){this.#x||!this.#r||(this.#x=!0,await this.#r.time().catch(()=>{}),performance.now()>this.#_+Y0&&(this.fragments=await this.countFragments(),this.#_=performance.now()),this.#x=!1)}async countFragments(){return this.#y||this.broken?null:await this.#r?.fragments().catch(()=>null)??null}get device(){let{floats:e,strips:t}=this.#r?.variant??{floats:!1,strips:!1},n=`${e?"floats":"halves"}, ${t?"strips":"batches"}`,{by:o}=this.#u,r=this.#r?.describe()??"";return{renderer:this.name,adapter:r,variant:n,sorted:o!=="",sorted_by:o||null}}destroy(){this.#h=this.broken=!0,this.#A("the renderer was lost"),this.#c?.terminate(),this.#a?.terminate(),this.#r?.destroy(),this.#r=null}#O(e){this.broken=!0,this.#A(e),this.#i.broken(e)}#z(e,t){this.broken&&t===this.#a||(e.kind==="failed"?this.#C(e.sentence,t):e.kind==="progress"?t===this.#l&&this.#i.progress(e.received/e.total):e.kind==="dots"?this.#$(e,t):e.kind==="scene"?this.#D(e,t):e.kind==="rows"?this.#B(e):e.kind==="more"?this.#T(e.means):e.kind==="order"?this.#I(e.order):(this.#u.by!=="worker"&&t.terminate(),this.#c||(this.calibrated=this.#N().catch(()=>{})),t===this.#l&&this.#i.loaded(e.milliseconds,e.bytes)))}#C(e,t){let n=t===this.#c&&this.#p!==null;t===this.#a&&this.#A(e),t===this.#c&&(this.#c=null,this.request=this.#p),(t!==this.#a||this.#u.by!=="worker")&&t.terminate(),t===this.#l&&this.#i.failed(e,n)}#$({dots:e,...t},n){if(this.patient&&!this.count){this.#y=!0,this.#L();return}this.#u.reset(""),this.#P(n,e.background,()=>this.#r?.setDots(e))&&(this.#y=!0,this.#F(t),this.logits=new Float32Array(e.means.length/3),this.#T(e.means),this.#d||this.#i.arrived())}#D({data:e,means:t,...n},o){let r=o===this.#a;this.#u.reset(e.sorted?"worker":this.#n?"page":""),e.sorted=this.#u.by!=="",this.#P(o,e.background,()=>{this.#r&&(this.#r.setDots(null),this.#r.setScene(e),this.#r.levelSigma=this.#o??er(e.footprint))})&&(this.#y=!1,this.#F(n),this.logits=new Float32Array(e.count),this.total=e.count,this.#m=Ie(e).lobes,this.editable&&e.lobes instanceof Uint32Array&&(this.#g=e.lobes),An(this.logits,this.#m,0,e.lobes),this.#T(t),!r&&!this.#d&&this.#i.arrived())}#P(e,t,n){if(e!==this.#a&&(this.#a?.terminate(),this.#A("another scene was opened")),this.#a=e,e===this.#c&&(this.#d=this.request===this.#p&&this.count>0,this.#p=this.request,this.#c=null),this.#E=[...t],this.#v=t,this.background=this.#b,this.#r?.lost)return this.#O(this.#r.lost),!1;try{n()}catch(o){return e.terminate(),this.#a=null,this.#u.reset(""),this.count=0,this.#i.failed(Sn(o)),!1}return this.broken=!1,!0}#F({views:e,near:t,up:n,notes:o}){this.views=e,this.near=t,this.up=n,this.notes=o}#T(e){this.#e=e,this.count=("stored"in e?e.stored:e).length/3,this.#r?.show(this.count),this.#u.invalidate(),this.#i.changed()}#B({part:e,from:t,numbers:n}){this.#r?.update(e,t,n),e==="lobes"&&(this.#g.length&&this.#g.set(n,t*this.#m),An(this.logits,this.#m,t,n)),this.#i.changed()}#I(e){this.#u.received(),this.#r?.setOrder(e),this.#k?.resolve(),this.#k=null,this.#i.ordered()}#w(e){let t=this.#u.neededDirection(e);t!==null&&(this.#u.by==="page"?this.#r?.setOrder(dn(this.means,t)):this.#a?.postMessage({forward:t}))}},Sn=s=>s instanceof Error?s.message:String(s);Pt();p();var Z0=16.666666666666668,J0=1e3/50,ef=1e3/45,ka=1e3/26,tf=3,nf=200,sf=.9,_a=[4,64],of=[1,.85,.7,.6,.5],ht=class{#e=0;#t=[];#o;#s=ef;#n={step:0,median:1/0};#i=0;#r=_a[0];constructor(e){this.fixed=e,this.#o=e===null?of:[e]}get scale(){return this.#o[this.#e]}reduced(e){return(e?this.scale:this.#o[0])<1}size(e,t,n,o){let r=Math.min(n,2)*(o?this.scale:this.#o[0]),i=a=>Math.max(1,Math.round(a*r));return{width:i(e),height:i(t)}}note(e){this.#t.push(e);let{length:t}=this.#t;if(t<tf||this.#t.reduce((o,r)=>o+r)<nf)return;let n=this.#t.sort((o,r)=>o-r)[t>>1];this.#t=[],n>this.#s?this.#a(n):n>=J0||this.#e===0?this.#i=0:++this.#i>=this.#r&&(this.#e-=1,this.#i=0)}#a(e){let{step:t,median:n}=this.#n;if(this.#i=0,this.#r=Math.min(2*this.#r,_a[1]),t<this.#e&&e<ka&&e>sf*n){this.#e=t,this.#s=ka;return}this.#n={step:this.#e,median:e};let o=this.scale*Math.sqrt(Z0/e),r=this.#o.findIndex(i=>i<this.scale&&i<=o);this.#e=r<0?this.#o.length-1:r}};p();function Aa({fx:s,fy:e,width:t,height:n},o){if(o.length===0)return 1;let r=Math.sqrt(o[0].K[0]*o[0].K[4]),i=Math.min(4,Math.floor(4096/Math.max(t,n)));return Math.max(1,Math.min(Math.floor(r/Math.sqrt(s*e)+.5),i))}we();B();var rf=100,Sa=150,af=6,cf=.2,lf=9*Math.PI/180,Mn=class{pose=new D([0,0,-3],[0,0,0],[0,-1,0]);fov=null;timed=!1;turning=!1;measured=!1;session=null;#e;#t;#o;#s;#n;#i=null;#r="auto";#a=null;#c=null;#l={};#f;#h;#p=this.pose;#d=!1;#m=!0;#g=null;#E={way:1,speed:1,excess:0};#b="orbit";#v=null;#u=0;#k=0;#_=-1/0;#x=!1;#y=0;#S=0;#R;constructor(e,t,{variant:n=null,levels:o=null,editable:r=!1,patient:i=!1}={}){this.#t=e,this.#e=t,this.#o=n,this.#s=o,this.#f=new ht(null),this.#n=this.#U(e,0,!1),this.#n.editable=r,this.#n.patient=i,this.#h=new hn(e,{pose:()=>this.pose,mode:()=>this.mode,held:()=>this.turning=!1,changed:()=>{this.#_=performance.now(),this.turning=this.#m=!1,this.#g&&oi(this.pose,this.#g,this.mode),this.redraw()},focus:(a,c)=>this.#T(a,c)}),this.#R=new ResizeObserver(()=>{this.count&&(this.#m?this.#N():this.#M()),this.redraw()}),this.#R.observe(e)}begin(e){return this.#r=e,this.#n.begin(e)}load(e){this.#n.request&&(this.#d=!1,this.#c=null),this.#n.load(e)}async compare(e,t,n){this.endComparison();let o=this.#U(e,1,n);o.background=this.#a,this.#i=o,await this.#n.calibrated,o===this.#i&&await o.begin(this.#r)&&o===this.#i&&o.load(t)}endComparison(){this.#i?.destroy(),this.#i=null}redraw(){!this.#u&&!this.measured&&!this.session&&(this.#u=requestAnimationFrame(e=>this.#C(e)))}reset(e){let{views:t}=this;if(this.#m=e===void 0||t.length===0,this.#m)this.#N();else{let n=e%t.length;this.pose=D.fromViews(t,(n+t.length)%t.length,this.#z)}this.redraw()}#N(){this.#M(),this.pose=this.#p.copy()}#M(){this.#p=this.#O();let{clientWidth:e,clientHeight:t}=this.#t;this.#g=this.#c===null?ni(this.notes,e,t):null}get up(){return this.#c}set up(e){let t=e!==null&&Ge.has(e)?e:null;t!==this.#c&&(this.#c=t,this.#n.count&&this.reset())}turnUp(){let{views:e}=this,t=this.#n.up??(e.length?D.fromViews(e).up:se);return this.up=vo(this.#c,t),this.#c??""}place(e){this.pose=e,e.box??=this.#p.box,this.#d=!0,this.#m=!1,this.redraw()}get mode(){return this.#b}set mode(e){this.#b=e;let t=e==="walk"?Vt(this.notes.floor):null,n=t?this.#p.eye:this.pose.eye,o=t?.normal??this.pose.up;this.#v=e==="walk"?{normal:o,offset:L(n,o)}:null,this.redraw()}stride(e,t){this.#h.stride=[e,t],this.redraw()}camera(e,t){return Nr(this.pose,this.views[0]??null,e,t,this.#n.near,this.fov)}get views(){return this.#n.views.length?this.#n.views:this.#i?.views??[]}get notes(){return{...this.#n.notes,...this.#l}}set given(e){this.#l=e,this.count&&(this.#m?this.reset():this.#M())}get count(){return this.#n.count}get means(){return this.#n.means}hide(e){this.#n.hide(e)}pointAt(e,t){let{clientWidth:n,clientHeight:o}=this.#t,{means:r,logits:i}=this.#n;return Ea(r,i,this.camera(n,o),e,t)}get calibrated(){return this.#n.calibrated}get source(){let{request:e}=this.#n;return e===null||"forward"in e?null:"url"in e?e.url:e.file}get device(){return this.#n.device}get scale(){return this.#f.fixed}set scale(e){this.#f=new ht(e),this.redraw()}get choices(){let{mode:e,fov:t,turning:n,scale:o,timed:r,up:i}=this;return{mode:e,fov:t,turning:n,scale:o,timed:r,up:i,background:this.#a}}get background(){return this.#n.background}set background(e){this.#a=e;for(let t of this.#A)t.background=e;this.redraw()}async drawAndWait(e,t){let n=this.camera(e,t),o=await this.#n.sort(n);if(this.#n.draw(n),await this.finished(),this.#n.broken)throw new Error("the renderer was lost");return o}async finished(){await this.#n.finished()}async passes(){return await this.#n.time(),this.#n.milliseconds}fragments(){return this.#n.countFragments()}pixels(e,t=0){return this.#A[t]?.pixels(e)??Promise.reject(new Error("there is no other scene"))}screenshot(e=1){return new Promise(t=>this.copy(e).toBlob(t,"image/png"))}copy(e=1){let{width:t,height:n}=this.#F(),o=document.createElement("canvas");[o.width,o.height]=[t,n];let r=o.getContext("2d");return this.#A.forEach(({canvas:i},a)=>{let c=a*Math.round(e*t),l=t-c;l>0&&r?.drawImage(i,c,0,l,n,c,0,l,n)}),o}get start(){return this.#p.copy()}async webglView(e,t){let{context:n,request:o}=this.#n;if(n)return{sceneView:this.#n,own:!0};let r=()=>{},i={progress:r,arrived:r,changed:r,ordered:r,loaded:r,failed:t,broken:t},a=this.#o??{floats:!1,strips:!1},c=new ft(document.createElement("canvas"),i,a,!1,this.#s);return c.patient=e,await c.begin("webgl")&&o&&c.load(o),{sceneView:c,own:!1}}destroy(){this.session?.end(),cancelAnimationFrame(this.#u),clearTimeout(this.#S),clearTimeout(this.#y),this.#h.destroy(),this.#R.disconnect();for(let e of this.#A)e.destroy()}get#A(){return this.#i?[this.#n,this.#i]:[this.#n]}#U(e,t,n){let o={progress:r=>this.#e.progress(t,r),arrived:()=>this.#L(t),changed:()=>{this.#y||=setTimeout(()=>this.redraw(),rf)},ordered:()=>this.redraw(),loaded:(r,i)=>{this.#e.loaded(t,r,i),this.redraw()},failed:(r,i)=>this.#e.failed(t,r,i),broken:r=>this.#e.broken(t,r)};return new ft(e,o,this.#o,n,this.#s)}#L(e){let{views:t}=this;(e===0||!this.#n.views.length&&this.#_===-1/0)&&(t.length||this.#n.count)&&(this.#M(),this.#d?this.pose.box??=this.#p.box:this.reset()),this.redraw()}#O(){let{views:e}=this;if(this.#c===null){let{clientWidth:t,clientHeight:n}=this.#t,o=si(this.notes,t,n);if(o)return D.fromStart(o,this.#z??(e.length?D.fromViews(e).up:se));if(e.length)return D.fromViews(e,0,this.#z)}return D.around(this.#n.means,this.#z??se)}get#z(){return Ge.get(this.#c??"")??this.#n.up}#C(e){this.#u=0,clearTimeout(this.#y),this.#y=0;let t=e-this.#k;this.#k=e;let n=this.#x,o=this.turning&&this.count>0;this.#x=performance.now()-this.#_<Sa||this.#h.busy||o,this.#x&&n&&this.#f.note(t);let r=Math.min(t,100)/1e3;this.#h.advance(r),o&&this.#$(r);let i=this.#P(r),{width:a,height:c}=this.#F();if(clearTimeout(this.#S),this.#x&&(this.#S=setTimeout(()=>this.redraw(),2*Sa)),this.count&&!this.#n.broken){let{name:f,count:h,milliseconds:d,fragments:m}=this.#n,u=this.#x&&n?t:0,g=this.#i?.count??0,w=this.#n.patient&&this.#m&&h<cf*this.#n.total;this.#e.drawn({renderer:f,count:h,compared:g,early:w,width:a,height:c,milliseconds:u,passes:d,fragments:m}),this.timed&&this.#n.time()}let l=this.#D(r);(this.#h.busy||o||i||l)&&this.redraw()}#$(e){let t=this.#E;t.speed+=(t.way-t.speed)*(1-Math.exp(-2*e)),this.pose.orbit(lf*e*t.speed,0),this.#m=!1;let n=this.#g?ii(this.pose,this.#g):0;n>t.excess&&t.way*t.speed>0&&(t.way=-t.way),t.excess=n}#D(e){if(!this.#v)return!1;let{normal:t,offset:n}=this.#v,o=L(this.pose.eye,t)-n;if(Math.abs(o)<1e-4*this.pose.reach)return!1;let r=-o*(1-Math.exp(-af*e));return this.pose.eye=y(this.pose.eye,t,r),this.pose.target=y(this.pose.target,t,r),!0}#P(e){return!(this.#g&&this.#_>-1/0&&!this.turning)||this.#h.held?!1:ri(this.pose,this.#g,this.mode,e)}#F(){let{clientWidth:e,clientHeight:t}=this.#t,n=this.#f.size(e,t,devicePixelRatio,this.#x);if(e&&t){let o=this.camera(n.width,n.height),r=this.#f.reduced(this.#x)?1:Aa(o,this.views);for(let i of this.#A)i.drawOrReport(o,r)}return n}#T(e,t){let n=this.pointAt(e,t);n&&this.pose.focus(n),this.redraw()}};var qs=["orbit","fly","walk"],ff=120,Ma=["heading","credit","alt","lang"],hf=["src","compare","annotations","follow"],df=2e3,Ta="sorted",uf={rootMargin:"100%"},Gs=class extends(globalThis.HTMLElement??Object){static observedAttributes=[...hf,...Rs,...Ma];viewer=null;#e;#t;#o;#s=st;#n="en";#i=null;#r=new it;#a=null;#c;#l=!1;#f=!1;#h=new fn;#p=0;#d=Promise.resolve(!1);#m=!1;#g="";#E=null;#b=new AbortController;#v=null;#u={inSight:null,suspend:()=>this.#S(),resume:()=>this.#x()};#k=new IntersectionObserver(([{isIntersecting:e}])=>Ti(this.#u,e));#_=new IntersectionObserver(e=>e.some(t=>t.isIntersecting)&&this.#x(),uf);constructor(){super(),this.#e=this.attachShadow({mode:"open",delegatesFocus:!0}),this.#e.innerHTML=Pi,this.#o=new on(this.#e),this.#t=new sn(this,this.#w("chrome"));for(let o of this.#e.querySelectorAll("button"))o.addEventListener("click",()=>this.act(o.dataset.act??""));Bi(this.#e,o=>this.act(o),()=>this.#w("help").classList.add("typed")),this.#w("settings").addEventListener("input",({target:o})=>{let r=o;r.name==="stats"?this.act("stats"):this.viewer&&ji(r,this.viewer),this.#w("stick").classList.toggle("shown",this.viewer?.mode==="walk")}),this.addEventListener("fullscreenchange",()=>{let o=this.#I("full"),r=document.fullscreenElement?"window":"full";o.innerHTML=pe(r),o.dataset.name=r,cn(this.#e,this.#s)}),Xi(this.#w("stick"),(o,r)=>this.viewer?.stride(o,r)),this.addEventListener("pointerdown",()=>Ri(this.#u)),Hi(this,this.#w("drop"),o=>this.#D(o));let e=this.#$;e.addEventListener("change",()=>{this.#o.show(null),this.#D(e.files),e.value=""});let t=this.#e.querySelector("slot"),n=async()=>{let{Slotted:o}=await ie();new o(this,t,()=>this.viewer)};t.addEventListener("slotchange",()=>{n()},{once:!0})}connectedCallback(){queueMicrotask(()=>{if(!this.isConnected||this.viewer)return;let e=this.getAttribute("poster")?.replace(/[\x22\\\n]/g,encodeURIComponent);e&&(this.style.background=`center / cover no-repeat url("${e}")`),this.clientHeight<=ff&&(this.style.aspectRatio="16 / 10"),this.#k.observe(this),this.getAttribute("loading")==="lazy"?this.#_.observe(this):this.#x()})}#x(e=!1){this.#_.disconnect();let t=Si(this.#u,e);if(this.#w("wake").hidden=t,!t)return void this.#O();this.#R(),this.#v&&this.#y(this.#v)}#y({choices:e,pose:t}){let n=this.viewer;Object.assign(n,e),t&&n.place(t)}#S(){let{viewer:e}=this;if(e){if(e.count){this.#v={choices:e.choices,pose:e.pose};let t=e.copy();t.className="still",this.#w("bar").before(t)}this.#w("wake").hidden=!1,this.#M()}}#R(e=this.getAttribute("renderer")??"auto"){this.#w("chrome").hidden=this.hasAttribute("noui"),this.#I("full").hidden=!document.fullscreenEnabled,this.#I("share").hidden=!Ui(),this.#t.offer(),this.#O();let t=this.#e.querySelector("canvas");this.viewer=new Mn(t,this,Fi(this)),t.classList.toggle("polite",this.hasAttribute("polite"));for(let r of Rs)tn(this,this.viewer,r);this.#d=this.viewer.begin(e),this.#m=!1,this.#g="",this.#N(),this.#d.then(r=>this.#m=!r);let n=this.#a??this.getAttribute("src"),o=this.#c===void 0?this.getAttribute("compare"):this.#c;n&&this.open(n),o&&this.compareWith(o)}disconnectedCallback(){this.#_.disconnect(),this.#k.disconnect(),this.#b.abort(),this.#M(),Mi(this.#u)}get camera(){return this.viewer?en(this.viewer.pose):""}set camera(e){if(!e||e===this.camera)return;let t=Se(e);this.viewer?t&&this.viewer.place(t):this.setAttribute("camera",e)}async flyTo(e,{seconds:t,signal:n}={}){let o=typeof e=="string"?Se(e):e;if(!o)throw new TypeError(`"${e}" is not a camera: write eye=x,y,z&at=x,y,z&up=x,y,z`);let{flyTo:r}=await ie(),{viewer:i}=this;return!i?.count||n?.aborted?!1:(i.turning=!1,r(i,this,o,{seconds:matchMedia(Ls).matches?0:t,signal:n}))}pointAt(e,t){return this.viewer?.count?this.viewer.pointAt(e,t):null}#N(){this.#b.abort(),this.#b=new AbortController,qi(this,this.#b.signal,(e,t)=>{this.#E=t,this.viewer?.place(e)})}#M(){this.viewer?.destroy(),this.viewer=null,this.#B(),this.#r=new it;let e=this.#e.querySelector("canvas");e?.classList.remove("drawn"),e?.replaceWith(e.cloneNode())}attributeChangedCallback(e,t,n){if(e==="src"&&(this.#a=null),e==="compare"&&(this.#c=void 0),!(!this.viewer||n===t)){if(Ma.includes(e)){this.#O();return}e==="compare"?this.compareWith(n||null):e==="annotations"?this.#A(!1):e==="follow"?this.#N():e==="camera"?this.camera=n??"":e!=="src"?tn(this,this.viewer,e):n&&this.open(n)}}async open(e){this.#a=e,this.#f=this.#l,await this.#F(0,e,(t,n)=>{t.load(n),tn(this,t,"up")})}async compareWith(e){this.#c=e,this.#f=!1,this.#l=e===Ta;let t=this.#l?this.#a:e;this.viewer?.endComparison(),this.#B(),this.#r.begin(1),this.#T(),t!==null&&await this.#F(1,t,(n,o)=>{this.#B();let r=document.createElement("canvas");r.className="over",r.setAttribute("aria-hidden","true"),this.#w("split").before(r),this.#i=new ln(this.#w("split"),r),n.compare(r,o,this.#l)})}act(e){let t=this.viewer;if(e==="wake"&&this.#x(!0),!!t){if(e==="reset"||e==="view")t.turning=!1,t.reset(e==="view"?++this.#p:void 0);else if(e==="help"||e==="settings")this.#o.show(e);else if(e==="stats")t.timed=this.#o.toggle("stats");else if(e==="own")t.background=null;else if(e==="up"){let n=t.turnUp();this.#L(n?Te(this.#s.axis,n):this.#s.ownAxis,!0)}else if(e==="mode"){let n=qs[(qs.indexOf(t.mode)+1)%qs.length];t.mode=n,this.#L(this.#s[{orbit:"orbits",fly:"flies",walk:"walks"}[n]],!0)}else e==="vr"||e==="ar"?this.#t.present(e,t)?.catch(({message:n})=>this.#L(n,!0)):e==="picture"?this.#P():e==="open"?this.#$.click():e==="copy"?this.#o.copy(this.#s):e==="share"?this.#o.share(this.#s):e==="send"?this.#o.send():e==="retry"?this.#C():e==="full"?document.fullscreenElement?document.exitFullscreen():this.requestFullscreen?.().catch(()=>{}):e==="close"&&(this.#w("message").hidden=!0,this.#o.show(null));this.#w("stick").classList.toggle("shown",t.mode==="walk"),Wi(this.#w("settings"),t,!this.#w("stats").hidden,this.#s),t.redraw()}}progress(e,t){this.#r.note(e,{share:t,state:"loading"}),this.#T()}loaded(e,t,n){this.#r.note(e,{share:1,state:"loaded"}),this.#T(),e!==1&&(this.#f&&this.compareWith(Ta),this.#L(Te(this.#s.loaded,(this.viewer?.count??0).toLocaleString(this.#n))),this.dispatchEvent(new CustomEvent("load",{detail:{milliseconds:t,bytes:n}})),this.#A(this.hasAttribute("autoplay")))}async#A(e){let{viewer:t}=this;this.#e.querySelector(".annotations")?.remove();let n=["annotations","path"].some(r=>t?.notes[r]||this.hasAttribute(r));if(!t||!n||this.hasAttribute("editable"))return;let{showNotes:o}=await ie();t===this.viewer&&o(this,this.#e,t,e)}failed(e,t,n=!1){this.#r.fail(e,t,n),e===0&&(this.#f=!1),this.#T();let o=this.#w("message");o.hidden=!1,e===0&&(this.#a=this.viewer?.source??this.#a);let{viewer:r}=this,i=!!r?.count,a=o.querySelector("h2");a.hidden=i,a.dataset.text=navigator.onLine?"failed":"offline",cn(o,this.#s),this.#I("open",o).hidden=i,this.#I("retry",o).hidden=i||typeof this.#a!="string"||!r?.device.renderer,this.dispatchEvent(new CustomEvent("error",{detail:{sentence:t}}))}broken(e,t){let n=this.viewer;if(!n||n.device.renderer==="WebGL2"||this.getAttribute("renderer")==="webgpu"){this.failed(e,t);return}console.warn(`WebGL2 takes over: ${t}`),this.#M(),this.#R("webgl"),this.#y({choices:n.choices,pose:n.count?n.pose:null})}async report(e){let{showReport:t}=await ie();t(this,this.#e,this.#o,e)}drawn(e){e.early||this.#e.querySelector("canvas")?.classList.add("drawn"),this.#e.querySelector(".still")?.remove(),this.#v=null,e.compared&&this.#w("split").hidden&&this.#i?.show(this.#r.names,this.#s.compared),this.#z(),this.viewer?.measured||this.#t.invite(this.#a),this.dispatchEvent(new CustomEvent("frame",{detail:e})),this.#U();let t=this.#w("stats");t.hidden||(t.textContent=this.#h.lines(e))}#U(){let{viewer:e,camera:t}=this;if(!e||t===this.#g)return;this.#g=t;let{eye:n,target:o,up:r}=e.pose,i={camera:t,eye:n,target:o,up:r,origin:this.#E??this};this.#E=null,this.dispatchEvent(new CustomEvent("camera",{detail:i,bubbles:!0}))}#L(e,t=!1){let n=this.#w("said");n.textContent=e,n.classList.toggle("seen",t),setTimeout(()=>n.classList.remove("seen"),df)}async#O(){this.#n=Gi(this),this.#s=await Vi(this.#n),cn(this.#e,this.#s),this.#e.querySelector("canvas")?.setAttribute("aria-label",`${this.getAttribute("alt")??this.#s.scene}. ${this.#s.keysHint}`),this.#z()}#z(){let{title:e="",credit:t=""}=this.viewer?.notes??{};this.#t.setTitle(this.getAttribute("heading")??String(e??""),this.getAttribute("credit")??String(t??""))}#C(){this.#a!==null&&(this.#w("message").hidden=!0,this.open(this.#a))}get#$(){return this.#e.querySelector("[type=file]")}#D(e){let[t,n]=e??[];t&&this.open(t),n&&this.compareWith(n)}async#P(){let e=await this.viewer?.screenshot(this.#i?.share);if(!e)return;let t=document.createElement("a");Object.assign(t,{href:URL.createObjectURL(e),download:"scene.png"}).click(),setTimeout(()=>URL.revokeObjectURL(t.href),1e3)}async#F(e,t,n){let o=this.viewer;if(o===null||this.#m)return;let r=this.#c;if(e===1&&(!await this.#d||o!==this.viewer||r!==this.#c))return;let i=typeof t=="string"?t.replace(/[?#].*$/,""):"scene",a=t instanceof File?t.name:i;this.#r.begin(e,e===1&&this.#l?`${a}, sorted`:a),this.#T();try{let c=t instanceof Blob?{file:t}:{url:new URL(t,document.baseURI).href};n(o,c)}catch(c){this.failed(e,`the scene cannot be opened: ${c.message}`)}}#T(){let{state:e,busy:t,share:n,sentence:o,names:r}=this.#r,i=this.#w("bar");i.hidden=!t,i.classList.toggle("unknown",Number.isNaN(n));let a=Math.min(100,Math.round(100*n))||0;i.setAttribute("aria-valuenow",String(a)),i.firstElementChild.style.width=`${a}%`;let c=this.#w("message"),l=c.querySelector("p");l.textContent!==o&&(l.textContent=o),o||(c.hidden=!0),this.#w("split").hidden||this.#i?.show(r,this.#s.compared),e&&(this.dataset.state=e)}#B(){this.#w("split").hidden=!0,this.#e.querySelector(".over")?.remove(),this.#i=null}#I(e,t=this.#e){return t.querySelector(`[data-act=${e}]`)}#w(e){return this.#e.querySelector(`.${e}`)}};globalThis.customElements?.get("mobile-gs")||globalThis.customElements?.define("mobile-gs",Gs);p();p();p();ve();te();_t();var pf=80;function Ra(s){let e=0;for(let{count:t,size:n,length:o}of s.values())e+=t*n*o;return e}function La(s,e){let t=0,n=new Map;for(let[o,{count:r,size:i,length:a}]of e){let c=()=>s.subarray(t,t+=i*a);n.set(o,{length:a,books:Array.from({length:r},c)})}if(n.get("scale")?.books.some(o=>o.some(r=>r>pf)))throw new _("the codebooks of the .mgs file hold scales that are out of range");return n}function Oa(s){return new Map([...s].map(([e,{step:t,columns:n}])=>{let o=n.map(({least:r,size:i})=>Float32Array.from({length:i},(a,c)=>(r+c)*t));return[e,{length:1,books:o,middles:n.map(({least:r,middle:i})=>i-r)}]}))}function za({name:s,codec:e,data:t},n,o){if(e==="rans")return ye(t,n,o);let r=32-Math.clz32(o-1),i=Ne(t,r*n),a=new Uint16Array(n);for(let c=0;c<n;c++){let l=i.take(r);if(l>=o)throw new _(`the stream '${s}' points outside of its codebook`);a[c]=l}return a}function dt({length:s,books:e,middles:t}){let n=new Uint16Array(k);return{length:s,books:e.map((o,r)=>t?o.subarray(t[r],t[r]+1):mf(o,s)),columns:e.map(()=>n)}}function mf(s,e){let t=new Float64Array(e);for(let n=0;n<s.length;n++)t[n%e]+=s[n]*e/s.length;return Float32Array.from(t)}function X({length:s,books:e,columns:t},n,o,r,i){for(let a=0;a<e.length;a++){let c=e[a],l=t[a],f=a*s*o;if(s===1){for(let h=r;h<i;h++)n[f++]=c[l[h]];continue}for(let h=0;h<s;h++,f=(a*s+h)*o)for(let d=r;d<i;d++)n[f++]=c[l[d]*s+h]}}te();fe();p();ve();var gf=[53,210,405,600,787,970,1151,1329],wf=Uint8Array.from({length:1330},(s,e)=>gf.filter(t=>t<=e).length),Vs=Float64Array.from({length:512},(s,e)=>(e+.5)/2**(31-Math.clz32(e))-1.5),bf=2.5,Ws=(s,e)=>wf[Math.min(256*Math.abs(Math.fround(s-e)),1329)|0];function Fa(s,e,t){let[n,o,r]=t,i=n.length,a=[new Uint16Array(i),new Uint16Array(i),new Uint16Array(i)],[c,l,f]=a,[h,d,m]=e,u=new be(s),g=0;for(let w=0;w<i;w++){let v=h[n[w]],E=d[o[w]],x=m[r[w]],A=Ws(E,x),M=Ws(v,x),R=Ws(v,E),$=u.take(A+M+R);c[w]=1<<A|$&(1<<A)-1,l[w]=1<<M|$>>>A&(1<<M)-1,f[w]=1<<R|$>>>A+M,g+=A+M+R}return Ne(s,g),a}function Na({step:s,columns:[{least:e},{least:t},{least:n}]},o,r,i,a){let[c,l,f,h,d,m]=o;for(let u=r,g=0;u<i;u++,g++){let w=s*(c[u]+e+Vs[h[u]]),v=s*(l[u]+t+Vs[d[u]]),E=s*(f[u]+n+Vs[m[u]]),x=(w*w+v*v+E*E)/4,A=1+x*(-1/2+x*(1/24+x*(-1/720+x*(1/40320+x*(-1/3628800+x*(1/479001600-x/87178291200)))))),M=1/2+x*(-1/12+x*(1/240+x*(-1/10080+x*(1/725760+x*(-1/79833600+x/12454041600)))));if(x>bf){let R=Math.sqrt(x);A=Math.cos(R),M=Math.sin(R)/(2*R)}a[g]=A,a[g+k]=M*w,a[g+2*k]=M*v,a[g+3*k]=M*E}}Hn();var vf=256,Ua=["raw","halves","planes"],xf=["bits","rans"],Ia=[["scale","rotation"],["appearance","opacity"],["lobes"]],Xs=Ia.length,ut=2,js=class{positions=null;columns=new Map;#e;constructor(e,t){this.#e=e,this.count=t}get stage(){let e=Ia.findIndex(t=>!t.every(n=>this.#t(n)));return e<0?Xs:e}rows(e,t,n="slice"){let o=[...this.columns].filter(([i])=>this.#t(i)).map(([i,a])=>[i,a.map(c=>c[n](e,t))]);return{positions:this.positions[n](3*e,3*t),columns:Object.fromEntries(o)}}#t(e){let{cuts:t,scalars:n}=this.#e,o=n.size&&e==="rotation"?3:0,r=(t.get(e)?.count??n.get(e)?.columns.length??0)+o;return Object.keys(this.columns.get(e)??[]).length===r}},Tn=class{levels;network=null;#e;#t;#o=new Map;#s=new Map;#n=new Map;#i={};#r={};constructor(e,t){this.#e=e,this.#t=t;let{network:n,lobes:o,cuts:r,scalars:i,lodSizes:a}=e;n&&this.#l("view-network",oo,f=>this.network=f),o&&this.#l("lobe-decoder",ro(o),f=>this.#i=f),this.#l(...so(e),f=>this.#r=f),i.size?this.#n=Oa(i):this.#c("codebooks",Ua,[],f=>{this.#n=La(Jn(f,Ra(r)),r)});let c=[...this.#o.keys()],l=0;this.levels=a.map((f,h)=>(l+=f,this.#a(f,h?`@${h}`:"",c,l)))}#a(e,t,n,o){let{cuts:r,scalars:i}=this.#e,a=new js(this.#e,e),[c,...l]=["positions","scale.0","scale.1","scale.2"].map(d=>d+t),f=(d,m)=>{let u=[];a.columns.set(d,u);for(let[g,w]of m.entries())this.#c(`${d}.${g}${t}`,xf,[c],v=>{u[g]=za(v,e,w)})},h=({data:d})=>{a.positions=Qi(d,e)};this.#c(c,["morton-class"],n,h,o);for(let[d,{count:m,size:u}]of r)f(d,Array(m).fill(u));for(let[d,{columns:m}]of i)f(d,m.map(({size:u})=>u));if(i.size){let[d,m]=["scale","rotation"].map(u=>a.columns.get(u)??[]);this.#c(`rotation-finer${t}`,["bits"],[c,...l],({data:u})=>{let{books:g}=this.#n.get("scale");Fa(u,g,d).forEach((w,v)=>m[3+v]=w)})}return a}accept(e){this.#o.has(e.name)&&this.#s.set(e.name,e)}step(e){for(let[t,{after:n,minBytes:o,read:r}]of this.#o){let i=this.#s.get(t);if(!(i===void 0||e<o||n.some(a=>this.#o.has(a))))return r(i),this.#o.delete(t),this.#s.delete(t),!0}return!1}get decoderInputs(){let[{count:e,positions:t}]=this.levels,n=t,o=Math.min(e,vf),r=new Uint16Array(3*o).map((c,l)=>n[3*Math.floor(Math.floor(l/3)*e/o)+l%3]),[i,a]=[this.#e,this.#n];return{header:i,books:a,appearance:this.#r,lobes:this.#i,samples:r}}#c(e,t,n,o,r=0){let i=this.#t.find(a=>a.name===e);if(i===void 0)throw new _(`the .mgs file lacks its stream '${e}'`);if(!t.includes(i.codec))throw new _(`the stream '${e}' of the .mgs file uses the codec '${i.codec}', which this program does not know`);this.#o.set(e,{after:n,minBytes:r,read:o})}#l(e,t,n){this.#c(e,Ua,[],o=>n(ao(Jn(o,io(t)),t)))}};p();p();ve();p();var q=new Int32Array(2048);for(let s=0;s<q.length;s++){let e=s<256?s:q[s-256];for(let t=0;t<8;t++)e=(e&1?3988292384:0)^e>>>1;q[s]=e}function Rn(s,e=0){let t=~e,n=0;for(;n+8<=s.length;n+=8)t^=s[n]|s[n+1]<<8|s[n+2]<<16|s[n+3]<<24,t=q[1792+(t&255)]^q[1536+(t>>>8&255)]^q[1280+(t>>>16&255)]^q[1024+(t>>>24)]^q[768+s[n+4]]^q[512+s[n+5]]^q[256+s[n+6]]^q[s[n+7]];for(;n<s.length;n++)t=q[(t^s[n])&255]^t>>>8;return~t>>>0}te();ze();var De=[77,71,83,26,13,10,0,1],Ks=[2,3,4],Ln=20,yf=2**20,Ef=256,kf=2**32,_f=[["ply","a PLY scene: train or compress it first"],["PK","a zip archive (perhaps .sog)"],["\x8B","a gzip file (perhaps .spz)"],["NGSP","an .spz scene"],["glTF","a binary glTF file"],["\xFD7zXZ","an xz file (perhaps another program's comp.xz)"],["\x89PNG","a PNG picture"],["\xFF\xD8\xFF","a JPEG picture"],["<","a web page"],["{","a JSON text"]],On=class{received=0;total=1/0;fields=null;table=[];#e=[];#t=0;#o=0;#s=!1;#n=null;append(e){if(e.length>0&&this.#e.push(e),this.received+=e.length,this.#t+=e.length,!this.#i())return[];if(this.received>this.total)throw new _(`the .mgs file has ${this.received-this.total} bytes too many at its end`);let t=[];for(let n;(n=this.table[this.#o])&&Ys(n.bytes)<=this.#t;)this.#o++,t.push(Af(n,this.#a(Ys(n.bytes))));return t}end(){if(this.fields!==null){let t=this.table[this.#o];if(t===void 0)return;throw new _(`the .mgs file ends inside its stream '${t.name}': it has been cut short`)}if(!this.#s)throw new _(Ca(this.#a(this.#t)));let e=this.#n===null?"first bytes":"header";throw new _(`the .mgs file ends inside its ${e}: it has been cut short`)}#i(){if(!this.#s&&this.#t>=De.length){let e=this.#a(De.length);if(De.some((t,n)=>t!==e[n]))throw new _(Ca(e));this.#s=!0}if(this.#s&&this.#n===null&&this.#t>=Ln-De.length&&(this.#n=this.#a(Ln-De.length)),this.#n!==null&&this.fields===null){let e=Sf(this.#n);this.#t>=e&&this.#r(this.#n,this.#a(e))}return this.fields!==null}#r(e,t){let n=Y(e).getUint32(8,!0);if((Ln+t.length)%8||Rn(t,Rn(e.subarray(0,8)))!==n)throw new _("the header of the .mgs file is damaged (wrong checksum)");this.fields=Mf(t);let o=Y(e).getUint16(0,!0);if((o===2||o===4&&this.fields.layers===void 0)&&(this.fields.layers=[this.fields.count]),o<4&&(this.fields.footprint=le),this.table=Tf(this.fields.streams),this.total=this.table.reduce((r,i)=>r+Ys(i.bytes),Ln+t.length),this.total>kf)throw new _(`the .mgs file claims ${this.total} bytes, too many for a scene`)}#a(e){this.#t-=e;let t=this.#e[0];if(t!==void 0&&t.length>e)return this.#e[0]=t.subarray(e),t.subarray(0,e);let n=new Uint8Array(e),o=0,r=0;for(;o<e;){let i=this.#e[r],a=i.subarray(0,e-o);n.set(a,o),o+=a.length,a.length<i.length?this.#e[r]=i.subarray(a.length):r++}return this.#e.splice(0,r),n}};function Ys(s){return Math.ceil(s/8)*8}function Af(s,e){let t=e.subarray(0,s.bytes);if(Rn(t)!==s.crc32)throw new _(`the stream '${s.name}' of the .mgs file is damaged (wrong checksum)`);if(e.subarray(s.bytes).some(n=>n!==0))throw new _(`the .mgs file is damaged after its stream '${s.name}'`);return{name:s.name,codec:s.codec,data:t}}function Sf(s){let e=Y(s),t=e.getUint16(0,!0),n=e.getUint32(4,!0);if(!Ks.includes(t))throw new _(`the .mgs file is of version ${t}.${e.getUint16(2,!0)}, this program reads ${Ks[0]}.x to ${Ks[2]}.x: reload the page, or write the file again with this version of mobilegs`);if(n>yf)throw new _(`the header of the .mgs file claims ${n} bytes: it is damaged`);return n}function Mf(s){let e;try{e=JSON.parse(new TextDecoder("utf-8",{fatal:!0,ignoreBOM:!0}).decode(s))}catch{throw new _("the header of the .mgs file is not valid JSON")}if(typeof e!="object"||e===null||Array.isArray(e))throw new _("the header of the .mgs file is not a JSON object");return e}function Tf(s){if(!Array.isArray(s)||s.length>Ef)throw new _("the header of the .mgs file lacks a table of streams");let e=new Set;return s.map(t=>{let{name:n,codec:o,bytes:r,crc32:i}=Object(t);if(!([n,o].every(c=>gt(c,64))&&[r,i].every(c=>Number.isInteger(c)&&c>=0&&c<2**40)))throw new _("the header of the .mgs file has a broken table of streams");if(e.has(n))throw new _(`the .mgs file has two streams called '${n}'`);return e.add(n),{name:n,codec:o,bytes:r,crc32:i}})}function Ca(s){if(s.length===0)return"the file is empty, not a .mgs scene";if(De.findIndex((o,r)=>o!==s[r])>=Math.min(3,s.length))return"the first bytes of the .mgs file are damaged: transfer it again, in binary mode";let t=String.fromCharCode(...s),n=_f.find(([o])=>t.startsWith(o));return n?`this is not a .mgs scene but looks like ${n[1]}`:"this is not a .mgs scene"}ze();var Qs=class{header=null;decoder=null;#e=new On;get received(){return this.#e.received}get total(){return this.#e.total}append(e){let t=this.#e.append(e),{fields:n,table:o,total:r}=this.#e;n!==null&&this.decoder===null&&(this.header=po(n,r),this.decoder=new Tn(this.header,o));for(let i of t)this.decoder?.accept(i)}end(){this.#e.end()}step(){return this.decoder?.step(this.received)??!1}};async function $a(s,e){let t=new Qs,n=s.getReader();try{for(let o=0;;){o-=performance.now();let{value:r,done:i}=await n.read();if(o+=performance.now(),i)break;t.append(r);do await e(t,o);while(t.step())}}catch(o){throw await n.cancel().catch(()=>{}),o}return t.end(),t}p();p();fe();var to=16,Zs=6*to,J=64,zn=13,Js=.01,eo=6,Da=15,{fround:G,sqrt:Rf}=Math,Fn=class{#e;#t;#o;#s;constructor(e,t,{static2:n,view2:o}){let r=3+o.length/9,i=new Float32Array(12*r);for(let a=0;a<12;a++){let c=a<3?n.subarray(3*a,3*a+3):o.subarray((a-3)*(r-3));i.set(c.subarray(0,r-3),a*r+(a<3?0:3))}this.#e=e,this.#t=e.block(r),this.#o=e.layer(i,r),this.#s=t}decode(e,t,n){X(t,this.#t.numbers,k,n,n+e.length/3),this.#e.apply(this.#o,this.#t,this.#s,1)}},Nn=class{#e;#t;#o;#s;#n;#i;#r;constructor(e,t,{both1:n,static2:o,view2:r}){this.#e=e,this.#t=[e.layer(n,eo),e.layer(o,J),e.layer(r,J)],this.#o=e.block(eo),this.#s=e.block(2*J),this.#n=[e.part(this.#s,0,J),e.part(this.#s,J,J)],this.#i=t,this.#r=e.part(t,3,12)}decode(e,t,n){let o=this.#e,[r,i,a]=this.#t;X(t,this.#o.numbers,k,n,n+e.length/3),o.apply(r,this.#o,this.#s,Js),o.apply(i,this.#n[0],this.#i,1),o.apply(a,this.#n[1],this.#r,1)}},Un=class{#e;#t;#o;#s;#n;#i;#r;#a;#c;#l;constructor(e,t,{context1:n,context2:o,static1:r,static2:i,view1:a,view2:c},l){this.#e=e,this.#t=[e.layer(n,Zs),e.layer(o,J),e.layer(r,zn+3),e.layer(i,J),e.layer(a,zn+3),e.layer(c,J)],this.#l=2**l,this.#o=e.block(eo),this.#s=e.block(Zs),this.#n=e.block(J),this.#i=e.block(zn+3),this.#r=e.part(this.#i,zn,3),this.#a=t,this.#c=e.part(t,3,12)}decode(e,t,n){let o=this.#e,[r,i,a,c,l,f]=this.#t,[h,d]=[this.#o.numbers,this.#r.numbers],[m,u,g]=[this.#s,this.#n,this.#i];this.#h(e,m.numbers),o.apply(r,m,u,0),o.apply(i,u,g,1),X(t,h,k,n,n+e.length/3),d.set(h.subarray(0,3*k)),o.apply(a,g,u,Js),o.apply(c,u,this.#a,1),d.set(h.subarray(3*k)),o.apply(l,g,u,Js),o.apply(f,u,this.#c,1)}#f(e,t){let n=H(e[t])*this.#l,o=H(e[t+1])*this.#l,r=H(e[t+2])*this.#l,i=G(G(G(n*n)+G(o*o))+G(r*r));return Math.max(1,G(Rf(i)))}#h(e,t){for(let n=0,o=0;o<e.length;n++,o+=3){let r=this.#f(e,o),i=G(2-G(1/r));for(let a=0;a<3;a++){let c=H(e[o+a])*this.#l,l=G(i*G(c/r));Lf(l,t,a*to*k+n)}}}};function Lf(s,e,t){let n=G(G(s*.25)+.5),o=Math.sin(Math.PI*n),r=Math.cos(Math.PI*n);for(let i=t+to*k;t<i;t+=k){e[t]=o,e[t+Zs/2*k]=r;let a=2*o*r;r=1-2*o*o,o=a}}p();Pn();var Cn=.28209479177387814,In=class{#e;#t;#o;#s;#n;#i;#r;constructor(e,t,n,{degree:o,latents:r,hidden:i},a){let c=2*(o+1)**2,l=i.at(-1)??0,f=[19+r,...i];this.#e=e,this.#o=n,this.#t=i.map((u,g)=>e.layer(a[`weights.${g}`],f[g],a[`offsets.${g}`]));let h=a[`weights.${i.length}`],d=Of(h,l,a.basis,r,c);this.#t.push(e.layer(d,l+r,a.bias)),this.#s=e.block(r);let m=i.length?[19,...i]:[0];this.#n=m.map(u=>e.block(Math.ceil(u/4)*4+r)),this.#i=[0,m.length-1].map(u=>e.part(this.#n[u],m[u],r)),this.#r=i.length?new Oe(e,t,this.#n[0]):null}decode(e,t,n){let[o,r,i]=[this.#e,this.#n,this.#t.length-1];this.#r?.write(),e&&X(e,this.#s.numbers,k,t,n),this.#i[0].numbers.set(this.#s.numbers);for(let a=0;a<i;a++)o.apply(this.#t[a],r[a],r[a+1],0);this.#i[1].numbers.set(this.#s.numbers),o.apply(this.#t[i],r[i],this.#o,1)}};function Of(s,e,t,n,o){let r=e+n,i=new Float32Array(o*r);for(let a=0;a<o;a++){for(let c=0;c<e;c++)i[a*r+c]=s[a*e+c];for(let c=0;c<n;c++)i[a*r+e+c]=t[c*o+a]}return i}Pn();p();function pt(s,e){for(let t=0;t<e.length;t++)s.fill(e[t],t*k,(t+1)*k)}var zf=1/3,Ff=[1,0,0,0],Pe=class{#e;#t=new xn;#o;#s;#n;#i;#r;#a;#c;#l;#f;constructor(e){let{header:t,samples:n}=e,{lobes:o,grid:r}=t,i=this.#t;this.#e=e;let a=o?.degree??0,c=i.block(Da),l={logScales:i.block(3),scales:i.block(3),quats:i.block(4),sh:i.part(c,0,12),lobes:i.block(2*(a+1)**2+2),statics:i.block(t.network?19:0),words:i.block(18)};this.#o=l.quats,this.#n=o&&new In(i,l,l.lobes,o,e.lobes),this.#i=t.network?new Oe(i,l,l.statics):null;let{appearance:f}=e;t.colors==="linear"?this.#s=new Fn(i,c,f):t.colors==="latent_networks"?this.#s=new Nn(i,c,f):this.#s=new Un(i,c,f,r.exponent),i.allocate(),this.#c=Object.fromEntries([...e.books].map(([m,u])=>[m,{...u,columns:[]}])),this.#l=Pa(this.#d("scale")),this.#f=Pa(dt(this.#d("scale")));let h=Object.fromEntries(Object.entries(l).map(([m,{numbers:u}])=>[m,u])),d=Uf(this.#l);this.#r={...h,count:0,lobeDegree:a,scaleRange:d,memory:i.wasmMemory},this.#a={sh:this.#h(n),lobes:[0,1/Cn]},this.#n&&(this.#a.lobes=this.#p(this.#n))}#h(e){let{sh:t}=this.#r,n=new Float64Array(12),o=dt(this.#d("appearance"));for(let r=0;r<e.length;r+=3*k){let i=e.subarray(r,r+3*k);this.#s.decode(i,o,0);for(let a=0;a<12;a++)for(let c=0;3*c<i.length;c++)n[a]+=3*t[a*k+c]/e.length}return n}#p(e){let{scales:t,quats:n,sh:o,lobes:r}=this.#r,i=this.#c.lobes;return X(this.#f,t,k,0,k),pt(n,Ff),pt(o,this.#a.sh),e.decode(i?dt(i):null,0,k),Array.from({length:r.length/k-2},(a,c)=>r[c*k])}decode({positions:e,columns:t},n=0){let{header:o}=this.#e,r=e.subarray(3*n,3*(n+k)),i=r.length/3,a=n+i,[c,l]=[this.#r,this.#c];c.count=i,c.positions=r;let{logScales:f,scales:h,quats:d,sh:m,lobes:u}=c,{scale:g,rotation:w,appearance:v}=t,E=!0;for(let A of Object.keys(l)){let M=t[A];M?this.#d(A).columns=M:E=!1}this.#l.columns=g,X(this.#d("scale"),f,k,n,a),X(this.#l,h,k,n,a);let x=o.scalars.get("rotation");if(x?Na(x,w,n,a,d):(X(this.#d("rotation"),d,k,n,a),this.#t.units(this.#o,this.#o)),v?this.#s.decode(r,this.#d("appearance"),n):pt(m,this.#a.sh),this.#n&&E?this.#n.decode(l.lobes??null,n,a):pt(u,this.#a.lobes),l.opacity){let{books:[A]}=t.opacity?l.opacity:dt(l.opacity),M=t.opacity?.[0];Nf(u,A,M,n,i)}return this.#i?.write(),c}get network(){return this.#i!==null}get lobeDegree(){return this.#r.lobeDegree}get scaleRange(){return this.#r.scaleRange}get neutral(){let e=[0,1,2].map(r=>.5+Cn*this.#a.sh[r]),[t,n,o]=this.#f.books.map(([r])=>r);return{color:e,side:zf*Math.cbrt(t*n*o)}}#d(e){return this.#c[e]}};function Nf(s,e,t,n,o){for(let r=0;r<o;r++)s[r]+=e[t?t[n+r]:0]/Cn}function Pa(s){return{...s,books:s.books.map(e=>e.map(Math.exp))}}function Uf({books:s}){let e=[1/0,-1/0];for(let t of s)for(let n of t)e=[Math.min(e[0],n),Math.max(e[1],n)];return e}re();p();_e();p();var Ba=0;async function $n(){if(performance.now()-Ba<8)return;let{port1:s,port2:e}=new MessageChannel;await new Promise(t=>{s.onmessage=()=>{s.close(),t(null)},e.postMessage(null)}),Ba=performance.now()}var Ha=8192,If=1e5,Cf=3,$f=2,Dn=class{results=[];#e=[];#t;#o=null;#s=null;#n=[];#i;#r=null;#a;#c;#l=!1;#f=!1;#h=()=>{};#p=()=>{};#d=new Promise((e,t)=>{this.#h=e,this.#p=t});constructor(e){this.#d.catch(()=>{});let t=0;for(let[n,o]of e.entries()){for(let r=0;r<o;r+=Ha)this.#e.push({level:n,from:r,to:Math.min(r+Ha,o),first:t+r});t+=o}this.#t=new Uint8Array(e.length),this.#a=new Uint8Array(this.#e.length),this.#c=this.#a.slice(),this.#i=t}set output(e){if(this.#r=e,e!==null)for(let[t,n]of this.results.splice(0))Ga(n,qa(e,this.#i,t,t+n.shapes.length/4))}spawn(){let{decoderInputs:e}=this.#o,t=this.#i<If?1:navigator.hardwareConcurrency;for(let n=1;n<Math.min(t,Cf+1);n++)this.#m(e)}#m(e){try{let t=ss();t.postMessage({decoderInputs:e});let n={worker:t,jobs:0};t.onmessage=({data:o})=>{n.jobs--,this.#x(o),this.#k(n)},t.onerror=o=>o.preventDefault(),this.#n.push(n)}catch{}}start(e){return this.#o=e,this.#s=new Pe(e.decoderInputs)}advance(e,t){if(!(t<=this.#t[e])){this.#t[e]=t;for(let n of this.#n)this.#k(n);this.#_().catch(this.#p)}}finish(){return this.#f=!0,this.#y(),this.#d}terminate(){for(let{worker:e}of this.#n)e.terminate()}get#g(){return this.#a.findIndex((e,t)=>e<this.#b(t))}get#E(){let e=this.#g;return e<0?this.#c.findIndex((t,n)=>t<this.#b(n)):e}#b(e){return this.#t[this.#e[e].level]}#v(e,t){let{levels:n}=this.#o,{level:o,from:r,to:i}=this.#e[e];return n[o].rows(r,i,t)}#u(e){let{first:t,from:n,to:o}=this.#e[e];return this.#r?qa(this.#r,this.#i,t,t+o-n):void 0}#k(e){for(let t;e.jobs<$f&&(t=this.#g)>=0;e.jobs++){let n=this.#a[t]=this.#b(t),o=this.#v(t,"slice"),r=[o.positions,...Object.values(o.columns).flat()].map(({buffer:i})=>i);e.worker.postMessage({rows:o,chunk:t,stage:n},{transfer:r})}}async#_(){if(!this.#l){this.#l=!0;for(let e;(e=this.#E)>=0&&this.#s;){let t=this.#a[e]=this.#b(e),n=En(this.#s,this.#v(e,"subarray"),this.#u(e));this.#x({chunk:e,stage:t,packed:n}),await $n()}this.#l=!1}}#x({chunk:e,stage:t,packed:n}){if(t<=this.#c[e])return;this.#c[e]=t;let o=this.#u(e);o===void 0?this.results.push([this.#e[e].first,n]):o.shapes.buffer!==n.shapes.buffer&&Ga(n,o),this.#y()}get firstLevelReady(){return this.#e.every(({level:e},t)=>e>0||this.#c[t]>0)}get levels(){let e=this.#c.findIndex(t=>t<ut);return e<0?this.#t.length:this.#e[e].level}#y(){this.#f&&this.#E<0&&this.#h()}};function qa(s,e,t,n){let o=r=>{let i=s[r].length/e;return s[r].subarray(i*t,i*n)};return{shapes:o("shapes"),colors:o("colors"),lobes:o("lobes")}}function Ga(s,e){for(let t of Object.keys(e))e[t].set(s[t])}p();async function Va(s,e){if("file"in s)return{source:s.file.stream(),total:s.file.size};let t;try{t=await fetch(s.url,{signal:e})}catch{throw e?.throwIfAborted(),new Error(`${s.url} cannot be reached: is the address right, the network there, and may this site load it (CORS)?`)}if(!t.ok||t.body===null)throw new Error(`${s.url} could not be loaded: the server says ${t.status}`);let n=t.headers.has("Content-Encoding")?NaN:Number(t.headers.get("Content-Length"));return{source:t.body,total:n||NaN}}p();function Wa(s){let e=s.length/3,t=Math.max(1,Math.floor(e/1e4)),n=[0,1,2].map(a=>Float32Array.from({length:Math.ceil(e/t)},(c,l)=>s[3*l*t+a])),o=n.map(a=>a.slice().sort()[a.length-1>>1]),r=n[0].map((a,c)=>Math.max(...n.map((l,f)=>Math.abs(l[c]-o[f])))),i=r.sort()[Math.floor(.9*(r.length-1))];return .2*Math.min(1,Math.max(i,1e-6))}Wn();we();var Df=8192,Pf=2**20,ja=1500,Bf=8,Qa=["shapes","colors","lobes"],Le=new Float32Array(0),ee=(s,e=[])=>self.postMessage(s,{transfer:e}),Za=({shapes:s,colors:e,lobes:t})=>[s.buffer,e.buffer,t.buffer],no=class{#e;#t;#o;#s;#n;#i=0;#r=null;#a=!1;constructor(e,t,n,o,r){this.#e=e,this.#n=r,this.#t=t,this.#o=n,this.#s=o;let i=Array.from(e.background),{color:a,side:c}=o.neutral,l=Is(Zi(t[0].positions,Df),e.grid),f=c*Math.sqrt(3*e.count/l.length),h={means:l,color:a,side:f,background:i};ee({kind:"dots",dots:h,...this.#c},[h.means.buffer])}get#c(){let{views:e,near:t,meta:n}=this.#e;return{views:e,near:t,up:bt(n.up),notes:n}}send(e){if(!this.#o.firstLevelReady||!this.allocate(e))return;let t=this.#o.levels,n=this.#i;this.#i=Math.max(t,1);let o=this.#o.results.splice(0),r=this.#r;if(r){this.#r=this.#o.output=null,ee({kind:"scene",data:r,means:this.#l(),...this.#c},Za(r));return}for(let[i,a]of o)for(let c of Qa){let l=a[c];ee({kind:"rows",part:c,from:i,numbers:l},[l.buffer])}n!==this.#i&&ee({kind:"more",means:this.#l()})}allocate(e){let{count:t}=this.#e;return!this.#a&&Bf*e>=t&&(this.#r=this.#o.output=da(this.#e,t,this.#s.scaleRange,this.#n),this.#a=!0),this.#a}#l(){let e=this.#t.slice(0,this.#i),t=new Uint16Array(e.reduce((r,{count:i})=>r+3*i,0)),n=0;for(let{positions:r,count:i}of e)t.set(r,n),n+=3*i;let o={stored:t,grid:this.#e.grid};return this.#e.sorted&&(Le=pn(o)),o}};async function Hf(s){let e=null,t=null,[n,o]=[0,0],r=[],i=async({header:a,decoder:c,received:l,total:f},h)=>{if(ee({kind:"progress",received:l,total:f}),a===null||c===null)return;o=l,e??=new Dn(a.lodSizes);let d=r=c.levels,m=h*(f/l-1)>ja;d[0].positions&&!t&&(t=new no(a,d,e,e.start(c),c.network),e.spawn(),n=setInterval(()=>t?.send(o),ja)),t?.allocate(l);for(let[u,{stage:g}]of d.entries())t&&(g===Xs||m&&u===0&&g>=ut)&&e.advance(u,g);await $n()};try{await $a(s,i)}finally{for(let[a,{stage:c,positions:l}]of r.entries())t&&l&&c>=ut&&e?.advance(a,c);await e?.finish().finally(()=>{clearInterval(n),e?.terminate()}),t?.send(o)}return o}async function Xa(s,e,t){let[n,o]=[new Uint8Array(e||Pf),0],r=s.getReader();for(let c;!(c=await r.read()).done;){let l=o+c.value.length;if(l>n.length){let f=n;n=new Uint8Array(Math.max(l,2*n.length)),n.set(f)}n.set(c.value,o),o=l,ee({kind:"progress",received:o,total:e})}let i=await t(n.subarray(0,o));if(!i.count)throw new Error("there is no Gaussian in this file that can be drawn");Le=new Float32Array(3*i.count);for(let c=0;c<Le.length;c++)Le[c]=i.shapes[4*c+3];let a={views:[],near:Wa(Le),up:i.up??null,notes:{}};return ee({kind:"scene",data:i,means:Le,...a},Za(i)),o}async function qf(s){let e=s.getReader(),t=()=>e.read().catch(()=>{throw new Error("the file broke off before its end: load it again")}),n=await t(),o=n?.value??new Uint8Array(0),r=new ReadableStream({async pull(i){let{value:a,done:c}=n??await t();n=null,c?i.close():i.enqueue(a)},cancel:()=>e.cancel()});return{first:o,whole:r}}async function Ka(s){let e=performance.now();try{let{source:t,total:n}=await Va(s),{first:o,whole:r}=await qf(t),i;vt(o)?i=await Xa(r,n,(await Ts()).readPly):xo(o)?i=await Xa(r,n,(await Ts()).readSpz):i=await Hf(r),ee({kind:"done",milliseconds:performance.now()-e,bytes:i})}catch(t){let{message:n}=t,o=t instanceof RangeError?`the scene is too large for this device: ${n}`:n;ee({kind:"failed",sentence:o})}}var Ya;function Ja(){self.onmessage=async({data:s})=>{if("decoderInputs"in s){Ya=new Pe(s.decoderInputs);return}if("rows"in s){let{rows:e,chunk:t,stage:n}=s,o=En(Ya,e),r=Qa.map(i=>o[i].buffer);self.postMessage({chunk:t,stage:n,packed:o},{transfer:r});return}if("forward"in s){let e=dn(Le,s.forward);ee({kind:"order",order:e},[e.buffer]);return}await Ka(s)},self.name&&Ka({url:self.name})}p();_e();re();var Gf="renderer variant levels scale noui poster background fov up start start-portrait limits free autorotate autoplay compare heading credit lang".split(" "),Vf=400;function tc(){let s=document.querySelector("mobile-gs"),e=new URLSearchParams(location.search);for(let c of Gf){let l=e.get(c);l!==null&&s.setAttribute(c,l)}s.lang||=navigator.language;let t=e.get("url");t&&s.setAttribute("src",t),setTimeout(()=>{let c=Zo();!t&&c?s.open(c):s.hasAttribute("src")||s.failed(0,"no scene is given: open a .mgs, .ply or .spz file, or add ?url=... to the address"),n(),parent===self&&s.focus({preventScroll:!0})},0);let n=()=>{let c=Se(location.hash);c&&s.viewer?.place(c)};addEventListener("hashchange",n);let o=0,r="",i=()=>s.viewer?en(s.viewer.pose):"";s.addEventListener("frame",()=>{r||=i(),clearTimeout(o),o=setTimeout(()=>{let c=i(),l=r!==""&&c!==r;r=c;try{l&&history.replaceState(null,"",`#${c}`)}catch{}},Vf)});let a=e.get("bench");a!==null&&Wf(s,a,e.getAll("url").slice(1))}async function Wf(s,e,t){let n={width:Math.round(innerWidth*devicePixelRatio),height:Math.round(innerHeight*devicePixelRatio)},o=ec(s),{parsePlan:r,runBench:i}=await ie(),a=r(e,n),c=[],l;for(let f of[null,...t]){f!==null&&(o=ec(s)),f!==null&&s.setAttribute("src",f);let h=await o,{viewer:d}=s;if(!h||!d)return;await d.calibrated,l??=await navigator.wakeLock?.request("screen").catch(()=>null);try{let m=await i(d,a,u=>s.progress(0,u));c.push({scene:s.getAttribute("src")??"own",gaussians:d.count,file_bytes:h.bytes,milliseconds_to_load:Math.round(h.milliseconds),...d.device,...m})}catch(m){l?.release(),s.failed(0,`the frame rate cannot be measured: ${m.message}`);return}s.loaded(0,h.milliseconds,h.bytes)}l?.release(),await s.report({date:new Date().toISOString(),...a,viewer:Qo(),browser:navigator.userAgent,device_pixel_ratio:devicePixelRatio,scenes:c})}function ec(s){return new Promise(e=>{s.addEventListener("load",t=>e(t.detail),{once:!0}),s.addEventListener("error",()=>e(null),{once:!0})})}globalThis.document?document.querySelector("mobile-gs[page]")&&tc():Ja();
})();
