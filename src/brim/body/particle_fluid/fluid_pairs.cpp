#include "brim/body/particle_fluid/fluid_pairs.h"

#include "brim/core/parallel.h"
#include "brim/core/widest.h"

namespace brim {

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

/// Additions run side by side in this many chains: one alone would wait for itself at every neighbour.
constexpr std::int32_t kChains = 4;

/// Four vectors, one of each chain.
template <class Widest>
using Chains = typename Widest::Floats;
template <class Widest>
BRIM_INLINE Chains<Widest> join(const FloatLanes& a, const FloatLanes& b, const FloatLanes& c, const FloatLanes& d) {
  return joined<Widest>(__builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7),
                        __builtin_shufflevector(c, d, 0, 1, 2, 3, 4, 5, 6, 7));
}
/// The chains together, with what was left over for the first.
template <class V>
BRIM_INLINE FloatLanes sum_of(const V& s, const FloatLanes& rest) {
  const WideFloats low = low_of(s), high = high_of(s);
  const FloatLanes s0 = __builtin_shufflevector(low, low, 0, 1, 2, 3),
                   s1 = __builtin_shufflevector(low, low, 4, 5, 6, 7),
                   s2 = __builtin_shufflevector(high, high, 0, 1, 2, 3),
                   s3 = __builtin_shufflevector(high, high, 4, 5, 6, 7);
  return ((s0 + rest) + s1) + (s2 + s3);
}

/// Asks for the gradients that follow some way behind these.
BRIM_INLINE void prefetch(const FluidPairs::Vec4* x) {
  __builtin_prefetch(reinterpret_cast<const char*>(x) + kBytesAhead);
}

BRIM_INLINE FloatLanes all_of(float x) { return FloatLanes{x, x, x, x}; }
BRIM_INLINE FloatLanes lanes(const FluidPairs::Vec4& x) { return load_lanes(x.data()); }
template <class Widest>
BRIM_INLINE Chains<Widest> chains(const FluidPairs::Vec4* x) {
  return load_widest<Widest>(x->data());
}
template <class Widest>
BRIM_INLINE Chains<Widest> chains(const FluidPairs::Vec4* x, const std::int32_t* j) {
  return join<Widest>(lanes(x[j[0]]), lanes(x[j[1]]), lanes(x[j[2]]), lanes(x[j[3]]));
}

// Of each vector: the sum of its lanes, in all of them; and its fourth lane in all.
BRIM_INLINE FloatLanes dot_of(const FloatLanes& t) {
  const FloatLanes pairs = t + __builtin_shufflevector(t, t, 1, 0, 3, 2);
  return pairs + __builtin_shufflevector(pairs, pairs, 2, 3, 0, 1);
}
BRIM_INLINE WideFloats dot_of(const WideFloats& t) {
  const WideFloats pairs = t + __builtin_shufflevector(t, t, 1, 0, 3, 2, 5, 4, 7, 6);
  return pairs + __builtin_shufflevector(pairs, pairs, 2, 3, 0, 1, 6, 7, 4, 5);
}
[[maybe_unused]] BRIM_INLINE InOne::Floats dot_of(const InOne::Floats& t) {
  const InOne::Floats pairs = t + __builtin_shufflevector(t, t, 1, 0, 3, 2, 5, 4, 7, 6, 9, 8, 11, 10, 13, 12, 15, 14);
  return pairs + __builtin_shufflevector(pairs, pairs, 2, 3, 0, 1, 6, 7, 4, 5, 10, 11, 8, 9, 14, 15, 12, 13);
}
BRIM_INLINE InTwo::Floats dot_of(const InTwo::Floats& t) { return {dot_of(t.low), dot_of(t.high)}; }
BRIM_INLINE FloatLanes fourth_of(const FloatLanes& g) { return __builtin_shufflevector(g, g, 3, 3, 3, 3); }
BRIM_INLINE WideFloats fourth_of(const WideFloats& g) { return __builtin_shufflevector(g, g, 3, 3, 3, 3, 7, 7, 7, 7); }
[[maybe_unused]] BRIM_INLINE InOne::Floats fourth_of(const InOne::Floats& g) {
  return __builtin_shufflevector(g, g, 3, 3, 3, 3, 7, 7, 7, 7, 11, 11, 11, 11, 15, 15, 15, 15);
}
BRIM_INLINE InTwo::Floats fourth_of(const InTwo::Floats& g) { return {fourth_of(g.low), fourth_of(g.high)}; }

/// Pairs of a block of particles, first[k] to first[k + 1] those of its particle k.
struct Pairs {
  const std::int32_t *first, *neighbour;
  const FluidPairs::Vec4* gradient;
  std::size_t particles;
};

template <class Widest>
BRIM_INLINE void sum_rates(const Pairs& b, const FluidPairs::Vec4* v, const FluidPairs::Vec4* own, const float* weight,
                           float* rate) {
  for (std::size_t k = 0; k < b.particles; ++k) {
    rate[k] = 0.0f;
    if (!(weight[k] > 0.0f)) continue;
    const FloatLanes vi = lanes(own[k]);
    const auto vis = join<Widest>(vi, vi, vi, vi);
    Chains<Widest> s = {};
    FloatLanes rest = {};
    std::int32_t e = b.first[k];
    for (const std::int32_t last = b.first[k + 1]; e < last; e += kChains) {
      if (e + kChains > last) {
        for (; e < last; ++e) rest += lanes(b.gradient[e]) * (vi - lanes(v[b.neighbour[e]]));
        break;
      }
      s += chains<Widest>(b.gradient + e) * (vis - chains<Widest>(v, b.neighbour + e));
    }
    const FloatLanes sum = sum_of(s, rest);
    rate[k] = (sum[0] + sum[1]) + sum[2];
  }
}

template <class Widest>
BRIM_INLINE void sum_pressure(const Pairs& b, const float* p, const float* own, Eigen::Vector3d* y) {
  for (std::size_t k = 0; k < b.particles; ++k) {
    const float pi = own[k];
    Chains<Widest> s = {};
    FloatLanes rest = {};
    std::int32_t e = b.first[k];
    for (const std::int32_t last = b.first[k + 1]; e < last; e += kChains) {
      const std::int32_t* j = b.neighbour + e;
      if (e + kChains > last) {
        for (; e < last; ++e) rest += lanes(b.gradient[e]) * (pi + p[b.neighbour[e]]);
        break;
      }
      prefetch(b.gradient + e);
      s += chains<Widest>(b.gradient + e) *
           (pi + join<Widest>(all_of(p[j[0]]), all_of(p[j[1]]), all_of(p[j[2]]), all_of(p[j[3]])));
    }
    const FloatLanes sum = sum_of(s, rest);
    y[k] += Eigen::Vector3d(sum[0], sum[1], sum[2]);
  }
}

/// @param rate  takes the rates, or null
template <class Widest>
BRIM_INLINE void sum_viscosity(const Pairs& b, double scale, const FluidPairs::Vec4* v, const FluidPairs::Vec4* own,
                               float* rate, Eigen::Vector3d* y) {
  for (std::size_t k = 0; k < b.particles; ++k) {
    const FloatLanes vi = lanes(own[k]);
    const auto vis = join<Widest>(vi, vi, vi, vi);
    Chains<Widest> force = {}, closing = {};
    FloatLanes force_rest = {}, closing_rest = {};
    std::int32_t e = b.first[k];
    for (const std::int32_t last = b.first[k + 1]; e < last; e += kChains) {
      if (e + kChains > last) {
        for (; e < last; ++e) {
          const FloatLanes g = lanes(b.gradient[e]), c = dot_of(g * (vi - lanes(v[b.neighbour[e]])));
          force_rest += fourth_of(g) * c * g, closing_rest += c;
        }
        break;
      }
      // v has no fourth lane.
      prefetch(b.gradient + e);
      const Chains<Widest> g = chains<Widest>(b.gradient + e), d = g * (vis - chains<Widest>(v, b.neighbour + e)),
                           c = dot_of(d);
      force += fourth_of(g) * c * g, closing += c;
    }
    if (rate != nullptr) rate[k] = sum_of(closing, closing_rest)[0];
    const FloatLanes f = sum_of(force, force_rest);
    y[k] += scale * Eigen::Vector3d(f[0], f[1], f[2]);
  }
}

BRIM_WIDEST(block_rates,
            (const Pairs& b, const FluidPairs::Vec4* v, const FluidPairs::Vec4* own, const float* weight, float* rate),
            sum_rates<Widest>(b, v, own, weight, rate))
BRIM_WIDEST(block_pressure, (const Pairs& b, const float* p, const float* own, Eigen::Vector3d* y),
            sum_pressure<Widest>(b, p, own, y))
BRIM_WIDEST(block_viscosity,
            (const Pairs& b, double scale, const FluidPairs::Vec4* v, const FluidPairs::Vec4* own, float* rate,
             Eigen::Vector3d* y),
            sum_viscosity<Widest>(b, scale, v, own, rate, y))

}  // namespace

template <class F>
void FluidPairs::for_blocks(const F& f) const {
  parallel_blocks(size_, kBlock, [&](std::size_t begin, std::size_t end) {
    const Block& b = blocks_[begin / kBlock];
    f(begin, Pairs{b.first.data(), b.neighbour.data(), b.gradient.data(), end - begin});
  });
}

void FluidPairs::rates(std::span<const Vec4> v, std::span<const float> weight, std::span<float> rate) const {
  for_blocks([&](std::size_t begin, const Pairs& pairs) {
    block_rates(pairs, v.data(), v.data() + begin, weight.data() + begin, rate.data() + begin);
  });
}

void FluidPairs::add_pressure(std::span<const float> p, std::span<Eigen::Vector3d> y) const {
  for_blocks([&](std::size_t begin, const Pairs& pairs) {
    block_pressure(pairs, p.data(), p.data() + begin, y.data() + begin);
  });
}

void FluidPairs::add_viscosity(double s, std::span<const Vec4> v, std::span<float> rate,
                               std::span<Eigen::Vector3d> y) const {
  for_blocks([&](std::size_t begin, const Pairs& pairs) {
    block_viscosity(pairs, s, v.data(), v.data() + begin, rate.empty() ? nullptr : rate.data() + begin,
                    y.data() + begin);
  });
}

}  // namespace brim
