#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "brim/raster/grid_shape.h"
#include "support/worlds.h"

/// What lies close in the hollow of another touches it along an arc, of which each place has a normal of its own: a
/// wheel on a shaft without friction turns on.
namespace brim::shaft_test {
namespace {

constexpr double kBore = 0.1, kRim = 0.19, kWidth = 0.1, h = 0.0125;

/// A ring about the y axis, outside a polygon, with a bore of 96 sides.
TriMesh ring() {
  constexpr int kSides = 96;
  TriMesh m;
  for (const double y : {-0.5 * kWidth, 0.5 * kWidth})
    for (const double r : {kBore, kRim})
      for (int i = 0; i < kSides; ++i) {
        const double t = 2.0 * std::numbers::pi * i / kSides;
        m.vertices.emplace_back(r * std::sin(t), y, r * std::cos(t));
      }
  const auto quad = [&](int a, int b, int c, int d) {
    m.triangles.push_back({a, b, c}), m.triangles.push_back({a, c, d});
  };
  for (int i = 0; i < kSides; ++i) {
    const int j = (i + 1) % kSides;
    const auto at = [&](int side, int rim, int k) { return (2 * side + rim) * kSides + k; };
    quad(at(0, 0, i), at(1, 0, i), at(1, 0, j), at(0, 0, j));
    quad(at(0, 1, i), at(0, 1, j), at(1, 1, j), at(1, 1, i));
    quad(at(0, 0, i), at(0, 0, j), at(0, 1, j), at(0, 1, i));
    quad(at(1, 0, i), at(1, 1, i), at(1, 1, j), at(1, 0, j));
  }
  return m;
}

/// A ring that spins at 5 rad/s on a shaft, and hangs on it by its weight.
World on_a_shaft(double clearance, Response response) {
  WorldOptions o = testing::options_at(h);
  o.response = response;
  World w(o);
  w.add(testing::obstacle("shaft", make_cylinder(kBore - clearance, 0.6), 0.0, Vec3::Zero(),
                          Quat(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX()))));
  DistanceGridOptions grid;
  grid.spacing = 0.5 * h, grid.margin = 2.0 * h;
  const TriMesh mesh = ring();
  RigidModel m;
  m.shape = make_grid_shape(std::make_shared<const DistanceGrid>(make_distance_grid(mesh, grid)), kRim - kBore);
  const MassProperties mass = mass_properties(mesh, 2000.0);
  m.mass = mass.mass, m.inertia = mass.inertia, m.center_of_mass = mass.center;
  m.position = Vec3(0, 0, -clearance), m.angular_velocity = Vec3(0, 5, 0);
  m.part.voxel_size = h, m.part.material.friction = 0.0;
  w.add(std::make_unique<RigidBody>(m));
  return w;
}

TEST(Shaft, AWheelOnRowsTurnsOnWithoutFriction) {
  // Rows of one normal for all of an arc held it fast within a fifth of a second.
  for (const double clearance : {0.005, 0.001}) {
    World w = on_a_shaft(clearance, Response::Constraint);
    testing::run(w, 0.5);
    EXPECT_GT(testing::spin(w, 1).y(), 0.65 * 5.0) << "clearance " << clearance;
    EXPECT_LT(testing::spin(w, 1).y(), 5.01) << "clearance " << clearance;
    const Vec3 x = testing::position(w, 1);
    EXPECT_LT(std::hypot(x.x(), x.z()), 0.1 * h + clearance) << "clearance " << clearance;
  }
}

TEST(Shaft, AWheelOnPenaltiesIsNotDriven) {
  World w = on_a_shaft(0.005, Response::Penalty);
  for (int s = 0; s < 60; ++s) {
    w.step();
    EXPECT_LT(testing::spin(w, 1).y(), 5.05) << "step " << s;
  }
  EXPECT_GT(testing::spin(w, 1).y(), 1.0);
}

}  // namespace
}  // namespace brim::shaft_test
