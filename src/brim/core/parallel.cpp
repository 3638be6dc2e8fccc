#include "brim/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <utility>
#include <vector>

#include "brim/core/alone.h"
#include "brim/core/profile.h"
#include "brim/core/stopwatch.h"
#include "brim/core/thread_team.h"

namespace brim {

namespace {

/// The limits that live, and the least of them.
struct Limits {
  std::mutex changing;
  std::vector<int> all;
  std::atomic<int> least{0};  ///< 0: none

  void add(int threads) {
    const std::lock_guard lock(changing);
    all.push_back(threads);
    least = *std::ranges::min_element(all);
  }
  void remove(int threads) {
    const std::lock_guard lock(changing);
    all.erase(std::ranges::find(all, threads));
    least = all.empty() ? 0 : *std::ranges::min_element(all);
  }
};

/// Never destroyed: a limit that lives as long as the program may end after whatever is made later.
Limits& limits() {
  static Limits& limits = *new Limits;
  return limits;
}

thread_local bool alone = false;

/// Adds up the time of loops that are not within others.
thread_local double seconds_in_loops = 0.0;
thread_local bool in_loop = false;

void share(std::size_t n, std::size_t grain, const void* work, void (*piece)(const void*, std::size_t, std::size_t)) {
  if (alone || thread_count() == 1) return piece(work, 0, n);
  ThreadTeam::shared().run(n, grain, thread_count(), work, piece);
}

}  // namespace

double loop_seconds() { return seconds_in_loops; }

ThreadLimit::ThreadLimit(int threads) : threads_(threads) {
  if (threads_ > 0) limits().add(threads_);
}

ThreadLimit::~ThreadLimit() {
  if (threads_ > 0) limits().remove(threads_);
}

int thread_count() {
  const int least = limits().least.load(std::memory_order_relaxed);
  return least > 0 ? least : ThreadTeam::cores();
}

int thread_number() { return ThreadTeam::number(); }

void run_alone(const std::function<void()>& f) {
  struct Alone {
    bool before = std::exchange(alone, true);
    ~Alone() { alone = before; }
  } here;
  f();
}

void detail::share_out(std::size_t n, std::size_t grain, const void* work,
                       void (*piece)(const void*, std::size_t, std::size_t)) {
  if (in_loop || !brim::profile_on()) return share(n, grain, work, piece);
  struct Inside {
    Inside() { in_loop = true; }
    ~Inside() { in_loop = false; }
  } inside;
  const ScopedSeconds timer(seconds_in_loops);
  share(n, grain, work, piece);
}

}  // namespace brim
