#pragma once

#include <string>
#include <utility>

#include "brim/world/attachment.h"

/// Joints between bodies (LinkJoint).
namespace brim::testing {

inline Attachment joint(JointKind kind, std::string body, std::string to, const Vec3& x,
                        const Vec3& axis = Vec3(0, 0, 1)) {
  Attachment a;
  a.name = "joint", a.body = std::move(body), a.to = std::move(to);
  a.touch = false;
  a.joint.emplace();
  a.joint->kind = kind, a.joint->position = x, a.joint->axis = axis;
  return a;
}

}  // namespace brim::testing
