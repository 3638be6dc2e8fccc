#include "brim/scene/formula.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>

#include "brim/core/error.h"

namespace brim {

namespace {

constexpr std::size_t kMaxLength = 1000;
constexpr int kMaxNesting = 50;
/// Values that wait at one time: each level of nesting holds a sum, a product and a power at most.
constexpr int kMaxWaiting = 4 * kMaxNesting;

}  // namespace

/// Recursive descent, which writes postfix: sum -> product -> power -> factor.
class FormulaParser {
 public:
  using Op = Formula::Op;
  FormulaParser(std::string_view text, const std::function<Formula::Meaning(const std::string&)>& meaning_of,
                std::vector<Formula::Item>& out)
      : text_(text), meaning_of_(meaning_of), out_(out) {}

  void whole() {
    sum();
    if (peek() != '\0') throw error("what comes there is not understood");
  }

 private:
  static const std::map<std::string, Formula::Function, std::less<>>& functions() {
    static const std::map<std::string, Formula::Function, std::less<>> all = {
        {"sqrt", std::sqrt}, {"exp", std::exp}, {"log", std::log},     {"sin", std::sin},   {"cos", std::cos},
        {"tan", std::tan},   {"abs", std::abs}, {"floor", std::floor}, {"ceil", std::ceil}, {"round", std::round}};
    return all;
  }
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
  void put(Op op) { out_.push_back({op}); }

  void sum() {
    product();
    for (;;) {
      if (take('+'))
        product(), put(Op::Add);
      else if (take('-'))
        product(), put(Op::Subtract);
      else
        return;
    }
  }
  void product() {
    signed_power();
    for (;;) {
      if (take('*'))
        signed_power(), put(Op::Multiply);
      else if (take('/'))
        signed_power(), put(Op::Divide);
      else
        return;
    }
  }
  void signed_power() {
    if (++depth_ > kMaxNesting) throw error(fmt::format("it is nested deeper than {} levels", kMaxNesting));
    if (take('-')) {
      signed_power(), put(Op::Negate);
    } else {
      take('+');
      power();
    }
    --depth_;
  }
  void power() {
    factor();
    if (take('^')) signed_power(), put(Op::Power);
  }
  void factor() {
    if (take('(')) {
      sum();
      need(')');
      return;
    }
    const char c = peek();
    if (std::isdigit(static_cast<unsigned char>(c)) || c == '.')
      number();
    else if (std::isalpha(static_cast<unsigned char>(c)) || c == '_')
      named();
    else
      throw error("a number, a name or \"(\" is missing");
  }
  void number() {
    double x = 0.0;
    const auto [end, bad] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), x);
    if (bad != std::errc()) throw error("the number cannot be read");
    at_ = static_cast<std::size_t>(end - text_.data());
    out_.push_back({Op::Number, x});
  }
  void named() {
    const std::size_t first = at_;
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) || text_[at_] == '_')) ++at_;
    const std::string name(text_.substr(first, at_ - first));
    if (peek() == '(') {
      call(name);
    } else if (name == "pi") {
      out_.push_back({Op::Number, std::numbers::pi});
    } else {
      const Formula::Meaning meaning = meaning_of_(name);
      if (const auto* variable = std::get_if<Formula::Variable>(&meaning))
        out_.push_back({Op::Variable, 0.0, variable->index});
      else
        out_.push_back({Op::Number, std::get<double>(meaning)});
    }
  }
  void call(const std::string& name) {
    need('(');
    sum();
    const bool least = name == "min", most = name == "max";
    int arguments = 1;
    for (; take(','); ++arguments) {
      sum();
      put(most ? Op::Max : Op::Min);
    }
    need(')');
    if (least || most) return;
    const auto f = functions().find(name);
    if (f == functions().end()) {
      std::string known = "min, max";
      for (const auto& [k, unused] : functions()) known += ", " + k;
      throw InputError(fmt::format("\"{}\" is no function; there are {}", name, known));
    }
    if (arguments != 1) throw InputError(fmt::format("{} takes one number, not {}", name, arguments));
    out_.push_back({Op::Call, 0.0, 0, f->second});
  }

  std::string_view text_;
  const std::function<Formula::Meaning(const std::string&)>& meaning_of_;
  std::vector<Formula::Item>& out_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

Formula::Formula(std::string_view text, const std::function<Meaning(const std::string&)>& meaning_of) {
  if (text.size() > kMaxLength) throw InputError(fmt::format("the expression has more than {} letters", kMaxLength));
  FormulaParser(text, meaning_of, items_).whole();
}

double Formula::operator()(std::span<const double> variables) const {
  std::array<double, kMaxWaiting> waiting;
  std::size_t n = 0;
  for (const Item& item : items_) {
    if (item.op == Op::Number || item.op == Op::Variable) {
      waiting[n++] = item.op == Op::Number ? item.number : variables[static_cast<std::size_t>(item.variable)];
      continue;
    }
    double& top = waiting[n - 1];
    if (item.op == Op::Negate || item.op == Op::Call) {
      top = item.op == Op::Negate ? -top : item.function(top);
      continue;
    }
    const double right = top;
    double& left = waiting[--n - 1];
    switch (item.op) {
      case Op::Add:
        left += right;
        break;
      case Op::Subtract:
        left -= right;
        break;
      case Op::Multiply:
        left *= right;
        break;
      case Op::Divide:
        left /= right;
        break;
      case Op::Power:
        left = std::pow(left, right);
        break;
      case Op::Min:
        left = std::min(left, right);
        break;
      default:
        left = std::max(left, right);
        break;
    }
  }
  return waiting[0];
}

}  // namespace brim
