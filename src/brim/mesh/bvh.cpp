#include "brim/mesh/bvh.h"

#include <algorithm>
#include <numeric>

namespace brim {

Bvh::Bvh(std::span<const Aabb> boxes, int leaf_size) {
  if (boxes.empty()) return;
  items_.resize(boxes.size());
  std::iota(items_.begin(), items_.end(), 0);
  nodes_.reserve(2 * boxes.size());
  nodes_.emplace_back();

  struct Range {
    std::int32_t node, first, last;
  };
  std::vector<Range> todo = {{0, 0, static_cast<std::int32_t>(boxes.size())}};
  while (!todo.empty()) {
    const Range r = todo.back();
    todo.pop_back();
    Aabb box, centers;
    for (std::int32_t i = r.first; i < r.last; ++i) {
      box.extend(boxes[items_[i]]);
      centers.extend(boxes[items_[i]].center());
    }
    nodes_[r.node].box = box;
    if (r.last - r.first <= leaf_size) {
      nodes_[r.node].first = r.first;
      nodes_[r.node].count = r.last - r.first;
      continue;
    }
    int axis = 0;
    centers.extent().maxCoeff(&axis);
    const std::int32_t middle = r.first + (r.last - r.first) / 2;
    // The index breaks ties, so that the tree is the same everywhere.
    std::nth_element(items_.begin() + r.first, items_.begin() + middle, items_.begin() + r.last,
                     [&](std::int32_t i, std::int32_t j) {
                       const double a = boxes[i].center()[axis], b = boxes[j].center()[axis];
                       return a < b || (a == b && i < j);
                     });
    const auto left = static_cast<std::int32_t>(nodes_.size());
    nodes_[r.node].first = left;
    nodes_.resize(nodes_.size() + 2);
    todo.push_back({left, r.first, middle});
    todo.push_back({left + 1, middle, r.last});
  }
}

}  // namespace brim
