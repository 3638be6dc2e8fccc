#include <cmath>

#include "brim/body/grid_fluid/grid_fluid_body.h"
#include "brim/scene/kinds.h"
#include "brim/scene/limits.h"
#include "brim/scene/region.h"

namespace brim {

BodyKind grid_fluid_kind();

namespace {

/// [bytes] that a cell with its faces, matrices and state takes.
constexpr double kBytesPerFluidCell = 1000.0;
/// [cells] by which a side of the box may miss a whole number of cells.
constexpr double kOddCells = 1e-3;

constexpr std::array<const char*, 6> kSides = {"-x", "+x", "-y", "+y", "-z", "+z"};

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
  if (n.has("repeat") && n.at("repeat").has("around"))
    throw n.at("repeat").at("around").error("a grid fluid's box cannot be turned; \"count\" makes copies on a grid");
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
    distance_ = [fill = region_distance(n.at("fill")), carve = region_distance(n.at("carve"))](const Vec3& x) {
      return std::max(fill(x), -carve(x));
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
  RegionDistance distance_;
};

}  // namespace

BodyKind grid_fluid_kind() {
  return {"grid_fluid", check_grid_fluid, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<GridFluidMaker>(n, c);
          }};
}

}  // namespace brim
