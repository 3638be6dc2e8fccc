#include "brim/world/sense/link_sensor.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/world/attachment.h"
#include "brim/world/world.h"

namespace brim {

LinkSensor::LinkSensor(const SensorModel& model, const World& world) : Sensor(model) {
  const int n = world.attachment_count();
  int found = 0;
  while (found < n && world.attachment(found).name != model.link) ++found;
  if (found == n) throw InputError(fmt::format("\"{}\" is not an attachment or joint", model.link));
  link_ = world.attachment_id(found);
  add_axes(channels_, "force", "N", Taking::Last);
  for (const auto& [name, unit] : {std::pair{"error", "m"}, std::pair{"coordinate", "rad or m"},
                                   std::pair{"effort", "N m or N"}, std::pair{"broken", ""}})
    channels_.push_back({name, unit, Taking::Last});
}

void LinkSensor::read(const World& world, const StepReport& report, std::span<double> values, std::span<double>) {
  std::fill(values.begin(), values.end(), 0.0);
  const int n = std::min(world.attachment_count(), static_cast<int>(report.links.size()));
  int at = 0;
  while (at < n && world.attachment_id(at) != link_) ++at;
  if (at == n) return;  // it does not exist in this state
  const LinkReport& r = report.links[static_cast<std::size_t>(at)];
  const double all[] = {r.force.x(), r.force.y(), r.force.z(), r.error, r.coordinate, r.effort, r.broken ? 1.0 : 0.0};
  std::copy(std::begin(all), std::end(all), values.begin());
}

}  // namespace brim
