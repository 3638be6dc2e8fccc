#include "brim/map/shell_weights.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "brim/mesh/tri_mesh.h"

namespace brim::shell_weights_test {
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
      d.push_back(0.8 * uniform(rng));
      r.push_back(place(triangles.size() - 1, x));
    }
    std::vector<std::int32_t> nearest(r.size());
    std::iota(nearest.begin(), nearest.end(), 0);
    map.build(SheetPatches(triangles), r, nearest, x);
  }
  /// The point rides on its own triangle.
  bool on_triangle(std::size_t p) const {
    return ShellWeightsMap::lever(r[p], triangles[p], x) <= ShellWeightsMap::kMaxLever;
  }
  std::vector<double> flat(const std::vector<Vec3>& a) const {
    std::vector<double> v;
    for (const Vec3& p : a) v.insert(v.end(), {p.x(), p.y(), p.z()});
    return v;
  }
};

SheetPatches one_triangle() { return SheetPatches(std::vector<Triangle>{{0, 1, 2}}); }

TEST(ShellWeights, ForceAboveARightTriangleByHand) {
  // b = (1, 0, 0), d = 1: f = x̂ at height 1 over corner 0 is the same force there plus a couple about y.
  const std::vector<Vec3> x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  ShellWeightsMap map;
  map.build(one_triangle(), std::vector{Vec3(0, 0, 1)}, std::vector<std::int32_t>{0}, x);
  std::vector<double> Q(9, 0.0);
  map.apply_transpose(std::vector<Vec3>{Vec3(1, 0, 0)}, Q);
  EXPECT_EQ(Q, (std::vector<double>{1, 0, 1, 0, 0, -1, 0, 0, 0}));
}

TEST(ShellWeights, VelocityIsTheDerivativeOfTheRidingPoint) {
  SCOPED_TRACE(kSeed);
  RandomShell s;
  std::vector<Vec3> dx;
  for (std::size_t i = 0; i < s.x.size(); ++i) dx.push_back(s.random());
  std::vector<Vec3> u(s.r.size());
  s.map.apply(s.flat(dx), u);
  const double e = 1e-6;
  auto plus = s.x, minus = s.x;
  for (std::size_t i = 0; i < s.x.size(); ++i) plus[i] += e * dx[i], minus[i] -= e * dx[i];
  std::size_t on_triangles = 0;
  for (std::size_t p = 0; p < s.r.size(); ++p) {
    if (!s.on_triangle(p)) continue;
    ++on_triangles;
    EXPECT_LT((u[p] - (s.place(p, plus) - s.place(p, minus)) / (2 * e)).norm(), 1e-8) << "point " << p;
  }
  EXPECT_GT(on_triangles, 80u);
  EXPECT_LT(on_triangles, s.r.size());  // the other tests look at points on patches too
}

TEST(ShellWeights, RigidMotionIsReproduced) {
  RandomShell s;
  const Vec3 t(0.3, -0.4, 0.9), omega(1.0, -2.0, 0.5);
  std::vector<Vec3> v, u(s.r.size());
  for (const Vec3& p : s.x) v.push_back(t + omega.cross(p));
  s.map.apply(s.flat(v), u);
  for (std::size_t p = 0; p < s.r.size(); ++p) EXPECT_LT((u[p] - t - omega.cross(s.r[p])).norm(), 1e-13);
}

TEST(ShellWeights, ForceAndTorqueArriveWhole) {
  RandomShell s;
  for (std::size_t p = 0; p < s.r.size(); ++p) {
    std::vector<Vec3> f(s.r.size(), Vec3::Zero());
    f[p] = s.random();
    std::vector<double> Q(3 * s.x.size(), 0.0);
    s.map.apply_transpose(f, Q);
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
    s.map.apply(e, u);
    for (std::size_t p = 0; p < u.size(); ++p) u[p] = K[p] * u[p];
    s.map.apply_transpose(u, Q);
    for (int r = 0; r < 3; ++r) EXPECT_NEAR(D.block(c / 3)(r, c % 3), Q[3 * (c / 3) + r], 1e-12);
  }
}

TEST(ShellWeights, SliverFallsBackToTheClosestPoint) {
  const std::vector<Vec3> x = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  ShellWeightsMap map;
  map.build(one_triangle(), std::vector{Vec3(0.5, 0.1, 0)}, std::vector<std::int32_t>{0}, x);
  std::vector<Vec3> u(1);
  map.apply(std::vector<double>{2, 0, 0, 4, 0, 0, 0, 0, 0}, u);
  EXPECT_TRUE(u[0].isApprox(Vec3(3, 0, 0)));
}

/// A sheet of cells x cells squares of side 1, squeezed to `share` of its length along x.
struct Squeezed {
  std::vector<Vec3> x;
  std::vector<Triangle> triangles;

  Squeezed(int cells, double share) {
    for (int j = 0; j <= cells; ++j)
      for (int i = 0; i <= cells; ++i) x.push_back(Vec3(share * i, j, 0.3 * (i % 2)));
    const auto at = [&](int i, int j) { return static_cast<std::int32_t>(j * (cells + 1) + i); };
    for (int j = 0; j < cells; ++j)
      for (int i = 0; i < cells; ++i) {
        triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
  }
};

TEST(ShellWeights, ASqueezedSheetIsNoShortLever) {
  // Pleats of a twentieth of a cell: a point one cell above them would turn a triangle about its short side.
  const Squeezed s(8, 0.05);
  const std::size_t t = 2 * (8 * 4 + 4);
  const Vec3 r = (s.x[s.triangles[t][0]] + s.x[s.triangles[t][1]] + s.x[s.triangles[t][2]]) / 3.0 + Vec3(1, 0, 0.2);
  EXPECT_GT(ShellWeightsMap::lever(r, s.triangles[t], s.x), ShellWeightsMap::kMaxLever);
  ShellWeightsMap map;
  map.build(SheetPatches(s.triangles), std::vector{r}, std::vector{static_cast<std::int32_t>(t)}, s.x);
  std::vector<double> Q(3 * s.x.size(), 0.0);
  const Vec3 f(0.3, -0.2, 1.0);
  map.apply_transpose(std::vector{f}, Q);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double largest = 0.0;
  std::size_t reached = 0;
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    const Vec3 q(Q[3 * i], Q[3 * i + 1], Q[3 * i + 2]);
    force += q, torque += s.x[i].cross(q), largest = std::max(largest, q.norm()), reached += q.norm() > 0.0;
  }
  EXPECT_LT((force - f).norm(), 1e-12);
  EXPECT_LT((torque - r.cross(f)).norm(), 1e-12);
  EXPECT_LT(largest, f.norm());  // on the triangle alone it would be many times the force
  EXPECT_EQ(reached, 12u);       // those of the triangles around
}

}  // namespace
}  // namespace brim::shell_weights_test
