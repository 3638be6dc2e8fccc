#include "brim/contact/patch_center.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "brim/math/rotation.h"
#include "brim/raster/shape.h"
#include "contact/solid_side.h"

/// What touches at a point is carried at that point, what touches along a line on that line; faces keep their points.
namespace brim::patch_center_test {
namespace {

constexpr double h = 0.1;

using testing::solid_side;

/// The contacts of two solids around a place, centred.
std::vector<Contact> centred(const CubeSide& a, const CubeSide& b, const Vec3& place, double reach) {
  ContactPair pair{0, 1, h, 3.0 * h, 0.0, 0, 0};
  CubeFinds finds;
  const Vec3i lo = ((place - Vec3::Constant(reach)) / h).array().floor().cast<int>(),
              hi = ((place + Vec3::Constant(reach)) / h).array().ceil().cast<int>();
  find_between_solids(a, b, pair, {lo, hi}, finds);
  center_on_least_gap(a, b, a, 1.0, h, finds.contacts);
  return finds.contacts;
}

TEST(PatchCenter, ABallIsCarriedStraightBelowItsMiddleWhereverTheNodesLie) {
  const auto ball = make_sphere(0.4), plane = make_half_space();
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int trial = 0; trial < 50; ++trial) {
    const Mat3 turn = rotation_from_vector(Vec3(u(rng), u(rng), u(rng))).toRotationMatrix();
    const Vec3 below = h * Vec3(u(rng), u(rng), u(rng)), n = turn.col(2);
    const Vec3 middle = below + 0.39 * n;
    const auto contacts = centred(solid_side(ball, {turn, middle}), solid_side(plane, {turn, below}), below, 0.3);
    ASSERT_FALSE(contacts.empty());
    for (const Contact& c : contacts) {
      const Vec3 lever = c.point - middle;
      // A curvature of 0.005 voxels a voxel is blended to flat: a fiftieth of the half voxel to the node is left.
      EXPECT_LT((lever - n * n.dot(lever)).norm(), 0.05 * h);
      // At the radius of the ball, though it sinks in by a tenth of a voxel.
      EXPECT_NEAR(lever.norm(), 0.4, 0.05 * h);
    }
  }
}

/// The contacts of two solids around a place, as they are found.
double roundness_of(const CubeSide& a, const CubeSide& b, double reach) {
  ContactPair pair{0, 1, h, 3.0 * h, 0.0, 0, 0};
  CubeFinds finds;
  const int n = static_cast<int>(std::ceil(reach / h));
  find_between_solids(a, b, pair, {Vec3i::Constant(-n), Vec3i::Constant(n)}, finds);
  return roundness(a, b, h, finds.contacts);
}

TEST(PatchCenter, BallsAndLyingCylindersAreRoundAndBoxesAreNotHoweverTheyLean) {
  const auto plane = make_half_space(), box = make_box(Vec3(0.8, 0.8, 0.8));
  const Mat3 lying = rotation_from_vector(Vec3(M_PI / 2, 0, 0)).toRotationMatrix();
  EXPECT_GT(
      roundness_of(solid_side(make_sphere(0.4), {Mat3::Identity(), Vec3(0, 0, 0.39)}), solid_side(plane, {}), 0.6),
      0.9);
  EXPECT_GT(roundness_of(solid_side(make_cylinder(0.4, 0.8), {lying, Vec3(0, 0, 0.39)}), solid_side(plane, {}), 0.6),
            0.9);
  for (const double lean : {0.0, 0.001, 0.003, 0.01, 0.03}) {
    const Mat3 turn = rotation_from_vector(Vec3(0, lean, 0)).toRotationMatrix();
    const Vec3 corner = turn * Vec3(0.4, 0, -0.4);  // the lower edge, at a hundredth of a voxel's depth
    const Vec3 middle(0.0, 0.0, -corner.z() - 0.01 * h);
    EXPECT_LT(roundness_of(solid_side(box, {turn, middle}), solid_side(plane, {}), 0.6), 0.1) << "lean " << lean;
  }
}

TEST(PatchCenter, ACylinderThatTouchesAtItsRimIsCarriedOnItsLine) {
  const auto cylinder = make_cylinder(0.4, 0.4), plane = make_half_space();
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> u(-1, 1);
  int seen = 0;
  for (int trial = 0; trial < 50; ++trial) {
    // It leans on one end by a twentieth of a voxel, and is turned a little across its line.
    const Mat3 lying = (rotation_from_vector(Vec3(0, 0, 0.05 * u(rng))) * rotation_from_vector(Vec3(0.0125, 0, 0)) *
                        rotation_from_vector(Vec3(M_PI / 2, 0, 0)))
                           .toRotationMatrix();
    const Vec3 middle(h * u(rng), h * u(rng), 0.393), line = lying.col(2), across = line.cross(Vec3::UnitZ());
    const auto contacts =
        centred(solid_side(cylinder, {lying, middle}), solid_side(plane, {}), Vec3(middle.x(), middle.y(), 0), 0.4);
    seen += !contacts.empty();  // between nodes it may lie unseen
    for (const Contact& c : contacts)
      if (c.overlap > 0.0f) {
        EXPECT_LT(std::abs(across.dot(c.point - middle)), 0.01 * h) << trial;
      }
  }
  EXPECT_GT(seen, 25);
}

TEST(PatchCenter, ACylinderIsCarriedOnItsLine) {
  const auto cylinder = make_cylinder(0.4, 1.0), plane = make_half_space();
  const Mat3 lying = rotation_from_vector(Vec3(M_PI / 2, 0, 0)).toRotationMatrix();
  const double x = 0.37 * h;
  const auto contacts =
      centred(solid_side(cylinder, {lying, Vec3(x, 0, 0.395)}), solid_side(plane, {}), Vec3(x, 0, 0), 0.6);
  ASSERT_GT(contacts.size(), 4u);
  double lo = 1.0, hi = -1.0;
  for (const Contact& c : contacts) {
    EXPECT_NEAR(c.point.x(), x, 0.05 * h);
    lo = std::min(lo, c.point.y()), hi = std::max(hi, c.point.y());
  }
  EXPECT_LT(lo, -0.35);
  EXPECT_GT(hi, 0.35);
}

TEST(PatchCenter, WhatLiesCloseInAHollowKeepsThePointsOfItsArc) {
  // A drum beside one that is hardly smaller, as a shaft within a wheel: the second distance is that of the hole.
  const auto wheel = make_cylinder(0.8, 2.0);
  class Hole final : public Shape, public KnownDistance {
   public:
    double distance(const Vec3& p) const override { return 0.85 - p.head<2>().norm(); }
    Aabb bounds() const override { return {Vec3(-2, -2, -1), Vec3(2, 2, 1)}; }
    double thickness() const override { return 1.0; }
    void fill(const Pose&, const TileKey&, double, double, DensityBlock&) const override {}
    double slack() const override { return 0.0; }
    double rough_distance(const Vec3& p) const override { return distance(p); }
    bool by_rows() const override { return false; }
  };
  const auto hole = std::make_shared<Hole>();
  for (const double shift : {0.02, 0.031, 0.047}) {
    const CubeSide a = solid_side(hole, {Mat3::Identity(), Vec3(0.0, shift - 0.055, 0.0)}),
                   b = solid_side(wheel, {Mat3::Identity(), Vec3(0.0, shift, 0.0)});
    ContactPair pair{0, 1, h, 3.0 * h, 0.0, 0, 0};
    CubeFinds finds;
    find_between_solids(a, b, pair, {Vec3i(-9, 3, -2), Vec3i(9, 10, 2)}, finds);
    const std::vector<Contact> before = finds.contacts;
    center_on_least_gap(a, b, a, 1.0, h, finds.contacts);
    double widest = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      EXPECT_NEAR(finds.contacts[i].point.x(), before[i].point.x(), 0.05 * std::abs(before[i].point.x()) + 1e-3 * h);
      if (before[i].overlap > 0.0f) widest = std::max(widest, std::abs(before[i].point.x()));
    }
    EXPECT_GT(widest, 0.5 * h);
  }
}

TEST(PatchCenter, FacesAndEdgesStay) {
  const auto box = make_box(Vec3(0.35, 0.35, 0.35)), plane = make_half_space();
  for (const double shift : {0.0, 0.3 * h}) {
    const CubeSide a = solid_side(box, {Mat3::Identity(), Vec3(shift, 0, 0.17)}), b = solid_side(plane, {});
    ContactPair pair{0, 1, h, 3.0 * h, 0.0, 0, 0};
    CubeFinds finds;
    find_between_solids(a, b, pair, {Vec3i(-4, -4, -4), Vec3i(4, 4, 4)}, finds);
    std::vector<Vec3> before;
    for (const Contact& c : finds.contacts) before.push_back(c.point);
    center_on_least_gap(a, b, a, 1.0, h, finds.contacts);
    for (std::size_t c = 0; c < before.size(); ++c) EXPECT_LT((finds.contacts[c].point - before[c]).norm(), 1e-6);
  }
}

TEST(PatchCenter, OfTwoThatMoveTheRounderIsTold) {
  const auto ball = make_sphere(0.4), small = make_sphere(0.2), plane = make_half_space();
  const CubeSide low = solid_side(ball, {Mat3::Identity(), Vec3(0.01, 0.02, -0.39)}),
                 flat = solid_side(plane, {Mat3::Identity(), Vec3::Zero()}),
                 high = solid_side(ball, {Mat3::Identity(), Vec3(0.01, 0.02, 0.39)}),
                 little = solid_side(small, {Mat3::Identity(), Vec3(0.01, 0.02, 0.19)});
  const auto more = [](const CubeSide& one, const CubeSide& other) {
    CubeFinds finds;
    find_between_solids(one, other, {0, 1, h, 3.0 * h, 0.0, 0, 0}, {Vec3i::Constant(-4), Vec3i::Constant(4)}, finds);
    return rounder(one, other, h, finds.contacts);
  };
  EXPECT_NEAR(more(high, flat), 1.0, 1e-3);
  EXPECT_NEAR(more(flat, high), -1.0, 1e-3);
  EXPECT_NEAR(more(high, low), 0.0, 1e-3);
  EXPECT_NEAR(more(little, low), 1.0 / 3.0, 0.05);
}

}  // namespace
}  // namespace brim::patch_center_test
