#pragma once

#include <memory>

#include "brim/body/rigid/rigid_body.h"

namespace brim {

/// The model of a homogeneous rigid body: mass, centre of mass and inertia by integration over the shape's distance, to
/// some 1e-4 (boxes: to rounding); voxel_size an eighth of the smallest extent, and the thickness of
/// the shape, as in scenes. Takes tens of milliseconds: of many equal bodies make one model and copy it.
/// @param shape     of finite extent
/// @param density   [kg/m³], > 0
/// @param position  [m] of the shape's origin @param rotation  from the shape's frame to the world
/// @throws InputError
/// Tests: tests/body/make_rigid_test.cpp
RigidModel make_rigid(std::shared_ptr<const Shape> shape, double density, const Vec3& position = Vec3::Zero(),
                      const Quat& rotation = Quat::Identity());

}  // namespace brim
