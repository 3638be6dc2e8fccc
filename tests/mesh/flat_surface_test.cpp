#include "brim/mesh/flat_surface.h"

#include <gtest/gtest.h>

#include "brim/mesh/primitives.h"

namespace brim::flat_surface_test {
namespace {

TriMesh turned_square(double lift) {
  const Mat3 R = Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized())).toRotationMatrix();
  TriMesh square{{{0, 0, 0}, {1, 0, 0}, {1, 1, lift}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  for (Vec3& x : square.vertices) x = (R * x + Vec3(5, -3, 2)).cast<float>().cast<double>();  // as a file keeps it
  return square;
}

TEST(FlatSurface, IsFoundInAnyPlaneAndNothingElse) {
  EXPECT_TRUE(is_flat(turned_square(0.0)));
  EXPECT_FALSE(is_flat(turned_square(1e-3)));
  EXPECT_FALSE(is_flat(shapes::box(Vec3(1, 1, 1e-3))));
  EXPECT_TRUE(is_flat(TriMesh{}));
  EXPECT_TRUE(is_flat(TriMesh{{{1, 2, 3}}, {}}));
}

}  // namespace
}  // namespace brim::flat_surface_test
