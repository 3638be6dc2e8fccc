#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "brim/world/measures.h"
#include "brim/world/world.h"

namespace brim {

/// What a run folder says about where it came from.
struct RunInfo {
  std::string scene_name;
  std::string scene_text;   ///< written to scene.json byte for byte
  double frame_time = 0.0;  ///< [s]
  int steps_per_frame = 1;
  std::string scene_path{};  ///< absolute, of the file it was read from; paths in a scene start from its folder
};

/// Records a run into a folder: run.h5, run.xdmf and scene.json (docs/formats.md). The file can be read while it grows,
/// and after the process was killed holds every frame up to the last flush, at most a second old.
/// Tests: tests/record/run_test.cpp
class RunWriter {
 public:
  /// Makes the folder; an old run in it is removed (check_run_folder comes first). @throws InputError
  RunWriter(const std::string& folder, const World& world, const RunInfo& info);
  /// Goes on with a recorded run after its frame `frame`; later frames are dropped.
  /// @throws InputError  when the folder holds no run of such a world
  RunWriter(const std::string& folder, const World& world, std::int64_t frame);
  ~RunWriter();
  RunWriter(RunWriter&&) noexcept;

  /// Records the world as it is now. @param samples  of all bodies (Measures::samples)
  void add(const World& world, const StepReport& frame, int steps, std::span<const BodySample> samples);
  /// The same with contacts and tiles that are not the world's own (copies of older runs), and without sensors.
  void add(const World& world, const StepReport& frame, int steps, std::span<const BodySample> samples,
           std::span<const ContactSample> contacts, std::span<const std::pair<TileKey, double>> tiles);
  /// Writes everything out; the object can go on afterwards.
  void flush();
  std::int64_t frames() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace brim
