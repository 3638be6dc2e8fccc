#include "brim/raster/triangle_splat.h"

#include <algorithm>
#include <cmath>

namespace brim {

namespace {

/// Seven numbers of a node that are linear in its place, for one triangle; all in voxels.
enum Line : int { kOff, kAcross, kAlong = kAcross + 3, kLines = kAlong + 3 };
constexpr int kPadded = 8;

/// What the squared distance to one triangle is made of, at the nodes of a block:
///   off       distance to the plane
///   across_i  distance from the line of edge i within the plane, positive outside
///   along_i   place along edge i, from 0 to its length within the edge
/// The foot is inside where no across_i is positive, and the distance is |off|; else it is the least of the edges'.
/// A triangle without area is its longest edge, three times over.
struct TriangleLines {
  alignas(32) float base[kPadded], dx[kPadded], dy[kPadded], dz[kPadded];  ///< at the first node, and from node to node
  float length[3];
};

BRIM_INLINE void set_line(TriangleLines& l, int line, const Vec3& direction, const Vec3& through) {
  l.base[line] = static_cast<float>(-dotted(direction, through));
  l.dx[line] = static_cast<float>(direction[0]);
  l.dy[line] = static_cast<float>(direction[1]);
  l.dz[line] = static_cast<float>(direction[2]);
}

/// @param p  corners in voxels from the first node, in double precision: what is left from here on is small
BRIM_INLINE void set_lines(const Vec3* p, TriangleLines& l) {
  Vec3 edge[3];
  double length[3];
  int longest = 0;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &a = p[i], &b = p[i == 2 ? 0 : i + 1];
    edge[i] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    length[i] = std::sqrt(dotted(edge[i], edge[i]));
    if (length[i] > length[longest]) longest = i;
  }
  const Vec3 m = crossed(edge[0], edge[1]);
  const double m2 = dotted(m, m), l2 = length[longest] * length[longest];
  if (m2 > 1e-24 * l2 * l2) {
    const Vec3 n = times(1.0 / std::sqrt(m2), m);
    set_line(l, kOff, n, p[0]);
    for (int i = 0; i < 3; ++i) {
      const Vec3 t = times(1.0 / length[i], edge[i]);
      set_line(l, kAlong + i, t, p[i]);
      set_line(l, kAcross + i, crossed(t, n), p[i]);
      l.length[i] = static_cast<float>(length[i]);
    }
  } else {
    const Vec3 t = length[longest] > 0.0 ? times(1.0 / length[longest], edge[longest]) : Vec3(1.0, 0.0, 0.0);
    const Vec3 out = t.unitOrthogonal();
    set_line(l, kOff, crossed(t, out), p[longest]);
    for (int i = 0; i < 3; ++i) {
      set_line(l, kAlong + i, t, p[longest]);
      set_line(l, kAcross + i, times(i == 1 ? -1.0 : 1.0, out), p[longest]);  // so that nothing counts as inside
      l.length[i] = static_cast<float>(length[longest]);
    }
  }
  l.base[kLines] = l.dx[kLines] = l.dy[kLines] = l.dz[kLines] = 0.0f;
}

/// The lines' values at the first node of each row (j, k), j from 0 on.
BRIM_INLINE void set_rows(const TriangleLines& l, const NodeRange& n, int k, float (*start)[kPadded]) {
  const WideFloats base = load_wide(l.base) + static_cast<float>(k) * load_wide(l.dz), dy = load_wide(l.dy);
  for (int j = n.lo[1]; j <= n.hi[1]; ++j) store_wide(base + static_cast<float>(j) * dy, start[j]);
}

}  // namespace

BRIM_WIDE void splat_triangles(std::span<const Vec3> x, std::span<const Triangle> triangles,
                               std::span<const std::int32_t> which, std::span<const std::int32_t> name,
                               const SplatReach& reach, const Vec3& origin, double h, Octants wanted,
                               BlockScratch& scratch) {
  const double inverse_h = 1.0 / h;
  const WideFloats zero{}, lanes = lane_numbers();
  const NodeRange clip = wanted_nodes(wanted);
  TriangleLines l;
  alignas(32) float start[kBlockSize][kPadded];
  for (const std::int32_t id : which) {
    const Triangle& t = triangles[id];
    const Vec3 p[3] = {in_voxels(x[t[0]], origin, inverse_h), in_voxels(x[t[1]], origin, inverse_h),
                       in_voxels(x[t[2]], origin, inverse_h)};
    const NodeRange n = nodes_around(p, times(inverse_h, reach.beyond(id)), clip);
    if (n.empty()) continue;
    set_lines(p, l);
    const WideIds called = wide(name.empty() ? id : name[id]);
    const WideFloats length[3] = {wide(l.length[0]), wide(l.length[1]), wide(l.length[2])};
    const RowGroups groups = row_groups(n.lo[0], n.hi[0]);
    for (int g = 0; g < groups.count; ++g) {
      const WideFloats at = lanes + static_cast<float>(groups.start[g]);
      WideFloats steps[kLines];
      for (int i = 0; i < kLines; ++i) steps[i] = at * l.dx[i];
      for (int k = n.lo[2]; k <= n.hi[2]; ++k) {
        set_rows(l, n, k, start);
        for (int j = n.lo[1]; j <= n.hi[1]; ++j) {
          const float* s = start[j];
          const int node = block_index(groups.start[g], j, k);
          const WideFloats kept = load_wide(scratch.value + node);
          const WideFloats off = s[kOff] + steps[kOff], off2 = off * off;
          const WideFloats a0 = s[kAcross] + steps[kAcross], a1 = s[kAcross + 1] + steps[kAcross + 1],
                           a2 = s[kAcross + 2] + steps[kAcross + 2];
          const WideFloats outside = wide_max(wide_max(a0, a1), a2), beyond = wide_max(outside, zero);
          if (!any_lane(off2 + beyond * beyond < kept)) continue;
          const auto edge = [&](int i, const WideFloats& across) BRIM_LAMBDA_INLINE {
            const WideFloats along = s[kAlong + i] + steps[kAlong + i];
            const WideFloats past = along - wide_min(wide_max(along, zero), length[i]);
            return past * past + across * across;
          };
          const WideFloats least = wide_min(wide_min(edge(0, a0), edge(1, a1)), edge(2, a2));
          const WideFloats found = off2 + (outside < 0.0f ? zero : least);
          const WideIds closer = found < kept;
          store_wide(closer ? found : kept, scratch.value + node);
          const WideIds ids = load_wide(scratch.nearest + node);
          store_wide(closer ? called : ids, scratch.nearest + node);
        }
      }
    }
  }
}

}  // namespace brim
