#include <gtest/gtest.h>

#include "brim/world/attachment.h"
#include "brim/world/levels.h"
#include "support/edited_worlds.h"

/// What may be done to a world between its steps, and that a world which was edited goes on as if it had been made so.
namespace brim::testing::editing_test {
namespace {

TEST(Materials, AnEditBeforeTheFirstStepMakesTheWorldThatWasMadeSo) {
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    const auto make = [&](double mu, const Vec3& gravity) {
      WorldOptions o = told(response);
      o.environment.gravity = gravity;
      auto w = std::make_unique<World>(o);
      w->add(ground(mu, Vec3(0.2, 0, 1).normalized()));
      w->add(box("box", {Vec3(0.05, 0, 0.27), Quat::FromTwoVectors(Vec3(0, 0, 1), Vec3(0.2, 0, 1))}, mu, 0.5));
      return w;
    };
    const auto a = make(0.5, Vec3(0, 0, -9.81)), b = make(0.1, Vec3(0, 1, -5));
    Material m;
    m.friction = 0.1;
    a->set_material(0, m), a->set_material(1, m);
    a->set_gravity(Vec3(0, 1, -5));
    EXPECT_EQ(a->material(1).friction, 0.1);
    for (int s = 0; s < 20; ++s) {
      a->step(), b->step();
      ASSERT_EQ(copy(a->q(1)), copy(b->q(1)));
    }
  }
}

TEST(Materials, OfAPairAreLookedUpByTheNamesThatBodiesHaveNow) {
  World w(told());
  w.add(ground(0.9, Vec3(0.3, 0, 1).normalized()));
  w.add(box("box", {Vec3(0.075, 0, 0.26), Quat::FromTwoVectors(Vec3(0, 0, 1), Vec3(0.3, 0, 1))}, 0.9, 0.5));
  for (int s = 0; s < 20; ++s) w.step();
  EXPECT_LT(velocity(w, 1).norm(), 0.05) << "held; a free slide would have come to 0.9 m/s";
  Material ice = w.material(1);
  ice.name = "ice";
  w.set_material(1, ice);
  PairMaterial slick;
  slick.friction = 0.0;
  w.set_pair_material("ice", "default", slick);
  for (int s = 0; s < 20; ++s) w.step();
  EXPECT_NEAR(velocity(w, 1).norm(), 0.94, 0.05) << "g sin(16.7 degrees) for a third of a second";
}

TEST(Editing, AResumedRunHasTheBitsOfTheOneThatWasNotInterrupted) {
  for (const bool sleep : {false, true})
    for (const Response response : {Response::Penalty, Response::Constraint}) {
      const auto make = [&] {
        WorldOptions o = options_at(0.1);  // with a stiffness chosen from the loads
        o.response = response;
        o.sleep = sleep;
        auto w = std::make_unique<World>(o);
        w->add(ground(0.5));
        add_rigid(*w);
        w->add(sheet("sheet", 0.8, Vec3(0, 0, 2.2)));
        Attachment a;
        a.name = "pin", a.body = "box3", a.to = "box2", a.point = Vec3(0.06, 0, 1.5);
        w->attach(a);
        return w;
      };
      const auto a = make();
      const auto edit = [](World& w, int s) {
        Material m;
        m.name = "felt", m.friction = 0.05;
        if (s == 3) w.freeze(2);
        if (s == 6) w.set_gravity(Vec3(0.5, 0, -8));
        if (s == 9) w.set_material(1, m);
        if (s == 12) w.remove(1);
        if (s == 15) w.set_touch({"ball", "ground", false});
        if (s == 18) w.freeze(2, false), w.remove(4);
        if (s == 21) w.set_stiffness(1e5);
        if (s == 24) w.move(3, {Mat3::Identity(), Vec3(0, 0, 0.3)}), w.set_velocity(3, Vec3(0, 1, 0), Vec3(0, 0, 1));
      };
      for (int s = 0; s < 28; ++s) {
        edit(*a, s);
        const auto b = make();
        b->set_state(a->state());
        ASSERT_EQ(a->hash(), b->hash());
        const StepReport ra = a->step(), rb = b->step();
        ASSERT_TRUE(ra.ok);
        ASSERT_EQ(a->hash(), b->hash()) << "after the edit of step " << s << (sleep ? ", sleep" : "");
        ASSERT_EQ(ra.stiffness, rb.stiffness);
        b->step();
      }
      EXPECT_TRUE(a->detached(0));
    }
}

TEST(Editing, LevelsAndLinksThatBrokeAreResumedTogether) {
  const auto make = [] {
    auto w = std::make_unique<World>(told(Response::Constraint));
    w->add(ground(0.5));
    add_rigid(*w);
    Attachment a;
    a.name = "pin", a.body = "ball", a.point = Vec3(1.5, 0, 0.3);
    w->attach(a);
    return w;
  };
  for (const bool levels : {false, true}) {
    const auto a = make(), b = make();
    LevelOptions coarse;
    coarse.bodies["box1"] = 1;
    if (levels) set_levels(*a, coarse);
    a->detach(0);
    for (int s = 0; s < 5; ++s) a->step();
    b->set_state(a->state());
    EXPECT_TRUE(b->detached(0)) << "rows in memory behind it must not hide it";
    for (int s = 0; s < 5; ++s) {
      a->step(), b->step();
      ASSERT_EQ(a->hash(), b->hash());
    }
  }
}

TEST(Schedule, EachEditHappensOnceAtTheStepThatBeginsThen) {
  const auto make = [](int& calls) {
    auto w = std::make_unique<World>(told());
    w->add(box("box", {Vec3(0, 0, 2)}, 0.5, 0.2));
    w->add(ball("ball", {Vec3(1, 0, 2)}, 0.5, 0.2));
    w->schedule(0.1, [&](World& world) { world.remove(1), ++calls; });
    w->schedule(0.0, [&](World& world) { world.freeze(0), ++calls; });
    w->schedule(0.205, [&](World& world) { world.freeze(0, false), ++calls; });
    w->schedule(0.3, [](World& world) { world.remove(1); });
    return w;
  };
  int calls = 0, later = 0;
  const auto a = make(calls);
  std::vector<State> states;
  std::size_t refused = 0;
  for (int s = 0; s < 24; ++s) {
    states.push_back(a->state());
    const StepReport r = a->step();
    for (const Warning& w : r.warnings) refused += w.code == "edit_refused" ? 1 : 0;
    EXPECT_EQ(a->removed(1), s >= 6) << "at 0.1 s";
    EXPECT_EQ(a->q(0)[2] < 2.0, s >= 13) << "let go by the first step that begins after 0.205 s";
  }
  EXPECT_EQ(calls, 3);
  EXPECT_EQ(refused, 1u);
  for (std::size_t s = 0; s < states.size(); ++s) {
    const auto b = make(later);
    b->set_state(states[s]);
    while (b->state().step < a->state().step) b->step();
    ASSERT_EQ(a->hash(), b->hash()) << "from step " << s;
  }
}

}  // namespace
}  // namespace brim::testing::editing_test
