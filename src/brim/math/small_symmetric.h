#pragma once

#include "brim/math/types.h"

namespace brim {

// Small symmetric matrices by Eigen's solvers, compiled once: each file that asks Eigen itself takes seconds more.
// Tests: tests/math/small_symmetric_test.cpp

/// Eigenvalues, ascending, and unit eigenvectors, a column each.
struct SymmetricAxes {
  Vec3 values;
  Mat3 vectors;
};
SymmetricAxes symmetric_axes(const Mat3& m);

/// x of m x = b. @param m  definite
Vec3 solve_symmetric(const Mat3& m, const Vec3& b);

/// At most six rows, without memory of its own.
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
/// m := m⁻¹. @return smallest pivot over the largest entry of the diagonal; at most 0 where m is not definite, which is
/// then left as it is
double invert_definite(SmallMatrix& m);

}  // namespace brim
