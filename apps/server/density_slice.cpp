#include "server/density_slice.h"

#include <algorithm>
#include <cmath>

#include "brim/core/error.h"

namespace brim::viewer {

namespace {

constexpr double kMostNodes = 3e6;
/// Share of the finest step that contact takes below which no step may be asked for: finer shows nothing of contact.
constexpr double kFinest = 0.25;

/// Box of what can move, and of what is fixed near by; with a margin of some voxels.
Aabb seen_box(const World& world, double h) {
  Aabb moving, fixed;
  for (int p = 0; p < world.part_count(); ++p) {
    const PartRef part = world.part(p);
    const Body& body = world.body(part.body);
    const Aabb box = body.bounds(part.index);
    if (!box.lo.allFinite() || !box.hi.allFinite() || box.empty()) continue;
    (body.immobile() ? fixed : moving).extend(box);
  }
  if (moving.empty()) moving = fixed.empty() ? Aabb{Vec3::Constant(-1.0), Vec3::Constant(1.0)} : fixed;
  const Aabb wide = moving.inflated(0.08 * moving.extent().maxCoeff() + 6.0 * h);
  // A fixed body that is not much larger is shown whole.
  if (!fixed.empty() && fixed.overlaps(wide) && fixed.extent().maxCoeff() < 1.5 * wide.extent().maxCoeff()) {
    moving.extend(fixed);
    return moving.inflated(6.0 * h);
  }
  return wide;
}

double finest_step(const World& world) {
  double h = world.options().voxel_size;
  if (h > 0.0) return h;
  for (int p = 0; p < world.part_count(); ++p) {
    const PartRef part = world.part(p);
    const double own = world.body(part.body).part(part.index).voxel_size;
    if (own > 0.0 && (h == 0.0 || own < h)) h = own;
  }
  return h > 0.0 ? h : 0.05;
}

/// One part's densities on the plane.
class Plane {
 public:
  Plane(const DensitySlice& slice, const World& world) : slice_(slice), world_(world) {
    u_ = (slice.axis + 1) % 3, v_ = (slice.axis + 2) % 3;
    layer_ = static_cast<std::int32_t>(std::lround(slice.at / slice.step));
  }

  /// Tiles of the plane on which a part is, for as long as no others are asked for.
  std::span<const TileKey> tiles(int p) {
    const PartRef part = world_.part(p);
    const Body& body = world_.body(part.body);
    const double h = slice_.step, ramp = world_.options().ramp_voxels * h;
    Aabb region;
    region.lo[slice_.axis] = region.hi[slice_.axis] = h * layer_;
    const int axes[2] = {u_, v_};
    for (int a = 0; a < 2; ++a) {
      region.lo[axes[a]] = h * slice_.first[a];
      region.hi[axes[a]] = h * (slice_.first[a] + slice_.count[a] - 1);
    }
    tiles_.clear();
    body.presence(part.index, h, ramp, region.inflated(0.25 * h), tiles_);
    std::sort(tiles_.begin(), tiles_.end());
    tiles_.erase(std::unique(tiles_.begin(), tiles_.end()), tiles_.end());
    const auto own_layer = static_cast<std::int32_t>(std::floor(static_cast<double>(layer_) / kTileSize));
    std::erase_if(tiles_, [&](const TileKey& t) { return coordinate(t, slice_.axis) != own_layer; });
    return tiles_;
  }

  /// Calls visit(index, rho) for every node with density.
  template <class Visit>
  void rasterize(int p, Visit visit) {
    constexpr std::size_t kBatch = 256;
    const std::span<const TileKey> all = tiles(p);
    for (std::size_t at = 0; at < all.size(); at += kBatch) {
      const auto batch = all.subspan(at, std::min(kBatch, all.size() - at));
      if (blocks_.size() < batch.size()) blocks_.resize(batch.size());
      world_.density(p, slice_.step, batch, std::span(blocks_).first(batch.size()));
      for (std::size_t t = 0; t < batch.size(); ++t) read(batch[t], blocks_[t], visit);
    }
  }

 private:
  static std::int32_t coordinate(const TileKey& t, int axis) { return axis == 0 ? t.x : axis == 1 ? t.y : t.z; }

  template <class Visit>
  void read(const TileKey& tile, const DensityBlock& block, Visit visit) const {
    int node[3];
    node[slice_.axis] = layer_ - kTileSize * coordinate(tile, slice_.axis) + kHalo;
    for (int b = 0; b < kTileSize; ++b)
      for (int a = 0; a < kTileSize; ++a) {
        const std::int32_t i = kTileSize * coordinate(tile, u_) + a - slice_.first[0];
        const std::int32_t j = kTileSize * coordinate(tile, v_) + b - slice_.first[1];
        if (i < 0 || j < 0 || i >= slice_.count[0] || j >= slice_.count[1]) continue;
        node[u_] = a + kHalo, node[v_] = b + kHalo;
        const double rho = block.rho[block_index(node[0], node[1], node[2])];
        if (rho > 0.0)
          visit(static_cast<std::size_t>(j) * static_cast<std::size_t>(slice_.count[0]) + static_cast<std::size_t>(i),
                static_cast<float>(rho));
      }
  }

  const DensitySlice& slice_;
  const World& world_;
  int u_ = 0, v_ = 1;
  std::int32_t layer_ = 0;
  std::vector<TileKey> tiles_;
  std::vector<DensityBlock> blocks_;
};

/// Takes the density of one more body in at a node, and its overlap with what was there.
void take(DensitySlice& slice, std::size_t n, float rho, std::int32_t body) {
  slice.overlap[n] = std::max(slice.overlap[n], std::max(0.0f, rho + slice.density[n] - 1.0f));
  if (rho > slice.density[n]) {
    slice.second[n] = slice.density[n], slice.second_body[n] = slice.body[n];
    slice.density[n] = rho, slice.body[n] = body;
  } else if (rho > slice.second[n]) {
    slice.second[n] = rho, slice.second_body[n] = body;
  }
}

/// Nodes of the plane over a box, at the step that the slice has or a coarser one.
void lay_out(const Aabb& box, double at, DensitySlice& slice) {
  const int axes[2] = {(slice.axis + 1) % 3, (slice.axis + 2) % 3};
  while (box.extent()[axes[0]] * box.extent()[axes[1]] > kMostNodes * slice.step * slice.step) slice.step *= 2.0;
  slice.lowest = box.lo[slice.axis], slice.highest = box.hi[slice.axis];
  slice.at = slice.step * std::round(std::clamp(at, slice.lowest, slice.highest) / slice.step);
  for (int a = 0; a < 2; ++a) {
    slice.first[a] = static_cast<std::int32_t>(std::floor(box.lo[axes[a]] / slice.step));
    slice.count[a] = static_cast<std::int32_t>(std::ceil(box.hi[axes[a]] / slice.step)) - slice.first[a] + 1;
  }
}

/// True when all parts, or those of one body, have no more tiles on the plane than can be sampled at once.
bool can_be_sampled(const DensitySlice& slice, const World& world, int body) {
  Plane plane(slice, world);
  std::size_t tiles = 0;
  for (int p = 0; p < world.part_count() && tiles <= kMostTiles; ++p)
    if (body < 0 || world.part(p).body == body) tiles += plane.tiles(p).size();
  return tiles <= kMostTiles;
}

void need_step(const World& world, double step) {
  const double finest = finest_step(world), extent = seen_box(world, finest).extent().maxCoeff();
  if (step < kFinest * finest * (1.0 - 1e-9) || step > extent)
    throw TooMuchWork(
        fmt::format("step: {:.3g} m is not allowed; must be 0, or from {:.3g} m (a quarter of the finest step "
                    "of contact) to {:.3g} m",
                    step, kFinest * finest, extent));
}

}  // namespace

DensitySlice cut_densities(const World& world, const SliceRequest& request) {
  if (request.axis < 0 || request.axis > 2) throw InputError("the axis of a slice must be 0, 1 or 2");
  if (request.body < -1 || request.body >= world.body_count())
    throw InputError(fmt::format("no body {}", request.body));
  if (!std::isfinite(request.at) || !std::isfinite(request.step) || request.step < 0.0)
    throw InputError("place and step of a slice must be finite, the step not negative");
  if (request.step > 0.0) need_step(world, request.step);
  DensitySlice slice;
  slice.axis = request.axis;
  slice.step = request.step > 0.0 ? request.step : finest_step(world);
  const Aabb box = seen_box(world, slice.step);
  lay_out(box, request.at, slice);
  while (!can_be_sampled(slice, world, request.body)) {
    if (request.step > 0.0)
      throw TooMuchWork(
          fmt::format("step: {:.3g} m is not allowed here; bodies meet more than {} tiles of the plane with "
                      "it; ask for a larger one, or for 0",
                      request.step, kMostTiles));
    slice.step *= 2.0;
    lay_out(box, request.at, slice);
  }
  const std::size_t nodes = static_cast<std::size_t>(slice.count[0]) * static_cast<std::size_t>(slice.count[1]);
  slice.density.assign(nodes, 0.0f), slice.second.assign(nodes, 0.0f), slice.overlap.assign(nodes, 0.0f);
  slice.body.assign(nodes, -1), slice.second_body.assign(nodes, -1);

  Plane plane(slice, world);
  std::vector<float> own(nodes, 0.0f);  // of all parts of a body so far
  std::vector<std::size_t> touched;
  for (int p = 0; p < world.part_count();) {
    const std::int32_t b = world.part(p).body;
    const int first = p;
    for (; p < world.part_count() && world.part(p).body == b; ++p) {
      if (request.body >= 0 && request.body != b) continue;
      const bool collides = p > first && world.body(b).parts_collide(p - first - 1, p - first);
      plane.rasterize(p, [&](std::size_t n, float rho) {
        if (own[n] == 0.0f) touched.push_back(n);
        if (collides) slice.overlap[n] = std::max(slice.overlap[n], std::max(0.0f, own[n] + rho - 1.0f));
        own[n] = std::min(1.0f, own[n] + rho);
      });
    }
    for (const std::size_t n : touched) {
      take(slice, n, own[n], b);
      own[n] = 0.0f;
    }
    touched.clear();
  }
  return slice;
}

}  // namespace brim::viewer
