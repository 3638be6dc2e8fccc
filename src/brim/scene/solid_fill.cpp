#include "brim/scene/solid_fill.h"

#include <algorithm>

#include "brim/mesh/mass_properties.h"
#include "brim/mesh/tet_lattice.h"
#include "brim/mesh/topology.h"
#include "brim/scene/given_arrays.h"
#include "brim/scene/limits.h"
#include "brim/scene/solid.h"

namespace brim {

namespace {

/// [bytes] that a tetrahedron with its share of nodes, matrix blocks and state takes.
constexpr double kBytesPerTet = 1000.0;

/// Fills a surface with tetrahedra.
TetMesh fill(const Node& n, const SolidSurface& source, double spacing, double limit) {
  const Aabb box = bounds(source.mesh.vertices);
  const Node at = n.at("lattice_spacing");
  if (spacing > box.extent().maxCoeff())
    throw at.error(fmt::format("{:.6g} m is not allowed; must be at most the shape's largest extent, {:.6g} m", spacing,
                               box.extent().maxCoeff()));
  // Twelve tetrahedra per cubic cell; the box bounds the volume where the surface does not enclose one.
  const double enclosed = enclosed_volume(source.mesh);
  const double volume = source.treatment == SurfaceTreatment::Closed ? enclosed : box.extent().prod();
  check_count(at, 12.0 * volume / (spacing * spacing * spacing), kBytesPerTet, limit, "tetrahedra");
  const LatticeStyle style = n.string("lattice") == "covering" ? LatticeStyle::Covering : LatticeStyle::Conforming;
  return at.placed([&] {
    if (source.treatment == SurfaceTreatment::Closed) return tet_lattice(source.mesh, spacing, style);
    DistanceGridOptions options;
    options.treatment = source.treatment;
    options.thickness = source.thickness;
    options.spacing = 0.25 * spacing;
    options.margin = spacing;
    const DistanceGrid grid = make_distance_grid(source.mesh, options);
    return tet_lattice([&](const Vec3& x) { return grid.value(x); }, grid.solid_box().inflated(spacing), spacing,
                       style);
  });
}

}  // namespace

void check_fill(const Node& n) {
  if (n.has("shape") && n.has("tet_mesh"))
    throw n.at("tet_mesh").error("both \"shape\" and \"tet_mesh\" are given; give one");
  if (n.has("shape")) {
    refuse_plane(n.at("shape"), "volume");
    check_shape(n.at("shape"));
    if (!n.has("lattice_spacing"))
      throw n.error(
          "the key \"lattice_spacing\" is missing; a shape is filled with tetrahedra of this size, in metres");
  } else if (n.has("lattice_spacing")) {
    throw n.at("lattice_spacing")
        .error(n.has("tet_mesh") ? "a \"tet_mesh\" has its own tetrahedra; only \"shape\" takes a lattice_spacing"
                                 : "only \"shape\" takes a lattice_spacing");
  }
}

FilledSolid read_filled(const Node& n, double scale, double memory_limit) {
  FilledSolid out;
  if (n.has("tet_mesh")) {
    out.mesh = named_tets(n.at("tet_mesh"));
    for (Vec3& x : out.mesh.vertices) x *= scale;
  } else {
    const SolidSurface source = read_surface_of(n.at("shape"), scale);
    const double spacing = scale * n.number("lattice_spacing");
    out.mesh = fill(n, source, spacing, memory_limit);
    if (source.treatment == SurfaceTreatment::Closed) {
      out.display = refine(source.mesh, spacing);
      if (n.string("lattice") != "covering")
        out.volume_share = enclosed_volume(source.mesh) / tet_quality(out.mesh).total_volume;
    }
  }
  return out;
}

}  // namespace brim
