#include "brim/body/posed_display.h"

namespace brim {

const PosedDisplay* posed_display(const Body& body) { return dynamic_cast<const PosedDisplay*>(&body); }

void place_vertices(std::span<const Vec3> rest, const Pose& pose, std::span<Vec3f> x) {
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = (pose.rotation * rest[i] + pose.translation).cast<float>();
}

}  // namespace brim
