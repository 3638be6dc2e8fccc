// Forces of a particle fluid and the products with its matrices: over pairs of particles, in single precision.
#include "brim/body/particle_fluid/particle_fluid_body.h"
#include "brim/body/particle_fluid/particle_slices.h"
#include "brim/core/parallel.h"

namespace brim {

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

}  // namespace brim
