#include "brim/body/grid_fluid/grid_fluid_body.h"

#include <cmath>
#include <utility>

#include "brim/core/error.h"

namespace brim {

namespace {

using Kind = WetFaces::Kind;

/// Flow that may remain in a cell, over the largest before the projection.
constexpr double kPressureTolerance = 1e-11;
/// Farthest that the volume correction may move the surface in a step, [cells].
constexpr double kMostShift = 0.1;
/// Layers of faces beyond the surface to which the velocity is extended, besides what the motion of a step needs.
constexpr int kExtraLayers = 4;

void need(const char* what, double value, bool good) {
  if (!good) throw InputError(fmt::format("grid fluid: {} = {} is out of range", what, value));
}

}  // namespace

GridFluidBody::GridFluidBody(GridFluidModel model)
    : model_(std::move(model)), start_origin_(model_.grid.origin), level_(model_.grid) {
  const MacGrid& g = model_.grid;
  need("cell size [m]", g.dx, g.dx > 0.0 && std::isfinite(g.dx));
  for (int a = 0; a < 3; ++a) need("number of cells along an axis", g.n[a], g.n[a] >= 1 && g.n[a] <= 4096);
  need("density [kg/m³]", model_.density, model_.density > 0.0 && std::isfinite(model_.density));
  need("viscosity [Pa s]", model_.viscosity, model_.viscosity >= 0.0 && std::isfinite(model_.viscosity));
  need("voxel size [m]", model_.voxel_size, model_.voxel_size >= 0.0 && std::isfinite(model_.voxel_size));
  if (!model_.distance) throw InputError("grid fluid: no fluid is given at the start");
  cell_mass_ = model_.density * g.dx * g.dx * g.dx;

  std::vector<double> q(q_size()), v(v_size());
  start_volume_ = -1.0;
  initial_state(q, v);
  start_volume_ = q.back();
  if (!(start_volume_ > 0.0)) throw InputError("grid fluid: there is no fluid inside the box at the start");
  update(0.0, q, v);

  part_.voxel_size = model_.voxel_size > 0.0 ? model_.voxel_size : g.dx;
  part_.areal_mass = model_.density * bounds_.extent().minCoeff();
  part_.modulus = 0.0;  // contact as soft as the loads allow: it presses matter that yields
  part_.conforming = true;
  part_.thickness = bounds_.extent().minCoeff();
  part_.material = model_.material;
}

void GridFluidBody::initial_state(std::span<double> q, std::span<double> v) const {
  MacGrid g = model_.grid;
  g.origin = start_origin_;
  const auto phi = q.first(g.cells());
  for_places(g.n, [&](int i, int j, int k) { phi[g.cell(i, j, k)] = model_.distance(g.cell_center(i, j, k)); });
  for (const double p : phi)
    if (!std::isfinite(p)) throw InputError("grid fluid: the distance to the fluid at the start is not finite");
  level_.redistance(phi);
  double area = 0.0;
  q.back() = level_.volume(phi, 0.0, area);
  std::fill(v.begin(), v.end(), 0.0);
  if (!model_.velocity) return;
  WetFaces wet;
  wet.find(g, phi, model_.open);
  for (int a = 0; a < 3; ++a)
    for_places(g.face_count(a), [&](int i, int j, int k) {
      const int f = g.face(a, i, j, k);
      if (wet.kind[f] == Kind::Free) v[f] = model_.velocity(g.face_position(a, i, j, k))[a];
    });
}

void GridFluidBody::set_base(const Pose& from_start) {
  model_.grid.origin = start_origin_ + from_start.translation;
  level_.set_origin(model_.grid.origin);
  taken_.clear();  // what was found for the last place is found again
}

void GridFluidBody::take_level_set(std::span<const double> q) {
  const auto phi = q.first(model_.grid.cells());
  if (taken_.size() == phi.size() && volume_ == q.back() && std::equal(phi.begin(), phi.end(), taken_.begin())) return;
  taken_.assign(phi.begin(), phi.end());
  solids_taken_ = false;
  phi_ = taken_;
  volume_ = q.back();
  if (among_solids())
    extend_into_solids(), hide_in_solids();  // where they were: how they move since is told by set_solids
  find_wet();
}

void GridFluidBody::find_wet() {
  const MacGrid& g = model_.grid;
  wet_.find(g, phi_, model_.open, left_of_face_);
  weigh_faces();
  projection_.prepare(g, wet_, mass_);
  bounds_ = Aabb();
  for (int k = 0; k < g.n.z(); ++k)
    for (int j = 0; j < g.n.y(); ++j)
      for (int i = 0; i < g.n.x(); ++i)
        if (phi_[g.cell(i, j, k)] < 0.0) bounds_.extend(g.cell_center(i, j, k));
  // The surface may be a cell beyond the outermost wet centre.
  if (!bounds_.empty()) bounds_ = bounds_.inflated(g.dx).intersection(g.box());
}

void GridFluidBody::weigh_faces() {
  Vec3 shares = Vec3::Zero();
  for (std::size_t f = 0; f < wet_.share.size(); ++f) shares[static_cast<int>(f % 3)] += wet_.share[f];
  const double cells = volume_ * model_.density / cell_mass_;
  Vec3 mass;
  for (int a = 0; a < 3; ++a) mass[a] = shares[a] > 0.0 ? cell_mass_ * cells / shares[a] : 0.0;
  mass_.resize(wet_.share.size());
  for (std::size_t f = 0; f < mass_.size(); ++f) mass_[f] = mass[static_cast<int>(f % 3)] * wet_.share[f];
}

void GridFluidBody::update(double, std::span<const double> q, std::span<const double> v) {
  take_level_set(q);
  v_.assign(v.begin(), v.end());
}

double GridFluidBody::leaving(double dt, std::span<const double> phi, std::span<const double> v) const {
  const MacGrid& g = model_.grid;
  double sum = 0.0;
  for (int a = 0; a < 3; ++a)
    for (const int side : {0, 1}) {
      if (!model_.open[2 * a + side]) continue;
      Vec3i first = Vec3i::Zero(), last = g.n - Vec3i::Ones();
      first[a] = last[a] = side == 0 ? 0 : g.n[a];
      for (int k = first.z(); k <= last.z(); ++k)
        for (int j = first.y(); j <= last.y(); ++j)
          for (int i = first.x(); i <= last.x(); ++i) {
            const int f = g.face(a, i, j, k);
            if (wet_.kind[f] != Kind::Free) continue;
            // As much of the face as its cell is full.
            const Vec3i cell = Vec3i(i, j, k) - side * Vec3i::Unit(a);
            sum += (side == 0 ? -v[f] : v[f]) * level_.fraction(phi, cell.x(), cell.y(), cell.z());
          }
    }
  return std::max(0.0, sum * g.dx * g.dx * dt);
}

void GridFluidBody::advance(double dt, std::span<double> q, std::span<const double> v) const {
  const MacGrid& g = model_.grid;
  extended_.assign(v.begin(), v.end());
  double fastest = 0.0;
  for (std::size_t f = 0; f < v.size(); ++f)
    if (wet_.kind[f] == Kind::Free) fastest = std::max(fastest, std::abs(v[f]));
  const double cells = std::min(std::ceil(fastest * dt / g.dx), 20.0);
  extend_velocity(g, wet_, model_.open, static_cast<int>(cells) + kExtraLayers, extended_, marks_);

  const auto phi = q.first(g.cells());
  if (among_solids()) std::copy(phi_.begin(), phi_.end(), phi.begin());
  const double left = q.back() - leaving(dt, phi, v);
  surface_.find(g, wet_, phi_);
  level_.advect(phi, dt, (cells + 3.0) * g.dx, model_.open, [&](int cell, const Vec3& x) -> Vec3 {
    thread_local std::vector<FaceWeight> row;
    const auto at = [&](SurfaceMotion motion, const Vec3& y) {
      return surface_velocity(g, wet_, surface_, phi_, motion, v, y, row);
    };
    if (touched_.has(cell)) return at(touched_motion(cell), x);
    // Along its own normal alone, or without the midpoint, a curved surface would sweep more than its matter does.
    return at(SurfaceMotion::Follows, x - 0.5 * dt * at(SurfaceMotion::Follows, x));
  });
  level_.redistance(phi);
  q.back() = std::max(0.0, left);
  level_.correct_volume(phi, q.back(), kMostShift * g.dx, left_);
}

void GridFluidBody::finish_step(double, double dt, std::span<double> q, std::span<double> v) {
  const MacGrid& g = model_.grid;
  keeper_.note(wet_, mass_, v);
  wall_impulse_ = solver_.wall_impulse(impulse_) - std::exchange(held_, Vec3::Zero());
  take_level_set(q);
  std::vector<double>& moved = scratch_;
  moved.resize(g.faces());
  advect_velocity(g, extended_, mass_, dt, moved);
  const bool closed = std::none_of(model_.open.begin(), model_.open.end(), [](bool open) { return open; });
  wall_impulse_ -= keeper_.restore(g, wet_, mass_, closed, moved);
  if (among_solids()) {
    // What flows out of cells is mended with the solids as the next step begins (FluidCoupling).
    std::copy(moved.begin(), moved.end(), v.begin());
    return;
  }
  for (std::size_t f = 0; f < moved.size(); ++f) moved[f] *= mass_[f];
  std::vector<double> pressure(g.cells(), 0.0);
  projection_.project(moved, kPressureTolerance, v, pressure);
  wall_impulse_ += projection_.wall_impulse(pressure);
}

void GridFluidBody::add_forces(const Environment& env, std::span<double> Q) const {
  for (std::size_t f = 0; f < Q.size(); ++f) Q[f] += mass_[f] * env.gravity[static_cast<int>(f % 3)];
  apply_damping(v_, Q);
}

void GridFluidBody::apply_mass(std::span<const double> x, std::span<double> y) const {
  for (std::size_t f = 0; f < x.size(); ++f) y[f] += (mass_[f] > 0.0 ? mass_[f] : cell_mass_) * x[f];
}

void GridFluidBody::apply_damping(std::span<const double> x, std::span<double> y) const {
  if (model_.viscosity == 0.0) return;
  const MacGrid& g = model_.grid;
  const double mu = model_.viscosity * g.dx;
  for (int a = 0; a < 3; ++a) {
    const Vec3i count = g.face_count(a);
    for_places(count, wet_.layers, [&](int i, int j, int k) {
      const int f = g.face(a, i, j, k);
      if (wet_.kind[f] == Kind::Dry) return;
      const std::array<int, 3> at = {i, j, k};
      double sum = 0.0;
      for (int b = 0; b < 3; ++b)
        for (const int side : {-1, 1}) {
          if (at[b] + side < 0 || at[b] + side >= count[b]) continue;
          const int other = f + side * g.face_stride(b);
          if (wet_.kind[other] != Kind::Dry) sum += x[other] - x[f];
        }
      y[f] += mu * sum;
    });
  }
}

void GridFluidBody::apply_system(std::span<const double> x, std::span<double> y) const {
  std::size_t f = 0;
  for (std::size_t h = 0; h <= wet_.held.size(); ++h) {
    const std::size_t end = h < wet_.held.size() ? wet_.held[h].begin : x.size();
    for (; f < end; ++f) y[f] += mass_[f] * x[f];
    if (h < wet_.held.size()) f = wet_.held[h].end;
  }
  if (model_.viscosity == 0.0) return;
  std::vector<double>& slowed = scratch_;
  slowed.assign(x.size(), 0.0);
  apply_damping(x, slowed);
  for (std::size_t i = 0; i < slowed.size(); ++i) y[i] -= dt_ * slowed[i];
}

void GridFluidBody::add_system_diagonal(std::size_t first, BlockDiagonal& D) const {
  const MacGrid& g = model_.grid;
  const double viscous = 6.0 * dt_ * model_.viscosity * g.dx;
  parallel_for(
      g.faces() / 3,
      [&](std::size_t p) {
        auto block = D.block(first + p);
        for (int a = 0; a < 3; ++a) {
          const double m = mass_[3 * p + a];
          block(a, a) += m > 0.0 ? m + viscous : cell_mass_;
        }
      },
      4096);
}

void GridFluidBody::prepare_preconditioner(std::size_t first, const BlockDiagonal& D) {
  scratch_.resize(v_size());
  for (std::size_t f = 0; f < scratch_.size(); ++f) {
    const auto a = static_cast<Eigen::Index>(f % 3);
    scratch_[f] = D.block(first + f / 3)(a, a);
  }
  solver_.prepare(model_.grid, wet_, scratch_);
  impulse_.assign(model_.grid.cells(), 0.0);
}

void GridFluidBody::precondition(std::size_t, const BlockDiagonal&, std::span<const double> r,
                                 std::span<double> z) const {
  if (among_solids()) {  // the pressure is that of all (FluidCoupling)
    solver_.divide_by_mass(r, z);
    return;
  }
  // Starting from the last pressure, which hardly changes within a solve, only the correction is computed.
  solver_.project(r, kPressureTolerance, z, impulse_);
}

void GridFluidBody::note_impulse(std::span<const double> impulse) {
  held_.setZero();
  for (std::size_t f = 0; f < impulse.size(); ++f)
    if (wet_.kind[f] == Kind::Wall) held_[static_cast<int>(f % 3)] += impulse[f];
}

void GridFluidBody::filter(std::span<double> x) const {
  for (const auto& [begin, end] : wet_.held) std::fill(x.begin() + begin, x.begin() + end, 0.0);
}

}  // namespace brim
