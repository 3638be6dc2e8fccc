#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/scene/document.h"
#include "brim/scene/pairs/pair_table.h"
#include "brim/scene/scene.h"
#include "brim/world/world.h"

/// Impulses on bodies of every kind.
namespace brim::impulse_kinds_test {
namespace {

TEST(ImpulseKinds, MomentumChangesByTheImpulseAndAngularMomentumByItsMoment) {
  PairTable table = standard_pairs();
  int acted = 0;
  for (const PairKind& upper : table.kinds) {
    SCOPED_TRACE(upper.name);
    World w = build_world(parse_scene(pair_scene_text(table, table.find("plane"), upper)));
    ASSERT_TRUE(w.step().ok);  // it moves
    const Body& body = w.body(1);
    Aabb box;
    for (int p = 0; p < body.part_count(); ++p) box.extend(body.bounds(p));
    const Vec3 impulse(0.3, -0.2, 0.5), asked = box.center() + 0.3 * box.extent();
    if (body.immobile() || body.kind() == "grid_fluid") {
      EXPECT_THROW(w.apply_impulse(1, impulse, asked), InputError);
      continue;
    }
    ++acted;
    const Vec3 linear = body.linear_momentum(w.v(1)), angular = body.angular_momentum(w.v(1));
    const Vec3 at = w.apply_impulse(1, impulse, asked);
    // On sheets, rods and loose nodes: their middle, or the nearest node.
    const double size = box.extent().norm();
    EXPECT_LT((at - asked).norm(), 0.3 * size);
    // Rounding, and what is left of the residual of conjugate gradients: 4e-14 and 6e-16 measured.
    EXPECT_NEAR((body.linear_momentum(w.v(1)) - linear - impulse).norm(), 0.0, 1e-12 * impulse.norm());
    EXPECT_NEAR((body.angular_momentum(w.v(1)) - angular - at.cross(impulse)).norm(), 0.0,
                1e-12 * (size + at.norm()) * impulse.norm());
  }
  EXPECT_GE(acted, 11);
}

}  // namespace
}  // namespace brim::impulse_kinds_test
