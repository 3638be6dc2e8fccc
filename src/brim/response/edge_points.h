#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/math/types.h"
#include "brim/response/node_places.h"
#include "brim/response/patch_model.h"

namespace brim {

/// A contact point at an edge or a tip.
struct EdgePoint {
  std::size_t node = 0;        ///< nearest contact
  Vec3 point = Vec3::Zero();   ///< [m]
  Vec3 normal = Vec3::Zero();  ///< unit, towards a
  double gap = 0.0;            ///< [m]
};

/// Finds contact points where the surfaces do not face each other: edges and tips on faces, edges across edges. There
/// the sum of the two distances d, which patches read as the gap, is right only between the two closest points. But
/// every node x on both ramps gives the closest points themselves, x − d_a ∇d_a and x − d_b ∇d_b, and so the gap along
/// a common normal n, that of the flatter surface:
///   φ = n·(d_b ∇d_b − d_a ∇d_a)
/// A connected group of nodes gives one point, or two when it stretches along an edge.
/// Tests: tests/response/constraint_test.cpp
class EdgePoints {
 public:
  /// @param faces  contacts of the pair handled as patches, ascending; nodes within two voxels of one are left to the
  ///               patches unless their gap is smaller
  std::span<const EdgePoint> find(const ContactSet& contacts, const ContactPair& pair,
                                  std::span<const std::size_t> faces, FixedPart fixed = FixedPart::None);

 private:
  struct Reading {
    std::size_t node;
    Vec3 point, normal;
    double gap;
  };
  void read(const ContactSet& contacts, const ContactPair& pair, std::span<const std::size_t> faces, FixedPart fixed);
  void add_points(double h);

  std::vector<EdgePoint> points_;
  std::vector<Reading> reading_, group_;
  std::vector<std::uint8_t> taken_;
  NodePlaces place_;
};

}  // namespace brim
