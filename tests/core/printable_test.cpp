#include "brim/core/printable.h"

#include <gtest/gtest.h>

namespace brim::printable_test {
namespace {

TEST(Printable, PlainTextOfAnyLanguageIsLeftAsItIs) {
  for (const char* text : {"", "box.json:8: /bodies/1/densty", "würfel", "箱", "\U0001f4e6", "C:\\x"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, WhatATerminalWouldObeyIsSpelled) {
  using namespace std::string_view_literals;
  EXPECT_EQ(printable("a\x1b[31m\a\0b\x7f"sv), "a\\u001b[31m\\u0007\\u0000b\\u007f");
  EXPECT_EQ(printable("one\ntwo\r\t"), "one\\ntwo\\r\\t");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\u009b31m")
      << "C1 in UTF-8";
}

TEST(Printable, BytesThatAreNoUtf8AreSpelled) {
  EXPECT_EQ(printable("\x9b"), "\\x9b");
  EXPECT_EQ(printable("\xc3"), "\\xc3") << "cut short";
  EXPECT_EQ(printable("\xc0\x80"), "\\xc0\\x80") << "a longer form than needed";
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "half of a pair";
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80") << "beyond Unicode";
}

}  // namespace
}  // namespace brim::printable_test
