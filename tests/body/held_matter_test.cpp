#include "brim/body/meshless/held_matter.h"

#include <gtest/gtest.h>

#include "support/carried.h"
#include "support/particle_laws.h"

namespace brim::held_matter_test {
namespace {

constexpr unsigned kSeed = 59;
constexpr double kReach = 0.4, kTension = 3e4;

/// Frames and matter at random, of which a half space is held.
struct Sample {
  std::vector<Vec3> frames, points;
  std::vector<double> volume;
  HeldRegion region{{}, [](const Vec3& x) { return x.x() <= 0.0; }};
  ShapeFunctions shape;

  explicit Sample(testing::Noise& noise) {
    for (int i = 0; i < 80; ++i) frames.push_back(0.5 * noise.vec());
    for (int i = 0; i < 30; ++i) points.push_back(0.45 * noise.vec()), volume.push_back(1e-3 * (1.5 + noise()));
    for (std::size_t k = 0; k < frames.size(); ++k)
      if (region.inside(frames[k])) region.frames.push_back(static_cast<std::int32_t>(k));
    shape = moving_least_squares(frames, points, kReach);
  }
  HeldMatter held() const { return {std::span(&region, 1), frames, kReach, points, shape, volume, kTension}; }
};

BlockMatrix pattern_of(HeldMatter& held, std::size_t nodes) {
  BlockMatrix K;
  K.begin(nodes);
  held.add_pattern(K);
  K.finish();
  held.find_pairs(K);
  return K;
}

TEST(HeldMatter, EnergyIsThatOfMatterAwayFromWhereItsFramesHoldIt) {
  SCOPED_TRACE(kSeed);
  testing::Noise noise(kSeed);
  const Sample s(noise);
  std::vector<Vec3> x, held_frames;
  for (const Vec3& p : s.frames) x.push_back(p + 0.1 * noise.vec());
  for (const std::int32_t k : s.region.frames) held_frames.push_back(s.frames[static_cast<std::size_t>(k)]);
  double energy = 0.0;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    if (!s.region.inside(s.points[i])) continue;
    Vec3 away = Vec3::Zero();
    for (std::int32_t e = s.shape.rows.first[i]; e < s.shape.rows.first[i + 1]; ++e)
      away += s.shape.rows.weight[static_cast<std::size_t>(e)] *
              x[static_cast<std::size_t>(s.shape.rows.source[static_cast<std::size_t>(e)])];
    const ShapeFunctions psi = moving_least_squares(held_frames, std::span(&s.points[i], 1), kReach);
    for (std::size_t e = 0; e < psi.rows.source.size(); ++e)
      away -= psi.rows.weight[e] *
              x[static_cast<std::size_t>(s.region.frames[static_cast<std::size_t>(psi.rows.source[e])])];
    energy += 0.5 * kTension * s.volume[i] * away.squaredNorm();
  }
  EXPECT_GT(energy, 0.0);
  EXPECT_NEAR(s.held().energy(x), energy, 1e-9 * energy);
}

TEST(HeldMatter, AffineMotionsStoreNothingAndMakeNoForce) {
  SCOPED_TRACE(kSeed);
  testing::Noise noise(kSeed);
  const Sample s(noise);
  HeldMatter held = s.held();
  BlockMatrix K = pattern_of(held, s.frames.size());
  Mat3 A;
  for (double& a : A.reshaped()) a = noise();
  std::vector<Vec3> x, force(s.frames.size(), Vec3::Zero());
  for (const Vec3& p : s.frames) x.push_back(A * p + Vec3(3, 2, 1));
  K.set_zero();
  held.add(x, force, K);
  EXPECT_GT(held.size(), 100u);
  EXPECT_NEAR(held.energy(x), 0.0, 1e-9);  // of terms of some 10 J
  for (const Vec3& f : force) EXPECT_LT(f.norm(), 1e-9);
}

TEST(HeldMatter, FramesInAPlaneHoldNoMatter) {
  testing::Noise noise(kSeed);
  Sample s(noise);
  for (const std::int32_t k : s.region.frames) s.frames[static_cast<std::size_t>(k)].x() = -0.2;
  s.shape = moving_least_squares(s.frames, s.points, kReach);
  EXPECT_EQ(s.held().size(), 0u);
}

/// A block of which the matter at its left is held.
std::unique_ptr<MeshlessBody> held_block() {
  const Vec3 half(0.2, 0.15, 0.15);
  const MeshlessModel m =
      fill_with_frames([=](const Vec3& x) { return testing::box_distance(x, half); }, {-half, half}, 0.1, 0.05);
  ElasticOptions o = testing::soft();
  const MeshlessBody free(m, Quat::Identity(), Vec3::Zero(), o);
  HeldRegion region{{}, [](const Vec3& x) { return x.x() <= 0.0; }};
  for (std::size_t k = 0; k < free.rest_positions().size(); ++k)
    if (region.inside(free.rest_positions()[k])) region.frames.push_back(static_cast<std::int32_t>(k));
  return std::make_unique<MeshlessBody>(m, Quat::Identity(), Vec3::Zero(), o, std::span(&region, 1));
}

TEST(HeldMatter, BodiesWithItObeyTheLawsOfElasticParticles) {
  const auto body = held_block();
  testing::Noise noise(kSeed);
  const Mat3 R = Eigen::AngleAxisd(1.0, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  std::vector<Vec3> x;
  for (const Vec3& p : body->rest_positions())
    x.push_back(R * (p + 0.01 * noise.vec() + 0.3 * Vec3(p.y() * p.z(), 0, p.x() * p.x())));
  const std::vector<double> q = testing::flat(x);
  testing::expect_force_is_minus_energy_gradient(*body, q, 1e-7, 1e-6, kSeed);
  testing::expect_stiffness_is_symmetric_and_definite(*body, q, kSeed);
  testing::expect_inner_forces_balance(*body, q);
  testing::expect_rigid_motion_makes_no_force(*body);
}

}  // namespace
}  // namespace brim::held_matter_test
