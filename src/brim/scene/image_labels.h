#pragma once

#include <string>
#include <vector>

#include "brim/io/volume_reader.h"
#include "brim/scene/node.h"

namespace brim {

/// The labels that an image holds, for messages: "0, 3, 5".
std::string listed_labels(const IntensitySummary& held);

/// The "labels" of a scene that are matter, and which of them voxels have.
class ImageLabels {
 public:
  /// @param source  the entry that has "labels"
  explicit ImageLabels(const Node& source);

  /// [-] Share of matter of a voxel: 1 for one of the labels, else 0. May be called by several threads at once.
  double share(double intensity);
  /// To be called when all voxels have been read.
  /// @throws InputError  when no voxel has some of the labels; if none has any, there is no matter, and nothing is
  /// thrown
  void check(const VolumeInfo& info) const;

 private:
  Node node_;
  std::vector<int> labels_;
  std::vector<char> found_;  ///< per label: nonzero when a voxel has it
};

}  // namespace brim
