#include "brim/body/particles/particle_body.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

Eigen::Map<const Vec3> at(std::span<const double> a, std::size_t i) { return Eigen::Map<const Vec3>(a.data() + 3 * i); }
Eigen::Map<Vec3> at(std::span<double> a, std::size_t i) { return Eigen::Map<Vec3>(a.data() + 3 * i); }

constexpr std::size_t kBlock = 4096;

}  // namespace

void require_positive(const char* what, const char* name, double value) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw InputError(fmt::format("{}: {} is {}; it must be positive and finite", what, name, value));
}

void require_not_negative(const char* what, const char* name, double value) {
  if (!(value >= 0.0) || !std::isfinite(value))
    throw InputError(fmt::format("{}: {} is {}; it must be zero or positive, and finite", what, name, value));
}

NodeMotion NodeMotion::constant_velocity(std::vector<std::int32_t> nodes, const Vec3& velocity) {
  return {std::move(nodes), [velocity](double time, const Vec3& rest) -> Vec3 { return rest + time * velocity; }};
}

ParticleBody::ParticleBody(std::vector<Vec3> rest, std::vector<double> mass, ParticleOptions options)
    : rest_(std::move(rest)),
      mass_(std::move(mass)),
      options_(std::move(options)),
      x_(rest_),
      v_(rest_.size(), Vec3::Zero()) {
  BRIM_CHECK(mass_.size(), ==, rest_.size());
  require_not_negative("body", "mass damping", options_.mass_damping);
  require_not_negative("body", "stiffness damping", options_.stiffness_damping);
  require_not_negative("body", "voxel size", options_.voxel_size);
  for (std::size_t i = 0; i < rest_.size(); ++i)
    if (!rest_[i].allFinite()) throw InputError(fmt::format("body: vertex {} has a position that is not finite", i));
  imposed_ = options_.fixed;
  for (const NodeMotion& m : options_.motions) {
    if (!m.position) throw InputError("body: a motion has no path");
    imposed_.insert(imposed_.end(), m.nodes.begin(), m.nodes.end());
  }
  std::sort(imposed_.begin(), imposed_.end());
  for (std::size_t i = 0; i < imposed_.size(); ++i) {
    if (imposed_[i] < 0 || static_cast<std::size_t>(imposed_[i]) >= rest_.size())
      throw InputError(
          fmt::format("body: node {} is fixed or moved, but nodes are 0 to {}", imposed_[i], rest_.size() - 1));
    if (i > 0 && imposed_[i] == imposed_[i - 1])
      throw InputError(fmt::format("body: node {} is fixed or moved twice", imposed_[i]));
  }
}

void ParticleBody::initial_state(std::span<double> q, std::span<double> v) const {
  Vec3 center = Vec3::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < rest_.size(); ++i) center += mass_[i] * rest_[i], total += mass_[i];
  center /= total;
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    at(q, i) = rest_[i];
    at(v, i) = options_.initial_velocity + options_.initial_spin.cross(rest_[i] - center);
  }
  filter(v);
}

void ParticleBody::prescribe(double time, double dt, std::span<const double> q, std::span<double> v) const {
  for (const std::int32_t i : options_.fixed) at(v, i).setZero();
  for (const NodeMotion& m : options_.motions)
    for (const std::int32_t i : m.nodes) at(v, i) = (m.position(time + dt, rest_[i]) - at(q, i)) / dt;
}

void ParticleBody::update(double, std::span<const double> q, std::span<const double> v) {
  BRIM_CHECK(q.size(), ==, q_size());
  BRIM_CHECK(v.size(), ==, v_size());
  for (std::size_t i = 0; i < rest_.size(); ++i) x_[i] = at(q, i), v_[i] = at(v, i);
  force_.assign(rest_.size(), Vec3::Zero());
  stiffness_.set_zero();
  add_inner();
}

void ParticleBody::advance(double dt, std::span<double> q, std::span<const double> v) const {
  for (std::size_t i = 0; i < q.size(); ++i) q[i] += dt * v[i];
}

void ParticleBody::add_forces(const Environment& env, std::span<double> Q) const {
  const double a = options_.mass_damping;
  for (std::size_t i = 0; i < rest_.size(); ++i) at(Q, i) += mass_[i] * env.gravity + force_[i] - a * mass_[i] * v_[i];
  if (options_.stiffness_damping > 0.0) {
    const std::span<const double> v(v_.data()->data(), 3 * v_.size());
    stiffness_.multiply_add(-options_.stiffness_damping, 0.0, mass_, v, Q);
  }
}

void ParticleBody::apply_mass(std::span<const double> x, std::span<double> y) const {
  for (std::size_t i = 0; i < rest_.size(); ++i) at(y, i) += mass_[i] * at(x, i);
}

void ParticleBody::apply_stiffness(std::span<const double> x, std::span<double> y) const {
  stiffness_.multiply_add(-1.0, 0.0, mass_, x, y);
}

void ParticleBody::apply_damping(std::span<const double> x, std::span<double> y) const {
  stiffness_.multiply_add(-options_.stiffness_damping, -options_.mass_damping, mass_, x, y);
}

void ParticleBody::apply_system(std::span<const double> x, std::span<double> y) const {
  stiffness_.multiply_add(dt_ * (options_.stiffness_damping + dt_), 1.0 + dt_ * options_.mass_damping, mass_, x, y);
}

void ParticleBody::add_system_diagonal(std::size_t first, BlockDiagonal& D) const {
  const double a = dt_ * (options_.stiffness_damping + dt_), b = 1.0 + dt_ * options_.mass_damping;
  parallel_blocks(rest_.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      D.block(first + i) += a * stiffness_.block(stiffness_.diagonal_slot(i)) + b * mass_[i] * Mat3::Identity();
  });
}

void ParticleBody::filter(std::span<double> x) const {
  for (const std::int32_t i : imposed_) at(x, i).setZero();
}

void ParticleBody::set_contact(std::unique_ptr<const ParticleContact> contact, PartInfo part) {
  contact_ = std::move(contact);
  part_ = std::move(part);
  if (options_.voxel_size > 0.0) part_.voxel_size = options_.voxel_size;
  if (immobile()) part_.areal_mass = 0.0;
  part_.material = options_.material;
  display_.vertices = rest_.size();
}

Aabb ParticleBody::bounds(int) const {
  Aabb box;
  for (const Vec3& x : x_) box.extend(x);
  return contact_ ? box.inflated(contact_->reach()) : box;
}

void ParticleBody::presence(int, double h, double w, const Aabb& region, std::vector<TileKey>& out) const {
  contact_->presence(x_, h, w, region, out);
}

void ParticleBody::rasterize(int, double h, double w, std::span<const TileKey> tiles,
                             std::span<DensityBlock> out) const {
  contact_->rasterize(x_, h, w, tiles, out);
}

void ParticleBody::make_map(int, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                            std::unique_ptr<Map>& map) const {
  contact_->make_map(x_, points, sources, map);
}

void ParticleBody::display_positions(std::span<Vec3f> x) const {
  BRIM_CHECK(x.size(), ==, x_.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = x_[i].cast<float>();
}

Vec3 ParticleBody::carrier_velocity(int, std::span<const double> v) const {
  double total = 0.0;
  for (const double m : mass_) total += m;
  return linear_momentum(v) / total;
}

double ParticleBody::relative_speed_bound(int, std::span<const double> v) const {
  const Vec3 carrier = carrier_velocity(0, v);
  double largest = 0.0;
  for (std::size_t i = 0; i < rest_.size(); ++i) largest = std::max(largest, (at(v, i) - carrier).squaredNorm());
  return std::sqrt(largest);
}

double ParticleBody::mass() const {
  if (imposed_.size() == rest_.size()) return std::numeric_limits<double>::infinity();
  double total = 0.0;
  for (const double m : mass_) total += m;
  return total;
}

double ParticleBody::potential_energy(const Environment& env) const {
  double e = elastic_energy();
  for (std::size_t i = 0; i < rest_.size(); ++i) e -= mass_[i] * env.gravity.dot(x_[i]);
  return e;
}

Vec3 ParticleBody::linear_momentum(std::span<const double> v) const {
  Vec3 p = Vec3::Zero();
  for (std::size_t i = 0; i < rest_.size(); ++i) p += mass_[i] * at(v, i);
  return p;
}

bool ParticleBody::rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const {
  for (std::size_t i = 0; i < x_.size(); ++i) Eigen::Map<Vec3>(v.data() + 3 * i) = t + w.cross(x_[i]);
  return true;
}

Vec3 ParticleBody::angular_momentum(std::span<const double> v) const {
  Vec3 l = Vec3::Zero();
  for (std::size_t i = 0; i < rest_.size(); ++i) l += mass_[i] * x_[i].cross(at(v, i));
  return l;
}

}  // namespace brim
