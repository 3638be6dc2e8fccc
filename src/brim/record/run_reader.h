#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "brim/record/process_mark.h"
#include "brim/record/run_tables.h"
#include "brim/world/measures.h"
#include "brim/world/world.h"

namespace brim {

/// A point that an attachment or joint holds, [m].
struct RecordedEnd {
  std::int32_t link = 0;  ///< which of link_names()
  Vec3f a, b;             ///< on its first body; on the other one or in space
};

/// Reads run.h5, finished, growing or interrupted (docs/formats.md). Frame 0 is the start.
/// Runs of all versions of the format are read alike. Every function throws InputError for frames and names that are
/// not there, and for damaged files: what a file says is checked before it is used. For one thread at a time.
class RunReader {
 public:
  /// @param path  a run folder, or a run.h5
  explicit RunReader(const std::string& path);
  ~RunReader();
  RunReader(RunReader&&) noexcept;

  /// Of the file that is read.
  const std::string& path() const;
  const std::string& scene_name() const;
  const std::string& brim_version() const;
  /// Of the format, 1 or 2.
  int format_version() const;
  /// Of the file that the scene was read from, absolute; empty when it is not known.
  const std::string& scene_path() const;
  /// The process that writes the run, or wrote it last; not known for runs of older versions.
  const ProcessMark& writer() const;
  double frame_time() const;  ///< [s]
  int steps_per_frame() const;
  std::int64_t frames() const;
  double time(std::int64_t frame) const;
  const std::vector<RecordedBody>& bodies() const;
  const std::vector<RecordedPart>& parts() const;

  /// Everything that the world needs to go on from a frame, bit for bit.
  State state(std::int64_t frame) const;
  /// Display positions of one body, [m], shape (vertices); of a changing one, those of the frame.
  std::vector<Vec3f> positions(int body, std::int64_t frame) const;
  /// Triangles of a body in a frame: those of its display, or of a changing one, those of the frame.
  std::vector<Triangle> triangles(int body, std::int64_t frame) const;
  /// True while one set of positions stands for all frames of a body.
  bool still(int body) const;
  std::vector<ContactSample> contacts(std::int64_t frame) const;
  std::vector<std::pair<TileKey, double>> tiles(std::int64_t frame) const;
  std::vector<PairReport> pairs(std::int64_t frame) const;
  /// Attachments and joints in the last sub-step of a frame, and what they are called; none where the run has none.
  std::vector<LinkReport> links(std::int64_t frame) const;
  std::vector<std::string> link_names() const;
  /// What each is: "point", "region", "fixed", "ball", "hinge" or "slider"; none in runs from before it was recorded.
  std::vector<std::string> link_kinds() const;
  /// Numbers of the two bodies of each, -1 space; none of runs of older versions. @throws InputError  when damaged
  std::vector<std::pair<int, int>> link_bodies() const;
  /// Where those that still hold have their ends at a frame; of a hinge or slider, the first two lie on its axis.
  std::vector<RecordedEnd> link_ends(std::int64_t frame) const;
  std::vector<Warning> warnings(std::int64_t frame) const;
  /// Report of a frame: scalars, pairs and warnings.
  StepReport report(std::int64_t frame) const;
  /// Steps that a frame joined.
  int steps(std::int64_t frame) const;
  /// Samples of all bodies, shape (bodies).
  std::vector<BodySample> samples(std::int64_t frame) const;
  /// One scalar over all frames ("worst_overlap", "seconds_solve", ...: report_fields(), "steps", "warnings").
  std::vector<double> series(const std::string& name) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// @throws InputError  naming the first difference, when the run is not one of such a world
void check_same_world(const RunReader& run, const World& world);

}  // namespace brim
