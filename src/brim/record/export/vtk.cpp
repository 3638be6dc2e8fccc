#include <fmt/format.h>

#include <numeric>

#include "brim/record/export/format.h"
#include "brim/record/export/output_file.h"
#include "brim/record/xdmf.h"

namespace brim::exporting {

namespace {

/// Builds one PolyData file (.vtp): numbers are appended raw behind the XML.
class PolyData {
 public:
  template <class T>
  std::string array(const char* type, const char* name, int components, const std::vector<T>& values) {
    const std::string tag =
        fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>",
                    type, name, components, data_.size());
    const std::uint64_t bytes = values.size() * sizeof(T);
    data_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    data_.append(reinterpret_cast<const char*>(values.data()), bytes);
    return tag + "\n";
  }
  /// Cells of one size. @param corners  vertex indices, shape (cells, size)
  std::string cells(const char* tag, const std::vector<std::int32_t>& corners, int size) {
    std::vector<std::int32_t> ends(corners.size() / static_cast<std::size_t>(size));
    for (std::size_t c = 0; c < ends.size(); ++c) ends[c] = static_cast<std::int32_t>(c + 1) * size;
    return fmt::format("<{}>\n{}{}</{}>\n", tag, array("Int32", "connectivity", 1, corners),
                       array("Int32", "offsets", 1, ends), tag);
  }
  void write(const std::filesystem::path& path, const std::string& piece, double time) {
    OutputFile file(path);
    file.write(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n");
    file.write(
        fmt::format("<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{}"
                    "</DataArray>\n</FieldData>\n",
                    time));
    file.write(piece + "</PolyData>\n<AppendedData encoding=\"raw\">\n_");
    file.write(data_);
    file.write("\n</AppendedData>\n</VTKFile>\n");
    file.close();
  }

 private:
  std::string data_;
};

std::vector<float> flat(const std::vector<Vec3f>& x) {
  std::vector<float> list(3 * x.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    for (int a = 0; a < 3; ++a) list[3 * i + static_cast<std::size_t>(a)] = x[i][a];
  return list;
}

template <class Cell>
std::vector<std::int32_t> flat_cells(const std::vector<Cell>& cells) {
  std::vector<std::int32_t> list;
  for (const Cell& c : cells) list.insert(list.end(), c.begin(), c.end());
  return list;
}

std::vector<std::int32_t> each(std::size_t n) {
  std::vector<std::int32_t> list(n);
  std::iota(list.begin(), list.end(), 0);
  return list;
}

std::string piece_head(std::size_t points, std::size_t verts, std::size_t lines, std::size_t polys) {
  return fmt::format(
      "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" "
      "NumberOfPolys=\"{}\">\n",
      points, verts, lines, polys);
}

/// VTK XML: body_00012.vtp per body and frame (one file for a body that never moves), contacts_00012.vtp per frame,
/// and run.pvd, which strings them together over time.
class VtkWriter : public Writer {
 public:
  explicit VtkWriter(const Job& job) : job_(job) {}

  void frame(const Frame& frame) override {
    for (std::size_t i = 0; i < job_.items.size(); ++i) {
      const Item& item = job_.items[i];
      const std::string name = item.still ? item.file_name + ".vtp" : numbered(item.file_name, frame.index, "vtp");
      if (!item.still || frame.order == 0)
        body(item, frame.positions[i], frame.triangles[i], frame.velocities[i], frame.time, name);
      list(frame.time, i, item.name, name);
    }
    const std::string name = numbered("contacts", frame.index, "vtp");
    contacts(frame, name);
    list(frame.time, job_.items.size(), "contacts", name);
  }

  void finish() override {
    OutputFile file(job_.folder / "run.pvd");
    file.write("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n");
    file.write("<Collection>\n" + collection_ + "</Collection>\n</VTKFile>\n");
    file.close();
  }

 private:
  void list(double time, std::size_t part, const std::string& title, const std::string& name) {
    collection_ += fmt::format("<DataSet timestep=\"{}\" group=\"\" part=\"{}\" name=\"{}\" file=\"{}\"/>\n", time,
                               part, xml_escaped(title), name);
  }

  void body(const Item& item, const std::vector<Vec3f>& x, const std::vector<Triangle>& triangles,
            const std::vector<Vec3f>& v, double time, const std::string& name) const {
    const Display& d = item.recorded->display;
    const std::size_t verts = d.kind == Display::Kind::Points ? x.size() : 0;
    PolyData file;
    std::string piece = piece_head(x.size(), verts, d.lines.size(), triangles.size());
    piece += "<PointData>\n";
    if (!v.empty()) piece += file.array("Float32", "velocity", 3, flat(v));
    if (d.kind != Display::Kind::Triangles && d.radius > 0.0)
      piece += file.array("Float32", "radius", 1, std::vector<float>(x.size(), static_cast<float>(d.radius)));
    piece += "</PointData>\n<Points>\n" + file.array("Float32", "points", 3, flat(x)) + "</Points>\n";
    piece += file.cells("Verts", each(verts), 1) + file.cells("Lines", flat_cells(d.lines), 2) +
             file.cells("Polys", flat_cells(triangles), 3) + "</Piece>\n";
    file.write(job_.folder / name, piece, time);
  }

  void contacts(const Frame& frame, const std::string& name) const {
    const std::size_t n = frame.contacts.size();
    std::vector<Vec3f> x(n), force(n), friction(n);
    std::vector<float> overlap(n);
    std::vector<std::int32_t> parts(2 * n);
    for (std::size_t i = 0; i < n; ++i) {
      const ContactSample& c = frame.contacts[i];
      x[i] = c.position, force[i] = c.force, friction[i] = c.friction, overlap[i] = c.overlap;
      parts[2 * i] = c.part_a, parts[2 * i + 1] = c.part_b;
    }
    PolyData file;
    std::string piece = piece_head(n, n, 0, 0) + "<PointData Vectors=\"force\">\n";
    piece += file.array("Float32", "force", 3, flat(force)) + file.array("Float32", "friction", 3, flat(friction)) +
             file.array("Float32", "overlap", 1, overlap) + file.array("Int32", "parts", 2, parts);
    piece += "</PointData>\n<Points>\n" + file.array("Float32", "points", 3, flat(x)) + "</Points>\n";
    piece += file.cells("Verts", each(n), 1) + "</Piece>\n";
    file.write(job_.folder / name, piece, frame.time);
  }

  const Job& job_;
  std::string collection_;
};

}  // namespace

std::unique_ptr<Writer> make_vtk(const Job& job) { return std::make_unique<VtkWriter>(job); }

}  // namespace brim::exporting
