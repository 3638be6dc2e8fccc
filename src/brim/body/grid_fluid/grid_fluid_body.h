#pragma once

#include <functional>

#include "brim/body/body.h"
#include "brim/body/changing_surface.h"
#include "brim/body/flow_places.h"
#include "brim/body/flows_around.h"
#include "brim/body/grid_fluid/face_map.h"
#include "brim/body/grid_fluid/face_transport.h"
#include "brim/body/grid_fluid/level_set.h"
#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/body/grid_fluid/momentum_keeper.h"
#include "brim/body/grid_fluid/pressure_projection.h"
#include "brim/body/grid_fluid/touched_cells.h"
#include "brim/body/grid_fluid/wet_faces.h"
#include "brim/body/known_volume.h"
#include "brim/body/movable_base.h"
#include "brim/body/moving_display.h"
#include "brim/body/restless.h"
#include "brim/body/touched_surface.h"
#include "brim/body/walled.h"

namespace brim {

/// Material, grid and initial state of a grid fluid.
struct GridFluidModel {
  MacGrid grid;
  std::array<bool, 6> open{};  ///< sides −x, +x, −y, +y, −z, +z of the box through which fluid may leave
  /// Signed distance to the fluid at the start, negative inside, [m]; need not be exact away from the surface.
  std::function<double(const Vec3&)> distance;
  std::function<Vec3(const Vec3&)> velocity;  ///< [m/s] at the start; empty: at rest
  double density = 1000.0;                    ///< [kg/m³]
  double viscosity = 0.0;                     ///< [Pa s] dynamic
  double voxel_size = 0.0;                    ///< [m] 0: the side of a cell
  Material material;
};

/// Incompressible fluid on a staggered grid in a box, with a free surface at zero pressure.
///   q = level set at the cells, then the volume to be kept [m³];   v = face velocities [m/s]
/// Volume is conserved twice. In the common solve the body's preconditioner maps any impulse to velocities that
/// conserve the volume of every wet cell, so conjugate gradients stay in that space, and pressure, contact and all
/// solids are solved together. After it the level set is advected, and shifted along its normal by the volume lost. It
/// moves with the material at the surface; where touched, with the velocity used by contact: if the two differed,
/// contact would do work on a surface that does not move. Fluid slips at the box's closed sides.
class GridFluidBody final : public Body,
                            public Walled,
                            public ChangingSurface,
                            public FlowPlaces,
                            public Restless,
                            public TouchedSurface,
                            public FlowsAround,
                            public IdleVelocities,
                            public MovableBase,
                            public KnownVolume,
                            public MovingDisplay {
 public:
  /// @throws InputError for a grid without cells, or values out of range
  explicit GridFluidBody(GridFluidModel model);

  std::string_view kind() const override { return "grid_fluid"; }
  bool restless() const override { return true; }
  const char* refuses_turn(const Mat3& R) const override {
    return R == Mat3::Identity() ? "" : "lies along the axes of the world";
  }
  void set_base(const Pose& from_start) override;
  std::size_t q_size() const override { return model_.grid.cells() + 1; }
  std::size_t v_size() const override { return model_.grid.faces(); }
  void initial_state(std::span<double> q, std::span<double> v) const override;
  void update(double time, std::span<const double> q, std::span<const double> v) override;
  void advance(double dt, std::span<double> q, std::span<const double> v) const override;
  void finish_step(double time, double dt, std::span<double> q, std::span<double> v) override;

  void add_forces(const Environment& env, std::span<double> Q) const override;
  void apply_mass(std::span<const double> x, std::span<double> y) const override;
  void apply_damping(std::span<const double> x, std::span<double> y) const override;
  void apply_system(std::span<const double> x, std::span<double> y) const override;
  std::vector<int> block_sizes() const override { return std::vector<int>(model_.grid.faces() / 3, 3); }
  void add_system_diagonal(std::size_t first, BlockDiagonal& D) const override;
  void prepare_preconditioner(std::size_t first, const BlockDiagonal& D) override;
  void precondition(std::size_t first, const BlockDiagonal& D, std::span<const double> r,
                    std::span<double> z) const override;
  void filter(std::span<double> x) const override;

  PartInfo part(int) const override { return part_; }
  Aabb bounds(int) const override { return bounds_; }
  Vec3 mean_velocity(int, std::span<const double> v) const override;
  double relative_speed_bound(int, std::span<const double> v) const override;
  void presence(int, double h, double w, const Aabb& region, std::vector<TileKey>& out) const override;
  void rasterize(int, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const override;
  void make_map(int, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const override;

  double mass() const override { return model_.density * start_volume_; }
  double potential_energy(const Environment& env) const override;
  Vec3 linear_momentum(std::span<const double> v) const override;
  Vec3 angular_momentum(std::span<const double> v) const override;
  bool confined() const override { return wet_.touches_walls; }
  void note_impulse(std::span<const double> impulse) override;
  void note_contacts(std::span<const Vec3> points, std::span<const std::uint8_t> by_fluid) override {
    touched_.note(model_.grid, points, by_fluid);
  }
  Vec3 wall_impulse() const override { return wall_impulse_; }

  std::span<const VelocityRange> idle_velocities() const override { return wet_.idle; }

  const MacGrid& flow_grid() const override { return model_.grid; }
  double flow_density() const override { return model_.density; }
  double flow_viscosity() const override { return model_.viscosity; }
  bool flows_around(const PartInfo& other) const override;
  void set_solids(std::span<const float> octant, std::span<double> v) override;
  bool has_taken_solids() const override { return solids_taken_; }
  bool is_wet(int cell) const override { return wet_.cell[cell] != 0; }
  std::span<const std::int32_t> wet_cells() const override { return wet_.wet; }
  double open_share(int face) const override { return wet_.open[face]; }
  double flowing_share(int face) const override {
    return wet_.kind[face] == WetFaces::Kind::Free ? wet_.open[face] * wet_.share[face] : 0.0;
  }
  void add_flow(std::span<const double> u, std::span<double> out) const override { solver_.flow(u, out); }
  void add_push(std::span<const double> pressure, std::span<double> impulse) const override {
    solver_.add_push(pressure, impulse);
  }
  void divide_by_mass(std::span<const double> r, std::span<double> z) const override { solver_.divide_by_mass(r, z); }
  void apply_poisson(std::span<const double> x, std::span<double> y) override { solver_.poisson().multiply(x, y); }
  void invert_poisson(std::span<const double> r, std::span<double> z) override { solver_.poisson().cycle(r, z); }
  void take_pressure(std::span<const double> pressure) override { impulse_.assign(pressure.begin(), pressure.end()); }
  bool rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const override;

  const Display& display() const override { return display_; }
  void display_positions(std::span<Vec3f>) const override {}
  void display_surface(std::vector<Vec3f>& x, std::vector<Triangle>& triangles) const override;
  /// Of the surface and the material along it.
  void display_velocities(std::span<const double> v, std::span<const Vec3f> x, std::span<Vec3f> u) const override;
  bool meets_air(const Vec3& x) const override;
  void velocity_places(std::span<Vec3> x) const override;

  // ---- of the last update, for tests and tools -------------------------------------------------------------------
  const MacGrid& grid() const { return model_.grid; }
  const WetFaces& wet() const { return wet_; }
  std::span<const double> level_set() const { return phi_; }
  /// Distance to the fluid at x: the level set within the box, [m].
  double distance(const Vec3& x) const;
  double volume() const override;
  /// [Pa] per cell, found by the last solve; zero in dry cells.
  double pressure(int cell) const { return dt_ > 0.0 ? impulse_[cell] / dt_ : 0.0; }
  /// Largest flow out of a wet cell divided by its size, [1/s].
  double divergence(std::span<const double> v) const;

 private:
  void take_level_set(std::span<const double> q);
  /// Finds the wet cells of phi_ and derived data.
  void find_wet();
  /// Continues phi_ into solids, with the surface perpendicular to theirs, and closes gaps thinner than half a cell
  /// between the two.
  void extend_into_solids();
  /// Gives cells beside known ones the mean of these. @param only_open  through open faces alone
  /// @return false when there are no such cells
  bool extend_by_a_layer(bool only_open, std::vector<unsigned char>& known, std::vector<int>& unknown);
  /// Makes air of pockets that no water reaches through open faces, as behind a piston that leaves a side of the box:
  /// as water they could not follow the solids that bound them.
  void air_in_pockets(std::vector<unsigned char>& known, std::vector<int>& unknown);
  /// Removes the inside of solids from the fluid as seen by contact: seen_ = max(phi_, depth in solids).
  void hide_in_solids();
  bool among_solids() const { return !left_.empty(); }
  std::span<const double> seen() const { return among_solids() ? seen_ : phi_; }
  /// Sets face masses proportional to their share θ, scaled so that all faces across an axis have the mass of the fluid
  /// volume. θ alone misses cells that the surface cuts and whose centres are dry.
  void weigh_faces();
  /// SurfaceMotion of contact in a cell.
  SurfaceMotion touched_motion(int cell) const {
    return model_.material.friction == 0.0 && !touched_.has_fluid(cell) ? SurfaceMotion::Slips : SurfaceMotion::Sticks;
  }
  /// [m³] leaving through the open sides in a step. phi is that of its start and v that of its end.
  double leaving(double dt, std::span<const double> phi, std::span<const double> v) const;

  GridFluidModel model_;
  Vec3 start_origin_;       ///< [m] of the grid
  double cell_mass_ = 0.0;  ///< [kg] of a full cell
  double start_volume_ = 0.0;
  PartInfo part_;
  Display display_;

  // Of the last update:
  std::vector<double> taken_, phi_;  ///< level set as given, and as continued into solids
  double volume_ = 0.0;              ///< [m³] to be kept
  WetFaces wet_;
  Aabb bounds_;
  std::vector<double> v_;
  PressureProjection projection_;

  // Of the solve:
  mutable PressureProjection solver_;
  mutable std::vector<double> impulse_;  ///< [Pa s] pressure, initial guess of the next solve
  std::vector<double> mass_;
  Vec3 wall_impulse_ = Vec3::Zero();  ///< [N s] from the walls, in the last sub-step
  Vec3 held_ = Vec3::Zero();          ///< [N s] impulses on faces held by walls, in this sub-step

  TouchedCells touched_;

  // Of the solids in it:
  std::vector<double> left_;  ///< open fraction of each cell; empty: no solids
  std::vector<double> left_of_face_;
  std::vector<double> seen_;       ///< phi_ as seen by contact, [m]
  bool solids_taken_ = false;      ///< set since phi_ was last updated
  std::vector<Vec3> left_moment_;  ///< [m] open fraction times the offset of its centre

  // Workspace:
  mutable LevelSet level_;
  mutable std::vector<double> extended_, scratch_;
  mutable ExtensionMarks marks_;
  mutable SurfaceFaces surface_;  ///< of phi_, in advance
  MomentumKeeper keeper_;
};

}  // namespace brim
