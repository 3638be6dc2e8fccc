#include "brim/mesh/mass_properties.h"

#include <gtest/gtest.h>

#include <numbers>

#include "brim/core/error.h"
#include "brim/mesh/primitives.h"
#include "mesh/data.h"

namespace brim::mass_properties_test {
namespace {

using std::numbers::pi;

TEST(MassProperties, BoxHasTheTextbookInertia) {
  const Vec3 e(1.0, 2.0, 3.0);
  const MassProperties m = mass_properties(shapes::box(e, 3), 700.0);
  EXPECT_NEAR(m.volume, 6.0, 1e-12);
  EXPECT_NEAR(m.mass, 4200.0, 1e-9);
  EXPECT_NEAR(m.center.norm(), 0.0, 1e-14);
  const Mat3 expected = (4200.0 / 12.0 * Vec3(4 + 9, 1 + 9, 1 + 4)).asDiagonal();
  EXPECT_NEAR((m.inertia - expected).norm(), 0.0, 1e-9);
}

TEST(MassProperties, SphereConvergesToTheAnalyticValuesAtSecondOrder) {
  double last = 0.0;
  for (int level = 2; level <= 5; ++level) {
    const MassProperties m = mass_properties(shapes::icosphere(0.5, level), 1000.0);
    const double volume = 4.0 / 3.0 * pi * 0.125, inertia = 0.4 * 1000.0 * volume * 0.25;
    const double error = 1.0 - m.inertia(0, 0) / inertia;
    EXPECT_GT(error, 0.0) << "the polyhedron lies inside the sphere";
    if (level > 2) {
      EXPECT_NEAR(last / error, 4.0, 0.2);
    }
    last = error;
  }
  EXPECT_LT(last, 2e-3);
}

TEST(MassProperties, TorusHasTheAnalyticInertia) {
  const double R = 1.0, r = 0.3;
  const MassProperties m = mass_properties(shapes::torus(R, r, 384, 192), 10.0);
  const double volume = 2.0 * pi * pi * R * r * r, mass = 10.0 * volume;
  EXPECT_NEAR(m.volume / volume, 1.0, 4e-4);
  EXPECT_NEAR(m.inertia(2, 2) / (mass * (R * R + 0.75 * r * r)), 1.0, 6e-4);
  EXPECT_NEAR(m.inertia(0, 0) / (mass * (0.5 * R * R + 0.625 * r * r)), 1.0, 6e-4);
}

TEST(MassProperties, FollowsARigidMotionOfTheMesh) {
  const std::uint64_t seed = 7;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  for (int i = 0; i < 5; ++i) {
    TriMesh mesh = shapes::blob(seed + i, 0.3, 3);
    const MassProperties before = mass_properties(mesh, 400.0);
    const Mat3 R = Quat(random(-1, 1), random(-1, 1), random(-1, 1), random(-1, 1)).normalized().toRotationMatrix();
    const Vec3 t(random(-9, 9), random(-9, 9), random(-9, 9));
    for (Vec3& x : mesh.vertices) x = R * x + t;
    const MassProperties after = mass_properties(mesh, 400.0);
    EXPECT_NEAR(after.mass / before.mass, 1.0, 1e-12);
    EXPECT_NEAR((after.center - (R * before.center + t)).norm(), 0.0, 1e-12);
    EXPECT_NEAR((after.inertia - R * before.inertia * R.transpose()).norm() / before.inertia.norm(), 0.0, 1e-11);
  }
}

TEST(MassProperties, TetrahedraAndTheirSurfaceAgree) {
  // A tetrahedral fan from the centre of a box fills the box.
  const TriMesh surface = shapes::box({1.0, 0.5, 0.2}, 2);
  TetMesh tets{surface.vertices, {}};
  tets.vertices.emplace_back(0.1, 0.05, 0.02);
  const auto apex = static_cast<std::int32_t>(surface.vertices.size());
  for (const Triangle& t : surface.triangles) tets.tets.push_back({apex, t[0], t[1], t[2]});
  const MassProperties a = mass_properties(surface, 900.0), b = mass_properties(tets, 900.0);
  EXPECT_NEAR(a.volume, b.volume, 1e-15);
  EXPECT_NEAR((a.center - b.center).norm(), 0.0, 1e-15);
  EXPECT_NEAR((a.inertia - b.inertia).norm(), 0.0, 1e-12);
}

TEST(MassProperties, RefusesInsideOutMeshesAndBadDensities) {
  TriMesh mesh = shapes::box({1, 1, 1});
  EXPECT_THROW(mass_properties(mesh, 0.0), InputError);
  EXPECT_THROW(mass_properties(mesh, std::nan("")), InputError);
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  EXPECT_THROW(mass_properties(mesh, 1.0), InputError);
  EXPECT_THROW(mass_properties(TriMesh{}, 1.0), InputError);
}

}  // namespace
}  // namespace brim::mass_properties_test
