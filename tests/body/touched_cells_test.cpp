#include "brim/body/grid_fluid/touched_cells.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace brim::touched_cells_test {
namespace {

TEST(TouchedCells, AreThoseOfThePointsAndTheirNeighboursAcrossAFace) {
  const MacGrid g{Vec3(-1.0, 0.5, 2.0), 0.1, Vec3i(9, 8, 7)};
  TouchedCells touched;
  EXPECT_FALSE(touched.has(g.cell(4, 4, 3))) << "nothing was noted";
  const std::vector<Vec3> points = {g.cell_center(4, 4, 3) + Vec3(0.04, -0.04, 0.02)};
  touched.note(g, points);
  for (int k = 0; k < 7; ++k)
    for (int j = 0; j < 8; ++j)
      for (int i = 0; i < 9; ++i)
        EXPECT_EQ(touched.has(g.cell(i, j, k)), std::abs(i - 4) + std::abs(j - 4) + std::abs(k - 3) <= 1)
            << i << " " << j << " " << k;
  touched.note(g, {});
  EXPECT_FALSE(touched.has(g.cell(4, 4, 3))) << "it was let go";
}

TEST(TouchedCells, PointsBeyondTheBoxCountForTheNearestCell) {
  const MacGrid g{Vec3::Zero(), 0.1, Vec3i(4, 4, 4)};
  TouchedCells touched;
  const std::vector<Vec3> points = {Vec3(-3.0, 9.0, 0.25), Vec3(0.35, 0.05, 0.05)};
  touched.note(g, points);
  EXPECT_TRUE(touched.has(g.cell(0, 3, 2)));
  EXPECT_TRUE(touched.has(g.cell(3, 0, 0)));
  EXPECT_FALSE(touched.has(g.cell(3, 3, 3)));
}

TEST(TouchedCells, WhereAFluidTouchesAsWellItIsKnown) {
  const MacGrid g{Vec3::Zero(), 0.1, Vec3i(9, 3, 3)};
  TouchedCells touched;
  const std::vector<Vec3> points = {g.cell_center(1, 1, 1), g.cell_center(6, 1, 1), g.cell_center(6, 1, 1)};
  const std::vector<std::uint8_t> by_fluid = {0, 1, 0};
  touched.note(g, points, by_fluid);
  EXPECT_TRUE(touched.has(g.cell(1, 1, 1)));
  EXPECT_FALSE(touched.has_fluid(g.cell(1, 1, 1)));
  EXPECT_TRUE(touched.has_fluid(g.cell(7, 1, 1)));
}

}  // namespace
}  // namespace brim::touched_cells_test
