#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "brim/core/error.h"
#include "brim/scene/scene.h"
#include "scene/scene_mistakes.h"

namespace brim::bad_scenes_test {
namespace {

namespace fs = std::filesystem;

using testing::kGood;
using testing::kMistakes;
using testing::Mistake;

std::string spoilt(const Mistake& m) {
  std::string text = kGood;
  const auto at = text.find(m.find);
  EXPECT_NE(at, std::string::npos) << m.what << ": \"" << m.find << "\" is not in the good scene";
  if (at != std::string::npos) text.replace(at, std::string(m.find).size(), m.replace);
  return text;
}

/// A folder with the mesh files that the mistakes name.
class BadScenes : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("brim_bad_scenes_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    write("empty.obj", "");
    write("garbage.obj", "f 1 2 x\nthis is no mesh\n");
    write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    write("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    // The second tetrahedron is inside out.
    write("inverted.msh",
          "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n"
          "$Elements\n2\n1 4 2 0 0 1 2 3 4\n2 4 2 0 0 2 4 3 5\n$EndElements\n");
    write("flat.msh",
          "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n$EndNodes\n"
          "$Elements\n1\n1 4 2 0 0 1 2 3 4\n$EndElements\n");
    write("index.msh",
          "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
          "$Elements\n1\n1 4 2 0 0 1 2 3 9\n$EndElements\n");
    write("short.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n");
    ::unsetenv("BRIM_NO_SUCH_FOLDER");
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  static void write(const char* name, const char* text) { std::ofstream(folder_ / name) << text; }

  /// The message that loading and building a text ends with; "" when it is accepted.
  static std::string message(const std::string& text) {
    try {
      const Scene scene = parse_scene(text, (folder_ / "scene.json").string());
      build_world(scene);
      return "";
    } catch (const InputError& e) {
      return e.what();
    }
  }
  static inline fs::path folder_;
};

TEST_F(BadScenes, TheGoodSceneIsAccepted) { EXPECT_EQ(message(kGood), ""); }

TEST_F(BadScenes, EveryMistakeGetsOneMessageWithFilePlaceValueAndWhatIsAllowed) {
  ASSERT_GE(kMistakes.size(), 100u);
  for (const Mistake& m : kMistakes) {
    const std::string text = message(spoilt(m));
    SCOPED_TRACE(std::string(m.what) + ": " + text);
    EXPECT_TRUE(text.starts_with((folder_ / "scene.json").string() + ":" + m.place)) << "expected place " << m.place;
    for (const char* word : m.words) EXPECT_NE(text.find(word), std::string::npos) << "expected the words: " << word;
    EXPECT_EQ(text.find('\n'), std::string::npos) << "one line";
  }
}

TEST_F(BadScenes, MissingFilesAndFoldersAreNamed) {
  const auto load = [](const std::string& path) {
    try {
      load_scene(path);
      return std::string();
    } catch (const InputError& e) {
      return std::string(e.what());
    }
  };
  EXPECT_NE(load((folder_ / "nothing.json").string()).find("no such file"), std::string::npos);
  EXPECT_NE(load(folder_.string()).find("is a folder"), std::string::npos);
}

TEST_F(BadScenes, DeepNestingIsRefusedAndDoesNotCrash) {
  EXPECT_NE(message(std::string(100000, '[')).find("nested deeper"), std::string::npos);
}

}  // namespace
}  // namespace brim::bad_scenes_test
