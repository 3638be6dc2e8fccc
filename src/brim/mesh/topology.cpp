#include "brim/mesh/topology.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "brim/core/error.h"
#include "brim/mesh/triangle_sides.h"

namespace brim {

namespace {

struct UnionFind {
  std::vector<std::int32_t> parent;
  explicit UnionFind(std::size_t n) : parent(n) { std::iota(parent.begin(), parent.end(), 0); }
  std::int32_t find(std::int32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  }
  void join(std::int32_t a, std::int32_t b) {
    a = find(a);
    b = find(b);
    if (a != b) parent[std::max(a, b)] = std::min(a, b);
  }
};

// Vertices whose triangles form more than one fan: corners joined through shared edges, per vertex.
std::size_t count_nonmanifold_vertices(std::size_t vertex_count, std::span<const Triangle> triangles,
                                       const std::vector<Side>& sides) {
  UnionFind corners(3 * triangles.size());
  const auto corner_of = [&](std::int32_t t, std::int32_t v) {
    for (int k = 0; k < 3; ++k)
      if (triangles[t][k] == v) return 3 * t + k;
    return 3 * t;
  };
  for_each_edge(sides, [&](const Side* first, const Side* last) {
    for (const Side* s = first + 1; s < last; ++s)
      for (const std::int32_t v : {s->a, s->b}) corners.join(corner_of(first->triangle, v), corner_of(s->triangle, v));
  });
  std::vector<std::int32_t> fans(vertex_count, 0);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto c = static_cast<std::int32_t>(3 * t + k);
      if (corners.find(c) == c) ++fans[triangles[t][k]];
    }
  return static_cast<std::size_t>(std::count_if(fans.begin(), fans.end(), [](std::int32_t n) { return n > 1; }));
}

bool is_degenerate(const TriMesh& mesh, const Triangle& t) {
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return true;
  const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
  const double longest2 = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return !(0.5 * (b - a).cross(c - a).norm() > 1e-12 * longest2);
}

std::string counted(std::size_t n, const char* one, const char* many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

}  // namespace

std::string MeshReport::summary() const {
  std::string s = counted(triangles, "triangle", "triangles") + ", " + counted(vertices, "vertex", "vertices") + ", " +
                  counted(pieces, "piece", "pieces");
  if (triangles == 0) return s;
  if (closed())
    s += ", closed";
  else if (boundary_edges > 0)
    s += ", open (" + counted(boundary_edges, "boundary edge", "boundary edges") + ")";
  if (repeated_triangles > 0) s += ", " + counted(repeated_triangles, "repeated triangle", "repeated triangles");
  if (manifold()) {
    s += ", manifold";
  } else {
    s += ", not manifold (" + counted(nonmanifold_edges, "edge", "edges") + ", " +
         counted(nonmanifold_vertices, "vertex", "vertices") + ")";
  }
  s += oriented() ? ", oriented" : ", " + counted(misoriented_edges, "edge", "edges") + " between opposite triangles";
  if (closed() && oriented() && volume < 0.0) s += ", inside out";
  if (degenerate_triangles > 0) s += ", " + counted(degenerate_triangles, "triangle", "triangles") + " without area";
  if (duplicate_vertices > 0) s += ", " + counted(duplicate_vertices, "duplicate vertex", "duplicate vertices");
  if (unused_vertices > 0) s += ", " + counted(unused_vertices, "unused vertex", "unused vertices");
  return s;
}

MeshReport inspect(const TriMesh& mesh) {
  MeshReport r;
  r.vertices = mesh.vertices.size();
  r.triangles = mesh.triangles.size();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::int32_t v : mesh.triangles[t])
      if (v < 0 || static_cast<std::size_t>(v) >= mesh.vertices.size())
        throw InputError(fmt::format("triangle {} names vertex {}, but the mesh has {} vertices", t, v, r.vertices));

  const std::vector<Side> sides = sorted_sides(mesh.triangles);
  for_each_edge(sides, [&](const Side* first, const Side* last) {
    ++r.edges;
    const auto forward = std::count_if(first, last, [](const Side& s) { return s.forward; });
    const auto n = last - first;
    if (n == 1) ++r.boundary_edges;
    if (n > 2) ++r.nonmanifold_edges;
    if (n > 1 && 2 * forward != n) ++r.misoriented_edges;
  });
  r.nonmanifold_vertices = count_nonmanifold_vertices(mesh.vertices.size(), mesh.triangles, sides);
  for (const Triangle& t : mesh.triangles) r.degenerate_triangles += is_degenerate(mesh, t);

  std::vector<Triangle> corners(mesh.triangles.begin(), mesh.triangles.end());
  for (Triangle& t : corners) std::sort(t.begin(), t.end());
  std::sort(corners.begin(), corners.end());
  for (std::size_t t = 1; t < corners.size(); ++t) r.repeated_triangles += corners[t] == corners[t - 1];

  const Pieces pieces = connected_pieces(mesh.vertices.size(), mesh.triangles);
  r.pieces = static_cast<std::size_t>(pieces.count);
  r.unused_vertices =
      static_cast<std::size_t>(std::count(pieces.of_vertex.begin(), pieces.of_vertex.end(), std::int32_t{-1}));

  std::vector<std::int32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto less = [&](std::int32_t i, std::int32_t j) {
    const Vec3 &a = mesh.vertices[i], &b = mesh.vertices[j];
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  std::sort(order.begin(), order.end(), less);
  for (std::size_t i = 1; i < order.size(); ++i)
    r.duplicate_vertices += mesh.vertices[order[i]] == mesh.vertices[order[i - 1]];

  const Vec3 o = mesh.vertices.empty() ? Vec3::Zero() : mesh.vertices[0];
  for (const Triangle& t : mesh.triangles)
    r.volume += (mesh.vertices[t[0]] - o).cross(mesh.vertices[t[1]] - o).dot(mesh.vertices[t[2]] - o) / 6.0;
  return r;
}

std::vector<Edge> edges(std::span<const Triangle> triangles) {
  std::vector<Edge> result;
  for_each_edge(sorted_sides(triangles), [&](const Side* first, const Side*) {
    result.push_back({first->a, first->b});
  });
  return result;
}

std::vector<Edge> edges(std::span<const Tetrahedron> tets) {
  std::vector<Edge> result;
  result.reserve(6 * tets.size());
  for (const Tetrahedron& t : tets)
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) result.push_back({std::min(t[i], t[j]), std::max(t[i], t[j])});
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

std::vector<Edge> boundary_edges(std::span<const Triangle> triangles) {
  std::vector<Edge> result;
  for_each_edge(sorted_sides(triangles), [&](const Side* first, const Side* last) {
    if (last - first == 1) result.push_back(first->forward ? Edge{first->a, first->b} : Edge{first->b, first->a});
  });
  std::sort(result.begin(), result.end());
  return result;
}

std::vector<Hinge> interior_edges(std::span<const Triangle> triangles) {
  std::vector<Hinge> result;
  for_each_edge(sorted_sides(triangles), [&](const Side* first, const Side* last) {
    const auto n = last - first;
    if (n == 1) return;
    if (n > 2)
      throw InputError(fmt::format("the edge between vertices {} and {} has {} triangles; at most 2 can fold there",
                                   first->a, first->b, n));
    if (first->forward == first[1].forward)
      throw InputError(fmt::format("triangles {} and {} run their edge {}-{} in the same direction; turn one of them",
                                   first->triangle, first[1].triangle, first->a, first->b));
    const Side& left = first->forward ? first[0] : first[1];
    const Side& right = first->forward ? first[1] : first[0];
    result.push_back({first->a, first->b, triangles[left.triangle][(left.corner + 2) % 3],
                      triangles[right.triangle][(right.corner + 2) % 3], left.triangle, right.triangle});
  });
  return result;
}

Pieces connected_pieces(std::size_t vertex_count, std::span<const Triangle> triangles) {
  UnionFind sets(vertex_count);
  std::vector<char> used(vertex_count, 0);
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      used[t[k]] = 1;
      sets.join(t[0], t[k]);
    }
  Pieces p;
  p.of_vertex.assign(vertex_count, -1);
  for (std::size_t v = 0; v < vertex_count; ++v) {
    if (!used[v]) continue;
    const std::int32_t root = sets.find(static_cast<std::int32_t>(v));
    p.of_vertex[v] = root == static_cast<std::int32_t>(v) ? p.count++ : p.of_vertex[root];
  }
  for (const Triangle& t : triangles) p.of_triangle.push_back(p.of_vertex[t[0]]);
  return p;
}

std::vector<Vec3> vertex_normals(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
  std::vector<Vec3> normals(vertices.size(), Vec3::Zero());
  for (const Triangle& t : triangles) {
    const Vec3 n = (vertices[t[1]] - vertices[t[0]]).cross(vertices[t[2]] - vertices[t[0]]);
    const double length = n.norm();
    if (!(length > 0.0)) continue;
    for (int k = 0; k < 3; ++k) {
      const Vec3 u = vertices[t[(k + 1) % 3]] - vertices[t[k]], v = vertices[t[(k + 2) % 3]] - vertices[t[k]];
      normals[t[k]] += std::atan2(u.cross(v).norm(), u.dot(v)) / length * n;
    }
  }
  for (Vec3& n : normals) {
    const double length = n.norm();
    if (length > 0.0) n /= length;
  }
  return normals;
}

Aabb bounds(std::span<const Vec3> points) {
  Aabb box;
  for (const Vec3& p : points) box.extend(p);
  return box;
}

}  // namespace brim
