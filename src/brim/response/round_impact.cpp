#include "brim/response/round_impact.h"

#include <algorithm>
#include <cmath>

namespace brim {

namespace {

/// [1/h] curvatures of what is round; largest relative difference between directions.
constexpr double kLeastRound = 1e-3, kMostRound = 0.95, kUneven = 0.05;
/// Cosine of axes that count as parallel.
constexpr double kParallel = 0.999;

/// A surface that is round: as a ball, or about an axis in which it is flat.
struct Surface {
  double radius = 0.0;  ///< [m] 0: it is not
  Vec3 flat = Vec3::Zero();
};

Surface surface_of(const std::array<float, 3>& bend, const Vec3& n, double h) {
  const double mean = 0.5 * (double{bend[0]} + bend[2]), half = 0.5 * (double{bend[0]} - bend[2]),
               spread = std::hypot(half, double{bend[1]}), most = mean + spread;
  const auto round = [&](double c) { return c * h > kLeastRound && c * h < kMostRound; };
  if (spread < kUneven * mean) return {round(mean) ? 1.0 / mean : 0.0};
  if (!round(most) || mean - spread > kUneven * most) return {};
  const double angle = 0.5 * std::atan2(double{bend[1]}, half);  // of the most curved direction
  return {1.0 / most, tangents_of(n) * Eigen::Vector2d(-std::sin(angle), std::cos(angle))};
}

}  // namespace

RoundContact round_contact(const RowPoint& row, double h) {
  const Surface a = surface_of(row.bend_a, row.normal, h), b = surface_of(row.bend_b, row.normal, h);
  if (!(a.radius > 0.0) || !(b.radius > 0.0)) return {};
  const bool ball_a = a.flat == Vec3::Zero(), ball_b = b.flat == Vec3::Zero();
  if (!ball_a && !ball_b && std::abs(a.flat.dot(b.flat)) < kParallel) return {};
  return {a.radius, b.radius, ball_a ? b.flat : a.flat, !ball_b};
}

std::optional<RoundImpact> find_round_impact(const Vec3& apart, const Vec3& velocity, double radii, double dt) {
  const double speed2 = velocity.squaredNorm(), closing = -apart.dot(velocity),
               open = apart.squaredNorm() - radii * radii;
  if (!(open > 0.0) || !(closing > 0.0)) return std::nullopt;
  // speed2 t² − 2 closing t + open = 0
  const double root = closing * closing - speed2 * open;
  const double touch = root >= 0.0 ? open / (closing + std::sqrt(root)) : closing / speed2;
  RoundImpact impact;
  impact.time = std::min(touch, dt);
  impact.normal = (apart + impact.time * velocity).normalized();
  impact.gap = impact.normal.dot(apart) - radii;
  return impact;
}

}  // namespace brim
