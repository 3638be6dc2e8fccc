#include "brim/response/cut_model.h"

#include <gtest/gtest.h>

#include <random>

namespace brim::cut_model_test {
namespace {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;

double value(const std::vector<Cut>& cuts, const Mat2& H, const Vec2& t, const Vec2& from) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Cut& c : cuts) most = std::max(most, c.value + c.slope.dot(t - c.at));
  return most + 0.5 * (t - from).dot(H * (t - from));
}

TEST(CutModel, FindsTheLeastPointOfUpToFourCuts) {
  std::mt19937 rng(9);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 200; ++round) {
    Mat2 H = Mat2::Identity();
    H(0, 0) = 0.5 + std::abs(normal(rng)), H(1, 1) = 0.5 + std::abs(normal(rng));
    CutModel model(H);
    std::vector<Cut> cuts;
    for (int i = 0; i <= round % 4; ++i) {
      cuts.push_back({Vec2(normal(rng), normal(rng)), Vec2(normal(rng), normal(rng)), normal(rng)});
      model.add(cuts.back());
    }
    const Vec2 from(normal(rng), normal(rng));
    double foretold = 0.0;
    const Vec2 best = model.least(from, foretold);
    EXPECT_NEAR(foretold, value(cuts, H, best, from), 1e-9);
    // Convex: no place around it is lower, near or far.
    for (const double r : {1e-3, 0.1, 1.0})
      for (int k = 0; k < 16; ++k) {
        const double angle = 2.0 * M_PI * k / 16;
        EXPECT_GE(value(cuts, H, best + r * Vec2(std::cos(angle), std::sin(angle)), from), foretold - 1e-9);
      }
  }
}

}  // namespace
}  // namespace brim::cut_model_test
