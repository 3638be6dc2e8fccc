#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

namespace brim {

/// The 3x3 blocks J of sparse rows, in single precision. Multiples of the identity, the usual case, are stored and
/// multiplied as one number.  Tests: tests/map/row_blocks_test.cpp
class RowBlocks {
 public:
  using Block = Eigen::Matrix3f;

  std::size_t size() const { return weight_.size(); }
  void clear() { weight_.clear(), general_.clear(), block_.clear(); }
  /// Appends weight times the identity.
  void add(float weight) { weight_.push_back(weight), general_.push_back(-1); }
  void add(const Block& J) {
    weight_.push_back(0.0f), general_.push_back(static_cast<std::int32_t>(block_.size()));
    block_.push_back(J);
  }
  /// Allocates n blocks, `general` of them not multiples of the identity; put fills them, from any thread.
  void resize(std::size_t n, std::size_t general) { weight_.resize(n), general_.resize(n), block_.resize(general); }
  /// Copies block e of another list, times `sign`, to index `at`. @param general  next free index of the general
  /// blocks, advanced when the block is general (not a multiple of the identity)
  void put(std::size_t at, std::int32_t& general, const RowBlocks& from, std::size_t e, float sign) {
    weight_[at] = sign * from.weight_[e], general_[at] = -1;
    if (from.general_[e] < 0) return;
    block_[general] = sign * from.block_[from.general_[e]];
    general_[at] = general++;
  }
  /// Number of general blocks in [begin, end).
  std::int32_t general(std::size_t begin, std::size_t end) const {
    return static_cast<std::int32_t>(std::count_if(general_.begin() + static_cast<std::ptrdiff_t>(begin),
                                                   general_.begin() + static_cast<std::ptrdiff_t>(end),
                                                   [](std::int32_t g) { return g >= 0; }));
  }

  /// True when the block is `weight` times the identity.
  bool plain(std::size_t e) const { return general_[e] < 0; }
  float weight(std::size_t e) const { return weight_[e]; }
  Block operator[](std::size_t e) const {
    return general_[e] < 0 ? Block(weight_[e] * Block::Identity()) : block_[general_[e]];
  }
  /// Jᵀ K
  Block transposed_times(std::size_t e, const Block& K) const {
    return general_[e] < 0 ? Block(weight_[e] * K) : Block(block_[general_[e]].transpose() * K);
  }
  /// K J
  Block times(const Block& K, std::size_t e) const {
    return general_[e] < 0 ? Block(weight_[e] * K) : Block(K * block_[general_[e]]);
  }
  /// tr(Jᵀ K J)
  float trace(std::size_t e, const Block& K) const {
    if (general_[e] >= 0) return (K * block_[general_[e]]).cwiseProduct(block_[general_[e]]).sum();
    const float w = weight_[e];
    return K(0, 0) * w * w + (K(1, 1) * w * w + K(2, 2) * w * w);
  }

 private:
  std::vector<float> weight_;
  std::vector<std::int32_t> general_;  ///< index in block_, −1 for multiples of the identity
  std::vector<Block> block_;
};

}  // namespace brim
