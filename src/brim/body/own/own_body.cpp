#include "brim/body/own/own_body.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "brim/body/own/own_matter.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/mass_properties.h"
#include "brim/raster/fill_tiles.h"

namespace brim {

namespace {

using Vector = Eigen::VectorXd;

/// Steps of central differences, as shares of what moves matter by its extent: of deform, along a motion, and of the
/// energy's first and second derivatives.
constexpr double kPlaceStep = 1e-4, kMotionStep = 1e-3, kForceStep = 1e-5, kStiffnessStep = 1e-4;
/// [-] of the extent by which matter may bulge beyond the points at which it is looked for.
constexpr double kBulge = 0.02;
/// [-] of the extent that edges of the surface may have: at a curvature κ matter bulges by κ l²/8 beyond an edge l,
/// which is kBulge where the body bends by 10 rad over its extent.
constexpr double kEdge = 0.126;

/// Pieces of matter at which the jacobian is held against differences of deform, and by how much it may miss them, as a
/// share of what the coordinate moves at most. Formulas that are right miss by rounding.
constexpr std::size_t kTried = 16;
constexpr double kMiss = 0.1;

Eigen::Map<const Vector> vector(std::span<const double> x) { return {x.data(), static_cast<Eigen::Index>(x.size())}; }
Eigen::Map<Vector> writable(std::span<double> x) { return {x.data(), static_cast<Eigen::Index>(x.size())}; }

}  // namespace

OwnBody::OwnBody(OwnModel model) : model_(std::move(model)) {
  if (model_.v.empty()) model_.v.assign(model_.q.size(), 0.0);
  if (model_.q.empty() || model_.v.size() != model_.q.size())
    throw InputError(fmt::format("own body: {} coordinates and {} velocities; one of each at least, and as many",
                                 model_.q.size(), model_.v.size()));
  const auto finite = [](double x) { return std::isfinite(x); };
  if (!std::all_of(model_.q.begin(), model_.q.end(), finite) || !std::all_of(model_.v.begin(), model_.v.end(), finite))
    throw InputError("own body: its state at the start is not finite");
  mass_ = mass_properties(model_.surface, model_.density).mass;
  Aabb box;
  for (const Vec3& x : model_.surface.vertices) box.extend(x);
  const double spacing = model_.mass_spacing > 0.0 ? model_.mass_spacing
                                                   : std::min(box.extent().maxCoeff() / 8.0, box.extent().minCoeff());
  MassPoints points = mass_points(model_.surface, model_.density, spacing);
  piece_ = std::move(points.at), piece_mass_ = std::move(points.mass);
  part_.voxel_size = model_.voxel_size > 0.0 ? model_.voxel_size : box.extent().minCoeff() / 8.0;
  part_.areal_mass = 6.0 * mass_ / surface_area(model_.surface);
  part_.thickness = box.extent().minCoeff();
  part_.width = width_of(mass_ / model_.density, part_.thickness, box);
  part_.material = model_.material;
  model_.surface = with_short_edges(model_.surface, kEdge * box.extent().maxCoeff());
  display_.vertices = model_.surface.vertices.size();
  display_.triangles = model_.surface.triangles;
}

void OwnBody::jacobian(Coordinates q, const Vec3& X, Eigen::Ref<Jacobian> J) const {
  std::vector<double> moved(q.begin(), q.end());
  for (std::size_t i = 0; i < q.size(); ++i) {
    const double d = step_of(i, kPlaceStep);
    moved[i] = q[i] + d;
    const Vec3 up = deform(moved, X);
    moved[i] = q[i] - d;
    J.col(static_cast<Eigen::Index>(i)) = (up - deform(moved, X)) / (2.0 * d);
    moved[i] = q[i];
  }
}

Eigen::VectorXd OwnBody::energy_force(Coordinates given) const {
  std::vector<double> q(given.begin(), given.end());
  Vector f(static_cast<Eigen::Index>(q.size()));
  for (std::size_t i = 0; i < q.size(); ++i) {
    const double at = q[i], d = step_of(i, kForceStep);
    q[i] = at + d;
    const double up = ask_energy(q);
    q[i] = at - d;
    f[static_cast<Eigen::Index>(i)] = -(up - ask_energy(q)) / (2.0 * d);
    q[i] = at;
  }
  return f;
}

Vec3 OwnBody::place(Coordinates, const Vec3&) const {
  throw InputError(fmt::format("body of kind '{}': deform(q, X) is missing; it says where the matter of X is", kind()));
}

Vec3 OwnBody::rest(Coordinates, const Vec3&) const {
  throw InputError(
      fmt::format("body of kind '{}': inverse_deform(q, x) is missing; it says which matter is at x", kind()));
}

void OwnBody::deform_all(Coordinates q, std::span<const Vec3> X, std::span<Vec3> x) const {
  parallel_for(
      X.size(), [&](std::size_t p) { x[p] = deform(q, X[p]); }, 64);
}

void OwnBody::inverse_deform_all(Coordinates q, std::span<const Vec3> x, std::span<Vec3> X) const {
  parallel_for(
      x.size(), [&](std::size_t p) { X[p] = inverse_deform(q, x[p]); }, 64);
}

void OwnBody::jacobian_all(Coordinates q, std::span<const Vec3> X, DenseMap& J) const {
  parallel_for(
      X.size(), [&](std::size_t p) { jacobian(q, X[p], J.row(p)); }, 16);
}

void OwnBody::initial_state(std::span<double> q, std::span<double> v) const {
  std::copy(model_.q.begin(), model_.q.end(), q.begin());
  std::copy(model_.v.begin(), model_.v.end(), v.begin());
}

void OwnBody::update(double time, std::span<const double> q, std::span<const double> v) {
  now_ = time;
  q_.assign(q.begin(), q.end());
  v_.assign(v.begin(), v.end());
  vertex_.resize(model_.surface.vertices.size());
  if (scale_.empty()) measure_scales();
  if (!started_) check_jacobian();
  measure_matter();
  ask_deform(q_, model_.surface.vertices, vertex_);
  bounds_ = Aabb();
  for (const Vec3& x : vertex_) bounds_.extend(x);
  for (std::size_t k = 0; k < x_.size(); k += 3) bounds_.extend(Vec3(x_[k], x_[k + 1], x_[k + 2]));
  bounds_ = bounds_.inflated(kBulge * bounds_.extent().maxCoeff());
  measure_energy();
  if (!started_) check_start();
  if (!started_) rigid_ = follows_rigid_motion(), turns_freely_ = rigid_ && is_energy_turned(), started_ = true;
  if (!rigid_) bias_ = bias();
}

double OwnBody::step_of(std::size_t i, double relative) const {
  return relative * (i < scale_.size() ? scale_[i] : 1.0);
}

double OwnBody::place_step(std::size_t i) const { return step_of(i, kPlaceStep); }

double OwnBody::time_step(std::span<const double> v) const {
  double most = 0.0;
  for (std::size_t i = 0; i < v.size(); ++i) most = std::max(most, std::abs(v[i]) / scale_[i]);
  return most > 0.0 ? kMotionStep / most : 1.0;
}

void OwnBody::measure_scales() {
  Aabb box;
  for (const Vec3& X : model_.surface.vertices) box.extend(X);
  // Where matter is: a local mode moves no corner of the box.
  std::vector<Vec3> matter = model_.surface.vertices;
  matter.insert(matter.end(), piece_.begin(), piece_.end());
  std::vector<Vec3> x(matter.size()), moved(matter.size());
  const double extent = box.extent().maxCoeff();
  std::vector<double> q = model_.q, scale(q.size());
  ask_deform(q, matter, x);
  for (std::size_t i = 0; i < q.size(); ++i) {
    // A step that moves it by little, whatever the unit: from that of one, at most a few times.
    double d = kPlaceStep * std::max(1.0, std::abs(q[i]));
    scale[i] = d / kPlaceStep;
    for (int attempt = 0; attempt < 4; ++attempt) {
      const double at = q[i];
      q[i] = at + d;
      deform_all(q, matter, moved);
      q[i] = at;
      double way = 0.0;
      for (std::size_t k = 0; k < x.size(); ++k) way = std::max(way, (moved[k] - x[k]).norm());
      if (!(way > 0.0) || !std::isfinite(way)) break;
      scale[i] = d * extent / way;
      const double wanted = kPlaceStep * scale[i];
      if (d > 0.1 * wanted && d < 10.0 * wanted) break;
      d = wanted;
    }
  }
  scale_ = std::move(scale);
}

void OwnBody::check_jacobian() const {
  std::vector<Vec3> X;
  const std::size_t tried = std::min(kTried, piece_.size());
  for (std::size_t k = 0; k < tried; ++k)
    X.push_back(piece_[k * (piece_.size() - 1) / std::max<std::size_t>(tried - 1, 1)]);
  Aabb box;
  for (const Vec3& at : model_.surface.vertices) box.extend(at);
  const double allowed = kMiss * box.extent().maxCoeff();
  DenseMap J;
  J.reset(X.size(), q_.size());
  ask_jacobian(q_, X, J);
  std::vector<Vec3> x(X.size()), up(X.size()), down(X.size());
  ask_deform(q_, X, x);
  std::vector<double> moved = q_;
  for (std::size_t i = 0; i < q_.size(); ++i) {
    const double d = place_step(i);
    moved[i] = q_[i] + d;
    ask_deform(moved, X, up);
    moved[i] = q_[i] - d;
    ask_deform(moved, X, down);
    moved[i] = q_[i];
    for (std::size_t p = 0; p < X.size(); ++p) {
      const Vec3 given = J.row(p).col(static_cast<Eigen::Index>(i)), found = (up[p] - down[p]) / (2.0 * d);
      // Where deform has an edge, the derivative of either side is right.
      const double miss = std::min(
          {(given - found).norm(), (given - (up[p] - x[p]) / d).norm(), (given - (x[p] - down[p]) / d).norm()});
      if (miss * scale_[i] <= allowed) continue;
      const auto text = [](const Vec3& v) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", v.x(), v.y(), v.z()); };
      throw InputError(fmt::format(
          "body '{}': jacobian(q, X) is not the derivative of deform(q, X): at X = {} its column {} is {}, and "
          "differences of deform give {}; mend it, or leave it out for differences",
          name(), text(X[p]), i, text(given), text(found)));
    }
  }
}

void OwnBody::measure_matter() {
  const auto n = static_cast<Eigen::Index>(q_.size());
  M_.resize(n, n);
  linear_.setZero(3, n);
  angular_.setZero(3, n);
  first_moment_.setZero();
  if (next_q_ == q_) {
    std::swap(x_, next_x_), std::swap(J_, next_J_);
  } else {
    x_ = piece_places(q_);
    J_.reset(piece_.size(), q_.size());
    ask_jacobian(q_, piece_, J_);
  }
  next_q_.clear();
  M_ = mass_matrix(J_);
  for (std::size_t k = 0; k < piece_.size(); ++k) {
    const double m = piece_mass_[k];
    const auto J = J_.row(k);
    const Vec3 x = Eigen::Map<const Vec3>(x_.data() + 3 * k);
    linear_ += m * J;
    angular_.noalias() += (m * skew(x)).lazyProduct(J);
    first_moment_ += m * x;
  }
}

Eigen::VectorXd OwnBody::bias() const {
  // J̇ v is the second derivative of deform along the motion.
  const double d = time_step(v_);
  std::vector<double> ahead(q_), behind(q_);
  for (std::size_t i = 0; i < q_.size(); ++i) ahead[i] += d * v_[i], behind[i] -= d * v_[i];
  std::vector<double> bend = piece_places(ahead);
  writable(bend) += vector(piece_places(behind)) - 2.0 * vector(x_);
  return gather(J_, bend) / (d * d);
}

void OwnBody::measure_energy() {
  const auto n = static_cast<Eigen::Index>(q_.size());
  force_ = ask_force(q_);
  K_.resize(n, n);
  std::vector<double> q = q_;
  for (Eigen::Index i = 0; i < n; ++i) {
    double& at = q[static_cast<std::size_t>(i)];
    const double start = at, d = step_of(static_cast<std::size_t>(i), kStiffnessStep);
    at = start + d;
    const Vector up = ask_force(q);
    at = start - d;
    K_.col(i) = (up - ask_force(q)) / (2.0 * d);
    at = start;
  }
  // The solve needs a definite matrix: keep what resists.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (K_ + K_.transpose()));
  K_ = eigen.eigenvectors() * eigen.eigenvalues().cwiseMin(0.0).asDiagonal() * eigen.eigenvectors().transpose();
}

void OwnBody::add_forces(const Environment& env, std::span<double> Q) const {
  writable(Q) += force_ + linear_.transpose() * env.gravity + model_.stiffness_damping * (K_ * vector(v_));
  add_forces_of_motion(Q);
  add_outer_forces(Q);
}

void OwnBody::apply_mass(std::span<const double> x, std::span<double> y) const { writable(y) += M_ * vector(x); }

void OwnBody::apply_stiffness(std::span<const double> x, std::span<double> y) const { writable(y) += K_ * vector(x); }

void OwnBody::apply_damping(std::span<const double> x, std::span<double> y) const {
  writable(y) += model_.stiffness_damping * (K_ * vector(x));
}

void OwnBody::add_system_diagonal(std::size_t first, BlockDiagonal& D) const {
  D.block(first) += M_ - dt_ * (dt_ + model_.stiffness_damping) * K_;
}

double OwnBody::relative_speed_bound(int, std::span<const double> v) const {
  const Vec3 mean = mean_velocity(0, v);
  const double d = time_step(v);
  std::vector<double> ahead(q_), behind(q_);
  for (std::size_t i = 0; i < q_.size(); ++i) ahead[i] += d * v[i], behind[i] -= d * v[i];
  std::vector<Vec3> front(model_.surface.vertices.size()), back(front.size());
  ask_deform(ahead, model_.surface.vertices, front);
  ask_deform(behind, model_.surface.vertices, back);
  double most = 0.0;
  for (std::size_t i = 0; i < front.size(); ++i)
    most = std::max(most, ((front[i] - back[i]) / (2.0 * d) - mean).norm());
  const std::vector<double> u = piece_velocities(v);
  for (std::size_t k = 0; k < u.size(); k += 3) most = std::max(most, (Vec3(u[k], u[k + 1], u[k + 2]) - mean).norm());
  return (1.0 + kBulge) * most;
}

void OwnBody::presence(int, double h, double w, const Aabb& region, std::vector<TileKey>& out) const {
  const Aabb where = region.intersection(bounds_.inflated(0.5 * w));
  if (where.empty()) return;
  const TileRange range = tiles_meeting(where.inflated(h), h);
  for (int z = range.lo.z; z <= range.hi.z; ++z)
    for (int y = range.lo.y; y <= range.hi.y; ++y)
      for (int x = range.lo.x; x <= range.hi.x; ++x) out.push_back({x, y, z});
}

void OwnBody::rasterize(int, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const {
  fill_tiles([&](const Vec3& x) { return ask_distance(q_, x); }, tiles, h, w, out);
}

void OwnBody::make_map(int, std::span<const Vec3> points, std::span<const std::int32_t>,
                       std::unique_ptr<Map>& map) const {
  if (!map) map = std::make_unique<DenseMap>();
  auto& dense = static_cast<DenseMap&>(*map);
  dense.reset(points.size(), q_.size());
  std::vector<Vec3> X(points.size());
  ask_inverse_deform(q_, points, X);
  ask_jacobian(q_, X, dense);
}

Vec3 OwnBody::material_at(int, const Vec3& x) const {
  Vec3 X;
  ask_inverse_deform(q_, {&x, 1}, {&X, 1});
  return X;
}

Vec3 OwnBody::position_of(int, const Vec3& X) const {
  Vec3 x;
  ask_deform(q_, {&X, 1}, {&x, 1});
  return x;
}

double OwnBody::potential_energy(const Environment& env) const {
  return ask_energy(q_) - env.gravity.dot(first_moment_);
}

Vec3 OwnBody::linear_momentum(std::span<const double> v) const { return linear_ * vector(v); }

Vec3 OwnBody::angular_momentum(std::span<const double> v) const { return angular_ * vector(v); }

bool OwnBody::rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const {
  // The coordinates' best try, by least squares over the matter: exact where such a motion is possible.
  writable(v) = M_.ldlt().solve(linear_.transpose() * t + angular_.transpose() * w);
  return true;
}

void OwnBody::display_positions(std::span<Vec3f> x) const {
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = vertex_[i].cast<float>();
}

}  // namespace brim
