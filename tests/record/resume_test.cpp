#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "brim/core/error.h"
#include "brim/record/h5.h"
#include "brim/record/scene_change.h"
#include "support/recorded_fall.h"

/// A run that is gone on with is the run that was never interrupted.
namespace brim::resume_test {
namespace {

namespace fs = std::filesystem;
using testing::kScene;
using testing::Run;
using testing::same_bits;
using testing::text_of;

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
  EXPECT_EQ(record_run(second, resumed(scene, at("parts")), {}).end, RunEnd::Completed);
  const RunReader a(at("straight")), b(at("parts"));
  ASSERT_EQ(a.frames(), b.frames());
  for (std::int64_t f = 0; f < a.frames(); ++f) {
    SCOPED_TRACE(f);
    const State x = a.state(f), y = b.state(f);
    EXPECT_TRUE(same_bits(x.q, y.q) && same_bits(x.v, y.v) && same_bits(x.warm_start, y.warm_start));
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

TEST_F(Run, ARunThatHasNoImpulsesIsReadAndGoneOnWith) {
  const Scene scene = parse_scene(kScene);
  World straight = build_world(scene);
  record_run(straight, plan(scene, at("straight")), {});
  World first = build_world(scene);
  record_run(first, plan(scene, at("old")), [](const RunProgress& p) { return p.frame < 7; });
  h5::File(at("old/run.h5"), h5::File::Mode::Write).remove("/motion/impulse");
  const std::int64_t there = RunReader(at("old")).frames();
  EXPECT_EQ(RunReader(at("old")).samples(there - 1)[2].impulse, Vec3::Zero());
  World second = build_world(scene);
  record_run(second, resumed(scene, at("old")), {});
  const RunReader a(at("straight")), b(at("old"));
  ASSERT_EQ(a.frames(), b.frames());
  double largest = 0.0;
  for (std::int64_t f = 0; f < a.frames(); ++f) {
    const Vec3 impulse = a.samples(f)[2].impulse;
    EXPECT_EQ(b.samples(f)[2].impulse, f < there ? Vec3::Zero() : impulse) << f;
    if (f >= there) largest = std::max(largest, impulse.norm());
  }
  EXPECT_GT(largest, 0.0) << "nothing touched";
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
  record_run(again, resumed(scene, at("run")), {});
  EXPECT_TRUE(same_bits(RunReader(at("run")).state(12).q, last.q));
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

}  // namespace
}  // namespace brim::resume_test
