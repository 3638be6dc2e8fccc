#include "brim/world/coarse_space.h"

#include <gtest/gtest.h>

#include "support/worlds.h"

namespace brim::testing::coarse_space_test {
namespace {

/// Iterations per solve over the first steps of a tower of boxes.
double iterations_of_tower(int boxes) {
  World w(options_at(1.0 / 8));
  w.add(ground(0.5));
  for (int i = 0; i < boxes; ++i) w.add(box("box." + std::to_string(i), {Vec3(0.01 * (i % 3), 0, 0.5 + 1.001 * i)}));
  double iterations = 0.0, solves = 0.0;
  for (int s = 0; s < 10; ++s) {
    const StepReport r = w.step();
    iterations += r.cg_iterations;
    solves += r.solves;
  }
  return iterations / solves;
}

TEST(CoarseSpace, ATowerOfRigidBodiesNeedsNoIterationsPerStorey) {
  // The coarse level is the whole problem here; what is left is rounding.
  EXPECT_LE(iterations_of_tower(2), 3.0);
  EXPECT_LE(iterations_of_tower(8), 3.0);
}

}  // namespace
}  // namespace brim::testing::coarse_space_test
