#include "brim/raster/trilinear.h"

#include <gtest/gtest.h>

namespace brim::trilinear_test {
namespace {

TEST(Trilinear, GivesALinearFunctionAndItsSlope) {
  const double h = 0.25;
  const Vec3 slope(2.0, -3.0, 0.5), t(0.1, 0.6, 0.9);
  const Trilinear at = trilinear(t, h, [&](int x, int y, int z) { return 1.0 + h * slope.dot(Vec3(x, y, z)); });
  EXPECT_NEAR(at.value, 1.0 + h * slope.dot(t), 1e-15);
  EXPECT_LT((at.slope - slope).norm(), 1e-14);
}

TEST(Trilinear, GivesTheValueOfACorner) {
  for (int c = 0; c < 8; ++c) {
    const Vec3 t(c & 1, c >> 1 & 1, c >> 2);
    EXPECT_EQ(trilinear(t, 1.0, [](int x, int y, int z) { return x + 2.0 * y + 4.0 * z; }).value, c);
  }
}

}  // namespace
}  // namespace brim::trilinear_test
