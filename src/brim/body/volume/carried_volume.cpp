#include "brim/body/volume/carried_volume.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/map/rows_map.h"

namespace brim {

namespace {
/// Volume ratios beyond these, of matter crushed or turned inside out, count as these.
constexpr double kLeastRatio = 0.1, kMostRatio = 10.0;
/// A corner on which hardly any matter weighs still needs a motion of its own: this share of the mean.
constexpr double kLeastMass = 1e-3;
}  // namespace

CarriedVolume::CarriedVolume(Carriage carriage, LayerWeights kind) : carriage_(std::move(carriage)), kind_(kind) {
  const std::size_t n = carriage_.weights.rows();
  BRIM_CHECK(carriage_.volume.size(), ==, n);
  BRIM_CHECK(carriage_.mass.size(), ==, n);
  BRIM_CHECK(carriage_.gradient.size(), ==, carriage_.weights.source.size());
  for (const double v : carriage_.volume) spacing_ = std::max(spacing_, std::cbrt(v));
  x_.resize(n), volume_.resize(n);
  // Cells that a face cuts lie as far apart as whole ones: with radii by their own volumes, what the sum of kernels of
  // different radii tells is no distance.
  radius_ = {std::max(carriage_.radius, VolumeLayer::kLeastSpacings * spacing_)};
}

void CarriedVolume::update(std::span<const Vec3> nodes) {
  const WeightRows& w = carriage_.weights;
  parallel_for(
      x_.size(),
      [&](std::size_t i) {
        Vec3 x = Vec3::Zero();
        Mat3 F = Mat3::Zero();
        for (std::int32_t e = w.first[i]; e < w.first[i + 1]; ++e) {
          const Vec3& q = nodes[static_cast<std::size_t>(w.source[e])];
          x += w.weight[e] * q;
          F += q * carriage_.gradient[static_cast<std::size_t>(e)].transpose();
        }
        x_[i] = x;
        volume_[i] = carriage_.volume[i] * std::clamp(F.determinant(), kLeastRatio, kMostRatio);
      },
      1024);
  layer_.set(x_, volume_, carriage_.mass, radius_);
}

void CarriedVolume::make_map(std::size_t nodes, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                             std::unique_ptr<Map>& map) const {
  auto* rows = dynamic_cast<RowsMap*>(map.get());
  if (rows == nullptr) {
    auto made = std::make_unique<RowsMap>();
    rows = made.get();
    map = std::move(made);
  }
  rows->assign(nodes, compose(layer_.weights(points, sources, kind_), carriage_.weights));
}

std::vector<double> CarriedVolume::node_masses(const Carriage& carriage, std::size_t nodes) {
  std::vector<double> mass(nodes, 0.0);
  for (std::size_t i = 0; i < carriage.weights.rows(); ++i)
    for (std::int32_t e = carriage.weights.first[i]; e < carriage.weights.first[i + 1]; ++e)
      mass[static_cast<std::size_t>(carriage.weights.source[e])] += carriage.mass[i] * carriage.weights.weight[e];
  double mean = 0.0;
  for (const double m : mass) mean += m / static_cast<double>(nodes);
  for (double& m : mass) m = std::max(m, kLeastMass * mean);
  return mass;
}

}  // namespace brim
