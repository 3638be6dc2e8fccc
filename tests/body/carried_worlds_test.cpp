#include <gtest/gtest.h>

#include "brim/body/cloth/cloth_body.h"
#include "brim/math/ramp.h"
#include "brim/raster/image_shape.h"
#include "support/carried.h"
#include "support/tiles.h"
#include "support/worlds.h"

/// Bodies whose nodes carry particles of matter, in small worlds.
namespace brim::carried_worlds_test {
namespace {

using testing::meshless;
using testing::soft;
using testing::voxels;

/// A soft block of 0.4 m on the ground.
struct Rest {
  double speed = 0.0;   ///< [m/s] mean over the last third of a second
  double height = 0.0;  ///< [m] its lower face, where its density is a half
  double worst = 0.0;   ///< [voxels]
};

Rest rest(bool image, LayerWeights kind) {
  const double h = 0.05;
  World w(testing::options_at(h));
  w.add(testing::ground(0.5));
  const ElasticOptions o = soft(1e5, kind);
  std::unique_ptr<CarriedBody> body;
  if (image)
    body = voxels(Vec3::Constant(0.4), 0.13, h, o, Vec3(0.01, 0.02, 0.21));
  else
    body = meshless(Vec3::Constant(0.4), 0.13, h, o, Vec3(0.01, 0.02, 0.21));
  body->set_name("soft");
  const CarriedBody& soft_body = *body;
  const int b = w.add(std::move(body));
  Rest r;
  const int steps = 60;
  for (int s = 0; s < steps; ++s) {
    r.worst = std::max(r.worst, w.step().worst_overlap);
    if (s >= steps - 20) r.speed += std::sqrt(2.0 * soft_body.kinetic_energy(w.v(b)) / soft_body.mass()) / 20.0;
  }
  std::vector<TileKey> tiles;
  soft_body.presence(0, h, 3 * h, {Vec3(-0.1, -0.1, -0.1), Vec3(0.1, 0.1, 0.2)}, tiles);
  std::vector<DensityBlock> blocks(tiles.size());
  soft_body.rasterize(0, h, 3 * h, tiles, blocks);
  // At the node above it that lies nearest, by the ramp.
  double nearest = 1.0;
  testing::for_each_node(tiles, h, [&](std::size_t t, int n, const Vec3& x) {
    const double d = ramp_inverse(blocks[t].rho[n], 3 * h);
    if (std::abs(x.x()) > 0.01 || std::abs(x.y()) > 0.01 || x.z() > 0.15 || std::abs(d) > std::abs(nearest)) return;
    nearest = d, r.height = x.z() + d;  // outwards is down
  });
  return r;
}

TEST(CarriedBody, RestsOnTheGroundWithEitherWeights) {
  for (const bool image : {false, true})
    for (const LayerWeights kind : {LayerWeights::Mass, LayerWeights::Affine, LayerWeights::DensityRate}) {
      const Rest r = rest(image, kind);
      std::printf("%s, weights %d: speed left %.2e m/s, worst overlap %.3f voxels, lower face at %.4f m\n",
                  image ? "voxels" : "meshless", static_cast<int>(kind), r.speed, r.worst, r.height);
      if (kind == LayerWeights::Mass) continue;
      EXPECT_LT(r.speed, 0.01);
      EXPECT_LT(r.worst, 0.3);
      EXPECT_NEAR(r.height, 0.0, 0.2 * 0.05) << "it neither floats nor sinks";
    }
}

TEST(CarriedBody, MeetsARigidBodyAClothAndARigidImage) {
  for (const bool image : {false, true}) {
    const double h = 0.05;
    World w(testing::options_at(h));
    w.add(testing::ground(0.5));
    std::unique_ptr<CarriedBody> body;
    if (image)
      body = voxels(Vec3(0.5, 0.5, 0.3), 0.13, h, soft(1e5), Vec3(0, 0, 0.16));
    else
      body = meshless(Vec3(0.5, 0.5, 0.3), 0.13, h, soft(1e5), Vec3(0, 0, 0.16));
    body->set_name("soft");
    w.add(std::move(body));
    RigidModel ball;
    const OccupancyGrid grid = sample_occupancy(
        testing::scan({Vec3::Constant(-0.2), Vec3::Constant(0.2)}, 0.02, [](const Vec3& x) { return x.norm() - 0.15; }),
        {0, 100}, 0.5 * h);
    const MassProperties m = mass_properties(grid, 800.0);
    ball.shape = make_image_shape(grid, 0.3);
    ball.mass = m.mass, ball.inertia = m.inertia, ball.center_of_mass = m.center;
    ball.position = Vec3(0.02, 0.01, 0.52);
    auto rigid = std::make_unique<RigidBody>(ball);
    rigid->set_name("scan");
    const int b = w.add(std::move(rigid));
    TriMesh sheet;
    for (int j = 0; j <= 12; ++j)
      for (int i = 0; i <= 12; ++i) sheet.vertices.push_back(Vec3(0.05 * i - 0.3, 0.05 * j - 0.3, 0.75));
    for (int j = 0; j < 12; ++j)
      for (int i = 0; i < 12; ++i) {
        const std::int32_t a = i + 13 * j;
        sheet.triangles.push_back({a, a + 1, a + 14});
        sheet.triangles.push_back({a, a + 14, a + 13});
      }
    ClothOptions co;
    co.thickness = 2 * h;
    co.areal_density = 0.5;
    auto cloth = std::make_unique<ClothBody>(sheet, co);
    cloth->set_name("cloth");
    w.add(std::move(cloth));
    double worst = 0.0;
    for (int s = 0; s < 40; ++s) {
      const StepReport r = w.step();
      EXPECT_TRUE(r.ok);
      worst = std::max(worst, r.worst_overlap);
    }
    EXPECT_LT(worst, 0.8);
    EXPECT_GT(testing::position(w, b).z(), 0.38) << "held by the soft body";
    EXPECT_LT(testing::position(w, b).z(), 0.5);
  }
}

}  // namespace
}  // namespace brim::carried_worlds_test
