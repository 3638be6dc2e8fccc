#include <limits>
#include <map>
#include <set>

#include "brim/scene/articulated/trees.h"
#include "brim/scene/motion.h"
#include "brim/scene/solid.h"
#include "brim/scene/validate.h"

namespace brim {

namespace {

JointKind joint_kind(const std::string& word) {
  if (word == "revolute") return JointKind::Revolute;
  if (word == "prismatic") return JointKind::Prismatic;
  if (word == "ball") return JointKind::Ball;
  return JointKind::Fixed;
}

void check_joint(const Node& n) {
  const std::string kind = n.string("kind");
  const auto only = [&](const char* key, bool allowed, const char* whose) {
    if (n.has(key) && !allowed) throw n.at(key).error(fmt::format("a {} joint has none; only {}", kind, whose));
  };
  const bool one = kind == "revolute" || kind == "prismatic";
  only("lower", one, "revolute and prismatic joints do");
  only("upper", kind != "fixed", "joints that move do");
  only("start_rotation", kind == "ball", "ball joints do");
  only("drive", kind != "fixed", "joints that move do");
  if (one && n.vec3("axis") == Vec3::Zero()) throw n.at("axis").error("[0, 0, 0] is no direction");
  if (n.has("lower") && n.has("upper") && n.number("lower") > n.number("upper"))
    throw n.at("lower").error(
        fmt::format("{} is not allowed; must be at most \"upper\", {}", n.number("lower"), n.number("upper")));
  // A joint that names no start has 0, wherever its limits are.
  if (one && n.number("start") != 0.0)
    need_start_within(n, n.has("lower") ? n.number("lower") : -std::numeric_limits<double>::infinity(),
                      n.has("upper") ? n.number("upper") : std::numeric_limits<double>::infinity());
  if (kind == "ball" && n.has("upper") && !(n.number("upper") > 0.0))
    throw n.at("upper").error(
        fmt::format("{} is not allowed; the largest angle of a ball joint must be above 0", n.number("upper")));
  if (n.has("rotation")) read_rotation(n.at("rotation"));
  if (n.has("start_rotation")) read_rotation(n.at("start_rotation"));
}

/// Mass, centre, inertia and the solid of one link.
void read_matter(const Node& n, double scale, const Node& body, const BuildContext& context, LinkModel& link) {
  if (!n.has("shape")) return;
  const Node place = n.at("transform");
  const double voxel = n.number("voxel_size") > 0.0 ? n.number("voxel_size") : body.number("voxel_size");
  Solid solid =
      read_solid(n.at("shape"), n, scale * place.number("scale"), voxel, context.world.memory_limit, context.solids);
  const double density = n.has("density") ? n.number("density") : 1000.0;
  link.mass = n.has("mass") ? n.number("mass") : density * solid.unit.mass;
  LinkShape s;
  s.pose.translation = scale * place.vec3("position");
  if (place.has("rotation")) s.pose.rotation = read_rotation(place.at("rotation")).toRotationMatrix();
  link.center_of_mass = s.pose.translation + s.pose.rotation * solid.unit.center;
  link.inertia = link.mass / solid.unit.mass * (s.pose.rotation * solid.unit.inertia * s.pose.rotation.transpose());
  s.shape = solid.shape;
  s.surface = std::move(solid.surface);
  s.part.voxel_size = solid.voxel_size;
  s.part.areal_mass = 6.0 * link.mass / solid.area;
  s.part.thickness = s.shape->thickness();
  s.part.width = width_of(solid.unit.volume, s.part.thickness, s.shape->bounds());
  s.part.material = context.material;
  link.shapes.push_back(std::move(s));
}

/// @throws InputError  for a drive that cannot reach what it aims at
void need_gains(const Node& d) {
  const bool stiff = d.number("stiffness") > 0.0, damped = d.number("damping") > 0.0;
  const auto refuse = [&](const char* key, const char* gain) {
    return d.error(fmt::format(
        "the drive has \"{}\" but no {} above 0; force = stiffness (target - q) + damping (target_velocity - "
        "q'), so nothing drives the joint there",
        key, gain));
  };
  if (d.has("keyframes") && !stiff && !damped) throw refuse("keyframes", "\"stiffness\" or \"damping\"");
  // An aim at zero is one too, where nothing drives the joint at all.
  const auto aims = [&](const char* key) { return d.has(key) && (d.number(key) != 0.0 || (!stiff && !damped)); };
  if (aims("target") && !stiff) throw refuse("target", "\"stiffness\"");
  if (aims("target_velocity") && !damped) throw refuse("target_velocity", "\"damping\"");
}

JointModel read_joint(const Node& n, double scale) {
  JointModel j;
  j.kind = joint_kind(n.string("kind"));
  j.position = scale * n.vec3("position");
  if (n.has("rotation")) j.rotation = read_rotation(n.at("rotation"));
  j.axis = n.vec3("axis");
  if (n.has("lower")) j.lower = n.number("lower");
  if (n.has("upper")) j.upper = n.number("upper");
  j.start = n.number("start");
  j.start_velocity = n.number("start_velocity");
  if (n.has("start_rotation")) j.start_rotation = read_rotation(n.at("start_rotation"));
  read_joint_actions(n, j);
  return j;
}

}  // namespace

void check_links(const Node& body) {
  const Node links = body.at("links");
  const bool free = body.string("base") == "free";
  std::set<std::string> names;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Node n = links.at(i);
    if (n.has("parent") && !names.contains(n.string("parent"))) {
      const std::string near = nearest_word(n.string("parent"), names);
      throw n.at("parent").error(fmt::format("\"{}\" is not an earlier link{}", n.string("parent"),
                                             near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
    }
    if (!names.insert(n.string("name")).second)
      throw n.at("name").error(fmt::format("\"{}\" is already the name of a link", n.string("name")));
    if (free && i == 0 && n.at("joint").string("kind") != "fixed")
      throw n.at("joint").error("the first link of a free base has no joint");
    if (free && i > 0 && !n.has("parent"))
      throw n.error("the key \"parent\" is missing; only the first link of a free base has none");
    check_joint(n.at("joint"));
    if (n.has("density") && n.has("mass"))
      throw n.at("mass").error("both \"mass\" and \"density\" are given; give one");
    if (!n.has("shape")) {
      for (const char* key : {"density", "mass"})
        if (n.has(key)) throw n.at(key).error("a link without a shape has no mass");
      continue;
    }
    refuse_plane(n.at("shape"), "mass");
    check_shape(n.at("shape"));
  }
}

ArticulatedModel read_links(const Node& body, const BuildContext& context) {
  const Node links = body.at("links");
  const double scale = body.at("transform").number("scale");
  ArticulatedModel model;
  std::map<std::string, int> number;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Node n = links.at(i);
    LinkModel link;
    link.name = n.string("name");
    if (n.has("parent")) link.parent = number.at(n.string("parent"));
    link.joint = read_joint(n.at("joint"), scale);
    link.joint.name = link.name;
    if (i == 0 && body.string("base") == "free") link.joint.kind = JointKind::Free;
    read_matter(n, scale, body, context, link);
    number[link.name] = static_cast<int>(i);
    model.links.push_back(std::move(link));
  }
  return model;
}

void read_joint_actions(const Node& n, JointModel& j) {
  const auto set = [&](const char* key, double& value) {
    if (n.has(key)) value = n.number(key);
  };
  set("limit_stiffness", j.limit_stiffness);
  set("damping", j.damping);
  set("friction", j.friction);
  set("armature", j.armature);
  if (!n.has("drive")) return;
  const Node d = n.at("drive");
  j.drive.stiffness = d.number("stiffness");
  j.drive.damping = d.number("damping");
  if (d.has("force_limit")) j.drive.force_limit = d.number("force_limit");
  if (d.has("target")) j.drive.target = d.number("target");
  if (d.has("target_velocity")) j.drive.target_velocity = d.number("target_velocity");
  need_gains(d);
  if (!d.has("keyframes")) return;
  const Node keys = d.at("keyframes");
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Node k = keys.at(i);
    if (i > 0 && !(k.number("time") > j.drive.keys.back().time))
      throw k.at("time").error(fmt::format("{} s is not allowed; times must increase, the one before is {}",
                                           k.number("time"), j.drive.keys.back().time));
    j.drive.keys.push_back({k.number("time"), k.number("target")});
  }
}

void need_start_within(const Node& joint, double lower, double upper) {
  const double start = joint.number("start");
  if (start >= lower && start <= upper) return;
  throw joint.at("start").error(
      fmt::format("{} is not allowed; must be within the limits of the joint, from {} to {}", start, lower, upper));
}

int find_link(const ArticulatedModel& model, const Node& name) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    if (model.links[i].name == name.string()) return static_cast<int>(i);
    names.insert(model.links[i].name);
  }
  const std::string near = nearest_word(name.string(), names);
  throw name.error(fmt::format("\"{}\" is not a link of this body{}", name.string(),
                               near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
}

}  // namespace brim
