#include "brim/solve/contact_responses.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "support/random_contacts.h"

namespace brim::contact_responses_test {
namespace {

/// Contacts on few velocities, each on four of nine.
testing::RandomContacts some(std::mt19937& rng) { return {8, 9, 4, rng}; }

TEST(ContactResponses, AreThoseOfTheMatrices) {
  std::mt19937 rng(3);
  const testing::RandomContacts p = some(rng);
  const Eigen::MatrixXd W = p.R * p.P * p.R.transpose();
  EXPECT_LT((p.responses.dense() - W).norm(), 1e-12 * W.norm());
  for (std::size_t c = 0; c < p.responses.size(); ++c) {
    const auto at = static_cast<Eigen::Index>(3 * c);
    EXPECT_LT((p.responses.local(c) - W.block<3, 3>(at, at)).norm(), 1e-12 * W.norm());
  }
  const Eigen::VectorXd x = Eigen::VectorXd::Random(W.cols());
  Eigen::VectorXd u;
  p.responses.multiply(x, u);
  EXPECT_LT((u - W * x).norm(), 1e-12 * u.norm());
}

TEST(ContactResponses, SolveIsThatOfTheDenseMatrix) {
  std::mt19937 rng(4);
  testing::RandomContacts p = some(rng);
  for (std::size_t c = 0; c < p.responses.size(); ++c) p.responses.scale(c, 0.2 + 0.1 * static_cast<double>(c));
  const Eigen::MatrixXd W = p.responses.dense();
  const Eigen::VectorXd b = Eigen::VectorXd::Random(W.cols());
  for (const double shift : {1e-3, 0.1, 10.0}) {
    Eigen::VectorXd x;
    ASSERT_TRUE(p.responses.factor(shift));
    p.responses.solve(b, x);
    const Eigen::MatrixXd A = W + shift * Eigen::MatrixXd::Identity(W.rows(), W.cols());
    EXPECT_LT((x - A.ldlt().solve(b)).norm(), 1e-9 * x.norm()) << shift;
  }
}

TEST(ContactResponses, WhatNothingMovesTakesNoPart) {
  ContactResponses r;
  r.add(std::vector<ContactEntry>{{7, Vec3::Zero(), Vec3::Zero()}, {5, Vec3(1, 0, 0), Vec3(0.5, 0, 0)}});
  r.add({});
  EXPECT_EQ(r.size(), 2u);
  EXPECT_EQ(r.width(), 1u);
  EXPECT_EQ(r.local(0)(0, 0), 0.5);
  EXPECT_EQ(r.local(1), Mat3::Zero());
}

}  // namespace
}  // namespace brim::contact_responses_test
