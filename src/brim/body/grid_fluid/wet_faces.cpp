#include "brim/body/grid_fluid/wet_faces.h"

namespace brim {

namespace {
/// Least share of a face at the surface: lighter faces would only spoil the condition of the pressure solve.
constexpr double kLeastWet = 0.05;
}  // namespace

void WetFaces::find(const MacGrid& g, std::span<const double> phi, const std::array<bool, 6>& open) {
  cell.resize(g.cells());
  kind.resize(g.faces());
  share.resize(g.faces());
  wet_cells = 0;
  for (std::size_t c = 0; c < cell.size(); ++c) wet_cells += cell[c] = phi[c] < 0.0;
  const Vec3i places = g.n + Vec3i::Ones();
  for_places(places, [&](int i, int j, int k) {
    for (int a = 0; a < 3; ++a) {
      const int f = g.face(a, i, j, k);
      kind[f] = Kind::Dry;
      share[f] = 0.0;
      Vec3i hi(i, j, k), lo = hi - Vec3i::Unit(a);
      const Vec3i count = g.face_count(a);
      if (i >= count.x() || j >= count.y() || k >= count.z()) continue;
      const bool low_side = lo[a] < 0, high_side = hi[a] >= g.n[a];
      if (low_side || high_side) {
        if (!cell[g.cell(low_side ? hi : lo)]) continue;
        kind[f] = open[2 * a + (high_side ? 1 : 0)] ? Kind::Free : Kind::Wall;
        share[f] = 0.5;
        continue;
      }
      const int cl = g.cell(lo), ch = g.cell(hi);
      if (!cell[cl] && !cell[ch]) continue;
      kind[f] = Kind::Free;
      share[f] = 1.0;
      if (cell[cl] && cell[ch]) continue;
      const double in = cell[cl] ? phi[cl] : phi[ch], out = cell[cl] ? phi[ch] : phi[cl];
      share[f] = std::max(in / (in - out), kLeastWet);
    }
  });
  touches_walls = std::find(kind.begin(), kind.end(), Kind::Wall) != kind.end();
}

}  // namespace brim
