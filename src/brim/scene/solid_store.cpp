#include "brim/scene/solid_store.h"

#include <algorithm>
#include <utility>

#include "brim/mesh/convex_polyhedron.h"
#include "brim/mesh/mass_properties.h"
#include "brim/raster/grid_shape.h"
#include "brim/raster/polyhedron_shape.h"

namespace brim {

namespace {

void make_anew(const SolidSurface& source, double memory_limit, Solid& solid) {
  if (source.treatment == SurfaceTreatment::Closed)
    if (auto polyhedron = convex_polyhedron(source.mesh)) {
      solid.unit = mass_properties(source.mesh, 1.0);
      solid.shape = make_polyhedron(std::move(*polyhedron));
      return;
    }
  DistanceGridOptions options;
  options.treatment = source.treatment;
  options.thickness = source.thickness;
  // Half a voxel resolves what the voxels can see.
  options.spacing = 0.5 * solid.voxel_size;
  options.margin = 2.0 * solid.voxel_size;
  options.max_nodes = static_cast<std::size_t>(memory_limit / sizeof(float));
  auto grid = std::make_shared<const DistanceGrid>(make_distance_grid(source.mesh, options));
  solid.unit =
      source.treatment == SurfaceTreatment::Closed ? mass_properties(source.mesh, 1.0) : mass_properties(*grid, 1.0);
  // The largest ball inside: the thickness of tori, gears and the like.
  const double deepest = *std::min_element(grid->values().begin(), grid->values().end());
  solid.shape = make_grid_shape(std::move(grid), -2.0 * deepest);
}

bool same(const SolidSurface& a, const SolidSurface& b) {
  return a.treatment == b.treatment && a.thickness == b.thickness && a.mesh.triangles == b.mesh.triangles &&
         a.mesh.vertices == b.mesh.vertices;
}

}  // namespace

void SolidStore::make(const SolidSurface& source, double memory_limit, Solid& solid) {
  std::erase_if(entries_, [](const Entry& e) { return e.shape.expired(); });
  for (const Entry& e : entries_)
    if (e.voxel_size == solid.voxel_size && same(e.source, source)) {
      solid.shape = e.shape.lock(), solid.unit = e.unit;
      return;
    }
  make_anew(source, memory_limit, solid);
  entries_.push_back({source, solid.voxel_size, solid.unit, solid.shape});
}

}  // namespace brim
