#include "brim/scene/parameters.h"

#include <set>
#include <vector>

#include "brim/core/error.h"
#include "brim/scene/errors.h"
#include "brim/scene/expression.h"

namespace brim {

namespace {

/// Parameters that one may be computed from, one from the other; values that all of them may write into a scene.
constexpr std::size_t kLongestChain = 200, kMostWritten = 1'000'000;

bool is_expression(const Json& value) {
  return value.is_string() && value.get_ref<const std::string&>().starts_with("=");
}

/// A parameter cannot be computed for a reason that is collected already.
struct Told : InputError {
  Told() : InputError("a parameter that it names is wrong") {}
};

/// The parameters of one document; each is computed when it is first asked for.
class Parameters {
 public:
  Parameters(const Document& document, const Json& given, ErrorList& errors) {
    for (const auto& [name, value] : given.items()) {
      const bool described = value.is_object();
      const std::string at = "/parameters/" + pointer_token(name);
      given_[name] = described ? value.value("value", Json()) : value;
      if (!described || value.contains("value")) continue;
      errors.add(at, document.place(at) + ": the key \"value\" is missing; a parameter is a value, or has one");
      failed_.insert(name);
    }
  }

  bool has(const std::string& name) const { return given_.contains(name); }
  /// @throws InputError  when the value is of another type
  void set(const std::string& name, const Json& value) {
    Json& slot = given_.at(name);
    const bool same = slot.type() == value.type() || (slot.is_number() && value.is_number()) || is_expression(slot) ||
                      is_expression(value);
    if (!same)
      throw InputError(fmt::format("the parameter \"{}\" is {} in the scene; {} is of another type", name, shown(slot),
                                   shown(value)));
    slot = value;
  }

  Json value(const std::string& name) {
    if (const auto done = values_.find(name); done != values_.end()) return done->second;
    if (failed_.contains(name)) throw Told();
    const auto it = given_.find(name);
    if (it == given_.end()) throw unknown(name);
    if (!open_.insert(name).second) throw InputError(fmt::format("the parameter \"{}\" is computed from itself", name));
    if (open_.size() > kLongestChain)
      throw InputError(
          fmt::format("the parameter \"{}\" is computed from a chain of more than {} others", name, kLongestChain));
    Json value = it->second;
    if (is_expression(value)) value = evaluated(value.get<std::string>());
    open_.erase(name);
    return values_[name] = value;
  }

  Json evaluated(const std::string& text) {
    if (text.starts_with("==")) return text.substr(1);
    try {
      return evaluate(std::string_view(text).substr(1), [this](const std::string& name) { return value(name); });
    } catch (const Told&) {
      open_.clear();
      throw;
    } catch (const InputError& e) {
      open_.clear();
      throw InputError(fmt::format("\"{}\" is not allowed: {}", text, e.what()));
    }
  }

  InputError unknown(const std::string& name) const {
    std::vector<std::string> names;
    std::string list;
    for (const auto& [k, unused] : given_) {
      names.push_back(k);
      list += (list.empty() ? "" : ", ") + k;
    }
    if (names.empty())
      return InputError(fmt::format("there is no parameter \"{}\"; the scene has no \"parameters\"", name));
    const std::string near = nearest_word(name, names);
    return InputError(fmt::format("there is no parameter \"{}\"{}; the scene has {}", name,
                                  near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near), list));
  }

  /// Of a value that a parameter was put in for. @throws InputError  where they all become too large
  void count(const Json& value) {
    written_ += value.is_structured() ? value.size() : 1;
    if (written_ > kMostWritten)
      throw InputError(fmt::format("the parameters of the scene write more than {} values into it", kMostWritten));
  }

  /// All that can be computed; what cannot is collected once, not again wherever it is used.
  Json all(const Document& document, ErrorList& errors) {
    Json values = Json::object();
    for (const auto& [name, unused] : given_) {
      const std::string at = "/parameters/" + pointer_token(name);
      try {
        values[name] = value(name);
      } catch (const Told&) {
        failed_.insert(name);
      } catch (const InputError& e) {
        errors.add(at, document.place(at) + ": " + e.what());
        failed_.insert(name);
      }
    }
    return values;
  }

 private:
  std::map<std::string, Json> given_, values_;
  std::set<std::string> open_;    ///< being computed
  std::set<std::string> failed_;  ///< told already
  std::size_t written_ = 0;
};

void substitute(const Document& doc, Json& value, const std::string& at, Parameters& parameters, ErrorList& errors) {
  if (is_expression(value)) {
    try {
      value = parameters.evaluated(value.get<std::string>());
      parameters.count(value);
    } catch (const Told&) {
      errors.mark(at);
    } catch (const InputError& e) {
      errors.add(at, doc.place(at) + ": " + e.what());
    }
  } else if (value.is_object()) {
    for (auto& [key, member] : value.items())
      substitute(doc, member, at + "/" + pointer_token(key), parameters, errors);
  } else if (value.is_array()) {
    for (std::size_t i = 0; i < value.size(); ++i)
      substitute(doc, value[i], at + "/" + std::to_string(i), parameters, errors);
  }
}

/// Puts a value where a pointer says; its last key may be new, and so may the scene's "world".
void set_at(Json& root, const std::string& pointer, const Json& value) {
  const auto cut = pointer.rfind('/');
  try {
    if (pointer.starts_with("/world/") && root.is_object()) root.emplace("world", Json::object());
    Json& parent = cut == 0 ? root : root.at(Json::json_pointer(pointer.substr(0, cut)));
    if (parent.is_array() && !root.contains(Json::json_pointer(pointer))) throw InputError("");
    if (!parent.is_structured()) throw InputError("");
    root[Json::json_pointer(pointer)] = value;
  } catch (const std::exception&) {
    throw InputError(fmt::format("{}: the scene has no such place; a pointer is written as /world/time_step", pointer));
  }
}

/// Writes the seed that a repeat, a heap of grains, a particle fluid or a blob has where it is left out.
void tell_seed(Json& value) {
  if (value.contains("repeat") && value["repeat"].is_object()) value["repeat"].emplace("seed", 1);
  const Json kind = value.value("kind", Json());
  if (kind == "blob" || kind == "particle_fluid" || (kind == "points" && value.contains("radius")))
    value.emplace("seed", 1);
}

/// Whether a value has "seed", said or not; adds to each.
bool add_to_seeds(Json& value, std::uint64_t more) {
  bool found = false;
  if (value.is_object()) {
    tell_seed(value);
    for (auto& [key, member] : value.items()) {
      if (key == "seed" && member.is_number_integer()) {
        member = member.get<std::uint64_t>() + more;
        found = true;
      } else {
        found = add_to_seeds(member, more) || found;
      }
    }
  } else if (value.is_array()) {
    for (Json& item : value) found = add_to_seeds(item, more) || found;
  }
  return found;
}

}  // namespace

std::pair<std::string, Json> read_setting(const std::string& text) {
  const auto cut = text.find('=');
  if (cut == std::string::npos || cut == 0)
    throw InputError(fmt::format("--set {}: must be name=value, as in --set h=0.02", text));
  const std::string name = text.substr(0, cut), value = text.substr(cut + 1);
  if (!Json::accept(value)) return {name, value};
  return {name, parse_document(value, "--set " + name).root};
}

void apply_parameters(Document& document, const SceneSettings& settings, ErrorList& errors) {
  if (!document.root.is_object()) return;
  Json given = Json::object();
  if (document.root.contains("parameters")) {
    given = document.root.at("parameters");
    document.root.erase("parameters");
    if (!given.is_object()) {
      errors.add("/parameters", fmt::format("{}: {} is not allowed; must be an object of values by name",
                                            document.place("/parameters"), shown(given)));
      given = Json::object();
    }
  }
  Parameters parameters(document, given, errors);
  const auto set = [&](const std::string& name, const Json& value) {
    errors.attempt("", [&] {
      try {
        if (name.starts_with('/'))
          set_at(document.root, name, value);
        else if (!parameters.has(name))
          throw parameters.unknown(name);
        else
          parameters.set(name, value);
      } catch (const InputError& e) {
        throw InputError(fmt::format("{}: set {}: {}", document.file, name, e.what()));
      }
    });
  };
  for (const auto& [name, value] : settings.set) set(name, value);
  if (settings.seed && parameters.has("seed")) set("seed", *settings.seed);
  document.parameters = parameters.all(document, errors);
  substitute(document, document.root, "", parameters, errors);
}

void apply_seed(Document& document, std::uint64_t seed) {
  if (document.parameters.is_object() && document.parameters.contains("seed")) return;
  if (seed < 1) throw InputError(document.file + ": seed 0 is not allowed; 1 is the scene as it is written");
  Json bodies = document.root.contains("bodies") ? document.root.at("bodies") : Json();
  const bool found = add_to_seeds(bodies, seed - 1);
  if (found && seed > 1) document.root["bodies"] = std::move(bodies);
  if (!found)
    throw InputError(document.file +
                     ": nothing of the scene is random; a seed needs a \"repeat\", grains, a particle fluid, a blob, "
                     "or a parameter \"seed\"");
}

}  // namespace brim
