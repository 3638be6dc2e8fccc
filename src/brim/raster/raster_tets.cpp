#include "brim/raster/raster_tets.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/raster/block_rows.h"
#include "brim/raster/triangle_splat.h"

namespace brim {

namespace {

/// A node this far outside of a tetrahedron, in voxels, still counts as inside, so that none falls into the rounding
/// gap between two of them. Where that is wrong, its distance is too by twice as much.
constexpr double kEdge = 1e-5;

template <std::size_t N>
Aabb box_of(std::span<const Vec3> x, const std::array<std::int32_t, N>& corners) {
  Aabb box{x[corners[0]], x[corners[0]]};
  for (std::size_t i = 1; i < N; ++i) box.extend(x[corners[i]]);
  return box;
}

Aabb grown(const Aabb& box, const Vec3& by) { return {box.lo - by, box.hi + by}; }

/// A tetrahedron that may hold nodes of a block.
struct Claim {
  std::int32_t id;
  NodeRange nodes;
};

/// Barycentric weights of kLanes tetrahedra at the nodes of a block: weight i of tetrahedron l is
/// base[l][i] + x dx[l][i] + y dy[l][i] + z dz[l][i], a little more than it is so that no node is lost between two.
struct ClaimWeights {
  alignas(32) float base[kLanes][4], dx[kLanes][4], dy[kLanes][4], dz[kLanes][4];
};

BRIM_INLINE Lanes size_of(const Lanes& x) { return x < 0.0 ? -x : x; }

/// Writes rows of four tetrahedra as rows of four weights.
BRIM_INLINE void store_transposed(const Lanes* weight, float (*out)[4]) {
  FloatLanes r[4];
  for (int i = 0; i < 4; ++i) r[i] = __builtin_convertvector(weight[i], FloatLanes);
  const FloatLanes a = __builtin_shufflevector(r[0], r[1], 0, 4, 1, 5),
                   b = __builtin_shufflevector(r[0], r[1], 2, 6, 3, 7),
                   c = __builtin_shufflevector(r[2], r[3], 0, 4, 1, 5),
                   d = __builtin_shufflevector(r[2], r[3], 2, 6, 3, 7);
  store_lanes(out[0], __builtin_shufflevector(a, c, 0, 1, 4, 5));
  store_lanes(out[1], __builtin_shufflevector(a, c, 2, 3, 6, 7));
  store_lanes(out[2], __builtin_shufflevector(b, d, 0, 1, 4, 5));
  store_lanes(out[3], __builtin_shufflevector(b, d, 2, 3, 6, 7));
}

/// @param corner  [voxels from the first node] corner i, axis a of tetrahedron l at [3 i + a][l]
BRIM_INLINE void set_weights(const double (*corner)[kLanes], ClaimWeights& w) {
  Lanes p[3], e[3][3], size{};
  for (int a = 0; a < 3; ++a) {
    p[a] = load_lanes(corner[a]);
    for (int i = 0; i < 3; ++i) {
      e[i][a] = load_lanes(corner[3 * (i + 1) + a]) - p[a];
      const Lanes s = size_of(e[i][a]);
      size = s > size ? s : size;
    }
  }
  // Gradients of the weights: cross products of edges over the volume.
  Lanes g[4][3];
  for (int i = 0; i < 3; ++i) {
    const Lanes *u = e[(i + 1) % 3], *v = e[(i + 2) % 3];
    for (int a = 0; a < 3; ++a) g[i + 1][a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
  }
  const Lanes det = e[0][0] * g[1][0] + e[0][1] * g[1][1] + e[0][2] * g[1][2];
  const LaneFlags solid = size_of(det) > 1e-14 * size * size * size;
  const Lanes inverse = 1.0 / (solid ? det : Lanes{} + 1.0);
  Lanes base[4];
  for (int a = 0; a < 3; ++a) {
    for (int i = 1; i < 4; ++i) g[i][a] *= inverse;
    g[0][a] = -(g[1][a] + g[2][a] + g[3][a]);
  }
  for (int i = 0; i < 4; ++i) {
    base[i] = (i == 0 ? 1.0 : 0.0) - (g[i][0] * p[0] + g[i][1] * p[1] + g[i][2] * p[2]) +
              kEdge * (size_of(g[i][0]) + size_of(g[i][1]) + size_of(g[i][2]));
    // What has no volume, or no place, holds nothing.
    base[i] = solid ? base[i] : Lanes{} - 1.0;
    for (int a = 0; a < 3; ++a) g[i][a] = solid ? g[i][a] : Lanes{};
  }
  store_transposed(base, w.base);
  const auto store_axis = [&](int a, float(*out)[4]) BRIM_LAMBDA_INLINE {
    const Lanes along[4] = {g[0][a], g[1][a], g[2][a], g[3][a]};
    store_transposed(along, out);
  };
  store_axis(0, w.dx), store_axis(1, w.dy), store_axis(2, w.dz);
}

/// Names a tetrahedron as the holder of the nodes inside it that have none yet: all its weights must be positive.
BRIM_INLINE void claim(const Claim& c, const ClaimWeights& w, int l, std::int32_t* holder) {
  const FloatLanes base = load_lanes(w.base[l]), dy = load_lanes(w.dy[l]), dz = load_lanes(w.dz[l]);
  const float* dx = w.dx[l];
  const NodeRange& n = c.nodes;
  const RowGroups groups = row_groups(n.lo[0], n.hi[0]);
  for (int s = 0; s < groups.count; ++s) {
    const WideFloats at = lane_numbers() + static_cast<float>(groups.start[s]);
    const WideFloats s0 = at * dx[0], s1 = at * dx[1], s2 = at * dx[2], s3 = at * dx[3];
    for (int k = n.lo[2]; k <= n.hi[2]; ++k)
      for (int j = n.lo[1]; j <= n.hi[1]; ++j) {
        const FloatLanes row = base + static_cast<float>(j) * dy + static_cast<float>(k) * dz;
        const WideFloats least = wide_min(wide_min(row[0] + s0, row[1] + s1), wide_min(row[2] + s2, row[3] + s3));
        std::int32_t* const out = holder + block_index(groups.start[s], j, k);
        const WideIds held = load_wide(out);
        store_wide((least >= 0.0f) & (held < 0) ? wide(c.id) : held, out);
      }
  }
}

/// Finds the holders of the nodes of a block: of each the first tetrahedron in which it is. Weights are prepared for
/// kLanes tetrahedra at a time, in double precision, and taken at eight nodes at a time in single.
BRIM_WIDE void claim_nodes(const TetSolid& solid, const VertexNodes& nodes, std::span<const std::int32_t> which,
                           const TileKey& tile, double h, Octants wanted, std::int32_t* holder) {
  const double inverse_h = 1.0 / h;
  const Vec3 origin = block_origin(tile, h);
  const std::int32_t first[3] = {kTileSize * tile.x - kHalo, kTileSize * tile.y - kHalo, kTileSize * tile.z - kHalo};
  const NodeRange clip = wanted_nodes(wanted);
  alignas(32) double corner[12][kLanes] = {};
  Claim pending[kLanes];
  ClaimWeights weights;
  int count = 0;
  const auto flush = [&]() BRIM_LAMBDA_INLINE {
    set_weights(corner, weights);
    for (int l = 0; l < count; ++l) claim(pending[l], weights, l, holder);
    count = 0;
  };
  for (const std::int32_t id : which) {
    const auto& t = solid.tets[id];
    Claim& c = pending[count];
    c.id = id;
    const NodeSpan span = nodes.around(t);
    for (int a = 0; a < 3; ++a) {
      c.nodes.lo[a] = std::max(clip.lo[a], span.lo[a] - first[a]);
      c.nodes.hi[a] = std::min(clip.hi[a], span.hi[a] - first[a]);
    }
    if (c.nodes.empty()) continue;
    for (int i = 0; i < 4; ++i) {
      const Vec3& x = solid.x[t[i]];
      for (int a = 0; a < 3; ++a) corner[3 * i + a][count] = (x[a] - origin[a]) * inverse_h;
    }
    if (++count == kLanes) flush();
  }
  if (count > 0) flush();
}

/// Densities and sources from the distances and holders.
BRIM_WIDE void settle_solid(const BlockScratch& scratch, double h, double w, DensityBlock& block) {
  const float inverse_w = static_cast<float>(h / w);
  for_wanted_groups(block.octants, [&](int group) BRIM_LAMBDA_INLINE {
    const WideIds nearest = load_wide(scratch.nearest + group), holder = load_wide(scratch.holder + group);
    const WideFloats d = wide_root(load_wide(scratch.value + group));
    const WideIds inside = holder >= 0;
    const WideFloats near = wide_ramp(inside ? -d : d, inverse_w);
    const WideFloats rho = nearest < 0 ? (inside ? wide(1.0f) : wide(0.0f)) : near;
    store_group(rho, inside ? holder : (rho > 0.0f ? nearest : wide(-1)), group, block);
  });
}

/// The nodes that all wanted octants span with their rings.
NodeSpan nodes_wanted(std::span<const TileKey> tiles, std::span<const DensityBlock> blocks) {
  constexpr auto n = static_cast<std::int32_t>(kFarthestNode);
  NodeSpan s{{n, n, n}, {-n, -n, -n}};
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const NodeRange r = wanted_nodes(blocks[t].octants);
    const std::int32_t tile[3] = {tiles[t].x, tiles[t].y, tiles[t].z};
    for (int a = 0; a < 3; ++a) {
      const std::int32_t first = kTileSize * tile[a] - kHalo;
      s.lo[a] = std::min(s.lo[a], first + r.lo[a]), s.hi[a] = std::max(s.hi[a], first + r.hi[a]);
    }
  }
  return s;
}

auto tet_boxes(const TetSolid& solid, const VertexNodes& nodes) {
  return BoxList{solid.tets.size(), [&](std::size_t i) { return nodes.around(solid.tets[i]); },
                 [&](std::size_t g) {
                   return solid.groups == nullptr ? NodeSpan::all() : solid.groups->tets.around(nodes, g, 0);
                 }};
}

/// @param reach  [voxels] of the boxes beyond their triangles, at most
template <class BoxOf>
auto surface_boxes(const TetSolid& solid, const VertexNodes& nodes, double reach, const BoxOf& box_of) {
  const std::int32_t more = node_above(reach) + 1;
  return BoxList{solid.surface.size(), box_of, [&solid, &nodes, more](std::size_t g) {
                   return solid.groups == nullptr ? NodeSpan::all() : solid.groups->surface.around(nodes, g, more);
                 }};
}

}  // namespace

void raster_tets(const TetSolid& solid, std::span<const TileKey> tiles, double h, double w, std::span<DensityBlock> out,
                 TetRasterWorkspace& workspace) {
  BRIM_CHECK(tiles.size(), ==, out.size());
  const double reach = 0.5 * w;
  workspace.index.build(tiles);
  workspace.reach.build(solid.x, solid.surface, reach);
  workspace.nodes.build(solid.x, h, kEdge);
  const NodeSpan wanted = nodes_wanted(tiles, out);
  workspace.tets.build(workspace.index, tiles.size(), h, tet_boxes(solid, workspace.nodes), wanted);
  workspace.surface.build(
      workspace.index, tiles.size(), h,
      surface_boxes(solid, workspace.nodes, reach / h,
                    [&](std::size_t i) { return grown(box_of(solid.x, solid.surface[i]), workspace.reach.beyond(i)); }),
      wanted);
  const float far2 = static_cast<float>(reach * reach / (h * h));
  parallel_for(tiles.size(), [&](std::size_t t) {
    const Vec3 origin = block_origin(tiles[t], h);
    BlockScratch scratch;
    std::fill_n(scratch.value, kBlockNodes, far2);
    std::fill_n(scratch.nearest, kBlockNodes, -1);
    std::fill_n(scratch.holder, kBlockNodes, -1);
    splat_triangles(solid.x, solid.surface, workspace.surface.of(t), solid.owner, workspace.reach, origin, h,
                    out[t].octants, scratch);
    claim_nodes(solid, workspace.nodes, workspace.tets.of(t), tiles[t], h, out[t].octants, scratch.holder);
    settle_solid(scratch, h, w, out[t]);
  });
}

namespace {

template <class Tile>
void cover_tets(const TetSolid& solid, double h, double w, const Aabb& region, std::vector<Tile>& out,
                TetRasterWorkspace& workspace) {
  // The boundary carries the box of the whole.
  Aabb box;
  for (const auto& s : solid.surface) box.extend(box_of(solid.x, s));
  workspace.nodes.build(solid.x, h, kEdge);
  workspace.cover.cover(box.inflated(0.5 * w).intersection(region), h, out, tet_boxes(solid, workspace.nodes),
                        surface_boxes(solid, workspace.nodes, 0.5 * w / h, [&](std::size_t i) {
                          return box_of(solid.x, solid.surface[i]).inflated(0.5 * w);
                        }));
}

}  // namespace

void presence_tets(const TetSolid& solid, double h, double w, const Aabb& region, std::vector<TileKey>& out,
                   TetRasterWorkspace& workspace) {
  cover_tets(solid, h, w, region, out, workspace);
}

void presence_tets(const TetSolid& solid, double h, double w, const Aabb& region, std::vector<OctantTile>& out,
                   TetRasterWorkspace& workspace) {
  cover_tets(solid, h, w, region, out, workspace);
}

double tet_weight_sum(const Vec3& r, const std::array<Vec3, 4>& x) {
  const double sum = sum_of_sizes(linear_weights(r, x));
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

std::array<double, 4> tet_weights(const Vec3& r, const std::array<Vec3, 4>& x, double max_weight) {
  const std::array<double, 4> b = linear_weights(r, x);
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
