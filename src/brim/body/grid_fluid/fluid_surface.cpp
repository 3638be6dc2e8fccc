#include "brim/body/grid_fluid/fluid_surface.h"

namespace brim {

void fluid_surface(const MacGrid& g, const std::function<double(const Vec3&)>& distance, std::vector<Vec3f>& x,
                   std::vector<Triangle>& triangles) {
  const Vec3i nodes = g.n + Vec3i::Ones();
  const std::array<int, 3> step = {1, nodes.x(), nodes.x() * nodes.y()};
  const auto at = [&](const Vec3i& c) { return c.x() + nodes.x() * (c.y() + nodes.y() * c.z()); };
  std::vector<double> value(static_cast<std::size_t>(nodes.x()) * nodes.y() * nodes.z());
  for_places(nodes, [&](int i, int j, int k) { value[at({i, j, k})] = distance(g.origin + g.dx * Vec3(i, j, k)); });

  // The vertex of the cube whose low corner is a node, made when it is first asked for.
  std::vector<std::int32_t> number(value.size(), -1);
  const auto vertex = [&](const Vec3i& c) {
    std::int32_t& known = number[static_cast<std::size_t>(at(c))];
    if (known >= 0) return known;
    Vec3 sum = Vec3::Zero();
    int cuts = 0;
    for (int corner = 0; corner < 8; ++corner)
      for (int a = 0; a < 3; ++a) {
        if ((corner >> a) & 1) continue;
        const Vec3i offset(corner & 1, (corner >> 1) & 1, corner >> 2);
        const double p = value[at(c + offset)], q = value[at(c + offset) + step[a]];
        if ((p < 0.0) == (q < 0.0)) continue;
        sum += offset.cast<double>() + (p / (p - q)) * Vec3::Unit(a);
        ++cuts;
      }
    x.push_back((g.origin + g.dx * (c.cast<double>() + sum / std::max(cuts, 1))).cast<float>());
    return known = static_cast<std::int32_t>(x.size()) - 1;
  };

  x.clear();
  triangles.clear();
  for (int k = 0; k < nodes.z(); ++k)
    for (int j = 0; j < nodes.y(); ++j)
      for (int i = 0; i < nodes.x(); ++i)
        for (int a = 0; a < 3; ++a) {
          const Vec3i c(i, j, k);
          const int b = (a + 1) % 3, d = (a + 2) % 3;
          // Edges along a side of the box have no cubes all around; both their ends are outside the fluid.
          if (c[a] + 1 >= nodes[a] || c[b] == 0 || c[d] == 0 || c[b] >= g.n[b] || c[d] >= g.n[d]) continue;
          const double p = value[at(c)], q = value[at(c) + step[a]];
          if ((p < 0.0) == (q < 0.0)) continue;
          const Vec3i eb = Vec3i::Unit(b), ed = Vec3i::Unit(d);
          const std::array<std::int32_t, 4> ring = {vertex(c - eb - ed), vertex(c - ed), vertex(c), vertex(c - eb)};
          const auto corner = [&](int n) { return ring[p < 0.0 ? n : 3 - n]; };
          triangles.push_back({corner(0), corner(1), corner(2)});
          triangles.push_back({corner(0), corner(2), corner(3)});
        }
}

}  // namespace brim
