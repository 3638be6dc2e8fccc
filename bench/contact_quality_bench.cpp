#include <benchmark/benchmark.h>

#include "support/contact_quality.h"

/// Quality of the contact force, as counters: a sphere pressed into planes of several directions. Percent.
namespace brim {
namespace {

void report(benchmark::State& state, const Vec3& n, double radius) {
  testing::ContactQuality q;
  for (auto _ : state) q = testing::contact_quality(n, 1, 64, radius);
  state.counters["tangential_mean_%"] = 100 * q.tangential_mean;
  state.counters["tangential_worst_%"] = 100 * q.tangential_worst;
  state.counters["scatter_%"] = 100 * q.scatter;
  state.counters["force_over_work"] = q.work_ratio;
  state.counters["force_over_k_h2"] = q.mean_force;
}

BENCHMARK_CAPTURE(report, tilted, Vec3(0.3, 0.2, 1), 6.0)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(report, axis, Vec3(0, 0, 1), 6.0)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(report, edge_diagonal, Vec3(0, 1, 1), 6.0)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(report, space_diagonal, Vec3(1, 1, 1), 6.0)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(report, tilted_small_sphere, Vec3(0.3, 0.2, 1), 3.0)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace brim
