#pragma once

#include <map>
#include <utility>

#include "brim/world/sense/contact_selection.h"
#include "brim/world/sense/sensor.h"

namespace brim {

/// Detects when pairs of bodies begin to touch, for how long, and with which impulse. A pair touches in a sub-step if
/// its normal forces sum to more than `least_force`; contact has ended after a pause of more than `gap`. Present
/// contacts are part of the world's state.
/// Tests: tests/world/sense/contact_sensor_test.cpp
class ContactSensor : public Sensor {
 public:
  ContactSensor(const SensorModel& model, const World& world);
  void find_bodies(const World& world) override;
  bool concerns(int a, int b) const override { return selection_.concerns(a, b); }
  void begin_step(const World& world) override;
  void substep(const SensedContacts& contacts, std::vector<ContactEvent>& events) override;
  void read(const World& world, const StepReport& report, std::span<double> values, std::span<double> map) override;
  /// body a, body b, since, until, impulse, peak of every touching pair
  void keep(std::vector<double>& memory) const override;
  void take(std::span<const double> memory) override;

 private:
  struct Touch {
    double since = 0.0, until = 0.0;  ///< [s]
    Vec3 impulse = Vec3::Zero();      ///< [N s] on the first body
    double peak = 0.0;                ///< [N]
  };
  struct Load {
    double normal = 0.0;        ///< [N]
    Vec3 force = Vec3::Zero();  ///< [N] on the first body
  };
  void end(const std::pair<int, int>& pair, const Touch& touch, std::vector<ContactEvent>& events);

  ContactSelection selection_;
  std::map<std::pair<int, int>, Touch> touching_;
  std::map<std::pair<int, int>, Load> load_;  ///< of a sub-step
  std::vector<const Body*> bodies_;
  double now_ = 0.0;  ///< [s] end of the last sub-step
  int began_ = 0, ended_ = 0;
  Vec3 impulse_ = Vec3::Zero();  ///< [N s] of the step
  double normal_ = 0.0, peak_ = 0.0;
};

}  // namespace brim
