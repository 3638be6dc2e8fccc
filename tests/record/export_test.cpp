#include "brim/record/export/export.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "brim/core/error.h"
#include "brim/record/export/format.h"
#include "brim/record/runner.h"
#include "brim/scene/scene.h"
#include "support/made_run.h"
#include "support/text_of.h"

namespace brim::export_test {
namespace {

namespace fs = std::filesystem;
using testing::MadeRun;
using testing::text_of;

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(FrameRanges, AreReadWithOpenAndNegativeEnds) {
  const auto expect = [](const char* text, std::int64_t first, std::int64_t last, std::int64_t stride) {
    const FrameRange r = parse_frames(text, 10);
    EXPECT_EQ(r.first, first) << text;
    EXPECT_EQ(r.last, last) << text;
    EXPECT_EQ(r.stride, stride) << text;
  };
  expect("", 0, 9, 1);
  expect("3", 3, 3, 1);
  expect("-1", 9, 9, 1);
  expect("2:5", 2, 5, 1);
  expect(":", 0, 9, 1);
  expect("4:", 4, 9, 1);
  expect(":-2", 0, 8, 1);
  expect("1:9:3", 1, 7, 3);  // the last frame is one that the stride meets
  expect("::4", 0, 8, 4);
  EXPECT_EQ(parse_frames("1:9:3", 10).count(), 3);
}

TEST(FrameRanges, AnythingElseIsRefusedByName) {
  for (const char* bad :
       {"10", "-11", "5:2", "a", "1:b", "1:2:0", "1:2:-1", "1:2:3:4", "1.5", " 1", "0:10", "99999999999999999999"})
    EXPECT_NE(message_of([&] { parse_frames(bad, 10); }).find(fmt::format("\"{}\"", bad)), std::string::npos) << bad;
  EXPECT_THROW(parse_frames("", 0), InputError) << "a run without frames has none to write";
}

TEST(Chains, JoinEverySegmentOnceAndNeverPassABranching) {
  // A chain 0-1-2-3, a ring 4-5-6, and a star 7-8, 7-9, 7-10.
  const std::vector<std::array<std::int32_t, 2>> lines = {{2, 1}, {0, 1}, {2, 3}, {4, 5}, {6, 4},
                                                          {5, 6}, {7, 8}, {9, 7}, {7, 10}};
  const auto list = exporting::chains(lines, 11);
  std::multiset<std::pair<int, int>> want, got;
  for (const auto& l : lines) want.insert(std::minmax({l[0], l[1]}));
  std::vector<std::size_t> lengths;
  for (const auto& chain : list) {
    lengths.push_back(chain.size());
    for (std::size_t i = 0; i + 1 < chain.size(); ++i) got.insert(std::minmax({chain[i], chain[i + 1]}));
    for (std::size_t i = 1; i + 1 < chain.size(); ++i) EXPECT_NE(chain[i], 7);
  }
  EXPECT_EQ(got, want);
  std::sort(lengths.begin(), lengths.end());
  EXPECT_EQ(lengths, (std::vector<std::size_t>{2, 2, 2, 4, 4}));
}

TEST(Export, RefusesWhatItCannotDoAndLeavesNothingBehind) {
  const MadeRun made(4);
  const RunReader run(made.folder());
  const fs::path out = made.path / "out";
  const auto refused = [&](ExportRequest request, const char* word) {
    request.folder = out.string();
    const std::string message = message_of([&] { export_run(run, request); });
    EXPECT_NE(message.find(word), std::string::npos) << message;
    EXPECT_FALSE(fs::exists(out)) << word;
  };
  refused({.format = "max"}, "must be one of vtk, vtu, xdmf");
  refused({.format = "obj", .frames = "3:9"}, "frame 9");
  refused({.format = "obj", .bodies = {"nobody"}}, "body \"nobody\" is not in the run; it has floor, ball");
  const MadeRun empty(0);
  EXPECT_THROW(export_run(RunReader(empty.folder()), {.format = "obj", .folder = out.string()}), InputError);
  EXPECT_FALSE(fs::exists(out));
  // Stopped half-way: neither the folder nor the one beside it in which it was made is left.
  EXPECT_THROW(export_run(run, {.format = "obj", .folder = out.string()}, {},
                          [](std::int64_t done, std::int64_t) { return done < 2; }),
               InputError);
  EXPECT_EQ(names_in(made.path), std::vector<std::string>{"run"});
}

TEST(Export, GrainsHaveTheVelocitiesOfTheirCentres) {
  const MadeRun lends(1);  // a folder
  const Scene scene = parse_scene(R"({"brim": 1, "name": "grains", "frames": 2,
    "world": {"gravity": [0, 0, 0], "time_step": 0.01}, "bodies": [
    {"kind": "points", "name": "sand", "radius": 0.1, "grid": {"count": [2, 1, 1]}, "velocity": [1, 2, -3]}]})");
  World world = build_world(scene);
  RunPlan plan;
  plan.folder = (lends.path / "sand").string();
  plan.info = {scene.name, scene.text, scene.frame_time(), scene.steps_per_frame};
  plan.scene_file = scene.file;
  plan.frames = plan.scene_frames = scene.frames;
  record_run(world, plan, [](const RunProgress&) { return true; });
  export_run(RunReader(plan.folder), {.format = "ply", .folder = (lends.path / "out").string(), .frames = "1"});
  const std::string ply = text_of(lends.path / "out/sand_00001.ply");
  EXPECT_NE(ply.find("property float vx\nproperty float vy\nproperty float vz\n"), std::string::npos) << ply;
  const std::size_t data = ply.find("end_header\n") + 11;
  for (std::size_t grain = 0; grain < 2; ++grain) {
    std::array<float, 7> row{};  // x y z vx vy vz pscale
    ASSERT_EQ(ply.size(), data + 2 * sizeof row);
    std::memcpy(row.data(), ply.data() + data + grain * sizeof row, sizeof row);
    EXPECT_EQ(row[3], 1.0f);
    EXPECT_EQ(row[4], 2.0f);
    EXPECT_EQ(row[5], -3.0f);
  }
}

TEST(Export, AnOlderExportIsReplacedOnlyWithForceAndStrangersFilesNever) {
  const MadeRun made(4);
  const RunReader run(made.folder());
  const fs::path out = made.path / "out";
  ExportRequest request{.format = "obj", .folder = out.string()};
  EXPECT_EQ(export_run(run, request).frames, 4);
  EXPECT_EQ(names_in(out), (std::vector<std::string>{"export.json", "frame_00000.obj", "frame_00001.obj",
                                                     "frame_00002.obj", "frame_00003.obj"}));
  EXPECT_NE(message_of([&] { export_run(run, request); }).find("--force"), std::string::npos);
  request.force = true;
  request.frames = "1:2";
  std::ofstream(out / "letter.txt") << "dear";
  export_run(run, request);
  EXPECT_EQ(names_in(out),
            (std::vector<std::string>{"export.json", "frame_00001.obj", "frame_00002.obj", "letter.txt"}));
  // A folder of somebody else, even with force; and a list that names files elsewhere.
  fs::create_directories(made.path / "mine");
  std::ofstream(made.path / "mine/letter.txt") << "dear";
  request.folder = (made.path / "mine").string();
  EXPECT_THROW(export_run(run, request), InputError);
  EXPECT_EQ(names_in(made.path / "mine"), std::vector<std::string>{"letter.txt"});
  std::ofstream(made.path / "mine/export.json")
      << R"({"files": ["../mine/letter.txt", "letter.txt/../../run/run.h5"]})";
  export_run(run, request);
  EXPECT_TRUE(fs::exists(made.path / "mine/letter.txt"));
  EXPECT_TRUE(fs::exists(made.path / "run/run.h5"));
}

TEST(Export, ABodysNameMeansItsNumberedCopiesAndItsContacts) {
  const MadeRun made(3);
  const RunReader run(made.folder());
  EXPECT_EQ(choose_bodies(run, {"ball"}), (std::vector<int>{1, 2}));
  EXPECT_EQ(choose_bodies(run, {"ball.1", "rod"}), (std::vector<int>{2, 3}));
  const fs::path out = made.path / "out";
  export_run(run, {.format = "ply", .folder = out.string(), .frames = "2", .bodies = {"grains"}});
  // Only the second contact is one of the grains.
  EXPECT_NE(text_of(out / "contacts_00002.ply").find("element vertex 1\n"), std::string::npos);
  EXPECT_EQ(names_in(out), (std::vector<std::string>{"contacts_00002.ply", "export.json", "grains_00002.ply"}));
}

}  // namespace
}  // namespace brim::export_test
