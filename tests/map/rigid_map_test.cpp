#include "brim/map/rigid_map.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "brim/math/rotation.h"

namespace brim::rigid_map_test {
namespace {

constexpr unsigned kSeed = 41;
constexpr std::size_t kFirst = 2;  ///< row of the frame in the body's velocities: not 0, so that offsets are tested
constexpr std::size_t kRows = 9;

struct Frame {
  std::mt19937 rng{kSeed};
  std::normal_distribution<double> normal;
  Vec3 origin = vector();
  std::vector<Vec3> points, forces;
  std::vector<double> v;
  RigidMap map;

  explicit Frame(std::size_t n = 50) {
    for (std::size_t i = 0; i < n; ++i) points.push_back(vector()), forces.push_back(vector());
    for (std::size_t i = 0; i < kRows; ++i) v.push_back(normal(rng));
    map.reset(kFirst, origin, points);
  }
  Vec3 vector() {
    const double x = normal(rng), y = normal(rng);
    return {x, y, normal(rng)};
  }
  Vec3 linear() const { return Vec3(v[kFirst], v[kFirst + 1], v[kFirst + 2]); }
  Vec3 angular() const { return Vec3(v[kFirst + 3], v[kFirst + 4], v[kFirst + 5]); }
  /// The points after the frame moved by e v.
  std::vector<Vec3> moved(double e) const {
    std::vector<Vec3> p;
    for (const Vec3& r : points)
      p.push_back(origin + e * linear() + rotation_from_vector(e * angular()) * Vec3(r - origin));
    return p;
  }
};

TEST(RigidMap, VelocityAndForceOfOnePointByHand) {
  RigidMap map;
  map.reset(0, Vec3(1, 0, 0), std::vector<Vec3>{Vec3(1, 2, 0)});
  std::vector<Vec3> u(1);
  map.apply(std::vector<double>{5, 0, 0, 0, 0, 3}, u);
  EXPECT_EQ(u[0], Vec3(-1, 0, 0));
  std::vector<double> Q(6, 1.0);
  map.apply_transpose(std::vector<Vec3>{Vec3(4, 0, 0)}, Q);
  EXPECT_EQ(Q, (std::vector<double>{5, 1, 1, 1, 1, -7}));
}

TEST(RigidMap, ForceIsTheTransposeOfVelocity) {
  SCOPED_TRACE(kSeed);
  const Frame f;
  std::vector<Vec3> u(f.points.size());
  f.map.apply(f.v, u);
  std::vector<double> Q(kRows, 0.0);
  f.map.apply_transpose(f.forces, Q);
  double work = 0.0, size = 0.0, generalised = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) work += u[i].dot(f.forces[i]), size += std::abs(u[i].dot(f.forces[i]));
  for (std::size_t i = 0; i < kRows; ++i) generalised += f.v[i] * Q[i];
  EXPECT_NEAR(work, generalised, 1e-14 * size);
  EXPECT_EQ(Q[0], 0.0);
  EXPECT_EQ(Q[8], 0.0) << "rows of others are left alone";
}

TEST(RigidMap, VelocityIsTheDerivativeOfThePositionsOfAMovedFrame) {
  SCOPED_TRACE(kSeed);
  const Frame f;
  std::vector<Vec3> u(f.points.size());
  f.map.apply(f.v, u);
  const double e = 1e-6;
  const auto up = f.moved(e), down = f.moved(-e);
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double scale = f.linear().norm() + f.angular().norm() * (f.points[i] - f.origin).norm();
    EXPECT_LT((u[i] - (up[i] - down[i]) / (2 * e)).norm(), 1e-9 * scale);
  }
}

TEST(RigidMap, GeometricTermIsTheChangeOfTheGeneralisedForceWhenTheFrameMoves) {
  SCOPED_TRACE(kSeed);
  const Frame f;
  std::vector<double> geometric(kRows, 0.0);
  f.map.add_geometric(f.forces, f.v, geometric);
  const double e = 1e-6;
  std::vector<double> up(kRows, 0.0), down(kRows, 0.0);
  RigidMap moved;
  moved.reset(kFirst, f.origin + e * f.linear(), f.moved(e));
  moved.apply_transpose(f.forces, up);
  moved.reset(kFirst, f.origin - e * f.linear(), f.moved(-e));
  moved.apply_transpose(f.forces, down);
  double size = 0.0;
  for (std::size_t i = 0; i < kRows; ++i) {
    EXPECT_NEAR(geometric[i], (up[i] - down[i]) / (2 * e), 1e-7);  // rounding 1e-15 * 50 points / e
    size += std::abs(geometric[i]);
  }
  EXPECT_GT(size, 1.0);
}

TEST(RigidMap, BlockDiagonalEqualsTheAssembledProduct) {
  SCOPED_TRACE(kSeed);
  Frame f;
  f.map.reset(0, f.origin, f.points);
  std::vector<Mat3> K;
  Eigen::MatrixXd J(3 * f.points.size(), 6), big = Eigen::MatrixXd::Zero(J.rows(), J.rows());
  for (std::size_t i = 0; i < f.points.size(); ++i) {
    Mat3 m;
    m << f.vector(), f.vector(), f.vector();
    K.push_back(m * m.transpose());
    big.block<3, 3>(3 * i, 3 * i) = K.back();
  }
  std::vector<Vec3> u(f.points.size());
  for (int c = 0; c < 6; ++c) {
    std::vector<double> unit(6, 0.0);
    unit[c] = 1.0;
    f.map.apply(unit, u);
    for (std::size_t i = 0; i < u.size(); ++i) J.col(c).segment<3>(3 * i) = u[i];
  }
  BlockDiagonal D;
  D.reset(std::vector<int>{3, 6});
  f.map.add_block_diagonal(K, 1, D);
  const Eigen::MatrixXd expected = J.transpose() * big * J;
  EXPECT_LT((Eigen::MatrixXd(D.block(1)) - expected).norm(), 1e-14 * expected.norm());
  EXPECT_EQ(D.block(0).norm(), 0.0);
}

TEST(RigidMap, NoPointsGiveNoForce) {
  RigidMap map;
  map.reset(0, Vec3(1, 2, 3), {});
  EXPECT_EQ(map.points(), 0u);
  std::vector<double> Q(6, 0.0);
  map.apply_transpose({}, Q);
  EXPECT_EQ(Q, std::vector<double>(6, 0.0));
}

}  // namespace
}  // namespace brim::rigid_map_test
