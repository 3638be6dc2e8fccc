#include "brim/map/shell_weights.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/mesh/tri_mesh.h"

namespace brim {
namespace {

constexpr unsigned kSeed = 7;

struct RandomShell {
  std::mt19937 rng{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};
  std::vector<Vec3> x;
  std::vector<Triangle> triangles;
  std::vector<Vec3> r;  // one point per triangle, off its plane
  std::vector<Vec3> b;  // its coordinates
  std::vector<double> d;
  ShellWeightsMap map;

  Vec3 random() { return Vec3(uniform(rng), uniform(rng), uniform(rng)); }
  static Vec3 normal(const Vec3& p0, const Vec3& p1, const Vec3& p2) { return (p1 - p0).cross(p2 - p0).normalized(); }
  Vec3 place(std::size_t p, const std::vector<Vec3>& at) const {
    const auto& t = triangles[p];
    return b[p][0] * at[t[0]] + b[p][1] * at[t[1]] + b[p][2] * at[t[2]] + d[p] * normal(at[t[0]], at[t[1]], at[t[2]]);
  }

  RandomShell() {
    for (int i = 0; i < 30; ++i) x.push_back(random());
    std::uniform_int_distribution<int> pick(0, 29);
    while (triangles.size() < 100) {
      const Triangle t = {pick(rng), pick(rng), pick(rng)};
      if ((x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm() < 0.2) continue;
      triangles.push_back(t);
      Vec3 w(0.5 + 0.8 * uniform(rng), 0.5 + 0.8 * uniform(rng), 0);
      w[2] = 1 - w[0] - w[1];
      b.push_back(w);
      d.push_back(0.3 * uniform(rng));
      r.push_back(place(triangles.size() - 1, x));
    }
    map.reset(x.size(), r.size());
    for (std::size_t p = 0; p < r.size(); ++p) map.set(p, r[p], triangles[p], x);
    map.finish();
  }
  std::vector<double> flat(const std::vector<Vec3>& a) const {
    std::vector<double> v;
    for (const Vec3& p : a) v.insert(v.end(), {p.x(), p.y(), p.z()});
    return v;
  }
};

TEST(ShellWeights, ForceAboveARightTriangleByHand) {
  // b = (1, 0, 0), d = 2: f = x̂ at height 2 over corner 0 is the same force there plus a couple about y.
  const std::vector<Vec3> x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  ShellWeightsMap map;
  map.reset(3, 1);
  map.set(0, Vec3(0, 0, 2), {0, 1, 2}, x);
  map.finish();
  std::vector<double> Q(9, 0.0);
  map.add_force(std::vector<Vec3>{Vec3(1, 0, 0)}, Q);
  EXPECT_EQ(Q, (std::vector<double>{1, 0, 2, 0, 0, -2, 0, 0, 0}));
}

TEST(ShellWeights, VelocityIsTheDerivativeOfTheRidingPoint) {
  SCOPED_TRACE(kSeed);
  RandomShell s;
  std::vector<Vec3> dx;
  for (std::size_t i = 0; i < s.x.size(); ++i) dx.push_back(s.random());
  std::vector<Vec3> u(s.r.size());
  s.map.velocity(s.flat(dx), u);
  const double e = 1e-6;
  auto plus = s.x, minus = s.x;
  for (std::size_t i = 0; i < s.x.size(); ++i) plus[i] += e * dx[i], minus[i] -= e * dx[i];
  for (std::size_t p = 0; p < s.r.size(); ++p)
    EXPECT_LT((u[p] - (s.place(p, plus) - s.place(p, minus)) / (2 * e)).norm(), 1e-8) << "point " << p;
}

TEST(ShellWeights, RigidMotionIsReproduced) {
  RandomShell s;
  const Vec3 t(0.3, -0.4, 0.9), omega(1.0, -2.0, 0.5);
  std::vector<Vec3> v, u(s.r.size());
  for (const Vec3& p : s.x) v.push_back(t + omega.cross(p));
  s.map.velocity(s.flat(v), u);
  for (std::size_t p = 0; p < s.r.size(); ++p) EXPECT_LT((u[p] - t - omega.cross(s.r[p])).norm(), 1e-13);
}

TEST(ShellWeights, ForceAndTorqueArriveWhole) {
  RandomShell s;
  for (std::size_t p = 0; p < s.r.size(); ++p) {
    std::vector<Vec3> f(s.r.size(), Vec3::Zero());
    f[p] = s.random();
    std::vector<double> Q(3 * s.x.size(), 0.0);
    s.map.add_force(f, Q);
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      const Vec3 q(Q[3 * i], Q[3 * i + 1], Q[3 * i + 2]);
      force += q;
      torque += s.x[i].cross(q);
    }
    EXPECT_LT((force - f[p]).norm(), 1e-13);
    EXPECT_LT((torque - s.r[p].cross(f[p])).norm(), 1e-13);
  }
}

TEST(ShellWeights, ForceIsTheTransposeOfVelocityAndBlocksAgree) {
  RandomShell s;
  std::vector<Mat3> K(s.r.size());
  for (auto& k : K) {
    const Mat3 a = Mat3::NullaryExpr([&] { return s.uniform(s.rng); });
    k = a * a.transpose();
  }
  const std::vector<int> sizes(s.x.size(), 3);
  BlockDiagonal D;
  D.reset(sizes);
  s.map.add_block_diagonal(K, 0, D);
  std::vector<Vec3> u(s.r.size());
  for (std::size_t c = 0; c < 3 * s.x.size(); ++c) {
    std::vector<double> e(3 * s.x.size(), 0.0), Q(3 * s.x.size(), 0.0);
    e[c] = 1.0;
    s.map.velocity(e, u);
    for (std::size_t p = 0; p < u.size(); ++p) u[p] = K[p] * u[p];
    s.map.add_force(u, Q);
    for (int r = 0; r < 3; ++r) EXPECT_NEAR(D.block(c / 3)(r, c % 3), Q[3 * (c / 3) + r], 1e-12);
  }
}

TEST(ShellWeights, SliverFallsBackToTheClosestPoint) {
  const std::vector<Vec3> x = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  ShellWeightsMap map;
  map.reset(3, 1);
  map.set(0, Vec3(0.5, 0.1, 0), {0, 1, 2}, x);
  map.finish();
  std::vector<Vec3> u(1);
  map.velocity(std::vector<double>{2, 0, 0, 4, 0, 0, 0, 0, 0}, u);
  EXPECT_TRUE(u[0].isApprox(Vec3(3, 0, 0)));
}

}  // namespace
}  // namespace brim
