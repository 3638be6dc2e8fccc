#include <cmath>

#include "brim/body/grid_fluid/grid_fluid_body.h"
#include "brim/scene/kinds.h"
#include "brim/scene/limits.h"

namespace brim {

BodyKind grid_fluid_kind();

namespace {

/// [bytes] that a cell with its faces, matrices and state takes.
constexpr double kBytesPerFluidCell = 1000.0;
/// [cells] by which a side of the box may miss a whole number of cells.
constexpr double kOddCells = 1e-3;
constexpr double kFar = 1e9;  // [m]

constexpr std::array<const char*, 6> kSides = {"-x", "+x", "-y", "+y", "-z", "+z"};

using Distance = std::function<double(const Vec3&)>;

/// Signed distance to a region of a scene, negative inside.
Distance distance_to(const Node& n) {
  const std::string kind = n.string("kind");
  if (kind == "sphere") {
    const Vec3 center = n.vec3("center");
    const double radius = n.number("radius");
    return [=](const Vec3& x) { return (x - center).norm() - radius; };
  }
  if (kind == "plane") {
    const Vec3 point = n.vec3("point"), normal = n.vec3("normal").normalized();
    return [=](const Vec3& x) { return (x - point).dot(normal); };
  }
  if (kind == "box") {
    const Vec3 lo = n.vec3("lo"), hi = n.vec3("hi");
    return [=](const Vec3& x) {
      const Vec3 d = (lo - x).cwiseMax(x - hi);
      return d.cwiseMax(0.0).norm() + std::min(d.maxCoeff(), 0.0);
    };
  }
  return [](const Vec3&) { return -kFar; };
}

void check_regions(const Node& list) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Node region = list.at(i);
    const std::string kind = region.string("kind");
    if (kind == "corners") throw region.at("kind").error("\"corners\" are those of a cloth; a fluid has none");
    if (kind == "plane" && !(region.vec3("normal").norm() > 0.0))
      throw region.at("normal").error("has no direction; give one that is not zero");
    if (kind == "box" && !(region.vec3("lo").array() < region.vec3("hi").array()).all())
      throw region.at("hi").error("must be above \"lo\" along every axis");
  }
}

void check_grid_fluid(const Node& n) {
  const Node box = n.at("box");
  const Vec3 extent = box.vec3("hi") - box.vec3("lo");
  const double dx = n.number("cell_size");
  if (!(extent.array() > 0.0).all()) throw box.at("hi").error("must be above \"lo\" along every axis");
  for (int a = 0; a < 3; ++a) {
    const double cells = extent[a] / dx;
    if (std::round(cells) < 1.0 || std::abs(cells - std::round(cells)) > kOddCells)
      throw n.at("cell_size")
          .error(fmt::format("{:.6g} m is not allowed; the box is {:.6g} m along {}, which must be a whole number of "
                             "cells and is {:.6g}",
                             dx, extent[a], "xyz"[a], cells));
  }
  const Node transform = n.at("transform");
  if (transform.has("rotation")) throw transform.at("rotation").error("a grid fluid's box cannot be turned");
  if (transform.number("scale") != 1.0)
    throw transform.at("scale").error("a grid fluid cannot be scaled; give other sizes");
  if (n.has("repeat") && n.at("repeat").string("turn") != "none")
    throw n.at("repeat").at("turn").error("a grid fluid's box cannot be turned");
  check_regions(n.at("fill"));
  check_regions(n.at("carve"));
}

class GridFluidMaker final : public BodyMaker {
 public:
  GridFluidMaker(const Node& n, const BuildContext& context) : node_(n), material_(context.material) {
    const Vec3 lo = n.at("box").vec3("lo"), extent = n.at("box").vec3("hi") - lo;
    model_.grid.origin = lo;
    model_.grid.dx = n.number("cell_size");
    const Vec3 cells = (extent / model_.grid.dx).array().round();
    check_count(n.at("cell_size"), cells.prod(), kBytesPerFluidCell, context.world.memory_limit, "cells");
    model_.grid.n = cells.cast<int>();
    for (std::size_t i = 0; i < n.at("open").size(); ++i)
      for (std::size_t s = 0; s < kSides.size(); ++s)
        if (n.at("open").at(i).string() == kSides[s]) model_.open[s] = true;
    std::vector<Distance> fill, carve;
    for (std::size_t i = 0; i < n.at("fill").size(); ++i) fill.push_back(distance_to(n.at("fill").at(i)));
    for (std::size_t i = 0; i < n.at("carve").size(); ++i) carve.push_back(distance_to(n.at("carve").at(i)));
    distance_ = [fill, carve](const Vec3& x) {
      double d = kFar;
      for (const Distance& f : fill) d = std::min(d, f(x));
      for (const Distance& f : carve) d = std::max(d, -f(x));
      return d;
    };
    model_.density = n.number("density");
    model_.viscosity = n.number("viscosity");
    model_.voxel_size = n.number("voxel_size");
    model_.material = material_;
    model_.material.friction = n.number("friction");
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    GridFluidModel model = model_;
    model.grid.origin += place.position;
    model.distance = [distance = distance_, at = place.position](const Vec3& x) { return distance(x - at); };
    if (!place.velocity.isZero(0.0)) model.velocity = [v = place.velocity](const Vec3&) { return v; };
    return node_.placed([&] { return std::make_unique<GridFluidBody>(std::move(model)); });
  }

 private:
  Node node_;
  Material material_;
  GridFluidModel model_;  ///< not placed
  Distance distance_;
};

}  // namespace

BodyKind grid_fluid_kind() {
  return {"grid_fluid", check_grid_fluid, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<GridFluidMaker>(n, c);
          }};
}

}  // namespace brim
