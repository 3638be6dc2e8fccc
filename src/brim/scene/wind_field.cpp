#include "brim/scene/wind_field.h"

#include <array>
#include <map>
#include <string>
#include <vector>

#include "brim/scene/formula.h"
#include "brim/scene/motion.h"
#include "brim/scene/validate.h"

namespace brim {

namespace {

const std::vector<std::string> kVariables = {"x", "y", "z", "t"};

std::map<std::string, double> read_constants(const Node& constants) {
  std::map<std::string, double> values;
  for (const auto& [name, value] : constants.json().items()) {
    const Node n = constants.at(name.c_str());
    if (std::ranges::find(kVariables, name) != kVariables.end() || name == "pi")
      throw n.error(fmt::format("\"{}\" has a meaning already; take another name", name));
    if (!value.is_number()) throw n.error(fmt::format("{} is not allowed; must be a number", shown(value)));
    values[name] = value.get<double>();
  }
  return values;
}

}  // namespace

WindField read_wind_field(const Node& field) {
  const std::map<std::string, double> constants = read_constants(field.at("constants"));
  const auto meaning_of = [&](const std::string& name) -> Formula::Meaning {
    for (std::size_t i = 0; i < kVariables.size(); ++i)
      if (name == kVariables[i]) return Formula::Variable{static_cast<int>(i)};
    if (const auto known = constants.find(name); known != constants.end()) return known->second;
    std::vector<std::string> words = kVariables;
    for (const auto& [word, unused] : constants) words.push_back(word);
    const std::string near = nearest_word(name, words);
    throw InputError(fmt::format("\"{}\" is neither x, y, z or t nor one of \"constants\"{}", name,
                                 near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
  };
  std::vector<Formula> along;
  for (std::size_t a = 0; a < 3; ++a) {
    const Node n = field.at("velocity").at(a);
    const std::string text = n.json().is_string() ? n.string() : fmt::format("{:.17g}", n.number());
    along.push_back(n.placed([&] { return Formula(text, meaning_of); }));
  }
  const bool turns = field.has("transform") && field.at("transform").has("rotation");
  const Mat3 R = turns ? read_rotation(field.at("transform").at("rotation")).toRotationMatrix() : Mat3::Identity();
  const Vec3 p = field.has("transform") ? field.at("transform").vec3("position") : Vec3(Vec3::Zero());
  return [along, R, p](double time, std::span<const Vec3> x, std::span<Vec3> velocity) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Vec3 at = R.transpose() * (x[i] - p);
      const std::array<double, 4> variables = {at.x(), at.y(), at.z(), time};
      velocity[i] += R * Vec3(along[0](variables), along[1](variables), along[2](variables));
    }
  };
}

}  // namespace brim
