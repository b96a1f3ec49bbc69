// Loops on the threads of torch's OpenMP runtime, whose functions binding.py passes. The library is
// linked to no runtime: any compiler can build it, and a process has one pool of threads.
#pragma once
#include <stdint.h>

#include <algorithm>
#include <atomic>

#if defined(_WIN32)  // __kmpc_fork_call, of LLVM's and Intel's runtimes
typedef void Fork(const void* source, int32_t arguments, void (*)(int32_t*, int32_t*, void*), ...);
#else  // GOMP_parallel, of GNU's and LLVM's
typedef void Fork(void (*work)(void*), void* data, unsigned threads, unsigned flags);
#endif

// Null: one thread.
inline Fork* omp_fork = nullptr;
inline int (*omp_threads)() = nullptr;

inline int most_threads() { return omp_threads ? std::max(1, omp_threads()) : 1; }

template <class Work>
struct Loop {
  const Work& work;
  int64_t count, size;
  std::atomic<int64_t> next;
  // the only call of `work`, which compilers then inline
  __attribute__((noinline)) static void run(void* data) {
    Loop& loop = *(Loop*)data;
    for (int64_t from; (from = loop.next.fetch_add(loop.size)) < loop.count;)
      loop.work(from, std::min(loop.count, from + loop.size));
  }
};

// Calls work(from, to) for parts of [0, count), `size` each. A thread takes the next part when it
// has finished one.
template <class Work>
void parallel_for(int64_t count, int64_t size, const Work& work) {
  Loop<Work> loop{work, count, size, {0}};
  if (count <= size || !omp_fork) return Loop<Work>::run(&loop);
#if defined(_WIN32)
  // ident_t of the runtime's kmp.h: a call by a compiler, from an unknown place
  static const struct {
    int32_t reserved, flags, more[2];
    const char* place;
  } source = {0, 2, {0, 0}, ";unknown;unknown;0;0;;"};
  omp_fork(&source, 1, [](int32_t*, int32_t*, void* data) { Loop<Work>::run(data); }, &loop);
#else
  omp_fork(Loop<Work>::run, &loop, 0, 0);
#endif
}

// The same with one part for each thread, all of the same size.
template <class Work>
void parallel_parts(int64_t count, const Work& work) {
  int64_t threads = most_threads();
  parallel_for(count, (count + threads - 1) / threads, work);
}
