#include "brim/math/block_matrix.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/core/parallel.h"
#include "brim/math/block_rows.h"

namespace brim::block_matrix_test {
namespace {

constexpr unsigned kSeed = 81;

/// Random triples of nodes and random blocks.
struct Sample {
  BlockMatrix matrix;
  std::vector<double> mass, x;
  std::mt19937 rng{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};

  explicit Sample(std::int32_t nodes = 700) {
    std::vector<std::int32_t> triples;
    for (std::int32_t i = 0; i < 3 * nodes; ++i) {
      const auto other = [&] { return static_cast<std::int32_t>(rng() % static_cast<unsigned>(nodes)); };
      const std::int32_t a = i % nodes;
      std::int32_t b = other(), c = other();
      while (b == a) b = other();
      while (c == a || c == b) c = other();
      triples.insert(triples.end(), {a, b, c});
    }
    matrix.begin(static_cast<std::size_t>(nodes));
    matrix.add_elements(triples, 3);
    matrix.finish();
    for (std::size_t t = 0; t < triples.size(); t += 3)
      for (const auto& [i, j] : {std::pair(0, 1), std::pair(2, 1), std::pair(0, 2)}) {
        Mat3 K;
        for (double& e : K.reshaped()) e = uniform(rng);
        matrix.add(matrix.pair(triples[t + i], triples[t + j]), K);
      }
    matrix.close();
    for (std::int32_t i = 0; i < nodes; ++i) mass.push_back(1.0 + uniform(rng));
    for (std::int32_t i = 0; i < 3 * nodes; ++i) x.push_back(uniform(rng));
  }
  detail::BlockRows rows(std::vector<std::int32_t>& diagonal, std::vector<float>& value,
                         std::vector<Mat3>& on_diagonal) const {
    for (std::size_t r = 0; r < matrix.rows(); ++r) {
      diagonal.push_back(matrix.diagonal_slot(r));
      on_diagonal.push_back(matrix.diagonal(r));
    }
    for (std::size_t s = 0; s < matrix.block_count(); ++s) {
      const Eigen::Matrix3f B = matrix.block(static_cast<std::int32_t>(s)).cast<float>();
      value.insert(value.end(), B.data(), B.data() + 9);
    }
    value.push_back(0.0f);
    return {matrix.row_first().data(), diagonal.data(), matrix.columns().data(), value.data(), on_diagonal.data()};
  }
};

TEST(BlockMatrix, APairByHand) {
  BlockMatrix K;
  K.begin(2);
  K.add_elements(std::vector<std::int32_t>{1, 0}, 2);
  K.finish();
  Mat3 B;
  B << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  K.add(K.pair(1, 0), B);
  K.close();
  EXPECT_EQ(K.block(K.slot(1, 0)), B);
  EXPECT_EQ(K.block(K.slot(0, 1)), B.transpose());
  EXPECT_EQ(K.diagonal(0), -B.transpose());
  EXPECT_EQ(K.diagonal(1), -B);
  const std::vector<double> x = {1, 0, 0, 0, 0, 2}, m = {10, 100};
  std::vector<double> y(6, 1.0);
  K.multiply_add(2.0, 3.0, m, x, y);
  // Row 0: Bᵀ (x_1 − x_0) = Bᵀ (−1, 0, 2); row 1: B (1, 0, −2).
  EXPECT_EQ(y, (std::vector<double>{1 + 2 * 13 + 30, 1 + 2 * 14, 1 + 2 * 15, 1 - 2 * 5, 1 - 2 * 8, 1 - 2 * 11 + 600}));
}

TEST(BlockMatrix, BlocksAcrossTheDiagonalAreTransposesToTheLastBit) {
  const Sample s;
  for (std::size_t r = 0; r < s.matrix.rows(); ++r)
    for (std::int32_t k = s.matrix.row_first()[r]; k < s.matrix.row_first()[r + 1]; ++k) {
      const std::int32_t c = s.matrix.columns()[static_cast<std::size_t>(k)];
      const Mat3 mirror = s.matrix.block(s.matrix.slot(c, static_cast<std::int32_t>(r)));
      if (c != static_cast<std::int32_t>(r)) {
        ASSERT_EQ(s.matrix.block(k), mirror.transpose());
      }
    }
}

TEST(BlockMatrix, ATranslationGivesNothingInDouble) {
  const Sample s;
  std::vector<double> t, y(s.x.size(), 0.0), none(s.mass.size(), 0.0);
  for (std::size_t i = 0; i < s.mass.size(); ++i) t.insert(t.end(), {3.1, -2.7, 1.9});
  s.matrix.multiply_add(1.0, 0.0, none, t, y);
  // Some 18 blocks of size 1 a row: their rounding in double, which single precision would be 1e8 times.
  for (const double e : y) EXPECT_NEAR(e, 0.0, 1e-13);
}

TEST(BlockMatrix, TheProductIsThatOfItsBlocks) {
  const Sample s;
  std::vector<double> y(s.x.size(), 0.5);
  s.matrix.multiply_add(1.5, -0.7, s.mass, s.x, y);
  for (std::size_t r = 0; r < s.matrix.rows(); ++r) {
    Vec3 sum = Vec3::Zero();
    const Eigen::Map<const Vec3> xr(s.x.data() + 3 * r);
    for (std::int32_t k = s.matrix.row_first()[r]; k < s.matrix.row_first()[r + 1]; ++k)
      if (k != s.matrix.diagonal_slot(r))
        sum += s.matrix.block(k) * (Eigen::Map<const Vec3>(s.x.data() + 3 * s.matrix.columns()[k]) - xr);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(y[3 * r + static_cast<std::size_t>(k)], 0.5 + 1.5 * sum[k] - 0.7 * s.mass[r] * xr[k], 1e-12);
  }
}

TEST(BlockMatrix, WideAndNarrowInstructionsGiveTheSameBits) {
  if (!detail::has_wide_rows()) GTEST_SKIP() << "this machine has no AVX2";
  const Sample s;
  std::vector<std::int32_t> diagonal;
  std::vector<float> value;
  std::vector<Mat3> on_diagonal;
  const detail::BlockRows rows = s.rows(diagonal, value, on_diagonal);
  std::vector<double> narrow(s.x.size(), 0.3), wide = narrow;
  detail::multiply_rows(rows, 0, s.mass.size(), 1.7, 0.9, s.mass.data(), s.x.data(), narrow.data());
  detail::multiply_rows_wide(rows, 0, s.mass.size(), 1.7, 0.9, s.mass.data(), s.x.data(), wide.data());
  EXPECT_EQ(narrow, wide);
}

TEST(BlockMatrix, AnyNumberOfThreadsGivesTheSameBits) {
  const auto product = [](int threads) {
    const ThreadLimit limit(threads);
    const Sample s(3000);
    std::vector<double> y(s.x.size(), 0.0);
    s.matrix.multiply_add(1.0, 1.0, s.mass, s.x, y);
    return y;
  };
  EXPECT_EQ(product(1), product(2));
}

TEST(BlockMatrix, ASumOfMatricesIsTheirSum) {
  const Sample a;
  BlockMatrix sum = a.matrix;
  sum.combine(2.0, a.matrix, -0.5, a.matrix);
  for (std::size_t s = 0; s < sum.block_count(); ++s) {
    const auto slot = static_cast<std::int32_t>(s);
    EXPECT_TRUE(sum.block(slot).isApprox(1.5 * a.matrix.block(slot), 1e-6));
  }
}

}  // namespace
}  // namespace brim::block_matrix_test
