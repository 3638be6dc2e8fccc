#include "brim/mesh/distance_row.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "brim/mesh/distance.h"
#include "brim/mesh/primitives.h"

namespace brim::distance_row_test {
namespace {

constexpr double kFar = 1e9;

/// Sharp edges and a hollow: where an interpolated distance is worst.
TriMesh gear() { return shapes::torus(0.7, 0.25, 7, 5); }
DistanceGrid grid_of(const TriMesh& mesh, double spacing) {
  DistanceGridOptions o;
  o.spacing = spacing;
  return make_distance_grid(mesh, o);
}

TEST(DistanceRow, HoldsTheValuesOfTheGridInSinglePrecision) {
  const DistanceGrid grid = sample_distance({Vec3::Constant(-1.0), Vec3::Constant(1.0)}, 0.1,
                                            [](const Vec3& p) { return p.norm() - 0.6 + 0.1 * std::sin(3.0 * p.x()); });
  std::mt19937 rng(11);
  std::uniform_real_distribution<double> in(-1.3, 1.3);  // some of them in cells at the border, and outside
  for (int trial = 0; trial < 500; ++trial) {
    const double a = in(rng), b = in(rng), c = in(rng), d = in(rng), e = in(rng);
    const Vec3 start(a, b, c), step(0.1 * d, 0.1 * e, 0.1 * in(rng));
    const auto wanted = static_cast<std::uint8_t>(rng());
    float out[8];
    std::fill(std::begin(out), std::end(out), -7.0f);
    distance_row(grid, start, step, wanted, kFar, out);
    for (int i = 0; i < 8; ++i) {
      if (wanted >> i & 1)
        EXPECT_NEAR(out[i], grid.value(start + i * step), 1e-6);
      else
        EXPECT_EQ(out[i], -7.0f);
    }
  }
}

TEST(DistanceRow, TellsFarPlacesOnTheRightSideAndNearOnesExactly) {
  const TriMesh mesh = gear();
  for (const double spacing : {0.02, 0.07}) {
    const DistanceGrid grid = grid_of(mesh, spacing);
    std::mt19937 rng(12);
    std::uniform_real_distribution<double> in(-1.4, 1.4);
    int near = 0, far = 0, spared = 0;
    for (int trial = 0; trial < 3000; ++trial) {
      const double a = in(rng), b = in(rng), c = 0.4 * in(rng), d = in(rng), e = in(rng);
      const Vec3 start(a, b, c), step(0.1 * d, 0.1 * e, 0.1 * in(rng));
      const double reach = 0.05 * (1.0 + in(rng) / 1.4);
      float out[8];
      distance_row(grid, start, step, 0xff, reach, out);
      for (int i = 0; i < 8; ++i) {
        const double value = grid.value(start + i * step);
        if (std::abs(value) <= reach) {
          ++near;
          EXPECT_NEAR(out[i], value, 1e-6);
        } else {
          ++far;
          spared += std::abs(out[i] - value) > 1e-6;
          EXPECT_GE(std::copysign(1.0, value) * out[i], reach - 1e-6);
          EXPECT_LE(std::abs(out[i]), std::abs(value) + 1e-6);
        }
      }
    }
    EXPECT_GT(near, 500);
    EXPECT_GT(spared, far / 2);
  }
}

TEST(DistanceRow, HoldsTheValuesAtAnyPlacesToo) {
  for (const double spacing : {0.02, 0.07}) {
    const DistanceGrid grid = grid_of(gear(), spacing);
    std::mt19937 rng(14);
    std::uniform_real_distribution<double> in(-1.1, 1.1);  // some of them outside
    for (const int count : {1, 3, 64, 1000}) {
      std::vector<double> x(count), y(count), z(count), out(count + 1, -7.0);
      for (int i = 0; i < count; ++i) x[i] = in(rng), y[i] = in(rng), z[i] = 0.4 * in(rng);
      distance_places(grid, x.data(), y.data(), z.data(), count, out.data());
      for (int i = 0; i < count; ++i) EXPECT_NEAR(out[i], grid.value({x[i], y[i], z[i]}), 1e-6);
      EXPECT_EQ(out[count], -7.0);
    }
  }
}

TEST(DistanceRow, LeastValuesLieBelowTheValueAndTheTrueDistance) {
  const TriMesh mesh = gear();
  const SurfaceTree surface(mesh);
  for (const double spacing : {0.02, 0.07}) {
    const DistanceGrid grid = grid_of(mesh, spacing);
    std::mt19937 rng(13);
    std::uniform_real_distribution<double> in(-1.4, 1.4);
    double most = 0.0, sum = 0.0;
    int count = 0;
    for (int trial = 0; trial < 400; ++trial) {
      const double a = in(rng), b = in(rng), c = in(rng), d = in(rng), e = in(rng);
      const Vec3 start(a, b, c), dx(0.1 * d, 0.1 * e, 0.1 * in(rng)), dy(0.1 * e, 0.1, 0.0), dz(0.0, -0.1 * d, 0.1);
      float at[3][8], least[8];
      for (auto& row : at)
        for (float& x : row) x = static_cast<float>(3.0 * in(rng));
      least_values(grid, start, dx, dy, dz, at[0], at[1], at[2], least);
      for (int l = 0; l < 8; ++l) {
        const Vec3 p = start + double{at[0][l]} * dx + double{at[1][l]} * dy + double{at[2][l]} * dz;
        const double scalar = grid.least_value(p), value = grid.value(p);
        EXPECT_LE(scalar, value);
        EXPECT_LE(scalar, surface.signed_distance(p));
        EXPECT_LE(least[l], scalar + 1e-6);
        EXPECT_GE(least[l], scalar - 0.3 * spacing);
        if (std::abs(value) > 4.0 * spacing) continue;
        most = std::max(most, value - scalar), sum += value - scalar, ++count;
      }
    }
    EXPECT_GT(count, 50);
    EXPECT_LT(most, 2.0 * spacing);
    EXPECT_LT(sum / count, spacing);
  }
}

}  // namespace
}  // namespace brim::distance_row_test
