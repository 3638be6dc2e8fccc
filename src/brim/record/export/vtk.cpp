#include <fmt/format.h>

#include <map>
#include <optional>

#include "brim/record/export/format.h"
#include "brim/record/export/output_file.h"
#include "brim/record/export/stress_grid.h"
#include "brim/record/export/vtk_file.h"
#include "brim/record/xdmf.h"

namespace brim::exporting {

namespace {

std::string piece_head(std::size_t points, std::size_t verts, std::size_t lines, std::size_t polys) {
  return fmt::format(
      "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" "
      "NumberOfPolys=\"{}\">\n",
      points, verts, lines, polys);
}

/// VTK XML: body_00012.vtp per body and frame (one file for a body that never moves), contacts_00012.vtp per frame,
/// and run.pvd, which strings them together over time. With stress, elastic solids are body_00012.vtu instead, their
/// elements.
class VtkWriter : public Writer {
 public:
  VtkWriter(const Job& job, bool stress) : job_(job), stress_(stress) {}

  void frame(const Frame& frame) override {
    const World* world = stress_ ? &job_.world_at(frame.index) : nullptr;
    for (std::size_t i = 0; i < job_.items.size(); ++i) {
      const Item& item = job_.items[i];
      const StressedSolid* solid = world ? dynamic_cast<const StressedSolid*>(&world->body(item.body)) : nullptr;
      if (frame.order == 0) ends_[item.body] = solid ? "vtu" : "vtp";
      const std::string end = ends_.at(item.body);
      const std::string name = item.still ? item.file_name + "." + end : numbered(item.file_name, frame.index, end);
      if (!item.still || frame.order == 0) {
        if (solid)
          elements(*solid, world->v(item.body), frame, i, name);
        else
          body(item, frame, i, name);
      }
      list(frame.time, i, item.name, name);
    }
    const std::string name = numbered("contacts", frame.index, "vtp");
    contacts(frame, name);
    list(frame.time, job_.items.size(), "contacts", name);
  }

  ItemPlace place(const Item& item) const override {
    const std::string end = ends_.at(item.body);
    return {.file = item.still ? item.file_name + "." + end : pattern(item.file_name, end)};
  }
  ItemPlace contacts_place() const override { return {.file = pattern("contacts", "vtp")}; }

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

  void body(const Item& item, const Frame& frame, std::size_t i, const std::string& name) const {
    const Display& d = item.recorded->display;
    const std::vector<Vec3f>&x = frame.positions[i], &v = frame.velocities[i];
    const std::vector<Triangle>& triangles = frame.triangles[i];
    const std::vector<Line>& lines = frame.lines[i];
    const std::size_t verts = d.kind == Display::Kind::Points ? x.size() : 0;
    VtkFile file;
    std::string piece = piece_head(x.size(), verts, lines.size(), triangles.size());
    piece += "<PointData>\n";
    if (item.velocity != VelocitySource::None) piece += file.vectors("velocity", v);
    if (d.kind != Display::Kind::Triangles && d.radius > 0.0)
      piece += file.array("Float32", "radius", 1, std::vector<float>(x.size(), static_cast<float>(d.radius)));
    piece += "</PointData>\n<Points>\n" + file.vectors("points", x) + "</Points>\n";
    piece += file.cells("Verts", each(verts), 1) + file.cells("Lines", flat_cells(lines), 2) +
             file.cells("Polys", flat_cells(triangles), 3) + "</Piece>\n";
    file.write(job_.folder / name, "PolyData", piece, frame.time);
  }

  void elements(const StressedSolid& solid, std::span<const double> v, const Frame& frame, std::size_t i,
                const std::string& name) const {
    StressField field = solid.stress_field();
    const bool samples = field.tets.empty();
    const bool nodal = !samples && v.size() == 3 * field.place.size(), gone = frame.gone[i] != 0;
    if (gone) field = {};
    VtkFile file;
    std::optional<std::span<const double>> velocities;
    if (nodal) velocities = gone ? std::span<const double>() : v;
    const std::string piece = stress_piece(field, samples, velocities, file);
    file.write(job_.folder / name, "UnstructuredGrid", piece, frame.time);
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
    VtkFile file;
    std::string piece = piece_head(n, n, 0, 0) + "<PointData Vectors=\"force\">\n";
    piece += file.vectors("force", force) + file.vectors("friction", friction) +
             file.array("Float32", "overlap", 1, overlap) + file.array("Int32", "parts", 2, parts);
    piece += "</PointData>\n<Points>\n" + file.vectors("points", x) + "</Points>\n";
    piece += file.cells("Verts", each(n), 1) + "</Piece>\n";
    file.write(job_.folder / name, "PolyData", piece, frame.time);
  }

  const Job& job_;
  bool stress_;
  std::map<int, std::string> ends_;  ///< of the files of each body
  std::string collection_;
};

}  // namespace

std::unique_ptr<Writer> make_vtk(const Job& job) { return std::make_unique<VtkWriter>(job, false); }

std::unique_ptr<Writer> make_vtu(const Job& job) { return std::make_unique<VtkWriter>(job, true); }

}  // namespace brim::exporting
