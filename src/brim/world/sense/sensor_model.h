#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Quantity that a sensor measures (docs/sensors.md).
enum class SensorKind {
  Force,     ///< contact force on bodies or a region of them: a force plate
  Contact,   ///< when contact begins, lasts and ends, with its impulse
  Pressure,  ///< map of contact pressure on a grid over a plane
  Motion,    ///< position, velocity and acceleration of a point or of a whole body
  Strain,    ///< strain of a region relative to when the sensor was added
  Distance,  ///< distance of two material points, its rate and strain: an extensometer
  Level,     ///< height of material along a vertical line: a fluid's level
  Link       ///< force and coordinate of an attachment or joint
};

/// Definition of a sensor. Each field names the kinds that use it; other kinds must leave it unset.
struct SensorModel {
  std::string name;  ///< unique among sensors
  SensorKind kind = SensorKind::Force;
  /// Names, stems of numbered copies or patterns (TouchRule). Exactly one body for Motion, Strain, Distance.
  std::vector<std::string> bodies;
  std::vector<std::string> with;  ///< Force, Contact, Pressure: the other side; empty: every body

  /// Force, Contact: of the body now, which carries it along; Strain: of its vertices.
  std::function<bool(const Vec3&)> region{};
  bool follows = true;           ///< Force, Contact, Pressure: false: the region or grid is fixed in space
  std::optional<Vec3> point;     ///< [m] now; Motion, Distance: the body's nearest material point; Level
  int part = -1;                 ///< of the body, for point; −1: the nearest one
  std::string to{};              ///< Distance: the other body; empty: space
  std::optional<Vec3> to_point;  ///< [m] Distance: now, of the other body
  Vec3 about = Vec3::Zero();     ///< [m] Force: reference point of the torque, in space

  double least_force = 0.0;  ///< [N] Contact: a pair touches when its normal forces sum to more
  double gap = 0.0;          ///< [s] Contact: pauses up to this long do not end a contact

  /// Cells of a map: at origin + s x̂ + t ŷ, 0 <= s < |x|, 0 <= t < |y|, at present. x × ŷ points out of the body.
  struct Grid {
    Vec3 origin = Vec3::Zero();                 ///< [m]
    Vec3 x = Vec3::UnitX(), y = Vec3::UnitY();  ///< [m] sides, perpendicular
    int columns = 16, rows = 16;
    double smoothing = -1.0;  ///< [m] side of the square over which a contact is spread; negative: its voxel
  };
  std::optional<Grid> grid;  ///< Pressure

  std::string link{};       ///< Link: name of the attachment or joint
  bool every_step = false;  ///< recorded after every step, not only once per frame
};

/// How a channel's readings in the steps of a frame are combined.
enum class Taking {
  Mean,    ///< forces
  Sum,     ///< impulses and counts
  Last,    ///< states
  Largest  ///< peaks; NaN readings are ignored
};

/// One number read by a sensor.
struct SensorChannel {
  std::string name, unit;  ///< "force_x", "N"; unit "" for counts and ratios
  Taking taking = Taking::Last;
};

/// Begin or end of a contact of two bodies, as detected by a Contact sensor.
struct ContactEvent {
  int sensor = 0;
  bool began = true;           ///< false: it ended
  double time = 0.0;           ///< [s] start of the first, or end of the last sub-step with contact
  int body_a = 0, body_b = 0;  ///< the sensor's side first
  /// For ended contacts:
  double duration = 0.0;        ///< [s]
  Vec3 impulse = Vec3::Zero();  ///< [N s] on body a over the duration
  double peak = 0.0;            ///< [N] largest sum of normal forces of a sub-step
};

}  // namespace brim
