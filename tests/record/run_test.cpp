#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "brim/body/changing_surface.h"
#include "brim/core/error.h"
#include "brim/record/runner.h"
#include "brim/record/scene_change.h"
#include "brim/scene/scene.h"
#include "brim/world/report_fields.h"
#include "support/made_run.h"
#include "support/version_1_run.h"

namespace brim {
namespace {

namespace fs = std::filesystem;

/// A ball falls on a floor while a bar above it begins to move after 0.05 s.
const char* const kScene = R"({
  "brim": 1, "name": "fall", "frames": 12, "world": {"time_step": 0.01},
  "bodies": [
    {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
    {"kind": "obstacle", "name": "bar", "shape": {"kind": "box", "size": [1, 0.1, 0.1]}, "transform": {"position": [0, 0, 3]},
     "keyframes": [{"time": 0.05}, {"time": 0.1, "offset": [0, 1, 0]}]},
    {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.5}, "transform": {"position": [0, 0, 0.51]},
     "velocity": [0.5, 0, -1]}
  ],
  "expect": [{"metric": "lowest", "body": "ball", "min": -0.2}, {"metric": "position_x", "body": "ball", "min": 100}]
})";

class Run : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / fmt::format("brim_run_{}_{}", ::getpid(),
                                                      ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string at(const char* name) const { return (folder_ / name).string(); }

  static RunPlan plan(const Scene& scene, const std::string& folder) {
    RunPlan p;
    p.folder = folder;
    p.info = {scene.name, scene.text, scene.frame_time(), scene.steps_per_frame};
    p.scene_file = scene.file;
    p.frames = p.scene_frames = scene.frames;
    p.expect = scene.expect;
    return p;
  }

  fs::path folder_;
};

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

std::string text_of(const fs::path& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

TEST_F(Run, EveryFrameIsReadBackBitForBit) {
  const Scene scene = parse_scene(kScene);
  World world = build_world(scene);
  std::vector<State> states = {world.state()};
  std::vector<std::vector<ContactSample>> contacts = {{}};
  std::vector<StepReport> reports = {{}};
  std::vector<std::vector<Vec3f>> bar(1), ball(1);
  const auto look = [&] {
    bar.back().resize(world.body(1).display().vertices);
    ball.back().resize(world.body(2).display().vertices);
    world.body(1).display_positions(bar.back());
    world.body(2).display_positions(ball.back());
  };
  look();
  const RunResult result = record_run(world, plan(scene, at("run")), [&](const RunProgress& p) {
    states.push_back(world.state());
    contacts.emplace_back(world.contacts().begin(), world.contacts().end());
    reports.push_back(*p.report);
    bar.emplace_back();
    ball.emplace_back();
    look();
    return true;
  });
  EXPECT_EQ(result.end, RunEnd::Completed);
  const RunReader run(at("run"));
  ASSERT_EQ(run.frames(), 13);
  EXPECT_EQ(run.scene_name(), "fall");
  EXPECT_EQ(run.bodies().size(), 3u);
  EXPECT_EQ(run.bodies()[2].kind, "rigid");
  EXPECT_EQ(run.bodies()[2].display.triangles, world.body(2).display().triangles);
  std::size_t contact_count = 0;
  for (std::int64_t f = 0; f < 13; ++f) {
    SCOPED_TRACE(f);
    const auto i = static_cast<std::size_t>(f);
    const State s = run.state(f);
    EXPECT_EQ(s.time, states[i].time);
    EXPECT_EQ(s.step, states[i].step);
    EXPECT_TRUE(same_bits(s.q, states[i].q) && same_bits(s.v, states[i].v) && same_bits(s.memory, states[i].memory));
    EXPECT_EQ(run.positions(1, f), bar[i]);
    EXPECT_EQ(run.positions(2, f), ball[i]);
    const std::vector<ContactSample> c = run.contacts(f);
    ASSERT_EQ(c.size(), contacts[i].size());
    contact_count += c.size();
    for (std::size_t k = 0; k < c.size(); ++k) {
      EXPECT_EQ(c[k].position, contacts[i][k].position);
      EXPECT_EQ(c[k].force, contacts[i][k].force);
      EXPECT_EQ(c[k].part_b, contacts[i][k].part_b);
    }
    const std::vector<PairReport> pairs = run.pairs(f);
    ASSERT_EQ(pairs.size(), reports[i].pairs.size());
    for (std::size_t k = 0; k < pairs.size(); ++k) EXPECT_EQ(pairs[k].force_on_a, reports[i].pairs[k].force_on_a);
    for (const ReportField& field : report_fields())
      EXPECT_EQ(run.series(field.name)[i], field.get(reports[i])) << field.name;
  }
  EXPECT_GT(contact_count, 0u) << "the ball must touch the floor, or the test is blind";
  // The bar rests for five frames and then moves: its early frames must have been filled in.
  EXPECT_EQ(run.positions(1, 3), run.positions(1, 0));
  EXPECT_NE(run.positions(1, 9), run.positions(1, 0));
}

TEST_F(Run, ResumedRunEqualsTheStraightOneBitForBit) {
  const Scene scene = parse_scene(kScene);
  World straight = build_world(scene);
  record_run(straight, plan(scene, at("straight")), {});
  {
    World first = build_world(scene);
    const RunResult r = record_run(first, plan(scene, at("parts")), [](const RunProgress& p) { return p.frame < 7; });
    EXPECT_EQ(r.end, RunEnd::Interrupted);
  }
  World second = build_world(scene);
  RunPlan p = plan(scene, at("parts"));
  p.resume = true;
  const RunResult resumed = record_run(second, p, {});
  EXPECT_EQ(resumed.end, RunEnd::Completed);
  const RunReader a(at("straight")), b(at("parts"));
  ASSERT_EQ(a.frames(), b.frames());
  for (std::int64_t f = 0; f < a.frames(); ++f) {
    SCOPED_TRACE(f);
    const State x = a.state(f), y = b.state(f);
    EXPECT_TRUE(same_bits(x.q, y.q) && same_bits(x.v, y.v) && same_bits(x.memory, y.memory));
    EXPECT_EQ(x.time, y.time);
    EXPECT_EQ(a.positions(1, f), b.positions(1, f));
    EXPECT_EQ(a.contacts(f).size(), b.contacts(f).size());
  }
  EXPECT_EQ(straight.hash(), second.hash());
  // The summary speaks of the whole run.
  const auto sa = nlohmann::json::parse(text_of(folder_ / "straight/summary.json"));
  const auto sb = nlohmann::json::parse(text_of(folder_ / "parts/summary.json"));
  for (const char* key : {"frames", "steps", "substeps", "hash", "worst_overlap", "expect"})
    EXPECT_EQ(sa[key], sb[key]) << key;
}

TEST_F(Run, AnOlderRunReadsZerosForWhatItsVersionDidNotRecordAndCanBeGoneOnWith) {
  const Scene scene = parse_scene(kScene);
  {
    World world = build_world(scene);
    record_run(world, plan(scene, at("run")), [](const RunProgress& p) { return p.frame < 7; });
  }
  const char* const kForget =
      "import sys, h5py\nf = h5py.File(sys.argv[1], 'a')\ndel f['series/sweeps'], f['series/voxels']\n";
  if (testing::run_python("h5py", kForget, "'" + at("run/run.h5") + "'", folder_) < 0)
    GTEST_SKIP() << "python3 without h5py";
  std::int64_t frames = 0;
  {
    const RunReader run(at("run"));
    frames = run.frames();
    ASSERT_GT(frames, 3);
    EXPECT_EQ(run.series("voxels"), std::vector<double>(static_cast<std::size_t>(frames), 0.0));
    EXPECT_EQ(run.report(3).sweeps, 0);
    EXPECT_GT(run.report(3).tiles, 0);
    EXPECT_THROW(run.series("no_such_series"), InputError);
  }
  World world = build_world(scene);
  RunPlan p = plan(scene, at("run"));
  p.resume = true;
  record_run(world, p, {});
  const RunReader run(at("run"));
  const std::vector<double> voxels = run.series("voxels");
  ASSERT_EQ(voxels.size(), 13u);
  EXPECT_EQ(voxels[static_cast<std::size_t>(frames) - 1], 0.0);
  EXPECT_GT(voxels.back(), 0.0);
}

TEST_F(Run, ARunOfTheFirstVersionReadsAlikeAndIsGoneOnWithToTheSameBits) {
  const Scene scene = parse_scene(kScene);
  World straight = build_world(scene);
  record_run(straight, plan(scene, at("straight")), {});
  {
    World first = build_world(scene);
    record_run(first, plan(scene, at("run")), [](const RunProgress& p) { return p.frame < 7; });
  }
  testing::write_version_1(at("run"), at("old"));
  {
    const RunReader now(at("run")), old(at("old"));
    EXPECT_EQ(old.format_version(), 1);
    EXPECT_EQ(now.format_version(), 2);
    ASSERT_EQ(now.frames(), old.frames());
    for (std::int64_t f = 0; f < now.frames(); ++f)
      for (int b = 0; b < 3; ++b) {
        EXPECT_EQ(now.positions(b, f), old.positions(b, f));
        EXPECT_EQ(now.triangles(b, f), old.triangles(b, f));
        EXPECT_EQ(now.still(b), old.still(b));
      }
  }
  World world = build_world(scene);
  RunPlan p = plan(scene, at("old"));
  p.resume = true;
  EXPECT_EQ(record_run(world, p, {}).end, RunEnd::Completed);
  EXPECT_EQ(world.hash(), straight.hash());
  const RunReader a(at("straight")), b(at("old"));
  EXPECT_EQ(b.format_version(), 2);
  ASSERT_EQ(a.frames(), b.frames());
  for (std::int64_t f = 0; f < a.frames(); ++f) {
    EXPECT_TRUE(same_bits(a.state(f).q, b.state(f).q)) << f;
    EXPECT_EQ(a.positions(2, f), b.positions(2, f)) << f;
    EXPECT_EQ(a.contacts(f).size(), b.contacts(f).size()) << f;
    EXPECT_EQ(a.pairs(f).size(), b.pairs(f).size()) << f;
  }
}

TEST_F(Run, FramesThatWereNotCountedYetAreNotThereAndAreWrittenAgain) {
  const Scene scene = parse_scene(kScene);
  World world = build_world(scene);
  record_run(world, plan(scene, at("run")), {});
  const State last = RunReader(at("run")).state(12);
  {
    // As a process leaves it that is killed after the rows of five frames and before their count.
    h5::File file(at("run/run.h5"), h5::File::Mode::Write);
    const std::int64_t count = 8;
    file.open("/frames/count").overwrite(&count, h5::Type::Int64);
  }
  EXPECT_EQ(RunReader(at("run")).frames(), 8);
  EXPECT_THROW(RunReader(at("run")).state(8), InputError);
  World again = build_world(scene);
  RunPlan p = plan(scene, at("run"));
  p.resume = true;
  record_run(again, p, {});
  EXPECT_TRUE(same_bits(RunReader(at("run")).state(12).q, last.q));
}

TEST_F(Run, DamagedFilesAreRefusedWithTheNameOfWhatIsWrong) {
  const Scene scene = parse_scene(kScene);
  World world = build_world(scene);
  record_run(world, plan(scene, at("run")), {});
  using Shape = std::vector<std::uint64_t>;
  const std::vector<char> zeros(1 << 22, 0);
  const std::vector<std::int64_t> ones(100000, 1), large(100000, 123456789012);
  std::vector<std::int64_t> rising;
  for (std::int64_t i = 0; i < 20; ++i) rising.push_back(i << 40);
  struct Damage {
    const char* path;
    h5::Type type;
    Shape shape;
    const void* data;
  };
  using enum h5::Type;
  const std::vector<Damage> damages = {{"/meshes/triangles", Int32, {12, 4000}, zeros.data()},
                                       {"/meshes/triangles", Float32, {12, 3}, zeros.data()},
                                       {"/meshes/vertices", Float64, {5}, zeros.data()},
                                       {"/meshes/first_vertex", Int64, {3}, large.data()},
                                       {"/poses/mesh", Int32, {3}, large.data()},
                                       {"/poses/mesh", Int32, {9000}, zeros.data()},
                                       {"/poses/rotation", Float64, {13, 1, 9}, zeros.data()},
                                       {"/poses/translation", Float64, {13, 9}, zeros.data()},
                                       {"/bodies/q_offset", Int64, {3}, large.data()},
                                       {"/bodies/v_size", Int64, {3}, large.data()},
                                       {"/bodies/pieces", Int64, {3}, large.data()},
                                       {"/bodies/vertices", Int64, {3}, ones.data()},
                                       {"/bodies/first_position", Int64, {3}, zeros.data()},
                                       {"/parts/body", Int64, {3}, large.data()},
                                       {"/frames/count", Int64, {1}, large.data()},
                                       {"/frames/q", Float64, {13, 2}, zeros.data()},
                                       {"/contacts/offset", Int64, {14}, rising.data()},
                                       {"/contacts/position", Float32, {20000, 30}, zeros.data()},
                                       {"/contacts/pair", Int32, {20000, 2}, large.data()},
                                       {"/contacts/pair", Float32, {20000, 2}, zeros.data()},
                                       {"/memory/offset", Int64, {14}, rising.data()},
                                       {"/motion/center", Float64, {13, 3, 30}, zeros.data()},
                                       {"/series/wall", Float64, {2}, zeros.data()},
                                       {"/display/first_triangle", Int64, {4}, large.data()}};
  for (const Damage& damage : damages) {
    SCOPED_TRACE(damage.path);
    fs::remove_all(folder_ / "bad");
    fs::copy(folder_ / "run", folder_ / "bad");
    {
      h5::File file(at("bad/run.h5"), h5::File::Mode::Write);
      file.remove(damage.path);
      file.write(damage.path, damage.type, damage.shape, damage.data);
    }
    const auto read_all = [&] {
      const RunReader run(at("bad"));
      run.series("wall");
      for (std::int64_t f = 0; f < run.frames(); ++f) {
        run.state(f), run.report(f), run.samples(f), run.contacts(f), run.tiles(f);
        for (std::size_t b = 0; b < run.bodies().size(); ++b) run.positions(static_cast<int>(b), f);
      }
    };
    EXPECT_THROW(read_all(), InputError);
    World fresh = build_world(scene);
    RunPlan p = plan(scene, at("bad"));
    p.resume = true;
    p.frames = 14;
    // The positions that resuming does not need may be anything; nothing may crash.
    try {
      record_run(fresh, p, {});
    } catch (const InputError&) {
    }
  }
}

TEST_F(Run, ASurfaceThatChangesIsReadBackFrameByFrameAlsoAfterResuming) {
  const Scene scene = parse_scene(R"({
    "brim": 1, "name": "drop", "frames": 6, "world": {"time_step": 0.02},
    "bodies": [{"kind": "grid_fluid", "name": "water", "cell_size": 0.1, "box": {"lo": [0, 0, 0], "hi": [1, 1, 1]},
                "fill": [{"kind": "sphere", "center": [0.5, 0.5, 0.4], "radius": 0.3}]}]})");
  std::vector<std::vector<Vec3f>> x(1);
  std::vector<std::vector<Triangle>> triangles(1);
  {
    World world = build_world(scene);
    const auto look = [&] { changing_surface(world.body(0))->display_surface(x.back(), triangles.back()); };
    look();
    record_run(world, plan(scene, at("run")), [&](const RunProgress&) {
      x.emplace_back(), triangles.emplace_back();
      look();
      return true;
    });
  }
  const auto expect_all = [&](const std::string& folder) {
    const RunReader run(folder);
    ASSERT_EQ(run.frames(), 7);
    EXPECT_TRUE(run.bodies()[0].changing);
    EXPECT_FALSE(run.still(0));
    for (std::int64_t f = 0; f < 7; ++f) {
      EXPECT_EQ(run.positions(0, f), x[static_cast<std::size_t>(f)]) << f;
      EXPECT_EQ(run.triangles(0, f), triangles[static_cast<std::size_t>(f)]) << f;
    }
  };
  expect_all(at("run"));
  EXPECT_NE(x.front().size(), x.back().size()) << "the surface must change, or the test is blind";
  // Closed and shared: every edge is passed once in each direction.
  std::map<std::pair<int, int>, int> passes;
  for (const Triangle& t : triangles.back())
    for (int k = 0; k < 3; ++k) ++passes[{t[k], t[(k + 1) % 3]}];
  for (const auto& [edge, count] : passes) EXPECT_EQ((passes.contains({edge.second, edge.first})), true);
  {
    World world = build_world(scene);
    record_run(world, plan(scene, at("parts")), [](const RunProgress& p) { return p.frame < 3; });
  }
  World world = build_world(scene);
  RunPlan p = plan(scene, at("parts"));
  p.resume = true;
  record_run(world, p, {});
  expect_all(at("parts"));
}

TEST_F(Run, ResumingAnotherSceneIsRefusedAndLeavesTheRunAsItWas) {
  const Scene scene = parse_scene(kScene);
  World world = build_world(scene);
  record_run(world, plan(scene, at("run")), {});
  std::string other = kScene;
  other.replace(other.find("\"ball\""), 6, "\"bell\"");
  other.replace(other.find("\"body\": \"ball\""), 14, "\"body\": \"bell\"");
  other.replace(other.find("\"body\": \"ball\""), 14, "\"body\": \"bell\"");
  const Scene wrong = parse_scene(other);
  World wrong_world = build_world(wrong);
  RunPlan p = plan(wrong, at("run"));
  p.resume = true;
  EXPECT_THROW(record_run(wrong_world, p, {}), InputError);
  EXPECT_EQ(RunReader(at("run")).frames(), 13);
}

TEST_F(Run, AChangedSceneIsGoneOnWithOnlyWhenThatIsAskedForAndIsRecorded) {
  const Scene scene = parse_scene(kScene);
  {
    World world = build_world(scene);
    record_run(world, plan(scene, at("run")), [](const RunProgress& p) { return p.frame < 7; });
  }
  std::string other = kScene;
  other.replace(other.find("0.01}"), 4, "0.005");
  const Scene changed = parse_scene(other);
  World world = build_world(changed);
  RunPlan p = plan(changed, at("run"));
  p.resume = true;
  EXPECT_THROW(record_run(world, p, {}), InputError);
  EXPECT_EQ(RunReader(at("run")).frames(), 8);
  EXPECT_EQ(text_of(folder_ / "run/scene.json"), kScene);
  p.edit = true;
  World again = build_world(changed);
  record_run(again, p, {});
  EXPECT_EQ(RunReader(at("run")).frames(), 13);
  EXPECT_EQ(text_of(folder_ / "run/scene.json"), other);
  EXPECT_EQ(text_of(folder_ / "run/scene_until_frame_7.json"), kScene);
  // A new run in the folder forgets them.
  World fresh = build_world(scene);
  p = plan(scene, at("run"));
  p.force = true;
  record_run(fresh, p, {});
  EXPECT_FALSE(fs::exists(folder_ / "run/scene_until_frame_7.json"));
}

TEST_F(Run, WhatOnlySaysHowLongAndWhatIsExpectedIsNoChangeOfAScene) {
  std::string longer = kScene;
  longer.replace(longer.find("\"frames\": 12"), 12, "/* more */ \"frames\": 90");
  EXPECT_TRUE(same_scene(kScene, longer));
  EXPECT_FALSE(same_scene(kScene, "{}"));
  EXPECT_FALSE(same_scene(kScene, "not JSON"));
}

TEST_F(Run, AFirstStepThatIsRefusedLeavesNoFolder) {
  std::string far = kScene;
  far.replace(far.find("[0, 0, 0.51]"), 12, "[1e10, 0, 0.49]");
  const Scene scene = parse_scene(far);
  World world = build_world(scene);
  EXPECT_THROW(record_run(world, plan(scene, at("run")), {}), InputError);
  EXPECT_FALSE(fs::exists(folder_ / "run"));
  // A folder of somebody's stays, without the files of the run.
  fs::create_directories(folder_ / "empty");
  World again = build_world(scene);
  EXPECT_THROW(record_run(again, plan(scene, at("empty")), {}), InputError);
  EXPECT_TRUE(fs::is_empty(folder_ / "empty"));
}

TEST_F(Run, SummarySaysWhatHappenedAndWhichExpectationsHold) {
  const Scene scene = parse_scene(kScene);
  World world = build_world(scene);
  const RunResult result = record_run(world, plan(scene, at("run")), {});
  ASSERT_EQ(result.findings.size(), 2u);
  EXPECT_TRUE(result.findings[0].ok);
  EXPECT_FALSE(result.findings[1].ok);
  EXPECT_FALSE(result.ok());
  const auto s = nlohmann::json::parse(text_of(folder_ / "run/summary.json"));
  for (const char* key : {"brim_version", "scene", "threads", "steps", "substeps", "simulated_seconds", "wall_seconds",
                          "seconds", "contact_share", "counts", "worst_overlap", "momentum_error", "energy", "warnings",
                          "peak_memory_bytes", "expect"})
    EXPECT_TRUE(s.contains(key)) << key;
  for (const char* phase : kPhaseNames) EXPECT_TRUE(s["seconds"].contains(phase)) << phase;
  for (const char* count : {"bodies", "coordinates", "particles", "contacts", "tiles", "voxels", "cg_iterations"})
    EXPECT_TRUE(s["counts"].contains(count)) << count;
  EXPECT_EQ(s["steps"], 12);
  EXPECT_NEAR(s["simulated_seconds"].get<double>(), 0.12, 1e-12);
  EXPECT_EQ(s["expect"][1]["ok"], false);
  EXPECT_EQ(text_of(folder_ / "run/scene.json"), kScene) << "the scene as run";
}

TEST_F(Run, FoldersWithOtherFilesAreNeverTouched) {
  const Scene scene = parse_scene(kScene);
  World world = build_world(scene);
  fs::create_directories(folder_ / "mine");
  std::ofstream(folder_ / "mine/letter.txt") << "dear";
  EXPECT_THROW(record_run(world, plan(scene, at("mine")), {}), InputError);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "mine"), fs::directory_iterator()), 1);

  record_run(world, plan(scene, at("run")), {});
  EXPECT_THROW(record_run(world, plan(scene, at("run")), {}), InputError) << "an old run needs force";
  std::ofstream(folder_ / "run/letter.txt") << "dear";
  RunPlan again = plan(scene, at("run"));
  again.force = true;
  World fresh = build_world(scene);
  EXPECT_NO_THROW(record_run(fresh, again, {}));
  EXPECT_TRUE(fs::exists(folder_ / "run/letter.txt"));
}

TEST_F(Run, OtherFilesAreNotTakenForRuns) {
  fs::create_directories(folder_);
  std::ofstream(folder_ / "a.h5") << "not HDF5 at all";
  EXPECT_THROW(RunReader{at("a.h5")}, InputError);
  EXPECT_THROW(RunReader{at("none")}, InputError);
  EXPECT_THROW(RunReader{folder_.string()}, InputError);
}

TEST_F(Run, XdmfIsWellFormedAndNamesWhatTheFileHolds) {
  std::string text = kScene;
  text.insert(text.find("{\"kind\": \"rigid\""),
              R"({"kind": "cloth", "name": "sheet", "grid": {"size": [0.6, 0.6], "cells": [3, 3]},
    "thickness": 0.05, "transform": {"position": [3, 0, 1]}},
   {"kind": "rod", "name": "rope", "radius": 0.04, "segments": 3, "points": [[-3, 0, 1], [-2, 0, 1]]},
   )");
  const Scene scene = parse_scene(text);
  World world = build_world(scene);
  record_run(world, plan(scene, at("run")), {});
  const std::string script =
      "import sys,xml.etree.ElementTree as e\n"
      "r=e.parse(sys.argv[1]).getroot()\n"
      "t=r.find('Domain/Grid')\n"
      "assert t.get('CollectionType')=='Temporal'\n"
      "fs=t.findall('Grid')\n"
      "assert len(fs)==13, len(fs)\n"
      "assert abs(float(fs[12].find('Time').get('Value'))-0.12)<1e-9\n"
      "assert [g.get('Name') for g in fs[5].findall('Grid')]==['sheet','rope','poses']\n"
      "seen=0\n"
      "for g in fs[12].findall('Grid'):\n"
      "  for item in g.iter('DataItem'):\n"
      "    start,stride,count,size=[list(map(int,x.split())) for x in item.text.split('|')[1].split(':')]\n"
      "    assert all(b+c<=n for b,c,n in zip(start,count,size)), item.text\n"
      "    assert list(map(int,item.get('Dimensions').split()))==count\n"
      "    seen+=1\n"
      "assert seen==6, seen\n";
  std::ofstream(folder_ / "check.py") << script;
  if (std::system("python3 -c 'import xml.etree.ElementTree' 2>/dev/null") != 0) GTEST_SKIP() << "no Python here";
  EXPECT_EQ(std::system(fmt::format("python3 '{}' '{}'", at("check.py"), at("run/run.xdmf")).c_str()), 0);
}

}  // namespace
}  // namespace brim
