#include "brim/world/matter_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "brim/body/loose_nodes.h"
#include "brim/body/material_points.h"
#include "brim/body/matter_sources.h"
#include "brim/body/posed_shape.h"
#include "brim/body/solid_of.h"
#include "brim/body/spinning_balls.h"
#include "brim/core/error.h"

namespace brim {

namespace {

/// Smallest density of a node that counts as material.
constexpr double kMatter = 0.05;
/// Maximum number of rounds to project a point onto the middle of a sheet or rod: each reduces its offset to two
/// thirds.
constexpr int kRounds = 120;
/// Offset relative to the step at which it counts as on the middle.
constexpr double kOnMiddle = 1e-10;
/// [voxels] distance from the requested point within which a place is held instead of it.
constexpr double kBeside = 2.0;
/// [voxels] error of the vertices shown, which are single precision.
constexpr double kVertexError = 1e-3;

/// The sources of the nodes nearest to points, −1 without material nearby.
std::vector<std::int32_t> nearest_sources(const WorldPart& part, double w, std::span<const Vec3> x) {
  const double h = part.h;
  std::map<TileKey, std::size_t> place;
  const auto for_nodes = [&](const Vec3& p, const auto& f) {
    const Vec3i lo = (p / h).array().floor().cast<int>() - 1;
    for (int k = 0; k < 4; ++k)
      for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) {
          const Vec3i node = lo + Vec3i(i, j, k);
          f(node, TileKey{tile_of_node(node[0]), tile_of_node(node[1]), tile_of_node(node[2])});
        }
  };
  for (const Vec3& p : x) for_nodes(p, [&](const Vec3i&, const TileKey& t) { place.emplace(t, 0); });
  std::vector<TileKey> tiles;
  for (auto& [t, i] : place) i = tiles.size(), tiles.push_back(t);
  std::vector<DensityBlock> blocks(tiles.size());
  part.body->rasterize(part.index, h, w, tiles, blocks);
  std::vector<std::int32_t> source;
  for (const Vec3& p : x) {
    double least = std::numeric_limits<double>::infinity();
    std::int32_t best = -1;
    for_nodes(p, [&](const Vec3i& node, const TileKey& t) {
      const DensityBlock& block = blocks[place.at(t)];
      const int at = block_index(node[0] - t.x * kTileSize + kHalo, node[1] - t.y * kTileSize + kHalo,
                                 node[2] - t.z * kTileSize + kHalo);
      const double d = (h * node.cast<double>() - p).squaredNorm();
      if (!(block.rho[at] > kMatter) || block.source[at] < 0 || !(d < least)) return;
      least = d, best = block.source[at];
    });
    source.push_back(best);
  }
  return source;
}

/// Node positions in the layout of velocities, so that a body's map gives positions of points.
std::vector<double> as_velocities(const Body& body, std::span<const double> q) {
  const std::size_t per_node = velocities_per_node(body);
  std::vector<double> out(per_node * (q.size() / 3), 0.0);
  for (std::size_t i = 0; i < q.size(); ++i) out[per_node * (i / 3) + i % 3] = q[i];
  return out;
}

Vec3 nearest_vertex(const Body& body, const Vec3& x) {
  std::vector<Vec3f> vertex(body.display().vertices);
  body.display_positions(vertex);
  Vec3 best = x;
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3f& v : vertex)
    if (const double d = (v.cast<double>() - x).squaredNorm(); d < least) least = d, best = v.cast<double>();
  return best;
}

/// Replacement of each point: itself if it is held, else the held point whose request is nearest; itself if there are
/// none.
std::vector<std::size_t> stand_ins(std::span<const Vec3> wanted, std::span<const std::uint8_t> is_held) {
  std::vector<std::size_t> held, out(wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i)
    if (is_held[i] != 0) held.push_back(i);
  std::iota(out.begin(), out.end(), 0);
  for (std::size_t i = 0; i < wanted.size() && !held.empty(); ++i)
    if (is_held[i] == 0)
      out[i] = *std::min_element(held.begin(), held.end(), [&](std::size_t c, std::size_t d) {
        return (wanted[c] - wanted[i]).squaredNorm() < (wanted[d] - wanted[i]).squaredNorm();
      });
  return out;
}

InputError holds_nothing(const WorldPart& part) {
  return InputError(fmt::format("'{}' ({}) has no points that a link can hold", part.body->name(), part.body->kind()));
}

/// Places of a body of nodes that its map reproduces, J q = x, one per requested point.
struct HeldPlaces {
  std::vector<Vec3> x;
  std::vector<std::int32_t> source;
  std::vector<std::uint8_t> is_held;  ///< 0 where no place was found near the request

  bool most_held() const {
    return 2 * std::count(is_held.begin(), is_held.end(), 1) >= static_cast<std::ptrdiff_t>(x.size());
  }
};

/// The sources of the material nearest to points. Those without are moved to the nearest vertex.
std::vector<std::int32_t> find_sources(const WorldPart& part, double w, std::vector<Vec3>& x) {
  std::vector<std::int32_t> source = nearest_sources(part, w, x);
  if (std::count(source.begin(), source.end(), -1) > 0) {
    for (std::size_t i = 0; i < x.size(); ++i)
      if (source[i] < 0) x[i] = nearest_vertex(*part.body, x[i]);
    source = nearest_sources(part, w, x);
    if (std::count(source.begin(), source.end(), -1) > 0) throw holds_nothing(part);
  }
  if (const auto* matter = dynamic_cast<const MatterSources*>(part.body))
    for (std::int32_t& s : source) s = matter->source_of_matter(s);
  return source;
}

/// Maps of volumes reproduce the requested point. One with an offset, of sheets, rods and grains, gives J q beside it;
/// without offset, on the middle, it gives the point itself. A place counts as held within two voxels of the request,
/// or if no vertex is nearer to it, as for the middle of what is thick.
/// @param q  in the layout of velocities
HeldPlaces places_near(const WorldPart& part, double w, std::span<const double> q, std::vector<Vec3> wanted) {
  HeldPlaces out;
  out.source = find_sources(part, w, wanted);
  out.x = wanted;
  out.is_held.assign(wanted.size(), 0);
  std::unique_ptr<Map> map;
  std::vector<std::size_t> moving(wanted.size());
  std::iota(moving.begin(), moving.end(), 0);
  for (int round = 0; round < kRounds && !moving.empty(); ++round) {
    std::vector<Vec3> at(moving.size()), next(moving.size());
    std::vector<std::int32_t> source(moving.size());
    for (std::size_t k = 0; k < moving.size(); ++k) at[k] = out.x[moving[k]], source[k] = out.source[moving[k]];
    part.body->make_map(part.index, at, source, map);
    map->apply(q, next);
    std::vector<std::size_t> still;
    for (std::size_t k = 0; k < moving.size(); ++k) {
      if (!next[k].allFinite()) throw holds_nothing(part);
      const Vec3 offset = next[k] - at[k];
      out.is_held[moving[k]] = offset.norm() <= kOnMiddle * part.h ? 1 : 0;
      if (out.is_held[moving[k]] != 0) continue;
      out.x[moving[k]] += offset / 3.0;
      still.push_back(moving[k]);
    }
    moving = std::move(still);
  }
  for (std::size_t i = 0; i < wanted.size(); ++i)
    if (const double d = (out.x[i] - wanted[i]).norm(); out.is_held[i] != 0 && d > kBeside * part.h)
      out.is_held[i] = d <= (nearest_vertex(*part.body, wanted[i]) - wanted[i]).norm() + kVertexError * part.h ? 1 : 0;
  return out;
}

}  // namespace

std::vector<Vec3> points_in(const Body& body, const std::function<bool(const Vec3&)>& region) {
  std::vector<Vec3f> vertex(body.display().vertices);
  body.display_positions(vertex);
  std::vector<Vec3> x;
  for (const Vec3f& v : vertex)
    if (region(v.cast<double>())) x.push_back(v.cast<double>());
  if (x.empty()) throw InputError(fmt::format("no point of '{}' lies in the region", body.name()));
  return x;
}

bool MatterPoints::takes_any(const WorldPart& part) {
  return solid_of(*part.body, part.index) != nullptr || dynamic_cast<const MaterialPoints*>(part.body) != nullptr;
}

std::size_t MatterPoints::nearest_part(std::span<const WorldPart> parts, const Vec3& x) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::size_t best = 0;
  std::pair<double, double> least = {kFar, kFar};
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const Aabb box = parts[p].body->bounds(parts[p].index);
    const PosedShape* solid = solid_of(*parts[p].body, parts[p].index);
    const std::pair<double, double> d = {(x - x.cwiseMax(box.lo).cwiseMin(box.hi)).norm(),
                                         solid != nullptr ? solid->distance_bound(x) : 0.0};
    if (d < least) least = d, best = p;
  }
  return best;
}

MatterPoints MatterPoints::of_space(std::vector<Vec3> x) {
  MatterPoints m;
  m.x_ = std::move(x);
  m.source_.assign(m.x_.size(), 0);
  return m;
}

MatterPoints MatterPoints::of_part(const WorldPart& part, double w, std::span<const double> q, std::vector<Vec3> x) {
  MatterPoints m;
  m.x_ = std::move(x);
  m.source_.assign(m.x_.size(), 0);
  if (const PosedShape* solid = solid_of(*part.body, part.index)) {
    m.means_ = Means::Solid;
    for (const Vec3& p : m.x_) m.local_.push_back(solid->pose().to_local(p));
    return m;
  }
  if (const auto* matter = dynamic_cast<const MaterialPoints*>(part.body)) {
    m.means_ = Means::Material;
    for (const Vec3& p : m.x_) m.local_.push_back(matter->material_at(part.index, p));
    return m;
  }
  if (const auto* loose = dynamic_cast<const LooseNodes*>(part.body)) {
    m.means_ = Means::Loose;
    const std::vector<Vec3> wanted = m.x_;
    for (const Vec3& p : m.x_) m.node_.push_back(loose->nearest_node(p));
    m.follow(part, q);
    std::vector<std::uint8_t> is_held;
    for (std::size_t i = 0; i < wanted.size(); ++i)
      is_held.push_back((m.x_[i] - wanted[i]).norm() <= kBeside * part.h ? 1 : 0);
    const std::vector<std::size_t> stand_in = stand_ins(wanted, is_held);
    const std::vector<std::int32_t> nearest = m.node_;
    for (std::size_t i = 0; i < nearest.size(); ++i) {
      m.node_[i] = nearest[stand_in[i]];
      m.source_[i] = loose->source_of_node(m.node_[i]);
    }
    m.follow(part, q);
    return m;
  }
  m.means_ = Means::Nodes;
  const bool nodes = q.size() % 3 == 0 && part.body->v_size() == velocities_per_node(*part.body) * (q.size() / 3);
  if (part.info.conforming || !nodes) throw holds_nothing(part);
  const std::vector<double> positions = as_velocities(*part.body, q);
  HeldPlaces found = places_near(part, w, positions, m.x_);
  if (!found.most_held()) {
    for (std::size_t i = 0; i < m.x_.size(); ++i)
      if (found.is_held[i] == 0) m.x_[i] = nearest_vertex(*part.body, m.x_[i]);
    found = places_near(part, w, positions, m.x_);
    if (!found.most_held()) throw holds_nothing(part);
  }
  // At the rim of a scan's material some points have no such place: their neighbours replace them.
  const std::vector<std::size_t> stand_in = stand_ins(m.x_, found.is_held);
  for (std::size_t i = 0; i < stand_in.size(); ++i)
    m.x_[i] = found.x[stand_in[i]], m.source_[i] = found.source[stand_in[i]];
  std::unique_ptr<Map> map;
  part.body->make_map(part.index, m.x_, m.source_, map);
  map->apply(positions, m.x_);
  m.map_ = std::move(map);
  return m;
}

void MatterPoints::follow(const WorldPart& part, std::span<const double> q) {
  if (means_ == Means::Solid) {
    const Pose& pose = solid_of(*part.body, part.index)->pose();
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] = pose.translation + pose.rotation * local_[i];
  } else if (means_ == Means::Material) {
    const auto* matter = dynamic_cast<const MaterialPoints*>(part.body);
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] = matter->position_of(part.index, local_[i]);
  } else if (means_ == Means::Loose) {
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] = Eigen::Map<const Vec3>(q.data() + 3 * std::size_t(node_[i]));
  } else if (means_ == Means::Nodes) {
    map_->apply(as_velocities(*part.body, q), x_);
  }
}

}  // namespace brim
