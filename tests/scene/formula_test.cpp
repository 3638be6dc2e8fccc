#include "brim/scene/formula.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>

#include "brim/core/error.h"

/// The rules of arithmetic and what is refused: tests/scene/expression_test.cpp.
namespace brim::formula_test {
namespace {

Formula::Meaning meaning_of(const std::string& name) {
  if (name == "x") return Formula::Variable{0};
  if (name == "t") return Formula::Variable{1};
  if (name == "U") return 4.0;
  throw InputError("no such name");
}

TEST(Formula, IsReadOnceAndEvaluatedWithAnyVariables) {
  const Formula f("U * (1 - exp(-t)) * max(0, 1 - (x/2)^2, min(x, t))", meaning_of);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-3.0, 3.0);
  for (int i = 0; i < 100; ++i) {
    const double x = any(random), t = any(random);
    const double expected = 4.0 * (1.0 - std::exp(-t)) * std::max({0.0, 1.0 - x * x / 4.0, std::min(x, t)});
    EXPECT_NEAR(f(std::array{x, t}), expected, 1e-14 * std::abs(expected)) << x << " " << t;
  }
}

TEST(Formula, TheDeepestNestingThatIsAllowedIsEvaluated) {
  std::string text;
  for (int i = 0; i < 24; ++i) text += "1+2*2^(";
  text += "0";
  text += std::string(24, ')');
  EXPECT_NO_THROW(Formula(text, meaning_of)({}));
  EXPECT_THROW(Formula("1 + nothing", meaning_of), InputError);
}

}  // namespace
}  // namespace brim::formula_test
