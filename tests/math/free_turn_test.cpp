#include "brim/math/free_turn.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace brim::free_turn_test {
namespace {

const Vec3 kInertia(1.0, 2.0, 3.0);
Vec3 spin_of(const Vec3& L) { return L.cwiseQuotient(kInertia); }

TEST(FreeTurn, ASpinThatStaysIsFollowedExactly) {
  const Vec3 L(0, 0, 3.0 * 7.0);  // about the axis of largest inertia
  const Quat r = free_turn(L, 0.9, spin_of), expected = rotation_from_vector(Vec3(0, 0, 0.9 * 7.0));
  EXPECT_LT(1.0 - std::abs(r.dot(expected)), 1e-15);
  EXPECT_EQ(free_turn(Vec3::Zero(), 0.9, spin_of).w(), 1.0);
}

// A body of revolution turns about its axis by L_3 (1/I_3 − 1/I_1) and about L by |L| / I_1 (Landau and Lifshitz,
// Mechanics, § 35).
TEST(FreeTurn, ABodyOfRevolutionPrecessesRegularly) {
  const Vec3 inertia(2.0, 2.0, 0.5), L(0.8, -0.4, 1.1);
  const double dt = 0.05;
  const Quat r = free_turn(L, dt, [&](const Vec3& l) -> Vec3 { return l.cwiseQuotient(inertia); });
  const Quat own = rotation_from_vector(Vec3(0, 0, dt * L.z() * (1.0 / 0.5 - 1.0 / 2.0)));
  const Quat expected = rotation_from_vector(dt / 2.0 * L) * own;
  EXPECT_LT(r.angularDistance(expected), 1e-8);
}

TEST(FreeTurn, ConvergesAtFourthOrderAndGoesBackAsItCame) {
  const Vec3 L(0.3, 1.4, -0.6);
  const auto error = [&](double dt) {
    Quat many = Quat::Identity();
    for (int i = 0; i < 256; ++i)
      many = free_turn(L, dt / 256, [&](const Vec3& l) -> Vec3 { return many * spin_of(many.conjugate() * l); }) * many;
    return free_turn(L, dt, spin_of).angularDistance(many);
  };
  // Each of one piece: its error is of fifth order.
  EXPECT_NEAR(std::log2(error(0.06) / error(0.03)), 5.0, 0.5);
  const Quat there = free_turn(L, 0.06, spin_of);
  const Quat back = free_turn(L, -0.06, [&](const Vec3& l) -> Vec3 { return there * spin_of(there.conjugate() * l); });
  EXPECT_LT((back * there).angularDistance(Quat::Identity()), 1e-9);
}

TEST(FreeTurn, FastOnesAreCutIntoPieces) {
  const Vec3 L(0.05, 20.0, 0.05);  // ten rad/s about the middle axis
  const Quat once = free_turn(L, 1.0 / 60.0, spin_of);
  Quat many = Quat::Identity();
  for (int i = 0; i < 64; ++i)
    many =
        free_turn(L, 1.0 / 3840.0, [&](const Vec3& l) -> Vec3 { return many * spin_of(many.conjugate() * l); }) * many;
  EXPECT_LT(once.angularDistance(many), 1e-9);
}

}  // namespace
}  // namespace brim::free_turn_test
