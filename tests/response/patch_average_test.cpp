#include "brim/response/patch_average.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace brim::patch_average_test {
namespace {

constexpr unsigned kSeed = 81;

/// Averages at all points of values that the first points have.
std::vector<double> averages(const std::vector<Vec3>& x, const std::vector<double>& v, double cell, const Vec3& origin,
                             PatchLattice& lattice) {
  lattice.place(x, cell, origin);
  PatchField<float> field;
  field.clear(lattice.size());
  for (std::size_t i = 0; i < v.size(); ++i) field.add(lattice[i], static_cast<float>(v[i]));
  std::vector<double> found;
  for (std::size_t i = 0; i < x.size(); ++i) found.push_back(field.at(lattice[i]));
  return found;
}

TEST(PatchAverage, OneSampleByHand) {
  // Half to the lattice point (0, 0, 0), half to (2, 0, 0).
  PatchLattice lattice;
  const std::vector<double> found = averages(
      {Vec3(1, 0, 0), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(3, 0, 0), Vec3(0, 2, 0)}, {8.0}, 2.0, Vec3::Zero(), lattice);
  EXPECT_EQ(found, (std::vector<double>{4.0, 4.0, 4.0, 2.0, 0.0}));
}

TEST(PatchAverage, EqualsTheSumOverAllPairsOfTentsInDenseAndInScatteredPatches) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const double cell = 1.5;
  const auto tent = [&](const Vec3& p, const Vec3& node) {
    double w = 1.0;
    for (int d = 0; d < 3; ++d) w *= std::max(0.0, 1.0 - std::abs(p[d] - node[d]) / cell);
    return w;
  };
  PatchLattice lattice;
  std::size_t dense = 0, scattered = 0;
  for (const double spread : {5.0, 20.0, 3.0, 400.0}) {
    std::vector<Vec3> x;
    std::vector<double> v;
    for (int i = 0; i < 400; ++i) {
      const double a = u(rng), b = u(rng), c = u(rng);
      x.push_back(spread * Vec3(a, b, c));
      if (i < 300) v.push_back(u(rng));
    }
    const std::vector<double> found = averages(x, v, cell, Vec3::Zero(), lattice);
    (lattice.size() > 512 + 8 * x.size() || spread > 50.0 ? scattered : dense) += 1;
    EXPECT_LE(lattice.size(), 512 + 8 * x.size());
    for (std::size_t i = 250; i < 350; ++i) {
      double expected = 0.0;
      for (int n = 0; n < 8; ++n) {
        const Vec3 node = cell * Vec3((x[i] / cell).array().floor().matrix() + Vec3(n & 1, n >> 1 & 1, n >> 2));
        for (std::size_t s = 0; s < v.size(); ++s) expected += tent(x[i], node) * tent(x[s], node) * v[s];
      }
      EXPECT_NEAR(found[i], expected, 3e-5) << "sums of some hundred numbers in single precision";
    }
  }
  EXPECT_GT(dense, 0u);
  EXPECT_GT(scattered, 0u);
}

}  // namespace
}  // namespace brim::patch_average_test
