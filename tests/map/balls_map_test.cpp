#include "brim/map/balls_map.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::balls_map_test {
namespace {

constexpr unsigned kSeed = 29;

struct Made {
  std::vector<Vec3> x, points;
  std::vector<std::int32_t> ball;
  BallsMap map;
};

Made made(int balls, int points) {
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const auto vec = [&] {
    const double x = u(rng), y = u(rng);
    return Vec3(x, y, u(rng));
  };
  Made m;
  for (int i = 0; i < balls; ++i) m.x.push_back(vec());
  for (int i = 0; i < points; ++i) m.points.push_back(vec()), m.ball.push_back(i % balls);
  m.map.reset(m.x, m.points, m.ball);
  return m;
}

std::vector<double> noise(std::size_t n, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  std::vector<double> x(n);
  for (double& e : x) e = u(rng);
  return x;
}

TEST(BallsMap, ABallByHand) {
  BallsMap map;
  map.reset(std::vector<Vec3>{{1, 0, 0}}, std::vector<Vec3>{{1, 0, -2}}, std::vector<std::int32_t>{0});
  std::vector<Vec3> u(1);
  map.apply(std::vector<double>{3, 0, 0, 0, 1.5, 0}, u);
  EXPECT_LT(u[0].norm(), 1e-15) << "it rolls: 3 m/s is 1.5 rad/s times 2 m";
  std::vector<double> Q(6, 0.0);
  map.apply_transpose(std::vector<Vec3>{{1, 0, 5}}, Q);
  EXPECT_EQ(Q, (std::vector<double>{1, 0, 5, 0, -2, 0}));
}

TEST(BallsMap, ForcesDoTheWorkThatTheVelocitiesSay) {
  SCOPED_TRACE(kSeed);
  const Made m = made(7, 40);
  const std::vector<double> v = noise(42, 1), fs = noise(120, 2);
  std::vector<Vec3> u(40), f(40);
  for (std::size_t i = 0; i < f.size(); ++i) f[i] = Vec3(fs[3 * i], fs[3 * i + 1], fs[3 * i + 2]);
  m.map.apply(v, u);
  std::vector<double> Q(42, 0.0);
  m.map.apply_transpose(f, Q);
  double there = 0.0, here = 0.0;
  for (std::size_t i = 0; i < f.size(); ++i) there += f[i].dot(u[i]);
  for (std::size_t i = 0; i < Q.size(); ++i) here += Q[i] * v[i];
  EXPECT_NEAR(there, here, 1e-13);
}

TEST(BallsMap, KeepsTheResultantAndTheTorqueOfForces) {
  SCOPED_TRACE(kSeed);
  const Made m = made(5, 30);
  const std::vector<double> fs = noise(90, 3);
  std::vector<Vec3> f(30);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  for (std::size_t i = 0; i < f.size(); ++i) {
    f[i] = Vec3(fs[3 * i], fs[3 * i + 1], fs[3 * i + 2]);
    force += f[i], torque += m.points[i].cross(f[i]);
  }
  std::vector<double> Q(30, 0.0);
  m.map.apply_transpose(f, Q);
  for (std::size_t b = 0; b < m.x.size(); ++b) {
    const Eigen::Map<const Vec3> linear(Q.data() + 6 * b), angular(Q.data() + 6 * b + 3);
    force -= linear, torque -= m.x[b].cross(linear) + angular;
  }
  EXPECT_LT(force.norm(), 1e-13);
  EXPECT_LT(torque.norm(), 1e-13);
}

TEST(BallsMap, RowsSelectionAndDiagonalAreThoseOfTheMap) {
  SCOPED_TRACE(kSeed);
  const Made m = made(3, 12);
  MapRows rows;
  ASSERT_TRUE(m.map.append_rows(rows));
  const std::vector<double> v = noise(18, 4);
  std::vector<Vec3> u(12);
  m.map.apply(v, u);
  for (std::size_t p = 0; p < u.size(); ++p) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (std::int32_t e = rows.first[p]; e < rows.first[p + 1]; ++e)
      sum += rows.blocks[e] * Eigen::Map<const Vec3>(v.data() + 3 * rows.column[e]).cast<float>();
    EXPECT_LT((sum.cast<double>() - u[p]).norm(), 1e-6) << "single precision";
  }
  std::unique_ptr<Map> some;
  ASSERT_TRUE(m.map.select(std::vector<std::uint32_t>{2, 7}, some));
  std::vector<Vec3> two(2);
  some->apply(v, two);
  EXPECT_EQ(two[0], u[2]);
  EXPECT_EQ(two[1], u[7]);

  std::vector<Mat3> K(12);
  for (std::size_t p = 0; p < K.size(); ++p) {
    const std::vector<double> a = noise(9, 10 + static_cast<unsigned>(p));
    const Mat3 A = Eigen::Map<const Mat3>(a.data());
    K[p] = A * A.transpose();
  }
  BlockDiagonal D;
  D.reset(std::vector<int>(3, 6));
  m.map.add_block_diagonal(K, 0, D);
  for (int b = 0; b < 3; ++b)
    for (int c = 0; c < 6; ++c) {
      std::vector<double> e(18, 0.0), y(18, 0.0);
      e[static_cast<std::size_t>(6 * b + c)] = 1.0;
      std::vector<Vec3> r(12);
      m.map.apply(e, r);
      for (std::size_t p = 0; p < r.size(); ++p) r[p] = K[p] * r[p];
      m.map.apply_transpose(r, y);
      for (int k = 0; k < 6; ++k)
        EXPECT_NEAR(D.block(static_cast<std::size_t>(b))(k, c), y[static_cast<std::size_t>(6 * b + k)], 1e-12);
    }
}

}  // namespace
}  // namespace brim::balls_map_test
