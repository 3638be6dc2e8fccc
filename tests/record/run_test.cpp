#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "brim/body/changing_surface.h"
#include "brim/core/error.h"
#include "brim/world/report_fields.h"
#include "support/recorded_fall.h"

/// What a run records is what there was.
namespace brim::run_test {
namespace {

namespace fs = testing::fs;
using testing::kScene;
using testing::Run;
using testing::same_bits;
using testing::text_of;

TEST_F(Run, EveryFrameIsReadBackBitForBit) {
  const Scene scene = parse_scene(kScene);
  World world = build_world(scene);
  std::vector<State> states = {world.state()};
  std::vector<std::vector<ContactSample>> contacts = {{}};
  std::vector<StepReport> reports = {world.present()};
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
    EXPECT_TRUE(same_bits(s.q, states[i].q) && same_bits(s.v, states[i].v) &&
                same_bits(s.warm_start, states[i].warm_start));
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

TEST_F(Run, TheFirstFrameKnowsTheEnergyOfTheStart) {
  const Scene scene = parse_scene(R"({
    "brim": 1, "name": "start", "frames": 1, "world": {"time_step": 0.01},
    "bodies": [{"kind": "rigid", "name": "ball", "density": 500, "shape": {"kind": "sphere", "radius": 0.1},
                "velocity": [3, 0, 4], "transform": {"position": [0, 0, 2]}}],
    "attachments": [{"name": "band", "body": "ball", "point": [0, 0, 2], "to_point": [0, 0, 4], "stiffness": 10,
                     "length": 1}]})");
  World world = build_world(scene);
  record_run(world, plan(scene, at("run")), {});
  const RunReader run(at("run"));
  const double mass = 500.0 * 4.0 / 3.0 * std::numbers::pi * 1e-3;
  EXPECT_NEAR(run.series("kinetic_energy")[0], 0.5 * mass * 25.0, 1e-9);
  EXPECT_NEAR(run.series("potential_energy")[0], mass * 9.81 * 2.0 + 0.5 * 10.0, 1e-9);
  EXPECT_GE(run.series("max_speed")[0], 5.0);
  EXPECT_EQ(run.series("substeps")[0], 0.0);
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
  record_run(world, resumed(scene, at("parts")), {});
  expect_all(at("parts"));
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

TEST_F(Run, AStepThatMemoryHasNoRoomForEndsTheRunWithTheFramesBeforeIt) {
  std::string text = kScene;
  text.replace(text.find("\"world\": {"), 10, "\"world\": {\"memory_limit\": 4e4, ");
  text.replace(text.find("0.51"), 4, "0.58");  // met after some frames
  const Scene scene = parse_scene(text);
  World world = build_world(scene);
  const RunResult result = record_run(world, plan(scene, at("full")), {});
  EXPECT_EQ(result.end, RunEnd::Failed);
  EXPECT_EQ(result.refused.find("scene.json: world: "), 0u) << result.refused;
  EXPECT_NE(result.refused.find("memory_limit"), std::string::npos) << result.refused;
  EXPECT_GT(RunReader(at("full")).frames(), 1);
  const auto s = nlohmann::json::parse(text_of(folder_ / "full/summary.json"));
  EXPECT_EQ(s["end"], "failed");
  EXPECT_EQ(s["warnings"]["codes"]["refused"], 1);
}

TEST_F(Run, WhatAStepRefusesNamesTheSceneFromItsFirstStepOn) {
  std::string text = kScene;
  text.replace(text.find("\"world\": {"), 10, "\"world\": {\"memory_limit\": 4e4, ");
  text.replace(text.find("0.51"), 4, "0.4");  // they overlap
  const Scene scene = parse_scene(text, "tight.json");
  World world = build_world(scene);
  try {
    record_run(world, plan(scene, at("none")), {});
    FAIL() << "there is no room for the first step";
  } catch (const InputError& e) {
    EXPECT_EQ(std::string(e.what()).find("tight.json: world: "), 0u) << e.what();
  }
  EXPECT_FALSE(fs::exists(at("none")));
}

TEST_F(Run, ARunThatIsStoppedWithinAStepKeepsTheFramesBeforeItAndGoesOnToTheSameBits) {
  const Scene scene = parse_scene(kScene);
  World straight = build_world(scene);
  int asked = 0, frames = 0;
  RunPlan whole = plan(scene, at("straight"));
  whole.stop = [&] { return ++asked < 0; };
  record_run(straight, whole, [&](const RunProgress&) { return ++frames > 0; });
  EXPECT_GT(asked, 3 * frames) << "it must be asked within steps, or the test is blind";
  World never = build_world(scene);
  record_run(never, plan(scene, at("never")), {});
  EXPECT_EQ(straight.hash(), never.hash()) << "asking changes nothing";
  const RunReader all(at("straight"));
  for (const int last : {1, 2, asked / 2, asked - 1}) {
    SCOPED_TRACE(last);
    World world = build_world(scene);
    RunPlan p = plan(scene, at("run"));
    p.force = true;
    int left = last;
    p.stop = [&] { return --left <= 0; };
    const RunResult result = record_run(world, p, {});
    EXPECT_EQ(result.end, RunEnd::Interrupted);
    const std::int64_t end = RunReader(at("run")).frames() - 1;
    EXPECT_LT(end, 12);
    EXPECT_EQ(result.totals.frames, end + 1);
    EXPECT_TRUE(same_bits(world.state().q, all.state(end).q) && same_bits(world.state().v, all.state(end).v) &&
                same_bits(world.state().warm_start, all.state(end).warm_start))
        << "the world is that of the last frame";
    const auto s = nlohmann::json::parse(text_of(folder_ / "run/summary.json"));
    EXPECT_EQ(s["end"], "interrupted");
    EXPECT_EQ(s["frames"], end + 1);
    World again = build_world(scene);
    p.force = false, p.resume = true, p.stop = {};
    EXPECT_EQ(record_run(again, p, {}).end, RunEnd::Completed);
    EXPECT_EQ(again.hash(), straight.hash());
  }
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
}  // namespace brim::run_test
