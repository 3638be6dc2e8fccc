#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/flows_around.h"
#include "brim/map/map.h"
#include "brim/world/solid_shares.h"
#include "brim/world/world_part.h"

namespace brim {

/// Drag on solids that the grid of a fluid does not resolve: the flow of a coarse grid slips around them, so that
/// nothing but waves would slow them down. As in flows of two phases (Anderson and Jackson 1967), the matter in each
/// cell exchanges momentum with the fluid around it,
///   f = k (W v_fluid − J v_solid)   k = ρ V γ   γ = C_d |u| A / (2 V)
/// V the solid's volume in the cell, u the velocity in brackets, W a mean over the free faces around. Balls have the
/// drag of Schiller and Naumann (1933) with Newton's 0.44 at least, lines that of a cylinder across the flow (White
/// 2006). The force is part of the implicit system, with k as at its start; both sides feel it, so that momentum is
/// exact. Same bits for any number of threads.  Tests: tests/world/fluid_drag_test.cpp
class FluidDrag {
 public:
  void clear() { pairs_.clear(); }
  /// Adds a solid of a fluid, both updated, unless the grid resolves it.
  /// @param fluid  number of its body  @param part  number of the solid's part
  void add(const FlowsAround& flow, int fluid, const WorldPart& solid, std::int32_t part,
           std::span<const Eighth> eighths);

  /// Sets k from the velocities of all bodies, [m/s]; first_v has the first velocity of each body.
  void begin(std::span<const double> v, std::span<const std::size_t> first_v);
  /// impulse −= dt Cᵀ k C v with C v = J v_solid − W v_fluid.
  void add_impulse(double dt, std::span<const double> v, std::span<double> impulse) { add(-dt, v, impulse); }
  /// y += dt Cᵀ k C x.
  void add_product(double dt, std::span<const double> x, std::span<double> y) { add(dt, x, y); }
  /// Calls f(x, force [N] on the solid at x) at velocities v, for a solid of a fluid.
  template <class F>
  void for_forces(int fluid, std::int32_t part, std::span<const double> v, const F& f) {
    for (const Pair& p : pairs_) {
      if (p.fluid != fluid || p.part != part) continue;
      find_slip(p, v);
      for (std::size_t i = 0; i < p.at.size(); ++i) f(p.at[i], Vec3(-p.k[i] * slip_[i]));
    }
  }

 private:
  struct Pair {
    int fluid = 0, body = 0;
    std::int32_t part = 0;
    double density = 0.0;                   ///< [kg/m³] of the fluid
    double viscosity = 0.0;                 ///< [m²/s] of the fluid, kinematic
    double thickness = 0.0;                 ///< [m] of the solid
    double share = 1.0;                     ///< of the drag that the grid leaves out, (0, 1]
    bool lines = false;                     ///< the solid is made of lines
    bool grains = false;                    ///< balls among others
    std::vector<Vec3> at;                   ///< [m] middle of the solid's matter in a cell
    std::vector<double> volume, k;          ///< [m³], [kg/s], per place
    std::vector<double> open;               ///< share of the faces around a place that is open to the fluid, (0, 1]
    std::vector<std::int32_t> first, face;  ///< faces of place i, axis a: first[3 i + a] to first[3 i + a + 1]
    std::vector<double> weight;             ///< of each, Σ = 1; none where there is no fluid
    std::unique_ptr<Map> map;
  };
  /// Finds the free faces around the places of a pair.
  static void find_faces(const FlowsAround& flow, Pair& pair);
  /// slip_ = C v of a pair; zero along axes without fluid.
  void find_slip(const Pair& p, std::span<const double> v);
  void add(double factor, std::span<const double> x, std::span<double> y);

  std::vector<Pair> pairs_;
  std::vector<std::size_t> first_v_;
  std::vector<Vec3> slip_;
};

}  // namespace brim
