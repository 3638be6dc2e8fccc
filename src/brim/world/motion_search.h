#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/motion_clusters.h"
#include "brim/math/box_sweep.h"
#include "brim/world/substeps.h"

/// The search behind motion_pieces; used by substeps.cpp only.
namespace brim {

/// The speeds of the two fastest parts, [m/s]: their sum bounds every relative speed.
class FastestTwo {
 public:
  void add(double speed) {
    second_ = std::max(second_, std::min(first_, speed));
    first_ = std::max(first_, speed);
  }
  double sum() const { return first_ + second_; }

 private:
  double first_ = 0.0, second_ = 0.0;
};

/// An upper bound of the pieces without looking at pairs: the two fastest parts at the finest step.
double most_pieces(const FastestTwo& speeds, std::span<const WorldPart> parts, const WorldOptions& options,
                   double time);

/// World normal of a part that is a half-space and does not turn; zero for all other parts. @param v  of its body
Vec3 normal_of_half_space(const WorldPart& part, std::span<const double> v);

/// Arguments of motion_pieces, with the meanings they have there.
struct PartMotion {
  std::span<const WorldPart> parts;
  std::span<const double> v;
  std::span<const std::size_t> first_v;
  const WorldOptions& options;
  double time, change;
  const HeldPairs& held;
  AlongPlanes along;
};

/// Finds the pair of parts that moves farthest relative to its motion_limit, by bounds that become finer:
///   the two fastest parts -> clusters of every part -> pairs of clusters whose boxes, swept over the time, overlap
///   -> finer clusters of the pairs that need more than one piece, those of the largest bounds first
/// Each stage ends the search when its bounds need no more than one piece. Used once.
/// Same bits for any number of threads.  Tests: tests/world/substeps_test.cpp
class MotionSearch {
 public:
  /// @param sweep  workspace
  MotionSearch(const PartMotion& motion, BoxSweep& sweep);
  /// Number of pieces, at least 1.
  double pieces();

 private:
  /// A pair of clusters that needs more than one piece by the bounds of its clusters.
  struct FastPair {
    double bound;      ///< upper bound of pieces
    double per_speed;  ///< [s/m] pieces for a relative speed
    std::int32_t a, b;
  };

  /// most_pieces before parts are divided into clusters; infinite when a part has clusters.
  double most_pieces_of_whole() const;
  double most_pieces_of_clusters() const;
  /// Asks the parts that can have several clusters for them; every other part is one.
  void find_clusters();
  /// Lists the clusters of all parts, with their boxes over the time.
  void place_clusters();
  void place_clusters_of(std::size_t part);
  /// Finds the pairs of clusters that need more than one piece.
  void find_fast_pairs();
  /// Finds those of the entries [begin, end) of the sweep with later ones.
  void find_fast_pairs_of(std::size_t begin, std::size_t end, std::vector<FastPair>& fast) const;
  /// [s/m] pieces for a relative speed of two parts, 0 for those that cannot meet.
  double pieces_per_speed(std::int32_t part_a, std::int32_t part_b) const;
  /// Divides the clusters of the fast pairs.
  void refine_clusters();
  /// Largest number of pieces of the fast pairs, by the finer clusters.
  double largest();
  /// The larger of `pieces` and what the given pairs need; they begin with the largest bounds.
  double largest_of(std::span<const FastPair> pairs, double pieces) const;

  std::span<const double> velocities(const WorldPart& part) const {
    return velocities_of(part, motion_.v, motion_.first_v);
  }
  /// True for parts that are one cluster.
  bool whole(std::size_t part) const { return number_[part] < 0 || several_[number_[part]].empty(); }
  double speed_between(const MotionCluster& a, const MotionCluster& b, std::int32_t part_a, std::int32_t part_b) const;

  PartMotion motion_;
  BoxSweep& sweep_;
  double wide_;  ///< [voxels] by which boxes are widened for the ramp
  // Per part.
  std::vector<std::int32_t> number_;  ///< index in several_, −1: none
  std::vector<Vec3> normal_;          ///< of half-spaces, if motion along them is ignored; else zero
  std::vector<std::size_t> first_;    ///< first cluster, shape (parts + 1)
  std::vector<std::vector<MotionCluster>> several_;
  // Per cluster.
  std::vector<MotionCluster> clusters_;
  std::vector<Aabb> boxes_;                        ///< [m] over the time, with ramp
  std::vector<std::int32_t> part_;                 ///< that it belongs to
  std::vector<std::int32_t> group_;                ///< of the sweep
  std::vector<std::vector<MotionCluster>> finer_;  ///< itself if it has none; empty where no pair is fast

  std::vector<FastPair> fast_;
};

}  // namespace brim
