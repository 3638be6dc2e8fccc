#include "brim/body/posed_shape.h"

#include <cmath>

#include "brim/core/parallel.h"
#include "brim/raster/known_distance.h"

namespace brim {

PosedShape::PosedShape(std::shared_ptr<const Shape> shape, TriMesh surface)
    : shape_(std::move(shape)), surface_(std::move(surface)) {
  const auto* known = dynamic_cast<const KnownDistance*>(shape_.get());
  slack_ = known != nullptr ? known->slack() : std::numeric_limits<double>::infinity();
}

double PosedShape::box_reach(const Vec3& center) const {
  const Aabb box = shape_->bounds();
  const Vec3 far = (box.hi - center).cwiseAbs().cwiseMax((box.lo - center).cwiseAbs());
  return far.allFinite() ? far.norm() : 0.0;
}

double PosedShape::reach(const Vec3& center) const {
  if (surface_.vertices.empty()) return box_reach(center);
  double most = 0.0;
  for (const Vec3& p : surface_.vertices) most = std::max(most, (p - center).norm());
  return most;
}

void PosedShape::presence(double h, double w, const Aabb& region, std::vector<TileKey>& out) const {
  shape_presence(*shape_, pose_, h, w, region, out);
}

double PosedShape::distance_bound(const Vec3& x) const {
  return std::isfinite(slack_) ? shape_->distance(pose_.to_local(x)) - slack_ : -slack_;
}

void PosedShape::rasterize(double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const {
  parallel_for(tiles.size(), [&](std::size_t i) { shape_->fill(pose_, tiles[i], h, w, out[i]); });
}

void PosedShape::display_positions(std::span<Vec3f> x) const {
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] = (pose_.rotation * surface_.vertices[i] + pose_.translation).cast<float>();
}

}  // namespace brim
