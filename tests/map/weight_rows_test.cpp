#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "brim/map/composed_map.h"
#include "brim/map/rigid_map.h"
#include "brim/map/rows_map.h"

namespace brim::weight_rows_test {
namespace {

constexpr unsigned kSeed = 17;

struct Random {
  std::mt19937 rng{kSeed};
  std::uniform_real_distribution<double> u{-1, 1};
  double operator()() { return u(rng); }
  Vec3 vec() { return Vec3(u(rng), u(rng), u(rng)); }
};

WeightRows random_rows(Random& r, std::size_t rows, int sources, int per_row, bool levers) {
  WeightRows w;
  for (std::size_t p = 0; p < rows; ++p) {
    for (int e = 0; e < per_row; ++e) {
      w.source.push_back(
          static_cast<std::int32_t>((p * 7 + static_cast<std::size_t>(e)) % static_cast<std::size_t>(sources)));
      w.weight.push_back(r());
      if (levers) w.lever.push_back(r.vec());
    }
    w.first.push_back(static_cast<std::int32_t>(w.source.size()));
    if (levers) w.normal.push_back(r.vec().normalized());
  }
  return w;
}

/// J column by column.
Eigen::MatrixXd dense(const Map& map, std::size_t nv) {
  Eigen::MatrixXd J(3 * map.points(), nv);
  std::vector<Vec3> u(map.points());
  for (std::size_t c = 0; c < nv; ++c) {
    std::vector<double> v(nv, 0.0);
    v[c] = 1.0;
    map.apply(v, u);
    for (std::size_t p = 0; p < u.size(); ++p) J.block<3, 1>(3 * static_cast<int>(p), static_cast<int>(c)) = u[p];
  }
  return J;
}

Eigen::MatrixXd dense_force(const Map& map, std::size_t nv) {
  Eigen::MatrixXd Jt = Eigen::MatrixXd::Zero(nv, 3 * map.points());
  for (std::size_t c = 0; c < 3 * map.points(); ++c) {
    std::vector<Vec3> f(map.points(), Vec3::Zero());
    f[c / 3][static_cast<int>(c % 3)] = 1.0;
    std::vector<double> Q(nv, 0.0);
    map.apply_transpose(f, Q);
    for (std::size_t i = 0; i < nv; ++i) Jt(static_cast<int>(i), static_cast<int>(c)) = Q[i];
  }
  return Jt;
}

TEST(WeightRows, ARowByHand) {
  WeightRows w;
  w.first = {0, 2};
  w.source = {0, 1};
  w.weight = {0.25, 0.75};
  w.normal = {Vec3(0, 0, 1)};
  w.lever = {Vec3(1, 0, 0), Vec3(0, 2, 0)};
  RowsMap map;
  map.assign(2, w);
  std::vector<Vec3> u(1);
  map.apply(std::vector<double>{4, 0, 0, 0, 3, 8}, u);
  EXPECT_EQ(u[0], Vec3(1, 2.25, 6 + 4 + 6));
}

TEST(WeightRows, ForceIsTheTransposeOfVelocityAndDiagonalIsExact) {
  Random r;
  for (const bool levers : {false, true}) {
    RowsMap map;
    map.assign(6, random_rows(r, 9, 6, 4, levers));
    const Eigen::MatrixXd J = dense(map, 18);
    EXPECT_LT((dense_force(map, 18) - J.transpose()).norm(), 1e-13) << "seed " << kSeed;
    std::vector<Mat3> K;
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(27, 27);
    for (int p = 0; p < 9; ++p) {
      const Mat3 a = Mat3::Identity() * (1.5 + r());
      K.push_back(a);
      full.block<3, 3>(3 * p, 3 * p) = a;
    }
    BlockDiagonal D;
    D.reset(std::vector<int>(6, 3));
    map.add_block_diagonal(K, 0, D);
    const Eigen::MatrixXd A = J.transpose() * full * J;
    for (int b = 0; b < 6; ++b)
      EXPECT_LT((D.block(static_cast<std::size_t>(b)) - A.block<3, 3>(3 * b, 3 * b)).norm(), 1e-12);
  }
}

TEST(WeightRows, ComposingIsTheProductOfTheMaps) {
  Random r;
  for (const bool levers : {false, true}) {
    const WeightRows outer = random_rows(r, 8, 5, 3, levers), inner = random_rows(r, 5, 7, 4, false);
    RowsMap joined, first, second;
    joined.assign(7, compose(outer, inner));
    first.assign(5, outer);
    second.assign(7, inner);
    const Eigen::MatrixXd product = dense(first, 15) * dense(second, 21);
    EXPECT_LT((dense(joined, 21) - product).norm(), 1e-13) << "seed " << kSeed;

    auto held = std::make_unique<RowsMap>();
    held->assign(7, inner);
    ComposedMap composed;
    composed.assign(outer, std::move(held));
    EXPECT_LT((dense(composed, 21) - product).norm(), 1e-13);
    EXPECT_LT((dense_force(composed, 21) - product.transpose()).norm(), 1e-13);
  }
}

TEST(WeightRows, ComposedDiagonalBoundsTheTrueOne) {
  Random r;
  for (const bool levers : {false, true}) {
    const WeightRows outer = random_rows(r, 8, 5, 3, levers);
    std::vector<Vec3> x;
    for (int i = 0; i < 5; ++i) x.push_back(r.vec());
    auto rigid = std::make_unique<RigidMap>();
    rigid->reset(0, Vec3(0.1, 0.2, 0.3), x);
    ComposedMap map;
    map.assign(outer, std::move(rigid));
    const Eigen::MatrixXd J = dense(map, 6);
    const std::vector<Mat3> K(8, 2.0 * Mat3::Identity());
    BlockDiagonal D;
    D.reset(std::vector<int>{6});
    map.add_block_diagonal(K, 0, D);
    const Eigen::MatrixXd gap = Eigen::MatrixXd(D.block(0)) - 2.0 * J.transpose() * J;
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(gap).eigenvalues().minCoeff(), -1e-12);
  }
}

TEST(WeightRows, NoPointsMakeNoForces) {
  RowsMap map;
  map.assign(3, WeightRows{});
  std::vector<double> Q(9, 0.0);
  map.apply_transpose(std::span<const Vec3>(), Q);
  map.apply(Q, std::span<Vec3>());
  EXPECT_EQ(Q, std::vector<double>(9, 0.0));
}

}  // namespace
}  // namespace brim::weight_rows_test
