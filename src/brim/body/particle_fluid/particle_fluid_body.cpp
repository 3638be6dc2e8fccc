#include "brim/body/particle_fluid/particle_fluid_body.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "brim/body/particle_fluid/particle_slices.h"
#include "brim/body/particles/loose_clusters.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

constexpr double kSupport = 2.0;  ///< H over the spacing

void require(const char* name, double value, bool good, const char* allowed) {
  if (!good || !std::isfinite(value))
    throw InputError(fmt::format("particle fluid: {} is {}; it must be {}", name, value, allowed));
}

/// Σ W over a cubic lattice of unit spacing: V is chosen so that the lattice fills space.
double lattice_sum(const FluidKernel& kernel, double spacing) {
  double sum = 0.0;
  const int n = static_cast<int>(kSupport) + 1;
  for (int z = -n; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) sum += kernel.value(spacing * std::sqrt(double(x * x + y * y + z * z)));
  return sum;
}

}  // namespace

ParticleFluidBody::ParticleFluidBody(std::vector<Vec3> x, ParticleFluidOptions options)
    : start_(std::move(x)),
      options_(std::move(options)),
      kernel_(kSupport * options_.spacing),
      cohesion_(kernel_.support(), options_.spacing, options_.surface_tension),
      volume_(1.0 / lattice_sum(kernel_, options_.spacing)),
      contact_(kernel_, volume_),
      images_(kernel_, options_.spacing, volume_) {
  const ParticleFluidOptions& o = options_;
  require("spacing [m]", o.spacing, o.spacing > 0.0, "positive");
  require("density [kg/m³]", o.density, o.density > 0.0, "positive");
  require("viscosity [Pa s]", o.viscosity, o.viscosity >= 0.0, "zero or positive");
  require("surface tension [N/m]", o.surface_tension, o.surface_tension >= 0.0, "zero or positive");
  require("bulk modulus [Pa]", o.bulk_modulus, o.bulk_modulus >= 0.0, "zero (automatic) or positive");
  require("compression", o.compression, o.compression > 0.0 && o.compression <= 0.1, "above 0 and at most 0.1");
  require("voxel size [m]", o.voxel_size, o.voxel_size >= 0.0 && o.voxel_size <= o.spacing * (1 + 1e-9),
          "at most the spacing: a coarser grid leaks");
  if (start_.empty()) throw InputError("particle fluid: there are no particles");
  Aabb box;
  for (const Vec3& p : start_) {
    if (!p.allFinite()) throw InputError("particle fluid: a particle's position is not finite");
    box.extend(p);
  }
  particle_mass_ = o.density * o.spacing * o.spacing * o.spacing;
  const Vec3 extent = box.extent() + Vec3::Constant(o.spacing);
  bulk_modulus_ = o.bulk_modulus;
  if (bulk_modulus_ == 0.0) {
    const double speed2 = o.initial_velocity.squaredNorm();
    bulk_modulus_ = o.density * (o.gravity.norm() * extent.norm() + speed2) / o.compression;
    if (bulk_modulus_ == 0.0) bulk_modulus_ = o.density / o.compression;
  }
  const double g = o.gravity.norm();
  const Vec3 down = g > 0.0 ? Vec3(o.gravity / g) : Vec3(0, 0, -1);
  part_.voxel_size = o.voxel_size > 0.0 ? o.voxel_size : 0.5 * o.spacing;
  part_.areal_mass = o.density * down.cwiseAbs().dot(extent);
  part_.modulus = bulk_modulus_;
  part_.conforming = true;
  part_.material = o.material;
  display_.kind = Display::Kind::Points;
  display_.vertices = start_.size();
  display_.radius = 0.5 * o.spacing;
  x_.reserve(start_.size());
}

void ParticleFluidBody::initial_state(std::span<double> q, std::span<double> v) const {
  Vec3 center = Vec3::Zero();
  for (const Vec3& x : start_) center += x / static_cast<double>(start_.size());
  for (std::size_t i = 0; i < start_.size(); ++i) {
    particle_at(q, i) = start_[i];
    particle_at(v, i) = options_.initial_velocity + options_.initial_spin.cross(start_[i] - center);
  }
}

void ParticleFluidBody::update(double, std::span<const double> q, std::span<const double> v) {
  BRIM_CHECK(q.size(), ==, q_size());
  BRIM_CHECK(v.size(), ==, v_size());
  v_.assign(v.begin(), v.end());
  // The end of a step and the start of the next are the same place.
  if (x_.size() == start_.size() && std::equal(q.begin(), q.end(), x_.front().data())) {
    contact_.forget_nodes();
    return;
  }
  x_.resize(start_.size());
  std::copy(q.begin(), q.end(), x_.front().data());
  cells_.build(x_, kernel_.support());
  pairs_.build(cells_, kernel_, volume_, options_.viscosity);
  slot_.resize(x_.size());
  for (std::size_t k = 0; k < x_.size(); ++k) slot_[cells_.order()[k]] = static_cast<std::int32_t>(k);
  seen_.clear();
  judge_fill();
  contact_.begin(cells_, pairs_.fill());
}

void ParticleFluidBody::advance(double dt, std::span<double> q, std::span<const double> v) const {
  parallel_blocks(q.size(), 4 * kParticleGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) q[i] += dt * v[i];
  });
}

Aabb ParticleFluidBody::bounds(int) const {
  Aabb box;
  for (const Vec3& x : x_) box.extend(x);
  return box.inflated(0.5 * options_.spacing);
}

Vec3 ParticleFluidBody::mean_velocity(int, std::span<const double> v) const { return linear_momentum(v) / mass(); }

double ParticleFluidBody::relative_speed_bound(int, std::span<const double> v) const {
  const Vec3 mean = mean_velocity(0, v);
  double largest = 0.0;
  for (std::size_t i = 0; i < start_.size(); ++i) largest = std::max(largest, (particle_at(v, i) - mean).squaredNorm());
  return std::sqrt(largest);
}

void ParticleFluidBody::motion_clusters(int, std::span<const double> v, std::vector<MotionCluster>& out) const {
  measure_cells(cells_, x_, v, 0.5 * options_.spacing, out);
}

void ParticleFluidBody::finer_clusters(int, std::size_t cluster, std::span<const double> v,
                                       std::vector<MotionCluster>& out) const {
  measure_cell(cells_, cluster, x_, v, 0.5 * options_.spacing, out);
}

void ParticleFluidBody::presence(int, double h, double, const Aabb& region, std::vector<TileKey>& out) const {
  contact_.presence(h, region, out);
}

void ParticleFluidBody::rasterize(int, double h, double, std::span<const TileKey> tiles,
                                  std::span<DensityBlock> out) const {
  contact_.rasterize(h, tiles, out);
}

void ParticleFluidBody::make_map(int, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                                 std::unique_ptr<Map>& map) const {
  BRIM_CHECK(points.size(), ==, sources.size());
  auto* weights = dynamic_cast<FluidMap*>(map.get());
  if (weights == nullptr) {
    auto made = std::make_unique<FluidMap>();
    weights = made.get();
    map = std::move(made);
  }
  contact_.make_map(sources, *weights);
}

std::int32_t ParticleFluidBody::nearest_node(const Vec3& x) const {
  const double reach = kernel_.support();
  std::pair<double, std::int32_t> best = {std::numeric_limits<double>::infinity(), 0};
  const auto take = [&](std::int32_t particle) {
    best = std::min(best, {(x_[static_cast<std::size_t>(particle)] - x).squaredNorm(), particle});
  };
  cells_.near(x, reach, [&](std::int32_t first, std::int32_t last) {
    for (std::int32_t k = first; k < last; ++k) take(cells_.order()[static_cast<std::size_t>(k)]);
  });
  if (best.first <= reach * reach) return best.second;
  for (std::size_t i = 0; i < x_.size(); ++i) take(static_cast<std::int32_t>(i));
  return best.second;
}

double ParticleFluidBody::potential_energy(const Environment& env) const {
  double e = 0.0;
  for (const double fill : fill_) e += 0.5 * fill_energy() * std::max(0.0, fill - 1.0) * std::max(0.0, fill - 1.0);
  for (const Vec3& x : x_) e -= particle_mass_ * env.gravity.dot(x);
  if (cohesion_.acts()) e += cohesion_.energy(cells_.positions(), pairs_);
  return e;
}

Vec3 ParticleFluidBody::linear_momentum(std::span<const double> v) const {
  Vec3 p = Vec3::Zero();
  for (std::size_t i = 0; i < start_.size(); ++i) p += particle_at(v, i);
  return particle_mass_ * p;
}

Vec3 ParticleFluidBody::angular_momentum(std::span<const double> v) const {
  Vec3 l = Vec3::Zero();
  for (std::size_t i = 0; i < start_.size(); ++i) l += x_[i].cross(particle_at(v, i));
  return particle_mass_ * l;
}

bool ParticleFluidBody::rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const {
  parallel_blocks(x_.size(), kParticleGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) particle_at(v, i) = t + w.cross(x_[i]);
  });
  return true;
}

void ParticleFluidBody::display_positions(std::span<Vec3f> x) const {
  BRIM_CHECK(x.size(), ==, start_.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = x_[i].cast<float>();
}

std::vector<double> ParticleFluidBody::fill() const {
  std::vector<double> out(start_.size());
  for (std::size_t k = 0; k < out.size(); ++k) out[cells_.order()[k]] = fill_[k];
  return out;
}

std::vector<double> ParticleFluidBody::pressure() const {
  std::vector<double> out = fill();
  for (double& p : out) p = bulk_modulus_ * std::max(0.0, p - 1.0);
  return out;
}

}  // namespace brim
