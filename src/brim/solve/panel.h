#pragma once

#include <cstddef>

/// Dense kernels on panels: columns of floats one after another, `stride` apart. The rows are worked on in lanes, each
/// row by itself, so that wide and narrow instructions give the same bits. Kernels may read and write up to kPad
/// rows past the last: strides and buffers leave room.
namespace brim::panel {

inline constexpr std::size_t kPad = 16;
/// Columns of a block that is factored by itself before the rest of the panel follows.
inline constexpr std::size_t kBlock = 12;
/// Rows of a panel with its padding.
inline std::size_t padded(std::size_t rows) { return (rows + kPad - 1) / kPad * kPad; }

/// C = A Bᵀ.
/// @param a, b    shape (rows, depth), (columns, depth), columns a multiple of 3; both with the stride of one panel
/// @param c       shape (rows, columns), stride padded(rows), overwritten
void multiply_transposed(const float* a, const float* b, std::size_t stride, std::size_t rows, std::size_t columns,
                         std::size_t depth, float* c);

/// Rows that follow one another in a product and in the panel that it is taken from: counted in floats.
struct Run {
  std::size_t in_product, in_panel, length;
};
/// Takes a product from the columns of a panel, each at `column[j]`. Lengths are multiples of 3.
void subtract_runs(const float* product, std::size_t stride, const Run* run, std::size_t runs, float* const* column,
                   std::size_t columns);

/// Smallest pivot of a matrix whose diagonal is 1: beyond it, single precision knows no more.
inline constexpr float kLeastPivot = 1e-5f;

/// Replaces the lower triangle of the first `width` rows by its Cholesky factor L, and the rows below by X L⁻ᵀ. Squares
/// of L along its diagonal are inverted, so that no solve divides.
/// @param rows       all rows of the panel, >= width; width a multiple of 3
/// @param workspace  room for padded(rows) x 12 floats
/// @return pivots that were lifted to kLeastPivot: L Lᵀ is then definite, but not the matrix
int factor(float* panel, std::size_t stride, std::size_t rows, std::size_t width, float* workspace);

/// The two halves of it for the columns [first, first + block) of a panel, block <= kBlock: their square, and rows
/// below it, [from, from + rows), once the square is done. All columns before have had both. Bits as by factor.
int factor_square(float* panel, std::size_t stride, std::size_t first, std::size_t block, float* workspace);
void factor_rows(float* panel, std::size_t stride, std::size_t first, std::size_t block, std::size_t from,
                 std::size_t rows, float* workspace);

}  // namespace brim::panel
