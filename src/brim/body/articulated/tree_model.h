#pragma once

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "brim/body/body.h"
#include "brim/raster/shape.h"

namespace brim {

/// How a link may move against its parent, and how many coordinates and velocities that takes (q, v).
enum class JointKind {
  Fixed,      ///< 0, 0
  Revolute,   ///< angle [rad] about the axis: 1, 1
  Prismatic,  ///< displacement [m] along the axis: 1, 1
  Ball,       ///< quaternion w x y z; angular velocity in the joint's frame: 4, 3
  Free        ///< position and quaternion; velocity of the link's origin and angular velocity, world frame: 7, 6
};

/// A moment of a drive's given motion.
struct TargetKey {
  double time = 0.0;   ///< [s]
  double value = 0.0;  ///< [rad or m]
};

/// A motor: force = stiffness (target − q) + damping (target_velocity − q'), no larger than force_limit. On a ball
/// joint it pulls towards the rotation of rest.
struct JointDrive {
  double stiffness = 0.0;                                        ///< [N m/rad or N/m], >= 0
  double damping = 0.0;                                          ///< [N m s/rad or N s/m], >= 0
  double force_limit = std::numeric_limits<double>::infinity();  ///< [N m or N], > 0
  double target = 0.0;                                           ///< [rad or m]
  double target_velocity = 0.0;                                  ///< [rad/s or m/s]
  /// When given, target and target_velocity follow from time: linear between keys, held outside. Times increase.
  std::vector<TargetKey> keys;
};

/// What joins a link to its parent. The link's frame is the joint's frame when its coordinate is zero.
struct JointModel {
  std::string name;
  JointKind kind = JointKind::Fixed;
  Vec3 position = Vec3::Zero();      ///< [m] of the joint's frame in the parent link's frame; Free: where it starts
  Quat rotation = Quat::Identity();  ///< likewise
  Vec3 axis = Vec3(0, 0, 1);         ///< of Revolute and Prismatic, joint's frame, any length > 0
  double lower = -std::numeric_limits<double>::infinity();  ///< [rad or m]; none for Ball
  double upper = std::numeric_limits<double>::infinity();   ///< [rad or m]; Ball: largest angle from rest, > 0
  double limit_stiffness = 0.0;  ///< [N m/rad or N/m] behind the limits; 0: as stiff as the time step can tell
  double damping = 0.0;          ///< [N m s/rad or N s/m], >= 0
  double friction = 0.0;         ///< [N m or N] dry friction, >= 0
  double armature = 0.0;         ///< [kg m² or kg] inertia of the motor, seen from the joint, >= 0
  double start = 0.0;            ///< [rad or m] initial coordinate
  double start_velocity = 0.0;   ///< [rad/s or m/s]
  Quat start_rotation = Quat::Identity();  ///< Ball: initial rotation in the joint's frame
  Vec3 velocity = Vec3::Zero();            ///< [m/s] Free: initial, of the link's origin
  Vec3 angular_velocity = Vec3::Zero();    ///< [rad/s] Ball (joint's frame), Free (world): initial
  JointDrive drive;
};

/// A solid on a link; every one is a part of the body.
struct LinkShape {
  std::shared_ptr<const Shape> shape;
  Pose pose;                ///< from the shape's to the link's frame
  Shared<TriMesh> surface;  ///< for display, shape's frame
  PartInfo part;
};

/// A rigid piece of the tree.
struct LinkModel {
  std::string name;
  int parent = -1;  ///< number of an earlier link; -1: the world
  JointModel joint;
  double mass = 0.0;                   ///< [kg], >= 0
  Vec3 center_of_mass = Vec3::Zero();  ///< [m] link's frame
  Mat3 inertia = Mat3::Zero();         ///< [kg m²] about the centre of mass, link's axes
  std::vector<LinkShape> shapes;
};

/// Links joined to a tree, parents first.
struct ArticulatedModel {
  std::vector<LinkModel> links;
  bool self_collision = true;                   ///< links that no joint connects touch each other
  std::vector<std::pair<int, int>> no_contact;  ///< further links that do not
};

}  // namespace brim
