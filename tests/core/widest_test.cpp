#include "brim/core/widest.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>

namespace brim::widest_test {
namespace {

template <class Widest>
BRIM_INLINE void combine(const float* a, const float* b, float s, float* out) {
  const auto x = load_widest<Widest>(a), y = load_widest<Widest>(b);
  auto z = s * (x + y) - x * y;
  z += x * s;
  z -= s + y;
  store_lanes(out, z);
}

BRIM_WIDEST(by_machine, (const float* a, const float* b, float s, float* out), combine<Widest>(a, b, s, out))

using Numbers = std::array<float, kWidestLanes>;

struct Operands {
  Numbers a, b;
  float s = 0.7f;
  Operands() {
    for (std::size_t i = 0; i < a.size(); ++i) {
      a[i] = 1.0f / static_cast<float>(i + 1);
      b[i] = 3.0f - 0.1f * static_cast<float>(i);
    }
  }
};

// One register, two registers, numbers one by one and what the machine chooses.
TEST(Widest, HasTheSameBitsInOneRegisterAndInTwo) {
  const Operands o;
  Numbers one, two, chosen;
  combine<InOne>(o.a.data(), o.b.data(), o.s, one.data());
  combine<InTwo>(o.a.data(), o.b.data(), o.s, two.data());
  by_machine(o.a.data(), o.b.data(), o.s, chosen.data());
  for (std::size_t i = 0; i < one.size(); ++i) {
    const float a = o.a[i], b = o.b[i], expected = o.s * (a + b) - a * b + a * o.s - (o.s + b);
    EXPECT_EQ(one[i], expected) << i;
    EXPECT_EQ(two[i], expected) << i;
    EXPECT_EQ(chosen[i], expected) << i;
  }
}

template <class Widest>
void expect_halves() {
  const Operands o;
  const auto whole = joined<Widest>(load_wide(o.a.data()), load_wide(o.a.data() + kWideLanes));
  Numbers stored;
  store_lanes(stored.data(), whole);
  EXPECT_EQ(stored, o.a);
  store_wide(low_of(whole), stored.data() + kWideLanes);
  store_wide(high_of(whole), stored.data());
  for (std::size_t i = 0; i < stored.size(); ++i) EXPECT_EQ(stored[i], o.a[(i + kWideLanes) % stored.size()]);
}

TEST(Widest, JoinsHalvesAndTakesThemApart) {
  expect_halves<InOne>();
  expect_halves<InTwo>();
}

TEST(Widest, HoldsEightDoubles) {
  const std::array<double, 8> x = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0};
  std::array<double, 8> one, two;
  store_lanes(one.data(), 0.1 * load_widest<InOne>(x.data()));
  store_lanes(two.data(), 0.1 * load_widest<InTwo>(x.data()));
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_EQ(one[i], 0.1 * x[i]);
    EXPECT_EQ(two[i], 0.1 * x[i]);
  }
}

}  // namespace
}  // namespace brim::widest_test
