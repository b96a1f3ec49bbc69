// The CUDA kernels, compiled by NVRTC at first use and launched by render/kernels/cuda.py. One
// thread per pixel or Gaussian, or one warp per Gaussian; the arithmetic is in core.h and pairs.h.
// No atomics: every sum has a fixed order, so equal inputs give equal bits. Tests compile the
// kernels for two generations of GPUs and emulate them thread by thread on a CPU; none has run on a
// GPU yet.
#include "cuda_contributions.h"
#include "cuda_sorted.h"
#include "cuda_sortfree.h"

// `blocks` share a multiprocessor: 4 blocks leave 64 registers per thread. Without this bound,
// ptxas spills registers of some kernels to fit one more block.
#define KERNEL(threads, blocks) extern "C" __global__ void __launch_bounds__(threads, blocks)
#define PARAM const __grid_constant__  // structs stay in the constant bank

// One thread per Gaussian. Writes the number of tiles that it touches, and the tile of its box's
// centre, which is the number of all tiles if it is not visible.
KERNEL(THREADS, 4)
mgs_project(PARAM View view, int n, PARAM Inputs in, Splat* splats, float* radii, int* counts,
            int* center_tiles) {
  int64 i = global_thread();
  if (i >= n) return;
  Splat s = {};
  bool shown = project(view, in.means + 3 * i, in.quats + 4 * i, in.scales + 3 * i,
                      in.opacities ? in.opacities[i] : 0.0f, in.sh + sh_floats(view) * i,
                      in.lobes + 2 * view.lobe_size * i, s);
  int touched = 0, tile = tile_count(view);
  if (shown) {
    Grid grid = grid_of(view, s.level);
    for_tiles(s, grid, [&](int) { touched++; });
    tile = center_tile(s, grid);
  }
  splats[i] = s;
  radii[i] = shown ? radius_of(s) : 0.0f;
  counts[i] = touched;
  center_tiles[i] = tile;
}

// One thread per Gaussian, in `order`, or by index if it is null. Writes its tiles and its index to
// its slots [ends[k - 1], ends[k]). The compiler may round for_tiles differently here than in
// mgs_project and disagree on a tile that the ellipse just touches: no entry leaves the slots, and
// an unused slot gets the tile after the last, which is not rendered.
KERNEL(THREADS, 4)
mgs_fill(PARAM View view, int n, const Splat* splats, const int64* order, const int64* ends,
         int* tiles, int* ids) {
  int64 k = global_thread();
  if (k >= n) return;
  int64 i = order ? order[k] : k, slot = k ? ends[k - 1] : 0, end = ends[k];
  if (slot == end) return;
  Splat s = splats[i];
  for_tiles(s, grid_of(view, s.level), [&](int tile) {
    if (slot == end) return;
    tiles[slot] = tile;
    ids[slot++] = (int)i;
  });
  for (; slot < end; slot++) tiles[slot] = tile_count(view), ids[slot] = (int)i;
}

// One warp per Gaussian, in the order of the slots: adds the slots that were reached.
KERNEL(THREADS, 4)
mgs_sorted_gather(int n, const int64* order, const int64* ends, const float* slot_sums,
                  const unsigned char* slot_reached, float* totals) {
  int64 k = (int64)blockIdx.x * (THREADS / WARP) + warp_of_thread();
  if (k >= n) return;
  int64 first = k ? ends[k - 1] : 0, end = ends[k];
  Sums<float> sums = {};
#pragma unroll 1  // few have more than 32 slots; fewer registers leave room for more warps
  for (int64 slot = first + lane_of_thread(); slot < end; slot += WARP) {
    if (!slot_reached[slot]) continue;
    Sums<float> more = load_sums(slot_sums + slot * SUMS);
    sums.r += more.r, sums.g += more.g, sums.b += more.b, sums.z += more.z, sums.w += more.w;
    sums.q += more.q, sums.qx += more.qx, sums.qy += more.qy;
    sums.qxx += more.qxx, sums.qxy += more.qxy, sums.qyy += more.qyy, sums.c += more.c;
  }
  Total total = add_lanes(sums);
  if (total.component >= 0) totals[order[k] * SUMS + total.component] = total.value;
}

// One block per tile, one thread per pixel; slots start at 0.
KERNEL(THREADS, 4)
mgs_contributions(PARAM View view, const Splat* splats, PARAM Lists lists, float2* slots,
                  int* winner, float* alpha) {
  measure_contributions(view, splats, lists, slots, winner, alpha);
}

// One warp per Gaussian, in the order of the slots: adds its shares and counts its pixels.
KERNEL(THREADS, 4)
mgs_contributions_gather(int n, const int64* order, const int64* ends, const float2* slots,
                         float* weights, int* touched) {
  int64 k = (int64)blockIdx.x * (THREADS / WARP) + warp_of_thread();
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
KERNEL(THREADS, 3)
mgs_write_gradients(PARAM View view, int n, PARAM Inputs in, const Splat* splats,
                    const float* totals, PARAM Gradients out, int sortfree) {
  int64 i = global_thread();
  if (i >= n) return;
  Splat s = splats[i];
  if (!visible(s)) {
    for (int k = 0; k < 3; k++) out.means[3 * i + k] = out.scales[3 * i + k] = 0;
    for (int k = 0; k < 4; k++) out.quats[4 * i + k] = 0;
    for (int k = 0; k < sh_floats(view); k++) out.sh[sh_floats(view) * i + k] = 0;
    for (int k = 0; k < 2 * view.lobe_size; k++) out.lobes[2 * view.lobe_size * i + k] = 0;
    if (out.opacities) out.opacities[i] = 0;
    if (out.screen) out.screen[2 * i] = out.screen[2 * i + 1] = 0;
    return;
  }
  SplatGrad d = splat_grad(load_sums(totals + i * SUMS), s, sortfree);
  project_adjoint(view, in.means + 3 * i, in.quats + 4 * i, in.scales + 3 * i,
                  in.opacities ? in.opacities[i] : 0.0f, in.sh + sh_floats(view) * i,
                  in.lobes + 2 * view.lobe_size * i, s, d, out.means + 3 * i, out.quats + 4 * i,
                  out.scales + 3 * i, out.opacities ? out.opacities + i : nullptr,
                  out.sh + sh_floats(view) * i, out.lobes + 2 * view.lobe_size * i);
  if (out.screen) out.screen[2 * i] = d.x, out.screen[2 * i + 1] = d.y;
}

// One block per tile, one thread per pixel.
KERNEL(THREADS, 4)
mgs_sortfree_forward(PARAM View view, const Splat* splats, PARAM Lists lists, PARAM Outputs out) {
  sortfree_forward<false, false>(view, splats, lists, out, nullptr);
}
KERNEL(THREADS, 4)
mgs_sortfree_forward_depth(PARAM View view, const Splat* splats, PARAM Lists lists,
                           PARAM Outputs out) {
  sortfree_forward<true, false>(view, splats, lists, out, nullptr);
}
KERNEL(THREADS, 4)
mgs_surfaces(PARAM View view, const Splat* splats, PARAM Lists lists, float* limits) {
  find_surfaces(view, splats, lists, limits);
}
KERNEL(THREADS, 4)
mgs_two_pass_forward(PARAM View view, const Splat* splats, PARAM Lists lists, PARAM Outputs out,
                     const float* limits) {
  sortfree_forward<false, true>(view, splats, lists, out, limits);
}
KERNEL(THREADS, 4)
mgs_two_pass_forward_depth(PARAM View view, const Splat* splats, PARAM Lists lists,
                           PARAM Outputs out, const float* limits) {
  sortfree_forward<true, true>(view, splats, lists, out, limits);
}
KERNEL(THREADS, 4)
mgs_sorted_forward(PARAM View view, const Splat* splats, PARAM Lists lists, PARAM Outputs out) {
  sorted_forward<false>(view, splats, lists, out);
}
KERNEL(THREADS, 4)
mgs_sorted_forward_depth(PARAM View view, const Splat* splats, PARAM Lists lists,
                         PARAM Outputs out) {
  sorted_forward<true>(view, splats, lists, out);
}

// One thread per pixel.
KERNEL(THREADS, 4)
mgs_sortfree_pixels(PARAM View view, const float* sums, PARAM OutputGradients in, float4* colors,
                    float2* others) {
  sortfree_pixels<false>(view, sums, in, colors, others);
}
KERNEL(THREADS, 4)
mgs_sortfree_pixels_depth(PARAM View view, const float* sums, PARAM OutputGradients in,
                          float4* colors, float2* others) {
  sortfree_pixels<true>(view, sums, in, colors, others);
}

// One thread per pixel of the finer or, in the backward pass, of the coarser level.
KERNEL(THREADS, 4)
mgs_add_enlarged(PARAM View view, int level, PARAM Outputs out) {
  add_enlarged<false>(view, level, out);
}
KERNEL(THREADS, 4)
mgs_add_enlarged_depth(PARAM View view, int level, PARAM Outputs out) {
  add_enlarged<true>(view, level, out);
}
KERNEL(THREADS, 4)
mgs_reduce_gradients(PARAM View view, int level, const float* own, float4* colors,
                     float2* others) {
  reduce_gradients(view, level, own, colors, others);
}
KERNEL(THREADS, 4)
mgs_finish_gradients(PARAM View view, const float* sums, float2* others) {
  finish_gradients(view, sums, others);
}

// One warp per Gaussian.
KERNEL(THREADS, 4)
mgs_sortfree_gather(PARAM View view, int n, const Splat* splats, const int64* order,
                    PARAM PixelGradients pixels, float* totals) {
  sortfree_gather<false, false>(view, n, splats, order, pixels, totals);
}
KERNEL(THREADS, 4)
mgs_sortfree_gather_depth(PARAM View view, int n, const Splat* splats, const int64* order,
                          PARAM PixelGradients pixels, float* totals) {
  sortfree_gather<true, false>(view, n, splats, order, pixels, totals);
}
KERNEL(THREADS, 4)
mgs_two_pass_gather(PARAM View view, int n, const Splat* splats, const int64* order,
                    PARAM PixelGradients pixels, float* totals) {
  sortfree_gather<false, true>(view, n, splats, order, pixels, totals);
}
KERNEL(THREADS, 4)
mgs_two_pass_gather_depth(PARAM View view, int n, const Splat* splats, const int64* order,
                          PARAM PixelGradients pixels, float* totals) {
  sortfree_gather<true, true>(view, n, splats, order, pixels, totals);
}

// One block per tile, two pixels per thread.
KERNEL(WALK_THREADS, 8)
mgs_sorted_backward(PARAM View view, const Splat* splats, PARAM Lists lists, const float* sums,
                    PARAM OutputGradients in, float* slot_sums, unsigned char* slot_reached) {
  sorted_backward<false>(view, splats, lists, sums, in, slot_sums, slot_reached);
}
KERNEL(WALK_THREADS, 8)
mgs_sorted_backward_depth(PARAM View view, const Splat* splats, PARAM Lists lists,
                          const float* sums, PARAM OutputGradients in, float* slot_sums,
                          unsigned char* slot_reached) {
  sorted_backward<true>(view, splats, lists, sums, in, slot_sums, slot_reached);
}
