#include "brim/body/particles/node_clusters.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "brim/core/parallel.h"
#include "brim/core/simd.h"

namespace brim {

namespace {

/// Particles of a cluster, without its neighbours, at most.
constexpr std::size_t kCluster = 32;

/// Least and largest of vectors, four numbers at a time of which the last means nothing.
struct Range {
  Lanes lo, hi;
  BRIM_INLINE void extend(const Lanes& x) {
    lo = x < lo ? x : lo;
    hi = x > hi ? x : hi;
  }
  BRIM_INLINE Aabb box() const { return {Vec3(lo[0], lo[1], lo[2]), Vec3(hi[0], hi[1], hi[2])}; }
};

BRIM_WIDE MotionCluster measured(std::span<const Vec3> x, std::span<const double> v,
                                 std::span<const std::int32_t> nodes, double reach) {
  const auto last = static_cast<std::int32_t>(x.size()) - 1;
  // Nothing follows the last vector in memory.
  const double last_x[4] = {x[last].x(), x[last].y(), x[last].z(), 0.0};
  const double* const last_of_v = v.data() + 3 * static_cast<std::size_t>(last);
  const double last_v[4] = {last_of_v[0], last_of_v[1], last_of_v[2], 0.0};
  constexpr double kMost = std::numeric_limits<double>::infinity();
  Range place{Lanes{} + kMost, Lanes{} - kMost}, speed = place;
  for (const std::int32_t i : nodes) {
    place.extend(load_lanes(i < last ? x[i].data() : last_x));
    speed.extend(load_lanes(i < last ? v.data() + 3 * static_cast<std::size_t>(i) : last_v));
  }
  return {place.box().inflated(reach), speed.box()};
}

}  // namespace

void NodeClusters::build(std::span<const Vec3> rest, const BlockMatrix& pattern) {
  first_.assign(1, 0);
  node_.clear();
  std::vector<std::int32_t> order(rest.size());
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::int32_t> seen(rest.size(), -1);
  const auto close = [&](std::span<const std::int32_t> own) {
    const auto cluster = static_cast<std::int32_t>(size());
    const auto add = [&](std::int32_t i) {
      if (seen[i] != cluster) seen[i] = cluster, node_.push_back(i);
    };
    for (const std::int32_t i : own)
      for (std::int32_t s = pattern.row_first()[i]; s < pattern.row_first()[i + 1]; ++s) add(pattern.columns()[s]);
    first_.push_back(static_cast<std::int32_t>(node_.size()));
  };
  // Halves across the longest side, until they are small enough.
  std::vector<std::pair<std::size_t, std::size_t>> open = {{0, rest.size()}};
  while (!open.empty()) {
    const auto [begin, end] = open.back();
    open.pop_back();
    const auto part = std::span(order).subspan(begin, end - begin);
    if (part.size() <= kCluster) {
      close(part);
      continue;
    }
    Aabb box;
    for (const std::int32_t i : part) box.extend(rest[i]);
    Eigen::Index axis = 0;
    box.extent().maxCoeff(&axis);
    const std::size_t half = part.size() / 2;
    std::nth_element(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(half), part.end(),
                     [&](std::int32_t a, std::int32_t b) {
                       return rest[a][axis] != rest[b][axis] ? rest[a][axis] < rest[b][axis] : a < b;
                     });
    open.emplace_back(begin + half, end);
    open.emplace_back(begin, begin + half);
  }
}

void NodeClusters::measure(std::span<const Vec3> x, std::span<const double> v, double reach,
                           std::vector<MotionCluster>& out) const {
  if (x.empty()) return;
  const std::size_t first = out.size();
  out.resize(first + size());
  parallel_blocks(size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c)
      out[first + c] = measured(
          x, v, std::span(node_).subspan(first_[c], static_cast<std::size_t>(first_[c + 1] - first_[c])), reach);
  });
}

}  // namespace brim
