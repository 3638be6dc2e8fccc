#include "brim/mesh/mass_properties.h"

#include "brim/core/error.h"
#include "brim/mesh/tet_moments.h"

namespace brim {

namespace {

MassProperties finish(const TetMoments& m, const Vec3& reference, double density) {
  if (!(density > 0.0) || !std::isfinite(density))
    throw InputError(fmt::format("density is {} kg/m³; it must be positive and finite", density));
  if (!(m.volume > 0.0) || !std::isfinite(m.volume))
    throw InputError(fmt::format(
        "the enclosed volume is {} m³; mass needs a closed mesh with its triangles facing outwards", m.volume));
  MassProperties r;
  r.volume = m.volume;
  r.mass = density * m.volume;
  const Vec3 c = m.first / m.volume;
  const Mat3 covariance = m.second - m.volume * c * c.transpose();
  r.center = reference + c;
  r.inertia = density * (covariance.trace() * Mat3::Identity() - covariance);
  r.inertia = 0.5 * (r.inertia + r.inertia.transpose()).eval();
  return r;
}

Vec3 middle(const std::vector<Vec3>& points) {
  Aabb box;
  for (const Vec3& p : points) box.extend(p);
  return box.empty() ? Vec3::Zero() : box.center();
}

}  // namespace

MassProperties mass_properties(const TriMesh& mesh, double density) {
  const Vec3 o = middle(mesh.vertices);
  TetMoments m;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - o, b = mesh.vertices[t[1]] - o, c = mesh.vertices[t[2]] - o;
    m.add(a.cross(b).dot(c), a, b, c, Vec3::Zero());
  }
  return finish(m, o, density);
}

MassProperties mass_properties(const TetMesh& mesh, double density) {
  const Vec3 o = middle(mesh.vertices);
  TetMoments m;
  for (const Tetrahedron& t : mesh.tets) {
    const Vec3 a = mesh.vertices[t[0]] - o, b = mesh.vertices[t[1]] - o, c = mesh.vertices[t[2]] - o,
               d = mesh.vertices[t[3]] - o;
    m.add(6.0 * tet_volume(a, b, c, d), a, b, c, d);
  }
  return finish(m, o, density);
}

double enclosed_volume(const TriMesh& mesh) {
  const Vec3 o = middle(mesh.vertices);
  double v = 0.0;
  for (const Triangle& t : mesh.triangles)
    v += (mesh.vertices[t[0]] - o).cross(mesh.vertices[t[1]] - o).dot(mesh.vertices[t[2]] - o);
  return v / 6.0;
}

double surface_area(const TriMesh& mesh) {
  double a = 0.0;
  for (const Triangle& t : mesh.triangles)
    a += (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).norm();
  return 0.5 * a;
}

std::vector<double> tet_volumes(const TetMesh& mesh) {
  const auto& x = mesh.vertices;
  std::vector<double> out;
  out.reserve(mesh.tets.size());
  for (const auto& [a, b, c, d] : mesh.tets) out.push_back(tet_volume(x[a], x[b], x[c], x[d]));
  return out;
}

}  // namespace brim
