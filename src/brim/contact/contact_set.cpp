#include "brim/contact/contact_set.h"

#include "brim/contact/stencil.h"
#include "brim/core/parallel.h"
#include "brim/math/ramp.h"

namespace brim {

void ContactSet::resize(std::size_t n) {
  node.resize(n), point.resize(n), overlap.resize(n), depth.resize(n);
  gradient_a.resize(n), gradient_b.resize(n);
  curvature_a.resize(n), curvature_b.resize(n);
  source_a.resize(n), source_b.resize(n);
}

namespace {

/// Calls f(block offset, i, j, k) for every own node where the parts overlap, or nearly do on both their slopes.
template <class F>
void for_overlaps(const PairTile& t, double margin, const F& f) {
  for (int k = kHalo; k < kHalo + kTileSize; ++k)
    for (int j = kHalo; j < kHalo + kTileSize; ++j) {
      const int row = block_index(0, j, k);
      for (int i = kHalo; i < kHalo + kTileSize; ++i) {
        const double a = t.a->rho[row + i], b = t.b->rho[row + i];
        if (a + b <= 1.0 - margin) continue;
        if (a + b > 1.0 || (a > 0.0 && a < 1.0 && b > 0.0 && b < 1.0)) f(row + i, i, j, k);
      }
    }
}

/// T H T with T the projection across the gradient; zero where there is no gradient.
Mat3 tangential(const Mat3& H, const Vec3& g) {
  const double n2 = g.squaredNorm();
  if (!(n2 > 0.0)) return Mat3::Zero();
  const Mat3 T = Mat3::Identity() - g * g.transpose() / n2;
  return T * H * T;
}

/// True when neither part has a slope at the node: its neighbours are all full (or the node is isolated in full
/// matter).
bool flat(const DensityBlock& b, int node) {
  return b.rho[node] >= 1.0 && b.rho[node - 1] >= 1.0 && b.rho[node + 1] >= 1.0 && b.rho[node - kBlockSize] >= 1.0 &&
         b.rho[node + kBlockSize] >= 1.0 && b.rho[node - kBlockSize * kBlockSize] >= 1.0 &&
         b.rho[node + kBlockSize * kBlockSize] >= 1.0;
}

}  // namespace

void detect(std::span<const PairTile> tiles, ContactSet& set) {
  // Count, so that every tile knows where to write.
  std::vector<std::size_t> first(tiles.size() + 1, 0);
  std::vector<std::int64_t> engulfed(tiles.size(), 0);
  parallel_for(tiles.size(), [&](std::size_t t) {
    std::size_t n = 0;
    for_overlaps(tiles[t], set.pairs[tiles[t].pair].margin, [&](int node, int, int, int) {
      if (flat(*tiles[t].a, node) && flat(*tiles[t].b, node))
        ++engulfed[t];
      else
        ++n;
    });
    first[t + 1] = n;
  });
  set.engulfed = 0;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    first[t + 1] += first[t];
    set.engulfed += engulfed[t];
  }
  set.resize(first.back());
  for (ContactPair& p : set.pairs) p.begin = p.end = 0;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    ContactPair& p = set.pairs[tiles[t].pair];
    if (p.end == 0 && p.begin == 0) p.begin = p.end = first[t];
    p.end = first[t + 1];
  }

  parallel_for(tiles.size(), [&](std::size_t t) {
    const PairTile& tile = tiles[t];
    const ContactPair& pair = set.pairs[tile.pair];
    const double h = pair.h;
    const Vec3 origin = block_origin(tile.tile, h);
    std::size_t c = first[t];
    for_overlaps(tile, pair.margin, [&](int node, int i, int j, int k) {
      if (flat(*tile.a, node) && flat(*tile.b, node)) return;
      const Vec3 x = origin + h * Vec3(i, j, k);
      Vec3 ga, gb;
      Mat3 Ha, Hb;
      density_derivatives(tile.a->rho, node, h, ga, Ha);
      density_derivatives(tile.b->rho, node, h, gb, Hb);
      const double ra = tile.a->rho[node], rb = tile.b->rho[node];
      const Vec3 g = ga - gb;
      const double length = g.norm();
      // Along the common normal the distances to both surfaces are known from the densities; meet half-way.
      const double da = ramp_inverse(ra, pair.w), db = ramp_inverse(rb, pair.w);
      const double shift = 0.5 * (da - db);
      set.node[c] = x;
      set.point[c] = length > 0.0 ? Vec3(x + (shift / length) * g) : x;
      set.overlap[c] = ra + rb - 1.0;
      set.depth[c] = -(da + db);
      set.gradient_a[c] = ga;
      set.gradient_b[c] = gb;
      set.curvature_a[c] = tangential(Ha, ga);
      set.curvature_b[c] = tangential(Hb, gb);
      set.source_a[c] = tile.a->source[node];
      set.source_b[c] = tile.b->source[node];
      ++c;
    });
  });
}

}  // namespace brim
