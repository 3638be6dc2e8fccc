#include "brim/contact/contact_set.h"

#include "brim/contact/tangent_frame.h"

namespace brim {

Mat3 unpack_tangent_tensor(const Vec3f& g, const std::array<float, 3>& packed) {
  const Vec3 d = g.cast<double>();
  const double length = d.norm();
  if (!(length > 0.0)) return Mat3::Zero();
  const Vec3 n = d / length;
  const TangentFrame<double> t(n[0], n[1], n[2]);
  const Vec3 u(t.u), v(t.v);
  const double uu = packed[0], uv = packed[1], vv = packed[2];
  return (uu * u + uv * v) * u.transpose() + (uv * u + vv * v) * v.transpose();
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
