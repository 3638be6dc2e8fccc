#include "brim/solve/contact_admm.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
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
/// Change of the iterates over the goal, from which on the contacts themselves are asked; how often they are at least.
constexpr double kNear = 10.0;
constexpr int kAskAll = 50;
/// Tolerance down to which single precision does, over the largest velocity.
constexpr double kSingle = 1e-5;
/// Share of the tolerance that is the goal, so that what the contacts meet survives rounding and what comes after.
constexpr double kGoal = 0.3;
/// Velocities per contact up to which their matrix, not that of the contacts, is factored.
constexpr double kFewVelocities = 1.5;
/// Iterations in which the miss has to halve: while it is above the tolerance, and below.
constexpr int kPatience = 300, kPatienceBelow = 30;

/// W as a matrix, and its factor. @tparam Factor  DenseFactor, or DoubleFactor
template <class Factor>
class DenseResponses {
 public:
  explicit DenseResponses(const Eigen::MatrixXd& W) : W_(&W) {}
  bool factor(double shift) { return factor_.factor(*W_, shift); }
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) { factor_.solve(b, x); }
  void multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const { y.noalias() = *W_ * x; }

 private:
  const Eigen::MatrixXd* W_;
  Factor factor_;
};

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
  Eigen::VectorXd g;
  Eigen::VectorXd x, y, z;
  double rho = kStart;

  std::size_t size() const { return s.size(); }
  /// û of the impulses y.
  template <class Responses>
  Eigen::VectorXd velocities(const Responses& responses) const {
    Eigen::VectorXd u;
    responses.multiply(y, u);
    u += g;
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
  template <class Responses>
  double miss(const Responses& responses) const {
    const Eigen::VectorXd u = velocities(responses);
    double worst = 0.0;
    for (std::size_t c = 0; c < size(); ++c)
      if (s[c] > 0.0) {
        const Vec3 own = at(y, c);
        worst = std::max(worst, (own - project_to_cone(own - at(u, c), friction[c])).cwiseAbs().maxCoeff() / s[c]);
      }
    return worst;
  }
};

/// True when a miss is worth further iterations.
class Progress {
 public:
  bool goes_on(int iteration, double miss, double tolerance) {
    if (miss < 0.5 * best_) best_ = miss, at_ = iteration;
    return iteration - at_ < (miss > tolerance ? kPatience : kPatienceBelow);
  }

 private:
  double best_ = std::numeric_limits<double>::infinity();
  int at_ = 0;
};

/// Iterates until the impulses change no more, the contacts miss by no more than the goal or come no nearer to it, or
/// there is no factor.
template <class Responses>
void iterate(Responses& responses, Scaled& a, double goal, double tolerance, int max_iterations,
             ContactAdmm::Report& report) {
  Eigen::VectorXd rhs;
  Progress progress;
  if (!responses.factor(a.rho + kProximal)) return;
  while (report.iterations < max_iterations) {
    rhs = a.g - a.z;
    a.add_correction(a.z, rhs);
    rhs = kProximal * a.x + a.rho * a.y - rhs;
    responses.solve(rhs, a.x);
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
    if (left <= goal || !std::isfinite(left)) return;
    if (report.iterations % kAsk != 0) continue;
    // What is left of the iterates says more than what it means for the contacts.
    if (left <= kNear * goal || report.iterations % kAskAll == 0) {
      const double miss = a.miss(responses);
      if (miss <= goal || !progress.goes_on(report.iterations, miss, tolerance)) return;
    }
    if (primal > kApart * change)
      a.rho *= kFactor;
    else if (change > kApart * primal)
      a.rho /= kFactor;
    else
      continue;
    if (!responses.factor(a.rho + kProximal)) return;
  }
}

}  // namespace

ContactAdmm::Report ContactAdmm::solve(ContactResponses responses, std::span<const Vec3> q,
                                       std::span<const double> friction, double tolerance, int max_iterations,
                                       std::span<Vec3> impulse) {
  Report report;
  const std::size_t n = q.size();
  const auto rows = static_cast<Eigen::Index>(3 * n);
  Scaled a{std::vector<double>(n, 0.0), friction, Eigen::VectorXd::Zero(rows), {}, Eigen::VectorXd::Zero(rows), {}};
  for (std::size_t c = 0; c < n; ++c) {
    const Mat3 W = responses.local(c);
    if (W(0, 0) > 0.0) {
      a.s[c] = 1.0 / std::sqrt(W.trace() / 3.0);
      at(a.g, c) = a.s[c] * q[c];
      at(a.y, c) = impulse[c] / a.s[c];
    }
    responses.scale(c, a.s[c]);
  }
  const auto run = [&](auto&& form, double goal) {
    a.x = a.y, a.z = a.velocities(form);
    iterate(form, a, goal, tolerance, max_iterations, report);
    if (a.y.allFinite()) report.converged = a.miss(form) <= tolerance;
  };
  if (static_cast<double>(responses.width()) <= kFewVelocities * static_cast<double>(n)) {
    run(responses, kGoal * tolerance);
  } else {
    Eigen::MatrixXd W = responses.dense();
    W = 0.5 * (W + W.transpose()).eval();
    double fastest = 0.0;
    const Eigen::VectorXd first = a.y, z = a.velocities(responses);
    for (std::size_t c = 0; c < n; ++c)
      if (a.s[c] > 0.0) fastest = std::max(fastest, at(z, c).cwiseAbs().maxCoeff() / a.s[c]);
    // In single precision first: what it finds is judged in double.
    run(DenseResponses<DenseFactor>(W), std::max(kGoal * tolerance, kSingle * fastest));
    if (!a.y.allFinite()) a.y = first, a.rho = kStart;
    if (!report.converged && report.iterations < max_iterations)
      run(DenseResponses<DoubleFactor>(W), kGoal * tolerance);
  }
  if (!a.y.allFinite()) return report;
  for (std::size_t c = 0; c < n; ++c)
    if (a.s[c] > 0.0) impulse[c] = a.s[c] * at(a.y, c);
  return report;
}

}  // namespace brim
