#include "brim/scene/materials.h"

#include <algorithm>
#include <vector>

#include "brim/scene/presets.h"

namespace brim {

Response read_response(const Node& n) {
  const std::string word = n.has("response") ? n.string("response") : "";
  return word == "constraint" ? Response::Constraint : word == "penalty" ? Response::Penalty : Response::Inherit;
}

std::map<std::string, Material> read_materials(const Node& n) {
  std::map<std::string, Material> materials;
  materials["default"] = Material{};
  materials["fluid"] = Material{"fluid", 0.0};
  for (const auto& [name, value] : n.json().items()) {
    const Node m = n.at(name.c_str());
    materials[name] = Material{name, m.number("friction"), m.number("restitution"), Response::Inherit,
                               m.number("rolling_resistance")};
  }
  return materials;
}

std::string material_of_kind(const std::string& kind) {
  return kind == "particle_fluid" || kind == "grid_fluid" ? "fluid" : "default";
}

namespace {

/// How a scene gets a material from a preset of about that name; "" where there is none.
std::string preset_hint(const std::string& name) {
  const std::vector<std::string> presets = material_preset_names();
  const std::string preset = nearest_word(name, presets);
  if (preset.empty()) return "";
  std::string list;
  for (const std::string& p : presets) list += (list.empty() ? "" : ", ") + p;
  return fmt::format("; there is a preset: \"materials\": {{\"{}\": {{\"preset\": \"{}\"}}}} (presets: {})", preset,
                     preset, list);
}

}  // namespace

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
                            near.empty() ? preset_hint(name) : fmt::format("; did you mean \"{}\"?", near)));
}

void read_pair(const Node& pair, const std::map<std::string, Material>& materials, WorldOptions& world) {
  const Node names = pair.at("materials");
  std::string a = names.at(std::size_t{0}).string(), b = names.at(std::size_t{1}).string();
  need_material(names.at(std::size_t{0}), a, materials);
  need_material(names.at(std::size_t{1}), b, materials);
  if (a > b) std::swap(a, b);
  const auto keys = {"friction", "stiffness", "restitution", "response", "rolling_resistance"};
  if (std::none_of(keys.begin(), keys.end(), [&](const char* key) { return pair.has(key); }))
    throw pair.error(
        "the pair says nothing; give one or more of \"friction\", \"stiffness\", \"restitution\", "
        "\"response\", \"rolling_resistance\"");
  PairMaterial m;
  if (pair.has("friction")) m.friction = pair.number("friction");
  if (pair.has("stiffness")) m.stiffness = pair.number("stiffness");
  if (pair.has("restitution")) m.restitution = pair.number("restitution");
  if (pair.has("rolling_resistance")) m.rolling_resistance = pair.number("rolling_resistance");
  m.response = read_response(pair);
  if (!world.pair_materials.emplace(std::make_pair(a, b), m).second)
    throw pair.error(fmt::format("the pair \"{}\" and \"{}\" is given twice; once is allowed", a, b));
}

}  // namespace brim
