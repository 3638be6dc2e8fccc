#include "brim/body/particles/element_clusters.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "brim/body/particles/motion_bounds.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

/// Elements of a cluster, over the elements that there are for a particle, at most: some thirty particles, and four.
constexpr std::size_t kCoarse = 32, kFine = 4;

/// Halves elements across the longest side of their middles until they are few enough. @param leaf  called with each
/// run
template <class Leaf>
void cut(std::span<std::int32_t> elements, std::span<const Vec3> middle, std::size_t most, const Leaf& leaf) {
  if (elements.size() <= most) {
    leaf(elements);
    return;
  }
  Aabb box;
  for (const std::int32_t e : elements) box.extend(middle[e]);
  Eigen::Index axis = 0;
  box.extent().maxCoeff(&axis);
  const std::size_t half = elements.size() / 2;
  std::nth_element(elements.begin(), elements.begin() + static_cast<std::ptrdiff_t>(half), elements.end(),
                   [&](std::int32_t a, std::int32_t b) {
                     return middle[a][axis] != middle[b][axis] ? middle[a][axis] < middle[b][axis] : a < b;
                   });
  cut(elements.first(half), middle, most, leaf);
  cut(elements.subspan(half), middle, most, leaf);
}

}  // namespace

void ElementClusters::build(std::span<const Vec3> rest, const ParticleContact::Elements& elements) {
  coarse_ = {}, fine_ = {};
  first_fine_.assign(1, 0);
  const bool alone = elements.node.empty();
  const auto corners = static_cast<std::size_t>(alone ? 1 : elements.per_element);
  const std::size_t count = alone ? rest.size() : elements.node.size() / corners;
  if (count == 0) return;
  const auto corner = [&](std::int32_t e, std::size_t k) {
    return alone ? e : elements.node[corners * static_cast<std::size_t>(e) + k];
  };
  std::vector<std::int32_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::vector<Vec3> middle(count, Vec3::Zero());
  for (const std::int32_t e : order)
    for (std::size_t k = 0; k < corners; ++k) middle[e] += rest[corner(e, k)] / static_cast<double>(corners);

  std::vector<std::int32_t> seen(rest.size(), -1);
  std::int32_t mark = 0;
  const auto close = [&](Clusters& c, std::span<const std::int32_t> run) {
    for (const std::int32_t e : run)
      for (std::size_t k = 0; k < corners; ++k)
        if (std::int32_t& last = seen[corner(e, k)]; last != mark) last = mark, c.node.push_back(corner(e, k));
    c.first.push_back(static_cast<std::int32_t>(c.node.size()));
    ++mark;
  };
  const auto most = [&](std::size_t particles) { return std::max<std::size_t>(1, particles * count / rest.size()); };
  cut(order, middle, most(kCoarse), [&](std::span<std::int32_t> run) {
    close(coarse_, run);
    cut(run, middle, most(kFine), [&](std::span<std::int32_t> part) { close(fine_, part); });
    first_fine_.push_back(static_cast<std::int32_t>(fine_.first.size()) - 1);
  });
}

void ElementClusters::measure(std::span<const Vec3> x, std::span<const double> v, double reach,
                              std::vector<MotionCluster>& out) const {
  const std::size_t first = out.size();
  out.resize(first + size());
  parallel_blocks(size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) out[first + c] = motion_bounds(x, v, coarse_.of(c), reach);
  });
}

void ElementClusters::measure_finer(std::size_t c, std::span<const Vec3> x, std::span<const double> v, double reach,
                                    std::vector<MotionCluster>& out) const {
  for (std::int32_t k = first_fine_[c]; k < first_fine_[c + 1]; ++k)
    out.push_back(motion_bounds(x, v, fine_.of(static_cast<std::size_t>(k)), reach));
}

}  // namespace brim
