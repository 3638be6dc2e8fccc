#include "brim/world/arc.h"

#include <gtest/gtest.h>

#include "support/soft_worlds.h"

/// Arcs of rigid bodies within a sub-step.
namespace brim::arc_test {
namespace {

constexpr double kStep = 0.02;

RigidModel brick() {
  RigidModel m;
  m.shape = make_box(Vec3(1, 0.6, 0.5));
  m.mass = 2.0;
  m.inertia = Vec3(0.1, 0.2, 0.25).asDiagonal();
  m.position = Vec3(1, -2, 3);
  m.rotation = rotation_from_vector(Vec3(0.3, -0.2, 0.5));
  m.velocity = Vec3(1, 2, -3);
  m.angular_velocity = Vec3(4, -6, 5);
  return m;
}

struct Moving {
  explicit Moving(const RigidModel& model) : body(model), q(body.q_size()), v(body.v_size()) {
    body.initial_state(q, v);
    body.update(0.0, q, v);
  }
  RigidBody body;
  std::vector<double> q, v;
};

TEST(Arc, BendsByWhatABodysOwnMotionAddsToAStraightWay) {
  const Moving m(brick());
  const Arc arc(m.body, m.q, m.v, kStep);
  std::vector<double> end = m.q;
  m.body.advance(kStep, end, m.v);
  const auto rotation = [](const std::vector<double>& q) { return Quat(q[3], q[4], q[5], q[6]); };
  const Vec3 local(0.4, -0.3, 0.7), c(m.q[0], m.q[1], m.q[2]), r = rotation(m.q) * local;
  const Vec3 straight = kStep * (Vec3(1, 2, -3) + Vec3(4, -6, 5).cross(r));
  const Vec3 there = Vec3(end[0], end[1], end[2]) + rotation(end) * local;
  EXPECT_LT((arc.bend(c + r) - (there - (c + r) - straight)).norm(), 1e-14);
  EXPECT_LT((arc.turned(rotation(m.q) * local) - rotation(end) * local).norm(), 1e-14);
  EXPECT_GT(arc.bend(c + r).norm(), 1e-3);
}

TEST(Arc, IsThatOfACircleForASteadySpin) {
  RigidModel model = brick();
  model.inertia = 0.2 * Mat3::Identity();
  model.angular_velocity = Vec3(0, 0, 10);
  const Moving m(model);
  const Arc arc(m.body, m.q, m.v, kStep);
  const double r = 0.5, angle = 10 * kStep;
  const Vec3 bend = arc.bend(model.position + Vec3(r, 0, 0));
  EXPECT_LT((bend - r * Vec3(std::cos(angle) - 1.0, std::sin(angle) - angle, 0)).norm(), 1e-13);
  EXPECT_LT(arc.bend(model.position + Vec3(0, 0, r)).norm(), 1e-14);  // on the axis
}

TEST(Arc, OtherBodiesMoveStraight) {
  const Arc none;
  EXPECT_EQ(none.bend(Vec3(1, 2, 3)), Vec3::Zero());
  EXPECT_EQ(none.turned(Vec3::UnitX()), Vec3::UnitX());
  const std::unique_ptr<Body> soft = testing::jelly("soft", 0.5, Vec3::Zero());
  std::vector<double> q(soft->q_size()), v(soft->v_size(), 1.0);
  soft->initial_state(q, v);
  EXPECT_EQ(Arc(*soft, q, v, kStep).bend(Vec3(1, 2, 3)), Vec3::Zero());
}

}  // namespace
}  // namespace brim::arc_test
