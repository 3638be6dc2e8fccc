#pragma once

#include <vector>

#include "brim/body/motion_clusters.h"
#include "brim/body/particles/particle_cells.h"

namespace brim {

/// Clusters of the matter of loose particles, which mix: those that lie in a cell now, and each particle alone. What
/// was spilled, and falls by itself, asks for no short steps of the rest.
/// @param x, v   of the particles in the caller's order, as in motion_bounds  @param reach  [m] of their matter
/// Tests: tests/body/loose_clusters_test.cpp
void measure_cells(const ParticleCells& cells, std::span<const Vec3> x, std::span<const double> v, double reach,
                   std::vector<MotionCluster>& out);
/// The particles of one cell.
void measure_cell(const ParticleCells& cells, std::size_t cell, std::span<const Vec3> x, std::span<const double> v,
                  double reach, std::vector<MotionCluster>& out);

}  // namespace brim
