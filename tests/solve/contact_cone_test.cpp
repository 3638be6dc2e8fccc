#include "brim/solve/contact_cone.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::contact_cone_test {
namespace {

Mat3 random_response(std::mt19937& rng) {
  std::normal_distribution<double> normal;
  const Mat3 B = Mat3::NullaryExpr([&] { return normal(rng); });
  return B * B.transpose() + 0.1 * Mat3::Identity();
}

TEST(ContactCone, ProjectionIsTheNearestPlaceInTheCone) {
  std::mt19937 rng(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const double mu = std::abs(normal(rng));
    const Vec3 x(normal(rng), normal(rng), normal(rng)), p = project_to_cone(x, mu);
    EXPECT_LE(p.tail<2>().norm(), mu * p.x() + 1e-12);
    // x − P is normal to P and makes no acute angle with any place of the cone.
    EXPECT_NEAR((x - p).dot(p), 0.0, 1e-12);
    for (int k = 0; k < 8; ++k) {
      const Vec3 inside = project_to_cone(Vec3(normal(rng), normal(rng), normal(rng)), mu);
      EXPECT_LE((x - p).dot(inside), 1e-12);
    }
  }
}

TEST(ContactCone, WhatSolvesOneContactHasNoResidualAndWhatDoesNotHas) {
  std::mt19937 rng(4);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const Mat3 W = random_response(rng);
    const double mu = 0.5 * std::abs(normal(rng)), w = W.trace() / 3.0;
    const Vec3 q(normal(rng), normal(rng), normal(rng));
    const Vec3 found = solve_contact(W, invert_response(W), mu, q, Vec3::Zero());
    EXPECT_LT(contact_residual(w, mu, q + W * found, found), 1e-9);
    const Vec3 other = project_to_cone(found + Vec3(0.2, 0.1, 0.0), mu);
    EXPECT_GT(contact_residual(w, mu, q + W * other, other), 1e-3);
  }
}

TEST(ContactCone, AllSolutionsOfAContactThatMayJamHaveNoResidual) {
  // The tangent presses on the normal, μ |W_nt| > W_nn: it parts, slips under an impulse, or sticks.
  Mat3 W;
  W << 1.0, 3.0, 0.0, 3.0, 10.0, 0.0, 0.0, 0.0, 1.0;
  const double mu = 0.5, w = W.trace() / 3.0;
  const Vec3 q(0.1, 1.0, 0.0), stick(2.0, -0.7, 0.0);
  for (const Vec3& impulse : {Vec3(0.0, 0.0, 0.0), Vec3(0.2, -0.1, 0.0), stick})
    EXPECT_LT(contact_residual(w, mu, q + W * impulse, impulse), 1e-12) << impulse.transpose();
  EXPECT_LT((solve_contact(W, invert_response(W), mu, q, Vec3::Zero()) - stick).norm(), 1e-9) << "finds one of them";
}

TEST(ContactCone, WhatJamsIsHeldByTheSmallestImpulse) {
  // A leg under a hinge, θ off upright, on a platform that rises: its foot moves along w alone, and cannot get out of
  // the way while friction holds it, tan θ < μ.
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> share(0.01, 0.95), speed(-0.3, 0.3);
  for (int i = 0; i < 500; ++i) {
    const double mu = 0.1 + share(rng), theta = share(rng) * std::atan(mu), turn = 6.0 * share(rng);
    const Vec3 side(0.0, std::cos(turn), std::sin(turn)),
        w = std::sin(theta) * Vec3::UnitX() + std::cos(theta) * side,
        along = std::cos(theta) * Vec3::UnitX() - std::sin(theta) * side;
    const Mat3 W = 0.3 * w * w.transpose();
    const Vec3 q = speed(rng) * w - Vec3(0.4, 0.0, 0.0);
    const Vec3 found = solve_contact(W, invert_response(W), mu, q, Vec3::Zero());
    const Vec3 u = q + W * found;
    EXPECT_LE(found.tail<2>().norm(), mu * found.x() * (1.0 + 1e-12));
    EXPECT_NEAR(u.dot(w), 0.0, 1e-6) << "what can be stopped is";
    EXPECT_NEAR((u - q.dot(along) * along).norm(), 0.0, 1e-6) << "the rest nothing can";
    // The smallest: with less along d it leaves the cone, unless none is needed.
    const double alpha = found.dot(along);
    const Vec3 less = found - 1e-3 * alpha * along;
    EXPECT_TRUE(alpha < 1e-9 || less.tail<2>().norm() > mu * less.x());
    EXPECT_LT(found.norm(), 1e3 * q.norm() / 0.3);
  }
}

}  // namespace
}  // namespace brim::contact_cone_test
