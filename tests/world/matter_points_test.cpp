#include "brim/world/matter_points.h"

#include <gtest/gtest.h>

#include <random>

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

/// A full ball of radius 0.15 m, three voxels from face to middle on each side.
constexpr double kRadius = 0.15;

std::unique_ptr<SoftImageBody> image_ball(LayerWeights weights) {
  const VoxelImage image = testing::scan({Vec3::Constant(-0.2), Vec3::Constant(0.2)}, 0.01,
                                         [](const Vec3& x) { return x.norm() - kRadius; });
  const OccupancyGrid grid = sample_occupancy(image, {0, 100}, 0.02);
  ElasticOptions o = testing::soft(1e4, weights);
  o.voxel_size = 0.03;
  return std::make_unique<SoftImageBody>(grid, display_surface(grid), 0.06, Quat::Identity(), Vec3::Zero(), o);
}

std::unique_ptr<MeshlessBody> meshless_ball(LayerWeights weights) {
  const MeshlessModel m = fill_with_frames([](const Vec3& x) { return x.norm() - kRadius; },
                                           {Vec3::Constant(-kRadius), Vec3::Constant(kRadius)}, 0.08, 0.03);
  ElasticOptions o = testing::soft(1e4, weights);
  o.voxel_size = 0.03;
  return std::make_unique<MeshlessBody>(m, Quat::Identity(), Vec3::Zero(), o);
}

/// Soft balls of either kind, with each of the weights.
std::vector<std::unique_ptr<CarriedBody>> balls() {
  std::vector<std::unique_ptr<CarriedBody>> out;
  for (const LayerWeights weights : {LayerWeights::DensityRate, LayerWeights::Affine, LayerWeights::Mass}) {
    out.push_back(image_ball(weights));
    out.push_back(meshless_ball(weights));
  }
  return out;
}

/// A body at its start, as a part of a world.
struct Placed {
  explicit Placed(CarriedBody& b) : body(b), q(b.q_size()), v(b.v_size()) {
    body.initial_state(q, v);
    body.update(0.0, q, v);
    part.body = &body, part.body_index = 0, part.index = 0, part.info = body.part(0), part.h = 0.03;
  }
  MatterPoints hold(std::vector<Vec3> x) const { return MatterPoints::of_part(part, 3.0 * part.h, q, std::move(x)); }

  CarriedBody& body;
  std::vector<double> q, v;
  WorldPart part;
};

std::vector<Vec3> points_inside(int n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> at(-0.95 * kRadius, 0.95 * kRadius);
  std::vector<Vec3> x;
  while (x.size() < static_cast<std::size_t>(n))
    if (const Vec3 p(at(random), at(random), at(random)); p.norm() < 0.95 * kRadius) x.push_back(p);
  return x;
}

TEST(MatterPoints, APointInsideASoftBodyIsHeldWhereItIs) {
  for (const auto& body : balls()) {
    const Placed ball(*body);
    for (const Vec3& p : points_inside(40, 1))  // each alone
      EXPECT_LT((ball.hold({p}).positions()[0] - p).norm(), 1e-9) << body->kind() << ": " << p.transpose();
  }
}

TEST(MatterPoints, APointInsideASoftBodyMovesAsItsMatterDoes) {
  Mat3 A;
  A << 0.1, -0.3, 0.2, 0.4, 0.05, -0.1, -0.2, 0.1, 0.3;
  for (const auto& body : balls()) {
    Placed ball(*body);
    const std::vector<Vec3> x = points_inside(40, 2);
    MatterPoints points = ball.hold(x);
    // The velocity of its map at the start, and the place after the motion.
    std::vector<double> v(ball.v.size());
    for (std::size_t i = 0; i < v.size(); i += 3)
      Eigen::Map<Vec3>(v.data() + i) = A * Eigen::Map<const Vec3>(ball.q.data() + i);
    std::vector<std::int32_t> source;
    for (std::size_t i = 0; i < x.size(); ++i) source.push_back(points.source(i));
    std::unique_ptr<Map> map;
    body->make_map(0, points.positions(), source, map);
    std::vector<Vec3> u(x.size());
    map->apply(v, u);
    for (std::size_t i = 0; i < ball.q.size(); ++i) ball.q[i] += v[i];
    body->update(0.0, ball.q, v);
    points.follow(ball.part, ball.q);
    for (std::size_t i = 0; i < x.size(); ++i) {
      EXPECT_LT((u[i] - A * x[i]).norm(), 1e-9) << body->kind() << ": " << x[i].transpose();
      EXPECT_LT((points.positions()[i] - x[i] - A * x[i]).norm(), 1e-9) << body->kind() << ": " << x[i].transpose();
    }
  }
}

TEST(MatterPoints, APointFarFromASoftBodyIsHeldAtTheNearestVertex) {
  for (const auto& body : balls()) {
    const Placed ball(*body);
    std::vector<Vec3f> shown(body->display().vertices);
    if (shown.empty()) continue;  // these meshless bodies have no surface
    body->display_positions(shown);
    for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(-1, 2, 0.5), Vec3(0.3, -1, 1)}) {
      const Vec3 x = 3.0 * kRadius * direction.normalized(), held = ball.hold({x}).positions()[0];
      Vec3 nearest = shown[0].cast<double>();
      for (const Vec3f& p : shown)
        if ((p.cast<double>() - x).norm() < (nearest - x).norm()) nearest = p.cast<double>();
      EXPECT_LT((held - nearest).norm(), 1e-9) << body->kind();
    }
  }
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
