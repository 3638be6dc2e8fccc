#include <set>

#include "brim/io/surface_reader.h"
#include "brim/io/urdf_reader.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/topology.h"
#include "brim/scene/articulated/trees.h"
#include "brim/scene/limits.h"
#include "brim/scene/solid_store.h"
#include "brim/scene/validate.h"

namespace brim {

namespace {

/// The solid of a piece of collision geometry.
Solid make_solid(const Urdf::Geometry& g, const Node& body, const BuildContext& context) {
  const double limit = context.world.memory_limit;
  Solid s;
  SolidSurface source;
  switch (g.kind) {
    case Urdf::Geometry::Kind::Box:
      s.shape = make_box(g.size), s.surface = shapes::box(g.size);
      break;
    case Urdf::Geometry::Kind::Cylinder:
      s.shape = make_cylinder(g.radius, g.length), s.surface = shapes::cylinder(g.radius, g.length);
      break;
    case Urdf::Geometry::Kind::Sphere:
      s.shape = make_sphere(g.radius), s.surface = shapes::icosphere(g.radius);
      break;
    case Urdf::Geometry::Kind::Mesh:
      source.mesh = read_surface(g.mesh);
      for (Vec3& x : source.mesh.vertices) x = x.cwiseProduct(g.scale);
      s.surface = source.mesh;
      break;
  }
  const Aabb box = bounds(s.surface->vertices);
  s.area = surface_area(s.surface);
  s.voxel_size = body.number("voxel_size") > 0.0 ? body.number("voxel_size") : 0.125 * box.extent().minCoeff();
  check_voxel_size(body, s.voxel_size, s.area, limit);
  if (s.shape) return s;
  const MeshReport report = inspect(source.mesh);
  const bool closed = report.closed() && report.oriented() && report.volume > 0.0;
  source.treatment = closed ? SurfaceTreatment::Closed : SurfaceTreatment::WindingNumber;
  context.solids.make(source, limit, s);
  return s;
}

JointModel make_joint(const Urdf::Joint& u) {
  JointModel j;
  j.name = u.name;
  j.kind = u.kind == Urdf::Joint::Kind::Revolute    ? JointKind::Revolute
           : u.kind == Urdf::Joint::Kind::Prismatic ? JointKind::Prismatic
                                                    : JointKind::Fixed;
  j.position = u.position, j.rotation = u.rotation, j.axis = u.axis;
  j.lower = u.lower, j.upper = u.upper;
  j.damping = u.damping, j.friction = u.friction;
  j.drive.force_limit = u.effort;
  return j;
}

/// Applies one entry of "joints".
void change_joint(const Node& n, ArticulatedModel& model) {
  std::set<std::string> names;
  for (LinkModel& l : model.links) {
    if (l.joint.name.empty()) continue;
    names.insert(l.joint.name);
    if (l.joint.name != n.string("joint")) continue;
    if (l.joint.kind == JointKind::Fixed)
      throw n.at("joint").error(fmt::format("joint \"{}\" is fixed; nothing in it can change", l.joint.name));
    if (n.has("start")) {
      need_start_within(n, l.joint.lower, l.joint.upper);
      l.joint.start = n.number("start");
    }
    if (n.has("start_velocity")) l.joint.start_velocity = n.number("start_velocity");
    read_joint_actions(n, l.joint);
    return;
  }
  const std::string near = nearest_word(n.string("joint"), names);
  throw n.at("joint").error(fmt::format("\"{}\" is not a joint of the file{}", n.string("joint"),
                                        near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
}

}  // namespace

ArticulatedModel read_urdf_tree(const Node& body, const BuildContext& context) {
  const Node at = body.at("urdf"), changes = body.at("joints");
  if (body.at("transform").number("scale") != 1.0)
    throw body.at("transform").at("scale").error("a URDF file has lengths and masses of its own; scale must be 1");
  const std::string path = scene_path(at);
  const Urdf urdf = at.placed([&] { return read_urdf(path); });
  ArticulatedModel model;
  for (const Urdf::Piece& piece : urdf.pieces) {
    LinkModel l;
    l.name = piece.link.name;
    l.parent = piece.parent;
    l.joint = make_joint(piece.joint);
    l.mass = piece.link.mass, l.center_of_mass = piece.link.center_of_mass, l.inertia = piece.link.inertia;
    for (const Urdf::Geometry& g : piece.link.collision) {
      Solid solid = at.placed([&] { return make_solid(g, body, context); });
      LinkShape s{solid.shape, {g.rotation.toRotationMatrix(), g.position}, std::move(solid.surface), {}};
      s.part.voxel_size = solid.voxel_size;
      s.part.areal_mass = 6.0 * l.mass / static_cast<double>(piece.link.collision.size()) / solid.area;
      s.part.thickness = solid.shape->thickness();
      s.part.width = width_of(solid.unit.volume, s.part.thickness, solid.shape->bounds());
      s.part.material = context.material;
      l.shapes.push_back(std::move(s));
    }
    model.links.push_back(std::move(l));
  }
  if (body.string("base") == "free") model.links[0].joint.kind = JointKind::Free;
  for (std::size_t i = 0; i < changes.size(); ++i) change_joint(changes.at(i), model);
  return model;
}

}  // namespace brim
