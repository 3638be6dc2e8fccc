#include "brim/solve/contact_admm.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "support/random_contacts.h"

namespace brim::contact_admm_test {
namespace {

/// Contacts and velocities that they start from: those of a motion that some velocities undo, so that targets can be
/// kept.
struct Contacts : testing::RandomContacts {
  Eigen::MatrixXd W;
  std::vector<Vec3> q;
  std::vector<double> friction;

  Contacts(int contacts, int velocities, double mu, std::mt19937& rng)
      : RandomContacts(contacts, velocities, velocities, rng),
        W(R * P * R.transpose()),
        friction(static_cast<std::size_t>(contacts), mu) {
    std::normal_distribution<double> normal;
    const Eigen::VectorXd free = R * Eigen::VectorXd::NullaryExpr(velocities, [&] { return normal(rng); });
    for (int c = 0; c < contacts; ++c) q.emplace_back(free.segment<3>(3 * c));
  }

  Vec3 velocity(std::size_t c, const std::vector<Vec3>& impulse) const {
    Vec3 u = q[c];
    for (std::size_t d = 0; d < impulse.size(); ++d)
      u += W.block<3, 3>(static_cast<Eigen::Index>(3 * c), static_cast<Eigen::Index>(3 * d)) * impulse[d];
    return u;
  }
};

TEST(ContactAdmm, APointThatLandsWithFrictionByHand) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(3, 3);
  const ContactResponses W = testing::responses_of(one, 0.5 * one);  // 2 kg
  const std::vector<double> friction{0.5};
  // Fast: Coulomb takes μ times the change of the normal velocity, against the slip. Slow: it sticks.
  for (const auto& [slip, left] : {std::pair{1.2, 0.7}, std::pair{0.4, 0.0}}) {
    const std::vector<Vec3> q{Vec3(-1.0, 0.6 * slip, 0.8 * slip)};
    std::vector<Vec3> impulse{Vec3::Zero()};
    EXPECT_TRUE(ContactAdmm::solve(W, q, friction, 1e-10, 1000, impulse).converged);
    EXPECT_NEAR(impulse[0].x(), 2.0, 1e-8);
    const Vec3 u = q[0] + 0.5 * impulse[0];
    EXPECT_NEAR(u.y(), 0.6 * left, 1e-8);
    EXPECT_NEAR(u.z(), 0.8 * left, 1e-8);
  }
}

TEST(ContactAdmm, WhatOpensAndWhatNothingMovesGetsNoImpulse) {
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(6, 3);
  R.topRows<3>().setIdentity();
  const ContactResponses W = testing::responses_of(R, Eigen::MatrixXd::Identity(3, 3));
  const std::vector<Vec3> q{Vec3(0.1, 0.3, 0.0), Vec3(-1.0, 1.0, 0.0)};
  std::vector<Vec3> impulse(2, Vec3::Zero());
  EXPECT_TRUE(ContactAdmm::solve(W, q, std::vector<double>{0.5, 0.5}, 1e-10, 1000, impulse).converged);
  EXPECT_LT(impulse[0].norm(), 1e-9);
  EXPECT_EQ(impulse[1], Vec3::Zero());
}

/// Contacts whose velocities are few, and not so few: either matrix is factored.
class ContactAdmmOf : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Velocities, ContactAdmmOf, ::testing::Values(9, 15));

TEST_P(ContactAdmmOf, SolutionsHoldCoulombsLawWhereRowsOutnumberVelocities) {
  constexpr unsigned kSeed = 8;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  constexpr std::size_t n = 8;
  int solved = 0;
  for (int trial = 0; trial < 30; ++trial) {
    const Contacts p(n, GetParam(), 0.4, rng);
    std::vector<Vec3> impulse(n, Vec3::Zero());
    if (!ContactAdmm::solve(p.responses, p.q, p.friction, 1e-9, 20000, impulse).converged) continue;
    ++solved;
    for (std::size_t c = 0; c < n; ++c) {
      const Vec3 u = p.velocity(c, impulse);
      const double slip = u.tail<2>().norm(), most = 0.4 * impulse[c].x();
      EXPECT_GE(impulse[c].x(), 0.0);
      EXPECT_GT(u.x(), -1e-7);
      EXPECT_LT(impulse[c].x() * u.x(), 1e-6);
      EXPECT_LE(impulse[c].tail<2>().norm(), most * (1.0 + 1e-9) + 1e-15);
      // Against the slip, at the limit, or no slip.
      EXPECT_LT((impulse[c].tail<2>() * slip + most * u.tail<2>()).norm(), 1e-6 * (1.0 + most * slip));
    }
  }
  EXPECT_GE(solved, 25) << "of 30";
}

TEST(ContactAdmm, UnlikeMassesOnTopOfEachOtherCarryTheirWeights) {
  // A column of points of 1 and 30 kg: impulses are the weights above, by hand.
  constexpr int n = 10;
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(3 * n, 3 * n), M = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  std::vector<double> mass;
  for (int i = 0; i < n; ++i) {
    mass.push_back(i % 2 == 0 ? 1.0 : 30.0);
    M.block<3, 3>(3 * i, 3 * i) = Mat3::Identity() / mass.back();
    R.block<3, 3>(3 * i, 3 * i).setIdentity();
    if (i > 0) R.block<3, 3>(3 * i, 3 * i - 3) = -Mat3::Identity();
  }
  const ContactResponses W = testing::responses_of(R, M);
  std::vector<Vec3> q(n, Vec3::Zero()), impulse(n, Vec3::Zero());
  q[0].x() = -1.0;  // all fall by 1 m/s, relative to each other not at all
  EXPECT_TRUE(ContactAdmm::solve(W, q, std::vector<double>(n, 0.5), 1e-9, 5000, impulse).converged);
  double above = 0.0;
  for (int i = n - 1; i >= 0; --i) {
    above += mass[static_cast<std::size_t>(i)];
    EXPECT_NEAR(impulse[static_cast<std::size_t>(i)].x(), above, 1e-5 * above);
  }
}

}  // namespace
}  // namespace brim::contact_admm_test
