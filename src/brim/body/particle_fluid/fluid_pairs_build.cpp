#include <algorithm>
#include <cmath>

#include "brim/body/particle_fluid/fluid_pairs.h"
#include "brim/core/parallel.h"
#include "brim/core/simd.h"

namespace brim {

namespace {

/// Places of all particles, a row for each coordinate, [m].
struct Places {
  const double *x, *y, *z;
};

/// Numbers of the particles [first, last) nearer to p than the root of `reach2`, p's own (i) left out. Four at a time;
/// `near` has room for three more. @return how many
BRIM_INLINE std::size_t find_near(const Places& at, std::int32_t first, std::int32_t last, std::int32_t i,
                                  const double* p, double reach2, std::int32_t* near) {
  std::size_t n = 0;
  for (std::int32_t j = first; j < last; j += kLanes) {
    const Lanes dx = p[0] - load_lanes(at.x + j), dy = p[1] - load_lanes(at.y + j), dz = p[2] - load_lanes(at.z + j);
    const LaneFlags within = dx * dx + dy * dy + dz * dz < reach2;
    for (std::int32_t l = 0; l < kLanes; ++l) {
      near[n] = j + l;
      n += static_cast<std::size_t>(-within[l] & (j + l < last) & (j + l != i));
    }
  }
  return n;
}

/// Of the pairs of p with those that are near: g and the drag's factor, and V W. Four at a time, with room for three
/// more behind all arrays.
BRIM_INLINE void find_pairs(const Places& at, const std::int32_t* near, std::size_t n, const double* p,
                            const FluidKernel& kernel, double volume, double viscosity, FluidPairs::Vec4* gradient,
                            double* filled) {
  const double H2 = kernel.support() * kernel.support();
  for (std::size_t e = 0; e < n; e += kLanes) {
    Lanes d[3];
    for (int l = 0; l < kLanes; ++l) {
      const std::int32_t j = near[std::min(e + static_cast<std::size_t>(l), n - 1)];
      d[0][l] = p[0] - at.x[j], d[1][l] = p[1] - at.y[j], d[2][l] = p[2] - at.z[j];
    }
    const Lanes r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    Lanes r;
    for (int l = 0; l < kLanes; ++l) r[l] = std::sqrt(r2[l]);
    const auto [value, over_r] = kernel.value_and_slope(r);
    const Lanes slope = volume * over_r;
    store_lanes(filled + e, Lanes(volume * value));
    // x_ij = g_ij / slope: the drag's factor on (g · v) g.
    const Lanes drag = slope < 0.0 ? -10.0 * viscosity * volume / (slope * (r2 + 0.01 * H2)) : Lanes{};
    const FloatLanes g[4] = {to_float(slope * d[0]), to_float(slope * d[1]), to_float(slope * d[2]), to_float(drag)};
    for (int l = 0; l < kLanes; ++l) {
      const FloatLanes entry = {g[0][l], g[1][l], g[2][l], g[3][l]};
      store_lanes(gradient[e + static_cast<std::size_t>(l)].data(), entry);
    }
  }
}

/// What a block of particles gathers while it is built.
struct Found {
  std::vector<std::int32_t>& neighbour;
  std::vector<FluidPairs::Vec4>& gradient;
  std::vector<double> filled;
};

/// Appends the pairs of particle i. @return Σ_j V W(x_ij) without its own
BRIM_WIDE double add_particle(const Places& at, std::size_t i,
                              std::span<const std::pair<std::int32_t, std::int32_t>> ranges, const FluidKernel& kernel,
                              double volume, double viscosity, Found& out) {
  const double p[3] = {at.x[i], at.y[i], at.z[i]};
  const std::size_t begin = out.neighbour.size();
  std::size_t n = begin, most = begin;
  for (const auto& [first, last] : ranges) most += static_cast<std::size_t>(last - first) + kLanes;
  out.neighbour.resize(most);
  for (const auto& [first, last] : ranges)
    n += find_near(at, first, last, static_cast<std::int32_t>(i), p, kernel.support() * kernel.support(),
                   out.neighbour.data() + n);
  out.gradient.resize(n + kLanes), out.filled.resize(n - begin + kLanes);
  find_pairs(at, out.neighbour.data() + begin, n - begin, p, kernel, volume, viscosity, out.gradient.data() + begin,
             out.filled.data());
  out.neighbour.resize(n), out.gradient.resize(n);
  double fill = 0.0;
  for (std::size_t k = 0; k < n - begin; ++k) fill += out.filled[k];
  return fill;
}

}  // namespace

void FluidPairs::build(const ParticleCells& cells, const FluidKernel& kernel, double volume, double viscosity) {
  size_ = cells.size();
  stretched_.clear();
  fill_.resize(size_);
  const std::size_t count = (size_ + kBlock - 1) / kBlock;
  if (blocks_.size() < count) blocks_.resize(count);
  for (std::size_t a = 0; a < 3; ++a) {
    place_[a].resize(size_ + kLanes, 0.0);
    for (std::size_t i = 0; i < size_; ++i) place_[a][i] = cells.positions()[i][static_cast<Eigen::Index>(a)];
  }
  const Places at{place_[0].data(), place_[1].data(), place_[2].data()};
  const double self = volume * kernel.value(0.0);
  parallel_for(count, [&](std::size_t k) {
    Block& b = blocks_[k];
    b.first.assign(1, 0);
    b.neighbour.clear(), b.gradient.clear();
    Found found{b.neighbour, b.gradient, {}};
    const std::size_t begin = k * kBlock, end = std::min(size_, begin + kBlock);
    cells.for_neighbourhoods(begin, end, [&](std::size_t i, auto ranges) {
      fill_[i] = self + add_particle(at, i, ranges, kernel, volume, viscosity, found);
      b.first.push_back(static_cast<std::int32_t>(b.neighbour.size()));
    });
  });
}

}  // namespace brim
