#include "brim/scene/repeat.h"

#include <numbers>

#include "brim/math/splitmix.h"
#include "brim/scene/circle.h"
#include "brim/scene/motion.h"

namespace brim {

namespace {

Quat yaw(double degrees) { return Quat(Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, Vec3::UnitZ())); }

/// Faster than this nothing can be stepped at 64 sub-steps of a voxel.
constexpr double kFastest = 1e5;

Vec3 motion_of(const Node& body, const char* key, const char* unit) {
  const Vec3 v = body.vec3(key);
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(v[a]) <= kFastest))
      throw body.at(key).error(
          fmt::format("{:g} {} is not allowed; must be from {:g} to {:g}", v[a], unit, -kFastest, kFastest));
  return v;
}

/// Copies along x, y and z.
std::vector<int> grid_count(const Node& repeat) {
  if (repeat.has("count")) return repeat.at("count").integers();
  if (repeat.has("around")) return {1, 1, 1};
  throw repeat.error(
      "neither \"count\" nor \"around\" is given; \"count\", a list of 3 whole numbers, makes copies on a grid, "
      "\"around\", an object with \"count\", copies in a circle");
}

}  // namespace

std::uint64_t SceneRandom::next() { return next_scattered(state_); }

Quat random_rotation(SceneRandom& random) {
  const double u = random.unit();
  const double a = 2.0 * std::numbers::pi * random.unit(), b = 2.0 * std::numbers::pi * random.unit();
  const double r = std::sqrt(1.0 - u), s = std::sqrt(u);
  return Quat(s * std::cos(b), r * std::sin(a), r * std::cos(a), s * std::sin(b));
}

std::size_t repeat_count(const Node& body) {
  if (!body.has("repeat")) return 1;
  const Node repeat = body.at("repeat");
  std::size_t n = 1;
  for (const int c : grid_count(repeat)) n *= static_cast<std::size_t>(c);
  return repeat.has("around") ? n * static_cast<std::size_t>(repeat.at("around").integer("count")) : n;
}

std::vector<Placement> placements(const Node& body) {
  Placement first;
  first.name = body.string("name");
  const Node transform = body.at("transform");
  first.position = transform.vec3("position");
  first.scale = transform.number("scale");
  if (transform.has("rotation")) first.rotation = read_rotation(transform.at("rotation"));
  first.velocity = motion_of(body, "velocity", "m/s");
  if (body.has("angular_velocity")) first.angular_velocity = motion_of(body, "angular_velocity", "rad/s");
  if (!body.has("repeat")) return {first};

  const Node repeat = body.at("repeat");
  const std::vector<int> count = grid_count(repeat);
  const Circle circle = repeat.has("around") ? read_circle(repeat.at("around")) : Circle();
  const Vec3 spacing = repeat.vec3("spacing"), jitter = repeat.vec3("jitter");
  const std::string turn = repeat.string("turn");
  const double turn_degrees = repeat.number("turn_degrees");
  const auto seed = static_cast<std::uint64_t>(repeat.integer("seed"));
  std::vector<Placement> all;
  all.reserve(repeat_count(body));
  const auto copy = [&](int i, int j, int k) {
    Placement p = first;
    SceneRandom random(seed * 0x100000001b3u + all.size());
    const Vec3 cell(i - 0.5 * (count[0] - 1), j - 0.5 * (count[1] - 1), k);
    for (int a = 0; a < 3; ++a) p.position[a] += cell[a] * spacing[a] + jitter[a] * random.symmetric();
    if (turn == "any") p.rotation = random_rotation(random) * p.rotation;
    if (turn == "yaw") p.rotation = yaw(turn_degrees * random.symmetric()) * p.rotation;
    p.name += fmt::format(".{}", all.size());
    return p;
  };
  for (int c = 0; c < circle.count; ++c)
    for (int k = 0; k < count[2]; ++k)
      for (int j = 0; j < count[1]; ++j)
        for (int i = 0; i < count[0]; ++i) all.push_back(circle.place(copy(i, j, k), c));
  return all;
}

}  // namespace brim
