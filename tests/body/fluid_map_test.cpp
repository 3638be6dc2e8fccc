#include "brim/body/particle_fluid/fluid_map.h"

#include <gtest/gtest.h>

#include "support/particle_fluids.h"

namespace brim::fluid_map_test {
namespace {

using namespace testing::fluids;

/// A disordered cube of fluid and its map at all nodes.
struct Mapped : Held {
  std::vector<Vec3> nodes;
  std::unique_ptr<Map> map;
  Mapped(double side, double h) : Held(block(Vec3::Constant(side), 0.3), options()) {
    map = map_of(body, Sampled(body, h), h, nodes);
  }
};

TEST(FluidMap, ForcesDoTheWorkOfVelocitiesAndUniformMotionIsExact) {
  const Mapped f(0.2, 0.025);
  const std::vector<Vec3>& nodes = f.nodes;
  const std::unique_ptr<Map>& map = f.map;
  ASSERT_GT(nodes.size(), 100u);
  const std::vector<double> v = random_vector(f.v.size(), kSeed), r = random_vector(3 * nodes.size(), kSeed + 1);
  std::vector<Vec3> u(nodes.size()), force;
  for (std::size_t i = 0; i < nodes.size(); ++i) force.emplace_back(r[3 * i], r[3 * i + 1], r[3 * i + 2]);
  map->apply(v, u);
  std::vector<double> Q(v.size(), 0.0);
  map->apply_transpose(force, Q);
  double work = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) work += u[i].dot(force[i]);
  EXPECT_NEAR(dot(Q, v), work, 1e-12 * std::sqrt(dot(Q, Q) * dot(v, v)));
  std::vector<double> even(v.size());
  f.body.rigid_motion(Vec3(1, -2, 3), Vec3::Zero(), even);
  map->apply(even, u);
  for (const Vec3& e : u) EXPECT_LT((e - Vec3(1, -2, 3)).norm(), 1e-12);
}

TEST(FluidMap, AChoiceOfPointsDoesAsThoseOfAllDo) {
  const Mapped f(0.2, 0.025);
  const std::vector<Vec3>& nodes = f.nodes;
  const std::unique_ptr<Map>& all = f.map;
  std::vector<std::uint32_t> rows;
  for (std::uint32_t i = 0; i < nodes.size(); i += 1 + i % 3) rows.push_back(i);
  ASSERT_GT(rows.size(), 30u);
  std::unique_ptr<Map> some;
  ASSERT_TRUE(all->select(rows, some));
  ASSERT_EQ(some->points(), rows.size());
  const std::vector<double> v = random_vector(f.v.size(), kSeed), r = random_vector(3 * rows.size(), kSeed + 1);
  std::vector<Vec3> u(nodes.size()), chosen(rows.size()), force(nodes.size(), Vec3::Zero()), part(rows.size());
  all->apply(v, u);
  some->apply(v, chosen);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(chosen[i], u[rows[i]]);
    part[i] = force[rows[i]] = Vec3(r[3 * i], r[3 * i + 1], r[3 * i + 2]);
  }
  std::vector<double> Q(v.size(), 0.0), P(v.size(), 0.0);
  all->apply_transpose(force, Q);
  some->apply_transpose(part, P);
  for (std::size_t i = 0; i < Q.size(); ++i) EXPECT_NEAR(P[i], Q[i], 1e-14);
  // Refilled for other points, with the room it has.
  rows.assign({5, 9});
  ASSERT_TRUE(all->select(rows, some));
  chosen.resize(2);
  some->apply(v, chosen);
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
  map->apply(v, u);
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
  const Mapped f(0.15, 0.05);
  const std::vector<Vec3>& nodes = f.nodes;
  const std::unique_ptr<Map>& map = f.map;
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
      map->apply(e, u);
      for (std::size_t p = 0; p < u.size(); ++p) u[p] = K[p] * u[p];
      map->apply_transpose(u, Q);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(D.block(i)(c, a), Q[3 * i + c], 1e-10 * D.block(i).norm());
    }
}

}  // namespace
}  // namespace brim::fluid_map_test
