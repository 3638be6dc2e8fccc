#include "brim/math/splitmix.h"

#include <gtest/gtest.h>

namespace brim::splitmix_test {
namespace {

TEST(Splitmix, GivesTheNumbersOfItsAuthors) {
  // First outputs of splitmix64.c (Vigna) from the state 1234567.
  std::uint64_t state = 1234567;
  EXPECT_EQ(next_scattered(state), 6457827717110365317u);
  EXPECT_EQ(next_scattered(state), 3203168211198807973u);
  EXPECT_EQ(next_scattered(state), 9817491932198370423u);
}

}  // namespace
}  // namespace brim::splitmix_test
