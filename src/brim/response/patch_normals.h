#pragma once

#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/math/types.h"
#include "brim/response/patch_average.h"

namespace brim {

/// Directions and normals of a patch of contacts, averaged over 3h:
///   ĝ = (1−α) ∇ρ_a − α ∇ρ_b,  α = κ_a / (κ_a + κ_b): the direction comes from the flatter of the two parts
///   n = ĝ smoothed once more, unit, towards a
/// Holds only work space. Tests: tests/response/penalty_test.cpp
class PatchNormals {
 public:
  /// @param direction  [1/m] ĝ, per contact of the set; only the pair's entries are written
  /// @param normal     n, likewise
  /// @param sharp      α from squared curvatures: the edges of a box then leave no trace in its normals on a plane,
  ///                   which would brake its sliding
  /// @param brink      for a deformable part on a firm one, or held by rows, hardly overlapping: nodes are weighted by
  ///                   their overlap above the smallest of the pair. Else one node in overlap would turn all normals up
  ///                   to 6h away
  void find(const ContactSet& contacts, const ContactPair& pair, std::span<Vec3> direction, std::span<Vec3> normal,
            bool sharp = false, bool brink = false);

  /// Weight of a contact in patch averages: its overlap, or a small value before overlap, so that patches have normals
  /// before contact too.
  static double weight_of(const ContactSet& contacts, std::size_t c);

 private:
  /// Force and the two curvature tensors as xx, yy, zz, xy, xz, yz, of a neighbourhood; the last entry is unused.
  using Sample = InTwo::Floats;

  PatchLattice lattice_;
  PatchField<Sample> average_;
  PatchField<FloatLanes> direction_;
  std::vector<float> weight_, curvature_a_, curvature_b_;  ///< per contact of the pair
};

}  // namespace brim
