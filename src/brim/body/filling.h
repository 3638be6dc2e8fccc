#pragma once

#include <cstdint>
#include <span>

#include "brim/math/types.h"

namespace brim {

/// What one element of a filling body sees of another part.
struct Seen {
  std::int32_t element = 0;   ///< of the filling body
  double fill = 0.0;          ///< [-] λ: the share of the element's neighbourhood that the part takes up
  Vec3 slope = Vec3::Zero();  ///< [1/m] ∇λ by the element's place, towards the part
};

/// Optional interface of bodies that fill what solids leave, as fluids do: rho_solid + rho_fluid <= 1, answered by the
/// body's own pressure (docs/numerics.md). With φ_i the fill of element i, what it sees of others included, and p_k the
/// derivative of the body's energy by that fill at contact k,
///   dφ_i = (own part) + Σ_k ∇λ_k · Δ_k,    force on the element −p_k ∇λ_k, its opposite on the other part
/// with Δ_k = v_element − v_other, so that pressure and its reaction are the derivative of one energy. The force on
/// the element acts through the contact maps like any contact's: the body itself adds none.
class Filling {
 public:
  virtual ~Filling() = default;

  /// [m] of the elements in the last updated state.
  virtual std::span<const Vec3> fill_places() const = 0;
  /// [m] signed distance to a surface from which on nothing is seen of it.
  virtual double fill_reach() const = 0;
  /// λ of a surface at a signed distance d < fill_reach(), [-]; slope: dλ/dd, [1/m], at most 0.
  virtual double fill_of(double d, double& slope) const = 0;
  /// [m] distance at which an element lies against a surface.
  virtual double fill_gap() const = 0;
  /// What make_map takes for the element itself.
  static std::int32_t source_of(std::int32_t element) { return -2 - element; }
  static std::int32_t element_of(std::int32_t source) { return -2 - source; }

  /// Takes in what is seen of others; counts until the next call, which follows every update.
  virtual void see(std::span<const Seen> seen) = 0;
  /// Takes in the motion at the start of a step: what will be full by its end is resisted from the start.
  /// @param rate  ∇λ_k · Δ_k, [1/s]
  virtual void foresee(double dt, std::span<const double> v, std::span<const double> rate) = 0;
  /// p_k at the state of the last update, [J]; shape (seen).
  virtual void press(std::span<double> push) const = 0;
  /// Body::apply_stiffness with what others do to the fill: y += (∂Q/∂q) x, push_k = dp_k of the motion, [J/s].
  /// @param rate  ∇λ_k · Δ_k, [1/s]
  virtual void apply_stiffness_seeing(std::span<const double> x, std::span<const double> rate, std::span<double> y,
                                      std::span<double> push) const = 0;
  /// Body::apply_system likewise: y += A x, push_k = dt² dp_k.
  virtual void apply_system_seeing(std::span<const double> x, std::span<const double> rate, std::span<double> y,
                                   std::span<double> push) const = 0;
  /// Stiffness of contact k in the system of a step dt along ∇λ_k, per |∇λ_k|²: dt² ∂²E/∂φ_i², [J s²]; for
  /// preconditioners, and known before begin_solve.
  virtual double fill_stiffness(std::size_t k, double dt) const = 0;
};

}  // namespace brim
