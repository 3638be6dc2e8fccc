#include "brim/body/points/grain_pairs.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "brim/core/parallel.h"

namespace brim {

namespace {
constexpr std::size_t kPairBlock = 512;
/// Overlap at the end of a step, over the smaller radius, from which a pair is foreseen: less brings in hardly any
/// energy, and another solve costs as much as for all.
constexpr double kForeseen = 0.01;

/// Linear springs in series, [N/m].
double spring(const GrainMaterial& m, double ra, double rb) { return 2.0 * m.young * ra * rb / (ra + rb); }
}  // namespace

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

GrainPairs::Contact GrainPairs::meeting(const NeighbourSearch::Pair& p, std::span<const Vec3> x,
                                        std::span<const double> radius, const GrainMaterial& m, double& overlap) {
  Contact c;
  const double ra = radius[p.a], rb = radius[p.b];
  const Vec3 d = x[p.a] - x[p.b];
  const double distance = d.norm();
  overlap = ra + rb - distance;
  c.normal = distance > 0.0 ? Vec3(d / distance) : Vec3::UnitZ();
  c.arm_a = distance * ra / (ra + rb), c.arm_b = distance * rb / (ra + rb);
  if (overlap > 0.0) c.energy = 0.5 * spring(m, ra, rb) * overlap * overlap;
  return c;
}

Vec3 GrainPairs::sliding(const Contact& c, const NeighbourSearch::Pair& p, std::span<const Vec3> v,
                         std::span<const Vec3> spin) {
  return v[p.a] - v[p.b] - (c.arm_a * spin[p.a] + c.arm_b * spin[p.b]).cross(c.normal);
}

void GrainPairs::press(Contact& c, const NeighbourSearch::Pair& p, double overlap, const Vec3& u,
                       std::span<const Vec3> spin, std::span<const double> radius, const GrainMaterial& m) {
  const double ra = radius[p.a], rb = radius[p.b];
  const double closing = -c.normal.dot(u), b = overlap > 0.0 ? m.damping : 0.0;
  c.k = spring(m, ra, rb);
  c.damper = b * c.k;
  const double push = c.k * (overlap + b * closing);
  c.force = push * c.normal;
  if (!(overlap > 0.0 && push > 0.0)) return;
  const Vec3 slip = u + closing * c.normal;
  c.drag = m.friction * push / std::max(slip.norm(), m.slip_speed);
  c.force -= c.drag * slip;
  const double R = ra * rb / (ra + rb);
  const Vec3 turn = spin[p.a] - spin[p.b];
  c.roll = m.rolling * R * push / std::max(turn.norm(), m.slip_speed / R);
  c.roll_torque = -c.roll * turn;
}

GrainPairs::Contact GrainPairs::contact(const NeighbourSearch::Pair& p, std::span<const Vec3> x,
                                        std::span<const Vec3> v, std::span<const Vec3> spin,
                                        std::span<const double> radius, std::span<const double> mass,
                                        const GrainMaterial& m, double dt) {
  double overlap;
  Contact c = meeting(p, x, radius, m, overlap);
  const double k = spring(m, radius[p.a], radius[p.b]);
  if (dt == 0.0) {
    if (overlap > 0.0) c.k = k, c.force = k * overlap * c.normal;
    return c;
  }
  const Vec3 u = sliding(c, p, v, spin);
  const double b = overlap > 0.0 ? m.damping : 0.0;
  const double inverse_mass = 1.0 / mass[p.a] + 1.0 / mass[p.b];
  // What would drive a touching pair together in this step without its spring: at rest, as much as the spring holds.
  const double drive = overlap > 0.0 ? dt * (m.gravity + k * overlap * inverse_mass) : 0.0;
  if (overlap + (dt + b) * (-c.normal.dot(u) + drive) > 0.0) press(c, p, overlap, u, spin, radius, m);
  return c;
}

bool GrainPairs::foresee(std::span<const Vec3> after, std::span<const Vec3> spin_after, std::span<const Vec3> x,
                         std::span<const Vec3> v, std::span<const Vec3> spin, std::span<const double> radius,
                         std::span<const double> mass, const GrainMaterial& m, double dt) {
  std::atomic<bool> any = false;
  parallel_blocks(pair_.size(), kPairBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto& p = pair_[i];
      if (contact_[i].k != 0.0) continue;
      double overlap;
      Contact c = meeting(p, x, radius, m, overlap);
      const double b = overlap > 0.0 ? m.damping : 0.0;
      const double least = kForeseen * std::min(radius[p.a], radius[p.b]);
      const Vec3 found = sliding(c, p, after, spin_after), u = sliding(c, p, v, spin);
      const double closing = -c.normal.dot(found);
      if (!(overlap + (dt + b) * closing > least)) continue;
      press(c, p, overlap, u, spin, radius, m);
      if (c.drag == 0.0 && closing > 0.0) {
        // The blow stops the two at most: friction of that load.
        const double stop = closing / (dt * (1.0 / mass[p.a] + 1.0 / mass[p.b]));
        const Vec3 slip = found + closing * c.normal;
        c.drag = m.friction * std::min(c.k * (overlap + dt * closing), stop) / std::max(slip.norm(), m.slip_speed);
        c.force -= c.drag * (u - c.normal * c.normal.dot(u));
      }
      contact_[i] = c;
      any = true;
    }
  });
  return any;
}

void GrainPairs::evaluate(std::span<const Vec3> x, std::span<const Vec3> v, std::span<const Vec3> spin,
                          std::span<const double> radius, std::span<const double> mass, const GrainMaterial& material,
                          double dt) {
  contact_.resize(pair_.size());
  parallel_blocks(pair_.size(), kPairBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) contact_[p] = contact(pair_[p], x, v, spin, radius, mass, material, dt);
  });
  worst_overlap_ = 0.0;
  for (const auto& p : pair_) {
    const double overlap = radius[p.a] + radius[p.b] - (x[p.a] - x[p.b]).norm();
    worst_overlap_ = std::max(worst_overlap_, overlap / std::min(radius[p.a], radius[p.b]));
  }
}

void GrainPairs::add_forces(std::span<Vec3> f, std::span<Vec3> torque) const {
  parallel_blocks(f.size(), kPairBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (const Side& s : sides_of(i)) {
        const Contact& c = contact_[s.pair];
        const bool is_a = pair_[s.pair].a == static_cast<std::int32_t>(i);
        f[i] += is_a ? c.force : Vec3(-c.force);
        torque[i] -= (is_a ? c.arm_a : c.arm_b) * c.normal.cross(c.force);
        torque[i] += is_a ? c.roll_torque : Vec3(-c.roll_torque);
      }
  });
}

void GrainPairs::multiply_add(double a, double b, std::span<const double> x, std::span<double> y) const {
  const auto at = [&](std::size_t i) { return Eigen::Map<const Vec3>(x.data() + 3 * i); };
  parallel_blocks(x.size() / 6, kPairBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 v = at(2 * i), w = at(2 * i + 1);
      Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
      for (const Side& s : sides_of(i)) {
        const Contact& c = contact_[s.pair];
        if (c.k == 0.0) continue;
        // Seen from grain i: n towards it, what it has at the contact against what the other has.
        const bool is_a = pair_[s.pair].a == static_cast<std::int32_t>(i);
        const double own = is_a ? c.arm_a : c.arm_b, others = is_a ? c.arm_b : c.arm_a;
        const auto other = static_cast<std::size_t>(s.other);
        const Vec3 n = is_a ? c.normal : Vec3(-c.normal);
        const Vec3 turn = own * w + others * at(2 * other + 1);
        const Vec3 push = c.times(a, b, v - at(2 * other) - turn.cross(n));
        force += push, torque += b * c.roll * (w - at(2 * other + 1)) - own * n.cross(push);
      }
      Eigen::Map<Vec3>(y.data() + 6 * i) += force;
      Eigen::Map<Vec3>(y.data() + 6 * i + 3) += torque;
    }
  });
}

GrainPairs::Mat6 GrainPairs::diagonal(std::size_t grain, double a, double b) const {
  Mat6 sum = Mat6::Zero();
  for (const Side& s : sides_of(grain)) {
    const Contact& c = contact_[s.pair];
    if (c.k == 0.0) continue;
    const bool is_a = pair_[s.pair].a == static_cast<std::int32_t>(grain);
    const Mat3 X = c.arm(is_a), M = c.matrix(a, b), MX = M * X;
    sum.topLeftCorner<3, 3>() += M;
    sum.topRightCorner<3, 3>() -= MX;
    sum.bottomLeftCorner<3, 3>() -= MX.transpose();
    sum.bottomRightCorner<3, 3>() += X.transpose() * MX + b * c.roll * Mat3::Identity();
  }
  return sum;
}

void GrainPairs::couple(double a, double b) {
  coupled_first_.assign(1, 0);
  coupled_.clear(), coupling_.clear();
  for (std::size_t i = 0; i + 1 < first_.size(); ++i) {
    for (const Side& s : sides_of(i)) {
      const Contact& c = contact_[s.pair];
      if (c.k == 0.0 || s.other < static_cast<std::int32_t>(i)) continue;
      // u = (v_i − X ω_i) − (v_j − Y ω_j), and grain i, the smaller of the two numbers, is a.
      const Mat3 X = c.arm(true), Y = c.arm(false), M = c.matrix(a, b), MY = M * Y;
      Mat6 block;
      block << -M, MY, X.transpose() * M, -X.transpose() * MY - b * c.roll * Mat3::Identity();
      coupled_.push_back(s.other);
      coupling_.push_back(block.cast<float>());
    }
    coupled_first_.push_back(static_cast<std::int32_t>(coupled_.size()));
  }
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
