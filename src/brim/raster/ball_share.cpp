#include "brim/raster/ball_share.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "brim/math/ramp.h"

namespace brim {

namespace {

/// Points and weights of Gauss and Legendre on [0, 1], the first half of eight: the others lie as far from the end.
constexpr std::array<double, 4> kPlace = {0.0198550717512319, 0.1016667612931866, 0.2372337950418355,
                                          0.4082826787521751};
constexpr std::array<double, 4> kWeight = {0.0506142681451881, 0.1111905172266872, 0.1568533229389437,
                                           0.1813418916891810};

/// Area that two discs share, [m²]. @param d  [m] between their centres
double lens(double a, double b, double d) {
  if (d >= a + b) return 0.0;
  const double small = std::min(a, b), large = std::max(a, b);
  if (d <= large - small) return std::numbers::pi * small * small;
  const double x = (d * d + a * a - b * b) / (2.0 * d);
  const auto segment = [](double r, double t) {
    t = std::clamp(t, -r, r);
    return r * r * std::acos(t / r) - t * std::sqrt(r * r - t * t);
  };
  return segment(a, x) + segment(b, d - x);
}

/// ∫ of the lens of the ball's section and a disc of the solid over lo <= z <= hi.
/// @param radius  [m] of the solid's section at a height
template <class Radius>
double slices(const Vec3& p, double r, double lo, double hi, const Radius& radius) {
  lo = std::max(lo, p.z() - r), hi = std::min(hi, p.z() + r);
  if (lo >= hi) return 0.0;
  const double away = std::hypot(p.x(), p.y());
  double sum = 0.0;
  for (std::size_t k = 0; k < kPlace.size(); ++k)
    for (const double t : {kPlace[k], 1.0 - kPlace[k]}) {
      const double z = lo + t * (hi - lo);
      sum += kWeight[k] * lens(std::sqrt(std::max(0.0, r * r - (z - p.z()) * (z - p.z()))), radius(z), away);
    }
  return sum * (hi - lo);
}

/// Half the width of a disc of radius r at a distance z from its centre, [m].
double chord(double r, double z) { return std::sqrt(std::max(0.0, r * r - z * z)); }

double volume(double r) { return 4.0 / 3.0 * std::numbers::pi * r * r * r; }

}  // namespace

double ball_share_of_sphere(const Vec3& p, double w, double radius) {
  const double d = p.norm(), r = 0.5 * w;
  if (d >= radius + r) return 0.0;
  if (d <= std::abs(radius - r)) return radius >= r ? 1.0 : std::pow(radius / r, 3);
  const double both = radius + r - d, apart = radius - r;
  return std::numbers::pi * both * both * (d * d + 2.0 * d * (radius + r) - 3.0 * apart * apart) /
         (12.0 * d * volume(r));
}

double ball_share_of_box(const Vec3& p, double w, const Vec3& half) {
  double share = 1.0;
  for (int a = 0; a < 3; ++a) share *= std::max(0.0, ramp(p[a] - half[a], w) - ramp(p[a] + half[a], w));
  return share;
}

double ball_share_of_cylinder(const Vec3& p, double w, double radius, double half) {
  const double r = 0.5 * w;
  return slices(p, r, -half, half, [=](double) { return radius; }) / volume(r);
}

double ball_share_of_capsule(const Vec3& p, double w, double radius, double half) {
  const double r = 0.5 * w;
  const auto round = [=](double z) {
    const double beyond = std::abs(z) - half;
    return std::sqrt(std::max(0.0, radius * radius - beyond * beyond));
  };
  return (slices(p, r, -half, half, [=](double) { return radius; }) + slices(p, r, half, half + radius, round) +
          slices(p, r, -half - radius, -half, round)) /
         volume(r);
}

double ball_share_of_torus(const Vec3& p, double w, double radius, double tube) {
  const double r = 0.5 * w;
  return (slices(p, r, -tube, tube, [=](double z) { return radius + chord(tube, z); }) -
          slices(p, r, -tube, tube, [=](double z) { return radius - chord(tube, z); })) /
         volume(r);
}

double ball_share_of_bowl(const Vec3& p, double w, double middle, double half) {
  const double r = 0.5 * w, outer = middle + half, inner = middle - half;
  return (slices(p, r, -outer, 0.0, [=](double z) { return chord(outer, z); }) -
          slices(p, r, -inner, 0.0, [=](double z) { return chord(inner, z); }) +
          slices(p, r, 0.0, half, [=](double z) { return middle + chord(half, z); }) -
          slices(p, r, 0.0, half, [=](double z) { return middle - chord(half, z); })) /
         volume(r);
}

double ball_share_of_cup(const Vec3& p, double w, double radius, double height, double thickness) {
  const double r = 0.5 * w;
  return (slices(p, r, 0.0, height, [=](double) { return radius; }) -
          slices(p, r, thickness, height, [=](double) { return radius - thickness; })) /
         volume(r);
}

}  // namespace brim
