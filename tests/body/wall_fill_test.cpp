#include "brim/body/particle_fluid/wall_fill.h"

#include <gtest/gtest.h>

#include "brim/math/types.h"
#include "support/particle_fluids.h"

namespace brim {
namespace {

using namespace testing::fluids;

/// Spacing, a kernel of two spacings and a volume that fills the lattice.
struct Lattice {
  FluidKernel kernel{2.0 * kSpacing};
  double volume = 1.0;
  std::vector<Vec3> half;  ///< all neighbours of a particle at the origin that lie at z >= 0, itself included
  Lattice() {
    double sum = 0.0;
    for (int z = -2; z <= 2; ++z)
      for (int y = -2; y <= 2; ++y)
        for (int x = -2; x <= 2; ++x) {
          const Vec3 r = kSpacing * Vec3(x, y, z);
          sum += kernel.value(r.norm());
          if (z >= 0) half.push_back(r);
        }
    volume = 1.0 / sum;
  }
};

TEST(WallFill, AWallHalfASpacingOffMakesALatticeFull) {
  const Lattice l;
  const WallFill wall(l.kernel, kSpacing, l.volume);
  double fill = 0.0, slope = 0.0;
  for (const Vec3& r : l.half) fill += l.volume * l.kernel.value(r.norm());
  EXPECT_NEAR(fill + wall(0.5 * kSpacing, slope), 1.0, 1e-12);
}

TEST(WallFill, UnderAUniformPressureTheLatticeAtTheWallIsInBalance) {
  // Σ_j (p_i + p_j) g_ij + p_i ∇λ = 0 with all p the same.
  const Lattice l;
  const WallFill wall(l.kernel, kSpacing, l.volume);
  Vec3 push = Vec3::Zero();
  for (const Vec3& r : l.half)
    if (r.norm() > 0.0) push += 2.0 * l.volume * l.kernel.slope_over_r(r.norm()) * -r;
  double slope = 0.0;
  wall(0.5 * kSpacing, slope);
  push.z() += slope;  // the wall lies below: d = z
  EXPECT_NEAR(push.norm() * kSpacing, 0.0, 1e-12);
  EXPECT_LT(slope, 0.0);
}

TEST(WallFill, ItsSlopeIsItsDerivativeAndItEndsAtItsReach) {
  const Lattice l;
  const WallFill wall(l.kernel, kSpacing, l.volume);
  const double e = 1e-6 * kSpacing;
  for (const double d : {-1.0, 0.0, 0.3, 0.5, 0.7, 2.0}) {
    double slope = 0.0, unused = 0.0;
    wall(d * kSpacing, slope);
    EXPECT_NEAR(slope, (wall(d * kSpacing + e, unused) - wall(d * kSpacing - e, unused)) / (2 * e), 1e-6 / kSpacing);
  }
  double slope = 1.0;
  EXPECT_EQ(wall(wall.reach(), slope), 0.0);
  EXPECT_EQ(slope, 0.0);
  EXPECT_NEAR(wall.reach(), 0.8 * kSpacing, 0.02 * kSpacing);
}

}  // namespace
}  // namespace brim
