var u=(r,e,t)=>()=>{if(t)throw t[0];try{return r&&(e=r(r=0)),e}catch(n){throw t=[n],n}};var h,i=u(()=>{h={"count.glsl":`out vec4 found;
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
`}});var Z=u(()=>{"use strict";i()});async function U0(r){return h[r]}var J=u(()=>{i();Z()});function y(r,e){let t=[[r,e]];for(let n=1;n<4;n++)t.push(t[n-1].map(s=>(s-(n===1?0:1)>>1)+2));return t}function R(r,e){let[,...t]=y(r,e),n=[[0,0]],s=0;for(let[,o]of t)n.push([r,s]),s+=o;return{places:n,size:[r+t[0][0],Math.max(e,s)]}}var B=u(()=>{"use strict";i()});var T=u(()=>{"use strict";i()});var G=u(()=>{"use strict";i();T()});var e0=u(()=>{"use strict";i()});var t0=u(()=>{"use strict";i();e0()});var n0=u(()=>{"use strict";i();t0()});var I0,Ee,o0=u(()=>{"use strict";i();G();T();n0();I0=14,Ee=1<<I0});var ke,D0,Fe,r0=u(()=>{"use strict";i();G();T();o0();ke=Float64Array.from({length:31},(r,e)=>2**(Math.max(e,1)-25)),D0=new Float32Array(1),Fe=new Uint32Array(D0.buffer)});var s0=u(()=>{"use strict";i()});function f0({packing:r,shSize:e,lobeSize:t,network:n}){return r?{shapes:4,colors:4,lobes:n?10:t+2>>1}:{shapes:12,colors:3*e,lobes:2*t}}var a0=u(()=>{"use strict";i();r0();s0()});var i0=u(()=>{"use strict";i()});var c0=u(()=>{"use strict";i();i0()});var d0,He,je,Ye,C0,Ke,l0=u(()=>{"use strict";i();T();c0();d0=Object.freeze({blur:.3,antialiased:!1,soft_edge:!1}),He=2**26,je=2**14,Ye=2**16,C0=[6,12],Ke=[["scale",3],["rotation",3],["appearance",C0[0]],["opacity",1]]});function $(r,e){let{fx:t,fy:n,cx:s,cy:o,width:f,height:c}=r;return{...r,fx:e*t,fy:e*n,cx:e*s,cy:e*o,width:e*f,height:e*c}}function p0(r,e,t,n,s){let{viewmat:o,fx:f,fy:c,cx:a,cy:d,width:l,height:p,near:b}=e,{background:w,weighting:m,packing:v,footprint:g=d0}=r,_=u0*.5*l/f,F=u0*.5*p/c,A=[0,1,2].map(E=>-(o[E]*o[3]+o[4+E]*o[7]+o[8+E]*o[11])),x=new Float32Array(P/4);x.set([...Array.from(o).slice(0,12),...A,b,f,c,a,d,-a/f-_,(l-a)/f+_,-d/c-F,(p-d)/c+F,...w,m.exponentMax,l,p,m.sigma,m.backgroundWeight,t]);let D=[r.count,r.shSize,r.lobeSize,m.index];if(new Int32Array(x.buffer).set(D,33),v){let{center:E,unit:S,leastScaleBits:M,scaleBitsSpan:O0}=v;x.set([...E,S,M,O0],40)}x[46]=!r.sorted&&m.alphaMin||1/255,x[47]=g.blur,new Int32Array(x.buffer).set([Number(g.antialiased),Number(g.soft_edge&&!r.sorted)],48),x[50]=n,new Int32Array(x.buffer)[51]=s;let L=y(l,p),{places:L0,size:S0}=R(l,p),M0=L0.flatMap(([E,S],M)=>[E,S,E+L[M][0],S+L[M][1]]);return x.set([...M0,...S0],52),x}var P,h0,u0,V=u(()=>{"use strict";i();l0();B();P=288,h0=2**-6,u0=.3});var O,b0=u(()=>{"use strict";i();O=class{milliseconds=null;#e;#r;#n=!1;#t=!1;#o=[];constructor(e){this.#e=e,this.#r=e.getExtension("EXT_disjoint_timer_query_webgl2")}start(){this.#t=this.#n&&!this.#o.length}pass(e){if(!this.#t)return;let[t,n]=[this.#e,this.#r.TIME_ELAPSED_EXT];if(this.#o.length&&t.endQuery(n),e){let s=t.createQuery();this.#o.push([e,s]),t.beginQuery(n,s)}else this.#t=!1}async time(){let e=this.#e;this.#n=this.#r!==null;let t=this.#o[this.#o.length-1];if(!t||this.#t)return;for(let s=0;s<100&&!e.getQueryParameter(t[1],e.QUERY_RESULT_AVAILABLE);s++)await new Promise(o=>setTimeout(o,5));let n=this.#o.map(([s,o])=>[s,e.getQueryParameter(o,e.QUERY_RESULT)/1e6]);e.getParameter(this.#r.GPU_DISJOINT_EXT)||(this.milliseconds=Object.fromEntries(n));for(let[,s]of this.#o.splice(0))e.deleteQuery(s)}forget(){this.#o=[],this.#t=!1}}});function m0({color:r,side:e},{viewmat:t,fx:n,fy:s,cx:o,cy:f,width:c,height:a,near:d}){let[l,p,b]=[0,4,8].map(w=>Array.from(t).slice(w,w+4));return Float32Array.of(...l.map((w,m)=>2*(n*w+o*b[m])/c-b[m]),...p.map((w,m)=>b[m]-2*(s*w+f*b[m])/a),...b,...r,d,s*e/2,.002*a/2,2/c,2/a)}function w0({means:r}){let e=new Float32Array(6*r.length);for(let t=0,n=0;t<r.length;t+=3)for(let s=n+18;n<s;n+=3)e[n]=r[t],e[n+1]=r[t+1],e[n+2]=r[t+2];return e}var g0=u(()=>{"use strict";i()});function k(r){return[Math.max(1,Math.min(r,4096)),Math.max(1,Math.ceil(r/4096))]}var N,U,X=u(()=>{"use strict";i();N=["shapes","colors","lobes","looks","opacities","order","color_sums","weight_sums","color_sums_1","weight_sums_1","color_sums_2","weight_sums_2"],U=class{#e;#r=new Map;constructor(e){this.#e=e}make(e,t,[n,s]){let o=this.#e;o.deleteTexture(this.#r.get(e)??null);let f=o.createTexture();return this.#r.set(e,f),o.activeTexture(o.TEXTURE0+N.indexOf(e)),o.bindTexture(o.TEXTURE_2D,f),o.texStorage2D(o.TEXTURE_2D,1,t,n,s),o.texParameteri(o.TEXTURE_2D,o.TEXTURE_MIN_FILTER,o.NEAREST),o.texParameteri(o.TEXTURE_2D,o.TEXTURE_MAG_FILTER,o.NEAREST),f}upload(e,t,n){let s=this.#e,[o,,f]=t,c=k(n.length/f);if(c[1]>s.getParameter(s.MAX_TEXTURE_SIZE))throw new Error("the scene has more Gaussians than this GPU's textures can hold");this.make(e,s[o],c),this.write(e,t,0,n)}write(e,[,t,n],s,o){let f=this.#e,c=o instanceof Float32Array?f.FLOAT:f.UNSIGNED_INT,a=o.length/n;f.activeTexture(f.TEXTURE0+N.indexOf(e));for(let d=0;d<a;){let[l,p]=[(s+d)%4096,Math.floor((s+d)/4096)],b=Math.min(4096-l,a-d),w=b===4096?Math.floor((a-d)/4096):1,m=d*n;f.texSubImage2D(f.TEXTURE_2D,0,l,p,b,w,f[t],c,o,m),d+=b*w}}destroy(){for(let e of this.#r.values())this.#e.deleteTexture(e)}}});function q(r){return["EXT_color_buffer_float","EXT_float_blend"].every(e=>r.getExtension(e))}function H(r){for(let o of[...W,"EXT_float_blend"])r.getExtension(o);let e=r.getExtension("WEBGL_provoking_vertex");e?.provokingVertexWEBGL(e.FIRST_VERTEX_CONVENTION_WEBGL),r.disable(r.DITHER);let t={view:r.createBuffer(),corners:r.createBuffer(),quads:r.createVertexArray(),looks:r.createFramebuffer(),sums:r.createFramebuffer(),enlarged:[r.createFramebuffer(),r.createFramebuffer()],programs:new Map,counters:new Map,textures:new U(r)};r.bindBufferBase(r.UNIFORM_BUFFER,x0,t.view),r.bufferData(r.UNIFORM_BUFFER,P,r.DYNAMIC_DRAW),r.bindVertexArray(t.quads),r.bindBuffer(r.ELEMENT_ARRAY_BUFFER,t.corners);let n=[0,1,2,2,1,3],s=Array.from({length:z},(o,f)=>n.map(c=>4*f+c));return r.bufferData(r.ELEMENT_ARRAY_BUFFER,Uint16Array.from(s.flat()),r.STATIC_DRAW),t}function E0(r,e,t){let{whole:n,project:s,splat:o,resolve:f}=e,c=t.packed?e.packed:e.wide,a=_0(r,e.view,t);return{project:a(n,`${c}${s}`),splat:a(`${c}${o}`,o),resolve:a(n,f),enlarge:t.leveled?[1,2].map(d=>a(n,`#define LEVEL ${d}
${f}`)):[]}}function v0(r,{view:e,packed:t,wide:n,whole:s,count:o},f){return _0(r,e,f)(s,`#define VERTEX
${f.packed?t:n}${o}`)}function _0(r,e,{sorted:t,strips:n,leveled:s}){let f=Object.entries({SORTED:t,STRIPS:n,LEVELED:s}).map(([c,a])=>a?`#define ${c}
`:"").join("");return(c,a)=>{let d=j(r,`${f}#define VERTEX
${e}${c}`,`${f}${e}${a}`);return r.useProgram(d),N.forEach((l,p)=>r.uniform1i(r.getUniformLocation(d,l),p)),r.uniformBlockBinding(d,r.getUniformBlockIndex(d,"View"),x0),d}}function j(r,e,t){let n=r.createProgram();for(let[s,o]of[[r.VERTEX_SHADER,e],[r.FRAGMENT_SHADER,t]]){let f=r.createShader(s);r.shaderSource(f,`#version 300 es
${o}`),r.compileShader(f),r.attachShader(n,f),r.deleteShader(f)}if(r.linkProgram(n),!r.getProgramParameter(n,r.LINK_STATUS)&&!r.isContextLost()){let s=(r.getAttachedShaders(n)??[]).map(o=>r.getShaderInfoLog(o));throw s.push(r.getProgramInfoLog(n)),new Error(`this GPU refuses a shader: ${s.join(" ")}`)}return n}var z,x0,W,Y=u(()=>{"use strict";i();V();X();z=128,x0=0,W=["EXT_color_buffer_float","EXT_color_buffer_half_float"]});var I,y0=u(()=>{"use strict";i();g0();Y();I=class{#e;#r=null;#n;#t;#o;#s=0;constructor(e,t){this.#e=e,this.#n=j(e,`#define VERTEX
${t}`,t),this.#t=e.createVertexArray(),this.#o=e.createBuffer(),e.bindVertexArray(this.#t),e.bindBuffer(e.ARRAY_BUFFER,this.#o),e.enableVertexAttribArray(0),e.vertexAttribPointer(0,3,e.FLOAT,!1,0,0)}take(e){let[t,n]=[this.#e,e?w0(e):new Float32Array(0)];this.#r=e,this.#s=n.length/3,t.bindBuffer(t.ARRAY_BUFFER,this.#o),t.bufferData(t.ARRAY_BUFFER,n,t.STATIC_DRAW)}draw(e){let[t,n]=[this.#e,this.#r];n&&(t.bindFramebuffer(t.FRAMEBUFFER,null),t.viewport(0,0,e.width,e.height),t.disable(t.BLEND),t.clearBufferfv(t.COLOR,0,[...n.background,1]),t.useProgram(this.#n),t.uniform4fv(t.getUniformLocation(this.#n,"dots"),m0(n,e)),t.bindVertexArray(this.#t),t.drawArrays(t.TRIANGLES,0,this.#s))}destroy(){let e=this.#e;e.deleteProgram(this.#n),e.deleteVertexArray(this.#t),e.deleteBuffer(this.#o)}}});var K,R0,k0,P0,T0,Q,F0=u(()=>{"use strict";i();B();a0();V();b0();y0();Y();X();K=new Float32Array(0),R0={shapes:["RGBA32UI","RGBA_INTEGER",4],colors:["RGBA32UI","RGBA_INTEGER",4],lobes:["R32UI","RED_INTEGER",1]},k0={shapes:["RGBA32F","RGBA",4],colors:["RGB32F","RGB",3],lobes:["RG32F","RG",2]},P0={...k0,colors:["RGB16F","RGB",3],lobes:["RG16F","RG",2]},T0=["R32UI","RED_INTEGER",1],Q=class r{static files=["view","wide","packed","whole","project","splat","resolve","count","dots"].map(e=>`${e}.glsl`);variant;levelSigma=0;supersampling=1;lost=null;onLost=()=>{};onRestored=()=>{};#e;#r;#n;#t=null;#o=R0;#s=null;#a=null;#i="";#f;#d=e=>{e.preventDefault(),this.#t=this.#s=null,this.lost="the browser took the GPU away from this page: reload it if no picture returns",this.onLost(this.lost)};#l=()=>{this.#t=null,this.#n=H(this.#e),this.#i="",this.#f.forget(),this.lost=null,this.onRestored()};static create(e,t,{floats:n=!1,strips:s=!1}={}){let o=e.getContext("webgl2",{alpha:!1,antialias:!1,depth:!1,powerPreference:"high-performance"});if(o===null)throw new Error("this browser cannot draw with WebGL2 here");if(!W.some(f=>o.getExtension(f)))throw new Error("this GPU cannot draw into textures of floats");if(n&&!q(o))throw new Error("this GPU cannot blend 32-bit floats: use the variant halves");if(o.getParameter(o.MAX_TEXTURE_SIZE)<4096)throw new Error(`this GPU's textures are less than ${4096} pixels wide`);return new r(o,t,{floats:n,strips:s})}constructor(e,t,n){this.#e=e,this.#r=t,this.variant=n,this.#n=H(e),this.#f=new O(e),e.canvas.addEventListener("webglcontextlost",this.#d),e.canvas.addEventListener("webglcontextrestored",this.#l)}setScene(e){let t=this.#e;if(this.#t=this.#a=null,e.network)throw new Error("this scene needs a network for every Gaussian in every frame, which takes WebGPU: open it in a browser that has it");this.#o=e.packing?R0:this.variant.floats?k0:P0;let{shapes:n,colors:s,lobes:o}=e;for(let[c,a]of Object.entries({shapes:n,colors:s,lobes:o}))this.#n.textures.upload(c,this.#o[c],a);t.bindFramebuffer(t.FRAMEBUFFER,this.#n.looks);let f=e.packing?[t.RG32UI,0]:[t.RGBA32F,t.R32F];["looks","opacities"].forEach((c,a)=>{let d=f[a]?this.#n.textures.make(c,f[a],k(e.count)):null;t.framebufferTexture2D(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0+a,t.TEXTURE_2D,d,0)}),this.#w("textures of 32-bit numbers"),this.#t={...e,shapes:K,colors:K,lobes:K},e.sorted&&this.#n.textures.upload("order",T0,Uint32Array.from({length:e.count},(c,a)=>a))}show(e){this.#t&&(this.#t.count=e)}update(e,t,n){if(this.#t===null)return;let s=this.#o[e];this.#n.textures.write(e,s,f0(this.#t)[e]/s[2]*t,n)}setDots(e){this.lost===null&&(this.#s??=new I(this.#e,this.#r.dots),this.#s.take(e))}drawDots(e){this.#s&&(this.#u(e),this.#s.draw(e))}setOrder(e){if(this.#t!==null){if(e.length!==this.#t.count)throw new Error(`an order of ${e.length} Gaussians does not fit this scene`);this.#n.textures.write("order",T0,0,e)}}draw(e){this.#t!==null&&(this.#u(e),this.#f.start(),this.#c(this.#t,e),this.#h(this.#t,e,null,e.height-1),this.#f.pass())}async drawUnseen(e){let t=this.#e;if(this.#t&&this.#c(this.#t,e),t.readBuffer(t.COLOR_ATTACHMENT0),t.readPixels(0,0,1,1,t.RGBA,t.FLOAT,new Float32Array(4)),t.isContextLost())throw new Error("the graphics device was lost")}get milliseconds(){return this.#f.milliseconds}async time(){this.lost===null&&await this.#f.time()}async finished(){this.#e.bindFramebuffer(this.#e.FRAMEBUFFER,null),this.#e.readPixels(0,0,1,1,this.#e.RGBA,this.#e.UNSIGNED_BYTE,new Uint8Array(4))}async fragments(){if(this.#t===null||this.#a===null)return null;let e=this.#e,{leveled:t,pixels:n}=this.#a,[s,o]=k(this.#t.count),[f,c]=[e.createFramebuffer(),e.createRenderbuffer()];e.bindFramebuffer(e.FRAMEBUFFER,f),e.bindRenderbuffer(e.RENDERBUFFER,c),e.renderbufferStorage(e.RENDERBUFFER,e.RGBA16F,s,o),e.framebufferRenderbuffer(e.FRAMEBUFFER,e.COLOR_ATTACHMENT0,e.RENDERBUFFER,c),e.disable(e.BLEND),e.viewport(0,0,s,o),e.useProgram(this.#E(this.#t,t)),e.drawArrays(e.TRIANGLES,0,3);let a=new Float32Array(4*s*o);e.readPixels(0,0,s,o,e.RGBA,e.FLOAT,a),e.deleteFramebuffer(f),e.deleteRenderbuffer(c);let d=new Array(t?4:1).fill(0);for(let l=0;l<a.length;l+=4)d[a[l+1]]+=a[l]**2/n;return d}get variants(){return(q(this.#e)?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}describe(){let e=this.#e,t=e.getExtension("WEBGL_debug_renderer_info");return String(e.getParameter(t?t.UNMASKED_RENDERER_WEBGL:e.RENDERER))}async pixels(e){if(this.#t===null)throw new Error("there is no scene to draw");let t=this.#e,{width:n,height:s}=e;this.#c(this.#t,e);let[o,f]=[t.createFramebuffer(),t.createRenderbuffer()];t.bindFramebuffer(t.FRAMEBUFFER,o),t.bindRenderbuffer(t.RENDERBUFFER,f),t.renderbufferStorage(t.RENDERBUFFER,t.RGBA32F,n,s),t.framebufferRenderbuffer(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0,t.RENDERBUFFER,f),this.#h(this.#t,e,o,0);let c=new Float32Array(4*n*s);return t.readPixels(0,0,n,s,t.RGBA,t.FLOAT,c),t.deleteFramebuffer(o),t.deleteRenderbuffer(f),c}destroy(){let e=this.#e,{view:t,corners:n,quads:s,looks:o,sums:f,enlarged:c,programs:a,counters:d,textures:l}=this.#n;this.#t=null,this.#s?.destroy(),e.canvas.removeEventListener("webglcontextlost",this.#d),e.canvas.removeEventListener("webglcontextrestored",this.#l),l.destroy();for(let p of a.values())for(let b of Object.values(p).flat())e.deleteProgram(b);for(let p of d.values())e.deleteProgram(p);for(let p of[o,f,...c])e.deleteFramebuffer(p);e.deleteVertexArray(s);for(let p of[t,n])e.deleteBuffer(p);e.getExtension("WEBGL_lose_context")?.loseContext()}#u({width:e,height:t}){let{canvas:n}=this.#e;n.width!==e&&(n.width=e),n.height!==t&&(n.height=t)}#c(e,t){let n=this.#e,s=t.width*t.height;t=$(t,this.supersampling);let{view:o,quads:f,looks:c,sums:a}=this.#n,d=this.#p(e,t),l=this.#m(e,d),[p,b]=this.#x(e.sorted,d,t);n.bindBuffer(n.UNIFORM_BUFFER,o),this.#a={leveled:d,pixels:s};let w=this.variant.floats?1:h0,m=p0(e,t,w,this.levelSigma,this.supersampling);n.bufferSubData(n.UNIFORM_BUFFER,0,m),n.bindVertexArray(f),n.disable(n.BLEND),n.bindFramebuffer(n.FRAMEBUFFER,c),n.drawBuffers([n.COLOR_ATTACHMENT0,e.packing?n.NONE:n.COLOR_ATTACHMENT1]);let[v,g]=k(e.count);if(n.viewport(0,0,v,g),n.useProgram(l.project),this.#f.pass("project"),n.drawArrays(n.TRIANGLES,0,3),n.bindFramebuffer(n.FRAMEBUFFER,a),n.viewport(0,0,p,b),n.enable(n.BLEND),n.useProgram(l.splat),this.#f.pass("splat"),e.sorted?(n.drawBuffers([n.COLOR_ATTACHMENT0]),n.clearBufferfv(n.COLOR,0,[0,0,0,0]),n.blendFunc(n.ONE,n.ONE_MINUS_SRC_ALPHA)):(n.drawBuffers([n.COLOR_ATTACHMENT0,n.COLOR_ATTACHMENT1]),n.clearBufferfv(n.COLOR,0,[0,0,0,1]),n.clearBufferfv(n.COLOR,1,[0,0,0,0]),n.blendFuncSeparate(n.ONE,n.ONE,n.ZERO,n.ONE_MINUS_SRC_ALPHA)),this.variant.strips)n.drawArraysInstanced(n.TRIANGLE_STRIP,0,4,e.count);else{let _=Math.ceil(e.count/z);n.drawElementsInstanced(n.TRIANGLES,6*z,n.UNSIGNED_SHORT,0,_)}}#h(e,t,n,s){let o=this.#e,f=$(t,this.supersampling),{resolve:c,enlarge:a}=this.#m(e,this.#p(e,f));o.disable(o.BLEND),this.#f.pass("resolve"),a.length&&this.#g(a,f),o.bindFramebuffer(o.FRAMEBUFFER,n),o.viewport(0,0,t.width,t.height),o.useProgram(c),o.uniform1i(o.getUniformLocation(c,"last_row"),s),o.drawArrays(o.TRIANGLES,0,3)}#g(e,{width:t,height:n}){let s=this.#e,o=y(t,n);for(let f of[2,1])s.bindFramebuffer(s.FRAMEBUFFER,this.#n.enlarged[f-1]),s.viewport(0,0,o[f][0],o[f][1]),s.useProgram(e[f-1]),s.drawArrays(s.TRIANGLES,0,3)}#p({sorted:e},{width:t,height:n}){let s=this.#e.getParameter(this.#e.MAX_TEXTURE_SIZE);return this.levelSigma>0&&!e&&Math.max(...R(t,n).size)<=s}#x(e,t,{width:n,height:s}){let{floats:o}=this.variant,f=t?R(n,s).size:[n,s],c=`${n} ${s} ${e} ${t} ${o}`;if(c===this.#i)return f;let a=this.#e,d=a.getParameter(a.MAX_TEXTURE_SIZE);if(!(n>0&&n<=d&&s>0&&s<=d))throw new Error(`an image of ${n}x${s} pixels cannot be rendered: each side must lie between 1 and ${d}`);let l=o?[a.RGBA32F,a.R32F]:[a.RGBA16F,a.R16F],{sums:p,enlarged:b,textures:w}=this.#n,m=y(n,s);return[p,...b].forEach((v,g)=>{let _=g?`_${g}`:"";a.bindFramebuffer(a.FRAMEBUFFER,v),["color_sums","weight_sums"].forEach((F,A)=>{let x=(g===0||t)&&!(e&&A>0),D=g===0?f:m[g],L=x?w.make(`${F}${_}`,l[A],D):null;a.framebufferTexture2D(a.FRAMEBUFFER,a.COLOR_ATTACHMENT0+A,a.TEXTURE_2D,L,0)}),g&&t&&a.drawBuffers([a.COLOR_ATTACHMENT0,a.COLOR_ATTACHMENT1]),(g===0||t)&&this.#w(`pictures of ${n}x${s} floats`)}),this.#i=c,f}#b({sorted:e,packing:t},n){return{sorted:e,packed:t!==null,strips:this.variant.strips,leveled:n}}#m(e,t){let{programs:n}=this.#n,s=this.#b(e,t),o=Object.values(s).join(" "),f=n.get(o)??E0(this.#e,this.#r,s);return n.set(o,f),f}#E(e,t){let{counters:n}=this.#n,s={...this.#b(e,t),strips:!1},o=Object.values(s).join(" "),f=n.get(o)??v0(this.#e,this.#r,s);return n.set(o,f),f}#w(e){let t=this.#e;if(t.checkFramebufferStatus(t.FRAMEBUFFER)!==t.FRAMEBUFFER_COMPLETE&&!t.isContextLost())throw new Error(`this GPU cannot draw into ${e}`)}}});var $0=u(()=>{i();J();F0()});$0();export{Q as WebGlRenderer,U0 as shaderText};
