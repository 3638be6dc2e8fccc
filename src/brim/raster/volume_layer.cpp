#include "brim/raster/volume_layer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/math/ramp.h"
#include "brim/math/small_symmetric.h"

namespace brim {

namespace {

constexpr double kWidthShare =
    0.73;  // R / w: the slope of the ramp at its middle, 3/2 / w, is 35/32 / R of this kernel
constexpr double kLift = 0.04;
constexpr double kMaxWeight = 8.0;
/// Affine weights reach farther than the density, so that points at its rim still see particles on all sides; at sharp
/// corners farther still.
constexpr double kAffineReach = 1.3, kCornerReach = 2.0;

/// The distance from the surface of a half space at which the integral of kernels of radius 1 is s, negative inside: of
///   s(u) = 1/2 − 35/32 (u − u³ + 3/5 u⁵ − u⁷/7),   −1 <= u <= 1
class PlaneDistance {
 public:
  PlaneDistance() {
    double u = -1.0;
    for (int i = kSteps; i >= 0; --i) {
      const double wanted = static_cast<double>(i) / kSteps;
      double lo = u, hi = 1.0;  // the sum falls with u
      for (int halving = 0; halving < 60; ++halving) (sum(0.5 * (lo + hi)) > wanted ? lo : hi) = 0.5 * (lo + hi);
      distance_[static_cast<std::size_t>(i)] = u = 0.5 * (lo + hi);
    }
  }
  /// Of a half space of cubes of edge a, each at its middle: their sum is s(u) − a²/24 s''(u), s'' = 105/16 u (1 −
  /// u²)².
  /// @param a2  a², in squares of the radius
  double of_cubes(double s, double a2) const {
    double u = (*this)(s);
    for (int i = 0; i < 2; ++i) u = (*this)(s + a2 / 24.0 * 6.5625 * u * (1.0 - u * u) * (1.0 - u * u));
    return u;
  }
  double operator()(double s) const {
    const double at = std::clamp(s, 0.0, 1.0) * kSteps;
    const auto i = std::min(static_cast<std::size_t>(at), static_cast<std::size_t>(kSteps - 1));
    return distance_[i] + (at - static_cast<double>(i)) * (distance_[i + 1] - distance_[i]);
  }

 private:
  static constexpr int kSteps = 1024;
  static double sum(double u) {
    const double u2 = u * u;
    return 0.5 - 35.0 / 32.0 * u * (1.0 - u2 * (1.0 - u2 * (0.6 - u2 / 7.0)));
  }
  std::array<double, kSteps + 1> distance_;
};

double kernel_scale(double R) { return 105.0 / (32.0 * std::numbers::pi * R * R * R); }

/// Makes Σ w x = r. @return false, and weights as they were, where the particles do not allow it
template <class Neighbour>
bool correct(std::span<const Vec3> x, const Vec3& r, std::vector<Neighbour>& near) {
  Vec3 mean = Vec3::Zero();
  for (const Neighbour& n : near) mean += n.weight * x[n.particle];
  Mat3 M = Mat3::Zero();
  for (const Neighbour& n : near) M += n.weight * (x[n.particle] - mean) * (x[n.particle] - mean).transpose();
  const SymmetricAxes eig = symmetric_axes(M);
  const double least = 1e-6 * eig.values[2];
  if (!(eig.values[0] > least)) return false;  // in one plane, on one line, or alone
  const Vec3 p = eig.vectors * (eig.vectors.transpose() * (r - mean)).cwiseQuotient(eig.values);
  double size = 0.0;
  for (const Neighbour& n : near) size += std::abs(n.weight * (1.0 + p.dot(x[n.particle] - mean)));
  if (size > kMaxWeight) return false;
  for (Neighbour& n : near) n.weight *= 1.0 + p.dot(x[n.particle] - mean);
  return true;
}

}  // namespace

/// The particles in reach of a point with the weights of Mass. @param wider  reach over R_i @return ∇s, [1/m]
Vec3 VolumeLayer::collect(std::span<const std::int32_t> around, const Vec3& r, double w, double wider,
                          std::vector<Neighbour>& near) const {
  near.clear();
  double total = 0.0;
  Vec3 gradient = Vec3::Zero();
  for (const std::int32_t id : around) {
    const auto i = static_cast<std::size_t>(id);
    const double R = influence(i, w), Rw = wider * R;
    const Vec3 d = r - x_[i];
    const double qw = 1.0 - d.squaredNorm() / (Rw * Rw), q = std::max(0.0, 1.0 - d.squaredNorm() / (R * R));
    if (qw <= 0.0) continue;
    near.push_back({id, mass_[i] * kernel_scale(Rw) * qw * qw, -4.0 * volume_[i] * kernel_scale(R) * q / (R * R) * d});
    total += near.back().weight;
    gradient += near.back().gradient;
  }
  for (Neighbour& n : near) n.weight /= total;
  return gradient;
}

void VolumeLayer::set(std::span<const Vec3> x, std::span<const double> volume, std::span<const double> mass,
                      std::span<const double> radius) {
  BRIM_CHECK(volume.size(), ==, x.size());
  BRIM_CHECK(mass.size(), ==, x.size());
  BRIM_CHECK((radius.size() == 1 || radius.size() == x.size()), ==, true);
  BRIM_CHECK(x.size(), <, (std::size_t{1} << 31) / (2 * kWidths));
  x_ = x, volume_ = volume, mass_ = mass, radius_ = radius;
  box_ = Aabb();
  for (const Vec3& p : x) box_.extend(p);
  edge_.resize(x.size());
  parallel_for(
      x.size(), [&](std::size_t i) { edge_[i] = std::cbrt(volume[i]); }, 1024);
}

double VolumeLayer::influence(std::size_t i, double w) const {
  return std::max({radius_[radius_.size() == 1 ? 0 : i], kWidthShare * w, kLeastSpacings * edge_[i]});
}

int VolumeLayer::slot_of(double w) const {
  const std::lock_guard lock(mutex_);
  for (int s = 0; s < widths_; ++s)
    if (width_[s] == w) return s;
  if (widths_ < kWidths) ++widths_;
  width_[widths_ - 1] = w;
  return widths_ - 1;
}

void VolumeLayer::presence(double h, double w, const Aabb& region, std::vector<TileKey>& out) const {
  auto workspace = workspace_.borrow();
  double most = 0.0;
  for (std::size_t i = 0; i < x_.size(); ++i) most = std::max(most, influence(i, w));
  workspace->cover.begin(box_.inflated(most).intersection(region), h);
  workspace->cover.add(BoxList{x_.size(), [&](std::size_t i) { return Aabb{x_[i], x_[i]}.inflated(influence(i, w)); }});
  workspace->cover.append_to(out);
}

void VolumeLayer::rasterize(double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const {
  BRIM_CHECK(tiles.size(), ==, out.size());
  static const PlaneDistance plane;
  const int slot = slot_of(w);
  auto workspace = workspace_.borrow();
  workspace->index.build(tiles);
  workspace->bins.build(workspace->index, tiles.size(), h,
                        BoxList{x_.size(), [&](std::size_t i) {
                                  return Aabb{x_[i], x_[i]}.inflated(influence(i, w));
                                }});
  parallel_for(tiles.size(), [&](std::size_t t) {
    const Vec3 origin = block_origin(tiles[t], h);
    DensityBlock& block = out[t];
    double nearest[kBlockNodes];
    std::fill_n(block.rho, kBlockNodes, 0.0);
    std::fill_n(block.source, kBlockNodes, -1);
    std::fill_n(nearest, kBlockNodes, std::numeric_limits<double>::infinity());
    for (const std::int32_t id : workspace->bins.of(t)) {
      const auto i = static_cast<std::size_t>(id);
      const double R = influence(i, w), scale = volume_[i] * kernel_scale(R), inverse = 1.0 / (R * R);
      const NodeRange n = nodes_in_box(Aabb{x_[i], x_[i]}.inflated(R), origin, h, block.octants);
      const Vec3 from = origin - x_[i];
      for (int c = n.lo[2]; c <= n.hi[2]; ++c)
        for (int b = n.lo[1]; b <= n.hi[1]; ++b) {
          const double y = from.y() + h * b, z = from.z() + h * c, yz = y * y + z * z;
          for (int a = n.lo[0]; a <= n.hi[0]; ++a) {
            const double x = from.x() + h * a, d2 = x * x + yz, q = 1.0 - d2 * inverse;
            if (q <= 0.0) continue;
            const int node = block_index(a, b, c);
            block.rho[node] += scale * q * q;
            if (d2 < nearest[node]) nearest[node] = d2, block.source[node] = id * 2 * kWidths + slot;
          }
        }
    }
    // Kernels reach farther than the ramp of a solid, the more so in fine voxels: what they tell is where the surface
    // is.
    for (int node = 0; node < kBlockNodes; ++node) {
      double& rho = block.rho[node];
      if (rho == 0.0) continue;
      const auto i = static_cast<std::size_t>(particle_of(block.source[node]));
      const double R = influence(i, w), edge = edge_[i] / R, s4 = rho * rho * rho * rho;
      rho = ramp(R * plane.of_cubes(rho * (1.0 + kLift * s4 * s4 * s4), edge * edge), w);
    }
  });
}

WeightRows VolumeLayer::weights(std::span<const Vec3> points, std::span<const std::int32_t> sources,
                                LayerWeights kind) const {
  BRIM_CHECK(points.size(), ==, sources.size());
  WeightRows rows;
  if (points.empty()) return rows;
  std::array<double, kWidths> width{};
  {
    const std::lock_guard lock(mutex_);
    width = width_;
  }
  const double widest = *std::max_element(width.begin(), width.end());
  const auto is_affine = [&](std::int32_t source) { return kind != LayerWeights::Mass || is_matter(source); };
  const double wider = std::any_of(sources.begin(), sources.end(), is_affine) ? kCornerReach : 1.0;
  double most = 0.0;
  for (std::size_t i = 0; i < x_.size(); ++i) most = std::max(most, wider * influence(i, widest));

  // Tiles half as wide as the reach, with the particles near each.
  const double step = most / 16.0, side = kTileSize * step;
  const auto tile_of = [&](const Vec3& r) {
    return TileKey{static_cast<std::int32_t>(std::floor(r.x() / side)),
                   static_cast<std::int32_t>(std::floor(r.y() / side)),
                   static_cast<std::int32_t>(std::floor(r.z() / side))};
  };
  std::vector<TileKey> tiles;
  Aabb wanted;
  for (const Vec3& r : points) tiles.push_back(tile_of(r)), wanted.extend(r);
  sort_unique(tiles);
  const Aabb near_points = wanted.inflated(step);
  auto workspace = workspace_.borrow();
  workspace->index.build(tiles);
  workspace->bins.build(
      workspace->index, tiles.size(), step,
      BoxList{x_.size(), [&](std::size_t i) {
                return Aabb{x_[i], x_[i]}.inflated(wider * influence(i, widest)).intersection(near_points);
              }});

  const bool rate = kind == LayerWeights::DensityRate;
  std::vector<std::vector<Neighbour>> made(points.size());
  std::vector<Vec3> normal(rate ? points.size() : 0, Vec3::Zero());
  parallel_for(
      points.size(),
      [&](std::size_t p) {
        std::vector<Neighbour>& near = made[p];
        const Vec3& r = points[p];
        const double w = width[static_cast<std::size_t>(width_of(sources[p]))];
        const bool affine = is_affine(sources[p]);
        const TileKey key = tile_of(r);
        const auto around = workspace->bins.of(static_cast<std::size_t>(workspace->index.find(key.x, key.y, key.z)));
        Vec3 gradient = collect(around, r, w, affine ? kAffineReach : 1.0, near);
        if (affine && !correct(x_, r, near)) {
          gradient = collect(around, r, w, kCornerReach, near);
          correct(x_, r, near);
        }
        if (near.empty()) {
          near.assign(1, {particle_of(sources[p]), 1.0, Vec3::Zero()});
          return;
        }
        // Matter has none, and deep inside the density does not say where it goes: there is no rate to follow.
        const double slope = gradient.norm();
        if (rate && !is_matter(sources[p]) && slope * w > 0.1) {
          normal[p] = gradient / slope;
          for (Neighbour& n : near) n.gradient = n.gradient / slope - n.weight * normal[p];
        } else {
          for (Neighbour& n : near) n.gradient.setZero();
        }
      },
      32);
  for (const auto& near : made) {
    for (const Neighbour& n : near) {
      rows.source.push_back(n.particle);
      rows.weight.push_back(n.weight);
      if (rate) rows.lever.push_back(n.gradient);
    }
    rows.first.push_back(static_cast<std::int32_t>(rows.source.size()));
  }
  rows.normal = std::move(normal);
  return rows;
}

}  // namespace brim
