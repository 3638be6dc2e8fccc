#include "brim/world/vertex_range.h"

#include <algorithm>
#include <cstring>

#include "brim/core/simd.h"

namespace brim {

namespace {

constexpr std::size_t kWide = 8;
typedef float Wide __attribute__((vector_size(kWide * sizeof(float))));

/// @param n  a multiple of eight
BRIM_WIDE void extent(const float* x, const float* y, const float* z, std::size_t n, const float* a, float* least,
                      float* largest) {
  Wide low = {}, high = {};
  for (std::size_t i = 0; i < n; i += kWide) {
    Wide px, py, pz;
    std::memcpy(&px, x + i, sizeof px);
    std::memcpy(&py, y + i, sizeof py);
    std::memcpy(&pz, z + i, sizeof pz);
    const Wide d = px * a[0] + py * a[1] + pz * a[2];
    low = i == 0 ? d : (d < low ? d : low);
    high = i == 0 ? d : (d > high ? d : high);
  }
  *least = low[0], *largest = high[0];
  for (std::size_t k = 1; k < kWide; ++k) {
    *least = std::min(*least, low[k]);
    *largest = std::max(*largest, high[k]);
  }
}

}  // namespace

VertexRange::VertexRange(std::span<const Vec3> points) : count_(points.size()) {
  if (count_ == 0) return;
  for (const Vec3& p : points) mean_ += p;
  mean_ /= static_cast<double>(count_);
  const std::size_t n = (count_ + kWide - 1) / kWide * kWide;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3f p = (points[std::min(i, count_ - 1)] - mean_).cast<float>();
    x_.push_back(p.x()), y_.push_back(p.y()), z_.push_back(p.z());
  }
}

std::pair<double, double> VertexRange::along(const Vec3& a) const {
  const Vec3f direction = a.cast<float>();
  float least = 0.0f, largest = 0.0f;
  extent(x_.data(), y_.data(), z_.data(), x_.size(), direction.data(), &least, &largest);
  const double middle = a.dot(mean_);
  return {middle + least, middle + largest};
}

std::shared_ptr<const VertexRange> VertexRanges::of(const std::vector<Vec3>& points) {
  for (const auto& [list, range] : known_)
    if (list->size() == points.size() && *list == points) return range;
  known_.emplace_back(&points, std::make_shared<const VertexRange>(points));
  return known_.back().second;
}

}  // namespace brim
