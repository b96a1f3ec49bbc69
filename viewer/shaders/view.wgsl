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
  sigma: f32,
  background_weight: f32,
  weight_scale: f32,  // a power of two that keeps sums of weights within halves
  count: u32,         // Gaussians
  sh_size: u32,       // coefficients per colour: 1, 4, 9 or 16
  lobe_size: u32,     // coefficients of opacity and phi, likewise
  weighting: u32,     // as WEIGHTINGS of sortfree.py
  frame: vec4f,       // of packed positions: the centre; w is the unit
  scale_bits: vec2f,  // of packed scales, as floats: of the least one, and the span
  alpha_min: f32,     // contributions below are dropped
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
const BLUR = 0.3;
const BATCH = 128u;  // Gaussians that are drawn or left out together

// The ellipse of a Gaussian on the picture.
struct Ellipse {
  depth: f32,
  center: vec2f,  // pixels
  variance: vec2f,  // along x and y, pixels^2
  covariance: f32,
  determinant: f32,
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
  out.variance = vec2f(dot(px, px), dot(py, py)) + BLUR;
  out.covariance = dot(px, py);
  // Cauchy-Binet: the determinant as a sum of squares cannot cancel
  let crossed = cross(px, py);
  out.determinant = dot(crossed, crossed) + BLUR * (out.variance.x + out.variance.y - BLUR);
  return out;
}

// Standard deviations out to which alpha is at least alpha_min.
fn reach_of(opacity: f32) -> f32 { return sqrt(2.0 * log(opacity / view.alpha_min)); }

// False if a Gaussian of this opacity is nowhere on the picture.
fn touches(ellipse: Ellipse, opacity: f32) -> bool {
  let box = reach_of(opacity) * sqrt(ellipse.variance);
  return !(any(ellipse.center + box < vec2f(0.5)) || any(ellipse.center - box > view.size - 0.5));
}
