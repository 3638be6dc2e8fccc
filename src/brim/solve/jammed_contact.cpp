#include "brim/solve/jammed_contact.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace brim {

namespace {

/// Response, relative to the largest one, below which a direction counts as immobile; largest α over |W⁺ q|.
constexpr double kImmobile = 1e-9, kMostAlong = 1e3;

}  // namespace

Vec3 hold_jammed(const Mat3& W, double friction, const Vec3& q, const Vec3& along) {
  const Eigen::SelfAdjointEigenSolver<Mat3> modes(0.5 * (W + W.transpose()));
  Vec3 hold = Vec3::Zero(), d = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vec3 mode = modes.eigenvectors().col(i);
    const double response = modes.eigenvalues()[i];
    if (response > kImmobile * modes.eigenvalues()[2])
      hold -= mode.dot(q) / response * mode;
    else
      d += mode.dot(along) * mode;
  }
  if (!(d.x() > 0.0)) return Vec3::Zero();
  d.normalize();
  // a α² + 2 b α + c = μ² λ_n² − |λ_t|² must not be negative, and λ_n not either.
  const double mu2 = friction * friction;
  const auto product = [&](const Vec3& x, const Vec3& y) { return mu2 * x.x() * y.x() - x.tail<2>().dot(y.tail<2>()); };
  const double a = product(d, d), b = product(hold, d), c = product(hold, hold), most = kMostAlong * hold.norm();
  double alpha = 0.0;
  if (c < 0.0 || hold.x() < 0.0) {
    const double root = std::sqrt(std::max(0.0, b * b - a * c));
    alpha = b > 0.0 ? -c / (b + root) : a > 0.0 ? (root - b) / a : most;
  }
  Vec3 next = hold + std::clamp(alpha, 0.0, most) * d;
  next.x() = std::max(0.0, next.x());
  const double limit = friction * next.x(), length = next.tail<2>().norm();
  if (length > limit) next.tail<2>() *= limit / length;
  return next;
}

}  // namespace brim
