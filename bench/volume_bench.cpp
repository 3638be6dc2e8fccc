// Cost of raw volumes and the volume layer: nodes of a rigid image against a sampled distance, particles spread to the
// grid, weights of contact points, samples of a meshless body.

#include <benchmark/benchmark.h>

#include "brim/body/meshless/meshless_body.h"
#include "brim/core/parallel.h"
#include "brim/raster/grid_shape.h"
#include "brim/raster/image_shape.h"
#include "brim/raster/volume_layer.h"

namespace brim {
namespace {

constexpr double kR = 0.5, kH = 1.0 / 32.0, kW = 3 * kH;

double ball(const Vec3& x) { return x.norm() - kR; }

std::vector<TileKey> tiles_near_surface() {
  std::vector<TileKey> tiles;
  const TileRange r = tiles_meeting({Vec3::Constant(-0.6), Vec3::Constant(0.6)}, kH);
  for (int z = r.lo.z; z <= r.hi.z; ++z)
    for (int y = r.lo.y; y <= r.hi.y; ++y)
      for (int x = r.lo.x; x <= r.hi.x; ++x)
        if (std::abs(ball(tile_box({x, y, z}, kH).center())) < 0.1) tiles.push_back({x, y, z});
  return tiles;
}

void fill(benchmark::State& state, const Shape& shape) {
  ThreadLimit one(1);
  const auto tiles = tiles_near_surface();
  std::vector<DensityBlock> blocks(tiles.size());
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(0.3, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  for (auto _ : state)
    for (std::size_t t = 0; t < tiles.size(); ++t) shape.fill(pose, tiles[t], kH, kW, blocks[t]);
  state.counters["s_per_node"] =
      benchmark::Counter(static_cast<double>(tiles.size()) * kBlockNodes * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

OccupancyGrid occupancy() {
  VoxelImage image;
  image.size = Vec3i::Constant(72);
  image.axes = 0.5 * kH * Mat3::Identity();
  image.origin = Vec3::Constant(-0.25 * kH * 71);
  for (int k = 0; k < 72; ++k)
    for (int j = 0; j < 72; ++j)
      for (int i = 0; i < 72; ++i)
        image.values.push_back(
            static_cast<float>(std::clamp(0.5 - ball(image.origin + 0.5 * kH * Vec3(i, j, k)) / (0.5 * kH), 0.0, 1.0)));
  return sample_occupancy(image, {0, 1}, 0.5 * kH);
}

void fill_image(benchmark::State& state) { fill(state, *make_image_shape(occupancy(), 1.0)); }
void fill_distance_grid(benchmark::State& state) {
  const Vec3 half = Vec3::Constant(0.6);
  fill(state,
       *make_grid_shape(std::make_shared<const DistanceGrid>(sample_distance({-half, half}, 0.5 * kH, ball)), 1.0));
}

struct Layer {
  std::vector<Vec3> x;
  std::vector<double> volume, radius{0.0};
  VolumeLayer layer;
  Layer() {
    const int n = static_cast<int>(kR / kH) + 1;
    for (int k = -n; k <= n; ++k)
      for (int j = -n; j <= n; ++j)
        for (int i = -n; i <= n; ++i)
          if (ball(kH * Vec3(i, j, k)) < 0) x.push_back(kH * Vec3(i, j, k)), volume.push_back(kH * kH * kH);
    layer.set(x, volume, volume, radius);
  }
};

void spread_particles(benchmark::State& state) {
  ThreadLimit one(1);
  const Layer l;
  const auto tiles = tiles_near_surface();
  std::vector<DensityBlock> blocks(tiles.size());
  for (auto _ : state) l.layer.rasterize(kH, kW, tiles, blocks);
  state.counters["s_per_node"] =
      benchmark::Counter(static_cast<double>(tiles.size()) * kBlockNodes * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void weights_of_points(benchmark::State& state) {
  ThreadLimit one(1);
  const Layer l;
  const auto tiles = tiles_near_surface();
  std::vector<DensityBlock> blocks(tiles.size());
  l.layer.rasterize(kH, kW, tiles, blocks);
  std::vector<Vec3> points;
  std::vector<std::int32_t> sources;
  for (std::size_t t = 0; t < tiles.size(); ++t)
    for (int n = 0; n < kBlockNodes; n += 7)
      if (blocks[t].rho[n] > 0.1 && blocks[t].rho[n] < 0.9) {
        points.push_back(block_origin(tiles[t], kH) +
                         kH * Vec3(n % kBlockSize, n / kBlockSize % kBlockSize, n / kBlockSize / kBlockSize));
        sources.push_back(blocks[t].source[n]);
      }
  const auto kind = static_cast<LayerWeights>(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(l.layer.weights(points, sources, kind));
  state.counters["s_per_point"] =
      benchmark::Counter(static_cast<double>(points.size()) * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void meshless_update(benchmark::State& state) {
  ThreadLimit one(1);
  const Vec3 half = Vec3::Constant(0.5);
  const auto box = [](const Vec3& x) { return x.cwiseAbs().maxCoeff() - 0.5; };
  const MeshlessModel m = fill_with_frames(box, {-half, half}, 0.125, 0.0625);
  MeshlessBody body(m, Quat::Identity(), Vec3::Zero(), {});
  std::vector<double> q(body.q_size()), v(body.v_size());
  body.initial_state(q, v);
  for (auto _ : state) body.update(0.0, q, v);
  state.counters["s_per_sample"] =
      benchmark::Counter(static_cast<double>(body.elements().size()) * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

BENCHMARK(fill_image);
BENCHMARK(fill_distance_grid);
BENCHMARK(spread_particles);
BENCHMARK(weights_of_points)->Arg(0)->Arg(1)->Arg(2);
BENCHMARK(meshless_update);

}  // namespace
}  // namespace brim
