#pragma once

#include <algorithm>
#include <cmath>

#include "brim/grid/tile.h"
#include "brim/raster/tile_bins.h"

namespace brim {

/// Squared distance to one triangle in its own plane frame: cheap to evaluate at many nodes.
/// The corners are turned so that the longest edge comes first; a triangle without area is its longest edge.
class TriangleDistance {
 public:
  TriangleDistance(const Vec3& p0, const Vec3& p1, const Vec3& p2) {
    const Vec3* p[3] = {&p0, &p1, &p2};
    int s = 0;
    double longest = -1.0;
    for (int i = 0; i < 3; ++i) {
      const double l = (*p[(i + 1) % 3] - *p[i]).squaredNorm();
      if (l > longest) longest = l, s = i;
    }
    a_ = *p[s];
    const Vec3 ab = *p[(s + 1) % 3] - a_, ac = *p[(s + 2) % 3] - a_;
    bx_ = std::sqrt(longest);
    eu_ = bx_ > 0.0 ? Vec3(ab / bx_) : Vec3::UnitX();
    cx_ = ac.dot(eu_);
    const Vec3 up = ac - cx_ * eu_;
    cy_ = up.norm();
    flat_ = !(cy_ > 1e-12 * bx_);
    if (flat_) {
      cy_ = 0.0;
      ev_ = eu_.unitOrthogonal();
    } else {
      ev_ = up / cy_;
    }
    n_ = eu_.cross(ev_);
    low_ = std::min(cx_, 0.0);
    high_ = std::max(cx_, bx_);
    ab2_ = inverse(bx_ * bx_);
    ac2_ = inverse(cx_ * cx_ + cy_ * cy_);
    bc2_ = inverse((cx_ - bx_) * (cx_ - bx_) + cy_ * cy_);
  }

  /// Coordinates in the triangle's frame: along its longest edge, across it, and off the plane.
  Vec3 local(const Vec3& r) const { return direction(r - a_); }
  Vec3 direction(const Vec3& d) const { return {eu_.dot(d), ev_.dot(d), n_.dot(d)}; }

  /// Narrows lo..hi to the i for which start + i step (local coordinates) may be within reach of the triangle.
  /// @param inverse_step  1 / step, or 0 where the step is too small to matter
  void clip_row(const Vec3& start, const Vec3& inverse_step, double reach, int& lo, int& hi) const {
    const double low[3] = {low_ - reach, -reach, -reach}, high[3] = {high_ + reach, cy_ + reach, reach};
    double first = lo, last = hi;
    for (int a = 0; a < 3; ++a) {
      if (inverse_step[a] == 0.0) {
        if (start[a] < low[a] - 1e-6 * reach || start[a] > high[a] + 1e-6 * reach) last = -1.0;
        continue;
      }
      const double p = (low[a] - start[a]) * inverse_step[a], q = (high[a] - start[a]) * inverse_step[a];
      first = std::max(first, std::min(p, q));
      last = std::min(last, std::max(p, q));
    }
    // Half a node of tolerance costs little and forgives rounding.
    lo = static_cast<int>(std::min(first + 0.5, double{kBlockSize}));
    hi = last < 0.0 ? (last < -0.5 ? -1 : 0) : static_cast<int>(last + 0.5);
  }

  /// Squared distance if it is less than `bound`, otherwise any number not less than `bound`.
  /// @param p  local coordinates
  double squared_distance(const Vec3& p, double bound) const {
    const double u = p[0], v = p[1], z2 = p[2] * p[2];
    if (!(z2 < bound)) return bound;
    // The box around the triangle in its plane turns most nodes away before the edges are looked at.
    const double du = std::max({low_ - u, u - high_, 0.0}), dv = std::max({-v, v - cy_, 0.0});
    if (!(z2 + du * du + dv * dv < bound)) return bound;
    const double fab = v, fbc = cy_ * (bx_ - u) + (cx_ - bx_) * v, fca = cy_ * u - cx_ * v;
    if (!flat_ && fab >= 0.0 && fbc >= 0.0 && fca >= 0.0) return z2;
    const double tab = std::clamp(u * bx_ * ab2_, 0.0, 1.0), xab = u - tab * bx_;
    const double tac = std::clamp((u * cx_ + v * cy_) * ac2_, 0.0, 1.0), xac = u - tac * cx_, yac = v - tac * cy_;
    const double tbc = std::clamp(((u - bx_) * (cx_ - bx_) + v * cy_) * bc2_, 0.0, 1.0);
    const double xbc = u - bx_ - tbc * (cx_ - bx_), ybc = v - tbc * cy_;
    return z2 + std::min({xab * xab + v * v, xac * xac + yac * yac, xbc * xbc + ybc * ybc});
  }

 private:
  static double inverse(double x) { return x > 0.0 ? 1.0 / x : 0.0; }

  Vec3 a_, eu_, ev_, n_;
  double bx_, cx_, cy_, low_, high_, ab2_, ac2_, bc2_;
  bool flat_;
};

/// Nearest triangle of each node of a block: lowers distance2 and sets nearest where a triangle comes closer than
/// what is there; of equals the first stays.
/// @param reach  [m]  triangles farther than this from a node need not be looked at
inline void splat_triangle(const Vec3& a, const Vec3& b, const Vec3& c, std::int32_t id, double reach,
                           const Vec3& origin, double h, double* distance2, std::int32_t* nearest) {
  const Aabb box = Aabb{a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)}.inflated(reach);
  const NodeRange n = nodes_in_box(box, origin, h);
  if (n.empty()) return;
  const TriangleDistance triangle(a, b, c);
  const Vec3 corner = triangle.local(origin), dx = triangle.direction(h * Vec3::UnitX());
  const Vec3 dy = triangle.direction(h * Vec3::UnitY()), dz = triangle.direction(h * Vec3::UnitZ());
  Vec3 inverse_dx = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(dx[axis]) * kBlockSize > 1e-6 * reach) inverse_dx[axis] = 1.0 / dx[axis];
  for (int k = n.lo[2]; k <= n.hi[2]; ++k)
    for (int j = n.lo[1]; j <= n.hi[1]; ++j) {
      const Vec3 start = corner + double(j) * dy + double(k) * dz;
      int lo = n.lo[0], hi = n.hi[0];
      triangle.clip_row(start, inverse_dx, reach, lo, hi);
      const int row = block_index(0, j, k);
      for (int i = lo; i <= hi; ++i) {
        const double d2 = triangle.squared_distance(start + double(i) * dx, distance2[row + i]);
        if (d2 < distance2[row + i]) {
          distance2[row + i] = d2;
          nearest[row + i] = id;
        }
      }
    }
}

}  // namespace brim
