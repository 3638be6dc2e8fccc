#include "brim/body/fem/tet_lanes.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "brim/body/meshless/sample_lanes.h"
#include "brim/math/svd3.h"
#include "support/principal_block.h"
#include "support/solids.h"

namespace brim::tet_lanes_test {
namespace {

constexpr unsigned kSeed = 91;

/// Eight random tetrahedra, turned and deformed.
struct Sample {
  TetLanes tets;
  double edge[3][3][TetLanes::kCount];
  Mat3 F[TetLanes::kCount], g[TetLanes::kCount];

  Sample(testing::Noise& noise, double amount) {
    for (int l = 0; l < TetLanes::kCount; ++l) {
      const auto random = [&] {
        Mat3 m;
        for (double& e : m.reshaped()) e = noise();
        return m;
      };
      const Mat3 rest = 0.1 * (Mat3::Identity() + 0.3 * random());
      const Quat turn(noise(), noise(), noise(), noise());
      F[l] = turn.normalized().toRotationMatrix() * (Mat3::Identity() + amount * random());
      g[l] = rest.inverse().transpose();
      set(l, F[l] * rest, rest.determinant() / 6.0);
    }
  }
  void set(int lane, const Mat3& edges, double volume) {
    for (int i = 0; i < 3; ++i)
      for (int c = 0; c < 3; ++c) tets.gradient[i][c][lane] = g[lane](c, i), edge[i][c][lane] = edges(c, i);
    tets.volume[lane] = volume;
  }
};

/// Largest differences from one tetrahedron after the other by its singular values, and the sizes that they are of.
struct Difference {
  double force = 0.0, forces = 0.0, block = 0.0, blocks = 0.0;

  void add(const Sample& s, ElasticLaw law, const Lame& lame, bool project) {
    TetResponse out;
    respond(law, lame, project, s.tets, s.edge, out);
    for (int l = 0; l < TetLanes::kCount; ++l) {
      const Svd3 d = svd3(s.F[l]);
      const PrincipalResponse r = principal_response(law, lame, d.s, project);
      const Mat3 a = d.V.transpose() * s.g[l];
      const Vec3 corner[4] = {-a.rowwise().sum(), a.col(0), a.col(1), a.col(2)};
      const Vec3 plus = 0.5 * (r.twist + r.flip), minus = 0.5 * (r.flip - r.twist);
      const double volume = s.tets.volume[l];
      for (int i = 0; i < 4; ++i) {
        const Vec3 f = -volume * (d.U * r.first.cwiseProduct(corner[i]));
        for (int c = 0; c < 3; ++c) force = std::max(force, std::abs(out.force[i][c][l] - f[c]));
        forces = std::max(forces, f.norm());
      }
      for (int i = 0, p = 0; i < 4; ++i)
        for (int j = i + 1; j < 4; ++j, ++p) {
          const Mat3 K =
              volume * (d.U * testing::principal_block(r, plus, minus, corner[i], corner[j]) * d.U.transpose());
          for (int k = 0; k < 9; ++k)
            block = std::max(block, std::abs(static_cast<double>(out.block[p][k][l]) - K.data()[k]));
          blocks = std::max(blocks, K.norm());
        }
    }
  }
};

TEST(TetLanes, GiveTheForcesAndBlocksOfOneTetrahedronAtATime) {
  SCOPED_TRACE(kSeed);
  const Lame lame = Lame::from(1e4, 0.3);
  for (const ElasticLaw law : {ElasticLaw::CorotationalLinear, ElasticLaw::StableNeoHookean})
    for (const bool project : {false, true})
      // The last turns a third of them inside out.
      for (const double amount : {0.05, 0.5, 2.0}) {
        testing::Noise noise(kSeed);
        Difference d;
        for (int trial = 0; trial < 100; ++trial) d.add(Sample(noise, amount), law, lame, project);
        EXPECT_LT(d.force, 1e-13 * d.forces) << amount;
        // Some forty roundings of single precision, as terms of the second law cancel.
        EXPECT_LT(d.block, 5e-6 * d.blocks) << amount;
      }
}

TEST(TetLanes, GiveTheEnergyOfSingularValues) {
  SCOPED_TRACE(kSeed);
  const Lame lame = Lame::from(1e4, 0.3);
  for (const ElasticLaw law : {ElasticLaw::CorotationalLinear, ElasticLaw::StableNeoHookean})
    for (const double amount : {0.05, 0.5, 2.0}) {
      testing::Noise noise(kSeed);
      for (int trial = 0; trial < 100; ++trial) {
        const Sample s(noise, amount);
        double e[TetLanes::kCount];
        energy(law, lame, s.tets, s.edge, e);
        for (int l = 0; l < TetLanes::kCount; ++l) {
          const double expected = s.tets.volume[l] * elastic_energy_density(law, lame, svd3(s.F[l]).s);
          EXPECT_NEAR(e[l], expected, 1e-12 * std::abs(expected) + 1e-13 * s.tets.volume[l] * lame.mu) << amount;
        }
      }
    }
}

/// The tetrahedra as samples that see their four corners and one frame more, which has no gradient.
struct AsSamples {
  static constexpr std::size_t kFrames = 5, kCount = SampleLanes::kCount;
  std::vector<double> gradient = std::vector<double>(3 * kFrames * kCount), x = gradient;

  explicit AsSamples(const Sample& s) {
    for (std::size_t l = 0; l < kCount; ++l)
      for (std::size_t c = 0; c < 3; ++c) {
        const auto at = [&](std::size_t k) { return kCount * (3 * k + c) + l; };
        for (std::size_t k = 1; k < 4; ++k) {
          gradient[at(k)] = s.tets.gradient[k - 1][c][l];
          gradient[at(0)] -= gradient[at(k)];
          x[at(k)] = s.edge[k - 1][c][l];
        }
        x[at(4)] = 3.0;
      }
  }
  SampleLanes lanes(const Sample& s) const { return {kFrames, gradient.data(), s.tets.volume}; }
};

TEST(SampleLanes, SamplesWithFourFramesAreTetrahedra) {
  SCOPED_TRACE(kSeed);
  const Lame lame = Lame::from(1e4, 0.3);
  testing::Noise noise(kSeed);
  for (const ElasticLaw law : {ElasticLaw::CorotationalLinear, ElasticLaw::StableNeoHookean})
    for (int trial = 0; trial < 100; ++trial) {
      const Sample s(noise, 0.5);
      const AsSamples samples(s);
      constexpr std::size_t n = AsSamples::kFrames;
      std::vector<double> force(samples.x.size()), e(AsSamples::kCount), expected(AsSamples::kCount);
      std::vector<float> block(9 * AsSamples::kCount * n * (n - 1) / 2);
      TetResponse tets;
      respond(law, lame, samples.lanes(s), samples.x.data(), force.data(), block.data());
      respond(law, lame, true, s.tets, s.edge, tets);
      energy(law, lame, samples.lanes(s), samples.x.data(), e.data());
      energy(law, lame, s.tets, s.edge, expected.data());
      double forces = 0.0, blocks = 0.0;
      for (const auto& corner : tets.force)
        for (const auto& c : corner)
          for (const double f : c) forces = std::max(forces, std::abs(f));
      for (const auto& b : tets.block)
        for (const auto& entry : b)
          for (const float k : entry) blocks = std::max(blocks, static_cast<double>(std::abs(k)));
      for (std::size_t l = 0; l < AsSamples::kCount; ++l) {
        EXPECT_NEAR(e[l], expected[l], 1e-12 * std::abs(expected[l]) + 1e-13 * s.tets.volume[l] * lame.mu);
        for (std::size_t k = 0; k < 4; ++k)
          for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(force[AsSamples::kCount * (3 * k + c) + l], tets.force[k][c][l], 1e-13 * forces);
        for (std::size_t i = 0, p = 0, q = 0; i < n; ++i)
          for (std::size_t j = i + 1; j < n; ++j, ++q) {
            for (std::size_t k = 0; k < 9; ++k) {
              const auto found = static_cast<double>(block[AsSamples::kCount * (9 * q + k) + l]);
              const double wanted = j < 4 ? static_cast<double>(tets.block[p][k][l]) : 0.0;
              EXPECT_NEAR(found, wanted, 5e-6 * blocks);
            }
            if (j < 4) ++p;
          }
      }
    }
}

TEST(TetLanes, OnesBitsDoNotDependOnTheOthers) {
  const Lame lame = Lame::from(1e4, 0.3);
  testing::Noise noise(kSeed);
  for (int trial = 0; trial < 20; ++trial) {
    const Sample mixed(noise, 1.0);
    TetResponse together;
    respond(ElasticLaw::StableNeoHookean, lame, true, mixed.tets, mixed.edge, together);
    for (int l = 0; l < TetLanes::kCount; ++l) {
      Sample alone = mixed;
      for (int k = 0; k < TetLanes::kCount; ++k) {
        alone.tets.volume[k] = mixed.tets.volume[l];
        for (int i = 0; i < 3; ++i)
          for (int c = 0; c < 3; ++c) {
            alone.tets.gradient[i][c][k] = mixed.tets.gradient[i][c][l];
            alone.edge[i][c][k] = mixed.edge[i][c][l];
          }
      }
      TetResponse out;
      respond(ElasticLaw::StableNeoHookean, lame, true, alone.tets, alone.edge, out);
      for (int k : {0, 5}) {
        for (int i = 0; i < 4; ++i)
          for (int c = 0; c < 3; ++c) EXPECT_EQ(out.force[i][c][k], together.force[i][c][l]);
        for (int p = 0; p < 6; ++p)
          for (int i = 0; i < 9; ++i) EXPECT_EQ(out.block[p][i][k], together.block[p][i][l]);
      }
    }
  }
}

TEST(TetLanes, ACrushedOneIsFinite) {
  testing::Noise noise(kSeed);
  Sample s(noise, 0.1);
  for (int l = 0; l < 4; ++l) {
    const Mat3 flat = l < 2 ? Mat3(Vec3(1, 1, 0).asDiagonal()) : l == 2 ? Mat3::Zero() : Mat3(1e-9 * s.F[l]);
    s.set(l, flat * s.g[l].inverse().transpose(), s.tets.volume[l]);
  }
  TetResponse out;
  for (const ElasticLaw law : {ElasticLaw::CorotationalLinear, ElasticLaw::StableNeoHookean}) {
    respond(law, Lame::from(1e4, 0.3), true, s.tets, s.edge, out);
    for (int l = 0; l < TetLanes::kCount; ++l) {
      for (int i = 0; i < 4; ++i)
        for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(out.force[i][c][l]));
      for (int p = 0; p < 6; ++p)
        for (int k = 0; k < 9; ++k) EXPECT_TRUE(std::isfinite(out.block[p][k][l]));
    }
  }
}

}  // namespace
}  // namespace brim::tet_lanes_test
