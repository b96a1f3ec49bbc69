// Vertex and fragment shader of dots, as in dots.wgsl.
precision highp float;

// the struct of dots.wgsl: three rows | colour, near | side, least, pixel
uniform vec4 dots[5];

#ifdef VERTEX
layout(location = 0) in vec3 mean;

void main() {
  vec4 at = vec4(mean, 1.0);
  float depth = dot(dots[2], at);
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // outside of the image
  if (!(depth > dots[3].w)) return;
  float side = depth * clamp(dots[4].x / depth, dots[4].y, 4.0 * dots[4].y);
  int way = gl_VertexID % 3;
  vec2 corner = vec2(float(way & 1), float(way >> 1)) * 2.0 - 1.0;
  if (gl_VertexID % 6 > 2) corner = -corner;  // the second triangle is the first one rotated
  vec2 place = vec2(dot(dots[0], at), dot(dots[1], at));
  gl_Position = vec4(place + side * dots[4].zw * corner, 0.0, depth);
}
#else
out vec4 color;

void main() { color = vec4(dots[3].rgb, 1.0); }
#endif
