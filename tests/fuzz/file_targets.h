#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
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
/// or take them; whatever else it does is a finding. Used by the fuzzer (fuzzer.cpp) and by the test of the inputs that
/// are kept (inputs_test.cpp).
namespace brim::fuzz {

using Bytes = std::span<const std::uint8_t>;

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

template <class Read>
void read_as(Bytes bytes, const char* name, const Read& read) {
  const std::filesystem::path path = folder() / name;
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  try {
    read(path);
  } catch (const InputError&) {
  }
}

inline void surface(Bytes bytes, const char* name) {
  read_as(bytes, name, [](const auto& path) { read_surface(path); });
}

inline void tets(Bytes bytes, const char* name) {
  read_as(bytes, name, [](const auto& path) { read_tets(path); });
}

inline void volume(Bytes bytes, const char* name) {
  read_as(bytes, name, [](const auto& path) {
    VolumeReadOptions options;
    options.max_bytes = 64e6;
    read_volume(read_volume_info(path.string()), options);
  });
}

/// The text of a scene, as far as no file and no body is made of it.
inline void scene(Bytes bytes) {
  try {
    Document document = parse_document({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "a.json");
    validate(document, scene_schema());
  } catch (const InputError&) {
  }
}

/// Every data set of a run file, read in the shape that it says it has.
inline void run(Bytes bytes) {
  read_as(bytes, "run.h5", [](const auto& path) {
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
  std::string series(std::int64_t from) override { return std::to_string(from); }
};

/// What comes over a connection of the viewer, one request after another. No file but the page's may be had.
inline void request(Bytes bytes) {
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
}

struct FileTarget {
  const char* name;
  void (*read)(Bytes);
};

inline constexpr FileTarget kFileTargets[] = {
    {"ply", [](Bytes b) { surface(b, "a.ply"); }},
    {"off", [](Bytes b) { surface(b, "a.off"); }},
    {"obj", [](Bytes b) { surface(b, "a.obj"); }},
    {"stl", [](Bytes b) { surface(b, "a.stl"); }},
    {"gltf", [](Bytes b) { surface(b, "a.gltf"); }},
    {"glb", [](Bytes b) { surface(b, "a.glb"); }},
    {"msh", [](Bytes b) { tets(b, "a.msh"); }},
    {"vtk", [](Bytes b) { tets(b, "a.vtk"); }},
    {"nrrd", [](Bytes b) { volume(b, "a.nrrd"); }},
    {"nifti", [](Bytes b) { volume(b, "a.nii"); }},
    {"nifti_gz", [](Bytes b) { volume(b, "a.nii.gz"); }},
    {"vdb", [](Bytes b) { volume(b, "a.vdb"); }},
    {"dicom", [](Bytes b) { volume(b, "a.dcm"); }},
    {"urdf", [](Bytes b) { read_as(b, "a.urdf", [](const auto& path) { read_urdf(path); }); }},
    {"scene", scene},
    {"run", run},
    {"request", request},
};

}  // namespace brim::fuzz
