#include "brim/scene/timeline.h"

#include <algorithm>
#include <array>
#include <functional>
#include <string_view>
#include <vector>

#include "brim/body/movable.h"
#include "brim/scene/motion.h"
#include "brim/scene/scene.h"
#include "brim/world/attachment.h"
#include "brim/world/body_motion.h"
#include "brim/world/touch_rules.h"
#include "brim/world/world.h"

namespace brim {

namespace {

/// What an entry may do; exactly one of them is its verb.
constexpr std::array<const char*, 12> kVerbs = {"freeze",    "thaw",    "remove",       "move",
                                                "detach",    "gravity", "set_velocity", "set_material",
                                                "set_drive", "grab",    "pull",         "release"};
/// Keys that say more about one verb.
struct Detail {
  const char* key;
  std::string_view verb;
};
constexpr std::array<Detail, 11> kDetails = {{{"offset", "move"},
                                              {"joint", "set_drive"},
                                              {"target", "set_drive"},
                                              {"target_velocity", "set_drive"},
                                              {"rotation", "move"},
                                              {"velocity", "set_velocity"},
                                              {"angular_velocity", "set_velocity"},
                                              {"material", "set_material"},
                                              {"point", "grab"},
                                              {"stiffness", "grab"},
                                              {"damping", "grab"}}};

std::string verb_of(const Node& entry) {
  std::string verb, all;
  for (const char* v : kVerbs) {
    all += (all.empty() ? "\"" : ", \"") + std::string(v) + "\"";
    if (!entry.has(v)) continue;
    if (!verb.empty())
      throw entry.at(v).error(fmt::format("it is not allowed beside \"{}\"; an entry is one edit", verb));
    verb = v;
  }
  if (verb.empty()) throw entry.error("says nothing to do; it must have one of " + all);
  for (const Detail& d : kDetails)
    if (entry.has(d.key) && d.verb != verb)
      throw entry.at(d.key).error(fmt::format("it is not allowed beside \"{}\"; it is for \"{}\"", verb, d.verb));
  return verb;
}

Vec3 vector_or_zero(const Node& entry, const char* key) {
  return entry.has(key) ? entry.vec3(key) : Vec3(Vec3::Zero());
}

/// Numbers of what the name means.
std::vector<int> bodies_of(const Node& name, const World& world) {
  std::vector<int> numbers;
  for (int b = 0; b < world.body_count(); ++b)
    if (name_matches(name.string(), world.body(b).name())) numbers.push_back(b);
  if (numbers.empty()) throw name.error(fmt::format("\"{}\" is not a body", name.string()));
  return numbers;
}

void need_movable(const Node& name, const std::string& verb, const Body& body, const Mat3& R) {
  const auto* movable = dynamic_cast<const Movable*>(&body);
  if (movable != nullptr && movable->driven())
    throw name.error(fmt::format("\"{}\" follows keyframes; it cannot be changed by \"{}\"", body.name(), verb));
  if (verb != "move") return;
  if (const std::string why = refuses_move(body, R); !why.empty())
    throw name.error(fmt::format("\"{}\" {}", body.name(), why));
}

Mat3 rotation_of(const Node& entry) {
  return entry.has("rotation") ? read_rotation(entry.at("rotation")).toRotationMatrix() : Mat3::Identity();
}

/// The edit of one body.
std::function<void(World&, int)> edit_of(const Node& entry, const std::string& verb, const Scene& scene) {
  if (verb == "freeze") return [](World& w, int b) { w.freeze(b); };
  if (verb == "thaw") return [](World& w, int b) { w.freeze(b, false); };
  if (verb == "remove") return [](World& w, int b) { w.remove(b); };
  if (verb == "set_material") {
    Material material = scene.materials.at(entry.string("material"));
    return [material](World& w, int b) {
      Material m = material;
      m.response = w.material(b).response;
      w.set_material(b, m);
    };
  }
  if (verb == "set_velocity")
    return [v = vector_or_zero(entry, "velocity"), s = vector_or_zero(entry, "angular_velocity")](World& w, int b) {
      w.set_velocity(b, v, s);
    };
  const Vec3 offset = vector_or_zero(entry, "offset");
  const Mat3 R = rotation_of(entry);
  return [offset, R](World& w, int b) {
    const Vec3 middle = middle_of(w.body(b));
    w.move(b, {R, R == Mat3::Identity() ? offset : Vec3(middle - R * middle + offset)});
  };
}

/// The edit of a drive: of a joint between bodies, or of one of an articulated body.
std::function<void(World&)> drive_edit(const Node& entry, const World& world) {
  const Node name = entry.at("set_drive");
  const auto number_or_zero = [&](const char* key) { return entry.has(key) ? entry.number(key) : 0.0; };
  const double target = number_or_zero("target"), velocity = number_or_zero("target_velocity");
  if (!entry.has("joint"))
    for (int i = 0; i < world.attachment_count(); ++i) {
      const Attachment& a = world.attachment(i);
      if (a.name != name.string()) continue;
      if (!a.joint || !(a.joint->drive.stiffness > 0.0 || a.joint->drive.damping > 0.0))
        throw name.error(fmt::format("\"{}\" has no drive", a.name));
      return [i, target, velocity](World& w) { w.set_drive(i, target, velocity); };
    }
  for (int b = 0; b < world.body_count(); ++b) {
    if (world.body(b).name() != name.string()) continue;
    if (!entry.has("joint"))
      throw entry.error(fmt::format("\"set_drive\" of the body \"{}\" needs \"joint\"", name.string()));
    const Node joint = entry.at("joint");
    const std::span<const std::string> names = world.drives(b);
    const auto found = std::ranges::find(names, joint.string());
    if (found == names.end()) {
      const std::string near = nearest_word(joint.string(), names);
      throw joint.error(fmt::format("\"{}\" is not a joint of \"{}\" with a drive{}", joint.string(), name.string(),
                                    near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
    }
    const int drive = static_cast<int>(found - names.begin());
    return [b, drive, target, velocity](World& w) { w.set_drive(b, drive, target, velocity); };
  }
  throw name.error(fmt::format("\"{}\" is not {}", name.string(), entry.has("joint") ? "a body" : "a joint or a body"));
}

/// The edit that an entry is, with the numbers of what it concerns.
std::function<void(World&)> read_edit(const Node& entry, const Scene& scene, const World& world) {
  const std::string verb = verb_of(entry);
  if (verb == "gravity") return [g = entry.vec3("gravity")](World& w) { w.set_gravity(g); };
  if (verb == "pull") return [to = entry.vec3("pull")](World& w) { w.pull(to); };
  if (verb == "release") return [](World& w) { w.release(); };
  if (verb == "set_drive") return drive_edit(entry, world);
  if (verb == "detach") {
    const Node name = entry.at("detach");
    std::vector<int> numbers;
    for (int i = 0; i < world.attachment_count(); ++i)
      if (name_matches(name.string(), world.attachment(i).name)) numbers.push_back(i);
    if (numbers.empty()) throw name.error(fmt::format("\"{}\" is not an attachment or joint", name.string()));
    return [numbers](World& w) {
      for (const int i : numbers) w.detach(i);
    };
  }
  const Node name = entry.at(verb.c_str());
  const std::vector<int> numbers = bodies_of(name, world);
  if (verb == "grab") {
    if (numbers.size() > 1)
      throw name.error(fmt::format("\"{}\" means {} bodies; one can be grabbed", name.string(), numbers.size()));
    if (world.body(numbers[0]).immobile())
      throw name.error(fmt::format("\"{}\" does not move; it cannot be grabbed", name.string()));
    const auto number_or_zero = [&](const char* key) { return entry.has(key) ? entry.number(key) : 0.0; };
    return [b = numbers[0], at = entry.vec3("point"), k = number_or_zero("stiffness"),
            d = number_or_zero("damping")](World& w) { w.grab(b, at, k, d); };
  }
  if (verb == "freeze" || verb == "move")
    for (const int b : numbers) need_movable(name, verb, world.body(b), rotation_of(entry));
  return [numbers, word = name.string(), verb, edit = edit_of(entry, verb, scene)](World& w) {
    bool any = false;
    for (const int b : numbers)
      if (!w.removed(b)) edit(w, b), any = true;
    if (!any) throw InputError(fmt::format("{}: all that \"{}\" means was removed", verb, word));
  };
}

}  // namespace

void check_timeline(const Node& root, const Scene& scene) {
  const Node list = root.at("timeline");
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Node entry = list.at(i);
    const std::string verb = verb_of(entry);
    if (verb == "set_material") {
      if (!entry.has("material")) throw entry.error("\"set_material\" needs \"material\", the name of one");
      if (!scene.materials.contains(entry.string("material")))
        throw entry.at("material")
            .error(fmt::format("\"{}\" is not a material of the scene", entry.string("material")));
    }
    if (verb == "grab" && !entry.has("point")) throw entry.error("\"grab\" needs \"point\", where it takes hold");
    if (verb == "release" && !entry.boolean("release"))
      throw entry.at("release").error("must be true: what is held is let go");
    if (entry.has("rotation")) read_rotation(entry.at("rotation"));
  }
}

std::vector<std::string> late_entries(const Scene& scene) {
  constexpr double kSlack = 1e-6;  // of a step: times of steps are sums
  const double dt = scene.world.time_step, end = static_cast<double>(scene.frames) * scene.frame_time();
  const Node list = Node(*scene.document, scene.document->root, "").at("timeline");
  std::vector<std::string> late;
  for (std::size_t i = 0; i < list.size(); ++i)
    if (const double at = list.at(i).number("at"); at > end - dt + kSlack * dt)
      late.emplace_back(
          list.at(i)
              .at("at")
              .error(fmt::format(
                  "{:.6g} s is after the last step, which begins at {:.6g} s and ends the run at {:.6g} s: nothing "
                  "comes of this entry",
                  at, end - dt, end))
              .what());
  return late;
}

void schedule_timeline(const Scene& scene, World& world) {
  const Node list = Node(*scene.document, scene.document->root, "").at("timeline");
  for (std::size_t i = 0; i < list.size(); ++i)
    world.schedule(list.at(i).number("at"), read_edit(list.at(i), scene, world));
}

}  // namespace brim
