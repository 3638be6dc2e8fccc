#pragma once

#include <cstdint>
#include <span>

#include "brim/math/types.h"

namespace brim {

/// What one element of a filling body sees of another part.
struct Seen {
  std::int32_t element = 0;  ///< of the filling body
  std::int32_t part = 0;     ///< which one it sees
  double distance = 0.0;     ///< [m] d, signed, of the element from the part's surface
  Vec3 n = Vec3::Zero();     ///< ∇d: from the surface to the element
  double bend = 0.0;         ///< [1/m] Laplacian of d: twice the mean curvature, positive where the surface bulges
};

/// Optional interface of bodies that fill what solids leave, as fluids do: rho_solid + rho_fluid <= 1, answered by the
/// body's own pressure (docs/numerics.md). The body's energy depends on the distances d_k of its elements from the
/// surfaces that they see; with push_k = −∂E/∂d_k,
///   d' = n_k · Δ_k,    force on the element push_k n_k, its opposite on the other part
/// with Δ_k = v_element − v_other, so that pressure and its reaction are the derivative of one energy. The force on
/// the element acts through the contact maps like any contact's: the body itself adds none.
class Filling {
 public:
  virtual ~Filling() = default;

  /// [m] of the elements in the last updated state.
  virtual std::span<const Vec3> fill_places() const = 0;
  /// [m] signed distance to a surface from which on nothing is seen of it.
  virtual double fill_reach() const = 0;
  /// [m] distance at which an element lies against a surface.
  virtual double fill_gap() const = 0;
  /// What make_map takes for the element itself.
  static std::int32_t source_of(std::int32_t element) { return -2 - element; }
  static std::int32_t element_of(std::int32_t source) { return -2 - source; }

  /// Takes in what is seen of others; counts until the next call, which follows every update.
  virtual void see(std::span<const Seen> seen) = 0;
  /// Takes in the motion at the start of a step: what will be full by its end is resisted from the start.
  /// @param rate  of d_k, [m/s]
  virtual void foresee(double dt, std::span<const double> v, std::span<const double> rate) = 0;
  /// push_k at the state of the last update, [N]; shape (seen).
  virtual void press(std::span<double> push) const = 0;
  /// Body::apply_stiffness with what others do to the fill: y += (∂Q/∂q) x, change_k = that of push_k by the motion,
  /// [N/s]. @param rate  of d_k, [m/s]
  virtual void apply_stiffness_seeing(std::span<const double> x, std::span<const double> rate, std::span<double> y,
                                      std::span<double> change) const = 0;
  /// Body::apply_system likewise: y += A x, change_k = dt² times that of push_k, [N s].
  virtual void apply_system_seeing(std::span<const double> x, std::span<const double> rate, std::span<double> y,
                                   std::span<double> change) const = 0;
  /// Stiffness of contact k in the system of a step dt along n_k, dt² ∂²E/∂d_k², [kg]; for preconditioners, and known
  /// before begin_solve.
  virtual double fill_stiffness(std::size_t k, double dt) const = 0;
  /// [N s/m] force along the surface against the motion along it: what is viscous sticks to what it touches.
  virtual double fill_drag(std::size_t k) const = 0;
};

}  // namespace brim
