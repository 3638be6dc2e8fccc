#include "brim/record/xdmf.h"

#include <fmt/format.h>

#include <iterator>

namespace brim {

namespace {

// Rows are picked out of a data set as "data set|start:stride:count:size", one number per axis. That form is of Xdmf 3,
// which ParaView takes for files of this kind unless told otherwise; the older ItemType="HyperSlab" makes it crash
// (ParaView 5.11).

/// One frame of a data set of shape (frames, n, width): rows first to first + count.
std::string frame_item(const char* path, int bytes, std::size_t frame, std::size_t frames, std::size_t first,
                       std::size_t count, std::size_t n, int width) {
  return fmt::format(
      "<DataItem Dimensions=\"1 {5} {7}\" NumberType=\"Float\" Precision=\"{1}\" Format=\"HDF\">run.h5:{0}|{2} {4} 0:1 "
      "1 1:1 {5} {7}:{3} {6} {7}</DataItem>",
      path, bytes, frame, frames, first, count, n, width);
}

void topology(std::string& out, const XdmfModel& model, const XdmfModel::Item& b) {
  auto to = std::back_inserter(out);
  if (b.kind == Display::Kind::Points) {
    fmt::format_to(to, "<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\"/>", b.vertices);
    return;
  }
  const bool lines = b.kind == Display::Kind::Lines;
  fmt::format_to(
      to,
      "<Topology TopologyType=\"{}\" NumberOfElements=\"{}\"{}><DataItem Dimensions=\"{} {}\" NumberType=\"Int\" "
      "Precision=\"4\" Format=\"HDF\">run.h5:/display/{}|{} 0:1 1:{} {}:{} {}</DataItem></Topology>",
      lines ? "Polyline" : "Triangle", b.cells, lines ? " NodesPerElement=\"2\"" : "", b.cells, lines ? 2 : 3,
      lines ? "lines" : "triangles", b.first_cell, b.cells, lines ? 2 : 3, lines ? model.lines : model.triangles,
      lines ? 2 : 3);
}

/// All rigid pieces as points at the origins of their shapes, with their rotations row by row.
void poses(std::string& out, const XdmfModel& model, std::size_t frame, std::size_t frames) {
  fmt::format_to(std::back_inserter(out),
                 "<Grid Name=\"poses\"><Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\"/><Geometry "
                 "GeometryType=\"XYZ\">{}</Geometry><Attribute Name=\"rotation\" AttributeType=\"Tensor\" "
                 "Center=\"Node\">{}</Attribute></Grid>\n",
                 model.pieces, frame_item("/poses/translation", 8, frame, frames, 0, model.pieces, model.pieces, 3),
                 frame_item("/poses/rotation", 8, frame, frames, 0, model.pieces, model.pieces, 9));
}

/// A frame of a surface that changes: rows of its lists of triangles and of vertices.
void changing(std::string& out, const XdmfModel::Item& b, const XdmfFrames::Rows& r, std::size_t i) {
  const auto count = [&](const std::vector<std::int64_t>& offset) { return offset[i + 1] - offset[i]; };
  const auto rows = [&](const char* list, const char* column, const std::vector<std::int64_t>& offset,
                        std::int64_t all) {
    return fmt::format("Format=\"HDF\">run.h5:/display/{}/{}/{}|{} 0:1 1:{} 3:{} 3</DataItem>", b.index, list, column,
                       offset[i], count(offset), all);
  };
  fmt::format_to(std::back_inserter(out),
                 "<Topology TopologyType=\"Triangle\" NumberOfElements=\"{0}\"><DataItem Dimensions=\"{0} 3\" "
                 "NumberType=\"Int\" Precision=\"4\" {1}</Topology><Geometry GeometryType=\"XYZ\"><DataItem "
                 "Dimensions=\"{2} 3\" NumberType=\"Float\" Precision=\"4\" {3}</Geometry>",
                 count(r.cells), rows("triangles", "corner", r.cells, r.all_cells), count(r.vertices),
                 rows("vertices", "position", r.vertices, r.all_vertices));
}

/// False in frames in which there is nothing to show: readers do not take empty grids.
bool shown(const XdmfModel::Item& b, const XdmfFrames::Rows& r, std::size_t i) {
  return b.changing ? r.cells[i + 1] > r.cells[i] : b.vertices > 0;
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

std::string xdmf_head() {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n"
         "<Grid Name=\"run\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
}

std::string xdmf_frames(const XdmfModel& model, const XdmfFrames& frames) {
  std::string out;
  for (std::size_t i = 0; i < frames.times.size(); ++i) {
    const std::size_t f = frames.first + i;
    fmt::format_to(std::back_inserter(out),
                   "<Grid Name=\"frame {}\" GridType=\"Collection\" CollectionType=\"Spatial\"><Time Value=\"{}\"/>\n",
                   f, frames.times[i]);
    for (std::size_t item = 0; item < model.bodies.size(); ++item) {
      const XdmfModel::Item& b = model.bodies[item];
      const XdmfFrames::Rows& rows = frames.rows[item];
      if (!shown(b, rows, i)) continue;
      out += "<Grid Name=\"" + xml_escaped(b.name) + "\">";
      if (b.changing) {
        changing(out, b, rows, i);
      } else {
        topology(out, model, b);
        out += "<Geometry GeometryType=\"XYZ\">" +
               frame_item("/display/positions", 4, f, frames.all, b.first_vertex, b.vertices, model.positions, 3) +
               "</Geometry>";
      }
      out += "</Grid>\n";
    }
    if (model.pieces > 0) poses(out, model, f, frames.all);
    out += "</Grid>\n";
  }
  return out;
}

std::string xdmf_tail() { return "</Grid>\n</Domain>\n</Xdmf>\n"; }

}  // namespace brim
