#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "brim/math/types.h"
#include "brim/solve/contact_responses.h"
#include "brim/solve/rigid_pair_rows.h"

namespace brim {

/// Contacts as inequality rows on a vector of velocities, solved one after another, each correction propagated at once
/// (paper, sections 4.3 and 6; projected Gauss-Seidel). It knows no bodies: a contact is three rows R of the velocities
/// (normal, tangent, tangent) and the response P Rᵀ of the velocities to a unit impulse along each.
///   u = R v + o       0 <= λ_n  ⟂  u_n − b >= 0       |λ_t| <= μ λ_n, opposite to the slip u_t (exact Coulomb cone)
/// Contacts between two rigid bodies have a compact form (RigidPairRows), and are relaxed pair by pair. Contacts are
/// swept in a fixed order, forward and back: same bits for any number of threads. When there are many rigid pairs,
/// threads share those that do not depend on each other through earlier ones in that order. From one double sweep to
/// the next, the previous change is continued as in conjugate gradients (Silcowitz, Niebe and Erleben 2010), unless the
/// changes grow.
/// If the contacts are few enough and the sweeps do not converge, all are solved at once (ContactAdmm) and swept again:
/// soon where some are of the general form, else after all sweeps and when far off, if the options let it. If that
/// fails too, the result with the smallest contact_residual is taken.
class ProjectedGaussSeidel {
 public:
  using Entry = ContactEntry;
  /// How solve sweeps, and when it ends.
  struct SweepOptions {
    double tolerance = 0.0;   ///< [-] residual at which it has converged
    int max_sweeps = 0;       ///< at most, forward and backward ones counted apart
    double scale = 0.0;       ///< [m/s] smallest scale of the residual
    double friction = 1.0;    ///< multiplies that of every contact: 0 for a frictionless solve
    bool may_at_once = true;  ///< false: sweeps only
    /// Nonzero for contacts that stay as they are, with the others of their group; shape (n), or empty. Sweeps only.
    std::span<const std::uint8_t> skipped = {};
  };
  struct Report {
    int sweeps = 0;
    double residual = 0.0;  ///< largest change of any u in the last sweep over the scale of the motion
    double scale = 0.0;     ///< [m/s] that scale
    bool converged = true;
  };

  void clear();
  /// Adds a contact; entries are copied, no index twice. A contact whose velocities cannot change has no effect.
  void add(std::span<const Entry> entries, double friction);
  /// Adds the contacts of two rigid bodies, numbered consecutively.
  /// @param grips  where friction acts
  void add_pair(const RigidPairRows::Side& a, const RigidPairRows::Side& b, std::span<const Vec3> points,
                std::span<const Vec3> grips, std::span<const Mat3> frames, double friction);
  void add_pair(const RigidPairRows::Side& a, const RigidPairRows::Side& b, std::span<const Vec3> points,
                std::span<const Mat3> frames, double friction) {
    add_pair(a, b, points, points, frames, friction);
  }
  /// Moves where the friction of a contact of a rigid pair acts. @param way  [m]  @param v  changes with its torque
  void move_friction(std::size_t c, const Vec3& way, const Vec3& impulse, std::span<double> v) {
    pairs_.move_friction(place_[c].row, way, impulse, v);
  }
  std::size_t size() const { return place_.size(); }

  /// Makes room for learn(): velocities from `first` on, kLearned of each island, describe no body. Call it after the
  /// last add(). @param island  number of each contact's island, from 0; no response leads from one to another. Empty:
  /// a single one
  void begin_learning(std::size_t first, std::span<const std::int32_t> island = {});
  /// Corrects the responses R P Rᵀ of contacts of the general form by one that is known, so that they give it for these
  /// impulses (Broyden-Fletcher-Goldfarb-Shanno): W' = W − W λ (W λ)ᵀ / λ·W λ + u uᵀ / λ·u, in every island. Does
  /// nothing where the room is used up or a product is not positive.
  /// @param impulse  λ, zero at contacts of rigid pairs  @param expected  W λ, [m/s]  @param actual  u, [m/s]
  void learn(std::span<const Vec3> impulse, std::span<const Vec3> expected, std::span<const Vec3> actual);
  /// Velocities that begin_learning() makes room for: two for each response.
  static constexpr std::size_t kLearned = 64;

  /// @param offset  o, [m/s], shape (size)
  /// @param target  b, [m/s], shape (size)
  /// @param impulse λ as (n, t1, t2), initial guess on entry (already in v), solution on return, [N s], shape (size)
  /// @param v       velocities, changed along with λ
  /// The scale of the residual is the larger of `options.scale` and the worst violation of any contact at the start,
  /// [m/s].
  Report solve(std::span<const Vec3> offset, std::span<const double> target, SweepOptions options,
               std::span<Vec3> impulse, std::span<double> v);

  /// True when all contacts are between two rigid bodies, in the compact form.
  bool pairs_only() const { return friction_.empty(); }
  /// Contacts that are relaxed together, [begin, end): those of one rigid pair, or one of the general form.
  std::size_t groups() const { return group_.size(); }
  std::pair<std::size_t, std::size_t> group(std::size_t g) const { return {group_[g].begin, group_[g].end}; }
  /// Solves the targets of one group alone, along the normals. @param offset, target, impulse  as in solve, of all
  void solve_alone(std::size_t g, std::span<const Vec3> offset, std::span<const double> target, int rounds,
                   std::span<Vec3> impulse, std::span<double> v) const;

  /// R v at contact c.
  Vec3 velocity(std::size_t c, std::span<const double> v) const;
  /// v += P Rᵀ λ of contact c.
  void add_response(std::size_t c, const Vec3& impulse, std::span<double> v) const;
  /// Q += Rᵀ λ of contact c, for velocities below Q's size.
  void add_force(std::size_t c, const Vec3& impulse, std::span<double> Q) const;

 private:
  /// Position of a contact among those of its form.
  struct Place {
    bool rigid = false;
    std::size_t row = 0;
  };
  /// Contacts that are relaxed together: those of a rigid pair, or one of the general form.
  struct Group {
    std::size_t begin = 0, end = 0;
    bool rigid = false;
    std::size_t index = 0;  ///< pair, or row
  };
  /// The sweeps of solve. @param options  its scale is that of the residual
  Report sweeps(std::span<const Vec3> offset, std::span<const double> target, const SweepOptions& options,
                std::span<Vec3> impulse, std::span<double> v);
  /// Solves all contacts at once, starting from the sweeps' result.
  /// @param options  its scale is that of the residual, its sweeps are made if that does not converge
  /// @param report  of the sweeps before; on return, of the chosen result
  void solve_at_once(std::span<const Vec3> offset, std::span<const double> target, SweepOptions options,
                     std::span<Vec3> impulse, std::span<double> v, Report& report);
  /// R P Rᵀ of all contacts. @param width  number of velocities
  ContactResponses responses(std::size_t width) const;
  /// Assigns groups to layers, if there are many and several threads: a group lies in the first layer after those of
  /// the earlier groups that share a body with it.
  void find_layers(std::size_t width);
  double relax_group(const Group& g, bool backward, double friction, std::span<const Vec3> offset,
                     std::span<const double> target, std::span<Vec3> impulse, std::span<double> v) const;
  double sweep(bool backward, const SweepOptions& options, std::span<const Vec3> offset, std::span<const double> target,
               std::span<Vec3> impulse, std::span<double> v) const;
  /// Corrects row r of the general form. @return largest resulting change of u, [m/s]
  double relax(std::size_t r, double friction, const Vec3& offset, double target, Vec3& impulse,
               std::span<double> v) const;
  /// Consecutive velocities in the response of a contact: v_i += x_i λ_n + y_i λ_t1 + z_i λ_t2.
  struct Run {
    std::size_t index = 0;  ///< of the first velocity
    std::size_t begin = 0;  ///< in response_: all x, then all y, then all z
    std::size_t size = 0;
  };
  /// Coefficients of one velocity in the contact's own velocity.
  struct Share {
    std::size_t index = 0;
    Vec3 row;
  };
  Vec3 row_velocity(std::size_t r, std::span<const double> v) const;
  void add_row_response(std::size_t r, const Vec3& impulse, std::span<double> v) const;

  std::vector<Place> place_;
  std::vector<Group> group_;
  RigidPairRows pairs_;
  // For rows of the general form, the starts of their shares and runs:
  std::vector<Share> shares_;
  std::vector<Run> runs_;
  std::vector<double> response_;
  std::vector<std::size_t> first_share_{0}, first_run_{0};
  std::vector<double> friction_;
  std::vector<Mat3> local_;                 ///< W = R P Rᵀ
  std::vector<Mat3> local_inverse_;         ///< zero where W is singular
  std::vector<Vec3> learned_;               ///< per row kLearned columns c: W' = W + Σ ∓ c cᵀ, minus for even ones
  std::vector<std::size_t> first_learned_;  ///< per row, index of the first velocity of its island's columns
  std::vector<std::int32_t> island_;        ///< per contact
  std::size_t learned_columns_ = 0;
  std::vector<std::size_t> layer_first_;  ///< start of each layer in layered_; empty when groups are swept one by one
  std::vector<std::uint32_t> layered_;    ///< groups, layer by layer
  mutable std::vector<double> change_;    ///< of each group
  // Workspace of solve: start of the last double sweep, and its direction.
  std::vector<Vec3> before_, way_;
  std::vector<double> v_before_, v_way_;
};

}  // namespace brim
