#include "brim/world/solid_shares.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "brim/body/posed_shape.h"
#include "brim/body/solid_of.h"
#include "brim/body/spinning_balls.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/math/ramp.h"
#include "brim/raster/trilinear.h"

namespace brim {

namespace {

/// [eighths] thickness that is sampled without dividing them, and their most pieces along an axis.
constexpr double kThick = 3.0;
constexpr int kMostPieces = 8;

/// Pieces along each axis in which the eighths of cells of size dx are sampled.
int pieces_of(double thickness, double dx) {
  int m = 1;
  while (m < kMostPieces && m * thickness < kThick * 0.5 * dx) m *= 2;
  return m;
}

/// Side of the cube with the volume of a ball, over its radius.
constexpr double kCube = 1.6119919540164696;

/// Calls f(eighth, share) for the eighths of side h that a ball takes, up to scale: by the distance of their middles
/// from its surface, or as a cube of its volume if it is smaller than one.
/// @param c  [h] centre from the low corner of the grid  @param r  [h]
template <class F>
void for_eighths_of_ball(const Vec3& c, double r, const F& f) {
  const bool small = r < 1.0;
  const double reach = small ? 0.5 * kCube * r : r + 0.5;
  const Vec3i low = (c.array() - reach).floor().cast<int>(), high = (c.array() + reach).floor().cast<int>();
  for (int k = low.z(); k <= high.z(); ++k)
    for (int j = low.y(); j <= high.y(); ++j)
      for (int i = low.x(); i <= high.x(); ++i) {
        const Vec3 corner(i, j, k);
        const double share =
            small ? ((c.array() + reach).min(corner.array() + 1.0) - (c.array() - reach).max(corner.array()))
                        .max(0.0)
                        .prod()
                  : std::clamp(0.5 + r - (corner + Vec3::Constant(0.5) - c).norm(), 0.0, 1.0);
        if (share > 0.0) f(Vec3i(i, j, k), share);
      }
}

/// The eighths that balls take, each with its whole volume.
void sample_balls(const MacGrid& g, const SpinningBalls& balls, std::vector<Eighth>& out) {
  const double h = 0.5 * g.dx;
  const Vec3i n = 2 * g.n;
  out.clear();
  for (std::int32_t b = 0; b < balls.balls(); ++b) {
    const double r = balls.ball_radius(b) / h;
    const Vec3 c = (balls.ball_center(b) - g.origin) / h;
    if ((c.array() + (r + 0.5) < 0.0).any() || (c.array() - (r + 0.5) > n.cast<double>().array()).any()) continue;
    double sum = 0.0;
    for_eighths_of_ball(c, r, [&](const Vec3i&, double share) { sum += share; });
    const double scale = 4.0 / 3.0 * std::numbers::pi * r * r * r / sum;
    for_eighths_of_ball(c, r, [&](const Vec3i& at, double share) {
      if ((at.array() >= 0).all() && (at.array() < n.array()).all())
        out.push_back(
            {at.x() + n.x() * (at.y() + n.y() * at.z()), std::min(static_cast<float>(scale * share), 1.0f), b});
    });
  }
}

/// Adds up the pieces of each eighth; its source is that of the fullest.
void join_pieces(std::vector<Eighth>& all) {
  std::stable_sort(all.begin(), all.end(), [](const Eighth& a, const Eighth& b) { return a.place < b.place; });
  std::size_t n = 0;
  for (std::size_t begin = 0; begin < all.size();) {
    Eighth sum{all[begin].place, 0.0f, 0};
    float fullest = 0.0f;
    for (; begin < all.size() && all[begin].place == sum.place; ++begin) {
      const Eighth& e = all[begin];
      if (e.share > fullest) fullest = e.share, sum.source = e.source;
      sum.share += e.share, sum.off += e.share * e.off;
    }
    sum.off /= sum.share;
    sum.share = std::min(sum.share, 1.0f);
    all[n++] = sum;
  }
  all.resize(n);
}

}  // namespace

const std::vector<Eighth>& SolidShares::of(std::pair<std::int32_t, std::int32_t> two, const MacGrid& g,
                                           const WorldPart& part) {
  Found& found = found_[two];
  const PosedShape* solid = solid_of(*part.body, part.index);
  const bool same = solid != nullptr && found.body == part.body && found.origin == g.origin &&
                    found.pose.rotation == solid->pose().rotation &&
                    found.pose.translation == solid->pose().translation;
  found.body = part.body, found.origin = g.origin;
  if (solid != nullptr) found.pose = solid->pose();
  const auto* balls = interface_of<SpinningBalls>(*part.body);
  if (balls != nullptr)
    sample_balls(g, *balls, found.eighths);
  else if (!same)
    sample(g, part, solid, found.eighths);
  return found.eighths;
}

void SolidShares::sample(const MacGrid& g, const WorldPart& part, const PosedShape* solid, std::vector<Eighth>& out) {
  const int m = pieces_of(part.info.thickness, g.dx);
  const double h = 0.5 * g.dx / m, w = 6.0 * h;
  const Vec3i n = 2 * m * g.n;
  const Vec3 origin = g.origin / h + Vec3::Constant(0.5);
  const Vec3i first = origin.array().floor().cast<int>();
  const Vec3 t = origin - first.cast<double>();  // centre of an eighth relative to the node below it
  const int p = part.index;
  const Aabb region = part.body->bounds(p).inflated(g.dx).intersection(g.box().inflated(g.dx));
  tiles_.clear(), out.clear();
  if (!region.empty()) part.body->presence(p, h, w, region, tiles_);
  sort_unique(tiles_);
  if (tiles_.empty()) return;
  const auto blocks = rasterize_whole(part, h, w, tiles_, blocks_);
  std::vector<std::vector<Eighth>> piece(tiles_.size());
  parallel_for(tiles_.size(), [&](std::size_t k) {
    const DensityBlock& block = blocks[k];
    const Vec3i tile = kTileSize * Vec3i(tiles_[k].x, tiles_[k].y, tiles_[k].z);
    std::array<double, kBlockNodes> distance;
    for (int i = 0; i < kBlockNodes; ++i) {
      const double rho = block.rho[i];
      distance[i] = rho <= 0.0 ? 0.5 * w : rho >= 1.0 ? -0.5 * w : ramp_inverse(rho, w);
    }
    for (int c = 0; c < kTileSize; ++c)
      for (int b = 0; b < kTileSize; ++b)
        for (int a = 0; a < kTileSize; ++a) {
          const Vec3i at = tile + Vec3i(a, b, c) - first;
          if ((at.array() < 0).any() || (at.array() >= n.array()).any()) continue;
          double fullest = 0.0;
          std::int32_t source = 0;
          const auto [d, slope] = trilinear(t, h, [&](int x, int y, int z) {
            const int node = block_index(a + x + kHalo, b + y + kHalo, c + z + kHalo);
            if (block.rho[node] > fullest) fullest = block.rho[node], source = block.source[node];
            return distance[node];
          });
          const double length = slope.norm();
          const double width = h * (length > 1e-6 ? slope.lpNorm<1>() / length : 1.0);
          double share = std::clamp(0.5 - d / width, 0.0, 1.0);
          Vec3f off = Vec3f::Zero();
          if (solid != nullptr && std::abs(d) < h) {
            // A known distance is evaluated at the centres of eighths of the eighth, since edges are no planes.
            share = 0.0;
            const Vec3 middle = g.origin + h * (at.cast<double>() + Vec3::Constant(0.5));
            for (int corner = 0; corner < 8; ++corner) {
              const Vec3 way = 0.25 * Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
              const double there = solid->shape().distance(solid->pose().to_local(middle + h * way));
              const double piece_share = 0.125 * std::clamp(0.5 - 2.0 * there / width, 0.0, 1.0);
              share += piece_share, off += (piece_share * way).cast<float>();
            }
            if (share > 0.0) off /= static_cast<float>(share);
          }
          if (share > 0.0) {
            const Vec3i eighth = at / m;
            const Vec3f within =
                ((at - m * eighth).cast<float>() + Vec3f::Constant(0.5f) + off) / static_cast<float>(m);
            piece[k].push_back({eighth.x() + 2 * g.n.x() * (eighth.y() + 2 * g.n.y() * eighth.z()),
                                static_cast<float>(share / (m * m * m)), source, within - Vec3f::Constant(0.5f)});
          }
        }
  });
  for (const auto& found : piece) out.insert(out.end(), found.begin(), found.end());
  if (m > 1) join_pieces(out);
}

}  // namespace brim
