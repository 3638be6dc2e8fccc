#include "brim/body/fem/edge_groups.h"

#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <utility>

namespace brim {

namespace {

using Edge = std::pair<std::int32_t, std::int32_t>;  // lower node, higher node

/// The edge that decides to which group a tetrahedron belongs.
Edge longest_edge(const TetMesh& mesh, const Tetrahedron& t) {
  constexpr double kAsLong = 1.0 + 1e-6;
  Edge best{-1, -1};
  double length = 0.0;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      const Edge edge{std::min(t[i], t[j]), std::max(t[i], t[j])};
      const double l = (mesh.vertices[t[i]] - mesh.vertices[t[j]]).norm();
      if (l > kAsLong * length || (kAsLong * l >= length && edge > best)) best = edge, length = std::max(l, length);
    }
  return best;
}

}  // namespace

EdgeGroups edge_groups(const TetMesh& mesh) {
  std::map<Edge, std::vector<std::size_t>> members;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) members[longest_edge(mesh, mesh.tets[e])].push_back(e);

  EdgeGroups out;
  for (const auto& [edge, tets] : members) {
    std::map<std::int32_t, Vec3> gradient;  // times the volume
    double volume = 0.0;
    for (const std::size_t e : tets) {
      const Tetrahedron& t = mesh.tets[e];
      Mat3 edges;
      for (int i = 0; i < 3; ++i) edges.col(i) = mesh.vertices[t[i + 1]] - mesh.vertices[t[0]];
      const Mat3 g = edges.inverse();
      const double v = edges.determinant() / 6.0;
      volume += v;
      for (const std::int32_t n : t) gradient.try_emplace(n, Vec3::Zero());
      for (int i = 0; i < 3; ++i) {
        gradient[t[i + 1]] += v * g.row(i).transpose();
        gradient[t[0]] -= v * g.row(i).transpose();
      }
    }
    for (const auto& [node, g] : gradient) {
      out.shape.rows.source.push_back(node);
      out.shape.rows.weight.push_back(0.0);
      out.shape.gradient.push_back(g / volume);
    }
    out.shape.rows.first.push_back(static_cast<std::int32_t>(out.shape.rows.source.size()));
    out.volume.push_back(volume);
  }
  return out;
}

}  // namespace brim
