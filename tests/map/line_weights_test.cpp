#include "brim/map/line_weights.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::line_weights_test {
namespace {

constexpr unsigned kSeed = 17;

using Segment = std::array<std::int32_t, 2>;

struct RandomLines {
  std::mt19937 rng{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};
  std::vector<Vec3> x;
  std::vector<Segment> segments;
  std::vector<Vec3> r;       // one point per segment, beside it
  std::vector<double> s;     // its place along the segment
  std::vector<Vec3> offset;  // e
  LineWeightsMap map;

  Vec3 random() { return Vec3(uniform(rng), uniform(rng), uniform(rng)); }
  Vec3 direction(std::size_t p, const std::vector<Vec3>& at) const {
    return (at[segments[p][1]] - at[segments[p][0]]).normalized();
  }
  /// The offset turned as the segment turns, by the shortest rotation.
  Vec3 place(std::size_t p, const std::vector<Vec3>& at) const {
    const Quat turn = Quat::FromTwoVectors(direction(p, x), direction(p, at));
    return (1 - s[p]) * at[segments[p][0]] + s[p] * at[segments[p][1]] + turn * offset[p];
  }

  RandomLines() {
    for (int i = 0; i < 30; ++i) x.push_back(random());
    std::uniform_int_distribution<int> pick(0, 29);
    while (segments.size() < 100) {
      const Segment e = {pick(rng), pick(rng)};
      if ((x[e[1]] - x[e[0]]).norm() < 0.3) continue;
      segments.push_back(e);
      s.push_back(0.5 + uniform(rng));
      const Vec3 t = direction(s.size() - 1, x), d = random();
      offset.push_back(0.3 * (d - t * t.dot(d)));
      r.push_back(place(s.size() - 1, x));
    }
    map.reset(x.size(), r.size());
    for (std::size_t p = 0; p < r.size(); ++p) map.set(p, r[p], segments[p], x);
    map.finish();
  }
};

std::vector<double> flat(const std::vector<Vec3>& a) {
  std::vector<double> v;
  for (const Vec3& p : a) v.insert(v.end(), {p.x(), p.y(), p.z()});
  return v;
}

TEST(LineWeights, ForcesBesideAUnitSegmentByHand) {
  // Segment 0 to x̂, point at x = 1/4 and y = 2. A force along x̂ makes a couple about z, carried by the two ends.
  const std::vector<Vec3> x = {{0, 0, 0}, {1, 0, 0}};
  LineWeightsMap map;
  map.reset(2, 1);
  map.set(0, Vec3(0.25, 2, 0), {0, 1}, x);
  map.finish();
  std::vector<double> Q(6, 0.0);
  map.apply_transpose(std::vector<Vec3>{Vec3(1, 0, 0)}, Q);
  EXPECT_EQ(Q, (std::vector<double>{0.75, 2, 0, 0.25, -2, 0}));
  // A force towards the line has no couple; one around the line goes to the ends, its spin about x is lost.
  Q.assign(6, 0.0);
  map.apply_transpose(std::vector<Vec3>{Vec3(0, -1, 4)}, Q);
  EXPECT_EQ(Q, (std::vector<double>{0, -0.75, 3, 0, -0.25, 1}));
}

TEST(LineWeights, VelocityIsTheDerivativeOfTheRidingPoint) {
  SCOPED_TRACE(kSeed);
  RandomLines l;
  std::vector<Vec3> dx;
  for (std::size_t i = 0; i < l.x.size(); ++i) dx.push_back(l.random());
  std::vector<Vec3> u(l.r.size());
  l.map.apply(flat(dx), u);
  const double e = 1e-6;
  auto plus = l.x, minus = l.x;
  for (std::size_t i = 0; i < l.x.size(); ++i) plus[i] += e * dx[i], minus[i] -= e * dx[i];
  for (std::size_t p = 0; p < l.r.size(); ++p)
    EXPECT_LT((u[p] - (l.place(p, plus) - l.place(p, minus)) / (2 * e)).norm(), 1e-7) << "point " << p;
}

TEST(LineWeights, ForcesAreTheTransposeOfVelocities) {
  SCOPED_TRACE(kSeed);
  RandomLines l;
  std::vector<Vec3> v, f;
  for (std::size_t i = 0; i < l.x.size(); ++i) v.push_back(l.random());
  for (std::size_t p = 0; p < l.r.size(); ++p) f.push_back(l.random());
  std::vector<Vec3> u(l.r.size());
  std::vector<double> Q(3 * l.x.size(), 0.0);
  const std::vector<double> flat_v = flat(v);
  l.map.apply(flat_v, u);
  l.map.apply_transpose(f, Q);
  double points = 0, particles = 0, size = 0;
  for (std::size_t p = 0; p < f.size(); ++p) points += u[p].dot(f[p]), size += std::abs(u[p].dot(f[p]));
  for (std::size_t i = 0; i < Q.size(); ++i) particles += Q[i] * flat_v[i];
  EXPECT_NEAR(points, particles, 1e-14 * size);
}

TEST(LineWeights, OnlyTheSpinAboutTheLineIsLost) {
  SCOPED_TRACE(kSeed);
  RandomLines l;
  for (std::size_t p = 0; p < l.r.size(); ++p) {
    std::vector<Vec3> f(l.r.size(), Vec3::Zero());
    f[p] = l.random();
    std::vector<double> Q(3 * l.x.size(), 0.0);
    l.map.apply_transpose(f, Q);
    Vec3 force = -f[p], torque = -l.r[p].cross(f[p]);
    for (std::size_t i = 0; i < l.x.size(); ++i) {
      const Vec3 q(Q[3 * i], Q[3 * i + 1], Q[3 * i + 2]);
      force += q;
      torque += l.x[i].cross(q);
    }
    const Vec3 t = l.direction(p, l.x);
    EXPECT_LT(force.norm(), 1e-14 * 10);
    EXPECT_LT((torque + t * t.dot(l.offset[p].cross(f[p]))).norm(), 1e-13);
  }
}

TEST(LineWeights, BlockDiagonalIsThatOfTheProduct) {
  SCOPED_TRACE(kSeed);
  RandomLines l;
  std::vector<Mat3> K;
  for (std::size_t p = 0; p < l.r.size(); ++p) {
    const Vec3 a = l.random(), b = l.random();
    K.push_back(a * a.transpose() + b * b.transpose());
  }
  BlockDiagonal D;
  D.reset(std::vector<int>(l.x.size(), 3));
  l.map.add_block_diagonal(K, 0, D);
  for (std::size_t i = 0; i < l.x.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      std::vector<double> v(3 * l.x.size(), 0.0), Q(v.size(), 0.0);
      v[3 * i + c] = 1.0;
      std::vector<Vec3> u(l.r.size());
      l.map.apply(v, u);
      for (std::size_t p = 0; p < u.size(); ++p) u[p] = K[p] * u[p];
      l.map.apply_transpose(u, Q);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(D.block(i)(k, c), Q[3 * i + k], 1e-12);
    }
}

TEST(LineWeights, SegmentsWithoutLengthCarryTheForceWithoutTheTorque) {
  const std::vector<Vec3> x = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1.001}};
  LineWeightsMap map;
  map.reset(3, 2);
  map.set(0, Vec3(2, 1, 1), {0, 1}, x);
  map.set(1, Vec3(2, 1, 1.5), {0, 2}, x);
  map.finish();
  std::vector<double> Q(9, 0.0);
  map.apply_transpose(std::vector<Vec3>{Vec3(1, 2, 3), Vec3(1, 0, 0)}, Q);
  EXPECT_EQ(Q, (std::vector<double>{1, 2, 3, 0, 0, 0, 1, 0, 0}));
}

}  // namespace
}  // namespace brim::line_weights_test
