#include "brim/solve/contact_admm.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "brim/solve/anderson.h"
#include "brim/solve/contact_cone.h"
#include "brim/solve/dense_factor.h"

namespace brim {

namespace {

/// ρ at first, the geometric mean of the largest responses of the scaled contacts, about 10, and of kProximal; its
/// factor when the residuals part by more than kApart; every how many iterations that and the contacts are asked.
constexpr double kStart = 0.003, kFactor = 3.0, kApart = 5.0;
constexpr int kAsk = 20;
/// Over-relaxation; and what keeps the system regular where more rows than velocities are.
constexpr double kRelaxation = 1.6, kProximal = 1e-6;
/// Changes by which iterations are accelerated.
constexpr int kMemory = 20;

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

  std::size_t size() const { return s.size(); }
  /// û of impulses y. @param Gy  G y
  Eigen::VectorXd velocities(const Eigen::VectorXd& Gy) const {
    Eigen::VectorXd u = Gy + g;
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
  void project(const Eigen::VectorXd& v, Eigen::VectorXd& y) const {
    for (std::size_t c = 0; c < size(); ++c) at(y, c) = project_to_cone(at(v, c), friction[c]);
  }
  /// The largest entry of x over its contact's s, as a velocity, [m/s].
  double largest(const Eigen::VectorXd& x) const {
    double most = 0.0;
    for (std::size_t c = 0; c < size(); ++c)
      if (s[c] > 0.0) most = std::max(most, at(x, c).cwiseAbs().maxCoeff() / s[c]);
    return most;
  }
  /// Largest miss of a contact at the impulses y of velocities u, [m/s].
  double miss(const Eigen::VectorXd& y, const Eigen::VectorXd& u) const {
    Eigen::VectorXd next(y.size());
    project(y - u, next);
    return largest(y - next);
  }
};

/// The iteration as a map of v = y − z / ρ, of which y is the nearest point in the cones and z what is left.
struct Iteration {
  explicit Iteration(const Scaled& contacts) : a(contacts) {}

  const Scaled& a;
  double rho = 0.0, lowest = 0.0;  ///< lowest: below it single precision is not enough
  DenseFactor factor;
  Eigen::VectorXd base, G_base;  ///< impulses from which the factor gives the change, so that rounding is of that alone
  Eigen::VectorXd x, y, z, next;  ///< next: v of the next iteration

  /// Takes another ρ, as near to this one as single precision allows. @return false if ρ stays as it is
  bool refactor(double to) {
    const double was = rho;
    rho = std::max(to, lowest);
    if (rho == was) return false;
    while (!factor.factor(a.G, rho + kProximal) && std::isfinite(rho)) rho = lowest = kFactor * rho;
    return true;
  }
  /// x, y, z and next of v.
  void evaluate(const Eigen::VectorXd& v) {
    a.project(v, y);
    z = rho * (y - v);
    x = a.g - z + G_base - (rho + kProximal) * (y - base);
    a.add_correction(z, x);
    next = -x;
    factor.solve(next, x);
    x += base;
    next = kRelaxation * x + (1.0 - kRelaxation) * y - z / rho;
  }
};

}  // namespace

ContactAdmm::Report ContactAdmm::solve(const Eigen::MatrixXd& W, std::span<const Vec3> q,
                                       std::span<const double> friction, double tolerance, int max_iterations,
                                       std::span<Vec3> impulse) {
  Report report;
  const std::size_t n = q.size();
  const auto rows = static_cast<Eigen::Index>(3 * n);
  Scaled a{std::vector<double>(n, 0.0), friction, {}, Eigen::VectorXd::Zero(rows)};
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(rows), y = scale;
  for (std::size_t c = 0; c < n; ++c) {
    const auto i = static_cast<Eigen::Index>(3 * c);
    if (!(W(i, i) > 0.0)) continue;
    a.s[c] = 1.0 / std::sqrt(W.block<3, 3>(i, i).trace() / 3.0);
    at(scale, c).setConstant(a.s[c]);
    at(a.g, c) = a.s[c] * q[c];
    at(y, c) = impulse[c] / a.s[c];
  }
  a.G = scale.asDiagonal() * (0.5 * (W + W.transpose())) * scale.asDiagonal();
  Iteration it(a);
  it.base = it.y = y, it.G_base = a.G * y;
  Eigen::VectorXd v = y - a.velocities(it.G_base) / kStart, after = y;
  Anderson ahead(rows, kMemory);
  it.refactor(kStart);
  double least = std::numeric_limits<double>::infinity();
  while (report.iterations < max_iterations) {
    it.evaluate(v);
    ++report.iterations;
    if (!it.next.allFinite()) break;
    if (report.iterations % kAsk == 0 || report.iterations == max_iterations) {
      a.project(it.next, after);
      it.base = after, it.G_base.noalias() = a.G * after;
      const double miss = a.miss(after, a.velocities(it.G_base));
      if (miss < least) y = after, least = miss;
      report.converged = miss <= tolerance;
      if (report.converged) break;
      const double primal = a.largest(it.x - after), change = it.rho * a.largest(after - it.y), was = it.rho;
      const bool more = primal > kApart * change;
      if ((more || change > kApart * primal) && it.refactor(more ? was * kFactor : was / kFactor)) {
        v = after + (was / it.rho) * (it.next - after);
        ahead.forget();
        continue;
      }
    }
    ahead.step(v, it.next);
  }
  for (std::size_t c = 0; c < n; ++c)
    if (a.s[c] > 0.0) impulse[c] = a.s[c] * at(y, c);
  return report;
}

}  // namespace brim
