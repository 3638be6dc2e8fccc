#include <gtest/gtest.h>

#include "brim/mesh/distance_grid.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/primitives.h"
#include "brim/raster/grid_shape.h"
#include "support/worlds.h"

/// What falls flat on a floor lies flat: rows stand under all of its face, however teeth and holes part it.
namespace brim::flat_landing_test {
namespace {

/// [degrees] how far a solid that falls by half a metre is tilted at most, turned about the vertical by so much.
double most_tilt(const TriMesh& mesh, double turned, double time_step) {
  constexpr double kVoxel = 0.02;
  WorldOptions o = testing::options_at(kVoxel);
  o.response = Response::Constraint, o.time_step = time_step;
  World w(o);
  w.add(testing::ground(0.4));
  const MassProperties solid = mass_properties(mesh, 1000.0);
  TriMesh centred = mesh;
  double lowest = 0.0;
  for (Vec3& v : centred.vertices) v -= solid.center, lowest = std::min(lowest, v.z());
  RigidModel m;
  m.shape = make_grid_shape(
      std::make_shared<const DistanceGrid>(make_distance_grid(centred, DistanceGridOptions{.spacing = 0.5 * kVoxel})),
      0.1);
  m.mass = solid.mass, m.inertia = solid.inertia;
  m.position = Vec3(0.003, 0.007, 0.5 - lowest);
  m.rotation = Eigen::AngleAxisd(turned * M_PI / 180.0, Vec3::UnitZ());
  auto body = std::make_unique<RigidBody>(m);
  body->set_name("solid");
  const int b = w.add(std::move(body));
  double most = 0.0;
  for (double t = 0.0; t < 0.8; t += time_step) {
    EXPECT_TRUE(w.step().ok);
    const auto q = w.q(b);
    const Vec3 up = Quat(q[3], q[4], q[5], q[6]) * Vec3::UnitZ();
    most = std::max(most, std::acos(std::min(1.0, up.z())) * 180.0 / M_PI);
  }
  // Gaps of up to 0.05 voxel count as touch where nodes tell them.
  EXPECT_NEAR(testing::position(w, b).z(), -lowest, 0.06 * kVoxel);
  return most;
}

TEST(FlatLanding, AGearLiesFlat) {
  const TriMesh gear = shapes::gear(8, 0.2, 0.14, 0.12, 0.05);
  for (const double dt : {1.0 / 60, 1.0 / 120})
    for (const double turned : {0.0, 17.0}) EXPECT_LT(most_tilt(gear, turned, dt), 0.05) << dt << ", " << turned;
}

TEST(FlatLanding, ABeakerLiesFlat) {
  const TriMesh cup = shapes::cup(0.15, 0.3, 0.05);
  for (const double turned : {0.0, 31.0}) EXPECT_LT(most_tilt(cup, turned, 1.0 / 60), 0.5) << turned;
}

}  // namespace
}  // namespace brim::flat_landing_test
