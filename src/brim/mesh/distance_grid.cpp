#include "brim/mesh/distance_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "brim/core/error.h"
#include "brim/core/simd.h"
#include "brim/mesh/distance_bounds.h"
#include "brim/mesh/isosurface.h"
#include "brim/mesh/kinked_cubic.h"

namespace brim {

namespace {

/// Value in a cell all of whose 64 nodes exist.
/// @param first  the first of them  @param nx, nxy  nodes from line to line and from plane to plane
/// @param at  place in the cell, 0 to 1
BRIM_WIDE double smooth_value(const float* first, std::ptrdiff_t nx, std::ptrdiff_t nxy, const double* at) {
  const Lanes t = {at[0], at[1], at[2], 0.0}, t2 = t * t, t3 = t2 * t;  // weights of x, y and z together
  const Lanes w[4] = {0.5 * (2.0 * t2 - t3 - t), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0), 0.5 * (4.0 * t2 - 3.0 * t3 + t),
                      0.5 * (t3 - t2)};
  Lanes sum = {};
  for (int m = 0; m < 4; ++m)
    for (int l = 0; l < 4; ++l)
      sum += (w[m][2] * w[l][1]) * __builtin_convertvector(load_lanes(first + l * nx + m * nxy), Lanes);
  return (sum[0] * w[0][0] + sum[1] * w[1][0]) + (sum[2] * w[2][0] + sum[3] * w[3][0]);
}

/// The same where a kink may be felt. @param inverse  [1/m] of the spacing
BRIM_WIDE double kinked_value(const float* first, std::ptrdiff_t nx, std::ptrdiff_t nxy, const double* t,
                              double inverse) {
  const Lanes all = {inverse, inverse, inverse, inverse}, y = {t[1], t[1], t[1], t[1]}, z = {t[2], t[2], t[2], t[2]};
  Lanes line[4];
  for (int l = 0; l < 4; ++l) {
    Lanes row[4];
    for (int m = 0; m < 4; ++m) row[m] = __builtin_convertvector(load_lanes(first + l * nx + m * nxy), Lanes);
    line[l] = kinked_cubic(row[0], row[1], row[2], row[3], z, all);
  }
  const Lanes r = kinked_cubic(line[0], line[1], line[2], line[3], y, all);
  return kinked_cubic(double{r[0]}, double{r[1]}, double{r[2]}, double{r[3]}, t[0], inverse);
}

}  // namespace

DistanceGrid::DistanceGrid(const Vec3& origin, double spacing, const Vec3i& nodes, std::vector<float> values,
                           Interpolation interpolation)
    : origin_(origin),
      spacing_(spacing),
      inverse_spacing_(1.0 / spacing),
      nodes_(nodes),
      values_(std::move(values)),
      interpolation_(interpolation) {
  BRIM_CHECK(spacing, >, 0.0);
  BRIM_CHECK(nodes.minCoeff(), >=, 2);
  BRIM_CHECK(values_.size(), ==, static_cast<std::size_t>(nodes.x()) * nodes.y() * nodes.z());
  box_ = {origin_, origin_ + spacing_ * (nodes_ - Vec3i::Ones()).cast<double>()};
  kinks_ = KinkedCells(values_, nodes, spacing);
}

double DistanceGrid::trilinear(const Vec3& p) const {
  const Vec3 x = (p - origin_) * inverse_spacing_;
  std::array<std::ptrdiff_t, 3> cell{};
  Vec3 t;
  for (int k = 0; k < 3; ++k) {
    cell[k] = std::clamp(static_cast<int>(x[k]), 0, nodes_[k] - 2);
    t[k] = std::clamp(x[k] - static_cast<double>(cell[k]), 0.0, 1.0);
  }
  const std::ptrdiff_t nx = nodes_.x(), nxy = nx * nodes_.y();
  const float* v = values_.data() + cell[0] + nx * cell[1] + nxy * cell[2];
  const auto line = [&](std::ptrdiff_t at) { return v[at] + t[0] * (double{v[at + 1]} - v[at]); };
  const double y0 = line(0), y1 = line(nx), z0 = line(nxy), z1 = line(nxy + nx);
  const double near = y0 + t[1] * (y1 - y0), far = z0 + t[1] * (z1 - z0);
  return near + t[2] * (far - near);
}

double DistanceGrid::tricubic(const Vec3& p) const {
  const Vec3 x = (p - origin_) * inverse_spacing_;
  std::array<int, 3> cell{};
  Vec3 t;
  bool inner = true;
  for (int k = 0; k < 3; ++k) {
    cell[k] = std::clamp(static_cast<int>(std::floor(x[k])), 0, nodes_[k] - 2);
    t[k] = std::clamp(x[k] - cell[k], 0.0, 1.0);
    inner = inner && cell[k] > 0 && cell[k] < nodes_[k] - 2;
  }
  const std::ptrdiff_t nx = nodes_.x(), nxy = nx * nodes_.y();
  const std::ptrdiff_t node = cell[0] + nx * cell[1] + nxy * cell[2];
  const float* base = values_.data() + node;
  if (inner) {
    const auto cell_id = static_cast<std::size_t>(node);
    if (!KinkedCells::holds(kinks_.bits(), cell_id)) return smooth_value(base - 1 - nx - nxy, nx, nxy, t.data());
    if (exact_ && KinkedCells::holds(exact_->bits(), cell_id)) return exact_->value(cell_id, p);
    return kinked_value(base - 1 - nx - nxy, nx, nxy, t.data(), inverse_spacing_);
  }
  // In the first and last cell the missing node continues the line through its two neighbours.
  const auto line = [&](int axis, const auto& at) {
    const double b = at(0), c = at(1);
    return kinked_cubic(cell[axis] > 0 ? at(-1) : b + b - c, b, c, cell[axis] < nodes_[axis] - 2 ? at(2) : c + c - b,
                        t[axis], inverse_spacing_);
  };
  return line(0, [&](int i) {
    return line(1, [&](int j) { return line(2, [&](int k) { return double{base[i + j * nx + k * nxy]}; }); });
  });
}

double DistanceGrid::value(const Vec3& p, Interpolation interpolation) const {
  const Vec3 q = p.cwiseMax(box_.lo).cwiseMin(box_.hi);
  const double d = interpolation == Interpolation::Trilinear ? trilinear(q) : tricubic(q);
  const double outside2 = (p - q).squaredNorm();
  if (outside2 == 0.0) return d;
  const double positive = std::max(0.0, d);
  return std::sqrt(outside2 + positive * positive);
}

double DistanceGrid::least_value(const Vec3& p) const {
  const Vec3 q = p.cwiseMax(box_.lo).cwiseMin(box_.hi), x = (q - origin_) * inverse_spacing_;
  std::size_t node = 0;
  double t2 = 0.0;
  for (int k = 2; k >= 0; --k) {
    const int at = std::min(static_cast<int>(x[k] + 0.5), nodes_[k] - 1);
    node = node * static_cast<std::size_t>(nodes_[k]) + static_cast<std::size_t>(at);
    t2 += (x[k] - at) * (x[k] - at);
  }
  const double d = values_[node];
  const double beyond = std::max(0.0, std::abs(d) - DistanceBounds::kExactBand * spacing_);
  const double least = d - spacing_ * (std::sqrt(t2) + DistanceBounds::kWaviness) - DistanceBounds::kTooFar * beyond;
  const double outside2 = (p - q).squaredNorm();
  if (outside2 == 0.0) return least;
  const double positive = std::max(0.0, least);
  return std::sqrt(outside2 + positive * positive);
}

Aabb DistanceGrid::solid_box(double level) const {
  Aabb box;
  std::size_t n = 0;
  for (int k = 0; k < nodes_.z(); ++k)
    for (int j = 0; j < nodes_.y(); ++j)
      for (int i = 0; i < nodes_.x(); ++i, ++n)
        if (values_[n] <= level) box.extend(Vec3(origin_ + spacing_ * Vec3(i, j, k)));
  return box.empty() ? box : box.inflated(spacing_);
}

MassProperties mass_properties(const DistanceGrid& grid, double density) {
  return mass_properties(isosurface({grid.origin(), grid.spacing(), grid.nodes(), grid.values()}), density);
}

}  // namespace brim
