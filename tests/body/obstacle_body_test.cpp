#include "brim/body/obstacle/obstacle_body.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/math/rotation.h"

namespace brim::obstacle_body_test {
namespace {

ObstacleModel animated() {
  ObstacleModel m;
  m.shape = make_box(Vec3(1, 2, 3));
  m.keys = {{0.0, Vec3(0, 0, 0), Quat::Identity()},
            {0.5, Vec3(1, 0, 0), rotation_from_vector(Vec3(0, 0, 1.2))},
            {1.25, Vec3(1, 2, -1), rotation_from_vector(Vec3(0.4, 0, 1.2))}};
  return m;
}

struct Motion {
  ObstacleBody body;
  std::vector<double> q, v;
  double time = 0.0;

  explicit Motion(const ObstacleModel& m) : body(m), q(7), v(6) { body.initial_state(q, v); }
  void step(double dt) {
    body.prescribe(time, dt, q, v);
    body.update(time, q, v);
    body.advance(dt, q, v);
    time += dt;
  }
  Vec3 position() const { return Vec3(q[0], q[1], q[2]); }
  Quat rotation() const { return Quat(q[3], q[4], q[5], q[6]); }
};

TEST(ObstacleBody, ArrivesAtItsKeysWhenStepsMeetTheirTimes) {
  const ObstacleModel m = animated();
  for (const double dt : {0.25, 0.05, 0.01}) {
    Motion o(m);
    for (const PoseKey& key : m.keys) {
      while (o.time < key.time - 1e-9) o.step(dt);
      EXPECT_LT((o.position() - key.position).norm(), 1e-12);
      EXPECT_LT(o.rotation().angularDistance(key.rotation), 1e-7);
    }
  }
}

TEST(ObstacleBody, VelocityIsThatOfTheMotionBetweenKeys) {
  Motion o(animated());
  o.step(0.1);
  EXPECT_LT((Vec3(o.v[0], o.v[1], o.v[2]) - Vec3(2, 0, 0)).norm(), 1e-12);
  EXPECT_LT((Vec3(o.v[3], o.v[4], o.v[5]) - Vec3(0, 0, 2.4)).norm(), 1e-12);
}

TEST(ObstacleBody, IsHeldAfterTheLastKey) {
  Motion o(animated());
  for (int s = 0; s < 40; ++s) o.step(0.05);
  EXPECT_LT((o.position() - Vec3(1, 2, -1)).norm(), 1e-12);
  EXPECT_LT(Vec3(o.v[0], o.v[1], o.v[2]).norm() + Vec3(o.v[3], o.v[4], o.v[5]).norm(), 1e-6);
}

TEST(ObstacleBody, FromAnyStateItReturnsToItsPath) {
  Motion o(animated());
  o.q[0] = 0.3, o.q[1] = -0.2;  // as after a resume at another time step
  o.step(0.5);
  EXPECT_LT((o.position() - Vec3(1, 0, 0)).norm(), 1e-12);
}

TEST(ObstacleBody, StandsStillWithOneKey) {
  ObstacleModel m;
  m.shape = make_half_space();
  m.keys[0].position = Vec3(0.1, 0.2, 0.3);
  Motion o(m);
  const auto before = o.q;
  o.v.assign(6, 7.0);
  o.step(0.1);
  EXPECT_EQ(o.q, before);
  EXPECT_EQ(o.v, std::vector<double>(6, 0.0));
  EXPECT_EQ(o.body.relative_speed_bound(0, o.v), 0.0) << "a half-space is infinite; its bound is not";
}

TEST(ObstacleBody, EveryDirectionIsFiltered) {
  const ObstacleBody body(animated());
  std::vector<double> x(6, 1.0);
  body.filter(x);
  EXPECT_EQ(x, std::vector<double>(6, 0.0));
}

TEST(ObstacleBody, KeysMustExistAndIncreaseInTime) {
  ObstacleModel m = animated();
  m.keys[2].time = 0.5;
  EXPECT_THROW(ObstacleBody{m}, InputError);
  m.keys.clear();
  EXPECT_THROW(ObstacleBody{m}, InputError);
}

}  // namespace
}  // namespace brim::obstacle_body_test
