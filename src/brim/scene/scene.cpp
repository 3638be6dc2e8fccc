#include "brim/scene/scene.h"

#include <cmath>
#include <limits>
#include <set>

#include "brim/core/printable.h"
#include "brim/scene/errors.h"
#include "brim/scene/idle_keys.h"
#include "brim/scene/include.h"
#include "brim/scene/kinds.h"
#include "brim/scene/links.h"
#include "brim/scene/materials.h"
#include "brim/scene/node.h"
#include "brim/scene/parameters.h"
#include "brim/scene/presets.h"
#include "brim/scene/read_expectation.h"
#include "brim/scene/read_world.h"
#include "brim/scene/repeat.h"
#include "brim/scene/sensors.h"
#include "brim/scene/solid_store.h"
#include "brim/scene/timeline.h"
#include "brim/scene/validate.h"

namespace brim {

namespace {

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

/// Words that begin with "=" get a second one, which keeps them from being read as names of parameters.
void keep_equal_signs(Json& value) {
  if (value.is_string() && value.get_ref<const std::string&>().starts_with("="))
    value = "=" + value.get<std::string>();
  else if (value.is_structured())
    for (Json& member : value) keep_equal_signs(member);
}

/// The text that makes the same scene by itself: with parameters in their places and all that was included.
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
  refuse_idle_keys(*document, errors);
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

void build_bodies(const Scene& scene, SolidStore& solids, const std::function<void(std::unique_ptr<Body>)>& take) {
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
        return kind.make(node, BuildContext{scene.world, material, duration, solids});
      });
      for (const Placement& p : placements(node)) {
        node.placed([&] {
          std::unique_ptr<Body> body = maker->body(p);
          body->set_name(p.name);
          take(std::move(body));
        });
      }
    });
  }
  errors.raise();
}

std::vector<std::unique_ptr<Body>> build_bodies(const Scene& scene) {
  SolidStore solids;
  return build_bodies(scene, solids);
}

std::vector<std::unique_ptr<Body>> build_bodies(const Scene& scene, SolidStore& solids) {
  std::vector<std::unique_ptr<Body>> bodies;
  build_bodies(scene, solids, [&](std::unique_ptr<Body> body) { bodies.push_back(std::move(body)); });
  return bodies;
}

void wire_world(const Scene& scene, World& world) {
  const Node root(*scene.document, scene.document->root, ""), n = root.at("world");
  root.placed([&] {
    wire_up(root, world);
    schedule_timeline(scene, world);
  });
  if (n.has("levels"))
    n.at("levels").placed([&] { set_levels(world, read_levels(n.at("levels"), scene.steps_per_frame)); });
}

World build_world(const Scene& scene) {
  const Node root(*scene.document, scene.document->root, ""), n = root.at("world");
  World world = n.placed([&] { return World(scene.world); });
  SolidStore solids;
  build_bodies(scene, solids, [&](std::unique_ptr<Body> body) { world.add(std::move(body)); });
  wire_world(scene, world);
  return world;
}

}  // namespace brim
