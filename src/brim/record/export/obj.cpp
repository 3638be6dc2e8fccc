#include <fmt/format.h>

#include <iterator>

#include "brim/record/export/format.h"
#include "brim/record/export/output_file.h"

namespace brim::exporting {

namespace {

/// Wavefront OBJ: frame_00012.obj holds every body as an object, triangles as f, lines as l, points as p. Every l has
/// two vertices, since not every reader takes more (Blender 3.4 keeps the first two).
/// The format has no numbers at vertices: velocities, radii and contacts are left out.
class ObjWriter : public Writer {
 public:
  explicit ObjWriter(const Job& job) : job_(job) {}

  void frame(const Frame& frame) override {
    OutputFile file(job_.folder / numbered("frame", frame.index, "obj"));
    std::string text = fmt::format("# brim: {} s; metres, z up\n", frame.time);
    std::size_t first = 1;  // vertices count from 1 through the whole file
    for (std::size_t i = 0; i < job_.items.size(); ++i) {
      if (frame.positions[i].empty()) continue;  // a fluid without surface, a body that was removed
      body(i, frame, first, text);
      first += frame.positions[i].size();
      file.write(text);
      text.clear();
    }
    file.close();
  }
  ItemPlace place(const Item& item) const override { return {.file = pattern("frame", "obj"), .path = item.file_name}; }

 private:
  void body(std::size_t i, const Frame& frame, std::size_t first, std::string& text) const {
    const Display& display = job_.items[i].recorded->display;
    const std::vector<Vec3f>& x = frame.positions[i];
    const auto to = std::back_inserter(text);
    fmt::format_to(to, "o {}\n", job_.items[i].file_name);
    for (const Vec3f& p : x) fmt::format_to(to, "v {} {} {}\n", p.x(), p.y(), p.z());
    const auto at = [first](std::int32_t v) { return first + static_cast<std::size_t>(v); };
    for (const Triangle& t : frame.triangles[i]) fmt::format_to(to, "f {} {} {}\n", at(t[0]), at(t[1]), at(t[2]));
    for (const Line& line : frame.lines[i]) fmt::format_to(to, "l {} {}\n", at(line[0]), at(line[1]));
    if (display.kind != Display::Kind::Points) return;
    for (std::size_t v = 0; v < x.size(); ++v) fmt::format_to(to, "p {}\n", first + v);
  }

  const Job& job_;
};

}  // namespace

std::unique_ptr<Writer> make_obj(const Job& job) { return std::make_unique<ObjWriter>(job); }

}  // namespace brim::exporting
