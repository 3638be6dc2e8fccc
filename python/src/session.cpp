#include "session.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "array_body.h"
#include "arrays.h"
#include "brim/body/own/own_body_check.h"
#include "brim/core/stop.h"
#include "brim/scene/kinds.h"
#include "brim/scene/links.h"
#include "brim/scene/node.h"
#include "brim/scene/parameters.h"
#include "brim/scene/read_world.h"
#include "brim/scene/sensors.h"
#include "brim/scene/solid.h"
#include "brim/world/applied_force.h"
#include "brim/world/attachment.h"
#include "brim/world/report_fields.h"
#include "brim/world/sense/sensors.h"
#include "interpreter_lock.h"
#include "json_of.h"
#include "session_busy.h"
#include "wind_of.h"

namespace brim::python {

namespace {

/// Stands for the file of an entry that was added; messages lose it again.
constexpr const char* kAdded = "<added>";

/// Takes the place in the made-up file and the number of the entry out of a line of a message:
/// "FILE:1: /bodies/0/shape/radius: ..." -> "shape/radius: ...". A line of another kind stays as it is.
std::string without_place(std::string line, const std::string& file) {
  if (!line.starts_with(file + ":")) return line;
  line = line.substr(line.find(": ") + 2);
  for (const char* prefix :
       {"/bodies/0/", "/bodies/0: ", "/attachments/0/", "/attachments/0: ", "/joints/0/", "/joints/0: ", "/forces/0/",
        "/forces/0: ", "/filters/0/", "/filters/0: ", "/sensors/0/", "/sensors/0: ", "/world/", "/"})
    if (line.starts_with(prefix)) return line.substr(std::strlen(prefix));
  return line;
}

/// The world names an attachment, force or sensor as well, in its own quotes: once is enough.
std::string named_once(std::string line, const std::string& what) {
  const std::size_t from = what.find('"'), end = line.find("': ");
  if (from == std::string::npos || end == std::string::npos) return line;
  const std::string name = what.substr(from + 1, what.size() - from - 2);
  for (const char* noun : {"attachment", "joint", "force", "sensor"})
    if (line.starts_with(fmt::format("{} '{}': ", noun, name))) return line.substr(end + 3);
  return line;
}

/// Errors of a scene, one a line, in the words of who called: each begins with `what`, none names the made-up file.
template <class F>
auto in_words(const std::string& file, const std::string& what, const F& f) {
  try {
    return f();
  } catch (const InputError& e) {
    std::istringstream lines(e.what());
    std::string text;
    for (std::string line; std::getline(lines, line);)
      text += (text.empty() ? "" : "\n") + what + ": " + named_once(without_place(line, file), what);
    throw InputError(text);
  }
}

Json floor_entry() { return {{"kind", "obstacle"}, {"name", "floor"}, {"shape", {{"kind", "plane"}}}}; }

}  // namespace

Session::Session(const py::dict& scene, std::string folder) : folder_(std::move(folder)) {
  head_ = json_of(scene, "");
  const Scene empty = checked(floor_entry());
  frames = empty.frames;
  steps_per_frame = empty.steps_per_frame;
  expect = empty.expect;
  world_ = std::make_unique<World>(empty.world);
  levels();
}

std::unique_ptr<Session> Session::load(const std::string& path, const py::dict& set,
                                       std::optional<std::uint64_t> seed) {
  std::unique_ptr<Session> s(new Session());
  SceneSettings settings;
  const Json given = json_of(set, "set");
  for (const auto& [name, value] : given.items()) settings.set[name] = value;
  settings.seed = seed;
  const Scene scene = settings.empty() ? load_scene(path) : load_scene(path, settings);
  s->folder_ = std::filesystem::absolute(path).parent_path().string();
  s->file = std::filesystem::absolute(path).lexically_normal().string();
  s->text = scene.text;
  s->frames = scene.frames;
  s->steps_per_frame = scene.steps_per_frame;
  s->expect = scene.expect;
  s->head_ = parse_document(scene.text, path).root;
  s->entries_ = s->head_.at("bodies");
  s->head_.erase("bodies");
  {
    const Unlocked unlocked;
    s->world_ = std::make_unique<World>(scene.world);
    build_bodies(scene, s->solids_, [&](std::unique_ptr<Body> body) { s->take(std::move(body)); });
    wire_world(scene, *s->world_);
  }
  std::int64_t links = 0, forces = 0;
  for (const char* list : {"attachments", "joints", "forces"})
    if (s->head_.contains(list))
      for (std::size_t i = 0; i < s->head_[list].size(); ++i)
        s->wired_[list].push_back(list == std::string("forces") ? forces++ : links++);
  for (const Json& entry : s->entries_) s->names_.insert(entry.at("name").get<std::string>());
  return s;
}

Scene Session::checked(const Json& entry, const std::string& kind) const {
  Document document;
  document.file = (std::filesystem::path(folder_) / kAdded).string();
  document.root = head_;
  for (const char* list : {"expect", "attachments", "joints", "forces", "sensors"}) document.root.erase(list);
  document.root["world"].erase("levels");  // names bodies that are not in this document
  document.root["bodies"] = Json::array({entry});
  document.arrays = arrays;
  const bool alone = entry == floor_entry();
  const std::string what =
      alone ? "World"
            : fmt::format("{} \"{}\"", kind.empty() ? entry.value("kind", "body") : kind,
                          entry.contains("name") && entry["name"].is_string() ? entry["name"].get<std::string>() : "");
  const std::string made_up = document.file;
  return in_words(made_up, what, [&] {
    Scene scene = check_scene(std::move(document));
    return scene;
  });
}

std::optional<LevelOptions> Session::levels() const {
  const auto world = head_.find("world");
  if (world == head_.end() || !world->contains("levels")) return std::nullopt;
  // Bodies to come may be named: one stands for each name.
  const Json& given = world->at("levels");
  Json named = Json::array();
  if (given.is_object() && given.contains("bodies") && given["bodies"].is_object())
    for (const auto& [name, level] : given["bodies"].items())
      named.push_back(floor_entry()), named.back()["name"] = name;
  if (named.empty()) named.push_back(floor_entry());
  Document document;
  document.file = (std::filesystem::path(folder_) / kAdded).string();
  document.root = {{"brim", 1}, {"name", "world"}, {"duration", 1}, {"world", {{"levels", given}}}, {"bodies", named}};
  const std::string made_up = document.file;
  return in_words(made_up, "World", [&] {
    const Scene scene = check_scene(std::move(document));
    const Node root(*scene.document, scene.document->root, "");
    return read_levels(root.at("world").at("levels"), steps_per_frame);
  });
}

std::map<std::string, Material> Session::materials() const { return checked(floor_entry()).materials; }

void Session::take(std::unique_ptr<Body> body) {
  const std::string name = body->name();
  auto* const outer = dynamic_cast<OuterForces*>(body.get());
  world_->add(std::move(body));  // may refuse it: then nothing is known of it
  names_.insert(name);
  outer_.push_back(outer);
  mirrors_.push_back(nullptr);
}

void Session::include(std::vector<std::unique_ptr<Body>> bodies, const Json& entry) {
  read_mirrors();
  unlocked([&] {
    for (std::unique_ptr<Body>& body : bodies) take(std::move(body));
    if (const auto chosen = levels()) set_levels(*world_, *chosen);
  });
  names_.insert(entry.at("name").get<std::string>());
  entries_.push_back(entry);
  file.clear(), text.clear();
}

std::vector<int> Session::add(const py::dict& given) {
  const Busy busy(*this);
  const Json entry = json_of(given, "");
  const Scene scene = checked(entry);
  const std::string name = entry.at("name").get<std::string>();
  std::vector<std::unique_ptr<Body>> bodies;
  const std::string made_up = scene.file;
  in_words(made_up, fmt::format("{} \"{}\"", entry.at("kind").get<std::string>(), name), [&] {
    if (names_.contains(name)) throw InputError("name: it is already the name of a body; names must be unique");
    const Unlocked unlocked;
    bodies = build_bodies(scene, solids_);
    for (const auto& body : bodies)
      if (names_.contains(body->name()))
        throw InputError(fmt::format("name: \"{}\" is already the name of a body; names must be unique", body->name()));
  });
  std::vector<int> numbers;
  for (std::size_t i = 0; i < bodies.size(); ++i) numbers.push_back(world_->body_count() + static_cast<int>(i));
  include(std::move(bodies), entry);
  return numbers;
}

int Session::add_own(const py::dict& given, const py::object& author, const py::object& q, const py::object& v,
                     double mass_spacing, double stiffness_damping) {
  const Busy busy(*this);
  Json entry = json_of(given, "");
  const auto kind = py::str(py::type::of(author).attr("__name__")).cast<std::string>();
  const Scene scene = checked(entry, kind);
  const std::string name = entry.at("name").get<std::string>();
  OwnModel model;
  in_words(scene.file, fmt::format("{} \"{}\"", kind, name), [&] {
    if (names_.contains(name)) throw InputError("name: it is already the name of a body; names must be unique");
    const Node node(*scene.document, scene.document->root.at("bodies").at(0), "/bodies/0");
    model.surface = read_surface_of(node.at("shape"), 1.0).mesh;
    model.density = node.has("density") ? node.number("density") : 1000.0;
    model.voxel_size = node.number("voxel_size");
    model.material = scene.materials.at(node.string("material"));
    if (node.has("response"))
      model.material.response = node.string("response") == "constraint" ? Response::Constraint : Response::Penalty;
    const DoubleArray start = DoubleArray::ensure(q);
    if (!start || start.ndim() != 1 || start.size() == 0) {
      PyErr_Clear();
      throw InputError("q0: must be an array of one coordinate at least, shape (n,)" +
                       (start ? ", not " + shape_text(start) : std::string()));
    }
    model.q = numbers_of(q, static_cast<std::size_t>(start.size()), "q0");
    if (!v.is_none()) model.v = numbers_of(v, model.q.size(), "v0");
    for (const auto& [key, value] :
         {std::pair{"mass_spacing", mass_spacing}, std::pair{"stiffness_damping", stiffness_damping}})
      if (!(value >= 0.0) || !std::isfinite(value))
        throw InputError(fmt::format("{}: {} is not allowed; must be a number from 0", key, value));
  });
  model.mass_spacing = mass_spacing;
  model.stiffness_damping = stiffness_damping;
  std::vector<std::unique_ptr<Body>> bodies;
  bodies.push_back(std::make_unique<ArrayBody>(std::move(model), author, caller_));
  bodies.back()->set_name(name);
  const int number = world_->body_count();
  served_ = true;
  // Once by itself, so that what its author raises leaves the world as it was.
  std::vector<double> first_q(bodies.back()->q_size()), first_v(bodies.back()->v_size());
  bodies.back()->initial_state(first_q, first_v);
  unlocked([&] { bodies.back()->update(world_->state().time, first_q, first_v); });
  entry["kind"] = "python";
  entry["class"] = kind;
  include(std::move(bodies), entry);
  return number;
}

std::vector<std::string> Session::check_own(int body, unsigned seed) {
  const Busy busy(*this);
  read_mirrors();
  const auto* own = dynamic_cast<const OwnBody*>(&world_->body(body));
  if (own == nullptr) throw InputError(fmt::format("check: '{}' is no own body", world_->body(body).name()));
  std::vector<std::string> found;
  unlocked([&] { found = check_own_body(*own, seed); });
  return found;
}

int Session::wire(const std::string& list, const py::dict& given, const py::object& field) {
  const Busy busy(*this);
  const Json entry = json_of(given, "");
  const bool named = entry.contains("name") && entry["name"].is_string();
  const std::string what =
      named ? fmt::format("{} \"{}\"", list.substr(0, list.size() - 1), entry["name"].get<std::string>())
            : list.substr(0, list.size() - 1);
  Document document;
  document.file = (std::filesystem::path(folder_) / kAdded).string();
  document.root = head_;
  for (const char* other : {"expect", "attachments", "joints", "forces", "filters", "sensors"})
    document.root.erase(other);
  document.root["world"].erase("levels");
  document.root["bodies"] = Json::array({floor_entry()});
  document.root[list] = Json::array({entry});
  const std::string made_up = document.file;
  int number = -1;
  WindField air;
  if (!field.is_none()) {
    if (!entry.contains("wind")) throw InputError(what + ": a field of air is of a wind");
    air = wind_of(field, caller_);
    served_ = true;
  }
  in_words(made_up, what, [&] {
    const Scene scene = check_scene(std::move(document));
    read_mirrors();
    unlocked([&] {
      const Node root(*scene.document, scene.document->root, ""), node = root.at(list.c_str()).at(std::size_t{0});
      if (list == "filters") {
        check_filter_names(node, root, *world_);
        for (const TouchRule& rule : scene.world.touch_rules) world_->set_touch(rule);
      } else if (list == "attachments")
        number = node.placed([&] { return world_->attach(read_attachment(node)); });
      else if (list == "joints")
        number = node.placed([&] { return world_->attach(read_joint(node)); });
      else if (list == "sensors")
        number = node.placed([&] { return add_sensor(*world_, read_sensor(node, &root.at("groups").json())); });
      else
        number = node.placed([&] {
          AppliedForce force = read_force(node);
          if (air) force.wind->field = air;
          return world_->apply(force);
        });
    });
  });
  head_[list].push_back(entry);
  if (list == "attachments" || list == "joints") wired_[list].push_back(world_->attachment_id(number));
  if (list == "forces") wired_[list].push_back(world_->force_id(number));
  file.clear(), text.clear();
  return number;
}

Json Session::head() {
  const World& world = this->world();
  std::set<std::int64_t> links, forces;
  for (int i = 0; i < world.attachment_count(); ++i) links.insert(world.attachment_id(i));
  for (int i = 0; i < world.force_count(); ++i) forces.insert(world.force_id(i));
  Json out = head_;
  for (const auto& [list, ids] : wired_) {
    const std::set<std::int64_t>& there = list == "forces" ? forces : links;
    Json kept = Json::array();
    for (std::size_t i = 0; i < ids.size(); ++i)
      if (there.contains(ids[i])) kept.push_back(head_.at(list).at(i));
    out[list] = kept;
  }
  const auto aimed = [&](const std::string& name, const std::optional<DriveAim>& aim, const char* key,
                         const std::string& joint) {
    if (!aim) return;
    Json edit = {{"at", 0}, {"set_drive", name}, {"target", aim->position}, {"target_velocity", aim->velocity}};
    if (key != nullptr) edit[key] = joint;
    out["timeline"].push_back(std::move(edit));
  };
  for (int i = 0; i < world.attachment_count(); ++i)
    if (world.aim(i)) aimed(world.attachment(i).name, world.aim(i), nullptr, {});
  for (int b = 0; b < world.body_count(); ++b)
    for (int d = 0; !world.removed(b) && d < static_cast<int>(world.drives(b).size()); ++d)
      aimed(world.body(b).name(), world.aim(b, d), "joint", world.drives(b)[static_cast<std::size_t>(d)]);
  return out;
}

void Session::check_attachment(int attachment) const {
  if (attachment < 0 || attachment >= world_->attachment_count())
    throw InputError(fmt::format("attachment {}: there are {}", attachment, world_->attachment_count()));
}

void Session::detach(int attachment) {
  const Busy busy(*this);
  check_attachment(attachment);
  world_->detach(attachment);
}

void Session::remove_force(const std::string& name) {
  const Busy busy(*this);
  const std::vector<std::int64_t>& ids = wired_["forces"];
  std::string there;
  for (int i = 0; i < world_->force_count(); ++i) {
    const auto entry = std::ranges::find(ids, world_->force_id(i));
    if (entry == ids.end()) continue;
    const auto of = head_.at("forces").at(static_cast<std::size_t>(entry - ids.begin())).at("name").get<std::string>();
    if (of == name) {
      world_->remove_force(i);
      return;
    }
    there += (there.empty() ? "\"" : ", \"") + of + "\"";
  }
  throw InputError(fmt::format("remove_force: \"{}\" is not one of the world's forces; those are {}", name,
                               there.empty() ? "none" : there));
}

void Session::set_drive(int attachment, double position, double velocity) {
  const Busy busy(*this);
  check_attachment(attachment);
  world_->set_drive(attachment, position, velocity);
}

void Session::aim_drives(int body, int first, std::span<const double> position, std::span<const double> velocity) {
  const Busy busy(*this);
  if (first == 0 && position.size() == world_->drives(body).size())
    world_->set_drives(body, position, velocity);
  else
    world_->set_drive(body, first, position[0], velocity.empty() ? 0.0 : velocity[0]);
}

}  // namespace brim::python
