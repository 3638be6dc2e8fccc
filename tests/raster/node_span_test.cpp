#include "brim/raster/node_span.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/solids.h"

namespace brim::node_span_test {
namespace {

TEST(NodeSpan, RoundsAsTheLibraryDoes) {
  testing::Noise noise(3);
  for (int i = 0; i < 10000; ++i) {
    const double x = (i % 2 == 0 ? 1.0 : 1e6) * noise();
    EXPECT_EQ(node_below(x), std::floor(x));
    EXPECT_EQ(node_above(x), std::ceil(x));
  }
  for (const double x : {-3.0, 0.0, 7.0}) {
    EXPECT_EQ(node_below(x), x);
    EXPECT_EQ(node_above(x), x);
  }
  EXPECT_EQ(node_below(1e300), 1000000000);
  EXPECT_EQ(node_below(-1e300), -1000000000);
  EXPECT_EQ(node_below(std::numeric_limits<double>::quiet_NaN()), -1000000000);
}

TEST(NodeSpan, ElementsHaveTheNodesOfTheBoxOfTheirCorners) {
  testing::Noise noise(4);
  const double h = 0.13;
  for (int round = 0; round < 1000; ++round) {
    std::vector<Vec3> x;
    Aabb box;
    for (int i = 0; i < 4; ++i) {
      x.push_back(noise.vec());
      if (i == 1 && round % 3 == 0) x.back() = h * Vec3(1.0, -2.0, 3.0);  // on a node
      box.extend(x.back());
    }
    VertexNodes nodes;
    nodes.build(x, h, 1e-9);
    const NodeSpan found = nodes.around(Tetrahedron{0, 1, 2, 3}), expected = nodes_in(box, h, 1e-9);
    for (int a = 0; a < 3; ++a) {
      EXPECT_EQ(found.lo[a], expected.lo[a]);
      EXPECT_EQ(found.hi[a], expected.hi[a]);
    }
  }
}

}  // namespace
}  // namespace brim::node_span_test
