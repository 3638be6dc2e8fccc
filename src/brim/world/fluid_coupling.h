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

/// Solids in fluids on grids (FlowsAround): finds the share that each solid has of every cell and face, and keeps the
/// velocities of a solve among those that keep the volume of every wet cell, D v = 0, D over fluids and solids. With B
/// the preconditioner of all bodies and their contacts,
///   S = D B Dᵀ      preconditioner B (1 − Dᵀ S⁻¹ D B)
/// so that conjugate gradients hardly leave D v = 0 (Gould, Hribar and Nocedal 2001); what they have left it by is
/// mended once at their end. Same bits for any number of threads.  Tests: tests/world/fluid_coupling_test.cpp
class FluidCoupling {
 public:
  /// Finds shares and maps of bodies that have been updated, and tells the fluids; nothing where all is as it was.
  /// @param filter  parts of solids that it keeps from the fluid are not there for it
  /// @param v       [m/s] of all bodies: fluids keep their momentum while solids move in them; or empty
  void find(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts, PartFilter& filter,
            std::span<const double> q, std::span<const std::size_t> first_v, std::span<double> v);
  /// Looks again at all bodies the next time: something moved them that the state does not tell.
  void forget() { found_.clear(), found_q_.clear(), shares_.clear(); }
  bool empty() const { return fluids_.empty(); }
  /// Calls f(body, other body) for every fluid and solid that are coupled.
  template <class F>
  void for_pairs(const F& f) const {
    for (const Fluid& fluid : fluids_)
      for (const Side& side : fluid.sides) f(fluid.body, side.body);
  }

  /// z = B r of all bodies, or of all but the fluids here.
  enum class Of { All, Solids };
  using Invert = std::function<void(std::span<const double> r, std::span<double> z, Of of)>;
  /// Nonzero for fluids that no contact acts on in a solve: B divides by their masses; shape (bodies).
  void set_untouched(std::span<const std::uint8_t> untouched);
  bool flows(std::size_t body) const {
    return std::ranges::any_of(fluids_, [&](const Fluid& f) { return f.body == static_cast<int>(body); });
  }
  /// delta += what makes D (v + delta) = 0, by a pressure that is kept as the first guess.
  void keep_volume(const Invert& invert, std::span<const double> v, std::span<double> delta);
  /// Takes what a pressure resists out of the impulses of a whole system, r += Dᵀ π with D B r = 0, and keeps that
  /// pressure. What is left is what acts among velocities that keep volume, and may be a millionth of what was there.
  void relieve(const Invert& invert, std::span<double> r);
  /// The same of what a solve has left since.
  void resist(const Invert& invert, std::span<double> r);
  /// Relieves what a solve has left of the whole system, and tells the fluids their pressure.
  void finish(const Invert& invert, std::span<double> r);

  /// Hands the momentum that a solve has left of the fluids back to them. @param residual  as finish left it
  void give_back(std::span<const double> residual, std::span<double> delta) const;
  /// Forces of the last solve, of each pair and at each face. @param dt  [s]
  void report(double dt, StepReport& report, std::vector<ContactSample>& samples) const;

 private:
  /// A face of a fluid, and how much of it a solid takes.
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
    bool told = false;  ///< that solids lie in its box
    std::vector<Side> sides;
    std::vector<double> pressure;  ///< [Pa s] that was taken out
    std::vector<double> guess;     ///< [Pa s] that resists what a solve has left
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
  /// The solids' parts of the two.
  void add_solid_flow(Fluid& f, std::span<const double> u, std::span<double> out);
  void push_solids(const Fluid& f, std::span<const double> pressure, std::span<double> impulse);
  /// velocity_ = B Dᵀ π.
  void yield(const Invert& invert, const std::vector<double> Fluid::*pressure);
  void resist(const Invert& invert, double tolerance, std::span<double> r);
  /// y = S p.
  void apply(const Invert& invert);
  /// r = −D u of the fluids. @return the largest, [m³/s]
  double find_excess(std::span<const double> u);
  /// x = S⁻¹ r, from zero. @param tolerance  [m³/s] of the largest flow left
  int solve(const Invert& invert, double tolerance);
  std::span<double> slice(std::span<double> x, int b) const { return x.subspan(first_[b], first_[b + 1] - first_[b]); }
  std::span<const double> slice(std::span<const double> x, int b) const {
    return x.subspan(first_[b], first_[b + 1] - first_[b]);
  }

  std::vector<Fluid> fluids_;
  std::vector<double> found_q_;             ///< state that was looked at
  std::vector<std::int32_t> found_, look_;  ///< parts that were looked at, each fluid's after it
  std::vector<std::size_t> first_;
  std::vector<const Body*> body_;
  bool apart_ = false;  ///< no contact acts on any of the fluids: B is that of solids beside that of fluids
  std::vector<double> impulse_, velocity_;
  std::vector<Vec3> at_points_;
  SolidShares shares_;
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<Eighth>> left_by_filter_;  ///< of fluid and solid
  std::vector<float> octant_;
};

/// True when one of two parts is a fluid that flows around the other, so that no contacts between them are looked for.
bool flows_around(const WorldPart& a, const WorldPart& b);

}  // namespace brim
