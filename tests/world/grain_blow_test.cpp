#include <gtest/gtest.h>

#include "brim/body/points/points_body.h"
#include "support/soft_worlds.h"

/// Layers of grains that hit what stops the lowest of them (ForeseesContact).
namespace brim::grain_blow_test {
namespace {

TEST(GrainBlow, LayersThatCameAlongGainNoEnergy) {
  // A speed of a fifth of the radius a step: the upper layers do not move against the lower ones until these are
  // stopped, and without foresight overlap them by that much at the end of that step.
  constexpr double radius = 0.024;
  for (const int layers : {2, 3}) {
    for (const Response response : {Response::Penalty, Response::Constraint}) {
      WorldOptions options = testing::options_at(0.02);
      options.environment.gravity.setZero();
      options.time_step = 0.005;
      options.response = response;
      World w(options);
      w.add(testing::ground(0.5));
      std::vector<Vec3> x;
      for (int k = 0; k < layers; ++k)
        for (int j = 0; j < 3; ++j)
          for (int i = 0; i < 3; ++i) x.push_back(2.01 * radius * Vec3(i, j, k) + Vec3(0.003 * k, 0, 0.04));
      PointsOptions o;
      o.radius = {radius};
      o.density = 1000.0;
      o.initial_velocity = Vec3(0, 0, -1);
      const int b = w.add(testing::named<PointsBody>("grains", x, o));
      const double start = w.body(b).kinetic_energy(w.v(b));
      double most = 0.0;
      for (int s = 0; s < 20; ++s) {
        const StepReport r = w.step();
        most = std::max(most, r.kinetic_energy + r.potential_energy);
      }
      EXPECT_LT(most, 1.0001 * start) << static_cast<int>(response) << ", " << layers;
      EXPECT_LT(w.body(b).kinetic_energy(w.v(b)), 0.9 * start) << "they have hit the ground";
    }
  }
}

}  // namespace
}  // namespace brim::grain_blow_test
