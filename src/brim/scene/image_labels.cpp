#include "brim/scene/image_labels.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace brim {

std::string listed_labels(const IntensitySummary& held) {
  return fmt::format("{}{}", fmt::join(held.labels, ", "), held.more_labels ? " and higher ones" : "");
}

ImageLabels::ImageLabels(const Node& source) : node_(source.at("labels")) {
  for (const int label : node_.integers())
    if (std::find(labels_.begin(), labels_.end(), label) == labels_.end()) labels_.push_back(label);
  found_.assign(labels_.size(), 0);
}

double ImageLabels::share(double intensity) {
  const auto at = std::find(labels_.begin(), labels_.end(), static_cast<int>(std::lround(intensity)));
  if (at == labels_.end()) return 0.0;
  std::atomic_ref found(found_[static_cast<std::size_t>(at - labels_.begin())]);
  if (found.load(std::memory_order_relaxed) == 0) found.store(1, std::memory_order_relaxed);
  return 1.0;
}

void ImageLabels::check(const VolumeInfo& info) const {
  std::vector<int> absent;
  for (std::size_t i = 0; i < labels_.size(); ++i)
    if (found_[i] == 0) absent.push_back(labels_[i]);
  if (absent.empty() || absent.size() == labels_.size()) return;
  const IntensitySummary held = summarize_intensities(info, [](double) { return 0.0; });
  throw node_.error(fmt::format("no voxel has the label{} {}; the image holds {}", absent.size() > 1 ? "s" : "",
                                fmt::join(absent, ", "), listed_labels(held)));
}

}  // namespace brim
