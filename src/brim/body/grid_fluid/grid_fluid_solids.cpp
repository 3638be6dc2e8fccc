#include "brim/body/grid_fluid/grid_fluid_body.h"

/// How a grid fluid sees the solids that lie in its cells.
namespace brim {

namespace {

/// [cells] thickness of walls that are seen as shares of cells; thinner ones would leak.
constexpr double kTightWall = 1.5;
/// Width over thickness from which on matter is a wall, and its least width, [cells].
constexpr double kWall = 2.5, kWideWall = 1.5;
/// Share of a cell that is solid, from which on its centre lies within.
constexpr double kWithin = 0.5;
/// [cells] from the surface within which a cell beside a solid is wet.
constexpr double kNear = 0.5, kJustWet = 0.02;
/// Layers of cells on both sides of a solid's surface that know how deep they lie in it.
constexpr int kLayers = 4;
/// Mark of a cell that is known to hold air, and tells other cells nothing.
constexpr unsigned char kAir = 2;

}  // namespace

bool GridFluidBody::flows_around(const PartInfo& other) const {
  const double dx = model_.grid.dx;
  const bool wall = !other.lines && other.width > std::max(kWall * other.thickness, kWideWall * dx);
  return !other.conforming && model_.material.friction == 0.0 && (!wall || other.thickness >= kTightWall * dx);
}

void GridFluidBody::set_solids(std::span<const float> octant, std::span<double> v) {
  solids_taken_ = true;
  if (octant.empty() && !among_solids()) return;
  const MacGrid& g = model_.grid;
  if (!v.empty()) keeper_.note(wet_, mass_, v);
  left_.assign(octant.empty() ? 0 : g.cells(), 1.0);
  left_of_face_.assign(octant.empty() ? 0 : g.faces(), 1.0);
  if (!octant.empty()) {
    const Vec3i eighths = 2 * g.n;
    const auto share = [&](int i, int j, int k) -> double {
      if (i < 0 || j < 0 || k < 0 || i >= eighths.x() || j >= eighths.y() || k >= eighths.z()) return 0.0;
      return std::min(octant[i + eighths.x() * (j + std::size_t{1} * eighths.y() * k)], 1.0f);
    };
    const auto sum = [&](const Vec3i& low) {
      double s = 0.0;
      for (int c = 0; c < 8; ++c) s += share(low.x() + (c & 1), low.y() + (c >> 1 & 1), low.z() + (c >> 2));
      return 0.125 * s;
    };
    left_moment_.assign(g.cells(), Vec3::Zero());
    for_places(g.n, [&](int i, int j, int k) {
      const int cell = g.cell(i, j, k);
      left_[cell] = 1.0 - sum(2 * Vec3i(i, j, k));
      for (int c = 0; c < 8; ++c) {
        const Vec3i at(c & 1, c >> 1 & 1, c >> 2);
        const Vec3 way = 0.5 * g.dx * (at.cast<double>() - Vec3::Constant(0.5));
        left_moment_[cell] -= 0.125 * share(2 * i + at.x(), 2 * j + at.y(), 2 * k + at.z()) * way;
      }
    });
    for (int a = 0; a < 3; ++a)
      for_places(g.face_count(a), [&](int i, int j, int k) {
        const Vec3i at(i, j, k);
        double solid = 0.0;
        if (at[a] > 0 && at[a] < g.n[a]) {
          solid = sum(2 * at - Vec3i::Unit(a));
        } else {
          // What crosses the box's sides goes on beyond them; what stands beside one leaves it alone.
          const int inwards = at[a] == 0 ? 1 : -1;
          const Vec3i low = 2 * (at - (at[a] == 0 ? 0 : 1) * Vec3i::Unit(a));
          for (int c = 0; c < 8; ++c) {
            const Vec3i e(c & 1, c >> 1 & 1, c >> 2);
            const bool first = e[a] == (inwards > 0 ? 0 : 1);
            solid += 0.25 * (first ? 1.5 : -0.5) * share(low.x() + e.x(), low.y() + e.y(), low.z() + e.z());
          }
        }
        left_of_face_[g.face(a, at)] = 1.0 - std::clamp(solid, 0.0, 1.0);
      });
  }
  phi_ = taken_;
  if (among_solids()) extend_into_solids(), hide_in_solids();
  find_wet();
  if (!v.empty()) keeper_.hand_over(g, wet_, mass_, v);
}

void GridFluidBody::extend_into_solids() {
  const MacGrid& g = model_.grid;
  const auto within = [&](int c) { return 1.0 - left_[c] >= kWithin; };
  // A gap between surface and solid that is thinner than half a cell is none.
  std::vector<double>& next = scratch_;
  next.assign(phi_.begin(), phi_.end());
  for_places(g.n, [&](int i, int j, int k) {
    const std::array<int, 3> at = {i, j, k};
    const int c = g.cell(i, j, k);
    if (within(c) || phi_[c] < 0.0 || phi_[c] > kNear * g.dx) return;
    for (int a = 0; a < 3; ++a)
      for (const int side : {-1, 1}) {
        if (at[a] + side < 0 || at[a] + side >= g.n[a] || at[a] - side < 0 || at[a] - side >= g.n[a]) continue;
        const int s = g.cell_stride(a) * side;
        if (within(c + s) && !within(c - s) && phi_[c - s] < 0.0) next[c] = -kJustWet * g.dx;
      }
  });
  std::copy(next.begin(), next.end(), phi_.begin());
  std::vector<unsigned char> known(g.cells());
  std::vector<int> unknown;
  for (std::size_t c = 0; c < known.size(); ++c) {
    known[c] = !within(static_cast<int>(c));
    if (!known[c]) unknown.push_back(static_cast<int>(c));
  }
  const double far = g.box().extent().norm();
  for (const int c : unknown) phi_[c] = far;
  // First to where water comes through open faces: beyond a thin wall there may be air.
  while (extend_by_a_layer(true, known, unknown)) {
  }
  air_in_pockets(known, unknown);
  while (extend_by_a_layer(false, known, unknown)) {
  }
}

void GridFluidBody::air_in_pockets(std::vector<unsigned char>& known, std::vector<int>& unknown) {
  const MacGrid& g = model_.grid;
  const auto any_neighbour = [&](int c, const auto& f) {
    const Vec3i at(c % g.n.x(), c / g.n.x() % g.n.y(), c / (g.n.x() * g.n.y()));
    for (int a = 0; a < 3; ++a)
      for (const int side : {-1, 1}) {
        if (at[a] + side < 0 || at[a] + side >= g.n[a]) continue;
        const int face = g.face(a, at) + (side > 0 ? g.face_stride(a) : 0);
        if (f(c + side * g.cell_stride(a), left_of_face_[face] >= WetFaces::kLeastOpen)) return true;
      }
    return false;
  };
  std::vector<int> pocket;
  for (const int c : unknown)
    if (any_neighbour(c, [](int, bool open) { return open; })) pocket.push_back(c), known[c] = kAir;
  // What lies beside known cells takes their surface, as solids do, with all that is open to it.
  while (std::erase_if(pocket, [&](int c) {
    const bool beside = any_neighbour(c, [&](int o, bool open) { return known[o] == 1 || (open && known[o] == 0); });
    if (beside) known[c] = 0;
    return beside;
  })) {
  }
  for (const int c : pocket) phi_[c] = g.dx;
  std::erase_if(unknown, [&](int c) { return known[c] == kAir; });
}

bool GridFluidBody::extend_by_a_layer(bool only_open, std::vector<unsigned char>& known, std::vector<int>& unknown) {
  const MacGrid& g = model_.grid;
  std::vector<int> now, later;
  for (const int c : unknown) {
    const Vec3i at(c % g.n.x(), c / g.n.x() % g.n.y(), c / (g.n.x() * g.n.y()));
    double sum = 0.0;
    int found = 0;
    for (int a = 0; a < 3; ++a)
      for (const int side : {-1, 1}) {
        if (at[a] + side < 0 || at[a] + side >= g.n[a]) continue;
        const int other = c + side * g.cell_stride(a), face = g.face(a, at) + (side > 0 ? g.face_stride(a) : 0);
        if (known[other] == 1 && (!only_open || left_of_face_[face] >= WetFaces::kLeastOpen))
          sum += phi_[other], ++found;
      }
    if (found > 0) phi_[c] = sum / found;
    (found > 0 ? now : later).push_back(c);
  }
  for (const int c : now) known[c] = 1;
  unknown.swap(later);
  return !now.empty();
}

void GridFluidBody::hide_in_solids() {
  const MacGrid& g = model_.grid;
  const auto within = [&](std::size_t c) { return 1.0 - left_[c] >= kWithin; };
  const auto for_neighbours = [&](std::size_t c, const auto& f) {
    const Vec3i at(static_cast<int>(c) % g.n.x(), static_cast<int>(c) / g.n.x() % g.n.y(),
                   static_cast<int>(c) / (g.n.x() * g.n.y()));
    for (int a = 0; a < 3; ++a)
      for (const int side : {-1, 1})
        if (at[a] + side >= 0 && at[a] + side < g.n[a]) f(c + static_cast<std::size_t>(side * g.cell_stride(a)));
  };
  // Depth in the solids: of cells at their surface by their share, of those behind by how many cells lie between.
  std::vector<double>& depth = scratch_;
  depth.assign(g.cells(), 0.0);
  std::vector<int> layer(g.cells(), kLayers + 1);
  std::vector<std::size_t> front, next;
  for (std::size_t c = 0; c < g.cells(); ++c) {
    bool surface = left_[c] > 0.0 && left_[c] < 1.0;
    if (!surface) for_neighbours(c, [&](std::size_t o) { surface = surface || within(o) != within(c); });
    depth[c] = (surface ? 0.5 - left_[c] : within(c) ? kLayers : -kLayers) * g.dx;
    if (surface) layer[c] = 0, front.push_back(c);
  }
  for (int l = 1; l <= kLayers && !front.empty(); ++l, front.swap(next)) {
    next.clear();
    for (const std::size_t c : front)
      for_neighbours(c, [&](std::size_t o) {
        if (layer[o] < l) return;
        const double there = within(o) ? std::max(depth[c], 0.0) + g.dx : std::min(depth[c], 0.0) - g.dx;
        if (layer[o] > l) {
          layer[o] = l, depth[o] = there;
          next.push_back(o);
        } else if (std::abs(there) < std::abs(depth[o])) {
          depth[o] = there;
        }
      });
  }
  seen_.resize(g.cells());
  for (std::size_t c = 0; c < g.cells(); ++c) seen_[c] = std::max(phi_[c], depth[c]);
}

}  // namespace brim
