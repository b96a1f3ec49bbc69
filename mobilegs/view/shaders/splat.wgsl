// Draws each Splat as the quad around the ellipse where alpha is at least 1/255. Sort-free, both
// targets share one blend state: colours add up, alpha multiplies by one minus itself.
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> splats: array<Splat>;
@group(0) @binding(2) var<storage, read> drawn: array<u32>;  // sort-free: its sixth is how many
@group(0) @binding(3) var<storage, read> order: array<u32>;  // sorted: far ones first

struct Corner {
  @builtin(position) position: vec4f,
  @location(0) @interpolate(flat) axes: vec4f,  // offsets in pixels to standard deviations
  @location(1) @interpolate(flat) color: vec4f,  // w: weight
  @location(2) @interpolate(flat) center: vec3f,  // z: opacity
}

fn corner_of(splat: Splat, corner: u32) -> Corner {
  var out: Corner;
  let lengths = vec2f(dot(splat.major, splat.major), dot(splat.minor, splat.minor));
  out.axes = vec4f(splat.major / lengths.x, splat.minor / lengths.y);
  out.color = vec4f(splat.color, splat.weight);
  out.center = vec3f(splat.center, splat.opacity);
  // a hair wider: rasterisers snap corners to fractions of a pixel
  let reach = splat.reach + 0.02 * inverseSqrt(lengths);
  let side = reach * (vec2f(vec2u(corner & 1u, corner >> 1u)) * 2.0 - 1.0);
  let at = splat.center + side.x * splat.major + side.y * splat.minor;
  out.position = vec4f(at / view.size * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), 0.0, 1.0);
  return out;
}

const NOWHERE = vec4f(2.0, 2.0, 2.0, 1.0);

@vertex
fn corner_sortfree(
    @builtin(vertex_index) vertex: u32, @builtin(instance_index) batch: u32) -> Corner {
  let place = batch * BATCH + vertex / 4u;
  var out: Corner;
  out.position = NOWHERE;
  if (place < drawn[5]) { out = corner_of(splats[place], vertex % 4u); }
  return out;
}

@vertex
fn corner_sorted(
    @builtin(vertex_index) vertex: u32, @builtin(instance_index) batch: u32) -> Corner {
  let place = batch * BATCH + vertex / 4u;
  var out: Corner;
  out.position = NOWHERE;
  if (place < view.count) {
    let splat = splats[order[place]];
    if (splat.reach > 0.0) { out = corner_of(splat, vertex % 4u); }
  }
  return out;
}

// From the fragment's own position: interpolated coordinates carry the rasteriser's snapping.
fn alpha_at(corner: Corner) -> f32 {
  let d = corner.position.xy - corner.center.xy;
  let q = vec2f(dot(corner.axes.xy, d), dot(corner.axes.zw, d));
  let alpha = corner.center.z * exp(-0.5 * dot(q, q));
  return select(0.0, min(alpha, ALPHA_MAX), alpha >= ALPHA_MIN);
}

struct Sums {
  @location(0) color: vec4f,   // sum of c a w; a becomes the product of 1 - a
  @location(1) weight: vec4f,  // sum of a w
}

@fragment
fn add_weighted(corner: Corner) -> Sums {
  let alpha = alpha_at(corner);
  let weighted = alpha * corner.color.w;
  return Sums(vec4f(corner.color.rgb * weighted, alpha), vec4f(weighted, 0.0, 0.0, 0.0));
}

@fragment
fn cover(corner: Corner) -> @location(0) vec4f {
  let alpha = alpha_at(corner);
  return vec4f(corner.color.rgb * alpha, alpha);
}
