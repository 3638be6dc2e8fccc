#include "brim/body/fem/fem_body.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "brim/core/error.h"
#include "brim/raster/raster_tets.h"
#include "support/implicit.h"
#include "support/particle_laws.h"
#include "support/tiles.h"

namespace brim::fem_body_test {
namespace {

using testing::flat;

constexpr unsigned kSeed = 31;
constexpr ElasticLaw kLaws[] = {ElasticLaw::CorotationalLinear, ElasticLaw::StableNeoHookean};

FemOptions options(ElasticLaw law, double young = 1e4, double poisson = 0.3) {
  FemOptions o;
  o.law = law;
  o.young = young;
  o.poisson = poisson;
  return o;
}

/// Rest shape bent, turned and shaken by about `amount` of a cell.
std::vector<double> deformed(const FemBody& body, double amount) {
  testing::Noise noise(kSeed);
  const Mat3 R = Eigen::AngleAxisd(1.0, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  std::vector<Vec3> x;
  for (const Vec3& p : body.rest_positions())
    x.push_back(R * (p + amount * 0.1 * noise.vec() + amount * Vec3(p.y() * p.z(), 0, p.x() * p.x())));
  return flat(x);
}

/// Rest shape stretched everywhere, where both laws are convex enough that projection changes nothing.
std::vector<double> stretched(const FemBody& body) {
  testing::Noise noise(kSeed);
  std::vector<Vec3> x;
  for (const Vec3& p : body.rest_positions()) x.push_back(1.15 * p + 0.001 * noise.vec());
  return flat(x);
}

TEST(FemBody, ForcesAreMinusTheDerivativeOfEnergy) {
  for (const ElasticLaw law : kLaws) {
    FemBody body(testing::block(2, 3, 2, 0.1), options(law));
    testing::expect_force_is_minus_energy_gradient(body, deformed(body, 0.6), 1e-7, 1e-6, kSeed);
  }
}

TEST(FemBody, StiffnessIsTheDerivativeOfForcesWhereNothingIsProjected) {
  for (const ElasticLaw law : kLaws) {
    FemBody body(testing::block(2, 3, 2, 0.1), options(law));
    testing::expect_stiffness_is_force_derivative(body, stretched(body), 1e-7, 1e-6, kSeed);
  }
}

/// A matrix with room for the blocks of the elements, which know their places in it.
BlockMatrix matrix_of(TetElements& elements, std::size_t nodes) {
  BlockMatrix K;
  K.begin(nodes);
  K.add_elements(elements.nodes(), 4);
  K.finish();
  elements.find_pairs(K);
  return K;
}

TEST(FemBody, UnprojectedStiffnessIsTheDerivativeOfForcesAnywhere) {
  const TetMesh mesh = testing::block(2, 2, 2, 0.1);
  for (const ElasticLaw law : kLaws) {
    FemBody body(mesh, options(law));
    TetElements elements(mesh, law, Lame::from(1e4, 0.3));
    BlockMatrix K = matrix_of(elements, mesh.vertices.size());
    const std::vector<double> q = deformed(body, 1.0);
    const auto forces = [&](const std::vector<double>& at, BlockMatrix& matrix) {
      std::vector<Vec3> x(mesh.vertices.size()), f(x.size(), Vec3::Zero());
      for (std::size_t i = 0; i < x.size(); ++i) x[i] = Vec3(at[3 * i], at[3 * i + 1], at[3 * i + 2]);
      matrix.set_zero();
      elements.add(x, f, matrix, false);
      matrix.close();
      return flat(f);
    };
    testing::Noise noise(kSeed);
    std::vector<double> d(q.size()), Kd(q.size(), 0.0), none(q.size() / 3, 0.0);
    for (double& e : d) e = noise();
    auto plus = q, minus = q;
    const double step = 1e-7;
    for (std::size_t i = 0; i < q.size(); ++i) plus[i] += step * d[i], minus[i] -= step * d[i];
    BlockMatrix scratch = K;
    const auto up = forces(plus, scratch), down = forces(minus, scratch);
    forces(q, K);
    K.multiply_add(-1.0, 0.0, none, d, Kd);
    double error = 0, size = 0;
    for (std::size_t i = 0; i < q.size(); ++i) {
      error += std::pow(Kd[i] - (up[i] - down[i]) / (2 * step), 2);
      size += Kd[i] * Kd[i];
    }
    EXPECT_LT(std::sqrt(error / size), 1e-6);
  }
}

TEST(FemBody, EnergyThatComesWithTheForcesIsThatOfTheState) {
  const TetMesh mesh = testing::block(2, 3, 2, 0.1);
  for (const ElasticLaw law : kLaws) {
    const FemBody body(mesh, options(law));
    TetElements elements(mesh, law, Lame::from(1e4, 0.3));
    BlockMatrix K = matrix_of(elements, mesh.vertices.size());
    for (const double turned : {0.3, 3.0}) {  // the second turns elements inside out
      const std::vector<double> q = deformed(body, turned);
      std::vector<Vec3> x(mesh.vertices.size()), f(x.size(), Vec3::Zero());
      for (std::size_t i = 0; i < x.size(); ++i) x[i] = Vec3(q[3 * i], q[3 * i + 1], q[3 * i + 2]);
      const std::optional<double> energy = elements.add(x, f, K);
      EXPECT_EQ(energy.has_value(), gives_energy(law));
      EXPECT_EQ(energy.value_or(elements.energy(x)), elements.energy(x));
    }
  }
}

TEST(FemBody, StiffnessIsSymmetricAndDefiniteAlsoWhenInverted) {
  for (const ElasticLaw law : kLaws) {
    FemBody body(testing::block(2, 2, 2, 0.1), options(law));
    testing::expect_stiffness_is_symmetric_and_definite(body, deformed(body, 0.5), kSeed);
    testing::expect_stiffness_is_symmetric_and_definite(body, deformed(body, 10.0), kSeed);
  }
}

TEST(FemBody, InnerForcesHaveNoResultantAndNoTorque) {
  for (const ElasticLaw law : kLaws) {
    FemBody body(testing::block(2, 2, 2, 0.1), options(law));
    testing::expect_inner_forces_balance(body, deformed(body, 0.5));
    testing::expect_inner_forces_balance(body, deformed(body, 10.0));
  }
}

TEST(FemBody, RigidMotionMakesNoForce) {
  for (const ElasticLaw law : kLaws) {
    FemBody body(testing::block(3, 2, 2, 0.1), options(law));
    testing::expect_rigid_motion_makes_no_force(body);
  }
}

TEST(FemBody, UniformStrainGivesTheStressOfHooke) {
  // Patch test: with F = I + ε for any mesh, inner nodes feel nothing and E = V (µ ε:ε + λ/2 tr² ε).
  TetMesh mesh = testing::block(3, 3, 3, 0.1);
  testing::Noise noise(kSeed);
  for (int k = 1; k < 3; ++k)
    for (int j = 1; j < 3; ++j)
      for (int i = 1; i < 3; ++i) mesh.vertices[i + 4 * (j + 4 * k)] += 0.02 * noise.vec();
  FemBody body(mesh, options(ElasticLaw::CorotationalLinear));
  Mat3 strain;
  strain << 0.01, 0.004, 0, 0.004, -0.02, 0.006, 0, 0.006, 0.015;
  std::vector<Vec3> x;
  for (const Vec3& p : mesh.vertices) x.push_back(p + strain * p);
  testing::set(body, flat(x));
  const Lame lame = Lame::from(1e4, 0.3);
  const double density = lame.mu * strain.squaredNorm() + 0.5 * lame.lambda * std::pow(strain.trace(), 2);
  EXPECT_NEAR(body.elastic_energy(), 0.027 * density, 1e-12 * density);
  const Mat3 stress = 2 * lame.mu * strain + lame.lambda * strain.trace() * Mat3::Identity();
  for (int k = 1; k < 3; ++k)
    for (int j = 1; j < 3; ++j)
      for (int i = 1; i < 3; ++i) {
        EXPECT_LT(body.inner_forces()[i + 4 * (j + 4 * k)].norm(), 1e-12 * stress.norm());
      }
  // The pull along x is the virtual work of moving all nodes by (x, 0, 0).
  double work = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) work -= body.inner_forces()[i].x() * mesh.vertices[i].x();
  EXPECT_NEAR(work, 0.027 * stress(0, 0), 1e-12 * stress.norm());
}

/// Sag of the tip of a beam 5 times as long as thick under its weight, over the value of Timoshenko's beam.
double cantilever_ratio(int cells) {
  const double thick = 0.1, length = 0.5, young = 1e7, density = 1000.0, g = 0.1;
  FemOptions o = options(ElasticLaw::CorotationalLinear, young, 0.0);
  const TetMesh mesh = testing::block(5 * cells, cells, cells, thick / cells);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (mesh.vertices[i].x() < 1e-9) o.fixed.push_back(static_cast<std::int32_t>(i));
  FemBody body(mesh, o);
  testing::Stepper stepper(body);
  Environment env;
  env.gravity = Vec3(0, 0, -g);
  stepper.relax(1, env);
  double tip = 0.0, count = 0.0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (mesh.vertices[i].x() > length - 1e-9) tip += mesh.vertices[i].z() - stepper.position(i).z(), count += 1;
  tip /= count;
  const double bending = 1.5 * density * g * std::pow(length, 4) / (young * thick * thick);
  const double shear = density * g * length * length / (2.0 * (5.0 / 6.0) * 0.5 * young);
  return tip / (bending + shear);
}

TEST(FemBody, CantileverConvergesToTheBeam) {
  const double e2 = 1 - cantilever_ratio(2), e4 = 1 - cantilever_ratio(4), e8 = 1 - cantilever_ratio(8);
  RecordProperty("errors", fmt::format("{:.4f} {:.4f} {:.4f}", e2, e4, e8));
  // Second order in the cell size: linear tetrahedra are too stiff in bending, by 5 % with eight cells across.
  EXPECT_GT(e2, e4);
  EXPECT_GT(e4 / e8, 3.0);
  EXPECT_LT(std::abs(e8), 0.06);
}

TEST(FemBody, TurnedInsideOutRecovers) {
  for (const ElasticLaw law : kLaws) {
    FemOptions o = options(law, 1e4, 0.3);
    o.mass_damping = 5.0;
    FemBody body(testing::block(2, 2, 2, 0.1), o);
    testing::Stepper stepper(body);
    // The middle node is thrown far outside, inverting the tetrahedra about it.
    const std::size_t middle = 13;
    for (int a = 0; a < 3; ++a) stepper.q[3 * middle + a] += 0.25;
    body.update(0.0, stepper.q, stepper.v);
    const double start = body.elastic_energy();
    Environment env;
    env.gravity.setZero();
    for (int s = 0; s < 400; ++s) stepper.step(0.01, env);
    EXPECT_LT(body.elastic_energy(), 1e-4 * start);
    for (const auto& t : body.mesh().tets) {
      Mat3 edges;
      for (int i = 0; i < 3; ++i) edges.col(i) = stepper.position(t[i + 1]) - stepper.position(t[0]);
      EXPECT_GT(edges.determinant(), 0.0);
    }
  }
}

TEST(FemBody, FlyingFreelyKeepsLinearMomentum) {
  FemOptions o = options(ElasticLaw::StableNeoHookean);
  o.initial_velocity = Vec3(1, 2, 0);
  o.initial_spin = Vec3(0, 0, 3);
  FemBody body(testing::block(2, 2, 2, 0.1), o);
  testing::Stepper stepper(body);
  Environment env;
  env.gravity.setZero();
  const Vec3 p = body.linear_momentum(stepper.v);
  EXPECT_TRUE(p.isApprox(8.0 * Vec3(1, 2, 0)));
  for (int s = 0; s < 50; ++s) stepper.step(0.005, env);
  EXPECT_LT((body.linear_momentum(stepper.v) - p).norm(), 1e-9);
}

TEST(FemBody, ImposedNodesArriveWhereTheyMust) {
  FemOptions o = options(ElasticLaw::CorotationalLinear);
  o.fixed = {0, 1};
  o.motions.push_back(NodeMotion::constant_velocity({26}, Vec3(0, 0, 0.2)));
  FemBody body(testing::block(2, 2, 2, 0.1), o);
  testing::Stepper stepper(body);
  for (int s = 0; s < 25; ++s) stepper.step(0.01, Environment{});
  EXPECT_TRUE(stepper.position(26).isApprox(Vec3(0.2, 0.2, 0.25)));
  EXPECT_EQ(stepper.position(0), Vec3(0, 0, 0));
  EXPECT_FALSE(body.immobile());
  EXPECT_NEAR(body.mass(), 8.0, 1e-12);
}

struct MapCheck {
  double filled = 0.0;   ///< [m³] volume under the density
  std::size_t flat = 0;  ///< points whose own tetrahedron is too flat to carry them
};

/// Rigid motion plus uniform strain is linear in r: the map must give it exactly.
MapCheck expect_linear_motion_throughout_the_density(FemBody& body) {
  MapCheck check;
  const double h = 0.02, w = 3 * h;
  std::vector<TileKey> tiles;
  body.presence(0, h, w, body.bounds(0).inflated(1.0), tiles);
  std::vector<DensityBlock> blocks(tiles.size());
  body.rasterize(0, h, w, tiles, blocks);
  std::vector<Vec3> points;
  std::vector<std::int32_t> sources;
  testing::for_each_node(tiles, h, [&](std::size_t t, int n, const Vec3& r) {
    if (blocks[t].rho[n] == 0.0) return;
    points.push_back(r + 0.2 * h * Vec3::Ones());
    sources.push_back(blocks[t].source[n]);
    const int i = n % kBlockSize, j = n / kBlockSize % kBlockSize, k = n / kBlockSize / kBlockSize;
    const auto own = [](int a) { return a >= kHalo && a < kHalo + kTileSize; };
    if (own(i) && own(j) && own(k)) check.filled += blocks[t].rho[n] * h * h * h;
  });
  Mat3 L;
  L << 0.1, 2, -1, 0.3, 0.2, 0.4, 1, -2, 0.5;
  std::vector<Vec3> v;
  for (const Vec3& x : body.positions()) v.push_back(Vec3(1, 2, 3) + L * x);
  std::unique_ptr<Map> map;
  body.make_map(0, points, sources, map);
  std::vector<Vec3> u(points.size());
  map->apply(flat(v), u);
  double worst = 0.0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    worst = std::max(worst, (u[p] - Vec3(1, 2, 3) - L * points[p]).norm());
    std::array<Vec3, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = body.positions()[body.mesh().tets[sources[p]][i]];
    check.flat += tet_weight_sum(points[p], corners) > kMaxTetWeight;
  }
  EXPECT_LT(worst, 1e-11);
  return check;
}

TEST(FemBody, MapMovesPointsOfTheDensityWithTheMatterAlsoWhereElementsAreCrushed) {
  FemBody body(testing::block(3, 3, 3, 0.1), options(ElasticLaw::CorotationalLinear));
  std::vector<Vec3> x(body.rest_positions().begin(), body.rest_positions().end());
  double top = 0.0;
  for (const Vec3& p : x) top = std::max(top, p.z());
  for (Vec3& p : x)
    if (p.z() > top - 1e-9) p.z() -= 0.1 - 1e-4;
  testing::set(body, flat(x));
  EXPECT_GT(expect_linear_motion_throughout_the_density(body).flat, 100u);
}

TEST(FemBody, MapMovesPointsOfTheDensityWithTheMatter) {
  FemBody body(testing::block(3, 3, 3, 0.1), options(ElasticLaw::CorotationalLinear));
  testing::set(body, deformed(body, 0.15));
  const double filled = expect_linear_motion_throughout_the_density(body).filled;
  // The volume under the density is that of the deformed solid, but for rounded edges: with variance w²/20 of the
  // ramp, a cube of side L gains 6 L (1 + π/4) w²/20, here 2 %.
  double volume = 0.0;
  for (const auto& t : body.mesh().tets) {
    Mat3 edges;
    for (int i = 0; i < 3; ++i) edges.col(i) = body.positions()[t[i + 1]] - body.positions()[t[0]];
    volume += edges.determinant() / 6.0;
  }
  EXPECT_NEAR(filled / volume, 1.0, 0.03);
}

TEST(FemBody, FineSurfaceFollowsTheElements) {
  FemOptions o = options(ElasticLaw::CorotationalLinear);
  o.display.vertices = {{0.05, 0.05, 0.2}, {0.15, 0.05, 0.2}, {0.1, 0.15, 0.21}};
  o.display.triangles = {{0, 1, 2}};
  FemBody body(testing::block(2, 2, 2, 0.1), o);
  Mat3 L;
  L << 1.1, 0.2, 0, 0, 0.9, 0.1, 0.1, 0, 1;
  std::vector<Vec3> x;
  for (const Vec3& p : body.rest_positions()) x.push_back(L * p);
  testing::set(body, flat(x));
  ASSERT_EQ(body.display().vertices, 3u);
  std::vector<Vec3f> shown(3);
  body.display_positions(shown);
  for (int i = 0; i < 3; ++i) EXPECT_LT((shown[i].cast<double>() - L * o.display.vertices[i]).norm(), 1e-7);
}

TEST(FemBody, ThreadsDoNotChangeABit) {
  FemBody body(testing::block(9, 9, 9, 0.1), options(ElasticLaw::StableNeoHookean));
  const std::vector<double> q = deformed(body, 1.0);
  std::vector<double> force, product;
  double energy = 0.0;
  for (const int threads : {1, 2, 4}) {
    ThreadLimit limit(threads);
    testing::set(body, q);
    body.begin_solve(0.01);
    std::vector<double> y(q.size(), 0.0);
    body.apply_system(q, y);
    if (force.empty()) force = flat(body.inner_forces()), product = y, energy = body.elastic_energy();
    EXPECT_EQ(flat(body.inner_forces()), force);
    EXPECT_EQ(y, product);
    EXPECT_EQ(body.elastic_energy(), energy);
  }
}

TEST(FemBody, SystemIsTheComposedOperatorAndItsDiagonal) {
  FemOptions o = options(ElasticLaw::StableNeoHookean);
  o.mass_damping = 0.7, o.stiffness_damping = 0.02;
  FemBody body(testing::block(2, 1, 1, 0.1), o);
  testing::set(body, deformed(body, 0.5));
  body.begin_solve(0.013);
  const std::size_t n = body.v_size();
  BlockDiagonal D;
  D.reset(body.block_sizes());
  body.add_system_diagonal(0, D);
  for (std::size_t c = 0; c < n; ++c) {
    std::vector<double> e(n, 0.0), fused(n, 0.0), composed(n, 0.0);
    e[c] = 1.0;
    body.apply_system(e, fused);
    body.Body::apply_system(e, composed);
    for (std::size_t r = 0; r < n; ++r) ASSERT_NEAR(fused[r], composed[r], 1e-12);
    for (int r = 0; r < 3; ++r) EXPECT_NEAR(D.block(c / 3)(r, c % 3), fused[3 * (c / 3) + r], 1e-12);
  }
}

TEST(FemBody, BadInputIsRefusedWithAMessage) {
  const TetMesh good = testing::block(1, 1, 1, 0.1);
  TetMesh flat_tet = good;
  flat_tet.tets.push_back({0, 1, 2, 3});
  EXPECT_THROW(FemBody(flat_tet, {}), InputError);
  TetMesh missing = good;
  missing.tets[0][1] = 99;
  EXPECT_THROW(FemBody(missing, {}), InputError);
  TetMesh unused = good;
  unused.vertices.push_back(Vec3(1, 1, 1));
  EXPECT_THROW(FemBody(unused, {}), InputError);
  FemOptions o;
  o.poisson = 0.5;
  EXPECT_THROW(FemBody(good, o), InputError);
  o = {};
  o.young = -1;
  EXPECT_THROW(FemBody(good, o), InputError);
  o = {};
  o.fixed = {3, 8};
  EXPECT_THROW(FemBody(good, o), InputError);
  o.fixed = {3, 3};
  EXPECT_THROW(FemBody(good, o), InputError);
  EXPECT_THROW(FemBody(TetMesh{}, {}), InputError);
}

}  // namespace
}  // namespace brim::fem_body_test
