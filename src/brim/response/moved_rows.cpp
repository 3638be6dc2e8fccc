#include "brim/response/moved_rows.h"

#include <cmath>

namespace brim {

namespace {

/// [1/h] curvature below which a surface counts as flat.
constexpr double kNearlyFlat = 1e-4;

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;

Mat2 tensor_of(const std::array<float, 3>& t) {
  Mat2 m;
  m << t[0], t[1], t[1], t[2];
  return m;
}

Mat2 inverse_of(const Mat2& m) {
  Mat2 r;
  r << m(1, 1), -m(0, 1), -m(1, 0), m(0, 0);
  return r / (m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0));
}

}  // namespace

Eigen::Matrix<double, 3, 2> tangents_of(const Vec3& n) {
  // Duff and others 2017, "Building an orthonormal basis, revisited".
  const double sign = std::copysign(1.0, n.z()), a = -1.0 / (sign + n.z()), b = n.x() * n.y() * a;
  Eigen::Matrix<double, 3, 2> t;
  t.col(0) << 1.0 + sign * n.x() * n.x() * a, sign * b, -sign * n.x();
  t.col(1) << b, sign + n.y() * n.y() * a, -n.y();
  return t;
}

Mat3 bend_across(const std::array<float, 3>& packed, const Vec3& n) {
  if (packed == std::array<float, 3>{}) return Mat3::Zero();
  const Eigen::Matrix<double, 3, 2> t = tangents_of(n);
  return t * tensor_of(packed) * t.transpose();
}

RowPoint moved(const RowPoint& row, const RigidMotion& a, const RigidMotion& b, double h, double farthest) {
  if (a.none && b.none) return row;
  const double flat = kNearlyFlat / h;
  const Vec3 &n = row.normal, by_a = a.displacement(row.point), by_b = b.displacement(row.point);
  const Eigen::Matrix<double, 3, 2> across = tangents_of(n);
  const Vec2 way_a = across.transpose() * by_a, way_b = across.transpose() * by_b;
  const Vec2 tilt_a = across.transpose() * a.rotation.cross(n), tilt_b = across.transpose() * b.rotation.cross(n);
  const Mat2 bend_a = tensor_of(row.bend_a), bend_b = tensor_of(row.bend_b), bend = bend_a + bend_b;
  // Flat directions move with the mean motion, curved ones roll.
  const Mat2 inverse = inverse_of(bend + flat * Mat2::Identity());
  Vec2 way =
      inverse * (bend_a * way_a + bend_b * way_b + bend * (inverse * (tilt_a - tilt_b)) + 0.5 * flat * (way_a + way_b));
  // On nearly flat surfaces the point would roll too far.
  if (way.norm() > farthest * h) way *= farthest * h / way.norm();
  const double size_a = bend_a.norm() + 0.5 * flat, size_b = bend_b.norm() + 0.5 * flat;
  const double share = size_a / (size_a + size_b);
  const Vec2 turn = share * (tilt_b + bend_b * (way - way_b)) + (1.0 - share) * (tilt_a - bend_a * (way - way_a));
  RowPoint r = row;
  r.point += across * way + 0.5 * n.dot(by_a + by_b) * n;
  r.normal = (n + across * turn).normalized();
  r.gap += n.dot(by_a - by_b);
  return r;
}

}  // namespace brim
