#include "brim/core/thread_team.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace brim::thread_team_test {
namespace {

/// More threads than most machines that test have cores: what waits for others must let them run.
constexpr int kThreads = 7;

template <class F>
void loop(ThreadTeam& team, std::size_t n, std::size_t grain, const F& f, int threads = kThreads) {
  team.run(n, grain, threads, &f, [](const void* work, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) (*static_cast<const F*>(work))(i);
  });
}

TEST(ThreadTeam, VisitsEveryIndexOnce) {
  ThreadTeam team(kThreads);
  for (const std::size_t n : {0u, 1u, 2u, 6u, 7u, 57u, 1000u, 20011u})
    for (const std::size_t grain : {1u, 16u, 5000u}) {
      std::vector<int> visits(n, 0);
      loop(team, n, grain, [&](std::size_t i) { ++visits[i]; });
      EXPECT_EQ(visits, std::vector<int>(n, 1)) << n << " by " << grain;
    }
}

TEST(ThreadTeam, PiecesAreNoShorterThanTheGrainButTheLast) {
  ThreadTeam team(kThreads);
  std::vector<std::size_t> length(1000, 0);
  team.run(1000, 30, kThreads, &length, [](const void* work, std::size_t begin, std::size_t end) {
    (*static_cast<std::vector<std::size_t>*>(const_cast<void*>(work)))[begin] = end - begin;
  });
  std::erase(length, 0u);
  EXPECT_EQ(std::accumulate(length.begin(), length.end(), std::size_t{0}), 1000u);
  EXPECT_GT(length.size(), 1u);
  for (std::size_t k = 0; k + 1 < length.size(); ++k) EXPECT_GE(length[k], 30u);
}

TEST(ThreadTeam, RunsLoopsWithinLoopsWithinLoops) {
  ThreadTeam team(kThreads);
  for (int repeat = 0; repeat < 50; ++repeat) {
    std::vector<std::atomic<int>> visits(5 * 11 * 40);
    loop(team, 5, 1, [&](std::size_t a) {
      loop(team, 11, 1,
           [&](std::size_t b) { loop(team, 40, 4, [&](std::size_t c) { ++visits[(a * 11 + b) * 40 + c]; }); });
    });
    for (const auto& v : visits) ASSERT_EQ(v, 1);
  }
}

TEST(ThreadTeam, RunsMoreOpenLoopsThanItHasPlacesFor) {
  ThreadTeam team(3);
  std::atomic<int> deepest = 0;
  struct Nest {
    ThreadTeam& team;
    std::atomic<int>& deepest;
    void down(int depth) const {
      if (depth == 100) {
        ++deepest;
        return;
      }
      loop(team, 2, 1, [&](std::size_t i) {
        if (i == 0) down(depth + 1);
      });
    }
  };
  Nest{team, deepest}.down(0);
  EXPECT_EQ(deepest, 1);
}

TEST(ThreadTeam, ServesSeveralCallersAtOnce) {
  ThreadTeam team(4);
  std::vector<std::size_t> sum(5, 0);
  std::vector<std::thread> callers;
  for (std::size_t k = 0; k < sum.size(); ++k)
    callers.emplace_back([&, k] {
      for (int repeat = 0; repeat < 200; ++repeat) {
        std::vector<std::size_t> value(100, 0);
        loop(team, value.size(), 1, [&](std::size_t i) { value[i] = i + k; });
        sum[k] += std::accumulate(value.begin(), value.end(), std::size_t{0});
      }
    });
  for (std::thread& t : callers) t.join();
  for (std::size_t k = 0; k < sum.size(); ++k) EXPECT_EQ(sum[k], 200 * (4950 + 100 * k));
}

TEST(ThreadTeam, ThrowsWhatTheFirstPieceThrewOnceAllHaveRun) {
  ThreadTeam team(kThreads);
  for (int repeat = 0; repeat < 20; ++repeat) {
    std::atomic<int> visits = 0;
    std::string thrown;
    try {
      loop(team, 50, 1, [&](std::size_t i) {
        ++visits;
        if (i == 13 || i == 14 || i == 40) throw std::runtime_error(std::to_string(i));
      });
    } catch (const std::runtime_error& e) {
      thrown = e.what();
    }
    EXPECT_EQ(thrown, "13");
    EXPECT_EQ(visits, 50);
    // And is as good as new.
    visits = 0;
    loop(team, 50, 1, [&](std::size_t) { ++visits; });
    EXPECT_EQ(visits, 50);
  }
}

TEST(ThreadTeam, LetsNoMoreThreadsTakePartThanAsked) {
  ThreadTeam team(kThreads);
  for (const int threads : {1, 2, 3}) {
    std::mutex mutex;
    std::set<std::thread::id> seen;
    loop(
        team, 60, 1,
        [&](std::size_t) {
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
          const std::lock_guard lock(mutex);
          seen.insert(std::this_thread::get_id());
        },
        threads);
    EXPECT_LE(seen.size(), static_cast<std::size_t>(threads));
    if (threads > 1) {
      EXPECT_GT(seen.size(), 1u);
    }
  }
}

TEST(ThreadTeam, WakesThreadsThatHaveGoneToSleep) {
  ThreadTeam team(4);
  for (int repeat = 0; repeat < 5; ++repeat) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    std::mutex mutex;
    std::set<std::thread::id> seen;
    // Long enough for each to be there, whatever else the machine does.
    loop(team, 400, 1, [&](std::size_t) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      const std::lock_guard lock(mutex);
      seen.insert(std::this_thread::get_id());
    });
    EXPECT_EQ(seen.size(), 4u);
  }
}

}  // namespace
}  // namespace brim::thread_team_test
