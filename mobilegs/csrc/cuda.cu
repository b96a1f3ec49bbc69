// The CUDA kernels, compiled by NVRTC at first use and launched by render/kernels/cuda.py. One
// thread per pixel or Gaussian, or one warp per Gaussian; the arithmetic is in core.h and pairs.h.
// No atomics but to count: every sum has a fixed order, so equal inputs give equal bits. Tests
// compile the kernels for two generations of GPUs and emulate them thread by thread on a CPU;
// bench/gpu tests and times them on a GPU.
#include "cuda_contributions.h"
#include "cuda_lists.h"
#include "cuda_loss.h"
#include "cuda_sorted.h"
#include "cuda_sortfree.h"
#include "cuda_student.h"
#include "cuda_terms.h"

// Returns the number of tiles that a splat touches. Without any, between pixels, its box becomes empty.
MGS_FN int count_tiles(const View& view, Splat& s) {
  int count = 0;
  if (visible(s)) for_tile_rows(s, grid_of(view, s.level), [&](int, int tiles) { count += tiles; });
  if (count == 0) s.x0 = s.x1 = s.y0 = s.y1 = 0;
  return count;
}

// One thread per Gaussian. Writes the number of tiles that it touches, the sum of each block, and for
// sorted blending numbers with the order of the depths: those of invisible Gaussians come last.
KERNEL(THREADS, 4)
mgs_project(PARAM View view, int n, PARAM Inputs in, Splat* splats, float* radii, int* touched,
            int* totals, int* depths) {
  int64 i = global_thread();
  int count = 0;
  if (i < n) {
    Projected<float> found;
    bool shown = project(view, in.means + 3 * i, in.quats + 4 * i, in.scales + 3 * i,
                         in.opacities + i, in.sh + sh_floats(view) * i,
                         more_of(view, in.sh, in.more, i), in.lobes + 2 * view.lobe_size * i, found);
    Splat s = pack(found);
    count = count_tiles(view, s);
    splats[i] = s;
    radii[i] = shown ? radius_of(found) : 0.0f;
    touched[i] = count;
    if (depths) depths[i] = count ? sortable(s.z) : -1;
  }
  int total = sum_before(count).total;
  if (threadIdx.x == 0) totals[blockIdx.x] = total;
}

// One thread per Gaussian: the same for the picture of the depth pass, from the projected splats.
KERNEL(THREADS, 4)
mgs_depth_splats(PARAM View pass, int n, const Splat* splats, Splat* coarse, int* touched,
                 int* totals) {
  int64 i = global_thread();
  int count = 0;
  if (i < n) {
    Splat s = splats[i];
    if (visible(s)) s = depth_splat(pass, s);
    count = count_tiles(pass, s);
    coarse[i] = s;
    touched[i] = count;
  }
  int total = sum_before(count).total;
  if (threadIdx.x == 0) totals[blockIdx.x] = total;
}

// One warp per Gaussian, in the order of the slots: adds the slots that were reached.
KERNEL(THREADS, 4)
mgs_sorted_gather(int n, const int* order, const int64* ends, const float* slot_sums,
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
mgs_contributions_gather(int n, const int* order, const int64* ends, const float2* slots,
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
  Projected<float> found = unpack(s);
  SplatGrad<float> d = splat_grad(load_sums(totals + i * SUMS), found, sortfree);
  project_adjoint(view, in.means + 3 * i, in.quats + 4 * i, in.scales + 3 * i, in.opacities + i,
                  more_of(view, in.sh, in.more, i), in.lobes + 2 * view.lobe_size * i, found, d, out.means + 3 * i,
                  out.quats + 4 * i, out.scales + 3 * i,
                  out.opacities ? out.opacities + i : nullptr, out.sh + sh_floats(view) * i,
                  more_of(view, out.sh, out.more, i), out.lobes + 2 * view.lobe_size * i);
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
mgs_depth_moments(PARAM View pass, const Splat* splats, PARAM Lists lists, float* moments) {
  depth_moments(pass, splats, lists, moments);
}
KERNEL(THREADS, 4)
mgs_depth_pass_forward(PARAM View view, const Splat* splats, PARAM Lists lists, PARAM Outputs out,
                     const float* moments) {
  sortfree_forward<false, true>(view, splats, lists, out, moments);
}
KERNEL(THREADS, 4)
mgs_depth_pass_forward_depth(PARAM View view, const Splat* splats, PARAM Lists lists,
                           PARAM Outputs out, const float* moments) {
  sortfree_forward<true, true>(view, splats, lists, out, moments);
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
mgs_sortfree_pixels(PARAM View view, const float* sums, PARAM OutputGradients in,
                    PARAM PixelGradients out) {
  sortfree_pixels<false>(view, sums, in, out);
}
KERNEL(THREADS, 4)
mgs_sortfree_pixels_depth(PARAM View view, const float* sums, PARAM OutputGradients in,
                          PARAM PixelGradients out) {
  sortfree_pixels<true>(view, sums, in, out);
}

// One block per tile of the image, or in the backward pass of the coarsest target.
KERNEL(THREADS, 4)
mgs_add_levels(PARAM View view, PARAM Outputs out) { add_levels<false>(view, out); }
KERNEL(THREADS, 4)
mgs_add_levels_depth(PARAM View view, PARAM Outputs out) { add_levels<true>(view, out); }
KERNEL(THREADS, 4)
mgs_reduce_levels(PARAM View view, const float* sums, PARAM PixelGradients out) {
  reduce_levels<false>(view, sums, out);
}
KERNEL(THREADS, 4)
mgs_reduce_levels_depth(PARAM View view, const float* sums, PARAM PixelGradients out) {
  reduce_levels<true>(view, sums, out);
}

// Each block takes GATHERED entries, one warp per Gaussian.
KERNEL(THREADS, 4)
mgs_sortfree_gather(PARAM View view, const Splat* splats, PARAM Lists lists,
                    PARAM PixelGradients pixels, float* totals) {
  sortfree_gather<false, false>(view, splats, lists, pixels, totals);
}
KERNEL(THREADS, 4)
mgs_sortfree_gather_depth(PARAM View view, const Splat* splats, PARAM Lists lists,
                          PARAM PixelGradients pixels, float* totals) {
  sortfree_gather<true, false>(view, splats, lists, pixels, totals);
}
KERNEL(THREADS, 3)
mgs_depth_pass_gather(PARAM View view, const Splat* splats, PARAM Lists lists,
                    PARAM PixelGradients pixels, float* totals) {
  sortfree_gather<false, true>(view, splats, lists, pixels, totals);
}
KERNEL(THREADS, 3)
mgs_depth_pass_gather_depth(PARAM View view, const Splat* splats, PARAM Lists lists,
                          PARAM PixelGradients pixels, float* totals) {
  sortfree_gather<true, true>(view, splats, lists, pixels, totals);
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
