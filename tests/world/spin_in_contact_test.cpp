#include <gtest/gtest.h>

#include "support/soft_worlds.h"

namespace brim::spin_in_contact_test {
namespace {

struct Momenta {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  // about the origin
};

Momenta of_body(const World& w, int body) {
  std::size_t first = 0;
  for (int b = 0; b < body; ++b) first += w.body(b).v_size();
  const auto v = std::span(w.state().v).subspan(first, w.body(body).v_size());
  return {w.body(body).linear_momentum(v), w.body(body).angular_momentum(v)};
}

Momenta of_all(const World& w) {
  Momenta sum;
  for (int b = 0; b < w.body_count(); ++b) {
    const Momenta m = of_body(w, b);
    sum.linear += m.linear, sum.angular += m.angular;
  }
  return sum;
}

/// Two spinning blocks of finite elements, a sheet between them: they meet off their centres, without weight.
World spinning_world(double tolerance, Response response) {
  WorldOptions o = testing::options_at(0.1);
  o.environment.gravity.setZero();
  o.cg_tolerance = tolerance;
  o.response = response;
  World w(o);
  FemOptions solid;
  solid.density = 500, solid.young = 1e5, solid.stiffness_damping = 0.01;
  solid.initial_spin = Vec3(1.0, 4.0, 2.0), solid.initial_velocity = Vec3(1.0, 0.0, 0.2);
  w.add(testing::named<FemBody>("left", testing::block_at(3, 0.5, Vec3(-0.75, -0.25, -0.25)), solid));
  solid.initial_spin = Vec3(-2.0, 1.0, 3.0), solid.initial_velocity = Vec3(-1.0, 0.0, 0.0);
  w.add(testing::named<FemBody>("right", testing::block_at(3, 0.5, Vec3(0.25, -0.1, -0.1)), solid));
  w.add(testing::sheet("sheet", 0.8, Vec3(-0.1, 0.0, 0.5)));
  return w;
}

/// @param share, angular_share  of the momenta that may be lost
void expect_spin_is_kept(double tolerance, double share, Response response = Response::Penalty,
                         double angular_share = 1e-8) {
  World w = spinning_world(tolerance, response);
  w.step();
  const Momenta before = of_all(w);
  const Vec3 left = of_body(w, 0).angular;
  std::int64_t contacts = 0;
  for (int s = 0; s < 60; ++s) contacts += w.step().contacts;
  ASSERT_GT(contacts, 100);
  const Momenta after = of_all(w);
  const double scale = left.norm() + before.angular.norm();
  EXPECT_GT((of_body(w, 0).angular - left).norm(), 0.05 * scale);
  EXPECT_LT((after.angular - before.angular).norm(), angular_share * scale);
  EXPECT_LT((after.linear - before.linear).norm(), share * left.norm());
}

TEST(SpinInContact, OfAClosedSystemStaysAndContactMovesItBetweenBodies) { expect_spin_is_kept(1e-12, 1e-8); }

TEST(SpinInContact, WhatALooseSolveLeavesIsGivenBack) { expect_spin_is_kept(1e-3, 1e-8); }

TEST(SpinInContact, WhatALooseSolveLeavesIsGivenBackWhereRowsActToo) {
  // Overlap that rows push out moves places without velocity, which turns nothing but has a moment about the origin.
  expect_spin_is_kept(1e-3, 1e-8, Response::Constraint, 1e-3);
}

}  // namespace
}  // namespace brim::spin_in_contact_test
