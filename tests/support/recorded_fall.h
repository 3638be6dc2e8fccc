#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "brim/record/runner.h"
#include "brim/scene/scene.h"
#include "support/text_of.h"

namespace brim::testing {

namespace fs = std::filesystem;

/// A ball falls on a floor while a bar above it begins to move after 0.05 s.
inline const char* const kScene = R"({
  "brim": 1, "name": "fall", "frames": 12, "world": {"response": "penalty", "time_step": 0.01},
  "bodies": [
    {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
    {"kind": "obstacle", "name": "bar", "shape": {"kind": "box", "size": [1, 0.1, 0.1]}, "transform": {"position": [0, 0, 3]},
     "keyframes": [{"time": 0.05}, {"time": 0.1, "offset": [0, 1, 0]}]},
    {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.5}, "transform": {"position": [0, 0, 0.51]},
     "velocity": [0.5, 0, -1]}
  ],
  "expect": [{"metric": "lowest", "body": "ball", "min": -0.2}, {"metric": "position_x", "body": "ball", "min": 100}]
})";

/// Runs of that scene in a folder of the test's own.
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
  /// The plan that goes on with the run in a folder.
  static RunPlan resumed(const Scene& scene, const std::string& folder) {
    RunPlan p = plan(scene, folder);
    p.resume = true;
    return p;
  }

  fs::path folder_;
};

inline bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

}  // namespace brim::testing
