#pragma once

#include <cstddef>

/// Dense kernels on panels: columns of floats, `stride` apart. Rows are processed in lanes, independently, so that wide
/// and narrow instructions give the same bits. Kernels may read and write up to kPad rows past the last: strides and
/// buffers must leave room.
namespace brim::panel {

inline constexpr std::size_t kPad = 16;
/// Number of columns factored as a block before the rest of the panel follows.
inline constexpr std::size_t kBlock = 12;
/// Rows of a panel with its padding.
inline std::size_t padded(std::size_t rows) { return (rows + kPad - 1) / kPad * kPad; }

/// C = A Bᵀ.
/// @param a, b    shape (rows, depth), (columns, depth), columns a multiple of 3; both with the stride of one panel
/// @param c       shape (rows, columns), stride padded(rows), overwritten
void multiply_transposed(const float* a, const float* b, std::size_t stride, std::size_t rows, std::size_t columns,
                         std::size_t depth, float* c);

/// Rows that are consecutive both in a product and in the panel it is subtracted from: counted in floats.
struct Run {
  std::size_t in_product, in_panel, length;
};
/// Subtracts a product from the columns of a panel, each at `column[j]`. Lengths are multiples of 3.
void subtract_runs(const float* product, std::size_t stride, const Run* run, std::size_t runs, float* const* column,
                   std::size_t columns);

/// Smallest pivot of a matrix with unit diagonal: below it single precision is meaningless.
inline constexpr float kLeastPivot = 1e-5f;

/// Replaces the lower triangle of the first `width` rows by its Cholesky factor L, and the rows below by X L⁻ᵀ.
/// Diagonal squares of L are inverted, so that solves need no division.
/// @param rows       all rows of the panel, >= width; width a multiple of 3
/// @param workspace  room for padded(rows) x 12 floats
/// @return number of pivots raised to kLeastPivot: L Lᵀ is then definite, but differs from the matrix
int factor(float* panel, std::size_t stride, std::size_t rows, std::size_t width, float* workspace);

/// The two halves of factor() for the columns [first, first + block) of a panel, block <= kBlock: their square, then
/// rows below it, [from, from + rows). All earlier columns must have had both. Same bits as factor().
int factor_square(float* panel, std::size_t stride, std::size_t first, std::size_t block, float* workspace);
void factor_rows(float* panel, std::size_t stride, std::size_t first, std::size_t block, std::size_t from,
                 std::size_t rows, float* workspace);

}  // namespace brim::panel
