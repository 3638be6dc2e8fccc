#pragma once

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies that know where two of their parts may touch each other better than the boxes of the
/// parts do. The world then searches only there.
class MeetingRegion {
 public:
  virtual ~MeetingRegion() = default;
  /// A box of all places where parts p and q may touch; empty where there is none.
  ///   d_p(x) <= beyond,  d_q(x) <= beyond,  d_p(x) + d_q(x) <= gap   at such a place x, d: distance to the surface
  /// @param beyond, gap  [m]
  virtual Aabb meeting_region(int p, int q, double beyond, double gap) const = 0;
};

}  // namespace brim
