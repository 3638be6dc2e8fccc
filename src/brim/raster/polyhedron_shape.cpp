#include "brim/raster/polyhedron_shape.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "brim/mesh/distance_grid.h"
#include "brim/mesh/topology.h"
#include "brim/raster/averaged_distances.h"
#include "brim/raster/averaged_solid.h"
#include "brim/raster/known_distance.h"
#include "brim/raster/polyhedron_distances.h"

namespace brim {

namespace {

/// Nodes of the samples from which a solid averaged over balls is computed: per diameter of a ball, and at most per
/// side.
constexpr double kNodesOfBall = 6.0, kMostNodes = 400.0;

/// Samples in one thread: a parallel loop could wait for a thread that waits for the lock of averaged().
DistanceGrid sampled(const PolyhedronDistances& distance, const Aabb& box, double w) {
  const Aabb around = box.inflated(w);
  const double spacing = std::max(w / kNodesOfBall, around.extent().maxCoeff() / kMostNodes);
  const Vec3i nodes = (around.extent() / spacing).array().ceil().cast<int>() + 1;
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(nodes.x()) * static_cast<std::size_t>(nodes.y()) *
                 static_cast<std::size_t>(nodes.z()));
  for (int k = 0; k < nodes.z(); ++k)
    for (int j = 0; j < nodes.y(); ++j)
      for (int i = 0; i < nodes.x(); ++i)
        values.push_back(static_cast<float>(distance(around.lo + spacing * Vec3(i, j, k))));
  return {around.lo, spacing, nodes, std::move(values)};
}

class Polyhedron final : public Shape, public KnownDistance, public ConvexDistance, public AveragedDistances {
 public:
  explicit Polyhedron(ConvexPolyhedron solid)
      : distance_(std::move(solid)), box_(brim::bounds(distance_.solid().corners)) {
    // The least extent across a face.
    for (const auto& f : distance_.solid().faces) {
      double deepest = 0.0;
      for (const Vec3& x : distance_.solid().corners) deepest = std::max(deepest, f.offset - f.normal.dot(x));
      thickness_ = std::min(thickness_, deepest);
    }
  }

  double distance(const Vec3& p) const override { return distance_(p); }
  double slack() const override { return 0.0; }
  double rough_distance(const Vec3& p) const override { return distance_(p); }
  void distances(const PlaceArrays& at, double* d) const override { distance_.at(at, d); }
  double distance_and_gradient(const Vec3& p, Vec3& gradient) const override { return distance_(p, gradient); }
  Vec3 support(const Vec3& direction) const override {
    const auto& corners = distance_.solid().corners;
    return *std::ranges::max_element(corners, {}, [&](const Vec3& x) { return direction.dot(x); });
  }
  void cube_distances(const Pose& pose, const NodeCube& cube, const NodeMask& wanted, double, float* d) const override {
    distance_.at(CubeFrame(pose, cube), wanted, d);
  }
  bool by_rows() const override { return true; }
  const ConvexDistance* convex() const override { return this; }
  Aabb bounds() const override { return box_; }
  double thickness() const override { return thickness_; }
  void fill(const Pose& pose, const TileKey& tile, double h, double w, DensityBlock& out) const override {
    fill_block(distance_, pose, tile, h, w, out);
  }
  const KnownDistance& averaged(double w) const override {
    const std::scoped_lock lock(mutex_);
    auto& a = averaged_[w];
    if (!a) a = std::make_unique<Averaged>(distance_, box_, w);
    return a->solid;
  }
  bool detailed() const override { return false; }

 private:
  struct Averaged {
    DistanceGrid grid;
    BallField field;
    AveragedSolid solid;
    Averaged(const PolyhedronDistances& distance, const Aabb& box, double w)
        : grid(sampled(distance, box, w)), field(occupancy_of(grid), w), solid(grid, field) {}
  };

  PolyhedronDistances distance_;
  Aabb box_;
  double thickness_ = std::numeric_limits<double>::infinity();
  mutable std::mutex mutex_;
  mutable std::map<double, std::unique_ptr<Averaged>> averaged_;
};

}  // namespace

std::shared_ptr<const Shape> make_polyhedron(ConvexPolyhedron solid) {
  return std::make_shared<Polyhedron>(std::move(solid));
}

}  // namespace brim
