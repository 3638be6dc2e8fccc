#include <numbers>

#include "brim/body/obstacle/obstacle_body.h"
#include "brim/scene/kinds.h"
#include "brim/scene/motion.h"
#include "brim/scene/solid.h"

namespace brim {

BodyKind obstacle_kind();

namespace {

void check_obstacle(const Node& n) {
  check_shape(n.at("shape"));
  if (!n.has("keyframes")) return;
  for (const char* key : {"velocity", "angular_velocity"})
    if (n.vec3(key) != Vec3::Zero())
      throw n.at(key).error("both a velocity and \"keyframes\" are given; give one of them");
  check_key_times(n.at("keyframes"));
}

/// Even motion as keys: straight ones need two, turning ones one every 30 degrees.
std::vector<PoseKey> even_motion(const Placement& p, double duration) {
  std::vector<PoseKey> keys = {{0.0, p.position, p.rotation}};
  const double spin = p.angular_velocity.norm();
  if (spin == 0.0 && p.velocity.norm() == 0.0) return keys;
  const int count = 1 + static_cast<int>(spin * duration / (std::numbers::pi / 6.0));
  for (int i = 1; i <= count; ++i) {
    const double t = duration * i / count;
    const Quat turn = spin > 0.0 ? Quat(Eigen::AngleAxisd(spin * t, p.angular_velocity / spin)) : Quat::Identity();
    keys.push_back({t, p.position + t * p.velocity, turn * p.rotation});
  }
  return keys;
}

class ObstacleMaker final : public BodyMaker {
 public:
  ObstacleMaker(const Node& n, const BuildContext& context)
      : node_(n),
        solid_(read_solid(n, context.world.memory_limit, context.solids)),
        material_(context.material),
        duration_(context.duration) {
    const double spin = n.vec3("angular_velocity").norm();
    if (spin * duration_ > 1e5)
      throw n.at("angular_velocity")
          .error(fmt::format("{} rad/s over {} s is too much; at most 1e5 rad in all", spin, duration_));
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    ObstacleModel model;
    model.shape = solid_.shape;
    if (node_.has("keyframes")) {
      model.keys.clear();
      for (const MotionKey& k : read_motion(node_.at("keyframes"), place.turned))
        model.keys.push_back({k.time, place.position + k.offset, k.rotation * place.rotation});
    } else {
      model.keys = even_motion(place, duration_);
    }
    model.part.voxel_size = solid_.voxel_size;
    model.part.thickness = solid_.shape->thickness();
    if (solid_.unit.volume > 0.0)
      model.part.width = width_of(solid_.unit.volume, model.part.thickness, solid_.shape->bounds());
    model.part.material = material_;
    model.surface = solid_.surface;
    return std::make_unique<ObstacleBody>(std::move(model));
  }

 private:
  Node node_;
  Solid solid_;
  Material material_;
  double duration_;
};

}  // namespace

BodyKind obstacle_kind() {
  return {"obstacle", check_obstacle, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<ObstacleMaker>(n, c);
          }};
}

}  // namespace brim
