#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/contact/cube_contacts.h"
#include "brim/math/types.h"

namespace brim {

/// True where both densities of a contact node lie on their ramps of width w, so that they give distances, and the two
/// surfaces face each other; elsewhere one surface turns away at an edge.
bool tells_distances(const ContactSet& contacts, std::size_t c, const ContactPair& pair);
/// True where both densities are on their ramps of width w.
bool on_ramps(const ContactSet& contacts, std::size_t c, const ContactPair& pair);
/// Distance from a node on both ramps to one of the two surfaces, [m].
double distance_to(const ContactSet& contacts, std::size_t c, bool of_a, double h);
/// True where the gradient of one part's density matches the slope of its ramp at that density. In the middle of a part
/// thinner than its ramp, e.g. on the axis of a capsule, it does not, and the gradient is normal to no nearby surface.
bool tells_direction(const ContactSet& contacts, std::size_t c, bool of_a, const ContactPair& pair);
/// Cosine between the normals of the two surfaces at a node, 1 where they face each other; −1 when one has none.
double facing(const ContactSet& contacts, std::size_t c);

/// The fixed part of a pair whose other part deforms: the fixed part's normals are used unless its curvature is the
/// larger one, so that a frictionless slider is not braked by the unevenness of its own surface.
enum class FixedPart : std::uint8_t { None, A, B };
/// Share of b's normal in the common normal, the rest being a's: the flatter surface gives the more accurate direction.
/// @param bend_a, bend_b  curvatures, [1/m]  @param h  [m] grid step
double share_of_b(double bend_a, double bend_b, FixedPart fixed, double h);

/// Quadratic model of the gap between two surfaces over a patch of nodes and its minimum: φ(y) = gap + slope·d + ½
/// d·curvature d, d: tangential part of y − x (docs/constraint.md).
struct PatchModel {
  Vec3 x = Vec3::Zero();                              ///< [m] centre of the nodes used in the fit
  Vec3 n = Vec3::UnitZ();                             ///< towards a, at the point of smallest gap
  double gap = 0.0;                                   ///< [m] at x
  Vec3 slope = Vec3::Zero();                          ///< [-]
  Mat3 curvature = Mat3::Zero();                      ///< [1/m] of the gap: sum over both surfaces
  Mat3 bend_a = Mat3::Zero(), bend_b = Mat3::Zero();  ///< [1/m] of each; zero where it is a plane
  Mat3 turn = Mat3::Zero();                           ///< [1/m] change of the normal along the patch
  Vec3 least_point = Vec3::Zero();                    ///< [m]
  double least_gap = 0.0;                             ///< [m]

  /// φ(y), [m].
  double gap_at(const Vec3& y) const;
  /// Tangential part of the normal at y: the sine of the angle by which it turns. Not small where one surface lies in a
  /// close-fitting hollow of the other.
  Vec3 turn_at(const Vec3& y) const;
  /// Unit normal at y, if it turns by less than a right angle.
  Vec3 normal_at(const Vec3& y) const;
  /// ½ d·curvature d about the point of smallest gap, at least 0: rise of the gap by curvature.
  double rise_at(const Vec3& y) const;
};

/// Fits models of patches. Holds only work space.
/// Tests: tests/response/constraint_test.cpp
class PatchFitter {
 public:
  /// The two solids of the next fits, whose faces are probed where nodes do not show that they are flat; or null.
  void set_solids(const CubeSide* a, const CubeSide* b) { solid_a_ = a, solid_b_ = b; }
  /// @param normals  unit, towards a, one per contact
  /// @param h        [m] grid step
  /// @param nodes    contacts of one patch, deepest first; not empty
  PatchModel fit(const ContactSet& contacts, std::span<const Vec3> normals, double h,
                 std::span<const std::size_t> nodes, FixedPart fixed = FixedPart::None);
  /// The nodes used in the last fit, all near the deepest.
  std::span<const std::size_t> near() const { return near_; }

 private:
  /// Corrects the model's turn of the normal from the nodes' own normals when these lie on one arc: for a shaft in its
  /// hub they are more accurate than the curvatures.
  void mend_turn(const ContactSet& contacts, std::span<const std::size_t> nodes, double share, double h,
                 PatchModel& model) const;

  const CubeSide *solid_a_ = nullptr, *solid_b_ = nullptr;
  std::vector<std::size_t> near_, level_;
  std::vector<double> weight_;
};

}  // namespace brim
