#include "brim/scene/exact_solid.h"

#include <numbers>

namespace brim {

namespace {

constexpr double kPi = std::numbers::pi;

/// A part of a solid that is round about z: volume, first and second moments about the origin. Parts are added and
/// taken away.
struct Round {
  double volume = 0.0;  ///< [m³]
  double z = 0.0;       ///< ∫ z, [m⁴]
  double across = 0.0;  ///< ∫ y² + z², [m⁵]
  double along = 0.0;   ///< ∫ x² + y², [m⁵]
  Round operator+(const Round& o) const { return {volume + o.volume, z + o.z, across + o.across, along + o.along}; }
  Round operator-(const Round& o) const { return {volume - o.volume, z - o.z, across - o.across, along - o.along}; }
};

Round ball(double r) {
  const double v = 4.0 / 3.0 * kPi * r * r * r;
  return {v, 0.0, 0.4 * v * r * r, 0.4 * v * r * r};
}

/// The half below z = 0.
Round half_ball(double r) {
  const double v = 2.0 / 3.0 * kPi * r * r * r;
  return {v, -0.375 * r * v, 0.4 * v * r * r, 0.4 * v * r * r};
}

/// From z = lo to z = hi.
Round cylinder(double r, double lo, double hi) {
  const double v = kPi * r * r * (hi - lo), middle = 0.5 * (lo + hi), square = (lo * lo + lo * hi + hi * hi) / 3.0;
  return {v, v * middle, v * (0.25 * r * r + square), 0.5 * v * r * r};
}

Round torus(double radius, double tube) {
  const double v = 2.0 * kPi * kPi * radius * tube * tube, rr = radius * radius, tt = tube * tube;
  return {v, 0.0, v * (0.5 * rr + 0.625 * tt), v * (rr + 0.75 * tt)};
}

/// The half above z = 0.
Round half_torus(double radius, double tube) {
  Round half = torus(radius, tube);
  half.volume *= 0.5, half.across *= 0.5, half.along *= 0.5;
  half.z = half.volume * 4.0 * tube / (3.0 * kPi);
  return half;
}

/// Two half balls, each with its centre of mass 3r/8 beyond the cylinder's end.
Round capsule(double r, double length) {
  Round ends = ball(r);
  const double away = 0.5 * length + 0.375 * r, own = 0.375 * r;
  ends.across += ends.volume * (away * away - own * own);
  return cylinder(r, -0.5 * length, 0.5 * length) + ends;
}

MassProperties unit(const Round& r) {
  MassProperties m;
  m.volume = m.mass = r.volume;
  m.center = Vec3(0.0, 0.0, r.z / r.volume);
  const double across = r.across - r.z * r.z / r.volume;
  m.inertia = Vec3(across, across, r.along).asDiagonal();
  return m;
}

}  // namespace

std::optional<ExactSolid> exact_solid(const Node& n, double scale) {
  const std::string kind = n.string("kind");
  const auto length = [&](const char* key) { return scale * n.number(key); };
  if (kind == "plane") return ExactSolid{make_half_space()};
  if (kind == "box") return ExactSolid{make_box(scale * n.vec3("size"))};
  if (kind == "sphere") {
    const double r = length("radius");
    return ExactSolid{make_sphere(r), unit(ball(r)), 4.0 * kPi * r * r};
  }
  if (kind == "cylinder") {
    const double r = length("radius"), l = length("length");
    return ExactSolid{make_cylinder(r, l), unit(cylinder(r, -0.5 * l, 0.5 * l)), 2.0 * kPi * r * (r + l)};
  }
  if (kind == "capsule") {
    const double r = length("radius"), l = length("length");
    return ExactSolid{make_capsule(r, l), unit(capsule(r, l)), 2.0 * kPi * r * (l + 2.0 * r)};
  }
  if (kind == "torus") {
    const double r = length("radius"), tube = length("tube");
    return ExactSolid{make_torus(r, tube), unit(torus(r, tube)), 4.0 * kPi * kPi * r * tube};
  }
  if (kind == "bowl") {
    const double r = length("radius"), t = length("thickness"), in = r - t, middle = r - 0.5 * t;
    return ExactSolid{make_bowl(r, t), unit(half_ball(r) - half_ball(in) + half_torus(middle, 0.5 * t)),
                      2.0 * kPi * (r * r + in * in) + kPi * t * (kPi * middle)};
  }
  if (kind == "cup") {
    const double r = length("radius"), h = length("height"), t = length("thickness"), in = r - t;
    const double walls = 2.0 * kPi * (r * h + in * (h - t)), flat = kPi * (r * r + (r * r - in * in) + in * in);
    return ExactSolid{make_cup(r, h, t), unit(cylinder(r, 0.0, h) - cylinder(in, t, h)), walls + flat};
  }
  return std::nullopt;
}

}  // namespace brim
