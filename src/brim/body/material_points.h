#pragma once

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies that know where a point of their matter is, whatever their coordinates mean: links
/// (attachments, joints) hold to such points. Bodies with a solid (DistanceBound::solid) and bodies whose positions are
/// their map applied to q need it not.  Tests: tests/world/links_test.cpp
class MaterialPoints {
 public:
  virtual ~MaterialPoints() = default;
  /// The matter at x in the last updated state, [m] at rest.
  virtual Vec3 material_at(int part, const Vec3& x) const = 0;
  /// Where that matter is in the last updated state, [m].
  virtual Vec3 position_of(int part, const Vec3& X) const = 0;
};

}  // namespace brim
