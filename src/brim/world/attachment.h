#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "brim/body/articulated/tree_model.h"
#include "brim/math/types.h"

namespace brim {

/// A joint at a frame, with the names and meaning of those of articulated bodies (JointModel): `body` is the child,
/// `to` the parent, and the coordinate is 0 in the present pose. It holds points of both sides around its position.
struct LinkJoint {
  JointKind kind = JointKind::Ball;  ///< Fixed, Revolute, Prismatic or Ball
  Vec3 position = Vec3::Zero();      ///< [m] now
  Vec3 axis = Vec3(0, 0, 1);         ///< of Revolute and Prismatic, world frame now, any length > 0
  /// [m] from its position to the points it holds; 0: a quarter of the smallest extent of the body.
  double span = 0.0;
  double lower = -std::numeric_limits<double>::infinity();  ///< [rad or m], a rotation within ±π
  double upper = std::numeric_limits<double>::infinity();
  double limit_stiffness = 0.0;  ///< [N m/rad or N/m] behind the limits; 0: rigid
  double damping = 0.0;          ///< [N m s/rad or N s/m] along the coordinate
  JointDrive drive;              ///< along the coordinate
};

/// Attaches points of one body to another body or to space (docs/links.md). Springs and dampers act between material
/// points, through the same maps as contact and in the same implicit solve, so momentum is conserved as in contact.
struct Attachment {
  std::string name;  ///< in reports and messages; must be unique
  std::string body;  ///< side a
  std::string to;    ///< side b; empty: space
  int part = -1;     ///< of the body; −1: the one nearest to the point
  int to_part = -1;

  /// Exactly one of joint, point and region says what is held.
  std::optional<LinkJoint> joint{};
  std::optional<Vec3> point;                  ///< [m] now; for bodies of nodes the nearest material point
  std::function<bool(const Vec3&)> region{};  ///< of the body's vertices at their present positions
  /// [m] point held on the other side; nothing: the same place. Only with a point.
  std::optional<Vec3> to_point;
  /// Motion of the target in space: place at a time of the point now at x, [m]; middle: mean of all its points. Only
  /// without `to`.
  std::function<Vec3(double time, const Vec3& x, const Vec3& middle)> motion{};

  double stiffness = 0.0;  ///< [N/m] of all its points together; 0: rigid, as stiff as the solve allows
  double damping = 0.0;    ///< [N s/m] of all points together; for a joint both are those of its constraint
  /// [m] rest length of the spring, which then acts only along the line between its ends. Nothing: when the ends
  /// coincide, length 0 and acting in every direction, else their distance now.
  std::optional<double> length;
  bool pulls_only = false;                                       ///< a rope: slack when shorter than its length
  double break_force = std::numeric_limits<double>::infinity();  ///< [N] total force that breaks it for good
  bool touch = true;                                             ///< false: the two bodies do not touch each other

  /// [m] Output of World::attachment, ignored as input: present positions of the held points on side a and on side b;
  /// of a revolute or prismatic joint the first two are on its axis. Empty once broken or detached.
  std::vector<std::pair<Vec3, Vec3>> ends{};
};

}  // namespace brim
