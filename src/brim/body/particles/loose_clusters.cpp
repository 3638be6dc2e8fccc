#include "brim/body/particles/loose_clusters.h"

#include "brim/body/particles/motion_bounds.h"
#include "brim/core/parallel.h"

namespace brim {

void measure_cells(const ParticleCells& cells, std::span<const Vec3> x, std::span<const double> v, double reach,
                   std::vector<MotionCluster>& out) {
  const std::size_t first = out.size();
  out.resize(first + cells.cells());
  parallel_blocks(cells.cells(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) out[first + c] = motion_bounds(x, v, cells.of_cell(c), reach);
  });
}

void measure_cell(const ParticleCells& cells, std::size_t cell, std::span<const Vec3> x, std::span<const double> v,
                  double reach, std::vector<MotionCluster>& out) {
  for (const std::int32_t& i : cells.of_cell(cell)) out.push_back(motion_bounds(x, v, std::span(&i, 1), reach));
}

}  // namespace brim
