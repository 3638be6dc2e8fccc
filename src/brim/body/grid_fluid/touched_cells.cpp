#include "brim/body/grid_fluid/touched_cells.h"

namespace brim {

void TouchedCells::note(const MacGrid& g, std::span<const Vec3> points) {
  touched_.clear();
  if (points.empty()) return;
  touched_.assign(g.cells(), 0);
  for (const Vec3& x : points) {
    const Vec3i at = ((x - g.origin) / g.dx).array().floor().cast<int>().max(0).min(g.n.array() - 1);
    touched_[g.cell(at)] = 1;
    for (int a = 0; a < 3; ++a)
      for (const int side : {-1, 1})
        if (at[a] + side >= 0 && at[a] + side < g.n[a]) touched_[g.cell(at) + side * g.cell_stride(a)] = 1;
  }
}

}  // namespace brim
