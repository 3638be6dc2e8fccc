#include "server/density_slice.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <random>

#include "brim/core/error.h"
#include "brim/record/runner.h"
#include "brim/scene/scene.h"
#include "server/rebuilt_world.h"
#include "support/worlds.h"

namespace brim::viewer::density_slice_test {
namespace {

namespace fs = std::filesystem;
using namespace brim::testing;

double ramp(double distance, double w) {
  const double s = std::clamp(0.5 - distance / w, 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

/// Position of node (i, j) of a slice.
Vec3 node(const DensitySlice& s, int i, int j) {
  Vec3 x;
  x[s.axis] = s.at;
  x[(s.axis + 1) % 3] = s.step * (s.first[0] + i);
  x[(s.axis + 2) % 3] = s.step * (s.first[1] + j);
  return x;
}

World two_balls() {
  World world(options_at(0.1));
  world.add(ground(0.5));
  world.add(ball("a", {.x = Vec3(0, 0, 0.45)}));
  world.add(ball("b", {.x = Vec3(0.3, 0.85, 0.5)}));
  return world;
}

TEST(DensitySlices, HoldTheDensitiesOfTheTwoFullestBodiesAtEveryNodeOfAnyPlane) {
  const World world = two_balls();
  const auto density = [](int body, const Vec3& x) {
    if (body == 0) return ramp(x.z(), 0.3);
    return ramp((x - (body == 1 ? Vec3(0, 0, 0.45) : Vec3(0.3, 0.85, 0.5))).norm() - 0.5, 0.3);
  };
  std::mt19937 random(20240);  // seed
  std::uniform_real_distribution<double> place(-0.2, 0.9);
  double worst_overlap = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    for (int trial = 0; trial < 4; ++trial) {
      const double at = place(random);
      SCOPED_TRACE(fmt::format("axis {} at {}", axis, at));
      const DensitySlice s = cut_densities(world, {.axis = axis, .at = at});
      EXPECT_EQ(s.step, 0.1);
      EXPECT_NEAR(s.at, at, 0.05 + 1e-12);
      for (int j = 0; j < s.count[1]; ++j)
        for (int i = 0; i < s.count[0]; ++i) {
          const Vec3 x = node(s, i, j);
          std::array<std::pair<double, int>, 3> rho;
          for (int b = 0; b < 3; ++b) rho[static_cast<std::size_t>(b)] = {density(b, x), b};
          std::sort(rho.rbegin(), rho.rend());
          const auto n = static_cast<std::size_t>(j * s.count[0] + i);
          ASSERT_NEAR(s.density[n], rho[0].first, 1e-6) << x.transpose();
          ASSERT_NEAR(s.second[n], rho[1].first, 1e-6) << x.transpose();
          if (rho[0].first > rho[1].first + 1e-6) {
            ASSERT_EQ(s.body[n], rho[0].second);
          }
          const double overlap = std::max(0.0, rho[0].first + rho[1].first - 1.0);
          ASSERT_NEAR(s.overlap[n], overlap, 1e-6);
          worst_overlap = std::max(worst_overlap, overlap);
        }
    }
  EXPECT_GT(worst_overlap, 0.1) << "the planes must meet an overlap, or the test is blind";
}

TEST(DensitySlices, OfOneBodyShowThatBodyAlone) {
  const World world = two_balls();
  const DensitySlice s = cut_densities(world, {.axis = 2, .at = 0.4, .body = 2, .step = 0.05});
  EXPECT_EQ(s.step, 0.05);
  double most = 0.0;
  for (std::size_t n = 0; n < s.density.size(); ++n) {
    EXPECT_TRUE(s.body[n] == 2 || (s.body[n] == -1 && s.density[n] == 0.0f));
    EXPECT_EQ(s.overlap[n], 0.0f);
    most = std::max(most, static_cast<double>(s.density[n]));
  }
  EXPECT_EQ(most, 1.0);
}

TEST(DensitySlices, WhatIsNotThereIsRefusedAndAnEmptyWorldHasAnEmptySlice) {
  const World world = two_balls();
  EXPECT_THROW(cut_densities(world, {.axis = 3}), InputError);
  EXPECT_THROW(cut_densities(world, {.body = 3}), InputError);
  EXPECT_THROW(cut_densities(world, {.at = std::nan("")}), InputError);
  EXPECT_THROW(cut_densities(world, {.step = -1.0}), InputError);
  EXPECT_THROW(cut_densities(world, {.step = std::nan("")}), InputError);
  const World nothing(options_at(0.1));
  const DensitySlice s = cut_densities(nothing, {});
  EXPECT_EQ(s.density.size(), static_cast<std::size_t>(s.count[0] * s.count[1]));
  EXPECT_EQ(*std::max_element(s.density.begin(), s.density.end()), 0.0f);
}

TEST(DensitySlices, TakeBoundedWork) {
  const World world = two_balls();
  for (const double step : {1e-300, 1e-9, 0.024, 1e3, 1e300})
    EXPECT_THROW(cut_densities(world, {.step = step}), TooMuchWork);
  for (const double step : {0.025, 0.05, 1.0}) EXPECT_EQ(cut_densities(world, {.step = step}).step, step);
  World fine(options_at(1e-4));
  fine.add(ball("a", {}));
  // 1.16 m along both axes, at most 3e6 nodes: 8e-4 m, whoever asked for less.
  EXPECT_DOUBLE_EQ(cut_densities(fine, {}).step, 8e-4);
  EXPECT_DOUBLE_EQ(cut_densities(fine, {.step = 5e-5}).step, 8e-4);
  // Two balls at one place have 2 x 19,200 tiles of 8 x 8 nodes there.
  fine.add(ball("b", {}));
  EXPECT_DOUBLE_EQ(cut_densities(fine, {}).step, 1.6e-3);
  EXPECT_DOUBLE_EQ(cut_densities(fine, {.body = 1}).step, 8e-4);
  EXPECT_THROW(cut_densities(fine, {.step = 8e-4}), TooMuchWork);
}

TEST(RebuiltWorlds, HaveTheRecordedStateOfEveryFrame) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("brim_rebuilt_{}", ::getpid());
  fs::remove_all(folder);
  const Scene scene = parse_scene(R"({"brim": 1, "name": "drop", "frames": 4, "bodies": [
    {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
    {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.5}, "transform": {"position": [0, 0, 2]}}]})");
  World world = build_world(scene);
  RunPlan plan;
  plan.folder = folder.string();
  plan.info = {scene.name, scene.text, scene.frame_time(), scene.steps_per_frame};
  plan.frames = scene.frames;
  record_run(world, plan, {});
  const RunReader run(folder.string());
  RebuiltWorld rebuilt(run);
  for (const std::int64_t f : {3, 0, 4}) {
    const World& then = rebuilt.at(run, f);
    EXPECT_EQ(then.state().q, run.state(f).q);
    std::vector<Vec3f> x(then.body(1).display().vertices);
    then.body(1).display_positions(x);
    EXPECT_EQ(x, run.positions(1, f));
  }
  EXPECT_THROW(rebuilt.at(run, 5), InputError);
  fs::remove(folder / "scene.json");
  EXPECT_THROW(RebuiltWorld{run}, InputError);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace brim::viewer::density_slice_test
