#include "brim/body/fem/fem_body.h"

#include "brim/body/particles/tet_contact.h"
#include "brim/core/error.h"
#include "brim/mesh/mass_properties.h"

namespace brim {

namespace {

AveragedElements make_elements(const TetMesh& mesh, const FemOptions& o) {
  if (mesh.tets.empty()) throw InputError("finite elements: the mesh has no tetrahedra");
  require_positive("finite elements", "density", o.density);
  require_positive("finite elements", "Young's modulus", o.young);
  if (!(o.poisson > -1.0 && o.poisson < 0.5))
    throw InputError(fmt::format("finite elements: Poisson's ratio is {}; it must be between -1 and 0.5", o.poisson));
  return AveragedElements(mesh, o.law, Lame::from(o.young, o.poisson), o.averaging);
}

std::vector<double> masses_of(const TetMesh& mesh, const TetElements& elements, double density) {
  std::vector<double> mass = elements.lumped_mass(mesh.vertices.size(), density);
  for (std::size_t i = 0; i < mass.size(); ++i)
    if (!(mass[i] > 0.0)) throw InputError(fmt::format("finite elements: vertex {} is in no tetrahedron", i));
  return mass;
}

}  // namespace

FemBody::FemBody(const TetMesh& mesh, const FemOptions& options)
    : FemBody(mesh, options, make_elements(mesh, options)) {}

FemBody::FemBody(const TetMesh& mesh, const FemOptions& options, AveragedElements elements)
    : ParticleBody(mesh.vertices, masses_of(mesh, elements.tets(), options.density), options),
      mesh_(mesh),
      elements_(std::move(elements)) {
  elements_.make_pattern(stiffness_);
  force_.assign(particle_count(), Vec3::Zero());

  auto contact = std::make_unique<TetContact>(mesh_);
  surface_ = contact->surface();
  shown_.emplace(mesh_, surface_, options.display);
  PartInfo part = contact->part_info(rest_, elements_.tets().volume(), options.density);
  part.modulus = options.young;
  set_contact(std::move(contact), part);
}

void FemBody::display_positions(std::span<Vec3f> x) const { shown_->positions(x_, x); }

void FemBody::display_velocities(std::span<const double> v, std::span<const Vec3f>, std::span<Vec3f> u) const {
  shown_->positions(node_vectors(v), u);
}

void FemBody::show(std::span<const double> value, std::span<float> out) const {
  shown_->values(node_means(particle_count(), mesh_.tets, tet_volumes(mesh_), {}, value), out);
}

}  // namespace brim
