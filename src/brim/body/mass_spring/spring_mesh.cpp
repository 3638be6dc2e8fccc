#include "brim/body/mass_spring/spring_mesh.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/mesh/mass_properties.h"

namespace brim {

namespace {

double measure_of(const std::vector<Vec3>& x, const Tetrahedron& t) {
  return tet_volume(x[t[0]], x[t[1]], x[t[2]], x[t[3]]);
}
double measure_of(const std::vector<Vec3>& x, const Triangle& t) {
  return 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm();
}
double measure_of(const std::vector<Vec3>& x, const std::array<std::int32_t, 2>& t) {
  return (x[t[1]] - x[t[0]]).norm();
}

/// Size to which the measure of a cell must be compared: 1e-12 of longest edge to the power of its dimension.
template <std::size_t N>
bool has_measure(const std::vector<Vec3>& x, const std::array<std::int32_t, N>& cell, double measure) {
  double longest = 0.0, size = 1e-12;
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = i + 1; j < N; ++j) longest = std::max(longest, (x[cell[i]] - x[cell[j]]).norm());
  for (std::size_t i = 1; i < N; ++i) size *= longest;
  return measure > size;
}

template <std::size_t N>
SpringMesh from_cells(const std::vector<Vec3>& x, const std::vector<std::array<std::int32_t, N>>& cells,
                      const char* word, double stiffness, double density) {
  if (cells.empty()) throw InputError(fmt::format("mass-spring body: the mesh has no {}s", word));
  SpringMesh out;
  out.mass.assign(x.size(), 0.0);
  std::vector<Spring> shares;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto& cell = cells[c];
    for (const std::int32_t n : cell)
      if (n < 0 || static_cast<std::size_t>(n) >= x.size())
        throw InputError(fmt::format("mass-spring body: {} {} names vertex {}; there are {}", word, c, n, x.size()));
    const double measure = measure_of(x, cell);
    if (!has_measure(x, cell, measure))
      throw InputError(fmt::format("mass-spring body: {} {} has no extent or is inside out", word, c));
    out.measure += measure;
    for (std::size_t i = 0; i < N; ++i) {
      out.mass[cell[i]] += density * measure / N;
      for (std::size_t j = i + 1; j < N; ++j) {
        const double length = (x[cell[i]] - x[cell[j]]).norm();
        shares.push_back({{std::min(cell[i], cell[j]), std::max(cell[i], cell[j])},
                          stiffness * measure / (length * length),
                          length});
      }
    }
  }
  // The order of equal ends is that of the cells, so that sums have one order.
  std::stable_sort(shares.begin(), shares.end(), [](const Spring& a, const Spring& b) { return a.node < b.node; });
  for (const Spring& s : shares) {
    if (!out.springs.empty() && out.springs.back().node == s.node)
      out.springs.back().stiffness += s.stiffness;
    else
      out.springs.push_back(s);
  }
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!(out.mass[i] > 0.0)) throw InputError(fmt::format("mass-spring body: vertex {} is in no {}", i, word));
  return out;
}

}  // namespace

LineMesh square_net(int nx, int ny, double lx, double ly) {
  if (nx < 1 || ny < 1) throw InputError(fmt::format("net: {} by {} meshes; at least 1 by 1 are needed", nx, ny));
  if (!(lx > 0.0) || !(ly > 0.0)) throw InputError(fmt::format("net: size {} by {} m must be positive", lx, ly));
  LineMesh net;
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const std::int32_t v = i + (nx + 1) * j;
      net.vertices.emplace_back(lx * (double(i) / nx - 0.5), ly * (double(j) / ny - 0.5), 0.0);
      if (i < nx) net.lines.push_back({v, v + 1});
      if (j < ny) net.lines.push_back({v, v + nx + 1});
    }
  return net;
}

SpringMesh make_springs(const TetMesh& mesh, double stiffness, double density) {
  return from_cells(mesh.vertices, mesh.tets, "tetrahedron", stiffness, density);
}

SpringMesh make_springs(const TriMesh& mesh, double stiffness, double density) {
  return from_cells(mesh.vertices, mesh.triangles, "triangle", stiffness, density);
}

SpringMesh make_springs(const LineMesh& mesh, double stiffness, double density) {
  return from_cells(mesh.vertices, mesh.lines, "line", stiffness, density);
}

}  // namespace brim
