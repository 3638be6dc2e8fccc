#include "brim/body/grid_fluid/touched_cells.h"

#include <algorithm>

namespace brim {

void TouchedCells::note(const MacGrid& g, std::span<const Vec3> points, std::span<const std::uint8_t> by_fluid) {
  touched_.clear();
  if (points.empty()) return;
  touched_.assign(g.cells(), 0);
  for (std::size_t p = 0; p < points.size(); ++p) {
    const unsigned char how = !by_fluid.empty() && by_fluid[p] != 0 ? kByFluid : kTouched;
    const auto mark = [&](int cell) { touched_[cell] = std::max(touched_[cell], how); };
    const Vec3i at = ((points[p] - g.origin) / g.dx).array().floor().cast<int>().max(0).min(g.n.array() - 1);
    mark(g.cell(at));
    for (int a = 0; a < 3; ++a)
      for (const int side : {-1, 1})
        if (at[a] + side >= 0 && at[a] + side < g.n[a]) mark(g.cell(at) + side * g.cell_stride(a));
  }
}

}  // namespace brim
