#pragma once

#include "brim/math/types.h"

namespace brim {

class PosedShape;

/// Optional interface of bodies with a cheap bound of the distance to a part's surface. The world then skips tiles on
/// which the bounds of two parts exclude contact (world/tile_culling.h).
class DistanceBound {
 public:
  virtual ~DistanceBound() = default;
  /// A lower bound of the signed distance d from x to the part's surface, negative inside, [m]. Required: the part's
  /// density is ramp(d, w) and d has Lipschitz constant 1. Minus infinity when no bound is known.
  virtual double distance_bound(int part, const Vec3& x) const = 0;
  /// The part as a solid with its pose, if it is one: contact then samples it directly, only at the nodes needed, and
  /// does not call Body::presence and Body::rasterize.
  virtual const PosedShape* solid(int part) const {
    (void)part;
    return nullptr;
  }
};

}  // namespace brim
