#include <gtest/gtest.h>

#include "brim/body/own/own_body.h"
#include "brim/math/rotation.h"
#include "brim/mesh/primitives.h"
#include "support/implicit.h"
#include "support/worlds.h"

/// How own bodies move between and in contacts: with their spin, and without energy of their own.
namespace brim::own_body_motion_test {
namespace {

/// A bar in rotation coordinates that stretches evenly along itself: q = centre, rotation vector, stretch.
class Bar final : public OwnBody {
 public:
  explicit Bar(OwnModel m) : OwnBody(std::move(m)) {}
  std::string_view kind() const override { return "bar"; }
  static Mat3 R(Coordinates q) { return rotation_from_vector(Vec3(q[3], q[4], q[5])).toRotationMatrix(); }
  static Vec3 stretch(Coordinates q) { return {1.0 + q[6], 1.0, 1.0}; }
  Vec3 deform(Coordinates q, const Vec3& X) const override {
    return Vec3(q[0], q[1], q[2]) + R(q) * X.cwiseProduct(stretch(q));
  }
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override {
    return (R(q).transpose() * (x - Vec3(q[0], q[1], q[2]))).cwiseQuotient(stretch(q));
  }
  double distance(Coordinates q, const Vec3& x) const override {
    return (inverse_deform(q, x).cwiseAbs() - Vec3(0.5, 0.1, 0.1)).maxCoeff();
  }
  double energy(Coordinates q) const override { return 0.5 * 4e6 * q[6] * q[6]; }
};

TEST(OwnBodyMotion, AFreeBarInRotationCoordinatesKeepsMomentumAndEnergy) {
  Environment env;
  env.gravity.setZero();
  for (const double dt : {0.01, 0.0025}) {
    OwnModel m;
    m.q = {0.2, 0, 0.1, 0, 0, 0, 0}, m.v = {0.5, -1, 0.3, 2, 1, 3, 0};
    m.surface = shapes::box(Vec3(1.0, 0.2, 0.2));
    m.density = 500.0, m.mass_spacing = 0.2;
    Bar bar(std::move(m));
    testing::Stepper s(bar);
    const Vec3 L = bar.angular_momentum(s.v), P = bar.linear_momentum(s.v);
    const double start = bar.kinetic_energy(s.v);
    // The rotation vector stays below 2 pi, where its derivative by the rotation ends.
    for (int i = 0; i < std::lround(1.0 / dt); ++i) {
      s.step(dt, env, 1e-13);
      bar.update(s.time, s.q, s.v);
      // The stretch by its spin, m l² ω² / 12 against 4e6 N, is 3e-5, and takes twice that from the spin.
      EXPECT_NEAR(bar.kinetic_energy(s.v) + bar.energy(s.q), start, 2e-4 * start) << "dt " << dt << ", step " << i;
    }
    EXPECT_LT((bar.angular_momentum(s.v) - L).norm(), 1e-8 * L.norm()) << "before, 11 % of it were lost at 0.01 s";
    EXPECT_LT((bar.linear_momentum(s.v) - P).norm(), 1e-8 * P.norm());
    EXPECT_GT(Vec3(s.q[3], s.q[4], s.q[5]).norm(), 3.0);
  }
}

/// x = c + A X with the energy of the example's jelly, k [Pa].
class Jelly final : public OwnBody {
 public:
  Jelly(OwnModel m, double k) : OwnBody(std::move(m)), k_(k) {}
  std::string_view kind() const override { return "jelly"; }
  static constexpr double kRadius = 0.1;
  static Vec3 c(Coordinates q) { return Eigen::Map<const Vec3>(q.data()); }
  static Mat3 A(Coordinates q) { return Eigen::Map<const Mat3>(q.data() + 3); }
  Vec3 deform(Coordinates q, const Vec3& X) const override { return c(q) + A(q) * X; }
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override { return A(q).inverse() * (x - c(q)); }
  double distance(Coordinates q, const Vec3& x) const override {
    const Mat3 back = A(q).inverse();
    const Vec3 X = back * (x - c(q));
    const double r = std::max(X.norm(), 1e-9);
    return (r - kRadius) / (back.transpose() * X / r).norm();
  }
  double energy(Coordinates q) const override {
    return k_ * 4.2e-3 * (A(q).transpose() * A(q) - Mat3::Identity()).squaredNorm();
  }

 private:
  double k_;
};

std::unique_ptr<Jelly> jelly(double k, const Vec3& at, const Vec3& velocity, const Vec3& spin) {
  OwnModel m;
  m.q = {at.x(), at.y(), at.z(), 1, 0, 0, 0, 1, 0, 0, 0, 1};
  m.v = {velocity.x(), velocity.y(), velocity.z()};
  const Mat3 turn = skew(spin);
  m.v.insert(m.v.end(), turn.data(), turn.data() + 9);
  m.surface = shapes::icosphere(Jelly::kRadius, 2);
  m.density = 500.0;
  m.voxel_size = 0.02, m.mass_spacing = 0.05;
  auto body = std::make_unique<Jelly>(std::move(m), k);
  body->set_name("jelly");
  return body;
}

TEST(OwnBodyMotion, AFreeJellyOfAnyStiffnessSpinsWithoutStretching) {
  Environment env;
  env.gravity.setZero();
  for (const double k : {2e3, 2e5, 1e7}) {
    const auto body = jelly(k, Vec3::Zero(), Vec3(0.5, 0, 0), Vec3(2, 6, -20));
    testing::Stepper s(*body);
    const Vec3 L = body->angular_momentum(s.v);
    const double start = body->kinetic_energy(s.v);
    for (int i = 0; i < 100; ++i) {
      s.step(0.01, env, 1e-13);
      body->update(s.time, s.q, s.v);
      EXPECT_LE(body->kinetic_energy(s.v) + body->energy(s.q), 1.001 * start) << "k " << k << ", step " << i;
    }
    EXPECT_LT((body->angular_momentum(s.v) - L).norm(), 1e-8 * L.norm()) << k;
    // Centrifugal forces stretch it by m ω²/5 r²·… against 8 k V: less than ρ ω² r² / k.
    const double stretch = (Jelly::A(s.q).transpose() * Jelly::A(s.q) - Mat3::Identity()).norm();
    EXPECT_LT(stretch, 2.0 * 500.0 * 440.0 * 0.01 / k) << k;
  }
}

TEST(OwnBodyMotion, AStiffJellyThatRollsGainsNoEnergy) {
  for (const double k : {2e4, 2e5, 1e6}) {
    WorldOptions o;
    o.voxel_size = 0.02, o.time_step = 0.01;
    World w(o);
    w.add(testing::ground(0.5));
    w.add(own_body_motion_test::jelly(k, Vec3(0, 0, 0.1), Vec3(0.5, 0, 0), Vec3(0, 5, 0)));
    const double start = w.body(1).kinetic_energy(w.v(1));
    for (int i = 0; i < 60; ++i) {
      ASSERT_TRUE(w.step().ok);
      // It falls by the compression of the contact, some hundredths of a voxel: m g 1e-3 m is a twentieth of its start.
      EXPECT_LT(w.body(1).kinetic_energy(w.v(1)), 1.05 * start) << "k " << k << ", step " << i;
    }
    EXPECT_GT(w.v(1)[0], 0.4) << "and goes on rolling";
  }
}

TEST(OwnBodyMotion, AWorldGoesOnFromAnyStateAsIfNothingHadBeen) {
  WorldOptions o;
  o.voxel_size = 0.02, o.time_step = 0.01;
  World w(o), resumed(o);
  for (World* world : {&w, &resumed}) {
    world->add(testing::ground(0.5));
    world->add(own_body_motion_test::jelly(2e4, Vec3(0, 0, 0.15), Vec3(0.5, 0, 0), Vec3(1, 5, 2)));
  }
  const State start = w.state();
  int contacts = 0;
  for (int i = 0; i < 60; ++i) {
    const State before = w.state();
    contacts += w.step().contacts;
    resumed.set_state(start), resumed.set_state(before);
    resumed.step();
    ASSERT_EQ(w.hash(), resumed.hash()) << "step " << i;
  }
  EXPECT_GT(contacts, 0);
}

/// A bar as a bow, of the eight vertices of a box: its ends are 0.4 m above its middle.
class Bow final : public OwnBody {
 public:
  explicit Bow(OwnModel m) : OwnBody(std::move(m)) {}
  std::string_view kind() const override { return "bow"; }
  Vec3 deform(Coordinates q, const Vec3& X) const override { return X + Vec3(0, 0, q[0] + q[1] * X.x() * X.x()); }
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override {
    return x - Vec3(0, 0, q[0] + q[1] * x.x() * x.x());
  }
  double distance(Coordinates q, const Vec3& x) const override {
    return (inverse_deform(q, x).cwiseAbs() - Vec3(0.5, 0.05, 0.05)).maxCoeff();
  }
  double energy(Coordinates q) const override { return 1e3 * (q[1] - 1.6) * (q[1] - 1.6); }
};

TEST(OwnBodyMotion, MatterBetweenTheVerticesOfABentBodyIsInItsBounds) {
  OwnModel m;
  m.q = {0.3, 1.6}, m.v = {-1.0, 0.0};
  m.surface = shapes::box(Vec3(1.0, 0.1, 0.1));
  m.voxel_size = 0.04;
  auto body = std::make_unique<Bow>(std::move(m));
  body->set_name("bow");
  WorldOptions o;
  o.voxel_size = 0.04, o.time_step = 0.01;
  World w(o);
  w.add(testing::ground(0.5));
  w.add(std::move(body));
  EXPECT_LE(w.body(1).bounds(0).lo.z(), 0.25);
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(w.step().ok);
  EXPECT_GT(w.q(1)[0], 0.03) << "the middle, half as thick as 0.1 m, lies on the ground: before, it fell through";
}

}  // namespace
}  // namespace brim::own_body_motion_test
