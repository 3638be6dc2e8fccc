#include "brim/contact/contact_set.h"

#include <cmath>

namespace brim {

namespace {

/// Two unit vectors across a direction (Duff and others 2017, "Building an orthonormal basis, revisited").
template <class Number>
struct Tangents {
  using Vec = Eigen::Matrix<Number, 3, 1>;
  Vec u, v;
  explicit Tangents(const Vec& n) {
    const Number sign = std::copysign(Number{1}, n.z()), a = Number{-1} / (sign + n.z()), b = n.x() * n.y() * a;
    u = {1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x()};
    v = {b, sign + n.y() * n.y() * a, -n.y()};
  }
};

}  // namespace

std::array<float, 3> tangent_tensor(const Vec3f& g, const std::array<float, 6>& H, float scale) {
  const float length = g.norm();
  if (!(length > 0.0f)) return {};
  const Tangents<float> t(g / length);
  const auto times = [&](const Vec3f& x) {
    return Vec3f(H[0] * x[0] + H[3] * x[1] + H[4] * x[2], H[3] * x[0] + H[1] * x[1] + H[5] * x[2],
                 H[4] * x[0] + H[5] * x[1] + H[2] * x[2]);
  };
  const Vec3f Hu = times(t.u), Hv = times(t.v);
  return {scale * t.u.dot(Hu), scale * t.u.dot(Hv), scale * t.v.dot(Hv)};
}

Mat3 unpack_tangent_tensor(const Vec3f& g, const std::array<float, 3>& packed) {
  const Vec3 d = g.cast<double>();
  const double length = d.norm();
  if (!(length > 0.0)) return Mat3::Zero();
  const Tangents<double> t(d / length);
  const double uu = packed[0], uv = packed[1], vv = packed[2];
  return (uu * t.u + uv * t.v) * t.u.transpose() + (uv * t.u + vv * t.v) * t.v.transpose();
}

Eigen::Matrix<float, 6, 1> unpack_tensor_entries(const Vec3f& g, const std::array<float, 3>& packed) {
  Eigen::Matrix<float, 6, 1> m = Eigen::Matrix<float, 6, 1>::Zero();
  const float length = g.norm();
  if (!(length > 0.0f)) return m;
  const Tangents<float> t(g / length);
  const Vec3f Mu = packed[0] * t.u + packed[1] * t.v, Mv = packed[1] * t.u + packed[2] * t.v;
  m << Mu[0] * t.u[0] + Mv[0] * t.v[0], Mu[1] * t.u[1] + Mv[1] * t.v[1], Mu[2] * t.u[2] + Mv[2] * t.v[2],
      Mu[0] * t.u[1] + Mv[0] * t.v[1], Mu[0] * t.u[2] + Mv[0] * t.v[2], Mu[1] * t.u[2] + Mv[1] * t.v[2];
  return m;
}

void ContactSet::resize(std::size_t n) {
  node.resize(n), point.resize(n), overlap.resize(n), depth.resize(n);
  gradient_a.resize(n), gradient_b.resize(n), bend_a.resize(n), bend_b.resize(n);
  source_a.resize(n), source_b.resize(n);
}

void ContactSet::set(std::size_t c, const Contact& contact) {
  node[c] = contact.node, point[c] = contact.point, overlap[c] = contact.overlap, depth[c] = contact.depth;
  gradient_a.set(c, contact.gradient_a), gradient_b.set(c, contact.gradient_b);
  bend_a[c] = contact.bend_a, bend_b[c] = contact.bend_b;
  source_a[c] = contact.source_a, source_b[c] = contact.source_b;
}

void ContactSet::append(const ContactSet& from, std::size_t c, const Vec3& x, double d) {
  node.push_back(from.node[c]), point.push_back(x);
  overlap.push_back(from.overlap[c]), depth.push_back(static_cast<float>(d));
  gradient_a.append(from.gradient_a, c), gradient_b.append(from.gradient_b, c);
  bend_a.push_back(from.bend_a[c]), bend_b.push_back(from.bend_b[c]);
  source_a.push_back(from.source_a[c]), source_b.push_back(from.source_b[c]);
}

void ContactSet::erase(std::size_t c) {
  const auto drop = [c](auto& v) { v.erase(v.begin() + static_cast<std::ptrdiff_t>(c)); };
  drop(node), drop(point), drop(overlap), drop(depth), drop(bend_a), drop(bend_b), drop(source_a), drop(source_b);
  gradient_a.erase(c), gradient_b.erase(c);
}

}  // namespace brim
