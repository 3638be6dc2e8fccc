#pragma once

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

#include "brim/core/error.h"
#include "brim/io/surface_reader.h"
#include "brim/io/tet_reader.h"
#include "brim/io/urdf_reader.h"
#include "brim/io/volume_reader.h"

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
    {"urdf", [](Bytes b) { read_as(b, "a.urdf", [](const auto& path) { read_urdf(path); }); }},
};

}  // namespace brim::fuzz
