#pragma once

#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/math/types.h"
#include "brim/response/patch_average.h"

namespace brim {

/// Finds the directions and normals of a patch of contacts, by averages over 3h:
///   ĝ = (1−α) ∇ρ_a − α ∇ρ_b,  α = κ_a / (κ_a + κ_b): the direction comes from the flatter of the two parts
///   n = ĝ smoothed once more, unit, towards a
/// Holds work space only. Tests: tests/response/penalty_test.cpp
class PatchNormals {
 public:
  /// @param direction  [1/m] ĝ, per contact of the set; those of the pair are written
  /// @param normal     n, likewise
  /// @param sharp      squares of the curvatures decide: nothing of a box's edges is left beside the plane that they
  ///                   slide on, which would brake it
  /// @param brink      what deforms lies on something fixed, or is held by rows, at the brink of overlap: nodes count
  ///                   by how far theirs is beyond the least. One alone in overlap would turn all normals up to 6h away
  void find(const ContactSet& contacts, const ContactPair& pair, std::span<Vec3> direction, std::span<Vec3> normal,
            bool sharp = false, bool brink = false);

  /// Weight of a contact in averages over its patch: its overlap, or a little where there is none yet, so that patches
  /// before touch have normals too.
  static double weight_of(const ContactSet& contacts, std::size_t c);

 private:
  /// Force, and the two curvature tensors as xx, yy, zz, xy, xz, yz, of a neighbourhood; the last is nothing.
  using Sample = WidestFloats;

  PatchLattice lattice_;
  PatchField<Sample> average_;
  PatchField<FloatLanes> direction_;
  std::vector<float> weight_, curvature_a_, curvature_b_;  ///< per contact of the pair
};

}  // namespace brim
