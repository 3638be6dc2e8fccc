#include "brim/raster/grid_shape.h"

#include <mutex>

#include "brim/mesh/distance_row.h"
#include "brim/raster/averaged_distances.h"
#include "brim/raster/averaged_solid.h"
#include "brim/raster/cube_distances.h"
#include "brim/raster/known_distance.h"

namespace brim {

namespace {

class GridShape final : public Shape, public KnownDistance, public AveragedDistances {
 public:
  GridShape(std::shared_ptr<const DistanceGrid> grid, double thickness)
      : grid_(std::move(grid)), box_(grid_->solid_box()), thickness_(thickness) {}

  double distance(const Vec3& p) const override { return grid_->value(p); }
  double slack() const override { return grid_->spacing(); }
  double rough_distance(const Vec3& p) const override { return grid_->value(p, Interpolation::Trilinear); }
  void distances(const PlaceArrays& at, double* d) const override {
    distance_places(*grid_, at.x, at.y, at.z, at.count, d);
  }
  double least_distance(const Vec3& p) const override { return grid_->least_value(p); }
  void least_distances(const CubeFrame& f, const float* i, const float* j, const float* k, float* out) const override {
    least_values(*grid_, f.base, f.dx, f.dy, f.dz, i, j, k, out);
  }
  bool by_rows() const override { return false; }
  bool tells_direction() const override { return true; }
  void cube_distances(const Pose& pose, const NodeCube& cube, const NodeMask& wanted, double reach,
                      float* d) const override {
    const CubeFrame f(pose, cube);
    wanted.for_rows([&](int j, int k, std::uint8_t row) {
      distance_row(*grid_, f.base + j * f.dy + k * f.dz, f.dx, row, reach, d + cube_index(0, j, k));
    });
  }
  const KnownDistance& averaged(double w) const override {
    const std::scoped_lock lock(mutex_);
    if (!pyramid_) pyramid_ = std::make_unique<OccupancyPyramid>(occupancy_of(*grid_));
    auto& solid = averaged_[w];
    if (!solid) solid = std::make_unique<AveragedSolid>(*grid_, pyramid_->field(w));
    return *solid;
  }
  bool detailed() const override { return true; }
  Aabb bounds() const override { return box_; }
  double thickness() const override { return thickness_; }

  void fill(const Pose& pose, const TileKey& tile, double h, double w, DensityBlock& out) const override {
    // A trilinear value tells which nodes lie near the surface; only those pay for the smooth one. Trilinear errs by
    // less than a spacing there.
    const double band = 0.5 * w + grid_->spacing();
    fill_block(
        [&](const Vec3& p) {
          const double rough = grid_->value(p, Interpolation::Trilinear);
          return std::abs(rough) > band ? rough : grid_->value(p);
        },
        pose, tile, h, w, out, grid_->spacing());
  }

 private:
  std::shared_ptr<const DistanceGrid> grid_;
  Aabb box_;
  double thickness_;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<OccupancyPyramid> pyramid_;
  mutable std::map<double, std::unique_ptr<AveragedSolid>> averaged_;
};

}  // namespace

std::shared_ptr<const Shape> make_grid_shape(std::shared_ptr<const DistanceGrid> grid, double thickness) {
  return std::make_shared<GridShape>(std::move(grid), thickness);
}

}  // namespace brim
