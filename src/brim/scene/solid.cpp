#include "brim/scene/solid.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "brim/mesh/flat_surface.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/topology.h"
#include "brim/scene/exact_solid.h"
#include "brim/scene/given_arrays.h"
#include "brim/scene/limits.h"
#include "brim/scene/solid_store.h"

namespace brim {

namespace {

/// Sides of a bowl's circles: facets so flat that what rolls in it does not feel them.
constexpr int kBowlSides = 128;

SurfaceTreatment treatment_of(const std::string& word) {
  if (word == "winding_number") return SurfaceTreatment::WindingNumber;
  if (word == "thickness") return SurfaceTreatment::Thickness;
  return SurfaceTreatment::Closed;
}

/// Square for viewers of a half space.
TriMesh plane_surface(double side) {
  const double a = 0.5 * side;
  return {{{-a, -a, 0}, {a, -a, 0}, {a, a, 0}, {-a, a, 0}}, {{0, 1, 2}, {0, 2, 3}}};
}

SolidSurface read_file(const Node& n, double scale) {
  SolidSurface s;
  s.mesh = named_surface(n.at("file"));
  s.treatment = treatment_of(n.string("treatment"));
  if (s.treatment == SurfaceTreatment::Thickness) s.thickness = n.number("thickness") * scale;
  if (n.string("up") == "y")
    for (Vec3& x : s.mesh.vertices) x = Vec3(x.x(), -x.z(), x.y());
  Aabb box = bounds(s.mesh.vertices);
  if (n.boolean("center"))
    for (Vec3& x : s.mesh.vertices) x -= box.center();
  double factor = scale;
  if (const auto fit = n.number_if("fit")) factor *= *fit / box.extent().maxCoeff();
  for (Vec3& x : s.mesh.vertices) x *= factor;
  if (s.treatment == SurfaceTreatment::WindingNumber && is_flat(s.mesh))
    throw n.at("file").error(
        fmt::format("{} is flat and encloses nothing; treatment \"winding_number\" needs a surface around something, "
                    "\"thickness\" makes a solid of a sheet",
                    n.string("file")));
  const MeshReport report = inspect(s.mesh);
  if (s.treatment == SurfaceTreatment::Closed && !(report.closed() && report.oriented() && report.volume > 0.0))
    throw n.at("file").error(fmt::format(
        "{} is not a closed surface ({}); treatment \"closed\" needs one, \"winding_number\" or \"thickness\" take any",
        n.string("file"), report.summary()));
  return s;
}

}  // namespace

std::string scene_path(const Node& n) {
  std::string path = n.string();
  for (std::size_t at; (at = path.find("${")) != std::string::npos;) {
    const std::size_t end = path.find('}', at);
    if (end == std::string::npos) throw n.error(fmt::format("\"{}\": a variable is written ${{NAME}}", path));
    const std::string name = path.substr(at + 2, end - at - 2);
    const char* value = std::getenv(name.c_str());
    if (!value)
      throw n.error(fmt::format("\"{}\": the environment variable {} is not set; set it to a folder, or write the path",
                                n.string(), name));
    path = path.substr(0, at) + value + path.substr(end + 1);
  }
  namespace fs = std::filesystem;
  fs::path full(path);
  if (full.is_relative()) full = fs::path(n.document().file).parent_path() / full;
  std::error_code error;
  if (!fs::exists(full, error)) throw n.error(fmt::format("\"{}\": no such file ({})", n.string(), full.string()));
  return full.string();
}

void refuse_plane(const Node& n, const char* lacks) {
  if (n.string("kind") == "plane")
    throw n.at("kind").error(fmt::format("\"plane\" has no finite {}; only an obstacle can be one", lacks));
}

void check_shape(const Node& n) {
  const std::string kind = n.string("kind");
  const auto below = [&](const char* small, const char* large) {
    if (n.number(small) >= n.number(large))
      throw n.at(small).error(fmt::format("{} is not allowed; must be below \"{}\", {}", shown(n.at(small).json()),
                                          large, shown(n.at(large).json())));
  };
  if (kind == "torus") below("tube", "radius");
  if (kind == "gear") {
    below("root", "outer");
    below("bore", "root");
  }
  if (kind == "star") below("inner", "outer");
  if (kind == "bowl" || kind == "cup") below("thickness", "radius");
  if (kind == "cup") below("thickness", "height");
  if (kind == "u_profile") {
    below("thickness", "height");
    if (2.0 * n.number("thickness") >= n.number("outer"))
      throw n.at("thickness")
          .error(fmt::format("{} is not allowed; must be below half of \"outer\", {}", n.number("thickness"),
                             0.5 * n.number("outer")));
  }
  if (kind == "l_profile") {
    below("width", "leg_x");
    below("width", "leg_y");
  }
  if (kind == "mesh") {
    const bool sheet = n.string("treatment") == "thickness";
    if (sheet && !n.has("thickness"))
      throw n.error("the key \"thickness\" is missing; treatment \"thickness\" needs it, in metres");
    if (!sheet && n.has("thickness"))
      throw n.at("thickness")
          .error(
              fmt::format("only treatment \"thickness\" has one; the treatment here is \"{}\"", n.string("treatment")));
  }
}

SolidSurface read_surface_of(const Node& n, double s) {
  const std::string kind = n.string("kind");
  const auto length = [&](const char* key) { return s * n.number(key); };
  const auto count = [&](const char* key) { return static_cast<int>(n.integer(key)); };
  if (kind == "mesh") return read_file(n, s);
  return n.placed([&]() -> SolidSurface {
    if (kind == "plane") return {plane_surface(length("display_size"))};
    if (kind == "box") return {shapes::box(s * n.vec3("size"))};
    if (kind == "sphere") return {shapes::icosphere(length("radius"))};
    if (kind == "capsule") return {shapes::capsule(length("radius"), length("length"))};
    if (kind == "cylinder") return {shapes::cylinder(length("radius"), length("length"))};
    if (kind == "torus") return {shapes::torus(length("radius"), length("tube"))};
    if (kind == "gear")
      return {shapes::gear(count("teeth"), length("outer"), length("root"), length("thickness"), length("bore"))};
    if (kind == "star") return {shapes::star(count("points"), length("outer"), length("inner"), length("thickness"))};
    if (kind == "blob") return {shapes::blob(static_cast<std::uint64_t>(n.integer("seed")), length("radius"))};
    if (kind == "bowl") return {shapes::bowl(length("radius"), length("thickness"), kBowlSides)};
    if (kind == "cup") return {shapes::cup(length("radius"), length("height"), length("thickness"))};
    if (kind == "l_profile")
      return {shapes::l_profile(length("leg_x"), length("leg_y"), length("width"), length("length"))};
    if (kind == "u_profile")
      return {shapes::u_profile(length("outer"), length("height"), length("thickness"), length("length"))};
    throw ProgrammingError("shape kind without a builder: " + kind);
  });
}

Solid read_solid(const Node& body, double memory_limit, SolidStore& store) {
  return read_solid(body.at("shape"), body, body.at("transform").number("scale"), body.number("voxel_size"),
                    memory_limit, store);
}

Solid read_solid(const Node& n, const Node& at, double scale, double voxel_size, double memory_limit,
                 SolidStore& store) {
  SolidSurface source = read_surface_of(n, scale);
  Solid solid;
  solid.area = surface_area(source.mesh);
  if (auto exact = exact_solid(n, scale)) {
    solid.shape = std::move(exact->shape);
    if (exact->area > 0.0) solid.area = exact->area;
    solid.unit = exact->unit;
  }
  const bool plane = n.string("kind") == "plane";
  const Aabb box = bounds(source.mesh.vertices);
  solid.voxel_size = voxel_size > 0.0 ? voxel_size : plane ? 1.0 : 0.125 * box.extent().minCoeff();
  if (source.treatment == SurfaceTreatment::Thickness && voxel_size <= 0.0) solid.voxel_size = 0.5 * source.thickness;
  if (!plane) check_voxel_size(at, solid.voxel_size, solid.area, memory_limit);
  if (!solid.shape) {
    n.placed([&] { store.make(source, memory_limit, solid); });
  } else if (solid.unit.mass == 0.0 && !plane) {
    solid.unit = mass_properties(source.mesh, 1.0);
  }
  solid.surface = std::move(source.mesh);
  return solid;
}

}  // namespace brim
