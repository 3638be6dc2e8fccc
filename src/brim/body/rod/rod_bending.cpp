#include "brim/body/rod/rod_bending.h"

#include <cmath>

#include "brim/core/error.h"

namespace brim {

namespace {

/// 1 + t_0·t_1 below which the edges count as folded onto each other.
constexpr double kFolded = 1e-6;

/// Two edges and their curvature binormal; false where an edge has no length or the two are folded.
struct Bend {
  Vec3 t0, t1, kappa;
  double l0, l1, chi;
  bool take(std::span<const Vec3> x, const std::int32_t* n) {
    t0 = x[n[1]] - x[n[0]];
    t1 = x[n[2]] - x[n[1]];
    l0 = t0.norm();
    l1 = t1.norm();
    if (!(l0 > 0.0) || !(l1 > 0.0)) return false;
    t0 /= l0;
    t1 /= l1;
    chi = 1.0 + t0.dot(t1);
    if (!(chi > kFolded)) return false;
    kappa = 2.0 / chi * t0.cross(t1);
    return true;
  }
  /// ∂κ/∂x of the three nodes.
  std::array<Mat3, 3> jacobian() const {
    const Mat3 d0 = (-2.0 * skew(t1) - kappa * t1.transpose()) / chi * (Mat3::Identity() - t0 * t0.transpose()) / l0;
    const Mat3 d1 = (2.0 * skew(t0) - kappa * t0.transpose()) / chi * (Mat3::Identity() - t1 * t1.transpose()) / l1;
    return {-d0, d0 - d1, d1};
  }
};

}  // namespace

RodBending::RodBending(std::span<const std::array<std::int32_t, 3>> triples, std::span<const Vec3> x, double B,
                       bool bent) {
  std::vector<std::int32_t> nodes;
  for (const auto& t : triples) nodes.insert(nodes.end(), t.begin(), t.end());
  schedule_.build(nodes, 3, x);
  for (const std::int32_t k : schedule_.order()) {
    const auto& t = triples[static_cast<std::size_t>(k)];
    Bend bend;
    if (!bend.take(x, t.data())) throw InputError(fmt::format("rod: it folds back onto itself at node {}", t[1]));
    element_.push_back({2.0 * B / (bend.l0 + bend.l1), bent ? bend.kappa.norm() : 0.0});
    node_.insert(node_.end(), t.begin(), t.end());
  }
}

void RodBending::find_pairs(const BlockMatrix& matrix) {
  pair_.clear();
  for (std::size_t k = 0; k < size(); ++k) {
    const std::int32_t* n = node_.data() + 3 * k;
    pair_.push_back({matrix.pair(n[0], n[1]), matrix.pair(n[0], n[2]), matrix.pair(n[1], n[2])});
  }
}

void RodBending::add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness,
                     BlockMatrix& damper) const {
  schedule_.for_each([&](std::size_t k) {
    const std::int32_t* n = node_.data() + 3 * k;
    const Element& e = element_[k];
    Bend bend;
    if (!bend.take(x, n)) return;
    const std::array<Mat3, 3> J = bend.jacobian();
    const double size = bend.kappa.norm();
    // A rod that rests bent has no direction to bend to where it is straight, and no force there.
    const double share = e.curvature == 0.0 ? 1.0 : size > 0.0 ? 1.0 - e.curvature / size : 0.0;
    const double across = std::max(0.0, share);
    Mat3 metric = across * Mat3::Identity();
    if (size > 0.0) metric += (1.0 - across) / (size * size) * bend.kappa * bend.kappa.transpose();
    metric *= e.stiffness;
    for (int i = 0, p = 0; i < 3; ++i) {
      force[n[i]] -= e.stiffness * share * (J[i].transpose() * bend.kappa);
      const Mat3 left = J[i].transpose() * metric;
      for (int j = i + 1; j < 3; ++j, ++p) {
        const Mat3 K = left * J[j];
        stiffness.add(pair_[k][p], K);
        damper.add(pair_[k][p], K);
      }
    }
  });
}

double RodBending::energy(std::span<const Vec3> x) const {
  return ordered_sum(size(), [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      Bend bend;
      if (bend.take(x, node_.data() + 3 * k))
        sum += 0.5 * element_[k].stiffness * std::pow(bend.kappa.norm() - element_[k].curvature, 2);
    }
    return sum;
  });
}

}  // namespace brim
