#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "brim/world/measures.h"
#include "brim/world/world.h"

namespace brim {

/// Origin of a run, stored in its folder.
struct RunInfo {
  std::string scene_name;
  std::string scene_text;   ///< written to scene.json byte for byte
  double frame_time = 0.0;  ///< [s]
  int steps_per_frame = 1;
  std::string scene_path{};  ///< absolute path of the scene file; paths in a scene are relative to its folder
};

/// Records a run into a folder: run.h5, run.xdmf and scene.json (docs/formats.md). The file is readable while it grows,
/// and if the process is killed it contains every frame up to the last flush, at most a second old.
/// Tests: tests/record/run_test.cpp
class RunWriter {
 public:
  /// Creates the folder and removes an old run in it (call check_run_folder first). @throws InputError
  RunWriter(const std::string& folder, const World& world, const RunInfo& info);
  /// Continues a recorded run after its frame `frame`; later frames are dropped.
  /// @throws InputError  when the folder contains no run of this world
  RunWriter(const std::string& folder, const World& world, std::int64_t frame);
  ~RunWriter();
  RunWriter(RunWriter&&) noexcept;

  /// Records the present world. @param samples  of all bodies (Measures::samples)
  void add(const World& world, const StepReport& frame, int steps, std::span<const BodySample> samples);
  /// The same with contacts and tiles other than the world's own (copies of older runs), and without sensors.
  void add(const World& world, const StepReport& frame, int steps, std::span<const BodySample> samples,
           std::span<const ContactSample> contacts, std::span<const std::pair<TileKey, double>> tiles);
  /// Writes everything out; recording can continue afterwards.
  void flush();
  std::int64_t frames() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace brim
