#include "brim/body/cloth/bending_elements.h"

#include <cmath>
#include <numbers>

#include "brim/mesh/topology.h"

namespace brim {

namespace {

constexpr double kFlatAngle = 1e-6;

/// Cotangent of the angle at p between the directions to a and b.
double cotangent(const Vec3& p, const Vec3& a, const Vec3& b) {
  return (a - p).dot(b - p) / (a - p).cross(b - p).norm();
}

/// Difference of two angles, turned into (−π, π].
double difference(double theta, double rest) {
  const double d = theta - rest;
  return d > std::numbers::pi ? d - 2.0 * std::numbers::pi : d < -std::numbers::pi ? d + 2.0 * std::numbers::pi : d;
}

}  // namespace

BendingElements::BendingElements(const TriMesh& rest, double B) {
  const std::vector<Hinge> hinges = interior_edges(rest.triangles);
  std::vector<std::int32_t> corners;
  for (const Hinge& h : hinges) corners.insert(corners.end(), {h.a, h.b, h.c, h.d});
  schedule_.build(corners, 4, rest.vertices);
  for (const std::int32_t k : schedule_.order()) {
    const std::int32_t* n = corners.data() + 4 * k;
    const Vec3 a = rest.vertices[n[0]], b = rest.vertices[n[1]], c = rest.vertices[n[2]], d = rest.vertices[n[3]];
    const double area = 0.5 * ((b - a).cross(c - a).norm() + (b - a).cross(d - a).norm());
    Element e{};
    e.size2 = area * area;
    const double ac = cotangent(a, b, c), ad = cotangent(a, b, d), bc = cotangent(b, a, c), bd = cotangent(b, a, d);
    e.weight[0] = bc + bd;
    e.weight[1] = ac + ad;
    e.weight[2] = -ac - bc;
    e.weight[3] = -ad - bd;
    Vec3 gradient[4];
    angle(rest.vertices, n, e.size2, e.angle, gradient);
    flat_ = flat_ && std::abs(e.angle) <= kFlatAngle;
    e.stiffness = B / area;
    element_.push_back(e);
    node_.insert(node_.end(), n, n + 4);
  }
  if (flat_) return;
  for (std::size_t k = 0; k < size(); ++k)
    element_[k].stiffness *= (rest.vertices[node_[4 * k]] - rest.vertices[node_[4 * k + 1]]).squaredNorm();
}

void BendingElements::find_pairs(const BlockMatrix& matrix) {
  pair_.resize(size());
  for (std::size_t k = 0; k < size(); ++k)
    for (int i = 0, p = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j, ++p) pair_[k][p] = matrix.pair(node_[4 * k + i], node_[4 * k + j]);
}

bool BendingElements::angle(std::span<const Vec3> x, const std::int32_t* n, double size2, double& theta,
                            Vec3 gradient[4]) {
  const Vec3 &a = x[n[0]], &b = x[n[1]], &c = x[n[2]], &d = x[n[3]];
  const Vec3 e = b - a, n1 = e.cross(c - a), n2 = (d - a).cross(e);
  const double e2 = e.squaredNorm(), length = std::sqrt(e2), s1 = n1.squaredNorm(), s2 = n2.squaredNorm();
  theta = 0.0;
  if (!(s1 > 1e-12 * size2) || !(s2 > 1e-12 * size2)) return false;
  theta = std::atan2(e.dot(n1.cross(n2)) / length, n1.dot(n2));
  // Each outer corner turns its own triangle; the edge takes what keeps translations and rotations free.
  gradient[2] = -length / s1 * n1;
  gradient[3] = -length / s2 * n2;
  const double tc = (c - a).dot(e) / e2, td = (d - a).dot(e) / e2;
  gradient[0] = -(1.0 - tc) * gradient[2] - (1.0 - td) * gradient[3];
  gradient[1] = -tc * gradient[2] - td * gradient[3];
  return true;
}

void BendingElements::add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness) const {
  schedule_.for_each([&](std::size_t k) {
    const std::int32_t* n = node_.data() + 4 * k;
    const Element& e = element_[k];
    if (flat_) {
      Vec3 sum = Vec3::Zero();
      for (int i = 0; i < 4; ++i) sum += e.weight[i] * x[n[i]];
      for (int i = 0, p = 0; i < 4; ++i) {
        force[n[i]] -= e.stiffness * e.weight[i] * sum;
        for (int j = i + 1; j < 4; ++j, ++p)
          stiffness.add(pair_[k][p], e.stiffness * e.weight[i] * e.weight[j] * Mat3::Identity());
      }
      return;
    }
    double theta;
    Vec3 g[4];
    if (!angle(x, n, e.size2, theta, g)) return;
    const double moment = e.stiffness * difference(theta, e.angle);
    for (int i = 0, p = 0; i < 4; ++i) {
      force[n[i]] -= moment * g[i];
      for (int j = i + 1; j < 4; ++j, ++p) stiffness.add(pair_[k][p], e.stiffness * g[i] * g[j].transpose());
    }
  });
}

double BendingElements::energy(std::span<const Vec3> x) const {
  return ordered_sum(size(), [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      const std::int32_t* n = node_.data() + 4 * k;
      const Element& e = element_[k];
      if (flat_) {
        Vec3 s = Vec3::Zero();
        for (int i = 0; i < 4; ++i) s += e.weight[i] * x[n[i]];
        sum += 0.5 * e.stiffness * s.squaredNorm();
        continue;
      }
      double theta;
      Vec3 g[4];
      if (angle(x, n, e.size2, theta, g)) sum += 0.5 * e.stiffness * std::pow(difference(theta, e.angle), 2);
    }
    return sum;
  });
}

}  // namespace brim
