#pragma once

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"

namespace brim {

/// Inverses P of the bodies' own systems A = M − dt ∂Q/∂v − dt² ∂Q/∂q, without contact, for constraint rows. Bodies
/// with few velocities are inverted exactly. Larger ones up to kMostFactored are factored on demand, their matrix
/// assembled column by column from their operator or, in single precision, taken from Body::block_system. For others P
/// = D⁻¹ + Z (Zᵀ A Z)⁻¹ Zᵀ: the inverse of the diagonal blocks, which responds only where a force acts, plus the six
/// rigid motions Z, which respond as a whole.
class BodyInverses {
 public:
  static constexpr std::size_t kMostFactored = 3000;  ///< [velocities] above this a factor costs more than it saves

  /// Every body must have begun its solve.
  /// @param wanted  1 for bodies whose inverse will be needed, 2 if it must be exact where possible, 3 if single
  ///                precision of the matrix is enough
  void begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
             std::span<const std::uint8_t> wanted);

  /// x = P b for the local part of P, filtered. @param b, x  slices of the body
  void local(std::size_t body, std::span<const double> b, std::span<double> x) const;
  /// Number of right-hand sides solved together, and their values, one row per velocity.
  static constexpr int kTogether = 24;
  using Together = Eigen::Matrix<double, Eigen::Dynamic, kTogether, Eigen::RowMajor>;
  /// x := A⁻¹ x, for a factored body. @param x  filtered, shape (nv of the body, kTogether)
  void solve_together(std::size_t body, Together& x) const;
  /// True when local is A⁻¹.
  bool exact(std::size_t body) const { return dense_[body] != 0 || factored(body); }
  /// True when the body has many velocities and its matrix is factored.
  bool factored(std::size_t body) const { return sparse_[body] != nullptr; }
  /// Number of rigid motions in addition to the local part, 0 or 6.
  int modes(std::size_t body) const { return static_cast<int>(mode_[body].cols()); }
  /// Zᵀ b, and the response (Zᵀ A Z)⁻¹ of the modes to it.
  Eigen::VectorXd to_modes(std::size_t body, std::span<const double> b) const;
  Eigen::VectorXd mode_response(std::size_t body, const Eigen::VectorXd& b) const;

 private:
  void factor(std::size_t body);
  void factor_sparse(std::size_t body, bool shown);
  void find_modes(std::size_t body);

  std::span<const std::unique_ptr<Body>> bodies_;
  std::vector<std::size_t> first_v_, first_block_;
  std::vector<std::uint8_t> dense_;
  std::vector<Eigen::LLT<Eigen::MatrixXd>> factor_;  ///< of A with prescribed directions replaced by the identity
  std::vector<std::unique_ptr<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>> sparse_;  ///< likewise, or null
  std::vector<Eigen::MatrixXd> mode_;  ///< Z, filtered, shape (nv, 6) or none
  std::vector<Eigen::LLT<Eigen::MatrixXd>> mode_factor_;
  std::vector<int> sizes_;
  BlockDiagonal diagonal_;
};

}  // namespace brim
