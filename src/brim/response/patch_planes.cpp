#include "brim/response/patch_planes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "brim/math/small_symmetric.h"
#include "brim/response/patch_model.h"

namespace brim {

namespace {

/// A surface is a plane if at least kFewest nodes, with curvature of at most kLevel/h, give distances that fit a plane
/// to kPlane voxels.
constexpr std::size_t kFewest = 8;
constexpr double kLevel = 0.15, kPlane = 1e-3;
/// [voxels] distance between the places at which a plane is probed; largest misfit there.
constexpr double kProbe = 0.4, kProbedPlane = 1e-4;

/// The plane that fits nodes best: mean normal of the gradients, corrected as far as the nodes' positions determine it.
SurfacePlane best_plane(const ContactSet& s, std::span<const std::size_t> nodes, bool of_a, const Vec3& x, double h) {
  Vec3 mean = Vec3::Zero(), normal = Vec3::Zero();
  double mean_d = 0.0;
  const auto n = static_cast<double>(nodes.size());
  for (const std::size_t c : nodes) {
    mean += s.node_at(c, h) / n, mean_d += distance_to(s, c, of_a, h) / n;
    normal -= (of_a ? s.gradient_a[c] : s.gradient_b[c]).normalized() / n;
  }
  Mat3 spread = Mat3::Identity() * (1e-9 * n * h * h);
  Vec3 miss = Vec3::Zero();
  for (const std::size_t c : nodes) {
    const Vec3 d = s.node_at(c, h) - mean;
    spread += d * d.transpose();
    miss += (distance_to(s, c, of_a, h) - mean_d - normal.dot(d)) * d;
  }
  const Vec3 slope = normal + solve_symmetric(spread, miss);
  return {mean_d + slope.dot(x - mean), slope};
}

}  // namespace

bool fit_plane(const ContactSet& s, std::span<const std::size_t> nodes, bool of_a, const Vec3& x, double h,
               std::vector<std::size_t>& level, SurfacePlane& plane) {
  level.clear();
  for (const std::size_t c : nodes) {
    const Vec3 g = of_a ? s.gradient_a[c] : s.gradient_b[c];
    if (h * (of_a ? s.curvature_a(c) : s.curvature_b(c)).norm() < kLevel * g.norm()) level.push_back(c);
  }
  const std::size_t fewest = std::max(kFewest, (3 * level.size() + 3) / 4);
  while (level.size() >= fewest) {
    plane = best_plane(s, level, of_a, x, h);
    const auto miss = [&](std::size_t c) {
      return std::abs(distance_to(s, c, of_a, h) - plane.gap - plane.slope.dot(s.node_at(c, h) - x));
    };
    double worst = 0.0;
    for (const std::size_t c : level) worst = std::max(worst, miss(c));
    if (worst <= kPlane * h) return true;
    std::erase_if(level, [&](std::size_t c) { return miss(c) > 0.5 * worst; });
  }
  return false;
}

bool probe_plane(const CubeSide& side, const Vec3& x, const Vec3& n, double h, SurfacePlane& plane) {
  Eigen::Index least = 0;
  n.cwiseAbs().minCoeff(&least);
  const Vec3 e = n.cross(Vec3::Unit(least)).normalized(), f = n.cross(e);
  constexpr int kPlaces = 9;
  // Of three by three places, −1 to 1 along each.
  constexpr std::array<double, kPlaces> u = {-1, 0, 1, -1, 0, 1, -1, 0, 1}, v = {-1, -1, -1, 0, 0, 0, 1, 1, 1};
  std::array<double, kPlaces> px, py, pz, d;
  for (int k = 0; k < kPlaces; ++k) {
    const Vec3 at = side.pose.to_local(x + kProbe * h * (u[k] * e + v[k] * f));
    px[k] = at.x(), py[k] = at.y(), pz[k] = at.z();
  }
  side.solid->distances({px.data(), py.data(), pz.data(), kPlaces}, d.data());
  double mean = 0.0, along_e = 0.0, along_f = 0.0;
  for (int k = 0; k < kPlaces; ++k) mean += d[k] / kPlaces, along_e += u[k] * d[k] / 6.0, along_f += v[k] * d[k] / 6.0;
  for (int k = 0; k < kPlaces; ++k)
    if (!(std::abs(d[k] - mean - u[k] * along_e - v[k] * along_f) <= kProbedPlane * h)) return false;
  const Vec3 across = (along_e * e + along_f * f) / (kProbe * h);
  const double rest = 1.0 - across.squaredNorm();
  if (!(rest > 0.0)) return false;
  plane = {mean, across + std::sqrt(rest) * n};
  return true;
}

}  // namespace brim
