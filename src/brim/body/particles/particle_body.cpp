#include "brim/body/particles/particle_body.h"

#include <algorithm>

#include "brim/body/particles/mean_motion.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

Eigen::Map<const Vec3> at(std::span<const double> a, std::size_t i) { return Eigen::Map<const Vec3>(a.data() + 3 * i); }
Eigen::Map<Vec3> at(std::span<double> a, std::size_t i) { return Eigen::Map<Vec3>(a.data() + 3 * i); }

std::span<const double> flat(const std::vector<Vec3>& x) { return {x.data()->data(), 3 * x.size()}; }

/// True where inner forces join the particles, so that they turn as one.
bool hold_together(const BlockMatrix& stiffness) { return stiffness.block_count() > stiffness.rows(); }

constexpr std::size_t kNodeBlock = 4096;

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
  for (const double m : mass_) total_mass_ += m;
  for (const Vec3& x : x_) box_.extend(x);
  for (std::size_t i = 0; i < rest_.size(); ++i)
    if (!rest_[i].allFinite()) throw InputError(fmt::format("body: vertex {} has a position that is not finite", i));
  prescribed_ = options_.fixed;
  for (const NodeMotion& m : options_.motions) {
    if (!m.position) throw InputError("body: a motion has no path");
    prescribed_.insert(prescribed_.end(), m.nodes.begin(), m.nodes.end());
  }
  std::sort(prescribed_.begin(), prescribed_.end());
  for (std::size_t i = 0; i < prescribed_.size(); ++i) {
    if (prescribed_[i] < 0 || static_cast<std::size_t>(prescribed_[i]) >= rest_.size())
      throw InputError(
          fmt::format("body: node {} is fixed or moved, but nodes are 0 to {}", prescribed_[i], rest_.size() - 1));
    if (i > 0 && prescribed_[i] == prescribed_[i - 1])
      throw InputError(fmt::format("body: node {} is fixed or moved twice", prescribed_[i]));
  }
}

void ParticleBody::initial_state(std::span<double> q, std::span<double> v) const {
  Vec3 center = Vec3::Zero();
  for (std::size_t i = 0; i < rest_.size(); ++i) center += mass_[i] * rest_[i];
  center /= total_mass_;
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
  BRIM_CHECK(v.size(), ==, 3 * rest_.size());
  if (std::exchange(ahead_, false) && std::ranges::equal(q, flat(x_))) {
    for (std::size_t i = 0; i < rest_.size(); ++i) v_[i] = at(v, i);
    guided_.clear(), linked_.clear();
    return;
  }
  box_ = Aabb{};
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    x_[i] = at(q, i), v_[i] = at(v, i);
    box_.extend(x_[i]);
  }
  guided_.clear(), linked_.clear();
  begin_inner();
  add_inner();
  end_inner();
  if (pieces_) pieces_->set_name(name()), pieces_->follow(x_);
}

void ParticleBody::begin_inner() {
  force_.assign(rest_.size(), Vec3::Zero());
  stiffness_.set_zero();
}

void ParticleBody::end_inner() { stiffness_.close(); }

void ParticleBody::turns(std::span<const double> v, std::span<Turn> part) const {
  Turn all;
  if (hold_together(stiffness_)) {
    const MeanMotion m = mean_motion(particle_set(), flat(x_), v);
    all = {.center = m.center, .spin = m.spin};
  }
  std::ranges::fill(part, all);
}

void ParticleBody::keep_energy(double time, std::span<const double> q, std::span<double> v) {
  if (!prescribed_.empty() || !hold_together(stiffness_)) return;
  const double before = elastic_energy() + energy_about_center(mass_, flat(v_));
  update(time, q, v);
  slow_inner_motion(particle_set(), q, before - elastic_energy(), v);
  for (std::size_t i = 0; i < rest_.size(); ++i) v_[i] = at(v, i);
  ahead_ = true;
}

void ParticleBody::advance(double dt, std::span<double> q, std::span<const double> v) const {
  if (hold_together(stiffness_))
    advance_turning(particle_set(), dt, q, v, straightening(dt));
  else
    for (std::size_t i = 0; i < q.size(); ++i) q[i] += dt * v[i];
}

void ParticleBody::finish_step(double, double dt, std::span<double> q, std::span<double> v) {
  if (!hold_together(stiffness_)) return;
  // The forces of the state have neither resultant nor torque; their linear change over the step, -K v, may have both.
  impulse_.assign(v.size(), 0.0);
  const BlockSystem system = *block_system();
  if (system.stiffness == &stiffness_) {
    stiffness_.multiply_add(system.stiffness_share, 0.0, mass_, v, impulse_);
    if (!guided_.empty()) {
      std::vector<double> turned(v.size(), 0.0);
      add_turning_stiffness(flat(v_), guided_, turned);
      for (std::size_t i = 0; i < turned.size(); ++i) impulse_[i] -= dt * dt * turned[i];
    }
  } else {
    // The system's own rounding acted on what the velocities changed by, that of K and D on what they were.
    std::vector<double> x(v.begin(), v.end());
    for (std::size_t i = 0; i < v_.size(); ++i) at(std::span(x), i) -= v_[i];
    system.stiffness->multiply_add(system.stiffness_share, 0.0, mass_, x, impulse_);
    std::fill(x.begin(), x.end(), 0.0);
    apply_start_stiffness(flat(v_), x);
    for (double& e : x) e *= dt;
    apply_damping(flat(v_), x);
    for (std::size_t i = 0; i < v_.size(); ++i)
      at(std::span(impulse_), i) -= dt * (at(std::span(x), i) + options_.mass_damping * mass_[i] * v_[i]);
  }
  turn_velocities(particle_set(), dt, flat(x_), q, v, impulse_);
}

void ParticleBody::add_forces(const Environment& env, std::span<double> Q) const {
  const double a = options_.mass_damping;
  for (std::size_t i = 0; i < rest_.size(); ++i) at(Q, i) += mass_[i] * env.gravity + force_[i] - a * mass_[i] * v_[i];
  if (options_.stiffness_damping > 0.0) {
    stiffness_.multiply_add(-options_.stiffness_damping, 0.0, mass_, flat(v_), Q);
  }
  if (hold_together(stiffness_)) add_turning_forces(particle_set(), dt_, flat(x_), flat(v_), Q);
  add_outer_forces(Q);
}

void ParticleBody::apply_mass(std::span<const double> x, std::span<double> y) const {
  for (std::size_t i = 0; i < rest_.size(); ++i) at(y, i) += mass_[i] * at(x, i);
}

void ParticleBody::apply_stiffness(std::span<const double> x, std::span<double> y) const {
  stiffness_.multiply_add(-1.0, 0.0, mass_, x, y);
}

void ParticleBody::apply_start_stiffness(std::span<const double> x, std::span<double> y) const {
  apply_stiffness(x, y);
  if (!guided_.empty()) add_turning_stiffness(x, guided_, y);
}

void ParticleBody::apply_damping(std::span<const double> x, std::span<double> y) const {
  stiffness_.multiply_add(-options_.stiffness_damping, -options_.mass_damping, mass_, x, y);
}

void ParticleBody::apply_system(std::span<const double> x, std::span<double> y) const {
  stiffness_.multiply_add(dt_ * (options_.stiffness_damping + dt_), 1.0 + dt_ * options_.mass_damping, mass_, x, y);
}

std::optional<BlockSystem> ParticleBody::block_system() const {
  return BlockSystem{&stiffness_,
                     dt_ * (options_.stiffness_damping + dt_),
                     1.0 + dt_ * options_.mass_damping,
                     mass_,
                     prescribed_,
                     x_,
                     contact_ && contact_->thin()};
}

void ParticleBody::add_system_diagonal(std::size_t first, BlockDiagonal& D) const {
  const double a = dt_ * (options_.stiffness_damping + dt_), b = 1.0 + dt_ * options_.mass_damping;
  parallel_blocks(rest_.size(), kNodeBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      D.block(first + i) += a * stiffness_.diagonal(i) + b * mass_[i] * Mat3::Identity();
  });
}

void ParticleBody::filter(std::span<double> x) const {
  for (const std::int32_t i : prescribed_) at(x, i).setZero();
}

void ParticleBody::set_contact(std::unique_ptr<const ParticleContact> contact, PartInfo part) {
  contact_ = std::move(contact);
  part_ = std::move(part);
  if (options_.voxel_size > 0.0) part_.voxel_size = options_.voxel_size;
  if (immobile()) part_.areal_mass = 0.0;
  part_.material = options_.material;
  display_.vertices = rest_.size();
  if (contact_) clusters_.build(rest_, contact_->elements());
  if (!options_.self_contact) return;
  if (!contact_ || contact_->piece({}) == nullptr)
    throw InputError("body: self-contact is for sheets, nets and lines; this one is neither");
  pieces_ = std::make_unique<BodyPieces>(rest_, *contact_, part_);
}

Aabb ParticleBody::bounds(int) const { return contact_ ? box_.inflated(contact_->reach()) : box_; }

void ParticleBody::presence(int, double h, double w, const Aabb& region, std::vector<TileKey>& out) const {
  contact_->presence(x_, h, w, region, out);
}

void ParticleBody::octant_presence(int part, double h, double w, const Aabb& region,
                                   std::vector<OctantTile>& out) const {
  if (contact_) return contact_->octant_presence(x_, h, w, region, out);
  // A kind with a presence of its own: whole tiles.
  std::vector<TileKey> tiles;
  presence(part, h, w, region.inflated(h), tiles);
  for (const TileKey& t : tiles) out.push_back({t, kAllOctants});
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

Vec3 ParticleBody::mean_velocity(int, std::span<const double> v) const { return linear_momentum(v) / total_mass_; }

double ParticleBody::relative_speed_bound(int, std::span<const double> v) const {
  const Vec3 mean = mean_velocity(0, v);
  double largest = 0.0;
  for (std::size_t i = 0; i < rest_.size(); ++i) largest = std::max(largest, (at(v, i) - mean).squaredNorm());
  return std::sqrt(largest);
}

void ParticleBody::motion_clusters(int, std::span<const double> v, std::vector<MotionCluster>& out) const {
  if (contact_) clusters_.measure(x_, v, contact_->reach(), out);
}

void ParticleBody::finer_clusters(int, std::size_t cluster, std::span<const double> v,
                                  std::vector<MotionCluster>& out) const {
  clusters_.measure_finer(cluster, x_, v, contact_->reach(), out);
}

double ParticleBody::mass() const {
  return prescribed_.size() == rest_.size() ? std::numeric_limits<double>::infinity() : total_mass_;
}

double ParticleBody::kinetic_energy(std::span<const double> v) const {
  double e = 0.0;
  for (std::size_t i = 0; i < rest_.size(); ++i) e += 0.5 * mass_[i] * at(v, i).squaredNorm();
  return e;
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
