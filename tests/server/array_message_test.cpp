#include "server/array_message.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include "brim/core/error.h"
#include "checkout_paths.h"

namespace brim::viewer::array_message_test {
namespace {

/// The message that viewer/test/codec.test.ts writes with the TypeScript twin.
std::string golden_message() {
  const double time = 0.125;
  const float positions[] = {1.0f, 2.0f, 3.0f, -4.0f, 0.5f, 6.0f};
  const std::int32_t pair[] = {0, 1, -7, 2147483647};
  ArrayMessage message;
  message.add("time", &time, 1);
  message.add("positions", positions, 2, 3, 2);
  message.add("contacts/pair", pair, 2, 2);
  message.add("nothing", static_cast<const float*>(nullptr), 0, 3);
  return message.bytes();
}

TEST(ArrayMessage, AMessageIsTheGoldenFileOfThePageByteForByte) {
  std::ifstream in(BRIM_SOURCE_DIR "/viewer/test/golden/arrays.bin", std::ios::binary);
  ASSERT_TRUE(in);
  const std::string golden{std::istreambuf_iterator<char>(in), {}};
  EXPECT_EQ(golden_message(), golden);
}

TEST(ArrayMessage, NumbersLieWhereTheTableSays) {
  const std::string m = golden_message();
  const std::size_t entry = 16 + 56;  // of "positions"
  std::uint64_t offset = 0;
  std::memcpy(&offset, &m[entry + 48], sizeof offset);
  float fourth = 0.0f;
  std::memcpy(&fourth, &m[offset + 12], sizeof fourth);
  EXPECT_EQ(fourth, -4.0f);
  EXPECT_EQ(offset % 8, 0u);
}

TEST(ArrayMessage, OfNoArraysIsAHeaderAlone) { EXPECT_EQ(ArrayMessage().bytes().size(), 16u); }

TEST(ArrayMessage, ANameTooLongIsADefect) {
  ArrayMessage message;
  const double x = 0.0;
  EXPECT_THROW(message.add(std::string(32, 'n'), &x, 1), ProgrammingError);
  EXPECT_NO_THROW(message.add(std::string(31, 'n'), &x, 1));
}

}  // namespace
}  // namespace brim::viewer::array_message_test
