#include "brim/body/particle_fluid/fluid_lattice.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace brim {

namespace {

/// Of a side, in spacings, that counts as whole, and of a volume that fills its box.
constexpr double kLatticeRounding = 1e-9;

bool is_whole(double side, double n) { return std::abs(side - n) <= kLatticeRounding * n; }

/// How many particles of the order of depth to take: nearest to `wanted`, without a cut through equal depths.
std::size_t cut(const std::vector<double>& depth, double wanted, double rounding) {
  std::size_t best = depth.size();
  for (std::size_t n = 1; n < depth.size(); ++n)
    if (depth[n] - depth[n - 1] > rounding &&
        std::abs(static_cast<double>(n) - wanted) < std::abs(static_cast<double>(best) - wanted))
      best = n;
  return best;
}

}  // namespace

FluidLattice lattice_in_box(const Vec3& lo, const Vec3& hi, double spacing) {
  const Vec3 sides = (hi - lo) / spacing, n = sides.array().round().max(1.0);
  Vec3 cell = Vec3::Constant(spacing);
  bool cubes = true;
  for (int a = 0; a < 3; ++a) {
    if (is_whole(sides[a], n[a])) continue;
    cell[a] = (hi[a] - lo[a]) / n[a];
    cubes = false;
  }
  FluidLattice out;
  out.spacing = cubes ? spacing : std::cbrt(cell.prod());
  for (int k = 0; k < static_cast<int>(n.z()); ++k)
    for (int j = 0; j < static_cast<int>(n.y()); ++j)
      for (int i = 0; i < static_cast<int>(n.x()); ++i)
        out.x.push_back(lo + cell.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5)));
  return out;
}

FluidLattice lattice_in_solid(const std::function<double(const Vec3&)>& distance, const Aabb& box, double volume,
                              double spacing) {
  Aabb room = box;
  for (int a = 0; a < 3; ++a)
    if (const double n = std::round(box.extent()[a] / spacing); is_whole(box.extent()[a] / spacing, n))
      room.lo[a] = box.center()[a] - 0.5 * (spacing * n), room.hi[a] = box.center()[a] + 0.5 * (spacing * n);
  const FluidLattice whole = lattice_in_box(room.lo, room.hi, spacing);
  if (volume >= (1.0 - kLatticeRounding) * box.extent().prod()) return whole;
  std::vector<Vec3> inside;
  std::vector<double> depth;
  for (const Vec3& x : whole.x)
    if (const double d = distance(x); d < 0.0) inside.push_back(x), depth.push_back(d);
  if (inside.empty()) return {};
  std::vector<std::size_t> order(inside.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return depth[a] < depth[b]; });
  std::sort(depth.begin(), depth.end());
  const double cell = whole.spacing * whole.spacing * whole.spacing;
  order.resize(cut(depth, volume / cell, kLatticeRounding * spacing));
  std::sort(order.begin(), order.end());
  FluidLattice out;
  out.spacing = std::cbrt(volume / static_cast<double>(order.size()));
  const Vec3 middle = box.center();
  for (const std::size_t i : order) out.x.push_back(middle + out.spacing / whole.spacing * (inside[i] - middle));
  return out;
}

}  // namespace brim
