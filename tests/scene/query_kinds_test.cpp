#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "brim/scene/document.h"
#include "brim/scene/pairs/pair_table.h"
#include "brim/scene/scene.h"
#include "brim/world/body_motion.h"
#include "brim/world/queries.h"
#include "brim/world/world.h"

/// Queries on bodies of every kind.
namespace brim::query_kinds_test {
namespace {

TEST(QueryKinds, RaysFromAllSidesMeetEveryKindAndNearestPointsAgree) {
  PairTable table = standard_pairs();
  for (const PairKind& upper : table.kinds) {
    SCOPED_TRACE(upper.name);
    Json scene = Json::parse(pair_scene_text(table, table.find("plane"), upper));
    World w = build_world(parse_scene(scene.dump()));
    const auto only = [](int b) { return b == 1; };
    for (int step = 0; step < 2; ++step) {
      int met = 0;
      Aabb box;
      for (int p = 0; p < w.body(1).part_count(); ++p) box.extend(w.body(1).bounds(p));
      if (!box.extent().allFinite()) break;  // a plane has no sides
      const Vec3 middle = box.center();
      const double size = box.extent().norm();
      for (int i = 0; i < 60; ++i) {
        const double turn = 2.39996 * i, z = 1.0 - 2.0 * (i + 0.5) / 60.0, s = std::sqrt(1.0 - z * z);
        const Vec3 from = middle + 1.5 * size * Vec3(s * std::cos(turn), s * std::sin(turn), z);
        const auto near = w.closest_point(from, 1e9, only);
        ASSERT_TRUE(near);
        ASSERT_GT(near->distance, 0.0);
        const auto hit = w.raycast(from, near->point - from, 1e9, only);
        if (!hit) continue;  // along a side below a sharp edge
        ++met;
        EXPECT_NEAR(hit->distance, near->distance, 0.02 * size);
        EXPECT_LT(hit->normal.dot(near->point - from), 0.0);
        EXPECT_EQ(w.overlap_ball(from, std::max(0.0, near->distance * 0.98 - 0.01 * size), only), std::vector<int>{});
        EXPECT_EQ(w.overlap_ball(from, near->distance * 1.001 + 1e-6, only), std::vector<int>{1});
        const Pose at{Mat3::Identity(), near->point};
        EXPECT_EQ(w.overlap_box(at, Vec3::Constant(0.02 * size), only), std::vector<int>{1});
        EXPECT_EQ(w.overlap_box({Mat3::Identity(), from}, Vec3::Constant(0.02 * size), only), std::vector<int>{});
      }
      EXPECT_GE(met, 55);
      ASSERT_TRUE(w.step().ok);
    }
  }
}

}  // namespace
}  // namespace brim::query_kinds_test
