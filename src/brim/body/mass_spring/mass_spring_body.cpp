#include "brim/body/mass_spring/mass_spring_body.h"

#include <algorithm>

#include "brim/body/particles/line_contact.h"
#include "brim/body/particles/sheet_contact.h"
#include "brim/body/particles/tet_contact.h"
#include "brim/core/error.h"

namespace brim {

namespace {

template <class Mesh>
SpringMesh springs_of(const Mesh& mesh, const MassSpringOptions& o) {
  require_positive("mass-spring body", "density", o.density);
  require_positive("mass-spring body", "stiffness", o.stiffness);
  require_positive("mass-spring body", "thickness", o.thickness);
  return make_springs(mesh, o.stiffness, o.density);
}

}  // namespace

MassSpringBody::MassSpringBody(std::vector<Vec3> rest, SpringMesh mesh, const MassSpringOptions& options)
    : StrainDampedBody(std::move(rest), std::move(mesh.mass), options),
      springs_(mesh.springs, rest_, options.slack),
      measure_(mesh.measure) {
  BlockMatrix pattern;
  pattern.begin(particle_count());
  pattern.add_elements(springs_.nodes(), 2);
  pattern.finish();
  share_pattern(std::move(pattern));
  springs_.find_pairs(stiffness_);
  force_.assign(particle_count(), Vec3::Zero());
}

MassSpringBody::MassSpringBody(const TetMesh& mesh, MassSpringOptions options)
    : MassSpringBody(mesh.vertices, springs_of(mesh, options), options) {
  auto contact = std::make_unique<TetContact>(mesh);
  solid_.emplace(mesh, contact->surface(), options.display);
  PartInfo part = contact->part_info(rest_, measure_, options.density);
  part.modulus = options.stiffness;
  set_contact(std::move(contact), part);
}

MassSpringBody::MassSpringBody(const TriMesh& mesh, MassSpringOptions options)
    : MassSpringBody(mesh.vertices, springs_of(mesh, options), options) {
  PartInfo part;
  part.voxel_size = 0.5 * options.thickness;
  part.areal_mass = options.density;
  part.thickness = options.thickness;
  set_contact(std::make_unique<SheetContact>(mesh.triangles, options.thickness), part);
  display_.triangles = mesh.triangles;
  display_.two_sided = true;
}

MassSpringBody::MassSpringBody(const LineMesh& mesh, MassSpringOptions options)
    : MassSpringBody(mesh.vertices, springs_of(mesh, options), options) {
  PartInfo part;
  part.voxel_size = 0.5 * options.thickness;
  part.areal_mass = options.density / options.thickness;
  part.thickness = options.thickness, part.lines = true;
  set_contact(std::make_unique<LineContact>(mesh.lines, 0.5 * options.thickness), part);
  display_.kind = Display::Kind::Lines;
  display_.lines = mesh.lines;
  display_.radius = 0.5 * options.thickness;
}

void MassSpringBody::display_positions(std::span<Vec3f> x) const {
  if (solid_)
    solid_->positions(x_, x);
  else
    ParticleBody::display_positions(x);
}

void MassSpringBody::display_velocities(std::span<const double> v, std::span<const Vec3f>, std::span<Vec3f> u) const {
  const std::span<const Vec3> nodes = node_vectors(v);
  if (solid_)
    solid_->positions(nodes, u);
  else
    std::ranges::transform(nodes, u.begin(), [](const Vec3& w) { return Vec3f(w.cast<float>()); });
}

}  // namespace brim
