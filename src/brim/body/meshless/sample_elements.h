#pragma once

#include "brim/body/fem/elastic_law.h"
#include "brim/body/meshless/moving_least_squares.h"
#include "brim/body/meshless/sample_lanes.h"
#include "brim/body/particles/element_schedule.h"
#include "brim/math/block_matrix.h"

namespace brim {

/// Elastic forces and stiffness at sample points of a field of frames:
///   F_s = Σ_k q_k ∇φ_k(X_s)ᵀ,   E = Σ_s V_s Ψ(F_s),   f_k = −Σ_s V_s P ∇φ_k,   K_kl = Σ_s V_s ∇φ_kᵀ (∂P/∂F) ∇φ_l
/// ∂P/∂F is made positive semi-definite as in TetElements. Eight samples are processed at a time (SampleLanes).
class SampleElements {
 public:
  /// @param shape   φ and ∇φ at the samples
  /// @param volume  [m³] of each sample
  /// @param frames  [m] at rest, to order the samples in space
  SampleElements(ShapeFunctions shape, std::vector<double> volume, ElasticLaw law, const Lame& lame,
                 std::span<const Vec3> frames);

  /// Adds to the pattern of the stiffness; the caller calls begin and finish.
  void add_pattern(BlockMatrix& matrix) const;
  void find_pairs(const BlockMatrix& matrix);
  /// Parallel, same bits for any number of threads. About 0.01 to 0.02 µs per pair of frames and sample.
  void add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness) const;
  double energy(std::span<const Vec3> x) const;
  std::size_t size() const { return volume_.size(); }
  /// F at a sample.
  Mat3 deformation(std::size_t sample, std::span<const Vec3> x) const;
  /// First Piola-Kirchhoff stress there, [Pa].
  Mat3 stress(std::size_t sample, std::span<const Vec3> x) const {
    return first_piola_stress(law_, lame_, deformation(sample, x));
  }
  const ShapeFunctions& shape() const { return shape_; }
  std::span<const double> volume() const { return volume_; }

 private:
  static constexpr std::size_t kLanes = SampleLanes::kCount;
  /// Samples of a chunk with similar numbers of frames: a sample with fewer repeats its first frame with zero gradient.
  struct Group {
    std::size_t frames;   ///< n, the largest number of a sample
    std::size_t samples;  ///< at most kLanes; the last lanes may repeat the last sample
    std::size_t node;     ///< where node_ starts, and a third of where gradient_ does
    std::size_t pair;     ///< where pair_ starts
  };
  /// Groups of a chunk that starts at a place.
  static std::size_t first_group(std::size_t place) { return (place + kLanes - 1) / kLanes; }
  void add_group(std::span<const std::size_t> samples);
  SampleLanes lanes(std::size_t group) const;
  /// Positions of a group's frames, shape (n, 3, kLanes).
  void take(const Group& group, std::span<const Vec3> x, std::vector<double>& out) const;
  std::size_t frames_of(std::size_t s) const {
    return static_cast<std::size_t>(shape_.rows.first[s + 1] - shape_.rows.first[s]);
  }

  ShapeFunctions shape_;
  std::vector<double> volume_;
  ElasticLaw law_;
  Lame lame_;
  ElementSchedule schedule_;
  std::vector<Group> group_;
  std::vector<double> lane_volume_;  // shape (groups, kLanes)
  std::vector<std::int32_t> node_;   // of each group, shape (n, kLanes)
  std::vector<double> gradient_;     // of each group, shape (n, 3, kLanes)
  std::vector<std::int32_t> pair_;   // in the matrix, of each group, shape (n (n − 1) / 2, kLanes); −1: none
};

}  // namespace brim
