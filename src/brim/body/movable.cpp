#include "brim/body/movable.h"

#include <Eigen/Geometry>

namespace brim {

namespace {

Eigen::Map<Vec3> vector_at(std::span<double> x, std::size_t i) { return Eigen::Map<Vec3>(x.data() + i); }

}  // namespace

void Movable::move_points(const Pose& by, std::span<double> x, std::span<double> u) {
  for (std::size_t i = 0; i + 2 < x.size(); i += 3) vector_at(x, i) = by.rotation * vector_at(x, i) + by.translation;
  for (std::size_t i = 0; i + 2 < u.size(); i += 3) vector_at(u, i) = by.rotation * vector_at(u, i);
}

void Movable::move_frame(const Pose& by, std::span<double> q, std::span<double> v) {
  move_points(by, q.first(3), v.first(6));
  if (by.rotation == Mat3::Identity()) return;
  const Quat next = (Quat(by.rotation) * Quat(q[3], q[4], q[5], q[6])).normalized();
  q[3] = next.w(), q[4] = next.x(), q[5] = next.y(), q[6] = next.z();
}

}  // namespace brim
