// How full the space around each particle is, what it sees filled by others, and what pushes back.
#include <algorithm>

#include "brim/body/particle_fluid/particle_fluid_body.h"
#include "brim/body/particle_fluid/particle_slices.h"

namespace brim {

namespace {

constexpr double kSurfaceFill = 0.90, kInsideFill = 0.98;
constexpr double kFullAtSurface = 0.98;
constexpr double kTouching = 0.8;  ///< spacings from a surface up to which a particle is of the layer at it

}  // namespace

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

}  // namespace brim
