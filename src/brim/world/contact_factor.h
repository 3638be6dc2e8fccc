#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "brim/body/blocks_of_six.h"
#include "brim/body/body.h"
#include "brim/core/workspace_pool.h"
#include "brim/math/block_matrix.h"
#include "brim/solve/block_cholesky.h"
#include "brim/world/contact_rows.h"

namespace brim {

/// Factor, across bodies, of the part of the system that contact touches:
///   T = velocities whose contact stiffness is at least a tenth of their body's own matrix,   z_T = (A_TT)⁻¹ r_T
/// with A the bodies' own matrices and Jᵀ K J of the contacts. This is what block Jacobi misses most: a tenth of the
/// nodes of a pile, and nearly all that couples them. Thin bodies (sheets, rods), whose factors have few entries, take
/// part with all their velocities if T is then still factored whole. Beyond some thousand blocks T is cut where A
/// couples it least (strong_clusters) into clusters and their couplings are dropped, so that cost and memory grow
/// linearly; pieces of several clusters are factored in parallel. Bodies take part if their matrix is known in blocks
/// (Body::block_system, BlocksOfSix or one block of six) and their maps are sparse; contact between two blocks of six
/// is included too. Same bits for any number of threads.
/// Tests: tests/world/contact_factor_test.cpp
class ContactFactor {
 public:
  struct Limits {
    /// [blocks of three velocities] largest T that is factored whole.
    std::size_t whole = 4096;
    /// [blocks] largest cluster when T is cut: larger ones cost more than the iterations they save.
    std::size_t cluster = 128;
    /// Share of a node's own matrix below which contact does not count as touching it: block Jacobi is good enough
    /// there.
    float touch = 0.1f;
  };

  ContactFactor();
  ~ContactFactor();

  /// Takes the matrices of the bodies for this step. @param diagonal  of the bodies alone, by their blocks
  /// @param island  number per body; no contact couples two islands. Empty: a single island
  void begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
             const BlockDiagonal& diagonal, std::span<const std::size_t> first_block,
             std::span<const std::uint8_t> sparse, std::span<const std::int32_t> island = {});
  /// Assembles and factors with the contact stiffness of the rows. The structure is kept when the pattern is the same.
  /// @param beside  called when the factor is not complete(), by another thread if there is one
  void factor(const ContactRows& rows, const Limits& limits, const std::function<void()>& beside = {});
  /// The same with the rows of the last call when only their stiffness has changed: T stays.
  void refactor(const ContactRows& rows, const std::function<void()>& beside = {});
  /// Reserves memory for the rows of all contacts, so that it does not depend on which of them act.
  void reserve(const ContactRows& rows) { incidence_.reserve(rows.offset.size()); }
  /// Nonzero for bodies of one block of six whose contact is entirely in the factor; shape (bodies).
  std::span<const std::uint8_t> rigid() const { return rigid_; }
  /// True when all moving bodies are such bodies.
  bool knows_all_rigid() const { return all_rigid_; }
  bool empty() const { return touched_.empty(); }
  /// True when every free velocity is in T and nothing is cut: the factor is that of the whole system.
  bool complete() const { return !cut_ && 3 * touched_.size() == free_; }
  /// Writes z on the touched velocities; the others are left alone.
  void apply(std::span<const double> r, std::span<double> z);

  std::size_t touched() const { return touched_.size(); }  ///< blocks of three velocities
  std::size_t entries() const;                             ///< floats of the factors

 private:
  struct Owner {
    bool known = false;
    std::size_t first_v = 0, first_block = 0;
    std::int32_t island = 0;
    std::optional<BlockSystem> system;  ///< none: blocks of six in the diagonal,
    SixCouplings sixes;                 ///< and their couplings, if there are several
  };
  struct Touched {
    std::int32_t velocity;  ///< first of three
    std::int32_t body;
    std::int32_t cluster = 0;
    std::int32_t piece = 0, at = 0;  ///< index in the piece
  };
  /// Rows of the upper triangle of a piece.
  struct Pattern {
    std::vector<std::int32_t> first, column;
  };
  struct Piece {
    std::vector<std::int32_t> touched;  ///< by cluster, then by velocity
    Pattern pattern, before;
    std::vector<BlockCholesky::Block> value;
    BlockCholesky factor;
    std::vector<float> x;
  };
  struct Chunk {
    std::vector<std::int32_t> column;
    std::vector<BlockCholesky::Block> value;
  };
  class RowSum;
  std::size_t end_of(std::size_t body) const {
    return body + 1 < owner_.size() ? owner_[body + 1].first_v : local_.size();
  }
  void find_touched(const ContactRows& rows, const Limits& limits);
  void take_blocks_of_six();
  void take_thin_whole(std::size_t most);
  /// Finds clusters and assigns them to pieces.
  void cut(const Limits& limits);
  std::vector<std::int32_t> find_clusters(const Limits& limits) const;
  /// The island of each touched block; two islands are not coupled.
  std::vector<std::int32_t> find_islands() const;
  void find_incidence(const ContactRows& rows);
  /// Calls add(u, block) for the terms of a row of the upper triangle of A_TT, for those u with counts(u).
  template <class Counts, class Add>
  void add_row(const ContactRows& rows, std::size_t row, const Counts& counts, const Add& add) const;
  /// Calls f(chunk, row, sum) for all rows, those of a chunk in order.
  template <class F>
  void for_rows(const F& f);
  /// The upper triangle of A_TT.
  void assemble(const ContactRows& rows);
  /// Fills patterns and values of the pieces from the assembled matrix.
  void fill_pieces();
  /// Reassembles only the values, in the present patterns.
  void assemble_again(const ContactRows& rows);
  template <class Add>
  void add_own_blocks(std::int32_t t, const Add& add) const;
  template <class Add>
  void add_blocks_of_six(std::int32_t t, const Add& add) const;
  /// Calls f(piece) for all pieces, and `beside` as factor does.
  template <class F>
  void for_pieces(const std::function<void()>& beside, const F& f);
  template <class F>
  void for_entries(const ContactRows& rows, const F& f) const;

  const BlockDiagonal* diagonal_ = nullptr;
  std::vector<Owner> owner_;         ///< per body
  std::vector<std::uint8_t> rigid_;  ///< per body
  bool all_rigid_ = false;
  std::size_t free_ = 0;                  ///< number of velocities that are not prescribed
  std::vector<std::uint8_t> prescribed_;  ///< per velocity
  std::vector<float> entry_trace_;        ///< [kg] of each entry of the rows
  std::vector<float> contact_trace_;      ///< [kg] of each node's block of Jᵀ K J, per velocity
  std::vector<std::int32_t> local_;       ///< per velocity: the touched block that starts there, or -1
  std::vector<Touched> touched_;          ///< by velocity
  struct Incidence {
    std::int32_t contact, entry;  ///< index in the rows
  };
  std::vector<std::int32_t> incidence_first_;
  std::vector<Incidence> incidence_;
  std::vector<std::int32_t> length_;  ///< of each row
  std::vector<Chunk> chunks_;
  std::unique_ptr<WorkspacePool<RowSum>> sums_;
  std::vector<Piece> pieces_;
  std::size_t piece_count_ = 0;
  bool cut_ = false;  ///< some couplings are dropped
};

}  // namespace brim
