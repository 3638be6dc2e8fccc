#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// A robot from a URDF file; lengths in metres, angles in radians.
struct Urdf {
  struct Geometry {
    enum class Kind { Box, Cylinder, Sphere, Mesh } kind = Kind::Box;
    Vec3 size = Vec3::Zero();      ///< [m] Box: full extents
    double radius = 0.0;           ///< [m]
    double length = 0.0;           ///< [m] Cylinder, along z
    std::filesystem::path mesh;    ///< found on disk
    Vec3 scale = Vec3::Ones();     ///< of the mesh
    Vec3 position = Vec3::Zero();  ///< [m] in the link
    Quat rotation = Quat::Identity();
    int line = 0;
  };
  struct Link {
    std::string name;
    int line = 0;
    double mass = 0.0;                   ///< [kg]
    Vec3 center_of_mass = Vec3::Zero();  ///< [m] in the link
    Mat3 inertia = Mat3::Zero();         ///< [kg m²] about the centre of mass, link's axes
    std::vector<Geometry> collision;
  };
  struct Joint {
    enum class Kind { Fixed, Revolute, Prismatic } kind = Kind::Fixed;
    std::string name;
    int line = 0;
    Vec3 position = Vec3::Zero();  ///< [m] in the parent
    Quat rotation = Quat::Identity();
    Vec3 axis = Vec3(1, 0, 0);
    double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
    double effort = std::numeric_limits<double>::infinity();  ///< [N m or N] largest force of its motor
    double damping = 0.0, friction = 0.0;
  };
  /// A link and the joint above it; parents come first. The first has no parent, and its joint is unused.
  struct Piece {
    Link link;
    int parent = -1;
    Joint joint;
  };
  std::string name;
  std::vector<Piece> pieces;
};

/// Reads links, inertia, collision geometry, joints with limits and dynamics. Visual geometry, transmissions, sensors
/// and velocity limits are ignored. "continuous" is revolute without limits. Mesh files are looked for next to the
/// file; "package://name/rest" in the folder `name` above the file or beside one of its parents, then in the folders of
/// ROS_PACKAGE_PATH.
/// @throws InputError  "file:line: what": invalid XML, unreadable numbers, missing or duplicate names, links that form
///                     no single tree, mimic, floating and planar joints, missing meshes
/// Tests: tests/io/urdf_reader_test.cpp
Urdf read_urdf(const std::filesystem::path& path);

}  // namespace brim
