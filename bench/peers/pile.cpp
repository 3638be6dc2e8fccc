#include "pile.h"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "brim/core/error.h"
#include "brim/math/ramp.h"

namespace brim::peers {

namespace {

using Json = nlohmann::json;

Vec3 vector(const Json& v) { return Vec3(v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>()); }

Vec3 polar(double radius, double angle, double z) { return {radius * std::cos(angle), radius * std::sin(angle), z}; }

/// A prism over polar corners (radius, angle).
Piece prism(const std::vector<std::pair<double, double>>& corners, double thickness) {
  Piece p;
  for (const double z : {-0.5 * thickness, 0.5 * thickness})
    for (const auto& [radius, angle] : corners) p.points.push_back(polar(radius, angle, z));
  return p;
}

std::vector<Piece> cut_gear(const Json& s) {
  const int teeth = s.at("teeth").get<int>();
  const double outer = s.at("outer"), root = s.at("root"), bore = s.at("bore"), thickness = s.at("thickness");
  const double pitch = 2.0 * std::numbers::pi / teeth;
  std::vector<Piece> pieces;
  for (int k = 0; k < teeth; ++k) {
    const double a = k * pitch;
    const auto at = [&](double radius, double turn) { return std::pair(radius, a + turn * pitch); };
    pieces.push_back(prism(
        {at(bore, -0.2), at(bore, 0.2), at(root, -0.2), at(root, -0.1), at(root, 0), at(root, 0.1), at(root, 0.2)},
        thickness));
    pieces.push_back(prism({at(bore, 0.2), at(bore, 0.8), at(root, 0.2), at(root, 0.8), at(outer, 0.36),
                            at(outer, 0.43), at(outer, 0.5), at(outer, 0.57), at(outer, 0.64)},
                           thickness));
  }
  return pieces;
}

std::vector<Piece> cut_star(const Json& s) {
  const int points = s.at("points");
  const double outer = s.at("outer"), inner = s.at("inner"), thickness = s.at("thickness");
  const double half = std::numbers::pi / points;
  std::vector<Piece> pieces;
  for (int k = 0; k < points; ++k) {
    const double a = 2 * k * half;
    pieces.push_back(prism({{0.0, 0.0}, {inner, a - half}, {outer, a}, {inner, a + half}}, thickness));
  }
  return pieces;
}

std::vector<Piece> cut_torus(const Json& s) {
  constexpr int kPieces = 20;
  const double radius = s.at("radius"), tube = s.at("tube");
  std::vector<Piece> pieces;
  for (int k = 0; k < kPieces; ++k) {
    const double step = 2.0 * std::numbers::pi / kPieces;
    pieces.push_back({{polar(radius, k * step, 0.0), polar(radius, (k + 1) * step, 0.0)}, tube});
  }
  return pieces;
}

std::vector<Piece> cut(const Json& shape) {
  const std::string kind = shape.at("kind");
  if (kind == "gear") return cut_gear(shape);
  if (kind == "star") return cut_star(shape);
  if (kind == "torus") return cut_torus(shape);
  if (kind == "sphere") return {{{Vec3::Zero()}, shape.at("radius").get<double>()}};
  if (kind == "box") return {{{}, 0.0, 0.5 * vector(shape.at("size"))}};
  throw InputError("no convex pieces are known for a shape of kind " + kind);
}

}  // namespace

double Piece::reach() const {
  double farthest = half.norm();
  for (const Vec3& x : points) farthest = std::max(farthest, x.norm() + radius);
  return farthest;
}

Pile cut_pile(const Scene& scene, const World& world) {
  const Json document = Json::parse(scene.text, nullptr, true, true);
  Pile pile;
  pile.time_step = scene.world.time_step;
  pile.friction = scene.materials.at("default").friction;
  std::map<std::string, int> shape_of;
  for (const Json& b : document.at("bodies")) {
    if (b.at("kind") == "rigid") {
      shape_of[b.at("name")] = static_cast<int>(pile.shapes.size());
      pile.shapes.push_back(cut(b.at("shape")));
    } else if (b.at("shape").at("kind") == "box") {
      pile.walls.push_back({vector(b.at("transform").at("position")), 0.5 * vector(b.at("shape").at("size"))});
    }
  }
  for (int i = 0; i < world.body_count(); ++i) {
    const Body& body = world.body(i);
    const auto it = shape_of.find(body.name().substr(0, body.name().find('.')));
    if (it == shape_of.end()) continue;
    const auto q = world.q(i);
    Solid s;
    s.shape = it->second;
    s.position = Vec3(q[0], q[1], q[2]);
    s.rotation = Quat(q[3], q[4], q[5], q[6]);
    s.mass = body.mass();
    for (int a = 0; a < 3; ++a) {
      const Vec3 axis = s.rotation * Vec3::Unit(a);
      const double x[6] = {0.0, 0.0, 0.0, axis.x(), axis.y(), axis.z()};
      double y[6] = {};
      body.apply_mass(x, y);
      s.inertia[a] = axis.dot(Vec3(y[3], y[4], y[5]));
    }
    pile.solids.push_back(s);
  }
  return pile;
}

namespace {

/// Puts the solids where a placement says, at rest.
void place(World& world, const Placement& placement) {
  State state = world.state();
  std::fill(state.v.begin(), state.v.end(), 0.0);
  std::size_t at = 0;
  for (int b = 0; b < world.body_count(); ++b) {
    const std::size_t first = static_cast<std::size_t>(world.q(b).data() - world.state().q.data());
    if (world.body(b).immobile()) continue;
    const Vec3& x = placement.position.at(at);
    const Quat& r = placement.rotation.at(at++);
    const double q[7] = {x.x(), x.y(), x.z(), r.w(), r.x(), r.y(), r.z()};
    std::copy(q, q + 7, state.q.begin() + static_cast<std::ptrdiff_t>(first));
  }
  world.set_state(std::move(state));
}

}  // namespace

Overlap measure_overlap(World& world, const Placement& placement) {
  place(world, placement);
  Overlap result;
  double sum = 0.0;
  for (int a = 0; a < world.part_count(); ++a)
    for (int b = a + 1; b < world.part_count(); ++b) {
      const Body &first = world.body(world.part(a).body), &second = world.body(world.part(b).body);
      if (first.immobile() && second.immobile()) continue;
      const double h = first.immobile() ? second.part(0).voxel_size : first.part(0).voxel_size;
      const double w = world.options().ramp_voxels * h;
      const Aabb box = first.bounds(0).inflated(0.5 * w).intersection(second.bounds(0).inflated(0.5 * w));
      if (box.empty()) continue;
      const TileRange r = tiles_meeting(box, h);
      std::vector<TileKey> tiles;
      for (std::int32_t z = r.lo.z; z <= r.hi.z; ++z)
        for (std::int32_t y = r.lo.y; y <= r.hi.y; ++y)
          for (std::int32_t x = r.lo.x; x <= r.hi.x; ++x) tiles.push_back({x, y, z});
      std::vector<DensityBlock> rho_a(tiles.size()), rho_b(tiles.size());
      world.density(a, h, tiles, rho_a);
      world.density(b, h, tiles, rho_b);
      double deepest = 0.0;
      for (std::size_t t = 0; t < tiles.size(); ++t)
        for (int n = 0; n < kBlockNodes; ++n) {
          const double da = rho_a[t].rho[n], db = rho_b[t].rho[n];
          if (da + db > 1.0) deepest = std::max(deepest, -(ramp_inverse(da, w) + ramp_inverse(db, w)));
        }
      if (!(deepest > 0.0)) continue;
      ++result.pairs;
      sum += deepest;
      result.worst = std::max(result.worst, deepest);
    }
  if (result.pairs > 0) result.mean = sum / result.pairs;
  return result;
}

namespace {

class BrimEngine final : public Engine {
 public:
  BrimEngine(const Scene& scene, const Pile* start) : world_(build_world(scene)) {
    if (!start) return;
    Placement p;
    for (const Solid& s : start->solids) p.position.push_back(s.position), p.rotation.push_back(s.rotation);
    place(world_, p);
  }
  std::string name() const override { return "brim"; }
  void step() override { world_.step(); }
  Placement placement() const override {
    Placement p;
    for (int b = 0; b < world_.body_count(); ++b) {
      if (world_.body(b).immobile()) continue;
      const auto q = world_.q(b), v = world_.v(b);
      p.position.emplace_back(q[0], q[1], q[2]);
      p.rotation.emplace_back(q[3], q[4], q[5], q[6]);
      p.velocity.emplace_back(v[0], v[1], v[2]);
      p.spin.emplace_back(v[3], v[4], v[5]);
    }
    return p;
  }

 private:
  World world_;
};

}  // namespace

std::unique_ptr<Engine> make_brim(const Scene& scene, const Pile* start) {
  return std::make_unique<BrimEngine>(scene, start);
}

}  // namespace brim::peers
