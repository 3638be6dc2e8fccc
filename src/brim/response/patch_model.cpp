#include "brim/response/patch_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "brim/math/ramp.h"
#include "brim/response/patch_planes.h"

namespace brim {

namespace {

/// [voxels] Nodes with a depth within this of the deepest contribute to the position of the first point.
constexpr double kNearDeepest = 0.25;
/// Smallest cosine between the two surfaces' normals where they touch: elsewhere one of them turns away at an edge.
constexpr double kFacing = 0.9;
/// Share of the ramp's width, on either side, in which a density gives a good distance; 1/2 is the whole ramp.
constexpr double kOnRamp = 0.46;
/// Smallest slope of a density relative to its ramp's: 0.87 or more beside a plane, from the stencil, 0.6 on the
/// bisector inside a right-angled edge, 0.5 and less at the end of an axis.
constexpr double kSteep = 0.55;
/// Smallest cosine of the normal at the smallest gap to the patch's.
constexpr double kAlikeToModel = 0.9;
/// [1/h] curvature below which the smallest gap is not searched; [voxels] largest shift to it.
constexpr double kLeastBend = 0.02, kFarthestShift = 0.75;
/// Spread of a patch, over h², below which its gradients are those of the stencil.
constexpr double kRegular = 0.1;
/// [1/h] three times the stencil's noise of curvature on tilted planes.
constexpr double kNoise = 0.015;
/// [1/h] curvature of a fixed surface up to which its own normals are used, whatever deformable part lies on it.
constexpr double kFixedBend = 0.05;
/// Spread of a patch, over h², above which its nodes' normals determine their rotation; allowed misfit of the sine.
constexpr double kTrust = 0.3, kOneArc = 0.03;

/// Half the difference of the distances to the two surfaces, (d_a − d_b)/2.
double lean(const ContactSet& s, std::size_t c, double h) {
  const Vec3 g = s.gradient_a[c] - s.gradient_b[c];
  const double length = g.norm();
  return length > 0.0 ? (s.point[c] - s.node_at(c, h)).dot(g) / length : 0.0;
}

/// Reduces a curvature that may be the stencil's noise.
Mat3 sure(const Mat3& curvature, double h) {
  const double size = h * h * curvature.squaredNorm();
  return curvature * (size / (size + kNoise * kNoise));
}

/// Distances to the two surfaces from one node: gradients, away from each part, and curvatures, [1/m].
struct NodeModel {
  Vec3 away_a, away_b;
  Mat3 curvature_a, curvature_b;
};

NodeModel model_at(const ContactSet& s, std::size_t c) {
  const double a = s.gradient_a[c].norm(), b = s.gradient_b[c].norm();
  if (!(a > 0.0 && b > 0.0)) return {Vec3::Zero(), Vec3::Zero(), Mat3::Zero(), Mat3::Zero()};
  return {-s.gradient_a[c] / a, -s.gradient_b[c] / b, -s.curvature_a(c) / a, -s.curvature_b(c) / b};
}

/// Normal at an offset from where the gradients hold.
Vec3 normal_at(const Vec3& n, const Vec3& shift, const Vec3& away_a, const Vec3& away_b, const Mat3& curvature_a,
               const Mat3& curvature_b, FixedPart fixed, double h) {
  const double share = share_of_b(curvature_a.norm(), curvature_b.norm(), fixed, h);
  const Vec3 found = share * (away_b + curvature_b * shift) - (1.0 - share) * (away_a + curvature_a * shift);
  return found.dot(n) > kAlikeToModel * found.norm() ? Vec3(found.normalized()) : n;
}

}  // namespace

double share_of_b(double bend_a, double bend_b, FixedPart fixed, double h) {
  if (fixed == FixedPart::None) return bend_a + bend_b > 0.0 ? bend_a / (bend_a + bend_b) : 0.5;
  const double least = kFixedBend / h, a = fixed == FixedPart::A ? bend_a : bend_a + least,
               b = fixed == FixedPart::B ? bend_b : bend_b + least;
  return a * a / (a * a + b * b);
}

double facing(const ContactSet& s, std::size_t c) {
  const double size = s.gradient_a[c].norm() * s.gradient_b[c].norm();
  return size > 0.0 ? -s.gradient_a[c].dot(s.gradient_b[c]) / size : -1.0;
}

bool on_ramps(const ContactSet& s, std::size_t c, const ContactPair& pair) {
  return 0.5 * std::abs(s.depth[c]) + std::abs(lean(s, c, pair.h)) < kOnRamp * pair.w;
}

double distance_to(const ContactSet& s, std::size_t c, bool of_a, double h) {
  return (of_a ? lean(s, c, h) : -lean(s, c, h)) - 0.5 * s.depth[c];
}

bool tells_direction(const ContactSet& s, std::size_t c, bool of_a, const ContactPair& pair) {
  const double slope = (of_a ? s.gradient_a[c] : s.gradient_b[c]).norm();
  return slope >= kSteep * -ramp_slope(distance_to(s, c, of_a, pair.h), pair.w);
}

bool tells_distances(const ContactSet& s, std::size_t c, const ContactPair& pair) {
  return on_ramps(s, c, pair) && facing(s, c) >= kFacing;
}

double PatchModel::gap_at(const Vec3& y) const {
  Vec3 d = y - x;
  d -= n * n.dot(d);
  return gap + slope.dot(d) + 0.5 * d.dot(curvature * d);
}

Vec3 PatchModel::turn_at(const Vec3& y) const {
  Vec3 d = y - least_point;
  d -= n * n.dot(d);
  const Vec3 sine = turn * d;
  return sine - n * n.dot(sine);
}

Vec3 PatchModel::normal_at(const Vec3& y) const {
  const Vec3 sine = turn_at(y);
  return std::sqrt(std::max(0.0, 1.0 - sine.squaredNorm())) * n + sine;
}

double PatchModel::rise_at(const Vec3& y) const {
  const Vec3 d = y - least_point;
  return 0.5 * std::max(0.0, d.dot(curvature * d));
}

void PatchFitter::mend_turn(const ContactSet& contacts, std::span<const std::size_t> nodes, double share, double h,
                            PatchModel& model) const {
  const Mat3 across = Mat3::Identity() - model.n * model.n.transpose();
  const auto for_normals = [&](const auto& f) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!(weight_[i] > 0.0)) continue;
      const NodeModel m = model_at(contacts, nodes[i]);
      const Vec3 normal = share * m.away_b - (1.0 - share) * m.away_a;
      if (!(normal.norm() > 0.0)) continue;
      f(weight_[i], across * (contacts.point[nodes[i]] - model.least_point), across * normal.normalized());
    }
  };
  double sum = 0.0, missed = 0.0;
  Vec3 middle = Vec3::Zero(), mean = Vec3::Zero();
  for_normals([&](double w, const Vec3& d, const Vec3& sine) { sum += w, middle += w * d, mean += w * sine; });
  middle /= sum, mean /= sum;
  Mat3 spread = kTrust * h * h * sum * Mat3::Identity(), turn = kTrust * h * h * sum * model.turn;
  for_normals([&](double w, const Vec3& d, const Vec3& sine) {
    spread += w * (d - middle) * (d - middle).transpose(), turn += w * (sine - mean) * (d - middle).transpose();
  });
  turn *= spread.inverse();
  const Vec3 at_least = mean - turn * middle;
  for_normals(
      [&](double w, const Vec3& d, const Vec3& sine) { missed += w * (sine - at_least - turn * d).squaredNorm(); });
  if (!(missed < kOneArc * kOneArc * sum) || !(at_least.norm() < kOneArc)) return;
  model.turn = turn;
  model.n = (model.n + at_least).normalized();
}

PatchModel PatchFitter::fit(const ContactSet& contacts, std::span<const Vec3> normals, double h,
                            std::span<const std::size_t> nodes, FixedPart fixed) {
  const double deepest = contacts.depth[nodes.front()];
  // A patch with a flat middle counts as flat, whatever its edges: nodes are weighted by flatness.
  const auto weight = [&](std::size_t c, const NodeModel& m) {
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
    const NodeModel m = model_at(contacts, c);
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
  SurfacePlane plane_a, plane_b;
  bool flat_a = fit_plane(contacts, near_, true, x, h, level_, plane_a),
       flat_b = fit_plane(contacts, near_, false, x, h, level_, plane_b);
  if (!(flat_a && flat_b) && solid_a_ != nullptr && probe_plane(*solid_a_, x, -n, h, plane_a) &&
      probe_plane(*solid_b_, x, n, h, plane_b))
    flat_a = flat_b = true;
  if (flat_a) curvature_a.setZero();
  if (flat_b) curvature_b.setZero();

  // Each node's prediction of the gap and of the two distances' gradients at x.
  const Mat3 curvature = curvature_a + curvature_b, T = Mat3::Identity() - n * n.transpose();
  double gap = 0.0;
  Vec3 away_a = Vec3::Zero(), away_b = Vec3::Zero();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double w = weight_[i] / sum;
    if (!(w > 0.0)) continue;
    const NodeModel m = model_at(contacts, nodes[i]);
    const Vec3 d = T * (x - contacts.point[nodes[i]]);
    gap += w * ((m.away_a + m.away_b).dot(d) + 0.5 * d.dot(curvature * d) - contacts.depth[nodes[i]]);
    away_a += w * (m.away_a + curvature_a * d);
    away_b += w * (m.away_b + curvature_b * d);
  }
  // Distances are exact where stencil gradients are not: a regression over the patch corrects both.
  Vec3 mean = Vec3::Zero(), miss_a = Vec3::Zero(), miss_b = Vec3::Zero();
  double mean_a = 0.0, mean_b = 0.0;
  const auto for_misses = [&](const auto& f) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const std::size_t c = nodes[i];
      const Vec3 at = contacts.node_at(c, h) - x, d = T * at;
      const double half = lean(contacts, c, h), depth = 0.5 * contacts.depth[c];
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
  // A larger shift leads to an edge outside the model, not to a smallest gap.
  if (!(change < 0.0 && std::isfinite(change) && length < kFarthestShift * h)) shift.setZero(), change = 0.0;
  const Vec3 found = normal_at(n, shift, away_a, away_b, curvature_a, curvature_b, fixed, h);
  PatchModel model;
  model.x = x, model.n = found, model.gap = gap, model.slope = slope, model.curvature = curvature;
  model.bend_a = curvature_a, model.bend_b = curvature_b;
  const double share = share_of_b(curvature_a.norm(), curvature_b.norm(), fixed, h);
  model.turn = share * curvature_b - (1.0 - share) * curvature_a;
  model.least_point = x + shift, model.least_gap = gap + change;
  if (!flat_a && !flat_b) mend_turn(contacts, nodes, share, h, model);
  return model;
}

}  // namespace brim
