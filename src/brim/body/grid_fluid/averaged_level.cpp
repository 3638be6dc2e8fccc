#include "brim/body/grid_fluid/averaged_level.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "brim/math/ramp.h"

namespace brim {

namespace {

/// [cells] ramp of a cell's own share, and how far from the surface none is asked for.
constexpr double kRamp = 2.5, kSeen = 2.2;
/// [cells²] variance along an axis of the spline, and the mean one of linear interpolation between two cells.
constexpr double kSpline = 1.0 / 3.0, kLinear = 1.0 / 6.0;
/// Of the way from one to the other, for ramps from no width on and up to 3.2 cells.
constexpr double kLeastPart = -1.0, kMostPart = 2.1;
/// [cells] most by which the spline may tell another distance: at edges it does, and far from the surface it tells
/// none.
constexpr double kShift = 0.45;
/// [cells] depth from which on a fluid is no film, and by how much its share may then put its surface further in.
constexpr double kThick = 1.0, kFurther = 0.5;

/// The cubic B-spline at the four cells about a point. @param t  [cells] from the second to the point, [0, 1)
std::array<double, 4> spline(double t) {
  const double u = 1.0 - t;
  return {u * u * u / 6.0, (4.0 - 3.0 * t * t * (1.0 + u)) / 6.0, (4.0 - 3.0 * u * u * (1.0 + t)) / 6.0,
          t * t * t / 6.0};
}

/// ρ̄ of planes across an axis, and its inverse.
class PlaneShare {
 public:
  PlaneShare() {
    for (int s = 0; s <= kSteps; ++s) {
      const double d = distance(s);
      double sum = 0.0;
      for (int p = 0; p < kPlaces; ++p) {
        const double t = (p + 0.5) / kPlaces;
        const std::array<double, 4> weight = spline(t);
        for (int m = 0; m < 4; ++m) sum += weight[static_cast<std::size_t>(m)] * ramp(d + m - 1 - t, kRamp);
      }
      share_[static_cast<std::size_t>(s)] = sum / kPlaces;
    }
  }
  /// [cells]; between the ends of the table.
  double distance_of(double share) const {
    const auto after = std::lower_bound(share_.begin(), share_.end(), share, std::greater<>());
    if (after == share_.begin()) return distance(0);
    if (after == share_.end()) return distance(kSteps);
    const auto s = static_cast<int>(after - share_.begin());
    return distance(s - 1) + (distance(s) - distance(s - 1)) * (after[-1] - share) / (after[-1] - after[0]);
  }

 private:
  static constexpr int kSteps = 256, kPlaces = 64;
  static double distance(int s) { return (2.0 + 0.5 * kRamp) * (2.0 * s / kSteps - 1.0); }
  std::array<double, kSteps + 1> share_;
};

}  // namespace

double boxed_distance(const MacGrid& g, std::span<const double> phi, const Vec3& x) {
  const Aabb box = g.box();
  const double beyond = (box.lo - x).cwiseMax(x - box.hi).maxCoeff();
  return std::max(beyond, sample_cells(g, phi, x));
}

double averaged_distance(const MacGrid& g, std::span<const double> phi, const Vec3& x, double w) {
  static const PlaneShare plane;
  const double rough = boxed_distance(g, phi, x);
  if (std::abs(rough) > kSeen * g.dx) return rough;
  const Vec3 s = (x - g.origin) / g.dx - Vec3::Constant(0.5);
  std::array<std::array<double, 4>, 3> weight, beyond;
  std::array<std::array<int, 4>, 3> cell;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    const auto low = static_cast<int>(std::floor(s[axis]));
    weight[a] = spline(s[axis] - low);
    for (int m = 0; m < 4; ++m) {
      const int c = low - 1 + m;
      beyond[a][static_cast<std::size_t>(m)] = std::max(-0.5 - c, c + 0.5 - g.n[axis]);
      cell[a][static_cast<std::size_t>(m)] = std::clamp(c, 0, g.n[axis] - 1);
    }
  }
  double share = 0.0, deepest = 0.0;
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t j = 0; j < 4; ++j) {
      const double out = std::max(beyond[1][j], beyond[2][k]);
      double row = 0.0;
      for (std::size_t i = 0; i < 4; ++i) {
        const double d = phi[g.cell(cell[0][i], cell[1][j], cell[2][k])] / g.dx;
        deepest = std::min(deepest, d);
        row += weight[0][i] * ramp(std::max({d, out, beyond[0][i]}), kRamp);
      }
      share += weight[1][j] * weight[2][k] * row;
    }
  const double ball = w * w / (20.0 * g.dx * g.dx);
  const double part = std::clamp((ball - kLinear) / (kSpline - kLinear), kLeastPart, kMostPart);
  const double shift = std::clamp(plane.distance_of(share) - rough / g.dx, -kShift, kShift);
  const double mean = rough + part * shift * g.dx;
  const double further = std::clamp(-deepest - kThick, 0.0, kFurther);
  return std::min(mean, rough + further * g.dx);
}

}  // namespace brim
