#include "brim/scene/moved_entry.h"

#include "brim/scene/motion.h"
#include "brim/scene/validate.h"

namespace brim {

namespace {

Json list_of(const Vec3& x) { return Json::array({x.x(), x.y(), x.z()}); }

/// x -> position + rotation x, applied to the parts of an entry; what is not of the form that the schema asks for is
/// left to the schema.
class Mover {
 public:
  Mover(const Vec3& position, const Quat& rotation, bool turns) : p_(position), r_(rotation), turns_(turns) {}

  void entry(Json& body, const Node& written) const {
    if (turns_) need_free(body, written);
    pose(body["transform"]);
    if (body.contains("repeat") && body["repeat"].is_object()) circle(body["repeat"]);
    for (const char* key : {"velocity", "angular_velocity"}) direction(body, key);
    if (body.contains("keyframes")) keyframes(body["keyframes"]);
    if (body.contains("constraints") && body["constraints"].is_array())
      for (Json& c : body["constraints"])
        if (c.is_object()) constraint(c);
  }
  /// The keys of filters, attachments, joints, forces and sensors are not at odds with each other.
  void link(Json& link, const Node& written) const {
    for (const char* key : {"region", "to_region"}) {
      if (!link.contains(key)) continue;
      if (turns_ && is_box(link[key])) refuse(written, "a region that is a box lies");
      region(link[key]);
    }
    // Torque is about the origin of the scene that is included.
    if (link.value("kind", Json()) == "force" && !link.contains("about")) link["about"] = Json::array({0, 0, 0});
    for (const char* key : {"point", "to_point", "position", "about"}) point(link, key);
    for (const char* key : {"axis", "force", "torque", "acceleration"}) direction(link, key);
    if (link.contains("keyframes")) keyframes(link["keyframes"]);
    if (link.contains("grid") && link["grid"].is_object()) {
      point(link["grid"], "origin");
      for (const char* side : {"x", "y"}) direction(link["grid"], side);
    }
    if (link.contains("wind") && link["wind"].is_object()) {
      Json& wind = link["wind"];
      direction(wind, "velocity");
      if (wind.contains("field") && wind["field"].is_object()) pose(wind["field"]["transform"]);
    }
    if (link.contains("attractor") && link["attractor"].is_object()) {
      Json& attractor = link["attractor"];
      if (!attractor.contains("center")) attractor["center"] = Json::array({0, 0, 0});
      point(attractor, "center");
    }
  }

  /// The rotation of an edit is about the middle of its body.
  void edit(Json& edit) const {
    for (const char* key : {"offset", "velocity", "angular_velocity"}) direction(edit, key);
    for (const char* key : {"point", "pull"}) point(edit, key);
    turn(edit);
  }

 private:
  static bool is_vec3(const Json& v) {
    return v.is_array() && v.size() == 3 && v[0].is_number() && v[1].is_number() && v[2].is_number();
  }
  static Vec3 vec3(const Json& v) { return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()}; }

  void point(Json& owner, const char* key) const {
    if (owner.contains(key) && is_vec3(owner[key])) owner[key] = list_of(p_ + r_ * vec3(owner[key]));
  }
  void direction(Json& owner, const char* key) const {
    if (turns_ && owner.contains(key) && is_vec3(owner[key])) owner[key] = list_of(r_ * vec3(owner[key]));
  }
  static Json quaternion(const Quat& q) { return {{"quaternion", Json::array({q.w(), q.x(), q.y(), q.z()})}}; }
  static Quat rotation_of(const Json& given) {
    Document alone;
    alone.root = {{"rotation", given}};
    const Json schema = {{"type", "object"},
                         {"properties", {{"rotation", {{"$ref", "#/$defs/rotation"}}}}},
                         {"$defs", scene_schema().at("$defs")}};
    validate(alone, schema);
    return read_rotation(Node(alone, alone.root.at("rotation"), "/rotation"));
  }

  void pose(Json& transform) const {
    if (transform.is_null()) transform = Json::object();
    if (!transform.is_object()) return;
    if (!transform.contains("position")) transform["position"] = Json::array({0, 0, 0});
    point(transform, "position");
    if (turns_)
      transform["rotation"] =
          quaternion(r_ * (transform.contains("rotation") ? rotation_of(transform["rotation"]) : Quat::Identity()));
  }
  void circle(Json& repeat) const {
    if (!repeat.contains("around") || !repeat["around"].is_object()) return;
    Json& around = repeat["around"];
    around.emplace("point", Json::array({0, 0, 0}));
    around.emplace("axis", Json::array({0, 0, 1}));
    point(around, "point");
    direction(around, "axis");
  }
  void keyframes(Json& keys) const {
    if (!turns_ || !keys.is_array()) return;
    for (Json& key : keys) {
      if (!key.is_object()) continue;
      direction(key, "offset");
      turn(key);
    }
  }
  /// A rotation of something where it is.
  void turn(Json& owner) const {
    if (turns_ && owner.contains("rotation"))
      owner["rotation"] = quaternion(r_ * rotation_of(owner["rotation"]) * r_.conjugate());
  }
  void region(Json& region_at) const {
    if (!region_at.is_object()) return;
    for (const char* key : {"lo", "hi", "center", "point"}) point(region_at, key);
    direction(region_at, "normal");
  }
  void constraint(Json& c) const {
    if (c.contains("select")) region(c["select"]);
    direction(c, "velocity");
    if (c.contains("keyframes")) keyframes(c["keyframes"]);
  }

  static bool is_box(const Json& select) { return select.is_object() && select.value("kind", "") == "box"; }

  [[noreturn]] static void refuse(const Node& written, const char* what) {
    throw written.error(
        fmt::format("{} along the axes of the world; the scene that includes it may move it, not turn it", what));
  }
  /// Copies in a circle alone have no axes of the world in them.
  static bool on_a_grid(const Json& repeat) {
    return !repeat.is_object() || !repeat.contains("around") || repeat.contains("count") || repeat.contains("jitter") ||
           repeat.value("turn", Json("none")) != "none";
  }
  static void need_free(const Json& body, const Node& written) {
    if (body.contains("repeat") && on_a_grid(body.at("repeat"))) refuse(written, "the copies of a \"repeat\" lie");
    if (body.value("kind", "") == "grid_fluid") refuse(written, "the grid of a grid_fluid lies");
    if (body.contains("constraints") && body.at("constraints").is_array())
      for (const Json& c : body.at("constraints"))
        if (c.is_object() && c.contains("select") && is_box(c.at("select")))
          refuse(written, "a region that is a box lies");
  }

  Vec3 p_;
  Quat r_;
  bool turns_;
};

}  // namespace

namespace {

/// Calls f with the mover of a transform.
template <class F>
void with_mover(const Node& transform, const Node& written, const F& f) {
  const bool turns = transform.has("rotation");
  const Quat r = turns ? read_rotation(transform.at("rotation")) : Quat::Identity();
  written.placed([&] { f(Mover(transform.vec3("position"), r, turns)); });
}

}  // namespace

void move_entry(Json& body, const Node& transform, const Node& written) {
  with_mover(transform, written, [&](const Mover& mover) { mover.entry(body, written); });
}

void move_link(Json& link, const Node& transform, const Node& written) {
  with_mover(transform, written, [&](const Mover& mover) { mover.link(link, written); });
}

void move_edit(Json& edit, const Node& transform, const Node& written) {
  with_mover(transform, written, [&](const Mover& mover) { mover.edit(edit); });
}

}  // namespace brim
