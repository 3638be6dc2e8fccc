#include "brim/world/reference_poses.h"

#include <algorithm>
#include <cmath>

namespace brim {

namespace {

/// Count of numbers of a reference in memory: the part and its pose.
constexpr std::size_t kReference = 13;

std::size_t count_in(std::span<const double> memory) {
  return memory.empty() || memory[0] >= 0.0 ? 0 : static_cast<std::size_t>(-1.0 - memory[0]);
}

/// Motion between two poses, and the displacement of the farthest corner of a box, [m].
RigidMotion motion_between(const Pose& from, const Pose& to) {
  RigidMotion m;
  m.none = from.rotation == to.rotation && from.translation == to.translation;
  if (m.none) return m;
  const Mat3 turn = to.rotation * from.rotation.transpose();
  m.turn = turn - Mat3::Identity();
  m.center = from.translation;
  m.shift = to.translation - from.translation;
  // For a small rotation the axial vector of the skew part is the rotation vector up to third order.
  m.rotation = 0.5 * Vec3(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1));
  return m;
}

/// Upper bound of the displacement of any point of a solid, [m].
double farthest(const RigidMotion& m, const Pose& from, const Aabb& local, double reach) {
  if (m.none) return 0.0;
  if (!local.lo.allFinite() || !local.hi.allFinite()) return std::numeric_limits<double>::infinity();
  double most = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 x(corner & 1 ? local.hi.x() : local.lo.x(), corner & 2 ? local.hi.y() : local.lo.y(),
                 corner & 4 ? local.hi.z() : local.lo.z());
    most = std::max(most, (m.turn * (from.rotation * x) + m.shift).squaredNorm());
  }
  // A ball is smaller than its box: its points move at most by its displacement plus its rotation, |R − 1| = 2
  // sin(θ/2).
  const double turn = std::sqrt(0.5) * m.turn.norm();
  return std::min(std::sqrt(most), reach > 0.0 ? m.shift.norm() + turn * reach : std::sqrt(most));
}

}  // namespace

void ReferencePoses::reset(std::size_t parts) {
  pose_.assign(parts, {}), motion_.assign(parts, {}), stamp_.assign(parts, 0);
}

void ReferencePoses::restore(std::span<const double> memory, std::size_t parts) {
  reset(parts);
  const std::size_t n = count_in(memory);
  if (memory.size() < 1 + kReference * n) return;
  for (std::size_t i = 0; i < n; ++i) {
    const double* m = memory.data() + 1 + kReference * i;
    const auto part = static_cast<std::size_t>(m[0]);
    if (part >= parts) continue;
    pose_[part].rotation = Eigen::Map<const Mat3>(m + 1);
    pose_[part].translation = Eigen::Map<const Vec3>(m + 10);
    stamp_[part] = ++last_stamp_;
  }
}

void ReferencePoses::follow(std::size_t part, const Pose& now, const Aabb& local, double reach, double h) {
  motion_[part] = motion_between(pose_[part], now);
  if (stamp_[part] != 0 && farthest(motion_[part], pose_[part], local, reach) <= kTolerance * h) return;
  pose_[part] = now;
  motion_[part] = {};
  stamp_[part] = ++last_stamp_;
}

void ReferencePoses::keep(std::span<const std::int32_t> parts, std::vector<double>& memory) const {
  memory.erase(memory.begin(), memory.end() - static_cast<std::ptrdiff_t>(rows_of(memory).size()));
  if (parts.empty()) return;
  std::vector<double> head{-1.0 - static_cast<double>(parts.size())};
  head.reserve(1 + kReference * parts.size());
  for (const std::int32_t part : parts) {
    const Pose& p = pose_[static_cast<std::size_t>(part)];
    head.push_back(part);
    head.insert(head.end(), p.rotation.data(), p.rotation.data() + 9);
    head.insert(head.end(), p.translation.data(), p.translation.data() + 3);
  }
  memory.insert(memory.begin(), head.begin(), head.end());
}

std::span<const double> ReferencePoses::rows_of(std::span<const double> memory) {
  const std::size_t n = count_in(memory);
  const std::size_t head = n > 0 ? 1 + kReference * n : 0;
  return memory.subspan(std::min(head, memory.size()));
}

}  // namespace brim
