#include "brim/body/rigid/make_rigid.h"

#include <algorithm>
#include <cmath>

#include "brim/core/error.h"
#include "brim/raster/convex_distance.h"

namespace brim {

namespace {

/// Bisections of the box along each axis: 128 cells.
constexpr int kDepth = 7;
/// [voxels] across the smallest extent of a shape.
constexpr double kVoxelsAcross = 8.0;

/// Integrals over the inside of a shape, about the middle of its box.
struct Moments {
  double volume = 0.0, area = 0.0;
  Vec3 first = Vec3::Zero();   ///< ∫ x
  Mat3 second = Mat3::Zero();  ///< ∫ x xᵀ

  /// Adds a share of a cell of sides 2 half.
  void add(const Vec3& x, const Vec3& half, double share) {
    const double v = share * 8.0 * half.prod();
    volume += v, first += v * x;
    second += v * (x * x.transpose());
    second.diagonal() += v / 3.0 * half.cwiseAbs2();
  }
};

class ShapeIntegral {
 public:
  explicit ShapeIntegral(const Shape& shape)
      : shape_(shape), known_(dynamic_cast<const ConvexDistance*>(&shape)), middle_(shape.bounds().center()) {
    split(Vec3::Zero(), 0.5 * shape.bounds().extent(), kDepth);
  }
  const Moments& moments() const { return moments_; }
  const Vec3& middle() const { return middle_; }

 private:
  double distance(const Vec3& x) const { return shape_.distance(middle_ + x); }

  /// The gradient of the distance, of any length.
  Vec3 slope(const Vec3& x, const Vec3& half) const {
    Vec3 n;
    if (known_ != nullptr) {
      known_->distance_and_gradient(middle_ + x, n);
      return n;
    }
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 step = 0.5 * half[axis] * Vec3::Unit(axis);
      n[axis] = (distance(x + step) - distance(x - step)) / half[axis];
    }
    return n;
  }

  void split(const Vec3& x, const Vec3& half, int depth) {
    const double d = distance(x), reach = half.norm();
    if (d >= reach) return;
    if (d <= -2.0 * reach) return moments_.add(x, half, 1.0);  // the surface is out of reach of the area's average too
    if (depth == 0) return cut(x, half, d);
    for (int octant = 0; octant < 8; ++octant) {
      Vec3 to = 0.5 * half;
      for (int axis = 0; axis < 3; ++axis)
        if ((octant >> axis & 1) == 0) to[axis] = -to[axis];
      split(x + to, 0.5 * half, depth - 1);
    }
  }

  /// A cell near the surface, as one that a plane cuts. With n the normal and s = Σ |n_a| times the sides of the cell,
  ///   inside: 1/2 − d/s, between 0 and 1;  area: the average of 2 (1 − |d|/s) / s over the inside
  /// Exact for faces along the axes between cells, second order in the sides for others.
  void cut(const Vec3& x, const Vec3& half, double d) {
    const Vec3 n = slope(x, half);
    const double length = n.norm();
    if (!(length > 0.0)) return moments_.add(x, half, d < 0.0 ? 1.0 : 0.0);
    const double s = 2.0 * n.cwiseAbs().dot(half) / length;
    moments_.add(x, half, std::clamp(0.5 - d / s, 0.0, 1.0));
    if (d < 0.0) moments_.area += 8.0 * half.prod() * 2.0 * std::max(0.0, 1.0 + d / s) / s;
  }

  const Shape& shape_;
  const ConvexDistance* known_;  ///< null: its gradient is found by differences
  Vec3 middle_;
  Moments moments_;
};

}  // namespace

RigidModel make_rigid(std::shared_ptr<const Shape> shape, double density, const Vec3& position, const Quat& rotation) {
  if (shape == nullptr) throw InputError("make_rigid: there is no shape; give one, such as make_sphere(0.1)");
  if (!(density > 0.0) || !std::isfinite(density))
    throw InputError(fmt::format("make_rigid: density {} is not allowed; must be a number above 0 [kg/m³]", density));
  const Aabb box = shape->bounds();
  if (!box.lo.allFinite() || !box.hi.allFinite() || !(box.extent().minCoeff() > 0.0))
    throw InputError("make_rigid: the shape has no finite extent, and so no mass; make an obstacle of it");
  const ShapeIntegral integral(*shape);
  const Moments& m = integral.moments();
  if (!(m.volume > 0.0)) throw InputError("make_rigid: the shape has no inside, and so no mass");
  const Vec3 center = m.first / m.volume;
  const Mat3 spread = m.second - m.volume * (center * center.transpose());

  RigidModel model;
  model.center_of_mass = integral.middle() + center;
  model.mass = density * m.volume;
  model.volume = m.volume;
  model.inertia = density * (spread.trace() * Mat3::Identity() - spread);
  model.position = position;
  model.rotation = rotation;
  model.part.voxel_size = box.extent().minCoeff() / kVoxelsAcross;
  // Six times volume over area is a box's column and a ball's diameter.
  model.part.areal_mass = 6.0 * model.mass / m.area;
  model.part.thickness = shape->thickness();
  model.part.width = width_of(m.volume, model.part.thickness, box);
  model.shape = std::move(shape);
  return model;
}

}  // namespace brim
