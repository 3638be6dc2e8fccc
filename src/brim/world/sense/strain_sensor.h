#pragma once

#include <optional>

#include "brim/world/sense/sensed_points.h"
#include "brim/world/sense/sensor.h"

namespace brim {

/// Mean strain of a region of a body, relative to when the sensor was added:
///   F = Σ (x − x̄)(X − X̄)ᵀ (Σ (X − X̄)(X − X̄)ᵀ)⁺,   E = ½ (Fᵀ F − P)
/// X: positions of its vertices then, x: now, P: projection onto the directions they span (all three for a solid, the
/// plane of a flat sheet, the line of a straight rod). Green strain in world axes at the start; exact for affine
/// deformation of the region, zero for rigid motion. Vertices are those of the display, which are material points for
/// every kind but fluids, in single precision. Tests: tests/world/sense/strain_sensor_test.cpp
class StrainSensor : public Sensor {
 public:
  StrainSensor(const SensorModel& model, const World& world);
  void find_bodies(const World& world) override;
  void read(const World& world, const StepReport& report, std::span<double> values, std::span<double> map) override;

 private:
  /// Present positions of the region's vertices, relative to their mean, [m].
  void places(std::vector<Vec3>& x);

  const Body* shown_ = nullptr;
  int body_ = -1;                    ///< its number
  std::vector<std::size_t> vertex_;  ///< indices of its vertices in the display
  std::vector<Vec3f> position_;      ///< [m] of all display vertices
  std::vector<Vec3> start_, now_;    ///< [m] relative to their mean
  Mat3 inverse_ = Mat3::Zero(), projection_ = Mat3::Zero();
};

/// Distance L of two material points, or of one from a point in space, its rate, and L / L₀ − 1.
/// Tests: tests/world/sense/strain_sensor_test.cpp
class DistanceSensor : public Sensor {
 public:
  DistanceSensor(const SensorModel& model, const World& world);
  void find_bodies(const World& world) override;
  void read(const World& world, const StepReport& report, std::span<double> values, std::span<double> map) override;

 private:
  std::optional<SensedPoints> a_, b_;  ///< b: empty when in space
  double start_ = 0.0;                 ///< [m] L₀
};

}  // namespace brim
