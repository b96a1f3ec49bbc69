// What every pass knows of the frame. Mirrored field by field in native.py.
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
}

// A Gaussian on the picture.
struct Splat {
  center: vec2f,  // pixels
  major: vec2f,   // half axes of the ellipse at one standard deviation, pixels
  minor: vec2f,
  reach: f32,    // standard deviations out to which alpha is at least 1/255; 0: not visible
  opacity: f32,
  color: vec3f,
  weight: f32,
}

const ALPHA_MIN = 1.0 / 255.0;
const ALPHA_MAX = 0.99;
const BLUR = 0.3;
const BATCH = 128u;  // quads drawn as one instance: some devices pay dearly for instances
