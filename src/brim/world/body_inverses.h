#pragma once

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"

namespace brim {

/// Inverses P of the bodies' own systems A = M − dt ∂Q/∂v − dt² ∂Q/∂q, without contact, as constraint rows need them.
/// Bodies of few velocities are inverted exactly, and larger ones on demand, up to a size (kMostFactored): their matrix
/// is found column by column from their operator, and factored, or taken as they show it (Body::block_system), in
/// single precision. Of others P = D⁻¹ + Z (Zᵀ A Z)⁻¹ Zᵀ: the inverse of the diagonal blocks, which answers only where
/// a force acts, and the six rigid motions Z, which answer as a whole.
class BodyInverses {
 public:
  static constexpr std::size_t kMostFactored = 3000;  ///< [velocities] beyond this a factor costs more than it saves

  /// Every body must have begun its solve.
  /// @param wanted  1 for bodies whose inverse will be asked for, 2 where it must be exact if it can be, 3 where single
  ///                precision of the matrix does
  void begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
             std::span<const std::uint8_t> wanted);

  /// x = P b for the local part of P, filtered. @param b, x  slices of the body
  void local(std::size_t body, std::span<const double> b, std::span<double> x) const;
  /// Right-hand sides that a factor takes at once, and their numbers one row after the other.
  static constexpr int kTogether = 24;
  using Together = Eigen::Matrix<double, Eigen::Dynamic, kTogether, Eigen::RowMajor>;
  /// x := A⁻¹ x, of a factored body. @param x  filtered, shape (nv of the body, kTogether)
  void solve_together(std::size_t body, Together& x) const;
  /// True when local is A⁻¹.
  bool exact(std::size_t body) const { return dense_[body] != 0 || factored(body); }
  /// True when the body's matrix is factored, though it has more than few velocities.
  bool factored(std::size_t body) const { return sparse_[body] != nullptr; }
  /// Number of rigid motions beside the local part, 0 or 6.
  int modes(std::size_t body) const { return static_cast<int>(mode_[body].cols()); }
  /// Zᵀ b, and the answer (Zᵀ A Z)⁻¹ of the motions to it.
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
  std::vector<std::unique_ptr<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>> sparse_;  ///< likewise, or none
  std::vector<Eigen::MatrixXd> mode_;  ///< Z, filtered, shape (nv, 6) or none
  std::vector<Eigen::LLT<Eigen::MatrixXd>> mode_factor_;
  std::vector<int> sizes_;
  BlockDiagonal diagonal_;
};

}  // namespace brim
