#include "brim/body/particle_fluid/fluid_pairs.h"

#include <cmath>
#include <cstring>

#include "brim/core/parallel.h"
#include "brim/core/simd.h"

namespace brim {

void FluidPairs::build(const ParticleCells& cells, const FluidKernel& kernel, double volume, double viscosity) {
  size_ = cells.size();
  stretched_.clear();
  fill_.resize(size_);
  const std::size_t count = (size_ + kBlock - 1) / kBlock;
  if (blocks_.size() < count) blocks_.resize(count);
  const auto x = cells.positions();
  const double H = kernel.support(), H2 = H * H, self = volume * kernel.value(0.0);
  parallel_for(count, [&](std::size_t k) {
    Block& b = blocks_[k];
    b.first.assign(1, 0);
    b.neighbour.clear(), b.gradient.clear();
    const std::size_t begin = k * kBlock, end = std::min(size_, begin + kBlock);
    cells.for_neighbourhoods(begin, end, [&](std::size_t i, auto ranges) {
      const Vec3 xi = x[i];
      double fill = self;
      for (const auto& [first, last] : ranges)
        for (std::int32_t j = first; j < last; ++j) {
          const Vec3 d = xi - x[j];
          const double r2 = d.squaredNorm();
          if (r2 >= H2 || static_cast<std::size_t>(j) == i) continue;
          const double r = std::sqrt(r2), slope = volume * kernel.slope_over_r(r);
          fill += volume * kernel.value(r);
          // x_ij = g_ij / slope: the drag's factor on (g · v) g.
          const double drag = slope < 0.0 ? -10.0 * viscosity * volume / (slope * (r2 + 0.01 * H2)) : 0.0;
          b.neighbour.push_back(j);
          const Eigen::Vector3f g = (slope * d).cast<float>();
          b.gradient.emplace_back(g.x(), g.y(), g.z(), static_cast<float>(drag));
        }
      fill_[i] = fill;
      b.first.push_back(static_cast<std::int32_t>(b.neighbour.size()));
    });
  });
}

void FluidPairs::stretch(std::size_t i, std::int32_t pair, float factor) {
  Block& b = blocks_[i / kBlock];
  const std::int32_t e = b.first[i % kBlock] + pair;
  stretched_.push_back({i / kBlock, e, b.gradient[e]});
  b.gradient[e].head<3>() *= factor;
  b.gradient[e][3] /= factor * factor;
}

void FluidPairs::release() {
  for (const Stretched& s : stretched_) blocks_[s.block].gradient[s.entry] = s.gradient;
  stretched_.clear();
}

namespace {

/// Chains of additions run side by side: one alone would wait for itself at every neighbour.
constexpr std::int32_t kChains = 4;

/// Σ f(e) over first <= e < last, in an order that depends on nothing else.
template <class T, class F>
T chained_sum(std::int32_t first, std::int32_t last, T zero, const F& f) {
  T s[kChains] = {zero, zero, zero, zero};
  std::int32_t e = first;
  for (; e + kChains <= last; e += kChains)
    for (std::int32_t k = 0; k < kChains; ++k) s[k] += f(e + k);
  for (; e < last; ++e) s[0] += f(e);
  return (s[0] + s[1]) + (s[2] + s[3]);
}

FloatLanes lanes(const FluidPairs::Vec4& x) {
  FloatLanes out;
  std::memcpy(&out, x.data(), sizeof out);
  return out;
}

struct Drag {
  FloatLanes force = {};    ///< fourth lane: nothing
  FloatLanes closing = {};  ///< the same in all lanes
  Drag& operator+=(const Drag& d) { return force += d.force, closing += d.closing, *this; }
  Drag operator+(const Drag& d) const { return {force + d.force, closing + d.closing}; }
};

}  // namespace

void FluidPairs::rates(std::span<const Vec4> v, std::span<const float> weight, std::span<float> rate) const {
  parallel_blocks(size_, kBlock, [&](std::size_t begin, std::size_t end) {
    const Block& b = blocks_[begin / kBlock];
    const Vec4* g = b.gradient.data();
    const std::int32_t* j = b.neighbour.data();
    for (std::size_t i = begin; i < end; ++i) {
      rate[i] = 0.0f;
      if (!(weight[i] > 0.0f)) continue;
      const Vec4 vi = v[i];
      const Vec4 sum = chained_sum(b.first[i - begin], b.first[i - begin + 1], Vec4(Vec4::Zero()),
                                   [&](std::int32_t e) -> Vec4 { return g[e] * (vi - v[j[e]]); });
      rate[i] = (sum[0] + sum[1]) + sum[2];
    }
  });
}

void FluidPairs::add_pressure(std::span<const float> p, std::span<Eigen::Vector3d> y) const {
  parallel_blocks(size_, kBlock, [&](std::size_t begin, std::size_t end) {
    const Block& b = blocks_[begin / kBlock];
    const Vec4* g = b.gradient.data();
    const std::int32_t* j = b.neighbour.data();
    for (std::size_t i = begin; i < end; ++i) {
      const float pi = p[i];
      const Vec4 sum = chained_sum(b.first[i - begin], b.first[i - begin + 1], Vec4(Vec4::Zero()),
                                   [&](std::int32_t e) -> Vec4 { return g[e] * (pi + p[j[e]]); });
      y[i] += sum.head<3>().matrix().cast<double>();
    }
  });
}

void FluidPairs::add_viscosity(double s, std::span<const Vec4> v, std::span<float> rate,
                               std::span<Eigen::Vector3d> y) const {
  parallel_blocks(size_, kBlock, [&](std::size_t begin, std::size_t end) {
    const Block& b = blocks_[begin / kBlock];
    const std::int32_t* j = b.neighbour.data();
    for (std::size_t i = begin; i < end; ++i) {
      const FloatLanes vi = lanes(v[i]);
      const Drag sum = chained_sum(b.first[i - begin], b.first[i - begin + 1], Drag{}, [&](std::int32_t e) {
        const FloatLanes g = lanes(b.gradient[e]), t = g * (vi - lanes(v[j[e]]));
        const FloatLanes pairs = t + __builtin_shufflevector(t, t, 1, 0, 3, 2);
        const FloatLanes closing = pairs + __builtin_shufflevector(pairs, pairs, 2, 3, 0, 1);  // v has no fourth lane
        return Drag{__builtin_shufflevector(g, g, 3, 3, 3, 3) * closing * g, closing};
      });
      if (!rate.empty()) rate[i] = sum.closing[0];
      y[i] += s * Eigen::Vector3d(sum.force[0], sum.force[1], sum.force[2]);
    }
  });
}

}  // namespace brim
