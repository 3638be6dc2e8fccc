#include "brim/response/patch_average.h"

#include <gtest/gtest.h>

#include <random>

namespace brim {
namespace {

constexpr unsigned kSeed = 81;

TEST(PatchAverage, OneSampleByHand) {
  PatchAverage<double> average;
  average.reset(2.0, 1);
  average.add(Vec3(1, 0, 0), 8.0);  // half to the lattice point (0, 0, 0), half to (2, 0, 0)
  EXPECT_DOUBLE_EQ(average.at(Vec3(0, 0, 0)), 4.0);
  EXPECT_DOUBLE_EQ(average.at(Vec3(1, 0, 0)), 4.0);
  EXPECT_DOUBLE_EQ(average.at(Vec3(3, 0, 0)), 2.0);
  EXPECT_DOUBLE_EQ(average.at(Vec3(0, 2, 0)), 0.0);
}

TEST(PatchAverage, EqualsTheSumOverAllPairsOfTents) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> u(-20.0, 20.0);
  const double cell = 1.5;
  std::vector<Vec3> x;
  std::vector<double> v;
  PatchAverage<double> average;
  for (int round = 0; round < 2; ++round) {  // a reset forgets the samples before it; too small a guess grows
    x.clear(), v.clear();
    average.reset(cell, 1);
    for (int i = 0; i < 400; ++i) {
      const double a = u(rng), b = u(rng), c = u(rng);
      x.emplace_back(a, b, c), v.push_back(u(rng));
      average.add(x.back(), v.back());
    }
  }
  const auto tent = [&](const Vec3& p, const Vec3& node) {
    double w = 1.0;
    for (int d = 0; d < 3; ++d) w *= std::max(0.0, 1.0 - std::abs(p[d] - node[d]) / cell);
    return w;
  };
  for (int i = 0; i < 100; ++i) {
    const double a = u(rng), b = u(rng), c = u(rng);
    const Vec3 p = i < 50 ? x[i] : Vec3(a, b, c);
    double expected = 0.0;
    for (int n = 0; n < 8; ++n) {
      const Vec3 node = cell * Vec3((p / cell).array().floor().matrix() + Vec3(n & 1, n >> 1 & 1, n >> 2));
      for (std::size_t s = 0; s < x.size(); ++s) expected += tent(p, node) * tent(x[s], node) * v[s];
    }
    EXPECT_NEAR(average.at(p), expected, 1e-12);
  }
}

}  // namespace
}  // namespace brim
