#include "brim/map/dense_map.h"

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

void DenseMap::reset(std::size_t n, std::size_t coordinates) {
  points_ = n;
  nv_ = coordinates;
  value_.assign(3 * n * coordinates, 0.0);
}

void DenseMap::apply(std::span<const double> v, std::span<Vec3> u) const {
  BRIM_CHECK(v.size(), ==, nv_);
  BRIM_CHECK(u.size(), ==, points_);
  const Eigen::Map<const Eigen::VectorXd> x(v.data(), static_cast<Eigen::Index>(nv_));
  parallel_for(
      points_, [&](std::size_t p) { u[p] = row(p) * x; }, 256);
}

void DenseMap::apply_transpose(std::span<const Vec3> f, std::span<double> Q) const {
  BRIM_CHECK(f.size(), ==, points_);
  BRIM_CHECK(Q.size(), ==, nv_);
  // In the order of the points, on one thread: the same bits always.
  Eigen::Map<Eigen::VectorXd> y(Q.data(), static_cast<Eigen::Index>(nv_));
  for (std::size_t p = 0; p < points_; ++p) y += row(p).transpose() * f[p];
}

void DenseMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  BRIM_CHECK(K.size(), ==, points_);
  auto block = D.block(first);
  for (std::size_t p = 0; p < points_; ++p)
    if (!K[p].isZero(0.0)) block += row(p).transpose() * K[p] * row(p);
}

}  // namespace brim
