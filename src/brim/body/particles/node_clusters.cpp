#include "brim/body/particles/node_clusters.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace brim {

namespace {

/// Particles of a cluster, without its neighbours, at most.
constexpr std::size_t kCluster = 32;

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
  for (std::size_t c = 0; c < size(); ++c) {
    const auto nodes = std::span(node_).subspan(first_[c], static_cast<std::size_t>(first_[c + 1] - first_[c]));
    if (nodes.empty()) continue;
    MotionCluster m;
    for (const std::int32_t i : nodes) {
      m.box.extend(x[i]);
      m.velocity.extend(Vec3(Eigen::Map<const Vec3>(v.data() + 3 * static_cast<std::size_t>(i))));
    }
    m.box = m.box.inflated(reach);
    out.push_back(m);
  }
}

}  // namespace brim
