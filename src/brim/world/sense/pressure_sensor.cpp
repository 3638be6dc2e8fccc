#include "brim/world/sense/pressure_sensor.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "brim/body/posed_shape.h"
#include "brim/body/solid_of.h"
#include "brim/core/error.h"
#include "brim/world/touch_rules.h"
#include "brim/world/world.h"

namespace brim {

namespace {

/// Maximum number of cells of a map.
constexpr int kMostCells = 1 << 18;

const PosedShape* only_solid(const Body& body) { return body.part_count() == 1 ? solid_of(body, 0) : nullptr; }

void check_grid(const SensorModel::Grid& g) {
  for (const auto& [what, side] : {std::pair{"x", g.x}, std::pair{"y", g.y}})
    if (!side.allFinite() || !(side.norm() > 0.0))
      throw InputError(fmt::format("grid: the side {} must be of some length", what));
  if (std::abs(g.x.normalized().dot(g.y.normalized())) > 1e-6)
    throw InputError("grid: its sides x and y must be at a right angle");
  if (g.columns < 1 || g.rows < 1 || static_cast<double>(g.columns) * g.rows > kMostCells)
    throw InputError(
        fmt::format("grid: {} x {} cells are not allowed; must be at least one each way and at most {} in all",
                    g.columns, g.rows, kMostCells));
}

}  // namespace

PressureSensor::PressureSensor(const SensorModel& model, const World& world)
    : Sensor(model), selection_(model_, world) {
  if (!model.grid) throw InputError("a map needs a grid");
  check_grid(*model.grid);
  impulse_.resize(map_size());
  channels_ = {{"force", "N", Taking::Mean}, {"outside", "N", Taking::Mean},  {"pressure", "Pa", Taking::Largest},
               {"area", "m2", Taking::Last}, {"center_x", "m", Taking::Last}, {"center_y", "m", Taking::Last}};
  for (int b = 0; b < world.body_count() && model.follows; ++b) {
    const Body& body = world.body(b);
    if (!std::any_of(model.bodies.begin(), model.bodies.end(),
                     [&](const std::string& w) { return name_matches(w, body.name()); }))
      continue;
    if (const PosedShape* solid = only_solid(body)) carrier_ = &body, carried_ = true, start_ = solid->pose();
    break;
  }
}

void PressureSensor::find_bodies(const World& world) {
  selection_.find_bodies(world);
  carried_ = false;
  for (int b = 0; b < world.body_count(); ++b) carried_ = carried_ || &world.body(b) == carrier_;
}

void PressureSensor::begin_step(const World&) {
  std::fill(impulse_.begin(), impulse_.end(), 0.0);
  time_ = outside_ = 0.0;
}

/// Distributes `amount` over the cells covered by a square of that width around (s, t); the rest goes to outside_.
void PressureSensor::spread(double s, double t, double width, double amount) {
  const SensorModel::Grid& g = *model_.grid;
  const double dx = g.x.norm() / g.columns, dy = g.y.norm() / g.rows;
  const auto range = [](double middle, double w, double cell, int cells) {
    const auto clamp = [&](double x) {
      return static_cast<int>(std::clamp(std::floor(x / cell), -1.0, double(cells)));
    };
    return std::pair(std::max(clamp(middle - 0.5 * w), 0), std::min(clamp(middle + 0.5 * w), cells - 1));
  };
  // The share of [middle − w/2, middle + w/2] in cell i; all of it for w = 0.
  const auto share = [](double middle, double w, double cell, int i) {
    if (!(w > 0.0)) return 1.0;
    const double lo = std::max(middle - 0.5 * w, i * cell), hi = std::min(middle + 0.5 * w, (i + 1) * cell);
    return std::max(0.0, hi - lo) / w;
  };
  const auto [i0, i1] = range(s, width, dx, g.columns);
  const auto [j0, j1] = range(t, width, dy, g.rows);
  double inside = 0.0;
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i) {
      const double part = share(s, width, dx, i) * share(t, width, dy, j);
      impulse_[static_cast<std::size_t>(j) * static_cast<std::size_t>(g.columns) + static_cast<std::size_t>(i)] +=
          part * amount;
      inside += part;
    }
  outside_ += (1.0 - inside) * amount;
}

void PressureSensor::substep(const SensedContacts& contacts, std::vector<ContactEvent>&) {
  selection_.moved();
  time_ += contacts.dt;
  if (carrier_ != nullptr && !carried_) return;
  const SensorModel::Grid& g = *model_.grid;
  const Vec3 x = g.x.normalized(), y = g.y.normalized(), n = x.cross(y);
  Pose now;
  if (start_) now = only_solid(*carrier_)->pose();
  for (const ContactSample& sample : contacts.samples) {
    const ContactSelection::Side side = selection_.side(sample);
    if (side.sign == 0.0 || side.within) continue;
    Vec3 at = sample.position.cast<double>(), force = side.sign * (sample.force + sample.friction).cast<double>();
    if (start_) {  // back to the grid's original pose
      at = start_->translation + start_->rotation * now.to_local(at);
      force = start_->rotation * (now.rotation.transpose() * force);
    }
    const double h = std::min(contacts.world.voxel_size(sample.part_a), contacts.world.voxel_size(sample.part_b));
    spread((at - g.origin).dot(x), (at - g.origin).dot(y), g.smoothing < 0.0 ? h : g.smoothing,
           -contacts.dt * force.dot(n));
  }
}

void PressureSensor::read(const World&, const StepReport&, std::span<double> values, std::span<double> map) {
  const SensorModel::Grid& g = *model_.grid;
  const double dx = g.x.norm() / g.columns, dy = g.y.norm() / g.rows, per_time = time_ > 0.0 ? 1.0 / time_ : 0.0;
  double sum = 0.0, most = 0.0, cells = 0.0, sx = 0.0, sy = 0.0;
  for (std::size_t c = 0; c < map.size(); ++c) {
    const double force = per_time * impulse_[c];
    map[c] = force / (dx * dy);
    sum += force;
    most = std::max(most, map[c]);
    if (force > 0.0) cells += 1.0;
    sx += force * (static_cast<double>(c % static_cast<std::size_t>(g.columns)) + 0.5) * dx;
    sy += force * (static_cast<double>(c / static_cast<std::size_t>(g.columns)) + 0.5) * dy;
  }
  const double none = std::numeric_limits<double>::quiet_NaN();
  const double all[] = {
      sum, per_time * outside_, most, cells * dx * dy, sum > 0.0 ? sx / sum : none, sum > 0.0 ? sy / sum : none};
  std::copy(std::begin(all), std::end(all), values.begin());
}

}  // namespace brim
