// Names of bodies in files: none is lost, whatever the bodies are called.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "brim/record/export/export.h"
#include "brim/record/export/names.h"
#include "brim/record/runner.h"
#include "brim/scene/scene.h"
#include "support/made_run.h"

namespace brim::export_names_test {
namespace {

namespace fs = std::filesystem;
using exporting::file_names;
using exporting::identifiers;
using Names = std::vector<std::string>;

TEST(ExportNames, NamesThatFilesTakeStayAsTheyAre) {
  const Names plain = {"ball", "gear.2", "left-arm", "arm_00012", "Kugel_groß", "мяч", "球", "σφαίρα", "공"};
  EXPECT_EQ(file_names(plain), plain);
}

TEST(ExportNames, NoBodyHasTheNameOfAnothersFrame) {
  EXPECT_EQ(file_names({"ball_00001", "ball"}), (Names{"ball_00001_2", "ball"}));
  EXPECT_EQ(file_names({"ball", "ball_100000", "ball_0001"}), (Names{"ball", "ball_100000_2", "ball_0001"}));
  EXPECT_EQ(file_names({"BALL_00001", "ball"}), (Names{"BALL_00001_2", "ball"}));
  EXPECT_EQ(file_names({"contacts", "contacts_00003"}), (Names{"contacts_2", "contacts_00003_2"}));
  EXPECT_EQ(file_names({"a_00001_00002", "a_00001"}), (Names{"a_00001_00002", "a_00001_2"}));
  // Nor of one that got a number: the frames of "A_2" would be "A_2_00007".
  EXPECT_EQ(file_names({"a_2_00007", "a", "A"}), (Names{"a_2_00007_2", "a", "A_2"}));
}

TEST(ExportNames, NamesThatBecomeEqualAreNumberedAndTheUnchangedOneKeepsItself) {
  EXPECT_EQ(file_names({"a b", "a_b", "a/b"}), (Names{"a_b_2", "a_b", "a_b_3"}));
  EXPECT_EQ(file_names({"Ball", "ball", "BALL"}), (Names{"Ball", "ball_2", "BALL_3"}));
  EXPECT_EQ(file_names({"Übung", "übung", "ЁЖ", "ёж"}), (Names{"Übung", "übung_2", "ЁЖ", "ёж_2"}));
  EXPECT_EQ(file_names({"", ".", "...", " "}), (Names{"_", "_.", "_...", "__2"}));
}

TEST(ExportNames, TwoSpellingsOfOneLetterAreTwoFiles) {
  // "é" as one character, and as "e" with a mark, which some file systems take for the same.
  EXPECT_EQ(file_names({"caf\u00e9", "cafe\u0301"}), (Names{"caf\u00e9", "cafe_2"}));
  EXPECT_EQ(file_names({"\u304c", "\u304b\u3099"}), (Names{"\u304c", "\u304b"}));
}

TEST(ExportNames, WhatIsNoLetterAndNamesOfDevicesAreReplaced) {
  EXPECT_EQ(file_names({"a:b", "tab\there", "bad\xff", "nul", "COM1.x", "a\u2028b", "a\uff0fb"}),
            (Names{"a_b", "tab_here", "bad_", "nul_", "COM1.x_", "a_b_2", "a_b_3"}));
  const std::string long_name(1000, 'x');
  const Names cut = file_names({long_name + "a", long_name + "b"});
  EXPECT_NE(cut[0], cut[1]);
  EXPECT_LT(cut[1].size(), 200u);
}

// Lower case of what the files are called, as a file system that knows no case sees it.
std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return text;
}

TEST(ExportNames, RandomNamesNeverShareAFileOrAnIdentifier) {
  const unsigned seed = 7;
  std::mt19937 random(seed);
  const Names pieces = {"a", "A", "b", " ", "_", "_00001", "_2", "_00002", "é", "É", "球", "?", "contacts", "."};
  for (int trial = 0; trial < 2000; ++trial) {
    std::set<std::string> bodies;
    while (bodies.size() < 12) {
      std::string name;
      for (unsigned n = 1 + random() % 3; n > 0; --n) name += pieces[random() % pieces.size()];
      bodies.insert(name);
    }
    Names names(bodies.begin(), bodies.end());
    std::ranges::shuffle(names, random);
    std::set<std::string> files = {"contacts.x", "contacts_00001.x", "contacts_00002.x"};
    for (const std::string& name : file_names(names))  // each as a still body and as one that moves
      for (const char* file : {".x", "_00001.x", "_00002.x"})
        EXPECT_TRUE(files.insert(lower(name) + file).second) << name << " seed " << seed << " trial " << trial;
    std::set<std::string> words;
    for (const std::string& word : identifiers(names)) EXPECT_TRUE(words.insert(word).second) << word;
  }
}

TEST(ExportNames, IdentifiersAreWrittenInEnglishLetters) {
  EXPECT_EQ(identifiers({"Kugel groß", "мяч", "Ώρα", "球", "2nd", "Ångström", "ball.1", "ball_1", "World", "x\xff"},
                        {"World"}),
            (Names{"Kugel_gross", "myach", "Ora", "u7403", "_2nd", "Angstrom", "ball_1", "ball_1_2", "World_2", "x_"}));
}

/// A run of bodies whose names ask for the same files.
class AlikeNames : public ::testing::Test {
 protected:
  AlikeNames() : lends_(1) {
    const Scene scene = parse_scene(R"({"brim": 1, "name": "alike", "frames": 2, "steps_per_frame": 1,
      "world": {"gravity": [0, 0, 0], "time_step": 0.1}, "bodies": [
      {"kind": "obstacle", "name": "ball_00001", "shape": {"kind": "box", "size": [9, 9, 1]}},
      {"kind": "points", "name": "ball", "radius": 0.1, "positions": [[0, 0, 2]], "velocity": [0, 0, 1]},
      {"kind": "points", "name": "Ball", "radius": 0.1, "positions": [[1, 0, 2]], "velocity": [0, 0, 1]},
      {"kind": "points", "name": "a b", "radius": 0.1, "positions": [[2, 0, 2]], "velocity": [0, 0, 1]},
      {"kind": "points", "name": "a_b", "radius": 0.1, "positions": [[3, 0, 2]], "velocity": [0, 0, 1]},
      {"kind": "points", "name": "球", "radius": 0.1, "positions": [[4, 0, 2]], "velocity": [0, 0, 1]},
      {"kind": "points", "name": "箱", "radius": 0.1, "positions": [[-1, 0, 2]], "velocity": [0, 0, 1]}]})");
    World world = build_world(scene);
    RunPlan plan;
    plan.folder = (lends_.path / "alike").string();
    plan.info = {scene.name, scene.text, scene.frame_time(), scene.steps_per_frame};
    plan.frames = plan.scene_frames = scene.frames;
    record_run(world, plan, {});
  }
  ExportResult exported(const std::string& format, std::vector<std::string> bodies = {}) {
    const fs::path out = lends_.path / fmt::format("{}{}", format, bodies.size());
    return export_run(RunReader((lends_.path / "alike").string()),
                      {.format = format, .folder = out.string(), .bodies = std::move(bodies)});
  }
  testing::MadeRun lends_;  ///< a folder
};

TEST_F(AlikeNames, LoseNoFileInVtkAndPly) {
  // Of the still one a file, of six that move and of contacts one in each of three frames; vtk has a collection too.
  EXPECT_EQ(exported("ply").files.size(), 1u + 3u * 7u);
  EXPECT_EQ(exported("vtk").files.size(), 1u + 3u * 7u + 1u);
}

TEST_F(AlikeNames, AreTheSameWhicheverBodiesAreChosen) {
  EXPECT_EQ(exported("ply", {"a b", "ball_00001", "箱"}).files,
            (Names{"a_b_2_00000.ply", "a_b_2_00001.ply", "a_b_2_00002.ply", "ball_00001_2.ply", "contacts_00000.ply",
                   "contacts_00001.ply", "contacts_00002.ply", "箱_00000.ply", "箱_00001.ply", "箱_00002.ply"}));
}

}  // namespace
}  // namespace brim::export_names_test
