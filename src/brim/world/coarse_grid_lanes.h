#pragma once

#include <cstddef>
#include <cstdint>

#include "brim/math/types.h"

/// The loops of CoarseGrid over nodes and contacts, with wide instructions.  Tests: tests/world/coarse_grid_test.cpp
namespace brim::coarse_grid_lanes {

/// Numbers per coupling of two cells: eight corners of one, nine of a block column by column, eight of the other.
inline constexpr std::size_t kPair = 8 * 9 * 8;
/// Cells around one, itself included: x + 3 (y + 3 z), each from 0 to 2.
inline constexpr std::size_t kAround = 27, kSelf = 13;

/// Rows of a body's block matrix, and the position of its nodes in the grid.
struct Rows {
  const std::int32_t* first;   ///< of its slots, per row
  const std::int32_t* column;  ///< per slot
  const float* value;          ///< per slot, nine numbers column by column; diagonal ones are unused
  const Mat3* diagonal;        ///< per row
  const double* mass;          ///< [kg] per row
  float stiffness_share, mass_share;
  const std::int32_t* node;  ///< per velocity of the body: its node in the grid, −1 for none
  const std::int32_t* code;  ///< of each node's cell: x + width (y + height z)
  std::int32_t width, height;
  const float* weight;  ///< shape (nodes of the grid, 8)
};
/// Adds Σ w_iI A_ij w_jJ over some rows, whose nodes lie in one cell, to the coupling of that cell with itself and with
/// each neighbour of higher code.
/// @param row    shape (n)   @param node  first of their nodes, which are consecutive
/// @param sum    shape (kAround, kPair): a cell's entry is cleared here when `used` lacks its bit
void add_rows(const Rows& rows, const std::int32_t* row, std::size_t n, std::size_t node, float* sum,
              std::uint32_t& used);

/// A contact projected to the cells that it reaches: its motion at their corners, shape (cells, 8) when its blocks are
/// multiples of the identity, else (cells, 9, 8).
struct Sight {
  alignas(32) float motion[8][9][8];
  std::uint8_t used = 0;  ///< one bit per cell
  bool plain = true;
};
/// Adds an entry of a contact's row. @param J  nine numbers column by column, or one when the sight is plain
void see(Sight& s, int cell, const float* J, const float* weight);
/// sum += motion_aᵀ K motion_b. @param K  nine numbers  @param sum  shape (kPair)
void add_contact(const Sight& s, int a, int b, const float* K, float* sum);

/// Σ w_iI r_i over consecutive nodes: shape (3, 8). @param velocity  first of three, per node
void restrict_to(const float* weight, const std::int32_t* velocity, std::size_t n, const double* r, float* sum);
/// z_i += Σ w_iI x_I. @param x  shape (3, 8)
void prolong(const float* weight, const std::int32_t* velocity, std::size_t n, const float* x, double* z);

}  // namespace brim::coarse_grid_lanes
