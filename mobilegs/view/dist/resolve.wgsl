@group(0) @binding(1) var colors: texture_2d<f32>;
@group(0) @binding(2) var weights: texture_2d<f32>;
@group(0) @binding(3) var coarse_colors: texture_2d<f32>;
@group(0) @binding(4) var coarse_weights: texture_2d<f32>;
@group(0) @binding(5) var bilinear: sampler;
override LEVEL = 1u;
struct Sums {
color: vec4f,
weights: vec4f,
}
fn with_coarser(fine: Sums, pixel: vec2i, begin: f32, first: vec2f) -> Sums {
let at = 0.5 * (vec2f(pixel) + 0.5 - begin) + 1.0 + first;
let place = at / vec2f(textureDimensions(coarse_colors));
let color = textureSampleLevel(coarse_colors, bilinear, place, 0.0);
let weights = textureSampleLevel(coarse_weights, bilinear, place, 0.0);
return Sums(vec4f(fine.color.rgb + color.rgb, fine.color.a * color.a), fine.weights + weights);
}
fn sums_at(pixel: vec2i) -> Sums { return Sums(textureLoad(colors, pixel, 0), textureLoad(weights, pixel, 0)); }
struct Added {
@location(0) color: vec4f,
@location(1) weights: vec4f,
}
@fragment
fn add_enlarged(@builtin(position) position: vec4f) -> Added {
let pixel = vec2i(position.xy);
var first = vec2f();
if (LEVEL == 2u) { first = view.regions[3].xy; }
let sums = with_coarser(sums_at(pixel + vec2i(view.regions[LEVEL].xy)), pixel, 1.0, first);
return Added(sums.color, sums.weights);
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
fn resolved_levels(pixel: vec2i) -> vec4f { return resolved(sums_of_levels(pixel)); }
fn sums_of_levels(pixel: vec2i) -> Sums { return with_coarser(sums_at(pixel), pixel, 0.0, vec2f()); }
fn samples() -> i32 { return i32(view.supersampling * view.supersampling); }
fn sample_of(position: vec4f, k: i32) -> vec2i {
let side = i32(view.supersampling);
return vec2i(position.xy) * side + vec2i(k % side, k / side);
}
fn resolved(sums: Sums) -> vec4f {
let sum = sums.color;
let weight = sums.weights.r;
if (!(weight > 1e-12 * view.weight_scale)) { return vec4f(view.background, 1.0 - sum.a); }
let behind = view.background_weight * view.weight_scale;
if (view.weighting == 3u) {
return vec4f((behind * view.background + sum.rgb) / (behind + weight), 1.0 - sum.a);
}
return vec4f((1.0 - sum.a) * sum.rgb / weight + sum.a * view.background, 1.0 - sum.a);
}
