#include <fmt/format.h>

#include <numeric>

#include "brim/record/export/format.h"
#include "brim/record/export/output_file.h"
#include "brim/record/h5.h"
#include "brim/record/xdmf.h"

namespace brim::exporting {

namespace {

using h5::Type;

/// XDMF 3: run.xdmf describes, run.h5 holds: /cells/<body>, /frames/<f>/<body>/{positions, velocity} and
/// /frames/<f>/contacts/{position, force, friction, overlap, parts}. One grid per body and one of contacts in each
/// frame. Unlike the run's own run.xdmf it stands alone, and every data set is read as a whole.
class XdmfWriter : public Writer {
 public:
  explicit XdmfWriter(const Job& job) : job_(job), data_((job.folder / "run.h5").string(), h5::File::Mode::Create) {
    data_.group("/cells");
    data_.group("/frames");
    for (std::size_t i = 0; i < job.items.size(); ++i) {
      const Display& d = job.items[i].recorded->display;
      if (!d.triangles.empty())
        data_.write(cells_of(i), Type::Int32, std::vector<std::uint64_t>{d.triangles.size(), 3}, d.triangles.data());
      if (!d.lines.empty())
        data_.write(cells_of(i), Type::Int32, std::vector<std::uint64_t>{d.lines.size(), 2}, d.lines.data());
    }
  }

  void frame(const Frame& frame) override {
    text_ +=
        fmt::format("<Grid Name=\"frame {}\" GridType=\"Collection\" CollectionType=\"Spatial\"><Time Value=\"{}\"/>\n",
                    frame.index, frame.time);
    for (std::size_t i = 0; i < job_.items.size(); ++i) body(frame, i);
    contacts(frame);
    text_ += "</Grid>\n";
  }

  ItemPlace place(const Item& item) const override { return {.file = "run.xdmf", .path = item.name}; }
  ItemPlace contacts_place() const override { return {.file = "run.xdmf", .path = "contacts"}; }

  void finish() override {
    data_.flush();
    OutputFile file(job_.folder / "run.xdmf");
    file.write("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n");
    file.write("<Grid Name=\"run\" GridType=\"Collection\" CollectionType=\"Temporal\">\n");
    file.write(text_ + "</Grid>\n</Domain>\n</Xdmf>\n");
    file.close();
  }

 private:
  static std::string cells_of(std::size_t i) { return "/cells/" + std::to_string(i); }

  /// Writes a data set and returns the tag that points to it.
  template <class T>
  std::string put(const std::string& path, Type type, std::size_t rows, std::size_t columns, const T* data) {
    const std::vector<std::uint64_t> shape =
        columns == 1 ? std::vector<std::uint64_t>{rows} : std::vector<std::uint64_t>{rows, columns};
    data_.write(path, type, shape, data);
    return item(path, type, rows, columns);
  }
  static std::string item(const std::string& path, Type type, std::size_t rows, std::size_t columns) {
    return fmt::format(
        "<DataItem Dimensions=\"{}{}\" NumberType=\"{}\" Precision=\"4\" Format=\"HDF\">run.h5:{}</DataItem>", rows,
        columns == 1 ? "" : fmt::format(" {}", columns), type == Type::Int32 ? "Int" : "Float", path);
  }
  static std::string attribute(const char* name, const char* type, const std::string& data) {
    return fmt::format("<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">{}</Attribute>\n", name, type,
                       data);
  }

  /// Every vertex as a cell. Its number alone would do for the format, but not for every reader.
  std::string points(std::size_t n, const std::string& path, bool fresh) {
    if (fresh) {
      std::vector<std::int32_t> index(n);
      std::iota(index.begin(), index.end(), 0);
      data_.write(path, Type::Int32, std::vector<std::uint64_t>{n, 1}, index.data());
    }
    return fmt::format(
        "<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{0}\" NodesPerElement=\"1\"><DataItem "
        "Dimensions=\"{0} 1\" NumberType=\"Int\" Precision=\"4\" Format=\"HDF\">run.h5:{1}</DataItem></Topology>\n",
        n, path);
  }

  void body(const Frame& frame, std::size_t i) {
    const Item& body = job_.items[i];
    const Display& d = body.recorded->display;
    const std::size_t vertices = frame.positions[i].size();
    if (vertices == 0) return;
    text_ += "<Grid Name=\"" + xml_escaped(body.name) + "\">\n";
    const bool lines = d.kind == Display::Kind::Lines;
    if (d.kind == Display::Kind::Points)
      text_ += points(vertices, cells_of(i), !data_.exists(cells_of(i)));
    else if (body.recorded->changing) {
      const std::size_t n = frame.triangles[i].size();
      const std::string at = fmt::format("/frames/{}/{}", frame.index, i);
      data_.group(at);
      text_ += fmt::format("<Topology TopologyType=\"Triangle\" NumberOfElements=\"{}\">{}</Topology>\n", n,
                           put(at + "/triangles", Type::Int32, n, 3, frame.triangles[i].front().data()));
    } else {
      const std::size_t n = lines ? d.lines.size() : d.triangles.size();
      text_ += fmt::format("<Topology TopologyType=\"{}\" NumberOfElements=\"{}\"{}>{}</Topology>\n",
                           lines ? "Polyline" : "Triangle", n, lines ? " NodesPerElement=\"2\"" : "",
                           item(cells_of(i), Type::Int32, n, lines ? 2 : 3));
    }
    const std::string at = fmt::format("/frames/{}/{}", body.still ? job_.frames.first : frame.index, i);
    const bool moving = body.velocity != VelocitySource::None;
    if (!body.still || !data_.exists(at)) {
      data_.group(at);
      put(at + "/positions", Type::Float32, vertices, 3, frame.positions[i].data());
      if (moving) put(at + "/velocity", Type::Float32, vertices, 3, frame.velocities[i].data());
    }
    text_ += "<Geometry GeometryType=\"XYZ\">" + item(at + "/positions", Type::Float32, vertices, 3) + "</Geometry>\n";
    if (moving) text_ += attribute("velocity", "Vector", item(at + "/velocity", Type::Float32, vertices, 3));
    text_ += "</Grid>\n";
  }

  void contacts(const Frame& frame) {
    const std::size_t n = frame.contacts.size();
    if (n == 0) return;  // readers do not take empty grids
    std::vector<Vec3f> x(n), force(n), friction(n);
    std::vector<float> overlap(n);
    std::vector<std::int32_t> a(n), b(n);
    for (std::size_t i = 0; i < n; ++i) {
      const ContactSample& c = frame.contacts[i];
      x[i] = c.position, force[i] = c.force, friction[i] = c.friction, overlap[i] = c.overlap;
      a[i] = c.part_a, b[i] = c.part_b;
    }
    const std::string at = fmt::format("/frames/{}/contacts", frame.index);
    data_.group(at);
    text_ += "<Grid Name=\"contacts\">\n" + points(n, at + "/cells", true);
    text_ += "<Geometry GeometryType=\"XYZ\">" + put(at + "/position", Type::Float32, n, 3, x.data()) + "</Geometry>\n";
    text_ += attribute("force", "Vector", put(at + "/force", Type::Float32, n, 3, force.data()));
    text_ += attribute("friction", "Vector", put(at + "/friction", Type::Float32, n, 3, friction.data()));
    text_ += attribute("overlap", "Scalar", put(at + "/overlap", Type::Float32, n, 1, overlap.data()));
    text_ += attribute("part_a", "Scalar", put(at + "/part_a", Type::Int32, n, 1, a.data()));
    text_ += attribute("part_b", "Scalar", put(at + "/part_b", Type::Int32, n, 1, b.data()));
    text_ += "</Grid>\n";
  }

  const Job& job_;
  h5::File data_;
  std::string text_;
};

}  // namespace

std::unique_ptr<Writer> make_xdmf(const Job& job) { return std::make_unique<XdmfWriter>(job); }

}  // namespace brim::exporting
