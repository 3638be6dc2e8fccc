#include "brim/scene/scene.h"

#include <cmath>
#include <limits>
#include <set>

#include "brim/core/printable.h"
#include "brim/scene/errors.h"
#include "brim/scene/include.h"
#include "brim/scene/kinds.h"
#include "brim/scene/links.h"
#include "brim/scene/node.h"
#include "brim/scene/parameters.h"
#include "brim/scene/presets.h"
#include "brim/scene/repeat.h"
#include "brim/scene/sensors.h"
#include "brim/scene/timeline.h"
#include "brim/scene/validate.h"
#include "brim/world/levels.h"
#include "brim/world/shown_metric.h"

namespace brim {

namespace {

/// The word under "response"; Inherit where there is none.
Response read_response(const Node& n) {
  if (!n.has("response")) return Response::Inherit;
  return n.string("response") == "constraint" ? Response::Constraint : Response::Penalty;
}

/// What "quality" stands for where the keys themselves are not given.
struct Quality {
  double max_motion_voxels, cg_tolerance;
  int max_passes;
  double constraint_tolerance;
  int constraint_sweeps;
};

Quality read_quality(const Node& n) {
  const std::string word = n.string("quality");
  if (word == "draft") return {2.0, 1e-3, 2, 1e-3, 60};
  if (word == "fine") return {0.5, 1e-6, 8, 1e-5, 1000};
  const WorldOptions o;
  return {o.max_motion_voxels, o.cg_tolerance, o.max_passes, o.constraint_tolerance, o.constraint_sweeps};
}

/// Levels are chosen once a frame, so that a frame's record has them.
LevelOptions read_levels(const Node& n, int steps_per_frame) {
  LevelOptions o;
  for (const auto& [name, level] : n.at("bodies").json().items()) o.bodies[name] = level.get<int>();
  if (n.has("interest")) o.interest = n.vec3("interest");
  o.near = n.number("near");
  o.most = static_cast<int>(n.integer("most"));
  o.budget = 1e-3 * n.number("budget_ms");
  o.average = n.string("reduce") == "average";
  o.interval = steps_per_frame;
  return o;
}

/// Throws when levels are given for what is no body.
void check_levels(const Node& n, const std::set<std::string>& bodies) {
  for (const auto& [name, level] : n.at("bodies").json().items()) {
    if (bodies.contains(name)) continue;
    const std::string near = nearest_word(name, bodies);
    throw n.at("bodies")
        .at(name.c_str())
        .error(fmt::format("\"{}\" is not a body of this scene{}; must be the name of one", name,
                           near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
  }
}

WorldOptions read_world(const Node& n) {
  WorldOptions o;
  const Quality quality = read_quality(n);
  const auto number = [&](const char* key, double otherwise) { return n.has(key) ? n.number(key) : otherwise; };
  const auto integer = [&](const char* key, int otherwise) {
    return n.has(key) ? static_cast<int>(n.integer(key)) : otherwise;
  };
  o.environment.gravity = n.vec3("gravity");
  o.time_step = n.number("time_step");
  o.voxel_size = n.number("voxel_size");
  o.ramp_voxels = n.number("ramp_voxels");
  o.stiffness = n.at("stiffness").json().is_string() ? 0.0 : n.number("stiffness");
  o.damping_steps = n.number("damping_steps");
  o.max_motion_voxels = number("max_motion_voxels", quality.max_motion_voxels);
  o.max_substeps = static_cast<int>(n.integer("max_substeps"));
  o.min_substeps = static_cast<int>(n.integer("min_substeps"));
  o.cg_tolerance = number("cg_tolerance", quality.cg_tolerance);
  o.cg_max_iterations = static_cast<int>(n.integer("cg_max_iterations"));
  o.max_passes = integer("max_passes", quality.max_passes);
  o.friction_speed = n.number("friction_speed");
  o.response = read_response(n);
  o.constraint_tolerance = number("constraint_tolerance", quality.constraint_tolerance);
  o.constraint_sweeps = integer("constraint_sweeps", quality.constraint_sweeps);
  o.sleep = n.boolean("sleep");
  o.memory_limit = n.number("memory_limit");
  if (o.min_substeps > o.max_substeps)
    throw n.at("min_substeps")
        .error(fmt::format("{} is not allowed; must be at most max_substeps, {}", o.min_substeps, o.max_substeps));
  return o;
}

/// Frames after the first, from exactly one of "frames" and "duration".
std::int64_t read_frames(const Node& root, double frame_time) {
  if (root.has("frames") == root.has("duration")) {
    const char* found =
        root.has("frames") ? "both \"frames\" and \"duration\" are given" : "the length of the run is missing";
    throw root.error(fmt::format("{}; give either \"frames\" (a whole number) or \"duration\" (seconds)", found));
  }
  if (root.has("frames")) return root.integer("frames");
  const double frames = std::round(root.number("duration") / frame_time);
  if (frames < 1.0 || frames > 1e7)
    throw root.at("duration")
        .error(fmt::format("{} is not allowed; must be from one frame, {:.6g} s, to 1e7 frames",
                           shown(root.at("duration").json()), frame_time));
  return static_cast<std::int64_t>(frames);
}

std::map<std::string, Material> read_materials(const Node& n) {
  std::map<std::string, Material> materials;
  materials["default"] = Material{};
  for (const auto& [name, value] : n.json().items()) {
    const Node m = n.at(name.c_str());
    materials[name] = Material{name, m.number("friction"), m.number("restitution")};
  }
  return materials;
}

/// Throws when `name` (a value at `n`) is no material.
void need_material(const Node& n, const std::string& name, const std::map<std::string, Material>& materials) {
  if (materials.contains(name)) return;
  std::vector<std::string> known;
  std::string list;
  for (const auto& [k, unused] : materials) {
    known.push_back(k);
    list += (list.empty() ? "" : ", ") + k;
  }
  const std::string near = nearest_word(name, known);
  throw n.error(fmt::format("\"{}\" is not a material; must be one of: {}{}", name, list,
                            near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
}

void read_pair(const Node& pair, const std::map<std::string, Material>& materials, WorldOptions& world) {
  const Node names = pair.at("materials");
  std::string a = names.at(std::size_t{0}).string(), b = names.at(std::size_t{1}).string();
  need_material(names.at(std::size_t{0}), a, materials);
  need_material(names.at(std::size_t{1}), b, materials);
  if (a > b) std::swap(a, b);
  if (!pair.has("friction") && !pair.has("stiffness") && !pair.has("restitution") && !pair.has("response"))
    throw pair.error(
        "the pair says nothing; give one or more of \"friction\", \"stiffness\", \"restitution\", "
        "\"response\"");
  PairMaterial m;
  if (pair.has("friction")) m.friction = pair.number("friction");
  if (pair.has("stiffness")) m.stiffness = pair.number("stiffness");
  if (pair.has("restitution")) m.restitution = pair.number("restitution");
  m.response = read_response(pair);
  if (!world.pair_materials.emplace(std::make_pair(a, b), m).second)
    throw pair.error(fmt::format("the pair \"{}\" and \"{}\" is given twice; once is allowed", a, b));
}

/// Checks bodies one after another; knows the names so far.
class BodyCheck {
 public:
  explicit BodyCheck(const std::map<std::string, Material>& materials) : materials_(materials) {}

  void check(const Node& body) {
    need_material(body.at("material"), body.string("material"), materials_);
    find_body_kind(body.string("kind")).check(body);
    if (const std::string name = body.string("name"); printable(name) != name)
      throw body.at("name").error(
          fmt::format("\"{}\" is not allowed; a name has no control characters", printable(name)));
    if (!names_.insert(body.string("name")).second)
      throw body.at("name").error(
          fmt::format("\"{}\" is already the name of a body; names must be unique", body.string("name")));
    const std::size_t copies = repeat_count(body);
    if (total_ + copies > kMaxBodies)
      throw body.error(fmt::format("{} bodies with this one; at most {} are allowed", total_ + copies, kMaxBodies));
    total_ += copies;
    for (const Placement& p : placements(body)) {
      const auto [it, fresh] = owner_.emplace(p.name, body.pointer());
      if (!fresh)
        throw body.at("name").error(
            fmt::format("\"{}\" is already the name of a body at {}; names must be unique", p.name, it->second));
      if (body.has("repeat")) names_.insert(p.name);
    }
  }

  /// Names that expectations may use: bodies, and stems of repeated ones.
  const std::set<std::string>& names() const { return names_; }

 private:
  const std::map<std::string, Material>& materials_;
  std::map<std::string, std::string> owner_;  ///< final body name -> where it was given
  std::set<std::string> names_;
  std::size_t total_ = 0;
};

/// @param bodies  names; nothing where not all bodies could be read
Expectation read_expectation(const Node& n, const std::set<std::string>* bodies, double end) {
  Expectation e;
  e.metric = n.string("metric");
  const auto read_body = [&](const char* key, std::string& name) {
    if (!n.has(key)) return;
    name = n.string(key);
    if (!bodies || bodies->contains(name)) return;
    const std::string near = nearest_word(name, *bodies);
    throw n.at(key).error(fmt::format("\"{}\" is not a body of this scene{}; must be the name of one", name,
                                      near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
  };
  read_body("body", e.body);
  read_body("of", e.of);
  if (ShownMetric::knows(e.metric) && e.body.empty())
    throw n.error(fmt::format("{} is of one body; \"body\" must name it", e.metric));
  if (ShownMetric::needs_other(e.metric) != n.has("of"))
    throw n.error(fmt::format(
        "{} {}", e.metric,
        n.has("of") ? "takes no other body; \"of\" must not be given" : "is beside another body; \"of\" must name it"));
  const bool sensed = e.metric == "sensor";
  for (const char* key : {"sensor", "channel"})
    if (n.has(key) != sensed)
      throw n.error(fmt::format(
          "\"{}\" {}", key,
          sensed ? "is missing: the metric \"sensor\" is of a reading of one" : "is of the metric \"sensor\" alone"));
  if (sensed) {
    if (n.has("body")) throw n.at("body").error("it is not allowed beside \"sensor\"; a sensor has its bodies");
    e.reading = {n.string("sensor"), n.string("channel")};
    if (n.has("over")) e.over = {n.at("over").string("sensor"), n.at("over").string("channel")};
    e.take = n.string("take");
  }
  e.from = n.number("from");
  if (e.from > end * (1 + 1e-9))
    throw n.at("from").error(fmt::format("{} s is after the end of the run; must be at most {:.6g}", e.from, end));
  if (n.has("to")) e.to = n.number("to");
  if (e.to < e.from) throw n.at("to").error(fmt::format("{} s is before \"from\"; must be at least {}", e.to, e.from));
  if (!n.has("min") && !n.has("max")) throw n.error("no bound is given; \"min\", \"max\" or both are needed");
  if (n.has("min")) e.min = n.number("min");
  if (n.has("max")) e.max = n.number("max");
  if (e.min > e.max)
    throw n.at("min").error(fmt::format("{} is not allowed; must be at most \"max\", {}", e.min, e.max));
  if (n.has("known_miss")) e.known_miss = n.string("known_miss");
  if (n.has("known_worst")) {
    e.known_worst = n.number("known_worst");
    if (e.known_miss.empty()) throw n.at("known_worst").error("it is of a bound with \"known_miss\" alone");
    if (e.known_worst >= e.min && e.known_worst <= e.max)
      throw n.at("known_worst").error(fmt::format("{} is within the bound; must be outside of it", e.known_worst));
  }
  return e;
}

/// The text that makes the same scene by itself: with parameters in their places and all that was included.
void keep_equal_signs(Json& value) {
  if (value.is_string() && value.get_ref<const std::string&>().starts_with("="))
    value = "=" + value.get<std::string>();
  else if (value.is_structured())
    for (Json& member : value) keep_equal_signs(member);
}

std::string whole_text(Json root) {
  keep_equal_signs(root);
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// Reads parts of a scene, those alone that were found good; what else is wrong is collected.
class SceneReader {
 public:
  SceneReader(const Node& root, ErrorList& errors) : root_(root), errors_(errors) {}

  void read(Scene& scene) {
    part("/name", [&] {
      scene.name = root_.string("name");
      if (scene.name.find_first_of("/\\") != std::string::npos || scene.name.starts_with('.'))
        throw root_.at("name").error(fmt::format(
            "\"{}\" is not allowed; must have no / or \\ and not begin with a dot: it names the folder of the run",
            scene.name));
    });
    part("/description", [&] { scene.description = root_.string("description"); });
    part("/world", [&] { scene.world = read_world(root_.at("world")); });
    part("/steps_per_frame", [&] { scene.steps_per_frame = static_cast<int>(root_.integer("steps_per_frame")); });
    // A misspelt key may be the one that is missing.
    const Json& known = scene_schema().at("properties");
    bool misspelt = false;
    for (const auto& [key, unused] : root_.json().items()) misspelt = misspelt || !known.contains(key);
    const bool timed = !misspelt && !errors_.touches("/world") && !errors_.touches("/steps_per_frame") &&
                       !errors_.touches("/duration") && !errors_.touches("/frames");
    if (timed) part("/frames", [&] { scene.frames = read_frames(root_, scene.frame_time()); });
    part("/materials", [&] { scene.materials = read_materials(root_.at("materials")); });
    if (!errors_.touches("/materials")) {
      each("pairs", [&](const Node& pair) { read_pair(pair, scene.materials, scene.world); });
      BodyCheck bodies(scene.materials);
      each("bodies", [&](const Node& body) { bodies.check(body); });
      const bool all = !errors_.touches("/bodies");
      if (all) part("/filters", [&] { scene.world.touch_rules = read_filters(root_); });
      if (all && !errors_.touches("/joints") && !errors_.touches("/forces"))
        part("/attachments", [&] { check_wiring(root_); });
      if (all) part("/timeline", [&] { check_timeline(root_, scene); });
      std::set<std::string> sensors;
      if (!errors_.touches("/groups"))
        each("sensors", [&](const Node& n) { check_sensor(n, &root_.at("groups").json(), sensors); });
      if (all && !errors_.touches("/world") && root_.at("world").has("levels"))
        part("/world/levels", [&] { check_levels(root_.at("world").at("levels"), bodies.names()); });
      const double end = timed && !errors_.touches("/frames") ? static_cast<double>(scene.frames) * scene.frame_time()
                                                              : std::numeric_limits<double>::infinity();
      each("expect",
           [&](const Node& n) { scene.expect.push_back(read_expectation(n, all ? &bodies.names() : nullptr, end)); });
    }
  }

 private:
  template <class F>
  void part(const std::string& pointer, const F& f) {
    if (!errors_.touches(pointer)) errors_.attempt(pointer, f);
  }
  template <class F>
  void each(const char* key, const F& f) {
    const Node list = root_.at(key);
    if (!list.json().is_array()) return;
    const bool good = !errors_.touches(list.pointer());
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Node n = list.at(i);
      if (good || !errors_.touches(n.pointer())) errors_.attempt(n.pointer(), [&] { f(n); });
    }
  }

  const Node& root_;
  ErrorList& errors_;
};

}  // namespace

Scene check_scene(Document document) { return check_scene(std::move(document), SceneSettings{}); }

Scene check_scene(Document read, const SceneSettings& settings) {
  auto document = std::make_shared<Document>(std::move(read));
  ErrorList errors;
  apply_parameters(*document, settings, errors);
  bool included = false;
  bool whole = errors.attempt("/include", [&] { included = apply_includes(*document, errors); });
  whole = whole && !errors.touches("/include");
  if (settings.seed) errors.attempt("", [&] { apply_seed(*document, *settings.seed); });
  if (included || !settings.empty()) document->text = whole_text(document->root);
  apply_presets(*document, errors);
  // Where not all files could be read, the list of bodies may be empty, and names may be theirs.
  if (!whole && (!document->root.contains("bodies") || document->root.at("bodies").empty())) errors.raise();
  validate(*document, scene_schema(), errors);
  if (!whole) errors.raise();
  Scene scene;
  const Node root(*document, document->root, "");
  // Without its frame nothing can be read, and the rest of what is wrong would be said in other words.
  const Json& r = document->root;
  if (r.is_object() && r.contains("bodies") && r.at("bodies").is_array() && r.contains("name"))
    SceneReader(root, errors).read(scene);
  errors.raise();
  scene.file = document->file;
  scene.text = document->text;
  scene.document = std::move(document);
  return scene;
}

Scene load_scene(const std::string& path) { return check_scene(read_document(path)); }

Scene load_scene(const std::string& path, const SceneSettings& settings) {
  return check_scene(read_document(path), settings);
}

Scene parse_scene(std::string_view text, const std::string& file) { return check_scene(parse_document(text, file)); }

Scene parse_scene(std::string_view text, const std::string& file, const SceneSettings& settings) {
  return check_scene(parse_document(text, file), settings);
}

std::vector<std::unique_ptr<Body>> build_bodies(const Scene& scene) {
  std::vector<std::unique_ptr<Body>> bodies;
  const Node list(*scene.document, scene.document->root.at("bodies"), "/bodies");
  const double duration = static_cast<double>(scene.frames) * scene.frame_time();
  ErrorList errors;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Node node = list.at(i);
    errors.attempt(node.pointer(), [&] {
      const BodyKind& kind = find_body_kind(node.string("kind"));
      Material material = scene.materials.at(node.string("material"));
      material.response = read_response(node);
      // Copies share what the kind made of the node (meshes, distance fields), so it is read once.
      const std::unique_ptr<BodyMaker> maker = node.placed([&] {
        return kind.make(node, BuildContext{scene.world, material, duration});
      });
      for (const Placement& p : placements(node)) {
        node.placed([&] {
          std::unique_ptr<Body> body = maker->body(p);
          body->set_name(p.name);
          bodies.push_back(std::move(body));
        });
      }
    });
  }
  errors.raise();
  return bodies;
}

World build_world(const Scene& scene) {
  World world(scene.world);
  for (std::unique_ptr<Body>& body : build_bodies(scene)) world.add(std::move(body));
  wire_up(Node(*scene.document, scene.document->root, ""), world);
  schedule_timeline(scene, world);
  const Node n(*scene.document, scene.document->root.at("world"), "/world");
  if (n.has("levels")) set_levels(world, read_levels(n.at("levels"), scene.steps_per_frame));
  return world;
}

}  // namespace brim
