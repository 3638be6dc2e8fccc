#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "brim/body/body.h"

namespace brim {

/// Description of the bodies for run.xdmf.
struct XdmfModel {
  /// A body whose positions are recorded: it deforms, or its surface changes.
  struct Item {
    std::string name;
    int index = 0;  ///< of the body
    Display::Kind kind = Display::Kind::Triangles;
    std::size_t vertices = 0, cells = 0;
    std::size_t first_vertex = 0, first_cell = 0;  ///< in a row of all positions, and in the list of all cells
    bool changing = false;  ///< vertices and cells vary in number from frame to frame: XdmfFrames has the rows
  };
  std::vector<Item> bodies;
  std::size_t positions = 0, triangles = 0, lines = 0;  ///< of all bodies together
  std::size_t pieces = 0;                               ///< rigid pieces: shown as points with rotations
};

/// Some consecutive frames and their positions in the file, for run.xdmf.
struct XdmfFrames {
  /// Of a body with a changing surface.
  struct Rows {
    std::vector<std::int64_t> vertices, cells;     ///< rows of frame first + i: [i] to [i + 1] - 1
    std::int64_t all_vertices = 0, all_cells = 0;  ///< rows of the whole run
  };
  std::size_t first = 0, all = 0;  ///< number of the first one; number of frames of the run
  std::vector<double> times;       ///< [s]
  std::vector<Rows> rows;          ///< shape (XdmfModel::bodies); empty for constant surfaces
};

/// XDMF 3 by which ParaView and others open run.h5: one temporal collection with one grid per body with recorded
/// positions, and one of points, "poses", for all rigid pieces. The text is a head, frames in any number of pieces, and
/// a tail, so that it need not be held in memory as a whole.
std::string xdmf_head();
std::string xdmf_frames(const XdmfModel& model, const XdmfFrames& frames);
std::string xdmf_tail();

/// Escapes & < > and quotes for XML; characters that XML forbids become spaces.
std::string xml_escaped(const std::string& text);

}  // namespace brim
