#include "brim/body/grid_fluid/wet_faces.h"

#include <algorithm>
#include <iterator>

namespace brim {

namespace {
/// Least share of a face at the surface: lighter faces would only spoil the condition of the pressure solve.
constexpr double kLeastWet = 0.05;
/// Faces of a range that counts as long.
constexpr std::size_t kLong = 256;
}  // namespace

void WetFaces::find(const MacGrid& g, std::span<const double> phi, const std::array<bool, 6>& sides,
                    std::span<const double> left) {
  cell.resize(g.cells());
  kind.resize(g.faces());
  share.resize(g.faces());
  open.assign(g.faces(), 1.0);
  for (std::size_t f = 0; f < left.size(); ++f) open[f] = left[f] < kLeastOpen ? 0.0 : left[f];
  wet.clear();
  for_places(g.n, [&](int i, int j, int k) {
    const Vec3i at(i, j, k);
    const int c = g.cell(at);
    cell[c] = phi[c] < 0.0;
    if (left.empty() || !cell[c]) return;
    bool any = false;
    for (int a = 0; a < 3; ++a) {
      const int f = g.face(a, at);
      const bool low = at[a] > 0 || sides[2 * a], high = at[a] + 1 < g.n[a] || sides[2 * a + 1];
      any = any || (low && open[f] > 0.0) || (high && open[f + g.face_stride(a)] > 0.0);
    }
    cell[c] = any;
  });
  for (std::size_t c = 0; c < cell.size(); ++c)
    if (cell[c]) wet.push_back(static_cast<std::int32_t>(c));
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
        const bool free = sides[2 * a + (high_side ? 1 : 0)];
        if (free && open[f] == 0.0) continue;
        kind[f] = free ? Kind::Free : Kind::Wall;
        share[f] = 0.5 * open[f];
        continue;
      }
      const int cl = g.cell(lo), ch = g.cell(hi);
      if ((!cell[cl] && !cell[ch]) || open[f] == 0.0) continue;
      kind[f] = Kind::Free;
      share[f] = open[f];
      if (cell[cl] && cell[ch]) continue;
      const double in = cell[cl] ? phi[cl] : phi[ch], out = cell[cl] ? phi[ch] : phi[cl];
      share[f] = open[f] * (out > 0.0 ? std::max(in / (in - out), kLeastWet) : 1.0);
    }
  });
  held.clear(), idle.clear();
  for (std::size_t f = 0; f < kind.size(); ++f) {
    if (kind[f] == Kind::Free) continue;
    if (held.empty() || held.back().end != f) held.push_back({f, f});
    held.back().end = f + 1;
  }
  std::ranges::copy_if(held, std::back_inserter(idle), [](const VelocityRange& r) { return r.end - r.begin >= kLong; });
  layers = {places.z(), 0};
  const std::size_t layer = 3 * static_cast<std::size_t>(places.x() * places.y());
  for (int k = 0; k < places.z(); ++k)
    if (std::any_of(kind.begin() + k * layer, kind.begin() + (k + 1) * layer, [](Kind f) { return f != Kind::Dry; }))
      layers = {std::min(layers.begin, k), k + 1};
  touches_walls = std::find(kind.begin(), kind.end(), Kind::Wall) != kind.end();
}

}  // namespace brim
