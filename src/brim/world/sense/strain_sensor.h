#pragma once

#include <optional>

#include "brim/world/sense/sensed_points.h"
#include "brim/world/sense/sensor.h"

namespace brim {

/// Mean strain of a region of a body, against how it was when the sensor was added:
///   F = Σ (x − x̄)(X − X̄)ᵀ (Σ (X − X̄)(X − X̄)ᵀ)⁺,   E = ½ (Fᵀ F − P)
/// X the places of its vertices then, x now, P the projection onto the directions that they span: all three of a solid,
/// the plane of a flat sheet, the line of a straight rod. Green's strain, axes of the world at the start; exact where
/// the region deforms affinely, zero in every rigid motion. The vertices are those that the body shows, which are of
/// its matter for every kind but fluids, in single precision. Tests: tests/world/sense/strain_sensor_test.cpp
class StrainSensor : public Sensor {
 public:
  StrainSensor(const SensorModel& model, const World& world);
  void find_bodies(const World& world) override;
  void read(const World& world, const StepReport& report, std::span<double> values, std::span<double> map) override;

 private:
  /// Places of the region's vertices in the world's present state, about their mean, [m].
  void places(std::vector<Vec3>& x);

  const Body* shown_ = nullptr;
  int body_ = -1;                    ///< its number
  std::vector<std::size_t> vertex_;  ///< of those that it shows
  std::vector<Vec3f> position_;      ///< [m] of all that it shows
  std::vector<Vec3> start_, now_;    ///< [m] about their mean
  Mat3 inverse_ = Mat3::Zero(), projection_ = Mat3::Zero();
};

/// Distance L of two points of matter, or of one from a place in space, its rate, and L / L₀ − 1.
/// Tests: tests/world/sense/strain_sensor_test.cpp
class DistanceSensor : public Sensor {
 public:
  DistanceSensor(const SensorModel& model, const World& world);
  void find_bodies(const World& world) override;
  void read(const World& world, const StepReport& report, std::span<double> values, std::span<double> map) override;

 private:
  std::optional<SensedPoints> a_, b_;  ///< b: nothing in space
  double start_ = 0.0;                 ///< [m] L₀
};

}  // namespace brim
