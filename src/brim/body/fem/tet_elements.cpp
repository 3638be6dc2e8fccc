#include "brim/body/fem/tet_elements.h"

#include <Eigen/LU>

#include "brim/body/fem/principal_block.h"
#include "brim/core/error.h"
#include "brim/math/svd3.h"

namespace brim {

TetElements::TetElements(const TetMesh& rest, ElasticLaw law, const Lame& lame) : law_(law), lame_(lame) {
  const auto vertices = static_cast<std::int32_t>(rest.vertices.size());
  std::vector<std::int32_t> corners;
  corners.reserve(4 * rest.tets.size());
  for (std::size_t e = 0; e < rest.tets.size(); ++e)
    for (const std::int32_t n : rest.tets[e]) {
      if (n < 0 || n >= vertices)
        throw InputError(fmt::format("finite elements: tetrahedron {} names vertex {}; there are {}", e, n, vertices));
      corners.push_back(n);
    }
  schedule_.build(corners, 4, rest.vertices);
  element_.reserve(schedule_.size());
  for (const std::int32_t e : schedule_.order()) {
    const auto& t = rest.tets[e];
    const Vec3 x0 = rest.vertices[t[0]];
    Mat3 edges;
    edges << rest.vertices[t[1]] - x0, rest.vertices[t[2]] - x0, rest.vertices[t[3]] - x0;
    const double volume = edges.determinant() / 6.0, size = edges.cwiseAbs().maxCoeff();
    if (!(volume > 1e-12 * size * size * size))
      throw InputError(
          fmt::format("finite elements: tetrahedron {} has volume {} m³; it must be positive and not flat", e, volume));
    element_.push_back({edges.inverse().transpose(), volume});
    node_.insert(node_.end(), t.begin(), t.end());
  }
}

void TetElements::find_slots(const BlockMatrix& matrix) {
  slot_.resize(size());
  for (std::size_t k = 0; k < size(); ++k)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) slot_[k][4 * i + j] = matrix.slot(node_[4 * k + i], node_[4 * k + j]);
}

void TetElements::add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness, bool project) const {
  schedule_.for_each([&](std::size_t k) {
    const std::int32_t* n = node_.data() + 4 * k;
    const Element& e = element_[k];
    Mat3 edges;
    edges << x[n[1]] - x[n[0]], x[n[2]] - x[n[0]], x[n[3]] - x[n[0]];
    const Mat3 F = edges * e.gradient.transpose();
    const Svd3 d = svd3(F);
    const PrincipalResponse r = principal_response(law_, lame_, d.s, project);

    const Mat3 g = d.V.transpose() * e.gradient;  // columns g_i in the principal frame
    const Mat3 pull = -e.volume * (d.U * (r.first.asDiagonal() * g));
    force[n[0]] -= pull.rowwise().sum();
    for (int i = 0; i < 3; ++i) force[n[i + 1]] += pull.col(i);

    const Vec3 plus = 0.5 * (r.twist + r.flip), minus = 0.5 * (r.flip - r.twist);
    const auto& slot = slot_[k];
    Mat3 row_sum[3] = {Mat3::Zero(), Mat3::Zero(), Mat3::Zero()};  // Σ_j K_ij, j = 1..3
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) {
        const Mat3 K = e.volume * (d.U * principal_block(r, plus, minus, g.col(i), g.col(j)) * d.U.transpose());
        stiffness.add(slot[4 * (i + 1) + j + 1], K);
        row_sum[i] += K;
        if (j > i) {
          const Mat3 transposed = K.transpose();
          stiffness.add(slot[4 * (j + 1) + i + 1], transposed);
          row_sum[j] += transposed;
        }
      }
    // Translations cost nothing: blocks with corner 0 are minus the sums.
    Mat3 corner = Mat3::Zero();
    for (int i = 0; i < 3; ++i) {
      stiffness.add(slot[4 * (i + 1)], -row_sum[i]);
      stiffness.add(slot[i + 1], -row_sum[i].transpose());
      corner += row_sum[i];
    }
    stiffness.add(slot[0], corner);
  });
}

double TetElements::energy(std::span<const Vec3> x) const {
  return ordered_sum(size(), [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      const std::int32_t* n = node_.data() + 4 * k;
      Mat3 edges;
      edges << x[n[1]] - x[n[0]], x[n[2]] - x[n[0]], x[n[3]] - x[n[0]];
      const Svd3 d = svd3(edges * element_[k].gradient.transpose());
      sum += element_[k].volume * elastic_energy_density(law_, lame_, d.s);
    }
    return sum;
  });
}

double TetElements::volume() const {
  double sum = 0.0;
  for (const Element& e : element_) sum += e.volume;
  return sum;
}

std::vector<double> TetElements::lumped_mass(std::size_t vertices, double density) const {
  std::vector<double> mass(vertices, 0.0);
  for (std::size_t k = 0; k < size(); ++k)
    for (int i = 0; i < 4; ++i) mass[node_[4 * k + i]] += 0.25 * density * element_[k].volume;
  return mass;
}

}  // namespace brim
