// Dots: squares of one colour at the means of Gaussians whose attributes have not arrived. Small shaders
// compile fast. Each dot is two triangles of six vertices: some devices render many instances slowly.
struct Dots {
  row_x: vec4f,  // world to clip, row by row
  row_y: vec4f,
  row_w: vec4f,  // the depth
  color: vec3f,
  near: f32,
  side: f32,   // half side in pixels, at depth 1
  least: f32,  // smallest half side in pixels
  pixel: vec2f,  // size of a pixel in clip space
}

@group(0) @binding(0) var<uniform> dots: Dots;

@vertex
fn corner_of_dot(@location(0) mean: vec3f, @builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
  let at = vec4f(mean, 1.0);
  let depth = dot(dots.row_w, at);
  if (!(depth > dots.near)) { return vec4f(2.0, 2.0, 2.0, 1.0); }  // outside of the image
  let side = depth * clamp(dots.side / depth, dots.least, 4.0 * dots.least);
  let turn = select(1.0, -1.0, vertex % 6u > 2u);  // the second triangle is the first one rotated
  let corner = turn * (vec2f(vec2u((vertex % 3u) & 1u, (vertex % 3u) >> 1u)) * 2.0 - 1.0);
  let place = vec2f(dot(dots.row_x, at), dot(dots.row_y, at));
  return vec4f(place + side * dots.pixel * corner, 0.0, depth);
}

@fragment
fn paint_dot() -> @location(0) vec4f { return vec4f(dots.color, 1.0); }
