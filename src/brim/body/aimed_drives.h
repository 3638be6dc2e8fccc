#pragma once

#include <optional>
#include <span>
#include <string>

namespace brim {

/// Target of a drive.
struct DriveAim {
  double position = 0.0;  ///< [rad or m]
  double velocity = 0.0;  ///< [rad/s or m/s]
};

/// Optional interface of bodies whose joints have drives that are aimed between steps. The world keeps the aims in its
/// state (World::set_drive, DriveAims). Tests: tests/world/drive_aims_test.cpp
class AimedDrives {
 public:
  virtual ~AimedDrives() = default;
  /// Names of the joints with a drive that can be aimed; a drive's number is its place here.
  virtual std::span<const std::string> drive_names() const = 0;
  /// Sets the target of a drive, which then holds; nothing: as the body was described, keyframes included. For an
  /// update that follows.
  virtual void aim_drive(std::size_t drive, const std::optional<DriveAim>& aim) = 0;
};

}  // namespace brim
