#include "brim/body/grid_fluid/grid_fluid_body.h"

#include <cmath>

#include "brim/body/grid_fluid/face_map.h"
#include "brim/body/grid_fluid/fluid_surface.h"
#include "brim/core/error.h"
#include "brim/math/ramp.h"

namespace brim {

namespace {

using Kind = WetFaces::Kind;

/// Flow that may remain in a cell, over the largest before the projection.
constexpr double kPressureTolerance = 1e-9;
/// Farthest that the volume correction may move the surface in a step, [cells].
constexpr double kMostShift = 0.1;
/// Layers of faces beyond the surface to which the velocity is extended, besides what the motion of a step needs.
constexpr int kExtraLayers = 4;
/// Room for the surface that viewers show, over what it takes at the start.
constexpr std::size_t kDisplayRoom = 2;

void need(const char* what, double value, bool good) {
  if (!good) throw InputError(fmt::format("grid fluid: {} = {} is out of range", what, value));
}

}  // namespace

GridFluidBody::GridFluidBody(GridFluidModel model) : model_(std::move(model)), level_(model_.grid) {
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
  part_.shapeless = true;
  part_.thickness = bounds_.extent().minCoeff();
  part_.material = model_.material;
  // The number of triangles of a body is constant: room for a surface that breaks up, empty while it does not.
  make_surface();
  const std::size_t quads = kDisplayRoom * (surface_.size() / 4) + 1000;
  display_.vertices = 4 * quads;
  for (std::size_t i = 0; i < quads; ++i) {
    const auto first = static_cast<std::int32_t>(4 * i);
    display_.triangles.push_back({first, first + 1, first + 2});
    display_.triangles.push_back({first, first + 2, first + 3});
  }
}

void GridFluidBody::initial_state(std::span<double> q, std::span<double> v) const {
  const MacGrid& g = model_.grid;
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

void GridFluidBody::take_level_set(std::span<const double> phi) {
  if (phi_.size() == phi.size() && std::equal(phi.begin(), phi.end(), phi_.begin())) return;
  const MacGrid& g = model_.grid;
  phi_.assign(phi.begin(), phi.end());
  wet_.find(g, phi_, model_.open);
  mass_.resize(g.faces());
  for (std::size_t f = 0; f < mass_.size(); ++f) mass_[f] = face_mass(static_cast<int>(f));
  projection_.prepare(g, wet_, mass_);
  bounds_ = Aabb();
  for (int k = 0; k < g.n.z(); ++k)
    for (int j = 0; j < g.n.y(); ++j)
      for (int i = 0; i < g.n.x(); ++i)
        if (phi_[g.cell(i, j, k)] < 0.0) bounds_.extend(g.cell_center(i, j, k));
  // The surface may be a cell beyond the outermost wet centre.
  if (!bounds_.empty()) bounds_ = bounds_.inflated(g.dx).intersection(g.box());
}

void GridFluidBody::update(double, std::span<const double> q, std::span<const double> v) {
  take_level_set(q.first(model_.grid.cells()));
  v_.assign(v.begin(), v.end());
}

void GridFluidBody::advance(double dt, std::span<double> q, std::span<const double> v) const {
  const MacGrid& g = model_.grid;
  extended_.assign(v.begin(), v.end());
  double fastest = 0.0, leaving = 0.0;
  for (std::size_t f = 0; f < v.size(); ++f)
    if (wet_.kind[f] == Kind::Free) fastest = std::max(fastest, std::abs(v[f]));
  const double cells = std::min(std::ceil(fastest * dt / g.dx), 20.0);
  extend_velocity(g, wet_, model_.open, static_cast<int>(cells) + kExtraLayers, extended_, marks_);

  for (int a = 0; a < 3; ++a)
    for (const int side : {0, 1}) {
      if (!model_.open[2 * a + side]) continue;
      Vec3i first = Vec3i::Zero(), last = g.n - Vec3i::Ones();
      first[a] = last[a] = side == 0 ? 0 : g.n[a];
      for (int k = first.z(); k <= last.z(); ++k)
        for (int j = first.y(); j <= last.y(); ++j)
          for (int i = first.x(); i <= last.x(); ++i) {
            const int f = g.face(a, i, j, k);
            if (wet_.kind[f] == Kind::Free) leaving += (side == 0 ? -v[f] : v[f]) * g.dx * g.dx * dt;
          }
    }

  const auto phi = q.first(g.cells());
  level_.advect(phi, dt, (cells + 3.0) * g.dx, model_.open, [&](const Vec3& x) -> Vec3 {
    thread_local std::vector<FaceWeight> row;
    surface_row(g, wet_, phi_, slips(), x, row);
    Vec3 u = Vec3::Zero();
    for (const FaceWeight& e : row) u += v[e.face] * e.weight;
    return u;
  });
  level_.redistance(phi);
  q.back() = std::max(0.0, q.back() - std::max(0.0, leaving));
  level_.correct_volume(phi, q.back(), kMostShift * g.dx);
}

void GridFluidBody::finish_step(double, double dt, std::span<double> q, std::span<double> v) {
  const MacGrid& g = model_.grid;
  take_level_set(q.first(g.cells()));
  std::vector<double>& moved = scratch_;
  moved.resize(g.faces());
  std::vector<double> forth;
  advect_velocity(g, extended_, dt, moved, forth);
  for (std::size_t f = 0; f < moved.size(); ++f) moved[f] *= mass_[f];
  std::vector<double> pressure(g.cells(), 0.0);
  projection_.project(moved, kPressureTolerance * projection_.scale(moved), v, pressure);
}

void GridFluidBody::add_forces(const Environment& env, std::span<double> Q) const {
  for (std::size_t f = 0; f < Q.size(); ++f)
    if (wet_.kind[f] == Kind::Free) Q[f] += mass_[f] * env.gravity[static_cast<int>(f % 3)];
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
    for_places(count, [&](int i, int j, int k) {
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
  pressure_iterations_ = 0;
}

void GridFluidBody::precondition(std::size_t, const BlockDiagonal&, std::span<const double> r,
                                 std::span<double> z) const {
  // Starting from the last pressure, which hardly changes within a solve, only the correction is computed.
  pressure_iterations_ += solver_.project(r, kPressureTolerance * solver_.scale(r), z, impulse_);
}

void GridFluidBody::filter(std::span<double> x) const {
  for (std::size_t f = 0; f < x.size(); ++f)
    if (wet_.kind[f] != Kind::Free) x[f] = 0.0;
}

Vec3 GridFluidBody::carrier_velocity(int, std::span<const double> v) const {
  const Vec3 p = linear_momentum(v);
  Vec3 m = Vec3::Zero();
  for (std::size_t f = 0; f < v.size(); ++f) m[static_cast<int>(f % 3)] += mass_[f];
  return p.array() / m.array().max(1e-300);
}

double GridFluidBody::relative_speed_bound(int, std::span<const double> v) const {
  const Vec3 mean = carrier_velocity(0, v);
  Vec3 most = Vec3::Zero();
  for (std::size_t f = 0; f < v.size(); ++f) {
    const int a = static_cast<int>(f % 3);
    if (wet_.kind[f] != Kind::Dry) most[a] = std::max(most[a], std::abs(v[f] - mean[a]));
  }
  return most.norm();
}

double GridFluidBody::distance(const Vec3& x) const {
  const Aabb box = model_.grid.box();
  const double beyond = (box.lo - x).cwiseMax(x - box.hi).maxCoeff();
  return std::max(beyond, sample_cells(model_.grid, phi_, x));
}

void GridFluidBody::presence(int, double h, double w, const Aabb& region, std::vector<TileKey>& out) const {
  if (bounds_.empty()) return;
  const MacGrid& g = model_.grid;
  const Aabb where = region.intersection(bounds_.inflated(0.5 * w + h));
  if (where.empty()) return;
  const TileRange range = tiles_meeting(where.inflated(h), h);
  for (int z = range.lo.z; z <= range.hi.z; ++z)
    for (int y = range.lo.y; y <= range.hi.y; ++y)
      for (int x = range.lo.x; x <= range.hi.x; ++x) {
        // Every cell that a node of the block may be interpolated from.
        const Aabb block = tile_box({x, y, z}, h).inflated(h);
        const auto place = [&](double p, int a) {
          return std::clamp(static_cast<int>(std::floor((p - g.origin[a]) / g.dx - 0.5)), 0, g.n[a] - 1);
        };
        bool found = false;
        for (int k = place(block.lo.z(), 2); k <= std::min(place(block.hi.z(), 2) + 1, g.n.z() - 1) && !found; ++k)
          for (int j = place(block.lo.y(), 1); j <= std::min(place(block.hi.y(), 1) + 1, g.n.y() - 1) && !found; ++j)
            for (int i = place(block.lo.x(), 0); i <= std::min(place(block.hi.x(), 0) + 1, g.n.x() - 1) && !found; ++i)
              found = phi_[g.cell(i, j, k)] < 0.5 * w;
        if (found) out.push_back({x, y, z});
      }
}

void GridFluidBody::rasterize(int, double h, double w, std::span<const TileKey> tiles,
                              std::span<DensityBlock> out) const {
  parallel_for(tiles.size(), [&](std::size_t t) {
    const Vec3 origin = block_origin(tiles[t], h);
    std::fill(std::begin(out[t].source), std::end(out[t].source), 0);
    double* rho = out[t].rho;
    for (int k = 0; k < kBlockSize; ++k)
      for (int j = 0; j < kBlockSize; ++j)
        for (int i = 0; i < kBlockSize; ++i) *rho++ = ramp(distance(origin + h * Vec3(i, j, k)), w);
  });
}

void GridFluidBody::make_map(int, std::span<const Vec3> points, std::span<const std::int32_t>,
                             std::unique_ptr<Map>& map) const {
  if (!map) map = std::make_unique<FaceMap>();
  static_cast<FaceMap&>(*map).reset(model_.grid, wet_, phi_, slips(), points);
}

double GridFluidBody::volume() const {
  double area = 0.0;
  return level_.volume(phi_, 0.0, area);
}

double GridFluidBody::divergence(std::span<const double> v) const {
  const double dx = model_.grid.dx;
  return projection_.divergence(v) / (dx * dx * dx);
}

double GridFluidBody::potential_energy(const Environment& env) const {
  const MacGrid& g = model_.grid;
  const double sum = ordered_sum(
      g.n.z(),
      [&](std::size_t plane, std::size_t) {
        double s = 0.0;
        const int k = static_cast<int>(plane);
        for (int j = 0; j < g.n.y(); ++j)
          for (int i = 0; i < g.n.x(); ++i)
            s += level_.fraction(phi_, i, j, k) * env.gravity.dot(g.cell_center(i, j, k));
        return s;
      },
      1);
  return -cell_mass_ * sum;
}

Vec3 GridFluidBody::linear_momentum(std::span<const double> v) const {
  Vec3 p = Vec3::Zero();
  for (std::size_t f = 0; f < v.size(); ++f) p[static_cast<int>(f % 3)] += mass_[f] * v[f];
  return p;
}

Vec3 GridFluidBody::angular_momentum(std::span<const double> v) const {
  const MacGrid& g = model_.grid;
  Vec3 sum = Vec3::Zero();
  for (int a = 0; a < 3; ++a) {
    const Vec3i count = g.face_count(a);
    for (int k = 0; k < count.z(); ++k)
      for (int j = 0; j < count.y(); ++j)
        for (int i = 0; i < count.x(); ++i) {
          const int f = g.face(a, i, j, k);
          if (mass_[f] > 0.0) sum += g.face_position(a, i, j, k).cross(mass_[f] * v[f] * Vec3::Unit(a));
        }
  }
  return sum;
}

bool GridFluidBody::rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const {
  const MacGrid& g = model_.grid;
  std::fill(v.begin(), v.end(), 0.0);
  for (int a = 0; a < 3; ++a)
    for_places(g.face_count(a),
               [&](int i, int j, int k) { v[g.face(a, i, j, k)] = (t + w.cross(g.face_position(a, i, j, k)))[a]; });
  return true;
}

void GridFluidBody::make_surface() const {
  fluid_surface(
      model_.grid, [&](const Vec3& x) { return distance(x); }, surface_);
}

void GridFluidBody::display_positions(std::span<Vec3f> x) const {
  make_surface();
  const std::size_t n = std::min(surface_.size(), x.size());
  std::copy(surface_.begin(), surface_.begin() + static_cast<std::ptrdiff_t>(n), x.begin());
  // What is left of the room collapses to the middle, where nobody sees it and the mean stays what it was.
  Vec3f middle = Vec3f::Zero();
  for (std::size_t i = 0; i < n; ++i) middle += x[i] / static_cast<float>(n);
  std::fill(x.begin() + static_cast<std::ptrdiff_t>(n), x.end(), middle);
}

}  // namespace brim
