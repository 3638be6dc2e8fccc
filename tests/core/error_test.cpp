#include "brim/core/error.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace brim::error_test {
namespace {

std::string message_of_failed_check(int left, int right) {
  try {
    BRIM_CHECK(left, ==, right);
  } catch (const ProgrammingError& error) {
    return error.what();
  }
  return "";
}

TEST(Check, SaysNothingWhenTheRelationHolds) { EXPECT_EQ(message_of_failed_check(3, 3), ""); }

TEST(Check, ShowsPlaceRelationAndBothValues) {
  const std::string message = message_of_failed_check(12, 345);
  for (const char* part : {"error_test.cpp:", "left == right", "left 12", "right 345"})
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is missing in: " << message;
}

TEST(Check, EvaluatesEachSideOnce) {
  int calls = 0;
  const auto next = [&] { return ++calls; };
  BRIM_CHECK(next(), ==, 1);
  EXPECT_EQ(calls, 1);
  EXPECT_THROW(BRIM_CHECK(next(), <, 0), ProgrammingError);
  EXPECT_EQ(calls, 2);
}

TEST(Check, FailsForNotANumberOnEitherSide) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(BRIM_CHECK(nan, ==, nan), ProgrammingError);
  EXPECT_THROW(BRIM_CHECK(nan, <, 1.0), ProgrammingError);
  EXPECT_THROW(BRIM_CHECK(1.0, >=, nan), ProgrammingError);
}

TEST(Check, IsOneStatement) {
  // Without the do-while of the macro, the else would belong to the macro's own if.
  bool reached = false;
  if (false)
    BRIM_CHECK(1, ==, 2);
  else
    reached = true;
  EXPECT_TRUE(reached);
}

TEST(Errors, KeepTheUsersFaultsApartFromTheProgrammers) {
  static_assert(!std::is_base_of_v<InputError, ProgrammingError> && !std::is_base_of_v<ProgrammingError, InputError>);
  static_assert(std::is_base_of_v<std::runtime_error, InputError> &&
                std::is_base_of_v<std::logic_error, ProgrammingError>);
  EXPECT_STREQ(InputError("scene.json: /dt: -1, must be > 0").what(), "scene.json: /dt: -1, must be > 0");
}

}  // namespace
}  // namespace brim::error_test
