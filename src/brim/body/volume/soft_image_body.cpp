#include "brim/body/volume/soft_image_body.h"

#include <Eigen/LU>

#include "brim/core/error.h"
#include "brim/mesh/lattice_around.h"

namespace brim {

namespace {

/// Cells with less than this share of matter are left out. [1/255]
constexpr int kLeastMatter = 4;

/// Rows of barycentric weights.
WeightRows rows_of(const TetMesh& mesh, const Embedding& embedding) {
  WeightRows rows;
  for (std::size_t i = 0; i < embedding.tet.size(); ++i) {
    const Tetrahedron& t = mesh.tets[static_cast<std::size_t>(embedding.tet[i])];
    rows.source.insert(rows.source.end(), t.begin(), t.end());
    rows.weight.insert(rows.weight.end(), embedding.weights[i].begin(), embedding.weights[i].end());
    rows.first.push_back(static_cast<std::int32_t>(rows.source.size()));
  }
  return rows;
}

}  // namespace

SoftImageBody::Parts SoftImageBody::build(const OccupancyGrid& matter, const TriMesh& surface, double spacing,
                                          const Quat& rotation, const Vec3& position, const ElasticOptions& options) {
  require_positive("image volume", "density", options.density);
  require_positive("image volume", "Young's modulus", options.young);
  if (!(options.poisson > -1.0 && options.poisson < 0.5))
    throw InputError(
        fmt::format("image volume: Poisson's ratio is {}; it must be between -1 and 0.5", options.poisson));
  Parts parts;
  std::vector<Vec3> x;
  const double cell = matter.spacing * matter.spacing * matter.spacing;
  for (int k = 0; k < matter.cells.z(); ++k)
    for (int j = 0; j < matter.cells.y(); ++j)
      for (int i = 0; i < matter.cells.x(); ++i) {
        const int share = matter.share[matter.index(i, j, k)];
        if (share < kLeastMatter) continue;
        x.push_back(matter.center(i, j, k));
        parts.carriage.volume.push_back(cell * share / 255.0);
        parts.carriage.mass.push_back(options.density * parts.carriage.volume.back());
      }
  // Cells that are mostly full hold tetrahedra all over.
  std::vector<double> edges;
  for (const double v : parts.carriage.volume) edges.push_back(v > 0.5 * cell ? matter.spacing : 0.0);
  HeldPoints held = lattice_around(x, spacing, edges);
  parts.mesh = std::move(held.mesh);
  parts.carriage.weights = rows_of(parts.mesh, held.embedding);
  parts.surface.triangles = surface.triangles;
  parts.surface.weights = rows_of(parts.mesh, embed(parts.mesh, surface.vertices));

  for (Vec3& p : parts.mesh.vertices) p = position + rotation * p;
  for (const std::int32_t e : held.embedding.tet) {
    const Tetrahedron& t = parts.mesh.tets[static_cast<std::size_t>(e)];
    Mat3 sides;
    for (int k = 0; k < 3; ++k) sides.col(k) = parts.mesh.vertices[t[k + 1]] - parts.mesh.vertices[t[0]];
    const Mat3 g = sides.inverse().transpose();
    parts.carriage.gradient.push_back(-g.rowwise().sum());
    for (int k = 0; k < 3; ++k) parts.carriage.gradient.push_back(g.col(k));
  }
  return parts;
}

SoftImageBody::SoftImageBody(const OccupancyGrid& matter, const TriMesh& surface, double spacing, const Quat& rotation,
                             const Vec3& position, ElasticOptions options)
    : SoftImageBody(build(matter, surface, spacing, rotation, position, options), options) {}

SoftImageBody::SoftImageBody(Parts parts, const ElasticOptions& options)
    : CarriedBody(parts.mesh.vertices, parts.carriage, options.weights, parts.surface, options.young, options),
      parts_(std::move(parts)),
      elements_(parts_.mesh, options.neo_hookean ? ElasticLaw::StableNeoHookean : ElasticLaw::CorotationalLinear,
                Lame::from(options.young, options.poisson)) {
  stiffness_.begin(particle_count());
  stiffness_.add_elements(elements_.nodes(), 4);
  stiffness_.finish();
  elements_.find_pairs(stiffness_);
  force_.assign(particle_count(), Vec3::Zero());
}

}  // namespace brim
