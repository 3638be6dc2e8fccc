#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "brim/record/h5.h"
#include "brim/record/run_layout.h"
#include "brim/record/run_reader.h"
#include "brim/world/report_fields.h"

namespace brim::testing {

/// Writes a run as version 1 of the format has it (docs/formats.md, "Version 1"), without changing surfaces.
inline void write_version_1(const std::string& from, const std::string& to) {
  using h5::Type;
  using Row = std::vector<std::uint64_t>;
  namespace fs = std::filesystem;
  fs::create_directories(to);
  fs::copy(fs::path(from) / "scene.json", fs::path(to) / "scene.json");
  const RunReader run(from);
  h5::File file((fs::path(to) / "run.h5").string(), h5::File::Mode::Create);
  file.attribute("/", "format", std::string("brim-run"));
  file.attribute("/", "version", std::int64_t{1});
  file.attribute("/", "brim_version", run.brim_version());
  file.attribute("/", "scene", run.scene_name());
  file.attribute("/", "scene_path", run.scene_path());
  file.attribute("/", "frame_time", run.frame_time());
  file.attribute("/", "steps_per_frame", std::int64_t{run.steps_per_frame()});
  const auto frames = run.frames();
  const auto grow = [&](const std::string& path, Type type, const Row& row) {
    file.group(path.substr(0, path.rfind('/')));
    return file.growing(path, type, row, 4, 0);
  };
  for (std::size_t b = 0; b < run.bodies().size(); ++b) {
    const RecordedBody& body = run.bodies()[b];
    const std::string at = "/bodies/" + std::to_string(b);
    file.group(at);
    file.attribute(at, "name", body.name);
    file.attribute(at, "kind", body.kind);
    file.attribute(at, "display_kind", std::string(run_layout::display_word(body.display.kind)));
    file.attribute(at, "two_sided", std::int64_t{body.display.two_sided});
    file.attribute(at, "radius", body.display.radius);
    file.attribute(at, "immobile", std::int64_t{body.immobile});
    file.attribute(at, "mass", body.mass);
    for (const auto& [name, value] :
         {std::pair("vertices", body.display.vertices), std::pair("q_offset", body.q_offset),
          std::pair("q_size", body.q_size), std::pair("v_offset", body.v_offset), std::pair("v_size", body.v_size),
          std::pair("parts", std::size_t(body.parts))})
      file.attribute(at, name, static_cast<std::int64_t>(value));
    if (body.display.kind == Display::Kind::Triangles)
      file.write(at + "/triangles", Type::Int32, Row{body.display.triangles.size(), 3}, body.display.triangles.data());
    if (body.display.kind == Display::Kind::Lines)
      file.write(at + "/lines", Type::Int32, Row{body.display.lines.size(), 2}, body.display.lines.data());
    h5::Dataset positions = grow(fmt::format("/display/{}/positions", b), Type::Float32, {body.display.vertices, 3});
    for (std::int64_t f = 0; f < (run.still(static_cast<int>(b)) ? 1 : frames); ++f)
      positions.append(run.positions(static_cast<int>(b), f).data(), 1, Type::Float32);
  }
  for (std::size_t p = 0; p < run.parts().size(); ++p) {
    const RecordedPart& part = run.parts()[p];
    const std::string at = "/parts/" + std::to_string(p);
    file.group(at);
    file.attribute(at, "name", part.name);
    file.attribute(at, "material", part.material);
    file.attribute(at, "body", std::int64_t{part.body});
    file.attribute(at, "part", std::int64_t{part.part});
    file.attribute(at, "voxel_size", part.voxel_size);
  }
  // What each frame has is laid out as today: it is copied data set by data set.
  const h5::File source(run.path(), h5::File::Mode::Read);
  for (const std::string& path : source.datasets()) {
    if (path == "/frames/count") continue;
    bool framed = false;
    for (const char* group :
         {"/frames/", "/series/", "/motion/", "/contacts/", "/tiles/", "/pairs/", "/memory/", "/warnings/"})
      framed = framed || path.starts_with(group);
    if (!framed) continue;
    const h5::Dataset set = source.open(path);
    const std::vector<std::uint64_t> shape = set.shape();
    h5::Dataset copy = grow(path, set.type(), Row(shape.begin() + 1, shape.end()));
    std::uint64_t elements = 1;
    for (const std::uint64_t n : shape) elements *= n;
    std::vector<double> room(elements);  // every type fits
    if (elements > 0) set.read(room.data(), elements, 0, shape[0], set.type());
    copy.append(room.data(), shape[0], set.type());
  }
  file.flush();
}

}  // namespace brim::testing
