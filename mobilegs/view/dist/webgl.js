var g=(s,e,t)=>()=>{if(t)throw t[0];try{return s&&(e=s(s=0)),e}catch(n){throw t=[n],n}};var v,u=g(()=>{v={"count.glsl":`out vec4 found;
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
`}});async function ye(s){return v[s]}var Q=g(()=>{u()});function y(s,e){let t=[[s,e]];for(let n=1;n<4;n++)t.push(t[n-1].map(r=>(r-(n===1?0:1)>>1)+2));return t}function A(s,e){let[,...t]=y(s,e),n=[[0,0]],r=0;for(let[,o]of t)n.push([s,r]),r+=o;return{places:n,size:[s+t[0][0],Math.max(e,r)]}}var I=g(()=>{"use strict";u()});function K({packing:s,shSize:e,lobeSize:t,network:n}){return s?{shapes:4,colors:4,lobes:n?10:t+2>>1}:{shapes:12,colors:3*e,lobes:2*t}}var Z=g(()=>{"use strict";u()});var J,Ie,Ne,Ce,Re,Pe,ee=g(()=>{"use strict";u();J=Object.freeze({blur:.3,antialiased:!1,soft_edge:!1}),Ie=2**26,Ne=2**14,Ce=2**16,Re=[6,12],Pe=[["scale",3],["rotation",3],["appearance",Re[0]],["opacity",1]]});function C(s,e){let{fx:t,fy:n,cx:r,cy:o,width:i,height:a}=s;return{...s,fx:e*t,fy:e*n,cx:e*r,cy:e*o,width:e*i,height:e*a}}function oe(s,e,t,n,r){let{viewmat:o,fx:i,fy:a,cx:c,cy:l,width:f,height:h,near:d}=e,{background:m,weighting:p,packing:x,footprint:w=J}=s,b=te*.5*f/i,F=te*.5*h/a,R=[0,1,2].map(_=>-(o[_]*o[3]+o[4+_]*o[7]+o[8+_]*o[11])),E=new Float32Array(N/4);E.set([...Array.from(o).slice(0,12),...R,d,i,a,c,l,-c/i-b,(f-c)/i+b,-l/a-F,(h-l)/a+F,...m,p.exponentMax,f,h,p.sigma,p.backgroundWeight,t]);let U=[s.count,s.shSize,s.lobeSize,p.index];if(new Int32Array(E.buffer).set(U,33),x){let{center:_,unit:S,leastScaleBits:O,scaleBitsSpan:xe}=x;E.set([..._,S,O,xe],40)}E[46]=!s.sorted&&p.alphaMin||1/255,E[47]=w.blur,new Int32Array(E.buffer).set([Number(w.antialiased),Number(w.soft_edge&&!s.sorted)],48),E[50]=n,new Int32Array(E.buffer)[51]=r;let L=y(f,h),{places:ve,size:Ee}=A(f,h),_e=ve.flatMap(([_,S],O)=>[_,S,_+L[O][0],S+L[O][1]]);return E.set([..._e,...Ee],52),E}var N,ne,te,P=g(()=>{"use strict";u();ee();I();N=336,ne=2**-6,te=.3});var z,re=g(()=>{"use strict";u();z=class{milliseconds=null;#e;#o;#n=!1;#t=!1;#r=[];constructor(e){this.#e=e,this.#o=e.getExtension("EXT_disjoint_timer_query_webgl2")}start(){this.#t=this.#n&&!this.#r.length}pass(e){if(!this.#t)return;let[t,n]=[this.#e,this.#o.TIME_ELAPSED_EXT];if(this.#r.length&&t.endQuery(n),e){let r=t.createQuery();this.#r.push([e,r]),t.beginQuery(n,r)}else this.#t=!1}async time(){let e=this.#e;this.#n=this.#o!==null;let t=this.#r[this.#r.length-1];if(!t||this.#t)return;for(let r=0;r<100&&!e.getQueryParameter(t[1],e.QUERY_RESULT_AVAILABLE);r++)await new Promise(o=>setTimeout(o,5));let n=this.#r.map(([r,o])=>[r,e.getQueryParameter(o,e.QUERY_RESULT)/1e6]);e.getParameter(this.#o.GPU_DISJOINT_EXT)||(this.milliseconds=Object.fromEntries(n));for(let[,r]of this.#r.splice(0))e.deleteQuery(r)}forget(){this.#r=[],this.#t=!1}}});function se({color:s,side:e},{viewmat:t,fx:n,fy:r,cx:o,cy:i,width:a,height:c,near:l}){let[f,h,d]=[0,4,8].map(m=>Array.from(t).slice(m,m+4));return Float32Array.of(...f.map((m,p)=>2*(n*m+o*d[p])/a-d[p]),...h.map((m,p)=>d[p]-2*(r*m+i*d[p])/c),...d,...s,l,r*e/2,.002*c/2,2/a,2/c)}function ie({means:s}){let e=new Float32Array(6*s.length);for(let t=0,n=0;t<s.length;t+=3)for(let r=n+18;n<r;n+=3)e[n]=s[t],e[n+1]=s[t+1],e[n+2]=s[t+2];return e}var ae=g(()=>{"use strict";u()});function k(s){return[Math.max(1,Math.min(s,4096)),Math.max(1,Math.ceil(s/4096))]}var G,T,D,V=g(()=>{"use strict";u();G={shapes:["RGBA32UI","RGBA_INTEGER",4],colors:["RGBA32UI","RGBA_INTEGER",4],lobes:["R32UI","RED_INTEGER",1]},T=["shapes","colors","lobes","looks","opacities","order","color_sums","weight_sums","color_sums_1","weight_sums_1","color_sums_2","weight_sums_2"],D=class{#e;#o=new Map;constructor(e){this.#e=e}make(e,t,[n,r]){let o=this.#e;o.deleteTexture(this.#o.get(e)??null);let i=o.createTexture();return this.#o.set(e,i),o.activeTexture(o.TEXTURE0+T.indexOf(e)),o.bindTexture(o.TEXTURE_2D,i),o.texStorage2D(o.TEXTURE_2D,1,t,n,r),o.texParameteri(o.TEXTURE_2D,o.TEXTURE_MIN_FILTER,o.NEAREST),o.texParameteri(o.TEXTURE_2D,o.TEXTURE_MAG_FILTER,o.NEAREST),i}upload(e,t,n){let r=this.#e,[o,,i]=t,a=k(n.length/i);if(a[1]>r.getParameter(r.MAX_TEXTURE_SIZE))throw new Error("the scene has more Gaussians than this GPU's textures can hold");this.make(e,r[o],a),this.write(e,t,0,n)}write(e,[,t,n],r,o){let i=this.#e,a=o instanceof Float32Array?i.FLOAT:i.UNSIGNED_INT,c=o.length/n;i.activeTexture(i.TEXTURE0+T.indexOf(e));for(let l=0;l<c;){let[f,h]=[(r+l)%4096,Math.floor((r+l)/4096)],d=Math.min(4096-f,c-l),m=d===4096?Math.floor((c-l)/4096):1,p=l*n;i.texSubImage2D(i.TEXTURE_2D,0,f,h,d,m,i[t],a,o,p),l+=d*m}}bind(){for(let[e,t]of this.#o)this.#e.activeTexture(this.#e.TEXTURE0+T.indexOf(e)),this.#e.bindTexture(this.#e.TEXTURE_2D,t)}destroy(){for(let e of this.#o.values())this.#e.deleteTexture(e)}}});function $(s){return["EXT_color_buffer_float","EXT_float_blend"].every(e=>s.getExtension(e))}function H(s){for(let o of[...X,"EXT_float_blend"])s.getExtension(o);let e=s.getExtension("WEBGL_provoking_vertex");e?.provokingVertexWEBGL(e.FIRST_VERTEX_CONVENTION_WEBGL),s.disable(s.DITHER);let t={view:s.createBuffer(),corners:s.createBuffer(),quads:s.createVertexArray(),looks:s.createFramebuffer(),sums:s.createFramebuffer(),enlarged:[s.createFramebuffer(),s.createFramebuffer()],programs:new Map,counters:new Map,textures:new D(s)};s.bindBufferBase(s.UNIFORM_BUFFER,ce,t.view),s.bufferData(s.UNIFORM_BUFFER,N,s.DYNAMIC_DRAW),s.bindVertexArray(t.quads),s.bindBuffer(s.ELEMENT_ARRAY_BUFFER,t.corners);let n=[0,1,2,2,1,3],r=Array.from({length:M},(o,i)=>n.map(a=>4*i+a));return s.bufferData(s.ELEMENT_ARRAY_BUFFER,Uint16Array.from(r.flat()),s.STATIC_DRAW),t}function le(s,e,t){let{whole:n,project:r,splat:o,resolve:i}=e,a=t.packed?e.packed:e.wide,c=ue(s,e.view,t);return{project:c(n,`${a}${r}`),splat:c(`${a}${o}`,o),resolve:c(n,i),enlarge:t.leveled?[1,2].map(l=>c(n,`#define LEVEL ${l}
${i}`)):[]}}function fe(s,{view:e,packed:t,wide:n,whole:r,count:o},i){return ue(s,e,i)(r,`#define VERTEX
${i.packed?t:n}${o}`)}function ue(s,e,{sorted:t,strips:n,leveled:r}){let i=Object.entries({SORTED:t,STRIPS:n,LEVELED:r}).map(([a,c])=>c?`#define ${a}
`:"").join("");return(a,c)=>{let l=W(s,`${i}#define VERTEX
${e}${a}`,`${i}${e}${c}`);return s.useProgram(l),T.forEach((f,h)=>s.uniform1i(s.getUniformLocation(l,f),h)),s.uniformBlockBinding(l,s.getUniformBlockIndex(l,"View"),ce),l}}function W(s,e,t){let n=s.createProgram();for(let[r,o]of[[s.VERTEX_SHADER,e],[s.FRAGMENT_SHADER,t]]){let i=s.createShader(r);s.shaderSource(i,`#version 300 es
${o}`),s.compileShader(i),s.attachShader(n,i),s.deleteShader(i)}if(s.linkProgram(n),!s.getProgramParameter(n,s.LINK_STATUS)&&!s.isContextLost()){let r=(s.getAttachedShaders(n)??[]).map(o=>s.getShaderInfoLog(o));throw r.push(s.getProgramInfoLog(n)),new Error(`this GPU refuses a shader: ${r.join(" ")}`)}return n}var M,ce,X,q=g(()=>{"use strict";u();P();V();M=128,ce=0,X=["EXT_color_buffer_float","EXT_color_buffer_half_float"]});var B,he=g(()=>{"use strict";u();ae();q();B=class{#e;#o=null;#n;#t;#r;#s=0;constructor(e,t){this.#e=e,this.#n=W(e,`#define VERTEX
${t}`,t),this.#t=e.createVertexArray(),this.#r=e.createBuffer(),e.bindVertexArray(this.#t),e.bindBuffer(e.ARRAY_BUFFER,this.#r),e.enableVertexAttribArray(0),e.vertexAttribPointer(0,3,e.FLOAT,!1,0,0)}take(e){let[t,n]=[this.#e,e?ie(e):new Float32Array(0)];this.#o=e,this.#s=n.length/3,t.bindBuffer(t.ARRAY_BUFFER,this.#r),t.bufferData(t.ARRAY_BUFFER,n,t.STATIC_DRAW)}draw(e,{framebuffer:t,x:n,y:r}){let[o,i]=[this.#e,this.#o];i&&(o.bindFramebuffer(o.FRAMEBUFFER,t),o.viewport(n,r,e.width,e.height),o.disable(o.BLEND),o.enable(o.SCISSOR_TEST),o.scissor(n,r,e.width,e.height),o.clearBufferfv(o.COLOR,0,[...i.background,1]),o.disable(o.SCISSOR_TEST),o.useProgram(this.#n),o.uniform4fv(o.getUniformLocation(this.#n,"dots"),se(i,e)),o.bindVertexArray(this.#t),o.drawArrays(o.TRIANGLES,0,this.#s))}destroy(){let e=this.#e;e.deleteProgram(this.#n),e.deleteVertexArray(this.#t),e.deleteBuffer(this.#r)}}});var j,pe,we,Te,me,Y,ge=g(()=>{"use strict";u();I();Z();P();re();he();q();V();j=new Float32Array(0),pe={framebuffer:null,x:0,y:0},we={shapes:["RGBA32F","RGBA",4],colors:["RGB32F","RGB",3],lobes:["RG32F","RG",2]},Te={...we,colors:["RGB16F","RGB",3],lobes:["RG16F","RG",2]},me=["R32UI","RED_INTEGER",1],Y=class s{static files=["view","wide","packed","whole","project","splat","resolve","count","dots"].map(e=>`${e}.glsl`);variant;levelSigma=0;supersampling=1;crop=null;lost=null;onLost=()=>{};onRestored=()=>{};#e;#o;#n;#t=null;#r=G;#s=null;#a=null;#c="";#i;#f=e=>{e.preventDefault(),this.#t=this.#s=null,this.lost="the browser took the GPU away from this page: reload it if no picture returns",this.onLost(this.lost)};#u=()=>{this.#t=null,this.#n=H(this.#e),this.#c="",this.#i.forget(),this.lost=null,this.onRestored()};static create(e,t,{floats:n=!1,strips:r=!1}={}){let o=e.getContext("webgl2",{alpha:!1,antialias:!1,depth:!1,powerPreference:"high-performance"});if(o===null)throw new Error("this browser cannot draw with WebGL2 here");if(!X.some(i=>o.getExtension(i)))throw new Error("this GPU cannot draw into textures of floats");if(n&&!$(o))throw new Error("this GPU cannot blend 32-bit floats: use the variant halves");if(o.getParameter(o.MAX_TEXTURE_SIZE)<4096)throw new Error(`this GPU's textures are less than ${4096} pixels wide`);return new s(o,t,{floats:n,strips:r})}constructor(e,t,n){this.#e=e,this.#o=t,this.variant=n,this.#n=H(e),this.#i=new z(e),e.canvas.addEventListener("webglcontextlost",this.#f),e.canvas.addEventListener("webglcontextrestored",this.#u)}setScene(e){let t=this.#e;if(this.#t=this.#a=null,e.network)throw new Error("this scene needs a network for every Gaussian in every frame, which takes WebGPU: open it in a browser that has it");this.#r=e.packing?G:this.variant.floats?we:Te;let{shapes:n,colors:r,lobes:o}=e;for(let[a,c]of Object.entries({shapes:n,colors:r,lobes:o}))this.#n.textures.upload(a,this.#r[a],c);t.bindFramebuffer(t.FRAMEBUFFER,this.#n.looks);let i=e.packing?[t.RG32UI,0]:[t.RGBA32F,t.R32F];["looks","opacities"].forEach((a,c)=>{let l=i[c]?this.#n.textures.make(a,i[c],k(e.count)):null;t.framebufferTexture2D(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0+c,t.TEXTURE_2D,l,0)}),this.#g("textures of 32-bit numbers"),this.#t={...e,shapes:j,colors:j,lobes:j},e.sorted&&this.#n.textures.upload("order",me,Uint32Array.from({length:e.count},(a,c)=>c))}show(e){this.#t&&(this.#t.count=e)}update(e,t,n){if(this.#t===null)return;let r=this.#r[e];this.#n.textures.write(e,r,K(this.#t)[e]/r[2]*t,n)}setDots(e){this.lost===null&&(this.#s??=new B(this.#e,this.#o.dots),this.#s.take(e))}drawDots(e,t=null){this.#s&&(t||this.#h(e),this.#s.draw(e,t??pe))}setOrder(e){if(this.#t!==null){if(e.length!==this.#t.count)throw new Error(`an order of ${e.length} Gaussians does not fit this scene`);this.#n.textures.write("order",me,0,e)}}draw(e,t=null){if(this.#t===null)return;t||this.#h(e);let{framebuffer:n,x:r,y:o}=t??pe;this.#i.start(),this.#l(this.#t,e),this.#d(this.#t,e,n,r,o,o+e.height-1),this.#i.pass()}async drawUnseen(e){let t=this.#e;if(this.#t&&this.#l(this.#t,e),t.readBuffer(t.COLOR_ATTACHMENT0),t.readPixels(0,0,1,1,t.RGBA,t.FLOAT,new Float32Array(4)),t.isContextLost())throw new Error("the graphics device was lost")}get milliseconds(){return this.#i.milliseconds}async time(){this.lost===null&&await this.#i.time()}async finished(){this.#e.bindFramebuffer(this.#e.FRAMEBUFFER,null),this.#e.readPixels(0,0,1,1,this.#e.RGBA,this.#e.UNSIGNED_BYTE,new Uint8Array(4))}async fragments(){if(this.#t===null||this.#a===null)return null;let e=this.#e,{leveled:t,pixels:n}=this.#a,[r,o]=k(this.#t.count),[i,a]=[e.createFramebuffer(),e.createRenderbuffer()];e.bindFramebuffer(e.FRAMEBUFFER,i),e.bindRenderbuffer(e.RENDERBUFFER,a),e.renderbufferStorage(e.RENDERBUFFER,e.RGBA16F,r,o),e.framebufferRenderbuffer(e.FRAMEBUFFER,e.COLOR_ATTACHMENT0,e.RENDERBUFFER,a),e.disable(e.BLEND),e.viewport(0,0,r,o),e.useProgram(this.#_(this.#t,t)),e.drawArrays(e.TRIANGLES,0,3);let c=new Float32Array(4*r*o);e.readPixels(0,0,r,o,e.RGBA,e.FLOAT,c),e.deleteFramebuffer(i),e.deleteRenderbuffer(a);let l=new Array(t?4:1).fill(0);for(let f=0;f<c.length;f+=4)l[c[f+1]]+=c[f]**2/n;return l}get variants(){return($(this.#e)?[!1,!0]:[!1]).flatMap(e=>[{floats:e,strips:!1},{floats:e,strips:!0}])}get context(){return this.#e}describe(){let e=this.#e,t=e.getExtension("WEBGL_debug_renderer_info");return String(e.getParameter(t?t.UNMASKED_RENDERER_WEBGL:e.RENDERER))}async pixels(e){if(this.#t===null)throw new Error("there is no scene to draw");let t=this.#e,{width:n,height:r}=e;this.#l(this.#t,e);let[o,i]=[t.createFramebuffer(),t.createRenderbuffer()];t.bindFramebuffer(t.FRAMEBUFFER,o),t.bindRenderbuffer(t.RENDERBUFFER,i),t.renderbufferStorage(t.RENDERBUFFER,t.RGBA32F,n,r),t.framebufferRenderbuffer(t.FRAMEBUFFER,t.COLOR_ATTACHMENT0,t.RENDERBUFFER,i),this.#d(this.#t,e,o,0,0,0);let a=new Float32Array(4*n*r);return t.readPixels(0,0,n,r,t.RGBA,t.FLOAT,a),t.deleteFramebuffer(o),t.deleteRenderbuffer(i),a}destroy(){let e=this.#e,{view:t,corners:n,quads:r,looks:o,sums:i,enlarged:a,programs:c,counters:l,textures:f}=this.#n;this.#t=null,this.#s?.destroy(),e.canvas.removeEventListener("webglcontextlost",this.#f),e.canvas.removeEventListener("webglcontextrestored",this.#u),f.destroy();for(let h of c.values())for(let d of Object.values(h).flat())e.deleteProgram(d);for(let h of l.values())e.deleteProgram(h);for(let h of[o,i,...a])e.deleteFramebuffer(h);e.deleteVertexArray(r);for(let h of[t,n])e.deleteBuffer(h);e.getExtension("WEBGL_lose_context")?.loseContext()}#h({width:e,height:t}){let{canvas:n}=this.#e;n.width!==e&&(n.width=e),n.height!==t&&(n.height=t)}#l(e,t){let n=this.#e,r=t.width*t.height;t=C(t,this.supersampling);let{view:o,quads:i,looks:a,sums:c}=this.#n,l=this.#p(e,t),f=this.#w(e,l),[h,d]=this.#E(e.sorted,l,t);n.bindBuffer(n.UNIFORM_BUFFER,o),this.#a={leveled:l,pixels:r};let m=this.variant.floats?1:ne,p=oe(e,t,m,this.levelSigma,this.supersampling);n.bufferSubData(n.UNIFORM_BUFFER,0,p),n.bindVertexArray(i),n.disable(n.BLEND),n.bindFramebuffer(n.FRAMEBUFFER,a),n.drawBuffers([n.COLOR_ATTACHMENT0,e.packing?n.NONE:n.COLOR_ATTACHMENT1]);let[x,w]=k(e.count);if(n.viewport(0,0,x,w),n.useProgram(f.project),n.uniform4fv(n.getUniformLocation(f.project,"crop"),this.crop??[0,0,0,0]),this.#i.pass("project"),n.drawArrays(n.TRIANGLES,0,3),n.bindFramebuffer(n.FRAMEBUFFER,c),n.viewport(0,0,h,d),n.enable(n.BLEND),n.useProgram(f.splat),this.#i.pass("splat"),e.sorted?(n.drawBuffers([n.COLOR_ATTACHMENT0]),n.clearBufferfv(n.COLOR,0,[0,0,0,0]),n.blendFunc(n.ONE,n.ONE_MINUS_SRC_ALPHA)):(n.drawBuffers([n.COLOR_ATTACHMENT0,n.COLOR_ATTACHMENT1]),n.clearBufferfv(n.COLOR,0,[0,0,0,1]),n.clearBufferfv(n.COLOR,1,[0,0,0,0]),n.blendFuncSeparate(n.ONE,n.ONE,n.ZERO,n.ONE_MINUS_SRC_ALPHA)),this.variant.strips)n.drawArraysInstanced(n.TRIANGLE_STRIP,0,4,e.count);else{let b=Math.ceil(e.count/M);n.drawElementsInstanced(n.TRIANGLES,6*M,n.UNSIGNED_SHORT,0,b)}}#d(e,t,n,r,o,i){let a=this.#e,c=C(t,this.supersampling),{resolve:l,enlarge:f}=this.#w(e,this.#p(e,c));a.disable(a.BLEND),this.#i.pass("resolve"),f.length&&this.#v(f,c),a.bindFramebuffer(a.FRAMEBUFFER,n),a.viewport(r,o,t.width,t.height),a.useProgram(l),a.uniform1i(a.getUniformLocation(l,"first_column"),r),a.uniform1i(a.getUniformLocation(l,"last_row"),i),a.drawArrays(a.TRIANGLES,0,3)}#v(e,{width:t,height:n}){let r=this.#e,o=y(t,n);for(let i of[2,1])r.bindFramebuffer(r.FRAMEBUFFER,this.#n.enlarged[i-1]),r.viewport(0,0,o[i][0],o[i][1]),r.useProgram(e[i-1]),r.drawArrays(r.TRIANGLES,0,3)}#p({sorted:e},{width:t,height:n}){let r=this.#e.getParameter(this.#e.MAX_TEXTURE_SIZE);return this.levelSigma>0&&!e&&Math.max(...A(t,n).size)<=r}#E(e,t,{width:n,height:r}){let{floats:o}=this.variant,i=t?A(n,r).size:[n,r],a=`${n} ${r} ${e} ${t} ${o}`;if(a===this.#c)return i;let c=this.#e,l=c.getParameter(c.MAX_TEXTURE_SIZE);if(!(n>0&&n<=l&&r>0&&r<=l))throw new Error(`an image of ${n}x${r} pixels cannot be rendered: each side must lie between 1 and ${l}`);let f=o?[c.RGBA32F,c.R32F]:[c.RGBA16F,c.R16F],{sums:h,enlarged:d,textures:m}=this.#n,p=y(n,r);return[h,...d].forEach((x,w)=>{let b=w?`_${w}`:"";c.bindFramebuffer(c.FRAMEBUFFER,x),["color_sums","weight_sums"].forEach((F,R)=>{let E=(w===0||t)&&!(e&&R>0),U=w===0?i:p[w],L=E?m.make(`${F}${b}`,f[R],U):null;c.framebufferTexture2D(c.FRAMEBUFFER,c.COLOR_ATTACHMENT0+R,c.TEXTURE_2D,L,0)}),w&&t&&c.drawBuffers([c.COLOR_ATTACHMENT0,c.COLOR_ATTACHMENT1]),(w===0||t)&&this.#g(`pictures of ${n}x${r} floats`)}),this.#c=a,i}#m({sorted:e,packing:t},n){return{sorted:e,packed:t!==null,strips:this.variant.strips,leveled:n}}#w(e,t){let{programs:n}=this.#n,r=this.#m(e,t),o=Object.values(r).join(" "),i=n.get(o)??le(this.#e,this.#o,r);return n.set(o,i),i}#_(e,t){let{counters:n}=this.#n,r={...this.#m(e,t),strips:!1},o=Object.values(r).join(" "),i=n.get(o)??fe(this.#e,this.#o,r);return n.set(o,i),i}#g(e){let t=this.#e;if(t.checkFramebufferStatus(t.FRAMEBUFFER)!==t.FRAMEBUFFER_COMPLETE&&!t.isContextLost())throw new Error(`this GPU cannot draw into ${e}`)}}});var ke=g(()=>{u();Q();ge()});ke();export{Y as WebGlRenderer,ye as shaderText};
