#include "brim/scene/own_kind.h"

#include <fmt/format.h>

#include <algorithm>

#include "brim/core/author_error.h"
#include "brim/scene/kinds.h"
#include "brim/scene/node.h"
#include "brim/scene/plugin.h"
#include "brim/scene/solid.h"
#include "brim/scene/validate.h"

namespace brim {

namespace {

class OwnBodyMaker final : public BodyMaker {
 public:
  OwnBodyMaker(const Node& n, const BuildContext& context, const OwnMaker& make)
      : node_(n), material_(context.material), world_(context.world), make_(make) {}
  std::unique_ptr<Body> body(const Placement& place) const override {
    return node_.placed([&] {
      std::unique_ptr<Body> made = asked(place);
      if (made == nullptr) throw InputError(fmt::format("the maker of kind \"{}\" gave no body (nullptr)", kind()));
      return made;
    });
  }

 private:
  std::string kind() const { return node_.string("kind"); }
  /// What the author's maker gives; what it raises names the kind.
  std::unique_ptr<Body> asked(const Placement& place) const {
    return call_author([&] { return make_(OwnEntry(node_, place, material_, world_)); },
                       [&](const std::exception& e) {
                         throw InputError(fmt::format("the maker of kind \"{}\" raised \"{}\"", kind(), e.what()));
                       });
  }

  Node node_;
  Material material_;
  WorldOptions world_;
  OwnMaker make_;
};

/// The branch of "body" for a kind: its own keys and those of a rigid body that concern any free body.
Json branch_of(const std::string& name, const Json& keys) {
  Json branch = {{"type", "object"}, {"description", "A kind of one's own."}, {"properties", Json::object()}};
  const Json& common = scene_schema().at("$defs").at("rigid").at("properties");
  for (const char* key :
       {"name", "material", "response", "voxel_size", "transform", "velocity", "repeat", "angular_velocity"})
    branch["properties"][key] = common.at(key);
  branch["properties"]["kind"] = {{"const", name}};
  branch["required"] = {"kind", "name"};
  for (const auto& [key, schema] : keys.items()) {
    if (branch["properties"].contains(key))
      throw InputError(fmt::format("kind \"{}\": the key \"{}\" is every body's; choose another word", name, key));
    branch["properties"][key] = schema;
    if (!schema.contains("default")) branch["required"].push_back(key);
  }
  branch["additionalProperties"] = false;
  return branch;
}

}  // namespace

namespace {

/// The value of a key that the maker reads. @throws InputError  when it is missing, or of another type
const Json& asked_key(const Node& n, const char* key, bool (Json::*fits)() const, const char* type) {
  const std::string kind = n.string("kind");
  if (!n.has(key))
    throw InputError(
        fmt::format("the maker of kind \"{}\" reads the key \"{}\", which is not there; "
                    "ask has(\"{}\"), or give it a default in add_body_kind",
                    kind, key, key));
  const Json& value = n.at(key).json();
  if (!(value.*fits)())
    throw InputError(fmt::format("the maker of kind \"{}\" reads the key \"{}\" as {}, but it is {}", kind, key, type,
                                 value.dump()));
  return value;
}

}  // namespace

bool OwnEntry::has(const char* key) const { return node_.has(key); }
double OwnEntry::number(const char* key) const {
  return asked_key(node_, key, &Json::is_number, "a number").get<double>();
}
bool OwnEntry::boolean(const char* key) const {
  return asked_key(node_, key, &Json::is_boolean, "true or false").get<bool>();
}
std::string OwnEntry::string(const char* key) const {
  return asked_key(node_, key, &Json::is_string, "a string").get<std::string>();
}
Vec3 OwnEntry::vec3(const char* key) const {
  const Json& list = asked_key(node_, key, &Json::is_array, "three numbers");
  if (list.size() != 3 || !std::all_of(list.begin(), list.end(), [](const Json& x) { return x.is_number(); }))
    throw InputError(fmt::format("the maker of kind \"{}\" reads the key \"{}\" as three numbers, but it is {}",
                                 node_.string("kind"), key, list.dump()));
  return node_.vec3(key);
}
std::string OwnEntry::path(const char* key) const {
  asked_key(node_, key, &Json::is_string, "a path");
  return scene_path(node_.at(key));
}
InputError OwnEntry::error(const char* key, const std::string& message) const {
  return node_.has(key) ? node_.at(key).error(message) : node_.error(fmt::format("{}: {}", key, message));
}

namespace {

void add_kind(const std::string& name, std::string_view keys, OwnMaker make, std::uint64_t layout) {
  if (layout != kOwnKindLayout)
    throw InputError(fmt::format(
        "kind \"{}\": it was built with the headers of another version of brim than this program; build it again with "
        "those of this one",
        name));
  const Document document = parse_document(keys, "keys of the kind \"" + name + "\"");
  if (!document.root.is_object())
    throw InputError(document.place("") + ": must be an object of keys and their schemas");
  add_body_branch(name, branch_of(name, document.root));
  BodyKind kind;
  kind.name = name;
  kind.check = [](const Node&) {};
  kind.make = [make = std::move(make)](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
    return std::make_unique<OwnBodyMaker>(n, c, make);
  };
  add_body_kind(std::move(kind));
}

}  // namespace

bool add_body_kind(const std::string& name, std::string_view keys, OwnMaker make, std::uint64_t layout) {
  try {
    add_kind(name, keys, std::move(make), layout);
    return true;
  } catch (const InputError& error) {
    if (!keep_plugin_error(error)) throw;
    return false;
  }
}

}  // namespace brim
