#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace brim {

/// A numeric formula, parsed once and evaluated often: numbers, names, + - * / ^, parentheses, pi, and sqrt, exp, log,
/// sin, cos, tan, abs, floor, ceil, round, min, max (angles in radians). A sign binds less than a power.  Tests:
/// tests/scene/formula_test.cpp, tests/scene/expression_test.cpp
/// power.  Tests: tests/scene/formula_test.cpp, tests/scene/expression_test.cpp
class Formula {
 public:
  struct Variable {
    int index = 0;  ///< index in the values given at evaluation
  };
  /// Meaning of a name: a constant, or one of the variables.
  using Meaning = std::variant<double, Variable>;
  /// @param meaning_of  of a name; throws InputError for unknown ones  @throws InputError with the reason
  Formula(std::string_view text, const std::function<Meaning(const std::string&)>& meaning_of);
  /// @param variables  covering all indices  @return any double, possibly infinite or NaN
  double operator()(std::span<const double> variables) const;

 private:
  friend class FormulaParser;
  using Function = double (*)(double);
  enum class Op { Number, Variable, Add, Subtract, Multiply, Divide, Power, Negate, Min, Max, Call };
  struct Item {
    Op op;
    double number = 0.0;
    int variable = 0;
    Function function = nullptr;
  };
  std::vector<Item> items_;  ///< in postfix order
};

}  // namespace brim
