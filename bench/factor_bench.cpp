// The factor of what contact touches (solve/block_cholesky.h), of three kinds of matrices: a sheet of 50 x 50 nodes
// whose bending ties nodes two cells apart, a solid of n³ nodes tied to their 26 neighbours, and many such solids one
// after another, whose factors no cache holds.

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "brim/solve/block_cholesky.h"

namespace brim {
namespace {

struct Matrix {
  std::vector<std::int32_t> first{0}, column;
  std::vector<BlockCholesky::Block> value;
  std::size_t nodes() const { return first.size() - 1; }
};

/// A lattice whose nodes are tied where `tied` says so of the steps between them: a spring matrix, and a little mass.
template <class Tied>
Matrix lattice(const std::array<int, 3>& n, int reach, const Tied& tied) {
  Matrix m;
  const auto node = [&](int x, int y, int z) { return (z * n[1] + y) * n[0] + x; };
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) {
        const std::size_t diagonal = m.value.size();
        m.column.push_back(node(x, y, z));
        m.value.push_back(BlockCholesky::Block::Identity() * 0.01f);
        for (int dz = -reach; dz <= reach; ++dz)
          for (int dy = -reach; dy <= reach; ++dy)
            for (int dx = -reach; dx <= reach; ++dx) {
              const int u = x + dx, v = y + dy, w = z + dz;
              if (u < 0 || v < 0 || w < 0 || u >= n[0] || v >= n[1] || w >= n[2]) continue;
              if ((dx == 0 && dy == 0 && dz == 0) || !tied(std::abs(dx), std::abs(dy), std::abs(dz))) continue;
              const Eigen::Vector3f d = Eigen::Vector3f(dx, dy, dz).normalized();
              const BlockCholesky::Block spring = d * d.transpose() + 0.1f * BlockCholesky::Block::Identity();
              m.value[diagonal] += spring;
              if (node(u, v, w) < node(x, y, z)) continue;
              m.column.push_back(node(u, v, w));
              m.value.push_back(-spring);
            }
        m.first.push_back(static_cast<std::int32_t>(m.column.size()));
      }
  return m;
}

Matrix sheet() {
  return lattice({50, 50, 1}, 2, [](int dx, int dy, int) { return dx + dy <= 2; });
}
Matrix patch() {  // where two solids touch
  return lattice({32, 16, 2}, 1, [](int, int, int) { return true; });
}
Matrix solid(int n) {
  return lattice({n, n, n}, 1, [](int, int, int) { return true; });
}

void factor(benchmark::State& state, const Matrix& matrix) {
  BlockCholesky factor;
  factor.analyze(matrix.first, matrix.column);
  for (auto _ : state) benchmark::DoNotOptimize(factor.factor(matrix.value));
  state.counters["entries"] = static_cast<double>(factor.entries());
}

void solve(benchmark::State& state, const Matrix& matrix, std::size_t many) {
  std::vector<BlockCholesky> factors(many);
  for (BlockCholesky& f : factors) f.analyze(matrix.first, matrix.column), f.factor(matrix.value);
  std::vector<float> x(3 * matrix.nodes(), 1.0f);
  for (auto _ : state) {
    for (BlockCholesky& f : factors) f.solve(x);
    benchmark::DoNotOptimize(x.data());
    for (float& v : x) v = 1.0f;
  }
  state.counters["entries"] = static_cast<double>(many * factors.front().entries());
}

BENCHMARK_CAPTURE(factor, sheet, sheet())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(factor, solid, solid(10))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, sheet, sheet(), 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, solid, solid(10), 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(factor, patch, patch())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, patch, patch(), 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, many_patches, patch(), 32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, many_solids, solid(10), 32)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace brim
