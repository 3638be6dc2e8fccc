#include "brim/world/space.h"

#include <algorithm>

namespace brim {

namespace {

class StillMap final : public Map {
 public:
  explicit StillMap(std::size_t points) : points_(points) {}
  std::size_t points() const override { return points_; }
  void apply(std::span<const double>, std::span<Vec3> u) const override { std::fill(u.begin(), u.end(), Vec3::Zero()); }
  void apply_transpose(std::span<const Vec3>, std::span<double>) const override {}
  void add_block_diagonal(std::span<const Mat3>, std::size_t, BlockDiagonal&) const override {}

 private:
  std::size_t points_;
};

}  // namespace

void Space::make_map(int, std::span<const Vec3> points, std::span<const std::int32_t>,
                     std::unique_ptr<Map>& map) const {
  map = std::make_unique<StillMap>(points.size());
}

}  // namespace brim
