#include "brim/math/rotation.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace brim::rotation_test {
namespace {

constexpr unsigned kSeed = 32;

TEST(Rotation, QuarterTurnByHand) {
  const Quat r = rotation_from_vector(Vec3(0, 0, 0.5 * std::numbers::pi));
  EXPECT_LT((r * Vec3(1, 0, 0) - Vec3(0, 1, 0)).norm(), 1e-15);
  EXPECT_LT((vector_from_rotation(r) - Vec3(0, 0, 0.5 * std::numbers::pi)).norm(), 1e-15);
}

TEST(Rotation, VectorAndQuaternionInvertEachOther) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> exponent(-13.0, 0.49);  // lengths from 1e-13 to just below π
  for (int i = 0; i < 2000; ++i) {
    const Vec3 axis = Vec3(normal(rng), normal(rng), normal(rng)).normalized();
    const double angle = std::pow(10.0, exponent(rng));
    const Quat r = rotation_from_vector(angle * axis);
    EXPECT_NEAR(r.norm(), 1.0, 1e-15);
    EXPECT_LT((vector_from_rotation(r) - angle * axis).norm(), 4e-15 * angle + 1e-24);
    const Quat opposite(-r.w(), -r.x(), -r.y(), -r.z());
    EXPECT_LT((vector_from_rotation(opposite) - angle * axis).norm(), 4e-15 * angle + 1e-24);
  }
}

TEST(Rotation, AgreesWithTheAxisAndAngleOfEigen) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    const Vec3 a(normal(rng), normal(rng), normal(rng));
    const Mat3 expected = Eigen::AngleAxisd(a.norm(), a.normalized()).toRotationMatrix();
    EXPECT_LT((rotation_from_vector(a).toRotationMatrix() - expected).norm(), 3e-15);
  }
}

TEST(Rotation, NoTurnIsTheIdentity) {
  EXPECT_EQ(rotation_from_vector(Vec3::Zero()).coeffs(), Quat::Identity().coeffs());
  EXPECT_EQ(vector_from_rotation(Quat::Identity()), Vec3::Zero());
}

TEST(Rotation, SeriesAtZeroJoinsTheQuotientSmoothly) {
  const Vec3 axis = Vec3(1, 2, -2) / 3.0;
  const double switch_angle = 2e-4;
  const Quat below = rotation_from_vector(switch_angle * (1 - 1e-9) * axis);
  const Quat above = rotation_from_vector(switch_angle * (1 + 1e-9) * axis);
  EXPECT_LT((below.coeffs() - above.coeffs()).norm(), 1e-12);
}

}  // namespace
}  // namespace brim::rotation_test
