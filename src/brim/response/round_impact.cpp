#include "brim/response/round_impact.h"

#include <algorithm>
#include <cmath>

namespace brim {

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
