#pragma once

#include <cstddef>
#include <cstdint>

#include "brim/solve/panel.h"

namespace brim::panel {

/// Floats of a column or row of the diagonal squares. Two registers read four more.
inline constexpr std::size_t kSquare = kBlock;

/// A factored panel in the order in which solves read it: for every twelve columns the inverted diagonal square, by
/// columns and by rows; separately the rows below in chunks of eight, a chunk of each column in turn. T is float, or
/// Triple with ten bits a number: equal steps over each column's range, a third of the memory for solves that are bound
/// by it. This costs no iterations, as entries of a factor scaled to a unit diagonal are at most 1. A Triple holds the
/// numbers of three columns in one row: in bits 0 to 9, 11 to 20 and 22 to 31.
enum class Triple : std::uint32_t {};

template <class T>
struct Stream {
  T* below;       ///< shape (stream_size)
  float* column;  ///< of the squares, zeros above the diagonal, shape (width, kSquare)
  float* row;     ///< of the squares, zeros beyond the diagonal, shape (width, kSquare)
  float* step;    ///< per column: value of 1 in T; shape (width)
};
/// @return number of T
template <class T>
std::size_t stream_size(std::size_t rows, std::size_t width);
void make_stream(const float* panel, std::size_t stride, std::size_t rows, std::size_t width, const Stream<float>& out);
void make_stream(const float* panel, std::size_t stride, std::size_t rows, std::size_t width,
                 const Stream<Triple>& out);

/// The first `width` of y become x = L⁻¹ y, the rest y − L x. @param y  shape (rows), and kPad more that are undefined
/// afterwards
void solve_forward(const Stream<float>& panel, std::size_t rows, std::size_t width, float* y);
void solve_forward(const Stream<Triple>& panel, std::size_t rows, std::size_t width, float* y);
/// The first `width` of y become L⁻ᵀ (y − Bᵀ z), B: the rows below, z: the rest of y.
/// @param y  shape (rows), and kPad more that are zero
void solve_backward(const Stream<float>& panel, std::size_t rows, std::size_t width, float* y);
void solve_backward(const Stream<Triple>& panel, std::size_t rows, std::size_t width, float* y);

}  // namespace brim::panel
