#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "brim/response/penalty.h"
#include "brim/world/coarse_grid.h"
#include "brim/world/contact_factor.h"
#include "brim/world/contact_maps.h"
#include "brim/world/contact_rows.h"

namespace brim {

/// Number of contacts whose stiffness in the system differs from that in the rows by more than the lesser of both:
/// released, newly active, or with another friction.
/// @param acting  nonzero for active contacts, shape (contacts)  @param block  stiffness of an active contact
std::size_t count_changed(const ContactRows& rows, std::span<const std::uint8_t> acting,
                          const std::function<Mat3(std::size_t)>& block);

/// The contact factor over the solves of a step, plus a coarse grid for the large bodies of each island. Built for the
/// first solve, and rebuilt when too much has changed: each contact that differs costs a solve about an iteration, and
/// a factor takes as long as ten to twenty. Tests: tests/world/contact_preconditioner_test.cpp
class ContactPreconditioner {
 public:
  /// A factor is reused while at most kMayDiffer contacts, and one in kFew of the active ones, differ from it.
  static constexpr std::size_t kMayDiffer = 16, kFew = 32;
  /// [nodes] size from which a body counts as large: a motion of the whole takes many iterations to pass through it.
  static constexpr std::size_t kLarge = 8192;

  /// As ContactFactor::begin. @param island  of each body, as in the solver  @param asleep  per body, or empty
  void begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
             const BlockDiagonal& diagonal, std::span<const std::size_t> first_block,
             std::span<const std::uint8_t> sparse, std::span<const std::int32_t> island,
             std::span<const std::uint8_t> asleep);
  /// Reserves memory for all contacts, so that it does not depend on which of them act.
  void reserve(const ContactMaps& all);
  /// Factors what contact touches, with the present contact stiffness.
  /// @param acting  maps of the active contacts  @param first  true for the first solve of a step
  /// @param beside  as in ContactFactor::factor
  void make(const ContactMaps& acting, const Penalty& response, bool first, const std::function<void()>& beside = {});
  /// True when the factor is still good for the present contacts.
  bool serves(const Penalty& response) const;
  /// Iterations allowed with a factor built for an earlier solve. @param then  iterations of that solve
  static int patience(int then) { return 2 * then + 10; }

  /// Nonzero for bodies of one block of six whose contact is entirely in the factor; shape (bodies).
  std::span<const std::uint8_t> rigid() const { return factor_.rigid(); }
  /// True when all moving bodies are such bodies.
  bool knows_all_rigid() const { return factor_.knows_all_rigid(); }
  /// True when it is the inverse of the system, up to rounding in single precision.
  bool complete() const { return factor_.complete(); }
  /// Writes z on the touched velocities and adds the correction of the coarse grids.
  void apply(std::span<const double> r, std::span<double> z);

 private:
  /// @param known  the rows are those of the factor, and only their stiffness has changed
  void make_factor(const Penalty& response, bool known, const std::function<void()>& beside);

  ContactRows rows_;
  ContactFactor factor_;
  std::vector<CoarseGrid> grids_;  ///< of the islands that have large bodies
};

}  // namespace brim
