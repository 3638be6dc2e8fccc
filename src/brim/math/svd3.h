#pragma once

#include "brim/math/types.h"

namespace brim {

/// F = U diag(s) Vᵀ with proper rotations U and V: the last singular value takes the sign of det F.
struct Svd3 {
  Mat3 U, V;
  Vec3 s;  ///< s0 >= s1 >= |s2|, s2 < 0 when F inverts space
};

/// Singular value decomposition of any 3x3 matrix, singular ones included: cyclic Jacobi on FᵀF, then the columns of
/// F V made orthonormal in order (Irving, Teran and Fedkiw 2004 for the sign; McAdams et al. 2011 for the scheme).
/// Absolute accuracy about 1e-15 |F|. About 0.3 µs.  Tests: tests/math/svd3_test.cpp
Svd3 svd3(const Mat3& F);

/// The rotation nearest to F (polar decomposition F = R S); proper also when F is inverted or flat.
inline Mat3 polar_rotation(const Mat3& F) {
  const Svd3 d = svd3(F);
  return d.U * d.V.transpose();
}

}  // namespace brim
