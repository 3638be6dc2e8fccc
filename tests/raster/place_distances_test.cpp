#include "brim/raster/place_distances.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "brim/raster/known_distance.h"
#include "brim/raster/shape.h"

namespace brim::place_distances_test {
namespace {

TEST(PlaceDistances, AreThoseOfTheShapesAtEachPlaceBitForBit) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> u(-1.5, 1.5);
  constexpr int n = 203;  // not a multiple of any number of lanes
  std::vector<double> x(n), y(n), z(n), d(n);
  for (int i = 0; i < n; ++i) x[i] = u(rng), y[i] = u(rng), z[i] = u(rng);
  for (const auto& shape : {make_sphere(0.7), make_box(Vec3(1, 1.4, 0.8)), make_capsule(0.3, 1.2),
                            make_cylinder(0.5, 1.1), make_half_space()}) {
    const auto& known = dynamic_cast<const KnownDistance&>(*shape);
    known.distances({x.data(), y.data(), z.data(), n}, d.data());
    for (int i = 0; i < n; ++i) EXPECT_EQ(d[i], shape->distance({x[i], y[i], z[i]}));
  }
}

}  // namespace
}  // namespace brim::place_distances_test
