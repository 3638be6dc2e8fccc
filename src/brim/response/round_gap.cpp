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

double bend_of(const std::array<double, 3>& gap, double span) {
  return (gap[0] - 2.0 * gap[1] + gap[2]) / (span * span);
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
    const auto bend_over = [&](double span) { return h * bend_of(gaps(a, b, x, span * e), span); };
    const double near = bend_over(kSpan * h);
    // An edge bends half as much over twice the span.
    if (near > kLeastCurved && bend_over(2.0 * kSpan * h) > kEven * near) out[static_cast<std::size_t>(i)] = e;
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

}  // namespace brim
