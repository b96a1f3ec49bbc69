// What every pass knows of the frame, and where Gaussians lie in textures. The numbers are those of
// view.wgsl in the same order; vec3s are kept out, since some drivers lay them out wrongly.
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
  vec4 size;        // pixels; z: sigma, w: background_weight
  float weight_scale;  // a power of two that keeps sums of weights within halves
  int count;           // Gaussians
  int sh_size;         // coefficients per colour: 1, 4, 9 or 16
  int lobe_size;       // coefficients of opacity and phi, likewise
  int weighting;       // as WEIGHTINGS of sortfree.py
};

const float ALPHA_MIN = 1.0 / 255.0;
const float ALPHA_MAX = 0.99;
const float BLUR = 0.3;
const int BATCH = 128;  // quads drawn as one instance: some devices pay dearly for instances

// Textures are 4096 wide, as ROW of webgl.js; what does not fit into a row goes on in the next.
ivec2 texel(int i) { return ivec2(i & 4095, i >> 12); }
