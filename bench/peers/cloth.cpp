#include "cloth.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace brim::peers {

namespace {

using Json = nlohmann::json;

Vec3 position(const Json& body) {
  const Json p = body.value("/transform/position"_json_pointer, Json::array({0, 0, 0}));
  return {p.at(0).get<double>(), p.at(1).get<double>(), p.at(2).get<double>()};
}

}  // namespace

std::unique_ptr<ClothOnBall> cut_cloth(const Scene& scene) {
  const Json document = Json::parse(scene.text, nullptr, true, true);
  auto out = std::make_unique<ClothOnBall>();
  out->time_step = scene.world.time_step;
  const auto material = scene.materials.find("default");
  out->friction = material == scene.materials.end() ? 0.5 : material->second.friction;
  for (const Json& b : document.at("bodies")) {
    if (b.at("kind") == "cloth" && b.contains("grid")) {
      const Json &size = b.at("grid").at("size"), &cells = b.at("grid").at("cells");
      out->size_x = size.at(0), out->size_y = size.at(1);
      out->nodes_x = cells.at(0).get<int>() + 1, out->nodes_y = cells.at(1).get<int>() + 1;
      out->start = position(b);
      out->thickness = b.value("thickness", 2.0 * b.at("voxel_size").get<double>());
      out->mass = b.value("areal_density", 0.2) * out->size_x * out->size_y;
    } else if (b.at("kind") == "obstacle" && b.value("/shape/kind"_json_pointer, "") == "sphere") {
      out->center = position(b);
      out->radius = b.at("shape").at("radius");
    } else {
      return nullptr;
    }
  }
  return out->nodes_x > 0 && out->radius > 0.0 ? std::move(out) : nullptr;
}

double depth_in_ball(const ClothOnBall& cloth, const std::vector<Vec3>& nodes) {
  double deepest = -std::numeric_limits<double>::infinity();
  const auto look = [&](const Vec3& x) { deepest = std::max(deepest, cloth.radius - (x - cloth.center).norm()); };
  const auto nx = static_cast<std::size_t>(cloth.nodes_x);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    look(nodes[i]);
    if ((i + 1) % nx != 0) look(0.5 * (nodes[i] + nodes[i + 1]));
    if (i + nx < nodes.size()) look(0.5 * (nodes[i] + nodes[i + nx]));
  }
  return deepest;
}

}  // namespace brim::peers
