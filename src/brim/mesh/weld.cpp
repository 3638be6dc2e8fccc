#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "brim/core/error.h"
#include "brim/mesh/topology.h"

namespace brim {

namespace {

struct Cell {
  std::int64_t x, y, z;
  bool operator==(const Cell&) const = default;
};

struct CellHash {
  std::size_t operator()(const Cell& c) const {
    std::uint64_t h = 0x9e3779b97f4a7c15ull;
    for (const std::int64_t v : {c.x, c.y, c.z})
      h = (h ^ static_cast<std::uint64_t>(v)) * 0xff51afd7ed558ccdull, h ^= h >> 32;
    return static_cast<std::size_t>(h);
  }
};

// For each vertex the earlier vertex it joins, or itself.
std::vector<std::int32_t> targets(const std::vector<Vec3>& vertices, double tolerance) {
  std::vector<std::int32_t> target(vertices.size());
  if (tolerance == 0.0) {
    const auto less = [](const Vec3& a, const Vec3& b) {
      return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
    };
    std::map<Vec3, std::int32_t, decltype(less)> seen(less);
    for (std::size_t i = 0; i < vertices.size(); ++i)
      target[i] = seen.try_emplace(vertices[i], static_cast<std::int32_t>(i)).first->second;
    return target;
  }
  // Cells as wide as the tolerance: a partner lies in one of the 27 around.
  std::unordered_map<Cell, std::vector<std::int32_t>, CellHash> cells;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vec3& p = vertices[i];
    const auto at = [&](int k) { return static_cast<std::int64_t>(std::floor(p[k] / tolerance)); };
    const Cell own = {at(0), at(1), at(2)};
    std::int32_t best = static_cast<std::int32_t>(i);
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) {
          const auto it = cells.find({own.x + dx, own.y + dy, own.z + dz});
          if (it == cells.end()) continue;
          for (const std::int32_t j : it->second)
            if (j < best && (vertices[j] - p).norm() <= tolerance) best = j;
        }
    target[i] = best;
    // Only survivors are partners, so that chains do not pull far vertices together.
    if (best == static_cast<std::int32_t>(i)) cells[own].push_back(best);
  }
  return target;
}

}  // namespace

TriMesh weld(const TriMesh& mesh, double tolerance) {
  if (!(tolerance >= 0.0) || !std::isfinite(tolerance))
    throw InputError(fmt::format("weld: tolerance is {} m; it must be 0 or more", tolerance));
  const std::vector<std::int32_t> target = targets(mesh.vertices, tolerance);
  std::vector<char> used(mesh.vertices.size(), 0);
  TriMesh result;
  for (const Triangle& t : mesh.triangles) {
    const Triangle w = {target[t[0]], target[t[1]], target[t[2]]};
    if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0]) continue;
    result.triangles.push_back(w);
    for (const std::int32_t v : w) used[v] = 1;
  }
  std::vector<std::int32_t> number(mesh.vertices.size(), -1);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (used[v]) {
      number[v] = static_cast<std::int32_t>(result.vertices.size());
      result.vertices.push_back(mesh.vertices[v]);
    }
  for (Triangle& t : result.triangles)
    for (std::int32_t& v : t) v = number[v];
  return result;
}

}  // namespace brim
