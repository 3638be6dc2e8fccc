#pragma once

#include <cstddef>
#include <cstdint>

#include "brim/solve/panel.h"

namespace brim::panel {

/// Floats of a column or row of the squares on the diagonal. Two registers read four more.
inline constexpr std::size_t kSquare = kBlock;

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
