#include "brim/mesh/exact_cells.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "brim/core/parallel.h"
#include "brim/mesh/distance_grid.h"
#include "brim/mesh/distance_row.h"
#include "brim/mesh/primitives.h"

/// Sampled distances beside sharp edges are those to the surface itself.
namespace brim::exact_cells_test {
namespace {

DistanceGrid grid_of(const TriMesh& mesh, double spacing) {
  DistanceGridOptions options;
  options.spacing = spacing, options.margin = 4.0 * spacing;
  return make_distance_grid(mesh, options);
}

/// Largest error near the surface, over the spacing.
double worst_error(const DistanceGrid& grid, const TriMesh& mesh, double* of_rows = nullptr) {
  const SurfaceTree tree(mesh);
  std::mt19937 rng(6);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  double worst = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 p = grid.box().lo + grid.box().extent().cwiseProduct(Vec3(unit(rng), unit(rng), unit(rng)));
    const double exact = tree.signed_distance(p);
    if (std::abs(exact) > 2.0 * grid.spacing()) continue;
    worst = std::max(worst, std::abs(grid.value(p) - exact) / grid.spacing());
    if (of_rows == nullptr) continue;
    float row[8] = {};
    distance_row(grid, p, Vec3(1e-3 * grid.spacing(), 0, 0), 1, 10.0, row);
    *of_rows = std::max(*of_rows, std::abs(row[0] - exact) / grid.spacing());
  }
  return worst;
}

TEST(ExactCells, DistancesBesideEdgesAndCornersAreRight) {
  const TriMesh box = shapes::box(Vec3(0.83, 0.61, 0.47));
  DistanceGrid grid = grid_of(box, 0.05);
  ASSERT_NE(grid.exact_cells(), nullptr);
  double rows = 0.0;
  // Cells with a smaller error at nine places, or without kinks, are left as they are.
  EXPECT_LT(worst_error(grid, box, &rows), 0.05);
  EXPECT_LT(rows, 0.05);
  grid.set_exact_cells(nullptr);
  EXPECT_GT(worst_error(grid, box), 0.07) << "or the cells do nothing";
}

TEST(ExactCells, RoundSurfacesHaveNone) {
  EXPECT_EQ(grid_of(shapes::icosphere(1.0, 3), 0.05).exact_cells(), nullptr);
  EXPECT_EQ(grid_of(shapes::cylinder(0.5, 0.4), 0.05).exact_cells(), nullptr) << "nor have their sharp rims";
}

TEST(ExactCells, AtTheirBordersValuesJumpByTheErrorOfInterpolation) {
  const DistanceGrid g = grid_of(shapes::gear(8, 0.5, 0.35, 0.3, 0.1), 0.05);
  ASSERT_NE(g.exact_cells(), nullptr);
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double e = 1e-9;
  double worst = 0.0;
  for (int i = 0; i < 6000; ++i) {
    Vec3 p = g.box().lo + g.box().extent().cwiseProduct(Vec3(unit(rng), unit(rng), unit(rng)));
    const int k = i % 3;
    p[k] = g.origin()[k] + g.spacing() * std::round((p[k] - g.origin()[k]) / g.spacing());
    if (std::abs(g.value(p)) > 2.0 * g.spacing()) continue;
    worst = std::max(worst, std::abs(g.value(p + e * Vec3::Unit(k)) - g.value(p - e * Vec3::Unit(k))));
  }
  EXPECT_LT(worst, 0.1 * g.spacing());
  RecordProperty("worst_jump_in_spacings", std::to_string(worst / g.spacing()));
}

TEST(ExactCells, SameBitsForAnyNumberOfThreads) {
  const TriMesh box = shapes::box(Vec3(0.83, 0.61, 0.47));
  std::vector<double> first;
  for (const int threads : {1, 3}) {
    const ThreadLimit limit(threads);
    const DistanceGrid grid = grid_of(box, 0.06);
    std::vector<double> values;
    for (double x = -0.5; x < 0.5; x += 0.01) values.push_back(grid.value(Vec3(x, 0.29, 0.22)));
    if (first.empty()) first = values;
    EXPECT_EQ(values, first);
  }
}

}  // namespace
}  // namespace brim::exact_cells_test
