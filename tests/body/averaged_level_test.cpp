#include "brim/body/grid_fluid/averaged_level.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "brim/math/ramp.h"
#include "brim/raster/averaged_distances.h"
#include "brim/raster/shape.h"

namespace brim::averaged_level_test {
namespace {

constexpr double kStep = 0.1, kWide = 3.0 * kStep, kFine = 1.5 * kStep;

struct Level {
  MacGrid grid{Vec3(-1, -1, -1), kStep, Vec3i(20, 20, 20)};
  std::vector<double> phi;
  explicit Level(const std::function<double(const Vec3&)>& distance) : phi(grid.cells()) {
    for_places(grid.n, [&](int i, int j, int k) { phi[grid.cell(i, j, k)] = distance(grid.cell_center(i, j, k)); });
  }
  double at(const Vec3& x, double w = kWide) const { return averaged_distance(grid, phi, x, w); }
};

TEST(AveragedLevel, APlaneKeepsItsDistanceWhateverItsTiltAndPlace) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int p = 0; p < 400; ++p) {
    const Vec3 n = p % 2 ? Vec3::Unit(p % 3) : Vec3(normal(random), normal(random), normal(random)).normalized();
    const double offset = 0.2 * unit(random);
    const Level level([&](const Vec3& x) { return n.dot(x) - offset; });
    const double d = 1.2 * kStep * unit(random);
    const Vec3 x = (offset + d) * n;
    // The spline's own noise between cells, 0.02 cells at half a cell and 0.06 beyond one, times the part that is
    // taken.
    for (const auto& [w, part] : {std::pair(kWide, 1.7), std::pair(kFine, 0.33)})
      EXPECT_NEAR(level.at(x, w), d, part * (std::abs(d) < 0.6 * kStep ? 0.02 : 0.06) * kStep)
          << n.transpose() << " " << d << " " << w;
  }
}

TEST(AveragedLevel, TheBoxEndsItAsASurfaceDoes) {
  const Level full([](const Vec3&) { return -1.0; });
  for (double d = -0.1; d <= 0.1; d += 0.02) EXPECT_NEAR(full.at(Vec3(1.0 + d, 0.03, -0.04)), d, 0.085 * kStep) << d;
  EXPECT_EQ(full.at(Vec3(0.1, 0.2, 0.3)), boxed_distance(full.grid, full.phi, Vec3(0.1, 0.2, 0.3)));
}

/// Mean of what two densities' sum has beyond 1, over points near a surface.
double excess(const Level& fluid, const Shape& solid, double w, bool average) {
  const double reach = w / 6.0;
  const KnownDistance& mean = dynamic_cast<const AveragedDistances&>(solid).averaged(w);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-0.7, 0.7);
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 x(unit(random), unit(random), unit(random));
    if (std::abs(solid.distance(x)) > reach) continue;
    const double f = average ? fluid.at(x, w) : boxed_distance(fluid.grid, fluid.phi, x);
    sum += ramp(mean.rough_distance(x), w) + ramp(f, w) - 1.0;
    ++count;
  }
  return sum / count;
}

TEST(AveragedLevel, WithASolidInItItFillsWhatThatLeaves) {
  // The share of one is what the other leaves. By the level set's own distance there would be room left in wide ramps.
  for (const double w : {kWide, kFine}) {
    SCOPED_TRACE(w);
    const auto ball = make_sphere(0.3);
    const Level around([](const Vec3& x) { return 0.3 - x.norm(); });
    const double seen = excess(around, *ball, w, true), raw = excess(around, *ball, w, false);
    RecordProperty(fmt::format("ball_{:.2f}", w), fmt::format("{:.4f}, {:.4f} by its own distance", seen, raw));
    EXPECT_LT(std::abs(seen), 0.02);
    const auto box = make_box(Vec3(0.5, 0.4, 0.6));
    const Level beside([&](const Vec3& x) { return -box->distance(x); });
    const double edges = excess(beside, *box, w, true), sharp = excess(beside, *box, w, false);
    RecordProperty(fmt::format("box_{:.2f}", w), fmt::format("{:.4f}, {:.4f} by its own distance", edges, sharp));
    EXPECT_LT(std::abs(edges), 0.02);
    if (w == kWide) {
      EXPECT_LT(raw, -0.05);
      EXPECT_LT(sharp, -0.05);
    }
  }
}

TEST(AveragedLevel, AFilmIsNoThinnerThanItIs) {
  // Of a layer of half a cell a share would leave less than half; one of five cells is seen as its share.
  for (const double thick : {0.5 * kStep, 5.0 * kStep}) {
    const auto slab = [&](const Vec3& x) { return std::abs(x.z()) - 0.5 * thick; };
    const Level level(slab);
    for (double z = -0.3; z <= 0.3; z += 0.025) {
      const Vec3 x(0.02, -0.01, z);
      EXPECT_LE(level.at(x), boxed_distance(level.grid, level.phi, x) + (thick > kStep ? 0.5 * kStep : 0.0) + 1e-12);
    }
  }
}

}  // namespace
}  // namespace brim::averaged_level_test
