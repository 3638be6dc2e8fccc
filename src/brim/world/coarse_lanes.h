#pragma once

#include <span>

#include "brim/math/types.h"

/// The loops of CoarseSpace over nodes and contacts, with wide instructions.  Tests: tests/world/coarse_lanes_test.cpp
namespace brim::coarse_lanes {

/// Σ Sᵀ K S of two sides: six rows of eight numbers, of which the first six are used.
struct PairSums {
  alignas(64) double aa[6][8] = {}, bb[6][8] = {}, ab[6][8] = {};  ///< ab: negative
};
/// Adds a contact. @param a, b  S of its sides, three rows of eight  @param K  symmetric, nine numbers
void add_contact(const double* a, const double* b, const double* K, PairSums& sum);

/// Σ f and Σ (x − c) × f. @param force  shape (3 places)  @param out  six numbers
void sum_wrench(std::span<const Vec3> place, const Vec3& c, std::span<const double> force, double* out);
/// v += t + w × x. @param v  shape (3 places)
void add_motion(std::span<const Vec3> place, const Vec3& t, const Vec3& w, std::span<double> v);

}  // namespace brim::coarse_lanes
