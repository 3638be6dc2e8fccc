#include "brim/body/particles/spring_elements.h"

#include <cmath>

namespace brim {

namespace {

/// Cosine below which a spring has turned too far in a step for its direction at the start to tell its length.
constexpr double kTurned = 0.5;

}  // namespace

SpringElements::SpringElements(std::span<const Spring> springs, std::span<const Vec3> x, bool slack) : slack_(slack) {
  std::vector<std::int32_t> ends;
  ends.reserve(2 * springs.size());
  for (const Spring& s : springs) ends.insert(ends.end(), s.node.begin(), s.node.end());
  schedule_.build(ends, 2, x);
  spring_.reserve(springs.size());
  node_.reserve(2 * springs.size());
  for (const std::int32_t k : schedule_.order()) {
    const Spring& s = springs[static_cast<std::size_t>(k)];
    spring_.push_back(s);
    node_.insert(node_.end(), s.node.begin(), s.node.end());
  }
}

void SpringElements::find_pairs(const BlockMatrix& matrix) {
  pair_.clear();
  for (const Spring& s : spring_) pair_.push_back(matrix.pair(s.node[0], s.node[1]));
}

void SpringElements::add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness,
                         BlockMatrix& damper) const {
  schedule_.for_each([&](std::size_t k) {
    const Spring& s = spring_[k];
    const Vec3 d = x[s.node[1]] - x[s.node[0]];
    const double l = d.norm();
    if (!(l > 0.0) || (slack_ && l <= s.length)) return;
    const Vec3 n = d / l;
    const Vec3 pull = s.stiffness * (l - s.length) * n;
    force[s.node[0]] += pull;
    force[s.node[1]] -= pull;
    const Mat3 along = s.stiffness * n * n.transpose();
    const double across = std::max(0.0, 1.0 - s.length / l);
    const Mat3 K = (1.0 - across) * along + across * s.stiffness * Mat3::Identity();
    stiffness.add(pair_[k], -K);
    damper.add(pair_[k], -along);
  });
}

double SpringElements::add_turned(std::span<const double> x, std::span<const double> way, std::span<const double> more,
                                  std::span<double> force) const {
  double energy = 0.0;
  for (const Spring& s : spring_) {
    const auto between = [&](std::span<const double> at) -> Vec3 {
      return Eigen::Map<const Vec3>(at.data() + 3 * s.node[1]) - Eigen::Map<const Vec3>(at.data() + 3 * s.node[0]);
    };
    const Vec3 d = between(x), moved = d + between(way);
    const double l = d.norm();
    if (!(l > 0.0)) continue;
    const Vec3 n = d / l;
    const double least = slack_ ? s.length : 0.0, straight = n.dot(moved);
    if (!(straight > kTurned * l)) continue;
    const double longer = std::max(least, (moved + between(more)).norm()) - std::max(least, straight);
    const Vec3 pull = s.stiffness * longer * n;
    energy += 0.5 * s.stiffness * longer * longer;
    Eigen::Map<Vec3>(force.data() + 3 * s.node[0]) += pull;
    Eigen::Map<Vec3>(force.data() + 3 * s.node[1]) -= pull;
  }
  return energy;
}

double SpringElements::energy(std::span<const Vec3> x) const {
  return ordered_sum(size(), [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      const Spring& s = spring_[k];
      const double stretch = (x[s.node[1]] - x[s.node[0]]).norm() - s.length;
      if (!slack_ || stretch > 0.0) sum += 0.5 * s.stiffness * stretch * stretch;
    }
    return sum;
  });
}

}  // namespace brim
