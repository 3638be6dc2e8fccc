#include "brim/solve/contact_admm.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "brim/solve/contact_cone.h"
#include "brim/solve/dense_factor.h"

namespace brim {

namespace {

/// ρ at first, over the contacts' own scaled responses, which are 1; its factor when the residuals part by more than
/// kApart; every how many iterations that is asked.
constexpr double kStart = 0.1, kFactor = 3.0, kApart = 5.0;
constexpr int kAsk = 10;
/// Over-relaxation; and what keeps the system regular where more rows than velocities are.
constexpr double kRelaxation = 1.6, kProximal = 1e-6;
/// Change of the iterates over the tolerance, from which on the contacts themselves are asked.
constexpr double kNear = 10.0;
/// Tolerance down to which single precision does, over the largest velocity.
constexpr double kSingle = 1e-5;
/// Share of the tolerance that it works to, so that what it finds holds in double as well.
constexpr double kStricter = 0.5;

/// What DenseFactor does, in double precision.
class DoubleFactor {
 public:
  bool factor(const Eigen::MatrixXd& A, double shift) {
    Eigen::MatrixXd shifted = A;
    shifted.diagonal().array() += shift;
    factor_.compute(shifted);
    return true;
  }
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) { x = factor_.solve(b); }

 private:
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

template <class V>
auto at(V& x, std::size_t c) {
  return x.template segment<3>(static_cast<Eigen::Index>(3 * c));
}

/// Contacts scaled by their own responses: λ = s y, û = z / s.
struct Scaled {
  std::vector<double> s;  ///< 0 where nothing moves
  std::span<const double> friction;
  Eigen::MatrixXd G;
  Eigen::VectorXd g;
  Eigen::VectorXd x, y, z;
  double rho = kStart;

  std::size_t size() const { return s.size(); }
  /// û of the impulses y.
  Eigen::VectorXd velocities() const {
    Eigen::VectorXd u = G * y + g;
    add_correction(u, u);
    return u;
  }
  /// u_n += μ |û_t| at every contact. @param slip  what û_t is read of
  void add_correction(const Eigen::VectorXd& slip, Eigen::VectorXd& u) const {
    for (std::size_t c = 0; c < size(); ++c) {
      const auto i = static_cast<Eigen::Index>(3 * c);
      u[i] += friction[c] * std::hypot(slip[i + 1], slip[i + 2]);
    }
  }
  /// Largest miss of a contact at the impulses y, [m/s].
  double miss() const {
    const Eigen::VectorXd u = velocities();
    double worst = 0.0;
    for (std::size_t c = 0; c < size(); ++c)
      if (s[c] > 0.0) {
        const Vec3 own = at(y, c);
        worst = std::max(worst, (own - project_to_cone(own - at(u, c), friction[c])).cwiseAbs().maxCoeff() / s[c]);
      }
    return worst;
  }
};

/// Iterates until the impulses change no more, or the factor is none.
template <class Factor>
void iterate(Scaled& a, double tolerance, int max_iterations, ContactAdmm::Report& report) {
  Factor factor;
  Eigen::VectorXd rhs;
  report.converged = false;
  if (!factor.factor(a.G, a.rho + kProximal)) return;
  while (report.iterations < max_iterations) {
    rhs = a.g - a.z;
    a.add_correction(a.z, rhs);
    rhs = kProximal * a.x + a.rho * a.y - rhs;
    factor.solve(rhs, a.x);
    double primal = 0.0, change = 0.0;  // [m/s]
    for (std::size_t c = 0; c < a.size(); ++c) {
      if (!(a.s[c] > 0.0)) continue;
      const Vec3 ahead = kRelaxation * at(a.x, c) + (1.0 - kRelaxation) * at(a.y, c);
      const Vec3 next = project_to_cone(ahead - at(a.z, c) / a.rho, a.friction[c]);
      at(a.z, c) -= a.rho * (ahead - next);
      primal = std::max(primal, (at(a.x, c) - next).cwiseAbs().maxCoeff() / a.s[c]);
      change = std::max(change, a.rho * (next - at(a.y, c)).cwiseAbs().maxCoeff() / a.s[c]);
      at(a.y, c) = next;
    }
    ++report.iterations;
    const double left = std::max(primal, change);
    report.converged = left <= tolerance;
    if (report.converged || !std::isfinite(left)) return;
    if (report.iterations % kAsk != 0) continue;
    // What is left of the iterates says more than what it means for the contacts.
    if (left <= kNear * tolerance && a.miss() <= tolerance) {
      report.converged = true;
      return;
    }
    if (primal > kApart * change)
      a.rho *= kFactor;
    else if (change > kApart * primal)
      a.rho /= kFactor;
    else
      continue;
    if (!factor.factor(a.G, a.rho + kProximal)) return;
  }
}

}  // namespace

ContactAdmm::Report ContactAdmm::solve(const Eigen::MatrixXd& W, std::span<const Vec3> q,
                                       std::span<const double> friction, double tolerance, int max_iterations,
                                       std::span<Vec3> impulse) {
  Report report;
  const std::size_t n = q.size();
  const auto rows = static_cast<Eigen::Index>(3 * n);
  Scaled a{std::vector<double>(n, 0.0), friction, {}, Eigen::VectorXd::Zero(rows), {}, Eigen::VectorXd::Zero(rows), {}};
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(rows);
  for (std::size_t c = 0; c < n; ++c) {
    const auto i = static_cast<Eigen::Index>(3 * c);
    if (!(W(i, i) > 0.0)) continue;
    a.s[c] = 1.0 / std::sqrt(W.block<3, 3>(i, i).trace() / 3.0);
    at(scale, c).setConstant(a.s[c]);
    at(a.g, c) = a.s[c] * q[c];
    at(a.y, c) = impulse[c] / a.s[c];
  }
  a.G = scale.asDiagonal() * (0.5 * (W + W.transpose())) * scale.asDiagonal();
  a.x = a.y, a.z = a.velocities();
  double fastest = 0.0;
  for (std::size_t c = 0; c < n; ++c)
    if (a.s[c] > 0.0) fastest = std::max(fastest, at(a.z, c).cwiseAbs().maxCoeff() / a.s[c]);
  // In single precision first: what it finds is judged in double.
  const Eigen::VectorXd first = a.y;
  iterate<DenseFactor>(a, std::max(kStricter * tolerance, kSingle * fastest), max_iterations, report);
  if (!a.y.allFinite()) a.y = first, a.rho = kStart;
  report.converged = a.miss() <= tolerance;
  a.x = a.y, a.z = a.velocities();
  if (!report.converged && report.iterations < max_iterations)
    iterate<DoubleFactor>(a, tolerance, max_iterations, report);
  if (!a.y.allFinite()) return report;
  for (std::size_t c = 0; c < n; ++c)
    if (a.s[c] > 0.0) impulse[c] = a.s[c] * at(a.y, c);
  return report;
}

}  // namespace brim
