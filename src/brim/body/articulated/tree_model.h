#pragma once

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "brim/body/body.h"
#include "brim/raster/shape.h"

namespace brim {

/// Motion of a link relative to its parent, and its numbers of coordinates and velocities (q, v).
enum class JointKind {
  Fixed,      ///< 0, 0
  Revolute,   ///< angle [rad] about the axis: 1, 1
  Prismatic,  ///< displacement [m] along the axis: 1, 1
  Ball,       ///< quaternion w x y z; angular velocity in the joint's frame: 4, 3
  Free        ///< position and quaternion; velocity of the link's origin and angular velocity, world frame: 7, 6
};

/// Key of a drive's prescribed target.
struct TargetKey {
  double time = 0.0;   ///< [s]
  double value = 0.0;  ///< [rad or m]
};

/// A motor: force = stiffness (target − q) + damping (target_velocity − q'), at most force_limit. For a ball joint the
/// target is the rest rotation.
struct JointDrive {
  double stiffness = 0.0;                                        ///< [N m/rad or N/m], >= 0
  double damping = 0.0;                                          ///< [N m s/rad or N s/m], >= 0
  double force_limit = std::numeric_limits<double>::infinity();  ///< [N m or N], > 0
  double target = 0.0;                                           ///< [rad or m]
  double target_velocity = 0.0;                                  ///< [rad/s or m/s]
  /// If given, target and target_velocity follow from time: linear between keys, constant outside. Times increase.
  std::vector<TargetKey> keys;
};

/// The joint between a link and its parent. The link's frame is the joint's frame when its coordinate is zero.
struct JointModel {
  std::string name;
  JointKind kind = JointKind::Fixed;
  Vec3 position = Vec3::Zero();      ///< [m] of the joint's frame in the parent link's frame; Free: initial position
  Quat rotation = Quat::Identity();  ///< likewise
  Vec3 axis = Vec3(0, 0, 1);         ///< of Revolute and Prismatic, joint's frame, any length > 0
  double lower = -std::numeric_limits<double>::infinity();  ///< [rad or m]; none for Ball
  double upper = std::numeric_limits<double>::infinity();   ///< [rad or m]; Ball: largest angle from rest, > 0
  double limit_stiffness = 0.0;  ///< [N m/rad or N/m] beyond the limits; 0: as stiff as the time step resolves
  double damping = 0.0;          ///< [N m s/rad or N s/m], >= 0
  double friction = 0.0;         ///< [N m or N] dry friction, >= 0
  double armature = 0.0;         ///< [kg m² or kg] inertia of the motor, reflected to the joint, >= 0
  double start = 0.0;            ///< [rad or m] initial coordinate
  double start_velocity = 0.0;   ///< [rad/s or m/s]
  Quat start_rotation = Quat::Identity();  ///< Ball: initial rotation in the joint's frame
  Vec3 velocity = Vec3::Zero();            ///< [m/s] Free: initial, of the link's origin
  Vec3 angular_velocity = Vec3::Zero();    ///< [rad/s] Ball (joint's frame), Free (world): initial
  JointDrive drive;
};

/// A solid on a link; each is a part of the body.
struct LinkShape {
  std::shared_ptr<const Shape> shape;
  Pose pose;                ///< from the shape's to the link's frame
  Shared<TriMesh> surface;  ///< for display, shape's frame
  PartInfo part;
};

/// A rigid link of the tree.
struct LinkModel {
  std::string name;
  int parent = -1;  ///< number of an earlier link; -1: the world
  JointModel joint;
  double mass = 0.0;                   ///< [kg], >= 0
  Vec3 center_of_mass = Vec3::Zero();  ///< [m] link's frame
  Mat3 inertia = Mat3::Zero();         ///< [kg m²] about the centre of mass, link's axes
  std::vector<LinkShape> shapes;
};

/// Links connected to a tree, parents first.
struct ArticulatedModel {
  std::vector<LinkModel> links;
  bool self_collision = true;                   ///< links without a common joint touch each other
  std::vector<std::pair<int, int>> no_contact;  ///< further pairs of links without contact
};

}  // namespace brim
