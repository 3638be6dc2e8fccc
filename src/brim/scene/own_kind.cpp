#include "brim/scene/own_kind.h"

#include <fmt/format.h>

#include "brim/scene/kinds.h"
#include "brim/scene/node.h"
#include "brim/scene/solid.h"
#include "brim/scene/validate.h"

namespace brim {

namespace {

class OwnBodyMaker final : public BodyMaker {
 public:
  OwnBodyMaker(const Node& n, const BuildContext& context, const OwnMaker& make)
      : node_(n), material_(context.material), world_(context.world), make_(make) {}
  std::unique_ptr<Body> body(const Placement& place) const override {
    return node_.placed([&] { return make_(OwnEntry(node_, place, material_, world_)); });
  }

 private:
  Node node_;
  Material material_;
  WorldOptions world_;
  OwnMaker make_;
};

/// The branch of "body" for a kind: its own keys and those of a rigid body that concern any free body.
Json branch_of(const std::string& name, const Json& keys) {
  Json branch = {{"type", "object"}, {"description", "A kind of one's own."}, {"properties", Json::object()}};
  const Json& common = scene_schema().at("$defs").at("rigid").at("properties");
  for (const char* key : {"name", "material", "voxel_size", "transform", "velocity", "repeat", "angular_velocity"})
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

bool OwnEntry::has(const char* key) const { return node_.has(key); }
double OwnEntry::number(const char* key) const { return node_.number(key); }
bool OwnEntry::boolean(const char* key) const { return node_.boolean(key); }
std::string OwnEntry::string(const char* key) const { return node_.string(key); }
Vec3 OwnEntry::vec3(const char* key) const { return node_.vec3(key); }
std::string OwnEntry::path(const char* key) const { return scene_path(node_.at(key)); }
InputError OwnEntry::error(const char* key, const std::string& message) const { return node_.at(key).error(message); }

bool add_body_kind(const std::string& name, std::string_view keys, OwnMaker make) {
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
  return true;
}

}  // namespace brim
