// A kind of body of one's own: a ball of jelly that stretches and shears evenly, x = c + A X, with twelve coordinates.
// Energy per volume k |AᵀA − 1|² (orthogonality potential of affine bodies: Lan et al. 2022).
#include <brim/body/own/own_body.h>
#include <brim/mesh/primitives.h>
#include <brim/scene/own_kind.h>

namespace {

using brim::Mat3, brim::Vec3;

class Jelly final : public brim::OwnBody {
 public:
  Jelly(brim::OwnModel model, double radius, double k) : OwnBody(std::move(model)), radius_(radius), k_(k) {}
  std::string_view kind() const override { return "jelly"; }

  Vec3 deform(Coordinates q, const Vec3& X) const override { return c(q) + A(q) * X; }
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override { return A(q).inverse() * (x - c(q)); }
  double distance(Coordinates q, const Vec3& x) const override {
    const Mat3 back = A(q).inverse();
    const Vec3 X = back * (x - c(q));
    const double r = std::max(X.norm(), 1e-9);
    return (r - radius_) / (back.transpose() * X / r).norm();  // over the slope: a distance near the surface
  }
  double energy(Coordinates q) const override {
    const double volume = 4.0 / 3.0 * 3.14159265358979 * radius_ * radius_ * radius_;
    return k_ * volume * (A(q).transpose() * A(q) - Mat3::Identity()).squaredNorm();
  }

 private:
  static Vec3 c(Coordinates q) { return Eigen::Map<const Vec3>(q.data()); }
  static Mat3 A(Coordinates q) { return Eigen::Map<const Mat3>(q.data() + 3); }
  double radius_, k_;  // [m], [Pa]
};

const bool added = brim::add_body_kind(
    "jelly", R"({"radius": {"type": "number", "exclusiveMinimum": 0, "description": "[m]"},
                 "stiffness": {"type": "number", "exclusiveMinimum": 0, "default": 2e4, "description": "[Pa]"}})",
    [](const brim::OwnEntry& entry) {
      const double radius = entry.place.scale * entry.number("radius");
      brim::OwnModel model;
      const Mat3 A = entry.place.rotation.toRotationMatrix(), spin = brim::skew(entry.place.angular_velocity) * A;
      const Vec3 &c = entry.place.position, &u = entry.place.velocity;
      model.q = {c.x(), c.y(), c.z()};
      model.v = {u.x(), u.y(), u.z()};
      model.q.insert(model.q.end(), A.data(), A.data() + 9);
      model.v.insert(model.v.end(), spin.data(), spin.data() + 9);
      model.surface = brim::shapes::icosphere(radius, 3);
      model.density = 500;
      model.voxel_size = entry.number("voxel_size");
      model.material = entry.material;
      return std::make_unique<Jelly>(std::move(model), radius, entry.number("stiffness"));
    });

}  // namespace
