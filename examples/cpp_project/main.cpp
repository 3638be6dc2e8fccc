// Drops a ball on a floor, and weighs it by the forces of contact (docs/cpp.md).
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "brim/brim.h"

namespace {

constexpr const char* kScene = R"({
  "brim": 1, "name": "drop", "duration": 2, "world": {"time_step": 0.01},
  "bodies": [
    {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
    {"kind": "rigid", "name": "ball", "mass": 2, "shape": {"kind": "sphere", "radius": 0.2},
     "transform": {"position": [0, 0, 0.5]}}
  ]
})";

}  // namespace

int main() {
  try {
    brim::World world = brim::build_world(brim::parse_scene(kScene));
    for (int step = 0; step < 200; ++step) {
      const brim::StepReport report = world.step();
      if (!report.ok) return EXIT_FAILURE;
    }
    // Forces are on part a; "ball" is body 1, and its only part is part 1.
    double weight = 0.0;
    for (const brim::ContactSample& c : world.contacts()) {
      const double up = c.force.z() + c.friction.z();
      if (world.part(c.part_a).body == 1) weight += up;
      if (world.part(c.part_b).body == 1) weight -= up;
    }
    const double height = world.q(1)[2];  // q of a rigid body: position, then quaternion
    std::printf("at %.2f s the ball lies at %.4f m and weighs %.3f N on %zu contacts\n", world.state().time, height,
                weight, world.contacts().size());
    return std::abs(height - 0.2) < 0.01 && std::abs(weight / (2 * 9.81) - 1.0) < 0.01 ? EXIT_SUCCESS : EXIT_FAILURE;
  } catch (const brim::InputError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return EXIT_FAILURE;
  }
}
