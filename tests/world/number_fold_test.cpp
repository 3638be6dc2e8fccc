#include "brim/world/number_fold.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

namespace brim::number_fold_test {
namespace {

using Take = NumberFold::Take;

double folded(Take take, const std::vector<double>& numbers) {
  NumberFold fold(take);
  for (const double x : numbers) fold.add(x);
  return fold.value();
}

TEST(NumberFold, IsWhatAllNumbersTogetherGive) {
  const unsigned seed = 5;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-3.0, 3.0);
  for (int size = 1; size < 20; ++size) {
    std::vector<double> x(static_cast<std::size_t>(size));
    for (double& v : x) v = number(random);
    const double sum = std::accumulate(x.begin(), x.end(), 0.0);
    EXPECT_EQ(folded(Take::Sum, x), sum);
    EXPECT_EQ(folded(Take::SumAfterFirst, x), std::accumulate(x.begin() + 1, x.end(), 0.0));
    EXPECT_EQ(folded(Take::Mean, x), sum / size);
    EXPECT_EQ(folded(Take::Last, x), x.back());
    EXPECT_EQ(folded(Take::Least, x), *std::ranges::min_element(x));
    EXPECT_EQ(folded(Take::Largest, x), *std::ranges::max_element(x));
    EXPECT_EQ(folded(Take::FarthestFromOne, x),
              *std::ranges::max_element(x, {}, [](double v) { return std::abs(v - 1.0); }));
  }
}

TEST(NumberFold, WhatIsNotANumberDoesNotHide) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> rows[] = {{none, 1.0}, {1.0, none}, {1.0, none, 2.0}};
  for (const Take take : {Take::Mean, Take::Sum, Take::Least, Take::Largest, Take::FarthestFromOne})
    for (const std::vector<double>& x : rows) EXPECT_TRUE(std::isnan(folded(take, x))) << static_cast<int>(take);
  EXPECT_EQ(folded(Take::Last, {none, 2.0}), 2.0);
  EXPECT_EQ(folded(Take::SumAfterFirst, {none, 2.0}), 2.0) << "the first belongs to what came before";
  EXPECT_TRUE(std::isnan(NumberFold(Take::Sum).value())) << "of no number";
}

}  // namespace
}  // namespace brim::number_fold_test
