#include "brim/body/grid_fluid/touched_cells.h"

#include <utility>

namespace brim {

namespace {
/// [cells] within which a cell is as near as can be, and from which on it is not near.
constexpr int kNear = 2, kFar = 4;
}  // namespace

void TouchedCells::note(const MacGrid& g, std::span<const Vec3> points) {
  nearness_.clear();
  if (points.empty()) return;
  nearness_.assign(g.cells(), 0.0F);
  front_.clear();
  for (const Vec3& x : points) {
    const Vec3i at = ((x - g.origin) / g.dx).array().floor().cast<int>().max(0).min(g.n.array() - 1);
    float& n = nearness_[g.cell(at)];
    if (n == 0.0F) front_.push_back(g.cell(at));
    n = 1.0F;
  }
  for (int way = 1; way < kFar; ++way) {
    const float near = way <= kNear ? 1.0F : static_cast<float>(kFar - way) / static_cast<float>(kFar - kNear);
    next_.clear();
    for (const int c : front_) {
      const Vec3i at(c % g.n.x(), c / g.n.x() % g.n.y(), c / (g.n.x() * g.n.y()));
      for (int a = 0; a < 3; ++a)
        for (const int side : {-1, 1}) {
          if (at[a] + side < 0 || at[a] + side >= g.n[a]) continue;
          const int other = c + side * g.cell_stride(a);
          if (nearness_[other] > 0.0F) continue;
          nearness_[other] = near;
          next_.push_back(other);
        }
    }
    std::swap(front_, next_);
  }
}

}  // namespace brim
