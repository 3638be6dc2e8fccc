#include "brim/body/volume/carried_body.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

CarriedBody::CarriedBody(std::vector<Vec3> nodes, Carriage carriage, LayerWeights weights, CarriedSurface surface,
                         double modulus, ParticleOptions options)
    : ParticleBody(nodes, CarriedVolume::node_masses(carriage, nodes.size()), std::move(options)),
      volume_(std::move(carriage), weights),
      surface_(std::move(surface.weights)) {
  for (std::size_t i = 0; i < mass_.size(); ++i)
    if (!(mass_[i] > 0.0)) throw InputError(fmt::format("body: node {} carries no matter", i));
  const Carriage& c = volume_.carriage();
  for (std::size_t i = 0; i < c.weights.rows(); ++i) {
    double sum = 0.0;
    for (std::int32_t e = c.weights.first[i]; e < c.weights.first[i + 1]; ++e)
      sum += std::abs(c.weights.weight[static_cast<std::size_t>(e)]);
    largest_row_ = std::max(largest_row_, sum);
  }
  volume_.update(rest_);
  const double total = std::accumulate(c.volume.begin(), c.volume.end(), 0.0);
  const double matter = std::accumulate(mass_.begin(), mass_.end(), 0.0);
  const double largest = *std::max_element(c.volume.begin(), c.volume.end());
  const Vec3 extent = volume_.layer().centers().extent() + Vec3::Constant(std::cbrt(largest));
  part_.voxel_size = options_.voxel_size > 0.0 ? options_.voxel_size : std::cbrt(largest);
  part_.areal_mass = immobile() ? 0.0 : matter * extent.maxCoeff() / extent.prod();
  part_.thickness = std::min(extent.minCoeff(), 2.0 * std::cbrt(total));
  part_.width = width_of(total, part_.thickness, volume_.layer().centers());
  part_.modulus = modulus;
  part_.material = options_.material;
  display_.triangles = std::move(surface.triangles);
  display_.vertices = surface_.rows();
}

void CarriedBody::update(double time, std::span<const double> q, std::span<const double> v) {
  ParticleBody::update(time, q, v);
  volume_.update(x_);
}

double CarriedBody::relative_speed_bound(int p, std::span<const double> v) const {
  return largest_row_ * ParticleBody::relative_speed_bound(p, v);
}

void CarriedBody::presence(int, double h, double w, const Aabb& region, std::vector<TileKey>& out) const {
  volume_.layer().presence(h, w, region, out);
}

void CarriedBody::rasterize(int, double h, double w, std::span<const TileKey> tiles,
                            std::span<DensityBlock> out) const {
  volume_.layer().rasterize(h, w, tiles, out);
}

void CarriedBody::make_map(int, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                           std::unique_ptr<Map>& map) const {
  volume_.make_map(particle_count(), points, sources, map);
}

void CarriedBody::display_positions(std::span<Vec3f> x) const { carry(x_, x); }

void CarriedBody::display_velocities(std::span<const double> v, std::span<const Vec3f>, std::span<Vec3f> u) const {
  carry(node_vectors(v), u);
}

void CarriedBody::carry(std::span<const Vec3> nodes, std::span<Vec3f> out) const {
  BRIM_CHECK(out.size(), ==, surface_.rows());
  parallel_for(
      out.size(),
      [&](std::size_t i) {
        Vec3 sum = Vec3::Zero();
        for (std::int32_t e = surface_.first[i]; e < surface_.first[i + 1]; ++e)
          sum += surface_.weight[static_cast<std::size_t>(e)] *
                 nodes[static_cast<std::size_t>(surface_.source[static_cast<std::size_t>(e)])];
        out[i] = sum.cast<float>();
      },
      1024);
}

void CarriedBody::show_nodes(std::span<const double> value, std::span<float> out) const {
  BRIM_CHECK(out.size(), ==, surface_.rows());
  for (std::size_t i = 0; i < out.size(); ++i) {
    double sum = 0.0;
    for (std::int32_t e = surface_.first[i]; e < surface_.first[i + 1]; ++e)
      sum += surface_.weight[static_cast<std::size_t>(e)] *
             value[static_cast<std::size_t>(surface_.source[static_cast<std::size_t>(e)])];
    out[i] = static_cast<float>(sum);
  }
}

}  // namespace brim
