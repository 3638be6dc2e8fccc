#pragma once

#include "brim/grid/node_cube.h"

namespace brim {

/// ramp_inverse at the nodes of one row of a cube, eight at a time in single precision: within 2e-7 w of the exact
/// inverse of the given density.
///   rho = ramp(d, w),  u = d/w:  3u - 4u^3 = 1 - 2 rho;  with v = 1/2 - |u|:  6v^2 - 4v^3 = 1 - |1 - 2 rho|
/// solved by two Newton steps from v^2 (6 - 4 sqrt(q/6)) = q, q = 1 - |1 - 2 rho|.
/// @param rho, d  shape (8)  @param w  unit of d
/// Tests: tests/contact/row_ramp_test.cpp
void row_ramp_inverse(const float* rho, float w, float* d);

}  // namespace brim
