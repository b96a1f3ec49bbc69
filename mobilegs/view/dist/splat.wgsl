override STRIPS = false;
override LEVELED = true;
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
@location(4) @interpolate(flat) seen: vec4f,
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
return level_corner(vertex, place, listed_ellipse(place), select(view.size, view.whole, LEVELED));
}
fn listed_ellipse(place: u32) -> Ellipse { return ellipse_of(shape_of(order[place] & ((1u << LEVEL_SHIFT) - 1u))); }
fn level_corner(vertex: u32, place: u32, full: Ellipse, size: vec2f) -> LevelCorner {
var out: LevelCorner;
let look = stored(looks[place]);
let level = order[place] >> LEVEL_SHIFT;
var ellipse = full;
var opacity = look.opacity;
if (level > 0u) {
ellipse = to_level(full, level);
opacity *= fading(full, ellipse, level);
}
out.region = view.regions[level];
out.seen = seen_of(level, full.depth);
ellipse.center += out.region.xy;
let corner = corner_of(vertex, look, opacity, ellipse, size);
out.position = corner.position;
out.axes = corner.axes;
out.color = corner.color;
out.center = corner.center;
return out;
}
@vertex
fn corner_of_pass(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> LevelCorner {
var out: LevelCorner;
out.position = NOWHERE;
let place = place_in(vertex, instance);
if (place >= listed.count) { return out; }
return pass_corner(vertex, place, listed_ellipse(place));
}
fn pass_corner(vertex: u32, place: u32, full: Ellipse) -> LevelCorner {
var out: LevelCorner;
out.position = NOWHERE;
let look = stored(looks[place]);
let coarse = shrunk(full, 2u, -PASS_BLUR);
let opacity = look.opacity * fading(full, coarse, 2u);
if (!(opacity > view.alpha_min)) { return out; }
let corner = corner_of(vertex, look, opacity, coarse, view.regions[2].zw - view.regions[2].xy);
out.position = corner.position;
out.axes = corner.axes;
out.center = corner.center;
out.seen = seen_of(2u, full.depth);
return out;
}
fn seen_of(level: u32, depth: f32) -> vec4f {
let factor = 0.25 * f32(1u << level);
return vec4f(1.0 - factor * (view.regions[level].xy + f32(min(level, 1u))), factor, log(depth) - log(view.sigma));
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
fn alpha_in(region: vec4f, position: vec2f, axes: vec4f, center: vec4f) -> f32 {
let outside = any(position < region.xy) || any(position > region.zw);
return select(alpha_at(position, axes, center), 0.0, outside);
}
struct Sums {
@location(0) color: vec4f,
@location(1) weights: vec4f,
}
@fragment
fn add_weighted(corner: Corner) -> Sums {
return sums_of(alpha_at(corner.position.xy, corner.axes, corner.center), corner.color);
}
@fragment
fn add_to_level(corner: LevelCorner) -> Sums {
return sums_of(alpha_in(corner.region, corner.position.xy, corner.axes, corner.center), corner.color);
}
const PASS_BLUR = 2.25;
const DEPTH_FLOOR = 0.02;
const DEPTH_SLOPE = 0.4;
const ALPHAS_MIN = 1e-6;
const ALPHAS_MAX = 16.0;
@fragment
fn add_depth(corner: LevelCorner) -> @location(0) vec4f {
return depth_of(alpha_at(corner.position.xy, corner.axes, corner.center), corner.seen.w);
}
fn depth_of(alpha: f32, u: f32) -> vec4f { return alpha * vec4f(1.0, u, u * u, 0.0); }
@group(0) @binding(2) var moments: texture_2d<f32>;
@group(0) @binding(3) var bilinear: sampler;
fn visibility(position: vec2f, seen: vec4f) -> f32 {
let place = (position * seen.z + seen.xy) / vec2f(textureDimensions(moments));
let found = textureSampleLevel(moments, bilinear, place, 0.0).rgb;
let mean = found.gb / max(found.r, ALPHAS_MIN);
let deviation = sqrt(max(mean.y - mean.x * mean.x, 0.0));
return exp(-min(found.r, ALPHAS_MAX) * clamp(DEPTH_SLOPE * (seen.w - mean.x) / (deviation + DEPTH_FLOOR), -0.5, 0.5));
}
@fragment
fn add_seen(corner: LevelCorner) -> Sums {
let alpha = alpha_in(corner.region, corner.position.xy, corner.axes, corner.center);
return sums_of(alpha, dimmed(corner.color, corner.position.xy, corner.seen));
}
fn dimmed(color: vec4f, position: vec2f, seen: vec4f) -> vec4f {
return vec4f(color.rgb, color.w * visibility(position, seen));
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
