@group(0) @binding(1) var colors: texture_2d<f32>;
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
