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

/// Positions of a point held by an attachment or joint, [m].
struct RecordedEnd {
  std::int32_t link = 0;  ///< index into link_names()
  Vec3f a, b;             ///< on its first body; on the other one or in space
};

/// A rigid piece of a body's display: its vertices, one after another.
struct RecordedPiece {
  std::size_t first_vertex = 0, vertices = 0;
};

/// Reads run.h5, complete, growing or interrupted (docs/formats.md). Frame 0 is the start. All versions of the format
/// are supported. Every function throws InputError for unknown frames and names, and for damaged files: contents are
/// checked before use. Not thread-safe.
class RunReader {
 public:
  /// @param path  a run folder, or a run.h5
  explicit RunReader(const std::string& path);
  ~RunReader();
  RunReader(RunReader&&) noexcept;

  /// Of the file being read.
  const std::string& path() const;
  const std::string& scene_name() const;
  const std::string& brim_version() const;
  /// Of the format, 1 or 2.
  int format_version() const;
  /// Absolute path of the scene file; empty when unknown.
  const std::string& scene_path() const;
  /// The process that is writing the run, or wrote it last; unknown for older versions.
  const ProcessMark& writer() const;
  double frame_time() const;  ///< [s]
  int steps_per_frame() const;
  std::int64_t frames() const;
  double time(std::int64_t frame) const;
  const std::vector<RecordedBody>& bodies() const;
  const std::vector<RecordedPart>& parts() const;

  /// Pieces of a body whose display moves in rigid ones, in the order of its vertices: those of an articulated body are
  /// its parts. Empty for a body that deforms, and for all of older runs.
  std::vector<RecordedPiece> pieces(int body) const;

  /// Complete state to continue the world from a frame, bit for bit.
  State state(std::int64_t frame) const;
  /// Display positions of one body, [m], shape (vertices); for a changing surface those of the frame.
  std::vector<Vec3f> positions(int body, std::int64_t frame) const;
  /// Triangles of a body in a frame: those of its display, or for a changing surface those of the frame.
  std::vector<Triangle> triangles(int body, std::int64_t frame) const;
  /// True when all frames so far have the same positions of a body, and none is without it.
  bool still(int body) const;
  /// Numbers of the bodies that a frame is without, ascending: they were removed (docs/editing.md). Their positions are
  /// all the same point.
  std::vector<int> removed(std::int64_t frame) const;
  std::vector<ContactSample> contacts(std::int64_t frame) const;
  std::vector<std::pair<TileKey, double>> tiles(std::int64_t frame) const;
  std::vector<PairReport> pairs(std::int64_t frame) const;
  /// Reports and names of attachments and joints, in the last sub-step of a frame; empty if the run has none.
  std::vector<LinkReport> links(std::int64_t frame) const;
  std::vector<std::string> link_names() const;
  /// Kind of each: "point", "region", "fixed", "ball", "hinge" or "slider"; empty for older runs.
  std::vector<std::string> link_kinds() const;
  /// Numbers of the two bodies of each, -1: space; empty for runs of older versions. @throws InputError  when damaged
  std::vector<std::pair<int, int>> link_bodies() const;
  /// Ends of the active ones at a frame; for a hinge or slider the first two lie on its axis.
  std::vector<RecordedEnd> link_ends(std::int64_t frame) const;
  std::vector<Warning> warnings(std::int64_t frame) const;
  /// Report of a frame: scalars, pairs and warnings.
  StepReport report(std::int64_t frame) const;
  /// Number of steps accumulated in a frame.
  int steps(std::int64_t frame) const;
  /// Samples of all bodies, shape (bodies).
  std::vector<BodySample> samples(std::int64_t frame) const;
  /// One scalar over all frames ("worst_overlap", "seconds_solve", ...: report_fields(), "steps", "warnings").
  std::vector<double> series(const std::string& name) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// @throws InputError  naming the first difference, when the run is not one of this world
void check_same_world(const RunReader& run, const World& world);

}  // namespace brim
