#include "brim/scene/scene.h"

#include <cmath>
#include <set>

#include "brim/core/printable.h"
#include "brim/scene/kinds.h"
#include "brim/scene/links.h"
#include "brim/scene/node.h"
#include "brim/scene/repeat.h"
#include "brim/scene/validate.h"
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

void read_pairs(const Node& list, const std::map<std::string, Material>& materials, WorldOptions& world) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Node pair = list.at(i), names = pair.at("materials");
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
}

/// Names that expectations may use: bodies, and stems of repeated ones.
std::set<std::string> check_bodies(const Node& list, const std::map<std::string, Material>& materials) {
  std::map<std::string, std::string> owner;  // final body name -> where it was given
  std::set<std::string> names;
  std::size_t total = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Node body = list.at(i);
    need_material(body.at("material"), body.string("material"), materials);
    find_body_kind(body.string("kind")).check(body);
    if (const std::string name = body.string("name"); printable(name) != name)
      throw body.at("name").error(
          fmt::format("\"{}\" is not allowed; a name has no control characters", printable(name)));
    if (!names.insert(body.string("name")).second)
      throw body.at("name").error(
          fmt::format("\"{}\" is already the name of a body; names must be unique", body.string("name")));
    total += repeat_count(body);
    if (total > kMaxBodies)
      throw body.error(fmt::format("{} bodies with this one; at most {} are allowed", total, kMaxBodies));
    for (const Placement& p : placements(body)) {
      const auto [it, fresh] = owner.emplace(p.name, body.pointer());
      if (!fresh)
        throw body.at("name").error(
            fmt::format("\"{}\" is already the name of a body at {}; names must be unique", p.name, it->second));
      if (body.has("repeat")) names.insert(p.name);
    }
  }
  return names;
}

std::vector<Expectation> read_expect(const Node& list, const std::set<std::string>& bodies, double end) {
  std::vector<Expectation> expect;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Node n = list.at(i);
    Expectation e;
    e.metric = n.string("metric");
    const auto read_body = [&](const char* key, std::string& name) {
      if (!n.has(key)) return;
      name = n.string(key);
      if (bodies.contains(name)) return;
      const std::string near = nearest_word(name, bodies);
      throw n.at(key).error(fmt::format("\"{}\" is not a body of this scene{}; must be the name of one", name,
                                        near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
    };
    read_body("body", e.body);
    read_body("of", e.of);
    if (ShownMetric::knows(e.metric) && e.body.empty())
      throw n.error(fmt::format("{} is of one body; \"body\" must name it", e.metric));
    if (ShownMetric::needs_other(e.metric) != n.has("of"))
      throw n.error(fmt::format("{} {}", e.metric,
                                n.has("of") ? "takes no other body; \"of\" must not be given"
                                            : "is beside another body; \"of\" must name it"));
    e.from = n.number("from");
    if (e.from > end * (1 + 1e-9))
      throw n.at("from").error(fmt::format("{} s is after the end of the run; must be at most {:.6g}", e.from, end));
    if (n.has("to")) e.to = n.number("to");
    if (e.to < e.from)
      throw n.at("to").error(fmt::format("{} s is before \"from\"; must be at least {}", e.to, e.from));
    if (!n.has("min") && !n.has("max")) throw n.error("no bound is given; \"min\", \"max\" or both are needed");
    if (n.has("min")) e.min = n.number("min");
    if (n.has("max")) e.max = n.number("max");
    if (e.min > e.max)
      throw n.at("min").error(fmt::format("{} is not allowed; must be at most \"max\", {}", e.min, e.max));
    if (n.has("known_miss")) e.known_miss = n.string("known_miss");
    expect.push_back(e);
  }
  return expect;
}

}  // namespace

Scene check_scene(Document read) {
  auto document = std::make_shared<Document>(std::move(read));
  validate(*document, scene_schema());
  const Node root(*document, document->root, "");
  Scene scene;
  scene.file = document->file;
  scene.text = document->text;
  scene.name = root.string("name");
  if (scene.name.find_first_of("/\\") != std::string::npos || scene.name.starts_with('.'))
    throw root.at("name").error(fmt::format(
        "\"{}\" is not allowed; must have no / or \\ and not begin with a dot: it names the folder of the run",
        scene.name));
  scene.description = root.string("description");
  scene.world = read_world(root.at("world"));
  scene.steps_per_frame = static_cast<int>(root.integer("steps_per_frame"));
  scene.frames = read_frames(root, scene.frame_time());
  scene.materials = read_materials(root.at("materials"));
  read_pairs(root.at("pairs"), scene.materials, scene.world);
  const std::set<std::string> bodies = check_bodies(root.at("bodies"), scene.materials);
  scene.world.touch_rules = read_filters(root);
  check_wiring(root);
  scene.expect = read_expect(root.at("expect"), bodies, static_cast<double>(scene.frames) * scene.frame_time());
  scene.document = std::move(document);
  return scene;
}

Scene load_scene(const std::string& path) { return check_scene(read_document(path)); }

Scene parse_scene(std::string_view text, const std::string& file) { return check_scene(parse_document(text, file)); }

std::vector<std::unique_ptr<Body>> build_bodies(const Scene& scene) {
  std::vector<std::unique_ptr<Body>> bodies;
  const Node list(*scene.document, scene.document->root.at("bodies"), "/bodies");
  const double duration = static_cast<double>(scene.frames) * scene.frame_time();
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Node node = list.at(i);
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
  }
  return bodies;
}

World build_world(const Scene& scene) {
  World world(scene.world);
  for (std::unique_ptr<Body>& body : build_bodies(scene)) world.add(std::move(body));
  wire_up(Node(*scene.document, scene.document->root, ""), world);
  return world;
}

}  // namespace brim
