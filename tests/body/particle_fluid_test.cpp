#include <gtest/gtest.h>

#include <random>

#include "brim/body/cloth/cloth_body.h"
#include "brim/body/particle_fluid/particle_fluid_body.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/primitives.h"
#include "support/implicit.h"
#include "support/particle_fluids.h"
#include "support/worlds.h"

namespace brim::particle_fluid_test {
namespace {

using namespace testing::fluids;

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

TEST(FluidKernel, GivesFourDistancesTheValuesOfEach) {
  const FluidKernel k(0.7);
  for (const double first : {0.0, 0.2, 0.33, 0.349, 0.35, 0.5, 0.69}) {
    const Lanes r{first, first + 0.001, first + 0.002, first + 0.005};
    const auto [value, slope] = k.value_and_slope(r);
    for (int l = 0; l < kLanes; ++l) {
      EXPECT_NEAR(value[l], k.value(r[l]), 1e-15 * k.value(0.0));
      EXPECT_NEAR(slope[l], k.slope_over_r(r[l]), 1e-14 * std::abs(k.slope_over_r(0.0)));
    }
  }
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

/// What particles near the plane z = 0 see of it.
std::vector<Seen> seen_of_floor(const ParticleFluidBody& b) {
  std::vector<Seen> seen;
  const auto x = b.fill_places();
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (x[i].z() < b.fill_reach()) seen.push_back({static_cast<std::int32_t>(i), 0, x[i].z(), Vec3::UnitZ(), 0.0});
  }
  return seen;
}

TEST(ParticleFluid, TheSystemIsSymmetricWithWhatMovesBesideIt) {
  Held f(block(Vec3(0.3, 0.3, 0.3), 0.2), options(2.0));
  const std::vector<Seen> seen = seen_of_floor(f.body);
  f.body.see(seen);
  std::vector<double> y[2], push[2], x[2], rate[2];
  for (int k = 0; k < 2; ++k) {
    x[k] = random_vector(f.v.size(), kSeed + k), rate[k] = random_vector(seen.size(), kSeed + 7 + k);
    y[k].assign(x[k].size(), 0.0), push[k].resize(seen.size());
    f.body.apply_system_seeing(x[k], rate[k], y[k], push[k]);
  }
  // Work of each motion in the forces of the other; what the other side moves counts by its rate.
  const double one = dot(x[0], y[1]) - dot(rate[0], push[1]), two = dot(x[1], y[0]) - dot(rate[1], push[0]);
  EXPECT_NEAR(one, two, 1e-5 * std::sqrt(dot(y[0], y[0]) * dot(x[1], x[1])));
  EXPECT_GT(std::abs(dot(rate[0], push[1])), 1e-3 * std::abs(one));
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
}  // namespace brim::particle_fluid_test
