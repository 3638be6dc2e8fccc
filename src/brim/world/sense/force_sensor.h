#pragma once

#include "brim/world/sense/contact_area.h"
#include "brim/world/sense/contact_selection.h"
#include "brim/world/sense/sensor.h"

namespace brim {

/// A force plate: forces of other bodies on the sensor's bodies, or on a region of them.
///   force = Σ dt F / T,  torque = Σ dt (x − about) × F / T,  impulse = Σ dt F,   over the sub-steps dt of a step T
///   center = Σ |N| x / Σ |N|,  N normal forces;  peak: largest |ΣF| of a sub-step
/// Forces between the sensor's own bodies are left out: they cancel.
/// Tests: tests/world/sense/force_sensor_test.cpp
class ForceSensor : public Sensor {
 public:
  ForceSensor(const SensorModel& model, const World& world);
  void find_bodies(const World& world) override { selection_.find_bodies(world); }
  bool concerns(int a, int b) const override { return selection_.concerns(a, b); }
  void begin_step(const World& world) override;
  void substep(const SensedContacts& contacts, std::vector<ContactEvent>& events) override;
  void read(const World& world, const StepReport& report, std::span<double> values, std::span<double> map) override;

 private:
  ContactSelection selection_;
  ContactArea area_;
  double time_ = 0.0;
  Vec3 impulse_ = Vec3::Zero(), friction_ = Vec3::Zero(), torque_ = Vec3::Zero();  ///< times dt
  double normal_ = 0.0;                                                            ///< [N s]
  Vec3 weighted_ = Vec3::Zero();                                                   ///< [N s m]
  double peak_ = 0.0, overlap_ = 0.0, contact_area_ = 0.0;
  std::int64_t contacts_ = 0;
};

}  // namespace brim
