#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <numbers>
#include <string_view>

#include "brim/body/changing_surface.h"
#include "brim/body/known_volume.h"
#include "brim/core/error.h"
#include "brim/core/printable.h"
#include "brim/io/surface_reader.h"
#include "brim/io/tet_reader.h"
#include "brim/io/volume_reader.h"
#include "brim/mesh/flat_surface.h"
#include "brim/mesh/tet_lattice.h"
#include "brim/mesh/topology.h"
#include "brim/record/run_reader.h"
#include "brim/scene/document.h"
#include "brim/scene/scene.h"
#include "commands.h"
#include "server/kept_scene.h"
#include "server/rebuilt_world.h"
#include "volume_picture.h"

namespace brim::cli {

namespace {

std::string vec_text(const Vec3& v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x(), v.y(), v.z()); }

std::string parameter_text(const Scene& scene) {
  std::string text;
  for (const auto& [name, value] : scene.document->parameters.items())
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", name, shown(value));
  return text;
}

/// Bodies with a line of their own.
constexpr int kMostBodies = 40;

/// A box around what is shown of a body, [m]; of a plane its display.
Aabb shown_box(const Body& body) {
  std::vector<Vec3f> x;
  display_now(body, x);
  Aabb box;
  for (const Vec3f& p : x) box.extend(p.cast<double>());
  return box;
}

/// ", 3.2 kg, 0.002 m³, 0.2 x 0.1 x 0.1 m, voxels of 0.01 m, 7 coordinates"
std::string size_text(const Body& body) {
  std::string text;
  if (!body.immobile()) text += fmt::format(", {:.4g} kg", body.mass());
  const auto* known = dynamic_cast<const KnownVolume*>(&body);
  if (known != nullptr && known->volume() > 0.0) text += fmt::format(", {:.4g} m³", known->volume());
  if (const Aabb box = shown_box(body); !box.empty())
    text += fmt::format(", {:.4g} x {:.4g} x {:.4g} m", box.extent().x(), box.extent().y(), box.extent().z());
  double finest = std::numeric_limits<double>::infinity();
  for (int p = 0; p < body.part_count(); ++p) finest = std::min(finest, body.part(p).voxel_size);
  if (finest > 0.0 && std::isfinite(finest)) text += fmt::format(", voxels of {:.4g} m", finest);
  if (body.q_size() > 0) text += fmt::format(", {} coordinates", body.q_size());
  return text;
}

/// True for two copies of a body that "repeat" makes, of which one line tells all.
bool alike(const Body& a, const Body& b) {
  const auto stem = [](std::string_view name) { return name.substr(0, name.rfind('.')); };
  return a.name() != stem(a.name()) && stem(a.name()) == stem(b.name()) && a.kind() == b.kind() &&
         a.q_size() == b.q_size() && std::abs(a.mass() - b.mass()) <= 1e-9 * std::abs(a.mass());
}

/// A line for each body: a slip of units shows in its size or mass.
void about_bodies(const World& world) {
  int lines = 0, last = 0;
  for (int b = 0; b < world.body_count(); b = last + 1) {
    const Body& body = world.body(b);
    for (last = b; last + 1 < world.body_count() && alike(body, world.body(last + 1));) ++last;
    if (++lines > kMostBodies) {
      fmt::print("    and {} more\n", world.body_count() - b);
      return;
    }
    const std::string copies = last > b ? fmt::format(" to {}", printable(world.body(last).name())) : "";
    fmt::print("    {}{}: {}{}\n", printable(body.name()), copies, printable(std::string(body.kind())),
               size_text(body));
  }
}

void about_scene(const std::string& path) {
  const Scene scene = load_scene(path);
  const World world = build_world(scene);
  fmt::print("{}: scene \"{}\"\n", path, scene.name);
  if (!scene.description.empty()) fmt::print("  {}\n", scene.description);
  std::map<std::string, int> kinds;
  for (int b = 0; b < world.body_count(); ++b) ++kinds[std::string(world.body(b).kind())];
  fmt::print("  {} bodies:", world.body_count());
  for (const auto& [kind, count] : kinds) fmt::print(" {} {}", count, printable(kind));
  fmt::print("\n");
  about_bodies(world);
  fmt::print("  {} coordinates, {} velocities\n", world.state().q.size(), world.state().v.size());
  fmt::print("  {} frames of {:.6g} s, {} steps of {:.6g} s each\n", scene.frames, scene.frame_time(),
             scene.steps_per_frame, scene.world.time_step);
  fmt::print("  {} expectations\n", scene.expect.size());
  if (!scene.document->parameters.empty()) fmt::print("  parameters, for --set: {}\n", parameter_text(scene));
}

void about_surface(const std::string& path) {
  const TriMesh mesh = read_surface(path);
  const MeshReport report = inspect(mesh);
  const Aabb box = bounds(mesh.vertices);
  fmt::print("{}: surface\n  {}\n  box {} to {} m\n", path, report.summary(), vec_text(box.lo), vec_text(box.hi));
  if (report.closed() && report.oriented()) fmt::print("  encloses {:.6g} m³\n", report.volume);
  if (!report.closed())
    fmt::print("  as a solid it needs treatment {}\n",
               is_flat(mesh) ? "\"thickness\", as it is flat" : "\"winding_number\" or \"thickness\"");
}

void about_tets(const std::string& path) {
  const TetMesh mesh = read_tets(path);
  const TetQuality q = tet_quality(mesh);
  const Aabb box = bounds(mesh.vertices);
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  fmt::print("{}: tetrahedra\n  {} tetrahedra, {} vertices\n  box {} to {} m, {:.6g} m³\n", path, mesh.tets.size(),
             mesh.vertices.size(), vec_text(box.lo), vec_text(box.hi), q.total_volume);
  fmt::print("  dihedral angles {:.1f} to {:.1f} degrees, quality {:.3f} least, {:.3f} mean\n",
             q.min_dihedral * kDegrees, q.max_dihedral * kDegrees, q.min_ratio, q.mean_ratio);
}

void about_volume(const std::string& path, const std::string& series, const std::string& sheet) {
  const VolumeInfo info = read_volume_info(path, {}, series);
  const VoxelImage image = read_volume(info);
  const Aabb box = image.box();
  const Vec3 step = info.steps();
  fmt::print("{}: {} volume\n  {} x {} x {} voxels of {:.6g} x {:.6g} x {:.6g} m{}\n  {}, {}-endian\n", path,
             info.format, info.size.x(), info.size.y(), info.size.z(), step.x(), step.y(), step.z(),
             info.unit_given ? "" : " (no unit in the file: millimetres taken)", voxel_word(info.type),
             info.big_endian ? "big" : "little");
  fmt::print("  box {} to {} m\n", vec_text(box.lo), vec_text(box.hi));
  const VolumeHistogram histogram(image.values);
  std::fputs(histogram.text().c_str(), stdout);
  if (sheet.empty()) return;
  write_contact_sheet(image, sheet);
  fmt::print("  slices along z are drawn in {}\n", sheet);
}

/// Why no program can build the run's world, where it keeps its scene.
std::string python_of(const RunReader& run) {
  try {
    return viewer::python_bodies(viewer::kept_scene(run));
  } catch (const InputError&) {
    return "";
  }
}

void about_run(const std::string& path) {
  const RunReader run(path);
  fmt::print("{}: run of scene \"{}\" by brim {}\n", path, run.scene_name(), run.brim_version());
  fmt::print("  {} frames of {:.6g} s", run.frames(), run.frame_time());
  if (run.frames() > 0) fmt::print(", to {:.6g} s", run.time(run.frames() - 1));
  std::map<std::string, int> kinds;
  for (const RecordedBody& b : run.bodies()) ++kinds[b.kind];
  fmt::print("\n  {} bodies:", run.bodies().size());
  for (const auto& [kind, count] : kinds) fmt::print(" {} {}", count, printable(kind));
  const auto largest = [&](const char* name) {
    const std::vector<double> x = run.series(name);
    return x.empty() ? 0.0 : *std::max_element(x.begin(), x.end());
  };
  const auto total = [&](const char* name) {
    double sum = 0.0;
    for (const double x : run.series(name)) sum += x;
    return sum;
  };
  fmt::print("\n");
  const std::vector<std::string> foreign = viewer::foreign_kinds(run);
  const std::string why = foreign.empty() ? "" : python_of(run);
  if (!why.empty()) fmt::print("  {}\n", printable(why));
  for (const std::string& kind : why.empty() ? foreign : std::vector<std::string>())
    fmt::print(
        "  \"{}\" is not a kind of brim's own: densities and --resume need its library, brim --plugin FILE ...\n",
        printable(kind));
  fmt::print("  {:.0f} steps in {:.1f} s, at most {:.0f} contacts, worst overlap {:.3g} voxels, {:.0f} warnings\n",
             total("steps"), total("wall"), largest("contacts"), largest("worst_overlap"), total("warnings"));
}

void about(const std::string& path, const std::string& series, const std::string& sheet) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!fs::exists(path, error)) throw InputError(path + ": no such file or folder");
  if (fs::is_directory(path, error) && (fs::exists(fs::path(path) / "run.h5", error) || !holds_dicom(path)))
    return about_run(path);
  std::string name = fs::path(path).filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name.ends_with(".json") || name.ends_with(".jsonc")) return about_scene(path);
  if (name.ends_with(".h5")) return about_run(path);
  if (name.ends_with(".msh") || name.ends_with(".vtk")) return about_tets(path);
  for (const char* end : {".nii", ".nii.gz", ".nrrd", ".nhdr", ".vdb"})
    if (name.ends_with(end)) return about_volume(path, series, sheet);
  for (const char* end : {".obj", ".stl", ".ply", ".off", ".gltf", ".glb"})
    if (name.ends_with(end)) return about_surface(path);
  if (holds_dicom(path)) return about_volume(path, series, sheet);
  throw InputError(
      path +
      ": not a kind of file that brim knows; it must be a scene (.json, .jsonc), a surface (.obj, .stl, .ply, "
      ".off, .gltf, .glb), tetrahedra (.msh, .vtk), a volume (.nii, .nii.gz, .nrrd, .nhdr, .vdb, "
      "DICOM file or folder), or a run (folder, .h5)");
}

}  // namespace

void add_info(CLI::App& app, int& code) {
  CLI::App* command = app.add_subcommand("info", "say what is in a scene, mesh, volume or run");
  auto path = std::make_shared<std::string>(), sheet = std::make_shared<std::string>(),
       series = std::make_shared<std::string>();
  command->add_option("file", *path, "scene, surface, tetrahedra, volume or run")->required();
  command->add_option("--series", *series, "of a DICOM folder: UID of the series to read, or \"largest\"");
  command->add_option("--sheet", *sheet, "of a volume: picture (.png) of slices along z to write");
  command->callback([path, series, sheet, &code] {
    about(*path, *series, *sheet);
    code = kGood;
  });
}

}  // namespace brim::cli
