#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Binary tree of boxes over any items, split at the median of the longest axis of the item centres. The tree depends
/// only on the boxes. Node 0 is the root; children come after their parent.
class Bvh {
 public:
  struct Node {
    Aabb box;
    std::int32_t first = 0;  ///< leaf: first index in items(); inner node: left child (the right one is first + 1)
    std::int32_t count = 0;  ///< leaf: number of items; inner node: 0
  };

  Bvh() = default;
  explicit Bvh(std::span<const Aabb> boxes, int leaf_size = 4);

  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<std::int32_t>& items() const { return items_; }
  bool empty() const { return nodes_.empty(); }

  static double squared_distance(const Aabb& b, const Vec3& p) {
    return (b.lo - p).cwiseMax(p - b.hi).cwiseMax(0.0).squaredNorm();
  }

  /// Visits items that may be nearer to p than the best so far, nearest boxes first.
  /// `visit(item, best2)` lowers best2 [m²] when the item is nearer.
  template <class Visit>
  void nearest(const Vec3& p, double& best2, const Visit& visit) const {
    if (nodes_.empty()) return;
    struct Entry {
      std::int32_t node;
      double d2;
    };
    Entry stack[96];
    int top = 0;
    stack[top++] = {0, squared_distance(nodes_[0].box, p)};
    while (top > 0) {
      const Entry e = stack[--top];
      if (e.d2 > best2) continue;
      const Node& n = nodes_[static_cast<std::size_t>(e.node)];
      if (n.count > 0) {
        for (std::int32_t k = 0; k < n.count; ++k) visit(items_[static_cast<std::size_t>(n.first + k)], best2);
        continue;
      }
      const double dl = squared_distance(nodes_[static_cast<std::size_t>(n.first)].box, p);
      const double dr = squared_distance(nodes_[static_cast<std::size_t>(n.first) + 1].box, p);
      // The nearer child goes on top of the stack.
      if (dl <= dr) {
        stack[top++] = {n.first + 1, dr};
        stack[top++] = {n.first, dl};
      } else {
        stack[top++] = {n.first, dl};
        stack[top++] = {n.first + 1, dr};
      }
    }
  }

  /// Calls visit(item) for every item whose leaf box overlaps the box.
  template <class Visit>
  void overlapping(const Aabb& box, const Visit& visit) const {
    if (nodes_.empty()) return;
    std::int32_t stack[96];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& n = nodes_[static_cast<std::size_t>(stack[--top])];
      if (!n.box.overlaps(box)) continue;
      if (n.count > 0) {
        for (std::int32_t k = 0; k < n.count; ++k) visit(items_[static_cast<std::size_t>(n.first + k)]);
      } else {
        stack[top++] = n.first + 1;
        stack[top++] = n.first;
      }
    }
  }

 private:
  std::vector<Node> nodes_;
  std::vector<std::int32_t> items_;
};

}  // namespace brim
