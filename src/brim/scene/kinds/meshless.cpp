#include <algorithm>
#include <cmath>

#include "brim/body/meshless/meshless_body.h"
#include "brim/mesh/topology.h"
#include "brim/scene/carried.h"
#include "brim/scene/kinds.h"
#include "brim/scene/limits.h"
#include "brim/scene/solid.h"

namespace brim {

BodyKind meshless_kind();

namespace {

/// [bytes] of a frame with its samples and matrix blocks, and of a particle with its weights.
constexpr double kBytesPerFrame = 60e3, kBytesPerSample = 1200.0;

void check_meshless(const Node& n) {
  refuse_plane(n.at("shape"), "volume");
  check_shape(n.at("shape"));
  check_constraints(n.at("constraints"), false);
}

/// Voxels across the smallest extent of a shape, and particles up to which there are so many.
constexpr double kThinVoxels = 8.0, kParticles = 20'000.0;

/// [m] half the frame spacing, or finer where the shape is thin: a domino of two voxels leans on its edge and falls
/// over.
double chosen_voxel_size(double frame_spacing, const Aabb& box, double volume) {
  const double fine = std::max(box.extent().minCoeff() / kThinVoxels, std::cbrt(volume / kParticles));
  return std::min(0.5 * frame_spacing, fine);
}

class MeshlessMaker final : public BodyMaker {
 public:
  MeshlessMaker(const Node& n, const BuildContext& context) : node_(n), material_(context.material) {
    const double limit = context.world.memory_limit, scale = n.at("transform").number("scale");
    const Solid solid = read_solid(n, limit, context.solids);
    const Aabb box = solid.shape->bounds();
    const double spacing = scale * n.number("frame_spacing");
    const Node at = n.at("frame_spacing");
    if (spacing > box.extent().maxCoeff())
      throw at.error(fmt::format("{:.6g} m is not allowed; must be at most the shape's largest extent, {:.6g} m",
                                 spacing, box.extent().maxCoeff()));
    voxel_size_ = n.number("voxel_size");
    if (!(voxel_size_ > 0.0)) voxel_size_ = chosen_voxel_size(spacing, box, solid.unit.volume);
    check_count(at, 2.0 * solid.unit.volume / (spacing * spacing * spacing), kBytesPerFrame, limit, "frames");
    check_count(n.number("voxel_size") > 0.0 ? n.at("voxel_size") : n,
                solid.unit.volume / (voxel_size_ * voxel_size_ * voxel_size_), kBytesPerSample, limit, "particles");
    model_ = at.placed([&] {
      return fill_with_frames([&](const Vec3& x) { return solid.shape->distance(x); }, box, spacing, voxel_size_);
    });
    // A shape's own triangles may be as large as its faces, and would show nothing of how they bend.
    model_.surface = refine(*solid.surface, spacing);
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    ElasticOptions options = read_elastic(node_, place, material_);
    options.voxel_size = voxel_size_;
    std::vector<HeldRegion> held;
    if (node_.at("constraints").size() > 0) {
      const MeshlessBody free(model_, place.rotation, place.position, options);
      held = read_constraints(node_.at("constraints"), free.rest_positions(), {}, place.turned, options);
    }
    return std::make_unique<MeshlessBody>(model_, place.rotation, place.position, std::move(options), held);
  }

 private:
  Node node_;
  Material material_;
  double voxel_size_ = 0.0;
  MeshlessModel model_;
};

}  // namespace

BodyKind meshless_kind() {
  return {"meshless", check_meshless, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<MeshlessMaker>(n, c);
          }};
}

}  // namespace brim
