#pragma once

#include "brim/body/articulated/tree_model.h"

namespace brim {

/// A chain of equal capsules along +x, each connected to the end of the one before.
struct ChainOptions {
  int links = 10;
  double length = 0.1;                ///< [m] from joint to joint
  double radius = 0.02;               ///< [m], below length / 2
  double density = 1000.0;            ///< [kg/m³]
  JointKind joint = JointKind::Ball;  ///< Ball or Revolute
  Vec3 axis = Vec3(0, 1, 0);          ///< of Revolute
  bool alternate = false;             ///< every second axis rotated by 90° about the chain, as in a roller chain
  bool floating = false;              ///< the first link is free; else a joint holds it
  Vec3 position = Vec3::Zero();       ///< [m] of the chain's start
  Quat rotation = Quat::Identity();
  Vec3 velocity = Vec3::Zero();          ///< [m/s] of a floating chain's start
  Vec3 angular_velocity = Vec3::Zero();  ///< [rad/s]
  /// Limits, damping, friction and drive of every joint; its position, kind and axis are ignored.
  JointModel each;
  PartInfo part;  ///< areal_mass and thickness are set from the links
};

/// @throws InputError for invalid sizes
ArticulatedModel chain_model(const ChainOptions& options);

}  // namespace brim
