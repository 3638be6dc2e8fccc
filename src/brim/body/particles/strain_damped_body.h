#pragma once

#include "brim/body/particles/particle_body.h"
#include "brim/body/particles/spring_elements.h"

namespace brim {

/// Particles whose stiffness damping acts only on the rate of strain: the force is −b D v, D: material part of the
/// stiffness, without the geometric part from tension. So a spinning, stretched rope is not braked:
///   A = (1 + dt a) M + dt² K + dt b D
/// D is computed with the internal forces, in a matrix with the pattern of K.
/// Springs that turn against the body's mean rotation keep the lengths that the solve gave them (docs/numerics.md,
/// Momentum of deformable bodies).
class StrainDampedBody : public ParticleBody {
 public:
  void add_forces(const Environment& env, std::span<double> Q) const override;
  void apply_damping(std::span<const double> x, std::span<double> y) const override;
  void begin_solve(double dt) override;
  void apply_system(std::span<const double> x, std::span<double> y) const override;
  std::optional<BlockSystem> block_system() const override;
  void add_system_diagonal(std::size_t first, BlockDiagonal& D) const override;

 protected:
  using ParticleBody::ParticleBody;
  /// Fixes the pattern of K, D and the system: call matrix.begin, add_elements any number of times, then this.
  void share_pattern(BlockMatrix pattern);

  void begin_inner() override;
  void end_inner() override;
  void add_turning_stiffness(std::span<const double> x, std::span<const std::uint8_t> guided,
                             std::span<double> y) const override;

  Straighten straightening(double dt) const override;
  /// Springs that must not be stretched by turning; null: none.
  virtual const SpringElements* stiff_springs() const { return nullptr; }

  BlockMatrix damper_;  // D [N/m], filled by add_inner

 private:
  bool straighten(std::span<const double> x, std::span<const double> way, std::span<double> more) const;

  BlockMatrix system_;  // dt² K + dt b D, made by begin_solve
};

}  // namespace brim
