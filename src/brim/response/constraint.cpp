#include "brim/response/constraint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "brim/response/fitting_solids.h"

namespace brim {

namespace {

/// [voxels] cell whose nodes make one point when a part deforms; smallest cosine of a patch's normals to its deepest
/// node's.
constexpr double kCell = 2.0, kAlikeInPatch = 0.9;
/// [voxels] largest misfit of a patch's model; with a larger one, the nodes within kAround of the deepest are modelled
/// first.
constexpr double kMisfit = 0.1, kAround = 3.0;
/// [voxels] overlap of a node beyond that of the nearest point, above which the point takes the node's overlap.
constexpr double kUnseen = 0.05;
/// [1/h] smallest curvature of the model of an edge, and largest one of a node on a face; [voxels] smallest excess of
/// the model's gap over that of such a node, for the model of an edge.
constexpr double kEdgeBend = 0.1, kFace = 0.02, kForetold = 0.02;
/// [voxels] largest excess of a node's gap over that of a face at its rim; smallest cosine there between the two
/// normals, of which the stencil turns one towards the side face.
constexpr double kRim = 0.1, kTurned = 0.5;

/// At an edge the point moves with the material of the sharper surface, as for a curvature radius of one voxel; the
/// other is flat.
Constraint::Bend sharp_bend(const ContactSet& s, std::size_t c, double h) {
  const double a = s.curvature_a(c).norm() * s.gradient_b[c].norm(),
               b = s.curvature_b(c).norm() * s.gradient_a[c].norm();
  Constraint::Bend bend;
  (a > b ? bend.a : bend.b) = Mat3::Identity() / h;
  return bend;
}

/// The gap around a round point, as a patch's model tells it.
PatchModel model_of(const RoundPoint& point, FixedPart fixed, double h) {
  PatchModel m;
  m.x = m.least_point = point.x, m.n = point.normal, m.gap = m.least_gap = point.gap;
  m.bend_a = point.bend_a, m.bend_b = point.bend_b, m.curvature = point.bend_a + point.bend_b;
  const double share = share_of_b(m.bend_a.norm(), m.bend_b.norm(), fixed, h);
  m.turn = share * m.bend_b - (1.0 - share) * m.bend_a;
  return m;
}

}  // namespace

void Constraint::gather(const ContactSet& contacts, std::span<const Vec3> normals,
                        std::span<const ConstraintPair> pairs, const ConstraintOptions& options,
                        const GatheredRows& gathered) {
  points_.resize(0);
  points_.pairs.clear(), off_nodes_.clear();
  normal_.clear(), grip_.clear(), friction_.clear(), restitution_.clear(), bend_.clear(), round_.clear();
  std::size_t next = 0;
  for (std::size_t p = 0; p <= contacts.pairs.size(); ++p) {
    const bool last = p == contacts.pairs.size();
    // Both lists are ordered by part numbers; merge them in this order.
    const auto comes_first = [&](const PairRows& r) {
      return last || std::pair(r.part_a, r.part_b) < std::pair(contacts.pairs[p].part_a, contacts.pairs[p].part_b);
    };
    for (; next < gathered.pairs.size() && comes_first(gathered.pairs[next]); ++next)
      take_rows(gathered.pairs[next], gathered.rows);
    if (last) break;
    points_.pairs.push_back(contacts.pairs[p]);
    points_.pairs.back().begin = points_.size();
    by_formula_ = 0;
    if (pairs[p].constrained && contacts.pairs[p].begin < contacts.pairs[p].end)
      gather_pair(contacts, normals, contacts.pairs[p], pairs[p], options);
    points_.pairs.back().end = points_.size();
    const std::size_t found = points_.size() - points_.pairs.back().begin;
    off_nodes_.push_back(pairs[p].rigid && (found == 0 || by_formula_ < found));
  }
}

void Constraint::take_rows(const PairRows& pair, std::span<const RowPoint> rows) {
  const std::size_t first = points_.size(), n = pair.end - pair.begin;
  points_.pairs.push_back({pair.part_a, pair.part_b, pair.h, pair.w, 0.0, first, first + n});
  off_nodes_.push_back(pair.off_nodes);
  points_.resize(first + n);
  for (std::size_t i = 0; i < n; ++i) {
    const RowPoint& r = rows[pair.begin + i];
    points_.point[first + i] = r.point;
    points_.depth[first + i] = static_cast<float>(-r.gap);
    normal_.push_back(r.normal), grip_.push_back(r.point + r.grip - r.normal * r.normal.dot(r.grip));
    // Without restitution and with friction there is no such path: a displacement that friction also bounds is not that
    // of a bent path, and angular momentum would be lost.
    const bool bends = pair.restitution > 0.0 || pair.friction == 0.0;
    round_.push_back(n == 1 && bends ? round_contact(r, pair.h) : RoundContact{});
    bend_.push_back({bend_across(r.bend_a, r.normal), bend_across(r.bend_b, r.normal)});
  }
  friction_.resize(first + n, pair.friction), restitution_.resize(first + n, pair.restitution);
}

void Constraint::gather_pair(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                             const ConstraintPair& law, const ConstraintOptions& options) {
  order_.clear();
  std::size_t best = pair.begin;
  double most = facing(contacts, best);
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    if (tells_distances(contacts, c, pair)) order_.push_back(c);
    const double f = facing(contacts, c);
    if (f > most) best = c, most = f;
  }
  const std::size_t first = points_.size();
  const std::span<const EdgePoint> edges =
      options.every_node ? std::span<const EdgePoint>() : edges_.find(contacts, pair, order_, law.fixed);
  if (order_.empty() && edges.empty()) order_.push_back(best);
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::size_t i, std::size_t j) { return contacts.depth[i] > contacts.depth[j]; });
  if (options.every_node)
    for (const std::size_t c : order_)
      add_point(contacts, c, contacts.point[c], normals[c], -contacts.depth[c], law, {});
  else if (law.rigid)
    gather_rigid(contacts, normals, pair, law, options);
  else
    gather_soft(contacts, normals, pair, law);
  for (const EdgePoint& e : edges) {
    // Opposing rows at one place cannot both be satisfied; and the corner of a face says more than a node beside it.
    bool against = false;
    for (std::size_t i = first; i < points_.size(); ++i) {
      const double apart = (points_.point[i] - e.point).norm(), alike = normal_[i].dot(e.normal);
      const bool corner = alike > kAlikeInPatch && bend_[i].a.isZero(0.0) && bend_[i].b.isZero(0.0);
      against = against || (alike < 0.0 && apart < kAround * pair.h) || (corner && apart < kApart * pair.h);
    }
    if (!against) add_point(contacts, e.node, e.point, e.normal, e.gap, law, sharp_bend(contacts, e.node, pair.h));
  }
  if (law.rigid && !options.every_node) deepen(contacts, normals, pair, law, first);
}

void Constraint::deepen(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                        const ConstraintPair& law, std::size_t first) {
  const std::size_t end = points_.size();
  const double far = kAround * pair.h, unseen = kUnseen * pair.h;
  std::size_t alone = pair.end;  // the deepest node without a point near it
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    if (!(contacts.depth[c] > unseen)) continue;
    std::size_t best = end;
    double least = far * far;
    for (std::size_t i = first; i < end; ++i) {
      const double d = (points_.point[i] - contacts.point[c]).squaredNorm();
      if (d < least) least = d, best = i;
    }
    if (best == end) {
      if (alone == pair.end || contacts.depth[c] > contacts.depth[alone]) alone = c;
    } else if (contacts.depth[c] > points_.depth[best] + unseen) {
      points_.depth[best] = contacts.depth[c];
    }
  }
  if (alone < pair.end)
    add_point(contacts, alone, contacts.point[alone], normals[alone], -contacts.depth[alone], law,
              sharp_bend(contacts, alone, pair.h));
}

void Constraint::gather_soft(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                             const ConstraintPair& law) {
  // Fixed cells: points then move smoothly, and keep their impulses from step to step.
  using Cell = std::array<std::int64_t, 3>;
  const auto cell_of = [&](std::size_t c) {
    const Vec3 i = (contacts.node[c].cast<double>() / kCell + Vec3::Constant(1e-6)).array().floor();
    return Cell{static_cast<std::int64_t>(i.x()), static_cast<std::int64_t>(i.y()), static_cast<std::int64_t>(i.z())};
  };
  std::map<Cell, std::vector<std::size_t>> cells;
  place_.reset(pair.h);
  for (std::size_t i = 0; i < order_.size(); ++i) place_.set(contacts.node_at(order_[i], pair.h), i);
  for (const std::size_t c : order_) {
    // Where the gradients cancel there is no normal.
    if (!(normals[c].squaredNorm() > 0.5)) continue;
    cells[cell_of(c)].push_back(c);  // deepest first, as in order_
  }
  std::map<Cell, std::size_t> rims;  // the deepest node of each
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    const auto cell = cell_of(c);
    if (cells.contains(cell) || !at_rim_of_face(contacts, normals, pair, c)) continue;
    const auto [it, fresh] = rims.try_emplace(cell, c);
    if (!fresh && contacts.depth[c] > contacts.depth[it->second]) it->second = c;
  }
  for (auto& [cell, nodes] : cells) {
    while (!nodes.empty()) {
      const Vec3 n = normals[nodes.front()];
      patch_.clear();
      for (const std::size_t c : nodes)
        if (normals[c].dot(n) >= kAlikeInPatch) patch_.push_back(c);
      add_patch(contacts, normals, pair, law, {}, patch_);
      std::erase_if(nodes, [&](std::size_t c) { return normals[c].dot(n) >= kAlikeInPatch; });
    }
  }
  // A node on the face gives the exact gap, others a larger one.
  for (const auto& [cell, c] : rims) add_point(contacts, c, contacts.point[c], normals[c], -contacts.depth[c], law, {});
}

void Constraint::gather_rigid(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                              const ConstraintPair& law, const ConstraintOptions& options) {
  fits_ = options.side_a != nullptr && fit_each_other(contacts, pair);
  // Node lookup, so that patches grow from neighbour to neighbour.
  place_.reset(pair.h);
  for (std::size_t i = 0; i < order_.size(); ++i) place_.set(contacts.node_at(order_[i], pair.h), i);
  const auto for_neighbours = [&](std::size_t c, const auto& f) {
    place_.for_around(contacts.node_at(c, pair.h), 1, f);
  };
  taken_.assign(order_.size(), 0);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    if (taken_[i]) continue;
    taken_[i] = 1;
    const std::size_t seed = order_[i];
    // The remainder of a deeper patch, curving away at its edge, is no patch of its own.
    bool top = true;
    for_neighbours(seed, [&](std::size_t j) { top = top && j >= i; });
    if (!top) continue;
    patch_.assign(1, seed);
    for (std::size_t k = 0; k < patch_.size(); ++k)
      for_neighbours(patch_[k], [&](std::size_t j) {
        if (taken_[j] || normals[order_[j]].dot(normals[seed]) < kAlikeInPatch) return;
        taken_[j] = 1;
        patch_.push_back(order_[j]);
      });
    add_patch(contacts, normals, pair, law, options, patch_);
  }
}

void Constraint::add_patch(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                           const ConstraintPair& law, const ConstraintOptions& options,
                           std::span<const std::size_t> nodes) {
  const double far = kAround * pair.h, miss = kMisfit * pair.h;
  const std::size_t first = points_.size();
  fitter_.set_solids(options.side_a, options.side_b);
  rest_.assign(nodes.begin(), nodes.end());
  while (!rest_.empty()) {
    const Vec3 deepest = contacts.point[rest_.front()];
    const auto around = [&](std::size_t c) { return (contacts.point[c] - deepest).norm() <= far; };
    // Nodes with smaller gaps than the model get points of their own.
    const auto drop_told = [&](const PatchModel& model) {
      std::erase_if(rest_, [&](std::size_t c) {
        return around(c) || (-contacts.depth[c] >= model.gap_at(contacts.point[c]) - miss &&
                             model.turn_at(contacts.point[c]).norm() <= kAlongArc);
      });
    };
    if (options.side_a != nullptr && !fits_)
      if (const auto found =
              find_round_point(*options.side_a, *options.side_b, deepest, normals[rest_.front()], pair.h)) {
        add_point(contacts, rest_.front(), found->x, found->normal, found->gap, law, {found->bend_a, found->bend_b});
        ++by_formula_;
        if (!law.rigid) return;
        drop_told(model_of(*found, law.fixed, pair.h));
        continue;
      }
    PatchModel model = fitter_.fit(contacts, normals, pair.h, rest_, law.fixed);
    around_ = rest_;
    const auto told = [&](std::size_t c) {
      return std::abs(model.gap_at(contacts.point[c]) + contacts.depth[c]) <= miss;
    };
    if (law.rigid && !std::all_of(fitter_.near().begin(), fitter_.near().end(), told)) {
      std::erase_if(around_, [&](std::size_t c) { return !around(c); });
      model = fitter_.fit(contacts, normals, pair.h, around_, law.fixed);
      // Rough surfaces fit no quadric: use their deepest node.
      if (-contacts.depth[around_.front()] < model.gap_at(deepest) - miss)
        model.least_point = deepest, model.least_gap = -contacts.depth[around_.front()];
    }
    // At the edge of a face the gap rises outwards and does not fall inwards: the nodes' gap is right.
    if (!law.rigid && at_edge_of_face(contacts, model, pair.h))
      model.least_point = model.x, model.least_gap = -contacts.depth[around_.front()];
    RoundDirections round{Vec3::Zero(), Vec3::Zero()};
    if (options.side_a != nullptr && !fits_) {
      const CubeSide &a = *options.side_a, &b = *options.side_b;
      round = round_directions(a, b, model.least_point, model.n, model.curvature, pair.h);
      if (const auto settled = settle_round_gap(a, b, model.least_point, round, pair.h))
        model.least_point = settled->x, model.least_gap = settled->gap;
    }
    const std::size_t center = points_.size();
    add_point(contacts, around_.front(), model.least_point, model.n, model.least_gap, law,
              {model.bend_a, model.bend_b});
    if (!law.rigid) return;
    add_corners(contacts, pair, law, options, model, round, first, center);
    drop_told(model);
  }
}

bool Constraint::at_rim_of_face(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                                std::size_t c) const {
  const double gap = -contacts.depth[c];
  if (!(gap < kRim * pair.h) || !(facing(contacts, c) >= kTurned) || !on_ramps(contacts, c, pair)) return false;
  return place_.any_around(contacts.node_at(c, pair.h), 2, [&](std::size_t i) {
    return normals[order_[i]].dot(normals[c]) >= kAlikeInPatch && gap < kRim * pair.h - contacts.depth[order_[i]];
  });
}

bool Constraint::at_edge_of_face(const ContactSet& contacts, const PatchModel& model, double h) const {
  if (model.least_point == model.x || h * (model.bend_a + model.bend_b).norm() < kEdgeBend) return false;
  return place_.any_around(model.least_point, 2, [&](std::size_t i) {
    const std::size_t c = order_[i];
    const double a = contacts.gradient_a[c].norm(), b = contacts.gradient_b[c].norm();
    return h * (contacts.curvature_a(c) / a + contacts.curvature_b(c) / b).norm() < kFace &&
           model.gap_at(contacts.point[c]) + contacts.depth[c] > kForetold * h;
  });
}

void Constraint::place(std::size_t c, const Vec3& point, const Vec3& normal, double gap) {
  points_.point[c] = grip_[c] = point;
  normal_[c] = normal;
  points_.depth[c] = static_cast<float>(-gap);
}

void Constraint::remove_point(std::size_t i) {
  const auto drop = [i](auto& v) { v.erase(v.begin() + static_cast<std::ptrdiff_t>(i)); };
  points_.erase(i);
  drop(normal_), drop(grip_), drop(friction_), drop(restitution_), drop(bend_), drop(round_);
}

void Constraint::add_point(const ContactSet& contacts, std::size_t c, const Vec3& x, const Vec3& n, double gap,
                           const ConstraintPair& law, const Bend& bend) {
  points_.append(contacts, c, x, -gap);
  bend_.push_back(bend), round_.push_back({});
  normal_.push_back(n), grip_.push_back(x), friction_.push_back(law.friction), restitution_.push_back(law.restitution);
}

}  // namespace brim
