#pragma once

#include <cstddef>
#include <span>

namespace brim {

/// Velocities [begin, end) of a body.
struct VelocityRange {
  std::size_t begin = 0, end = 0;
};

/// Optional interface of bodies most of whose velocities may be zero, such as fluids that fill a part of their grid.
class IdleVelocities {
 public:
  virtual ~IdleVelocities() = default;
  /// Long ranges that filter sets to zero until the next update, ascending: a solve does no work on them.
  virtual std::span<const VelocityRange> idle_velocities() const = 0;
};

}  // namespace brim
