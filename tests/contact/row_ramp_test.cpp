#include "brim/contact/row_ramp.h"

#include <gtest/gtest.h>

#include "brim/math/ramp.h"

namespace brim::row_ramp_test {
namespace {

TEST(RowRamp, InvertsTheRampAtEveryDensity) {
  constexpr int kSteps = 100000;
  const double w = 0.06;
  for (int first = -80; first <= kSteps + 80; first += kCubeSize) {
    alignas(32) float rho[kCubeSize], d[kCubeSize];
    for (int i = 0; i < kCubeSize; ++i) rho[i] = static_cast<float>(first + i) / kSteps;
    row_ramp_inverse(rho, static_cast<float>(w), d);
    for (int i = 0; i < kCubeSize; ++i) ASSERT_NEAR(d[i], ramp_inverse(rho[i], w), 2e-7 * w) << rho[i];
  }
}

TEST(RowRamp, TellsSmallDensitiesToTheirLastDigits) {
  alignas(32) float rho[kCubeSize], d[kCubeSize];
  for (int i = 0; i < kCubeSize; ++i) rho[i] = std::pow(10.0f, static_cast<float>(-i));
  row_ramp_inverse(rho, 1.0f, d);
  for (int i = 0; i < kCubeSize; ++i) EXPECT_NEAR(d[i], ramp_inverse(rho[i], 1.0), 2e-7) << rho[i];
}

}  // namespace
}  // namespace brim::row_ramp_test
