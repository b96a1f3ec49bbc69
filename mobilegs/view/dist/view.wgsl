struct View {
row_x: vec4f,
row_y: vec4f,
row_z: vec4f,
position: vec3f,
near: f32,
focal: vec2f,
center: vec2f,
limits: vec4f,
background: vec3f,
exponent_max: f32,
size: vec2f,
sigma: f32,
background_weight: f32,
weight_scale: f32,
count: u32,
sh_size: u32,
lobe_size: u32,
weighting: u32,
frame: vec4f,
scale_bits: vec2f,
alpha_min: f32,
}
@group(0) @binding(0) var<uniform> view: View;
struct Shape {
mean: vec3f,
axes: mat3x3f,
}
struct Look {
color: vec3f,
weight: f32,
opacity: f32,
}
const ALPHA_MAX = 0.99;
const BLUR = 0.3;
const BATCH = 128u;
struct Ellipse {
depth: f32,
center: vec2f,
variance: vec2f,
covariance: f32,
determinant: f32,
}
fn ellipse_of(shape: Shape) -> Ellipse {
var out: Ellipse;
let mean = vec4f(shape.mean, 1.0);
out.depth = dot(view.row_z, mean);
if (!(out.depth > view.near)) { return out; }
let t = vec2f(dot(view.row_x, mean), dot(view.row_y, mean)) / out.depth;
let uv = clamp(t, view.limits.xz, view.limits.yw);
let depths = view.row_z.xyz * shape.axes;
let px = (view.focal.x / out.depth) * (view.row_x.xyz * shape.axes - uv.x * depths);
let py = (view.focal.y / out.depth) * (view.row_y.xyz * shape.axes - uv.y * depths);
out.center = view.focal * t + view.center;
out.variance = vec2f(dot(px, px), dot(py, py)) + BLUR;
out.covariance = dot(px, py);
let crossed = cross(px, py);
out.determinant = dot(crossed, crossed) + BLUR * (out.variance.x + out.variance.y - BLUR);
return out;
}
fn reach_of(opacity: f32) -> f32 { return sqrt(2.0 * log(opacity / view.alpha_min)); }
fn touches(ellipse: Ellipse, opacity: f32) -> bool {
let box = reach_of(opacity) * sqrt(ellipse.variance);
return !(any(ellipse.center + box < vec2f(0.5)) || any(ellipse.center - box > view.size - 0.5));
}
