#pragma once

#include <algorithm>
#include <memory>
#include <numbers>
#include <string>

#include "brim/body/obstacle/obstacle_body.h"
#include "brim/body/rigid/rigid_body.h"
#include "brim/math/rotation.h"
#include "brim/world/world.h"

/// Small scenes of rigid bodies, and what one looks at in them.
namespace brim::testing {

inline WorldOptions options_at(double h) {
  WorldOptions o;
  o.voxel_size = h;
  return o;
}

inline std::unique_ptr<Body> obstacle(std::string name, std::shared_ptr<const Shape> shape, double mu,
                                      const Vec3& x = Vec3::Zero(), const Quat& r = Quat::Identity()) {
  ObstacleModel m;
  m.shape = std::move(shape);
  m.part.material.friction = mu;
  m.keys[0].position = x;
  m.keys[0].rotation = r;
  auto b = std::make_unique<ObstacleBody>(m);
  b->set_name(std::move(name));
  return b;
}

/// Half-space below a plane through the origin.
inline std::unique_ptr<Body> ground(double mu, const Vec3& normal = Vec3(0, 0, 1)) {
  return obstacle("ground", make_half_space(), mu, Vec3::Zero(), Quat::FromTwoVectors(Vec3(0, 0, 1), normal));
}

struct Start {
  Vec3 x = Vec3::Zero();
  Quat rotation = Quat::Identity();
  Vec3 v = Vec3::Zero(), w = Vec3::Zero();
};

inline std::unique_ptr<Body> box(std::string name, const Start& s, double mu = 0.5, double side = 1.0,
                                 double density = 1000.0) {
  RigidModel m;
  m.shape = make_box(Vec3::Constant(side));
  m.mass = density * side * side * side;
  m.inertia = m.mass * side * side / 6.0 * Mat3::Identity();
  m.position = s.x, m.rotation = s.rotation, m.velocity = s.v, m.angular_velocity = s.w;
  m.part.material.friction = mu;
  auto b = std::make_unique<RigidBody>(m);
  b->set_name(std::move(name));
  return b;
}

inline std::unique_ptr<Body> ball(std::string name, const Start& s, double mu = 0.5, double radius = 0.5,
                                  double density = 1000.0) {
  RigidModel m;
  m.shape = make_sphere(radius);
  m.mass = density * 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
  m.inertia = 0.4 * m.mass * radius * radius * Mat3::Identity();
  m.position = s.x, m.rotation = s.rotation, m.velocity = s.v, m.angular_velocity = s.w;
  m.part.material.friction = mu;
  auto b = std::make_unique<RigidBody>(m);
  b->set_name(std::move(name));
  return b;
}

inline Vec3 position(const World& w, int b) { return Vec3(w.q(b)[0], w.q(b)[1], w.q(b)[2]); }
inline Vec3 velocity(const World& w, int b) { return Vec3(w.v(b)[0], w.v(b)[1], w.v(b)[2]); }
inline Vec3 spin(const World& w, int b) { return Vec3(w.v(b)[3], w.v(b)[4], w.v(b)[5]); }

/// Largest |v| + |ω| L/2 of the movable bodies, L = 1 m.
inline double liveliness(const World& w) {
  double most = 0.0;
  for (int b = 0; b < w.body_count(); ++b)
    if (!w.body(b).immobile()) most = std::max(most, velocity(w, b).norm() + 0.5 * spin(w, b).norm());
  return most;
}

/// Steps for a time; @return the worst overlap, [voxels].
inline double run(World& w, double seconds) {
  double worst = 0.0;
  const int steps = static_cast<int>(seconds / w.options().time_step + 0.5);
  for (int s = 0; s < steps; ++s) worst = std::max(worst, w.step().worst_overlap);
  return worst;
}

}  // namespace brim::testing
