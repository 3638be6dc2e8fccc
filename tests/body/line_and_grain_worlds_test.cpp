#include <gtest/gtest.h>

#include <numbers>

#include "brim/body/cloth/cloth_body.h"
#include "brim/body/fem/fem_body.h"
#include "brim/body/mass_spring/mass_spring_body.h"
#include "brim/body/points/points_body.h"
#include "brim/body/rod/rod_body.h"
#include "brim/core/error.h"
#include "brim/mesh/primitives.h"
#include "support/solids.h"
#include "support/worlds.h"

/// Springs, rods and grains against obstacles, rigid bodies, cloth and elements: small worlds.
namespace brim::line_and_grain_worlds_test {
namespace {

using testing::ground;
using testing::options_at;
using testing::position;

/// What a run was at its worst, and its last report.
struct Watched {
  double overlap = 0.0, linear = 0.0, angular = 0.0;
  StepReport last;
};

Watched watch(World& w, double seconds) {
  Watched out;
  const int steps = static_cast<int>(seconds / w.options().time_step + 0.5);
  for (int s = 0; s < steps; ++s) {
    out.last = w.step();
    EXPECT_TRUE(out.last.ok);
    out.overlap = std::max(out.overlap, out.last.worst_overlap);
    out.linear = std::max(out.linear, out.last.momentum_error);
    out.angular = std::max(out.angular, out.last.angular_error);
  }
  return out;
}

template <class B, class... Args>
std::unique_ptr<Body> named(std::string name, Args&&... args) {
  auto b = std::make_unique<B>(std::forward<Args>(args)...);
  b->set_name(std::move(name));
  return b;
}

/// Lowest particle of a body, [m].
double lowest(const World& w, int body) {
  double z = std::numeric_limits<double>::infinity();
  for (std::size_t i = 2; i < w.q(body).size(); i += 3) z = std::min(z, w.q(body)[i]);
  return z;
}

double fastest(const World& w, int body) {
  double most = 0.0;
  for (std::size_t i = 0; i + 2 < w.v(body).size(); i += velocities_per_node(w.body(body)))
    most = std::max(most, Vec3(w.v(body)[i], w.v(body)[i + 1], w.v(body)[i + 2]).norm());
  return most;
}

/// Sum of contact forces on the ground, body 0, upwards on what stands on it, [N].
double carried(const StepReport& r) {
  double z = 0.0;
  for (const PairReport& p : r.pairs)
    if (p.part_a == 0) z -= p.force_on_a.z();
  return z;
}

TEST(MassSpringWorld, ANetHeldAtItsCornersCatchesABall) {
  World w(options_at(0.05));
  MassSpringOptions o;
  o.density = 0.2, o.stiffness = 2000, o.thickness = 0.1, o.slack = true, o.stiffness_damping = 0.01;
  const int n = 8, row = n + 1;
  o.fixed = {0, n, n * row, n * row + n};
  const int net = w.add(named<MassSpringBody>("net", square_net(n, n, 1.6, 1.6), o));
  const int ball = w.add(testing::ball("ball", {Vec3(0.05, 0.02, 0.5)}, 0.5, 0.25, 100.0));
  const Watched run = watch(w, 2.0);
  EXPECT_GT(position(w, ball).z(), -1.0);
  EXPECT_GT(position(w, ball).z(), lowest(w, net));
  EXPECT_LT(run.overlap, 1.0);
  EXPECT_LT(run.linear, 1e-12);
  RecordProperty("angular_error", fmt::format("{:.1e}", run.angular));
}

TEST(MassSpringWorld, ASolidRestsOnTheGroundWithItsWeight) {
  World w(options_at(0.05));
  w.add(ground(0.5));
  MassSpringOptions o;
  o.density = 500, o.stiffness = 2e5, o.stiffness_damping = 0.02;
  TetMesh block = testing::block(4, 4, 3, 0.1);
  for (Vec3& x : block.vertices) x += Vec3(-0.2, -0.2, 0.01);
  w.add(named<MassSpringBody>("block", block, o));
  const Watched run = watch(w, 1.5);
  EXPECT_LT(run.linear, 1e-12);
  EXPECT_LT(run.angular, 1e-10);
  EXPECT_NEAR(carried(run.last), 500 * 0.048 * 9.81, 0.02 * 500 * 0.048 * 9.81);
  EXPECT_LT(fastest(w, 1), 0.01);
  EXPECT_NEAR(lowest(w, 1), 0.0, 0.01);
}

TEST(MassSpringWorld, ASheetDrapesOnAnElasticBlock) {
  World w(options_at(0.05));
  w.add(ground(0.5));
  TetMesh block = testing::block(4, 4, 3, 0.1);
  for (Vec3& x : block.vertices) x += Vec3(-0.2, -0.2, 0.0);
  FemOptions f;
  f.young = 2e5, f.stiffness_damping = 0.02;
  w.add(named<FemBody>("block", block, f));
  MassSpringOptions o;
  o.density = 0.5, o.stiffness = 500, o.thickness = 0.1, o.stiffness_damping = 0.01;
  TriMesh sheet = shapes::grid(10, 10, 0.8, 0.8);
  for (Vec3& x : sheet.vertices) x.z() = 0.4;
  const int cloth = w.add(named<MassSpringBody>("sheet", sheet, o));
  const Watched run = watch(w, 1.0);
  EXPECT_LT(run.linear, 1e-12);
  EXPECT_LT(run.angular, 1e-10);
  EXPECT_GT(w.q(cloth)[3 * 60 + 2], 0.3) << "its middle lies on the block";
  EXPECT_LT(w.q(cloth)[2], 0.3) << "its corner hangs";
}

std::vector<Vec3> line(const Vec3& a, const Vec3& b, int segments) {
  std::vector<Vec3> x;
  for (int i = 0; i <= segments; ++i) x.push_back(a + (b - a) * (double(i) / segments));
  return x;
}

TEST(RodWorld, ARopeThatFallsOnTheGroundComesToRestOnIt) {
  World w(options_at(0.04));
  w.add(ground(0.5));
  RodOptions o;
  o.radius = 0.04, o.linear_density = 0.5, o.stretch = 5e3, o.bending = 0.01, o.rests_straight = true;
  o.stiffness_damping = 0.01;
  const int rope = w.add(named<RodBody>("rope", line(Vec3(0, 0, 0.08), Vec3(1, 0.2, 0.5), 14), o));
  const Watched run = watch(w, 2.0);
  EXPECT_LT(run.linear, 1e-12);
  EXPECT_NEAR(carried(run.last), 0.5 * std::sqrt(1 + 0.04 + 0.42 * 0.42) * 9.81, 0.15);
  EXPECT_NEAR(lowest(w, rope), 0.04, 0.01);
  EXPECT_LT(fastest(w, rope), 0.02);
}

/// A rod above a ball that flies up to it, without friction, the rod's axis beside the ball's centre by `aside` [m].
/// @return the worst angular error: torque about the rod itself, which it has no coordinate for
double lost_torque(double aside) {
  World w(options_at(0.05));
  RodOptions o;
  o.radius = 0.05, o.linear_density = 1.0, o.stretch = 5e3, o.bending = 0.1;
  o.material.friction = 0.0;
  w.add(named<RodBody>("rod", line(Vec3(-0.6, aside, 0.32), Vec3(0.6, aside, 0.28), 8), o));
  w.add(testing::ball("ball", {Vec3(0, 0, 0), Quat::Identity(), Vec3(0, 0, 1)}, 0.0, 0.25, 50.0));
  // While the ball presses: what grazes later has next to no force to compare with.
  const Watched run = watch(w, 0.25);
  EXPECT_LT(run.linear, 1e-12);
  EXPECT_LT(run.overlap, 1.0);
  return run.angular;
}

TEST(RodWorld, OnlyTorqueAboutTheRodItselfIsLost) {
  // Pressure straight under the axis has none. Beside it, it has some: the normal is smoothed over voxels.
  const double centred = lost_torque(0.0), beside = lost_torque(0.03);
  RecordProperty("centred", fmt::format("{:.1e}", centred));
  RecordProperty("beside", fmt::format("{:.1e}", beside));
  EXPECT_LT(centred, 1e-5) << "as symmetric as the solver's tolerance";
  EXPECT_GT(beside, 1e-3) << "if this is exact now, say so in docs/bodies/rod.md";
}

/// A rope over a fixed cylinder, its ends hanging down by a and b. @return how far the longer end sank, [m]
double slip_over_a_post(double mu, double a, double b, double seconds = 1.0) {
  World w(options_at(0.03));
  const Quat along_y(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX()));
  w.add(testing::obstacle("post", make_capsule(0.2, 0.6), mu, Vec3::Zero(), along_y));
  RodOptions o;
  o.radius = 0.03, o.linear_density = 0.5, o.stretch = 2e4, o.bending = 0.0, o.rests_straight = true;
  o.stiffness_damping = 0.01;
  o.material.friction = mu;
  const double R = 0.23;
  std::vector<Vec3> x;
  const int na = static_cast<int>(a / 0.06), nb = static_cast<int>(b / 0.06), arc = 12;
  for (int i = na; i > 0; --i) x.emplace_back(-R, 0, -a * i / na);
  for (int i = 0; i <= arc; ++i) {
    const double t = std::numbers::pi * (1.0 - double(i) / arc);
    x.emplace_back(R * std::cos(t), 0, R * std::sin(t));
  }
  for (int i = 1; i <= nb; ++i) x.emplace_back(R, 0, -b * i / nb);
  const int rope = w.add(named<RodBody>("rope", x, o));
  watch(w, seconds);
  return -b - w.q(rope)[3 * x.size() - 1];
}

TEST(RodWorld, ARopeOverAPostHoldsAndSlipsAsTheCapstanSays) {
  // dT/dφ = μ r/R (T + λ R g sin φ) + λ R g cos φ: friction acts at the post's face, at r = 0.2 m, and tension at the
  // rope's axis, at R = 0.23 m. Friction 0.3 over half a turn then holds 2.88 to 1 where the shorter end is 0.6 m.
  const double holds = slip_over_a_post(0.3, 0.6, 0.95 * 2.88 * 0.6),
               slips = slip_over_a_post(0.3, 0.6, 1.15 * 2.88 * 0.6);
  RecordProperty("slip_5_percent_below", fmt::format("{:.4f}", holds));
  RecordProperty("slip_15_percent_above", fmt::format("{:.4f}", slips));
  EXPECT_LT(std::abs(holds), 0.02);
  EXPECT_GT(slips, 0.1);
}

TEST(RodWorld, TensionThatTurnsAroundAPostDoesNotBrake) {
  // Without friction, x'' = 2 g x / L about the place where both ends hang alike. At 1/60 s the rope moves by up to a
  // tenth of the post's radius in a step, off along its tangents, which takes a few per cent; turned with the rope but
  // not with the post, its tension took 30.
  const double a = 0.42, b = 1.62, L = a + b + 0.23 * std::numbers::pi, t = 0.3;
  const double sunk = 0.5 * (b - a) * (std::cosh(std::sqrt(2.0 * 9.81 / L) * t) - 1.0);
  const double found = slip_over_a_post(0.0, a, b, t);
  RecordProperty("over_theory", fmt::format("{:.4f}", found / sunk));
  EXPECT_GT(found, 0.9 * sunk);
  EXPECT_LT(found, 1.05 * sunk);
}

PointsOptions grains() {
  PointsOptions o;
  o.radius = {0.05};
  o.density = 1000;
  o.young = 1e6;
  o.stiffness_damping = 2.0 / 60.0;
  o.slip_speed = 1e-3 * 9.81 / 60.0;
  return o;
}

std::vector<Vec3> lattice(int nx, int ny, int nz, const Vec3& first, double spacing) {
  testing::Noise noise(5);
  std::vector<Vec3> x;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) x.push_back(first + spacing * Vec3(i, j, k) + 0.01 * noise.vec());
  return x;
}

TEST(PointsWorld, AGrainLiesStillOnAnother) {
  for (const double young : {1e5, 1e6, 1e7}) {
    World w(options_at(0.05 / 1.5));
    w.add(ground(0.6));
    PointsOptions o = grains();
    o.young = young;
    const int pair = w.add(named<PointsBody>("pair", std::vector<Vec3>{{0, 0, 0.055}, {0.003, 0.001, 0.17}}, o));
    watch(w, 1.5);
    EXPECT_LT(fastest(w, pair), 1e-3) << young;
    EXPECT_NEAR(w.q(pair)[5] - w.q(pair)[2], 0.1, 2e-3) << young;
  }
}

TEST(PointsWorld, AHeapStandsOnTheGround) {
  World w(options_at(0.05 / 1.5));
  w.add(ground(0.6));
  PointsOptions o = grains();
  o.turn = false;  // those that roll lie a little flatter
  o.friction = 0.6, o.material.friction = 0.6;
  const auto x = lattice(3, 3, 6, Vec3(-0.11, -0.11, 0.07), 0.112);
  const int heap = w.add(named<PointsBody>("heap", x, o));
  const Watched run = watch(w, 3.0);
  const auto& body = dynamic_cast<const PointsBody&>(w.body(heap));
  double highest = 0.0;
  for (std::size_t i = 2; i < w.q(heap).size(); i += 3) highest = std::max(highest, w.q(heap)[i]);
  RecordProperty("highest", fmt::format("{:.3f}", highest));
  RecordProperty("fastest", fmt::format("{:.1e}", fastest(w, heap)));
  RecordProperty("overlap", fmt::format("{:.1e}", body.pairs().worst_overlap()));
  EXPECT_GT(highest, 0.18) << "grains lie on grains";
  EXPECT_LT(fastest(w, heap), 0.02);
  EXPECT_LT(body.pairs().worst_overlap(), 0.05);
  EXPECT_GT(lowest(w, heap), 0.04);
  const double weight = 54 * 1000 * 4.0 / 3 * std::numbers::pi * 0.05 * 0.05 * 0.05 * 9.81;
  EXPECT_NEAR(carried(run.last), weight, 0.03 * weight);
  EXPECT_LT(run.linear, 1e-12);
}

TEST(PointsWorld, GrainsLieInAHeldClothAndPushARigidBoxAside) {
  World w(options_at(0.05 / 1.5));
  ClothOptions c;
  c.thickness = 0.07, c.areal_density = 0.5, c.membrane.young = 3000, c.stiffness_damping = 0.01;
  const TriMesh sheet = shapes::grid(10, 10, 1.0, 1.0);
  c.fixed = {0, 10, 110, 120};
  w.add(named<ClothBody>("cloth", sheet, c));
  const int heap = w.add(named<PointsBody>("grains", lattice(4, 4, 2, Vec3(-0.17, -0.17, 0.12), 0.112), grains()));
  const int box = w.add(testing::box("box", {Vec3(0, 0, 0.55)}, 0.5, 0.2, 300));
  const Watched run = watch(w, 2.0);
  EXPECT_LT(run.linear, 1e-12);
  EXPECT_GT(lowest(w, heap), lowest(w, 0)) << "no grain passes the cloth";
  EXPECT_GT(position(w, box).z(), lowest(w, heap));
  EXPECT_LT(fastest(w, heap), 0.5);
}

}  // namespace
}  // namespace brim::line_and_grain_worlds_test
