#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace brim {

/// Two rows of a symmetric matrix and how strongly it couples them.
struct Coupling {
  std::int32_t a = 0, b = 0;
  float strength = 0.0f;  ///< >= 0, such as |A_ab| / √(|A_aa| |A_bb|)
};

/// Cuts the rows of a matrix where it couples them least: couplings are gone through from the strongest on (those
/// within 6 % count as equal, and come in the order given), and join the clusters of their rows where these have at
/// most `most` rows together (Kruskal 1956, with a bound).
/// @param rows  how many  @param joined  pairs of rows that stay together, whatever their size
/// @return the cluster of each row, counted from 0 in the order of their first rows; shape (rows)
/// Tests: tests/solve/strong_clusters_test.cpp
std::vector<std::int32_t> strong_clusters(std::size_t rows, std::span<const Coupling> couplings, std::size_t most,
                                          std::span<const Coupling> joined = {});

}  // namespace brim
