#pragma once

#include <cstddef>
#include <cstdint>

/// Dense kernels on panels: columns of floats one after another, `stride` apart. The rows are worked on in lanes, each
/// row by itself, so that wide and narrow instructions give the same bits. Kernels may read and write up to kPad
/// rows past the last: strides and buffers leave room.
namespace brim::panel {

inline constexpr std::size_t kPad = 16;
/// Columns of a block that is factored by itself before the rest of the panel follows.
inline constexpr std::size_t kBlock = 12;
/// Floats of a column or row of such a block's square in a stream: two registers.
inline constexpr std::size_t kSquare = 16;

/// Rows of a panel with its padding.
inline std::size_t padded(std::size_t rows) { return (rows + kPad - 1) / kPad * kPad; }

/// C = A Bᵀ.
/// @param a, b    shape (rows, depth), (columns, depth), columns a multiple of 3; both with the stride of one panel
/// @param c       shape (rows, columns), stride padded(rows), overwritten
void multiply_transposed(const float* a, const float* b, std::size_t stride, std::size_t rows, std::size_t columns,
                         std::size_t depth, float* c);

/// Smallest pivot of a matrix whose diagonal is 1: beyond it, single precision knows no more.
inline constexpr float kLeastPivot = 1e-5f;

/// Replaces the lower triangle of the first `width` rows by its Cholesky factor L, and the rows below by X L⁻ᵀ. Squares
/// of L along its diagonal are inverted, so that no solve divides.
/// @param rows       all rows of the panel, >= width; width a multiple of 3
/// @param workspace  room for padded(rows) x 12 floats
/// @return pivots that were lifted to kLeastPivot: L Lᵀ is then definite, but not the matrix
int factor(float* panel, std::size_t stride, std::size_t rows, std::size_t width, float* workspace);

/// A factored panel as solves read it, in the order in which they do: for every twelve columns the square on the
/// diagonal, inverted, by columns and by rows, and apart from it what is below in chunks of eight rows, a chunk of each
/// of the columns in turn. T is float, or Triple, ten bits a number: equal steps over each column's range, a third of
/// the memory for solves that are bound by it. An iteration loses nothing by that, as entries of a factor that is
/// scaled to a diagonal of ones are at most 1. Numbers of three columns in a row of a panel: in bits 0 to 9, 11 to 20
/// and 22 to 31.
enum class Triple : std::uint32_t {};

template <class T>
struct Stream {
  T* below;       ///< shape (stream_size)
  float* column;  ///< of the squares, zeros above the diagonal, shape (width, kSquare)
  float* row;     ///< of the squares, zeros beyond the diagonal, shape (width, kSquare)
  float* step;    ///< of each column, what 1 of T is worth; shape (width)
};
/// @return how many of T
template <class T>
std::size_t stream_size(std::size_t rows, std::size_t width);
void make_stream(const float* panel, std::size_t stride, std::size_t rows, std::size_t width, const Stream<float>& out);
void make_stream(const float* panel, std::size_t stride, std::size_t rows, std::size_t width,
                 const Stream<Triple>& out);

/// The first `width` of y become x = L⁻¹ y, what is below takes y − L x. @param y  shape (rows), and kPad more whose
/// numbers mean nothing afterwards
void solve_forward(const Stream<float>& panel, std::size_t rows, std::size_t width, float* y);
void solve_forward(const Stream<Triple>& panel, std::size_t rows, std::size_t width, float* y);
/// The first `width` of y become L⁻ᵀ (y − Bᵀ z), B the rows below and z what is there in y.
/// @param y  shape (rows), and kPad more that are zero
void solve_backward(const Stream<float>& panel, std::size_t rows, std::size_t width, float* y);
void solve_backward(const Stream<Triple>& panel, std::size_t rows, std::size_t width, float* y);

}  // namespace brim::panel
