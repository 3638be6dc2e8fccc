#include "brim/response/fitting_solids.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "brim/math/rotation.h"
#include "brim/mesh/distance_grid.h"
#include "brim/raster/grid_shape.h"
#include "brim/raster/shape.h"
#include "contact/solid_side.h"

/// Solids that fit each other are told from others, and the rates of their overlap are those of their motion.
namespace brim::fitting_solids_test {
namespace {

using testing::solid_side;

constexpr double h = 0.1, w = 0.3;

/// The contacts between two solids within a box.
ContactSet contacts_of(const CubeSide& a, const CubeSide& b, const Vec3i& reach) {
  ContactSet set;
  ContactPair pair;
  pair.part_a = 0, pair.part_b = 1, pair.h = h, pair.w = w, pair.margin = 0.4;
  set.pairs.push_back(pair);
  CubeFinds finds;
  find_between_solids(a, b, pair, {-reach, reach}, finds);
  const PairFinds piece{0, &finds};
  gather({&piece, 1}, set);
  return set;
}

/// All of space but a bore along z; the shape's frame is turned about the axis.
std::shared_ptr<const Shape> bored(double radius) {
  const Vec3 half(1.2, 1.2, 0.6);
  return make_grid_shape(std::make_shared<DistanceGrid>(sample_distance(
                             {-half, half}, 0.5 * h, [=](const Vec3& x) { return radius - std::hypot(x.x(), x.y()); })),
                         half.prod() * 8.0);
}

TEST(FittingSolids, AShaftFitsItsBoreAndNeitherABallNorABoxFitsAPlane) {
  const auto fits = [](const std::shared_ptr<const Shape>& a, const Pose& at, const std::shared_ptr<const Shape>& b) {
    const ContactSet set = contacts_of(solid_side(a, at), solid_side(b, {}), {12, 12, 4});
    EXPECT_GT(set.size(), 4u);
    return fit_each_other(set, set.pairs[0]);
  };
  const auto at = [](double x, double y, double z) { return Pose{Mat3::Identity(), Vec3(x, y, z)}; };
  const auto shaft = make_cylinder(0.76, 4.0);
  EXPECT_TRUE(fits(shaft, at(0.02, 0.01, 0), bored(0.8)));
  EXPECT_TRUE(fits(make_cylinder(0.59, 4.0), at(0, 0.01, 0), bored(0.6)));
  EXPECT_FALSE(fits(make_sphere(0.5), at(0, 0, 0.49), make_half_space()));
  EXPECT_FALSE(fits(make_box(Vec3(1, 1, 0.4)), at(0.03, 0.02, 0.2), make_half_space()));
}

TEST(FittingSolids, TheMotionOfARigidPartIsFoundFromVelocitiesOfItsPoints) {
  std::mt19937 rng(3);
  std::normal_distribution<double> normal;
  const auto some = [&] { return Vec3(normal(rng), normal(rng), normal(rng)); };
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 center = some(), velocity = some(), spin = 3.0 * some();
    std::vector<Vec3> x, v;
    for (int i = 0; i < 5; ++i) x.push_back(some()), v.push_back(velocity + spin.cross(x.back() - center));
    const SolidMotion m = rigid_motion_of(x, v, velocity);
    EXPECT_LE((m.spin - spin).norm(), 1e-9 * spin.norm());
    // Where a point of the solid goes: about the centre, which goes straight on.
    const double dt = 0.1;
    const Mat3 turn = rotation_from_vector(dt * spin).toRotationMatrix();
    const Pose now{rotation_from_vector(some()).toRotationMatrix(), some()}, then = m.after(now, dt);
    EXPECT_LE((then.rotation - turn * now.rotation).norm(), 1e-9);
    const Vec3 expected = center + dt * velocity + turn * (now.translation - center);
    EXPECT_LE((then.translation - expected).norm(), 1e-9);
  }
}

TEST(FittingSolids, RatesForetellTheOverlapThatIsFoundAtTheNextPoses) {
  const auto shaft = make_cylinder(0.76, 4.0), bore = bored(0.8);
  const double dt = 1.0 / 60.0;
  const CubeSide a = solid_side(shaft, {Mat3::Identity(), Vec3(0.03, 0.01, 0)}), b = solid_side(bore, {});
  const ContactSet set = contacts_of(a, b, {12, 12, 4});
  SolidMotion still, moves;
  moves.velocity = Vec3(0.4, -0.2, 0.0), moves.spin = Vec3(0.3, 0.1, 5.0);
  std::vector<double> rate(set.size());
  set_rates_by_motion(set, set.pairs[0], a, b, still, moves, Vec3::Zero(), dt, rate);
  CubeSide then = b;
  then.pose = moves.after(b.pose, dt);
  const ContactSet next = contacts_of(a, then, {12, 12, 4});
  std::size_t compared = 0, j = 0;
  double most = 0.0;
  for (std::size_t i = 0; i < set.size(); ++i) {
    for (j = 0; j < next.size() && next.node[j] != set.node[i]; ++j) {
    }
    if (j == next.size()) continue;
    EXPECT_NEAR(set.overlap[i] - dt * rate[i], next.overlap[j], 1e-5);
    most = std::max(most, std::abs(dt * rate[i]));
    ++compared;
  }
  EXPECT_GT(compared, 100u);
  EXPECT_GT(most, 0.02);
}

TEST(FittingSolids, ASpinAboutTheCommonAxisForetellsHardlyAnyOverlap) {
  const double dt = 1.0 / 60.0;
  const auto shaft = make_cylinder(0.79, 4.0), bore = bored(0.8);
  const CubeSide a = solid_side(shaft, {}), b = solid_side(bore, {});
  const ContactSet set = contacts_of(a, b, {12, 12, 4});
  ASSERT_GT(set.size(), 100u);
  SolidMotion still, spins;
  spins.spin = Vec3(0, 0, 5.0);
  std::vector<double> rate(set.size());
  set_rates_by_motion(set, set.pairs[0], a, b, still, spins, Vec3::Zero(), dt, rate);
  // By the samples' accuracy alone: points move by two thirds of a voxel.
  for (const double r : rate) EXPECT_LE(std::abs(dt * r), 0.01);
}

}  // namespace
}  // namespace brim::fitting_solids_test
