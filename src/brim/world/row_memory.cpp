#include "brim/world/row_memory.h"

namespace brim {

namespace {

/// Count of numbers per point: parts, position, force on a.
constexpr std::size_t kRecord = 8;
/// [voxels] largest distance from the matching point of the last step.
constexpr double kSamePoint = 2.0;

}  // namespace

void RowMemory::recall(std::span<const double> memory, const ContactSet& points, std::span<Vec3> force) {
  const std::size_t old = memory.size() / kRecord;
  used_.assign(old, 0);
  anew_.clear();
  std::size_t first = 0;
  const auto is_before = [&](std::size_t i, const ContactPair& p) {
    const double a = memory[kRecord * i], b = memory[kRecord * i + 1];
    return a != p.part_a ? a < p.part_a : b < p.part_b;
  };
  for (const ContactPair& pair : points.pairs) {  // both are ordered by part numbers
    while (first < old && is_before(first, pair)) ++first;
    std::size_t end = first;
    while (end < old && memory[kRecord * end] == pair.part_a && memory[kRecord * end + 1] == pair.part_b) ++end;
    fresh_.clear();
    for (std::size_t c = pair.begin; c < pair.end; ++c) {
      force[c].setZero();
      double least = kSamePoint * kSamePoint * pair.h * pair.h;
      std::size_t best = end;
      for (std::size_t i = first; i < end; ++i) {
        const double* m = &memory[kRecord * i];
        const double d = used_[i] ? least : (Vec3(m[2], m[3], m[4]) - points.point[c]).squaredNorm();
        if (d < least) least = d, best = i;
      }
      if (best == end) {
        fresh_.push_back(c);
        continue;
      }
      used_[best] = 1;
      const double* m = &memory[kRecord * best];
      force[c] = Vec3(m[5], m[6], m[7]);
    }
    // All points are others: they share what the pair bore.
    const bool anew = end > first && fresh_.size() == pair.end - pair.begin;
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = first; anew && i < end; ++i)
      sum += Vec3(memory[kRecord * i + 5], memory[kRecord * i + 6], memory[kRecord * i + 7]);
    for (const std::size_t c : fresh_) force[c] = sum / static_cast<double>(fresh_.size());
    anew_.push_back(anew && !fresh_.empty());
    first = end;
  }
}

std::vector<std::pair<std::int32_t, std::int32_t>> RowMemory::pairs(std::span<const double> memory) {
  std::vector<std::pair<std::int32_t, std::int32_t>> out;
  for (std::size_t i = 0; i + kRecord <= memory.size(); i += kRecord) {
    const std::pair pair(static_cast<std::int32_t>(memory[i]), static_cast<std::int32_t>(memory[i + 1]));
    if (out.empty() || out.back() != pair) out.push_back(pair);
  }
  return out;
}

void RowMemory::keep(const ContactPair& pair, const Vec3& x, const Vec3& f, std::vector<double>& memory) {
  memory.insert(memory.end(), {static_cast<double>(pair.part_a), static_cast<double>(pair.part_b), x.x(), x.y(), x.z(),
                               f.x(), f.y(), f.z()});
}

}  // namespace brim
