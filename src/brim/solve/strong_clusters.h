#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace brim {

/// Strength of the coupling of two rows of a symmetric matrix.
struct Coupling {
  std::int32_t a = 0, b = 0;
  float strength = 0.0f;  ///< >= 0, such as |A_ab| / √(|A_aa| |A_bb|)
};

/// Clusters the rows of a matrix, cutting its weakest couplings: couplings are processed from the strongest (within 6 %
/// they count as equal, and keep the given order), and merge the clusters of their rows if these have at most `most`
/// rows together (Kruskal 1956, with a bound).
/// @param rows  number of rows  @param joined  pairs of rows that stay together, whatever the cluster's size
/// @return the cluster of each row, numbered from 0 in the order of their first rows; shape (rows)
/// Tests: tests/solve/strong_clusters_test.cpp
std::vector<std::int32_t> strong_clusters(std::size_t rows, std::span<const Coupling> couplings, std::size_t most,
                                          std::span<const Coupling> joined = {});

}  // namespace brim
