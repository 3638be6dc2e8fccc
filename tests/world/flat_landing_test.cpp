#include <gtest/gtest.h>

#include "brim/mesh/distance_grid.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/topology.h"
#include "brim/raster/grid_shape.h"
#include "support/worlds.h"

/// What falls flat on a floor lies flat: rows stand under all of its face, however teeth and holes part it; and up to
/// its edges, so that it topples where it should.
namespace brim::flat_landing_test {
namespace {

RigidModel sampled(const TriMesh& mesh, double voxel) {
  const MassProperties solid = mass_properties(mesh, 1000.0);
  TriMesh centred = mesh;
  for (Vec3& v : centred.vertices) v -= solid.center;
  const DistanceGridOptions grid{.spacing = 0.5 * voxel};
  RigidModel m;
  m.shape = make_grid_shape(std::make_shared<const DistanceGrid>(make_distance_grid(centred, grid)), 0.1);
  m.mass = solid.mass, m.inertia = solid.inertia;
  return m;
}

int add(World& w, const RigidModel& m) {
  auto body = std::make_unique<RigidBody>(m);
  body->set_name("solid");
  return w.add(std::move(body));
}

/// [degrees] of its own vertical.
double tilt(const World& w, int b) {
  const auto q = w.q(b);
  const Vec3 up = Quat(q[3], q[4], q[5], q[6]) * Vec3::UnitZ();
  return std::acos(std::clamp(up.z(), -1.0, 1.0)) * 180.0 / M_PI;
}

/// [degrees] how far a solid that falls by half a metre is tilted at most, turned about the vertical by so much.
double most_tilt(const TriMesh& mesh, double turned, double time_step) {
  constexpr double kVoxel = 0.02;
  WorldOptions o = testing::options_at(kVoxel);
  o.response = Response::Constraint, o.time_step = time_step;
  World w(o);
  w.add(testing::ground(0.4));
  const double lowest = mass_properties(mesh, 1000.0).center.z() - bounds(mesh.vertices).lo.z();
  RigidModel m = sampled(mesh, kVoxel);
  m.position = Vec3(0.003, 0.007, 0.5 + lowest);
  m.rotation = Eigen::AngleAxisd(turned * M_PI / 180.0, Vec3::UnitZ());
  const int b = add(w, m);
  double most = 0.0;
  for (double t = 0.0; t < 0.8; t += time_step) {
    EXPECT_TRUE(w.step().ok);
    most = std::max(most, tilt(w, b));
  }
  // Gaps of up to 0.05 voxel count as touch where nodes tell them.
  EXPECT_NEAR(testing::position(w, b).z(), lowest, 0.06 * kVoxel);
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

/// True where a sampled block half as wide as high, eight voxels wide, falls over on a slope.
bool topples(double degrees, Response response, const Vec3& shift) {
  constexpr double kWidth = 0.4, kVoxel = kWidth / 8;
  const Quat turn(Eigen::AngleAxisd(degrees * M_PI / 180.0, Vec3::UnitY()));
  WorldOptions o = testing::options_at(kVoxel);
  o.response = response;
  World w(o);
  w.add(testing::ground(0.9, turn * Vec3::UnitZ()));
  RigidModel m = sampled(shapes::box(Vec3(kWidth, kWidth, 2 * kWidth)), kVoxel);
  m.position = turn * (Vec3(0, 0, kWidth) + kVoxel * shift), m.rotation = turn, m.part.material.friction = 0.9;
  const int b = add(w, m);
  for (int s = 0; s < 150; ++s) EXPECT_TRUE(w.step().ok);
  return tilt(w, b) > degrees + 5.0;
}

TEST(FlatLanding, ASampledBlockTopplesWhereItsEdgesSay) {
  // tan θ = 1/2: 26.57 degrees. It was 20 to 24.5 under penalties and 22.5 to 24 on rows.
  for (const Response response : {Response::Penalty, Response::Constraint})
    for (const Vec3& shift : {Vec3(0, 0, 0), Vec3(0.26, 0.42, 0)}) {
      SCOPED_TRACE(::testing::Message() << (response == Response::Penalty ? "penalties, " : "rows, ")
                                        << shift.transpose());
      EXPECT_FALSE(topples(25.75, response, shift));
      EXPECT_TRUE(topples(27.25, response, shift));
    }
}

}  // namespace
}  // namespace brim::flat_landing_test
