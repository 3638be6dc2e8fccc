#include "brim/solve/rigid_pair_rows.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "brim/math/rotation.h"
#include "brim/solve/projected_gauss_seidel.h"

namespace brim::rigid_pair_rows_test {
namespace {

using Side = RigidPairRows::Side;

/// Three bodies, two of which move, and four contacts on each of two pairs.
struct RandomPairs {
  Side a, b, fixed;
  std::vector<Vec3> points, grips;
  std::vector<Mat3> frames;

  explicit RandomPairs(unsigned seed) {
    std::mt19937 rng(seed);
    std::normal_distribution<double> normal;
    const auto vec = [&] { return Vec3(normal(rng), normal(rng), normal(rng)); };
    const auto body = [&](std::size_t first) {
      const Mat3 L = Mat3::NullaryExpr([&] { return normal(rng); });
      return Side{first, vec(), 0.2 + std::abs(normal(rng)), L * L.transpose() + 0.1 * Mat3::Identity()};
    };
    a = body(0), b = body(6);
    fixed.center = vec();
    for (int i = 0; i < 8; ++i) {
      points.push_back(vec()), grips.push_back(vec());
      frames.push_back(rotation_from_vector(vec()).toRotationMatrix());
    }
  }

  /// A contact of the general form for the same pair.
  std::vector<ProjectedGaussSeidel::Entry> entries(const Side& one, const Side& two, std::size_t i) const {
    std::vector<ProjectedGaussSeidel::Entry> out;
    const auto add = [&](const Side& s, double sign) {
      if (s.first == RigidPairRows::kFixed) return;
      Eigen::Matrix<double, 6, 3> row, answer;
      for (int k = 0; k < 3; ++k) {
        const Vec3 f = sign * frames[i].row(k).transpose(),
                   torque = ((k == 0 ? points[i] : grips[i]) - s.center).cross(f);
        row.col(k) << f, torque;
        answer.col(k) << s.inverse_mass * f, s.inverse_inertia * torque;
      }
      for (int j = 0; j < 6; ++j) out.push_back({s.first + static_cast<std::size_t>(j), row.row(j), answer.row(j)});
    };
    add(one, 1.0);
    add(two, -1.0);
    return out;
  }
};

TEST(RigidPairRows, VelocitiesResponsesAndForcesAreThoseOfTheGeneralForm) {
  const RandomPairs r(3);
  ProjectedGaussSeidel pairs, general;
  pairs.add_pair(r.a, r.b, std::span(r.points).first(4), std::span(r.grips).first(4), std::span(r.frames).first(4),
                 0.4);
  pairs.add_pair(r.b, r.fixed, std::span(r.points).last(4), std::span(r.grips).last(4), std::span(r.frames).last(4),
                 0.4);
  for (std::size_t i = 0; i < 8; ++i) general.add(i < 4 ? r.entries(r.a, r.b, i) : r.entries(r.b, r.fixed, i), 0.4);
  std::vector<double> v(12);
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = std::sin(1.0 + 3.0 * static_cast<double>(i));
  const Vec3 impulse(1.3, -0.2, 0.7);
  for (std::size_t c = 0; c < 8; ++c) {
    EXPECT_LT((pairs.velocity(c, v) - general.velocity(c, v)).norm(), 1e-13);
    std::vector<double> one(12, 0.0), two(12, 0.0);
    pairs.add_response(c, impulse, one), general.add_response(c, impulse, two);
    for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(one[i], two[i], 1e-12);
    std::fill(one.begin(), one.end(), 0.0), std::fill(two.begin(), two.end(), 0.0);
    pairs.add_force(c, impulse, one), general.add_force(c, impulse, two);
    for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(one[i], two[i], 1e-12);
  }
}

TEST(RigidPairRows, TheSolutionIsThatOfTheGeneralForm) {
  for (unsigned seed = 1; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const RandomPairs r(seed);
    ProjectedGaussSeidel pairs, general;
    // One contact a pair: with more, impulses are not unique.
    pairs.add_pair(r.a, r.b, std::span(r.points).first(1), std::span(r.grips).first(1), std::span(r.frames).first(1),
                   0.4);
    pairs.add_pair(r.b, r.fixed, std::span(r.points).last(1), std::span(r.grips).last(1), std::span(r.frames).last(1),
                   0.4);
    general.add(r.entries(r.a, r.b, 0), 0.4);
    general.add(r.entries(r.b, r.fixed, 7), 0.4);
    const std::vector<Vec3> offset{Vec3(-1.0, 0.3, 0.2), Vec3(-0.5, 0.1, -0.4)};
    const std::vector<double> target{0.0, 0.1};
    std::vector<double> v(12, 0.0), w(12, 0.0);
    std::vector<Vec3> one(2, Vec3::Zero()), two(2, Vec3::Zero());
    ASSERT_TRUE(pairs.solve(offset, target, {.tolerance = 1e-13, .max_sweeps = 20000, .scale = 1.0}, one, v).converged);
    ASSERT_TRUE(
        general.solve(offset, target, {.tolerance = 1e-13, .max_sweeps = 20000, .scale = 1.0}, two, w).converged);
    for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(v[i], w[i], 1e-10);
    for (int c = 0; c < 2; ++c) EXPECT_LT((one[c] - two[c]).norm(), 1e-10);
  }
}

TEST(RigidPairRows, AVisitLeavesVelocitiesAndImpulsesInStepAndMomentumWhereItWas) {
  const RandomPairs r(11);
  RigidPairRows rows;
  rows.add(r.a, r.b, r.points, r.grips, r.frames, 0.4);
  const std::vector<Vec3> offset(8, Vec3(-1.0, 0.5, 0.0));
  const std::vector<double> target(8, 0.0);
  std::vector<Vec3> impulse(8, Vec3::Zero());
  std::vector<double> v(12, 0.0), wanted(12, 0.0);
  EXPECT_GT(rows.relax(0, false, 3, 1.0, offset, target, impulse, v), 0.0);
  for (std::size_t i = 0; i < 8; ++i) rows.add_response(i, impulse[i], wanted);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(v[i], wanted[i], 1e-12);
  const auto momentum = [&](const Side& s) -> Vec3 {
    return Vec3(v[s.first], v[s.first + 1], v[s.first + 2]) / s.inverse_mass;
  };
  const auto spin = [&](const Side& s) -> Vec3 {
    const Vec3 w(v[s.first + 3], v[s.first + 4], v[s.first + 5]);
    return s.inverse_inertia.inverse() * w + s.center.cross(momentum(s));
  };
  EXPECT_LT((momentum(r.a) + momentum(r.b)).norm(), 1e-13);
  EXPECT_LT((spin(r.a) + spin(r.b)).norm(), 1e-12);
}

TEST(RigidPairRows, WhereFrictionMovesTheyAreThoseOfRowsAddedThere) {
  const RandomPairs r(5);
  const Vec3 way(0.3, -0.2, 0.5);
  std::vector<Vec3> moved = r.grips;
  for (Vec3& g : moved) g += way;
  RigidPairRows rows, there;
  rows.add(r.a, r.b, r.points, r.grips, r.frames, 0.4);
  there.add(r.a, r.b, r.points, moved, r.frames, 0.4);
  const Vec3 impulse(1.3, -0.2, 0.7);
  std::vector<double> v(12, 0.0), wanted(12, 0.0);
  for (std::size_t i = 0; i < 8; ++i) {
    rows.add_response(i, impulse, v);
    rows.move_friction(i, way, impulse, v);
    there.add_response(i, impulse, wanted);
  }
  for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(v[i], wanted[i], 1e-12);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_LT((rows.velocity(i, v) - there.velocity(i, v)).norm(), 1e-12);
}

}  // namespace
}  // namespace brim::rigid_pair_rows_test
