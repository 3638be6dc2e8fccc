#include "brim/world/matter_points.h"

#include <gtest/gtest.h>

#include "support/carried.h"

namespace brim::matter_points_test {
namespace {

/// A hollow ball as a scanner sees it, its wall thinner than the lattice that carries it.
std::unique_ptr<SoftImageBody> shell() {
  const VoxelImage image = testing::scan({Vec3::Constant(-0.24), Vec3::Constant(0.24)}, 0.01,
                                         [](const Vec3& x) { return std::abs(x.norm() - 0.19) - 0.012; });
  const OccupancyGrid grid = sample_occupancy(image, {0, 100}, 0.02);
  ElasticOptions o;
  o.voxel_size = 0.03;
  return std::make_unique<SoftImageBody>(grid, display_surface(grid), 0.08, Quat::Identity(), Vec3::Zero(), o);
}

TEST(MatterPoints, AWideRegionOfAScanIsHeldWithinVoxelsOfWhatWasAskedFor) {
  const auto body = shell();
  std::vector<double> q(body->q_size()), v(body->v_size());
  body->initial_state(q, v);
  body->update(0.0, q, v);
  WorldPart part;
  part.body = body.get(), part.body_index = 0, part.index = 0, part.info = body->part(0), part.h = 0.03;
  std::vector<Vec3f> shown(body->display().vertices);
  body->display_positions(shown);
  std::vector<Vec3> x;
  for (const Vec3f& p : shown) x.push_back(p.cast<double>());

  MatterPoints all = MatterPoints::of_part(part, 3.0 * part.h, q, x);
  ASSERT_EQ(all.size(), x.size());
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LT((all.positions()[i] - x[i]).norm(), 3.0 * part.h);
  // They go where the body goes.
  const std::vector<Vec3> before(all.positions().begin(), all.positions().end());
  for (std::size_t i = 0; i < q.size(); i += 3) q[i] += 0.1;
  body->update(0.0, q, v);
  all.follow(part, q);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LT((all.positions()[i] - before[i] - Vec3(0.1, 0, 0)).norm(), 1e-9);
}

}  // namespace
}  // namespace brim::matter_points_test
