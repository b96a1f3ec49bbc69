// The camera and settings of a frame, for every pass; mobilegs/view/wgpu_renderer.py mirrors the fields.
struct View {
  row_x: vec4f,  // world to camera (OpenCV axes), row by row; w is the translation
  row_y: vec4f,
  row_z: vec4f,
  position: vec3f,  // of the camera, in the world
  near: f32,
  focal: vec2f,   // pixels
  center: vec2f,  // pixels, from the picture's corner
  limits: vec4f,  // range of x/z and y/z at which the projection is linearised
  background: vec3f,
  exponent_max: f32,
  size: vec2f,  // pixels
  sigma: f32,  // of weighting 3; of 4, a depth whose logarithm counts as 0
  background_weight: f32,
  weight_scale: f32,  // a power of two that keeps sums of weights within halves
  count: u32,         // Gaussians
  sh_size: u32,       // coefficients per colour: 1, 4, 9 or 16
  lobe_size: u32,     // coefficients of opacity and phi, likewise
  weighting: u32,     // as WEIGHTINGS of sortfree.py
  frame: vec4f,       // of packed positions: the centre; w is the unit
  scale_bits: vec2f,  // of packed scales, as floats: of the least one, and the span
  alpha_min: f32,     // contributions below are dropped
  blur: f32,          // px^2 added to both variances
  antialiased: u32,   // 1: alpha is compensated for the blur
  soft_edge: u32,     // 1: alpha_min is subtracted from alpha
  level_sigma: f32,   // of mobilegs/render/levels.py; 0: all at full size
  supersampling: u32,  // pixels of the sums along a side of the picture's pixel; `size` counts the former
  regions: array<vec4f, 4>,  // first pixel and end of each level in the texture of all: levelPlaces in levels.js
  whole: vec2f,              // size of that texture
  nearest: f32,              // depth at which the nearness is 1; 0: no depth is compared
  faded: f32,                // the share that a mesh of three.js loses
  grade: array<vec4f, 3>,    // what is added to r, g and b: factors of r, g, b and 1
  crop: array<vec4f, 2>,     // least and greatest corner of a box, in the world; w of the first: 1 if there is one
}

@group(0) @binding(0) var<uniform> view: View;

// A Gaussian as the scene holds it; wide.wgsl and packed.wgsl give it.
struct Shape {
  mean: vec3f,
  axes: mat3x3f,  // half axes at one standard deviation, in the world
}

// What a Gaussian looks like from the camera.
struct Look {
  color: vec3f,
  weight: f32,
  opacity: f32,  // 0: it cannot touch the picture
}

const ALPHA_MAX = 0.99;
const PROXIMITY_SCALE = 8.0;  // keeps sums of proximities and of their squares within halves
const BATCH = 128u;  // quads of an instance, and Gaussians of a work group
const WEIGHT_UNIT = 10.0;
const LEVEL_SHIFT = 30u;  // of the level in an entry of the list of visible Gaussians

// The ellipse of a Gaussian on the picture.
struct Ellipse {
  depth: f32,
  center: vec2f,  // pixels
  variance: vec2f,  // along x and y, pixels^2
  covariance: f32,
  determinant: f32,
  compensation: f32,  // factor of alpha
  depth_covariance: vec2f,  // of the depth with x and y
  depth_variance: f32,
}

// The ellipse of a Gaussian in the image (3DGS, Eq. 5); the depth is at most `near` if there is none. Same
// formula: project in mobilegs/render/project.py, geometry_of and project in csrc/core.h, view.glsl.
fn ellipse_of(shape: Shape) -> Ellipse {
  var out: Ellipse;
  let mean = vec4f(shape.mean, 1.0);
  out.depth = dot(view.row_z, mean);
  if (!(out.depth > view.near)) { return out; }
  let t = vec2f(dot(view.row_x, mean), dot(view.row_y, mean)) / out.depth;
  let uv = clamp(t, view.limits.xz, view.limits.yw);

  // rows of the projected square root of the covariance
  let depths = view.row_z.xyz * shape.axes;
  let px = (view.focal.x / out.depth) * (view.row_x.xyz * shape.axes - uv.x * depths);
  let py = (view.focal.y / out.depth) * (view.row_y.xyz * shape.axes - uv.y * depths);
  out.center = view.focal * t + view.center;
  out.variance = vec2f(dot(px, px), dot(py, py)) + view.blur;
  out.covariance = dot(px, py);
  out.depth_covariance = vec2f(dot(px, depths), dot(py, depths));
  out.depth_variance = dot(depths, depths);
  // Cauchy-Binet: the determinant as a sum of squares cannot cancel
  let crossed = cross(px, py);
  let before = dot(crossed, crossed);
  out.determinant = before + view.blur * (out.variance.x + out.variance.y - view.blur);
  out.compensation = select(1.0, sqrt(before / out.determinant), view.antialiased == 1u);
  return out;
}

// The level of a Gaussian of weight w. Same formula: choose_levels in mobilegs/render/levels.py,
// level_of in csrc/core.h.
fn level_of(ellipse: Ellipse, w: f32) -> u32 {
  if (!(view.level_sigma > 0.0)) { return 0u; }
  let skew = 0.5 * (ellipse.variance.x - ellipse.variance.y);
  let cov = ellipse.covariance;
  let larger = 0.5 * (ellipse.variance.x + ellipse.variance.y) + sqrt(skew * skew + cov * cov);
  let needed = view.level_sigma * view.level_sigma * sqrt(max(w / WEIGHT_UNIT, 1.0));
  let share = ellipse.determinant / (larger * needed);
  return u32(share >= 4.0) + u32(share >= 16.0) + u32(share >= 64.0);
}

// The ellipse in the pixels of a level's target, less what enlarging adds: to_level in csrc/core.h.
fn to_level(ellipse: Ellipse, level: u32) -> Ellipse {
  return shrunk(ellipse, level, 0.25 * (f32(1u << (2u * level)) - 1.0));
}

// The ellipse in the pixels of a level's target, with `spread` px^2 of the image less in both variances: at_level in
// mobilegs/render/levels.py.
fn shrunk(ellipse: Ellipse, level: u32, spread: f32) -> Ellipse {
  var out = ellipse;
  let side = f32(1u << level);
  out.center = ellipse.center / side + 1.0;
  out.determinant = ellipse.determinant - spread * (ellipse.variance.x + ellipse.variance.y) + spread * spread;
  out.determinant /= side * side * side * side;
  out.variance = (ellipse.variance - spread) / (side * side);
  out.covariance = ellipse.covariance / (side * side);
  return out;
}

// The factor of the opacity of a Gaussian whose ellipse is drawn as that one.
fn fading(ellipse: Ellipse, coarse: Ellipse, level: u32) -> f32 {
  return sqrt(ellipse.determinant / coarse.determinant) / f32(1u << (2u * level));
}

// Standard deviations out to which alpha is at least alpha_min.
fn reach_of(opacity: f32) -> f32 { return sqrt(2.0 * log(opacity / view.alpha_min)); }

// False if a Gaussian of this opacity is nowhere on the picture.
fn touches(ellipse: Ellipse, opacity: f32) -> bool {
  let box = reach_of(opacity) * sqrt(ellipse.variance);
  return !(any(ellipse.center + box < vec2f(0.5)) || any(ellipse.center - box > view.size - 0.5));
}
