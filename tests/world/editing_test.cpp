#include <gtest/gtest.h>

#include "brim/body/articulated/articulated_body.h"
#include "brim/body/grid_fluid/grid_fluid_body.h"
#include "brim/core/error.h"
#include "brim/world/attachment.h"
#include "brim/world/body_motion.h"
#include "brim/world/levels.h"
#include "support/soft_worlds.h"

/// What may be done to a world between its steps, and that a world which was edited goes on as if it had been made so.
namespace brim::testing {
namespace {

WorldOptions told(Response response = Response::Penalty) {
  WorldOptions o = options_at(0.1);
  o.stiffness = 2e5;
  o.response = response;
  return o;
}

void add_soft(World& w) {
  w.add(jelly("jelly", 0.5, Vec3(-0.25, -0.25, 0.0)));
  w.add(sheet("sheet", 0.8, Vec3(0, 0, 0.56)));
  w.add(box("box", {Vec3(0.02, 0.01, 0.78)}, 0.5, 0.3, 300));
  w.add(springs("springs", 0.4, Vec3(0.8, -0.2, 0.0)));
  w.add(rope("rope", Vec3(1.0, -0.5, 0.47), Vec3(1.0, 0.5, 0.48)));
  w.add(blob("fluid", 5, 0.1, Vec3(0.2, -0.3, 0.75)));
}

void add_rigid(World& w) {
  for (int i = 0; i < 4; ++i) w.add(box("box" + std::to_string(i), {Vec3(0.03 * i, 0, 0.25 + 0.5 * i)}, 0.5, 0.5));
  w.add(ball("ball", {Vec3(1.5, 0, 0.3)}, 0.5, 0.3));
}

std::vector<double> copy(std::span<const double> x) { return {x.begin(), x.end()}; }

std::string message(const std::function<void()>& f) {
  try {
    f();
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

/// The same bodies in both, but for `extra`, which a has as number 1.
void expect_equal_but(const World& a, const World& b) {
  for (int i = 0; i < b.body_count(); ++i) {
    const int j = i == 0 ? 0 : i + 1;
    ASSERT_EQ(a.body(j).name(), b.body(i).name());
    ASSERT_EQ(copy(a.q(j)), copy(b.q(i))) << b.body(i).name();
    ASSERT_EQ(copy(a.v(j)), copy(b.v(i))) << b.body(i).name();
  }
}

TEST(Remove, OthersStepBitForBitAsIfTheBodyHadNeverBeen) {
  struct Case {
    Response response;
    void (*add)(World&);
    bool sleep;
  };
  for (const Case& c : {Case{Response::Penalty, add_soft, false}, Case{Response::Constraint, add_soft, false},
                        Case{Response::Constraint, add_rigid, false}, Case{Response::Penalty, add_rigid, false},
                        Case{Response::Constraint, add_rigid, true}}) {
    WorldOptions o = told(c.response);
    o.sleep = c.sleep;
    World a(o), b(o);
    a.add(ground(0.5)), b.add(ground(0.5));
    a.add(jelly("extra", 0.37, Vec3(-0.3, 0.1, 0.2)));
    c.add(a), c.add(b);
    a.remove(1);
    EXPECT_TRUE(a.removed(1));
    EXPECT_EQ(a.body_count(), b.body_count() + 1);
    for (int s = 0; s < 25; ++s) {
      const StepReport ra = a.step(), rb = b.step();
      expect_equal_but(a, b);
      ASSERT_EQ(ra.contacts, rb.contacts);
      ASSERT_EQ(ra.cg_iterations, rb.cg_iterations);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(Remove, InTheMiddleOfContactTheOthersGoOnAsFromTheirStatesAlone) {
  World a(told()), b(told());
  a.add(ground(0.5)), b.add(ground(0.5));
  a.add(box("extra", {Vec3(0.05, 0, 1.1)}, 0.5, 0.3));
  add_soft(a), add_soft(b);
  for (int s = 0; s < 12; ++s) a.step();
  const Vec3 before = a.body(3).linear_momentum(a.v(3));
  a.remove(1);
  EXPECT_EQ(a.body(3).linear_momentum(a.v(3)), before);
  b.step();  // its stiffness is told, nothing else is chosen at the start
  State s;
  s.time = a.state().time, s.step = a.state().step;
  for (int i = 0; i < a.body_count(); ++i) {
    if (i == 1) continue;
    s.q.insert(s.q.end(), a.q(i).begin(), a.q(i).end());
    s.v.insert(s.v.end(), a.v(i).begin(), a.v(i).end());
  }
  b.set_state(s);
  for (int i = 0; i < 15; ++i) {
    a.step(), b.step();
    expect_equal_but(a, b);
    if (HasFatalFailure()) return;
  }
}

TEST(Remove, AnEarlierStateBringsTheBodyBackBitForBit) {
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    World a(told(response)), b(told(response));
    for (World* w : {&a, &b}) w->add(ground(0.5)), add_rigid(*w);
    for (int s = 0; s < 8; ++s) a.step(), b.step();
    const State before = a.state();
    a.remove(2);
    a.remove(4);
    for (int s = 0; s < 8; ++s) a.step();
    EXPECT_GT(a.q(2)[2], 0.5) << "it is kept where it was";
    a.set_state(before);
    EXPECT_FALSE(a.removed(2));
    for (int s = 0; s < 10; ++s) {
      a.step(), b.step();
      ASSERT_EQ(a.hash(), b.hash());
    }
  }
}

TEST(Remove, WhatLayOnItFallsAndWhatSleptThereWakes) {
  WorldOptions o = told(Response::Constraint);
  o.time_step = 1.0 / 120.0;
  o.sleep = true;
  World w(o);
  w.add(ground(0.5));
  w.add(box("lower", {Vec3(0, 0, 0.25)}, 0.5, 0.5));
  w.add(box("upper", {Vec3(0, 0, 0.75)}, 0.5, 0.5));
  for (int s = 0; s < 300 && !w.asleep(2); ++s) w.step();
  ASSERT_TRUE(w.asleep(2));
  w.remove(1);
  EXPECT_FALSE(w.asleep(2));
  for (int s = 0; s < 120; ++s) w.step();
  EXPECT_NEAR(w.q(2)[2], 0.25, 0.02);
  for (int s = 0; s < 300 && !w.asleep(2); ++s) w.step();
  ASSERT_TRUE(w.asleep(2));
  w.remove(0);  // the ground
  EXPECT_FALSE(w.asleep(2));
  for (int s = 0; s < 30; ++s) w.step();
  EXPECT_LT(w.q(2)[2], 0.0);
}

TEST(Remove, WhatHeldToItIsDetachedAndItsForcesEnd) {
  World w(told());
  w.add(box("post", {Vec3(0, 0, 1)}, 0.5, 0.2));
  w.add(box("weight", {Vec3(0, 0, 0.7)}, 0.5, 0.2));
  Attachment a;
  a.name = "pin", a.body = "post", a.point = Vec3(0, 0, 1);
  w.attach(a);
  a.name = "rope", a.to = "weight", a.point = Vec3(0, 0, 0.9), a.to_point = Vec3(0, 0, 0.8);
  w.attach(a);
  for (int s = 0; s < 5; ++s) w.step();
  w.remove(0);
  EXPECT_TRUE(w.detached(0));
  EXPECT_TRUE(w.detached(1));
  const double z = w.q(1)[2];
  for (int s = 0; s < 30; ++s) w.step();
  EXPECT_NEAR(w.q(1)[2], z - 0.5 * 9.81 * 0.25, 0.1);
  a.name = "late", a.to.clear(), a.to_point.reset();
  EXPECT_NE(message([&] { w.attach(a); }).find("\"post\" was removed"), std::string::npos);
}

TEST(Freeze, ABoxCarriesABallAsAnObstacleDoes) {
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    World a(told(response)), b(told(response));
    a.add(box("seat", {Vec3(0, 0, 2)}, 0.5, 0.5));
    b.add(obstacle("seat", make_box(Vec3::Constant(0.5)), 0.5, Vec3(0, 0, 2)));
    for (World* w : {&a, &b})
      w->add(ball("ball", {Vec3(0.11, 0.02, 2.5), Quat::Identity(), Vec3(0.2, 0, 0)}, 0.5, 0.2));
    a.freeze(0);
    EXPECT_TRUE(a.frozen(0));
    const auto seat = copy(a.q(0));
    for (int s = 0; s < 60; ++s) {
      const StepReport r = a.step();
      ASSERT_TRUE(r.ok);
      ASSERT_LT(r.momentum_error, 1e-9);
      b.step();
      EXPECT_EQ(copy(a.q(0)), seat);
      ASSERT_LT((position(a, 1) - position(b, 1)).norm(), 1e-9) << s;  // the same to rounding
    }
    EXPECT_GT(position(a, 1).z(), 2.3) << "it lies on the seat";
  }
}

TEST(Freeze, ItStaysWhereItIsAndGoesOnAtRest) {
  World w(told());
  w.add(ground(0.5));
  add_soft(w);
  for (int s = 0; s < 5; ++s) w.step();
  for (int b = 1; b < w.body_count(); ++b) w.freeze(b);
  const State s = w.state();
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(w.step().ok);
  EXPECT_EQ(w.state().q, s.q);
  for (const double x : w.state().v) ASSERT_EQ(x, 0.0);
  w.freeze(3, false);
  EXPECT_FALSE(w.frozen(3));
  w.freeze(2, false);
  EXPECT_EQ(w.v(3)[2], 0.0);
  w.step();
  EXPECT_LT(w.v(2)[2], 0.0) << "the sheet falls again";
  EXPECT_EQ(copy(w.q(1)),
            std::vector<double>(s.q.begin() + 7, s.q.begin() + 7 + static_cast<std::ptrdiff_t>(w.q(1).size())));
}

TEST(Move, ABodyThatIsMovedIsOneThatWasMadeThere) {
  const Quat turn(Eigen::AngleAxisd(0.4, Vec3(0.2, 0.3, 1).normalized()));
  const Pose by{turn.toRotationMatrix(), Vec3(0.4, -0.3, 0.5)};
  const auto there = [&](const Vec3& x) -> Vec3 { return by.rotation * x + by.translation; };
  World a(told()), b(told());
  a.add(ground(0.5)), b.add(ground(0.5));
  const Vec3 x(0.3, 0.2, 0.6), v(0.1, 0.5, -1), spin(1, 2, 3);
  a.add(box("box", {x, Quat::Identity(), v, spin}, 0.5, 0.3));
  b.add(box("box", {there(x), turn, turn * v, turn * spin}, 0.5, 0.3));
  ClothOptions o;
  o.membrane.young = 500, o.areal_density = 1.0, o.thickness = 0.1;
  TriMesh mesh = shapes::grid(6, 6, 0.8, 0.8);
  a.add(named<ClothBody>("sheet", mesh, o));
  for (Vec3& p : mesh.vertices) p = there(p);
  b.add(named<ClothBody>("sheet", mesh, o));
  a.move(1, by), a.move(2, by);
  for (int s = 0; s < 20; ++s) {
    for (int i = 1; i < 3; ++i)
      for (std::size_t k = 0; k < a.q(i).size(); ++k) ASSERT_NEAR(a.q(i)[k], b.q(i)[k], 1e-9) << s;
    a.step(), b.step();
  }
}

/// A pendulum on a base that is fixed to the world at x, turned by r; it swings into a box.
std::unique_ptr<Body> pendulum(const Vec3& x, const Quat& r) {
  ArticulatedModel m;
  LinkModel l;
  l.name = "bob";
  l.joint.kind = JointKind::Revolute;
  l.joint.position = x, l.joint.rotation = r;
  l.joint.axis = Vec3::UnitY();
  l.joint.start = -0.6;
  l.mass = 5.0, l.center_of_mass = Vec3(0, 0, -0.8), l.inertia = 0.1 * Mat3::Identity();
  LinkShape s;
  s.shape = make_sphere(0.2);
  s.pose.translation = Vec3(0, 0, -0.8);
  s.part.areal_mass = 40.0;
  l.shapes.push_back(s);
  m.links.push_back(l);
  return named<ArticulatedBody>("pendulum", m);
}

std::unique_ptr<Body> pool(const Vec3& origin) {
  GridFluidModel m;
  m.grid.n = {8, 8, 8}, m.grid.dx = 0.1, m.grid.origin = origin;
  m.distance = [origin](const Vec3& x) { return x.z() - origin.z() - 0.45 - 0.2 * (x.x() - origin.x()); };
  return named<GridFluidBody>("pool", m);
}

TEST(Move, AFixedTreeThatIsMovedIsOneThatWasMadeThere) {
  const Quat turn(Eigen::AngleAxisd(0.7, Vec3::UnitZ()));
  const Pose by{turn.toRotationMatrix(), Vec3(0.4, -0.3, 0.1)};
  const auto world = [&](bool moved) {
    World w(told());
    w.add(ground(0.5));
    w.add(moved ? pendulum(by.rotation * Vec3(0, 0, 1) + by.translation, turn)
                : pendulum(Vec3(0, 0, 1), Quat::Identity()));
    w.add(box("box", {Vec3(0.4, -0.3, 0.2), turn}, 0.5, 0.4));
    if (!moved) w.move(1, by);
    return w;
  };
  World a = world(false), b = world(true);
  State middle;
  for (int s = 0; s < 60; ++s) {
    for (int i = 1; i < 3; ++i)
      for (std::size_t k = 0; k < a.q(i).size(); ++k) ASSERT_NEAR(a.q(i)[k], b.q(i)[k], 1e-7) << s;
    if (s == 30) middle = a.state();
    a.step(), b.step();
  }
  EXPECT_GT((position(a, 2) - Vec3(0.4, -0.3, 0.2)).head<2>().norm(), 1e-3) << "the box was hit";
  // Where the base is belongs to the state.
  World again(told());
  again.add(ground(0.5));
  again.add(pendulum(Vec3(0, 0, 1), Quat::Identity()));
  again.add(box("box", {Vec3(0.4, -0.3, 0.2), turn}, 0.5, 0.4));
  const State start = again.state();
  again.set_state(middle);
  for (int s = 30; s < 60; ++s) again.step();
  EXPECT_EQ(again.hash(), a.hash());
  a.set_state(start);
  World plain(told());
  plain.add(ground(0.5));
  plain.add(pendulum(Vec3(0, 0, 1), Quat::Identity()));
  plain.add(box("box", {Vec3(0.4, -0.3, 0.2), turn}, 0.5, 0.4));
  for (int s = 0; s < 10; ++s) a.step(), plain.step();
  EXPECT_EQ(a.hash(), plain.hash()) << "an earlier state takes the base back";
}

TEST(Move, TheBoxOfAGridFluidIsMovedWithWhatIsInIt) {
  const Pose by{Mat3::Identity(), Vec3(1.6, -0.8, 0.8)};
  World a(told()), b(told());
  a.add(pool(Vec3::Zero())), b.add(pool(by.translation));
  a.add(ball("ball", {Vec3(2.0, -0.4, 1.5)}, 0.5, 0.15, 400)),
      b.add(ball("ball", {Vec3(2.0, -0.4, 1.5)}, 0.5, 0.15, 400));
  for (int s = 0; s < 5; ++s) a.step();  // the ball falls, the pool sloshes where it is
  World rest(told());
  rest.add(pool(by.translation));
  const auto depth = [](const World& w) { return dynamic_cast<const GridFluidBody&>(w.body(0)).volume(); };
  EXPECT_NEAR(depth(a), depth(rest), 1e-9);
  a.set_state(b.state());
  a.move(0, by);
  for (int s = 0; s < 20; ++s) {
    for (int i = 0; i < 2; ++i)
      for (std::size_t k = 0; k < a.q(i).size(); ++k) ASSERT_NEAR(a.q(i)[k], b.q(i)[k], 1e-6) << s;
    a.step(), b.step();
  }
  EXPECT_LT(a.v(1)[2], 0.0);
  const Pose turn{Quat(Eigen::AngleAxisd(0.1, Vec3::UnitZ())).toRotationMatrix(), Vec3::Zero()};
  EXPECT_EQ(message([&] { a.move(0, turn); }), "move: 'pool' lies along the axes of the world; it cannot be turned");
}

TEST(Move, IsRefusedWhereSomethingElseSaysWhereTheBodyIs) {
  World w(told());
  ObstacleModel m;
  m.shape = make_sphere(0.2);
  m.keys = {{0.0}, {1.0, Vec3(1, 0, 0)}};
  w.add(named<ObstacleBody>("belt", m));
  w.add(box("box", {Vec3(0, 0, 2)}, 0.5, 0.2));
  w.add(ground(0.5));
  Attachment a;
  a.name = "pin", a.body = "box", a.point = Vec3(0, 0, 2);
  w.attach(a);
  const Pose up{Mat3::Identity(), Vec3(0, 0, 1)};
  EXPECT_EQ(message([&] { w.move(0, up); }), "move: 'belt' follows keyframes; it cannot be moved");
  EXPECT_EQ(message([&] { w.freeze(0); }), "freeze: 'belt' follows keyframes; it cannot be frozen");
  EXPECT_EQ(message([&] { w.move(1, up); }), "move: 'box' is held by 'pin'; detach it first");
  EXPECT_EQ(message([&] {
              w.move(1, {2.0 * Mat3::Identity(), Vec3::Zero()});
            }),
            "move: 'box' must be moved by finite numbers and a rotation");
  EXPECT_EQ(message([&] { w.set_velocity(2, Vec3::UnitX(), Vec3::Zero()); }), "set_velocity: 'ground' is fixed");
  EXPECT_EQ(message([&] { w.remove(7); }), "remove: body 7 is not there; there are 3");
  Material slick;
  slick.friction = -1.0;
  EXPECT_EQ(message([&] { w.set_material(1, slick); }),
            "material 'default' of 'box': friction -1 is not allowed; must be a number from 0");
  slick.friction = 0.0, slick.restitution = 2.0;
  EXPECT_EQ(message([&] { w.set_material(1, slick); }),
            "material 'default' of 'box': restitution 2 is not allowed; must be from 0 to 1");
  EXPECT_EQ(message([&] { w.set_stiffness(0.0); }), "world: stiffness 0 is not allowed; must be a number above 0 [Pa]");
  w.detach(0);
  w.move(1, up);
  EXPECT_EQ(position(w, 1), Vec3(0, 0, 3));
  w.move(2, up);  // the ground
  EXPECT_EQ(position(w, 2), Vec3(0, 0, 1));
  w.freeze(1);
  EXPECT_EQ(message([&] { w.set_velocity(1, Vec3::UnitX(), Vec3::Zero()); }),
            "set_velocity: 'box' is frozen; let it go first");
  w.remove(1);
  EXPECT_EQ(message([&] { w.remove(1); }), "remove: 'box' was removed");
  EXPECT_EQ(message([&] { w.add(box("box", {})); }), "world: two bodies are named 'box'; names must be unique");
}

TEST(SetVelocity, GivesMomentumAndSpinAboutTheCentreOfMass) {
  World w(told());
  w.add(ground(0.5));
  add_soft(w);
  const Vec3 v(1, 2, 3), spin(0.1, -0.2, 0.3);
  for (int b = 1; b < w.body_count(); ++b) {
    const Body& body = w.body(b);
    const Vec3 c = *center_of_mass(body);
    w.set_velocity(b, v, spin);
    EXPECT_LT((body.linear_momentum(w.v(b)) - body.mass() * v).norm(), 1e-9 * body.mass());
    // L about the centre along the spin: positive, and without the motion of the centre.
    EXPECT_GT(spin.dot(body.angular_momentum(w.v(b)) - c.cross(body.mass() * v)), 0.0) << body.name();
    EXPECT_LT((c - middle_of(body)).norm(), 1e-12);
  }
  EXPECT_LT((spin - brim::testing::spin(w, 3)).norm(), 1e-12);
}

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
}  // namespace brim::testing
