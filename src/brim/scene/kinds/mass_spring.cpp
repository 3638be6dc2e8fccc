#include <variant>

#include "brim/body/mass_spring/mass_spring_body.h"
#include "brim/io/tet_reader.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/tet_lattice.h"
#include "brim/mesh/topology.h"
#include "brim/scene/constraints.h"
#include "brim/scene/given_arrays.h"
#include "brim/scene/kinds.h"
#include "brim/scene/limits.h"
#include "brim/scene/particle_options.h"
#include "brim/scene/sheet_grid.h"
#include "brim/scene/solid.h"
#include "brim/scene/solid_fill.h"

namespace brim {

BodyKind mass_spring_kind();

namespace {

/// [bytes] that a cell with its springs, matrix blocks and state takes.
constexpr double kBytesPerSpringCell = 2000.0;

void check_mass_spring(const Node& n) {
  const char* const sources[] = {"shape", "tet_mesh", "grid", "mesh"};
  const char* given = nullptr;
  for (const char* s : sources) {
    if (!n.has(s)) continue;
    if (given != nullptr) throw n.at(s).error(fmt::format("both \"{}\" and \"{}\" are given; give one", given, s));
    given = s;
  }
  if (given == nullptr)
    throw n.error(
        "what the springs join is missing; give \"shape\" or \"tet_mesh\" for a solid, \"grid\" or \"mesh\" for a "
        "sheet or net");
  const bool flat = n.has("grid") || n.has("mesh");
  if (n.has("form") && !flat)
    throw n.at("form").error("only \"grid\" and \"mesh\" have a form; a shape and a tet_mesh are solids");
  if (n.has("thickness") && !flat)
    throw n.at("thickness").error("only a sheet or net has a thickness; a solid is where its tetrahedra are");
  if (n.boolean("self_contact") && !flat)
    throw n.at("self_contact").error("only a sheet or net touches itself; give \"grid\" or \"mesh\"");
  check_fill(n);
  check_constraints(n.at("constraints"), n.has("grid"));
}

using AnyMesh = std::variant<TetMesh, TriMesh, LineMesh>;

std::vector<Vec3>& vertices(AnyMesh& mesh) {
  return std::visit([](auto& m) -> std::vector<Vec3>& { return m.vertices; }, mesh);
}

double mean_length(const LineMesh& net) {
  double sum = 0.0;
  for (const auto& l : net.lines) sum += (net.vertices[l[0]] - net.vertices[l[1]]).norm();
  return sum / static_cast<double>(net.lines.size());
}

LineMesh edges_of(const TriMesh& mesh) { return {mesh.vertices, edges(mesh.triangles)}; }

class MassSpringMaker final : public BodyMaker {
 public:
  MassSpringMaker(const Node& n, const BuildContext& context) : node_(n), material_(context.material) {
    const double scale = n.at("transform").number("scale"), limit = context.world.memory_limit;
    if (n.has("shape") || n.has("tet_mesh")) {
      FilledSolid solid = read_filled(n, scale, limit);
      display_ = std::move(solid.display);
      volume_share_ = solid.volume_share;
      mesh_ = std::move(solid.mesh);
      return;
    }
    read_flat(n, scale, limit);
    const LineMesh lines =
        std::holds_alternative<LineMesh>(mesh_) ? std::get<LineMesh>(mesh_) : edges_of(std::get<TriMesh>(mesh_));
    const double voxel = n.number("voxel_size");
    thickness_ = n.number_if("thickness").value_or(0.0);
    if (thickness_ <= 0.0) thickness_ = voxel > 0.0 ? 2.0 * voxel : 0.25 * mean_length(lines);
    const double area = std::holds_alternative<TriMesh>(mesh_)
                            ? 2.0 * surface_area(std::get<TriMesh>(mesh_))
                            : 4.0 * thickness_ * mean_length(lines) * static_cast<double>(lines.lines.size());
    check_voxel_size(n, voxel > 0.0 ? voxel : 0.5 * thickness_, area, limit);
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    AnyMesh mesh = mesh_;
    for (Vec3& x : vertices(mesh)) x = place.position + place.rotation * x;
    MassSpringOptions options;
    options.density = volume_share_ * node_.number("density");
    options.stiffness = node_.number("stiffness");
    options.slack = node_.boolean("slack");
    options.thickness = thickness_;
    read_particle_options(node_, place, material_, options);
    options.self_contact = node_.boolean("self_contact");
    options.display = display_;
    for (Vec3& x : options.display.vertices) x = place.position + place.rotation * x;
    read_constraints(node_.at("constraints"), vertices(mesh), corners_, place.turned, options);
    return std::visit(
        [&](const auto& m) -> std::unique_ptr<Body> { return std::make_unique<MassSpringBody>(m, std::move(options)); },
        mesh);
  }

 private:
  /// A grid or a surface file, as a sheet of triangles or a net of lines.
  void read_flat(const Node& n, double scale, double limit) {
    const bool net = n.has("form") && n.string("form") == "net";
    if (n.has("grid")) {
      SheetGrid grid = read_sheet_grid(n.at("grid"), scale, kBytesPerSpringCell, limit);
      if (net)
        mesh_ = square_net(grid.nx, grid.ny, grid.lx, grid.ly);
      else
        mesh_ = shapes::grid(grid.nx, grid.ny, grid.lx, grid.ly);
      corners_ = std::move(grid.corners);
      return;
    }
    TriMesh surface = named_surface(n.at("mesh"));
    for (Vec3& x : surface.vertices) x *= scale;
    if (net)
      mesh_ = edges_of(surface);
    else
      mesh_ = std::move(surface);
  }

  Node node_;
  Material material_;
  AnyMesh mesh_;               ///< scaled, not placed
  TriMesh display_;            ///< likewise; of a solid; empty: the boundary of the mesh
  double volume_share_ = 1.0;  ///< of a solid (FilledSolid)
  std::vector<std::int32_t> corners_;
  double thickness_ = 0.01;  ///< [m] of a sheet or net
};

}  // namespace

BodyKind mass_spring_kind() {
  return {"mass_spring", check_mass_spring, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<MassSpringMaker>(n, c);
          }};
}

}  // namespace brim
