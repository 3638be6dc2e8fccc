#include "brim/body/grid_fluid/momentum_keeper.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::momentum_keeper_test {
namespace {

/// Wet cells within any of some boxes of cells, and the masses of their faces.
struct Fluid {
  WetFaces wet;
  std::vector<double> mass, v;
  Fluid(const MacGrid& g, const std::vector<std::pair<Vec3i, Vec3i>>& boxes, std::mt19937& rng) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<double> phi(g.cells(), 0.4 * g.dx);
    for (const auto& [lo, hi] : boxes)
      for (int k = lo.z(); k <= hi.z(); ++k)
        for (int j = lo.y(); j <= hi.y(); ++j)
          for (int i = lo.x(); i <= hi.x(); ++i) phi[g.cell(i, j, k)] = -0.6 * g.dx;
    wet.find(g, phi, {});
    for (const double share : wet.share) {
      mass.push_back(1000.0 * share);
      v.push_back(share > 0.0 ? unit(rng) : 0.0);
    }
    for (std::size_t f = 0; f < v.size(); ++f)
      if (wet.kind[f] == WetFaces::Kind::Wall) v[f] = 0.0;
  }
  /// [J] of the free faces
  double energy() const {
    double e = 0.0;
    for (std::size_t f = 0; f < v.size(); ++f)
      if (wet.kind[f] == WetFaces::Kind::Free) e += 0.5 * mass[f] * v[f] * v[f];
    return e;
  }
  /// [N s] of the faces whose place along x is within a range.
  Vec3 momentum(const MacGrid& g, int from = 0, int to = 1000) const {
    Vec3 p = Vec3::Zero();
    for (std::size_t f = 0; f < v.size(); ++f) {
      const int i = static_cast<int>(f / 3) % (g.n.x() + 1);
      if (i >= from && i <= to) p[static_cast<int>(f % 3)] += mass[f] * v[f];
    }
    return p;
  }
};

TEST(MomentumKeeper, EveryPieceOfFluidKeepsItsOwnMomentum) {
  const unsigned seed = 3;
  SCOPED_TRACE(seed);
  std::mt19937 rng(seed);
  const MacGrid g{Vec3::Zero(), 0.1, Vec3i(12, 6, 6)};
  const Fluid before(g, {{{1, 1, 1}, {3, 3, 3}}, {{8, 2, 2}, {9, 3, 4}}}, rng);
  Fluid after(g, {{{1, 1, 1}, {4, 3, 3}}, {{8, 2, 1}, {9, 3, 4}}}, rng);
  MomentumKeeper keeper;
  keeper.note(before.wet, before.mass, before.v);
  EXPECT_EQ(keeper.restore(g, after.wet, after.mass, true, after.v), Vec3(Vec3::Zero()));
  for (const auto& [from, to] : {std::pair{0, 6}, std::pair{7, 12}})
    EXPECT_LT((after.momentum(g, from, to) - before.momentum(g, from, to)).norm(), 1e-12 * before.momentum(g).norm());
}

TEST(MomentumKeeper, WhatAPieceLosesGoesToAllOrLeaves) {
  std::mt19937 rng(5);
  const MacGrid g{Vec3::Zero(), 0.1, Vec3i(12, 6, 6)};
  const Fluid before(g, {{{1, 1, 1}, {3, 3, 3}}, {{8, 2, 2}, {9, 3, 4}}}, rng);
  for (const bool keep : {true, false}) {
    Fluid after(g, {{{1, 1, 1}, {3, 3, 3}}}, rng);  // the other piece is gone
    MomentumKeeper keeper;
    keeper.note(before.wet, before.mass, before.v);
    const Vec3 gone = keeper.restore(g, after.wet, after.mass, keep, after.v);
    EXPECT_LT((after.momentum(g) + gone - before.momentum(g)).norm(), 1e-12 * before.momentum(g).norm());
    EXPECT_EQ(gone.norm() > 0.0, !keep);
    if (!keep) {
      EXPECT_LT((gone - before.momentum(g, 7, 12)).norm(), 1e-12 * gone.norm());
    }
  }
}

TEST(MomentumKeeper, WhatIsCarriedAlongGainsNoEnergy) {
  for (const unsigned seed : {11u, 12u, 13u}) {
    std::mt19937 rng(seed);
    const MacGrid g{Vec3::Zero(), 0.1, Vec3i(8, 6, 6)};
    const Fluid before(g, {{{1, 1, 1}, {3, 3, 3}}}, rng);
    Fluid after(g, {{{2, 1, 1}, {5, 3, 3}}}, rng);
    for (double& v : after.v) v *= 3.0;  // a poor transport
    MomentumKeeper keeper;
    keeper.note(before.wet, before.mass, before.v);
    keeper.restore(g, after.wet, after.mass, true, after.v);
    EXPECT_LT((after.momentum(g) - before.momentum(g)).norm(), 1e-12 * before.momentum(g).norm()) << seed;
    EXPECT_LT(after.energy(), before.energy() * (1.0 + 1e-12)) << seed;
    EXPECT_GT(after.energy(), 0.99 * before.energy()) << seed;
  }
}

TEST(MomentumKeeper, MassThatMovesBetweenFacesTakesItsMomentumAlongAndNoMore) {
  for (const unsigned seed : {21u, 22u, 23u}) {
    std::mt19937 rng(seed);
    const MacGrid g{Vec3::Zero(), 0.1, Vec3i(12, 6, 6)};
    Fluid fluid(g, {{{1, 1, 1}, {3, 3, 3}}, {{8, 2, 2}, {9, 3, 4}}}, rng);
    const Fluid before = fluid;
    MomentumKeeper keeper;
    keeper.note(fluid.wet, fluid.mass, fluid.v);
    // Solids take some of one piece's faces; the other's masses grow by that, so that none is lost.
    std::uniform_real_distribution<double> unit(0.2, 1.0);
    std::array<double, 3> was{}, is{};
    for (std::size_t f = 0; f < fluid.mass.size(); ++f) {
      if (fluid.wet.kind[f] != WetFaces::Kind::Free) fluid.mass[f] = 0.0;
      was[f % 3] += before.wet.kind[f] == WetFaces::Kind::Free ? before.mass[f] : 0.0;
      fluid.mass[f] *= unit(rng);
      is[f % 3] += fluid.mass[f];
    }
    for (std::size_t f = 0; f < fluid.mass.size(); ++f) fluid.mass[f] *= was[f % 3] / is[f % 3];
    keeper.hand_over(g, fluid.wet, fluid.mass, fluid.v);
    EXPECT_LT((fluid.momentum(g) - before.momentum(g)).norm(), 1e-12 * before.momentum(g).norm()) << seed;
    EXPECT_LT(fluid.energy(), before.energy() * (1.0 + 1e-12)) << seed;
  }
}

TEST(MomentumKeeper, WhatDidNotChangeIsLeftAlone) {
  std::mt19937 rng(7);
  const MacGrid g{Vec3::Zero(), 0.1, Vec3i(5, 5, 5)};
  Fluid fluid(g, {{{0, 0, 0}, {4, 4, 2}}}, rng);
  const std::vector<double> v = fluid.v;
  MomentumKeeper keeper;
  keeper.note(fluid.wet, fluid.mass, fluid.v);
  keeper.restore(g, fluid.wet, fluid.mass, true, fluid.v);
  for (std::size_t f = 0; f < v.size(); ++f) EXPECT_NEAR(fluid.v[f], v[f], 1e-12);
}

}  // namespace
}  // namespace brim::momentum_keeper_test
