#include "brim/mesh/distance.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "brim/core/error.h"
#include "brim/mesh/topology.h"

namespace brim {

namespace {

constexpr double kInverseFourPi = 0.25 / std::numbers::pi;

// Closest point of the segment a-b as the weight of b.
double segment_parameter(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double l2 = d.squaredNorm();
  return l2 > 0.0 ? std::clamp((p - a).dot(d) / l2, 0.0, 1.0) : 0.0;
}

TrianglePoint closest_on_edges(const Vec3& p, const std::array<Vec3, 3>& x) {
  static constexpr Feature kEdges[3] = {Feature::EdgeAB, Feature::EdgeBC, Feature::EdgeCA};
  static constexpr Feature kVertices[3] = {Feature::VertexA, Feature::VertexB, Feature::VertexC};
  TrianglePoint best{};
  double best2 = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    const double t = segment_parameter(p, x[k], x[l]);
    const Vec3 q = x[k] + t * (x[l] - x[k]);
    const double d2 = (p - q).squaredNorm();
    if (d2 >= best2) continue;
    best2 = d2;
    best.point = q;
    best.barycentric = Vec3::Zero();
    best.barycentric[k] = 1.0 - t;
    best.barycentric[l] = t;
    best.feature = t == 0.0 ? kVertices[k] : t == 1.0 ? kVertices[l] : kEdges[k];
  }
  return best;
}

}  // namespace

TrianglePoint closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double longest2 = std::max({ab.squaredNorm(), ac.squaredNorm(), (c - b).squaredNorm()});
  if (!(ab.cross(ac).squaredNorm() > 1e-28 * longest2 * longest2)) return closest_on_edges(p, {a, b, c});

  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {a, {1, 0, 0}, Feature::VertexA};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return {b, {0, 1, 0}, Feature::VertexB};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    const double t = d1 / (d1 - d3);
    return {a + t * ab, {1.0 - t, t, 0}, Feature::EdgeAB};
  }
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return {c, {0, 0, 1}, Feature::VertexC};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    const double t = d2 / (d2 - d6);
    return {a + t * ac, {1.0 - t, 0, t}, Feature::EdgeCA};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {b + t * (c - b), {0, 1.0 - t, t}, Feature::EdgeBC};
  }
  const double scale = 1.0 / (va + vb + vc);
  const double v = vb * scale, w = vc * scale;
  return {a + v * ab + w * ac, {1.0 - v - w, v, w}, Feature::Face};
}

double triangle_winding(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 x = a - p, y = b - p, z = c - p;
  const double lx = x.norm(), ly = y.norm(), lz = z.norm();
  const double numerator = x.dot(y.cross(z));
  const double denominator = lx * ly * lz + x.dot(y) * lz + y.dot(z) * lx + z.dot(x) * ly;
  // On the triangle's own plane the angle is taken as zero instead of ±π.
  if (numerator == 0.0) return 0.0;
  return 2.0 * kInverseFourPi * std::atan2(numerator, denominator);
}

SurfaceTree::SurfaceTree(TriMesh mesh) : mesh_(std::move(mesh)) {
  if (mesh_.triangles.empty()) throw InputError("the surface has no triangles");
  for (std::size_t v = 0; v < mesh_.vertices.size(); ++v)
    if (!mesh_.vertices[v].allFinite())
      throw InputError(fmt::format("vertex {} of the surface is not finite: ({}, {}, {})", v, mesh_.vertices[v].x(),
                                   mesh_.vertices[v].y(), mesh_.vertices[v].z()));
  std::vector<Aabb> boxes(mesh_.triangles.size());
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
    for (const std::int32_t v : mesh_.triangles[t]) {
      if (v < 0 || static_cast<std::size_t>(v) >= mesh_.vertices.size())
        throw InputError(
            fmt::format("triangle {} names vertex {}, but the mesh has {} vertices", t, v, mesh_.vertices.size()));
      boxes[t].extend(mesh_.vertices[v]);
    }
  tree_ = Bvh(boxes);
  box_ = tree_.nodes()[0].box;
  build_pseudonormals();
  build_dipoles();
}

void SurfaceTree::build_pseudonormals() {
  const std::size_t n = mesh_.triangles.size();
  face_normal_.resize(n);
  edge_normal_.resize(n);
  for (std::size_t t = 0; t < n; ++t) {
    const Triangle& c = mesh_.triangles[t];
    const Vec3 m = (mesh_.vertices[c[1]] - mesh_.vertices[c[0]]).cross(mesh_.vertices[c[2]] - mesh_.vertices[c[0]]);
    const double length = m.norm();
    face_normal_[t] = length > 0.0 ? Vec3(m / length) : Vec3::Zero();
  }
  vertex_normal_ = vertex_normals(mesh_.vertices, mesh_.triangles);

  // An edge's normal is the sum over its triangles: sort the sides by edge, then sum each group.
  std::vector<std::array<std::int32_t, 4>> sides;  // lower vertex, higher vertex, triangle, side
  sides.reserve(3 * n);
  for (std::size_t t = 0; t < n; ++t)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = mesh_.triangles[t][k], b = mesh_.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), k});
    }
  std::sort(sides.begin(), sides.end());
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t j = i;
    Vec3 sum = Vec3::Zero();
    for (; j < sides.size() && sides[j][0] == sides[i][0] && sides[j][1] == sides[i][1]; ++j)
      sum += face_normal_[sides[j][2]];
    for (; i < j; ++i) edge_normal_[sides[i][2]][sides[i][3]] = sum;
  }
}

void SurfaceTree::build_dipoles() {
  const std::vector<Bvh::Node>& nodes = tree_.nodes();
  dipoles_.resize(nodes.size());
  // First area, centre and normal from the leaves up (children come after their parent) ...
  std::vector<double> area(nodes.size(), 0.0);
  const auto triangle = [&](std::int32_t item, Vec3& normal, Vec3& center) {
    const Triangle& c = mesh_.triangles[item];
    const Vec3 &x = mesh_.vertices[c[0]], &y = mesh_.vertices[c[1]], &z = mesh_.vertices[c[2]];
    normal = 0.5 * (y - x).cross(z - x);
    center = (x + y + z) / 3.0;
  };

  for (std::size_t i = nodes.size(); i-- > 0;) {
    const Bvh::Node& n = nodes[i];
    Dipole& d = dipoles_[i];
    Vec3 weighted = Vec3::Zero(), normal, center;
    if (n.count > 0) {
      for (std::int32_t k = n.first; k < n.first + n.count; ++k) {
        triangle(tree_.items()[k], normal, center);
        area[i] += normal.norm();
        weighted += normal.norm() * center;
        d.normal += normal;
      }
    } else {
      const auto l = static_cast<std::size_t>(n.first), r = l + 1;
      area[i] = area[l] + area[r];
      weighted = area[l] * dipoles_[l].center + area[r] * dipoles_[r].center;
      d.normal = dipoles_[l].normal + dipoles_[r].normal;
    }
    d.center = area[i] > 0.0 ? Vec3(weighted / area[i]) : n.box.center();
    d.radius = (d.center - n.box.lo).cwiseMax(n.box.hi - d.center).norm();
  }
  // ... then the first moment about that centre, moved up by the parallel rule.
  for (std::size_t i = nodes.size(); i-- > 0;) {
    const Bvh::Node& n = nodes[i];
    Dipole& d = dipoles_[i];
    if (n.count > 0) {
      Vec3 normal, center;
      for (std::int32_t k = n.first; k < n.first + n.count; ++k) {
        triangle(tree_.items()[k], normal, center);
        d.moment += (center - d.center) * normal.transpose();
      }
    } else {
      for (std::int32_t c = n.first; c < n.first + 2; ++c)
        d.moment += dipoles_[c].moment + (dipoles_[c].center - d.center) * dipoles_[c].normal.transpose();
    }
  }
}

void SurfaceTree::try_triangle(const Vec3& p, std::int32_t t, ClosestPoint& best, double& best2) const {
  const Triangle& c = mesh_.triangles[t];
  const TrianglePoint q = closest_on_triangle(p, mesh_.vertices[c[0]], mesh_.vertices[c[1]], mesh_.vertices[c[2]]);
  const double d2 = (p - q.point).squaredNorm();
  // Of two triangles at the same distance the lower index wins, whatever the order of the visit.
  if (d2 > best2 || (d2 == best2 && best.triangle >= 0 && t > best.triangle)) return;
  best2 = d2;
  best.point = q.point;
  best.barycentric = q.barycentric;
  best.triangle = t;
  best.feature = q.feature;
}

ClosestPoint SurfaceTree::closest(const Vec3& p, double max_distance) const {
  ClosestPoint best;
  double best2 = max_distance * max_distance;
  tree_.nearest(p, best2, [&](std::int32_t t, double& bound2) { try_triangle(p, t, best, bound2); });
  if (best.triangle >= 0) best.distance = std::sqrt(best2);
  return best;
}

ClosestPoint SurfaceTree::closest_from(const Vec3& p, std::int32_t near) const {
  ClosestPoint best;
  double best2 = std::numeric_limits<double>::infinity();
  try_triangle(p, near, best, best2);
  tree_.nearest(p, best2, [&](std::int32_t t, double& bound2) {
    if (t != near) try_triangle(p, t, best, bound2);
  });
  best.distance = std::sqrt(best2);
  return best;
}

double SurfaceTree::winding_number(const Vec3& p, double beta) const {
  const std::vector<Bvh::Node>& nodes = tree_.nodes();
  double sum = 0.0;
  std::int32_t stack[96];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const auto i = static_cast<std::size_t>(stack[--top]);
    const Dipole& d = dipoles_[i];
    const Vec3 r = d.center - p;
    const double l2 = r.squaredNorm();
    if (l2 > beta * beta * d.radius * d.radius) {
      // w = r·N/(4π|r|³) + tr(∇(r/|r|³) M)/(4π), the first two terms of the expansion about the centre.
      const double l = std::sqrt(l2), l3 = l2 * l;
      sum += kInverseFourPi * (r.dot(d.normal) / l3 + d.moment.trace() / l3 - 3.0 * r.dot(d.moment * r) / (l3 * l2));
      continue;
    }
    const Bvh::Node& n = nodes[i];
    if (n.count > 0) {
      for (std::int32_t k = n.first; k < n.first + n.count; ++k) {
        const Triangle& c = mesh_.triangles[tree_.items()[k]];
        sum += triangle_winding(p, mesh_.vertices[c[0]], mesh_.vertices[c[1]], mesh_.vertices[c[2]]);
      }
    } else {
      stack[top++] = n.first;
      stack[top++] = n.first + 1;
    }
  }
  return sum;
}

double SurfaceTree::winding_number_exact(const Vec3& p) const {
  double sum = 0.0;
  for (const Triangle& c : mesh_.triangles)
    sum += triangle_winding(p, mesh_.vertices[c[0]], mesh_.vertices[c[1]], mesh_.vertices[c[2]]);
  return sum;
}

bool SurfaceTree::inside(const Vec3& p, const ClosestPoint& c) const {
  const auto t = static_cast<std::size_t>(c.triangle);
  const Triangle& corners = mesh_.triangles[t];
  Vec3 normal;
  switch (c.feature) {
    case Feature::VertexA:
      normal = vertex_normal_[corners[0]];
      break;
    case Feature::VertexB:
      normal = vertex_normal_[corners[1]];
      break;
    case Feature::VertexC:
      normal = vertex_normal_[corners[2]];
      break;
    case Feature::EdgeAB:
      normal = edge_normal_[t][0];
      break;
    case Feature::EdgeBC:
      normal = edge_normal_[t][1];
      break;
    case Feature::EdgeCA:
      normal = edge_normal_[t][2];
      break;
    default:
      normal = face_normal_[t];
      break;
  }
  return (p - c.point).dot(normal) < 0.0;
}

double SurfaceTree::signed_distance(const Vec3& p) const {
  const ClosestPoint c = closest(p);
  return inside(p, c) ? -c.distance : c.distance;
}

ClosestPoint closest_brute_force(const TriMesh& mesh, const Vec3& p) {
  ClosestPoint best;
  double best2 = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& c = mesh.triangles[t];
    const TrianglePoint q = closest_on_triangle(p, mesh.vertices[c[0]], mesh.vertices[c[1]], mesh.vertices[c[2]]);
    const double d2 = (p - q.point).squaredNorm();
    if (d2 >= best2) continue;
    best2 = d2;
    best = {std::sqrt(d2), q.point, q.barycentric, static_cast<std::int32_t>(t), q.feature};
  }
  return best;
}

}  // namespace brim
