#include "brim/body/rigid/rigid_body.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/core/error.h"
#include "brim/math/rotation.h"

namespace brim::rigid_body_test {
namespace {

constexpr unsigned kSeed = 91;

RigidModel brick() {
  RigidModel m;
  const Vec3 e(0.4, 1.0, 0.2);
  m.shape = make_box(e);
  m.mass = 80.0;
  const Vec3 s = e.cwiseAbs2() * m.mass / 12.0;
  m.inertia = Vec3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()).asDiagonal();
  return m;
}

/// The body under the step of the world without contact: solve, advance, finish.
struct Flight {
  RigidBody body;
  std::vector<double> q, v;
  double time = 0.0;

  explicit Flight(const RigidModel& m) : body(m), q(7), v(6) {
    body.initial_state(q, v);
    body.update(0.0, q, v);
  }
  void step(double dt, const Environment& env) {
    body.update(time, q, v);
    body.begin_solve(dt);
    std::vector<double> Q(6, 0.0), d(6);
    body.add_forces(env, Q);
    BlockDiagonal A;
    A.reset(body.block_sizes());
    body.add_system_diagonal(0, A);
    A.factor();
    A.solve(Q, d);
    for (int i = 0; i < 6; ++i) v[i] += dt * d[i];
    body.advance(dt, q, v);
    body.finish_step(time, dt, q, v);
    time += dt;
    body.update(time, q, v);
  }
};

TEST(RigidBody, FreeTumblingKeepsAngularMomentumAndBoundsEnergy) {
  RigidModel m = brick();
  m.angular_velocity = Vec3(3.0, 0.05, 0.02);  // about the middle axis of inertia: it tumbles over
  m.velocity = Vec3(0.3, -0.1, 0.2);
  Flight f(m);
  const Environment weightless{Vec3::Zero()};
  const Vec3 L = f.body.angular_momentum(f.v), P = f.body.linear_momentum(f.v);
  const double E = f.body.kinetic_energy(f.v);
  double least = E, most = E, worst = 0.0, turned = 0.0;
  for (int s = 0; s < 10000; ++s) {
    f.step(1.0 / 240.0, weightless);
    worst = std::max(worst, (f.body.angular_momentum(f.v) - L).norm() / L.norm());
    least = std::min(least, f.body.kinetic_energy(f.v)), most = std::max(most, f.body.kinetic_energy(f.v));
    turned = std::max(turned, (Quat(f.q[3], f.q[4], f.q[5], f.q[6]) * Vec3(1, 0, 0)).dot(Vec3(-1, 0, 0)));
  }
  RecordProperty("angular_momentum_error", std::to_string(worst));
  EXPECT_LT(worst, 1e-12);
  EXPECT_LT((f.body.linear_momentum(f.v) - P).norm(), 1e-12 * P.norm());
  EXPECT_LT(most, 1.01 * E);
  EXPECT_GT(least, 0.99 * E);
  EXPECT_GT(turned, 0.9) << "the brick turned over";
  EXPECT_NEAR(Quat(f.q[3], f.q[4], f.q[5], f.q[6]).norm(), 1.0, 1e-12);
}

TEST(RigidBody, RotationConvergesAtFourthOrder) {
  const auto end = [](int steps) {
    RigidModel m = brick();
    m.angular_velocity = Vec3(1.0, 2.0, -1.5);
    Flight f(m);
    for (int s = 0; s < steps; ++s) f.step(1.0 / steps, {Vec3::Zero()});
    return Quat(f.q[3], f.q[4], f.q[5], f.q[6]);
  };
  const Quat fine = end(12800);
  const double coarse = end(80).angularDistance(fine), half = end(160).angularDistance(fine);  // each of one piece
  EXPECT_GT(coarse, 1e-9);
  EXPECT_NEAR(coarse / half, 16.0, 2.0);
}

TEST(RigidBody, FallsOnAParabola) {
  RigidModel m = brick();
  m.position = Vec3(1, 2, 3);
  m.velocity = Vec3(2, 0, 5);
  Flight f(m);
  const double dt = 1e-2;
  const int n = 100;
  for (int s = 0; s < n; ++s) f.step(dt, {});
  // Semi-implicit Euler: z = z0 + v t − g t² (1 + 1/n) / 2, exactly.
  const Vec3 expected(1 + 2, 2, 3 + 5 - 0.5 * 9.81 * (1.0 + 1.0 / n));
  EXPECT_LT((Vec3(f.q[0], f.q[1], f.q[2]) - expected).norm(), 1e-12);
  EXPECT_NEAR(f.v[5 - 3], 5 - 9.81, 1e-12);
}

TEST(RigidBody, DragDampsMomentumAtTheImplicitRate) {
  RigidModel m = brick();
  m.velocity = Vec3(4, 0, 0);
  m.linear_damping = 2.0;
  Flight f(m);
  const double dt = 0.05;
  for (int s = 0; s < 10; ++s) f.step(dt, {Vec3::Zero()});
  EXPECT_NEAR(f.v[0], 4.0 / std::pow(1.0 + 2.0 * dt, 10), 1e-12);
}

TEST(RigidBody, SystemIsTheMassWithDampingAndItsDiagonalIsTheWholeMatrix) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::normal_distribution<double> normal;
  RigidModel m = brick();
  m.rotation = rotation_from_vector(Vec3(0.3, -1.0, 0.4));
  m.linear_damping = 0.7, m.angular_damping = 0.3;
  Flight f(m);
  const double dt = 0.02;
  f.body.begin_solve(dt);
  BlockDiagonal D;
  D.reset(f.body.block_sizes());
  f.body.add_system_diagonal(0, D);
  for (int trial = 0; trial < 5; ++trial) {
    std::vector<double> x(6), y(6, 0.0), mass(6, 0.0), drag(6, 0.0);
    for (double& e : x) e = normal(rng);
    f.body.apply_system(x, y);
    f.body.apply_mass(x, mass);
    f.body.apply_damping(x, drag);
    const Eigen::VectorXd product = D.block(0) * Eigen::Map<const Eigen::VectorXd>(x.data(), 6);
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR(y[i], mass[i] - dt * drag[i], 1e-12);
      EXPECT_NEAR(y[i], product[i], 1e-12);
    }
  }
}

TEST(RigidBody, ItsRigidFrameInvertsItsSystem) {
  RigidModel m = brick();
  m.center_of_mass = Vec3(0.1, 0.2, -0.05);
  m.rotation = rotation_from_vector(Vec3(0.3, -1.0, 0.6));
  m.linear_damping = 0.7, m.angular_damping = 1.9;
  Flight f(m);
  f.body.begin_solve(0.02);
  const RigidFrame::Frame frame = f.body.rigid_frame();
  EXPECT_LT((frame.center - Vec3(f.q[0], f.q[1], f.q[2])).norm(), 1e-15);
  const std::vector<double> x{0.3, -1.2, 0.5, 2.0, 0.1, -0.7};
  std::vector<double> y(6, 0.0);
  f.body.apply_system(x, y);
  EXPECT_LT((frame.inverse_mass * Vec3(y[0], y[1], y[2]) - Vec3(x[0], x[1], x[2])).norm(), 1e-13);
  EXPECT_LT((frame.inverse_inertia * Vec3(y[3], y[4], y[5]) - Vec3(x[3], x[4], x[5])).norm(), 1e-13);
}

TEST(RigidBody, CenterOfMassAwayFromTheShapesOriginIsWhatMoves) {
  RigidModel m = brick();
  m.center_of_mass = Vec3(0, 0.4, 0);
  m.position = Vec3(5, 0, 0);
  m.rotation = rotation_from_vector(Vec3(0, 0, 0.5 * 3.14159265358979323846));
  Flight f(m);
  EXPECT_LT((Vec3(f.q[0], f.q[1], f.q[2]) - Vec3(4.6, 0, 0)).norm(), 1e-15);
  const Aabb box = f.body.bounds(0);
  EXPECT_LT((box.center() - Vec3(5, 0, 0)).norm(), 1e-12);
  EXPECT_NEAR(box.extent().x(), 1.0, 1e-12);
  std::unique_ptr<Map> map;
  f.body.make_map(0, std::vector<Vec3>{Vec3(4.6, 1, 0)}, std::vector<std::int32_t>{0}, map);
  std::vector<Vec3> u(1);
  map->apply(std::vector<double>{0, 0, 0, 0, 0, 1}, u);
  EXPECT_LT((u[0] - Vec3(-1, 0, 0)).norm(), 1e-15);
}

TEST(RigidBody, SpeedBoundHoldsForEveryPointOfTheShape) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  RigidModel m = brick();
  m.center_of_mass = Vec3(0.05, 0.3, -0.02);
  const RigidBody body(m);
  for (int i = 0; i < 1000; ++i) {
    const double a = u(rng), b = u(rng), c = u(rng), x = u(rng), y = u(rng), z = u(rng);
    const std::vector<double> v = {1, 2, 3, a, b, c};
    const Vec3 p = Vec3(0.2 * x, 0.5 * y, 0.1 * z) - m.center_of_mass;
    EXPECT_LE(Vec3(a, b, c).cross(p).norm(), body.relative_speed_bound(0, v) + 1e-15);
  }
}

TEST(RigidBody, MassAndInertiaMustBePositive) {
  RigidModel m = brick();
  m.mass = 0.0;
  EXPECT_THROW(RigidBody{m}, InputError);
  m = brick();
  m.inertia(1, 1) = -1.0;
  EXPECT_THROW(RigidBody{m}, InputError);
}

}  // namespace
}  // namespace brim::rigid_body_test
