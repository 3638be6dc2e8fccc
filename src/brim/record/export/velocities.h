#pragma once

#include <optional>
#include <vector>

#include "brim/record/export/format.h"

namespace brim::exporting {

/// Velocities of the vertices of a run's bodies, for motion blur.
///   rigid bodies            u = V + ω × (x − c)   with the recorded twist (V, ω) at c
///   vertices that are nodes u = v of the node
///   all others              u = (∂x/∂q) v         by the body, in the world that is built anew (docs/export.md)
/// Without a world those are differences of positions: u = (x₊ − x₋) / (t₊ − t₋) from the frame before to that after.
/// Tests: tests/record/export_velocities_test.cpp
class Velocities {
 public:
  /// @param world_at  called only for bodies that need it; may be empty, or throw an InputError: there is no world
  Velocities(const RunReader& run, WorldAt world_at);

  VelocitySource source(int body);
  /// @param state  of the frame  @param x  [m] vertices of the body in it
  /// @return [m/s], shape (vertices), or empty where the source is None
  std::vector<Vec3f> at(int body, std::int64_t frame, const State& state, const std::vector<Vec3f>& x);

 private:
  struct Own {
    VelocitySource source = VelocitySource::None;
    std::size_t stride = 3;         ///< numbers of each node in v
    std::vector<std::size_t> node;  ///< of each vertex, where vertices are nodes
  };
  const Own& own(int body);
  Own find(int body);
  bool find_nodes(int body, Own& found) const;
  const World* world(std::int64_t frame);
  std::vector<Vec3f> of_nodes(const Own& own, int body, const State& state, const std::vector<Vec3f>& x) const;
  std::vector<Vec3f> of_world(int body, std::int64_t frame, const std::vector<Vec3f>& x);
  std::vector<Vec3f> differences(int body, std::int64_t frame, std::size_t vertices) const;

  const RunReader& run_;
  WorldAt world_at_;
  std::vector<std::optional<Own>> own_;
};

}  // namespace brim::exporting
