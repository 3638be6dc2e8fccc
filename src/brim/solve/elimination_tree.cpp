#include "brim/solve/elimination_tree.h"

namespace brim {

std::vector<std::int32_t> elimination_tree(const LowerRows& lower) {
  const auto n = static_cast<std::int32_t>(lower.first.size()) - 1;
  std::vector<std::int32_t> parent(n, -1), ancestor(n, -1);
  for (std::int32_t i = 0; i < n; ++i)
    for (std::int32_t j : lower.row(i))
      while (j != -1 && j < i) {
        const std::int32_t next = ancestor[j];
        ancestor[j] = i;
        if (next == -1) parent[j] = i;
        j = next;
      }
  return parent;
}

std::vector<std::int32_t> postorder(std::span<const std::int32_t> parent) {
  const auto n = static_cast<std::int32_t>(parent.size());
  std::vector<std::int32_t> child(n + 1, -1), sibling(n, -1), order, stack;
  for (std::int32_t j = n; j-- > 0;) {
    const std::int32_t p = parent[j] < 0 ? n : parent[j];
    sibling[j] = child[p];
    child[p] = j;
  }
  order.reserve(n);
  for (std::int32_t root = child[n]; root != -1; root = sibling[root]) {
    stack.push_back(root);
    while (!stack.empty()) {
      const std::int32_t j = stack.back();
      if (child[j] != -1) {
        stack.push_back(child[j]);
        child[j] = -1;
        // The siblings of a child follow once it is done.
        continue;
      }
      stack.pop_back();
      order.push_back(j);
      if (j != root && sibling[j] != -1) stack.push_back(sibling[j]);
    }
  }
  return order;
}

}  // namespace brim
