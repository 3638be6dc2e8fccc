#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "brim/map/row_blocks.h"

namespace brim {

/// Contacts as rows over the velocities of all bodies: Δ_c = Σ_e J_e v[offset_e .. + 3), the relative velocity of the
/// two sides. Only sides whose maps are sparse rows appear (SparseMap). Filled by ContactMaps, read by all
/// factorizations of contact across bodies.
struct ContactRows {
  std::vector<std::uint32_t> contact;  ///< of the contact set, shape (n)
  std::vector<std::int32_t> first;     ///< shape (n + 1)
  std::vector<std::int32_t> offset;    ///< first of three velocities, world numbering; shape (entries)
  RowBlocks blocks;                    ///< J, negative on side b; shape (entries)
  /// [kg] dt (dt + β) K + dt C, contribution of a contact to the system of velocities; shape (n)
  std::vector<Eigen::Matrix3f> stiffness;

  std::size_t size() const { return contact.size(); }
};

}  // namespace brim
