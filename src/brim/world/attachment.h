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
/// `to` the parent, and the coordinate is 0 as they are now. It holds points of both sides around its place.
struct LinkJoint {
  JointKind kind = JointKind::Ball;  ///< Fixed, Revolute, Prismatic or Ball
  Vec3 position = Vec3::Zero();      ///< [m] now
  Vec3 axis = Vec3(0, 0, 1);         ///< of Revolute and Prismatic, world frame now, any length > 0
  /// [m] from its place to the points that it holds; 0: a quarter of the smallest extent of the body.
  double span = 0.0;
  double lower = -std::numeric_limits<double>::infinity();  ///< [rad or m], within ±π of a turn
  double upper = std::numeric_limits<double>::infinity();
  double limit_stiffness = 0.0;  ///< [N m/rad or N/m] behind the limits; 0: rigid
  double damping = 0.0;          ///< [N m s/rad or N s/m] along the coordinate
  JointDrive drive;              ///< along the coordinate
};

/// What holds points of one body to another body or to space (docs/links.md). Springs and dampers act between points of
/// matter, through the same maps as contact, in the same implicit solve: momentum is kept as contact keeps it.
struct Attachment {
  std::string name;  ///< in reports and messages; must be unique
  std::string body;  ///< side a
  std::string to;    ///< side b; empty: space
  int part = -1;     ///< of the body; −1: the one nearest to the point
  int to_part = -1;

  /// Exactly one of the three says what of the body is held.
  std::optional<LinkJoint> joint{};
  std::optional<Vec3> point;                  ///< [m] now; for bodies of nodes the matter nearest to it
  std::function<bool(const Vec3&)> region{};  ///< of the body's vertices, as they are now
  /// [m] where it is held on the other side; nothing: at the same place. Only with a point.
  std::optional<Vec3> to_point;
  /// The target in space moves: place at a time of what is at x now, [m]; middle: of all its points. Only without `to`.
  std::function<Vec3(double time, const Vec3& x, const Vec3& middle)> motion{};

  double stiffness = 0.0;  ///< [N/m] of all its points together; 0: rigid, as stiff as the solve can bear
  double damping = 0.0;    ///< [N s/m] of all together; of a joint, both are of what it holds
  /// [m] at which the spring is at rest; it then acts along the line between its ends only. Nothing: 0 where the ends
  /// are at the same place, where it acts in every direction, else their distance now.
  std::optional<double> length;
  bool pulls_only = false;                                       ///< a rope: slack when shorter than its length
  double break_force = std::numeric_limits<double>::infinity();  ///< [N] total above which it is gone for good
  bool touch = true;                                             ///< false: the two bodies do not touch each other

  /// [m] Told by World::attachment, not read: where the points that hold lie now, on side a and on side b; of a joint
  /// that turns or slides, the first two are on its axis. None once it is gone.
  std::vector<std::pair<Vec3, Vec3>> ends{};
};

}  // namespace brim
