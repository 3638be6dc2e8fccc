#include "brim/body/grid_fluid/fluid_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>

namespace brim::fluid_surface_test {
namespace {

struct Shown {
  std::vector<Vec3f> x;
  std::vector<Triangle> triangles;

  double volume() const {
    double v = 0.0;
    for (const Triangle& t : triangles)
      v += x[t[0]].cast<double>().dot(x[t[1]].cast<double>().cross(x[t[2]].cast<double>())) / 6.0;
    return v;
  }
  /// Whether every edge belongs to as many triangles in the one direction as in the other.
  bool closed() const {
    std::map<std::pair<int, int>, int> edges;
    for (const Triangle& t : triangles)
      for (int c = 0; c < 3; ++c) {
        const int a = t[c], b = t[(c + 1) % 3];
        edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
      }
    for (const auto& [edge, sum] : edges)
      if (sum != 0) return false;
    return true;
  }
};

Shown shown(const MacGrid& g, const std::function<double(const Vec3&)>& distance) {
  std::vector<double> phi(g.cells());
  for_places(g.n, [&](int i, int j, int k) {
    phi[static_cast<std::size_t>(g.cell(i, j, k))] = distance(g.cell_center(i, j, k));
  });
  Shown s;
  fluid_surface(g, phi, s.x, s.triangles);
  return s;
}

const MacGrid kTank{Vec3(0.3, -0.2, 0.1), 0.05, Vec3i(16, 8, 8)};
const Vec3 kSize = kTank.dx * kTank.n.cast<double>();

TEST(FluidSurface, APoolFillsItsBoxToEdgesAndCorners) {
  const double area = kSize.x() * kSize.y();
  for (const double depth : {0.03, 0.17, 0.2, 0.225, 0.31, 0.385, 0.4}) {
    const Shown s = shown(kTank, [&](const Vec3& x) { return x.z() - kTank.origin.z() - depth; });
    EXPECT_TRUE(s.closed());
    // A full box: its surface is the lid.
    EXPECT_NEAR(s.volume(), area * depth, 1e-6 * area) << depth;
    Aabb box;
    for (const Vec3f& x : s.x) box.extend(x.cast<double>());
    EXPECT_LT((box.lo - kTank.origin).norm(), 1e-6);
  }
}

TEST(FluidSurface, ATiltedPoolKeepsItsVolume) {
  // The surface through the middle of the box cuts it into halves, and meets all four walls.
  const Vec3 n = Vec3(0.2, -0.13, 1.0).normalized();
  const Shown s = shown(kTank, [&](const Vec3& x) { return n.dot(x - kTank.box().center()); });
  EXPECT_TRUE(s.closed());
  EXPECT_NEAR(s.volume(), 0.5 * kSize.prod(), 1e-3 * kSize.prod());
}

TEST(FluidSurface, BallsConverge) {
  double last = 1.0;
  for (const int cells : {8, 16, 32}) {
    const double dx = 1.0 / cells, r = 0.31;
    const MacGrid g{Vec3(0, 0, 0), dx, Vec3i::Constant(cells)};
    const Shown s = shown(g, [&](const Vec3& x) { return (x - Vec3(0.48, 0.53, 0.5)).norm() - r; });
    EXPECT_TRUE(s.closed());
    const double wrong = std::abs(s.volume() / (4.0 / 3.0 * std::numbers::pi * r * r * r) - 1.0);
    EXPECT_LT(wrong, last / 3.0) << cells;
    last = wrong;
  }
  EXPECT_LT(last, 0.015);
}

TEST(FluidSurface, OneCellAcrossIsStillABox) {
  const MacGrid g{Vec3(0, 0, 0), 0.1, Vec3i(6, 1, 4)};
  const Shown s = shown(g, [](const Vec3& x) { return x.z() - 0.23; });
  EXPECT_TRUE(s.closed());
  EXPECT_NEAR(s.volume(), 0.6 * 0.1 * 0.23, 1e-7);
}

}  // namespace
}  // namespace brim::fluid_surface_test
