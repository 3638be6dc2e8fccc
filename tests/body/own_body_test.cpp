#include "brim/body/own/own_body.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "brim/core/error.h"
#include "brim/mesh/primitives.h"
#include "brim/world/world.h"

/// What follows from deform, inverse_deform, distance and energy.
namespace brim::own_body_test {
namespace {

constexpr double kRadius = 0.1, kDensity = 500.0;
const double kMass = kDensity * 4.0 / 3.0 * std::numbers::pi * kRadius * kRadius * kRadius;

OwnModel ball_model(std::vector<double> q, std::vector<double> v = {}) {
  OwnModel m;
  m.q = std::move(q);
  m.v = std::move(v);
  m.surface = shapes::icosphere(kRadius, 3);
  m.density = kDensity;
  return m;
}

/// A ball in the plane z = 0 that does not turn, in polar coordinates: curved, so that inertia depends on place.
class PolarBall final : public OwnBody {
 public:
  explicit PolarBall(OwnModel m) : OwnBody(std::move(m)) {}
  std::string_view kind() const override { return "polar"; }
  static Vec3 center(Coordinates q) { return {q[0] * std::cos(q[1]), q[0] * std::sin(q[1]), 0.0}; }
  Vec3 deform(Coordinates q, const Vec3& X) const override { return center(q) + X; }
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override { return x - center(q); }
  double distance(Coordinates q, const Vec3& x) const override { return inverse_deform(q, x).norm() - kRadius; }
};

/// x = c + A X with an energy that is no quadratic form.
class AffineBall final : public OwnBody {
 public:
  explicit AffineBall(OwnModel m) : OwnBody(std::move(m)) {}
  std::string_view kind() const override { return "affine"; }
  static Vec3 c(Coordinates q) { return Eigen::Map<const Vec3>(q.data()); }
  static Mat3 A(Coordinates q) { return Eigen::Map<const Mat3>(q.data() + 3); }
  Vec3 deform(Coordinates q, const Vec3& X) const override { return c(q) + A(q) * X; }
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override { return A(q).inverse() * (x - c(q)); }
  double distance(Coordinates q, const Vec3& x) const override { return inverse_deform(q, x).norm() - kRadius; }
  double energy(Coordinates q) const override {
    return 40.0 * (A(q).transpose() * A(q) - Mat3::Identity()).squaredNorm();
  }
};

std::vector<double> affine_state(std::mt19937& rng) {
  std::uniform_real_distribution<double> u(-1, 1);
  std::vector<double> q = {0.3, -0.2, 0.5, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (double& x : q) x += 0.2 * u(rng);
  return q;
}

TEST(OwnBody, AFreeBallInPolarCoordinatesFliesStraight) {
  // M = m diag(1, r²), Q = m (r θ'², −2 r r' θ'): by hand.
  const std::vector<double> q = {2.0, 0.4}, v = {0.7, 1.3};
  PolarBall body(ball_model(q, v));
  body.update(0.0, q, v);
  Environment env;
  env.gravity.setZero();
  std::vector<double> Q(2, 0.0), Mx(2, 0.0);
  body.add_forces(env, Q);
  body.apply_mass(std::vector<double>{1.0, 1.0}, Mx);
  EXPECT_NEAR(body.mass(), kMass, 0.02 * kMass) << "the icosphere is a little smaller than the ball";
  const double m = body.mass();
  EXPECT_NEAR(Mx[0], m, 1e-8 * m);
  EXPECT_NEAR(Mx[1], 4.0 * m, 1e-8 * m);
  EXPECT_NEAR(Q[0], m * 2.0 * 1.3 * 1.3, 1e-4 * m);
  EXPECT_NEAR(Q[1], -2.0 * m * 2.0 * 0.7 * 1.3, 1e-4 * m);
  const Vec3 p = body.linear_momentum(v);
  const Vec3 by_hand =
      m * Vec3(0.7 * std::cos(0.4) - 2.0 * 1.3 * std::sin(0.4), 0.7 * std::sin(0.4) + 2.0 * 1.3 * std::cos(0.4), 0.0);
  EXPECT_LT((p - by_hand).norm(), 1e-8 * m);
}

/// x = c + |s| X / 1 m: at s = 0 its derivative has two sides. Its author's formula is of any kind.
class FormulaBall final : public OwnBody {
 public:
  enum class Formula { Right, LeftSide, Zero, Random, WrongUnit };
  FormulaBall(Formula formula, double s) : OwnBody(ball_model({0.3, -0.2, 0.5, s})), formula_(formula) {}
  std::string_view kind() const override { return "formula"; }
  Vec3 deform(Coordinates q, const Vec3& X) const override {
    return Eigen::Map<const Vec3>(q.data()) + (1.0 + std::abs(q[3])) * X;
  }
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override {
    return (x - Eigen::Map<const Vec3>(q.data())) / (1.0 + std::abs(q[3]));
  }
  double distance(Coordinates q, const Vec3& x) const override { return inverse_deform(q, x).norm() - kRadius; }
  void jacobian(Coordinates q, const Vec3& X, Eigen::Ref<Jacobian> J) const override {
    J.leftCols(3) = Mat3::Identity();
    J.col(3) = (q[3] < 0.0 || formula_ == Formula::LeftSide ? -1.0 : 1.0) * X;
    if (formula_ == Formula::Zero) J.setZero();
    if (formula_ == Formula::Random) J.col(3) = Vec3(0.3, -0.8, 0.4);
    if (formula_ == Formula::WrongUnit) J.col(3) *= 180.0 / std::numbers::pi;
  }

 private:
  Formula formula_;
};

TEST(OwnBody, AJacobianThatIsNoDerivativeOfDeformIsRefusedAtTheStart) {
  using Formula = FormulaBall::Formula;
  const auto message = [](Formula formula, double s) -> std::string {
    World world;
    auto body = std::make_unique<FormulaBall>(formula, s);
    body->set_name("mine");
    try {
      world.add(std::move(body));
    } catch (const InputError& e) {
      EXPECT_EQ(world.body_count(), 0);
      return e.what();
    }
    return "";
  };
  for (const double s : {-0.2, 0.0, 0.3}) EXPECT_EQ(message(Formula::Right, s), "") << s;
  EXPECT_EQ(message(Formula::LeftSide, 0.0), "") << "the derivative of one side of an edge";
  for (const Formula wrong : {Formula::Zero, Formula::Random, Formula::WrongUnit}) {
    const std::string text = message(wrong, 0.3);
    EXPECT_EQ(text.find("body 'mine': jacobian(q, X) is not the derivative of deform(q, X): at X = ("), 0u) << text;
  }
  EXPECT_NE(message(Formula::LeftSide, 0.3), "");
  EXPECT_NE(message(Formula::WrongUnit, 0.3).find("its column 3 is"), std::string::npos);
}

TEST(OwnBody, ForceIsMinusTheSlopeOfEnergyAndStiffnessItsDerivative) {
  const unsigned seed = 5;
  SCOPED_TRACE(seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  Environment env;
  for (int trial = 0; trial < 5; ++trial) {
    const std::vector<double> q = affine_state(rng), zero(12, 0.0);
    AffineBall body(ball_model(q));
    const auto force = [&](const std::vector<double>& at) {
      std::vector<double> Q(12, 0.0);
      body.update(0.0, at, zero);
      body.add_forces(env, Q);
      return Q;
    };
    std::vector<double> d(12), plus = q, minus = q;
    const double step = 1e-4;
    for (double& x : d) x = u(rng);
    for (std::size_t i = 0; i < 12; ++i) plus[i] += step * d[i], minus[i] -= step * d[i];
    body.update(0.0, plus, zero);
    const double up = body.potential_energy(env);
    body.update(0.0, minus, zero);
    const double down = body.potential_energy(env);
    const auto Q = force(q);
    double work = 0.0, size = 0.0;
    for (std::size_t i = 0; i < 12; ++i) work += Q[i] * d[i], size += std::abs(Q[i] * d[i]);
    EXPECT_NEAR(work, -(up - down) / (2 * step), 1e-5 * size);

    // Without its positive part K takes at least as much energy as the true derivative.
    std::vector<double> Kd(12, 0.0);
    body.apply_stiffness(d, Kd);
    const auto f_up = force(plus), f_down = force(minus);
    double projected = 0.0, exact = 0.0;
    for (std::size_t i = 0; i < 12; ++i) {
      projected += d[i] * Kd[i];
      exact += d[i] * (f_up[i] - f_down[i]) / (2 * step);
    }
    EXPECT_LE(projected, 1e-9);
    EXPECT_LE(projected, exact + 1e-4 * std::abs(exact));
  }
}

TEST(OwnBody, StiffnessIsTheDerivativeWhereItResistsEveryMotion) {
  // Near rest every direction of the strain resists.
  std::vector<double> q = {0, 0, 0, 1.01, 0, 0, 0, 1.01, 0, 0, 0, 1.01}, zero(12, 0.0);
  AffineBall body(ball_model(q));
  std::vector<double> d = {0, 0, 0, 0.3, 0.1, 0.2, 0.1, -0.4, 0, 0.2, 0, 0.5}, Kd(12, 0.0);
  body.update(0.0, q, zero);
  body.apply_stiffness(d, Kd);
  // E = 40 |AᵀA − 1|², A = a 1: by hand dF = −40 (4 sym-part: 2 a² (D + Dᵀ) + 4 (a² − 1) D), D the motion of A.
  const double a = 1.01;
  const Mat3 D = Eigen::Map<const Mat3>(d.data() + 3);
  const Mat3 by_hand = -40.0 * (4.0 * a * a * (D + D.transpose()) + 4.0 * (a * a - 1.0) * D);
  EXPECT_LT((Eigen::Map<const Mat3>(Kd.data() + 3) - by_hand).norm(), 1e-4 * by_hand.norm());
}

TEST(OwnBody, TheMapIsTheRateOfPlaceAndItsTransposeDoesTheSameWork) {
  const unsigned seed = 11;
  SCOPED_TRACE(seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  const std::vector<double> q = affine_state(rng);
  std::vector<double> v(12);
  for (double& x : v) x = u(rng);
  AffineBall body(ball_model(q));
  body.update(0.0, q, v);
  std::vector<Vec3> points, f, velocity(20);
  for (int i = 0; i < 20; ++i) {
    points.push_back(AffineBall::c(q) + 0.1 * Vec3(u(rng), u(rng), u(rng)));
    f.push_back(Vec3(u(rng), u(rng), u(rng)));
  }
  std::unique_ptr<Map> map;
  body.make_map(0, points, std::vector<std::int32_t>(20, 0), map);
  map->apply(v, velocity);
  std::vector<double> Q(12, 0.0), ahead = q, behind = q;
  map->apply_transpose(f, Q);
  double power = 0.0, work = 0.0;
  for (std::size_t i = 0; i < 12; ++i) {
    power += Q[i] * v[i];
    ahead[i] += 1e-4 * v[i], behind[i] -= 1e-4 * v[i];
  }
  for (std::size_t p = 0; p < 20; ++p) {
    work += f[p].dot(velocity[p]);
    const Vec3 X = body.inverse_deform(q, points[p]);
    const Vec3 rate = (body.deform(ahead, X) - body.deform(behind, X)) / 2e-4;
    EXPECT_LT((velocity[p] - rate).norm(), 1e-9);
  }
  EXPECT_NEAR(power, work, 1e-13 * std::abs(work) + 1e-13);
  // The diagonal block is JᵀKJ.
  const std::vector<Mat3> K(20, Mat3::Identity());
  BlockDiagonal D;
  D.reset(std::vector<int>{12});
  map->add_block_diagonal(K, 0, D);
  const Eigen::Map<const Eigen::VectorXd> x(v.data(), 12);
  double square = 0.0;
  for (const Vec3& w : velocity) square += w.squaredNorm();
  EXPECT_NEAR(x.dot(D.block(0) * x), square, 1e-12 * square);
}

TEST(OwnBody, ABodyThatCanTurnKeepsMomentumExactly) {
  std::mt19937 rng(3);
  const std::vector<double> q = affine_state(rng), zero(12, 0.0);
  AffineBall body(ball_model(q));
  body.update(0.0, q, zero);
  std::vector<double> v(12);
  const Vec3 t(0.3, -1.0, 0.2), w(1.0, 0.5, -2.0);
  ASSERT_TRUE(body.rigid_motion(t, w, v));
  std::vector<Vec3> points = {Vec3(0.4, -0.2, 0.5), Vec3(0.3, -0.1, 0.45)}, u(2);
  std::unique_ptr<Map> map;
  body.make_map(0, points, std::vector<std::int32_t>(2, 0), map);
  map->apply(v, u);
  for (std::size_t p = 0; p < 2; ++p) EXPECT_LT((u[p] - t - w.cross(points[p])).norm(), 1e-8);
}

/// The same in another unit of its coordinates.
class ScaledBall final : public OwnBody {
 public:
  static constexpr double kUnit = 1e-6;
  explicit ScaledBall(OwnModel m) : OwnBody(std::move(m)) {}
  std::string_view kind() const override { return "scaled"; }
  static std::vector<double> plain(Coordinates q) {
    std::vector<double> p(q.begin(), q.end());
    for (double& x : p) x *= kUnit;
    return p;
  }
  Vec3 deform(Coordinates q, const Vec3& X) const override {
    const auto p = plain(q);
    return AffineBall::c(p) + AffineBall::A(p) * X;
  }
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override {
    const auto p = plain(q);
    return AffineBall::A(p).inverse() * (x - AffineBall::c(p));
  }
  double distance(Coordinates q, const Vec3& x) const override { return inverse_deform(q, x).norm() - kRadius; }
  double energy(Coordinates q) const override {
    const Mat3 A = AffineBall::A(plain(q));
    return 40.0 * (A.transpose() * A - Mat3::Identity()).squaredNorm();
  }
};

TEST(OwnBody, TheUnitOfItsCoordinatesChangesNothing) {
  std::mt19937 rng(5);
  const std::vector<double> q = affine_state(rng);
  std::vector<double> v(12), scaled_q = q, scaled_v(12);
  std::uniform_real_distribution<double> u(-1, 1);
  for (double& x : v) x = u(rng);
  for (std::size_t i = 0; i < 12; ++i) scaled_q[i] = q[i] / ScaledBall::kUnit, scaled_v[i] = v[i] / ScaledBall::kUnit;
  AffineBall plain(ball_model(q));
  ScaledBall scaled(ball_model(scaled_q));
  plain.update(0.0, q, v), scaled.update(0.0, scaled_q, scaled_v);
  std::vector<double> Q(12, 0.0), scaled_Q(12, 0.0);
  plain.add_forces({}, Q), scaled.add_forces({}, scaled_Q);
  double most = 0.0;
  for (const double f : Q) most = std::max(most, std::abs(f));
  for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(scaled_Q[i] / ScaledBall::kUnit, Q[i], 1e-6 * most) << i;
}

/// A plate of 1 m with a dimple of some centimetres in its middle: q = height, depth.
class Dimple final : public OwnBody {
 public:
  static constexpr double kWidth = 0.15;
  explicit Dimple(OwnModel m) : OwnBody(std::move(m)) {}
  std::string_view kind() const override { return "dimple"; }
  static double mode(const Vec3& X) { return std::exp(-X.head<2>().squaredNorm() / (2.0 * kWidth * kWidth)); }
  Vec3 deform(Coordinates q, const Vec3& X) const override {
    return X + Vec3(0.2 * std::sin(q[1]) * mode(X), 0.0, q[0] + q[1] * mode(X));
  }
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override { return x - (deform(q, x) - x); }
  double distance(Coordinates q, const Vec3& x) const override { return std::abs(inverse_deform(q, x).z()) - 0.05; }
  double energy(Coordinates q) const override { return 250.0 * q[1] * q[1] + 2.5e4 * std::pow(q[1], 4); }
  void jacobian(Coordinates q, const Vec3& X, Eigen::Ref<Jacobian> J) const override {
    J.col(0) = Vec3::UnitZ(), J.col(1) = Vec3(0.2 * std::cos(q[1]), 0.0, 1.0) * mode(X);
  }
};

TEST(OwnBody, AModeThatMovesLittleOfTheMatterHasItsForceAndItsJacobian) {
  // The dimple is 1e-5 deep at the corners of the plate.
  OwnModel m;
  m.q = {0.0, 0.0};
  m.surface = shapes::box(Vec3(1.0, 1.0, 0.1), 8);
  m.density = 100.0;
  Dimple body(std::move(m));
  const std::vector<double> zero(2, 0.0);
  EXPECT_NO_THROW(body.update(0.0, zero, zero)) << "its jacobian is right";
  const std::vector<double> q = {0.0, 0.05};
  body.update(0.0, q, zero);
  std::vector<double> Q(2, 0.0);
  Environment env;
  env.gravity.setZero();
  body.add_forces(env, Q);
  const double by_hand = -500.0 * q[1] - 1e5 * std::pow(q[1], 3);
  EXPECT_NEAR(Q[1], by_hand, 1e-4 * std::abs(by_hand));
}

TEST(OwnBody, AFreeBodyKeepsItsSpin_AndOneThatIsTiedToSpaceSwings) {
  const std::vector<double> q = {0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::vector<double> v(12, 0.0);
  // A' = ω × A
  const Mat3 spin = skew(Vec3(0.5, -1.0, 6.0));
  Eigen::Map<Mat3>(v.data() + 3) = spin;
  WorldOptions o;
  o.voxel_size = 0.1;
  o.environment.gravity.setZero();
  World w(o);
  auto body = std::make_unique<AffineBall>(ball_model(q, v));
  body->set_name("ball");
  w.add(std::move(body));
  const auto momentum = [&] { return w.body(0).angular_momentum(w.v(0)); };
  const Vec3 start = momentum();
  for (int s = 0; s < 120; ++s) ASSERT_TRUE(w.step().ok);
  EXPECT_LT((momentum() - start).norm(), 1e-7 * start.norm());  // measured 1e-8; a third of it was left before

  // Torsion about z, of a body that does nothing else: its energy minds how it is turned.
  class Twisted final : public OwnBody {
   public:
    explicit Twisted(OwnModel m) : OwnBody(std::move(m)) {}
    std::string_view kind() const override { return "twisted"; }
    static Mat3 R(Coordinates q) { return Eigen::AngleAxisd(q[0], Vec3::UnitZ()).toRotationMatrix(); }
    Vec3 deform(Coordinates q, const Vec3& X) const override { return R(q) * X; }
    Vec3 inverse_deform(Coordinates q, const Vec3& x) const override { return R(q).transpose() * x; }
    double distance(Coordinates q, const Vec3& x) const override { return inverse_deform(q, x).norm() - kRadius; }
    double energy(Coordinates q) const override { return 0.5 * q[0] * q[0]; }
  };
  World turning(o);
  auto twisted = std::make_unique<Twisted>(ball_model({0.3}, {0.0}));
  twisted->set_name("twisted");
  turning.add(std::move(twisted));
  double least = 0.3;
  for (int s = 0; s < 200; ++s) {
    ASSERT_TRUE(turning.step().ok);
    least = std::min(least, turning.q(0)[0]);
  }
  EXPECT_LT(least, -0.1) << "it swings through";
}

TEST(OwnBody, WhatCannotBeABodyIsRefused) {
  EXPECT_THROW(PolarBall(ball_model({})), InputError);
  EXPECT_THROW(PolarBall(ball_model({1.0, 2.0}, {1.0})), InputError);
  EXPECT_THROW(PolarBall(ball_model({1.0, std::nan("")})), InputError);
  OwnModel hollow = ball_model({1.0, 2.0});
  hollow.surface = TriMesh();
  EXPECT_THROW(PolarBall(std::move(hollow)), InputError);
}

}  // namespace
}  // namespace brim::own_body_test
