#include "brim/body/cloth/membrane_elements.h"

#include <Eigen/LU>

#include "brim/core/error.h"

namespace brim {

namespace {

/// The part of a symmetric 2x2 matrix with positive eigenvalues.
Eigen::Matrix2d tension(const Eigen::Matrix2d& s) {
  const double mean = 0.5 * (s(0, 0) + s(1, 1)), half = 0.5 * (s(0, 0) - s(1, 1));
  const double radius = std::sqrt(half * half + s(0, 1) * s(0, 1));
  const double high = mean + radius, low = mean - radius;
  if (low >= 0.0) return s;
  if (high <= 0.0) return Eigen::Matrix2d::Zero();
  // high times the projector onto its eigenvector, (S − low) / (high − low).
  return high / (high - low) * (s - low * Eigen::Matrix2d::Identity());
}

}  // namespace

MembraneMaterial::Moduli MembraneMaterial::moduli() const {
  const double e1 = young, e2 = young_weft > 0.0 ? young_weft : young;
  if (!(e1 > 0.0) || !std::isfinite(e1) || !std::isfinite(e2) || young_weft < 0.0 || !(shear >= 0.0))
    throw InputError(
        fmt::format("cloth: moduli are {} (warp), {} (weft), {} (shear) N/m; the first must be positive, the "
                    "others zero or positive",
                    young, young_weft, shear));
  const double rest = 1.0 - poisson * poisson * e2 / e1;
  if (!(rest > 0.0) || !(poisson > -1.0))
    throw InputError(
        fmt::format("cloth: Poisson's ratio is {}; it must be above -1 and its square times weft over warp "
                    "modulus below 1",
                    poisson));
  return {e1 / rest, e2 / rest, poisson * e2 / rest,
          shear > 0.0 ? shear : std::sqrt(e1 * e2) / (2.0 * (1.0 + poisson))};
}

MembraneElements::MembraneElements(const TriMesh& rest, const MembraneMaterial& material) : c_(material.moduli()) {
  const auto vertices = static_cast<std::int32_t>(rest.vertices.size());
  std::vector<std::int32_t> corners;
  for (std::size_t t = 0; t < rest.triangles.size(); ++t)
    for (const std::int32_t n : rest.triangles[t]) {
      if (n < 0 || n >= vertices)
        throw InputError(fmt::format("cloth: triangle {} names vertex {}; there are {}", t, n, vertices));
      corners.push_back(n);
    }
  schedule_.build(corners, 3, rest.vertices);
  for (const std::int32_t t : schedule_.order()) {
    const Triangle& c = rest.triangles[t];
    const Vec3 u = rest.vertices[c[1]] - rest.vertices[c[0]], v = rest.vertices[c[2]] - rest.vertices[c[0]];
    const Vec3 m = u.cross(v);
    const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (u - v).squaredNorm()});
    if (!(m.norm() > 1e-10 * longest)) throw InputError(fmt::format("cloth: triangle {} has no area", t));
    const Vec3 n = m.normalized();
    // A warp that stands across the triangle has no direction in it; its first edge serves.
    Vec3 e1 = material.warp - n * n.dot(material.warp);
    if (!(e1.norm() > 1e-6 * material.warp.norm())) e1 = u;
    e1.normalize();
    const Vec3 e2 = n.cross(e1);
    Mat2 edges;
    edges << u.dot(e1), v.dot(e1), u.dot(e2), v.dot(e2);
    const Mat2 g = edges.inverse();
    Element e;
    e.gradient[1] = g.row(0);
    e.gradient[2] = g.row(1);
    e.gradient[0] = -e.gradient[1] - e.gradient[2];
    e.area = 0.5 * m.norm();
    element_.push_back(e);
    node_.insert(node_.end(), c.begin(), c.end());
  }
}

void MembraneElements::find_pairs(const BlockMatrix& matrix) {
  pair_.clear();
  for (std::size_t k = 0; k < size(); ++k) {
    const std::int32_t* n = node_.data() + 3 * k;
    pair_.push_back({matrix.pair(n[0], n[1]), matrix.pair(n[0], n[2]), matrix.pair(n[1], n[2])});
  }
}

MembraneElements::Mat32 MembraneElements::deformation(std::span<const Vec3> x, std::size_t k) const {
  const std::int32_t* n = node_.data() + 3 * k;
  const Element& e = element_[k];
  return (x[n[1]] - x[n[0]]) * e.gradient[1].transpose() + (x[n[2]] - x[n[0]]) * e.gradient[2].transpose();
}

MembraneElements::Mat2 MembraneElements::stress(const Mat32& F, Mat2& strain) const {
  strain = 0.5 * (F.transpose() * F - Mat2::Identity());
  Mat2 s;
  s(0, 0) = c_.c11 * strain(0, 0) + c_.c12 * strain(1, 1);
  s(1, 1) = c_.c12 * strain(0, 0) + c_.c22 * strain(1, 1);
  s(0, 1) = s(1, 0) = 2.0 * c_.g * strain(0, 1);
  return s;
}

void MembraneElements::add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness) const {
  schedule_.for_each([&](std::size_t k) {
    const std::int32_t* n = node_.data() + 3 * k;
    const Element& e = element_[k];
    const Mat32 F = deformation(x, k);
    Mat2 strain;
    const Mat2 S = stress(F, strain);
    const Mat32 P = -e.area * (F * S);
    for (int i = 0; i < 3; ++i) force[n[i]] += P * e.gradient[i];
    const Mat2 T = tension(S);
    for (int i = 0, p = 0; i < 3; ++i)
      for (int j = i + 1; j < 3; ++j, ++p) {
        const Vec2 &a = e.gradient[i], &b = e.gradient[j];
        Mat2 D;
        D(0, 0) = c_.c11 * a[0] * b[0] + c_.g * a[1] * b[1];
        D(0, 1) = c_.c12 * a[0] * b[1] + c_.g * a[1] * b[0];
        D(1, 0) = c_.c12 * a[1] * b[0] + c_.g * a[0] * b[1];
        D(1, 1) = c_.c22 * a[1] * b[1] + c_.g * a[0] * b[0];
        Mat3 K = e.area * (F * D * F.transpose());
        K.diagonal().array() += e.area * a.dot(T * b);
        stiffness.add(pair_[k][p], K);
      }
  });
}

void MembraneElements::add_turning(std::span<const Vec3> x, std::span<const double> v,
                                   std::span<const std::uint8_t> chosen, std::span<double> y) const {
  schedule_.for_each([&](std::size_t k) {
    const std::int32_t* n = node_.data() + 3 * k;
    if (!chosen[n[0]] || !chosen[n[1]] || !chosen[n[2]]) return;
    Mat2 strain;
    const Mat2 T = tension(stress(deformation(x, k), strain));
    if (T == Mat2::Zero()) return;
    const Element& e = element_[k];
    const auto at = [&](int i) { return Eigen::Map<const Vec3>(v.data() + 3 * n[i]); };
    const Mat32 L = (at(1) - at(0)) * e.gradient[1].transpose() + (at(2) - at(0)) * e.gradient[2].transpose();
    const Mat32 P = e.area * (L * T);
    for (int i = 0; i < 3; ++i) Eigen::Map<Vec3>(y.data() + 3 * n[i]) += P * e.gradient[i];
  });
}

double MembraneElements::energy(std::span<const Vec3> x) const {
  return ordered_sum(size(), [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      Mat2 strain;
      const Mat2 S = stress(deformation(x, k), strain);
      sum += 0.5 * element_[k].area * S.cwiseProduct(strain).sum();
    }
    return sum;
  });
}

double MembraneElements::area() const {
  double sum = 0.0;
  for (const Element& e : element_) sum += e.area;
  return sum;
}

std::vector<double> MembraneElements::lumped_mass(std::size_t vertices, double areal_density) const {
  std::vector<double> mass(vertices, 0.0);
  for (std::size_t k = 0; k < size(); ++k)
    for (int i = 0; i < 3; ++i) mass[node_[3 * k + i]] += areal_density * element_[k].area / 3.0;
  return mass;
}

}  // namespace brim
