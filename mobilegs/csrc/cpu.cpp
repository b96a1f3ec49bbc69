// The CPU kernels behind a C interface, which render/kernels/cpu.py calls by ctypes. Threads share no
// sums: results do not depend on their number.
#include "cpu_contributions.h"
#include "cpu_sorted.h"
#include "cpu_sortfree.h"

#define EXPORT extern "C" __attribute__((visibility("default")))

EXPORT int mgs_lanes() { return LANES; }
EXPORT int mgs_view_bytes() { return sizeof(View); }
EXPORT int mgs_splat_bytes() { return sizeof(Splat); }

EXPORT void mgs_project(const View* view, int n, const Inputs* in, Splat* splats, float* radii) {
  project_all(*view, n, *in, splats, radii);
}

EXPORT void mgs_sortfree_forward(const View* view, int n, const Inputs* in, Splat* splats,
                                 float* radii, float* sums, float* image, float* alpha,
                                 float* depth) {
  project_all(*view, n, *in, splats, radii);
  bool pass = view->weighting == DEPTH_PASS;
  auto run = depth ? (pass ? sortfree_forward<true, true> : sortfree_forward<true, false>)
                   : (pass ? sortfree_forward<false, true> : sortfree_forward<false, false>);
  run(*view, n, splats, sums, image, alpha, depth);
}

EXPORT void mgs_sortfree_backward(const View* view, int n, const Inputs* in, const Splat* splats,
                                  const float* sums, const float* g_image, const float* g_alpha,
                                  const float* g_depth, const Gradients* out) {
  bool pass = view->weighting == DEPTH_PASS;
  auto run = g_depth
                 ? (pass ? sortfree_backward<true, true> : sortfree_backward<true, false>)
                 : (pass ? sortfree_backward<false, true> : sortfree_backward<false, false>);
  run(*view, n, *in, splats, sums, g_image, g_alpha, g_depth, *out);
}

// Returns the tile lists, which the backward pass needs and mgs_bins_free frees.
EXPORT void* mgs_sorted_forward(const View* view, int n, const Inputs* in, Splat* splats,
                                float* radii, float* sums, float* image, float* alpha,
                                float* depth) {
  project_all(*view, n, *in, splats, radii);
  std::vector<int> order = depth_order(n, splats);
  Bins* bins = new Bins(bin(*view, n, splats, &order));
  (depth ? sorted_forward<true> : sorted_forward<false>)(*view, *bins, splats, sums, image, alpha,
                                                         depth);
  return bins;
}

EXPORT void mgs_sorted_backward(const View* view, int n, const Inputs* in, const Splat* splats,
                                const void* bins, const float* sums, const float* g_image,
                                const float* g_alpha, const float* g_depth, const Gradients* out) {
  (g_depth ? sorted_backward<true> : sorted_backward<false>)(
      *view, n, *in, splats, *(const Bins*)bins, sums, g_image, g_alpha, g_depth, *out);
}

EXPORT void mgs_contributions(const View* view, int n, const Inputs* in, Splat* splats,
                              float* radii, float* weights, int32_t* touched, int32_t* winner,
                              float* alpha) {
  project_all(*view, n, *in, splats, radii);
  std::vector<int> order = depth_order(n, splats);
  Bins bins = bin(*view, n, splats, &order);
  measure_contributions(*view, n, bins, splats, weights, touched, winner, alpha);
}

EXPORT void mgs_bins_free(void* bins) { delete (Bins*)bins; }
