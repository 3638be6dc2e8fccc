#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "brim/core/workspace_pool.h"
#include "brim/solve/panel.h"
#include "brim/solve/panel_stream.h"

namespace brim {

/// Cholesky factor of a sparse symmetric positive definite matrix of 3x3 blocks, in single precision, as the exact part
/// of a preconditioner. The matrix is scaled to a unit diagonal; pivots lost to rounding are raised, so that the factor
/// is always that of a definite matrix.
///
///   order by approximate minimum degree -> elimination tree -> supernodes (columns of equal pattern, small ones
///   merged)
///   -> panels of floats, filled left to right by products of dense panels (Ng and Peyton 1993)
///   -> diagonal squares inverted, so that a solve consists of products only
///   -> a stream in the order in which solves read it; for large factors, whose solves are bound by memory, in ten bits
///
/// Subtrees of the elimination tree are independent: they are assigned to a fixed number of tasks, shared by threads;
/// the rest above them (the top) follows in order, its large panels split by rows. So the bits are the same for any
/// number of threads. Several factors may be used at once. Tests: tests/solve/block_cholesky_test.cpp
class BlockCholesky {
 public:
  using Block = Eigen::Matrix3f;

  /// Takes the pattern of the upper triangle, diagonal included, and finds ordering and structure of the factor.
  /// @param first   shape (n + 1)
  /// @param column  block columns of each row, ascending from the diagonal on, shape (first[n])
  /// @param in_turn  number of factors of this size that are applied alternately: they share the cache
  void analyze(std::span<const std::int32_t> first, std::span<const std::int32_t> column, std::size_t in_turn = 1);
  /// @param value  blocks in the order of the pattern, shape (first[n]) @return number of raised pivots
  int factor(std::span<const Block> value);
  /// x := A⁻¹ x. @param x  shape (3 n)
  void solve(std::span<float> x);

  std::size_t blocks() const { return order_.size(); }
  /// Scalar entries of the factor, zeros of merged supernodes included.
  std::size_t entries() const { return panel_.size(); }

 private:
  struct Supernode {
    std::int32_t begin = 0, end = 0;  ///< block columns, in the new order
    std::size_t row = 0;              ///< first of its block rows in row_, own columns first
    std::int32_t rows = 0;            ///< block rows
    std::size_t panel = 0;            ///< first of its floats in panel_
    std::size_t stride = 0;           ///< of a column
    std::size_t stream = 0;           ///< first of its numbers in the stream
    std::size_t runs = 0;             ///< end of its runs in row_run_, which follow those of the previous supernode
  };
  /// Rows below a supernode's own columns that are consecutive in x, and in a task's contribution to the top.
  struct RowRun {
    std::int32_t place, above;  ///< index of floats; above is −1 for rows not in the top, or of the top itself
    std::int32_t floats;
  };
  /// Update of a supernode by one below it: its block rows from `from` on, by its columns at the rows up to `to`.
  struct Update {
    std::int32_t supernode, from, to;
  };
  /// Workspace of one thread.
  struct Scratch {
    std::vector<float> product;
    std::vector<panel::Run> run;
    std::vector<float*> column;
  };
  /// Supernodes processed by one thread: whole subtrees, children first.
  struct Task {
    std::vector<std::int32_t> supernode;
    // Workspace.
    std::vector<float> rows, above;  ///< above: contribution to the top, shape (3 blocks of the top)
    std::vector<std::int32_t> local;
    std::vector<Update> update;
    Scratch scratch;
    int lifted = 0;
  };
  void find_order(std::span<const std::int32_t> first, std::span<const std::int32_t> column);
  void find_structure(std::span<const std::int32_t> first, std::span<const std::int32_t> column, std::size_t in_turn);
  /// Sets place_ by order_.
  void number_places();
  /// Renumbers the blocks in a postorder of the elimination tree. @return the parent of each, −1 for roots
  std::vector<std::int32_t> find_tree(std::span<const std::int32_t> first, std::span<const std::int32_t> column);
  /// Sorts the blocks of the pattern by columns.
  void find_entries(std::span<const std::int32_t> first, std::span<const std::int32_t> column);
  /// Finds the supernodes: a column joins the one before it where that costs few zeros.
  /// @param count  blocks in each column @return number of their block rows
  std::size_t find_supernodes(std::span<const std::int32_t> parent, std::span<const std::int32_t> count);
  /// Places the panels of the supernodes. @return number of their floats
  std::size_t lay_out_panels();
  void lay_out_stream();
  /// Finds the rows of the supernodes, `room` in all.
  void find_rows(std::size_t room);
  void find_tasks();
  void find_runs();
  std::span<const RowRun> runs_of(std::int32_t supernode) const {
    const std::size_t first = supernode == 0 ? 0 : supernode_[supernode - 1].runs;
    return std::span(row_run_).subspan(first, supernode_[supernode].runs - first);
  }
  void load(const Supernode& s, std::span<const Block> value, Task& task);
  void take_updates(std::size_t s, Task& task);
  /// The part of the updates for block rows [begin, end) of the panel.
  void take_rows(const Supernode& s, const Task& task, std::int32_t begin, std::int32_t end, Scratch& scratch);
  void write_stream(const Supernode& s);
  void factor(Task& task, std::span<const Block> value);
  /// A supernode of the top, its rows shared by threads.
  int factor_shared(const Supernode& s);
  /// Passes a supernode on to the next one that has rows of it.
  void hand_on(std::int32_t supernode);
  /// Calls f(panel::Stream) with the data that solves read of a supernode.
  template <class F>
  void with_stream(const Supernode& s, const F& f);
  void solve_forward(Task& task);
  void solve_backward(Task& task);

  std::vector<std::int32_t> order_, place_;  ///< old block of each new one, and the reverse
  // The lower triangle by columns in the new order: destination of each block of the pattern.
  struct Entry {
    std::int32_t row;     ///< new
    std::int32_t source;  ///< in the pattern
    bool transposed;
  };
  std::vector<std::int32_t> entry_first_;
  std::vector<Entry> entry_;
  std::vector<Supernode> supernode_;
  std::vector<std::int32_t> row_, supernode_of_;
  std::vector<RowRun> row_run_;
  std::vector<float> panel_;
  // The same in the order of solves (panel::Stream): ten bits for large factors, floats for small ones.
  bool compressed_ = false;
  std::vector<panel::Triple> triple_stream_;
  std::vector<float> stream_, square_columns_, square_rows_, step_;
  std::vector<Task> task_;               ///< the last one is the top
  std::vector<std::int32_t> task_of_;    ///< per supernode
  std::vector<std::int32_t> top_place_;  ///< per block: its index in the top
  // Workspace: lists of the supernodes that update a supernode, and how far each has been used.
  std::vector<std::int32_t> head_, next_, done_;
  std::vector<float> scale_, x_;
  std::unique_ptr<WorkspacePool<Scratch>> scratch_ = std::make_unique<WorkspacePool<Scratch>>();
};

}  // namespace brim
