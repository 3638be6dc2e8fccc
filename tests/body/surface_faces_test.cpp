#include "brim/body/grid_fluid/surface_faces.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::surface_faces_test {
namespace {

TEST(SurfaceFaces, AreThoseBetweenWetAndDryCellsOfTheAskedBox) {
  const unsigned seed = 5;
  RecordProperty("seed", static_cast<int>(seed));
  const MacGrid g{Vec3::Zero(), 0.1, {9, 7, 8}};
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(-0.25, 0.3);
  std::vector<double> phi(g.cells());
  for (double& p : phi) p = unit(rng);
  WetFaces wet;
  wet.find(g, phi, {});
  SurfaceFaces surface;
  surface.find(g, wet, phi);
  const Vec3i first(2, 0, 3), last(8, 4, 6);
  std::vector<int> expected, found;
  for (int k = first.z(); k <= last.z(); ++k)
    for (int j = first.y(); j <= last.y(); ++j)
      for (int i = first.x(); i <= last.x(); ++i)
        for (int a = 0; a < 3; ++a)
          for (const int side : {-1, 1}) {
            const Vec3i at(i, j, k), other = at + side * Vec3i::Unit(a);
            const double p = phi[g.cell(at)];
            if (!g.inside(other) || p < 0.0 || p > 2.0 * g.dx || phi[g.cell(other)] >= 0.0) continue;
            expected.push_back(g.face(a, side < 0 ? at : other));
          }
  surface.for_cuts(first, last, [&](const SurfaceFaces::Cut& c) {
    found.push_back(c.face);
    EXPECT_LE(std::abs(c.way), 1.0);
  });
  EXPECT_FALSE(expected.empty());
  EXPECT_EQ(found, expected);
}

TEST(SurfaceFaces, ACutLiesWhereTheLineBetweenTwoCentresIsZero) {
  const MacGrid g{Vec3::Zero(), 1.0, {1, 1, 2}};
  const std::vector<double> phi = {-0.25, 0.75};
  WetFaces wet;
  wet.find(g, phi, {});
  SurfaceFaces surface;
  surface.find(g, wet, phi);
  int cuts = 0;
  surface.for_cuts(Vec3i::Zero(), Vec3i(0, 0, 1), [&](const SurfaceFaces::Cut& c) {
    ++cuts;
    EXPECT_EQ(c.face, g.face(2, 0, 0, 1));
    EXPECT_EQ(c.axis, 2);
    EXPECT_EQ(c.sign, 1.0);
    EXPECT_DOUBLE_EQ(c.cell.z() + c.way, 0.25);
  });
  EXPECT_EQ(cuts, 1);
}

}  // namespace
}  // namespace brim::surface_faces_test
