#include "brim/world/sense/force_sensor.h"

#include <algorithm>
#include <limits>

#include "brim/world/world.h"

namespace brim {

ForceSensor::ForceSensor(const SensorModel& model, const World& world) : Sensor(model), selection_(model_, world) {
  add_axes(channels_, "force", "N", Taking::Mean);
  add_axes(channels_, "torque", "N m", Taking::Mean);
  add_axes(channels_, "friction", "N", Taking::Mean);
  add_axes(channels_, "impulse", "N s", Taking::Sum);
  channels_.push_back({"normal", "N", Taking::Mean});
  channels_.push_back({"peak", "N", Taking::Largest});
  add_axes(channels_, "center", "m", Taking::Last);
  channels_.push_back({"area", "m2", Taking::Last});
  channels_.push_back({"contacts", "", Taking::Last});
  channels_.push_back({"overlap", "voxels", Taking::Largest});
}

void ForceSensor::begin_step(const World&) {
  time_ = normal_ = peak_ = overlap_ = contact_area_ = 0.0;
  impulse_.setZero(), friction_.setZero(), torque_.setZero(), weighted_.setZero();
  contacts_ = 0;
}

void ForceSensor::substep(const SensedContacts& contacts, std::vector<ContactEvent>&) {
  selection_.moved();
  Vec3 total = Vec3::Zero();
  contacts_ = 0;
  for (const ContactSample& s : contacts.samples) {
    const ContactSelection::Side side = selection_.side(s);
    if (side.sign == 0.0 || side.within) continue;
    const Vec3 x = s.position.cast<double>(), n = side.sign * s.force.cast<double>(),
               t = side.sign * s.friction.cast<double>();
    total += n + t;
    friction_ += contacts.dt * t;
    torque_ += contacts.dt * (x - model_.about).cross(n + t);
    normal_ += contacts.dt * n.norm();
    weighted_ += contacts.dt * n.norm() * x;
    overlap_ = std::max(overlap_, static_cast<double>(s.overlap));
    if (n.squaredNorm() > 0.0) ++contacts_;
    area_.add(x, n, std::min(contacts.world.voxel_size(s.part_a), contacts.world.voxel_size(s.part_b)));
  }
  impulse_ += contacts.dt * total;
  peak_ = std::max(peak_, total.norm());
  contact_area_ = area_.take();
  time_ += contacts.dt;
}

void ForceSensor::read(const World&, const StepReport&, std::span<double> values, std::span<double>) {
  std::size_t at = 0;
  const auto put = [&](double x) { values[at++] = x; };
  const auto put_axes = [&](const Vec3& x) { put(x.x()), put(x.y()), put(x.z()); };
  const double per_time = time_ > 0.0 ? 1.0 / time_ : 0.0;
  put_axes(per_time * impulse_);
  put_axes(per_time * torque_);
  put_axes(per_time * friction_);
  put_axes(impulse_);
  put(per_time * normal_);
  put(peak_);
  put_axes(normal_ > 0.0 ? Vec3(weighted_ / normal_) : Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  put(contact_area_);
  put(static_cast<double>(contacts_));
  put(overlap_);
}

}  // namespace brim
