#include "brim/response/constraint.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace brim {

namespace {

/// Nodes this many voxels short of the deepest still have a say in where the first point is.
constexpr double kNearDeepest = 0.25;
/// Points whose gap exceeds the least of their pair by more voxels than this touch later, and do not bounce yet.
constexpr double kTogether = 0.02;
/// [voxels] overlap that is left alone; the share of the rest that a step pushes out, at no more than kPush a step.
constexpr double kSlop = 0.005, kShare = 0.2, kPush = 0.1;
/// [voxels] gap that counts as touch: bodies do not rock on gaps so small.
constexpr double kTouch = 0.005;
/// Least cosine between the two surfaces' normals where they touch: elsewhere one of them turns away at an edge.
constexpr double kFacing = 0.9;
/// Part of the ramp's width within which a density tells a distance well; 1/2 is the whole ramp.
constexpr double kOnRamp = 0.46;
/// [voxels] cell whose nodes make a point where a part deforms; least cosine of a patch's normals to its deepest
/// node's.
constexpr double kCell = 2.0, kAlike = 0.9;
/// [1/h] curvature below which the place of the least gap is not sought; [voxels] farthest that it is.
constexpr double kLeastBend = 0.02, kFarthestShift = 0.75;
/// Spread of a patch, over h², below which its gradients are left as the stencil gives them.
constexpr double kRegular = 0.1;
/// [1/h] curvature that the stencil's noise reaches on tilted planes, thrice.
constexpr double kNoise = 0.015;
/// A surface is a plane where at least so many nodes, bent by no more than kLevel/h there, tell distances that miss one
/// by no more than kPlane voxels.
constexpr std::size_t kFewest = 8;
constexpr double kLevel = 0.15, kPlane = 1e-3;
/// [voxels] rise of the gap by curvature up to which a node belongs to the flat part of a patch.
constexpr double kFlat = 0.05;
/// [voxels] corners nearer to another point than this say nothing new.
constexpr double kApart = 1.0;

double facing(const ContactSet& s, std::size_t c) {
  const double size = s.gradient_a[c].norm() * s.gradient_b[c].norm();
  return size > 0.0 ? -s.gradient_a[c].dot(s.gradient_b[c]) / size : -1.0;
}

/// Half the difference of the distances to the two surfaces, (d_a − d_b)/2.
double lean(const ContactSet& s, std::size_t c) {
  const Vec3 g = s.gradient_a[c] - s.gradient_b[c];
  const double length = g.norm();
  return length > 0.0 ? (s.point[c] - s.node[c]).dot(g) / length : 0.0;
}

/// True where both densities are on their ramps, so that they tell distances, and the surfaces face each other.
bool fit(const ContactSet& s, std::size_t c, double w) {
  return 0.5 * std::abs(s.depth[c]) + std::abs(lean(s, c)) < kOnRamp * w && facing(s, c) >= kFacing;
}

/// A curvature that may be the stencil's noise counts less.
Mat3 sure(const Mat3& curvature, double h) {
  const double size = h * h * curvature.squaredNorm();
  return curvature * (size / (size + kNoise * kNoise));
}

/// Distances from nodes to one of the two surfaces, about a point: d(y) = gap + slope·(y − x).
struct Plane {
  double gap = 0.0;
  Vec3 slope = Vec3::Zero();
};

/// What a node says of the distance to one of the two surfaces.
double told(const ContactSet& s, std::size_t c, bool of_a) {
  return (of_a ? lean(s, c) : -lean(s, c)) - 0.5 * s.depth[c];
}

/// The plane that fits nodes best: the gradients' mean normal, corrected as far as the nodes' places tell.
Plane best_plane(const ContactSet& s, std::span<const std::size_t> nodes, bool of_a, const Vec3& x, double h) {
  Vec3 mean = Vec3::Zero(), normal = Vec3::Zero();
  double mean_d = 0.0;
  const auto n = static_cast<double>(nodes.size());
  for (const std::size_t c : nodes) {
    mean += s.node[c] / n, mean_d += told(s, c, of_a) / n;
    normal -= (of_a ? s.gradient_a[c] : s.gradient_b[c]).normalized() / n;
  }
  Mat3 spread = Mat3::Identity() * (1e-9 * n * h * h);
  Vec3 miss = Vec3::Zero();
  for (const std::size_t c : nodes) {
    const Vec3 d = s.node[c] - mean;
    spread += d * d.transpose();
    miss += (told(s, c, of_a) - mean_d - normal.dot(d)) * d;
  }
  const Vec3 slope = normal + spread.ldlt().solve(miss);
  return {mean_d + slope.dot(x - mean), slope};
}

/// Fits a plane to what nodes say of one surface. Distances are exact where gradients by stencils are not, so the
/// normals of flat faces become exact. Nodes at an edge that pass for level are left out, if they are few.
/// @param level  workspace
/// @return false when the surface is no plane there, or too few nodes tell
bool fit_plane(const ContactSet& s, std::span<const std::size_t> nodes, bool of_a, const Vec3& x, double h,
               std::vector<std::size_t>& level, Plane& plane) {
  level.clear();
  for (const std::size_t c : nodes) {
    const Vec3& g = of_a ? s.gradient_a[c] : s.gradient_b[c];
    if (h * (of_a ? s.curvature_a[c] : s.curvature_b[c]).norm() < kLevel * g.norm()) level.push_back(c);
  }
  const std::size_t fewest = std::max(kFewest, (3 * level.size() + 3) / 4);
  while (level.size() >= fewest) {
    plane = best_plane(s, level, of_a, x, h);
    const auto miss = [&](std::size_t c) {
      return std::abs(told(s, c, of_a) - plane.gap - plane.slope.dot(s.node[c] - x));
    };
    double worst = 0.0;
    for (const std::size_t c : level) worst = std::max(worst, miss(c));
    if (worst <= kPlane * h) return true;
    std::erase_if(level, [&](std::size_t c) { return miss(c) > 0.5 * worst; });
  }
  return false;
}

/// Rise of the gap by curvature from x to y.
double rise(const Mat3& curvature, const Vec3& d) { return 0.5 * std::max(0.0, d.dot(curvature * d)); }

}  // namespace

void Constraint::gather(const ContactSet& contacts, std::span<const Vec3> normals,
                        std::span<const ConstraintPair> pairs, const ConstraintOptions& options) {
  points_.resize(0);
  points_.pairs = contacts.pairs;
  normal_.clear(), friction_.clear(), restitution_.clear();
  for (std::size_t p = 0; p < contacts.pairs.size(); ++p) {
    points_.pairs[p].begin = points_.size();
    if (pairs[p].constrained && contacts.pairs[p].begin < contacts.pairs[p].end)
      gather_pair(contacts, normals, contacts.pairs[p], pairs[p], options);
    points_.pairs[p].end = points_.size();
  }
}

void Constraint::gather_pair(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                             const ConstraintPair& law, const ConstraintOptions& options) {
  order_.clear();
  std::size_t best = pair.begin;
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    if (fit(contacts, c, pair.w)) order_.push_back(c);
    if (facing(contacts, c) > facing(contacts, best)) best = c;
  }
  if (order_.empty()) order_.push_back(best);
  if (options.every_node) {
    for (const std::size_t c : order_) add_point(contacts, c, contacts.point[c], normals[c], -contacts.depth[c], law);
    return;
  }
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::size_t i, std::size_t j) { return contacts.depth[i] > contacts.depth[j]; });
  if (law.stiff)
    gather_stiff(contacts, normals, pair, law);
  else
    gather_soft(contacts, normals, pair, law);
}

void Constraint::gather_soft(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                             const ConstraintPair& law) {
  // Cells that stay where they are: points then move smoothly, and keep their impulses from step to step.
  std::map<std::array<std::int64_t, 3>, std::vector<std::size_t>> cells;
  for (const std::size_t c : order_) {
    const Vec3 i = (contacts.node[c] / (kCell * pair.h) + Vec3::Constant(1e-6)).array().floor();
    cells[{static_cast<std::int64_t>(i.x()), static_cast<std::int64_t>(i.y()), static_cast<std::int64_t>(i.z())}]
        .push_back(c);  // deepest first, as in order_
  }
  for (auto& [cell, nodes] : cells) {
    patch_.clear();
    for (const std::size_t c : nodes)
      if (normals[c].dot(normals[nodes.front()]) >= kAlike) patch_.push_back(c);
    add_patch(contacts, normals, pair, law, patch_);
  }
}

void Constraint::gather_stiff(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                              const ConstraintPair& law) {
  // Where each node lies, so that patches grow from neighbour to neighbour.
  const auto key = [&](std::size_t c, int dx, int dy, int dz) {
    const Vec3 i = (contacts.node[c] / pair.h).array().round();
    constexpr std::int64_t kBias = 1 << 20;
    return ((static_cast<std::int64_t>(i.x()) + dx + kBias) << 42) +
           ((static_cast<std::int64_t>(i.y()) + dy + kBias) << 21) + static_cast<std::int64_t>(i.z()) + dz + kBias;
  };
  place_.clear();
  for (std::size_t i = 0; i < order_.size(); ++i) place_[key(order_[i], 0, 0, 0)] = i;
  const auto for_neighbours = [&](std::size_t c, const auto& f) {
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz)
          if (const auto it = place_.find(key(c, dx, dy, dz)); it != place_.end()) f(it->second);
  };
  taken_.assign(order_.size(), 0);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    if (taken_[i]) continue;
    taken_[i] = 1;
    const std::size_t seed = order_[i];
    // The rest of a deeper patch, turned away at its edge, is none of its own.
    bool top = true;
    for_neighbours(seed, [&](std::size_t j) { top = top && j >= i; });
    if (!top) continue;
    patch_.assign(1, seed);
    for (std::size_t k = 0; k < patch_.size(); ++k)
      for_neighbours(patch_[k], [&](std::size_t j) {
        if (taken_[j] || normals[order_[j]].dot(normals[seed]) < kAlike) return;
        taken_[j] = 1;
        patch_.push_back(order_[j]);
      });
    add_patch(contacts, normals, pair, law, patch_);
  }
}

Constraint::Model Constraint::model_at(const ContactSet& s, std::size_t c) {
  const double a = s.gradient_a[c].norm(), b = s.gradient_b[c].norm();
  if (!(a > 0.0 && b > 0.0)) return {Vec3::Zero(), Vec3::Zero(), Mat3::Zero(), Mat3::Zero()};
  return {-s.gradient_a[c] / a, -s.gradient_b[c] / b, -s.curvature_a[c] / a, -s.curvature_b[c] / b};
}

void Constraint::add_patch(const ContactSet& contacts, std::span<const Vec3> normals, const ContactPair& pair,
                           const ConstraintPair& law, std::span<const std::size_t> nodes) {
  const double h = pair.h, deepest = contacts.depth[nodes.front()];
  // A patch with a flat middle is flat, whatever its edges: nodes count by how flat they are.
  const auto weight = [&](std::size_t c, const Model& m) {
    const double near = contacts.depth[c] - deepest + kNearDeepest * h;
    if (!(near > 0.0)) return 0.0;
    const double bent = h * (m.curvature_a + m.curvature_b).norm() + kLeastBend;
    return near / (bent * bent);
  };
  Vec3 x = Vec3::Zero(), n = Vec3::Zero();
  Mat3 curvature_a = Mat3::Zero(), curvature_b = Mat3::Zero();
  double sum = 0.0;
  weight_.clear();
  for (const std::size_t c : nodes) {
    const Model m = model_at(contacts, c);
    const double w = weight(c, m);
    weight_.push_back(w);
    sum += w;
    x += w * contacts.point[c];
    n += w * normals[c];
    curvature_a += w * m.curvature_a, curvature_b += w * m.curvature_b;
  }
  x /= sum, curvature_a = sure(curvature_a / sum, h), curvature_b = sure(curvature_b / sum, h);
  n = n.norm() > 0.0 ? Vec3(n.normalized()) : normals[nodes.front()];
  near_.clear();
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (weight_[i] > 0.0) near_.push_back(nodes[i]);
  Plane plane_a, plane_b;
  const bool flat_a = fit_plane(contacts, near_, true, x, h, level_, plane_a),
             flat_b = fit_plane(contacts, near_, false, x, h, level_, plane_b);
  if (flat_a) curvature_a.setZero();
  if (flat_b) curvature_b.setZero();

  // What every node foretells of the gap and of the two distances' gradients at x.
  const Mat3 curvature = curvature_a + curvature_b, T = Mat3::Identity() - n * n.transpose();
  double gap = 0.0;
  Vec3 away_a = Vec3::Zero(), away_b = Vec3::Zero();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double w = weight_[i] / sum;
    if (!(w > 0.0)) continue;
    const Model m = model_at(contacts, nodes[i]);
    const Vec3 d = T * (x - contacts.point[nodes[i]]);
    gap += w * ((m.away_a + m.away_b).dot(d) + 0.5 * d.dot(curvature * d) - contacts.depth[nodes[i]]);
    away_a += w * (m.away_a + curvature_a * d);
    away_b += w * (m.away_b + curvature_b * d);
  }
  // The distances themselves are exact where the gradients' stencil is not: their regression over the patch mends both.
  Vec3 mean = Vec3::Zero(), miss_a = Vec3::Zero(), miss_b = Vec3::Zero();
  double mean_a = 0.0, mean_b = 0.0;
  const auto for_misses = [&](const auto& f) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const std::size_t c = nodes[i];
      const Vec3 at = contacts.node[c] - x, d = T * at;
      const double half = lean(contacts, c), depth = 0.5 * contacts.depth[c];
      f(weight_[i] / sum, d, half - depth - away_a.dot(at) - 0.5 * d.dot(curvature_a * d),
        -half - depth - away_b.dot(at) - 0.5 * d.dot(curvature_b * d));
    }
  };
  for_misses([&](double w, const Vec3& d, double a, double b) { mean += w * d, mean_a += w * a, mean_b += w * b; });
  Mat3 spread = (kRegular * h * h) * Mat3::Identity();
  for_misses([&](double w, const Vec3& d, double a, double b) {
    miss_a += w * (a - mean_a) * (d - mean), miss_b += w * (b - mean_b) * (d - mean);
    spread += w * (d - mean) * (d - mean).transpose();
  });
  const Mat3 regression = T * spread.inverse();
  away_a += regression * miss_a, away_b += regression * miss_b;
  if (flat_a) away_a = plane_a.slope;
  if (flat_b) away_b = plane_b.slope;
  if (flat_a && flat_b) gap = plane_a.gap + plane_b.gap;
  Vec3 slope = away_a + away_b;
  slope -= n * n.dot(slope);
  const Mat3 bend = curvature + kLeastBend / h * Mat3::Identity() + n * n.transpose() / h;
  Vec3 shift = -bend.inverse() * slope;
  shift -= n * n.dot(shift);
  const double length = shift.norm();
  double change = slope.dot(shift) + 0.5 * shift.dot(curvature * shift);
  // Farther away lies no least gap but an edge that the model does not see.
  if (!(change < 0.0 && std::isfinite(change) && length < kFarthestShift * h)) shift.setZero(), change = 0.0;
  const Vec3 found = normal_at(n, shift, away_a, away_b, curvature_a, curvature_b);
  add_point(contacts, nodes.front(), x + shift, found, gap + change, law);
  if (law.stiff) add_corners(contacts, pair, law, nodes, {x, gap, slope, curvature});
}

Vec3 Constraint::normal_at(const Vec3& n, const Vec3& shift, const Vec3& away_a, const Vec3& away_b,
                           const Mat3& curvature_a, const Mat3& curvature_b) {
  // The flatter of the two tells the direction better.
  const double a = curvature_a.norm(), b = curvature_b.norm(), share = a + b > 0.0 ? a / (a + b) : 0.5;
  const Vec3 found = share * (away_b + curvature_b * shift) - (1.0 - share) * (away_a + curvature_a * shift);
  return found.dot(n) > kAlike * found.norm() ? Vec3(found.normalized()) : n;
}

void Constraint::add_corners(const ContactSet& contacts, const ContactPair& pair, const ConstraintPair& law,
                             std::span<const std::size_t> nodes, const Quadric& quadric) {
  const double h = pair.h;
  const std::size_t center = points_.size() - 1;
  const Vec3 x = points_.point[center], n = normal_[center];
  const auto fitted = [&](std::size_t c) {
    Vec3 d = contacts.point[c] - quadric.x;
    d -= n * n.dot(d);
    return quadric.gap + quadric.slope.dot(d) + 0.5 * d.dot(quadric.curvature * d);
  };
  // Nodes off the model lie beyond an edge, or on another surface that has its own patch.
  flat_.clear();
  for (const std::size_t c : nodes)
    if (rise(quadric.curvature, contacts.point[c] - x) <= kFlat * h &&
        std::abs(fitted(c) + contacts.depth[c]) <= kFlat * h)
      flat_.push_back(c);
  if (flat_.empty()) return;
  const auto farthest = [&](const auto& measure) {
    std::size_t best = flat_.front();
    for (const std::size_t c : flat_)
      if (measure(contacts.point[c]) > measure(contacts.point[best]) + 1e-9 * h) best = c;
    return best;
  };
  // Corners: the two farthest apart, and those farthest from the line between them on either side.
  const std::size_t first = farthest([&](const Vec3& y) { return (y - x).norm(); });
  const Vec3 from = contacts.point[first];
  const std::size_t second = farthest([&](const Vec3& y) { return (y - from).norm(); });
  Vec3 across = n.cross(contacts.point[second] - from);
  if (across.norm() > 0.0) across.normalize();
  const std::size_t left = farthest([&](const Vec3& y) { return across.dot(y - from); });
  const std::size_t right = farthest([&](const Vec3& y) { return -across.dot(y - from); });
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t c : {first, second, left, right}) {
    const Vec3& y = contacts.point[c];
    bool fresh = true;
    for (std::size_t i = center; i < points_.size(); ++i) fresh = fresh && (points_.point[i] - y).norm() > kApart * h;
    if (!fresh) continue;
    // The gaps are the model's: bodies would rock on the noise of each node.
    const double gap = fitted(c);
    add_point(contacts, c, y, n, gap, law);
    least = std::min(least, gap);
  }
  // Between three corners or four the first point says nothing new, unless it lies deeper.
  if (points_.size() >= center + 4 && -points_.depth[center] > least - 0.5 * kFlat * h) remove_point(center);
}

void Constraint::remove_point(std::size_t i) {
  const auto drop = [i](auto& v) { v.erase(v.begin() + static_cast<std::ptrdiff_t>(i)); };
  ContactSet& s = points_;
  drop(s.node), drop(s.point), drop(s.overlap), drop(s.depth), drop(s.gradient_a), drop(s.gradient_b);
  drop(s.curvature_a), drop(s.curvature_b), drop(s.source_a), drop(s.source_b);
  drop(normal_), drop(friction_), drop(restitution_);
}

void Constraint::add_point(const ContactSet& contacts, std::size_t c, const Vec3& x, const Vec3& n, double gap,
                           const ConstraintPair& law) {
  ContactSet& s = points_;
  s.node.push_back(contacts.node[c]), s.point.push_back(x);
  s.overlap.push_back(contacts.overlap[c]), s.depth.push_back(-gap);
  s.gradient_a.push_back(contacts.gradient_a[c]), s.gradient_b.push_back(contacts.gradient_b[c]);
  s.curvature_a.push_back(contacts.curvature_a[c]), s.curvature_b.push_back(contacts.curvature_b[c]);
  s.source_a.push_back(contacts.source_a[c]), s.source_b.push_back(contacts.source_b[c]);
  normal_.push_back(n), friction_.push_back(law.friction), restitution_.push_back(law.restitution);
}

void Constraint::set_targets(const ConstraintOptions& options, std::span<const Vec3> start,
                             std::span<const Vec3> free) {
  const double dt = options.dt;
  velocity_target_.resize(points_.size()), travel_target_.resize(points_.size());
  travels_apart_ = false;
  for (const ContactPair& pair : points_.pairs) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = pair.begin; c < pair.end; ++c) least = std::min(least, -points_.depth[c]);
    for (std::size_t c = pair.begin; c < pair.end; ++c) {
      const double gap = -points_.depth[c], open = std::max(0.0, gap);
      const double u0 = normal_[c].dot(start[c]), u1 = normal_[c].dot(free[c]), a = (u1 - u0) / dt;
      const double push = std::min(kShare * std::max(0.0, -gap - kSlop * pair.h), kPush * pair.h) / dt;
      const double closing = -std::max(0.0, gap - kTouch * pair.h) / dt;
      velocity_target_[c] = closing;
      travel_target_[c] = closing + push;
      const bool touches = open + dt * u1 < 0.0;
      if (touches && restitution_[c] > 0.0 && gap <= least + kTogether * pair.h) {
        // In free flight by v ← v + a dt, x ← x + dt v, the parabola's own velocity is half a step ahead of v.
        const double before = open / -u1, left = dt - before;
        const double hit = u0 + a * (0.5 * dt + before);
        if (-hit > options.bounce_speed) {
          const double after = -restitution_[c] * hit;
          velocity_target_[c] = std::max(0.0, after + a * (0.5 * dt - before));
          travel_target_[c] = std::max(push, (after * left + 0.5 * a * left * left) / dt) - open / dt;
        }
      }
      travels_apart_ = travels_apart_ || velocity_target_[c] != travel_target_[c];
    }
  }
}

}  // namespace brim
