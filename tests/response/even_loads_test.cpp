#include "brim/response/even_loads.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace brim::even_loads_test {
namespace {

struct Loads {
  double sum = 0.0, squares = 0.0;
  Vec3 moment = Vec3::Zero();
};

Loads of(const std::vector<Vec3>& x, const std::vector<double>& load) {
  Loads l;
  for (std::size_t i = 0; i < x.size(); ++i)
    l.sum += load[i], l.squares += load[i] * load[i], l.moment += load[i] * x[i];
  return l;
}

std::vector<Vec3> ring(int n, const Vec3& normal) {
  const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<Vec3> x;
  for (int i = 0; i < n; ++i) {
    const double a = 2.0 * M_PI * i / n;
    x.push_back(Vec3(1, 2, 3) + 0.3 * (std::cos(a) * u + std::sin(a) * v));
  }
  return x;
}

TEST(EvenLoads, KeepSumAndCentreWithTheLeastSquares) {
  const Vec3 normal = Vec3(1, 2, 2).normalized();
  for (const int n : {4, 5, 8}) {
    const std::vector<Vec3> x = ring(n, normal);
    std::vector<double> load(x.size());
    for (std::size_t i = 0; i < load.size(); ++i) load[i] = i % 2 == 0 ? 2.0 : 1.0 + 0.1 * static_cast<double>(i);
    const Loads before = of(x, load);
    ASSERT_TRUE(even_loads(x, normal, load));
    const Loads after = of(x, load);
    EXPECT_NEAR(after.sum, before.sum, 1e-12);
    EXPECT_LT((after.moment - before.moment).norm(), 1e-12);
    EXPECT_LT(after.squares, before.squares);
    // Once even, they stay.
    const std::vector<double> even = load;
    ASSERT_TRUE(even_loads(x, normal, load));
    for (std::size_t i = 0; i < load.size(); ++i) EXPECT_NEAR(load[i], even[i], 1e-12);
  }
}

TEST(EvenLoads, OfASquareLoadedInTheMiddleAreEqual) {
  const std::vector<Vec3> x = ring(4, Vec3::UnitZ());
  std::vector<double> load{2.0, 0.0, 2.0, 0.0};
  ASSERT_TRUE(even_loads(x, Vec3::UnitZ(), load));
  for (const double l : load) EXPECT_NEAR(l, 1.0, 1e-12);
}

TEST(EvenLoads, NeverPull) {
  const std::vector<Vec3> x = ring(6, Vec3::UnitZ());
  std::vector<double> load{5.0, 1.0, 0.0, 0.0, 0.0, 0.5};
  const Loads before = of(x, load);
  ASSERT_TRUE(even_loads(x, Vec3::UnitZ(), load));
  for (const double l : load) EXPECT_GE(l, 0.0);
  EXPECT_NEAR(of(x, load).sum, before.sum, 1e-12);
  EXPECT_LT((of(x, load).moment - before.moment).norm(), 1e-12);
}

TEST(EvenLoads, StayWhereNothingCanBeShared) {
  std::vector<double> three{1.0, 2.0, 3.0};
  EXPECT_FALSE(even_loads(ring(3, Vec3::UnitZ()), Vec3::UnitZ(), three));
  std::vector<double> line{1.0, 2.0, 3.0, 4.0};
  const std::vector<Vec3> x{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(3, 0, 0)};
  EXPECT_FALSE(even_loads(x, Vec3::UnitZ(), line));
  EXPECT_EQ(line, (std::vector<double>{1.0, 2.0, 3.0, 4.0}));
  std::vector<double> none(5, 0.0);
  EXPECT_FALSE(even_loads(ring(5, Vec3::UnitZ()), Vec3::UnitZ(), none));
}

}  // namespace
}  // namespace brim::even_loads_test
