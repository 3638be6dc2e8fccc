#pragma once

#include <string>
#include <vector>

#include "brim/record/export/format.h"

namespace brim::exporting {

/// The text of export.json: which body is where in an export, in which frames (docs/export.md).
/// Tests: tests/record/export_catalogue_test.cpp
class Catalogue {
 public:
  Catalogue(const Job& job, std::string format) : job_(job), format_(std::move(format)), gone_(job.items.size()) {}
  /// Called for every frame, in order.
  void frame(const Frame& frame);
  /// @param writer  after its last frame  @param files  of the export
  std::string text(const Writer& writer, const std::vector<std::string>& files) const;

 private:
  const Job& job_;
  std::string format_;
  std::vector<std::int64_t> frames_;
  std::vector<double> times_;
  std::vector<std::vector<std::int64_t>> gone_;  ///< [item]: frames without it
};

}  // namespace brim::exporting
