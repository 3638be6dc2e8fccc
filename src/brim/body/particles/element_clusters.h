#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/motion_clusters.h"
#include "brim/body/particles/particle_contact.h"

namespace brim {

/// The matter of a body of particles in clusters of neighbouring elements, each divided again into a few finer ones.
/// Position and velocity of an element lie within the hull of its corners', so the boxes of a cluster's corners contain
/// both. Tests: tests/body/element_clusters_test.cpp
class ElementClusters {
 public:
  /// @param rest  [m] positions that define neighbours
  void build(std::span<const Vec3> rest, const ParticleContact::Elements& elements);
  /// Appends the bounds of each cluster.
  /// @param x, v   [m], [m/s] of the particles  @param reach  [m] of the matter beyond the particles
  void measure(std::span<const Vec3> x, std::span<const double> v, double reach, std::vector<MotionCluster>& out) const;
  /// Appends the bounds of the finer clusters of cluster c.
  void measure_finer(std::size_t c, std::span<const Vec3> x, std::span<const double> v, double reach,
                     std::vector<MotionCluster>& out) const;
  std::size_t size() const { return coarse_.first.size() - 1; }

 private:
  /// Particles of each cluster, without repetition.
  struct Clusters {
    std::vector<std::int32_t> first{0}, node;
    std::span<const std::int32_t> of(std::size_t c) const {
      return std::span(node).subspan(static_cast<std::size_t>(first[c]),
                                     static_cast<std::size_t>(first[c + 1] - first[c]));
    }
  };
  Clusters coarse_, fine_;
  std::vector<std::int32_t> first_fine_{0};  ///< of each cluster
};

}  // namespace brim
