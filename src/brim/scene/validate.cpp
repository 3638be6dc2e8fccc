#include "brim/scene/validate.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "brim/core/error.h"
#include "brim/scene/common_words.h"

namespace brim {

namespace {

const std::set<std::string> kKeywords = {"type",
                                         "properties",
                                         "required",
                                         "additionalProperties",
                                         "enum",
                                         "const",
                                         "minimum",
                                         "maximum",
                                         "minLength",
                                         "exclusiveMinimum",
                                         "exclusiveMaximum",
                                         "items",
                                         "minItems",
                                         "maxItems",
                                         "oneOf",
                                         "$ref",
                                         "$defs",
                                         "default",
                                         "title",
                                         "description",
                                         "$schema",
                                         "$id",
                                         "examples"};

/// "a", "a or b", "a, b or c".
std::string either(const std::vector<std::string>& words, const char* last = " or ") {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? last : ", ";
    text += words[i];
  }
  return text;
}

bool has_type(const Json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "null") return value.is_null();
  if (type == "number") return value.is_number();
  if (type == "integer")
    return value.is_number_integer() || (value.is_number() && std::trunc(value.get<double>()) == value.get<double>());
  throw ProgrammingError("schema: unknown type " + type);
}

std::string type_name(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return fmt::format("a list of {}", value.size());
  return shown(value);
}

/// The allowed word that is meant by another one.
std::string probable_word(const std::string& word, const std::vector<std::string>& allowed) {
  const std::string meant = meant_word(word, allowed);
  return meant.empty() ? nearest_word(word, allowed) : meant;
}

class Validator {
 public:
  Validator(const Document& document, const Json& schema, ErrorList& errors)
      : doc_(document), root_(schema), errors_(errors) {}

  void check(Json& value, const Json& given_schema, const std::string& at) const {
    const Json& schema = resolve(given_schema);
    for (const auto& [key, unused] : schema.items())
      if (!kKeywords.contains(key)) throw ProgrammingError("schema: the keyword " + key + " is not checked by brim");
    if (schema.contains("oneOf")) {
      check(value, branch(value, schema, at), at);
      return;
    }
    check_type(value, schema, at);
    check_choice(value, schema, at);
    if (value.is_number()) check_range(value, schema, at);
    if (value.is_string()) check_length(value, schema, at);
    if (value.is_array()) check_array(value, schema, at);
    if (value.is_object()) check_object(value, schema, at);
  }

 private:
  [[noreturn]] void fail(const std::string& at, const std::string& message) const {
    throw InputError(doc_.place(at) + ": " + message);
  }
  void note(const std::string& at, const std::string& message) const {
    errors_.add(at, doc_.place(at) + ": " + message);
  }
  /// Checks a member that nothing is known against; what is wrong with it is collected, and its neighbours are looked
  /// at.
  void check_member(Json& value, const Json& schema, const std::string& at) const {
    if (!errors_.holds(at)) errors_.attempt(at, [&] { check(value, schema, at); });
  }

  const Json& resolve(const Json& schema) const {
    const Json* s = &schema;
    while (s->contains("$ref")) {
      const std::string ref = s->at("$ref").get<std::string>();
      if (!ref.starts_with("#")) throw ProgrammingError("schema: a $ref must stay inside the file: " + ref);
      s = &root_.at(Json::json_pointer(ref.substr(1)));
    }
    return *s;
  }

  /// What a schema allows, in a few words.
  std::string allowed(const Json& given) const {
    const Json& s = resolve(given);
    if (s.contains("const")) return shown(s.at("const"));
    if (s.contains("enum")) {
      std::vector<std::string> words;
      for (const Json& v : s.at("enum")) words.push_back(shown(v));
      return (words.size() > 1 ? "one of " : "") + either(words);
    }
    if (s.contains("oneOf")) {
      std::vector<const Json*> branches;
      std::vector<std::string> words;
      for (const Json& b : s.at("oneOf")) {
        branches.push_back(&resolve(b));
        words.push_back(allowed(b));
      }
      if (const std::string key = discriminator(branches); !key.empty()) return "an object with \"" + key + "\"";
      return either(words);
    }
    const std::string type = s.value("type", "");
    if (type == "array") {
      std::string size;
      if (s.contains("minItems") && s.contains("maxItems") && s.at("minItems") == s.at("maxItems"))
        size = fmt::format("{} ", s.at("minItems").get<int>());
      const std::string of = s.contains("items") ? resolve(s.at("items")).value("type", "value") : "value";
      return fmt::format("a list of {}{}s", size, of);
    }
    if (type == "number" || type == "integer") {
      std::string text = type == "integer" ? "a whole number" : "a number";
      if (s.contains("exclusiveMinimum")) text += " above " + shown(s.at("exclusiveMinimum"));
      if (s.contains("minimum")) text += " from " + shown(s.at("minimum"));
      if (s.contains("maximum")) text += (s.contains("minimum") ? " to " : " up to ") + shown(s.at("maximum"));
      if (s.contains("exclusiveMaximum")) text += " below " + shown(s.at("exclusiveMaximum"));
      return text;
    }
    if (type == "string") return "a string";
    if (type == "boolean") return "true or false";
    if (type == "object") {
      if (!s.contains("required")) return "an object";
      std::vector<std::string> words;
      for (const Json& k : s.at("required")) words.push_back(shown(k));
      return "an object with " + either(words, " and ");
    }
    return "a value";
  }

  void check_type(const Json& value, const Json& schema, const std::string& at) const {
    if (!schema.contains("type")) return;
    if (!has_type(value, schema.at("type").get<std::string>()))
      fail(at, fmt::format("{} is not allowed; must be {}", type_name(value), allowed(schema)));
  }

  void check_choice(const Json& value, const Json& schema, const std::string& at) const {
    if (schema.contains("const") && value != schema.at("const"))
      fail(at, fmt::format("{} is not allowed; must be {}", shown(value), allowed(schema)));
    if (!schema.contains("enum")) return;
    const Json& choices = schema.at("enum");
    if (std::find(choices.begin(), choices.end(), value) != choices.end()) return;
    std::vector<std::string> words;
    for (const Json& v : choices)
      if (v.is_string()) words.push_back(v.get<std::string>());
    const std::string near = value.is_string() ? probable_word(value.get<std::string>(), words) : "";
    fail(at, fmt::format("{} is not allowed; must be {}{}", shown(value), allowed(schema),
                         near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
  }

  void check_range(const Json& value, const Json& schema, const std::string& at) const {
    const double x = value.get<double>();
    const auto bound = [&](const char* key) {
      return schema.contains(key) ? schema.at(key).get<double>() : std::nan("");
    };
    const bool bad = !std::isfinite(x) || x < bound("minimum") || x > bound("maximum") ||
                     x <= bound("exclusiveMinimum") || x >= bound("exclusiveMaximum");
    if (bad) fail(at, fmt::format("{} is not allowed; must be {}", shown(value), allowed(schema)));
  }

  void check_length(const Json& value, const Json& schema, const std::string& at) const {
    if (value.get<std::string>().size() < schema.value("minLength", std::size_t{0}))
      fail(at, fmt::format("{} is not allowed; must be a string of at least {} letters", shown(value),
                           schema.at("minLength").get<int>()));
  }

  void check_array(Json& value, const Json& schema, const std::string& at) const {
    const std::size_t least = schema.value("minItems", std::size_t{0});
    const std::size_t most = schema.value("maxItems", value.size());
    if (value.size() < least || value.size() > most) {
      const std::string count = least == most          ? fmt::format("exactly {}", least)
                                : value.size() < least ? fmt::format("at least {}", least)
                                                       : fmt::format("at most {}", most);
      const bool one = (value.size() < least ? least : most) == 1;
      fail(at,
           fmt::format("a list of {} is not allowed; must have {} {}", value.size(), count, one ? "entry" : "entries"));
    }
    if (!schema.contains("items")) return;
    for (std::size_t i = 0; i < value.size(); ++i)
      check_member(value[i], schema.at("items"), at + "/" + std::to_string(i));
  }

  void check_object(Json& value, const Json& schema, const std::string& at) const {
    const Json empty = Json::object();
    const Json& properties = schema.contains("properties") ? schema.at("properties") : empty;
    // Unknown keys first: a misspelt required key is then shown as misspelt, not as missing.
    std::set<std::string> misspelt;
    for (auto& [key, member] : value.items()) {
      const std::string below = at + "/" + pointer_token(key);
      if (properties.contains(key)) continue;
      const Json extra = schema.value("additionalProperties", Json(true));
      if (extra.is_object()) {
        check_member(member, schema.at("additionalProperties"), below);
      } else if (!extra.get<bool>()) {
        std::vector<std::string> words;
        for (const auto& [k, unused] : properties.items()) words.push_back(k);
        const RightPlace elsewhere = right_place(key, words);
        const std::string near = elsewhere.key.empty() ? probable_word(key, words) : elsewhere.key;
        misspelt.insert(near);
        const std::string hint = !elsewhere.key.empty() ? "; " + elsewhere.message
                                 : near.empty()         ? ""
                                                        : fmt::format("; did you mean \"{}\"?", near);
        note(below, fmt::format("unknown key \"{}\"{}; allowed here: {}", key, hint, either(words)));
      }
    }
    if (schema.contains("required"))
      for (const Json& key : schema.at("required"))
        if (!value.contains(key.get<std::string>()) && !misspelt.contains(key.get<std::string>()))
          note(at, fmt::format("the key {} is missing; it must be {}", shown(key),
                               allowed(properties.at(key.get<std::string>()))));
    for (const auto& [key, sub] : properties.items()) {
      if (!value.contains(key)) {
        const Json& target = resolve(sub);
        const Json* fill = sub.contains("default")      ? &sub.at("default")
                           : target.contains("default") ? &target.at("default")
                                                        : nullptr;
        if (!fill) continue;
        value[key] = *fill;
      }
      check_member(value[key], sub, at + "/" + pointer_token(key));
    }
  }

  const Json& branch(const Json& value, const Json& schema, const std::string& at) const {
    std::vector<const Json*> fitting;
    for (const Json& b : schema.at("oneOf")) {
      const Json& s = resolve(b);
      if (s.contains("oneOf") || !s.contains("type") || has_type(value, s.at("type").get<std::string>()))
        fitting.push_back(&s);
    }
    if (fitting.empty()) fail(at, fmt::format("{} is not allowed; must be {}", type_name(value), allowed(schema)));
    if (!value.is_object()) {
      for (const Json* s : fitting)
        if (accepts(value, *s)) return *s;
      fail(at, fmt::format("{} is not allowed; must be {}", type_name(value), allowed(schema)));
    }
    if (fitting.size() == 1) return *fitting.front();
    if (const std::string key = discriminator(fitting); !key.empty()) return branch_by(value, fitting, key, at);
    for (const Json* s : fitting)
      if (s->contains("required"))
        for (const Json& k : s->at("required"))
          if (value.contains(k.get<std::string>())) return *s;
    fail(at, fmt::format("{} is not allowed; must be {}", shown(value), allowed(schema)));
  }

  bool accepts(const Json& value, const Json& schema) const {
    ErrorList errors;
    const Validator alone(doc_, root_, errors);
    Json copy = value;
    alone.check_member(copy, schema, "");
    return errors.empty();
  }

  /// The property that is const in every branch, or "".
  std::string discriminator(const std::vector<const Json*>& branches) const {
    if (!branches.front()->contains("properties")) return "";
    for (const auto& [key, unused] : branches.front()->at("properties").items()) {
      const auto is_const = [&, k = key](const Json* s) {
        return s->contains("properties") && s->at("properties").contains(k) &&
               s->at("properties").at(k).contains("const");
      };
      if (std::all_of(branches.begin(), branches.end(), is_const)) return key;
    }
    return "";
  }

  const Json& branch_by(const Json& value, const std::vector<const Json*>& branches, const std::string& key,
                        const std::string& at) const {
    std::vector<std::string> words, quoted;
    for (const Json* s : branches) {
      const Json& name = s->at("properties").at(key).at("const");
      if (value.contains(key) && value.at(key) == name) return *s;
      words.push_back(name.get<std::string>());
      quoted.push_back(shown(name));
    }
    if (!value.contains(key))
      fail(at, fmt::format("the key \"{}\" is missing; it must be one of {}", key, either(quoted)));
    const Json& given = value.at(key);
    const std::string near = given.is_string() ? probable_word(given.get<std::string>(), words) : "";
    const bool body = root_.contains("$defs") && root_.at("$defs").contains("body") &&
                      &resolve(root_.at("$defs").at("body").at("oneOf").front()) == branches.front();
    fail(at + "/" + key,
         fmt::format(
             "{} is not allowed; must be one of {}{}{}", shown(given), either(quoted),
             near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near),
             body ? "; kinds of one's own come from a library: brim --plugin FILE (brim.load_plugin in Python)" : ""));
  }

  const Document& doc_;
  const Json& root_;
  ErrorList& errors_;
};

}  // namespace

void validate(Document& document, const Json& schema, ErrorList& errors) {
  Json root = std::move(document.root);
  errors.attempt("", [&] { Validator(document, schema, errors).check(root, schema, ""); });
  document.root = std::move(root);
}

void validate(Document& document, const Json& schema) {
  ErrorList errors;
  validate(document, schema, errors);
  errors.raise();
}

namespace {

Json& changeable_schema() {
  static Json schema = Json::parse(scene_schema_text());
  return schema;
}

}  // namespace

const Json& scene_schema() { return changeable_schema(); }

std::string known_schema_text() {
  return scene_schema() != Json::parse(scene_schema_text()) ? scene_schema().dump(2) + "\n" : scene_schema_text();
}

void add_body_branch(const std::string& name, Json branch) {
  Json& defs = changeable_schema().at("$defs");
  if (defs.contains(name)) throw InputError(fmt::format("kind \"{}\": the name is taken; choose another", name));
  defs[name] = std::move(branch);
  defs.at("body").at("oneOf").push_back({{"$ref", "#/$defs/" + name}});
}

}  // namespace brim
