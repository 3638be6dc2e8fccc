#pragma once

#include <cstddef>
#include <span>

#include "brim/math/types.h"

namespace brim {

/// Particles processed by a thread at a time.
inline constexpr std::size_t kParticleGrain = 1024;

/// Position or velocity of particle i in coordinates of three numbers each.
inline Eigen::Map<const Vec3> particle_at(std::span<const double> a, std::size_t i) {
  return Eigen::Map<const Vec3>(a.data() + 3 * i);
}
inline Eigen::Map<Vec3> particle_at(std::span<double> a, std::size_t i) { return Eigen::Map<Vec3>(a.data() + 3 * i); }

}  // namespace brim
