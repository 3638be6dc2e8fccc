#include "brim/record/export/shading.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace brim::exporting {

namespace {

/// Twice the area times the unit normal.
Vec3f area_vector(std::span<const Vec3f> x, const Triangle& t) {
  const Vec3f& a = x[static_cast<std::size_t>(t[0])];
  return (x[static_cast<std::size_t>(t[1])] - a).cross(x[static_cast<std::size_t>(t[2])] - a);
}

bool smooth(const Vec3f& a, const Vec3f& b, double least) {
  const double size = static_cast<double>(a.norm()) * b.norm();
  return size == 0.0 || a.dot(b) >= least * size;
}

/// Corners, three a triangle, joined into sets.
struct Corners {
  std::vector<std::size_t> parent;
  explicit Corners(std::size_t n) : parent(n) { std::iota(parent.begin(), parent.end(), std::size_t{0}); }
  std::size_t root(std::size_t c) {
    while (parent[c] != c) c = parent[c] = parent[parent[c]];
    return c;
  }
  void unite(std::size_t a, std::size_t b) {
    const auto [low, high] = std::minmax({root(a), root(b)});
    parent[high] = low;
  }
};

}  // namespace

SplitMesh split_at_creases(std::span<const Vec3f> x, std::span<const Triangle> triangles, double crease) {
  struct Edge {
    std::int32_t low, high;
    std::size_t corner;  ///< that starts it
  };
  std::vector<Edge> edges;
  std::vector<Vec3f> area;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    area.push_back(area_vector(x, triangles[t]));
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles[t][k], triangles[t][(k + 1) % 3]);
      edges.push_back({low, high, 3 * t + k});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner);
  });
  const auto vertex = [&](std::size_t corner) { return triangles[corner / 3][corner % 3]; };
  const auto next = [](std::size_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; };
  Corners corners(3 * triangles.size());
  for (std::size_t i = 0; i < edges.size();) {
    // All triangles at one edge; each is compared with the first.
    std::size_t j = i + 1;
    for (; j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high; ++j) {
      const std::size_t a = edges[i].corner, b = edges[j].corner;
      if (!smooth(area[a / 3], area[b / 3], std::cos(crease))) continue;
      const bool same_start = vertex(a) == vertex(b);
      corners.unite(a, same_start ? b : next(b));
      corners.unite(next(a), same_start ? next(b) : b);
    }
    i = j;
  }
  SplitMesh mesh;
  mesh.triangles.resize(triangles.size());
  std::vector<std::int64_t> number(3 * triangles.size(), -1);
  for (std::size_t c = 0; c < number.size(); ++c) {
    std::int64_t& n = number[corners.root(c)];
    if (n < 0) {
      n = static_cast<std::int64_t>(mesh.source.size());
      mesh.source.push_back(vertex(c));
    }
    mesh.triangles[c / 3][c % 3] = static_cast<std::uint32_t>(n);
  }
  return mesh;
}

void shade(const SplitMesh& mesh, std::span<const Vec3f> x, std::vector<Vec3f>& positions,
           std::vector<Vec3f>& normals) {
  positions.resize(mesh.source.size());
  normals.assign(mesh.source.size(), Vec3f::Zero());
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = x[static_cast<std::size_t>(mesh.source[i])];
  for (const auto& t : mesh.triangles) {
    const Vec3f area = (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]);
    for (const std::uint32_t v : t) normals[v] += area;
  }
  for (Vec3f& n : normals) {
    const float size = n.norm();
    n = size > 0.0f ? Vec3f(n / size) : Vec3f(0, 0, 1);
  }
}

}  // namespace brim::exporting
