#pragma once

#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace brim {

/// Rows of a lower triangle: the entries left of the diagonal in each, in any order.
struct LowerRows {
  std::vector<std::int32_t> first, column;

  std::span<const std::int32_t> row(std::int32_t i) const {
    return {column.data() + first[i], static_cast<std::size_t>(first[i + 1] - first[i])};
  }
};

/// Parent of each column in the elimination tree of a symmetric matrix, −1 for roots (Liu 1986).
/// Tests: tests/solve/elimination_tree_test.cpp
std::vector<std::int32_t> elimination_tree(const LowerRows& lower);

/// Postorder: children before parents, each subtree contiguous; the order of children is kept. @return the columns in
/// that order
std::vector<std::int32_t> postorder(std::span<const std::int32_t> parent);

/// Number of entries in each column of the factor, diagonal included, in time proportional to the matrix, not the
/// factor (Gilbert, Ng and Peyton 1994): row i of the factor is the subtree of the elimination tree between its entries
/// and i; a column counts once per subtree of which it is a leaf, minus the overlaps of such subtrees.
/// @param parent  columns in postorder  @param for_column  f(j, g): calls g(i) for the rows i > j of column j
template <class F>
std::vector<std::int32_t> column_counts(std::span<const std::int32_t> parent, const F& for_column) {
  const auto n = static_cast<std::int32_t>(parent.size());
  std::vector<std::int32_t> count(n, 0), first(n, -1), most(n, -1), leaf(n, -1), ancestor(n);
  std::iota(ancestor.begin(), ancestor.end(), 0);
  for (std::int32_t k = 0; k < n; ++k) {
    count[k] = first[k] == -1;
    for (std::int32_t j = k; j != -1 && first[j] == -1; j = parent[j]) first[j] = k;
  }
  // Meeting point of the subtrees of two columns, among the columns passed so far.
  const auto meet = [&](std::int32_t j) {
    std::int32_t q = j;
    while (q != ancestor[q]) q = ancestor[q];
    while (j != q) j = std::exchange(ancestor[j], q);
    return q;
  };
  for (std::int32_t j = 0; j < n; ++j) {
    if (parent[j] != -1) --count[parent[j]];
    for_column(j, [&](std::int32_t i) {
      if (first[j] <= most[i]) return;
      most[i] = first[j];
      const std::int32_t before = std::exchange(leaf[i], j);
      ++count[j];
      if (before != -1) --count[meet(before)];
    });
    if (parent[j] != -1) ancestor[j] = parent[j];
  }
  for (std::int32_t j = 0; j < n; ++j)
    if (parent[j] != -1) count[parent[j]] += count[j];
  return count;
}

}  // namespace brim
