#pragma once

#include <cstdint>
#include <vector>

#include "brim/map/row_blocks.h"

namespace brim {

/// A map as sparse rows of 3x3 blocks: u_p = Σ_e J_e v[3 c_e .. 3 c_e + 3), e from first[p] to first[p + 1], c_e the
/// block column of the body's velocities. Single precision, for preconditioners; forces go through Map itself.
struct MapRows {
  std::vector<std::int32_t> first{0};  ///< shape (points + 1)
  std::vector<std::int32_t> column;    ///< shape (entries)
  RowBlocks blocks;                    ///< J, shape (entries)

  void clear() {
    first.assign(1, 0);
    column.clear(), blocks.clear();
  }
  /// Appends an entry. @param J  a block, or a float that multiplies the identity
  template <class J>
  void add(std::int32_t c, const J& j) {
    column.push_back(c), blocks.add(j);
  }
  void end_row() { first.push_back(static_cast<std::int32_t>(column.size())); }
};

/// Optional interface of maps that are sparse in blocks of three velocities: their contact can be factored across
/// bodies.
class SparseMap {
 public:
  virtual ~SparseMap() = default;
  /// Appends the rows of all points. @return false, with nothing appended, when this map has no such rows
  virtual bool append_rows(MapRows& out) const = 0;
};

}  // namespace brim
