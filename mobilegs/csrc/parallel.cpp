// The threads of parallel.h: one pool for the process, which runs one loop at a time.
#include "parallel.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>

#if !defined(_WIN32)
#include <pthread.h>
#include <unistd.h>
#endif

#define EXPORT extern "C" __attribute__((visibility("default")))

namespace {

int (*threads_of_torch)() = nullptr;  // null: one thread
std::atomic<int> chosen{0};           // 0: as many as torch's

// Loops of a step mostly follow each other within less than this. With 50 us in place of it steps took
// 3 % longer; beside other programs both get their share.
constexpr std::chrono::microseconds PATIENCE{300};

// Waits without sleep until `done`; false if it takes long.
template <class Done>
bool spun(const Done& done) {
  auto end = std::chrono::steady_clock::now() + PATIENCE;
  for (int tries = 0; !done(); tries++) {
#if defined(__x86_64__) || defined(_M_X64)
    __builtin_ia32_pause();
#endif
    if (tries % 32 == 31 && std::chrono::steady_clock::now() > end) return done();
  }
  return true;
}

// condition_variable::wait, whose symbol in libstdc++ is newer than wheels may need.
void wait(std::condition_variable& condition, std::unique_lock<std::mutex>& hold) {
#if defined(_WIN32)
  condition.wait(hold);
#else
  pthread_cond_wait(condition.native_handle(), hold.mutex()->native_handle());
#endif
}

struct Pool {
  std::atomic<bool> busy{false};  // with a loop
  std::mutex guard;               // of what follows
  std::condition_variable opened, left;
  Loop* loop = nullptr;           // that threads may join
  int places = 0;                 // for threads beside the caller
  int workers = 0;                // threads that were started
  std::atomic<uint64_t> loops{0};  // so far
  std::atomic<int> inside{0};      // threads that work on `loop`

  void start(int wanted);
  void work();
  void run(Loop& mine, int helpers);
};

void Pool::start(int wanted) {
  while (workers < wanted) {
    try {
      std::thread([this] { work(); }).detach();
    } catch (const std::system_error&) {
      return;  // the system has no more: fewer threads do the same
    }
    workers++;
  }
}

void Pool::work() {
  uint64_t seen = 0;
  for (;;) {
    spun([&] { return loops.load(std::memory_order_relaxed) != seen; });
    Loop* joined = nullptr;
    {
      std::unique_lock<std::mutex> hold(guard);
      while (loops == seen) wait(opened, hold);
      seen = loops;
      if (!loop || inside >= places) continue;
      joined = loop;
      inside++;
    }
    joined->take_parts(*joined);
    std::lock_guard<std::mutex> hold(guard);
    if (--inside == 0) left.notify_one();
  }
}

void Pool::run(Loop& mine, int helpers) {
  {
    std::lock_guard<std::mutex> hold(guard);
    start(helpers);
    loop = &mine, places = helpers;
    loops++;
  }
  opened.notify_all();
  mine.take_parts(mine);
  {
    std::lock_guard<std::mutex> hold(guard);
    loop = nullptr;  // nobody joins any more
  }
  if (spun([&] { return inside == 0; })) return;
  std::unique_lock<std::mutex> hold(guard);
  while (inside != 0) wait(left, hold);
}

// Never freed: its threads end with the process. A process that was forked has none of them.
Pool& pool() {
#if defined(_WIN32)
  static Pool* only = new Pool;
  return *only;
#else
  static std::atomic<Pool*> only{new Pool};
  static std::atomic<pid_t> process{getpid()};
  pid_t before = process, now = getpid();
  if (before != now && process.compare_exchange_strong(before, now)) only = new Pool;
  return *only;
#endif
}

}  // namespace

int most_threads() {
  if (int number = chosen) return number;
  return threads_of_torch ? std::max(1, threads_of_torch()) : 1;
}

void run_on_threads(Loop& loop) {
  int helpers = (int)std::min<int64_t>(most_threads(), (loop.count + loop.size - 1) / loop.size) - 1;
  Pool& threads = pool();
  if (helpers < 1 || threads.busy.exchange(true))  // inside a loop, or beside another thread's
    return loop.take_parts(loop);
  threads.run(loop, helpers);
  threads.busy = false;
}

// binding.py calls it once, with the function of torch's OpenMP runtime that gives its threads.
EXPORT void mgs_follow_threads(int (*threads)()) { threads_of_torch = threads; }

// Sets the number of threads of loops, whatever torch's is; 0: torch's.
EXPORT void mgs_use_threads(int number) { chosen = number; }
