#pragma once

#include <vector>

#include "brim/body/motion_clusters.h"
#include "brim/body/particles/particle_cells.h"

namespace brim {

/// Motion clusters of loose particles, which mix: those now in a cell; as finer clusters single particles. Spilled
/// particles that fall by themselves then do not shorten the steps of the rest.
/// @param x, v   of the particles in the caller's order, as in motion_bounds  @param reach  [m] of their matter
/// Tests: tests/body/loose_clusters_test.cpp
void measure_cells(const ParticleCells& cells, std::span<const Vec3> x, std::span<const double> v, double reach,
                   std::vector<MotionCluster>& out);
/// The particles of one cell.
void measure_cell(const ParticleCells& cells, std::size_t cell, std::span<const Vec3> x, std::span<const double> v,
                  double reach, std::vector<MotionCluster>& out);

}  // namespace brim
