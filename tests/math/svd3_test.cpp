#include "brim/math/svd3.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <random>

namespace brim::svd3_test {
namespace {

constexpr unsigned kSeed = 17;

void expect_svd(const Mat3& F) {
  const Svd3 d = svd3(F);
  const double size = F.norm();
  EXPECT_LE((d.U * d.s.asDiagonal() * d.V.transpose() - F).norm(), 4e-15 * size) << F;
  EXPECT_LT((d.U.transpose() * d.U - Mat3::Identity()).norm(), 1e-14) << F;
  EXPECT_LT((d.V.transpose() * d.V - Mat3::Identity()).norm(), 1e-14) << F;
  EXPECT_NEAR(d.U.determinant(), 1.0, 1e-14);
  EXPECT_NEAR(d.V.determinant(), 1.0, 1e-14);
  EXPECT_GE(d.s[0], d.s[1] - 1e-15 * size);
  EXPECT_GE(d.s[1], std::abs(d.s[2]) - 2e-15 * size);
}

TEST(Svd3, DiagonalByHandWithTheSignInTheLastValue) {
  const Svd3 d = svd3(Vec3(1, -2, 3).asDiagonal());
  EXPECT_TRUE(d.s.isApprox(Vec3(3, 2, -1)));
}

TEST(Svd3, RandomMatricesAgreeWithEigen) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 2000; ++i) {
    Mat3 F = Mat3::NullaryExpr([&] { return normal(rng); });
    if (i % 4 == 1) F.col(2) = F.col(0) + 1e-9 * F.col(1);
    if (i % 4 == 2) F = Mat3::Identity() + 1e-7 * F;
    if (i % 4 == 3) F.col(1) = 1e-5 * F.col(1);
    expect_svd(F);
    const Eigen::JacobiSVD<Mat3> reference(F);
    EXPECT_LT((svd3(F).s.cwiseAbs() - reference.singularValues()).norm(), 1e-14 * F.norm());
  }
}

TEST(Svd3, FlatAndVanishingMatricesHaveProperRotations) {
  expect_svd(Mat3::Zero());
  expect_svd(Vec3(1, 2, 3) * Vec3(3, -1, 2).transpose());
  expect_svd(Mat3::Identity());
  expect_svd(-Mat3::Identity());
  expect_svd(1e-160 * Mat3::Identity());
}

TEST(Svd3, PolarRotationOfARotationIsItself) {
  const Mat3 R = Eigen::AngleAxisd(2.3, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  EXPECT_LT((polar_rotation(R) - R).norm(), 1e-15 * 10);
  EXPECT_LT((polar_rotation(R * Vec3(3, 0.2, 1).asDiagonal()) - R).norm(), 1e-14);
}

}  // namespace
}  // namespace brim::svd3_test
