#include "brim/grid/node_cube.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::node_cube_test {
namespace {

bool has(const NodeMask& m, int i, int j, int k) {
  return i >= 0 && j >= 0 && k >= 0 && i < kCubeSize && j < kCubeSize && k < kCubeSize && (m.row(j, k) >> i & 1) != 0;
}

template <class F>
void for_all(const F& f) {
  for (int k = 0; k < kCubeSize; ++k)
    for (int j = 0; j < kCubeSize; ++j)
      for (int i = 0; i < kCubeSize; ++i) f(i, j, k);
}

TEST(NodeMask, BoxHoldsItsNodesAndNoOthers) {
  const Vec3i lo(1, 0, 3), hi(6, 7, 4);
  const NodeMask m = NodeMask::box(lo, hi);
  for_all([&](int i, int j, int k) {
    const Vec3i n(i, j, k);
    EXPECT_EQ(has(m, i, j, k), (n.array() >= lo.array()).all() && (n.array() <= hi.array()).all());
  });
  EXPECT_EQ(m.count(), 6 * 8 * 2);
}

TEST(NodeMask, GrowsByTheNeighboursThatASearchFinds) {
  std::mt19937_64 rng(5);
  for (int trial = 0; trial < 50; ++trial) {
    NodeMask m;
    for (auto& p : m.plane) p = rng() & rng() & rng() & rng() & rng();
    const NodeMask grown = m.grown(), rows = m.whole_rows();
    int count = 0, seen = 0;
    for_all([&](int i, int j, int k) {
      bool near = false, row = false;
      for (int c = -1; c <= 1; ++c)
        for (int b = -1; b <= 1; ++b)
          for (int a = -1; a <= 1; ++a) near = near || has(m, i + a, j + b, k + c);
      for (int a = 0; a < kCubeSize; ++a) row = row || has(m, a, j, k);
      EXPECT_EQ(has(grown, i, j, k), near);
      EXPECT_EQ(has(rows, i, j, k), row);
      count += has(m, i, j, k);
    });
    EXPECT_EQ(m.count(), count);
    EXPECT_EQ(m.any(), count > 0);
    m.for_rows([&](int j, int k, std::uint8_t bits) {
      EXPECT_EQ(bits, m.row(j, k));
      seen += std::popcount(bits);
    });
    EXPECT_EQ(seen, count);
    EXPECT_FALSE(m.without(m).any());
  }
}

}  // namespace
}  // namespace brim::node_cube_test
