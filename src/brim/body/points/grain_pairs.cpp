#include "brim/body/points/grain_pairs.h"

#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"

namespace brim {

namespace {
constexpr std::size_t kPairBlock = 512;
}

Mat3 GrainPairs::Contact::matrix(double a, double b) const {
  const double across = b * drag;
  return across * Mat3::Identity() + (a * k + b * damper - across) * normal * normal.transpose();
}

Vec3 GrainPairs::Contact::times(double a, double b, const Vec3& d) const {
  const double across = b * drag;
  return across * d + (a * k + b * damper - across) * normal.dot(d) * normal;
}

void GrainPairs::find(std::span<const Vec3> x, std::span<const double> radius, double gap) {
  gap_ = gap;
  pair_ = search_.find(x, radius, gap);
  first_.assign(x.size() + 1, 0);
  for (const auto& p : pair_) ++first_[p.a + 1], ++first_[p.b + 1];
  for (std::size_t i = 0; i < x.size(); ++i) first_[i + 1] += first_[i];
  side_.resize(2 * pair_.size());
  for (std::size_t p = 0; p < pair_.size(); ++p) {
    side_[first_[pair_[p].a]++] = {pair_[p].b, static_cast<std::int32_t>(p)};
    side_[first_[pair_[p].b]++] = {pair_[p].a, static_cast<std::int32_t>(p)};
  }
  for (std::size_t i = x.size(); i > 0; --i) first_[i] = first_[i - 1];
  first_[0] = 0;
}

GrainPairs::Contact GrainPairs::contact(const NeighbourSearch::Pair& p, std::span<const Vec3> x,
                                        std::span<const Vec3> v, std::span<const double> radius,
                                        std::span<const double> mass, const GrainMaterial& m, double dt) const {
  Contact c;
  const double ra = radius[p.a], rb = radius[p.b];
  const Vec3 d = x[p.a] - x[p.b], u = v[p.a] - v[p.b];
  const double distance = d.norm(), overlap = ra + rb - distance;
  c.normal = distance > 0.0 ? Vec3(d / distance) : Vec3::UnitZ();
  const double k = 2.0 * m.young * ra * rb / (ra + rb);
  const double closing = -c.normal.dot(u);
  const double inverse_mass = 1.0 / mass[p.a] + 1.0 / mass[p.b];
  if (overlap > 0.0) c.energy = 0.5 * k * overlap * overlap;
  if (dt == 0.0) {
    if (overlap <= 0.0) return c;
    c.k = k;
    c.force = k * overlap * c.normal;
    return c;
  }
  const double b = overlap > 0.0 ? m.damping : 0.0;
  // What would drive a touching pair together in this step without its spring: at rest, as much as the spring holds.
  const double drive = overlap > 0.0 ? dt * (m.gravity + k * overlap * inverse_mass) : 0.0;
  if (!(overlap + (dt + b) * (closing + drive) > 0.0)) return c;
  c.k = k;
  c.damper = b * k;
  const double push = k * (overlap + b * closing);
  c.force = push * c.normal;
  if (overlap > 0.0 && push > 0.0) {
    const Vec3 slip = u + closing * c.normal;
    c.drag = m.friction * push / std::max(slip.norm(), m.slip_speed);
    c.force -= c.drag * slip;
  }
  return c;
}

void GrainPairs::evaluate(std::span<const Vec3> x, std::span<const Vec3> v, std::span<const double> radius,
                          std::span<const double> mass, const GrainMaterial& material, double dt) {
  contact_.resize(pair_.size());
  parallel_blocks(pair_.size(), kPairBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) contact_[p] = contact(pair_[p], x, v, radius, mass, material, dt);
  });
  worst_overlap_ = 0.0;
  for (const auto& p : pair_) {
    const double overlap = radius[p.a] + radius[p.b] - (x[p.a] - x[p.b]).norm();
    worst_overlap_ = std::max(worst_overlap_, overlap / std::min(radius[p.a], radius[p.b]));
  }
}

void GrainPairs::add_forces(std::span<Vec3> f) const {
  parallel_blocks(f.size(), kPairBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (const Side& s : sides_of(i)) {
        const Vec3& force = contact_[s.pair].force;
        f[i] += pair_[s.pair].a == static_cast<std::int32_t>(i) ? force : Vec3(-force);
      }
  });
}

void GrainPairs::multiply_add(double a, double b, std::span<const double> x, std::span<double> y) const {
  parallel_blocks(x.size() / 3, kPairBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::Map<const Vec3> xi(x.data() + 3 * i);
      Vec3 sum = Vec3::Zero();
      for (const Side& s : sides_of(i))
        sum += contact_[s.pair].times(a, b, xi - Eigen::Map<const Vec3>(x.data() + 3 * s.other));
      Eigen::Map<Vec3>(y.data() + 3 * i) += sum;
    }
  });
}

Mat3 GrainPairs::diagonal(std::size_t grain, double a, double b) const {
  Mat3 sum = Mat3::Zero();
  for (const Side& s : sides_of(grain)) sum += contact_[s.pair].matrix(a, b);
  return sum;
}

double GrainPairs::energy() const {
  return ordered_sum(contact_.size(), [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t p = begin; p < end; ++p) sum += contact_[p].energy;
    return sum;
  });
}

std::size_t GrainPairs::touching() const {
  return static_cast<std::size_t>(
      std::count_if(contact_.begin(), contact_.end(), [](const Contact& c) { return c.energy > 0.0; }));
}

}  // namespace brim
