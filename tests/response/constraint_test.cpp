#include "brim/response/constraint.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/math/rotation.h"
#include "brim/mesh/distance_grid.h"
#include "brim/raster/grid_shape.h"
#include "brim/response/penalty.h"
#include "contact/solid_side.h"
#include "support/touching.h"

namespace brim::constraint_test {
namespace {

using testing::plane_pose;
using testing::Touching;

/// The rows of a shape at a plane through the origin.
Constraint rows_of(const Shape& shape, const Pose& pose, const Pose& plane, double h, bool rigid = true,
                   const ConstraintOptions& options = {}) {
  const auto half_space = make_half_space();
  const Touching t(shape, pose, *half_space, plane, h, 3 * h, 0.4);
  const std::vector<Vec3> still(t.contacts.size(), Vec3::Zero());
  Penalty normals;
  PenaltyOptions o;
  o.dt = 1.0 / 60.0, o.friction_speed = 1e-3;
  normals.begin(t.contacts, std::vector<PairState>(1), o, still, still);
  Constraint rows;
  ConstraintPair law;
  law.constrained = true, law.friction = 0.5, law.rigid = rigid;
  rows.gather(t.contacts, normals.normals(), std::vector<ConstraintPair>{law}, options);
  return rows;
}

double least_gap(const Constraint& rows) {
  double least = std::numeric_limits<double>::infinity();
  for (const double depth : rows.points().depth) least = std::min(least, -depth);
  return least;
}

TEST(Constraint, ABallHasOnePointWhereItIsNearest) {
  constexpr unsigned kSeed = 3;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const double h = 0.1, R = 0.6;
  const auto ball = make_sphere(R);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 n = Vec3(0.3 * unit(rng), 0.3 * unit(rng), 1.0).normalized();
    const double gap = 0.06 * unit(rng);
    const Vec3 at(unit(rng), unit(rng), unit(rng));
    const Constraint rows = rows_of(*ball, {Mat3::Identity(), at + (R + gap) * n}, plane_pose(n, at), h);
    ASSERT_EQ(rows.points().size(), 1u) << "a rolling ball must not be held by points beside";
    EXPECT_NEAR(-rows.points().depth[0], gap, 0.02 * h);
    EXPECT_NEAR(rows.normals()[0].dot(n), 1.0, 2e-4);
    EXPECT_LT((rows.points().point[0] - (at + 0.5 * gap * n)).norm(), 0.2 * h);
  }
}

TEST(Constraint, ABoxOnAPlaneHasFourPointsOfOneGapAtItsCorners) {
  const double h = 0.1, gap = 0.013;
  const auto box = make_box(Vec3::Ones());
  const Constraint rows =
      rows_of(*box, {Mat3::Identity(), Vec3(0.03, 0.04, 0.5 + gap)}, plane_pose(Vec3::UnitZ(), Vec3::Zero()), h);
  ASSERT_EQ(rows.points().size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(-rows.points().depth[i], gap, 0.01 * h);
    const Vec3 r = rows.points().point[i] - Vec3(0.03, 0.04, 0.0);
    EXPECT_GT(std::min(std::abs(r.x()), std::abs(r.y())), 0.5 - h) << "within a voxel of the corner";
    EXPECT_LT(std::max(std::abs(r.x()), std::abs(r.y())), 0.5 + 0.5 * h);
    EXPECT_GT(rows.normals()[i].z(), 1.0 - 1e-6);
  }
}

TEST(Constraint, ASampledFaceIsHeldAtItsCornersHoweverItLiesInTheGrid) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const double h = 0.1;
  for (const double half : {2.0 * h, 4.0 * h, 8.0 * h}) {
    const auto exact = [&](const Vec3& p) {
      const Vec3 q = p.cwiseAbs() - Vec3(half, half, 4.0 * h);
      return q.cwiseMax(0.0).norm() + std::min(0.0, q.maxCoeff());
    };
    const Vec3 around(half + 4.0 * h, half + 4.0 * h, 8.0 * h);
    const auto block = make_grid_shape(
        std::make_shared<const DistanceGrid>(sample_distance({-around, around}, 0.5 * h, exact)), 4.0 * h);
    const auto plane = make_half_space();
    for (int trial = 0; trial < 60; ++trial) {
      SCOPED_TRACE(::testing::Message() << half / h << " voxels, " << trial);
      // Block and plane turned together.
      const Pose world{rotation_from_vector(Vec3(unit(rng), unit(rng), unit(rng))).toRotationMatrix(),
                       Vec3(unit(rng), unit(rng), unit(rng))};
      const double gap = 0.03 * h * unit(rng);
      const Pose pose{world.rotation, world.translation + world.rotation * Vec3(0, 0, 4.0 * h + gap)};
      const CubeSide a = testing::solid_side(block, pose), b = testing::solid_side(plane, world);
      ConstraintOptions options;
      options.side_a = &a, options.side_b = &b;
      const Constraint rows = rows_of(*block, pose, world, h, true, options);
      ASSERT_EQ(rows.points().size(), 4u);
      for (std::size_t i = 0; i < 4; ++i) {
        const Vec3 x = world.to_local(rows.points().point[i]);
        EXPECT_NEAR(std::abs(x.x()), half, 0.1 * h);
        EXPECT_NEAR(std::abs(x.y()), half, 0.1 * h);
        EXPECT_NEAR(-rows.points().depth[i], gap, 3e-3 * h);
      }
    }
  }
}

TEST(Constraint, ATiltedBoxStandsOnItsEdgeToAFifthOfAVoxel) {
  const double h = 0.1;
  const auto box = make_box(Vec3::Ones());
  for (const double degrees : {18.0, 30.0, 45.0})
    for (int k = 0; k < 8; ++k) {
      const double angle = degrees * M_PI / 180.0, gap = 0.01;
      const Quat q(Eigen::AngleAxisd(angle, Vec3::UnitY()));
      const Vec3 at(0.0137 * k, 0.0071 * k, 0.0119 * k);
      const double height = 0.5 * (std::cos(angle) + std::sin(angle)) + gap;
      const Constraint rows =
          rows_of(*box, {q.toRotationMatrix(), at + Vec3(0, 0, height)}, plane_pose(Vec3::UnitZ(), at), h);
      SCOPED_TRACE(::testing::Message() << degrees << " degrees, " << k);
      EXPECT_NEAR(least_gap(rows), gap, 0.2 * h);
      if (degrees < 20.0) continue;
      // The edge, ten voxels long, is held along its length, by normals of the plane.
      double lo = 0.0, hi = 0.0;
      for (std::size_t i = 0; i < rows.points().size(); ++i) {
        const double y = (rows.points().point[i] - at).y();
        lo = std::min(lo, y), hi = std::max(hi, y);
        EXPECT_GT(rows.normals()[i].z(), 0.999);
      }
      EXPECT_GT(hi - lo, 4.0 * h);
    }
}

TEST(Constraint, NoRowOfAFaceThatMayDeformFallsBelowItsGapAtTheEdges) {
  constexpr unsigned kSeed = 11;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const double h = 0.1;
  const auto box = make_box(Vec3::Constant(0.8));
  for (int trial = 0; trial < 20; ++trial) {
    const double gap = 0.03 * unit(rng);
    const Vec3 at(0.5 * h * unit(rng), 0.5 * h * unit(rng), 0.5 * h * unit(rng));
    const Mat3 turn = Eigen::AngleAxisd(trial % 2 == 0 ? 0.0 : unit(rng), Vec3::UnitZ()).toRotationMatrix();
    const Constraint rows = rows_of(*box, {turn, at + Vec3(0, 0, 0.4 + gap)}, plane_pose(Vec3::UnitZ(), at), h, false);
    ASSERT_GE(rows.points().size(), 16u);
    // Of quadrics that bend little. Those of edges fell by up to 0.13, of corners by 0.045.
    EXPECT_GT(least_gap(rows), gap - 0.02 * h);
  }
}

TEST(Constraint, ARingOnAPlaneIsHeldAllAround) {
  const double h = 0.02, R = 0.14, r = 0.055;
  const auto torus =
      make_grid_shape(std::make_shared<DistanceGrid>(sample_distance(
                          Aabb{Vec3(-0.25, -0.25, -0.12), Vec3(0.25, 0.25, 0.12)}, 0.005,
                          [&](const Vec3& p) { return std::hypot(std::hypot(p.x(), p.y()) - R, p.z()) - r; })),
                      2 * r);
  for (const double degrees : {0.0, 1.0, 4.0})
    for (const double gap : {0.1 * h, -0.2 * h, -1.0 * h}) {
      SCOPED_TRACE(::testing::Message() << degrees << " degrees, gap " << gap / h << " voxels");
      const double angle = degrees * M_PI / 180.0;
      const Mat3 turn = Eigen::AngleAxisd(angle, Vec3(1, 0.3, 0).normalized()).toRotationMatrix();
      const Vec3 middle(0.0037, 0.0081, R * std::sin(angle) + r + gap);
      const Constraint rows = rows_of(*torus, {turn, middle}, plane_pose(Vec3::UnitZ(), Vec3::Zero()), h);
      EXPECT_NEAR(least_gap(rows), gap, 0.1 * h);
      EXPECT_LE(rows.points().size(), 40u);
      // No row asks for what is not there; and none is missing where the ring is nearer than a tenth of a voxel.
      const auto true_gap = [&](double phi) {
        const Vec3 rim = turn * Vec3(R * std::cos(phi), R * std::sin(phi), 0.0);
        return middle.z() + rim.z() - r;
      };
      for (std::size_t i = 0; i < rows.points().size(); ++i) {
        const Vec3 y = turn.transpose() * (rows.points().point[i] - middle);
        EXPECT_GT(-rows.points().depth[i], true_gap(std::atan2(y.y(), y.x())) - 0.15 * h) << "point " << i;
      }
      for (int k = 0; k < 24; ++k) {
        const double phi = 2.0 * M_PI * k / 24;
        if (true_gap(phi) > 0.1 * h) continue;
        const Vec3 at = middle + turn * Vec3(R * std::cos(phi), R * std::sin(phi), -r);
        double nearest = std::numeric_limits<double>::infinity();
        for (const Vec3& y : rows.points().point) nearest = std::min(nearest, (y - at).head<2>().norm());
        EXPECT_LT(nearest, 4.0 * h) << "at " << phi;
      }
    }
}

TEST(Constraint, PairsOfThePenaltyResponseAndEmptyPairsHaveNoPoints) {
  ContactSet none;
  none.pairs.resize(1);
  Constraint rows;
  rows.gather(none, {}, std::vector<ConstraintPair>{{true, 0.5, 0.0, true}}, {});
  EXPECT_EQ(rows.points().size(), 0u);
  rows.set_targets({}, {}, {});
  EXPECT_FALSE(rows.targets_differ());
}

TEST(Constraint, NodesWithoutADirectionMakeNoRowsBetweenSoftParts) {
  // Two bodies in one place: gradients cancel, and the search for patches must end.
  const double h = 0.1;
  const auto ball = make_sphere(0.6);
  const auto half_space = make_half_space();
  const Touching t(*ball, {Mat3::Identity(), Vec3(0, 0, 0.55)}, *half_space, plane_pose(Vec3::UnitZ(), Vec3::Zero()), h,
                   3 * h, 0.4);
  ConstraintPair law;
  law.constrained = true, law.rigid = false;
  Constraint rows;
  for (const double none : {0.0, std::numeric_limits<double>::quiet_NaN()}) {
    std::vector<Vec3> normals(t.contacts.size(), Vec3::Constant(none));
    rows.gather(t.contacts, normals, std::vector<ConstraintPair>{law}, {});
    EXPECT_EQ(rows.points().size(), 0u);
    // Those that have one still do.
    std::fill(normals.begin(), normals.begin() + static_cast<std::ptrdiff_t>(normals.size() / 2), Vec3::UnitZ());
    rows.gather(t.contacts, normals, std::vector<ConstraintPair>{law}, {});
    EXPECT_GT(rows.points().size(), 0u);
  }
}

TEST(Constraint, TargetsByHand) {
  const double h = 0.1;
  const auto ball = make_sphere(0.6);
  Constraint rows = rows_of(*ball, {Mat3::Identity(), Vec3(0, 0, 0.63)}, plane_pose(Vec3::UnitZ(), Vec3::Zero()), h);
  ASSERT_EQ(rows.points().size(), 1u);
  const double gap = -rows.points().depth[0], dt = 0.1;
  // Free of contact it may come as far as the gap, a little less: what is nearly touched counts as touched.
  const std::vector<Vec3> start{Vec3(0, 0, -1.0)}, free{Vec3(0, 0, -2.0)};
  rows.set_targets({dt, 0.0}, start, free);
  EXPECT_NEAR(rows.velocity_targets()[0], -(gap - 0.05 * h) / dt, 1e-9);
  EXPECT_FALSE(rows.targets_differ());
}

TEST(Constraint, OverlapThatNodesCannotTellIsLeftAlone) {
  const double h = 0.1, dt = 0.02;
  const auto push = [&](bool off_nodes, double overlap) {
    const std::vector<RowPoint> row{{Vec3::Zero(), Vec3::UnitZ(), -overlap, Vec3::Zero(), {}, {}}};
    const std::vector<PairRows> pair{{0, 1, h, 3 * h, 0.5, 0.0, off_nodes, 0, 1}};
    Constraint rows;
    rows.gather({}, {}, {}, {}, {pair, row});
    const std::vector<Vec3> still{Vec3::Zero()};
    rows.set_targets({dt, 0.0}, still, still);
    EXPECT_EQ(rows.velocity_targets()[0], 0.0) << "no overlap becomes a velocity";
    return rows.position_targets()[0] * dt;
  };
  // A fifth of what is over the slop: 0.1 h where nodes told the gap, 0.005 h where distances did.
  EXPECT_EQ(push(true, 0.09 * h), 0.0);
  EXPECT_NEAR(push(true, 0.2 * h), 0.02 * h, 1e-6 * h);
  EXPECT_NEAR(push(false, 0.09 * h), 0.017 * h, 1e-6 * h);
  EXPECT_NEAR(push(false, 3.0 * h), 0.1 * h, 1e-6 * h) << "a tenth of a voxel at most";
}

TEST(Constraint, FrictionOfAFaceThatSlidesHasTheCentreOfItsLoad) {
  const double h = 0.1;
  const auto box = make_box(Vec3(1.0, 0.8, 0.4));
  Constraint rows =
      rows_of(*box, {Mat3::Identity(), Vec3(0.03, 0.01, 0.2)}, plane_pose(Vec3::UnitZ(), Vec3::Zero()), h);
  const std::size_t n = rows.points().size();
  ASSERT_GE(n, 4u);
  std::vector<Vec3> force(n), way;
  for (std::size_t c = 0; c < n; ++c) {
    const double load = 1.0 + static_cast<double>(c);
    force[c] = load * (rows.normals()[c] + 0.5 * Vec3(0.6, 0.8, 0.0));
  }
  const std::vector<std::uint8_t> movable(rows.points().pairs.size(), 1), fixed(rows.points().pairs.size(), 0);
  EXPECT_FALSE(rows.center_friction(force, fixed, way));
  const std::vector<Vec3> before(rows.grips().begin(), rows.grips().end());
  ASSERT_TRUE(rows.center_friction(force, movable, way));
  Vec3 of_load = Vec3::Zero(), of_friction = Vec3::Zero();
  for (std::size_t c = 0; c < n; ++c) {
    EXPECT_LT((rows.grips()[c] - before[c] - way[c]).norm(), 1e-12);
    const double load = force[c].dot(rows.normals()[c]);
    of_load += load * rows.points().point[c], of_friction += load * rows.grips()[c];
  }
  EXPECT_LT((of_load - of_friction).head<2>().norm(), 1e-9);
  EXPECT_FALSE(rows.center_friction(force, movable, way)) << "once there, it stays";
  for (Vec3& f : force) f = Vec3(0.0, 0.0, f.z());  // sticks
  EXPECT_FALSE(rows.center_friction(force, movable, way));
}

}  // namespace
}  // namespace brim::constraint_test
