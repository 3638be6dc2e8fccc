#pragma once

#include <cstddef>
#include <cstdint>

#include "brim/math/types.h"

namespace brim::detail {

/// Data of the product with a BlockMatrix, by row: slots first[r] <= s < first[r + 1], except diagonal[r].
struct BlockRows {
  const std::int32_t* first;
  const std::int32_t* diagonal;
  const std::int32_t* column;  ///< per slot
  const float* value;          ///< per slot, nine numbers column by column; one extra entry at the end may be read
  const Mat3* on_diagonal;     ///< per row
};

/// Rows [begin, end) of y += a K x + b m x. multiply_rows_wide needs AVX2 and gives the same bits:
///   (K x)_r = (s_0 + s_1) + s_2,  s_c: sum of column c of the blocks times x_c, the diagonal first, slots in order
void multiply_rows(const BlockRows& K, std::size_t begin, std::size_t end, double a, double b, const double* m,
                   const double* x, double* y);
void multiply_rows_wide(const BlockRows& K, std::size_t begin, std::size_t end, double a, double b, const double* m,
                        const double* x, double* y);
/// True where multiply_rows_wide may be called.
bool has_wide_rows();

}  // namespace brim::detail
