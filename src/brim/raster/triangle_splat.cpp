#include "brim/raster/triangle_splat.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "brim/core/wide.h"
#include "brim/grid/tile.h"
#include "brim/raster/tile_bins.h"

namespace brim {

namespace {

/// Squared distance to one triangle in its own plane frame: cheap to evaluate at many nodes, kLanes at a time.
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

  /// Lowers kLanes squared distances and sets their nearest triangles where this one is closer.
  /// @param u, v, n  local coordinates of the points
  BRIM_INLINE void keep_nearest(const Lanes& u, const Lanes& v, const Lanes& n, std::int32_t id, double* distance2,
                                std::int32_t* nearest) const {
    const Lanes zero = Lanes{}, one = zero + 1.0;
    Lanes kept;
    std::memcpy(&kept, distance2, sizeof kept);
    // The box around the triangle in its plane turns most points away before the edges are looked at.
    const Lanes below = low_ - u, above = u - high_, before = -v, behind = v - cy_;
    Lanes du = below > above ? below : above, dv = before > behind ? before : behind;
    du = du > zero ? du : zero, dv = dv > zero ? dv : zero;
    const LaneFlags near = n * n + du * du + dv * dv < kept;
    if (((near[0] | near[1]) | (near[2] | near[3])) == 0) return;
    const auto clamped = [&](const Lanes& x) { return x < zero ? zero : (x > one ? one : x); };
    const Lanes tab = clamped(u * (bx_ * ab2_)), xab = u - tab * bx_;
    const Lanes tac = clamped((u * cx_ + v * cy_) * ac2_), xac = u - tac * cx_, yac = v - tac * cy_;
    const Lanes ub = u - bx_;
    const Lanes tbc = clamped((ub * (cx_ - bx_) + v * cy_) * bc2_), xbc = ub - tbc * (cx_ - bx_), ybc = v - tbc * cy_;
    const Lanes dab = xab * xab + v * v, dac = xac * xac + yac * yac, dbc = xbc * xbc + ybc * ybc;
    Lanes least = dab < dac ? dab : dac;
    least = dbc < least ? dbc : least;
    if (!flat_) {
      const Lanes fbc = cy_ * (bx_ - u) + (cx_ - bx_) * v, fca = cy_ * u - cx_ * v;
      least = ((v >= zero) & (fbc >= zero) & (fca >= zero)) ? zero : least;
    }
    const Lanes found = n * n + least;
    const LaneFlags closer = found < kept;
    kept = closer ? found : kept;
    std::memcpy(distance2, &kept, sizeof kept);
    LaneIds ids;
    std::memcpy(&ids, nearest, sizeof ids);
    ids = __builtin_convertvector(closer, LaneIds) ? id - LaneIds{} : ids;
    std::memcpy(nearest, &ids, sizeof ids);
  }

 private:
  static double inverse(double x) { return x > 0.0 ? 1.0 / x : 0.0; }

  Vec3 a_, eu_, ev_, n_;
  double bx_, cx_, cy_, low_, high_, ab2_, ac2_, bc2_;
  bool flat_;
};

}  // namespace

BRIM_WIDE void splat_triangle(const Vec3& a, const Vec3& b, const Vec3& c, std::int32_t id, double reach,
                              const Vec3& origin, double h, Octants wanted, double* distance2, std::int32_t* nearest) {
  const Aabb box = Aabb{a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)}.inflated(reach);
  const NodeRange n = nodes_in_box(box, origin, h, wanted);
  if (n.empty()) return;
  const TriangleDistance triangle(a, b, c);
  const Vec3 corner = triangle.local(origin), dx = triangle.direction(h * Vec3::UnitX());
  const Vec3 dy = triangle.direction(h * Vec3::UnitY()), dz = triangle.direction(h * Vec3::UnitZ());
  const Lanes steps = {0.0, 1.0, 2.0, 3.0};
  for (int k = n.lo[2]; k <= n.hi[2]; ++k)
    for (int j = n.lo[1]; j <= n.hi[1]; ++j) {
      const Vec3 start = corner + double(j) * dy + double(k) * dz;
      // Whole groups of nodes within the row; what lies beyond the box is out of reach and changes nothing.
      for (int i = std::min(n.lo[0], kBlockSize - kLanes); i <= n.hi[0]; i += kLanes) {
        i = std::min(i, kBlockSize - kLanes);
        const Lanes at = steps + double(i);
        const int node = block_index(i, j, k);
        triangle.keep_nearest(start[0] + at * dx[0], start[1] + at * dx[1], start[2] + at * dx[2], id, distance2 + node,
                              nearest + node);
        if (i == kBlockSize - kLanes) break;
      }
    }
}

}  // namespace brim
