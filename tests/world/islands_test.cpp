#include "brim/world/islands.h"

#include <gtest/gtest.h>

#include "brim/body/rigid/rigid_body.h"
#include "support/soft_worlds.h"

namespace brim::islands_test {
namespace {

TEST(Islands, AreNumberedInTheOrderOfTheirFirstBodies) {
  Islands i(6);
  i.join(5, 1), i.join(4, 2), i.join(5, 3);
  EXPECT_EQ(i.first_of(5), 1);
  EXPECT_EQ(i.numbers(), (std::vector<std::int32_t>{0, 1, 2, 1, 2, 1}));
}

/// A sheet lies still on a box, which is fixed; a metre beside it a block of 25 kg falls and hits the ground.
TEST(Islands, WhatHitsTheGroundDoesNotStirWhatLiesElsewhere) {
  const auto fastest = [](bool block) {
    WorldOptions o = testing::options_at(0.05);
    o.time_step = 1.0 / 120.0;
    World w(o);
    w.add(testing::ground(0.5));
    w.add(testing::obstacle("seat", make_box(Vec3(0.3, 0.3, 0.3)), 0.5, Vec3(2, 0, 0.15)));
    w.add(testing::sheet("sheet", 0.5, Vec3(2, 0, 0.34)));
    if (block) w.add(testing::box("block", {Vec3(0, 0, 1.5)}, 0.5, 0.3, 1000));
    double most = 0.0;
    for (int s = 0; s < 120; ++s) {
      w.step();
      for (std::size_t k = 0; s > 40 && k < w.v(2).size(); ++k) most = std::max(most, std::abs(w.v(2)[k]));
    }
    return most;
  };
  const double alone = fastest(false);
  EXPECT_LT(fastest(true), 2.0 * alone + 1e-3);
}

}  // namespace
}  // namespace brim::islands_test
