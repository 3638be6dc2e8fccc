#pragma once

#include <optional>
#include <span>
#include <vector>

#include "brim/body/stressed_solid.h"
#include "brim/record/export/vtk_file.h"

namespace brim::exporting {

/// Adds the tetrahedra of a solid (or its samples, one vertex each) with stress and strain to an unstructured grid;
/// the tensors as XX, YY, ZZ, XY, YZ, XZ.
/// @param field    may be empty, for a solid that was removed
/// @param samples  it is one of samples: has no tetrahedra
/// @param v        [m/s] of the nodes, shape (nodes, 3) flat; nothing: no such array
/// @return the piece
std::string stress_piece(const StressField& field, bool samples, std::optional<std::span<const double>> v,
                         VtkFile& file);

}  // namespace brim::exporting
