#include <algorithm>
#include <cmath>
#include <limits>

#include "brim/core/error.h"
#include "brim/mesh/topology.h"

namespace brim {

namespace {

constexpr std::size_t kMaxTriangles = 20'000'000;

// Cuts one triangle whose middle points m (of sides 01, 12, 20; −1 where the side stays) are given.
void cut(const std::vector<Vec3>& x, const Triangle& t, const std::array<std::int32_t, 3>& m,
         std::vector<Triangle>& out) {
  const int count = (m[0] >= 0) + (m[1] >= 0) + (m[2] >= 0);
  if (count == 0) {
    out.push_back(t);
    return;
  }
  if (count == 3) {
    out.insert(out.end(), {{t[0], m[0], m[2]}, {t[1], m[1], m[0]}, {t[2], m[2], m[1]}, {m[0], m[1], m[2]}});
    return;
  }
  // Turn the triangle so that side 0 is cut, and with two cuts sides 0 and 1.
  int k = 0;
  while (!(m[k] >= 0 && (count == 1 || m[(k + 1) % 3] >= 0))) ++k;
  const std::int32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3], ab = m[k], bc = m[(k + 1) % 3];
  if (count == 1) {
    out.insert(out.end(), {{a, ab, c}, {ab, b, c}});
    return;
  }
  out.push_back({ab, b, bc});
  // The rest is the quad a, ab, bc, c: cut along its shorter diagonal.
  if ((x[a] - x[bc]).squaredNorm() <= (x[ab] - x[c]).squaredNorm()) {
    out.insert(out.end(), {{a, ab, bc}, {a, bc, c}});
  } else {
    out.insert(out.end(), {{a, ab, c}, {ab, bc, c}});
  }
}

}  // namespace

TriMesh refine(const TriMesh& mesh, double max_edge) {
  if (!(max_edge > 0.0) || !std::isfinite(max_edge))
    throw InputError(fmt::format("refine: max_edge is {} m; it must be positive and finite", max_edge));
  TriMesh r = mesh;
  const double limit2 = max_edge * max_edge * (1.0 + 1e-12);
  while (true) {
    std::vector<Edge> all = edges(r.triangles);
    std::vector<std::int32_t> middle(all.size(), -1);
    bool any = false;
    for (std::size_t e = 0; e < all.size(); ++e) {
      const Vec3 &a = r.vertices[all[e][0]], &b = r.vertices[all[e][1]];
      if ((a - b).squaredNorm() <= limit2) continue;
      any = true;
      middle[e] = static_cast<std::int32_t>(r.vertices.size());
      const Vec3 m = 0.5 * (a + b);
      r.vertices.push_back(m);
    }
    if (!any) return r;
    const auto find = [&](std::int32_t a, std::int32_t b) {
      const Edge key = {std::min(a, b), std::max(a, b)};
      return middle[static_cast<std::size_t>(std::lower_bound(all.begin(), all.end(), key) - all.begin())];
    };
    std::vector<Triangle> fine;
    fine.reserve(2 * r.triangles.size());
    for (const Triangle& t : r.triangles)
      cut(r.vertices, t, {find(t[0], t[1]), find(t[1], t[2]), find(t[2], t[0])}, fine);
    if (fine.size() > kMaxTriangles)
      throw InputError(fmt::format("refine: max_edge {} m would give more than {} triangles", max_edge, kMaxTriangles));
    r.triangles = std::move(fine);
  }
}

}  // namespace brim
