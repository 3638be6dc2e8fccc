#include "brim/body/stressed_solid.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "brim/body/fem/fem_body.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/tet_lattice.h"
#include "support/carried.h"
#include "support/particle_laws.h"

/// Stress of elastic solids: the derivative of their energy, and what their nodal forces come from.
namespace brim::stressed_solid_test {
namespace {

constexpr unsigned kSeed = 43;
constexpr ElasticLaw kLaws[] = {ElasticLaw::CorotationalLinear, ElasticLaw::StableNeoHookean};
constexpr Lame kLame{4e3, 6e3};

Mat3 turn() { return Eigen::AngleAxisd(1.0, Vec3(1, 2, 0).normalized()).toRotationMatrix(); }

/// A turned stretch along one axis with the contraction across that leaves the sides free, to first order.
Mat3 pulled(double strain, double poisson) {
  return turn() * (Vec3::Ones() + strain * Vec3(1.0, -poisson, -poisson)).asDiagonal();
}

std::vector<double> moved(const ParticleBody& body, const Mat3& F) {
  std::vector<Vec3> x;
  for (const Vec3& p : body.rest_positions()) x.push_back(F * p);
  return testing::flat(x);
}

double energy_density(ElasticLaw law, const Mat3& F) {
  return elastic_energy_density(law, kLame, Eigen::JacobiSVD<Mat3>(F).singularValues());
}

TEST(StressedSolid, PiolaStressIsTheDerivativeOfTheEnergy) {
  testing::Noise noise(kSeed);
  for (const ElasticLaw law : kLaws)
    for (int sample = 0; sample < 20; ++sample) {
      Mat3 F = Mat3::Identity();
      for (int c = 0; c < 3; ++c) F.col(c) += 0.3 * noise.vec();
      if (F.determinant() < 0.1) continue;
      const Mat3 P = first_piola_stress(law, kLame, F);
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          constexpr double kStep = 1e-6;
          Mat3 more = F, less = F;
          more(r, c) += kStep, less(r, c) -= kStep;
          EXPECT_NEAR(P(r, c), (energy_density(law, more) - energy_density(law, less)) / (2 * kStep), 1e-5 * kLame.mu);
        }
    }
}

TEST(StressedSolid, MeasuresOfATensor) {
  const Mat3 R = turn();
  const auto turned = [&](const Vec3& s) { return Mat3(R * s.asDiagonal() * R.transpose()); };
  EXPECT_NEAR(von_mises(turned({7, 0, 0})), 7.0, 1e-12);
  EXPECT_NEAR(von_mises(turned({5, 5, 5})), 0.0, 1e-12);
  EXPECT_NEAR(von_mises(turned({2, -2, 0})), std::sqrt(12.0), 1e-12);  // pure shear: √3 τ
  EXPECT_LT(green_strain(R).norm(), 1e-15);
  EXPECT_NEAR(green_strain(R * Vec3(1.2, 1, 1).asDiagonal())(0, 0), 0.22, 1e-15);
  EXPECT_EQ(cauchy_stress(R, Mat3::Zero()), Mat3::Zero());
}

// f_k = −Σ_e V_e P_e g_e,k, plain and with edge domains.
TEST(StressedSolid, NodalForcesComeFromIt) {
  const TetMesh mesh =
      tet_lattice([](const Vec3& p) { return p.norm() - 0.1; }, {Vec3::Constant(-0.1), Vec3::Constant(0.1)}, 0.06);
  testing::Noise noise(kSeed);
  std::vector<Vec3> x;
  for (const Vec3& p : mesh.vertices) x.push_back(turn() * (p + 0.005 * noise.vec()));
  std::vector<double> stiffness(mesh.tets.size());
  std::vector<EdgeShares> edges(mesh.tets.size());
  for (std::size_t e = 0; e < stiffness.size(); ++e) {
    stiffness[e] = 1.5 + noise();
    for (double& s : edges[e]) s = 1.5 + noise();
  }
  const std::vector<double> volume = tet_volumes(mesh);
  for (const ElasticLaw law : kLaws)
    for (const double averaging : {0.0, 0.9}) {
      AveragedElements elements(mesh, law, kLame, averaging, stiffness, edges);
      BlockMatrix K;
      elements.make_pattern(K);
      std::vector<Vec3> force(x.size(), Vec3::Zero()), want(x.size(), Vec3::Zero());
      elements.add(x, force, K);
      std::vector<Mat3> F(mesh.tets.size()), P(mesh.tets.size());
      elements.find_stress(mesh, x, F, P);
      double largest = 0.0;
      for (std::size_t e = 0; e < P.size(); ++e) {
        const Tetrahedron& t = mesh.tets[e];
        Mat3 rest, now;
        for (int i = 0; i < 3; ++i) {
          rest.col(i) = mesh.vertices[t[i + 1]] - mesh.vertices[t[0]];
          now.col(i) = x[t[i + 1]] - x[t[0]];
        }
        EXPECT_LT((F[e] * rest - now).norm(), 1e-13);
        const Mat3 f = -volume[e] * P[e] * rest.inverse().transpose();
        for (int i = 0; i < 3; ++i) want[t[i + 1]] += f.col(i), want[t[0]] -= f.col(i);
      }
      for (const Vec3& f : want) largest = std::max(largest, f.norm());
      for (std::size_t k = 0; k < x.size(); ++k) EXPECT_LT((force[k] - want[k]).norm(), 1e-9 * largest);
    }
}

/// Checks that every element has the stress E ε along the turned axis and none across, and that it is shown so.
void expect_pulled(ParticleBody& body, double young) {
  constexpr double kStrain = 1e-4, kPoisson = 0.3;
  const auto& solid = dynamic_cast<const StressedSolid&>(body);
  testing::set(body, moved(body, pulled(kStrain, kPoisson)));
  const StressField field = solid.stress_field();
  const Vec3 axis = turn().col(0);
  const double sigma = young * kStrain;
  std::vector<double> equivalent;
  ASSERT_GT(field.size(), 10u);
  for (std::size_t e = 0; e < field.size(); ++e) {
    const double filled = field.filled.empty() ? 1.0 : field.filled[e];
    EXPECT_LT((field.stress[e] - filled * sigma * axis * axis.transpose()).norm(), 1e-3 * sigma) << e;
    equivalent.push_back(von_mises(field.stress[e]));
  }
  std::vector<float> shown(body.display().vertices, 0.0f);
  solid.show(equivalent, shown);
  ASSERT_FALSE(shown.empty());
  for (const float s : shown) EXPECT_NEAR(static_cast<double>(s), sigma, 2e-3 * sigma);
}

TEST(StressedSolid, APulledBarHasThatOfTheory_InEveryKind) {
  const TetMesh bar = tet_lattice([](const Vec3& p) { return (p.cwiseAbs() - Vec3(0.2, 0.1, 0.1)).maxCoeff(); },
                                  {Vec3(-0.2, -0.1, -0.1), Vec3(0.2, 0.1, 0.1)}, 0.1);
  for (const ElasticLaw law : kLaws)
    for (const double averaging : {0.0, 0.9}) {
      FemOptions o;
      o.law = law, o.averaging = averaging;
      FemBody body(bar, o);
      expect_pulled(body, o.young);
    }
  // A lattice that the matter fills in part.
  expect_pulled(*testing::voxels(Vec3(0.4, 0.3, 0.3), 0.12, 0.05, testing::soft(1e4)), 1e4);
  const Vec3 half(0.2, 0.15, 0.15);
  MeshlessModel model =
      fill_with_frames([&](const Vec3& x) { return testing::box_distance(x, half); }, {-half, half}, 0.1, 0.05);
  model.surface = shapes::box(2.0 * half);
  MeshlessBody meshless(model, Quat::Identity(), Vec3::Zero(), testing::soft(1e4));
  expect_pulled(meshless, 1e4);
}

}  // namespace
}  // namespace brim::stressed_solid_test
