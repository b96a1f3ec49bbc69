// Uniforms of the frame, and the place of Gaussians in textures. The numbers are those of view.wgsl in the
// same order, without vec3, which some drivers lay out wrongly.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

layout(std140) uniform View {
  vec4 row_x;  // world to camera (OpenCV axes), row by row; w is the translation
  vec4 row_y;
  vec4 row_z;
  vec4 position;    // of the camera, in the world; w: near plane
  vec4 lens;        // focal lengths, then the centre from the picture's corner, pixels
  vec4 limits;      // range of x/z and y/z at which the projection is linearised
  vec4 background;  // w: exponent_max
  vec4 size;        // pixels; z: sigma (of weighting 4: a depth whose logarithm counts as 0), w: background_weight
  float weight_scale;  // a power of two that keeps sums of weights within halves
  int count;           // Gaussians
  int sh_size;         // coefficients per colour: 1, 4, 9 or 16
  int lobe_size;       // coefficients of opacity and phi, likewise
  int weighting;       // as WEIGHTINGS of sortfree.py
  vec4 frame;          // of packed positions: the centre; w is the unit
  // of packed scales, as floats: of the least one, and the span; z: alpha_min, w: blur
  vec4 scale_bits;
  int antialiased;    // 1: alpha is compensated for the blur
  int soft_edge;      // 1: alpha_min is subtracted from alpha
  float level_sigma;  // of mobilegs/render/levels.py; 0: all at full size
  int supersampling;  // pixels of the sums along a side of the picture's pixel; `size` counts the former
  vec4 regions[4];    // first pixel and end of each level in the texture of all: levelPlaces in levels.js
  // size of that texture; z: depth at which the nearness is 1, 0: no depth is compared; w: share that a mesh loses
  vec4 whole;
  vec4 grade[3];  // what is added to r, g and b: factors of r, g, b and 1
  vec4 box[2];    // least and greatest corner of a crop, in the world; w of the first: 1 if there is one
};

const float ALPHA_MAX = 0.99;
const float PROXIMITY_SCALE = 8.0;  // keeps sums of proximities and of their squares within halves
const int BATCH = 128;  // quads drawn as one instance, unless STRIPS

// Textures are 4096 wide, as ROW of webgl.js; what does not fit into a row goes on in the next.
ivec2 texel(int i) { return ivec2(i & 4095, i >> 12); }

// A Gaussian as the scene holds it; wide.glsl and packed.glsl give it.
struct Shape {
  vec3 mean;
  mat3 axes;  // half axes at one standard deviation, in the world
};

// What a Gaussian looks like from the camera.
struct Look {
  vec3 color;
  float weight;
  float opacity;  // 0: it cannot touch the picture
};

// The ellipse of a Gaussian on the picture.
struct Ellipse {
  float depth;
  vec2 center;    // pixels
  vec2 variance;  // along x and y, pixels^2
  float covariance;
  float determinant;
  float compensation;  // factor of alpha
  vec2 depth_covariance;  // of the depth with x and y
  float depth_variance;
};

// As project.py defines it; a depth of at most `near` means that there is none.
Ellipse ellipse_of(Shape shape) {
  Ellipse e;
  vec4 mean = vec4(shape.mean, 1.0);
  e.depth = dot(row_z, mean);
  if (!(e.depth > position.w)) { return e; }
  vec2 t = vec2(dot(row_x, mean), dot(row_y, mean)) / e.depth;
  vec2 uv = clamp(t, limits.xz, limits.yw);

  // rows of the projected square root of the covariance
  vec3 depths = row_z.xyz * shape.axes;
  vec3 px = (lens.x / e.depth) * (row_x.xyz * shape.axes - uv.x * depths);
  vec3 py = (lens.y / e.depth) * (row_y.xyz * shape.axes - uv.y * depths);
  e.center = lens.xy * t + lens.zw;
  float blur = scale_bits.w;
  e.variance = vec2(dot(px, px), dot(py, py)) + blur;
  e.covariance = dot(px, py);
  e.depth_covariance = vec2(dot(px, depths), dot(py, depths));
  e.depth_variance = dot(depths, depths);
  // Cauchy-Binet: the determinant as a sum of squares cannot cancel
  vec3 crossed = cross(px, py);
  float before = dot(crossed, crossed);
  e.determinant = before + blur * (e.variance.x + e.variance.y - blur);
  e.compensation = antialiased == 1 ? sqrt(before / e.determinant) : 1.0;
  return e;
}

// The ellipse in the pixels of a level's target, with `spread` px^2 of the image less in both variances: at_level
// in mobilegs/render/levels.py.
Ellipse shrunk(Ellipse e, int level, float spread) {
  Ellipse coarse = e;
  float side = float(1 << level);
  coarse.center = e.center / side + 1.0;
  coarse.determinant = e.determinant - spread * (e.variance.x + e.variance.y) + spread * spread;
  coarse.determinant /= side * side * side * side;
  coarse.variance = (e.variance - spread) / (side * side);
  coarse.covariance = e.covariance / (side * side);
  return coarse;
}

// The factor of the opacity of a Gaussian whose ellipse is drawn as that one.
float fading(Ellipse e, Ellipse coarse, int level) {
  return sqrt(e.determinant / coarse.determinant) / float(1 << (2 * level));
}

#ifdef LEVELED

const float WEIGHT_UNIT = 10.0;

// The level of a Gaussian of weight w. Same formula: choose_levels in mobilegs/render/levels.py,
// level_of in view.wgsl.
int level_of(Ellipse e, float w) {
  if (!(level_sigma > 0.0)) { return 0; }
  float skew = 0.5 * (e.variance.x - e.variance.y);
  float cov = e.covariance;
  float larger = 0.5 * (e.variance.x + e.variance.y) + sqrt(skew * skew + cov * cov);
  float needed = level_sigma * level_sigma * sqrt(max(w / WEIGHT_UNIT, 1.0));
  float share = e.determinant / (larger * needed);
  return int(share >= 4.0) + int(share >= 16.0) + int(share >= 64.0);
}

// The ellipse of a Gaussian in a level's target, less what enlarging adds; to_level in view.wgsl.
Ellipse to_level(Ellipse e, int level) { return shrunk(e, level, 0.25 * (float(1 << (2 * level)) - 1.0)); }

#endif

// Standard deviations out to which alpha is at least alpha_min, below which it is dropped.
float reach_of(float opacity) { return sqrt(2.0 * log(opacity / scale_bits.z)); }
