#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "brim/math/types.h"
#include "brim/world/sense/sensor_model.h"
#include "brim/world/start_places.h"
#include "brim/world/step_report.h"

namespace brim {

class Body;
class World;

/// The contacts that a sensor considers, seen from the side of its bodies.
class ContactSelection {
 public:
  /// @throws InputError where no body has one of the names
  ContactSelection(const SensorModel& model, const World& world);
  void find_bodies(const World& world);
  /// To be called when the bodies have moved since the last call of `side`.
  void moved();

  /// Side of a contact: sign times the sample's forces are those on body a.
  struct Side {
    double sign = 0.0;  ///< 0: contact not selected
    int body_a = 0, body_b = 0;
    bool within = false;  ///< both bodies belong to the sensor
  };
  Side side(const ContactSample& sample);
  /// True when contacts of the two bodies may be selected.
  bool concerns(int body_a, int body_b) const;

 private:
  bool in_region(int body, int part, const Vec3& x);

  const SensorModel& model_;
  std::vector<std::uint8_t> own_, other_;                                ///< per body
  std::vector<int> body_of_, index_of_;                                  ///< per part
  std::vector<const Body*> bodies_;                                      ///< per body
  std::unordered_map<const Body*, std::unique_ptr<StartPlaces>> start_;  ///< of bodies with a region that follows
};

}  // namespace brim
