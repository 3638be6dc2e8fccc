#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace brim {

/// Limits the number of worker threads for as long as it lives.
class ThreadLimit {
 public:
  /// @param threads  >= 1; 0 leaves the default (all cores)
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  int threads_;
};

/// Number of threads that parallel_for may use now.
int thread_count();
/// Index of this thread in the thread team; 0 for every thread that calls loops from outside the team.
int thread_number();

/// [s] that this thread has spent in parallel loops while the profile was on: the time that other threads may share.
/// Nested loops count once.
double loop_seconds();

namespace detail {
/// Calls piece(work, begin, end) from several threads for ranges that partition [0, n). With more than one range each
/// has at least `grain` items. Behind pointers, so that a loop compiles to a single call.
void share_out(std::size_t n, std::size_t grain, const void* work,
               void (*piece)(const void* work, std::size_t begin, std::size_t end));
}  // namespace detail

/// Calls f(i) for i in [0, n), in any order and on any thread. f must write only what belongs to i.
template <class F>
void parallel_for(std::size_t n, const F& f, std::size_t grain = 1) {
  if (n <= grain) {
    for (std::size_t i = 0; i < n; ++i) f(i);
    return;
  }
  detail::share_out(n, grain, &f, [](const void* work, std::size_t begin, std::size_t end) {
    const F& call = *static_cast<const F*>(work);
    for (std::size_t i = begin; i < end; ++i) call(i);
  });
}

/// Calls f(begin, end) on fixed blocks of [0, n); the blocks do not depend on the number of threads.
template <class F>
void parallel_blocks(std::size_t n, std::size_t block, const F& f) {
  const std::size_t count = (n + block - 1) / block;
  parallel_for(count, [&](std::size_t b) { f(b * block, std::min(n, (b + 1) * block)); });
}

/// Sum of f(begin, end) over fixed blocks, added in block order: the same bits for any number of threads.
template <class F>
double ordered_sum(std::size_t n, const F& f, std::size_t block = 4096) {
  const std::size_t count = (n + block - 1) / block;
  if (count == 0) return 0.0;
  if (count == 1) return f(std::size_t{0}, n);
  std::vector<double> part(count);
  parallel_for(count, [&](std::size_t b) { part[b] = f(b * block, std::min(n, (b + 1) * block)); });
  double sum = 0.0;
  for (double p : part) sum += p;
  return sum;
}

}  // namespace brim
