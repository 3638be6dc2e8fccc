// Queries of worlds: a field of many bodies, and one body of many triangles.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "brim/world/queries.h"
#include "support/soft_worlds.h"

namespace brim::testing {
namespace {

/// n boxes and balls in turn, 0.4 m wide, on a square lattice of 1 m over the ground.
World field(int n) {
  World w(options_at(0.1));
  w.add(ground(0.5));
  const int side = static_cast<int>(std::ceil(std::sqrt(n)));
  for (int i = 0; i < n; ++i) {
    const Start at{Vec3(i % side, i / side, 0.5)};
    w.add(i % 2 == 0 ? box(std::to_string(i), at, 0.5, 0.4) : ball(std::to_string(i), at, 0.5, 0.2));
  }
  return w;
}

/// A soft cube with about 12 cells² triangles on its surface.
World soft_cube(int cells) {
  World w(options_at(0.1));
  FemOptions o;
  o.density = 500, o.young = 1e5;
  w.add(named<FemBody>("cube", block_at(cells, 1.0, Vec3::Zero()), o));
  return w;
}

/// Rays along the field, just above the ground, at angles that differ.
void raycast_field(benchmark::State& state) {
  const World w = field(static_cast<int>(state.range(0)));
  int i = 0;
  for (auto _ : state) {
    const double turn = 0.1 + 1e-3 * (++i % 1000);
    benchmark::DoNotOptimize(w.raycast(Vec3(-1, -1, 0.5), Vec3(std::cos(turn), std::sin(turn), 0.0)));
  }
}
BENCHMARK(raycast_field)->Arg(20)->Arg(200)->Arg(2000)->Unit(benchmark::kMicrosecond);

void closest_in_field(benchmark::State& state) {
  const World w = field(static_cast<int>(state.range(0)));
  int i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(w.closest_point(Vec3(0.01 * (++i % 1000), 3.3, 1.5)));
}
BENCHMARK(closest_in_field)->Arg(20)->Arg(2000)->Unit(benchmark::kMicrosecond);

void overlap_in_field(benchmark::State& state) {
  const World w = field(static_cast<int>(state.range(0)));
  int i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(w.overlap_ball(Vec3(0.01 * (++i % 1000), 3.3, 0.5), 1.0));
}
BENCHMARK(overlap_in_field)->Arg(20)->Arg(2000)->Unit(benchmark::kMicrosecond);

void raycast_soft_cube(benchmark::State& state) {
  const World w = soft_cube(static_cast<int>(state.range(0)));
  int i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(w.raycast(Vec3(0.5, 0.001 * (++i % 900), 3.0), Vec3(0.01, 0.02, -1.0)));
  state.counters["triangles"] = static_cast<double>(std::span(w.body(0).display().triangles).size());
}
BENCHMARK(raycast_soft_cube)->Arg(4)->Arg(24)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace brim::testing
