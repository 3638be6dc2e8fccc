#include "brim/world/drive_aims.h"

#include <algorithm>
#include <cmath>

namespace brim {

namespace {

/// First number of aims in memory; differs from those of Levels, Edits, Links, Sleep, sensors and ReferencePoses.
constexpr double kAimsMark = -0.375;
constexpr std::size_t kNumbersPerAim = 4;

}  // namespace

void DriveAims::apply(std::span<const double> list, bool aimed, const Bodies& bodies) {
  for (std::size_t i = 0; i + kNumbersPerAim <= list.size(); i += kNumbersPerAim) {
    auto* const drives = dynamic_cast<AimedDrives*>(bodies(static_cast<int>(list[i])));
    const auto drive = static_cast<std::size_t>(list[i + 1]);
    if (drives == nullptr || drive >= drives->drive_names().size()) continue;
    drives->aim_drive(drive, aimed ? std::optional(DriveAim{list[i + 2], list[i + 3]}) : std::nullopt);
  }
}

void DriveAims::set(int body, std::size_t first, std::span<const double> position, std::span<const double> velocity,
                    const Bodies& bodies) {
  std::size_t at = 0;
  for (std::size_t i = 0; i < position.size(); ++i) {
    const double b = body, drive = static_cast<double>(first + i);
    while (at < list_.size() && (list_[at] < b || (list_[at] == b && list_[at + 1] < drive))) at += kNumbersPerAim;
    if (at == list_.size() || list_[at] != b || list_[at + 1] != drive)
      list_.insert(list_.begin() + static_cast<std::ptrdiff_t>(at), {b, drive, 0.0, 0.0});
    list_[at + 2] = position[i], list_[at + 3] = velocity.empty() ? 0.0 : velocity[i];
    apply(std::span(list_).subspan(at, kNumbersPerAim), true, bodies);
  }
}

std::optional<DriveAim> DriveAims::of(int body, int drive) const {
  for (std::size_t i = 0; i + kNumbersPerAim <= list_.size(); i += kNumbersPerAim)
    if (list_[i] == body && list_[i + 1] == drive) return DriveAim{list_[i + 2], list_[i + 3]};
  return std::nullopt;
}

void DriveAims::take(std::vector<double>& memory, const Bodies& bodies) {
  std::size_t n = 0;
  const bool any = memory.size() >= 2 && memory[0] == kAimsMark && memory[1] >= 0.0;
  if (any) n = static_cast<std::size_t>(std::min(memory[1], static_cast<double>(memory.size() - 2)));
  const std::span<const double> given = std::span<const double>(memory).subspan(any ? 2 : 0, n);
  // In a run of steps nothing is new.
  if (!std::ranges::equal(given, list_)) {
    std::vector<double> list;
    for (std::size_t i = 0; i + kNumbersPerAim <= n; i += kNumbersPerAim) {
      const auto aim = given.subspan(i, kNumbersPerAim);
      const bool good = std::ranges::all_of(aim, [](double x) { return std::isfinite(x); }) && aim[0] >= 0.0 &&
                        aim[0] < 1e9 && aim[1] >= 0.0 && aim[1] < 1e9;
      if (good) list.insert(list.end(), aim.begin(), aim.end());
    }
    apply(list_, false, bodies);
    list_ = std::move(list);
    apply(list_, true, bodies);
  }
  if (any) memory.erase(memory.begin(), memory.begin() + static_cast<std::ptrdiff_t>(2 + n));
}

void DriveAims::keep(std::vector<double>& memory) const {
  if (list_.empty()) return;
  const std::size_t size = memory.size(), n = list_.size() + 2;
  memory.resize(size + n);
  std::copy_backward(memory.begin(), memory.begin() + static_cast<std::ptrdiff_t>(size), memory.end());
  memory[0] = kAimsMark, memory[1] = static_cast<double>(list_.size());
  std::ranges::copy(list_, memory.begin() + 2);
}

}  // namespace brim
