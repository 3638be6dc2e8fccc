#include "brim/scene/expression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "brim/core/error.h"

namespace brim::expression_test {
namespace {

Json value_of(const std::string& name) {
  if (name == "h") return 0.5;
  if (name == "n") return 3;
  if (name == "word") return "text";
  if (name == "list") return Json::array({1, 2, 3});
  throw InputError("no such parameter");
}

TEST(Expression, FollowsTheRulesOfArithmetic) {
  const std::pair<const char*, double> cases[] = {
      {"1 + 2 * 3", 7.0},  {"(1 + 2) * 3", 9.0},    {"-2^2", -4.0},
      {"2^3^2", 512.0},    {"2^-1", 0.5},           {"8 / 2 / 2", 2.0},
      {"10 - 3 - 2", 5.0}, {"1e-3 * 2", 0.002},     {".5", 0.5},
      {"- - 3", 3.0},      {"2*h + n", 4.0},        {"max(1, n, 2) - min(h, 1)", 2.5},
      {"sin(pi/6)", 0.5},  {"sqrt(abs(-16))", 4.0}, {"round(2.6) + floor(2.6) + ceil(2.1)", 8.0}};
  for (const auto& [text, expected] : cases)
    EXPECT_NEAR(evaluate(text, value_of).get<double>(), expected, 1e-15 * std::abs(expected)) << text;
}

TEST(Expression, ANameAloneIsWhateverItsParameterIs) {
  EXPECT_EQ(evaluate(" word ", value_of), "text");
  EXPECT_EQ(evaluate("list", value_of), Json::array({1, 2, 3}));
  EXPECT_DOUBLE_EQ(evaluate("pi", value_of).get<double>(), std::numbers::pi);
}

TEST(Expression, WholeNumbersStayWhole) {
  EXPECT_TRUE(evaluate("2 * 3", value_of).is_number_integer());
  EXPECT_FALSE(evaluate("2 / 3", value_of).is_number_integer());
}

TEST(Expression, WhatIsNotUnderstoodIsRefused) {
  for (const std::string text : {"", "1 +", "(1", "1)", "2 3", "h h", "1 / 0", "log(-1)", "word + 1", "list * 2",
                                 "nothing", "wat(1)", "sin()", "sin(1, 2)", "max()", "1..2", "0x10", "a.b", "1e999"})
    EXPECT_THROW(evaluate(text, value_of), InputError) << text;
  EXPECT_THROW(evaluate(std::string(400, '(') + "1" + std::string(400, ')'), value_of), InputError);
  EXPECT_THROW(evaluate(std::string(200000, '-') + "1", value_of), InputError);
}

}  // namespace
}  // namespace brim::expression_test
