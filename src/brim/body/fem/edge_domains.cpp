#include "brim/body/fem/edge_domains.h"

#include <Eigen/LU>
#include <algorithm>
#include <utility>

#include "brim/core/error.h"

namespace brim {

namespace {

struct EdgeOfTet {
  std::int32_t a, b;       // nodes, a < b
  std::size_t tet, place;  // of it in the tetrahedron
  auto operator<=>(const EdgeOfTet&) const = default;
};

std::vector<EdgeOfTet> edges_of(const TetMesh& mesh) {
  std::vector<EdgeOfTet> edges;
  edges.reserve(6 * mesh.tets.size());
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (std::size_t i = 0, place = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j, ++place) {
        const auto [a, b] = std::minmax(mesh.tets[e][i], mesh.tets[e][j]);
        edges.push_back({a, b, e, place});
      }
  std::sort(edges.begin(), edges.end());
  return edges;
}

}  // namespace

EdgeDomains edge_domains(const TetMesh& mesh, std::span<const EdgeShares> stiffness) {
  BRIM_CHECK(stiffness.size(), ==, mesh.tets.size());
  // Of each tetrahedron a sixth, and that times the gradients.
  std::vector<double> sixth(mesh.tets.size());
  std::vector<std::array<Vec3, 4>> moment(mesh.tets.size());
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const Tetrahedron& t = mesh.tets[e];
    Mat3 sides;
    for (int i = 0; i < 3; ++i) sides.col(i) = mesh.vertices[t[i + 1]] - mesh.vertices[t[0]];
    sixth[e] = sides.determinant() / 36.0;
    const Mat3 g = sixth[e] * sides.inverse().transpose();
    moment[e] = {-g.rowwise().sum(), g.col(0), g.col(1), g.col(2)};
  }

  EdgeDomains out;
  const std::vector<EdgeOfTet> edges = edges_of(mesh);
  std::vector<std::pair<std::int32_t, Vec3>> sum;  // by node
  for (std::size_t first = 0, end = 0; first < edges.size(); first = end) {
    double volume = 0.0;
    sum.clear();
    for (; end < edges.size() && edges[end].a == edges[first].a && edges[end].b == edges[first].b; ++end) {
      const std::size_t e = edges[end].tet;
      const double share = stiffness[e][edges[end].place];
      volume += share * sixth[e];
      for (int i = 0; i < 4; ++i) {
        const std::int32_t node = mesh.tets[e][i];
        const auto at = std::find_if(sum.begin(), sum.end(), [&](const auto& s) { return s.first == node; });
        if (at == sum.end())
          sum.emplace_back(node, share * moment[e][i]);
        else
          at->second += share * moment[e][i];
      }
    }
    std::sort(sum.begin(), sum.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [node, m] : sum) {
      out.shape.rows.source.push_back(node);
      out.shape.rows.weight.push_back(0.0);
      out.shape.gradient.push_back(m / volume);
    }
    out.shape.rows.first.push_back(static_cast<std::int32_t>(out.shape.rows.source.size()));
    out.volume.push_back(volume);
  }
  return out;
}

std::vector<std::array<std::int32_t, 6>> domains_of_tets(const TetMesh& mesh) {
  std::vector<std::array<std::int32_t, 6>> of(mesh.tets.size());
  const std::vector<EdgeOfTet> edges = edges_of(mesh);
  std::int32_t domain = -1;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (i == 0 || edges[i].a != edges[i - 1].a || edges[i].b != edges[i - 1].b) ++domain;
    of[edges[i].tet][edges[i].place] = domain;
  }
  return of;
}

}  // namespace brim
