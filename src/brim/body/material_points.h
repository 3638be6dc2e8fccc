#pragma once

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies that locate material points, whatever their coordinates mean: links (attachments,
/// joints) hold such points. Not needed by bodies with a solid (DistanceBound::solid) and bodies whose positions are
/// their map applied to q.  Tests: tests/world/links_test.cpp
class MaterialPoints {
 public:
  virtual ~MaterialPoints() = default;
  /// Rest position of the material at x in the last updated state, [m].
  virtual Vec3 material_at(int part, const Vec3& x) const = 0;
  /// Position of that material in the last updated state, [m].
  virtual Vec3 position_of(int part, const Vec3& X) const = 0;
};

}  // namespace brim
