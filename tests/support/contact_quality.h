#pragma once

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "brim/response/penalty.h"
#include "support/touching.h"

namespace brim::testing {

/// How steady and how straight the force of a body pressed into a plane is, over random sub-voxel positions.
struct ContactQuality {
  double mean_force = 0.0;        ///< normal force over k h³ / h
  double scatter = 0.0;           ///< standard deviation of the normal force over its mean
  double tangential_mean = 0.0;   ///< mean of tangential over normal force
  double tangential_worst = 0.0;  ///< largest of it
  double work_ratio = 0.0;        ///< normal force over −dE/ds, s the height of the body; mean
  double work_ratio_worst = 0.0;  ///< largest distance of one position from that mean
  double contacts = 0.0;          ///< mean number of nodes
};

/// What is pressed into the plane, wherever the plane is put.
/// @param ground  the plane's pose, its normal along its own z
/// @param lift    [m] how much higher than the depth of the measurement
using Pressed = std::function<Touching(const Pose& ground, double lift)>;

/// @param n_any  plane's normal, any length @param h [m]
inline ContactQuality contact_quality(const Pressed& pressed, const Vec3& n_any, unsigned seed, int positions,
                                      double h) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> uniform(0.0, h);
  const Vec3 n = n_any.normalized();
  PenaltyOptions options;
  options.dt = 1.0;
  options.friction_speed = 1.0;
  std::vector<PairState> pairs(1);
  pairs[0].stiffness = 1.0;
  ContactQuality q;
  double sum = 0.0, squares = 0.0;
  std::vector<double> ratios;
  for (int i = 0; i < positions; ++i) {
    const double x = uniform(rng), y = uniform(rng), z = uniform(rng);
    const Pose ground = plane_pose(n, Vec3(x, y, z));
    const auto respond = [&](const Touching& t, Penalty& penalty) {
      const std::vector<Vec3> still(t.contacts.size(), Vec3::Zero());
      penalty.begin(t.contacts, pairs, options, still, still);
    };
    const Touching t = pressed(ground, 0.0);
    Penalty penalty;
    respond(t, penalty);
    std::vector<Vec3> normal(t.contacts.size()), friction(t.contacts.size());
    penalty.forces(std::vector<Vec3>(t.contacts.size(), Vec3::Zero()), normal, friction);
    Vec3 force = Vec3::Zero();
    for (const Vec3& f : normal) force += f;
    const double along = force.dot(n), tangential = (force - along * n).norm() / along;
    // Work: energy falls by F ds when the body is lifted.
    const double e = 1e-4 * h;
    Penalty up, down;
    respond(pressed(ground, e), up);
    respond(pressed(ground, -e), down);
    ratios.push_back(along * 2 * e / (down.energy() - up.energy()));
    q.work_ratio += ratios.back() / positions;
    sum += along, squares += along * along;
    q.tangential_mean += tangential / positions;
    q.tangential_worst = std::max(q.tangential_worst, tangential);
    q.contacts += static_cast<double>(t.contacts.size()) / positions;
  }
  const double mean = sum / positions;
  q.mean_force = mean / (h * h);
  q.scatter = std::sqrt(std::max(0.0, squares / positions - mean * mean)) / mean;
  for (const double r : ratios) q.work_ratio_worst = std::max(q.work_ratio_worst, std::abs(r - q.work_ratio));
  return q;
}

/// Of a sphere. @param press  [m] overlap of sphere and plane @param radius [m]
inline ContactQuality contact_quality(const Vec3& n, unsigned seed, int positions = 16, double radius = 6.0,
                                      double press = 0.5, double h = 1.0, double ramp_voxels = 3.0) {
  const auto sphere = make_sphere(radius);
  const auto plane = make_half_space();
  const Pressed pressed = [&](const Pose& ground, double lift) {
    Pose ball;
    ball.translation = ground.translation + (radius - press + lift) * ground.rotation.col(2);
    return Touching(*sphere, ball, *plane, ground, h, ramp_voxels * h);
  };
  return contact_quality(pressed, n, seed, positions, h);
}

}  // namespace brim::testing
