#pragma once

#include <vector>

#include "brim/math/types.h"
#include "brim/scene/node.h"

namespace brim {

/// Key of a prescribed motion, relative to the start.
struct MotionKey {
  double time = 0.0;           ///< [s]
  Vec3 offset = Vec3::Zero();  ///< [m]
  Quat rotation = Quat::Identity();
};

/// @throws InputError  when times do not increase
void check_key_times(const Node& keyframes);
/// Reads the keys of a motion. Between rotations about one axis, given by axis or Euler angles, the angle is linear,
/// also over many turns, by keys added in between; other rotations take the short way. Tests:
/// tests/scene/motion_test.cpp
/// @param turned  of the body's placement (placement.h): offsets and axes of rotations turn by it
std::vector<MotionKey> read_motion(const Node& keyframes, const Quat& turned = Quat::Identity());
/// Offset and rotation of a motion at a time: interpolated between keys, constant outside.
MotionKey at_time(const std::vector<MotionKey>& keys, double time);
/// Reads a rotation of a scene. @throws InputError  when its axis or quaternion has length zero
Quat read_rotation(const Node& rotation);

}  // namespace brim
