#include <benchmark/benchmark.h>

#include "brim/body/particle_fluid/particle_fluid_body.h"

/// What a fluid of 24,389 particles costs a step apart from contact: neighbours, the product of the solve, its
/// diagonal.
namespace brim {
namespace {

struct Cube {
  ParticleFluidBody body;
  std::vector<double> q, v;

  static ParticleFluidOptions options(double viscosity) {
    ParticleFluidOptions o;
    o.spacing = 1.0 / 29;
    o.viscosity = viscosity;
    return o;
  }
  explicit Cube(double viscosity)
      : body(lattice_in_box(Vec3::Zero(), Vec3::Ones(), 1.0 / 29).x, options(viscosity)),
        q(body.q_size()),
        v(body.v_size()) {
    body.initial_state(q, v);
    body.update(0.0, q, v);
    body.begin_solve(0.004);
  }
};

void neighbours(benchmark::State& state) {
  Cube c(0.0);
  double shift = 1e-6;
  for (auto _ : state) {
    c.q[0] += shift, shift = -shift;  // another state, so that nothing is reused
    c.body.update(0.0, c.q, c.v);
  }
}

void product(benchmark::State& state) {
  Cube c(state.range(0) ? 1.0 : 0.0);
  std::vector<double> y(c.v.size());
  for (std::size_t i = 0; i < c.v.size(); ++i) c.v[i] = static_cast<double>(i % 7);
  for (auto _ : state) c.body.apply_system(c.v, y);
}

void diagonal(benchmark::State& state) {
  Cube c(0.0);
  BlockDiagonal D;
  for (auto _ : state) {
    D.reset(c.body.block_sizes());
    c.body.add_system_diagonal(0, D);
  }
}

BENCHMARK(neighbours)->Unit(benchmark::kMillisecond);
BENCHMARK(product)->ArgName("viscous")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(diagonal)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace brim
