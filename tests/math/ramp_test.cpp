#include "brim/math/ramp.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::ramp_test {
namespace {

constexpr unsigned kSeed = 31;

TEST(Ramp, ValuesByHand) {
  EXPECT_EQ(ramp(0.0, 0.3), 0.5);
  EXPECT_EQ(ramp(-0.15, 0.3), 1.0);
  EXPECT_EQ(ramp(0.15, 0.3), 0.0);
  EXPECT_EQ(ramp(-7.0, 0.3), 1.0);
  EXPECT_EQ(ramp(7.0, 0.3), 0.0);
  EXPECT_NEAR(ramp(0.075, 0.3), 1.0 - 27.0 / 32.0, 1e-15);  // t = 3/4
  EXPECT_NEAR(ramp_slope(0.0, 0.3), -1.5 / 0.3, 1e-14);
}

TEST(Ramp, FallsMonotonouslyAndIsAntisymmetricAboutTheSurface) {
  const double w = 0.7;
  double before = 1.0;
  for (int i = -500; i <= 500; ++i) {
    const double d = 1e-3 * i;
    EXPECT_LE(ramp(d, w), before);
    EXPECT_NEAR(ramp(d, w) + ramp(-d, w), 1.0, 1e-15);
    before = ramp(d, w);
  }
}

TEST(Ramp, InverseGivesTheDistanceBack) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> width(0.01, 10.0), part(-0.499, 0.499);
  for (int i = 0; i < 1000; ++i) {
    const double w = width(rng), d = w * part(rng);
    // Near the ends of the ramp the slope vanishes: one rounding of the density moves the distance by eps / slope.
    EXPECT_NEAR(ramp_inverse(ramp(d, w), w), d, 4e-16 / std::abs(ramp_slope(d, w)) + 1e-14 * w);
  }
  EXPECT_NEAR(ramp_inverse(1.0, 2.0), -1.0, 1e-15);
  EXPECT_NEAR(ramp_inverse(0.0, 2.0), 1.0, 1e-15);
  EXPECT_NEAR(ramp_inverse(-3.0, 2.0), 1.0, 1e-15) << "densities out of range are clamped";
}

TEST(Ramp, SlopeIsTheDerivative) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> part(-0.7, 0.7);
  const double w = 0.4, e = 1e-6;
  for (int i = 0; i < 1000; ++i) {
    const double d = w * part(rng);
    // Central difference: error e² |ramp'''| / 6 = 12 e² / (6 w³), and rounding 1e-16 / e. At the ends the second
    // derivative jumps: e |ramp''| / 4.
    EXPECT_NEAR(ramp_slope(d, w), (ramp(d + e, w) - ramp(d - e, w)) / (2 * e), 1e-9 + 2.0 * e / (w * w) * 6.0 / 4.0);
    EXPECT_LE(ramp_slope(d, w), 0.0);
  }
}

}  // namespace
}  // namespace brim::ramp_test
