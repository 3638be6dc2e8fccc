#include "brim/world/contact_stage.h"

#include <algorithm>
#include <atomic>
#include <bit>

#include "brim/body/posed_shape.h"
#include "brim/contact/face_edges.h"
#include "brim/contact/patch_center.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/core/stopwatch.h"
#include "brim/world/averaged_raster.h"
#include "brim/world/contact_parameters.h"
#include "brim/world/fill_stage.h"
#include "brim/world/part_filter.h"

namespace brim {

namespace {

/// Least margin of pairs that rows hold apart. At touch the nodes next to a ball of two voxels, or to an edge, are up
/// to a quarter of a voxel away from both surfaces together, which the ramp, 3 voxels wide, shows as 0.1.
constexpr double kRowMargin = 0.1;
/// The same where a part deforms: it moves farther in a step than its speed tells where a load on it ends. From 0.01 to
/// 0.05 balls and cubes that are pressed have the force that they should; at 0 rows come and go, and at 0.1 nodes that
/// are too far from the surfaces have a say in their patches.
constexpr double kSoftRowMargin = 0.03;

/// Index of the first element of a sorted list that equals the key; the key must be there.
std::size_t index_of(const std::vector<TileKey>& sorted, const TileKey& key) {
  return std::lower_bound(sorted.begin(), sorted.end(), key) - sorted.begin();
}

bool inside(const TileKey& t, const TileRange& r) {
  return t.x >= r.lo.x && t.x <= r.hi.x && t.y >= r.lo.y && t.y <= r.hi.y && t.z >= r.lo.z && t.z <= r.hi.z;
}

/// Sorts the tiles and joins the octants of those that are there more than once.
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

/// What a part's presence is on a tile; no octant where it is not there. @param sorted  by tile
Octants octants_on(const std::vector<OctantTile>& sorted, const TileKey& tile) {
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), tile,
                                   [](const OctantTile& s, const TileKey& t) { return s.tile < t; });
  return at != sorted.end() && at->tile == tile ? at->octants : Octants{0};
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

/// Own nodes of an octant.
constexpr std::int64_t kOctantNodes = std::int64_t{kTileSize} * kTileSize * kTileSize / 8;

/// Tiles of one piece of a search.
constexpr std::size_t kTilesOfWork = 16;

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

/// What a step keeps of a contact, of a pair whose boxes overlap, [bytes]; the first as measured between rigid boxes.
constexpr double kContactBytes = 1300.0, kPairBytes = 300.0;

[[noreturn]] void refuse_crowd(const char* what, double most, double limit) {
  throw InputError(
      fmt::format("world: more than {:.3g} {} at one time, more than memory_limit = {:.1f} GB has room for; look for "
                  "bodies that lie "
                  "in one place, or use a larger voxel_size",
                  most, what, 1e-9 * limit));
}

}  // namespace

void ContactStage::find(std::span<const WorldPart> parts, std::span<const double> v,
                        std::span<const std::size_t> first_v, double dt, const WorldOptions& options,
                        StepReport& report) {
  const auto seconds = [&](Phase p) -> double& { return report.seconds[static_cast<std::size_t>(p)]; };
  {
    const ScopedSeconds timer(seconds(Phase::Presence));
    access(parts);
    find_candidates(parts, v, first_v, dt, options);
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
  // Work past the limit is not begun.
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
  for (std::size_t p = 0; p < parts.size(); ++p) {
    PartAccess& a = access_[p];
    a.bounded = {dynamic_cast<const DistanceBound*>(parts[p].body), parts[p].index};
    const PosedShape* solid = a.bounded.body != nullptr ? a.bounded.body->solid(parts[p].index) : nullptr;
    a.solid.solid = solid != nullptr ? solid->known_distance() : nullptr;
    a.posed = solid;
    if (a.is_solid()) a.solid.pose = solid->pose();
    a.solid.by_distances = a.is_solid() && a.solid.solid->by_rows();
    a.immobile = is_fixed(parts[p]);
  }
}

void ContactStage::outline(std::span<const WorldPart> parts, std::span<const double> v,
                           std::span<const std::size_t> first_v, double ramp) {
  if (rigid_.any()) rigid_.follow(coarsest_level(parts));
  outline_.resize(parts.size());
  const double wide = std::ldexp(0.5 * ramp, coarsest_level(parts));
  parallel_for(
      parts.size(),
      [&](std::size_t p) {
        const WorldPart& part = parts[p];
        const auto vb = v.subspan(first_v[part.body_index], first_v[part.body_index + 1] - first_v[part.body_index]);
        Outline& o = outline_[p];
        o.box = part.body->bounds(part.index).inflated(wide * part.h);
        o.swept = o.box;
        if (rigid_.any() && rigid_.follows(static_cast<std::int32_t>(p)))
          o.swept.extend(rigid_.box(static_cast<std::int32_t>(p)));
        o.velocity = part.body->mean_velocity(part.index, vb);
        o.spread = part.body->relative_speed_bound(part.index, vb);
      },
      64);
}

void ContactStage::sweep_boxes(double memory_limit) {
  const double most = memory_limit / kPairBytes;
  const std::size_t n = outline_.size();
  swept_.clear();
  for (const Outline& o : outline_) swept_.push_back(o.swept);
  sweep_.build(swept_);
  near_.clear();
  first_touch_.assign(n + 1, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t own = sweep_.at(i);
    partners_.clear();
    sweep_.partners(i, partners_);
    for (const std::int32_t other : partners_) {
      if (static_cast<double>(near_.size()) > most) refuse_crowd("pairs of bodies that may touch", most, memory_limit);
      near_.emplace_back(std::min(own, other), std::max(own, other));
      ++first_touch_[near_.back().first + 1];
    }
  }
  // Ordered: sorted by the first part by counting, then each part's own.
  for (std::size_t p = 0; p < n; ++p) first_touch_[p + 1] += first_touch_[p];
  touching_.resize(near_.size());
  std::vector<std::int32_t> next(first_touch_.begin(), first_touch_.end() - 1);
  for (const auto& pair : near_) touching_[next[pair.first]++] = pair;
  for (std::size_t p = 0; p < n; ++p)
    std::sort(touching_.begin() + first_touch_[p], touching_.begin() + first_touch_[p + 1]);
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
  held_.clear();

  // The root of the hierarchy: boxes of whole parts.
  outline(parts, v, first_v, ramp);
  sweep_boxes(options.memory_limit);
  for (const auto& [pa, pb] : touching_) {
    const WorldPart &a = parts[pa], &b = parts[pb];
    if (!may_touch(a, b) || fills(a, b)) continue;
    const bool held = rigid_.any() && rigid_.holds(pa, pb) && !PartFilter::concerns(a, b);
    const Aabb &box_a = held ? rigid_.box(pa) : outline_[pa].box, &box_b = held ? rigid_.box(pb) : outline_[pb].box;
    if (!box_a.overlaps(box_b)) continue;
    const Aabb region = box_a.intersection(box_b);
    const int level = meeting_level(a, b);
    const double h = meeting_step(a, b);  // the finer of their two, seen at that level
    // Nodes whose gap may close within the step count as contacts that wait.
    const double speed =
        (outline_[pa].velocity - outline_[pb].velocity).norm() + outline_[pa].spread + outline_[pb].spread;
    const double least = held || meet_by_rigid_rows(a, b, options) ? kRowMargin
                         : meet_by_rows(a, b, options)             ? kSoftRowMargin
                                                                   : 0.0;
    const double margin = std::clamp(1.5 * (speed + fall) * dt / (ramp * h), least, 0.4);
    require_near(a, b, region, h);
    if (held) {
      if (rigid_.leaves_room(pa, pb, widest_gap(margin) * ramp * h))
        held_.push_back({pa, pb, h, ramp * h, margin, level});
      continue;
    }
    if (candidate_count_ == candidates_.size()) candidates_.emplace_back();
    Candidate& c = candidates_[candidate_count_++];
    c.pair = ContactPair{pa, pb, h, ramp * h, margin, 0, 0};
    c.region = region;
    c.level = level;
    c.by_part = PartFilter::concerns(a, b);
    c.tiles.clear(), c.octants.clear();
    c.layer_a = access_[pa].is_solid() ? -1 : layer_of(pa, h, level, region);
    c.layer_b = access_[pb].is_solid() ? -1 : layer_of(pb, h, level, region);
  }
  for (std::size_t l = 0; l < layer_count_; ++l) require_few(parts[layers_[l].part], layers_[l].region, layers_[l].h);
}

CubeSide ContactStage::side_of(std::int32_t part, const Candidate& c) const {
  CubeSide side = access_[part].solid;
  if (c.level > 0 && average_ && side.solid != nullptr)
    side.solid = access_[part].posed->known_distance_averaged(c.pair.w);
  return side;
}

std::int32_t ContactStage::layer_of(std::int32_t part, double h, int level, const Aabb& region) {
  for (std::size_t l = layer_count_; l-- > 0;)
    if (layers_[l].part == part && layers_[l].h == h && layers_[l].level == level) {
      layers_[l].region.extend(region);
      return static_cast<std::int32_t>(l);
    }
  if (layer_count_ == layers_.size()) layers_.emplace_back();
  Layer& layer = layers_[layer_count_];
  layer.part = part;
  layer.h = h;
  layer.level = level;
  layer.region = region;
  return static_cast<std::int32_t>(layer_count_++);
}

void ContactStage::find_presence(std::span<const WorldPart> parts, double ramp, StepReport& report) {
  parallel_for(layer_count_, [&](std::size_t l) {
    Layer& layer = layers_[l];
    const WorldPart& part = parts[layer.part];
    const ProfileScope scope("presence", *part.body);
    if (const auto* fine = dynamic_cast<const OctantPresence*>(part.body)) {
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
    // What is averaged is no ramp of the distance, but empty beyond half a ramp from the surface.
    if (c.level > 0 && pa.body != nullptr) pb.body = nullptr;
    const std::vector<OctantTile>& one = layers_[c.layer_a >= 0 ? c.layer_a : c.layer_b].present;
    const std::vector<OctantTile>& other = layers_[c.layer_b >= 0 ? c.layer_b : c.layer_a].present;
    const TileRange range = tiles_meeting(c.region.inflated(c.pair.h), c.pair.h);
    const std::vector<OctantTile>& few = one.size() < other.size() ? one : other;
    const std::vector<OctantTile>& many = one.size() < other.size() ? other : one;
    for (const OctantTile& t : few) {
      if (!inside(t.tile, range)) continue;
      Octants octants = &few != &many ? t.octants & octants_on(many, t.tile) : t.octants;
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
    // Solids average themselves, as does what has no finer level.
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
    // Only what rolls on something fixed: between two free bodies single points leave a residue of momentum.
    if (access_[c.pair.part_a].immobile || access_[c.pair.part_b].immobile) {
      work.roundness = roundness(a, b, h, work.finds.contacts);
      center_on_least_gap(a, b, access_[c.pair.part_a].immobile ? b : a, h, work.finds.contacts);
    }
    return;
  }
  CubeSide a = side_of(c.pair.part_a, c), b = side_of(c.pair.part_b, c);
  const auto take_block = [&](std::int32_t l, const TileKey& tile, CubeSide& side) {
    if (l < 0) return;
    side.tile = tile;
    side.block = &blocks_[layers_[l].first_block + index_of(layers_[l].needed, tile)];
  };
  for (std::size_t t = work.begin; t < work.end; ++t) {
    take_block(c.layer_a, c.tiles[t], a), take_block(c.layer_b, c.tiles[t], b);
    find_in_tile(a, b, c.pair, c.tiles[t], c.octants[t], work.finds);
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
  for (const auto& [box, h] : boxes)
    for (int corner = 0; corner < 8; ++corner) {
      const auto tile = [&](int axis) {
        const int node = corner >> axis & 1 ? box.hi[axis] : box.lo[axis];
        return node >= 0 ? node / kTileSize : -((kTileSize - 1 - node) / kTileSize);
      };
      active_.emplace_back(TileKey{tile(0), tile(1), tile(2)}, h);
    }
  std::sort(active_.begin(), active_.end(), [](const auto& s, const auto& t) {
    return s.second != t.second ? s.second < t.second : s.first < t.first;
  });
  active_.erase(std::unique(active_.begin(), active_.end()), active_.end());
  return active_;
}

}  // namespace brim
