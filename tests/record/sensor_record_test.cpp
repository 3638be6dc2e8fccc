#include "brim/record/sensor_record.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "brim/core/error.h"
#include "brim/record/runner.h"
#include "brim/record/sensor_csv.h"
#include "brim/scene/scene.h"
#include "brim/world/sense/sensors.h"

namespace brim::sensor_record_test {
namespace {

namespace fs = std::filesystem;

const char* const kSensors = R"([
  {"name": "plate", "kind": "force", "body": "floor", "sample": "step"},
  {"name": "touch", "kind": "contact", "body": "ball", "gap": 0.03},
  {"name": "map", "kind": "pressure", "body": "floor", "grid": {"origin": [-1, -1, 0], "x": [3, 0, 0], "y": [0, 2, 0], "cells": [6, 4]}},
  {"name": "a, \"b\"", "kind": "motion", "body": "ball"}
])";

std::string scene_text(const std::string& sensors, int frames) {
  return R"({"brim": 1, "name": "fall", "frames": )" + std::to_string(frames) +
         R"(, "steps_per_frame": 2, "world": {"time_step": 0.01},
  "bodies": [
    {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
    {"kind": "rigid", "name": "ball", "response": "constraint", "shape": {"kind": "sphere", "radius": 0.5}, "transform": {"position": [0, 0, 0.53]},
     "velocity": [0.5, 0, -1]}
  ],
  "sensors": )" +
         sensors +
         R"(, "expect": [{"metric": "sensor", "sensor": "plate", "channel": "impulse_z", "take": "sum", "max": 0}]})";
}

class SensorRecords : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / fmt::format("brim_sensors_{}", ::getpid());
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  RunResult run(const std::string& name, const std::string& text, std::int64_t frames, bool resume = false,
                bool edit = false) {
    const Scene scene = parse_scene(text);
    World world = build_world(scene);
    RunPlan p;
    p.folder = (folder_ / name).string();
    p.info = {scene.name, scene.text, scene.frame_time(), scene.steps_per_frame};
    p.frames = frames, p.scene_frames = scene.frames;
    p.expect = scene.expect;
    p.resume = resume, p.edit = edit;
    return record_run(world, p, {});
  }
  std::string text_of(const std::string& run, const std::string& file) const {
    std::ostringstream out;
    out << std::ifstream(folder_ / run / file).rdbuf();
    return out.str();
  }

  fs::path folder_;
};

TEST_F(SensorRecords, HoldWhatSensorsOfTheSameRunRead) {
  run("whole", scene_text(kSensors, 12), 12);
  const RunReader reader((folder_ / "whole").string());
  const SensorRecord record(reader);
  ASSERT_EQ(record.sensors().size(), 4u);
  EXPECT_EQ(record.sensors()[2].rows, 4);
  EXPECT_EQ(record.sensors()[2].columns, 6);
  EXPECT_EQ(record.sensors()[2].width, 3.0);
  EXPECT_EQ(record.sensors()[3].name, "a, \"b\"");

  World world = build_world(parse_scene(scene_text(kSensors, 12)));
  Sensors& sensors = *find_sensors(world);
  std::size_t events = 0, steps = 0;
  for (std::int64_t f = 1; f <= 12; ++f) {
    sensors.begin_frame();
    world.step(), world.step();
    for (std::size_t i = 0; i < 4; ++i) {
      const auto values = record.values(i);
      const auto& now = sensors.frame(i).values;
      for (std::size_t c = 0; c < now.size(); ++c) {
        const double x = values[static_cast<std::size_t>(f) * now.size() + c];
        EXPECT_TRUE(x == now[c] || (std::isnan(x) && std::isnan(now[c]))) << record.sensors()[i].name << c;
      }
    }
    const auto map = record.map(2, f);
    for (std::size_t c = 0; c < map.size(); ++c) EXPECT_EQ(map[c], static_cast<float>(sensors.frame(2).map[c]));
    events += sensors.frame_events().size();
    EXPECT_EQ(record.events(f).size(), sensors.frame_events().size());
    steps += 2;
  }
  EXPECT_GT(events, 0u);
  EXPECT_EQ(record.all_events().size(), events);
  EXPECT_EQ(record.steps(0).size(), steps * (1 + record.sensors()[0].channels.size()));
  EXPECT_THROW(record.steps(1), InputError);
  EXPECT_THROW(record.map(0, 0), InputError);
  EXPECT_THROW(record.map(2, 13), InputError);
}

TEST_F(SensorRecords, ARunThatWasResumedHasTheSameTables) {
  const RunResult whole = run("whole", scene_text(kSensors, 12), 12);
  run("parts", scene_text(kSensors, 12), 5);
  const RunResult resumed = run("parts", scene_text(kSensors, 12), 12, true);
  for (const std::string& file : sensor_csv_files()) {
    EXPECT_FALSE(text_of("whole", file).empty()) << file;
    EXPECT_EQ(text_of("parts", file), text_of("whole", file)) << file;
  }
  EXPECT_EQ(resumed.findings[0].value, whole.findings[0].value);
  EXPECT_LT(whole.findings[0].value, 0.0);
}

TEST_F(SensorRecords, TablesHaveALineForEachFrameStepAndEvent) {
  run("whole", scene_text(kSensors, 12), 12);
  const auto lines = [&](const char* file) {
    const std::string text = text_of("whole", file);
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(lines("sensors.csv"), 1 + 13);
  EXPECT_EQ(lines("sensor_steps.csv"), 1 + 24);
  EXPECT_GE(lines("events.csv"), 2);
  const std::string head = text_of("whole", "sensors.csv").substr(0, text_of("whole", "sensors.csv").find('\n'));
  EXPECT_TRUE(head.starts_with("frame,time [s],plate.force_x [N],plate.force_y [N],plate.force_z [N],")) << head;
  EXPECT_NE(head.find(",\"a, \"\"b\"\".position_x [m]\","), std::string::npos) << head;
}

TEST_F(SensorRecords, ARunGoesOnWithSensorsThatItDidNotHave) {
  run("run", scene_text(R"([{"name": "plate", "kind": "force", "body": "floor"}])", 12), 5);
  run("run",
      scene_text(
          R"([{"name": "plate", "kind": "force", "body": "floor"}, {"name": "touch", "kind": "contact", "body": "ball"}])",
          12),
      12, true, true);
  const RunReader reader((folder_ / "run").string());
  const SensorRecord record(reader);
  ASSERT_EQ(record.sensors().size(), 2u);
  const auto values = record.values(1);
  const std::size_t n = record.sensors()[1].channels.size();
  ASSERT_EQ(values.size(), 13 * n);
  EXPECT_TRUE(std::isnan(values[5 * n]));
  EXPECT_FALSE(std::isnan(values[6 * n]));
}

TEST_F(SensorRecords, ARunWithoutSensorsHasNone) {
  const std::string text = scene_text("[]", 3);
  const auto at = text.find(", \"expect\"");
  run("run", text.substr(0, at) + "}", 3);
  const RunReader reader((folder_ / "run").string());
  EXPECT_TRUE(SensorRecord(reader).sensors().empty());
  EXPECT_TRUE(SensorRecord(reader).all_events().empty());
  EXPECT_FALSE(fs::exists(folder_ / "run/sensors.csv"));
}

}  // namespace
}  // namespace brim::sensor_record_test
