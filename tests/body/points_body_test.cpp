#include "brim/body/points/points_body.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "support/implicit.h"
#include "support/particle_laws.h"
#include "support/worlds.h"

namespace brim::points_body_test {
namespace {

using testing::flat;

constexpr unsigned kSeed = 71;

PointsOptions options(double radius = 0.1) {
  PointsOptions o;
  o.radius = {radius};
  o.density = 1000.0;
  o.young = 1e4;
  return o;
}

/// Balls of various radii in a box, so close that many overlap.
PointsBody cloud(int n, double side, PointsOptions o = options()) {
  testing::Noise noise(kSeed);
  std::vector<Vec3> x;
  o.radius.clear();
  for (int i = 0; i < n; ++i) x.push_back(side * noise.vec()), o.radius.push_back(0.1 + 0.05 * noise());
  return PointsBody(x, o);
}

TEST(NeighbourSearch, FindsThePairsThatBruteForceFinds) {
  SCOPED_TRACE(kSeed);
  testing::Noise noise(kSeed);
  NeighbourSearch search;
  for (const double side : {0.05, 1.0, 30.0, 1e9}) {
    std::vector<Vec3> x;
    std::vector<double> radius;
    for (int i = 0; i < 400; ++i) {
      x.push_back(side * noise.vec());
      if (i % 7 == 0) x.back() = x[i / 2] + Vec3(0.1, 0, 0);
      radius.push_back(0.1 + 0.05 * noise());
    }
    x[5] = x[6];
    x[7].y() = std::numeric_limits<double>::quiet_NaN();
    for (const double gap : {0.0, 0.2}) {
      std::vector<NeighbourSearch::Pair> expected;
      for (std::int32_t a = 0; a < 400; ++a)
        for (std::int32_t b = a + 1; b < 400; ++b)
          if ((x[a] - x[b]).norm() < radius[a] + radius[b] + gap) expected.push_back({a, b});
      ASSERT_FALSE(expected.empty());
      for (const int threads : {1, 4}) {
        ThreadLimit limit(threads);
        const auto found = search.find(x, radius, gap);
        EXPECT_EQ(std::vector(found.begin(), found.end()), expected) << "side " << side;
      }
    }
  }
  EXPECT_TRUE(search.find({}, {}, 0.0).empty());
}

TEST(PointsBody, ForeseesPairsThatASolveCloses) {
  // Radii 0.1, a gap of 0.01; both move at 1 m/s until one is stopped: in a step of 0.02 s they overlap by 0.01.
  constexpr double dt = 0.02, gap = 0.01, k = 2 * 1e4 * 0.05;
  PointsBody body({Vec3(0, 0, 0), Vec3(0.2 + gap, 0, 0)}, options());
  const std::vector<double> v{-1, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0}, after{0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0};
  body.update(0.0, flat(body.rest_positions()), v);
  body.begin_solve(dt);
  const auto force_and_product = [&] {
    std::vector<double> f(12, 0.0), y(12, 0.0);
    body.add_forces({Vec3::Zero()}, f);
    body.apply_system(after, y);
    return std::pair{f[6], y[0]};
  };
  EXPECT_FALSE(body.foresee(v)) << "they come along together";
  EXPECT_EQ(force_and_product(), (std::pair{0.0, 0.0}));
  EXPECT_TRUE(body.foresee(after));
  // The spring of the gap, which the motion of the step turns into a push: k (−gap + dt).
  const auto [force, product] = force_and_product();
  EXPECT_NEAR(force, -k * gap, 1e-9);
  EXPECT_NEAR(product, dt * dt * k, 1e-9);
  EXPECT_FALSE(body.foresee(after)) << "they are known already";
  EXPECT_EQ(body.elastic_energy(), 0.0);
}

TEST(PointsBody, TwoGrainsByHand) {
  // Radii 0.1 and 0.3, k = 2 E 0.03/0.4 = 1500 N/m, overlap 0.1: 150 N apart.
  PointsOptions o = options();
  o.radius = {0.1, 0.3};
  PointsBody body({Vec3(0, 0, 0), Vec3(0.3, 0, 0)}, o);
  EXPECT_NEAR(body.masses()[0], 1000 * 4.0 / 3 * std::numbers::pi * 0.001, 1e-12);
  body.update(0.0, flat(body.rest_positions()), std::vector<double>(body.v_size(), 0.0));
  EXPECT_NEAR((body.inner_forces()[0] - Vec3(-150, 0, 0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((body.inner_forces()[1] - Vec3(150, 0, 0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(body.elastic_energy(), 0.5 * 1500 * 0.01, 1e-9);
  EXPECT_EQ(body.pairs().touching(), 1u);
  EXPECT_NEAR(body.pairs().worst_overlap(), 1.0, 1e-12);
}

TEST(PointsBody, ForcesAreMinusTheDerivativeOfEnergy) {
  PointsBody body = cloud(60, 0.3);
  testing::expect_force_is_minus_energy_gradient(body, flat(body.rest_positions()), 1e-8, 1e-6, kSeed);
}

TEST(PointsBody, StiffnessIsTheDerivativeOfTheForceAlongTheLineOfCentres) {
  PointsBody body({Vec3(0, 0, 0), Vec3(0.19, 0, 0)}, options());
  body.update(0.0, flat(body.rest_positions()), std::vector<double>(body.v_size(), 0.0));
  std::vector<double> y(12, 0.0);
  body.apply_stiffness(std::vector<double>{1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, y);
  const double k = 2 * 1e4 * 0.01 / 0.2;
  EXPECT_NEAR(y[0], -k, 1e-9);
  EXPECT_NEAR(y[6], k, 1e-9);
}

TEST(PointsBody, StiffnessAndDampingAreSymmetricAndDefinite) {
  PointsOptions o = options();
  o.stiffness_damping = 0.03;
  PointsBody body = cloud(60, 0.3, o);
  testing::expect_stiffness_is_symmetric_and_definite(body, flat(body.rest_positions()), kSeed);
  testing::Noise noise(kSeed);
  std::vector<double> v(body.v_size());
  for (double& e : v) e = noise();
  body.update(0.0, flat(body.rest_positions()), v);
  body.begin_solve(0.01);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> a(v.size()), b(v.size()), Da(v.size(), 0.0), Db(v.size(), 0.0);
    for (double& e : a) e = noise();
    for (double& e : b) e = noise();
    body.apply_damping(a, Da), body.apply_damping(b, Db);
    double ab = 0, ba = 0, aa = 0, size = 0;
    for (std::size_t i = 0; i < v.size(); ++i)
      ab += b[i] * Da[i], ba += a[i] * Db[i], aa += a[i] * Da[i], size += std::abs(b[i] * Da[i]);
    EXPECT_GT(size, 0.0);
    EXPECT_NEAR(ab, ba, 1e-13 * size);
    EXPECT_LE(aa, 1e-13 * size);
  }
}

TEST(PointsBody, ForcesHaveNeitherResultantNorTorque) {
  PointsOptions o = options();
  o.stiffness_damping = 0.03;
  PointsBody body = cloud(60, 0.3, o);
  testing::expect_inner_forces_balance(body, flat(body.rest_positions()));
  testing::Noise noise(kSeed);
  std::vector<double> v(body.v_size());
  for (double& e : v) e = noise();
  body.update(0.0, flat(body.rest_positions()), v);
  body.begin_solve(0.01);
  std::vector<double> Q(v.size(), 0.0);
  Environment env;
  env.gravity.setZero();
  body.add_forces(env, Q);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double size = 0.0;
  for (std::size_t i = 0; i < body.particle_count(); ++i) {
    const Eigen::Map<const Vec3> f(Q.data() + 6 * i), spin(Q.data() + 6 * i + 3);
    force += f, torque += body.positions()[i].cross(f) + spin, size += f.norm();
  }
  EXPECT_GT(size, 1.0);
  EXPECT_LT(force.norm(), 1e-13 * size);
  EXPECT_LT(torque.norm(), 1e-12 * size);
}

TEST(PointsBody, SystemIsMassDampingAndStiffnessComposedAndHasItsDiagonal) {
  PointsOptions o = options();
  o.stiffness_damping = 0.03, o.mass_damping = 0.2;
  PointsBody body = cloud(40, 0.25, o);
  testing::Noise noise(kSeed);
  std::vector<double> v(body.v_size()), A(v.size(), 0.0), M(v.size(), 0.0), K(v.size(), 0.0), C(v.size(), 0.0);
  for (double& e : v) e = noise();
  body.update(0.0, flat(body.rest_positions()), v);
  const double dt = 0.01;
  body.begin_solve(dt);
  body.apply_system(v, A);
  body.apply_mass(v, M), body.apply_stiffness(v, K), body.apply_damping(v, C);
  for (std::size_t i = 0; i < v.size(); ++i) EXPECT_NEAR(A[i], M[i] - dt * C[i] - dt * dt * K[i], 1e-10);
  BlockDiagonal D;
  D.reset(body.block_sizes());
  body.add_system_diagonal(0, D);
  for (const std::size_t i : {0u, 7u, 20u})
    for (int c = 0; c < 6; ++c) {
      std::vector<double> e(v.size(), 0.0), y(v.size(), 0.0);
      e[6 * i + c] = 1.0;
      body.apply_system(e, y);
      for (int k = 0; k < 6; ++k) EXPECT_NEAR(D.block(i)(k, c), y[6 * i + k], 1e-10);
    }
}

TEST(PointsBody, CouplingsAndDiagonalMakeUpTheSystem) {
  SCOPED_TRACE(kSeed);
  PointsBody body = cloud(30, 0.3);
  testing::Noise noise(kSeed);
  std::vector<double> q(body.q_size()), v(body.v_size());
  body.initial_state(q, v);
  for (double& x : v) x = 0.1 * noise();
  body.update(0.0, q, v);
  body.begin_solve(0.01);
  const auto n = static_cast<Eigen::Index>(body.v_size());
  BlockDiagonal diagonal;
  diagonal.reset(body.block_sizes());
  body.add_system_diagonal(0, diagonal);
  const SixCouplings couplings = body.couplings();
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(n, n), A = expected;
  for (Eigen::Index i = 0; i < n / 6; ++i) {
    const auto row = static_cast<std::size_t>(i);
    expected.block<6, 6>(6 * i, 6 * i) = diagonal.block(row);
    for (std::int32_t k = couplings.first[row]; k < couplings.first[row + 1]; ++k) {
      const Eigen::Index j = couplings.column[k];
      ASSERT_GT(j, i);
      expected.block<6, 6>(6 * i, 6 * j) = couplings.value[k].cast<double>();
      expected.block<6, 6>(6 * j, 6 * i) = couplings.value[k].transpose().cast<double>();
    }
  }
  ASSERT_GT(couplings.value.size(), 30u);
  for (Eigen::Index k = 0; k < n; ++k) {
    std::vector<double> x(body.v_size(), 0.0), y(x.size(), 0.0);
    x[static_cast<std::size_t>(k)] = 1.0;
    body.apply_system(x, y);
    A.col(k) = Eigen::Map<const Eigen::VectorXd>(y.data(), n);
  }
  EXPECT_LT((A - expected).cwiseAbs().maxCoeff(), 1e-6 * A.cwiseAbs().maxCoeff());
}

TEST(PointsBody, HeadOnGrainsStopAtTheTouchAndDoNotStick) {
  PointsOptions o = options();
  o.young = 1e7;  // the step does not resolve this contact: without waiting, the overlap would be up to 0.3 radii
  o.stiffness_damping = 2.0 / 60.0;
  PointsBody body({Vec3(0, 0, 0), Vec3(0.5, 0, 0)}, o);
  testing::Stepper stepper(body);
  Environment env;
  env.gravity.setZero();
  stepper.v = {1, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0};
  const double before = body.kinetic_energy(stepper.v);
  double worst = 0.0;
  for (int s = 0; s < 60; ++s) {
    stepper.step(1.0 / 60.0, env);
    worst = std::max(worst, body.pairs().worst_overlap());
    EXPECT_LE(body.kinetic_energy(stepper.v) + body.elastic_energy(), before * (1 + 1e-9));
  }
  EXPECT_LT(worst, 0.01);
  EXPECT_NEAR(stepper.v[0] + stepper.v[6], 0.0, 1e-12);
  // Drawn apart they part at once.
  stepper.v = {-1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0};
  body.update(stepper.time, stepper.q, stepper.v);
  stepper.step(1.0 / 60.0, env);
  EXPECT_NEAR(stepper.v[6], 1.0, 1e-9);
}

TEST(PointsBody, FrictionIsCoulombs) {
  // A grain pressed on a fixed one slides across: its friction is μ times the normal force.
  PointsOptions o = options();
  o.friction = 0.3;
  o.fixed = {0};
  PointsBody body({Vec3(0, 0, 0), Vec3(0, 0, 0.19)}, o);
  const std::vector<double> q = flat(body.rest_positions()), v = {0, 0, 0, 0, 0, 0, 0.4, 0.3, 0, 0, 0, 0};
  body.update(0.0, q, v);
  body.begin_solve(0.01);
  std::vector<double> Q(12, 0.0);
  Environment env;
  env.gravity.setZero();
  body.add_forces(env, Q);
  const double N = 0.01 * 2 * 1e4 * 0.01 / 0.2;
  EXPECT_NEAR(Q[8], N, 1e-9);
  EXPECT_NEAR(Q[6], -0.3 * N * 0.8, 1e-9);
  EXPECT_NEAR(Q[7], -0.3 * N * 0.6, 1e-9);
}

TEST(PointsBody, ThreadsDoNotChangeABit) {
  PointsBody body = cloud(3000, 1.0);
  testing::Noise noise(kSeed);
  std::vector<double> v(body.v_size()), first;
  for (double& e : v) e = noise();
  for (const int threads : {1, 2, 4}) {
    ThreadLimit limit(threads);
    body.update(0.0, flat(body.rest_positions()), v);
    body.begin_solve(0.01);
    std::vector<double> Q(v.size(), 0.0);
    body.add_forces(Environment{}, Q);
    body.apply_system(v, Q);
    if (first.empty()) first = Q;
    EXPECT_EQ(Q, first);
  }
}

TEST(PointsBody, BadInputIsRefusedWithAMessage) {
  EXPECT_THROW(PointsBody({}, options()), InputError);
  EXPECT_THROW(PointsBody({Vec3::Zero()}, options(0.0)), InputError);
  EXPECT_THROW(PointsBody({Vec3(0, std::nan(""), 0)}, options()), InputError);
  PointsOptions o = options();
  o.radius = {0.1, 0.1};
  EXPECT_THROW(PointsBody({Vec3::Zero()}, o), InputError);
  for (double PointsOptions::*number : {&PointsOptions::density, &PointsOptions::young, &PointsOptions::slip_speed}) {
    o = options();
    o.*number = 0.0;
    EXPECT_THROW(PointsBody({Vec3::Zero()}, o), InputError);
  }
  o = options(), o.friction = -1;
  EXPECT_THROW(PointsBody({Vec3::Zero()}, o), InputError);
}

}  // namespace
}  // namespace brim::points_body_test
