#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>

#include "brim/mesh/tri_mesh.h"
#include "checkout_paths.h"

namespace brim::test {

/// Path of a file of the optional test data; empty when the file is absent.
inline std::filesystem::path data_file(const std::string& name) {
  const char* folder = std::getenv("BRIM_DATA");
  for (const std::filesystem::path& base :
       {std::filesystem::path(folder ? folder : ""), std::filesystem::path(BRIM_SOURCE_DIR) / "../shared/data",
        std::filesystem::path(BRIM_SOURCE_DIR) / "../../shared/data"})
    if (!base.empty() && std::filesystem::exists(base / name)) return base / name;
  return {};
}

/// Reads v and f lines of an OBJ file (polygons as fans), nothing else: an independent and minimal reader.
inline TriMesh read_plain_obj(const std::filesystem::path& path) {
  TriMesh mesh;
  std::ifstream in(path);
  std::string line;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string kind, word;
    words >> kind;
    if (kind == "v") {
      Vec3 x;
      words >> x[0] >> x[1] >> x[2];
      mesh.vertices.push_back(x);
    } else if (kind == "f") {
      std::vector<std::int32_t> corners;
      while (words >> word) {
        const int i = std::stoi(word);
        corners.push_back(i > 0 ? i - 1 : static_cast<int>(mesh.vertices.size()) + i);
      }
      for (std::size_t k = 2; k < corners.size(); ++k)
        mesh.triangles.push_back({corners[0], corners[k - 1], corners[k]});
    }
  }
  return mesh;
}

/// Random numbers that are the same on every machine.
struct Random {
  std::mt19937_64 engine;
  explicit Random(std::uint64_t seed) : engine(seed) {}
  double operator()(double lo, double hi) { return lo + (hi - lo) * static_cast<double>(engine() >> 11) * 0x1p-53; }
  Vec3 in(const Aabb& box) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = (*this)(box.lo[k], box.hi[k]);
    return p;
  }
};

}  // namespace brim::test
