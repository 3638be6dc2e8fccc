#pragma once

#include <string>
#include <vector>

#include "brim/mesh/voxel_image.h"

namespace brim::cli {

/// How the intensities of a volume are spread, and which windows divide them.
class VolumeHistogram {
 public:
  explicit VolumeHistogram(const std::vector<float>& values);
  /// Bars, logarithmic, and windows [lo, hi] around the two thresholds that part three classes best (Otsu 1979).
  std::string text() const;
  /// The two thresholds. Equal where all intensities are.
  std::pair<double, double> thresholds() const;

 private:
  double at(std::size_t bin) const { return lo_ + (hi_ - lo_) * static_cast<double>(bin) / kBins; }
  static constexpr std::size_t kBins = 256;
  double lo_ = 0.0, hi_ = 0.0;
  std::vector<double> count_;
};

/// Draws up to 24 slices along k, from the lowest intensity (black) to the highest (white).
/// @throws InputError  when the file cannot be written
void write_contact_sheet(const VoxelImage& image, const std::string& path);

}  // namespace brim::cli
