// Cost of elastic bodies: update (forces and stiffness), the product of the implicit step, density, presence, map.

#include <benchmark/benchmark.h>

#include "brim/body/cloth/cloth_body.h"
#include "brim/body/fem/fem_body.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/tet_lattice.h"

namespace brim {
namespace {

/// A ball of about 80 000 tetrahedra, slightly deformed.
struct Ball {
  std::unique_ptr<FemBody> body;
  std::vector<double> q, v;
  explicit Ball(ElasticLaw law, double spacing = 0.087) {
    FemOptions o;
    o.law = law;
    body = std::make_unique<FemBody>(tet_lattice([](const Vec3& p) { return p.norm() - 1.0; },
                                                 Aabb{Vec3::Constant(-1.2), Vec3::Constant(1.2)}, spacing),
                                     o);
    q.resize(body->q_size());
    v.resize(body->v_size());
    body->initial_state(q, v);
    for (std::size_t i = 0; i < q.size(); i += 3) q[i] += 0.1 * q[i + 1] * q[i + 2];
    body->update(0.0, q, v);
    body->begin_solve(0.01);
  }
};

void update(benchmark::State& state) {
  Ball b(state.range(0) == 0 ? ElasticLaw::CorotationalLinear : ElasticLaw::StableNeoHookean);
  for (auto _ : state) b.body->update(0.0, b.q, b.v);
  state.counters["tets"] = static_cast<double>(b.body->elements().size());
  state.counters["s_per_tet"] = benchmark::Counter(state.counters["tets"] * static_cast<double>(state.iterations()),
                                                   benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(update)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->UseRealTime();

void apply_system(benchmark::State& state) {
  Ball b(ElasticLaw::CorotationalLinear);
  std::vector<double> y(b.q.size(), 0.0);
  for (auto _ : state) b.body->apply_system(b.q, y);
  state.counters["nodes"] = static_cast<double>(b.body->particle_count());
  state.counters["blocks"] = static_cast<double>(b.body->stiffness().block_count());
  state.counters["bytes"] = benchmark::Counter(
      76.0 * state.counters["blocks"] * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(apply_system)->Unit(benchmark::kMillisecond)->UseRealTime();

void raster(benchmark::State& state) {
  Ball b(ElasticLaw::CorotationalLinear);
  const double h = b.body->part(0).voxel_size, w = 3 * h;
  std::vector<TileKey> tiles;
  b.body->presence(0, h, w, b.body->bounds(0).inflated(1.0), tiles);
  std::vector<DensityBlock> out(tiles.size());
  for (auto _ : state) b.body->rasterize(0, h, w, tiles, out);
  state.counters["tiles"] = static_cast<double>(tiles.size());
  state.counters["s_per_tet"] =
      benchmark::Counter(static_cast<double>(b.body->elements().size()) * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["s_per_tile"] = benchmark::Counter(static_cast<double>(tiles.size() * state.iterations()),
                                                    benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(raster)->Unit(benchmark::kMillisecond)->UseRealTime();

void raster_surface_tiles(benchmark::State& state) {
  // Only tiles about one pole, as when another body touches there.
  Ball b(ElasticLaw::CorotationalLinear);
  const double h = b.body->part(0).voxel_size, w = 3 * h;
  std::vector<TileKey> tiles;
  b.body->presence(0, h, w, Aabb{Vec3(-0.4, -0.4, 0.8), Vec3(0.4, 0.4, 1.2)}, tiles);
  std::vector<DensityBlock> out(tiles.size());
  for (auto _ : state) b.body->rasterize(0, h, w, tiles, out);
  state.counters["tiles"] = static_cast<double>(tiles.size());
}
BENCHMARK(raster_surface_tiles)->Unit(benchmark::kMillisecond)->UseRealTime();

void presence(benchmark::State& state) {
  Ball b(ElasticLaw::CorotationalLinear);
  const double h = b.body->part(0).voxel_size;
  std::vector<TileKey> tiles;
  for (auto _ : state) {
    tiles.clear();
    b.body->presence(0, h, 3 * h, b.body->bounds(0), tiles);
  }
  state.counters["tiles"] = static_cast<double>(tiles.size());
}
BENCHMARK(presence)->Unit(benchmark::kMillisecond)->UseRealTime();

struct Sheet {
  std::unique_ptr<ClothBody> body;
  std::vector<double> q, v;
  Sheet() {
    ClothOptions o;
    o.thickness = 0.02;
    body = std::make_unique<ClothBody>(shapes::grid(100, 100, 2, 2), o);
    q.resize(body->q_size());
    v.resize(body->v_size());
    body->initial_state(q, v);
    for (std::size_t i = 0; i < q.size(); i += 3) q[i + 2] += 0.2 * std::sin(3 * q[i]) * std::cos(2 * q[i + 1]);
    body->update(0.0, q, v);
  }
};

void cloth_update(benchmark::State& state) {
  Sheet s;
  for (auto _ : state) s.body->update(0.0, s.q, s.v);
  state.counters["triangles"] = static_cast<double>(s.body->membrane().size());
}
BENCHMARK(cloth_update)->Unit(benchmark::kMillisecond)->UseRealTime();

void cloth_raster(benchmark::State& state) {
  Sheet s;
  const double h = s.body->part(0).voxel_size, w = 3 * h;
  std::vector<TileKey> tiles;
  s.body->presence(0, h, w, s.body->bounds(0).inflated(1.0), tiles);
  std::vector<DensityBlock> out(tiles.size());
  for (auto _ : state) s.body->rasterize(0, h, w, tiles, out);
  state.counters["tiles"] = static_cast<double>(tiles.size());
}
BENCHMARK(cloth_raster)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace brim
