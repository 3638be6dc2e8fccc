#include "brim/io/slice_stack.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>

#include "brim/core/error.h"

namespace brim::slice_stack_test {
namespace {

/// n slices of a turned, tilted stack in any order. @param step  [mm] from one to the next
std::vector<StackSlice> stack(int n, const Vec3& step, const Mat3& turn = Mat3::Identity()) {
  std::vector<StackSlice> slices(static_cast<std::size_t>(n));
  for (int k = 0; k < n; ++k) {
    StackSlice& s = slices[static_cast<std::size_t>(k)];
    s.name = fmt::format("s{}", k);
    s.row = turn.col(0), s.column = turn.col(1);
    s.position = Vec3(3, -2, 1) + k * step;
    s.step = {0.25, 0.5};
    s.width = 4, s.height = 3;
  }
  return slices;
}

std::string message(const std::vector<StackSlice>& slices) {
  try {
    stack_slices("scan", slices);
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

TEST(SliceStack, AnyOrderTurnAndTiltGivesThePlacesBack) {
  std::mt19937 rng(11);
  std::normal_distribution<double> g;
  for (int round = 0; round < 50; ++round) {
    const Mat3 turn = Quat(g(rng), g(rng), g(rng), g(rng)).normalized().toRotationMatrix();
    const double shear = 0.4 * g(rng);
    const Vec3 step = 2.5 * turn.col(2) + shear * turn.col(1);
    auto slices = stack(9, step, turn);
    std::shuffle(slices.begin(), slices.end(), rng);
    const SliceStack s = stack_slices("scan", slices);
    EXPECT_TRUE(s.origin.isApprox(Vec3(3, -2, 1), 1e-12));
    EXPECT_TRUE(s.axes.col(0).isApprox(0.25 * turn.col(0), 1e-12));
    EXPECT_TRUE(s.axes.col(1).isApprox(0.5 * turn.col(1), 1e-12));
    EXPECT_TRUE(s.axes.col(2).isApprox(step, 1e-12));
    EXPECT_NEAR(s.tilt, std::atan(std::abs(shear) / 2.5), 1e-7);
    for (int k = 0; k < 9; ++k) EXPECT_EQ(slices[s.order[static_cast<std::size_t>(k)]].name, fmt::format("s{}", k));
  }
}

TEST(SliceStack, ASingleSliceIsAsThickAsItSays) {
  auto slices = stack(1, Vec3::Zero());
  EXPECT_NE(message(slices).find("without a thickness"), std::string::npos);
  slices[0].thickness = 5.0;
  EXPECT_TRUE(stack_slices("scan", slices).axes.col(2).isApprox(Vec3(0, 0, 5)));
}

TEST(SliceStack, WhatIsNoEvenStackIsRefusedWithItsPlace) {
  const auto good = stack(8, Vec3(0, 0, 2));
  EXPECT_EQ(message(good), "");
  const auto refused = [&](auto change, std::initializer_list<const char*> words) {
    auto slices = good;
    change(slices);
    const std::string text = message(slices);
    for (const char* w : words) EXPECT_NE(text.find(w), std::string::npos) << w << " is not in \"" << text << '"';
  };
  refused([](auto& s) { s.erase(s.begin() + 3); }, {"1 missing between s2 at 5 mm and s4 at 9 mm", "7 slices", "2 mm"});
  refused([](auto& s) { s.erase(s.begin() + 2, s.begin() + 5); }, {"3 missing between s1 at 3 mm and s5 at 11 mm"});
  refused([](auto& s) { s.erase(s.begin() + 1); }, {"1 missing between s0"});
  refused([](auto& s) { s.push_back(s[5]), s.back().name = "again"; }, {"s5 and again are at the same place, 11 mm"});
  refused(
      [](auto& s) {
        for (int k = 0; k < 8; ++k) s.push_back(s[static_cast<std::size_t>(k)]);
      },
      {"s0 and s0 are at the same place", "and 5 more"});
  refused([](auto& s) { s[4].position.z() += 0.7; }, {"2.7 mm between s3 at 7 mm and s4 at 9.7 mm", "1.3 mm between"});
  refused([](auto& s) { s[4].position.x() += 0.7; }, {"s4 lies 0.7 mm from its place"});
  refused([](auto& s) { s[4].row = Vec3(0, 1, 0), s[4].column = Vec3(0, 0, 1); }, {"s0 and s4 are not parallel"});
  refused([](auto& s) { s[4].width = 5; }, {"s0 has 4 x 3 pixels, s4 has 5 x 3"});
  refused([](auto& s) { s[4].step.y() = 0.6; }, {"s4 of 0.25 x 0.6 mm"});
  refused([](auto& s) { s[4].row = Vec3(2, 0, 0); }, {"s4", "unit vectors"});
  refused([](auto& s) { s[4].position.x() = std::nan(""); }, {"s4", "finite"});
  refused([](auto& s) { s[4].step.x() = 0.0; }, {"s4", "positive"});
  refused(
      [](auto& s) {
        for (auto& slice : s) slice.position.setZero();
      },
      {"one place"});
  EXPECT_NE(message({}).find("no slices"), std::string::npos);
}

TEST(SliceStack, PlacesRoundedByTheScannerAreTaken) {
  auto slices = stack(40, Vec3(0, 0, 1.25));
  for (StackSlice& s : slices) s.position = (10.0 * s.position.array()).round() / 10.0;
  const SliceStack s = stack_slices("scan", slices);
  EXPECT_NEAR(s.axes(2, 2), 1.25, 0.1 / 39);
}

}  // namespace
}  // namespace brim::slice_stack_test
