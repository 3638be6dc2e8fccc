#include "brim/body/grid_fluid/surface_faces.h"

namespace brim {

void SurfaceFaces::find(const MacGrid& g, const WetFaces& wet, std::span<const double> phi) {
  n_ = g.n;
  cuts_.clear();
  start_.resize(g.cells() + 1);
  int cell = 0;
  for (int k = 0; k < g.n.z(); ++k)
    for (int j = 0; j < g.n.y(); ++j)
      for (int i = 0; i < g.n.x(); ++i, ++cell) {
        start_[static_cast<std::size_t>(cell)] = static_cast<std::int32_t>(cuts_.size());
        if (wet.cell[cell] || phi[cell] > 2.0 * g.dx) continue;
        const Vec3i c(i, j, k);
        for (int a = 0; a < 3; ++a)
          for (const int side : {-1, 1}) {
            if (c[a] + side < 0 || c[a] + side >= g.n[a]) continue;
            const int other = cell + side * g.cell_stride(a);
            if (!wet.cell[other]) continue;
            const int face = g.face(a, c) + (side < 0 ? 0 : g.face_stride(a));
            cuts_.push_back(
                {c.cast<double>(), side * phi[cell] / (phi[cell] - phi[other]), face, a, side < 0 ? 1.0 : -1.0});
          }
      }
  start_.back() = static_cast<std::int32_t>(cuts_.size());
}

}  // namespace brim
