#include <numbers>

#include "brim/body/points/points_body.h"
#include "brim/scene/kinds.h"
#include "brim/scene/limits.h"

namespace brim {

BodyKind points_kind();

namespace {

/// [bytes] that a grain with its pairs and state takes.
constexpr double kBytesPerGrain = 2000.0;

void check_points(const Node& n) {
  if (n.has("grid") && n.has("positions"))
    throw n.at("positions").error("both \"grid\" and \"positions\" are given; give one");
  if (!n.has("grid") && !n.has("positions")) throw n.error("the grains are missing; give \"grid\" or \"positions\"");
}

class PointsMaker final : public BodyMaker {
 public:
  PointsMaker(const Node& n, const BuildContext& context)
      : node_(n),
        material_(context.material),
        time_step_(context.world.time_step),
        gravity_(context.world.environment.gravity.norm()) {
    const double scale = n.at("transform").number("scale"), limit = context.world.memory_limit;
    const double radius = scale * n.number("radius");
    if (n.has("positions")) {
      const Node list = n.at("positions");
      check_count(list, static_cast<double>(list.size()), kBytesPerGrain, limit, "grains");
      for (std::size_t i = 0; i < list.size(); ++i) centers_.push_back(scale * list.at(i).vec3());
    } else {
      fill_grid(n.at("grid"), radius, scale, limit);
    }
    SceneRandom random(static_cast<std::uint64_t>(n.integer("seed")) ^ 0x5bd1e995u);
    const double spread = n.number("radius_spread");
    double area = 0.0;
    for (std::size_t i = 0; i < centers_.size(); ++i) {
      radius_.push_back(radius * (1.0 + spread * random.symmetric()));
      area += 4.0 * std::numbers::pi * radius_.back() * radius_.back();
    }
    const double voxel = n.number("voxel_size");
    check_voxel_size(n, voxel > 0.0 ? voxel : radius * (1.0 - spread) / 1.5, area, limit);
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    std::vector<Vec3> centers = centers_;
    for (Vec3& x : centers) x = place.position + place.rotation * x;
    PointsOptions options;
    options.radius = radius_;
    options.density = node_.number("density");
    options.young = node_.number("young_modulus");
    options.friction = node_.number_if("inner_friction").value_or(material_.friction);
    options.turn = node_.boolean("turn");
    options.rolling_friction = node_.number("rolling_friction");
    options.gravity = gravity_;
    options.slip_speed = std::max(1e-3 * gravity_ * time_step_, 1e-9);
    options.stiffness_damping = node_.number_if("contact_damping").value_or(2.0 * time_step_);
    options.mass_damping = node_.number("mass_damping");
    options.initial_velocity = place.velocity;
    options.voxel_size = node_.number("voxel_size");
    options.material = material_;
    return std::make_unique<PointsBody>(std::move(centers), std::move(options));
  }

 private:
  void fill_grid(const Node& grid, double radius, double scale, double limit) {
    const std::vector<int> count = grid.at("count").integers();
    check_count(grid.at("count"), 1.0 * count[0] * count[1] * count[2], kBytesPerGrain, limit, "grains");
    const double spacing = grid.has("spacing") ? scale * grid.number("spacing") : 2.1 * radius;
    const double jitter = scale * grid.number("jitter");
    SceneRandom random(static_cast<std::uint64_t>(node_.integer("seed")));
    for (int k = 0; k < count[2]; ++k)
      for (int j = 0; j < count[1]; ++j)
        for (int i = 0; i < count[0]; ++i) {
          const Vec3 cell(i - 0.5 * (count[0] - 1), j - 0.5 * (count[1] - 1), k);
          const double x = random.symmetric(), y = random.symmetric(), z = random.symmetric();
          centers_.push_back(spacing * cell + jitter * Vec3(x, y, z));
        }
  }

  Node node_;
  Material material_;
  double time_step_, gravity_;
  std::vector<Vec3> centers_;  ///< scaled, not placed
  std::vector<double> radius_;
};

}  // namespace

BodyKind points_kind() {
  return {"points", check_points, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<PointsMaker>(n, c);
          }};
}

}  // namespace brim
