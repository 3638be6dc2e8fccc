#include "brim/core/parallel.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <optional>

#include "brim/core/fork_join.h"

namespace brim {

struct ThreadLimit::Control {
  std::optional<tbb::global_control> limit;
};

ThreadLimit::ThreadLimit(int threads) : control_(std::make_unique<Control>()) {
  if (threads > 0)
    control_->limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
}

ThreadLimit::~ThreadLimit() = default;

int thread_count() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void detail::share_out(std::size_t n, std::size_t grain, const void* work,
                       void (*piece)(const void*, std::size_t, std::size_t)) {
  if (thread_count() == 1) return piece(work, 0, n);
  ForkJoin edges(work);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain),
                    [&](const tbb::blocked_range<std::size_t>& r) BRIM_UNSEEN {
                      const ForkJoin::Work part(edges);
                      piece(work, r.begin(), r.end());
                    });
}

}  // namespace brim
