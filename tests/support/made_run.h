#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "brim/record/h5.h"
#include "brim/world/report_fields.h"

/// A small recorded run with every kind of display, written by hand as docs/formats.md describes it.
namespace brim::testing {

/// Bodies: 0 "floor" (two triangles, never moves), 1 "ball" and 2 "ball.1" (tetrahedra; the first turns and rises, the
/// second stretches), 3 "rod" (four vertices, three lines), 4 "grains" (five points with velocities). Frame f has
/// contacts f - 1 of them, up to two: ball on floor, grains on floor.
struct MadeRun {
  std::filesystem::path path;  ///< holds the run in "run"; removed at the end
  std::string folder() const { return (path / "run").string(); }

  static Vec3f corner(int i) {
    static const Vec3f kCorners[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    return kCorners[i];
  }
  /// Where a vertex is: the formula that readers are held to.
  static Vec3f at(int body, int vertex, int frame) {
    const float t = 0.1f * static_cast<float>(frame);
    switch (body) {
      case 0:
        return {vertex % 2 ? 5.0f : -5.0f, vertex / 2 ? 5.0f : -5.0f, 0.0f};
      case 1: {
        const Vec3f p = corner(vertex);
        return Vec3f(std::cos(t) * p.x() - std::sin(t) * p.y() + t, std::sin(t) * p.x() + std::cos(t) * p.y(),
                     p.z() + 2 * t);
      }
      case 2:
        return Vec3f(corner(vertex).x() * (1 + t) + 3, corner(vertex).y(), corner(vertex).z());
      case 3:
        return {0.5f * static_cast<float>(vertex), -2.0f, t * static_cast<float>(vertex)};
      default:
        return {0.25f * static_cast<float>(vertex), 2.0f, t};
    }
  }
  static int vertices(int body) { return body == 4 ? 5 : 4; }

  explicit MadeRun(int frames) {
    path = std::filesystem::temp_directory_path() / ("brim_made_run_" + std::to_string(std::random_device{}()));
    std::filesystem::create_directories(path / "run");
    h5::File file((path / "run/run.h5").string(), h5::File::Mode::Create);
    describe(file);
    write_frames(file, frames);
    file.flush();
  }
  ~MadeRun() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  MadeRun(const MadeRun&) = delete;
  MadeRun& operator=(const MadeRun&) = delete;

 private:
  static void describe(h5::File& file) {
    using h5::Type;
    file.attribute("/", "format", std::string("brim-run"));
    file.attribute("/", "version", std::int64_t{1});
    file.attribute("/", "brim_version", std::string("0.1.0"));
    file.attribute("/", "scene", std::string("made \"by\" hand"));
    file.attribute("/", "frame_time", 0.1);
    file.attribute("/", "steps_per_frame", std::int64_t{1});
    for (const char* g : {"/bodies", "/parts", "/frames", "/display", "/series", "/contacts", "/tiles", "/pairs",
                          "/memory", "/warnings"})
      file.group(g);
    const char* const names[] = {"floor", "ball", "ball.1", "rod", "grains"};
    const char* const displays[] = {"triangles", "triangles", "triangles", "lines", "points"};
    for (int b = 0; b < 5; ++b) {
      const std::string at = "/bodies/" + std::to_string(b), part = "/parts/" + std::to_string(b);
      file.group(at);
      file.attribute(at, "name", std::string(names[b]));
      file.attribute(at, "kind", std::string("made"));
      file.attribute(at, "display_kind", std::string(displays[b]));
      for (const char* zero : {"two_sided", "q_offset", "v_offset"}) file.attribute(at, zero, std::int64_t{0});
      for (const char* size : {"q_size", "v_size"}) file.attribute(at, size, std::int64_t{b == 4 ? 15 : 0});
      file.attribute(at, "radius", b >= 3 ? 0.125 : 0.0);
      file.attribute(at, "vertices", std::int64_t{vertices(b)});
      file.attribute(at, "immobile", std::int64_t{b == 0});
      file.attribute(at, "mass", 1.0);
      file.attribute(at, "parts", std::int64_t{1});
      file.group(part);
      file.attribute(part, "name", std::string(names[b]));
      file.attribute(part, "material", std::string("m"));
      file.attribute(part, "body", std::int64_t{b});
      file.attribute(part, "part", std::int64_t{0});
      file.attribute(part, "voxel_size", 0.1);
      file.group("/display/" + std::to_string(b));
    }
    const std::int32_t sheet[] = {0, 1, 3, 0, 3, 2}, solid[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3},
                       lines[] = {0, 1, 1, 2, 2, 3};
    file.write("/bodies/0/triangles", Type::Int32, std::vector<std::uint64_t>{2, 3}, sheet);
    file.write("/bodies/1/triangles", Type::Int32, std::vector<std::uint64_t>{4, 3}, solid);
    file.write("/bodies/2/triangles", Type::Int32, std::vector<std::uint64_t>{4, 3}, solid);
    file.write("/bodies/3/lines", Type::Int32, std::vector<std::uint64_t>{3, 2}, lines);
  }

  static void write_frames(h5::File& file, int frames) {
    using h5::Type;
    const auto grow = [&](const std::string& name, Type type, const std::vector<std::uint64_t>& row) {
      return file.growing(name, type, row, 4, 0);
    };
    auto time = grow("/frames/time", Type::Float64, {}), q = grow("/frames/q", Type::Float64, {15}),
         v = grow("/frames/v", Type::Float64, {15}), step = grow("/frames/step", Type::Int64, {});
    std::vector<h5::Dataset> display, series;
    for (int b = 0; b < 5; ++b)
      display.push_back(
          grow(fmt::format("/display/{}/positions", b), Type::Float32, {static_cast<std::uint64_t>(vertices(b)), 3}));
    for (const ReportField& f : report_fields())
      series.push_back(grow(std::string("/series/") + f.name, Type::Float64, {}));
    std::map<std::string, h5::Dataset> offset;
    const std::int64_t zero = 0;
    for (const char* g : {"/contacts", "/tiles", "/pairs", "/memory", "/warnings"})
      (offset[g] = grow(std::string(g) + "/offset", Type::Int64, {})).append(&zero, 1, Type::Int64);
    auto position = grow("/contacts/position", Type::Float32, {3}), force = grow("/contacts/force", Type::Float32, {3}),
         friction = grow("/contacts/friction", Type::Float32, {3}),
         overlap = grow("/contacts/overlap", Type::Float32, {}), pair = grow("/contacts/pair", Type::Int32, {2});
    grow("/memory/value", Type::Float64, {});
    std::int64_t rows = 0;
    for (int f = 0; f < frames; ++f) {
      const double t = 0.1 * f;
      const std::int64_t taken = f;
      time.append(&t, 1, Type::Float64);
      step.append(&taken, 1, Type::Int64);
      std::vector<double> place, speed;
      for (int b = 0; b < 5; ++b) {
        std::vector<float> x;
        for (int i = 0; i < vertices(b); ++i) {
          const Vec3f p = at(b, i, f);
          x.insert(x.end(), p.data(), p.data() + 3);
          if (b == 4) place.insert(place.end(), p.data(), p.data() + 3), speed.insert(speed.end(), {0, 0, 1});
        }
        if (b > 0 || f == 0) display[static_cast<std::size_t>(b)].append(x.data(), 1, Type::Float32);
      }
      q.append(place.data(), 1, Type::Float64);
      v.append(speed.data(), 1, Type::Float64);
      for (h5::Dataset& s : series) s.append(&t, 1, Type::Float64);
      for (int c = 0; c < std::min(f, 2); ++c) {
        const float x[] = {static_cast<float>(c), 0, 0}, push[] = {0, 0, -static_cast<float>(f)}, drag[] = {0.5f, 0, 0},
                    deep = 0.25f;
        const std::int32_t between[] = {0, c == 0 ? 1 : 4};
        position.append(x, 1, Type::Float32), force.append(push, 1, Type::Float32);
        friction.append(drag, 1, Type::Float32), overlap.append(&deep, 1, Type::Float32);
        pair.append(between, 1, Type::Int32);
        ++rows;
      }
      offset["/contacts"].append(&rows, 1, Type::Int64);
      for (const char* g : {"/tiles", "/pairs", "/memory", "/warnings"}) offset[g].append(&zero, 1, Type::Int64);
    }
  }
};

/// Runs a Python script with arguments. @return its exit code, or -1 when a module it needs is not installed
inline int run_python(const std::string& modules, const std::string& script, const std::string& arguments,
                      const std::filesystem::path& folder) {
  const char* const python = "/usr/bin/python3";  // the one for which Debian's packages are installed
  if (std::system(fmt::format("{} -c 'import {}' >/dev/null 2>&1", python, modules).c_str()) != 0) return -1;
  const std::filesystem::path file = folder / "check.py";
  std::ofstream(file) << script;
  const int status = std::system(fmt::format("{} '{}' {}", python, file.string(), arguments).c_str());
  return status == 0 ? 0 : 1;
}

}  // namespace brim::testing
