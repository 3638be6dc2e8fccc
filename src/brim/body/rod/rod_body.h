#pragma once

#include <array>

#include "brim/body/particles/spring_elements.h"
#include "brim/body/particles/strain_damped_body.h"
#include "brim/body/rod/rod_bending.h"

namespace brim {

/// Material and options of a rod or a rope. For a solid round rod: λ = ρ π r², EA = E π r², EI = E π r⁴ / 4.
struct RodOptions : ParticleOptions {
  double radius = 0.01;         ///< [m] for contact; the voxel size follows it
  double linear_density = 0.1;  ///< λ [kg/m]
  double stretch = 1e4;         ///< EA [N]
  double bending = 1e-3;        ///< EI [N m²], >= 0
  bool closed = false;          ///< the last node is connected to the first
  bool rests_straight = false;  ///< true: a rope, straight at rest; false: its rest shape is the given one
};

/// A line of particles: rod, rope, chain, ring (docs/bodies/rod.md). Stretch by springs of stiffness EA / L, bending by
/// the curvature at each node; no twist.
/// Contact: capsules along the segments (paper, section 5.2), exact in linear and angular momentum except for the spin
/// of the rod about itself, for which it has no coordinate (LineWeightsMap). The radius should be at least one voxel.
/// Tests: tests/body/rod_body_test.cpp
class RodBody final : public StrainDampedBody {
 public:
  /// @param nodes  rest positions along the rod, [m], world frame; at least 2, 3 when closed
  /// @throws InputError  when a number is out of range, two nodes in a row coincide, or the rod folds onto itself
  RodBody(std::vector<Vec3> nodes, RodOptions options);

  std::string_view kind() const override { return "rod"; }
  double elastic_energy() const override { return stretch_.energy(x_) + bending_.energy(x_); }
  const SpringElements* stiff_springs() const override { return &stretch_; }

  const SpringElements& stretch() const { return stretch_; }
  const RodBending& bending() const { return bending_; }
  /// Length at rest, [m].
  double length() const { return length_; }

 protected:
  void add_inner() override;

 private:
  struct Line {
    std::vector<Spring> springs;
    std::vector<double> mass;
  };
  static Line make_line(const std::vector<Vec3>& nodes, const RodOptions& options);
  RodBody(std::vector<Vec3> nodes, Line line, const RodOptions& options);

  SpringElements stretch_;
  RodBending bending_;
  double length_ = 0.0;
};

}  // namespace brim
