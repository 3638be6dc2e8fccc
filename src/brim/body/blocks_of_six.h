#pragma once

#include <cstdint>
#include <span>

#include "brim/math/types.h"

namespace brim {

/// What couples the blocks of a body of many blocks of six, such as grains: with its blocks of the system's diagonal
/// (Body::add_system_diagonal) that is its whole part of the system of the step. Views of the body: good from
/// begin_solve to the next update.
struct SixCouplings {
  using Block = Eigen::Matrix<float, 6, 6>;
  std::span<const std::int32_t> first;       ///< of each block's row: its couplings to later blocks; shape (blocks + 1)
  std::span<const std::int32_t> column;      ///< the other block, larger than the row
  std::span<const Block> value;              ///< rows of the one, columns of the other
  std::span<const std::int32_t> prescribed;  ///< threes, two a block, whose velocity is given; sorted
};

/// Optional interface of such bodies: solvers may factor what they see of it.
class BlocksOfSix {
 public:
  virtual ~BlocksOfSix() = default;
  virtual SixCouplings couplings() const = 0;
};

}  // namespace brim
