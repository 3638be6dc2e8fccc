#include "brim/response/hardening.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/contact/contact_set.h"
#include "brim/response/penalty.h"

namespace brim::hardening_test {
namespace {

constexpr unsigned kSeed = 61;

double force(const Hardening& law, double overlap) { return law.at(overlap).stiffness * law.at(overlap).offset; }

TEST(Hardening, UpToItsStartAndWithoutGrowthTheLawIsLinearToTheBit) {
  for (const double overlap : {-0.3, 0.0, 0.04, Hardening::kStart}) {
    EXPECT_EQ(Hardening(3000.0).at(overlap).stiffness, 1.0);
    EXPECT_EQ(Hardening(3000.0).at(overlap).offset, overlap);
    EXPECT_EQ(Hardening(3000.0).energy(overlap), 0.5 * overlap * overlap);
  }
  for (const Hardening& linear : {Hardening(), Hardening(1.0), Hardening(0.2)}) {
    EXPECT_EQ(linear.at(0.9).stiffness, 1.0);
    EXPECT_EQ(linear.at(0.9).offset, 0.9);
    EXPECT_EQ(linear.energy(0.9), 0.5 * 0.9 * 0.9);
  }
}

TEST(Hardening, FullOverlapIsStifferByItsGrowth) {
  for (const double growth : {2.0, 50.0, 3000.0})
    EXPECT_NEAR(Hardening(growth).at(1.0).stiffness, growth, 1e-12 * growth);
}

TEST(Hardening, ForceIsTheSlopeOfEnergyAndStiffnessThatOfForce) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> overlaps(0.0, 1.0), logs(0.0, 8.0);
  for (int trial = 0; trial < 200; ++trial) {
    const Hardening law(std::exp(logs(rng)));
    const double x = overlaps(rng), d = 1e-6, f = force(law, x), k = law.at(x).stiffness;
    // Central differences of a smooth law; across the start stiffness has a kink, which costs m d / kStart.
    EXPECT_NEAR((law.energy(x + d) - law.energy(x - d)) / (2.0 * d), f, 1e-7 * (f + 1.0));
    EXPECT_NEAR((force(law, x + d) - force(law, x - d)) / (2.0 * d), k, 1e-4 * k);
  }
}

TEST(Hardening, StepsAlongItsLinesComeFromAnyOverlapToTheLoadFromAboveOnly) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> overlaps(0.0, 1.0);
  const Hardening law(3000.0);
  for (int trial = 0; trial < 50; ++trial) {
    const double sought = overlaps(rng), load = force(law, sought);
    double x = overlaps(rng);
    for (int step = 0; step < 400; ++step) {
      const Hardening::Line line = law.at(x);
      x += load / line.stiffness - line.offset;
      if (step == 0) x = std::min(x, 1.0);  // matter that has gone through is not brought back
      ASSERT_GE(x, sought - 1e-12);
    }
    EXPECT_NEAR(x, sought, 1e-9);
  }
}

TEST(Hardening, ANodeByHand) {
  ContactSet set;
  set.pairs.push_back({0, 1, 0.5, 1.5, 0.0, 0, 1});
  set.resize(1);
  set.overlap[0] = 0.5F;
  set.gradient_a.set(0, Vec3(0, 0, 0.75));
  set.gradient_b.set(0, Vec3(0, 0, -0.75));
  PenaltyOptions o;
  o.dt = 0.01, o.friction_speed = 1e-3;
  // growth 1000 from 0.1 to 1: stiffness r³, force 0.1 + 0.1 (r⁴ − 1)/4, energy over k h³ at r = 5
  const double stiffness = 125.0, pressed = 0.1 + 0.1 * 624.0 / 4.0,
               energy = 0.01 * (0.5 + 4.0 + (3124.0 / 5.0 - 4.0) / 4.0);
  Penalty p;
  p.begin(set, std::vector<PairState>{{.stiffness = 1000.0, .growth = 1000.0}}, o, std::vector<Vec3>(1, Vec3::Zero()),
          std::vector<Vec3>(1, Vec3::Zero()));
  std::vector<Vec3> f(1), friction(1);
  p.right_hand_side(f);
  EXPECT_NEAR(f[0].z(), 1000.0 * 0.125 * pressed * 0.75, 1e-10);
  EXPECT_NEAR(p.energy(), 1000.0 * 0.125 * energy, 1e-10);
  p.apply(std::vector<Vec3>{Vec3(0, 0, 1)}, f);
  EXPECT_NEAR(f[0].z(), 0.01 * 0.01 * 1000.0 * stiffness * 0.125 * 0.5625, 1e-10);
  const std::vector<Vec3> lifted{Vec3(0, 0, 0.1)};
  p.update_loads(set, lifted);
  p.forces(lifted, f, friction);
  EXPECT_NEAR(f[0].z(), 1000.0 * 0.125 * 0.75 * (pressed - stiffness * 0.75 * 0.01 * 0.1), 1e-10);
}

}  // namespace
}  // namespace brim::hardening_test
