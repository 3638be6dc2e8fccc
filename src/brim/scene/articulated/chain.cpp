#include "brim/body/articulated/chain_model.h"
#include "brim/scene/articulated/trees.h"
#include "brim/scene/limits.h"

namespace brim {

ArticulatedModel read_chain(const Node& body, const BuildContext& context) {
  const Node n = body.at("chain");
  const double scale = body.at("transform").number("scale");
  ChainOptions o;
  o.links = static_cast<int>(n.integer("links"));
  o.length = scale * n.number("length");
  o.radius = scale * n.number("radius");
  o.density = n.number("density");
  o.joint = n.string("joint") == "ball" ? JointKind::Ball : JointKind::Revolute;
  o.axis = n.vec3("axis");
  o.alternate = n.boolean("alternate");
  o.floating = body.string("base") == "free";
  if (n.has("bend")) {
    o.each.upper = n.number("bend");
    if (o.joint == JointKind::Revolute) o.each.lower = -n.number("bend");
  }
  read_joint_actions(n, o.each);
  o.part.voxel_size = body.number("voxel_size");
  o.part.material = context.material;
  ArticulatedModel model = n.placed([&] { return chain_model(o); });
  const double area = 2.0 * 3.2 * o.radius * (o.length + 2.0 * o.radius) * o.links;
  check_voxel_size(body, model.links[0].shapes[0].part.voxel_size, area, context.world.memory_limit);
  // The first link leaves the base as it likes: the bend is between links.
  model.links[0].joint.upper = std::numeric_limits<double>::infinity();
  model.links[0].joint.lower = -std::numeric_limits<double>::infinity();
  return model;
}

}  // namespace brim
