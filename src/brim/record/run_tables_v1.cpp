#include "brim/record/run_layout.h"
#include "brim/record/run_tables.h"
#include "brim/record/table_columns.h"

namespace brim {

using h5::Type;

RunTables read_tables_v1(const h5::File& file) {
  constexpr std::int64_t kMost = std::int64_t{1} << 40;
  RunTables t;
  for (int b = 0;; ++b) {
    const std::string at = "/bodies/" + std::to_string(b);
    if (!file.exists(at)) break;
    const auto whole = [&](const char* name, std::int64_t most) {
      return static_cast<std::size_t>(file.whole(at, name, 0, most));
    };
    RecordedBody body;
    body.name = file.text(at, "name");
    body.kind = file.text(at, "kind");
    body.display.kind = run_layout::display_kind(file.text(at, "display_kind"), file.path());
    body.display.two_sided = whole("two_sided", 1) != 0;
    body.display.radius = file.number(at, "radius");
    body.display.vertices = whole("vertices", kMost);
    body.immobile = whole("immobile", 1) != 0;
    body.changing = file.has_attribute(at, "changing") && whole("changing", 1) != 0;
    body.mass = file.number(at, "mass");
    body.q_offset = whole("q_offset", kMost);
    body.q_size = whole("q_size", kMost);
    body.v_offset = whole("v_offset", kMost);
    body.v_size = whole("v_size", kMost);
    body.parts = static_cast<int>(whole("parts", run_layout::kMostParts));
    if (body.display.kind == Display::Kind::Triangles && !body.changing)
      body.display.triangles = read_column<Triangle>(file, at + "/triangles", Type::Int32, 3);
    else if (body.display.kind == Display::Kind::Lines)
      body.display.lines = read_column<std::array<std::int32_t, 2>>(file, at + "/lines", Type::Int32, 2);
    check_indices<3>(file, body.display.triangles, body.display.vertices, at + "/triangles");
    check_indices<2>(file, body.display.lines, body.display.vertices, at + "/lines");
    t.bodies.push_back(std::move(body));
  }
  for (int p = 0;; ++p) {
    const std::string at = "/parts/" + std::to_string(p);
    if (!file.exists(at)) break;
    t.parts.push_back({file.text(at, "name"), file.text(at, "material"),
                       static_cast<int>(file.whole(at, "body", 0, static_cast<std::int64_t>(t.bodies.size()) - 1)),
                       static_cast<int>(file.whole(at, "part", 0, run_layout::kMostParts)),
                       file.number(at, "voxel_size")});
  }
  return t;
}

}  // namespace brim
