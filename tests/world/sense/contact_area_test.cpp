#include "brim/world/sense/contact_area.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace brim::contact_area_test {
namespace {

constexpr double kStep = 0.01;

/// Adds the nodes (i, j), |i|, |j| <= n, that carry force(r), r in steps from the middle.
template <class F>
void add_disc(ContactArea& area, int n, const Vec3& at, const F& force) {
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j) area.add(at + kStep * Vec3(i, j, 0), Vec3(0, 0, force(std::hypot(i, j))), kStep);
}

TEST(ContactArea, ThePressureOfHertzHasTheAreaOfItsDisc) {
  ContactArea area;
  for (const double a : {4.5, 9.3, 30.2}) {
    add_disc(area, 40, Vec3::Zero(), [=](double r) { return std::sqrt(std::max(0.0, 1.0 - r * r / (a * a))); });
    const double taken = area.take() / (kStep * kStep);
    EXPECT_GT(taken, std::numbers::pi * (a - 0.5) * (a - 0.5)) << a;
    EXPECT_LT(taken, std::numbers::pi * (a + 0.5) * (a + 0.5)) << a;
  }
}

// The rim of a ball on something soft, where ramps overlap over the gap: 0.2 % of the pressure inside, and less.
TEST(ContactArea, AFaintRimHardlyCounts) {
  constexpr double a = 4.5;
  ContactArea area;
  add_disc(area, 8, Vec3::Zero(), [](double r) { return r < a ? 1.0 : r < a + 2.0 ? 0.002 : 1e-5; });
  EXPECT_LT(area.take(), std::numbers::pi * std::pow(kStep * (a + 0.5), 2.0));
}

TEST(ContactArea, ALightFootBesideAHeavyOneCountsInFull) {
  ContactArea area;
  add_disc(area, 2, Vec3::Zero(), [](double) { return 1000.0; });
  add_disc(area, 2, kStep * Vec3(7, 0, 0), [](double) { return 1.0; });
  EXPECT_NEAR(area.take(), 50 * kStep * kStep, 1e-12);  // rounding
}

TEST(ContactArea, NodesAboveEachOtherAreOneSquareAndTheSlopeCounts) {
  ContactArea area;
  for (const double z : {0.0, kStep}) area.add(Vec3(0, 0, z), Vec3(0, 3, 4), kStep);
  EXPECT_NEAR(area.take(), kStep * kStep / 0.8, 1e-12);
  EXPECT_EQ(area.take(), 0.0);
}

}  // namespace
}  // namespace brim::contact_area_test
