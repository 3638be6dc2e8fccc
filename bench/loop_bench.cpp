// What a parallel loop costs (core/thread_team.h): one with nothing in it, one over an array, one with work, and loops
// within a loop. Wall clock; the argument is the number of threads.

#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "brim/core/parallel.h"

namespace brim {
namespace {

constexpr std::size_t kBlock = 4096;

template <class F>
void measure(benchmark::State& state, const F& loop) {
  const ThreadLimit limit(static_cast<int>(state.range(0)));
  std::vector<double> x(96 * kBlock, 0.5), y(x.size(), 1.0);
  for (auto _ : state) {
    loop(x, y);
    benchmark::DoNotOptimize(y.data());
  }
}

void nothing(benchmark::State& state) {
  measure(state, [](const auto& x, auto& y) { parallel_for(64, [&](std::size_t i) { y[8 * i] = x[i]; }); });
}

void add(benchmark::State& state) {  // 70,000 numbers
  measure(state, [](const auto& x, auto& y) {
    parallel_blocks(17 * kBlock, kBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) y[i] += 1e-9 * x[i];
    });
  });
}

void roots(benchmark::State& state) {  // of 400,000 numbers
  measure(state, [](const auto& x, auto& y) {
    parallel_blocks(x.size(), kBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) y[i] += 1e-9 * std::sqrt(x[i]);
    });
  });
}

void within(benchmark::State& state) {  // 25 loops of 8 pieces each
  measure(state, [](const auto& x, auto& y) {
    parallel_for(25, [&](std::size_t k) {
      parallel_for(8, [&](std::size_t j) {
        const std::size_t begin = (8 * k + j) * kBlock / 8;
        for (std::size_t i = begin; i < begin + kBlock / 8; ++i) y[i] += 1e-9 * std::sqrt(x[i]);
      });
    });
  });
}

void threads(benchmark::internal::Benchmark* b) { b->RangeMultiplier(2)->Range(1, 16)->UseRealTime(); }

BENCHMARK(nothing)->Apply(threads);
BENCHMARK(add)->Apply(threads);
BENCHMARK(roots)->Apply(threads);
BENCHMARK(within)->Apply(threads);

}  // namespace
}  // namespace brim
