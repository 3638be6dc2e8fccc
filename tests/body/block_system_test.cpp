#include <gtest/gtest.h>

#include "brim/body/cloth/cloth_body.h"
#include "brim/body/fem/fem_body.h"
#include "brim/body/mass_spring/mass_spring_body.h"
#include "brim/body/points/points_body.h"
#include "brim/body/rod/rod_body.h"
#include "brim/mesh/primitives.h"
#include "support/carried.h"
#include "support/particle_laws.h"

namespace brim::block_system_test {
namespace {

constexpr unsigned kSeed = 71;

/// One body of each kind that is made of elements, damped.
std::vector<std::unique_ptr<ParticleBody>> elastic_bodies() {
  ElasticOptions soft = testing::soft();
  FemOptions solid;
  ClothOptions sheet;
  MassSpringOptions springs;
  RodOptions rod;
  for (ParticleOptions* o : std::initializer_list<ParticleOptions*>{&soft, &solid, &sheet, &springs, &rod}) {
    o->mass_damping = 0.7, o->stiffness_damping = 0.02;
    o->fixed = {1, 3};
  }
  std::vector<std::unique_ptr<ParticleBody>> all;
  all.push_back(std::make_unique<FemBody>(testing::block(2, 2, 3, 0.2), solid));
  all.push_back(std::make_unique<ClothBody>(shapes::grid(4, 5, 1, 1), sheet));
  all.push_back(std::make_unique<MassSpringBody>(testing::block(2, 2, 2, 0.2), springs));
  all.push_back(std::make_unique<RodBody>(std::vector<Vec3>{{0, 0, 0}, {0.1, 0, 0}, {0.2, 0.05, 0}, {0.3, 0, 0}}, rod));
  all.push_back(testing::meshless(Vec3(0.4, 0.3, 0.3), 0.1, 0.05, soft));
  all.push_back(testing::voxels(Vec3(0.4, 0.3, 0.3), 0.1, 0.05, soft));
  return all;
}

/// y = A x, block by block.
std::vector<double> product(const BlockSystem& system, const std::vector<double>& x) {
  const BlockMatrix& K = *system.stiffness;
  std::vector<double> y(x.size());
  for (std::size_t r = 0; r < K.rows(); ++r) {
    Vec3 sum = system.mass_share * system.mass[r] * Eigen::Map<const Vec3>(x.data() + 3 * r);
    for (std::int32_t s = K.row_first()[r]; s < K.row_first()[r + 1]; ++s) {
      const Mat3 block = s == K.diagonal_slot(r) ? K.diagonal(r) : K.block(s);
      sum += system.stiffness_share * (block * Eigen::Map<const Vec3>(x.data() + 3 * K.columns()[s]));
    }
    Eigen::Map<Vec3>(y.data() + 3 * r) = sum;
  }
  return y;
}

TEST(BlockSystem, IsTheMatrixOfApplySystemForEveryElasticKind) {
  for (const auto& body : elastic_bodies()) {
    SCOPED_TRACE(body->kind());
    testing::Noise noise(kSeed);
    std::vector<double> q(body->q_size()), v(body->v_size()), x(q.size()), y(q.size(), 0.0);
    body->initial_state(q, v);
    for (double& e : q) e += 0.01 * noise();
    for (double& e : x) e = noise();
    body->update(0.0, q, v);
    body->begin_solve(0.01);
    const std::optional<BlockSystem> system = body->block_system();
    ASSERT_TRUE(system);
    body->apply_system(x, y);
    const std::vector<double> z = product(*system, x);
    double size = 0.0;
    for (const double e : y) size = std::max(size, std::abs(e));
    // The order of sums differs.
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(z[i], y[i], 1e-13 * size);

    std::vector<double> filtered(x.size(), 1.0);
    body->filter(filtered);
    for (const std::int32_t i : system->prescribed) EXPECT_EQ(filtered[3 * static_cast<std::size_t>(i)], 0.0);
    EXPECT_EQ(std::count(filtered.begin(), filtered.end(), 0.0), 3 * std::ssize(system->prescribed));
  }
}

TEST(BlockSystem, GrainsHaveNone) {
  PointsBody grains({Vec3(0, 0, 0), Vec3(0.02, 0, 0)}, {});
  EXPECT_FALSE(grains.block_system());
}

}  // namespace
}  // namespace brim::block_system_test
