#include "brim/response/solid_gap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "brim/raster/shape.h"

namespace brim::solid_gap_test {
namespace {

constexpr double h = 0.05;  // [m] a box of 0.2 m has four voxels

struct Placed {
  std::shared_ptr<const Shape> shape;
  Pose pose;
  CubeSide side() const {
    CubeSide s;
    s.solid = dynamic_cast<const KnownDistance*>(shape.get()), s.pose = pose;
    return s;
  }
  double distance(const Vec3& x) const { return shape->distance(pose.to_local(x)); }
};

struct Random {
  explicit Random(unsigned seed) : engine(seed) {}
  std::mt19937 engine;
  double uniform() { return std::uniform_real_distribution<double>(-1.0, 1.0)(engine); }
  Vec3 vector() { return {uniform(), uniform(), uniform()}; }
  Mat3 turn() {
    std::normal_distribution<double> n;
    return Eigen::Quaterniond(n(engine), n(engine), n(engine), n(engine)).normalized().toRotationMatrix();
  }
};

/// Largest separation of two boxes along any of the axes on which it can be largest (Gottschalk and others 1996).
/// @param n  that axis, towards a
double separation(const Vec3& half_a, const Pose& a, const Vec3& half_b, const Pose& b, Vec3& n) {
  double most = -std::numeric_limits<double>::infinity();
  const auto along = [&](const Vec3& axis) {
    if (axis.norm() < 1e-6) return;
    const Vec3 u = axis.normalized();
    const double way = u.dot(a.translation - b.translation), s = std::abs(way) -
                                                                 (a.rotation.transpose() * u).cwiseAbs().dot(half_a) -
                                                                 (b.rotation.transpose() * u).cwiseAbs().dot(half_b);
    if (s > most) most = s, n = way > 0.0 ? u : Vec3(-u);
  };
  for (int i = 0; i < 3; ++i) {
    along(a.rotation.col(i)), along(b.rotation.col(i));
    for (int j = 0; j < 3; ++j) along(a.rotation.col(i).cross(b.rotation.col(j)));
  }
  return most;
}

/// The node of a grid at which two solids overlap most.
RowPoint deepest_node(const Placed& a, const Placed& b) {
  RowPoint row;
  row.gap = std::numeric_limits<double>::infinity();
  const Aabb region =
      a.shape->placed_bounds(a.pose).inflated(1.5 * h).intersection(b.shape->placed_bounds(b.pose).inflated(1.5 * h));
  const Vec3i lo = (region.lo / h).array().ceil().cast<int>(), hi = (region.hi / h).array().floor().cast<int>();
  for (int k = lo.z(); k <= hi.z(); ++k)
    for (int j = lo.y(); j <= hi.y(); ++j)
      for (int i = lo.x(); i <= hi.x(); ++i) {
        const Vec3 x = h * Vec3(i, j, k);
        const double gap = a.distance(x) + b.distance(x);
        if (gap < row.gap) row.point = x, row.gap = gap;
      }
  return row;
}

std::vector<RowPoint> rows_of(const Placed& a, const Placed& b, const RowPoint& near) {
  SolidGap gap(a.side(), b.side(), h);
  EXPECT_TRUE(gap.reads());
  std::vector<RowPoint> rows;
  if (!gap.find_rows(near, 1.0, rows)) rows.clear();
  return rows;
}

double least_gap(const std::vector<RowPoint>& rows) {
  double least = std::numeric_limits<double>::infinity();
  for (const RowPoint& r : rows) least = std::min(least, r.gap);
  return least;
}

TEST(SolidGap, TheLeastGapOfTwoBoxesIsTheirLargestSeparation) {
  Random random(7);
  constexpr int kCases = 2000;
  int found = 0, near_enough = 0;
  const Vec3 half_a(0.1, 0.1, 0.1), half_b(0.1, 0.12, 0.2);
  for (int i = 0; i < kCases; ++i) {
    Placed a{make_box(2.0 * half_a), {random.turn(), Vec3::Zero()}},
        b{make_box(2.0 * half_b), {random.turn(), Vec3::Zero()}};
    const Vec3 way = random.vector().normalized();
    // Apart by -0.3 to 0.1 voxel.
    const double wanted = h * (0.2 * random.uniform() - 0.1);
    Vec3 n = Vec3::Zero();
    double lo = 0.0, hi = 1.0;
    for (int k = 0; k < 50; ++k) {
      b.pose.translation = 0.5 * (lo + hi) * way;
      (separation(half_a, a.pose, half_b, b.pose, n) < wanted ? lo : hi) = 0.5 * (lo + hi);
    }
    RowPoint near = deepest_node(a, b);
    // Normals of nodes are wrong by some tenths next to edges.
    near.normal = (n + 0.3 * random.vector()).normalized();
    const std::vector<RowPoint> rows = rows_of(a, b, near);
    if (rows.empty()) continue;
    ++found;
    const double miss = std::abs(least_gap(rows) - wanted) / h;
    EXPECT_LT(miss, 0.05) << "case " << i;
    near_enough += miss < 0.0101;
  }
  // Where two axes part two boxes nearly as well, the normal may be that of the other.
  EXPECT_GE(found, kCases - kCases / 100);
  EXPECT_GE(near_enough, kCases - kCases / 50);
}

TEST(SolidGap, LongThinSolidsAreFoundHoweverTheyAreTilted) {
  Random random(11);
  int far = 0;
  for (int i = 0; i < 1200; ++i) {
    // 30 to 2,000 voxels long and 1 to 8 thick, tilted by a hundredth of a degree to 90 degrees on a floor.
    const double length = 30.0 * h * std::pow(10.0, 0.9 * (1.0 + random.uniform())), thick = i % 2 == 0 ? h : 8.0 * h,
                 tilt = 0.5 * M_PI * std::pow(10.0, 2.0 * (random.uniform() - 1.0));
    Placed a, floor{make_half_space(), {}};
    a.pose.rotation = Eigen::AngleAxisd(tilt, Vec3(random.uniform(), random.uniform(), 0.0).normalized()) *
                      Eigen::AngleAxisd(M_PI * random.uniform(), Vec3::UnitZ()).toRotationMatrix();
    const double up = std::abs(a.pose.rotation(2, 2)), wanted = h * (0.2 * random.uniform() - 0.02);
    double low = 0.0;
    if (i % 3 == 0) {
      const Vec3 half(0.5 * length, 0.3 * length, 0.5 * thick);
      a.shape = make_box(2.0 * half);
      low = a.pose.rotation.row(2).cwiseAbs() * half;
    } else if (i % 3 == 1) {
      a.shape = make_cylinder(0.5 * length, thick);
      low = 0.5 * thick * up + 0.5 * length * std::sqrt(std::max(0.0, 1.0 - up * up));
    } else {
      a.pose.rotation = a.pose.rotation * Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitX()).toRotationMatrix();
      a.shape = make_capsule(0.5 * thick, length);
      low = 0.5 * thick + 0.5 * length * std::abs(a.pose.rotation(2, 2));
    }
    a.pose.translation = Vec3(random.uniform(), random.uniform(), low + wanted);
    const Mat3 turn = random.turn();
    a.pose = {turn * a.pose.rotation, turn * a.pose.translation}, floor.pose.rotation = turn;
    const Aabb region = a.shape->placed_bounds(a.pose).inflated(1.5 * h).intersection(
        floor.shape->placed_bounds(floor.pose).inflated(1.5 * h));
    SolidGap gap(a.side(), floor.side(), h);
    RowPoint near;
    std::vector<RowPoint> rows;
    ASSERT_TRUE(gap.approach(region, 0.5 * h, near) && gap.find_rows(near, 0.5 * h, rows) && !rows.empty())
        << "case " << i << ": length " << length / h << " voxels, tilt " << tilt;
    EXPECT_NEAR(least_gap(rows), wanted, 0.3 * h) << "case " << i;
    far += std::abs(least_gap(rows) - wanted) > 0.03 * h;
  }
  EXPECT_LE(far, 24);
}

TEST(SolidGap, WhatIsRoundIsExact) {
  Random random(3);
  for (const double R : {1.5 * h, 2.0 * h, 5.0 * h, 20.0 * h})
    for (int i = 0; i < 100; ++i) {
      const Placed ball{make_sphere(R), {random.turn(), R * random.vector()}};
      Placed other{make_sphere(2.0 * h), {random.turn(), Vec3::Zero()}},
          plane{make_half_space(), {random.turn(), Vec3::Zero()}};
      const Vec3 n = random.vector().normalized();
      const double wanted = 0.1 * h * random.uniform();
      other.pose.translation = ball.pose.translation - (R + 2.0 * h + wanted) * n;
      const Vec3 up = plane.pose.rotation.col(2);
      plane.pose.translation = ball.pose.translation - (R + wanted) * up;
      RowPoint near;
      near.normal = (n + 0.1 * random.vector()).normalized();
      near.point = ball.pose.translation - R * n + 0.2 * h * random.vector();
      near.gap = ball.distance(near.point) + other.distance(near.point);
      const std::vector<RowPoint> on_ball = rows_of(ball, other, near);
      near.normal = (up + 0.1 * random.vector()).normalized();
      near.point = ball.pose.translation - R * up + 0.2 * h * random.vector();
      near.gap = ball.distance(near.point) + plane.distance(near.point);
      const std::vector<RowPoint> on_plane = rows_of(ball, plane, near);
      ASSERT_EQ(on_ball.size(), 1u);
      ASSERT_EQ(on_plane.size(), 1u);
      // The descent ends where the normal changes by no more than 6e-3, and the gap by 1e-5 of a voxel.
      EXPECT_NEAR(on_ball[0].gap, wanted, 1e-4 * h);
      EXPECT_NEAR(on_plane[0].gap, wanted, 1e-4 * h);
      EXPECT_GT(on_ball[0].normal.dot(n), 1.0 - 2e-5);
      EXPECT_GT(on_plane[0].normal.dot(up), 1.0 - 1e-9);
      EXPECT_LT((on_plane[0].point - (ball.pose.translation - (R + 0.5 * wanted) * up)).norm(), 0.02 * h);
      EXPECT_NEAR(on_plane[0].bend_a[0] * R, 1.0, 0.01);
      EXPECT_NEAR(on_plane[0].bend_a[2] * R, 1.0, 0.01);
      EXPECT_EQ(on_plane[0].bend_b[0], 0.0f);
    }
}

TEST(SolidGap, ABoxOnAPlaneStandsOnItsCorners) {
  Random random(11);
  const Placed plane{make_half_space(), {}};
  int corners = 0, exact = 0;
  for (const double tilt : {0.0, 1e-6, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2})
    for (int i = 0; i < 100; ++i) {
      Placed box{make_box(Vec3(0.2, 0.2, 0.2)), {}};
      const double about = M_PI * random.uniform();
      box.pose.rotation = Eigen::AngleAxisd(tilt, Vec3(std::cos(about), std::sin(about), 0.0)).toRotationMatrix() *
                          Eigen::AngleAxisd(M_PI * random.uniform(), Vec3::UnitZ()).toRotationMatrix();
      box.pose.translation = Vec3(h * random.uniform(), h * random.uniform(), 0.1 + 0.1 * h * random.uniform());
      RowPoint near = deepest_node(box, plane);
      near.normal = (Vec3::UnitZ() + 0.1 * random.vector()).normalized();
      const std::vector<RowPoint> rows = rows_of(box, plane, near);
      ASSERT_FALSE(rows.empty());
      for (int k = 0; k < 4; ++k) {
        const Vec3 corner =
            box.pose.rotation * Vec3(k & 1 ? 0.1 : -0.1, k & 2 ? 0.1 : -0.1, -0.1) + box.pose.translation;
        const RowPoint* best = &rows.front();
        for (const RowPoint& r : rows)
          if ((r.point - corner).norm() < (best->point - corner).norm()) best = &r;
        const double off = (best->point - Vec3(corner.x(), corner.y(), 0.5 * corner.z())).norm() / h;
        ++corners;
        exact += off < 0.11 && std::abs(best->gap - corner.z()) < 0.01 * h;
      }
    }
  // A way that ends right at a corner finds no edge to go on along.
  EXPECT_GE(exact, corners - corners / 50);
}

TEST(SolidGap, ACapsuleNearlyFlatStandsOnBothItsEnds) {
  // Tilted a little, its lowest point lies on the ball at its lower end. With one row there and none at the other end a
  // capsule rocked from step to step and sank through the floor.
  Random random(7);
  const Placed plane{make_half_space(), {}};
  for (const double length : {3.0 * h, 6.0 * h, 20.0 * h})
    for (const double R : {1.5 * h, 3.0 * h, 5.0 * h})
      for (const double rise : {0.0, 1e-3 * h, 0.01 * h, 0.1 * h, 0.25 * h}) {
        const double tilt = std::asin(rise / length);
        if (R * tilt > 0.4 * h) continue;  // a stub: the lower end is half a voxel from its lowest point
        // The flat line ends R tilt before the lowest point of the ball, and is found to a tenth of a voxel.
        const double accuracy = 0.01 * h + tilt * (R * tilt + 0.1 * h);
        for (int i = 0; i < 20; ++i) {
          Placed capsule{make_capsule(R, length), {}};
          capsule.pose.rotation = Eigen::AngleAxisd(M_PI * random.uniform(), Vec3::UnitZ()).toRotationMatrix() *
                                  Eigen::AngleAxisd(0.5 * M_PI + tilt, Vec3::UnitY()).toRotationMatrix();
          const double wanted = 0.1 * h * random.uniform();
          capsule.pose.translation = Vec3(h * random.uniform(), h * random.uniform(), R + 0.5 * rise + wanted);
          RowPoint near = deepest_node(capsule, plane);
          near.normal = (Vec3::UnitZ() + 0.1 * random.vector()).normalized();
          const std::vector<RowPoint> rows = rows_of(capsule, plane, near);
          for (const double end : {-0.5, 0.5}) {
            const Vec3 center = capsule.pose.rotation * Vec3(0, 0, end * length) + capsule.pose.translation;
            EXPECT_TRUE(std::ranges::any_of(rows,
                                            [&](const RowPoint& r) {
                                              return (r.point - center).head<2>().norm() < 0.5 * h &&
                                                     std::abs(r.gap - (center.z() - R)) < accuracy;
                                            }))
                << length / h << " long, radius " << R / h << ", rise " << rise / h << ", rows " << rows.size();
          }
        }
      }
}

TEST(SolidGap, ABoxOnAnEdgeStandsOnTheEndsOfTheEdge) {
  Random random(5);
  const Placed plane{make_half_space(), {}};
  for (const double tilt : {0.3, 0.5, M_PI / 4.0, 1.2})
    for (int i = 0; i < 50; ++i) {
      Placed box{make_box(Vec3(0.2, 0.3, 0.2)), {}};
      box.pose.rotation = Eigen::AngleAxisd(M_PI * random.uniform(), Vec3::UnitZ()).toRotationMatrix() *
                          Eigen::AngleAxisd(tilt, Vec3::UnitY()).toRotationMatrix();
      const double height = 0.1 * (std::sin(tilt) + std::cos(tilt)), wanted = 0.1 * h * random.uniform();
      box.pose.translation = Vec3(h * random.uniform(), h * random.uniform(), height + wanted);
      RowPoint near = deepest_node(box, plane);
      near.normal = (Vec3::UnitZ() + 0.2 * random.vector()).normalized();
      const std::vector<RowPoint> rows = rows_of(box, plane, near);
      ASSERT_GE(rows.size(), 2u) << tilt;
      EXPECT_LE(rows.size(), 3u) << tilt;
      double length = 0.0;
      for (const RowPoint& r : rows)
        for (const RowPoint& s : rows) length = std::max(length, (r.point - s.point).norm());
      EXPECT_NEAR(length, 0.3, 0.2 * h);
      for (const RowPoint& r : rows) EXPECT_NEAR(r.gap, wanted, 0.01 * h);
    }
}

TEST(SolidGap, AStandingCylinderHasPlacesAllAround) {
  const Placed plane{make_half_space(), {}};
  const Placed cylinder{make_cylinder(0.2, 0.3), {Mat3::Identity(), Vec3(0.01, 0.02, 0.149)}};
  RowPoint near;
  near.point = Vec3(0.06, -0.03, 0.0), near.normal = Vec3::UnitZ();
  near.gap = cylinder.distance(near.point) + plane.distance(near.point);
  const std::vector<RowPoint> rows = rows_of(cylinder, plane, near);
  ASSERT_EQ(rows.size(), 4u);
  Vec3 middle = Vec3::Zero();
  for (const RowPoint& r : rows) {
    middle += 0.25 * r.point;
    EXPECT_NEAR(r.gap, -0.001, 1e-6);
    EXPECT_NEAR((r.point - cylinder.pose.translation).head<2>().norm(), 0.2, 0.1 * h);
  }
  EXPECT_LT((middle - cylinder.pose.translation).head<2>().norm(), 0.5 * h);
}

}  // namespace
}  // namespace brim::solid_gap_test
