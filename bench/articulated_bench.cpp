// Cost of chains over their number of links: the product of the implicit step, its inverse, the free motion, the maps.

#include <benchmark/benchmark.h>

#include "brim/body/articulated/articulated_body.h"
#include "brim/body/articulated/chain_model.h"

namespace brim {
namespace {

struct Chain {
  std::unique_ptr<ArticulatedBody> body;
  std::vector<double> q, v, x, y;
  BlockDiagonal D;
  explicit Chain(int links) {
    ChainOptions o;
    o.links = links;
    o.each.damping = 1e-3;
    body = std::make_unique<ArticulatedBody>(chain_model(o));
    q.resize(body->q_size()), v.resize(body->v_size());
    body->initial_state(q, v);
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = 0.01 * static_cast<double>(i * 7919 % 13) - 0.06;
    body->update(0.0, q, v);
    body->begin_solve(0.01);
    D.reset(body->block_sizes());
    body->add_system_diagonal(0, D);
    body->prepare_preconditioner(0, D);
    x = v, y = v;
  }
};

void per_link(benchmark::State& state) {
  state.counters["s_per_link"] =
      benchmark::Counter(static_cast<double>(state.range(0)) * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void apply_system(benchmark::State& state) {
  Chain c(static_cast<int>(state.range(0)));
  for (auto _ : state) c.body->apply_system(c.x, c.y);
  per_link(state);
}
BENCHMARK(apply_system)->RangeMultiplier(10)->Range(10, 1000);

void precondition(benchmark::State& state) {
  Chain c(static_cast<int>(state.range(0)));
  for (auto _ : state) c.body->precondition(0, c.D, c.x, c.y);
  per_link(state);
}
BENCHMARK(precondition)->RangeMultiplier(10)->Range(10, 1000);

void prepare(benchmark::State& state) {
  Chain c(static_cast<int>(state.range(0)));
  for (auto _ : state) c.body->prepare_preconditioner(0, c.D);
  per_link(state);
}
BENCHMARK(prepare)->RangeMultiplier(10)->Range(10, 1000);

void update(benchmark::State& state) {
  Chain c(static_cast<int>(state.range(0)));
  for (auto _ : state) c.body->update(0.0, c.q, c.v);
  per_link(state);
}
BENCHMARK(update)->RangeMultiplier(10)->Range(10, 1000);

void finish_step(benchmark::State& state) {
  Chain c(static_cast<int>(state.range(0)));
  auto q = c.q, v = c.v;
  for (auto _ : state) {
    v = c.v;
    c.body->finish_step(0.0, 1.0 / 60.0, q, v);
  }
  per_link(state);
}
BENCHMARK(finish_step)->RangeMultiplier(10)->Range(10, 1000);

/// J v and Jᵀ f of 20 points on the last link.
void map_of_the_last_link(benchmark::State& state) {
  Chain c(static_cast<int>(state.range(0)));
  std::vector<Vec3> points(20, Vec3(1, 2, 3)), u(20);
  const std::vector<std::int32_t> sources(20, 0);
  std::unique_ptr<Map> map;
  c.body->make_map(c.body->part_count() - 1, points, sources, map);
  for (auto _ : state) {
    map->apply(c.x, u);
    map->apply_transpose(u, c.y);
  }
  per_link(state);
}
BENCHMARK(map_of_the_last_link)->RangeMultiplier(10)->Range(10, 1000);

}  // namespace
}  // namespace brim
