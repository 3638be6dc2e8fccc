#pragma once

#include <cstdint>
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
    bool changing = false;  ///< of another number of vertices and cells in every frame: XdmfFrames says which rows
  };
  std::vector<Item> bodies;
  std::size_t positions = 0, triangles = 0, lines = 0;  ///< of all bodies together
  std::size_t pieces = 0;                               ///< rigid pieces: shown as points with their rotations
};

/// Some frames one after another, as run.xdmf says where they are.
struct XdmfFrames {
  /// Of a body whose surface is another one in every frame.
  struct Rows {
    std::vector<std::int64_t> vertices, cells;     ///< rows of frame first + i: [i] to [i + 1] - 1
    std::int64_t all_vertices = 0, all_cells = 0;  ///< rows of the whole run
  };
  std::size_t first = 0, all = 0;  ///< the first of them; frames of the run
  std::vector<double> times;       ///< [s]
  std::vector<Rows> rows;          ///< shape (XdmfModel::bodies); empty for surfaces that do not change
};

/// XDMF 3 that lets ParaView and others open run.h5: one collection over time, in it one grid per body whose positions
/// are recorded, and one of points, "poses", for all rigid pieces. The text is a head, frames in as many pieces as one
/// likes, and a tail, so that it need not be held as a whole.
std::string xdmf_head();
std::string xdmf_frames(const XdmfModel& model, const XdmfFrames& frames);
std::string xdmf_tail();

/// & < > and quotes written so that they stay text inside XML; characters that XML forbids become spaces.
std::string xml_escaped(const std::string& text);

}  // namespace brim
