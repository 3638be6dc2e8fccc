#pragma once

#include <functional>
#include <span>
#include <vector>

#include "brim/body/aimed_drives.h"
#include "brim/body/body.h"

namespace brim {

/// Targets of drives that were set between steps (World::set_drive), of bodies with AimedDrives. Part of the world's
/// state, in its memory:
///   memory: [−0.375, n, and for every drive: body, drive, position, velocity]; nothing if none was set
/// Tests: tests/world/drive_aims_test.cpp
class DriveAims {
 public:
  /// The body of a number; null for a number that is none.
  using Bodies = std::function<Body*(int)>;

  /// Sets the targets of drives [first, first + position.size()) of a body. @param velocity  of that length, or empty:
  /// 0
  void set(int body, std::size_t first, std::span<const double> position, std::span<const double> velocity,
           const Bodies& bodies);
  /// Target of a drive, if it was set.
  std::optional<DriveAim> of(int body, int drive) const;
  /// Reads and removes its part of memory, and aims all drives as it says. Entries that mean no drive are ignored.
  void take(std::vector<double>& memory, const Bodies& bodies);
  /// Writes it in front of the rest of memory.
  void keep(std::vector<double>& memory) const;

 private:
  /// Aims the drives in the list, or lets them go.
  static void apply(std::span<const double> list, bool aimed, const Bodies& bodies);

  std::vector<double> list_;  ///< body, drive, position, velocity; sorted by the first two
};

}  // namespace brim
