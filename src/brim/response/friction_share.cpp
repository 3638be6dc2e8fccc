#include "brim/response/friction_share.h"

#include <algorithm>

#include "brim/response/moved_rows.h"

namespace brim {

namespace {

/// Smallest cosine of a node's normal to the mean one of a flat patch; smallest determinant of the spread of its
/// points, relative to the square of its trace: below it they lie on a line.
constexpr double kFlatPatch = 0.9, kAlmostALine = 1e-6;
/// Newton steps; change of the exponent at any node in one of them; distance from the centre, relative to the radius of
/// the points, at which they end.
constexpr int kSteps = 20;
constexpr double kLargestStep = 2.0, kCentered = 1e-4;

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;

}  // namespace

FrictionShare share_about(std::span<const Vec3> points, std::span<const Vec3> normals, std::span<const double> loads,
                          double net, const Vec3& center) {
  const std::size_t n = points.size();
  double sum = 0.0, radius = 0.0;
  Vec3 middle = Vec3::Zero(), normal = Vec3::Zero();
  for (std::size_t i = 0; i < n; ++i)
    if (loads[i] > 0.0) sum += loads[i], middle += loads[i] * (points[i] - center), normal += loads[i] * normals[i];
  if (!(sum > 0.0)) return {};
  const FrictionShare even{.scale = net / sum, .center = center + middle / sum};
  if (!(normal.norm() > 0.0)) return even;
  normal.normalize();
  for (std::size_t i = 0; i < n; ++i) {
    if (!(loads[i] > 0.0)) continue;
    if (normals[i].dot(normal) < kFlatPatch) return even;
    radius = std::max(radius, (points[i] - even.center).norm());
  }
  const Eigen::Matrix<double, 3, 2> across = tangents_of(normal);
  const Vec2 target = across.transpose() * (center - even.center);
  // Newton's method for the minimum of log Σ l exp(b·(y − target)), convex in b.
  FrictionShare f = even;
  for (int step = 0;; ++step) {
    double weight = 0.0;
    Vec2 first = Vec2::Zero();
    Mat2 second = Mat2::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      if (!(loads[i] > 0.0)) continue;
      const double w = f.of(loads[i], points[i]);
      const Vec2 y = across.transpose() * (points[i] - f.center);
      weight += w, first += w * y, second += w * y * y.transpose();
    }
    f.scale *= net / weight;
    const Vec2 at = first / weight;
    if ((target - at).norm() <= kCentered * radius || step == kSteps) return f;
    const Mat2 spread = second / weight - at * at.transpose();
    if (!(spread.determinant() > kAlmostALine * spread.trace() * spread.trace())) return f;
    const Vec3 more = across * (spread.inverse() * (target - at));
    f.tilt += std::min(1.0, kLargestStep / (more.norm() * radius)) * more;
  }
}

}  // namespace brim
