#pragma once

#include "brim/body/meshless/meshless_body.h"
#include "brim/body/volume/soft_image_body.h"
#include "support/images.h"

/// Blocks whose nodes carry particles of matter: meshless, and of the voxels of an image.
namespace brim::testing {

inline double box_distance(const Vec3& x, const Vec3& half) {
  const Vec3 d = x.cwiseAbs() - half;
  return d.cwiseMax(0.0).norm() + std::min(d.maxCoeff(), 0.0);
}

inline ElasticOptions soft(double young = 1e4, LayerWeights weights = LayerWeights::DensityRate) {
  ElasticOptions o;
  o.young = young;
  o.poisson = 0.3;
  o.weights = weights;
  return o;
}

inline std::unique_ptr<MeshlessBody> meshless(const Vec3& extents, double spacing, double cell, ElasticOptions o,
                                              const Vec3& at = Vec3::Zero()) {
  const Vec3 half = 0.5 * extents;
  const MeshlessModel m =
      fill_with_frames([=](const Vec3& x) { return box_distance(x, half); }, {-half, half}, spacing, cell);
  return std::make_unique<MeshlessBody>(m, Quat::Identity(), at, std::move(o));
}

inline std::unique_ptr<SoftImageBody> voxels(const Vec3& extents, double spacing, double cell, ElasticOptions o,
                                             const Vec3& at = Vec3::Zero()) {
  const Vec3 half = 0.5 * extents;
  const VoxelImage image = scan({-half - Vec3::Constant(cell), half + Vec3::Constant(cell)}, 0.5 * cell,
                                [=](const Vec3& x) { return box_distance(x, half); });
  const OccupancyGrid grid = sample_occupancy(image, {0, 100}, cell);
  return std::make_unique<SoftImageBody>(grid, display_surface(grid), spacing, Quat::Identity(), at, std::move(o));
}

}  // namespace brim::testing
