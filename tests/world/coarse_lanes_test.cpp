#include "brim/world/coarse_lanes.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/solids.h"

namespace brim::coarse_lanes_test {
namespace {

constexpr unsigned kSeed = 23;

TEST(CoarseLanes, WrenchAndMotionAreThoseOfEachNode) {
  testing::Noise noise(kSeed);
  for (const std::size_t n : {1u, 2u, 3u, 4u, 5u, 8u, 11u}) {
    std::vector<Vec3> place;
    std::vector<double> force(3 * n), v(3 * n);
    for (std::size_t i = 0; i < n; ++i) place.push_back(noise.vec());
    for (std::size_t i = 0; i < 3 * n; ++i) force[i] = noise(), v[i] = noise();
    const Vec3 c = noise.vec(), t = noise.vec(), w = noise.vec();

    Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
    std::vector<double> moved = v;
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Map<const Vec3> f(force.data() + 3 * i);
      sum += f, torque += (place[i] - c).cross(f);
      Eigen::Map<Vec3>(moved.data() + 3 * i) += t + w.cross(place[i]);
    }
    double out[6];
    coarse_lanes::sum_wrench(place, c, force, out);
    coarse_lanes::add_motion(place, t, w, v);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(out[k], sum[k], 1e-13);
      EXPECT_NEAR(out[3 + k], torque[k], 1e-13);
    }
    for (std::size_t i = 0; i < 3 * n; ++i) EXPECT_NEAR(v[i], moved[i], 1e-14);
  }
}

TEST(CoarseLanes, ContactsAddTheProductsOfTheirSides) {
  using Seen = Eigen::Matrix<double, 3, 8, Eigen::RowMajor>;
  testing::Noise noise(kSeed);
  coarse_lanes::PairSums sum;
  Eigen::Matrix<double, 8, 8> aa = Eigen::Matrix<double, 8, 8>::Zero(), bb = aa, ab = aa;
  for (int contact = 0; contact < 5; ++contact) {
    Seen a, b;
    for (int i = 0; i < 24; ++i) a.data()[i] = noise(), b.data()[i] = noise();
    const Vec3 x = noise.vec(), y = noise.vec();
    const Mat3 K = x * x.transpose() + y * y.transpose();
    coarse_lanes::add_contact(a.data(), b.data(), K.data(), sum);
    aa += a.transpose() * K * a, bb += b.transpose() * K * b, ab -= a.transpose() * K * b;
  }
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      EXPECT_NEAR(sum.aa[i][j], aa(i, j), 1e-12);
      EXPECT_NEAR(sum.bb[i][j], bb(i, j), 1e-12);
      EXPECT_NEAR(sum.ab[i][j], ab(i, j), 1e-12);
    }
}

}  // namespace
}  // namespace brim::coarse_lanes_test
