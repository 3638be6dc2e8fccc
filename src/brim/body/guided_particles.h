#pragma once

#include <cstdint>
#include <span>

namespace brim {

/// Optional interface of bodies of particles whose matter carries tension. The forces of a step are known where it
/// starts: Q + dt ∂Q/∂q v would turn the tension of what slides along a curve with it, by v dt/R, while the normals of
/// what guides it, found at the start too, do not turn. The two are then out of balance by T v dt/R per radian, a brake
/// (docs/numerics.md, Tension along curves). So between particles that are guided the rate at the start counts strain
/// alone.
class GuidedParticles {
 public:
  virtual ~GuidedParticles() = default;
  /// Of the coming step; the next update forgets it. @param guided  nonzero for particles that lie on something fixed,
  /// shape (particles)
  virtual void set_guided(std::span<const std::uint8_t> guided) = 0;
  /// y += (∂Q/∂q) x, less what only turns tension between guided particles. @param x  [m/s]  @param y  [N/s]
  virtual void apply_start_stiffness(std::span<const double> x, std::span<double> y) const = 0;
};

}  // namespace brim
