#pragma once

#include <filesystem>
#include <optional>
#include <random>
#include <string>

#include "brim/record/runner.h"
#include "brim/scene/scene.h"

namespace brim::testing {

/// A recorded run of seven frames, 8 ms apart, in which a body of nearly every kind falls, turns or is moved. The
/// timeline removes the net before frame 5.
struct MovingRun {
  std::filesystem::path path;  ///< holds the run in "run"; removed at the end
  Scene scene;
  std::optional<World> world;
  std::string folder() const { return (path / "run").string(); }

  static constexpr const char* kText = R"({"brim": 1, "name": "moving", "frames": 6, "steps_per_frame": 4,
    "world": {"gravity": [0, 0, -9.81], "time_step": 0.002},
    "bodies": [
      {"kind": "obstacle", "name": "floor", "shape": {"kind": "box", "size": [9, 9, 0.2]},
       "transform": {"position": [0, 0, -3]}},
      {"kind": "obstacle", "name": "platform", "shape": {"kind": "box", "size": [1, 1, 0.1]},
       "transform": {"position": [0, -3, 0]}, "keyframes": [{"time": 0}, {"time": 1, "offset": [1, 0, 0]}]},
      {"kind": "rigid", "name": "box", "shape": {"kind": "box", "size": [0.3, 0.2, 0.1]},
       "transform": {"position": [-3, 0, 0]}, "velocity": [1, 0, 0], "angular_velocity": [3, 2, 1]},
      {"kind": "finite_elements", "name": "jelly", "shape": {"kind": "box", "size": [0.4, 0.4, 0.4]},
       "lattice_spacing": 0.2, "transform": {"position": [-1, 2, 0.5]}, "velocity": [0.5, 0, 0]},
      {"kind": "finite_elements", "name": "drop", "shape": {"kind": "sphere", "radius": 0.2}, "lattice_spacing": 0.2,
       "lattice": "covering", "transform": {"position": [-3, 2, 0]}, "velocity": [0.5, 0, 0]},
      {"kind": "meshless", "name": "blob", "shape": {"kind": "box", "size": [0.4, 0.4, 0.4]}, "frame_spacing": 0.2,
       "transform": {"position": [-2, 2, 0]}, "velocity": [0.5, 0, 0]},
      {"kind": "cloth", "name": "sheet", "grid": {"size": [0.6, 0.6], "cells": [3, 3]}, "thickness": 0.05,
       "transform": {"position": [2, 0, 0]}},
      {"kind": "mass_spring", "name": "net", "form": "net", "grid": {"size": [0.6, 0.6], "cells": [3, 3]},
       "thickness": 0.05, "density": 0.15, "stiffness": 3000, "transform": {"position": [2, 2, 0]}},
      {"kind": "rod", "name": "rope", "points": [[-1, 3, 0], [-2, 3, 0]], "segments": 4, "radius": 0.05,
       "velocity": [0, 0, 1]},
      {"kind": "points", "name": "sand", "radius": 0.05, "grid": {"count": [2, 2, 1]},
       "transform": {"position": [0, -2, 0]}, "velocity": [0, 0, -1]},
      {"kind": "particle_fluid", "name": "spray", "spacing": 0.1, "shape": {"kind": "box", "size": [0.3, 0.3, 0.3]},
       "transform": {"position": [2, -2, 0]}, "velocity": [0, 1, 0]},
      {"kind": "articulated", "name": "arm", "transform": {"position": [0, 0, 1]}, "links": [
        {"name": "upper", "joint": {"kind": "revolute", "axis": [0, 1, 0], "start_velocity": 3},
         "shape": {"kind": "box", "size": [0.1, 0.1, 0.4]}},
        {"name": "lower", "parent": "upper", "joint": {"kind": "ball", "position": [0, 0, -0.5]},
         "shape": {"kind": "box", "size": [0.1, 0.1, 0.3]}}]},
      {"kind": "grid_fluid", "name": "water", "cell_size": 0.1, "box": {"lo": [3, -3, 0], "hi": [4, -2, 1]},
       "fill": [{"kind": "sphere", "center": [3.5, -2.5, 0.5], "radius": 0.25}]}
    ],
    "timeline": [{"at": 0.035, "remove": "net"}]})";

  MovingRun()
      : path(std::filesystem::temp_directory_path() / ("brim_moving_run_" + std::to_string(std::random_device{}()))),
        scene(parse_scene(kText)) {
    World made = build_world(scene);
    RunPlan plan;
    plan.folder = folder();
    plan.info = {scene.name, scene.text, scene.frame_time(), scene.steps_per_frame};
    plan.scene_file = scene.file;
    plan.frames = plan.scene_frames = scene.frames;
    record_run(made, plan, [](const RunProgress&) { return true; });
  }
  ~MovingRun() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  MovingRun(const MovingRun&) = delete;
  MovingRun& operator=(const MovingRun&) = delete;

  /// The world built anew, in the state of a frame.
  const World& world_at(std::int64_t frame) {
    if (!world) world.emplace(build_world(scene));
    world->set_state(RunReader(folder()).state(frame));
    return *world;
  }
};

}  // namespace brim::testing
