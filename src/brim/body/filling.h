#pragma once

#include <cstdint>
#include <span>

#include "brim/math/types.h"

namespace brim {

/// An element of a filling body near another part.
struct Seen {
  std::int32_t element = 0;  ///< of the filling body
  std::int32_t part = 0;     ///< the other part
  double distance = 0.0;     ///< [m] d, signed distance of the element from the part's surface
  Vec3 n = Vec3::Zero();     ///< ∇d: from the surface to the element
  double bend = 0.0;         ///< [1/m] Laplacian of d: twice the mean curvature, positive when the surface is convex
};

/// Optional interface of bodies that fill the space between solids, as fluids do: rho_solid + rho_fluid <= 1, enforced
/// by the body's own pressure (docs/numerics.md). The body's energy depends on the distances d_k of its elements from
/// nearby surfaces; with push_k = −∂E/∂d_k,
///   d' = n_k · Δ_k,    force on the element push_k n_k, its opposite on the other part
/// with Δ_k = v_element − v_other, so that pressure and its reaction derive from one energy. The force on the element
/// acts through the contact maps like that of any contact; the body itself adds none.
class Filling {
 public:
  virtual ~Filling() = default;

  /// [m] positions of the elements in the last updated state.
  virtual std::span<const Vec3> fill_places() const = 0;
  /// [m] signed distance beyond which a surface has no effect.
  virtual double fill_reach() const = 0;
  /// [m] distance at which an element lies against a surface.
  virtual double fill_gap() const = 0;
  /// Source to pass to make_map for the element itself.
  static std::int32_t source_of(std::int32_t element) { return -2 - element; }
  static std::int32_t element_of(std::int32_t source) { return -2 - source; }

  /// Sets the nearby surfaces; valid until the next call, which follows every update.
  virtual void see(std::span<const Seen> seen) = 0;
  /// Reads the motion at the start of a step: elements that will be full by its end are resisted from the start.
  /// @param rate  of d_k, [m/s]
  virtual void foresee(double dt, std::span<const double> v, std::span<const double> rate) = 0;
  /// push_k at the state of the last update, [N]; shape (seen).
  virtual void press(std::span<double> push) const = 0;
  /// Body::apply_stiffness with the motion of surfaces: y += (∂Q/∂q) x, change_k = rate of push_k in the motion, [N/s].
  /// @param rate  of d_k, [m/s]
  virtual void apply_stiffness_seeing(std::span<const double> x, std::span<const double> rate, std::span<double> y,
                                      std::span<double> change) const = 0;
  /// Body::apply_system likewise: y += A x, change_k = dt² times that of push_k, [N s].
  virtual void apply_system_seeing(std::span<const double> x, std::span<const double> rate, std::span<double> y,
                                   std::span<double> change) const = 0;
  /// Stiffness of contact k along n_k in the system of a step dt, dt² ∂²E/∂d_k², [kg]; for preconditioners, available
  /// before begin_solve.
  virtual double fill_stiffness(std::size_t k, double dt) const = 0;
  /// [N s/m] tangential drag: a viscous fluid sticks to the surfaces it touches.
  virtual double fill_drag(std::size_t k) const = 0;
};

}  // namespace brim
