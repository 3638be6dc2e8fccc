#include <algorithm>
#include <atomic>
#include <cmath>

#include "brim/body/meeting_region.h"
#include "brim/core/error.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/world/contact_parameters.h"
#include "brim/world/contact_stage.h"
#include "brim/world/fill_stage.h"
#include "brim/world/fluid_coupling.h"
#include "brim/world/part_filter.h"

// The broad phase: pairs of parts that may touch, and the layers on which they are searched.

namespace brim {

namespace {

/// Smallest margin of pairs under rows. At contact the nodes next to a ball of two voxels, or to an edge, are up to a
/// quarter of a voxel away from both surfaces together, 0.1 on a ramp of 3 voxels.
constexpr double kRowMargin = 0.1;
/// The same when a part deforms: after a load on it ends it moves farther in a step than its speed predicts. From 0.01
/// to 0.05 pressed balls and cubes have the correct force; at 0 rows appear and vanish, and at 0.1 nodes too far from
/// the surfaces affect their patches.
constexpr double kSoftRowMargin = 0.03;

/// Largest margin: of what forces keep apart, gaps of 1.3 voxels on a ramp of 3; of rigid parts under rows, which may
/// move by two voxels before they meet, 2.25.
constexpr double kMostMargin = 0.4, kMostRowMargin = 0.85;

/// Number of boxes whose partners one thread searches at a time.
constexpr std::size_t kBoxesOfWork = 64;

bool one_conforms(const WorldPart& a, const WorldPart& b) { return a.info.conforming || b.info.conforming; }

/// [bytes] memory of a step per pair with overlapping boxes.
constexpr double kPairBytes = 300.0;

/// Tiles are numbered in 32 bits, and beyond 1e9 steps positions in double precision are inaccurate relative to a step.
/// @throws InputError  when the common region of two parts is farther from the origin
void require_near(const WorldPart& a, const WorldPart& b, const Aabb& region, double h) {
  const double far = std::max(region.lo.cwiseAbs().maxCoeff(), region.hi.cwiseAbs().maxCoeff());
  if (far > 1e9 * h)
    throw InputError(
        fmt::format("world: '{}' and '{}' meet {:.3g} m from the origin, too far for steps of {} m (at most 1e9 of "
                    "them); look for a speed, a position or a size that is too large",
                    a.body->name(), b.body->name(), far, h));
}

/// Largest number of tiles that presence may examine in the region of one part: seconds of work.
constexpr double kMostTiles = 2e8;

/// @throws InputError  when the region of a part is so large that the search would take too long
void require_few(const WorldPart& part, const Aabb& region, double h) {
  const Vec3 tiles = region.extent() / (kTileSize * h) + Vec3::Constant(2.0);
  if (tiles.prod() > kMostTiles)
    throw InputError(fmt::format(
        "world: what touches '{}' lies up to {:.3g} m apart, {:.1g} tiles at steps of {} m (at most {:.0g}); "
        "look for a speed or a position that is too large, or use a larger voxel_size",
        part.body->name(), region.extent().maxCoeff(), tiles.prod(), h, kMostTiles));
}

/// Limits the region of two parts of one body to what the body knows of it. False when they do not touch.
bool narrow(const WorldPart& a, const WorldPart& b, double ramp, double margin, int level, double h, Aabb& region) {
  const auto* body = interface_of<MeetingRegion>(*a.body);
  if (body == nullptr) return true;
  // The ramp of an averaged density is no ramp of the distance.
  const double beyond = 0.5 * ramp * h, gap = level > 0 ? 2.0 * beyond : widest_gap(margin) * ramp * h;
  const Aabb known = body->meeting_region(a.index, b.index, beyond + kDensityRounding * h, gap + kDensityRounding * h);
  region = region.intersection(known);
  return !region.empty();
}

}  // namespace

void ContactStage::refuse_crowd(const char* what, double most, double limit) {
  throw InputError(
      fmt::format("world: more than {:.3g} {} at one time, more than memory_limit = {:.1f} GB has room for; look for "
                  "bodies that lie "
                  "in one place, or use a larger voxel_size",
                  most, what, 1e-9 * limit));
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
        const auto vb = velocities_of(part, v, first_v);
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
  // The boxes are divided into blocks of fixed size, whose partners are found independently.
  near_.resize((n + kBoxesOfWork - 1) / kBoxesOfWork);
  std::atomic<std::size_t> found = 0;
  parallel_for(near_.size(), [&](std::size_t k) {
    std::vector<std::pair<std::int32_t, std::int32_t>>& near = near_[k];
    std::vector<std::int32_t> partners;
    near.clear();
    for (std::size_t i = k * kBoxesOfWork; i < std::min(n, (k + 1) * kBoxesOfWork); ++i) {
      if (static_cast<double>(found) > most) return;
      partners.clear();
      sweep_.partners(i, partners);
      const std::int32_t own = sweep_.at(i);
      for (const std::int32_t other : partners) near.emplace_back(std::min(own, other), std::max(own, other));
      found += partners.size();
    }
  });
  if (static_cast<double>(found) > most) refuse_crowd("pairs of bodies that may touch", most, memory_limit);
  first_touch_.assign(n + 1, 0);
  for (const auto& near : near_)
    for (const auto& pair : near) ++first_touch_[pair.first + 1];
  // Counting sort by the first part, then each part's own partners.
  for (std::size_t p = 0; p < n; ++p) first_touch_[p + 1] += first_touch_[p];
  touching_.resize(found);
  std::vector<std::int32_t> next(first_touch_.begin(), first_touch_.end() - 1);
  for (const auto& near : near_)
    for (const auto& pair : near) touching_[next[pair.first]++] = pair;
  parallel_for(
      n,
      [&](std::size_t p) { std::sort(touching_.begin() + first_touch_[p], touching_.begin() + first_touch_[p + 1]); },
      kBoxesOfWork);
}

double ContactStage::largest_speed(std::int32_t pa, std::int32_t pb) const {
  return (outline_[pa].velocity - outline_[pb].velocity).norm() + outline_[pa].spread + outline_[pb].spread;
}

void ContactStage::find_blows(std::span<const WorldPart> parts) {
  blow_.assign(parts.size(), 0.0);
  const auto gives_way = [&](std::int32_t p) { return !parts[p].solid && !is_fixed(parts[p]); };
  for (const auto& [pa, pb] : touching_) {
    const bool a = gives_way(pa), b = gives_way(pb);
    if (!(a || b) || one_conforms(parts[pa], parts[pb]) || !may_touch(parts[pa], parts[pb])) continue;
    const double speed = largest_speed(pa, pb);
    if (a) blow_[pa] = std::max(blow_[pa], speed);
    if (b) blow_[pb] = std::max(blow_[pb], speed);
  }
}

ContactStage::Meeting ContactStage::meet(std::span<const WorldPart> parts, std::int32_t pa, std::int32_t pb, double dt,
                                         const HeldPairs& held_before, const WorldOptions& options) const {
  const double ramp = options.ramp_voxels, fall = options.environment.gravity.norm() * dt;
  const WorldPart &a = parts[pa], &b = parts[pb];
  Meeting m;
  if (!may_touch(a, b) || fills(a, b) || flows_around(a, b)) return m;
  const bool held = rigid_.any() && rigid_.holds(pa, pb) && !PartFilter::concerns(a, b);
  const Aabb &box_a = held ? rigid_.box(pa) : outline_[pa].box, &box_b = held ? rigid_.box(pb) : outline_[pb].box;
  if (!box_a.overlaps(box_b)) return m;
  m.region = box_a.intersection(box_b);
  m.level = meeting_level(a, b);
  m.h = meeting_step(a, b);  // the finer of the two steps, at that level
  // Nodes whose gap may close within the step count as inactive contacts: by the speed of the two, or of a third part
  // that hits one of them, if this deforms.
  double speed = largest_speed(pa, pb);
  const bool rigid_rows = held || meet_by_rigid_rows(a, b, options);
  const double least = rigid_rows ? kRowMargin : meet_by_rows(a, b, options) ? kSoftRowMargin : 0.0;
  if (least == 0.0 && !one_conforms(a, b)) speed = std::max({speed, blow_[pa], blow_[pb]});
  m.margin = std::clamp(1.5 * (speed + fall) * dt / (ramp * m.h), least,
                        rigid_rows && !held_before.contains(pa, pb) ? kMostRowMargin : kMostMargin);
  if (!held && a.body == b.body && !narrow(a, b, ramp, m.margin, m.level, m.h, m.region)) return m;
  require_near(a, b, m.region, m.h);
  if (!held)
    m.how = Meeting::kSearched;
  else if (rigid_.leaves_room(pa, pb, widest_gap(m.margin) * ramp * m.h))
    m.how = Meeting::kHeld;
  return m;
}

void ContactStage::find_candidates(std::span<const WorldPart> parts, std::span<const double> v,
                                   std::span<const std::size_t> first_v, double dt, const HeldPairs& held_before,
                                   const WorldOptions& options) {
  const double ramp = options.ramp_voxels;
  for (std::size_t l = 0; l < layer_count_; ++l) {
    layers_[l].present.clear();
    layers_[l].needed.clear();
  }
  layer_count_ = candidate_count_ = 0;
  held_.clear();

  // The root of the hierarchy: boxes of whole parts.
  outline(parts, v, first_v, ramp);
  sweep_boxes(options.memory_limit);
  find_blows(parts);
  meeting_.resize(touching_.size());
  parallel_for(
      touching_.size(),
      [&](std::size_t i) {
        meeting_[i] = meet(parts, touching_[i].first, touching_[i].second, dt, held_before, options);
      },
      64);
  for (std::size_t i = 0; i < touching_.size(); ++i) {
    const auto [pa, pb] = touching_[i];
    const Meeting& m = meeting_[i];
    if (m.how == Meeting::kHeld) held_.push_back({pa, pb, m.h, ramp * m.h, m.margin, m.level});
    if (m.how != Meeting::kSearched) continue;
    if (candidate_count_ == candidates_.size()) candidates_.emplace_back();
    Candidate& c = candidates_[candidate_count_++];
    c.pair = ContactPair{pa, pb, m.h, ramp * m.h, m.margin, 0, 0};
    c.region = m.region;
    c.level = m.level;
    c.averaged = average_ && parts[pa].info.conforming != parts[pb].info.conforming;
    c.by_part = PartFilter::concerns(parts[pa], parts[pb]);
    c.tiles.clear(), c.octants.clear();
    // Parts that are not solids are averaged from samples at half the step.
    const auto level = [&](std::int32_t p) { return c.averaged && !parts[p].info.conforming ? 1 : m.level; };
    c.layer_a = access_[pa].is_solid() ? -1 : layer_of(pa, m.h, level(pa), m.region);
    c.layer_b = access_[pb].is_solid() ? -1 : layer_of(pb, m.h, level(pb), m.region);
  }
  for (std::size_t l = 0; l < layer_count_; ++l) require_few(parts[layers_[l].part], layers_[l].region, layers_[l].h);
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

}  // namespace brim
