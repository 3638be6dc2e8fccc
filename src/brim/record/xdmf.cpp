#include "brim/record/xdmf.h"

#include <fmt/format.h>

#include <iterator>

namespace brim {

namespace {

void topology(std::string& out, const XdmfModel::Item& b) {
  auto to = std::back_inserter(out);
  if (b.kind == Display::Kind::Points) {
    fmt::format_to(to, "<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\"/>", b.vertices);
    return;
  }
  const bool lines = b.kind == Display::Kind::Lines;
  fmt::format_to(
      to,
      "<Topology TopologyType=\"{}\" NumberOfElements=\"{}\"{}><DataItem Dimensions=\"{} {}\" NumberType=\"Int\" "
      "Precision=\"4\" Format=\"HDF\">run.h5:/bodies/{}/{}</DataItem></Topology>",
      lines ? "Polyline" : "Triangle", b.cells, lines ? " NodesPerElement=\"2\"" : "", b.cells, lines ? 2 : 3, b.index,
      lines ? "lines" : "triangles");
}

/// Rows of one frame out of all. The form "data set|start:stride:count:size" is that of Xdmf 3, which ParaView takes
/// for files of this kind unless told otherwise; the older ItemType="HyperSlab" makes it crash (ParaView 5.11).
void geometry(std::string& out, const XdmfModel::Item& b, std::size_t frame, std::size_t frames) {
  fmt::format_to(std::back_inserter(out),
                 "<Geometry GeometryType=\"XYZ\"><DataItem Dimensions=\"1 {1} 3\" NumberType=\"Float\" Precision=\"4\" "
                 "Format=\"HDF\">run.h5:/display/{3}/positions|{0} 0 0:1 1 1:1 {1} 3:{2} {1} 3</DataItem></Geometry>",
                 b.still ? 0 : frame, b.vertices, b.still ? 1 : frames, b.index);
}

/// A frame of a surface that changes: rows of its lists of triangles and of vertices.
void changing(std::string& out, const XdmfModel::Item& b, std::size_t frame) {
  const auto rows = [&](const char* list, const char* column, const std::vector<std::int64_t>& offset) {
    return fmt::format("Format=\"HDF\">run.h5:/display/{}/{}/{}|{} 0:1 1:{} 3:{} 3</DataItem>", b.index, list, column,
                       offset[frame], offset[frame + 1] - offset[frame], offset.back());
  };
  const auto count = [&](const std::vector<std::int64_t>& offset) { return offset[frame + 1] - offset[frame]; };
  fmt::format_to(std::back_inserter(out),
                 "<Topology TopologyType=\"Triangle\" NumberOfElements=\"{0}\"><DataItem Dimensions=\"{0} 3\" "
                 "NumberType=\"Int\" Precision=\"4\" {1}</Topology><Geometry GeometryType=\"XYZ\"><DataItem "
                 "Dimensions=\"{2} 3\" NumberType=\"Float\" Precision=\"4\" {3}</Geometry>",
                 count(b.cell_offset), rows("triangles", "corner", b.cell_offset), count(b.vertex_offset),
                 rows("vertices", "position", b.vertex_offset));
}

/// False in frames in which there is nothing to show: readers do not take empty grids.
bool shown(const XdmfModel::Item& b, std::size_t frame) {
  return b.changing ? b.cell_offset[frame + 1] > b.cell_offset[frame] : b.vertices > 0;
}

}  // namespace

std::string xml_escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return out;
}

std::string xdmf_text(const XdmfModel& model, std::span<const double> times) {
  std::string out =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n"
      "<Grid Name=\"run\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (std::size_t f = 0; f < times.size(); ++f) {
    fmt::format_to(std::back_inserter(out),
                   "<Grid Name=\"frame {}\" GridType=\"Collection\" CollectionType=\"Spatial\"><Time Value=\"{}\"/>\n",
                   f, times[f]);
    for (const XdmfModel::Item& b : model.bodies) {
      if (!shown(b, f)) continue;
      out += "<Grid Name=\"" + xml_escaped(b.name) + "\">";
      if (b.changing) {
        changing(out, b, f);
      } else {
        topology(out, b);
        geometry(out, b, f, times.size());
      }
      out += "</Grid>\n";
    }
    out += "</Grid>\n";
  }
  out += "</Grid>\n</Domain>\n</Xdmf>\n";
  return out;
}

}  // namespace brim
