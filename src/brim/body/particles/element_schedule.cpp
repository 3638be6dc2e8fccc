#include "brim/body/particles/element_schedule.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace brim {

namespace {

constexpr int kMaskColors = 64;

/// Spreads the low 10 bits of v to every third bit.
std::uint32_t spread(std::uint32_t v) {
  v = (v | (v << 16)) & 0x030000FF;
  v = (v | (v << 8)) & 0x0300F00F;
  v = (v | (v << 4)) & 0x030C30C3;
  return (v | (v << 2)) & 0x09249249;
}

}  // namespace

void ElementSchedule::build(std::span<const std::int32_t> node_of, int per_element, std::span<const Vec3> x) {
  const std::size_t elements = node_of.size() / per_element;
  Aabb box;
  for (const Vec3& p : x) box.extend(p);
  const double scale = x.empty() ? 0.0 : 1023.0 / std::max(box.extent().maxCoeff(), 1e-300);
  std::vector<std::uint32_t> code(elements);
  for (std::size_t e = 0; e < elements; ++e) {
    Vec3 center = Vec3::Zero();
    for (int i = 0; i < per_element; ++i) center += x[node_of[e * per_element + i]] / per_element;
    const Vec3 cell = (scale * (center - box.lo)).cwiseMax(0.0).cwiseMin(1023.0);
    code[e] = spread(static_cast<std::uint32_t>(cell.x())) | spread(static_cast<std::uint32_t>(cell.y())) << 1 |
              spread(static_cast<std::uint32_t>(cell.z())) << 2;
  }
  std::vector<std::int32_t> sorted(elements);
  std::iota(sorted.begin(), sorted.end(), 0);
  std::stable_sort(sorted.begin(), sorted.end(), [&](std::int32_t a, std::int32_t b) { return code[a] < code[b]; });

  // Each chunk takes the lowest colour that none of its nodes has met; beyond 64 colours each chunk gets its own.
  const std::size_t chunks = (elements + kChunk - 1) / kChunk;
  std::vector<std::uint64_t> met(x.size(), 0);
  std::vector<int> color(chunks);
  int colors = 0;
  for (std::size_t c = 0; c < chunks; ++c) {
    const std::size_t begin = c * kChunk, end = std::min(elements, begin + kChunk);
    std::uint64_t used = 0;
    const auto for_nodes = [&](const auto& f) {
      for (std::size_t k = begin; k < end; ++k)
        for (int i = 0; i < per_element; ++i) f(met[node_of[sorted[k] * static_cast<std::size_t>(per_element) + i]]);
    };
    for_nodes([&](std::uint64_t m) { used |= m; });
    const int free = std::countr_one(used);
    color[c] = free < kMaskColors ? free : std::max(colors, kMaskColors);
    if (free < kMaskColors) for_nodes([&](std::uint64_t& m) { m |= std::uint64_t{1} << free; });
    colors = std::max(colors, color[c] + 1);
  }

  order_.clear();
  chunk_first_.assign(1, 0);
  color_first_.assign(1, 0);
  for (int k = 0; k < colors; ++k) {
    for (std::size_t c = 0; c < chunks; ++c) {
      if (color[c] != k) continue;
      const std::size_t begin = c * kChunk, end = std::min(elements, begin + kChunk);
      order_.insert(order_.end(), sorted.begin() + begin, sorted.begin() + end);
      chunk_first_.push_back(static_cast<std::int32_t>(order_.size()));
    }
    color_first_.push_back(static_cast<std::int32_t>(chunk_first_.size()) - 1);
  }
}

}  // namespace brim
