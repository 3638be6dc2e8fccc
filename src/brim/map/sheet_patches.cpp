#include "brim/map/sheet_patches.h"

#include <algorithm>

namespace brim {

SheetPatches::SheetPatches(std::span<const Corners> triangles) : triangles_(triangles.begin(), triangles.end()) {
  std::int32_t count = 0;
  for (const Corners& t : triangles_) count = std::max({count, t[0] + 1, t[1] + 1, t[2] + 1});
  std::vector<std::vector<std::int32_t>> at(static_cast<std::size_t>(count));
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (const std::int32_t i : triangles_[t]) at[i].push_back(static_cast<std::int32_t>(t));
  first_.assign(1, 0);
  std::vector<std::int32_t> patch;
  for (const Corners& t : triangles_) {
    patch.clear();
    for (const std::int32_t i : t)
      for (const std::int32_t near : at[i]) patch.insert(patch.end(), triangles_[near].begin(), triangles_[near].end());
    std::sort(patch.begin(), patch.end());
    vertices_.insert(vertices_.end(), patch.begin(), std::unique(patch.begin(), patch.end()));
    first_.push_back(static_cast<std::int32_t>(vertices_.size()));
  }
}

}  // namespace brim
