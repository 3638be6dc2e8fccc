#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "brim/record/export/export.h"

/// Common parts of the export formats: one file per format, and its line in formats.cpp.
namespace brim::exporting {

using Line = std::array<std::int32_t, 2>;  ///< vertices of a segment

/// A body to be exported.
struct Item {
  int body = 0;            ///< number in the run
  std::string name;        ///< in the run
  std::string file_name;   ///< see file_names (names.h)
  std::string identifier;  ///< see identifiers (names.h)
  const RecordedBody* recorded = nullptr;
  bool still = false;                    ///< all frames have the same positions
  Vec3f colour = Vec3f::Constant(0.5f);  ///< linear red, green, blue, as in the viewer
};

/// One frame of the items, in their order.
struct Frame {
  std::int64_t index = 0;                        ///< in the run
  std::int64_t order = 0;                        ///< 0, 1, ... among the exported ones
  double time = 0.0;                             ///< [s]
  std::vector<std::vector<Vec3f>> positions;     ///< [m], per item, shape (vertices)
  std::vector<std::vector<Triangle>> triangles;  ///< per item; those of this frame for changing surfaces
  std::vector<std::vector<Line>> lines;          ///< per item
  std::vector<std::vector<Vec3f>> velocities;    ///< [m/s], per item; empty if the run has none per vertex
  std::vector<char> gone;                        ///< per item: removed, so that all its lists here are empty
  std::vector<ContactSample> contacts;           ///< contacts that involve an item
};

/// Input of a writer, given before the first frame. Outlives the writer.
struct Job {
  const RunReader* run = nullptr;
  FrameRange frames;
  std::vector<Item> items;
  std::filesystem::path folder;  ///< empty; write here
  double voxel_size = 0.0;       ///< [m], 0: each body's own
  WorldAt world_at;
};

/// Writes one format: frames in order, then finish.
class Writer {
 public:
  virtual ~Writer() = default;
  virtual void frame(const Frame& frame) = 0;
  virtual void finish() {}
};

struct Format {
  const char* name;
  const char* text;    ///< one-line description
  bool world = false;  ///< needs Job::world_at
  std::unique_ptr<Writer> (*make)(const Job&);
};

/// All formats of this build.
std::span<const Format> formats();

std::unique_ptr<Writer> make_gltf(const Job& job);
std::unique_ptr<Writer> make_npz(const Job& job);
std::unique_ptr<Writer> make_obj(const Job& job);
std::unique_ptr<Writer> make_ply(const Job& job);
std::unique_ptr<Writer> make_usda(const Job& job);
std::unique_ptr<Writer> make_vdb(const Job& job);
std::unique_ptr<Writer> make_vtk(const Job& job);
std::unique_ptr<Writer> make_vtu(const Job& job);
std::unique_ptr<Writer> make_xdmf(const Job& job);

/// "name_00012.end", with the frame's number in the run.
std::string numbered(std::string_view name, std::int64_t frame, std::string_view end);

/// Line segments joined into chains, each a list of vertices; a closed chain repeats its first vertex at its end.
std::vector<std::vector<std::int32_t>> chains(std::span<const std::array<std::int32_t, 2>> lines, std::size_t vertices);

}  // namespace brim::exporting
