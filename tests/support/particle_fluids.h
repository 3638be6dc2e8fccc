#pragma once

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "brim/body/particle_fluid/particle_fluid_body.h"

namespace brim::testing::fluids {

inline constexpr unsigned kSeed = 17;
inline constexpr double kSpacing = 0.05;

inline ParticleFluidOptions options(double viscosity = 0.0) {
  ParticleFluidOptions o;
  o.spacing = kSpacing;
  o.viscosity = viscosity;
  return o;
}

inline std::vector<Vec3> block(const Vec3& size, double jitter = 0.0, const Vec3& lo = Vec3::Zero()) {
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> noise(-jitter * kSpacing, jitter * kSpacing);
  std::vector<Vec3> x = lattice_in_box(lo, lo + size, kSpacing).x;
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

inline std::vector<double> random_vector(std::size_t n, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  std::vector<double> x(n);
  for (double& e : x) e = u(rng);
  return x;
}

inline double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double s = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) s += a[i] * b[i];
  return s;
}

/// The density of a fluid at all nodes near it.
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

/// A map of all nodes of a fluid, with their sources.
inline std::unique_ptr<Map> map_of(const ParticleFluidBody& b, const Sampled& s, double h, std::vector<Vec3>& nodes) {
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

}  // namespace brim::testing::fluids
