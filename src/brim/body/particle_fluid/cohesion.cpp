#include "brim/body/particle_fluid/cohesion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "brim/core/parallel.h"

namespace brim {

namespace {

/// ∫ q³ (1 − q)³ from 0 to q.
double primitive(double q) {
  const double q2 = q * q, q4 = q2 * q2;
  return q4 * (0.25 - 0.6 * q + 0.5 * q2 - q2 * q / 7.0);
}

/// −u(q) of the class.
double depth(double q) {
  if (q >= 1.0) return 0.0;
  if (q >= 0.5) return primitive(1.0) - primitive(q);
  return primitive(1.0) - primitive(0.5) + 2.0 * (primitive(0.5) - primitive(q)) - (0.5 - q) / 64.0;
}

}  // namespace

Cohesion::Cohesion(double support, double spacing, double tension) : support_(support) {
  if (!(tension > 0.0)) return;
  tension_ = tension;
  // Bonds that a plane of the lattice cuts, per s²: those that rise by k planes are cut by k of them.
  double bonds = 0.0;
  const int n = static_cast<int>(std::ceil(support / spacing));
  for (int z = 1; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) bonds += z * depth(spacing * std::sqrt(double(x * x + y * y + z * z)) / support);
  strength_ = 2.0 * tension * spacing * spacing / (support * bonds);
}

double Cohesion::longest_step(double density, double spacing) const {
  constexpr double kStable = 0.7;
  if (!(tension_ > 0.0)) return std::numeric_limits<double>::infinity();
  return kStable * std::sqrt(density * spacing * spacing * spacing / (2.0 * std::numbers::pi * tension_));
}

double Cohesion::pull_over_r(double r) const {
  const double q = r / support_;
  if (q >= 1.0 || !(r > 0.0)) return 0.0;
  const double t = q * (1.0 - q), c = t * t * t;
  return strength_ * (q > 0.5 ? c : 2.0 * c - 1.0 / 64.0) / r;
}

double Cohesion::energy(double r) const { return -strength_ * support_ * depth(r / support_); }

void Cohesion::add_forces(std::span<const Vec3> x, const FluidPairs& pairs, std::span<Vec3> y) const {
  parallel_blocks(x.size(), FluidPairs::kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      pairs.for_neighbours(i, [&](std::int32_t j, const FluidPairs::Vec4&) {
        const Vec3 d = x[i] - x[j];
        y[i] -= pull_over_r(d.norm()) * d;
      });
  });
}

double Cohesion::energy(std::span<const Vec3> x, const FluidPairs& pairs) const {
  double e = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i)
    pairs.for_neighbours(i, [&](std::int32_t j, const FluidPairs::Vec4&) { e += 0.5 * energy((x[i] - x[j]).norm()); });
  return e;
}

}  // namespace brim
