#include "brim/solve/projected_gauss_seidel.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>
#include <utility>

#include "brim/core/parallel.h"
#include "brim/solve/contact_cone.h"

namespace brim::projected_gauss_seidel_test {
namespace {

using Entry = ProjectedGaussSeidel::Entry;

/// A point of mass m whose velocities are indices 0 to 2, touching along z; tangents x and y.
std::vector<Entry> point_on_floor(double m) {
  return {{0, Vec3(0, 1, 0), Vec3(0, 1, 0) / m},
          {1, Vec3(0, 0, 1), Vec3(0, 0, 1) / m},
          {2, Vec3(1, 0, 0), Vec3(1, 0, 0) / m}};
}

TEST(ProjectedGaussSeidel, APointThatLandsWithFrictionByHand) {
  ProjectedGaussSeidel s;
  s.add(point_on_floor(2.0), 0.5);
  const std::vector<Vec3> offset{Vec3::Zero()};
  const std::vector<double> target{0.0};
  // Fast: Coulomb takes μ times the change of the normal velocity. Slow: it sticks.
  for (const auto& [slip, left] : {std::pair{1.2, 0.7}, std::pair{0.4, 0.0}}) {
    std::vector<double> v{0.6 * slip, 0.8 * slip, -1.0};
    std::vector<Vec3> impulse{Vec3::Zero()};
    const auto r = s.solve(offset, target, {.tolerance = 1e-12, .max_sweeps = 200}, impulse, v);
    EXPECT_TRUE(r.converged);
    EXPECT_NEAR(v[2], 0.0, 1e-12);
    EXPECT_NEAR(v[0], 0.6 * left, 1e-9);
    EXPECT_NEAR(v[1], 0.8 * left, 1e-9);
    EXPECT_NEAR(impulse[0].x(), 2.0, 1e-9);
    EXPECT_NEAR(impulse[0].tail<2>().norm(), 2.0 * (slip - left), 1e-9);
  }
}

TEST(ProjectedGaussSeidel, AContactThatOpensGetsNoImpulse) {
  ProjectedGaussSeidel s;
  s.add(point_on_floor(1.0), 0.5);
  std::vector<double> v{0.3, 0.0, 0.1};
  std::vector<Vec3> impulse{Vec3::Zero()};
  s.solve(std::vector<Vec3>{Vec3::Zero()}, std::vector<double>{0.0}, {.tolerance = 1e-12, .max_sweeps = 50}, impulse,
          v);
  EXPECT_EQ(impulse[0], Vec3::Zero());
  EXPECT_EQ(v[0], 0.3);
}

TEST(ProjectedGaussSeidel, AContactOfImmovableThingsDoesNothing) {
  ProjectedGaussSeidel s;
  s.add({}, 0.5);
  std::vector<double> v;
  std::vector<Vec3> impulse{Vec3::Zero()};
  const auto r = s.solve(std::vector<Vec3>{Vec3(-1, 0, 0)}, std::vector<double>{0.0},
                         {.tolerance = 1e-6, .max_sweeps = 50}, impulse, v);
  EXPECT_TRUE(r.converged);
  EXPECT_EQ(impulse[0], Vec3::Zero());
}

/// Random contacts on random coupled velocities.
struct Problem {
  ProjectedGaussSeidel solver;
  Eigen::MatrixXd R, P;  ///< rows (3 n), inverse mass
  std::vector<Vec3> offset;
  std::vector<double> target, free;

  Problem(int contacts, int velocities, double mu, std::mt19937& rng) {
    std::normal_distribution<double> normal;
    R = Eigen::MatrixXd::NullaryExpr(3 * contacts, velocities, [&] { return normal(rng); });
    const Eigen::MatrixXd B = Eigen::MatrixXd::NullaryExpr(velocities, velocities, [&] { return normal(rng); });
    P = B * B.transpose() + Eigen::MatrixXd::Identity(velocities, velocities);
    for (int c = 0; c < contacts; ++c) {
      const Eigen::MatrixXd answer = P * R.middleRows(3 * c, 3).transpose();
      std::vector<Entry> entries;
      for (int i = 0; i < velocities; ++i)
        entries.push_back({static_cast<std::size_t>(i), R.block(3 * c, i, 3, 1), answer.row(i).transpose()});
      solver.add(entries, mu);
      offset.push_back(Vec3(normal(rng), normal(rng), normal(rng)));
      target.push_back(normal(rng));
    }
    for (int i = 0; i < velocities; ++i) free.push_back(normal(rng));
  }
};

TEST(ProjectedGaussSeidel, SolutionsHoldCoulombsLawAtEveryContact) {
  constexpr unsigned kSeed = 21;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  for (int trial = 0; trial < 20; ++trial) {
    const double mu = 0.3;
    Problem p(4, 12, mu, rng);
    std::vector<double> v = p.free;
    std::vector<Vec3> impulse(4, Vec3::Zero());
    if (!p.solver.solve(p.offset, p.target, {.tolerance = 1e-12, .max_sweeps = 20000}, impulse, v).converged) continue;
    for (std::size_t c = 0; c < 4; ++c) {
      const Vec3 u = p.solver.velocity(c, v) + p.offset[c];
      const double un = u.x() - p.target[c], slip = u.tail<2>().norm(), most = mu * impulse[c].x();
      EXPECT_GE(impulse[c].x(), 0.0);
      EXPECT_GT(un, -1e-8);
      EXPECT_LT(std::abs(impulse[c].x() * un), 1e-7);
      EXPECT_LE(impulse[c].tail<2>().norm(), most * (1.0 + 1e-9));
      // Against the slip, at the limit, or no slip.
      EXPECT_LT((impulse[c].tail<2>() * slip + most * u.tail<2>()).norm(), 1e-6 * (1.0 + most * slip));
    }
  }
}

TEST(ProjectedGaussSeidel, ResponsesThatItLearnsReplaceWhatItAssumed) {
  constexpr unsigned kSeed = 33;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  constexpr int kContacts = 3, kVelocities = 12, kRows = 3 * kContacts;
  std::normal_distribution<double> normal;
  Problem p(kContacts, kVelocities, 0.3, rng);
  p.solver.begin_learning(kVelocities);
  const std::size_t width = kVelocities + ProjectedGaussSeidel::kLearned;
  const Eigen::MatrixXd B = Eigen::MatrixXd::NullaryExpr(kRows, kRows, [&] { return normal(rng); });
  const Eigen::MatrixXd W = B * B.transpose();
  const auto expected = [&](const std::vector<Vec3>& impulse) {
    std::vector<double> v(width, 0.0);
    for (std::size_t c = 0; c < kContacts; ++c) p.solver.add_response(c, impulse[c], v);
    std::vector<Vec3> u;
    for (std::size_t c = 0; c < kContacts; ++c) u.push_back(p.solver.velocity(c, v));
    return u;
  };
  const auto actual = [&](const std::vector<Vec3>& impulse) {
    Eigen::VectorXd x(kRows);
    for (int c = 0; c < kContacts; ++c) x.segment<3>(3 * c) = impulse[static_cast<std::size_t>(c)];
    const Eigen::VectorXd y = W * x;
    std::vector<Vec3> u;
    for (int c = 0; c < kContacts; ++c) u.emplace_back(y.segment<3>(3 * c));
    return u;
  };
  const auto away = [](const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    double d = 0.0, size = 0.0;
    for (std::size_t c = 0; c < a.size(); ++c) d += (a[c] - b[c]).squaredNorm(), size += b[c].squaredNorm();
    return std::sqrt(d / size);
  };
  const auto random = [&] {
    std::vector<Vec3> impulse;
    for (int c = 0; c < kContacts; ++c) impulse.emplace_back(normal(rng), normal(rng), normal(rng));
    return impulse;
  };
  const std::vector<Vec3> probe = random();
  EXPECT_GT(away(expected(probe), actual(probe)), 0.1) << "the test is empty";
  // Conjugate impulses: what is learned of one stays when the next is.
  std::vector<std::vector<Vec3>> before;
  const auto dot = [](const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    double sum = 0.0;
    for (std::size_t c = 0; c < a.size(); ++c) sum += a[c].dot(b[c]);
    return sum;
  };
  for (int i = 0; i < kRows; ++i) {
    std::vector<Vec3> impulse = random();
    for (const auto& b : before) {
      const double share = dot(impulse, actual(b)) / dot(b, actual(b));
      for (std::size_t c = 0; c < kContacts; ++c) impulse[c] -= share * b[c];
    }
    before.push_back(impulse);
    p.solver.learn(impulse, expected(impulse), actual(impulse));
    EXPECT_LT(away(expected(impulse), actual(impulse)), 1e-9);
  }
  EXPECT_LT(away(expected(probe), actual(probe)), 1e-7);
  // Sweeps of what was learned end where Coulomb's law holds with the true responses.
  std::vector<double> v = p.free;
  v.resize(width, 0.0);
  std::vector<Vec3> impulse(kContacts, Vec3::Zero()), start;
  for (std::size_t c = 0; c < kContacts; ++c) start.push_back(p.solver.velocity(c, v) + p.offset[c]);
  ASSERT_TRUE(p.solver.solve(p.offset, p.target, {.tolerance = 1e-12, .max_sweeps = 20000}, impulse, v).converged);
  const std::vector<Vec3> change = actual(impulse);
  for (std::size_t c = 0; c < kContacts; ++c)
    EXPECT_LT(contact_residual(W.block<3, 3>(3 * c, 3 * c).trace() / 3.0, 0.3,
                               start[c] + change[c] - Vec3(p.target[c], 0, 0), impulse[c]),
              1e-6);
}

TEST(ProjectedGaussSeidel, WithoutFrictionTheSolutionIsThatOfEveryActiveSetTried) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  for (int trial = 0; trial < 20; ++trial) {
    const int n = 4;
    Problem p(n, 9, 0.0, rng);
    std::vector<double> v = p.free;
    std::vector<Vec3> impulse(n, Vec3::Zero());
    ASSERT_TRUE(p.solver.solve(p.offset, p.target, {.tolerance = 1e-13, .max_sweeps = 20000}, impulse, v).converged);
    // Brute force: W λ + q complementary to λ on the normals.
    Eigen::MatrixXd N(n, 9);
    Eigen::VectorXd q(n);
    const Eigen::Map<const Eigen::VectorXd> free(p.free.data(), 9);
    for (int c = 0; c < n; ++c) {
      N.row(c) = p.R.row(3 * c);
      q[c] = N.row(c).dot(free) + p.offset[c].x() - p.target[c];
    }
    const Eigen::MatrixXd W = N * p.P * N.transpose();
    int found = 0;
    for (int set = 0; set < 1 << n; ++set) {
      std::vector<int> on;
      for (int c = 0; c < n; ++c)
        if (set >> c & 1) on.push_back(c);
      Eigen::VectorXd lambda = Eigen::VectorXd::Zero(n);
      if (!on.empty()) lambda(on) = W(on, on).lu().solve(-q(on)).eval();
      const Eigen::VectorXd u = W * lambda + q;
      if (lambda.minCoeff() < -1e-12 || u.minCoeff() < -1e-9) continue;
      ++found;
      for (int c = 0; c < n; ++c) EXPECT_NEAR(impulse[c].x(), lambda[c], 1e-7);
    }
    EXPECT_GE(found, 1);
  }
}

TEST(ProjectedGaussSeidel, OneContactHoldsCoulombsLawHoweverItsTangentsPressOnItsNormal) {
  constexpr unsigned kSeed = 2;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::normal_distribution<double> normal;
  int slips = 0, coupled = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const double mu = 0.1 + 0.5 * std::abs(normal(rng));
    const Mat3 B = Mat3::NullaryExpr([&] { return normal(rng); });
    const Mat3 W = B * B.transpose() + 0.01 * Mat3::Identity();
    const Vec3 q(normal(rng), normal(rng), normal(rng)), guess(std::abs(normal(rng)), normal(rng), normal(rng));
    const Vec3 impulse = solve_contact(W, invert_response(W), mu, q + W * guess, guess), u = q + W * impulse;
    const double slip = u.tail<2>().norm(), most = mu * impulse.x();
    ASSERT_GE(impulse.x(), 0.0);
    ASSERT_GT(u.x(), -1e-8);
    ASSERT_LT(impulse.x() * u.x(), 1e-8 * (1.0 + impulse.x()));
    ASSERT_LE(impulse.tail<2>().norm(), most * (1.0 + 1e-12));
    ASSERT_LT((impulse.tail<2>() * slip + most * u.tail<2>()).norm(), 1e-7 * (1.0 + most * slip));
    if (slip < 1e-9 || most == 0.0) continue;
    ++slips;
    coupled += mu * W.row(0).tail<2>().norm() > W(0, 0) ? 1 : 0;
  }
  EXPECT_GT(slips, 300);
  EXPECT_GT(coupled, 30);
}

/// A column of points, the upper ones heavy: sweeps pass the weight on slowly.
ProjectedGaussSeidel column(int points) {
  ProjectedGaussSeidel s;
  for (int i = 0; i < points; ++i) {
    std::vector<Entry> entries;
    const auto add = [&](int point, double sign) {
      const double mass = point == points - 1 ? 30.0 : 1.0;
      for (int k = 0; k < 3; ++k) {
        const Vec3 row = sign * Vec3::Unit(k);
        entries.push_back({static_cast<std::size_t>(3 * point + k), row, row / mass});
      }
    };
    add(i, 1.0);
    if (i > 0) add(i - 1, -1.0);
    s.add(entries, 0.5);
  }
  return s;
}

TEST(ProjectedGaussSeidel, WhereSweepsAreTooFewAllContactsAreSolvedAtOnce) {
  constexpr int n = 6;
  ProjectedGaussSeidel s = column(n);
  std::vector<double> v(3 * n, 0.0);
  for (int i = 0; i < n; ++i) v[static_cast<std::size_t>(3 * i)] = -1.0;
  std::vector<Vec3> impulse(n, Vec3::Zero());
  const auto r = s.solve(std::vector<Vec3>(n, Vec3::Zero()), std::vector<double>(n, 0.0),
                         {.tolerance = 1e-6, .max_sweeps = 20}, impulse, v);
  EXPECT_TRUE(r.converged) << r.residual;
  for (int i = 0; i < n; ++i) {
    const auto c = static_cast<std::size_t>(i);
    EXPECT_NEAR(impulse[c].x(), 30.0 + n - 1 - i, 1e-3);
    EXPECT_NEAR(v[3 * c], 0.0, 1e-4);
  }
}

TEST(ProjectedGaussSeidel, PairsSharedByThreadsGiveTheSameBits) {
  // Pairs of many bodies in no order, so that threads have enough to share.
  constexpr std::size_t kBodies = 600, kPairs = 1000;
  std::mt19937 rng(7);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<std::size_t> body(0, kBodies);
  const auto vector = [&] { return Vec3(normal(rng), normal(rng), normal(rng)); };
  std::vector<RigidPairRows::Side> side(kBodies + 1);
  for (std::size_t b = 0; b <= kBodies; ++b) {
    const Mat3 m = Mat3::Random();
    side[b] = {6 * b, vector(), 0.5, Mat3::Identity() + 0.1 * m * m.transpose()};
  }
  side[kBodies] = {RigidPairRows::kFixed, Vec3::Zero(), 0.0, Mat3::Zero()};
  ProjectedGaussSeidel s;
  for (std::size_t p = 0; p < kPairs; ++p) {
    const std::size_t a = body(rng) % kBodies, b = body(rng);
    if (a == b) continue;
    std::vector<Vec3> points(1 + p % 3);
    std::vector<Mat3> frames(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i] = 0.5 * (side[a].center + side[b].center) + 0.1 * vector();
      frames[i] = Quat(normal(rng), normal(rng), normal(rng), normal(rng)).normalized().toRotationMatrix();
    }
    s.add_pair(side[a], side[b], points, frames, 0.4);
  }
  std::vector<Vec3> offset(s.size());
  for (Vec3& o : offset) o = 0.3 * vector();
  const std::vector<double> target(s.size(), 0.0);
  const auto solve = [&](int threads) {
    const ThreadLimit limit(threads);
    std::vector<Vec3> impulse(s.size(), Vec3::Zero());
    std::vector<double> v(6 * kBodies, 0.0);
    s.solve(offset, target, {.tolerance = 1e-8, .max_sweeps = 20, .scale = 1.0}, impulse, v);
    return std::pair(impulse, v);
  };
  EXPECT_EQ(solve(1), solve(2));
}

}  // namespace
}  // namespace brim::projected_gauss_seidel_test
