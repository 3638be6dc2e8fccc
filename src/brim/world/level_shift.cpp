#include "brim/world/level_shift.h"

#include <algorithm>

namespace brim {

namespace {

/// Slope of a ramp at its middle, times its width.
constexpr double kSlope = 1.5;

}  // namespace

std::map<LevelShift::Pair, LevelShift::Depth> LevelShift::depths(const ContactSet& contacts) {
  std::map<Pair, Depth> found;
  for (const ContactPair& p : contacts.pairs) {
    double most = 0.0;
    for (std::size_t c = p.begin; c < p.end; ++c) most = std::max(most, static_cast<double>(contacts.depth[c]));
    if (most > 0.0) found[{p.part_a, p.part_b}] = {most, p.h};
  }
  return found;
}

void LevelShift::change(const std::map<Pair, Depth>& before, const std::map<Pair, Depth>& after) {
  for (const auto& [pair, now] : after) {
    const auto was = before.find(pair);
    const auto shifted = shift_.find(pair);
    const double known = shifted != shift_.end() ? shifted->second.now : 0.0;
    double real = was != before.end() ? std::max(0.0, was->second.depth - known) : 0.0;
    if (real > 0.0) real *= std::min(1.0, now.h / was->second.h);
    const double jump = now.depth - real;
    if (jump > 0.0) shift_[pair] = {jump, jump / kSpan};
  }
}

void LevelShift::apply(ContactSet& contacts) const {
  if (shift_.empty()) return;
  for (const ContactPair& p : contacts.pairs) {
    const auto it = shift_.find({p.part_a, p.part_b});
    if (it == shift_.end()) continue;
    const double s = it->second.now;
    for (std::size_t c = p.begin; c < p.end; ++c) {
      const double depth = contacts.depth[c], left = depth - s;
      const double overlap = contacts.overlap[c];
      contacts.depth[c] = static_cast<float>(left);
      contacts.overlap[c] = static_cast<float>(
          left > 0.0 ? overlap * (left / depth) : std::min(overlap, 0.0) + kSlope / p.w * std::min(left, 0.0));
    }
  }
}

void LevelShift::pass(double dt) {
  for (auto it = shift_.begin(); it != shift_.end();) {
    it->second.now -= it->second.rate * dt;
    it = it->second.now > 0.0 ? std::next(it) : shift_.erase(it);
  }
}

std::vector<double> LevelShift::numbers() const {
  std::vector<double> list;
  for (const auto& [pair, s] : shift_)
    list.insert(list.end(), {static_cast<double>(pair.first), static_cast<double>(pair.second), s.now, s.rate});
  return list;
}

void LevelShift::take(std::span<const double> numbers) {
  shift_.clear();
  for (std::size_t i = 0; i + 4 <= numbers.size(); i += 4)
    shift_[{static_cast<std::int32_t>(std::clamp(numbers[i], 0.0, 2e9)),
            static_cast<std::int32_t>(std::clamp(numbers[i + 1], 0.0, 2e9))}] = {numbers[i + 2], numbers[i + 3]};
}

}  // namespace brim
