#include "brim/solve/contact_admm.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "brim/solve/contact_cone.h"

namespace brim {

namespace {

/// ρ at first, over the contacts' own scaled responses, which are 1; its factor when the residuals part by more than
/// kApart; every how many iterations that is asked.
constexpr double kStart = 0.1, kFactor = 3.0, kApart = 5.0;
constexpr int kAsk = 10;
/// Over-relaxation; and what keeps the system regular where more rows than velocities are.
constexpr double kRelaxation = 1.6, kProximal = 1e-6;

}  // namespace

ContactAdmm::Report ContactAdmm::solve(const Eigen::MatrixXd& W, std::span<const Vec3> q,
                                       std::span<const double> friction, double tolerance, int max_iterations,
                                       std::span<Vec3> impulse) {
  Report report;
  const auto n = static_cast<Eigen::Index>(q.size());
  const auto at = [](auto& x, Eigen::Index c) { return x.template segment<3>(3 * c); };
  // λ = s y with s² the inverse of the contact's own response; what nothing moves takes no part.
  std::vector<double> s(q.size(), 0.0);
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(3 * n), g = scale;
  for (Eigen::Index c = 0; c < n; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const double own = W.block<3, 3>(3 * c, 3 * c).trace() / 3.0;
    if (!(W(3 * c, 3 * c) > 0.0)) continue;
    s[i] = 1.0 / std::sqrt(own);
    at(scale, c).setConstant(s[i]);
    at(g, c) = s[i] * q[i];
  }
  const Eigen::MatrixXd G = scale.asDiagonal() * (0.5 * (W + W.transpose())) * scale.asDiagonal();
  Eigen::VectorXd y = Eigen::VectorXd::Zero(3 * n);
  for (Eigen::Index c = 0; c < n; ++c)
    if (const auto i = static_cast<std::size_t>(c); s[i] > 0.0) at(y, c) = impulse[i] / s[i];
  Eigen::VectorXd x = y, z = G * y + g, rhs(3 * n);  // z: û, scaled
  const auto correction = [&](Eigen::Index c) {
    return friction[static_cast<std::size_t>(c)] * std::hypot(z[3 * c + 1], z[3 * c + 2]);
  };
  for (Eigen::Index c = 0; c < n; ++c) z[3 * c] += correction(c);
  double rho = kStart;
  Eigen::LLT<Eigen::MatrixXd> factor;
  const auto factorize = [&] {
    Eigen::MatrixXd A = G;
    A.diagonal().array() += rho + kProximal;
    factor.compute(A);
  };
  factorize();
  while (report.iterations < max_iterations) {
    rhs = z - g + kProximal * x + rho * y;
    for (Eigen::Index c = 0; c < n; ++c) rhs[3 * c] -= correction(c);
    x = factor.solve(rhs);
    double primal = 0.0, change = 0.0;  // [m/s]
    for (Eigen::Index c = 0; c < n; ++c) {
      const auto i = static_cast<std::size_t>(c);
      if (!(s[i] > 0.0)) continue;
      const Vec3 ahead = kRelaxation * at(x, c) + (1.0 - kRelaxation) * at(y, c);
      const Vec3 next = project_to_cone(ahead - at(z, c) / rho, friction[i]);
      at(z, c) -= rho * (ahead - next);
      primal = std::max(primal, (at(x, c) - next).cwiseAbs().maxCoeff() / s[i]);
      change = std::max(change, rho * (next - at(y, c)).cwiseAbs().maxCoeff() / s[i]);
      at(y, c) = next;
    }
    ++report.iterations;
    report.converged = std::max(primal, change) <= tolerance;
    if (report.converged || !std::isfinite(primal + change)) break;
    if (report.iterations % kAsk != 0) continue;
    if (primal > kApart * change)
      rho *= kFactor, factorize();
    else if (change > kApart * primal)
      rho /= kFactor, factorize();
  }
  if (!y.allFinite()) return report;
  for (Eigen::Index c = 0; c < n; ++c)
    if (const auto i = static_cast<std::size_t>(c); s[i] > 0.0) impulse[i] = s[i] * at(y, c);
  return report;
}

}  // namespace brim
