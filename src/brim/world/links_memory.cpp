/// What links keep from step to step: the part of a state's memory that is theirs.
#include <algorithm>
#include <cmath>

#include "brim/world/links.h"

namespace brim {

namespace {

/// First number of links in memory; differs from those of Levels, Edits, Sleep and ReferencePoses.
constexpr double kLinksMark = -0.125;
constexpr double kOlderMark =
    -0.25;  ///< of runs before Levels used it; the records of Levels are longer (Levels::read)
/// In the memory of links: between the numbers of broken ones and targets of drives, and before the swing.
constexpr double kAimsFollow = -1.0, kSwingFollows = -2.0;

}  // namespace

void Links::take(std::vector<double>& memory) {
  for (const auto& l : links_) l->broken = false, l->aim.reset();
  swing_ = swing_now_ = last_substep_ = 0.0;
  if (memory.size() < 2 || (memory[0] != kLinksMark && memory[0] != kOlderMark)) return;
  const auto n = static_cast<std::size_t>(std::clamp(memory[1], 0.0, static_cast<double>(memory.size() - 2)));
  const std::span<const double> numbers = std::span<const double>(memory).subspan(2, n);
  const auto link_at = [&](std::size_t i) {
    const double l = numbers[i];
    return l >= 0.0 && l < static_cast<double>(kept()) ? links_[static_cast<std::size_t>(l)].get() : nullptr;
  };
  std::size_t i = 0;
  for (; i < n && numbers[i] != kAimsFollow && numbers[i] != kSwingFollows; ++i)
    if (Link* const l = link_at(i)) l->broken = true;
  if (i < n && numbers[i] == kAimsFollow) ++i;
  for (; i + 3 <= n && numbers[i] != kSwingFollows; i += 3)
    if (Link* const l = link_at(i); l && std::isfinite(numbers[i + 1]) && std::isfinite(numbers[i + 2]))
      l->aim = DriveAim{numbers[i + 1], numbers[i + 2]};
  if (i + 2 <= n && numbers[i] == kSwingFollows && std::isfinite(numbers[i + 1])) swing_ = numbers[i + 1];
  if (i + 3 == n && numbers[i + 2] > 0.0 && std::isfinite(numbers[i + 2])) last_substep_ = numbers[i + 2];
  memory.erase(memory.begin(), memory.begin() + static_cast<std::ptrdiff_t>(2 + n));
}

void Links::keep(std::vector<double>& memory) const {
  std::vector<double> head = {kLinksMark, 0.0};
  for (std::size_t l = 0; l < kept(); ++l)
    if (links_[l]->broken) head.push_back(static_cast<double>(l));
  bool aimed = false;
  for (std::size_t l = 0; l < kept(); ++l) {
    const auto& aim = links_[l]->aim;
    if (!aim) continue;
    if (!aimed) head.push_back(kAimsFollow);
    aimed = true;
    head.insert(head.end(), {static_cast<double>(l), aim->position, aim->velocity});
  }
  if (kept() > 0 && last_substep_ > 0.0) head.insert(head.end(), {kSwingFollows, swing_, last_substep_});
  if (head.size() == 2) return;
  head[1] = static_cast<double>(head.size() - 2);
  memory.insert(memory.begin(), head.begin(), head.end());
}

}  // namespace brim
