#include "brim/body/grid_fluid/level_set.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

namespace brim::level_set_test {
namespace {

std::vector<double> sampled(const MacGrid& g, const auto& distance) {
  std::vector<double> phi(g.cells());
  for_places(g.n, [&](int i, int j, int k) { phi[g.cell(i, j, k)] = distance(g.cell_center(i, j, k)); });
  return phi;
}

const MacGrid kGrid{Vec3(-0.5, -0.5, -0.5), 1.0 / 24.0, Vec3i(24, 24, 24)};
constexpr std::array<bool, 6> kClosed{};

TEST(LevelSet, VolumeOfABallOfSevenCellsIsRightToAPercent) {
  LevelSet level(kGrid);
  const auto phi = sampled(kGrid, [](const Vec3& x) { return (x - Vec3(0.013, -0.007, 0.004)).norm() - 0.3; });
  double area = 0.0;
  const double exact = 4.0 / 3.0 * std::numbers::pi * 0.027;
  EXPECT_NEAR(level.volume(phi, 0.0, area), exact, 0.01 * exact);
  EXPECT_NEAR(area, 4.0 * std::numbers::pi * 0.09, 0.05 * 4.0 * std::numbers::pi * 0.09);
}

TEST(LevelSet, VolumeUnderALevelPlaneIsExact) {
  LevelSet level(kGrid);
  for (const double height : {-0.21, 0.0, 0.0123, 0.3}) {
    const auto phi = sampled(kGrid, [&](const Vec3& x) { return x.z() - height; });
    double area = 0.0;
    EXPECT_NEAR(level.volume(phi, 0.0, area), height + 0.5, 1e-12);
  }
}

TEST(LevelSet, CenterOfMassUnderAPlaneIsThatOfThePrism) {
  LevelSet level(kGrid);
  const double volume = std::pow(kGrid.dx, 3);
  const auto first_moment = [&](double slope, double height) {
    const auto phi = sampled(
        kGrid, [&](const Vec3& x) { return (x.z() - height - slope * x.x()) / std::sqrt(1.0 + slope * slope); });
    std::vector<double> layer(static_cast<std::size_t>(kGrid.n.z()), 0.0);  // threads share the layers
    for_places(kGrid.n, [&](int i, int j, int k) {
      layer[static_cast<std::size_t>(k)] +=
          level.fraction(phi, i, j, k) * kGrid.cell_center(i, j, k).z() + level.moment(phi, i, j, k).z();
    });
    return std::accumulate(layer.begin(), layer.end(), 0.0) * volume;
  };
  // ∫ (z² − 1/4)/2 over the unit square, z = height + slope x.
  const auto exact = [](double slope, double height) { return 0.5 * (height * height + slope * slope / 12.0 - 0.25); };
  for (const double height : {-0.21, 0.0, 0.0123, 0.3})
    EXPECT_NEAR(first_moment(0.0, height), exact(0.0, height), 1e-12);
  for (const double height : {-0.1, 0.0, 0.0123})
    for (const double slope : {0.1, 0.2, 0.4})
      EXPECT_NEAR(first_moment(slope, height), exact(slope, height), 2e-5) << slope << " " << height;
}

TEST(LevelSet, MakingADistanceTwiceChangesNothingMore) {
  LevelSet level(kGrid);
  auto phi = sampled(kGrid, [](const Vec3& x) { return std::max(x.z() - 0.1, 0.2 - (x - Vec3(0, 0, 0.02)).norm()); });
  level.redistance(phi);
  auto again = phi;
  for (int i = 0; i < 5; ++i) level.redistance(again);
  for (std::size_t c = 0; c < phi.size(); ++c) EXPECT_NEAR(again[c], phi[c], 1e-12);
}

TEST(LevelSet, DistancesFarFromABallAreThoseOfTheBall) {
  LevelSet level(kGrid);
  const auto exact = [](const Vec3& x) { return x.norm() - 0.25; };
  auto phi = sampled(kGrid, exact);
  for (double& p : phi)
    if (std::abs(p) > 2.0 * kGrid.dx) p = p < 0.0 ? -3.0 : 3.0;
  level.redistance(phi);
  double worst = 0.0;
  for (int k = 0; k < 24; ++k)
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 24; ++i) {
        const Vec3 x = kGrid.cell_center(i, j, k);
        worst = std::max(worst, std::abs(phi[kGrid.cell(i, j, k)] - exact(x)));
      }
  EXPECT_LT(worst, kGrid.dx);  // first order: grows with the distance, ten cells here
}

TEST(LevelSet, CarriedBallKeepsShapeAndVolume) {
  LevelSet level(kGrid);
  const auto ball = [](const Vec3& x) { return x.norm() - 0.2; };
  auto phi = sampled(kGrid, ball);
  const Vec3 u(0.4, 0.3, -0.2);
  double area = 0.0;
  const double before = level.volume(phi, 0.0, area);
  for (int s = 0; s < 30; ++s) {
    level.advect(phi, 0.01, 6.0 * kGrid.dx, kClosed, [&](int, const Vec3&) { return u; });
    level.redistance(phi);
  }
  EXPECT_NEAR(level.volume(phi, 0.0, area), before, 0.02 * before);
  double worst = 0.0;
  for (int k = 0; k < 24; ++k)
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 24; ++i) {
        const double exact = ball(kGrid.cell_center(i, j, k) - 0.3 * u);
        if (std::abs(exact) < kGrid.dx) worst = std::max(worst, std::abs(phi[kGrid.cell(i, j, k)] - exact));
      }
  EXPECT_LT(worst, 0.25 * kGrid.dx);
}

TEST(LevelSet, CorrectionBringsTheVolumeBack) {
  LevelSet level(kGrid);
  auto phi = sampled(kGrid, [](const Vec3& x) { return x.norm() - 0.3; });
  double area = 0.0;
  const double before = level.volume(phi, 0.0, area), wanted = 1.01 * before;
  const double shift = level.correct_volume(phi, wanted, 0.1 * kGrid.dx);
  EXPECT_NEAR(level.volume(phi, 0.0, area), wanted, 1e-6 * wanted);
  EXPECT_NEAR(shift, 0.01 * before / area, 0.05 * shift);
  // Never farther than it may.
  EXPECT_NEAR(level.correct_volume(phi, 2.0 * before, 0.1 * kGrid.dx), 0.1 * kGrid.dx, 1e-12);
}

}  // namespace
}  // namespace brim::level_set_test
