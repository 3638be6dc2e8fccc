#include <gtest/gtest.h>

#include "brim/body/articulated/articulated_body.h"
#include "brim/body/grid_fluid/grid_fluid_body.h"
#include "brim/world/attachment.h"
#include "brim/world/body_motion.h"
#include "support/edited_worlds.h"

/// Bodies that are frozen, moved and pushed between steps.
namespace brim::testing::moving_test {
namespace {

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
  // Until they touch: of a sheet that comes down, rounding decides which corner bends first.
  int steps = 0;
  for (bool touch = false; !touch; ++steps) {
    ASSERT_LT(steps, 60);
    for (int i = 1; i < 3; ++i)
      for (std::size_t k = 0; k < a.q(i).size(); ++k) ASSERT_NEAR(a.q(i)[k], b.q(i)[k], 1e-12) << steps;
    const auto met = a.step().contacts;
    EXPECT_EQ(met, b.step().contacts);
    touch = met > 0;
  }
  EXPECT_GT(steps, 10);
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
  EXPECT_EQ(message([&] { w.set_target(1, Pose{}); }),
            "set_target: 'box' (rigid) moves by forces; obstacles are driven");
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
  EXPECT_EQ(message([&] { w.add(box("box", {})); }),
            "world: 'box' is the name of a removed body, for which it stays reserved; use another");
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

}  // namespace
}  // namespace brim::testing::moving_test
