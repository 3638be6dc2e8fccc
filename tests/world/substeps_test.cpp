#include "brim/world/substeps.h"

#include <gtest/gtest.h>

#include "brim/body/particle_fluid/particle_fluid_body.h"
#include "brim/body/points/points_body.h"
#include "brim/mesh/distance_grid.h"
#include "brim/raster/grid_shape.h"
#include "support/soft_worlds.h"

namespace brim::substeps_test {
namespace {

using testing::ball;
using testing::box;
using testing::obstacle;
using testing::options_at;

/// Steps a weightless world once. @return its report
StepReport first_step(WorldOptions o, const testing::Start& a, const testing::Start& b) {
  o.environment.gravity = Vec3::Zero();
  World w(o);
  w.add(ball("a", a));
  w.add(ball("b", b));
  return w.step();
}

TEST(Substeps, SurfaceTensionIsStableInThem) {
  // 0.7 √(ρ s³/(2π σ)) = 0.37 ms at 0.5 mm: in steps of 1.04 ms a drop boiled at 0.1 m/s for ever.
  ParticleFluidOptions water;
  water.spacing = 0.0005, water.surface_tension = 0.072, water.gravity = Vec3::Zero();
  std::vector<Vec3> x;
  for (int i = 0; i < 343; ++i) {
    const Vec3 at = 0.0005 * (Vec3(i % 7, i / 7 % 7, i / 49) - Vec3::Constant(3.0));
    if (at.norm() < 0.00155) x.push_back(at);
  }
  WorldOptions o = options_at(0.00025);
  o.environment.gravity.setZero();
  o.time_step = 1.04e-3;
  World w(o);
  w.add(std::make_unique<ParticleFluidBody>(x, water));
  double first = 0.0;
  StepReport r;
  for (int s = 0; s < 200; ++s) {
    r = w.step();
    EXPECT_GE(r.substeps, 3);
    if (s < 40) first = std::max(first, r.kinetic_energy);
  }
  EXPECT_LT(r.kinetic_energy, 0.1 * first) << "its ripples die out";
}

TEST(Substeps, RelativeMotionOfAVoxelNeedsOneEachByHand) {
  WorldOptions o = options_at(0.125);
  o.time_step = 0.1;
  // 5 m/s together for 0.1 s are 0.5 m = 4 voxels.
  EXPECT_EQ(first_step(o, {Vec3(0, 0, 0), Quat::Identity(), Vec3(2, 0, 0)},
                       {Vec3(1.5, 0, 0), Quat::Identity(), Vec3(-3, 0, 0)})
                .substeps,
            4);
  o.max_motion_voxels = 2.0;
  EXPECT_EQ(first_step(o, {Vec3(0, 0, 0), Quat::Identity(), Vec3(2, 0, 0)},
                       {Vec3(1.5, 0, 0), Quat::Identity(), Vec3(-3, 0, 0)})
                .substeps,
            2);
}

TEST(Substeps, CommonMotionAndDistantBodiesNeedNone) {
  WorldOptions o = options_at(0.125);
  const Vec3 fast(50, 0, 0);
  EXPECT_EQ(first_step(o, {Vec3::Zero(), Quat::Identity(), fast}, {Vec3(0, 1.05, 0), Quat::Identity(), fast}).substeps,
            1);
  EXPECT_EQ(first_step(o, {Vec3::Zero(), Quat::Identity(), fast}, {Vec3(0, 9, 0), Quat::Identity(), -fast}).substeps,
            1);
}

TEST(Substeps, MotionAlongAPlaneNeedsNoneByHand) {
  const auto pieces = [](const Vec3& velocity, const Quat& turn, double spin, AlongPlanes along) {
    WorldOptions o = options_at(0.125);
    o.max_motion_voxels = 2.0;
    const auto floor = obstacle("floor", make_half_space(), 0.5, Vec3::Zero(), turn);
    const auto one = ball("ball", {turn * Vec3(0, 0, 0.55)});
    std::vector<double> q(7), v(12);
    for (const auto& [body, at] : {std::pair(floor.get(), 0), std::pair(one.get(), 6)}) {
      body->initial_state(q, std::span(v).subspan(static_cast<std::size_t>(at), 6));
      body->update(0.0, q, std::span(v).subspan(static_cast<std::size_t>(at), 6));
    }
    Eigen::Map<Vec3>(v.data() + 6) = turn * velocity;
    v[5] = spin;
    const std::vector<WorldPart> parts = {{floor.get(), 0, 0, 0.125, floor->part(0)},
                                          {one.get(), 1, 0, 0.125, one->part(0)}};
    BoxSweep sweep;
    return motion_pieces(parts, v, std::vector<std::size_t>{0, 6, 12}, o, 0.1, 0.0, {}, sweep, along);
  };
  const Quat tilted(Eigen::AngleAxisd(0.3, Vec3(1, 2, 0).normalized()));
  for (const Quat& turn : {Quat::Identity(), tilted}) {
    EXPECT_EQ(pieces(Vec3(30, -20, 0), turn, 0.0, AlongPlanes::Ignored), 1.0);
    // 5 m/s towards it for 0.1 s are 4 voxels, whatever the ball does along it: two pieces of two.
    EXPECT_NEAR(pieces(Vec3(0, 0, -5), turn, 0.0, AlongPlanes::Ignored), 2.0, 1e-9);
    EXPECT_NEAR(pieces(Vec3(30, 0, -5), turn, 0.0, AlongPlanes::Ignored), 2.0, 1e-9);
    EXPECT_NEAR(pieces(Vec3(30, 0, 0), turn, 0.0, AlongPlanes::Counted), 12.0, 1e-9);
    EXPECT_NEAR(pieces(Vec3(30, 0, 0), turn, 0.1, AlongPlanes::Ignored), 12.0, 1e-9) << "a plane that turns";
  }
}

TEST(Substeps, BallsFallByLessThanASixthOfTheirRadiusInEachByHand) {
  const auto substeps = [](double radius, double gravity) {
    WorldOptions o = options_at(0.125);
    o.time_step = 0.02;
    o.environment.gravity = Vec3(0, 0, -gravity);
    World w(o);
    PointsOptions grains;
    grains.radius = {radius};
    w.add(testing::named<PointsBody>("grains", std::vector<Vec3>{Vec3::Zero()}, grains));
    return w.step().substeps;
  };
  // g dt² = 4 mm in one step, and 0.16 R = 4 mm, 1.6 mm, 0.4 mm.
  EXPECT_EQ(substeps(0.025, 10.0), 1);
  EXPECT_EQ(substeps(0.01, 10.0), 2);
  EXPECT_EQ(substeps(0.0025, 10.0), 4);
  EXPECT_EQ(substeps(0.0025, 0.0), 1);
}

TEST(Substeps, SpinCountsWithTheReachOfTheBody) {
  WorldOptions o = options_at(0.125);
  o.time_step = 0.1;
  o.environment.gravity = Vec3::Zero();
  World w(o);
  w.add(box("a", {Vec3::Zero(), Quat::Identity(), Vec3::Zero(), Vec3(0, 0, 5)}));
  w.add(box("b", {Vec3(0, 0, 1.05)}));
  // Corners move at 5 * sqrt(3)/2 = 4.33 m/s: 3.5 voxels in the step.
  EXPECT_EQ(w.step().substeps, 4);
}

/// Sub-steps of a step of a soft beam beside a ball at its left end, whose nodes from x0 to x1 move at 10 m/s.
int substeps_of_beam(double x0, double x1) {
  WorldOptions o = options_at(0.1);
  o.environment.gravity = Vec3::Zero();
  World w(o);
  const TetMesh mesh = testing::block(24, 2, 2, 0.1);
  FemOptions soft;
  soft.young = 100.0;
  w.add(testing::named<FemBody>("beam", mesh, soft));
  w.add(ball("ball", {Vec3(0.1, 0.1, -0.6)}));
  State s = w.state();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (mesh.vertices[i].x() > x0 && mesh.vertices[i].x() < x1) s.v[3 * i + 2] = 10.0;
  w.set_state(s);
  return w.step().substeps;
}

TEST(Substeps, AFastEndOfASoftBodyCountsWhereItIs) {
  // 10 m/s in a sixtieth of a second are 1.7 voxels.
  EXPECT_EQ(substeps_of_beam(2.15, 9.0), 1);
  EXPECT_GE(substeps_of_beam(-1.0, 0.25), 2);
}

/// Pieces that two soft bars ask for, side by side, whose nodes move along z by `slope` m/s a metre.
double pieces_of_bars(double slope, double gap) {
  WorldOptions o = options_at(0.1);
  const TetMesh mesh = testing::block(24, 1, 1, 0.1);
  TetMesh beside = mesh;
  for (Vec3& x : beside.vertices) x.y() += 0.1 + gap;
  const auto one = testing::named<FemBody>("one", mesh, FemOptions{}),
             two = testing::named<FemBody>("two", beside, FemOptions{});
  const std::size_t n = 3 * mesh.vertices.size();
  const std::vector<WorldPart> parts = {{one.get(), 0, 0, 0.1, one->part(0)}, {two.get(), 1, 0, 0.1, two->part(0)}};
  const std::vector<std::size_t> first_v = {0, n, 2 * n};
  std::vector<double> v;
  for (const TetMesh& m : {mesh, beside})
    for (const Vec3& x : m.vertices) v.insert(v.end(), {0.0, 0.0, slope * x.x()});
  BoxSweep sweep;
  return motion_pieces(parts, v, first_v, o, 0.1, 0.0, {}, sweep);
}

TEST(Substeps, MotionThatNeighboursShareDoesNotCount) {
  // Both bars turn alike, 24 m/s at their far ends. What may meet lies no farther apart along them than two clusters of
  // three cells at most and the cell beyond which nothing meets.
  const double asked = pieces_of_bars(10.0, 0.0);
  EXPECT_GT(asked, 1.0);
  EXPECT_LE(asked, 10.0 * (2.0 * 0.3 + 0.1) * 0.1 / 0.1 + 1e-9);
  EXPECT_EQ(pieces_of_bars(10.0, 0.5), 1.0);
}

/// Pieces that a still ball at the origin and loose particles ask for within a tenth of a second, at 0.1 m a voxel.
/// @param make  the body of particles at places
template <class Make>
double pieces_beside_a_ball(const Make& make, const std::vector<Vec3>& x, const std::vector<Vec3>& velocity) {
  const WorldOptions o = options_at(0.1);
  const auto one = ball("ball", {});
  const auto loose = make(x);
  std::vector<double> q(loose->q_size()), v(6 + loose->v_size());
  const std::span<double> own = std::span(v).subspan(6);
  loose->initial_state(q, own);
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) own[own.size() / x.size() * i + k] = velocity[i][static_cast<Eigen::Index>(k)];
  loose->update(0.0, q, own);
  const std::vector<WorldPart> parts = {{one.get(), 0, 0, 0.1, one->part(0)}, {loose.get(), 1, 0, 0.1, loose->part(0)}};
  const std::vector<std::size_t> first_v = {0, 6, v.size()};
  BoxSweep sweep;
  return motion_pieces(parts, v, first_v, o, 0.1, 0.0, {}, sweep);
}

std::unique_ptr<Body> liquid(const std::vector<Vec3>& x) {
  ParticleFluidOptions o;
  o.spacing = 0.2;
  return testing::named<ParticleFluidBody>("liquid", x, o);
}
std::unique_ptr<Body> grains(const std::vector<Vec3>& x) {
  PointsOptions o;
  o.radius = {0.15};
  return testing::named<PointsBody>("grains", x, o);
}

TEST(Substeps, WhatWasSpilledAndFallsByItselfAsksForNothing) {
  // Some lie on the ball; others, which the ball's side of the body's box holds too, fall far beside it at 30 m/s.
  const std::vector<Vec3> x = {Vec3(0, 0, 0.7), Vec3(0.3, 0, 0.6), Vec3(3, 0, 4), Vec3(3, 0.2, 4), Vec3(-3, -3, -4)};
  const Vec3 rest = Vec3::Zero(), fast(0, 0, -30);
  for (const auto& make : {liquid, grains}) {
    EXPECT_EQ(pieces_beside_a_ball(make, x, {rest, rest, fast, fast, fast}), 1.0);
    EXPECT_GT(pieces_beside_a_ball(make, x, {fast, rest, rest, rest, rest}), 5.0);
  }
}

TEST(Substeps, LooseMatterThatMeetsItselfCounts) {
  const std::vector<Vec3> x = {Vec3(5, 0, 0), Vec3(5, 0, 1)};
  for (const auto& make : {liquid, grains}) {
    EXPECT_EQ(pieces_beside_a_ball(make, x, {Vec3(0, 0, -9), Vec3(0, 0, -9)}), 1.0);
    EXPECT_GT(pieces_beside_a_ball(make, x, {Vec3(0, 0, 9), Vec3(0, 0, -9)}), 10.0);
  }
}

TEST(Substeps, FastGrainsOfABodyDoNotMissEachOther) {
  // Head-on they would pass each other by four of their sizes in a step.
  WorldOptions o = options_at(0.05);
  o.environment.gravity = Vec3::Zero();
  World w(o);
  PointsOptions grain;
  grain.radius = {0.05};
  w.add(testing::named<PointsBody>("grains", std::vector<Vec3>{Vec3(-0.3, 0, 0), Vec3(0.3, 0, 0)}, grain));
  State s = w.state();
  s.v[0] = 30.0, s.v[6] = -30.0;
  w.set_state(s);
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(w.step().ok);
  EXPECT_LT(w.state().q[0], w.state().q[3]);
  EXPECT_LT(w.state().v[0], 1.0);
  EXPECT_GT(w.state().v[6], -1.0);
}

TEST(Substeps, ThickSoftPartsMayMoveFartherThanThinOnes) {
  WorldOptions o = options_at(0.1);
  const auto block = testing::named<FemBody>("block", testing::block(2, 2, 2, 0.3), FemOptions{});
  const auto sheet = [&](double thickness) {
    WorldPart p{block.get(), 0, 0, 0.1, block->part(0)};
    p.info.thickness = thickness;
    return p;
  };
  // A quarter of both together, from one voxel to two.
  EXPECT_DOUBLE_EQ(motion_limit(sheet(0.2), sheet(0.2), o, false), 0.1);
  EXPECT_DOUBLE_EQ(motion_limit(sheet(0.02), sheet(0.02), o, false), 0.1);
  EXPECT_DOUBLE_EQ(motion_limit(sheet(0.2), sheet(0.4), o, false), 0.15);
  EXPECT_DOUBLE_EQ(motion_limit(sheet(0.9), sheet(0.9), o, false), 0.2);
  o.max_motion_voxels = 2.0;
  EXPECT_DOUBLE_EQ(motion_limit(sheet(0.2), sheet(0.9), o, false), 0.2);
  const auto one = ball("one", {}), two = ball("two", {});
  EXPECT_DOUBLE_EQ(motion_limit({one.get(), 0, 0, 0.1, one->part(0)}, {two.get(), 1, 0, 0.1, two->part(0)}, o, false),
                   0.2);
}

TEST(Substeps, SolidsThatRowsHoldMayMoveByAVoxelAndOthersByTwo) {
  WorldOptions o = options_at(0.125);
  o.response = Response::Constraint;
  const auto one = ball("one", {}), two = ball("two", {});
  const auto part = [&](const std::unique_ptr<Body>& body, int index) {
    WorldPart p{body.get(), index, 0, 0.1, body->part(0)};
    p.info.thickness = 1.0;
    return p;
  };
  EXPECT_DOUBLE_EQ(motion_limit(part(one, 0), part(two, 1), o, true), 0.1);
  EXPECT_DOUBLE_EQ(motion_limit(part(one, 0), part(two, 1), o, false), 0.2);
  EXPECT_TRUE(HeldPairs().contains(1, 2)) << "at the start of a world nothing is known";
  const HeldPairs held({{0, 3}, {1, 2}});
  EXPECT_TRUE(held.contains(2, 1));
  EXPECT_FALSE(held.contains(0, 2));
}

/// A body strikes the ground by almost two voxels a step. @param below  [m] from its middle down to its lowest point
/// @return greatest depth in five steps, [voxels]
double depth_of_a_blow(std::shared_ptr<const Shape> shape, double below, double gap) {
  WorldOptions o = options_at(0.125);
  o.response = Response::Constraint;
  o.environment.gravity = Vec3::Zero();
  o.time_step = 0.01;
  World w(o);
  w.add(testing::ground(0.0));
  RigidModel m;
  m.shape = std::move(shape);
  m.position = Vec3(0, 0, below + 0.2 + gap), m.velocity = Vec3(0, 0, -20);
  m.part.thickness = 2.0 * below;
  w.add(testing::named<RigidBody>("body", m));
  w.step();  // at the start all pairs count as held
  double deepest = 0.0;
  int pieces = 0;
  for (int k = 0; k < 5; ++k) {
    const StepReport r = w.step();
    pieces += r.substeps;
    deepest = std::max(deepest, r.worst_overlap);
  }
  EXPECT_LT(pieces, 7) << "two a step once rows see it";
  EXPECT_LT(std::abs(w.state().v[2]), 0.2) << "it has struck";
  return deepest;
}

TEST(Substeps, ABlowOfTwoVoxelsAStepIsSeenBeforeItLands) {
  const auto ring =
      make_grid_shape(std::make_shared<const DistanceGrid>(sample_distance(
                          Aabb{Vec3(-1.2, -1.2, -0.5), Vec3(1.2, 1.2, 0.5)}, 0.0625,
                          [](const Vec3& x) { return std::hypot(x.head<2>().norm() - 0.8, x.z()) - 0.3; })),
                      0.6);
  for (const double gap : {0.25, 0.30, 0.37, 0.44, 0.51, 0.58}) {
    SCOPED_TRACE(gap);
    EXPECT_LT(depth_of_a_blow(make_box(Vec3::Ones()), 0.5, gap), 0.02);
    EXPECT_LT(depth_of_a_blow(make_sphere(0.5), 0.5, gap), 0.02);
    EXPECT_LT(depth_of_a_blow(ring, 0.3, gap), 0.1) << "found at nodes";
  }
}

TEST(Substeps, TheLimitIsKeptAndTold) {
  WorldOptions o = options_at(0.125);
  o.max_substeps = 5;
  const StepReport r = first_step(o, {Vec3::Zero(), Quat::Identity(), Vec3(100, 0, 0)}, {Vec3(1.1, 0, 0)});
  EXPECT_LE(r.substeps, 5);
  const auto told = std::ranges::find(r.warnings, "substeps_capped", &Warning::code);
  ASSERT_NE(told, r.warnings.end());
  // What moves how far, and three cures.
  for (const char* words : {"at 100 m/s", "voxels in each", "\"time_step\"", "\"max_substeps\"", "\"voxel_size\""})
    EXPECT_NE(told->message.find(words), std::string::npos) << told->message;
}

TEST(Substeps, PiecesMakeUpTheStepExactly) {
  WorldOptions o = options_at(0.125);
  o.environment.gravity = Vec3::Zero();
  World w(o);
  w.add(ball("a", {Vec3::Zero(), Quat::Identity(), Vec3(40, 0, 0)}));
  w.add(obstacle("wall", make_box(Vec3(0.2, 8, 8)), 0.5, Vec3(30, 0, 0)));
  w.add(ball("near", {Vec3(0, 1.2, 0), Quat::Identity(), Vec3(20, 0, 0)}));
  double moved = 0.0;
  for (int s = 0; s < 10; ++s) {
    w.step();
    moved += o.time_step * testing::velocity(w, 0).x();
  }
  EXPECT_NEAR(w.state().time, 10 * o.time_step, 1e-14);
  EXPECT_NEAR(testing::position(w, 0).x(), 40 * 10 * o.time_step, 1e-9);
  EXPECT_NEAR(moved, testing::position(w, 0).x(), 1e-9);
}

TEST(Substeps, WhatIsSqueezedOutMovesNoFartherThanAllowed) {
  // Between two steep slopes a ball that overlaps both is at rest, and is thrown up within the step: the speeds before
  // it ask for one sub-step.
  for (const bool planes : {false, true}) {
    const double h = 0.125, tilt = 4.0 * std::numbers::pi / 180.0;
    WorldOptions o = options_at(h);
    o.environment.gravity = Vec3::Zero();
    o.damping_steps = 0.0;
    o.stiffness = 1e10;
    World w(o);
    for (const double side : {-1.0, 1.0}) {
      const Vec3 n(-side * std::cos(tilt), 0, std::sin(tilt)), at(side * (0.5 - 0.7 * h), 0, 0);
      w.add(obstacle(side < 0 ? "left" : "right", planes ? make_half_space() : make_box(Vec3::Constant(4.0)), 0.0,
                     planes ? at : Vec3(at - 2.0 * n), Quat::FromTwoVectors(Vec3(0, 0, 1), n)));
    }
    w.add(ball("seed", {}, 0.0));
    const StepReport r = w.step();
    const double speed = testing::velocity(w, 2).norm();
    EXPECT_GT(speed * o.time_step, 3.0 * h) << "the case does not throw";
    EXPECT_GT(r.substeps, 1);
    // Once it flies along planes, it may go as far as it likes.
    if (!planes) {
      EXPECT_LE(speed * o.time_step / r.substeps, 2.0 * h);
    }
  }
}

TEST(Substeps, TheFewestThatAreAskedForAreEqual) {
  for (const int fewest : {1, 4, 7}) {
    WorldOptions o;
    o.time_step = 0.02, o.min_substeps = fewest, o.environment.gravity = Vec3(0, 0, -10);
    World w(o);
    w.add(ball("ball", {Vec3(0, 0, 5)}));
    EXPECT_EQ(w.step().substeps, fewest) << "not one short sub-step and one with all the rest";
    EXPECT_NEAR(w.q(0)[2], 5.0 - 0.5 * 10.0 * 4e-4, 1e-12);
  }
}

}  // namespace
}  // namespace brim::substeps_test
