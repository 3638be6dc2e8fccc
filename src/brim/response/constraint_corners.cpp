// Corners of the flat part of a patch, which carry its torque.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "brim/contact/face_corner.h"
#include "brim/response/constraint.h"

namespace brim {

namespace {

/// [voxels] rise of the gap by curvature up to which a node belongs to the flat part of a patch.
constexpr double kFlat = 0.05;
/// [voxels] from the outermost node of a face inwards, from where its corner is searched.
constexpr double kInwards = 1.0;
/// Cosine of normals that count as those of one face; share of its limit from which on friction counts as that of
/// sliding; largest lever of friction about the centre of the load that is left, relative to the size of the face.
constexpr double kOneNormal = 0.9999, kSlides = 0.999, kLever = 1e-4;

}  // namespace

void Constraint::add_corners(const ContactSet& contacts, const ContactPair& pair, const ConstraintPair& law,
                             const ConstraintOptions& options, const PatchModel& model, const RoundDirections& round,
                             std::size_t first, std::size_t center) {
  const double h = pair.h;
  // Nodes off the model lie beyond an edge, or on another surface with its own patch. Nodes that fit it belong to it at
  // any distance, even if it was fitted to others nearby.
  flat_.clear();
  for (const std::size_t c : rest_)
    if (model.rise_at(contacts.point[c]) <= kFlat * h && model.turn_at(contacts.point[c]).norm() <= kAlongArc &&
        std::abs(model.gap_at(contacts.point[c]) + contacts.depth[c]) <= kFlat * h)
      flat_.push_back(c);
  if (flat_.empty()) return;
  const auto farthest = [&](const auto& measure) {
    std::size_t best = flat_.front();
    for (const std::size_t c : flat_)
      if (measure(contacts.point[c]) > measure(contacts.point[best]) + 1e-9 * h) best = c;
    return best;
  };
  // Corners: the two farthest apart, and the farthest on either side of the line between them.
  const std::size_t one = farthest([&](const Vec3& y) { return (y - model.least_point).norm(); });
  const Vec3 from = contacts.point[one];
  const std::size_t two = farthest([&](const Vec3& y) { return (y - from).norm(); });
  Vec3 across = model.n.cross(contacts.point[two] - from);
  if (across.norm() > 0.0) across.normalize();
  const std::size_t left = farthest([&](const Vec3& y) { return across.dot(y - from); });
  const std::size_t right = farthest([&](const Vec3& y) { return -across.dot(y - from); });
  double least = std::numeric_limits<double>::infinity();
  const std::size_t corners = points_.size();
  const auto add = [&](std::size_t c, const Vec3& y, double gap) {
    for (std::size_t i = first; i < points_.size(); ++i)
      if ((points_.point[i] - y).norm() <= kApart * h) return;
    add_point(contacts, c, y, model.normal_at(y), gap, law, {model.bend_a, model.bend_b});
    least = std::min(least, gap);
  };
  // Gaps from the model: bodies would rock on the noise of single nodes.
  const auto add_face = [&](std::size_t c, const Vec3& y) { add(c, y, model.gap_at(y)); };
  if (options.side_a != nullptr && model.bend_a.isZero(0.0) && model.bend_b.isZero(0.0)) {
    // A face ends at its edge, not at its outermost node.
    const FaceCorner face(*options.side_a, *options.side_b, h, {model.x, model.n, model.gap, model.slope});
    for (const std::size_t c : {one, two, left, right}) {
      const Vec3 x = contacts.point[c], out = x - model.x;
      const Vec3 inside = x - std::min(1.0, kInwards * h / out.norm()) * out;
      add_face(c, face.find(inside, out).value_or(x));
    }
    // Few nodes may all lead to one corner: those opposite to it and across.
    if (corners < points_.size()) {
      const Vec3 out = points_.point[corners] - model.x, aside = model.n.cross(out);
      for (const Vec3& way : {Vec3(-out), aside, Vec3(-aside)})
        if (points_.size() < corners + 4)
          if (const auto y = face.find(model.x, way)) add_face(one, *y);
    }
  } else {
    // Where the gap is round, a corner ahead would stop what rolls on to it: corners lie along the line of least gap.
    for (const std::size_t c : {one, two, left, right}) {
      const Vec3& x = contacts.point[c];
      const auto settled =
          options.side_a != nullptr ? settle_round_gap(*options.side_a, *options.side_b, x, round, h) : std::nullopt;
      if (settled)
        add(c, settled->x, settled->gap);
      else
        add_face(c, x);
    }
  }
  place_friction(contacts, model, corners);
  // Between three or four corners the first point is redundant, unless it is deeper.
  if (points_.size() >= center + 4 && -points_.depth[center] > least - 0.5 * kFlat * h) remove_point(center);
}

void Constraint::place_friction(const ContactSet& contacts, const PatchModel& model, std::size_t first) {
  // Nodes cover the patch evenly: friction at its corners acts at their mean distance from the middle.
  if (points_.size() < first + 2) return;
  const auto across = [&](const Vec3& x) { return Vec3(x - model.n * model.n.dot(x)); };
  Vec3 middle = Vec3::Zero();
  for (const std::size_t c : flat_) middle += contacts.point[c] / static_cast<double>(flat_.size());
  double radius = 0.0, mean = 0.0;
  for (const std::size_t c : flat_)
    radius += across(contacts.point[c] - middle).norm() / static_cast<double>(flat_.size());
  for (std::size_t i = first; i < points_.size(); ++i)
    mean += across(points_.point[i] - middle).norm() / static_cast<double>(points_.size() - first);
  if (!(mean > radius)) return;
  for (std::size_t i = first; i < points_.size(); ++i)
    grip_[i] += (radius / mean - 1.0) * across(points_.point[i] - middle);
}

bool Constraint::center_friction(std::span<const Vec3> force, std::span<const std::uint8_t> pairs,
                                 std::vector<Vec3>& way) {
  way.assign(points_.size(), Vec3::Zero());
  std::vector<std::uint8_t> taken(points_.size(), 0);
  std::vector<std::size_t> face;
  bool any = false;
  for (std::size_t p = 0; p < points_.pairs.size(); ++p) {
    const ContactPair& pair = points_.pairs[p];
    for (std::size_t first = pair.begin; first < pair.end && pairs[p]; ++first) {
      if (taken[first]) continue;
      const Vec3 n = normal_[first];
      face.clear();
      double load = 0.0;
      Vec3 along = Vec3::Zero(), center = Vec3::Zero(), off = Vec3::Zero();
      bool slides = true, apart = false;
      for (std::size_t c = first; c < pair.end; ++c) {
        if (taken[c] || normal_[c].dot(n) < kOneNormal) continue;
        taken[c] = 1, face.push_back(c);
        apart = apart || grip_[c] != points_.point[c];
        const double l = force[c].dot(n);
        if (!(l > 0.0)) continue;
        const Vec3 t = force[c] - l * n;
        slides = slides && t.norm() > kSlides * friction_[c] * l;
        load += l, along += t, center += l * points_.point[c], off += l * (points_.point[c] - grip_[c]);
      }
      if (!apart || face.size() < 2 || !slides || !(load > 0.0)) continue;
      center /= load, off /= load;
      // Equal shares of the distances from the centre: however the points share the load, its centre is that of
      // friction.
      Vec3 middle_x = Vec3::Zero(), middle_g = Vec3::Zero();
      for (const std::size_t c : face) middle_x += points_.point[c], middle_g += grip_[c];
      middle_x /= static_cast<double>(face.size()), middle_g /= static_cast<double>(face.size());
      double size_x = 0.0, size_g = 0.0;
      for (const std::size_t c : face)
        size_x += (points_.point[c] - middle_x).squaredNorm(), size_g += (grip_[c] - middle_g).squaredNorm();
      const double size = std::sqrt(size_x / static_cast<double>(face.size())), share = std::sqrt(size_g / size_x);
      if (!(std::abs(n.dot(off.cross(along))) > kLever * size * along.norm())) continue;
      for (const std::size_t c : face) {
        const Vec3 in = (share - 1.0) * (points_.point[c] - center);
        const Vec3 grip = points_.point[c] + in - normal_[c] * normal_[c].dot(in);
        way[c] = grip - grip_[c], grip_[c] = grip;
      }
      any = true;
    }
  }
  return any;
}

}  // namespace brim
