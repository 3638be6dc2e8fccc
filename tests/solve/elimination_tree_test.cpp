#include "brim/solve/elimination_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace brim::elimination_tree_test {
namespace {

/// What lies below the diagonal in each column of a matrix: rows in order.
using Columns = std::vector<std::set<std::int32_t>>;

Columns random_matrix(std::int32_t n, double share, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Columns below(n);
  for (std::int32_t j = 0; j < n; ++j)
    for (std::int32_t i = j + 1; i < n; ++i)
      if (unit(rng) < share) below[j].insert(i);
  return below;
}

LowerRows rows_of(const Columns& below) {
  LowerRows lower;
  lower.first.push_back(0);
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(below.size()); ++i) {
    for (std::int32_t j = 0; j < i; ++j)
      if (below[j].contains(i)) lower.column.push_back(j);
    lower.first.push_back(static_cast<std::int32_t>(lower.column.size()));
  }
  return lower;
}

/// The factor's pattern, by eliminating column after column: each hands its rows to the column of the first of them.
Columns eliminate(Columns below) {
  for (std::size_t j = 0; j < below.size(); ++j) {
    if (below[j].empty()) continue;
    const std::int32_t next = *below[j].begin();
    for (const std::int32_t i : below[j])
      if (i != next) below[next].insert(i);
  }
  return below;
}

TEST(EliminationTree, ParentIsTheFirstRowBelowTheDiagonalOfTheFactor) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Columns below = random_matrix(40, 0.02 + 0.01 * seed, seed), factor = eliminate(below);
    const std::vector<std::int32_t> parent = elimination_tree(rows_of(below));
    for (std::size_t j = 0; j < parent.size(); ++j)
      EXPECT_EQ(parent[j], factor[j].empty() ? -1 : *factor[j].begin()) << seed << ": " << j;
  }
}

TEST(EliminationTree, PostorderHoldsEachSubtreeInOneRunBeforeItsRoot) {
  const std::vector<std::int32_t> parent = elimination_tree(rows_of(random_matrix(60, 0.04, 3)));
  const std::vector<std::int32_t> order = postorder(parent);
  std::vector<std::int32_t> place(order.size(), -1), size(order.size(), 1), first(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = first[order[k]] = static_cast<std::int32_t>(k);
  EXPECT_EQ(std::count(place.begin(), place.end(), -1), 0) << "each column once";
  for (const std::int32_t j : order) {
    EXPECT_EQ(place[j] - first[j] + 1, size[j]) << "its subtree is what lies between";
    if (parent[j] < 0) continue;
    EXPECT_LT(place[j], place[parent[j]]);
    size[parent[j]] += size[j];
    first[parent[j]] = std::min(first[parent[j]], first[j]);
  }
}

TEST(EliminationTree, ColumnsAreCountedAsTheyAreFilled) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    // Counting wants columns in postorder.
    Columns below = random_matrix(40, 0.02 + 0.01 * seed, seed), renewed(below.size());
    const std::vector<std::int32_t> order = postorder(elimination_tree(rows_of(below)));
    std::vector<std::int32_t> place(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<std::int32_t>(k);
    for (std::size_t j = 0; j < below.size(); ++j)
      for (const std::int32_t i : below[j]) renewed[std::min(place[i], place[j])].insert(std::max(place[i], place[j]));
    const Columns factor = eliminate(renewed);
    const std::vector<std::int32_t> count =
        column_counts(elimination_tree(rows_of(renewed)), [&](std::int32_t j, const auto& f) {
          for (const std::int32_t i : renewed[j]) f(i);
        });
    for (std::size_t j = 0; j < count.size(); ++j)
      EXPECT_EQ(count[j], 1 + static_cast<std::int32_t>(factor[j].size())) << seed << ": " << j;
  }
}

}  // namespace
}  // namespace brim::elimination_tree_test
