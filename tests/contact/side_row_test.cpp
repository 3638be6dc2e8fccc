#include "brim/contact/side_row.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/contact/contact_set.h"

/// What a row says of a side, against the formulas written out at one node.
namespace brim::side_row_test {
namespace {

constexpr unsigned kSeed = 75;
/// Single precision, tensors of size up to 10.
constexpr double kSingle = 2e-5;

Vec3 vector_at(const float (&x)[3][kCubeSize], int i) { return Vec3f(x[0][i], x[1][i], x[2][i]).cast<double>(); }

Mat3 tensor_at(const RowDerivatives& r, int i) {
  const auto& H = r.hessian;
  Mat3 m;
  m << H[0][i], H[3][i], H[4][i], H[3][i], H[1][i], H[5][i], H[4][i], H[5][i], H[2][i];
  return m;
}

/// T H T, T = 1 − ĝĝᵀ.
Mat3 across(const Vec3& g, const Mat3& H) {
  const Mat3 T = Mat3::Identity() - g.normalized() * g.normalized().transpose();
  return T * H * T;
}

Mat3 bend_at(const SideRow& s, int i) {
  return unpack_tangent_tensor(vector_at(s.gradient, i).cast<float>(), {s.bend[0][i], s.bend[1][i], s.bend[2][i]});
}

RowDerivatives random_row(std::mt19937& rng) {
  std::uniform_real_distribution<float> u(-1.0f, 1.0f);
  RowDerivatives r;
  for (auto& g : r.gradient)
    for (float& x : g) x = u(rng);
  for (auto& g : r.hessian)
    for (float& x : g) x = u(rng);
  return r;
}

TEST(SideRow, HasTheGradientOfTheDensitiesAndTheirBendAcrossIt) {
  std::mt19937 rng(kSeed);
  RowDerivatives rho = random_row(rng);
  for (auto& g : rho.gradient) g[3] = 0.0f;
  rho.gradient[0][5] = rho.gradient[1][5] = 0.0f, rho.gradient[2][5] = -0.5f;
  const float inverse_h = 2.0f;
  SideRow side;
  side_row(rho, nullptr, inverse_h, side);
  for (int i = 0; i < kCubeSize; ++i) {
    const Vec3 g = inverse_h * vector_at(rho.gradient, i);
    EXPECT_EQ(vector_at(side.gradient, i), g);
    const Mat3 expected = i == 3 ? Mat3(Mat3::Zero()) : Mat3(inverse_h * inverse_h * across(g, tensor_at(rho, i)));
    EXPECT_LE((bend_at(side, i) - expected).norm(), kSingle) << "node " << i;
  }
}

TEST(SideRow, PointsAndBendsAsDistancesDoWhereTheseTellAndIsAsLongAsTheDensitiesSay) {
  std::mt19937 rng(kSeed);
  const RowDerivatives rho = random_row(rng);
  RowDerivatives told = random_row(rng);
  // Amid a solid distances have no slope that tells a direction.
  for (auto& g : told.gradient) g[2] *= 1e-3f;
  const float inverse_h = 2.0f;
  SideRow side;
  side_row(rho, &told, inverse_h, side);
  for (int i = 0; i < kCubeSize; ++i) {
    const Vec3 g = inverse_h * vector_at(rho.gradient, i), away = inverse_h * vector_at(told.gradient, i);
    if (i == 2) {
      EXPECT_EQ(vector_at(side.gradient, i), g);
      EXPECT_EQ(bend_at(side, i), Mat3(Mat3::Zero()));
      continue;
    }
    const double slope = -g.norm() / away.norm();
    EXPECT_LE((vector_at(side.gradient, i) - slope * away).norm(), kSingle) << "node " << i;
    const Mat3 expected = slope * inverse_h * inverse_h * across(away, tensor_at(told, i));
    EXPECT_LE((bend_at(side, i) - expected).norm(), kSingle * std::max(1.0, -slope)) << "node " << i;
  }
}

}  // namespace
}  // namespace brim::side_row_test
