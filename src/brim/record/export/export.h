#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "brim/record/run_reader.h"
#include "brim/world/world.h"

namespace brim {

/// What to export of a run, and where to.
struct ExportRequest {
  std::string format{};               ///< name of one of formats()
  std::string folder{};               ///< created; must not exist, be empty, or (with force) contain an older export
  std::string frames{};               ///< see parse_frames; empty: all
  std::vector<std::string> bodies{};  ///< names, each the name of a body or of all its numbered copies; empty: all
  double voxel_size = 0.0;            ///< [m] of densities; 0: that of each body's finest part
  bool force = false;
};

/// Frames first, first + stride, ... up to last.
struct FrameRange {
  std::int64_t first = 0, last = 0, stride = 1;
  std::int64_t count() const { return (last - first) / stride + 1; }
};

/// Parses "a", "a:b" or "a:b:stride", both ends included; an omitted end is the run's own, a negative one counts from
/// the end (-1 is the last frame). @throws InputError  for other text, and for frames that the run does not have
FrameRange parse_frames(const std::string& text, std::int64_t frames);

/// Numbers of the bodies matched by the names, in order. @throws InputError  for a name without match
std::vector<int> choose_bodies(const RunReader& run, const std::vector<std::string>& names);

/// The world of the run in the state of a frame; only used by formats that write what is not recorded.
using WorldAt = std::function<const World&(std::int64_t frame)>;

/// Result of an export.
struct ExportResult {
  std::int64_t frames = 0;
  std::vector<std::string> files;  ///< names within the folder
};

/// Exports a run in another program's format (docs/export.md). Everything is written into a folder beside the requested
/// one and moved there when complete: a failed export changes nothing.
/// @param world_at  may be empty when the format needs no world
/// @param progress  called with (frames done, total frames); false stops the export and removes it
/// @throws InputError  for invalid requests, folders with other contents, and files that cannot be written
/// Tests: tests/record/export_test.cpp, tests/record/export_usda_test.cpp, tests/record/export_stress_test.cpp,
/// tests/record/export_readers_test.cpp
ExportResult export_run(const RunReader& run, const ExportRequest& request, const WorldAt& world_at = {},
                        const std::function<bool(std::int64_t, std::int64_t)>& progress = {});

}  // namespace brim
