#pragma once

#include "brim/math/types.h"

namespace brim {

class PosedShape;

/// What a Body may be besides where it can tell cheaply how far the surface of a part is. The world then leaves out
/// tiles on which the bounds of two parts leave no room for contact (world/tile_culling.h).
class DistanceBound {
 public:
  virtual ~DistanceBound() = default;
  /// A lower bound of the signed distance d from x to the part's surface, negative inside, [m], where the part's
  /// density is ramp(d, w), where d changes by no more than x moves. Minus infinity where none is known.
  virtual double distance_bound(int part, const Vec3& x) const = 0;
  /// The part as a solid with its place in the world, where it is one: contact then samples it itself, only at the
  /// nodes that it needs, and does not call Body::presence and Body::rasterize.
  virtual const PosedShape* solid(int part) const {
    (void)part;
    return nullptr;
  }
};

}  // namespace brim
