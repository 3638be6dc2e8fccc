#include "brim/body/grid_fluid/fluid_surface.h"

#include <limits>

namespace brim {

namespace {

/// The cell centres and, outside the fluid, a layer of places beyond each side of the box. Cube c has the corners
/// c .. c + 1; cube 0 and cube n of an axis lie astride the sides.
class CenterLattice {
 public:
  CenterLattice(const MacGrid& g, std::span<const double> distance) : g_(g), places_(g.n + 2 * Vec3i::Ones()) {
    value_.assign(static_cast<std::size_t>(places_.x()) * places_.y() * places_.z(), kOutside);
    for_places(g.n, [&](int i, int j, int k) {
      value_[at(Vec3i(i + 1, j + 1, k + 1))] = distance[static_cast<std::size_t>(g.cell(i, j, k))];
    });
  }

  const Vec3i& places() const { return places_; }
  std::size_t at(const Vec3i& c) const {
    return static_cast<std::size_t>(c.x()) +
           static_cast<std::size_t>(places_.x()) * (c.y() + static_cast<std::size_t>(places_.y()) * c.z());
  }
  bool wet(const Vec3i& c) const { return value_[at(c)] < 0.0; }

  /// [m] vertex of a cube that the surface cuts.
  Vec3 vertex(const Vec3i& c) const {
    Vec3 sum = Vec3::Zero(), beside = Vec3::Zero();
    Vec3i sides = Vec3i::Zero();
    int cuts = 0;
    for (int corner = 0; corner < 8; ++corner)
      for (int a = 0; a < 3; ++a) {
        if ((corner >> a) & 1) continue;
        const Vec3i low = c + Vec3i(corner & 1, (corner >> 1) & 1, corner >> 2);
        if (wet(low) == wet(low + Vec3i::Unit(a))) continue;
        if (low[a] == 0 || low[a] == g_.n[a]) {  // the end within the box is wet
          beside[a] += low[a] == 0 ? 1.0 - before_side(low + Vec3i::Unit(a), a, -1) : before_side(low, a, 1);
          ++sides[a];
        } else {
          const double p = value_[at(low)], q = value_[at(low + Vec3i::Unit(a))];
          sum += (low - c).cast<double>() + (p / (p - q)) * Vec3::Unit(a);
          ++cuts;
        }
      }
    Vec3 x = cuts > 0 ? Vec3(sum / cuts) : Vec3::Constant(0.5);
    for (int a = 0; a < 3; ++a)
      if (c[a] == 0 || c[a] == g_.n[a]) x[a] = sides[a] > 0 ? beside[a] / sides[a] : 0.5;
    return g_.origin + g_.dx * (c.cast<double>() + x - Vec3::Constant(0.5));
  }

 private:
  static constexpr double kOutside = std::numeric_limits<double>::max();

  /// [cells] from the wet centre c before a side to where the surface ends: at the side, or at the free surface before
  /// it, which is the line through the last two values.
  double before_side(const Vec3i& c, int a, int toward) const {
    const double p = value_[at(c)], inner = value_[at(c - toward * Vec3i::Unit(a))];
    const double rise = inner == kOutside ? 0.0 : p - inner;  // [m] a cell, towards the side
    return rise > -2.0 * p ? -p / rise : 0.5;
  }

  const MacGrid& g_;
  Vec3i places_;
  std::vector<double> value_;
};

}  // namespace

void fluid_surface(const MacGrid& g, std::span<const double> distance, std::vector<Vec3f>& x,
                   std::vector<Triangle>& triangles) {
  const CenterLattice lattice(g, distance);
  const Vec3i& places = lattice.places();
  std::vector<std::int32_t> number(static_cast<std::size_t>(places.x()) * places.y() * places.z(), -1);
  const auto vertex = [&](const Vec3i& cube) {
    std::int32_t& known = number[lattice.at(cube)];
    if (known >= 0) return known;
    x.push_back(lattice.vertex(cube).cast<float>());
    return known = static_cast<std::int32_t>(x.size()) - 1;
  };

  x.clear();
  triangles.clear();
  for (int k = 0; k < places.z(); ++k)
    for (int j = 0; j < places.y(); ++j)
      for (int i = 0; i < places.x(); ++i)
        for (int a = 0; a < 3; ++a) {
          const Vec3i c(i, j, k);
          if (c[a] + 1 >= places[a]) continue;
          const bool wet = lattice.wet(c);
          if (wet == lattice.wet(c + Vec3i::Unit(a))) continue;
          const Vec3i eb = Vec3i::Unit((a + 1) % 3), ed = Vec3i::Unit((a + 2) % 3);
          const std::array<std::int32_t, 4> ring = {vertex(c - eb - ed), vertex(c - ed), vertex(c), vertex(c - eb)};
          const auto corner = [&](int n) { return ring[wet ? n : 3 - n]; };
          triangles.push_back({corner(0), corner(1), corner(2)});
          triangles.push_back({corner(0), corner(2), corner(3)});
        }
}

}  // namespace brim
