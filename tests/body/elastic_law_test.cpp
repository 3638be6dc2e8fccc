#include "brim/body/fem/elastic_law.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "support/solids.h"

namespace brim::elastic_law_test {
namespace {

constexpr unsigned kSeed = 23;
constexpr ElasticLaw kLaws[] = {ElasticLaw::CorotationalLinear, ElasticLaw::StableNeoHookean};

TEST(ElasticLaw, RestHasNoEnergyNoStressAndHookesModuli) {
  const Lame lame = Lame::from(1e5, 0.3);
  for (const ElasticLaw law : kLaws) {
    const PrincipalResponse r = principal_response(law, lame, Vec3::Ones());
    EXPECT_NEAR(r.energy, 0.0, 1e-10);
    EXPECT_LT(r.first.norm(), 1e-9);
    // Hooke: stretch = 2µ I + λ 11ᵀ, shear modes 2µ; rotations are free.
    const Mat3 hooke = 2 * lame.mu * Mat3::Identity() + Mat3::Constant(lame.lambda);
    EXPECT_LT((r.stretch - hooke).norm(), 1e-9 * lame.mu);
    EXPECT_LT((r.flip - Vec3::Constant(2 * lame.mu)).norm(), 1e-9 * lame.mu);
    EXPECT_LT(r.twist.norm(), 1e-9 * lame.mu);
  }
}

TEST(ElasticLaw, StressAndModuliAreDerivativesOfEnergy) {
  SCOPED_TRACE(kSeed);
  testing::Noise noise(kSeed);
  const Lame lame = Lame::from(1.0, 0.4);
  const double e = 1e-5;
  for (const ElasticLaw law : kLaws)
    for (int trial = 0; trial < 50; ++trial) {
      const Vec3 s = Vec3::Constant(1.0) + 0.7 * noise.vec();
      const auto r = principal_response(law, lame, s, false);
      EXPECT_NEAR(r.energy, elastic_energy_density(law, lame, s), 1e-13);
      for (int i = 0; i < 3; ++i) {
        const Vec3 d = e * Vec3::Unit(i);
        const auto plus = principal_response(law, lame, s + d, false),
                   minus = principal_response(law, lame, s - d, false);
        EXPECT_NEAR(r.first[i], (plus.energy - minus.energy) / (2 * e), 1e-8);
        EXPECT_LT((r.stretch.col(i) - (plus.first - minus.first) / (2 * e)).norm(), 1e-8);
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        EXPECT_NEAR(r.flip[k] * (s[i] - s[j]), r.first[i] - r.first[j], 1e-12);
        EXPECT_NEAR(r.twist[k] * (s[i] + s[j]), r.first[i] + r.first[j], 1e-12);
      }
    }
}

TEST(ElasticLaw, ProjectionRemovesOnlyTheNegativePart) {
  testing::Noise noise(kSeed);
  const Lame lame = Lame::from(1.0, 0.45);
  int changed = 0;
  for (const ElasticLaw law : kLaws)
    for (int trial = 0; trial < 300; ++trial) {
      const Vec3 s = Vec3::Constant(0.6) + 1.2 * noise.vec();
      const auto full = principal_response(law, lame, s, false), safe = principal_response(law, lame, s, true);
      const Eigen::SelfAdjointEigenSolver<Mat3> a(full.stretch), b(safe.stretch);
      EXPECT_LT((a.eigenvalues().cwiseMax(0.0) - b.eigenvalues()).norm(), 1e-12 * full.stretch.norm());
      EXPECT_GE(safe.twist.minCoeff(), 0.0);
      EXPECT_GE(safe.flip.minCoeff(), 0.0);
      changed += (full.stretch - safe.stretch).norm() > 0 || full.twist != safe.twist;
    }
  EXPECT_GT(changed, 100);
}

}  // namespace
}  // namespace brim::elastic_law_test
