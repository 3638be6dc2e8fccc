#include "brim/scene/presets.h"

#include <vector>

#include "brim/scene/errors.h"

namespace brim {

namespace {

std::string list_of(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& w : words) text += (text.empty() ? "" : ", ") + w;
  return text;
}

/// Names of the presets that hold an entry under all the keys.
std::vector<std::string> names_with(const char* group, const std::string& kind) {
  std::vector<std::string> names;
  for (const auto& [name, preset] : material_presets().items())
    if (preset.contains(group) && (kind.empty() || preset.at(group).contains(kind))) names.push_back(name);
  return names;
}

/// Fills what `owner` does not give from its preset. @param kind  of a body, or "" for materials and pairs
void fill(const Document& doc, Json& owner, const std::string& at, const char* group, const std::string& kind,
          const char* what) {
  if (!owner.is_object() || !owner.contains("preset")) return;
  const Json given = owner.at("preset");
  owner.erase("preset");
  const std::vector<std::string> names = names_with(group, kind);
  const std::string name = given.is_string() ? given.get<std::string>() : "";
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    const std::string near = nearest_word(name, names);
    throw InputError(fmt::format("{}: {} is no preset of {}{}; there are: {}", doc.place(at + "/preset"), shown(given),
                                 what, near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near),
                                 names.empty() ? "none" : list_of(names)));
  }
  const Json& all = material_presets().at(name).at(group);
  for (const auto& [key, value] : (kind.empty() ? all : all.at(kind)).items())
    if (!owner.contains(key) && !(key == "density" && owner.contains("mass"))) owner[key] = value;
}

}  // namespace

const Json& material_presets() {
  static const Json presets = Json::parse(material_presets_text()).at("presets");
  return presets;
}

std::vector<std::string> material_preset_names() { return names_with("material", ""); }

void apply_presets(Document& document, ErrorList& errors) {
  Json& root = document.root;
  if (!root.is_object()) return;
  const auto each = [&](const char* list, const auto& f) {
    if (!root.contains(list) || !root[list].is_structured()) return;
    const std::string below = std::string("/") + list + "/";
    if (root[list].is_array())
      for (std::size_t i = 0; i < root[list].size(); ++i) f(root[list][i], below + std::to_string(i));
    else
      for (auto& [name, value] : root[list].items()) f(value, below + pointer_token(name));
  };
  each("materials", [&](Json& m, const std::string& at) {
    errors.attempt(at + "/preset", [&] { fill(document, m, at, "material", "", "a material"); });
  });
  each("pairs", [&](Json& p, const std::string& at) {
    errors.attempt(at + "/preset", [&] { fill(document, p, at, "pair", "", "a pair of materials"); });
  });
  each("bodies", [&](Json& b, const std::string& at) {
    if (!b.is_object() || !b.contains("kind") || !b["kind"].is_string()) return;
    const auto kind = b["kind"].get<std::string>();
    errors.attempt(at + "/preset",
                   [&] { fill(document, b, at, "bodies", kind, ("the kind \"" + kind + "\"").c_str()); });
  });
}

}  // namespace brim
