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

/// The part of the system that contact touches, factored across bodies:
///   T = velocities whose share in contacts that act is a tenth of their own matrix at least,   z_T = (A_TT)⁻¹ r_T
/// with A the bodies' own matrices and Jᵀ K J of the contacts. It is what block Jacobi misses most: a tenth of the
/// nodes of a pile, and nearly all of what couples them. Thin bodies (sheets, rods), whose factors have few entries,
/// take part with all their velocities where T is then still factored whole. Beyond some thousand blocks T is cut where
/// A couples it least (strong_clusters) into clusters, and what couples these is left out, so that cost and memory grow
/// linearly; pieces of some clusters each are factored side by side. Bodies take part whose matrix is known in blocks
/// (Body::block_system, BlocksOfSix or one block of six) and whose maps are sparse. Of blocks of six, those take part
/// that touch each other, too. Same bits for any number of threads.
/// Tests: tests/world/contact_factor_test.cpp
class ContactFactor {
 public:
  struct Limits {
    /// [blocks of three velocities] that are factored whole, at most.
    std::size_t whole = 4096;
    /// [blocks] of a cluster at most where they are not: more of these cost more than the iterations that they save.
    std::size_t cluster = 128;
    /// Share of a node's own matrix below which contact does not touch it: block Jacobi knows as much.
    float touch = 0.1f;
  };

  ContactFactor();
  ~ContactFactor();

  /// Takes the matrices of the bodies for the step at hand. @param diagonal  of the bodies alone, by their blocks
  /// @param island  number of each body's; bodies of two are tied by no contact. Empty: all are of one
  void begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
             const BlockDiagonal& diagonal, std::span<const std::size_t> first_block,
             std::span<const std::uint8_t> sparse, std::span<const std::int32_t> island = {});
  /// Assembles and factors with the contact stiffness of the rows. The structure is kept where the pattern is the same.
  /// @param beside  called where the factor is not complete(), by another thread if there is one
  void factor(const ContactRows& rows, const Limits& limits, const std::function<void()>& beside = {});
  /// The same with the rows of the last call, of which the stiffness alone has changed: what is touched stays.
  void refactor(const ContactRows& rows, const std::function<void()>& beside = {});
  /// Makes room for the rows of all contacts, so that memory does not follow which of them act.
  void reserve(const ContactRows& rows) { incidence_.reserve(rows.offset.size()); }
  /// Nonzero for bodies of one block of six, of which the factor has all that contact touches; shape (bodies).
  std::span<const std::uint8_t> rigid() const { return rigid_; }
  /// True when all that moves are such bodies.
  bool knows_all_rigid() const { return all_rigid_; }
  bool empty() const { return touched_.empty(); }
  /// True when all that moves is touched and nothing is cut: the factor is that of the whole system.
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
    SixCouplings sixes;                 ///< and what couples them, if there are several
  };
  struct Touched {
    std::int32_t velocity;  ///< first of three
    std::int32_t body;
    std::int32_t cluster = 0;
    std::int32_t piece = 0, at = 0;  ///< its place in the piece
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
  /// Finds clusters, and deals them to pieces.
  void cut(const Limits& limits);
  std::vector<std::int32_t> find_clusters(const Limits& limits) const;
  /// The island of each touched block: nothing couples two of them.
  std::vector<std::int32_t> find_islands() const;
  void find_incidence(const ContactRows& rows);
  /// Calls add(u, block) for what a row of the upper triangle of A_TT is made of, where counts(u) holds.
  template <class Counts, class Add>
  void add_row(const ContactRows& rows, std::size_t row, const Counts& counts, const Add& add) const;
  /// Calls f(chunk, row, sum) for all rows, those of a chunk in order.
  template <class F>
  void for_rows(const F& f);
  /// The upper triangle of A_TT.
  void assemble(const ContactRows& rows);
  /// Patterns and values of the pieces, of what was assembled.
  void fill_pieces();
  /// The values alone, in the patterns as they are.
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
  std::size_t free_ = 0;                  ///< velocities that nothing prescribes
  std::vector<std::uint8_t> prescribed_;  ///< per velocity
  std::vector<float> entry_trace_;        ///< [kg] of each entry of the rows
  std::vector<float> contact_trace_;      ///< [kg] of each node's block of Jᵀ K J, per velocity
  std::vector<std::int32_t> local_;       ///< per velocity: the touched block that starts there, or -1
  std::vector<Touched> touched_;          ///< by velocity
  struct Incidence {
    std::int32_t contact, entry;  ///< place in the rows
  };
  std::vector<std::int32_t> incidence_first_;
  std::vector<Incidence> incidence_;
  std::vector<std::int32_t> length_;  ///< of each row
  std::vector<Chunk> chunks_;
  std::unique_ptr<WorkspacePool<RowSum>> sums_;
  std::vector<Piece> pieces_;
  std::size_t piece_count_ = 0;
  bool cut_ = false;  ///< couplings are left out
};

}  // namespace brim
