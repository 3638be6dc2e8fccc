#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "brim/core/workspace_pool.h"
#include "brim/math/block_matrix.h"
#include "brim/solve/block_cholesky.h"
#include "brim/world/contact_rows.h"

namespace brim {

/// Coarse level for large bodies: displacement fields that are trilinear in the cells of a grid shared by these bodies,
///   z += W (Wᵀ A W)⁻¹ Wᵀ r,   W_iI: weight of corner I of its cell at the position of node i
/// with A the bodies' own matrices and Jᵀ K J of the contacts. Surfaces held together by stiff contact move together in
/// such a field even if their meshes do not match; neither the clusters of the contact factor nor coarse motions per
/// body have this property (Galerkin coarse level; Smith, Bjørstad and Gropp 1996, chapter 2).
/// Cells are several mesh edges wide; contacts that reach beyond the next cell are left to the rest of the
/// preconditioner. Same bits for any number of threads.
/// Tests: tests/world/coarse_grid_test.cpp
class CoarseGrid {
 public:
  /// [mesh edges] width of a cell, which then holds some 200 nodes.
  static constexpr double kCellEdges = 6.0;

  struct Member {
    std::size_t first_v = 0;  ///< first velocity of the body in the world's vector
    BlockSystem system;       ///< with places
  };

  CoarseGrid();
  ~CoarseGrid();
  CoarseGrid(CoarseGrid&&) noexcept;
  CoarseGrid& operator=(CoarseGrid&&) noexcept;

  /// Builds the grid and sums the bodies' own matrices. @param velocities  number of the world's
  void begin(std::span<const Member> members, std::size_t velocities, double cell_edges = kCellEdges);
  /// Adds the contact stiffness of the rows and factors. May be called again, with the same rows or others, until
  /// begin.
  void factor(const ContactRows& rows);
  /// Adds to z; velocities of other bodies are left alone. @param r, z  of the world
  void add(std::span<const double> r, std::span<double> z);

  std::size_t corners() const { return corner_.size(); }
  /// Wᵀ A W as last factored, for tests: shape (3 corners, 3 corners).
  Eigen::MatrixXd dense() const;
  /// W_iI of the node whose first velocity is given, zero when prescribed or no node: shape (corners).
  Eigen::VectorXd weights(std::size_t velocity) const;

 private:
  using Place = std::array<std::int32_t, 3>;
  /// Corners at most two cells apart are coupled; of these each stores itself and those that follow it in order.
  static constexpr std::size_t kAhead = 63;

  /// 0 or 1: whether corner b of a cell is its second one along an axis.
  static constexpr std::int32_t corner_bit(std::size_t b, int axis) { return static_cast<std::int32_t>(b >> axis & 1); }

  struct Cell {
    Place at;
    std::size_t begin, end;              ///< of its nodes
    std::array<std::int32_t, 8> corner;  ///< numbers of its corners
    std::array<float, 24> sum;           ///< workspace of add
  };
  struct Run {
    std::size_t member, cell, begin, end;  ///< of nodes
  };
  struct Workspace;

  void lay(std::span<const Member> members, double cell_edges);
  void sort_nodes(std::span<const Member> members);
  void number_corners();
  void sum_bodies(std::span<const Member> members);
  void sum_contacts(const ContactRows& rows);
  /// Adds the coupling of two cells, the second offset by `away` cells: shape (8 corners, 9 numbers, 8 corners).
  void scatter(const float* sum, const std::array<std::int32_t, 8>& corner, const std::array<std::int32_t, 8>& other,
               const Place& away);
  std::size_t dense_cell(const Place& p) const;

  Vec3 origin_ = Vec3::Zero(), step_ = Vec3::Ones();
  Place cells_ = {1, 1, 1};
  // Nodes without prescribed velocity, by cell, then in order of their velocities.
  std::vector<std::int32_t> velocity_;  ///< first of three
  std::vector<std::int32_t> code_;      ///< of the cell; differences of codes identify neighbours
  std::vector<std::int32_t> cell_at_;   ///< per node
  std::vector<float> weight_;           ///< shape (nodes, 8)
  std::vector<std::int32_t> node_of_;   ///< per velocity of the world; −1
  std::vector<Cell> cell_;
  std::vector<std::int32_t> cell_of_;    ///< per place of a cell; −1 for none
  std::vector<Run> run_;                 ///< nodes of one cell and one member
  std::vector<Place> corner_;            ///< in ascending order of z, y, x
  std::vector<std::int32_t> corner_of_;  ///< per place of a corner; −1 for none
  // Blocks of the upper triangle: per corner, those with the corners that follow it.
  std::vector<BlockCholesky::Block> own_, sum_;  ///< without contact; with contact
  std::vector<std::uint8_t> own_used_, used_;    ///< nonzero where something was added
  std::vector<std::int32_t> first_, column_, first_before_, column_before_;
  std::vector<BlockCholesky::Block> value_;
  BlockCholesky factor_;
  std::vector<float> x_;
  std::vector<std::size_t> contact_first_;  ///< per cell: contacts by the lowest cell that they reach
  std::vector<std::uint32_t> contact_;
  std::unique_ptr<WorkspacePool<Workspace>> pool_;
};

}  // namespace brim
