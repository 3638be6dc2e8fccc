#include "brim/body/articulated/chain_model.h"

#include <numbers>

#include "brim/core/error.h"
#include "brim/mesh/primitives.h"

namespace brim {

ArticulatedModel chain_model(const ChainOptions& o) {
  if (o.links < 1) throw InputError(fmt::format("chain: {} links, but at least 1 is needed", o.links));
  if (!(o.radius > 0.0) || !(o.radius < 0.5 * o.length))
    throw InputError(fmt::format("chain: radius {} must be above 0 and below half of the links' length, {}", o.radius,
                                 0.5 * o.length));
  if (o.joint != JointKind::Ball && o.joint != JointKind::Revolute)
    throw InputError("chain: the joints must be ball or revolute");
  // Rounded ends meet at the joints, so that a bent chain has no gaps.
  const double r = o.radius, straight = o.length, pi = std::numbers::pi;
  const double tube = pi * r * r * straight, caps = 4.0 / 3.0 * pi * r * r * r, mass = o.density * (tube + caps);
  const double end = 0.5 * straight + 0.375 * r;  // centres of mass of the half balls
  const double along = o.density * (0.5 * tube * r * r + 0.4 * caps * r * r);
  const double across = o.density * (tube * (3.0 * r * r + straight * straight) / 12.0 +
                                     caps * (0.4 - 9.0 / 64.0) * r * r + caps * end * end);
  const auto shape = make_capsule(r, straight);
  const TriMesh surface = shapes::capsule(r, straight, 16);  // there are many
  const Mat3 along_x = Eigen::AngleAxisd(0.5 * pi, Vec3::UnitY()).toRotationMatrix();

  ArticulatedModel model;
  for (int i = 0; i < o.links; ++i) {
    LinkModel l;
    l.name = std::to_string(i);
    l.parent = i - 1;
    l.joint = o.each;
    l.joint.kind = o.joint;
    l.joint.axis = o.axis;
    l.joint.rotation = Quat::Identity();
    if (o.alternate && i % 2 == 1) l.joint.axis = Eigen::AngleAxisd(0.5 * pi, Vec3::UnitX()) * o.axis;
    l.joint.position = Vec3(straight, 0, 0);
    if (i == 0) {
      if (o.floating) l.joint = JointModel{};
      if (o.floating) l.joint.kind = JointKind::Free;
      l.joint.position = o.position, l.joint.rotation = o.rotation;
      l.joint.velocity = o.velocity;
      l.joint.angular_velocity = o.floating ? o.angular_velocity : o.each.angular_velocity;
    }
    l.mass = mass;
    l.center_of_mass = Vec3(0.5 * straight, 0, 0);
    l.inertia = Vec3(along, across, across).asDiagonal();
    LinkShape s{shape, {along_x, l.center_of_mass}, surface, o.part};
    s.part.areal_mass = 6.0 * mass / (2.0 * pi * r * straight + 4.0 * pi * r * r);
    s.part.thickness = s.part.width = shape->thickness();
    if (!(s.part.voxel_size > 0.0)) s.part.voxel_size = 0.25 * r;
    l.shapes.push_back(std::move(s));
    model.links.push_back(std::move(l));
  }
  return model;
}

}  // namespace brim
