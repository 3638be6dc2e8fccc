#pragma once

#include "brim/math/types.h"

namespace brim {

// Small symmetric matrices by Eigen's solvers, compiled once: each file that instantiates them takes seconds longer.
// Tests: tests/math/small_symmetric_test.cpp

/// Eigenvalues, ascending, and unit eigenvectors, one per column.
struct SymmetricAxes {
  Vec3 values;
  Mat3 vectors;
};
SymmetricAxes symmetric_axes(const Mat3& m);

/// Solves m x = b. @param m  definite
Vec3 solve_symmetric(const Mat3& m, const Vec3& b);

/// Matrix of at most six rows, without heap memory.
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
/// m := m⁻¹. @return smallest pivot over the largest diagonal entry; at most 0 when m is not positive definite, and m
/// is then unchanged
double invert_definite(SmallMatrix& m);

}  // namespace brim
