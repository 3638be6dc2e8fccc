#pragma once

#include <cstdint>
#include <vector>

#include "brim/body/posed_shape.h"
#include "brim/record/h5.h"
#include "brim/world/world.h"

namespace brim {

/// A body as described by a run file.
struct RecordedBody {
  std::string name, kind;
  Display display;
  bool immobile = false;
  bool changing = false;  ///< vertices and triangles change in every frame: the display has none of its own
  double mass = 0.0;      ///< [kg], may be infinite
  std::size_t q_offset = 0, q_size = 0, v_offset = 0, v_size = 0;
  int parts = 0;
};

/// A part as described by a run file.
struct RecordedPart {
  std::string name, material;
  int body = 0, part = 0;
  double voxel_size = 0.0;  ///< [m]
};

/// Data that a run file stores once for all frames (docs/formats.md).
struct RunTables {
  /// Position of a body's display data in the frames.
  struct Place {
    std::int64_t first_position = -1;         ///< its first vertex in a row of /display/positions; -1: none
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

/// Writes /bodies, /parts, /meshes and the constant parts of /display and /poses.
void write_tables(h5::File& file, const World& world);
/// Reads them, checking every number. @throws InputError
RunTables read_tables(const h5::File& file);
/// Reads those of version 1. @throws InputError
RunTables read_tables_v1(const h5::File& file);

}  // namespace brim
