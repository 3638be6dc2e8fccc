// Distance queries, distance grids and tetrahedral lattices of generated shapes.
#include <benchmark/benchmark.h>

#include <array>
#include <cstdint>

#include "brim/mesh/distance.h"
#include "brim/mesh/distance_grid.h"
#include "brim/mesh/distance_row.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/tet_lattice.h"

namespace {

using namespace brim;

void distance_grid(benchmark::State& state, SurfaceTreatment treatment) {
  const TriMesh mesh = shapes::blob(1, 0.5, 5);
  DistanceGridOptions o;
  o.spacing = 1.0 / static_cast<double>(state.range(0));
  o.treatment = treatment;
  o.thickness = 0.1;
  std::size_t nodes = 0;
  for (auto _ : state) nodes = make_distance_grid(mesh, o).values().size();
  state.counters["nodes"] = static_cast<double>(nodes);
}
BENCHMARK_CAPTURE(distance_grid, closed, SurfaceTreatment::Closed)->Arg(32)->Arg(64)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(distance_grid, winding, SurfaceTreatment::WindingNumber)->Arg(32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(distance_grid, thickness, SurfaceTreatment::Thickness)->Arg(32)->Unit(benchmark::kMillisecond);

void grid_value(benchmark::State& state, Interpolation interpolation) {
  DistanceGridOptions o;
  o.spacing = 1.0 / 32;
  const DistanceGrid grid = make_distance_grid(shapes::blob(1, 0.5, 4), o);
  int i = 0;
  for (auto _ : state) {
    ++i;
    benchmark::DoNotOptimize(
        grid.value({(i % 97) / 97.0 - 0.5, (i % 89) / 89.0 - 0.5, (i % 83) / 83.0 - 0.5}, interpolation));
  }
}
BENCHMARK_CAPTURE(grid_value, trilinear, Interpolation::Trilinear);
BENCHMARK_CAPTURE(grid_value, tricubic, Interpolation::Tricubic);

/// The same places, 64 at a time.
void grid_values(benchmark::State& state) {
  DistanceGridOptions o;
  o.spacing = 1.0 / 32;
  const DistanceGrid grid = make_distance_grid(shapes::blob(1, 0.5, 4), o);
  std::array<double, 64> x, y, z, d;
  int i = 0;
  for (auto _ : state) {
    for (std::size_t k = 0; k < x.size(); ++k, ++i)
      x[k] = (i % 97) / 97.0 - 0.5, y[k] = (i % 89) / 89.0 - 0.5, z[k] = (i % 83) / 83.0 - 0.5;
    distance_places(grid, x.data(), y.data(), z.data(), static_cast<int>(x.size()), d.data());
    benchmark::DoNotOptimize(d.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(x.size()));
}
BENCHMARK(grid_values);

void lattice(benchmark::State& state) {
  const TriMesh mesh = shapes::blob(1, 0.5, 4);
  std::size_t tets = 0;
  for (auto _ : state) tets = tet_lattice(mesh, 1.0 / static_cast<double>(state.range(0))).tets.size();
  state.counters["tets"] = static_cast<double>(tets);
}
BENCHMARK(lattice)->Arg(10)->Arg(20)->Unit(benchmark::kMillisecond);

void embedding(benchmark::State& state) {
  const TriMesh mesh = shapes::blob(1, 0.5, 5);
  const TetMesh tets = tet_lattice(shapes::blob(1, 0.5, 4), 0.1);
  for (auto _ : state) benchmark::DoNotOptimize(embed(tets, mesh.vertices));
  state.counters["points"] = static_cast<double>(mesh.vertices.size());
}
BENCHMARK(embedding)->Unit(benchmark::kMillisecond);

}  // namespace
