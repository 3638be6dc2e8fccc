// Corners of the flat part of a patch, which carry its torque.
#include <algorithm>
#include <limits>

#include "brim/contact/face_corner.h"
#include "brim/response/constraint.h"

namespace brim {

namespace {

/// [voxels] rise of the gap by curvature up to which a node belongs to the flat part of a patch.
constexpr double kFlat = 0.05;
/// [voxels] from the outermost node of a face inwards, from where its corner is searched.
constexpr double kInwards = 1.0;

}  // namespace

void Constraint::add_corners(const ContactSet& contacts, const ContactPair& pair, const ConstraintPair& law,
                             const ConstraintOptions& options, const PatchModel& model, std::size_t first,
                             std::size_t center) {
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
  const auto add = [&](std::size_t c, const Vec3& y) {
    for (std::size_t i = first; i < points_.size(); ++i)
      if ((points_.point[i] - y).norm() <= kApart * h) return;
    // Gaps from the model: bodies would rock on the noise of single nodes.
    const double gap = model.gap_at(y);
    add_point(contacts, c, y, model.normal_at(y), gap, law, {model.bend_a, model.bend_b});
    least = std::min(least, gap);
  };
  if (options.side_a != nullptr && model.bend_a.isZero(0.0) && model.bend_b.isZero(0.0)) {
    // A face ends at its edge, not at its outermost node.
    const FaceCorner face(*options.side_a, *options.side_b, h, {model.x, model.n, model.gap, model.slope});
    for (const std::size_t c : {one, two, left, right}) {
      const Vec3 x = contacts.point[c], out = x - model.x;
      const Vec3 inside = x - std::min(1.0, kInwards * h / out.norm()) * out;
      add(c, face.find(inside, out).value_or(x));
    }
    // Few nodes may all lead to one corner: those opposite to it and across.
    if (corners < points_.size()) {
      const Vec3 out = points_.point[corners] - model.x, aside = model.n.cross(out);
      for (const Vec3& way : {Vec3(-out), aside, Vec3(-aside)})
        if (points_.size() < corners + 4)
          if (const auto y = face.find(model.x, way)) add(one, *y);
    }
  } else {
    for (const std::size_t c : {one, two, left, right}) add(c, contacts.point[c]);
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

}  // namespace brim
