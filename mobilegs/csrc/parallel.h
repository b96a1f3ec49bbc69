// Loops on threads of the library's own, which wait for nobody that has not begun: beside other
// programs a thread may come late or never, and the others do its part.
#pragma once
#include <stdint.h>

#include <algorithm>
#include <atomic>

// The number of threads of a loop, its caller among them; at least 1.
int most_threads();

// A loop whose threads take parts of [0, count), `size` each, until none is left.
struct Loop {
  void (*take_parts)(Loop&);
  int64_t count, size;
  std::atomic<int64_t> next{0};
};

// Runs a loop on the calling thread and on those of the library that are free.
void run_on_threads(Loop& loop);

template <class Work>
struct LoopOf : Loop {
  const Work& work;
  // the only call of `work`, which compilers then inline
  __attribute__((noinline)) static void take(Loop& loop) {
    const Work& work = static_cast<LoopOf&>(loop).work;
    for (int64_t from; (from = loop.next.fetch_add(loop.size)) < loop.count;)
      work(from, std::min(loop.count, from + loop.size));
  }
  LoopOf(int64_t count, int64_t size, const Work& work)
      : Loop{LoopOf::take, count, size}, work(work) {}
};

// Calls work(from, to) for parts of [0, count), `size` each, in any order.
template <class Work>
void parallel_for(int64_t count, int64_t size, const Work& work) {
  LoopOf<Work> loop(count, size, work);
  if (count <= size)
    LoopOf<Work>::take(loop);
  else
    run_on_threads(loop);
}

// The same with some parts for each thread.
template <class Work>
void parallel_parts(int64_t count, const Work& work) {
  int64_t parts = most_threads() > 1 ? 4 * most_threads() : 1;
  parallel_for(count, std::max<int64_t>(1, (count + parts - 1) / parts), work);
}
