#pragma once

#include <cstdint>
#include <span>

#include "brim/math/types.h"

namespace brim {

/// Couplings between the blocks of a body with many blocks of six, such as grains. Together with its blocks of the
/// system's diagonal (Body::add_system_diagonal) they are its whole part of the system of the step. Views into the
/// body: valid from begin_solve to the next update.
struct SixCouplings {
  using Block = Eigen::Matrix<float, 6, 6>;
  std::span<const std::int32_t> first;       ///< per block row: its couplings to later blocks; shape (blocks + 1)
  std::span<const std::int32_t> column;      ///< the other block, larger than the row
  std::span<const Block> value;              ///< rows of the row block, columns of the other
  std::span<const std::int32_t> prescribed;  ///< triples, two per block, with prescribed velocity; sorted
};

/// Optional interface of such bodies: solvers may factor their system.
class BlocksOfSix {
 public:
  virtual ~BlocksOfSix() = default;
  virtual SixCouplings couplings() const = 0;
};

}  // namespace brim
