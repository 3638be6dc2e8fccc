#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/map/row_transpose.h"
#include "brim/math/types.h"

namespace brim {

/// Sparse weights by rows: row p defines how point p follows sources (particles, nodes).
///   u_p = Σ_i w_pi u_i                                    without normals
///   u_p = Σ_i [ w_pi I + n_p b_piᵀ ] u_i                  with a normal n_p and levers b_pi
/// The second form lets motion along n_p follow another rule (the rate of a density) than tangential motion.
struct WeightRows {
  std::vector<std::int32_t> first{0};  ///< shape (rows + 1)
  std::vector<std::int32_t> source;    ///< shape (entries)
  std::vector<double> weight;          ///< shape (entries)
  std::vector<Vec3> lever;             ///< b, shape (entries) or empty
  std::vector<Vec3> normal;            ///< n, shape (rows) or empty

  std::size_t rows() const { return first.size() - 1; }
  void clear() {
    first.assign(1, 0);
    source.clear(), weight.clear(), lever.clear(), normal.clear();
  }
};

/// Applies the rows to velocities of the sources.
/// @param v  three numbers per source
/// @param u  of each row
void apply_rows(const WeightRows& rows, std::span<const double> v, std::span<Vec3> u);
/// Adds the transpose of the rows times a force at each: Q += Wᵀ f.
/// @param transpose  of the rows
/// @param Q          three numbers per source
void add_transpose(const WeightRows& rows, const RowTranspose& transpose, std::span<const Vec3> f, std::span<double> Q);

/// Product of two sparse maps: points that follow particles that follow nodes; entries of one node are merged and
/// sorted. The weights of `inner` must have no levers. If outer and inner reproduce constants and linear fields (Σ w =
/// 1, Σ w x = r), so does the product.
/// Same bits for any number of threads.  Tests: tests/map/weight_rows_test.cpp
WeightRows compose(const WeightRows& outer, const WeightRows& inner);

}  // namespace brim
