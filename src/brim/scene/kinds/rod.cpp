#include <numbers>

#include "brim/body/rod/rod_body.h"
#include "brim/scene/constraints.h"
#include "brim/scene/kinds.h"
#include "brim/scene/limits.h"
#include "brim/scene/particle_options.h"

namespace brim {

BodyKind rod_kind();

namespace {

/// [bytes] that a node with its matrix blocks and state takes.
constexpr double kBytesPerNode = 1500.0;

void check_rod(const Node& n) {
  if (n.has("points") && n.has("helix")) throw n.at("helix").error("both \"points\" and \"helix\" are given; give one");
  if (!n.has("points") && !n.has("helix"))
    throw n.error("the line of the rod is missing; give \"points\" or \"helix\"");
  const bool closed = n.boolean("closed");
  if (closed && n.has("helix")) throw n.at("closed").error("a helix has two ends; only \"points\" can be closed");
  if (n.has("points")) {
    const Node points = n.at("points");
    const std::size_t least = closed ? 3 : 2;
    if (points.size() < least)
      throw points.error(fmt::format("list of {} is not allowed; must hold at least {}", points.size(), least));
    for (std::size_t i = closed ? 0 : 1; i < points.size(); ++i) {
      const std::size_t before = (i + points.size() - 1) % points.size();
      if (!((points.at(i).vec3() - points.at(before).vec3()).norm() > 0.0))
        throw points.at(i).error(
            fmt::format("{} is not allowed; must differ from the point before it", shown(points.at(i).json())));
    }
  }
  check_constraints(n.at("constraints"), false);
}

std::vector<Vec3> helix(const Node& n) {
  const double radius = n.number("radius"), pitch = n.number("pitch"), turns = n.number("turns");
  // Corners so fine that the chords are as good as the curve.
  const int corners = static_cast<int>(std::ceil(256.0 * turns));
  std::vector<Vec3> line;
  for (int i = 0; i <= corners; ++i) {
    const double turn = turns * i / corners, angle = 2.0 * std::numbers::pi * turn;
    line.emplace_back(radius * std::cos(angle), radius * std::sin(angle), pitch * turn);
  }
  return line;
}

/// Points at even distances along a line of straight pieces, its ends among them.
std::vector<Vec3> resample(std::vector<Vec3> line, bool closed, std::size_t segments) {
  if (closed) line.push_back(line.front());
  std::vector<double> at(1, 0.0);
  for (std::size_t i = 1; i < line.size(); ++i) at.push_back(at.back() + (line[i] - line[i - 1]).norm());
  std::vector<Vec3> out;
  std::size_t piece = 1;
  for (std::size_t i = 0; i < segments + (closed ? 0 : 1); ++i) {
    const double s = at.back() * static_cast<double>(i) / static_cast<double>(segments);
    while (piece + 1 < line.size() && at[piece] < s) ++piece;
    const double share = std::min(1.0, (s - at[piece - 1]) / (at[piece] - at[piece - 1]));
    out.emplace_back((1.0 - share) * line[piece - 1] + share * line[piece]);
  }
  return out;
}

class RodMaker final : public BodyMaker {
 public:
  RodMaker(const Node& n, const BuildContext& context) : node_(n), material_(context.material) {
    const double scale = n.at("transform").number("scale"), limit = context.world.memory_limit;
    const bool closed = n.boolean("closed");
    std::vector<Vec3> line;
    if (n.has("helix"))
      line = helix(n.at("helix"));
    else
      for (std::size_t i = 0; i < n.at("points").size(); ++i) line.push_back(n.at("points").at(i).vec3());
    for (Vec3& x : line) x *= scale;
    const auto segments = static_cast<std::size_t>(n.integer("segments"));
    if (closed && segments < 3)
      throw n.at("segments").error(fmt::format("{} is not allowed; a closed rod needs at least 3", segments));
    check_count(n.at("segments"), 1.0 * static_cast<double>(segments), kBytesPerNode, limit, "nodes");
    nodes_ = resample(std::move(line), closed, segments);
    double length = 0.0;
    for (std::size_t i = 1; i < nodes_.size(); ++i) length += (nodes_[i] - nodes_[i - 1]).norm();
    const double voxel = n.number("voxel_size");
    radius_ = scale * n.number("radius");
    check_voxel_size(n, voxel > 0.0 ? voxel : radius_, 2.0 * std::numbers::pi * radius_ * length, limit);
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    std::vector<Vec3> nodes = nodes_;
    for (Vec3& x : nodes) x = place.position + place.rotation * x;
    RodOptions options;
    options.radius = radius_;
    options.linear_density = node_.number("linear_density");
    options.stretch = node_.number("stretch_stiffness");
    options.bending = node_.number("bend_stiffness");
    options.closed = node_.boolean("closed");
    options.rests_straight = node_.boolean("rests_straight");
    read_particle_options(node_, place, material_, options);
    options.self_contact = node_.boolean("self_contact");
    read_constraints(node_.at("constraints"), nodes, {}, place.turned, options);
    return node_.placed([&] { return std::make_unique<RodBody>(std::move(nodes), std::move(options)); });
  }

 private:
  Node node_;
  Material material_;
  std::vector<Vec3> nodes_;  ///< scaled, not placed
  double radius_ = 0.0;      ///< [m] scaled
};

}  // namespace

BodyKind rod_kind() {
  return {"rod", check_rod, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<RodMaker>(n, c);
          }};
}

}  // namespace brim
