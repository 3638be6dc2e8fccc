#include "brim/mesh/occupancy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/intensity_table.h"
#include "brim/mesh/topology.h"
#include "support/images.h"

namespace brim::occupancy_test {
namespace {

constexpr IntensityWindow kWindow{0, 100};

TEST(IntensityWindow, RisesFromEmptyToFullAndMayBeAStep) {
  const IntensityWindow ramp{10, 30}, step{20, 20};
  EXPECT_EQ(ramp.share(10), 0.0);
  EXPECT_EQ(ramp.share(15), 0.25);
  EXPECT_EQ(ramp.share(30), 1.0);
  EXPECT_EQ(step.share(19.9), 0.0);
  EXPECT_EQ(step.share(20), 1.0);
  EXPECT_EQ(step.share(21), 1.0);
}

TEST(VoxelImage, SamplesLinearFieldsExactlyAndNothingOutside) {
  VoxelImage image;
  image.size = Vec3i(3, 4, 2);
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 3; ++i) image.values.push_back(static_cast<float>(1 + 2 * i - 3 * j + 5 * k));
  double v = -99;
  ASSERT_TRUE(image.sample(Vec3(1.25, 2.5, 0.75), v));
  EXPECT_NEAR(v, 1 + 2.5 - 7.5 + 3.75, 1e-6);
  ASSERT_TRUE(image.sample(Vec3(-0.5, 3.5, 1.5), v));
  EXPECT_NEAR(v, 1 - 9 + 5, 1e-6) << "the border's value reaches half a voxel out";
  v = -99;
  EXPECT_FALSE(image.sample(Vec3(-0.51, 0, 0), v));
  EXPECT_FALSE(image.sample(Vec3(0, std::nan(""), 0), v));
  EXPECT_EQ(v, -99);
}

TEST(Occupancy, MassAndInertiaOfABallAndATurnedBoxAreTheirs) {
  const double r = 0.1;
  const VoxelImage ball =
      testing::scan({Vec3::Constant(-0.12), Vec3::Constant(0.12)}, 0.01, [&](const Vec3& x) { return x.norm() - r; });
  const MassProperties m = mass_properties(sample_occupancy(ball, kWindow, 0.012), 500.0);
  const double mass = 500.0 * 4.0 / 3.0 * std::numbers::pi * r * r * r;
  EXPECT_NEAR(m.mass, mass, 0.01 * mass);
  EXPECT_LT(m.center.norm(), 1e-4);
  EXPECT_LT((m.inertia - 0.4 * mass * r * r * Mat3::Identity()).norm(), 0.03 * mass * r * r);

  // An image whose axes are turned and mirrored holds the same box.
  VoxelImage box;
  box.size = Vec3i(12, 22, 32);
  box.axes =
      Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix() * Vec3(0.01, 0.01, -0.01).asDiagonal();
  box.origin = box.axes * Vec3(-5.5, -10.5, -15.5);
  for (int k = 0; k < 32; ++k)
    for (int j = 0; j < 22; ++j)
      for (int i = 0; i < 12; ++i)
        box.values.push_back(i > 0 && i < 11 && j > 0 && j < 21 && k > 0 && k < 31 ? 100.0f : 0.0f);
  const MassProperties b = mass_properties(sample_occupancy(box, kWindow, 0.008), 1000.0);
  EXPECT_NEAR(b.volume, 0.1 * 0.2 * 0.3, 0.01 * 0.006);
  const Vec3 axis = box.axes.col(2).normalized();
  EXPECT_NEAR(axis.dot(b.inertia * axis), 6.0 * (0.01 + 0.04) / 12.0, 0.02 * 6.0 * 0.05 / 12.0);
}

TEST(Occupancy, ReadingJoinedVoxelsGivesTheSameMatter) {
  // Coarse cells are means of shares, so the matter does not depend on the cells.
  const VoxelImage torus = testing::scan({Vec3(-0.14, -0.14, -0.05), Vec3(0.14, 0.14, 0.05)}, 0.005, [](const Vec3& x) {
    return std::hypot(std::hypot(x.x(), x.y()) - 0.1, x.z()) - 0.03;
  });
  const double fine = mass_properties(sample_occupancy(torus, kWindow, 0.004), 1.0).volume;
  const double coarse = mass_properties(sample_occupancy(torus, kWindow, 0.015), 1.0).volume;
  const double exact = 2.0 * std::numbers::pi * std::numbers::pi * 0.1 * 0.03 * 0.03;
  EXPECT_NEAR(fine, exact, 0.01 * exact);
  EXPECT_NEAR(coarse, exact, 0.015 * exact);
}

TEST(Occupancy, TheLargestPieceIsKeptAndSpecksGo) {
  const auto balls = [](const Vec3& x) {
    return std::min((x - Vec3(0.1, 0, 0)).norm() - 0.05, (x + Vec3(0.1, 0, 0)).norm() - 0.03);
  };
  OccupancyGrid grid =
      sample_occupancy(testing::scan({Vec3(-0.2, -0.1, -0.1), Vec3(0.2, 0.1, 0.1)}, 0.01, balls), kWindow, 0.01);
  EXPECT_EQ(keep_largest_piece(grid), 2u);
  const MassProperties m = mass_properties(grid, 1.0);
  EXPECT_NEAR(m.center.x(), 0.1, 1e-3);
  const double volume = 4.0 / 3.0 * std::numbers::pi * 0.05 * 0.05 * 0.05;
  EXPECT_NEAR(m.volume, volume, 0.03 * volume);
}

TEST(Occupancy, APieceIsChosenByAPointOrBySize) {
  const auto balls = [](const Vec3& x) {
    return std::min({(x - Vec3(0.1, 0, 0)).norm() - 0.05, (x + Vec3(0.1, 0, 0)).norm() - 0.03, x.norm() - 0.015});
  };
  const OccupancyGrid grid =
      sample_occupancy(testing::scan({Vec3(-0.2, -0.1, -0.1), Vec3(0.2, 0.1, 0.1)}, 0.005, balls), kWindow, 0.005);
  const auto ball = [](double r) { return 4.0 / 3.0 * std::numbers::pi * r * r * r; };
  OccupancyGrid small = grid, two = grid, none = grid;
  EXPECT_EQ(keep_piece_at(small, Vec3(-0.2, 0.05, 0)), 3u);
  EXPECT_NEAR(mass_properties(small, 1.0).center.x(), -0.1, 1e-3);
  EXPECT_EQ(keep_pieces_above(two, ball(0.02)), 3u);
  EXPECT_NEAR(mass_properties(two, 1.0).volume, ball(0.05) + ball(0.03), 0.03 * ball(0.05));
  keep_pieces_above(none, 1.0);
  EXPECT_TRUE(std::all_of(none.share.begin(), none.share.end(), [](std::uint8_t s) { return s < 128; }));
}

TEST(Occupancy, JoinedCellsHoldTheSameMatterInTheSamePlace) {
  const auto lump = [](const Vec3& x) { return (x - Vec3(0.01, 0.02, 0)).norm() - 0.07; };
  const OccupancyGrid fine =
      sample_occupancy(testing::scan({Vec3::Constant(-0.1), Vec3::Constant(0.1)}, 0.01, lump), kWindow, 0.007);
  const MassProperties a = mass_properties(fine, 1.0);
  for (const int f : {1, 2, 3}) {
    const MassProperties b = mass_properties(joined_cells(fine, f), 1.0);
    EXPECT_NEAR(b.volume, a.volume, 2e-3 * a.volume) << "shares are rounded to 1/255";
    EXPECT_LT((b.center - a.center).norm(), 1e-4);
  }
}

TEST(Occupancy, DisplaySurfaceIsClosedAndWhereTheMatterEnds) {
  const OccupancyGrid grid = sample_occupancy(
      testing::scan({Vec3::Constant(-0.12), Vec3::Constant(0.12)}, 0.01, [](const Vec3& x) { return x.norm() - 0.1; }),
      kWindow, 0.005);
  for (const std::size_t nodes : {1'000'000u, 20'000u}) {
    const TriMesh surface = display_surface(grid, nodes);
    const MeshReport report = inspect(surface);
    EXPECT_TRUE(report.closed() && report.oriented());
    double worst = 0.0;
    for (const Vec3& x : surface.vertices) worst = std::max(worst, std::abs(x.norm() - 0.1));
    EXPECT_LT(worst, 0.005) << nodes;
    EXPECT_NEAR(report.volume, 4.0 / 3.0 * std::numbers::pi * 1e-3, 0.04 * 4.2e-3);
  }
}

TEST(Occupancy, NothingLeftAndTooManyCellsAreRefused) {
  const VoxelImage ball =
      testing::scan({Vec3::Constant(-0.1), Vec3::Constant(0.1)}, 0.02, [](const Vec3& x) { return x.norm() - 0.06; });
  EXPECT_THROW(sample_occupancy(ball, {101, 200}, 0.02), InputError);
  EXPECT_THROW(sample_occupancy(ball, kWindow, 0.001, 1000), InputError);
  EXPECT_THROW(sample_occupancy(ball, kWindow, 0.0), InputError);
  EXPECT_THROW(mass_properties(sample_occupancy(ball, kWindow, 0.02), -1.0), InputError);
}

TEST(Occupancy, ThreadsDoNotChangeABit) {
  const VoxelImage ball =
      testing::scan({Vec3::Constant(-0.1), Vec3::Constant(0.1)}, 0.01, [](const Vec3& x) { return x.norm() - 0.06; });
  std::vector<std::uint8_t> first;
  for (const int threads : {1, 2, 4}) {
    ThreadLimit limit(threads);
    const OccupancyGrid grid = sample_occupancy(ball, kWindow, 0.007);
    if (first.empty()) first = grid.share;
    EXPECT_EQ(grid.share, first);
  }
}

TEST(IntensityTable, IsLinearBetweenItsPointsAndConstantBeyond) {
  const IntensityTable t{{{-1000, 1}, {0, 1000}, {1500, 1900}}};
  EXPECT_EQ(t.at(-3000), 1);
  EXPECT_EQ(t.at(-1000), 1);
  EXPECT_NEAR(t.at(-500), 500.5, 1e-12);
  EXPECT_EQ(t.at(0), 1000);
  EXPECT_NEAR(t.at(500), 1300, 1e-12);
  EXPECT_EQ(t.at(1500), 1900);
  EXPECT_EQ(t.at(1e9), 1900);
  EXPECT_EQ((IntensityTable{{{5, 7}}}.at(-1)), 7);
}

TEST(CellMeans, OfAConstantTheMassIsThatOfTheDensity) {
  const VoxelImage ball =
      testing::scan({Vec3::Constant(-0.12), Vec3::Constant(0.12)}, 0.01, [](const Vec3& x) { return x.norm() - 0.1; });
  const OccupancyGrid grid = sample_occupancy(ball, kWindow, 0.006);
  const auto density = cell_means(ball, grid, [](double v) { return 700.0 * kWindow.share(v); });
  const MassProperties one = mass_properties(grid, 700.0), other = mass_properties(grid, density);
  // Shares are kept in 255ths.
  EXPECT_NEAR(other.mass, one.mass, 1e-3 * one.mass);
  EXPECT_EQ(other.volume, one.volume);
  EXPECT_LT((other.inertia - one.inertia).norm(), 2e-3 * one.inertia.norm());
  // Cells with less than half a 255th of matter count as empty.
  const OccupancyGrid wide = joined_cells(grid, 2);
  EXPECT_NEAR(mass_properties(wide, joined_means(grid, density, 2)).mass, other.mass, 1e-4 * other.mass);
}

TEST(CellMeans, OfABallWhoseDensityFallsWithTheRadiusAreTheIntegrals) {
  // I = 1000 (1 − r/R) in the ball, ρ = 500 + I: m = 4π ∫ ρ r² dr, Θ = (8π/3) ∫ ρ r⁴ dr.
  const double R = 0.1, step = 0.004;
  VoxelImage image;
  image.size = Vec3i::Constant(61);
  image.axes = step * Mat3::Identity();
  image.origin = Vec3(0.3, 0, 0) - 30.0 * step * Vec3::Ones();
  for (int k = 0; k < 61; ++k)
    for (int j = 0; j < 61; ++j)
      for (int i = 0; i < 61; ++i)
        image.values.push_back(static_cast<float>(1000.0 * (1.0 - step * Vec3(i - 30, j - 30, k - 30).norm() / R)));
  const IntensityWindow inside{0, 0};
  const IntensityTable table{{{0, 500}, {1000, 1500}}};
  const OccupancyGrid grid = sample_occupancy(image, inside, 0.004);
  const auto density = cell_means(image, grid, [&](double v) { return inside.share(v) * table.at(v); });
  const MassProperties m = mass_properties(grid, density);
  constexpr double pi = std::numbers::pi;
  const double mass = 4.0 * pi * R * R * R * (1500.0 / 3.0 - 1000.0 / 4.0);
  const double inertia = 8.0 * pi / 3.0 * std::pow(R, 5) * (1500.0 / 5.0 - 1000.0 / 6.0);
  EXPECT_NEAR(m.mass, mass, 2e-3 * mass);
  EXPECT_LT((m.center - Vec3(0.3, 0, 0)).norm(), 1e-5);
  EXPECT_LT((m.inertia - inertia * Mat3::Identity()).norm(), 5e-3 * inertia);
}

TEST(Occupancy, MiddleLiesBetweenHalfFullPlacesNotBetweenFaintBorders) {
  // The border of a layer of cells is faint on one side alone.
  for (const double shift : {0.0, 0.3, 0.5, 0.77}) {
    OccupancyGrid grid;
    grid.spacing = 0.1;
    grid.cells = Vec3i(12, 5, 5);
    grid.origin = Vec3(0.02, 0.0, 0.0);
    grid.share.assign(300, 0);
    const double lo = 0.25 + 0.1 * shift, hi = 0.75 + 0.1 * shift;
    for (int n = 0; n < 300; ++n) {
      const Vec3i at(n % 12, n / 12 % 5, n / 60);
      if (at.y() == 0 || at.z() == 0 || at.y() == 4 || at.z() == 4) continue;
      const double x = grid.origin.x() + 0.1 * at.x();
      grid.share[n] =
          static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(0.5 + std::min(x - lo, hi - x) / 0.2, 0.0, 1.0)));
    }
    EXPECT_NEAR(grid.middle().x(), 0.5 * (lo + hi), 1e-3) << shift;
    EXPECT_NEAR(grid.middle().y(), 0.2, 1e-9);
  }
}

TEST(CellMeans, OfABarDenserAtOneEndMoveItsCentre) {
  // ρ = 1000 (1 + x/L) along a bar of 0 < x < L: m = 3/2 · 1000 V, centre 5/9 L, Θ about y through it 13/162 m L² for a
  // thin one.
  VoxelImage image;
  image.size = Vec3i(100, 4, 4);
  image.axes = 0.01 * Mat3::Identity();
  image.origin = Vec3::Constant(0.005);
  for (int n = 0; n < 1600; ++n) image.values.push_back(static_cast<float>(n % 100) + 0.5f);
  const OccupancyGrid grid = sample_occupancy(image, {-1, -1}, 0.01);
  const IntensityTable table{{{0, 1000}, {100, 2000}}};
  const MassProperties m = mass_properties(grid, cell_means(image, grid, [&](double v) { return table.at(v); }));
  const double mass = 1500.0 * 0.04 * 0.04;
  EXPECT_NEAR(m.mass, mass, 1e-6 * mass);
  EXPECT_NEAR(m.center.x(), 5.0 / 9.0, 1e-4);
  EXPECT_NEAR(m.inertia(1, 1), mass * (13.0 / 162.0 + 0.04 * 0.04 / 12.0), 1e-3 * mass);
}

}  // namespace
}  // namespace brim::occupancy_test
