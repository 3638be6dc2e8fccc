#include "brim/world/sense/level_sensor.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "brim/core/error.h"
#include "brim/world/touch_rules.h"
#include "brim/world/world.h"

namespace brim {

namespace {

/// Density at a surface.
constexpr double kSurface = 0.5;
/// Maximum number of tiles of a column: for a taller body there is no reading, to save memory.
constexpr int kMostColumnTiles = 4096;

}  // namespace

LevelSensor::LevelSensor(const SensorModel& model, const World& world) : Sensor(model) {
  if (!model.point) throw InputError("a level is read on an upright line; give a \"point\" of it");
  find_bodies(world);
  if (parts_.empty()) throw InputError("no body of those names is there");
  for (const int p : parts_) {
    const Body& body = world.body(world.part(p).body);
    const Aabb box = body.bounds(world.part(p).index);
    if (!box.empty() && !(std::isfinite(box.lo.z()) && std::isfinite(box.hi.z())))
      throw InputError(fmt::format("'{}' has no end along z; a level is of bodies that do", body.name()));
  }
  channels_ = {{"level", "m", Taking::Last}, {"depth", "m", Taking::Last}};
}

void LevelSensor::find_bodies(const World& world) {
  parts_.clear();
  for (int p = 0; p < world.part_count(); ++p)
    for (const std::string& word : model_.bodies)
      if (name_matches(word, world.body(world.part(p).body).name())) {
        parts_.push_back(p);
        break;
      }
}

void LevelSensor::runs_of(const World& world, int part, std::vector<Run>& runs) {
  const double h = world.voxel_size(part), x = model_.point->x(), y = model_.point->y();
  Aabb box = world.body(world.part(part).body).bounds(world.part(part).index);
  if (box.empty()) return;
  box = box.inflated(0.5 * world.options().ramp_voxels * h + h);
  if (x < box.lo.x() || x > box.hi.x() || y < box.lo.y() || y > box.hi.y()) return;
  // The tile whose own nodes begin at or below the line; its halo contains the next ones.
  const auto tile = [h](double c) { return static_cast<std::int32_t>(std::floor(c / h / kTileSize)); };
  const std::int32_t first = tile(box.lo.z()), last = std::min(tile(box.hi.z()), first + kMostColumnTiles - 1);
  tiles_.clear();
  for (std::int32_t z = first; z <= last; ++z) tiles_.push_back({tile(x), tile(y), z});
  blocks_.resize(tiles_.size());
  for (DensityBlock& b : blocks_) b.octants = kAllOctants;
  world.density(part, h, tiles_, blocks_);
  const double u = x / h - tiles_[0].x * kTileSize, v = y / h - tiles_[0].y * kTileSize;
  const int i = static_cast<int>(u), j = static_cast<int>(v);
  const double fu = u - i, fv = v - j;
  double before = 0.0;
  bool inside = false;
  const auto cross = [&](double now, double z) { return z - h * (now - kSurface) / (now - before); };
  for (std::size_t t = 0; t < tiles_.size(); ++t)
    for (int k = 0; k < kTileSize; ++k) {
      const auto rho = [&](int a, int b) {
        return blocks_[t].rho[block_index(i + a + kHalo, j + b + kHalo, k + kHalo)];
      };
      const double now =
          (1 - fu) * (1 - fv) * rho(0, 0) + fu * (1 - fv) * rho(1, 0) + (1 - fu) * fv * rho(0, 1) + fu * fv * rho(1, 1);
      const double z = h * (tiles_[t].z * kTileSize + k);
      if (!inside && now > kSurface) runs.push_back({cross(now, z), z}), inside = true;
      if (inside && now <= kSurface) runs.back().top = cross(now, z), inside = false;
      if (inside) runs.back().top = z;
      before = now;
    }
}

void LevelSensor::read(const World& world, const StepReport&, std::span<double> values, std::span<double>) {
  std::vector<Run> runs;
  for (const int p : parts_) runs_of(world, p, runs);
  // Runs of several parts may overlap or meet.
  std::sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.bottom < b.bottom; });
  std::vector<Run> whole;
  for (const Run& r : runs)
    if (!whole.empty() && r.bottom <= whole.back().top)
      whole.back().top = std::max(whole.back().top, r.top);
    else
      whole.push_back(r);
  double longest = 0.0;
  values[0] = std::numeric_limits<double>::quiet_NaN(), values[1] = 0.0;
  for (const Run& r : whole) {
    values[1] += r.top - r.bottom;
    if (r.top - r.bottom > longest) longest = r.top - r.bottom, values[0] = r.top;
  }
}

}  // namespace brim
