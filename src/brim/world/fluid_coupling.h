#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/flows_around.h"
#include "brim/world/fluid_drag.h"
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
  /// To be called when B has been made anew.
  void renew() { yield_known_ = yield_known_ && apart_; }
  bool flows(std::size_t body) const {
    return std::ranges::any_of(fluids_, [&](const Fluid& f) { return f.body == static_cast<int>(body); });
  }
  /// True when done(body) for all fluids.
  template <class F>
  bool all_done(const F& done) const {
    return std::ranges::all_of(fluids_, [&](const Fluid& f) { return done(static_cast<std::size_t>(f.body)); });
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
  /// Of the solids found that the grid does not resolve.
  FluidDrag& drag() { return drag_; }
  /// Forces of the last solve, per pair and per face. @param dt  [s]
  /// @param v  [m/s] after it, of all bodies
  void report(double dt, std::span<const double> v, StepReport& report, std::vector<ContactSample>& samples);

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
    std::vector<double> pressure;       ///< [Pa s] removed by relieve
    std::vector<double> guess;          ///< [Pa s] balancing the residual of a solve
    std::vector<double> x, r, p, y, z;  ///< per cell, zero where it is not wet
    /// Z and M⁻¹ Z of find_yield, one row per wet cell.
    Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> flows, yield;
    Eigen::VectorXf at_wet;
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
  void add_solid_flow(Side& s, std::span<const double> u, std::span<double> out);
  void push_solids(const Fluid& f, std::span<const double> pressure, std::span<double> impulse);
  /// Finds how solids that move as wholes give way to pressure. With M ≈ the fluids' own part of S, the columns Z = D u
  /// of the motions u that have much added mass, and C = (uᵀ A u)⁻¹,
  ///   S⁻¹ ≈ (M + Z C Zᵀ)⁻¹ = M⁻¹ − M⁻¹ Z (C⁻¹ + Zᵀ M⁻¹ Z)⁻¹ Zᵀ M⁻¹
  /// Deformable solids give way in too many ways to be told like this.
  void find_yield();
  /// Solids that move as wholes, those with most faces in fluids first.
  std::vector<int> yielding_solids() const;
  /// The column of the motion in impulse_. @return its added mass zᵀ M⁻¹ z
  double find_column(int body, Eigen::Index column);
  /// z = that, applied to r.
  void invert_flows();
  /// velocity_ = B Dᵀ π.
  void yield(const Invert& invert, const std::vector<double> Fluid::*pressure);
  /// @param tolerance  of the flow that is left, relative to that without the new pressure
  /// @param floor      [m³/s] flow that may be left anyway
  void resist(const Invert& invert, double tolerance, double floor, std::span<double> r);
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
  bool yield_known_ = false;
  Eigen::LLT<Eigen::MatrixXd> yield_;  ///< of C⁻¹ + Zᵀ M⁻¹ Z
  bool apart_ = false;                 ///< no fluid has contacts: B is that of solids next to that of fluids
  std::vector<double> impulse_, velocity_;
  std::vector<Vec3> at_points_;
  SolidShares shares_;
  FluidDrag drag_;
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<Eighth>> left_by_filter_;  ///< of fluid and solid
  std::vector<float> octant_;
};

/// True when one of two parts is a fluid that flows around the other, so that contacts between them are not searched.
bool flows_around(const WorldPart& a, const WorldPart& b);

}  // namespace brim
