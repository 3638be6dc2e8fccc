#pragma once

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies that move as one rigid frame, v = (o', ω) in world axes, with A = diag(m 1, I): contact
/// rows between two of them need no maps, only lever arms and these numbers.
class RigidFrame {
 public:
  struct Frame {
    Vec3 center = Vec3::Zero();           ///< [m] o
    double inverse_mass = 0.0;            ///< [1/kg] of A, damping included; zero when prescribed
    Mat3 inverse_inertia = Mat3::Zero();  ///< [1/(kg m²)] likewise
  };

  virtual ~RigidFrame() = default;
  /// At the last update and begin_solve.
  virtual Frame rigid_frame() const = 0;
};

}  // namespace brim
