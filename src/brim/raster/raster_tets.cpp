#include "brim/raster/raster_tets.h"

#include <Eigen/LU>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/math/ramp.h"
#include "brim/raster/triangle_splat.h"

namespace brim {

namespace {

/// Tolerance on barycentric weights, so that no node falls into the rounding gap between two tetrahedra.
constexpr double kEdge = 1e-9;

template <std::size_t N>
Aabb box_of(std::span<const Vec3> x, const std::array<std::int32_t, N>& corners) {
  Aabb box{x[corners[0]], x[corners[0]]};
  for (std::size_t i = 1; i < N; ++i) box.extend(x[corners[i]]);
  return box;
}

/// Names tetrahedron `id` as the holder of the nodes inside it that have none yet.
void claim_nodes(const TetSolid& solid, std::int32_t id, const Vec3& origin, double h, Octants wanted,
                 std::int32_t* holder) {
  const auto& t = solid.tets[id];
  const NodeRange n = nodes_in_box(box_of(solid.x, t), origin, h, wanted);
  if (n.empty()) return;
  const Vec3 x0 = solid.x[t[0]];
  Mat3 edges;
  edges << solid.x[t[1]] - x0, solid.x[t[2]] - x0, solid.x[t[3]] - x0;
  const double det = edges.determinant();
  const double size = edges.cwiseAbs().maxCoeff();
  if (!(std::abs(det) > 1e-14 * size * size * size)) return;
  const Mat3 G = edges.inverse();  // rows: gradients of weights 1 to 3
  const Vec3 base = G * (origin - x0);
  const Mat3 step = h * G;
  for (int k = n.lo[2]; k <= n.hi[2]; ++k)
    for (int j = n.lo[1]; j <= n.hi[1]; ++j) {
      const Vec3 row = base + step.col(1) * j + step.col(2) * k;
      std::int32_t* out = holder + block_index(0, j, k);
      for (int i = n.lo[0]; i <= n.hi[0]; ++i) {
        const double b1 = row[0] + step(0, 0) * i, b2 = row[1] + step(1, 0) * i, b3 = row[2] + step(2, 0) * i;
        const bool inside = b1 >= -kEdge && b2 >= -kEdge && b3 >= -kEdge && b1 + b2 + b3 <= 1.0 + kEdge;
        if (inside && out[i] < 0) out[i] = id;
      }
    }
}

}  // namespace

void raster_tets(const TetSolid& solid, std::span<const TileKey> tiles, double h, double w, std::span<DensityBlock> out,
                 TetRasterWorkspace& workspace) {
  BRIM_CHECK(tiles.size(), ==, out.size());
  const double reach = 0.5 * w;
  workspace.index.build(tiles);
  workspace.tets.build(workspace.index, tiles.size(), h, solid.tets.size(),
                       [&](std::size_t i) { return box_of(solid.x, solid.tets[i]).inflated(1e-9 * h); });
  workspace.surface.build(workspace.index, tiles.size(), h, solid.surface.size(),
                          [&](std::size_t i) { return box_of(solid.x, solid.surface[i]).inflated(reach); });

  parallel_for(tiles.size(), [&](std::size_t t) {
    const Vec3 origin = block_origin(tiles[t], h);
    DensityBlock& block = out[t];
    std::int32_t holder[kBlockNodes];
    // Until the last loop, rho holds the squared distance and source the nearest boundary triangle.
    std::fill_n(block.rho, kBlockNodes, reach * reach);
    std::fill_n(block.source, kBlockNodes, -1);
    std::fill_n(holder, kBlockNodes, -1);
    for (const std::int32_t s : workspace.surface.of(t)) {
      const auto& c = solid.surface[s];
      splat_triangle(solid.x[c[0]], solid.x[c[1]], solid.x[c[2]], s, reach, origin, h, block.octants, block.rho,
                     block.source);
    }
    for (const std::int32_t i : workspace.tets.of(t)) claim_nodes(solid, i, origin, h, block.octants, holder);
    for (int n = 0; n < kBlockNodes; ++n) {
      const bool inside = holder[n] >= 0;
      const std::int32_t nearest = block.source[n];
      if (nearest < 0) {
        block.rho[n] = inside ? 1.0 : 0.0;
        block.source[n] = holder[n];
        continue;
      }
      const double d = std::sqrt(block.rho[n]);
      block.rho[n] = ramp(inside ? -d : d, w);
      block.source[n] = inside ? holder[n] : block.rho[n] > 0.0 ? solid.owner[nearest] : -1;
    }
  });
}

void presence_tets(const TetSolid& solid, double h, double w, const Aabb& region, std::vector<TileKey>& out,
                   TetRasterWorkspace& workspace) {
  // The boundary carries the box of the whole.
  Aabb box;
  for (const auto& s : solid.surface) box.extend(box_of(solid.x, s));
  workspace.cover.begin(box.inflated(0.5 * w).intersection(region), h);
  workspace.cover.add(solid.tets.size(), [&](std::size_t i) { return box_of(solid.x, solid.tets[i]); });
  workspace.cover.add(solid.surface.size(),
                      [&](std::size_t i) { return box_of(solid.x, solid.surface[i]).inflated(0.5 * w); });
  workspace.cover.append_to(out);
}

namespace {

std::array<double, 4> unbounded_weights(const Vec3& r, const std::array<Vec3, 4>& x) {
  Mat3 edges;
  edges << x[1] - x[0], x[2] - x[0], x[3] - x[0];
  const Vec3 b = edges.inverse() * (r - x[0]);
  return {1.0 - b.sum(), b[0], b[1], b[2]};
}

double sum_of_sizes(const std::array<double, 4>& b) {
  return std::abs(b[0]) + std::abs(b[1]) + std::abs(b[2]) + std::abs(b[3]);
}

}  // namespace

double tet_weight_sum(const Vec3& r, const std::array<Vec3, 4>& x) {
  const double sum = sum_of_sizes(unbounded_weights(r, x));
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

std::array<double, 4> tet_weights(const Vec3& r, const std::array<Vec3, 4>& x, double max_weight) {
  const std::array<double, 4> b = unbounded_weights(r, x);
  if (sum_of_sizes(b) <= max_weight) return b;
  // Closest point over the faces, by projected weights clamped to the edges where they leave a face.
  std::array<double, 4> best = {1.0, 0.0, 0.0, 0.0};
  double best_distance = std::numeric_limits<double>::infinity();
  const auto consider = [&](const std::array<double, 4>& weights) {
    Vec3 p = Vec3::Zero();
    for (int i = 0; i < 4; ++i) p += weights[i] * x[i];
    const double d = (p - r).squaredNorm();
    if (d < best_distance) best_distance = d, best = weights;
  };
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      const Vec3 e = x[j] - x[i];
      const double l2 = e.squaredNorm();
      const double t = l2 > 0.0 ? std::clamp((r - x[i]).dot(e) / l2, 0.0, 1.0) : 0.0;
      std::array<double, 4> weights{};
      weights[i] = 1.0 - t;
      weights[j] = t;
      consider(weights);
      for (int k = j + 1; k < 4; ++k) {
        const Vec3 f = x[k] - x[i], m = e.cross(f);
        const double m2 = m.squaredNorm();
        if (!(m2 > 1e-24 * l2 * f.squaredNorm())) continue;
        const double bj = (r - x[i]).cross(f).dot(m) / m2, bk = e.cross(r - x[i]).dot(m) / m2;
        if (bj < 0.0 || bk < 0.0 || bj + bk > 1.0) continue;
        std::array<double, 4> face{};
        face[i] = 1.0 - bj - bk;
        face[j] = bj;
        face[k] = bk;
        consider(face);
      }
    }
  return best;
}

}  // namespace brim
