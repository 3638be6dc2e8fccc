#include "brim/scene/expression.h"

#include <cctype>
#include <cmath>

#include "brim/core/error.h"
#include "brim/scene/formula.h"

namespace brim {

namespace {

bool is_name(std::string_view text) {
  if (text.empty() || std::isdigit(static_cast<unsigned char>(text.front()))) return false;
  for (const char c : text)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_') return false;
  return text != "pi";
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

}  // namespace

Json evaluate(std::string_view given, const ValueOf& value_of) {
  const std::string_view text = trimmed(given);
  if (is_name(text)) return value_of(std::string(text));
  const Formula formula(text, [&](const std::string& name) -> Formula::Meaning {
    const Json value = value_of(name);
    if (!value.is_number())
      throw InputError(fmt::format("the parameter \"{}\" is {}, no number to compute with", name, shown(value)));
    return value.get<double>();
  });
  const double x = formula({});
  if (!std::isfinite(x)) throw InputError("the value is not finite");
  // Whole numbers stay whole, for keys that count.
  if (std::abs(x) < 9e15 && x == std::floor(x)) return static_cast<std::int64_t>(x);
  return x;
}

}  // namespace brim
