#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/bvh.h"
#include "brim/mesh/distance.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/tet_lattice.h"

namespace brim {

namespace {

constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};  // opposite corner k, outward

// Barycentric weights of p, extrapolated outside.
std::array<double, 4> weights_of(const std::array<Vec3, 4>& x, const Vec3& p) {
  const double v = 1.0 / tet_volume(x[0], x[1], x[2], x[3]);
  std::array<double, 4> w{};
  w[1] = tet_volume(x[0], p, x[2], x[3]) * v;
  w[2] = tet_volume(x[0], x[1], p, x[3]) * v;
  w[3] = tet_volume(x[0], x[1], x[2], p) * v;
  w[0] = 1.0 - w[1] - w[2] - w[3];
  return w;
}

std::array<Vec3, 4> corners(const TetMesh& mesh, std::size_t e) {
  return {mesh.vertices[mesh.tets[e][0]], mesh.vertices[mesh.tets[e][1]], mesh.vertices[mesh.tets[e][2]],
          mesh.vertices[mesh.tets[e][3]]};
}

double squared_distance(const std::array<Vec3, 4>& x, const Vec3& p) {
  const std::array<double, 4> w = weights_of(x, p);
  if (*std::min_element(w.begin(), w.end()) >= 0.0) return 0.0;
  double best = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 4; ++k)
    best = std::min(
        best, (closest_on_triangle(p, x[kFaces[k][0]], x[kFaces[k][1]], x[kFaces[k][2]]).point - p).squaredNorm());
  return best;
}

}  // namespace

TetQuality tet_quality(const TetMesh& mesh) {
  TetQuality q;
  if (mesh.tets.empty()) return q;
  q.min_volume = q.min_dihedral = q.min_ratio = std::numeric_limits<double>::infinity();
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const std::array<Vec3, 4> x = corners(mesh, e);
    const double v = tet_volume(x[0], x[1], x[2], x[3]);
    std::array<Vec3, 4> n;
    for (int k = 0; k < 4; ++k)
      n[k] = (x[kFaces[k][1]] - x[kFaces[k][0]]).cross(x[kFaces[k][2]] - x[kFaces[k][0]]).normalized();
    double squares = 0.0;
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) {
        const double angle = std::numbers::pi - std::acos(std::clamp(n[i].dot(n[j]), -1.0, 1.0));
        q.min_dihedral = std::min(q.min_dihedral, angle);
        q.max_dihedral = std::max(q.max_dihedral, angle);
        squares += (x[i] - x[j]).squaredNorm();
      }
    const double ratio = 6.0 * std::numbers::sqrt2 * v / std::pow(squares / 6.0, 1.5);
    q.min_ratio = std::min(q.min_ratio, ratio);
    q.mean_ratio += ratio / static_cast<double>(mesh.tets.size());
    q.min_volume = std::min(q.min_volume, v);
    q.total_volume += v;
  }
  return q;
}

Embedding embed(const TetMesh& mesh, std::span<const Vec3> points) {
  if (mesh.tets.empty()) throw InputError("embedding: the mesh has no tetrahedra");
  std::vector<Aabb> boxes(mesh.tets.size());
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (const Vec3& x : corners(mesh, e)) boxes[e].extend(x);
  const Bvh tree(boxes);
  Embedding result;
  result.tet.resize(points.size());
  result.weights.resize(points.size());
  std::vector<double> distance2(points.size());
  parallel_for(
      points.size(),
      [&](std::size_t i) {
        double best2 = std::numeric_limits<double>::infinity();
        std::int32_t best = -1;
        tree.nearest(points[i], best2, [&](std::int32_t e, double& bound2) {
          const double d2 = squared_distance(corners(mesh, static_cast<std::size_t>(e)), points[i]);
          if (d2 > bound2 || (d2 == bound2 && best >= 0 && e > best)) return;
          bound2 = d2;
          best = e;
        });
        if (best < 0) throw InputError(fmt::format("embedding: point {} is not finite", i));
        result.tet[i] = best;
        result.weights[i] = weights_of(corners(mesh, static_cast<std::size_t>(best)), points[i]);
        distance2[i] = best2;
      },
      16);
  for (const double d2 : distance2) result.farthest = std::max(result.farthest, std::sqrt(d2));
  return result;
}

std::vector<Vec3> interpolate(const Embedding& embedding, std::span<const Tetrahedron> tets,
                              std::span<const Vec3> vertices) {
  std::vector<Vec3> points(embedding.tet.size(), Vec3::Zero());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Tetrahedron& t = tets[embedding.tet[i]];
    for (int k = 0; k < 4; ++k) points[i] += embedding.weights[i][k] * vertices[t[k]];
  }
  return points;
}

}  // namespace brim
