#include <algorithm>
#include <cmath>

#include "brim/body/spinning_balls.h"
#include "brim/core/interface_of.h"
#include "brim/world/fluid_coupling.h"

/// Which faces of a fluid its solids take, and the points of them that move with the solids.
namespace brim {

namespace {

/// What a solid takes of a face: the part of its cube, and its first moment about the face.
struct Taken {
  std::int32_t face, source;
  float part;
  float fullest;  ///< share of the fullest eighth, whose source it is
  Vec3f moment;   ///< [cells]
};

/// Adds up what is taken of the same face. @param apart  sources stay apart
void join(std::vector<Taken>& all, bool apart) {
  std::ranges::stable_sort(all, [&](const Taken& a, const Taken& b) {
    return a.face != b.face ? a.face < b.face : apart && a.source < b.source;
  });
  std::size_t n = 0;
  for (const Taken& t : all) {
    if (n == 0 || all[n - 1].face != t.face || (apart && all[n - 1].source != t.source)) {
      all[n++] = t;
      continue;
    }
    Taken& sum = all[n - 1];
    if (t.fullest > sum.fullest) sum.fullest = t.fullest, sum.source = t.source;
    sum.part += t.part, sum.moment += t.moment;
  }
  all.resize(n);
}

/// Low corner of the cell above a face, in cells.
Vec3i place_of(const MacGrid& g, int face) {
  const int place = face / 3;
  return {place % (g.n.x() + 1), place / (g.n.x() + 1) % (g.n.y() + 1), place / ((g.n.x() + 1) * (g.n.y() + 1))};
}

/// What eighths take of faces; overlapping solids divide what is available.
/// @param octant  share of each eighth that all solids take
std::vector<Taken> find_taken(const MacGrid& g, std::span<const Eighth> eighths, std::span<const float> octant) {
  const Vec3i n = 2 * g.n;
  std::vector<Taken> all;
  all.reserve(4 * eighths.size());
  for (const Eighth& e : eighths) {
    const Vec3i at(e.place % n.x(), e.place / n.x() % n.y(), e.place / (n.x() * n.y()));
    const float part = 0.125f * e.share / std::max(1.0f, octant[e.place]);
    const Vec3 middle = 0.5 * (at.cast<double>() + Vec3::Constant(0.5) + e.off.cast<double>());
    for (int a = 0; a < 3; ++a) {
      const auto take = [&](const Vec3i& cell, float of, bool across) {
        Vec3 way = middle - cell.cast<double>() - g.face_offset(a);
        if (!across) way[a] = 0.0;
        all.push_back({g.face(a, cell), e.source, of, e.share, of * way.cast<float>()});
      };
      Vec3i cell = at / 2;
      // At the box's sides as the fluid extrapolates its solids (set_solids).
      for (const int side : {0, g.n[a]}) {
        const int layer = side == 0 ? at[a] : n[a] - 1 - at[a];
        if (layer > 1) continue;
        cell[a] = side;
        take(cell, layer == 0 ? 3.0f * part : -part, false);
      }
      cell[a] = (at[a] + 1) / 2;
      if (cell[a] > 0 && cell[a] < g.n[a]) take(cell, part, true);
    }
  }
  return all;
}

}  // namespace

void FluidCoupling::find_rows(Fluid& fluid, std::span<const WorldPart> parts) {
  const MacGrid& g = fluid.flow->flow_grid();
  std::vector<float> all(g.faces(), 0.0f);
  std::vector<std::vector<Taken>> taken;
  for (const Side& side : fluid.sides) {
    std::vector<Taken>& own = taken.emplace_back(find_taken(g, *side.eighths, octant_));
    for (const Taken& t : own) all[t.face] += t.part;
    join(own, interface_of<SpinningBalls>(*parts[side.part].body) != nullptr);
  }
  std::vector<Side> kept;
  std::vector<std::int32_t> sources;
  for (std::size_t i = 0; i < fluid.sides.size(); ++i) {
    Side& side = fluid.sides[i];
    const WorldPart& part = parts[side.part];
    const auto* balls = interface_of<SpinningBalls>(*part.body);
    sources.clear();
    for (const Taken& t : taken[i]) {
      const int a = t.face % 3;
      const Vec3i hi = place_of(g, t.face);
      const int high = g.cell(hi), low = high - g.cell_stride(a);
      const bool wet_low = hi[a] > 0 && fluid.flow->is_wet(low);
      const bool wet_high = hi[a] < g.n[a] && fluid.flow->is_wet(high);
      if (!(wet_low || wet_high) || !(all[t.face] > 0.0f) || !(t.part > 0.0f)) continue;
      // Everything not open to the fluid belongs to solids.
      const double share = std::min(double{t.part} / all[t.face], 1.0) * (1.0 - fluid.flow->open_share(t.face));
      side.rows.push_back({wet_low ? low : -1, wet_high ? high : -1, a, share * g.dx * g.dx});
      // The middle of what is taken moves as it does on average. Pressure turns no ball.
      const Vec3 way = (t.moment / t.part).cast<double>().cwiseMax(-0.5).cwiseMin(0.5);
      side.points.push_back(balls != nullptr ? balls->ball_center(t.source)
                                             : Vec3(g.face_position(a, hi.x(), hi.y(), hi.z()) + g.dx * way));
      sources.push_back(t.source);
    }
    if (side.rows.empty()) continue;
    part.body->make_map(part.index, side.points, sources, side.map);
    kept.push_back(std::move(side));
  }
  fluid.sides = std::move(kept);
}

}  // namespace brim
