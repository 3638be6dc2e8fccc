#pragma once

#include <cstdint>
#include <span>

namespace brim {

/// Optional interface of bodies of particles under tension. Forces are evaluated at the start of a step: Q + dt ∂Q/∂q v
/// would rotate the tension of matter sliding along a curve by v dt/R, while the normals of the guiding surface, also
/// from the start, do not rotate. The imbalance T v dt/R per radian acts as a brake (docs/numerics.md, Tension along
/// curves). So between guided particles the rate at the start includes strain only.
class GuidedParticles {
 public:
  virtual ~GuidedParticles() = default;
  /// For the coming step; the next update clears it. @param guided  nonzero for particles that lie on a rigid body or
  /// on a fixed part, shape (particles)
  virtual void set_guided(std::span<const std::uint8_t> guided) = 0;
  /// For the coming step; the next update clears it. @param linked  nonzero for particles that a link holds
  virtual void set_linked(std::span<const std::uint8_t> linked) = 0;
  /// y += (∂Q/∂q) x, without the rotation of tension between guided particles. @param x  [m/s]  @param y  [N/s]
  virtual void apply_start_stiffness(std::span<const double> x, std::span<double> y) const = 0;
};

}  // namespace brim
