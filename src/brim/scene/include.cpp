#include "brim/scene/include.h"

#include <filesystem>
#include <set>
#include <vector>

#include "brim/scene/errors.h"
#include "brim/scene/materials.h"
#include "brim/scene/motion.h"
#include "brim/scene/moved_entry.h"
#include "brim/scene/node.h"
#include "brim/scene/parameters.h"
#include "brim/scene/solid.h"
#include "brim/scene/validate.h"

namespace brim {

namespace {

constexpr std::size_t kMaxIncludes = 8, kMaxFiles = 1000;

/// Keys of an included scene that say nothing about its bodies.
const std::set<std::string> kOfTheWhole = {"$schema",         "brim",     "name",  "description", "world", "frames",
                                           "steps_per_frame", "duration", "expect"};
const std::set<std::string> kTaken = {"bodies",      "materials", "pairs",  "groups",  "filters",
                                      "attachments", "joints",    "forces", "sensors", "timeline"};

/// The files that are being read, each by the one before, and how many there were.
struct Reading {
  std::vector<std::filesystem::path> open;
  std::size_t files = 0;
};

/// "include" alone, held against its part of the schema. @param errors  what is wrong is added to it
Document checked_list(const Document& document, ErrorList& errors) {
  Document part = document;
  part.root = {{"include", document.root.at("include")}};
  const Json& scene = scene_schema();
  const Json schema = {{"type", "object"},
                       {"properties", {{"include", scene.at("properties").at("include")}}},
                       {"$defs", scene.at("$defs")}};
  validate(part, schema, errors);
  return part;
}

void take_paths(Json& value, const std::filesystem::path& folder) {
  static const std::set<std::string> kPaths = {"file", "mesh", "tet_mesh", "urdf"};
  if (value.is_array())
    for (Json& item : value) take_paths(item, folder);
  if (!value.is_object()) return;
  for (auto& [key, member] : value.items()) {
    if (!kPaths.contains(key) || !member.is_string()) {
      take_paths(member, folder);
      continue;
    }
    const auto path = member.get<std::string>();
    if (!path.starts_with("${") && std::filesystem::path(path).is_relative())
      member = (folder / path).lexically_normal().string();
  }
}

/// Adds one included document to the including one.
class Merger {
 public:
  Merger(Document& into, const std::shared_ptr<const Document>& from, const Node& entry)
      : into_(into), from_(from), entry_(entry), prefix_(entry.string("prefix")) {}

  void merge() {
    for (const auto& [key, unused] : from_->root.items())
      if (!kOfTheWhole.contains(key) && !kTaken.contains(key))
        throw InputError(
            fmt::format("{}: \"{}\" of a scene that is included cannot be taken over", from_->place("/" + key), key));
    if (from_->root.contains("materials")) materials();
    if (from_->root.contains("pairs")) pairs();
    bodies();
    groups();
    entries("filters", [&](Json& filter, const Node& written) {
      prefix_all(filter, "between");
      if (entry_.has("transform")) move_link(filter, entry_.at("transform"), written);
    });
    for (const char* list : {"attachments", "joints"})
      entries(list, [&](Json& link, const Node& written) {
        for (const char* key : {"name", "body", "to"}) prefix_one(link, key);
        if (entry_.has("transform")) move_link(link, entry_.at("transform"), written);
      });
    entries("forces", [&](Json& force, const Node& written) {
      prefix_one(force, "name");
      prefix_all(force, "bodies");
      if (!force.contains("bodies") || force["bodies"].empty()) force["bodies"] = movable();
      if (entry_.has("transform")) move_link(force, entry_.at("transform"), written);
    });
    entries("sensors", [&](Json& sensor, const Node& written) {
      for (const char* key : {"name", "body", "with", "to", "link"}) {
        prefix_one(sensor, key);
        prefix_all(sensor, key);
      }
      if (entry_.has("transform")) move_link(sensor, entry_.at("transform"), written);
    });
    timeline();
  }

 private:
  void prefix_one(Json& owner, const char* key) const {
    if (owner.contains(key) && owner[key].is_string()) owner[key] = prefix_ + owner[key].get<std::string>();
  }
  void prefix_all(Json& owner, const char* key) const {
    if (owner.contains(key) && owner[key].is_array())
      for (Json& word : owner[key])
        if (word.is_string()) word = prefix_ + word.get<std::string>();
  }

  /// Names of the file's bodies that are no obstacles.
  Json movable() const {
    Json names = Json::array();
    if (from_->root.contains("bodies") && from_->root.at("bodies").is_array())
      for (const Json& body : from_->root.at("bodies"))
        if (body.is_object() && body.value("kind", Json()) != "obstacle" && body.contains("name") &&
            body.at("name").is_string())
          names.push_back(prefix_ + body.at("name").get<std::string>());
    return names;
  }

  /// Edits of its bodies and of what it wires up; gravity belongs to the world, which is not taken over.
  void timeline() {
    const auto keep = [](const Json& edit) { return !edit.is_object() || !edit.contains("gravity"); };
    entries(
        "timeline",
        [&](Json& edit, const Node& written) {
          for (const char* verb :
               {"freeze", "thaw", "remove", "move", "detach", "set_velocity", "set_material", "set_drive", "grab"})
            prefix_one(edit, verb);
          if (edit.contains("material") && edit["material"].is_string())
            edit["material"] = material(edit["material"].get<std::string>());
          if (entry_.has("transform")) move_edit(edit, entry_.at("transform"), written);
        },
        keep);
  }

  /// Takes over the entries of a list, each changed. @param change  of an entry and where it is written
  /// @param keep  false for an entry that stays behind
  template <class Change, class Keep = bool (*)(const Json&)>
  void entries(
      const char* list, const Change& change, const Keep& keep = [](const Json&) { return true; }) {
    if (!from_->root.contains(list)) return;
    const Json& given = from_->root.at(list);
    if (!given.is_array())
      throw InputError(
          fmt::format("{}: {} is not allowed; must be a list", from_->place(std::string("/") + list), shown(given)));
    Json& all = into_.root[list];
    if (all.is_null()) all = Json::array();
    for (std::size_t i = 0; i < given.size(); ++i) {
      if (!keep(given[i])) continue;
      const std::string at = fmt::format("/{}/{}", list, i);
      Json entry = given[i];
      if (entry.is_object()) change(entry, Node(*from_, given[i], at));
      into_.origins[fmt::format("/{}/{}", list, all.size())] = {from_, at};
      all.push_back(std::move(entry));
    }
  }

  void groups() {
    if (!from_->root.contains("groups") || !from_->root.at("groups").is_object()) return;
    Json& all = into_.root["groups"];
    if (all.is_null()) all = Json::object();
    for (const auto& [name, members] : from_->root.at("groups").items()) {
      Json group = {{"members", members}};
      prefix_all(group, "members");
      const std::string key = prefix_ + name, at = "/groups/" + pointer_token(name);
      if (all.contains(key) && all.at(key) != group["members"])
        throw InputError(
            fmt::format("{}: the group \"{}\" is there already and differs; a \"prefix\" keeps the two apart",
                        from_->place(at), key));
      all[key] = group["members"];
      into_.origins["/groups/" + pointer_token(key)] = {from_, at};
    }
  }

  std::string material(const std::string& name) const {
    const bool own = from_->root.contains("materials") && from_->root.at("materials").contains(name);
    return own ? prefix_ + name : name;
  }

  /// Names the material of a body without one, where the file has its own of that name.
  void name_material(Json& body) const {
    const std::string usual = material_of_kind(body["kind"].get<std::string>()), own = material(usual);
    if (own != usual) body["material"] = own;
  }

  void materials() {
    Json& all = into_.root["materials"];
    if (all.is_null()) all = Json::object();
    for (const auto& [name, value] : from_->root.at("materials").items()) {
      const std::string key = prefix_ + name, at = "/materials/" + pointer_token(name);
      if (all.contains(key) && all.at(key) != value)
        throw InputError(
            fmt::format("{}: the material \"{}\" is there already and differs; a \"prefix\" keeps the two apart",
                        from_->place(at), key));
      all[key] = value;
      into_.origins["/materials/" + pointer_token(key)] = {from_, at};
    }
  }

  void pairs() {
    Json& all = into_.root["pairs"];
    if (all.is_null()) all = Json::array();
    const Json& given = from_->root.at("pairs");
    for (std::size_t i = 0; i < given.size(); ++i) {
      Json pair = given[i];
      if (pair.is_object() && pair.contains("materials") && pair["materials"].is_array())
        for (Json& name : pair["materials"])
          if (name.is_string()) name = material(name.get<std::string>());
      if (std::find(all.begin(), all.end(), pair) != all.end()) continue;
      into_.origins[fmt::format("/pairs/{}", all.size())] = {from_, fmt::format("/pairs/{}", i)};
      all.push_back(std::move(pair));
    }
  }

  void bodies() {
    if (!from_->root.contains("bodies")) return;
    const Json& given = from_->root.at("bodies");
    if (!given.is_array())
      throw InputError(
          fmt::format("{}: {} is not allowed; must be a list of bodies", from_->place("/bodies"), shown(given)));
    Json& all = into_.root["bodies"];
    if (all.is_null()) all = Json::array();
    const auto folder = std::filesystem::path(entry_.string("file")).parent_path();
    for (std::size_t i = 0; i < given.size(); ++i) {
      const std::string at = fmt::format("/bodies/{}", i);
      Json body = given[i];
      if (body.is_object()) {
        if (body.contains("name") && body["name"].is_string()) body["name"] = prefix_ + body["name"].get<std::string>();
        if (body.contains("material") && body["material"].is_string())
          body["material"] = material(body["material"].get<std::string>());
        else if (!body.contains("material") && body.contains("kind") && body["kind"].is_string())
          name_material(body);
        take_paths(body, folder);
        if (entry_.has("transform")) move_entry(body, entry_.at("transform"), Node(*from_, given[i], at));
      }
      into_.origins[fmt::format("/bodies/{}", all.size())] = {from_, at};
      all.push_back(std::move(body));
    }
  }

  Document& into_;
  const std::shared_ptr<const Document>& from_;
  const Node& entry_;
  std::string prefix_;
};

bool include_all(Document& document, Reading& reading, ErrorList errors);

void include_one(Document& document, const Node& entry, Reading& reading) {
  const std::string path = scene_path(entry.at("file"));
  const auto canonical = std::filesystem::canonical(path);
  if (std::find(reading.open.begin(), reading.open.end(), canonical) != reading.open.end())
    throw entry.at("file").error(fmt::format("\"{}\" includes itself", entry.string("file")));
  if (reading.open.size() >= kMaxIncludes)
    throw entry.at("file").error(fmt::format("scenes include each other deeper than {} files", kMaxIncludes));
  if (++reading.files > kMaxFiles) throw entry.error(fmt::format("more than {} files are included", kMaxFiles));
  auto from = std::make_shared<Document>(read_document(path));
  SceneSettings settings;
  if (entry.has("set"))
    for (const auto& [name, value] : entry.at("set").json().items()) settings.set[name] = value;
  ErrorList errors;
  entry.placed([&] {
    apply_parameters(*from, settings, errors);
    errors.raise();
  });
  reading.open.push_back(canonical);
  errors.attempt("", [&] { include_all(*from, reading, {}); });
  reading.open.pop_back();
  errors.raise();
  const std::shared_ptr<const Document> read = std::move(from);
  Merger(document, read, entry).merge();
}

/// @param errors  marks of entries that are wrong for a reason told elsewhere: they are passed over
/// @throws InputError, InputErrors  for all others that cannot be taken in
bool include_all(Document& document, Reading& reading, ErrorList errors) {
  if (!document.root.is_object() || !document.root.contains("include")) return false;
  const Document part = checked_list(document, errors);
  errors.raise();
  document.root.erase("include");
  const Node list(part, part.root.at("include"), "/include");
  for (std::size_t i = 0; i < list.size(); ++i)
    if (!errors.touches(list.at(i).pointer())) errors.attempt("", [&] { include_one(document, list.at(i), reading); });
  errors.raise();
  return true;
}

}  // namespace

bool apply_includes(Document& document, const ErrorList& errors) {
  Reading reading;
  std::error_code error;
  const auto self = std::filesystem::canonical(document.file, error);
  if (!error) reading.open.push_back(self);
  return include_all(document, reading, errors.marks());
}

}  // namespace brim
