#include "brim/world/self_contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "brim/core/parallel.h"
#include "support/soft_worlds.h"

namespace brim::self_contact_test {
namespace {

constexpr double kThickness = 0.1;

ClothOptions cloth(bool touches_itself) {
  ClothOptions o;
  o.membrane.young = 500, o.bending = 1e-3, o.areal_density = 1.0, o.thickness = kThickness;
  o.stiffness_damping = 0.02, o.self_contact = touches_itself;
  return o;
}

WorldOptions options(const Vec3& gravity = Vec3(0.0, 0.0, -9.81)) {
  WorldOptions o = testing::options_at(0.5 * kThickness);
  o.environment.gravity = gravity;
  return o;
}

/// A strip of 3 x 0.4 m, folded over at rest: two flaps with a gap between their middles, and a half circle.
TriMesh folded(double gap) {
  TriMesh mesh = shapes::grid(60, 8, 3.0, 0.4);
  for (Vec3& x : mesh.vertices) x.x() += 1.5;
  const double r = 0.5 * gap, flap = 0.5 * (3.0 - std::numbers::pi * r);
  for (Vec3& x : mesh.vertices) {
    const double s = x.x() - flap, a = s / r;
    if (s <= 0.0)
      x = Vec3(x.x(), x.y(), 0.0);
    else if (a < std::numbers::pi)
      x = Vec3(flap + r * std::sin(a), x.y(), r * (1.0 - std::cos(a)));
    else
      x = Vec3(2.0 * flap + std::numbers::pi * r - x.x(), x.y(), gap);
  }
  return mesh;
}

/// A strip that falls on its edge, on the ground.
World fold() {
  World w(options());
  w.add(testing::ground(0.5));
  TriMesh mesh = shapes::grid(30, 6, 1.5, 0.3);
  for (Vec3& x : mesh.vertices) x = Vec3(0.05 * std::sin(4.0 * x.x()), x.y(), 0.85 + x.x());
  w.add(testing::named<ClothBody>("strip", mesh, cloth(true)));
  return w;
}

std::size_t contacts_with_itself(const World& w, int part) {
  std::size_t n = 0;
  for (const ContactSample& c : w.contacts()) n += c.part_a == part && c.part_b == part;
  return n;
}

TEST(SelfContact, TwoFlapsMeetAsTwoSheetsDo) {
  const double gap = 0.8 * kThickness;
  WorldOptions o = options(Vec3::Zero());
  o.stiffness = 2000.0;  // chosen, a body would meet itself more stiffly
  World one(o);
  const TriMesh mesh = folded(gap);
  one.add(testing::named<ClothBody>("strip", mesh, cloth(true)));
  // The flaps alone, as sheets of their own.
  World two(o);
  for (const bool upper : {false, true}) {
    TriMesh flap;
    std::vector<std::int32_t> number(mesh.vertices.size(), -1);
    for (const Triangle& t : mesh.triangles) {
      bool own = true;
      for (const std::int32_t i : t) own = own && mesh.vertices[i].z() == (upper ? gap : 0.0);
      if (!own) continue;
      Triangle mine = t;
      for (std::int32_t& i : mine) {
        if (number[i] < 0)
          number[i] = static_cast<std::int32_t>(flap.vertices.size()), flap.vertices.push_back(mesh.vertices[i]);
        i = number[i];
      }
      flap.triangles.push_back(mine);
    }
    two.add(testing::named<ClothBody>(upper ? "upper" : "lower", flap, cloth(false)));
  }
  ASSERT_TRUE(one.step().ok);
  ASSERT_TRUE(two.step().ok);
  // Away from the fold, where the strip has what the flaps lack.
  struct Found {
    std::vector<std::array<float, 4>> places;  // [m], and overlap [voxels]
    double force = 0.0;                        // [N] of all of them
  };
  const auto found = [](const World& w) {
    Found f;
    for (const ContactSample& c : w.contacts()) {
      if (c.position.x() >= 1.0f) continue;
      f.places.push_back({c.position.x(), c.position.y(), c.position.z(), c.overlap});
      f.force += std::abs(c.force.z());
    }
    std::ranges::sort(f.places);
    return f;
  };
  const Found own = found(one), sheets = found(two);
  ASSERT_GT(sheets.places.size(), 100u);
  ASSERT_EQ(own.places.size(), sheets.places.size());
  for (std::size_t c = 0; c < own.places.size(); ++c)
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(own.places[c][k], sheets.places[c][k], 1e-5);
  EXPECT_NEAR(own.force, sheets.force, 0.01 * sheets.force);
}

TEST(SelfContact, WhatDoesNotComeBackToItselfMovesAsWithout) {
  std::vector<double> states[2];
  for (const bool touches : {false, true}) {
    World w(options());
    w.add(testing::ground(0.5));
    w.add(testing::ball("ball", {Vec3(0.0, 0.0, 0.3)}, 0.5, 0.3));
    TriMesh mesh = shapes::grid(24, 24, 1.2, 1.2);
    for (Vec3& x : mesh.vertices) x.z() += 0.8;
    w.add(testing::named<ClothBody>("sheet", mesh, cloth(touches)));
    for (int s = 0; s < 12; ++s) ASSERT_TRUE(w.step().ok);
    states[touches].assign(w.q(2).begin(), w.q(2).end());
  }
  EXPECT_EQ(states[0], states[1]);
}

TEST(SelfContact, CreasesOfCoarseCellsCostNothing) {
  // A zigzag of cells wider than three thicknesses that turns by 130° at each line of the grid: nothing touches, though
  // neighbours are not flat and their boxes overlap.
  World w(options(Vec3::Zero()));
  const double cell = 3.3 * kThickness, slope = 65.0 / 180.0 * std::numbers::pi;
  TriMesh mesh = shapes::grid(10, 6, 10 * cell, 6 * cell);
  for (Vec3& x : mesh.vertices) {
    const double s = x.x() / cell, up = std::abs(s - 2.0 * std::round(0.5 * s));
    x = Vec3(std::cos(slope) * x.x(), x.y(), std::sin(slope) * cell * up);
  }
  w.add(testing::named<ClothBody>("sheet", mesh, cloth(true)));
  const StepReport r = w.step();
  EXPECT_TRUE(r.ok);
  EXPECT_EQ(r.voxels, 0);
}

TEST(SelfContact, MomentumOfWhatFoldsInFlightStays) {
  World w(options(Vec3::Zero()));
  TriMesh mesh = shapes::grid(24, 6, 1.2, 0.3);
  w.add(testing::named<ClothBody>("strip", mesh, cloth(true)));
  State s = w.state();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    // Both ends come up and inwards.
    const double x = mesh.vertices[i].x();
    s.v[3 * i] = -4.0 * x, s.v[3 * i + 1] = 0.3, s.v[3 * i + 2] = 16.0 * x * x;
  }
  w.set_state(s);
  const Vec3 p = w.body(0).linear_momentum(w.v(0)), l = w.body(0).angular_momentum(w.v(0));
  std::size_t most = 0;
  double deepest = 0.0;
  for (int k = 0; k < 60; ++k) {
    const StepReport r = w.step();
    ASSERT_TRUE(r.ok);
    most = std::max(most, contacts_with_itself(w, 0));
    deepest = std::max(deepest, r.worst_overlap);
    EXPECT_LT((w.body(0).linear_momentum(w.v(0)) - p).norm(), 1e-10 * p.norm());
    EXPECT_LT((w.body(0).angular_momentum(w.v(0)) - l).norm(), 1e-10 * p.norm());
  }
  EXPECT_GT(most, 20u) << "it never met itself: nothing was tested";
  EXPECT_LT(deepest, 1.5);
}

TEST(SelfContact, AFlapLiesDownOnTheOther) {
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    WorldOptions o = options();
    o.response = response;
    World w(o);
    w.add(testing::ground(0.5));
    TriMesh mesh = folded(3.0 * kThickness);
    for (Vec3& x : mesh.vertices) x.z() += 0.6 * kThickness;
    const std::size_t end = 60;  // the upper flap's, over the first vertex
    ASSERT_NEAR(mesh.vertices[end].x(), mesh.vertices[0].x(), 1e-12);
    w.add(testing::named<ClothBody>("strip", mesh, cloth(true)));
    double deepest = 0.0;
    for (int s = 0; s < 120; ++s) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok);
      if (s >= 90) deepest = std::max(deepest, r.worst_overlap);
    }
    EXPECT_GT(contacts_with_itself(w, 1), 100u);
    EXPECT_LT(deepest, 0.3);
    EXPECT_NEAR(w.q(1)[3 * end + 2] - w.q(1)[2], kThickness, 0.2 * kThickness);
  }
}

TEST(SelfContact, ARopeCoilsUpOnItself) {
  double highest[2] = {};
  for (const bool touches : {false, true}) {
    World w(options());
    w.add(testing::ground(0.5));
    std::vector<Vec3> x;
    for (int i = 0; i <= 60; ++i) x.emplace_back(0.01 * i / 60.0, 0.0, 0.1 + 4.0 * i / 60.0);
    RodOptions o;
    o.radius = 0.05, o.linear_density = 1.0, o.stretch = 5e3, o.bending = 0.01, o.stiffness_damping = 0.01;
    o.self_contact = touches;
    w.add(testing::named<RodBody>("rope", x, o));
    for (int s = 0; s < 300; ++s) ASSERT_TRUE(w.step().ok);
    for (std::size_t i = 2; i < w.q(1).size(); i += 3) highest[touches] = std::max(highest[touches], w.q(1)[i]);
  }
  EXPECT_LT(highest[0], 0.1) << "it lies in itself";
  EXPECT_GT(highest[1], 0.12) << "one turn on another is three radii high";
}

TEST(SelfContact, SameBitsForAnyNumberOfThreads) {
  std::vector<std::uint64_t> one;
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    World w = fold();
    for (int s = 0; s < 60; ++s) {
      ASSERT_TRUE(w.step().ok);
      if (threads == 1) one.push_back(w.hash());
      ASSERT_EQ(w.hash(), one[static_cast<std::size_t>(s)]) << threads << " threads, step " << s;
    }
  }
}

TEST(SelfContact, ARuleOfABodyWithItselfCounts) {
  World w = fold();
  w.set_touch({"strip", "strip", false});
  for (int s = 0; s < 120; ++s) {
    ASSERT_TRUE(w.step().ok);
    ASSERT_EQ(contacts_with_itself(w, 1), 0u);
  }
}

}  // namespace
}  // namespace brim::self_contact_test
