#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/math/types.h"

namespace brim {

/// True where both densities of a contact node are on their ramps of width w, so that they tell distances, and the two
/// surfaces face each other; elsewhere one of them turns away at an edge.
bool tells_distances(const ContactSet& contacts, std::size_t c, const ContactPair& pair);
/// True where both densities are on their ramps of width w.
bool on_ramps(const ContactSet& contacts, std::size_t c, const ContactPair& pair);
/// What a node on both ramps says of the distance to one of the two surfaces, [m].
double distance_to(const ContactSet& contacts, std::size_t c, bool of_a, double h);
/// True where the density of one part rises as its ramp does at that density. In the middle of what is thinner than its
/// ramp, as at the axis of a capsule, it does not: there the gradient has the direction of no surface nearby.
bool tells_direction(const ContactSet& contacts, std::size_t c, bool of_a, const ContactPair& pair);
/// Cosine between the normals of the two surfaces at a node, 1 where they face each other; −1 where one has none.
double facing(const ContactSet& contacts, std::size_t c);

/// Which part of a pair is fixed, where the other one deforms: its normals then hold unless it has the sharper bend, so
/// that what slides on it without friction is not braked by the unevenness of its own surface.
enum class FixedPart : std::uint8_t { None, A, B };
/// Share of b's normal in the common one, the rest being a's: the flatter surface tells the direction better.
/// @param bend_a, bend_b  curvatures, [1/m]  @param h  [m] grid step
double share_of_b(double bend_a, double bend_b, FixedPart fixed, double h);

/// The gap between two surfaces over a patch of nodes, φ(y) = gap + slope·d + ½ d·curvature d with d the tangential
/// part of y − x, and where it is least (docs/constraint.md).
struct PatchModel {
  Vec3 x = Vec3::Zero();                              ///< [m] middle of the nodes that count
  Vec3 n = Vec3::UnitZ();                             ///< towards a, at the point of least gap
  double gap = 0.0;                                   ///< [m] at x
  Vec3 slope = Vec3::Zero();                          ///< [-]
  Mat3 curvature = Mat3::Zero();                      ///< [1/m] of the gap: the sum of both surfaces'
  Mat3 bend_a = Mat3::Zero(), bend_b = Mat3::Zero();  ///< [1/m] of each; zero where it is a plane
  Mat3 turn = Mat3::Zero();                           ///< [1/m] change of the normal along the patch
  Vec3 least_point = Vec3::Zero();                    ///< [m]
  double least_gap = 0.0;                             ///< [m]

  /// φ(y), [m].
  double gap_at(const Vec3& y) const;
  /// What the normal at y has across n: the sine of the angle by which it turns. Where one surface lies close in the
  /// hollow of another it is no small one.
  Vec3 turn_at(const Vec3& y) const;
  /// Unit normal at y, where it turns by less than a right angle.
  Vec3 normal_at(const Vec3& y) const;
  /// ½ d·curvature d about the point of least gap, at least 0: how far the gap rises by curvature.
  double rise_at(const Vec3& y) const;
};

/// Finds models of patches. Holds work space only.
/// Tests: tests/response/constraint_test.cpp
class PatchFitter {
 public:
  /// @param normals  unit, towards a, one per contact
  /// @param h        [m] grid step
  /// @param nodes    contacts of one patch, deepest first; not empty
  PatchModel fit(const ContactSet& contacts, std::span<const Vec3> normals, double h,
                 std::span<const std::size_t> nodes, FixedPart fixed = FixedPart::None);
  /// Those of the nodes that counted in the last fit, all near the deepest.
  std::span<const std::size_t> near() const { return near_; }

 private:
  /// Corrects how the normal turns by the nodes' own, where these lie on one arc: those of a shaft in its wheel tell it
  /// better than their curvature.
  void mend_turn(const ContactSet& contacts, std::span<const std::size_t> nodes, double share, double h,
                 PatchModel& model) const;

  std::vector<std::size_t> near_, level_;
  std::vector<double> weight_;
};

}  // namespace brim
