#include "brim/body/outer_forces.h"

#include <gtest/gtest.h>

#include "brim/body/rigid/rigid_body.h"
#include "brim/raster/shape.h"

namespace brim::outer_forces_test {
namespace {

RigidModel unit_ball() {
  RigidModel model;
  model.shape = make_sphere(0.1);
  model.mass = 2.0;
  model.inertia = 0.5 * Mat3::Identity();
  model.part.voxel_size = 0.05;
  return model;
}

TEST(OuterForces, AddToTheBodysOwnUntilTheyAreSetAgain) {
  RigidBody body(unit_ball());
  std::vector<double> q(body.q_size()), v(body.v_size());
  body.initial_state(q, v);
  body.update(0.0, q, v);
  const Environment env;
  std::vector<double> before(6, 0.0), with(6, 0.0), after(6, 0.0);
  body.add_forces(env, before);
  const std::vector<double> given = {1, 2, 3, 4, 5, 6};
  body.set_outer_forces(given);
  body.add_forces(env, with);
  body.set_outer_forces({});
  body.add_forces(env, after);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(with[i], before[i] + given[i]);
  EXPECT_EQ(after, before);
}

}  // namespace
}  // namespace brim::outer_forces_test
