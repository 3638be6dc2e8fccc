#include "brim/body/posed_shape.h"

#include <cmath>

#include "brim/body/posed_display.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/raster/averaged_distances.h"

namespace brim {

PosedShape::PosedShape(std::shared_ptr<const Shape> shape, Shared<TriMesh> surface)
    : shape_(std::move(shape)), known_(dynamic_cast<const KnownDistance*>(shape_.get())), surface_(std::move(surface)) {
  if (shape_ == nullptr) throw InputError("solid: there is no shape; give one, such as make_sphere(0.1)");
}

const KnownDistance* PosedShape::known_distance_averaged(double w, Averaged which) const {
  const auto* shape = dynamic_cast<const AveragedDistances*>(shape_.get());
  return shape != nullptr && (which == Averaged::All || shape->detailed()) ? &shape->averaged(w) : known_;
}

double PosedShape::box_reach(const Vec3& center) const {
  const Aabb box = shape_->bounds();
  const Vec3 far = (box.hi - center).cwiseAbs().cwiseMax((box.lo - center).cwiseAbs());
  return far.allFinite() ? far.norm() : 0.0;
}

double PosedShape::reach(const Vec3& center) const {
  // Of a half space the surface shows a part only.
  const Aabb box = shape_->bounds();
  if (surface_->vertices.empty() || !box.lo.allFinite() || !box.hi.allFinite()) return box_reach(center);
  double most = 0.0;
  for (const Vec3& p : surface_->vertices) most = std::max(most, (p - center).norm());
  return most;
}

void PosedShape::presence(double h, double w, const Aabb& region, std::vector<TileKey>& out) const {
  shape_presence(*shape_, pose_, h, w, region, out);
}

double PosedShape::distance_bound(const Vec3& x) const {
  if (known_ == nullptr) return -std::numeric_limits<double>::infinity();
  return known_->least_distance(pose_.to_local(x));
}

void PosedShape::rasterize(double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const {
  parallel_for(tiles.size(), [&](std::size_t i) { shape_->fill(pose_, tiles[i], h, w, out[i]); });
}

void PosedShape::display_positions(std::span<Vec3f> x) const { place_vertices(surface_->vertices, pose_, x); }

}  // namespace brim
