#include "brim/world/impulse.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "brim/core/error.h"
#include "brim/world/matter_points.h"

namespace brim {

namespace {

using Coordinates = Eigen::VectorXd;

/// Most coordinates for which the matrix is set up.
constexpr Eigen::Index kDenseCoordinates = 120;

Coordinates filtered(const Body& body, Coordinates x) {
  body.filter({x.data(), static_cast<std::size_t>(x.size())});
  return x;
}

/// P M x for a filtered x.
Coordinates image_of(const Body& body, const Coordinates& x) {
  Coordinates y = Coordinates::Zero(x.size());
  const auto n = static_cast<std::size_t>(x.size());
  body.apply_mass({x.data(), n}, {y.data(), n});
  return filtered(body, std::move(y));
}

Coordinates solve_dense(const Body& body, const Coordinates& b) {
  const Eigen::Index n = b.size();
  Eigen::MatrixXd A(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Coordinates unit = Coordinates::Unit(n, i), free = filtered(body, unit);
    A.col(i) = image_of(body, free) + (unit - free);  // directions that are gone keep a definite matrix
  }
  const Eigen::LDLT<Eigen::MatrixXd> factor(A);
  Coordinates x = filtered(body, factor.solve(b));
  x += filtered(body, factor.solve(b - image_of(body, x)));
  return x;
}

Coordinates solve_many(const Body& body, const Coordinates& b) {
  constexpr double kRounding = 1e-15;
  Coordinates x = Coordinates::Zero(b.size()), r = b, d = r;
  double r2 = r.squaredNorm();
  const double enough = kRounding * kRounding * r2;
  const Eigen::Index most = 2 * b.size();
  for (Eigen::Index i = 0; i < most && r2 > enough; ++i) {
    const Coordinates Ad = image_of(body, d);
    const double a = r2 / d.dot(Ad);
    x += a * d, r -= a * Ad;
    const double next = r.squaredNorm();
    d = r + (next / r2) * d;
    r2 = next;
  }
  return x;
}

}  // namespace

std::vector<double> velocity_change(const Body& body, std::span<const double> p) {
  const Coordinates b = filtered(body, Eigen::Map<const Coordinates>(p.data(), static_cast<Eigen::Index>(p.size())));
  const Coordinates x = b.size() <= kDenseCoordinates ? solve_dense(body, b) : solve_many(body, b);
  return {x.begin(), x.end()};
}

std::optional<ImpulseEffect> find_impulse_effect(std::span<const WorldPart> parts, double ramp_voxels,
                                                 std::span<const double> q, const Vec3& impulse, const Vec3& point) {
  if (parts.empty()) return {};
  const WorldPart& part = parts[MatterPoints::nearest_part(parts, point)];
  MatterPoints held;
  try {
    held = MatterPoints::of_part(part, ramp_voxels * part.h, q, {point});
  } catch (const InputError&) {
    return {};
  }
  const Body& body = *part.body;
  const std::int32_t source = held.source(0);
  std::unique_ptr<Map> map;
  body.make_map(part.index, held.positions(), {&source, 1}, map);
  std::vector<double> p(body.v_size(), 0.0);
  map->apply_transpose(std::vector<Vec3>{impulse}, p);
  return ImpulseEffect{held.positions()[0], velocity_change(body, p)};
}

}  // namespace brim
