#include "brim/world/rigid_contacts.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/math/rotation.h"
#include "support/worlds.h"

/// What is sampled of rigid solids at their references, kept and moved along.
namespace brim::rigid_contacts_test {
namespace {

constexpr unsigned kSeed = 31;

/// Boxes and balls that fall into a heap.
World heap(unsigned seed, int count) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  WorldOptions o = testing::options_at(0.125);
  o.response = Response::Constraint;
  World w(o);
  w.add(testing::ground(0.5));
  for (int i = 0; i < count; ++i) {
    const double x = u(rng), y = u(rng), a = u(rng), b = u(rng), c = u(rng);
    const testing::Start s{Vec3(0.6 * x, 0.6 * y, 0.9 + 0.9 * i), rotation_from_vector(2 * Vec3(a, b, c))};
    if (i % 2)
      w.add(testing::ball("ball" + std::to_string(i), s, 0.5, 0.35));
    else
      w.add(testing::box("box" + std::to_string(i), s, 0.5, 0.7));
  }
  return w;
}

TEST(RigidContacts, WhatIsKeptEqualsWhatIsSampledAnewBitForBit) {
  for (unsigned seed = kSeed; seed < kSeed + 2; ++seed) {
    SCOPED_TRACE(seed);
    World kept = heap(seed, 8), anew = heap(seed, 8);
    std::int64_t nodes_kept = 0, nodes_anew = 0;
    for (int s = 0; s < 150; ++s) {
      anew.set_state(anew.state());  // nothing is kept over it but the state
      nodes_kept += kept.step().voxels, nodes_anew += anew.step().voxels;
      ASSERT_EQ(kept.hash(), anew.hash()) << "step " << s;
    }
    EXPECT_LT(nodes_kept, nodes_anew) << "something was kept";
  }
}

TEST(RigidContacts, RowsThatAreMovedAlongTellTheGapsOfRowsThatAreSampledWhereSolidsAre) {
  // A ball that slides slowly over a plane, seen by a world that samples it now and then, and by one that never saw it.
  WorldOptions o = testing::options_at(0.125);
  o.response = Response::Constraint;
  const auto build = [&](const Vec3& normal) {
    World w(o);
    w.add(testing::ground(0.0, normal));
    w.add(testing::ball("ball", {0.498 * normal, Quat::Identity(), 0.05 * normal.cross(Vec3(0, 1, 0))}, 0.0));
    return w;
  };
  for (const Vec3& n : {Vec3(0, 0, 1), Vec3(0.1, -0.2, 1)}) {
    World w = build(n.normalized());
    std::int64_t nodes = 0;
    int sampled = 0;
    for (int s = 0; s < 60; ++s) {
      World fresh = build(n.normalized());
      State state = w.state();
      state.warm_start.clear();
      fresh.set_state(state);
      const StepReport r = w.step(), f = fresh.step();
      nodes += r.voxels, sampled += r.voxels > 0;
      // Sliding takes both references along by up to a tenth of a voxel each: 0.2²/8 of a ball of four voxels.
      ASSERT_NEAR(r.worst_overlap, f.worst_overlap, 0.005) << "step " << s;
    }
    EXPECT_GT(nodes, 0);
    EXPECT_LT(sampled, 60);
  }
}

TEST(MovedRows, FollowASmallMotionToSecondOrder) {
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  const auto vec = [&] {
    const double x = u(rng), y = u(rng), z = u(rng);
    return Vec3(x, y, z);
  };
  const Aabb local{Vec3::Constant(-1), Vec3::Constant(1)};
  for (int trial = 0; trial < 20; ++trial) {
    // A ball of radius 1 against the half-space n·x <= d, both turning and moving a little.
    Pose ball{rotation_from_vector(vec()).toRotationMatrix(), vec()}, plane{Mat3::Identity(), vec()};
    const Vec3 n = vec().normalized();
    const auto gap = [&](const Pose& a, const Pose& b) {
      return (b.rotation * n).dot(a.translation - b.translation) - 1.0;
    };
    RowPoint row;
    row.normal = n, row.gap = gap(ball, plane), row.point = ball.translation - (1.0 + 0.5 * row.gap) * n;
    double last = 0.0;
    const Vec3 ta = vec(), ra = vec(), tb = vec(), rb = vec();
    for (const double step : {1e-2, 1e-3}) {
      ReferencePoses references;
      references.reset(2);
      references.follow(0, ball, local, 0.0, 1.0), references.follow(1, plane, local, 0.0, 1.0);
      const auto after = [&](const Pose& p, const Vec3& t, const Vec3& r) {
        return Pose{rotation_from_vector(step * r).toRotationMatrix() * p.rotation, p.translation + step * t};
      };
      const Pose a = after(ball, ta, ra), b = after(plane, tb, rb);
      references.follow(0, a, local, 0.0, 1.0), references.follow(1, b, local, 0.0, 1.0);
      const double miss = std::abs(moved(row, references.motion(0), references.motion(1), 0.1).gap - gap(a, b));
      EXPECT_LT(miss, 20.0 * step * step);
      last = miss;
    }
    EXPECT_LT(last, 2e-5);
  }
}

TEST(MovedRows, RollWithABallAndTurnWithThePlaneBelow) {
  constexpr double R = 0.7, h = 0.02;
  RowPoint row;
  row.normal = Vec3(0.1, -0.3, 1.0).normalized();
  const auto t = tangents_of(row.normal);
  row.point = Vec3(1, 2, 3);
  row.bend_a = {static_cast<float>(1.0 / R), 0.0f, static_cast<float>(1.0 / R)};
  const Vec3 center = row.point + R * row.normal;
  // The ball rolls by a small way, the plane turns about the point.
  const Vec3 way = 1e-3 * (0.8 * t.col(0) + 0.6 * t.col(1)), spin = row.normal.cross(way) / R;
  RigidMotion ball, plane;
  ball.none = false, ball.center = center, ball.shift = way, ball.rotation = spin, ball.turn = skew(spin);
  EXPECT_LT(ball.displacement(row.point).norm(), 1e-12);
  const RowPoint rolled = moved(row, ball, plane, h);
  // A curvature of 1e-4/h counts as flat, which leaves 2 % here.
  EXPECT_LT((rolled.point - row.point - way).norm(), 0.02 * way.norm());
  EXPECT_LT((rolled.normal - row.normal).norm(), 1e-6);
  plane.none = false, plane.center = row.point, plane.rotation = 1e-3 * t.col(0), plane.turn = skew(plane.rotation);
  const RowPoint turned = moved(row, {}, plane, h);
  EXPECT_LT((turned.normal - row.normal - plane.rotation.cross(row.normal)).norm(), 1e-5);
  // The least gap is where the ball's normal is the plane's.
  EXPECT_LT((turned.point - (center - R * turned.normal)).norm(), 0.02 * 1e-3 * R);
}

TEST(RigidContacts, ABallThatRollsSlowlyIsNotDrivenOn) {
  WorldOptions o = testing::options_at(0.125);
  o.response = Response::Constraint;
  World w(o);
  w.add(testing::ground(0.5));
  const double speed = 0.1;
  const int b =
      w.add(testing::ball("ball", {Vec3(0, 0, 0.5), Quat::Identity(), Vec3(speed, 0, 0), Vec3(0, 2 * speed, 0)}));
  std::int64_t nodes = 0, sampled = 0;
  for (int s = 0; s < 180; ++s) {
    const std::int64_t n = w.step().voxels;
    nodes += n, sampled += n > 0;
  }
  EXPECT_LT(sampled, 60) << "most steps went by what was kept";
  EXPECT_NEAR(testing::velocity(w, b).x(), speed, 0.005 * speed);
}

TEST(RigidContacts, APlaneCarriesBeyondTheSquareThatIsShownOfIt) {
  WorldOptions o = testing::options_at(0.125);
  o.response = Response::Constraint;
  World w(o);
  ObstacleModel m;
  m.shape = make_half_space();
  m.surface = TriMesh{{Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1, 0)}, {{0, 1, 2}}};
  auto ground = std::make_unique<ObstacleBody>(m);
  ground->set_name("ground");
  w.add(std::move(ground));
  const int b = w.add(testing::box("box", {Vec3(5, 0, 0.5)}));
  testing::run(w, 0.5);
  EXPECT_NEAR(testing::position(w, b).z(), 0.5, 1e-3);
}

TEST(ReferencePoses, StayUntilAPointHasMovedByTheTolerance) {
  const Aabb local{Vec3(-1, -2, -3), Vec3(1, 2, 3)};
  const double h = 0.5, most = ReferencePoses::kTolerance * h;
  ReferencePoses r;
  r.reset(1);
  EXPECT_EQ(r.stamp(0), 0u);
  r.follow(0, {}, local, 0.0, h);
  const auto first = r.stamp(0);
  EXPECT_NE(first, 0u);
  r.follow(0, {Mat3::Identity(), Vec3(0.99 * most, 0, 0)}, local, 0.0, h);
  EXPECT_EQ(r.stamp(0), first);
  EXPECT_EQ(r.pose(0).translation, Vec3::Zero());
  EXPECT_NEAR(r.motion(0).displacement(Vec3(5, 6, 7)).x(), 0.99 * most, 1e-15);
  // A turn about z moves the corners by its angle times sqrt(5).
  const double angle = most / std::sqrt(5.0);
  r.follow(0, {rotation_from_vector(Vec3(0, 0, 0.99 * angle)).toRotationMatrix(), Vec3::Zero()}, local, 0.0, h);
  EXPECT_EQ(r.stamp(0), first);
  r.follow(0, {rotation_from_vector(Vec3(0, 0, 1.01 * angle)).toRotationMatrix(), Vec3::Zero()}, local, 0.0, h);
  EXPECT_NE(r.stamp(0), first);
  EXPECT_TRUE(r.motion(0).none);
  // A ball within that box, of radius 1: by its place and its turn alone.
  const Pose now = r.pose(0);
  const auto second = r.stamp(0);
  const Pose turned{rotation_from_vector(Vec3(0, 0, 0.99 * most)).toRotationMatrix() * now.rotation, now.translation};
  r.follow(0, turned, local, 1.0, h);
  EXPECT_EQ(r.stamp(0), second);
}

TEST(ReferencePoses, ComeBackFromMemoryAsTheyWere) {
  ReferencePoses r;
  r.reset(3);
  const Pose pose{rotation_from_vector(Vec3(0.1, 0.7, -0.4)).toRotationMatrix(), Vec3(1, 2, 3)};
  r.follow(2, pose, {Vec3::Zero(), Vec3::Ones()}, 0.0, 1.0);
  const std::vector<double> rows{0, 2, 1, 1, 1, 5, 6, 7};
  std::vector<double> memory = rows;
  const std::int32_t parts[] = {2};
  r.keep(parts, memory);
  r.keep(parts, memory);  // what is there is replaced
  EXPECT_EQ(memory.size(), rows.size() + 14);
  const auto left = ReferencePoses::rows_of(memory);
  EXPECT_TRUE(std::equal(left.begin(), left.end(), rows.begin(), rows.end()));
  ReferencePoses s;
  s.restore(memory, 3);
  EXPECT_EQ(s.pose(2).rotation, pose.rotation);
  EXPECT_EQ(s.pose(2).translation, pose.translation);
  EXPECT_EQ(s.stamp(1), 0u);
  EXPECT_NE(s.stamp(2), 0u);
  r.keep({}, memory);
  EXPECT_EQ(memory, rows);
}

}  // namespace
}  // namespace brim::rigid_contacts_test
