#include "brim/raster/shape.h"

#include "brim/core/error.h"
#include "brim/raster/ball_share.h"
#include "brim/raster/cube_distances.h"
#include "brim/raster/place_distances.h"
#include "brim/raster/shape_of.h"

namespace brim {

Aabb Shape::placed_bounds(const Pose& pose) const {
  const Aabb b = bounds();
  if (!b.lo.allFinite() || !b.hi.allFinite())
    return {Vec3::Constant(-std::numeric_limits<double>::infinity()),
            Vec3::Constant(std::numeric_limits<double>::infinity())};
  const Vec3 c = pose.rotation * b.center() + pose.translation;
  const Vec3 e = pose.rotation.cwiseAbs() * (0.5 * b.extent());
  return {c - e, c + e};
}

namespace {

class Sphere final : public RoundedShapeOf<Sphere, ConvexShapeOf<Sphere>> {
 public:
  explicit Sphere(double r) : r_(r) {}
  double operator()(const Vec3& p) const { return p.norm() - r_; }
  double share(const Vec3& p, double w) const { return ball_share_of_sphere(p, w, r_); }
  double distance_and_gradient(const Vec3& p, Vec3& gradient) const override {
    const double r = p.norm();
    gradient = r > 0.0 ? Vec3(p / r) : Vec3(Vec3::Zero());
    return r - r_;
  }
  Vec3 support(const Vec3& direction) const override { return r_ * direction.normalized(); }
  void cube_distances(const Pose& pose, const NodeCube& cube, const NodeMask& wanted, double, float* d) const override {
    sphere_distances({pose, cube}, r_, wanted, d);
  }
  void distances(const PlaceArrays& at, double* d) const override { sphere_distances(at, r_, d); }
  Aabb bounds() const override { return {Vec3::Constant(-r_), Vec3::Constant(r_)}; }
  Aabb placed_bounds(const Pose& pose) const override {
    return {pose.translation - Vec3::Constant(r_), pose.translation + Vec3::Constant(r_)};
  }
  double thickness() const override { return 2 * r_; }

 private:
  double r_;
};

class Box final : public RoundedShapeOf<Box, ConvexShapeOf<Box>> {
 public:
  explicit Box(const Vec3& extents) : half_(0.5 * extents) {}
  double operator()(const Vec3& p) const {
    const Vec3 d = p.cwiseAbs() - half_;
    return d.cwiseMax(0.0).norm() + std::min(d.maxCoeff(), 0.0);
  }
  double share(const Vec3& p, double w) const { return ball_share_of_box(p, w, half_); }
  double distance_and_gradient(const Vec3& p, Vec3& gradient) const override {
    const Vec3 d = p.cwiseAbs() - half_;
    Eigen::Index axis = 0;
    const double most = d.maxCoeff(&axis);
    const auto sign = [&](Eigen::Index a) { return std::copysign(1.0, p[a]); };
    if (most <= 0.0) {
      gradient = sign(axis) * Vec3::Unit(axis);
      return most;
    }
    const Vec3 out = d.cwiseMax(0.0);
    const double length = out.norm();
    gradient = Vec3(sign(0) * out[0], sign(1) * out[1], sign(2) * out[2]) / length;
    return length;
  }
  Vec3 support(const Vec3& direction) const override {
    return half_.binaryExpr(direction, [](double size, double along) { return std::copysign(size, along); });
  }
  void cube_distances(const Pose& pose, const NodeCube& cube, const NodeMask& wanted, double, float* d) const override {
    box_distances({pose, cube}, half_, wanted, d);
  }
  void distances(const PlaceArrays& at, double* d) const override { box_distances(at, half_, d); }
  Aabb bounds() const override { return {-half_, half_}; }
  double thickness() const override { return 2 * half_.minCoeff(); }

 private:
  Vec3 half_;
};

class CapsuleShape final : public RoundedShapeOf<CapsuleShape, ConvexShapeOf<CapsuleShape>> {
 public:
  CapsuleShape(double r, double length) : r_(r), half_(0.5 * length) {}
  double operator()(const Vec3& p) const {
    const double z = p.z() - std::clamp(p.z(), -half_, half_);
    return std::sqrt(p.x() * p.x() + p.y() * p.y() + z * z) - r_;
  }
  double share(const Vec3& p, double w) const { return ball_share_of_capsule(p, w, r_, half_); }
  double distance_and_gradient(const Vec3& p, Vec3& gradient) const override {
    const Vec3 d(p.x(), p.y(), p.z() - std::clamp(p.z(), -half_, half_));
    const double r = d.norm();
    gradient = r > 0.0 ? Vec3(d / r) : Vec3(Vec3::Zero());
    return r - r_;
  }
  Vec3 support(const Vec3& direction) const override {
    return r_ * direction.normalized() + std::copysign(half_, direction.z()) * Vec3::UnitZ();
  }
  void cube_distances(const Pose& pose, const NodeCube& cube, const NodeMask& wanted, double, float* d) const override {
    capsule_distances({pose, cube}, r_, half_, wanted, d);
  }
  void distances(const PlaceArrays& at, double* d) const override { capsule_distances(at, r_, half_, d); }
  Aabb bounds() const override { return {Vec3(-r_, -r_, -half_ - r_), Vec3(r_, r_, half_ + r_)}; }
  double thickness() const override { return 2 * r_; }

 private:
  double r_, half_;
};

class Cylinder final : public RoundedShapeOf<Cylinder, ConvexShapeOf<Cylinder>> {
 public:
  Cylinder(double r, double height) : r_(r), half_(0.5 * height) {}
  double operator()(const Vec3& p) const {
    const double dr = std::hypot(p.x(), p.y()) - r_;
    const double dz = std::abs(p.z()) - half_;
    return std::hypot(std::max(dr, 0.0), std::max(dz, 0.0)) + std::min(std::max(dr, dz), 0.0);
  }
  double share(const Vec3& p, double w) const { return ball_share_of_cylinder(p, w, r_, half_); }
  double distance_and_gradient(const Vec3& p, Vec3& gradient) const override {
    const double r = std::hypot(p.x(), p.y()), dr = r - r_, dz = std::abs(p.z()) - half_;
    const Vec3 side = r > 0.0 ? Vec3(p.x() / r, p.y() / r, 0.0) : Vec3(Vec3::Zero());
    const Vec3 end(0.0, 0.0, std::copysign(1.0, p.z()));
    if (dr <= 0.0 || dz <= 0.0) {
      gradient = dr > dz ? side : end;
      return std::max(dr, dz);
    }
    const double d = std::hypot(dr, dz);
    gradient = (dr * side + dz * end) / d;
    return d;
  }
  Vec3 support(const Vec3& direction) const override {
    const double along = std::hypot(direction.x(), direction.y()), size = along > 0.0 ? r_ / along : 0.0;
    return {size * direction.x(), size * direction.y(), std::copysign(half_, direction.z())};
  }
  void cube_distances(const Pose& pose, const NodeCube& cube, const NodeMask& wanted, double, float* d) const override {
    cylinder_distances({pose, cube}, r_, half_, wanted, d);
  }
  Aabb bounds() const override { return {Vec3(-r_, -r_, -half_), Vec3(r_, r_, half_)}; }
  double thickness() const override { return 2 * std::min(r_, half_); }

 private:
  double r_, half_;
};

class HalfSpace final : public ConvexShapeOf<HalfSpace> {
 public:
  double operator()(const Vec3& p) const { return p.z(); }
  double distance_and_gradient(const Vec3& p, Vec3& gradient) const override {
    gradient = Vec3::UnitZ();
    return p.z();
  }
  Vec3 support(const Vec3&) const override { return Vec3::Constant(std::numeric_limits<double>::infinity()); }
  void cube_distances(const Pose& pose, const NodeCube& cube, const NodeMask& wanted, double, float* d) const override {
    half_space_distances({pose, cube}, wanted, d);
  }
  bool half_space() const override { return true; }
  Aabb bounds() const override {
    const double inf = std::numeric_limits<double>::infinity();
    return {Vec3::Constant(-inf), Vec3(inf, inf, 0.0)};
  }
  /// Finite on the open side when the plane is aligned with an axis.
  Aabb placed_bounds(const Pose& pose) const override {
    const double inf = std::numeric_limits<double>::infinity();
    Aabb b{Vec3::Constant(-inf), Vec3::Constant(inf)};
    const Vec3 n = pose.rotation.col(2);
    for (int a = 0; a < 3; ++a) {
      if (n[a] == 1.0) b.hi[a] = pose.translation[a];
      if (n[a] == -1.0) b.lo[a] = pose.translation[a];
    }
    return b;
  }
  double thickness() const override { return std::numeric_limits<double>::infinity(); }
};

}  // namespace

std::shared_ptr<const Shape> make_sphere(double radius) {
  check_length("sphere radius", radius);
  return std::make_shared<Sphere>(radius);
}

std::shared_ptr<const Shape> make_box(const Vec3& extents) {
  for (int a = 0; a < 3; ++a) check_length("box extent", extents[a]);
  return std::make_shared<Box>(extents);
}

std::shared_ptr<const Shape> make_capsule(double radius, double length) {
  check_length("capsule radius", radius);
  check_length("capsule length", length);
  return std::make_shared<CapsuleShape>(radius, length);
}

std::shared_ptr<const Shape> make_cylinder(double radius, double height) {
  check_length("cylinder radius", radius);
  check_length("cylinder height", height);
  return std::make_shared<Cylinder>(radius, height);
}

std::shared_ptr<const Shape> make_half_space() { return std::make_shared<HalfSpace>(); }

void shape_presence(const Shape& shape, const Pose& pose, double h, double w, const Aabb& region,
                    std::vector<TileKey>& out) {
  const double margin = 0.5 * w + kHalo * h;
  const Aabb box = shape.placed_bounds(pose).inflated(margin).intersection(region);
  if (box.empty()) return;
  const TileRange r = tiles_meeting(box, h);
  const double half = 0.5 * (kBlockSize - 1) * h;  // the block, halo included
  const double reach = std::sqrt(3.0) * half + 0.5 * w;
  for (std::int32_t z = r.lo.z; z <= r.hi.z; ++z)
    for (std::int32_t y = r.lo.y; y <= r.hi.y; ++y)
      for (std::int32_t x = r.lo.x; x <= r.hi.x; ++x) {
        const Vec3 center = tile_box({x, y, z}, h).center();
        if (shape.distance(pose.to_local(center)) <= reach) out.push_back({x, y, z});
      }
}

}  // namespace brim
