#include "brim/body/fem/elastic_law.h"

#include "brim/math/small_symmetric.h"
#include "brim/math/svd3.h"

namespace brim {

namespace {

Vec3 cofactors(const Vec3& s) { return {s[1] * s[2], s[2] * s[0], s[0] * s[1]}; }

void corotational(const Lame& l, const Vec3& s, PrincipalResponse& r) {
  const double trace = s.sum() - 3.0;
  r.energy = l.mu * (s - Vec3::Ones()).squaredNorm() + 0.5 * l.lambda * trace * trace;
  r.first = 2.0 * l.mu * (s - Vec3::Ones()) + Vec3::Constant(l.lambda * trace);
  r.stretch = Mat3::Constant(l.lambda) + 2.0 * l.mu * Mat3::Identity();
  for (int k = 0; k < 3; ++k) {
    // Two vanishing stretches leave the rotation undefined; the floor keeps the stiffness finite there.
    const double sum = std::max(s[(k + 1) % 3] + s[(k + 2) % 3], 1e-6);
    r.twist[k] = 2.0 * l.mu + 2.0 * (l.lambda * trace - 2.0 * l.mu) / sum;
    r.flip[k] = 2.0 * l.mu;
  }
}

void neo_hookean(const StableNeoHookean& n, const Vec3& s, PrincipalResponse& r) {
  const double ic = s.squaredNorm(), volume = s.prod() - n.alpha;
  const double shear = n.mu * (1.0 - 1.0 / (ic + 1.0)), bulk = n.lambda * volume;
  const Vec3 c = cofactors(s);
  r.first = shear * s + bulk * c;
  r.stretch = 2.0 * n.mu / ((ic + 1.0) * (ic + 1.0)) * s * s.transpose() + n.lambda * c * c.transpose();
  r.stretch.diagonal().array() += shear;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    r.stretch(i, j) += bulk * s[k];
    r.stretch(j, i) += bulk * s[k];
    r.twist[k] = shear + bulk * s[k];
    r.flip[k] = shear - bulk * s[k];
  }
}

}  // namespace

double elastic_energy_density(ElasticLaw law, const Lame& lame, const Vec3& s) {
  if (law == ElasticLaw::CorotationalLinear) {
    const double trace = s.sum() - 3.0;
    return lame.mu * (s - Vec3::Ones()).squaredNorm() + 0.5 * lame.lambda * trace * trace;
  }
  const StableNeoHookean n(lame);
  const double ic = s.squaredNorm(), volume = s.prod() - n.alpha, rest = 1.0 - n.alpha;
  return 0.5 * n.mu * (ic - 3.0) + 0.5 * n.lambda * (volume * volume - rest * rest) -
         0.5 * n.mu * std::log((ic + 1.0) / 4.0);
}

Mat3 first_piola_stress(ElasticLaw law, const Lame& lame, const Mat3& F) {
  if (law == ElasticLaw::CorotationalLinear) {
    const Mat3 R = polar_rotation(F);
    return 2.0 * lame.mu * (F - R) + lame.lambda * ((R.transpose() * F).trace() - 3.0) * R;
  }
  const StableNeoHookean n(lame);
  Mat3 cofactor;
  for (int c = 0; c < 3; ++c) cofactor.col(c) = F.col((c + 1) % 3).cross(F.col((c + 2) % 3));
  const double volume = F.col(0).dot(cofactor.col(0));
  return n.mu * (1.0 - 1.0 / (F.squaredNorm() + 1.0)) * F + n.lambda * (volume - n.alpha) * cofactor;
}

PrincipalResponse principal_response(ElasticLaw law, const Lame& lame, const Vec3& s, bool project) {
  PrincipalResponse r;
  if (law == ElasticLaw::CorotationalLinear) {
    corotational(lame, s, r);
  } else {
    neo_hookean(StableNeoHookean(lame), s, r);
    r.energy = elastic_energy_density(law, lame, s);
    if (project) r.stretch = clamp_to_positive(r.stretch);
  }
  if (project) {
    r.twist = r.twist.cwiseMax(0.0);
    r.flip = r.flip.cwiseMax(0.0);
  }
  return r;
}

Mat3 clamp_to_positive(const Mat3& a) {
  // Leading minors all positive: nothing to do, the common case.
  const double m2 = a(0, 0) * a(1, 1) - a(0, 1) * a(0, 1);
  if (a(0, 0) > 0.0 && m2 > 0.0 && a.determinant() > 0.0) return a;
  const SymmetricAxes e = symmetric_axes(a);
  return e.vectors * e.values.cwiseMax(0.0).asDiagonal() * e.vectors.transpose();
}

}  // namespace brim
