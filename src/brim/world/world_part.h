#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/touch_rules.h"

namespace brim {

/// A part with its global number.
struct WorldPart {
  const Body* body = nullptr;
  int body_index = 0;
  int index = 0;   ///< within the body
  double h = 0.0;  ///< [m] its own grid step, h0 2^l
  PartInfo info;
  bool solid = false;         ///< it never moves, or it does not deform and the distance to it is known
  int level = 0;              ///< level of detail of its body in contact (Levels)
  bool still = false;         ///< set by Sleep: asleep, or fixed and not moving; always false when bodies do not sleep
  bool frozen = false;        ///< its body is frozen (World::freeze)
  TouchRules::Sides sides{};  ///< of the body's name
  const TouchRules* rules = nullptr;  ///< null: all may touch
};

/// True when nothing can move the part: no contact changes its velocity.
inline bool is_fixed(const WorldPart& p) { return p.frozen || p.body->immobile(); }

/// The velocities of the part's body.
/// @param v        of all bodies
/// @param first_v  of each body, and the end
inline std::span<const double> velocities_of(const WorldPart& p, std::span<const double> v,
                                             std::span<const std::size_t> first_v) {
  return v.subspan(first_v[p.body_index], first_v[p.body_index + 1] - first_v[p.body_index]);
}

/// [m/s] Upper bound of the speed of the part's material. @param vb  of its body
inline double speed_bound(const WorldPart& p, std::span<const double> vb) {
  return p.body->mean_velocity(p.index, vb).norm() + p.body->relative_speed_bound(p.index, vb);
}

/// The part's density on whole tiles. @param kept  storage; grows
inline std::span<const DensityBlock> rasterize_whole(const WorldPart& p, double h, double w,
                                                     std::span<const TileKey> tiles, std::vector<DensityBlock>& kept) {
  if (kept.size() < tiles.size()) kept.resize(tiles.size());
  const auto blocks = std::span(kept).first(tiles.size());
  for (DensityBlock& b : blocks) b.octants = kAllOctants;
  p.body->rasterize(p.index, h, w, tiles, blocks);
  return blocks;
}

/// False for pairs that rules or a link keep from touching.
inline bool rules_allow(const WorldPart& a, const WorldPart& b) {
  return a.rules == nullptr || a.rules->touch(a.sides, a.body_index, b.sides, b.body_index);
}

/// False for pairs that are not searched: nothing moves, or their body or the rules exclude contact.
inline bool may_touch(const WorldPart& a, const WorldPart& b) {
  if (a.body == b.body && !a.body->parts_collide(a.index, b.index)) return false;
  return !(a.still && b.still) && !(is_fixed(a) && is_fixed(b)) && rules_allow(a, b);
}

/// By how many levels two parts meet coarser than their own steps: the coarser of the two says, but neither becomes
/// thinner than two voxels, and fluids keep their own.
inline int meeting_level(const WorldPart& a, const WorldPart& b) {
  int level = std::max(a.level, b.level);
  if (level == 0 || a.info.conforming || b.info.conforming) return 0;
  const double h = std::min(a.h, b.h), thin = std::min(a.info.thickness, b.info.thickness);
  while (level > 0 && thin < (2.0 - 1e-9) * std::ldexp(h, level)) --level;
  return level;
}

/// [m] step at which two parts meet: the finer of their two, seen at that level.
inline double meeting_step(const WorldPart& a, const WorldPart& b) {
  return std::ldexp(std::min(a.h, b.h), meeting_level(a, b));
}

/// The coarsest level of any part: boxes that are to hold a ramp are widened by two to its power.
inline int coarsest_level(std::span<const WorldPart> parts) {
  int most = 0;
  for (const WorldPart& p : parts) most = std::max(most, p.level);
  return most;
}

}  // namespace brim
