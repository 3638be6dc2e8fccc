#include "brim/raster/image_shape.h"

#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"
#include "brim/raster/averaged_solid.h"
#include "brim/raster/ball_field.h"

namespace brim {

namespace {

/// How far each block of cells is from the nearest block with matter: from box to box, exact up to a reach.
class MatterMask {
 public:
  explicit MatterMask(const OccupancyGrid& grid)
      : corner_(grid.origin - Vec3::Constant(0.5 * grid.spacing)), block_(kBlock * grid.spacing) {
    n_ = ((grid.cells.array() + kBlock - 1) / kBlock).matrix();
    constexpr float kFar = kReach * kReach;
    gap_.assign(static_cast<std::size_t>(n_.x()) * n_.y() * n_.z(), kFar);
    for (int k = 0; k < grid.cells.z(); ++k)
      for (int j = 0; j < grid.cells.y(); ++j)
        for (int i = 0; i < grid.cells.x(); ++i)
          if (grid.share[grid.index(i, j, k)] > 0) gap_[at(i / kBlock, j / kBlock, k / kBlock)] = 0.0f;
    // Squares of gaps along the axes add, so each axis can be swept by itself.
    const std::size_t step[3] = {1, static_cast<std::size_t>(n_.x()), static_cast<std::size_t>(n_.x()) * n_.y()};
    for (int a = 0; a < 3; ++a) {
      const int u = (a + 1) % 3, v = (a + 2) % 3;
      parallel_for(static_cast<std::size_t>(n_[v]), [&](std::size_t jv) {
        std::vector<float> line(static_cast<std::size_t>(n_[a]));
        for (int ju = 0; ju < n_[u]; ++ju) {
          float* first = gap_.data() + step[u] * static_cast<std::size_t>(ju) + step[v] * jv;
          for (int i = 0; i < n_[a]; ++i) line[i] = first[step[a] * i];
          for (int i = 0; i < n_[a]; ++i) {
            float best = kFar;
            for (int m = std::max(0, i - kReach); m <= std::min(n_[a] - 1, i + kReach); ++m) {
              const float d = static_cast<float>(std::max(0, std::abs(i - m) - 1));
              best = std::min(best, line[m] + d * d);
            }
            first[step[a] * i] = best;
          }
        }
      });
    }
  }

  /// At most the distance from p to matter, [m]; 0 at and near it.
  double distance(const Vec3& p) const {
    const Vec3 x = (p - corner_) / block_;
    const Vec3 inside = x.cwiseMax(0.0).cwiseMin(n_.cast<double>() - Vec3::Constant(1e-9));
    const Vec3i b = inside.cast<int>();
    // From outside of the grid, which is convex, the way on turns by a right angle or more.
    return std::sqrt((x - inside).squaredNorm() + gap_[at(b.x(), b.y(), b.z())]) * block_;
  }

 private:
  static constexpr int kBlock = 4;   // [cells]
  static constexpr int kReach = 16;  // [blocks]
  std::size_t at(int i, int j, int k) const {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(n_.x()) * (j + static_cast<std::size_t>(n_.y()) * k);
  }
  Vec3 corner_;
  double block_;
  Vec3i n_;
  std::vector<float> gap_;  // [blocks²]
};

class ImageShape final : public Shape {
 public:
  ImageShape(OccupancyGrid grid, double thickness)
      : spacing_(grid.spacing),
        mask_(grid),
        box_(grid.matter_box().inflated(grid.spacing)),
        thickness_(thickness),
        pyramid_(std::move(grid)) {}

  /// Interpolation spreads the density by a cell.
  double distance(const Vec3& p) const override { return std::max(0.0, mask_.distance(p) - spacing_); }
  Aabb bounds() const override { return box_; }
  double thickness() const override { return thickness_; }

  void fill(const Pose& pose, const TileKey& tile, double h, double w, DensityBlock& out) const override {
    const BallField& field = pyramid_.field(w);
    std::fill(std::begin(out.source), std::end(out.source), 0);
    const Mat3 back = pose.rotation.transpose();
    const Vec3 base = back * (block_origin(tile, h) - pose.translation);
    const Mat3 step = h * back;
    const Vec3 half = Vec3::Constant(0.5 * (kBlockSize - 1));
    const Vec3 center = base + step * half, extent = step.cwiseAbs() * half;
    if (const int all = field.uniform({center - extent, center + extent}); all != 0) {
      std::fill(std::begin(out.rho), std::end(out.rho), all > 0 ? 0.0 : 1.0);
      return;
    }
    double* rho = out.rho;
    for (int k = 0; k < kBlockSize; ++k)
      for (int j = 0; j < kBlockSize; ++j) {
        const Vec3 row = base + step.col(1) * j + step.col(2) * k;
        for (int i = 0; i < kBlockSize; ++i) *rho++ = ramp(field.distance(row + step.col(0) * i), field.width());
      }
  }

 private:
  double spacing_;
  MatterMask mask_;
  Aabb box_;
  double thickness_;
  OccupancyPyramid pyramid_;
};

}  // namespace

std::shared_ptr<const Shape> make_image_shape(OccupancyGrid grid, double thickness) {
  return std::make_shared<ImageShape>(std::move(grid), thickness);
}

}  // namespace brim
