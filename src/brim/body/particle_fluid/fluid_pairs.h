#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/particle_fluid/fluid_kernel.h"
#include "brim/body/particles/particle_cells.h"

namespace brim {

/// Every ordered pair of neighbours of a particle fluid, in cell order, and products with the pressure and viscosity
/// operators. With V the volume of a particle and x_ij = x_i − x_j,
///   g_ij = V ∇W(x_ij)   [1/m]            φ_i = Σ_j V W(x_ij)   (i itself included; 1 where space is filled)
///   dφ_i = Σ_j g_ij · (dx_i − dx_j)
/// Entries are single precision, computed from differences in double precision; g_ij = −g_ji exactly.
class FluidPairs {
 public:
  using Vec4 = Eigen::Array4f;  ///< a vector in three lanes; the fourth is 0 unless noted

  /// @param volume     [m³] of a particle
  /// @param viscosity  [Pa s] dynamic
  void build(const ParticleCells& cells, const FluidKernel& kernel, double volume, double viscosity);

  std::size_t size() const { return size_; }
  /// φ in cell order, [-].
  std::span<const double> fill() const { return fill_; }
  /// Calls f(i, j, g_ij) for the neighbours of a particle, g in lanes 0 to 2.
  template <class F>
  void for_neighbours(std::size_t i, const F& f) const {
    const Block& b = blocks_[i / kBlock];
    for (std::int32_t e = b.first[i % kBlock]; e < b.first[i % kBlock + 1]; ++e) f(b.neighbour[e], b.gradient[e]);
  }

  /// Multiplies g of a particle's pair (index as in for_neighbours) by a factor and keeps its drag: the effect of an
  /// image along x_ij. Both directions of a pair need it. Valid until the next build or release.
  void stretch(std::size_t i, std::int32_t pair, float factor);
  /// Undoes all stretching.
  void release();

  /// rate_i = Σ_j g_ij · (v_i − v_j), for the particles with weight_i > 0; 0 for others.
  void rates(std::span<const Vec4> v, std::span<const float> weight, std::span<float> rate) const;
  /// y_i += Σ_j (p_i + p_j) g_ij.
  void add_pressure(std::span<const float> p, std::span<Eigen::Vector3d> y) const;
  /// y_i += s Σ_j a_ij (g_ij · (v_i − v_j)) g_ij, the viscous drag of the neighbours (Weiler et al. 2018, equation 6):
  ///   −f_i = 10 μ V Σ_j  (x_ij · v_ij) / (|x_ij|² + 0.01 H²) (−g_ij),  symmetric and definite, conserving both momenta
  void add_viscosity(double s, std::span<const Vec4> v, std::span<Eigen::Vector3d> y) const {
    add_viscosity(s, v, {}, y);
  }
  /// add_viscosity and the rates of all particles in one pass over the pairs.
  void add_viscosity(double s, std::span<const Vec4> v, std::span<float> rate, std::span<Eigen::Vector3d> y) const;

  /// Particles of one block of memory and work.
  static constexpr std::size_t kBlock = 256;

 private:
  struct Block {
    std::vector<std::int32_t> first;  ///< shape (particles + 1)
    std::vector<std::int32_t> neighbour;
    std::vector<Vec4> gradient;  ///< g, and a_ij in the fourth lane
  };
  /// Calls f(first particle, pairs) for all blocks, in parallel.
  template <class F>
  void for_blocks(const F& f) const;

  std::size_t size_ = 0;
  std::vector<double> place_[3];  ///< [m] each coordinate of all particles, and four more
  struct Stretched {
    std::size_t block;
    std::int32_t entry;
    Vec4 gradient;  ///< before stretching
  };
  std::vector<Block> blocks_;
  std::vector<Stretched> stretched_;
  std::vector<double> fill_;
};

}  // namespace brim
