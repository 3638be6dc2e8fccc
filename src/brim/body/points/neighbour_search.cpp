#include "brim/body/points/neighbour_search.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

constexpr int kBits = 21;
constexpr double kMaxCells = (1 << kBits) - 4.0;
constexpr std::uint64_t kNowhere = ~std::uint64_t{0};
constexpr std::size_t kSearchBlock = 1024;

}  // namespace

void NeighbourSearch::sort_into_cells(std::span<const Vec3> x, double cell) {
  Aabb box;
  for (const Vec3& p : x)
    if (p.allFinite()) box.extend(p);
  // Cells grow where so many of them would not have a number.
  if (!box.empty()) cell = std::max(cell, box.extent().maxCoeff() / kMaxCells);
  cell_of_.resize(x.size());
  sorted_.clear();
  for (std::size_t i = 0; i < x.size(); ++i) {
    cell_of_[i] = kNowhere;
    if (!x[i].allFinite()) continue;
    // Counted from 1, so that the neighbours below exist.
    const Vec3 c = ((x[i] - box.lo) / cell).array().floor() + 1.0;
    cell_of_[i] = static_cast<std::uint64_t>(c.z()) << 2 * kBits | static_cast<std::uint64_t>(c.y()) << kBits |
                  static_cast<std::uint64_t>(c.x());
    sorted_.push_back({cell_of_[i], static_cast<std::int32_t>(i)});
  }
  std::sort(sorted_.begin(), sorted_.end());
}

/// Calls f(j) for the balls in the 27 cells around that of ball i: nine runs of three cells along x.
template <class F>
void NeighbourSearch::for_neighbours(std::size_t i, const F& f) const {
  if (cell_of_[i] == kNowhere) return;
  for (std::int64_t dz = -1; dz <= 1; ++dz)
    for (std::int64_t dy = -1; dy <= 1; ++dy) {
      const std::uint64_t middle = cell_of_[i] + static_cast<std::uint64_t>(dz * (std::int64_t{1} << 2 * kBits) +
                                                                            dy * (std::int64_t{1} << kBits));
      auto it = std::lower_bound(sorted_.begin(), sorted_.end(), Entry{middle - 1, -1});
      for (; it != sorted_.end() && it->cell <= middle + 1; ++it) f(it->ball);
    }
}

std::span<const NeighbourSearch::Pair> NeighbourSearch::find(std::span<const Vec3> x, std::span<const double> radius,
                                                             double gap) {
  BRIM_CHECK(radius.size(), ==, x.size());
  const double largest = radius.empty() ? 0.0 : *std::max_element(radius.begin(), radius.end());
  sort_into_cells(x, std::max(2.0 * largest + gap, 1e-300));
  const auto near = [&](std::size_t i, std::int32_t j) {
    if (static_cast<std::size_t>(j) <= i) return false;
    const double reach = radius[i] + radius[j] + gap;
    return (x[i] - x[j]).squaredNorm() < reach * reach;
  };
  // Count, then fill: every ball owns its place in the list.
  first_.assign(x.size() + 1, 0);
  parallel_blocks(x.size(), kSearchBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) for_neighbours(i, [&](std::int32_t j) { first_[i + 1] += near(i, j); });
  });
  for (std::size_t i = 0; i < x.size(); ++i) first_[i + 1] += first_[i];
  pairs_.resize(first_.back());
  parallel_blocks(x.size(), kSearchBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::size_t at = first_[i];
      for_neighbours(i, [&](std::int32_t j) {
        if (near(i, j)) pairs_[at++] = {static_cast<std::int32_t>(i), j};
      });
      std::sort(pairs_.begin() + first_[i], pairs_.begin() + at);
    }
  });
  return pairs_;
}

}  // namespace brim
