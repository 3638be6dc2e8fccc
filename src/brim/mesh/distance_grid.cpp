#include "brim/mesh/distance_grid.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "brim/core/error.h"
#include "brim/core/simd.h"
#include "brim/mesh/distance_bounds.h"
#include "brim/mesh/isosurface.h"

namespace brim {

namespace {

// Weights of four nodes around the cell [1, 2] for the fraction t in [0, 1], and their derivatives.
struct CubicWeights {
  std::array<double, 4> w, d;
};

// Catmull-Rom; in the first and last cell the missing node continues the line through its two neighbours.
CubicWeights cubic_weights(double t, bool first, bool last) {
  const double t2 = t * t, t3 = t2 * t;
  CubicWeights c{
      {0.5 * (-t3 + 2 * t2 - t), 0.5 * (3 * t3 - 5 * t2 + 2), 0.5 * (-3 * t3 + 4 * t2 + t), 0.5 * (t3 - t2)},
      {0.5 * (-3 * t2 + 4 * t - 1), 0.5 * (9 * t2 - 10 * t), 0.5 * (-9 * t2 + 8 * t + 1), 0.5 * (3 * t2 - 2 * t)}};
  for (auto* w : {&c.w, &c.d}) {
    if (first) {
      (*w)[1] += 2.0 * (*w)[0];
      (*w)[2] -= (*w)[0];
      (*w)[0] = 0.0;
    }
    if (last) {
      (*w)[2] += 2.0 * (*w)[3];
      (*w)[1] -= (*w)[3];
      (*w)[3] = 0.0;
    }
  }
  return c;
}

/// Catmull-Rom in a cell all of whose 64 nodes exist, four of a line at once.
/// @param first  the first of the 64 nodes  @param nx, nxy  nodes from line to line and from plane to plane
/// @param tx, ty, tz  place in the cell, 0 to 1
BRIM_WIDE double tricubic(const float* first, std::ptrdiff_t nx, std::ptrdiff_t nxy, double tx, double ty, double tz) {
  const Lanes t = {tx, ty, tz, 0.0}, t2 = t * t, t3 = t2 * t;  // weights of x, y and z together
  const Lanes w[4] = {0.5 * (2.0 * t2 - t3 - t), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0), 0.5 * (4.0 * t2 - 3.0 * t3 + t),
                      0.5 * (t3 - t2)};
  Lanes sum = {};
  for (int m = 0; m < 4; ++m)
    for (int l = 0; l < 4; ++l) {
      FloatLanes row;
      std::memcpy(&row, first + l * nx + m * nxy, sizeof(row));
      sum += (w[m][2] * w[l][1]) * __builtin_convertvector(row, Lanes);
    }
  return (sum[0] * w[0][0] + sum[1] * w[1][0]) + (sum[2] * w[2][0] + sum[3] * w[3][0]);
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

double DistanceGrid::inside_value(const Vec3& p, Interpolation interpolation, Vec3* gradient) const {
  const Vec3 x = (p - origin_) * inverse_spacing_;
  std::array<int, 3> cell{};
  Vec3 t;
  for (int k = 0; k < 3; ++k) {
    cell[k] = std::clamp(static_cast<int>(std::floor(x[k])), 0, nodes_[k] - 2);
    t[k] = std::clamp(x[k] - cell[k], 0.0, 1.0);
  }
  const std::size_t nx = static_cast<std::size_t>(nodes_.x()), nxy = nx * static_cast<std::size_t>(nodes_.y());
  const float* base = values_.data() + static_cast<std::size_t>(cell[0]) + nx * static_cast<std::size_t>(cell[1]) +
                      nxy * static_cast<std::size_t>(cell[2]);
  const auto inner = [&](int k) { return cell[k] > 0 && cell[k] < nodes_[k] - 2; };
  if (gradient == nullptr && interpolation == Interpolation::Tricubic && inner(0) && inner(1) && inner(2))
    return tricubic(base - 1 - nx - nxy, static_cast<std::ptrdiff_t>(nx), static_cast<std::ptrdiff_t>(nxy), t[0], t[1],
                    t[2]);
  std::array<CubicWeights, 3> c;
  std::array<std::array<int, 2>, 3> range;  // first and last of the four nodes that exist
  for (int k = 0; k < 3; ++k) {
    if (interpolation == Interpolation::Trilinear) {
      c[k] = {{0.0, 1.0 - t[k], t[k], 0.0}, {0.0, -1.0, 1.0, 0.0}};
      range[k] = {1, 2};
    } else {
      const bool first = cell[k] == 0, last = cell[k] == nodes_[k] - 2;
      c[k] = cubic_weights(t[k], first, last);
      range[k] = {first ? 1 : 0, last ? 2 : 3};
    }
  }
  double value = 0.0;
  if (gradient == nullptr) {
    for (int m = range[2][0]; m <= range[2][1]; ++m)
      for (int l = range[1][0]; l <= range[1][1]; ++l) {
        const float* row =
            base + (l - 1) * static_cast<std::ptrdiff_t>(nx) + (m - 1) * static_cast<std::ptrdiff_t>(nxy);
        double line = 0.0;
        for (int k = range[0][0]; k <= range[0][1]; ++k) line += c[0].w[k] * row[k - 1];
        value += c[2].w[m] * c[1].w[l] * line;
      }
    return value;
  }
  Vec3 slope = Vec3::Zero();
  for (int m = range[2][0]; m <= range[2][1]; ++m) {
    double plane = 0.0, plane_x = 0.0, plane_y = 0.0;
    for (int l = range[1][0]; l <= range[1][1]; ++l) {
      const float* row = base + (l - 1) * static_cast<std::ptrdiff_t>(nx) + (m - 1) * static_cast<std::ptrdiff_t>(nxy);
      double line = 0.0, line_x = 0.0;
      for (int k = range[0][0]; k <= range[0][1]; ++k) {
        line += c[0].w[k] * row[k - 1];
        line_x += c[0].d[k] * row[k - 1];
      }
      plane += c[1].w[l] * line;
      plane_x += c[1].w[l] * line_x;
      plane_y += c[1].d[l] * line;
    }
    value += c[2].w[m] * plane;
    slope += Vec3(c[2].w[m] * plane_x, c[2].w[m] * plane_y, c[2].d[m] * plane);
  }
  if (gradient) *gradient = slope / spacing_;
  return value;
}

double DistanceGrid::value(const Vec3& p, Interpolation interpolation) const {
  const Vec3 q = p.cwiseMax(box_.lo).cwiseMin(box_.hi);
  const double d = interpolation == Interpolation::Trilinear ? trilinear(q) : inside_value(q, interpolation, nullptr);
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

Vec3 DistanceGrid::gradient(const Vec3& p) const {
  const Vec3 q = p.cwiseMax(box_.lo).cwiseMin(box_.hi);
  Vec3 g;
  const double d = inside_value(q, interpolation_, &g);
  const Vec3 away = p - q;
  if (away.squaredNorm() == 0.0) return g;
  // Along the axes that leave the box the distance to it grows; along the others q moves with p.
  const double positive = std::max(0.0, d);
  Vec3 r = away;
  for (int k = 0; k < 3; ++k)
    if (away[k] == 0.0) r[k] = positive * g[k];
  return r / std::sqrt(away.squaredNorm() + positive * positive);
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
