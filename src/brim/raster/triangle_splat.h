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
    ab2_ = inverse(bx_ * bx_);
    ac2_ = inverse(cx_ * cx_ + cy_ * cy_);
    bc2_ = inverse((cx_ - bx_) * (cx_ - bx_) + cy_ * cy_);
  }

  /// Squared distance if it is less than `bound`, otherwise any number not less than `bound`.
  double squared_distance(const Vec3& r, double bound) const {
    const Vec3 d = r - a_;
    const double z = n_.dot(d), z2 = z * z;
    if (!(z2 < bound)) return bound;
    const double u = eu_.dot(d), v = ev_.dot(d);
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
  double bx_, cx_, cy_, ab2_, ac2_, bc2_;
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
  for (int k = n.lo[2]; k <= n.hi[2]; ++k)
    for (int j = n.lo[1]; j <= n.hi[1]; ++j) {
      const int row = block_index(0, j, k);
      for (int i = n.lo[0]; i <= n.hi[0]; ++i) {
        const double d2 = triangle.squared_distance(origin + h * Vec3(i, j, k), distance2[row + i]);
        if (d2 < distance2[row + i]) {
          distance2[row + i] = d2;
          nearest[row + i] = id;
        }
      }
    }
}

}  // namespace brim
