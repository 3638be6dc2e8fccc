#include "brim/response/round_gap.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

#include "brim/response/moved_rows.h"

namespace brim {

namespace {

constexpr int kNewtonSteps = 3;
/// [1/h] curvatures of what is round: below it is flat, above an edge.
constexpr double kLeastCurved = 0.02, kMostCurved = 0.5;
/// Least ratio of the curvatures over two spans and one of what is round.
constexpr double kEven = 0.75;
/// [voxels] over which differences are taken, and farthest that one step and all lead.
constexpr double kSpan = 0.75, kFarthestAway = 1.5;
/// [voxels] the same where distances are formulas; steps there, and the way that ends them, [voxels]; sum of two unit
/// slopes of surfaces that face each other.
constexpr double kFormula = 0.02, kSettled = 1e-5, kOpposed = 1.0;
constexpr int kFormulaSteps = 8;

/// d_a + d_b at x − way, x and x + way.
std::array<double, 3> gaps(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& way) {
  std::array<double, 3> sum{};
  for (const CubeSide* side : {&a, &b}) {
    std::array<double, 3> px, py, pz, d;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 at = side->pose.to_local(x + (static_cast<double>(k) - 1.0) * way);
      px[k] = at.x(), py[k] = at.y(), pz[k] = at.z();
    }
    side->solid->distances({px.data(), py.data(), pz.data(), 3}, d.data());
    for (std::size_t k = 0; k < 3; ++k) sum[k] += d[k];
  }
  return sum;
}

/// Slope and curvature of a distance, by differences over a step.
struct Form {
  double distance = 0.0;  ///< [m]
  Vec3 slope;
  Mat3 bend;  ///< [1/m]
};
Form form_of(const CubeSide& side, const Vec3& x, double step) {
  const auto at = [&](const Vec3& way) {
    const Vec3 p = side.pose.to_local(x + way);
    return side.solid->rough_distance(p);
  };
  Form f;
  const double here = f.distance = at(Vec3::Zero());
  Vec3 ahead, behind;
  for (int i = 0; i < 3; ++i) {
    const Vec3 way = step * Vec3::Unit(i);
    ahead[i] = at(way), behind[i] = at(-way);
    f.bend(i, i) = ahead[i] - 2.0 * here + behind[i];
  }
  f.slope = (ahead - behind) / (2.0 * step);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < i; ++j) {
      const Vec3 way = step * (Vec3::Unit(i) + Vec3::Unit(j));
      f.bend(i, j) = f.bend(j, i) =
          0.5 * (at(way) + at(-way) - ahead[i] - ahead[j] - behind[i] - behind[j] + 2.0 * here);
    }
  f.bend /= step * step;
  return f;
}

double bend_of(const std::array<double, 3>& gap, double span) {
  return (gap[0] - 2.0 * gap[1] + gap[2]) / (span * span);
}

/// True where the gap is bent as much over twice the span: an edge bends half as much.
bool even_along(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& e, double h) {
  const auto bend_over = [&](double span) { return h * bend_of(gaps(a, b, x, span * e), span); };
  const double near = bend_over(kSpan * h);
  return near > kLeastCurved && bend_over(2.0 * kSpan * h) > kEven * near;
}

}  // namespace

RoundDirections round_directions(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& normal,
                                 const Mat3& curvature, double h) {
  const Eigen::Matrix<double, 3, 2> across = tangents_of(normal);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(across.transpose() * curvature * across);
  RoundDirections out{Vec3::Zero(), Vec3::Zero()};
  for (int i = 0; i < 2; ++i) {
    const double bend = h * axes.eigenvalues()[i];
    if (!(bend > kLeastCurved && bend < kMostCurved)) continue;
    const Vec3 e = across * axes.eigenvectors().col(i);
    if (even_along(a, b, x, e, h)) out[static_cast<std::size_t>(i)] = e;
  }
  return out;
}

std::optional<RoundGap> settle_round_gap(const CubeSide& a, const CubeSide& b, const Vec3& x,
                                         const RoundDirections& round, double h) {
  Vec3 at = x;
  bool any = false;
  for (int step = 0; step < kNewtonSteps; ++step)
    for (const Vec3& e : round) {
      if (e.isZero(0.0)) continue;
      any = true;
      const double s = kSpan * h;
      const std::array<double, 3> g = gaps(a, b, at, s * e);
      const double bend = bend_of(g, s);
      if (!(bend * h > kLeastCurved)) return std::nullopt;
      at += std::clamp(0.5 * (g[0] - g[2]) / (s * bend), -s, s) * e;
    }
  if (!any || !((at - x).norm() < kFarthestAway * h)) return std::nullopt;
  return RoundGap{at, gaps(a, b, at, Vec3::Zero())[1]};
}

std::optional<RoundPoint> find_round_point(const CubeSide& a, const CubeSide& b, const Vec3& x, const Vec3& normal,
                                           double h) {
  if (!a.solid->by_rows() || !b.solid->by_rows()) return std::nullopt;
  RoundPoint at;
  at.x = x, at.normal = normal;
  for (int step = 0; step < kFormulaSteps; ++step) {
    const Form of_a = form_of(a, at.x, kFormula * h), of_b = form_of(b, at.x, kFormula * h);
    if (const Vec3 n = of_b.slope - of_a.slope; n.norm() > kOpposed) at.normal = n.normalized();
    const Mat3 across = Mat3::Identity() - at.normal * at.normal.transpose();
    at.gap = of_a.distance + of_b.distance;
    at.bend_a = across * of_a.bend * across, at.bend_b = across * of_b.bend * across;
    const Eigen::Matrix<double, 3, 2> t = tangents_of(at.normal);
    const Eigen::Matrix2d bend = t.transpose() * (at.bend_a + at.bend_b) * t;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(bend);
    if (!(h * axes.eigenvalues()[0] > kLeastCurved) || !(h * axes.eigenvalues()[1] < kMostCurved)) return std::nullopt;
    Vec3 way = -(t * (bend.inverse() * (t.transpose() * (of_a.slope + of_b.slope))));
    if (way.norm() > h) way *= h / way.norm();
    at.x += way + 0.5 * (of_a.distance - of_b.distance) * at.normal;
    if (!((at.x - x).norm() < kFarthestAway * h)) return std::nullopt;
    if (way.norm() > kSettled * h) continue;
    for (int i = 0; i < 2; ++i)
      if (!even_along(a, b, at.x, t * axes.eigenvectors().col(i), h)) return std::nullopt;
    return at;
  }
  return std::nullopt;
}

}  // namespace brim
