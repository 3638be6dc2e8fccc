#include "brim/body/fem/fem_body.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/map/point_weights.h"
#include "brim/mesh/tet_lattice.h"
#include "brim/mesh/topology.h"

namespace brim {

namespace {

TetElements make_elements(const TetMesh& mesh, const FemOptions& o) {
  if (mesh.tets.empty()) throw InputError("finite elements: the mesh has no tetrahedra");
  require_positive("finite elements", "density", o.density);
  require_positive("finite elements", "Young's modulus", o.young);
  if (!(o.poisson > -1.0 && o.poisson < 0.5))
    throw InputError(fmt::format("finite elements: Poisson's ratio is {}; it must be between -1 and 0.5", o.poisson));
  return TetElements(mesh, o.law, Lame::from(o.young, o.poisson));
}

std::vector<double> masses_of(const TetMesh& mesh, const TetElements& elements, double density) {
  std::vector<double> mass = elements.lumped_mass(mesh.vertices.size(), density);
  for (std::size_t i = 0; i < mass.size(); ++i)
    if (!(mass[i] > 0.0)) throw InputError(fmt::format("finite elements: vertex {} is in no tetrahedron", i));
  return mass;
}

}  // namespace

FemBody::FemBody(TetMesh mesh, FemOptions options) : FemBody(mesh, options, make_elements(mesh, options)) {}

FemBody::FemBody(TetMesh mesh, FemOptions options, TetElements elements)
    : ParticleBody(mesh.vertices, masses_of(mesh, elements, options.density), options),
      mesh_(std::move(mesh)),
      elements_(std::move(elements)) {
  stiffness_.begin(particle_count());
  stiffness_.add_elements(elements_.nodes(), 4);
  stiffness_.finish();
  elements_.find_slots(stiffness_);
  TetSurface surface = tet_surface(mesh_);
  surface_ = std::move(surface.triangles);
  owner_ = std::move(surface.owner);
  force_.assign(particle_count(), Vec3::Zero());

  // Two voxels per boundary edge resolve the faces; the column behind the contact is at most the longest extent.
  double edge = 0.0, area = 0.0;
  for (const Triangle& t : surface_) {
    for (int i = 0; i < 3; ++i) edge += (rest_[t[i]] - rest_[t[(i + 1) % 3]]).norm();
    area += 0.5 * (rest_[t[1]] - rest_[t[0]]).cross(rest_[t[2]] - rest_[t[0]]).norm();
  }
  edge /= 3.0 * static_cast<double>(surface_.size());
  const Vec3 extent = bounds(0).extent();
  const double volume = elements_.volume();
  part_.voxel_size = options_.voxel_size > 0.0 ? options_.voxel_size : 0.5 * edge;
  part_.areal_mass = options.density * volume * extent.maxCoeff() / extent.prod();
  part_.thickness = std::min(extent.minCoeff(), 6.0 * volume / area);
  part_.modulus = options.young;
  part_.material = options_.material;
  if (immobile()) part_.areal_mass = 0.0;
  make_display(options.display);
}

PartInfo FemBody::part(int) const { return part_; }

void FemBody::presence(int, double h, double w, const Aabb& region, std::vector<TileKey>& out) const {
  auto workspace = workspace_.borrow();
  presence_tets(solid(), h, w, region, out, *workspace);
}

void FemBody::rasterize(int, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const {
  auto workspace = workspace_.borrow();
  raster_tets(solid(), tiles, h, w, out, *workspace);
}

void FemBody::make_map(int, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                       std::unique_ptr<Map>& map) const {
  BRIM_CHECK(points.size(), ==, sources.size());
  auto* weights = dynamic_cast<PointWeightsMap*>(map.get());
  if (weights == nullptr) {
    auto made = std::make_unique<PointWeightsMap>();
    weights = made.get();
    map = std::move(made);
  }
  weights->reset(particle_count(), points.size(), 4);
  parallel_blocks(points.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const Tetrahedron& t = mesh_.tets[sources[p]];
      const auto w = tet_weights(points[p], {x_[t[0]], x_[t[1]], x_[t[2]], x_[t[3]]});
      const auto row = weights->row(p);
      std::copy(t.begin(), t.end(), row.particle.begin());
      std::copy(w.begin(), w.end(), row.weight.begin());
    }
  });
  weights->finish();
}

void FemBody::make_display(const TriMesh& fine) {
  if (!fine.triangles.empty()) {
    const Embedding embedding = embed(mesh_, fine.vertices);
    for (const std::int32_t e : embedding.tet) carrier_.push_back(mesh_.tets[e]);
    weight_ = embedding.weights;
    display_.triangles = fine.triangles;
  } else {
    // The boundary with its own numbering, so that inner nodes are not written to files.
    std::vector<std::int32_t> number(particle_count(), -1);
    for (Triangle t : surface_) {
      for (std::int32_t& n : t) {
        if (number[n] < 0) {
          number[n] = static_cast<std::int32_t>(carrier_.size());
          carrier_.push_back({n, n, n, n});
          weight_.push_back({1.0, 0.0, 0.0, 0.0});
        }
        n = number[n];
      }
      display_.triangles.push_back(t);
    }
  }
  display_.vertices = carrier_.size();
}

void FemBody::display_positions(std::span<Vec3f> x) const {
  BRIM_CHECK(x.size(), ==, carrier_.size());
  parallel_blocks(x.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 sum = Vec3::Zero();
      for (int k = 0; k < 4; ++k) sum += weight_[i][k] * x_[carrier_[i][k]];
      x[i] = sum.cast<float>();
    }
  });
}

}  // namespace brim
