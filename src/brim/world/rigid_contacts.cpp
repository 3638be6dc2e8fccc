#include "brim/world/rigid_contacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>

#include "brim/body/posed_shape.h"
#include "brim/body/solid_of.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/core/workspace_pool.h"
#include "brim/response/patch_normals.h"
#include "brim/response/solid_gap.h"
#include "brim/world/contact_parameters.h"

namespace brim {

namespace {

/// [bytes] memory of a step per row, with its pair: measured for 500,000 pairs of boxes.
constexpr double kRowBytes = 1800.0;

/// The part as a solid that moves as a whole, a rigid body or a link, or null.
const PosedShape* rigid_solid(const WorldPart& part) {
  const PosedShape* solid = solid_of(*part.body, part.index);
  return solid != nullptr && solid->known_distance() != nullptr ? solid : nullptr;
}

/// Least curvature of two surfaces together, over the larger of either, at which a hollow one of them is followed.
constexpr double kClearlyConvex = 0.2;

std::array<float, 3> pack(const Eigen::Matrix2d& m) {
  return {static_cast<float>(m(0, 0)), static_cast<float>(m(0, 1)), static_cast<float>(m(1, 1))};
}

/// A symmetric matrix without its negative eigenvalues.
Eigen::Matrix2d without_hollows(const Eigen::Matrix2d& b) {
  const double mean = 0.5 * (b(0, 0) + b(1, 1)), half = 0.5 * (b(0, 0) - b(1, 1)), spread = std::hypot(half, b(0, 1));
  if (mean >= spread) return b;
  if (mean + spread <= 0.0) return Eigen::Matrix2d::Zero();
  const double most = 0.5 * (mean + spread), x = most / spread;
  Eigen::Matrix2d m;
  m << most + x * half, x * b(0, 1), x * b(0, 1), most - x * half;
  return m;
}

/// The curvatures of both surfaces of a row, in tangents_of(n), [1/m]. They are kept as they are where together they
/// are clearly convex, as those of a ball in a bowl: the point then rolls as they say. Elsewhere the concave directions
/// of each count as flat.
void pack_bends(const Constraint::Bend& bend, RowPoint& row) {
  if (bend.a == Mat3::Zero() && bend.b == Mat3::Zero()) return;
  const Eigen::Matrix<double, 3, 2> t = tangents_of(row.normal);
  const Eigen::Matrix2d a = t.transpose() * bend.a * t, b = t.transpose() * bend.b * t;
  const Eigen::Matrix2d both = a + b;
  const double mean = 0.5 * (both(0, 0) + both(1, 1)), spread = std::hypot(0.5 * (both(0, 0) - both(1, 1)), both(0, 1));
  const bool fits = mean - spread > kClearlyConvex * std::max(a.norm(), b.norm());
  row.bend_a = pack(fits ? a : without_hollows(a)), row.bend_b = pack(fits ? b : without_hollows(b));
}

bool before(std::int32_t a, std::int32_t b, const RigidContacts::Touch& t) {
  return a != t.part_a ? a < t.part_a : b < t.part_b;
}

}  // namespace

/// Contacts of one pair during conversion to rows.
struct RigidContacts::Workspace {
  CubeFinds finds;
  ContactSet contacts;
  std::vector<Vec3> direction, normal;
  PatchNormals normals;
  Constraint rows;
};
struct RigidContacts::Workspaces : WorkspacePool<Workspace> {};

RigidContacts::RigidContacts() : workspaces_(std::make_unique<Workspaces>()) {}
RigidContacts::~RigidContacts() = default;

void RigidContacts::start(std::span<const WorldPart> parts, const ContactParameters& laws,
                          const WorldOptions& options) {
  class_.assign(parts.size(), -1), solid_.assign(parts.size(), nullptr);
  half_ramp_.assign(parts.size(), 0.0), reach_.assign(parts.size(), 0.0);
  side_.assign(parts.size(), {}), box_.assign(parts.size(), {});
  pairs_.clear(), kept_.clear();
  coarsest_ = 0;
  references_.reset(parts.size());
  most_rows_ = options.memory_limit / kRowBytes;
  std::map<std::tuple<std::string, double, double, Response>, std::int32_t> known;
  std::vector<std::size_t> example;
  finest_ = std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p < parts.size(); ++p) {
    finest_ = std::min(finest_, parts[p].h);
    half_ramp_[p] = 0.5 * options.ramp_voxels * parts[p].h;
    solid_[p] = rigid_solid(parts[p]);
    if (solid_[p] == nullptr) continue;
    side_[p].solid = solid_[p]->known_distance();
    reach_[p] = solid_[p]->reach(Vec3::Zero());
    if (reach_[p] > 0.0) reach_[p] += side_[p].solid->slack() + 1e-6 * finest_;
    const Material& m = parts[p].info.material;
    const auto [it, fresh] =
        known.try_emplace({m.name, m.friction, m.restitution, m.response}, static_cast<std::int32_t>(known.size()));
    if (fresh) example.push_back(p);
    class_[p] = it->second;
  }
  classes_ = static_cast<std::int32_t>(example.size());
  laws_.clear();
  any_ = false;
  for (const std::size_t a : example)
    for (const std::size_t b : example) {
      laws_.push_back(laws.constraint_between(parts[a], parts[b], options));
      laws_.back().rigid = true;  // solids do not deform, even if joints move them
      any_ = any_ || laws_.back().constrained;
    }
}

void RigidContacts::restore(std::span<const double> memory) {
  references_.restore(memory, class_.size());
  box_.assign(class_.size(), {});
  pairs_.clear(), kept_.clear();
}

void RigidContacts::follow(int coarsest) {
  if (coarsest != coarsest_) {
    for (double& r : half_ramp_) r = std::ldexp(r, coarsest - coarsest_);
    coarsest_ = coarsest;
    box_.assign(box_.size(), {});
  }
  for (std::size_t p = 0; p < solid_.size(); ++p) {
    if (solid_[p] == nullptr) continue;
    const std::uint64_t before = references_.stamp(p);
    references_.follow(p, solid_[p]->pose(), solid_[p]->shape().bounds(), reach_[p], finest_);
    if (references_.stamp(p) == before && !box_[p].empty()) continue;
    side_[p].pose = references_.pose(p);
    box_[p] = solid_[p]->shape().placed_bounds(side_[p].pose).inflated(half_ramp_[p]);
  }
}

CubeSide RigidContacts::side_of(std::int32_t part, const Touch& t) const {
  CubeSide side = side_[part];
  if (t.level > 0 && average_) side.solid = solid_[part]->known_distance_averaged(t.w, PosedShape::Averaged::Detailed);
  return side;
}

void RigidContacts::find(std::span<const Touch> touches, bool every_node, bool average) {
  average_ = average;
  std::swap(pairs_, kept_);
  pairs_.resize(touches.size());
  fresh_.clear();
  std::size_t next = 0;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const Touch& t = touches[i];
    while (next < kept_.size() && before(kept_[next].touch.part_a, kept_[next].touch.part_b, t)) ++next;
    if (next < kept_.size() && kept_[next].touch.part_a == t.part_a && kept_[next].touch.part_b == t.part_b)
      std::swap(pairs_[i], kept_[next++]);
    Pair& p = pairs_[i];
    const std::uint64_t a = references_.stamp(static_cast<std::size_t>(t.part_a)),
                        b = references_.stamp(static_cast<std::size_t>(t.part_b));
    // Stamps are unique to a part and never reused.
    const bool same = p.stamp_a == a && p.stamp_b == b && p.touch.margin == t.margin && p.touch.level == t.level;
    if (same) continue;
    p.touch = t, p.stamp_a = a, p.stamp_b = b;
    fresh_.push_back(i);
  }
  // Work beyond the limit is not started.
  std::atomic<std::int64_t> rows = 0;
  for (const std::size_t i : fresh_) pairs_[i].rows.clear();
  for (const Pair& p : pairs_) rows += static_cast<std::int64_t>(p.rows.size());
  parallel_for(
      fresh_.size(),
      [&](std::size_t i) {
        if (static_cast<double>(rows) > most_rows_) return;
        sample(pairs_[fresh_[i]], *workspaces_->borrow(), every_node);
        if (const auto found = static_cast<std::int64_t>(pairs_[fresh_[i]].rows.size()); found > 0) rows += found;
      },
      2);
  if (static_cast<double>(rows) > most_rows_)
    throw InputError(
        fmt::format("world: more than {:.3g} constraint rows at one time, more than memory_limit = {:.1f} GB has room "
                    "for; look for "
                    "bodies that lie in one place",
                    most_rows_, 1e-9 * kRowBytes * most_rows_));
  profile_count("rigid pairs sampled", static_cast<double>(fresh_.size()));
  profile_count("rigid pairs kept", static_cast<double>(touches.size() - fresh_.size()));
  contacts_ = engulfed_ = 0;
  for (const Pair& p : pairs_) contacts_ += p.contacts, engulfed_ += p.engulfed;
}

bool RigidContacts::apart(std::int32_t a, std::int32_t b, double gap) const {
  // d_a(x) + d_b(x) >= d_a(c) − |x − c| + |x − c| − reach at every x, c: origin of b.
  const CubeSide& side = side_[a];
  return reach_[b] > 0.0 && side.solid->least_distance(side.pose.to_local(side_[b].pose.translation)) > reach_[b] + gap;
}

bool RigidContacts::read_between(Pair& pair, const Aabb& region, double gap) const {
  const Touch& t = pair.touch;
  SolidGap between(side_of(t.part_a, t), side_of(t.part_b, t), t.h);
  if (!between.reads()) return false;
  const bool near = between.approach(region, gap, pair.deepest),
             found = near && between.find_rows(pair.deepest, gap, pair.rows);
  pair.nodes = between.readings();
  if (!found || pair.rows.empty()) return found || !near;
  pair.deepest = *std::min_element(pair.rows.begin(), pair.rows.end(),
                                   [](const RowPoint& r, const RowPoint& s) { return r.gap < s.gap; });
  pair.contacts = static_cast<std::int32_t>(pair.rows.size());
  return true;
}

void RigidContacts::sample(Pair& pair, Workspace& ws, bool every_node) const {
  const Touch& t = pair.touch;
  pair.rows.clear(), pair.boxes.clear();
  pair.contacts = 0, pair.engulfed = 0, pair.nodes = 0, pair.most_overlap = 0.0f, pair.off_nodes = false;
  ContactPair contact_pair{t.part_a, t.part_b, t.h, t.w, t.margin, 0, 0};
  const double gap = widest_gap(t.margin) * t.w, seen = t.level > 0 ? gap + t.w : gap;
  if (apart(t.part_a, t.part_b, seen) || apart(t.part_b, t.part_a, seen)) return;
  const Aabb region = box_[t.part_a].intersection(box_[t.part_b]);
  if (!every_node && read_between(pair, region, gap)) return;
  const Vec3i lo = (region.lo / t.h).array().ceil().cast<int>(), hi = (region.hi / t.h).array().floor().cast<int>();
  if (!(lo.array() <= hi.array()).all()) return;
  ws.finds.clear();
  const CubeSide a = side_of(t.part_a, t), b = side_of(t.part_b, t);
  find_between_solids(a, b, contact_pair, {lo, hi}, ws.finds);
  pair.off_nodes = true;
  pair.boxes.assign(ws.finds.boxes.begin(), ws.finds.boxes.end());
  pair.engulfed = ws.finds.engulfed, pair.nodes = ws.finds.nodes;
  if (ws.finds.contacts.empty()) return;
  ContactSet& set = ws.contacts;
  set.pairs.assign(1, contact_pair);
  const PairFinds piece{0, &ws.finds};
  brim::gather(std::span(&piece, 1), set);
  const std::size_t n = set.size();
  pair.contacts = static_cast<std::int32_t>(n);
  std::size_t deepest = 0;
  for (std::size_t c = 0; c < n; ++c) {
    if (set.depth[c] > set.depth[deepest]) deepest = c;
    pair.most_overlap = std::max(pair.most_overlap, set.overlap[c]);
  }
  ws.direction.resize(n), ws.normal.resize(n);
  ws.normals.find(set, set.pairs[0], ws.direction, ws.normal);
  pair.deepest = {set.point[deepest], ws.normal[deepest], -set.depth[deepest], Vec3::Zero(), {}, {}};
  ConstraintOptions options;
  options.every_node = every_node;
  if (t.level == 0) options.side_a = &a, options.side_b = &b;  // averaged solids have no edges
  ws.rows.gather(set, ws.normal, std::span(&law(t.part_a, t.part_b), 1), options);
  pair.off_nodes = ws.rows.off_nodes(0);
  const ContactSet& points = ws.rows.points();
  for (std::size_t c = 0; c < points.size(); ++c) {
    const Vec3& normal = ws.rows.normals()[c];
    const Vec3& x = points.point[c];
    pair.rows.push_back({x, normal, -points.depth[c], ws.rows.grips()[c] - x, {}, {}});
    pack_bends(ws.rows.bends()[c], pair.rows.back());
  }
}

GatheredRows RigidContacts::gather() {
  pair_rows_.clear(), rows_.clear();
  for (const Pair& p : pairs_) {
    if (p.rows.empty()) continue;
    const Touch& t = p.touch;
    const RigidMotion &a = references_.motion(static_cast<std::size_t>(t.part_a)),
                      &b = references_.motion(static_cast<std::size_t>(t.part_b));
    const ConstraintPair& l = law(t.part_a, t.part_b);
    pair_rows_.push_back({t.part_a, t.part_b, t.h, t.w, l.friction, l.restitution, p.off_nodes, rows_.size(),
                          rows_.size() + p.rows.size()});
    for (const RowPoint& r : p.rows) rows_.push_back(moved(r, a, b, t.h));
  }
  return {pair_rows_, rows_};
}

}  // namespace brim
