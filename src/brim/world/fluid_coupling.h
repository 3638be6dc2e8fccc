#pragma once

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/flows_around.h"
#include "brim/grid/tile.h"
#include "brim/raster/shape.h"
#include "brim/world/step_report.h"
#include "brim/world/world_part.h"

namespace brim {

class BlockDiagonal;
class PosedShape;

/// Solids in fluids on grids (FlowsAround): finds the share that each solid has of every cell and face, and keeps the
/// velocities of a solve among those that keep the volume of every wet cell, D v = 0, D over fluids and solids. With B
/// a preconditioner of all bodies by themselves, G its simple part (masses of faces, diagonal blocks of solids),
///   S = D G⁻¹ Dᵀ      Π = 1 − G⁻¹ Dᵀ S⁻¹ D      preconditioner Π B Πᵀ
/// so that conjugate gradients never leave D v = 0 (Gould, Hribar and Nocedal 2001).
/// Same bits for any number of threads.  Tests: tests/world/fluid_coupling_test.cpp
class FluidCoupling {
 public:
  /// Finds shares and maps of bodies that have been updated, and tells the fluids; nothing where all is as it was.
  /// @param v  [m/s] of all bodies: fluids keep their momentum while solids move in them; or empty
  void find(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts, std::span<const double> q,
            std::span<const std::size_t> first_v, std::span<double> v);
  /// Looks again at all bodies the next time: something moved them that the state does not tell.
  void forget() { found_.clear(), found_q_.clear(), shares_.clear(); }
  bool empty() const { return fluids_.empty(); }
  /// Calls f(body, other body) for every fluid and solid that are coupled.
  template <class F>
  void for_pairs(const F& f) const {
    for (const Fluid& fluid : fluids_)
      for (const Side& side : fluid.sides) f(fluid.body, side.body);
  }

  /// Takes G, once the diagonal is factored. @param held  nonzero for bodies that nothing moves, shape (bodies) or
  /// empty
  void prepare(const BlockDiagonal& diagonal, std::span<const std::size_t> first_block,
               std::span<const std::uint8_t> held);
  /// delta += what makes D (v + delta) = 0, with the least change in G.
  void start(std::span<const double> v, std::span<double> delta);
  /// r ← Πᵀ r: takes what a pressure resists out of the impulses of a whole system, and keeps that pressure. What is
  /// left is what acts among velocities that keep volume, and may be a millionth of what was there.
  void relieve(std::span<double> r);
  /// The same of what a solve has left since.
  void resist(std::span<double> r);
  /// z ← Π z.
  void correct(std::span<double> z);
  /// Relieves what a solve has left of the whole system, and tells the fluids their pressure.
  void finish(std::span<double> r);

  /// Hands the momentum that a solve has left of the fluids back to them. @param residual  as finish left it
  void give_back(std::span<const double> residual, std::span<double> delta) const;
  /// Forces of the last solve. @param dt  [s]
  void report(double dt, StepReport& report) const;
  std::size_t rows() const { return rows_; }

 private:
  /// What one solid has of eighths of cells.
  struct Eighth {
    std::int32_t place;
    float share;
    std::int32_t source;
  };
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
    std::vector<Side> sides;
    std::vector<double> pressure;  ///< [Pa s] that was taken out
    std::vector<double> guess;     ///< [Pa s] that resists what a solve has left
    std::vector<double> x, r, p, y, z;
  };
  /// The fluids, and the solids that they may flow around.
  std::vector<Fluid> find_fluids(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts) const;
  /// @param grid  of the fluid  @param solid  the part as a shape, or null
  /// @param out   eighths of the fluid's cells that the part has something of
  void sample(const MacGrid& grid, const WorldPart& part, const PosedShape* solid, std::vector<Eighth>& out);
  void find_shares(Fluid& fluid, std::span<const WorldPart> parts);
  void find_rows(Fluid& fluid, std::span<const WorldPart> parts);
  /// out = D u.
  void flow(std::span<const double> u, std::vector<double> Fluid::*out);
  /// impulse += Dᵀ π.
  void push(const std::vector<double> Fluid::*pressure, std::span<double> impulse);
  /// The solids' parts of the two.
  void add_solid_flow(Fluid& f, std::span<const double> u, std::span<double> out);
  void push_solids(const Fluid& f, std::span<const double> pressure, std::span<double> impulse);
  /// z = G⁻¹ r on coupled bodies.
  void divide(std::span<const double> r, std::span<double> z);
  void divide_solids(std::span<const double> r, std::span<double> z);
  /// y += D_s G⁻¹ D_sᵀ p over the solids.
  void add_yield();
  /// x = S⁻¹ b, from zero, b in `r` and x in `x` of the fluids. @param tolerance  [m³/s] of the largest flow left
  int solve(double tolerance);
  std::span<double> slice(std::span<double> x, int b) const { return x.subspan(first_[b], first_[b + 1] - first_[b]); }
  std::span<const double> slice(std::span<const double> x, int b) const {
    return x.subspan(first_[b], first_[b + 1] - first_[b]);
  }

  std::vector<Fluid> fluids_;
  std::vector<double> found_q_;             ///< state that was looked at
  std::vector<std::int32_t> found_, look_;  ///< parts that were looked at, each fluid's after it
  std::vector<std::size_t> first_;
  std::vector<int> solids_;  ///< bodies that some fluid is coupled to, each once
  std::vector<const Body*> body_;
  std::size_t rows_ = 0;
  const BlockDiagonal* diagonal_ = nullptr;
  std::vector<std::size_t> first_block_;
  std::vector<std::uint8_t> held_;
  std::vector<double> impulse_, velocity_, own_;
  std::vector<Vec3> at_points_;

  struct Shares {
    const Body* body = nullptr;
    Vec3 origin = Vec3::Zero();  ///< [m] of the fluid's grid
    Pose pose;
    std::vector<Eighth> eighths;
  };
  std::map<std::pair<std::int32_t, std::int32_t>, Shares> shares_;  ///< of fluid and solid
  std::vector<float> octant_;
  std::vector<TileKey> tiles_;
  std::vector<DensityBlock> blocks_;
};

/// True when one of two parts is a fluid that flows around the other, so that no contacts between them are looked for.
bool flows_around(const WorldPart& a, const WorldPart& b);

}  // namespace brim
