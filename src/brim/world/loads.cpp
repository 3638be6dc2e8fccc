#include "brim/world/loads.h"

#include <algorithm>
#include <cmath>

namespace brim {

namespace {

/// [m] largest descent of a box's centre onto the lowest immobile part, ending on its flattest side: a standing body
/// may topple, but its own height is no drop.
double drop_height(std::span<const WorldPart> parts, const Vec3& down, const Aabb& box) {
  double lowest = -std::numeric_limits<double>::infinity();
  for (const WorldPart& p : parts)
    if (is_fixed(p)) {
      const Aabb b = p.body->bounds(p.index);
      double far = 0.0;  // farthest point of the obstacle's top along gravity
      for (int a = 0; a < 3; ++a)
        if (down[a] != 0.0) far += down[a] * (down[a] > 0 ? b.lo[a] : b.hi[a]);
      if (!std::isfinite(far)) {
        far = 0.0;
        for (int a = 0; a < 3; ++a)
          if (down[a] != 0.0) far += down[a] * (down[a] > 0 ? b.hi[a] : b.lo[a]);
      }
      if (std::isfinite(far)) lowest = std::max(lowest, far);
    }
  if (!std::isfinite(lowest)) return 0.0;
  return std::max(0.0, lowest - 0.5 * box.extent().minCoeff() - down.dot(box.center()));
}

}  // namespace

void Loads::raise_to(const Loads& other) {
  pressure = std::max(pressure, other.pressure);
  areal_mass = std::max(areal_mass, other.areal_mass);
  impact_energy = std::max(impact_energy, other.impact_energy);
}

double sheet_pull(const Environment& env) { return std::max(env.gravity.norm(), kLeastPull); }

std::vector<Loads> estimate_loads(std::span<const WorldPart> parts, std::span<const double> part_speed,
                                  const Environment& env) {
  std::vector<Loads> loads(parts.size());
  const double g = env.gravity.norm();
  const Vec3 down = g > 0.0 ? Vec3(env.gravity / g) : Vec3(0, 0, -1);
  int axis = 0;
  down.cwiseAbs().maxCoeff(&axis);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;

  Aabb all;
  for (const WorldPart& p : parts)
    if (!is_fixed(p)) all.extend(p.body->bounds(p.index));
  if (all.empty() || !all.lo.allFinite() || !all.hi.allFinite()) return loads;

  constexpr int kColumns = 48;
  std::vector<double> column(kColumns * kColumns, 0.0);
  const auto cell = [&](double x, int a) {
    const double extent = std::max(all.hi[a] - all.lo[a], 1e-12);
    return std::clamp(static_cast<int>(kColumns * (x - all.lo[a]) / extent), 0, kColumns - 1);
  };
  // From the top down, so that each column contains the weight above.
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (!is_fixed(parts[i])) order.push_back(i);
  const auto depth = [&](std::size_t i) { return down.dot(parts[i].body->bounds(parts[i].index).center()); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return depth(i) < depth(j); });
  for (const std::size_t i : order) {
    const WorldPart& p = parts[i];
    const Aabb b = p.body->bounds(p.index);
    double areal = p.info.areal_mass;
    if (!(areal > 0.0)) {
      const double area = std::max(b.extent()[u], p.h) * std::max(b.extent()[v], p.h);
      areal = p.body->mass() / p.body->part_count() / area;
    }
    loads[i].areal_mass = areal;
    const double pull = p.info.modulus == 0.0 && !p.info.conforming ? sheet_pull(env) : g;
    const double fall = drop_height(parts, down, b);
    const double speed2 = part_speed[i] * part_speed[i] + 2.0 * g * fall;
    loads[i].impact_energy = areal * speed2;
    for (int y = cell(b.lo[v], v); y <= cell(b.hi[v], v); ++y)
      for (int x = cell(b.lo[u], u); x <= cell(b.hi[u], u); ++x) {
        double& weight = column[y * kColumns + x];
        weight += pull * areal;
        loads[i].pressure = std::max(loads[i].pressure, weight);
      }
  }
  return loads;
}

namespace {

/// Stiffness that keeps bodies from passing through each other, with the factor on p for static loads.
double least_stiffness(double share, const Loads& loads, double w, double dt) {
  return std::max(
      {share * loads.pressure, 8.0 * loads.impact_energy / w, 4.0 * loads.areal_mass * w / (1.2 * dt * dt)});
}

}  // namespace

double choose_stiffness(const Loads& loads, double w, double dt) { return least_stiffness(2000.0, loads, w, dt); }

double soften_stiffness(double k, double E, const Loads& loads, double w, double dt) {
  if (std::isinf(E)) return k;
  double chosen = kContactModulus * E;
  if (loads.areal_mass > 0.0) {  // else nothing that moves is known
    const double voxel = w / 3.0, motion2 = loads.impact_energy / loads.areal_mass * dt * dt;
    chosen = std::min(chosen, k * std::clamp(kMostOfFast * voxel * voxel / motion2, kMostOfFast, kMostOfSlow));
  }
  return std::max(chosen, least_stiffness(100.0, loads, w, dt));
}

double conforming_stiffness(double k, double E, const Loads& loads) {
  const double p = loads.pressure;
  return p > 0.0 ? std::min(k, std::clamp(20.0 * E, 20.0 * p, 1000.0 * p)) : k;
}

}  // namespace brim
