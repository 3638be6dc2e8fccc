#include <fmt/format.h>

#include "brim/record/export/format.h"
#include "brim/record/export/output_file.h"

namespace brim::exporting {

namespace {

/// Binary PLY: body_00012.ply per body and frame (one file for a body that never moves), contacts_00012.ply per frame.
/// Vertices carry vx vy vz where the run has velocities and pscale, the radius, where the body has one; lines are the
/// element edge. Contacts carry nx ny nz (direction of the force on the first part), force, friction, overlap, part.
class PlyWriter : public Writer {
 public:
  explicit PlyWriter(const Job& job) : job_(job) {}

  void frame(const Frame& frame) override {
    for (std::size_t i = 0; i < job_.items.size(); ++i) {
      const Item& item = job_.items[i];
      if (item.still && frame.order > 0) continue;
      body(item, frame, i, item.still ? item.file_name + ".ply" : numbered(item.file_name, frame.index, "ply"));
    }
    contacts(frame);
  }
  ItemPlace place(const Item& item) const override {
    return {.file = item.still ? item.file_name + ".ply" : pattern(item.file_name, "ply")};
  }
  ItemPlace contacts_place() const override { return {.file = pattern("contacts", "ply")}; }

 private:
  void body(const Item& item, const Frame& frame, std::size_t i, const std::string& name) const {
    const Display& d = item.recorded->display;
    const std::vector<Vec3f>&x = frame.positions[i], &v = frame.velocities[i];
    const std::vector<Triangle>& triangles = frame.triangles[i];
    const std::vector<Line>& lines = frame.lines[i];
    const bool sized = d.kind != Display::Kind::Triangles && d.radius > 0.0;
    std::string head = "ply\nformat binary_little_endian 1.0\ncomment brim: " + item.identifier + "; metres, z up\n";
    head += fmt::format("element vertex {}\nproperty float x\nproperty float y\nproperty float z\n", x.size());
    const bool moving = item.velocity != VelocitySource::None;
    if (moving) head += "property float vx\nproperty float vy\nproperty float vz\n";
    if (sized) head += "property float pscale\n";
    if (!triangles.empty())
      head += fmt::format("element face {}\nproperty list uchar int vertex_indices\n", triangles.size());
    if (!lines.empty())
      head += fmt::format("element edge {}\nproperty int vertex1\nproperty int vertex2\n", lines.size());
    OutputFile file(job_.folder / name);
    file.write(head + "end_header\n");
    for (std::size_t n = 0; n < x.size(); ++n) {
      file.write(x[n].data(), sizeof(Vec3f));
      if (moving) file.write(v[n].data(), sizeof(Vec3f));
      if (sized) file.write_number(static_cast<float>(d.radius));
    }
    for (const Triangle& t : triangles) {
      file.write_number(std::uint8_t{3});
      file.write(t.data(), sizeof t);
    }
    file.write_array(std::span(lines));
    file.close();
  }

  void contacts(const Frame& frame) const {
    std::string head = "ply\nformat binary_little_endian 1.0\ncomment brim: contacts; newtons on part_a\n";
    head += fmt::format("element vertex {}\n", frame.contacts.size());
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "force_x", "force_y", "force_z", "friction_x",
                             "friction_y", "friction_z", "overlap"})
      head += fmt::format("property float {}\n", name);
    OutputFile file(job_.folder / numbered("contacts", frame.index, "ply"));
    file.write(head + "property int part_a\nproperty int part_b\nend_header\n");
    for (const ContactSample& c : frame.contacts) {
      const float size = c.force.norm();
      const Vec3f normal = size > 0.0f ? Vec3f(c.force / size) : Vec3f(0, 0, 0);
      for (const Vec3f* p : {&c.position, &normal, &c.force, &c.friction}) file.write(p->data(), sizeof(Vec3f));
      file.write_number(c.overlap);
      file.write_number(c.part_a);
      file.write_number(c.part_b);
    }
    file.close();
  }

  const Job& job_;
};

}  // namespace

std::unique_ptr<Writer> make_ply(const Job& job) { return std::make_unique<PlyWriter>(job); }

}  // namespace brim::exporting
