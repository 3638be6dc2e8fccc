#include "brim/core/thread_team.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace brim {

namespace {

constexpr std::size_t kLine = 64;  ///< [bytes] what caches exchange
/// Pieces that a loop is cut into, for each thread.
constexpr std::size_t kPieces = 8;
/// Loops that may be open at a time: one bit each. A loop that finds no place runs on its caller alone.
constexpr int kLoops = 64;
/// Looks at the open loops before a thread lets others have its core between looks, and before it looks at the clock.
constexpr int kLooks = 2000, kLooksAtClock = 16;
/// Time without work after which a thread sleeps.
constexpr std::chrono::microseconds kAwake{1000};
/// Sleeping threads that each one that has found work wakes.
constexpr int kWakes = 2;

void pause() {
#if defined(__x86_64__)
  _mm_pause();
#endif
}

/// Waits a little; for longer each time.
class Patience {
 public:
  void wait() {
    if (++looks_ < kLooks)
      pause();
    else
      std::this_thread::yield();
  }
  /// True after kAwake.
  bool ends() {
    if (looks_ < kLooks || looks_ % kLooksAtClock != 0) return false;
    const auto now = std::chrono::steady_clock::now();
    if (since_ == std::chrono::steady_clock::time_point()) since_ = now;
    return now - since_ > kAwake;
  }

 private:
  int looks_ = 0;
  std::chrono::steady_clock::time_point since_;
};

/// What the thread at hand is: its number in the team (0 for all threads that are not of it), and the loops around it.
struct Here {
  int number = 0;
  int depth = 0;
};
thread_local Here here;

}  // namespace

/// What of a range of pieces is left: the first in the upper half of the number, the end in the lower one.
struct alignas(kLine) ThreadTeam::Range {
  std::atomic<std::uint64_t> left{0};

  void set(std::uint32_t begin, std::uint32_t end) {
    left.store(std::uint64_t{begin} << 32 | end, std::memory_order_relaxed);
  }
  /// Takes a piece from the front or the back. @return false where none is left
  bool take(bool front, std::uint32_t& piece) {
    std::uint64_t now = left.load(std::memory_order_relaxed);
    while (true) {
      const auto begin = static_cast<std::uint32_t>(now >> 32), end = static_cast<std::uint32_t>(now);
      if (begin >= end) return false;
      const std::uint64_t then = front ? now + (std::uint64_t{1} << 32) : now - 1;
      if (!left.compare_exchange_weak(now, then, std::memory_order_relaxed)) continue;
      piece = front ? begin : end - 1;
      return true;
    }
  }
};

struct alignas(kLine) ThreadTeam::Loop {
  static constexpr std::uint32_t kOpen = std::uint32_t{1} << 31;

  std::atomic<std::uint32_t> users{0};  ///< who looks at it, and kOpen where the rest holds
  std::size_t n = 0, size = 0;          ///< items, and those of a piece
  const void* work = nullptr;
  Piece piece = nullptr;
  int depth = 0;
  std::atomic<int> threads{0};
  alignas(kLine) std::atomic<std::uint32_t> left{0};  ///< pieces that have not ended
  std::mutex failing;
  std::exception_ptr error;
  std::uint32_t failed = 0;  ///< the piece that threw it
  std::unique_ptr<Range[]> range;

  void call(std::uint32_t p) {
    try {
      piece(work, p * size, std::min(n, (p + 1) * size));
    } catch (...) {
      const std::lock_guard lock(failing);
      if (!error || p < failed) error = std::current_exception(), failed = p;
    }
  }
  /// Works through its own range, then through what others have left.
  void work_as(int number) {
    const int before = here.depth;
    here.depth = depth + 1;
    std::uint32_t done = 0, p = 0;
    const int all = threads.load(std::memory_order_relaxed);
    for (int k = 0; k < all; ++k) {
      Range& from = range[(number + k) % all];
      while (from.take(k == 0, p)) call(p), ++done;
    }
    here.depth = before;
    if (done > 0) left.fetch_sub(done, std::memory_order_release);
  }
};

struct alignas(kLine) ThreadTeam::Worker {
  std::atomic<std::uint32_t> asleep{0};
  std::thread thread;
};

struct ThreadTeam::Impl {
  const int size;
  std::vector<Loop> loops{kLoops};
  std::vector<Worker> workers;  ///< the first stands for callers
  std::once_flag started;
  std::atomic<bool> ending{false};
  alignas(kLine) std::atomic<std::uint64_t> open{0};   ///< loops that may have pieces left
  alignas(kLine) std::atomic<std::uint64_t> taken{0};  ///< places of loops in use
  alignas(kLine) std::atomic<int> sleepers{0};

  explicit Impl(int threads) : size(threads), workers(static_cast<std::size_t>(threads)) {
    for (Loop& loop : loops) loop.range = std::make_unique<Range[]>(workers.size());
  }
  void start() {
    for (int number = 1; number < size; ++number)
      workers[number].thread = std::thread([this, number] { live(number); });
  }
  void end() {
    ending = true;
    for (Worker& w : workers) {
      w.asleep.store(0);
      w.asleep.notify_one();
      if (w.thread.joinable()) w.thread.join();
    }
  }

  /// @return a free place, or -1
  int take_place() {
    std::uint64_t now = taken.load(std::memory_order_relaxed);
    while (true) {
      const int place = std::countr_one(now);
      if (place == kLoops) return -1;
      if (taken.compare_exchange_weak(now, now | std::uint64_t{1} << place, std::memory_order_acquire)) return place;
    }
  }

  void wake(int threads) {
    int most = kWakes;
    if (sleepers.load() == 0) return;
    for (int k = 1; k < threads && most > 0; ++k)
      if (workers[k].asleep.load() != 0 && workers[k].asleep.exchange(0) != 0) workers[k].asleep.notify_one(), --most;
  }

  /// Helps with the open loops of at least that depth. @return false where there was nothing to do
  bool help(int number, int depth) {
    bool any = false;
    for (std::uint64_t bits = open.load(std::memory_order_acquire); bits != 0; bits &= bits - 1) {
      const int place = std::countr_zero(bits);
      Loop& loop = loops[place];
      if ((loop.users.fetch_add(1, std::memory_order_acquire) & Loop::kOpen) != 0 && loop.depth >= depth &&
          number < loop.threads.load(std::memory_order_relaxed)) {
        wake(loop.threads.load(std::memory_order_relaxed));
        loop.work_as(number);
        open.fetch_and(~(std::uint64_t{1} << place), std::memory_order_relaxed);
        any = true;
      }
      loop.users.fetch_sub(1, std::memory_order_release);
    }
    return any;
  }

  /// True when a loop is open in which that thread may take part.
  bool wanted(int number) const {
    for (std::uint64_t bits = open.load(); bits != 0; bits &= bits - 1)
      if (number < loops[std::countr_zero(bits)].threads.load(std::memory_order_relaxed)) return true;
    return false;
  }

  /// What a thread of the team does for as long as the team lives.
  void live(int number) {
    here.number = number;
    std::atomic<std::uint32_t>& asleep = workers[number].asleep;
    while (!ending) {
      for (Patience patience; !ending && !patience.ends();)
        if (help(number, 0))
          patience = Patience();
        else
          patience.wait();
      sleepers.fetch_add(1);
      asleep.store(1);
      // A loop that was opened before it slept, and an end, have seen nobody to wake.
      if (!wanted(number) && !ending) asleep.wait(1);
      asleep.store(0);
      sleepers.fetch_sub(1);
    }
  }

  void run(int place, std::size_t n, std::size_t grain, int threads, const void* work, Piece piece) {
    Loop& loop = loops[place];
    const auto all = static_cast<std::size_t>(threads);
    std::size_t pieces = std::min((n + grain - 1) / grain, kPieces * all);
    loop.size = (n + pieces - 1) / pieces;
    pieces = (n + loop.size - 1) / loop.size;
    loop.n = n, loop.work = work, loop.piece = piece, loop.depth = here.depth;
    loop.threads.store(threads, std::memory_order_relaxed);
    loop.left.store(static_cast<std::uint32_t>(pieces), std::memory_order_relaxed);
    for (std::size_t t = 0; t < all; ++t)
      loop.range[t].set(static_cast<std::uint32_t>(pieces * t / all),
                        static_cast<std::uint32_t>(pieces * (t + 1) / all));
    const std::uint64_t bit = std::uint64_t{1} << place;
    loop.users.fetch_or(Loop::kOpen, std::memory_order_release);
    open.fetch_or(bit);
    wake(threads);

    loop.work_as(here.number < threads ? here.number : 0);
    open.fetch_and(~bit, std::memory_order_relaxed);
    for (Patience patience; loop.left.load(std::memory_order_acquire) != 0;)
      if (!help(here.number, here.depth + 1)) patience.wait();
    loop.users.fetch_and(~Loop::kOpen, std::memory_order_relaxed);
    for (Patience patience; loop.users.load(std::memory_order_acquire) != 0;) patience.wait();
    const std::exception_ptr error = std::exchange(loop.error, nullptr);
    taken.fetch_and(~bit, std::memory_order_release);
    if (error) std::rethrow_exception(error);
  }
};

ThreadTeam::ThreadTeam(int size) : impl_(std::make_unique<Impl>(std::max(1, size))) {}

ThreadTeam::~ThreadTeam() { impl_->end(); }

ThreadTeam& ThreadTeam::shared() {
  static ThreadTeam* const team = new ThreadTeam(cores());
  return *team;
}

int ThreadTeam::number() { return here.number; }

int ThreadTeam::cores() {
  static const int n = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return n;
}

void ThreadTeam::run(std::size_t n, std::size_t grain, int threads, const void* work, Piece piece) {
  threads = std::min(threads, impl_->size);
  const int place = threads > 1 && n > grain ? impl_->take_place() : -1;
  if (place < 0) return n > 0 ? piece(work, 0, n) : void();
  std::call_once(impl_->started, [&] { impl_->start(); });
  impl_->run(place, n, grain, threads, work, piece);
}

}  // namespace brim
