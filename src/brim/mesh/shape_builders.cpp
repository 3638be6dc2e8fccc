#include "brim/mesh/shape_builders.h"

#include <numbers>

#include "brim/core/error.h"

namespace brim::shapes {

namespace {

void add_quad(TriMesh& mesh, std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

double cross(const XY& o, const XY& a, const XY& b) { return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x); }

// Triangles of a simple counter-clockwise polygon: cuts the ear with the shortest cut first, O(n²) each.
std::vector<Triangle> clip_ears(const std::vector<XY>& p) {
  std::vector<std::int32_t> ring(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) ring[i] = static_cast<std::int32_t>(i);
  std::vector<Triangle> triangles;
  while (ring.size() > 3) {
    const std::size_t n = ring.size();
    std::size_t best = n;
    double best_length = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const std::int32_t ia = ring[(i + n - 1) % n], ib = ring[i], ic = ring[(i + 1) % n];
      if (!(cross(p[ia], p[ib], p[ic]) > 0.0)) continue;
      bool free = true;
      for (const std::int32_t k : ring) {
        if (k == ia || k == ib || k == ic) continue;
        if (cross(p[ia], p[ib], p[k]) >= 0.0 && cross(p[ib], p[ic], p[k]) >= 0.0 && cross(p[ic], p[ia], p[k]) >= 0.0)
          free = false;
      }
      const double length = std::hypot(p[ic].x - p[ia].x, p[ic].y - p[ia].y);
      if (free && (best == n || length < best_length)) {
        best = i;
        best_length = length;
      }
    }
    BRIM_CHECK(best, <, n);
    triangles.push_back({ring[(best + n - 1) % n], ring[best], ring[(best + 1) % n]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(best));
  }
  triangles.push_back({ring[0], ring[1], ring[2]});
  return triangles;
}

}  // namespace

TriMesh revolve(const std::vector<RZ>& profile, int around) {
  TriMesh mesh;
  const auto rings = static_cast<std::int32_t>(profile.size()) - 2;
  BRIM_CHECK(rings, >=, 1);
  const std::int32_t south = 0, north = 1;
  mesh.vertices.emplace_back(0.0, 0.0, profile.front().z);
  mesh.vertices.emplace_back(0.0, 0.0, profile.back().z);
  for (std::int32_t k = 1; k <= rings; ++k)
    for (int i = 0; i < around; ++i) {
      const double a = 2.0 * std::numbers::pi * i / around;
      mesh.vertices.emplace_back(profile[k].r * std::cos(a), profile[k].r * std::sin(a), profile[k].z);
    }
  const auto at = [&](std::int32_t ring, int i) { return 2 + ring * around + i % around; };
  for (int i = 0; i < around; ++i) {
    mesh.triangles.push_back({south, at(0, i + 1), at(0, i)});
    for (std::int32_t k = 0; k + 1 < rings; ++k) add_quad(mesh, at(k, i), at(k, i + 1), at(k + 1, i + 1), at(k + 1, i));
    mesh.triangles.push_back({north, at(rings - 1, i), at(rings - 1, i + 1)});
  }
  return mesh;
}

TriMesh extrude_around_center(const std::vector<XY>& outline, double bore, double thickness) {
  TriMesh mesh;
  const auto n = static_cast<std::int32_t>(outline.size());
  const double z = 0.5 * thickness;
  for (const double side : {-z, z})
    for (const XY& p : outline) mesh.vertices.emplace_back(p.x, p.y, side);
  if (bore > 0.0) {
    for (const double side : {-z, z})
      for (const XY& p : outline) {
        const double s = bore / std::hypot(p.x, p.y);
        mesh.vertices.emplace_back(s * p.x, s * p.y, side);
      }
  } else {
    mesh.vertices.emplace_back(0.0, 0.0, -z);
    mesh.vertices.emplace_back(0.0, 0.0, z);
  }
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t j = (i + 1) % n;
    add_quad(mesh, i, j, n + j, n + i);
    if (bore > 0.0) {
      const std::int32_t low = 2 * n, high = 3 * n;
      add_quad(mesh, low + i, low + j, j, i);
      add_quad(mesh, high + i, n + i, n + j, high + j);
      add_quad(mesh, low + i, high + i, high + j, low + j);
    } else {
      mesh.triangles.push_back({2 * n, j, i});
      mesh.triangles.push_back({2 * n + 1, n + i, n + j});
    }
  }
  return mesh;
}

TriMesh extrude_polygon(const std::vector<XY>& outline, double length) {
  TriMesh mesh;
  const auto n = static_cast<std::int32_t>(outline.size());
  for (const double z : {-0.5 * length, 0.5 * length})
    for (const XY& p : outline) mesh.vertices.emplace_back(p.x, p.y, z);
  for (std::int32_t i = 0; i < n; ++i) add_quad(mesh, i, (i + 1) % n, n + (i + 1) % n, n + i);
  for (const Triangle& t : clip_ears(outline)) {
    mesh.triangles.push_back({t[0], t[2], t[1]});
    mesh.triangles.push_back({n + t[0], n + t[1], n + t[2]});
  }
  return mesh;
}

}  // namespace brim::shapes
