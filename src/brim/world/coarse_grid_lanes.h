#pragma once

#include <cstddef>
#include <cstdint>

#include "brim/math/types.h"

/// The loops of CoarseGrid over nodes and contacts, with wide instructions.  Tests: tests/world/coarse_grid_test.cpp
namespace brim::coarse_grid_lanes {

/// Numbers of what two cells share: eight corners of the one, nine of a block column by column, eight of the other.
inline constexpr std::size_t kPair = 8 * 9 * 8;
/// Cells around one, itself included: x + 3 (y + 3 z), each from 0 to 2.
inline constexpr std::size_t kAround = 27, kSelf = 13;

/// Rows of a body's matrix in blocks, and where its nodes are in the grid.
struct Rows {
  const std::int32_t* first;   ///< of its slots, per row
  const std::int32_t* column;  ///< per slot
  const float* value;          ///< per slot, nine numbers column by column; those on the diagonal mean nothing
  const Mat3* diagonal;        ///< per row
  const double* mass;          ///< [kg] per row
  float stiffness_share, mass_share;
  const std::int32_t* node;  ///< per velocity of the body: its node in the grid, −1 for none
  const std::int32_t* code;  ///< of each node's cell: x + width (y + height z)
  std::int32_t width, height;
  const float* weight;  ///< shape (nodes of the grid, 8)
};
/// Adds Σ w_iI A_ij w_jJ over some rows, whose nodes lie in one cell, to what that cell shares with itself and with
/// each around it that has a higher code.
/// @param row    shape (n)   @param node  of the first of them; the others follow
/// @param sum    shape (kAround, kPair): cleared here where `used` lacks the bit of a cell
void add_rows(const Rows& rows, const std::int32_t* row, std::size_t n, std::size_t node, float* sum,
              std::uint32_t& used);

/// A contact as the cells see it that it reaches: its motion at their corners, shape (cells, 8) where its blocks are
/// multiples of the identity, else (cells, 9, 8).
struct Sight {
  alignas(32) float motion[8][9][8];
  std::uint8_t used = 0;  ///< bit of each cell
  bool plain = true;
};
/// Adds an entry of a contact's row. @param J  nine numbers column by column, or one where the sight is plain
void see(Sight& s, int cell, const float* J, const float* weight);
/// sum += motion_aᵀ K motion_b. @param K  nine numbers  @param sum  shape (kPair)
void add_contact(const Sight& s, int a, int b, const float* K, float* sum);

/// Σ w_iI r_i over nodes that follow one another: shape (3, 8). @param velocity  first of three, per node
void restrict_to(const float* weight, const std::int32_t* velocity, std::size_t n, const double* r, float* sum);
/// z_i += Σ w_iI x_I. @param x  shape (3, 8)
void prolong(const float* weight, const std::int32_t* velocity, std::size_t n, const float* x, double* z);

}  // namespace brim::coarse_grid_lanes
