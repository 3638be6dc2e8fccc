#include "brim/world/queries.h"

#include <gtest/gtest.h>

#include <limits>

#include "brim/body/changing_surface.h"
#include "brim/body/points/points_body.h"
#include "brim/core/parallel.h"
#include "mesh/data.h"
#include "support/edited_worlds.h"

/// Rays, nearest points and overlaps in worlds.
namespace brim::testing::queries_test {
namespace {

const Aabb kUnit{Vec3::Constant(-1), Vec3::Constant(1)};

std::unique_ptr<Body> grains(const std::string& name, std::vector<Vec3> centers, std::vector<double> radius) {
  PointsOptions o;
  o.radius = std::move(radius);
  return named<PointsBody>(name, std::move(centers), o);
}

/// One body of each kind that is here, side by side.
World row() {
  World w(told());
  w.add(ground(0.5));
  w.add(ball("ball", {Vec3(0, 0, 1)}, 0.5, 0.5));
  w.add(jelly("jelly", 1.0, Vec3(2.5, -0.5, 0.5)));
  w.add(sheet("sheet", 1.0, Vec3(6, 0, 1)));
  w.add(rope("rope", Vec3(8.5, 0, 1), Vec3(9.5, 0, 1)));
  w.add(grains("grains", {Vec3(12, 0, 1), Vec3(12.5, 0, 1)}, {0.1, 0.2}));
  w.add(blob("fluid", 5, 0.1, Vec3(15, -0.2, 0.8)));
  return w;
}

TEST(Queries, ARayFromAboveMeetsEachKindAtItsTop) {
  const World w = row();
  const auto down = [&](double x, double y = 0.0) { return w.raycast(Vec3(x, y, 5), Vec3(0, 0, -2)); };
  const auto expect = [&](double x, int body, double distance, double error) {
    const auto hit = down(x);
    ASSERT_TRUE(hit) << body;
    EXPECT_EQ(hit->body, body);
    EXPECT_NEAR(hit->distance, distance, error);
    EXPECT_NEAR((hit->point - Vec3(x, 0, 5 - hit->distance)).norm(), 0.0, 1e-12);
    EXPECT_NEAR((hit->normal - Vec3::UnitZ()).norm(), 0.0, 1e-5) << body;
  };
  expect(-3, 0, 5.0, 1e-12);
  expect(0, 1, 3.5, 1e-12);
  expect(3, 2, 3.5, 1e-6);
  expect(6.03, 3, 3.95, 1e-6);  // half of its thickness above it
  expect(9, 4, 3.95, 1e-6);
  expect(12.5, 5, 3.8, 1e-12);
  EXPECT_EQ(down(12.25)->body, 0) << "between the grains";
  const auto water = down(15.25, 0.05);
  ASSERT_EQ(water->body, 6);
  EXPECT_GT(water->point.z(), 1.0);
}

TEST(Queries, TheNearestSurfaceIsThatOfTheNearestMatterAndInsideNegative) {
  const World w = row();
  const auto near = [&](const Vec3& p) { return *w.closest_point(p); };
  EXPECT_EQ(near(Vec3(0, 0, 2)).body, 1);
  EXPECT_NEAR(near(Vec3(0, 0, 2)).distance, 0.5, 1e-12);
  EXPECT_NEAR(near(Vec3(0, 0.1, 1)).distance, -0.4, 1e-12);
  EXPECT_NEAR((near(Vec3(0, 0.1, 1)).point - Vec3(0, 0.5, 1)).norm(), 0.0, 1e-6);
  EXPECT_EQ(near(Vec3(3, 0, 1.4)).body, 2);
  EXPECT_NEAR(near(Vec3(3, 0, 1.4)).distance, -0.1, 1e-6);
  EXPECT_NEAR((near(Vec3(3, 0, 1.4)).normal - Vec3::UnitZ()).norm(), 0.0, 1e-5);
  EXPECT_NEAR(near(Vec3(6, 0, 1.02)).distance, -0.03, 1e-6) << "within the sheet";
  EXPECT_NEAR(near(Vec3(12, 0, 1.3)).distance, 0.2, 1e-12);
  EXPECT_FALSE(w.closest_point(Vec3(0, 0, 2), 0.49));
  EXPECT_TRUE(w.closest_point(Vec3(0, 0, 2), 0.51));
  EXPECT_EQ(near(Vec3(0, 0, -1)).body, 0);
  EXPECT_NEAR(near(Vec3(0, 0, -1)).distance, -1.0, 1e-12);
}

TEST(Queries, OverlapsAreTheBodiesWithMatterThere) {
  const World w = row();
  const Vec3 middle(0, 0, 0.3);
  EXPECT_EQ(w.overlap_ball(middle, 0.1), (std::vector<int>{}));
  EXPECT_EQ(w.overlap_ball(middle, 0.21), (std::vector<int>{1}));
  EXPECT_EQ(w.overlap_ball(middle, 0.31), (std::vector<int>{0, 1}));
  EXPECT_EQ(w.overlap_ball(Vec3(3, 0, 1), 0.0), (std::vector<int>{2})) << "a point inside";
  const Pose at{Mat3::Identity(), Vec3(7.6, 0, 1)};
  EXPECT_EQ(w.overlap_box(at, Vec3(1.6, 0.2, 0.2)), (std::vector<int>{})) << "between the sheet and the rope";
  EXPECT_EQ(w.overlap_box(at, Vec3(1.9, 0.2, 0.2)), (std::vector<int>{4}));
  EXPECT_EQ(w.overlap_box(at, Vec3(2.3, 0.2, 0.2)), (std::vector<int>{3, 4}));
  EXPECT_EQ(w.overlap_box({Mat3::Identity(), Vec3(3, 0, 1)}, Vec3::Constant(0.1)), (std::vector<int>{2}))
      << "wholly within";
  EXPECT_EQ(w.overlap_box({Mat3::Identity(), Vec3(8, 0, 1)}, Vec3(30, 3, 3)).size(), 7u);
}

TEST(Queries, RaysMeetWhatASweepOverAllTrianglesMeets) {
  const std::uint64_t seed = 41;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  World w(told());
  w.add(ground(0.5));
  add_soft(w);
  for (int s = 0; s < 20; ++s) w.step();
  int met = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 from = Vec3(0.3, 0, 1.0) + 3.0 * random.in(kUnit).normalized();
    const Ray ray{from, (Vec3(0.3, 0, 0.5) + 0.7 * random.in(kUnit)-from).normalized()};
    if (from.z() <= 0.0) continue;
    // The jelly is body 1, the springs are body 4: closed surfaces.
    std::optional<RayEntry> twin;
    int body = -1;
    for (const int b : {1, 4}) {
      const Display& display = w.body(b).display();
      std::vector<Vec3f> x;
      display_now(w.body(b), x);
      for (const Triangle& t : std::span(display.triangles)) {
        const auto corner = [&](int k) -> Vec3 {
          return x[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])].cast<double>();
        };
        const auto e = enter(ray, RoundedSimplex{{corner(0), corner(1), corner(2)}, 3, 0.0});
        if (e && (!twin || e->distance < twin->distance)) twin = e, body = b;
      }
    }
    const auto hit = w.raycast(from, ray.direction, 100.0, [](int b) { return b == 1 || b == 4; });
    ASSERT_EQ(hit.has_value(), twin.has_value()) << i;
    if (!hit) continue;
    ++met;
    EXPECT_EQ(hit->body, body);
    EXPECT_NEAR(hit->distance, twin->distance, 1e-12);
    const auto all = w.raycast(from, ray.direction);
    ASSERT_TRUE(all);
    EXPECT_LE(all->distance, hit->distance);
  }
  EXPECT_GT(met, 40);
}

TEST(Queries, TheFilterLeavesBodiesOut) {
  const World w = row();
  const auto without_ball = [](int b) { return b != 1; };
  EXPECT_EQ(w.raycast(Vec3(0, 0, 5), -Vec3::UnitZ(), 10.0, without_ball)->body, 0);
  EXPECT_EQ(w.closest_point(Vec3(0, 0, 2), 10.0, without_ball)->body, 0);
  EXPECT_EQ(w.overlap_ball(Vec3(0, 0, 0.3), 1.0, without_ball), (std::vector<int>{0}));
  EXPECT_FALSE(w.raycast(Vec3(0, 0, 5), -Vec3::UnitZ(), 10.0, [](int) { return false; }));
}

TEST(Queries, TheySeeEditsAndStatesAtOnceAndChangeNothing) {
  World asked = row(), twin = row();
  const auto top = [&] { return asked.raycast(Vec3(0, 0, 5), -Vec3::UnitZ()); };
  for (int s = 0; s < 5; ++s) {
    top(), asked.closest_point(Vec3(3, 0, 2)), asked.overlap_ball(Vec3(6, 0, 1), 2.0);
    asked.step(), twin.step();
  }
  EXPECT_EQ(asked.hash(), twin.hash());
  const State before = asked.state();
  const double there = top()->distance;
  EXPECT_NEAR(there, 4.0 - asked.q(1)[2] + 0.5, 1e-12);
  asked.move(1, {Mat3::Identity(), Vec3(0, 0, 0.7)});
  EXPECT_NEAR(top()->distance, there - 0.7, 1e-12);
  asked.remove(1);
  EXPECT_EQ(top()->body, 0) << "removed, before any step";
  EXPECT_EQ(asked.add(ball("other", {Vec3(0, 0, 2)}, 0.5, 0.25)), 7);
  EXPECT_EQ(top()->body, 7) << "added, before any step";
  asked.remove(7);
  asked.set_state([&] {
    State s = asked.state();
    std::copy(before.q.begin(), before.q.end(), s.q.begin());
    s.warm_start = before.warm_start;
    return s;
  }());
  EXPECT_EQ(top()->body, 7) << "neither is removed in that state";
  EXPECT_EQ(asked.raycast(Vec3(0, 0, 5), -Vec3::UnitZ(), 10.0, [](int b) { return b != 7; })->distance, there);
}

TEST(Queries, TheSameBitsForAnyNumberOfThreads) {
  const auto answer = [](int threads) {
    const ThreadLimit limit(threads);
    const World w = row();
    std::vector<double> all;
    for (int i = 0; i < 40; ++i) {
      const auto hit = w.raycast(Vec3(0.4 * i, 0.03, 5), Vec3(0.01, 0.02, -1));
      if (hit) all.insert(all.end(), {double(hit->body), hit->distance, hit->normal.x(), hit->point.z()});
    }
    return all;
  };
  EXPECT_EQ(answer(1), answer(2));
}

TEST(Queries, RefuseWhatIsNoPlaceDirectionOrLength) {
  const World w = row();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message([&] { w.raycast(Vec3(nan, 0, 0), Vec3::UnitX()); }),
            "raycast: origin (nan, 0, 0) is not allowed; must be finite");
  EXPECT_NE(message([&] { w.raycast(Vec3::Zero(), Vec3::Zero()); }).find("direction is zero"), std::string::npos);
  EXPECT_NE(message([&] { w.raycast(Vec3::Zero(), Vec3::UnitX(), -1.0); }), "");
  EXPECT_NE(message([&] { w.closest_point(Vec3::Zero(), nan); }), "");
  EXPECT_EQ(message([&] { w.overlap_ball(Vec3::Zero(), -0.5); }),
            "overlap_ball: radius -0.5 is not allowed; must be from 0 [m]");
  EXPECT_NE(message([&] { w.overlap_box({2.0 * Mat3::Identity(), Vec3::Zero()}, Vec3::Ones()); }), "");
  EXPECT_NE(message([&] { w.overlap_box(Pose{}, Vec3(1, -1, 1)); }), "");
  World empty;
  EXPECT_FALSE(empty.raycast(Vec3::Zero(), Vec3::UnitX()));
  EXPECT_FALSE(empty.closest_point(Vec3::Zero()));
}

}  // namespace
}  // namespace brim::testing::queries_test
