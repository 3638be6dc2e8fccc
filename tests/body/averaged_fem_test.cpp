#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numeric>

#include "brim/body/fem/edge_domains.h"
#include "brim/body/fem/fem_body.h"
#include "brim/core/error.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/tet_lattice.h"
#include "support/particle_laws.h"

namespace brim::averaged_fem_test {
namespace {

using testing::flat;

constexpr unsigned kSeed = 37;
constexpr ElasticLaw kLaws[] = {ElasticLaw::CorotationalLinear, ElasticLaw::StableNeoHookean};

/// A ball on the lattice that fills shapes: whole, moved and cut tetrahedra.
TetMesh ball(double spacing = 0.06) {
  return tet_lattice([](const Vec3& p) { return p.norm() - 0.1; }, {Vec3::Constant(-0.1), Vec3::Constant(0.1)},
                     spacing);
}

FemOptions options(ElasticLaw law) {
  FemOptions o;
  o.law = law;
  o.young = 1e4;
  o.averaging = 0.9;
  return o;
}

std::vector<double> deformed(const FemBody& body, double amount, double stretch = 1.0) {
  testing::Noise noise(kSeed);
  const Mat3 R = Eigen::AngleAxisd(1.0, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  std::vector<Vec3> x;
  for (const Vec3& p : body.rest_positions()) x.push_back(R * (stretch * p + amount * 0.01 * noise.vec()));
  return flat(x);
}

TEST(AveragedFem, DomainsHoldAllVolumeAndTheirGradientsReproduceAffineMotion) {
  const TetMesh mesh = ball();
  testing::Noise noise(kSeed);
  std::vector<EdgeShares> stiffness(mesh.tets.size());
  double volume = 0.0;
  for (std::size_t e = 0; e < stiffness.size(); ++e) {
    const auto corner = [&](int k) { return mesh.vertices[static_cast<std::size_t>(mesh.tets[e][k])]; };
    for (double& s : stiffness[e]) {
      s = 1.5 + noise();
      volume += s / 6.0 * tet_volume(corner(0), corner(1), corner(2), corner(3));
    }
  }
  const EdgeDomains domains = edge_domains(mesh, stiffness);
  EXPECT_NEAR(std::accumulate(domains.volume.begin(), domains.volume.end(), 0.0), volume, 1e-14);
  for (std::size_t s = 0; s < domains.volume.size(); ++s) {
    Mat3 F = Mat3::Zero();
    Vec3 sum = Vec3::Zero();
    for (auto e = static_cast<std::size_t>(domains.shape.rows.first[s]);
         e < static_cast<std::size_t>(domains.shape.rows.first[s + 1]); ++e) {
      F +=
          mesh.vertices[static_cast<std::size_t>(domains.shape.rows.source[e])] * domains.shape.gradient[e].transpose();
      sum += domains.shape.gradient[e];
    }
    EXPECT_LT((F - Mat3::Identity()).norm(), 1e-10);
    EXPECT_LT(sum.norm(), 1e-8);
  }
}

// One tetrahedron is all six of its domains, a sixth in each: their mean is its own gradient.
TEST(AveragedFem, DomainsOfOneTetrahedronAreSixthsOfIt) {
  const TetMesh one{{Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}, {{0, 1, 2, 3}}};
  const EdgeDomains domains = edge_domains(one, std::vector<EdgeShares>{{1, 2, 3, 4, 5, 6}});
  ASSERT_EQ(domains.volume.size(), 6u);
  for (std::size_t d = 0; d < 6; ++d) {
    EXPECT_NEAR(domains.volume[d], static_cast<double>(d + 1) / 36.0, 1e-16);
    for (std::size_t k = 1; k < 4; ++k) EXPECT_LT((domains.shape.gradient[4 * d + k] - one.vertices[k]).norm(), 1e-15);
  }
}

// What is uniform is the same about edges as in tetrahedra: energies agree at any share.
TEST(AveragedFem, UniformStrainStoresTheEnergyOfSingleTetrahedra) {
  for (const ElasticLaw law : kLaws) {
    FemOptions single = options(law);
    single.averaging = 0.0;
    FemBody averaged(ball(), options(law)), plain(ball(), single);
    const std::vector<double> q = deformed(averaged, 0.0, 1.1);
    testing::set(averaged, q);
    testing::set(plain, q);
    EXPECT_NEAR(averaged.elastic_energy() / plain.elastic_energy(), 1.0, 1e-12);
    const auto a = averaged.inner_forces(), b = plain.inner_forces();
    double largest = 0.0, gap = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      largest = std::max(largest, b[i].norm());
      gap = std::max(gap, (a[i] - b[i]).norm());
    }
    EXPECT_LT(gap, 1e-9 * largest);
  }
}

TEST(AveragedFem, ForcesAreMinusTheDerivativeOfEnergy) {
  for (const ElasticLaw law : kLaws) {
    FemBody body(ball(), options(law));
    testing::expect_force_is_minus_energy_gradient(body, deformed(body, 0.6), 1e-7, 1e-6, kSeed);
  }
}

TEST(AveragedFem, StiffnessIsTheDerivativeOfForcesWhereNothingIsProjected) {
  for (const ElasticLaw law : kLaws) {
    FemBody body(ball(), options(law));
    testing::expect_stiffness_is_force_derivative(body, deformed(body, 0.02, 1.15), 1e-7, 1e-6, kSeed);
  }
}

TEST(AveragedFem, StiffnessIsSymmetricAndDefiniteAlsoWhenInverted) {
  for (const ElasticLaw law : kLaws) {
    FemBody body(ball(), options(law));
    testing::expect_stiffness_is_symmetric_and_definite(body, deformed(body, 10.0), kSeed);
  }
}

TEST(AveragedFem, InnerForcesHaveNoResultantAndNoTorqueAndRigidMotionMakesNone) {
  for (const ElasticLaw law : kLaws) {
    FemBody body(ball(), options(law));
    testing::expect_inner_forces_balance(body, deformed(body, 0.5));
    testing::expect_inner_forces_balance(body, deformed(body, 10.0));
    testing::expect_rigid_motion_makes_no_force(body);
  }
}

TEST(AveragedFem, ThreadsDoNotChangeABit) {
  FemBody body(ball(0.02), options(ElasticLaw::StableNeoHookean));
  const std::vector<double> q = deformed(body, 0.3);
  std::vector<double> force, product;
  double energy = 0.0;
  for (const int threads : {1, 2, 4}) {
    ThreadLimit limit(threads);
    testing::set(body, q);
    body.begin_solve(0.01);
    std::vector<double> y(q.size(), 0.0);
    body.apply_system(q, y);
    if (force.empty()) force = flat(body.inner_forces()), product = y, energy = body.elastic_energy();
    EXPECT_EQ(flat(body.inner_forces()), force);
    EXPECT_EQ(y, product);
    EXPECT_EQ(body.elastic_energy(), energy);
  }
}

TEST(AveragedFem, ShareOutsideItsRangeIsRefused) {
  for (const double share : {-0.1, 1.0, std::nan("")}) {
    FemOptions o = options(ElasticLaw::CorotationalLinear);
    o.averaging = share;
    EXPECT_THROW(FemBody(ball(), o), InputError);
  }
}

}  // namespace
}  // namespace brim::averaged_fem_test
