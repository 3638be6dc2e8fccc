#include "brim/body/particles/tet_display.h"

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/tet_lattice.h"

namespace brim {

TetDisplay::TetDisplay(const TetMesh& mesh, std::span<const Triangle> boundary, const TriMesh& fine) {
  if (!fine.triangles.empty()) {
    const Embedding embedding = embed(mesh, fine.vertices);
    for (const std::int32_t e : embedding.tet) carrier_.push_back(mesh.tets[e]);
    weight_ = embedding.weights;
    display_.triangles = fine.triangles;
  } else {
    // The boundary with its own numbering, so that inner vertices are not written to files.
    std::vector<std::int32_t> number(mesh.vertices.size(), -1);
    std::vector<Triangle> triangles;
    for (Triangle t : boundary) {
      for (std::int32_t& n : t) {
        if (number[n] < 0) {
          number[n] = static_cast<std::int32_t>(carrier_.size());
          carrier_.push_back({n, n, n, n});
          weight_.push_back({1.0, 0.0, 0.0, 0.0});
        }
        n = number[n];
      }
      triangles.push_back(t);
    }
    display_.triangles = std::move(triangles);
  }
  display_.vertices = carrier_.size();
}

void TetDisplay::positions(std::span<const Vec3> x, std::span<Vec3f> out) const {
  BRIM_CHECK(out.size(), ==, carrier_.size());
  parallel_blocks(out.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 sum = Vec3::Zero();
      for (int k = 0; k < 4; ++k) sum += weight_[i][k] * x[carrier_[i][k]];
      out[i] = sum.cast<float>();
    }
  });
}

void TetDisplay::values(std::span<const double> value, std::span<float> out) const {
  BRIM_CHECK(out.size(), ==, carrier_.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) sum += weight_[i][k] * value[static_cast<std::size_t>(carrier_[i][k])];
    out[i] = static_cast<float>(sum);
  }
}

}  // namespace brim
