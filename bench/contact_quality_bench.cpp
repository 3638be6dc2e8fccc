#include <benchmark/benchmark.h>

#include "support/cube_on_plane.h"

/// Quality of the contact force, as counters: a sphere, and a finite-element cube, pressed into planes of several
/// directions. Percent.
namespace brim {
namespace {

constexpr unsigned kSeed = 1;
constexpr int kPositions = 64;

void count(benchmark::State& state, const testing::ContactQuality& q) {
  state.counters["tangential_mean_%"] = 100 * q.tangential_mean;
  state.counters["tangential_worst_%"] = 100 * q.tangential_worst;
  state.counters["scatter_%"] = 100 * q.scatter;
  state.counters["force_over_work"] = q.work_ratio;
  state.counters["force_over_k_h2"] = q.mean_force;
}

void sphere(benchmark::State& state, const Vec3& n, double radius) {
  testing::ContactQuality q;
  for (auto _ : state) q = testing::contact_quality(n, kSeed, kPositions, radius);
  count(state, q);
}

/// @param side  [voxels]
void cube(benchmark::State& state, const Vec3& n, double side, double press, bool random_yaw) {
  testing::ContactQuality q;
  for (auto _ : state) q = testing::cube_contact_quality(n, kSeed, kPositions, 6, side, press, random_yaw);
  count(state, q);
}

const Vec3 kTilted(0.3, 0.2, 1), kAxis(0, 0, 1), kEdgeDiagonal(0, 1, 1), kSpaceDiagonal(1, 1, 1);

#define BRIM_QUALITY(...) BENCHMARK_CAPTURE(__VA_ARGS__)->Iterations(1)->Unit(benchmark::kMillisecond)
BRIM_QUALITY(sphere, tilted, kTilted, 6.0);
BRIM_QUALITY(sphere, axis, kAxis, 6.0);
BRIM_QUALITY(sphere, edge_diagonal, kEdgeDiagonal, 6.0);
BRIM_QUALITY(sphere, space_diagonal, kSpaceDiagonal, 6.0);
BRIM_QUALITY(sphere, tilted_small, kTilted, 3.0);
BRIM_QUALITY(cube, tilted, kTilted, 16.0, 0.5, false);
BRIM_QUALITY(cube, axis, kAxis, 16.0, 0.5, false);
BRIM_QUALITY(cube, edge_diagonal, kEdgeDiagonal, 16.0, 0.5, false);
BRIM_QUALITY(cube, space_diagonal, kSpaceDiagonal, 16.0, 0.5, false);
BRIM_QUALITY(cube, tilted_any_yaw, kTilted, 16.0, 0.5, true);
BRIM_QUALITY(cube, tilted_shallow, kTilted, 16.0, 0.1, false);
BRIM_QUALITY(cube, tilted_small, kTilted, 8.0, 0.5, false);

}  // namespace
}  // namespace brim
