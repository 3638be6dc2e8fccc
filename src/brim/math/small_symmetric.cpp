#include "brim/math/small_symmetric.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace brim {

SymmetricAxes symmetric_axes(const Mat3& m) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(m);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Vec3 solve_symmetric(const Mat3& m, const Vec3& b) { return m.ldlt().solve(b); }

double invert_definite(SmallMatrix& m) {
  const double largest = m.diagonal().maxCoeff();
  if (!(m.diagonal().minCoeff() > 0.0)) return 0.0;
  if (m.rows() == 1) {
    m(0, 0) = 1.0 / m(0, 0);
    return 1.0;
  }
  const Eigen::LLT<SmallMatrix> llt(m);
  if (llt.info() != Eigen::Success) return 0.0;
  m = llt.solve(SmallMatrix::Identity(m.rows(), m.rows()));
  return llt.matrixLLT().diagonal().cwiseAbs2().minCoeff() / largest;
}

}  // namespace brim
