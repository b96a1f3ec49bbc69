override SORTED = false;
@group(0) @binding(4) var<storage, read> looks: array<StoredLook>;
@group(0) @binding(5) var<storage, read> list: array<u32>;
@group(0) @binding(6) var<storage, read> listed: array<u32, 6>;
@group(0) @binding(7) var<storage, read_write> areas: array<atomic<u32>, 4>;
@compute @workgroup_size(BATCH)
fn count_fragments(
@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
@builtin(local_invocation_index) local: u32) {
let place = (group.y * groups.x + group.x) * BATCH + local;
if (place >= select(listed[5], view.count, SORTED)) { return; }
let look = stored(looks[place]);
if (!(look.opacity > 0.0)) { return; }
let entry = select(list[place], place, SORTED);
let level = select(entry >> LEVEL_SHIFT, 0u, SORTED);
var ellipse = ellipse_of(shape_of(select(entry & ((1u << LEVEL_SHIFT) - 1u), entry, SORTED)));
var opacity = look.opacity;
if (level > 0u) {
let coarse = to_level(ellipse, level);
opacity *= fading(ellipse, coarse, level);
ellipse = coarse;
}
let region = view.regions[level];
let reach = reach_of(max(opacity, view.alpha_min));
let box = reach * sqrt(ellipse.variance);
let inside = max(min(ellipse.center + box, region.zw - region.xy) - max(ellipse.center - box, vec2f()), vec2f());
let share = inside / max(2.0 * box, vec2f(1e-9));
let area = 3.14159265 * reach * reach * sqrt(ellipse.determinant) * share.x * share.y;
atomicAdd(&areas[level], u32(8.0 * area + 0.5));
}
