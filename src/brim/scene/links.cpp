#include "brim/scene/links.h"

#include <algorithm>
#include <set>

#include "brim/scene/articulated/trees.h"
#include "brim/scene/constraints.h"
#include "brim/scene/motion.h"
#include "brim/scene/sensors.h"
#include "brim/scene/validate.h"
#include "brim/scene/wind_field.h"
#include "brim/world/world.h"

namespace brim {

namespace {

/// The names that a side of a filter stands for.
std::vector<std::string> names_of(const std::string& word, const Json* groups) {
  if (groups != nullptr && groups->contains(word)) return groups->at(word).get<std::vector<std::string>>();
  return {word};
}

/// Offset and turn about the middle over time.
std::function<Vec3(double, const Vec3&, const Vec3&)> target_motion(const Node& keyframes) {
  return [keys = read_motion(keyframes)](double time, const Vec3& x, const Vec3& middle) -> Vec3 {
    const MotionKey k = at_time(keys, time);
    return middle + k.offset + k.rotation * (x - middle);
  };
}

void check_names_differ(const Node& list) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string name = list.at(i).string("name");
    if (std::find(names.begin(), names.end(), name) != names.end())
      throw list.at(i).at("name").error(fmt::format("\"{}\" is given twice; names must be unique", name));
    names.push_back(name);
  }
}

/// Throws when `word`, a name or a pattern of names at `n`, stands for no body of the world.
void need_bodies(const Node& n, const std::string& word, const Json& groups, const World& world) {
  std::set<std::string> known;
  for (int b = 0; b < world.body_count(); ++b) {
    const std::string& name = world.body(b).name();
    if (name_matches(word, name)) return;
    known.insert(name);
    // The stem of a numbered copy.
    if (const auto dot = name.rfind('.'); dot != std::string::npos && name_matches(name.substr(0, dot), name))
      known.insert(name.substr(0, dot));
  }
  if (word.find_first_of("*?") != std::string::npos)
    throw n.error(fmt::format("\"{}\" is not allowed; must match the name of a body, and no body's does", word));
  for (const auto& [name, unused] : groups.items()) known.insert(name);
  const std::string near = nearest_word(word, known);
  throw n.error(fmt::format("\"{}\" is not a body; must be a body, the stem of numbered copies, a pattern or a group{}",
                            word, near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
}

}  // namespace

void check_filter_names(const Node& filter, const Node& root, const World& world) {
  const Json none = Json::object();
  const Json& groups = root.has("groups") ? root.at("groups").json() : none;
  for (const std::size_t side : {0, 1}) {
    const Node n = filter.at("between").at(side);
    const std::string word = n.string();
    if (!groups.contains(word)) {
      need_bodies(n, word, groups, world);
      continue;
    }
    const Node members = root.at("groups").at(word.c_str());
    for (std::size_t i = 0; i < members.size(); ++i) need_bodies(members.at(i), members.at(i).string(), none, world);
  }
}

std::vector<TouchRule> read_filter(const Node& filter, const Json* groups) {
  std::vector<TouchRule> rules;
  const Node between = filter.at("between");
  TouchRule rule;
  rule.touch = filter.boolean("touch");
  if (filter.has("region")) rule.region_a = read_region(filter.at("region"));
  if (filter.has("to_region")) rule.region_b = read_region(filter.at("to_region"));
  for (const std::string& a : names_of(between.at(std::size_t{0}).string(), groups))
    for (const std::string& b : names_of(between.at(std::size_t{1}).string(), groups)) {
      rule.a = a, rule.b = b;
      rules.push_back(rule);
    }
  return rules;
}

/// What attachments and joints have in common.
Attachment read_sides(const Node& n) {
  Attachment a;
  a.name = n.string("name");
  a.body = n.string("body");
  if (n.has("to")) a.to = n.string("to");
  if (n.has("part")) a.part = static_cast<int>(n.integer("part"));
  if (n.has("to_part")) a.to_part = static_cast<int>(n.integer("to_part"));
  if (n.has("break_force")) a.break_force = n.number("break_force");
  a.touch = n.boolean("touch");
  return a;
}

Attachment read_attachment(const Node& n) {
  Attachment a = read_sides(n);
  if (n.has("point") == n.has("region")) throw n.error("give either \"point\" or \"region\": what of the body is held");
  if (n.has("point")) a.point = n.vec3("point");
  if (n.has("region")) a.region = read_region(n.at("region"));
  if (n.has("to_point")) a.to_point = n.vec3("to_point");
  if (n.has("region") && n.has("to_point"))
    throw n.at("to_point").error("it is not allowed beside \"region\"; a region is held where it is");
  if (n.has("keyframes")) {
    if (n.has("to")) throw n.at("keyframes").error("they are not allowed beside \"to\"; they move a place in space");
    check_key_times(n.at("keyframes"));
    a.motion = target_motion(n.at("keyframes"));
  }
  a.stiffness = n.number("stiffness");
  a.damping = n.number("damping");
  if (n.has("length")) a.length = n.number("length");
  a.pulls_only = n.boolean("pulls_only");
  return a;
}

Attachment read_joint(const Node& n) {
  Attachment a = read_sides(n);
  LinkJoint j;
  const std::string kind = n.string("kind");
  j.kind = kind == "fixed"      ? JointKind::Fixed
           : kind == "revolute" ? JointKind::Revolute
           : kind == "ball"     ? JointKind::Ball
                                : JointKind::Prismatic;
  j.position = n.vec3("position");
  j.axis = n.vec3("axis");
  if (!(j.axis.norm() > 1e-12)) throw n.at("axis").error("[0,0,0] is not allowed; must be a direction of some length");
  j.span = n.number("span");
  if (n.has("lower")) j.lower = n.number("lower");
  if (n.has("upper")) j.upper = n.number("upper");
  if (j.lower > j.upper) throw n.at("lower").error(fmt::format("{} is above \"upper\", {}", j.lower, j.upper));
  const bool turns = j.kind == JointKind::Revolute, slides = j.kind == JointKind::Prismatic;
  for (const char* key : {"lower", "upper", "drive"})
    if (n.has(key) && !turns && !slides) throw n.at(key).error("it is for revolute and prismatic joints");
  JointModel actions;
  read_joint_actions(n, actions);
  j.limit_stiffness = actions.limit_stiffness;
  j.damping = actions.damping;
  j.drive = actions.drive;
  if (j.damping > 0.0 && !turns && !slides) throw n.at("damping").error("it is for revolute and prismatic joints");
  a.joint = j;
  return a;
}

AppliedForce read_force(const Node& n) {
  AppliedForce f;
  f.name = n.string("name");
  for (std::size_t i = 0; i < n.at("bodies").size(); ++i) f.bodies.push_back(n.at("bodies").at(i).string());
  f.force = n.vec3("force");
  f.torque = n.vec3("torque");
  f.acceleration = n.vec3("acceleration");
  f.gravity_scale = n.number_if("gravity_scale");
  f.damping = n.number("damping");
  if (n.has("point") && n.has("region")) throw n.error("give \"point\" or \"region\", not both");
  if (n.has("point")) f.point = n.vec3("point");
  if (n.has("region")) f.region = read_region(n.at("region"));
  if (n.has("wind")) {
    const Node w = n.at("wind");
    f.wind = AppliedForce::Wind{w.vec3("velocity"), w.number("density"), w.number("drag"), w.number("lift")};
    if (w.has("field")) f.wind->field = read_wind_field(w.at("field"));
  }
  if (n.has("attractor")) {
    const Node a = n.at("attractor");
    f.attractor = AppliedForce::Attractor{a.vec3("center"), a.number("strength"), a.number("range"), a.number("power")};
  }
  const Node scale = n.at("scale");
  for (std::size_t k = 0; k < scale.size(); ++k) {
    f.scale.push_back({scale.at(k).number("time"), scale.at(k).number("value")});
    if (k > 0 && f.scale[k].time <= f.scale[k - 1].time)
      throw scale.at(k).at("time").error("times must increase from key to key");
  }
  return f;
}

std::vector<TouchRule> read_filters(const Node& root) {
  std::vector<TouchRule> rules;
  const Json& groups = root.at("groups").json();
  for (std::size_t i = 0; i < root.at("filters").size(); ++i) {
    const auto more = read_filter(root.at("filters").at(i), &groups);
    rules.insert(rules.end(), more.begin(), more.end());
    if (rules.size() > TouchRules::kMost)
      throw root.at("filters").error(
          fmt::format("{} pairs of names with entry {}; at most {} are allowed", rules.size(), i, TouchRules::kMost));
  }
  return rules;
}

void check_wiring(const Node& root) {
  for (const char* list : {"attachments", "joints", "forces"}) check_names_differ(root.at(list));
  for (std::size_t i = 0; i < root.at("joints").size(); ++i) read_joint(root.at("joints").at(i));
  for (std::size_t i = 0; i < root.at("attachments").size(); ++i) read_attachment(root.at("attachments").at(i));
  for (std::size_t i = 0; i < root.at("forces").size(); ++i) read_force(root.at("forces").at(i));
}

void wire_up(const Node& root, World& world) {
  for (std::size_t i = 0; i < root.at("attachments").size(); ++i) {
    const Node n = root.at("attachments").at(i);
    n.placed([&] { world.attach(read_attachment(n)); });
  }
  for (std::size_t i = 0; i < root.at("joints").size(); ++i) {
    const Node n = root.at("joints").at(i);
    n.placed([&] { world.attach(read_joint(n)); });
  }
  for (std::size_t i = 0; i < root.at("forces").size(); ++i) {
    const Node n = root.at("forces").at(i);
    n.placed([&] { world.apply(read_force(n)); });
  }
  add_sensors(root, world);
  for (std::size_t i = 0; i < root.at("filters").size(); ++i) check_filter_names(root.at("filters").at(i), root, world);
  // What a filter's region cannot be about is said now, and not by the first step.
  for (std::size_t i = 0; i < root.at("filters").size(); ++i)
    if (const Node n = root.at("filters").at(i); n.has("region") || n.has("to_region"))
      n.placed([&] { static_cast<void>(world.stiffness()); });
}

}  // namespace brim
