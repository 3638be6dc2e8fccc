#include "brim/body/cloth/cloth_body.h"

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/map/shell_weights.h"

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
      bending_(mesh_, options.bending),
      thickness_(options.thickness) {
  stiffness_.begin(particle_count());
  stiffness_.add_elements(membrane_.nodes(), 3);
  stiffness_.add_elements(bending_.nodes(), 4);
  stiffness_.finish();
  membrane_.find_slots(stiffness_);
  bending_.find_slots(stiffness_);
  force_.assign(particle_count(), Vec3::Zero());

  part_.voxel_size = options_.voxel_size > 0.0 ? options_.voxel_size : 0.5 * thickness_;
  part_.areal_mass = immobile() ? 0.0 : options.areal_density;
  part_.thickness = thickness_;
  part_.material = options_.material;
  display_.vertices = particle_count();
  display_.triangles = mesh_.triangles;
  display_.two_sided = true;
}

void ClothBody::add_inner() {
  membrane_.add(x_, force_, stiffness_);
  bending_.add(x_, force_, stiffness_);
}

PartInfo ClothBody::part(int) const { return part_; }

Aabb ClothBody::bounds(int p) const { return ParticleBody::bounds(p).inflated(0.5 * thickness_); }

void ClothBody::presence(int, double h, double w, const Aabb& region, std::vector<TileKey>& out) const {
  auto workspace = workspace_.borrow();
  presence_triangles(x_, mesh_.triangles, thickness_, h, w, region, out, *workspace);
}

void ClothBody::rasterize(int, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const {
  auto workspace = workspace_.borrow();
  raster_triangles(x_, mesh_.triangles, thickness_, tiles, h, w, out, *workspace);
}

void ClothBody::make_map(int, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                         std::unique_ptr<Map>& map) const {
  BRIM_CHECK(points.size(), ==, sources.size());
  auto* weights = dynamic_cast<ShellWeightsMap*>(map.get());
  if (weights == nullptr) {
    auto made = std::make_unique<ShellWeightsMap>();
    weights = made.get();
    map = std::move(made);
  }
  weights->reset(particle_count(), points.size());
  parallel_blocks(points.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) weights->set(p, points[p], mesh_.triangles[sources[p]], x_);
  });
  weights->finish();
}

void ClothBody::display_positions(std::span<Vec3f> x) const {
  BRIM_CHECK(x.size(), ==, particle_count());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = x_[i].cast<float>();
}

}  // namespace brim
