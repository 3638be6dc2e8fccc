#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "brim/core/error.h"
#include "brim/io/surface_reader.h"
#include "brim/io/tet_reader.h"
#include "brim/io/urdf_reader.h"
#include "brim/io/volume_reader.h"
#include "brim/record/h5.h"
#include "brim/scene/document.h"
#include "brim/scene/validate.h"
#include "server/viewer_routes.h"

/// What is done with bytes that could be anything: read as a file of each format. A reader may refuse them (InputError)
/// or take them; whatever else it does is a finding. Used by the fuzzers (fuzzer.cpp, apart_fuzzer.cpp) and by the test
/// of the inputs that are kept (inputs_test.cpp).
namespace brim::fuzz {

using Bytes = std::span<const std::uint8_t>;
/// What a reader said: the message of what it refuses, some words on what it takes.
using Outcome = std::string;

/// A place for a file in memory, where there is one, that goes with the process.
inline const std::filesystem::path& folder() {
  static const struct Folder {
    std::filesystem::path path = (std::filesystem::is_directory("/dev/shm") ? std::filesystem::path("/dev/shm")
                                                                            : std::filesystem::temp_directory_path()) /
                                 ("brim_fuzz_" + std::to_string(::getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  } made;
  return made.path;
}

/// Reads the bytes from a file of that name. What is refused is refused with a reason.
template <class Read>
Outcome read_as(Bytes bytes, const char* name, const Read& read) {
  const std::filesystem::path path = folder() / name;
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  try {
    return read(path);
  } catch (const InputError& error) {
    const std::string_view why = error.what();
    if (why.empty()) std::abort();
    if (!why.starts_with(path.string())) return std::string(why);  // of another file that this one names
    return std::string(why.substr(path.string().size()));
  }
}

inline Outcome surface(Bytes bytes, const char* name) {
  return read_as(bytes, name, [](const auto& path) {
    const TriMesh mesh = read_surface(path);
    return fmt::format("{} vertices, {} triangles", mesh.vertices.size(), mesh.triangles.size());
  });
}

inline Outcome tets(Bytes bytes, const char* name) {
  return read_as(bytes, name, [](const auto& path) { return fmt::format("{} tets", read_tets(path).tets.size()); });
}

inline Outcome volume(Bytes bytes, const char* name) {
  return read_as(bytes, name, [](const auto& path) {
    VolumeReadOptions options;
    options.max_bytes = 4e6;
    const VolumeInfo info = read_volume_info(path.string());
    read_volume(info, options);
    return fmt::format("{} {}", info.format, voxel_word(info.type));
  });
}

/// The text of a scene, as far as no file and no body is made of it.
inline Outcome scene(Bytes bytes) {
  try {
    Document document = parse_document({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "a.json");
    validate(document, scene_schema());
    return "a scene";
  } catch (const InputError& error) {
    return error.what();
  }
}

/// Every data set of a run file, read in the shape that it says it has.
inline Outcome run(Bytes bytes) {
  return read_as(bytes, "run.h5", [](const auto& path) {
    const h5::File file(path.string(), h5::File::Mode::Read);
    for (const std::string& name : file.datasets()) {
      try {
        const h5::Dataset set = file.open(name);
        const std::vector<std::uint64_t> shape = set.shape();
        set.need_rows(0, shape[0], std::span(shape).subspan(1));
        std::uint64_t elements = 1;
        for (const std::uint64_t n : shape) elements *= n;
        if (elements > (std::uint64_t{1} << 22)) continue;
        std::vector<double> numbers(elements);  // the widest of all types
        set.read(numbers.data(), elements, 0, shape[0], set.type());
      } catch (const InputError&) {
      }
    }
    return "a run";
  });
}

/// A run of which nothing is there.
class NoRun : public viewer::RunSource {
 public:
  viewer::Progress progress() override { return {}; }
  nlohmann::json info() override { return {{"name", "none"}}; }
  std::string topology(int body) override { return std::to_string(body); }
  std::string frame(std::int64_t frame) override { return std::to_string(frame); }
  std::string slice(std::int64_t frame, const viewer::SliceRequest& request) override {
    return fmt::format("{} {} {}", frame, request.axis, request.at);
  }
  std::string stress(std::int64_t frame) override { return std::to_string(frame); }
  std::string series(std::int64_t from) override { return std::to_string(from); }
};

/// What comes over a connection of the viewer, one request after another. No file but the page's may be had.
inline Outcome request(Bytes bytes) {
  static NoRun source;
  static const viewer::ViewerRoutes routes(source, folder());
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  while (const auto size = viewer::head_size(text)) {
    const auto read = viewer::parse_request(text.substr(0, *size));
    text.remove_prefix(*size);
    if (!read) continue;
    const viewer::HttpResponse response = routes.answer(*read);
    viewer::bytes_of(response, read->method == "HEAD", read->keep_alive);
    if (response.status == 200 && response.body.find("root:") != std::string::npos) std::abort();
  }
  return "";
}

enum class Where {
  Here,   ///< brim's own reader, in this process: with address and undefined-behaviour checks
  Apart,  ///< a library of others, in a process of its own (brim/io/child_reader.h), which may end as it likes
};

struct FileTarget {
  const char* name;
  Where where;
  Outcome (*read)(Bytes);
};

inline constexpr FileTarget kFileTargets[] = {
    {"ply", Where::Here, [](Bytes b) { return surface(b, "a.ply"); }},
    {"off", Where::Here, [](Bytes b) { return surface(b, "a.off"); }},
    {"obj", Where::Here, [](Bytes b) { return surface(b, "a.obj"); }},
    {"stl", Where::Apart, [](Bytes b) { return surface(b, "a.stl"); }},
    {"gltf", Where::Apart, [](Bytes b) { return surface(b, "a.gltf"); }},
    {"glb", Where::Apart, [](Bytes b) { return surface(b, "a.glb"); }},
    {"msh", Where::Here, [](Bytes b) { return tets(b, "a.msh"); }},
    {"vtk", Where::Here, [](Bytes b) { return tets(b, "a.vtk"); }},
    {"nrrd", Where::Here, [](Bytes b) { return volume(b, "a.nrrd"); }},
    {"nifti", Where::Here, [](Bytes b) { return volume(b, "a.nii"); }},
    {"nifti_gz", Where::Here, [](Bytes b) { return volume(b, "a.nii.gz"); }},
    {"vdb", Where::Apart, [](Bytes b) { return volume(b, "a.vdb"); }},
    {"dicom", Where::Apart, [](Bytes b) { return volume(b, "a.dcm"); }},
    {"urdf", Where::Here,
     [](Bytes b) {
       return read_as(b, "a.urdf",
                      [](const auto& path) { return fmt::format("{} pieces", read_urdf(path).pieces.size()); });
     }},
    {"scene", Where::Here, scene},
    {"run", Where::Apart, run},
    {"request", Where::Here, request},
};

/// The target that BRIM_FUZZ_TARGET names; ends the process where it is none of those.
inline const FileTarget& chosen_target(Where where) {
  const char* name = std::getenv("BRIM_FUZZ_TARGET");
  for (const FileTarget& t : kFileTargets)
    if (name != nullptr && t.where == where && std::string_view(name) == t.name) return t;
  std::fputs("BRIM_FUZZ_TARGET must be one of:\n", stderr);
  for (const FileTarget& t : kFileTargets)
    if (t.where == where) std::fprintf(stderr, "%s\n", t.name);
  std::exit(2);
}

}  // namespace brim::fuzz
