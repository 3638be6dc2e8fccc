#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "brim/raster/node_span.h"

namespace brim {

/// Consecutive elements of a list in groups of 32, with the distinct vertices of each group: the nodes around a group
/// cost a tenth of those around its elements, and a group far from the query is skipped as a whole. Efficient when
/// neighbours are close in the list.  Tests: tests/raster/element_groups_test.cpp
class ElementGroups {
 public:
  static constexpr std::size_t kSize = 32;

  template <std::size_t N>
  void build(std::span<const std::array<std::int32_t, N>> elements) {
    first_.assign(1, 0), vertex_.clear();
    for (std::size_t begin = 0; begin < elements.size(); begin += kSize) {
      for (std::size_t e = begin; e < std::min(begin + kSize, elements.size()); ++e)
        vertex_.insert(vertex_.end(), elements[e].begin(), elements[e].end());
      const auto of_group = vertex_.begin() + first_.back();
      std::sort(of_group, vertex_.end());
      vertex_.erase(std::unique(of_group, vertex_.end()), vertex_.end());
      first_.push_back(static_cast<std::int32_t>(vertex_.size()));
    }
  }
  /// Nodes in the bounding box of a group's vertices, extended by `more`.
  NodeSpan around(const VertexNodes& nodes, std::size_t group, std::int32_t more) const {
    return nodes.around(std::span(vertex_).subspan(first_[group], first_[group + 1] - first_[group])).grown(more);
  }

 private:
  std::vector<std::int32_t> first_{0}, vertex_;
};

/// For a BoxList whose elements are not grouped.
struct Ungrouped {
  NodeSpan operator()(std::size_t) const { return NodeSpan::all(); }
};

/// The boxes of a list of elements, for TileBins and TileCover.
template <class BoxOf, class GroupOf = Ungrouped>
struct BoxList {
  std::size_t count;
  BoxOf box_of;        ///< box_of(i): Aabb [m] or NodeSpan of all nodes that element i may reach
  GroupOf group_of{};  ///< group_of(g): NodeSpan that contains those of elements 32 g to 32 g + 31

  std::size_t groups() const { return (count + ElementGroups::kSize - 1) / ElementGroups::kSize; }
  /// Calls f(i) for the elements of a group.
  template <class F>
  void for_group(std::size_t g, const F& f) const {
    for (std::size_t i = g * ElementGroups::kSize; i < std::min(count, (g + 1) * ElementGroups::kSize); ++i) f(i);
  }
};

}  // namespace brim
