#include "brim/body/particle_fluid/fluid_pairs.h"

#include <cmath>

#include "brim/core/parallel.h"

namespace brim {

void FluidPairs::build(const ParticleCells& cells, const FluidKernel& kernel, double volume, double viscosity) {
  size_ = cells.size();
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

void FluidPairs::rates(std::span<const Vec4> v, std::span<const float> weight, std::span<float> rate) const {
  parallel_blocks(size_, kBlock, [&](std::size_t begin, std::size_t end) {
    const Block& b = blocks_[begin / kBlock];
    for (std::size_t i = begin; i < end; ++i) {
      rate[i] = 0.0f;
      if (!(weight[i] > 0.0f)) continue;
      const Vec4 vi = v[i];
      Vec4 sum = Vec4::Zero();
      for (std::int32_t e = b.first[i - begin]; e < b.first[i - begin + 1]; ++e)
        sum += b.gradient[e] * (vi - v[b.neighbour[e]]);
      rate[i] = (sum[0] + sum[1]) + sum[2];
    }
  });
}

void FluidPairs::add_pressure(std::span<const float> p, std::span<Eigen::Vector3d> y) const {
  parallel_blocks(size_, kBlock, [&](std::size_t begin, std::size_t end) {
    const Block& b = blocks_[begin / kBlock];
    for (std::size_t i = begin; i < end; ++i) {
      Vec4 sum = Vec4::Zero();
      const float pi = p[i];
      for (std::int32_t e = b.first[i - begin]; e < b.first[i - begin + 1]; ++e)
        sum += b.gradient[e] * (pi + p[b.neighbour[e]]);
      y[i] += sum.head<3>().matrix().cast<double>();
    }
  });
}

void FluidPairs::add_viscosity(double s, std::span<const Vec4> v, std::span<float> rate,
                               std::span<Eigen::Vector3d> y) const {
  parallel_blocks(size_, kBlock, [&](std::size_t begin, std::size_t end) {
    const Block& b = blocks_[begin / kBlock];
    for (std::size_t i = begin; i < end; ++i) {
      Vec4 sum = Vec4::Zero();
      float total = 0.0f;
      const Vec4 vi = v[i];
      for (std::int32_t e = b.first[i - begin]; e < b.first[i - begin + 1]; ++e) {
        const Vec4& g = b.gradient[e];
        const Vec4 t = g * (vi - v[b.neighbour[e]]);
        const float closing = t[0] + t[1] + t[2];
        total += closing;
        sum += (g[3] * closing) * g;
      }
      if (!rate.empty()) rate[i] = total;
      y[i] += s * sum.head<3>().matrix().cast<double>();
    }
  });
}

}  // namespace brim
