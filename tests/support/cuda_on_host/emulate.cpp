// Runs the kernels of cuda.cu on the CPU, thread by thread. The warps of a block take turns: each
// runs until it must wait for the others, so a missing barrier gives a wrong result. The order of the
// turns can be reversed. It is an error if threads of a group wait at different barriers, or for
// threads that have ended.
#include "shim.h"

#include "cuda.cu"

#include <setjmp.h>
#include <string.h>
#include <ucontext.h>

#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

Index threadIdx, blockIdx, blockDim, gridDim;

namespace {

constexpr size_t STACK = 64 << 10;
constexpr int THREADS_MAX = 256;

struct Fiber {
  ucontext_t first;  // entered once; then setjmp switches, without system calls
  jmp_buf place;
  std::vector<char> stack = std::vector<char>(STACK);
  bool started, ended;
  const char* waits_at;  // name of the barrier, or null
  Group group;
};
Fiber fibers[THREADS_MAX];
uint32_t handed_in[THREADS_MAX], handed_out[THREADS_MAX];
jmp_buf scheduler;
ucontext_t unused;
std::function<void()> body;
bool reversed = false;

[[noreturn]] void fail(const char* what, unsigned thread) {
  std::string place = "block " + std::to_string(blockIdx.x) + ", thread " + std::to_string(thread);
  throw std::runtime_error(place + " " + what);
}

void enter() {
  body();
  fibers[threadIdx.x].ended = true;
  _longjmp(scheduler, 1);
}

void resume(unsigned i) {
  Fiber& fiber = fibers[i];
  threadIdx.x = i;
  if (_setjmp(scheduler)) return;
  if (fiber.started) _longjmp(fiber.place, 1);
  fiber.started = true;
  getcontext(&fiber.first);
  fiber.first.uc_stack.ss_sp = fiber.stack.data();
  fiber.first.uc_stack.ss_size = STACK;
  fiber.first.uc_link = nullptr;
  makecontext(&fiber.first, enter, 0);
  swapcontext(&unused, &fiber.first);
}

// Resumes the threads [from, to), which must wait at one barrier. Returns false if none waits.
bool release(unsigned from, unsigned to, Group group) {
  unsigned waiting = 0;
  for (unsigned i = from; i < to; i++) waiting += fibers[i].waits_at && fibers[i].group == group;
  if (waiting == 0) return false;
  for (unsigned i = from; i < to; i++) {
    if (fibers[i].ended) fail("has ended while others wait for it", i);
    if (fibers[i].group != group) fail("waits for the block while its warp waits for it", i);
    if (strcmp(fibers[i].waits_at, fibers[from].waits_at)) fail("waits at another barrier than others", i);
  }
  memcpy(handed_out + from, handed_in + from, sizeof(uint32_t) * (to - from));
  for (unsigned i = from; i < to; i++) fibers[i].waits_at = nullptr;
  return true;
}

// Runs 32 threads until each has ended or waits for the block.
void run_warp(unsigned first) {
  do {
    for (unsigned turn = 0; turn < 32; turn++) {
      unsigned i = first + (reversed ? 31 - turn : turn);
      if (!fibers[i].ended && !fibers[i].waits_at) resume(i);
    }
  } while (release(first, first + 32, Group::WARP));
}

void run_block() {
  unsigned count = blockDim.x;
  for (unsigned i = 0; i < count; i++) {
    fibers[i].started = fibers[i].ended = false;
    fibers[i].waits_at = nullptr;
  }
  do {
    for (unsigned turn = 0; turn < count; turn += 32) run_warp(reversed ? count - 32 - turn : turn);
  } while (release(0, count, Group::BLOCK));
}

template <class... A>
std::function<void(void**)> caller(void (*kernel)(A...)) {
  return [kernel](void** arguments) {
    [&]<size_t... I>(std::index_sequence<I...>) {
      kernel(*(std::remove_const_t<A>*)arguments[I]...);
    }(std::index_sequence_for<A...>{});
  };
}

#define ENTRY(name) {#name, caller(name)}
const std::map<std::string, std::function<void(void**)>> kernels = {
    ENTRY(mgs_project),
    ENTRY(mgs_total),
    ENTRY(mgs_fill),
    ENTRY(mgs_count_digits),
    ENTRY(mgs_scatter),
    ENTRY(mgs_find_starts),
    ENTRY(mgs_write_gradients),
    ENTRY(mgs_sortfree_forward),
    ENTRY(mgs_sortfree_forward_depth),
    ENTRY(mgs_depth_moments),
    ENTRY(mgs_depth_splats),
    ENTRY(mgs_depth_pass_forward),
    ENTRY(mgs_depth_pass_forward_depth),
    ENTRY(mgs_sortfree_pixels),
    ENTRY(mgs_sortfree_pixels_depth),
    ENTRY(mgs_add_levels),
    ENTRY(mgs_add_levels_depth),
    ENTRY(mgs_reduce_levels),
    ENTRY(mgs_reduce_levels_depth),
    ENTRY(mgs_sortfree_gather),
    ENTRY(mgs_sortfree_gather_depth),
    ENTRY(mgs_depth_pass_gather),
    ENTRY(mgs_depth_pass_gather_depth),
    ENTRY(mgs_sorted_forward),
    ENTRY(mgs_sorted_forward_depth),
    ENTRY(mgs_sorted_backward),
    ENTRY(mgs_sorted_backward_depth),
    ENTRY(mgs_sorted_gather),
    ENTRY(mgs_contributions),
    ENTRY(mgs_contributions_gather),
    ENTRY(mgs_student_prepare),
    ENTRY(mgs_student_decode),
    ENTRY(mgs_student_update),
    ENTRY(mgs_student_finish),
    ENTRY(mgs_adam),
    ENTRY(mgs_photo_terms),
    ENTRY(mgs_photo_finish),
    ENTRY(mgs_photo_gradient),
    ENTRY(mgs_distill_terms),
    ENTRY(mgs_distill_finish),
    ENTRY(mgs_distill_gradient),
    ENTRY(mgs_early_rate_sums),
    ENTRY(mgs_early_rate),
    ENTRY(mgs_count_codes),
    ENTRY(mgs_rate),
    ENTRY(mgs_rate_total),
    ENTRY(mgs_count_angles), ENTRY(mgs_angle_bits),
};

}  // namespace

__attribute__((noinline)) const uint32_t* exchange(Group group, const char* what, uint32_t value) {
  unsigned me = threadIdx.x;
  handed_in[me] = value;
  fibers[me].waits_at = what, fibers[me].group = group;
  if (!_setjmp(fibers[me].place)) _longjmp(scheduler, 1);
  return handed_out + (group == Group::BLOCK ? 0 : me / 32 * 32);
}

// The bytes of a struct that Python mirrors, or 0.
extern "C" int struct_bytes(const char* name) {
  const std::map<std::string, size_t> sizes = {
      {"Student", sizeof(Student)}, {"Shared", sizeof(Shared)}, {"Trained", sizeof(Trained)},
      {"Steps", sizeof(Steps)}, {"RateTensor", sizeof(RateTensor)}, {"View", sizeof(View)},
      {"Distilled", sizeof(Distilled)}, {"SortPass", sizeof(SortPass)}, {"Lists", sizeof(Lists)},
      {"Overdraw", sizeof(Overdraw)},
  };
  auto found = sizes.find(name);
  return found == sizes.end() ? 0 : (int)found->second;
}

extern "C" void set_reversed(int value) { reversed = value; }

// Launches a kernel; `arguments` are pointers, as for cuLaunchKernel. Returns the error, or an empty
// text.
extern "C" const char* launch(const char* name, unsigned blocks, unsigned threads,
                              void** arguments) {
  static std::string message;
  auto found = kernels.find(name);
  if (found == kernels.end()) return "there is no such kernel";
  if (threads > THREADS_MAX || threads % 32) return "a block has up to 8 whole warps";
  body = [&] { found->second(arguments); };
  blockDim.x = threads, gridDim.x = blocks;
  try {
    for (blockIdx.x = 0; blockIdx.x < blocks; blockIdx.x++) run_block();
  } catch (const std::runtime_error& error) {
    message = error.what();
    return message.c_str();
  }
  return "";
}
