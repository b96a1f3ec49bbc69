// The GPU's kernels: thin loops over core.h, compiled by NVRTC at first use; cuda.py launches them
// and says in which order. One thread per pixel or Gaussian, or one warp per Gaussian; no atomics:
// whatever several threads add up has one place per addend and one order of adding, so that equal
// inputs give equal bits. Never run on a GPU so far; tests compile them for two generations, and
// execute them thread by thread on a CPU.
#include "cuda_contributions.h"
#include "cuda_sorted.h"
#include "cuda_sortfree.h"

// `blocks` of them share a multiprocessor: 4 leave 64 registers a thread. Left to itself, ptxas
// spills some kernels to make room for one block more.
#define KERNEL(threads, blocks) extern "C" __global__ void __launch_bounds__(threads, blocks)
#define GIVEN const __grid_constant__  // structs stay in the constant bank

// One thread per Gaussian. `counts` are the tiles it touches, `homes` the tile of its box's centre,
// or the number of tiles where it is unseen.
KERNEL(MANY, 4)
mgs_project(GIVEN View view, int n, GIVEN Inputs in, Splat* splats, float* radii, int* counts,
            int* homes) {
  int64 i = global_thread();
  if (i >= n) return;
  Splat s = {};
  bool seen = project(view, in.means + 3 * i, in.quats + 4 * i, in.scales + 3 * i,
                      in.opacities ? in.opacities[i] : 0.0f, in.sh + 3 * view.sh_size * i,
                      in.lobes + 2 * view.lobe_size * i, s);
  int across = tiles_across(view), touched = 0, home = tile_count(view);
  if (seen) {
    for_tiles(s, across, [&](int) { touched++; });
    home = (s.y0 + s.y1 - 1) / 2 / TILE * across + (s.x0 + s.x1 - 1) / 2 / TILE;
  }
  splats[i] = s;
  radii[i] = seen ? radius_of(s) : 0.0f;
  counts[i] = touched;
  homes[i] = home;
}

// One thread per Gaussian, in the order given or, where it is null, by index: writes its entries'
// tiles and itself to its slots, which end at ends[k] and begin where its predecessor's end. The
// compiler may round for_tiles differently here than where tiles were counted, and so disagree on
// a tile that the ellipse just grazes: no such entry leaves the slots, and a slot left over goes
// to the tile after the last, which nobody draws.
KERNEL(MANY, 4)
mgs_fill(GIVEN View view, int n, const Splat* splats, const int64* order, const int64* ends,
         int* tiles, int* ids) {
  int64 k = global_thread();
  if (k >= n) return;
  int64 i = order ? order[k] : k, slot = k ? ends[k - 1] : 0, end = ends[k];
  if (slot == end) return;
  Splat s = splats[i];
  for_tiles(s, tiles_across(view), [&](int tile) {
    if (slot == end) return;
    tiles[slot] = tile;
    ids[slot++] = (int)i;
  });
  for (; slot < end; slot++) tiles[slot] = tile_count(view), ids[slot] = (int)i;
}

// One warp per Gaussian, in the order of its slots: adds up the slots that were reached.
KERNEL(MANY, 4)
mgs_sorted_gather(int n, const int64* order, const int64* ends, const float* slot_sums,
                  const unsigned char* slot_reached, float* totals) {
  int64 k = (int64)blockIdx.x * (MANY / WARP) + warp_of_thread();
  if (k >= n) return;
  int64 first = k ? ends[k - 1] : 0, end = ends[k];
  Sums<float> sums = {};
#pragma unroll 1  // few have more than 32 slots, all gain from registers left for more warps
  for (int64 slot = first + lane_of_thread(); slot < end; slot += WARP) {
    if (!slot_reached[slot]) continue;
    Sums<float> more = load_sums(slot_sums + slot * SUMS);
    sums.r += more.r, sums.g += more.g, sums.b += more.b, sums.z += more.z, sums.w += more.w;
    sums.q += more.q, sums.qx += more.qx, sums.qy += more.qy;
    sums.qxx += more.qxx, sums.qxy += more.qxy, sums.qyy += more.qyy;
  }
  Total total = add_lanes(sums);
  if (total.mine >= 0) totals[order[k] * SUMS + total.mine] = total.value;
}

// One block per tile, one thread per pixel; slots start at 0.
KERNEL(MANY, 4)
mgs_contributions(GIVEN View view, const Splat* splats, GIVEN Lists lists, float2* slots,
                  int* winner, float* alpha) {
  measure_contributions(view, splats, lists, slots, winner, alpha);
}

// One warp per Gaussian, in the order of its slots: adds up its shares and counts its pixels.
KERNEL(MANY, 4)
mgs_contributions_gather(int n, const int64* order, const int64* ends, const float2* slots,
                         float* weights, int* touched) {
  int64 k = (int64)blockIdx.x * (MANY / WARP) + warp_of_thread();
  if (k >= n) return;
  int64 first = k ? ends[k - 1] : 0, end = ends[k];
  float weight = 0;
  int pixels = 0;
  for (int64 slot = first + lane_of_thread(); slot < end; slot += WARP)
    weight += slots[slot].x, pixels += (int)slots[slot].y;
  weight = sum_of_lanes(weight), pixels = sum_of_lanes(pixels);
  if (lane_of_thread()) return;
  weights[order[k]] = weight, touched[order[k]] = pixels;
}

// One thread per Gaussian: from its finished sums to the gradients of the inputs.
KERNEL(MANY, 3)
mgs_finish(GIVEN View view, int n, GIVEN Inputs in, const Splat* splats, const float* totals,
           GIVEN Gradients out, int sortfree) {
  int64 i = global_thread();
  if (i >= n) return;
  Splat s = splats[i];
  if (!visible(s)) {
    for (int k = 0; k < 3; k++) out.means[3 * i + k] = out.scales[3 * i + k] = 0;
    for (int k = 0; k < 4; k++) out.quats[4 * i + k] = 0;
    for (int k = 0; k < 3 * view.sh_size; k++) out.sh[3 * view.sh_size * i + k] = 0;
    for (int k = 0; k < 2 * view.lobe_size; k++) out.lobes[2 * view.lobe_size * i + k] = 0;
    if (out.opacities) out.opacities[i] = 0;
    if (out.screen) out.screen[2 * i] = out.screen[2 * i + 1] = 0;
    return;
  }
  SplatGrad d = splat_grad(load_sums(totals + i * SUMS), s, sortfree);
  project_adjoint(view, in.means + 3 * i, in.quats + 4 * i, in.scales + 3 * i,
                  in.sh + 3 * view.sh_size * i, in.lobes + 2 * view.lobe_size * i, s, d,
                  out.means + 3 * i, out.quats + 4 * i, out.scales + 3 * i,
                  out.opacities ? out.opacities + i : nullptr, out.sh + 3 * view.sh_size * i,
                  out.lobes + 2 * view.lobe_size * i);
  if (out.screen) out.screen[2 * i] = d.x, out.screen[2 * i + 1] = d.y;
}

// One block per tile, one thread per pixel.
KERNEL(MANY, 4)
mgs_sortfree_forward(GIVEN View view, const Splat* splats, GIVEN Lists lists, GIVEN Picture out) {
  sortfree_forward<false, false>(view, splats, lists, out, nullptr);
}
KERNEL(MANY, 4)
mgs_sortfree_forward_depth(GIVEN View view, const Splat* splats, GIVEN Lists lists,
                           GIVEN Picture out) {
  sortfree_forward<true, false>(view, splats, lists, out, nullptr);
}
KERNEL(MANY, 4)
mgs_surfaces(GIVEN View view, const Splat* splats, GIVEN Lists lists, float* limits) {
  find_surfaces(view, splats, lists, limits);
}
KERNEL(MANY, 4)
mgs_two_pass_forward(GIVEN View view, const Splat* splats, GIVEN Lists lists, GIVEN Picture out,
                     const float* limits) {
  sortfree_forward<false, true>(view, splats, lists, out, limits);
}
KERNEL(MANY, 4)
mgs_two_pass_forward_depth(GIVEN View view, const Splat* splats, GIVEN Lists lists,
                           GIVEN Picture out, const float* limits) {
  sortfree_forward<true, true>(view, splats, lists, out, limits);
}
KERNEL(MANY, 4)
mgs_sorted_forward(GIVEN View view, const Splat* splats, GIVEN Lists lists, GIVEN Picture out) {
  sorted_forward<false>(view, splats, lists, out);
}
KERNEL(MANY, 4)
mgs_sorted_forward_depth(GIVEN View view, const Splat* splats, GIVEN Lists lists,
                         GIVEN Picture out) {
  sorted_forward<true>(view, splats, lists, out);
}

// One thread per pixel.
KERNEL(MANY, 4)
mgs_sortfree_pixels(GIVEN View view, const float* sums, GIVEN PictureGradients in, float4* colors,
                    float2* others) {
  sortfree_pixels<false>(view, sums, in, colors, others);
}
KERNEL(MANY, 4)
mgs_sortfree_pixels_depth(GIVEN View view, const float* sums, GIVEN PictureGradients in,
                          float4* colors, float2* others) {
  sortfree_pixels<true>(view, sums, in, colors, others);
}

// One warp per Gaussian.
KERNEL(MANY, 4)
mgs_sortfree_gather(GIVEN View view, int n, const Splat* splats, const int64* order,
                    GIVEN Asked pixels, float* totals) {
  sortfree_gather<false, false>(view, n, splats, order, pixels, totals);
}
KERNEL(MANY, 4)
mgs_sortfree_gather_depth(GIVEN View view, int n, const Splat* splats, const int64* order,
                          GIVEN Asked pixels, float* totals) {
  sortfree_gather<true, false>(view, n, splats, order, pixels, totals);
}
KERNEL(MANY, 4)
mgs_two_pass_gather(GIVEN View view, int n, const Splat* splats, const int64* order,
                    GIVEN Asked pixels, float* totals) {
  sortfree_gather<false, true>(view, n, splats, order, pixels, totals);
}
KERNEL(MANY, 4)
mgs_two_pass_gather_depth(GIVEN View view, int n, const Splat* splats, const int64* order,
                          GIVEN Asked pixels, float* totals) {
  sortfree_gather<true, true>(view, n, splats, order, pixels, totals);
}

// One block per tile, two pixels per thread.
KERNEL(WALKERS, 8)
mgs_sorted_backward(GIVEN View view, const Splat* splats, GIVEN Lists lists, const float* sums,
                    GIVEN PictureGradients in, float* slot_sums, unsigned char* slot_reached) {
  sorted_backward<false>(view, splats, lists, sums, in, slot_sums, slot_reached);
}
KERNEL(WALKERS, 8)
mgs_sorted_backward_depth(GIVEN View view, const Splat* splats, GIVEN Lists lists,
                          const float* sums, GIVEN PictureGradients in, float* slot_sums,
                          unsigned char* slot_reached) {
  sorted_backward<true>(view, splats, lists, sums, in, slot_sums, slot_reached);
}
