#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "brim/body/body.h"

namespace brim {

/// What run.xdmf needs to know of the bodies.
struct XdmfModel {
  /// A body whose positions are recorded: it deforms, or has another surface in every frame.
  struct Item {
    std::string name;
    int index = 0;  ///< of the body
    Display::Kind kind = Display::Kind::Triangles;
    std::size_t vertices = 0, cells = 0;
    std::size_t first_vertex = 0, first_cell = 0;  ///< in a row of all positions, and in the list of all cells
    bool changing = false;  ///< of another number of vertices and cells in every frame: then these say which rows
    std::vector<std::int64_t> vertex_offset, cell_offset;  ///< rows of frame f: offset[f] to offset[f + 1] - 1
  };
  std::vector<Item> bodies;
  std::size_t positions = 0, triangles = 0, lines = 0;  ///< of all bodies together
  std::size_t pieces = 0;                               ///< rigid pieces: shown as points with their rotations
};

/// XDMF 3 that lets ParaView and others open run.h5: one collection over time, in it one grid per body whose positions
/// are recorded, and one of points, "poses", for all rigid pieces.
/// @param times  [s] of the recorded frames
std::string xdmf_text(const XdmfModel& model, std::span<const double> times);

/// & < > and quotes written so that they stay text inside XML; characters that XML forbids become spaces.
std::string xml_escaped(const std::string& text);

}  // namespace brim
