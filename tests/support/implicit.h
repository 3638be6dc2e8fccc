#pragma once

#include <vector>

#include "brim/body/body.h"

namespace brim::testing {

/// A body with its state, stepped by the linearly implicit Euler method without contact.
struct Stepper {
  Body& body;
  std::vector<double> q, v;
  double time = 0.0;
  int iterations = 0;  ///< of CG, last step

  explicit Stepper(Body& b) : body(b), q(b.q_size()), v(b.v_size()) {
    body.initial_state(q, v);
    body.update(0.0, q, v);
  }

  /// A Δv = dt (Q + dt ∂Q/∂q v), filtered CG to a relative residual.
  void step(double dt, const Environment& env, double tolerance = 1e-10) {
    body.prescribe(time, dt, q, v);
    body.update(time, q, v);
    body.begin_solve(dt);
    const std::size_t n = v.size();
    std::vector<double> b(n, 0.0), x(n, 0.0), r, p, Ap(n), z(n);
    body.apply_stiffness(v, b);
    for (double& e : b) e *= dt;
    body.add_forces(env, b);
    for (double& e : b) e *= dt;
    body.filter(b);
    BlockDiagonal D;
    D.reset(body.block_sizes());
    body.add_system_diagonal(0, D);
    D.factor();
    r = b;
    const auto dot = [](const auto& u, const auto& w) {
      double s = 0.0;
      for (std::size_t i = 0; i < u.size(); ++i) s += u[i] * w[i];
      return s;
    };
    const double target = tolerance * tolerance * dot(b, b);
    D.solve(r, z);
    body.filter(z);
    p = z;
    double rz = dot(r, z);
    for (iterations = 0; iterations < 5000 && dot(r, r) > target; ++iterations) {
      std::fill(Ap.begin(), Ap.end(), 0.0);
      body.apply_system(p, Ap);
      body.filter(Ap);
      const double alpha = rz / dot(p, Ap);
      for (std::size_t i = 0; i < n; ++i) x[i] += alpha * p[i], r[i] -= alpha * Ap[i];
      D.solve(r, z);
      body.filter(z);
      const double next = dot(r, z);
      for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + next / rz * p[i];
      rz = next;
    }
    for (std::size_t i = 0; i < n; ++i) v[i] += x[i];
    body.advance(dt, q, v);
    body.finish_step(time, dt, q, v);
    time += dt;
    body.update(time, q, v);
  }

  /// Steps so long that inertia hardly counts: close to Newton's method for the state of rest.
  void relax(int steps, const Environment& env, double dt = 100.0) {
    for (int s = 0; s < steps; ++s) {
      std::fill(v.begin(), v.end(), 0.0);
      step(dt, env);
    }
    std::fill(v.begin(), v.end(), 0.0);
    body.update(time, q, v);
  }

  Vec3 position(std::size_t i) const { return Vec3(q[3 * i], q[3 * i + 1], q[3 * i + 2]); }
};

}  // namespace brim::testing
