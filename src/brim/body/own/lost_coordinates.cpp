#include "brim/body/own/lost_coordinates.h"

#include <Eigen/Eigenvalues>

namespace brim {

namespace {

/// Motion of no matter, by the square of its share; resistance of no force, as a share of the largest.
constexpr double kNoMatter = 1e-12, kNoForce = 1e-9;
/// [-] of the largest share in a motion from which on a coordinate is named.
constexpr double kTakesPart = 0.1;

}  // namespace

std::vector<Eigen::Index> lost_coordinates(const Eigen::MatrixXd& M, const Eigen::MatrixXd& K) {
  const Eigen::Index n = M.rows();
  Eigen::VectorXd unit(n);
  for (Eigen::Index i = 0; i < n; ++i) unit[i] = M(i, i) > 0.0 ? 1.0 / std::sqrt(M(i, i)) : 1.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> motions(unit.asDiagonal() * M * unit.asDiagonal());
  Eigen::Index lost = 0;
  while (lost < n && motions.eigenvalues()[lost] < kNoMatter) ++lost;
  if (lost == 0) return {};
  // Of the motions of no matter, the one that forces resist least.
  const Eigen::MatrixXd resistance = -(unit.asDiagonal() * K * unit.asDiagonal());
  const Eigen::MatrixXd Z = motions.eigenvectors().leftCols(lost);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> resisted(Z.transpose() * resistance * Z);
  if (resisted.eigenvalues()[0] > kNoForce * resistance.diagonal().cwiseAbs().maxCoeff()) return {};
  const Eigen::VectorXd z = Z * resisted.eigenvectors().col(0);
  std::vector<Eigen::Index> named;
  for (Eigen::Index i = 0; i < n; ++i)
    if (std::abs(z[i]) >= kTakesPart * z.cwiseAbs().maxCoeff()) named.push_back(i);
  return named;
}

}  // namespace brim
