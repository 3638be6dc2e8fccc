#pragma once

#include <vector>

#include "brim/record/ragged_list.h"
#include "brim/record/run_tables.h"
#include "brim/record/xdmf.h"
#include "brim/world/world.h"

namespace brim {

/// Display data of a run's bodies, frame by frame: poses of rigid pieces, positions of vertices, changing surfaces, and
/// which bodies have never moved (docs/formats.md).
/// Tests: tests/record/run_test.cpp
class FrameDisplay {
 public:
  FrameDisplay() = default;
  /// @param tables  must outlive this
  FrameDisplay(h5::File& file, const RunTables& tables, bool create);

  void add(const World& world);
  /// Drops all frames from `frames` on.
  void cut(std::uint64_t frames);
  void flush();
  /// Description of the bodies for run.xdmf.
  const XdmfModel& xdmf() const { return xdmf_; }
  /// Rows of the changing surfaces of frames, as flushed. @return shape (xdmf().bodies)
  std::vector<XdmfFrames::Rows> xdmf_rows(std::uint64_t first, std::uint64_t count) const;

 private:
  /// The changing surface of a body.
  struct Surface {
    std::size_t body = 0;
    std::size_t item = 0;  ///< of xdmf_.bodies
    RaggedList vertices, triangles;
  };
  /// Poses of all rigid pieces and positions of all vertices in a frame.
  struct Row {
    std::vector<double> rotation, translation;
    std::vector<Vec3f> positions;
  };

  void describe_xdmf();
  void place(const World& world);
  void shrink(const RunTables::Place& place, const Body& body);
  void add_surfaces(const World& world);
  void watch_still(const World& world);

  const RunTables* tables_ = nullptr;
  Column rotation_, translation_, positions_;
  std::vector<Surface> surfaces_;
  h5::Dataset still_set_;
  std::vector<std::int64_t> still_;  ///< per body: 1 until its display differs from the first, or it is gone
  bool still_changed_ = false;
  bool empty_ = true;
  Row row_, first_;
  std::vector<Vec3f> vertices_;
  std::vector<Triangle> corners_;
  XdmfModel xdmf_;
};

}  // namespace brim
