#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/flows_around.h"
#include "brim/world/solid_shares.h"
#include "brim/world/step_report.h"
#include "brim/world/world_part.h"

namespace brim {

class PartFilter;

/// Solids in fluids on grids (FlowsAround): finds the fraction of every cell and face that each solid takes, and keeps
/// the velocities of a solve in the space that conserves the volume of every wet cell, D v = 0, D over fluids and
/// solids. With B
/// the preconditioner of all bodies and their contacts,
///   S = D B Dᵀ      preconditioner B (1 − Dᵀ S⁻¹ D B)
/// so that conjugate gradients hardly leave D v = 0 (Gould, Hribar and Nocedal 2001); the drift is corrected once at
/// their end. Same bits for any number of threads.  Tests: tests/world/fluid_coupling_test.cpp
class FluidCoupling {
 public:
  /// Finds fractions and maps of updated bodies and passes them to the fluids; no work when nothing has changed.
  /// @param filter  parts of solids excluded by it do not exist for the fluid
  /// @param v       [m/s] of all bodies: fluids keep their momentum while solids move in them; or empty
  void find(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts, PartFilter& filter,
            std::span<const double> q, std::span<const std::size_t> first_v, std::span<double> v);
  /// Forces a new search for all bodies the next time, after a motion that the state does not show.
  void forget() { found_.clear(), found_q_.clear(), shares_.clear(); }
  bool empty() const { return fluids_.empty(); }
  /// Calls f(body, other body) for every fluid and solid that are coupled.
  template <class F>
  void for_pairs(const F& f) const {
    for (const Fluid& fluid : fluids_)
      for (const Side& side : fluid.sides) f(fluid.body, side.body);
  }

  /// z = B r of all bodies, or of all except these fluids.
  enum class Of { All, Solids };
  using Invert = std::function<void(std::span<const double> r, std::span<double> z, Of of)>;
  /// Nonzero for fluids without contact in a solve: for them B divides by their masses; shape (bodies).
  void set_untouched(std::span<const std::uint8_t> untouched);
  bool flows(std::size_t body) const {
    return std::ranges::any_of(fluids_, [&](const Fluid& f) { return f.body == static_cast<int>(body); });
  }
  /// Changes delta so that D (v + delta) = 0, by a pressure that is kept as the next initial guess.
  void keep_volume(const Invert& invert, std::span<const double> v, std::span<double> delta);
  /// Removes from the impulses of a whole system the part balanced by pressure, r += Dᵀ π with D B r = 0, and keeps
  /// that pressure. What remains acts on volume-conserving velocities, and may be a millionth of the original.
  void relieve(const Invert& invert, std::span<double> r);
  /// The same for the residual of a solve.
  void resist(const Invert& invert, std::span<double> r);
  /// Relieves the residual of the whole system and passes the pressure to the fluids.
  void finish(const Invert& invert, std::span<double> r);

  /// Gives the fluids the momentum missing after a solve. @param residual  as left by finish
  void give_back(std::span<const double> residual, std::span<double> delta) const;
  /// Forces of the last solve, per pair and per face. @param dt  [s]
  void report(double dt, StepReport& report, std::vector<ContactSample>& samples) const;

 private:
  /// A face of a fluid and the area of it taken by a solid.
  struct Row {
    std::int32_t low, high;  ///< wet cells on its sides, or −1
    std::int32_t axis;
    double area;  ///< [m²]
  };
  struct Side {
    std::int32_t part = 0;
    int body = 0;
    const std::vector<Eighth>* eighths = nullptr;
    std::vector<Row> rows;
    std::vector<Vec3> points;
    std::unique_ptr<Map> map;
  };
  struct Fluid {
    FlowsAround* flow = nullptr;
    std::int32_t part = 0;
    int body = 0;
    bool told = false;  ///< it knows of the solids in its box
    std::vector<Side> sides;
    std::vector<double> pressure;  ///< [Pa s] removed by relieve
    std::vector<double> guess;     ///< [Pa s] balancing the residual of a solve
    std::vector<double> x, r, p, y, z;
  };
  /// The fluids, and the solids that they may flow around.
  std::vector<Fluid> find_fluids(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts) const;
  void find_shares(Fluid& fluid, std::span<const WorldPart> parts, PartFilter& filter);
  void find_rows(Fluid& fluid, std::span<const WorldPart> parts);
  /// out = D u.
  void flow(std::span<const double> u, std::vector<double> Fluid::*out);
  /// impulse += Dᵀ π.
  void push(const std::vector<double> Fluid::*pressure, std::span<double> impulse);
  /// The solids' parts of flow and push.
  void add_solid_flow(Fluid& f, std::span<const double> u, std::span<double> out);
  void push_solids(const Fluid& f, std::span<const double> pressure, std::span<double> impulse);
  /// velocity_ = B Dᵀ π.
  void yield(const Invert& invert, const std::vector<double> Fluid::*pressure);
  void resist(const Invert& invert, double tolerance, std::span<double> r);
  /// y = S p.
  void apply(const Invert& invert);
  /// r = −D u of the fluids. @return the largest, [m³/s]
  double find_excess(std::span<const double> u);
  /// x = S⁻¹ r, from zero. @param tolerance  [m³/s] of the largest remaining flow
  int solve(const Invert& invert, double tolerance);
  std::span<double> slice(std::span<double> x, int b) const { return x.subspan(first_[b], first_[b + 1] - first_[b]); }
  std::span<const double> slice(std::span<const double> x, int b) const {
    return x.subspan(first_[b], first_[b + 1] - first_[b]);
  }

  std::vector<Fluid> fluids_;
  std::vector<double> found_q_;             ///< state at the last search
  std::vector<std::int32_t> found_, look_;  ///< parts considered, each fluid's after it
  std::vector<std::size_t> first_;
  std::vector<const Body*> body_;
  bool apart_ = false;  ///< no fluid has contacts: B is that of solids next to that of fluids
  std::vector<double> impulse_, velocity_;
  std::vector<Vec3> at_points_;
  SolidShares shares_;
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<Eighth>> left_by_filter_;  ///< of fluid and solid
  std::vector<float> octant_;
};

/// True when one of two parts is a fluid that flows around the other, so that contacts between them are not searched.
bool flows_around(const WorldPart& a, const WorldPart& b);

}  // namespace brim
