#include "brim/mesh/convex_polyhedron.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "brim/mesh/topology.h"

namespace brim {

namespace {

constexpr std::size_t kMostFaces = ConvexPolyhedron::kMostFaces;
/// Cosine of 15 degrees, between the normals of two faces that share an edge: above it the edge is blunt, below minus
/// it too sharp.
constexpr double kBlunt = 0.9659;
/// Share of blunt edges from which a surface stands for a smooth one.
constexpr double kMostlyBlunt = 0.25;
/// Accuracy of coordinates relative to the extent.
constexpr double kAccuracy = 1e-6;

/// Faces of a mesh, and the face of each of its triangles.
struct Faces {
  std::vector<ConvexPolyhedron::Face> planes;
  std::vector<int> of_triangle;
};

/// Joins triangles in a common plane, the largest ones first.
std::optional<Faces> join_triangles(const TriMesh& mesh, double tolerance) {
  const std::size_t n = mesh.triangles.size();
  std::vector<Vec3> area(n);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto corner = [&](std::size_t t, int c) -> const Vec3& {
    return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][static_cast<std::size_t>(c)])];
  };
  for (std::size_t t = 0; t < n; ++t) area[t] = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t s, std::size_t t) { return area[s].squaredNorm() > area[t].squaredNorm(); });
  Faces out;
  out.of_triangle.resize(n);
  for (const std::size_t t : order) {
    const auto in_plane = [&](const ConvexPolyhedron::Face& f) {
      for (int c = 0; c < 3; ++c)
        if (std::abs(f.normal.dot(corner(t, c)) - f.offset) > tolerance) return false;
      // A triangle without area has no direction of its own.
      return f.normal.dot(area[t]) > 0.0 || area[t].norm() <= tolerance * tolerance;
    };
    const auto face = std::find_if(out.planes.begin(), out.planes.end(), in_plane);
    out.of_triangle[t] = static_cast<int>(face - out.planes.begin());
    if (face != out.planes.end()) continue;
    if (out.planes.size() == kMostFaces || !(area[t].norm() > tolerance * tolerance)) return std::nullopt;
    const Vec3 normal = area[t].normalized();
    out.planes.push_back({normal, normal.dot((corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3.0)});
  }
  return out;
}

bool convex(const TriMesh& mesh, const Faces& faces, double tolerance) {
  for (const ConvexPolyhedron::Face& f : faces.planes)
    for (const Vec3& x : mesh.vertices)
      if (f.normal.dot(x) > f.offset + tolerance) return false;
  return true;
}

/// The vertices on the line that two faces share, by the pair of faces, the smaller number first.
using Lines = std::map<std::array<int, 2>, std::vector<std::int32_t>>;

std::optional<Lines> shared_lines(const TriMesh& mesh, const Faces& faces) {
  struct Side {
    Edge edge;
    int face;
  };
  std::vector<Side> sides;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int32_t a = mesh.triangles[t][c], b = mesh.triangles[t][(c + 1) % 3];
      sides.push_back({{std::min(a, b), std::max(a, b)}, faces.of_triangle[t]});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) { return s.edge < t.edge; });
  Lines lines;
  for (std::size_t i = 0; i < sides.size(); i += 2) {
    if (i + 1 == sides.size() || sides[i].edge != sides[i + 1].edge) return std::nullopt;
    if (i + 2 < sides.size() && sides[i].edge == sides[i + 2].edge) return std::nullopt;
    const auto [f, g] = std::minmax(sides[i].face, sides[i + 1].face);
    if (f == g) continue;
    for (const std::int32_t v : sides[i].edge) lines[{f, g}].push_back(v);
  }
  return lines;
}

}  // namespace

std::optional<ConvexPolyhedron> convex_polyhedron(const TriMesh& mesh) {
  if (mesh.triangles.size() < 4) return std::nullopt;
  const double tolerance = kAccuracy * bounds(mesh.vertices).extent().norm();
  const auto faces = join_triangles(mesh, tolerance);
  if (!faces || faces->planes.size() < 4 || !convex(mesh, *faces, 2.0 * tolerance)) return std::nullopt;
  const auto lines = shared_lines(mesh, *faces);
  if (!lines) return std::nullopt;

  ConvexPolyhedron out;
  out.faces = faces->planes;
  std::map<std::int32_t, int> corner_of;
  const auto corner = [&](std::int32_t v) {
    const auto [at, added] = corner_of.try_emplace(v, static_cast<int>(out.corners.size()));
    if (added) out.corners.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
    return at->second;
  };
  int blunt = 0;
  for (const auto& [pair, vertices] : *lines) {
    const Vec3 &n0 = out.faces[static_cast<std::size_t>(pair[0])].normal,
               &n1 = out.faces[static_cast<std::size_t>(pair[1])].normal;
    ConvexPolyhedron::Edge edge{
        .faces = pair, .corners = {}, .along = n0.cross(n1), .length = 0.0, .cosine = n0.dot(n1)};
    if (edge.cosine < -kBlunt) return std::nullopt;
    if (edge.cosine > kBlunt) ++blunt;
    const auto place = [&](std::int32_t v) { return edge.along.dot(mesh.vertices[static_cast<std::size_t>(v)]); };
    const auto [first, last] = std::minmax_element(vertices.begin(), vertices.end(),
                                                   [&](std::int32_t v, std::int32_t w) { return place(v) < place(w); });
    edge.corners = {corner(*first), corner(*last)};
    const Vec3 way =
        out.corners[static_cast<std::size_t>(edge.corners[1])] - out.corners[static_cast<std::size_t>(edge.corners[0])];
    edge.length = way.norm();
    if (!(edge.length > 2.0 * tolerance)) return std::nullopt;
    edge.along = way / edge.length;
    out.edges.push_back(edge);
  }
  if (blunt > kMostlyBlunt * static_cast<double>(out.edges.size())) return std::nullopt;
  // Euler: a single piece without holes, and no corner taken twice.
  if (out.corners.size() + out.faces.size() != out.edges.size() + 2) return std::nullopt;
  return out;
}

}  // namespace brim
