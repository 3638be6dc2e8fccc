// How solids as wholes give way to pressure: the part of S that the fluids' own inverse does not know.
#include <algorithm>
#include <cmath>

#include "brim/core/profile.h"
#include "brim/world/fluid_coupling.h"
#include "brim/world/wind.h"

namespace brim {

namespace {

/// Solids at most, those with most faces: the columns are dense.
constexpr std::size_t kMostSolids = 16;
/// Added mass of a motion relative to its own, from which on a column saves iterations.
constexpr double kLeastYield = 0.1;

/// Solids, links of trees among them.
bool moves_as_whole(const Body& body) { return !body.immobile() && !has_nodes(body); }

double dot_of(std::span<const std::int32_t> cells, std::span<const double> a, std::span<const double> b) {
  double s = 0.0;
  for (const std::int32_t c : cells) s += a[c] * b[c];
  return s;
}

}  // namespace

std::vector<int> FluidCoupling::yielding_solids() const {
  std::map<int, std::size_t> faces;
  for (const Fluid& f : fluids_)
    for (const Side& s : f.sides)
      if (moves_as_whole(*body_[s.body])) faces[s.body] += s.rows.size();
  std::vector<int> solids;
  for (const auto& [body, n] : faces) solids.push_back(body);
  std::ranges::stable_sort(solids, [&](int a, int b) { return faces[a] > faces[b]; });
  solids.resize(std::min(solids.size(), kMostSolids));
  return solids;
}

double FluidCoupling::find_column(int body, Eigen::Index column) {
  double added = 0.0;
  for (Fluid& f : fluids_) {
    const auto wet = f.flow->wet_cells();
    for (const std::int32_t c : wet) f.p[c] = 0.0;
    for (Side& s : f.sides)
      if (s.body == body) add_solid_flow(s, impulse_, f.p);
    f.flow->invert_poisson(f.p, f.z);
    for (std::size_t i = 0; i < wet.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      f.flows(row, column) = static_cast<float>(f.p[wet[i]]), f.yield(row, column) = static_cast<float>(f.z[wet[i]]);
    }
    added += dot_of(wet, f.p, f.z);
  }
  return added;
}

void FluidCoupling::find_yield() {
  const ProfileScope scope("yield of solids in fluids");
  yield_known_ = true;
  const std::vector<int> solids = yielding_solids();
  const auto most = static_cast<Eigen::Index>(6 * solids.size());
  for (Fluid& f : fluids_) {
    const auto wet = static_cast<Eigen::Index>(f.flow->wet_cells().size());
    f.flows.resize(wet, most), f.yield.resize(wet, most);
  }
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(most, most);  // C⁻¹
  Eigen::Index columns = 0;
  impulse_.assign(first_.back(), 0.0);
  for (const int body : solids) {
    const auto motion = slice(std::span<double>(impulse_), body);
    Eigen::Map<const Eigen::VectorXd> u(motion.data(), static_cast<Eigen::Index>(motion.size()));
    Eigen::MatrixXd moved(u.size(), 6);  // A u
    const Eigen::Index first = columns;
    for (int m = 0; m < 6; ++m) {
      const Vec3 unit = Vec3::Unit(m % 3);
      std::ranges::fill(motion, 0.0);
      if (!body_[body]->rigid_motion(m < 3 ? unit : Vec3::Zero(), m < 3 ? Vec3::Zero() : unit, motion)) break;
      body_[body]->filter(motion);
      auto image = moved.col(columns - first);
      image.setZero();
      body_[body]->apply_system(motion, {image.data(), motion.size()});
      if (!(u.dot(image) > 0.0) || !(find_column(body, columns) > kLeastYield * u.dot(image))) continue;
      for (Eigen::Index c = first; c <= columns; ++c) own(c, columns) = own(columns, c) = u.dot(moved.col(c - first));
      ++columns;
    }
    std::ranges::fill(motion, 0.0);
  }
  Eigen::MatrixXd E = own.topLeftCorner(columns, columns);
  for (Fluid& f : fluids_) {
    f.yield.conservativeResize(Eigen::NoChange, columns);
    E += (f.flows.leftCols(columns).transpose() * f.yield).cast<double>();
  }
  yield_.compute(0.5 * (E + E.transpose()));
  if (yield_.info() == Eigen::Success) return;
  yield_.compute(Eigen::MatrixXd(0, 0));
  for (Fluid& f : fluids_) f.yield.resize(f.yield.rows(), 0);
}

void FluidCoupling::invert_flows() {
  if (!yield_known_) find_yield();
  const Eigen::Index columns = yield_.cols();
  Eigen::VectorXd held = Eigen::VectorXd::Zero(columns);
  for (Fluid& f : fluids_) {
    f.flow->invert_poisson(f.r, f.z);
    if (columns == 0) continue;
    const auto wet = f.flow->wet_cells();
    f.at_wet.resize(static_cast<Eigen::Index>(wet.size()));
    for (std::size_t i = 0; i < wet.size(); ++i)
      f.at_wet[static_cast<Eigen::Index>(i)] = static_cast<float>(f.r[wet[i]]);
    held += (f.yield.transpose() * f.at_wet).cast<double>();
  }
  if (columns == 0) return;
  const Eigen::VectorXf gives = yield_.solve(held).cast<float>();
  for (Fluid& f : fluids_) {
    const auto wet = f.flow->wet_cells();
    f.at_wet.noalias() = f.yield * gives;
    for (std::size_t i = 0; i < wet.size(); ++i) f.z[wet[i]] -= double{f.at_wet[static_cast<Eigen::Index>(i)]};
  }
}

}  // namespace brim
