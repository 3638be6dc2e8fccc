#include "brim/world/contact_stage.h"

#include <algorithm>
#include <atomic>
#include <bit>

#include "brim/body/posed_shape.h"
#include "brim/body/solid_of.h"
#include "brim/contact/face_edges.h"
#include "brim/contact/patch_center.h"
#include "brim/core/error.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/core/stopwatch.h"
#include "brim/world/averaged_raster.h"
#include "brim/world/part_filter.h"

namespace brim {

namespace {

/// Index of the first element of a sorted list that equals the key; the key must be there.
std::size_t index_of(const std::vector<TileKey>& sorted, const TileKey& key) {
  return std::lower_bound(sorted.begin(), sorted.end(), key) - sorted.begin();
}

bool inside(const TileKey& t, const TileRange& r) {
  return t.x >= r.lo.x && t.x <= r.hi.x && t.y >= r.lo.y && t.y <= r.hi.y && t.z >= r.lo.z && t.z <= r.hi.z;
}

/// Sorts the tiles and merges the octants of repeated ones.
void sort_unique(std::vector<OctantTile>& tiles) {
  const auto before = [](const OctantTile& s, const OctantTile& t) { return s.tile < t.tile; };
  if (!std::is_sorted(tiles.begin(), tiles.end(), before)) std::sort(tiles.begin(), tiles.end(), before);
  std::size_t n = 0;
  for (const OctantTile& t : tiles)
    if (n > 0 && tiles[n - 1].tile == t.tile)
      tiles[n - 1].octants |= t.octants;
    else
      tiles[n++] = t;
  tiles.resize(n);
}

/// A part's presence on a tile; no octant when absent. @param sorted  by tile
Octants octants_on(const std::vector<OctantTile>& sorted, const TileKey& tile) {
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), tile,
                                   [](const OctantTile& s, const TileKey& t) { return s.tile < t; });
  return at != sorted.end() && at->tile == tile ? at->octants : Octants{0};
}

/// Octants of a tile with own nodes in a box.
Octants octants_meeting(const Aabb& box, const TileKey& tile, double h) {
  // The lower half along each axis, in the bits of octants.
  constexpr Octants kLower[3] = {0x55, 0x33, 0x0f};
  constexpr int kHalf = kTileSize / 2;
  const int first[3] = {kTileSize * tile.x, kTileSize * tile.y, kTileSize * tile.z};
  Octants found = kAllOctants;
  for (int a = 0; a < 3; ++a) {
    const double lo = box.lo[a] / h - first[a], hi = box.hi[a] / h - first[a];
    if (hi < 0.0 || lo > kHalf - 1) found &= static_cast<Octants>(~kLower[a]);
    if (hi < kHalf || lo > kTileSize - 1) found &= kLower[a];
  }
  return found;
}

/// Own nodes of an octant.
constexpr std::int64_t kOctantNodes = std::int64_t{kTileSize} * kTileSize * kTileSize / 8;

/// Tiles per piece of a search.
constexpr std::size_t kTilesOfWork = 16;

/// [bytes] memory of a step per contact, measured between rigid boxes.
constexpr double kContactBytes = 1300.0;

}  // namespace

void ContactStage::find(std::span<const WorldPart> parts, std::span<const double> v,
                        std::span<const std::size_t> first_v, double dt, const HeldPairs& held_before,
                        const WorldOptions& options, StepReport& report) {
  const auto seconds = [&](Phase p) -> double& { return report.seconds[static_cast<std::size_t>(p)]; };
  {
    const ScopedSeconds timer(seconds(Phase::Presence));
    access(parts);
    find_candidates(parts, v, first_v, dt, held_before, options);
    find_presence(parts, options.ramp_voxels, report);
  }
  {
    const ScopedSeconds timer(seconds(Phase::Refine));
    refine(options);
  }
  {
    const ScopedSeconds timer(seconds(Phase::Rasterize));
    rasterize(parts, options.ramp_voxels, report);
  }
  const ScopedSeconds timer(seconds(Phase::Detect));
  rigid_.find(held_, options.constraint_every_node, average_);
  plan_work();
  // Work beyond the limit is not started.
  const double most = options.memory_limit / kContactBytes;
  std::atomic<std::int64_t> found = 0;
  parallel_for(work_count_, [&](std::size_t i) {
    if (static_cast<double>(found) > most) return;
    search(work_[i]);
    if (candidates_[work_[i].candidate].by_part) work_[i].finds.engulfed = 0;
    found += static_cast<std::int64_t>(work_[i].finds.contacts.size());
  });
  if (static_cast<double>(found) > most) refuse_crowd("contacts", most, options.memory_limit);
  collect(report);
}

void ContactStage::access(std::span<const WorldPart> parts) {
  access_.resize(parts.size());
  parallel_for(
      parts.size(),
      [&](std::size_t p) {
        PartAccess& a = access_[p];
        a.bounded = {interface_of<DistanceBound>(*parts[p].body), parts[p].index};
        const PosedShape* solid = solid_of(*parts[p].body, parts[p].index);
        a.solid.solid = solid != nullptr ? solid->known_distance() : nullptr;
        a.posed = solid;
        if (a.is_solid()) a.solid.pose = solid->pose();
        a.solid.by_distances = a.is_solid() && a.solid.solid->tells_direction();
        a.immobile = is_fixed(parts[p]);
      },
      64);
}

CubeSide ContactStage::side_of(std::int32_t part, const Candidate& c) const {
  CubeSide side = access_[part].solid;
  if (side.solid == nullptr || !(c.averaged || (c.level > 0 && average_))) return side;
  using Averaged = PosedShape::Averaged;
  side.solid = access_[part].posed->known_distance_averaged(c.pair.w, c.averaged ? Averaged::All : Averaged::Detailed);
  side.by_distances = side.by_distances && side.solid->tells_direction();
  return side;
}

void ContactStage::find_presence(std::span<const WorldPart> parts, double ramp, StepReport& report) {
  parallel_for(layer_count_, [&](std::size_t l) {
    Layer& layer = layers_[l];
    const WorldPart& part = parts[layer.part];
    const ProfileScope scope("presence", *part.body);
    if (const auto* fine = interface_of<OctantPresence>(*part.body)) {
      fine->octant_presence(part.index, layer.h, ramp * layer.h, layer.region, layer.present);
    } else {
      std::vector<TileKey> tiles;
      part.body->presence(part.index, layer.h, ramp * layer.h, layer.region.inflated(layer.h), tiles);
      for (const TileKey& t : tiles) layer.present.push_back({t, kAllOctants});
    }
    sort_unique(layer.present);
  });
  for (std::size_t l = 0; l < layer_count_; ++l)
    report.tiles_present += static_cast<std::int64_t>(layers_[l].present.size());
}

void ContactStage::refine(const WorldOptions& options) {
  parallel_for(candidate_count_, [&](std::size_t i) {
    Candidate& c = candidates_[i];
    if (c.layer_a < 0 && c.layer_b < 0) return;
    BoundedPart pa = access_[c.pair.part_a].bounded, pb = access_[c.pair.part_b].bounded;
    // An averaged density is no ramp of the distance, but zero beyond half a ramp from the surface.
    if (c.level > 0 && pa.body != nullptr) pb.body = nullptr;
    const std::vector<OctantTile>& one = layers_[c.layer_a >= 0 ? c.layer_a : c.layer_b].present;
    const std::vector<OctantTile>& other = layers_[c.layer_b >= 0 ? c.layer_b : c.layer_a].present;
    const Aabb region = c.region.inflated(kDensityRounding * c.pair.h);
    const TileRange range = tiles_meeting(region, c.pair.h);
    const std::vector<OctantTile>& few = one.size() < other.size() ? one : other;
    const std::vector<OctantTile>& many = one.size() < other.size() ? other : one;
    for (const OctantTile& t : few) {
      if (!inside(t.tile, range)) continue;
      Octants octants = &few != &many ? t.octants & octants_on(many, t.tile) : t.octants;
      if (octants != 0) octants &= octants_meeting(region, t.tile, c.pair.h);
      if (octants != 0) octants &= octants_with_room(pa, pb, c.pair, t.tile);
      if (octants != 0) c.tiles.push_back(t.tile), c.octants.push_back(octants);
    }
  });
  const auto for_layers = [&](const auto& f) {
    for (std::size_t i = 0; i < candidate_count_; ++i)
      for (const std::int32_t l : {candidates_[i].layer_a, candidates_[i].layer_b})
        if (l >= 0) f(layers_[l], candidates_[i]);
  };
  for_layers([](Layer& l, const Candidate& c) { l.needed.insert(l.needed.end(), c.tiles.begin(), c.tiles.end()); });
  std::size_t total = 0;
  for (std::size_t l = 0; l < layer_count_; ++l) {
    sort_unique(layers_[l].needed);
    layers_[l].octants.assign(layers_[l].needed.size(), 0);
    layers_[l].first_block = total;
    total += layers_[l].needed.size();
  }
  for_layers([](Layer& l, const Candidate& c) {
    for (std::size_t t = 0; t < c.tiles.size(); ++t) l.octants[index_of(l.needed, c.tiles[t])] |= c.octants[t];
  });
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
    const ProfileScope scope("rasterize", *part.body);
    profile_bytes(static_cast<double>(blocks.size_bytes()));
    for (std::size_t t = 0; t < blocks.size(); ++t) blocks[t].octants = layer.octants[t];
    // Solids average themselves, and so do parts without a finer level.
    if (layer.level > 0 && average_ && access_[layer.part].posed == nullptr)
      return rasterize_averaged(*part.body, part.index, {layer.h, ramp, layer.level}, layer.needed, blocks);
    part.body->rasterize(part.index, layer.h, ramp * layer.h, layer.needed, blocks);
  });
  for (std::size_t l = 0; l < layer_count_; ++l) report.tiles += static_cast<std::int64_t>(layers_[l].needed.size());
  for (std::size_t l = 0; l < layer_count_; ++l)
    for (const Octants o : layers_[l].octants) report.voxels += std::popcount(o) * kOctantNodes;
}

void ContactStage::plan_work() {
  work_count_ = 0;
  for (std::size_t i = 0; i < candidate_count_; ++i) {
    const Candidate& c = candidates_[i];
    const bool solids = c.layer_a < 0 && c.layer_b < 0;
    for (std::size_t t = 0; t < (solids ? 1 : c.tiles.size()); t += kTilesOfWork) {
      if (work_count_ == work_.size()) work_.emplace_back();
      Work& w = work_[work_count_++];
      w.candidate = i, w.begin = t, w.end = std::min(c.tiles.size(), t + kTilesOfWork);
      w.finds.clear(), w.roundness = 1.0;
    }
  }
}

void ContactStage::search(Work& work) const {
  const Candidate& c = candidates_[work.candidate];
  const double h = c.pair.h;
  if (c.layer_a < 0 && c.layer_b < 0) {
    const Vec3i lo = (c.region.lo / h).array().ceil().cast<int>(), hi = (c.region.hi / h).array().floor().cast<int>();
    const CubeSide a = side_of(c.pair.part_a, c), b = side_of(c.pair.part_b, c);
    if ((lo.array() <= hi.array()).all()) find_between_solids(a, b, c.pair, {lo, hi}, work.finds);
    carry_to_edges(a, b, h, work.finds.contacts);
    work.roundness = roundness(a, b, h, work.finds.contacts);
    // Of two that move the rounder one rolls on the other.
    const bool still_a = access_[c.pair.part_a].immobile, still_b = access_[c.pair.part_b].immobile;
    const double more_b = still_a ? 1.0 : still_b ? -1.0 : rounder(b, a, h, work.finds.contacts);
    center_on_least_gap(a, b, more_b > 0.0 ? b : a, std::abs(more_b), h, work.finds.contacts);
    return;
  }
  CubeSide a = side_of(c.pair.part_a, c), b = side_of(c.pair.part_b, c);
  const auto take_block = [&](std::int32_t l, const TileKey& tile, CubeSide& side, Octants& octants) {
    if (l < 0) return;
    side.tile = tile;
    side.block = &blocks_[layers_[l].first_block + index_of(layers_[l].needed, tile)];
    octants &= side.block->octants;
  };
  for (std::size_t t = work.begin; t < work.end; ++t) {
    Octants octants = c.octants[t];
    take_block(c.layer_a, c.tiles[t], a, octants), take_block(c.layer_b, c.tiles[t], b, octants);
    find_in_tile(a, b, c.pair, c.tiles[t], octants, work.finds);
  }
}

void ContactStage::collect(StepReport& report) {
  contacts_.pairs.clear();
  contacts_.link_pairs = 0, contacts_.link_point_b.clear();
  pieces_.clear();
  active_known_ = false;
  std::size_t last = candidate_count_;
  for (std::size_t i = 0; i < work_count_; ++i) {
    const Work& w = work_[i];
    const Candidate& c = candidates_[w.candidate];
    report.voxels += w.finds.nodes;
    report.tiles += static_cast<std::int64_t>(w.finds.boxes.size()) * ((c.layer_a < 0) + (c.layer_b < 0));
    if (w.finds.contacts.empty() && w.finds.engulfed == 0) continue;
    if (w.candidate != last) contacts_.pairs.push_back(c.pair);
    contacts_.pairs.back().roundness = w.roundness;
    last = w.candidate;
    pieces_.push_back({contacts_.pairs.size() - 1, &w.finds});
  }
  gather(pieces_, contacts_);
  contacts_.engulfed += rigid_.engulfed();
  rigid_.count_work(report);
}

std::span<const std::pair<TileKey, double>> ContactStage::active_tiles() const {
  if (active_known_) return active_;
  active_known_ = true;
  active_.clear();
  std::vector<std::pair<NodeBox, double>> boxes;
  for (std::size_t i = 0; i < work_count_; ++i)
    for (const NodeBox& box : work_[i].finds.boxes) boxes.emplace_back(box, candidates_[work_[i].candidate].pair.h);
  rigid_.append_boxes(boxes);
  const auto tile_of = [](int node) { return tile_of_node(node); };
  for (const auto& [box, h] : boxes) {
    const Vec3i first = box.lo.unaryExpr(tile_of), last = box.hi.unaryExpr(tile_of);
    for (int k = first.z(); k <= last.z(); ++k)
      for (int j = first.y(); j <= last.y(); ++j)
        for (int i = first.x(); i <= last.x(); ++i) active_.emplace_back(TileKey{i, j, k}, h);
  }
  std::sort(active_.begin(), active_.end(), [](const auto& s, const auto& t) {
    return s.second != t.second ? s.second < t.second : s.first < t.first;
  });
  active_.erase(std::unique(active_.begin(), active_.end()), active_.end());
  return active_;
}

}  // namespace brim
