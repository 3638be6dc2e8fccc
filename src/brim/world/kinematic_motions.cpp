#include "brim/world/kinematic_motions.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace brim {

namespace {

/// First number of motions in memory; differs from those of Levels, Edits, DriveAims, Links, Sleep, sensors and
/// ReferencePoses.
constexpr double kMotionsMark = -0.1875;
constexpr std::size_t kNumbersPerMotion = 10;

std::array<double, kNumbersPerMotion> numbers_of_motion(int body, const KinematicMotion& m) {
  if (m.to_pose)
    return {double(body),   1.0,
            m.at,           m.position.x(),
            m.position.y(), m.position.z(),
            m.rotation.w(), m.rotation.x(),
            m.rotation.y(), m.rotation.z()};
  return {double(body),   0.0,        0.0,        m.velocity.x(), m.velocity.y(),
          m.velocity.z(), m.spin.x(), m.spin.y(), m.spin.z(),     0.0};
}

KinematicMotion motion_of(std::span<const double> n) {
  KinematicMotion m;
  m.to_pose = n[1] == 1.0;
  if (m.to_pose) {
    m.at = n[2], m.position = Vec3(n[3], n[4], n[5]);
    m.rotation = Quat(n[6], n[7], n[8], n[9]);
  } else {
    m.velocity = Vec3(n[3], n[4], n[5]), m.spin = Vec3(n[6], n[7], n[8]);
  }
  return m;
}

bool is_motion(std::span<const double> n) {
  const double length2 = n[6] * n[6] + n[7] * n[7] + n[8] * n[8] + n[9] * n[9];
  return std::ranges::all_of(n, [](double x) { return std::isfinite(x); }) && n[0] >= 0.0 && n[0] < 1e9 &&
         (n[1] == 0.0 || (n[1] == 1.0 && std::abs(length2 - 1.0) < 1e-6));
}

}  // namespace

void KinematicMotions::apply(std::span<const double> list, bool given, const Bodies& bodies) {
  for (std::size_t i = 0; i + kNumbersPerMotion <= list.size(); i += kNumbersPerMotion) {
    auto* const body = dynamic_cast<Kinematic*>(bodies(static_cast<int>(list[i])));
    if (body == nullptr) continue;
    body->set_motion(given ? std::optional(motion_of(list.subspan(i, kNumbersPerMotion))) : std::nullopt);
  }
}

void KinematicMotions::set(int body, const KinematicMotion& motion, const Bodies& bodies) {
  std::size_t at = 0;
  while (at < list_.size() && list_[at] < body) at += kNumbersPerMotion;
  const auto numbers = numbers_of_motion(body, motion);
  const auto place = list_.begin() + static_cast<std::ptrdiff_t>(at);
  if (at < list_.size() && list_[at] == body)
    std::ranges::copy(numbers, place);
  else
    list_.insert(place, numbers.begin(), numbers.end());
  apply(std::span(list_).subspan(at, kNumbersPerMotion), true, bodies);
}

void KinematicMotions::take(std::vector<double>& memory, const Bodies& bodies) {
  std::size_t n = 0;
  const bool any = memory.size() >= 2 && memory[0] == kMotionsMark && memory[1] >= 0.0;
  if (any) n = static_cast<std::size_t>(std::min(memory[1], static_cast<double>(memory.size() - 2)));
  const std::span<const double> given = std::span<const double>(memory).subspan(any ? 2 : 0, n);
  // In a run of steps nothing is new.
  if (!std::ranges::equal(given, list_)) {
    std::vector<double> list;
    for (std::size_t i = 0; i + kNumbersPerMotion <= n; i += kNumbersPerMotion)
      if (const auto one = given.subspan(i, kNumbersPerMotion); is_motion(one))
        list.insert(list.end(), one.begin(), one.end());
    apply(list_, false, bodies);
    list_ = std::move(list);
    apply(list_, true, bodies);
  }
  if (any) memory.erase(memory.begin(), memory.begin() + static_cast<std::ptrdiff_t>(2 + n));
}

void KinematicMotions::keep(std::vector<double>& memory) const {
  if (list_.empty()) return;
  std::vector<double> head = {kMotionsMark, static_cast<double>(list_.size())};
  head.insert(head.end(), list_.begin(), list_.end());
  memory.insert(memory.begin(), head.begin(), head.end());
}

}  // namespace brim
