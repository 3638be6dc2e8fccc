#include "brim/core/parallel.h"

#include <gtest/gtest.h>

#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include "brim/core/profile.h"

namespace brim::parallel_test {
namespace {

// Numbers of very different size, so that a different order of addition shows in the last bits.
std::vector<double> wild_numbers(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-40, 40);
  std::vector<double> values(n);
  for (double& value : values) value = std::ldexp(mantissa(random), exponent(random));
  return values;
}

double sum_range(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  double sum = 0.0;
  for (std::size_t i = begin; i < end; ++i) sum += values[i];
  return sum;
}

TEST(OrderedSum, AddsOneToHundred) {
  const auto integers = [](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += static_cast<double>(i + 1);
    return sum;
  };
  EXPECT_EQ(ordered_sum(100, integers), 5050.0);     // one block
  EXPECT_EQ(ordered_sum(100, integers, 7), 5050.0);  // fifteen blocks, the last one short
}

TEST(OrderedSum, OfNothingIsZeroAndCallsNothing) {
  EXPECT_EQ(ordered_sum(0, [](std::size_t, std::size_t) { return std::nan(""); }), 0.0);
}

TEST(OrderedSum, HasTheSameBitsForOneTwoAndFourThreads) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  const std::vector<double> values = wild_numbers(100'003, seed);
  const std::size_t block = 64;

  // Independent reference: the blocks added one after the other, without threads.
  double expected = 0.0;
  for (std::size_t b = 0; b < values.size(); b += block)
    expected += sum_range(values, b, std::min(values.size(), b + block));

  for (int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    for (int repeat = 0; repeat < 5; ++repeat) {
      const double sum = ordered_sum(
          values.size(), [&](std::size_t begin, std::size_t end) { return sum_range(values, begin, end); }, block);
      EXPECT_EQ(std::bit_cast<std::uint64_t>(sum), std::bit_cast<std::uint64_t>(expected)) << threads << " threads";
    }
  }
}

TEST(ParallelFor, VisitsEveryIndexOnce) {
  for (std::size_t n : {0u, 1u, 2u, 1000u}) {
    for (std::size_t grain : {1u, 16u, 5000u}) {
      std::vector<int> visits(n, 0);
      parallel_for(
          n, [&](std::size_t i) { ++visits[i]; }, grain);
      EXPECT_EQ(visits, std::vector<int>(n, 1)) << "n " << n << ", grain " << grain;
    }
  }
}

TEST(ParallelBlocks, AreFixedAndCoverTheRangeForAnyNumberOfThreads) {
  for (int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    std::vector<std::size_t> end_of(1000, 0);
    parallel_blocks(1000, 300, [&](std::size_t begin, std::size_t end) { end_of[begin] = end; });
    std::vector<std::size_t> expected(1000, 0);
    expected[0] = 300;
    expected[300] = 600;
    expected[600] = 900;
    expected[900] = 1000;
    EXPECT_EQ(end_of, expected);
  }
}

TEST(ParallelFor, HandsAnExceptionToTheCaller) {
  EXPECT_THROW(parallel_for(100,
                            [](std::size_t i) {
                              if (i == 42) throw std::runtime_error("42");
                            }),
               std::runtime_error);
}

TEST(ThreadLimit, HoldsAsLongAsItLivesAndTheTighterOneWins) {
  const int before = thread_count();
  {
    const ThreadLimit two(2);
    EXPECT_EQ(thread_count(), 2);
    {
      const ThreadLimit one(1);
      EXPECT_EQ(thread_count(), 1);
    }
    EXPECT_EQ(thread_count(), 2);
    const ThreadLimit default_limit(0);
    EXPECT_EQ(thread_count(), 2);
  }
  EXPECT_EQ(thread_count(), before);
}

TEST(ThreadLimit, OfOneKeepsTheWorkOnTheCallingThread) {
  const ThreadLimit one(1);
  const std::thread::id caller = std::this_thread::get_id();
  std::vector<char> elsewhere(1000, 0);
  parallel_for(elsewhere.size(), [&](std::size_t i) { elsewhere[i] = std::this_thread::get_id() != caller; });
  EXPECT_EQ(elsewhere, std::vector<char>(1000, 0));
}

TEST(Parallel, TellsTheTimeInLoopsWhileTheProfileIsOn) {
  const auto wait = [] {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(5);
    while (std::chrono::steady_clock::now() < end) continue;
  };
  const auto loops = [&] {
    const double before = loop_seconds();
    wait();  // outside of loops
    parallel_for(2, [&](std::size_t) {
      wait();
      parallel_for(2, [&](std::size_t) { wait(); });  // within one: counts once
    });
    return loop_seconds() - before;
  };
  const ThreadLimit one(1);
  EXPECT_EQ(loops(), 0.0);
  set_profile(true);
  const double told = loops();
  set_profile(false);
  EXPECT_GE(told, 0.03);
  EXPECT_LT(told, 0.3);
}

}  // namespace
}  // namespace brim::parallel_test
