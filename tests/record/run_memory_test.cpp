#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "brim/record/runner.h"
#include "brim/scene/scene.h"
#include "support/heap.h"

namespace brim::run_memory_test {
namespace {

namespace fs = std::filesystem;

/// A box at rest on a floor that a sensor watches; every kind of metric is asked of it.
const char* const kScene = R"({
  "brim": 1, "name": "long", "frames": 40959, "world": {"time_step": 0.01, "response": "constraint"},
  "bodies": [
    {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
    {"kind": "rigid", "name": "box", "shape": {"kind": "box", "size": [1, 1, 1]}, "transform": {"position": [0, 0, 0.5]}}
  ],
  "sensors": [{"kind": "force", "name": "plate", "body": "floor"}],
  "expect": [{"metric": "drift", "body": "box", "max": 1e-4}, {"metric": "worst_overlap", "max": 1},
             {"metric": "energy_rise", "max": 1}, {"metric": "momentum_change", "max": 1}, {"metric": "step_seconds", "max": 1},
             {"metric": "front", "body": "box", "max": 1},
             {"metric": "sensor", "sensor": "plate", "channel": "force_z", "take": "mean", "max": 1}]
})";

class LongRun : public ::testing::Test {
 protected:
  std::string folder_ = (fs::temp_directory_path() / fmt::format("brim_long_run_{}", ::getpid())).string();
  void TearDown() override { fs::remove_all(folder_); }
};

/// What a frame says lies in the file. What HDF5 keeps of an open file grows until it is dropped, every 8192 frames,
/// and by a step where an index gets another level, at 15,000 frames and 800,000: highest values of two spans between
/// are compared.
TEST_F(LongRun, KeepsNoMemoryPerFrame) {
  if (!testing::heap_is_measurable()) GTEST_SKIP() << "this allocator does not say what is in use";
  constexpr std::int64_t kPeriod = 8192, kFrames = 5 * kPeriod - 1;
  const Scene scene = parse_scene(kScene);
  World world = build_world(scene);
  RunPlan plan;
  plan.folder = folder_;
  plan.info = {scene.name, scene.text, scene.frame_time(), 1};
  plan.frames = plan.scene_frames = kFrames;
  plan.expect = scene.expect;
  std::map<std::int64_t, std::size_t> heap;  // highest in each span of kPeriod frames, [bytes]
  const RunResult result = record_run(world, plan, [&](const RunProgress& p) {
    std::size_t& most = heap[p.frame / kPeriod];
    if (p.frame % 64 == 0) most = std::max(most, testing::bytes_in_use());
    return true;
  });
  EXPECT_TRUE(result.ok());
  ASSERT_EQ(heap.size(), 5u);
  EXPECT_LT(static_cast<double>(heap[4]) - static_cast<double>(heap[2]), 8.0 * 2.0 * kPeriod)
      << "8 bytes a frame; a report alone has 400";

  // Nothing was lost where the file was closed and opened again.
  const RunReader run(folder_);
  ASSERT_EQ(run.frames(), kFrames + 1);
  for (const std::int64_t f : {kPeriod - 1, kPeriod, kPeriod + 1, kFrames}) {
    EXPECT_EQ(run.state(f).step, f);
    EXPECT_NEAR(run.state(f).time, 0.01 * static_cast<double>(f), 1e-6);
  }
  std::ifstream xdmf(fs::path(folder_) / "run.xdmf");
  std::int64_t frames = 0;
  for (std::string line; std::getline(xdmf, line);) frames += line.find("<Time ") != std::string::npos;
  EXPECT_EQ(frames, kFrames + 1);
}

}  // namespace
}  // namespace brim::run_memory_test
