#include "brim/scene/common_words.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/scene/scene.h"

namespace brim::common_words_test {
namespace {

/// The message about a scene of one body, or of its other entries.
std::string message_of(const std::string& body, const std::string& more = "") {
  try {
    parse_scene(R"({"brim": 1, "name": "s", "duration": 1, "bodies": [{)" + body + "}]" + more + "}", "s.json");
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

bool says(const std::string& message, const std::string& words) {
  EXPECT_NE(message.find(words), std::string::npos) << message;
  return message.find(words) != std::string::npos;
}

TEST(CommonWords, AKeyThatBelongsElsewhereIsToldWhere) {
  const std::string ball = R"("kind": "rigid", "name": "b", "shape": {"kind": "sphere", "radius": 1}, )";
  says(message_of(ball + R"("position": [0, 0, 1])"), R"(it belongs in "transform": {"position": ...})");
  says(message_of(ball + R"("rotation": {"axis": [0, 0, 1], "degrees": 3})"), R"(it belongs in "transform")");
  says(message_of(ball + R"("friction": 0.3)"), R"(it belongs in "materials" of the scene)");
  says(message_of(ball + R"("restitution": 0.3)"), R"({"NAME": {"restitution": ...}})");
}

TEST(CommonWords, WordsOfOtherProgramsAreUnderstood) {
  const auto shape = [](const std::string& s) {
    return message_of(R"("kind": "rigid", "name": "b", "shape": {)" + s + "}");
  };
  says(shape(R"("kind": "sphere", "diameter": 1)"), R"(did you mean "radius"?)");
  says(shape(R"("kind": "cylinder", "radius": 1, "height": 1)"), R"(did you mean "length"?)");
  says(shape(R"("kind": "cube", "size": [1, 1, 1])"), R"(did you mean "box"?)");
  says(message_of(R"("kind": "static", "name": "b", "shape": {"kind": "plane"})"), R"(did you mean "obstacle"?)");
  says(message_of(R"("kind": "obstacle", "name": "b", "shape": {"kind": "plane"})",
                  R"(, "joints": [{"name": "j", "body": "b", "kind": "hinge", "position": [0, 0, 0]}])"),
       R"(did you mean "revolute"?)");
}

TEST(CommonWords, OnlyWhatIsAllowedIsProposed) {
  EXPECT_EQ(meant_word("height", {"radius", "length"}), "length");
  EXPECT_EQ(meant_word("height", {"radius"}), "");
  EXPECT_EQ(meant_word("ball", {"box", "sphere"}), "sphere");
  EXPECT_EQ(right_place("position", {"kind", "radius"}).key, "");
}

}  // namespace
}  // namespace brim::common_words_test
