#include "brim/mesh/distance_row.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace brim {
namespace {

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
    distance_row(grid, start, step, wanted, out);
    for (int i = 0; i < 8; ++i) {
      if (wanted >> i & 1)
        EXPECT_NEAR(out[i], grid.value(start + i * step), 1e-6);
      else
        EXPECT_EQ(out[i], -7.0f);
    }
  }
}

}  // namespace
}  // namespace brim
