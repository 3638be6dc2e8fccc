#include "brim/body/cloth/cloth_body.h"

#include "brim/body/particles/sheet_contact.h"
#include "brim/core/error.h"

namespace brim {

namespace {

MembraneElements make_membrane(const TriMesh& mesh, const ClothOptions& o) {
  if (mesh.triangles.empty()) throw InputError("cloth: the mesh has no triangles");
  require_positive("cloth", "areal density", o.areal_density);
  require_positive("cloth", "thickness", o.thickness);
  require_not_negative("cloth", "bending stiffness", o.bending);
  return MembraneElements(mesh, o.membrane);
}

std::vector<double> masses_of(const TriMesh& mesh, const MembraneElements& membrane, double areal_density) {
  std::vector<double> mass = membrane.lumped_mass(mesh.vertices.size(), areal_density);
  for (std::size_t i = 0; i < mass.size(); ++i)
    if (!(mass[i] > 0.0)) throw InputError(fmt::format("cloth: vertex {} is in no triangle", i));
  return mass;
}

}  // namespace

ClothBody::ClothBody(TriMesh mesh, ClothOptions options) : ClothBody(mesh, options, make_membrane(mesh, options)) {}

ClothBody::ClothBody(TriMesh mesh, ClothOptions options, MembraneElements membrane)
    : ParticleBody(mesh.vertices, masses_of(mesh, membrane, options.areal_density), options),
      mesh_(std::move(mesh)),
      membrane_(std::move(membrane)),
      bending_(mesh_, options.bending) {
  stiffness_.begin(particle_count());
  stiffness_.add_elements(membrane_.nodes(), 3);
  stiffness_.add_elements(bending_.nodes(), 4);
  stiffness_.finish();
  membrane_.find_pairs(stiffness_);
  bending_.find_pairs(stiffness_);
  force_.assign(particle_count(), Vec3::Zero());

  PartInfo part;
  part.voxel_size = 0.5 * options.thickness;
  part.modulus = 0.0;  // a sheet yields to whatever presses it
  part.areal_mass = options.areal_density;
  part.thickness = options.thickness;
  set_contact(std::make_unique<SheetContact>(mesh_.triangles, options.thickness), part);
  display_.triangles = mesh_.triangles;
  display_.two_sided = true;
}

void ClothBody::add_inner() {
  membrane_.add(x_, force_, stiffness_);
  bending_.add(x_, force_, stiffness_);
}

void ClothBody::add_turning_stiffness(std::span<const double> x, std::span<const std::uint8_t> guided,
                                      std::span<double> y) const {
  membrane_.add_turning(x_, x, guided, y);
}

}  // namespace brim
