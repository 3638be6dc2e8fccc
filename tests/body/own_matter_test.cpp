#include "brim/body/own/own_matter.h"

#include <gtest/gtest.h>

#include "brim/mesh/mass_properties.h"
#include "brim/mesh/primitives.h"

/// Points that stand for the matter of own bodies, and the surface by which they are bounded and shown.
namespace brim::own_matter_test {
namespace {

TEST(OwnMatter, PointsHaveTheMassCentreAndInertiaOfTheSolid) {
  const TriMesh ball = shapes::icosphere(0.2, 3), bar = shapes::box(Vec3(1.0, 0.1, 0.1));
  TriMesh far = bar;
  for (Vec3& x : far.vertices) x += Vec3(0.3, -20.0, 4.0);
  for (const auto& [surface, spacing] : {std::pair(ball, 0.05), {ball, 0.2}, {bar, 0.1}, {far, 0.09}, {far, 0.04}}) {
    const MassProperties whole = mass_properties(surface, 500.0);
    const MassPoints points = mass_points(surface, 500.0, spacing);
    double mass = 0.0;
    Vec3 first = Vec3::Zero();
    Mat3 inertia = Mat3::Zero();
    for (std::size_t k = 0; k < points.at.size(); ++k) {
      const Vec3 d = points.at[k] - whole.center;
      EXPECT_GT(points.mass[k], 0.0);
      mass += points.mass[k], first += points.mass[k] * d;
      inertia += points.mass[k] * (d.squaredNorm() * Mat3::Identity() - d * d.transpose());
    }
    // By centroids of tetrahedra the bar had 0.81 of its inertia about itself at the default spacing, 0.1.
    EXPECT_NEAR(mass, whole.mass, 1e-12 * whole.mass);
    EXPECT_LT(first.norm(), 1e-12 * whole.mass);
    EXPECT_LT((inertia - whole.inertia).norm(), 1e-11 * whole.inertia.norm());
    EXPECT_NEAR(inertia(0, 0), whole.inertia(0, 0), 1e-9 * whole.inertia(0, 0));
  }
}

TEST(OwnMatter, QuadraticFunctionsOfAPartAreExactlySummed) {
  // ∫ max(x, 0)² over one half of a bar, whose middle is at a border of cells: L³/24 A, by hand.
  const MassPoints points = mass_points(shapes::box(Vec3(1.0, 0.2, 0.2)), 1.0, 0.1);
  double sum = 0.0;
  for (std::size_t k = 0; k < points.at.size(); ++k)
    sum += points.mass[k] * std::pow(std::max(points.at[k].x(), 0.0), 2);
  EXPECT_NEAR(sum, 0.04 / 24.0, 2e-2 * 0.04 / 24.0) << "tetrahedra reach over the border by less than half a cell";
}

TEST(OwnMatter, AStockOfLongEdgesIsDividedIntoAClosedSurfaceOfTheSameSolid) {
  for (const TriMesh& coarse : {shapes::box(Vec3(1.0, 0.1, 0.1)), shapes::icosphere(0.2, 1)}) {
    const TriMesh fine = with_short_edges(coarse, 0.125);
    double longest = 0.0;
    for (const Triangle& t : fine.triangles)
      for (int k = 0; k < 3; ++k)
        longest = std::max(longest, (fine.vertices[t[k]] - fine.vertices[t[(k + 1) % 3]]).norm());
    EXPECT_LE(longest, 0.125);
    const MassProperties a = mass_properties(coarse, 1.0), b = mass_properties(fine, 1.0);
    EXPECT_NEAR(a.mass, b.mass, 1e-13 * a.mass);
    EXPECT_LT((a.inertia - b.inertia).norm(), 1e-13 * a.inertia.norm());
    // Euler: no cracks.
    EXPECT_EQ(2 * fine.vertices.size(), fine.triangles.size() + 4);
  }
}

}  // namespace
}  // namespace brim::own_matter_test
