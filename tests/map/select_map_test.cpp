#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "brim/map/point_weights.h"
#include "brim/map/shell_weights.h"

namespace brim::select_map_test {
namespace {

constexpr std::size_t kParticles = 40, kPoints = 60;

struct Scatter {
  std::mt19937 random{11};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};
  Vec3 vector() { return Vec3(uniform(random), uniform(random), uniform(random)); }
  std::vector<Vec3> vectors(std::size_t n) {
    std::vector<Vec3> x(n);
    for (Vec3& v : x) v = vector();
    return x;
  }
};

/// Rows of different lengths, with a particle named twice.
std::unique_ptr<Map> point_weights(Scatter& scatter) {
  std::vector<std::int32_t> first{0}, particle;
  std::vector<double> weight;
  for (std::size_t p = 0; p < kPoints; ++p) {
    for (std::size_t i = 0; i < 1 + p % 4; ++i) {
      particle.push_back(static_cast<std::int32_t>((7 * p + 13 * (i % 3)) % kParticles));
      weight.push_back(scatter.uniform(scatter.random));
    }
    first.push_back(static_cast<std::int32_t>(particle.size()));
  }
  auto map = std::make_unique<PointWeightsMap>();
  map->assign(kParticles, first, particle, weight);
  return map;
}

/// Points near triangles and, where these are small beside their distance, on patches.
std::unique_ptr<Map> shell_weights(Scatter& scatter) {
  std::vector<Vec3> x = scatter.vectors(kParticles);
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (std::int32_t t = 0; t + 2 < static_cast<std::int32_t>(kParticles); ++t) triangles.push_back({t, t + 1, t + 2});
  std::vector<Vec3> points;
  std::vector<std::int32_t> nearest;
  for (std::size_t p = 0; p < kPoints; ++p) {
    nearest.push_back(static_cast<std::int32_t>(p % triangles.size()));
    points.push_back(x[triangles[nearest.back()][0]] + (p % 3 == 0 ? 2.0 : 0.05) * scatter.vector());
  }
  auto map = std::make_unique<ShellWeightsMap>();
  map->build(SheetPatches(triangles), points, nearest, x);
  return map;
}

using Maker = std::unique_ptr<Map> (*)(Scatter&);

class SelectMap : public ::testing::TestWithParam<Maker> {};

TEST_P(SelectMap, SomeOfTheRowsDoWhatTheyDidAmongAll) {
  Scatter scatter;
  const std::unique_ptr<Map> all = GetParam()(scatter);
  std::vector<std::uint32_t> rows;
  for (std::uint32_t p = 0; p < kPoints; ++p)
    if (p % 5 != 2) rows.push_back(p);
  std::unique_ptr<Map> some;
  ASSERT_TRUE(all->select(rows, some));
  ASSERT_EQ(some->points(), rows.size());

  std::vector<double> v(3 * kParticles);
  for (double& x : v) x = scatter.uniform(scatter.random);
  std::vector<Vec3> u(kPoints), picked(rows.size());
  all->apply(v, u), some->apply(v, picked);
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(u[rows[i]], picked[i]);

  std::vector<Vec3> f(kPoints, Vec3::Zero()), f_picked = scatter.vectors(rows.size());
  std::vector<Mat3> K(kPoints, Mat3::Zero()), K_picked;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Vec3 n = scatter.vector();
    K_picked.push_back(n * n.transpose());
    f[rows[i]] = f_picked[i], K[rows[i]] = K_picked[i];
  }
  std::vector<double> Q(3 * kParticles, 0.0), Q_picked(Q);
  all->apply_transpose(f, Q), some->apply_transpose(f_picked, Q_picked);
  BlockDiagonal D, D_picked;
  D.reset(std::vector<int>(kParticles, 3)), D_picked.reset(std::vector<int>(kParticles, 3));
  all->add_block_diagonal(K, 0, D), some->add_block_diagonal(K_picked, 0, D_picked);
  for (std::size_t i = 0; i < Q.size(); ++i) EXPECT_NEAR(Q[i], Q_picked[i], 1e-14);
  for (std::size_t b = 0; b < kParticles; ++b)
    EXPECT_LT((D.block(b) - D_picked.block(b)).norm(), 1e-13 * (1.0 + D.block(b).norm()));
}

TEST_P(SelectMap, RoomOfAnotherChoiceIsTakenOver) {
  Scatter scatter;
  const std::unique_ptr<Map> all = GetParam()(scatter);
  const std::vector<std::uint32_t> many = {0, 1, 2, 3, 4, 5, 40, 41}, few = {7, 41};
  std::unique_ptr<Map> some;
  ASSERT_TRUE(all->select(many, some));
  // The transpose of the former choice has been made, and must go.
  std::vector<double> Q(3 * kParticles, 0.0), alone(Q);
  some->apply_transpose(scatter.vectors(many.size()), Q);
  const Map* room = some.get();
  ASSERT_TRUE(all->select(few, some));
  EXPECT_EQ(room, some.get());
  const std::vector<Vec3> f = scatter.vectors(few.size());
  std::vector<Vec3> f_all(kPoints, Vec3::Zero());
  f_all[7] = f[0], f_all[41] = f[1];
  std::fill(Q.begin(), Q.end(), 0.0);
  some->apply_transpose(f, Q), all->apply_transpose(f_all, alone);
  for (std::size_t i = 0; i < Q.size(); ++i) EXPECT_NEAR(Q[i], alone[i], 1e-14);
}

INSTANTIATE_TEST_SUITE_P(Kinds, SelectMap, ::testing::Values(point_weights, shell_weights));

}  // namespace
}  // namespace brim::select_map_test
