#include <cmath>

#include "brim/core/error.h"
#include "brim/raster/ball_share.h"
#include "brim/raster/cube_distances.h"
#include "brim/raster/shape.h"
#include "brim/raster/shape_of.h"

/// Solids of revolution about z that are not convex, by the exact distance to their outline in (s, z), s the distance
/// from the axis.
namespace brim {

namespace {

class Torus final : public RoundedShapeOf<Torus, ShapeOf<Torus>> {
 public:
  Torus(double radius, double tube) : radius_(radius), tube_(tube) {}
  double operator()(const Vec3& p) const { return std::hypot(std::hypot(p.x(), p.y()) - radius_, p.z()) - tube_; }
  double share(const Vec3& p, double w) const { return ball_share_of_torus(p, w, radius_, tube_); }
  void cube_distances(const Pose& pose, const NodeCube& cube, const NodeMask& wanted, double, float* d) const override {
    torus_distances({pose, cube}, radius_, tube_, wanted, d);
  }
  Aabb bounds() const override {
    const double out = radius_ + tube_;
    return {Vec3(-out, -out, -tube_), Vec3(out, out, tube_)};
  }
  double thickness() const override { return 2.0 * tube_; }

 private:
  double radius_, tube_;
};

class Bowl final : public RoundedShapeOf<Bowl, ShapeOf<Bowl>> {
 public:
  Bowl(double radius, double thickness) : middle_(radius - 0.5 * thickness), half_(0.5 * thickness) {}
  double operator()(const Vec3& p) const {
    const double s = std::hypot(p.x(), p.y());
    return (p.z() <= 0.0 ? std::abs(std::hypot(s, p.z()) - middle_) : std::hypot(s - middle_, p.z())) - half_;
  }
  double share(const Vec3& p, double w) const { return ball_share_of_bowl(p, w, middle_, half_); }
  void cube_distances(const Pose& pose, const NodeCube& cube, const NodeMask& wanted, double, float* d) const override {
    bowl_distances({pose, cube}, middle_, half_, wanted, d);
  }
  Aabb bounds() const override {
    const double out = middle_ + half_;
    return {Vec3::Constant(-out), Vec3(out, out, half_)};
  }
  double thickness() const override { return 2.0 * half_; }

 private:
  double middle_, half_;
};

class Cup final : public RoundedShapeOf<Cup, ShapeOf<Cup>> {
 public:
  Cup(double radius, double height, double thickness) : radius_(radius), height_(height), thickness_(thickness) {}
  double operator()(const Vec3& p) const {
    const double s = std::hypot(p.x(), p.y()), inner = radius_ - thickness_;
    // Above the opening the rim and the floor are near, not the lid that the outer cylinder would have.
    if (p.z() > height_ && s < inner) return std::min(std::hypot(inner - s, p.z() - height_), p.z() - thickness_);
    const double side = s - radius_, end = std::max(p.z() - height_, -p.z());
    const double outer = std::hypot(std::max(side, 0.0), std::max(end, 0.0)) + std::min(std::max(side, end), 0.0);
    const double wall = s - inner, floor = thickness_ - p.z();
    const double hollow = std::hypot(std::max(wall, 0.0), std::max(floor, 0.0)) + std::min(std::max(wall, floor), 0.0);
    return std::max(outer, -hollow);
  }
  double share(const Vec3& p, double w) const { return ball_share_of_cup(p, w, radius_, height_, thickness_); }
  void cube_distances(const Pose& pose, const NodeCube& cube, const NodeMask& wanted, double, float* d) const override {
    cup_distances({pose, cube}, radius_, height_, thickness_, wanted, d);
  }
  Aabb bounds() const override { return {Vec3(-radius_, -radius_, 0.0), Vec3(radius_, radius_, height_)}; }
  double thickness() const override { return thickness_; }

 private:
  double radius_, height_, thickness_;
};

void check_below(const char* what, double value, double most) {
  check_length(what, value);
  if (value >= most) throw InputError(fmt::format("{} is {}, but must be below {} [m]", what, value, most));
}

}  // namespace

std::shared_ptr<const Shape> make_torus(double radius, double tube) {
  check_length("torus radius", radius);
  check_below("torus tube", tube, radius);
  return std::make_shared<Torus>(radius, tube);
}

std::shared_ptr<const Shape> make_bowl(double radius, double thickness) {
  check_length("bowl radius", radius);
  check_below("bowl thickness", thickness, radius);
  return std::make_shared<Bowl>(radius, thickness);
}

std::shared_ptr<const Shape> make_cup(double radius, double height, double thickness) {
  check_length("cup radius", radius);
  check_length("cup height", height);
  check_below("cup thickness", thickness, std::min(radius, height));
  return std::make_shared<Cup>(radius, height, thickness);
}

}  // namespace brim
