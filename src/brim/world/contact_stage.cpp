#include "brim/world/contact_stage.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/core/stopwatch.h"
#include "brim/world/tile_room.h"

namespace brim {

namespace {

/// Index of the first element of a sorted list that equals the key; the key must be there.
std::size_t index_of(const std::vector<TileKey>& sorted, const TileKey& key) {
  return std::lower_bound(sorted.begin(), sorted.end(), key) - sorted.begin();
}

bool inside(const TileKey& t, const TileRange& r) {
  return t.x >= r.lo.x && t.x <= r.hi.x && t.y >= r.lo.y && t.y <= r.hi.y && t.z >= r.lo.z && t.z <= r.hi.z;
}

void sort_unique(std::vector<TileKey>& tiles) {
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
}

/// Tiles are counted in 32 bits, and beyond 1e9 steps positions in double precision are rough against a step.
/// @throws InputError  when what two parts share is farther from the origin
void require_near(const WorldPart& a, const WorldPart& b, const Aabb& region, double h) {
  const double far = std::max(region.lo.cwiseAbs().maxCoeff(), region.hi.cwiseAbs().maxCoeff());
  if (far > 1e9 * h)
    throw InputError(
        fmt::format("world: '{}' and '{}' meet {:.3g} m from the origin, too far for steps of {} m (at most 1e9 of "
                    "them); look for a speed, a position or a size that is too large",
                    a.body->name(), b.body->name(), far, h));
}

/// Most tiles that presence may have to look at in the region of one part: seconds of work.
constexpr double kMostTiles = 2e8;

/// @throws InputError  when what touches a part lies so far apart that looking for it would not end
void require_few(const WorldPart& part, const Aabb& region, double h) {
  const Vec3 tiles = region.extent() / (kTileSize * h) + Vec3::Constant(2.0);
  if (tiles.prod() > kMostTiles)
    throw InputError(fmt::format(
        "world: what touches '{}' lies up to {:.3g} m apart, {:.1g} tiles at steps of {} m (at most {:.0g}); "
        "look for a speed or a position that is too large, or use a larger voxel_size",
        part.body->name(), region.extent().maxCoeff(), tiles.prod(), h, kMostTiles));
}

}  // namespace

void ContactStage::find(std::span<const WorldPart> parts, std::span<const double> v,
                        std::span<const std::size_t> first_v, double dt, const WorldOptions& options,
                        StepReport& report) {
  const auto seconds = [&](Phase p) -> double& { return report.seconds[static_cast<std::size_t>(p)]; };
  {
    const ScopedSeconds timer(seconds(Phase::Presence));
    find_candidates(parts, v, first_v, dt, options);
    find_presence(parts, options.ramp_voxels, report);
  }
  {
    const ScopedSeconds timer(seconds(Phase::Refine));
    refine(parts, options);
  }
  {
    const ScopedSeconds timer(seconds(Phase::Rasterize));
    rasterize(parts, options.ramp_voxels, report);
  }
  const ScopedSeconds timer(seconds(Phase::Detect));
  collect();
  detect(pair_tiles_, contacts_);
}

void ContactStage::find_candidates(std::span<const WorldPart> parts, std::span<const double> v,
                                   std::span<const std::size_t> first_v, double dt, const WorldOptions& options) {
  const double ramp = options.ramp_voxels;
  const double fall = options.environment.gravity.norm() * dt;
  for (std::size_t l = 0; l < layer_count_; ++l) {
    layers_[l].present.clear();
    layers_[l].needed.clear();
  }
  layer_count_ = candidate_count_ = 0;

  // The root of the hierarchy: boxes of whole parts, swept along x.
  struct Entry {
    Aabb box;
    std::int32_t part;
  };
  std::vector<Entry> entries(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p)
    entries[p] = {parts[p].body->bounds(parts[p].index).inflated(0.5 * ramp * parts[p].h),
                  static_cast<std::int32_t>(p)};
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.box.lo.x() != b.box.lo.x() ? a.box.lo.x() < b.box.lo.x() : a.part < b.part;
  });
  struct Touch {
    std::int32_t a, b;
    Aabb region;
  };
  std::vector<Touch> touches;
  for (std::size_t i = 0; i < entries.size(); ++i)
    for (std::size_t j = i + 1; j < entries.size() && entries[j].box.lo.x() <= entries[i].box.hi.x(); ++j) {
      if (!entries[i].box.overlaps(entries[j].box)) continue;
      const auto a = std::min(entries[i].part, entries[j].part), b = std::max(entries[i].part, entries[j].part);
      if (!may_touch(parts[a], parts[b])) continue;
      touches.push_back({a, b, entries[i].box.intersection(entries[j].box)});
    }
  std::sort(touches.begin(), touches.end(),
            [](const Touch& s, const Touch& t) { return s.a != t.a ? s.a < t.a : s.b < t.b; });

  for (const Touch& t : touches) {
    const double h = std::min(parts[t.a].h, parts[t.b].h);  // they meet at the finer of their two steps
    if (candidate_count_ == candidates_.size()) candidates_.emplace_back();
    Candidate& c = candidates_[candidate_count_++];
    // Nodes whose gap may close within the step count as contacts that wait.
    const WorldPart &a = parts[t.a], &b = parts[t.b];
    const auto va = v.subspan(first_v[a.body_index], first_v[a.body_index + 1] - first_v[a.body_index]);
    const auto vb = v.subspan(first_v[b.body_index], first_v[b.body_index + 1] - first_v[b.body_index]);
    const double speed = (a.body->carrier_velocity(a.index, va) - b.body->carrier_velocity(b.index, vb)).norm() +
                         a.body->relative_speed_bound(a.index, va) + b.body->relative_speed_bound(b.index, vb);
    const double margin = std::min(0.4, 1.5 * (speed + fall) * dt / (ramp * h));
    c.pair = ContactPair{t.a, t.b, h, ramp * h, margin, 0, 0};
    c.region = t.region;
    require_near(a, b, t.region, h);
    c.tiles.clear(), c.octants.clear();
    c.pair_layer_a = layer_of(t.a, h, t.region);
    c.pair_layer_b = layer_of(t.b, h, t.region);
  }
  for (std::size_t l = 0; l < layer_count_; ++l) require_few(parts[layers_[l].part], layers_[l].region, layers_[l].h);
}

std::int32_t ContactStage::layer_of(std::int32_t part, double h, const Aabb& region) {
  for (std::size_t l = layer_count_; l-- > 0;)
    if (layers_[l].part == part && layers_[l].h == h) {
      layers_[l].region.extend(region);
      return static_cast<std::int32_t>(l);
    }
  if (layer_count_ == layers_.size()) layers_.emplace_back();
  Layer& layer = layers_[layer_count_];
  layer.part = part;
  layer.h = h;
  layer.region = region;
  return static_cast<std::int32_t>(layer_count_++);
}

void ContactStage::find_presence(std::span<const WorldPart> parts, double ramp, StepReport& report) {
  parallel_for(layer_count_, [&](std::size_t l) {
    Layer& layer = layers_[l];
    const WorldPart& part = parts[layer.part];
    part.body->presence(part.index, layer.h, ramp * layer.h, layer.region.inflated(layer.h), layer.present);
    sort_unique(layer.present);
  });
  for (std::size_t l = 0; l < layer_count_; ++l)
    report.tiles_present += static_cast<std::int64_t>(layers_[l].present.size());
}

void ContactStage::refine(std::span<const WorldPart> parts, const WorldOptions& options) {
  parallel_for(candidate_count_, [&](std::size_t i) {
    Candidate& c = candidates_[i];
    const auto bounded_part = [&](std::int32_t p) {
      return BoundedPart{dynamic_cast<const DistanceBound*>(parts[p].body), parts[p].index};
    };
    const BoundedPart pa = bounded_part(c.pair.part_a), pb = bounded_part(c.pair.part_b);
    const std::vector<TileKey>&a = layers_[c.pair_layer_a].present, &b = layers_[c.pair_layer_b].present;
    const TileRange range = tiles_meeting(c.region.inflated(c.pair.h), c.pair.h);
    const std::vector<TileKey>& few = a.size() < b.size() ? a : b;
    const std::vector<TileKey>& many = a.size() < b.size() ? b : a;
    for (const TileKey& t : few) {
      if (!inside(t, range) || !std::binary_search(many.begin(), many.end(), t)) continue;
      const Octants octants = octants_with_room(pa, pb, c.pair, t);
      if (octants != 0) c.tiles.push_back(t), c.octants.push_back(octants);
    }
  });
  for (std::size_t i = 0; i < candidate_count_; ++i) {
    const Candidate& c = candidates_[i];
    for (const std::int32_t l : {c.pair_layer_a, c.pair_layer_b})
      layers_[l].needed.insert(layers_[l].needed.end(), c.tiles.begin(), c.tiles.end());
  }
  std::size_t total = 0;
  for (std::size_t l = 0; l < layer_count_; ++l) {
    sort_unique(layers_[l].needed);
    layers_[l].octants.assign(layers_[l].needed.size(), 0);
    layers_[l].first_block = total;
    total += layers_[l].needed.size();
  }
  for (std::size_t i = 0; i < candidate_count_; ++i) {
    const Candidate& c = candidates_[i];
    for (const std::int32_t l : {c.pair_layer_a, c.pair_layer_b})
      for (std::size_t t = 0; t < c.tiles.size(); ++t)
        layers_[l].octants[index_of(layers_[l].needed, c.tiles[t])] |= c.octants[t];
  }
  if (static_cast<double>(total) * sizeof(DensityBlock) > options.memory_limit)
    throw InputError(fmt::format(
        "world: {} density tiles need {:.1f} GB, more than memory_limit = {:.1f} GB; use a larger voxel_size", total,
        1e-9 * static_cast<double>(total) * sizeof(DensityBlock), 1e-9 * options.memory_limit));
  if (total > blocks_.size()) blocks_.resize(total);
}

void ContactStage::rasterize(std::span<const WorldPart> parts, double ramp, StepReport& report) {
  parallel_for(layer_count_, [&](std::size_t l) {
    const Layer& layer = layers_[l];
    if (layer.needed.empty()) return;
    const WorldPart& part = parts[layer.part];
    const auto blocks = std::span(blocks_).subspan(layer.first_block, layer.needed.size());
    for (std::size_t t = 0; t < blocks.size(); ++t) blocks[t].octants = layer.octants[t];
    part.body->rasterize(part.index, layer.h, ramp * layer.h, layer.needed, blocks);
  });
  for (std::size_t l = 0; l < layer_count_; ++l) report.tiles += static_cast<std::int64_t>(layers_[l].needed.size());
  report.voxels = report.tiles * kTileSize * kTileSize * kTileSize;
}

void ContactStage::collect() {
  pair_tiles_.clear();
  active_.clear();
  contacts_.pairs.clear();
  for (std::size_t i = 0; i < candidate_count_; ++i) {
    const Candidate& c = candidates_[i];
    if (c.tiles.empty()) continue;
    const Layer &a = layers_[c.pair_layer_a], &b = layers_[c.pair_layer_b];
    const auto pair = static_cast<std::int32_t>(contacts_.pairs.size());
    contacts_.pairs.push_back(c.pair);
    for (const TileKey& t : c.tiles) {
      pair_tiles_.push_back(
          {pair, t, &blocks_[a.first_block + index_of(a.needed, t)], &blocks_[b.first_block + index_of(b.needed, t)]});
      active_.emplace_back(t, c.pair.h);
    }
  }
  std::sort(active_.begin(), active_.end(), [](const auto& s, const auto& t) {
    return s.second != t.second ? s.second < t.second : s.first < t.first;
  });
  active_.erase(std::unique(active_.begin(), active_.end()), active_.end());
}

}  // namespace brim
