#include <gtest/gtest.h>

#include <random>

#include "brim/body/cloth/cloth_body.h"
#include "brim/body/particle_fluid/particle_fluid_body.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/primitives.h"
#include "support/implicit.h"
#include "support/worlds.h"

namespace brim {
namespace {

constexpr unsigned kSeed = 17;
constexpr double kSpacing = 0.05;

ParticleFluidOptions options(double viscosity = 0.0) {
  ParticleFluidOptions o;
  o.spacing = kSpacing;
  o.viscosity = viscosity;
  return o;
}

std::vector<Vec3> block(const Vec3& size, double jitter = 0.0, const Vec3& lo = Vec3::Zero()) {
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> noise(-jitter * kSpacing, jitter * kSpacing);
  std::vector<Vec3> x = lattice_in_box(lo, lo + size, kSpacing);
  for (Vec3& p : x) p += Vec3(noise(rng), noise(rng), noise(rng));
  return x;
}

struct Held {
  ParticleFluidBody body;
  std::vector<double> q, v;
  Held(std::vector<Vec3> x, ParticleFluidOptions o) : body(std::move(x), std::move(o)) {
    q.resize(body.q_size()), v.resize(body.v_size());
    body.initial_state(q, v);
    body.update(0.0, q, v);
    body.begin_solve(0.005);
  }
  void set(const std::vector<double>& at) { body.update(0.0, at, v); }
};

std::vector<double> random_vector(std::size_t n, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  std::vector<double> x(n);
  for (double& e : x) e = u(rng);
  return x;
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double s = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) s += a[i] * b[i];
  return s;
}

std::vector<double> forces(const Body& b, const Vec3& gravity = Vec3::Zero()) {
  std::vector<double> Q(b.v_size(), 0.0);
  b.add_forces(Environment{gravity}, Q);
  return Q;
}

std::vector<double> system_times(const Body& b, const std::vector<double>& x) {
  std::vector<double> y(x.size(), 0.0);
  b.apply_system(x, y);
  return y;
}

TEST(FluidKernel, IntegratesToOneAndItsSlopeIsItsDerivative) {
  const FluidKernel k(0.7);
  double sum = 0.0;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const double r = 0.7 * (i + 0.5) / n;
    sum += 4.0 * std::numbers::pi * r * r * k.value(r) * 0.7 / n;
  }
  EXPECT_NEAR(sum, 1.0, 1e-7);
  for (const double r : {0.01, 0.2, 0.34, 0.36, 0.6, 0.69}) {
    const double e = 1e-6;
    EXPECT_NEAR(k.slope_over_r(r) * r, (k.value(r + e) - k.value(r - e)) / (2 * e), 1e-6 * k.value(0));
  }
}

TEST(ParticleCells, FindTheNeighboursThatBruteForceFindsAlsoFarAway) {
  std::vector<Vec3> x = block(Vec3(0.4, 0.3, 0.2), 0.4);
  x.push_back(Vec3(1e7, -1e7, 3.0));
  x.push_back(Vec3(1e7, -1e7, 3.02));
  const double radius = 0.1;
  ParticleCells cells;
  cells.build(x, radius);
  std::size_t found = 0, expected = 0;
  const auto p = cells.positions();
  cells.for_neighbourhoods(0, cells.size(), [&](std::size_t i, auto ranges) {
    for (const auto& [first, last] : ranges)
      for (std::int32_t j = first; j < last; ++j) found += (p[i] - p[j]).norm() < radius;
  });
  for (const Vec3& a : x)
    for (const Vec3& b : x) expected += (a - b).norm() < radius;
  EXPECT_EQ(found, expected);
  std::size_t near = 0, all = 0;
  const Vec3 c(0.21, 0.12, 0.07);
  cells.near(c, 0.13, [&](std::int32_t first, std::int32_t last) {
    for (std::int32_t j = first; j < last; ++j) near += (c - p[j]).norm() < 0.13;
  });
  for (const Vec3& a : x) all += (a - c).norm() < 0.13;
  EXPECT_EQ(near, all);
}

TEST(ParticleFluid, ALatticeInsideIsExactlyFull) {
  Held f(block(Vec3(0.4, 0.4, 0.4)), options());
  const std::vector<double> fill = f.body.fill();
  double most = 0.0;
  for (const double e : fill) most = std::max(most, e);
  EXPECT_NEAR(most, 1.0, 1e-12);
  EXPECT_LT(*std::min_element(fill.begin(), fill.end()), 0.7);  // corners
}

TEST(ParticleFluid, PressureForcesAreMinusTheDerivativeOfEnergy) {
  std::vector<Vec3> x = block(Vec3(0.3, 0.3, 0.3), 0.2);
  for (Vec3& p : x) p *= 0.93;  // compressed
  Held f(x, options());
  const std::vector<double> Q = forces(f.body);
  ASSERT_GT(dot(Q, Q), 0.0);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    const std::vector<double> d = random_vector(Q.size(), seed);
    const double e = 1e-7;
    std::vector<double> plus = f.q, minus = f.q;
    for (std::size_t i = 0; i < d.size(); ++i) plus[i] += e * d[i], minus[i] -= e * d[i];
    const Environment still{Vec3::Zero()};
    f.set(plus);
    const double up = f.body.potential_energy(still);
    f.set(minus);
    const double down = f.body.potential_energy(still);
    // Gradients are kept in single precision.
    EXPECT_NEAR(dot(Q, d), -(up - down) / (2 * e), 1e-5 * std::sqrt(dot(Q, Q) * dot(d, d)));
  }
}

TEST(ParticleFluid, TheSystemIsSymmetricAndHeavierThanItsMass) {
  Held f(block(Vec3(0.3, 0.3, 0.3), 0.3), options(2.0));
  const std::vector<double> a = random_vector(f.v.size(), kSeed), b = random_vector(f.v.size(), kSeed + 1);
  const std::vector<double> Aa = system_times(f.body, a), Ab = system_times(f.body, b);
  EXPECT_NEAR(dot(a, Ab), dot(b, Aa), 1e-5 * std::sqrt(dot(Aa, Aa) * dot(b, b)));
  EXPECT_GT(dot(a, Aa), f.body.particle_mass() * dot(a, a));
}

TEST(ParticleFluid, TheSystemIsTheMassAndTheSquaredRatesOfFill) {
  Held f(block(Vec3(0.4, 0.4, 0.4)), options());
  const std::vector<double> d = random_vector(f.v.size(), kSeed);
  std::vector<double> Kd(d.size(), 0.0);
  f.body.apply_stiffness(d, Kd);
  const double e = 1e-6;
  const std::vector<double> fill = f.body.fill();
  std::vector<double> plus = f.q, minus = f.q;
  for (std::size_t i = 0; i < d.size(); ++i) plus[i] += e * d[i], minus[i] -= e * d[i];
  f.set(plus);
  const std::vector<double> up = f.body.fill();
  f.set(minus);
  const std::vector<double> down = f.body.fill();
  double sum = 0.0;
  const double volume = kSpacing * kSpacing * kSpacing;
  for (std::size_t i = 0; i < fill.size(); ++i) {
    const double t = std::clamp((fill[i] - 0.90) / 0.08, 0.0, 1.0), rate = (up[i] - down[i]) / (2 * e);
    sum += t * t * (3 - 2 * t) * f.body.bulk_modulus() * volume * rate * rate;
  }
  EXPECT_NEAR(-dot(d, Kd), sum, 1e-4 * sum);
}

TEST(ParticleFluid, TheDiagonalBlocksAreThoseOfTheSystem) {
  Held f(block(Vec3(0.2, 0.2, 0.2), 0.2), options(3.0));
  BlockDiagonal D;
  D.reset(f.body.block_sizes());
  f.body.add_system_diagonal(0, D);
  for (const std::size_t i : {0u, 21u, 40u})
    for (int a = 0; a < 3; ++a) {
      std::vector<double> unit(f.v.size(), 0.0);
      unit[3 * i + a] = 1.0;
      const std::vector<double> column = system_times(f.body, unit);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(D.block(i)(c, a), column[3 * i + c], 1e-5 * D.block(i).norm()) << i << " " << c << a;
    }
}

TEST(ParticleFluid, InnerForcesHaveNoResultantAndNoTorque) {
  std::vector<Vec3> x = block(Vec3(0.3, 0.3, 0.3), 0.3);
  for (Vec3& p : x) p *= 0.95;
  Held f(x, options(5.0));
  f.v = random_vector(f.v.size(), kSeed);
  f.set(f.q);
  const std::vector<double> Q = forces(f.body);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double size = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 F(Q[3 * i], Q[3 * i + 1], Q[3 * i + 2]);
    force += F, torque += x[i].cross(F), size += F.norm();
  }
  EXPECT_LT(force.norm(), 1e-7 * size);
  EXPECT_LT(torque.norm(), 1e-7 * size);
}

TEST(ParticleFluid, RigidMotionMeetsNoViscosityAndShearDoes) {
  Held f(block(Vec3(0.3, 0.3, 0.3), 0.2), options(5.0));
  std::vector<double> turn(f.v.size()), y(f.v.size(), 0.0), z(f.v.size(), 0.0), shear(f.v.size(), 0.0);
  f.body.rigid_motion(Vec3(1, 2, 3), Vec3(0.5, -1, 2), turn);
  for (std::size_t i = 0; i < shear.size(); i += 3) shear[i] = f.q[i + 2];
  f.body.apply_damping(turn, y);
  f.body.apply_damping(shear, z);
  EXPECT_LT(std::sqrt(dot(y, y)), 1e-4 * std::sqrt(dot(z, z)));
  EXPECT_LT(dot(shear, z), 0.0);
}

TEST(ParticleFluid, ALoneParticleFalls) {
  Held f({Vec3(0, 0, 1)}, options());
  testing::Stepper s(f.body);
  for (int i = 0; i < 10; ++i) s.step(0.01, Environment{});
  EXPECT_NEAR(s.v[2], -0.981, 1e-12);
}

TEST(ParticleFluid, RefusesWhatCannotBe) {
  EXPECT_THROW(ParticleFluidBody({}, options()), InputError);
  EXPECT_THROW(ParticleFluidBody({Vec3(0, 0, std::nan(""))}, options()), InputError);
  const auto with = [](auto change) {
    ParticleFluidOptions o = options();
    change(o);
    return o;
  };
  for (const auto& bad : {with([](auto& o) { o.spacing = 0.0; }), with([](auto& o) { o.density = -1.0; }),
                          with([](auto& o) { o.viscosity = -1.0; }), with([](auto& o) { o.compression = 0.5; }),
                          with([](auto& o) { o.voxel_size = 0.06; }), with([](auto& o) { o.bulk_modulus = -1.0; })})
    EXPECT_THROW(ParticleFluidBody({Vec3::Zero()}, bad), InputError);
}

/// The fluid's density at nodes of a step along z through (x, y), read from its tiles.
struct Sampled {
  std::vector<TileKey> tiles;
  std::vector<DensityBlock> blocks;
  Sampled(const ParticleFluidBody& b, double h) {
    b.presence(0, h, 3 * h, Aabb{Vec3::Constant(-1), Vec3::Constant(1)}, tiles);
    std::sort(tiles.begin(), tiles.end());
    tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
    blocks.resize(tiles.size());
    b.rasterize(0, h, 3 * h, tiles, blocks);
  }
};

TEST(ParticleFluid, DensityIsFullInsideHalfWithinATenthOfASpacingOfTheSurfaceAndNothingOutside) {
  Held f(block(Vec3(0.5, 0.5, 0.5), 0.0, Vec3(-0.25, -0.25, -0.5)), options());
  const double h = 0.025;
  const Sampled s(f.body, h);
  int inside = 0, surface = 0, outside = 0;
  for (std::size_t t = 0; t < s.tiles.size(); ++t)
    for (int k = 0; k < kBlockSize; ++k)
      for (int j = 0; j < kBlockSize; ++j)
        for (int i = 0; i < kBlockSize; ++i) {
          const Vec3 x = block_origin(s.tiles[t], h) + h * Vec3(i, j, k);
          if (x.head<2>().cwiseAbs().maxCoeff() > 0.12) continue;
          const double rho = s.blocks[t].rho[block_index(i, j, k)];
          EXPECT_GE(rho, 0.0);
          EXPECT_LE(rho, 1.0);
          if (x.z() < -0.11 && x.z() > -0.39) {
            EXPECT_GT(rho, 0.97);
            ++inside;
          }
          if (std::abs(x.z()) < 1e-9 && k > 0) {
            // Where the line through this node and the one below it is at a half.
            const double below = s.blocks[t].rho[block_index(i, j, k - 1)];
            EXPECT_NEAR(h * (rho - 0.5) / (below - rho), 0.0, 0.1 * kSpacing);
            ++surface;
          }
          if (x.z() > 0.08) {
            EXPECT_EQ(rho, 0.0);
            ++outside;
          }
        }
  EXPECT_GT(inside, 100);
  EXPECT_GT(surface, 20);
  EXPECT_GT(outside, 20);
}

/// A map of all nodes of a fluid, with their sources.
std::unique_ptr<Map> map_of(const ParticleFluidBody& b, const Sampled& s, double h, std::vector<Vec3>& nodes) {
  std::vector<std::int32_t> sources;
  for (std::size_t t = 0; t < s.tiles.size(); ++t)
    for (int n = 0; n < kBlockNodes; ++n) {
      if (s.blocks[t].source[n] < 0) continue;
      nodes.push_back(block_origin(s.tiles[t], h) +
                      h * Vec3(n % kBlockSize, n / kBlockSize % kBlockSize, n / (kBlockSize * kBlockSize)));
      sources.push_back(s.blocks[t].source[n]);
    }
  std::unique_ptr<Map> map;
  b.make_map(0, nodes, sources, map);
  return map;
}

TEST(FluidMap, ForcesDoTheWorkOfVelocitiesAndUniformMotionIsExact) {
  Held f(block(Vec3(0.2, 0.2, 0.2), 0.3), options());
  const double h = 0.025;
  const Sampled s(f.body, h);
  std::vector<Vec3> nodes;
  const std::unique_ptr<Map> map = map_of(f.body, s, h, nodes);
  ASSERT_GT(nodes.size(), 100u);
  const std::vector<double> v = random_vector(f.v.size(), kSeed), r = random_vector(3 * nodes.size(), kSeed + 1);
  std::vector<Vec3> u(nodes.size()), force;
  for (std::size_t i = 0; i < nodes.size(); ++i) force.emplace_back(r[3 * i], r[3 * i + 1], r[3 * i + 2]);
  map->velocity(v, u);
  std::vector<double> Q(v.size(), 0.0);
  map->add_force(force, Q);
  double work = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) work += u[i].dot(force[i]);
  EXPECT_NEAR(dot(Q, v), work, 1e-12 * std::sqrt(dot(Q, Q) * dot(v, v)));
  std::vector<double> even(v.size());
  f.body.rigid_motion(Vec3(1, -2, 3), Vec3::Zero(), even);
  map->velocity(even, u);
  for (const Vec3& e : u) EXPECT_LT((e - Vec3(1, -2, 3)).norm(), 1e-12);
}

TEST(FluidMap, AChoiceOfPointsDoesAsThoseOfAllDo) {
  Held f(block(Vec3(0.2, 0.2, 0.2), 0.3), options());
  const double h = 0.025;
  const Sampled s(f.body, h);
  std::vector<Vec3> nodes;
  const std::unique_ptr<Map> all = map_of(f.body, s, h, nodes);
  std::vector<std::uint32_t> rows;
  for (std::uint32_t i = 0; i < nodes.size(); i += 1 + i % 3) rows.push_back(i);
  ASSERT_GT(rows.size(), 30u);
  std::unique_ptr<Map> some;
  ASSERT_TRUE(all->select(rows, some));
  ASSERT_EQ(some->points(), rows.size());
  const std::vector<double> v = random_vector(f.v.size(), kSeed), r = random_vector(3 * rows.size(), kSeed + 1);
  std::vector<Vec3> u(nodes.size()), chosen(rows.size()), force(nodes.size(), Vec3::Zero()), part(rows.size());
  all->velocity(v, u);
  some->velocity(v, chosen);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(chosen[i], u[rows[i]]);
    part[i] = force[rows[i]] = Vec3(r[3 * i], r[3 * i + 1], r[3 * i + 2]);
  }
  std::vector<double> Q(v.size(), 0.0), P(v.size(), 0.0);
  all->add_force(force, Q);
  some->add_force(part, P);
  for (std::size_t i = 0; i < Q.size(); ++i) EXPECT_NEAR(P[i], Q[i], 1e-14);
  // Refilled for other points, with the room it has.
  rows.assign({5, 9});
  ASSERT_TRUE(all->select(rows, some));
  chosen.resize(2);
  some->velocity(v, chosen);
  EXPECT_EQ(chosen[0], u[5]);
  EXPECT_EQ(chosen[1], u[9]);
}

TEST(FluidMap, AlongItsDirectionTheVelocityIsTheRateOfTheDensity) {
  Held f(block(Vec3(0.4, 0.4, 0.3), 0.15, Vec3(-0.2, -0.2, -0.3)), options());
  const double h = 0.025, e = 1e-6;
  const Sampled s(f.body, h);
  const std::vector<double> v = random_vector(f.v.size(), kSeed);
  std::vector<Vec3> nodes;
  std::vector<std::pair<std::size_t, int>> places;
  std::vector<std::int32_t> sources;
  for (std::size_t t = 0; t < s.tiles.size(); ++t)
    for (int n = 0; n < kBlockNodes; ++n) {
      const double rho = s.blocks[t].rho[n];
      const Vec3 x = block_origin(s.tiles[t], h) +
                     h * Vec3(n % kBlockSize, n / kBlockSize % kBlockSize, n / (kBlockSize * kBlockSize));
      // The upper surface's steep part, away from edges where particles swell.
      if (rho < 0.3 || rho > 0.6 || x.head<2>().cwiseAbs().maxCoeff() > 0.06 || x.z() < -0.05) continue;
      nodes.push_back(x), places.emplace_back(t, n), sources.push_back(s.blocks[t].source[n]);
    }
  ASSERT_GT(nodes.size(), 10u);
  std::unique_ptr<Map> map;
  f.body.make_map(0, nodes, sources, map);
  std::vector<Vec3> u(nodes.size());
  map->velocity(v, u);
  std::vector<double> plus = f.q, minus = f.q;
  for (std::size_t i = 0; i < v.size(); ++i) plus[i] += e * v[i], minus[i] -= e * v[i];
  const auto rho_at = [&](const std::vector<double>& q) {
    ParticleFluidBody moved(block(Vec3(0.4, 0.4, 0.3)), options());
    moved.update(0.0, q, f.v);
    std::vector<DensityBlock> out(s.tiles.size());
    moved.rasterize(0, h, 3 * h, s.tiles, out);
    std::vector<double> rho;
    for (const auto& [t, n] : places) rho.push_back(out[t].rho[n]);
    return rho;
  };
  const std::vector<double> up = rho_at(plus), down = rho_at(minus);
  std::vector<Vec3> probe(nodes.size());
  // The gradient from three even motions: dρ = −∇ρ·dx.
  std::vector<Vec3> gradient(nodes.size(), Vec3::Zero());
  for (int a = 0; a < 3; ++a) {
    std::vector<double> p = f.q, m = f.q;
    for (std::size_t i = static_cast<std::size_t>(a); i < p.size(); i += 3) p[i] += e, m[i] -= e;
    const std::vector<double> rp = rho_at(p), rm = rho_at(m);
    for (std::size_t i = 0; i < nodes.size(); ++i) gradient[i][a] = -(rp[i] - rm[i]) / (2 * e);
  }
  for (std::size_t i = 0; i < nodes.size(); ++i)
    EXPECT_NEAR(-gradient[i].dot(u[i]), (up[i] - down[i]) / (2 * e), 2e-3 * gradient[i].norm());
}

TEST(FluidMap, DiagonalBlocksAreThoseOfTheProduct) {
  Held f(block(Vec3(0.15, 0.15, 0.15), 0.3), options());
  const double h = 0.05;
  const Sampled s(f.body, h);
  std::vector<Vec3> nodes;
  const std::unique_ptr<Map> map = map_of(f.body, s, h, nodes);
  std::vector<Mat3> K(nodes.size());
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (Mat3& k : K) {
    const Vec3 n(unit(rng), unit(rng), unit(rng));
    k = n * n.transpose() + Mat3::Identity();
  }
  BlockDiagonal D;
  D.reset(f.body.block_sizes());
  map->add_block_diagonal(K, 0, D);
  for (const std::size_t i : {0u, 13u})
    for (int a = 0; a < 3; ++a) {
      std::vector<double> e(f.v.size(), 0.0), Q(f.v.size(), 0.0);
      e[3 * i + a] = 1.0;
      std::vector<Vec3> u(nodes.size());
      map->velocity(e, u);
      for (std::size_t p = 0; p < u.size(); ++p) u[p] = K[p] * u[p];
      map->add_force(u, Q);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(D.block(i)(c, a), Q[3 * i + c], 1e-10 * D.block(i).norm());
    }
}

std::unique_ptr<Body> fluid(std::vector<Vec3> x, double viscosity = 1.0) {
  ParticleFluidOptions o = options(viscosity);
  o.material.friction = 0.0;
  auto b = std::make_unique<ParticleFluidBody>(std::move(x), o);
  b->set_name("fluid");
  return b;
}

/// A basin of 0.3 x 0.3 m with the fluid in it.
World basin(double fluid_height) {
  WorldOptions o;
  o.time_step = 0.005;
  o.voxel_size = 0.025;
  World w(o);
  w.add(testing::obstacle("floor", make_box(Vec3(0.7, 0.7, 0.2)), 0.0, Vec3(0, 0, -0.1)));
  w.add(testing::obstacle("west", make_box(Vec3(0.2, 0.7, 0.6)), 0.0, Vec3(-0.25, 0, 0.3)));
  w.add(testing::obstacle("east", make_box(Vec3(0.2, 0.7, 0.6)), 0.0, Vec3(0.25, 0, 0.3)));
  w.add(testing::obstacle("south", make_box(Vec3(0.7, 0.2, 0.6)), 0.0, Vec3(0, -0.25, 0.3)));
  w.add(testing::obstacle("north", make_box(Vec3(0.7, 0.2, 0.6)), 0.0, Vec3(0, 0.25, 0.3)));
  w.add(fluid(block(Vec3(0.3, 0.3, fluid_height), 0.0, Vec3(-0.15, -0.15, 0))));
  return w;
}

TEST(ParticleFluid, APoolPressesOnItsBasinWithItsWeightAndKeepsItsVolume) {
  World w = basin(0.25);
  testing::run(w, 0.5);
  double force = 0.0, error = 0.0;
  const int steps = 40;
  for (int i = 0; i < steps; ++i) {
    const StepReport r = w.step();
    ASSERT_TRUE(r.ok);
    error = std::max(error, r.momentum_error);
    for (const PairReport& p : r.pairs) force -= p.force_on_a.z() / steps;
  }
  const double weight = w.body(5).mass() * 9.81;
  EXPECT_NEAR(force, weight, 0.02 * weight);
  EXPECT_LT(error, 1e-12);
  double mean = 0.0, lowest = 1.0;
  const auto q = w.q(5);
  for (std::size_t i = 2; i < q.size(); i += 3) mean += q[i] * 3.0 / q.size(), lowest = std::min(lowest, q[i]);
  EXPECT_NEAR(mean, 0.125, 0.1 * 0.125);  // volume, seen by the height of the centre of mass
  EXPECT_GT(lowest, 0.0);
}

TEST(ParticleFluid, ABallAndAClothAreCarriedByFluid) {
  {
    World w = basin(0.25);
    testing::Start s;
    s.x = Vec3(0, 0, 0.36);
    w.add(testing::ball("ball", s, 0.0, 0.08, 300.0));
    testing::run(w, 0.6);
    EXPECT_GT(testing::position(w, 6).z(), 0.2);
    EXPECT_LT(testing::position(w, 6).z(), 0.42);
  }
  {
    World w = basin(0.2);
    TriMesh mesh = shapes::grid(5, 5, 0.2, 0.2);
    for (Vec3& x : mesh.vertices) x.z() = 0.28;
    ClothOptions o;
    o.thickness = 0.05;
    o.areal_density = 5.0;
    o.material.friction = 0.0;
    auto cloth = std::make_unique<ClothBody>(mesh, o);
    cloth->set_name("cloth");
    w.add(std::move(cloth));
    testing::run(w, 0.4);
    const auto q = w.q(6);
    for (std::size_t i = 2; i < q.size(); i += 3) EXPECT_GT(q[i], 0.1);
  }
}

TEST(ParticleFluid, OneThreadAndThreeGiveTheSameBits) {
  std::uint64_t hash[2];
  for (int k = 0; k < 2; ++k) {
    const ThreadLimit limit(k == 0 ? 1 : 3);
    World w = basin(0.15);
    testing::run(w, 0.05);
    hash[k] = w.hash();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

}  // namespace
}  // namespace brim
