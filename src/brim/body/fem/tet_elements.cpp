#include "brim/body/fem/tet_elements.h"

#include <Eigen/LU>
#include <algorithm>
#include <numeric>

#include "brim/core/error.h"

namespace brim {

namespace {
constexpr int kLaneCount = TetLanes::kCount;
static_assert(ElementSchedule::kChunk % kLaneCount == 0);
}  // namespace

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
  lanes_.resize(first_lanes(schedule_.size()));
  const auto edges_of = [&](const Tetrahedron& t) {
    Mat3 edges;
    for (int i = 0; i < 3; ++i) edges.col(i) = rest.vertices[t[i + 1]] - rest.vertices[t[0]];
    return edges;
  };
  for (const std::int32_t e : schedule_.order()) {
    Tetrahedron t = rest.tets[e];
    const Mat3 given = edges_of(t);
    const double volume = given.determinant() / 6.0, size = given.cwiseAbs().maxCoeff();
    if (!(volume > 1e-12 * size * size * size))
      throw InputError(
          fmt::format("finite elements: tetrahedron {} has volume {} m³; it must be positive and not flat", e, volume));
    // In ascending order all blocks K_ij, i < j, lie above the diagonal of the matrix.
    std::sort(t.begin(), t.end());
    node_.insert(node_.end(), t.begin(), t.end());
    volume_.push_back(volume);
  }
  schedule_.for_chunks([&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < begin + (end - begin + kLaneCount - 1) / kLaneCount * kLaneCount; ++k) {
      const std::size_t place = std::min(k, end - 1), lane = (k - begin) % kLaneCount;
      TetLanes& lanes = lanes_[first_lanes(begin) + (k - begin) / kLaneCount];
      const std::int32_t* n = node_.data() + 4 * place;
      const Mat3 g = edges_of({n[0], n[1], n[2], n[3]}).inverse().transpose();
      for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 3; ++c) lanes.gradient[i][c][lane] = g(c, i);
      lanes.volume[lane] = volume_[place];
    }
  });
}

void TetElements::scale_stiffness(std::span<const double> factor) {
  BRIM_CHECK(factor.size(), ==, size());
  const std::span<const std::int32_t> order = schedule_.order();
  schedule_.for_chunks([&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < begin + (end - begin + kLaneCount - 1) / kLaneCount * kLaneCount; ++k)
      // Energy, force and stiffness are all the volume times something of the material.
      lanes_[first_lanes(begin) + (k - begin) / kLaneCount].volume[(k - begin) % kLaneCount] *=
          factor[static_cast<std::size_t>(order[std::min(k, end - 1)])];
  });
}

void TetElements::find_pairs(const BlockMatrix& matrix) {
  pair_.resize(size());
  for (std::size_t k = 0; k < size(); ++k)
    for (int i = 0, p = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j, ++p) pair_[k][p] = matrix.pair(node_[4 * k + i], node_[4 * k + j]);
}

void TetElements::take_edges(std::size_t at, std::size_t end, std::span<const Vec3> x,
                             double edge[3][3][TetLanes::kCount]) const {
  for (std::size_t lane = 0; lane < kLaneCount; ++lane) {
    const std::int32_t* n = node_.data() + 4 * std::min(at + lane, end - 1);
    for (int i = 0; i < 3; ++i)
      for (int c = 0; c < 3; ++c) edge[i][c][lane] = x[n[i + 1]][c] - x[n[0]][c];
  }
}

void TetElements::add_chunk(std::size_t begin, std::size_t end, std::span<const Vec3> x, std::span<Vec3> force,
                            BlockMatrix& stiffness, bool project, std::span<double> energy) const {
  TetResponse r;
  double edge[3][3][kLaneCount];
  for (std::size_t at = begin; at < end; at += kLaneCount) {
    take_edges(at, end, x, edge);
    respond(law_, lame_, project, lanes_[first_lanes(begin) + (at - begin) / kLaneCount], edge, r);
    for (std::size_t lane = 0; lane < std::min<std::size_t>(kLaneCount, end - at); ++lane) {
      const std::int32_t* n = node_.data() + 4 * (at + lane);
      for (int i = 0; i < 4; ++i)
        for (int c = 0; c < 3; ++c) force[n[i]][c] += r.force[i][c][lane];
      for (int p = 0; p < 6; ++p) {
        float* to = stiffness.values(pair_[at + lane][p]);
        for (int k = 0; k < 9; ++k) to[k] += r.block[p][k][lane];
      }
      if (!energy.empty()) energy[at + lane] = r.energy[lane];
    }
  }
}

std::optional<double> TetElements::add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness,
                                       bool project) const {
  std::vector<double> energy(gives_energy(law_) ? size() : 0);
  schedule_.for_chunks(
      [&](std::size_t begin, std::size_t end) { add_chunk(begin, end, x, force, stiffness, project, energy); });
  if (!gives_energy(law_)) return std::nullopt;
  return std::accumulate(energy.begin(), energy.end(), 0.0);
}

double TetElements::energy(std::span<const Vec3> x) const {
  std::vector<double> of_element(size());
  schedule_.for_chunks([&](std::size_t begin, std::size_t end) {
    double edge[3][3][kLaneCount], e[kLaneCount];
    for (std::size_t at = begin; at < end; at += kLaneCount) {
      take_edges(at, end, x, edge);
      brim::energy(law_, lame_, lanes_[first_lanes(begin) + (at - begin) / kLaneCount], edge, e);
      std::copy_n(e, std::min<std::size_t>(kLaneCount, end - at), of_element.data() + at);
    }
  });
  return std::accumulate(of_element.begin(), of_element.end(), 0.0);
}

void TetElements::find_stress(std::span<const Vec3> x, std::span<Mat3> F, std::span<Mat3> P) const {
  BRIM_CHECK(F.size(), ==, size());
  BRIM_CHECK(P.size(), ==, size());
  schedule_.for_chunks([&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const TetLanes& lanes = lanes_[first_lanes(begin) + (k - begin) / kLaneCount];
      const std::size_t lane = (k - begin) % kLaneCount;
      const auto e = static_cast<std::size_t>(schedule_.order()[k]);
      const std::int32_t* n = node_.data() + 4 * k;
      F[e].setZero();
      for (int i = 0; i < 3; ++i)
        F[e] += (x[n[i + 1]] - x[n[0]]) *
                Vec3(lanes.gradient[i][0][lane], lanes.gradient[i][1][lane], lanes.gradient[i][2][lane]).transpose();
      P[e] = lanes.volume[lane] / volume_[k] * first_piola_stress(law_, lame_, F[e]);
    }
  });
}

double TetElements::volume() const {
  double sum = 0.0;
  for (const double v : volume_) sum += v;
  return sum;
}

std::vector<double> TetElements::lumped_mass(std::size_t vertices, double density) const {
  std::vector<double> mass(vertices, 0.0);
  for (std::size_t k = 0; k < size(); ++k)
    for (int i = 0; i < 4; ++i) mass[node_[4 * k + i]] += 0.25 * density * volume_[k];
  return mass;
}

}  // namespace brim
