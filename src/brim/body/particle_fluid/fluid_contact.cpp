#include "brim/body/particle_fluid/fluid_contact.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "brim/body/filling.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/core/simd.h"

namespace brim {

namespace {

/// |Σ V ∇W| times the support at which the map follows the slopes alone. A plane surface has 1.4.
constexpr double kSteepSlope = 0.7;
/// Fill below which a particle counts for more than its volume.
constexpr double kSparseFill = 0.7;
/// Kernel sum that counts as empty. The whole tail would reach far into walls, where nothing has a slope to push with;
/// more would let the layer at a wall sink into it (0.12: 0.15 spacings).
constexpr double kTail = 0.09;

/// rho += volume W(r) at the nodes of a block that are wanted and in reach, whole groups of a row together: what of a
/// group lies out of reach gets zero, as W = 2 a³ − b³ with a = (1 − r/H)₊, b = (1 − 2 r/H)₊.
BRIM_WIDE void splat_kernel(const Vec3& x, const FluidKernel& kernel, double volume, const Vec3& origin, double h,
                            Octants wanted, double* rho) {
  const double H = kernel.support(), inverse = 1.0 / H, top = volume * kernel.value(0.0);
  const NodeRange n = nodes_in_box(Aabb{x, x}.inflated(H), origin, h, wanted);
  const Lanes steps = {0.0, 1.0, 2.0, 3.0}, zero = {};
  for (int k = n.lo[2]; k <= n.hi[2]; ++k)
    for (int j = n.lo[1]; j <= n.hi[1]; ++j) {
      const double dy = origin.y() + h * j - x.y(), dz = origin.z() + h * k - x.z(), off2 = dy * dy + dz * dz;
      if (off2 >= H * H) continue;
      for (int i = n.lo[0]; i <= n.hi[0]; i += kLanes) {
        const int first = std::min(i, kBlockSize - kLanes);  // the last group of a row begins in the one before
        const Lanes node = steps + double(first), dx = (origin.x() - x.x()) + h * node, r2 = off2 + dx * dx;
        Lanes q;
        for (int l = 0; l < kLanes; ++l) q[l] = __builtin_sqrt(r2[l]);
        q *= inverse;
        const LaneFlags fresh = node >= double(i);
        const Lanes a = (q < 1.0) & fresh ? 1.0 - q : zero, b = (q < 0.5) & fresh ? 1.0 - 2.0 * q : zero;
        Lanes sum;
        double* at = rho + block_index(first, j, k);
        std::memcpy(&sum, at, sizeof sum);
        sum += top * (2.0 * (a * a * a) - b * b * b);
        std::memcpy(at, &sum, sizeof sum);
      }
    }
}

}  // namespace

void FluidContact::begin(const ParticleCells& cells, std::span<const double> fill) {
  cells_ = &cells;
  batches_.clear();
  auto places = std::make_shared<std::vector<Vec3>>(cells.size());
  for (std::size_t k = 0; k < cells.size(); ++k) (*places)[cells.order()[k]] = cells.positions()[k];
  places_ = std::move(places);
  volume_.resize(cells.size());
  for (std::size_t i = 0; i < volume_.size(); ++i) volume_[i] = volume_of_one_ * std::max(1.0, kSparseFill / fill[i]);
}

void FluidContact::presence(double h, const Aabb& region, std::vector<TileKey>& out) const {
  const auto x = cells_->positions();
  const double H = kernel_.support();
  Aabb box;
  for (const Vec3& p : x) box.extend(p);
  auto workspace = workspace_.borrow();
  workspace->cover.begin(box.inflated(H).intersection(region), h);
  workspace->cover.add(BoxList{x.size(), [&](std::size_t i) { return Aabb{x[i], x[i]}.inflated(H); }});
  workspace->cover.append_to(out);
}

void FluidContact::rasterize(double h, std::span<const TileKey> tiles, std::span<DensityBlock> out) const {
  std::int32_t first_source = 0;
  {
    const std::lock_guard lock(mutex_);
    if (!batches_.empty())
      first_source =
          batches_.back().first_source + kBlockNodes * static_cast<std::int32_t>(batches_.back().tiles.size());
    batches_.push_back({first_source, h, {tiles.begin(), tiles.end()}});
  }
  const auto x = cells_->positions();
  const double H = kernel_.support();
  auto workspace = workspace_.borrow();
  workspace->index.build(tiles);
  workspace->bins.build(workspace->index, tiles.size(), h, BoxList{x.size(), [&](std::size_t i) {
                                                                     return Aabb{x[i], x[i]}.inflated(H);
                                                                   }});
  const TileBins& bins = workspace->bins;
  parallel_for(tiles.size(), [&](std::size_t t) {
    DensityBlock& block = out[t];
    std::fill(std::begin(block.rho), std::end(block.rho), 0.0);
    const Vec3 origin = block_origin(tiles[t], h);
    for (const std::int32_t p : bins.of(t))
      splat_kernel(x[p], kernel_, volume_[p], origin, h, block.octants, std::begin(block.rho));
    for (int n = 0; n < kBlockNodes; ++n) {
      block.rho[n] = std::clamp((block.rho[n] - kTail) / (1.0 - kTail), 0.0, 1.0);
      block.source[n] =
          block.rho[n] > 0.0 ? first_source + kBlockNodes * static_cast<std::int32_t>(t) + n : std::int32_t{-1};
    }
  });
}

Vec3 FluidContact::node_of(std::int32_t source) const {
  auto batch = std::upper_bound(batches_.begin(), batches_.end(), source,
                                [](std::int32_t s, const Batch& b) { return s < b.first_source; });
  BRIM_CHECK(batch != batches_.begin(), ==, true);
  --batch;
  const std::int32_t local = source - batch->first_source, node = local % kBlockNodes;
  const TileKey& tile = batch->tiles.at(static_cast<std::size_t>(local / kBlockNodes));
  const int i = node % kBlockSize, j = node / kBlockSize % kBlockSize, k = node / (kBlockSize * kBlockSize);
  return block_origin(tile, batch->h) + batch->h * Vec3(i, j, k);
}

void FluidContact::make_map(std::span<const std::int32_t> sources, FluidMap& map) const {
  const auto x = cells_->positions();
  const auto order = cells_->order();
  const double H = kernel_.support();
  // Rows of any length: blocks of points gather their own, then all are put together in order.
  constexpr std::size_t kBlock = 256;
  const std::size_t n = sources.size(), blocks = (n + kBlock - 1) / kBlock;
  std::vector<std::vector<FluidMap::Entry>> entries(blocks);
  std::vector<std::int32_t> length(n);
  std::vector<FluidMap::Row> rows(n);
  parallel_for(blocks, [&](std::size_t b) {
    for (std::size_t p = b * kBlock; p < std::min(n, (b + 1) * kBlock); ++p) {
      const std::size_t before = entries[b].size();
      if (sources[p] < -1) {
        // The particle itself.
        const std::int32_t particle = Filling::element_of(sources[p]);
        entries[b].push_back({particle, 1.0f, 0.0f});
        rows[p] = {(*places_)[particle], Vec3::UnitZ(), 1.0, 0.0, 1.0};
        length[p] = 1;
        continue;
      }
      const Vec3 node = node_of(sources[p]);
      Vec3 slope = Vec3::Zero();
      double value = 0.0;
      cells_->near(node, H, [&](std::int32_t first, std::int32_t last) {
        for (std::int32_t i = first; i < last; ++i) {
          const Vec3 d = node - x[i];
          const double r2 = d.squaredNorm();
          if (r2 >= H * H) continue;
          const double r = std::sqrt(r2);
          const FluidMap::Entry e = {order[i], static_cast<float>(volume_[i] * kernel_.value(r)),
                                     static_cast<float>(volume_[i] * kernel_.slope_over_r(r))};
          entries[b].push_back(e);
          value += e.value;
          slope += double(e.slope) * d;
        }
      });
      // Slopes as far as they add up, kernel weights for what is missing.
      const double size = slope.norm(), scale = std::max(size, kSteepSlope / H);
      rows[p] = {node, size > 0.0 ? Vec3(slope / size) : Vec3::UnitZ(), value > 0.0 ? 1.0 / value : 0.0, 1.0 / scale,
                 1.0 - size / scale};
      length[p] = static_cast<std::int32_t>(entries[b].size() - before);
    }
  });
  map.assign(places_, std::move(rows), entries, length);
}

}  // namespace brim
