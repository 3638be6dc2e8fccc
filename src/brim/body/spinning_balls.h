#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "brim/body/body.h"

namespace brim {

/// Optional interface of bodies of spinning balls: q has the centre of each ball, v six numbers per ball, the velocity
/// of the centre and the spin in world axes. Orientations are not stored, as they have no effect.
class SpinningBalls {
 public:
  virtual ~SpinningBalls() = default;
  virtual std::int32_t balls() const = 0;  ///< number of them; sources are 0 to that
  /// [m] centre of the ball of a node's source, in the last updated state.
  virtual const Vec3& ball_center(std::int32_t source) const = 0;
  virtual double ball_radius(std::int32_t source) const = 0;  ///< [m]
  virtual double least_radius() const = 0;                    ///< [m] of all balls
  /// Says what parts that do not move press each ball with in the step to come, for its rolling resistance.
  /// @param load  [N], shape (balls)
  virtual void set_loads(std::span<const double> load) = 0;
};

/// Number of velocities per node of a body of nodes; the first three are those of its position.
inline std::size_t velocities_per_node(const Body& body) {
  return dynamic_cast<const SpinningBalls*>(&body) != nullptr ? 6 : 3;
}

}  // namespace brim
