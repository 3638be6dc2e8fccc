#include "brim/world/load_groups.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "brim/core/parallel.h"
#include "support/soft_worlds.h"

/// Which bodies press on a contact: by hand, over random graphs against brute force, and what follows for worlds.
namespace brim::load_groups_test {
namespace {

using testing::ball;
using testing::box;
using testing::ground;
using testing::options_at;

/// Body b is a hundred times as heavy as the one before it.
double load(int b) { return std::pow(100.0, b); }
/// What one that just rests on others counts with.
double resting(int b) { return 10.0 * load(b); }

/// Bodies in the order of their loads, of which the first is fixed, and pairs that touch.
struct Graph {
  std::vector<std::unique_ptr<Body>> bodies;
  std::vector<WorldPart> parts;
  ContactStage stage;
  LoadGroups groups;

  explicit Graph(int movable, std::unique_ptr<Body> last = nullptr) {
    bodies.push_back(ground(0.5));
    for (int i = 1; i <= movable; ++i) bodies.push_back(box("box" + std::to_string(i), {}));
    if (last) bodies.push_back(std::move(last));
    std::vector<Loads> loads;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      parts.push_back({bodies[b].get(), static_cast<int>(b), 0, 0.1, bodies[b]->part(0)});
      const double p = load(static_cast<int>(b));
      loads.push_back(b == 0 ? Loads{} : Loads{p, 2.0 * p, 3.0 * p});
    }
    groups.start(parts, loads);
  }
  void touch(int a, int b) {
    ContactPair pair;
    pair.part_a = a, pair.part_b = b, pair.end = 1;
    stage.contacts().pairs.push_back(pair);
  }
  double between(int a, int b) {
    groups.find(parts, stage);
    const Loads& l = groups.between(parts[a], parts[b]);
    EXPECT_EQ(l.areal_mass, 2.0 * l.pressure);
    EXPECT_EQ(l.impact_energy, 3.0 * l.pressure);
    return l.pressure;
  }
};

TEST(LoadGroups, WhatStandsBesideAStackCarriesItselfAndEachContactWhatRestsOnIt) {
  Graph g(4);
  g.touch(0, 1);  // beside
  g.touch(0, 4), g.touch(2, 4), g.touch(2, 3);
  EXPECT_EQ(g.between(0, 1), load(1));
  EXPECT_EQ(g.between(0, 4), load(4));
  EXPECT_EQ(g.between(2, 4), resting(3)) << "of 2 and of 3 above it, not of 4 below";
  EXPECT_EQ(g.between(2, 3), resting(3));
}

TEST(LoadGroups, WhatLiesUnderTheHeaviestCarriesIt) {
  Graph g(3);
  g.touch(0, 1), g.touch(1, 2), g.touch(2, 3);
  EXPECT_EQ(g.between(0, 1), load(3));
  EXPECT_EQ(g.between(1, 2), load(3));
  EXPECT_EQ(g.between(2, 3), load(3));
}

TEST(LoadGroups, WhatIsHeldElsewhereMayBePressedByAllThatTouchesIt) {
  Graph g(2);
  g.touch(0, 1), g.touch(1, 2);
  EXPECT_EQ(g.between(0, 1), load(2));
  g.touch(0, 2);
  EXPECT_EQ(g.between(1, 2), load(2)) << "between a heavy one and the wall";
  Graph light_on_heavy(2);
  light_on_heavy.touch(0, 2), light_on_heavy.touch(1, 2);
  EXPECT_EQ(light_on_heavy.between(1, 2), resting(1));
  light_on_heavy.touch(0, 1);
  EXPECT_EQ(light_on_heavy.between(1, 2), load(2));
}

TEST(LoadGroups, TwoPartsOfOneBodyMaySqueezeWhatIsBetweenThem) {
  Graph g(2);
  g.parts.push_back(g.parts[2]);
  g.parts.back().index = 1;  // another finger
  g.touch(0, 2), g.touch(1, 2);
  EXPECT_EQ(g.between(1, 2), resting(1));
  g.touch(1, 3);
  EXPECT_EQ(g.between(1, 2), load(2));
}

TEST(LoadGroups, NodesThatAreFixedHoldASheet) {
  const auto pinned = [](bool pin) {
    ClothOptions o;
    o.thickness = 0.1;
    if (pin) o.fixed = {0};
    return testing::named<ClothBody>("sheet", shapes::grid(2, 2, 1.0, 1.0), o);
  };
  for (const bool pin : {false, true}) {
    Graph g(1, pinned(pin));  // it lies on a heavy box
    g.groups.start(g.parts, std::vector<Loads>{{}, {load(3)}, {load(1)}});
    g.touch(0, 1), g.touch(1, 2);
    g.groups.find(g.parts, g.stage);
    EXPECT_EQ(g.groups.between(g.parts[1], g.parts[2]).pressure, pin ? load(3) : resting(1));
  }
}

TEST(LoadGroups, WhatTouchesNothingFixedIsAsHeavyAsItsHeaviest) {
  Graph g(3);
  g.touch(1, 2), g.touch(2, 3);
  EXPECT_EQ(g.between(1, 2), load(3)) << "nothing says which rests on which";
}

TEST(LoadGroups, InAStackOfAFewEqualBoxesAllContactsCarryTheWhole) {
  Graph g(5);
  std::vector<Loads> loads(g.parts.size());
  for (std::size_t b = 1; b < loads.size(); ++b) loads[b].pressure = 6.0 - static_cast<double>(b);  // with those above
  g.groups.start(g.parts, loads);
  for (int b = 0; b < 5; ++b) g.touch(b, b + 1);
  g.groups.find(g.parts, g.stage);
  for (int b = 0; b < 5; ++b) EXPECT_EQ(g.groups.between(g.parts[b], g.parts[b + 1]).pressure, 5.0) << b;
}

/// The heaviest that `from` reaches, and whether it reaches the ground, without the contacts of two bodies.
std::pair<int, bool> side(const std::vector<std::pair<int, int>>& contacts, int from, std::pair<int, int> without) {
  std::vector<int> found = {from};
  bool on_ground = false;
  for (std::size_t i = 0; i < found.size(); ++i)
    for (const auto& [a, b] : contacts) {
      if (std::pair(a, b) == without || (a != found[i] && b != found[i])) continue;
      const int to = a == found[i] ? b : a;
      if (to == 0) on_ground = true;
      if (to != 0 && std::ranges::find(found, to) == found.end()) found.push_back(to);
    }
  return {*std::ranges::max_element(found), on_ground};
}

TEST(LoadGroups, OverRandomContactsAsBruteForceSays) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const int n = 2 + static_cast<int>(random() % 8);
    Graph g(n);
    std::vector<std::pair<int, int>> contacts;
    for (int a = 0; a < n; ++a)
      for (int b = a + 1; b <= n; ++b)
        if (random() % 100 < 25) contacts.emplace_back(a, b), g.touch(a, b);
    for (const auto& [a, b] : contacts) {
      // The least of what any contact between here and the ground has behind it.
      double least = load(side(contacts, b, {-1, -1}).first);
      if (side(contacts, b, {-1, -1}).second)
        for (const auto& cut : contacts) {
          if (cut.first == 0) continue;
          for (const int behind : {cut.first, cut.second}) {
            const auto [heaviest, on_ground] = side(contacts, behind, cut);
            const bool here =
                std::pair(a, b) == cut || (a != 0 && side(contacts, a, cut) == std::pair(heaviest, false));
            if (!on_ground && here) least = std::min(least, resting(heaviest));
          }
        }
      EXPECT_EQ(g.between(a, b), least) << a << " and " << b;
    }
  }
}

// ---- worlds --------------------------------------------------------------------------------------------------------

/// Overlap of the last pair of a body with the ground (body 0), [voxels].
double overlap_on_ground(World& w, int body, int steps) {
  double overlap = 0.0;
  for (int s = 0; s < steps; ++s)
    for (const StepReport r = w.step(); const PairReport& p : r.pairs)
      if (p.part_a == 0 && p.part_b == body) overlap = p.worst_overlap;
  return overlap;
}

TEST(LoadGroups, ALightBoxSinksInAsFarWithAHeavyOneElsewhereAsWithout) {
  const auto overlap = [](double heavy) {
    World w(options_at(0.05));
    w.add(ground(0.5));
    w.add(box("light", {Vec3(0, 0, 0.1)}, 0.5, 0.2, 10.0));
    if (heavy > 0.0) w.add(box("heavy", {Vec3(2, 0, 0.25)}, 0.5, 0.5, heavy));
    return overlap_on_ground(w, 1, 60);
  };
  const double alone = overlap(0.0);
  EXPECT_GT(alone, 0.0);
  // Of 5e-5 voxels the distances, in single precision, tell a fiftieth.
  EXPECT_NEAR(overlap(1e3), alone, 0.05 * alone);
  EXPECT_NEAR(overlap(1e6), alone, 0.05 * alone);
}

TEST(LoadGroups, AClothThatFallsBesideAHeavyBallIsNotThrown) {
  WorldOptions o = options_at(0.05);
  o.time_step = 0.01;
  World w(o);
  w.add(ball("heavy", {Vec3(0, 0, 0.12)}, 0.5, 0.1, 1e5));
  w.add(ground(0.5));
  TriMesh mesh = shapes::grid(8, 8, 0.3, 0.3);
  for (Vec3& x : mesh.vertices) x += Vec3(1, 0, 0.1);
  ClothOptions c;
  c.areal_density = 0.12, c.thickness = 0.05;
  w.add(testing::named<ClothBody>("cloth", mesh, c));
  double fastest = 0.0;
  for (int s = 0; s < 100; ++s) fastest = std::max(fastest, w.step().max_speed);
  EXPECT_LT(fastest, 1.5) << "it falls by 0.05 m, and was thrown at hundreds of m/s";
}

TEST(LoadGroups, ALightBoxUnderAHeavyOneCarriesIt) {
  for (const double z : {0.8, 2.0}) {  // side by side with its column at the start, or in it
    World w(options_at(0.05));
    w.add(ground(0.5));
    w.add(box("light", {Vec3(0, 0, 0.25)}, 0.5, 0.5, 10.0));
    w.add(box("heavy", {Vec3(0.02, 0, z)}, 0.5, 0.5, 1e4));
    testing::run(w, 1.0);
    EXPECT_LT(testing::run(w, 0.5), 0.02) << "[voxels] from z = " << z;
    EXPECT_NEAR(testing::position(w, 2).z(), 0.75, 0.002);
  }
}

/// A heavy box that slides over the edge of a ledge and falls on a light one: groups come and go.
World ledge() {
  World w(options_at(0.05));
  w.add(ground(0.5));
  w.add(box("ledge", {Vec3(0, 0, 0.25)}, 0.1, 0.5));
  w.add(box("heavy", {Vec3(0, 0, 0.75), Quat::Identity(), Vec3(2.5, 0, 0)}, 0.1, 0.5, 1e4));
  w.add(box("light", {Vec3(0.8, 0, 0.1)}, 0.5, 0.2, 50.0));
  return w;
}

TEST(LoadGroups, AResumedRunHasTheSameBitsWhereGroupsComeAndGo) {
  World straight = ledge();
  for (int s = 0; s < 60; ++s) {
    if (s % 15 == 0) {
      World resumed = ledge();
      resumed.set_state(straight.state());
      for (int k = 0; k < 15; ++k) resumed.step(), straight.step();
      ASSERT_EQ(resumed.state().q, straight.state().q) << "from step " << s;
      ASSERT_EQ(resumed.state().v, straight.state().v);
    }
  }
}

TEST(LoadGroups, SameBitsForAnyNumberOfThreads) {
  const auto end = [](int threads) {
    const ThreadLimit limit(threads);
    World w = ledge();
    testing::run(w, 1.0);
    return w.state().q;
  };
  EXPECT_EQ(end(1), end(2));
}

}  // namespace
}  // namespace brim::load_groups_test
