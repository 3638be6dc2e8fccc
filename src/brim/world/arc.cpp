#include "brim/world/arc.h"

#include <vector>

#include "brim/body/rigid_frame.h"
#include "brim/core/interface_of.h"

namespace brim {

Arc::Arc(const Body& body, std::span<const double> q, std::span<const double> v, double dt) {
  if (interface_of<RigidFrame>(body) == nullptr || q.size() != 7 || v.size() != 6) return;
  std::vector<double> end(q.begin(), q.end());
  body.advance(dt, end, v);
  center_ = Vec3(q[0], q[1], q[2]);
  spin_ = dt * Vec3(v[3], v[4], v[5]);
  way_ = Vec3(end[0], end[1], end[2]) - center_ - dt * Vec3(v[0], v[1], v[2]);
  rotation_ = (Quat(end[3], end[4], end[5], end[6]) * Quat(q[3], q[4], q[5], q[6]).conjugate()).toRotationMatrix();
}

Vec3 Arc::bend(const Vec3& x) const {
  const Vec3 r = x - center_;
  return way_ + rotation_ * r - r - spin_.cross(r);
}

}  // namespace brim
