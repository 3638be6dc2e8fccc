#pragma once

#include <cmath>

#include "brim/body/fem/elastic_law.h"
#include "brim/core/simd.h"
#include "brim/math/svd3.h"

/// The elastic laws for eight deformation gradients at a time: forces in double and stiffness in single precision. F =
/// R S is decomposed by Newton's iteration X ← (X + X⁻ᵀ)/2 for R (Higham 1986) and Jacobi's method for the principal
/// frame of F Rᵀ; nearly flat or inverted elements use svd3. The bits of an element do not depend on the others or on
/// the instruction set. For files with BRIM_WIDE functions (TetLanes, SampleLanes).
namespace brim::elastic_lanes {

inline constexpr int kCount = kWideLanes;
static_assert(kCount == 2 * kLanes);

/// det F over |F|³ below which an element is too flat for Newton's iteration.
inline constexpr double kFlat = 0.02;
/// Change of an entry of R at which the iteration ends: the next change, its square, is below the last bit.
inline constexpr double kSettled = 1e-8;
inline constexpr int kMostIterations = 12;
inline constexpr int kJacobiSweeps = 4;

using Mat3L = Lanes[3][3];
using Mat3W = WideFloats[3][3];

template <class L>
BRIM_INLINE void cofactor(const L (&X)[3][3], L (&C)[3][3]) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      C[r][c] = X[(r + 1) % 3][(c + 1) % 3] * X[(r + 2) % 3][(c + 2) % 3] -
                X[(r + 1) % 3][(c + 2) % 3] * X[(r + 2) % 3][(c + 1) % 3];
}

template <class L>
BRIM_INLINE L determinant(const L (&X)[3][3], const L (&C)[3][3]) {
  return X[0][0] * C[0][0] + X[0][1] * C[0][1] + X[0][2] * C[0][2];
}

template <class Flags>
BRIM_INLINE bool any(const Flags& flags) {
  Flags f = flags;
  for (std::size_t k = 1; k < sizeof(Flags) / sizeof(f[0]); ++k) f[0] |= f[k];
  return f[0] != 0;
}

BRIM_INLINE Lanes absolute(const Lanes& x) { return x < 0.0 ? -x : x; }

/// R of F = R S, proper also when F is inverted.
BRIM_INLINE void nearest_rotation(const Mat3L& F, Mat3L& R) {
  Mat3L C;
  cofactor(F, C);
  const Lanes det = determinant(F, C);
  Lanes n = {};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) n += F[r][c] * F[r][c];
  LaneFlags hard = ~((det > 0.0) & (det * det > kFlat * kFlat * n * n * n));
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) R[r][c] = hard ? (r == c ? Lanes{} + 1.0 : Lanes{}) : F[r][c];
  // A converged element no longer changes, so that its bits do not depend on the others.
  LaneFlags moving = ~hard;
  for (int k = 0; k < kMostIterations && any(moving); ++k) {
    cofactor(R, C);
    const Lanes half = 0.5 / determinant(R, C);
    Lanes change = {};
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        const Lanes next = 0.5 * R[r][c] + half * C[r][c];
        const Lanes d = absolute(next - R[r][c]);
        change = d > change ? d : change;
        R[r][c] = moving ? next : R[r][c];
      }
    moving &= change > kSettled;
  }
  hard |= moving;
  if (!any(hard)) return;
  for (int lane = 0; lane < kLanes; ++lane) {
    if (hard[lane] == 0) continue;
    Mat3 f;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) f(r, c) = F[r][c][lane];
    const Mat3 rotation = polar_rotation(f);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) R[r][c][lane] = rotation(r, c);
  }
}

/// First Piola stress P = ∂Ψ/∂F.
BRIM_INLINE void stress(ElasticLaw law, const Lame& lame, const Mat3L& F, const Mat3L& R, Mat3L& P) {
  if (law == ElasticLaw::CorotationalLinear) {
    Lanes trace = Lanes{} - 3.0;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) trace += R[r][c] * F[r][c];
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) P[r][c] = 2.0 * lame.mu * (F[r][c] - R[r][c]) + lame.lambda * trace * R[r][c];
    return;
  }
  const StableNeoHookean n(lame);
  Mat3L C;
  cofactor(F, C);
  Lanes ic = {};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) ic += F[r][c] * F[r][c];
  const Lanes shear = n.mu * (1.0 - 1.0 / (ic + 1.0)), bulk = n.lambda * (determinant(F, C) - n.alpha);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) P[r][c] = shear * F[r][c] + bulk * C[r][c];
}

/// Rotates coordinates p and q so that S(p, q) vanishes; Q gets the same rotation.
BRIM_INLINE void jacobi(Mat3W& S, Mat3W& Q, int p, int q) {
  const WideFloats off = 2.0f * S[p][q], gap = S[q][q] - S[p][p];
  WideFloats root = gap * gap + off * off, c, s;
  for (int k = 0; k < kCount; ++k) root[k] = std::sqrt(root[k]);
  const WideFloats size = (gap < 0.0f ? -gap : gap) + root;
  const WideFloats t = (gap < 0.0f ? -off : off) / (size > 1e-30f ? size : WideFloats{} + 1e-30f);
  c = t * t + 1.0f;
  for (int k = 0; k < kCount; ++k) c[k] = std::sqrt(c[k]);
  c = 1.0f / c;
  s = t * c;
  const int r = 3 - p - q;
  const WideFloats move = 0.5f * t * off, rp = S[r][p], rq = S[r][q];
  S[p][p] -= move;
  S[q][q] += move;
  S[p][q] = S[q][p] = WideFloats{};
  S[r][p] = S[p][r] = c * rp - s * rq;
  S[r][q] = S[q][r] = s * rp + c * rq;
  for (int i = 0; i < 3; ++i) {
    const WideFloats a = Q[i][p], b = Q[i][q];
    Q[i][p] = c * a - s * b;
    Q[i][q] = s * a + c * b;
  }
}

/// Entries of ∂P/∂F in the principal frame times the volume (PrincipalResponse): plus and minus are half the sum and
/// half the difference of flip and twist.
struct PrincipalLanes {
  Mat3W stretch;
  WideFloats plus[3], minus[3];
};

BRIM_INLINE WideFloats positive(const WideFloats& x) { return x > 0.0f ? x : WideFloats{}; }

/// Clamps the matrices that are not positive definite.
BRIM_INLINE void clamp(Mat3W& A) {
  const WideFloats m2 = A[0][0] * A[1][1] - A[0][1] * A[0][1];
  Mat3W C;
  cofactor(A, C);
  const WideIds bad = ~((A[0][0] > 0.0f) & (m2 > 0.0f) & (determinant(A, C) > 0.0f));
  if (!any(bad)) return;
  for (int lane = 0; lane < kCount; ++lane) {
    if (bad[lane] == 0) continue;
    Mat3 a;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) a(r, c) = static_cast<double>(A[r][c][lane]);
    a = clamp_to_positive(a);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) A[r][c][lane] = static_cast<float>(a(r, c));
  }
}

BRIM_INLINE void principal(ElasticLaw law, const Lame& lame, bool project, const WideFloats (&e)[3],
                           const WideFloats& volume, PrincipalLanes& out) {
  WideFloats twist[3], flip[3];
  if (law == ElasticLaw::CorotationalLinear) {
    const auto mu2 = static_cast<float>(2.0 * lame.mu), lambda = static_cast<float>(lame.lambda);
    const WideFloats trace = e[0] + e[1] + e[2] - 3.0f;
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) out.stretch[k][i] = WideFloats{} + (i == k ? lambda + mu2 : lambda);
      const WideFloats sum = e[(k + 1) % 3] + e[(k + 2) % 3];
      twist[k] = mu2 + 2.0f * (lambda * trace - mu2) / (sum > 1e-6f ? sum : WideFloats{} + 1e-6f);
      flip[k] = WideFloats{} + mu2;
    }
  } else {
    const StableNeoHookean n(lame);
    const auto mu = static_cast<float>(n.mu), lambda = static_cast<float>(n.lambda);
    const WideFloats ic1 = e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + 1.0f;
    const WideFloats shear = mu * (1.0f - 1.0f / ic1);
    const WideFloats bulk = lambda * (e[0] * e[1] * e[2] - static_cast<float>(n.alpha));
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      const WideFloats ci = e[j] * e[k], cj = e[k] * e[i], ck = e[i] * e[j], soft = 2.0f * mu / (ic1 * ic1);
      out.stretch[k][k] = soft * e[k] * e[k] + lambda * ck * ck + shear;
      out.stretch[i][j] = out.stretch[j][i] = soft * e[i] * e[j] + lambda * ci * cj + bulk * e[k];
      twist[k] = shear + bulk * e[k];
      flip[k] = shear - bulk * e[k];
    }
    if (project) clamp(out.stretch);
  }
  for (int k = 0; k < 3; ++k) {
    if (project) twist[k] = positive(twist[k]), flip[k] = positive(flip[k]);
    out.plus[k] = 0.5f * volume * (twist[k] + flip[k]);
    out.minus[k] = 0.5f * volume * (flip[k] - twist[k]);
    for (int i = 0; i < 3; ++i) out.stretch[k][i] *= volume;
  }
}

/// K = Q B Qᵀ with B the block of a and b in the principal frame, stored column by column; B written
/// plainly: tests/support/principal_block.h.
BRIM_INLINE void store_block(const PrincipalLanes& r, const Mat3W& Q, const WideFloats (&a)[3],
                             const WideFloats (&b)[3], float (&out)[9][kCount]) {
  Mat3W B, T;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    B[i][i] = r.stretch[i][i] * (a[i] * b[i]) + r.plus[k] * (a[j] * b[j]) + r.plus[j] * (a[k] * b[k]);
    B[i][j] = r.stretch[i][j] * (a[i] * b[j]) + r.minus[k] * (a[j] * b[i]);
    B[j][i] = r.stretch[i][j] * (a[j] * b[i]) + r.minus[k] * (a[i] * b[j]);
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) T[i][j] = Q[i][0] * B[0][j] + Q[i][1] * B[1][j] + Q[i][2] * B[2][j];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      store_lanes(out[3 * j + i], WideFloats(T[i][0] * Q[j][0] + T[i][1] * Q[j][1] + T[i][2] * Q[j][2]));
}

BRIM_INLINE WideFloats narrow(const double* x) {
  double d[kCount];
  std::memcpy(d, x, sizeof d);
  WideFloats f;
  for (int k = 0; k < kCount; ++k) f[k] = static_cast<float>(d[k]);
  return f;
}

/// Energy density of the corotational law. @param R  rotation of F
BRIM_INLINE Lanes turned_density(const Lame& lame, const Mat3L& F, const Mat3L& R) {
  Lanes trace = Lanes{} - 3.0, gap = {};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      const Lanes d = F[r][c] - R[r][c];
      trace += R[r][c] * F[r][c], gap += d * d;
    }
  return lame.mu * gap + 0.5 * lame.lambda * trace * trace;
}

/// Energy density.
BRIM_INLINE Lanes density(ElasticLaw law, const Lame& lame, const Mat3L& F) {
  Mat3L C;
  if (law == ElasticLaw::CorotationalLinear) {
    nearest_rotation(F, C);
    return turned_density(lame, F, C);
  }
  const StableNeoHookean n(lame);
  cofactor(F, C);
  Lanes ic = {};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) ic += F[r][c] * F[r][c];
  const Lanes volume = determinant(F, C) - n.alpha;
  const double rest = 1.0 - n.alpha;
  Lanes log = 0.25 * (ic + 1.0);
  for (int k = 0; k < kLanes; ++k) log[k] = std::log(log[k]);
  return 0.5 * n.mu * (ic - 3.0 - log) + 0.5 * n.lambda * (volume * volume - rest * rest);
}

/// ∂P/∂F of eight elements in their principal frames, with the transforms of blocks and gradients: K = Q B Qᵀ, a = W g.
struct PrincipalFrame {
  PrincipalLanes response;
  Mat3W Q, W;
};

/// @param rotation, left  R and F Rᵀ, entry by entry
BRIM_INLINE void principal_frame(ElasticLaw law, const Lame& lame, bool project, const double (&rotation)[3][3][kCount],
                                 const double (&left)[3][3][kCount], const double (&volume)[kCount],
                                 PrincipalFrame& out) {
  Mat3W S, &Q = out.Q;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      S[r][c] = narrow(left[r <= c ? r : c][r <= c ? c : r]);
      Q[r][c] = WideFloats{} + (r == c ? 1.0f : 0.0f);
    }
  for (int sweep = 0; sweep < kJacobiSweeps; ++sweep) {
    jacobi(S, Q, 0, 1);
    jacobi(S, Q, 0, 2);
    jacobi(S, Q, 1, 2);
  }
  const WideFloats e[3] = {S[0][0], S[1][1], S[2][2]};
  principal(law, lame, project, e, narrow(volume), out.response);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      out.W[i][j] =
          Q[0][i] * narrow(rotation[0][j]) + Q[1][i] * narrow(rotation[1][j]) + Q[2][i] * narrow(rotation[2][j]);
}

/// R and F Rᵀ of one half of the elements, and the stress P.
BRIM_INLINE void split(ElasticLaw law, const Lame& lame, const Mat3L& F, int at, double (&rotation)[3][3][kCount],
                       double (&left)[3][3][kCount], Mat3L& R, Mat3L& P) {
  nearest_rotation(F, R);
  stress(law, lame, F, R, P);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      store_lanes(rotation[r][c] + at, R[r][c]);
      store_lanes(left[r][c] + at, Lanes(F[r][0] * R[c][0] + F[r][1] * R[c][1] + F[r][2] * R[c][2]));
    }
}

}  // namespace brim::elastic_lanes
