#include "brim/response/edge_points.h"

#include <algorithm>
#include <cmath>

#include "brim/math/small_symmetric.h"
#include "brim/response/patch_model.h"

namespace brim {

namespace {

/// Smallest cosine between the surfaces' normals: beyond it no common normal separates them.
constexpr double kLeastFacing = 0.0;
/// Smallest cosine of a normal to that of the smallest gap of its group.
constexpr double kAlikeAtEdge = 0.8;
/// [voxels] excess over the smallest gap up to which nodes are averaged; length above which a group has two points.
constexpr double kNearLeast = 0.25, kLong = 1.0;
/// [voxels] distance from a node of a face up to which a node belongs to that face, unless its gap is smaller by
/// kNearer.
constexpr int kBesideFace = 2;
constexpr double kNearer = 0.1;

}  // namespace

void EdgePoints::read(const ContactSet& s, const ContactPair& pair, std::span<const std::size_t> faces,
                      FixedPart fixed) {
  reading_.clear();
  place_.reset(pair.h);
  for (const std::size_t c : faces) place_.set(s.node_at(c, pair.h), c);
  const auto belongs_to_face = [&](const Reading& r) {
    const auto owns = [&](std::size_t face) { return -s.depth[face] <= r.gap + kNearer * pair.h; };
    const Vec3 at = s.node_at(r.node, pair.h);
    return place_.any_around(at, 1, owns) || place_.any_around(at, kBesideFace, owns);
  };
  std::size_t next = 0;  // index in faces
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    if (next < faces.size() && faces[next] == c) {
      ++next;
      continue;
    }
    if (!on_ramps(s, c, pair) || facing(s, c) < kLeastFacing) continue;
    if (!tells_direction(s, c, true, pair) || !tells_direction(s, c, false, pair)) continue;
    const Vec3 away_a = -s.gradient_a[c].normalized(), away_b = -s.gradient_b[c].normalized();
    const double bend_a = s.curvature_a(c).norm() / s.gradient_a[c].norm(),
                 bend_b = s.curvature_b(c).norm() / s.gradient_b[c].norm();
    const double share = share_of_b(bend_a, bend_b, fixed, pair.h);
    const Vec3 n = (share * away_b - (1.0 - share) * away_a).normalized();
    const Vec3 to_a = distance_to(s, c, true, pair.h) * away_a, to_b = distance_to(s, c, false, pair.h) * away_b;
    const Reading reading{c, s.node_at(c, pair.h) - 0.5 * (to_a + to_b), n, n.dot(to_b - to_a)};
    if (!belongs_to_face(reading)) reading_.push_back(reading);
  }
}

std::span<const EdgePoint> EdgePoints::find(const ContactSet& contacts, const ContactPair& pair,
                                            std::span<const std::size_t> faces, FixedPart fixed) {
  points_.clear();
  read(contacts, pair, faces, fixed);
  std::stable_sort(reading_.begin(), reading_.end(), [](const Reading& i, const Reading& j) { return i.gap < j.gap; });
  place_.reset(pair.h);
  for (std::size_t i = 0; i < reading_.size(); ++i) place_.set(contacts.node_at(reading_[i].node, pair.h), i);
  taken_.assign(reading_.size(), 0);
  std::vector<std::size_t> grown;
  for (std::size_t i = 0; i < reading_.size(); ++i) {
    if (taken_[i]) continue;
    taken_[i] = 1;
    grown.assign(1, i);
    for (std::size_t k = 0; k < grown.size(); ++k)
      place_.for_around(contacts.node_at(reading_[grown[k]].node, pair.h), 1, [&](std::size_t j) {
        if (taken_[j] || reading_[j].normal.dot(reading_[i].normal) < kAlikeAtEdge) return;
        taken_[j] = 1;
        grown.push_back(j);
      });
    group_.clear();
    for (const std::size_t g : grown)
      if (reading_[g].gap < reading_[i].gap + kNearLeast * pair.h) group_.push_back(reading_[g]);
    add_points(pair.h);
  }
  return points_;
}

void EdgePoints::add_points(double h) {
  const double least = group_.front().gap;
  const auto weight = [&](const Reading& r) { return least + kNearLeast * h - r.gap; };
  double sum = 0.0, gap = 0.0;
  Vec3 middle = Vec3::Zero(), n = Vec3::Zero();
  for (const Reading& r : group_) {
    const double w = weight(r);
    sum += w, gap += w * r.gap, middle += w * r.point, n += w * r.normal;
  }
  gap /= sum, middle /= sum, n.normalize();
  Mat3 spread = Mat3::Zero();
  for (const Reading& r : group_) {
    Vec3 d = r.point - middle;
    d -= n * n.dot(d);
    spread += weight(r) / sum * d * d.transpose();
  }
  const SymmetricAxes axes = symmetric_axes(spread);
  const Vec3 along = axes.vectors.col(2);
  double lo = 0.0, hi = 0.0, rise = 0.0;
  for (const Reading& r : group_) {
    const double t = along.dot(r.point - middle);
    lo = std::min(lo, t), hi = std::max(hi, t);
    rise += weight(r) / sum * t * (r.gap - gap);
  }
  if (hi - lo < kLong * h) {
    points_.push_back({group_.front().node, middle, n, gap});
    return;
  }
  const double slope = rise / axes.values[2];
  for (const double t : {lo, hi}) points_.push_back({group_.front().node, middle + t * along, n, gap + slope * t});
}

}  // namespace brim
