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

/// How the velocities of a body's vertices are found.
enum class VelocitySource {
  None,        ///< not at all: the body's surface changes, and the world cannot be built anew
  Twist,       ///< from the recorded velocity and spin of a rigid body
  Nodes,       ///< vertices are nodes, whose velocities are recorded
  Map,         ///< by the body itself, from what is recorded: (∂x/∂q) v
  Differences  ///< of positions in the frames before and after
};

/// A part of a body that moves as a rigid one, as links do.
struct ItemPiece {
  std::string name;        ///< of the part
  std::string identifier;  ///< unique within the item; as that of items
  RecordedPiece vertices;
};

/// A body to be exported.
struct Item {
  int body = 0;            ///< number in the run
  std::string name;        ///< in the run
  std::string file_name;   ///< see file_names (names.h)
  std::string identifier;  ///< see identifiers (names.h)
  const RecordedBody* recorded = nullptr;
  std::vector<ItemPiece> pieces;  ///< two or more of a body of several rigid parts; else empty
  VelocitySource velocity = VelocitySource::None;
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
  std::vector<std::vector<Vec3f>> velocities;    ///< [m/s], per item; empty where Item::velocity is None
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

/// Where a body or the contacts are in an export, as export.json tells it.
struct ItemPlace {
  std::string file{};  ///< "%05d" stands for the frame's number; empty: nowhere
  std::string path{};  ///< within the file: prim, node, grid, object or array; empty: the file as a whole
  std::vector<std::string> pieces{};  ///< likewise of Item::pieces; empty: they are not apart
};

/// Writes one format: frames in order, then finish.
class Writer {
 public:
  virtual ~Writer() = default;
  virtual ItemPlace place(const Item& item) const = 0;
  virtual ItemPlace contacts_place() const { return {}; }
  virtual void frame(const Frame& frame) = 0;
  virtual void finish() {}
};

struct Format {
  const char* name;
  const char* text;         ///< one-line description
  bool world = false;       ///< needs Job::world_at
  bool velocities = false;  ///< writes Frame::velocities; without it they are not found
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

/// "name_%05d.end", the names of numbered() for every frame.
std::string pattern(std::string_view name, std::string_view end);

/// "name_00012.end", with the frame's number in the run.
std::string numbered(std::string_view name, std::int64_t frame, std::string_view end);

/// Line segments joined into chains, each a list of vertices; a closed chain repeats its first vertex at its end.
std::vector<std::vector<std::int32_t>> chains(std::span<const std::array<std::int32_t, 2>> lines, std::size_t vertices);

}  // namespace brim::exporting
