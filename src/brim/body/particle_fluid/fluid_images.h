#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/filling.h"
#include "brim/body/particle_fluid/fluid_kernel.h"
#include "brim/body/particle_fluid/fluid_pairs.h"
#include "brim/body/particles/particle_cells.h"

namespace brim {

/// What surfaces take up of the neighbourhoods of particles: the images of the particles behind them. Two particles at
/// distances d_i and d_j of a plane surface are |x_ij|² + 4 d_i d_j, squared, from each other's image, so that
///   φ_i += Σ_j ω V W(r_ij)      r_ij² = |x_ij|² + 4 u(d_i) u(d_j)      j = i included
/// A lattice that lies half a spacing off a plane is full, in balance under any uniform pressure, and resists a change
/// of its shape as little as the bulk does, as what is missing of it is mirrored. Since r_ij depends on the distance of
/// two particles and on theirs from the surface alone, forces are central ones between particles, and act along the
/// normal between particle and surface: momentum of both kinds is exact. Two surfaces also have images of images, as
/// far as they stand upright on each other.
///   u(d) = d near the surface; grows faster from 0.7 spacings on, so that nothing beyond 1.2 is seen; 0 inside
///   μ(d) = a (d₁ − d)² below d₁ = 0.5 spacings, which φ_i has besides: images have no slope where they coincide with
///          their particles, nothing else keeps a particle off its own image, and a lone one has no other to be kept
///          out by. It comes to rest at 0.1 spacings.
///   ω    = 1 − d L/2, the mean of both particles, L the Laplacian of the distance, 2/(R + d) off a ball of radius R.
///          Inside of a ball lies less space than outside for the images of a shell, (R − d)/(R + d) = 1 − d L of it;
///          what floats says half of that, as the layers give way too (docs/bodies/particle_fluid.md).
/// Tests: tests/body/fluid_images_test.cpp
class FluidImages {
 public:
  /// @param spacing  [m] s of the particles @param volume  [m³] of one
  FluidImages(const FluidKernel& kernel, double spacing, double volume)
      : kernel_(kernel), spacing_(spacing), volume_(volume) {}

  double reach() const { return kReach * spacing_; }  ///< d from which on nothing is seen, [m]
  /// u and du/dd, [m] and [-]; both 0 well inside of the surface.
  double offset(double d, double& slope) const;
  /// μ and dμ/dd, [-] and [1/m].
  double barrier(double d, double& slope) const;

  /// Takes in what is seen, adds to φ what it has of it, and lets the pairs know what images do along x_ij.
  /// @param slot  place in cell order of each particle @param fill  φ in cell order
  void build(std::span<const Seen> seen, std::span<const std::int32_t> slot, const ParticleCells& cells,
             FluidPairs& pairs, std::span<double> fill);

  /// Calls f(slot) for the particles that see something.
  template <class F>
  void for_seeing(const F& f) const {
    for (const std::int32_t s : seeing_) f(static_cast<std::size_t>(s));
  }
  /// rate_i += Σ_k ∂φ_i/∂d_k ḋ_k. @param closing  ḋ_k, [m/s], shape (seen)
  void add_rates(std::span<const double> closing, std::span<float> rate) const;
  /// The same of one particle that sees something.
  double rate_of(std::size_t slot, std::span<const double> closing) const;
  /// push_k = −Σ_i p_i ∂φ_i/∂d_k, [N]. @param p  ∂E/∂φ in cell order, [J]
  void press(std::span<const float> p, std::span<double> push) const;
  /// Σ_i s_i (∂φ_i/∂d_k)², [1/m²].
  double stiffness(std::size_t k, std::span<const float> weight) const;
  /// Calls f(pair, ∂φ_j/∂d_k) for each neighbour's entry, pair as FluidPairs counts them for the particle, and
  /// f(−1, ∂φ_i/∂d_k) for the particle itself; a neighbour may come several times.
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

  /// An image that contact k sees: of the particle of contact `other`, on the same surface.
  struct Entry {
    std::int32_t other;
    std::int32_t pair;  ///< of the particle's pairs; −1: its own image
    float out;          ///< ∂φ of each of the two particles by d_k, [1/m]
    float in;           ///< the same by the distance of the other
  };
  struct Stretch {  ///< what the images of a pair do along x_ij, as a factor of its own slope
    std::size_t particle;
    std::int32_t pair;
    float factor;
  };
  struct Piece {  ///< of some particles that see something: rows of their contacts, in order
    std::vector<Entry> entries;
    std::vector<std::int32_t> length;
    std::vector<Stretch> stretch;
  };
  /// Takes in what each contact has of itself, and which contacts a particle has.
  void take(std::span<const Seen> seen, std::span<const std::int32_t> slot);
  /// Adds the images of particle j, over all sets of surfaces that both see, to the rows of contacts of i.
  /// @param fill  φ_i, added to @return what they add to the slope along x_ij over the distance, [1/m²]
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
  std::vector<std::int32_t> place_;   ///< in seeing_ of each particle, −1
  std::vector<Piece> pieces_;
  std::vector<Entry> entries_;
  std::vector<std::size_t> first_entry_;  ///< per contact
  std::vector<std::size_t> length_;
};

}  // namespace brim
