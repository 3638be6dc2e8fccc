#include "brim/body/mass_spring/mass_spring_body.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/tet_lattice.h"
#include "brim/world/world.h"
#include "support/implicit.h"
#include "support/particle_laws.h"

namespace brim::mass_spring_body_test {
namespace {

using testing::flat;

constexpr unsigned kSeed = 51;

MassSpringOptions options(double stiffness = 100.0) {
  MassSpringOptions o;
  o.density = 1.0;
  o.stiffness = stiffness;
  return o;
}

/// Equilateral triangles of side a in n rows of n, without a straight rim.
TriMesh equilateral(int n, double a) {
  TriMesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) mesh.vertices.emplace_back(a * (i + 0.5 * j), a * j * std::sqrt(0.75), 0.0);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const std::int32_t v = i + (n + 1) * j;
      mesh.triangles.push_back({v, v + 1, v + n + 1});
      mesh.triangles.push_back({v + 1, v + n + 2, v + n + 1});
    }
  return mesh;
}

std::vector<std::unique_ptr<MassSpringBody>> one_of_each() {
  std::vector<std::unique_ptr<MassSpringBody>> all;
  all.push_back(std::make_unique<MassSpringBody>(testing::block(3, 2, 2, 0.2), options()));
  all.push_back(std::make_unique<MassSpringBody>(shapes::grid(5, 4, 0.6, 0.4), options()));
  all.push_back(std::make_unique<MassSpringBody>(square_net(5, 4, 0.6, 0.4), options()));
  MassSpringOptions slack = options();
  slack.slack = true;
  all.push_back(std::make_unique<MassSpringBody>(square_net(5, 4, 0.6, 0.4), slack));
  return all;
}

std::vector<double> deformed(const ParticleBody& body, double amount, double stretch = 1.0) {
  testing::Noise noise(kSeed);
  const Mat3 R = Eigen::AngleAxisd(1.0, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  std::vector<Vec3> x;
  for (const Vec3& p : body.rest_positions())
    x.push_back(R * (stretch * p + amount * (0.05 * noise.vec() + Vec3(p.y() * p.y(), 0, p.x() * p.x()))));
  return flat(x);
}

TEST(MassSpringBody, OneStretchedStringByHand) {
  // 2 m of string, EA = 100 N, 0.5 kg/m, drawn out to 3 m: tension 100 · 1/2, energy ½ · 50 · 1².
  MassSpringOptions o = options(100.0);
  o.density = 0.5;
  MassSpringBody body(LineMesh{{{0, 0, 0}, {2, 0, 0}}, {{0, 1}}}, o);
  EXPECT_EQ(body.masses()[0], 0.5);
  testing::set(body, {0, 0, 0, 0, 3, 0});
  EXPECT_NEAR((body.inner_forces()[0] - Vec3(0, 50, 0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(body.elastic_energy(), 25.0, 1e-12);
  // Along the string k = 50; across it tension over length, 50/3.
  std::vector<double> y(6, 0.0);
  body.apply_stiffness(std::vector<double>{1, 1, 0, 0, 0, 0}, y);
  EXPECT_NEAR(y[0], -50.0 / 3.0, testing::kSingle * 50.0);
  EXPECT_NEAR(y[1], -50.0, testing::kSingle * 50.0);
  EXPECT_NEAR(y[4], 50.0, testing::kSingle * 50.0);
}

TEST(MassSpringBody, SlackStringsDoNotPush) {
  MassSpringOptions o = options();
  o.slack = true;
  MassSpringBody body(LineMesh{{{0, 0, 0}, {2, 0, 0}}, {{0, 1}}}, o);
  testing::set(body, {0, 0, 0, 1, 0, 0});
  EXPECT_EQ(body.elastic_energy(), 0.0);
  EXPECT_EQ(body.inner_forces()[0], Vec3::Zero());
  testing::set(body, {0, 0, 0, 2.5, 0, 0});
  EXPECT_GT(body.inner_forces()[0].x(), 0.0);
}

TEST(MassSpringBody, ForcesAreMinusTheDerivativeOfEnergy) {
  for (const auto& body : one_of_each())
    testing::expect_force_is_minus_energy_gradient(*body, deformed(*body, 1.0), 1e-7, 1e-6, kSeed);
}

TEST(MassSpringBody, StiffnessIsTheDerivativeOfForcesInTension) {
  for (const auto& body : one_of_each())
    testing::expect_stiffness_is_force_derivative(*body, deformed(*body, 0.05, 1.3), 1e-7, 1e-6, kSeed);
}

TEST(MassSpringBody, StiffnessIsSymmetricAndDefiniteAlsoWhenCompressed) {
  for (const auto& body : one_of_each()) {
    testing::expect_stiffness_is_symmetric_and_definite(*body, deformed(*body, 1.0, 0.6), kSeed);
    testing::expect_stiffness_is_symmetric_and_definite(*body, deformed(*body, 10.0), kSeed);
  }
}

TEST(MassSpringBody, InnerForcesHaveNoResultantAndNoTorque) {
  for (const auto& body : one_of_each()) testing::expect_inner_forces_balance(*body, deformed(*body, 1.0));
}

TEST(MassSpringBody, RigidMotionMakesNoForce) {
  for (const auto& body : one_of_each()) testing::expect_rigid_motion_makes_no_force(*body, Mat3::Identity());
}

TEST(MassSpringBody, SystemIsMassDampingAndStiffnessComposed) {
  MassSpringOptions o = options();
  o.stiffness_damping = 0.02, o.mass_damping = 0.3;
  MassSpringBody body(shapes::grid(5, 4, 0.6, 0.4), o);
  testing::set(body, deformed(body, 1.0));
  const double dt = 0.01;
  body.begin_solve(dt);
  testing::Noise noise(kSeed);
  std::vector<double> x(body.v_size()), A(x.size(), 0.0), M(x.size(), 0.0), K(x.size(), 0.0), C(x.size(), 0.0);
  for (double& e : x) e = noise();
  body.apply_system(x, A);
  body.apply_mass(x, M), body.apply_stiffness(x, K), body.apply_damping(x, C);
  double size = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) size = std::max(size, std::abs(dt * C[i]) + std::abs(dt * dt * K[i]));
  for (std::size_t i = 0; i < x.size(); ++i)
    EXPECT_NEAR(A[i], M[i] - dt * C[i] - dt * dt * K[i], testing::kSingle * size);
  // The diagonal blocks are those of the operator.
  BlockDiagonal D;
  D.reset(body.block_sizes());
  body.add_system_diagonal(0, D);
  for (const std::size_t i : {0u, 7u, 20u})
    for (int c = 0; c < 3; ++c) {
      std::vector<double> e(x.size(), 0.0), y(x.size(), 0.0);
      e[3 * i + c] = 1.0;
      body.apply_system(e, y);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(D.block(i)(k, c), y[3 * i + k], 1e-13);
    }
}

TEST(MassSpringBody, DampingDoesNotBrakeTheSpinOfAStretchedBody) {
  // A taut net that spins: the Rayleigh damping of the whole stiffness would take its spin, that of the strain does
  // not.
  MassSpringOptions o = options(1000.0);
  o.stiffness_damping = 0.1;
  MassSpringBody body(shapes::grid(5, 4, 0.6, 0.4), o);
  std::vector<double> q = deformed(body, 0.2, 1.5), v(q.size());
  testing::Noise noise(kSeed);
  const Vec3 spin(1, 2, -3);
  for (std::size_t i = 0; i < body.particle_count(); ++i) {
    const Vec3 x(q[3 * i], q[3 * i + 1], q[3 * i + 2]), u = spin.cross(x) + noise.vec();
    v[3 * i] = u.x(), v[3 * i + 1] = u.y(), v[3 * i + 2] = u.z();
  }
  body.update(0.0, q, v);
  std::vector<double> Q(q.size(), 0.0);
  body.apply_damping(v, Q);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double size = 0.0, power = 0.0;
  for (std::size_t i = 0; i < body.particle_count(); ++i) {
    const Vec3 f(Q[3 * i], Q[3 * i + 1], Q[3 * i + 2]);
    force += f, torque += body.positions()[i].cross(f), size += f.norm();
  }
  for (std::size_t i = 0; i < Q.size(); ++i) power += Q[i] * v[i];
  EXPECT_GT(size, 1.0);
  EXPECT_LT(power, 0.0);
  EXPECT_LT(force.norm(), 1e-12 * size);
  // Blocks are single: torque is zero but for their rounding, which finish_step gives back (spin_test).
  EXPECT_LT(torque.norm(), std::numeric_limits<float>::epsilon() * size);
}

TEST(MassSpringBody, DampingActsInFreeFlightToo) {
  // A stretched sheet swings against itself; keep_energy goes ahead of the next update.
  const auto energy_left = [](double damping) {
    MassSpringOptions o = options(20.0);
    o.stiffness_damping = damping;
    World w([] {
      WorldOptions options;
      options.time_step = 0.001, options.environment.gravity.setZero();
      return options;
    }());
    auto body = std::make_unique<MassSpringBody>(shapes::grid(5, 4, 0.6, 0.4), o);
    body->set_name("sheet");
    const std::vector<double> q = deformed(*body, 0.0, 1.2);
    w.add(std::move(body));
    State start = w.state();
    start.q = q;
    w.set_state(start);
    const auto energy = [](const StepReport& r) { return r.kinetic_energy + r.potential_energy; };
    const double before = energy(w.present());
    StepReport last;
    for (int i = 0; i < 40; ++i) last = w.step();
    return energy(last) / before;
  };
  EXPECT_LT(energy_left(0.05), 0.6 * energy_left(0.0));
}

/// Energy per measure of a uniform small strain.
double energy_density(MassSpringBody& body, const Mat3& strain, double measure) {
  std::vector<Vec3> x;
  for (const Vec3& p : body.rest_positions()) x.push_back(p + strain * p);
  testing::set(body, flat(x));
  return body.elastic_energy() / measure;
}

TEST(MassSpringBody, EquilateralSheetHasTheYoungsModulusGivenAndPoissonsRatioOneThird) {
  const int n = 5;
  MassSpringBody body(equilateral(n, 0.1), options(100.0));
  const double area = 2 * n * n * std::sqrt(3.0) / 4.0 * 0.01, e = 1e-5;
  const double factor = 100.0 / (1.0 - 1.0 / 9.0);  // Y / (1 − ν²)
  Mat3 s = Mat3::Zero();
  s(0, 0) = e;
  EXPECT_NEAR(energy_density(body, s, area), 0.5 * factor * e * e, 1e-4 * factor * e * e);
  s(1, 1) = -0.5 * e;
  EXPECT_NEAR(energy_density(body, s, area), 0.5 * factor * e * e * (1 + 0.25 - 1.0 / 3.0), 1e-4 * factor * e * e);
  s = Mat3::Zero();
  s(0, 1) = s(1, 0) = e;  // shear 2e, G = Y / (2 (1 + ν))
  EXPECT_NEAR(energy_density(body, s, area), 2.0 * 100.0 / (2 * (4.0 / 3.0)) * e * e, 1e-4 * factor * e * e);
}

TEST(MassSpringBody, LatticeSolidHasPoissonsRatioOneQuarterAndNearlyTheYoungsModulusGiven) {
  // Uniform strains of a body-centred lattice: c_11, c_12 and c_44 by energy, axes along the lattice.
  const TetMesh mesh = tet_lattice(shapes::box(Vec3(1, 1, 1), 4), 0.25);
  double volume = 0.0;
  for (const Tetrahedron& t : mesh.tets) {
    const auto& x = mesh.vertices;
    volume += (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).dot(x[t[3]] - x[t[0]]) / 6.0;
  }
  MassSpringBody body(mesh, options(100.0));
  const double e = 1e-5;
  const auto density = [&](double xx, double yy, double xy) {
    Mat3 s = Mat3::Zero();
    s(0, 0) = xx * e, s(1, 1) = yy * e, s(0, 1) = s(1, 0) = xy * e;
    return 2.0 * energy_density(body, s, volume) / (e * e);
  };
  const double c11 = density(1, 0, 0), c12 = 0.5 * (density(1, 1, 0) - density(1, 0, 0) - density(0, 1, 0));
  const double c44 = 0.25 * density(0, 0, 1);
  const double young = c11 - 2 * c12 * c12 / (c11 + c12), poisson = c12 / (c11 + c12);
  RecordProperty("young_over_Y", fmt::format("{:.3f}", young / 100.0));
  RecordProperty("poisson", fmt::format("{:.3f}", poisson));
  RecordProperty("shear_anisotropy", fmt::format("{:.3f}", 2 * c44 / (c11 - c12)));
  // Central forces at rest: Cauchy's relation, up to rounding of the strain.
  EXPECT_NEAR(c12, c44, 1e-3 * c11);
  EXPECT_NEAR(poisson, 0.25, 0.05);
  EXPECT_NEAR(young / 100.0, 1.0, 0.35);
}

TEST(MassSpringBody, HangingStringsStretchAsRods) {
  // Elongation of a hanging string: λ g L² / (2 EA), exact for lumped masses with half a mass at the ends.
  MassSpringOptions o = options(50.0);
  o.density = 0.3;
  LineMesh line;
  const int n = 10;
  for (int i = 0; i <= n; ++i) {
    line.vertices.emplace_back(0, 0, -2.0 * i / n);
    if (i < n) line.lines.push_back({i, i + 1});
  }
  o.fixed = {0};
  MassSpringBody body(line, o);
  testing::Stepper stepper(body);
  stepper.relax(4, Environment{});
  EXPECT_NEAR(-2.0 - stepper.position(n).z(), 0.3 * 9.81 * 4 / (2 * 50.0), 1e-8);
}

TEST(MassSpringBody, ThreadsDoNotChangeABit) {
  MassSpringBody body(testing::block(8, 8, 8, 0.1), options());
  const std::vector<double> q = deformed(body, 1.0);
  std::vector<double> force, product;
  for (const int threads : {1, 2, 4}) {
    ThreadLimit limit(threads);
    testing::set(body, q);
    body.begin_solve(0.01);
    std::vector<double> y(q.size(), 0.0);
    body.apply_system(q, y);
    if (force.empty()) force = flat(body.inner_forces()), product = y;
    EXPECT_EQ(flat(body.inner_forces()), force);
    EXPECT_EQ(y, product);
  }
}

TEST(MassSpringBody, BadInputIsRefusedWithAMessage) {
  EXPECT_THROW(MassSpringBody(TriMesh{}, options()), InputError);
  EXPECT_THROW(MassSpringBody(LineMesh{{{0, 0, 0}, {0, 0, 0}}, {{0, 1}}}, options()), InputError);
  EXPECT_THROW(MassSpringBody(LineMesh{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1}}}, options()), InputError);
  EXPECT_THROW(MassSpringBody(LineMesh{{{0, 0, 0}, {1, 0, 0}}, {{0, 5}}}, options()), InputError);
  TriMesh flat_triangle{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}};
  EXPECT_THROW(MassSpringBody(flat_triangle, options()), InputError);
  TetMesh inverted = testing::block(1, 1, 1, 1.0);
  std::swap(inverted.tets[0][0], inverted.tets[0][1]);
  EXPECT_THROW(MassSpringBody(inverted, options()), InputError);
  MassSpringOptions o = options(-1.0);
  EXPECT_THROW(MassSpringBody(square_net(1, 1, 1, 1), o), InputError);
  o = options(), o.density = 0;
  EXPECT_THROW(MassSpringBody(square_net(1, 1, 1, 1), o), InputError);
  o = options(), o.thickness = 0;
  EXPECT_THROW(MassSpringBody(square_net(1, 1, 1, 1), o), InputError);
  EXPECT_THROW(square_net(0, 1, 1, 1), InputError);
  EXPECT_THROW(square_net(1, 1, 1, -1), InputError);
}

}  // namespace
}  // namespace brim::mass_spring_body_test
