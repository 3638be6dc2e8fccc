#include "brim/body/posed_display.h"

#include <gtest/gtest.h>

#include "brim/body/changing_surface.h"
#include "brim/scene/scene.h"

namespace brim::posed_display_test {
namespace {

TEST(PosedDisplay, PiecesAtTheirPosesAreTheDisplayBitForBit) {
  const Scene scene = parse_scene(R"({
    "brim": 1, "name": "posed", "frames": 4, "world": {"time_step": 0.01},
    "bodies": [
      {"kind": "obstacle", "name": "bar", "shape": {"kind": "box", "size": [1, 0.1, 0.1]},
       "keyframes": [{"time": 0}, {"time": 1, "offset": [0, 1, 0], "rotation": {"axis": [0, 0, 1], "degrees": 90}}]},
      {"kind": "rigid", "name": "ball", "shape": {"kind": "box", "size": [0.3, 0.2, 0.1]},
       "transform": {"position": [0, 0, 5]}, "angular_velocity": [3, 2, 1]},
      {"kind": "cloth", "name": "sheet", "grid": {"size": [0.6, 0.6], "cells": [3, 3]}, "thickness": 0.05,
       "transform": {"position": [5, 0, 5]}}
    ]})");
  World world = build_world(scene);
  for (int f = 0; f < 3; ++f) {
    for (int b = 0; b < 2; ++b) {
      const Body& body = world.body(b);
      const PosedDisplay* posed = posed_display(body);
      ASSERT_NE(posed, nullptr);
      std::vector<Vec3f> shown, placed(body.display().vertices);
      display_now(body, shown);
      std::size_t first = 0;
      for (std::size_t i = 0; i < posed->piece_count(); ++i) {
        const auto& rest = posed->piece(i).surface().vertices;
        place_vertices(rest, posed->piece(i).pose(), std::span(placed).subspan(first, rest.size()));
        first += rest.size();
      }
      EXPECT_EQ(first, shown.size());
      EXPECT_EQ(placed, shown);
    }
    world.step();
  }
  EXPECT_EQ(posed_display(world.body(2)), nullptr) << "a sheet deforms";
}

}  // namespace
}  // namespace brim::posed_display_test
