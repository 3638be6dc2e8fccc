#include "brim/world/fill_stage.h"

#include <algorithm>
#include <cmath>

#include "brim/body/posed_shape.h"
#include "brim/body/solid_of.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/math/ramp.h"
#include "brim/raster/trilinear.h"
#include "brim/world/part_filter.h"

namespace brim {

namespace {

constexpr std::size_t kGrain = 512;
/// Step of central differences of a distance, relative to the reach.
constexpr double kDifference = 1e-3;
/// Distance, relative to the gap, up to which a density gives a distance: beyond it a meshless body's is wrong.
constexpr double kReadable = 1.6;
/// Step of second differences, relative to the gap of the layer at a surface.
constexpr double kBendWidth = 0.6;

const Filling* filling(const WorldPart& p) { return p.info.conforming ? interface_of<Filling>(*p.body) : nullptr; }

bool inside(const Aabb& box, const Vec3& x) {
  return (x.array() >= box.lo.array()).all() && (x.array() <= box.hi.array()).all();
}

/// The tile whose own nodes contain the cell of x; node: its lowest corner within the tile.
TileKey tile_of(const Vec3& x, double h, Vec3i& node) {
  TileKey t;
  std::int32_t* key[3] = {&t.x, &t.y, &t.z};
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::int64_t>(std::floor(x[a] / h));
    const std::int64_t tile = tile_of_node(i);
    *key[a] = static_cast<std::int32_t>(tile);
    node[a] = static_cast<int>(i - tile * kTileSize);
  }
  return t;
}

}  // namespace

bool fills(const WorldPart& a, const WorldPart& b) {
  return a.info.conforming != b.info.conforming && (filling(a) != nullptr || filling(b) != nullptr);
}

void FillStage::find(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts,
                     const WorldOptions& options, PartFilter& filter, ContactSet& set) {
  filler_.assign(bodies.size(), {});
  first_ = set.size();
  normal_.clear(), seen_.clear();
  for (std::size_t f = 0; f < parts.size(); ++f) {
    if (filling(parts[f]) == nullptr) continue;
    Filler& filler = filler_[parts[f].body_index];
    filler.body = dynamic_cast<Filling*>(bodies[parts[f].body_index].get());
    filler.begin = normal_.size();
    const ProfileScope scope("fill", *parts[f].body);
    const auto places = filler.body->fill_places();
    const double reach = filler.body->fill_reach();
    const Aabb box = parts[f].body->bounds(parts[f].index).inflated(reach);
    for (std::size_t o = 0; o < parts.size(); ++o) {
      if (o == f || !fills(parts[f], parts[o]) || !rules_allow(parts[f], parts[o]) ||
          !box.overlaps(parts[o].body->bounds(parts[o].index)))
        continue;
      const double h = std::min(parts[f].h, parts[o].h);
      found_.clear();
      const PosedShape* solid = solid_of(*parts[o].body, parts[o].index);
      if (solid != nullptr && solid->known_distance() != nullptr)
        find_in_solid(*solid, parts[o].body->bounds(parts[o].index).inflated(reach), *filler.body);
      else
        find_on_grid(parts[o], h, box, *filler.body);
      if (PartFilter::concerns(parts[f], parts[o]))
        std::erase_if(found_, [&](const Found& s) {
          return !filter.touch(parts[f], parts[o], places[s.element] - s.distance * s.n);
        });
      if (found_.empty()) continue;
      const bool fluid_first = f < o;
      ContactPair pair{static_cast<std::int32_t>(std::min(f, o)),
                       static_cast<std::int32_t>(std::max(f, o)),
                       h,
                       options.ramp_voxels * h,
                       0.0,
                       set.size(),
                       set.size() + found_.size()};
      std::size_t c = set.size();
      set.resize(pair.end);
      for (const Found& s : found_) {
        Contact contact{};
        // At the element, not at the surface: nothing slips when both rotate together, and drag and friction have no
        // torque of their own. Pressure acts along n, the same from either place.
        contact.point = places[s.element];
        contact.node = (contact.point / h).array().round().cast<int>();
        contact.depth = static_cast<float>(filler.body->fill_gap() - s.distance);
        const Vec3 slope = -s.n / filler.body->fill_gap();
        (fluid_first ? contact.gradient_b : contact.gradient_a) = slope.cast<float>();
        (fluid_first ? contact.source_a : contact.source_b) = Filling::source_of(s.element);
        (fluid_first ? contact.source_b : contact.source_a) = s.source;
        set.set(c++, contact);
        normal_.push_back(fluid_first ? s.n : Vec3(-s.n));
        seen_.push_back({s.element, static_cast<std::int32_t>(o), s.distance, s.n, s.bend});
      }
      set.pairs.push_back(pair);
    }
    filler.end = normal_.size();
    filler.body->see(std::span(seen_).subspan(filler.begin, filler.end - filler.begin));
  }
}

void FillStage::find_in_solid(const PosedShape& solid, const Aabb& bounds, const Filling& filler) {
  const auto places = filler.fill_places();
  const double reach = filler.fill_reach(), step = kDifference * reach;
  piece_.resize((places.size() + kGrain - 1) / kGrain);
  const Shape& shape = solid.shape();
  const Pose& pose = solid.pose();
  const KnownDistance& known = *solid.known_distance();
  parallel_for(piece_.size(), [&](std::size_t b) {
    std::vector<Found>& out = piece_[b];
    out.clear();
    for (std::size_t i = b * kGrain; i < std::min(places.size(), (b + 1) * kGrain); ++i) {
      if (!inside(bounds, places[i])) continue;
      const Vec3 p = pose.to_local(places[i]);
      if (known.least_distance(p) > reach) continue;
      const double d = shape.distance(p);
      if (!(d < reach)) continue;
      Vec3 n;
      for (int a = 0; a < 3; ++a) {
        const Vec3 e = step * Vec3::Unit(a);
        n[a] = shape.distance(p + e) - shape.distance(p - e);
      }
      const double length = n.norm();
      if (!(length > 0.0)) continue;
      // Second differences over a width that resolves edges.
      const double wide = kBendWidth * filler.fill_gap();
      double bend = -6.0 * d;
      for (int a = 0; a < 3; ++a) {
        const Vec3 e = wide * Vec3::Unit(a);
        bend += shape.distance(p + e) + shape.distance(p - e);
      }
      out.push_back({static_cast<std::int32_t>(i), d, bend / (wide * wide), pose.rotation * (n / length), 0});
    }
  });
  for (const auto& out : piece_) found_.insert(found_.end(), out.begin(), out.end());
}

void FillStage::find_on_grid(const WorldPart& part, double h, const Aabb& region, const Filling& filler) {
  const auto places = filler.fill_places();
  const double reach = kReadable * filler.fill_gap();
  // Distances are read from the density's ramp, which must extend over the whole reach.
  const double w = std::max(3.0 * h, 2.0 * reach + h);
  const Aabb bounds = part.body->bounds(part.index).inflated(0.5 * w).intersection(region);
  present_.clear(), binned_.clear();
  part.body->presence(part.index, h, w, bounds, present_);
  sort_unique(present_);
  Vec3i node;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!inside(bounds, places[i])) continue;
    const TileKey t = tile_of(places[i], h, node);
    if (std::binary_search(present_.begin(), present_.end(), t)) binned_.emplace_back(t, static_cast<std::int32_t>(i));
  }
  if (binned_.empty()) return;
  std::sort(binned_.begin(), binned_.end());
  tiles_.clear(), first_in_tile_.clear();
  for (std::size_t i = 0; i < binned_.size(); ++i)
    if (i == 0 || binned_[i].first != binned_[i - 1].first)
      tiles_.push_back(binned_[i].first), first_in_tile_.push_back(i);
  first_in_tile_.push_back(binned_.size());
  const auto blocks = rasterize_whole(part, h, w, tiles_, blocks_);

  piece_.resize(tiles_.size());
  parallel_for(tiles_.size(), [&](std::size_t t) {
    std::vector<Found>& out = piece_[t];
    out.clear();
    const DensityBlock& block = blocks[t];
    for (std::size_t k = first_in_tile_[t]; k < first_in_tile_[t + 1]; ++k) {
      const std::int32_t i = binned_[k].second;
      Vec3i lo;
      tile_of(places[i], h, lo);
      const Vec3 f = places[i] / h - (places[i] / h).array().floor().matrix();
      // Trilinear in the distances; the source of the fullest corner.
      double best = 0.0;
      std::int32_t source = -1;
      const auto [d, n] = trilinear(f, h, [&](int a, int b, int c) {
        const int at = block_index(lo[0] + a + kHalo, lo[1] + b + kHalo, lo[2] + c + kHalo);
        const double rho = block.rho[at];
        if (rho > best && block.source[at] >= 0) best = rho, source = block.source[at];
        return ramp_inverse(rho, w);
      });
      const double length = n.norm();
      if (!(d < reach) || !(best > 0.0) || !(length > 1e-6)) continue;
      out.push_back({i, d, 0.0, n / length, source});
    }
  });
  for (const auto& out : piece_) found_.insert(found_.end(), out.begin(), out.end());
}

void FillStage::begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                      std::span<const double> v, std::span<const Vec3> velocity_a, std::span<const Vec3> velocity_b,
                      double dt, Penalty& response) {
  dt_ = dt;
  const std::size_t n = normal_.size();
  start_push_.resize(n), start_change_.resize(n), load_.resize(n), rate_.resize(n), push_.resize(n);
  start_stiffness_.assign(first_v.back(), 0.0);
  first_v_.assign(first_v.begin(), first_v.end());
  for (std::size_t i = 0; i < n; ++i) see(first_ + i, velocity_a[first_ + i] - velocity_b[first_ + i]);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Filler& f = filler_[b];
    if (f.body == nullptr) continue;
    const auto mine = [&](auto& x) { return std::span(x).subspan(f.begin, f.end - f.begin); };
    f.body->foresee(dt, v.subspan(first_v[b], first_v[b + 1] - first_v[b]), mine(rate_));
    f.body->press(mine(start_push_));
    f.body->apply_stiffness_seeing(v.subspan(first_v[b], first_v[b + 1] - first_v[b]), mine(rate_),
                                   std::span(start_stiffness_).subspan(first_v[b], first_v[b + 1] - first_v[b]),
                                   mine(start_change_));
    for (std::size_t k = f.begin; k < f.end; ++k) {
      load_[k] = start_push_[k] + dt * start_change_[k];
      response.set_pressed(first_ + k, f.body->fill_stiffness(k - f.begin, dt), f.body->fill_drag(k - f.begin));
    }
  }
  give_loads(response);
}

void FillStage::add_start_stiffness(std::size_t body, std::span<double> y) const {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += start_stiffness_[first_v_[body] + i];
}

void FillStage::add_right_hand_side(std::span<Vec3> force) const {
  for (std::size_t k = 0; k < normal_.size(); ++k)
    force[first_ + k] += (start_push_[k] + dt_ * start_change_[k]) * normal_[k];
}

void FillStage::apply_system(std::size_t body, std::span<const double> x, std::span<double> y) const {
  const Filler& f = filler_[body];
  f.body->apply_system_seeing(x, std::span<const double>(rate_).subspan(f.begin, f.end - f.begin), y,
                              std::span(push_).subspan(f.begin, f.end - f.begin));
}

void FillStage::finish(std::span<const std::size_t> first_v, std::span<const double> delta,
                       std::span<const Vec3> contact_delta) {
  for (std::size_t k = 0; k < normal_.size(); ++k) see(first_ + k, contact_delta[first_ + k]);
  for (std::size_t b = 0; b < filler_.size(); ++b) {
    if (filler_[b].body == nullptr) continue;
    const std::size_t n = first_v[b + 1] - first_v[b];
    scratch_.assign(n, 0.0);
    apply_system(b, delta.subspan(first_v[b], n), scratch_);
  }
  for (std::size_t k = 0; k < normal_.size(); ++k) load_[k] = start_push_[k] + dt_ * start_change_[k] + push_[k] / dt_;
}

void FillStage::add_forces(std::span<Vec3> force) const {
  for (std::size_t k = 0; k < normal_.size(); ++k) force[first_ + k] += load_[k] * normal_[k];
}

void FillStage::give_loads(Penalty& response) const {
  for (std::size_t k = 0; k < normal_.size(); ++k) response.set_load(first_ + k, load_[k]);
}

}  // namespace brim
