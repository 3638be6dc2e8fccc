#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/filling.h"
#include "brim/body/particle_fluid/fluid_kernel.h"
#include "brim/body/particle_fluid/fluid_pairs.h"
#include "brim/body/particles/particle_cells.h"

namespace brim {

/// Completes the neighbourhoods of particles at surfaces by mirror images of the particles. With distances d_i and d_j
/// from a plane, the squared distance of a particle from the other's image is |x_ij|² + 4 d_i d_j, so that
///   φ_i += Σ_j ω V W(r_ij)      r_ij² = |x_ij|² + 4 u(d_i) u(d_j)      j = i included
/// A lattice half a spacing off a plane is full, in balance under any uniform pressure, and its resistance to shear is
/// as small as in the bulk, since the missing part is mirrored. As r_ij depends only on the distance of two particles
/// and on theirs from the surface, forces are central between particles and normal between particle and surface: both
/// momenta are exact. Two surfaces also have images of images, to the extent that they are perpendicular.
///   u(d) = d near the surface; grows faster beyond 0.7 spacings, so that nothing beyond 1.2 counts; 0 inside
///   μ(d) = a (d₁ − d)² below d₁ = 0.5 spacings, added to φ_i: images have no slope where they coincide with their
///          particles, so nothing else separates a particle from its own image, and a single particle has no other
///          image to keep it out. It comes to rest at 0.1 spacings.
///   ω    = 1 − d L/2, the mean of both particles, L the Laplacian of the distance, 2/(R + d) for a ball of radius R.
///          The images of a shell have less space inside a ball than outside, (R − d)/(R + d) = 1 − d L of it;
///          floating bodies require half of that, as the layers give way too (docs/bodies/particle_fluid.md).
/// Tests: tests/body/fluid_images_test.cpp
class FluidImages {
 public:
  /// @param spacing  [m] s of the particles @param volume  [m³] of one
  FluidImages(const FluidKernel& kernel, double spacing, double volume)
      : kernel_(kernel), spacing_(spacing), volume_(volume) {}

  double reach() const { return kReach * spacing_; }  ///< d beyond which nothing counts, [m]
  /// u and du/dd, [m] and [-]; both 0 well inside the surface.
  double offset(double d, double& slope) const;
  /// μ and dμ/dd, [-] and [1/m].
  double barrier(double d, double& slope) const;

  /// Reads the surfaces seen, adds their images to φ, and passes the images' effect along x_ij to the pairs.
  /// @param slot  index in cell order of each particle @param fill  φ in cell order
  void build(std::span<const Seen> seen, std::span<const std::int32_t> slot, const ParticleCells& cells,
             FluidPairs& pairs, std::span<double> fill);

  /// Calls f(slot) for the particles near a surface.
  template <class F>
  void for_seeing(const F& f) const {
    for (const std::int32_t s : seeing_) f(static_cast<std::size_t>(s));
  }
  /// rate_i += Σ_k ∂φ_i/∂d_k ḋ_k. @param closing  ḋ_k, [m/s], shape (seen)
  void add_rates(std::span<const double> closing, std::span<float> rate) const;
  /// The same for one particle near a surface.
  double rate_of(std::size_t slot, std::span<const double> closing) const;
  /// push_k = −Σ_i p_i ∂φ_i/∂d_k, [N]. @param p  ∂E/∂φ in cell order, [J]
  void press(std::span<const float> p, std::span<double> push) const;
  /// Σ_i s_i (∂φ_i/∂d_k)², [1/m²].
  double stiffness(std::size_t k, std::span<const float> weight) const;
  /// Calls f(pair, ∂φ_j/∂d_k) for each neighbour's entry, pair: index in FluidPairs of the particle, and f(−1,
  /// ∂φ_i/∂d_k) for the particle itself; a neighbour may occur several times.
  template <class F>
  void for_slopes(std::size_t k, const F& f) const {
    double own = barrier_slope_[k];
    for (const Entry& e : row(k)) {
      own += e.out;
      if (e.pair >= 0)
        f(e.pair, double{e.out});
      else
        own += e.out;
    }
    f(-1, own);
  }
  /// The contacts of a particle in cell order.
  std::span<const std::int32_t> contacts_of(std::size_t slot) const {
    const std::int32_t p = place_[slot];
    if (p < 0) return {};
    return std::span(sorted_).subspan(first_[p], first_[p + 1] - first_[p]);
  }

 private:
  static constexpr double kReach = 1.2;

  /// An image seen by contact k: of the particle of contact `other`, on the same surface.
  struct Entry {
    std::int32_t other;
    std::int32_t pair;  ///< index among the particle's pairs; −1: its own image
    float out;          ///< ∂φ of each of the two particles with respect to d_k, [1/m]
    float in;           ///< the same with respect to the distance of the other
  };
  struct Stretch {  ///< effect of a pair's images along x_ij, as a factor of its own slope
    std::size_t particle;
    std::int32_t pair;
    float factor;
  };
  struct Piece {  ///< of some particles near surfaces: rows of their contacts, in order
    std::vector<Entry> entries;
    std::vector<std::int32_t> length;
    std::vector<Stretch> stretch;
  };
  /// Computes the data of each contact, and lists the contacts of each particle.
  void take(std::span<const Seen> seen, std::span<const std::int32_t> slot);
  /// Adds the images of particle j, over all sets of surfaces near both, to the rows of contacts of i.
  /// @param fill  φ_i, added to @return their contribution to the slope along x_ij divided by the distance, [1/m²]
  double add_images(std::size_t i, std::size_t j, std::int32_t pair, double distance2,
                    std::span<std::vector<Entry>> rows, double& fill) const;
  std::span<const Entry> row(std::size_t k) const { return std::span(entries_).subspan(first_entry_[k], length_[k]); }

  FluidKernel kernel_;
  double spacing_, volume_;
  std::vector<std::int32_t> slot_of_;                                                  ///< per contact
  std::vector<double> u_, u_slope_, barrier_, barrier_slope_, weight_, weight_slope_;  ///< per contact
  std::vector<Vec3> n_;
  std::vector<std::int32_t> part_;
  std::vector<std::int32_t> sorted_;  ///< contacts by particle in cell order
  std::vector<std::int32_t> seeing_;  ///< particles with contacts, cell order
  std::vector<std::size_t> first_;    ///< of sorted_, per entry of seeing_
  std::vector<std::int32_t> place_;   ///< index of each particle in seeing_, −1 for none
  std::vector<Piece> pieces_;
  std::vector<Entry> entries_;
  std::vector<std::size_t> first_entry_;  ///< per contact
  std::vector<std::size_t> length_;
};

}  // namespace brim
