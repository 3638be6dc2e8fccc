#pragma once

#include "brim/body/fem/elastic_law.h"
#include "brim/body/meshless/moving_least_squares.h"
#include "brim/body/particles/element_schedule.h"
#include "brim/math/block_matrix.h"

namespace brim {

/// Elastic forces and stiffness at sample points of a field of frames:
///   F_s = Σ_k q_k ∇φ_k(X_s)ᵀ,   E = Σ_s V_s Ψ(F_s),   f_k = −Σ_s V_s P ∇φ_k,   K_kl = Σ_s V_s ∇φ_kᵀ (∂P/∂F) ∇φ_l
/// ∂P/∂F is made positive semi-definite as in TetElements.
class SampleElements {
 public:
  /// @param shape   φ and ∇φ at the samples
  /// @param volume  [m³] of each sample
  /// @param frames  [m] at rest, to order the samples in space
  SampleElements(ShapeFunctions shape, std::vector<double> volume, ElasticLaw law, const Lame& lame,
                 std::span<const Vec3> frames);

  /// The pattern of the stiffness: begin and finish stay with the caller.
  void add_pattern(BlockMatrix& matrix) const;
  void find_pairs(const BlockMatrix& matrix);
  /// Parallel, same bits for any number of threads. About 0.05 µs a pair of frames and sample.
  void add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness) const;
  double energy(std::span<const Vec3> x) const;
  std::size_t size() const { return volume_.size(); }
  /// F at a sample.
  Mat3 deformation(std::size_t sample, std::span<const Vec3> x) const;

 private:
  ShapeFunctions shape_;
  std::vector<double> volume_;
  ElasticLaw law_;
  Lame lame_;
  ElementSchedule schedule_;
  std::vector<std::int32_t> pair_;       // in the matrix, of all pairs (i, j), i < j, of a sample's frames
  std::vector<std::size_t> first_pair_;  // shape (samples + 1)
};

}  // namespace brim
