#include "brim/map/point_weights.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/core/parallel.h"

namespace brim::point_weights_test {
namespace {

constexpr unsigned kSeed = 20260721;

/// Rows of random lengths, duplicates of a particle included.
struct RandomRows {
  std::size_t particles = 40, points = 300;
  std::vector<std::int32_t> start{0}, particle;
  std::vector<double> weight, v;
  std::vector<Vec3> f;
  std::mt19937 rng{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};

  RandomRows() {
    std::uniform_int_distribution<int> length(0, 5), pick(0, static_cast<int>(particles) - 1);
    for (std::size_t p = 0; p < points; ++p) {
      for (int k = length(rng); k > 0; --k) {
        particle.push_back(pick(rng));
        weight.push_back(uniform(rng));
      }
      start.push_back(static_cast<std::int32_t>(particle.size()));
    }
    for (std::size_t i = 0; i < 3 * particles; ++i) v.push_back(uniform(rng));
    for (std::size_t i = 0; i < points; ++i) f.emplace_back(uniform(rng), uniform(rng), uniform(rng));
  }
};

TEST(PointWeights, VelocityAndForceOfOnePointByHand) {
  PointWeightsMap map;
  map.reset(3, 1, 2);
  auto row = map.row(0);
  row.particle[0] = 0, row.weight[0] = 0.25;
  row.particle[1] = 2, row.weight[1] = 0.75;
  map.finish();
  const std::vector<double> v = {4, 0, 0, 9, 9, 9, 0, 8, 0};
  std::vector<Vec3> u(1);
  map.apply(v, u);
  EXPECT_EQ(u[0], Vec3(1, 6, 0));
  std::vector<double> Q(9, 1.0);
  map.apply_transpose(std::vector<Vec3>{Vec3(4, 8, 12)}, Q);
  EXPECT_EQ(Q, (std::vector<double>{2, 3, 4, 1, 1, 1, 4, 7, 10}));
}

TEST(PointWeights, ForceIsTheTransposeOfVelocity) {
  SCOPED_TRACE(kSeed);
  RandomRows rows;
  PointWeightsMap map;
  map.assign(rows.particles, rows.start, rows.particle, rows.weight);
  std::vector<Vec3> u(rows.points);
  map.apply(rows.v, u);
  std::vector<double> Q(rows.v.size(), 0.0);
  map.apply_transpose(rows.f, Q);
  double a = 0, b = 0, scale = 0;
  for (std::size_t p = 0; p < rows.points; ++p) a += u[p].dot(rows.f[p]), scale += u[p].norm() * rows.f[p].norm();
  for (std::size_t i = 0; i < Q.size(); ++i) b += Q[i] * rows.v[i];
  EXPECT_NEAR(a, b, 1e-14 * scale);
  EXPECT_GT(std::abs(a), 1e-3 * scale / rows.points);
}

TEST(PointWeights, DiagonalBlocksAreThoseOfTheAssembledProduct) {
  RandomRows rows;
  PointWeightsMap map;
  map.assign(rows.particles, rows.start, rows.particle, rows.weight);
  std::vector<Mat3> K(rows.points);
  for (auto& k : K) {
    const Mat3 a = Mat3::NullaryExpr([&] { return rows.uniform(rows.rng); });
    k = a * a.transpose();
  }
  BlockDiagonal D;
  const std::vector<int> sizes(rows.particles + 2, 3);
  D.reset(sizes);
  map.add_block_diagonal(K, 2, D);
  // Reference: unit vectors through J, K and Jᵀ.
  std::vector<Vec3> u(rows.points);
  for (std::size_t c = 0; c < 3 * rows.particles; ++c) {
    std::vector<double> e(3 * rows.particles, 0.0), Q(3 * rows.particles, 0.0);
    e[c] = 1.0;
    map.apply(e, u);
    for (std::size_t p = 0; p < rows.points; ++p) u[p] = K[p] * u[p];
    map.apply_transpose(u, Q);
    for (int r = 0; r < 3; ++r) EXPECT_NEAR(D.block(2 + c / 3)(r, c % 3), Q[3 * (c / 3) + r], 1e-12);
  }
  EXPECT_EQ(D.block(0).norm() + D.block(1).norm(), 0.0);
}

TEST(PointWeights, NoPointsAndEmptyRowsGiveNothing) {
  PointWeightsMap map;
  map.reset(5, 0, 4);
  map.finish();
  std::vector<double> Q(15, 0.0);
  map.apply_transpose({}, Q);
  EXPECT_EQ(Q, std::vector<double>(15, 0.0));
  map.assign(5, std::vector<std::int32_t>{0, 0}, {}, {});
  std::vector<Vec3> u(1, Vec3::Ones());
  map.apply(std::vector<double>(15, 1.0), u);
  EXPECT_EQ(u[0], Vec3::Zero());
}

TEST(PointWeights, ThreadsDoNotChangeABit) {
  RandomRows rows;
  PointWeightsMap map;
  map.assign(rows.particles, rows.start, rows.particle, rows.weight);
  std::vector<double> reference;
  for (int threads : {1, 2, 4}) {
    ThreadLimit limit(threads);
    std::vector<double> Q(rows.v.size(), 0.0);
    map.apply_transpose(rows.f, Q);
    if (reference.empty()) reference = Q;
    EXPECT_EQ(Q, reference);
  }
}

}  // namespace
}  // namespace brim::point_weights_test
