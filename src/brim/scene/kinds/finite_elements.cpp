#include <algorithm>

#include "brim/body/fem/fem_body.h"
#include "brim/io/tet_reader.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/tet_lattice.h"
#include "brim/mesh/topology.h"
#include "brim/scene/constraints.h"
#include "brim/scene/kinds.h"
#include "brim/scene/limits.h"
#include "brim/scene/solid.h"

namespace brim {

BodyKind finite_elements_kind();

namespace {

/// [bytes] that a tetrahedron with its share of nodes, matrix blocks and state takes.
constexpr double kBytesPerTet = 1000.0;

void check(const Node& n) {
  if (n.has("shape") && n.has("tet_mesh"))
    throw n.at("tet_mesh").error("both \"shape\" and \"tet_mesh\" are given; give one");
  if (!n.has("shape") && !n.has("tet_mesh"))
    throw n.error("the key \"shape\" is missing; give \"shape\" or \"tet_mesh\"");
  if (n.has("shape")) {
    if (n.at("shape").string("kind") == "plane")
      throw n.at("shape").at("kind").error("\"plane\" has no finite volume; only an obstacle can be one");
    check_shape(n.at("shape"));
    if (!n.has("lattice_spacing"))
      throw n.error(
          "the key \"lattice_spacing\" is missing; a shape is filled with tetrahedra of this size, in metres");
  } else if (n.has("lattice_spacing")) {
    throw n.at("lattice_spacing")
        .error("a \"tet_mesh\" has its own tetrahedra; only \"shape\" takes a lattice_spacing");
  }
  check_constraints(n.at("constraints"), false);
}

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

class FiniteElementsMaker final : public BodyMaker {
 public:
  FiniteElementsMaker(const Node& n, const BuildContext& context) : node_(n), material_(context.material) {
    const double scale = n.at("transform").number("scale"), limit = context.world.memory_limit;
    if (n.has("tet_mesh")) {
      const std::string path = scene_path(n.at("tet_mesh"));
      mesh_ = n.at("tet_mesh").placed([&] { return read_tets(path); });
      for (Vec3& x : mesh_.vertices) x *= scale;
    } else {
      const SolidSurface source = read_surface_of(n.at("shape"), scale);
      const double spacing = scale * n.number("lattice_spacing");
      mesh_ = fill(n, source, spacing, limit);
      if (source.treatment == SurfaceTreatment::Closed) display_ = refine(source.mesh, spacing);
    }
    if (n.number("voxel_size") > 0.0) {
      const TriMesh surface{mesh_.vertices, tet_surface(mesh_).triangles};
      check_voxel_size(n, n.number("voxel_size"), surface_area(surface), limit);
    }
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    TetMesh mesh = mesh_;
    for (Vec3& x : mesh.vertices) x = place.position + place.rotation * x;
    FemOptions options;
    options.density = node_.number("density");
    options.young = node_.number("young_modulus");
    options.poisson = node_.number("poisson_ratio");
    options.law = node_.string("law") == "neo_hookean" ? ElasticLaw::StableNeoHookean : ElasticLaw::CorotationalLinear;
    options.stiffness_damping = node_.number("stiffness_damping");
    options.mass_damping = node_.number("mass_damping");
    options.initial_velocity = place.velocity;
    options.initial_spin = place.angular_velocity;
    options.voxel_size = node_.number("voxel_size");
    options.material = material_;
    options.display = display_;
    for (Vec3& x : options.display.vertices) x = place.position + place.rotation * x;
    read_constraints(node_.at("constraints"), mesh.vertices, {}, options);
    return std::make_unique<FemBody>(std::move(mesh), std::move(options));
  }

 private:
  Node node_;
  Material material_;
  TetMesh mesh_;     ///< scaled, not placed
  TriMesh display_;  ///< likewise; empty: the boundary of the mesh
};

}  // namespace

BodyKind finite_elements_kind() {
  return {"finite_elements", check, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<FiniteElementsMaker>(n, c);
          }};
}

}  // namespace brim
