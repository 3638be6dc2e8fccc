#include "brim/scene/expression.h"

#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "brim/core/error.h"

namespace brim {

namespace {

constexpr std::size_t kMaxLength = 1000;
constexpr int kMaxNesting = 50;

using Function = double (*)(double);
const std::map<std::string, Function, std::less<>> kFunctions = {
    {"sqrt", std::sqrt}, {"exp", std::exp}, {"log", std::log},     {"sin", std::sin},   {"cos", std::cos},
    {"tan", std::tan},   {"abs", std::abs}, {"floor", std::floor}, {"ceil", std::ceil}, {"round", std::round}};

/// Recursive descent: sum -> product -> power -> factor.
class Parser {
 public:
  Parser(std::string_view text, const ValueOf& value_of) : text_(text), value_of_(value_of) {}

  double whole() {
    const double x = sum();
    if (peek() != '\0') throw error("what comes there is not understood");
    return x;
  }

 private:
  InputError error(const std::string& why) const {
    return InputError(fmt::format("at character {}, {}", std::min(at_, text_.size()) + 1, why));
  }
  char peek() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool take(char c) {
    if (peek() != c) return false;
    ++at_;
    return true;
  }
  void need(char c) {
    if (!take(c)) throw error(fmt::format("a \"{}\" is missing", c));
  }

  double sum() {
    double x = product();
    for (;;) {
      if (take('+'))
        x += product();
      else if (take('-'))
        x -= product();
      else
        return x;
    }
  }
  double product() {
    double x = signed_power();
    for (;;) {
      if (take('*'))
        x *= signed_power();
      else if (take('/'))
        x /= signed_power();
      else
        return x;
    }
  }
  /// A sign binds less than a power: -2^2 is -4.
  double signed_power() {
    if (++depth_ > kMaxNesting) throw error(fmt::format("it is nested deeper than {} levels", kMaxNesting));
    const double sign = take('-') ? -1.0 : 1.0;
    if (sign > 0.0) take('+');
    const double x = sign < 0.0 ? sign * signed_power() : power();
    --depth_;
    return x;
  }
  double power() {
    const double base = factor();
    return take('^') ? std::pow(base, signed_power()) : base;
  }
  double factor() {
    if (take('(')) {
      const double x = sum();
      need(')');
      return x;
    }
    const char c = peek();
    if (std::isdigit(static_cast<unsigned char>(c)) || c == '.') return number();
    if (std::isalpha(static_cast<unsigned char>(c)) || c == '_') return named();
    throw error("a number, a name or \"(\" is missing");
  }
  double number() {
    double x = 0.0;
    const auto [end, bad] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), x);
    if (bad != std::errc()) throw error("the number cannot be read");
    at_ = static_cast<std::size_t>(end - text_.data());
    return x;
  }
  double named() {
    const std::size_t first = at_;
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) || text_[at_] == '_')) ++at_;
    const std::string name(text_.substr(first, at_ - first));
    if (peek() == '(') return call(name);
    if (name == "pi") return std::numbers::pi;
    const Json value = value_of_(name);
    if (!value.is_number())
      throw InputError(fmt::format("the parameter \"{}\" is {}, no number to compute with", name, shown(value)));
    return value.get<double>();
  }
  double call(const std::string& name) {
    need('(');
    std::vector<double> arguments = {sum()};
    while (take(',')) arguments.push_back(sum());
    need(')');
    if (name == "min" || name == "max") {
      double x = arguments.front();
      for (const double a : arguments) x = name == "min" ? std::min(x, a) : std::max(x, a);
      return x;
    }
    const auto f = kFunctions.find(name);
    if (f == kFunctions.end()) {
      std::string known = "min, max";
      for (const auto& [k, unused] : kFunctions) known += ", " + k;
      throw InputError(fmt::format("\"{}\" is no function; there are {}", name, known));
    }
    if (arguments.size() != 1) throw InputError(fmt::format("{} takes one number, not {}", name, arguments.size()));
    return f->second(arguments.front());
  }

  std::string_view text_;
  const ValueOf& value_of_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

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
  if (text.size() > kMaxLength) throw InputError(fmt::format("the expression has more than {} letters", kMaxLength));
  if (is_name(text)) return value_of(std::string(text));
  const double x = Parser(text, value_of).whole();
  if (!std::isfinite(x)) throw InputError("the value is not finite");
  // Whole numbers stay whole, for keys that count.
  if (std::abs(x) < 9e15 && x == std::floor(x)) return static_cast<std::int64_t>(x);
  return x;
}

}  // namespace brim
