#pragma once

#include <cstdint>
#include <vector>

#include "brim/body/posed_shape.h"
#include "brim/record/h5.h"
#include "brim/world/world.h"

namespace brim {

/// A body as a run file describes it.
struct RecordedBody {
  std::string name, kind;
  Display display;
  bool immobile = false;
  bool changing = false;  ///< other vertices and triangles in every frame: the display has none of its own
  double mass = 0.0;      ///< [kg], may be infinite
  std::size_t q_offset = 0, q_size = 0, v_offset = 0, v_size = 0;
  int parts = 0;
};

/// A part as a run file describes it.
struct RecordedPart {
  std::string name, material;
  int body = 0, part = 0;
  double voxel_size = 0.0;  ///< [m]
};

/// What a run file says once for all frames (docs/formats.md).
struct RunTables {
  /// Where the frames of a body's display are.
  struct Place {
    std::int64_t first_position = -1;         ///< its first vertex in a row of /display/positions; -1: not there
    std::size_t first_piece = 0, pieces = 0;  ///< in a row of /poses
  };
  std::vector<RecordedBody> bodies;
  std::vector<Place> places;  ///< shape (bodies); empty for version 1
  std::vector<RecordedPart> parts;
  std::vector<std::int32_t> piece_mesh;         ///< mesh of each piece, shape (pieces)
  std::vector<std::int64_t> mesh_first_vertex;  ///< shape (meshes + 1)
  std::vector<Vec3> rest;                       ///< [m] vertices of the meshes, each in its shape's frame

  std::span<const Vec3> mesh(std::size_t piece) const {
    const auto m = static_cast<std::size_t>(piece_mesh[piece]);
    const auto first = static_cast<std::size_t>(mesh_first_vertex[m]);
    return std::span(rest).subspan(first, static_cast<std::size_t>(mesh_first_vertex[m + 1]) - first);
  }
  /// Vertices of all deforming displays: rows of /display/positions.
  std::size_t positions = 0;
};

/// Writes /bodies, /parts, /meshes and what of /display and /poses is the same in all frames.
void write_tables(h5::File& file, const World& world);
/// Reads them back, every number checked. @throws InputError
RunTables read_tables(const h5::File& file);
/// Reads those of version 1. @throws InputError
RunTables read_tables_v1(const h5::File& file);

}  // namespace brim
