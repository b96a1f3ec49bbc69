// Tile lists in CUDA: the Gaussians that each tile visits, by index or, for sorted blending, front
// first. Every Gaussian writes an entry per tile; then the entries are sorted by tile. Sorted
// blending sorts the Gaussians by depth before. The sort is a stable radix sort: a pass per digit,
// of two kernels. Lengths stay on the device: kernels read `length`, and do nothing if the entries
// have no room.
#pragma once
#include "cuda_common.h"

namespace {

constexpr int DIGITS = 256;  // values of the largest digit
constexpr int PER_THREAD = 8;
constexpr int PART = THREADS * PER_THREAD;  // items that a block sorts at a time

// One pass of the sort, by the digit of `bits` bits (1 to 8) from bit `shift` on; cuda.py mirrors
// the fields. Each block takes a run of whole parts.
struct SortPass {
  const int *keys, *values;  // of the items; without values, an item's is its number
  int *sorted_keys, *sorted_values;
  int* counts;          // [blocks][1 << bits]: items of each digit in a block's run
  const int64* length;  // number of items; null: `room`
  int room, shift, bits;
};

// A number with the order of the floats, as keys are sorted: bits without a sign.
MGS_FN int sortable(float x) {
  int bits = __float_as_int(x);
  return bits ^ (bits >> 31 | FIRST);
}

struct Run {
  int first, end;  // of the block's items
  int used;        // blocks that have items
};

MGS_FN Run run_of(const SortPass& p) {
  int64 count = p.length ? listed(*p.length, p.room) : p.room;
  int64 parts = (count + PART - 1) / PART;
  int64 size = (parts + gridDim.x - 1) / gridDim.x * PART, first = size * blockIdx.x;
  int64 end = first + size < count ? first + size : count;
  return {(int)(first < end ? first : end), (int)end, size ? (int)((count + size - 1) / size) : 0};
}

MGS_FN int digit_of(const SortPass& p, int key) { return key >> p.shift & ((1 << p.bits) - 1); }

// Number of the item that a thread takes in turn k. A warp's items are neighbours.
MGS_FN int item_of(int first, int k) {
  return first + (warp_of_thread() * PER_THREAD + k) * WARP + lane_of_thread();
}

MGS_FN void clear(int (*counts)[DIGITS]) {
  for (int k = threadIdx.x; k < WARPS * DIGITS; k += THREADS) counts[k / DIGITS][k % DIGITS] = 0;
}

// Reads the keys of a part, adds its items to the `counts` of each warp's digits, and finds their
// ranks among the items of the same warp and digit.
MGS_FN void rank_items(const SortPass& p, int first, int end, int (*counts)[DIGITS], int* keys,
                       int* ranks) {
  int *own = counts[warp_of_thread()], lane = lane_of_thread();
  UNROLL
  for (int k = 0; k < PER_THREAD; k++) {
    int i = item_of(first, k);
    keys[k] = i < end ? p.keys[i] : 0;
  }
  UNROLL
  for (int k = 0; k < PER_THREAD; k++) {
    bool given = item_of(first, k) < end;
    int digit = digit_of(p, keys[k]);
    unsigned same = __ballot_sync(ALL, given);  // lanes with the same digit
    for (int b = 0; b < p.bits; b++) {
      unsigned ones = __ballot_sync(ALL, digit >> b & 1);
      same &= digit >> b & 1 ? ones : ~ones;
    }
    ranks[k] = own[digit] + __popc(same & ((1u << lane) - 1));
    __syncwarp();
    if (given && same >> lane == 1) own[digit] += __popc(same);  // the last of them
    __syncwarp();
  }
}

// Sets, for each digit, the place of the block's first item: behind all smaller digits, and behind
// the same digit in earlier blocks. `scratch` has two numbers per thread.
MGS_FN void find_places(const SortPass& p, const Run& run, int* scratch, int* places) {
  int digits = 1 << p.bits, me = threadIdx.x, all = 0, before = 0;
  // all threads read: consecutive ones consecutive digits, then blocks
  for (int block = me >> p.bits; block < run.used; block += THREADS >> p.bits) {
    int count = p.counts[(block << p.bits) + (me & (digits - 1))];
    all += count;
    if (block < (int)blockIdx.x) before += count;
  }
  scratch[me] = all, scratch[THREADS + me] = before;
  __syncthreads();
  all = before = 0;
  if (me < digits)
    for (int k = me; k < THREADS; k += digits) all += scratch[k], before += scratch[THREADS + k];
  int smaller = sum_before(all).before;
  if (me < digits) places[me] = smaller + before;
}

// Sorts the parts of the block's run one after the other in shared memory, so that items of one
// digit are written side by side.
MGS_FN void scatter_items(const SortPass& p) {
  __shared__ int counts[WARPS][DIGITS], starts[DIGITS], places[DIGITS];
  __shared__ int staged_keys[PART], staged_values[PART];
  Run run = run_of(p);
  if (run.first == run.end) return;
  int me = threadIdx.x, digits = 1 << p.bits;
  find_places(p, run, staged_keys, places);
  for (int first = run.first; first < run.end; first += PART) {
    int keys[PER_THREAD], ranks[PER_THREAD], total = 0;
    clear(counts);
    __syncthreads();  // and all threads have read what was staged before
    rank_items(p, first, run.end, counts, keys, ranks);
    __syncthreads();
    if (me < digits)
      for (int w = 0; w < WARPS; w++) {
        int count = counts[w][me];
        counts[w][me] = total;
        total += count;
      }
    int start = sum_before(total).before;
    if (me < digits) starts[me] = start;
    __syncthreads();
    UNROLL
    for (int k = 0; k < PER_THREAD; k++) {
      int i = item_of(first, k), digit = digit_of(p, keys[k]);
      if (i >= run.end) continue;
      int at = starts[digit] + counts[warp_of_thread()][digit] + ranks[k];
      staged_keys[at] = keys[k];
      staged_values[at] = p.values ? p.values[i] : i;
    }
    __syncthreads();
    for (int at = me; at < PART && at < run.end - first; at += THREADS) {
      int key = staged_keys[at], digit = digit_of(p, key);
      int place = places[digit] + at - starts[digit];
      p.sorted_keys[place] = key;
      p.sorted_values[place] = staged_values[at];
    }
    __syncthreads();
    if (me < digits) places[me] += total;
  }
}

// Adds the numbers of entries of all groups, and of those before group `first`.
MGS_FN void add_groups(const int* groups, int count, int first, int64& all, int64& before) {
  __shared__ int64 sums[2][THREADS];
  int me = threadIdx.x;
  all = before = 0;
  for (int g = me; g < count; g += THREADS) {
    all += groups[g];
    if (g < first) before += groups[g];
  }
  sums[0][me] = all, sums[1][me] = before;
  for (int half = THREADS / 2; half; half /= 2) {
    __syncthreads();
    if (me >= half) continue;
    for (int k = 0; k < 2; k++) sums[k][me] += sums[k][me + half];
  }
  __syncthreads();
  all = sums[0][0], before = sums[1][0];
}

}  // namespace

// Counts the items of each digit in the run of each block.
KERNEL(THREADS, 4)
mgs_count_digits(PARAM SortPass p) {
  __shared__ int counts[WARPS][DIGITS];
  Run run = run_of(p);
  if (run.first == run.end) return;
  clear(counts);
  __syncthreads();
  for (int first = run.first; first < run.end; first += PART) {
    int keys[PER_THREAD], ranks[PER_THREAD];
    rank_items(p, first, run.end, counts, keys, ranks);
  }
  __syncthreads();
  int digits = 1 << p.bits, me = threadIdx.x, total = 0;
  if (me >= digits) return;
  for (int w = 0; w < WARPS; w++) total += counts[w][me];
  p.counts[blockIdx.x * digits + me] = total;
}
KERNEL(THREADS, 4)
mgs_scatter(PARAM SortPass p) { scatter_items(p); }

// One thread per Gaussian, in `order`: the number of entries of each group of THREADS.
KERNEL(THREADS, 4)
mgs_total(int n, const int* order, const int* touched, int* groups) {
  int64 k = global_thread();
  int total = sum_before(k < n ? touched[order[k]] : 0).total;
  if (threadIdx.x == 0) groups[blockIdx.x] = total;
}

// One thread per Gaussian, in `order`, or by index if it is null; each block takes a run of groups.
// Writes the number of all entries, and each Gaussian's tiles and index to its entries, as many as
// mgs_project counted. Sorted blending also needs the `ends` of these.
KERNEL(THREADS, 4)
mgs_fill(PARAM View view, int n, int room, const Splat* splats, const int* order,
         const int* touched, const int* groups, int64* length, int64* ends, int* tiles, int* ids) {
  int count = (n + THREADS - 1) / THREADS, size = (count + gridDim.x - 1) / gridDim.x;
  int first = blockIdx.x * size, end = first + size < count ? first + size : count;
  int64 all, before;
  add_groups(groups, count, first, all, before);
  if (blockIdx.x == 0 && threadIdx.x == 0) *length = all;
  for (int g = first; g < end; g++) {
    int k = g * THREADS + threadIdx.x, i = k < n && order ? order[k] : k;
    BlockSum sum = sum_before(k < n ? touched[i] : 0);
    int64 slot = before + sum.before, slots_end = slot + (k < n ? touched[i] : 0);
    before += sum.total;
    if (ends && k < n) ends[k] = slots_end;
    if (all > room || slot == slots_end) continue;
    Splat s = splats[i];
    int id = i | FIRST;
    for_tiles(s, grid_of(view, s.level), [&](int tile) {
      if (slot == slots_end) return;
      tiles[slot] = tile, ids[slot] = id;
      slot++, id = i;
    });
    for (; slot < slots_end; slot++) tiles[slot] = tile_count(view), ids[slot] = id, id = i;  // of no tile
  }
}

// One thread per tile, and one more: where each tile's entries begin among the sorted ones. With
// `slots`, gathers the ids of all entries.
KERNEL(THREADS, 4)
mgs_find_starts(int tiles, int room, const int* sorted_tiles, const int64* length,
                const int* slots, const int* ids, int* starts, int* sorted_ids) {
  int64 me = global_thread(), count = listed(*length, room);
  if (me <= tiles) {
    int low = 0, high = (int)count;
    while (low < high) {
      int middle = low + (high - low) / 2;
      bool before = sorted_tiles[middle] < me;
      low = before ? middle + 1 : low, high = before ? high : middle;
    }
    starts[me] = low;
  }
  if (!slots) return;
  for (int64 e = me; e < count; e += (int64)gridDim.x * THREADS) sorted_ids[e] = ids[slots[e]];
}
