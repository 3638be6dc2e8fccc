#include "brim/body/particles/mean_motion.h"

#include <gtest/gtest.h>

namespace brim::mean_motion_test {
namespace {

const std::vector<double> kMass = {1.0, 2.0, 0.5, 1.5}, kPlaces = {0, 0, 0, 1, 0.2, 0, 0.1, 1.3, 0.4, -0.3, 0.2, 1.1},
                          kVelocities = {1, 0, 0, -0.5, 2, 0.3, 0.2, -0.7, 1.5, 0.4, 0.4, -1};

Vec3 momentum(std::span<const double> v) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < kMass.size(); ++i) sum += kMass[i] * Eigen::Map<const Vec3>(v.data() + 3 * i);
  return sum;
}

TEST(SlowInnerMotion, TakesTheExcessAndKeepsBothMomenta) {
  const ParticleSet p{kMass, {}};
  const MeanMotion before = mean_motion(p, kPlaces, kVelocities);
  const double all = energy_about_center(kMass, kVelocities), turning = 0.5 * before.spin.dot(before.momentum);
  ASSERT_LT(turning, 0.9 * all);
  for (const double most : {2.0 * all, all, 0.5 * (all + turning), turning, 0.5 * turning}) {
    SCOPED_TRACE(most / all);
    std::vector<double> v = kVelocities;
    slow_inner_motion(p, kPlaces, most, v);
    EXPECT_NEAR(energy_about_center(kMass, v), std::clamp(most, turning, all), 1e-12 * all);
    EXPECT_LT((momentum(v) - momentum(kVelocities)).norm(), 1e-12);
    EXPECT_LT((mean_motion(p, kPlaces, v).momentum - before.momentum).norm(), 1e-12);
  }
}

TEST(AdvanceTurning, AddsACorrectionInTheFrameThatTurns) {
  const ParticleSet p{kMass, {}};
  const double dt = 0.1;
  std::vector<double> plain = kPlaces, more = kPlaces, none = kPlaces;
  advance_turning(p, dt, plain, kVelocities);
  advance_turning(p, dt, none, kVelocities, [](auto, auto, auto) { return false; });
  EXPECT_EQ(plain, none);
  advance_turning(p, dt, more, kVelocities,
                  [&](std::span<const double> x, std::span<const double> way, std::span<double> out) {
                    // The whole way back: what is left is the rigid motion.
                    EXPECT_TRUE(std::ranges::equal(x, kPlaces));
                    for (std::size_t i = 0; i < way.size(); ++i) out[i] = -way[i];
                    return true;
                  });
  for (std::size_t i = 0; i < kMass.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const auto apart = [&](const std::vector<double>& x) {
        return (Eigen::Map<const Vec3>(x.data() + 3 * i) - Eigen::Map<const Vec3>(x.data() + 3 * j)).norm();
      };
      EXPECT_NEAR(apart(more), apart(kPlaces), 1e-12);
      EXPECT_GT(std::abs(apart(plain) - apart(kPlaces)), 1e-3);
    }
}

}  // namespace
}  // namespace brim::mean_motion_test
