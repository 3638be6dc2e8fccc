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
      if (b.vertices == 0) continue;
      out += "<Grid Name=\"" + xml_escaped(b.name) + "\">";
      topology(out, b);
      geometry(out, b, f, times.size());
      out += "</Grid>\n";
    }
    out += "</Grid>\n";
  }
  out += "</Grid>\n</Domain>\n</Xdmf>\n";
  return out;
}

}  // namespace brim
