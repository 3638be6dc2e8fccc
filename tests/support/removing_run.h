#pragma once

#include <filesystem>
#include <random>
#include <string>

#include "brim/record/runner.h"
#include "brim/scene/scene.h"

namespace brim::testing {

/// A recorded run of five frames, 0.1 s apart, with a body of every kind of display. The timeline removes all but the
/// floor, which is body 0, in the third.
struct RemovingRun {
  static constexpr std::int64_t kGone = 3;  ///< the first frame without them
  static constexpr const char* kNames[] = {"stone", "box", "sheet", "jelly", "rope", "hoop", "grains", "water"};

  std::filesystem::path path;  ///< holds the run in "run"; removed at the end
  Scene scene;
  std::string folder() const { return (path / "run").string(); }

  static std::string text() {
    std::string timeline;
    for (const char* name : kNames)
      timeline += std::string(timeline.empty() ? "" : ", ") + R"({"at": 0.15, "remove": ")" + name + "\"}";
    return R"({
    "brim": 1, "name": "removing", "frames": 4, "steps_per_frame": 1,
    "world": {"gravity": [0, 0, 0], "time_step": 0.1},
    "bodies": [
      {"kind": "obstacle", "name": "floor", "shape": {"kind": "box", "size": [9, 9, 0.2]},
       "transform": {"position": [0, 0, -5]}},
      {"kind": "points", "name": "stone", "radius": 0.1, "positions": [[-3, 0, 0]]},
      {"kind": "rigid", "name": "box", "shape": {"kind": "box", "size": [0.3, 0.2, 0.1]},
       "velocity": [0, 0, 0.5], "angular_velocity": [3, 2, 1]},
      {"kind": "cloth", "name": "sheet", "grid": {"size": [0.6, 0.6], "cells": [3, 3]}, "thickness": 0.05,
       "velocity": [0, 0, 0.5], "transform": {"position": [2, 0, 0]}},
      {"kind": "finite_elements", "name": "jelly", "shape": {"kind": "box", "size": [0.4, 0.4, 0.4]},
       "velocity": [0, 0, 0.5], "lattice_spacing": 0.2, "transform": {"position": [0, 2, 0]}},
      {"kind": "rod", "name": "rope", "points": [[-1, 2, 0], [-2, 2, 0]], "segments": 4, "radius": 0.05},
      {"kind": "rod", "name": "hoop", "points": [[2, 2, 0], [3, 2, 0], [3, 3, 0]], "segments": 4, "radius": 0.05,
       "velocity": [0, 0, 0.5]},
      {"kind": "points", "name": "grains", "radius": 0.1, "grid": {"count": [2, 2, 1]}, "velocity": [0, 0, 0.5],
       "transform": {"position": [0, -2, 0]}},
      {"kind": "grid_fluid", "name": "water", "cell_size": 0.1, "box": {"lo": [3, -3, 0], "hi": [3.4, -2.6, 0.4]},
       "fill": [{"kind": "box", "lo": [3, -3, 0], "hi": [3.2, -2.6, 0.2]}]}
    ],
    "timeline": [)" +
           timeline + "]}";
  }

  RemovingRun()
      : path(std::filesystem::temp_directory_path() / ("brim_removing_run_" + std::to_string(std::random_device{}()))),
        scene(parse_scene(text())) {
    World world = build_world(scene);
    RunPlan plan;
    plan.folder = folder();
    plan.info = {scene.name, scene.text, scene.frame_time(), scene.steps_per_frame};
    plan.scene_file = scene.file;
    plan.frames = plan.scene_frames = scene.frames;
    record_run(world, plan, [](const RunProgress&) { return true; });
  }
  ~RemovingRun() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  RemovingRun(const RemovingRun&) = delete;
  RemovingRun& operator=(const RemovingRun&) = delete;
};

}  // namespace brim::testing
