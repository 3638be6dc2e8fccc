#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "brim/core/shared.h"
#include "brim/grid/tile.h"
#include "brim/map/map.h"
#include "brim/math/block_diagonal.h"
#include "brim/math/types.h"
#include "brim/mesh/tri_mesh.h"

namespace brim {

struct BlockSystem;  // brim/math/block_matrix.h

/// Contact response: by stiff forces, or by rows that no motion may violate (docs/constraint.md).
enum class Response { Inherit, Penalty, Constraint };

/// Contact behaviour of a part's surface.
struct Material {
  std::string name = "default";
  double friction = 0.5;  ///< Coulomb coefficient, [-], >= 0; a pair uses the geometric mean unless overridden
  /// Newton's coefficient e, [-], 0 to 1, for the constraint response; a pair uses the larger unless overridden.
  double restitution = 0.0;
  /// Of pairs without one of their own: constraint when either material says so, else penalty, else as the world.
  Response response = Response::Inherit;
  /// b, [m], >= 0: lever arm of the rolling resistance of rigid bodies; a pair uses the larger unless overridden.
  double rolling_resistance = 0.0;
};

/// PartInfo::width of matter of a volume [m³] and thickness [m] within a box.
inline double width_of(double volume, double thickness, const Aabb& box) {
  const double across = thickness * box.extent().maxCoeff();
  return across > 0.0 ? volume / across : std::numeric_limits<double>::infinity();
}

/// Parameters of a part for contact besides its density.
struct PartInfo {
  double voxel_size = 0.0;  ///< [m] grid step that resolves the part's detail; the world rounds it to h0 2^l
  double areal_mass = 0.0;  ///< [kg/m²] mass per contact area, for the choice of stiffness; 0 if fixed
  /// [m] Smallest extent: thick parts may move farther in a sub-step, thin parts are not resolved by coarser voxels.
  double thickness = std::numeric_limits<double>::infinity();
  /// [m] Volume over thickness and diameter: much more than the thickness is the width of a wall, which holds fluids.
  double width = std::numeric_limits<double>::infinity();
  /// Made of lines, as rods and nets are: no wall, and its drag is that of a cylinder.
  bool lines = false;
  /// [Pa] Young's modulus of the material behind the surface: contact need not be much stiffer.
  double modulus = std::numeric_limits<double>::infinity();
  bool conforming =
      false;  ///< conforms to the other surface, as fluids do: contact normals are those of the other side
  Material material;
};

/// External actions on all bodies.
struct Environment {
  Vec3 gravity = Vec3(0, 0, -9.81);  ///< [m/s²]

  /// That of a body whose gravity has a factor of its own. @param factor  per body; those beyond its end have 1
  Environment scaled(std::span<const double> factor, std::size_t body) const {
    return body < factor.size() ? Environment{factor[body] * gravity} : *this;
  }
};

/// Display geometry of a body for viewers and files: constant topology, positions that follow the state.
struct Display {
  enum class Kind { Triangles, Lines, Points };
  Kind kind = Kind::Triangles;
  std::size_t vertices = 0;
  SharedList<Triangle> triangles;                  ///< when kind is Triangles
  std::vector<std::array<std::int32_t, 2>> lines;  ///< when kind is Lines
  bool two_sided = false;                          ///< an open sheet
  double radius = 0.0;                             ///< [m] of lines and points
};

/// A simulated object with generalised coordinates q and velocities v (paper, section 5). This is the whole interface
/// for the world, contact and the solver; none of them knows the body's kind.
///
/// Order of calls in a sub-step:
///   prescribe, update             state and prescribed velocities at the start of the sub-step
///   presence, rasterize, make_map contacts; these are const, and may be called at any time after an update
///   begin_solve                   then add_forces and the other const operators
///   prepare_preconditioner        before a solve whose contacts have changed; several solves are usual
///   advance, finish_step
/// A sub-step that moves too far is undone before it advances, and begins again with prescribe. The speeds that
/// determine its length, and energies at the end of a step, are queried after an update alone.
class Body {
 public:
  virtual ~Body() = default;

  const std::string& name() const { return name_; }
  void set_name(std::string name) { name_ = std::move(name); }
  /// The keyword of this kind in scenes and reports ("rigid", "cloth", ...).
  virtual std::string_view kind() const = 0;

  // ---- state -----------------------------------------------------------------------------------------------------
  virtual std::size_t q_size() const = 0;
  virtual std::size_t v_size() const = 0;
  virtual void initial_state(std::span<double> q, std::span<double> v) const = 0;
  /// Sets the prescribed velocities (fixed and animated directions) so that the body reaches its prescribed position at
  /// time + dt. @param q, v  at time
  virtual void prescribe(double time, double dt, std::span<const double> q, std::span<double> v) const {
    (void)time, (void)dt, (void)q, (void)v;
  }
  /// Reads the state: everything below refers to the last update.
  virtual void update(double time, std::span<const double> q, std::span<const double> v) = 0;
  /// q ← q ⊕ dt v on the body's own manifold.
  virtual void advance(double dt, std::span<double> q, std::span<const double> v) const = 0;
  /// The body's own work after the common solve (for example the pressure projection of a fluid).
  virtual void finish_step(double time, double dt, std::span<double> q, std::span<double> v) {
    (void)time, (void)dt, (void)q, (void)v;
  }

  // ---- dynamics --------------------------------------------------------------------------------------------------
  /// Q += Q(q, v): internal and external forces without contact, [N, N·m], shape (nv).
  virtual void add_forces(const Environment& env, std::span<double> Q) const = 0;
  /// y += M x.
  virtual void apply_mass(std::span<const double> x, std::span<double> y) const = 0;
  /// y += (∂Q/∂q) x and y += (∂Q/∂v) x; symmetric, negative semi-definite after projection (the solve needs it).
  virtual void apply_stiffness(std::span<const double> x, std::span<double> y) const { (void)x, (void)y; }
  virtual void apply_damping(std::span<const double> x, std::span<double> y) const { (void)x, (void)y; }

  /// Prepares A = M − dt ∂Q/∂v − dt² ∂Q/∂q for apply_system. The default composes the three operators above.
  virtual void begin_solve(double dt) { dt_ = dt; }
  /// y += A x.
  virtual void apply_system(std::span<const double> x, std::span<double> y) const;
  /// A as sparse 3x3 blocks, after begin_solve, for preconditioners; empty for kinds without such a matrix.
  /// Tests: tests/body/block_system_test.cpp
  virtual std::optional<BlockSystem> block_system() const;
  /// Sizes of the diagonal blocks of A, in order; they sum to v_size().
  virtual std::vector<int> block_sizes() const = 0;
  /// Adds the diagonal blocks of A. @param first  index of the body's first block in D
  virtual void add_system_diagonal(std::size_t first, BlockDiagonal& D) const = 0;
  /// Approximate inverse of the body's part of the system, A plus its contacts, for the solver: symmetric, positive
  /// definite, the same linear map until the next prepare. The default is the inverse of the diagonal blocks.
  /// @param D      diagonal blocks of all bodies, contact included; inverted in precondition, not yet in prepare
  /// @param first  index of the body's first block in D
  /// @param r, z   slices of this body; z is overwritten
  virtual void prepare_preconditioner(std::size_t first, const BlockDiagonal& D) { (void)first, (void)D; }
  virtual void precondition(std::size_t first, const BlockDiagonal& D, std::span<const double> r,
                            std::span<double> z) const;
  /// Sets the prescribed directions of x to zero (filtered CG, Baraff and Witkin 1998).
  virtual void filter(std::span<double> x) const { (void)x; }

  // ---- contact ---------------------------------------------------------------------------------------------------
  virtual int part_count() const { return 1; }
  virtual PartInfo part(int p) const = 0;
  /// False for two parts of this body that never touch each other, such as links with a common joint.
  virtual bool parts_collide(int p, int q) const { return p != q; }
  /// True when no part moves or can be moved; pairs of two such bodies are skipped.
  virtual bool immobile() const { return false; }
  /// Bounding box of the part (without ramp), may be infinite.
  virtual Aabb bounds(int p) const = 0;
  /// Mean velocity of the part, [m/s].
  virtual Vec3 mean_velocity(int p, std::span<const double> v) const = 0;
  /// Upper bound of the speed of the part's material relative to mean_velocity(p, v), [m/s].
  virtual double relative_speed_bound(int p, std::span<const double> v) const = 0;
  /// Tiles of step h in the region whose block (halo included) may hold density of the part; none may be missing.
  /// @param w    [m] ramp width
  /// @param out  appended to; order and repetition do not matter
  virtual void presence(int p, double h, double w, const Aabb& region, std::vector<TileKey>& out) const = 0;
  /// Writes the part's density on the given tiles; out contains the requested octants of each (DensityBlock).
  virtual void rasterize(int p, double h, double w, std::span<const TileKey> tiles,
                         std::span<DensityBlock> out) const = 0;
  /// Makes (or refills) the map of the part at the given points, each near the node with the given source.
  virtual void make_map(int p, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                        std::unique_ptr<Map>& map) const = 0;

  // ---- measures --------------------------------------------------------------------------------------------------
  /// [kg]; infinity when the body is fixed or animated.
  virtual double mass() const = 0;
  virtual double kinetic_energy(std::span<const double> v) const;
  /// Elastic and gravitational energy of the last updated state, [J].
  virtual double potential_energy(const Environment& env) const = 0;
  virtual Vec3 linear_momentum(std::span<const double> v) const = 0;
  /// About the world's origin, [kg m²/s].
  virtual Vec3 angular_momentum(std::span<const double> v) const = 0;
  /// Generalised velocities of the rigid motion u(x) = t + w × x of the whole body, for measuring resultants: v·Q is
  /// then the power of the forces Q in that motion. @return false when the body has no such motion
  virtual bool rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const {
    (void)t, (void)w, (void)v;
    return false;
  }

  // ---- display ---------------------------------------------------------------------------------------------------
  virtual const Display& display() const = 0;
  /// Positions of the display's vertices in the last updated state, [m], shape (display().vertices).
  virtual void display_positions(std::span<Vec3f> x) const = 0;

 protected:
  double dt_ = 0.0;

 private:
  std::string name_;
};

}  // namespace brim
