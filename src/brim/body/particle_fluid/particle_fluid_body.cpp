#include "brim/body/particle_fluid/particle_fluid_body.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

constexpr double kSupport = 2.0;  ///< H over the spacing
constexpr double kSurfaceFill = 0.90, kInsideFill = 0.98;
constexpr double kFullAtSurface = 0.98;
constexpr double kTouching = 0.8;  ///< spacings from a surface up to which a particle is of the layer at it
constexpr std::size_t kParticleGrain = 1024;

void require(const char* name, double value, bool good, const char* allowed) {
  if (!good || !std::isfinite(value))
    throw InputError(fmt::format("particle fluid: {} is {}; it must be {}", name, value, allowed));
}

Eigen::Map<const Vec3> particle_at(std::span<const double> a, std::size_t i) {
  return Eigen::Map<const Vec3>(a.data() + 3 * i);
}
Eigen::Map<Vec3> particle_at(std::span<double> a, std::size_t i) { return Eigen::Map<Vec3>(a.data() + 3 * i); }

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

std::vector<Vec3> lattice_in_box(const Vec3& lo, const Vec3& hi, double spacing) {
  const Vec3 n = ((hi - lo) / spacing).array().round().max(0.0);
  std::vector<Vec3> x;
  for (int k = 0; k < static_cast<int>(n.z()); ++k)
    for (int j = 0; j < static_cast<int>(n.y()); ++j)
      for (int i = 0; i < static_cast<int>(n.x()); ++i) x.push_back(lo + spacing * Vec3(i + 0.5, j + 0.5, k + 0.5));
  return x;
}

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

void ParticleFluidBody::see(std::span<const Seen> seen) {
  seen_.assign(seen.begin(), seen.end());
  judge_fill();
}

void ParticleFluidBody::judge_fill() {
  fill_.assign(pairs_.fill().begin(), pairs_.fill().end());
  images_.build(seen_, slot_, cells_, pairs_, fill_);
  inside_.resize(x_.size()), excess_.resize(x_.size());
  for (std::size_t i = 0; i < inside_.size(); ++i) {
    const double t = std::clamp((fill_[i] - kSurfaceFill) / (kInsideFill - kSurfaceFill), 0.0, 1.0);
    inside_[i] = static_cast<float>(t * t * (3.0 - 2.0 * t));
    excess_[i] = std::max(0.0, fill_[i] - 1.0);
  }
}

void ParticleFluidBody::foresee(double dt, std::span<const double> v, std::span<const double> rate) {
  images_.for_seeing([&](std::size_t i) {
    double nearest = fill_reach();
    for (const std::int32_t k : images_.contacts_of(i)) nearest = std::min(nearest, seen_[k].distance);
    if (nearest > kTouching * options_.spacing) return;
    double closing = images_.rate_of(i, rate);
    const Vec3 own = particle_at(v, cells_.order()[i]);
    pairs_.for_neighbours(i, [&](std::int32_t j, const Vec4& g) {
      closing += (own - particle_at(v, cells_.order()[j])).dot(g.head<3>().matrix().cast<double>());
    });
    // A surface pushes and does not pull: only what is full or will be by the end of the step is kept from changing.
    const double after = std::max(excess_[i] > 0.0 ? 1.0 : 0.0, fill_[i] + dt * closing);
    const double t = std::clamp((after - kFullAtSurface) / (1.0 - kFullAtSurface), 0.0, 1.0);
    inside_[i] = static_cast<float>(t * t * (3.0 - 2.0 * t));
    // What is not full yet may close up to there.
    if (after > 1.0) excess_[i] = fill_[i] - 1.0;
  });
}

void ParticleFluidBody::press(std::span<double> push) const {
  auto p = products_.borrow();
  p->pressure.resize(excess_.size());
  for (std::size_t i = 0; i < excess_.size(); ++i) p->pressure[i] = static_cast<float>(fill_energy() * excess_[i]);
  images_.press(p->pressure, push);
}

double ParticleFluidBody::fill_stiffness(std::size_t k, double dt) const {
  return dt * dt * fill_energy() * images_.stiffness(k, inside_);
}

double ParticleFluidBody::fill_drag(std::size_t k) const {
  // The layer at the surface, spacing² of it, over half a spacing of fluid that is sheared.
  const double s = options_.spacing, away = seen_[k].distance / s - 0.5;
  return 2.0 * options_.viscosity * s * std::clamp(1.0 - away / (kTouching - 0.5), 0.0, 1.0);
}

void ParticleFluidBody::apply_stiffness_seeing(std::span<const double> x, std::span<const double> rate,
                                               std::span<double> y, std::span<double> change) const {
  multiply(-1.0, 0.0, x, y, rate, change);
  for (double& c : change) c = -c;
}

void ParticleFluidBody::apply_system_seeing(std::span<const double> x, std::span<const double> rate,
                                            std::span<double> y, std::span<double> change) const {
  apply_mass(x, y);
  multiply(dt_ * dt_, dt_, x, y, rate, change);
}

void ParticleFluidBody::advance(double dt, std::span<double> q, std::span<const double> v) const {
  parallel_blocks(q.size(), 4 * kParticleGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) q[i] += dt * v[i];
  });
}

void ParticleFluidBody::gather(std::span<const double> x, Product& p) const {
  const auto order = cells_.order();
  p.v.resize(order.size()), p.rate.resize(order.size()), p.pressure.resize(order.size());
  p.y.resize(order.size());
  parallel_blocks(order.size(), kParticleGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      p.y[k].setZero();
      const double* s = x.data() + 3 * order[k];
      p.v[k] = Vec4(static_cast<float>(s[0]), static_cast<float>(s[1]), static_cast<float>(s[2]), 0.0f);
    }
  });
}

void ParticleFluidBody::scatter(const Product& p, double scale, std::span<double> y) const {
  const auto order = cells_.order();
  parallel_blocks(order.size(), kParticleGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) particle_at(y, order[k]) += scale * p.y[k];
  });
}

void ParticleFluidBody::multiply(double pressure_factor, double viscous_factor, std::span<const double> x,
                                 std::span<double> y, std::span<const double> rate, std::span<double> change) const {
  auto p = products_.borrow();
  gather(x, *p);
  const bool viscous = viscous_factor != 0.0 && options_.viscosity > 0.0;
  if (viscous) pairs_.add_viscosity(viscous_factor, p->v, p->rate, p->y);
  if (pressure_factor != 0.0) {
    if (!viscous) pairs_.rates(p->v, inside_, p->rate);
    if (!rate.empty()) images_.add_rates(rate, p->rate);
    const double energy = pressure_factor * fill_energy();
    parallel_blocks(p->rate.size(), 4 * kParticleGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) p->pressure[i] = static_cast<float>(energy * inside_[i]) * p->rate[i];
    });
    if (!change.empty()) images_.press(p->pressure, change);
    pairs_.add_pressure(p->pressure, p->y);
  }
  scatter(*p, 1.0, y);
}

void ParticleFluidBody::add_forces(const Environment& env, std::span<double> Q) const {
  auto p = products_.borrow();
  gather(v_, *p);
  for (std::size_t i = 0; i < fill_.size(); ++i) p->pressure[i] = static_cast<float>(-fill_energy() * excess_[i]);
  pairs_.add_pressure(p->pressure, p->y);
  if (options_.viscosity > 0.0) pairs_.add_viscosity(-1.0, p->v, p->y);
  if (cohesion_.acts()) cohesion_.add_forces(cells_.positions(), pairs_, p->y);
  for (Vec3& f : p->y) f += particle_mass_ * env.gravity;
  scatter(*p, 1.0, Q);
  add_outer_forces(Q);
}

void ParticleFluidBody::apply_mass(std::span<const double> x, std::span<double> y) const {
  parallel_blocks(x.size(), 4 * kParticleGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) y[i] += particle_mass_ * x[i];
  });
}

void ParticleFluidBody::apply_stiffness(std::span<const double> x, std::span<double> y) const {
  multiply(-1.0, 0.0, x, y);
}

void ParticleFluidBody::apply_damping(std::span<const double> x, std::span<double> y) const {
  multiply(0.0, -1.0, x, y);
}

void ParticleFluidBody::apply_system(std::span<const double> x, std::span<double> y) const {
  apply_mass(x, y);
  multiply(dt_ * dt_, dt_, x, y);
}

void ParticleFluidBody::add_system_diagonal(std::size_t first, BlockDiagonal& D) const {
  const auto order = cells_.order();
  const float kappa = static_cast<float>(dt_ * dt_ * fill_energy());
  parallel_blocks(order.size(), kParticleGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<Eigen::Vector3f> by_images;
    for (std::size_t i = begin; i < end; ++i) {
      Eigen::Vector3f own = Eigen::Vector3f::Zero();
      Eigen::Matrix3f others = Eigen::Matrix3f::Zero();
      by_images.clear();
      for (const std::int32_t k : images_.contacts_of(i)) {
        const Eigen::Vector3f n = seen_[k].n.cast<float>();
        images_.for_slopes(static_cast<std::size_t>(k), [&](std::int32_t pair, double slope) {
          const Eigen::Vector3f g = static_cast<float>(slope) * n;
          if (pair < 0) {
            own += g;
          } else {
            if (by_images.size() <= static_cast<std::size_t>(pair)) by_images.resize(pair + 1, Eigen::Vector3f::Zero());
            by_images[pair] += g;
          }
        });
        // What contact adds itself of each thing seen is left out.
        others -=
            (kappa * static_cast<float>(images_.stiffness(static_cast<std::size_t>(k), inside_))) * n * n.transpose();
      }
      std::size_t pair = 0;
      pairs_.for_neighbours(i, [&](std::int32_t j, const Vec4& e) {
        const Eigen::Vector3f g = e.head<3>().matrix();
        own += g;
        others += (static_cast<float>(dt_) * e[3]) * g * g.transpose();
        const Eigen::Vector3f there = pair < by_images.size() ? Eigen::Vector3f(g + by_images[pair]) : g;
        others += (kappa * inside_[j]) * there * there.transpose();
        ++pair;
      });
      others += (kappa * inside_[i]) * own * own.transpose();
      D.block(first + order[i]) += particle_mass_ * Mat3::Identity() + others.cast<double>();
    }
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
