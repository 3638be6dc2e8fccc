#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "brim/body/body.h"

namespace brim {

/// What run.xdmf needs to know of the bodies.
struct XdmfModel {
  struct Item {
    std::string name;
    int index = 0;  ///< of the body
    Display::Kind kind = Display::Kind::Triangles;
    std::size_t vertices = 0, cells = 0;
    bool still = false;     ///< recorded once
    bool changing = false;  ///< of another number of vertices and cells in every frame: then these say which rows
    std::vector<std::int64_t> vertex_offset, cell_offset;  ///< rows of frame f: offset[f] to offset[f + 1] - 1
  };
  std::vector<Item> bodies;
};

/// XDMF 3 that lets ParaView and others open run.h5: one collection over time, in it one grid per body.
/// @param times  [s] of the recorded frames
std::string xdmf_text(const XdmfModel& model, std::span<const double> times);

/// & < > and quotes written so that they stay text inside XML; characters that XML forbids become spaces.
std::string xml_escaped(const std::string& text);

}  // namespace brim
