#include "brim/math/svd3.h"

#include <utility>

namespace brim {

namespace {

/// Turns coordinates p and q so that S(p, q) vanishes; V takes the same turn.
void rotate(Mat3& S, Mat3& V, int p, int q, double small) {
  const double off = S(p, q);
  if (!(std::abs(off) > small)) return;
  const double theta = (S(q, q) - S(p, p)) / (2.0 * off);
  const double t = (theta >= 0.0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
  const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
  const int r = 3 - p - q;
  S(p, p) -= t * off;
  S(q, q) += t * off;
  S(p, q) = S(q, p) = 0.0;
  const double rp = S(r, p), rq = S(r, q);
  S(r, p) = S(p, r) = c * rp - s * rq;
  S(r, q) = S(q, r) = s * rp + c * rq;
  for (int i = 0; i < 3; ++i) {
    const double vp = V(i, p), vq = V(i, q);
    V(i, p) = c * vp - s * vq;
    V(i, q) = s * vp + c * vq;
  }
}

}  // namespace

Svd3 svd3(const Mat3& matrix) {
  // Unit size, so that squares neither vanish nor overflow.
  const double size = matrix.cwiseAbs().maxCoeff();
  if (!(size > 0.0) || !std::isfinite(size)) return {Mat3::Identity(), Mat3::Identity(), Vec3::Constant(size)};
  const Mat3 F = matrix / size;
  Mat3 S = F.transpose() * F, V = Mat3::Identity();
  const double small = 1e-17 * S.trace();
  for (int sweep = 0; sweep < 12; ++sweep) {
    if (std::abs(S(0, 1)) + std::abs(S(0, 2)) + std::abs(S(1, 2)) <= 3.0 * small) break;
    rotate(S, V, 0, 1, small);
    rotate(S, V, 0, 2, small);
    rotate(S, V, 1, 2, small);
  }
  // Largest first; an exchange flips one column so that V stays a rotation.
  Vec3 e = S.diagonal();
  const auto order = [&](int i, int j) {
    if (e[i] >= e[j]) return;
    std::swap(e[i], e[j]);
    const Vec3 column = V.col(i);
    V.col(i) = V.col(j);
    V.col(j) = -column;
  };
  order(0, 1);
  order(0, 2);
  order(1, 2);

  const Mat3 B = F * V;
  Svd3 d;
  d.V = V;
  const double s0 = B.col(0).norm();
  const Vec3 u0 = B.col(0) / s0;
  const Vec3 b1 = B.col(1) - u0 * u0.dot(B.col(1));
  const double s1 = b1.norm();
  Vec3 u1 = s1 > 1e-15 * s0 ? Vec3(b1 / s1) : u0.unitOrthogonal();
  u1 = (u1 - u0 * u0.dot(u1)).normalized();
  d.U.col(0) = u0;
  d.U.col(1) = u1;
  d.U.col(2) = u0.cross(u1);
  d.s = size * Vec3(s0, u1.dot(B.col(1)), d.U.col(2).dot(B.col(2)));
  return d;
}

}  // namespace brim
