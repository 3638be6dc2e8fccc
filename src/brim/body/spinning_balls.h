#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "brim/body/body.h"

namespace brim {

/// Optional interface of bodies of balls that turn: q has three numbers a ball, its centre, and v has six, the velocity
/// of the centre and the spin in the world's axes. How a ball is turned is not kept, as none can see it.
class SpinningBalls {
 public:
  virtual ~SpinningBalls() = default;
  /// [m] of the ball that the source of a node names, in the last updated state.
  virtual const Vec3& ball_center(std::int32_t source) const = 0;
  virtual double ball_radius(std::int32_t source) const = 0;  ///< [m]
  /// Says what parts that do not move press each ball with in the step to come, for its rolling resistance.
  /// @param load  [N], shape (balls)
  virtual void set_loads(std::span<const double> load) = 0;
};

/// Velocities of a node of a body of nodes, of which the first three are those of its place.
inline std::size_t velocities_per_node(const Body& body) {
  return dynamic_cast<const SpinningBalls*>(&body) != nullptr ? 6 : 3;
}

}  // namespace brim
