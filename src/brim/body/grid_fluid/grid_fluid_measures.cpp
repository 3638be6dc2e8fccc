#include "brim/body/grid_fluid/fluid_surface.h"
#include "brim/body/grid_fluid/grid_fluid_body.h"

/// What is measured and shown of a grid fluid.
namespace brim {

namespace {
/// [cells] from a side of the box within which the surface lies on it.
constexpr double kOnSide = 0.25;
}  // namespace

double GridFluidBody::volume() const {
  double area = 0.0;
  return level_.volume(phi_, 0.0, area, left_);
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
          for (int i = 0; i < g.n.x(); ++i) {
            const double left = left_.empty() ? 1.0 : left_[g.cell(i, j, k)];
            if (left == 0.0) continue;
            const double share = level_.fraction(taken_, i, j, k);
            s += left * env.gravity.dot(share * g.cell_center(i, j, k) + level_.moment(taken_, i, j, k));
            if (left < 1.0) s += share * env.gravity.dot(left_moment_[g.cell(i, j, k)]);
          }
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

void GridFluidBody::velocity_places(std::span<Vec3> x) const {
  const MacGrid& g = model_.grid;
  for (int a = 0; a < 3; ++a)
    for_places(g.n + Vec3i::Ones(), [&](int i, int j, int k) { x[g.face(a, i, j, k)] = g.face_position(a, i, j, k); });
}

void GridFluidBody::display_surface(std::vector<Vec3f>& x, std::vector<Triangle>& triangles) const {
  std::vector<double> shown = phi_;
  // Without what solids take: where half of a cell is left, about, their surface is.
  for (std::size_t c = 0; c < left_.size(); ++c) shown[c] = std::max(shown[c], (0.5 - left_[c]) * model_.grid.dx);
  fluid_surface(model_.grid, shown, x, triangles);
}

bool GridFluidBody::meets_air(const Vec3& x) const {
  const Aabb box = model_.grid.box();
  return (x - box.lo).cwiseMin(box.hi - x).minCoeff() > kOnSide * model_.grid.dx;
}

}  // namespace brim
