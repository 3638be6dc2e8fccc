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

/// Contacts whose stiffness in the system differs from that in the rows by more than the lesser of both: those that
/// have let go or come since, and those whose friction is another.
/// @param acting  nonzero for contacts that act, shape (contacts)  @param block  stiffness of a contact that acts
std::size_t count_changed(const ContactRows& rows, std::span<const std::uint8_t> acting,
                          const std::function<Mat3(std::size_t)>& block);

/// The contact factor over the solves of a step, and a coarse grid for the large bodies of each island: made for the
/// first, and again for those for which too much has changed. A contact that differs costs a solve about an iteration,
/// and a factor takes as long as ten to twenty. Tests: tests/world/contact_preconditioner_test.cpp
class ContactPreconditioner {
 public:
  /// Contacts that may differ from those that are factored, and one in how many of those that act.
  static constexpr std::size_t kMayDiffer = 16, kFew = 32;
  /// Nodes from which on a body is large: a motion of the whole takes many iterations to come through.
  static constexpr std::size_t kLarge = 8192;

  /// As ContactFactor has it. @param island  of each body, as its solver has them  @param asleep  per body, or empty
  void begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
             const BlockDiagonal& diagonal, std::span<const std::size_t> first_block,
             std::span<const std::uint8_t> sparse, std::span<const std::int32_t> island,
             std::span<const std::uint8_t> asleep);
  /// Makes room for all contacts, so that memory does not follow which of them act.
  void reserve(const ContactMaps& all);
  /// Factors what contact touches, with the stiffness of the contacts as it is.
  /// @param acting  maps of the contacts that act  @param first  of the solves of a step  @param beside  as
  /// ContactFactor::factor has it
  void make(const ContactMaps& acting, const Penalty& response, bool first, const std::function<void()>& beside = {});
  /// True where what was made serves the contacts as they are now.
  bool serves(const Penalty& response) const;
  /// Iterations that a solve may take with what was made for another. @param then  what that one took
  static int patience(int then) { return 2 * then + 10; }

  /// Nonzero for bodies of one block of six, of which the factor has all that contact touches; shape (bodies).
  std::span<const std::uint8_t> rigid() const { return factor_.rigid(); }
  /// True when all that moves are such bodies.
  bool knows_all_rigid() const { return factor_.knows_all_rigid(); }
  /// True when what was made is the inverse of the system, but for rounding in single precision.
  bool complete() const { return factor_.complete(); }
  /// Writes z on the touched velocities, and adds to it what the coarse grids know.
  void apply(std::span<const double> r, std::span<double> z);

 private:
  /// @param known  the rows are those of the factor, their stiffness alone is another
  void make_factor(const Penalty& response, bool known, const std::function<void()>& beside);

  ContactRows rows_;
  ContactFactor factor_;
  std::vector<CoarseGrid> grids_;  ///< of the islands that have large bodies
};

}  // namespace brim
