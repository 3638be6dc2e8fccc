#include "brim/raster/shape_queries.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "brim/math/rotation.h"
#include "brim/mesh/distance.h"
#include "brim/mesh/primitives.h"
#include "brim/raster/grid_shape.h"
#include "mesh/data.h"

namespace brim::shape_queries_test {
namespace {

const Aabb kAround{Vec3::Constant(-1.5), Vec3::Constant(1.5)};

/// A shape and a triangle mesh of its surface, made by other code.
struct Sample {
  const char* name;
  std::shared_ptr<const Shape> shape;
  TriMesh mesh;
  double error;  ///< [m] distance of the mesh from the surface, at most
};

std::vector<Sample> samples() {
  const double fine = 1.0 - std::cos(std::numbers::pi / 96);
  DistanceGridOptions grid;
  grid.spacing = 0.02;
  const TriMesh ring = shapes::torus(0.5, 0.2, 96, 96);
  return {{"sphere", make_sphere(0.7), shapes::icosphere(0.7, 4), 0.7 * 3e-3},
          {"box", make_box(Vec3(1.0, 0.6, 0.3)), shapes::box(Vec3(1.0, 0.6, 0.3)), 1e-9},
          {"capsule", make_capsule(0.3, 0.8), shapes::capsule(0.3, 0.8, 96), 0.3 * 2 * fine},
          {"cylinder", make_cylinder(0.5, 0.4), shapes::cylinder(0.5, 0.4, 96), 0.5 * fine},
          {"torus", make_torus(0.5, 0.2), ring, 0.7 * 2 * fine},
          {"mesh", make_grid_shape(std::make_shared<DistanceGrid>(make_distance_grid(ring, grid)), 0.4), ring, 2e-3}};
}

Pose some_pose() { return {rotation_from_vector(Vec3(0.4, -0.7, 0.3)).toRotationMatrix(), Vec3(0.1, -0.2, 0.3)}; }

/// The twin: all triangles.
std::optional<RayEntry> enter_mesh(const Ray& ray, const TriMesh& mesh) {
  std::optional<RayEntry> best;
  for (const Triangle& t : mesh.triangles) {
    const auto e = enter(ray, {{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, 3, 0.0});
    if (e && (!best || e->distance < best->distance)) best = e;
  }
  return best;
}

TEST(ShapeQueries, RaysMeetWhatTheTrianglesOfTheShapeMeet) {
  const std::uint64_t seed = 31;
  SCOPED_TRACE(seed);
  for (const Sample& s : samples()) {
    SCOPED_TRACE(s.name);
    test::Random random(seed);
    const Pose pose = some_pose();
    TriMesh mesh = s.mesh;
    for (Vec3& x : mesh.vertices) x = pose.rotation * x + pose.translation;
    int met = 0, differ = 0;
    for (int i = 0; i < 400; ++i) {
      const Vec3 from = random.in(kAround);
      if (s.shape->distance(pose.to_local(from)) <= s.error) continue;
      const Ray ray{from, (0.5 * random.in(kAround)-from).normalized(), 10.0};
      const auto entry = enter(ray, *s.shape, pose);
      const auto twin = enter_mesh(ray, mesh);
      if (entry) {
        ++met;
        EXPECT_LT(entry->normal.dot(ray.direction), 1e-3);
        EXPECT_NEAR(entry->normal.norm(), 1.0, 1e-12);
        EXPECT_NEAR(s.shape->distance(pose.to_local(ray.at(entry->distance))), 0.0, 1e-9) << "on the surface";
      }
      // Rays that graze may meet one and miss the other; elsewhere the error grows with the slope of the ray.
      if (!entry && !twin) continue;
      const double steep = entry ? -entry->normal.dot(ray.direction) : 0.0;
      if (entry.has_value() != twin.has_value() || steep < 0.2) {
        ++differ;
        continue;
      }
      if (entry && std::abs(entry->distance - twin->distance) > 4.0 * s.error / steep) ++differ, ADD_FAILURE() << i;
    }
    EXPECT_GT(met, 80);
    EXPECT_LT(differ, 60);
  }
}

TEST(ShapeQueries, ARayOnATorusIsTheRootOfItsQuartic) {
  const double R = 0.5, r = 0.2;
  const auto torus = make_torus(R, r);
  const std::uint64_t seed = 32;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  int met = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3 from = 2.0 * random.in(kAround).normalized();
    const Ray ray{from, (0.4 * random.in(kAround)-from).normalized(), 10.0};
    const auto entry = enter(ray, *torus, Pose{});
    // (|x|² + R² − r²)² − 4 R² (x² + y²) changes its sign at the surface: the first root by dense samples.
    const auto f = [&](double t) {
      const Vec3 x = ray.at(t);
      return std::pow(x.squaredNorm() + R * R - r * r, 2) - 4 * R * R * (x.x() * x.x() + x.y() * x.y());
    };
    double root = -1.0;
    const int n = 20000;
    for (int k = 1; k <= n && root < 0.0; ++k) {
      double a = 4.0 * (k - 1) / n, b = 4.0 * k / n;
      if (f(b) > 0.0) continue;
      for (int j = 0; j < 60; ++j) (f(0.5 * (a + b)) > 0.0 ? a : b) = 0.5 * (a + b);
      root = b;
    }
    if (root < 0.0) continue;
    ++met;
    ASSERT_TRUE(entry) << i;
    EXPECT_NEAR(entry->distance, root, 1e-7) << i;  // a root of a quartic: a graze loses half the digits
  }
  EXPECT_GT(met, 150);
}

TEST(ShapeQueries, EndForRaysFromFarAwayAndForNoNumbers) {
  for (const Sample& s : samples()) {
    SCOPED_TRACE(s.name);
    const double x = s.shape->distance(Vec3(0.5, 0.03, 0)) < 0.0 ? 0.5 : 0.05;
    for (const double away : {1e6, 1e12, 1e15}) {
      const auto entry = enter({Vec3(x, 0.03, -away), Vec3::UnitZ()}, *s.shape, Pose{});
      // Beyond 1e13 a step of rounding is wider than the solid.
      ASSERT_TRUE(entry || away > 1e13);
      if (entry) {
        EXPECT_NEAR(entry->distance, away, 1.0);
      }
    }
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(enter({Vec3(x, 0.03, -3), Vec3::UnitZ(), 10.0}, *s.shape, {Mat3::Identity(), Vec3::Constant(nan)}));
  }
}

TEST(ShapeQueries, ExactOnBallBoxAndPlane) {
  const auto hit = [](const Shape& s, const Vec3& from, const Vec3& along) {
    return enter({from, along.normalized(), 1e9}, s, Pose{});
  };
  EXPECT_NEAR(hit(*make_sphere(0.5), Vec3(0.3, 0, 2), -Vec3::UnitZ())->distance, 1.6, 1e-12);
  EXPECT_FALSE(hit(*make_sphere(0.5), Vec3(0.51, 0, 2), -Vec3::UnitZ()));
  const auto box = hit(*make_box(Vec3(1, 1, 1)), Vec3(3, 0.2, 0.1), -Vec3::UnitX());
  EXPECT_NEAR(box->distance, 2.5, 1e-12);
  EXPECT_NEAR((box->normal - Vec3::UnitX()).norm(), 0.0, 1e-9);
  const auto floor = make_half_space();
  EXPECT_NEAR(hit(*floor, Vec3(0, 0, 3), Vec3(4, 0, -3))->distance, 5.0, 1e-12);
  EXPECT_FALSE(hit(*floor, Vec3(0, 0, 1e-9), Vec3::UnitX())) << "along the floor";
  EXPECT_FALSE(hit(*floor, Vec3(0, 0, 1), Vec3(1, 0, 1e-12)));
  EXPECT_EQ(hit(*floor, Vec3(0, 0, -1), Vec3::UnitX())->distance, 0.0) << "inside";
  EXPECT_EQ(hit(*make_torus(0.5, 0.2), Vec3(0, 0, 3), -Vec3::UnitZ()).has_value(), false) << "through the hole";
  const Vec3 tangent(0.7, -3, 0);
  EXPECT_FALSE(hit(*make_torus(0.5, 0.2), tangent + Vec3(1e-6, 0, 0), Vec3::UnitY()));
}

TEST(ShapeQueries, TheNearestPointIsThatOfTheTriangles) {
  const std::uint64_t seed = 33;
  SCOPED_TRACE(seed);
  for (const Sample& s : samples()) {
    SCOPED_TRACE(s.name);
    test::Random random(seed);
    const Pose pose = some_pose();
    const SurfaceTree tree(s.mesh);
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = 1.5 * random.in(kAround);
      const NearPoint near = nearest(p, *s.shape, pose);
      const double twin = tree.signed_distance(pose.to_local(p));
      EXPECT_NEAR(near.distance, twin, 3.0 * s.error) << i << " at " << p.transpose();
      EXPECT_NEAR((p - near.point).norm(), std::abs(near.distance), 2e-6) << i;
      EXPECT_NEAR(s.shape->distance(pose.to_local(near.point)), 0.0, 1e-9) << i;
      if (std::abs(near.distance) > 0.01) {
        EXPECT_NEAR((p - near.point - near.distance * near.normal).norm(), 0.0, 4e-6) << i;
      }
    }
  }
  const NearPoint middle = nearest(Vec3::Zero(), *make_box(Vec3(1, 2, 3)), Pose{});
  EXPECT_DOUBLE_EQ(middle.distance, -0.5) << "where several points are nearest";
  EXPECT_NEAR(std::abs(middle.point.x()), 0.5, 1e-9);
}

TEST(ShapeQueries, ABoxMeetsASolidWhereOneOfItsPointsIsInside) {
  const std::uint64_t seed = 34;
  SCOPED_TRACE(seed);
  for (const Sample& s : samples()) {
    SCOPED_TRACE(s.name);
    test::Random random(seed);
    const Pose pose = some_pose();
    int yes = 0, no = 0;
    for (int i = 0; i < 300; ++i) {
      const Pose box{rotation_from_vector(random.in(kAround)).toRotationMatrix(), random.in(kAround)};
      const Vec3 half = 0.3 * random.in(kAround).cwiseAbs() + Vec3::Constant(0.02);
      const bool meets = meets_box(*s.shape, pose, box, half);
      (meets ? yes : no)++;
      double least = 1.0;  // of the distance over points of the box
      for (int k = 0; k < 4000; ++k) {
        const Vec3 u = random.in(Aabb{-half, half});
        least = std::min(least, s.shape->distance(pose.to_local(box.rotation * u + box.translation)));
      }
      if (least < 0.0) {
        EXPECT_TRUE(meets) << i;
      }
      if (least > 0.35 * half.norm()) {  // farther than samples are apart
        EXPECT_FALSE(meets) << i;
      }
    }
    EXPECT_GT(yes, 15);
    EXPECT_GT(no, 100);
  }
  const Pose on_floor{Mat3::Identity(), Vec3(0, 0, 0.5)};
  EXPECT_TRUE(meets_box(*make_half_space(), Pose{}, on_floor, Vec3::Constant(0.5)));
  EXPECT_FALSE(meets_box(*make_half_space(), Pose{}, on_floor, Vec3::Constant(0.4999)));
}

}  // namespace
}  // namespace brim::shape_queries_test
