#include "brim/body/cloth/cloth_body.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/map/shell_weights.h"
#include "brim/mesh/primitives.h"
#include "support/implicit.h"
#include "support/particle_laws.h"
#include "support/tiles.h"

namespace brim::cloth_body_test {
namespace {

using testing::flat;

constexpr unsigned kSeed = 41;

ClothOptions options(double young = 100.0, double poisson = 0.3, double bending = 1e-3) {
  ClothOptions o;
  o.membrane.young = young;
  o.membrane.poisson = poisson;
  o.bending = bending;
  return o;
}

/// A bent rest shape, so that bending goes by angles.
TriMesh curved() {
  TriMesh mesh = shapes::grid(6, 4, 0.6, 0.4);
  for (Vec3& x : mesh.vertices) x.z() = 0.5 * x.x() * x.x() - 0.3 * x.y() * x.x();
  return mesh;
}

std::vector<double> deformed(const ClothBody& body, double amount, double stretch = 1.0) {
  testing::Noise noise(kSeed);
  const Mat3 R = Eigen::AngleAxisd(1.0, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  std::vector<Vec3> x;
  for (const Vec3& p : body.rest_positions())
    x.push_back(R *
                (stretch * p + amount * (0.02 * noise.vec() + Vec3(p.y() * p.y(), 0, p.x() * p.x() + p.x() * p.y()))));
  return flat(x);
}

TEST(ClothBody, ForcesAreMinusTheDerivativeOfEnergy) {
  for (const TriMesh& mesh : {shapes::grid(6, 4, 0.6, 0.4), curved()}) {
    ClothOptions o = options();
    o.membrane.young_weft = 40.0;
    o.membrane.shear = 13.0;
    o.membrane.warp = Vec3(1, 0.5, 0);
    ClothBody body(mesh, o);
    testing::expect_force_is_minus_energy_gradient(body, deformed(body, 1.0), 1e-7, 1e-6, kSeed);
  }
}

TEST(ClothBody, StiffnessIsTheDerivativeOfForcesInTension) {
  ClothBody body(shapes::grid(6, 4, 0.6, 0.4), options());
  ASSERT_TRUE(body.bending().flat());
  testing::expect_stiffness_is_force_derivative(body, deformed(body, 0.02, 1.2), 1e-7, 1e-6, kSeed);
  // At rest nothing is compressed and every angle is at rest, so it is exact for curved sheets also.
  ClothBody shell(curved(), options());
  ASSERT_FALSE(shell.bending().flat());
  testing::expect_stiffness_is_force_derivative(shell, flat(shell.rest_positions()), 1e-7, 1e-5, kSeed);
}

TEST(ClothBody, StiffnessIsSymmetricAndDefiniteAlsoWhenCompressed) {
  for (const TriMesh& mesh : {shapes::grid(6, 4, 0.6, 0.4), curved()}) {
    ClothBody body(mesh, options());
    testing::expect_stiffness_is_symmetric_and_definite(body, deformed(body, 1.0, 0.7), kSeed);
    testing::expect_stiffness_is_symmetric_and_definite(body, deformed(body, 10.0), kSeed);
  }
}

TEST(ClothBody, InnerForcesHaveNoResultantAndNoTorque) {
  for (const TriMesh& mesh : {shapes::grid(6, 4, 0.6, 0.4), curved()}) {
    ClothBody body(mesh, options());
    testing::expect_inner_forces_balance(body, deformed(body, 1.0));
  }
}

TEST(ClothBody, RigidMotionMakesNoForce) {
  for (const TriMesh& mesh : {shapes::grid(6, 4, 0.6, 0.4), curved()}) {
    ClothBody body(mesh, options());
    testing::expect_rigid_motion_makes_no_force(body);
  }
}

TEST(ClothBody, UniformStrainGivesTheOrthotropicStress) {
  // F = diag(1 + a, 1 + b): E = (a + a²/2, b + b²/2); energy = area (c11 E1² + c22 E2² + 2 c12 E1 E2) / 2.
  ClothOptions o = options(100.0, 0.2, 0.0);
  o.membrane.young_weft = 50.0;
  ClothBody body(shapes::grid(5, 3, 0.5, 0.3), o);
  std::vector<Vec3> x;
  for (const Vec3& p : body.rest_positions()) x.push_back(Vec3(1.1 * p.x(), 0.95 * p.y(), p.z()));
  testing::set(body, flat(x));
  const double e1 = 0.105, e2 = -0.04875, rest = 1 - 0.04 * 0.5;
  const double c11 = 100 / rest, c22 = 50 / rest, c12 = 0.2 * 50 / rest;
  const double expected = 0.5 * 0.15 * (c11 * e1 * e1 + c22 * e2 * e2 + 2 * c12 * e1 * e2);
  EXPECT_NEAR(body.elastic_energy(), expected, 1e-12 * expected);
}

TEST(ClothBody, BendingOnACylinderHasTheEnergyOfThePlate) {
  // ½ B A / R² for a sheet rolled without stretch; edges at the rim have no hinge, so the error falls with the cell
  // size.
  const double R = 0.5, B = 2.0;
  for (const bool by_angle : {false, true}) {
    double last = 1.0;
    for (const int n : {8, 16, 32}) {
      TriMesh sheet = shapes::grid(n, n, 0.4, 0.4);
      // A tiny bump makes the rest shape count as curved.
      if (by_angle) sheet.vertices[sheet.vertices.size() / 2].z() += 1e-6;
      const BendingElements bending(sheet, B);
      ASSERT_EQ(bending.flat(), !by_angle);
      std::vector<Vec3> x;
      for (const Vec3& p : sheet.vertices)
        x.emplace_back(R * std::sin(p.x() / R), p.y(), R * (1 - std::cos(p.x() / R)));
      const double error = std::abs(bending.energy(x) / (0.5 * B * 0.16 / (R * R)) - 1.0);
      EXPECT_LT(error, 0.7 * last) << n;
      last = error;
    }
    EXPECT_LT(last, 0.06) << (by_angle ? "by angle" : "quadratic");
  }
}

TEST(ClothBody, HangingStripStretchesByItsWeight) {
  // A strip of length L held at the top; small strain: ΔL = σ g L² / (2 E).
  const double L = 0.5, g = 0.5;
  ClothOptions o = options(200.0, 0.0, 0.0);
  o.areal_density = 0.3;
  const int n = 20;
  const TriMesh mesh = shapes::grid(n, 4, L, 0.1);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (mesh.vertices[i].x() < -L / 2 + 1e-9) o.fixed.push_back(static_cast<std::int32_t>(i));
  ClothBody body(mesh, o);
  testing::Stepper stepper(body);
  Environment env;
  env.gravity = Vec3(g, 0, 0);
  stepper.relax(4, env);
  double longest = -1.0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) longest = std::max(longest, stepper.position(i).x());
  const double expected = o.areal_density * g * L * L / (2 * 200.0);
  // The law is not linear: at this strain of 1e-4 it differs by as much.
  EXPECT_NEAR((longest - L / 2) / expected, 1.0, 2e-3);
}

/// Strip of n equilateral triangles along x, `across` rows.
TriMesh equilateral_strip(int n, int across, double side) {
  TriMesh mesh;
  for (int j = 0; j <= across; ++j)
    for (int i = 0; i <= n; ++i) mesh.vertices.push_back(side * Vec3(i + 0.5 * (j % 2), std::sqrt(0.75) * j, 0));
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = i + (n + 1) * j, c = a + n + 1;
      if (j % 2 == 0) {
        mesh.triangles.push_back({a, a + 1, c});
        mesh.triangles.push_back({a + 1, c + 1, c});
      } else {
        mesh.triangles.push_back({a, a + 1, c + 1});
        mesh.triangles.push_back({a, c + 1, c});
      }
    }
  return mesh;
}

/// Tip sag of a clamped strip under its own weight over q L⁴ / (8 B), q = σ g.
double sag_ratio(int n) {
  const double L = 0.3, B = 1e-2, g = 0.1, side = L / n;
  ClothOptions o = options(1e4, 0.0, B);
  o.areal_density = 0.2;
  const TriMesh mesh = equilateral_strip(n, n / 8, side);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (mesh.vertices[i].x() < 1.1 * side) o.fixed.push_back(static_cast<std::int32_t>(i));
  ClothBody body(mesh, o);
  testing::Stepper stepper(body);
  Environment env;
  env.gravity = Vec3(0, 0, -g);
  stepper.relax(3, env);
  double sag = 0.0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) sag = std::max(sag, -stepper.position(i).z());
  // Clamp and tip are zigzags of half a side.
  const double free = L - 0.5 * side;
  return sag / (o.areal_density * g * std::pow(free, 4) / (8 * B));
}

TEST(ClothBody, StripSagsAsAPlate) {
  // On equilateral triangles the hinges make a plate with Poisson's ratio −1/3 (a rolled sheet has B, a dome 4/3, a
  // saddle 8/3 of ½ B κ²): a strip with free sides bends with B (1 − 1/9), so it sags by 9/8 of the beam, a little
  // less near the clamp, which holds its sides.
  const double coarse = sag_ratio(16), middle = sag_ratio(32), fine = sag_ratio(64);
  RecordProperty("ratio", fmt::format("{:.4f} {:.4f} {:.4f}", coarse, middle, fine));
  EXPECT_LT(std::abs(fine - middle), 0.6 * std::abs(middle - coarse));
  EXPECT_NEAR(fine, 1.125, 0.02);
}

TEST(ClothBody, CrumpledSheetUnfolds) {
  ClothOptions o = options(100.0, 0.3, 1e-3);
  o.mass_damping = 10.0;
  ClothBody body(shapes::grid(6, 6, 0.6, 0.6), o);
  testing::Stepper stepper(body);
  testing::Noise noise(kSeed);
  for (double& x : stepper.q) x += 0.06 * noise();
  body.update(0.0, stepper.q, stepper.v);
  const double start = body.elastic_energy();
  Environment env;
  env.gravity.setZero();
  for (int s = 0; s < 600; ++s) stepper.step(0.01, env);
  EXPECT_LT(body.elastic_energy(), 1e-4 * start);
}

/// A rigid motion of all particles moves every point of the density with it.
/// @return the points whose nearest triangle is too thin to carry them
std::size_t expect_rigid_motion_throughout_the_density(ClothBody& body) {
  const double h = body.part(0).voxel_size, w = 3 * h;
  std::vector<TileKey> tiles;
  body.presence(0, h, w, body.bounds(0).inflated(1.0), tiles);
  std::vector<DensityBlock> blocks(tiles.size());
  body.rasterize(0, h, w, tiles, blocks);
  std::vector<Vec3> points;
  std::vector<std::int32_t> sources;
  testing::for_each_node(tiles, h, [&](std::size_t t, int n, const Vec3& r) {
    if (blocks[t].rho[n] > 0.0) points.push_back(r), sources.push_back(blocks[t].source[n]);
  });
  EXPECT_GT(points.size(), 1000u);
  std::vector<Vec3> v, u(points.size());
  const Vec3 omega(1, -2, 0.5);
  for (const Vec3& x : body.positions()) v.push_back(Vec3(1, 2, 3) + omega.cross(x));
  std::unique_ptr<Map> map;
  body.make_map(0, points, sources, map);
  map->apply(flat(v), u);
  double worst = 0.0;
  std::size_t thin = 0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    worst = std::max(worst, (u[p] - Vec3(1, 2, 3) - omega.cross(points[p])).norm());
    const Triangle& triangle = body.mesh().triangles[sources[p]];
    thin += ShellWeightsMap::lever(points[p], triangle, body.positions()) > ShellWeightsMap::kMaxLever;
  }
  EXPECT_LT(worst, 1e-12);
  return thin;
}

ClothOptions thick() {
  ClothOptions o = options();
  o.thickness = 0.04;
  return o;
}

TEST(ClothBody, MapIsExactForRigidMotionThroughoutTheDensity) {
  ClothBody body(shapes::grid(6, 4, 0.6, 0.4), thick());
  testing::set(body, deformed(body, 0.5));
  EXPECT_DOUBLE_EQ(body.part(0).voxel_size, 0.02);
  EXPECT_EQ(expect_rigid_motion_throughout_the_density(body), 0u);
}

TEST(ClothBody, MapIsExactForRigidMotionWhereTrianglesAreFoldedToSlivers) {
  ClothBody body(shapes::grid(6, 4, 0.6, 0.4), thick());
  std::vector<Vec3> x(body.rest_positions().begin(), body.rest_positions().end());
  // The sheet's edge is drawn in, to a hair before the line of the next row.
  double edge = 0.0;
  for (const Vec3& p : x) edge = std::max(edge, p.x());
  for (Vec3& p : x)
    if (p.x() > edge - 1e-9) p.x() -= 0.1 - 1e-4;
  testing::set(body, flat(x));
  EXPECT_GT(expect_rigid_motion_throughout_the_density(body), 100u);
}

TEST(ClothBody, ThreadsDoNotChangeABit) {
  for (const TriMesh& mesh : {shapes::grid(40, 40, 1, 1), curved()}) {
    ClothBody body(mesh, options());
    const std::vector<double> q = deformed(body, 1.0);
    std::vector<double> force, product;
    for (const int threads : {1, 2, 4}) {
      ThreadLimit limit(threads);
      testing::set(body, q);
      body.begin_solve(0.01);
      std::vector<double> y(q.size(), 0.0);
      body.apply_system(q, y);
      if (force.empty()) force = flat(body.inner_forces()), product = y;
      EXPECT_EQ(flat(body.inner_forces()), force);
      EXPECT_EQ(y, product);
    }
  }
}

TEST(ClothBody, BadInputIsRefusedWithAMessage) {
  const TriMesh good = shapes::grid(2, 2, 1, 1);
  TriMesh bad = good;
  bad.triangles.push_back({0, 1, 2});  // on one line
  EXPECT_THROW(ClothBody(bad, {}), InputError);
  bad = good;
  bad.vertices.push_back(Vec3::Ones());
  EXPECT_THROW(ClothBody(bad, {}), InputError);
  bad = good;
  bad.triangles[1][0] = 77;
  EXPECT_THROW(ClothBody(bad, {}), InputError);
  EXPECT_THROW(ClothBody(TriMesh{}, {}), InputError);
  ClothOptions o;
  o.thickness = 0;
  EXPECT_THROW(ClothBody(good, o), InputError);
  o = {};
  o.membrane.poisson = 1.0;
  EXPECT_THROW(ClothBody(good, o), InputError);
  o = {};
  o.bending = -1;
  EXPECT_THROW(ClothBody(good, o), InputError);
}

}  // namespace
}  // namespace brim::cloth_body_test
