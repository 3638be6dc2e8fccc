#include "brim/scene/syntax_hint.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/scene/document.h"

namespace brim::syntax_hint_test {
namespace {

std::string message_of(const std::string& text) {
  try {
    parse_document(text, "a.json");
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

TEST(SyntaxHint, ACommaTooManyIsToldWhereItIs) {
  EXPECT_EQ(message_of("{\"a\": [1,\n 2,\n\n]}"), "a.json:2: /a: not valid JSON: a comma too many before ']'");
  EXPECT_EQ(message_of("{\"a\": 1, // more\n}"), "a.json:1: /: not valid JSON: a comma too many before '}'");
  EXPECT_EQ(message_of("[1,, 2]"), "a.json:1: /: not valid JSON: a comma too many before ','");
}

TEST(SyntaxHint, AMissingCommaIsToldWhereItBelongs) {
  EXPECT_EQ(message_of("{\"a\": \"x, y\"\n\n \"b\": 2}"),
            "a.json:1: /: not valid JSON: a comma is missing after \"x, y\"");
  EXPECT_EQ(message_of("{\"a\": [\n{}\n /* , */\n{}]}"), "a.json:2: /a: not valid JSON: a comma is missing after }");
  EXPECT_EQ(message_of("{\"a\": [0.5\n 1]}"), "a.json:1: /a: not valid JSON: a comma is missing after 0.5");
  EXPECT_EQ(message_of("{\"a\": true\n \"b\": 1}"), "a.json:1: /: not valid JSON: a comma is missing after true");
}

TEST(SyntaxHint, AMissingColonIsToldToo) {
  EXPECT_EQ(message_of("{\"a\"\n 1}"), "a.json:1: /: not valid JSON: a colon is missing after \"a\"");
}

TEST(SyntaxHint, OtherMistakesKeepTheWordsOfTheParser) {
  EXPECT_NE(message_of("{\"a\": }").find("unexpected '}'"), std::string::npos);
  EXPECT_NE(message_of("{\"a\": [1, 2}").find("unexpected '}'"), std::string::npos);
  EXPECT_NE(message_of("{\"a\": 1} 2").find("expected end of input"), std::string::npos);
  EXPECT_NE(message_of("{\"a\": 1").find("unexpected end of input"), std::string::npos);
}

}  // namespace
}  // namespace brim::syntax_hint_test
