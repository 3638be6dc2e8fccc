#include "brim/body/own/own_body_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "brim/body/own/lost_coordinates.h"
#include "brim/core/error.h"
#include "brim/mesh/primitives.h"
#include "brim/world/world.h"

/// Mistakes of authors, each alone: what is found at the start, and what the check finds.
namespace brim::own_body_check_test {
namespace {

constexpr double kRadius = 0.3;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A ball that stretches along the axes, q = (centre, stretch), with one function replaced.
struct Mistakes {
  std::function<Vec3(OwnBody::Coordinates, const Vec3&)> deform, inverse;
  std::function<double(OwnBody::Coordinates, const Vec3&)> distance;
  std::function<double(OwnBody::Coordinates)> energy;
  std::function<Eigen::VectorXd(OwnBody::Coordinates)> force;
  double jacobian = 1.0;  ///< factor on the right one
  std::vector<double> q = {0, 0, 0.35, 1, 1, 1};
};

class Stretched final : public OwnBody {
 public:
  explicit Stretched(Mistakes m) : OwnBody(model(m)), m_(std::move(m)) { set_name("mine"); }
  static OwnModel model(const Mistakes& m) {
    OwnModel model;
    model.q = m.q;
    model.surface = shapes::icosphere(kRadius, 3);
    return model;
  }
  std::string_view kind() const override { return "stretched"; }
  Vec3 deform(Coordinates q, const Vec3& X) const override {
    if (m_.deform) return m_.deform(q, X);
    return {q[0] + q[3] * X.x(), q[1] + q[4] * X.y(), q[2] + q[5] * X.z()};
  }
  static Vec3 at_rest(Coordinates q, const Vec3& x) {
    return {(x.x() - q[0]) / q[3], (x.y() - q[1]) / q[4], (x.z() - q[2]) / q[5]};
  }
  static double right_distance(Coordinates q, const Vec3& x) {
    return (at_rest(q, x).norm() - kRadius) * std::min({q[3], q[4], q[5]});
  }
  static double right_energy(Coordinates q) {
    double E = 0.0;
    for (int i = 3; i < 6; ++i) E += 2e3 * (q[i] - 1) * (q[i] - 1);
    return E;
  }
  static Eigen::VectorXd right_force(Coordinates q) {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(q.size()));
    for (int i = 3; i < 6; ++i) f[i] = -4e3 * (q[i] - 1);
    return f;
  }
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override {
    return m_.inverse ? m_.inverse(q, x) : at_rest(q, x);
  }
  double distance(Coordinates q, const Vec3& x) const override {
    return m_.distance ? m_.distance(q, x) : right_distance(q, x);
  }
  double energy(Coordinates q) const override { return m_.energy ? m_.energy(q) : right_energy(q); }
  Eigen::VectorXd energy_force(Coordinates q) const override { return m_.force ? m_.force(q) : right_force(q); }
  void jacobian(Coordinates q, const Vec3& X, Eigen::Ref<Jacobian> J) const override {
    OwnBody::jacobian(q, X, J);
    J *= m_.jacobian;
  }

 private:
  Mistakes m_;
};

/// What World::add refuses, or else all that the check finds; "" for a good body.
std::string told(Mistakes mistakes) {
  World world;
  try {
    const int b = world.add(std::make_unique<Stretched>(std::move(mistakes)));
    std::string all;
    for (const std::string& text : check_own_body(dynamic_cast<const OwnBody&>(world.body(b))))
      all += (all.empty() ? "" : "\n") + text;
    return all;
  } catch (const InputError& e) {
    return std::string("add: ") + e.what();
  }
}

::testing::AssertionResult begins(const std::string& text, const std::string& with) {
  if (text.find(with) == 0 && text.find('\n') == std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "\"" << text << "\" is not one line that begins with \"" << with << "\"";
}

TEST(OwnBodyCheck, AGoodBodyIsGood) { EXPECT_EQ(told({}), ""); }

TEST(OwnBodyCheck, AForceThatIsNotMinusTheDerivativeOfEnergyIsFound) {
  for (const double factor : {-1.0, 0.5, 1.03, 100.0}) {
    Mistakes m;
    m.force = [factor](OwnBody::Coordinates q) -> Eigen::VectorXd { return factor * Stretched::right_force(q); };
    EXPECT_TRUE(begins(told(m), "body 'mine': force of coordinate ")) << factor;
  }
}

TEST(OwnBodyCheck, AJacobianOffByTwoPercentIsFound) {
  Mistakes m;
  m.jacobian = 1.02;
  EXPECT_TRUE(begins(told(m), "body 'mine': jacobian at X = ("));
}

TEST(OwnBodyCheck, AnInverseThatIsNoneIsFound) {
  Mistakes m;
  m.inverse = [](OwnBody::Coordinates q, const Vec3& x) -> Vec3 { return x - Vec3(q[0], q[1], 0.9 * q[2]); };
  EXPECT_TRUE(begins(told(m), "body 'mine': inverse_deform of the place of X = ("));
}

TEST(OwnBodyCheck, DistancesOfAnotherSignPlaceSlopeAndReachAreFound) {
  const auto with = [](const std::function<double(double)>& change) {
    Mistakes m;
    m.distance = [change](OwnBody::Coordinates q, const Vec3& x) { return change(Stretched::right_distance(q, x)); };
    return told(m);
  };
  EXPECT_TRUE(begins(with([](double d) { return -d; }), "body 'mine': distance at x = ("));
  EXPECT_TRUE(begins(with([](double d) { return d + 0.1; }), "body 'mine': distance at x = ("));
  EXPECT_TRUE(begins(with([](double d) { return 2.0 * d; }), "body 'mine': distance grows by 2 m per metre"));
  EXPECT_TRUE(begins(with([](double d) { return std::min(d, 0.05); }), "body 'mine': distance saturates"));
  EXPECT_TRUE(begins(with([](double d) { return d > 0.5 ? -1.0 : d; }), "body 'mine': distance at x = ("));
  EXPECT_TRUE(
      begins(with([](double d) { return d > 0.5 ? kNan : d; }), "body 'mine': distance(q, x) gave nan for x = ("));
  EXPECT_EQ(with([](double d) { return std::clamp(d, -0.15, 0.15); }), "") << "farther away its sign is enough";
}

TEST(OwnBodyCheck, ACoordinateWithoutAnEffectOfItsOwnIsNamedAtTheStart) {
  Mistakes m;
  m.q.push_back(0.0);
  m.energy = [](OwnBody::Coordinates q) { return Stretched::right_energy(q.first(6)); };
  EXPECT_TRUE(begins(told(m), "add: body 'mine': coordinate 6 has no effect: it moves no matter"));
  m.deform = [](OwnBody::Coordinates q, const Vec3& X) -> Vec3 {
    return {q[0] + q[3] * X.x(), q[1] + q[4] * X.y(), q[2] + q[6] + q[5] * X.z()};
  };
  EXPECT_TRUE(begins(told(m), "add: body 'mine': coordinates 2 and 6 have no effects of their own"));
}

TEST(OwnBodyCheck, AMotionOfNoMatterThatForcesResistIsNotLost) {
  Eigen::MatrixXd M = Eigen::Vector3d(2.0, 3e-12, 0.0).asDiagonal(), K = Eigen::MatrixXd::Zero(3, 3);
  EXPECT_EQ(lost_coordinates(M, K), std::vector<Eigen::Index>{2});
  K(2, 2) = -1.0;
  EXPECT_TRUE(lost_coordinates(M, K).empty());
  // Two that do the same, in units a million apart: J = (1, 1e6).
  M = (Eigen::Matrix2d() << 1.0, 1e6, 1e6, 1e12).finished();
  EXPECT_EQ(lost_coordinates(M, Eigen::MatrixXd::Zero(2, 2)), (std::vector<Eigen::Index>{0, 1}));
}

TEST(OwnBodyCheck, WhatTheAuthorRaisesOrGivesWronglyNamesBodyFunctionTimeAndCoordinates) {
  const std::string end = ", at 0 s and q = (0, 0, 0.35, 1, 1, 1)";
  Mistakes m;
  m.force = [](OwnBody::Coordinates) -> Eigen::VectorXd { return Eigen::VectorXd::Zero(5); };
  EXPECT_EQ(told(m), "add: body 'mine': energy_force(q) gave 5 numbers; must be 6, one for each coordinate" + end);
  m.force = [](OwnBody::Coordinates) -> Eigen::VectorXd { return Eigen::VectorXd::Constant(6, kNan); };
  EXPECT_EQ(told(m), "add: body 'mine': energy_force(q) gave nan for coordinate 0; must be finite" + end);
  m.force = [](OwnBody::Coordinates) -> Eigen::VectorXd { throw std::runtime_error("my solver diverged"); };
  EXPECT_EQ(told(m), "add: body 'mine': energy_force(q) raised \"my solver diverged\"" + end);
  m = {};
  m.deform = [](OwnBody::Coordinates, const Vec3&) -> Vec3 { return {kNan, 0, 0}; };
  EXPECT_TRUE(begins(told(m), "add: body 'mine': deform(q, X) gave (nan, 0, 0) for X = ("));
  m = {};
  m.inverse = [](OwnBody::Coordinates, const Vec3&) -> Vec3 { throw std::out_of_range("no cell"); };
  EXPECT_TRUE(begins(told(m), "add: body 'mine': inverse_deform(q, x) raised \"no cell\", at 0 s"));
  m = {};
  m.distance = [](OwnBody::Coordinates, const Vec3&) { return kNan; };
  EXPECT_TRUE(begins(told(m), "add: body 'mine': distance(q, x) gave nan for x = ("));
}

TEST(OwnBodyCheck, AnEnergyThatFailsLaterNamesTheTime) {
  Mistakes m;
  m.energy = [](OwnBody::Coordinates q) { return q[2] < 0.34 ? kNan : Stretched::right_energy(q); };
  World world;
  world.add(std::make_unique<Stretched>(m));
  std::string text;
  for (int s = 0; s < 20 && text.empty(); ++s) {
    try {
      world.step();
    } catch (const InputError& e) {
      text = e.what();
    }
  }
  EXPECT_TRUE(begins(text, "body 'mine': energy(q) gave nan; must be finite, at 0.0")) << text;
}

}  // namespace
}  // namespace brim::own_body_check_test
