#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// What a sensor reads (docs/sensors.md).
enum class SensorKind {
  Force,     ///< contact force on bodies or a region of them: a force plate
  Contact,   ///< when contact begins, lasts and ends, with its impulse
  Pressure,  ///< map of contact pressure on a grid over a plane
  Motion,    ///< position, velocity and acceleration of a point or of a whole body
  Strain,    ///< strain of a region against how it was when the sensor was added
  Distance,  ///< distance of two points of matter, its rate and strain: an extensometer
  Level,     ///< height of matter along an upright line: a fluid's level
  Link       ///< what an attachment or joint carries
};

/// A sensor as it is asked for. Which fields a kind takes is said with each; others must be left alone.
struct SensorModel {
  std::string name;  ///< unique among sensors
  SensorKind kind = SensorKind::Force;
  /// Names, stems of numbered copies or patterns (TouchRule). One body alone for Motion, Strain, Distance.
  std::vector<std::string> bodies;
  std::vector<std::string> with;  ///< Force, Contact, Pressure: the other side; empty: every body

  /// Force, Contact: of the body as it is now, which carries it along; Strain: of its vertices.
  std::function<bool(const Vec3&)> region{};
  bool follows = true;  ///< Force, Contact, Pressure: false: the region or grid stays where it is in space
  std::optional<Vec3>
      point;         ///< [m] now; Motion, Distance: of the body, of which it is the matter nearest to it; Level
  int part = -1;     ///< of the body, for point; −1: the one nearest to it
  std::string to{};  ///< Distance: the other body; empty: space
  std::optional<Vec3> to_point;  ///< [m] Distance: now, of the other body
  Vec3 about = Vec3::Zero();     ///< [m] Force: torque is about this place in space

  double least_force = 0.0;  ///< [N] Contact: sum of normal forces of a pair above which it touches
  double gap = 0.0;          ///< [s] Contact: pauses up to this long do not end it

  /// Cells of a map: at origin + s x̂ + t ŷ, 0 <= s < |x|, 0 <= t < |y|, as it is now. x × ŷ points out of the body.
  struct Grid {
    Vec3 origin = Vec3::Zero();                 ///< [m]
    Vec3 x = Vec3::UnitX(), y = Vec3::UnitY();  ///< [m] sides, at a right angle
    int columns = 16, rows = 16;
    double smoothing = -1.0;  ///< [m] side of the square over which a contact spreads; negative: its voxel
  };
  std::optional<Grid> grid;  ///< Pressure

  std::string link{};       ///< Link: name of the attachment or joint
  bool every_step = false;  ///< recorded after every step, not of every frame alone
};

/// How what a channel reads in the steps of a frame becomes one reading.
enum class Taking {
  Mean,    ///< forces
  Sum,     ///< impulses and counts
  Last,    ///< states
  Largest  ///< peaks; readings that are not a number are left out
};

/// One number that a sensor reads.
struct SensorChannel {
  std::string name, unit;  ///< "force_x", "N"; unit "" for counts and ratios
  Taking taking = Taking::Last;
};

/// A contact of two bodies that began or ended, as a Contact sensor saw it.
struct ContactEvent {
  int sensor = 0;
  bool began = true;           ///< else it ended
  double time = 0.0;           ///< [s] start of the first, or end of the last sub-step with contact
  int body_a = 0, body_b = 0;  ///< the sensor's side first
  /// Of contacts that ended:
  double duration = 0.0;        ///< [s]
  Vec3 impulse = Vec3::Zero();  ///< [N s] on body a over the duration
  double peak = 0.0;            ///< [N] largest sum of normal forces of a sub-step
};

}  // namespace brim
