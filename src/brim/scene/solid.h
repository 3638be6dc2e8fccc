#pragma once

#include <memory>
#include <string>

#include "brim/core/shared.h"
#include "brim/mesh/distance_grid.h"
#include "brim/mesh/tri_mesh.h"
#include "brim/raster/shape.h"
#include "brim/scene/node.h"

namespace brim {

class SolidStore;

/// The surface of a scene's shape and its conversion to a solid.
struct SolidSurface {
  TriMesh mesh;  ///< [m], the shape's own frame, scaled
  SurfaceTreatment treatment = SurfaceTreatment::Closed;
  double thickness = 0.0;  ///< [m], for SurfaceTreatment::Thickness
  bool round = false;      ///< smooth: the display mesh is an approximation
};

/// A rigid solid with the data needed by bodies.
struct Solid {
  std::shared_ptr<const Shape> shape;
  Shared<TriMesh> surface;  ///< for display, shape's frame
  MassProperties unit;      ///< of density 1 kg/m³; zero for the half space
  double area = 0.0;        ///< [m²] of the surface
  double voxel_size = 0.0;  ///< [m] suitable grid step
};

/// Refuses a plane. @param lacks  what a plane has no finite amount of: volume, mass  @throws InputError
void refuse_plane(const Node& shape, const char* lacks);

/// Checks of a shape that the schema cannot express; reads no files. @throws InputError
void check_shape(const Node& shape);

/// Resolves a path of a scene: ${NAME} is replaced by the environment variable, relative to the scene's folder.
/// @throws InputError  for an unset variable or a missing file
std::string scene_path(const Node& path);

/// Makes or reads the surface. @param scale  [-] of all lengths
/// @throws InputError  for invalid sizes, unreadable files, meshes that do not suit the treatment
SolidSurface read_surface_of(const Node& shape, double scale);

/// The rigid solid of a body's "shape", "transform" scale and "voxel_size": exact distance for primitives, a sampled
/// distance field for all others. The default voxel_size is an eighth of the shape's smallest extent.
/// @param memory_limit  [bytes] of the scene @param store  solids sampled so far
/// @throws InputError
Solid read_solid(const Node& body, double memory_limit, SolidStore& store);

/// The same for a shape alone. @param at  node whose "voxel_size" is named when there are too many voxels
/// @param voxel_size  [m] 0: an eighth of the smallest extent
Solid read_solid(const Node& shape, const Node& at, double scale, double voxel_size, double memory_limit,
                 SolidStore& store);

}  // namespace brim
